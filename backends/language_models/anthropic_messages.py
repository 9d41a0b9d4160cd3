"""Claude by the Messages API, through the ``anthropic`` package."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from scenelang.backends.language_models.catalogue import (
    CONNECT_TIMEOUT,
    NO_KEY,
    Account,
    Blocks,
    ImageContent,
    Part,
    Reply,
    Request,
    Stop,
    TextContent,
    Turn,
    Usage,
)
from scenelang.backends.language_models.openai_chat import tokens_at_most, upper_estimate
from scenelang.backends.language_models.provider import BrokenStream, Family, Watch, arriving, failure, told
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from anthropic import Anthropic

_STOPS = {
    "end_turn": Stop.END,
    "stop_sequence": Stop.END,
    "tool_use": Stop.END,
    "max_tokens": Stop.CUT,
    "model_context_window_exceeded": Stop.FULL,
    "refusal": Stop.REFUSED,
    "pause_turn": Stop.PAUSED,
}
_KEPT = {"type": "ephemeral"}


class AnthropicMessages:
    """Sends by streaming; the SDK retries what it knows to be safe, and nothing else does."""

    name = "anthropic"

    def __init__(self, account: Account) -> None:
        self._account = account

    @cached_property
    def _client(self) -> Anthropic:
        """Connects at the first request: an estimate needs neither the package nor a key."""
        from anthropic import Anthropic, Timeout

        account = self._account
        timeout = Timeout(account.timeout, connect=min(CONNECT_TIMEOUT, account.timeout))
        return Anthropic(api_key=account.key or NO_KEY, base_url=account.address, timeout=timeout)

    @property
    def address(self) -> str:
        return self._account.shown_address

    def clean(self, text: str) -> str:
        return self._account.clean(text)

    def payload(self, request: Request) -> dict[str, Any]:
        payload = self._prompt(request) | {"max_tokens": request.max_tokens}
        if request.effort is not None:
            payload["output_config"] = {"effort": request.effort}
        return payload

    def _prompt(self, request: Request) -> dict[str, Any]:
        """What of a request counts as its prompt."""
        prompt: dict[str, Any] = {
            "model": request.model,
            "system": [_block(request.system)],
            "messages": [_message(turn) for turn in request.turns],
        }
        if request.thinking is not None:
            prompt["thinking"] = {"type": request.thinking}
        return prompt

    def count(self, request: Request) -> int:
        prompt = self._prompt(request)
        try:
            with self._told():
                return int(self._client.messages.count_tokens(**prompt).input_tokens)
        except SceneError as error:
            if error.name != "model-request":
                raise
            return upper_estimate(request)  # gateways do not all count

    def send(self, request: Request, watch: Watch) -> Reply:
        received = _Received()
        with self._told(), self._client.messages.stream(**self.payload(request)) as stream:
            try:
                for text in arriving(self._pieces(stream, received)):
                    watch(text)
            except BrokenStream as error:
                return self._broken(request, received, str(error))
        return received.reply or self._broken(request, received, "the stream ended early")

    def _pieces(self, stream: Any, received: _Received) -> Iterator[str]:
        """Read a stream to its end; its texts as they come."""
        for event in stream:
            if event.type == "text":
                received.texts.append(event.text)
                yield event.text
            elif event.type == "message_start":
                received.usage = _usage(event.message.usage)
        message = stream.get_final_message()
        if message.stop_reason is not None:
            received.reply = self._reply(message)

    def _broken(self, request: Request, received: _Received, why: str) -> Reply:
        """An answer that broke off; what it cost beyond the prompt is not known, so its length is an estimate."""
        text = self._account.clean("".join(received.texts))
        usage = replace(received.usage, answered=max(received.usage.answered, tokens_at_most(text)))
        return Reply(text, Stop.BROKEN, usage, request.model, self._account.clean(why)[:200])

    def _reply(self, message: Any) -> Reply:
        stop, clean = _STOPS.get(message.stop_reason, Stop.BROKEN), self._account.clean
        text = "".join(block.text for block in message.content if block.type == "text")
        note = _note(message) if stop is not Stop.BROKEN else f"it stopped for `{message.stop_reason}`"
        blocks: tuple[Mapping[str, Any], ...] = ()
        if stop is Stop.PAUSED:
            blocks = tuple(block.to_dict() for block in message.content)
        return Reply(clean(text), stop, _usage(message.usage), clean(str(message.model)), clean(note)[:200], blocks)

    # --- batches -----------------------------------------------------------------------------------------------

    def submit(self, requests: Mapping[str, Request]) -> str:
        listed: Any = [{"custom_id": name, "params": self.payload(request)} for name, request in requests.items()]
        with self._told():
            return str(self._client.messages.batches.create(requests=listed).id)

    def pending(self, batch: str) -> int:
        with self._told():
            found = self._client.messages.batches.retrieve(batch)
        return 0 if found.processing_status == "ended" else max(1, found.request_counts.processing)

    def collect(self, batch: str) -> dict[str, Reply | SceneError]:
        found: dict[str, Reply | SceneError] = {}
        with self._told():
            lines = self._client.messages.batches.results(batch)
            try:
                for name, reply in arriving((line.custom_id, self._result(line.result)) for line in lines):
                    found[name] = reply
            except BrokenStream as error:
                said = f"the answers of the batch cannot be read: {error}"
                raise failure(None, said, self._account) from None
        return found

    def _result(self, result: Any) -> Reply | SceneError:
        if result.type == "succeeded":
            return self._reply(result.message)
        said = getattr(getattr(getattr(result, "error", None), "error", None), "message", "") or result.type
        return failure(None, f"the batch's request did not succeed: {said}", self._account)

    def _told(self) -> AbstractContextManager[None]:
        """Turns the SDK's exceptions into errors in users' words."""
        import anthropic

        return told(anthropic, anthropic.AnthropicError, self._account)


class _Received:
    """What has arrived of an answer; ``reply`` once it is complete."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.usage = Usage()
        self.reply: Reply | None = None


def _message(turn: Turn) -> dict[str, Any]:
    content: list[Any] = []
    for part in turn.parts:
        content += [dict(block) for block in part.blocks] if isinstance(part, Blocks) else [_block(part)]
    return {"role": turn.role, "content": content}


def _block(part: Part) -> dict[str, Any]:
    if isinstance(part, ImageContent):
        data = base64.standard_b64encode(part.data).decode("ascii")
        return {"type": "image", "source": {"type": "base64", "media_type": part.media_type, "data": data}}
    assert isinstance(part, TextContent)
    block: dict[str, Any] = {"type": "text", "text": part.text}
    return block | {"cache_control": _KEPT} if part.is_fixed else block


def _usage(usage: Any) -> Usage:
    return Usage(
        int(usage.input_tokens or 0),
        int(usage.cache_read_input_tokens or 0),
        int(usage.cache_creation_input_tokens or 0),
        int(usage.output_tokens or 0),
    )


def _note(message: Any) -> str:
    """What a refusal says of itself."""
    details = getattr(message, "stop_details", None)
    if details is None:
        return ""
    return str(getattr(details, "explanation", None) or getattr(details, "category", None) or "")


ANTHROPIC = Family(
    "anthropic", "Claude, by the Messages API", "claude-opus-5-5", AnthropicMessages,
    ("ANTHROPIC_API_KEY",), "ANTHROPIC_BASE_URL", "https://api.anthropic.com", package="anthropic",
)  # fmt: skip
