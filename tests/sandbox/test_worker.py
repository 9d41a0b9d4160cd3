"""Workers of servers: every request has a process of its own."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import signal
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from support import PATIENCE, wait_until

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.values.limits import Limits
from scenelang.sandbox.supervision import Ended, is_supported, limited
from scenelang.sandbox.worker import Worker, trial

pytestmark = pytest.mark.skipif(not is_supported(), reason="hard limits need Linux")


def serve(what: str, value: Any = None) -> Any:
    """What the workers of these tests do."""
    with limited(Limits(seconds=0.5, memory=200_000_000)):
        if what == "hold":
            sum(range(10**11))
        if what == "grow":
            held = [bytearray(b"x") * 10_000_000 for _ in range(100)]
            sum(range(10**11))
            del held
        if what == "crash":
            faulthandler.disable()
            ctypes.string_at(0)
        if what == "vanish":
            os._exit(3)
        if what == "raise":
            raise SceneError("value", "no such thing", hint="another")
        if what == "open":
            open("/etc/passwd").close()
        if what == "odd":
            return lambda: None
        if what == "pid":
            return os.getpid(), os.getppid()
        return value


@pytest.fixture
def worker() -> Iterator[Worker]:
    made = Worker(serve, ("/usr",))
    yield made
    made.close()


@pytest.mark.parametrize(
    ("what", "code"), [("hold", "E507"), ("grow", "E506"), ("crash", "E509"), ("vanish", "E509")], ids=str
)
@pytest.mark.sampled(2)
def test_a_request_that_is_ended_costs_nothing_else(worker: Worker, what: str, code: str) -> None:
    with pytest.raises(Ended) as caught:
        worker.ask(what)
    assert caught.value.problem.code == code
    assert worker.ask("value", {"a": b"x" * 10_000_000}) == {"a": b"x" * 10_000_000}


def test_every_request_has_its_own_process(worker: Worker) -> None:
    (first, parent), (second, same) = worker.ask("pid"), worker.ask("pid")
    assert first != second
    assert parent == same != os.getpid()


def test_errors_come_back(worker: Worker) -> None:
    with pytest.raises(SceneError) as caught:
        worker.ask("raise")
    assert (caught.value.name, caught.value.hint) == ("value", "another")
    with pytest.raises(PermissionError):
        worker.ask("open")
    with pytest.raises(RuntimeError, match="internal error"):
        worker.ask("odd")


def test_several_threads_may_ask(worker: Worker) -> None:
    found: list[int] = []
    threads = [threading.Thread(target=lambda n=n: found.append(worker.ask("value", n))) for n in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert sorted(found) == list(range(6))


def test_a_request_can_be_cancelled() -> None:
    def endless() -> None:
        sum(range(10**11))

    worker = Worker(endless)
    caught: list[BaseException] = []

    def ask() -> None:
        try:
            worker.ask()
        except Ended as error:
            caught.append(error)

    thread = threading.Thread(target=ask)
    thread.start()

    def is_over() -> bool:
        worker.interrupt()  # before the thread has asked there is nothing to end
        return not thread.is_alive()

    wait_until(is_over)
    assert [error.name for error in caught] == ["interrupted"]  # type: ignore[attr-defined]
    worker.close()


def test_an_interruption_of_nothing_does_not_end_the_next_request(worker: Worker) -> None:
    worker.interrupt()
    assert worker.ask("value", 3) == 3
    worker.interrupt()
    assert worker.ask("value", 4) == 4


def test_a_worker_that_is_killed_comes_back(worker: Worker) -> None:
    _, waiting = worker.ask("pid")
    os.kill(waiting, signal.SIGKILL)
    with pytest.raises(Ended):
        worker.ask("value", 1)
    assert worker.ask("value", 2) == 2


def test_a_trial_says_why_it_was_ended() -> None:
    assert trial(lambda: None) is None
    problem = trial(lambda: serve("hold"))
    assert problem is not None
    assert problem.code == "E507"
    assert trial(lambda: serve("raise")) is None  # it is raised where the work is done


# A process that stays for the requests of one file.


_SEEN: list[str] = []


def remember(file: str, what: str) -> Any:
    """Keep what was asked; ``large`` fails only in a process that has kept something."""
    with limited(Limits(seconds=0.5, memory=400_000_000)):
        _SEEN.append(what)
        if what == "hold" or (what == "large" and len(_SEEN) > 1):
            faulthandler.disable()
            sum(range(10**11)) if what == "hold" else ctypes.string_at(0)
        return os.getpid(), list(_SEEN)


@pytest.fixture
def keeper() -> Iterator[Worker]:
    made = Worker(remember, keeps=True)
    yield made
    made.close()


def test_a_process_stays_for_each_file(keeper: Worker) -> None:
    first, seen = keeper.ask("a", "1")
    assert keeper.ask("a", "2") == (first, [*seen, "2"])
    other, seen_there = keeper.ask("b", "3")
    assert other != first
    assert seen_there == ["3"]
    assert keeper.ask("a", "4") == (first, ["1", "2", "4"])


@pytest.mark.slow
def test_a_kill_costs_what_was_kept_and_nothing_else(keeper: Worker) -> None:
    first, _ = keeper.ask("a", "1")
    with pytest.raises(Ended) as ended:
        keeper.ask("a", "hold")
    assert ended.value.problem.code == "E507"
    second, seen = keeper.ask("a", "2")
    assert second != first
    assert seen == ["2"]
    assert keeper.ask("a", "large")[1] == ["large"]  # a new process has tried again


@pytest.mark.slow
def test_only_some_processes_stay(keeper: Worker) -> None:
    pids = [keeper.ask(name, "1")[0] for name in "abcdef"]
    assert keeper.ask("f", "2")[0] == pids[5]
    assert keeper.ask("a", "2")[0] != pids[0]
