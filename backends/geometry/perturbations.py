"""Wrong scenes made from a right one: which declarations notice when objects are moved, turned, resized or left out.

A declaration that holds for a scene and for all scenes of ``perturbed`` says nothing about it, as a test that no mutant
of a program fails (DeMillo, Lipton and Sayward, 1978).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.primitives import shape_of
from scenelang.interpreter.values.values import Embedding, Matrix, Pair

_MAX_OBJECTS = 5_000  # of a frame that are moved
_WALL = 2.0  # metres around an object that walls leave: more than an arm's reach


@dataclass(frozen=True, slots=True)
class NamedObject:
    """Outermost instance of one of the words: its word, and its box in the scene's frame, corners (3,) each."""

    word: str
    low: FloatArray
    high: FloatArray

    @property
    def center(self) -> FloatArray:
        """Center (3,) of the box."""
        return np.asarray((self.low + self.high) / 2.0, np.float64)

    @property
    def extent(self) -> FloatArray:
        """Edges (3,) of the box."""
        return np.asarray(self.high - self.low, np.float64)


# For each object of a frame the transforms (4, 4) in the scene's frame of the instances that replace it.
Moves = list[list[FloatArray]]
Change = Callable[[Sequence[NamedObject], int], Moves]


def perturbed(scene: Scene, words: Collection[str], without: Collection[str] = ()) -> Iterator[tuple[str, Scene]]:
    """Yield wrong scenes with what is wrong, such as "all objects in one place".

    Parameters
    ----------
    scene
        A scene, whose objects are placed as they should be.
    words
        Words whose outermost instances are the objects.
    without
        Changes of ``CHANGES`` that are left out.

    Raises
    ------
    LimitError
        For more than 5,000 objects in a frame.
    """
    for scene_or_whole, moved in testbeds(scene, words):
        for name, change in CHANGES.items():
            if name not in without:
                yield name, changed(scene_or_whole, moved, change)
    if scene.animated:
        yield "the first frame only", Scene(scene.word, [scene.root] * len(scene.frames), animated=True)
        yield "the film backwards", Scene(scene.word, scene.frames[::-1], animated=True)


def testbeds(scene: Scene, words: Collection[str]) -> Iterator[tuple[Scene, Collection[str]]]:
    """Yield scenes with the words whose instances can be moved in them: below the roots, and a named root itself.

    A root of one of the words is moved as a whole, below a parent without a name.
    """
    yield scene, words
    if scene.root.word in words:
        roots = [
            Entity("", Embedding(), (Pair(root, Matrix(np.eye(4)[:3].ravel().tolist())),), None, root.tainted)
            for root in scene.frames
        ]
        yield Scene(scene.word, roots, scene.animated), (scene.root.word,)


def objects_of(root: Entity, words: Collection[str]) -> list[NamedObject]:
    """Return the outermost instances of words below a root that have geometry, in depth-first order."""
    instances: list[NamedObject] = []

    def collect(entity: Entity, pose: FloatArray) -> list[FloatArray]:
        """Add an object, and leave it where it is."""
        instances.append(_named(entity, pose))
        return [np.eye(4)]

    _rebuilt(root, np.eye(4), frozenset(words), collect)
    return instances


def changed(scene: Scene, words: Collection[str], change: Change) -> Scene:
    """Return a scene whose objects are moved, turned, resized, left out or repeated."""
    frames = []
    for number, root in enumerate(scene.frames):
        moves = iter(change(objects_of(root, words), number))
        frames.append(_rebuilt(root, np.eye(4), frozenset(words), _next_of(moves)))
    return Scene(scene.word, frames, scene.animated)


def _next_of(moves: Iterator[list[FloatArray]]) -> Callable[[Entity, FloatArray], list[FloatArray]]:
    """Return a function of an object that returns its moves; objects come in the order of ``objects_of``."""
    return lambda entity, pose: next(moves)


def _named(entity: Entity, pose: FloatArray) -> NamedObject:
    """Return an object with its box; corners of its own box are turned into the scene's frame."""
    box = entity_box(entity)
    assert box is not None  # entities without geometry are no objects
    corners = np.array([[box[x], box[y], box[z], 1.0] for x in (0, 3) for y in (1, 4) for z in (2, 5)]) @ pose.T
    return NamedObject(entity.word, corners[:, :3].min(axis=0), corners[:, :3].max(axis=0))


def _rebuilt(
    root: Entity, pose: FloatArray, words: frozenset[str], moved: Callable[[Entity, FloatArray], list[FloatArray]]
) -> Entity:
    """Return a copy of a tree in which ``moved`` replaces each outermost object by instances under transforms."""
    count = 0
    holds: dict[int, bool] = {}

    def has_object(entity: Entity) -> bool:
        """Return whether an object is at or below an entity."""
        if id(entity) not in holds:
            holds[id(entity)] = is_object(entity) or any(has_object(pair.car) for pair in entity.children)
        return holds[id(entity)]

    def is_object(entity: Entity) -> bool:
        """Return whether an entity is an instance of one of the words, with geometry."""
        return entity.word in words and entity is not root and entity_box(entity) is not None

    def copy(entity: Entity, pose: FloatArray) -> Entity:
        """Return a copy of an entity, itself if nothing below it is an object."""
        nonlocal count
        if not has_object(entity):
            return entity
        children = []
        for pair in entity.children:
            world = pose @ _square(pair.cdr)
            if not is_object(pair.car):
                children.append(Pair(copy(pair.car, world), pair.cdr))
                continue
            count += 1
            if count > _MAX_OBJECTS:
                raise LimitError(
                    "primitives", f"more than {_MAX_OBJECTS:,} objects to move", "check a part of the scene"
                )
            for transform in moved(pair.car, world):
                local = np.linalg.pinv(pose) @ transform @ world
                children.append(Pair(pair.car, Matrix(local[:3].ravel().tolist())))
        return Entity(entity.word, entity.embedding, tuple(children), entity.shape, entity.tainted, entity.call_sites)

    return copy(root, pose)


def _square(matrix: Matrix) -> FloatArray:
    """Return a pose as a matrix (4, 4)."""
    square = np.eye(4)
    square[:3] = np.reshape(matrix, (3, 4))
    return square


# --- changes ---------------------------------------------------------------------------------------------------------


def _shift(x: float, y: float, z: float) -> FloatArray:
    """Return a translation (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def _about(point: FloatArray, linear: FloatArray) -> FloatArray:
    """Return a linear map (3, 3) about a point as a matrix (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = point - linear @ point
    return matrix


def _turn(axis: int, degrees: float) -> FloatArray:
    """Return a rotation (3, 3) about an axis of the scene."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = [k for k in range(3) if k != axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def _each(move: Callable[[NamedObject, int, int], FloatArray]) -> Change:
    """Return the change that moves every object, given its number and that of the frame."""
    return lambda objects, frame: [[move(each, number, frame)] for number, each in enumerate(objects)]


def _spread(objects: Sequence[NamedObject]) -> float:
    """Return the diagonal of the box of all objects."""
    low, high = (np.array([getattr(each, end) for each in objects]) for end in ("low", "high"))
    return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0))) if objects else 1.0


def _left_out(objects: Sequence[NamedObject], _: int) -> Moves:
    """Leave out all objects."""
    return [[] for _ in objects]


def _twice(objects: Sequence[NamedObject], _: int) -> Moves:
    """Repeat all objects beside the scene."""
    beside = _shift(1.5 * _spread(objects), 0.0, 0.7 * _spread(objects))
    return [[np.eye(4), beside] for _ in objects]


def _in_one_place(objects: Sequence[NamedObject], _: int) -> Moves:
    """Move the centers of all objects to that of the first."""
    return [[_shift(*(objects[0].center - each.center).tolist())] for each in objects]


def _permuted(objects: Sequence[NamedObject], _: int) -> Moves:
    """Put objects into the places of objects of other words, as far as there are as many, feet on feet."""
    order = sorted(range(len(objects)), key=lambda number: objects[number].word)
    counts = [sum(each.word == word for each in objects) for word in {each.word for each in objects}]
    step = max(counts, default=0)
    moves: Moves = [[] for _ in objects]
    for position, number in enumerate(order):
        own, other = objects[number], objects[order[(position + step) % len(order)]]
        way = other.center - own.center
        way[1] = other.low[1] - own.low[1]
        moves[number] = [_shift(*way.tolist())]
    return moves


def _scaled(factor: float) -> Change:
    """Return the change of all lengths by a factor."""
    return _each(lambda each, number, frame: np.diag([factor, factor, factor, 1.0]))


def _apart(objects: Sequence[NamedObject], _: int) -> Moves:
    """Triple the horizontal distances between the centers of objects."""
    middle = np.mean([each.center for each in objects], axis=0) if objects else np.zeros(3)
    ways = [2.0 * (each.center - middle) * [1.0, 0.0, 1.0] for each in objects]
    return [[_shift(*way.tolist())] for way in ways]


def _scattered(objects: Sequence[NamedObject], frame: int) -> Moves:
    """Move every object sideways by its own share of the scene's size; the same in all frames."""
    size = 0.6 * _spread(objects)
    # Golden angle and a golden share of the way: no two objects move alike, and no random numbers are needed.
    angles = [2.39996 * (number + 1) for number in range(len(objects))]
    ways = [size * (0.4 + 0.618034 * (number + 1) % 1.0) for number in range(len(objects))]
    return [[_shift(way * math.cos(angle), 0.0, way * math.sin(angle))] for angle, way in zip(angles, ways)]


def _mirrored(axis: int) -> Change:
    """Return the change that mirrors the places of all objects across the middle of the scene, not their shapes."""

    def change(objects: Sequence[NamedObject], _: int) -> Moves:
        """Mirror the centers."""
        middle = np.mean([each.center for each in objects], axis=0) if objects else np.zeros(3)
        ways = [2.0 * (middle - each.center)[axis] for each in objects]
        return [[_shift(*(way if k == axis else 0.0 for k in range(3)))] for way in ways]

    return change


def put(word: str, other: str, share: float) -> Change:
    """Return the change that puts all objects of a word over the middle of the first one of another.

    Their feet come at a share of its height: 1 puts them on it, 0 into it.
    """

    def change(objects: Sequence[NamedObject], _: int) -> Moves:
        """Move the objects of the word."""
        goal = next((each for each in objects if each.word == other), None)
        moves: Moves = []
        for each in objects:
            way = np.zeros(3)
            if goal is not None and each.word == word and each is not goal:
                way = goal.center - each.center
                way[1] = goal.low[1] + share * goal.extent[1] - each.low[1]
            moves.append([_shift(*way.tolist())])
        return moves

    return change


def at_random(seed: int) -> Change:
    """Return the change that places, turns and resizes every object at random in the box of all, anew in each frame."""

    def change(objects: Sequence[NamedObject], frame: int) -> Moves:
        """Draw a place, an axis of rotation and three factors between a third and three for each object."""
        draws = np.random.default_rng([seed, frame])
        low = np.min([each.low for each in objects], axis=0) if objects else np.zeros(3)
        high = np.max([each.high for each in objects], axis=0) if objects else np.zeros(3)
        moves = []
        for each in objects:
            rotation, _ = np.linalg.qr(draws.normal(size=(3, 3)))
            linear = rotation @ np.diag(3.0 ** draws.uniform(-1.0, 1.0, 3))
            moves.append([_shift(*(draws.uniform(low, high) - each.center).tolist()) @ _about(each.center, linear)])
        return moves

    return change


def _resized(factors: Sequence[float]) -> Change:
    """Return the change of the extents of every object, about the middle of its foot."""
    return _each(lambda each, number, frame: _about(each.center * [1, 0, 1] + each.low * [0, 1, 0], np.diag(factors)))


def _alternating(even: float, odd: float) -> Change:
    """Return the change of the sizes of objects by two factors in turn, about their centers."""
    return _each(lambda each, number, frame: _about(each.center, np.eye(3) * (odd if number % 2 else even)))


_TURNS = (90.0, 180.0, 135.0)
CHANGES: Mapping[str, Change] = {
    "all objects missing": _left_out,
    "all objects twice": _twice,
    "places exchanged": _permuted,
    "all lengths times ten": _scaled(10.0),
    "all lengths divided by ten": _scaled(0.1),
    "objects raised": _each(lambda each, number, frame: _shift(0.0, (1.0 + 0.7 * number) * max(each.extent), 0.0)),
    "objects far apart": _apart,
    "objects scattered": _scattered,
    "left and right exchanged": _mirrored(0),
    "above and below exchanged": _mirrored(1),
    "front and back exchanged": _mirrored(2),
    "objects turned": _each(lambda each, number, frame: _about(each.center, _turn(1, _TURNS[number % len(_TURNS)]))),
    "objects tipped over": _each(lambda each, number, frame: _about(each.center, _turn(0, 40.0 + 7.0 * number))),
    "objects squashed": _resized((1.0, 0.3, 1.0)),
    "objects stretched": _resized((3.0, 1.0, 1.0)),
    "objects narrowed": _resized((0.25, 1.0, 1.0)),
    "objects deepened": _resized((1.0, 1.0, 3.0)),
    "objects of different sizes": _alternating(2.2, 0.4),
    "objects of other different sizes": _alternating(0.4, 2.2),
    "objects drifting": _each(lambda each, number, frame: _shift(0.7 * frame * max(each.extent), 0.0, 0.0)),
    "objects spinning": _each(
        lambda each, number, frame: _about(each.center, _turn(1, 37.0 * frame) @ _turn(0, 29.0 * frame))
    ),
    # Last, since what few other changes break is left: comparing everything with everything takes minutes for chess.
    "all objects in one place": _in_one_place,
}


def walled(scene: Scene, words: Collection[str]) -> Scene:
    """Return a scene in which a closed box stands around every object, which nothing sees or reaches."""
    frames = []
    for root in scene.frames:
        boxes = []
        for each in objects_of(root, words):
            size, center = each.extent + 2.0 * _WALL, each.center
            matrix = Matrix(np.c_[np.diag(size), center].ravel().tolist())
            boxes.append(Pair(_cube(), matrix))
        children = (*root.children, *boxes)
        frames.append(Entity(root.word, root.embedding, children, root.shape, root.tainted, root.call_sites))
    return Scene(scene.word, frames, scene.animated)


@cache
def _cube() -> Entity:
    """Return the unit cube."""
    return Entity("cube", Embedding(), (), shape_of("cube", {}))
