"""HTTP server of the live viewer and the studio: on localhost, with a token in every URL, closed to other origins.

Paths below ``/TOKEN/``: the page, its script and style; ``files``; ``state?file=N``; ``picture?file=N`` (the packet, or
with ``&has=V`` the changes to the version V, which is the ETag of an earlier answer);
``events`` (server-sent); POST ``set`` and ``save`` with JSON. In the studio also ``text?file=N``, ``progress``, and
POST ``edit``, ``store``, ``literal``, ``create``, ``stop``, the tools of ``program_tools``, and ``lsp``: messages of
the language server go by requests and come with the events, so that one set of checks guards all of them.
Other paths and wrong tokens return 404, a foreign Host or Origin returns 403.
"""

from __future__ import annotations

import asyncio
import functools
import hmac
import json
import queue
import secrets
import threading
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from scenelang.backends.viewer import packet
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.plugins import SERVICES
from scenelang.viewer.program_tools import TOOLS
from scenelang.viewer.workspace import FileWatch, Workspace, state_data

HOST = "127.0.0.1"
MAX_BODY_SIZE = 64 * 1024  # of a request, in bytes
MAX_TEXT_SIZE = 16 * 1024 * 1024  # of a request with a program, in bytes
_HEARTBEAT_S = 10.0  # seconds between events that keep proxies from closing the connection
_TIMEOUT_S = 30.0  # seconds of a silent connection
_MAX_LISTENERS = 32  # open pages that receive events, each of which occupies a thread
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'{nonce}; img-src data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_EDITING = ("edit", "store", "literal", *TOOLS, "create", "stop", "lsp")  # what only the studio accepts
_MAX_CLIENT_LENGTH = 64  # characters of a page's name


class _Channels:
    """Language servers of the open pages, by the name that each page gave itself, in one asyncio loop.

    Messages wait in the queue of their page until it reads them, as a page sends its first one before it listens.
    """

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._channels: dict[str, Any] = {}
        self._queues: dict[str, queue.SimpleQueue[str | None]] = {}
        self._lock = threading.Lock()
        threading.Thread(target=self._loop.run_forever, daemon=True).start()

    def attach(self, client: str) -> queue.SimpleQueue[str | None]:
        """Return a new queue for a connection of a page, with the messages that wait; an earlier connection ends."""
        messages: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        with self._lock:
            earlier = self._queue(client)
            while not earlier.empty():
                message = earlier.get()
                if message is not None:
                    messages.put(message)
            earlier.put(None)
            self._queues[client] = messages
        return messages

    def _queue(self, client: str) -> queue.SimpleQueue[str | None]:
        """Return the queue of a page; the oldest of too many pages is forgotten. The caller holds the lock."""
        if client not in self._queues and len(self._queues) >= _MAX_LISTENERS:
            oldest = next(iter(self._queues))
            del self._queues[oldest]
            self._loop.call_soon_threadsafe(self._channels.pop, oldest, None)
        return self._queues.setdefault(client, queue.SimpleQueue())

    def _send(self, client: str, message: str) -> None:
        """Put a message of a language server into the queue of its page."""
        with self._lock:
            self._queue(client).put(message)

    def receive(self, client: str, message: str) -> None:
        """Pass a message of a page to its language server."""
        self._loop.call_soon_threadsafe(self._handle, client, message)

    def _handle(self, client: str, message: str) -> None:
        if client not in self._channels:
            with self._lock:
                self._queue(client)
            send = functools.partial(self._send, client)
            self._channels[client] = SERVICES.find("language-server")("studio", send)
        self._channels[client].receive(message)

    def stop(self) -> None:
        """End the loop."""
        self._loop.call_soon_threadsafe(self._loop.stop)


class ViewServer(ThreadingHTTPServer):
    """HTTP server of a workspace. ``address`` is the URL to open. Raises SceneError("file") if the port is in use.

    With ``edits``, the page has an editor and may write the files of the workspace (`scenelang studio`).
    """

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, workspace: Workspace, port: int = 0, edits: bool = False) -> None:
        """Bind the port and start watching the files; raises SceneError("file") if the port is in use."""
        if edits:
            SERVICES.find("language-server")  # a missing package is reported before the page opens
        self.workspace = workspace
        self.channels = _Channels() if edits else None
        self.token = secrets.token_urlsafe(24)
        self._events: list[queue.SimpleQueue[Event]] = []
        self._events_lock = threading.Lock()
        self._watch: FileWatch | None = None
        try:
            super().__init__((HOST, port), _Handler)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or error
            raise SceneError("file", f"cannot serve on port {port}: {reason}", "choose another --port") from None
        workspace.listen(self._announce)
        self._watch = FileWatch(lambda: workspace.folders, workspace.refresh)

    @property
    def address(self) -> str:
        """URL to open, with the token."""
        return f"http://{HOST}:{self.server_port}/{self.token}/"

    @property
    def hosts(self) -> tuple[str, str]:
        """Return the accepted Host headers, to reject DNS rebinding."""
        return f"{HOST}:{self.server_port}", f"localhost:{self.server_port}"

    def subscribe(self) -> queue.SimpleQueue[Event] | None:
        """Return a queue of the numbers of changed files, and of messages; None if there are too many subscribers."""
        with self._events_lock:
            if len(self._events) >= _MAX_LISTENERS:
                return None
            self._events.append(queue.SimpleQueue())
            return self._events[-1]

    def unsubscribe(self, events: queue.SimpleQueue[Event]) -> None:
        """End a subscription."""
        with self._events_lock:
            self._events.remove(events)

    def server_close(self) -> None:
        """Stop watching and end all event streams, then close the socket."""
        if self._watch is not None:
            self._watch.stop()
        with self._events_lock:
            for events in self._events:
                events.put(None)
        if self.channels is not None:
            self.channels.stop()
        super().server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore disconnected browsers."""

    def _announce(self, file: int) -> None:
        """Tell all subscribers that a file has changed."""
        with self._events_lock:
            for events in self._events:
                events.put(file)


Event = int | str | None  # the number of a file that changed, a message of the language server, or the end


def _pump(messages: queue.SimpleQueue[str | None], events: queue.SimpleQueue[Event]) -> None:
    """Pass a language server's messages to the events of its page until None comes."""
    while (message := messages.get()) is not None:
        events.put(message)


def _client(name: Any) -> str:
    """Return the name that a page has given itself; raises _Refused if it is none."""
    if not isinstance(name, str) or not name or len(name) > _MAX_CLIENT_LENGTH:
        raise _Refused(HTTPStatus.BAD_REQUEST, "missing name of the page")
    return name


def _text(data: dict[str, Any], name: str) -> str:
    """Return a text of a request; raises _Refused if there is none."""
    value = data.get(name)
    if not isinstance(value, str):
        raise _Refused(HTTPStatus.BAD_REQUEST, f"missing {name}")
    return value


class _Refused(Exception):
    """Raised to refuse a request with a status and a one-line message."""

    def __init__(self, status: HTTPStatus, message: str) -> None:
        self.status, self.message = status, message


class _Handler(BaseHTTPRequestHandler):
    """Handler of one connection."""

    server: ViewServer
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "scenelang", ""
    timeout = _TIMEOUT_S

    def do_GET(self) -> None:
        """Answer a GET request."""
        self._guarded(self._get)

    def do_POST(self) -> None:
        """Answer a POST request."""
        self._guarded(self._post)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Log nothing, so that the URL with its token does not appear in logs."""

    # --- access control --------------------------------------------------------------------------------------------

    def _guarded(self, action: Callable[[str, dict[str, str]], None]) -> None:
        """Run an action of an authorized request; errors become JSON responses."""
        try:
            action(*self._checked())
        except _Refused as refused:
            self.close_connection = True  # an unread body must not be parsed as the next request
            self._send_json({"message": refused.message}, refused.status)
        except SceneError as error:
            self._send_json({"message": error.message, "hint": error.hint}, HTTPStatus.CONFLICT)
        except (BrokenPipeError, ConnectionError, TimeoutError):
            self.close_connection = True
        except (ValueError, TypeError, OverflowError, RecursionError):  # data of another kind than is asked for
            self._send_json({"message": "invalid data"}, HTTPStatus.BAD_REQUEST)

    def _checked(self) -> tuple[str, dict[str, str]]:
        """Return path and query of an authorized request; raises _Refused otherwise."""
        origin = self.headers.get("Origin")
        if self.headers.get("Host") not in self.server.hosts:
            raise _Refused(HTTPStatus.FORBIDDEN, "this server only accepts requests to 127.0.0.1")
        if origin is not None and origin not in [f"http://{host}" for host in self.server.hosts]:
            raise _Refused(HTTPStatus.FORBIDDEN, "cross-site requests are not allowed")
        is_link = (
            self.command == "GET" and self.headers.get("Sec-Fetch-Dest") == "document"
        )  # navigation by a link is allowed
        if self.headers.get("Sec-Fetch-Site") in ("cross-site", "same-site") and not is_link:
            raise _Refused(HTTPStatus.FORBIDDEN, "cross-site requests are not allowed")
        parts = urlsplit(self.path)
        _, _, rest = parts.path.partition("/")
        token, slash, name = rest.partition("/")
        if not slash or not hmac.compare_digest(token.encode(), self.server.token.encode()):
            raise _Refused(HTTPStatus.NOT_FOUND, "not found")
        try:
            query = parse_qs(parts.query, max_num_fields=8)
        except ValueError:
            raise _Refused(HTTPStatus.BAD_REQUEST, "too many fields in the query") from None
        return name, {key: values[0] for key, values in query.items()}

    def _file(self, text: Any) -> int:
        """Parse the number of a file; raises _Refused if it is invalid."""
        number = int(text) if isinstance(text, (str, int)) and str(text).isdecimal() and len(str(text)) < 6 else -1
        if not 0 <= number < len(self.server.workspace.files):
            raise _Refused(HTTPStatus.NOT_FOUND, "file not found")
        return number

    # --- GET -------------------------------------------------------------------------------------------------------

    def _get(self, name: str, query: dict[str, str]) -> None:
        """Answer a GET request for a name below the token."""
        edits = self.server.channels is not None
        if name == "":
            nonce = secrets.token_urlsafe(16) if edits else None
            self._send(packet.served_page(nonce), "text/html; charset=utf-8", nonce=nonce)
        elif name in packet.STATIC:
            self._send(packet.static(name), packet.STATIC[name])
        elif name == "files":
            files = self.server.workspace.files
            self._send_json({"files": list(files), "uris": [Path(name).resolve().as_uri() for name in files]})
        elif name == "text" and edits:
            number = self._file(query.get("file"))
            text = self.server.workspace.text(number)
            self._send_json({"name": self.server.workspace.files[number], "text": text})
        elif name == "progress" and edits:
            self._send_json({"progress": self.server.workspace.progress()})
        elif name == "state":
            self._send_state(self._file(query.get("file")))
        elif name == "picture":
            self._send_picture(self._file(query.get("file")), query.get("has"))
        elif name == "events":
            self._send_events(query.get("client"))
        else:
            raise _Refused(HTTPStatus.NOT_FOUND, "not found")

    def _send_state(self, file: int) -> None:
        """Send the state of a file."""
        workspace = self.server.workspace
        self._send_json(state_data(workspace.files[file], workspace.state(file), path=workspace.files[file]))

    def _send_picture(self, file: int, has: str | None) -> None:
        """Send the packet of a file, or its changes to the version ``has`` if that is shorter."""
        state = self.server.workspace.state(file)
        body = state.packet
        if body is None:
            raise _Refused(HTTPStatus.NOT_FOUND, "not rendered yet")
        if state.last is not None and has == str(state.last[0]):
            body = min(packet.packet_changes(state.last[1], body), body, key=len)
        self._send(body, "application/octet-stream", tag=f'"{state.picture}"')

    def _send_events(self, client: str | None) -> None:
        """Send events until the page disconnects or the server closes."""
        events = self.server.subscribe()
        if events is None:
            raise _Refused(HTTPStatus.SERVICE_UNAVAILABLE, "too many open pages")
        self.close_connection = True
        channels = self.server.channels
        pump = None
        try:
            self._headers(HTTPStatus.OK, "text/event-stream", None)
            self.wfile.write(b"retry: 1000\n\n")
            if client is not None and channels is not None:
                messages = channels.attach(_client(client))
                pump = threading.Thread(target=_pump, args=(messages, events), daemon=True)
                pump.start()
            while True:
                try:
                    event = events.get(timeout=_HEARTBEAT_S)
                except queue.Empty:
                    self.wfile.write(b": still here\n\n")
                    continue
                if event is None:
                    return
                text = (
                    f"lsp\ndata: {event}" if isinstance(event, str) else f"change\ndata: {json.dumps({'file': event})}"
                )
                self.wfile.write(f"event: {text}\n\n".encode())
        finally:
            self.server.unsubscribe(events)
            if pump is not None:
                messages.put(None)  # the page may come back

    # --- POST ------------------------------------------------------------------------------------------------------

    def _post(self, name: str, query: dict[str, str]) -> None:
        """Set or save the value of a param, or, in the studio, the text of a program."""
        edits = self.server.channels is not None
        if name not in ("set", "save") and not (edits and name in _EDITING):
            raise _Refused(HTTPStatus.NOT_FOUND, "not found")
        data = self._body(MAX_TEXT_SIZE if edits else MAX_BODY_SIZE)
        if name in _EDITING:
            self._post_edit(name, data)
            return
        file, param = self._file(data.get("file")), data.get("name")
        if not isinstance(param, str):
            raise _Refused(HTTPStatus.BAD_REQUEST, "missing name of a param")
        self.server.workspace.state(file)
        if name == "set":
            self.server.workspace.try_value(file, param, data.get("value"))
        else:
            self.server.workspace.save(file, param)
        self._send_state(file)

    def _post_edit(self, name: str, data: dict[str, Any]) -> None:
        """Handle a request of the editor."""
        workspace = self.server.workspace
        if name == "lsp":
            assert self.server.channels is not None, "only the studio accepts it"
            self.server.channels.receive(_client(data.get("client")), _text(data, "message"))
            self._send_json({})
            return
        if name == "stop":
            workspace.interrupt(_text(data, "what") if "what" in data else "edit")
            self._send_json({})
            return
        if name == "create":
            self._send_json({"file": workspace.create(_text(data, "name"))})
            return
        file = self._file(data.get("file"))
        workspace.state(file)
        if name in TOOLS:
            change = data.get("change", {})
            if not isinstance(change, dict):
                raise _Refused(HTTPStatus.BAD_REQUEST, "missing change")
            self._send_json(workspace.use(name, file, _text(data, "text"), change))
            return
        if name == "literal":
            self._send_json(workspace.literal_edit(file, _text(data, "name"), data.get("value"), _text(data, "text")))
            return
        if name == "edit":
            workspace.edit(file, None if data.get("text") is None else _text(data, "text"))
        else:
            workspace.store(file, _text(data, "text"), _text(data, "before"))
        self._send_state(file)

    def _body(self, limit: int) -> dict[str, Any]:
        """Read the JSON object of the request body; raises _Refused."""
        if self.headers.get_content_type() != "application/json":
            raise _Refused(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "send JSON")
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or self.headers.get("Transfer-Encoding") is not None:
            raise _Refused(HTTPStatus.LENGTH_REQUIRED, "missing Content-Length")
        if len(length) > 9 or int(length) > limit:
            raise _Refused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "request body too large")
        try:
            data = json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            raise _Refused(HTTPStatus.BAD_REQUEST, "invalid JSON") from None
        if not isinstance(data, dict):
            raise _Refused(HTTPStatus.BAD_REQUEST, "expected a JSON object")
        return data

    # --- answers ---------------------------------------------------------------------------------------------------

    def _send_json(self, data: dict[str, Any], status: HTTPStatus = HTTPStatus.OK) -> None:
        """Send JSON data."""
        self._send(json.dumps(data).encode(), "application/json", status)

    def _send(
        self, body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK, tag: str | None = None,
        nonce: str | None = None,
    ) -> None:  # fmt: skip
        """Send a body."""
        self._headers(status, kind, len(body), tag, nonce)
        if self.command != "HEAD":
            self.wfile.write(body)

    def _headers(
        self, status: HTTPStatus, kind: str, length: int | None, tag: str | None = None, nonce: str | None = None
    ) -> None:
        """Send the status and headers of a response, which forbid caching and other origins."""
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        if tag is not None:
            self.send_header("ETag", tag)
        if self.close_connection:
            self.send_header("Connection", "close")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", _POLICY.format(nonce=f" 'nonce-{nonce}'" if nonce else ""))
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.end_headers()
