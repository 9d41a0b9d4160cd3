"""Params as controls, their literals, and writing one back."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from scenelang.grammar.diagnostics import SceneError
from scenelang.session.session import Options, Session
from scenelang.viewer.workspace import ParamControl, controls_of, write_back

Program = Callable[..., Path]


def controls(path: Path) -> dict[str, ParamControl]:
    session = Session(Options())
    program = session.check(session.source(str(path))).program
    assert program is not None
    return {control.param.name: control for control in controls_of(program.params)}


@pytest.mark.parametrize(
    ("written", "kind", "value"),
    [
        ("3", "integer", 3),
        ("-2.5", "number", -2.5),
        ("#t", "boolean", True),
        ('"a \\"b\\""', "text", 'a "b"'),
        ('"#c08040"', "color", "#c08040"),
        ("[1 0 0.2158605]", "color", "#ff0080"),
        ('(color "gold")', "color", "#ffd700"),
        ("[1 2 3]", "literal", "[1 2 3]"),
        ("[.1 .2]", "literal", "[.1 .2]"),
        ("(* 2 3)", "computed", "(* 2 3)"),
        ('(color "no such")', "computed", '(color "no such")'),
        ("99999999999999999999", "literal", "99999999999999999999"),
    ],
)
def test_kinds(program: Program, written: str, kind: str, value: Any) -> None:
    (control,) = controls(program(f"(param it {written})")).values()
    assert (control.kind, control.value) == (kind, value)
    assert (control.place is None) == (kind == "computed")
    if control.place is not None:
        assert control.place.text == written


@pytest.mark.parametrize(
    ("written", "value", "after"),
    [
        ("3", 4, "4"),
        ("3", 4.0, "4"),
        ("2.5", 3, "3.0"),
        ("2.5", 1e-7, "1e-07"),
        ("#t", False, "#f"),
        ('"a"', 'x "y" \\ (z)', '"x \\"y\\" \\\\ (z)"'),
        ('"#c08040"', "#112233", '"#112233"'),
        ("[1 0 0]", "#ff8000", "[1 0.2159 0]"),
        ('(color "gold")', "#112233", '(color "#112233")'),
        ("[1 2 3]", "[4 5 6]", "[4 5 6]"),
    ],
)
def test_only_the_value_is_replaced(program: Program, written: str, value: Any, after: str) -> None:
    text = f'; é (param it 1)\r\n(param it {written} "doc ü" ) ; after\r\n(define x it)\n'
    path = program(text)
    write_back(controls(path), "it", value)
    assert path.read_bytes().decode() == text.replace(f"(param it {written} ", f"(param it {after} ")
    assert Session(Options()).check(Session(Options()).source(str(path))).ok


@pytest.mark.parametrize(
    ("written", "value"),
    [("3", "4"), ("3", 4.5), ("3", True), ("3", float("nan")), ("3", None), ("2.5", float("inf")), ("#t", 1),
     ('"a"', 3), ("[1 0 0]", "red"), ("[1 0 0]", "#ff80000"), ("[1 2 3]", "(exit)"), ("[1 2 3]", "[1 2] [3]"),
     ("[1 2 3]", "[1 2"), ("[1 2 3]", "[1 2] ; x"), ("(* 2 3)", 6)],
)  # fmt: skip
def test_values_that_do_not_fit_are_refused(program: Program, written: str, value: Any) -> None:
    path = program(f"(param it {written})")
    with pytest.raises(SceneError) as error:
        write_back(controls(path), "it", value)
    assert error.value.name == "param"
    assert path.read_text() == f"(param it {written})"


def test_a_file_that_changed_meanwhile_is_not_touched(program: Program) -> None:
    path = program("(param it 3)")
    known = controls(path)
    path.write_text("(param it 3) ; mine")
    with pytest.raises(SceneError) as error:
        write_back(known, "it", 4)
    assert error.value.name == "file"
    assert path.read_text() == "(param it 3) ; mine"


def test_mark_mode_and_link_stay(program: Program, tmp_path: Path) -> None:
    path = program("\ufeff(param it 3)")
    path.chmod(0o640)
    link = tmp_path / "link.scene"
    link.symlink_to(path)
    write_back(controls(link), "it", 4)
    assert link.is_symlink()
    assert path.read_bytes() == b"\xef\xbb\xbf(param it 4)"
    assert path.stat().st_mode & 0o777 == 0o640
    assert os.listdir(tmp_path) == sorted(["a.scene", "link.scene"]) or len(os.listdir(tmp_path)) == 2


def test_a_param_of_an_imported_file_is_written_there(program: Program) -> None:
    other = program("(param it 3)", "other.scene")
    main = program('(import "other.scene")\n(param it2 (+ it 1))')
    write_back(controls(main), "it", 5)
    assert other.read_text() == "(param it 5)"


def test_a_param_that_a_macro_made_cannot_be_saved(program: Program) -> None:
    path = program("(define-syntax make (syntax-rules () ((_ n v) (param n v))))\n(make it 3)")
    known = controls(path)
    assert known["it"].place is None
    assert known["it"].reason
    with pytest.raises(SceneError):
        write_back(known, "it", 4)


@pytest.mark.parametrize(
    ("limits", "kind"), [(":min 0 :max 9", "integer"), (":min .2 :max 3", "number"), (":max 2.5", "number")]
)
def test_a_whole_default_with_limits_between_whole_numbers_is_a_number(
    program: Program, limits: str, kind: str
) -> None:
    path = program(f"(param it 1 {limits})")
    control = controls(path)["it"]
    assert control.kind == kind
    write_back(controls(path), "it", 2)
    assert path.read_text().startswith("(param it 2 ")  # a whole number stays one
    if kind == "number":
        write_back(controls(path), "it", 1.5)
        assert path.read_text().startswith("(param it 1.5 ")
