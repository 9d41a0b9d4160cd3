"""Runs of datasets: planning of shards, workers, resuming, checking and merging (docs/datasets.md)."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from scenelang.backends.base import require
from scenelang.backends.files import atomic_write, new_folder
from scenelang.datasets import store as stores
from scenelang.datasets.describing import write_card
from scenelang.datasets.making import Maker, SampleFailure, decoded
from scenelang.datasets.naming import classes_of, warnings_of
from scenelang.datasets.owned import check_owned, derived_problems, names_of_files, other_formats, writing_derived
from scenelang.datasets.sampler import index_of, key_of
from scenelang.datasets.spec import CODE, SHARD_FORMATS, Spec, read_spec
from scenelang.datasets.store import Plan, Store
from scenelang.datasets.working import Pool, RayPool, in_process
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, SceneError, UsageError, error_of
from scenelang.grammar.settings import setting, typed, whole, within

_MAX_FINDINGS = 100  # of a check
MAX_FAILURES = 100  # samples, after which a run stops by default
_MAX_JOBS = 1_024  # worker processes


def _part(text: str) -> tuple[int, int]:
    """Parse ``K/N``: shard K, from 0, and every N-th after it."""
    first, sign, count = text.partition("/")
    if not (sign and first.isdecimal() and count.isdecimal() and int(first) < int(count) <= 1_000_000):
        raise ValueError(f"expected K/N with K from 0 to N - 1, got `{text[:60]}`")
    return int(first), int(count)


@dataclass(frozen=True, slots=True)
class DatasetSettings:
    """Settings of a run, which change no sample; see ``dataset``."""

    jobs: int = setting(1, "worker processes on this machine (default 1)", metavar="N", read=whole)
    resume: bool = setting(False, "go on with an interrupted run, and make damaged shards again")
    count: int | None = setting(None, "number of samples instead of the spec's", metavar="N", read=whole)
    part: tuple[int, int] | None = setting(
        None, "make only every N-th shard from K, counted from 0", metavar="K/N", read=_part
    )
    max_failures: int = setting(
        MAX_FAILURES, "stop when more samples have failed (default 100)", metavar="N", read=whole
    )
    ray: str | None = setting(None, "run on a Ray cluster: its address, or `auto`", metavar="ADDRESS", read=str)
    gpus: float = setting(0.0, "share of a GPU for each of Ray's workers", metavar="X", read=within(0.0, 1024.0))


@dataclass(frozen=True, slots=True)
class DatasetProgress:
    """Progress of a run.

    Attributes
    ----------
    done, total, kept
        Samples that are done, of all, and from an earlier run.
    failures
        Failed samples by diagnostic code.
    rate
        Samples per second.
    eta
        Remaining seconds, None if unknown.
    memory
        Peak memory of a worker in bytes.
    """

    done: int
    total: int
    kept: int
    failures: Mapping[str, int]
    rate: float
    eta: float | None
    memory: int

    def __str__(self) -> str:
        """Return one line.

        Examples
        --------
        >>> print(DatasetProgress(50, 100, 0, {"E502": 1}, 4.0, 12.5, 2_000_000))
        50 of 100 samples, 4.0 per second, 0:00:13 left, 1 failed (E502: 1), 2 MB per worker
        """
        failed = ", ".join(f"{code}: {count}" for code, count in sorted(self.failures.items()))
        parts = [f"{self.done:,} of {self.total:,} samples"]
        parts += [f"{self.rate:.1f} per second"] if self.rate else []
        parts += [f"{_clock(self.eta)} left"] if self.eta is not None and self.done < self.total else []
        parts += [f"{sum(self.failures.values()):,} failed ({failed})"] if failed else []
        parts += [f"{self.memory / 1e6:,.0f} MB per worker"] if self.memory else []
        return ", ".join(parts)


def _clock(seconds: float) -> str:
    """Return seconds as hours, minutes and seconds."""
    minutes, second = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{second:02d}"


@dataclass(frozen=True, slots=True)
class DatasetReport:
    """A dataset as it is: its folder, samples that it has and is to have, images, failures by code, the digest of
    its files, whether all shards are committed, the most bytes that a worker has used, how many of the failures are for
    reasons of the machine, how many records are damaged, the part that is complete, notes, and warnings of the spec."""

    out: str
    samples: int
    total: int
    pictures: int
    failures: Mapping[str, int]
    splits: Mapping[str, int]
    digest: str
    is_complete: bool
    seconds: float
    memory: int
    of_machine: int = 0
    damaged: int = 0
    part: tuple[int, int] | None = None
    notes: Sequence[str] = ()
    failed: Sequence[Mapping[str, Any]] = field(repr=False, default=())
    warnings: Sequence[Diagnostic] = field(repr=False, default=())

    @property
    def has_nothing(self) -> bool:
        """Whether every sample has failed."""
        return bool(self.failed) and not self.samples

    def data(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        names = [name for name in self.__dataclass_fields__ if name not in ("failed", "warnings")]
        plain = {name: getattr(self, name) for name in names}
        return plain | {"failures": dict(self.failures), "splits": dict(self.splits), "failed": list(self.failed)}

    def __str__(self) -> str:
        failed = sum(self.failures.values())
        codes = ", ".join(f"{code}: {count:,}" for code, count in sorted(self.failures.items()))
        splits = ", ".join(f"{name} {count:,}" for name, count in sorted(self.splits.items()))
        lines = [
            f"{self.samples:,} of {self.total:,} samples, {self.pictures:,} pictures ({splits or 'none'})",
            f"{failed:,} failed{f' ({codes})' if codes else ''}",
            f"digest {self.digest}" if self.is_complete else _part_line(self.part),
        ]
        lines[2:2] = [_machine_line(self.of_machine)] if self.of_machine else []
        lines += [f"{_counted(self.damaged, 'shard')} with damaged records"] if self.damaged else []
        lines += self.notes
        lines += [f"{self.memory / 1e6:,.0f} MB at most in a worker"] if self.memory else []
        return "\n".join([*lines, *_failure_lines(self.failed)])


def _counted(count: int, noun: str) -> str:
    """Return a count with its noun."""
    return f"{count:,} {noun}{'s' * (count != 1)}"


def _machine_line(count: int) -> str:
    """Return the line about samples that failed for reasons of the machine."""
    them = "it" if count == 1 else "them"
    return f"{_counted(count, 'sample')} failed for reasons of the machine; `--resume` tries {them} again"


def _part_line(part: tuple[int, int] | None) -> str:
    """Return the line about an incomplete dataset, or a complete part."""
    if part is None:
        return "not complete; --resume goes on"
    return f"part {part[0]}/{part[1]} is complete; `dataset merge` joins the parts"


def _failure_lines(failed: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return lines with the first failure of each code, and how to investigate it."""
    first: dict[str, Mapping[str, Any]] = {}
    for failure in failed:
        first.setdefault(failure["code"], failure)
    lines = [f"{code}, first of {failure['key']}: {failure['message']}" for code, failure in sorted(first.items())]
    if lines:
        lines.append(f"`scenelang dataset sample SPEC {failed[0]['key']} -o OUT` makes such a sample alone")
    return lines


def progress_text(stream: TextIO) -> Callable[[DatasetProgress], None]:
    """Return a callback that shows progress as one line of a terminal, at most ten times a second."""
    last = [0.0, 0]

    def show(progress: DatasetProgress) -> None:
        now, is_done = time.monotonic(), progress.done >= progress.total
        if now - last[0] < 0.1 and not is_done:
            return
        text = str(progress)
        stream.write("\r" + text.ljust(int(last[1])) + ("\n" if is_done else ""))
        stream.flush()
        last[:] = [now, len(text)]

    return show


# --- making ----------------------------------------------------------------------------------------------------------


@typed
def dataset(
    spec: str | Path,
    out: str | Path,
    *,
    jobs: int = 1,
    resume: bool = False,
    ray: str | None = None,
    gpus: float = 0.0,
    part: tuple[int, int] | None = None,
    count: int | None = None,
    max_failures: int = MAX_FAILURES,
    progress: Callable[[DatasetProgress], None] | None = None,
) -> DatasetReport:
    """Make a labeled dataset from programs.

    Parameters
    ----------
    spec : path
        TOML file with the spec (docs/datasets.md).
    out : path
        Folder, or an address that fsspec knows, such as ``s3://bucket/set``.
    jobs : int
        Worker processes on this machine; 0 makes everything in this process, without hard limits.
    resume : bool
        Continue an interrupted run, make damaged shards again, or extend the dataset to a larger ``count``.
    ray : str, optional
        Address of a Ray cluster, or "auto"; needs ``pip install 'scenelang[cluster]'``.
    gpus : float
        Share of a GPU that each of Ray's workers asks for.
    part : (k, n), optional
        Make only every n-th shard, from shard k, counted from 0; ``merge_datasets`` joins the parts.
    count : int, optional
        Number of samples instead of the spec's.
    max_failures : int
        Stop when more samples have failed.
    progress : callable, optional
        Called with a ``DatasetProgress`` after every sample.

    Returns
    -------
    DatasetReport
        The state of the dataset.

    Raises
    ------
    SceneError
        "dataset" for a mistake in the spec, with its location, or if ``out`` is another dataset; "file" if the file
        system fails, "sample" if too many samples fail. Finished shards remain and ``resume`` continues.

    Examples
    --------
    >>> import scenelang as sl
    >>> sl.dataset("examples/datasets/clevr.toml", "/tmp/clevr", jobs=2)  # doctest: +SKIP
    """
    settings = DatasetSettings(jobs, resume, count, part, max_failures, ray, gpus)
    return _dataset(read_spec(spec), str(out), settings, progress)


def _dataset(
    spec: Spec, out: str, settings: DatasetSettings, progress: Callable[[DatasetProgress], None] | None
) -> DatasetReport:
    """Make a dataset as ``dataset`` documents, from a spec that is read."""
    _check_numbers(settings)
    for package in _packages(spec):
        require(package, stores.INSTALL)
    store = Store(out)
    _check_store(spec.output.formats, store, has_workers=settings.jobs > 0 or settings.ray is not None)
    plan = stores.plan_of(spec, classes_of(spec), settings.count)
    is_new = stores.read_plan(store) is None
    intact = _prepared(store, plan, resume=settings.resume)
    first, step = settings.part or (0, 1)
    numbers = stores.ShardNumbers(range(first, plan.shards, step), frozenset(intact))
    tally = _Tally(plan, numbers, intact, settings.max_failures, progress)
    try:
        _make(spec, plan, out, numbers, tally, settings)
    except SceneError:
        if is_new and not tally.has_made:
            _forget(store)
        raise
    report = replace(dataset_status(out), warnings=warnings_of(spec), part=settings.part)
    if not report.is_complete:
        return report
    return replace(report, notes=finish(store, plan))


def _make(
    spec: Spec, plan: Plan, out: str, numbers: stores.ShardNumbers, tally: _Tally, settings: DatasetSettings
) -> None:
    """Make shards with the workers that are asked for."""
    run: Callable[[Collection[int]], Iterator[dict[str, Any]]]
    if settings.ray is not None:
        run = RayPool(spec, plan, out, settings.ray, settings.gpus, tally.hear).run
    elif settings.jobs == 0:
        run = in_process(spec, plan, out, tally.hear)
    else:
        run = Pool(spec, plan, out, settings.jobs, tally.hear).run
    for _ in run(numbers):
        tally.check()


def _check_store(formats: Sequence[str], store: Store, *, has_workers: bool) -> None:
    """Raise an error if the store cannot keep the formats, or workers cannot see it."""
    if store.local is not None:
        return
    others = [name for name in formats if name not in SHARD_FORMATS]
    if others:
        hint = "choose a local folder, or leave them out of `formats`"
        message = f"{', '.join(others)}: written to local folders only, not to {store.address}"
        raise SceneError("unsupported", message, hint)
    if store.address.startswith("memory:") and has_workers:
        raise SceneError("unsupported", f"workers do not see {store.address}", "use `jobs=0` of the Python API")


def _forget(store: Store) -> None:
    """Remove the plan of a dataset that has no shards, so that nothing is left of a failed start."""
    if stores.names_of_records(store):
        return
    store.delete(stores.PLAN)
    if store.local is not None:
        with suppress(OSError):
            store.local.rmdir()


def _check_numbers(settings: DatasetSettings) -> None:
    """Raise UsageError for options out of range."""
    jobs, count, part, gpus = settings.jobs, settings.count, settings.part, settings.gpus
    if not 0 <= gpus < math.inf:
        raise UsageError("value", f"`gpus`: expected a number of at least 0, got {gpus:g}")
    if gpus > 1 and not float(gpus).is_integer():
        raise UsageError("value", f"`gpus`: expected a whole number, or less than 1, got {gpus:g}")
    is_pair = isinstance(part, tuple | list) and len(part) == 2 and all(type(number) is int for number in part)
    if part is not None and not is_pair:
        raise UsageError("value", f"`part`: expected two whole numbers (k, n), got {str(part)[:60]!r}")
    if not 0 <= jobs <= _MAX_JOBS:
        raise UsageError("value", f"`jobs`: expected 0 to {_MAX_JOBS:,}, got {jobs}")
    if count is not None and count < 1:
        raise UsageError("value", f"`count`: expected at least 1, got {count}")
    if settings.max_failures < 0:
        raise UsageError("value", f"`max_failures`: expected at least 0, got {settings.max_failures}")
    if part is not None and not 0 <= part[0] < part[1]:
        raise UsageError("value", f"`part`: expected k of n with 0 <= k < n, got {part[0]} of {part[1]}")


def _packages(spec: Spec) -> Iterator[str]:
    """Yield the packages that the formats need."""
    if spec.output.shards == "parquet":
        yield "pyarrow"


def _prepared(store: Store, plan: Plan, *, resume: bool) -> dict[int, dict[str, Any]]:
    """Write the plan, and return the records of intact shards of an earlier run by number.

    Shards with failures for reasons of the machine are made again.
    """
    old = stores.read_plan(store)
    if old is None and names_of_files(store.names()):
        raise SceneError("file", f"{store.address} is not empty, and no dataset", "choose a new folder")
    if old is not None and not resume:
        hint = "add --resume to go on with it, or choose another folder"
        raise SceneError("file", f"{store.address} has a dataset already", hint)
    if old is not None and not old.fits(plan):
        is_same_spec = old.spec_digest == plan.spec_digest
        difference = (
            "another size of shards or another format" if is_same_spec else "another spec, or its programs have changed"
        )
        raise SceneError(CODE, f"{store.address} was made with {difference}", "choose another folder")
    if old is not None and old.count > plan.count:
        raise SceneError(CODE, f"{store.address} has {old.count:,} samples, more than {plan.count:,}")
    check_owned(store, plan)
    store.make()
    stores.write_plan(store, plan)
    return {record["shard"]: record for record in stores.records_of(store, plan) if _is_final(store, record)}


def _is_final(store: Store, record: Mapping[str, Any]) -> bool:
    """Return whether a shard is intact, and no run can improve it."""
    return not stores.failures_of_machine(record) and stores.is_intact(store, record)


class _Tally:
    """Counter of the workers' reports, which reports the progress and stops a run after too many failures."""

    def __init__(
        self, plan: Plan, numbers: stores.ShardNumbers, kept: Mapping[int, Mapping[str, Any]], max_failures: int,
        progress: Callable[[DatasetProgress], None] | None,
    ) -> None:  # fmt: skip
        self._kept = sum(len(plan.samples(number)) for number in kept)
        self._total = self._kept + plan.samples_in(numbers)
        self._failures = Counter(failure["code"] for record in kept.values() for failure in record["failures"])
        self._most, self._progress = max_failures, progress
        self._codes: dict[int, str | None] = {}  # by sample of this run, once although shards may be made again
        self._started: float | None = None
        self._memory = 0

    def hear(self, message: Mapping[str, Any]) -> None:
        """Count a message of a worker; raises SceneError("sample") after too many failures."""
        if self._started is None and "begin" in message:
            self._started = time.monotonic()
        if "end" not in message:
            return
        self._codes[message["end"]] = message["code"]
        self._memory = max(self._memory, message.get("memory", 0))
        if self._progress is not None:
            self._progress(self.progress())
        self.check()

    def progress(self) -> DatasetProgress:
        """Return the progress so far."""
        elapsed = time.monotonic() - (self._started or time.monotonic())
        rate = len(self._codes) / elapsed if elapsed > 0 else 0.0
        done = self._kept + len(self._codes)
        eta = (self._total - done) / rate if rate else None
        return DatasetProgress(done, self._total, self._kept, self.failures, rate, eta, self._memory)

    @property
    def has_made(self) -> bool:
        """Whether any sample of this run has been made or has failed."""
        return bool(self._codes)

    @property
    def failures(self) -> Counter[str]:
        """Failed samples by code."""
        return self._failures + Counter(code for code in self._codes.values() if code is not None)

    def check(self) -> None:
        """Raise SceneError("sample") if too many samples have failed."""
        failed = sum(self.failures.values())
        if failed > self._most:
            codes = ", ".join(f"{code}: {count}" for code, count in sorted(self.failures.items()))
            hint = "`dataset sample SPEC KEY` makes one alone; --max-failures raises the limit, --resume goes on"
            raise SceneError("sample", f"{failed:,} samples have failed ({codes}), more than {self._most:,}", hint)


def finish(store: Store, plan: Plan) -> list[str]:
    """Write the files derived from all shards, the other formats and the dataset card; return notes."""
    from scenelang.datasets.layouts import write_layout

    records, notes = list(stores.records_of(store, plan)), list[str]()
    with writing_derived(store, plan):
        for name in other_formats(plan):
            if not write_layout(name, store, plan, records):
                notes.append(f"warning: `{name}` is not written, since it is made of films and all scenes are still")
        write_card(store, plan, records, stores.digest_of(records))
    return notes


# --- one sample ------------------------------------------------------------------------------------------------------


@typed
def dataset_sample(spec: str | Path, key: str, count: int | None = None) -> dict[str, bytes]:
    """Make one sample of a dataset again, byte for byte, from its key.

    Parameters
    ----------
    spec : path
        Spec of the dataset.
    key : str
        Key of a sample, or of one of its images.
    count : int, optional
        Number of samples of the dataset; by default that of the spec.

    Returns
    -------
    dict
        Contents by file name, which begins with the key of an image.

    Raises
    ------
    SceneError
        If the sample fails, as it does in the dataset, or there is no such sample or image.
    """
    read = read_spec(spec)
    index = index_of(key)
    samples = read.count if count is None else count
    if index >= samples:
        message = f"`{key[:60]}`: there are {samples:,} samples, up to {key_of(samples - 1)}"
        raise SceneError("value", message, "raise the count of the spec, or give `--count`: it changes no sample")
    try:
        sample = Maker(read).make(index)
    except SampleFailure as failure:
        raise error_of(failure.diagnostic) from None
    chosen = [item for item in sample.items if key in (key_of(index), item.key)]
    if not chosen:
        raise SceneError("value", f"the sample {key_of(index)} has no picture `{key[:60]}`")
    return {f"{item.key}.{ending}": data for item in chosen for ending, data in item.files.items()}


def write_sample(spec: str | Path, key: str, folder: str | Path, count: int | None = None) -> list[Path]:
    """Write the files of one sample, made again, to a folder, and return their paths; raises as ``dataset_sample``."""
    files = dataset_sample(spec, key, count)
    with new_folder(Path(folder)) as target:
        for name, data in files.items():
            with atomic_write(target / name) as temporary:
                temporary.write_bytes(data)
    return [target / name for name in files]


# --- state and checks -----------------------------------------------------------------------------------------------


@typed
def dataset_status(out: str | Path) -> DatasetReport:
    """Return the state of a dataset, from the records of its shards; files are not read.

    Raises
    ------
    SceneError
        "file" if there is no dataset, "dataset" if its plan is damaged.
    """
    store = Store(out)
    plan = stores.require_plan(store)
    records = list(stores.records_of(store, plan))
    splits: Counter[str] = Counter()
    for record in records:
        splits.update({file["split"]: file["items"] for file in record["files"]})
    failed = [failure for record in records for failure in record["failures"]]
    return DatasetReport(
        out=str(out),
        samples=sum(record["samples"] for record in records),
        total=plan.count,
        pictures=sum(record["pictures"] for record in records),
        failures=Counter(failure["code"] for failure in failed),
        splits=splits,
        digest=stores.digest_of(records),
        is_complete=len(records) == plan.shards,
        seconds=sum(record["run"]["seconds"] for record in records),
        memory=max((record["run"]["memory"] for record in records), default=0),
        of_machine=sum(map(stores.failures_of_machine, records)),
        damaged=len(stores.damaged_records(store, plan)),
        failed=failed,
    )


@typed
def verify_dataset(out: str | Path, progress: Callable[[float], None] | None = None) -> list[Diagnostic]:
    """Check a dataset: digests, decoding, labels against each other, statistics, and duplicates.

    Returns
    -------
    list of Diagnostic
        At most ``_MAX_FINDINGS`` problems; empty if the dataset is complete and sound.
    """
    store = Store(out)
    plan = stores.require_plan(store)
    records = list(stores.records_of(store, plan))
    findings: list[Diagnostic] = []
    committed, damaged = frozenset(record["shard"] for record in records), stores.damaged_records(store, plan)
    missing = stores.ShardNumbers(range(plan.shards), committed.union(damaged))
    for numbers, problem in ((missing, "are missing"), (damaged, "have damaged records")):
        if len(numbers):
            shown = ", ".join(map(str, islice(numbers, 8))) + (" ..." if len(numbers) > 8 else "")
            findings.append(_finding(f"{len(numbers):,} of {plan.shards:,} shards {problem}: {shown}"))
    of_machine = sum(map(stores.failures_of_machine, records))
    findings += [Diagnostic("dataset", _machine_line(of_machine))] if of_machine else []
    findings += _folder_findings(store, plan, records)
    keys: set[str] = set()
    marks: dict[bytes, str] = {}
    for done, record in enumerate(records):
        for file in record["files"]:
            findings += _file_findings(store, plan, record, file, keys, marks)
            if len(findings) > _MAX_FINDINGS:
                return findings[:_MAX_FINDINGS]
        if progress is not None:
            progress((done + 1) / len(records))
    return findings


def _folder_findings(store: Store, plan: Plan, records: Sequence[Mapping[str, Any]]) -> Iterator[Diagnostic]:
    """Yield a finding for each file that no record lists, and for problems of the derived formats."""
    known = {file["name"] for record in records for file in record["files"]}
    for name in store.names():
        if stores.SHARD_NAME.fullmatch(name) and name not in known:
            yield Diagnostic("dataset", f"`{name}` belongs to no shard", None, "delete it, or make its shard again")
    if len(records) == plan.shards:
        yield from map(_finding, derived_problems(store, plan))


def _finding(message: str) -> Diagnostic:
    """Return a problem that `--resume` fixes."""
    return Diagnostic("dataset", message, None, "`--resume` makes missing and damaged shards again")


def _file_findings(
    store: Store, plan: Plan, record: Mapping[str, Any], file: Mapping[str, Any], keys: set[str],
    pictures: dict[bytes, str],
) -> Iterator[Diagnostic]:  # fmt: skip
    """Yield the problems of one file of a shard.

    ``keys`` and ``pictures`` collect those of all files, to find duplicates.
    """
    name, items = file["name"], 0
    try:
        if store.digest(name) != (file["sha256"], file["bytes"]):
            yield _finding(f"`{name}` is damaged: its digest differs from its record")
            return
        for key, files in stores.items_of(store, name):
            items += 1
            if key in keys:
                yield _finding(f"the key {key} occurs twice")
            keys.add(key)
            if index_of(key) not in plan.samples(record["shard"]):
                yield _finding(f"`{name}` has the sample {key}, which belongs to another shard")
            problems = _item_findings(key, files, file["split"], plan)
            yield from map(_finding, problems)
            if not problems:
                yield from _duplicates(key, files, pictures)
    except SceneError as error:
        yield _finding(error.message)
        return
    if items != file["items"]:
        yield _finding(f"`{name}` has {items} items; its record says {file['items']}")


def _duplicates(key: str, files: Mapping[str, bytes], pictures: dict[bytes, str]) -> Iterator[Diagnostic]:
    """Yield a finding if another sample is a duplicate.

    That is one with the same image, or the same values and camera; or one of another split with the same scene or
    image, unless nothing is visible.
    """
    record = json.loads(files["json"])
    if not record.get("things"):
        return
    marks = {"picture": hashlib.blake2b(files["color.png"], digest_size=12).digest()}
    marks |= {"scene": b"scene " + record["scene"].encode()} if "scene" in record else {}
    for kind, mark in marks.items():
        other, split = pictures.setdefault(mark, f"{key} {record['split']}").split()
        if split != record["split"]:
            hint = "split by scene, or vary what the programs show"
            message = f"{key} of `{record['split']}` has the {kind} of {other} of `{split}`, which leaks"
            yield Diagnostic("dataset", message, None, hint)
            return
        if kind == "picture" and index_of(other) != index_of(key):  # even if it was drawn with another seed
            yield _repeats(key, other, "pictures")
            return
    drawn = [record["values"], record["camera"], record["frame"]]
    mark = hashlib.blake2b(json.dumps(drawn, sort_keys=True).encode(), digest_size=12).digest()
    other = pictures.setdefault(mark, key)
    if other != key:
        yield _repeats(key, other, "values and cameras")


def _repeats(key: str, other: str, equal_parts: str) -> Diagnostic:
    """Return the warning that a sample repeats another."""
    return Diagnostic("dataset", f"{key} repeats {other}: equal {equal_parts}", None, "vary more, or make less")


def _item_findings(key: str, files: Mapping[str, bytes], split: str, plan: Plan) -> list[str]:
    """Return the problems of the labels of one image."""
    try:
        return list(_label_findings(key, files, split, plan))
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        return [f"{key} has labels of another form: {type(error).__name__}: {error}"]


def _label_findings(key: str, files: Mapping[str, bytes], split: str, plan: Plan) -> Iterator[str]:
    """Yield the problems of an item: decoding, record, sizes and disagreements."""
    try:
        record = json.loads(files["json"])
        arrays = {name: decoded(name, data) for name, data in files.items()}
    except (ValueError, KeyError, OSError, SyntaxError) as error:
        yield f"{key} cannot be decoded: {type(error).__name__}: {error}"
        return
    if record.get("key") != key or record.get("split") != split or record.get("spec") != plan.spec_digest:
        yield f"{key}: its record is that of another sample"
        return
    size = (record["camera"]["height"], record["camera"]["width"])
    for name, values in arrays.items():
        is_map = isinstance(values, np.ndarray) and name != "tracks.npz"
        if is_map and values.shape[:2] != size:
            yield f"{key}: `{name}` has the size {values.shape[1]} x {values.shape[0]}, not {size[1]} x {size[0]}"
            return
    yield from _disagreements(key, record, arrays)


def _disagreements(key: str, record: Mapping[str, Any], arrays: Mapping[str, Any]) -> Iterator[str]:
    """Yield disagreements between the maps and the records of an item."""
    ids, classes, depth = (arrays.get(name) for name in ("instance.png", "semantic.png", "depth.npy"))
    instances = record.get("things")
    if ids is not None and instances is not None:
        if int(ids.max(initial=0)) > len(instances):
            yield f"{key}: the instance {int(ids.max())} has no record"
            return
        table = np.array([0, *(instance["class"] for instance in instances)])
        if classes is not None and not np.array_equal(table[ids], classes):
            yield f"{key}: classes and instances disagree"
        for instance in instances:
            x, y, width, height = instance["bbox"]
            rows, columns = np.nonzero(ids == instance["id"])
            inside = (rows >= y) & (rows < y + height) & (columns >= x) & (columns < x + width)
            if len(rows) > instance["area"] or not inside.all():
                yield f"{key}: the mask of instance {instance['id']} exceeds its box or area"
                return
    if ids is not None and depth is not None and not np.isfinite(depth[ids > 0]).all():
        yield f"{key}: an instance has no depth"


# --- merging ---------------------------------------------------------------------------------------------------------


@typed
def merge_datasets(parts: str | Path | Sequence[str | Path], out: str | Path) -> DatasetReport:
    """Join parts of one dataset, made with ``part``.

    Shards that several parts have must be equal, except for samples that failed for reasons of the machine.

    Raises
    ------
    SceneError
        "dataset" if the parts are of different datasets or disagree, "file" if a file system fails.
    """
    parts = [parts] if isinstance(parts, str | Path) else parts
    if not parts:
        raise UsageError("value", "name at least one dataset to merge")
    sources = [Store(part) for part in parts]
    plans = [stores.require_plan(source) for source in sources]
    for plan, part in zip(plans, parts, strict=True):
        if not plan.fits(plans[0]) or plan.count != plans[0].count:
            raise SceneError(CODE, f"{part} is a part of another dataset than {parts[0]}")
    target = Store(out)
    _check_store(plans[0].formats, target, has_workers=False)
    merged = _prepared(target, plans[0], resume=True)
    for source in sources:
        for record in stores.records_of(source, plans[0]):
            known = merged.get(record["shard"])
            failed, least = (
                stores.failures_of_machine(record),
                0 if known is None else stores.failures_of_machine(known),
            )
            if known is not None and known["files"] != record["files"] and not failed and not least:
                raise SceneError(CODE, f"shard {record['shard']} differs between the parts")
            if known is None or failed < least:
                _copy_shard(source, target, record)
                merged[record["shard"]] = record
    notes = finish(target, plans[0]) if len(merged) == plans[0].shards else ()
    return replace(dataset_status(out), notes=notes)


def _copy_shard(source: Store, target: Store, record: Mapping[str, Any]) -> None:
    """Copy an intact shard, its record last."""
    if not stores.is_intact(source, record):
        raise SceneError(CODE, f"shard {record['shard']} of {source.address} is damaged")
    for file in record["files"]:
        target.copy_from(source, file["name"])
    target.write(stores.record_name(record["shard"]), json.dumps(record, sort_keys=True).encode())
