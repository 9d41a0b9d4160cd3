"""Every builtin notes what it reads: a call before and one after a change give what they give without sharing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from random import Random
from typing import Any

import numpy as np
import pytest
from metering.samples import Sample, functions, small_samples

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.runtime import Runtime, raised_value
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.values.limits import Limits
from scenelang.interpreter.values.values import (
    NIL,
    Embedding,
    Keyword,
    Mutable,
    MutableArray,
    MutableList,
    Pair,
    Record,
    RecordType,
    Set,
    Table,
    Vector,
    make_list,
)
from scenelang.stdlib.library import IMPORTED, TOPICS, build_library, registry_of

BUILTINS = {
    name: entry for topic in (*TOPICS, *IMPORTED.values()) for name, entry in registry_of(topic).entries.items()
}
FEW, MANY = 14, 600  # calls tried of a builtin


@dataclass(frozen=True, slots=True)
class Change:
    """A mutable thing, inside ``wrap`` of it, and what is done to it between two calls."""

    name: str
    make: Callable[[], Mutable]
    change: Callable[[Any], None]
    wrap: Callable[[Any], Any] = lambda thing: thing


def _replace(items: list[Any]) -> Callable[[Any], None]:
    def change(thing: Any) -> None:
        thing.items[:] = items

    return change


def _fill(number: float) -> Callable[[Any], None]:
    def change(thing: Any) -> None:
        thing.data[...] = number

    return change


def _entries(**entries: Any) -> dict[str, tuple[str, Any]]:
    return {name: (name, value) for name, value in entries.items()}


def _table() -> Table:
    return Table(_entries(a=1), 1)


def _more_entries(table: Any) -> None:
    table.entries.update(_entries(a=5, b=2))


def _more_members(members: Any) -> None:
    members.entries.update({9: 9, "x": "x"})


def _list(*items: Any) -> Callable[[], MutableList]:
    return lambda: MutableList(list(items), 1)


def _pose() -> MutableArray:
    return MutableArray(np.eye(4), 1)


def _move(array: Any) -> None:
    array.data[0, 3] = 5.0


def _record() -> Record:
    return Record(RecordType("point", ("x", "y")), [1, 2], 1)


def _change_record(record: Any) -> None:
    record.values[0] = 7


CHANGES = [
    Change("numbers", _list(3, 1, 2), _replace([5, 1, 2])),
    Change("numbers that grow", _list(3, 1, 2), _replace([3, 1, 2, 4])),
    Change("numbers that become strings", _list(3, 1, 2), _replace(["b", "a", "c"])),
    Change("strings that become numbers", _list("a", "b"), _replace([1.0, 2.0, 3.0])),
    Change("nothing that becomes something", _list(), _replace([Pair("a", 1)])),
    Change("pairs", _list(Pair("a", 1)), _replace([Pair("a", 2), Pair("b", 3)])),
    Change("array", lambda: MutableArray(np.array([1.0, 2.0, 3.0]), 1), _fill(7)),
    Change("pose", _pose, _move),
    Change("pose that is none any more", _pose, _fill(3)),
    Change("table", _table, _more_entries),
    Change("set", lambda: Set({1: 1, 2: 2}, 1), _more_members),
    Change("record", _record, _change_record),
    Change("list in a list", _list(3, 1), _replace(["x"]), lambda thing: make_list((thing, thing))),
    Change("row of a list", _list(1, 2), _replace([3, 4]), lambda thing: make_list((thing, Vector((1, 2))))),
    Change("array in a list", lambda: MutableArray(np.array([1.0, 2.0]), 1), _fill(7), lambda t: make_list((t, t))),
    Change("four rows", _list(0, 0, 0, 1), _replace([0, 0, 0, 2]), lambda t: make_list((*_three_rows(), t))),
    Change("list in a pair", _list(1), _replace([2]), lambda thing: Pair("a", thing)),
    Change("table in a list", _table, _more_entries, lambda thing: make_list((thing,))),
    Change("list in an embedding", _list(1), _replace([2]), lambda thing: Embedding(None, None, {"a": thing})),
    Change("list in a list that can change", _list(1), _replace([2, 3]), lambda thing: MutableList([thing], 1)),
]


def _three_rows() -> list[Vector]:
    return [Vector(row) for row in ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))]


def _others() -> list[Sample]:
    return [*small_samples(), *functions()[:3]]


def _calls(builtin: Builtin, most: int) -> Iterator[tuple[Change, int, tuple[Sample, ...], str | None]]:
    """Every change in every place, beside other arguments; a keyword takes the place behind the positional ones."""
    signature = builtin.signature
    least = len(signature.required)
    longest = least + len(signature.optional) + (2 if signature.rest is not None else 0)
    rows = []
    for count in range(max(1, least), longest + 1):
        for place, change in product(range(count), CHANGES):
            for others in product(_others(), repeat=min(count - 1, 1)):
                rows.append((change, place, others * (count - 1), None))
    for keyword in signature.keywords:
        for change in CHANGES:
            rows.append((change, least, (_others()[6],) * least, keyword.name))
    random = Random(builtin.name)
    yield from rows if len(rows) <= most else random.sample(rows, most)


def _texts(rt: Runtime, builtin: Builtin, call: tuple[Change, int, tuple[Sample, ...], str | None]) -> list[str]:
    """What the call gives, as text, before and after the change, each inside a call of a word."""
    change, place, others, keyword = call
    rt.reset()
    rt.invalidate_calls()
    thing = change.make()
    arguments = [sample.make() for sample in others]
    given = change.wrap(thing)

    def body(rt: Runtime) -> Any:
        values = [*arguments[:place], given, *arguments[place:]]
        if keyword is not None:
            values.insert(place, Keyword(keyword))
        try:
            text = rt.show(rt.apply(builtin, values))
        except SceneError as error:
            text = rt.apply(BUILTINS["error-message"], [raised_value(error)])
        return rt.primitive("cube", Embedding(None, text))

    rt.bind_word("word", Builtin("word", "", "Entity", body, "", None, "test"))
    texts = []
    for _ in range(2):
        entity = rt.call_word("word", Embedding(), NIL, frozenset(), None)
        texts.append(entity.children[0].car.embedding.text)
        rt.write(thing)
        change.change(thing)
    return texts


def _check(name: str, most: int) -> None:
    builtin = BUILTINS[name]
    shared, unshared = (Runtime(build_library(), Limits(seconds=3600.0), memoize=memoize) for memoize in (True, False))
    for call in _calls(builtin, most):
        described = (name, call[0].name, call[1], [sample.name for sample in call[2]], call[3])
        assert _texts(shared, builtin, call) == _texts(unshared, builtin, call), described


@pytest.mark.parametrize("name", sorted(BUILTINS))
@pytest.mark.sampled(3)
def test_a_change_is_seen(name: str) -> None:
    _check(name, FEW)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(BUILTINS))
def test_a_change_is_seen_by_many_calls(name: str) -> None:
    _check(name, MANY)
