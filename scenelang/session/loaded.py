"""A scene with the program that it comes from: its measures, parts, primitives and variants.

``LoadedScene`` is what the interpreter alone can answer. ``scenelang.Scene`` adds images, exports, maps and physics;
domains take a ``LoadedScene``, and what they derive from one has its class.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import frame_of, require_word
from scenelang.grammar.datum import Source, atom_text
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.settings import typed
from scenelang.interpreter.inspection.instance_paths import Locator, is_plain, part_of, selected
from scenelang.interpreter.runtime.show import plain_attributes
from scenelang.interpreter.scene.bounds import parts_box
from scenelang.interpreter.scene.entity import Entity, Scene, count_words, descendants, primitive_count
from scenelang.interpreter.values.values import Pair
from scenelang.session.materials import look_value, restyled
from scenelang.session.session import Evaluated, Options, Session

if TYPE_CHECKING:
    from scenelang.grammar.datum import Span
    from scenelang.interpreter.checker.program import Program
    from scenelang.interpreter.scene.flatten import FlatFrame
    from scenelang.interpreter.scene.modelling.measuring import Measures
    from scenelang.session.scene_changes import Changes

FloatArray = npt.NDArray[np.float64]
AnyScene = TypeVar("AnyScene", bound="LoadedScene")


class Primitives:
    """The primitives of a frame as arrays, in depth-first order. An array is made when it is first used.

    Attributes
    ----------
    matrix : (N, 4, 4) float64
        World matrix of each primitive.
    word, handle, shape : (N,) object
        Strings; ``shape`` is "cube", "sphere", ..., or "box" for a word without a defined geometry.
    path : (N,) object
        Tuples of words from the root to the primitive's parent.
    color : (N, 3) float64
        Linear sRGB.
    entity : tuple of Entity
        Entity of each primitive; repeated primitives share one.
    """

    def __init__(self, graph: Scene, frame: int, flat: FlatFrame) -> None:
        self._graph, self._frame, self._flat = graph, frame, flat

    @property
    def matrix(self) -> FloatArray:
        return self._flat.matrices

    @cached_property
    def word(self) -> npt.NDArray[np.object_]:
        return self._each([entity.word for entity in self._flat.primitives])

    @cached_property
    def path(self) -> npt.NDArray[np.object_]:
        return _objects(self._flat.paths)[self._flat.path_index]

    @cached_property
    def handle(self) -> npt.NDArray[np.object_]:
        from scenelang.interpreter.inspection.numbering import frame_handles

        return _objects([f"<{handle}>" for handle in frame_handles(self._graph, self._frame, self._flat)])

    @cached_property
    def shape(self) -> npt.NDArray[np.object_]:
        shapes = [entity.shape for entity in self._flat.primitives]
        return self._each(["" if shape is None else shape.word or "box" for shape in shapes])

    @cached_property
    def color(self) -> FloatArray:
        shapes = [entity.shape for entity in self._flat.primitives]
        colors = np.array([shape.color if shape is not None else (1.0, 1.0, 1.0) for shape in shapes])
        return colors.reshape(-1, 3).take(self._flat.index, axis=0)

    @cached_property
    def entity(self) -> tuple[Entity, ...]:
        return tuple(self._each(self._flat.primitives).tolist())

    def __len__(self) -> int:
        return len(self._flat)

    def _each(self, values: Sequence[Any]) -> npt.NDArray[np.object_]:
        """Return for each primitive (N,) the value of its entity, given for the distinct ones."""
        return _objects(values)[self._flat.index]

    @typed
    def attribute(self, name: str, default: Any = None) -> npt.NDArray[np.object_]:
        """Return the attribute ``name`` of each primitive (N,), with the defaults of its geometry filled in.

        Examples
        --------
        >>> import scenelang as sl
        >>> sl.evaluate('(bind "a" (lambda () (call "sphere" :radius 2)))').flatten().attribute("radius")
        array([2.0], dtype=object)
        """
        from scenelang.interpreter.runtime.show import primitive_attributes

        return self._each([primitive_attributes(entity).get(name, default) for entity in self._flat.primitives])

    def __getitem__(self, mask: Any) -> Primitives:
        """Return the primitives selected by a mask (N,) or by indices."""
        rows = np.arange(len(self))[mask].reshape(-1)
        if self._graph.animated:
            self.handle  # noqa: B018 - numbers of later frames come from all instances, so they are selected below
        selected = Primitives(self._graph, self._frame, self._flat.select(rows))
        made = vars(self).keys() & {"word", "path", "handle", "shape", "color"}  # may have been written to
        vars(selected).update({name: getattr(self, name)[rows] for name in made})
        return selected

    def __repr__(self) -> str:
        words = len(set(self.word.tolist()))
        return f"<Primitives: {len(self):,} of {words:,} {'word' if words == 1 else 'words'}>"


@dataclass(frozen=True, slots=True, eq=False)
class SceneInstance:
    """An instance of a scene.

    Attributes
    ----------
    path
        The path of this instance only, such as "chair[1]/leg[2]".
    handle
        Handle of its embedding, such as "z3".
    word
        Its word.
    pose : (4, 4) float64
        Pose in the world, in scene units.
    box : (2, 3) float64 or None
        Exact world-space bounding box, minimum corner first; None without geometry.
    attributes
        Attributes of its embedding, as JSON data.
    entity
        The entity, which equal instances share.
    definition, place
        Source locations of the binding of its word, and of the call of the instance or of its first primitive; None
        if unknown.
    """

    path: str
    handle: str
    word: str
    pose: FloatArray
    box: FloatArray | None
    attributes: dict[str, Any]
    entity: Entity
    definition: Span | None
    place: Span | None

    def data(self) -> dict[str, Any]:
        """Return the instance as JSON data."""
        box = None if self.box is None else self.box.tolist()
        data = {"path": self.path, "handle": self.handle, "word": self.word, "pose": self.pose[:3].tolist(), "box": box}
        if self.attributes:
            data["attributes"] = self.attributes
        for name, span in (("defined", self.definition), ("called", self.place)):
            if span is not None:
                data[name] = {"file": span.source.name, "line": span.source.position(span.start)[0]}
        return data

    def __repr__(self) -> str:
        return f"<SceneInstance {self.path}>"


@dataclass(frozen=True, slots=True, eq=False)
class LoadedScene:
    """A scene: one root entity, or one root entity per frame of a 4D scene.

    Attributes
    ----------
    graph
        The entity graph.
    name
        File of the program, or ``<text>``.
    log
        Lines printed by the program.
    warnings
        Diagnostics of the evaluation.
    program, options
        The program and the options it was evaluated under; None for a scene loaded from JSON, or a part of a scene.
    """

    graph: Scene = field(repr=False)
    name: str = "<text>"
    log: tuple[str, ...] = field(default=(), repr=False)
    warnings: tuple[Diagnostic, ...] = field(default=(), repr=False)
    program: Program | None = field(default=None, repr=False)
    options: Options | None = field(default=None, repr=False)

    @classmethod
    @typed
    def of(cls, entity: Entity) -> Self:
        """Create a scene from an entity, in the entity's local frame."""
        return cls(Scene(entity.word, [entity], False))

    @property
    def word(self) -> str:
        """Word of the root."""
        return self.graph.word

    @property
    def root(self) -> Entity:
        """Root entity of the first frame."""
        return self.graph.root

    @property
    def frames(self) -> tuple[Entity, ...]:
        """Root entity of each frame."""
        return self.graph.frames

    @property
    def animated(self) -> bool:
        """Whether the scene is 4D."""
        return self.graph.animated

    @property
    def words(self) -> list[str]:
        """Sorted words of all entities."""
        return sorted({entity.word for entity in descendants(*self.frames)})

    @property
    def params(self) -> dict[str, str]:
        """The program's params with the source text of their defaults."""
        return {} if self.program is None else {param.name: param.default for param in self.program.params}

    @property
    def bounds(self) -> FloatArray | None:
        """Exact axis-aligned bounding box (2, 3) of all frames, minimum corner first; None without geometry."""
        return self._box(None)

    @property
    def extents(self) -> FloatArray | None:
        """Extents (3,) of ``bounds``; None without geometry."""
        return None if (box := self.bounds) is None else box[1] - box[0]

    @typed
    def bounds_of(self, word: str) -> FloatArray | None:
        """Return the exact world-space bounding box (2, 3) of all entities of ``word``; None without geometry.

        ``word`` may be a path, such as ``chair/leg[2]``; see ``instances``.

        Raises
        ------
        SceneError
            If no entity has the word.
        """
        require_word(self.graph, word)
        return self._box(word)

    def _box(self, word: str | None) -> FloatArray | None:
        """Return the box of all instances of a word or path, or of the scene."""
        from scenelang.interpreter.inspection.instance_paths import box_of

        box = box_of(self.graph, word)
        return None if box is None else np.array(box, np.float64).reshape(2, 3)

    @typed
    def measure(self, word: str | None = None, frame: int = 0, limit: int = 100_000) -> Measures:
        """Return volume, surface area, center of mass and inertia of a frame, or of all entities of a word in it.

        Volumes that overlap count once; density is 1. A primitive that meets no other is measured exactly.

        Parameters
        ----------
        word : str, optional
            Word or path, such as ``chair/leg[2]``; None measures the whole frame.
        frame : int
            Frame of a 4D scene, counted from 0.
        limit : int
            Maximum number of primitives.

        Raises
        ------
        SceneError
            If no entity has the word, or a primitive has no volume, such as a Minecraft block.

        Examples
        --------
        >>> import scenelang as sl
        >>> sl.evaluate('(bind "it" (lambda () (call "cube" :scale [1 2 3])))').measure().volume
        6.0
        """
        from scenelang.interpreter.scene.modelling.measuring import measures_of

        if word is not None:
            require_word(self.graph, word)
        if word is not None and not is_plain(word):
            return measures_of(selected(self.graph, word, frame_of(self.graph, frame)), None, limit)
        return measures_of(self._frame(frame), word, limit)

    @typed
    def count(self, frame: int = 0) -> dict[str, int]:
        """Return the number of instances of every word in a frame, in depth-first order of appearance."""
        return count_words(self._frame(frame))

    @typed
    def tree(self, depth: int | None = None, *, poses: bool = False, every: bool = False) -> str:
        """Return the hierarchy of the first frame as text, to ``depth`` below the root; ``every`` lists each part."""
        from scenelang.interpreter.inspection.outline import outline

        return "\n".join(outline(self.graph, depth, poses, every))

    @typed
    def tree_data(self, depth: int | None = None) -> dict[str, Any]:
        """Return the hierarchy of the first frame as JSON data."""
        from scenelang.interpreter.inspection.outline import outline_data

        return outline_data(self.graph, depth)

    @typed
    def flatten(self, frame: int = 0, limit: int = 5_000_000) -> Primitives:
        """Return the primitives of a frame with their world matrices.

        Raises
        ------
        LimitError
            If the scene expands to more than ``limit`` primitives.
        """
        from scenelang.interpreter.scene.flatten import flatten

        root = self._frame(frame)
        return Primitives(self.graph, frame, flatten(Scene(self.word, [root], False), limit, whole=True).frames[0])

    @typed
    def with_params(self, values: Mapping[str, Any]) -> Self:
        """Evaluate the same program again with other values of its params, given as plain Python values.

        Raises
        ------
        SceneError
            If the scene has no program, the program has no such param, or the evaluation fails.
        """
        if self.program is None or self.options is None:
            raise SceneError("unsupported", "scenes loaded from JSON have no params")
        texts = {name: literal(value) for name, value in values.items()}
        options = replace(self.options, defines={**self.options.defines, **texts})
        return scene_of(type(self), self.program.main, options)

    @typed
    def with_seed(self, seed: int) -> Self:
        """Evaluate the same program again with another seed of random numbers, from 0 to 4,294,967,295.

        Raises
        ------
        SceneError
            If the scene has no program, or the evaluation fails.
        """
        if self.program is None or self.options is None:
            raise SceneError("unsupported", "scenes loaded from JSON have no random numbers")
        return scene_of(type(self), self.program.main, replace(self.options, seed=seed))

    @typed
    def restyled(
        self,
        word: str,
        *,
        color: Sequence[float] | str | None = None,
        roughness: float | None = None,
        metallic: float | None = None,
        opacity: float | None = None,
        emission: Sequence[float] | float | None = None,
        ior: float | None = None,
    ) -> Self:
        """Return a copy of the scene with another material for all entities of ``word`` and their parts.

        Parameters
        ----------
        word : str
            A word of the scene.
        color : (r, g, b) or str, optional
            Linear sRGB from 0 to 1, a color name or a hex code.
        roughness, metallic, opacity, emission, ior : float, optional
            Material attributes (docs/language.md).

        Raises
        ------
        SceneError
            If no entity has the word.
        """
        require_word(self.graph, word)
        look = {"color": color, "roughness": roughness, "metallic": metallic, "opacity": opacity}
        look |= {"emission": emission, "ior": ior}
        attributes = {name: look_value(name, value) for name, value in look.items() if value is not None}
        known: dict[tuple[int, bool], Entity] = {}
        frames = [restyled(root, word, attributes, known) for root in self.frames]
        return replace(self, graph=self.graph.with_frames(frames), program=None)

    @typed
    def frame(self, number: int) -> Self:
        """Return one frame of a 4D scene as a static scene."""
        return replace(self, graph=self.graph.with_frames([self._frame(number)], False))

    @typed
    def instances(self, path: str, frame: int = 0, limit: int = 20_000) -> list[SceneInstance]:
        """Return the instances of a path, in depth-first order.

        Parameters
        ----------
        path : str
            Words from the root down, such as ``chair/leg[2]``: every outermost instance of "chair", and in each the
            third "leg". ``<z3>`` is the instance with a handle, ``*`` every direct part; a backslash escapes a
            character.
        frame : int
            Frame of a 4D scene, counted from 0.
        limit : int
            Maximum number of instances to return.

        Raises
        ------
        SceneError
            If the path is malformed, or there is no such instance.

        Examples
        --------
        >>> import scenelang as sl
        >>> pair = '(bind "pair" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
        >>> sl.evaluate(pair).instances("cube[1]")
        [<SceneInstance cube[1]>]
        """
        locator = Locator(self.graph, frame_of(self.graph, frame))
        words: Mapping[str, Span] = {} if self.program is None else self.program.words
        instances = []
        for located in locator.find(path)[:limit]:
            pose = np.eye(4)
            pose[:3] = np.array(located.pose, np.float64).reshape(3, 4)
            box = parts_box((Pair(located.entity, located.pose),))
            instances.append(
                SceneInstance(
                    locator.path(located.positions),
                    locator.handle(located.positions),
                    located.entity.word,
                    pose,
                    None if box is None else np.array(box, np.float64).reshape(2, 3),
                    plain_attributes(located.entity),
                    located.entity,
                    words.get(located.entity.word),
                    next((span for entity in descendants(located.entity) for span in entity.call_sites[:1]), None),
                )
            )
        return instances

    @typed
    def part(self, path: str) -> Self:
        """Return the scene of the instances of a path, at their places in this scene; see ``instances``.

        Examples
        --------
        >>> import scenelang as sl
        >>> pair = '(bind "pair" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
        >>> sl.evaluate(pair).part("cube[1]").bounds[0].tolist()
        [0.5, -0.5, -0.5]
        """
        return replace(self, graph=part_of(self.graph, path), program=None)

    @typed
    def diff(self, other: LoadedScene, tolerance: float = 1e-5, limit: int = 2_000_000) -> Changes:
        """Return the changes from this scene to ``other``.

        Parameters
        ----------
        other
            Scene to compare with.
        tolerance
            Differences up to this share of the scene's size are ignored, as in ``scenelang.diff``.
        limit
            Maximum number of primitives of a scene.
        """
        from scenelang.session.scene_changes import changes_between, compared_frames

        return changes_between(compared_frames(self.graph, limit), compared_frames(other.graph, limit), tolerance)

    def to_json(self) -> dict[str, Any]:
        """Return the scene as the JSON export has it (docs/exports.md), mesh paths relative to the current folder."""
        from scenelang.files.scene_json import scene_text

        data: dict[str, Any] = json.loads("".join(scene_text(self.graph, Path.cwd())))
        return data

    def _frame(self, number: int) -> Entity:
        """Return the root of a frame; raises SceneError if the frame does not exist."""
        return self.frames[frame_of(self.graph, number)]

    def __repr__(self) -> str:
        count = primitive_count(self.root)
        frames = f", {len(self.frames)} frames" if self.animated else ""
        return f'<Scene "{self.word}": {count:,} {"primitive" if count == 1 else "primitives"}{frames}>'


def scene_of(kind: type[AnyScene], source: Source, options: Options) -> AnyScene:
    """Evaluate a program, and return its scene.

    Parameters
    ----------
    kind
        Class of the scene: ``LoadedScene`` or a subclass.
    source
        The program.
    options
        Options of the evaluation.

    Raises
    ------
    SceneError
        The first error of the program, or "value" for an invalid seed.
    """
    if not 0 <= options.seed < 1 << 32:
        raise SceneError("value", f"`seed`: expected a whole number from 0 to {(1 << 32) - 1}, got {options.seed}")
    result = Session(options).evaluate(source)
    result.require()
    return scene_from(kind, result, source.name, options)


def scene_from(kind: type[AnyScene], result: Evaluated, name: str, options: Options) -> AnyScene:
    """Create the scene of a program that was evaluated without errors.

    Parameters
    ----------
    kind
        Class of the scene: ``LoadedScene`` or a subclass.
    result
        Evaluation of the program; it has a scene.
    name
        Name of the program's source, usually its path.
    options
        Options of the evaluation, with which the scene is evaluated again.
    """
    assert result.scene is not None
    return kind(result.scene, name, result.log, result.diagnostics, result.program, options)


def literal(value: Any) -> str:
    """Convert a plain Python value to a literal of the language, as accepted by ``defines``.

    Raises
    ------
    SceneError
        If the value is not a number, a boolean, a string or a sequence of these.

    Examples
    --------
    >>> literal([1, 2.5]), literal(True), literal("oak")
    ('[1 2.5]', '#t', '"oak"')
    """
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, bool | int | float | str):
        return atom_text(value)
    if isinstance(value, list | tuple):
        return f"[{' '.join(literal(item) for item in value)}]"
    raise SceneError("param", f"expected a number, boolean, string or sequence for a param, got {type(value).__name__}")


def _objects(values: Sequence[Any]) -> npt.NDArray[np.object_]:
    """Create an object array (N,) of arbitrary values; unlike ``np.array`` it does not unpack tuples."""
    objects = np.empty(len(values), object)
    for i, value in enumerate(values):
        objects[i] = value
    return objects
