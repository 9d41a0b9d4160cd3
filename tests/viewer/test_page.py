"""The page in a browser: what an artist does with it (`make test-browser`)."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import interruptible

from scenelang.api import load
from scenelang.backends.pictures.camera import Viewpoint, camera_from_json, parse_viewpoint
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.backends.pictures.stage import still
from scenelang.cli.main import main
from scenelang.interpreter.inspection.numbering import primitive_handles
from scenelang.interpreter.scene.flatten import flatten

pytestmark = pytest.mark.browser

Show = Callable[..., Any]
PAIR = """(param size 1.0 "how large the ball is" :min 0.2 :max 1.5)
(param tint [.8 .1 .1] "the ball's color")
(param doubled (* 2 size))
(bind "ball" (lambda () (call "sphere" :radius size :color tint)))
(bind "box" (lambda () (transform (call "cube" :color [.1 .2 .8]) (translate [3 0 0]))))
(bind "pair" (lambda () (union (call "ball") (call "box"))))
"""
FILM = """(bind "mover" (lambda ()
  (frames (for/list ((i 4)) (union (transform (call "cube" :color [.8 .1 .1]) (translate (list (* 2 i) 0 0)))
                                   (transform (call "sphere" :color [.1 .1 .8]) (translate [0 3 0])))))))
"""


def red(picture: Any) -> Any:
    return (picture[:, :, 0].astype(int) - picture[:, :, 2]) > 60


def blue(picture: Any) -> Any:
    return (picture[:, :, 2].astype(int) - picture[:, :, 0]) > 60


def test_the_page_shows_meshes_and_loads_only_from_its_server(program: Show, serve: Show, show: Show) -> None:
    server = serve(program(PAIR))
    page = show(server.address).ready()
    picture = page.picture()
    assert red(picture).sum() > 2000
    assert blue(picture).sum() > 1000
    assert np.ptp(picture[5:20, 5:20].reshape(-1, 3), axis=0).max() < 8, "the corner is backdrop"
    assert all(url.startswith(server.address) for url in page.requests if not url.startswith("data:"))
    assert "2 primitives" in page.page.locator("#summary").text_content()


def test_isolating_and_hiding_a_word_changes_the_picture(program: Show, serve: Show, show: Show) -> None:
    page = show(serve(program(PAIR)).address).ready()
    page.page.get_by_role("button", name="Only ball").click()
    page.settled()
    assert red(page.picture()).sum() > 2000
    assert blue(page.picture()).sum() == 0
    page.page.get_by_role("button", name="Only ball").click()
    page.page.get_by_role("button", name="Hide ball").click()
    page.settled()
    assert red(page.picture()).sum() == 0
    assert blue(page.picture()).sum() > 1000
    page.page.get_by_role("button", name="Show everything").click()
    page.settled()
    assert red(page.picture()).sum() > 2000


def test_moving_a_slider_evaluates_anew_and_saving_writes_the_file(program: Show, serve: Show, show: Show) -> None:
    path = program(PAIR)
    page = show(serve(path).address).ready()
    before = red(page.picture()).sum()
    slider = page.page.get_by_label("size, slider")
    page.after(lambda: slider.fill("0.3"))
    assert red(page.picture()).sum() < 0.6 * before
    assert path.read_text() == PAIR
    page.after(lambda: page.page.locator("[data-param=size]").get_by_role("button", name="Save").click())
    assert path.read_text() == PAIR.replace("size 1.0", "size 0.3")
    page.after(lambda: page.page.locator("[data-param=tint] input").fill("#1030e0"))
    assert red(page.picture()).sum() == 0
    page.after(lambda: page.page.locator("[data-param=tint]").get_by_role("button", name="Reset").click())
    assert red(page.picture()).sum() > 0


def test_a_computed_param_is_shown_with_a_reason(program: Show, serve: Show, show: Show) -> None:
    page = show(serve(program(PAIR)).address).ready()
    row = page.page.locator("[data-param=doubled]")
    assert row.locator("input").is_disabled()
    assert "Computed value; change it in the program." in row.inner_text()


def test_an_edit_shows_up_and_a_mistake_keeps_picture_and_camera(program: Show, serve: Show, show: Show) -> None:
    path = program(PAIR)
    page = show(serve(path).address).ready()
    page.page.locator("#canvas").press("ArrowLeft")
    page.settled()
    camera = page.page.evaluate("() => scenelangPage.viewpoint.azimuth")
    assert camera != 30
    page.after(lambda: program(PAIR.replace("[.1 .2 .8]", "[.8 .2 .1]")))
    assert blue(page.picture()).sum() == 0
    good = page.picture()
    page.after(lambda: program(PAIR.replace('(call "box")', "(call box)")))
    told = page.text("#diagnostics")
    assert "E212" in told
    assert "a.scene:6:" in told
    assert '(bind "pair"' in told
    assert "^^^" in told
    assert np.abs(page.picture()[:200].astype(int) - good[:200]).max() <= 2
    assert page.page.evaluate("() => scenelangPage.viewpoint.azimuth") == camera
    page.after(lambda: program(PAIR))
    assert not page.page.locator("#diagnostics").is_visible()


def test_errors_at_run_time_show_hint_and_chain(program: Show, serve: Show, show: Show) -> None:
    page = show(
        serve(
            program(
                '(bind "a" (lambda () (call "b")))\n(bind "b" (lambda () (call "cube" :scale (ref (list 1) (length (list 1 2 3))))))\n'
            )
        ).address
    ).ready()
    told = page.text("#diagnostics")
    assert 'in "b", called at' in told
    assert "there is no picture yet" in page.text("#message")


def test_picking_shows_path_attributes_and_the_line(program: Show, serve: Show, show: Show) -> None:
    page = show(serve(program(PAIR)).address).ready()
    rows, columns = np.nonzero(blue(page.picture()))
    page.page.locator("#canvas").click(position={"x": int(np.median(columns)), "y": int(np.median(rows))})
    page.page.wait_for_selector("#inspector h3")
    told = page.text("#inspector")
    assert "pair/box/cube" in told
    assert "<z5>" in told
    assert "[0.1 0.2 0.8]" in told
    assert "a.scene, line 5" in told
    assert '(call "cube" :color [.1 .2 .8])' in told
    selected = page.page.locator('#tree [aria-selected="true"] .name')
    assert selected.inner_text() == "cube"
    page.page.keyboard.press("Escape")
    assert page.page.locator('#tree [aria-selected="true"]').count() == 0


def test_paths_and_handles_are_those_of_the_scene(serve: Show, show: Show) -> None:
    path = Path(__file__).parents[2] / "examples" / "chessboard.scene"
    page = show(serve(path).address, (600, 400)).ready()
    told = page.page.evaluate(
        """() => { const { graph } = scenelangPage; const count = graph.leaves[graph.root(0)];
        return Array.from({ length: count }, (_, leaf) => graph.handle(0, graph.pathOfLeaf(0, leaf))); }"""
    )
    scene = load(path)
    assert told == list(primitive_handles(scene, flatten(scene))[0])


def test_a_4d_scene_has_a_timeline(program: Show, serve: Show, show: Show) -> None:
    page = show(serve(program(FILM)).address).ready()
    first = page.picture()
    page.page.get_by_label("Frame", exact=True).fill("3")
    page.settled()
    last = page.picture()
    where = [np.nonzero(red(picture))[1].mean() for picture in (first, last)]
    assert where[1] > where[0] + 50
    assert np.abs(np.nonzero(blue(first))[1].mean() - np.nonzero(blue(last))[1].mean()) < 2
    page.page.locator("body").press(" ")
    assert page.text("#play") == "Pause"
    page.page.locator("body").press(" ")
    assert page.text("#play") == "Play"
    assert page.page.locator("#tree li").count() == 3


def test_the_tree_is_walked_with_keys(program: Show, serve: Show, show: Show) -> None:
    page = show(serve(program(PAIR)).address).ready()
    page.page.locator("#tree > li").focus()
    for key in ("ArrowDown", "ArrowRight", "ArrowDown", "Enter"):
        page.page.keyboard.press(key)
    assert "pair/ball/sphere" in page.text("#inspector")


def test_a_copied_camera_draws_the_same_picture(program: Show, serve: Show, show: Show) -> None:
    path = program(PAIR)
    page = show(serve(path).address).ready()
    for _ in range(3):
        page.page.locator("#canvas").press("ArrowLeft")
    page.settled()
    picture = page.picture()
    height, width = picture.shape[:2]
    page.page.get_by_role("button", name="Copy camera").click()
    viewpoint = parse_viewpoint(page.page.evaluate("() => navigator.clipboard.readText()"))
    page.page.get_by_role("button", name="JSON").click()
    camera = camera_from_json(json.loads(page.page.evaluate("() => navigator.clipboard.readText()")))
    scene = load(path).graph
    for chosen in (viewpoint, camera):
        drawn = render(scene, PictureOptions(width=width, height=height, camera=chosen))
        for mask in (red, blue):
            both = (mask(drawn) & mask(picture)).sum() / (mask(drawn) | mask(picture)).sum()
            assert both > 0.96


def test_the_views_agree_with_the_renderers_cameras(program: Show, serve: Show, show: Show) -> None:
    path = program(PAIR)
    page = show(serve(path).address, (900, 700)).ready()
    for name, viewpoint in (
        ("default", Viewpoint()),
        ("top", Viewpoint(azimuth=0, elevation=90)),
        ("isometric", parse_viewpoint("isometric")),
    ):
        if name != "default":  # the first view
            page.page.locator("#view").select_option(name)
        page.settled()
        box = page.page.locator("#canvas").bounding_box()
        size = round(box["width"]), round(box["height"])
        found = camera_from_json(
            page.page.evaluate(
                "([w, h]) => scenelangPage.viewpoint.json(scenelangPage.packet.box, w, h)", [size[0], size[1]]
            )
        )
        expected = still(load(path).graph, viewpoint, 0, *size).camera
        assert found.projection == expected.projection
        assert np.allclose(found.intrinsics, expected.intrinsics, rtol=2e-3)
        assert np.allclose(found.world_to_camera[:2], expected.world_to_camera[:2], atol=2e-3)


# As it is moved, refined as far as a slow machine may get, refined.
@pytest.mark.parametrize("samples", [0, 10, pytest.param(32, marks=pytest.mark.slow)])
def test_a_flat_patch_has_the_color_of_draft_pictures(program: Show, serve: Show, show: Show, samples: int) -> None:
    colors = ["1 1 1", ".8 .8 .8", ".5 .1 .05", ".05 .3 .9", ".02 .02 .02", "0 1 0"]
    patches = "\n".join(
        f'(transform (call "cube" :scale [1 .01 1] :color [{color}]) (translate [{i} 0 0]))'
        for i, color in enumerate(colors)
    )
    path = program(f'(bind "patches" (lambda () (union {patches})))')
    page = show(serve(path).address, (760, 260)).ready()
    page.page.locator("#view").select_option("top")
    page.settled()
    more = "async (most) => { const { stage, viewpoint } = scenelangPage; while (stage.samples < most) "
    page.page.evaluate(more + "{ stage.addSample(viewpoint); await stage.finished(20000); } }", samples)
    picture = page.picture().astype(int)
    height, width = picture.shape[:2]
    camera = still(load(path).graph, Viewpoint(azimuth=0, elevation=90), 0, width, height).camera
    drawn = render(load(path).graph, PictureOptions(width=width, height=height, camera=camera))
    for i in range(len(colors)):
        x, y, depth = camera.intrinsics @ (camera.world_to_camera @ [i, 0.005, 0, 1])[:3]
        at = int(y / depth), int(x / depth)
        assert np.abs(picture[at] - drawn[at].astype(int)).max() <= 2, colors[i]


def test_looks_agree_with_draft_pictures(program: Show, serve: Show, show: Show) -> None:
    looks = [":roughness .3", ":metallic 1 :roughness .3", ":emission [.2 .1 0]", ":opacity .5", ":ior 1.5"]
    balls = " ".join(
        f'(transform (call "sphere" :color [.7 .3 .2] {look}) (translate [{3 * i} 0 0]))'
        for i, look in enumerate(looks)
    )
    path = program(f'(bind "balls" (lambda () (union {balls})))')
    page = show(serve(path).address, (1000, 360)).ready()
    picture = page.picture().astype(int)
    height, width = picture.shape[:2]
    script = "([w, h]) => scenelangPage.viewpoint.json(scenelangPage.packet.box, w, h)"
    camera = camera_from_json(page.page.evaluate(script, [width, height]))
    drawn = render(load(path).graph, PictureOptions(width=width, height=height, camera=camera)).astype(int)
    inside = drawn.max(axis=2) - drawn.min(axis=2) > 30
    assert inside.sum() > 20_000
    assert np.abs(picture - drawn)[inside].mean() < 4


@pytest.mark.slow
def test_a_hundred_thousand_instances(program: Show, serve: Show, show: Show) -> None:
    field = """(bind "tile" (lambda () (call "cube" :scale .8 :color [.8 .1 .1])))
    (bind "field" (lambda () (union-loop 100000 (lambda (i)
      (transform (call "tile") (translate (list (modulo i 250) 0 (quotient i 250))))))))"""
    page = show(serve(program(field)).address, (700, 420)).ready()
    assert red(page.picture()).sum() > 3000
    assert page.page.evaluate("() => scenelangPage.instances.shown") == 100_000
    assert page.page.locator("#tree li").count() < 300
    assert (
        page.page.evaluate(
            "() => { const t = performance.now(); scenelangPage.refill(); return performance.now() - t; }"
        )
        < 3000
    )
    page.page.evaluate("() => scenelangPage.select([99999, 0])")
    assert "field/tile[99999]/cube" in page.page.locator("#inspector").text_content()


def test_a_scene_too_large_to_draw_is_still_a_tree(program: Show, serve: Show, show: Show) -> None:
    levels = "\n".join(
        f'(bind "l{i}" (lambda () (union-loop 100 (lambda (k) (transform (call "{below}") (translate (list k 0 0)))))))'
        for i, below in enumerate(["cube", "l0", "l1", "l2", "l3"])
    )
    page = show(serve(program(levels)).address).ready()
    assert "10,000,000,000 primitives" in page.text("#message")
    page.page.locator("#tree .twist").nth(1).click()
    assert page.page.locator("#tree li").count() == 201


def test_an_empty_scene_says_so(program: Show, serve: Show, show: Show) -> None:
    page = show(serve(program('(bind "void" (lambda () (union)))')).address).ready()
    assert "nothing to draw" in page.text("#message")
    for name in ("Copy camera", "JSON", "Frame", "Ground", "Labels"):
        page.page.get_by_role("button", name=name).click()
    page.page.locator("#canvas").click()
    assert "no camera" in page.text("#status")


def test_words_cannot_bring_markup(program: Show, serve: Show, show: Show) -> None:
    evil = '<img src=x onerror=\\"document.title=1\\"><script>document.title=1</script>'
    page = show(serve(program(f'(bind "top" (lambda () (call "{evil}" :note "<b>bold</b>")))')).address).ready()
    page.page.evaluate("() => scenelangPage.select([0])")
    assert "<script>" in page.text("#inspector")
    assert page.page.locator("main img, aside img, main script, aside b").count() == 0
    assert page.page.title() != "1"


def test_several_files_have_a_chooser(program: Show, serve: Show, show: Show) -> None:
    other = program('(bind "other" (lambda () (call "cube" :color [0 .8 0])))', "b.scene")
    page = show(serve(program(PAIR), other).address).ready()
    page.page.locator("#files").select_option("1")
    page.page.wait_for_selector("#tree >> text=other")
    page.settled()
    assert red(page.picture()).sum() == 0
    assert page.drawn() > 1000


def test_a_saved_page_works_offline_from_a_file(program: Show, show: Show, tmp_path: Path) -> None:
    out = tmp_path / "out.html"
    assert main(["view", str(program(PAIR)), "--html", str(out), "-q"]) == 0
    page = show(out.as_uri()).ready()
    assert red(page.picture()).sum() > 2000
    assert [url for url in page.requests if not url.startswith("data:")] == [out.as_uri()]
    assert page.page.locator("[data-param=size] input").first.is_disabled()
    page.page.get_by_role("button", name="Hide ball").click()
    page.settled()
    assert red(page.picture()).sum() == 0


@pytest.mark.parametrize("size", [(800, 600), (1600, 1000)])
def test_nothing_sticks_out(program: Show, serve: Show, show: Show, size: tuple[int, int]) -> None:
    page = show(serve(program(FILM)).address, size).ready()
    wide, high = page.page.evaluate(
        "() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    )
    assert (wide, high) == size
    for button in page.page.locator("header button:visible").all():
        box = button.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= size[0]


def test_the_command_serves_until_it_is_stopped(program: Show, show: Show, tmp_path: Path) -> None:
    command = [sys.executable, "-P", "-m", "scenelang", "view", str(program(PAIR)), "--no-browser"]
    with interruptible(command, tmp_path) as process:
        assert process.stdout is not None
        address = process.stdout.readline().decode().strip()
        assert address.startswith("http://127.0.0.1:")
        assert red(show(address).ready().picture()).sum() > 2000
        process.send_signal(signal.SIGINT)
        process.wait()
    assert process.returncode == 0
