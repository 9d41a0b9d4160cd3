"""The programs of ``benchmarks/strangers``: each has the value, or makes the primitives, that the same has in Python."""

from __future__ import annotations

import inspect
import re
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import support

import scenelang as sl

STRANGERS = Path(__file__).parents[2] / "benchmarks" / "strangers"
NAMES = sorted(path.stem for path in STRANGERS.glob("*.scene"))
TEXT_LINES = 300


@pytest.fixture(autouse=True)
def _beside_the_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(STRANGERS))


def _program(name: str) -> tuple[str, Callable[..., Any]]:
    return (STRANGERS / f"{name}.scene").read_text("utf-8"), runpy.run_path(str(STRANGERS / f"{name}.py"))["run"]


def _sizes(run: Callable[..., Any]) -> dict[str, int]:
    return {name: parameter.default for name, parameter in inspect.signature(run).parameters.items()}


def _result(text: str, sizes: dict[str, int]) -> Any:
    """The value of the last form, or the number of primitives of a scene."""
    if "(scene " in text:
        return len(sl.evaluate(text, defines=sizes).flatten().word)
    return support.value(text, defines={name: str(size) for name, size in sizes.items()})


@pytest.mark.parametrize("name", NAMES)
def test_equals_python(name: str) -> None:
    text, run = _program(name)
    # Sizes below 20 are levels and the like, of which half is little work; 8 of 32 is a power of two as well.
    smaller = {size: value // (2 if value < 20 else 4) for size, value in _sizes(run).items()}
    assert _result(text, smaller) == run(**smaller)


@pytest.mark.parametrize("name", NAMES)
def test_sizes_are_those_of_python(name: str) -> None:
    text, run = _program(name)
    assert {size: int(value) for size, value in re.findall(r"\(param (\S+) (\d+) ", text)} == _sizes(run)


@pytest.mark.parametrize("name", NAMES)
def test_source_and_date_are_told(name: str) -> None:
    comments = [(STRANGERS / f"{name}{ending}").read_text("utf-8").splitlines()[0][2:] for ending in (".scene", ".py")]
    assert comments[0] == comments[1]
    assert re.search(r"; \d{4}-\d\d-\d\d\.$", comments[0])


@pytest.mark.parametrize("name", ["blocks", "rods", "table", "mixed"])
def test_long_texts_equal_python(name: str, tmp_path: Path) -> None:
    texts = runpy.run_path(str(STRANGERS / "texts.py"))
    text = texts["write"](name, tmp_path, TEXT_LINES).read_text("utf-8")
    assert len(text.splitlines()) >= TEXT_LINES
    assert _result(text, {}) == texts["run"](name, TEXT_LINES)


def test_computations_and_scenes_are_there() -> None:
    scenes = [name for name in NAMES if "(scene " in _program(name)[0]]
    assert (len(scenes), len(NAMES) - len(scenes)) == (8, 21)
