"""Specs: what they may say, and how a mistake in one is told, with its line and column."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from scenelang.datasets.naming import classes_of
from scenelang.datasets.spec import Distribution, Spec, varied
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError

Read = Callable[..., Spec]
HEAD = 'programs = "room.scene"\n'
ORTHOGRAPHIC = (
    HEAD
    + "[cameras]\northographic = true\n[labels]\nwrite = ['instance', 'depth', 'boxes', 'visibility']\n"
    + "[output]\nformats = ['{}']"
)


@pytest.mark.parametrize(
    ("text", "line", "column", "told", "hint"),
    [
        ("programs = 'room.scene'\ncuont = 3", 2, 1, "unknown key `cuont`", "did you mean `count`?"),
        ("programs = 'room.scene'\ncount = 'x'", 2, 1, "`count`: expected a whole number, got 'x'", None),
        ("programs = 'room.scene'\ncount = 0", 2, 1, "`count`: expected 1 to", None),
        ("count = 3", 1, 1, "name at least one program", None),
        ("programs = ['no-*.scene']", 1, 13, "no program matches `no-*.scene`", "paths are relative"),
        ("programs = ['room.scene', 'spec.toml']", 1, 27, "`spec.toml` is no program", "programs end in .scene"),
        (f"programs = ['{'x' * 5000}.scene']", 1, 13, "no program matches `xxx", None),
        ("programs = ['']", 1, 13, "no program matches ``", None),
        ("programs = ['room.scene', 'empty']", 1, 27, "`empty` has no program", None),
        ("programs = ['*.toml']", 1, 13, "no program matches `*.toml`", None),
        (HEAD + "seed = 1" + "0" * 5000, 2, 8, "an integer has thousands of digits", "64 bits"),
        (HEAD + "seed = 0x1" + "0" * 5000, 2, 1, "`seed`: the integer is too large", "64 bits"),
        (HEAD + "[params]\nballs = { integer = [0, 9223372036854775808] }", 3, 25, "`integer`: the integer is too large", None),
        (HEAD + "[params]\nballs = { uniform = [-1.7e308, 1.7e308] }", 3, 11, "at most 1e+300", None),
        (HEAD + "[params]\nballs = { normal = [0, 1e308] }", 3, 11, "at most 1e+300", None),
        (HEAD + "[params]\nballs = { choice = [1, 2], weights = [inf, 1] }", 3, 28, "expected finite numbers", None),
        (HEAD + "[params]\nballs = { choice = [1, 2], weights = [nan, 1] }", 3, 28, "expected finite numbers", None),
        (HEAD + "[cameras]\ntarget = [0, nan, 0]", 3, 1, "expected three finite numbers", None),
        (HEAD + "[cameras]\nkind = 'file'\nfiles = 'spec.toml'", 4, 1, "is not a camera file", None),
        (HEAD + "[words.ball]\ncolor = ['redd']", 3, 1, "unknown color", "did you mean"),
        (HEAD + "[words.ball]\nroughness = ['rough']", 3, 1, "`roughness`: expected numbers", None),
        (HEAD + "[words.ball]\nbind = ['(lambda (']", 3, 1, "`bind`: ", None),
        (HEAD + "[words.ball]\nbind = ['1 2']", 3, 1, "expected one expression, got 2", None),
        (HEAD + "[captions]\ntemplates = ['{things}', '{thing}']", 3, 26, "unknown field `{thing}`", "`things`"),
        (HEAD + "[labels]\nwrite = ['keypoints']", 3, 1, "keypoints of no words", None),
        (ORTHOGRAPHIC.format("nerfstudio"), 7, 1, "nerfstudio has no orthographic cameras", None),
        (ORTHOGRAPHIC.format("colmap"), 7, 1, "colmap has no orthographic cameras", None),
        (ORTHOGRAPHIC.format("bop"), 7, 1, "bop has no orthographic cameras", None),
        (ORTHOGRAPHIC.format("kitti"), 7, 1, "kitti has no orthographic cameras", None),
        ("programs = ['room.scene'\ncount = 3", 2, 1, "this is not TOML", None),
        (HEAD + "[params]\nballs = { uniform = [3, 1] }", 3, 11, "the range [3, 1] is empty", "write [1, 3]"),
        (HEAD + "[params]\nballs = { unifrom = [1, 3] }", 3, 11, "unknown `unifrom`", "did you mean `uniform`?"),
        (HEAD + "[params]\nballs = { integer = [1.5, 3] }", 3, 11, "`integer`: expected two whole numbers", None),
        (HEAD + "[params]\nballs = { loguniform = [0, 3] }", 3, 11, "expected positive numbers", None),
        (HEAD + "[params]\nballs = { choice = [1, 2], weights = [1] }", 3, 28, "expected 2 numbers", None),
        (HEAD + "[params]\nballs = [1, { a = 1 }]", 3, 13, "expected a number", None),
        (HEAD + "[params]\nballs = []", 3, 1, "expected 1 to", None),
        (HEAD + "[pictures]\nsize = [0, 3]", 3, 1, "`size`: expected [width, height]", None),
        (HEAD + "[pictures]\nquality = 'drafty'", 3, 1, "unknown quality or backend `drafty`", "draft"),
        (HEAD + "[pictures]\nenvironment = 'suny'", 3, 1, "unknown `suny`", "did you mean `sunny`?"),
        (HEAD + "[pictures]\nsettings = { samples = 3 }", 3, 1, "has no option `--samples`", None),
        (HEAD + "[cameras]\nkind = 'spiral'", 3, 1, "unknown `spiral`", None),
        (HEAD + "[cameras]\nelevation = { uniform = [0, 100] }", 3, 1, "expected numbers from -90 to 90", None),
        (HEAD + "[cameras]\nkind = 'trajectory'", 3, 1, "a trajectory needs `eyes`", None),
        (HEAD + "[labels]\nwrite = ['depths']", 3, 1, "unknown `depths`", "did you mean `depth`?"),
        (HEAD + "[output]\nformats = ['bop']", 3, 1, "bop is made from visibility", "add visibility"),
        (HEAD + "[output]\nformats = ['webdataset', 'parquet']", 3, 1, "not both", None),
        (HEAD + "[splits]\ntrain = 0.5\ntest = 0.4", 2, 1, "the shares sum to 0.9", None),
        (HEAD + "[splits]\nby = 'size'\ntrain = [1]\ntest = [2]", 3, 1, "`size` does not vary", None),
        (HEAD + "[splits]\nby = 'program'\ntrain = ['x*']\ntest = 'rest'", 4, 1, "no program matches x*", None),
        (HEAD + "[splits]\nby = 'program'\ntrain = 0.7\ntest = 0.3", 3, 1, "one program cannot be dealt to 2 splits", 'by = "scene"'),
        (HEAD + "[splits]\ntrain = 0.7\n'..' = 0.3", 4, 1, "`..` is not a name for a split", "use at most 64 letters"),
        (HEAD + "[splits]\ntrain = 0.7\n'a/b' = 0.3", 4, 1, "`a/b` is not a name for a split", None),
        (HEAD + f"[splits]\ntrain = 0.7\n{'a' * 65} = 0.3", 4, 1, "is not a name for a split", None),
        (HEAD + "[splits]\ntrain = 0.7\nTrain = 0.3", 4, 1, "`Train` and `train` are one name where case is ignored", None),
        (HEAD + "[splits]\ntrain = 0.7\nmodels = 0.3\n[labels]\nwrite = ['instance', 'depth', 'boxes', 'visibility']\n[output]\nformats = 'bop'", 4, 1, "`models`: bop has a folder of this name", "choose another name"),
        (HEAD + "[splits]\nannotations = 0.7\ntest = 0.3\n[output]\nformats = 'coco'", 3, 1, "`annotations`: coco has", None),
        (HEAD + "[splits]\ntest = 0.7\nSeqmaps = 0.3\n[output]\nformats = 'mot'", 4, 1, "`Seqmaps`: mot has", None),
        (HEAD + "[splits]\nby = 'balls'\ntrain = 0.5\ntest = 0.5\n[params]\nballs = [1, 2]", 4, 1, "`train`: expected { range = [low, high] } or a list", None),
        (HEAD + "[params]\nballs = [1, 2]\n[splits]\nby = 'balls'\ntrain = { range = [1, 2] }\ntest = [1, 2]", 7, 1, "`test`: 1 is in the range of `train`, which would leak", None),
        (HEAD + "[params]\nballs = [1, 2]\n[splits]\nby = 'balls'\ntrain = [1, 2]\ntest = [3]", 7, 1, "`test`: no value of `balls` is in this split", None),
        (HEAD + "[params]\nballs = [1, 2]\n[splits]\nby = 'balls'\ntrain = [1, 2]\ntest = 'rest'", 7, 1, "`test`: no value of `balls` is in this split", None),
        (HEAD + "[params]\nballs = { integer = [1, 4] }\n[splits]\nby = 'balls'\ntrain = { range = [1, 4.5] }\ntest = 'rest'", 7, 1, "`test`: no value", None),
        (HEAD + "[params]\nballs = { integer = [1, 4] }\n[splits]\nby = 'balls'\ntrain = { range = [1, 4] }\ntest = { range = [4.5, 9] }", 7, 1, "`test`: no value", None),
        (HEAD + "[params]\nballs = { uniform = [1, 4] }\n[splits]\nby = 'balls'\ntrain = { range = [0, 5] }\ntest = 'rest'", 7, 1, "`test`: no value", None),
        (HEAD + "[params]\nballs = { uniform = [1, 4] }\n[splits]\nby = 'balls'\ntrain = [2]\ntest = 'rest'", 6, 1, "`train`: no value", None),
        (HEAD + "[params]\nballs = { normal = [1, 4], max = 3 }\n[splits]\nby = 'balls'\ntrain = { range = [4, 5] }\ntest = 'rest'", 6, 1, "`train`: no value", None),
        (HEAD + "[params]\nballs = [true, 1.5]\n[splits]\nby = 'balls'\ntrain = [true]\ntest = [true, 1.5]", 7, 1, "`test`: true is also in `train`", None),
        (HEAD + "[splits]\nby = 'program'\ntrain = ['*.scene']\ntest = 'rest'", 5, 1, "`test`: every program is in another split", None),
        (HEAD + "[params]\nballs = { uniform = [1, 2, 3] }", 3, 11, "`uniform`: expected two numbers, got [1, 2, 3]", None),
        (HEAD + "[params]\nballs = 2026-11-02", 3, 1, "got 2026-11-02", None),
        (HEAD + "[pictures]\nsize = 4096", 3, 1, "`size`: 4,096 x 4,096 pixels need at least 5.5 GB of memory, more than the limit of 4 GB", "raise `memory`"),
        (HEAD + "[pictures]\nsize = 512\n[limits]\nmemory = 50000000", 5, 1, "`memory`: 512 x 512 pixels need at least 0.087 GB", "reduce `size`"),
        (HEAD + "count = true", 2, 1, "expected a whole number, got true", None),
        (HEAD + "[filters]\npredicates = ['mine']", 3, 1, "unknown `mine`", "no package has"),
        (HEAD + "[filters.visible]\nball = 2", 3, 1, "expected 0.0 to 1.0", None),
        (HEAD + "[limits]\nseconds = -1", 3, 1, "expected 0.1 to", None),
        (HEAD + "[words.ball]\npaint = 'red'", 3, 1, "unknown key `paint`", None),
        (HEAD + "[words.ball]", 2, 1, "nothing varies", None),
    ],
)  # fmt: skip
def test_mistakes_are_told_with_their_place(
    read: Read, text: str, line: int, column: int, told: str, hint: str | None
) -> None:
    with pytest.raises(SceneError) as caught:
        read(text)
    error = caught.value
    assert (error.name, error.diagnostic.code) == ("dataset", "E921")
    assert told in error.message
    assert hint is None or hint in str(error.hint)
    assert isinstance(error.span, Span)
    assert error.span.source.position(error.span.start) == (line, column)


def test_splits_may_have_the_names_of_other_formats(read: Read) -> None:
    assert read(HEAD + "[splits]\nmodels = 0.7\nannotations = 0.3").splits is not None


def test_programs_of_equal_text_are_dealt_as_one(tmp_path: Path) -> None:
    from scenelang.datasets.spec import spec_of

    for name, size in (("a", 1), ("b", 1), ("c", 2)):
        (tmp_path / f"{name}.scene").write_text(f'(bind "a" (lambda () (call "cube" :scale {size})))')
    text = "programs = '*.scene'\n[splits]\nby = 'program'\ntrain = 0.5\ntest = 0.3\n"
    with pytest.raises(SceneError, match="2 different programs cannot be dealt to 3 splits"):
        spec_of(text + "val = 0.2", "s", tmp_path)
    assert spec_of(text.replace("0.3", "0.5"), "s", tmp_path).splits is not None


def test_a_split_whose_programs_are_all_equal_to_others_is_empty(tmp_path: Path) -> None:
    from scenelang.datasets.spec import spec_of

    for name in ("a-1", "b-1"):
        (tmp_path / f"{name}.scene").write_text('(bind "a" (lambda () (call "cube")))')
    text = "programs = '*.scene'\n[splits]\nby = 'program'\ntrain = ['a-*.scene']\n"
    with pytest.raises(SceneError, match="`test`: every program is in another split"):
        spec_of(text + "test = 'rest'", "s", tmp_path)
    with pytest.raises(SceneError, match="`test`: its programs, or programs of equal text, are in another split"):
        spec_of(text + "test = ['b-*.scene']", "s", tmp_path)


def test_ranges_of_splits_may_not_overlap(read: Read) -> None:
    text = HEAD + "[params]\nballs = { integer = [1, 6] }\n[splits]\nby = 'balls'\n"
    with pytest.raises(SceneError, match="overlaps that of `train`, which would leak"):
        read(text + "train = { range = [1, 4] }\ntest = { range = [3, 7] }")
    with pytest.raises(SceneError, match="is also in `train`"):
        read(text + "train = [1, 2]\ntest = [2, 3]")
    assert read(text + "train = { range = [1, 4] }\ntest = 'rest'").splits is not None


@pytest.mark.parametrize(
    ("text", "line", "told", "hint"),
    [
        ("root = 'rom'", 2, "no program has the word `rom`", "did you mean `room`?"),
        ("[words.bal]\nroughness = 1", 2, "no program has the word `bal`", "did you mean `ball`?"),
        ("[labels]\nwords = ['bal']", 3, "no program has the word `bal`", "did you mean `ball`?"),
        ("[labels]\nkeypoints = ['lg']", 3, "no program has the word `lg`", "did you mean `leg`?"),
        ("[filters.visible]\nbal = 0.1", 3, "no program has the word `bal`", "did you mean `ball`?"),
        (
            "[captions]\ntemplates = ['{things}', '{count:bal}']",
            3,
            "no program has the word `bal`",
            "did you mean `ball`?",
        ),
        ("[params]\nbals = 1", 3, "no program has the param `bals`", "did you mean `balls`?"),
    ],
)
def test_unknown_names_are_told_with_their_place(read: Read, text: str, line: int, told: str, hint: str) -> None:
    with pytest.raises(SceneError) as caught:
        classes_of(read(HEAD + text))
    assert (caught.value.diagnostic.code, caught.value.message, caught.value.hint) == ("E921", told, hint)
    assert isinstance(caught.value.span, Span)
    assert caught.value.span.source.position(caught.value.span.start)[0] == line


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ("[1, 7]", "accepts 1 to 6, but 7 may be drawn"),
        ("{ integer = [0, 3] }", "accepts 1 to 6, but 0 may be drawn"),
        ("{ uniform = [1, 6.5] }", "accepts 1 to 6, but 6.5 may be drawn"),
        ("{ normal = [3, 1] }", "accepts 1 to 6, but -3 may be drawn"),
        ("{ value = [1, 2] }", "accepts numbers only, got [1, 2]"),
        ("true", "accepts numbers only, got true"),
        ("{ normal = [3, 1], min = 1, max = 6 }", None),
        ("{ choice = [1, 9], weights = [1, 0] }", None),
        ("{ uniform = [0, 9], min = 1, max = 6 }", None),
    ],
)
def test_params_outside_the_bounds_of_a_program_are_told(read: Read, values: str, told: str | None) -> None:
    spec = read(HEAD + f"[params]\nballs = {values}")
    if told is None:
        assert classes_of(spec)
        return
    with pytest.raises(SceneError) as caught:
        classes_of(spec)
    assert told in caught.value.message
    assert "`balls`: `room.scene` accepts" in caught.value.message
    assert isinstance(caught.value.span, Span)
    assert caught.value.span.source.position(caught.value.span.start) == (3, 1)


def test_a_split_by_a_param_that_a_program_lacks_is_told(read: Read) -> None:
    text = "programs = ['room.scene', 'cart.scene']\n[params]\nballs = [1, 2]\n[splits]\nby = 'balls'\ntrain = [1]\ntest = [2]"
    with pytest.raises(SceneError, match=r"`by`: `cart.scene` has no param `balls`, .* in every split") as caught:
        classes_of(read(text))
    assert isinstance(caught.value.span, Span)
    assert caught.value.span.source.position(caught.value.span.start) == (5, 1)
    assert classes_of(read(text.replace(", 'cart.scene'", "")))


def test_looks_out_of_range_are_warnings(read: Read) -> None:
    from scenelang.datasets.naming import warnings_of

    looks = (
        "color = [[0.5, 2, 0], 'red']\nroughness = { uniform = [0, 1.5] }\nior = 1.5\nemission = -1\nmetallic = [0, 1]"
    )
    found = warnings_of(read(HEAD + f"[words.ball]\n{looks}"))
    assert [(each.code, each.message) for each in found] == [
        ("W402", 'the attribute `:color` of "ball" should be 0 to 1, got 2'),
        ("W402", 'the attribute `:roughness` of "ball" should be 0 to 1, got 1.5'),
        ("W402", 'the attribute `:emission` of "ball" should not be negative, got -1'),
    ]
    assert [each.span.source.position(each.span.start)[0] for each in found if isinstance(each.span, Span)] == [3, 4, 6]


def test_words_are_classes_once_and_what_draws_nothing_is_none(tmp_path: Path) -> None:
    from scenelang.datasets.spec import spec_of

    (tmp_path / "a.scene").write_text(
        '(bind "a\\x62;" (lambda () (call "cube")))\n(bind "quote\\"d" (lambda () (call "sphere")))\n'
        '(bind "root" (lambda () (union (call "ab") (call "a\\u0062") (call "quote\\"d") (call "c\\x75;be")'
        ' (call "delete-blocks" :scale [1 1 1]))))'
    )
    assert list(classes_of(spec_of("programs = 'a.scene'", "s", tmp_path))) == ["ab", 'quote"d', "root"]


@pytest.mark.parametrize("name", ["a.scene", "a.json", "a.py"])
def test_programs_that_cannot_be_read_are_told_before_the_run(tmp_path: Path, name: str) -> None:
    from scenelang.datasets.running import dataset

    (tmp_path / name).write_bytes(b"\xff\xfe(bind")
    (tmp_path / "spec.toml").write_text(f"count = 2\nprograms = '{name}'")
    with pytest.raises(SceneError, match=r"`programs`: .*UTF-8") as caught:
        dataset(tmp_path / "spec.toml", tmp_path / "out", jobs=0)
    assert isinstance(caught.value.span, Span)
    assert caught.value.span.source.position(caught.value.span.start) == (2, 1)
    assert not (tmp_path / "out").exists()


def test_unknown_words_of_programs_that_compute_words_are_warnings(tmp_path: Path) -> None:
    from scenelang.datasets.naming import warnings_of
    from scenelang.datasets.spec import spec_of

    (tmp_path / "a.scene").write_text(
        '(define w "thing")\n(bind "a" (lambda () (call w)))\n(bind w (lambda () (call "cube")))'
    )
    spec = spec_of("programs = 'a.scene'\n[labels]\nwords = ['thing', 'thingg']", "s", tmp_path)
    assert set(classes_of(spec)) == {"thing", "thingg"}
    assert "no program has the word `thingg`" in [each.message for each in warnings_of(spec)]


def test_params_of_a_dataset_of_python_must_be_known(tmp_path: Path) -> None:
    from scenelang.datasets.spec import spec_of

    (tmp_path / "a.py").write_text('@register()\ndef box():\n    return primitive_call("cube")\n')
    with pytest.raises(SceneError, match="no program has the param `n`"):
        classes_of(spec_of("programs = 'a.py'\n[params]\nn = 3", "s", tmp_path))


def test_the_digest_has_the_content_of_cameras_and_no_folders(tmp_path: Path) -> None:
    from scenelang.backends.pictures.camera import Camera, camera_to_json
    from scenelang.datasets.spec import read_spec

    text = "programs = ['a.scene', '../b.scene']\n[cameras]\nkind = 'file'\nfiles = 'camera.json'"
    inner = np.array([[9.0, 0, 4], [0, 9, 4], [0, 0, 1]])
    camera = Camera(8, 8, inner, np.eye(4), "perspective")
    for name in ("one", "two"):
        own = tmp_path / name / "specs"
        own.mkdir(parents=True)
        (own / "spec.toml").write_text(text)
        for program in (own / "a.scene", own.parent / "b.scene"):
            program.write_text('(bind "a" (lambda () (call "cube")))')
        (own / "camera.json").write_text(json.dumps(camera_to_json(camera)))
    one, two = (read_spec(tmp_path / name / "specs" / "spec.toml") for name in ("one", "two"))
    assert [one.program_name(path) for path in one.programs] == ["a.scene", "../b.scene"]
    assert one.digest == two.digest
    moved = np.eye(4)
    moved[2, 3] = 1.0
    other = tmp_path / "two" / "specs" / "camera.json"
    other.write_text(json.dumps(camera_to_json(Camera(8, 8, inner, moved, "perspective"))))
    assert read_spec(tmp_path / "two" / "specs" / "spec.toml").digest != one.digest


def test_a_param_that_no_program_has(read: Read) -> None:
    with pytest.raises(SceneError, match="no program has the param `bals`") as caught:
        classes_of(read(HEAD + "[params]\nbals = 3"))
    assert caught.value.hint == "did you mean `balls`?"


def test_programs_are_files_globs_folders_and_runs(tmp_path: Path) -> None:
    from scenelang.datasets.spec import spec_of

    for name in ("b/2.scene", "b/1.scene", "a.scene", "run/best.scene", "run/sample-1/program.scene"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text('(bind "a" (lambda () (call "cube")))')
    spec = spec_of("programs = ['a.scene', 'b', 'run', '*.scene']", "s", tmp_path)
    names = [spec.program_name(path) for path in spec.programs]
    assert names == ["a.scene", "b/1.scene", "b/2.scene", "run/best.scene"]


def test_only_what_changes_a_sample_is_in_the_digest(read: Read, folder: Path) -> None:
    base = read(HEAD)
    assert read(HEAD + "count = 7\n[output]\nshard = 9\nlicence = 'mit'").digest == base.digest
    for other in ("seed = 1", "[params]\nballs = 2", "[pictures]\nsize = 8", "[labels]\nwrite = ['depth']"):
        assert read(HEAD + other).digest != base.digest
    imported = folder / "imported.scene"
    imported.write_text("(define size 1)")
    (folder / "importing.scene").write_text(
        '(import "imported.scene")\n(bind "a" (lambda () (call "cube" :scale size)))'
    )
    before = read("programs = 'importing.scene'").digest
    imported.write_text("(define size 2)")
    assert read("programs = 'importing.scene'").digest != before


@pytest.mark.parametrize(
    ("distribution", "low", "high", "mean"),
    [
        (Distribution("uniform", (2.0, 4.0)), 2.0, 4.0, 3.0),
        (Distribution("integer", (1, 3)), 1, 3, 2.0),
        (Distribution("normal", (1.0, 2.0), (), 0.0, 2.0), 0.0, 2.0, 1.0),
        (Distribution("loguniform", (0.1, 10.0)), 0.1, 10.0, 9.9 / np.log(100.0)),
        (Distribution("choice", (0, 1), (3.0, 1.0)), 0, 1, 0.25),
    ],
)
def test_distributions(distribution: Distribution, low: float, high: float, mean: float) -> None:
    random = np.random.default_rng(1)
    drawn = [distribution.draw(random) for _ in range(4000)]
    assert low <= min(drawn) <= max(drawn) <= high
    assert np.mean(drawn) == pytest.approx(mean, rel=0.05)


def test_what_varies_is_known(read: Read) -> None:
    text = HEAD + "[params]\nballs = [1, 2]\n[words.ball]\ncolor = ['red', 'blue']\nroughness = 0.5"
    assert list(varied(read(text))) == ["param.balls", "ball.color"]


def test_the_documented_spec_is_read(read: Read) -> None:
    import re

    text = (Path(__file__).parents[2] / "docs" / "datasets.md").read_text("utf-8")
    block = re.findall(r"^```toml\n(.*?)^```$", text, re.M | re.S)[0]
    block = re.sub(r"^programs = .*$", 'programs = "room.scene"', block, flags=re.M)
    spec = read(block.replace('predicates = ["mine"]', ""))
    assert spec.cameras.views == 4
    assert spec.output.formats == ("webdataset", "coco")
    assert set(spec.params) == {"objects", "size", "material", "depth"}


def test_documented_commands_can_be_run_in_turn() -> None:
    """No two documented commands make datasets in one folder, which the second would refuse."""
    import re

    root = Path(__file__).parents[2]
    made = [
        folder
        for name in ("README.md", "docs/datasets.md")
        for folder in re.findall(r"^scenelang dataset \S+\.toml .*-o (\S+)", (root / name).read_text("utf-8"), re.M)
    ]
    assert len(made) >= 2
    assert len(set(made)) == len(made)
