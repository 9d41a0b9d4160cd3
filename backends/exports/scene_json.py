"""Exports as JSON: the DAG of entities, each once, in a documented schema that ``scene_file`` reads back."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from scenelang.backends.base import Accepts, Backend, Options, Work, check_settings, frame_of
from scenelang.backends.files import written_whole
from scenelang.interpreter.entity import Entity, Scene, descendants
from scenelang.interpreter.plain import NotPlain, plain_value

FORMAT = "scenelang-scene"
VERSION = 1
_AXES = "right-handed: x right, y up, z towards the viewer; poses are the upper three rows of 4x4 matrices, row by row"


def write_scene(scene: Scene, path: Path | str) -> None:
    """Write ``scene`` to ``path``, whole or not at all; raises SceneError("file")."""
    with written_whole(path) as temporary, temporary.open("w", encoding="ascii", newline="\n") as file:
        file.writelines(_pieces(scene, Path(path).resolve().parent))


def _pieces(scene: Scene, folder: Path) -> Iterator[str]:
    """The document, one entity a line, children before parents."""
    head = {"format": FORMAT, "version": VERSION, "word": scene.word, "animated": scene.animated, "axes": _AXES}
    yield json.dumps(head)[:-1] + ',\n"entities": ['
    numbers: dict[int, int] = {}
    for entity in descendants(*scene.frames):
        yield "," if numbers else ""
        numbers[id(entity)] = len(numbers)
        yield "\n" + json.dumps(_entity(entity, numbers, folder), separators=(",", ":"), allow_nan=False)
    yield '\n],\n"frames": ' + json.dumps([numbers[id(root)] for root in scene.frames]) + "}\n"


def _entity(entity: Entity, numbers: dict[int, int], folder: Path) -> dict[str, Any]:
    embedding = entity.embedding
    made: dict[str, Any] = {"word": entity.word}
    if entity.is_primitive:
        made["primitive"] = True
    if embedding.handle is not None:
        made["handle"] = embedding.handle
    if embedding.text is not None:
        made["text"] = embedding.text
    attributes = _attributes(entity)
    if attributes:
        made["attributes"] = attributes
    if entity.shape is not None and entity.shape.file is not None:
        made["file"] = _relative(entity.shape.file, folder)
    if entity.children:
        made["children"] = [[numbers[id(part.car)], list(part.cdr)] for part in entity.children]
    return made


def _attributes(entity: Entity) -> dict[str, Any]:
    """The attributes as tagged plain data; what is not plain (functions, entities) is left out."""
    found: dict[str, Any] = {}
    for name, value in entity.embedding.attributes.items():
        try:
            found[name] = plain_value(value, tagged=True)
        except NotPlain:
            continue
    return found


def _relative(file: str, folder: Path) -> str:
    """The path of a mesh file from ``folder`` where it lies inside it."""
    target = Path(file).resolve()
    return target.relative_to(folder).as_posix() if target.is_relative_to(folder) else os.fspath(target)


def _run(scene: Scene, path: Path, options: Options) -> None:
    check_settings(options, [JSON])
    if options.frame is not None:
        scene = Scene(scene.word, [scene.frames[frame_of(scene, options.frame)]], False)
    write_scene(scene, path)


JSON = Backend(
    "json",
    "the tree of entities as JSON, which can be read back",
    Work.EXPORT,
    (".json",),
    _run,
    accepts=Accepts(animated=True),
)


def holds_scene(path: Path | str) -> bool:
    """Whether a JSON file begins as those that are written here do."""
    try:
        with open(path, "rb") as file:
            return f'"format": "{FORMAT}"'.encode() in file.read(200)
    except OSError:
        return False
