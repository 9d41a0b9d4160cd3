"""Mistakes that newcomers and language models make, one in each program: `check` reports it, and nothing else, before
the program runs.

The first line of a program says which finding is expected; ``undecidable`` says why only a run can find it. Beside it
is what `check` prints, and the text that was meant where `check --fix` can restore it.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from pathlib import Path

import pytest

from mistakes.typos import typos
from support import unchecked
from scenelang import Session, Source
from scenelang.grammar.diagnostics import Diagnostic, render_text

HERE = Path(__file__).parent
PROGRAMS = sorted(path for path in HERE.rglob("*") if path.suffix in (".scene", ".py") and path.parent != HERE)
FIXED = sorted(HERE.rglob("*.fixed"))
UPDATE = bool(os.environ.get("SCENELANG_UPDATE_GOLDENS"))
_QUIET = ("W306",)  # what is left over by the mistake


def name_of(path: Path) -> str:
    return str(path.relative_to(HERE).with_suffix(""))


def source_of(path: Path) -> Source:
    suffix = ".py" if path.with_suffix(".py").exists() else ".scene"
    return Source(path.stem + suffix, path.read_text("utf-8"))


def expected_of(path: Path) -> str:
    match = re.match(r"[;#] expect ([EW]\d+)\n", path.read_text("utf-8"))
    assert match is not None, path
    return match[1]


def is_undecidable(path: Path) -> bool:
    return "undecidable:" in path.read_text("utf-8").split("\n")[1]


def checked(path: Path) -> list[Diagnostic]:
    return [d for d in Session().check(source_of(path)).diagnostics if d.code not in _QUIET]


@pytest.mark.parametrize("path", PROGRAMS, ids=name_of)
def test_it_is_the_one_finding(path: Path) -> None:
    found = checked(path)
    text = "\n".join(render_text(d, color=False) for d in found) + "\n"
    golden = path.with_suffix(".txt")
    if UPDATE:
        golden.write_text(text, "utf-8")
    assert text == golden.read_text("utf-8")
    if not is_undecidable(path):
        assert [d.code for d in found] == [expected_of(path)]


@pytest.mark.parametrize("path", FIXED, ids=name_of)
def test_it_is_fixed_to_what_was_meant(path: Path) -> None:
    source, count = Session().autofix(source_of(path.with_suffix(".scene")))
    assert count >= 1
    assert source.text == path.read_text("utf-8")
    assert [d for d in checked(path) if d.is_error] == []


def test_the_corpus_is_broad() -> None:
    decidable = [path for path in PROGRAMS if not is_undecidable(path)]
    assert len(PROGRAMS) >= 150
    assert len(PROGRAMS) - len(decidable) <= 0.15 * len(PROGRAMS)
    assert len({path.parent for path in PROGRAMS}) >= 5
    fixable = [path for path in PROGRAMS if path.suffix == ".scene"]
    assert len(FIXED) >= len(fixable) / 2


AT_RUN = [
    path
    for path in PROGRAMS
    if path.suffix == ".scene" and expected_of(path)[:2] in ("E4", "E6") and not is_undecidable(path)
    and path.stem != "loop-body-index"  # a run first meets the index that the missing function would bind
]


@pytest.mark.parametrize("path", AT_RUN, ids=name_of)
def test_the_run_fails_in_the_same_way(path: Path) -> None:
    """An error that is found before the run has the code that the run would give."""
    with unchecked():
        evaluated = Session().evaluate(source_of(path))
    (error,) = [d for d in evaluated.diagnostics if d.is_error]
    assert error.code == expected_of(path)


SOUND = {name: (HERE.parents[1] / "examples" / f"{name}.scene").read_text("utf-8") for name in ("jenga", "toys")}
# What no check can know: words of the author's own, texts, attributes that are passed on, names of materials in them.
_OPEN = re.compile(r'"jenga|"number|"[a-z]+ [a-z ]+"|-> "#|"toys|"ball')


@pytest.mark.parametrize("name", SOUND)
@pytest.mark.sampled(2)
def test_typos(name: str) -> None:
    counts: Counter[str] = Counter()
    missed: list[str] = []
    for kind, change, text in typos(SOUND[name], 1, 60):
        if _OPEN.search(change):
            continue
        found = [d for d in Session().check(Source("a.scene", text)).diagnostics if d.code not in _QUIET]
        counts[kind] += 1
        if not found:
            missed.append(f"{kind}: {change}")
    assert len(missed) <= 0.05 * counts.total(), missed


SEVEN = """(define (leg height::Float) (call "cylinder" :radius .1 :p1 [0 height 0]))
(bind "top" (lambda ((:width 1)) (call "cube" :scale [width .1 1])))
(bind "table"
  (lambda ()
    (union
      (call "top" :widht 2)
      (transform (translate [0 1 0]) (leg 1))
      (transform (leg "tall") (translate 1 0 0))
      (call "sphere" :color "red")
      (for ((i 4)) (leg i))
      (roate 1 [0 1 0]))))
"""


def test_many_mistakes_in_one_run() -> None:
    """Each mistake is reported, though the others are not fixed."""
    found = Session().check(Source("seven.scene", SEVEN)).diagnostics
    assert [(d.code, d.span.text if d.span else "") for d in found] == [
        ("E404", ":widht"),
        ("E602", "(translate [0 1 0])"),
        ("E401", '"tall"'),
        ("E402", "(translate 1 0 0)"),
        ("E603", '"red"'),
        ("E601", "(for ((i 4)) (leg i))"),
        ("E301", "roate"),
    ]


SEVEN_IN_PYTHON = """@register()
def leg(height: float) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p1': (0, height, 0)}, color='red')

@register()
def top() -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (1, 0.1)})

@register()
def table() -> Shape:
    legs = loop(4, lambda i: transform_shape(translation_matrix((i, 0, 0)), library_call('leg', height=1)))
    a = transform_shape(library_call('leg', hieght=1), translation_matrix(1, 0, 0))
    b = transform_shape(library_call('top'), rotation_matrix((0, 1, 0), 1))
    c = primitive_call('sphere', shape_kwargs={'radius': 'big'})
    return concat_shapes(legs, a, b, c, undefined)
"""


def test_many_mistakes_in_python_in_one_run() -> None:
    found = [d for d in Session().check(Source("seven.py", SEVEN_IN_PYTHON)).diagnostics if d.is_error]
    assert [(d.code, d.span.text if d.span else "") for d in found] == [
        ("E603", "'red'"),
        ("E603", "(1, 0.1)"),
        ("E602", "translation_matrix((i, 0, 0))"),
        ("E805", "hieght=1"),
        ("E805", "translation_matrix(1, 0, 0)"),
        ("E401", "rotation_matrix((0, 1, 0), 1)"),
        ("E603", "'big'"),
        ("E804", "undefined"),
    ]
