"""Compiler from the core AST to Python closures over lexically addressed frames.

A compiled expression is a function of the frame. A frame is a list of the enclosing frame followed by one slot per
variable. A call in tail position may return ``TAIL`` and store the callee in the runtime; the caller of the body then
performs the call (a trampoline). A tail call of a named ``let`` returns a marker that continues the loop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.compile import calls, comprehension, generate, generated, intrinsics
from scenelang.interpreter.compile.analyze import (
    Analysis,
    FrameLayout,
    Loop,
    Region,
    analyze,
    cell_reader,
    checked_reader,
    enters_library,
    pattern_variables,
    slot_reader,
    slot_writer,
    undefined,
)
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.procedures import (
    UNDEFINED,
    Cell,
    Closure,
    ClosureCode,
    CodeParameter,
    Escape,
    EscapeSignal,
    Exposure,
    Frame,
    Node,
    items_of,
)
from scenelang.interpreter.runtime.runtime import Runtime, raised_value
from scenelang.interpreter.runtime.show import array_literal
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.values.limits import STEPS_OF_ERROR
from scenelang.interpreter.values.values import Pair, make_list


@dataclass(frozen=True, slots=True, eq=False)
class LoopPlan:
    """Compiled loop, as calls that continue it need it.

    Attributes
    ----------
    mark
        Marker that the body returns to continue with the next iteration.
    layout, slots
        Layout of the frame that has the loop's variables, and their slots in it.
    own_frame
        Whether each iteration has a separate frame.
    """

    mark: Any
    layout: FrameLayout
    slots: tuple[int, ...]
    own_frame: bool


@dataclass(frozen=True, slots=True, eq=False)
class Context:
    """Context of an expression.

    ``tail`` is set in tail position of a function; ``loops`` are the loops that can be continued here.
    """

    layout: FrameLayout
    tail: bool = False
    loops: tuple[tuple[Variable, LoopPlan], ...] = ()

    @property
    def inner(self) -> Context:
        """The same context, but not in tail position."""
        return Context(self.layout) if self.tail or self.loops else self


def compile_forms(rt: Runtime, globals_: dict[Variable, Cell], forms: Sequence[Any]) -> list[Node]:
    """Compile the top-level forms of a file; each is run with a separate empty frame (see ``run_form``)."""
    analysis = analyze(tuple(forms))
    return [Compiler(rt, globals_, analysis).top_level(form) for form in forms]


class Compiler:
    """Compiler for a single run: compiled nodes refer to the runtime and the cells of global variables.

    The methods take a node of the core AST and the context in which its value is used. They return a closure that takes
    the frame and returns the value.
    """

    def __init__(self, rt: Runtime, globals_: dict[Variable, Cell], analysis: Analysis) -> None:
        """Create a compiler of forms that ``analysis`` describes; ``globals_`` are the cells that exist already."""
        self.rt = rt
        self.globals = globals_
        self.analysis = analysis
        self.bounce, self.bind_cell = generated.bouncer(rt), generated.cell_binder(rt)
        self.codes: dict[int, ClosureCode] = {}  # by id of the Lambda
        self.exposures: dict[int, Exposure] = {}  # of all codes of a Lambda, by its id
        self.layouts: dict[int, FrameLayout] = {}  # of the nodes with frames of their own, by id

    def top_level(self, form: Any) -> Node:
        """Compile a top-level form to a node that creates its own frame and ignores its argument."""
        layout = FrameLayout(None)
        context = Context(layout)
        body = self.define(form, context) if type(form) is ast.Define else self.compile(form, context)
        pad = [None] * (layout.size - 1)
        return lambda frame: body([None, *pad])

    def global_cell(self, variable: Variable) -> Cell:
        """Return the cell of a global variable, created at its first use."""
        cell = self.globals.get(variable)
        if cell is None:
            cell = self.globals[variable] = Cell(UNDEFINED, 0)
        return cell

    def global_cells_of(self, code: ClosureCode) -> list[Cell]:
        """Return the cells of the global variables whose value is a closure of ``code``."""
        closures = [(variable, cell) for variable, cell in self.globals.items() if type(cell.value) is Closure]
        return [cell for variable, cell in closures if cell.value.code is code and not variable.assigned]

    def compile(self, node: Any, context: Context) -> Node:
        """Compile an expression to a closure."""
        compiled: Node = _COMPILERS[type(node)](self, node, context)
        return compiled

    def compile_all(self, nodes: Sequence[Any], context: Context) -> tuple[Node, ...]:
        """Compile expressions that are evaluated one after another."""
        return tuple([self.compile(node, context) for node in nodes])

    # --- values and variables ----------------------------------------------------------------------------------

    def constant(self, node: ast.Constant, context: Context) -> Node:
        """Compile a literal or quoted datum."""
        value = node.value
        return lambda frame: value

    def handle(self, node: ast.HandleLiteral, context: Context) -> Node:
        """Compile a handle such as ``<z1>`` to its embedding."""
        value = self.rt.handle(node.name)
        return lambda frame: value

    def address(self, variable: Variable, layout: FrameLayout) -> tuple[int, int]:
        """Return the lexical address of a variable: the number of frames to go outward, and the slot."""
        depth = 0
        while variable not in layout.slots:
            depth += 1
            assert layout.parent is not None, f"{variable.name} has no slot"
            layout = layout.parent
        return depth, layout.slots[variable]

    def in_cell(self, variable: Variable) -> bool:
        """Return whether a variable is stored in a cell: only if it is both assigned and captured by a closure."""
        return variable.assigned and variable.captured

    def reference(self, node: ast.Reference, context: Context) -> Node:
        """Compile a variable to the cheapest reader that is safe: a slot, a checked slot, or a cell."""
        target = node.target
        if not isinstance(target, Variable):
            return lambda frame: target
        if target.is_global:
            return self._global_reference(target, node.span)
        depth, slot = self.address(target, context.layout)
        if self.in_cell(target):
            return cell_reader(self.rt, slot_reader(depth, slot), target.name, node.span)
        if target.recursive:
            return checked_reader(self.rt, slot_reader(depth, slot), target.name, node.span)
        return slot_reader(depth, slot)

    def _global_reference(self, variable: Variable, span: Span) -> Node:
        """Compile a global variable; one that the program assigns is recorded as read."""
        cell = self.global_cell(variable)
        if variable.assigned:
            return cell_reader(self.rt, lambda frame: cell, variable.name, span)
        rt, name = self.rt, variable.name

        def node(frame: Frame) -> Any:
            value = cell.value
            if value is UNDEFINED:
                raise undefined(rt, name, span)
            return value

        return node

    def assignment(self, node: ast.Assignment, context: Context) -> Node:
        """Compile ``set!``."""
        value = self.compile(node.value, context.inner)
        store = self.store(node.target, context.layout, node.span)

        def assign(frame: Frame) -> None:
            store(frame, value(frame))

        return assign

    def store(self, variable: Variable, layout: FrameLayout, span: Span) -> Any:
        """Return ``store(frame, value)``, which assigns an existing variable.

        ``layout`` is the layout of the frame, and ``span`` the location of the assignment, for the error if the
        variable is not defined yet.
        """
        rt, name = self.rt, variable.name
        if variable.is_global or self.in_cell(variable):
            if variable.is_global:
                cell = self.global_cell(variable)
                find: Node = lambda frame: cell
            else:
                find = slot_reader(*self.address(variable, layout))

            def store_cell(frame: Frame, value: Any) -> None:
                target = find(frame)
                if target is None or target.value is UNDEFINED:
                    raise undefined(rt, name, span)
                rt.write(target)
                target.value = value

            return store_cell
        return slot_writer(*self.address(variable, layout))

    def binder(self, target: Any, layout: FrameLayout, span: Span) -> Any:
        """Return ``bind(frame, value)`` for a definition.

        Parameters
        ----------
        target
            Variable, destructuring pattern, or None for ``_``.
        layout
            Layout of the frame; slots for new variables are added.
        span
            Location of the definition, for the error if a value does not fit the pattern.
        """
        if target is None:
            return lambda frame, value: None
        if isinstance(target, tuple):
            return self._pattern_binder(target, layout, span)
        if target.is_global:
            return self._global_binder(target)
        if target not in layout.slots:
            layout.add(target)
        slot = layout.slots[target]
        if self.in_cell(target):
            rt = self.rt

            def bind_cell(frame: Frame, value: Any) -> None:
                cell = frame[slot]
                if type(cell) is Cell and cell.value is UNDEFINED:
                    cell.value = value
                else:
                    frame[slot] = Cell(value, rt.clock)

            return bind_cell
        return slot_writer(0, slot)

    def plain_slot(self, target: Any, layout: FrameLayout) -> int | None:
        """Return the slot of a target that is a single variable of this frame without a cell, else None."""
        if not isinstance(target, Variable) or target.is_global or self.in_cell(target):
            return None
        return layout.slots.get(target)

    def _global_binder(self, variable: Variable) -> Any:
        cell = self.global_cell(variable)
        rt = self.rt

        def bind_global(frame: Frame, value: Any) -> None:
            rt.write(cell)
            cell.value = value

        return bind_global

    def _pattern_binder(self, pattern: tuple[tuple[Any, ...], Any], layout: FrameLayout, span: Span) -> Any:
        """Return ``bind(frame, value)`` for a destructuring pattern ``(item ... . rest)``.

        ``pattern`` is a tuple ``(items, rest)`` of targets, with False as ``rest`` of a pattern without a dot.
        """
        items, rest = pattern
        binders = [self.binder(item, layout, span) for item in items]
        rest_binder = None if rest is False else self.binder(rest, layout, span)
        rt, count = self.rt, len(binders)

        def bind(frame: Frame, value: Any) -> None:
            """Bind the items of the sequence ``value``; raises SceneError("pattern") if their number differs."""
            # `(first . rest)` of a list needs no copy of the list, so that a recursion along a list is linear.
            if count == 1 and rest_binder is not None and type(value) is Pair:
                binders[0](frame, value.car)
                rest_binder(frame, value.cdr)
                return
            members = items_of(rt, value)
            if len(members) < count or (rest_binder is None and len(members) > count):
                expected = f"{count}" if rest_binder is None else f"at least {count}"
                message = f"the pattern expects {expected} items, but the sequence has {len(members)}"
                raise SceneError("pattern", message, span=span)
            for binder, member in zip(binders, members):
                binder(frame, member)
            if rest_binder is not None:
                rest_binder(frame, make_list(members[count:]))

        return bind

    def define(self, node: ast.Define, context: Context) -> Node:
        """Compile a definition; the common case, a variable in a slot of this frame, has a fast path."""
        value = self.compile(node.value, context.inner)
        bind = self.binder(node.target, context.layout, node.span)
        span = node.span
        slot = self.plain_slot(node.target, context.layout)
        if slot is not None:

            def set_slot(frame: Frame) -> None:
                frame[slot] = value(frame)

            return set_slot

        def run(frame: Frame) -> None:
            result = value(frame)
            try:
                bind(frame, result)
            except SceneError as error:
                if error.span is None:
                    error.span = span
                raise

        return run

    # --- control -----------------------------------------------------------------------------------------------

    def conditional(self, node: ast.If, context: Context) -> Node:
        """Compile ``if``."""
        then = self.compile(node.then, context)
        otherwise = self.compile(node.otherwise, context) if node.otherwise is not None else _none
        return self._choice(node.test, then, otherwise, context)

    def _choice(self, condition: Any, then: Node, otherwise: Node, context: Context) -> Node:
        """Compile a test and its branches.

        A comparison of a variable with a number, and predicates, which always return a boolean, have fast paths;
        ``not`` exchanges the branches.
        """
        name, operands = self._intrinsic_use(condition)
        if name == "not" and len(operands) == 1:
            return self._choice(operands[0], otherwise, then, context)
        if name in intrinsics.TESTS and len(operands) == 2 and type(operands[1]) is ast.Constant:
            slot, number = self._local_slot(operands[0], context), operands[1].value
            if slot is not None and type(number) in (int, float):
                slow = calls.slow_call(self.rt, condition.function.target, condition.span)
                return intrinsics.TESTS[name](slot, number, lambda x, y: slow([x, y]), then, otherwise)
        test = self.compile(condition, context.inner)
        if name in intrinsics.PREDICATES:

            def choose_boolean(frame: Frame) -> Any:
                if test(frame):
                    return then(frame)
                return otherwise(frame)

            return choose_boolean

        def choose(frame: Frame) -> Any:
            value = test(frame)
            if value is False or value is None:
                return otherwise(frame)
            return then(frame)

        return choose

    @staticmethod
    def _intrinsic_use(node: Any) -> tuple[str, tuple[Any, ...]]:
        """Return the operation and operands of a call of a builtin with a fast path, or an empty name."""
        if type(node) is ast.Application and type(node.function) is ast.Reference:
            builtin = node.function.target
            if isinstance(builtin, Builtin) and builtin.intrinsic is not None:
                return builtin.intrinsic, node.arguments
        return "", ()

    def conjunction(self, node: ast.And, context: Context) -> Node:
        """Compile ``and``, whose value is that of the first false item or of the last one."""
        if not node.items:
            return lambda frame: True
        *tests, last = [*self.compile_all(node.items[:-1], context.inner), self.compile(node.items[-1], context)]
        if not tests:
            return last

        def all_of(frame: Frame) -> Any:
            for test in tests:
                value = test(frame)
                if value is False or value is None:
                    return value
            return last(frame)

        return all_of

    def disjunction(self, node: ast.Or, context: Context) -> Node:
        """Compile ``or``, whose value is that of the first true item or of the last one."""
        if not node.items:
            return lambda frame: False
        *tests, last = [*self.compile_all(node.items[:-1], context.inner), self.compile(node.items[-1], context)]

        def any_of(frame: Frame) -> Any:
            for test in tests:
                value = test(frame)
                if value is not False and value is not None:
                    return value
            return last(frame)

        return any_of if tests else last

    def body(self, node: ast.Body, context: Context) -> Node:
        """Compile a body.

        Local variables get their slots before the definitions are compiled, so that functions can refer to later ones.
        """
        loop = self.analysis.loops.get(id(node))
        if loop is not None:
            return self._loop(loop, context)
        for item in node.items:
            if type(item) is ast.Define:
                for variable in pattern_variables(item.target):
                    if not variable.is_global:
                        context.layout.add(variable)
        prepare = self._prepare(node, context)
        last = len(node.items) - 1
        steps = []
        for index, item in enumerate(node.items):
            if type(item) is ast.Define:
                steps.append(self.define(item, context))
            else:
                steps.append(self.compile(item, context if index == last else context.inner))
        return _sequence([*prepare, *steps])

    def _prepare(self, node: ast.Body, context: Context) -> list[Node]:
        """Return steps that mark variables as undefined if they might be read before their definition."""
        early = [
            (context.layout.slots[variable], self.in_cell(variable))
            for item in node.items
            if type(item) is ast.Define
            for variable in pattern_variables(item.target)
            if not variable.is_global and (variable.recursive or self.in_cell(variable))
        ]
        if not early:
            return []
        rt = self.rt

        def prepare(frame: Frame) -> None:
            for slot, in_cell in early:
                frame[slot] = Cell(UNDEFINED, rt.clock) if in_cell else UNDEFINED

        return [prepare]

    def _loop(self, loop: Loop, context: Context) -> Node:
        """Compile a named ``let`` in tail position to a Python loop.

        After ``rt.hot`` turns, generated code continues it.
        """
        function = loop.function
        region = self.analysis.regions[id(function)]
        layout = FrameLayout(context.layout) if region.has_frame else context.layout
        slots = tuple([layout.add(parameter.target) for parameter in function.parameters])
        starts = self.compile_all(loop.start.arguments, context.inner)
        self.layouts[id(function)] = layout
        plan = LoopPlan(object(), layout, slots, region.has_frame)
        inner = Context(layout, context.tail, (*context.loops, (loop.variable, plan)))
        binders = [self.binder(p.target, layout, loop.start.span) for p in function.parameters]
        body = self.compile(function.body, inner)
        if region.has_frame:
            return calls.framed_loop(self.rt, plan.mark, starts, binders, body, layout)
        if self.rt.hot is None:
            return calls.plain_loop(self.rt, plan.mark, starts, binders, body)

        def generate_loop() -> Callable[[Frame, int], Any] | None:
            return loop_function(self, loop, layout, context.tail)

        return calls.counted_loop(self.rt, plan.mark, starts, binders, body, self.rt.hot, generate_loop)

    def repeated(self, node: Any, context: Context) -> Node:
        """Compile the body or the test of a loop, which generated code replaces after ``rt.hot`` turns.

        Unlike a function or a named ``let``, a loop may be entered once and turn a million times.
        """
        cold = self.compile(node, context)
        if self.rt.hot is None or type(node) in (ast.Constant, ast.Reference):
            return cold
        left, replacement = self.rt.hot, None

        def run(frame: Frame) -> Any:
            nonlocal left, replacement
            if replacement is not None:
                return replacement(frame)
            left -= 1
            if left == 0:
                replacement = expression_function(self, node, context.layout) or cold
            return cold(frame)

        return run

    def while_loop(self, node: ast.While, context: Context) -> Node:
        """Compile ``while``."""
        region = self.analysis.regions[id(node)]
        layout = FrameLayout(context.layout) if region.has_frame else context.layout
        inner = Context(layout)
        test = self.repeated(node.test, inner)
        body = self.repeated(node.body, inner)
        tick = self.rt.tick

        def run(outer: Frame) -> None:
            try:
                while True:
                    tick()
                    frame = [outer, *([None] * (layout.size - 1))] if region.has_frame else outer
                    value = test(frame)
                    if value is False or value is None:
                        return
                    body(frame)
            except SceneError as error:
                error.span = error.span or node.span
                raise

        return run

    def first(self, node: ast.First, context: Context) -> Node:
        """Compile ``begin0``: the value of the first expression, then the effects of the others."""
        head, *rest = self.compile_all(node.items, context.inner)

        def run(frame: Frame) -> Any:
            value = head(frame)
            for step in rest:
                step(frame)
            return value

        return run

    def let_escape(self, node: ast.LetEscape, context: Context) -> Node:
        """Compile ``let/ec``: the escape procedure raises a signal, and is inactive after the body."""
        bind = self.binder(node.target, context.layout, node.span)
        body = self.compile(node.body, context.inner)
        name = node.name

        def run(frame: Frame) -> Any:
            escape = Escape(name)
            bind(frame, escape)
            try:
                return body(frame)
            except EscapeSignal as signal:
                if signal.escape is escape:
                    return signal.value
                raise
            finally:
                escape.active = False

        return run

    def guard(self, node: ast.Guard, context: Context) -> Node:
        """Compile ``guard``.

        Limit errors are not caught. A caught error is charged, because its message takes time to build.
        """
        body = self.compile(node.body, context.inner)
        bind = self.binder(node.target, context.layout, node.span)
        handler = self.compile(node.handler, context)
        charge = self.rt.charge

        def run(frame: Frame) -> Any:
            try:
                return body(frame)
            except LimitError:
                raise
            except SceneError as error:
                caught = error
            charge(STEPS_OF_ERROR)
            bind(frame, raised_value(caught))
            return handler(frame)

        return run

    # --- functions ---------------------------------------------------------------------------------------------

    def function(self, node: ast.Lambda, context: Context) -> Node:
        """Compile a ``lambda``; its body is compiled at the first call."""
        layout = FrameLayout(context.layout)
        slots = [layout.add(parameter.target) for parameter in node.parameters]
        inner = Context(layout)
        parameters = tuple([
            CodeParameter(
                p.name, p.kind, slot, p.type,
                self._default(p.default, inner, len(slots)) if p.default is not None else None,
                p.target is not None and self.in_cell(p.target),
            )
            for p, slot in zip(node.parameters, slots)
        ])  # fmt: skip
        is_plain = all(p.kind == "required" and p.type is None and not p.in_cell for p in parameters)
        arity = len(parameters) if is_plain else -1
        code = ClosureCode(node.name, parameters, node.usage, arity, _none, self.exposure_of(node))
        code.body = self._at_first_call(node, code, layout)
        self.codes[id(node)] = code
        self.layouts[id(node)] = layout
        return lambda frame: Closure(code, frame)

    def exposure_of(self, node: ast.Lambda) -> Exposure:
        """Return what all codes of a function share."""
        return self.exposures.setdefault(id(node), Exposure())

    def _default(self, node: Any, context: Context, parameters: int) -> Node:
        """Compile the default of a parameter; its local variables are those of a copy of the frame."""
        body = self.compile(node, context)
        locals_ = (None,) * (context.layout.size - 1 - parameters)
        return (lambda frame: body([*frame, *locals_])) if locals_ else body

    def _at_first_call(self, node: ast.Lambda, code: ClosureCode, layout: FrameLayout) -> Node:
        """Return a body that compiles the function when it is first called, and again when it becomes hot."""

        def first(frame: Frame) -> Any:
            if code.body is first:
                body = self.compile(node.body, Context(layout, tail=True))
                body = calls.with_locals(body, layout.size - 1 - len(code.parameters))
                code.body = body if self.rt.hot is None else self._counting(node, code, layout, body, self.rt.hot)
            return code.body(frame)

        return first

    def _counting(self, node: ast.Lambda, code: ClosureCode, layout: FrameLayout, body: Node, hot: int) -> Node:
        """Return a body that counts its calls and is replaced by generated code at the call number ``hot``."""
        left = hot

        def counted(frame: Frame) -> Any:
            nonlocal left
            left -= 1
            if left == 0:
                code.body = body
                replace_function(self, node, code, layout)
            return body(frame)

        return counted

    def application(self, node: ast.Application, context: Context) -> Node:
        """Compile a call: of a builtin, of a loop's continuation, or of a procedure."""
        head = node.function
        if type(head) is ast.Reference:
            target = head.target
            if isinstance(target, Builtin):
                return self._builtin_call(target, node, context)
            for variable, plan in context.loops:
                if variable is target:
                    return self._next_iteration(plan, node, context)
        arguments = self.compile_all(node.arguments, context.inner)
        function = self._head(head, context.inner)
        factory = calls.tail_call if context.tail and not enters_library(node) else calls.call
        return factory(self.rt, function, arguments, node.span)

    def _head(self, head: Any, context: Context) -> Node:
        """Compile the function of a call. An undefined global is not checked here, because calling it fails anyway."""
        if type(head) is ast.Reference and isinstance(head.target, Variable):
            variable = head.target
            if variable.is_global and not variable.assigned:
                return calls.GlobalHead(self.global_cell(variable), variable.name, head.span)
        return self.compile(head, context)

    def _next_iteration(self, plan: LoopPlan, node: ast.Application, context: Context) -> Node:
        """Compile the continuation of a loop: assign its variables and return its marker."""
        arguments = self.compile_all(node.arguments, context.inner)
        if plan.own_frame:
            return calls.next_framed_iteration(self.rt, plan.mark, arguments)
        depth, layout = 0, context.layout
        while layout is not plan.layout:
            depth += 1
            assert layout.parent is not None
            layout = layout.parent
        step = self._step(node.arguments[0], plan, context) if len(arguments) == 2 and depth == 0 else None
        if step is not None:
            return calls.next_counted_iteration(plan.mark, arguments[0], arguments[1], plan.slots, step)
        return calls.next_iteration(plan.mark, arguments, plan.slots, depth)

    def _step(self, argument: Any, plan: LoopPlan, context: Context) -> int | None:
        """Return the constant in ``(+ i constant)``, where ``i`` is the loop's first variable, else None."""
        name, operands = self._intrinsic_use(argument)
        if name != "add" or len(operands) != 2 or type(operands[1]) is not ast.Constant:
            return None
        step = operands[1].value
        return step if type(step) is int and self._local_slot(operands[0], context) == plan.slots[0] else None

    def _builtin_call(self, builtin: Builtin, node: ast.Application, context: Context) -> Node:
        intrinsic = builtin.intrinsic
        if intrinsic is not None:
            fast = self._intrinsic(builtin, intrinsic, node, context)
            if fast is not None:
                return fast
        arguments = self.compile_all(node.arguments, context.inner)
        if builtin.name == "apply" and context.tail:
            return calls.tail_apply(self.rt, builtin, arguments, node.span)
        names = calls.keyword_places(builtin, node.arguments)
        if names:
            return calls.keyword_call(self.rt, builtin, arguments, names, node.span)
        return calls.builtin_call(self.rt, builtin, arguments, node.span)

    def _intrinsic(self, builtin: Builtin, name: str, node: ast.Application, context: Context) -> Node | None:
        """Compile a call of a builtin with a fast path; None if it has none for these operands.

        More than two operands are nested to the left.
        """
        operands = node.arguments
        if len(operands) == 1 and name in intrinsics.UNARY:
            slow_one = calls.slow_call(self.rt, builtin, node.span)
            return intrinsics.UNARY[name](self.compile(operands[0], context.inner), lambda x: slow_one([x]))
        if name in intrinsics.ITEMS:
            count, make = intrinsics.ITEMS[name]
            if len(operands) != count:
                return None
            fast = make(self.rt, calls.spread_call(self.rt, builtin, node.span))
            return calls.called(fast, self.compile_all(operands, context.inner))
        if name not in intrinsics.BINARY:
            return None
        if len(operands) > 2 and name in ("add", "mul", "matmul"):
            nested = ast.Application(node.function, operands[:-1], node.span)
            return self._intrinsic(
                builtin, name, ast.Application(node.function, (nested, operands[-1]), node.span), context
            )
        if len(operands) != 2:
            return None
        slow_call = calls.slow_call(self.rt, builtin, node.span)

        slow: intrinsics.Slow = lambda x, y: slow_call([x, y])
        if name in intrinsics.ARITHMETIC:
            slow = intrinsics.ARITHMETIC[name](slow)
        left = self._local_slot(operands[0], context)
        number = operands[1].value if type(operands[1]) is ast.Constant else None
        if left is not None and type(number) in (int, float) and name in intrinsics.SLOT_CONSTANT:
            return intrinsics.SLOT_CONSTANT[name](left, number, slow)
        right = self._local_slot(operands[1], context)
        if left is not None and right is not None and name in intrinsics.SLOTS:
            return intrinsics.SLOTS[name](left, right, slow)
        a, b = self.compile_all(operands, context.inner)
        return intrinsics.BINARY[name](a, b, slow)

    def _local_slot(self, node: Any, context: Context) -> int | None:
        """Return the slot of a variable of this frame that needs no check or cell, else None."""
        if type(node) is ast.Reference and isinstance(node.target, Variable):
            variable = node.target
            if not (variable.is_global or variable.recursive or self.in_cell(variable)):
                return context.layout.slots.get(variable)
        return None

    def array(self, node: ast.ArrayLiteral, context: Context) -> Node:
        """Compile an array literal; one of constants is computed now."""
        items = self.compile_all(node.items, context.inner)
        span = node.span
        if all(type(item) is ast.Constant for item in node.items):
            try:
                value = array_literal([item.value for item in node.items])  # type: ignore[union-attr]
            except SceneError:
                pass  # report the error at run time, where a `guard` can catch it
            else:
                return lambda frame: value
        return calls.array_node(self.rt, items, span)

    def for_loop(self, node: ast.For, context: Context) -> Node:
        """Compile a ``for`` form."""
        return comprehension.compile_for(self, node, context)

    def bind(self, node: ast.Bind, context: Context) -> Node:
        """Compile ``bind`` of a word."""
        return calls.compile_bind(self, node, context)

    def call(self, node: ast.Call, context: Context) -> Node:
        """Compile ``call`` of a word."""
        return calls.compile_call(self, node, context)

    def union(self, node: ast.Union, context: Context) -> Node:
        """Compile ``union``."""
        return calls.compile_union(self, node, context)

    def union_loop(self, node: ast.UnionLoop, context: Context) -> Node:
        """Compile ``union-loop``."""
        return calls.compile_union_loop(self, node, context)

    def transform(self, node: ast.Transform, context: Context) -> Node:
        """Compile ``transform``."""
        return calls.compile_transform(self, node, context)

    def embedded(self, node: Any, layout: FrameLayout) -> Node:
        """Compile a part of a generated function to a closure, which finds its variables in the frame."""
        context = Context(layout)
        return self.define(node, context) if type(node) is ast.Define else self.compile(node, context)

    def region(self, node: Any) -> Region:
        """Return the region of a function or loop."""
        return self.analysis.regions[id(node)]


_COMPILERS: dict[type, Any] = {
    ast.Constant: Compiler.constant, ast.HandleLiteral: Compiler.handle, ast.Reference: Compiler.reference,
    ast.Assignment: Compiler.assignment, ast.If: Compiler.conditional, ast.And: Compiler.conjunction,
    ast.Or: Compiler.disjunction, ast.Lambda: Compiler.function, ast.Body: Compiler.body, ast.First: Compiler.first,
    ast.Application: Compiler.application, ast.ArrayLiteral: Compiler.array, ast.While: Compiler.while_loop,
    ast.For: Compiler.for_loop, ast.LetEscape: Compiler.let_escape, ast.Guard: Compiler.guard, ast.Bind: Compiler.bind,
    ast.Call: Compiler.call, ast.Union: Compiler.union, ast.UnionLoop: Compiler.union_loop,
    ast.Transform: Compiler.transform,
}  # fmt: skip


def _none(frame: Frame) -> None:
    """Node of a missing expression, such as the ``else`` branch of an ``if`` without one."""
    return None


def _sequence(steps: list[Node]) -> Node:
    """Return a node that runs steps in order and returns the value of the last."""
    if len(steps) == 1:
        return steps[0]
    if len(steps) == 2:
        first, second = steps

        def run_two(frame: Frame) -> Any:
            first(frame)
            return second(frame)

        return run_two
    *before, last = steps

    def run_all(frame: Frame) -> Any:
        for step in before:
            step(frame)
        return last(frame)

    return run_all


# What the generator and CPython raise for code that stays with the closures.
_REJECTED = (generated.Unsupported, RecursionError, SyntaxError, MemoryError)


def replace_function(compiler: Compiler, node: ast.Lambda, code: ClosureCode, layout: FrameLayout) -> None:
    """Replace the body of a function by generated code, unless the generator or CPython rejects it.

    Parameters
    ----------
    node
        The function.
    code
        Its closures, whose entry point is replaced.
    layout
        Layout of its frames.
    """
    try:
        writer = generate.FunctionWriter(compiler, layout, node.body)
        entry = writer.function(node, code)
    except _REJECTED:
        return
    code.entry = entry
    code.direct, code.returns_tail = entry, writer.returns_tail
    code.body = _ADAPTERS[code.arity](entry) if code.arity >= 0 else entry


def loop_function(
    compiler: Compiler, loop: Loop, layout: FrameLayout, tail: bool
) -> Callable[[Frame, int], Any] | None:
    """Return a function of the frame that continues a loop after a number of turns; None if it cannot be generated.

    Parameters
    ----------
    loop
        The loop.
    layout
        Layout of the frame that has its variables.
    tail
        Whether the loop is in tail position, so that the function may return a tail call.
    """
    try:
        return generate.FunctionWriter(compiler, layout, loop.function.body).loop(loop, tail)
    except _REJECTED:
        return None


def expression_function(compiler: Compiler, node: Any, layout: FrameLayout) -> Node | None:
    """Return generated code for the value of an expression in a frame; None if it cannot be generated."""
    try:
        return generate.FunctionWriter(compiler, layout, node).expression(node)
    except _REJECTED:
        return None


_ADAPTERS: tuple[Callable[[Any], Node], ...] = (
    lambda g: lambda frame: g(frame[0]),
    lambda g: lambda frame: g(frame[0], frame[1]),
    lambda g: lambda frame: g(frame[0], frame[1], frame[2]),
    lambda g: lambda frame: g(frame[0], frame[1], frame[2], frame[3]),
    lambda g: lambda frame: g(frame[0], frame[1], frame[2], frame[3], frame[4]),
    lambda g: lambda frame: g(frame[0], frame[1], frame[2], frame[3], frame[4], frame[5]),
    lambda g: lambda frame: g(frame[0], frame[1], frame[2], frame[3], frame[4], frame[5], frame[6]),
    lambda g: lambda frame: g(frame[0], frame[1], frame[2], frame[3], frame[4], frame[5], frame[6], frame[7]),
    lambda g: lambda frame: g(frame[0], frame[1], frame[2], frame[3], frame[4], frame[5], frame[6], frame[7], frame[8]),
)
