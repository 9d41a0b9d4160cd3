"""End to end on the toy diffusion model that is committed: the command distils red balls and blue cubes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from later import later
from small_models import seeded
from toy.model import build, unpack
from toy.pictures import Orbit, picture
from toy.train import loss_of, train

from scenelang.backends.neural.clip import ClipName, TextEncoder, load_clip
from scenelang.backends.neural.diffusion_loading import load_diffusion
from scenelang.backends.neural.distillation.run import SavedDistillation, load_checkpoint
from scenelang.backends.neural.distillation.training import orbit_cameras
from scenelang.backends.neural.splats.files import read_gaussians
from scenelang.backends.neural.splats.gaussians import apply_pose, view_of
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.cli.main import main
from scenelang.files import beside

torch = later("torch")

TOYS = """
(bind "toys" (lambda () (union
  (transform (call "sphere" (embedding <z2> "red")) (translate [-1.5 0 0]))
  (transform (call "cube" (embedding <z3> "blue")) (translate [1.5 0 0])))))
"""
WORK = ["--guidance", "7.5", "--no-scene-term", "--device", "cpu", "-q"]
WHOLE = ["--steps", "120", "--gaussians", "450", *WORK]
SKETCH = ["--steps", "40", "--gaussians", "200", *WORK]


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    seeded()
    return unpack(tmp_path_factory.mktemp("models") / "toy")


def distilled(folder: Path, toy: Path, work: list[str]) -> Path:
    """A folder with the program and a run of it."""
    seeded()
    (folder / "toys.scene").write_text(TOYS)
    assert main(["distill", str(folder / "toys.scene"), "-o", str(folder / "run"), "--model", str(toy), *work]) == 0
    return folder


@pytest.fixture(scope="module")
def place(toy: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return distilled(tmp_path_factory.mktemp("work"), toy, WHOLE)


def views(kept: SavedDistillation, figure: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean color (3,) where a figure hides anything, and how much it hides (4, 64, 64), from four sides."""
    gaussians = kept.groups()[figure]
    splats = apply_pose(gaussians, torch.eye(3), torch.zeros(3))
    drawn = [rasterise(splats, view_of(camera, splats.means)) for camera in orbit_cameras(4, 64, 20.0, 15.0, 40.0, 1.1)]
    alpha = np.stack([one.alpha.numpy() for one in drawn])
    color = np.stack([one.color.numpy() for one in drawn])
    return color.sum((0, 1, 2)) / alpha.sum(), alpha


def likeness(alpha: np.ndarray, shape: str) -> float:
    """Overlap over union with the silhouette that the training pictures have of ``shape``."""
    up, half = np.radians((15.0, 20.0))
    orbits = [Orbit(np.radians(20.0 + 90.0 * i), up, 1.1 / np.tan(half), half) for i in range(4)]
    true = np.stack([(picture(shape, (1, 0, 0), orbit, 64)[0] != 0.5).numpy() for orbit in orbits])
    seen = alpha > 0.5
    return float((true & seen).sum() / (true | seen).sum())


@pytest.mark.slow
def test_colors_and_shapes_are_those_of_the_sentences(place: Path) -> None:
    kept = load_checkpoint(place / "run")
    red, round_ = views(kept, 0)
    blue, square = views(kept, 1)
    assert red[0] > 0.7
    assert max(red[1:]) < 0.25
    assert blue[2] > 0.6
    assert max(blue[:2]) < 0.25
    assert likeness(round_, "sphere") > max(0.7, likeness(round_, "cube"))
    assert likeness(square, "cube") > max(0.75, likeness(square, "sphere"))


@pytest.mark.slow
def test_what_a_run_leaves(place: Path) -> None:
    made = {path.name for path in (place / "run").iterdir()}
    assert made == {"state.safetensors", "losses.jsonl", "preview.png", "scene.ply", "poses.json"}
    told = json.loads((place / "run" / "poses.json").read_text())
    assert [actor["handle"] for actor in told["actors"]] == ["<z2>", "<z3>"]
    assert [actor["path"][0][0] for actor in told["actors"]] == [-1.5, 1.5]
    assert "red" in told["figures"][0]["sentence"]
    gaussians = read_gaussians(place / "run" / "scene.ply")
    left = gaussians.means[:, 0] < 0
    assert float(gaussians.colors[left, 0].median()) > 0.5
    assert float(gaussians.colors[~left, 2].median()) > 0.5
    losses = [json.loads(line) for line in (place / "run" / "losses.jsonl").read_text().splitlines()]
    assert [row["step"] for row in losses] == list(range(1, 241))
    early, late = (np.mean([row["figure"] for row in part]) for part in (losses[:40], losses[-40:]))
    assert late < early / 4


@pytest.mark.slow
def test_swapping_an_embedding_changes_only_its_entity(place: Path, toy: Path) -> None:
    """A new text for <z2> makes that thing again; the other is taken over as it is."""
    program = str(place / "toys.scene")
    try:
        assert main(["embeddings", program, "set", "<z2>", "--text", "green", "-q"]) == 0
        words = ["distill", program, "-o", str(place / "green"), "--start", str(place / "run"), "--model", str(toy)]
        assert main([*words, *WHOLE]) == 0
    finally:
        beside(program).unlink(missing_ok=True)
    before, after = load_checkpoint(place / "run"), load_checkpoint(place / "green")
    assert all(
        before.tensors[name].equal(after.tensors[name]) for name in before.tensors if name.startswith("figure/1/")
    )
    green = views(after, 0)[0]
    assert green[1] > 0.6
    assert max(green[0], green[2]) < 0.3


@pytest.mark.slow
def test_distilled_scenes_are_drawn(toy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from PIL import Image

    place = distilled(tmp_path, toy, SKETCH)
    words = ["render", str(place / "toys.scene"), "--backend", "splats", "--camera", "azimuth=0,elevation=5"]
    words += ["--distilled", str(place / "run"), "-o", str(place / "a.png"), "--size", "120x80", "-q"]
    assert main(words) == 0
    pixels = np.asarray(Image.open(place / "a.png")).astype(float)
    assert pixels[40, 30, 0] > 2 * pixels[40, 30, 2]  # red on the left
    assert pixels[40, 90, 2] > 2 * pixels[40, 90, 0]
    assert main([*words, "--distilled", str(place)]) == 1
    assert "no distillation in" in capsys.readouterr().err


@pytest.mark.slow
def test_training_makes_the_loss_smaller(tmp_path: Path) -> None:
    """Twenty steps of the script that made the committed weights, measured on the same pictures and noise."""
    seeded()
    folder = build(tmp_path / "toy")
    model, clip = load_diffusion(folder), load_clip(ClipName(str(folder / "text")))

    def measured() -> float:
        with torch.no_grad():
            losses = [loss_of(model, TextEncoder(clip), torch.Generator().manual_seed(seed)) for seed in range(3)]
        return float(np.mean(losses))

    before = measured()
    train(model, clip, 20)
    assert measured() < 0.9 * before


def test_the_weights_are_a_few_megabytes() -> None:
    from toy.model import WEIGHTS

    assert WEIGHTS.stat().st_size < 6_000_000
