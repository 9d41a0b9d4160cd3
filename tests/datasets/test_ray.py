"""Datasets on a Ray cluster of several nodes: the same bytes, whatever is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from scenelang.datasets.running import DatasetProgress, dataset, dataset_status, verify_dataset
from scenelang.grammar.diagnostics import SceneError

pytestmark = pytest.mark.slow


@pytest.fixture
def cluster() -> Iterator[Any]:
    """Three nodes of two processors each, on this machine."""
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    found = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 100_000_000})
    found.others = [found.add_node(num_cpus=1, object_store_memory=100_000_000) for _ in range(2)]
    found.wait_for_nodes()
    yield found
    ray.shutdown()
    found.shutdown()


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*-*.tar")}


def test_a_cluster_gives_the_same_bytes(cluster: Any, made: Path, folder: Path, tmp_path: Path) -> None:
    seen: list[DatasetProgress] = []
    report = dataset(folder / "spec.toml", tmp_path / "out", ray=cluster.address, progress=seen.append)
    assert report.digest == dataset_status(made).digest
    assert contents(tmp_path / "out") == contents(made)
    assert seen[-1].done == 10


def _actors() -> list[int]:
    """Process numbers of the actors on this machine."""
    lines = subprocess.run(["ps", "ax", "-o", "pid,args"], capture_output=True, text=True, check=True).stdout
    return [int(line.split()[0]) for line in lines.splitlines() if "ray::RayActor" in line]


def test_killed_actors_and_a_lost_node_lose_nothing(cluster: Any, folder: Path, tmp_path: Path) -> None:
    whole = dataset(folder / "spec.toml", tmp_path / "whole", jobs=0, count=40)
    killed: list[Any] = []

    def disturb(progress: DatasetProgress) -> None:
        if progress.done >= 3 and not killed:
            for pid in _actors()[:1]:
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
        if progress.done >= 12 and len(killed) == 1:
            cluster.remove_node(cluster.others[0], allow_graceful=False)
            killed.append("node")

    report = dataset(folder / "spec.toml", tmp_path / "out", ray=cluster.address, count=40, progress=disturb)
    assert len(killed) == 2
    assert report.digest == whole.digest
    assert report.failures == {}
    assert verify_dataset(tmp_path / "out") == []


def test_a_killed_driver_is_resumed(cluster: Any, folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = [sys.executable, "-m", "scenelang", "dataset", str(folder / "spec.toml"), "-o", str(out), "--count", "40"]
    with subprocess.Popen([*words, "--ray", cluster.address]) as running:
        deadline = time.monotonic() + 120.0
        while len(list(out.glob("shards/0*.json"))) < 2 and time.monotonic() < deadline:
            time.sleep(0.02)
        running.kill()
    before = dataset_status(out)
    assert 0 < before.samples < 40
    report = dataset(folder / "spec.toml", out, ray=cluster.address, count=40, resume=True)
    assert report.is_complete
    assert report.digest == dataset(folder / "spec.toml", tmp_path / "whole", jobs=0, count=40).digest


def test_no_cluster_is_told(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("ray")
    with pytest.raises(SceneError, match="no Ray cluster at `auto`") as caught:
        dataset(folder / "spec.toml", tmp_path / "out", ray="auto")
    assert caught.value.name == "backend"
