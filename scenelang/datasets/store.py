"""Stores of datasets: local folders and fsspec addresses, shards that are committed whole, and their records.

A shard covers a range of samples. Its files are written under temporary names and renamed; its record in ``shards/``
is written last and commits it. Files without a record do not count, so an interrupted run loses only the shards in
progress and never duplicates a sample. A lock service or a queue of samples would lose less work when a run is killed,
and be one more part that can fail.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import shutil
import tarfile
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any

from scenelang.backends.base import require
from scenelang.backends.files import atomic_write, new_folder, reason_of
from scenelang.datasets.making import Files, Sample
from scenelang.datasets.spec import CODE, FORMATS, MAX_SAMPLES, MAX_SHARD, SHARD_FORMATS, Spec, is_split_name
from scenelang.grammar.diagnostics import SceneError

FORMAT, VERSION = "scenelang-dataset", 1
PLAN = "dataset.json"
RECORDS = "shards"
INSTALL = "'scenelang[datasets]'"
SHARD_NAME = re.compile(r"\w+-\d{6,}\.(?:tar|parquet)")
_ITEM_KEY = re.compile(r"[0-9]{9,18}(?:-v[0-9]{3,})?(?:-f[0-9]{4,})?")
_GROUP_ROWS = 32  # of a row group in Parquet files
_OBJECT_STORES = frozenset({"s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "oss"})  # stores without folders
_DAMAGE_ERRORS = (tarfile.TarError, EOFError, ValueError, KeyError)  # errors of readers for damaged files
_REMOTE = "check the address, and the endpoint and keys of its store"
_CHUNK_BYTES = 1 << 20  # bytes read at a time
_ENDINGS = {"webdataset": "tar", "parquet": "parquet"}
# The shapes of JSON data: a dict of them by key ("*" for any key), a list of one, or a type; float is any number.
_PLAN = {
    "format": str, "version": int, "spec": str, "count": int, "shard": int, "shards": str, "classes": {"*": int},
    "columns": [str], "formats": [str], "licence": str, "text": str,
}  # fmt: skip
_FILE = {"name": str, "split": str, "sha256": str, "bytes": int, "items": int}
_FAILURE = {"key": str, "code": str, "message": str, "text": str, "machine": bool}
_RECORD = {
    "shard": int, "range": [int], "spec": str, "files": [_FILE], "samples": int, "pictures": int,
    "failures": [_FAILURE], "values": [{"*": object}], "shown": {"*": int},
    "run": {"seconds": float, "memory": int, "process": int},
}  # fmt: skip


# --- where files are -------------------------------------------------------------------------------------------------


class Store:
    """A folder, local or of any file system that fsspec knows (``s3://bucket/set``, ``memory://set``).

    Methods raise SceneError("file") if the file system fails.
    """

    def __init__(self, address: str | Path) -> None:
        """Open a folder or address; raises SceneError("file")."""
        self.address = str(address)
        self._remote: Any = None
        self._root = self.address
        if "://" in self.address:
            fsspec = require("fsspec", INSTALL)
            try:
                self._remote, self._root = fsspec.core.url_to_fs(self.address)
            except Exception as error:  # packages of stores raise any class
                raise SceneError("file", f"cannot open {self.address}: {reason_of(error)}") from error

    @property
    def local(self) -> Path | None:
        """The folder, None for a remote store."""
        return Path(self._root) if self._remote is None else None

    def path(self, name: str) -> Path:
        """Return the path of a file of a local store; raises SceneError for a remote one."""
        if self._remote is not None:
            raise SceneError("unsupported", f"{self.address} is no local folder")
        return Path(self._root) / name

    def _path(self, name: str) -> str:
        """Return the path of a file in the file system of the store."""
        return f"{self._root.rstrip('/')}/{name}" if name else self._root

    @contextmanager
    def _failing(self, action: str, passing: tuple[type[Exception], ...] = ()) -> Iterator[None]:
        """Raise SceneError("file") for errors of the file system but those in ``passing``.

        Packages of remote stores raise exceptions of any class: that of S3, for instance, for a missing server or key.
        """
        passed: tuple[type[Exception], ...] = (SceneError, MemoryError, *passing)
        try:
            yield
        except passed:
            raise
        except Exception as error:
            is_remote = self._remote is not None
            if not is_remote and not isinstance(error, OSError):
                raise
            message = f"cannot {action} in {self.address}: {reason_of(error)}"
            raise SceneError("file", message, _REMOTE if is_remote else None) from error

    def _make_remote(self, path: str) -> None:
        """Create a folder of a remote store, unless it has none, where a wrong address would create a bucket."""
        if self.address.partition(":")[0] not in _OBJECT_STORES:
            self._remote.makedirs(path, exist_ok=True)

    def make(self) -> None:
        """Create the folder of a remote store; one on this machine appears with its first file."""
        if self._remote is not None:
            with self._failing("make the folder"):
                self._make_remote(self._root)

    def exists(self, name: str) -> bool:
        """Return whether a file or folder exists."""
        with self._failing(f"look for `{name}`"):
            return (
                Path(self._path(name)).exists() if self._remote is None else bool(self._remote.exists(self._path(name)))
            )

    def names(self, folder: str = "") -> list[str]:
        """Return the sorted names in a folder, none if it does not exist."""
        path = self._path(folder)
        with self._failing(f"list `{folder}`"):
            if self._remote is None:
                return sorted(os.listdir(path)) if os.path.isdir(path) else []
            self._remote.invalidate_cache()
            try:
                paths = self._remote.ls(path, detail=False)
            except FileNotFoundError:
                paths = []
            return sorted(entry.rstrip("/").rsplit("/", 1)[-1] for entry in paths)

    def read(self, name: str) -> bytes:
        """Return the content of a file."""
        with self.open(name) as file:
            return file.read()

    @contextmanager
    def open(self, name: str) -> Iterator[IO[bytes]]:
        """Open a file for reading; errors of a reader for a damaged file pass through."""
        with self._failing(f"read `{name}`", _DAMAGE_ERRORS):
            path = self._path(name)
            with open(path, "rb") if self._remote is None else self._remote.open(path, "rb") as file:
                yield file

    def write(self, name: str, data: bytes) -> None:
        """Write a file whole or not at all."""
        with self.writing(name) as temporary:
            temporary.write_bytes(data)

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Yield a local path to write; on success the file appears under its name."""
        if self._remote is None:
            target = Path(self._path(name))
            with new_folder(target.parent), atomic_write(target) as temporary:
                yield temporary
            return
        with self._failing(f"write `{name}`"), tempfile.TemporaryDirectory(prefix="scenelang-shard-") as folder:
            temporary = Path(folder) / Path(name).name
            yield temporary
            parent = self._path(name).rsplit("/", 1)[0]
            with suppress(OSError, NotImplementedError):  # writing the file then reports the error
                self._make_remote(parent)
            self._remote.put_file(str(temporary), self._path(name))

    def delete(self, name: str) -> None:
        """Remove a file if it exists."""
        with self._failing(f"delete `{name}`"):
            if self._remote is None:
                Path(self._path(name)).unlink(missing_ok=True)
            elif self._remote.exists(self._path(name)):
                self._remote.rm_file(self._path(name))

    def digest(self, name: str) -> tuple[str, int]:
        """Return SHA-256 and size of a file."""
        total, size = hashlib.sha256(), 0
        with self.open(name) as file:
            while chunk := file.read(_CHUNK_BYTES):
                total.update(chunk)
                size += len(chunk)
        return total.hexdigest(), size

    def copy_from(self, other: Store, name: str) -> None:
        """Copy a file of another store, whole or not at all."""
        with other.open(name) as source, self.writing(name) as temporary, open(temporary, "wb") as target:
            shutil.copyfileobj(source, target, _CHUNK_BYTES)


# --- plans and records -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Plan:
    """Data that all shards of a dataset share, stored as ``dataset.json``."""

    spec_digest: str
    count: int
    shard: int
    format: str
    classes: Mapping[str, int]
    columns: tuple[str, ...]
    formats: tuple[str, ...]
    licence: str
    text: str = field(repr=False)

    def fits(self, other: Plan) -> bool:
        """Return whether the shards of two plans are of one dataset; it may grow, and be written in more formats."""
        return replace(self, count=0, text="", formats=(), licence="") == replace(
            other, count=0, text="", formats=(), licence=""
        )

    @property
    def shards(self) -> int:
        """Number of shards."""
        return -(-self.count // self.shard)

    def samples(self, number: int) -> range:
        """Return the numbers of a shard's samples."""
        return range(number * self.shard, min(self.count, (number + 1) * self.shard))

    def samples_in(self, numbers: ShardNumbers) -> int:
        """Return the number of samples of some shards."""
        last = self.shards - 1
        lacking = self.shard - len(self.samples(last)) if last in numbers else 0
        return len(numbers) * self.shard - lacking

    def data(self) -> dict[str, Any]:
        """Return the plan as JSON data."""
        return {
            "format": FORMAT, "version": VERSION, "spec": self.spec_digest, "count": self.count, "shard": self.shard,
            "shards": self.format, "classes": dict(self.classes), "columns": list(self.columns),
            "formats": list(self.formats), "licence": self.licence, "text": self.text,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class ShardNumbers:
    """Numbers of the shards to make: ``wanted`` without ``kept``, never listed because there may be very many."""

    wanted: range
    kept: frozenset[int] = frozenset()

    def __iter__(self) -> Iterator[int]:
        return (number for number in self.wanted if number not in self.kept)

    def __contains__(self, number: object) -> bool:
        return number in self.wanted and number not in self.kept

    def __len__(self) -> int:
        return len(self.wanted) - sum(number in self.wanted for number in self.kept)


def plan_of(spec: Spec, classes: Mapping[str, int], count: int | None = None) -> Plan:
    """Return the plan of a spec's dataset."""
    size = spec.output
    return Plan(
        spec.digest, count or spec.count, size.shard, size.shards, classes, columns_of(spec), size.formats,
        size.licence, spec.text,
    )  # fmt: skip


def columns_of(spec: Spec) -> tuple[str, ...]:
    """Return the endings of the files that an item may have, in the order of Parquet's columns."""
    wanted, common = spec.labels.write, ["json", "color.png"]
    files = {
        "instance": ["instance.png"], "semantic": ["semantic.png"], "depth": ["depth.npy"], "normals": ["normals.png"],
        "levels": [f"level{n}.png" for n in range(1, spec.labels.levels + 1)], "albedo": ["albedo.png"],
        "flow": ["flow.npy", "flow_state.png"], "tracks": ["tracks.npz"], "captions": ["txt"],
        "graph": ["graph.json"], "program": ["program.scene"],
    }  # fmt: skip
    return (*common, *(name for label in wanted for name in files.get(label, ())))


def read_plan(store: Store) -> Plan | None:
    """Return the plan of a store, None if it has none; raises SceneError("dataset") for a damaged one."""
    if not store.exists(PLAN):
        return None
    try:
        data = json.loads(store.read(PLAN))
    except (ValueError, RecursionError):
        data = None
    if not (_has_shape(data, _PLAN) and _is_plan(data)):
        hint = "restore it from a copy, or make the dataset again in a new folder"
        raise SceneError(CODE, f"`{PLAN}` in {store.address} is not the plan of a dataset", hint)
    return Plan(
        data["spec"], data["count"], data["shard"], data["shards"], data["classes"], tuple(data["columns"]),
        tuple(data["formats"]), data["licence"], data["text"],
    )  # fmt: skip


def _is_plan(data: Mapping[str, Any]) -> bool:
    """Return whether JSON data of the right shape is a plan of this version."""
    is_known = (data["format"], data["version"]) == (FORMAT, VERSION) and set(data["formats"]) <= set(FORMATS)
    has_size = 1 <= data["count"] <= MAX_SAMPLES and 1 <= data["shard"] <= MAX_SHARD
    return is_known and has_size and data["shards"] in SHARD_FORMATS


def _has_shape(value: Any, shape: Any) -> bool:
    """Return whether JSON data has the types that a shape says.

    Examples
    --------
    >>> _has_shape({"a": [1, 2]}, {"a": [int]}), _has_shape({"a": ["x"]}, {"a": [int]})
    (True, False)
    """
    if isinstance(shape, dict):
        if "*" in shape:
            return isinstance(value, dict) and all(_has_shape(item, shape["*"]) for item in value.values())
        return isinstance(value, dict) and all(
            name in value and _has_shape(value[name], kind) for name, kind in shape.items()
        )
    if isinstance(shape, list):
        return isinstance(value, list) and all(_has_shape(item, shape[0]) for item in value)
    if shape is float:
        return type(value) in (int, float)
    return shape is object or type(value) is shape


def require_plan(store: Store) -> Plan:
    """Return the plan of a store; raises SceneError if there is none."""
    plan = read_plan(store)
    if plan is None:
        raise SceneError("file", f"{store.address} is not a dataset: it has no `{PLAN}`")
    return plan


def write_plan(store: Store, plan: Plan) -> None:
    """Write the plan of a dataset."""
    store.write(PLAN, json.dumps(plan.data(), indent=1, sort_keys=True).encode())


def names_of_records(store: Store) -> list[str]:
    """Return the names of all records."""
    return store.names(RECORDS)


def record_name(number: int) -> str:
    """Return the name of a shard's record."""
    return f"{RECORDS}/{number:06d}.json"


def records_of(store: Store, plan: Plan) -> Iterator[dict[str, Any]]:
    """Yield the records of the committed shards in order; damaged records and those of other plans are left out."""
    for number in _recorded(store, plan):
        record = _record(store, number, plan)
        if record is not None:
            yield record


def damaged_records(store: Store, plan: Plan) -> list[int]:
    """Return the numbers of the shards whose records are damaged."""
    return [number for number in _recorded(store, plan) if _record(store, number, plan) is None]


def _recorded(store: Store, plan: Plan) -> Iterator[int]:
    """Yield the numbers of the shards that have a file for their record."""
    for name in store.names(RECORDS):
        stem = name.removesuffix(".json")
        number = int(stem) if stem.isdecimal() and len(stem) <= 18 else plan.shards
        if number < plan.shards and f"{RECORDS}/{name}" == record_name(number):
            yield number


def _record(store: Store, number: int, plan: Plan) -> dict[str, Any] | None:
    """Return the record of a shard, None if it is damaged or of another dataset."""
    try:
        record = json.loads(store.read(record_name(number)))
    except (ValueError, RecursionError, SceneError):
        return None
    return record if _has_shape(record, _RECORD) and _is_of(record, number, plan) else None


def _is_of(record: Mapping[str, Any], number: int, plan: Plan) -> bool:
    """Return whether a record belongs to a shard: it lists its samples, and no files but those of the shard."""
    samples = plan.samples(number)
    is_ours = (record["shard"], record["spec"]) == (number, plan.spec_digest)
    is_whole = record["range"] == [samples.start, samples.stop]
    is_whole = is_whole and record["samples"] + len(record["failures"]) == len(samples)
    splits = [file["split"] for file in record["files"]]
    names = [file["name"] for file in record["files"]]
    has_names = all(map(is_split_name, splits)) and len(set(splits)) == len(splits)
    return is_ours and is_whole and has_names and names == [shard_name(split, number, plan.format) for split in splits]


def shard_name(split: str, number: int, kind: str) -> str:
    """Return the name of the file of a shard that has the samples of one split."""
    return f"{split}-{number:06d}.{_ENDINGS[kind]}"


def is_intact(store: Store, record: Mapping[str, Any]) -> bool:
    """Return whether all files of a shard exist with the recorded sizes."""
    try:
        return all(store.digest(file["name"]) == (file["sha256"], file["bytes"]) for file in record["files"])
    except SceneError:
        return False


def failures_of_machine(record: Mapping[str, Any]) -> int:
    """Return the number of samples of a shard that failed for reasons of the machine, such as a limit of time."""
    return sum(failure["machine"] for failure in record["failures"])


def digest_of(records: Sequence[Mapping[str, Any]]) -> str:
    """Return the digest of a dataset: of the digests and names of its files, and of its failures."""
    files = sorted(f"{file['sha256']}  {file['name']}" for record in records for file in record["files"])
    failed = sorted(f"{failure['key']}  {failure['code']}" for record in records for failure in record["failures"])
    return hashlib.sha256("\n".join([*files, *failed]).encode()).hexdigest()


# --- files of shards -------------------------------------------------------------------------------------------------


class _TarFile:
    """WebDataset: a tar file whose members of one sample follow each other, with equal names up to the first dot."""

    def __init__(self, path: Path, plan: Plan) -> None:
        self._raw = io.FileIO(path, "wb")
        self._file = io.BufferedWriter(self._raw)
        self._tar = tarfile.open(  # noqa: SIM115 - closed by `close` or `discard`
            fileobj=self._file, mode="w", format=tarfile.USTAR_FORMAT
        )

    def add(self, key: str, files: Files) -> None:
        """Append the files of an item."""
        for name in sorted(files):
            info = tarfile.TarInfo(f"{key}.{name}")
            info.size, info.mode = len(files[name]), 0o644
            self._tar.addfile(info, io.BytesIO(files[name]))

    def close(self) -> None:
        """Write the end of the archive."""
        self._tar.close()
        self._file.close()

    def discard(self) -> None:
        """Close the file without its content: buffered data must not fail again when the object is collected."""
        self._raw.seek(0)
        self._raw.truncate(0)
        self._file.close()


class _ParquetFile:
    """Parquet: a row for each item, images as encoded bytes with the features that ``datasets`` reads."""

    def __init__(self, path: Path, plan: Plan) -> None:
        self._arrow = require("pyarrow", INSTALL)
        self._schema = _schema(self._arrow, plan.columns)
        self._writer = require("pyarrow.parquet", INSTALL).ParquetWriter(path, self._schema, compression="zstd")
        self._rows: list[dict[str, Any]] = []

    def add(self, key: str, files: Files) -> None:
        """Append the row of an item, written in groups."""
        row: dict[str, Any] = {"__key__": key}
        for name in self._schema.names[1:]:
            data = files.get(_ending_of(name))
            if name.endswith("_png") and data is not None:
                row[name] = {"bytes": data, "path": None}
            else:
                row[name] = data.decode("utf-8", "replace") if data is not None and _is_text(name) else data
        self._rows.append(row)
        if len(self._rows) >= _GROUP_ROWS:
            self._flush()

    def _flush(self) -> None:
        """Write the collected rows."""
        if self._rows:
            self._writer.write_table(self._arrow.Table.from_pylist(self._rows, schema=self._schema))
            self._rows.clear()

    def close(self) -> None:
        """Write the last rows and the footer."""
        self._flush()
        self._writer.close()

    def discard(self) -> None:
        """Close the file without the rows that are not written yet."""
        self._rows.clear()
        self._writer.close()


def _is_text(column: str) -> bool:
    """Return whether a column of Parquet is text."""
    return column in ("json", "txt", "graph_json", "program_scene")


def _ending_of(column: str) -> str:
    """Return the ending that a column holds: ``color.png`` for ``color_png``."""
    stem, sign, kind = column.rpartition("_")
    return f"{stem}.{kind}" if sign else column


def _schema(arrow: Any, columns: Sequence[str]) -> Any:
    """Return the schema of a Parquet file, with Hugging Face's description of its images."""
    picture = arrow.struct([("bytes", arrow.binary()), ("path", arrow.string())])
    fields, features = [("__key__", arrow.string())], {"__key__": {"dtype": "string", "_type": "Value"}}
    for ending in columns:
        name = ending.replace(".", "_")
        if name.endswith("_png"):
            fields.append((name, picture))
            features[name] = {"_type": "Image"}
        else:
            fields.append((name, arrow.string() if _is_text(name) else arrow.binary()))
            features[name] = {"dtype": "string" if _is_text(name) else "binary", "_type": "Value"}
    described = json.dumps({"info": {"features": features}})
    return arrow.schema(fields, metadata={"huggingface": described})


_WRITERS: Mapping[str, type[_TarFile] | type[_ParquetFile]] = {"webdataset": _TarFile, "parquet": _ParquetFile}


class ShardFiles:
    """The files of one shard, one for each split that occurs; they appear when the shard is committed."""

    def __init__(self, store: Store, plan: Plan, number: int) -> None:
        """Prepare the files of a shard; a writer is opened for each split on first use."""
        self._store, self._plan, self._number = store, plan, number
        self._folder = store.local if store.local is not None else None
        self._open: dict[str, tuple[Any, Path, Any]] = {}
        self._count: dict[str, int] = {}

    def add(self, sample: Sample) -> None:
        """Append the items of a sample; raises SceneError("file") if the file system fails."""
        split = sample.draw.split
        if split not in self._open:
            context = self._store.writing(shard_name(split, self._number, self._plan.format))
            path = context.__enter__()
            self._open[split] = _WRITERS[self._plan.format](path, self._plan), path, context
        for item in sample.items:
            with self._writing(split):
                self._open[split][0].add(item.key, item.files)
            self._count[split] = self._count.get(split, 0) + 1

    def commit(self) -> list[dict[str, Any]]:
        """Close the files and give them their names; returns their records."""
        records = []
        for split, (writer, path, context) in sorted(self._open.items()):
            with self._writing(split):
                writer.close()
            data = hashlib.sha256()
            with open(path, "rb") as file:
                while chunk := file.read(_CHUNK_BYTES):
                    data.update(chunk)
            size = path.stat().st_size
            context.__exit__(None, None, None)
            name = shard_name(split, self._number, self._plan.format)
            records.append(
                {"name": name, "split": split, "sha256": data.hexdigest(), "bytes": size, "items": self._count[split]}
            )
        self._open.clear()
        return records

    @contextmanager
    def _writing(self, split: str) -> Iterator[None]:
        """Raise SceneError("file") for errors of the file system."""
        try:
            yield
        except OSError as error:
            name = shard_name(split, self._number, self._plan.format)
            message = f"cannot write `{name}` in {self._store.address}: {reason_of(error)}"
            raise SceneError("file", message) from error

    def abandon(self) -> None:
        """Remove the files that are not committed."""
        for writer, _, context in self._open.values():
            with suppress(Exception):
                writer.discard()
            with suppress(Exception):
                context.__exit__(SceneError, SceneError("file", "abandoned"), None)
        self._open.clear()


# --- reading ---------------------------------------------------------------------------------------------------------


def items_of(store: Store, name: str) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Yield the key and the files of each item in a file of a shard; raises SceneError for a damaged file."""
    reader = _parquet_items if name.endswith(".parquet") else _tar_items
    try:
        for key, files in reader(store, name):
            if not (isinstance(key, str) and _ITEM_KEY.fullmatch(key)):  # it becomes the name of a file
                raise ValueError(f"`{str(key)[:60]}` is not the key of a picture")
            yield key, files
    except (tarfile.TarError, EOFError, ValueError, KeyError) as error:
        raise SceneError(CODE, f"`{name}` is damaged: {reason_of(error)}") from error


def _tar_items(store: Store, name: str) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Yield the items of a tar file; members of one item are adjacent."""
    key, files = "", dict[str, bytes]()
    with store.open(name) as raw, tarfile.open(fileobj=raw, mode="r|") as tar:
        for member in tar:
            member_key, _, ending = member.name.partition(".")
            if member_key != key and files:
                yield key, files
                files = {}
            key = member_key
            content = tar.extractfile(member)
            files[ending] = content.read() if content is not None else b""
    if files:
        yield key, files


def _parquet_items(store: Store, name: str) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Yield the items of a Parquet file."""
    parquet = require("pyarrow.parquet", INSTALL)
    with store.open(name) as raw:
        try:
            for batch in parquet.ParquetFile(raw).iter_batches(batch_size=_GROUP_ROWS):
                for row in batch.to_pylist():
                    yield row.pop("__key__"), dict(_row_files(row))
        except OSError as error:
            raise ValueError(reason_of(error)) from error


def _row_files(row: Mapping[str, Any]) -> Iterator[tuple[str, bytes]]:
    """Yield the files of a row by ending."""
    for name, value in row.items():
        if value is not None:
            data = value["bytes"] if isinstance(value, dict) else value
            yield _ending_of(name), data.encode("utf-8") if isinstance(data, str) else data
