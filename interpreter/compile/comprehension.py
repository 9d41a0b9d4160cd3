"""Compiler of ``for`` forms: clauses become nested Python loops around a step that updates an accumulator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile.analyse import FrameLayout
from scenelang.interpreter.compile.calls import item_adder, unpacker
from scenelang.interpreter.runtime.parts import parts_of
from scenelang.interpreter.runtime.procedures import Frame, Node, items_of, iterate
from scenelang.interpreter.runtime.types import type_name
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values.values import IDENTITY, Matrix, Pair, make_list, table_key

if TYPE_CHECKING:
    from scenelang.interpreter.compile.compile import Compiler, Context
    from scenelang.interpreter.runtime.runtime import Runtime


Step = Callable[[Frame, Any], Any]  # takes the frame and the accumulator; returns True to end all loops


def compile_for(compiler: Compiler, node: ast.For, context: Context) -> Node:
    """Compile a ``for`` form of any kind to a closure."""
    from scenelang.interpreter.compile.compile import Context as MakeContext

    rt = compiler.rt
    framed = compiler.region(node).has_frame
    layout = FrameLayout(context.layout) if framed else context.layout
    inner = MakeContext(layout)
    starts = [compiler.compile(accumulator.value, context.inner) for accumulator in node.accumulators]
    accumulators = [compiler.binder(a.target, layout, node.span) for a in node.accumulators]
    levels = []
    for index, clause in enumerate(node.clauses):
        outer = context.inner if index == 0 and not node.accumulators else inner
        levels.append(_level(compiler, clause, outer, inner, node.span))
    body = compiler.compile(node.body, inner)
    kind = _KINDS[node.kind]
    step = kind.step(rt, body, node.span)
    if accumulators:
        step = _fold_step(rt, body, accumulators, node.span)
    first_outside = bool(node.clauses) and not node.accumulators and framed
    for number, level in reversed(list(enumerate(levels))):
        step = level(rt, step, layout if framed else None, first_outside and number == 0)

    def run(f: Frame) -> Any:
        out = kind.start(rt) if not starts else [start(f) for start in starts]
        frame = f
        if framed and not first_outside:
            frame = [f, *([None] * (layout.size - 1))]
        for bind, value in zip(accumulators, out if starts else ()):
            bind(frame, value)
        step(frame, out)
        try:
            return kind.finish(rt, out)
        except SceneError as error:
            if error.span is None:
                error.span = node.span
            raise

    return run


def _level(compiler: Compiler, clause: ast.Clause, outer: Any, inner: Any, span: Span) -> Any:
    """Return a function that wraps a step in the loop or test of a clause."""
    if clause.kind == "each":
        values = compiler.compile_all(clause.values, outer)
        binders = [compiler.binder(target, inner.layout, span) for target in clause.targets]
        slot = compiler.plain_slot(clause.targets[0], inner.layout) if len(binders) == 1 else None
        return lambda rt, step, layout, fresh: (
            _each_slot(rt, values[0], slot, step, clause.values[0].span)
            if slot is not None and layout is None
            else _each(rt, values, binders, step, layout, fresh, clause, span)
        )
    test = compiler.compile(clause.values[0], outer)
    return lambda rt, step, layout, fresh: _TESTS[clause.kind](test, step, layout, fresh)


def _each_slot(rt: Runtime, value: Node, slot: int, step: Step, place: Span) -> Step:
    """Loop over one sequence with a single variable in an existing frame, the most common case."""
    tick = rt.tick

    def run(f: Frame, out: Any) -> Any:
        sequence = value(f)
        try:
            items = iterate(rt, sequence)
        except SceneError as error:
            if error.span is None:
                error.span = place
            raise
        for item in items:
            tick()
            f[slot] = item
            if step(f, out):
                return True
        return False

    return run


def _each(
    rt: Runtime, values: Sequence[Node], binders: Sequence[Any], step: Step, layout: Any, fresh: bool,
    clause: ast.Clause, span: Span,
) -> Step:  # fmt: skip
    tick = rt.tick
    places = [value.span for value in clause.values]

    def iteration_frame(f: Frame) -> Frame:
        """Return the frame of an iteration: ``f`` itself, or a new one if closures capture variables."""
        if layout is None:
            return f
        return [f, *([None] * (layout.size - 1))] if fresh else f[:]

    def sequences(f: Frame) -> list[Any]:
        found = []
        for value, place in zip(values, places):
            sequence = value(f)
            try:
                found.append(iterate(rt, sequence))
            except SceneError as error:
                if error.span is None:
                    error.span = place
                raise
        return found

    if len(values) == 1:
        (bind,) = binders

        def run_one(f: Frame, out: Any) -> Any:
            (sequence,) = sequences(f)
            for item in sequence:
                tick()
                frame = iteration_frame(f)
                bind(frame, item)
                if step(frame, out):
                    return True
            return False

        return run_one

    def run(f: Frame, out: Any) -> Any:
        for items in zip(*sequences(f)):
            tick()
            frame = iteration_frame(f)
            for bind, item in zip(binders, items):
                bind(frame, item)
            if step(frame, out):
                return True
        return False

    return run


def _entered(layout: Any, fresh: bool, f: Frame) -> Frame:
    return [f, *([None] * (layout.size - 1))] if fresh and layout is not None else f


def _when(test: Node, step: Step, layout: Any, fresh: bool) -> Step:
    def run(f: Frame, out: Any) -> Any:
        value = test(f)
        return False if value is False or value is None else step(_entered(layout, fresh, f), out)

    return run


def _unless(test: Node, step: Step, layout: Any, fresh: bool) -> Step:
    def run(f: Frame, out: Any) -> Any:
        value = test(f)
        return step(_entered(layout, fresh, f), out) if value is False or value is None else False

    return run


def _break(test: Node, step: Step, layout: Any, fresh: bool) -> Step:
    def run(f: Frame, out: Any) -> Any:
        value = test(f)
        return step(_entered(layout, fresh, f), out) if value is False or value is None else True

    return run


_TESTS = {"when": _when, "unless": _unless, "break": _break}


# --- kinds of loops: initial accumulator, update with each value of the body, final result -----------------------


def _fold_step(rt: Runtime, body: Node, accumulators: Sequence[Any], span: Span) -> Step:
    """Return the step of ``for/fold``, which binds the accumulators in the frame of the iteration and updates them."""
    is_single, values_of = len(accumulators) == 1, unpacker(rt, len(accumulators), span)

    def step(f: Frame, out: Any) -> Any:
        for bind, value in zip(accumulators, out):
            bind(f, value)
        value = body(f)
        out[:] = [value] if is_single else values_of(value)

    return step


class _Kind:
    """Kind of ``for`` loop; the default collects a list. Subclasses are stateless."""

    @staticmethod
    def start(rt: Runtime) -> Any:
        return []

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            out.append(body(f))

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return make_list(out)


class _Each(_Kind):
    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            body(f)

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return None


class _List(_Kind):
    pass


class _Union(_Kind):
    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            value = body(f)
            if type(value) is Pair and type(value.cdr) is Matrix and type(value.car) is Entity:
                out.append(value)
            elif type(value) is Entity:
                out.append(Pair(value, IDENTITY))
            else:
                try:
                    out.extend(parts_of(rt, value))
                except SceneError as error:
                    if error.span is None:
                        error.span = span
                    raise

        return step


class _Append(_Kind):
    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        add = item_adder(rt, span)
        return lambda f, out: add(out, body(f))


class _Sum(_Kind):
    @staticmethod
    def start(rt: Runtime) -> Any:
        return [0]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        plus = rt.library.builtins["+"].function

        def step(f: Frame, out: Any) -> Any:
            value = body(f)
            if type(value) is float or type(value) is int:
                out[0] += value
                if type(out[0]) is float or out[0].bit_length() < 4000:
                    return
                out[0] -= value
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
    @staticmethod
    def start(rt: Runtime) -> Any:
        return [True]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            value = out[0] = body(f)
            if value is False or value is None:
                out[0] = False
                return True
            return False

        return step


class _Or(_Quantifier):
    @staticmethod
    def start(rt: Runtime) -> Any:
        return [False]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            value = body(f)
            if value is False or value is None:
                return False
            out[0] = value
            return True

        return step


class _First(_Quantifier):
    @staticmethod
    def start(rt: Runtime) -> Any:
        return [False]

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            out[0] = body(f)
            return True

        return step


class _Fold(_Kind):
    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return out[0] if len(out) == 1 else make_list(out)


class _Table(_Kind):
    @staticmethod
    def start(rt: Runtime) -> Any:
        return {}

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            value = body(f)
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
    @staticmethod
    def start(rt: Runtime) -> Any:
        return {}

    @staticmethod
    def step(rt: Runtime, body: Node, span: Span) -> Step:
        def step(f: Frame, out: Any) -> Any:
            value = body(f)
            out.setdefault(table_key(value), value)

        return step

    @staticmethod
    def finish(rt: Runtime, out: Any) -> Any:
        return rt.set_of(out)


_KINDS: dict[str, Any] = {
    "each": _Each, "list": _List, "union": _Union, "append": _Append, "sum": _Sum, "and": _And, "or": _Or,
    "first": _First, "fold": _Fold, "table": _Table, "set": _Set,
}  # fmt: skip
