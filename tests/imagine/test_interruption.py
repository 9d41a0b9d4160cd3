"""Ctrl-C while `scenelang imagine` draws."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import pytest
from small_diffusion import small_diffusion
from support import interruptible, wait_until

PROGRAM = '(bind "beach" (lambda () (call "moai" :scale [1 2 1])))'


@pytest.mark.slow
def test_interrupted_runs_leave_nothing_half_written(tmp_path: Path) -> None:
    from PIL import Image

    checkpoint = small_diffusion(tmp_path / "sd")
    place = tmp_path / "work"
    place.mkdir()
    (place / "beach.scene").write_text(PROGRAM, "utf-8")
    words = [
        sys.executable,
        "-P",
        "-m",
        "scenelang",
        "imagine",
        "beach.scene",
        "-o",
        "a.png",
        "--count",
        "900",
    ]
    with interruptible([*words, "--steps", "2", "--device", "cpu", "--model", str(checkpoint)], place) as running:
        wait_until(lambda: (place / "a-1.png").exists() or running.poll() is not None)
        running.send_signal(signal.SIGINT)
        _, error = running.communicate()
    assert running.returncode == 130
    assert b"Traceback" not in error
    made = sorted(place.glob("a-*.png"))
    assert made
    for path in made:
        with Image.open(path) as picture:
            picture.load()
    assert sorted(place.iterdir()) == sorted([place / "beach.scene", *made])
