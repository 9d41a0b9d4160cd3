"""Blender scripts become scenes with the boxes, volumes and colors that Blender has measured, or are refused by name.

``measures.json`` is written by `python benchmarks/blender_reference.py tests/blender/measures.json
tests/blender/scripts/*.py` in an environment with bpy 5.
"""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from types import ModuleType

import pytest
from support import calls

from scenelang.backends.blender.animating import Curve
from scenelang.backends.blender.importing import converted
from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.session.session import Session

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
SCRIPTS = sorted((HERE / "scripts").glob("*.py"))
MEASURES = json.loads((HERE / "measures.json").read_text("utf-8"))


def comparison() -> ModuleType:
    """The benchmark that compares scripts with Blender."""
    spec = importlib.util.spec_from_file_location("blender_scripts", ROOT / "benchmarks" / "blender_scripts.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def program(script: str) -> str:
    return converted(Source("script.py", f"import bpy\n{script}"))[0]


def refusal(script: str) -> tuple[str, str, str]:
    """The code, the message and the place of a refusal."""
    with pytest.raises(SceneError) as caught:
        program(script)
    assert caught.value.span is not None
    return caught.value.name, caught.value.message, caught.value.span.text


def warnings(script: str) -> list[str]:
    return [d.message for d in converted(Source("script.py", f"import bpy\n{script}"))[1]]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_measures_of_blender(path: Path) -> None:
    kind, reason = comparison().verdict(path, MEASURES[path.name])
    assert kind == "equal", reason


def test_every_measure_is_compared() -> None:
    """A box, a volume or a color that is wrong by one percent is a difference."""
    module = comparison()
    changed = json.loads(json.dumps(MEASURES["primitives.py"]))
    for variant in changed.values():
        for row in variant["frames"]["None"]:
            if row["volume"] is not None:
                row["volume"] *= 1.01
    assert module.verdict(HERE / "scripts" / "primitives.py", changed)[0] == "different"


def test_words_of_functions_and_shared_objects() -> None:
    text = (ROOT / "examples" / "blender" / "chair.py").read_text("utf-8")
    made, found = converted(Source("chair.py", text), "chair")
    assert [line for line in made.splitlines() if line.startswith("(bind")] == [
        f'(bind "{word}"' for word in ("Leg", "Seat", "Cushion", "Back", "chair", "chair scene")
    ]
    assert made.count('(call "chair")') == 3
    assert "(define oak [0.42 0.25 0.11])" in made
    assert found == []


@pytest.mark.parametrize(
    ("script", "named"),
    [
        ("bpy.ops.sculpt.mesh_filter(type='INFLATE')", "`bpy.ops.sculpt.mesh_filter`"),
        ("bpy.data.curves.new('c', 'CURVE')", "curves"),
        ("bpy.data.node_groups.new('g', 'GeometryNodeTree')", "node groups"),
        ("bpy.ops.object.text_add()", "`bpy.ops.object.text_add`"),
        ("bpy.context.object.modifiers.new('m', 'CLOTH')", "`CLOTH`"),
        ("bpy.context.object.constraints.new('COPY_LOCATION')", "constraints"),
        ("bpy.ops.wm.obj_import(filepath='a.obj')", "`bpy.ops.wm.obj_import`"),
        ("bpy.app.handlers.frame_change_pre.append(print)", "`frame_change_pre`"),
        ("bpy.ops.mesh.primitive_monkey_add()", "`bpy.ops.mesh.primitive_monkey_add`"),
    ],
)
def test_what_has_no_counterpart_is_refused_by_name(script: str, named: str) -> None:
    name, message, place = refusal(f"a = 1\n{script}\n")
    assert name == "blender-unsupported"
    assert named in message
    assert script.split("(")[0] in place or "modifiers" in script


def test_mistakes_are_those_of_python() -> None:
    assert refusal("bpy.ops.mesh.primitive_cube_add(sise=2)")[:2] == (
        "python-exception",
        'Python: TypeError: Converting py args to operator properties: keyword "sise" unrecognized',
    )
    assert refusal("bpy.data.objects['Sphere']")[0] == "python-exception"


def test_one_warning_for_what_is_left_out() -> None:
    script = "for i in range(3):\n    bpy.ops.object.light_add()\nbpy.context.object.data.energy = 5\n"
    assert len(warnings(script)) == 1
    assert "lights" in warnings(script)[0]


def test_the_script_is_not_executed() -> None:
    for line in ("import os; os.system('x')", "open('x', 'w')", "__import__('os')", "eval('1')", "import subprocess"):
        name, _, _ = refusal(f"{line}\nsubprocess.run('x')" if "subprocess" in line else line)
        assert name in ("python-forbidden", "python-exception", "blender-unsupported"), line


def test_an_endless_script_ends() -> None:
    assert "too long" in refusal("while True:\n    pass")[1]


def test_curves_are_those_of_blender() -> None:
    """Values that Blender 5 evaluates, with extremes, clamped handles and continuous acceleration."""
    curve = Curve("location", 2)
    for frame, value in ((1, 0), (11, 2), (20, 3), (31, 9), (40, 4), (50, 3.5), (70, -1)):
        curve.insert(frame, value, "BEZIER")
    values = [curve.evaluate(frame) for frame in (3, 6, 9, 15, 17, 25, 28, 35, 45, 48, 60, 65)]
    assert values == pytest.approx(
        [0.16253, 0.82237, 1.61011, 2.26323, 2.39103, 6.0879, 8.10293, 7.0631, 3.70312, 3.648, 0.96875, -0.40234],
        abs=2e-5,
    )


def test_commands_recognise_a_script(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = 'import bpy\nbpy.context.object.name = "Block"\n'
    (tmp_path / "a.py").write_text(script)
    (tmp_path / "answer.txt").write_text(f"Here it is:\n\n```python\n{script}```\nRun it in Blender.\n")
    for name in ("a.py", "answer.txt"):
        assert main(["run", str(tmp_path / name)]) == 0
        assert main(["import", str(tmp_path / name), "-o", str(tmp_path / "out.scene")]) == 0
        assert main(["transpile", str(tmp_path / name)]) == 0
        assert '(bind "Block"' in capsys.readouterr().out
    session = Session()
    assert session.evaluate(session.source(str(tmp_path / "out.scene"))).scene is not None


def test_time_grows_with_the_objects() -> None:
    lines = "for i in range({}):\n    bpy.ops.mesh.primitive_cube_add(location=(i, 0, 0))\n"
    few, many = (calls(lambda n=n: program(lines.format(n))) for n in (50, 200))
    assert many < 6 * few


def test_a_hollow_body_has_its_color() -> None:
    """The inner surface of a solidified box is cut out of the outer one, and both have the material's color."""
    made = program(
        "box = bpy.context.object\n"
        "box.data.materials[0].diffuse_color = (1, 0, 0, 1)\n"
        'box.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.2\n'
    )
    assert re.search(r"\(difference .* :color material\)", " ".join(made.split()))
