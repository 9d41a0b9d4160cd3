"""The studio: the editor, its language server, changes of objects in the picture, drafts, and what the server refuses."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer.conftest import WAIT, open_session

from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError, UsageError
from scenelang.viewer.program_tools import TOOLS, tools
from scenelang.viewer.server import ViewServer
from scenelang.viewer.workspace import STARTER, Workspace, evaluator, programs_of

PAIR = """(param size 1.0 :min 0.5 :max 2.0)
(bind "pair" (lambda ()
  (union
    (call "cube" :scale [size 1 1] :color (color "tan"))
    (transform (call "sphere" :radius .5 :color (color "tomato")) (translate [2 0 0])))))
"""


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Callable[..., ViewServer]]:
    """Starts studios of files; they end with the test."""
    servers: list[ViewServer] = []

    def start(*files: Path) -> ViewServer:
        workspace = Workspace([str(file) for file in files], evaluator(open_session, 100_000), tools(open_session))
        server = ViewServer(workspace, edits=True)
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        servers.append(server)
        return server

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


def _ask(server: ViewServer, method: str, path: str, data: Any = None, **headers: str) -> tuple[int, Any]:
    """Send a request with the server's token, and return the status and the JSON answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    body = None if data is None else data if isinstance(data, bytes) else json.dumps(data).encode()
    given = {"Content-Type": "application/json", **{name.replace("_", "-"): value for name, value in headers.items()}}
    connection.request(
        method,
        path if path.startswith("//") else f"/{server.token}/{path}",
        body,
        given if body is not None else headers,
    )
    response = connection.getresponse()
    content = response.read()
    connection.close()
    return response.status, json.loads(content) if content[:1] == b"{" else content


# --- the server


def test_text_is_evaluated_in_place_of_the_file(studio: Any, program: Any) -> None:
    path = program(PAIR)
    server = studio(path)
    assert _ask(server, "GET", "text?file=0") == (200, {"name": str(path), "text": PAIR})
    status, state = _ask(server, "POST", "edit", {"file": 0, "text": PAIR.replace('"sphere"', '"ball"')})
    assert status == 200
    assert path.read_text() == PAIR
    status, state = _ask(server, "POST", "edit", {"file": 0, "text": PAIR.replace("[2 0 0]", "[2 0")})
    assert (status, state["ok"]) == (200, False)
    assert state["picture"] is not None  # the last good one
    assert _ask(server, "POST", "edit", {"file": 0, "text": None})[1]["ok"]


def test_store_keeps_what_changed_on_disk(studio: Any, program: Any) -> None:
    path = program(PAIR)
    server = studio(path)
    new = PAIR.replace("[2 0 0]", "[3 0 0]")
    assert _ask(server, "POST", "store", {"file": 0, "text": new, "before": PAIR})[0] == 200
    assert path.read_text() == new
    path.write_text("; another program\n" + new)
    status, answer = _ask(server, "POST", "store", {"file": 0, "text": PAIR, "before": new})
    assert status == 409
    assert "modified" in answer["message"]
    assert path.read_text().startswith("; another program")


def test_value_of_a_param_is_an_edit(studio: Any, program: Any) -> None:
    server = studio(program(PAIR))
    status, edit = _ask(server, "POST", "literal", {"file": 0, "name": "size", "value": 1.5, "text": PAIR})
    assert (status, PAIR[: edit["start"]] + edit["text"] + PAIR[edit["end"] :]) == (
        200,
        PAIR.replace("size 1.0", "size 1.5"),
    )
    assert _ask(server, "POST", "literal", {"file": 0, "name": "other", "value": 1, "text": PAIR})[0] == 409


def test_param_of_another_text_is_refused(studio: Any, program: Any) -> None:
    """Places are those of the text that was evaluated last; in another one they would be wrong."""
    server = studio(program(PAIR))
    _ask(server, "POST", "edit", {"file": 0, "text": "; my note (\n" + PAIR})
    assert _ask(server, "POST", "literal", {"file": 0, "name": "size", "value": 1.5, "text": PAIR})[0] == 409
    for value in (10**400, [1], {"a": 1}):
        status, _ = _ask(
            server, "POST", "literal", {"file": 0, "name": "size", "value": value, "text": "; my note (\n" + PAIR}
        )
        assert status in (400, 409)
    assert _ask(server, "POST", "change", {"file": 0, "text": PAIR, "change": {"path": [1], "move": [1, 2, 3]}})[0] in (
        400,
        409,
    )


def test_windows_line_ends_are_kept(studio: Any, tmp_path: Path) -> None:
    path = tmp_path / "dos.scene"
    path.write_bytes(PAIR.replace("\n", "\r\n").encode())
    server = studio(path)
    assert _ask(server, "GET", "text?file=0")[1]["text"] == PAIR
    _ask(server, "POST", "edit", {"file": 0, "text": PAIR})
    edit = _ask(server, "POST", "literal", {"file": 0, "name": "size", "value": 1.5, "text": PAIR})[1]
    assert PAIR[: edit["start"]] + edit["text"] + PAIR[edit["end"] :] == PAIR.replace("size 1.0", "size 1.5")
    new = PAIR.replace("[2 0 0]", "[3 0 0]")
    assert _ask(server, "POST", "store", {"file": 0, "text": new, "before": PAIR})[0] == 200
    assert path.read_bytes() == new.replace("\n", "\r\n").encode()


def test_deleted_file_is_written_again(studio: Any, program: Any) -> None:
    path = program(PAIR)
    server = studio(path)
    path.unlink()
    assert _ask(server, "GET", "text?file=0")[1]["text"] == ""
    assert _ask(server, "POST", "store", {"file": 0, "text": PAIR, "before": PAIR})[0] == 200
    assert path.read_text() == PAIR


def test_links_do_not_lead_out_of_the_folder(studio: Any, tmp_path: Path) -> None:
    inside, outside = tmp_path / "in", tmp_path / "out"
    inside.mkdir()
    outside.mkdir()
    (outside / "secret.scene").write_text("secret")
    (inside / "a.scene").write_text(PAIR)
    (inside / "link.scene").symlink_to(outside / "secret.scene")
    (inside / "dangling.scene").symlink_to(outside / "new.scene")
    (inside / "folder.scene").mkdir()
    assert programs_of(inside)[0] == [str(inside / "a.scene")]
    server = studio(inside / "a.scene")
    assert _ask(server, "POST", "create", {"name": "dangling"})[0] == 409
    assert not (outside / "new.scene").exists()


def test_many_pages_do_not_lock_out_others(studio: Any, program: Any) -> None:
    server = studio(program(PAIR))
    hello = '{"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {"capabilities": {}, "processId": null, "rootUri": null}}'
    for number in range(40):
        assert _ask(server, "POST", "lsp", {"client": f"page {number}", "message": hello})[0] == 200


def test_object_is_changed_in_the_program(studio: Any, program: Any) -> None:
    server = studio(program(PAIR))
    ask = lambda change: _ask(server, "POST", "change", {"file": 0, "text": PAIR, "change": change})
    status, answer = ask({"path": "pair/sphere", "move": [0, 1, 0]})
    assert status == 200
    assert answer["text"] == PAIR.replace("[2 0 0]", "[2 1 0]")
    assert '"skyblue"' in ask({"path": "pair/cube", "recolor": '(color "skyblue")'})[1]["text"]
    assert ask({"path": "pair/horse", "move": [0, 1, 0]})[0] == 409
    for wrong in (
        {"path": "pair/sphere"},
        {"path": "pair/sphere", "explode": True},
        {"move": [0, 1, 0]},
        {"path": "a", "move": "x"},
    ):
        status, answer = ask(wrong)
        assert status == 409, (wrong, answer)
    assert ask([1])[0] == 400


def test_new_program(studio: Any, program: Any, tmp_path: Path) -> None:
    """A new program is beside the first one, and nowhere else."""
    server = studio(program(PAIR))
    assert _ask(server, "POST", "create", {"name": "room"}) == (200, {"file": 1})
    assert (tmp_path / "room.scene").read_text() == STARTER
    assert _ask(server, "GET", "text?file=1")[1]["text"] == STARTER
    assert _ask(server, "POST", "edit", {"file": 1, "text": STARTER})[1]["ok"]
    before = sorted(tmp_path.parent.rglob("*.scene"))
    for name in ("room", "../room", "/tmp/room", "a/b", "", "room.py", "a" * 300, "..", ".scene", "a\nb"):
        assert _ask(server, "POST", "create", {"name": name})[0] == 409, name
    assert _ask(server, "POST", "create", {"name": 5})[0] == 400
    assert sorted(tmp_path.parent.rglob("*.scene")) == before


def test_findings_have_edits_that_were_tried(studio: Any, program: Any) -> None:
    """A ball above the ground is found, and the edit that is offered puts it there."""
    text = '(bind "a" (lambda () (union (call "cube" :scale [4 .2 4]) (transform (call "sphere" :radius .5) (translate [0 1.5 0])))))\n'
    server = studio(program(text))
    status, answer = _ask(server, "POST", "examine", {"file": 0, "text": text})
    assert status == 200
    findings = [each for each in answer["diagnostics"] if each["code"].startswith("W6")]
    assert findings, answer
    edits = next(each["edits"] for each in findings if "edits" in each)
    fixed = text
    for edit in sorted(edits, key=lambda edit: -edit["start"]):
        fixed = fixed[: edit["start"]] + edit["text"] + fixed[edit["end"] :]
    again = _ask(server, "POST", "examine", {"file": 0, "text": fixed})[1]["diagnostics"]
    assert len([each for each in again if each["code"].startswith("W6")]) < len(findings)
    assert _ask(server, "POST", "examine", {"file": 0, "text": "(call"})[1]["diagnostics"][0]["severity"] == "error"


HOSTILE: list[tuple[str, str, Any, dict[str, str], int]] = [
    ("POST", "//WRONG/edit", {"file": 0, "text": ""}, {}, 404),
    ("POST", "///edit", {"file": 0, "text": ""}, {}, 404),
    ("POST", "edit", {"file": 0, "text": ""}, {"Origin": "http://evil.example"}, 403),
    ("POST", "store", {"file": 0, "text": "", "before": PAIR}, {"Origin": "null"}, 403),
    ("POST", "store", {"file": 0, "text": "", "before": PAIR}, {"Host": "evil.example"}, 403),
    ("POST", "lsp", {"client": "a", "message": "{}"}, {"Sec_Fetch_Site": "cross-site"}, 403),
    ("POST", "edit", b"file=0&text=", {"Content_Type": "application/x-www-form-urlencoded"}, 415),
    ("POST", "edit", b'{"file": 0, "text": ""}', {"Content_Type": "text/plain"}, 415),
    ("POST", "edit", {"file": 7, "text": ""}, {}, 404),
    ("POST", "edit", {"file": "../../etc/passwd", "text": ""}, {}, 404),
    ("POST", "edit", {"file": -1, "text": ""}, {}, 404),
    ("POST", "edit", {"file": 0, "text": ["a"]}, {}, 400),
    ("POST", "store", {"file": 0, "text": ""}, {}, 400),
    ("POST", "store", {"file": 0, "text": "", "before": ""}, {}, 409),
    ("POST", "edit", b"[" * 100_000, {}, 400),
    ("POST", "edit", b"{", {}, 400),
    ("POST", "lsp", {"message": "{}"}, {}, 400),
    ("POST", "lsp", {"client": "a" * 1000, "message": "{}"}, {}, 400),
    ("POST", "lsp", {"client": "a", "message": 5}, {}, 400),
    ("GET", "text?file=../../../etc/passwd", None, {}, 404),
    (
        "POST",
        "evaluate",
        {"file": 0, "text": "", "change": {"expression": "1"}},
        {"Origin": "http://evil.example"},
        403,
    ),
    ("POST", "evaluate", {"file": 0, "text": "", "change": {}}, {}, 409),
    ("POST", "evaluate", {"file": 0, "change": {"expression": "1"}}, {}, 400),
    ("POST", "gap", {"file": 0, "text": PAIR, "change": {"from": [], "to": {}}}, {}, 409),
    ("POST", "still", {"file": 0, "text": PAIR, "change": {"width": 1e30}}, {}, 409),
    ("POST", "still", {"file": 0, "text": PAIR, "change": 5}, {}, 400),
    ("POST", "stop", {"what": 5}, {}, 400),
    ("GET", "still", None, {}, 404),
    ("GET", "progress", None, {"Origin": "http://evil.example"}, 403),
    ("GET", "edit", None, {}, 404),
    ("POST", "quit", {}, {}, 404),
    ("POST", "text", {"file": 0}, {}, 404),
]


@pytest.mark.parametrize("case", HOSTILE, ids=lambda case: f"{case[1][:12]}-{case[4]}")
def test_attack_is_refused(studio: Any, program: Any, case: Any) -> None:
    method, path, data, headers, expected = case
    file = program(PAIR)
    status, _ = _ask(studio(file), method, path, data, **headers)
    assert status == expected
    assert file.read_text() == PAIR


def test_language_server_survives_nonsense(studio: Any, program: Any) -> None:
    server = studio(program(PAIR))
    for message in (
        "",
        "null",
        "[]",
        "{}",
        '{"jsonrpc": "2.0", "id": 1, "method": "shutdown?"}',
        "[" * 5000,
        '{"id": {}, "method": 3}',
    ):
        assert _ask(server, "POST", "lsp", {"client": "a", "message": message})[0] == 200
    assert _ask(server, "POST", "edit", {"file": 0, "text": PAIR})[1]["ok"]


def test_viewer_accepts_no_edits(serve: Any, program: Any) -> None:
    """`scenelang view` only shows: what the studio accepts is not there."""
    path = program(PAIR)
    server = serve(path)
    for name in ("edit", "store", "literal", *TOOLS, "create", "stop", "lsp"):
        assert _ask(server, "POST", name, {"file": 0, "text": "", "before": PAIR})[0] == 404
    assert _ask(server, "GET", "text?file=0")[0] == 404
    assert _ask(server, "GET", "progress")[0] == 404
    assert path.read_text() == PAIR


# --- the command


def test_programs_of_a_path(tmp_path: Path) -> None:
    files, created = programs_of(tmp_path)
    assert (files, created) == ([str(tmp_path / "main.scene")], [tmp_path / "main.scene"])
    assert (tmp_path / "main.scene").read_text() == STARTER
    (tmp_path / "b.scene").write_text(PAIR)
    assert programs_of(tmp_path) == ([str(tmp_path / "b.scene"), str(tmp_path / "main.scene")], [])
    assert programs_of(tmp_path / "b.scene") == ([str(tmp_path / "b.scene")], [])
    with pytest.raises(UsageError):
        programs_of(tmp_path / "a.py")
    with pytest.raises(SceneError):
        programs_of(tmp_path / "no" / "a.scene")


def test_command_refuses_other_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["studio", str(tmp_path / "a.py"), "--no-browser"]) == 2
    assert main(["studio", str(tmp_path / "no" / "a.scene"), "--no-browser"]) == 1
    assert "Traceback" not in capsys.readouterr().err


# --- the page


def _open(show: Any, server: ViewServer, size: tuple[int, int] = (1200, 800)) -> Any:
    shown = show(server.address, size)
    return shown.ready()


def _text(shown: Any) -> str:
    return str(shown.page.evaluate("scenelangPage.editor.text"))


def _until(shown: Any, condition: str) -> None:
    """Wait until an expression of JavaScript is true; evaluated from outside, as the page forbids ``eval``."""
    end = time.monotonic() + WAIT / 1000
    while not shown.page.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < end, condition
        shown.page.wait_for_timeout(30)


@pytest.mark.browser
def test_typing_draws_and_reports(studio: Any, program: Any, show: Any) -> None:
    """From an empty program to two objects by typing, with a mistake on the way and a completed name."""
    shown = _open(show, studio(program("; nothing yet\n")))
    page = shown.page
    page.click(".cm-content")
    page.keyboard.press("Control+End")
    page.keyboard.insert_text('(bind "room" (lambda () (union (call "cube") (call "spher")')
    _until(shown, "document.getElementById('verdict').textContent.includes('error')")
    page.wait_for_selector(".cm-lintRange-error", state="attached")
    page.keyboard.insert_text(")))")
    _until(shown, "scenelangPage.packet && scenelangPage.packet.primitives === 2")
    page.keyboard.press("Control+End")
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
    page.keyboard.press("Control+Space")
    page.wait_for_selector(".cm-tooltip-autocomplete >> text=sphere")
    page.wait_for_timeout(200)  # a list that has just opened does not take Enter
    page.keyboard.press("Enter")
    _until(shown, "scenelangPage.editor.text.includes('\"sphere\"')")
    _until(shown, "document.getElementById('verdict').textContent === ''")
    assert shown.settled().drawn() >= 0


def test_change_in_the_picture_and_undo(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    page.evaluate("scenelangPage.select([1])")
    assert shown.text("#breadcrumb").split() == ["pair", "›", "sphere"] or "sphere" in shown.text("#breadcrumb")
    page.click("[data-mode=move]")
    page.evaluate("scenelangPage.changeSelection({ move: [0, 1, 0] })")
    _until(shown, "scenelangPage.editor.text.includes('[2 1 0]')")
    assert _text(shown) == PAIR.replace("[2 0 0]", "[2 1 0]")
    page.click(".cm-content")
    page.keyboard.press("Control+z")
    assert _text(shown) == PAIR
    page.evaluate("scenelangPage.select(null)")
    assert page.locator("#tools").is_hidden()


@pytest.mark.browser
def test_gizmo_is_dragged(studio: Any, program: Any, show: Any) -> None:
    """Dragging the upward arrow moves the object up, by what the message says, and only its literal changes."""
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    page.evaluate("scenelangPage.select([1])")
    page.click("[data-mode=move]")
    shown.settled()
    at = page.evaluate(
        """() => {
          const { gizmo, viewpoint } = scenelangPage;
          const box = document.getElementById('canvas').getBoundingClientRect();
          const place = (dy) => { const v = gizmo.anchor.position.clone(); v.y += dy; v.project(viewpoint.camera); return [box.left + (v.x + 1) / 2 * box.width, box.top + (1 - v.y) / 2 * box.height]; };
          return [place(0.28), place(0.55)];
        }"""
    )
    (x0, y0), (x1, y1) = at
    page.mouse.move(x0, y0)
    page.wait_for_timeout(200)
    page.mouse.down()
    page.mouse.move((x0 + x1) / 2, (y0 + y1) / 2, steps=4)
    page.mouse.move(x1, y1, steps=4)
    page.mouse.up()
    _until(shown, f"scenelangPage.editor.text !== {json.dumps(PAIR)}")
    before, _, after = PAIR.partition("[2 0 0]")
    text = _text(shown)
    assert text.startswith(before)
    assert text.endswith(after)
    moved = [float(number) for number in text[len(before) : len(text) - len(after)].strip("[]").split()]
    assert moved[0] == 2.0
    assert moved[1] > 0.1
    assert moved[2] == 0.0


@pytest.mark.browser
def test_color_is_picked_in_the_text(studio: Any, program: Any, show: Any) -> None:
    """A swatch shows each color of the text, and writes another one in the same notation."""
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    page.wait_for_selector(".swatch >> nth=1")
    assert page.locator(".swatch").count() == 2
    page.locator(".swatch").first.evaluate(
        "(input) => { input.value = '#336699'; input.dispatchEvent(new Event('change')); }"
    )
    _until(shown, "scenelangPage.editor.text.includes('#336699')")
    assert _text(shown) == PAIR.replace('"tan"', '"#336699"')


@pytest.mark.browser
def test_tree_beside_the_editor(studio: Any, program: Any, show: Any) -> None:
    """The tree lies over the details when it is asked for."""
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    assert page.locator("#left").is_hidden()
    page.click("#toggle-left")
    page.locator("#tree .row", has_text="pair").click()
    assert page.locator("#left").bounding_box()["width"] > 200
    page.click("#toggle-left")
    assert page.locator("#left").is_hidden()


@pytest.mark.browser
def test_slider_writes_into_the_text(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program(PAIR)))
    shown.page.fill("#param-size", "1.75")
    _until(shown, "scenelangPage.editor.text.includes('size 1.75')")
    assert _text(shown) == PAIR.replace("size 1.0", "size 1.75")


@pytest.mark.browser
def test_number_is_dragged_in_the_text(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    box = page.evaluate(
        "() => { const v = scenelangPage.editor.view; const at = v.coordsAtPos(scenelangPage.editor.text.indexOf('[2 0 0]') + 1); return [at.left + 2, (at.top + at.bottom) / 2]; }"
    )
    page.keyboard.down("Alt")
    page.mouse.move(*box)
    page.mouse.down()
    page.mouse.move(box[0] + 20, box[1], steps=3)
    page.mouse.up()
    page.keyboard.up("Alt")
    assert _text(shown) == PAIR.replace("[2 0 0]", "[7 0 0]")


@pytest.mark.browser
def test_reload_keeps_the_draft(studio: Any, program: Any, show: Any) -> None:
    path = program(PAIR)
    shown = _open(show, studio(path))
    page = shown.page
    page.click(".cm-content")
    page.keyboard.press("Control+Home")
    page.keyboard.insert_text("; a draft\n")
    page.wait_for_timeout(700)
    page.reload()
    shown.ready()
    assert _text(shown) == "; a draft\n" + PAIR
    assert path.read_text() == PAIR
    page.click(".cm-content")
    page.keyboard.press("Control+z")  # undo survives, too
    assert _text(shown) == PAIR


@pytest.mark.browser
def test_save_and_change_on_disk(studio: Any, program: Any, show: Any) -> None:
    path = program(PAIR)
    shown = _open(show, studio(path))
    page = shown.page
    page.click(".cm-content")
    page.keyboard.press("Control+Home")
    page.keyboard.insert_text("; mine\n")
    page.keyboard.press("Control+s")
    _until(shown, "!document.body.classList.contains('dirty')")
    assert path.read_text() == "; mine\n" + PAIR
    program("; theirs\n" + PAIR)  # an unchanged text follows the file
    _until(shown, "scenelangPage.editor.text.startsWith('; theirs')")
    page.keyboard.insert_text("; again mine\n")
    program("; again theirs\n" + PAIR)
    page.wait_for_selector("#conflict:not([hidden])")
    assert "again theirs" in shown.text("#conflict")
    assert "again mine" in _text(shown)
    page.click("text=Take the file")
    assert _text(shown) == "; again theirs\n" + PAIR


@pytest.mark.browser
def test_second_tab_loses_nothing(studio: Any, program: Any, show: Any) -> None:
    path = program(PAIR)
    server = studio(path)
    first, second = _open(show, server), _open(show, server)
    for shown, text in ((first, "; first\n"), (second, "; second\n")):
        shown.page.click(".cm-content")
        shown.page.keyboard.press("Control+Home")
        shown.page.keyboard.insert_text(text)
    first.page.keyboard.press("Control+s")
    _until(first, "!document.body.classList.contains('dirty')")
    assert path.read_text() == "; first\n" + PAIR
    second.page.wait_for_selector("#conflict:not([hidden])")
    second.page.keyboard.press("Control+s")
    second.page.wait_for_timeout(300)
    assert all("409" in complaint for complaint in second.complaints)  # the refusal, which the console notes
    second.complaints.clear()
    assert _text(second) == "; second\n" + PAIR
    assert path.read_text() == "; first\n" + PAIR


@pytest.mark.browser
def test_question_about_the_disk_survives_reloads(studio: Any, program: Any, show: Any) -> None:
    """While it is open, saving is refused, however often the page is loaded again."""
    path = program(PAIR)
    shown = _open(show, studio(path))
    page = shown.page
    page.click(".cm-content")
    page.keyboard.press("Control+Home")
    page.keyboard.insert_text("; mine\n")
    page.wait_for_timeout(700)
    program("; theirs\n" + PAIR)
    page.wait_for_selector("#conflict:not([hidden])")
    for _ in range(2):
        page.reload()
        shown.ready()
        assert page.locator("#conflict").is_visible()
        page.click(".cm-content")
        page.keyboard.press("Control+s")
        page.wait_for_timeout(300)
        assert path.read_text() == "; theirs\n" + PAIR
    shown.complaints.clear()  # the refusals, which the console notes


@pytest.mark.browser
def test_page_that_only_looks_keeps_the_draft_of_another(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    other = shown.context.new_page()
    other.goto(page.url)
    other.wait_for_selector("body[data-version]", state="attached")
    page.click(".cm-content")
    page.keyboard.press("Control+Home")
    page.keyboard.insert_text("; mine\n")
    page.wait_for_timeout(700)
    other.close(run_before_unload=True)
    page.wait_for_timeout(300)
    page.evaluate("scenelangPage.hasTyped = false")  # as if the page were killed
    page.reload()
    shown.ready()
    assert _text(shown).startswith("; mine")


@pytest.mark.browser
def test_drafts_of_two_windows_are_both_kept(studio: Any, program: Any, show: Any) -> None:
    """The window that wrote last has its draft shown, and that of the other one is offered."""
    shown = _open(show, studio(program(PAIR)))
    page, other = shown.page, shown.context.new_page()
    other.goto(page.url)
    other.wait_for_selector("body[data-version]", state="attached")
    for each, text in ((page, "; mine\n"), (other, "; theirs\n"), (page, "; again\n"), (other, "; last\n")):
        each.click(".cm-content")
        each.keyboard.press("Control+Home")
        each.keyboard.insert_text(text)
        each.wait_for_timeout(700)
    other.close(run_before_unload=True)
    page.evaluate("scenelangPage.hasTyped = false")  # as if the page were killed
    page.reload()
    shown.ready()
    assert _text(shown) == "; last\n; theirs\n" + PAIR
    page.wait_for_selector("#conflict:not([hidden])")
    page.click("text=Take that text")
    assert _text(shown) == "; again\n; mine\n" + PAIR
    page.reload()
    shown.ready()
    assert _text(shown) == "; again\n; mine\n" + PAIR
    assert page.locator("#conflict").is_hidden()


@pytest.mark.browser
def test_question_about_the_disk_is_answered_once(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    page.click(".cm-content")
    page.keyboard.press("Control+Home")
    page.keyboard.insert_text("; mine\n")
    page.wait_for_timeout(700)
    program(PAIR + "; theirs\n")
    page.wait_for_selector("#conflict:not([hidden])")
    assert page.locator("#conflict .removed").count() == page.locator("#conflict .added").count() == 1
    page.click("text=Keep this text")
    page.reload()
    shown.ready()
    assert page.locator("#conflict").is_hidden()
    assert _text(shown) == "; mine\n" + PAIR


@pytest.mark.browser
def test_words_like_markup_and_paths_can_be_changed(studio: Any, program: Any, show: Any) -> None:
    text = (
        '(bind "<b>a/b</b>" (lambda () (union (call "cube" :color (color "tomato"))\n'
        '  (transform (call "sphere" :color (color "teal")) (translate [2 0 0])))))\n'
    )
    shown = _open(show, studio(program(text)))
    shown.page.evaluate("scenelangPage.select([1])")
    assert shown.page.input_value("#recolor") == "#008080"
    shown.page.evaluate("scenelangPage.changeSelection({ move: [0, 1, 0] })")
    _until(shown, "scenelangPage.editor.text.includes('[2 1 0]')")


@pytest.mark.browser
def test_fix_of_a_mistake_is_a_button(studio: Any, program: Any, show: Any) -> None:
    shown = _open(show, studio(program('(bind "a" (lambda () (call "cube" :sacle [1 2 1])))\n')))
    shown.page.click("#diagnostics >> text=Apply this fix")
    _until(shown, "scenelangPage.editor.text.includes(':scale [1 2 1]')")
    _until(shown, "document.getElementById('verdict').textContent === ''")


@pytest.mark.browser
def test_new_program_in_the_page(studio: Any, program: Any, show: Any) -> None:
    """A program that was just created has diagnostics in its text."""
    shown = _open(show, studio(program(PAIR)))
    page = shown.page
    page.click("#create")
    page.fill("#new-name", "room")
    page.click("#naming button[value=create]")
    _until(shown, "scenelangPage.fileName.endsWith('room.scene') && scenelangPage.editor.text.includes('first scene')")
    page.evaluate("scenelangPage.editor.replace('(oops)')")
    page.wait_for_selector(".cm-lintRange-error", state="attached")


@pytest.mark.browser
def test_names_are_text(studio: Any, program: Any, show: Any) -> None:
    """Markup in words, labels and messages stays text."""
    evil = "<img src=x onerror=alert(1)>"
    text = f'(bind "{evil}" (lambda () (union (call "{evil} b") (call "cube"))))\n'
    shown = _open(show, studio(program(text)))
    shown.page.evaluate("scenelangPage.select([0])")
    assert evil in shown.text("#breadcrumb")
    assert shown.page.locator("#breadcrumb img, #tree img, #inspector img, #diagnostics img").count() == 0


@pytest.mark.parametrize("size", [(390, 844), (768, 1024)])
def test_small_screen(studio: Any, program: Any, show: Any, size: tuple[int, int]) -> None:
    """The picture has the whole width; panels are sheets that one button each opens and closes."""
    shown = _open(show, studio(program(PAIR)), size)
    page = shown.page
    assert page.locator("#canvas").bounding_box()["width"] == size[0]
    assert page.locator("#editor").is_visible()
    page.click("#sheets [data-sheet=right]")
    assert page.locator("#param-size").is_visible()
    assert page.locator("#editor").is_hidden()
    page.click("#sheets [data-sheet=right]")
    assert page.locator("#right").is_hidden()
    assert page.locator("#canvas").bounding_box()["height"] > 0.75 * size[1]
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]


@pytest.mark.browser
def test_viewer_on_a_phone(serve: Any, program: Any, show: Any) -> None:
    shown = show(serve(program(PAIR)).address, (390, 844)).ready()
    assert shown.page.locator("#canvas").bounding_box()["width"] == 390
    shown.page.click("#sheets [data-sheet=left]")
    assert shown.page.locator("#tree").is_visible()


@pytest.mark.browser
def test_looks(serve: Any, program: Any, show: Any) -> None:
    """A section removes half of a cube, instances have colors of their own, and x-ray lets the ground through."""
    text = '(bind "pair" (lambda () (union (call "cube" :color (color "red")) (transform (call "cube" :color (color "red")) (translate [2 0 0])))))'
    shown = show(serve(program(text)).address, (900, 600)).ready()
    page, whole = shown.page, shown.drawn()
    page.select_option("#section-axis", "0")
    half = shown.settled().drawn()
    assert 0.3 * whole < half < 0.7 * whole
    page.select_option("#section-axis", "")
    assert shown.settled().drawn() == pytest.approx(whole, rel=0.02)
    page.select_option("#mode", "1")
    picture = shown.settled().picture().reshape(-1, 3).astype(int)
    solid = picture[picture.max(axis=1) - picture.min(axis=1) > 30]
    hues = {tuple(color) for color in np.round(solid / solid.max(axis=1, keepdims=True) * 3).astype(int)}
    assert len(hues) >= 2
    page.select_option("#mode", "4")
    page.evaluate("scenelangPage.select([0])")
    shown.settled()
    assert shown.text("#inspector").count("1 × 1 × 1") == 1
