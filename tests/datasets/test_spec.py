"""Specs: what they may say, and how a mistake in one is told, with its line and column."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from scenelang.datasets.making import classes_of
from scenelang.datasets.spec import Distribution, Spec, varied
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError

Read = Callable[..., Spec]
HEAD = 'programs = "room.scene"\n'


@pytest.mark.parametrize(
    ("text", "line", "column", "told", "hint"),
    [
        ("programs = 'room.scene'\ncuont = 3", 2, 1, "unknown key `cuont`", "did you mean `count`?"),
        ("programs = 'room.scene'\ncount = 'x'", 2, 1, "`count`: expected a whole number, got 'x'", None),
        ("programs = 'room.scene'\ncount = 0", 2, 1, "`count`: expected 1 to", None),
        ("count = 3", 1, 1, "name at least one program", None),
        ("programs = ['no-*.scene']", 1, 1, "nothing matches `no-*.scene`", "paths are relative"),
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


def test_ranges_of_splits_may_not_overlap(read: Read) -> None:
    text = HEAD + "[params]\nballs = { integer = [1, 6] }\n[splits]\nby = 'balls'\n"
    with pytest.raises(SceneError, match="overlaps that of `train`, which would leak"):
        read(text + "train = { range = [1, 4] }\ntest = { range = [3, 7] }")
    with pytest.raises(SceneError, match="is also in `train`"):
        read(text + "train = [1, 2]\ntest = [2, 3]")
    assert read(text + "train = { range = [1, 4] }\ntest = 'rest'").splits is not None


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
