"""The pages for people who come from other libraries: each row of their tables is tried."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang import Source
from scenelang.backends.blender import importing
from scenelang.backends.openscad import converting
from scenelang.backends.pictures.camera import parse_viewpoint

DOCS = Path(__file__).parents[1] / "docs"
SIZED = 0.01  # of the volume: trimesh's round shapes are polyhedra


def rows_of(page: str) -> list[Any]:
    """The first two columns of the table of correspondences of a page."""
    table = (DOCS / page).read_text("utf-8").partition("## Correspondences")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(.*?)` \| `(\(.*?)` \|", table, re.M)
    assert len(rows) > 8
    return [pytest.param(theirs, ours, id=theirs) for theirs, ours in rows]


def printed(expression: str, names: str) -> str:
    """Evaluate an expression of the language below definitions, and return what is printed of it."""
    row = f'(bind "row" (lambda () (print {expression}) (call "cube")))'
    return sl.evaluate(f'{names}{row}(scene "row")').log[-1]


def numbers_of(expression: str, names: str) -> list[float]:
    """The volume of an object, or the numbers of another value."""
    value = f"(let ((value {expression})) (if (or (entity? value) (pair? value)) (volume (union value)) value))"
    return [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", printed(value, names))]


def example_of(page: str, language: str) -> tuple[str, str]:
    """The worked example of a page: the program in another language, and the converted one."""
    section = (DOCS / page).read_text("utf-8").partition("\n## Example\n")[2]
    match = re.search(rf"^```{language}\n(.*?)^```\n\nbecomes\n\n```scene\n(.*?)^```$", section, re.M | re.S)
    assert match is not None
    return match[1], match[2]


def test_the_openscad_example_converts_as_it_says() -> None:
    theirs, ours = example_of("from-openscad.md", "openscad")
    assert converting.converted(theirs, word="washers")[0].endswith(ours)


def test_the_blender_example_converts_as_it_says() -> None:
    theirs, ours = example_of("from-blender.md", "text")
    assert importing.converted(Source("<example>", theirs), word="stool")[0].endswith(ours)


def test_the_example_of_the_authors_python_translates_as_it_says() -> None:
    theirs, ours = example_of("from-paper-python.md", "text")
    assert sl.transpile(theirs).text.strip() == ours.strip()


TRIMESH = """
(define points [[0 0 0] [1 0 0] [0 1 0] [0 0 1]])
(define triangles '((0 2 1) (0 1 3) (1 2 3) (0 3 2)))
(define box (call "cube" :scale 2))
(define ball (call "sphere" :radius 1.2))
(define moved (transform box (translate [4 0 0])))
"""


def trimesh_value(expression: str) -> np.ndarray:
    """Evaluate an expression of trimesh: the volume of a mesh, or the numbers."""
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box(extents=(2, 2, 2))
    names = {
        "trimesh": trimesh, "np": np, "box": box,
        "ball": trimesh.creation.icosphere(radius=1.2, subdivisions=5),
        "moved": box.copy().apply_translation([4, 0, 0]),
        "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    }  # fmt: skip
    try:
        value = eval(expression, names)
    except ModuleNotFoundError as missing:  # trimesh has optional dependencies
        pytest.skip(str(missing))
    return np.asarray(value.volume if isinstance(value, trimesh.Trimesh) else value)


@pytest.mark.parametrize(("theirs", "ours"), rows_of("from-trimesh.md"))
def test_trimesh_and_the_language_agree(theirs: str, ours: str) -> None:
    assert numbers_of(ours, TRIMESH) == pytest.approx(trimesh_value(theirs).ravel().tolist(), rel=SIZED, abs=1e-9)


def test_cameras_and_lights_for_people_from_threejs_are_declared() -> None:
    section = (
        (DOCS / "from-threejs.md").read_text("utf-8").partition("## Camera, light and files")[2].partition("\n## ")[0]
    )
    declared = re.findall(r"^\| [^|]+ \| `(\((?:camera|light|environment|render-settings) .*?\))` \|", section, re.M)
    scene = sl.evaluate("\n".join([*declared, '(bind "box" (lambda () (call "cube")))']))
    forms = [item.form for item in scene.graph.setup]
    assert [form for form in ("camera", "light", "environment", "render-settings") if form in forms] == [
        "camera", "light", "environment", "render-settings"
    ]  # fmt: skip
    assert len(forms) == len(declared) >= 8
    for text in re.findall(r"\| `--camera (\S+?)` \|", section):
        parse_viewpoint(text)


CADQUERY = """
(define block (call "cube" :scale 2))
(define rod (call "cylinder" :radius .5 :p0 [0 0 -1] :p1 [0 0 3]))
"""
# What CadQuery 2.8 computes for the first column, with the same `block` and `rod`: volumes, and the last coordinate of a center.
CADQUERY_VALUES = {
    "cq.Workplane().box(1, 2, 3)": 6,
    "cq.Workplane().sphere(2)": 33.5103,
    "cq.Workplane().cylinder(3, 1)": 9.42478,
    "cq.Workplane().circle(2).extrude(3)": 37.6991,
    "cq.Workplane().rect(4, 2).extrude(1)": 8,
    "cq.Workplane().polygon(6, 4).extrude(1)": 10.3923,
    "cq.Workplane().polyline([(0, 0), (2, 0), (0, 1)]).close().extrude(1)": 1,
    "cq.Workplane().rect(4, 2).circle(.5).extrude(1)": 7.2146,
    "cq.Workplane().rect(2, 2).twistExtrude(3, 90)": 12.0002,
    "cq.Workplane().polyline([(0, 0), (1, 0), (0, 2)]).close().revolve()": 2.0944,
    'cq.Workplane("XY").circle(.5).sweep(cq.Workplane("XZ").lineTo(0, 4))': 3.14159,
    "cq.Workplane().rect(2, 2).workplane(3).rect(1, 1).loft()": 7,
    "block.cut(rod)": 6.4292,
    "block.union(rod)": 9.5708,
    "block.intersect(rod)": 1.5708,
    'block.faces(">Z").workplane().hole(1)': 6.4292,
    "block.edges().fillet(.2)": 7.8047,
    "block.translate((4, 0, 0))": 8,
    "rod.rotate((0, 0, 0), (1, 0, 0), 90)": 3.14159,
    'rod.mirror("YZ")': 3.14159,
    "cq.Workplane().polarArray(3, 0, 360, 6).circle(.5).extrude(1)": 4.71239,
    "cq.Workplane().rarray(2, 3, 4, 2).circle(.5).extrude(1)": 6.28319,
    "block.val().Volume()": 8,
    "rod.val().Center().toTuple()": 1,
}


@pytest.mark.parametrize(("theirs", "ours"), rows_of("from-cadquery.md"))
def test_cadquery_and_the_language_agree(theirs: str, ours: str) -> None:
    assert numbers_of(ours, CADQUERY)[-1] == pytest.approx(CADQUERY_VALUES[theirs], rel=SIZED)


THREEJS = """
(define points [[.5 0] [1 0] [.5 2]])
(define curve (catmull-rom [[0 0 0] [1 1 0] [2 0 0]]))
(define shape (circle 1))
(define material (embedding :color (color "gold")))
(define a (call "cube" :scale 1))
(define b (call "sphere" :radius 1))
"""


# What the triangles of Three.js 0.170 enclose.
THREEJS_VOLUMES = {
    "new BoxGeometry(1, 2, 3)": 6,
    "new SphereGeometry(2, 64, 32)": 33.376,
    "new CylinderGeometry(1, 1, 4, 64)": 12.546,
    "new ConeGeometry(1, 4, 64)": 4.1821,
    "new CapsuleGeometry(1, 4, 16, 64)": 16.726,
    "new TorusGeometry(2, .5, 32, 64)": 9.7906,
    "new ExtrudeGeometry(shape, { depth: 3, bevelEnabled: false })": 9.3175,
}


@pytest.mark.parametrize(("theirs", "ours"), rows_of("from-threejs.md"))
def test_threejs_and_the_language_agree(theirs: str, ours: str) -> None:
    numbers = numbers_of(ours, THREEJS)
    assert numbers
    if theirs in THREEJS_VOLUMES:
        assert numbers == pytest.approx([THREEJS_VOLUMES[theirs]], rel=SIZED)


def test_volumes_of_threejs_are_of_rows() -> None:
    assert set(THREEJS_VOLUMES) <= {row.values[0] for row in rows_of("from-threejs.md")}


PAPER = """
@register()
def part(height=1):
    return primitive_call('cube', shape_kwargs={{'scale': (1, height, 1)}})

@register()
def row():
    return {}
"""


@pytest.mark.parametrize(("theirs", "ours"), rows_of("from-paper-python.md"))
def test_the_authors_python_is_translated_as_the_table_says(theirs: str, ours: str) -> None:
    text = sl.transpile(PAPER.format(theirs), literal=True).text
    assert ours in " ".join(text.split())
    assert sl.evaluate(text).count()["row"] == 1
