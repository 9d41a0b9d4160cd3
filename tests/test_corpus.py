"""Hand-translated programs of the corpus give the geometry of the reference implementation; so do their expansions."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import pytest
from corpus.compare import compare

from scenelang.cli.main import main

FOLDER = Path(__file__).parent / "corpus"
PROGRAMS = sorted(FOLDER.glob("*.scene"))


def flattened(path: Path) -> Any:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(["flatten", str(path), "--json", "-q"]) == 0
    return json.loads(out.getvalue())


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_program_gives_its_golden_geometry(program: Path) -> None:
    golden = json.loads(program.with_suffix(".json").read_text())
    result = compare(flattened(program), golden)
    assert result["equal"], result
    assert result["matched"] == sum(len(frame["primitives"]) for frame in golden["frames"])


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_diff_agrees(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diff", str(program), str(program.with_suffix(".json")), "-q"]) == 0
    assert capsys.readouterr().out.startswith("equal: ")


EXAMPLES = sorted((FOLDER.parent.parent / "examples").glob("*.scene"))


def test_expansion_keeps_params(tmp_path: Path) -> None:
    sponge = next(path for path in EXAMPLES if path.stem == "menger-sponge")
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(["expand", str(sponge)]) == 0
    expanded = tmp_path / "sponge.scene"
    expanded.write_text(out.getvalue())
    counts = []
    for path in (sponge, expanded):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            assert main(["count", str(path), "--json", "--define", "level=1"]) == 0
        counts.append(json.loads(out.getvalue()))
    assert counts[0] == counts[1]
    assert counts[0]["cube"] == 20


def test_expansion_has_no_camera_of_an_imported_file(tmp_path: Path) -> None:
    (tmp_path / "part.scene").write_text('(camera "c" :eye [0 0 9])\n(bind "part" (lambda () (call "cube")))\n')
    main_file = tmp_path / "main.scene"
    main_file.write_text(
        '(import "part.scene")\n(light :position [1 2 3] :power 5)\n(bind "a" (lambda () (call "part")))\n'
    )
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(["expand", str(main_file)]) == 0
    assert "camera" not in out.getvalue()
    assert "(light" in out.getvalue()


@pytest.mark.parametrize("program", [*PROGRAMS, *EXAMPLES], ids=lambda path: path.stem)
@pytest.mark.sampled(4)
def test_expansion_is_the_same_program(program: Path, tmp_path: Path) -> None:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(["expand", str(program)]) == 0
    expanded = tmp_path / program.name
    expanded.write_text(out.getvalue())
    assert flattened(expanded) == flattened(program)
