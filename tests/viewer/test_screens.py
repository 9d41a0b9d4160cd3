"""The studio on screens of many sizes: what fits, what is in view, what the selection leaves as it is."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from viewer.test_studio import _open, _text, _until
from viewer.test_studio_page import _seen_at
from viewer.test_studio_page import still as still
from viewer.test_studio_page import studio as studio

pytestmark = pytest.mark.browser

DEEP = """(bind "lamp with a shade" (lambda () (union (call "cone") (call "cube"))))
(bind "desk of oak" (lambda () (union (call "lamp with a shade") (transform (call "cube") (translate [2 0 0])))))
(bind "study" (lambda () (union (call "desk of oak") (call "sphere"))))
(bind "furnished house" (lambda () (union (call "study") (transform (call "cube") (translate [4 0 0])))))
"""
# The extent of the scene's box in the picture, which goes from -1 to 1, and what the page says that it shows.
EXTENT = """() => {
  const { viewpoint, stage, packet: { box } } = scenelangPage;
  const [low, high] = [box.low, box.high].map((corner) => scenelangPage.staged(corner));
  viewpoint.apply();
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => stage.outline.box.min.clone().set(...[0, 1, 2].map((i) => (bits & (1 << i) ? high : low)[i])).project(viewpoint.camera));
  return Math.max(...corners.flatMap(({ x, y }) => [Math.abs(x), Math.abs(y)]));
}"""
SPOTS = """() => [...document.querySelectorAll('#breadcrumb button, #tools button, #tools input')].map((each) => {
  const { left, top, right, bottom } = each.getBoundingClientRect();
  return [left, top, right, bottom];
})"""


def _row(count: int) -> str:
    return f'(bind "row" (lambda () (union-loop {count} (lambda (i) (transform (call "cube") (translate [(* 2 i) 0 0]))))))\n'


def _write(shown: Any, text: str) -> None:
    """Replace the program, and wait until its picture is there."""
    shown.after(lambda: shown.page.evaluate("(text) => scenelangPage.editor.replace(text)", text))
    shown.page.wait_for_timeout(150)


def _extent(shown: Any) -> float:
    return float(shown.page.evaluate(EXTENT))


# --- what is in view


def test_a_scene_that_grows_stays_in_view(studio: Any, program: Any, show: Any) -> None:
    """As long as a person has only turned the view of the whole; a view that was zoomed stays."""
    shown = _open(show, studio(program(_row(1))), (900, 500))
    page = shown.page
    page.focus("#canvas")
    for _ in range(4):
        page.keyboard.press("ArrowLeft")
    azimuth = page.evaluate("scenelangPage.viewpoint.azimuth")
    for count in (2, 3, 8):
        _write(shown, _row(count))
        assert _extent(shown) < 1
    assert page.evaluate("scenelangPage.viewpoint.azimuth") == azimuth
    page.keyboard.press("+")
    page.keyboard.press("+")
    near = page.evaluate("scenelangPage.viewpoint.saved()")
    scale = page.evaluate("scenelangPage.packet.box.scale")
    _write(shown, _row(9))
    after = page.evaluate("scenelangPage.viewpoint.saved()")
    ratio = page.evaluate("scenelangPage.packet.box.scale") / scale
    assert after["distance"] == pytest.approx(near["distance"] * ratio)


def test_a_part_that_leaves_the_view_a_little_is_framed(studio: Any, program: Any, show: Any) -> None:
    text = '(bind "a" (lambda () (union (call "cube") (transform (call "cube" :scale .2) (translate [0 HIGH 0])))))\n'
    shown = _open(show, studio(program(text.replace("HIGH", ".6"))), (900, 500))
    for high in (".7", ".8", ".9", "1"):
        _write(shown, text.replace("HIGH", high))
        assert _extent(shown) < 1


def test_the_whole_scene_is_framed_in_a_picture_of_another_shape(studio: Any, program: Any, show: Any) -> None:
    """A phone whose panel is closed, or which is turned."""
    shown = _open(show, studio(program(_row(4))), (390, 844))
    page = shown.page
    page.click("[data-sheet=code]")
    _until(shown, f"0.85 < ({EXTENT})()")
    assert _extent(shown) < 1
    page.set_viewport_size({"width": 844, "height": 390})
    _until(shown, f"0.85 < ({EXTENT})()")
    assert _extent(shown) < 1


# --- what is over the picture and the text


@pytest.mark.parametrize("width", [320, 390, 600, 801, 900, 1040, 1280, 1440])
def test_nothing_covers_the_path_of_the_selection(studio: Any, program: Any, show: Any, width: int) -> None:
    shown = _open(show, studio(program(DEEP)), (width, 700))
    shown.page.evaluate("scenelangPage.select([0, 0, 0, 0])")
    spots = np.array(shown.page.evaluate(SPOTS))
    view = shown.page.locator("#viewport").bounding_box()
    assert len(spots) == 12
    assert (spots[:, 0] >= view["x"] - 0.5).all()
    assert (spots[:, 2] <= view["x"] + view["width"] + 0.5).all()
    overlaps = np.minimum(spots[:, None, 2:], spots[None, :, 2:]) - np.maximum(spots[:, None, :2], spots[None, :, :2])
    covered = (overlaps > 0.5).all(axis=2)
    assert covered.sum() == len(spots)  # each one itself alone


@pytest.mark.parametrize("size", [(1440, 900), (900, 300), (390, 844)])
@pytest.mark.parametrize("line", [0, 4, 9])
def test_help_at_a_name_is_not_cut_off(studio: Any, program: Any, show: Any, size: tuple[int, int], line: int) -> None:
    lines = ["; a comment"] * 10
    lines[line] = '(define wheel (ring 6 (call "sphere" :radius .3) :radius 2))'
    shown = _open(show, studio(program("\n".join([*lines, '(bind "a" (lambda () (call "cube")))\n']))), size)
    page = shown.page
    x, y = page.evaluate(
        """() => {
          const { view, text } = scenelangPage.editor;
          const at = view.coordsAtPos(text.indexOf('ring') + 2);
          return [at.left, (at.top + at.bottom) / 2];
        }"""
    )
    page.mouse.move(x, y)
    page.mouse.move(x + 1, y)
    _until(
        shown, "document.querySelector('.cm-tooltip-hover')?.getBoundingClientRect().top > -5000"
    )  # else not placed yet
    box = page.locator(".cm-tooltip-hover").bounding_box()
    assert box["x"] >= 0
    assert box["y"] >= 0
    assert box["x"] + box["width"] <= size[0]
    assert box["y"] + box["height"] <= size[1]


@pytest.mark.parametrize("width", [390, 768, 900, 1440])
def test_params_and_camera_are_within_reach(studio: Any, program: Any, show: Any, width: int) -> None:
    shown = _open(
        show, studio(program('(param size 1.0)\n(bind "a" (lambda () (call "cube" :scale size)))\n')), (width, 800)
    )
    page = shown.page
    if not page.is_visible("#params input"):
        page.click("[data-sheet=right]" if width <= 800 else "#toggle-right")
    assert page.is_visible("#params input")
    page.click("#copy-json")
    assert '"scenelang-camera"' in page.evaluate("navigator.clipboard.readText()")


def test_only_the_names_of_files_are_shown(studio: Any, program: Any, show: Any, tmp_path: Any) -> None:
    shown = _open(show, studio(program('(import "missing.scene")\n(bind "a" (lambda () (call "cube")))\n')))
    assert shown.text("#file-name") == "a.scene"
    assert "there is no file missing.scene" in shown.text("#diagnostics")
    assert str(tmp_path) not in shown.text("body")
    _write(shown, '(bind "a" (lambda () (call "cube")))\n')
    shown.page.evaluate("scenelangPage.select([0])")
    shown.page.evaluate("scenelangPage.editor.replace('')")
    shown.page.evaluate("scenelangPage.changeSelection({ remove: true })")
    assert shown.text("#status").startswith("a.scene is empty")
    assert all("409" in complaint for complaint in shown.complaints)  # the refusal, which the console notes
    shown.complaints.clear()


@pytest.mark.parametrize("width", [390, 768, 1100, 1440])
def test_what_comes_and_goes_leaves_the_picture_as_it_is(studio: Any, program: Any, show: Any, width: int) -> None:
    """An evaluation that takes long does not change the height of the picture."""
    shown = _open(show, studio(program(DEEP)), (width, 700))
    page = shown.page
    before = page.locator("#viewport").bounding_box()
    page.evaluate("() => { for (const id of ['busy', 'stop']) document.getElementById(id).hidden = false; }")
    assert page.is_visible("#stop")
    assert page.locator("#viewport").bounding_box() == before


def test_a_canvas_of_another_size_is_drawn_at_once(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program(DEEP)), (900, 600))
    drawn = shown.page.evaluate(
        """() => {
          const canvas = document.getElementById('canvas');
          const before = canvas.toDataURL();
          scenelangPage.viewport.style.flex = '0 0 300px';
          scenelangPage.resize();
          const { width, height } = canvas;
          const copy = Object.assign(document.createElement('canvas'), { width, height });
          copy.getContext('2d').drawImage(canvas, 0, 0);
          const { data } = copy.getContext('2d').getImageData(0, 0, width, height);
          return data.filter((value, i) => i % 4 === 3 && value === 255).length / (width * height);
        }"""
    )
    assert drawn == 1.0


def test_long_words_and_deep_paths_fit(studio: Any, program: Any, show: Any) -> None:
    levels = "".join(
        f'(bind "level {i}" (lambda () (union (call "level {i - 1}") (transform (call "cube") (translate [{i} 0 0])))))\n'
        for i in range(1, 20)
    )
    long = "w" * 300
    text = f'(bind "level 0" (lambda () (call "cube")))\n{levels}(bind "{long}" (lambda () (union (call "level 19") (call "cube"))))\n'
    shown = _open(show, studio(program(text)), (390, 844))
    page = shown.page
    page.evaluate("scenelangPage.select(Array(21).fill(0))")
    spots = np.array(page.evaluate(SPOTS))
    assert spots[:, 2].max() <= 390
    assert page.locator("#breadcrumb").bounding_box()["height"] <= 66
    last, bar = (page.locator(each).bounding_box() for each in ("#breadcrumb button[aria-current]", "#breadcrumb"))
    assert last["y"] + last["height"] <= bar["y"] + bar["height"] + 1


# --- the selection


def test_the_selection_leaves_colors_as_they_are(studio: Any, program: Any, show: Any) -> None:
    """A line goes around the selected object; what is inside it keeps its color, also where another object hides it."""
    text = """(bind "a" (lambda () (union
      (call "cube" :color (color "tomato"))
      (transform (call "sphere" :radius .5 :color (color "gold")) (translate [1.5 0 0])))))\n"""
    shown = _open(show, studio(program(text)), (900, 500))
    before = shown.picture().astype(int)
    ball = (before[:, :, 0] > 120) & (before[:, :, 1] > 90) & (before[:, :, 2] < 80)
    assert ball.sum() > 1000
    shown.page.evaluate("scenelangPage.select([1])")
    shown.settled()
    shown.page.evaluate("scenelangPage.stage.outline.visible = false")  # the box
    shown.page.evaluate("scenelangPage.draw()")
    shown.settled()
    after = shown.picture().astype(int)
    differs = np.abs(after - before).max(axis=2) > 8
    is_line = (after[:, :, 2] > 150) & (after[:, :, 0] < 110)
    assert (is_line & differs).sum() > 200
    inner = ball.copy()
    for shift in range(1, 4):  # without the soft edge
        for axis in (0, 1):
            inner &= np.roll(ball, shift, axis) & np.roll(ball, -shift, axis)
    assert (differs & inner).mean() == 0


# --- numbers in the text


@pytest.mark.parametrize(
    ("number", "pixels", "expected"),
    [(".5", 8, ".7"), ("-.5", 40, ".5"), ("1e-3", 8, "0.003"), ("2.00", -8, "1.98"), (".1", -4, ".0")],
)
def test_a_dragged_number_is_written_as_it_was(
    studio: Any, program: Any, show: Any, number: str, pixels: int, expected: str
) -> None:
    text = f'(bind "a" (lambda () (transform (call "cube") (translate [0 {number} 0]))))\n'
    shown = _open(show, studio(program(text)))
    page = shown.page
    x, y = page.evaluate(
        """(number) => {
          const { view, text } = scenelangPage.editor;
          const at = view.coordsAtPos(text.indexOf(`[0 ${number}`) + 4);
          return [at.left, (at.top + at.bottom) / 2];
        }""",
        number,
    )
    page.keyboard.down("Alt")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + pixels, y, steps=4)
    page.mouse.up()
    page.keyboard.up("Alt")
    assert _text(shown) == text.replace(f"[0 {number} 0]", f"[0 {expected} 0]")
    _until(shown, "!scenelangPage.isEvaluating")


# --- keys and fingers

PAIR = """(param size 1.0 :min .5 :max 2)
(define-syntax ball (syntax-rules () ((_ x r) (transform (call "sphere" :radius r :color (color "gold")) (translate [x 0 0])))))
(bind "a" (lambda () (union (call "cube" :scale size :color (color "tomato")) (ball 2 .5))))
"""


def test_objects_are_changed_by_keys_alone(studio: Any, program: Any, show: Any) -> None:
    """From the cursor in the text to the buttons of the selection, where keys do what the handles do."""
    shown = _open(show, studio(program(PAIR)), (1200, 700))
    page = shown.page
    page.focus(".cm-content")
    page.evaluate(
        "scenelangPage.editor.view.dispatch({ selection: { anchor: scenelangPage.editor.text.indexOf('ball 2') } })"
    )
    _until(shown, "scenelangPage.selection?.[0] === 1")
    page.keyboard.press("Escape")
    for _ in range(12):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.dataset.mode") == "move":
            break
    assert page.evaluate("document.activeElement.dataset.mode") == "move"
    assert page.evaluate("scenelangPage.selection") == [1]
    step = page.evaluate("5 * 10 ** Math.floor(Math.log10(0.01 / scenelangPage.packet.box.scale))")
    page.keyboard.press("ArrowRight")
    moved = PAIR.replace("(ball 2 .5)", f"(ball {2 + step:g} .5)")
    _until(shown, f"scenelangPage.editor.text === {json.dumps(moved)}")
    _until(shown, "!scenelangPage.isChanging && !scenelangPage.isEvaluating")
    for _ in range(4):  # faster than they are made
        page.keyboard.press("Shift+ArrowLeft")
    moved = PAIR.replace("(ball 2 .5)", f"(ball {2 + step / 5:g} .5)")
    _until(shown, f"scenelangPage.editor.text === {json.dumps(moved)}")
    _until(shown, "!scenelangPage.isChanging && !scenelangPage.isEvaluating")
    page.focus("[data-mode=scale]")
    page.keyboard.press("ArrowUp")
    _until(shown, f"scenelangPage.editor.text.includes('(ball {2 + step / 5:g} .55)')")


def test_fingers_turn_select_zoom_and_drag(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program(PAIR)), (390, 844))
    page = shown.page
    touch = shown.context.new_cdp_session(page)

    def put(kind: str, *points: tuple[float, float]) -> None:
        places = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    def view() -> Any:
        return page.evaluate("scenelangPage.viewpoint.saved()")

    start = view()
    box = page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] - 40
    put("touchStart", (x, y))
    for k in range(5):
        put("touchMove", (x + 8 * k, y))
    put("touchEnd")
    assert view()["azimuth"] != start["azimuth"]
    assert page.evaluate("scenelangPage.selection") is None
    near = view()["distance"]
    put("touchStart", (x - 30, y), (x + 30, y))
    for k in range(5):
        put("touchMove", (x - 30 - 8 * k, y), (x + 30 + 8 * k, y))
    put("touchEnd")
    assert view()["distance"] < near
    assert page.evaluate("visualViewport.scale") == 1
    page.evaluate("scenelangPage.setView('default')")
    x, y = _seen_at(shown, [2.0, 0.0, 0.0])
    put("touchStart", (x, y))
    put("touchEnd")
    _until(shown, "scenelangPage.selection?.[0] === 1")
    page.click("[data-mode=move]")
    shown.settled()
    before = view()
    (x0, y0), (x1, y1) = page.evaluate(
        """() => {
          const { gizmo, viewpoint } = scenelangPage;
          const box = document.getElementById('canvas').getBoundingClientRect();
          const length = 0.38 * viewpoint.tangent * viewpoint.camera.position.distanceTo(gizmo.anchor.position); // of the arrow
          return [0.5, 1.2].map((share) => {
            const v = gizmo.anchor.position.clone();
            v.y += share * length;
            v.project(viewpoint.camera);
            return [box.left + (v.x + 1) / 2 * box.width, box.top + (1 - v.y) / 2 * box.height];
          });
        }"""
    )
    put("touchStart", (x0, y0))
    for k in range(1, 9):
        put("touchMove", (x0 + (x1 - x0) * k / 8, y0 + (y1 - y0) * k / 8))
    put("touchEnd")
    _until(shown, f"scenelangPage.editor.text !== {json.dumps(PAIR)}")
    assert view()["azimuth"] == before["azimuth"]  # the view stays while an object is dragged
    assert view()["elevation"] == before["elevation"]
