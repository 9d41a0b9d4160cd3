"""Models and textures of a build's blocks: the models of every state, and a texture atlas.

The sources are a jar or zip, a folder with the same layout, or npm's `minecraft-assets`. Their files are untrusted:
names are validated, sizes are limited, and nothing outside the source is opened.
"""

from __future__ import annotations

import io
import json
import math
import os
import re
import sys
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.deepslate.builds import WATER_TEXTURES, is_wet
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, load_table, variants
from scenelang.backends.minecraft.models import Bar, model_of
from scenelang.backends.pictures.film import png_of
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError

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
            return next((entry for each in look_ups if (entry := each(full)) is not None), None)

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
        entry = names.get(name)
        if entry is None:
            return None
        if entry.file_size > largest:
            raise _too_large(name, largest)
        with archive.open(entry) as file:
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
    folders = [at for at in data.iterdir() if number_of(at.name)] if data.is_dir() else []
    return sorted((at for at in folders if (at / "blocks_states.json").is_file()), key=lambda at: number_of(at.name))


def _npm(folder: Path) -> Layer:
    """Return a source with the layout of npm's `minecraft-assets`: one file for all states, one for all models."""
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


# --- sources of models and textures -----------------------------------------------------------------------------------


# Texture atlas of a build.


Pixels = npt.NDArray[np.uint8]  # (H, W, 4)
Place = tuple[int, int, int, int]

_MAX_SIDE = 4096  # of one texture, animation frames included
_MAX_FRAME = 1024
_MAX_ATLAS = 8192
_CLEAR, _SOLID = 26, 230  # alpha between these is translucent, as in stained glass, rather than an antialiased edge
_MIN_TRANSLUCENT = 0.03  # minimum fraction of such pixels in a translucent texture


@dataclass(frozen=True, slots=True, eq=False)
class Atlas:
    """A texture atlas; ``png`` is square, its side a power of two.

    ``places`` maps textures to left, top, right, bottom in pixels. ``translucent`` are the names of translucent
    textures.
    """

    png: bytes
    side: int
    places: Mapping[str, Place]
    translucent: frozenset[str]


def texture_from(png: bytes, name: str) -> Pixels:
    """Return the first frame of a texture, RGBA; raises SceneError("file") for invalid or too large images."""
    image_type = require("PIL.Image", "pillow")
    try:
        with image_type.open(io.BytesIO(png), formats=["PNG"]) as picture:
            width, height = picture.size
            if max(width, height) > _MAX_SIDE or width > _MAX_FRAME:
                raise SceneError("file", f"the texture `{name}` is too large: {width} x {height} pixels")
            pixels = np.asarray(picture.convert("RGBA"), np.uint8)
    except SceneError:
        raise
    except Exception as error:  # pillow raises various exceptions for damaged files
        raise SceneError("file", f"the texture `{name}` is not a valid image: {error}") from None
    is_film = height > width and height % width == 0 and not name.startswith("minecraft:entity/")
    return pixels[:width] if is_film or height > _MAX_FRAME else pixels


def atlas_of(textures: Mapping[str, Pixels]) -> Atlas:
    """Pack all ``textures`` into an atlas; raises LimitError if they do not fit."""
    order = sorted(textures, key=lambda name: (-textures[name].shape[0], name))
    side = _power_of_two(int(np.sqrt(sum(t.shape[0] * t.shape[1] for t in textures.values()) + 1.0)))
    side = max([side, *(_power_of_two(max(t.shape[:2])) for t in textures.values())])
    places = _pack_shelves(textures, order, side)
    while places is None:
        side *= 2
        places = _pack_shelves(textures, order, side)
    if side > _MAX_ATLAS:
        raise LimitError("size", f"the build's textures exceed the limit of {_MAX_ATLAS} x {_MAX_ATLAS} pixels")
    sheet = np.zeros((side, side, 4), np.uint8)
    for name, (left, top, right, bottom) in places.items():
        sheet[top:bottom, left:right] = textures[name]
    return Atlas(png_of(sheet), side, places, frozenset(_translucent(textures.items())))


def _pack_shelves(textures: Mapping[str, Pixels], order: Iterable[str], side: int) -> dict[str, Place] | None:
    """Pack textures in rows from the top, tallest first (shelf packing); returns None if they do not fit."""
    places: dict[str, Place] = {}
    x = y = row = 0
    for name in order:
        height, width = textures[name].shape[:2]
        if x + width > side:
            x, y, row = 0, y + row, 0
        row = max(row, height)
        if y + height > side:
            return None
        places[name] = (x, y, x + width, y + height)
        x += width
    return places


def _translucent(textures: Iterable[tuple[str, Any]]) -> Iterable[str]:
    for name, pixels in textures:
        alpha = pixels[:, :, 3]
        if ((alpha > _CLEAR) & (alpha < _SOLID)).mean() > _MIN_TRANSLUCENT:
            yield name


def _power_of_two(least: int) -> int:
    return 1 << max(4, (least - 1).bit_length())


# Models in the form that the page draws: parents merged, texture names resolved, numbers validated. The page trusts
# them, so malformed resource packs are rejected here: cycles of parents or of textures, unbounded boxes, invalid
# values.


Json = dict[str, Any]

_MAX_PARENTS = 32
_MAX_ELEMENTS = 2_000
_MAX_TEXTURES = 1_000
_MAX_COORDINATE = 1_000.0  # sixteenths of a block
_SIDES = ("down", "up", "north", "south", "west", "east")
_TURNS = (0, 90, 180, 270)
MISSING = "minecraft:missing"  # placeholder for a texture that no source contains


def flat_model(name: str, model: Callable[[str], Any]) -> Json | None:
    """Return the model ``name`` (full) with its parents merged: ``{"elements": [...]}`` with full texture names.

    None if no source contains it, or the ancestor with its boxes. Raises SceneError("file") for a malformed model.
    """
    textures: Json = {}
    elements: Any = None
    for ancestor in _ancestors(name, model):
        if ancestor is None:
            if elements is None:
                return None
            break
        given = ancestor.get("textures", {})
        for key, value in given.items() if isinstance(given, Mapping) else ():
            textures.setdefault(key, value)
        elements = ancestor.get("elements") if elements is None else elements
    elements = elements or []
    if len(textures) > _MAX_TEXTURES or not isinstance(elements, list) or len(elements) > _MAX_ELEMENTS:
        raise _wrong(name)
    try:
        return {"elements": [_element(each, textures) for each in elements]}
    except (TypeError, ValueError, KeyError, AttributeError, IndexError):
        raise _wrong(name) from None


def turn(value: Any) -> int:
    """Return the rotation of a whole model or face in degrees; raises ValueError if it is not a quarter turn."""
    if value not in _TURNS:
        raise ValueError(value)
    return int(value)


def textures_of(model: Json) -> Iterator[str]:
    """Yield the full names of the textures of a flat model."""
    for element in model["elements"]:
        for face in element["faces"].values():
            yield face["texture"]


def _wrong(name: str) -> SceneError:
    return SceneError("file", f"the model `{name}` of the resource pack is malformed")


def _ancestors(name: str, model: Callable[[str], Any]) -> Iterator[Json | None]:
    """Yield a model and its ancestors; None for one that no source contains."""
    required: str | None = name
    for _ in range(_MAX_PARENTS):
        if required is None:
            return
        ancestor = model(required)
        if ancestor is not None and not isinstance(ancestor, dict):
            raise _wrong(name)
        yield ancestor
        if ancestor is None:
            return
        required = full_name(ancestor.get("parent"))
    raise _wrong(name)


def _element(given: Json, textures: Json) -> Json:
    element: Json = {"from": _numbers(given["from"], 3), "to": _numbers(given["to"], 3)}
    element["faces"] = {side: _face(face, textures) for side, face in given["faces"].items() if side in _SIDES}
    if given.get("rotation"):
        element["rotation"] = _rotation(given["rotation"])
    return element


def _face(given: Json, textures: Json) -> Json:
    face: Json = {"texture": _texture(given["texture"], textures), "rotation": turn(given.get("rotation", 0))}
    if "uv" in given:
        face["uv"] = _numbers(given["uv"], 4)
    if given.get("cullface") in _SIDES:
        face["cullface"] = given["cullface"]
    if type(given.get("tintindex")) is int:
        face["tintindex"] = max(-1, min(given["tintindex"], 16))
    return face


def _texture(name: Any, textures: Json) -> str:
    for _ in range(_MAX_PARENTS):
        if isinstance(name, Mapping):
            name = name.get("sprite")
        if not isinstance(name, str):
            return MISSING
        key = name.removeprefix("#")
        if key not in textures:
            return MISSING if name.startswith("#") else full_name(name) or MISSING
        name = textures[key]
    return MISSING


def _rotation(given: Json) -> Json:
    """Return a rotation about one axis; of a rotation about several axes, the first."""
    axis, angle = given.get("axis"), given.get("angle", 0)
    if axis is None:
        axis, angle = next(((each, given[each]) for each in "xyz" if given.get(each)), ("y", 0))
    if axis not in ("x", "y", "z"):
        raise ValueError(axis)
    (angle,) = _numbers([angle], 1)
    origin = _numbers(given.get("origin", [8, 8, 8]), 3)
    return {"origin": origin, "axis": axis, "angle": angle, "rescale": given.get("rescale") is True}


def _numbers(given: Any, count: int) -> list[float]:
    numbers = [float(n) for n in given]
    if len(numbers) != count or not all(math.isfinite(n) and abs(n) <= _MAX_COORDINATE for n in numbers):
        raise ValueError(given)
    return numbers


# Fallback for blocks without a model: boxes of their average color, like those of the other renderers.


_FACES = {"west": (0, 0.0), "down": (1, 0.0), "north": (2, 0.0), "east": (0, 16.0), "up": (1, 16.0), "south": (2, 16.0)}
_SIDE = 16  # pixels


def plain_model(state: BlockState, texture: str) -> Json:
    """Return the flat model of ``state`` with ``texture`` on every face; without boxes for invisible blocks."""
    return {"elements": [_plain_element(bar, texture) for bar in model_of(state, load_table().blocks[state.name])]}


def plain_texture(state: BlockState) -> Pixels:
    """Return a uniform texture with the block's color and opacity."""
    kind = load_table().blocks[state.name]
    color = [*(kind.color or (0, 0, 0)), round(255 * kind.opacity)]
    return np.tile(np.array(color, np.uint8), (_SIDE, _SIDE, 1))


def _plain_element(bar: Bar, texture: str) -> Json:
    faces: dict[str, Json] = {side: {"texture": texture, "rotation": 0} for side in _FACES}
    for side, (axis, border) in _FACES.items():
        if bar.turn == 0.0 and (bar.low if border == 0.0 else bar.high)[axis] == border:
            faces[side]["cullface"] = side
    element: Json = {"from": list(bar.low), "to": list(bar.high), "faces": faces}
    if bar.turn:
        element["rotation"] = {"origin": [8.0, 8.0, 8.0], "axis": "y", "angle": bar.turn, "rescale": False}
    return element


_MAX_PARTS = 64  # models of one state
_MAX_NAMED = 8  # blocks listed in a warning
_PLAIN = "scenelang:plain"  # prefix of fallback models and textures, which are never looked up in a source


@dataclass(frozen=True, slots=True)
class BlockLook:
    """How a state is drawn.

    ``parts`` are its models ``{"model": name, "x": degrees, "y": degrees}``. ``is_special`` marks states that deepslate
    draws itself, such as chests, ``is_wet`` those surrounded by water.
    """

    parts: tuple[Json, ...]
    is_special: bool = False
    is_wet: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class BlockLooks:
    """Models and textures of a palette.

    ``states[n]`` is the look of state ``n``; ``models`` are by name, with parents merged. ``plain`` are the blocks that
    no source contains, drawn as boxes of their average color.
    """

    states: tuple[BlockLook, ...]
    models: dict[str, Json]
    atlas: Atlas
    plain: tuple[str, ...]

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """The warning that lists ``plain`` blocks, if any."""
        if not self.plain:
            return ()
        more = ", .." if len(self.plain) > _MAX_NAMED else ""
        shown = ", ".join(f"`{name}`" for name in self.plain[:_MAX_NAMED]) + more
        message = f"missing or incomplete models for {shown}; drawn as boxes of their average color"
        hint = "if you use a resource pack, install the game too, which provides the missing models"
        return (Diagnostic("plain-look", message, hint=hint),)


def looks_of(palette: Sequence[BlockState], layers: Sequence[Layer]) -> BlockLooks:
    """Return the models and textures of ``palette`` from ``layers``, in order of precedence.

    Raises SceneError("file") for unreadable content, or if the layers contain none of these blocks.
    """
    layer = stacked(layers)
    _check(palette, layer)
    models: dict[str, Json] = {}
    textures = {MISSING: _checkered()}
    looks, plain = [], set()
    for number, state in enumerate(palette):
        look = _look(state, layer, models)
        if look is None:
            name = f"{_PLAIN}/{number}"
            models[name], textures[name] = plain_model(state, name), plain_texture(state)
            look = BlockLook(({"model": name, "x": 0, "y": 0},), is_wet=is_wet(state))
            plain.add(state.name)
        looks.append(look)
    textures |= _textures(_required_textures(palette, looks, models) - textures.keys(), layer)
    return BlockLooks(tuple(looks), models, atlas_of(textures), tuple(sorted(plain)))


def _check(palette: Sequence[BlockState], layer: Layer) -> None:
    """Raise SceneError if ``layer`` contains none of the blocks."""
    names = sorted({state.name for state in palette} - {AIR_STATE.name})
    if names and all(layer.definition(name) is None for name in names):
        raise SceneError("file", f"{layer.name} contains none of the build's blocks ({names[0]})", hint=HINT)


def _look(state: BlockState, layer: Layer, models: dict[str, Json]) -> BlockLook | None:
    """Return the look of a state and add its models to ``models``; None if the layer cannot draw it."""
    parts = _parts(state, layer)
    models_by_name = {part["model"]: flat_model(part["model"], layer.model) for part in parts or ()}
    is_special = any(layer.picture(name) is not None for name in _special(state))
    if not (is_special or _is_invisible(state) or _is_whole(models_by_name, state, layer)):
        return None
    models |= {name: model for name, model in models_by_name.items() if model is not None}
    return BlockLook(tuple(part for part in parts or () if part["model"] in models), is_special, is_wet(state))


def _is_invisible(state: BlockState) -> bool:
    """Whether the block is invisible, such as air or barriers."""
    return load_table().blocks[state.name].color is None


def _is_whole(models_by_name: Mapping[str, Json | None], state: BlockState, layer: Layer) -> bool:
    """Whether no model is missing and some state has visible elements, even if this one is empty.

    For example, the upper half of a young plant is empty.
    """
    if None in models_by_name.values():
        return False
    others = (part["model"] for part in _parts(state, layer, every=True) or ())
    models = (*models_by_name.values(), *(flat_model(name, layer.model) for name in dict.fromkeys(others)))
    return any(model is not None and model["elements"] for model in models)


def _parts(state: BlockState, layer: Layer, *, every: bool = False) -> tuple[Json, ...] | None:
    """Return the models of a state, with ``every`` those of all states of its block; None if the layer lacks the
    block."""
    definition = layer.definition(state.name)
    if definition is None:
        return None
    try:
        parts = [_part(variant) for variant in variants(definition, dict(state.properties), every)]
    except (TypeError, ValueError, KeyError, AttributeError, IndexError, RecursionError):
        raise SceneError("file", f"the definition of `{state.name}` in the resource pack is malformed") from None
    return tuple(parts[:_MAX_PARTS])


def _part(variant: Any) -> Json:
    name = full_name(variant["model"])
    if name is None:
        raise ValueError(variant["model"])
    return {"model": name, "x": turn(variant.get("x", 0)), "y": turn(variant.get("y", 0))}


@cache
def _special_textures() -> dict[str, list[str]]:
    """Return the textures of blocks that deepslate draws without a model (chests, signs, beds), by block."""
    text = files(__package__).joinpath("static", "special.json").read_text("utf-8")
    return dict(json.loads(text))


def _special(state: BlockState) -> frozenset[str]:
    """Return the textures with which deepslate draws a state itself, without the surrounding water."""
    own = frozenset(_special_textures().get(state.name, ()))
    return own - frozenset(WATER_TEXTURES) if is_wet(state) else own


# --- textures ------------------------------------------------------------------------------------------------------


def _required_textures(
    palette: Sequence[BlockState], looks: Sequence[BlockLook], models: Mapping[str, Json]
) -> set[str]:
    """Return the full names of all required textures."""
    required = {name for model in models.values() for name in textures_of(model)}
    for state, look in zip(palette, looks, strict=True):
        required |= _special(state) if look.is_special else set()
        required |= set(WATER_TEXTURES) if look.is_wet else set()
    return required


def _textures(names: Iterable[str], layer: Layer) -> dict[str, Pixels]:
    """Return those textures that the layer contains."""
    pictures = ((name, layer.picture(name)) for name in sorted(names))
    return {name: texture_from(png, name) for name, png in pictures if png is not None}


def _checkered() -> Pixels:
    """Return the game's placeholder for a missing texture."""
    squares = (np.indices((16, 16)) // 8).sum(axis=0) % 2
    return np.asarray(np.array([[248, 0, 248, 255], [0, 0, 0, 255]])[squares], np.uint8)
