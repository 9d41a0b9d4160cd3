"""Client for a model: cached replies, a budget reserved before each request, and continuation of paused replies."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from threading import Condition
from typing import Any

from scenelang.backends.files import atomic_write
from scenelang.backends.language_models.catalogue import Blocks, Message, Model, Reply, Request, StopReason, Usage
from scenelang.backends.language_models.provider import BatchProvider, OnText, Provider
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import user_folder

# Cache of replies on disk, so that equal requests are paid for once; safe for concurrent processes.
#
# The key is a digest of the payload and of the numbers of sample and attempt, so that samples differ. A lock per key
# makes a second process wait for the first one's reply.


_PRIVATE = 0o600  # file mode


def reply_cache_folder() -> Path:
    """Return the folder of the cache."""
    return user_folder("CACHE") / "replies"


def digest_of(*values: Any) -> str:
    """Return a digest of JSON values."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


def reply_data(reply: Reply) -> dict[str, Any]:
    """Return a reply as JSON data, without the content blocks."""
    return {
        "text": reply.text,
        "stop": reply.stop.value,
        "usage": asdict(reply.usage),
        "model": reply.model,
        "note": reply.note,
    }


def reply_of(data: Mapping[str, Any]) -> Reply:
    """Parse the result of ``reply_data``; raises KeyError, TypeError or ValueError for invalid data."""
    usage = Usage(**{name: int(number) for name, number in data["usage"].items()})
    return Reply(str(data["text"]), StopReason(data["stop"]), usage, str(data["model"]), str(data["note"]))


class ReplyCache:
    """Cache of replies in a folder that only its owner can read."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, key: str) -> Reply | None:
        """Return a cached reply, None if it does not exist or cannot be read."""
        try:
            return reply_of(json.loads(self._path(key).read_text("utf-8")))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
            return None

    def put(self, key: str, reply: Reply) -> None:
        """Cache a complete reply, if the folder is writable."""
        if reply.stop is not StopReason.END:
            return
        try:
            self._make_folder()
            with atomic_write(self._path(key), mode=_PRIVATE) as temporary:
                temporary.write_text(json.dumps(reply_data(reply)), "utf-8")
        except (SceneError, OSError):
            return

    @contextmanager
    def lock(self, key: str) -> Iterator[None]:
        """Hold the lock of a key, so that only one process sends the request; does nothing without ``flock``."""
        path = self._path(key).with_suffix(".lock")
        try:
            self._make_folder()
            file = _lock_file(path)
        except (ImportError, OSError):
            yield
            return
        try:
            yield
        finally:
            path.unlink(missing_ok=True)
            os.close(file)  # also releases the lock

    def _make_folder(self) -> None:
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def _path(self, key: str) -> Path:
        return self._folder / f"{key}.json"


def _lock_file(path: Path) -> int:
    """Open and lock a file; returns its descriptor. Raises ImportError or OSError if locks are not supported."""
    import fcntl

    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT, _PRIVATE)
        try:
            fcntl.flock(file, fcntl.LOCK_EX)
            if os.path.samestat(os.fstat(file), path.stat()):
                return file
        except FileNotFoundError:
            pass
        except OSError:
            os.close(file)
            raise
        os.close(file)  # the previous holder has removed the file, so the lock is void


# Budget for all requests: the maximum cost is reserved before a request and the actual cost settled after it.


_TOLERANCE = 1e-9  # dollars, for rounding errors of sums


class Budget:
    """Spent and reserved US dollars; thread-safe."""

    def __init__(self, limit: float, spent: float = 0.0) -> None:
        self.limit = limit
        self._spent = spent
        self._reserved = 0.0
        self._changed = Condition()

    @property
    def spent(self) -> float:
        return self._spent

    def reserve(self, amount: float) -> None:
        """Reserve ``amount`` dollars; raises SceneError if this exceeds the limit."""
        with self._changed:
            self._reserve(amount)

    def wait_and_reserve(self, amount: float) -> None:
        """Reserve ``amount``, after waiting for other requests whose settlement may release enough."""
        with self._changed:
            while self._reserved > _TOLERANCE and amount > self._remaining + _TOLERANCE:
                self._changed.wait()
            self._reserve(amount)

    @property
    def _remaining(self) -> float:
        return self.limit - self._spent - self._reserved

    def _reserve(self, amount: float) -> None:
        if amount > self._remaining + _TOLERANCE:
            remaining = max(0.0, self._remaining)
            message = f"the next request could cost ${amount:.4f}, but only ${remaining:.4f} of --max-cost remains"
            raise SceneError("model-cost", message, "increase --max-cost, or decrease --max-tokens, -n or --critique")
        self._reserved += amount

    def settle(self, reserved: float, cost: float) -> None:
        """Release a reservation of ``reserved`` dollars and record the actual ``cost``."""
        with self._changed:
            self._reserved = max(0.0, self._reserved - reserved)
            self._spent += cost
            self._changed.notify_all()


# Sending requests.


_MAX_PAUSES = 8
OnSend = Callable[[float], None]  # called with the maximum cost before a request is sent


@dataclass(frozen=True, slots=True)
class Answer:
    """Reply with its cost in US dollars, which is 0 for a cached one."""

    reply: Reply
    cost: float
    was_cached: bool = False


class Client:
    """Client for one model of a provider, with a budget and an optional cache of replies."""

    def __init__(self, provider: Provider, model: Model, budget: Budget, cache: ReplyCache | None) -> None:
        self.provider = provider
        self.model = model
        self.budget = budget
        self._cache = cache

    def redact(self, text: str) -> str:
        """Remove the API key and other secrets from a text."""
        return self.provider.redact(text)

    def payload(self, request: Request) -> dict[str, Any]:
        """Return the body of a request as JSON data."""
        return self.provider.payload(request)

    def key(self, request: Request, sample: int, attempt: int) -> str:
        """Return the cache key of a request."""
        return digest_of(self.provider.name, self.provider.address, self.payload(request), sample, attempt)

    def ask(
        self, request: Request, sample: int, attempt: int, on_text: OnText, on_send: OnSend = lambda _: None
    ) -> Answer:
        """Return the reply to a request, from the cache or the service.

        Raises SceneError if the request fails, or its maximum cost exceeds the budget.
        """
        if self._cache is None:
            return self._ask(request, on_text, on_send)
        key = self.key(request, sample, attempt)
        with self._cache.lock(key):
            cached = self.cached(key)
            if cached is not None:
                return cached
            answer = self._ask(request, on_text, on_send)
            self.cache(key, answer.reply)
            return answer

    def cached(self, key: str) -> Answer | None:
        """Return the cached reply of an earlier run, or None."""
        reply = self._cache.get(key) if self._cache is not None else None
        return Answer(reply, 0.0, was_cached=True) if reply is not None else None

    def cache(self, key: str, reply: Reply) -> None:
        """Cache a reply for later runs."""
        if self._cache is not None:
            self._cache.put(key, reply)

    def max_cost(self, request: Request, is_batch: bool = False) -> float:
        """Return the maximum cost of a request in US dollars."""
        return self.model.max_cost(self.provider.count(request), request.max_tokens, is_batch)

    def max_tokens(self, request: Request) -> int:
        """Return the most tokens that a request and its answer have."""
        return self.provider.count(request) + request.max_tokens

    def _ask(self, request: Request, on_text: OnText, on_send: OnSend) -> Answer:
        """Send a request, and send paused replies back until the model has finished."""
        text, usage, cost = "", Usage(), 0.0
        messages = request.messages
        for _ in range(_MAX_PAUSES):
            answer = self._send(replace(request, messages=messages), on_text, on_send)
            text, usage, cost = text + answer.reply.text, usage + answer.reply.usage, cost + answer.cost
            if answer.reply.stop is not StopReason.PAUSED:
                return Answer(replace(answer.reply, text=text, usage=usage), cost)
            messages = (*messages, Message("assistant", (Blocks(answer.reply.blocks),)))
        note = f"the model paused {_MAX_PAUSES} times"
        return Answer(Reply(text, StopReason.INTERRUPTED, usage, request.model, note), cost)

    def _send(self, request: Request, on_text: OnText, on_send: OnSend) -> Answer:
        reserved = self.max_cost(request)
        self.budget.wait_and_reserve(reserved)
        on_send(reserved)
        cost = reserved  # the actual cost of an interrupted request is unknown
        try:
            reply = self.provider.send(request, on_text)
            cost = reserved if reply.stop is StopReason.INTERRUPTED else self.model.cost(reply.usage)
            return Answer(reply, cost)
        except SceneError:
            cost = 0.0  # rejected requests are free
            raise
        finally:
            self.budget.settle(reserved, cost)

    # --- batches -------------------------------------------------------------------------------------------------

    def submit(self, requests: Mapping[str, Request]) -> tuple[str, dict[str, float]]:
        """Submit requests by name as a batch.

        Returns its identifier, and the dollars reserved for each request until ``collect``. Raises SceneError if the
        provider does not support batches.
        """
        provider = self.batches()
        reserved = {name: self.max_cost(request, is_batch=True) for name, request in requests.items()}
        self.budget.reserve(sum(reserved.values()))
        try:
            return provider.submit(requests), reserved
        except SceneError:
            self.budget.settle(sum(reserved.values()), 0.0)
            raise

    def collect(self, batch: str, reserved: Mapping[str, float]) -> dict[str, Answer | SceneError]:
        """Return the replies of a finished batch by name, and settle their reservations."""
        answers: dict[str, Answer | SceneError] = {}
        for name, reply in self.batches().collect(batch).items():
            if name in reserved:
                answers[name] = reply if isinstance(reply, SceneError) else self._batch_answer(reply)
        self.budget.settle(sum(reserved.values()), sum(a.cost for a in answers.values() if isinstance(a, Answer)))
        return answers

    def _batch_answer(self, reply: Reply) -> Answer:
        if reply.stop is StopReason.PAUSED:  # batches cannot continue paused replies
            reply = replace(reply, stop=StopReason.INTERRUPTED, note="the model paused", blocks=())
        return Answer(reply, self.model.cost(reply.usage, is_batch=True))

    def batches(self) -> BatchProvider:
        """Return the provider; raises SceneError if it does not support batches."""
        if not hasattr(self.provider, "submit"):
            raise SceneError("value", f"the provider `{self.provider.name}` does not support batches", "omit --batch")
        provider: BatchProvider = self.provider  # type: ignore[assignment]
        return provider
