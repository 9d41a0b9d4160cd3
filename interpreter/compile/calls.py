"""Compiler of calls: closures by number of arguments, tail calls, builtins, and iterations of loops.

Calls of global functions and builtins with few arguments have one closure for each number of arguments, because a list
of argument nodes would cost a loop at each call. Call chains of errors omit calls in tail position, because their
frames no longer exist when the error is raised.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile.analyze import undefined
from scenelang.interpreter.runtime.parts import (
    PartCollector,
    call_embeddings,
    copy_table,
    listed,
    parts_of,
    plain_parts,
    transformed,
)
from scenelang.interpreter.runtime.procedures import (
    TAIL,
    UNDEFINED,
    Cell,
    Closure,
    Frame,
    Node,
    bind_arguments,
    builtin_arity_error,
    call_builtin,
    items_of,
    python_error,
    type_error,
)
from scenelang.interpreter.runtime.show import array_literal, described
from scenelang.interpreter.runtime.types import Builtin, Mismatch
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.part_columns import MIN_COLUMNS
from scenelang.interpreter.values.values import (
    ANONYMOUS,
    IDENTITY,
    NIL,
    Embedding,
    Keyword,
    Matrix,
    Pair,
    Procedure,
    Table,
    Vector,
    make_list,
)

if TYPE_CHECKING:
    from scenelang.interpreter.compile.analyze import FrameLayout
    from scenelang.interpreter.compile.compile import Compiler, Context
    from scenelang.interpreter.runtime.runtime import Runtime


_NUMBERS = frozenset((int, float))
_BLOCK = 2048  # turns of a loop between two charges; one tick for each turn would cost more than a short body
_UNNAMED = ("lambda", "do")


class GlobalHead:
    """Head of a call that is a global variable without assignments."""

    __slots__ = ("cell", "name", "span")

    def __init__(self, cell: Cell, name: str, span: Span) -> None:
        self.cell = cell
        self.name = name
        self.span = span

    def __call__(self, frame: Frame) -> Any:
        return self.cell.value


def locate(error: SceneError, function: Any, span: Span) -> None:
    """Add the location of a call to an error that occurred in it.

    An error without a location gets that of the call; to others, the call is added as the next one of the call stack.
    """
    if error.span is None:
        error.span = span
    elif type(function) is Closure and function.code.name not in _UNNAMED:
        error.called(f"`{function.code.name}`", span)


def _apply(rt: Runtime, function: Any, arguments: Sequence[Any], head: Any, span: Span) -> Any:
    """Perform a call without a fast path."""
    if function is UNDEFINED:
        raise undefined(rt, head.name, head.span)
    if not isinstance(function, Procedure):
        raise rt.not_a_procedure(function, span)
    return rt.apply(function, arguments)


def call(rt: Runtime, head: Any, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call that is not in tail position.

    Parameters
    ----------
    head
        Compiled head, whose value is the function; ``GlobalHead`` for a global variable.
    arguments
        Compiled arguments.
    span
        Location of the call, for errors.
    """
    if isinstance(head, GlobalHead) and len(arguments) in _GLOBAL_CALLS:
        return _GLOBAL_CALLS[len(arguments)](rt, head, arguments, span)
    tick = rt.tick

    def node(frame: Frame) -> Any:
        function = head(frame)
        values = [argument(frame) for argument in arguments]
        try:
            if type(function) is Closure and function.arity == len(values):
                tick()
                result = function.code.body([function.env, *values])
                while result is TAIL:
                    tick()
                    result = rt.next_body(rt.next_frame)
                return result
            return _apply(rt, function, values, head, span)
        except SceneError as error:
            locate(error, function, span)
            raise

    return node


def _global_call0(rt: Runtime, head: GlobalHead, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call of a global function without arguments."""
    cell, tick = head.cell, rt.tick

    def node(frame: Frame) -> Any:
        function = cell.value
        try:
            if type(function) is Closure and function.arity == 0:
                tick()
                result = function.code.body([function.env])
                while result is TAIL:
                    tick()
                    result = rt.next_body(rt.next_frame)
                return result
            return _apply(rt, function, (), head, span)
        except SceneError as error:
            locate(error, function, span)
            raise

    return node


def _global_call1(rt: Runtime, head: GlobalHead, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call of a global function with one argument."""
    cell, tick = head.cell, rt.tick
    (a,) = arguments

    def node(frame: Frame) -> Any:
        function = cell.value
        x = a(frame)
        try:
            if type(function) is Closure and function.arity == 1:
                tick()
                result = function.code.body([function.env, x])
                while result is TAIL:
                    tick()
                    result = rt.next_body(rt.next_frame)
                return result
            return _apply(rt, function, (x,), head, span)
        except SceneError as error:
            locate(error, function, span)
            raise

    return node


def _global_call2(rt: Runtime, head: GlobalHead, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call of a global function with two arguments."""
    cell, tick = head.cell, rt.tick
    a, b = arguments

    def node(frame: Frame) -> Any:
        function = cell.value
        x = a(frame)
        y = b(frame)
        try:
            if type(function) is Closure and function.arity == 2:
                tick()
                result = function.code.body([function.env, x, y])
                while result is TAIL:
                    tick()
                    result = rt.next_body(rt.next_frame)
                return result
            return _apply(rt, function, (x, y), head, span)
        except SceneError as error:
            locate(error, function, span)
            raise

    return node


def _global_call3(rt: Runtime, head: GlobalHead, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call of a global function with three arguments."""
    cell, tick = head.cell, rt.tick
    a, b, c = arguments

    def node(frame: Frame) -> Any:
        function = cell.value
        x = a(frame)
        y = b(frame)
        z = c(frame)
        try:
            if type(function) is Closure and function.arity == 3:
                tick()
                result = function.code.body([function.env, x, y, z])
                while result is TAIL:
                    tick()
                    result = rt.next_body(rt.next_frame)
                return result
            return _apply(rt, function, (x, y, z), head, span)
        except SceneError as error:
            locate(error, function, span)
            raise

    return node


_GLOBAL_CALLS: dict[int, Callable[..., Node]] = {
    0: _global_call0,
    1: _global_call1,
    2: _global_call2,
    3: _global_call3,
}


def tail_call(rt: Runtime, head: Any, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call in tail position: the body of a closure is passed to the caller's trampoline.

    The parameters are those of ``call``.
    """
    if isinstance(head, GlobalHead) and len(arguments) in _GLOBAL_TAIL_CALLS:
        return _GLOBAL_TAIL_CALLS[len(arguments)](rt, head, arguments, span)

    def node(frame: Frame) -> Any:
        function = head(frame)
        values = [argument(frame) for argument in arguments]
        if type(function) is Closure and function.arity == len(values):
            rt.next_body = function.code.body
            rt.next_frame = [function.env, *values]
            return TAIL
        return apply_at(rt, function, values, head, span)

    return node


def apply_at(rt: Runtime, function: Any, values: Sequence[Any], head: Any, span: Span) -> Any:
    """Perform a call in tail position that has no fast path.

    Parameters
    ----------
    function, values
        Evaluated function and arguments.
    head
        Compiled head, for the name in errors.
    span
        Location of the call.
    """
    try:
        if type(function) is Closure:
            frame = bind_arguments(rt, function, values)
            rt.next_body, rt.next_frame = function.body, frame
            return TAIL
        return _apply(rt, function, values, head, span)
    except SceneError as error:
        locate(error, function, span)
        raise


def tail_apply(rt: Runtime, builtin: Builtin, arguments: Sequence[Node], span: Span) -> Node:
    """Compile ``(apply f ... xs)`` in tail position: the body of a closure is passed to the caller's trampoline."""

    def node(outer: Frame) -> Any:
        values = [argument(outer) for argument in arguments]
        rt.site = span
        try:
            if len(values) < 2 or type(values[0]) is not Closure or not (type(values[-1]) is Pair or values[-1] is NIL):
                return call_builtin(rt, builtin, values)
            frame = bind_arguments(rt, values[0], [*values[1:-1], *items_of(rt, values[-1])])
            rt.next_body, rt.next_frame = values[0].body, frame
            return TAIL
        except SceneError as error:
            locate(error, values[0] if values else None, span)
            raise

    return node


def _global_tail_call1(rt: Runtime, head: GlobalHead, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a tail call of a global function with one argument."""
    cell = head.cell
    (a,) = arguments

    def node(frame: Frame) -> Any:
        function = cell.value
        x = a(frame)
        if type(function) is Closure and function.arity == 1:
            rt.next_body = function.code.body
            rt.next_frame = [function.env, x]
            return TAIL
        return apply_at(rt, function, (x,), head, span)

    return node


def _global_tail_call2(rt: Runtime, head: GlobalHead, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a tail call of a global function with two arguments."""
    cell = head.cell
    a, b = arguments

    def node(frame: Frame) -> Any:
        function = cell.value
        x = a(frame)
        y = b(frame)
        if type(function) is Closure and function.arity == 2:
            rt.next_body = function.code.body
            rt.next_frame = [function.env, x, y]
            return TAIL
        return apply_at(rt, function, (x, y), head, span)

    return node


def _global_tail_call3(rt: Runtime, head: GlobalHead, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a tail call of a global function with three arguments."""
    cell = head.cell
    a, b, c = arguments

    def node(frame: Frame) -> Any:
        function = cell.value
        x = a(frame)
        y = b(frame)
        z = c(frame)
        if type(function) is Closure and function.arity == 3:
            rt.next_body = function.code.body
            rt.next_frame = [function.env, x, y, z]
            return TAIL
        return apply_at(rt, function, (x, y, z), head, span)

    return node


_GLOBAL_TAIL_CALLS: dict[int, Callable[..., Node]] = {
    1: _global_tail_call1,
    2: _global_tail_call2,
    3: _global_tail_call3,
}


def with_locals(body: Node, count: int) -> Node:
    """Wrap ``body`` to extend its frame by ``count`` local variables."""
    if not count:
        return body
    locals_ = (None,) * count

    def run(frame: Frame) -> Any:
        frame.extend(locals_)
        return body(frame)

    return run


def item_adder(rt: Runtime, span: Span) -> Callable[[list[Any], Any], None]:
    """Return a function that appends the items of a turn's value to the list of ``for/append``."""

    def add(out: list[Any], value: Any) -> None:
        try:
            items = items_of(rt, value)
        except SceneError as error:
            raise _located(error, span)
        rt.meter.check_size(len(out) + len(items), "a list")
        out.extend(items)

    return add


def unpacker(rt: Runtime, count: int, span: Span) -> Callable[[Any], list[Any]]:
    """Return a function that takes the value of a body of ``for/fold`` apart, one item for each accumulator."""

    def values_of(value: Any) -> list[Any]:
        values = items_of(rt, value)
        if len(values) != count:
            message = f"the body of `for/fold` must return a list of {count} values, got {len(values)}"
            raise SceneError("value", message, span=span)
        return values

    return values_of


# --- loops -----------------------------------------------------------------------------------------------------


def plain_loop(rt: Runtime, mark: Any, starts: Sequence[Node], binders: Sequence[Any], body: Node) -> Node:
    """Compile a loop whose variables are stored in the enclosing frame.

    Iterations are charged in blocks, which is cheaper than a tick for each.

    Parameters
    ----------
    mark
        Marker that the body returns to continue the loop (``next_iteration``); any other value is the result.
    starts
        Initial values of the variables.
    binders
        Functions ``bind(frame, value)`` of the variables.
    body
        Body of the loop.
    """
    spend, charge = rt.meter.spend, rt.charge
    block = range(1, _BLOCK + 1)

    def run(frame: Frame) -> Any:
        values = [start(frame) for start in starts]
        for bind, value in zip(binders, values):
            bind(frame, value)
        while True:
            for count in block:
                result = body(frame)
                if result is not mark:
                    charge(count)
                    return result
            spend(_BLOCK)

    return run


def counted_loop(
    rt: Runtime,
    mark: Any,
    starts: Sequence[Node],
    binders: Sequence[Any],
    body: Node,
    hot: int,
    generate: Callable[[], Callable[[Frame, int], Any] | None],
) -> Node:
    """Compile a loop like ``plain_loop`` that is continued by generated code after a number of turns.

    Parameters
    ----------
    mark, starts, binders, body
        As for ``plain_loop``.
    hot
        Number of turns, over all runs of the loop, after which code is generated.
    generate
        Returns the generated loop, or None if the loop cannot be generated. The loop takes the frame with the
        variables, and the number of turns that are not charged yet.
    """
    spend, charge = rt.meter.spend, rt.charge
    block = range(1, _BLOCK + 1)
    left = hot

    def cold(frame: Frame, done: int) -> Any:
        """Continue as closures, after ``done`` turns that are not charged, if no code can be generated."""
        rest = range(done + 1, _BLOCK + 1)
        while True:
            for count in rest:
                result = body(frame)
                if result is not mark:
                    charge(count)
                    return result
            spend(_BLOCK)
            rest = block

    continued: Callable[[Frame, int], Any] | None = None  # the generated loop, or `cold`

    def run(frame: Frame) -> Any:
        """Run the loop: as closures for its first turns, which may be spread over several runs."""
        nonlocal left, continued
        values = [start(frame) for start in starts]
        for bind, value in zip(binders, values):
            bind(frame, value)
        if continued is not None:
            return continued(frame, 0)
        warm = left
        for count in range(1, warm + 1):
            result = body(frame)
            if result is not mark:
                left = min(left, warm - count)  # an inner run of the same loop may have counted down further
                charge(count)
                return result
        left = 0
        if continued is None:  # unless an inner run has generated it
            continued = generate() or cold
        return continued(frame, warm)

    return run


def framed_loop(
    rt: Runtime, mark: Any, starts: Sequence[Node], binders: Sequence[Any], body: Node, layout: FrameLayout
) -> Node:
    """Compile a loop with a separate frame for each iteration, because closures capture its variables.

    Parameters
    ----------
    mark, starts, binders, body
        As for ``plain_loop``; the binders and the body take the frame of the iteration.
    layout
        Layout of that frame.
    """
    tick = rt.tick

    def run(outer: Frame) -> Any:
        values: Any = [start(outer) for start in starts]
        pad = [None] * (layout.size - 1)
        while True:
            tick()
            frame = [outer, *pad]
            for bind, value in zip(binders, values):
                bind(frame, value)
            result = body(frame)
            if result is not mark:
                return result
            values = rt.next_frame

    return run


def next_framed_iteration(rt: Runtime, mark: Any, arguments: Sequence[Node]) -> Node:
    """Continue a loop with separate frames: pass the next values to ``framed_loop`` and return the marker."""

    def node(frame: Frame) -> Any:
        rt.next_frame = [argument(frame) for argument in arguments]
        return mark

    return node


def next_counted_iteration(mark: Any, count: Node, other: Node, slots: Sequence[int], step: int) -> Node:
    """Return a node that continues a loop of two variables, the first of which counts: ``(loop (+ i step) other)``.

    Parameters
    ----------
    mark, slots
        As for ``next_iteration``, in the current frame.
    count
        The first argument, ``(+ i step)``, which is evaluated if the variable is not an Integer.
    other
        The second argument.
    step
        Number that is added to the counter.
    """
    i, j = slots

    def node(frame: Frame) -> Any:
        x = frame[i]
        x = x + step if type(x) is int else count(frame)
        frame[j] = other(frame)
        frame[i] = x
        return mark

    return node


def next_iteration(mark: Any, arguments: Sequence[Node], slots: Sequence[int], depth: int) -> Node:
    """Return a node that continues a loop: it assigns all variables simultaneously, and returns the marker.

    Parameters
    ----------
    mark
        Marker of the loop.
    arguments
        Next values of the variables.
    slots
        Slots of the variables in the loop's frame.
    depth
        Number of frames between that frame and the current one.
    """
    # Most loops have one or two variables in the current frame, which need no list of values.
    if depth == 0 and len(arguments) == 1:
        (argument,), (slot,) = arguments, slots

        def assign_one(frame: Frame) -> Any:
            frame[slot] = argument(frame)
            return mark

        return assign_one
    if depth == 0 and len(arguments) == 2:
        (first, second), (first_slot, second_slot) = arguments, slots

        def assign_two(frame: Frame) -> Any:
            value = first(frame)
            frame[second_slot] = second(frame)  # may read the first variable, which still has its old value
            frame[first_slot] = value
            return mark

        return assign_two

    def node(frame: Frame) -> Any:
        values = [argument(frame) for argument in arguments]
        for _ in range(depth):
            frame = frame[0]
        for slot, value in zip(slots, values):
            frame[slot] = value
        return mark

    return node


# --- builtins --------------------------------------------------------------------------------------------------

_ARITHMETIC = (ArithmeticError, MemoryError)


def slow_call(rt: Runtime, builtin: Builtin, span: Span) -> Callable[[list[Any]], Any]:
    """Return a function that calls ``builtin`` with evaluated arguments and sets the span of errors."""

    def run(values: list[Any]) -> Any:
        rt.site = span
        try:
            return call_builtin(rt, builtin, values)
        except SceneError as error:
            if error.span is None:
                error.span = span
            raise

    return run


def spread_call(rt: Runtime, builtin: Builtin, span: Span) -> Callable[..., Any]:
    """Return a function that calls ``builtin`` with positional arguments that need no check."""
    function = builtin.function

    def run(*values: Any) -> Any:
        try:
            return function(rt, *values)
        except (SceneError, *_ARITHMETIC) as error:
            raise _placed(builtin, error, span) from None

    return run


def called(function: Callable[..., Any], arguments: Sequence[Node]) -> Node:
    """Return a node that calls a Python function with two or three evaluated arguments."""
    if len(arguments) == 2:
        a, b = arguments
        return lambda frame: function(a(frame), b(frame))
    x, y, z = arguments
    return lambda frame: function(x(frame), y(frame), z(frame))


def builtin_call(rt: Runtime, builtin: Builtin, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call of a builtin. Types are checked inline for up to three positional arguments."""
    signature = builtin.signature
    count = len(arguments)
    keywords = bool(signature.keywords)
    if not keywords and not signature.takes(count):
        error = builtin_arity_error(builtin, count)
        return _raiser(arguments, error.name, error.message, error.hint, span)
    slow = slow_call(rt, builtin, span)
    if not signature.takes(count) or count > _MAX_DIRECT:
        return lambda frame: slow([argument(frame) for argument in arguments])
    checks = tuple(
        [
            parameter.type.checker(rt) if parameter.type.is_checked and not builtin.checks_arguments else None
            for parameter in builtin.signature.taking(count)
        ]
    )
    if keywords or count > 3 or calls_others(builtin, count):
        return _builtin_many(rt, builtin, arguments, checks, slow if keywords else None, span)
    return _FIXED[count](rt, builtin, arguments, checks, span)


def keyword_places(builtin: Builtin, arguments: Sequence[Any]) -> dict[int, str]:
    """Return where a call names its keyword arguments: the positions of keywords that the signature has.

    Empty for a call whose keywords are wrong or only known when it is evaluated, and for one that calls others.
    """
    known = {parameter.name for parameter in builtin.signature.keywords}
    places: dict[int, str] = {}
    position = 0
    while known and position < len(arguments):
        argument = arguments[position]
        value = argument.value if type(argument) is ast.Constant else None
        if type(value) is Keyword:
            if value not in known or value in places.values() or position + 1 == len(arguments):
                return {}
            places[position] = str(value)
            position += 1
        position += 1
    count = len(arguments) - 2 * len(places)
    is_direct = builtin.signature.takes(count) and len(arguments) <= _MAX_DIRECT and not calls_others(builtin, count)
    return places if is_direct else {}


def keyword_call(
    rt: Runtime, builtin: Builtin, arguments: Sequence[Node], names: Mapping[int, str], span: Span
) -> Node:
    """Compile a call of a builtin with keyword arguments, whose positions are the keys of ``names``."""
    slow = slow_call(rt, builtin, span)
    named = {position + 1: name for position, name in names.items()}
    positions = [index for index in range(len(arguments)) if index not in names and index not in named]
    keywords = {parameter.name: parameter for parameter in builtin.signature.keywords}
    is_checked = not builtin.checks_arguments
    checks = [
        (index, p.type.checker(rt))
        for index, p in zip(positions, builtin.signature.taking(len(positions)))
        if is_checked and p.type.is_checked
    ]
    checks += [(index, keywords[name].type.checker(rt)) for index, name in named.items()]
    places = [(index, name.replace("-", "_")) for index, name in named.items()]
    function = builtin.function

    def node(frame: Frame) -> Any:
        values = [argument(frame) for argument in arguments]
        converted = values[:]
        try:
            for index, check in checks:
                converted[index] = check(values[index])
        except Mismatch:
            return slow(values)  # which reports the argument
        positional = [converted[index] for index in positions]
        for value in positional:
            if type(value) is Keyword:
                return slow(values)
        rt.site = span
        try:
            return function(rt, *positional, **{name: converted[index] for index, name in places})
        except (SceneError, *_ARITHMETIC) as error:
            raise _placed(builtin, error, span) from None

    return node


def calls_others(builtin: Builtin, count: int) -> bool:
    """Return whether a builtin calls functions that it is given; the call chain of an error in them shows its call."""
    return any(parameter.type.name == "Function" for parameter in builtin.signature.taking(count))


def _raiser(arguments: Sequence[Node], name: str, message: str, hint: str | None, span: Span) -> Node:
    """Compile a call with a wrong number of arguments, which fails after it has evaluated them."""

    def node(frame: Frame) -> Any:
        for argument in arguments:
            argument(frame)
        raise SceneError(name, message, hint, span)

    return node


def _builtin0(rt: Runtime, builtin: Builtin, arguments: Sequence[Node], checks: Sequence[Any], span: Span) -> Node:
    """Compile a call of a builtin without arguments; all functions of ``_FIXED`` have these parameters."""
    function = builtin.function

    def node(frame: Frame) -> Any:
        try:
            return function(rt)
        except (SceneError, *_ARITHMETIC) as error:
            raise _placed(builtin, error, span) from None

    return node


def _builtin1(rt: Runtime, builtin: Builtin, arguments: Sequence[Node], checks: Sequence[Any], span: Span) -> Node:
    """Compile a call of a builtin with one argument."""
    function = builtin.function
    (a,), (check_a,) = arguments, checks

    def node(frame: Frame) -> Any:
        x = argument = a(frame)
        try:
            if check_a is not None:
                x = check_a(argument)
            return function(rt, x)
        except Mismatch:
            raise mismatch(builtin, checks, (argument,), span) from None
        except (SceneError, *_ARITHMETIC) as error:
            raise _placed(builtin, error, span) from None

    return node


def _builtin2(rt: Runtime, builtin: Builtin, arguments: Sequence[Node], checks: Sequence[Any], span: Span) -> Node:
    """Compile a call of a builtin with two arguments."""
    function = builtin.function
    (a, b), (check_a, check_b) = arguments, checks

    def node(frame: Frame) -> Any:
        x = first = a(frame)
        y = second = b(frame)
        try:
            if check_a is not None:
                x = check_a(first)
            if check_b is not None:
                y = check_b(second)
            return function(rt, x, y)
        except Mismatch:
            raise mismatch(builtin, checks, (first, second), span) from None
        except (SceneError, *_ARITHMETIC) as error:
            raise _placed(builtin, error, span) from None

    return node


def _builtin3(rt: Runtime, builtin: Builtin, arguments: Sequence[Node], checks: Sequence[Any], span: Span) -> Node:
    """Compile a call of a builtin with three arguments."""
    function = builtin.function
    (a, b, c), (check_a, check_b, check_c) = arguments, checks

    def node(frame: Frame) -> Any:
        x = first = a(frame)
        y = second = b(frame)
        z = third = c(frame)
        try:
            if check_a is not None:
                x = check_a(first)
            if check_b is not None:
                y = check_b(second)
            if check_c is not None:
                z = check_c(third)
            return function(rt, x, y, z)
        except Mismatch:
            raise mismatch(builtin, checks, (first, second, third), span) from None
        except (SceneError, *_ARITHMETIC) as error:
            raise _placed(builtin, error, span) from None

    return node


def _builtin_many(
    rt: Runtime, builtin: Builtin, arguments: Sequence[Node], checks: Sequence[Any], named: Any, span: Span
) -> Node:
    """Compile a call of a builtin with more arguments, one that also takes keywords, or one that calls functions.

    ``named`` is the function that calls a builtin of the latter kind where one of the arguments is a keyword.
    """
    function = builtin.function
    is_checked = any(check is not None for check in checks)

    def node(frame: Frame) -> Any:
        values = converted = [argument(frame) for argument in arguments]
        if named is not None:
            for value in values:
                if type(value) is Keyword:
                    return named(values)
        rt.site = span
        try:
            if is_checked:
                converted = [value if check is None else check(value) for check, value in zip(checks, values)]
            return function(rt, *converted)
        except Mismatch:
            raise mismatch(builtin, checks, values, span) from None
        except (SceneError, *_ARITHMETIC) as error:
            raise _placed(builtin, error, span) from None

    return node


_MAX_DIRECT = 16  # arguments of a call without an array of them; ``call_builtin`` charges for more than 32
_FIXED: dict[int, Callable[..., Node]] = {0: _builtin0, 1: _builtin1, 2: _builtin2, 3: _builtin3}


def mismatch(builtin: Builtin, checks: Sequence[Any], values: Sequence[Any], span: Span) -> SceneError:
    """Return the error for the first argument of the wrong type.

    Parameters
    ----------
    builtin
        The builtin that is called.
    checks
        Function for each argument that raises ``Mismatch`` for a wrong type; None if it accepts every value.
    values
        Arguments.
    span
        Location of the call.
    """
    error: SceneError | None = None
    for parameter, check, value in zip(builtin.signature.taking(len(values)), checks, values):
        try:
            if check is not None:
                check(value)
        except Mismatch:
            error = type_error(builtin, parameter, value)
            break
    if error is None:
        error = SceneError("type", f"argument of the wrong type for `{builtin.name}`", f"signature: {builtin.usage}")
    error.span = span
    return error


def _placed(builtin: Builtin, error: Exception, span: Span) -> SceneError:
    """Return the error of a failed builtin as a ``SceneError`` with a span."""
    if not isinstance(error, SceneError):
        error = python_error(builtin.name, error)
    return _located(error, span)


def array_node(rt: Runtime, items: Sequence[Node], span: Span) -> Node:
    """Compile an array literal ``[item ...]``; three numbers, as in a point, have a fast path."""
    if len(items) == 3:
        first, second, third = items

        def triple(frame: Frame) -> Any:
            return make(first(frame), second(frame), third(frame))

        make = vector_maker(rt, span)
        return triple
    return lambda frame: _array(rt, [item(frame) for item in items], span)


def vector_maker(rt: Runtime, span: Span) -> Callable[[Any, Any, Any], Any]:
    """Return a function that creates the array ``[x y z]``."""

    def make(x: Any, y: Any, z: Any) -> Any:
        kind_x, kind_y, kind_z = type(x), type(y), type(z)
        if kind_x is kind_y is kind_z and (kind_x is float or kind_x is int):
            return Vector((x, y, z))
        if kind_x in _NUMBERS and kind_y in _NUMBERS and kind_z in _NUMBERS:
            try:
                return Vector((float(x), float(y), float(z)))
            except OverflowError:
                pass  # an integer too large for a float: the general case reports the error
        return _array(rt, (x, y, z), span)

    return make


def _array(rt: Runtime, values: Sequence[Any], span: Span) -> Any:
    """Return the array of evaluated items; errors get the span of the literal."""
    try:
        return array_literal(values, rt)
    except SceneError as error:
        if error.span is None:
            error.span = span
        raise


# Compiled uses of ``bind``, ``call``, ``union``, ``union-loop`` and ``transform``.
#
# They are faster equivalents of the definitions in the prelude (``stdlib/prelude.scene``); tests compare the two.


def _located(error: SceneError, span: Span) -> SceneError:
    """Return an error with ``span`` as its location, unless it has one."""
    if error.span is None:
        error.span = span
    return error


def compile_bind(compiler: Compiler, node: ast.Bind, context: Context) -> Node:
    """Compile ``(bind word function)``."""
    word = compiler.compile(node.word, context.inner)
    function = compiler.compile(node.function, context.inner)
    return bind_node(compiler.rt, word, function, node.span)


def bind_node(rt: Runtime, word: Node, function: Node, span: Span) -> Node:
    """Return a node that binds a word to a function."""

    def bind(frame: Frame) -> None:
        name = word(frame)
        value = function(frame)
        try:
            rt.bind_word(name, value, span)
        except SceneError as error:
            raise _located(error, span) from None

    return bind


# --- call ------------------------------------------------------------------------------------------------------


def compile_call(compiler: Compiler, node: ast.Call, context: Context) -> Node:
    """Compile ``(call word argument ...)``."""
    word, *nodes = compiler.compile_all((node.word, *call_operands(node)), context.inner)
    return call_node(compiler.rt, word, nodes, node)


def call_operands(node: ast.Call) -> Sequence[ast.Expr]:
    """Return the operands of a ``call`` that are evaluated after its word."""
    plan = _attributes_only(node.arguments)
    return node.arguments if plan is None else plan[1]


def call_node(rt: Runtime, word: Node, nodes: Sequence[Node], node: ast.Call) -> Node:
    """Compile ``(call word ...)``; ``nodes`` are its compiled operands."""
    plan = _attributes_only(node.arguments)
    if plan is None:
        return _general_call(rt, word, nodes, node.span)
    names, values = plan
    if all(_is_constant(value) for value in values):
        try:
            constants = [literal(value) for value in values]
        except SceneError:
            pass  # report the error at run time, where a `guard` can catch it
        else:
            made = Embedding(None, None, dict(zip(names, constants))) if names else ANONYMOUS
            _, z = rt.literal_embeddings.setdefault(id(node), (node, made))
            return _constant_call(rt, word, z, frozenset(names), node)
    return _attribute_call(rt, word, tuple(zip(names, nodes)), node.span)


def literal(node: Any) -> Any:
    """Return the value of a literal (see ``_is_constant``)."""
    return node.value if type(node) is ast.Constant else array_literal([item.value for item in node.items])


def _is_constant(node: ast.Expr) -> bool:
    """Return whether a node is a literal: a number, a string or an array of numbers."""
    if type(node) is ast.ArrayLiteral:
        return bool(node.items) and all(type(i) is ast.Constant and type(i.value) in (int, float) for i in node.items)
    return type(node) is ast.Constant


def _attributes_only(arguments: tuple[ast.Expr, ...]) -> tuple[list[str], list[ast.Expr]] | None:
    """Return names and values if all arguments are literal ``:name value`` pairs with distinct names, else None."""
    names: list[str] = []
    values: list[ast.Expr] = []
    if len(arguments) % 2:
        return None
    for index in range(0, len(arguments), 2):
        name = arguments[index]
        if type(name) is not ast.Constant or type(name.value) is not Keyword or str(name.value) in names:
            return None
        names.append(str(name.value))
        values.append(arguments[index + 1])
    return names, values


def _constant_call(rt: Runtime, word: Node, z: Embedding, written: frozenset[str], node: ast.Call) -> Node:
    """Compile a call whose attributes are literals, with one embedding for all its evaluations."""
    name = node.word.value if type(node.word) is ast.Constant else None
    if type(name) is str:
        evaluate = rt.literal_call(name, z, written, node.span)

        def call_literal(frame: Frame) -> Any:
            try:
                return evaluate()
            except SceneError as error:
                raise _located(error, node.span)

        return call_literal

    def call(frame: Frame) -> Any:
        name = word(frame)
        try:
            if type(name) is not str:
                call_embeddings(rt, name, [])
            return rt.call_word(name, z, NIL, written, node.span)
        except SceneError as error:
            raise _located(error, node.span)

    return call


def _attribute_call(rt: Runtime, word: Node, attributes: tuple[tuple[str, Node], ...], span: Span) -> Node:
    """Compile a call with attributes ``:name value`` only.

    Tables are copied and frozen, so that the call can be shared; mutable lists and arrays are not, so it cannot.
    """
    written = frozenset(name for name, _ in attributes)

    def call(frame: Frame) -> Any:
        name = word(frame)
        values = {}
        for key, node in attributes:
            value = node(frame)
            values[key] = copy_table(rt, value) if type(value) is Table else value
        try:
            if type(name) is not str:
                call_embeddings(rt, name, [])
            return rt.call_word(name, Embedding(None, None, values), NIL, written, span)
        except SceneError as error:
            raise _located(error, span)

    return call


def _general_call(rt: Runtime, word: Node, arguments: Sequence[Node], span: Span) -> Node:
    """Compile a call with embeddings, positional arguments or repeated names."""

    def call(frame: Frame) -> Any:
        name = word(frame)
        values = [argument(frame) for argument in arguments]
        try:
            z, rest, written = call_embeddings(rt, name, values)
            return rt.call_word(name, z, make_list(rest), written, span)
        except SceneError as error:
            raise _located(error, span)

    return call


# --- union -----------------------------------------------------------------------------------------------------


def add_parts(rt: Runtime, out: PartCollector, value: Any, span: Span) -> None:
    """Convert ``value`` to parts and append them to ``out``; entities and posed entities have a fast path.

    Raises SceneError at ``span`` if the value is not parts.
    """
    if type(value) is Entity:
        out.append(Pair(value, IDENTITY))
    elif type(value) is Pair and type(value.cdr) is Matrix and type(value.car) is Entity:
        out.append(value)
        if len(out) >= MIN_COLUMNS:
            out.settle()
    else:
        try:
            out.join(parts_of(rt, value))
        except SceneError as error:
            raise _located(error, span) from None


def part_result(compiler: Compiler, node: Any) -> Callable[[Any], Any]:
    """Return a function of a form's parts, which keeps columns where they only become parts (``Analysis.parts``)."""
    if id(node) not in compiler.analysis.parts:
        return listed
    owner = compiler.analysis.parts[id(node)]
    if owner is None:
        return lambda value: value
    exposure = compiler.exposure_of(owner)
    return lambda value: listed(value) if exposure.is_exposed else value


def compile_union(compiler: Compiler, node: ast.Union, context: Context) -> Node:
    """Compile ``(union member ...)``."""
    nodes = compiler.compile_all(node.members, context.inner)
    return union_node(compiler.rt, nodes, node, part_result(compiler, node))


def union_node(rt: Runtime, nodes: Sequence[Node], node: ast.Union, result: Callable[[Any], Any]) -> Node:
    """Return a node that joins the parts of its members; all are evaluated before the first is checked."""
    spans = [member.span for member in node.members]

    def union(frame: Frame) -> Any:
        values = [member(frame) for member in nodes]
        pairs = plain_parts(values)
        if pairs is not None and len(pairs) < MIN_COLUMNS:
            return make_list(pairs)
        collector = PartCollector()
        for value, span in zip(values, spans):
            add_parts(rt, collector, value, span)
        return result(collector.value())

    return union


def compile_union_loop(compiler: Compiler, node: ast.UnionLoop, context: Context) -> Node:
    """Compile ``(union-loop count function)``."""
    count = compiler.compile(node.count, context.inner)
    function = compiler.compile(node.function, context.inner)
    return union_loop_node(compiler.rt, count, function, node.span, part_result(compiler, node))


def union_loop_node(rt: Runtime, count: Node, function: Node, span: Span, result: Callable[[Any], Any]) -> Node:
    """Return a node that joins the parts that a function returns for 0 to count - 1.

    A closure with one plain parameter is called directly, without ``rt.apply``.
    """
    tick = rt.tick

    def loop(frame: Frame) -> Any:
        times = count(frame)
        body = function(frame)
        out = PartCollector()
        values: list[Any] = []  # from the first one on that must be converted
        add = values.append
        try:
            times = _loop_count(times)
            if not isinstance(body, Procedure):
                raise rt.not_a_procedure(body)
            if type(body) is Closure and body.arity == 1:
                # the trampoline of `rt.call1`, written out because this loop is hot
                code, env = body.code, body.env
                is_plain = True
                for low in range(0, times, MIN_COLUMNS):
                    for i in range(low, min(low + MIN_COLUMNS, times)):
                        tick()
                        value = code.entry(env, i)
                        while value is TAIL:
                            tick()
                            value = rt.next_body(rt.next_frame)
                        add(value)
                    is_plain = is_plain and out.take_plain(values)
                    if is_plain:
                        values.clear()
            else:
                for i in range(times):
                    add(rt.apply(body, (i,)))
        except SceneError as error:
            if type(body) is Closure and error.span is not None and body.code.name != "lambda":
                error.called(f"`{body.code.name}`", span)
            raise _located(error, span)
        # all calls precede the first check, as in `union_node`
        for value in values:
            add_parts(rt, out, value, span)
        return result(out.value())

    return loop


def _loop_count(count: Any) -> int:
    """Return the count of a ``union-loop``; a Float without a fraction is one too."""
    if type(count) is int:
        return count
    if type(count) is float and count.is_integer():
        return int(count)
    message = f"`union-loop` expects an Integer count, got {described(count, 60)}"
    raise SceneError("type", message, hint="round it: `(round n)`, `(floor n)`")


# --- transform -------------------------------------------------------------------------------------------------


def compile_transform(compiler: Compiler, node: ast.Transform, context: Context) -> Node:
    """Compile ``(transform part matrix)``."""
    part = compiler.compile(node.part, context.inner)
    matrix = compiler.compile(node.matrix, context.inner)
    return transform_node(compiler.rt, part, matrix, node.span, part_result(compiler, node))


def transform_node(rt: Runtime, part: Node, matrix: Node, span: Span, result: Callable[[Any], Any]) -> Node:
    """Return a node that poses a part; a finite matrix (its sum is finite) and an entity need no conversion."""

    def transform(frame: Frame) -> Any:
        p = part(frame)
        m = matrix(frame)
        if type(p) is Entity and type(m) is Matrix and isfinite(sum(m)):
            return Pair(p, m)
        try:
            return result(transformed(rt, p, m))
        except SceneError as error:
            raise _located(error, span) from None

    return transform
