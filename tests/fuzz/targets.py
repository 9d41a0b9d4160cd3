"""What is fuzzed: each target takes bytes, and anything that it raises is a finding."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shutil
import struct
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from fuzz import api_calls, making
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError, render_text
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import Options, Session

LIMITS = Limits(
    steps=200_000,
    depth=3_000,
    entities=20_000,
    primitives=20_000,
    size=1_000_000,
    memory=300_000_000,
    seconds=1.0,
    log=1_000,
)


@dataclass(frozen=True)
class Target:
    """``make`` gives an input from a random stream, ``check`` works on one; ``seconds``: longer is a hang."""

    name: str
    make: Callable[[making.Rng], bytes]
    check: Callable[[bytes], object]
    seconds: float = 5.0


def text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape" if data.startswith(b"\xff") else "replace")


@cache
def folder() -> Path:
    """Where inputs are put; there is one for a process, and it goes with it."""
    import atexit

    path = Path(tempfile.mkdtemp(prefix="fuzz-"))
    atexit.register(shutil.rmtree, path, True)
    return path


def written(name: str, data: bytes) -> Path:
    path = folder() / name
    path.write_bytes(data)
    return path


@contextlib.contextmanager
def refusing() -> Any:
    """What is refused is a SceneError whose message is a text for people."""
    try:
        yield
    except SceneError as error:
        shown = render_text(error.diagnostic)
        assert "Traceback" not in shown
        assert " at 0x" not in shown
        assert len(shown) < 100_000
        shown.encode()


# --- texts -----------------------------------------------------------------------------------------------------------


def reader(data: bytes) -> None:
    from scenelang.grammar import ast
    from scenelang.grammar.formatter import format_text
    from scenelang.grammar.reader import read
    from scenelang.repl.console import scan

    source = Source("a.scene", text(data))
    scan(source.text)
    found = read(source)
    for diagnostic in found.diagnostics:
        render_text(diagnostic)
    if found.diagnostics:
        return
    with refusing():
        ast.check_strict(found.forms)
    with refusing():
        once = format_text(source.text, {})
        assert format_text(once, {}) == once, "formatting twice differs"


def programs(data: bytes) -> None:
    found = Session(Options(limits=LIMITS)).evaluate(Source(str(folder() / "a.scene"), text(data)))
    shown = "\n".join(render_text(d) for d in found.diagnostics)
    assert "internal error" not in shown, shown[:300]
    assert " at 0x" not in shown, shown[:300]
    shown.encode()
    assert len(shown) < 1_000_000


def python(data: bytes) -> None:
    with refusing():
        translation = Session(Options(limits=LIMITS)).transpile(Source("a.py", text(data)))
        for diagnostic in translation.diagnostics:
            render_text(diagnostic)
        if translation.text:
            checked = Session(Options(limits=LIMITS)).check(Source("a.scene", translation.text))
            wrong = [d for d in checked.diagnostics if d.is_error and d.code.startswith("E1")]
            assert not wrong, f"the program cannot be read: {wrong[0].message}"


def repl(data: bytes) -> None:
    from scenelang.repl.evaluation import ReplEvaluation
    from scenelang.repl.plain import Plain

    for as_json in (False, True):
        out, errors = io.StringIO(), io.StringIO()
        Plain(io.StringIO(text(data)), out, errors, as_json=as_json).run(
            ReplEvaluation(Session(Options(limits=LIMITS)))
        )
        said = out.getvalue() + errors.getvalue()
        assert "internal error" not in said, said[-300:]
        assert " at 0x" not in said, said[-300:]


REPL_COMMANDS = ("help", "doc", "apropos", "source", "expand", "time", "trace", "seed", "reset", "tree", "count", "bounds", "primitives", "load", "reload", "quit", "save", "defs", "x", "")  # fmt: skip


def make_repl(rng: making.Rng) -> bytes:
    lines = []
    for _ in range(rng.choice((1, 2, 4))):
        kind = rng.random()
        if kind < 0.4:
            rest = rng.choice((making.expression(rng, 1), "x", "", "(", "3", "nothing.scene", "cube", "\x1b"))
            lines.append(f",{rng.choice(REPL_COMMANDS)} {rest}".encode())
        elif kind < 0.8:
            lines.append(
                rng.choice(
                    (
                        making.expression(rng, 2),
                        f"(define x {making.expression(rng, 2)})",
                        '(bind "a" (lambda () (call "cube")))',
                    )
                ).encode()
            )
        else:
            lines.append(making.tokens(rng))
    return b"\n".join(line.replace(b",save", b",x") for line in lines) + b"\n"


@cache
def _server() -> Any:
    from lsprotocol import types as lsp
    from pygls.workspace import Workspace

    from scenelang.lsp.server import build_server

    server = build_server("1")
    server.protocol._workspace = Workspace(folder().as_uri(), sync_kind=lsp.TextDocumentSyncKind.Incremental)
    server.protocol.notify = lambda *_, **__: None
    server.text_document_publish_diagnostics = lambda *_: None
    server.documents.root = folder()
    server.changed = lambda uri: None  # which waits for a pause in an event loop before it publishes
    return server


def lsp_requests(data: bytes) -> None:
    """A text, then requests at places of it: a JSON list after the last null character."""
    from lsprotocol import types as lsp
    from pygls.exceptions import JsonRpcInvalidParams

    body, _, rest = data.rpartition(b"\0")
    try:
        requests = json.loads(rest)
    except ValueError:
        requests = [["textDocument/hover", 0, 0]]
    server = _server()
    features = server.protocol.fm.features
    uri = (folder() / "a.scene").as_uri()
    identifier = lsp.TextDocumentIdentifier(uri)
    item = lsp.TextDocumentItem(uri, "scene", 1, text(body))
    server.workspace.put_text_document(item)
    features["textDocument/didOpen"](lsp.DidOpenTextDocumentParams(item))
    for request in requests if isinstance(requests, list) else []:
        name, line, column = request
        if name == "change":
            at = lsp.Range(lsp.Position(line, column), lsp.Position(line, column + 2))
            edit = lsp.TextDocumentContentChangePartial(range=at, text="(")
            identified = lsp.VersionedTextDocumentIdentifier(2, uri)
            server.workspace.update_text_document(identified, edit)
            document = server.workspace.get_text_document(uri)
            server.documents.change(folder() / "a.scene", document.source)
            continue
        with contextlib.suppress(JsonRpcInvalidParams):  # a refusal with a message, as of a name that cannot be changed
            features[name](_parameters(lsp, name, identifier, lsp.Position(line, column)))
    server.publish(uri)
    features["textDocument/didClose"](lsp.DidCloseTextDocumentParams(identifier))
    server.workspace.remove_text_document(uri)


AT_PLACE = (
    "hover",
    "completion",
    "signatureHelp",
    "definition",
    "references",
    "documentHighlight",
    "prepareRename",
    "rename",
)
OF_TEXT = (
    "documentSymbol",
    "semanticTokens/full",
    "semanticTokens/range",
    "formatting",
    "rangeFormatting",
    "codeAction",
)


def _parameters(lsp: Any, name: str, identifier: Any, at: Any) -> Any:
    range_ = lsp.Range(lsp.Position(0, 0), at)
    kinds: dict[str, Callable[[], Any]] = {
        "hover": lambda: lsp.HoverParams(identifier, at), "completion": lambda: lsp.CompletionParams(identifier, at),
        "signatureHelp": lambda: lsp.SignatureHelpParams(identifier, at), "definition": lambda: lsp.DefinitionParams(identifier, at),
        "references": lambda: lsp.ReferenceParams(lsp.ReferenceContext(True), identifier, at),
        "documentHighlight": lambda: lsp.DocumentHighlightParams(identifier, at), "prepareRename": lambda: lsp.PrepareRenameParams(identifier, at),
        "rename": lambda: lsp.RenameParams(text_document=identifier, position=at, new_name="new-name"), "documentSymbol": lambda: lsp.DocumentSymbolParams(identifier),
        "semanticTokens/full": lambda: lsp.SemanticTokensParams(identifier), "semanticTokens/range": lambda: lsp.SemanticTokensRangeParams(identifier, range_),
        "formatting": lambda: lsp.DocumentFormattingParams(identifier, lsp.FormattingOptions(2, True)),
        "rangeFormatting": lambda: lsp.DocumentRangeFormattingParams(identifier, range_, lsp.FormattingOptions(2, True)),
        "codeAction": lambda: lsp.CodeActionParams(identifier, range_, lsp.CodeActionContext([])),
    }  # fmt: skip
    return kinds[name.removeprefix("textDocument/")]()


def make_lsp(rng: making.Rng) -> bytes:
    body = rng.choice((making.program, making.tokens))(rng).replace(b"\0", b"")
    names = [f"textDocument/{rng.choice(AT_PLACE + OF_TEXT)}" if rng.random() < 0.9 else "change" for _ in range(4)]
    places = [[name, rng.choice((0, 0, 1, 2, 3, 5, 10**6)), rng.choice((0, 1, 3, 8, 15, 40, 10**6))] for name in names]
    return body + b"\0" + json.dumps(places).encode()


# --- options ---------------------------------------------------------------------------------------------------------

COMMANDS = ("check", "run", "tree", "flatten", "count", "bounds", "expand", "explain", "diff", "transpile", "runs", "export", "backends", "graph", "embeddings", "grammar", "completion", "labels")  # fmt: skip
VALUES = ("", "0", "1", "-1", "1e999", "nan", "9" * 30, "x", "a=1", "a=", "=", "x=(", "prog.scene", "other.scene", "none.scene", ".", "-", "/dev/null", "--", "\x1b[31m", "é", "1x1", "0x0", "1M", "-1G", "out.json", "out.glb", "dot", "E101", "bash", "json", "a\udcff", "(list", "[1 2", "z1")  # fmt: skip


@cache
def _options() -> dict[str, tuple[str, ...]]:
    from scenelang.cli.main import build_parser

    action = next(a for a in build_parser()._actions if isinstance(a, argparse._SubParsersAction))
    return {
        name: tuple(o for a in p._actions for o in a.option_strings if "open" not in o)
        for name, p in action.choices.items()
    }


def make_options(rng: making.Rng) -> bytes:
    command = rng.choice(COMMANDS)
    words = [command]
    if rng.random() < 0.8:
        words.append("prog.scene")
    for _ in range(rng.choice((0, 1, 2, 3))):
        words += (
            [rng.choice(_options()[command]), rng.choice(VALUES)][: rng.choice((1, 2))]
            if rng.random() < 0.7
            else [rng.choice(VALUES)]
        )
    return b"\0".join(word.encode("utf-8", "surrogateescape") for word in words)


def options(data: bytes) -> None:
    from scenelang.cli.main import main

    place = folder() / "options"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    (place / "prog.scene").write_text('(bind "dot" (lambda () (call "cube" z1)))\n(param n 3)\n')
    (place / "other.scene").write_text('(bind "dot" (lambda () (call "sphere")))\n')
    before = Path.cwd()
    out, errors = _Stream(), _Stream()
    os.chdir(place)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            try:
                code: Any = main([word.decode("utf-8", "surrogateescape") for word in data.split(b"\0")])
            except SystemExit as leaving:
                code = leaving.code
    finally:
        os.chdir(before)
    said = errors.getvalue()
    assert code in (0, 1, 2, None), code
    assert "internal error" not in said, said[-400:]
    assert "Traceback" not in said, said[-400:]
    assert " at 0x" not in said, said[-400:]
    assert code in (0, None) or said or out.getvalue(), "a failure that says nothing"


class _Stream(io.StringIO):
    """A stream of text with bytes below it, as standard output is."""

    def __init__(self) -> None:
        super().__init__()
        self.buffer = io.BytesIO()


# --- files -----------------------------------------------------------------------------------------------------------


def asset(ending: str) -> Callable[[bytes], None]:
    def check(data: bytes) -> None:
        from scenelang.backends.surfaces.assets import AssetFiles, load_asset

        path = written(f"a{ending}", data)
        with refusing():
            AssetFiles(folder(), folder(), False).measure(path.name)
        with refusing():
            load_asset(path, folder())

    return check


OBJ = b"mtllib a.mtl\no first\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1 1 0 0\nvt 0 0\nvt 1 0\nvn 0 0 1\nusemtl red\nf 1/1/1 2/2/1 3/1/1\nf 1 2 3 4\nf -1 -2 -3\ng b\nl 1 2\n"
PLY = b"ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n"
STL = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"


def stl_seeds() -> Sequence[bytes]:
    return (STL, b"\0" * 80 + struct.pack("<I", 2) + struct.pack("<12fH", *range(12), 0) * 2)


def ply_seeds() -> Sequence[bytes]:
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    return (PLY, head + struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) + struct.pack("<Biii", 3, 0, 1, 2))


@cache
def gltf_seeds() -> Sequence[Any]:
    return (json.loads(_exported(".gltf")), *_glb_parts()[:1])


@cache
def _glb_parts() -> tuple[Any, bytes]:
    data = _exported(".glb")
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[20 + length :]


EXPORTED = '(bind "b" (lambda (:n) (union (call "cube" :color [1 0 0]) (transform (call "sphere" :radius .2) (translate [1 n 0]))))) (bind "a" (lambda () (frames (list (call "b" :n 1) (call "b" :n 2)))))'


@cache
def _exported(ending: str) -> bytes:
    from scenelang.cli.main import main

    (folder() / "seed.scene").write_text(EXPORTED)
    out = folder() / f"seed{ending if ending != '.gltf' else '.glb'}"
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as errors:
        code = main(["export", str(folder() / "seed.scene"), "-o", str(out)])
    assert code == 0, errors.getvalue()
    if ending != ".gltf":
        return out.read_bytes()
    import base64

    document, rest = _glb_parts()
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(rest[8:]).decode()
    return json.dumps(document).encode()


def make_glb(rng: making.Rng) -> bytes:
    document, rest = _glb_parts()
    if rng.random() < 0.4:
        return making.mutated(_exported(".glb"), rng)
    chunk = making.json_like(lambda: (document,))(rng)
    chunk += b" " * (-len(chunk) % 4)
    body = struct.pack("<I", len(chunk)) + b"JSON" + chunk + rest
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


@cache
def scene_seeds() -> Sequence[Any]:
    return (json.loads(_exported(".json")),)


def scene_json(data: bytes) -> None:
    from scenelang.files.scene_json import read_scene

    path = written("a.json", data)
    with refusing():
        read_scene(path, folder())


@cache
def flattened_seeds() -> Sequence[Any]:
    from scenelang.cli.main import main

    _exported(".json")
    with contextlib.redirect_stdout(io.StringIO()) as out:
        main(["flatten", str(folder() / "seed.scene"), "--json"])
    return (json.loads(out.getvalue()),)


def flattened(data: bytes) -> None:
    from scenelang.interpreter.inspection.difference import compare_frames
    from scenelang.session.scene_changes import read_compared_frames

    path = written("a.json", data)
    with refusing():
        sheets = read_compared_frames(str(path), 10_000)
        for one in sheets[:2]:
            if len(one) < 100:
                compare_frames(one, sheets[0])


@cache
def z_seeds() -> Sequence[bytes]:
    import numpy as np
    from safetensors.numpy import save

    from scenelang.files.zfile import set_entry

    path = folder() / "seed.z.safetensors"
    set_entry(path, "z1", "an old oak", {"a": 1.5, "b": "x"})
    told = {"scenelang": json.dumps({"z1": {"text": "x", "attributes": {"a": 1}}})}
    return (path.read_bytes(), save({"z1": np.ones(4, np.float32)}, told), save({"z1": np.ones((2, 3), np.float32)}))


def make_z(rng: making.Rng) -> bytes:
    data = rng.choice(z_seeds())
    if rng.random() < 0.3:
        return making.mutated(data, rng)
    length = struct.unpack_from("<Q", data)[0]
    document = making.changed(json.loads(data[8 : 8 + length]), rng)
    meta = document.get("__metadata__") if isinstance(document, dict) else None
    if isinstance(meta, dict) and rng.random() < 0.7:
        for key, value in meta.items():
            with contextlib.suppress(ValueError, TypeError):
                meta[key] = json.dumps(making.changed(json.loads(value), rng))
    head = json.dumps(document).encode()
    return struct.pack("<Q", len(head)) + head + data[8 + length :]


def z_file(data: bytes) -> None:
    from scenelang.files import zfile
    from scenelang.learning import stored_words

    path = written("a.z.safetensors", data)
    for read in (zfile.read_z, stored_words.read_wording, zfile.read_made, stored_words.read_encodings):
        with refusing():
            read(path)
    with refusing():
        zfile.set_entry(path, "new", "text", {"a": 1})
    with refusing():
        zfile.swap_handles(path, "z1", "new")


CAMERA = {"format": "scenelang-camera/1", "projection": "perspective", "width": 64, "height": 48, "K": [[50, 0, 32], [0, 50, 24], [0, 0, 1]],
          "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]], "aperture": 0.1, "focus": 2}  # fmt: skip


def camera_seeds() -> Sequence[Any]:
    from scenelang.backends.pictures.camera import FORMAT

    return ({**CAMERA, "format": FORMAT}, {**CAMERA, "format": FORMAT, "projection": "orthographic"})


def camera(data: bytes) -> None:
    from scenelang.backends.pictures.camera import read_camera

    path = written("camera.json", data)
    with refusing():
        found = read_camera(path)
        found.resized(10, 10)


@cache
def build_seeds() -> dict[str, Sequence[bytes]]:
    import gzip

    import numpy as np
    from minecraft.builds import STATES, made

    from scenelang.backends.minecraft import build_files

    build = made((1, 2, 3), np.arange(24).reshape(2, 3, 4), STATES)
    found = {}
    for ending, write in (
        (".schem", build_files.write_schematic),
        (".litematic", build_files.write_litematic),
        (".nbt", build_files.write_structure),
    ):
        path = folder() / f"seed{ending}"
        write(build, path, build_files.game_version())
        found[ending] = (gzip.decompress(path.read_bytes()), path.read_bytes())
    return found


def build(ending: str) -> Callable[[bytes], None]:
    def check(data: bytes) -> None:
        from scenelang.backends.minecraft.export import read

        path = written(f"a{ending}", data)
        with refusing():
            read(path, 1_000_000)

    return check


@cache
def splat_seeds(ending: str) -> Sequence[bytes]:
    import torch

    from scenelang.backends.neural.splats import files

    if ending == ".splat":
        return (struct.pack("<6f8B", *range(1, 7), *range(8)) * 3,)
    names = [
        "x",
        "y",
        "z",
        "f_dc_0",
        "f_dc_1",
        "f_dc_2",
        "opacity",
        "scale_0",
        "scale_1",
        "scale_2",
        "rot_0",
        "rot_1",
        "rot_2",
        "rot_3",
    ]
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 2\n"
        + "".join(f"property float {n}\n" for n in names)
        + "end_header\n"
    )
    data = head.encode() + struct.pack("<14f", *(0.1 * i for i in range(14))) * 2
    files.from_ply(data)
    del torch
    return (data,)


def splats(ending: str) -> Callable[[bytes], None]:
    def check(data: bytes) -> None:
        from scenelang.backends.neural.splats.files import read_gaussians

        path = written(f"a{ending}", data)
        with refusing():
            read_gaussians(path)

    return check


CONFIG = b'[anthropic]\nbase_url = "https://models.invalid:8080/v1"\nmodel = "m"\n[openai]\nbase_url = "http://localhost:1"\nmax_tokens = 10\n[generate]\nmodel = "x"\n'


def config(data: bytes) -> None:
    from scenelang.backends.language_models import catalogue

    place = folder() / "config"
    (place / "scenelang").mkdir(parents=True, exist_ok=True)
    before = os.environ.get("XDG_CONFIG_HOME")
    os.environ["XDG_CONFIG_HOME"] = str(place)
    try:
        path = catalogue.config_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        path.chmod(0o600)
        with refusing():
            catalogue.load_config()
        for family in ("anthropic", "openai"):
            with refusing():
                catalogue.load_account(family, ["NO_SUCH_KEY"], "NO_SUCH_ADDRESS", "http://localhost:1", False)
    finally:
        if before is None:
            del os.environ["XDG_CONFIG_HOME"]
        else:
            os.environ["XDG_CONFIG_HOME"] = before


def run_seeds() -> Sequence[Any]:
    return (
        {"version": 1, "command": "generate", "task": "a chair", "settings": {"model": "m", "samples": 1}, "state": "done", "cost": 0.5, "started": "2026-01-01T00:00:00", "samples": 1, "best": 0},
        {"version": 1, "command": "edit", "task": "x", "settings": {}},
    )  # fmt: skip


def runs(data: bytes) -> None:
    """run.json of a run, and the same data as the files of its attempts."""
    from scenelang.inference.records import all_runs, settings_of

    place = folder() / "runs"
    run = place / "2026-01-01-a"
    attempt = run / "sample-1" / "01-generate"
    attempt.mkdir(parents=True, exist_ok=True)
    for path in (run / "run.json", attempt / "reply.json", attempt / "verdict.json", attempt / "sent.json"):
        path.write_bytes(data)
    for each in all_runs(place):
        with refusing():
            facts = each.facts
            with refusing():
                settings_of(facts.get("settings", {}) if isinstance(facts.get("settings", {}), dict) else {})
        with refusing():
            list(each.attempts())
        with refusing():
            _ = each.spent
        with refusing():
            _ = each.state
        with refusing():
            each.recorded(1, 1, "key")
    main_runs(place)


def main_runs(place: Path) -> None:
    from scenelang.cli.main import main

    for words in (["runs"], ["runs", "last"]):
        errors = io.StringIO()
        with contextlib.redirect_stdout(_Stream()), contextlib.redirect_stderr(errors):
            try:
                main([*words, "--runs", str(place)])
            except SystemExit:
                return
        assert "internal error" not in errors.getvalue(), errors.getvalue()[-300:]


def answers(data: bytes) -> None:
    """The JSON that a model answers with, made into a program."""
    from scenelang.inference.listing import program_of

    with refusing():
        program = program_of(text(data), "a task")
        assert Session(Options(limits=LIMITS)).check(Source("a.scene", program)).program is not None


ANSWER = (
    [
        {
            "word": "cube",
            "scale": [1, 2, 3],
            "color": [1, 0, 0],
            "matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
        },
        {"shape": "sphere", "radius": 1},
    ],
    {"frames": [[{"word": "cube"}]]},
)


def texts(rng: making.Rng) -> bytes:
    """Texts for the reader: programs with changes, tokens, bytes."""
    kind = rng.random()
    if kind < 0.5:
        return making.tokens(rng)
    if kind < 0.9:
        return making.mutated_text(making.program(rng).decode("utf-8", "replace"), rng).encode("utf-8", "replace")
    return making.mutated(making.program(rng), rng)


ALL = (
    Target("api", api_calls.make, api_calls.check, 20.0),
    Target("reader", texts, reader),
    Target("programs", making.program, programs, 8.0),
    Target("python", making.python, python),
    Target("repl", make_repl, repl, 10.0),
    Target("lsp", make_lsp, lsp_requests, 8.0),
    Target("options", make_options, options, 10.0),
    Target("gltf", making.json_like(gltf_seeds), asset(".gltf")),
    Target("glb", make_glb, asset(".glb")),
    Target("obj", making.file_like(lambda: (OBJ,)), asset(".obj")),
    Target("ply", making.file_like(ply_seeds), asset(".ply")),
    Target("stl", making.file_like(stl_seeds), asset(".stl")),
    Target("scene-json", making.json_like(scene_seeds), scene_json),
    Target("flattened-json", making.json_like(flattened_seeds), flattened),
    Target("z", make_z, z_file),
    Target("camera", making.json_like(camera_seeds), camera),
    Target("schem", making.file_like(lambda: build_seeds()[".schem"]), build(".schem")),
    Target("litematic", making.file_like(lambda: build_seeds()[".litematic"]), build(".litematic")),
    Target("nbt", making.file_like(lambda: build_seeds()[".nbt"]), build(".nbt")),
    Target("splat-ply", making.file_like(lambda: splat_seeds(".ply")), splats(".ply")),
    Target("splat", making.file_like(lambda: splat_seeds(".splat")), splats(".splat")),
    Target("config", making.file_like(lambda: (CONFIG,)), config),
    Target("runs", making.json_like(run_seeds), runs),
    Target("answers", making.json_like(lambda: ANSWER), answers),
)
