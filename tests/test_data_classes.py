"""Data classes are made as those of the standard library, but later."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import subprocess
import sys
from collections.abc import Callable
from typing import Any, ClassVar

import pytest

from scenelang.grammar import datum
from scenelang.grammar.datum import Atom, Source, Span

MAKERS = [(dataclasses.dataclass, dataclasses.field), (datum.dataclass, datum.field)]
OPTIONS = [
    {"frozen": frozen, "slots": slots, "eq": eq} for frozen in (True, False) for slots in (True, False) for eq in (True, False)
]  # fmt: skip


def pair(make: Callable[[Any, Any], type]) -> tuple[type, type]:
    """A class as the standard library makes it, and as ours does."""
    return make(*MAKERS[0]), make(*MAKERS[1])


def outcome(action: Callable[[], Any]) -> Any:
    try:
        return action()
    except Exception as error:
        return type(error)


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_they_do_what_those_of_the_standard_library_do(options: dict[str, bool]) -> None:
    def make(dataclass: Any, field: Any) -> type:
        @dataclass(**options)
        class Record:
            """A record."""

            shared: ClassVar[int] = 7
            a: int
            b: str = "b"
            c: list[int] = field(default_factory=list)
            d: int = field(default=4, repr=False, compare=False)
            e: list[int] = field(init=False, default_factory=list)

            def total(self) -> int:
                return self.a + len(self.c)

        return Record

    for actions in zip(*(list(behaviour(kind)) for kind in pair(make))):
        theirs, ours = map(outcome, actions)
        assert theirs == ours


def behaviour(kind: Any) -> list[Callable[[], Any]]:
    one = kind(1, c=[2])
    return [
        lambda: repr(one), lambda: one.total(), lambda: kind(1, c=[2]) == one, lambda: kind(2) == one, lambda: one == 1,
        lambda: kind(1) != kind(1, d=5), lambda: hash(kind(1, c=())) == hash(kind(1, c=(), d=5)), lambda: kind(), lambda: kind(1, f=2),
        lambda: setattr(one, "a", 1), lambda: delattr(one, "b"), lambda: kind(1).c is kind(1).c, lambda: kind(1).e,
        lambda: str(inspect.signature(kind)).replace("<factory>", "").partition("c:")[0], lambda: kind.__match_args__,
        lambda: [f.name for f in dataclasses.fields(kind)], lambda: dataclasses.replace(one, a=5).a, lambda: dataclasses.asdict(kind(3)),
        lambda: dataclasses.is_dataclass(kind), lambda: copy.copy(one).a, lambda: copy.deepcopy(one).c, lambda: kind.shared,
        lambda: hasattr(one, "__dict__"), lambda: one.__doc__, lambda: kind.__qualname__.rpartition(".")[2], lambda: kind.__hash__ is None,
    ]  # fmt: skip


def test_keywords_inheritance_and_post_init() -> None:
    def make(dataclass: Any, field: Any) -> type:
        @dataclass(eq=False)
        class Base(Exception):
            a: int
            b: int = 2

            def __post_init__(self) -> None:
                self.args = (self.a,)

        @dataclass(eq=False)
        class Derived(Base):
            c: int = 3

        @dataclass(frozen=True, kw_only=True)
        class Named:
            x: int
            y: int = 2

        class Holder:
            base, derived, named = Base, Derived, Named

        return Holder

    def told(kind: Any) -> list[Any]:
        one = kind.derived(1, c=5)
        return [
            one.args, one.b, one.c, repr(one).rpartition(".")[2], str(kind.base(4)), kind.named(y=1, x=3).x, kind.named.__match_args__,
            outcome(lambda: kind.named(1)), [f.name for f in dataclasses.fields(kind.derived)],
        ]  # fmt: skip

    theirs, ours = pair(make)
    assert told(theirs) == told(ours)


def test_instances_from_other_processes_are_complete() -> None:
    """The first instance of a class may come from a pickle."""
    span = Span(Source("a", "text"), 0, 1)
    code = (
        "import pickle, sys; found = pickle.loads(sys.stdin.buffer.read())\n"
        "print(found, found.value == 3, type(found)(1, None).value); found.value = 4"
    )
    done = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(Atom(3, span)), capture_output=True)
    assert done.stdout.decode().strip().endswith("True 1")
    assert b"FrozenInstanceError" in done.stderr


def test_signatures_are_those_of_the_constructor_before_there_is_an_instance() -> None:
    @datum.dataclass(frozen=True, slots=True)
    class Fresh:
        a: int
        b: int = 2

    assert str(inspect.signature(Fresh)) == "(a: 'int', b: 'int' = 2) -> None"
    assert datum.replace(Fresh(1), b=3) == Fresh(1, 3)
    assert [each.name for each in datum.fields(Fresh)] == ["a", "b"]


def test_those_of_the_standard_library_extend_ours() -> None:
    @datum.dataclass(eq=False)
    class Ours(Exception):
        a: int
        b: list[int] = datum.field(default_factory=list)

        def __post_init__(self) -> None:
            self.args = (self.a,)

    @dataclasses.dataclass(eq=False)
    class Theirs(Ours):
        c: int = 3

    one = Theirs(1, [2], 5)
    assert (one.a, one.b, one.c, one.args) == (1, [2], 5, (1,))
    assert Theirs(1, c=4).b == []
