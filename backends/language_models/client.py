"""One question to a provider: kept replies, money set aside before it is sent, paused answers continued."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from scenelang.backends.language_models.catalogue import Model
from scenelang.backends.language_models.conversation import Blocks, Reply, Request, Stop, Turn, Usage
from scenelang.backends.language_models.provider import BatchProvider, Provider, Watch
from scenelang.backends.language_models.replies import Replies, digest
from scenelang.backends.language_models.spending import Spending
from scenelang.grammar.diagnostics import SceneError

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
