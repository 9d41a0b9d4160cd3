"""Many parts of an entity as columns: what a loop places takes a third of the memory of pairs and poses.

``Entity.children`` is a tuple of pairs, or ``PartColumns``, which makes a pair when somebody reads it. A pair, its pose
and its numbers take 260 to 330 bytes, a row of the columns 100. Whatever looks at all parts of large scenes reads the
columns (``flatten.graph_of``, ``descendants`` and the counts); everything else iterates over pairs as before.

Forms that make parts return columns to each other and to the entity around them (``Analysis.parts``); programs see
lists of pairs. Lists whose pairs are made when they are read were tried for all of them: an attribute hook on ``Pair``
keeps CPython from specializing its attributes, and made programs on lists 1.7 times slower.
"""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import repeat
from math import isfinite
from typing import TYPE_CHECKING, Any, overload

from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.pose import compose, packed, products
from scenelang.interpreter.values.values import IDENTITY, Matrix, Pair

if TYPE_CHECKING:
    from scenelang.interpreter.scene.entity import Entity

_ENTRIES = len(IDENTITY)  # numbers of a pose
_MIN_ARRAY = 4_000  # parts that are multiplied by numpy
MIN_COLUMNS = 256  # parts: fewer stay pairs, which are as small beside their entities and faster to read


class PartColumns(Sequence[Pair]):
    """Parts of an entity, pairs ``(Entity . Matrix)`` that are made when they are read.

    Attributes
    ----------
    entities
        Distinct entities, in the order of their first parts.
    numbers
        For each part, the index of its entity (N,).
    poses
        The twelve numbers of each pose, one pose after another (12 N,).

    Examples
    --------
    >>> columns = PartColumns.of([Pair(entity, IDENTITY)] * 3)
    >>> len(columns), len(columns.entities)
    (3, 1)
    """

    __slots__ = ("entities", "numbers", "poses")

    def __init__(self, entities: tuple[Entity, ...], numbers: array[int], poses: array[float]) -> None:
        self.entities = entities
        self.numbers = numbers
        self.poses = poses

    @staticmethod
    def of(parts: Iterable[Pair]) -> PartColumns:
        """Return the columns of pairs."""
        gathered = GatheredParts()
        gathered.extend(parts)
        return gathered.columns()

    def __len__(self) -> int:
        return len(self.numbers)

    def __iter__(self) -> Iterator[Pair]:
        entries = iter(self.poses)
        poses = map(Matrix, zip(*repeat(entries, _ENTRIES)))
        return map(Pair, map(self.entities.__getitem__, self.numbers), poses)

    @overload
    def __getitem__(self, index: int) -> Pair: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Pair, ...]: ...

    def __getitem__(self, index: int | slice) -> Pair | tuple[Pair, ...]:
        if isinstance(index, slice):
            return tuple([self._pair(i) for i in range(*index.indices(len(self)))])
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        return self._pair(index % len(self))

    def _pair(self, index: int) -> Pair:
        """Return the part with an index from 0."""
        pose = self.poses[_ENTRIES * index : _ENTRIES * (index + 1)]
        return Pair(self.entities[self.numbers[index]], Matrix(pose))

    def moved(self, pose: Sequence[float]) -> PartColumns | None:
        """Return the parts with their poses multiplied by one from the left, or None if a product is not finite.

        Both ways give the same bits; numpy takes 50 ms to load, and then .04 us a pose instead of 1.3.
        """
        count = len(self)
        if count < _MIN_ARRAY:
            poses = array("d")
            for low in range(0, _ENTRIES * count, _ENTRIES):
                poses.extend(compose(pose, self.poses[low : low + _ENTRIES]))
        else:
            poses = array("d")
            poses.frombytes(products(pose, np.frombuffer(self.poses).reshape(count, _ENTRIES)).tobytes())
        if not isfinite(sum(poses)) and not all(map(isfinite, poses)):  # the sum of finite numbers may overflow
            return None
        return PartColumns(self.entities, self.numbers, poses)


class GatheredParts:
    """Columns that grow: parts in the order in which a form evaluates them."""

    __slots__ = ("_entities", "_numbers", "_poses")

    def __init__(self) -> None:
        self._entities: dict[Entity, int] = {}
        self._numbers: array[int] = array("I")
        self._poses: array[float] = array("d")

    def __len__(self) -> int:
        return len(self._numbers)

    def extend(self, parts: Iterable[Pair]) -> None:
        """Add parts; columns are added as they are."""
        number = self._entities.setdefault
        if isinstance(parts, PartColumns):
            numbers = [number(entity, len(self._entities)) for entity in parts.entities]
            self._numbers.extend(map(numbers.__getitem__, parts.numbers))
            self._poses.extend(parts.poses)
            return
        if not isinstance(parts, (list, tuple)):
            parts = list(parts)
        self._numbers.extend([number(part.car, len(self._entities)) for part in parts])
        self._poses.frombytes(packed([part.cdr for part in parts]))

    def columns(self) -> PartColumns:
        """Return the parts so far; nothing may be added afterwards."""
        return PartColumns(tuple(self._entities), self._numbers, self._poses)


def distinct_entities(parts: Sequence[Any]) -> Iterable[Entity]:
    """Return the distinct entities of parts in the order of their first ones.

    Asking of each of a million parts whether its entity is known is slow.
    """
    if type(parts) is PartColumns:
        return parts.entities
    entities = [part.car for part in parts]
    return dict.fromkeys(entities) if len(entities) > 1 else entities


def entity_times(parts: Sequence[Any]) -> Iterable[tuple[Entity, int]]:
    """Return the distinct entities of parts with the number of their parts."""
    if type(parts) is not PartColumns:
        return Counter([part.car for part in parts]).items()
    times = Counter(parts.numbers)
    return [(entity, times[number]) for number, entity in enumerate(parts.entities)]
