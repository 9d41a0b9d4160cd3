"""One question to a provider: kept replies, money set aside before it is sent, paused answers continued."""

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

from scenelang.backends.files import atomic_write, user_folder
from scenelang.backends.language_models.catalogue import Blocks, Model, Reply, Request, Stop, Turn, Usage
from scenelang.backends.language_models.provider import BatchProvider, Provider, Watch
from scenelang.grammar.diagnostics import SceneError

# Replies kept on disk, so that the same question is not paid for twice; safe for processes side by side.
#
# A reply is kept under a digest of all that was sent and of the numbers of sample and attempt, so that samples
# differ. A lock per question makes a second process wait for the first one's answer.


_PRIVATE = 0o600


def reply_folder() -> Path:
    """Where replies are kept."""
    return user_folder("CACHE") / "replies"


def digest(*facts: Any) -> str:
    """A name for what was asked."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def reply_data(reply: Reply) -> dict[str, Any]:
    """A reply as JSON data, without what only continues a conversation."""
    return {
        "text": reply.text,
        "stop": reply.stop.value,
        "usage": asdict(reply.usage),
        "model": reply.model,
        "note": reply.note,
    }


def reply_of(data: Mapping[str, Any]) -> Reply:
    """The inverse of ``reply_data``; raises KeyError, TypeError or ValueError for other data."""
    usage = Usage(**{name: int(number) for name, number in data["usage"].items()})
    return Reply(str(data["text"]), Stop(data["stop"]), usage, str(data["model"]), str(data["note"]))


class Replies:
    """Replies in a folder that only its owner can read."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def find(self, key: str) -> Reply | None:
        """The reply that is kept under a digest; one that cannot be read counts as none."""
        try:
            return reply_of(json.loads(self._path(key).read_text("utf-8")))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
            return None

    def keep(self, key: str, reply: Reply) -> None:
        """Keep a complete reply. Where the folder cannot be written nothing is kept."""
        if reply.stop is not Stop.END:
            return
        try:
            self._make_folder()
            with atomic_write(self._path(key), mode=_PRIVATE) as temporary:
                temporary.write_text(json.dumps(reply_data(reply)), "utf-8")
        except (SceneError, OSError):
            return

    @contextmanager
    def asking(self, key: str) -> Iterator[None]:
        """Only one process asks a question at a time; without locks on this system they ask side by side."""
        path = self._path(key).with_suffix(".lock")
        try:
            self._make_folder()
            file = _locked(path)
        except (ImportError, OSError):
            yield
            return
        try:
            yield
        finally:
            path.unlink(missing_ok=True)
            os.close(file)  # lets go of the lock too

    def _make_folder(self) -> None:
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def _path(self, key: str) -> Path:
        return self._folder / f"{key}.json"


def _locked(path: Path) -> int:
    """A file that this process holds alone, as a descriptor. Raises ImportError or OSError where there are no locks."""
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
        os.close(file)  # whoever held it before took it away


# A limit on what requests cost together: money is reserved before a request is sent and settled after it.


_SLACK = 1e-9  # dollars that sums of floats may be off by


class Spending:
    """Dollars spent and reserved, safe for requests that run side by side."""

    def __init__(self, limit: float, spent: float = 0.0) -> None:
        self.limit = limit
        self._spent = spent
        self._reserved = 0.0
        self._changed = Condition()

    @property
    def spent(self) -> float:
        return self._spent

    def reserve(self, amount: float) -> None:
        """Set ``amount`` dollars aside. Raises SceneError where the limit does not allow it."""
        with self._changed:
            self._reserve(amount)

    def reserve_when_free(self, amount: float) -> None:
        """``reserve``, but wait while others have money set aside, of which they may give back enough."""
        with self._changed:
            while self._reserved > _SLACK and amount > self._left + _SLACK:
                self._changed.wait()
            self._reserve(amount)

    @property
    def _left(self) -> float:
        return self.limit - self._spent - self._reserved

    def _reserve(self, amount: float) -> None:
        if amount > self._left + _SLACK:
            left = max(0.0, self._left)
            message = f"the next request could cost ${amount:.4f}, and ${left:.4f} is left of --max-cost"
            raise SceneError("model-cost", message, "raise --max-cost, or lower --max-tokens, -n or --critique")
        self._reserved += amount

    def settle(self, reserved: float, cost: float) -> None:
        """A request for which ``reserved`` was set aside has cost ``cost``."""
        with self._changed:
            self._reserved = max(0.0, self._reserved - reserved)
            self._spent += cost
            self._changed.notify_all()


_MOST_PAUSES = 8
Sending = Callable[[float], None]


@dataclass(frozen=True, slots=True)
class Answer:
    """A reply and what it cost in US dollars; one that was kept from an earlier run cost nothing."""

    reply: Reply
    cost: float
    was_kept: bool = False


class Client:
    """Asks one model of one provider."""

    def __init__(self, provider: Provider, model: Model, spending: Spending, replies: Replies | None) -> None:
        self.provider = provider
        self.model = model
        self.spending = spending
        self._replies = replies

    def clean(self, text: str) -> str:
        """A text without the key and other secrets."""
        return self.provider.clean(text)

    def payload(self, request: Request) -> dict[str, Any]:
        """What is sent for a request, as JSON data."""
        return self.provider.payload(request)

    def key(self, request: Request, sample: int, attempt: int) -> str:
        """The digest under which the answer to a request is kept."""
        return digest(self.provider.name, self.provider.address, self.payload(request), sample, attempt)

    def ask(
        self, request: Request, sample: int, attempt: int, watch: Watch, sending: Sending = lambda _: None
    ) -> Answer:
        """The answer to a request; ``sending`` is told what it can cost before it is sent. Raises SceneError where it
        cannot be had, or could cost more than is left."""
        if self._replies is None:
            return self._ask(request, watch, sending)
        key = self.key(request, sample, attempt)
        with self._replies.asking(key):
            kept = self.kept(key)
            if kept is not None:
                return kept
            answer = self._ask(request, watch, sending)
            self.keep(key, answer.reply)
            return answer

    def kept(self, key: str) -> Answer | None:
        """The answer that an earlier run got to the same question."""
        reply = self._replies.find(key) if self._replies is not None else None
        return Answer(reply, 0.0, was_kept=True) if reply is not None else None

    def keep(self, key: str, reply: Reply) -> None:
        """Keep an answer for later runs."""
        if self._replies is not None:
            self._replies.keep(key, reply)

    def highest_cost(self, request: Request, is_batch: bool = False) -> float:
        """What a request can cost at most, in US dollars."""
        return self.model.highest_cost(self.provider.count(request), request.max_tokens, is_batch)

    def _ask(self, request: Request, watch: Watch, sending: Sending) -> Answer:
        """Send, and send back what was paused until the model has said all."""
        text, usage, cost = "", Usage(), 0.0
        turns = request.turns
        for _ in range(_MOST_PAUSES):
            answer = self._send(replace(request, turns=turns), watch, sending)
            text, usage, cost = text + answer.reply.text, usage + answer.reply.usage, cost + answer.cost
            if answer.reply.stop is not Stop.PAUSED:
                return Answer(replace(answer.reply, text=text, usage=usage), cost)
            turns = (*turns, Turn("assistant", (Blocks(answer.reply.blocks),)))
        note = f"the model paused {_MOST_PAUSES} times"
        return Answer(Reply(text, Stop.BROKEN, usage, request.model, note), cost)

    def _send(self, request: Request, watch: Watch, sending: Sending) -> Answer:
        reserved = self.highest_cost(request)
        self.spending.reserve_when_free(reserved)
        sending(reserved)
        cost = reserved  # an interrupted request may have cost all of it
        try:
            reply = self.provider.send(request, watch)
            cost = reserved if reply.stop is Stop.BROKEN else self.model.cost(reply.usage)
            return Answer(reply, cost)
        except SceneError:
            cost = 0.0  # it was refused before anything was answered
            raise
        finally:
            self.spending.settle(reserved, cost)

    # --- many at once --------------------------------------------------------------------------------------------

    def submit(self, requests: Mapping[str, Request]) -> tuple[str, dict[str, float]]:
        """Send requests by name as one batch: its identifier, and the dollars that are set aside for each until
        ``collect``. Raises SceneError where the provider has no batches."""
        provider = self.batches()
        reserved = {name: self.highest_cost(request, is_batch=True) for name, request in requests.items()}
        self.spending.reserve(sum(reserved.values()))
        try:
            return provider.submit(requests), reserved
        except SceneError:
            self.spending.settle(sum(reserved.values()), 0.0)
            raise

    def collect(self, batch: str, reserved: Mapping[str, float]) -> dict[str, Answer | SceneError]:
        """The answers of a batch that is done to the questions that money is ``reserved`` for, by name; it becomes what
        they cost."""
        found: dict[str, Answer | SceneError] = {}
        for name, reply in self.batches().collect(batch).items():
            if name in reserved:
                found[name] = reply if isinstance(reply, SceneError) else self._in_batch(reply)
        self.spending.settle(sum(reserved.values()), sum(a.cost for a in found.values() if isinstance(a, Answer)))
        return found

    def _in_batch(self, reply: Reply) -> Answer:
        if reply.stop is Stop.PAUSED:  # a batch cannot go on with it
            reply = replace(reply, stop=Stop.BROKEN, note="the model paused", blocks=())
        return Answer(reply, self.model.cost(reply.usage, is_batch=True))

    def batches(self) -> BatchProvider:
        """The provider, if it has batches; raises SceneError otherwise."""
        if not hasattr(self.provider, "submit"):
            raise SceneError("value", f"the provider `{self.provider.name}` has no batches", "leave --batch out")
        provider: BatchProvider = self.provider  # type: ignore[assignment]
        return provider
