"""Every command under every condition of its surroundings: encodings without letters, full disks, folders that may only
be read, signals, pipes that nobody reads, links, odd names; and every option that takes a number, at the edges of it.

Twenty cells of each, drawn by the date, every time; all of them nightly: ``make test-nightly``.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Any

import copies
import pytest
from hostile.every_command import LINES, numeric_options, prepare
from hostile.measuring import children
from hostile.test_faults import heed, limit_files, read_only
from support import wait_until

from scenelang.cli.main import COMMANDS
from scenelang.sandbox.supervision import is_supported

pytestmark = pytest.mark.skipif(not is_supported(), reason="needs Linux")

WRONG = (b"Traceback", b"internal error", b"Exception ignored", b"--- Logging error")
CODES = {0, 1, 2, 130, 141, 143, -signal.SIGTERM}  # -15: SIGTERM ends a process that has not started its work
NO_SUCH_RIGHT = 99
DRAWN = 20
LATE = 120.0


@dataclass(frozen=True)
class Condition:
    """Surroundings of a command: variables and options of Python, what runs in the child before it, where its output
    goes, what happens to it while it runs, how its files are named, and whether its outputs are links."""

    variables: dict[str, str] = field(default_factory=dict)
    python: tuple[str, ...] = ()
    before: Callable[[Path], Callable[[], None]] | None = None
    output: Callable[[], int] | None = None
    during: Callable[[subprocess.Popen[bytes]], None] | None = None
    rename: str | None = None
    links: bool = False


def encoded(name: str) -> Condition:
    return Condition({"PYTHONIOENCODING": name, "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"})


def closed() -> int:
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def sent(number: int, wait: Callable[[subprocess.Popen[bytes]], Any], *python: str) -> Condition:
    def send(running: subprocess.Popen[bytes]) -> None:
        wait(running)
        running.send_signal(number)

    return Condition(python=python, before=lambda _: heed, during=send)


def importing(running: subprocess.Popen[bytes]) -> None:
    """Wait until the process loads the first module of the command line: before, Python itself answers signals."""
    said = Path(f"/proc/{running.pid}/fd/2")
    wait_until(lambda: running.poll() is not None or b"scenelang.cli" in said.read_bytes())


def working(running: subprocess.Popen[bytes]) -> None:
    """Wait until the process has a child, where evaluation takes place, or has ended, or is one that has no child."""
    end = time.monotonic() + 1.0
    while running.poll() is None and not children(running.pid) and time.monotonic() < end:
        time.sleep(0.01)


CONDITIONS = {
    "latin-1": encoded("latin-1"), "ascii": encoded("ascii"), "cp1252": encoded("cp1252"),
    "no encoding": Condition({"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}),
    "full output": Condition(output=lambda: os.open("/dev/full", os.O_WRONLY)),
    "full disk": Condition({"PYTHONDONTWRITEBYTECODE": "1"}, before=lambda _: limit_files),
    "read only": Condition(before=lambda folder: lambda: read_only(folder)),
    "closed pipe": Condition(output=closed),
    "SIGTERM in imports": sent(signal.SIGTERM, importing, "-X", "importtime"), "SIGINT in imports": sent(signal.SIGINT, importing, "-X", "importtime"),
    "SIGTERM at work": sent(signal.SIGTERM, working), "SIGINT at work": sent(signal.SIGINT, working),
    "links": Condition(links=True),
    "name with spaces": Condition(rename=" a  b "), "name of a dash": Condition(rename="-a"),
    "name in Chinese": Condition(rename="木"), "name of a newline": Condition(rename="a\nb"),
    "name of bytes": Condition(rename="a\udcff"), "name of a quote": Condition(rename="a'\"%s{}$(b)"),
}  # fmt: skip
SLOW = {"doctor"}  # measures the installation for ten seconds
PRINTING = {
    "fmt", "explain", "expand", "transpile", "simplify", "import", "tree", "count", "bounds", "measure", "flatten",
    "backends", "bench", "embed", "search", "grammar", "completion",
}  # fmt: skip


def lines_in(folder: Path, command: str, condition: Condition) -> list[str]:
    """Return the words of a command whose files exist in ``folder``, named and linked as the condition says."""
    prepare(folder)
    words = list(LINES[command])
    if condition.rename is not None:
        for i, word in enumerate(words):
            name = Path(word)
            if name.stem in ("a", "b", "out") and (name.suffix or word == "out"):
                words[i] = "./" + condition.rename + name.name
                if (folder / word).exists():
                    (folder / word).rename(folder / words[i])
    if condition.links:
        for word in words:
            if Path(word).stem == "out" and Path(word).suffix:
                (folder / "target").mkdir(exist_ok=True)
                (folder / "target" / word).write_bytes(b"old")
                (folder / word).symlink_to(folder / "target" / word)
    return words


def ended(command: str, words: list[str], folder: Path, condition: Condition) -> tuple[int, bytes]:
    """Run a command under a condition; return its exit status and all that it said."""
    with tempfile.TemporaryFile() as said:
        output = said.fileno() if condition.output is None else condition.output()
        running = subprocess.Popen(
            [sys.executable, "-P", *condition.python, "-m", "scenelang", command, *words],
            cwd=folder, env={**os.environ, **condition.variables}, stdin=subprocess.DEVNULL, stdout=output,
            stderr=said, preexec_fn=None if condition.before is None else condition.before(folder),
        )  # fmt: skip
        try:
            if condition.during is not None:
                condition.during(running)
            running.wait(LATE)
        finally:
            running.kill()
            if condition.output is not None:
                os.close(output)
        said.seek(0)
        return running.returncode, said.read()


def drawn(cells: list[Any]) -> list[Any]:
    """Return the cells as parameters, of which those that the date draws run every time."""
    today = set(random.Random(date.today().toordinal()).sample(range(len(cells)), DRAWN))
    return [
        pytest.param(*cell, id="-".join(cell), marks=() if i in today else pytest.mark.slow)
        for i, cell in enumerate(cells)
    ]


def test_every_command_has_a_line() -> None:
    assert set(LINES) == set(COMMANDS)


CELLS = [(command, name) for command in LINES if command not in SLOW for name in CONDITIONS]


@pytest.mark.parametrize(("command", "name"), drawn(CELLS))
def test_a_command_in_odd_surroundings(command: str, name: str, tmp_path: Path) -> None:
    condition = CONDITIONS[name]
    code, said = ended(command, lines_in(tmp_path, command, condition), tmp_path, condition)
    if code == NO_SUCH_RIGHT:
        pytest.skip("this process may not make folders read-only")
    assert not [word for word in WRONG if word in said], said.decode(errors="replace")
    assert code in CODES, (code, said)
    if condition.output is not None and command in PRINTING:
        assert code == (1 if name == "full output" else 141), said
    for target in (tmp_path / "target").glob("*"):
        assert (tmp_path / target.name).is_symlink()
        assert code or target.read_bytes() != b"old"


# The edges of what an option may mean: none, negative, more than any machine holds, no number at all.
EDGES = (
    "0",
    "-1",
    "1",
    ".5",
    "1e-300",
    "1e11",
    "1e308",
    "nan",
    "inf",
    "999999999",
    "99999999999999999999",
    "9" * 5000,
    "9x9",
    "",
)
NUMBERS = [(command, option, str(i)) for command, option in numeric_options() for i in range(len(EDGES))]
GUARDS = ("--max-steps", "2M", "--max-memory", "1G", "--max-seconds", "20")


@pytest.mark.parametrize(("command", "option", "edge"), drawn(NUMBERS))
def test_a_number_at_its_edge(command: str, option: str, edge: str, tmp_path: Path) -> None:
    """A number ends in a result, a refusal, or at a limit: never in an internal error, and never late."""
    prepare(tmp_path)
    words = [*LINES[command], *_beside(command, option), option + "=" + EDGES[int(edge)]]
    done = copies.command(command, *words, folder=tmp_path, timeout=LATE)
    said = (done.stdout + done.stderr).encode()
    assert not [word for word in WRONG if word in said], said.decode(errors="replace")
    assert done.returncode in (0, 1, 2), said


def _beside(command: str, option: str) -> tuple[str, ...]:
    """Return what an option of a video needs: an output that is one."""
    if command == "render" and option in ("--frames", "--fps", "--orbit"):
        return ("-o", "out.gif", *(() if option == "--frames" else ("--frames", "2")))
    return ()
