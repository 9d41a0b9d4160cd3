"""Workers of datasets: one process each, which makes whole shards and reports in lines of JSON.

A worker receives shards on standard input and answers on standard output. It is a subprocess rather than a
`multiprocessing` one: nothing runs the user's main script again, each has one thread for linear algebra, and a killed
one leaves no lock or queue behind. The pool watches its workers: one that
exceeds a limit of its program is ended, one that dies is replaced, and the shard is made again; a sample that ends its
worker again and again is recorded as failed.
"""

from __future__ import annotations

import json
import os
import selectors
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from scenelang.backends.base import require
from scenelang.datasets.making import Maker, Sample, SampleFailure
from scenelang.datasets.sampler import key_of
from scenelang.datasets.spec import CODE, MEMORY_SLACK, Spec, spec_of
from scenelang.datasets.store import Plan, ShardFiles, Store, record_name
from scenelang.grammar.diagnostics import Diagnostic, SceneError, render_text
from scenelang.sandbox.environment import named_variables

_MAX_DEATHS = 3  # of workers at one sample, after which it counts as failed
_GRACE_S = 2.0  # over twice the limit of a program, before its worker is ended
_MAX_SLOWDOWN = 20.0  # times the limit of a program in wall-clock time, plus a minute, before its worker is ended
_STALLED_S = 3_600.0  # without a message from a worker, before it is ended
_POLL_S = 0.25  # seconds between checks of the workers
_MAX_LOSSES = 10  # of a shard on a cluster
_MACHINE_FAILURES = ("time", "memory")  # diagnostics of failures that another run may not have
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"), "1")
_CODE = "from scenelang.datasets.working import serve; serve()"

Report = Callable[[Mapping[str, Any]], None]


# --- one shard -------------------------------------------------------------------------------------------------------


def write_shard(
    maker: Maker, store: Store, plan: Plan, number: int, skip: Mapping[int, Mapping[str, Any]], report: Report
) -> dict[str, Any]:
    """Make the samples of a shard, commit its files and then its record, and return the record.

    Parameters
    ----------
    skip
        Samples that are not tried because they ended their worker, with the records of their failures.
    report
        Called with ``{"begin": index}`` before and ``{"end": index, "code": ...}`` after each sample.

    Raises
    ------
    SceneError
        "file" if the file system fails; nothing of the shard counts then.
    """
    started = time.monotonic()
    files, failures, values, shown = ShardFiles(store, plan, number), [], list[dict[str, Any]](), Counter[str]()
    samples = pictures = 0
    encoder = Encoder(files)
    try:
        for index in plan.samples(number):
            report({"begin": index})
            failure = skip.get(index)
            if failure is None:
                try:
                    sample = maker.make(index)
                    encoder.add(sample)
                    samples, pictures = samples + 1, pictures + len(sample.items)
                    values.append({**sample.draw.values, **sample.camera, "split": sample.draw.split})
                    shown.update(sample.shown)
                except SampleFailure as error:
                    failure = failure_record(index, error.diagnostic, error.is_of_machine)
            if failure is not None:
                failures.append(dict(failure))
            report({"end": index, "code": failure["code"] if failure is not None else None, "memory": peak_memory()})
        encoder.finish()
        written = files.commit()
    except BaseException:
        encoder.cancel()
        files.abandon()
        raise
    record = {
        "shard": number, "range": [plan.samples(number).start, plan.samples(number).stop], "spec": plan.spec_digest,
        "files": written, "samples": samples, "pictures": pictures, "failures": failures, "values": values,
        "shown": dict(sorted(shown.items())),
        "run": {"seconds": time.monotonic() - started, "memory": peak_memory(), "process": os.getpid()},
    }  # fmt: skip
    store.write(record_name(number), json.dumps(record, sort_keys=True).encode())
    return record


class Encoder:
    """Encoder of the samples of a shard, in a thread: one sample is written while the next one is made."""

    def __init__(self, files: ShardFiles) -> None:
        self._files = files
        self._thread = ThreadPoolExecutor(1, "encoder")
        self._last: Future[None] | None = None

    def add(self, sample: Sample) -> None:
        """Begin to write a sample after the one before is written, so that two are held; raises its errors."""
        if self._last is not None:
            self._last.result()
        self._last = self._thread.submit(self._files.add, sample)

    def finish(self) -> None:
        """Wait for the last sample; raises its error."""
        if self._last is not None:
            self._last.result()
        self._thread.shutdown()

    def cancel(self) -> None:
        """Wait until no sample is being written; their errors are dropped."""
        self._thread.shutdown()


def failure_record(index: int, diagnostic: Diagnostic, of_machine: bool = False) -> dict[str, Any]:
    """Return the record of a failed sample: its key, and its diagnostic as code, message and text.

    It also tells whether the sample failed for reasons of the machine, such as limits of time and memory.
    """
    return {
        "key": key_of(index), "code": diagnostic.code, "message": diagnostic.message[:500],
        "text": render_text(diagnostic)[:2_000], "machine": of_machine or diagnostic.name in _MACHINE_FAILURES,
    }  # fmt: skip


def processor_seconds_of(pid: int) -> float | None:
    """Return the CPU time of a process in seconds, None if the system does not report it."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            user, system = file.read().rpartition(b")")[2].split()[11:13]
    except (OSError, ValueError):
        return None
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def peak_memory() -> int:
    """Return the peak memory of this process in bytes, 0 if the system does not report it."""
    try:
        with open("/proc/self/status", encoding="ascii") as status:  # unlike getrusage, without the parent's memory
            return next((int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM:")), 0)
    except OSError:
        pass
    try:
        import resource
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


# --- the worker ------------------------------------------------------------------------------------------------------


def serve() -> None:
    """Serve as a worker on standard input and output until the input ends."""
    from scenelang.sandbox.status import Status
    from scenelang.sandbox.supervision import become_child, is_supported

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the pool, which ends its workers
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # removes temporary files
    replies = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # output of libraries must not be read as replies
    if is_supported():
        become_child(Status())  # programs are confined, and the worker ends with the pool

    def tell(message: Mapping[str, Any]) -> None:
        replies.write(json.dumps(message) + "\n")

    request = json.loads(sys.stdin.readline())
    try:
        spec = spec_of(request["text"], request["name"], Path(request["folder"]))
        plan = Plan(
            **(
                request["plan"]
                | {"columns": tuple(request["plan"]["columns"]), "formats": tuple(request["plan"]["formats"])}
            )
        )
        if spec.digest != plan.spec_digest:
            raise SceneError(CODE, f"the programs of {spec.name} have changed since the dataset was begun")
        maker, store = Maker(spec, plan.classes, lambda begins: tell({"evaluating": begins})), Store(request["out"])
        tell({"ready": os.getpid()})
        for line in sys.stdin:
            task = json.loads(line)
            skip = {int(index): failure for index, failure in task["skip"].items()}
            tell({"done": write_shard(maker, store, plan, task["shard"], skip, tell)})
    except SceneError as error:
        tell({"fatal": [error.name, error.message, error.hint]})
    except BrokenPipeError:
        pass


def environment(out: str = "") -> dict[str, str]:
    """Return the environment of workers, with one thread each, so that workers do not compete and sums have one order.

    Keys in the environment are only for the stores of other machines.
    """
    variables = dict(os.environ) if "://" in out else named_variables()
    return {**variables, **_ONE_THREAD}


# --- the pool --------------------------------------------------------------------------------------------------------


@dataclass(slots=True)
class _Task:
    """Shard to make, the samples to skip, and the deaths of workers at each sample."""

    number: int
    skip: dict[int, dict[str, Any]] = field(default_factory=dict)
    deaths: Counter[int] = field(default_factory=Counter)


class _Queue:
    """Queue of shards: those that are handed back, and then ``numbers``, which are not listed at once."""

    def __init__(self, numbers: Collection[int]) -> None:
        self._numbers, self._remaining = iter(numbers), len(numbers)
        self._back: list[_Task] = []

    def __len__(self) -> int:
        return self._remaining + len(self._back)

    def pop(self) -> _Task:
        """Remove and return the next shard."""
        if self._back:
            return self._back.pop()
        self._remaining -= 1
        return _Task(next(self._numbers))

    def append(self, task: _Task) -> None:
        """Hand back a shard."""
        self._back.append(task)


class _Worker:
    """Worker process from the pool's side."""

    def __init__(self, request: Mapping[str, Any]) -> None:
        """Start a process and send it the spec and the plan."""
        self.process = subprocess.Popen(  # this interpreter with our own code  # noqa: S603  # nosec B603
            [sys.executable, "-c", _CODE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0,
            env=environment(str(request["out"])), start_new_session=True,
        )  # fmt: skip
        self.task: _Task | None = None
        self.sample: int | None = None
        self.heard = time.monotonic()
        self._evaluates_since: tuple[float, float | None] | None = None  # wall-clock and processor time
        self.resident = 0
        self._received = b""
        self.verdict: Diagnostic | None = None
        self._send(request)

    @property
    def output(self) -> IO[bytes]:
        """Standard output of the process."""
        assert self.process.stdout is not None
        return self.process.stdout

    def messages(self) -> list[dict[str, Any]] | None:
        """Return the messages that have arrived, None if the worker has ended."""
        data = os.read(self.output.fileno(), 1 << 20)
        if not data:
            return None
        *lines, self._received = (self._received + data).split(b"\n")
        return [json.loads(line) for line in lines]

    def _send(self, message: Mapping[str, Any]) -> None:
        """Send a message; a dead worker is noticed when reading."""
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):
            self.process.stdin.write(json.dumps(message).encode() + b"\n")

    def give(self, task: _Task) -> None:
        """Ask for a shard."""
        self.task, self.sample, self.heard = task, None, time.monotonic()
        self._send({"shard": task.number, "skip": task.skip})

    def evaluates(self, begins: bool) -> None:
        """Record that the evaluation of a program begins or ends."""
        self._evaluates_since = (time.monotonic(), processor_seconds_of(self.process.pid)) if begins else None

    def is_late(self, seconds: float) -> bool:
        """Return whether an evaluation exceeds its limit by so much that the evaluator cannot end it."""
        if self._evaluates_since is None:
            return False
        start, spent = self._evaluates_since
        now = processor_seconds_of(self.process.pid)
        is_busy = spent is not None and now is not None and now - spent > 2.0 * seconds + _GRACE_S
        return is_busy or time.monotonic() - start > _MAX_SLOWDOWN * seconds + 60.0

    def end(self, number: int = signal.SIGTERM) -> None:
        """Send a signal to the process."""
        with suppress(ProcessLookupError):
            self.process.send_signal(number)


class Pool:
    """Local worker processes that make shards.

    ``run`` yields the records of shards as they are committed. ``report`` is called with every message of a worker.
    """

    def __init__(self, spec: Spec, plan: Plan, out: str, jobs: int, report: Report) -> None:
        """Prepare the request that starts a worker."""
        self._limits, self._jobs, self._report = spec.limits, jobs, report
        data = {name: getattr(plan, name) for name in plan.__dataclass_fields__}
        self._request = {"text": spec.text, "name": spec.name, "folder": spec.folder, "out": out, "plan": data}
        self._workers: list[_Worker] = []
        self._waiting = _Queue(())

    def run(self, numbers: Collection[int]) -> Iterator[dict[str, Any]]:
        """Make the shards ``numbers``; raises SceneError if the file system fails or a worker cannot start."""
        self._waiting = _Queue(numbers)
        with selectors.DefaultSelector() as selector:
            try:
                for _ in range(min(self._jobs, len(numbers))):
                    self._start(selector)
                while self._workers:
                    for key, _ in selector.select(_POLL_S):
                        yield from self._heard(selector, key.data)
                    self._watch()
            finally:
                self._stop()

    def _start(self, selector: selectors.BaseSelector) -> None:
        """Start a worker with the next shard."""
        worker = _Worker(self._request)
        self._workers.append(worker)
        selector.register(worker.output, selectors.EVENT_READ, worker)
        worker.give(self._waiting.pop())

    def _heard(self, selector: selectors.BaseSelector, worker: _Worker) -> Iterator[dict[str, Any]]:
        """Handle the messages of a worker, or its end."""
        messages = worker.messages()
        if messages is None:
            self._lost(selector, worker)
            return
        for message in messages:
            yield from self._take(selector, worker, message)

    def _take(
        self, selector: selectors.BaseSelector, worker: _Worker, message: dict[str, Any]
    ) -> Iterator[dict[str, Any]]:
        """Handle a message; yields the record of a committed shard."""
        worker.heard = time.monotonic()
        if "fatal" in message:
            raise SceneError(*message["fatal"])
        if "begin" in message:
            worker.sample = message["begin"]
        if "evaluating" in message:
            worker.evaluates(message["evaluating"])
        self._report(message | {"process": worker.process.pid})
        if "done" in message:
            worker.task = worker.sample = None
            yield message["done"]
            if self._waiting:
                worker.give(self._waiting.pop())
            else:
                self._dismiss(selector, worker)

    def _dismiss(self, selector: selectors.BaseSelector, worker: _Worker) -> None:
        """End a worker that has no more shards."""
        selector.unregister(worker.output)
        self._workers.remove(worker)
        assert worker.process.stdin is not None
        worker.process.stdin.close()
        worker.process.wait()
        worker.output.close()

    def _lost(self, selector: selectors.BaseSelector, worker: _Worker) -> None:
        """Replace a worker that died; its shard is made again, without a sample that repeatedly kills workers."""
        task, sample = worker.task, worker.sample
        self._dismiss(selector, worker)
        if task is None:
            return
        code = worker.process.returncode
        if sample is None:  # it died before its first sample, which another worker would do, too
            task.deaths[-1] += 1
            if task.deaths[-1] >= _MAX_DEATHS:
                raise SceneError("sample", f"workers end before they begin (exit status {code})")
        else:
            task.deaths[sample] += 1
            verdict = worker.verdict
            if verdict is None and task.deaths[sample] >= _MAX_DEATHS:
                verdict = Diagnostic(
                    "sample", f"the worker ended {_MAX_DEATHS} times at this sample (exit status {code})"
                )
            if verdict is not None:
                task.skip[sample] = failure_record(sample, verdict, of_machine=True)
        self._report({"lost": code, "shard": task.number})
        self._waiting.append(task)
        self._start(selector)

    def _watch(self) -> None:
        """End workers that exceed the limits of their program."""
        from scenelang.sandbox.status import resident_bytes_of

        now = time.monotonic()
        for worker in self._workers:
            if worker.sample is None:
                worker.resident = resident_bytes_of(worker.process.pid)
                continue
            used = resident_bytes_of(worker.process.pid) - worker.resident
            if used > self._limits.memory * MEMORY_SLACK:
                worker.verdict = Diagnostic("memory", f"the sample exceeds {self._limits.memory:,} bytes of memory")
            elif worker.is_late(self._limits.seconds):
                worker.verdict = Diagnostic("time", f"the program exceeds {self._limits.seconds:g} seconds")
            elif now - worker.heard > _STALLED_S:
                worker.verdict = Diagnostic("time", f"the sample takes more than {_STALLED_S:,.0f} seconds")
            if worker.verdict is not None:
                worker.end(signal.SIGKILL)

    def _stop(self) -> None:
        """End all workers, which remove their temporary files."""
        for worker in self._workers:
            worker.end()
        deadline = time.monotonic() + 5.0
        for worker in self._workers:
            with suppress(subprocess.TimeoutExpired):
                worker.process.wait(max(0.1, deadline - time.monotonic()))
            worker.end(signal.SIGKILL)
            worker.process.wait()
            worker.output.close()
        self._workers.clear()


def in_process(
    spec: Spec, plan: Plan, out: str, report: Report
) -> Callable[[Collection[int]], Iterator[dict[str, Any]]]:
    """Return a maker of shards in this process, without hard limits: for stores that other processes cannot see."""
    maker, store = Maker(spec, plan.classes), Store(out)

    def run(numbers: Collection[int]) -> Iterator[dict[str, Any]]:
        for number in numbers:
            yield write_shard(maker, store, plan, number, {}, report)

    return run


# --- Ray -------------------------------------------------------------------------------------------------------------

_ACTOR_BYTES = 500_000_000  # that an actor reserves
_MAX_SHARDS_PER_ACTOR = 2  # shards that an actor has at a time, so that none waits for the driver


_MAX_LISTED_NODES = 8  # in a message
_RAY_HINT = "`ray status` tells the address; a cluster with tokens needs RAY_AUTH_MODE=token in the environment"


def _resources(amounts: Mapping[str, float]) -> str:
    """Return resources of Ray as a text.

    Examples
    --------
    >>> _resources({"CPU": 1.0, "GPU": 0.5, "memory": 5e8})
    '1 CPU, 0.5 GPU and 500 MB'
    """
    cpus, gpus, memory = (amounts.get(name, 0.0) for name in ("CPU", "GPU", "memory"))
    return f"{cpus:g} CPU, {gpus:g} GPU and {memory / 1e6:,.0f} MB"


class RayActor:
    """A worker on a Ray cluster; evaluated scenes are reused from shard to shard."""

    def __init__(self, request: Mapping[str, Any]) -> None:
        data = request["plan"]
        spec = spec_of(request["text"], request["name"], Path(request["folder"]))
        self._plan = Plan(**(data | {"columns": tuple(data["columns"]), "formats": tuple(data["formats"])}))
        if spec.digest != self._plan.spec_digest:
            raise SceneError(CODE, f"the programs of {spec.name} differ on this node")
        self._maker, self._store = Maker(spec, self._plan.classes), Store(request["out"])

    def ready(self) -> bool:
        """Return True once the actor runs."""
        return True

    def make(self, number: int, skip: Mapping[int, Mapping[str, Any]]) -> dict[str, Any]:
        """Make and commit a shard and return its record; errors are returned as ``{"fatal": ...}``."""
        try:
            return write_shard(self._maker, self._store, self._plan, number, skip, lambda _: None)
        except SceneError as error:
            return {"fatal": [error.name, error.message, error.hint]}


class RayPool:
    """Actors on a Ray cluster that make shards; dead ones are replaced, and their shards are made again.

    ``address`` is that of the cluster or "auto", ``gpus`` the share of a GPU that an actor reserves.
    """

    def __init__(self, spec: Spec, plan: Plan, out: str, address: str, gpus: float, report: Report) -> None:
        """Connect to the cluster; raises SceneError("backend") if there is none or its nodes are too small."""
        ray = require("ray", "'scenelang[cluster]'")
        data = {name: getattr(plan, name) for name in plan.__dataclass_fields__}
        self._request = {"text": spec.text, "name": spec.name, "folder": spec.folder, "out": out, "plan": data}
        self._ray, self._report, self._plan = ray, report, plan
        if not ray.is_initialized():
            try:
                ray.init(address=address, log_to_driver=False)
            except (ConnectionError, ValueError, RuntimeError) as error:
                message = f"no Ray cluster at `{address}`: {str(error)[:200]}"
                raise SceneError("backend", message, _RAY_HINT) from error
        self._wanted = {"CPU": 1.0, "GPU": float(gpus), "memory": float(_ACTOR_BYTES)}
        options = {"num_cpus": 1, "num_gpus": gpus, "memory": _ACTOR_BYTES}  # one processor: Ray gives it one thread
        self._kind = ray.remote(**options)(RayActor)
        self._check_resources()
        self._actors: dict[Any, int] = {}  # actors that run, with the number of shards that each has
        self._starting: dict[
            Any, Any
        ] = {}  # actors that may still wait for a processor, by the reference that is ready when they run
        self._false_starts = 0
        self._running: dict[Any, tuple[Any, _Task]] = {}

    def _fits(self, node: Mapping[str, float]) -> bool:
        """Return whether a node has the resources of an actor."""
        return all(node.get(name, 0.0) >= amount for name, amount in self._wanted.items())

    def _nodes(self) -> list[Mapping[str, float]]:
        """Return the resources of the nodes that are alive."""
        return [node["Resources"] for node in self._ray.nodes() if node["Alive"]]

    def _check_resources(self) -> None:
        """Raise SceneError("backend") if no node has an actor's resources, for which Ray would wait silently."""
        nodes = self._nodes()
        if not any(map(self._fits, nodes)):
            listed = "; ".join(map(_resources, nodes[:_MAX_LISTED_NODES])) + (
                "; ..." if len(nodes) > _MAX_LISTED_NODES else ""
            )
            message = (
                f"no node of the cluster has {_resources(self._wanted)} for a worker; it has {listed or 'no nodes'}"
            )
            raise SceneError("backend", message, "ask for less with --gpus, or add nodes to the cluster")

    def run(self, numbers: Collection[int]) -> Iterator[dict[str, Any]]:
        """Make the shards ``numbers``; raises SceneError if the file system fails or shards cannot be made."""
        waiting = _Queue(numbers)
        self._report({"begin": None})
        try:
            while waiting or self._running:
                self._grow(len(waiting) + len(self._running))
                self._hand_out(waiting)
                done, _ = self._ray.wait([*self._starting, *self._running], num_returns=1, timeout=2.0)
                for reference in done:
                    if reference in self._starting:
                        self._started(reference)
                    else:
                        yield from self._take(reference, waiting)
        finally:
            for actor in (*self._actors, *self._starting.values()):
                self._ray.kill(actor)
            self._actors.clear()
            self._starting.clear()

    def _grow(self, shards: int) -> None:
        """Start actors for the processors that the cluster has now, at most one per shard."""
        if not self._actors:
            self._check_resources()  # a node may have been lost
        wanted = min(shards, max(1, int(sum(node.get("CPU", 0.0) for node in self._nodes()))))
        while len(self._actors) + len(self._starting) < wanted:
            actor = self._kind.remote(self._request)
            self._starting[actor.ready.remote()] = actor
        while self._starting and len(self._actors) + len(self._starting) > wanted:  # a node was lost
            self._ray.kill(self._starting.popitem()[1])

    def _started(self, reference: Any) -> None:
        """Count an actor that runs; raises SceneError if too many fail to start."""
        actor = self._starting.pop(reference)
        try:
            self._ray.get(reference)
        except self._ray.exceptions.RayError as error:
            self._false_starts += 1
            if self._false_starts > _MAX_LOSSES:
                raise SceneError("sample", f"workers cannot start on the cluster: {str(error)[:500]}") from error
        else:
            self._actors[actor] = 0

    def _hand_out(self, waiting: _Queue) -> None:
        """Give shards to the actors with the fewest, up to the maximum of each."""
        while waiting and (free := [actor for actor, count in self._actors.items() if count < _MAX_SHARDS_PER_ACTOR]):
            actor = min(free, key=self._actors.__getitem__)
            task = waiting.pop()
            skip = {number: dict(failure) for number, failure in task.skip.items()}
            self._running[actor.make.remote(task.number, skip)] = actor, task
            self._actors[actor] += 1

    def _take(self, reference: Any, waiting: _Queue) -> Iterator[dict[str, Any]]:
        """Handle the result of a shard, or the loss of its actor; yields the record."""
        actor, task = self._running.pop(reference)
        try:
            record = self._ray.get(reference)
        except self._ray.exceptions.RayError as error:
            self._actors.pop(actor, None)
            self._report({"lost": str(error)[:200], "shard": task.number})
            task.deaths[-1] += 1
            if task.deaths[-1] > _MAX_LOSSES:
                message = f"shard {task.number} was lost {task.deaths[-1]} times: {str(error)[:300]}"
                raise SceneError("sample", message, "`--resume` goes on") from error
            waiting.append(task)
            return
        if actor in self._actors:
            self._actors[actor] -= 1
        if "fatal" in record:
            raise SceneError(*record["fatal"])
        failed = {failure["key"]: failure["code"] for failure in record["failures"]}
        for index in self._plan.samples(task.number):
            code = failed.get(key_of(index))
            self._report({"begin": index})
            self._report({"end": index, "code": code, "memory": record["run"]["memory"]})
        yield record
