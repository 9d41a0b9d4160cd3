"""Libraries that programs import: rotations against scipy, noise against recorded numbers, the rest within its table."""

from __future__ import annotations

import ast
import contextlib
import io
import math
import random
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.transpile.analysis.library_rotations import ROTATION, STACKS
from scenelang.interpreter.transpile.evaluation import UnsupportedPython, noise, scientific
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.reference_model import flatten

ROOT = Path(__file__).parents[2]
SESSION = Session()
HEAD = '"""a row of bars"""\nfrom helper import *\nimport math\nimport numpy as np\n'
BAR = """
def bar(x, y=0.0, z=0.0):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': .1}), translation_matrix((x, y, z)))
"""


def program(before: str, body: str) -> str:
    lines = "\n".join(f"    {line}" for line in body.strip("\n").split("\n"))
    return f"{HEAD}{before}\n{BAR}\n@register()\ndef scene(turn: float = 20.0) -> Shape:\n{lines}\n"


def error_of(code: str) -> Diagnostic:
    (problem,) = [d for d in SESSION.transpile(Source("libraries.py", code)).diagnostics if d.is_error]
    return problem


def translated(code: str) -> str:
    """The translation of a program, whose scene is that of CPython."""
    translation = SESSION.transpile(Source("libraries.py", code))
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("libraries.scene", translation.text))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
    with contextlib.redirect_stdout(io.StringIO()):
        expected = flatten(code)
    assert first_difference(flattened(evaluated.scene), expected) is None
    return translation.text


# --- rotations ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rotations() -> Any:
    """The package's own Python, which CPython runs here as the evaluator does elsewhere."""
    names: dict[str, Any] = {"math": math, "np": np, "dataclass": dataclass}
    exec(compile(ROTATION + STACKS, "<rotations>", "exec"), names)
    return names


def pairs(rotations: Any, draw: random.Random) -> Any:
    """A rotation of each kind: scipy's, and the package's."""
    transform = pytest.importorskip("scipy.spatial.transform")
    scipys, own = transform.Rotation, rotations["Rotation"]
    axes = draw.choice(["xyz", "zyx", "XYZ", "ZXZ", "yxy", "x", "Z", "xz"])
    angles: Any = [draw.choice([draw.uniform(-400, 400), 0, 90, 180]) for _ in axes]
    angles = angles[0] if len(axes) == 1 else angles
    vector = [draw.gauss(0, draw.choice([1, 1e-5])) for _ in range(4)]
    return draw.choice([
        lambda: [each.from_euler(axes, angles, degrees=True) for each in (scipys, own)],
        lambda: [each.from_rotvec(vector[:3]) for each in (scipys, own)],
        lambda: [each.from_quat(vector) for each in (scipys, own)],
        lambda: [each.from_matrix(scipys.from_quat(vector).as_matrix()) for each in (scipys, own)],
        lambda: [each.from_euler("zyx", [90, 90, 30], degrees=True) for each in (scipys, own)],
    ])()  # fmt: skip


def test_rotations_are_those_of_scipy(rotations: Any) -> None:
    draw = random.Random(5)
    for _ in range(300):
        (a, b), (c, d) = pairs(rotations, draw), pairs(rotations, draw)
        for theirs, ours in ((a * c, b * d), (a.inv(), b.inv()), (a**0.3, b**0.3), (a**2 * c, b**2 * d)):
            for method in ("as_quat", "as_rotvec", "as_matrix", "magnitude"):
                assert np.allclose(getattr(theirs, method)(), getattr(ours, method)(), atol=1e-9), method
            assert np.allclose(theirs.as_quat(canonical=True, scalar_first=True), ours.as_quat(True, scalar_first=True))
            assert np.allclose(theirs.apply([[1, 2, 3]] * 2, inverse=True), ours.apply([[1, 2, 3]] * 2, inverse=True))


@pytest.mark.parametrize("axes", ["xyz", "zyx", "XYZ", "ZYX", "zxz", "YXY"])
@pytest.mark.filterwarnings("ignore:Gimbal")
def test_angles_of_rotations_are_those_of_scipy(rotations: Any, axes: str) -> None:
    draw = random.Random(axes)
    for _ in range(60):
        theirs, ours = pairs(rotations, draw)
        found = theirs.as_euler(axes, degrees=True), ours.as_euler(axes, degrees=True)
        turned = [type(ours).from_euler(axes, each, degrees=True) for each in found]
        assert turned[0].approx_equal(turned[1], 1e-6)
        if min(abs(found[0][1] % 180), abs(found[0][1] % 180 - 90)) > 1e-3:  # else several angles turn alike
            assert np.allclose(*found, atol=1e-6)


def test_stacks_of_rotations_are_those_of_scipy(rotations: Any) -> None:
    transform = pytest.importorskip("scipy.spatial.transform")
    draw = random.Random(3)
    quaternions = [[draw.gauss(0, 1) for _ in range(4)] for _ in range(6)]
    points = [[draw.gauss(0, 1) for _ in range(3)] for _ in range(6)]
    for_each = []
    for R, Slerp in ((transform.Rotation, transform.Slerp), (rotations["Rotation"], rotations["Slerp"])):
        stack, one = R.from_quat(quaternions), R.from_euler("x", 20, degrees=True)
        for_each.append([
            stack.as_matrix(), (stack * one).as_quat(), (one * stack).as_rotvec(), stack.inv().as_euler("xyz"),
            stack.apply(points), stack.apply(points[0]), one.apply(points), stack[2].as_quat(), stack[1:3].as_quat(),
            stack.magnitude(), stack.mean().as_matrix(), Slerp(range(6), stack)([0, 0.3, 2, 4.9, 5]).as_matrix(),
            Slerp(range(6), stack)(1.5).as_matrix(), R.random(3, random_state=4).as_quat(), R.random(rng=7).as_matrix(),
            R.align_vectors(points, stack.apply(points))[0].as_matrix(), R.align_vectors([points[0]], [[0, 0, 1]])[1],
            R.align_vectors([points[0]], [[0, 0, 1]])[0].as_matrix(), R.align_vectors([[0, 0, -1]], [[0, 0, 1]])[0].as_matrix(),
            R.from_euler("y", [[10], [20]], degrees=True).as_quat(), R.from_matrix(np.eye(3) + 0.1).as_matrix(),
            R.identity(2).as_quat(), R.concatenate([one, stack]).as_quat(), len(stack),
            *(each.as_quat() for each in stack),
        ])  # fmt: skip
    for theirs, ours in zip(*for_each):
        assert np.allclose(theirs, ours, atol=1e-9)


ROTATED = """
import numpy as np
from scipy.spatial.transform import Rotation as R
"""


def test_a_rotation_is_translated_with_its_angle_as_a_parameter() -> None:
    pytest.importorskip("scipy")
    code = program(
        ROTATED,
        "spin = R.from_euler('zy', [turn, 10], degrees=True) * R.from_rotvec([0, 0, .3]).inv()\n"
        "axis = spin.as_rotvec()\n"
        "return concat_shapes(bar(*spin.apply([1, 2, 3])), bar(*axis), bar(spin.magnitude(), *spin.as_euler('xyz')[:2]))",
    )
    text = translated(code)
    assert "Evaluated from Python" not in text
    assert "define-record rotation" in text
    evaluated = SESSION.evaluate(Source("turned.scene", text.replace("(param turn 20.0", "(param turn 35.0")))
    assert evaluated.scene is not None
    assert "(param turn 20.0" in text
    assert first_difference(flattened(evaluated.scene), flatten(code, call=("scene", {"turn": 35.0}))) is None


@pytest.mark.parametrize("rotation", [
    "R.from_euler('y', [[turn], [30]], degrees=True)[1]", "R.from_rotvec([[0, 0, 1], [0, turn / 9, 0]])[1]",
    "R.from_matrix(np.eye(3) + .05)", "R.align_vectors([[1, 2, 3]], [[0, 0, 1]])[0]",
])  # fmt: skip
def test_what_is_no_single_rotation_is_evaluated(rotation: str) -> None:
    pytest.importorskip("scipy")
    translated(program(ROTATED, f"return bar(*{rotation}.apply([1, 2, 3]))"))


def test_what_is_not_known_of_rotations_is_no_mistake_of_the_program() -> None:
    problem = error_of(program(ROTATED, "return bar(R.from_euler('x', 3).as_davenport([], 'e', 3)[0])"))
    assert (problem.name, problem.message) == ("python-unsupported", "`as_davenport` of a Rotation is not supported")
    wrong = program(ROTATED, "return bar(R.from_euler('xw', [1, 2]).magnitude())")
    (problem,) = [d for d in SESSION.evaluate(Source("wrong.py", wrong)).diagnostics if d.is_error]
    assert problem.name == "python-exception"
    assert problem.span is not None
    assert "from_euler" in problem.span.text


# --- noise ----------------------------------------------------------------------------------------------------------


def test_noise_is_that_of_the_packages() -> None:
    """Recorded from noise 1.2.2, opensimplex 0.4.5.1 and perlin_noise 1.14."""
    steps = range(4)
    simplex, perlin = noise.OpenSimplex(42), noise.PerlinNoise(octaves=3.5, seed=7)
    layered = {"persistence": 0.4, "lacunarity": 1.9, "repeatx": 8, "repeaty": 5, "base": 3}
    found = {
        "pnoise1": [noise.pnoise1(x * 0.37 - 1, octaves=3) for x in steps],
        "pnoise2": [noise.pnoise2(x * 0.37 - 1, x * 0.21, octaves=4, **layered) for x in steps],
        "pnoise3": [noise.pnoise3(x * 0.37 - 1, x * 0.21, 0.7, octaves=2) for x in steps],
        "snoise2": [noise.snoise2(x * 0.37 - 1, x * 0.21, octaves=3, base=2.5) for x in steps],
        "snoise3": [noise.snoise3(x * 0.37 - 1, x * 0.21, 0.7) for x in steps],
        "noise2": [simplex.noise2(x * 0.77 - 1, x * 0.31) for x in steps],
        "noise3": [simplex.noise3(x * 0.77 - 1, x * 0.31, x * 0.53) for x in range(12)],
        "perlin": [perlin([x * 0.37 - 1, x * 0.21]) for x in steps] + [perlin(0.3)],
    }
    recorded = {
        "pnoise1": [0.0, -0.139900222, -0.40830788, 0.486692518],
        "pnoise2": [0.043035265, 0.040652171, -0.234171823, -0.143236578],
        "pnoise3": [-0.063760012, -0.119083166, 0.058202516, 0.006668776],
        "snoise2": [-0.085196435, 0.096738838, 0.062277231, -0.077709608],
        "snoise3": [0.053742953, -0.298840672, -0.609770477, 0.190323204],
        "noise2": [-0.490629796562, -0.064048840156, -0.27278506304, -0.441685770074],
        "noise3": [
            0.435614686963, 0.389757736899, -0.535342990142, -0.256722399798, 0.279698923433, -0.053557878107,
            0.34371221237, -0.631575676145, -0.433955008258, 0.186875133795, 0.206351965976, 0.085051209931,
        ],
        "perlin": [0.029060471066, 0.095197025973, 0.142715603691, 0.158049085232, -0.038534354331],
    }  # fmt: skip
    for name, values in recorded.items():
        assert found[name] == pytest.approx(values, abs=1e-6), name


def test_noise_beyond_the_tables_of_the_package_is_no_number() -> None:
    with pytest.raises(UnsupportedPython, match="reads past the end"):
        noise.pnoise2(200.5, 200.5, base=300)
    with pytest.raises(UnsupportedPython, match="without a seed"):
        noise.PerlinNoise(octaves=3)


def test_noise_of_a_program_follows_its_seed() -> None:
    imported = "import opensimplex"
    body = "opensimplex.seed({})\nh = opensimplex.noise2(.3, .4)\nopensimplex.seed(2)\nreturn bar(h, opensimplex.noise2(.3, .4))"
    texts = []
    for seed in (1, 5):
        translation = SESSION.transpile(Source("noise.py", program(imported, body.format(seed))))
        evaluated = SESSION.evaluate(Source("noise.scene", translation.text))
        assert evaluated.scene is not None
        place = np.array(flattened(evaluated.scene)["frames"][0]["primitives"][0]["matrix"])[:2, 3]
        expected = noise.OpenSimplex(seed).noise2(0.3, 0.4), noise.OpenSimplex(2).noise2(0.3, 0.4)
        assert place == pytest.approx(expected, abs=1e-6)
        texts.append(translation.text)
    assert texts[0] != texts[1]


# --- other libraries ------------------------------------------------------------------------------------------------

HULL = "from scipy.spatial import ConvexHull\nPOINTS = np.random.default_rng(1).random((9, 2))\n"
VALID = {
    "a hull": (HULL, "hull = ConvexHull(POINTS)\nreturn concat_shapes(*[bar(*POINTS[i]) for i in hull.vertices], bar(hull.area))"),
    "a module of a package": ("import scipy.spatial as sp", "tree = sp.KDTree([[0, 0], [1, 2], [3, 1]])\n"
        "d, i = tree.query([1, 1], k=2)\nreturn bar(float(d[1]), int(i[0]))"),
    "a package": ("from scipy import spatial", "return bar(*spatial.Delaunay([[0, 0], [1, 0], [0, 1]]).simplices[0])"),
    "a spline": ("from scipy.interpolate import CubicSpline, splprep, splev",
        "c = CubicSpline([0, 1, 2], [[0, 0], [1, 3], [2, 1]])\ntck, _ = splprep([[0, 1, 2, 3], [0, 2, 1, 0]], s=0)\n"
        "x, y = splev(.4, tck)\nreturn concat_shapes(*[bar(*c(t)) for t in (.1, 1.5)], bar(float(x), float(y)), bar(*c(.5, 1)))"),
    "a fill": ("from scipy.ndimage import label", "_, n = label(np.array([[1, 0, 1], [1, 0, 0]]))\nreturn bar(n)"),
    "a polygon with a hole": ("from shapely.geometry import Polygon, box", "p = Polygon([(0, 0), (4, 0), (4, 3), (0, 3)]).difference(box(1, 1, 2, 2))\n"
        "return concat_shapes(bar(p.area), bar(p.length, len(p.interiors)))"),
    "a polygon": ("from shapely.geometry import Polygon, Point", "p = Polygon([(0, 0), (3, 0), (0, 3)]).buffer(.1) - Point(1, 1).buffer(.5)\n"
        "return concat_shapes(*[bar(x, y) for x, y in list(p.exterior.coords)[::7]], bar(p.area, p.centroid.x, len(p.interiors)))"),
    "a graph": ("import networkx as nx", "g = nx.Graph()\ng.add_weighted_edges_from([('a', 'b', 2), ('b', 'c', 1), ('a', 'c', 4)])\n"
        "t = nx.minimum_spanning_tree(g)\nw = [d['weight'] for _, _, d in t.edges(data=True)]\n"
        "return bar(sum(w), nx.shortest_path_length(g, 'a', 'c', weight='weight'), len(g['a']))"),
    "a solid": ("import trimesh", "m = trimesh.creation.icosphere(subdivisions=1, radius=2)\n"
        "return concat_shapes(*[bar(*v) for v in m.vertices[:5]], bar(len(m.faces)))"),
}  # fmt: skip


@pytest.mark.parametrize("name", VALID)
def test_a_library_computes_what_it_does_in_cpython(name: str) -> None:
    before, body = VALID[name]
    pytest.importorskip(before.split()[1].partition(".")[0])
    translated(program(before, body))


REFUSED = {
    "another module": ("from scipy.optimize import brentq", "return bar(brentq(abs, 0, 1))", "the module `scipy.optimize` cannot"),
    "another function": ("from scipy import spatial", "return bar(spatial.geometric_slerp([0], [1], 3))",
        "`scipy.spatial.geometric_slerp` is not supported"),
    "files": ("import networkx as nx", "nx.write_gml(nx.path_graph(3), 'x')\nreturn bar(1)", "`networkx.write_gml` is not"),
    "meshes of files": ("import trimesh", "return bar(trimesh.load('x.stl').volume)", "`trimesh.load` is not supported"),
    "what a class does not show": (HULL, "return bar(ConvexHull(POINTS)._qhull.x)", "'ConvexHull' object has no"),
    "another attribute": (HULL, "return bar(ConvexHull(POINTS).add_points([[1, 2]]))", "`add_points` of a ConvexHull is not"),
    "many points": ("from scipy.spatial import KDTree", "return bar(KDTree(np.zeros((30000, 3))).n)", "this call of `scipy.spatial.KDTree`"),
    "many coordinates": (HULL, "return bar(ConvexHull(np.eye(9)).area)", "`scipy.spatial.ConvexHull` of points with more"),
    "many pairs": ("from scipy.spatial import KDTree", "return bar(len(KDTree(np.zeros((3000, 2))).query_pairs(1.)))", "this call of `query_pairs`"),
    "a large solid": ("import trimesh", "return bar(trimesh.creation.icosphere(subdivisions=12).area)", "this call of `trimesh.creation.icosphere`"),
    "a large graph": ("import networkx as nx", "return bar(len(nx.balanced_tree(9, 30)))", "this call of `networkx.balanced_tree`"),
    "a graph by chance": ("import networkx as nx", "return bar(len(nx.gnp_random_graph(9, .5).edges))", "`networkx.gnp_random_graph` without a seed"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_in_the_table_is_refused(name: str) -> None:
    before, body, message = REFUSED[name]
    pytest.importorskip(before.split()[1].partition(".")[0])
    problem = error_of(program(before, body))
    assert message in problem.message
    assert "\n" not in problem.message
    assert problem.span is not None


def test_a_missing_library_is_told_with_the_command_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(package: str, install: str) -> None:
        raise SceneError(
            "backend", f"the package `{package}` cannot be imported", hint=f"install it with `pip install {install}`"
        )

    monkeypatch.setattr(scientific, "require", missing)
    problem = error_of(program(HULL, "return bar(ConvexHull(POINTS).area)"))
    assert problem.message == "the module `scipy.spatial` needs `python-libraries`"
    assert problem.hint == "install it with `pip install 'scenelang[python-libraries]'`"


def test_a_graph_that_changes_is_no_constant() -> None:
    pytest.importorskip("networkx")
    text = translated(program(
        "import networkx as nx\nG = nx.path_graph(3)",
        "sizes = []\nfor i in range(3):\n    G.add_edge(i, i + 9)\n    sizes.append(G.number_of_edges())\n"
        "return concat_shapes(*[bar(n, i) for i, n in enumerate(sizes)])",
    ))  # fmt: skip
    assert "5" in text


def test_no_library_reads_a_clock_or_files() -> None:
    """What the tables name takes no file, and neither module of libraries asks for the time."""
    for path in (ROOT / "interpreter" / "transpile" / "evaluation" / f"{name}.py" for name in ("noise", "scientific")):
        imported = {
            name.partition(".")[0]
            for node in ast.walk(ast.parse(path.read_text("utf-8")))
            if isinstance(node, (ast.Import, ast.ImportFrom))
            for name in ([each.name for each in node.names] if isinstance(node, ast.Import) else [node.module or ""])
        }
        assert not imported & {"time", "datetime", "os", "pathlib", "io", "subprocess", "socket"}, path.name
    names = {name for row in scientific.FUNCTIONS.values() for name in row.split()}
    names |= {name for row in scientific.CLASSES.values() for name in row.attributes}
    assert len(names) > 150
    assert not [name for name in names if name.startswith(("read", "write", "load", "save", "export", "draw", "plot"))]
