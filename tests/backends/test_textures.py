"""Textures: the same image on the same places in drafts, final images and glTF files."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import scenelang as sl
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.tiles import coordinates, corner_coordinates, tile_of
from scenelang.interpreter.scene.primitives.textures import PATTERNS, PROJECTIONS, Texture

SIZE = 96


def textured(texture: str, shape: str = '"cube" :scale [2 2 2]') -> sl.Scene:
    return sl.evaluate(f'(bind "a" (lambda () (call {shape} :texture {texture})))')


def seen(scene: sl.Scene, quality: str = "draft", **view: Any) -> np.ndarray:
    """Return the front of a cube of side 2 that fills the image, unlit."""
    view = {"azimuth": 0.0, "elevation": 0.0} | view
    camera = Viewpoint(orthographic=True, target=(0.0, 0.0, 0.0), distance=3.1716, **view)
    options = PictureOptions(width=SIZE, height=SIZE, camera=camera, environment="flat")
    return draw(scene.graph, options, picture_backend(quality)).picture


@pytest.mark.parametrize("name", list(PATTERNS))
def test_a_period_repeats_without_a_seam(name: str) -> None:
    tile = tile_of(Texture(name, text="A"))
    image = tile.image.astype(float)
    inner = np.abs(np.diff(image, axis=0)).max(), np.abs(np.diff(image, axis=1)).max()
    assert np.abs(image[0] - image[-1]).max() <= inner[0] + 1e-6
    assert np.abs(image[:, 0] - image[:, -1]).max() <= inner[1] + 1e-6
    assert image.std() > 0.01
    assert tile.mean == pytest.approx(image.mean(axis=(0, 1)), abs=1e-3)


def test_a_checker_is_a_closed_form_on_the_front_of_a_cube() -> None:
    """Squares of side .5 that meet in the middle of the face, white at the right of the middle and above it."""
    picture = seen(textured('(texture "checker" :scale .5 :colors [[1 1 1] [0 0 0]])')).mean(axis=2)
    row, column = np.mgrid[0:SIZE, 0:SIZE]
    x, y = (column + 0.5) / SIZE * 2.0 - 1.0, 1.0 - (row + 0.5) / SIZE * 2.0
    white = (np.floor(x / 0.5) + np.floor(y / 0.5)) % 2 == 0
    away = np.minimum(np.abs(x / 0.5 - np.round(x / 0.5)), np.abs(y / 0.5 - np.round(y / 0.5))) > 0.1
    assert (picture[away & white] > 250).all() or (picture[away & ~white] > 250).all()
    assert (np.abs(picture[away & white].mean() - picture[away & ~white].mean())) > 240


def test_a_turn_of_a_right_angle_swaps_the_axes() -> None:
    plain = seen(textured('(texture "stripes" :scale .25)')).astype(int)
    turned = seen(textured('(texture "stripes" :scale .25 :turn 90)')).astype(int)
    for picture, along in ((plain, 1), (turned, 0)):
        assert np.abs(np.diff(picture, axis=along)).max() <= 2
        assert np.abs(np.diff(picture, axis=1 - along)).max() > 100


def test_far_patterns_are_their_mean_and_not_noise() -> None:
    picture = seen(textured('(texture "checker" :scale .002 :colors [[1 1 1] [0 0 0]])'))
    assert np.ptp(picture[4:-4, 4:-4]) <= 6
    assert abs(int(picture[48, 48, 0]) - int(encode(np.array([0.5]))[0])) <= 2


@pytest.mark.parametrize("projection", [name for name in PROJECTIONS if name != "uv"])
@pytest.mark.parametrize("shape", ["cube", "sphere", "cylinder"])
def test_a_projection_has_no_seam_across_a_triangle(projection: str, shape: str) -> None:
    trimesh = pytest.importorskip("trimesh")
    makers = {"cube": trimesh.creation.box, "sphere": trimesh.creation.icosphere, "cylinder": trimesh.creation.cylinder}
    mesh = makers[shape](1.0, 2.0) if shape == "cylinder" else makers[shape]()
    corners = np.asarray(mesh.triangles)[:, :, [1, 2, 0]]  # the axis along y
    uv = corner_coordinates(Texture("checker", 0.2, projection=projection), corners)
    spread = np.ptp(uv, axis=1)
    period = 2 * 0.2
    longest = np.ptp(corners, axis=1).max()
    bulk = np.sort(spread.max(axis=1))[: int(0.98 * len(spread))]  # at the poles, angles are not defined
    assert bulk.max() <= 3.2 * longest / period + 0.1


def test_a_cylindrical_pattern_meets_itself() -> None:
    texture = Texture("stripes", 0.3, 90.0, projection="cylindrical")
    points = np.array([[1e-9, 0.1, -1.0], [-1e-9, 0.1, -1.0]])
    uv = coordinates(texture, points, points)
    tile = tile_of(texture)
    colors = tile.at(uv + 0.0, np.full(2, 1e-3))
    assert np.abs(colors[0] - colors[1]).max() < 0.02


@pytest.mark.parametrize("name", ["checker", "brick", "tiles", "planks", "dots", "gradient", "marble"])
def test_draft_and_final_show_the_same(name: str) -> None:
    pytest.importorskip("mitsuba")
    scene = textured(f'(texture "{name}" :scale .7)')
    camera = Viewpoint(20.0, 15.0)
    pictures = [
        draw(
            scene.graph,
            PictureOptions(width=SIZE, height=SIZE, camera=camera, ground="none", settings=settings),
            picture_backend(quality),
        ).radiance
        for quality, settings in (("draft", {}), ("final", {"samples": 64, "bounces": 2}))
    ]
    inside = np.zeros((SIZE, SIZE), bool)
    inside[30:60, 30:60] = True
    first, second = (picture[inside].mean(axis=1) for picture in pictures)
    assert np.corrcoef(first, second)[0, 1] > 0.9
    assert first.mean() == pytest.approx(second.mean(), rel=0.08)


@pytest.mark.parametrize("scale", ["[1 1 -1]", "[-1 1 1]", "[1 -1 1]", "[-1 1 -1]"])
def test_mirrored_decals_are_the_same_in_both_qualities(scale: str) -> None:
    pytest.importorskip("mitsuba")
    decal = '(call "cube" :texture (texture "text" :text "Rg" :side "front" :scale .7))'
    scene = sl.evaluate(f'(bind "a" (lambda () (transform {decal} (scale {scale}))))').graph
    pictures = []
    for settings in ({}, {"samples": 16}):
        options = PictureOptions(width=SIZE, height=SIZE, camera=Viewpoint(0.0, 0.0), ground="none", settings=settings)
        pictures.append(draw(scene, options, picture_backend("final" if settings else "draft")).picture[30:66, 30:66])
    dark = [picture.mean(axis=2) < picture.max() / 2 for picture in pictures]
    assert (dark[0] != dark[1]).mean() < 0.05
    assert dark[0].any() == (scale in ("[-1 1 1]", "[1 -1 1]"))


def test_an_image_is_upright_and_not_mirrored(tmp_path: Path) -> None:
    corners = np.zeros((64, 64, 3), np.uint8)
    corners[:32, :32], corners[:32, 32:], corners[32:, :32] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    Image.fromarray(corners).save(tmp_path / "flag.png")
    (tmp_path / "a.scene").write_text('(bind "a" (lambda () (call "cube" :scale [2 2 2] :texture "flag.png")))')
    scene = sl.load(tmp_path / "a.scene")
    for quality in ("draft", "final") if _has_mitsuba() else ("draft",):
        picture = seen(scene, quality)
        quarters = [picture[SIZE * r // 4, SIZE * c // 4].tolist() for r, c in ((1, 1), (1, 3), (3, 1), (3, 3))]
        assert quarters == [[255, 0, 0], [0, 255, 0], [0, 0, 255], [0, 0, 0]]


@pytest.mark.parametrize("quality", ["draft", "final"])
@pytest.mark.parametrize(("side", "azimuth", "elevation"), [
    ("front", 0, 0), ("back", 180, 0), ("right", 90, 0), ("left", -90, 0), ("top", 0, 90), ("bottom", 0, -90),
])  # fmt: skip
def test_a_decal_is_upright_on_its_side_alone(
    side: str, azimuth: float, elevation: float, quality: str, tmp_path: Path
) -> None:
    """Half the width of a face, .3 to the right and .2 upwards, as a person sees it who faces that side."""
    if quality == "final" and not _has_mitsuba():
        pytest.skip("needs mitsuba")
    corners = np.zeros((64, 64, 3), np.uint8)
    corners[:32, :32], corners[:32, 32:], corners[32:, :32] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    Image.fromarray(corners).save(tmp_path / "flag.png")
    color = "[0 1 1]"
    texture = f'(texture "flag.png" :scale 1 :side "{side}" :at [.3 .2])'
    (tmp_path / "a.scene").write_text(
        f'(bind "a" (lambda () (call "cube" :scale [2 2 2] :color {color} :texture {texture})))'
    )
    scene = sl.load(tmp_path / "a.scene")
    picture = seen(scene, quality, azimuth=azimuth, elevation=elevation)

    def at(x: float, y: float) -> list[int]:
        return picture[round((1 - y) / 2 * SIZE), round((x + 1) / 2 * SIZE)].tolist()

    assert [at(x, y) for x, y in ((0.05, 0.45), (0.55, 0.45), (0.05, -0.05), (0.55, -0.05))] == [
        [255, 0, 0], [0, 255, 0], [0, 0, 255], [0, 0, 0],
    ]  # fmt: skip
    around = [at(x, y) for x, y in ((-0.5, 0.2), (0.9, 0.2), (0.3, 0.9), (0.3, -0.5))]
    assert around == [[0, 255, 255]] * 4
    others = seen(scene, quality, azimuth=azimuth + 180, elevation=-elevation)
    assert (others[10:-10, 10:-10] == (0, 255, 255)).all()


def test_transparent_parts_of_a_decal_show_the_color_of_the_surface(tmp_path: Path) -> None:
    data = np.zeros((32, 32, 4), np.uint8)
    data[:16] = (255, 0, 0, 255)
    Image.fromarray(data).save(tmp_path / "half.png")
    (tmp_path / "a.scene").write_text(
        '(bind "a" (lambda () (call "cube" :scale [2 2 2] :color [0 1 0] :texture (texture "half.png" :side "front" :scale 1))))'
    )
    picture = seen(sl.load(tmp_path / "a.scene"))
    assert picture[SIZE // 2 - 10, SIZE // 2].tolist() == [255, 0, 0]
    assert picture[SIZE // 2 + 10, SIZE // 2].tolist() == [0, 255, 0]


@pytest.mark.parametrize(("settings", "message"), [
    ('"brick" :side "front"', "only images and texts"),
    ('"text" :text "A" :side "frnt"', "must be one of front"),
    ('"text" :text "A" :at [0 0]', "without `:side`"),
    ('"text" :text "A" :side "top" :at [0 0 0]', "two numbers"),
    ('"text" :text "A" :side "top" :projection "box"', "both a `:side` and the projection"),
    ('"brick" :bump "deep"', "bump"),
    ('"brick" :bump 1000', "from -10 to 10"),
])  # fmt: skip
def test_wrong_settings_of_decals_and_reliefs_are_named(settings: str, message: str) -> None:
    with pytest.raises(sl.SceneError, match=message):
        textured(f"(texture {settings})")


@pytest.mark.parametrize("quality", ["draft", "final"])
@pytest.mark.parametrize("pose", ["", "(scale [-1 1 1])"])
def test_a_relief_tilts_towards_the_light_as_its_closed_form(quality: str, pose: str) -> None:
    """The pattern gradient rises along y by bump * scale over half a period of scale: slopes of 2 * bump up and down.

    By the cosine law, the halves differ from a flat face as tilted planes do.
    """
    if quality == "final" and not _has_mitsuba():
        pytest.skip("needs mitsuba")
    slope = 0.2
    white = ":colors [[.5 .5 .5] [.5 .5 .5]]"
    program = """(environment "night")(light "sun" :direction [-1 -1 -1] :strength 30)
      (bind "a" (lambda () (transform (call "cube" :scale [2 2 2] :texture {}) {})))"""
    camera = Viewpoint(0.0, 0.0, orthographic=True, target=(0.0, 0.0, 0.0), distance=3.1716)

    def front(texture: str) -> np.ndarray:
        scene = sl.evaluate(program.format(texture, pose or "(translate [0 0 0])"))
        options = PictureOptions(
            width=SIZE, height=SIZE, camera=camera, ground="none",
            settings={"samples": 64} if quality == "final" else {},
        )  # fmt: skip
        return draw(scene.graph, options, picture_backend(quality)).radiance.mean(axis=2)

    flat = front(f'(texture "gradient" :scale 2 {white})')
    tilted = front(f'(texture "gradient" :scale 2 :bump {slope / 2} {white})')
    ratio = (tilted / flat)[:, SIZE // 4 : -SIZE // 4].mean(axis=1)
    normal = 1.0 / np.sqrt(1.0 + slope**2)
    # The first color is in the middle of the face (v = 0), so that its upper half slopes upwards: its normal is up.
    assert ratio[SIZE // 8 : SIZE // 2 - SIZE // 8].mean() == pytest.approx((1 + slope) * normal, rel=0.02)
    assert ratio[SIZE // 2 + SIZE // 8 : -SIZE // 8].mean() == pytest.approx((1 - slope) * normal, rel=0.02)


def _has_mitsuba() -> bool:
    try:
        import mitsuba  # noqa: F401
    except ImportError:
        return False
    return True


def test_gltf_carries_the_image_and_the_coordinates(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = textured('(texture "checker" :scale .5 :colors [[1 1 1] [0 0 0]])')
    scene.export(tmp_path / "a.glb")
    (mesh,) = trimesh.load(tmp_path / "a.glb").dump()
    image = np.asarray(mesh.visual.material.baseColorTexture.convert("RGB"))
    assert (image == encode(tile_of(Texture("checker", colors=((1.0,) * 3, (0.0,) * 3))).image)).all()
    # The color at the middle of every face is that of the draft's definition.
    middles = mesh.triangles_center
    uv = mesh.visual.uv[mesh.faces].mean(axis=1)
    height, width = image.shape[:2]
    shown = image[((1.0 - uv[:, 1] % 1.0) * height).astype(int) % height, (uv[:, 0] % 1.0 * width).astype(int) % width]
    texture = Texture("checker", 0.5, colors=((1.0,) * 3, (0.0,) * 3))
    wanted = tile_of(texture).at(coordinates(texture, middles, mesh.face_normals), np.full(len(middles), 1e-4))
    assert np.abs(shown.astype(int) - encode(wanted)).max() <= 1


def test_equal_cubes_of_other_sizes_have_their_own_coordinates(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = sl.evaluate(
        '(bind "a" (lambda () (union (call "cube" :scale 1 :texture (texture "checker" :scale .5))'
        ' (transform (call "cube" :scale 2 :texture (texture "checker" :scale .5)) (translate [3 0 0])))))'
    )
    scene.export(tmp_path / "a.glb")
    meshes = trimesh.load(tmp_path / "a.glb").dump()
    spans = sorted(np.ptp(mesh.visual.uv[:, 0]) for mesh in meshes)
    assert spans == pytest.approx([1.0, 2.0])


def test_a_computed_solid_keeps_the_texture_on_its_faces() -> None:
    source = '(difference (call "cube" :scale [2 2 2] {}) (call "cylinder" :radius .3 :p0 [0 -2 0] :p1 [0 2 0]))'
    texture = ':texture (texture "checker" :scale .5 :colors [[1 1 1] [0 0 0]])'
    solid = sl.evaluate(f'(bind "a" (lambda () {source.format(texture)}))')
    cube = textured('(texture "checker" :scale .5 :colors [[1 1 1] [0 0 0]])')
    assert (np.abs(seen(solid).astype(int) - seen(cube).astype(int)) > 8).mean() < 4.52


@pytest.mark.parametrize(("texture", "words"), [
    ('"brik"', "did you mean"), ("(list)", "name of a pattern"), ("(list 3)", "name of a pattern"),
    ('(list "brick" "size" 3)', "no setting `:size`"), ('(texture "brick" :scale 0)', "above 0"),
    ('(texture "brick" :projection "cube")', "must be one of"), ('(texture "text")', "1 to 200 characters"),
    ('(texture "checker" :colors [1 2 3])', "two colors"), ('"lost.png"', "lost.png"),
    ('"../../../etc/x.png"', "outside"),
])  # fmt: skip
def test_wrong_textures_are_diagnostics(texture: str, words: str) -> None:
    with pytest.raises(sl.SceneError) as caught:
        textured(texture)
    assert words in str(caught.value)


def test_a_file_that_is_no_image_is_a_diagnostic(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"not an image")
    (tmp_path / "a.scene").write_text('(bind "a" (lambda () (call "cube" :texture "a.png")))')
    with pytest.raises(sl.SceneError, match="not an image"):
        sl.load(tmp_path / "a.scene")


def test_png_of_a_tile_is_its_image() -> None:
    tile = tile_of(Texture("dots"))
    assert (np.asarray(Image.open(io.BytesIO(tile.png()))) == encode(tile.image)).all()


def test_the_middle_of_a_cap_has_no_angle_of_its_own() -> None:
    """The corner of a sector on the axis takes the angle of the sector, so that its image is not twisted."""
    sector = np.array([[[0.0, 0.1, 0.0], [0.5, 0.1, 0.5], [0.6, 0.1, 0.4]]])
    uv = corner_coordinates(Texture("checker", 0.2, projection="cylindrical"), sector)
    assert np.ptp(uv[0, :, 0]) < 0.7
    assert min(uv[0, 1:, 0]) <= uv[0, 0, 0] <= max(uv[0, 1:, 0])


def test_textures_at_grazing_angles_are_those_of_larger_images() -> None:
    scene = textured('(texture "checker" :scale .1)', '"cube" :scale [4 .1 4]')
    pictures = [
        draw(
            scene.graph,
            PictureOptions(width=factor * 120, height=factor * 90, camera=Viewpoint(30.0, 12.0), environment="flat"),
            picture_backend("draft"),
        ).picture.astype(float)
        for factor in (1, 6)
    ]
    mean = pictures[1].reshape(90, 6, 120, 6, 3).mean(axis=(1, 3))
    assert np.abs(pictures[0] - mean).mean() < 4.5


@pytest.mark.parametrize("text", ["日本", "\U0001f600"])
def test_letters_that_the_font_lacks_are_an_error(text: str) -> None:
    with pytest.raises(sl.SceneError, match="no letter"):
        textured(f'(texture "text" :text "{text}")').render(size=(16, 16))


def test_16_bit_images_keep_their_tones(tmp_path: Path) -> None:
    ramp = np.tile(np.linspace(0, 65535, 64).astype(np.uint16), (64, 1))
    Image.fromarray(ramp).save(tmp_path / "ramp.png")
    image = tile_of(Texture(str(tmp_path / "ramp.png"))).image
    assert image[0, 0, 0] < 0.01
    assert image[0, 63, 0] > 0.98
    assert 0.15 < image[0, 32, 0] < 0.3


@pytest.mark.parametrize("setting", [":text label", ":text label :side side", ":text (string-append label label)"])
def test_check_knows_nothing_of_settings_that_are_computed(setting: str) -> None:
    program = f'(bind "a" (lambda ((:label "A") (:side "top")) (call "cube" :texture (texture "text" {setting}))))'
    assert sl.check(program).ok


@pytest.mark.parametrize(("call", "message"), [
    ('"cube" :material "oakk"', 'names no known substance: "oakk"'),
    ('"sphere" :texture "chekker"', 'names no pattern or image: "chekker"'),
    ('"cube" :texture (texture "bric" :scale 2)', '`texture` names no pattern or image: "bric"'),
    ('"cube" :texture (texture "brick" :scale -2)', "`:scale` of `texture` must be a finite number above 0"),
    ('"cube" :density "oakk"', 'names no known substance: "oakk"'),
])  # fmt: skip
def test_check_tries_names_without_a_run(call: str, message: str) -> None:
    report = sl.check(f'(bind "a" (lambda () (call {call})))(scene "a")')
    assert [message in error.message for error in report.diagnostics if error.is_error] == [True]


@pytest.mark.parametrize("projection", ["cylindrical", "spherical"])
def test_draft_and_final_agree_where_coordinates_bend(projection: str) -> None:
    """On the front of a cube, the angle around the axis is not linear between its corners."""
    pytest.importorskip("mitsuba")
    scene = textured(f'(texture "checker" :scale .25 :projection "{projection}" :colors [[1 1 1] [0 0 0]])')
    camera = Viewpoint(0.0, 0.0, orthographic=True, target=(0.0, 0.0, 0.0), distance=3.1716)
    pictures = [
        draw(
            scene.graph,
            PictureOptions(width=SIZE, height=SIZE, camera=camera, ground="none", settings=settings),
            picture_backend(quality),
        ).radiance.mean(axis=2)
        for quality, settings in (("draft", {}), ("final", {"samples": 64, "bounces": 2}))
    ]
    first, second = (picture[4:-4, 4:-4].reshape(-1) for picture in pictures)
    assert np.corrcoef(first, second)[0, 1] > 0.97


def test_a_broken_image_is_an_error_and_no_crash(tmp_path: Path) -> None:
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (32, 32, 3), np.uint8)).save(tmp_path / "whole.png")
    (tmp_path / "half.png").write_bytes((tmp_path / "whole.png").read_bytes()[:600])
    (tmp_path / "a.scene").write_text('(bind "a" (lambda () (call "cube" :texture "half.png")))')
    for use in (sl.Scene.render, lambda scene: scene.export(tmp_path / "a.glb")):
        with pytest.raises(sl.SceneError, match=r"half\.png"):
            use(sl.load(tmp_path / "a.scene"))


@pytest.mark.parametrize("turn", [0, 35])
def test_letters_are_readable_at_grazing_angles(turn: int) -> None:
    """Letters on a floor, seen along it, look as in the mean of a draft of four times the size.

    Pixels cover strips of the floor there; means over squares as long as the strips had correlations of .3 and .6.
    """
    written = ':texture (texture "text" :text "SCENE LANGUAGE" :side "top" :scale 5.5)'
    floors = [
        sl.evaluate(f'(bind "floor" (lambda () (call "cube" :scale [6 .1 3] :color [.8 .8 .8] {texture})))')
        for texture in (written, "")
    ]
    inks = []
    for factor in (1, 4):
        text, plain = (
            np.asarray(
                floor.render(
                    camera=f"elevation=9,azimuth={turn}", size=(400 * factor, 130 * factor), environment="flat"
                ),
                float,
            )
            for floor in floors
        )
        inks.append((plain - text).mean(axis=2).reshape(130, factor, 400, factor).mean(axis=(1, 3)))
    seen, true = (ink[inks[1] > 3.0] for ink in inks)
    assert np.corrcoef(seen, true)[0, 1] > 0.75
