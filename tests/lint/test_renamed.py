"""Names of earlier versions: the fix gives a program of the same scene, and nothing names them any more."""

from __future__ import annotations

from pathlib import Path

import pytest

import scenelang as sl
from scenelang import Session, Source
from scenelang.interpreter.expand.forms import RENAMED
from scenelang.interpreter.scene.primitives import words
from scenelang.stdlib.reference import records

# What was written, and the same scene without any name that changed.
CASES = [
    ('(transform (call "cube") (rotate (radians 90) [0 1 0]))', '(transform (call "cube") (rotate (/ pi 2) [0 1 0]))'),
    ('(transform (call "cube") (rotate (degrees 30) [0 1 0]))', '(transform (call "cube") (rotate (/ pi 6) [0 1 0]))'),
    ('(ring 3 (call "cube") :sweep (degrees 6))', '(ring 3 (call "cube") :sweep (/ pi 30))'),
    ('(call "cube" :scale (degrees pi))', '(call "cube" :scale 180.0)'),
    ('(call "cube" :scale (- (degrees (atan 1 -1)) 134))', '(call "cube" :scale 1.0)'),
    ('(let ((deg 90)) (transform (call "cube") (rotate (radians deg) [0 1 0])))',
     '(transform (call "cube") (rotate (/ pi 2) [0 1 0]))'),
    ('(union-solid (call "cube") (call "sphere"))', '(solid-union (call "cube") (call "sphere"))'),
    ('(call "rounded-cube" :scale 2 :rounding .3)', '(call "rounded-cube" :scale 2 :radius .3)'),
    ('(call "asset" :file "tip.obj")', '(call "mesh" :file "tip.obj")'),
]  # fmt: skip


@pytest.mark.parametrize(("written", "same"), CASES)
def test_the_fix_gives_the_same_scene(written: str, same: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tip.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    program = '(bind "a" (lambda () {}))\n(scene "a")'
    fixed, count = Session().autofix(Source("a.scene", program.format(written)))
    assert count == 1
    assert sl.diff(sl.evaluate(fixed.text), sl.evaluate(program.format(same))).equal


def test_no_name_of_earlier_versions_is_known() -> None:
    names = {record.name for record in records()} | set(words())
    assert names.isdisjoint({*RENAMED, "asset"})
    assert {*RENAMED.values(), "mesh"} <= names
