"""The archive of the playground in a Python that has nothing else: what a browser runs, but for solids."""

from __future__ import annotations

import json
import pickle
import re
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenelang.backends.surfaces import tiles
from scenelang.playground.archive import modules, write_archives, write_examples
from scenelang.session.session import Options, Session
from scenelang.viewer.workspace import evaluator

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").rglob("*.scene"))
# Solids need WebAssembly; ``test_page`` draws them.
PLAIN = [path for path in EXAMPLES if "making" not in path.parts and "(lathe" not in path.read_text()]

SCRIPT = """
import json, pickle, sys
sys.path[:0] = [sys.argv[1]]
from scenelang.playground.in_browser import Playground, open_session
from scenelang.viewer.workspace import evaluator
import numpy
assert numpy.__file__.startswith(sys.argv[1]), numpy.__file__
evaluate = evaluator(lambda path, values: open_session(path, values, sys.argv[3]), 1_000_000)
results = {path: evaluate(path, {}) for path in sys.argv[4:]}
pickle.dump({path: (r.packet, [d.message for d in r.diagnostics if d.is_error]) for path, r in results.items()}, open(sys.argv[2], "wb"))
"""


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import zipfile

    folder = tmp_path_factory.mktemp("archive")
    write_archives(folder)
    for name in ("scenelang", "packages"):
        zipfile.ZipFile(folder / f"{name}.zip").extractall(folder / "modules")
    return folder


def _decoded(packet: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    (length,) = struct.unpack("<I", packet[4:8])
    header = json.loads(packet[8 : 8 + length])
    kinds = {"f4": np.float32, "i4": np.int32, "u4": np.uint32, "u1": np.uint8}
    columns = {
        name: np.frombuffer(packet, kinds[kind], count, 8 + length + offset)
        for name, (kind, offset, count) in header.pop("columns").items()
    }
    return header, columns


def _assert_close(left: Any, right: Any) -> None:
    """Compare the data of headers; floats to the last bits."""
    if isinstance(right, dict):
        assert left.keys() == right.keys()
        for key, value in right.items():
            _assert_close(left[key], value)
    elif isinstance(right, list):
        assert len(left) == len(right)
        for a, b in zip(left, right, strict=True):
            _assert_close(a, b)
    elif isinstance(right, float):
        assert left == pytest.approx(right, rel=1e-12, abs=1e-12)
    elif isinstance(right, str):  # values of attributes are texts of floats
        numbers = r"-?\d+\.\d+(?:e-?\d+)?"
        assert re.sub(numbers, "#", left) == re.sub(numbers, "#", right)
        pairs = zip(re.findall(numbers, left), re.findall(numbers, right), strict=True)
        assert all(float(a) == pytest.approx(float(b), rel=1e-9) for a, b in pairs)
    else:
        assert left == right


def test_examples_are_the_desktop_s(archive: Path) -> None:
    """Every example without solids gives the desktop's packet, in a process that has no other module."""
    out = archive / "packets.pickle"
    words = [sys.executable, "-I", "-S", "-c", SCRIPT, str(archive / "modules"), str(out), str(ROOT / "examples")]
    done = subprocess.run([*words, *map(str, PLAIN)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    packets = pickle.loads(out.read_bytes())
    evaluate = evaluator(lambda path, values: Session(Options(defines=dict(values))), 1_000_000)
    assert len(packets) == len(PLAIN) > 15
    for path, (packet, errors) in packets.items():
        assert packet is not None, (path, errors)
        expected = evaluate(path, {}, None).packet
        assert expected is not None
        (header, columns), (wanted, theirs) = _decoded(packet), _decoded(expected)
        for name in ("backdrop", "ground"):  # the playground has no drafts that choose the tone
            wanted["studio"][name] = header["studio"][name]
        _assert_close(header, wanted)
        assert columns.keys() == theirs.keys()
        for name, column in theirs.items():
            assert columns[name].shape == column.shape, (path, name)
            assert np.allclose(columns[name], column, rtol=1e-6, atol=1e-6), (path, name)


LIT = """(environment "sky" :hour 16 :turn 20) (light :position [1 3 2] :look-at "a" :power 40 :angle 50)
(light :direction [0 -1 0]) (camera :eye [3 2 5] :look-at "a" :roll 5) (camera "b" :azimuth 40)
(bind "a" (lambda () (call "cube")))
"""


def test_light_and_cameras_are_the_desktop_s(archive: Path, tmp_path: Path) -> None:
    out, program = tmp_path / "packets.pickle", tmp_path / "a.scene"
    program.write_text(LIT)
    words = [sys.executable, "-I", "-S", "-c", SCRIPT, str(archive / "modules"), str(out), str(tmp_path), str(program)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    ((packet, errors),) = pickle.loads(out.read_bytes()).values()
    assert packet is not None, errors
    expected = evaluator(lambda path, values: Session(Options()), 1_000)(str(program), {}, None).packet
    assert expected is not None
    (header, columns), (wanted, theirs) = _decoded(packet), _decoded(expected)
    _assert_close(header["cameras"], wanted["cameras"])
    _assert_close(header["studio"], wanted["studio"])
    assert np.allclose(columns["panorama"], theirs["panorama"], rtol=1e-6)


TEXTURED = """(bind "a" (lambda () (union (call "cube" :texture "checker") (call "sphere" :texture "marble")
  (call "cylinder" :texture (texture "brick" :projection "cylindrical" :scale 0.3)) (call "cube" :texture "wood"))))
"""
SMALL = """
import sys
sys.path[:0] = [sys.argv[1]]
import scenelang.backends.surfaces.tiles as tiles
tiles._SIZE = 32
"""


def test_textures_are_the_desktop_s(archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Patterns need no package; their images are the desktop's, but smaller."""
    out, program = tmp_path / "packets.pickle", tmp_path / "a.scene"
    program.write_text(TEXTURED)
    words = [sys.executable, "-I", "-S", "-c", SMALL + SCRIPT, str(archive / "modules"), str(out), str(tmp_path)]
    done = subprocess.run([*words, str(program)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    ((packet, errors),) = pickle.loads(out.read_bytes()).values()
    assert packet is not None, errors
    monkeypatch.setattr(tiles, "_SIZE", 32)
    tiles._tile.cache_clear()
    expected = evaluator(lambda path, values: Session(Options()), 1_000)(str(program), {}, None).packet
    tiles._tile.cache_clear()
    assert expected is not None
    (header, columns), (wanted, theirs) = _decoded(packet), _decoded(expected)
    assert header["textureSide"] == wanted["textureSide"] == 32
    assert len(columns["textureImages"]) == 4 * 32 * 32 * 3
    assert np.abs(columns["textureImages"].astype(int) - theirs["textureImages"].astype(int)).max() <= 1
    assert np.allclose(columns["primitiveTexture"], theirs["primitiveTexture"], atol=1e-6)


SESSION = """
import asyncio, json, sys
sys.path[:0] = [sys.argv[1]]
import scenelang.playground.in_browser as worker
worker.FOLDER = sys.argv[2]
from scenelang.playground.in_browser import Playground

async def main():
    said = []
    playground = Playground(said.append)
    ask = lambda method, *values: playground.call(method, json.dumps(values))
    text = '(param size 1.0 :min 0.5 :max 2.0)\\n(bind "pair" (lambda () (union (call "cube" :scale [size 1 1]) (transform (call "cone") (translate [2 0 0])))))'
    print(ask("open", {"a.scene": text}, ["a.scene"]))
    print(ask("state", 0))
    print(len(ask("picture", 0)))
    print(ask("literal", 0, "size", 1.5, text))
    print(ask("change", 0, text, {"path": "pair/cone", "move": [0, 1, 0]}))
    print(ask("change", 0, text, {"path": "pair/horse", "move": [0, 1, 0]}))
    print(ask("edit", 0, "(call"))
    print(len(ask("picture", 0)))
    print(ask("edit", 0, '(define (f n) (+ 1 (f (+ n 1))))\\n(bind "a" (lambda () (f 1)))'))
    print(ask("edit", 0, '(bind "a" (lambda () (call "cube" :scale (+ 1 (random :stream (default-rng 3))))))'))
    print(ask("export", 0, "stl"))
    ask("edit", 0, text)
    print(len(ask("export", 0, "glb")), ask("export", 0, "glb")[:4])
    ask("lsp", json.dumps({"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {"capabilities": {}, "processId": None, "rootUri": None}}))
    await asyncio.sleep(0.1)
    print("definitionProvider" in said[0])
    ask("lsp", "no message")
    try:
        ask("__init__")
    except ValueError as error:
        print(error)

asyncio.run(main())
"""


def test_session(archive: Path, tmp_path: Path) -> None:
    """What the page asks, and what it gets, errors included."""
    words = [sys.executable, "-I", "-S", "-c", SESSION, str(archive / "modules"), str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    said = iter(done.stdout.splitlines())
    assert json.loads(next(said)) == ["a.scene"]
    state = json.loads(next(said))
    assert state["ok"]
    assert [param["name"] for param in state["params"]] == ["size"]
    first = int(next(said))
    assert first > 1000
    assert json.loads(next(said)) == {"start": 12, "end": 15, "text": "1.5"}
    changed = json.loads(next(said))
    assert "[2 1 0]" in changed["text"]
    assert "horse" in json.loads(next(said))["error"]
    broken = json.loads(next(said))
    assert not broken["ok"]
    assert broken["diagnostics"][0]["code"].startswith("E1")
    assert int(next(said)) == first  # the last good picture
    assert json.loads(next(said))["diagnostics"][-1]["code"] == "E502"
    missing = json.loads(next(said))["diagnostics"][-1]
    assert "which the playground does not have" in missing["message"]
    assert "--> a.scene:1:" in missing["text"]
    assert "desktop" in json.loads(next(said))["hint"]
    assert next(said).endswith("b'glTF'")
    assert next(said) == "True"
    assert "__init__" in next(said)


def test_domains_stay_out() -> None:
    """The archive has the kernel and the viewer, not the other domains."""
    names = modules()
    assert "scenelang.interpreter.evaluation.evaluate" in names
    assert not [
        name
        for name in names
        if re.match(r"scenelang\.(inference|bench|backends\.neural|interpreter\.transpile)", name)
    ]


def test_examples_of_the_page(tmp_path: Path) -> None:
    """All example programs are offered, with a title."""
    write_examples(tmp_path / "examples.json", ROOT / "examples")
    examples = json.loads((tmp_path / "examples.json").read_text())
    assert {example["name"] for example in examples} >= {"chessboard.scene", "paper/chessboard.scene"}
    assert len(examples) == len(EXAMPLES)
    assert all(example["title"] for example in examples)
