"""Materials, textures, the light, the tone and the first camera of a packet, and that the page shows them as drafts do."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import scenelang as sl
from scenelang.backends.pictures.camera import axes_of, camera_from_json, rolled
from scenelang.backends.pictures.declared import ProgramView
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.backends.pictures.stage import still, unit_size
from scenelang.backends.surfaces import dome, microfacets
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.environments import ENVIRONMENTS
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.tiles import coordinates, tile_of
from scenelang.backends.viewer import texture_columns as textures
from scenelang.backends.viewer.packet import packet_of
from scenelang.backends.viewer.start import cameras_of, studio_of, tone_of
from scenelang.interpreter.scene.primitives.textures import PROJECTIONS, SIDES
from scenelang.session.session import Options, Session, definition
from scenelang.viewer.workspace import evaluator

Make = Callable[..., Any]
USUAL = (1.0, 1.0, 1.0)


def packet(program: str) -> tuple[dict[str, Any], dict[str, Any]]:
    return decoded(packet_of(sl.evaluate(program).graph))


def decoded(data: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    (length,) = struct.unpack("<I", data[4:8])
    header = json.loads(data[8 : 8 + length])
    kinds = {"f4": np.float32, "i4": np.int32, "u4": np.uint32, "u1": np.uint8}
    return header, {
        name: np.frombuffer(data, kinds[kind], count, 8 + length + offset)
        for name, (kind, offset, count) in header["columns"].items()
    }


def shape(attributes: str, kind: str = "cube") -> str:
    return f'(bind "a" (lambda () (call "{kind}" {attributes})))'


# --- textures


def uv_of(row: Any, points: Any, normals: Any) -> Any:
    """Texture coordinates as the shader computes them from the floats of a primitive."""
    x, y, z = points.T
    projection, around = round(float(row[1])), row[7]
    if projection == 0:
        along = np.abs(normals).argmax(axis=1)
        sign = np.sign(normals[np.arange(len(points)), along])
        u = np.choose(along, [-z * sign, x, x * sign])
        v = np.choose(along, [y, -z * sign, y])
    elif projection == 1:
        u, v = x, y
    elif projection >= len(PROJECTIONS):
        side = list(SIDES)[projection - len(PROJECTIONS)]
        u, v = {
            "front": (x, y), "back": (-x, y), "right": (-z, y), "left": (z, y), "top": (x, -z), "bottom": (x, z)
        }[side]  # fmt: skip
        u, v = u - row[22], v - row[23]
    else:
        u = np.arctan2(x, z) * around
        v = y if projection == 2 else np.arctan2(y, np.hypot(x, z)) * around
    turned = np.stack([u * row[4] + v * row[5], v * row[4] - u * row[5]], axis=1)
    return turned / row[2:4] + row[6]


@pytest.mark.parametrize("projection", [name for name in PROJECTIONS if name != "uv"])
@pytest.mark.parametrize("more", ["", ":scale .3 :turn 30"])
@pytest.mark.parametrize("name", ["brick", "text"])
def test_the_numbers_of_a_texture_are_those_of_its_coordinates(name: str, projection: str, more: str) -> None:
    text = ':text "A"' if name == "text" else ""
    made = f'(texture "{name}" {text} :projection "{projection}" {more})'
    scene = sl.evaluate(shape(f":scale [2 1.2 .5] :texture {made}")).graph
    _, columns = decoded(packet_of(scene))
    texture = look_of(scene.frames[0].children[0].car).texture
    assert texture is not None
    random = np.random.default_rng(3)
    points, normals = random.normal(size=(200, 3)), random.normal(size=(200, 3))
    wanted = coordinates(texture, points, normals)
    assert np.allclose(uv_of(columns["primitiveTexture"], points, normals), wanted, atol=1e-4)


@pytest.mark.parametrize("side", list(SIDES))
def test_the_numbers_of_a_decal_are_those_of_its_coordinates(side: str) -> None:
    made = f'(texture "text" :text "A" :side "{side}" :at [.1 -.2] :turn 20)'
    scene = sl.evaluate(shape(f":scale [2 1.2 .5] :texture {made}")).graph
    _, columns = decoded(packet_of(scene))
    texture = look_of(scene.frames[0].children[0].car).texture
    assert texture is not None
    random = np.random.default_rng(4)
    points, normals = random.normal(size=(200, 3)), random.normal(size=(200, 3))
    axis, is_positive = SIDES[side]
    facing = normals[:, axis] * (1 if is_positive else -1) / np.linalg.norm(normals, axis=1) > 0.05
    wanted = coordinates(texture, points, normals)
    assert np.allclose(uv_of(columns["primitiveTexture"], points, normals)[facing], wanted[facing], atol=1e-4)
    assert (wanted[~facing] == 0).all()


@pytest.mark.parametrize(
    ("kind", "attributes", "half"),
    [("cube", ":scale [2 1.2 .2]", [1, 0.6, 0.1]), ("cylinder", ":radius .4 :p0 [1 2 3] :p1 [1 4 3]", [0.4, 1, 0.4])],
)
def test_the_pose_leads_from_the_geometry_to_the_primitive(kind: str, attributes: str, half: list[float]) -> None:
    _, columns = packet(shape(f'{attributes} :texture "checker"', kind))
    pose = columns["primitiveTexture"][8:20].reshape(3, 4)
    points = columns["geometry0Positions"].reshape(-1, 3) @ pose[:, :3].T + pose[:, 3]
    assert np.allclose(np.ptp(points, axis=0) / 2, half, atol=1e-5)


def test_an_image_is_sent_once_and_nothing_without_textures() -> None:
    header, columns = packet(
        '(bind "a" (lambda () (union (call "cube" :texture "brick") (call "sphere" :texture (texture "brick" :turn 20))'
        ' (call "cube") (call "cube" :texture "dots"))))'
    )
    side = header["textureSide"]
    assert len(columns["textureImages"]) == 2 * side * side * 3
    assert columns["primitiveTexture"].reshape(-1, textures.FLOATS)[:, 0].tolist() == [0, 0, -1, 1]
    header, columns = packet(shape(""))
    assert header["textureSide"] == 0
    assert not {"textureImages", "primitiveTexture"} & set(columns)


def test_pixels_are_those_of_the_period() -> None:
    header, columns = packet(shape(':texture "planks"'))
    texture = look_of(sl.evaluate(shape(':texture "planks"')).graph.frames[0].children[0].car).texture
    assert texture is not None
    found = columns["textureImages"].reshape(header["textureSide"], header["textureSide"], 3)
    assert (found == encode(tile_of(texture).image)).all()


def test_a_wide_image_becomes_a_square_of_its_longer_side(tmp_path: Path) -> None:
    data = np.zeros((16, 64, 3), np.uint8)
    data[:8], data[8:, 32:] = (255, 0, 0), (0, 0, 255)
    Image.fromarray(data).save(tmp_path / "a.png")
    path = tmp_path / "a.scene"
    path.write_text(shape(':texture "a.png"'))
    header, columns = decoded(packet_of(sl.load(path).graph))
    assert header["textureSide"] == 64
    found = columns["textureImages"].reshape(64, 64, 3)
    assert [found[y, x].tolist() for y, x in ((10, 10), (50, 50), (50, 10))] == [[255, 0, 0], [0, 0, 255], [0, 0, 0]]
    row = columns["primitiveTexture"]
    assert row[2] / row[3] == pytest.approx(4.0)


def test_many_images_are_smaller_and_the_last_ones_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(textures, "_MOST_PIXELS", 3 * 64 * 64)
    monkeypatch.setattr(textures, "_MOST", 3)
    names = ["checker", "dots", "tiles", "gradient"]
    cubes = " ".join(f'(call "cube" :texture "{name}")' for name in names)
    header, columns = packet(f'(bind "a" (lambda () (union {cubes})))')
    assert header["textureSide"] == 64
    assert len(columns["textureImages"]) == 3 * 64 * 64 * 3
    assert columns["primitiveTexture"].reshape(-1, textures.FLOATS)[:, 0].tolist() == [0, 1, 2, -1]


# --- looks and light


def test_looks_have_coat_and_sheen() -> None:
    _, columns = packet(
        '(bind "a" (lambda () (union (call "cube" :coat .7) (call "cube" :sheen .4) (call "cube") (call "cube" :ior 1.3))))'
    )
    ior, rough, _, coat, sheen = columns["primitiveLook"].reshape(-1, 12)[:, 7:].T
    assert np.allclose(coat, [0.7, 0, 0, 0])
    assert np.allclose(sheen, [0, 0.4, 0, 0])
    assert np.allclose(ior, [1, 1, 1, 1.3]), "a matte surface below a coat reflects nothing by itself"
    assert np.allclose(rough, [1, 1, -1, 0.05])


def test_the_studio_has_its_dome_and_its_tables() -> None:
    studio, panorama = studio_of(sl.evaluate(shape("")).graph, USUAL, None)
    assert panorama is None
    sky = ENVIRONMENTS["studio"].sky
    assert len(studio["sky"]["softboxes"]) == len(sky.softboxes) > 0
    assert studio["sky"]["softboxes"][0]["radiance"] == sky.softboxes[0].radiance
    for rough in (0.0, 0.3, 1.0):
        assert studio["albedo"][round(10 * rough)] == microfacets.albedo(rough)
    assert len(studio["grazing"]) == 11


# --- tone and first camera


def test_the_backdrop_is_that_of_drafts() -> None:
    bright = sl.evaluate(shape(":color [.9 .9 .9]", "sphere")).graph
    header, _ = decoded(packet_of(bright))
    corner = render(bright, PictureOptions(width=64, height=48))[0, 0]
    assert np.abs(encode(np.array(header["studio"]["backdrop"])).astype(int) - corner).max() <= 2
    dark = packet(shape(":color [.02 .02 .02]", "sphere"))[0]["studio"]["backdrop"]
    assert dark != header["studio"]["backdrop"]


def test_a_large_scene_keeps_the_tone_of_the_studio(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = sl.evaluate(shape(":color [.9 .9 .9]", "sphere")).graph
    assert tone_of(scene) != USUAL
    monkeypatch.setattr("scenelang.backends.viewer.start._MOST_TONED", 0)
    assert tone_of(scene) == USUAL


def test_typing_and_sliders_keep_the_tone(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    text = '(param c .02)\n(bind "a" (lambda () (call "sphere" :color [c c c])))'
    path.write_text(text)
    evaluate = evaluator(
        lambda _, values: Session(Options(defines=dict(definition(f"{k}={v}") for k, v in values.items()))), 1_000
    )

    def tone(literals: dict[str, str], typed: str | None = None) -> Any:
        made = evaluate(str(path), literals, typed).packet
        assert made is not None
        return decoded(made)[0]["studio"]["backdrop"]

    dark = tone({})
    bright = text.replace(".02", ".9")
    assert tone({"c": "0.9"}) == tone({}, bright) == dark
    path.write_text(bright)
    assert tone({}) != dark


CAMERAS = [
    "(camera :azimuth 100 :elevation 12 :distance 5 :fov 50)",
    "(camera :eye [3 2 4] :look-at [0.5 0 0] :fov 20)",
    "(camera :eye [1 6 0] :look-at [1 0 0])",
    "(camera :azimuth -40 :elevation -30)",
    "(camera :azimuth 70 :elevation 15 :roll 20)",
    "(camera :eye [3 2 4] :look-at [0.5 0 0] :roll -130)",
    "(camera :azimuth 45 :elevation 30 :orthographic #t :distance 4)",
]


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_first_camera_is_that_of_drafts(camera: str) -> None:
    scene = sl.evaluate(f'{camera}\n(camera "other" :azimuth 3)\n{shape("")}').graph
    first, other = cameras_of(scene)
    assert (first["name"], other["name"]) == ("", "other")
    (found,) = first["poses"]
    expected = still(scene, ProgramView(), 0, 640, 480).camera.rescaled(*unit_size(scene))
    right, up, forward = rolled(axes_of(found["azimuth"], found["elevation"]), found["roll"])
    assert np.allclose(forward, expected.forward, atol=1e-6)
    assert np.allclose(right, expected.right, atol=1e-6)
    assert np.allclose(up, expected.up, atol=1e-6)
    assert first["isFramed"] == (camera in CAMERAS[3:5])
    if first["isFramed"]:  # the page places it
        assert found["fov"] == pytest.approx(35)
        return
    half = np.tan(np.radians(found["fov"]) / 2) * (found["distance"] if found["orthographic"] else 1.0)
    assert half == pytest.approx(240 / expected.focal[1])
    away = np.array(found["target"]) - expected.eye
    assert np.allclose(np.cross(away, expected.forward), 0, atol=1e-6), "the target is in the middle of the image"
    if not found["orthographic"]:
        assert np.linalg.norm(away) == pytest.approx(found["distance"])


def test_a_program_without_cameras_or_with_a_wrong_one_starts_as_usual() -> None:
    assert cameras_of(sl.evaluate(shape("")).graph) == []
    cameras = cameras_of(sl.evaluate(f'(camera :look-at "nobody")\n(camera "a" :azimuth 3)\n{shape("")}').graph)
    assert [camera["name"] for camera in cameras] == ["a"]


# --- the page


def pictures(show: Make, server: Any, scene: Any, size: tuple[int, int] = (760, 420)) -> tuple[Any, Any]:
    """What the page shows and the draft by its camera (H, W, 3)."""
    page = show(server.address, size).ready()
    script = """async () => { const { stage, viewpoint } = scenelangPage; scenelangPage.refine = async () => {};
      stage.draw(viewpoint, false);
      while (stage.samples < 32) { stage.addSample(viewpoint); await stage.finished(20000); } }"""
    page.page.evaluate(script)
    picture = page.picture().astype(int)
    height, width = picture.shape[:2]
    camera = camera_from_json(
        page.page.evaluate("([w, h]) => scenelangPage.viewpoint.json(scenelangPage.packet.box, w, h)", [width, height])
    )
    drawn = render(scene, PictureOptions(width=width, height=height, camera=camera, labels=False))
    return picture, drawn.astype(int)


SURFACES = """(bind "a" (lambda () (union
  (transform (call "sphere" :radius .5 :metallic 1 :roughness .1 :color [.8 .5 .3]) (translate [-1.2 0 0]))
  (call "sphere" :radius .5 :color [.6 .1 .1] :coat 1)
  (transform (call "sphere" :radius .5 :color [.1 .1 .5] :sheen 1) (translate [1.2 0 0]))
  (transform (call "cube" :texture (texture "checker" :scale .3)) (@ (translate [-1.2 0 1.5]) (rotate .4 [0 1 0])))
  (transform (call "cylinder" :radius .5 :texture (texture "stripes" :projection "cylindrical" :turn 90 :scale .2
    :colors [[.02 .05 .2] [.3 .1 .02]]))
    (translate [0 -.5 1.5]))
  (transform (call "sphere" :radius .5 :texture (texture "dots" :projection "spherical" :colors [[.25 .03 .03] [.02 .1 .05]]))
    (translate [1.2 0 1.5])))))
"""


@pytest.mark.browser
def test_surfaces_look_as_in_drafts(program: Make, serve: Make, show: Make) -> None:
    path = program(SURFACES)
    picture, drawn = pictures(show, serve(path), sl.load(path).graph)
    away = np.abs(picture - drawn)
    things = np.abs(drawn - drawn[4, 4]).max(axis=2) > 12
    assert np.median(away[things]) <= 4
    assert away[things].mean() < 9
    assert np.abs(picture[4, 4] - drawn[4, 4]).max() <= 2, "both have the same tone"


RELIEFS = """(bind "a" (lambda () (union
  (transform (call "cube" :scale [2 2 2] :color [.7 .3 .1] :texture (texture "text" :text "MILK" :side "front"
    :colors [[.7 .3 .1] [1 1 1]])) (translate [-2.6 1 0]))
  (transform (call "cube" :scale [2 2 2] :texture (texture "tiles" :scale .6 :bump .1)) (translate [0 1 0]))
  (transform (call "cylinder" :radius 1 :p0 [0 0 0] :p1 [0 2 0]
    :texture (texture "dots" :projection "cylindrical" :bump -.1)) (@ (translate [2.6 0 0]) (scale [1 1 -1]))))))
"""


@pytest.mark.browser
def test_reliefs_and_decals_look_as_in_drafts(program: Make, serve: Make, show: Make) -> None:
    path = program(RELIEFS)
    picture, drawn = pictures(show, serve(path), sl.load(path).graph)
    away = np.abs(picture - drawn)
    objects = np.abs(drawn - drawn[4, 4]).max(axis=2) > 12
    assert np.median(away[objects]) <= 4
    assert away[objects].mean() < 9
    flat = program(RELIEFS.replace(":bump .1", "").replace(":bump -.1", ""), "flat.scene")
    without = render(sl.load(flat).graph, PictureOptions(width=drawn.shape[1], height=drawn.shape[0], labels=False))
    relief = np.abs(drawn - without.astype(int)).max(axis=2) > 25
    assert relief.sum() > 1000, "the relief is seen"


@pytest.mark.browser
def test_the_dome_of_the_page_is_that_of_drafts(program: Make, serve: Make, show: Make) -> None:
    page = show(serve(program(shape(""))).address).ready()
    script = """(name) => { const { image } = scenelangPage.stage.uniforms[name].value;
      return { size: [image.depth ?? 1, image.height, image.width, 4], data: Array.from(image.data) }; }"""
    light = ENVIRONMENTS["studio"]
    panorama = dome.panorama_of(light.sky, light.ambient)
    expected = {
        "dome": panorama.image[None],
        "domeTables": np.stack(dome._blurred(panorama)),
    }
    for name, wanted in expected.items():
        found = page.page.evaluate(script, name)
        colors = np.array(found["data"], np.uint16).view(np.float16).astype(float).reshape(found["size"])[..., :3]
        assert np.allclose(colors[: len(wanted)], wanted, rtol=2e-3, atol=1e-3), name
    directions = dome.directions_of(24).reshape(-1, 3)
    for layer, above in ((4, True), (5, False)):
        light_on = dome.Dome(panorama).irradiance(directions, above=above).reshape(24, 48, 3)
        assert np.abs(colors[layer] - light_on).max() < 0.02


@pytest.mark.browser
def test_the_page_starts_at_the_camera_of_the_program(program: Make, serve: Make, show: Make) -> None:
    path = program(f"(camera :eye [3 2 4] :look-at [0.5 0 0] :fov 20)\n{shape(':scale [2 1 1] :color [.7 .1 .1]')}")
    page = show(serve(path).address, (760, 420)).ready()
    picture = page.picture().astype(int)
    height, width = picture.shape[:2]
    drawn = render(sl.load(path).graph, PictureOptions(width=width, height=height)).astype(int)
    red = [image[:, :, 0] - image[:, :, 2] > 60 for image in (picture, drawn)]
    assert (red[0] & red[1]).sum() / (red[0] | red[1]).sum() > 0.96
    assert page.page.evaluate("() => scenelangPage.viewpoint.fov") == pytest.approx(20)


@pytest.mark.browser
def test_the_first_view_is_framed_by_the_window(program: Make, serve: Make, show: Make) -> None:
    page = show(serve(program(f"(camera :azimuth -40 :elevation 5)\n{shape('')}")).address, (900, 400)).ready()
    assert page.page.evaluate("() => scenelangPage.viewpoint.azimuth") == pytest.approx(-40)
    assert page.page.evaluate("() => scenelangPage.viewpoint.elevation") == pytest.approx(5)
