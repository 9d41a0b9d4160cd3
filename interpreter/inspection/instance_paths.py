"""Paths to the instances of a scene, such as ``chair/leg[2]``: words from the root down, the same everywhere.

A step is a word: it selects the outermost instances of that word below those of the step before; the first step may
select the root as well. ``leg[2]`` is the third of them in the order of the tree (numbers start at 0, as for frames
and lists), ``<z3>`` the instance with a handle, and ``*`` every direct part. Intermediate words may be left out, so a
word alone is a path. A backslash escapes a character.

Steps are words at any depth and not child positions, so that ``chair/leg[2]`` still holds after a ``union`` is added.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import LimitError, SceneError, suggest
from scenelang.interpreter.inspection.numbering import Numbering, frame_numbers, number_scene
from scenelang.interpreter.scene.bounds import word_box
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.part_columns import distinct_entities, entity_times
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.scene.primitives.base import Box
from scenelang.interpreter.values.values import IDENTITY, Embedding, Matrix, Pair

MAX_INSTANCES = 100_000  # that a path may select
_MAX_CHARACTERS = 2_000  # of a path
_MAX_CACHED_WORDS = 64  # words whose counts are cached
_MAX_LISTED_WORDS = 12  # of the parts where a path fails, in a hint
_MAX_EXAMINED = 100  # instances in which the words for a hint are looked up
_MAX_SHOWN_CHARACTERS = 80  # of a malformed path, in a message
_SPECIAL = frozenset("/[]\\")
_ANY = "*"


@dataclass(frozen=True, slots=True)
class PathStep:
    """Step of a path: a word, a handle or any part, and the index of one of its instances, or None for all."""

    name: str
    kind: str = "word"  # or "handle", "any"
    index: int | None = None

    def __str__(self) -> str:
        name = {"word": escaped(self.name), "handle": f"<{self.name}>"}.get(self.kind, _ANY)
        return name if self.index is None else f"{name}[{self.index}]"


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """Instance in a frame: its child positions from the root, its entity, and its world pose."""

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
    """Return whether a path is a word without special characters."""
    return not _SPECIAL & set(text) and text != _ANY and not text.startswith("<")


def is_handle(text: str) -> bool:
    """Return whether a path is a single handle, such as ``<z3>``."""
    return text.startswith("<") and text.endswith(">") and len(text) > 2 and not _SPECIAL & set(text)


def read_path(text: str) -> tuple[PathStep, ...]:
    r"""Read a path. Raises SceneError("value") for a path that is malformed.

    Examples
    --------
    >>> [str(step) for step in read_path("room/chair[1]/<z3>")]
    ['room', 'chair[1]', '<z3>']
    """
    if len(text) > _MAX_CHARACTERS:
        raise SceneError("value", f"a path has at most {_MAX_CHARACTERS:,} characters, got {len(text):,}")
    return tuple(_step(text, part) for part in _split(text))


def _split(text: str) -> list[list[tuple[str, bool]]]:
    """Split a path into steps: their characters, and whether a backslash escapes each."""
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
    """Return a step of its characters; ``text`` is the whole path, for error messages."""
    index = None
    opening = next((k for k, character in enumerate(part) if character == ("[", False)), None)
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
    """Return the error for a malformed path."""
    shown = text if len(text) <= _MAX_SHOWN_CHARACTERS else text[: _MAX_SHOWN_CHARACTERS - 3] + "..."
    return SceneError("value", f"`{shown}` is no path: {why}", "write `chair/leg[2]`; a backslash escapes / [ ]")


# --- finding instances -----------------------------------------------------------------------------------------------


class Locator:
    """Finds the instances of one frame of a scene by path.

    Counts of words are cached by entity, so that a search skips subtrees without the word and nothing is expanded.
    """

    def __init__(self, scene: Scene, frame: int = 0) -> None:
        """Prepare a frame; the indexes are built when they are needed."""
        self.scene = scene
        self.root = scene.frames[frame]
        self._counts_by_word: dict[str, dict[int, int]] = {}  # numbers of outermost instances, by word and entity's id
        self._before: dict[tuple[int, str], list[int]] = {}  # their running sums over the parts of an entity
        self._entities: list[Entity] | None = None
        self._numbering: Numbering | None = None
        self._numbers: dict[tuple[int, ...], int] | None = None
        self._offsets: dict[int, list[int]] = {}  # instances without a handle before each part
        self._paths: dict[int, tuple[int, ...]] = {}

    def find(self, text: str, start: Located | None = None) -> list[Located]:
        """Return the instances that a path selects, in the order of the tree; at least one.

        A text that is not a path, or selects nothing, may be a word with special characters.

        Parameters
        ----------
        text
            Path, handle or word.
        start
            Instance to search, the root by default.

        Raises
        ------
        SceneError
            "value" if the path is malformed, or there is no such instance.
        LimitError
            If there are more than 100,000.
        """
        top = start or Located((), self.root, IDENTITY)
        try:
            return self._select(read_path(text), top)
        except LimitError:
            raise
        except SceneError:
            words = [] if is_plain(text) else self._under(top, PathStep(text), with_top=True)
            if not words:
                raise
            return words

    def _select(self, steps: Sequence[PathStep], top: Located) -> list[Located]:
        """Return the instances that the steps select below ``top``."""
        selection = [top]
        for number, step in enumerate(steps):
            below: list[Located] = []
            for instance in selection:
                below += self._under(instance, step, with_top=number == 0)
            if not below:
                raise self._missing(steps[:number], step, selection)
            if len(below) > MAX_INSTANCES:
                raise LimitError("primitives", f"the path means more than {MAX_INSTANCES:,} instances")
            selection = below
        return selection

    def _missing(self, before: Sequence[PathStep], step: PathStep, selection: Sequence[Located]) -> SceneError:
        """Return the error for a step that selects nothing, with the number of such parts or a similar word."""
        around = "/".join(map(str, before)) or self.root.word
        every = PathStep(step.name, step.kind)
        if step.index is not None:
            examined = selection[:_MAX_EXAMINED]
            most = max(len(self._under(instance, every, with_top=not before)) for instance in examined)
            if most:
                counted = f"are {most} `{every}`, numbered from 0" if most > 1 else f"is only one `{every}`"
                return SceneError("value", f"no part `{step}` in `{around}`", f"there {counted}")
        words = sorted({e.word for instance in selection[:_MAX_EXAMINED] for e in descendants(instance.entity)})
        hint = None
        if step.kind == "word":
            shown = ", ".join(words[:_MAX_LISTED_WORDS]) + (", ..." if len(words) > _MAX_LISTED_WORDS else "")
            hint = suggest(step.name, words) or f"its words are {shown}"
        return SceneError("value", f"no part `{step}` in `{around}`", hint)

    def _under(self, top: Located, step: PathStep, *, with_top: bool) -> list[Located]:
        """Return the instances that a step selects below ``top``, which may be one of them if ``with_top``."""
        if step.kind == "any":
            selection = [self._part(top, k) for k in range(len(top.entity.children))]
        elif step.kind == "handle":
            selection = self._with_handle(top, step.name)
        else:
            return self._with_word(top, step, with_top=with_top)
        return selection if step.index is None else selection[step.index : step.index + 1]

    def _with_word(self, top: Located, step: PathStep, *, with_top: bool) -> list[Located]:
        """Return the outermost instances of a word; for one index, subtrees before it are skipped by their counts."""
        if with_top and top.entity.word == step.name:
            return [top] if not step.index else []
        counts = self._counts(step.name)
        selection: list[Located] = []
        skip = step.index or 0
        stack = self._parts(top, counts)
        while stack and len(selection) <= MAX_INSTANCES:
            instance = stack.pop()
            if skip >= counts[id(instance.entity)]:
                skip -= counts[id(instance.entity)]
            elif instance.entity.word == step.name:
                selection.append(instance)
                if step.index is not None:
                    break
            else:
                stack += self._parts(instance, counts)
        return selection

    def _parts(self, top: Located, counts: dict[int, int]) -> list[Located]:
        """Return the parts that contain counted instances, the first one last, as the search stack needs them."""
        places = range(len(top.entity.children) - 1, -1, -1)
        return [self._part(top, k) for k in places if counts[id(top.entity.children[k].car)]]

    @staticmethod
    def _part(top: Located, position: int) -> Located:
        """Return the part of an instance at a child position."""
        part = top.entity.children[position]
        return Located((*top.positions, position), part.car, compose(top.pose, part.cdr))

    def _counts(self, word: str) -> dict[int, int]:
        """Return for each entity the number of outermost instances of a word in it, by ``id``."""
        if word not in self._counts_by_word:
            if len(self._counts_by_word) >= _MAX_CACHED_WORDS:  # each table has a row for every entity of the scene
                self._counts_by_word.clear()
            if self._entities is None:
                self._entities = list(descendants(self.root))  # children first
            counts: dict[int, int] = {}
            for entity in self._entities:
                if entity.word == word:
                    counts[id(entity)] = 1  # instances inside it are not outermost
                else:
                    counts[id(entity)] = sum(
                        times * counts[id(child)] for child, times in entity_times(entity.children)
                    )
            self._counts_by_word[word] = counts
        return self._counts_by_word[word]

    def _running(self, entity: Entity, word: str) -> list[int]:
        """Return the number of outermost instances of a word before each part of an entity, and in all of them."""
        key = id(entity), word
        if key not in self._before:
            if len(self._before) >= _MAX_CACHED_WORDS:
                self._before.clear()
            counts = self._counts(word)
            self._before[key] = [0, *accumulate(counts[id(part.car)] for part in entity.children)]
        return self._before[key]

    # --- handles -----------------------------------------------------------------------------------------------

    def _with_handle(self, top: Located, handle: str) -> list[Located]:
        """Return the instances with a handle: an automatic number, or that of an embedding, which several may have."""
        positions = self._numbered(handle)
        if positions is not None:
            below = positions[: len(top.positions)] == top.positions
            return [self.at(positions, top)] if below else []
        selection: list[Located] = []
        stack, holding = [top], self._holding(handle)
        while stack and len(selection) <= MAX_INSTANCES:
            instance = stack.pop()
            if instance.entity.embedding.handle == handle:
                selection.append(instance)
            parts = instance.entity.children
            stack += [self._part(instance, k) for k in range(len(parts) - 1, -1, -1) if id(parts[k].car) in holding]
        return selection

    def _holding(self, handle: str) -> set[int]:
        """Return the ``id`` of each entity that has, or contains, a handle of an embedding."""
        holders: set[int] = set()
        for entity in descendants(self.root):
            if entity.embedding.handle == handle or any(
                id(child) in holders for child in distinct_entities(entity.children)
            ):
                holders.add(id(entity))
        return holders

    def _numbered(self, handle: str) -> tuple[int, ...] | None:
        """Return the child positions of the instance with an automatic number in the frame, or None."""
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
        """Return whether this frame has an instance without a handle at child positions, as another frame does."""
        entity = self.root
        for position in positions:
            if position >= len(entity.children):
                return False
            entity = entity.children[position].car
        return entity.embedding.handle is None

    def _numbers_of_scene(self) -> Numbering:
        """Return the numbering of a static scene, cached."""
        if self._numbering is None:
            self._numbering = number_scene(self.scene)
        return self._numbering

    def _frame_numbers(self) -> dict[tuple[int, ...], int]:
        """Return the numbers of a scene with several frames, cached."""
        if self._numbers is None:
            self._numbers = frame_numbers(self.scene)
        return self._numbers

    def handle(self, positions: tuple[int, ...]) -> str:
        """Return the handle of an instance: that of its embedding, or its automatic number."""
        if len(self.scene.frames) > 1:
            handle = self.at(positions).entity.embedding.handle
            return handle or f"z{self._frame_numbers()[positions]}"
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
        """Return the instance at child positions from the root; the walk starts at ``top``, an ancestor, if given."""
        instance = top or Located((), self.root, IDENTITY)
        for position in positions[len(instance.positions) :]:
            instance = self._part(instance, position)
        return instance

    def path(self, positions: Sequence[int]) -> str:
        """Return the path that selects only the instance at these child positions.

        It has all words on the way to the instance, without that of the root.
        """
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


def primitive_ranges(root: Entity, instances: Sequence[Located]) -> list[tuple[int, int]]:
    """Return for each located instance its primitives in the flattened frame, as a half-open range of indices."""
    counts: dict[int, int] = {}
    for entity in descendants(root):
        below = sum(times * counts[id(child)] for child, times in entity_times(entity.children))
        counts[id(entity)] = int(entity.is_primitive) + below
    return [_range(root, instance.positions, counts) for instance in instances]


def _range(root: Entity, positions: Sequence[int], counts: dict[int, int]) -> tuple[int, int]:
    """Return the range of the primitives of one instance; ``counts`` are the primitives below each entity."""
    entity, first = root, 0
    for position in positions:
        first += sum(counts[id(part.car)] for part in entity.children[:position])
        entity = entity.children[position].car
    return first, first + counts[id(entity)]


def outermost(instances: Sequence[Located]) -> Iterator[Located]:
    """Yield the instances that are not below another one, each once."""
    yielded: set[tuple[int, ...]] = set()
    for instance in sorted(instances, key=lambda one: one.positions):  # ancestors first
        if not any(instance.positions[:k] in yielded for k in range(len(instance.positions) + 1)):
            yielded.add(instance.positions)
            yield instance


def selected(scene: Scene, path: str, frame: int) -> Entity:
    """Return an entity with the outermost instances that a path selects in a frame, under their world poses.

    Raises SceneError and LimitError as ``Locator.find`` does.
    """
    instances = list(outermost(Locator(scene, frame).find(path)))
    if len(instances) == 1 and not instances[0].positions:
        return instances[0].entity
    return Entity(path, Embedding(None, None, {}), tuple(Pair(part.entity, part.pose) for part in instances))


def part_of(scene: Scene, path: str) -> Scene:
    """Return a scene of the instances that a path selects, in each frame.

    Parameters
    ----------
    path
        Path such as ``chair/leg[2]``; the docstring of this module has the syntax.

    Returns
    -------
    Scene
        As many frames as the scene has; those without such an instance are empty.

    Raises
    ------
    SceneError
        If no frame has such an instance, or the path is malformed.
    LimitError
        If too many instances are selected.
    """
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
    return scene.with_frames(frames)


def box_of(scene: Scene, text: str | None) -> Box | None:
    """Return the exact world-space box over all frames of a scene; None without geometry.

    With ``text``, a word or path, only its instances are measured. Raises SceneError for a path that selects nothing.
    """
    return word_box(scene, text) if text is None or is_plain(text) else word_box(part_of(scene, text), None)
