"""A local server that speaks the Messages API, enough for the SDK: streams, images, errors, batches, broken lines.

What it answers is scripted: a list of answers, one for each request that is not a count of tokens.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock, Thread
from typing import Any

RESPONSES_PER_PIECE = 64  # characters in one event of a stream
MOST_PIECES = 1000
NONE: Mapping[str, str] = {}


@dataclass(frozen=True)
class Said:
    """An answer. ``status`` other than 200 is an error; ``breaks_after`` closes the connection after so many characters,
    with ``last_words`` before that as they stand; ``drops`` closes it before anything is said; ``waits`` are seconds
    before the answer; ``thinks`` puts a block of thinking before the text; ``model`` is the one that says it answers."""

    text: str = ""
    stop: str = "end_turn"
    status: int = 200
    breaks_after: int | None = None
    is_error_event: bool = False
    thinks: bool = False
    usage: dict[str, int] = field(default_factory=dict)
    details: dict[str, Any] | None = None
    last_words: str = ""
    drops: bool = False
    waits: float = 0.0
    model: str | None = None
    headers: dict[str, str] = field(default_factory=dict)


Script = Sequence[Said] | Callable[[dict[str, Any]], Said]


class ModelServer:
    """``requests`` are the bodies of all questions, ``counted`` those whose tokens were counted, ``polled`` the batches
    that were asked after. ``count`` is how counting is answered: tokens, or the status of an error below 0. A batch is
    done once it was asked after more than ``patience`` times; ``tail`` follows its results."""

    def __init__(self, script: Script) -> None:
        self.script = script
        self.requests: list[dict[str, Any]] = []
        self.counted: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.batches: dict[str, list[dict[str, Any]]] = {}
        self.polled: list[str] = []
        self.count: Callable[[dict[str, Any]], int] = lambda body: len(json.dumps(body)) // 4
        self.patience = 1
        self.tail = ""
        self.url = ""
        self._next = 0
        self._lock = Lock()

    def renew(self, script: Script) -> None:
        """Answer from another script, and forget what was asked."""
        with self._lock:
            self.script, self._next, self.polled = script, 0, []
            self.requests, self.counted, self.headers, self.batches = [], [], [], {}

    def answer(self, body: dict[str, Any]) -> Said:
        with self._lock:
            self.requests.append(body)
            if callable(self.script):
                return self.script(body)
            position, self._next = self._next, self._next + 1
            if position >= len(self.script):
                return Said(f"the model is asked {position + 1} times", status=400)
            return self.script[position]


@contextmanager
def serving(script: Script) -> Iterator[ModelServer]:
    """A server on this machine for the time of the block."""
    state = ModelServer(script)

    class Handler(Speaking):
        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["content-length"])))
            state.headers.append({name.lower(): value for name, value in self.headers.items()})
            if self.path.startswith("/v1/messages/count_tokens"):
                state.counted.append(body)
                tokens = state.count(body)
                self._json({"input_tokens": tokens}) if tokens >= 0 else self._refuse(Said("no counts", status=-tokens))
            elif self.path.startswith("/v1/messages/batches"):
                self._batch(body)
            else:
                self._say(state.answer(body), body)

        def do_GET(self) -> None:
            name = self.path.split("/")[4].split("?")[0] if self.path.count("/") >= 4 else ""
            if self.path.endswith("/results"):
                lines = [self._result(entry) for entry in state.batches[name]][::-1]  # in any order
                self._send(200, ("\n".join(map(json.dumps, lines)) + state.tail).encode(), "application/x-jsonl")
            elif name in state.batches:
                state.polled.append(name)
                is_done = state.polled.count(name) > state.patience
                self._json(batch(name, "ended" if is_done else "in_progress", self))
            else:
                self._json({"type": "error", "error": {"type": "not_found_error", "message": "no such thing"}}, 404)

        def _batch(self, body: dict[str, Any]) -> None:
            name = f"msgbatch_{len(state.batches)}"
            state.batches[name] = body["requests"]
            self._json(batch(name, "in_progress", self))

        def _result(self, entry: dict[str, Any]) -> dict[str, Any]:
            said = state.answer(entry["params"])
            if said.status != 200:
                error = {"type": "error", "error": {"type": "invalid_request_error", "message": said.text}}
                return {"custom_id": entry["custom_id"], "result": {"type": "errored", "error": error}}
            result = {"type": "succeeded", "message": message(said, entry["params"])}
            return {"custom_id": entry["custom_id"], "result": result}

        def _say(self, said: Said, body: dict[str, Any]) -> None:
            time.sleep(said.waits)
            if said.drops:
                self.close_connection = True
            elif said.status != 200:
                self._refuse(said)
            elif not body.get("stream"):
                self._json(message(said, body))
            else:
                self._stream(lines(said, body), said.headers)

        def _refuse(self, said: Said) -> None:
            kind = KINDS.get(said.status, "api_error")
            error = {"type": "error", "error": {"type": kind, "message": said.text}}
            self._json(error, said.status, said.headers)

    with running(Handler) as state.url:
        yield state


KINDS = {
    400: "invalid_request_error", 401: "authentication_error", 403: "permission_error", 404: "not_found_error",
    413: "request_too_large", 429: "rate_limit_error", 529: "overloaded_error",
}  # fmt: skip


class Speaking(BaseHTTPRequestHandler):
    """What servers have in common: JSON and streams of events; clients that try again need not wait."""

    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True  # which holds small pieces back

    def _json(self, data: Any, status: int = 200, headers: Mapping[str, str] = NONE) -> None:
        self._send(status, json.dumps(data).encode(), "application/json", headers)

    def _send(self, status: int, data: bytes, kind: str, headers: Mapping[str, str] = NONE) -> None:
        more = {"content-type": kind, "content-length": str(len(data)), "retry-after-ms": "1"}
        self._head(status, {**more, **headers})
        self.wfile.write(data)

    def _stream(self, pieces: Iterator[str | None], headers: Mapping[str, str] = NONE) -> None:
        """Send a stream piece by piece; None breaks the connection."""
        self._head(200, {"content-type": "text/event-stream", "transfer-encoding": "chunked", **headers})
        for piece in pieces:
            if piece is None:
                self.close_connection = True
                return
            data = piece.encode()
            self.wfile.write(f"{len(data):x}\r\n".encode() + data + b"\r\n")
        self.wfile.write(b"0\r\n\r\n")

    def _head(self, status: int, headers: Mapping[str, str]) -> None:
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def running(handler: type[BaseHTTPRequestHandler]) -> Iterator[str]:
    """The address of a server on this machine for the time of the block."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    server.daemon_threads = True
    server.handle_error = lambda request, client_address: None  # a client that was killed hears nothing more
    thread = Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}"
    finally:
        server.shutdown()
        server.server_close()


def batch(name: str, status: str, handler: BaseHTTPRequestHandler) -> dict[str, Any]:
    host = handler.headers["host"]
    return {
        "id": name,
        "type": "message_batch",
        "processing_status": status,
        "request_counts": {"processing": 1, "succeeded": 0, "errored": 0, "canceled": 0, "expired": 0},
        "created_at": "2026-11-22T00:00:00Z",
        "expires_at": "2026-11-23T00:00:00Z",
        "ended_at": None,
        "archived_at": None,
        "cancel_initiated_at": None,
        "results_url": f"http://{host}/v1/messages/batches/{name}/results" if status == "ended" else None,
    }


def usage(said: Said) -> dict[str, Any]:
    tokens = {"input_tokens": 1000, "output_tokens": max(1, len(said.text) // 4)}
    return {**tokens, "cache_read_input_tokens": 0, "cache_creation_input_tokens": 0, **said.usage}


def message(said: Said, body: dict[str, Any]) -> dict[str, Any]:
    content = [{"type": "text", "text": said.text}] if said.text else []
    found = {
        "id": "msg_1", "type": "message", "role": "assistant", "model": said.model or body["model"], "content": content,
        "stop_reason": said.stop, "stop_sequence": None, "usage": usage(said),
    }  # fmt: skip
    return found | ({"stop_details": said.details} if said.details else {})


def lines(said: Said, body: dict[str, Any]) -> Iterator[str | None]:
    """The events of a stream as they are sent."""
    for event in events(said, body):
        if event is None and said.last_words:
            yield said.last_words
        yield f"event: {event['type']}\ndata: {json.dumps(event)}\n\n" if event is not None else None


def events(said: Said, body: dict[str, Any]) -> Iterator[dict[str, Any] | None]:
    """The events of a stream; None where the connection breaks."""
    start = message(said, body) | {"content": [], "stop_reason": None}
    start.pop("stop_details", None)
    start["usage"] = {**usage(said), "output_tokens": 1}
    yield {"type": "message_start", "message": start}
    index = 0
    if said.thinks:
        yield {
            "type": "content_block_start",
            "index": 0,
            "content_block": {"type": "thinking", "thinking": "", "signature": ""},
        }
        yield {"type": "content_block_delta", "index": 0, "delta": {"type": "thinking_delta", "thinking": "hm"}}
        yield {"type": "content_block_delta", "index": 0, "delta": {"type": "signature_delta", "signature": "c2ln"}}
        yield {"type": "content_block_stop", "index": 0}
        index = 1
    yield {"type": "ping"}
    yield {"type": "content_block_start", "index": index, "content_block": {"type": "text", "text": ""}}
    sent = 0
    length = max(RESPONSES_PER_PIECE, len(said.text) // MOST_PIECES)
    for start_of_piece in range(0, len(said.text), length):
        if said.breaks_after is not None and sent >= said.breaks_after:
            yield from _break(said)
            return
        piece = said.text[start_of_piece : start_of_piece + length]
        yield {"type": "content_block_delta", "index": index, "delta": {"type": "text_delta", "text": piece}}
        sent += len(piece)
    if said.breaks_after is not None:
        yield from _break(said)
        return
    yield {"type": "content_block_stop", "index": index}
    delta = {"stop_reason": said.stop, "stop_sequence": None}
    if said.details:
        delta["stop_details"] = said.details
    yield {"type": "message_delta", "delta": delta, "usage": usage(said)}
    yield {"type": "message_stop"}


def _break(said: Said) -> Iterator[dict[str, Any] | None]:
    if said.is_error_event:
        yield {"type": "error", "error": {"type": "overloaded_error", "message": "overloaded in mid-stream"}}
    yield None
