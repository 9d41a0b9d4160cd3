"""The toy distilled on a GPU, more Gaussians and more steps than elsewhere; how long it takes is printed."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from later import later
from toy.model import unpack

from distillation.test_toy import TOYS, likeness, views
from scenelang.backends.neural.distillation.run import load_checkpoint
from scenelang.cli.main import main

torch = later("torch")


@pytest.mark.gpu
def test_colors_and_shapes_on_cuda(tmp_path: Path) -> None:
    if not torch.cuda.is_available():
        pytest.skip("there is no GPU")
    toy = unpack(tmp_path / "toy")
    (tmp_path / "toys.scene").write_text(TOYS)
    words = ["distill", str(tmp_path / "toys.scene"), "-o", str(tmp_path / "run"), "--model", str(toy), "-q"]
    words += ["--steps", "600", "--gaussians", "20000", "--guidance", "7.5", "--no-scene-term", "--device", "cuda"]
    start = time.monotonic()
    assert main(words) == 0
    print(f"1,200 steps on {torch.cuda.get_device_name()}: {time.monotonic() - start:.0f} s")
    kept = load_checkpoint(tmp_path / "run")
    red, round_ = views(kept, 0)
    blue, square = views(kept, 1)
    assert red[0] > 0.7 > 0.3 > max(red[1:])
    assert blue[2] > 0.6 > 0.3 > max(blue[:2])
    assert likeness(round_, "sphere") > likeness(round_, "cube")
    assert likeness(square, "cube") > likeness(square, "sphere")
