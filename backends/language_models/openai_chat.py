"""Servers of OpenAI's chat completions, through the ``openai`` package: vLLM, llama.cpp, Ollama and others.

Which of them a server is decides how it takes a grammar; it is asked once, by the addresses that only it answers.
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
    Part,
    Reply,
    Request,
    Stop,
    TextContent,
    Turn,
    Usage,
)
from scenelang.backends.language_models.provider import BrokenStream, Family, Watch, arriving, told
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from openai import OpenAI


# Tokens counted without a service: never fewer than there are.


_BYTES_PER_TOKEN = 2  # fewer than the tokens of prose and programs have
_TOKENS_OF_PICTURE = 6_000  # more than the largest picture that services take
_FRAME = 100  # what services add around a request


def tokens_at_most(text: str) -> int:
    """More tokens than a text has."""
    return math.ceil(len(text.encode()) / _BYTES_PER_TOKEN)


def upper_estimate(request: Request) -> int:
    """More tokens than a request has."""
    parts = [part for turn in request.turns for part in turn.parts]
    texts = [request.system.text, *(part.text for part in parts if isinstance(part, TextContent))]
    texts += [str(block) for part in parts if isinstance(part, Blocks) for block in part.blocks]
    pictures = sum(isinstance(part, ImageContent) for part in parts)
    return sum(map(tokens_at_most, texts)) + pictures * _TOKENS_OF_PICTURE + _FRAME


_STOPS = {"stop": Stop.END, "tool_calls": Stop.END, "length": Stop.CUT, "content_filter": Stop.REFUSED}
_DIALECTS = ("llama.cpp", "vllm", "none")
_PROBES = (("/props", "default_generation_settings", "llama.cpp"), ("/version", "version", "vllm"))
_PATIENCE = 3.0  # seconds for a server to say what it is


class OpenAIChat:
    """Sends by streaming; retries are the package's own. A server on this machine needs no key."""

    name = "openai"

    def __init__(self, account: Account) -> None:
        self._account = account

    @cached_property
    def _client(self) -> OpenAI:
        """Connects at the first request: an estimate needs neither the package nor a key."""
        from openai import OpenAI, Timeout

        account = self._account
        timeout = Timeout(account.timeout, connect=min(CONNECT_TIMEOUT, account.timeout))
        return OpenAI(api_key=account.key or NO_KEY, base_url=account.address, timeout=timeout)

    @property
    def address(self) -> str:
        return self._account.shown_address

    def clean(self, text: str) -> str:
        return self._account.clean(text)

    @cached_property
    def dialect(self) -> str:
        """How the server takes a grammar: the configuration's ``grammar``, else what the server says that it is."""
        wanted = self._account.settings.get("grammar")
        if wanted is not None:
            if wanted not in _DIALECTS:
                raise SceneError("value", f"`grammar` of [openai] is one of {', '.join(_DIALECTS)}")
            return str(wanted)
        parts = urlsplit(self._account.address)
        root = urlunsplit((parts.scheme, parts.netloc, parts.path.removesuffix("/v1"), "", ""))
        for path, field, dialect in _PROBES:
            answer = self._probe(root + path)
            if isinstance(answer, dict) and field in answer:
                return dialect
        return "none"

    def _probe(self, url: str) -> Any:
        """What a server answers at an address that it may not have; None where it has none."""
        import openai

        try:
            return self._client.with_options(timeout=_PATIENCE, max_retries=0).get(url, cast_to=object)
        except (openai.OpenAIError, ValueError):
            return None

    def payload(self, request: Request) -> dict[str, Any]:
        system = {"role": "system", "content": request.system.text}
        payload: dict[str, Any] = {
            "model": request.model,
            "messages": [system, *(_message(turn) for turn in request.turns)],
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
        return upper_estimate(request)  # the protocol has no way to ask

    def send(self, request: Request, watch: Watch) -> Reply:
        payload = self.payload(request)
        extra = {name: payload.pop(name) for name in ("grammar", "structured_outputs") if name in payload}
        received = _Received()
        with self._told():
            stream = self._client.chat.completions.create(
                **payload, stream=True, stream_options={"include_usage": True}, extra_body=extra or None
            )
            try:
                with stream:
                    for text in arriving(received.pieces(stream)):
                        watch(text)
            except BrokenStream as error:
                return self._reply(request, received, Stop.BROKEN, str(error))
        if received.refusals:
            return self._reply(request, received, Stop.REFUSED, "".join(received.refusals))
        stop = _STOPS.get(received.stop or "", Stop.BROKEN)
        said = f"it stopped for `{received.stop}`" if received.stop else "the stream ended early"
        return self._reply(request, received, stop, said if stop is Stop.BROKEN else "")

    def _reply(self, request: Request, received: _Received, stop: Stop, note: str) -> Reply:
        clean = self._account.clean
        text, usage = clean("".join(received.texts)), received.usage
        if usage == Usage():
            usage = Usage(upper_estimate(request), answered=tokens_at_most(text))
        return Reply(text, stop, usage, clean(received.model) or request.model, clean(note)[:200])

    def _told(self) -> AbstractContextManager[None]:
        """Turns the package's exceptions into errors in users' words."""
        import openai

        return told(openai, openai.OpenAIError, self._account)


class _Received:
    """What has arrived of an answer."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.refusals: list[str] = []
        self.stop: str | None = None
        self.usage = Usage()
        self.model = ""

    def pieces(self, stream: Any) -> Iterator[str]:
        """Read a stream to its end; its texts as they come. Servers leave out what they have nothing to say about."""
        for chunk in stream:
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


def _message(turn: Turn) -> dict[str, Any]:
    texts = [part.text for part in turn.parts if isinstance(part, TextContent)]
    if len(texts) == len(turn.parts):
        return {"role": turn.role, "content": "\n\n".join(texts)}
    return {"role": turn.role, "content": [_part(part) for part in turn.parts]}


def _part(part: Part) -> dict[str, Any]:
    if isinstance(part, ImageContent):
        data = base64.standard_b64encode(part.data).decode("ascii")
        return {"type": "image_url", "image_url": {"url": f"data:{part.media_type};base64,{data}"}}
    if isinstance(part, TextContent):
        return {"type": "text", "text": part.text}
    raise SceneError("model-request", "this service cannot take a paused answer back")


OPENAI = Family(
    "openai", "any server of OpenAI's chat completions: vLLM, llama.cpp, Ollama", None, OpenAIChat,
    ("OPENAI_API_KEY",), "OPENAI_BASE_URL", "http://localhost:8000/v1", needs_key=False, package="openai",
)  # fmt: skip
