"""Sources of models and textures: a jar or zip, a folder with the same layout, or npm's `minecraft-assets`.

The files are untrusted: names are validated, sizes are limited, and nothing outside the source is opened.
"""

from __future__ import annotations

import json
import os
import re
import sys
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from scenelang.grammar.diagnostics import SceneError

_MAX_JSON = 1_000_000  # bytes
_MAX_LIST = 64_000_000  # bytes of the file with all models of a version
MAX_PICTURE_BYTES = 8_000_000
_MAX_FILES = 500_000  # in a zip
_ASSETS = "assets"
_IDENTIFIER = re.compile(r"(?:([a-z0-9_.-]+):)?([a-z0-9_.-]+(?:/[a-z0-9_.-]+)*)")
_NPM_FOLDERS = {"block": "blocks", "item": "items"}


@dataclass(frozen=True, slots=True)
class Layer:
    """A source of models and textures.

    Each function takes a full name, ``minecraft:block/stone``, and returns None if the source does not contain it; they
    raise SceneError("file") for unreadable content.
    """

    name: str
    definition: Callable[[str], Any]
    model: Callable[[str], Any]
    picture: Callable[[str], bytes | None]


def full_name(name: Any) -> str | None:
    """Return ``name`` with its namespace, None if it is not a valid identifier, such as a path outside its folder."""
    match = _IDENTIFIER.fullmatch(name) if isinstance(name, str) and len(name) < 300 else None
    if match is None or any(set(part) <= {"."} for part in (match[1] or "_", *match[2].split("/"))):
        return None
    return f"{match[1] or 'minecraft'}:{match[2]}"


def layer_at(path: Path) -> Layer:
    """Return the source in the jar, zip or folder ``path``; raises SceneError("file") if it contains no textures."""
    try:
        if path.is_file():
            return _zipped(path)
        if path.is_dir():
            folder = next((at for at in (path, path / "minecraft-assets", path / "data") if _versions(at)), None)
            if (path / "blocks_states.json").is_file():
                return _npm(path)
            if folder is not None:
                return _npm(_versions(folder)[-1])
            if (path / _ASSETS).is_dir():
                return _packed(str(path), _within(path))
            raise _none_at(path)
    except (OSError, zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
        raise SceneError("file", f"cannot read the textures in `{path}`: {error}") from error
    raise SceneError("file", f"the texture path `{path}` does not exist")


def stacked(layers: Sequence[Layer]) -> Layer:
    """Combine ``layers`` into one with cached lookups; the first that contains something is used."""

    def first(look_ups: Sequence[Callable[[str], Any]]) -> Callable[[str], Any]:
        @cache
        def look_up(full: str) -> Any:
            return next((found for each in look_ups if (found := each(full)) is not None), None)

        return look_up

    return Layer(
        ", ".join(f"`{layer.name}`" for layer in layers),
        first([layer.definition for layer in layers]),
        first([layer.model for layer in layers]),
        first([layer.picture for layer in layers]),
    )


def number_of(version: str) -> tuple[int, ...]:
    """Return a version such as ``1.21.4`` as sortable numbers, empty if it is not a version number."""
    return tuple(int(n) for n in version.split(".")) if re.fullmatch(r"\d{1,6}(\.\d{1,6}){1,3}", version) else ()


def _none_at(path: Path) -> SceneError:
    return SceneError(
        "file",
        f"`{path}` contains no Minecraft textures",
        hint="use the game's jar, a resource pack (.zip or folder), or the folder of npm's minecraft-assets",
    )


# --- jars and resource packs ---------------------------------------------------------------------------------------


def _zipped(path: Path) -> Layer:
    if not zipfile.is_zipfile(path):
        raise _none_at(path)
    archive = zipfile.ZipFile(path)
    names = archive.NameToInfo
    if len(names) > _MAX_FILES or not any(name.startswith(f"{_ASSETS}/") for name in names):
        raise _none_at(path)

    def read(name: str, largest: int) -> bytes | None:
        found = names.get(name)
        if found is None:
            return None
        if found.file_size > largest:
            raise _too_large(name, largest)
        with archive.open(found) as file:
            return _bounded(file.read(largest + 1), name, largest)

    return _packed(str(path), read)


def _within(folder: Path) -> Callable[[str, int], bytes | None]:
    root = folder.resolve()

    def read(name: str, largest: int) -> bytes | None:
        path = (root / name).resolve()
        if not path.is_relative_to(root) or not path.is_file():  # a symbolic link may lead outside
            return None
        with path.open("rb") as file:
            return _bounded(file.read(largest + 1), name, largest)

    return read


def _packed(name: str, read: Callable[[str, int], bytes | None]) -> Layer:
    """Return a source with the layout of the game's jar and of resource packs."""

    def data(folder: str) -> Callable[[str], Any]:
        def look_up(full: str) -> Any:
            file = _place(full, folder, ".json")
            text = _guarded(read, file, _MAX_JSON, name)
            return None if text is None else _json(text, file)

        return look_up

    def picture(full: str) -> bytes | None:
        return _guarded(read, _place(full, "textures", ".png"), MAX_PICTURE_BYTES, name)

    return Layer(name, data("blockstates"), data("models"), picture)


def _place(full: str, folder: str, ending: str) -> str:
    space, _, path = full.partition(":")
    return f"{_ASSETS}/{space}/{folder}/{path}{ending}"


# --- npm's minecraft-assets ----------------------------------------------------------------------------------------


def _versions(folder: Path) -> list[Path]:
    """Return the version folders of `minecraft-assets`, newest last."""
    data = folder if folder.name == "data" else folder / "minecraft-assets" / "data"
    if not data.is_dir():
        data = folder / "data"
    found = [at for at in data.iterdir() if number_of(at.name)] if data.is_dir() else []
    return sorted((at for at in found if (at / "blocks_states.json").is_file()), key=lambda at: number_of(at.name))


def _npm(folder: Path) -> Layer:
    read = _within(folder)

    @cache
    def listed(file: str) -> Mapping[str, Any]:
        text = _guarded(read, file, _MAX_LIST, str(folder))
        data = None if text is None else _json(text, file)
        return data if isinstance(data, dict) else {}

    def definition(full: str) -> Any:
        return listed("blocks_states.json").get(full.removeprefix("minecraft:"))

    def model(full: str) -> Any:
        return listed("blocks_models.json").get(full.removeprefix("minecraft:").removeprefix("block/"))

    def picture(full: str) -> bytes | None:
        top, _, rest = full.removeprefix("minecraft:").partition("/")
        return _guarded(read, f"{_NPM_FOLDERS.get(top, top)}/{rest}.png", MAX_PICTURE_BYTES, str(folder))

    return Layer(str(folder), definition, model, picture)


# --- reading -------------------------------------------------------------------------------------------------------


def _guarded(read: Callable[[str, int], bytes | None], name: str, largest: int, place: str) -> bytes | None:
    try:
        return read(name, largest)
    except SceneError:
        raise
    except Exception as error:  # zipfile and zlib raise various exceptions for damaged archives
        raise SceneError("file", f"cannot read `{name}` in `{place}`: {error}") from error


def _bounded(data: bytes, name: str, largest: int) -> bytes:
    if len(data) > largest:
        raise _too_large(name, largest)
    return data


def _too_large(name: str, largest: int) -> SceneError:
    return SceneError("file", f"`{name}` is larger than the limit of {largest:,} bytes")


def _json(text: bytes, name: str) -> Any:
    try:
        return json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise SceneError("file", f"`{name}` is not valid JSON: {error}") from None


# Location of the game's files on this machine: set by the user, else the default locations.


VARIABLE = "SCENELANG_MINECRAFT"
_PACKAGE = Path("node_modules/minecraft-assets")
HINT = (
    "install the game and start it once, or use `--textures PATH` with its jar, a resource pack, or the folder of "
    "npm's minecraft-assets"
)


def layers_for(given: str) -> tuple[Layer, ...]:
    """Return the sources of models and textures, in order of precedence; raises SceneError("file") if there are none.

    ``given`` (if empty, the environment variable) comes first, then a default location, since a resource pack may be
    incomplete.
    """
    named = given or os.environ.get(VARIABLE, "")
    layers = [layer_at(Path(named).expanduser())] if named else []
    default = next(_default_locations(), None)
    if default is not None:
        layers.append(layer_at(default))
    if not layers:
        raise SceneError("file", "Minecraft's textures were not found on this machine", hint=HINT)
    return tuple(layers)


def _default_locations() -> Iterator[Path]:
    """Yield existing default locations, the newest version of the game first."""
    jars = [path for path in (_game() / "versions").glob("*/*.jar") if path.is_file()]
    yield from sorted(jars, key=lambda path: number_of(path.stem), reverse=True)
    for folder in (Path.cwd(), Path.home()):
        if (folder / _PACKAGE).is_dir():
            yield folder / _PACKAGE


def _game() -> Path:
    """Return the game's folder."""
    if sys.platform == "win32":
        return Path(os.environ.get("APPDATA", "~")).expanduser() / ".minecraft"
    if sys.platform == "darwin":
        return Path.home() / "Library/Application Support/minecraft"
    return Path.home() / ".minecraft"
