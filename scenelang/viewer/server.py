"""HTTP server of the live viewer: bound to localhost, protected by a token in every URL, closed to other origins.

Paths below ``/TOKEN/``: the page, its script and style; ``files``; ``state?file=N``; ``picture?file=N`` (the packet, or
with ``&has=V`` the changes to the version V, which is the ETag of an earlier answer);
``events`` (server-sent); POST ``set`` and ``save`` with JSON. Other paths and wrong tokens return 404, a foreign Host
or Origin returns 403.
"""

from __future__ import annotations

import hmac
import json
import queue
import secrets
import threading
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from scenelang.backends.viewer import packet
from scenelang.grammar.diagnostics import SceneError
from scenelang.viewer.workspace import FileWatch, Workspace, state_data

HOST = "127.0.0.1"
MAX_BODY_SIZE = 64 * 1024  # of a request, in bytes
_HEARTBEAT_S = 10.0  # seconds between events that keep proxies from closing the connection
_TIMEOUT_S = 30.0  # seconds of a silent connection
_MAX_LISTENERS = 32  # open pages that receive events, each of which occupies a thread
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class ViewServer(ThreadingHTTPServer):
    """HTTP server of a workspace. ``address`` is the URL to open. Raises SceneError("file") if the port is in use."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, workspace: Workspace, port: int = 0) -> None:
        """Bind the port and start watching the files; raises SceneError("file") if the port is in use."""
        self.workspace = workspace
        self.token = secrets.token_urlsafe(24)
        self._events: list[queue.SimpleQueue[int | None]] = []
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

    def subscribe(self) -> queue.SimpleQueue[int | None] | None:
        """Subscribe to changes: returns a queue of file numbers, or None if there are too many subscribers."""
        with self._events_lock:
            if len(self._events) >= _MAX_LISTENERS:
                return None
            self._events.append(queue.SimpleQueue())
            return self._events[-1]

    def unsubscribe(self, events: queue.SimpleQueue[int | None]) -> None:
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
        super().server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore disconnected browsers."""

    def _announce(self, file: int) -> None:
        """Tell all subscribers that a file has changed."""
        with self._events_lock:
            for events in self._events:
                events.put(file)


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
            self._send_json({"message": error.message}, HTTPStatus.CONFLICT)
        except (BrokenPipeError, ConnectionError, TimeoutError):
            self.close_connection = True

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
        if name == "":
            self._send(packet.served_page(), "text/html; charset=utf-8")
        elif name in packet.STATIC:
            self._send(packet.static(name), packet.STATIC[name])
        elif name == "files":
            self._send_json({"files": list(self.server.workspace.files)})
        elif name == "state":
            self._send_state(self._file(query.get("file")))
        elif name == "picture":
            self._send_picture(self._file(query.get("file")), query.get("has"))
        elif name == "events":
            self._send_events()
        else:
            raise _Refused(HTTPStatus.NOT_FOUND, "not found")

    def _send_state(self, file: int) -> None:
        """Send the state of a file."""
        workspace = self.server.workspace
        self._send_json(state_data(workspace.files[file], workspace.state(file)))

    def _send_picture(self, file: int, has: str | None) -> None:
        """Send the packet of a file, or its changes to the version ``has`` if that is shorter."""
        state = self.server.workspace.state(file)
        body = state.packet
        if body is None:
            raise _Refused(HTTPStatus.NOT_FOUND, "not rendered yet")
        if state.last is not None and has == str(state.last[0]):
            body = min(packet.packet_changes(state.last[1], body), body, key=len)
        self._send(body, "application/octet-stream", tag=f'"{state.picture}"')

    def _send_events(self) -> None:
        """Send events until the page disconnects or the server closes."""
        events = self.server.subscribe()
        if events is None:
            raise _Refused(HTTPStatus.SERVICE_UNAVAILABLE, "too many open pages")
        self.close_connection = True
        try:
            self._headers(HTTPStatus.OK, "text/event-stream", None)
            self.wfile.write(b"retry: 1000\n\n")
            while True:
                try:
                    file = events.get(timeout=_HEARTBEAT_S)
                except queue.Empty:
                    self.wfile.write(b": still here\n\n")
                    continue
                if file is None:
                    return
                self.wfile.write(f"event: change\ndata: {json.dumps({'file': file})}\n\n".encode())
        finally:
            self.server.unsubscribe(events)

    # --- POST ------------------------------------------------------------------------------------------------------

    def _post(self, name: str, query: dict[str, str]) -> None:
        """Set or save the value of a param."""
        if name not in ("set", "save"):
            raise _Refused(HTTPStatus.NOT_FOUND, "not found")
        data = self._body()
        file, param = self._file(data.get("file")), data.get("name")
        if not isinstance(param, str):
            raise _Refused(HTTPStatus.BAD_REQUEST, "missing name of a param")
        self.server.workspace.state(file)
        if name == "set":
            self.server.workspace.try_value(file, param, data.get("value"))
        else:
            self.server.workspace.save(file, param)
        self._send_state(file)

    def _body(self) -> dict[str, Any]:
        """Read the JSON object of the request body; raises _Refused."""
        if self.headers.get_content_type() != "application/json":
            raise _Refused(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "send JSON")
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or self.headers.get("Transfer-Encoding") is not None:
            raise _Refused(HTTPStatus.LENGTH_REQUIRED, "missing Content-Length")
        if len(length) > 9 or int(length) > MAX_BODY_SIZE:
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

    def _send(self, body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK, tag: str | None = None) -> None:
        """Send a body."""
        self._headers(status, kind, len(body), tag)
        if self.command != "HEAD":
            self.wfile.write(body)

    def _headers(self, status: HTTPStatus, kind: str, length: int | None, tag: str | None = None) -> None:
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
        self.send_header("Content-Security-Policy", _POLICY)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.end_headers()
