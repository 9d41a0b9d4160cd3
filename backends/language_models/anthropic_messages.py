"""Claude models, by the Messages API of the ``anthropic`` package."""

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
    Message,
    Part,
    Reply,
    Request,
    StopReason,
    TextContent,
    Usage,
)
from scenelang.backends.language_models.openai_chat import estimate_tokens, max_token_count
from scenelang.backends.language_models.provider import (
    Family,
    OnText,
    StreamError,
    read_stream,
    request_error,
    translate_errors,
)
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from anthropic import Anthropic

_STOP_REASONS = {
    "end_turn": StopReason.END,
    "stop_sequence": StopReason.END,
    "tool_use": StopReason.END,
    "max_tokens": StopReason.MAX_TOKENS,
    "model_context_window_exceeded": StopReason.CONTEXT_FULL,
    "refusal": StopReason.REFUSED,
    "pause_turn": StopReason.PAUSED,
}
_CACHE_CONTROL = {"type": "ephemeral"}


class AnthropicMessages:
    """Provider for Claude models; requests are streamed, and only the SDK retries them."""

    name = "anthropic"

    def __init__(self, account: Account) -> None:
        self._account = account

    @cached_property
    def _client(self) -> Anthropic:
        """SDK client, created at the first request, since estimates require neither the package nor a key."""
        from anthropic import Anthropic, Timeout

        account = self._account
        timeout = Timeout(account.timeout, connect=min(CONNECT_TIMEOUT, account.timeout))
        return Anthropic(api_key=account.key or NO_KEY, base_url=account.address, timeout=timeout)

    @property
    def address(self) -> str:
        return self._account.public_address

    def redact(self, text: str) -> str:
        return self._account.redact(text)

    def payload(self, request: Request) -> dict[str, Any]:
        payload = self._prompt(request) | {"max_tokens": request.max_tokens}
        if request.effort is not None:
            payload["output_config"] = {"effort": request.effort}
        return payload

    def _prompt(self, request: Request) -> dict[str, Any]:
        """Return the part of the payload that counts as input tokens."""
        prompt: dict[str, Any] = {
            "model": request.model,
            "system": [_block(request.system)],
            "messages": [_message(message) for message in request.messages],
        }
        if request.thinking is not None:
            prompt["thinking"] = {"type": request.thinking}
        return prompt

    def count(self, request: Request) -> int:
        prompt = self._prompt(request)
        try:
            with self._translate_errors():
                return int(self._client.messages.count_tokens(**prompt).input_tokens)
        except SceneError as error:
            if error.name != "model-request":
                raise
            return estimate_tokens(request)  # some gateways do not support counting

    def send(self, request: Request, on_text: OnText) -> Reply:
        received = _StreamState()
        with self._translate_errors(), self._client.messages.stream(**self.payload(request)) as stream:
            try:
                for text in read_stream(self._texts(stream, received)):
                    on_text(text)
            except StreamError as error:
                return self._interrupted(request, received, str(error))
        return received.reply or self._interrupted(request, received, "the stream ended early")

    def _texts(self, stream: Any, received: _StreamState) -> Iterator[str]:
        """Read a stream to its end, and yield its texts."""
        for event in stream:
            if event.type == "text":
                received.texts.append(event.text)
                yield event.text
            elif event.type == "message_start":
                received.usage = _usage(event.message.usage)
        message = stream.get_final_message()
        if message.stop_reason is not None:
            received.reply = self._reply(message)

    def _interrupted(self, request: Request, received: _StreamState, reason: str) -> Reply:
        """Return an interrupted reply; its output tokens are an upper bound, since the service does not report them."""
        text = self._account.redact("".join(received.texts))
        usage = replace(received.usage, answered=max(received.usage.answered, max_token_count(text)))
        return Reply(text, StopReason.INTERRUPTED, usage, request.model, self._account.redact(reason)[:200])

    def _reply(self, message: Any) -> Reply:
        stop, redact = _STOP_REASONS.get(message.stop_reason, StopReason.INTERRUPTED), self._account.redact
        text = "".join(block.text for block in message.content if block.type == "text")
        note = _note(message) if stop is not StopReason.INTERRUPTED else f"unknown stop reason `{message.stop_reason}`"
        blocks: tuple[Mapping[str, Any], ...] = ()
        if stop is StopReason.PAUSED:
            blocks = tuple(block.to_dict() for block in message.content)
        usage = _usage(message.usage)
        return Reply(redact(text), stop, usage, redact(str(message.model)), redact(note)[:200], blocks)

    # --- batches -----------------------------------------------------------------------------------------------

    def submit(self, requests: Mapping[str, Request]) -> str:
        batch_requests: Any = [
            {"custom_id": name, "params": self.payload(request)} for name, request in requests.items()
        ]
        with self._translate_errors():
            return str(self._client.messages.batches.create(requests=batch_requests).id)

    def pending(self, batch: str) -> int:
        with self._translate_errors():
            state = self._client.messages.batches.retrieve(batch)
        return 0 if state.processing_status == "ended" else max(1, state.request_counts.processing)

    def collect(self, batch: str) -> dict[str, Reply | SceneError]:
        replies: dict[str, Reply | SceneError] = {}
        with self._translate_errors():
            lines = self._client.messages.batches.results(batch)
            try:
                for name, reply in read_stream((line.custom_id, self._result(line.result)) for line in lines):
                    replies[name] = reply
            except StreamError as error:
                raise request_error(None, f"cannot read the replies of the batch: {error}", self._account) from None
        return replies

    def _result(self, result: Any) -> Reply | SceneError:
        if result.type == "succeeded":
            return self._reply(result.message)
        reason = getattr(getattr(getattr(result, "error", None), "error", None), "message", "") or result.type
        return request_error(None, f"the request in the batch failed: {reason}", self._account)

    def _translate_errors(self) -> AbstractContextManager[None]:
        """Translate the SDK's exceptions to SceneError."""
        import anthropic

        return translate_errors(anthropic, anthropic.AnthropicError, self._account)


class _StreamState:
    """Received part of a reply; ``reply`` is set when it is complete."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.usage = Usage()
        self.reply: Reply | None = None


def _message(message: Message) -> dict[str, Any]:
    content: list[Any] = []
    for part in message.parts:
        content += [dict(block) for block in part.blocks] if isinstance(part, Blocks) else [_block(part)]
    return {"role": message.role, "content": content}


def _block(part: Part) -> dict[str, Any]:
    if isinstance(part, ImageContent):
        data = base64.standard_b64encode(part.data).decode("ascii")
        return {"type": "image", "source": {"type": "base64", "media_type": part.media_type, "data": data}}
    assert isinstance(part, TextContent)
    block: dict[str, Any] = {"type": "text", "text": part.text}
    return block | {"cache_control": _CACHE_CONTROL} if part.is_cacheable else block


def _usage(usage: Any) -> Usage:
    return Usage(
        int(usage.input_tokens or 0),
        int(usage.cache_read_input_tokens or 0),
        int(usage.cache_creation_input_tokens or 0),
        int(usage.output_tokens or 0),
    )


def _note(message: Any) -> str:
    """Return the explanation of a refusal, if any."""
    details = getattr(message, "stop_details", None)
    if details is None:
        return ""
    return str(getattr(details, "explanation", None) or getattr(details, "category", None) or "")


ANTHROPIC = Family(
    "anthropic", "Claude, by the Messages API", "claude-opus-5-5", AnthropicMessages,
    ("ANTHROPIC_API_KEY",), "ANTHROPIC_BASE_URL", "https://api.anthropic.com", package="anthropic",
)  # fmt: skip
