"""The cell magic `%%scene` in IPython, and the notebook of the examples in a kernel of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import scenelang as sl

pytest.importorskip("IPython")
ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
TOWER = """(param floors 3 "how high" :min 1 :max 9)
(param paint "#c04030" "its color")
(bind "tower" (lambda () (union-loop floors (lambda (i)
  (transform (call "cube" :color (color paint)) (translate [0 i 0]))))))
"""


@pytest.fixture(scope="module")
def ipython() -> Iterator[Any]:
    from IPython.core.interactiveshell import InteractiveShell

    InteractiveShell.clear_instance()
    shell = InteractiveShell.instance()
    shell.run_line_magic("load_ext", "scenelang")
    yield shell
    InteractiveShell.clear_instance()


@pytest.fixture
def shell(ipython: Any) -> Any:
    ipython.user_ns.pop("scene", None)
    return ipython


def run(shell: Any, line: str, cell: str) -> tuple[list[Any], str, str]:
    """What a cell displays, and what it writes to standard output and error."""
    from IPython.utils.capture import capture_output

    with capture_output() as captured:
        shell.run_cell_magic("scene", line, cell)
    return [output.data for output in captured.outputs], captured.stdout, captured.stderr


def test_a_cell_shows_a_picture_and_keeps_the_scene(shell: Any) -> None:
    shown, _, errors = run(shell, "board --size 96x64", '(bind "board" (lambda () (call "cube")))')
    assert errors == ""
    assert [set(data) >= {"image/png"} for data in shown] == [True]
    assert isinstance(shell.user_ns["board"], sl.Scene)
    assert shell.user_ns["board"].count()["cube"] == 1


def test_a_mistake_is_a_diagnostic_and_keeps_nothing(shell: Any) -> None:
    shown, _, errors = run(shell, "", '(bind "a" (lambda () (call "cube" :scale "big")))')
    assert shown == []
    assert "error[" in errors
    assert "<cell>:1:" in errors
    assert "Traceback" not in errors
    assert "scene" not in shell.user_ns
    for line in ("--size huge", "2x", "class", "--camera up=1", "--quality none", "--frame 9", "'open"):
        shown, _, errors = run(shell, line, TOWER)
        assert shown == [], line
        assert errors.startswith("error"), line
        assert "Traceback" not in errors


def test_printed_lines_and_the_viewer(shell: Any) -> None:
    cell = '(bind "a" (lambda () (print "hello") (call "cube")))'
    shown, printed, _ = run(shell, "--view", cell)
    assert printed == "hello\n"
    assert "iframe" in shown[0]["text/html"]


def test_params_are_controls_that_evaluate_anew(shell: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    widgets = pytest.importorskip("ipywidgets")
    from scenelang.notebook import magic as notebook

    panels: list[Any] = []
    panel = notebook._panel
    monkeypatch.setattr(notebook, "_panel", lambda *a: panels.append(panel(*a)) or panels[-1])
    run(shell, "--size 64x48", TOWER)
    (box,) = panels
    floors, paint, _ = box.children
    assert isinstance(floors, widgets.IntSlider)
    assert (floors.value, floors.min, floors.max) == (3, 1, 9)
    floors.value = 5
    assert shell.user_ns["scene"].count()["cube"] == 5
    paint.value = "#000000"
    assert shell.user_ns["scene"].flatten().color.max() == 0
    assert shell.user_ns["scene"].count()["cube"] == 5


def test_controls_can_be_left_out(shell: Any) -> None:
    shown, _, _ = run(shell, "--no-widgets --size 64x48", TOWER)
    assert "image/png" in shown[0]
    assert shell.user_ns["scene"].params == {"floors": "3", "paint": '"#c04030"'}


A_CELL = 30  # seconds; ten times what one takes on a loaded machine


@pytest.mark.parametrize("path", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_notebooks_of_the_examples_run(path: Path) -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(path, as_version=4)
    # nbclient may miss a reply while it passes the state of widgets on, and looks again when its time for a cell is over.
    nbclient.NotebookClient(notebook, timeout=A_CELL, resources={"metadata": {"path": str(ROOT)}}).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    outputs = [output for cell in cells for output in cell.outputs]
    assert not [output for output in outputs if output.output_type == "error" or output.get("name") == "stderr"]
    kinds = [kind for output in outputs for kind in output.get("data", {})]
    assert kinds.count("image/png") >= 2
    assert "application/vnd.jupyter.widget-view+json" in kinds


def test_there_is_a_notebook() -> None:
    assert NOTEBOOKS
