"""Pictures: draft and final agree, and hard scenes are drawn without a warning."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import calls

from scenelang.backends.base import BackendOptions
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.draft import draw
from scenelang.backends.pictures.draft_painter import DRAFT
from scenelang.backends.pictures.film import (
    Image,
    PictureOptions,
    labels_of,
    picture_backend,
    render,
    save_picture,
    write_labels,
)
from scenelang.backends.pictures.film import draw as picture_draw
from scenelang.backends.pictures.stage import Stage, staging_of, still, stills
from scenelang.backends.surfaces.environments import ENVIRONMENTS, FADED, tone
from scenelang.backends.surfaces.image_files import encode, from_srgb, to_srgb
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.values.values import Matrix

BACKGROUND = encode(np.array(ENVIRONMENTS["studio"].backdrop))


def staged(scene: Scene, view: Viewpoint, width: int, height: int, frame: int = 0) -> Stage:
    return staging_of(scene, [frame], 1000).stage(still(scene, view, frame, width, height))


def finished(scene: Scene, view: Viewpoint, width: int, height: int, **settings: Any) -> Image:
    options = PictureOptions(
        width=width, height=height, camera=view, ground="seamless", settings=settings, labels=False
    )
    return picture_draw(scene, options, picture_backend("final"))


def drafted(scene: Scene, **options: Any) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return render(scene, PictureOptions(**{"width": 64, "height": 64, "ground": "seamless"} | options))


def test_draft_and_final_agree(make: Any) -> None:
    stage = staged(make.odd(), Viewpoint(), 128, 96)
    quick = draw(stage)
    guide = draw(stage, shaded=False)
    assert (guide.ids == quick.ids).all()
    final = finished(make.odd(), Viewpoint(), 128, 96, samples=24)
    a, b = encode(quick.linear).astype(float), final.picture.astype(float)
    solid = quick.ids >= 0
    assert np.abs(a - b)[solid].mean() < 9
    assert np.abs(a - b)[~solid].mean() < 5
    assert np.abs((a - b)[solid].mean(axis=0)).max() < 6


def test_silhouettes_agree(make: Any) -> None:
    black = {"color": (0, 0, 0)}
    parts = [
        (make.primitive(word, **black), pose.translation(3 * i, 0, 0)) for i, word in enumerate(("sphere", "cone"))
    ]
    parts.append(
        (
            make.primitive("cylinder", **black),
            make.chain(pose.translation(6, 0, 0), pose.scaling(-1, 2, 0.5, (0, 0, 0))),
        )
    )
    camera = Viewpoint(elevation=-10)  # from below the ground is not drawn, so that black means solid
    quick = draw(staged(make.scene(*parts), camera, 320, 240))
    final = finished(make.scene(*parts), camera, 320, 240, samples=16)
    a, b = quick.radiance.mean(axis=2) < 0.15, final.radiance.mean(axis=2) < 0.15
    assert a.sum() > 8000
    assert (a != b).sum() < 0.015 * a.sum()


def test_the_unshaded_ground_is_the_backdrop(make: Any) -> None:
    for quality in ("draft", "final"):
        picture = render(
            make.scene(make.primitive("sphere")),
            PictureOptions(width=64, height=64, camera=Viewpoint(elevation=8, distance=30), ground="seamless"),
            quality,
        )
        far = encode(FADED * from_srgb(BACKGROUND / 255.0)).astype(float)
        assert np.abs(picture[0, [0, -1]].astype(float) - far).max() < 5
        middle = picture[:, 0].astype(float)
        assert np.abs(np.diff(middle[:40], 2, axis=0)).max() < 10  # no horizon


def test_colors_are_right(make: Any) -> None:
    for color, strongest in (((0.8, 0.1, 0.1), 0), ((0.1, 0.7, 0.1), 1), ((0.05, 0.1, 0.8), 2)):
        picture = drafted(make.scene(make.primitive("cube", color=color)), labels=False)
        middle = picture[24:40, 24:40].reshape(-1, 3).mean(axis=0)
        assert np.argmax(middle) == strongest
        assert middle[strongest] > 1.6 * np.delete(middle, strongest).max()


def test_light_comes_from_the_left_and_shadow_falls_to_the_right(make: Any) -> None:
    picture = drafted(make.scene(make.primitive("cube")), camera=Viewpoint(0, 20, distance=6), width=128, height=128)
    ground = picture[110, :].astype(float).mean(axis=1)
    left, right = picture[70, :30].mean(), picture[70:80, 92:100].mean()
    assert right < left - 25
    assert ground[64] == pytest.approx(BACKGROUND.mean(), abs=10)


def hard_scenes(make: Any) -> dict[str, Scene]:
    cube, ball = make.primitive("cube"), make.primitive("sphere")
    nothing = Matrix((0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3))
    line = Matrix((1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0))
    plane = Matrix((1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0))
    far = pose.translation(1e9, 0, 0)
    return {
        "a point": make.scene((cube, nothing)),
        "a line": make.scene((ball, line)),
        "a disk": make.scene((ball, plane)),
        "a flat square": make.scene(make.primitive("cube", scale=(1, 0, 1))),
        "no radius": make.scene(make.primitive("sphere", radius=0), cube),
        "no length": make.scene(make.primitive("cylinder", p1=(0, 0, 0)), make.primitive("cone", p1=(0, 0, 0))),
        "far away": make.scene((cube, far)),
        "tiny": make.scene((cube, pose.scaling(1e-30, 1e-30, 1e-30, (0, 0, 0)))),
        "huge": make.scene((cube, pose.scaling(1e150, 1e150, 1e150, (0, 0, 0)))),
        "see-through only": make.scene(make.primitive("sphere", opacity=0.5)),
        "invisible": make.scene(make.primitive("sphere", opacity=0), cube),
        "glowing": make.scene(make.primitive("sphere", emission=2.0), make.primitive("cube", emission=(1, 0, 0))),
        "deleted blocks": make.scene(make.primitive("delete-blocks", scale=(1, 1, 1)), cube),
    }


HARD = "a point,a line,a disk,a flat square,no radius,no length,far away,tiny,huge,see-through only,invisible,glowing"


@pytest.mark.parametrize("name", [*HARD.split(","), "deleted blocks"])
@pytest.mark.sampled(2)
def test_hard_scenes_are_drawn(make: Any, name: str) -> None:
    scene = hard_scenes(make)[name]
    picture = drafted(scene, width=40, height=30)
    assert picture.shape == (30, 40, 3)
    if name not in ("a point", "a line", "no length"):
        assert np.ptp(picture) > 20
    final = render(scene, PictureOptions(width=40, height=30, ground="seamless", settings={"samples": 4}), "final")
    assert np.abs(picture.astype(float) - final).mean() < 25


def test_opacity_lets_what_is_behind_through(make: Any) -> None:
    behind = (make.primitive("cube", scale=(4, 4, 0.1), color=(0.9, 0, 0)), pose.translation(0, 0, -3))

    def red(opacity: float) -> float:
        camera = Viewpoint(0, 0)
        picture = drafted(
            make.scene(behind, make.primitive("sphere", color=(0, 0, 0.9), opacity=opacity)), camera=camera
        )
        return float(picture[32, 32, 0]) - float(picture[32, 32, 2])

    assert red(1.0) < -60 < red(0.3) < red(0.0) - 30


def test_frames_of_a_film_share_one_camera_and_single_ones_have_their_own(make: Any) -> None:
    cube = make.primitive("cube", color=(0.8, 0, 0))
    roots = [make.group("film", (cube, pose.translation(x, 0, 0))) for x in (0.0, 4.0)]
    film = Scene("film", [*roots, make.group("film")], True)
    eyes = [shot.camera.eye for shot in stills(film, Viewpoint(), range(3), 64, 64)]
    assert (eyes[0] == eyes[1]).all()
    alone = [still(film, Viewpoint(), k, 64, 64).camera.eye for k in range(3)]
    assert alone[1] - alone[0] == pytest.approx([4.0, 0.0, 0.0], abs=1e-9)
    assert np.abs(drafted(film, frame=0).astype(int) - drafted(film, frame=1)).mean() < 2
    empty = drafted(film, frame=2).astype(float)  # an empty studio, in which the light falls off smoothly
    assert max(np.abs(np.diff(empty, 2, axis=axis)).max() for axis in (0, 1)) <= 4
    with pytest.raises(SceneError, match="frame 3 does not exist"):
        drafted(film, frame=3)


def test_errors(make: Any) -> None:
    cube = make.primitive("cube")
    with pytest.raises(SceneError) as caught:
        drafted(make.scene())
    assert caught.value.name == "empty-scene"
    with pytest.raises(LimitError):
        drafted(make.scene(cube, cube, cube), limit=2)
    with pytest.raises(SceneError, match="opacity"):
        drafted(make.scene(make.primitive("cube", opacity="much")))
    with pytest.raises(SceneError, match="emission"):
        drafted(make.scene(make.primitive("cube", emission=(1, 2))))
    for options in ({"width": 0}, {"height": 10**6}, {"width": 8000, "height": 8000}, {"ground": "mud"}):
        with pytest.raises(SceneError) as caught:
            drafted(make.scene(cube), **options)
        assert caught.value.name == "value"


def test_progress_rises_to_one(make: Any) -> None:
    for quality in ("draft", "final"):
        seen: list[float] = []
        render(make.odd(), PictureOptions(width=48, height=48, progress=seen.append), quality)
        assert seen == sorted(seen)
        assert seen[-1] == pytest.approx(1.0)


def test_the_same_seed_gives_the_same_picture(make: Any) -> None:
    options = PictureOptions(width=40, height=40, settings={"samples": 4})
    assert (render(make.odd(), options, "final") == render(make.odd(), options, "final")).all()


def village(make: Any) -> Scene:
    house = make.primitive("house", scale=(2, 2, 2))
    trees = [(make.primitive("tree", scale=(1, 3, 1)), pose.translation(x, 0, -1)) for x in (3, -3)]
    return make.scene(house, *trees, (make.primitive("mouse", scale=0.2), pose.translation(0, 0, -4)))


def test_labels_stand_on_what_is_seen_of_their_boxes(make: Any) -> None:
    stage = staged(village(make), Viewpoint(azimuth=0, elevation=10), 256, 256)
    ids = draw(stage, shaded=False).ids
    labels = labels_of(stage.solids, ids)
    assert sorted(label.text for label in labels) == ["house", "tree", "tree"]  # the mouse is hidden
    for label in labels:
        seen = ids[int(label.y), int(label.x)]
        assert stage.solids.words[stage.solids.word[seen]] == label.text
    blank = np.full((256, 256, 3), 128, np.uint8)
    written = write_labels(blank, labels)
    assert (blank == 128).all()
    assert (written != blank).any(axis=2).sum() > 300
    assert (drafted(village(make), labels=True) != drafted(village(make), labels=False)).any()


def test_words_have_stable_tints_unless_they_have_a_color(make: Any) -> None:
    from scenelang.backends.surfaces.appearance import look_of

    assert look_of(make.primitive("house")) == look_of(make.primitive("house"))
    assert look_of(make.primitive("house")).color != look_of(make.primitive("tree")).color
    assert look_of(make.primitive("house", color=(0.1, 0.2, 0.3))).color == (0.1, 0.2, 0.3)
    stone = [look_of(make.primitive("set-cuboid", block_type=block)).color for block in ("stone", "stone", "dirt")]
    assert stone[0] == stone[1] != stone[2]
    assert look_of(make.primitive("cube")).color == (1.0, 1.0, 1.0)


def test_an_asset_is_drawn_as_its_mesh(make: Any, tmp_path: Path) -> None:
    import trimesh

    from scenelang.backends.surfaces.assets import AssetFiles
    from scenelang.interpreter.scene.entity import Entity
    from scenelang.interpreter.scene.primitives import shape_of
    from scenelang.interpreter.values.values import Embedding

    path = tmp_path / "ball.glb"
    trimesh.creation.icosphere(subdivisions=4).export(path)
    asset = AssetFiles(tmp_path, tmp_path, False).measure("ball.glb")
    given = {"file": str(path), "color": make.vector(0.8, 0.1, 0.1)}
    mesh = Entity("mesh", Embedding(attributes=given), (), shape_of("mesh", given, asset))
    ball = make.primitive("sphere", color=(0.8, 0.1, 0.1))
    a, b = drafted(make.scene(mesh)).astype(float), drafted(make.scene(ball)).astype(float)
    assert np.abs(a - b).mean() < 2
    final = render(
        make.scene(mesh), PictureOptions(width=64, height=64, ground="seamless", settings={"samples": 8}), "final"
    ).astype(float)
    assert np.abs(a - final).mean() < 4
    lost = {"file": str(tmp_path / "lost.glb"), "color": given["color"]}
    box = Entity("mesh", Embedding(attributes=lost), (), shape_of("mesh", lost, asset))
    with pytest.raises(SceneError, match=r"cannot read the mesh file lost\.glb"):
        drafted(make.scene(box))


def test_twice_the_primitives_take_at_most_twice_the_calls(make: Any) -> None:
    def work(count: int) -> int:
        scene, pictures = make.random(count), []
        made = calls(lambda: pictures.append(drafted(scene, width=256, height=256)))
        assert np.ptp(pictures[0]) > 100
        return made

    work(10)  # what is made once
    few, many = work(2_000), work(4_000)
    assert many < 2.3 * few


def test_film_curves() -> None:
    x = np.linspace(0, 20, 2001)
    y = tone(x)
    assert (np.diff(y) >= 0).all()
    assert y.max() <= 1
    assert (y[x <= 0.7] == x[x <= 0.7]).all()
    unit = np.linspace(0, 1, 101)
    assert from_srgb(to_srgb(unit)) == pytest.approx(unit, abs=1e-6)


def test_the_backend_object_writes_a_file(make: Any, tmp_path: Path) -> None:
    from PIL import Image

    DRAFT.run(make.odd(), tmp_path / "a.webp", BackendOptions())
    assert Image.open(tmp_path / "a.webp").size == (512, 512)
    save_picture(drafted(make.odd()), tmp_path / "b.jpg")
    assert Image.open(tmp_path / "b.jpg").size == (64, 64)


def test_shading_by_pixel_is_close_to_shading_by_sample(make: Any) -> None:
    for environment in ("studio", "sunny", "flat"):
        a, b = (
            drafted(make.odd(), width=96, height=72, environment=environment, settings={"shading": shading}).astype(int)
            for shading in ("sample", "pixel")
        )
        assert np.abs(a - b).mean() < 2.0
        assert (np.abs(a - b).max(axis=2) > 40).mean() < 0.03
    with pytest.raises(SceneError, match="`--shading` is one of sample, pixel"):
        drafted(make.odd(), settings={"shading": "pixels"})


@pytest.mark.parametrize("shading", ["sample", "pixel"])
def test_a_painter_of_many_cameras_paints_as_one_of_each(make: Any, shading: str) -> None:
    from scenelang.backends.pictures.film import painters

    scene, backend = make.odd(), picture_backend("draft")
    options = PictureOptions(width=48, height=36, settings={"shading": shading})
    shots = [still(scene, Viewpoint(azimuth=azimuth), 0, 48, 36) for azimuth in (10.0, 120.0, 10.0)]
    (shared,) = painters(scene, options, [backend], shots)
    for shot in shots:
        (alone,) = painters(scene, options, [backend], [shot])
        assert (shared.paint(shot).picture == alone.paint(shot).picture).all()


def test_glass_reflects_and_colors_in_drafts(make: Any) -> None:
    """Glass is not a ghost: its highlight is that of an opaque surface, and amber colors what is behind it."""
    pictures = {
        name: draw_picture(make, **more)
        for name, more in (
            ("opaque", {"color": (0.02, 0.02, 0.02), "ior": 1.5}),
            ("glass", {"color": (1, 1, 1), "ior": 1.5, "opacity": 0.02}),
            ("amber", {"material": "amber"}),
        )
    }
    assert pictures["glass"].max() > 0.8 * pictures["opaque"].max()
    red, _, blue = pictures["amber"][44:52, 44:52].reshape(-1, 3).mean(axis=0)
    assert red > 4.0 * blue


def draw_picture(make: Any, **attributes: Any) -> np.ndarray:
    """Return the radiance of a ball before the seamless ground."""
    options = PictureOptions(width=96, height=96, ground="seamless", camera=Viewpoint(0, 20), labels=False)
    return picture_draw(make.scene(make.primitive("sphere", **attributes)), options, picture_backend("draft")).radiance
