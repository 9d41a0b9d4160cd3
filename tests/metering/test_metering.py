"""Every function of the library is charged for its work: what is done between two checks of the meter stays bounded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from random import Random

import pytest
from metering.measure import Measured, Seconds, WatchedRuntime, Work, measure
from metering.samples import Call, Sample, arguments, calls, described, samples
from support import session

from scenelang.interpreter.evaluation.evaluate import ProgramRun
from scenelang.interpreter.runtime.procedures import Closure
from scenelang.interpreter.runtime.types import BASE_TYPES, BuiltinParameter, Signature
from scenelang.interpreter.values.limits import Limits
from scenelang.interpreter.values.values import Procedure
from scenelang.stdlib.library import IMPORTED, TOPICS, build_library, registry_of
from scenelang.stdlib.reference import records

BUILTINS = {
    name: entry for topic in (*TOPICS, *IMPORTED.values()) for name, entry in registry_of(topic).entries.items()
}
COMBINATORS = sorted(record.name for record in records() if record.topic == "combinators")
FEW, MANY = 2, 12  # calls per number of arguments
SMALL, LARGE = 200, 50_000  # n; the arguments have n, 2n and 4n items
GROWTH = 2.5  # of what is done per step, from n to 4n


@dataclass(frozen=True, slots=True)
class Bounds:
    """``most``: between two checks; ``noticed``: the same, from which on growth counts; ``tries``: what is measured too
    high is measured again, since the first call may load modules, and since the machine has other work."""

    most: float
    noticed: float
    tries: int


WORK = Bounds(1_000_000, 600_000, 2)
SECONDS = Bounds(0.25, 0.1, 5)

Samples = Mapping[str, list[Sample]]


@cache
def sized(n: int) -> Samples:
    return samples(n)


def combinators(rt: WatchedRuntime) -> dict[str, Procedure]:
    """The library's functions that are written in the language."""
    from scenelang.grammar.datum import Source

    program = session().check(Source("<test>", f"(list {' '.join(COMBINATORS)})")).program
    assert program is not None
    values = ProgramRun(build_library(), rt).run_form(program.forms[0])
    found = {}
    for name in COMBINATORS:
        found[name], values = values.car, values.cdr
    return found


def signature_of(function: Procedure) -> Signature:
    """The parameters of a closure as a builtin has them."""
    assert isinstance(function, Closure)
    made = [
        BuiltinParameter(
            p.name, p.type or BASE_TYPES["Any"], p.kind != "required", p.kind == "keyword", p.kind == "rest"
        )
        for p in function.code.parameters
    ]
    return Signature(
        "",
        tuple(p for p in made if not p.optional),
        tuple(p for p in made if p.optional and not p.keyword and not p.rest),
        next((p for p in made if p.rest), None),
        tuple(p for p in made if p.keyword),
    )


def at_best(rt: WatchedRuntime, function: Procedure, call: Call, bound: float, tries: int) -> Measured:
    found = measure(rt, function, *arguments(call))
    for _ in range(1, tries):
        if found.worst <= bound:
            break
        again = measure(rt, function, *arguments(call))
        found = min(found, again, key=lambda measured: measured.worst)
    return found


def check(
    rt: WatchedRuntime, name: str, function: Procedure, signature: Signature, n: int, few: int, bounds: Bounds
) -> None:
    rows = [calls(signature, sized(size), few, Random(name)) for size in (n, 2 * n, 4 * n)]
    assert rows[0], f"no call of {name} is tried"
    for small, middle, large in zip(*rows):
        last = at_best(rt, function, large, bounds.noticed, bounds.tries)
        assert last.worst <= bounds.most, (described(name, large), last)
        if last.looped > bounds.noticed:
            first = at_best(rt, function, small, 0.0, bounds.tries)
            assert last.looped < GROWTH * first.looped, (described(name, large), first, last)
            second = at_best(rt, function, middle, bounds.most, bounds.tries)
            assert second.worst <= bounds.most, (described(name, middle), second)


def check_work(name: str, function: Procedure, signature: Signature, few: int = FEW) -> None:
    check(worker(), name, function, signature, SMALL, few, WORK)


def worker() -> WatchedRuntime:
    return WatchedRuntime(Limits(steps=40_000, seconds=1e6), Work())


def clocked() -> WatchedRuntime:
    return WatchedRuntime(Limits(steps=2_000_000, seconds=5.0), Seconds())


@pytest.mark.parametrize("name", sorted(BUILTINS))
@pytest.mark.sampled(3)
def test_builtins_are_charged(name: str) -> None:
    check_work(name, BUILTINS[name], BUILTINS[name].signature)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(BUILTINS))
def test_builtins_are_charged_for_large_arguments(name: str) -> None:
    check(clocked(), name, BUILTINS[name], BUILTINS[name].signature, LARGE, MANY, SECONDS)


def test_combinators_are_charged() -> None:
    rt = worker()
    for name, function in combinators(rt).items():
        check(rt, name, function, signature_of(function), SMALL, 1, WORK)


@pytest.mark.slow
def test_combinators_are_charged_for_large_arguments() -> None:
    rt = clocked()
    for name, function in combinators(rt).items():
        check(rt, name, function, signature_of(function), LARGE, MANY, SECONDS)


def test_a_builtin_that_does_not_charge_is_found() -> None:
    @cache
    def quadratic() -> Procedure:
        from scenelang.interpreter.runtime.types import Builtin
        from scenelang.interpreter.values.values import list_items

        def body(rt: object, xs: object) -> int:
            members = list_items(xs)
            return sum(1 for one in members for other in members[:200] if one is other)

        return Builtin("pairs", "xs::List", "Integer", body, "", None, "test")

    function = quadratic()
    with pytest.raises(AssertionError):
        check_work("pairs", function, function.signature, 16)  # type: ignore[attr-defined]
