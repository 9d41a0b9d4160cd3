"""Images with alpha, over flat backgrounds, and with the shadow alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image
from silhouettes import mask_of
from support import evaluate

import scenelang as sl
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.stage import still
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError

SIZE = (96, 72)
OPAQUE = """(bind "still" (lambda () (union
  (transform (call "sphere" :radius .6 :color [.8 .2 .1]) (translate [0 .6 0]))
  (transform (call "cube" :color [.2 .4 .8]) (translate [1.5 .5 0]))
  (transform (call "cone" :p1 [0 1.4 0] :radius .5 :color [.9 .8 .3]) (translate [-1.4 0 .3])))))"""
GLASS = '(bind "a" (lambda () (union (call "sphere" :color [.2 .6 .3] :opacity .4))))'
GLOWS = '(bind "a" (lambda () (union (call "cube" :emission 2) (transform (call "sphere") (translate [3 0 0])))))'
QUALITIES = {"draft": {}, "final": {"samples": 8}}
Pixels = npt.NDArray[np.uint8]


def pixels(text: str, quality: str = "draft", **options: object) -> Pixels:
    return sl.evaluate(text).render(size=SIZE, quality=quality, settings=QUALITIES[quality], **options).pixels  # type: ignore[arg-type]


def composited(picture: Pixels, color: tuple[int, int, int]) -> Pixels:
    """As Pillow puts it over a color."""
    below = Image.new("RGBA", (picture.shape[1], picture.shape[0]), (*color, 255))
    below.alpha_composite(Image.fromarray(picture))
    return np.asarray(below)[:, :, :3]


def inner(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """The pixels of a mask whose eight neighbors are in it too."""
    padded = np.pad(mask, 1, mode="edge")
    height, width = mask.shape
    return np.all([padded[i : i + height, k : k + width] for i in range(3) for k in range(3)], axis=0)


@pytest.mark.parametrize("quality", QUALITIES)
@pytest.mark.parametrize("text", [OPAQUE, GLOWS])
def test_alpha_is_255_on_objects_and_0_beside_them(text: str, quality: str) -> None:
    scene = evaluate(text)
    mask = mask_of(scene, still(scene, Viewpoint(), 0, *SIZE))
    alpha = pixels(text, quality, ground="transparent")[:, :, 3]
    assert (alpha[inner(mask)] == 255).all()
    assert (alpha[inner(~mask)] == 0).all()
    assert 0 < ((alpha > 0) & (alpha < 255)).mean() < 0.1  # the edges
    assert alpha.mean() / 255 == pytest.approx(mask.mean(), abs=0.01)


@pytest.mark.parametrize("quality", QUALITIES)
@pytest.mark.parametrize("color", ["white", "black", "#3080f0"])
def test_alpha_over_a_background_is_the_image_with_it(color: str, quality: str) -> None:
    drawn = pixels(OPAQUE, quality, background=color)
    assert (drawn[:, :, 3] == 255).all()
    rgb = {"white": (255, 255, 255), "black": (0, 0, 0), "#3080f0": (48, 128, 240)}[color]
    over = composited(pixels(OPAQUE, quality, ground="transparent"), rgb)
    assert np.abs(over.astype(int) - drawn[:, :, :3]).max() <= 1
    assert (drawn[0, 0, :3] == rgb).all()


def test_alpha_over_the_backdrop_is_the_opaque_image_without_a_ground() -> None:
    opaque = pixels(OPAQUE, ground="none")[:, :, :3].astype(int)
    over = composited(pixels(OPAQUE, ground="transparent"), tuple(opaque[0, 0]))
    scene = evaluate(OPAQUE)
    mask = mask_of(scene, still(scene, Viewpoint(), 0, *SIZE))
    flat = inner(mask) | inner(~mask)
    assert np.abs(over - opaque)[flat].max() <= 1
    assert np.abs(over - opaque).mean() < 0.5  # edges are blended in sRGB, samples in linear light


def test_transparent_objects_have_partial_alpha() -> None:
    for quality, room in (("draft", 0), ("final", 30)):
        picture = pixels(GLASS, quality, ground="transparent")
        middle = picture[36, 48]
        assert abs(int(middle[3]) - round(255 * (1 - 0.6**2))) <= max(room, 1), quality
        assert middle[1] > middle[0]  # its own color, not mixed with a backdrop
    over = composited(pixels(GLASS, ground="transparent"), (255, 0, 0))
    assert np.abs(over.astype(int) - pixels(GLASS, background="red")[:, :, :3]).max() <= 1


@pytest.mark.parametrize("quality", QUALITIES)
def test_a_shadow_is_black_with_alpha(quality: str) -> None:
    clear, shadow = (pixels(OPAQUE, quality, ground=ground) for ground in ("transparent", "shadow"))
    only = (clear[:, :, 3] == 0) & (shadow[:, :, 3] > 0)
    assert 0.02 < (only & (shadow[:, :, 3] > 40)).mean() < 0.5
    assert (shadow[only][:, :3] == 0).all()
    assert shadow[0, 0, 3] == 0
    assert (shadow[:, :, 3].astype(int) >= clear[:, :, 3].astype(int) - 1).all()
    drawn = pixels(OPAQUE, quality, ground="shadow", background="white")
    assert np.abs(composited(shadow, (255, 255, 255)).astype(int) - drawn[:, :, :3]).max() <= 1


def test_flat_light_has_alpha_too() -> None:
    picture = pixels(OPAQUE, "final", ground="transparent", environment="flat")
    assert np.array_equal(picture, pixels(OPAQUE, ground="transparent", environment="flat"))
    assert not pixels(OPAQUE, ground="shadow", environment="flat")[0, 0, 3]


def test_labels_are_opaque() -> None:
    text = '(bind "a" (lambda () (call "vase of flowers")))'
    plain, written = (pixels(text, ground="transparent", labels=labels) for labels in (False, True))
    changed = (plain != written).any(axis=2)
    assert changed.any()
    assert (written[changed][:, 3] > 0).all()
    assert (written[:, :, 3] >= plain[:, :, 3]).all()


@pytest.mark.parametrize("ending", [".png", ".webp"])
def test_files_keep_alpha(ending: str, tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(OPAQUE)
    words = ["render", str(tmp_path / "a.scene"), "--size", "96x72", "--ground", "transparent", "-o"]
    assert main([*words, str(tmp_path / f"a{ending}")]) == 0
    written = np.asarray(Image.open(tmp_path / f"a{ending}"))
    assert written.shape == (72, 96, 4)
    assert np.array_equal(written[:, :, 3], pixels(OPAQUE, ground="transparent")[:, :, 3])
    saved = sl.evaluate(OPAQUE).render(size=SIZE, ground="transparent").save(tmp_path / f"b{ending}")
    assert Image.open(saved).mode == "RGBA"
    opaque = sl.evaluate(OPAQUE).render(size=SIZE).save(tmp_path / f"c{ending}")
    assert Image.open(opaque).mode == "RGB"


def test_exr_has_alpha_and_multiplied_radiance(tmp_path: Path) -> None:
    mi = pytest.importorskip("mitsuba")
    image = sl.evaluate(OPAQUE).render(size=SIZE, ground="transparent")
    image.save(tmp_path / "a.exr")
    bitmap = np.array(mi.Bitmap(str(tmp_path / "a.exr")))
    assert bitmap.shape == (72, 96, 4)
    assert np.allclose(bitmap[:, :, 3], image.pixels[:, :, 3] / 255.0, atol=1e-3)
    assert (bitmap[bitmap[:, :, 3] == 0.0] == 0.0).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--ground", "transparent", "-o", "a.jpg"], "a .jpg file has no transparency"),
        (["--ground", "shadow", "-o", "a.gif"], "a video has no transparency"),
        (["--ground", "white", "--background", "red"], "a flat background has no ground"),
        (["--background", "reddish"], "unknown color"),
        (["--ground", "transparant"], "transparent"),
    ],
)
def test_mistakes_are_usage_errors(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.scene").write_text(OPAQUE)
    assert main(["render", "a.scene", "--size", "24x18", *words]) == 2
    assert said in capsys.readouterr().err


def test_labels_and_films_have_no_alpha(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.scene").write_text(OPAQUE)
    words = ["labels", str(tmp_path / "a.scene"), "-o", str(tmp_path / "out"), "--size", "24x18"]
    assert main([*words, "--ground", "transparent"]) == 2
    assert "labeled images have no transparency" in capsys.readouterr().err
    scene = sl.evaluate(OPAQUE)
    with pytest.raises(SceneError, match="labeled images have no transparency"):
        scene.maps(ground="shadow", size=SIZE)
    with pytest.raises(SceneError, match="a video has no transparency"):
        scene.film(ground="transparent", size=(24, 18), frames=2).save(tmp_path / "a.gif")
    with pytest.raises(SceneError, match="JPEG has no transparency"):
        scene.render(ground="transparent", size=(24, 18)).save(tmp_path / "a.jpg")
    scene.film(background="white", size=(24, 18), frames=2).save(tmp_path / "a.gif")
    assert Image.open(tmp_path / "a.gif").n_frames == 2
