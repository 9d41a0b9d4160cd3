"""Export to JSON: the entity DAG, each entity once, in a documented schema that ``read_scene`` reads back."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from scenelang.backends.base import Accepts, Backend, BackendOptions, Work, check_settings, frame_of
from scenelang.backends.files import atomic_write, read_regular, reason_of
from scenelang.backends.surfaces.assets import AssetFiles
from scenelang.backends.unreadable import unreadable
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.show import NotPlain, plain_value, value_of
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.modelling.operations import from_plain, to_plain
from scenelang.interpreter.scene.modelling.solid import SolidShape
from scenelang.interpreter.scene.primitives import Primitive, class_of, former_word, word_of_today
from scenelang.interpreter.scene.setup import is_panorama, setup_of_plain
from scenelang.interpreter.values.values import Embedding, Matrix, Pair

FORMAT = "scenelang-scene"
VERSION = 1
_AXES = "right-handed: x right, y up, z towards the viewer; poses are the upper three rows of 4x4 matrices, row by row"


def write_scene(scene: Scene, path: Path | str) -> None:
    """Write ``scene`` to ``path`` atomically; raises SceneError("file")."""
    with atomic_write(path) as temporary, temporary.open("w", encoding="ascii", newline="\n") as file:
        file.writelines(scene_text(scene, Path(path).resolve().parent))


def scene_text(scene: Scene, folder: Path) -> Iterator[str]:
    """Yield the pieces of the JSON document of a scene.

    Each entity is on a line of its own, children before parents. Paths of mesh files are relative to ``folder``.
    """
    head: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "word": scene.word,
        "animated": scene.animated,
        "axes": _AXES,
    }
    if scene.setup:
        head["setup"] = [_with_name(item.to_plain(), lambda path: _relative(path, folder)) for item in scene.setup]
    yield json.dumps(head)[:-1] + ',\n"entities": ['
    numbers: dict[int, int] = {}
    for entity in descendants(*scene.frames):
        yield "," if numbers else ""
        numbers[id(entity)] = len(numbers)
        yield "\n" + json.dumps(_entity(entity, numbers, folder), separators=(",", ":"), allow_nan=False)
    yield '\n],\n"frames": ' + json.dumps([numbers[id(root)] for root in scene.frames]) + "}\n"


def _entity(entity: Entity, numbers: dict[int, int], folder: Path) -> dict[str, Any]:
    """Return an entity as JSON data; absent properties are omitted. Raises SceneError for what a section left."""
    embedding = entity.embedding
    record: dict[str, Any] = {"word": entity.word}
    if entity.shape is not None and entity.shape.is_remnant:
        message = f'"{entity.word}" is what a section left of a surface, which JSON does not describe'
        raise SceneError("unsupported", message, hint="export a mesh, such as .glb or .obj")
    if entity.is_primitive:
        record["primitive"] = True
    if embedding.handle is not None:
        record["handle"] = embedding.handle
    if embedding.text is not None:
        record["text"] = embedding.text
    attributes = _attributes(entity)
    if attributes:
        record["attributes"] = attributes
    file = getattr(entity.shape, "file", None)
    if file is not None:
        record["file"] = _relative(file, folder)
    if isinstance(entity.shape, SolidShape):
        record["solid"] = to_plain(entity.shape.expression, lambda path: _relative(path, folder))
    if entity.children:
        record["children"] = [[numbers[id(part.car)], list(part.cdr)] for part in entity.children]
    return record


def _attributes(entity: Entity) -> dict[str, Any]:
    """Return the attributes as tagged plain data; other values (functions, entities) are omitted."""
    attributes: dict[str, Any] = {}
    for name, value in entity.embedding.attributes.items():
        try:
            attributes[name] = plain_value(value, tagged=True)
        except NotPlain:
            continue
    return attributes


def _with_name(declared: Any, path_of: Callable[[str], str]) -> Any:
    """Return a declaration as JSON data with another path of its panorama, if it has one."""
    if not isinstance(declared, dict) or not is_panorama(declared.get("name")):
        return declared
    return {**declared, "name": path_of(declared["name"])}


def _relative(file: str, folder: Path) -> str:
    """Return the path of a mesh file, relative to ``folder`` if it is inside it."""
    target = Path(file).resolve()
    return target.relative_to(folder).as_posix() if target.is_relative_to(folder) else os.fspath(target)


def _run(scene: Scene, path: Path, options: BackendOptions) -> None:
    check_settings(options, [JSON])
    if options.frame is not None:
        scene = scene.with_frames([scene.frames[frame_of(scene, options.frame)]], False)
    write_scene(scene, path)


JSON = Backend(
    "json",
    "JSON of the entity graph, which can be read back",
    Work.EXPORT,
    (".json",),
    _run,
    accepts=Accepts(animated=True),
)


def holds_scene(path: Path | str) -> bool:
    """Return whether a JSON file starts like those that ``write_scene`` writes."""
    try:
        with open(path, "rb") as file:
            return f'"format": "{FORMAT}"'.encode() in file.read(200)
    except OSError:
        return False


# Reading scenes from JSON. The file may come from anywhere: nothing in it is trusted.


# Limits of a file, which is read and parsed as a whole, so that it cannot fill the memory.
MAX_FILE_BYTES = 256_000_000
MAX_ENTITIES = 1_000_000
MAX_PARTS = 5_000_000  # children of all entities together; entities are shared


def read_scene(path: Path | str, project: Path | None = None, allow_outside: bool = False) -> Scene:
    """Read a scene from a file written by ``write_scene``.

    Parameters
    ----------
    path : Path or str
    project : Path, optional
        Directory that must contain the mesh files it refers to; by default the file's own.
    allow_outside : bool
        Allow mesh files outside ``project``.

    Raises
    ------
    SceneError
        "file" if the file cannot be read or is not a scene, "import-outside" for mesh files outside ``project``,
        "attribute" for invalid geometry attributes.
    LimitError
        "size" if the file is too large.
    """
    path = Path(path)
    data = _parsed(path)
    reader = _Reader(path, AssetFiles(path.parent, (project or path.parent).resolve(), allow_outside))
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        reader.fail(f'missing "format": "{FORMAT}"')
    if data.get("version") != VERSION:
        reader.fail(f"unsupported version {str(data.get('version'))[:20]}, expected {VERSION}")
    word = reader.text(data.get("word"), "the word of the scene")
    listed = data.get("entities")
    if not isinstance(listed, list):
        reader.fail('"entities" must be a list')
    if len(listed) > MAX_ENTITIES:
        raise LimitError("size", f"{path.name} has {len(listed):,} entities, more than the limit of {MAX_ENTITIES:,}")
    entities: list[Entity] = []
    for fields in listed:
        entities.append(reader.entity(fields, entities))
    frames = data.get("frames")
    if not isinstance(frames, list) or not frames:
        reader.fail('"frames" must be a non-empty list of entity indices')
    roots = [entities[reader.index(frame, len(entities), "a frame")] for frame in frames]
    animated = data.get("animated", len(roots) > 1)
    if not isinstance(animated, bool) or (len(roots) > 1 and not animated):
        reader.fail('"animated" must be true for several frames')
    try:
        listed = data.get("setup", [])
        is_list = isinstance(listed, list)
        setup = setup_of_plain([_with_name(item, reader.assets.image) for item in listed] if is_list else listed)
    except SceneError as error:
        reader.fail(f'"setup": {error.message}')
    return Scene(word, roots, animated, (), setup)


def _parsed(path: Path) -> Any:
    """Parse a file within its limits; raises SceneError."""
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise LimitError("size", f"{path.name} is larger than the limit of {MAX_FILE_BYTES:,} bytes")
        text = read_regular(path).decode("utf-8")
    except OSError as error:
        raise unreadable(str(path), str(path), reason_of(error)) from None
    except UnicodeDecodeError:
        raise SceneError("encoding", f"{path.name} is not UTF-8 text") from None
    try:
        return json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise SceneError("file", f"{path.name} is not valid JSON: {reason[:120]}") from None


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not a valid number")


@dataclass(slots=True)
class _Reader:
    """Creates entities from their JSON fields; ``parts`` counts the parts created so far."""

    path: Path
    assets: AssetFiles
    parts: int = 0

    def fail(self, what: str) -> NoReturn:
        """Raise the error that the file is not a valid scene."""
        raise SceneError("file", f"{self.path.name} is not a valid scene: {what}")

    def text(self, value: Any, what: str) -> str:
        """Return ``value`` if it is a string, else fail."""
        if not isinstance(value, str):
            self.fail(f"{what} must be a string")
        return value

    def index(self, value: Any, count: int, what: str) -> int:
        """Return ``value`` if it is an index below ``count``, else fail."""
        if type(value) is not int or not 0 <= value < count:
            self.fail(f"{what} must be the index of an earlier entity, not {str(value)[:20]}")
        return value

    def entity(self, fields: Any, earlier: Sequence[Entity]) -> Entity:
        """Return the next entity; its children must come before it, which rules out cycles.

        Parameters
        ----------
        fields
            JSON object of the entity.
        earlier
            Entities before it in the file, which its children refer to by index.

        Raises
        ------
        SceneError
            "file" if a field is missing or malformed, and the errors of its attributes and mesh file.
        LimitError
            "size" if the file has too many parts.
        """
        where = f"entity {len(earlier)}"
        if not isinstance(fields, dict):
            self.fail(f"{where} must be an object")
        word = self.text(fields.get("word"), f"the word of {where}")
        handle = self._optional_text(fields.get("handle"), f"the handle of {where}")
        text = self._optional_text(fields.get("text"), f"the text of {where}")
        attributes = self._attributes(fields.get("attributes", {}), where)
        children = self._children(fields.get("children", []), earlier, where)
        shape = None
        if fields.get("primitive", False) is True:
            if children:
                self.fail(f"{where} is a primitive but has children")
            shape = self._shape(word, attributes, fields, where)
        return Entity(word, Embedding(handle, text, attributes), children, shape)

    def _optional_text(self, value: Any, what: str) -> str | None:
        """Return ``value`` if it is a string or None, else fail."""
        return None if value is None else self.text(value, what)

    def _attributes(self, given: Any, where: str) -> dict[str, Any]:
        if not isinstance(given, dict):
            self.fail(f"the attributes of {where} must be an object")
        try:
            return {name: value_of(value) for name, value in given.items()}
        except (ValueError, TypeError, AttributeError, OverflowError, SceneError, RecursionError):
            self.fail(f"an attribute of {where} is malformed")

    def _children(self, given: Any, earlier: Sequence[Entity], where: str) -> tuple[Pair, ...]:
        if not isinstance(given, list):
            self.fail(f"the children of {where} must be a list")
        self.parts += len(given)
        if self.parts > MAX_PARTS:
            raise LimitError("size", f"{self.path.name} has more than the limit of {MAX_PARTS:,} parts")
        return tuple(self._part(part, earlier, where) for part in given)

    def _part(self, part: Any, earlier: Sequence[Entity], where: str) -> Pair:
        """Parse a part: an index of an earlier entity, and a pose."""
        if not isinstance(part, list) or len(part) != 2:
            self.fail(f"a child of {where} must be a pair of an index and a pose")
        number, pose = part
        child = earlier[self.index(number, len(earlier), f"a child of {where}")]
        if not isinstance(pose, list) or len(pose) != 12 or not all(type(x) in (int, float) for x in pose):
            self.fail(f"the pose of a child of {where} must be 12 numbers")
        try:
            matrix = Matrix(map(float, pose))
        except OverflowError:
            self.fail(f"the pose of a child of {where} is not finite")
        if not all(map(math.isfinite, matrix)):
            self.fail(f"the pose of a child of {where} is not finite")
        return Pair(child, matrix)

    def _shape(self, word: str, attributes: dict[str, Any], fields: dict[str, Any], where: str) -> Primitive:
        if "solid" in fields:
            return self._solid(fields["solid"], attributes, where)
        return self._plain_shape(word, attributes, fields.get("file"), where)

    def _plain_shape(self, word: str, attributes: dict[str, Any], file: Any, where: str) -> Primitive:
        today = word_of_today(word, () if file is None else ("file",))
        if today is not None:
            self.fail(f"in {where}, {former_word(word, today)}")
        cls = class_of(word)
        if not cls.is_file:
            return cls.from_attributes(word, attributes)
        asset = self.assets.measure(self.text(file, f"the file of {where}"))
        return cls.from_attributes(word, {**attributes, "file": asset.path}, asset)

    def _solid(self, records: Any, attributes: dict[str, Any], where: str) -> Primitive:
        def leaf(word: str, given: Any, file: Any) -> Primitive:
            """Create an operand that is not a solid itself."""
            own_attributes = {str(name): value_of(value) for name, value in given.items() if value is not None}
            return self._plain_shape(word, own_attributes, file, where)

        try:
            return SolidShape.of(from_plain(records, leaf), attributes)
        except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError):
            self.fail(f"the solid of {where} is malformed")
