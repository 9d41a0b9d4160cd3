"""Ctrl-C in the middle of long work: one line, exit code 130, and nothing half-written."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import pytest
from sampling import only
from support import interruptible, wait_for_work

SCENE = '(bind "a" (lambda () (frames (for/list ((i (iota 30))) (transform (call "sphere") (translate [i 0 0]))))))'
WORK = {
    "a final picture": [
        "render",
        "a.scene",
        "-o",
        "out.png",
        "--quality",
        "final",
        "--samples",
        "60000",
        "--size",
        "400x300",
    ],
    "a film": ["render", "a.scene", "-o", "out.gif", "--size", "700x500"],
    "an mp4": ["render", "a.scene", "-o", "out.mp4", "--size", "700x500", "--frames", "300"],
    "labels": ["labels", "a.scene", "-o", ".", "--size", "700x500"],
}


@pytest.mark.parametrize("name", only(("labels", "a film"), WORK))
@pytest.mark.sampled(2)
def test_an_interruption_leaves_nothing_half_written(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(SCENE)
    words = [sys.executable, "-P", "-m", "scenelang", *WORK[name]]
    with interruptible(words, tmp_path) as running:
        wait_for_work(running.pid, 0.8)
        assert running.poll() is None, "the work was too short to be interrupted"
        running.send_signal(signal.SIGINT)
        _, said = running.communicate()
    assert running.returncode == 130, said.decode()
    assert said.decode().strip() == "interrupted"
    for folder in tmp_path.rglob("frame-*"):  # what is there is complete
        assert not os.listdir(folder) or (folder / "shot.json").exists()
    left = [path.name for path in tmp_path.rglob("*") if path.name.startswith((".scenelang", "out"))]
    assert left == []
