"""Final pictures: exact shapes under any pose, materials, instancing, variants, and agreement with draft pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sampling import one_in, only
from support import calls, evaluate, session, unchecked

import scenelang
from scenelang.backends.pictures import mitsuba
from scenelang.backends.pictures.camera import PRESETS, Viewpoint
from scenelang.backends.pictures.draft import draw as draw_draft
from scenelang.backends.pictures.film import Image, PictureOptions, draw, picture_backend
from scenelang.backends.pictures.mitsuba import MITSUBA
from scenelang.backends.pictures.mitsuba_scene import parts_of
from scenelang.backends.pictures.stage import staging_of, still
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.environments import ENVIRONMENTS, FADED, GROUNDS
from scenelang.backends.surfaces.image_files import encode
from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten_entity

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def image(scene: Scene, quality: str = "final", size: tuple[int, int] = (96, 72), **options: Any) -> Image:
    given = {"samples": 16} | options.pop("settings", {})
    settings = given if quality == "final" else {}
    chosen = PictureOptions(width=size[0], height=size[1], settings=settings, labels=False, **options)
    return draw(scene, chosen, picture_backend(quality))


def both(scene: Scene, **options: Any) -> tuple[np.ndarray, np.ndarray]:
    return tuple(image(scene, quality, **options).picture.astype(float) for quality in ("draft", "final"))  # type: ignore[return-value]


@pytest.mark.slow
def test_solids_are_solid_and_right_under_any_pose(make: Any) -> None:
    """Silhouettes agree with the analytic caster for sheared, mirrored and stretched solids of every kind."""
    scene = make.odd()
    options = {"size": (480, 360), "ground": "none", "camera": Viewpoint(20, 30)}
    backdrop = np.array(ENVIRONMENTS["studio"].backdrop)
    masks = []
    for quality in ("draft", "final"):
        found = image(scene, quality, settings={"denoise": "off"}, **options)
        masks.append(np.abs(found.radiance - backdrop).max(axis=2) > 0.12)
    overlap = (masks[0] & masks[1]).sum() / (masks[0] | masks[1]).sum()
    assert masks[0].sum() > 10_000
    assert overlap > 0.995


@pytest.mark.parametrize("flat", [0.0, 1e-4, 1e-3, 0.01, 0.1])
@pytest.mark.sampled(5)
def test_flat_balls_are_disks(flat: float) -> None:
    """Mitsuba's own sphere dissolves when it is squeezed."""
    ball = f'(transform (call "sphere" :color [.05 .05 .05]) (scale [1 {flat} 1]))'
    scene = evaluate(
        f'(bind "a" (lambda () (union {ball} (transform (call "cube" :scale .2 :color [.1 .1 .1]) (translate [0 -1 0])))))'
    )
    backdrop = np.array(ENVIRONMENTS["studio"].backdrop)
    masks = []
    for quality in ("draft", "final"):
        found = image(
            scene, quality, size=(200, 150), camera=Viewpoint(0, 50), ground="none", settings={"denoise": "off"}
        )
        masks.append(np.abs(found.radiance - backdrop).max(axis=2) > 0.1)
    assert masks[0].sum() > 3000
    assert (masks[0] & masks[1]).sum() / (masks[0] | masks[1]).sum() > 0.985


def test_a_cylinder_is_seen_from_above_with_its_cap_and_a_mirrored_ball_is_not_black(make: Any) -> None:
    from tests.backends.conftest import MIRROR  # type: ignore[import-not-found]

    cylinder = image(evaluate('(bind "a" (lambda () (call "cylinder" :color [.8 .1 .1])))'), camera=PRESETS["top"])
    red = cylinder.picture[36, 48].astype(int)
    assert red[0] > 150 > 1.7 * red[1]
    ball = make.primitive("sphere", color=(0.8, 0.8, 0.8))
    for pose in ((ball, MIRROR), ball):
        middle = image(make.scene(pose), camera=Viewpoint(0, 0)).picture[30:42, 42:54]
        assert middle.mean() > 90


MATERIALS = {
    "rough": ":color [.7 .2 .1] :roughness .8",
    "plastic": ":color [.1 .3 .7] :roughness .15",
    "gold": ":color [.9 .7 .3] :metallic 1 :roughness .3",
    "veil": ":color [.2 .7 .3] :opacity .4",
    "lamp": ":color [.9 .8 .5] :emission .6",
}


@pytest.mark.parametrize("name", list(MATERIALS))
@pytest.mark.parametrize("word", ["sphere", "cube"])
@pytest.mark.sampled(2)
def test_materials_agree_in_draft_and_final(name: str, word: str) -> None:
    text = f'(bind "a" (lambda () (union (call "{word}" {MATERIALS[name]}) (transform (call "cube" :color [.9 .9 .9]) (translate [0 0 -3])))))'
    draft, final = both(evaluate(text))
    assert np.abs(draft - final).mean() < 9
    assert np.abs(draft.mean(axis=(0, 1)) - final.mean(axis=(0, 1))).max() < 0.04 * 255


def test_glass_refracts_and_gloss_reflects() -> None:
    stripes = "".join(
        f'(transform (call "cube" :scale [.2 3 .1] :color [.8 0 0]) (translate [{x / 2} 0 -2]))' for x in range(-3, 4)
    )
    text = '(bind "a" (lambda () (union {} (call "sphere" :color [1 1 1] :opacity .1 {}))))'
    clear, glass = (
        image(evaluate(text.format(stripes, more)), camera=Viewpoint(0, 0)).picture.astype(int)
        for more in ("", ":ior 1.5")
    )
    assert np.abs(clear - glass)[24:48, 36:60].mean() > 15
    matte, gloss = (
        image(
            evaluate(f'(bind "a" (lambda () (call "sphere" :color [.1 .1 .1] {more})))'), camera=Viewpoint(0, 10)
        ).radiance
        for more in ("", ":roughness .1")
    )
    assert gloss.max() > 2 * np.percentile(matte, 99)


@pytest.mark.parametrize(
    ("attributes", "said"),
    [
        (':roughness "much"', "roughness"),
        (":metallic [1 2]", "metallic"),
        (":ior .5", "from 1 to 4"),
        (":ior nan", "ior"),
        (":opacity 'x", "opacity"),
        (":emission [1 2]", "emission"),
    ],
)
def test_attributes_that_make_no_material_are_told(attributes: str, said: str) -> None:
    source = Source("<test>", f'(bind "a" (lambda () (call "sphere" {attributes})))')
    with unchecked(), pytest.raises(SceneError, match=said) as caught:
        image(session().evaluate(source).require(), "draft")
    assert caught.value.name == "attribute"


def test_materials_are_read_from_attributes(make: Any) -> None:
    look = look_of(
        make.primitive("sphere", roughness=2, metallic=-1, opacity=0.5, ior=1.4, emission=0.5, color=(0.5, 0.5, 0.5))
    )
    assert (look.roughness, look.metallic, look.opacity, look.ior) == (1.0, 0.0, 0.5, 1.4)
    assert look.emission == (0.25, 0.25, 0.25)
    assert look_of(make.primitive("sphere")).is_matte
    assert not look.is_matte


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_a_scene_that_cannot_be_seen_is_told(quality: str) -> None:
    with pytest.raises(SceneError, match=":opacity 0") as caught:
        image(evaluate('(bind "a" (lambda () (call "sphere" :opacity 0)))'), quality)
    assert caught.value.name == "empty-scene"


@pytest.mark.parametrize("environment", list(ENVIRONMENTS))
@pytest.mark.sampled(2)
def test_environments_agree_in_draft_and_final(environment: str) -> None:
    scene = evaluate(
        '(bind "a" (lambda () (union (call "sphere" :color [.8 .3 .1]) (transform (call "cube" :scale [6 .1 6]) (translate [0 -1.05 0])))))'
    )
    draft, final = both(scene, environment=environment)
    assert np.abs(draft.mean(axis=(0, 1)) - final.mean(axis=(0, 1))).max() < 0.04 * 255


@pytest.mark.parametrize("ground", list(GROUNDS))
@pytest.mark.parametrize("view", [Viewpoint(30, 30), PRESETS["isometric"]])
@pytest.mark.sampled(3)
def test_grounds_agree_in_draft_and_final(ground: str, view: Viewpoint) -> None:
    scene = evaluate('(bind "a" (lambda () (call "cube" :color [.8 .3 .1])))')
    draft, final = both(scene, ground=ground, camera=view, size=(64, 48))
    assert np.abs(draft - final).mean() < 8


COLORS = [(0.8, 0.1, 0.05), (0.02, 0.02, 0.02), (0.5, 0.5, 0.5), (1.0, 1.0, 1.0), (0.0, 0.2, 0.6)]


@pytest.mark.parametrize(
    "color",
    one_in(5, map(pytest.param, COLORS)),
)
def test_a_flat_patch_has_one_color_everywhere(color: tuple[float, ...], tmp_path: Path) -> None:
    """Draft, final, and a GLB that is exported and read back, agree within 2/255; flat light shows the color itself."""
    given = " ".join(map(str, color))
    text = f'(bind "patch" (lambda () (call "cube" :scale [4 .1 4] :color [{given}])))'
    (tmp_path / "a.scene").write_text(text)
    assert main(["export", str(tmp_path / "a.scene"), "-o", str(tmp_path / "a.glb"), "-q"]) == 0
    (tmp_path / "b.scene").write_text('(bind "copy" (lambda () (call "mesh" :file "a.glb")))')
    expected = encode(np.array(color)).astype(int)
    middles = []
    for name in ("a", "b"):
        scene = scenelang.load(tmp_path / f"{name}.scene").graph
        for quality in ("draft", "final"):
            for environment in ("studio", "flat"):
                found = image(scene, quality, camera=PRESETS["top"], environment=environment, settings={"samples": 64})
                middle = found.picture[32:40, 44:52].reshape(-1, 3).mean(axis=0)
                if environment == "flat":
                    assert np.abs(middle - expected).max() <= 2
                else:
                    middles.append(middle)
    assert np.ptp(np.array(middles), axis=0).max() <= 2


def test_isometric_pictures_are_parallel() -> None:
    scene = evaluate('(bind "a" (lambda () (union (call "cube") (transform (call "cube") (translate [0 0 -6])))))')
    camera = still(scene, PRESETS["isometric"], 0, 96, 72).camera
    assert camera.is_parallel
    draft, final = both(scene, camera=PRESETS["isometric"])
    assert np.abs(draft - final).mean() < 4
    lengths = [np.diff(camera.project(np.array([[0, 0, z], [1.0, 0, z]]))[0], axis=0) for z in (0.0, -6.0)]
    assert lengths[0] == pytest.approx(lengths[1])


def test_a_lens_blurs_what_is_out_of_focus() -> None:
    scene = evaluate(
        '(bind "a" (lambda () (union-loop 6 (lambda (i) (transform (call "cube" :scale .5 :color [.8 .1 .1]) (translate [0 0 (- i)]))))))'
    )
    sharp = image(scene, camera=Viewpoint(40, 20)).picture.astype(float)
    blurred = image(scene, camera=Viewpoint(40, 20, aperture=0.4)).picture.astype(float)
    edges = [np.abs(np.diff(one.mean(axis=2), axis=1)) for one in (sharp, blurred)]
    assert np.percentile(edges[1], 99) < 0.8 * np.percentile(edges[0], 99)


def test_exr_is_linear(tmp_path: Path) -> None:
    import mitsuba as mi

    (tmp_path / "a.scene").write_text('(bind "a" (lambda () (call "sphere" :emission 4 :color [1 .5 .25])))')
    for quality in ("draft", "final"):
        out = tmp_path / f"{quality}.exr"
        command = ["render", str(tmp_path / "a.scene"), "-o", str(out), "--quality", quality, "--size", "32x32"]
        assert main([*command, "--ground", "seamless"]) == 0
        values = np.array(mi.Bitmap(str(out)))
        assert values.shape == (32, 32, 3)
        # the sphere's own light and no more than what a white surface reflects of the room
        assert values[16, 16] == pytest.approx([4.6, 2.3, 1.15], rel=0.25)
        assert values[1, 1] == pytest.approx(FADED * np.array(ENVIRONMENTS["studio"].backdrop), rel=0.2)


# --- instancing ------------------------------------------------------------------------------------------------


def sponge(level: int) -> Scene:
    return scenelang.load(EXAMPLES / "menger-sponge.scene", defines={"level": level}).graph


def test_a_shared_scene_becomes_few_prototypes() -> None:
    scene = sponge(4)
    staging = staging_of(scene, [0], 1_000_000)
    parts = parts_of(staging, 0)
    assert parts is not None
    stored = sum(len(one.solids) + len(one.matrices) for one in parts.prototypes) + len(parts.loose)
    assert sum(len(one.solids) * len(one.matrices) for one in parts.prototypes) + len(parts.loose) == 160_000
    assert stored < 2000
    # every placed solid is where flattening puts it
    placed = []
    for one in parts.prototypes:
        for matrix in one.matrices[:50]:
            placed.append(one.solids.matrices[:, :, 3] @ matrix[:, :3].T + matrix[:, 3])
    flat = flatten_entity(scene.root).matrices[:, :, 3]
    known = {tuple(row) for row in np.round((flat - staging.center) * staging.scale, 6) + 0.0}
    assert all(tuple(row) in known for row in np.round(np.concatenate(placed), 6) + 0.0)


def test_nothing_shared_is_no_prototype(make: Any) -> None:
    parts = [make.primitive("sphere", radius=0.1 + i / 1000) for i in range(50)]
    staging = staging_of(make.scene(*parts), [0], 1000)
    assert parts_of(staging, 0) is None


def test_instances_look_like_what_they_are_instances_of(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = sponge(2)
    plain = image(scene, settings={"denoise": "off"})
    monkeypatch.setattr("scenelang.backends.pictures.mitsuba.FEW", 10)
    placed = image(scene, settings={"denoise": "off"})
    assert np.abs(plain.picture.astype(int) - placed.picture).mean() < 5  # two samples of one noise
    assert np.abs(plain.radiance.mean(axis=(0, 1)) - placed.radiance.mean(axis=(0, 1))).max() < 0.005


def test_lamps_in_shared_parts_light_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing that shines is instanced: Mitsuba forbids it."""
    text = (
        '(bind "post" (lambda () (union-loop 5 (lambda (i) (transform (call "cube" :scale .2) (translate [0 (* .2 i) 0]))))))'
        '(bind "lamp" (lambda () (union (call "post") (transform (call "sphere" :radius .2 :emission 3) (translate [0 1.1 0])))))'
        '(bind "street" (lambda () (union-loop 12 (lambda (i) (transform (call "lamp") (translate [i 0 0]))))))'
    )
    scene = evaluate(text)
    monkeypatch.setattr("scenelang.backends.pictures.mitsuba.FEW", 4)
    parts = parts_of(staging_of(scene, [0], 1000), 0)
    assert parts is not None
    assert {one.entity.word for one in parts.prototypes} == {"post"}
    assert image(scene, environment="night").radiance.max() > 1.0


def load_solids(count: int) -> None:
    """Make Mitsuba's shapes of so many solids in twenty materials."""
    text = f"""
    (define looks (for/list ((i (iota 20))) (list (/ i 20) (/ (% (* i 7) 20) 20) (/ i 25))))
    (bind "field" (lambda () (for/union ((i (iota {count})))
      (define look (ref looks (% i 20)))
      (define c (vector (first look) (second look) .5))
      (define s (+ .02 (* i 1e-7)))
      (define one (case (% i 4)
        ((0) (call "sphere" :radius s :color c :roughness (third look)))
        ((1) (call "cylinder" :radius s :p1 [0 .05 0] :color c :roughness (third look)))
        ((2) (call "cone" :radius s :p1 [0 .05 0] :color c :roughness (third look)))
        (else (call "cube" :scale s :color c :roughness (third look)))))
      (transform one (@ (translate [(% i 47) (% i 53) (% i 59)]) (rotate i [1 2 3]) (scale [1 2 1]) (rotate 1 [1 0 0]))))))
    """
    scene = evaluate(text)
    options = PictureOptions(width=64, height=64, settings={"samples": 1, "denoise": "off"})
    shot = still(scene, Viewpoint(), 0, 64, 64)
    staging = staging_of(scene, [0], 200_000)
    assert MITSUBA.painter is not None
    painter: Any = MITSUBA.painter(staging, options, 1)
    stage = staging.stage(shot)
    from scenelang.backends.pictures.mitsuba_scene import surroundings

    painter.mitsuba.load_dict(surroundings(painter.mitsuba, stage, 8) | painter.shapes_of(0, stage))


def test_twice_the_solids_take_twice_the_calls() -> None:
    load_solids(10)  # what is made once
    few, many = (calls(lambda n=n: load_solids(n)) for n in (1_000, 2_000))
    assert many < 2.3 * few


# --- variants --------------------------------------------------------------------------------------------------


def test_variants_are_tried_before_they_are_used(monkeypatch: pytest.MonkeyPatch) -> None:
    assert mitsuba.works("scalar")
    monkeypatch.setattr(mitsuba, "works", lambda name: False)
    with pytest.raises(SceneError, match="no compatible NVIDIA GPU") as caught:
        mitsuba.use("cuda", 1, False)
    assert caught.value.hint == "use `--variant scalar`, which works everywhere"
    with pytest.raises(SceneError, match=r"no compatible LLVM \(Debian"):
        mitsuba.use("llvm", 1, False)
    assert mitsuba.use("auto", 10**9, False).variant() == "scalar_rgb"


def test_many_samples_take_llvm_where_it_works(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    class Fake:
        LogLevel = type("LogLevel", (), {"Error": 0})

        def variant(self) -> str:
            return ""

        def set_variant(self, name: str) -> None:
            asked.append(name)

        def set_log_level(self, level: int) -> None: ...

    monkeypatch.setattr(mitsuba, "require", lambda *_: Fake())
    monkeypatch.setattr(mitsuba, "works", lambda name: True)
    for choice, samples, crowded in (
        ("auto", 10**9, False),
        ("auto", 10**9, True),
        ("auto", 10, False),
        ("cuda", 1, True),
    ):
        mitsuba.use(choice, samples, crowded)
    assert asked == ["llvm_ad_rgb", "scalar_rgb", "scalar_rgb", "cuda_ad_rgb"]


def test_llvm_draws_the_same_picture(make: Any) -> None:
    if not mitsuba.works("llvm"):
        pytest.skip("no LLVM that Mitsuba can use is installed (Debian: libllvm19)")
    a, b = (image(make.odd(), settings={"variant": name}).picture.astype(float) for name in ("scalar", "llvm"))
    assert np.abs(a - b).mean() < 4


@pytest.mark.gpu
def test_cuda_draws_the_same_picture(make: Any) -> None:
    a, b = (image(make.odd(), settings={"variant": name}).picture.astype(float) for name in ("scalar", "cuda"))
    assert np.abs(a - b).mean() < 4


_ALL = sorted(path.stem for path in EXAMPLES.glob("*.scene"))
_SMALL = {*_ALL} - {"fractal-tree", "menger-sponge", "toys"}


@pytest.mark.parametrize("name", only(_SMALL, _ALL))
@pytest.mark.sampled(4)
def test_examples_have_the_same_mean_color_in_draft_and_final(name: str) -> None:
    draft, final = both(scenelang.load(EXAMPLES / f"{name}.scene").graph, size=(64, 48))
    assert np.abs(draft.mean(axis=(0, 1)) - final.mean(axis=(0, 1))).max() < 0.08 * 255


def test_a_guide_is_drawn_without_light(make: Any) -> None:
    stage = staging_of(make.odd(), [0], 100).stage(still(make.odd(), Viewpoint(), 0, 32, 24))
    assert (draw_draft(stage, shaded=False).ids == draw_draft(stage).ids).all()
