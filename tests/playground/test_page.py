"""The playground in Chromium, as `make playground` builds it: the interpreter by Pyodide, solids by manifold-3d."""

from __future__ import annotations

import functools
import http.server
import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playground.test_archive import EXAMPLES, ROOT, _decoded
from viewer.conftest import WAIT, Shown
from viewer.conftest import browser as browser
from viewer.conftest import show as show

from scenelang.session.session import Options, Session
from scenelang.viewer.workspace import evaluator

SITE = ROOT / ".playground"
pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not (SITE / "index.html").is_file(), reason="`make playground` has not been run"),
]


class _Quiet(http.server.SimpleHTTPRequestHandler):
    """Handler that logs nothing."""

    def log_message(self, format: str, *arguments: Any) -> None:
        """Log nothing."""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Quiet, directory=str(SITE)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()


@pytest.fixture
def page(show: Any, address: str) -> Shown:
    shown: Shown = show(address, (1200, 800)).ready()
    return shown


def _until(shown: Shown, condition: str, seconds: float = WAIT / 1000) -> None:
    end = time.monotonic() + seconds
    while not shown.page.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < end, condition
        shown.page.wait_for_timeout(50)


def _draw(shown: Shown, text: str) -> dict[str, Any]:
    state: dict[str, Any] = shown.page.evaluate("(text) => scenelangPage.server.edit(0, text)", text)
    return state


def test_examples_draw_as_on_the_desktop(page: Shown) -> None:
    """All example programs, those with solids by manifold-3d, whose meshes have 32-bit coordinates."""
    evaluate = evaluator(lambda path, values: Session(Options(defines=dict(values))), 1_000_000)
    names = page.page.evaluate("scenelangPage.examples.map((example) => example.name)")
    assert len(names) == len(EXAMPLES)
    others = page.page.evaluate("Object.fromEntries(scenelangPage.examples.map((e) => [e.name, e.text]))")
    for name in names:
        drawn = page.page.evaluate(
            """async ([texts, name]) => {
              const { server } = scenelangPage;
              await server.open(texts, [name]);
              const state = await server.state(0);
              const bytes = state.ok ? new Uint8Array(await server.picture(0)) : null;
              let letters = "";
              for (const byte of bytes ?? []) letters += String.fromCharCode(byte);
              return [state, btoa(letters)];
            }""",
            [others, name],
        )
        state, letters = drawn
        assert state["ok"], (name, state["diagnostics"])
        import base64

        header, columns = _decoded(base64.b64decode(letters))
        packet = evaluate(str(ROOT / "examples" / name), {}, None).packet
        assert packet is not None
        wanted, theirs = _decoded(packet)
        assert header["primitives"] == wanted["primitives"], name
        assert columns["rowPose"].shape == theirs["rowPose"].shape, name
        size = max(b - a for a, b in zip(wanted["box"]["low"], wanted["box"]["high"], strict=True))
        for edge in ("low", "high"):
            assert header["box"][edge] == pytest.approx(wanted["box"][edge], abs=1e-6 * size), name


def _volume(packet: bytes) -> float:
    """Return the volume of the only mesh of a packet, in stage units, by the divergence theorem."""
    _, columns = _decoded(packet)
    corners = columns["geometry0Positions"].reshape(-1, 3).astype(float)
    a, b, c = corners[columns["geometry0Indices"].reshape(-1, 3)].transpose(1, 0, 2)
    scale = columns["rowPose"][0]
    return float(np.einsum("ni,ni->n", a, np.cross(b, c)).sum() / 6.0 * scale**3)


def test_volumes_agree_with_the_desktop(page: Shown, tmp_path: Path) -> None:
    """The volume of a solid of three shapes is the desktop's within a millionth; its mesh can be downloaded."""
    text = '(bind "a" (lambda () (difference (call "cube") (call "sphere" :radius 0.6) (call "cylinder" :radius 0.2))))'
    page.page.evaluate("(text) => scenelangPage.server.open({ 'a.scene': text }, ['a.scene'])", text)
    assert page.page.evaluate("scenelangPage.server.state(0)")["ok"]
    drawn = page.page.evaluate("async () => [...new Uint8Array(await scenelangPage.server.picture(0))]")
    program = tmp_path / "a.scene"
    program.write_text(text)
    evaluate = evaluator(lambda path, values: Session(Options(defines=dict(values))), 1_000_000)
    packet = evaluate(str(program), {}, None).packet
    assert packet is not None
    assert _volume(bytes(drawn)) == pytest.approx(_volume(packet), rel=1e-6)
    script = """async () => {
      const bytes = await scenelangPage.server.export(0, "glb");
      return bytes.length;
    }"""
    assert page.page.evaluate(script) > 1000


def test_stop_and_limits(page: Shown) -> None:
    """A program that does not end is stopped by a button or by the step limit, and the next one draws soon."""
    _until(page, "scenelangPage.server.spare")
    page.page.wait_for_timeout(12_000)  # until the spare worker is loaded
    endless = '(define (f n) (f (+ n 1)))\n(bind "a" (lambda () (f 1)))'
    page.page.evaluate("(text) => { scenelangPage.editor.replace(text); }", endless)
    _until(page, "scenelangPage.isEvaluating")
    started = time.monotonic()
    page.page.evaluate("() => { scenelangPage.server.stop(); }")
    _until(page, "!scenelangPage.isEvaluating")
    stopped = time.monotonic() - started
    page.page.evaluate("""() => { scenelangPage.editor.replace('(bind "a" (lambda () (call "cube")))'); }""")
    _until(page, "scenelangPage.packet?.primitives === 1")
    print(f"stopped after {stopped:.2f} s, next image after {time.monotonic() - started:.2f} s")
    state = _draw(page, endless)
    assert state["diagnostics"][-1]["code"] in ("E501", "E503")


DEEP = {
    "calls": ("(define (f n) (+ 1 (f (+ n 1))))", "(f 0)"),
    "lists": ("(define (f n) (cons n (f (+ n 1))))", "(length (f 0))"),
    "entities": ('(define (f n) (union (call "cube") (f (+ n 1))))', "(f 0)"),
    "mutual": ("(define (f n) (* 2 (g n))) (define (g n) (- 1 (f n)))", "(f 0)"),
    "map": ("(define (f n) (map (lambda (x) (f x)) (list n)))", "(f 0)"),
    "apply": ("(define (f n) (+ 1 (apply f (list n))))", "(f 0)"),
    "sort": ("(define (f n) (sort (list 2 1) (lambda (a b) (f n))))", "(f 0)"),
}


@pytest.mark.parametrize("kind", DEEP)
def test_deep_recursion(page: Shown, kind: str) -> None:
    """Recursion without end is the usual diagnostic in all its forms, and the page goes on."""
    definitions, call = DEEP[kind]
    state = _draw(page, f'{definitions}\n(bind "a" (lambda () (let ((x {call})) (call "cube"))))')
    assert not state["ok"]
    assert state["diagnostics"][-1]["code"] == "E502", state["diagnostics"]
    assert _draw(page, '(bind "a" (lambda () (call "cube")))')["ok"]


def test_nested_text(page: Shown) -> None:
    """A program nested beyond all bounds is a diagnostic, too."""
    state = _draw(page, "(" * 20_000)
    assert state["diagnostics"][0]["code"].startswith("E")
    assert _draw(page, '(bind "a" (lambda () (call "cube")))')["ok"]


def test_editing(page: Shown) -> None:
    """Diagnostics in place, completion and formatting come from the same language server as on the desktop."""
    text = '(bind "a" (lambda ()   (call   "sphere" :radius  2)))'
    page.page.evaluate("(text) => scenelangPage.editor.replace(text)", text.replace("2", "oops"))
    page.page.wait_for_selector(".cm-lintRange-error", state="attached")
    page.page.evaluate("(text) => scenelangPage.editor.replace(text)", text)
    _until(page, "scenelangPage.packet?.primitives === 1")
    page.page.click("#format")
    _until(page, """scenelangPage.editor.text.includes('(call "sphere" :radius 2)')""")


def test_share(page: Shown, show: Any) -> None:
    """A link contains the program, and opens it."""
    text = (ROOT / "examples" / "spiral-staircase.scene").read_text()[:4096]
    code = page.page.evaluate(
        "async (text) => { scenelangPage.editor.replace(text); await scenelangPage.share(); return location.href; }",
        text,
    )
    assert len(code) < 2000
    other = show(code, (800, 600))
    _until(other, "window.scenelangPage?.editor")
    assert other.page.evaluate("scenelangPage.editor.text") == text


def test_offline(page: Shown) -> None:
    """After the first visit it works without a network."""
    _until(page, "navigator.serviceWorker.controller")
    page.page.wait_for_timeout(3000)
    page.context.set_offline(True)
    page.page.reload()
    page.ready()
    assert page.page.evaluate("scenelangPage.packet.primitives") > 100


def test_nothing_is_loaded_from_elsewhere(page: Shown, address: str) -> None:
    assert [url for url in page.requests if not url.startswith((address, "blob:", "data:"))] == []


def test_opened_as_a_file(show: Any) -> None:
    shown = show((SITE / "index.html").as_uri(), (800, 600))
    assert "http.server" in shown.text("#message")


def test_sizes() -> None:
    """What a first visit loads, beside Pyodide's own files, is small."""
    import gzip

    ours = sum(
        len(gzip.compress((SITE / name).read_bytes()))
        for name in ("playground.js", "worker.js", "viewer.css", "manifold.wasm")
    )
    assert ours < 700_000
    assert (SITE / "scenelang.tar.xz").stat().st_size < 1_200_000
    assert (SITE / "packages.tar.xz").stat().st_size < 450_000
    assert json.loads((SITE / "examples.json").read_text())


def test_one_of_a_loop_becomes_an_exception(page: Shown) -> None:
    text = (
        '(bind "a" (lambda () (union-loop 3 (lambda (i) (transform (call "cube") (translate (vector (* 2 i) 0 0)))))))'
    )
    changed = page.page.evaluate(
        """async ([text, change]) => {
          const { server } = scenelangPage;
          await server.open({ "a.scene": text }, ["a.scene"]);
          return [await server.change(0, text, change), await server.change(0, text, { ...change, shared: true })];
        }""",
        [text, {"path": "cube[1]", "move": [0, 1, 0]}],
    )
    assert "(if (= i 1) [0 1 0] [0 0 0])" in changed[0]["text"]
    assert "(vector (* 2 i) 1 0)" in changed[1]["text"]


def test_files_are_named_without_their_folder(page: Shown) -> None:
    page.page.evaluate("scenelangPage.select([0])")
    text = '(import "missing.scene")\n(import "/etc/passwd")\n(bind "a" (lambda () (call "cube")))\n'
    page.page.evaluate("(text) => scenelangPage.editor.replace(text)", text)
    _until(page, "document.getElementById('diagnostics').innerText.includes('there is no file missing.scene')")
    assert "/scenes" not in page.page.evaluate("document.documentElement.outerHTML")
