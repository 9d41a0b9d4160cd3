"""`scenelang distill` from outside: breaks, wrong usage, absent and wrong weights, 4D scenes."""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from later import later
from loaded_once import loaded_once as loaded_once
from small_models import seeded, small_diffusion
from support import interruptible, wait_for_more_work

from scenelang.backends.neural.distillation import run as runs
from scenelang.backends.neural.distillation.run import load_checkpoint
from scenelang.cli.main import main

torch = later("torch")
pytestmark = pytest.mark.usefixtures("loaded_once")

TWO = '(bind "toys" (lambda () (union (call "sphere") (transform (call "cube") (translate [3 0 0])))))'
MOVING = """
; Two balls that part.
(bind "toys" (lambda () (frames (list
  (union (call "sphere") (transform (call "sphere") (translate [2 0 0])))
  (union (call "sphere") (transform (call "sphere") (translate [3 0 0])))))))
"""


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    seeded()
    folder = tmp_path_factory.mktemp("models")
    small_diffusion(folder / "figures", pixels=True)
    small_diffusion(folder / "scene", views=False, control=True)
    return folder


@pytest.fixture
def words(models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SCENELANG_MODELS", str(models))
    Path("a.scene").write_text(TWO, "utf-8")
    return ["distill", "a.scene", "-o", "run", "--model", "figures", "--scene-model", "scene", *_SMALL]


_SMALL = ["--device", "cpu", "--gaussians", "40", "--steps", "3", "--offline"]


def said(capsys: pytest.CaptureFixture[str]) -> str:
    return capsys.readouterr().err


def test_a_run_that_was_killed_goes_on(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Its file is from before the kill; what came after is made again, exactly."""
    assert main([*words, "-o", "whole", "-q"]) == 0
    monkeypatch.setattr(runs, "_CHECKPOINT_INTERVAL", 0.0)
    monkeypatch.setattr(runs, "_MAX_OVERHEAD", 1e9)
    step, made = runs.DistillationTrainer.step, []

    def fatal(self: Any, share: Any = None) -> Any:
        if self.step_number == 4 and not made:
            made.append(1)
            raise MemoryError
        return step(self, share)

    monkeypatch.setattr(runs.DistillationTrainer, "step", fatal)
    main([*words, "-q"])
    assert made
    assert int(load_checkpoint(Path("run")).tensors["step"]) == 4
    assert main([*words, "--resume", "-q"]) == 0
    one, other = load_checkpoint(Path("whole")).tensors, load_checkpoint(Path("run")).tensors
    assert all(one[name].equal(other[name]) for name in one)
    lines = [json.loads(line)["step"] for line in Path("run/losses.jsonl").read_text().splitlines()]
    assert lines == list(range(1, 7))


@pytest.mark.slow
def test_ctrl_c_keeps_the_run(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    command = [sys.executable, "-P", "-m", "scenelang", *words, "--steps", "100000"]
    with interruptible(command, Path.cwd()) as running:
        assert running.stderr is not None
        while b"to optimize" not in running.stderr.readline():  # it tells that it begins
            assert running.poll() is None
        wait_for_more_work(running.pid, 1.0)
        running.send_signal(signal.SIGINT)
        _, told = running.communicate()
    assert running.returncode == 130
    assert told.decode().splitlines()[-2:] == ["saved to run; continue with `--resume`", "interrupted"]
    assert int(load_checkpoint(Path("run")).tensors["step"]) >= 1
    assert not [path for path in Path("run").iterdir() if path.name.startswith(".")]


@pytest.mark.slow
def test_a_run_is_not_overwritten_unasked(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, "-q"]) == 0
    assert main(words) == 1
    assert "run already contains a run" in said(capsys)
    assert main([*words, "--force", "-q"]) == 0
    assert main([*words, "--resume", "--seed", "5"]) == 1
    assert "other settings: seed" in said(capsys)
    assert main([*words, "--resume", "--steps", "4", "-q"]) == 0  # more of the same is allowed
    assert int(load_checkpoint(Path("run")).tensors["step"]) == 8


def test_a_budget_ends_in_time(words: list[str]) -> None:
    assert main([*words, "--steps", "1000000", "--budget", "0.02", "-q"]) == 0
    assert load_checkpoint(Path("run")).seconds >= 1.2
    assert Path("run/scene.ply").exists()


@pytest.mark.slow
def test_frames_have_one_theta_and_their_own_poses(words: list[str]) -> None:
    Path("a.scene").write_text(MOVING, "utf-8")
    assert main([*words, "--steps", "9", "--film", "film.gif", "-q"]) == 0
    told = json.loads(Path("run/poses.json").read_text())
    assert len(told["figures"]) == 1
    first, second = told["actors"]
    assert [len(actor["poses"]) for actor in (first, second)] == [2, 2]
    (ax, *_), (bx, *_) = second["path"]
    assert ax == pytest.approx(2.0, abs=0.3)
    assert bx == pytest.approx(3.0, abs=0.3)
    assert ax != 2.0  # the term of the scene moved it
    assert sorted(path.name for path in Path("run").glob("*.ply")) == ["scene-000.ply", "scene-001.ply"]
    from PIL import Image

    assert Image.open("film.gif").n_frames == 2
    assert load_checkpoint(Path("run")).config["prompt"] == "Two balls that part"


@pytest.mark.parametrize(
    ("more", "code", "message"),
    [
        (["--model", "nothing"], 1, "the weights of `nothing` are not available"),
        (["--model", "scene/unet"], 1, "E707"),
        (["--scene-model", "figures"], 1, "E707"),
        (["--depth", "1", "--entity", "house"], 1, "the scene has no entity `house`"),
        (["--steps", "0"], 2, "at least 1 step"),
        (["--film", "nowhere/a.gif"], 1, "nowhere"),
        (["--resume", "--start", "b"], 2, "cannot be combined with"),
        (["--resume", "--force"], 2, "cannot be combined with"),
        (["--resume"], 1, "no distillation in run"),
        (["--start", "b"], 1, "no distillation in b"),
        (["-o", "a.scene"], 1, "cannot be a folder"),
        (["--device", "tpu"], 1, "unknown device `tpu`"),
        (["--template", "a {color} thing"], 1, "unknown placeholder `{color}` in the template"),
        (["--film", "a.txt"], 1, "cannot write a film as `a.txt`"),
    ],
)
def test_wrong_usage_is_one_line(
    words: list[str], more: list[str], code: int, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, *more]) == code
    told = said(capsys)
    assert message in told
    assert "Traceback" not in told
    assert not Path("run/state.safetensors").exists()


def test_nothing_left_to_learn_is_told(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, "-q"]) == 0
    assert main([*words, "-o", "again", "--start", "run"]) == 1
    assert "nothing to optimize" in said(capsys)


@pytest.mark.slow
def test_what_was_taken_over_stays_after_a_break(words: list[str]) -> None:
    assert main([*words, "-q"]) == 0
    Path("a.scene").write_text(TWO.replace('(call "sphere")', '(call "sphere" :text "golden")'), "utf-8")
    assert main([*words, "-o", "again", "--start", "run", "-q"]) == 0
    before = load_checkpoint(Path("again"))
    assert before.frozen == (1,)
    assert main([*words, "-o", "again", "--resume", "--steps", "5", "-q"]) == 0
    after = load_checkpoint(Path("again"))
    assert int(after.tensors["step"]) == 5
    assert not before.tensors["figure/0/theta/means"].equal(after.tensors["figure/0/theta/means"])
    for name in (name for name in before.tensors if name.startswith("figure/1/")):
        assert before.tensors[name].equal(after.tensors[name])


def test_an_empty_scene_and_a_run_of_another_one(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, "-q"]) == 0
    Path("a.scene").write_text('(bind "other" (lambda () (call "cone")))', "utf-8")
    assert main(["render", "a.scene", "--backend", "splats", "--distilled", "run", "-o", "a.png"]) == 1
    assert "is of another scene" in said(capsys)
    Path("a.scene").write_text('(bind "e" (lambda () (union)))', "utf-8")
    for command in (words, ["embeddings", "a.scene", "encode"]):
        assert main([*command, "--force"] if command is words else command) == 1
        told = said(capsys)
        assert "no primitives" in told
        assert "internal error" not in told


def test_frames_without_anything_are_left_out(words: list[str]) -> None:
    Path("a.scene").write_text('(bind "a" (lambda () (frames (list (union) (call "sphere")))))', "utf-8")
    assert main([*words, "--steps", "5", "-q"]) == 0
    assert [path.name for path in Path("run").glob("*.ply")] == ["scene-001.ply"]


def test_models_that_give_no_numbers_are_told(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.backends.neural.diffusion import DiffusionModel

    monkeypatch.setattr(DiffusionModel, "predict", lambda self, latents, *_: latents * float("nan"))
    assert main(words) == 1
    assert int(load_checkpoint(Path("run")).tensors["step"]) == 0
