"""The README's spec makes 1,000 samples, and a tiny network learns to count on them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from scenelang.datasets.running import dataset

ROOT = Path(__file__).parents[2]
SPEC = ROOT / "examples" / "datasets" / "clevr.toml"


def test_the_readme_shows_the_spec() -> None:
    text = SPEC.read_text("utf-8")
    assert f"```toml\n{text}```" in (ROOT / "README.md").read_text("utf-8")
    assert len(text.splitlines()) == 10


@pytest.mark.slow
def test_every_spec_of_the_examples_makes_samples(tmp_path: Path) -> None:
    for path in sorted(SPEC.parent.glob("*.toml")):
        report = dataset(path, tmp_path / path.stem, jobs=0, count=2)
        assert (report.samples, report.failures) == (2, {}), path


@pytest.mark.slow
def test_a_network_counts_better_than_chance(tmp_path: Path) -> None:
    report = dataset(SPEC, tmp_path / "clevr", jobs=2)
    assert (report.samples, report.failures) == (1000, {})
    program = [sys.executable, str(SPEC.parent / "count.py"), str(tmp_path / "clevr"), "120"]
    done = subprocess.run(program, capture_output=True, text=True, timeout=900, env=dict(os.environ), check=True)
    found = re.search(r"counted exactly: ([\d.]+)% \(chance 12\.5%\), mean error ([\d.]+)", done.stdout)
    assert found is not None, done.stdout
    assert float(found[1]) > 20.0  # of 200 pictures; three standard deviations above chance
    assert float(found[2]) < 1.8  # the best constant has 2
