"""A local server that speaks OpenAI's chat completions, as llama.cpp, vLLM or one that is neither."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from models.server import Speaking, running

LETTERS_PER_PIECE = 16
PROBES = {
    "llama.cpp": {"/props": {"default_generation_settings": {"n_ctx": 4096}, "total_slots": 1}},
    "vllm": {"/version": {"version": "0.14.0"}},
    "plain": {},
}


@dataclass(frozen=True)
class Chat:
    """An answer. ``stop`` None ends the stream without a reason, ``breaks_after`` breaks the connection after so many
    characters, with ``last_words`` before that; ``usage`` None says nothing of tokens; ``pieces`` are sent as chunks in
    place of all else."""

    text: str = ""
    stop: str | None = "stop"
    status: int = 200
    usage: dict[str, Any] | None = field(default_factory=lambda: {"prompt_tokens": 100, "completion_tokens": 20})
    breaks_after: int | None = None
    last_words: str = ""
    refusal: str = ""
    model: str | None = None
    pieces: Sequence[str] = ()


class ChatServer:
    """``requests`` are the bodies of all questions, ``headers`` theirs, ``probed`` the other paths that were asked."""

    def __init__(self, script: Sequence[Chat] | Callable[[dict[str, Any]], Chat], kind: str) -> None:
        self.script = script if callable(script) else list(script)
        self.kind = kind
        self.requests: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.probed: list[str] = []
        self.url = ""


@contextmanager
def chatting(script: Sequence[Chat] | Callable[[dict[str, Any]], Chat], kind: str = "plain") -> Iterator[ChatServer]:
    """A server on this machine for the time of the block; its ``url`` is the base URL."""
    state = ChatServer(script, kind)

    class Handler(Speaking):
        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["content-length"])))
            if self.path != "/v1/chat/completions":
                self._json({"error": {"message": "no such path"}}, 404)
                return
            if callable(state.script):
                chat = state.script(body)
            else:
                assert len(state.requests) < len(state.script), f"the model is asked {len(state.requests) + 1} times"
                chat = state.script[len(state.requests)]
            state.requests.append(body)
            state.headers.append({name.lower(): value for name, value in self.headers.items()})
            if chat.status != 200:
                self._json({"error": {"message": chat.text, "type": "error", "code": None}}, chat.status)
            else:
                self._stream(_lines(chat, body))

        def do_GET(self) -> None:
            state.probed.append(self.path)
            found = PROBES[state.kind].get(self.path)
            self._json(found or {"error": {"message": "Not Found"}}, 200 if found else 404)

    with running(Handler) as url:
        state.url = f"{url}/v1"
        yield state


def _lines(chat: Chat, body: dict[str, Any]) -> Iterator[str | None]:
    for piece in chat.pieces or _chunks(chat, body):
        yield f"data: {piece}\n\n" if isinstance(piece, str) else None
    if chat.last_words:
        yield chat.last_words
    if chat.breaks_after is None:
        yield "data: [DONE]\n\n"


def _chunks(chat: Chat, body: dict[str, Any]) -> Iterator[str | None]:
    sent = 0
    yield _chunk(chat, body, {"role": "assistant", "content": ""}, None)
    for letter in chat.refusal.split(" ") if chat.refusal else ():
        yield _chunk(chat, body, {"refusal": f"{letter} "}, None)
    while sent < len(chat.text):
        if chat.breaks_after is not None and sent >= chat.breaks_after:
            if not chat.last_words:
                yield None
            return
        yield _chunk(chat, body, {"content": chat.text[sent : sent + LETTERS_PER_PIECE]}, None)
        sent += LETTERS_PER_PIECE
    yield _chunk(chat, body, {}, chat.stop)
    if chat.usage is not None:
        last = json.loads(_chunk(chat, body, {}, None)) | {"choices": [], "usage": chat.usage}
        yield json.dumps(last)


def _chunk(chat: Chat, body: dict[str, Any], delta: dict[str, Any], stop: str | None) -> str:
    choice = {"index": 0, "delta": delta, "finish_reason": stop}
    model = chat.model or body["model"]
    return json.dumps({"id": "c", "object": "chat.completion.chunk", "created": 0, "model": model, "choices": [choice]})
