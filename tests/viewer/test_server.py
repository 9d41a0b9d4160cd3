"""The server lets in its own page only."""

from __future__ import annotations

import http.client
import json
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from support import PATIENCE
from viewer.test_packet import changed

from scenelang.cli.main import main
from scenelang.viewer.server import MAX_BODY_SIZE, ViewServer

TEXT = '(param n 2)\n(bind "row" (lambda () (union-loop n (lambda (i) (call "cube")))))\n'


@pytest.fixture
def server(program: Callable[..., Path], serve: Any) -> ViewServer:
    started: ViewServer = serve(program(TEXT))
    return started


def ask(
    server: ViewServer, path: str, method: str = "GET", body: bytes | None = None, **headers: str
) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of a request; ``path`` beginning with / is absolute, else below the token."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE)
    target = path if path.startswith("/") else urlsplit(server.address).path + path
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.putrequest(method, target, skip_host="Host" in named)
    if body is not None and "Content-Length" not in named:
        named["Content-Length"] = str(len(body))
    for name, value in named.items():
        connection.putheader(name, value)
    connection.endheaders(body)
    response = connection.getresponse()
    found = response.status, dict(response.getheaders()), response.read()
    connection.close()
    return found


def post(server: ViewServer, path: str, data: Any, **headers: str) -> tuple[int, Any]:
    given = {"Content_Type": "application/json", **headers}
    status, _, body = ask(server, path, "POST", json.dumps(data).encode(), **given)
    return status, json.loads(body)


def test_it_serves_the_page_and_the_scene(server: ViewServer) -> None:
    status, headers, body = ask(server, "")
    assert status == 200
    assert b"viewer.js" in body
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert ask(server, "viewer.js")[1]["Content-Type"].startswith("text/javascript")
    state = json.loads(ask(server, "state?file=0")[2])
    assert state["ok"]
    assert state["params"][0]["value"] == 2
    assert ask(server, "picture?file=0")[2][:4] == b"SCNV"


def test_it_sends_the_changes_to_the_picture_that_a_page_has(server: ViewServer) -> None:
    _, headers, whole = ask(server, "picture?file=0")
    name = json.loads(ask(server, "state?file=0")[2])["params"][0]["name"]
    post(server, "set", {"file": 0, "name": name, "value": 3})
    version = json.loads(headers["ETag"])
    _, others, changes = ask(server, f"picture?file=0&has={version}")
    _, same, other = ask(server, "picture?file=0&has=17")
    assert changed(whole, changes) == other
    assert others["ETag"] == same["ETag"] != headers["ETag"]


def test_it_listens_on_this_machine_only(server: ViewServer) -> None:
    assert server.server_address[0] == "127.0.0.1"


def test_without_the_token_there_is_nothing(server: ViewServer) -> None:
    assert len(server.token) >= 32
    for path in (
        "/",
        "/viewer.js",
        "/state?file=0",
        f"/{server.token[:-1]}/",
        f"/{server.token}x/state?file=0",
        "/%C3%A9/",
    ):
        status, _, body = ask(server, path)
        assert status == 404
        assert server.token.encode() not in body


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1", "", "0.0.0.0"])
def test_another_host_is_refused(server: ViewServer, host: str) -> None:
    assert ask(server, "state?file=0", Host=host)[0] == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1:1", "file://"]
)
def test_another_origin_is_refused(server: ViewServer, origin: str) -> None:
    assert ask(server, "state?file=0", Origin=origin)[0] == 403
    assert post(server, "set", {"file": 0, "name": "n", "value": 3}, Origin=origin)[0] == 403
    assert ask(server, "state?file=0", Sec_Fetch_Site="cross-site")[0] == 403
    assert ask(server, "", Sec_Fetch_Site="cross-site", Sec_Fetch_Dest="iframe")[0] == 403


def test_its_own_origin_is_let_in(server: ViewServer) -> None:
    for host in server.hosts:
        assert ask(server, "state?file=0", Host=host, Origin=f"http://{host}")[0] == 200
    assert ask(server, "", Sec_Fetch_Site="cross-site", Sec_Fetch_Dest="document")[0] == 200, "a link may be clicked"


@pytest.mark.parametrize(
    "path",
    [
        "../../etc/passwd",
        "%2e%2e/%2e%2e/etc/passwd",
        "a.scene",
        "page.html",
        "viewer.js/../page.html",
        "static/viewer.js",
    ],
)
def test_nothing_else_can_be_read(server: ViewServer, path: str) -> None:
    assert ask(server, path)[0] == 404


@pytest.mark.parametrize("number", ["1", "-1", "x", "", "00000000", "1e3", "²"])
def test_other_files_are_none(server: ViewServer, number: str) -> None:
    assert ask(server, f"state?file={number.encode().hex() if number == '²' else number}")[0] == 404


def test_bodies_are_bounded_and_json(server: ViewServer) -> None:
    assert ask(server, "set", "POST", b"x" * (MAX_BODY_SIZE + 1), Content_Type="application/json")[0] == 413
    assert ask(server, "set", "POST", b"", Content_Type="application/json", Content_Length="99999999999999")[0] == 413
    assert ask(server, "set", "POST", b"{}", Content_Type="text/plain")[0] == 415
    for body in (b"{", b"[]", b"3", b"[" * 60_000, b"\xff"):
        assert ask(server, "set", "POST", body, Content_Type="application/json")[0] == 400
    assert ask(server, "set", "POST", None, Content_Type="application/json")[0] == 411
    assert post(server, "nothing", {})[0] == 404
    assert post(server, "set", {"file": 0, "name": 3, "value": 1})[0] == 400
    assert post(server, "set", {"file": True, "name": "n", "value": 1})[0] == 404


@pytest.mark.parametrize("method", ["PUT", "DELETE", "OPTIONS", "HEAD"])
def test_other_methods_do_nothing(server: ViewServer, method: str) -> None:
    assert ask(server, "state?file=0", method)[0] >= 400


def test_values_are_set_and_saved(server: ViewServer) -> None:
    status, state = post(server, "set", {"file": 0, "name": "n", "value": 4})
    assert status == 200
    assert state["params"][0] | {"value": 4, "changed": True} == state["params"][0]
    status, answer = post(server, "set", {"file": 0, "name": "n", "value": '4) (define x "'})
    assert status == 409
    assert "invalid value" in answer["message"]
    status, state = post(server, "save", {"file": 0, "name": "n"})
    assert status == 200
    assert Path(server.workspace.files[0]).read_text() == TEXT.replace("n 2", "n 4")
    assert post(server, "save", {"file": 0, "name": "n"})[0] == 409


def test_changes_are_told_and_listeners_are_bounded(server: ViewServer) -> None:
    ask(server, "state?file=0")
    target = urlsplit(server.address).path + "events"
    head = f"GET {target} HTTP/1.1\r\nHost: {server.hosts[0]}\r\n\r\n".encode()
    listeners = []
    for _ in range(32):
        listener = socket.create_connection(("127.0.0.1", server.server_port), 20)
        listener.sendall(head)
        assert b"200" in listener.recv(1000)
        listeners.append(listener)
    assert ask(server, "events")[0] == 503
    Path(server.workspace.files[0]).write_text(TEXT + ";")
    said = b""
    while b"event: change" not in said:
        said += listeners[0].recv(1000)
    assert b'{"file": 0}' in said or listeners[0].recv(100)
    for listener in listeners:
        listener.close()


def test_the_command_says_what_is_wrong(program: Callable[..., Path], serve: Any, tmp_path: Path, capsys: Any) -> None:
    path = str(program(TEXT))
    taken = serve(program(TEXT)).server_port
    assert main(["view", path, "--no-browser", "--port", str(taken)]) == 1
    assert "cannot serve on port" in capsys.readouterr().err
    assert main(["view", "-"]) == 2
    assert main(["view", path, "--html", str(tmp_path / "a.png")]) == 2
    assert main(["view", path, "--html", str(tmp_path / "no" / "a.html")]) == 1
    assert main(["view", str(program("(", "b.scene")), "--html", str(tmp_path / "a.html")]) == 1
    assert not (tmp_path / "a.html").exists()
    with pytest.raises(SystemExit):
        main(["view", path, "--port", "70000"])
