"""Programs of OpenSCAD: they convert, check and are formatted, and their volumes are those that OpenSCAD computes."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest
import trimesh

import scenelang as sl
from scenelang.backends.openscad.converting import converted, imported
from scenelang.backends.openscad.expressions import ANY, INT, NUM, UNKNOWN, joined, list_of, vector
from scenelang.backends.openscad.geometry import fragments_of
from scenelang.backends.openscad.syntax import MAX_NESTING
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import INDENTS

HERE = Path(__file__).parent
PROGRAMS = sorted((HERE / "programs").glob("*.scad"))
VOLUMES = json.loads((HERE / "volumes.json").read_text("utf-8"))


def volume(text: str) -> float:
    """The volume of a converted program's scene."""
    done = sl.evaluate(f'{text}\n(bind "%volume" (lambda () (call "cube" :scale [(volume {body(text)}) 1 1])))\n(scene "%volume")')
    return float(done.graph.root.children[0].car.embedding.attributes["scale"][0])


def body(text: str) -> str:
    """The word of the root as a call."""
    word = text.rsplit('(bind "', 1)[1].split('"', 1)[0]
    return f'(call "{word}")'


def volume_of(program: str) -> float:
    return volume(converted(program)[0])


def error(program: str) -> tuple[str, str, tuple[int, int]]:
    """The code, message and place of a program's mistake."""
    with pytest.raises(SceneError) as caught:
        converted(program)
    span = caught.value.span
    assert span is not None
    return caught.value.name, caught.value.message, span.source.position(span.start)


# --- whole programs --------------------------------------------------------------------------------------------------


def test_there_are_thirty_programs_with_a_volume() -> None:
    assert len(PROGRAMS) >= 30
    assert set(VOLUMES) == {path.stem for path in PROGRAMS}


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_has_the_volume_that_openscad_gives(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    text, _ = imported(path)
    assert format_text(text, INDENTS) == text
    program = tmp_path / "a.scene"
    program.write_text(text, "utf-8")
    assert main(["check", str(program)]) == 0
    assert volume(text) == pytest.approx(VOLUMES[path.stem], rel=1e-3)
    made = tmp_path / "a.3mf"
    assert main(["export", str(program), "-o", str(made), *WATERTIGHT]) == 0
    capsys.readouterr()
    mesh = trimesh.load(made, force="mesh")
    mesh.merge_vertices()
    assert mesh.is_watertight
    assert abs(mesh.volume) * SCALE == pytest.approx(VOLUMES[path.stem], rel=1e-3)
