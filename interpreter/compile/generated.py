"""What generated functions need at run time: places of errors, arithmetic outside its fast paths, general calls.

A generated function has no ``try`` around its calls. One handler around its body asks ``placed`` to find, by the line
number in the traceback, the *site* that failed, and to do what the closure of that call would have done.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from types import TracebackType
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile import calls
from scenelang.interpreter.compile.analyse import undefined
from scenelang.interpreter.runtime.procedures import (
    TAIL,
    UNDEFINED,
    Cell,
    Closure,
    bind_arguments,
    python_error,
)
from scenelang.interpreter.runtime.types import Builtin, Mismatch
from scenelang.interpreter.runtime.values import Procedure, Vector

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

SITES = "SITES"  # name of the table of sites among the constants of a generated function
CAUGHT = (SceneError, Mismatch, ArithmeticError, MemoryError)
_LIMIT = 1 << 4000  # larger results are checked by the builtin (see ``intrinsics``)


@dataclass(frozen=True, slots=True)
class Local:
    """Operand of a site that is a local variable of the generated function."""

    name: str


@dataclass(frozen=True, slots=True)
class CallSite:
    """Call of a procedure; ``function`` is the local or global variable that holds it."""

    function: Local | Cell
    span: Span


@dataclass(frozen=True, slots=True)
class BuiltinSite:
    """Call of a builtin with ``arguments``, local variables or constants, and the checks of their types."""

    builtin: Builtin
    checks: tuple[Any, ...]
    arguments: tuple[Any, ...]
    span: Span


def placed(error: BaseException, sites: Mapping[int, Any]) -> BaseException:
    """Return the error to raise for ``error``, with the span or the call of the site that failed."""
    traceback = error.__traceback__
    assert traceback is not None
    site = sites.get(traceback.tb_lineno)
    if type(site) is CallSite and isinstance(error, SceneError):
        calls.locate(error, None if error.span is None else _called(site, traceback), site.span)
    elif type(site) is BuiltinSite:
        return _placed_builtin(error, site, traceback)
    return error


def _placed_builtin(error: BaseException, site: BuiltinSite, traceback: TracebackType) -> BaseException:
    if isinstance(error, SceneError):
        if error.span is None:
            error.span = site.span
        return error
    if isinstance(error, Mismatch):
        names = traceback.tb_frame.f_locals
        values = [names[a.name] if type(a) is Local else a for a in site.arguments]
        return calls.mismatch(site.builtin, site.checks, values, site.span)
    assert isinstance(error, Exception)
    found = python_error(site.builtin.name, error)
    found.span = site.span
    return found


def site_of(traceback: TracebackType) -> tuple[Any, Span] | None:
    """Return the function and the span of the call at which an entry of a traceback is, if its function is generated."""
    frame = traceback.tb_frame
    sites = frame.f_globals.get(SITES)
    site = sites.get(traceback.tb_lineno) if type(sites) is dict else None
    if type(site) is not CallSite:
        return None
    return _called(site, traceback), site.span


def _called(site: CallSite, traceback: TracebackType) -> Any:
    function = site.function
    return traceback.tb_frame.f_locals.get(function.name) if type(function) is Local else function.value


def forget(rt: Runtime, function: Closure) -> None:
    """Make the generated functions call ``function`` like an unknown one, as it is traced."""
    for constants in rt.units:
        for name, value in constants.items():
            if value is function:
                constants[name] = None


def bouncer(rt: Runtime) -> Callable[[], Any]:
    """Return the trampoline: a function that performs the pending tail calls."""
    tick = rt.tick

    def bounce() -> Any:
        result: Any = TAIL
        while result is TAIL:
            tick()
            result = rt.next_body(rt.next_frame)
        return result

    return bounce


def caller(rt: Runtime, head: Any, span: Span) -> Callable[[Any, Sequence[Any]], Any]:
    """Return a function that performs a call that is not direct; the caller's site places its errors."""
    tick = rt.tick

    def call(function: Any, values: Sequence[Any]) -> Any:
        if type(function) is Closure and function.arity == len(values):
            tick()
            result = function.code.body([function.env, *values])
            while result is TAIL:
                tick()
                result = rt.next_body(rt.next_frame)
            return result
        if function is UNDEFINED:
            raise undefined(rt, head.name, head.span)
        if not isinstance(function, Procedure):
            raise rt.not_a_procedure(function, span)
        return rt.apply(function, values)

    return call


def global_caller(rt: Runtime, cell: Cell, head: Any, span: Span) -> Callable[..., Any]:
    """Return a function that calls the value of a global variable, which was another one when code was generated."""
    call = caller(rt, head, span)
    return lambda *values: call(cell.value, values)


def tail_caller(rt: Runtime, head: Any, span: Span) -> Callable[[Any, Sequence[Any]], Any]:
    """Return a function that performs a tail call that is not direct."""

    def call(function: Any, values: Sequence[Any]) -> Any:
        return calls.apply_at(rt, function, values, head, span)

    return call


def direct_frame(rt: Runtime, function: Closure, values: Sequence[Any]) -> list[Any]:
    return bind_arguments(rt, function, values)


def undefined_raiser(rt: Runtime, name: str, span: Span) -> Callable[[], Any]:
    def fail() -> Any:
        raise undefined(rt, name, span)

    return fail


def cell_binder(rt: Runtime) -> Callable[[list[Any], int, Any], None]:
    """Return a function that gives a variable in a cell its value; an undefined cell may be captured already."""

    def bind(frame: list[Any], slot: int, value: Any) -> None:
        cell = frame[slot]
        if type(cell) is Cell and cell.value is UNDEFINED:
            cell.value = value
        else:
            frame[slot] = Cell(value, rt.clock)

    return bind


def cell_storer(rt: Runtime, name: str, span: Span) -> Callable[[Any, Any], None]:
    """Return a function that assigns a variable in a cell."""

    def store(cell: Any, value: Any) -> None:
        if cell is None or cell.value is UNDEFINED:
            raise undefined(rt, name, span)
        rt.write(cell)
        cell.value = value

    return store


def vector_maker(rt: Runtime, span: Span) -> Callable[[Any, Any, Any], Any]:
    """Return a function that creates the array ``[x y z]``."""
    general = calls.array_node(rt, [itemgetter(0), itemgetter(1), itemgetter(2)], span)

    def make(x: Any, y: Any, z: Any) -> Any:
        s = type(x)
        if s is type(y) is type(z) and (s is float or s is int):
            return Vector((x, y, z))
        return general((x, y, z))  # type: ignore[arg-type]

    return make


Slow = Callable[[Any, Any], Any]
_NUMBERS = frozenset((int, float))


def adder(slow: Slow) -> Slow:
    def add(x: Any, y: Any) -> Any:
        s, t = type(x), type(y)
        if s is Vector and t is Vector and len(x) == 3 and len(y) == 3:
            a, b, c = x
            d, e, f = y
            if type(a) is float and type(d) is float:
                return Vector((a + d, b + e, c + f))
        elif s in _NUMBERS and t in _NUMBERS:
            try:
                r = x + y
            except OverflowError:
                return slow(x, y)
            if type(r) is float or -_LIMIT < r < _LIMIT:
                return r
        return slow(x, y)

    return add


def subtracter(slow: Slow) -> Slow:
    def subtract(x: Any, y: Any) -> Any:
        s, t = type(x), type(y)
        if s is Vector and t is Vector and len(x) == 3 and len(y) == 3:
            a, b, c = x
            d, e, f = y
            if type(a) is float and type(d) is float:
                return Vector((a - d, b - e, c - f))
        elif s in _NUMBERS and t in _NUMBERS:
            try:
                r = x - y
            except OverflowError:
                return slow(x, y)
            if type(r) is float or -_LIMIT < r < _LIMIT:
                return r
        return slow(x, y)

    return subtract


def multiplier(slow: Slow) -> Slow:
    def multiply(x: Any, y: Any) -> Any:
        s, t = type(x), type(y)
        if s is Vector and t is float and len(x) == 3:
            a, b, c = x
            if type(a) is float:
                return Vector((a * y, b * y, c * y))
        elif t is Vector and s is float and len(y) == 3:
            a, b, c = y
            if type(a) is float:
                return Vector((x * a, x * b, x * c))
        elif s is Vector and t is Vector and len(x) == 3 and len(y) == 3:
            a, b, c = x
            d, e, f = y
            if type(a) is float and type(d) is float:
                return Vector((a * d, b * e, c * f))
        elif s in _NUMBERS and t in _NUMBERS:
            if s is int and t is int and not (-_LIMIT < x < _LIMIT and -_LIMIT < y < _LIMIT):
                return slow(x, y)
            try:
                r = x * y
            except OverflowError:
                return slow(x, y)
            if type(r) is float or -_LIMIT < r < _LIMIT:
                return r
        return slow(x, y)

    return multiply


def divider(slow: Slow) -> Slow:
    def divide(x: Any, y: Any) -> Any:
        if type(x) in _NUMBERS and type(y) in _NUMBERS and y:
            try:
                return x / y
            except OverflowError:
                return slow(x, y)
        if type(x) is Vector and type(y) is float and y and len(x) == 3 and type(x[0]) is float:
            a, b, c = x
            return Vector((a / y, b / y, c / y))
        return slow(x, y)

    return divide


ARITHMETIC: Mapping[str, Callable[[Slow], Slow]] = {
    "add": adder,
    "sub": subtracter,
    "mul": multiplier,
    "div": divider,
}
