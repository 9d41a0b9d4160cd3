"""What mesh files refer to lies inside the project, whatever version of trimesh reads them; broken and outsized files
are told before anything decodes them."""

from __future__ import annotations

import base64
import copy
import json
import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import calls

from scenelang.backends.surfaces import assets
from scenelang.backends.surfaces.assets import AssetFiles, load_asset
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.values.limits import Limits, Meter

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()
DATA = CORNERS + np.array([0, 1, 2], np.uint16).tobytes()
INLINE = "data:application/octet-stream;base64," + base64.b64encode(DATA).decode()


def document(uri: str = INLINE) -> dict[str, Any]:
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "buffers": [{"byteLength": len(DATA), "uri": uri}],
    }


def written(path: Path, content: dict[str, Any]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content))
    return path


def png(width: int, height: int) -> bytes:
    """A picture in black, of a few bytes however large it is."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    packed = zlib.compressobj(9)
    rows = b"".join(packed.compress(bytes(1 + (width + 7) // 8)) for _ in range(height)) + packed.flush()
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


# --- what is referred to ---------------------------------------------------------------------------------------------


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project beside a secret file that could stand for the buffer of an asset."""
    (tmp_path / "secret.bin").write_bytes(DATA)
    (tmp_path / "project" / "models" / "deep").mkdir(parents=True)
    (tmp_path / "project" / "own.bin").write_bytes(DATA)
    (tmp_path / "project" / "models" / "near by.bin").write_bytes(DATA)
    return tmp_path / "project"


def measured(project: Path, file: str, outside: bool = False) -> AssetFiles:
    files = AssetFiles(project, project.resolve(), outside)
    files.measure(file)
    return files


@pytest.mark.parametrize(
    "uri", [INLINE, "near by.bin", "near%20by.bin", "./near%20by.bin", "deep/../near%20by.bin", "../own.bin"]
)
def test_buffers_inside_the_project_are_read(project: Path, uri: str) -> None:
    written(project / "models" / "a.gltf", document(uri))
    measured(project, "models/a.gltf")


OUTSIDE = [
    "../../secret.bin", "%2e%2e/%2e%2e/secret.bin", "..%2f..%2fsecret.bin", "..\\..\\secret.bin", "..%5c..%5csecret.bin",
    "deep/../../../secret.bin", "link.bin", "folder/secret.bin", "file:../../secret.bin", "http://localhost/secret.bin",
    "C:/secret.bin", "a%00.bin",
]  # fmt: skip


def escaping(project: Path, uri: str) -> str:
    (project / "models" / "link.bin").symlink_to(project.parent / "secret.bin")
    (project / "models" / "folder").symlink_to(project.parent)
    return uri


@pytest.mark.parametrize("uri", [*OUTSIDE, "absolute", "file://absolute"])
@pytest.mark.parametrize("place", ["buffers", "images"])
def test_nothing_outside_the_project_is_read(
    project: Path, uri: str, place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    uri = uri.replace("absolute", str(project.parent / "secret.bin"))
    content = document(escaping(project, uri) if place == "buffers" else INLINE)
    if place == "images":
        content |= {"images": [{"uri": uri}], "textures": [{"source": 0}]}
        content["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        content["meshes"][0]["primitives"][0]["material"] = 0
        escaping(project, uri)
    written(project / "models" / "a.gltf", content)
    opened: list[Path] = []
    plain = Path.open
    monkeypatch.setattr(Path, "open", lambda self, *a, **k: (opened.append(self.resolve()), plain(self, *a, **k))[1])
    with pytest.raises(SceneError) as caught:
        measured(project, "models/a.gltf")
    assert caught.value.name == "import-outside"
    assert project.parent / "secret.bin" not in opened


def test_what_is_drawn_later_keeps_to_the_project(project: Path) -> None:
    """Renderers load the file again; then too nothing outside is read."""
    path = written(project / "models" / "a.gltf", document("../own.bin"))
    asset = AssetFiles(project, project.resolve(), False).measure("models/a.gltf")
    assert len(load_asset(asset.path, asset.root).faces) == 1
    with pytest.raises(SceneError, match="is outside"):
        load_asset(path)  # by itself a file refers to what is below its own folder only


@pytest.mark.parametrize("line", ["mtllib {}", "mtllib near.mtl"])
@pytest.mark.parametrize("name", ["../../secret.mtl", "link.mtl", "absolute"])
def test_materials_and_textures_of_obj_files_stay_inside(project: Path, line: str, name: str) -> None:
    secret = project.parent / "secret.mtl"
    secret.write_text("newmtl m\nKd 1 0 0\n")
    (project / "models" / "link.mtl").symlink_to(secret)
    name = str(secret) if name == "absolute" else name
    (project / "models" / "near.mtl").write_text(f"newmtl m\nKd 1 0 0\nmap_Kd {name}\n")
    (project / "models" / "a.obj").write_text(
        f"{line.format(name)}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"
    )
    with pytest.raises(SceneError) as caught:
        measured(project, "models/a.obj")
    assert caught.value.name == "import-outside"


def test_textures_of_ply_files_stay_inside(project: Path) -> None:
    (project.parent / "secret.png").write_bytes(png(4, 4))
    head = "ply\nformat ascii 1.0\ncomment TextureFile ../../secret.png\nelement vertex 3\n"
    head += "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    (project / "models" / "a.ply").write_text(head + "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n")
    with pytest.raises(SceneError, match="is outside"):
        measured(project, "models/a.ply")


def test_pipes_are_not_opened(project: Path) -> None:
    import os

    os.mkfifo(project / "models" / "pipe.bin")
    written(project / "models" / "a.gltf", document("pipe.bin"))
    with pytest.raises(SceneError, match="which does not exist"):
        measured(project, "models/a.gltf")


# --- indices and ranges ----------------------------------------------------------------------------------------------

Change = Callable[[dict[str, Any]], Any]
_BAD = (-1, 9, 2**70, 1.0, "0", None, True, [0])
_PLACES: dict[str, Change] = {
    "scene": lambda d: (d, "scene"),
    "scenes[0].nodes[0]": lambda d: (d["scenes"][0]["nodes"], 0),
    "nodes[0].mesh": lambda d: (d["nodes"][0], "mesh"),
    "nodes[0].children": lambda d: (d["nodes"][0].setdefault("children", [0]), 0),
    "POSITION": lambda d: (d["meshes"][0]["primitives"][0]["attributes"], "POSITION"),
    "indices": lambda d: (d["meshes"][0]["primitives"][0], "indices"),
    "material": lambda d: (d["meshes"][0]["primitives"][0], "material"),
    "accessors[0].bufferView": lambda d: (d["accessors"][0], "bufferView"),
    "bufferViews[0].buffer": lambda d: (d["bufferViews"][0], "buffer"),
}


def told(path: Path) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_asset(path)
    assert caught.value.name == "file"
    assert "\n" not in caught.value.message
    return caught.value


def told_within(most: int, path: Path) -> SceneError:
    """The same after at most so many calls."""
    found: list[SceneError] = []
    assert calls(lambda: found.append(told(path))) < most
    return found[0]


@pytest.mark.parametrize("value", _BAD)
@pytest.mark.parametrize("place", list(_PLACES))
def test_indices_that_point_at_nothing(place: str, value: Any, tmp_path: Path) -> None:
    content = document()
    holder, key = _PLACES[place](content)
    holder[key] = value
    if value is None and place == "scene":
        return  # none is a scene that is not chosen
    assert "is invalid: index `" in told(written(tmp_path / "a.gltf", content)).message


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["nodes"].extend([{"children": [2]}, {"children": [1]}]), "contain a cycle"),
        (lambda d: d["nodes"][0].update(children=[0]), "contain a cycle"),
        (lambda d: d["nodes"].extend([{"children": [0]}, {"children": [0]}]), "has several parents"),
        (lambda d: d["bufferViews"][0].update(byteLength=4000), "ends at byte 4,000"),
        (lambda d: d["bufferViews"][0].update(byteOffset=-4), "not a valid size"),
        (lambda d: d["accessors"][0].update(count=4), "accessors.0.` ends at byte 48"),
        (lambda d: d["accessors"][0].update(count=-1), "not a valid size"),
        (lambda d: d["accessors"][0].update(componentType=1), "unknown type"),
        (lambda d: d["accessors"][1].update(count=10**9, bufferView=None), "is invalid"),
        (lambda d: d["buffers"][0].update(byteLength=10**9), "the buffer has 42 bytes"),
        (lambda d: d["buffers"][0].pop("uri"), "the buffer has 0 bytes"),
        (lambda d: d["buffers"][0].update(uri="data:,AAAA"), "without base64"),
        (lambda d: d["buffers"][0].update(uri=7), "not a string"),
        (lambda d: d.update(nodes={}), "is invalid"),
        (lambda d: d.update(nodes=7), "not a list of objects"),
        (lambda d: d.update(nodes=[[]]), "not a list of objects"),
        (lambda d: d["nodes"][0].update(children=7), "not a list"),
        (lambda d: d["meshes"][0].update(primitives=[]), "contains no mesh"),
        (lambda d: d["meshes"][0].pop("primitives"), "no primitives"),
    ],
)  # fmt: skip
def test_broken_documents_are_told(change: Change, message: str, tmp_path: Path) -> None:
    content = document()
    change(content)
    assert re.search(message, told(written(tmp_path / "a.gltf", content)).message)


@pytest.mark.parametrize("index", [3, 65535])
def test_faces_of_vertices_that_there_are_not(index: int, tmp_path: Path) -> None:
    wrong = CORNERS + np.array([0, 1, index], np.uint16).tobytes()
    content = document("data:;base64," + base64.b64encode(wrong).decode())
    assert f"a face refers to vertex {index:,}" in told(written(tmp_path / "a.gltf", content)).message


@pytest.mark.parametrize("command", ["count", "tree", "bounds", "run"])
def test_every_command_tells_of_a_broken_asset(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = document()
    content["nodes"][0]["mesh"] = -1
    written(tmp_path / "a.gltf", content)
    (tmp_path / "a.scene").write_text('(bind "it" (lambda () (call "mesh" :file "a.gltf")))\n')
    if command == "bounds":
        (tmp_path / "a.scene").write_text(
            '(bind "it" (lambda () (call "mesh" :file "a.gltf")))\n(print (compute-shape-min (call "it")))\n'
        )
        command = "run"
    assert main([command, str(tmp_path / "a.scene")]) == 1
    said = capsys.readouterr()
    assert "`nodes[0].mesh` is -1" in said.err + said.out
    assert "Traceback" not in said.err + said.out


def test_chunks_that_end_after_the_file(tmp_path: Path) -> None:
    text = json.dumps(document()).encode()
    good = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text
    (tmp_path / "a.glb").write_bytes(good)
    assert len(load_asset(tmp_path / "a.glb").faces) == 1
    for bad in (good[:-9], good[:12] + struct.pack("<I", 2**32 - 1) + good[16:], good[:16] + b"BIN\0" + good[20:]):
        (tmp_path / "b.glb").write_bytes(bad)
        told(tmp_path / "b.glb")


# --- limits ----------------------------------------------------------------------------------------------------------


def test_too_many_nodes(tmp_path: Path) -> None:
    content = document()
    content["nodes"] = [{"mesh": 0} for _ in range(300_000)]
    content["scenes"][0]["nodes"] = list(range(300_000))
    assert "300,000 nodes" in told_within(3_000_000, written(tmp_path / "a.gltf", content)).message


def test_nodes_that_are_nested_too_deep(tmp_path: Path) -> None:
    content = document()
    content["nodes"] = [{"mesh": 0, "children": [i + 1]} for i in range(10_000)] + [{"mesh": 0}]
    assert "nested deeper" in told_within(1_000_000, written(tmp_path / "a.gltf", content)).message


def test_meshes_that_stand_in_too_many_places(tmp_path: Path) -> None:
    content = document()
    content["meshes"][0]["primitives"] *= 200
    content["nodes"] = [{"mesh": 0} for _ in range(200)]
    content["scenes"][0]["nodes"] = list(range(200))
    assert "place 40,200 parts" in told(written(tmp_path / "a.gltf", content)).message


def test_triangles_are_counted_before_they_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assets, "MAX_TRIANGLES", 9)
    content = document()
    content["nodes"] = [{"mesh": 0} for _ in range(10)]
    assert "10 triangles" in told(written(tmp_path / "a.gltf", content)).message


def test_accessors_without_a_buffer_are_not_made(tmp_path: Path) -> None:
    content = document()
    content["accessors"][0] = {"componentType": 5126, "count": 10**10, "type": "VEC3"}
    assert "exceed the size limit" in told(written(tmp_path / "a.gltf", content)).message


def test_views_that_overlap_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assets, "_MAX_VIEW_BYTES", 2000)
    content = document()
    content["bufferViews"] += [copy.copy(content["bufferViews"][0]) for _ in range(60)]
    assert "overlap" in told(written(tmp_path / "a.gltf", content)).message


def test_json_of_too_many_values(tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_bytes(b'{"x":[' + b"[]," * 2_500_000 + b"[]]}")
    assert "more than the limit of 2,000,000 values" in told(tmp_path / "a.gltf").message


@pytest.mark.parametrize("size", [(30_000, 30_000), (8193, 4097)])
@pytest.mark.parametrize("where", ["data", "view", "file", "obj"])
@pytest.mark.sampled(2)
def test_pictures_are_measured_before_they_are_decoded(size: tuple[int, int], where: str, tmp_path: Path) -> None:
    data = png(*size)
    (tmp_path / "a.png").write_bytes(data)
    if where == "obj":
        (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd a.png\n")
        (tmp_path / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n")
        assert "pixels" in told(tmp_path / "a.obj").message
        return
    content = document()
    uri = {"data": "data:image/png;base64," + base64.b64encode(data).decode(), "file": "a.png"}.get(where)
    content["images"] = [{"uri": uri} if uri else {"bufferView": 2, "mimeType": "image/png"}]
    if where == "view":
        content["buffers"][0] = {
            "byteLength": len(DATA + data),
            "uri": "data:;base64," + base64.b64encode(DATA + data).decode(),
        }
        content["bufferViews"].append({"buffer": 0, "byteOffset": len(DATA), "byteLength": len(data)})
    assert "pixels" in told(written(tmp_path / "a.gltf", content)).message


def test_pictures_are_counted_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assets, "MAX_PIXELS", 100)
    (tmp_path / "a.png").write_bytes(png(6, 6))
    content = document()
    content["images"] = [{"uri": "a.png"}, {"uri": "./a.png"}]
    load_asset(written(tmp_path / "a.gltf", content))
    content["images"].append({"uri": ".//a.png"})
    assert "pixels" in told(written(tmp_path / "b.gltf", content)).message


def test_pictures_that_would_run_a_program(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\n%%EndComments\n")
    content = document()
    content["images"] = [{"uri": "a.png"}]
    assert "format EPS" in told(written(tmp_path / "a.gltf", content)).message


def test_loading_is_charged_and_stops_at_the_deadline(tmp_path: Path) -> None:
    written(tmp_path / "a.gltf", document())
    meter = Meter(Limits(seconds=0.0))
    with pytest.raises(LimitError, match="seconds of CPU time"):
        AssetFiles(tmp_path, tmp_path, False).measure("a.gltf", meter.charge)
