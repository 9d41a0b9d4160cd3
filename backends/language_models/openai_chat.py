"""Servers with OpenAI's chat completions API, by the ``openai`` package: vLLM, llama.cpp, Ollama and others.

The parameter for grammars depends on the server's software, which is detected once by endpoints specific to it.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import cached_property
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit, urlunsplit

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
from scenelang.backends.language_models.provider import Family, OnText, StreamError, read_stream, translate_errors
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from openai import OpenAI


# Upper bounds of token counts, without a tokenizer.


_BYTES_PER_TOKEN = 2  # lower bound of the mean in English text and programs
_TOKENS_PER_IMAGE = 6_000  # upper bound for the largest images that services accept
_REQUEST_OVERHEAD = 100  # tokens that services add to a request


def max_token_count(text: str) -> int:
    """Return an upper bound of the number of tokens of a text."""
    return math.ceil(len(text.encode()) / _BYTES_PER_TOKEN)


def estimate_tokens(request: Request) -> int:
    """Return an upper bound of the number of input tokens of a request."""
    parts = [part for message in request.messages for part in message.parts]
    texts = [request.system.text, *(part.text for part in parts if isinstance(part, TextContent))]
    texts += [str(block) for part in parts if isinstance(part, Blocks) for block in part.blocks]
    images = sum(isinstance(part, ImageContent) for part in parts)
    return sum(map(max_token_count, texts)) + images * _TOKENS_PER_IMAGE + _REQUEST_OVERHEAD


# The provider.


_STOP_REASONS = {
    "stop": StopReason.END,
    "tool_calls": StopReason.END,
    "length": StopReason.MAX_TOKENS,
    "content_filter": StopReason.REFUSED,
}
_DIALECTS = ("llama.cpp", "vllm", "none")
_PROBES = (("/props", "default_generation_settings", "llama.cpp"), ("/version", "version", "vllm"))
_PROBE_TIMEOUT = 3.0  # seconds


class OpenAIChat:
    """Provider for servers with the chat completions API; requests are streamed, and only the SDK retries them."""

    name = "openai"

    def __init__(self, account: Account) -> None:
        self._account = account

    @cached_property
    def _client(self) -> OpenAI:
        """SDK client, created at the first request, since estimates require neither the package nor a key."""
        from openai import OpenAI, Timeout

        account = self._account
        timeout = Timeout(account.timeout, connect=min(CONNECT_TIMEOUT, account.timeout))
        return OpenAI(api_key=account.key or NO_KEY, base_url=account.address, timeout=timeout)

    @property
    def address(self) -> str:
        return self._account.public_address

    def redact(self, text: str) -> str:
        return self._account.redact(text)

    @cached_property
    def dialect(self) -> str:
        """Server software, which determines the parameter for grammars: as configured by ``grammar``, or detected."""
        configured = self._account.settings.get("grammar")
        if configured is not None:
            if configured not in _DIALECTS:
                message = f"expected `grammar` in [openai] to be one of {', '.join(_DIALECTS)}, got {configured!r}"
                raise SceneError("value", message)
            return str(configured)
        parts = urlsplit(self._account.address)
        root = urlunsplit((parts.scheme, parts.netloc, parts.path.removesuffix("/v1"), "", ""))
        for path, field, dialect in _PROBES:
            answer = self._probe(root + path)
            if isinstance(answer, dict) and field in answer:
                return dialect
        return "none"

    def _probe(self, url: str) -> Any:
        """Return the response of an endpoint, None if the server does not have it."""
        import openai

        try:
            return self._client.with_options(timeout=_PROBE_TIMEOUT, max_retries=0).get(url, cast_to=object)
        except (openai.OpenAIError, ValueError):
            return None

    def payload(self, request: Request) -> dict[str, Any]:
        system = {"role": "system", "content": request.system.text}
        payload: dict[str, Any] = {
            "model": request.model,
            "messages": [system, *(_message(message) for message in request.messages)],
            "max_tokens": request.max_tokens,
        }
        if request.effort is not None:
            payload["reasoning_effort"] = request.effort
        if request.grammar is not None:
            payload |= self._grammar(request.grammar)
        return payload

    def _grammar(self, grammar: str) -> dict[str, Any]:
        if self.dialect == "llama.cpp":
            return {"grammar": grammar}
        return {"structured_outputs": {"grammar": grammar}} if self.dialect == "vllm" else {}

    def count(self, request: Request) -> int:
        return estimate_tokens(request)  # the API has no endpoint for counting

    def send(self, request: Request, on_text: OnText) -> Reply:
        payload = self.payload(request)
        extra = {name: payload.pop(name) for name in ("grammar", "structured_outputs") if name in payload}
        received = _StreamState()
        with self._translate_errors():
            stream = self._client.chat.completions.create(
                **payload, stream=True, stream_options={"include_usage": True}, extra_body=extra or None
            )
            try:
                with stream:
                    for text in read_stream(received.read(stream)):
                        on_text(text)
            except StreamError as error:
                return self._reply(request, received, StopReason.INTERRUPTED, str(error))
        if received.refusals:
            return self._reply(request, received, StopReason.REFUSED, "".join(received.refusals))
        stop = _STOP_REASONS.get(received.stop or "", StopReason.INTERRUPTED)
        reason = f"unknown stop reason `{received.stop}`" if received.stop else "the stream ended early"
        return self._reply(request, received, stop, reason if stop is StopReason.INTERRUPTED else "")

    def _reply(self, request: Request, received: _StreamState, stop: StopReason, note: str) -> Reply:
        redact = self._account.redact
        text, usage = redact("".join(received.texts)), received.usage
        if usage == Usage():
            usage = Usage(estimate_tokens(request), answered=max_token_count(text))
        return Reply(text, stop, usage, redact(received.model) or request.model, redact(note)[:200])

    def _translate_errors(self) -> AbstractContextManager[None]:
        """Translate the SDK's exceptions to SceneError."""
        import openai

        return translate_errors(openai, openai.OpenAIError, self._account)


class _StreamState:
    """Received part of a reply."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.refusals: list[str] = []
        self.stop: str | None = None
        self.usage = Usage()
        self.model = ""

    def read(self, stream: Any) -> Iterator[str]:
        """Read a stream to its end, and yield its texts."""
        for chunk in stream:  # servers omit fields without a value, so none can be relied on
            self.model = str(getattr(chunk, "model", None) or self.model)
            self.usage = _usage(getattr(chunk, "usage", None)) or self.usage
            for choice in getattr(chunk, "choices", None) or ():
                reason, delta = getattr(choice, "finish_reason", None), getattr(choice, "delta", None)
                self.stop = str(reason) if reason else self.stop
                refusal, text = getattr(delta, "refusal", None), getattr(delta, "content", None)
                if refusal and isinstance(refusal, str):
                    self.refusals.append(refusal)
                if text and isinstance(text, str):
                    self.texts.append(text)
                    yield text


def _usage(usage: Any) -> Usage | None:
    if usage is None:
        return None
    cached = int(getattr(getattr(usage, "prompt_tokens_details", None), "cached_tokens", None) or 0)
    sent, answered = getattr(usage, "prompt_tokens", None) or 0, getattr(usage, "completion_tokens", None) or 0
    return Usage(max(0, int(sent) - cached), cached, 0, int(answered))


def _message(message: Message) -> dict[str, Any]:
    texts = [part.text for part in message.parts if isinstance(part, TextContent)]
    if len(texts) == len(message.parts):
        return {"role": message.role, "content": "\n\n".join(texts)}
    return {"role": message.role, "content": [_part(part) for part in message.parts]}


def _part(part: Part) -> dict[str, Any]:
    if isinstance(part, ImageContent):
        data = base64.standard_b64encode(part.data).decode("ascii")
        return {"type": "image_url", "image_url": {"url": f"data:{part.media_type};base64,{data}"}}
    if isinstance(part, TextContent):
        return {"type": "text", "text": part.text}
    raise SceneError("model-request", "this service cannot continue a paused reply")


OPENAI = Family(
    "openai", "any server with OpenAI's chat completions API: vLLM, llama.cpp, Ollama", None, OpenAIChat,
    ("OPENAI_API_KEY",), "OPENAI_BASE_URL", "http://localhost:8000/v1", needs_key=False, package="openai",
)  # fmt: skip
