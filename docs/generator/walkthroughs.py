"""Pages that are followed step by step: their commands run in order, in one folder, and show what they print.

A fenced block with a title is a file: ```` ```scene title="mill.scene" ````. A `console` block holds commands after
``$`` and their output. An image from the page's own folder is a file that the commands write. ``make docs`` runs the
pages and writes outputs and images; a test fails where they differ.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
PAGES = ("ten-minutes.md", *sorted(f"tutorials/{path.name}" for path in (DOCS / "tutorials").glob("*.md")))

_BLOCK = re.compile(
    r'^(?P<fence>`{3,})(?P<language>\w+)(?: title="(?P<title>[^"]+)")?\n(?P<body>.*?)^(?P=fence)$', re.M | re.S
)
_IMAGE = re.compile(r"!\[[^\]]*\]\((?P<path>[^)\s]+)\)")


@dataclass(frozen=True, slots=True)
class Walkthrough:
    """A page with the output that its commands print now, and the images that they write, by their path in docs."""

    text: str
    images: dict[str, bytes]


Command = Callable[[list[str], Path], "subprocess.CompletedProcess[str]"]


def process(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run `scenelang` with ``words`` in a process of its own."""
    command = [sys.executable, "-P", "-m", "scenelang", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)


def follow(page: str, command: Command = process) -> Walkthrough:
    """Run the blocks of ``page``, a path in docs; ``command`` runs `scenelang`.

    Raises RuntimeError for a command that fails without saying so: one that should fail ends with ``# fails``.
    """
    text = (DOCS / page).read_text("utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "examples").symlink_to(ROOT / "examples")
        shown = _BLOCK.sub(lambda block: _run(block, folder, command), text)
        return Walkthrough(shown, dict(_images(page, text, folder)))


def _run(block: re.Match[str], folder: Path, command: Command) -> str:
    if block["title"]:
        (folder / block["title"]).write_text(block["body"], "utf-8")
    if block["language"] != "console":
        return block[0]
    commands = [line for line in block["body"].splitlines() if line.startswith("$ ")]
    body = "".join(f"{line}\n{output(line[2:], folder, command)}" for line in commands)
    return f"```console\n{body}```"


def output(line: str, folder: Path, command: Command = process) -> str:
    """Return what a command prints on a terminal: standard output, then standard error."""
    program, *words = shlex.split(line, comments=True)
    if program == "scenelang":
        done = command(words, folder)
    elif program == "python":
        done = subprocess.run([sys.executable, *words], cwd=folder, capture_output=True, text=True, timeout=120)
    else:
        raise RuntimeError(f"`{program}` is not run here")
    if bool(done.returncode) != line.endswith("# fails"):
        raise RuntimeError(f"`{line}` ended with {done.returncode}\n{done.stdout}{done.stderr}")
    said = done.stdout + done.stderr
    return said if not said or said.endswith("\n") else f"{said}\n"


def _images(page: str, text: str, folder: Path) -> list[tuple[str, bytes]]:
    """The images of the page's own folder, ``tutorials/animation/swing.gif`` for the file ``swing.gif``."""
    found = []
    for image in _IMAGE.finditer(text):
        path = Path(page).parent / image["path"]
        if path.parent == Path(page).with_suffix(""):
            found.append((str(path), (folder / path.name).read_bytes()))
    return found


def write() -> None:
    """Write the outputs and images of all pages."""
    for page in PAGES:
        found = follow(page)
        (DOCS / page).write_text(found.text, "utf-8")
        for path, data in found.images.items():
            (DOCS / path).parent.mkdir(exist_ok=True)
            (DOCS / path).write_bytes(data)


if __name__ == "__main__":
    write()
