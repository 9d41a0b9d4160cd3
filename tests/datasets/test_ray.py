"""Datasets on a Ray cluster of several nodes: the same bytes, whatever is killed, full or damaged."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support import wait_until

from scenelang.datasets.running import DatasetProgress, dataset, dataset_status, verify_dataset
from scenelang.grammar.diagnostics import SceneError

pytestmark = pytest.mark.slow


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Three nodes of two processors each, on this machine."""
    ray = pytest.importorskip("ray")
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # Python keeps bytecode that a limit has cut short
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
        wait_until(lambda: len(list(out.glob("shards/0*.json"))) >= 2)
        running.kill()
    before = dataset_status(out)
    assert 0 < before.samples < 40
    report = dataset(folder / "spec.toml", out, ray=cluster.address, count=40, resume=True)
    assert report.is_complete
    assert report.digest == dataset(folder / "spec.toml", tmp_path / "whole", jobs=0, count=40).digest


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits the files of other processes")
def test_a_disk_that_runs_full_is_told_and_resumed(cluster: Any, folder: Path, tmp_path: Path) -> None:
    """No file of the actors may grow beyond 30 kB from the sixth sample on, as if the disk were full."""
    import resource

    out, limited = tmp_path / "out", list[int]()

    def fill(progress: DatasetProgress) -> None:
        if progress.done >= 6 and not limited:
            for pid in _actors():
                resource.prlimit(pid, resource.RLIMIT_FSIZE, (30_000, 30_000))
                limited.append(pid)

    with pytest.raises(SceneError, match="cannot write") as caught:
        dataset(folder / "spec.toml", out, ray=cluster.address, count=40, progress=fill)
    assert caught.value.name == "file"
    assert limited
    before = dataset_status(out)
    assert 6 <= before.samples < 40
    assert all("are missing" in finding.message for finding in verify_dataset(out))  # what counts is whole
    report = dataset(folder / "spec.toml", out, ray=cluster.address, count=40, resume=True)
    assert report.is_complete
    assert report.digest == dataset(folder / "spec.toml", tmp_path / "whole", jobs=0, count=40).digest
    assert contents(out) == contents(tmp_path / "whole")
    assert verify_dataset(out) == []
    assert not list(out.rglob(".scenelang-*"))


def test_damaged_shards_are_found_and_made_again(cluster: Any, copy: Path, made: Path, folder: Path) -> None:
    cut, flipped, deleted, *_ = sorted(path for path in copy.glob("*-*.tar") if path.stat().st_size > 20_000)
    cut.write_bytes(cut.read_bytes()[:-12_000])
    data = bytearray(flipped.read_bytes())
    data[len(data) // 2] ^= 1
    flipped.write_bytes(data)
    deleted.unlink()
    found = [finding.message for finding in verify_dataset(copy)]
    assert [sum(f"`{path.name}`" in message for message in found) for path in (cut, flipped, deleted)] == [1, 1, 1]
    seen: list[DatasetProgress] = []
    report = dataset(folder / "spec.toml", copy, ray=cluster.address, resume=True, progress=seen.append)
    assert 0 < seen[0].kept < 10  # intact shards are kept
    assert report.digest == dataset_status(made).digest
    assert contents(copy) == contents(made)
    assert verify_dataset(copy) == []


@pytest.mark.parametrize(("gpus", "told"), [(1.0, "1 CPU, 1 GPU and 500 MB"), (0.5, "1 CPU, 0.5 GPU and 500 MB")])
def test_resources_that_no_node_has_are_told(
    cluster: Any, folder: Path, tmp_path: Path, gpus: float, told: str
) -> None:
    with pytest.raises(
        SceneError, match=f"no node of the cluster has {told} for a worker; it has 1 CPU, 0 GPU"
    ) as caught:
        dataset(folder / "spec.toml", tmp_path / "out", ray=cluster.address, gpus=gpus)
    assert caught.value.name == "backend"
    assert not (tmp_path / "out" / "dataset.json").exists()


def test_no_cluster_is_told(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("ray")
    with pytest.raises(SceneError, match="no Ray cluster at `auto`") as caught:
        dataset(folder / "spec.toml", tmp_path / "out", ray="auto")
    assert caught.value.name == "backend"
    assert "RAY_AUTH_MODE=token" in str(caught.value.hint)
