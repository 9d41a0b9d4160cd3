"""Packs what the playground runs: the interpreter's modules, the packages of its language server, and the examples."""

from __future__ import annotations

import ast
import io
import json
import sys
import zipfile
from collections.abc import Iterable, Iterator
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path

ROOT = "scenelang.playground.in_browser"
# Modules that are imported by name: topics of builtins, and services.
NAMED = (
    "scenelang.lsp.channel", "scenelang.stdlib", "scenelang.interpreter.scene.primitives", "scenelang.grammar.tables",
    "scenelang.backends.minecraft.models", "scenelang.backends.exports.gltf", "scenelang.repairs.instance_edits",
)  # fmt: skip
# Domains that the playground does without; a program that needs one gets a diagnostic.
WITHOUT = (
    "api", "scene", "cli", "doctor", "console", "bench", "blender", "datasets", "evaluation", "inference", "learning",
    "mcp", "notebook", "repairs.repairing", "repl", "translation", "viewer.server",
    "backends.blender", "backends.deepslate", "backends.geometry", "backends.labels", "backends.language_models",
    "backends.mitsuba_export", "backends.neural", "backends.openscad", "backends.physics", "backends.pictures.draft",
    "backends.pictures.draft_painter", "backends.pictures.mitsuba", "backends.pictures.motion_blur",
    "backends.minecraft.export", "interpreter.lift", "interpreter.transpile",
    "grammar.export",
)  # fmt: skip
PACKAGES = ("pygls", "lsprotocol", "cattrs", "attr", "attrs", "typing_extensions", "fontTools")
_EXCLUDED = tuple(f"scenelang.{name}" for name in WITHOUT)
# Of fontTools what reads the outlines of the font that the language comes with; the rest is 9 of 10 parts.
_FONT_TOOLS = {
    "": "__init__ agl unicode",
    "config": "__init__",
    "encodings": "__init__ codecs",
    "misc": "__init__ arrayTools bezierTools configTools cython encodingTools filenames fixedTools loggingTools "
    "psCharStrings roundTools sstruct textTools timeTools transform vector xmlWriter",
    "pens": "__init__ basePen filterPen pointPen recordingPen transformPen",
    "ttLib": "__init__ sfnt standardGlyphOrder ttCollection ttFont ttGlyphSet",
    "ttLib/tables": "__init__ D_S_I_G_ DefaultTable _c_m_a_p _g_l_y_f _h_e_a_d _h_h_e_a _h_m_t_x _l_o_c_a _m_a_x_p "
    "_p_o_s_t ttProgram",
}


def write_archives(folder: Path) -> None:
    """Write the sources that the worker puts on its module path: the interpreter's, and those of other packages.

    The build of the page replaces both by compiled code, which it compresses as a whole (``build.mjs``).
    """
    _write_zip(folder / "scenelang.zip", _interpreter())
    _write_zip(folder / "packages.zip", (entry for package in PACKAGES for entry in _package(package)))


def _write_zip(path: Path, entries: Iterable[tuple[str, bytes]]) -> None:
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for name, content in sorted(entries):
            archive.writestr(zipfile.ZipInfo(name), content)
    path.write_bytes(data.getvalue())


def _interpreter() -> Iterator[tuple[str, bytes]]:
    """Yield the names and contents of our own files."""
    for name, file in modules().items():
        place = name.replace(".", "/") + ("/__init__.py" if file.name == "__init__.py" else ".py")
        yield place, file.read_bytes()
    here = Path(__file__).parent
    for file in sorted((here / "numpy").glob("*.py")):
        yield f"numpy/{file.name}", file.read_bytes()
    yield "manifold3d.py", (here / "manifold3d.py").read_bytes()
    yield from _data_files()
    points = distribution("scenelang").read_text("entry_points.txt") or ""
    yield "scenelang-0.dist-info/entry_points.txt", points.encode()
    version = distribution("manifold3d").version
    yield "manifold3d-0.dist-info/METADATA", f"Metadata-Version: 2.1\nName: manifold3d\nVersion: {version}\n".encode()


def modules() -> dict[str, Path]:
    """Return the files of the modules that the worker may import, by name: what the imports of each lead to."""
    files: dict[str, Path] = {}
    pending = [ROOT, *NAMED]
    while pending:
        name = pending.pop()
        file = None if name in files or _is_excluded(name) else _file(name)
        if file is None:
            continue
        files[name] = file
        pending += [name.rpartition(".")[0], *_imports(file)]
        if name in NAMED and file.name == "__init__.py":
            pending += [f"{name}.{each.stem}" for each in file.parent.glob("*.py") if each.stem != "__init__"]
    return dict(sorted(files.items()))


def _is_excluded(name: str) -> bool:
    return any(name == each or name.startswith(f"{each}.") for each in _EXCLUDED)


def _file(name: str) -> Path | None:
    """Return the file of one of our modules, None for another name."""
    if not name.startswith("scenelang"):
        return None
    try:
        spec = find_spec(name)
    except (ImportError, AttributeError, ValueError):  # an attribute of a module
        return None
    return Path(spec.origin) if spec is not None and spec.origin is not None else None


def _imports(file: Path) -> Iterator[str]:
    """Yield the names that a module imports from our package, at any place of the file."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _data_files() -> Iterator[tuple[str, bytes]]:
    """Yield the data that our modules read: the prelude, the parts, fonts, and descriptions of backends."""
    import scenelang.backends
    import scenelang.interpreter.scene.modelling
    import scenelang.stdlib

    std = Path(scenelang.stdlib.__file__).parent
    for file in sorted([*std.glob("*.scene"), *std.glob("parts/**/*.scene")]):
        yield f"scenelang/stdlib/{file.relative_to(std)}", file.read_bytes()
    backends = Path(scenelang.backends.__file__).parent
    yield "scenelang/backends/descriptions.json", (backends / "descriptions.json").read_bytes()
    for file in sorted((backends / "minecraft").glob("*.tsv.gz")):
        yield f"scenelang/backends/minecraft/{file.name}", file.read_bytes()
    modelling = Path(scenelang.interpreter.scene.modelling.__file__).parent
    for file in sorted(modelling.glob("fonts/*")):
        if file.is_file():
            yield f"scenelang/interpreter/scene/modelling/fonts/{file.name}", file.read_bytes()


def _package(name: str) -> Iterator[tuple[str, bytes]]:
    """Yield the modules of an installed package in plain Python."""
    spec = find_spec(name)
    assert spec is not None, f"{name} is not installed"
    origin = Path(spec.origin or "")
    if origin.name != "__init__.py":
        yield origin.name, origin.read_bytes()
        return
    for file in sorted(origin.parent.rglob("*.py")):
        place = file.relative_to(origin.parent)
        folder = str(place.parent).removeprefix(".")
        if name != "fontTools" or place.stem in _FONT_TOOLS.get(folder, "").split():
            yield f"{name}/{place}", file.read_bytes()


def write_examples(path: Path, folder: Path) -> None:
    """Write the example programs of a folder, by name, with the first line of comment of each as its title."""
    examples = []
    for file in sorted(folder.rglob("*.scene")):
        text = file.read_text(encoding="utf-8")
        title = text.lstrip("; ").partition("\n")[0].strip()
        examples.append({"name": str(file.relative_to(folder)), "title": title[:90], "text": text})
    path.write_text(json.dumps(examples), encoding="utf-8")


if __name__ == "__main__":
    out = Path(sys.argv[1])
    write_archives(out)
    write_examples(out / "examples.json", Path(sys.argv[2]))
