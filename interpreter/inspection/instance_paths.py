"""Paths to the instances of a scene, such as ``chair/leg[2]``: words from the root down, the same everywhere.

A step is a word, and means every outermost instance with it below the instances so far; the first step also means the
root. ``leg[2]`` is the third of them below each, in the order of the tree, ``<z3>`` the instance with a handle, and
``*`` every direct part. Intermediate words may be left out, so a word alone is a path. A backslash escapes a character.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import LimitError, SceneError, suggest
from scenelang.interpreter.inspection.numbering import Numbering, frame_numbers, number_scene
from scenelang.interpreter.scene.bounds import word_box
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.scene.primitives.base import Box
from scenelang.interpreter.values.values import IDENTITY, Embedding, Matrix, Pair

MAX_INSTANCES = 100_000
_MAX_LENGTH = 2_000  # characters
_MAX_KEPT = 64  # words whose counts are kept
_SPECIAL = frozenset("/[]\\")
_ANY = "*"


@dataclass(frozen=True, slots=True)
class PathStep:
    """A step of a path: a word, a handle or any part, and which of those that it means (None: all)."""

    name: str
    kind: str = "word"  # or "handle", "any"
    index: int | None = None

    def __str__(self) -> str:
        name = {"word": escaped(self.name), "handle": f"<{self.name}>"}.get(self.kind, _ANY)
        return name if self.index is None else f"{name}[{self.index}]"


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """An instance in a frame: its child positions from the root, its entity, and its pose in the scene."""

    positions: tuple[int, ...]
    entity: Entity
    pose: Matrix


def escaped(word: str) -> str:
    r"""Return a word as a step of a path.

    Examples
    --------
    >>> escaped("1/2 inch"), escaped("a[0]"), escaped("*")
    ('1\\/2 inch', 'a\\[0\\]', '\\*')
    """
    text = "".join(f"\\{c}" if c in _SPECIAL else c for c in word)
    return f"\\{text}" if text == _ANY or text.startswith("<") else text


def is_plain(text: str) -> bool:
    """Return whether a path is nothing but a word."""
    return not _SPECIAL & set(text) and text != _ANY and not text.startswith("<")


def is_handle(text: str) -> bool:
    """Return whether a path is nothing but a handle, such as ``<z3>``."""
    return text.startswith("<") and text.endswith(">") and len(text) > 2 and not _SPECIAL & set(text)


def read_path(text: str) -> tuple[PathStep, ...]:
    r"""Read a path. Raises SceneError("value") for a path that is malformed.

    Examples
    --------
    >>> [str(step) for step in read_path("room/chair[1]/<z3>")]
    ['room', 'chair[1]', '<z3>']
    """
    if len(text) > _MAX_LENGTH:
        raise SceneError("value", f"a path has at most {_MAX_LENGTH:,} characters, got {len(text):,}")
    return tuple(_step(text, part) for part in _split(text))


def _split(text: str) -> list[list[tuple[str, bool]]]:
    """Return the characters of each step, with whether a backslash escapes them."""
    steps: list[list[tuple[str, bool]]] = [[]]
    characters = iter(text)
    for c in characters:
        if c == "\\":
            following = next(characters, None)
            if following is None:
                raise _malformed(text, "a backslash at the end escapes nothing")
            steps[-1].append((following, True))
        elif c == "/":
            steps.append([])
        else:
            steps[-1].append((c, False))
    return steps


def _step(text: str, part: list[tuple[str, bool]]) -> PathStep:
    index = None
    opening = next((k for k, each in enumerate(part) if each == ("[", False)), None)
    if opening is not None:
        inside = "".join(c for c, _ in part[opening + 1 : -1])
        if part[-1] != ("]", False) or not (inside.isascii() and inside.isdecimal()) or len(inside) > 9:
            raise _malformed(text, "expected a number from 0 on in brackets, such as `leg[2]`")
        part, index = part[:opening], int(inside)
    name = "".join(c for c, _ in part)
    if ("]", False) in part:
        raise _malformed(text, "`]` has no `[`; a word with brackets needs backslashes")
    if not part:
        raise _malformed(text, "a step is empty; expected words with `/` between them")
    if part == [(_ANY, False)]:
        return PathStep("", "any", index)
    if part[0] == ("<", False) and part[-1] == (">", False) and len(part) > 2:
        return PathStep(name[1:-1], "handle", index)
    return PathStep(name, "word", index)


def _malformed(text: str, why: str) -> SceneError:
    shown = text if len(text) <= 80 else text[:77] + "..."
    return SceneError("value", f"`{shown}` is no path: {why}", "write `chair/leg[2]`; a backslash escapes / [ ]")


# --- finding instances -----------------------------------------------------------------------------------------------


class Locator:
    """Finds the instances of one frame of a scene by path."""

    def __init__(self, scene: Scene, frame: int = 0) -> None:
        self.scene = scene
        self.root = scene.frames[frame]
        self._below: dict[str, dict[int, int]] = {}
        self._before: dict[tuple[int, str], list[int]] = {}
        self._entities: list[Entity] | None = None
        self._numbering: Numbering | None = None
        self._numbers: dict[tuple[int, ...], int] | None = None
        self._offsets: dict[int, list[int]] = {}  # instances without a handle before each part
        self._paths: dict[int, tuple[int, ...]] = {}

    def find(self, text: str, start: Located | None = None) -> list[Located]:
        """Return the instances that a path means, in the order of the tree; at least one.

        A text that is no path, or means nothing as one, may be a word with special characters. ``start`` is the
        instance to search, the root by default.

        Raises
        ------
        SceneError("value")
            If the path is malformed, or there is no such instance.
        LimitError
            If there are more than 100,000.
        """
        top = start or Located((), self.root, IDENTITY)
        try:
            return self._found(read_path(text), top)
        except LimitError:
            raise
        except SceneError:
            words = [] if is_plain(text) else self._under(top, PathStep(text), True)
            if not words:
                raise
            return words

    def _found(self, steps: Sequence[PathStep], top: Located) -> list[Located]:
        found = [top]
        for number, step in enumerate(steps):
            following = [each for one in found for each in self._under(one, step, number == 0)]
            if not following:
                raise self._missing(steps[:number], step, found)
            if len(following) > MAX_INSTANCES:
                raise LimitError("primitives", f"the path means more than {MAX_INSTANCES:,} instances")
            found = following
        return found

    def _missing(self, before: Sequence[PathStep], step: PathStep, found: Sequence[Located]) -> SceneError:
        around = "/".join(map(str, before)) or self.root.word
        every = PathStep(step.name, step.kind)
        if step.index is not None:
            most = max(len(self._under(each, every, not before)) for each in found[:100])
            if most:
                counted = f"are {most} `{every}`, numbered from 0" if most > 1 else f"is only one `{every}`"
                return SceneError("value", f"no part `{step}` in `{around}`", f"there {counted}")
        words = sorted({e.word for each in found[:100] for e in descendants(each.entity)})
        hint = suggest(step.name, words) if step.kind == "word" else None
        return SceneError("value", f"no part `{step}` in `{around}`", hint)

    def _under(self, top: Located, step: PathStep, with_top: bool) -> list[Located]:
        if step.kind == "any":
            found = [self._part(top, k) for k in range(len(top.entity.children))]
        elif step.kind == "handle":
            found = self._with_handle(top, step.name)
        else:
            return self._with_word(top, step, with_top)
        return found if step.index is None else found[step.index : step.index + 1]

    def _with_word(self, top: Located, step: PathStep, with_top: bool) -> list[Located]:
        if with_top and top.entity.word == step.name:
            return [top] if not step.index else []
        counts = self._counts(step.name)
        found: list[Located] = []
        skip = step.index or 0
        stack = self._parts(top, counts)
        while stack and len(found) <= MAX_INSTANCES:
            each = stack.pop()
            if skip >= counts[id(each.entity)]:
                skip -= counts[id(each.entity)]
            elif each.entity.word == step.name:
                found.append(each)
                if step.index is not None:
                    break
            else:
                stack += self._parts(each, counts)
        return found

    def _parts(self, top: Located, counts: dict[int, int]) -> list[Located]:
        """Return the parts that contain something to find, the first one last."""
        places = range(len(top.entity.children) - 1, -1, -1)
        return [self._part(top, k) for k in places if counts[id(top.entity.children[k].car)]]

    @staticmethod
    def _part(top: Located, position: int) -> Located:
        part = top.entity.children[position]
        return Located((*top.positions, position), part.car, compose(top.pose, part.cdr))

    def _counts(self, word: str) -> dict[int, int]:
        """Return for each entity the number of outermost instances of a word in it, by ``id``."""
        if word not in self._below:
            if len(self._below) >= _MAX_KEPT:
                self._below.clear()
            if self._entities is None:
                self._entities = list(descendants(self.root))
            counts: dict[int, int] = {}
            for entity in self._entities:
                inside = 1 if entity.word == word else sum(counts[id(part.car)] for part in entity.children)
                counts[id(entity)] = inside
            self._below[word] = counts
        return self._below[word]

    def _running(self, entity: Entity, word: str) -> list[int]:
        """Return the number of outermost instances of a word before each part of an entity, and in all of them."""
        key = id(entity), word
        if key not in self._before:
            if len(self._before) >= _MAX_KEPT:
                self._before.clear()
            counts = self._counts(word)
            self._before[key] = [0, *accumulate(counts[id(part.car)] for part in entity.children)]
        return self._before[key]

    # --- handles -----------------------------------------------------------------------------------------------

    def _with_handle(self, top: Located, handle: str) -> list[Located]:
        positions = self._numbered(handle)
        if positions is not None:
            below = positions[: len(top.positions)] == top.positions
            return [self.at(positions, top)] if below else []
        found: list[Located] = []
        stack, holding = [top], self._holding(handle)
        while stack and len(found) <= MAX_INSTANCES:
            each = stack.pop()
            if each.entity.embedding.handle == handle:
                found.append(each)
            parts = each.entity.children
            stack += [self._part(each, k) for k in range(len(parts) - 1, -1, -1) if id(parts[k].car) in holding]
        return found

    def _holding(self, handle: str) -> set[int]:
        """Return the ``id`` of each entity that has, or contains, a handle of an embedding."""
        found: set[int] = set()
        for entity in descendants(self.root):
            if entity.embedding.handle == handle or any(id(part.car) in found for part in entity.children):
                found.add(id(entity))
        return found

    def _numbered(self, handle: str) -> tuple[int, ...] | None:
        """Return the child positions of the instance with an automatic number in the frame, None if there is none."""
        number = handle[1:]
        if handle[:1] != "z" or not (number.isascii() and number.isdecimal()) or len(number) > 18:
            return None
        if len(self.scene.frames) == 1:
            return self._numbers_of_scene().path(int(number))
        if not self._paths:
            self._paths = {n: positions for positions, n in self._frame_numbers().items()}
        positions = self._paths.get(int(number))
        return positions if positions is not None and self._exists(positions) else None

    def _exists(self, positions: Sequence[int]) -> bool:
        entity = self.root
        for position in positions:
            if position >= len(entity.children):
                return False
            entity = entity.children[position].car
        return entity.embedding.handle is None

    def _numbers_of_scene(self) -> Numbering:
        if self._numbering is None:
            self._numbering = number_scene(self.scene)
        return self._numbering

    def _frame_numbers(self) -> dict[tuple[int, ...], int]:
        if self._numbers is None:
            self._numbers = frame_numbers(self.scene)
        return self._numbers

    def handle(self, positions: tuple[int, ...]) -> str:
        """Return the handle of an instance: that of its embedding, or its automatic number."""
        if len(self.scene.frames) > 1:
            own = self.at(positions).entity.embedding.handle
            return own or f"z{self._frame_numbers()[positions]}"
        numbering = self._numbers_of_scene()
        entity, before = self.root, 0
        for position in positions:
            if id(entity) not in self._offsets:
                self._offsets[id(entity)] = [count for _, count in numbering.children(entity, 0)]
            before += self._offsets[id(entity)][position]
            entity = entity.children[position].car
        return numbering.handle(entity, before)

    # --- places ------------------------------------------------------------------------------------------------

    def at(self, positions: Sequence[int], top: Located | None = None) -> Located:
        """Return the instance at child positions from the root; ``top`` is one above it that is known."""
        found = top or Located((), self.root, IDENTITY)
        for position in positions[len(found.positions) :]:
            found = self._part(found, position)
        return found

    def path(self, positions: Sequence[int]) -> str:
        """Return the path that means one instance only: all words on the way to it, without the root's."""
        entity, steps = self.root, list[str]()
        for position in positions:
            child = entity.children[position].car
            places = self._running(entity, child.word)
            total, before = places[-1], places[position]
            if not steps and child.word == self.root.word:
                steps.append(escaped(self.root.word))
            steps.append(str(PathStep(child.word, "word", before if total > 1 else None)))
            entity = child
        return "/".join(steps) or escaped(self.root.word)


def primitive_ranges(root: Entity, found: Sequence[Located]) -> list[tuple[int, int]]:
    """Return for each instance the half-open range of its primitives in the flattened frame."""
    counts: dict[int, int] = {}
    for entity in descendants(root):
        counts[id(entity)] = int(entity.is_primitive) + sum(counts[id(part.car)] for part in entity.children)
    return [_range(root, each.positions, counts) for each in found]


def _range(root: Entity, positions: Sequence[int], counts: dict[int, int]) -> tuple[int, int]:
    entity, first = root, 0
    for position in positions:
        first += sum(counts[id(part.car)] for part in entity.children[:position])
        entity = entity.children[position].car
    return first, first + counts[id(entity)]


def outermost(found: Sequence[Located]) -> Iterator[Located]:
    """Yield the instances that are not below another one, each once."""
    seen: set[tuple[int, ...]] = set()
    for each in sorted(found, key=lambda one: one.positions):
        if not any(each.positions[:k] in seen for k in range(len(each.positions) + 1)):
            seen.add(each.positions)
            yield each


def selected(scene: Scene, path: str, frame: int) -> Entity:
    """Return an entity with the outermost instances that a path means in a frame, where they are in the scene.

    Raises SceneError and LimitError as ``Locator.find`` does.
    """
    found = list(outermost(Locator(scene, frame).find(path)))
    if len(found) == 1 and not found[0].positions:
        return found[0].entity
    return Entity(path, Embedding(None, None, {}), tuple(Pair(each.entity, each.pose) for each in found))


def part_of(scene: Scene, path: str) -> Scene:
    """Return the scene of what a path means, in the frames that have it; raises SceneError if none does."""
    frames: list[Entity] = []
    problem: SceneError | None = None
    for number in range(len(scene.frames)):
        try:
            frames.append(selected(scene, path, number))
        except LimitError:
            raise
        except SceneError as error:
            problem = problem or error
            frames.append(Entity(path, Embedding(None, None, {}), ()))
    if problem is not None and not any(root.children or root.is_primitive for root in frames):
        raise problem
    return Scene(scene.word, frames, scene.animated)


def box_of(scene: Scene, text: str | None) -> Box | None:
    """Return the exact world-space box over all frames of a scene, or of a word or path in it; None without geometry.

    Raises SceneError for a path that means nothing.
    """
    return word_box(scene, text) if text is None or is_plain(text) else word_box(part_of(scene, text), None)
