"""A program has the same verdict on an idle machine and beside four busy loops: counted work decides, never time."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import copies
import pytest

TESTS = Path(__file__).parent.parent
EXAMPLES = TESTS.parent / "examples"
LOOPS = 4
BUSY = "while True: pass"

SPIN = """(bind "wheel" (lambda () (union-loop 12 (lambda (i) (transform (call "cube" :scale .2) (translate [(cos i) 1 (sin i)]))))))
(bind "fair" (lambda () (frames (for/list ((t 48)) (transform (call "wheel") (rotate (/ t 8) [0 1 0]))))))
"""
BALLS = """(bind "balls" (lambda () (union-loop 400 (lambda (i) (transform (call "sphere" :radius .4)
  (translate [(* .7 (% i 20)) 0 (* .7 (// i 20))]))))))
"""
ENDLESS = '(define (f n) (f (+ n 1))) (bind "a" (lambda () (f 0) (call "cube")))'
TILTED = """(bind "table" (lambda () (transform (call "cube" :scale [2 1 1]) (translate [0 .5 0]))))
(bind "vase" (lambda () (call "cylinder" :radius .1 :p1 [0 .3 0])))
(bind "room" (lambda () (union (call "table") (transform (call "vase") (translate [1.05 1 0])))))
"""
PYTHON = """from helper import *
from enum import Enum


class Kind(Enum):
    A = 1
    B = 2


@register()
def pile() -> Shape:
    primes = []
    for n in range(2, 4000):
        if all(n % p for p in primes):
            primes.append(n)
    parts = [transform_shape(primitive_call("cube", scale=1), translation_matrix((p, Kind.A.value, 0))) for p in primes[:20]]
    return concat_shapes(*parts)
"""
FILES = {"spin.scene": SPIN, "balls.scene": BALLS, "endless.scene": ENDLESS, "tilted.scene": TILTED, "pile.py": PYTHON}
SMALL = [
    ("check", "spin.scene", "--geometry"), ("check", "tilted.scene", "--geometry"), ("repair", "tilted.scene"),
    ("run", "endless.scene", "--max-steps", "300k"), ("transpile", "pile.py"), ("check", "balls.scene", "--geometry"),
]  # fmt: skip
LONG = [
    *((word, str(EXAMPLES / name), *more)
      for name in ("jenga.scene", "chessboard.scene", "orrery.scene", "toys.scene", "water-mill.scene", "combinators.scene")
      for word, *more in (("check", "--geometry"), ("check", "--physics"), ("count",), ("simplify",), ("repair",))),
    *(("transpile", str(path)) for path in sorted((TESTS / "transpile" / "modern").glob("*.py"))),
]  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@contextlib.contextmanager
def busy() -> Iterator[None]:
    """Keep every core busy with other processes."""
    loops = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(LOOPS)]
    try:
        yield
    finally:
        for each in loops:
            each.kill()
            each.wait()


def verdicts(commands: list[tuple[str, ...]], folder: Path) -> dict[str, tuple[int, str, str]]:
    found = {}
    for words in commands:
        done = copies.command(*words, folder=folder)
        found[" ".join(words)] = done.returncode, done.stdout, done.stderr
    return found


@pytest.mark.slow
@pytest.mark.parametrize("commands", [SMALL, LONG], ids=["small", "long"])
def test_a_verdict_does_not_depend_on_the_load(commands: list[tuple[str, ...]], folder: Path) -> None:
    alone = verdicts(commands, folder)
    with busy():
        assert verdicts(commands, folder) == alone
    assert {code for code, _, _ in alone.values()} <= {0, 1}


def test_the_verdicts_are_those_expected(folder: Path) -> None:
    found = verdicts(SMALL, folder)
    codes = {words: code for words, (code, _, _) in found.items()}
    assert codes["run endless.scene --max-steps 300k"] == 1
    assert "E501" in found["run endless.scene --max-steps 300k"][2]
    assert codes["transpile pile.py"] == 0
    assert "W626" in found["check tilted.scene --geometry"][2]


def test_seconds_are_those_of_the_evaluation(folder: Path) -> None:
    """A guard of CPU seconds does not count what other processes take."""
    with busy():
        done = copies.command("run", "spin.scene", "--json", "--max-seconds", "10", folder=folder)
    assert done.returncode == 0
    assert json.loads(done.stdout)
