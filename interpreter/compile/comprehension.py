"""Compiler of ``for`` forms: clauses become nested Python loops around a step that updates an accumulator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile.analyze import FrameLayout
from scenelang.interpreter.compile.calls import add_parts, item_adder, part_result, unpacker
from scenelang.interpreter.runtime.parts import PartCollector
from scenelang.interpreter.runtime.procedures import Frame, Node, items_of, iterate
from scenelang.interpreter.runtime.types import type_name
from scenelang.interpreter.values.values import Pair, make_list, table_key

if TYPE_CHECKING:
    from scenelang.interpreter.compile.compile import Compiler, Context
    from scenelang.interpreter.runtime.runtime import Runtime


Step = Callable[[Frame, Any], Any]  # takes the frame and the accumulator; returns True to end all loops
_MAX_SUM_BITS = 4_000  # of a sum on the fast path, as in ``intrinsics``


def compile_for(compiler: Compiler, node: ast.For, context: Context) -> Node:
    """Compile a ``for`` form of any kind to a closure; ``context`` has the layout of the frame around it."""
    from scenelang.interpreter.compile.compile import Context as MakeContext

    rt = compiler.rt
    has_frame = compiler.region(node).has_frame
    layout = FrameLayout(context.layout) if has_frame else context.layout
    inner = MakeContext(layout)
    starts = [compiler.compile(accumulator.value, context.inner) for accumulator in node.accumulators]
    accumulators = [compiler.binder(a.target, layout, node.span) for a in node.accumulators]
    levels = []
    for index, clause in enumerate(node.clauses):
        outer = context.inner if index == 0 and not node.accumulators else inner
        levels.append(_level(compiler, clause, outer, inner, node.span))
    body = compiler.repeated(node.body, inner)
    kind = _KINDS[node.kind]
    result = part_result(compiler, node)  # which changes nothing but parts
    step = kind.step(rt, body, node.span)
    if accumulators:
        step = _fold_step(rt, body, accumulators, node.span)
    # The first sequence is evaluated in the frame around the loop, so its turns create the loop's frames.
    creates_frames = bool(node.clauses) and not node.accumulators and has_frame
    for number, level in reversed(list(enumerate(levels))):
        step = level(rt, step, layout if has_frame else None, is_new=creates_frames and number == 0)

    def run(outer: Frame) -> Any:
        out = kind.start(rt) if not starts else [start(outer) for start in starts]
        frame = outer
        if has_frame and not creates_frames:
            frame = [outer, *([None] * (layout.size - 1))]
        for bind, value in zip(accumulators, out if starts else ()):
            bind(frame, value)
        step(frame, out)
        try:
            return result(kind.finish(rt, out))
        except SceneError as error:
            if error.span is None:
                error.span = node.span
            raise

    return run


def _level(compiler: Compiler, clause: ast.Clause, outer: Any, inner: Any, span: Span) -> Any:
    """Return a function that wraps a step in the loop or test of a clause.

    It takes the runtime, the step, the layout of the loop's frames (None if it has none), and ``is_new``: whether the
    clause creates these frames.
    """
    if clause.kind != "each":
        test = compiler.compile(clause.values[0], outer)
        return lambda rt, step, layout, is_new: _TESTS[clause.kind](test, step, layout, is_new=is_new)
    values = compiler.compile_all(clause.values, outer)
    spans = [value.span for value in clause.values]
    binders = [compiler.binder(target, inner.layout, span) for target in clause.targets]
    slot = compiler.plain_slot(clause.targets[0], inner.layout) if len(binders) == 1 else None

    def wrap(rt: Runtime, step: Step, layout: Any, is_new: bool) -> Step:
        if slot is not None and layout is None:
            return _each_slot(rt, values[0], slot, step, spans[0])
        return _each(rt, tuple(zip(values, spans)), binders, step, layout, is_new=is_new)

    return wrap


def _each_slot(rt: Runtime, value: Node, slot: int, step: Step, place: Span) -> Step:
    """Loop over one sequence with a single variable in an existing frame, the most common case."""
    tick = rt.tick

    def run(frame: Frame, out: Any) -> Any:
        sequence = value(frame)
        try:
            items = iterate(rt, sequence)
        except SceneError as error:
            if error.span is None:
                error.span = place
            raise
        for item in items:
            tick()
            frame[slot] = item
            if step(frame, out):
                return True
        return False

    return run


def _each(
    rt: Runtime, values: Sequence[tuple[Node, Span]], binders: Sequence[Any], step: Step, layout: Any, *, is_new: bool
) -> Step:
    """Loop over one sequence, or several in step.

    Parameters
    ----------
    values
        The compiled sequences with their spans.
    layout
        Layout of the frame of each turn; None if the turns share the frame around the loop.
    is_new
        Whether a turn creates its frame, rather than a copy of that of an outer clause.
    """
    tick = rt.tick

    def iteration_frame(frame: Frame) -> Frame:
        """Return the frame of an iteration: ``f`` itself, or a new one if closures capture variables."""
        if layout is None:
            return frame
        return [frame, *([None] * (layout.size - 1))] if is_new else frame[:]

    def sequences(frame: Frame) -> list[Any]:
        """Evaluate the sequences in order."""
        iterators = []
        for value, span in values:
            sequence = value(frame)
            try:
                iterators.append(iterate(rt, sequence))
            except SceneError as error:
                if error.span is None:
                    error.span = span
                raise
        return iterators

    if len(values) == 1:
        (bind,) = binders

        def run_one(outer: Frame, out: Any) -> Any:
            (sequence,) = sequences(outer)
            for item in sequence:
                tick()
                frame = iteration_frame(outer)
                bind(frame, item)
                if step(frame, out):
                    return True
            return False

        return run_one

    def run(outer: Frame, out: Any) -> Any:
        for items in zip(*sequences(outer)):
            tick()
            frame = iteration_frame(outer)
            for bind, item in zip(binders, items):
                bind(frame, item)
            if step(frame, out):
                return True
        return False

    return run


def _entered(layout: Any, frame: Frame, *, is_new: bool) -> Frame:
    """Return the frame of the step after a test."""
    return [frame, *([None] * (layout.size - 1))] if is_new and layout is not None else frame


def _when(test: Node, step: Step, layout: Any, *, is_new: bool) -> Step:
    """Return the step of a clause ``:when``: ``step`` where the test is true, else nothing; the loop goes on."""

    def run(frame: Frame, out: Any) -> Any:
        value = test(frame)
        return False if value is False or value is None else step(_entered(layout, frame, is_new=is_new), out)

    return run


def _unless(test: Node, step: Step, layout: Any, *, is_new: bool) -> Step:
    """Return the step of a clause ``:unless``: ``step`` where the test is false, else nothing; the loop goes on."""

    def run(frame: Frame, out: Any) -> Any:
        value = test(frame)
        return step(_entered(layout, frame, is_new=is_new), out) if value is False or value is None else False

    return run


def _break(test: Node, step: Step, layout: Any, *, is_new: bool) -> Step:
    """Return the step of a clause ``:break``: it ends all loops where the test is true, else it is ``step``."""

    def run(frame: Frame, out: Any) -> Any:
        value = test(frame)
        return step(_entered(layout, frame, is_new=is_new), out) if value is False or value is None else True

    return run


_TESTS = {"when": _when, "unless": _unless, "break": _break}


# --- kinds of loops: initial accumulator, update with each value of the body, final result -----------------------


def _fold_step(rt: Runtime, body: Node, accumulators: Sequence[Any], span: Span) -> Step:
    """Return the step of ``for/fold``, which binds the accumulators in the frame of the iteration and updates them."""
    is_single, values_of = len(accumulators) == 1, unpacker(rt, len(accumulators), span)

    def step(frame: Frame, out: Any) -> Any:
        for bind, value in zip(accumulators, out):
            bind(frame, value)
        value = body(frame)
        out[:] = [value] if is_single else values_of(value)

    return step


class _Kind:
    """Kind of ``for`` loop; the default collects a list. Subclasses are stateless."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        """Return the initial accumulator, a mutable object."""
        return []

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        """Return the step that updates the accumulator with a value of the body."""

        def step(frame: Frame, out: Any) -> Any:
            out.append(body(frame))

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        """Return the result of the form for the final accumulator."""
        return make_list(out)


class _Each(_Kind):
    """``for``: only the effects of the body."""

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(frame: Frame, out: Any) -> Any:
            body(frame)

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return None


class _List(_Kind):
    """``for/list``."""


class _Union(_Kind):
    """``for/union``: the parts of all values."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return PartCollector()

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(frame: Frame, out: Any) -> Any:
            add_parts(rt, out, body(frame), span)

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return out.value()


class _Append(_Kind):
    """``for/append``: the items of all values."""

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        add = item_adder(rt, span)
        return lambda frame, out: add(out, body(frame))


class _Sum(_Kind):
    """``for/sum``: numbers are added inline, arrays and long Integers by ``+``."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return [0]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        plus = rt.library.builtins["+"].function

        def step(frame: Frame, out: Any) -> Any:
            value = body(frame)
            if type(value) is float or type(value) is int:
                out[0] += value
                if type(out[0]) is float or out[0].bit_length() < _MAX_SUM_BITS:
                    return
                out[0] -= value  # `+` adds it again, and checks the size
            try:
                out[0] = plus(rt, out[0], value)
            except SceneError as error:
                if error.span is None:
                    error.span = span
                raise

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return out[0]


class _Quantifier(_Kind):
    """``and``, ``or`` and ``first``: a single value, and possibly an early exit."""

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return out[0]


class _And(_Quantifier):
    """``for/and``: the last value, or false at the first false one."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return [True]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(frame: Frame, out: Any) -> Any:
            value = out[0] = body(frame)
            if value is False or value is None:
                out[0] = False
                return True
            return False

        return step


class _Or(_Quantifier):
    """``for/or``: the first true value."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return [False]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(frame: Frame, out: Any) -> Any:
            value = body(frame)
            if value is False or value is None:
                return False
            out[0] = value
            return True

        return step


class _First(_Quantifier):
    """``for/first``: the value of the body in the first turn, which ends the loop; ``#f`` without turns."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return [False]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(frame: Frame, out: Any) -> Any:
            out[0] = body(frame)
            return True

        return step


class _Fold(_Kind):
    """``for/fold``: the accumulators; ``_fold_step`` is the step."""

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return out[0] if len(out) == 1 else make_list(out)


class _Table(_Kind):
    """``for/table``: a table of the pairs of key and value that the body returns."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return {}

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(frame: Frame, out: Any) -> Any:
            value = body(frame)
            members = items_of(rt, value) if type(value) is Pair else ()
            if len(members) != 2:
                message = f"the body of `for/table` must return `(list key value)`, got {type_name(value)}"
                raise SceneError("value", message, span=span)
            out[table_key(members[0])] = (members[0], members[1])

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return rt.table_of(out)


class _Set(_Kind):
    """``for/set``: the distinct values."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return {}

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(frame: Frame, out: Any) -> Any:
            value = body(frame)
            out.setdefault(table_key(value), value)

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return rt.set_of(out)


_KINDS: dict[str, Any] = {
    "each": _Each, "list": _List, "union": _Union, "append": _Append, "sum": _Sum, "and": _And, "or": _Or,
    "first": _First, "fold": _Fold, "table": _Table, "set": _Set,
}  # fmt: skip
