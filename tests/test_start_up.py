"""What a command imports before it works, and how many instructions that takes beside a bare Python."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from scenelang.grammar import datum
from scenelang.grammar.datum import Source
from scenelang.interpreter.checker.program import prelude_of
from scenelang.interpreter.loading import entry_points_of
from scenelang.stdlib.library import build_library

ROOT = Path(__file__).parents[1]
FIGURE = str(ROOT / "examples" / "paper" / "chessboard.scene")
# Each costs a hundredth of the start-up or more, and the check of a small program needs none of them.
NEEDLESS = [
    "numpy",
    "ctypes",
    "dataclasses",
    "difflib",
    "inspect",
    "ipaddress",
    "json",
    "locale",
    "pathlib",
    "scenelang.backends.base",
    "scenelang.files.zfile",
    "scenelang.interpreter.scene.modelling.contours",
    "scenelang.stdlib.python",
    "scenelang.stdlib.random",
    "shutil",
    "urllib.parse",
]


def _environment() -> dict[str, str]:
    """The package on the path without ``site``, whose installed hooks differ from one environment to the next."""
    package = Path(datum.__file__).parents[1]  # installed; in a checkout that is linked, the checkout itself
    folder = package.parent if package.name == "scenelang" else ROOT / ".venv" / "live"
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "COV_"))}
    return {**kept, "PYTHONPATH": str(folder)}


def _instructions(*words: str) -> float:
    """Instructions of a Python process by cachegrind; the first run writes bytecode."""
    command = [sys.executable, "-S", "-P", *words]
    subprocess.run(command, env=_environment(), capture_output=True, check=True)
    counted = ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", *command]
    done = subprocess.run(counted, env=_environment(), capture_output=True, text=True, check=True)
    match = re.search(r"I\s+refs:\s+([\d,]+)", done.stderr)
    assert match is not None
    return float(match[1].replace(",", ""))


@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed")
@pytest.mark.parametrize(
    ("words", "budget"),
    [
        # 10.2 and 3.3 with Python 3.11: 7.9 and 2.7 beside a Python that imports ``site``, as people start it, where they
        # were 15 and 3.1 before modules were imported by need
        (("-m", "scenelang", "check", FIGURE), 11.5),
        (("-m", "scenelang", "--help"), 4.0),
    ],
)
def test_start_up_stays_within_its_instructions(words: tuple[str, ...], budget: float) -> None:
    assert _instructions(*words) <= budget * _instructions("-c", "pass")


def test_a_check_imports_what_it_uses() -> None:
    script = (
        "import sys; from scenelang.cli.main import main; code = main(['check', sys.argv[1]]);"
        f"print([name for name in {NEEDLESS!r} if name in sys.modules]); sys.exit(code)"
    )
    command = [sys.executable, "-S", "-P", "-c", script, FIGURE]
    done = subprocess.run(command, env=_environment(), capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "[]"), done.stderr


def test_a_definition_of_the_prelude_is_expanded_when_its_body_is_needed() -> None:
    prelude = type(prelude_of(build_library()))(build_library())
    assert prelude.scope.fallback is not None
    ring = prelude.scope.fallback("ring")
    assert list(prelude.definitions) == [ring]
    definition = prelude.definitions[ring]
    assert definition.target is ring
    place = definition.span
    assert place.source.text[place.start :].startswith("(define (ring ")
    assert isinstance(place.source, Source)


@pytest.mark.parametrize("group", ["scenelang.backends", "scenelang.primitives", "console_scripts", "pytest11"])
def test_entry_points_are_those_of_the_standard_library(group: str) -> None:
    expected = {point.name: point.value for point in reversed(entry_points(group=group))}
    assert {name: point.value for name, point in entry_points_of(group).items()} == expected
