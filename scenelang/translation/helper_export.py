"""Export to Python of the paper's helper API: the way back of the transpiler.

A registered function for each entity, and the scene's last. The API has cubes, spheres and cylinders with a color;
other primitives are errors. Other attributes and the texts of embeddings are left out, and semantic primitives become
cubes, each with a warning.
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Accepts, Backend, BackendOptions, Work, check_settings, frame_of
from scenelang.backends.files import write_text
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.primitives import PHYSICS
from scenelang.interpreter.values.values import Matrix

FloatArray = npt.NDArray[np.float64]
_MAX_LISTED_NAMES = 8  # names in a warning
_WORDS = ("cube", "sphere", "cylinder")
# Attributes of a primitive that the helper API has, too.
_SHARED_ATTRIBUTES = frozenset({"color", "scale", "radius", "p0", "p1"})
# Attributes that a call of a bound word has whatever its function does with the others.
_OF_EVERY_CALL = frozenset(attribute.name for attribute in PHYSICS)
_API = """
Shape P T np math register register_animation library_call primitive_call loop concat_shapes transform_shape
rotation_matrix translation_matrix scale_matrix identity_matrix compute_shape_center compute_shape_min
compute_shape_max compute_shape_sizes reflection_matrix random numpy
"""


def _write(scene: Scene, path: Path, options: BackendOptions) -> None:
    check_settings(options, [HELPER_PYTHON])
    frames = scene.frames if options.frame is None else [scene.frames[frame_of(scene, options.frame)]]
    writer = _Writer()
    text = writer.text(frames, scene.word, scene.animated and options.frame is None)
    if options.warn is not None:
        for message in writer.losses():
            options.warn(Diagnostic("lost-attribute", message, None))
    write_text(path, text)


class _Writer:
    def __init__(self) -> None:
        self._names = {*_API.split(), "helper"}
        self._functions: dict[int, str] = {}
        self._attributes: set[str] = set()
        self._texts: set[str] = set()
        self._semantic: set[str] = set()

    def losses(self) -> Iterator[str]:
        """Yield a sentence for each kind of content that the written text lacks."""
        if self._attributes:
            yield f"the helper API has colors only: {_listed(f'`:{name}`' for name in self._attributes)} left out"
        if self._texts:
            yield f"the helper API has no texts: {_listed(map(_quoted, self._texts))} left out"
        if self._semantic:
            yield f"the helper API has no semantic primitives: cubes for {_listed(map(_quoted, self._semantic))}"

    def _lose(self, entity: Entity) -> None:
        """Note the attributes and the text of an entity that the helper API does not have."""
        given = {name for name, value in entity.embedding.attributes.items() if value is not None}
        self._attributes |= given - _SHARED_ATTRIBUTES if entity.is_primitive else given & _OF_EVERY_CALL
        if entity.embedding.text:
            self._texts.add(entity.embedding.text)

    def text(self, frames: Iterable[Entity], word: str, is_animated: bool) -> str:
        """Return the program."""
        roots = list(frames)
        parts = [f'"""{word}, written by `scenelang export`."""\n\nfrom helper import *\nimport numpy as np']
        for entity in descendants(*roots):
            if not entity.is_primitive:
                parts.append(self._function(entity))
        for root in roots:
            if root.is_primitive:
                parts.append(self._function(root))
        if is_animated:
            name = self._free(f"{word} animation")
            calls = "".join(f"        library_call({self._functions[id(root)]!r}),\n" for root in roots)
            parts.append(f"@register_animation({word!r})\ndef {name}() -> list[Shape]:\n    return [\n{calls}    ]")
        return "\n\n\n".join(parts) + "\n"

    def _function(self, entity: Entity) -> str:
        name = self._functions[id(entity)] = self._free(entity.word)
        if not entity.is_primitive:
            self._lose(entity)
        if entity.is_primitive:
            parts = [self._primitive(entity)]
        else:
            shown = [pair for pair in entity.children if not pair.car.is_primitive or _is_visible(pair.car)]
            parts = [self._placed(pair.car, _rows(pair.cdr)) for pair in shown]
        body = parts[0] if len(parts) == 1 else "concat_shapes(" + "".join(f"\n        {part}," for part in parts)
        body += "\n    )" if len(parts) > 1 else ")" if not parts else ""
        return f"@register({entity.word!r})\ndef {name}() -> Shape:\n    return {body}"

    def _placed(self, entity: Entity, pose: FloatArray) -> str:
        text = self._primitive(entity) if entity.is_primitive else f"library_call({self._functions[id(entity)]!r})"
        return text if np.array_equal(pose, np.eye(4)) else f"transform_shape({text}, {_pose_text(pose)})"

    def _primitive(self, entity: Entity) -> str:
        shape = entity.shape
        kind = type(shape).__name__.lower()
        if shape is None or kind not in (*_WORDS, "semantic"):
            message = f'the helper API has no "{entity.word}": it has cubes, spheres and cylinders only'
            span = entity.call_sites[0] if entity.call_sites else None
            raise SceneError("unsupported", message, "export to Blender with `--to bpy`, or to .glb", span)
        self._lose(entity)
        if kind == "semantic":
            self._semantic.add(entity.word)
        if kind in ("cube", "semantic"):
            word, values = "cube", f"'scale': {_tuple(shape.size)}"  # type: ignore[attr-defined]
        elif kind == "sphere":
            word, values = "sphere", f"'radius': {_number(shape.radius)}"  # type: ignore[attr-defined]
        else:
            word = "cylinder"
            ends = f"'p0': {_tuple(shape.p0)}, 'p1': {_tuple(shape.p1)}"  # type: ignore[attr-defined]
            values = f"'radius': {_number(shape.radius)}, {ends}"  # type: ignore[attr-defined]
        color = "" if tuple(shape.color) == (1.0, 1.0, 1.0) else f", color={_tuple(shape.color)}"
        return f"primitive_call({word!r}, shape_kwargs={{{values}}}{color})"

    def _free(self, name: str) -> str:
        stem = re.sub(r"\W+", "_", name.lower(), flags=re.ASCII).strip("_") or "part"
        stem = f"_{stem}" if stem[0].isdigit() or keyword.iskeyword(stem) else stem
        unique = next(n for n in (stem, *(f"{stem}_{i}" for i in range(2, 1_000_000))) if n not in self._names)
        self._names.add(unique)
        return unique


def _listed(names: Iterable[str]) -> str:
    """Return the first names in alphabetical order, and the number of the others."""
    ordered = sorted(names)
    others = f" and {len(ordered) - _MAX_LISTED_NAMES} more" if len(ordered) > _MAX_LISTED_NAMES else ""
    return ", ".join(ordered[:_MAX_LISTED_NAMES]) + others


def _quoted(text: str) -> str:
    return f'"{text}"'


def _is_visible(entity: Entity) -> bool:
    return entity.shape is not None and entity.shape.has_geometry


def _rows(pose: Matrix) -> FloatArray:
    made = np.eye(4)
    made[:3] = np.array(list(pose), np.float64)[:12].reshape(3, 4)
    return made


def _pose_text(pose: FloatArray) -> str:
    """Return a pose as a product of helpers if it is one to the last digits, else as an array."""
    linear, offset = pose[:3, :3], pose[:3, 3]
    factors = [f"translation_matrix({_tuple(offset)})"] if offset.any() else []
    size = float(np.cbrt(np.linalg.det(linear)))
    turn = linear / size if size else linear
    if not np.allclose(turn.T @ turn, np.eye(3), atol=1e-12) or size <= 0:
        return f"np.array([{', '.join('[' + ', '.join(map(_number, row)) + ']' for row in pose)}])"
    cosine = min(1.0, max(-1.0, (float(np.trace(turn)) - 1) / 2))
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    length = float(np.linalg.norm(axis))
    if length > 1e-7:
        angle = math.atan2(length / 2, cosine)
        factors.append(f"rotation_matrix({_number(angle)}, {_tuple(axis / length)}, (0, 0, 0))")
    elif cosine < 0:  # half a turn
        column = (turn + np.eye(3))[:, int(np.argmax(np.diag(turn)))]
        factors.append(f"rotation_matrix(math.pi, {_tuple(column / np.linalg.norm(column))}, (0, 0, 0))")
    if abs(size - 1) > 1e-12:
        factors.append(f"scale_matrix({_number(size)}, (0, 0, 0))")
    return " @ ".join(factors) or "identity_matrix()"


def _number(value: float) -> str:
    number = float(value)
    text = f"{number:.12g}"
    return "0" if text == "-0" or abs(number) < 1e-15 else text


def _tuple(values: Iterable[float]) -> str:
    return f"({', '.join(_number(value) for value in values)})"


HELPER_PYTHON = Backend(
    "python",
    "Python of the paper's helper API, a registered function for each entity",
    Work.EXPORT,
    (".py",),
    _write,
    accepts=Accepts(words=_WORDS, attributes=("color",), animated=True),
)
