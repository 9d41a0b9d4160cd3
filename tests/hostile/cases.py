"""All hostile cases: the command, its program, the files beside it. Files are made here, none is kept."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from hostile import programs

ASSET = '(bind "a" (lambda () (call "mesh" :file "{}")))\n'
Maker = Callable[[Path], None]


@dataclass(frozen=True)
class Case:
    """``text`` is what ``file`` holds; ``make`` adds other files to its folder."""

    name: str
    text: str
    word: str = "run"
    file: str = "prog.scene"
    options: tuple[str, ...] = ()
    make: Maker | None = None
    kind: str = ""


def rooted(text: str) -> str:
    imports = '(import "std/python.scene")\n' if "(py-" in text else ""
    return imports + text if "(bind" in text else imports + text + programs.ROOT


def every() -> list[Case]:
    return [*_of_tables(), *_assets(), *_texts(), *_python(), *_embeddings(), *_imports()]


def _of_tables() -> Iterator[Case]:
    for kind in ("HUGE_ARGUMENTS", "COLLISIONS", "ERRORS", "OUTPUT", "FORMATS", "INTEGERS"):
        for name, text in getattr(programs, kind).items():
            yield Case(f"{kind.lower()}: {name}", rooted(text), kind=kind.lower())
    for name, text in programs.MACROS.items():
        yield Case(f"macros: {name}", rooted(text), word="check", kind="macros")
    for number, (name, text) in enumerate(programs.SCENES.items()):
        word = ("run", "count", "flatten", "bounds", "tree")[number % 5]
        yield Case(f"scenes: {name}", rooted(text), word=word, kind="scenes")
    for number, (name, text) in enumerate(programs.OPERATIONS.items()):
        yield Case(f"shared data: {name}", rooted(programs.TWIN + text), kind="shared data")
        if number % 3 == 0:
            yield Case(f"deep data: {name}", rooted(programs.DEEP + "(define y (list x))" + text), kind="deep data")
        if number % 3 == 1:
            yield Case(
                f"cyclic data: {name}", rooted(programs.CYCLE + "(define y (list x))" + text), kind="cyclic data"
            )


# --- assets ----------------------------------------------------------------------------------------------------------


def gltf(**parts: object) -> str:
    return json.dumps({"asset": {"version": "2.0"}, **parts})


def many_nodes(path: Path) -> None:
    nodes = [{"children": [i + 1]} if i % 7 else {"mesh": 0} for i in range(300_000)]
    (path / "a.gltf").write_text(gltf(nodes=nodes, scenes=[{"nodes": list(range(0, 300_000, 7))}], scene=0))


def doubling_nodes(path: Path) -> None:
    """Every node has the next one twice: 2^40 instances of a triangle."""
    nodes: list[dict[str, object]] = [{"children": [i + 1, i + 1]} for i in range(40)]
    (path / "a.gltf").write_text(gltf(nodes=[*nodes, {"mesh": 0}], scenes=[{"nodes": [0]}], scene=0, **triangle()))


def cyclic_nodes(path: Path) -> None:
    nodes = [{"children": [1], "mesh": 0}, {"children": [0], "mesh": 0}]
    (path / "a.gltf").write_text(gltf(nodes=nodes, scenes=[{"nodes": [0]}], scene=0, **triangle()))


def deep_nodes(path: Path) -> None:
    nodes: list[dict[str, object]] = [{"children": [i + 1]} for i in range(50_000)]
    (path / "a.gltf").write_text(gltf(nodes=[*nodes, {"mesh": 0}], scenes=[{"nodes": [0]}], scene=0, **triangle()))


def triangle(count: int = 3, kind: str = "VEC3") -> dict[str, object]:
    import base64

    data = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return {
        "buffers": [{"uri": uri, "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": kind}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    }


def huge_accessor(path: Path) -> None:
    document = triangle(10**9)
    (path / "a.gltf").write_text(gltf(nodes=[{"mesh": 0}], scenes=[{"nodes": [0]}], scene=0, **document))


def no_view(path: Path) -> None:
    """An accessor without a view is zeros, as many as it says."""
    document = triangle()
    document["accessors"] = [{"componentType": 5126, "count": 10**9, "type": "VEC3"}]
    (path / "a.gltf").write_text(gltf(nodes=[{"mesh": 0}], scenes=[{"nodes": [0]}], scene=0, **document))


def many_meshes(path: Path) -> None:
    document = triangle()
    document["meshes"] = document["meshes"] * 50_000  # type: ignore[operator]
    nodes = [{"mesh": i} for i in range(50_000)]
    (path / "a.gltf").write_text(gltf(nodes=nodes, scenes=[{"nodes": list(range(50_000))}], scene=0, **document))


def png(width: int, height: int) -> bytes:
    """A picture of one color, which compresses to almost nothing."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    packer = zlib.compressobj(9)
    row = b"\0" * (1 + 3 * width)
    data = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def picture_bomb(path: Path) -> None:
    (path / "bomb.png").write_bytes(png(12_000, 12_000))
    (path / "a.mtl").write_text("newmtl m\nmap_Kd bomb.png\n")
    (path / "a.obj").write_text("mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n")


def picture_bomb_in_gltf(path: Path) -> None:
    (path / "bomb.png").write_bytes(png(12_000, 12_000))
    document = triangle()
    document["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    pictures = {"materials": [material], "textures": [{"source": 0}], "images": [{"uri": "bomb.png"}]}
    (path / "a.gltf").write_text(gltf(nodes=[{"mesh": 0}], scenes=[{"nodes": [0]}], scene=0, **document, **pictures))


def long_obj(path: Path) -> None:
    (path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 1_500_000)


def wide_face(path: Path) -> None:
    corners = "".join(f"v {i} {i * i % 97} 0\n" for i in range(100_000))
    (path / "a.obj").write_text(corners + "f " + " ".join(str(i + 1) for i in range(100_000)) + "\n")


def many_groups(path: Path) -> None:
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    (path / "a.obj").write_text(corners + "".join(f"o g{i}\nusemtl m{i}\nf 1 2 3\n" for i in range(100_000)))


def stl_that_lies(path: Path) -> None:
    (path / "a.stl").write_bytes(b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 500)


def ply_that_lies(path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    (path / "a.ply").write_text(head + "0 0 0\n" * 10)


def ply_of_lists(path: Path) -> None:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
    )
    head += "element face 1\nproperty list uint int vertex_indices\nend_header\n"
    (path / "a.ply").write_bytes(head.encode() + struct.pack("<fffI", 0, 0, 0, 2**32 - 1))


def deep_json(path: Path) -> None:
    (path / "a.gltf").write_text("[" * 1_000_000)


def glb_that_lies(path: Path) -> None:
    (path / "a.glb").write_bytes(b"glTF" + struct.pack("<III", 2, 2**32 - 1, 2**32 - 1) + b"JSON" + b"{" * 100)


def sparse_file(path: Path) -> None:
    with (path / "a.obj").open("wb") as file:
        file.truncate(3_000_000_000)


def fifo(path: Path) -> None:
    import os

    os.mkfifo(path / "a.obj")


ASSETS: dict[str, tuple[str, Maker]] = {
    "300,000 nodes": ("a.gltf", many_nodes), "doubling nodes": ("a.gltf", doubling_nodes),
    "cyclic nodes": ("a.gltf", cyclic_nodes), "deep nodes": ("a.gltf", deep_nodes),
    "accessor that lies": ("a.gltf", huge_accessor), "accessor of zeros": ("a.gltf", no_view),
    "50,000 meshes": ("a.gltf", many_meshes), "picture bomb": ("a.obj", picture_bomb),
    "picture bomb in a glTF": ("a.gltf", picture_bomb_in_gltf), "long OBJ": ("a.obj", long_obj),
    "face of 100,000 corners": ("a.obj", wide_face), "100,000 groups": ("a.obj", many_groups),
    "STL that lies": ("a.stl", stl_that_lies), "PLY that lies": ("a.ply", ply_that_lies),
    "PLY of lists": ("a.ply", ply_of_lists), "deep JSON": ("a.gltf", deep_json), "GLB that lies": ("a.glb", glb_that_lies),
    "sparse file": ("a.obj", sparse_file), "FIFO": ("a.obj", fifo),
}  # fmt: skip


def _assets() -> Iterator[Case]:
    for number, (name, (file, make)) in enumerate(ASSETS.items()):
        word = ("bounds", "count", "flatten")[number % 3]
        yield Case(f"assets: {name}", ASSET.format(file), word=word, make=make, kind="assets")


# --- texts -----------------------------------------------------------------------------------------------------------

N = 1_000_000
TEXTS = {
    "open brackets": "(" * N, "closed brackets": ")" * N, "nested": "(" * N + ")" * N, "quotes": "'" * N,
    "comments": "#;" * N, "open comment": "#|" * N, "open string": '"' + "\\" * N, "one word": "a" * (5 * N),
    "one number": "9" * (5 * N), "one string": f'(print "{"x" * (5 * N)}")', "many strings": '"" ' * N,
    "many definitions": "\n".join(f"(define a{i} {i})" for i in range(60_000)),
    "the same definition": "(define a 1)\n" * 60_000, "one wide list": "(list " + "1 " * N + ")",
    "wide call of words": '(bind "a" (lambda () (union ' + '(call "cube") ' * 60_000 + ")))",
    "nested lets": "(let ((a 1)) " * 4_000 + "a" + ")" * 4_000, "nested lambdas": "(lambda () " * 4_000 + "1" + ")" * 4_000,
    "long cond": "(cond " + "((= 1 2) 3) " * 60_000 + ")", "colors": "(color \"" + "e" * N + "\")",
    "controls": "\x1b[2J\x07\x00" * 100_000, "line ends": "\r\n\x0b\x0c\u2028" * 200_000, "marks": "\u202e\u0301" * 300_000,
    "similar names": "\n".join(f"(define aaaaaaaaaaaaaaaaaaaa{i} 1) (aaaaaaaaaaaaaaaaaaab{i})" for i in range(3_000)),
    "vectors as in Scheme": "#(1 2)" * 100_000,
    "unused parameters": "\n".join(f"(define (f{i} a b c d) {i})" for i in range(10_000)),
}  # fmt: skip


def _texts() -> Iterator[Case]:
    for name, text in TEXTS.items():
        yield Case(f"texts: {name}", text + programs.ROOT, word="check", kind="texts")


# --- Python ----------------------------------------------------------------------------------------------------------

HEAD = "from helper import *\n\n@register()\ndef scene() -> Shape:\n"
PYTHON = {
    "deep brackets": HEAD + "    return " + "(" * 10_000 + "1" + ")" * 10_000, "deep lists": HEAD + "    return " + "[" * 5_000 + "]" * 5_000,
    "long sum": HEAD + "    return " + "1+" * 20_000 + "1", "long comparison": HEAD + "    return " + "1<" * 20_000 + "1",
    "unary signs": HEAD + "    return " + "-" * 20_000 + "1", "nots": HEAD + "    return " + "not " * 20_000 + "1",
    "attributes": HEAD + "    return a" + ".b" * 20_000, "calls": HEAD + "    return a" + "()" * 20_000,
    "subscripts": HEAD + "    return a" + "[0]" * 20_000, "conditionals": HEAD + "    return " + "1 if a else " * 5_000 + "2",
    "lambdas": HEAD + "    return " + "lambda: " * 5_000 + "1", "statements": HEAD + "    a = 1\n" * 60_000,
    "functions": "".join(f"def f{i}(a, b):\n    return a + b\n" for i in range(15_000)),
    "nested functions": "".join("    " * i + f"def f{i}():\n" for i in range(95)) + "    " * 95 + "pass\n",
    "nested loops": HEAD + "".join("    " * (i + 1) + f"for i{i} in range(9):\n" for i in range(90)) + "    " * 91 + "pass\n",
    "nested comprehensions": HEAD + "    return " + "[" * 90 + "1" + " for a in b]" * 90,
    "comprehension of many": HEAD + "    return [1 " + "for a in b " * 5_000 + "]", "one number": HEAD + "    return " + "9" * 100_000,
    "one hex number": HEAD + "    return 0x" + "f" * 900_000, "one text": HEAD + "    return '" + "x" * 3_000_000 + "'",
    "texts joined": HEAD + "    return " + "'x' " * 100_000, "nested f-texts": HEAD + "    return " + "f'{" * 2 + "1" + "}'" * 2,
    "wide call": HEAD + "    return f(" + "1, " * 100_000 + ")", "keywords": HEAD + "    return f(" + ", ".join(f"k{i}=1" for i in range(20_000)) + ")",
    "powers": HEAD + "    return " + "9**" * 5_000 + "9", "fences": "```python\n" * 100_000, "open fences": "```python\nx = '''" * 30_000,
    "names assigned": HEAD + "".join(f"    a{i} = a{i - 1} if a{i - 1} else a{i - 2}\n" for i in range(2, 8_000)),
    "branches": HEAD + "".join(f"    if a{i}:\n        b = {i}\n    else:\n        c = b\n" for i in range(5_000)),
    "elifs": HEAD + "    if a == 0:\n        b = 0\n" + "".join(f"    elif a == {i}:\n        b = {i}\n" for i in range(2_000)),
    "tabs": HEAD + "\t" * 100_000 + "pass", "decorators": "@register()\n" * 20_000 + "def f(): pass", "null": "\0" * 100_000,
    "surrogates": HEAD + "    return '" + "\\ud800" * 20_000 + "'", "classes": "".join(f"class A{i}:\n    x = {i}\n" for i in range(20_000)),
}  # fmt: skip


def _python() -> Iterator[Case]:
    for name, text in PYTHON.items():
        yield Case(f"python: {name}", text, word="transpile", file="answer.py", kind="python")


# --- embeddings ------------------------------------------------------------------------------------------------------


def z(data: bytes | Callable[[], bytes]) -> Maker:
    """A file of embeddings; where the data take long to make, what makes them."""
    made = data if callable(data) else lambda: data
    return lambda path: (path / "prog.z.safetensors").write_bytes(made()) and None


def header(document: object, length: int | None = None) -> bytes:
    text = json.dumps(document).encode()
    return struct.pack("<Q", len(text) if length is None else length) + text


def sparse_z(path: Path) -> None:
    data = header({"z1": {"dtype": "F32", "shape": [750_000_000], "data_offsets": [0, 3_000_000_000]}})
    with (path / "prog.z.safetensors").open("wb") as file:
        file.write(data)
        file.truncate(len(data) + 3_000_000_000)


EMBEDDINGS: dict[str, Maker] = {
    "length that lies": z(struct.pack("<Q", 2**63)), "shape that lies": z(header({"a": {"dtype": "F32", "shape": [2**40], "data_offsets": [0, 4]}}) + b"\0" * 4),
    "huge sparse": sparse_z, "many tensors": z(lambda: header({f"a{i}": {"dtype": "F32", "shape": [0], "data_offsets": [0, 0]} for i in range(200_000)})),
    "deep header": z(struct.pack("<Q", 200_000) + b"[" * 200_000), "controls": z(header({"\x1b[2J\x00": {"dtype": "F32", "shape": [1], "data_offsets": [0, 4]}}) + b"\0" * 4),
    "metadata": z(lambda: header({"__metadata__": {f"k{i}": "x" * 90 for i in range(50_000)}})), "folder": lambda path: (path / "prog.z.safetensors").mkdir(),
}  # fmt: skip


def _embeddings() -> Iterator[Case]:
    text = '(bind "a" (lambda () (call "cube" z1)))\n'
    for name, make in EMBEDDINGS.items():
        yield Case(f"embeddings: {name}", text, make=make, kind="embeddings")


# --- imports ---------------------------------------------------------------------------------------------------------


def chain(path: Path) -> None:
    for i in range(2_000):
        (path / f"f{i}.scene").write_text(f'(import "f{i + 1}.scene")\n')
    (path / "f2000.scene").write_text("(define a 1)")


def fan(path: Path) -> None:
    """Each of 60 files imports all that follow."""
    for i in range(60):
        (path / f"f{i}.scene").write_text(
            "".join(f'(import "f{j}.scene" :prefix p{j}/)\n' for j in range(i + 1, 60)) + f"(define a{i} 1)"
        )


def ring(path: Path) -> None:
    for i in range(100):
        (path / f"f{i}.scene").write_text(f'(import "f{(i + 1) % 100}.scene")\n')


def big(path: Path) -> None:
    (path / "f0.scene").write_text("(define a 1)\n" * 1_200_000)


def long_work(path: Path) -> None:
    (path / "f0.scene").write_text("(while #t 1)")


def looping_macro(path: Path) -> None:
    (path / "f0.scene").write_text("(define-macro (m) (while #t 1))")


def device(path: Path) -> None:
    (path / "f0.scene").symlink_to("/dev/zero")


def pipe(path: Path) -> None:
    import os

    os.mkfifo(path / "f0.scene")


IMPORTS: dict[str, tuple[str, Maker]] = {
    "chain of 2,000": ("", chain), "fan": ("", fan), "ring": ("", ring), "long file": ("", big),
    "loop in a file": ("", long_work), "macro of a file": ("(m)", looping_macro), "device": ("", device), "FIFO": ("", pipe),
}  # fmt: skip


def _imports() -> Iterator[Case]:
    for name, (text, make) in IMPORTS.items():
        yield Case(f"imports: {name}", f'(import "f0.scene")\n{text}{programs.ROOT}', make=make, kind="imports")
    many = "".join(f'(import "missing{i}.scene")\n' for i in range(20_000))
    yield Case("imports: 20,000 files that are missing", many + programs.ROOT, word="check", kind="imports")
