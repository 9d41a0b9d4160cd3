"""Datasets in a store of the S3 protocol, served on this machine: `make test-s3`."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import pytest

from scenelang.datasets.running import (
    DatasetProgress,
    dataset,
    dataset_sample,
    dataset_status,
    merge_datasets,
    verify_dataset,
)
from scenelang.grammar.diagnostics import SceneError

pytestmark = pytest.mark.slow


class Service:
    """A server of the S3 protocol; what it stores outlives ``stop``."""

    def __init__(self) -> None:
        from moto.server import ThreadedMotoServer

        self._kind: Any = ThreadedMotoServer
        self._server = self._kind(ip_address="127.0.0.1", port=0, verbose=False)
        self._server.start()
        self.port: int = self._server.get_host_and_port()[1]
        reset = Request(f"http://127.0.0.1:{self.port}/moto-api/reset", method="POST")  # what earlier servers stored
        urlopen(reset).close()

    @property
    def files(self) -> Any:
        """The stored files as a fresh file system of fsspec."""
        import s3fs

        return s3fs.S3FileSystem(skip_instance_cache=True, use_listings_cache=False)

    def stop(self) -> None:
        self._server.stop()

    def start(self) -> None:
        self._server = self._kind(ip_address="127.0.0.1", port=self.port, verbose=False)
        self._server.start()


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch) -> Iterator[Service]:
    """A server with the empty bucket `bucket`, told to fsspec by the environment."""
    pytest.importorskip("moto.server", reason="`make test-s3` has moto and s3fs")
    s3fs = pytest.importorskip("s3fs")
    logging.getLogger("werkzeug").setLevel(logging.CRITICAL)
    found = Service()
    for name, value in (
        ("ENDPOINT_URL", f"http://127.0.0.1:{found.port}"), ("ACCESS_KEY_ID", "key"), ("SECRET_ACCESS_KEY", "secret"),
        ("DEFAULT_REGION", "us-east-1"), ("MAX_ATTEMPTS", "1"), ("EC2_METADATA_DISABLED", "true"),
    ):  # fmt: skip
        monkeypatch.setenv(f"AWS_{name}", value)
    s3fs.S3FileSystem.clear_instance_cache()
    found.files.mkdir("bucket")
    yield found
    s3fs.S3FileSystem.clear_instance_cache()
    found.stop()


def contents(service: Service, folder: str = "bucket/set") -> dict[str, bytes]:
    files = service.files
    return {path.rsplit("/", 1)[1]: files.cat_file(path) for path in files.glob(f"{folder}/*-*.tar")}


def local(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*-*.tar")}


def test_a_bucket_has_the_same_bytes_and_damage_is_made_again(service: Service, made: Path, folder: Path) -> None:
    report = dataset(folder / "spec.toml", "s3://bucket/set", jobs=2)
    assert report.is_complete
    assert report.digest == dataset_status("s3://bucket/set").digest == dataset_status(made).digest
    assert contents(service) == local(made)
    assert verify_dataset("s3://bucket/set") == []
    assert service.files.cat_file("bucket/set/README.md").startswith(b"---\nlicense:")
    cut, deleted, flipped, *_ = (f"bucket/set/{name}" for name in sorted(local(made)))
    service.files.pipe_file(cut, service.files.cat_file(cut)[:-12_000])
    service.files.rm_file(deleted)
    data = bytearray(service.files.cat_file(flipped))
    data[len(data) // 2] ^= 1
    service.files.pipe_file(flipped, bytes(data))
    found = [finding.message for finding in verify_dataset("s3://bucket/set")]
    assert [sum(path.rsplit("/", 1)[1] in message for message in found) for path in (cut, deleted, flipped)] == [1] * 3
    with pytest.raises(SceneError, match="has a dataset already"):
        dataset(folder / "spec.toml", "s3://bucket/set", jobs=2)
    assert dataset(folder / "spec.toml", "s3://bucket/set", jobs=2, resume=True).digest == report.digest
    assert contents(service) == local(made)
    assert verify_dataset("s3://bucket/set") == []


def test_parts_in_buckets_are_merged_and_parquet_is_written(service: Service, made: Path, folder: Path) -> None:
    for k in range(2):
        dataset(folder / "spec.toml", f"s3://bucket/part{k}", jobs=0, part=(k, 2))
    merge_datasets(["s3://bucket/part0", "s3://bucket/part1"], "s3://bucket/all")
    assert contents(service, "bucket/all") == local(made)
    spec = folder / "parquet.toml"
    spec.write_text((folder / "spec.toml").read_text() + '\nformats = ["parquet"]\n')
    dataset(spec, "s3://bucket/rows", jobs=1)
    assert verify_dataset("s3://bucket/rows") == []
    assert sorted(dataset_sample(spec, "000000003"))


def test_a_wrong_bucket_is_told_and_not_created(service: Service, folder: Path) -> None:
    with pytest.raises(SceneError, match=r"cannot write `dataset\.json` in s3://buckte/set") as caught:
        dataset(folder / "spec.toml", "s3://buckte/set", jobs=1)
    assert caught.value.name == "file"
    assert service.files.ls("") == ["bucket"]


def test_a_lost_server_is_told_and_the_run_goes_on(service: Service, made: Path, folder: Path) -> None:
    stopped: list[int] = []

    def stop(progress: DatasetProgress) -> None:
        if progress.done >= 5 and not stopped:
            service.stop()
            stopped.append(progress.done)

    with pytest.raises(SceneError, match="in s3://bucket/set: ") as caught:
        dataset(folder / "spec.toml", "s3://bucket/set", jobs=1, progress=stop)
    assert caught.value.name == "file"
    assert caught.value.hint == "check the address, and the endpoint and keys of its store"
    with pytest.raises(SceneError, match="in s3://bucket/set: ") as caught:
        dataset_status("s3://bucket/set")
    service.start()
    assert 0 < dataset_status("s3://bucket/set").samples < 10
    report = dataset(folder / "spec.toml", "s3://bucket/set", jobs=1, resume=True)
    assert report.digest == dataset_status(made).digest
    assert contents(service) == local(made)


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [("AWS_ENDPOINT_URL", "nonsense", "Invalid endpoint"), ("AWS_SECRET_ACCESS_KEY", None, "credentials")],
)
def test_a_wrong_environment_is_told(
    service: Service, monkeypatch: pytest.MonkeyPatch, name: str, value: str | None, told: str
) -> None:
    import s3fs

    monkeypatch.setenv(name, value) if value else monkeypatch.delenv(name)
    s3fs.S3FileSystem.clear_instance_cache()
    with pytest.raises(SceneError, match=told) as caught:
        dataset_status("s3://bucket/set")
    assert caught.value.name == "file"


def test_a_cluster_writes_to_a_bucket(service: Service, made: Path, folder: Path) -> None:
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 100_000_000})
    try:
        cluster.add_node(num_cpus=1, object_store_memory=100_000_000)
        cluster.wait_for_nodes()
        report = dataset(folder / "spec.toml", "s3://bucket/set", ray=cluster.address)
        assert report.digest == dataset_status(made).digest
        damaged = f"bucket/set/{min(local(made))}"
        service.files.pipe_file(damaged, service.files.cat_file(damaged)[:-12_000])
        assert len(verify_dataset("s3://bucket/set")) == 1
        dataset(folder / "spec.toml", "s3://bucket/set", ray=cluster.address, resume=True)
        assert contents(service) == local(made)
    finally:
        ray.shutdown()
        cluster.shutdown()
