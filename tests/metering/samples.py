"""Arguments of a size for every type that a signature names: plain ones, and those that are known to be dear.

``samples(type_name, n)`` gives makers, so that a mutable argument is new for every call.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from random import Random
from typing import Any

import numpy as np

from scenelang.grammar.datum import Keyword, Symbol
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.procedures import Condition
from scenelang.interpreter.runtime.types import Builtin, BuiltinParameter, Signature
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values.values import (
    IDENTITY,
    NIL,
    Array,
    Embedding,
    HandleList,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Record,
    RecordType,
    Set,
    Stream,
    Table,
    Vector,
    make_list,
    table_key,
)

COLLIDING = (1 << 61) - 1  # CPython gives all its multiples one hash
_FEW = 200  # items of what is quadratic to make


@dataclass(frozen=True, slots=True)
class Sample:
    """An argument. ``large``: its size follows n; ``make`` gives the value."""

    name: str
    make: Callable[[], Any]
    large: bool = True


def _same(name: str, value: Any, large: bool = True) -> Sample:
    return Sample(name, lambda: value, large)


def _function(name: str, body: Callable[..., Any]) -> Sample:
    builtin = Builtin(name, "arguments ...", "Any", lambda rt, *arguments: body(*arguments), "", None, "test")
    return Sample(name, lambda: builtin, large=False)


def doubled(value: Any, times: int) -> Any:
    """Data of ``2 ** times`` items that share all their parts."""
    for _ in range(times):
        value = make_list((value, value))
    return value


def _deep(n: int) -> Any:
    value: Any = NIL
    for _ in range(n):
        value = Pair(value, NIL)
    return value


def _table(n: int, multiple: int = 1) -> Callable[[], Table]:
    def make() -> Table:
        return Table({table_key(i * multiple): (i * multiple, i) for i in range(n)}, 1)

    return make


def _set(members: Sequence[Any]) -> Callable[[], Set]:
    return lambda: Set({table_key(member): member for member in members}, 1)


def _parts(n: int) -> Any:
    cube = Entity("cube", Embedding(), ())
    return make_list([Pair(cube, IDENTITY) for _ in range(n)])


def _texts(n: int) -> list[Sample]:
    distinct = "".join(chr(0x100 + i % 0xC000) for i in range(n))
    return [
        _same("text", "a" * n),
        _same("distinct text", distinct),
        _same("distinct text, reversed", distinct[::-1]),
        _same("blanks and letters", "a " * (n // 2)),
        _same("fields", "{}" * (n // 2)),
        _same("percent fields", "%s" * (n // 2)),
        _same("nearly a half", "a" * (n // 2) + "b"),
    ]


def _lists(n: int) -> list[Sample]:
    numbers = make_list(range(n))
    side = max(2, int(n**0.5))
    shared_row = make_list(range(n // 10))
    return [
        _same("list", numbers),
        _same("list of floats", make_list([i * 0.5 for i in range(n)])),
        _same("list, falling", make_list(range(n, 0, -1))),
        _same("list of texts", make_list([f"{i % 97}" for i in range(n)])),
        _same("list of long texts", make_list(["a" * n] * 10)),
        _same("list of pairs", make_list([Pair(i, i) for i in range(n)])),
        _same("list of short lists", make_list([make_list((i, 1, 2)) for i in range(n // 3)])),
        _same("list of rows", make_list([make_list(range(side)) for _ in range(side)])),
        _same("list of vectors", make_list([Vector((float(i), 1.0, 2.0)) for i in range(n // 3)])),
        _same("one row many times", make_list([shared_row] * (n // 10))),
        _same("one vector many times", make_list([Vector(range(n // 10))] * (n // 10))),
        _same("colliding integers", make_list([i * COLLIDING for i in range(n)])),
        _same("long integers", make_list([(1 << 4000) + i for i in range(n // 10)])),
        _same("doubled", doubled(make_list((1,)), 28)),
        _same("one doubled item", make_list((doubled(make_list((1,)), 28), 1))),
        _same("deep", _deep(n)),
        _same("improper", make_list(range(n), 5)),
        _same("not numbers at the end", make_list([*range(n), "a"])),
        _same("parts", _parts(n)),
        _same("doubled parts", doubled(_parts(1), 28)),
    ]


def _arrays(n: int) -> list[Sample]:
    side = max(2, int(n**0.5))
    return [
        _same("vector", Vector(range(n))),
        _same("vector of floats", Vector([i * 0.5 for i in range(n)])),
        _same("square array", Array(np.arange(float(side * side)).reshape(side, side))),
        _same("array of integers", Array(np.arange(side * side).reshape(side, side))),
        _same("tall array", Array(np.ones((n // 2, 2)))),
        _same("array of zeros", Array(np.zeros((side, side)))),
        Sample("mutable array", lambda: MutableArray(np.arange(float(n)), 1)),
        Sample("mutable square array", lambda: MutableArray(np.ones((side, side)), 1)),
    ]


def _mutable(n: int) -> list[Sample]:
    return [
        Sample("mutable list", lambda: MutableList(list(range(n)), 1)),
        Sample("mutable list of rows", lambda: MutableList([make_list((i, 2)) for i in range(n // 2)], 1)),
        Sample("table", _table(n)),
        Sample("table of few colliding keys", _table(_FEW, COLLIDING)),
        Sample("set", _set(range(n))),
        Sample("set of texts", _set([str(i) for i in range(n)])),
        Sample("record", lambda: Record(RecordType("point", ("x", "y")), [make_list(range(n)), 2], 1)),
    ]


def _entities(n: int) -> list[Sample]:
    children = tuple(Pair(Entity("cube", Embedding(), ()), IDENTITY) for _ in range(n))
    wide = Entity("wide", Embedding(), children)
    narrow = Entity("cube", Embedding(), ())
    for _ in range(28):
        narrow = Entity("twice", Embedding(), (Pair(narrow, IDENTITY), Pair(narrow, IDENTITY)))
    return [_same("wide entity", wide), _same("doubled entity", narrow)]


def _embeddings(n: int) -> list[Sample]:
    return [
        _same("embedding", Embedding(None, None, {f"a{i}": i for i in range(n)})),
        _same("embedding of long text", Embedding(None, "a" * n)),
        _same("embedding of shared data", Embedding(None, None, {"x": doubled(NIL, 28)})),
        _same("embedding of a list", Embedding(None, None, {"x": make_list(range(n))})),
    ]


def small_samples() -> list[Sample]:
    return [
        _same("0", 0, False), _same("2", 2, False), _same("0.5", 0.5, False), _same("a", "a", False),
        _same("none", None, False), _same("#t", True, False), _same("(1 2)", make_list((1, 2)), False),
        _same("[1 2 3]", Vector((1.0, 2.0, 3.0)), False), _same(":x", Keyword("x"), False),
    ]  # fmt: skip


def _first_is_less(*arguments: Any) -> bool:
    numbers = [argument for argument in arguments if type(argument) in (int, float)]
    return len(numbers) > 1 and bool(numbers[0] < numbers[-1])


def functions() -> list[Sample]:
    shared = doubled(make_list((1,)), 28)
    return [
        _function("identity", lambda *arguments: arguments[0] if arguments else None),
        _function("false", lambda *arguments: False),
        _function("less", _first_is_less),
        _function("long list", lambda *arguments: shared),
    ]


def _numbers(n: int) -> list[Sample]:
    return [
        _same("n", n), _same("-n", -n, False), _same("long integer", (1 << 13_000) + 12345),
        _same("long odd integer", 3**8000), _same("half n", n // 2), _same("float", 1e300, False),
    ]  # fmt: skip


def _streams() -> list[Sample]:
    return [
        Sample("numpy stream", lambda: Stream("random-stream", np.random.RandomState(1), 1), False),
        Sample("python stream", lambda: Stream("py-random-stream", Random(1), 1), False),
    ]


def _named(samples: Sequence[Sample], *names: str) -> list[Sample]:
    return [sample for sample in samples if sample.name in names]


def samples(n: int) -> dict[str, list[Sample]]:
    """The arguments to try for every type, by its name; those of ``Any`` are all of them."""
    texts, lists, arrays, mutable, numbers = _texts(n), _lists(n), _arrays(n), _mutable(n), _numbers(n)
    entities, embeddings, small, streams, procedures = (
        _entities(n), _embeddings(n), small_samples(), _streams(), functions(),
    )  # fmt: skip
    integers = [*_named(small, "0", "2"), *_named(numbers, "n", "half n", "-n", "long integer", "long odd integer")]
    handles = [_same("handles", HandleList(2), False)]
    error = [_same("error", Condition(SceneError("user", "a" * n)))]
    booleans = [_same("#f", False, False), _same("#t", True, False)]
    pose = [_same("pose", IDENTITY, False)]
    symbols = [_same("symbol", Symbol("a" * n))]
    everything = [
        *texts, *lists, *arrays, *mutable, *numbers, *entities, *embeddings, *small, *streams[:1], *procedures[:2],
        *handles, *error, *pose, *symbols,
    ]  # fmt: skip
    parts = _named(lists, "parts", "doubled parts", "list")
    vectors = [*_named(arrays, "vector", "vector of floats", "mutable array"), *lists[:3], *_named(small, "[1 2 3]")]
    short_text = _named(small, "a")
    return {
        "Any": everything,
        "Numeric": everything,
        "ArrayLike": everything,
        "Sequence": [*lists, *arrays, *mutable[:-1], *texts, *_named(small, "(1 2)")],
        "List": [*lists, *mutable[:2], *handles, *_named(small, "(1 2)")],
        "Array": arrays,
        "Vector": [*vectors, *_named(lists, "not numbers at the end", "doubled")],
        "Integer": integers,
        "Number": [*integers, *_named(small, "0.5"), *_named(numbers, "float")],
        "Float": [*_named(small, "0.5"), *_named(numbers, "float", "long integer")],
        "String": [*texts, *short_text],
        "Word": [*texts[:1], *short_text],
        "Embedding": [*embeddings, *texts[:1]],
        "Entity": entities,
        "Parts": [*entities, *parts],
        "List[Parts]": parts,
        "Template": [*entities, *parts, *procedures],
        "Axis": [_same(":y", Keyword("y"), False)],
        "Alignment": [_same(":max", Keyword("max"), False), _same("none", None, False)],
        "Extent": [*_named(small, "0.5", "[1 2 3]"), *vectors],
        "Point": [*vectors, *_named(small, "[1 2 3]")],
        "Function": procedures,
        "Stream": streams,
        "Table": mutable[2:4],
        "Set": mutable[4:6],
        "Boolean": booleans,
        "Symbol": symbols,
        "Keyword": [_same(f":{name}", Keyword(name), False) for name in ("left", "miter", "even-odd", "y")],
        "MutableList": mutable[:2],
        "MutableArray": arrays[-2:],
        "Matrix": [_same("pose", Matrix(IDENTITY), False)],
    }


Call = tuple[tuple[Sample, ...], dict[str, Sample]]


def _positionals(signature: Signature) -> Iterator[tuple[BuiltinParameter, ...]]:
    """The parameters of the calls to try: the required ones, and as many optional ones as there are."""
    yield signature.required
    for count in range(1, len(signature.optional) + 1):
        yield (*signature.required, *signature.optional[:count])
    if signature.rest is not None:
        for count in (1, 2):
            yield (*signature.required, *signature.optional, *[signature.rest] * count)


def calls(signature: Signature, known: dict[str, list[Sample]], most: int, random: Random) -> list[Call]:
    """Up to ``most`` calls per number of arguments, each with at least one large argument where there can be one.
    Raises KeyError for a type without samples."""
    found: list[Call] = []
    for parameters in _positionals(signature):
        choices = [known[parameter.type.name] for parameter in parameters]
        total = 1
        for choice in choices:
            total *= len(choice)
        if total <= most:
            rows = list(product(*choices))
        else:
            rows = [*_one_large(choices), *(tuple(map(random.choice, choices)) for _ in range(most))]
            rows = random.sample(rows, most)
        found += [(row, {}) for row in rows]
        for keyword in signature.keywords:
            name = keyword.name.replace("-", "_")
            for row in random.sample(rows, min(len(rows), max(1, most // 8))):
                found.append((row, {name: random.choice(known[keyword.type.name])}))
    return found


def _one_large(choices: Sequence[Sequence[Sample]]) -> Iterator[tuple[Sample, ...]]:
    """Every large argument once in every place, beside small ones where there are any."""
    for place, choice in enumerate(choices):
        for sample in choice:
            others = [[s for s in other if not s.large] or list(other[:1]) for other in choices]
            row = [other[place % len(other)] for other in others]
            row[place] = sample
            yield tuple(row)


def arguments(call: Call) -> tuple[list[Any], dict[str, Any]]:
    positional, keywords = call
    return [sample.make() for sample in positional], {name: sample.make() for name, sample in keywords.items()}


def described(name: str, call: Call) -> str:
    positional, keywords = call
    parts = [sample.name for sample in positional] + [f":{key} {sample.name}" for key, sample in keywords.items()]
    return f"({', '.join([name, *parts])})"
