"""Variable analysis of the core AST before compilation: frames, captured variables, and loops that need no calls.

A *region* is a part of the program whose variables have the same lifetime: the body of a function or of a loop. A
function's region has a separate frame. A loop's region has one only if a closure captures its variables, because each
iteration then needs new variables; otherwise its variables are stored in the enclosing frame.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span, dataclass, field
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile.kinds import (
    ANY,
    FLOAT,
    INTEGER,
    NUMBER,
    Kind,
    integer_of,
    is_number,
    join,
    join_all,
    kind_of_operand,
    without_bits,
)
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.procedures import UNDEFINED, Frame, Node
from scenelang.interpreter.runtime.types import STD, Builtin
from scenelang.interpreter.values.values import Pair

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime


class Region:
    """Body of a function (``is_function``) or loop, within the region ``parent``.

    ``has_frame`` is set if its variables need a separate frame.
    """

    __slots__ = ("has_frame", "is_function", "parent")

    def __init__(self, parent: Region | None, is_function: bool) -> None:
        self.parent = parent
        self.is_function = is_function
        self.has_frame = is_function


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """Named ``let`` or ``do`` whose function is only called in tail position of its own body.

    Attributes
    ----------
    variable
        Name of the loop.
    function
        Its variables and body.
    start
        Call with the initial values.
    """

    variable: Variable
    function: ast.Lambda
    start: ast.Application


@dataclass(slots=True, eq=False)
class Analysis:
    """Result of the analysis.

    ``regions`` are keyed by the id of the Lambda, For or While node, ``loops`` by the id of the Body that is a loop.

    ``parts`` has the ids of the forms that make parts (``union`` and its kin) and whose value only becomes parts: of
    another such form, or of an entity. They may return columns, which programs never see. Their values are None, or
    the Lambda of a word whose body they end, which others may get by ``retrieve``.
    """

    regions: dict[int, Region] = field(default_factory=dict)
    loops: dict[int, Loop] = field(default_factory=dict)
    parts: dict[int, ast.Lambda | None] = field(default_factory=dict)


def pattern_variables(target: Any) -> Iterator[Variable]:
    """Iterate over the variables of a binding target: a Variable, None, or a pattern ``(items, rest)``."""
    stack = [target]
    while stack:
        item = stack.pop()
        if isinstance(item, Variable):
            yield item
        elif isinstance(item, tuple):
            stack.extend(item[0])
            if item[1] is not False:
                stack.append(item[1])


def children(node: Any) -> list[Any]:
    """Return the direct subexpressions of a node."""
    kind = type(node)
    if kind in (ast.Constant, ast.HandleLiteral, ast.Reference):
        return []
    return _CHILDREN[kind](node)


_CHILDREN: dict[type, Callable[[Any], list[Any]]] = {
    ast.Assignment: lambda n: [n.value],
    ast.If: lambda n: [n.test, n.then] if n.otherwise is None else [n.test, n.then, n.otherwise],
    ast.And: lambda n: list(n.items),
    ast.Or: lambda n: list(n.items),
    ast.Lambda: lambda n: [*(p.default for p in n.parameters if p.default is not None), n.body],
    ast.Define: lambda n: [n.value],
    ast.Body: lambda n: list(n.items),
    ast.First: lambda n: list(n.items),
    ast.Application: lambda n: [n.function, *n.arguments],
    ast.ArrayLiteral: lambda n: list(n.items),
    ast.While: lambda n: [n.test, n.body],
    ast.For: lambda n: [*n.accumulators, *(v for clause in n.clauses for v in clause.values), n.body],
    ast.LetEscape: lambda n: [n.body],
    ast.Guard: lambda n: [n.body, n.handler],
    ast.Bind: lambda n: [n.word, n.function],
    ast.Call: lambda n: [n.word, *n.arguments],
    ast.Union: lambda n: list(n.members),
    ast.UnionLoop: lambda n: [n.count, n.function],
    ast.Transform: lambda n: [n.part, n.matrix],
}


def walk(*roots: Any) -> Iterator[Any]:
    """Iterate over ``roots`` and all their descendants."""
    stack = list(roots)
    while stack:
        node = stack.pop()
        yield node
        stack.extend(children(node))


def mentioned(form: Any) -> Iterator[Variable]:
    """Iterate over the variables that a form refers to, assigns or defines."""
    for node in walk(form):
        if type(node) is ast.Define:
            yield from pattern_variables(node.target)
        elif type(node) in (ast.Reference, ast.Assignment) and isinstance(node.target, Variable):
            yield node.target


def strings_in(value: Any) -> Iterator[str]:
    """Iterate over the strings in a constant, including quoted lists."""
    stack = [value]
    while stack:
        item = stack.pop()
        if type(item) is str:
            yield item
        elif type(item) is Pair:
            stack += (item.car, item.cdr)


def called_builtin(node: Any) -> str | None:
    """Return the name of the builtin that an expression calls, None for any other expression."""
    if type(node) is not ast.Application or type(node.function) is not ast.Reference:
        return None
    target = node.function.target
    return target.name if isinstance(target, Builtin) else None


def analyze(forms: tuple[Any, ...]) -> Analysis:
    """Analyze the top-level forms of a file.

    This also sets two attributes of each variable that the forms bind: ``owner``, the region that binds it, and
    ``captured``, whether a closure refers to it.
    """
    analysis = Analysis()
    top = Region(None, is_function=True)
    for form in forms:
        _Analyzer(analysis, form).visit(form, top)
    return analysis


class _Analyzer:
    """Visitor of one top-level form, which records its regions and loops and marks captured variables."""

    def __init__(self, analysis: Analysis, form: Any) -> None:
        self.analysis = analysis
        self._loops = _Loops(form)

    def visit(self, node: Any, region: Region) -> None:
        """Visit an expression whose variables live in ``region``."""
        kind = type(node)
        if kind in _CONSUMED:
            for consumed in _CONSUMED[kind](node):
                self._mark_parts(consumed, node.function if kind is ast.Bind else None)
        if kind is ast.Reference:
            self._use(node.target, region)
        elif kind is ast.Assignment:
            self._use(node.target, region)
            self.visit(node.value, region)
        elif kind is ast.Lambda:
            self._function(node, region)
        elif kind is ast.For:
            self._for(node, region)
        elif kind is ast.While:
            inner = self._region(node, region, is_function=False)
            self.visit(node.test, inner)
            self.visit(node.body, inner)
        elif kind is ast.Body:
            self._body(node, region)
        elif kind is ast.Define:
            self._set_owner(node.target, region)
            self.visit(node.value, region)
        else:
            if kind is ast.LetEscape or kind is ast.Guard:
                self._set_owner(node.target, region)
            for child in children(node):
                self.visit(child, region)

    def _mark_parts(self, node: Any, owner: ast.Lambda | None) -> None:
        """Record in ``Analysis.parts`` which forms make the value of ``node``: through bodies and branches, to a
        ``union`` and its kin. ``owner`` is the Lambda of the word whose body they end, None within another form."""
        ends = [node]
        while ends:
            end = ends.pop()
            kind = type(end)
            if kind is ast.Body and end.items:
                ends.append(end.items[-1])
            elif kind is ast.If:
                ends += [end.then, end.otherwise]
            elif kind in (ast.Union, ast.UnionLoop, ast.Transform) or (kind is ast.For and end.kind == "union"):
                self.analysis.parts[id(end)] = owner

    def _region(self, node: Any, parent: Region, *, is_function: bool) -> Region:
        """Create the region of a node."""
        region = self.analysis.regions[id(node)] = Region(parent, is_function)
        return region

    def _set_owner(self, target: Any, region: Region) -> None:
        """Record the region in which the variables of a binding target live."""
        for variable in pattern_variables(target):
            variable.owner = region

    def _use(self, target: Any, region: Region) -> None:
        """Mark a variable as captured if a function lies between its region and the use."""
        if not isinstance(target, Variable) or target.is_global:
            return
        owner, inner, crossed = target.owner, region, False
        while inner is not owner and inner is not None:
            crossed = crossed or inner.is_function
            inner = inner.parent  # type: ignore[assignment]
        if crossed:
            target.captured = True
            if owner is not None:
                owner.has_frame = True

    def _function(self, node: ast.Lambda, region: Region) -> None:
        """Visit a function, whose parameters and body form a region with a separate frame."""
        inner = self._region(node, region, is_function=True)
        for parameter in node.parameters:
            self._set_owner(parameter.target, inner)
        for parameter in node.parameters:
            if parameter.default is not None:
                self.visit(parameter.default, inner)
        self.visit(node.body, inner)

    def _for(self, node: ast.For, region: Region) -> None:
        """Visit a ``for`` form.

        The first sequence is evaluated outside the loop's region unless accumulators precede it.
        """
        for accumulator in node.accumulators:
            self.visit(accumulator.value, region)
        inner = self._region(node, region, is_function=False)
        for accumulator in node.accumulators:
            self._set_owner(accumulator.target, inner)
        for index, clause in enumerate(node.clauses):
            for target in clause.targets:
                self._set_owner(target, inner)
            for value in clause.values:
                self.visit(value, region if index == 0 and not node.accumulators else inner)
        self.visit(node.body, inner)

    def _body(self, node: ast.Body, region: Region) -> None:
        """Visit a body; one that is a loop gets a region without a frame until a closure captures a variable."""
        loop = self._loops.find(node)
        if loop is not None:
            self.analysis.loops[id(node)] = loop
            for argument in loop.start.arguments:
                self.visit(argument, region)
            loop.variable.owner = region
            inner = self._region(loop.function, region, is_function=False)
            for parameter in loop.function.parameters:
                self._set_owner(parameter.target, inner)
            self.visit(loop.function.body, inner)
            return
        for item in node.items:
            if type(item) is ast.Define:
                self._set_owner(item.target, region)
        _mark_safe(node)
        for item in node.items:
            self.visit(item.value if type(item) is ast.Define else item, region)


def _body_of(node: Any) -> Sequence[Any]:
    """Return the body of the function of a form, if it is written there, so that nothing else calls it."""
    return (node.function.body,) if type(node.function) is ast.Lambda else ()


# The expressions whose values a form converts to parts, and which nothing else sees.
_CONSUMED: dict[type, Callable[[Any], Sequence[Any]]] = {
    ast.Union: lambda n: n.members,
    ast.Transform: lambda n: (n.part,),
    ast.For: lambda n: (n.body,) if n.kind == "union" else (),
    ast.UnionLoop: _body_of,
    ast.Bind: _body_of,
}


def _mark_safe(node: ast.Body) -> None:
    """Clear ``recursive`` of variables that are certain to have a value at every use.

    Function definitions at the start of a body run no code before all of them are evaluated. A variable that is not
    mentioned before the end of its definition can only be used after it.
    """
    mentioned: set[Any] = set()
    leading = True
    for item in node.items:
        if type(item) is not ast.Define:
            leading = False
            mentioned.update(n.target for n in walk(item) if type(n) is ast.Reference)
            continue
        leading = leading and type(item.value) is ast.Lambda
        if not leading:
            mentioned.update(n.target for n in walk(item.value) if type(n) is ast.Reference)
        for variable in pattern_variables(item.target):
            if leading or variable not in mentioned:
                variable.recursive = False


TailCalls = Counter[tuple[Variable, int]]  # by variable and number of arguments


class _Loops:
    """Finds loops. Results are cached, because a loop in tail position is found while its enclosing loop is."""

    def __init__(self, form: Any) -> None:
        self._form = form
        self._loops: dict[int, Loop | None] = {}  # by id of the Body
        self._calls: dict[int, TailCalls] = {}  # of loops, by their nodes, until the enclosing loop takes them

    @cached_property
    def _uses(self) -> Counter[Variable]:
        """How often each variable is read in the form: a local one only in its scope."""
        targets = (node.target for node in walk(self._form) if type(node) is ast.Reference)
        return Counter(target for target in targets if isinstance(target, Variable))

    def find(self, node: ast.Body) -> Loop | None:
        """Return the loop if ``node`` has the form ``(letrec ((name (lambda ...))) (name start ...))``, else None."""
        if id(node) not in self._loops:
            self._loops[id(node)] = self._loop(node)
        return self._loops[id(node)]

    def _loop(self, node: ast.Body) -> Loop | None:
        """Return the loop of a body, if all uses of its function are the start and tail calls with all arguments."""
        if len(node.items) != 2:
            return None
        definition, start = node.items
        if type(definition) is not ast.Define or type(start) is not ast.Application:
            return None
        variable, function = definition.target, definition.value
        if type(function) is not ast.Lambda or not isinstance(variable, Variable) or variable.is_global:
            return None
        is_plain = all(p.kind == "required" and p.type is None for p in function.parameters)
        if type(start.function) is not ast.Reference or start.function.target is not variable:
            return None
        if not is_plain or len(start.arguments) != len(function.parameters) or variable.assigned:
            return None
        uses = self._uses[variable] - 1  # without the call that starts the loop
        calls = self._tail_calls(function.body)
        if uses != calls.pop((variable, len(function.parameters)), 0):
            return None
        self._calls[id(node)] = calls
        return Loop(variable, function, start)

    def _tail_calls(self, body: Any) -> TailCalls:
        """Count the tail calls of each variable in ``body``.

        The smaller count is added to the larger one, so that nested loops do not take quadratic time.
        """
        counts: TailCalls = Counter()
        stack = [body]
        while stack:
            node = stack.pop()
            kind = type(node)
            if kind is ast.Application:
                head = node.function
                if type(head) is ast.Reference and isinstance(head.target, Variable):
                    counts[head.target, len(node.arguments)] += 1
            elif kind is ast.If:
                stack.append(node.then)
                if node.otherwise is not None:
                    stack.append(node.otherwise)
            elif kind is ast.Body:
                if self.find(node) is None:
                    stack.append(node.items[-1])
                    continue
                inner = self._calls.pop(id(node))
                smaller, counts = sorted((counts, inner), key=len)
                counts.update(smaller)
            elif kind in (ast.And, ast.Or) and node.items:
                stack.append(node.items[-1])
        return counts


# --- kinds of loop variables, for the generator of functions ----------------------------------------------------------

# Integers of fewer bits are added and multiplied without a check of their size: a few operations on them cannot reach
# the limit of the language, and a Float holds them (its largest exponent is 1023).
MAX_BITS = 1_000
_TURN_BITS = 65  # by which fewer than 2^64 sums with bounded numbers can lengthen an Integer


def arithmetic_kind(name: str, left: Kind, right: Kind) -> Kind:
    """Return the kind of a sum, difference or product (``add``, ``sub`` or ``mul``) of values of two kinds."""
    if left.tag == right.tag == "Integer":
        if not (left.bits and right.bits):
            return INTEGER
        bits = left.bits + right.bits if name == "mul" else max(left.bits, right.bits) + 1
        return integer_of(bits if bits <= MAX_BITS else 0)
    if is_number(left) and is_number(right):
        return FLOAT if "Float" in (left.tag, right.tag) else NUMBER
    return ANY


def tail_nodes(root: Any, loops: dict[int, Loop]) -> Iterator[Any]:
    """Iterate over the nodes in tail position, except those in loops."""
    stack = [root]
    while stack:
        node = stack.pop()
        kind = type(node)
        if kind is ast.If:
            stack.append(node.then)
            if node.otherwise is not None:
                stack.append(node.otherwise)
        elif kind is ast.Body:
            if id(node) not in loops:
                stack.append(node.items[-1])
        elif kind in (ast.And, ast.Or) and node.items:
            stack.append(node.items[-1])
        else:
            yield node


class LoopKinds:
    """Inference of the kinds of a loop's parameters, from their first values and all continuations of the loop.

    An iteration to a fixpoint finds the tags. The bits of an Integer are then bounded where every continuation adds a
    number whose bits are bounded, because a loop has fewer than 2^64 turns.
    """

    def __init__(self, outer: Callable[[Variable], Kind]) -> None:
        self.outer = outer  # returns the kind of a variable that is bound outside the loop
        self.known: dict[Variable, Kind] = {}

    def loop(self, loop: Loop, starts: Sequence[Kind]) -> list[Kind]:
        """Return the kinds of the parameters; ``starts`` are those of their first values."""
        parameters = [p.target for p in loop.function.parameters]
        turns = _continuations(loop)
        types = [without_bits(k) if not p.assigned else ANY for p, k in zip(parameters, starts)]
        for _ in range(len(parameters) + 2):
            self.known.update(zip(parameters, types))
            wider = [
                join_all([kind, *(without_bits(self.kind(arguments[i])) for arguments in turns)])
                for i, kind in enumerate(types)
            ]
            if wider == types:
                break
            types = wider
        else:
            return [ANY] * len(parameters)
        self._bound(parameters, types, starts, turns)
        return [self.known[p] for p in parameters]

    def _bound(
        self,
        parameters: Sequence[Variable],
        types: Sequence[Kind],
        starts: Sequence[Kind],
        turns: list[tuple[Any, ...]],
    ) -> None:
        """Bound the bits of Integer parameters; ``turns`` are the arguments of the continuations.

        A bound of one parameter can give that of another, so each pass may find one more.
        """
        self.known.update(zip(parameters, types))
        for _ in parameters:
            for index, variable in enumerate(parameters):
                kind = self.known[variable]
                if kind.tag != "Integer" or kind.bits or not starts[index].bits:
                    continue
                steps = [self._step(arguments[index], variable) for arguments in turns]
                if all(step > 0 for step in steps):
                    bits = max([starts[index].bits, *steps]) + _TURN_BITS
                    if bits <= MAX_BITS:
                        self.known[variable] = integer_of(bits)

    def _step(self, node: Any, variable: Variable) -> int:
        """Return a bound for the bits by which a continuation changes a variable, or 0 if there is none."""
        if type(node) is ast.Reference and node.target is variable:
            return 1
        if type(node) is ast.Application and type(node.function) is ast.Reference and len(node.arguments) == 2:
            target = node.function.target
            name = target.intrinsic if isinstance(target, Builtin) else None
            left, right = node.arguments
            if name in ("add", "sub") and type(left) is ast.Reference and left.target is variable:
                return self.kind(right).bits
            if name == "add" and type(right) is ast.Reference and right.target is variable:
                return self.kind(left).bits
        return self.kind(node).bits

    def kind(self, node: Any) -> Kind:
        """Return the kind of an expression in the loop; ANY unless it is a constant, variable, choice or arithmetic."""
        kind = type(node)
        if kind is ast.Constant:
            return kind_of_operand(node.value)
        if kind is ast.Reference:
            if node.target in self.known:
                return self.known[node.target]
            return self.outer(node.target) if isinstance(node.target, Variable) else ANY
        if kind is ast.If and node.otherwise is not None:
            return join(self.kind(node.then), self.kind(node.otherwise))
        if kind is ast.Application and type(node.function) is ast.Reference and len(node.arguments) == 2:
            target = node.function.target
            name = target.intrinsic if isinstance(target, Builtin) else None
            if name in ("add", "sub", "mul"):
                return arithmetic_kind(name, self.kind(node.arguments[0]), self.kind(node.arguments[1]))
        return ANY


def _continuations(loop: Loop) -> list[tuple[Any, ...]]:
    """Return the arguments of all continuations of a loop."""
    calls = [node for node in walk(loop.function.body) if type(node) is ast.Application]
    return [
        node.arguments
        for node in calls
        if isinstance(node.function, ast.Reference) and node.function.target is loop.variable
    ]


# --- storage of variables at run time: the slots of a frame, and closures that read and write them --------------------


class FrameLayout:
    """Assignment of variables to the slots of a frame."""

    __slots__ = ("parent", "size", "slots")

    def __init__(self, parent: FrameLayout | None) -> None:
        self.parent = parent
        self.slots: dict[Variable, int] = {}
        self.size = 1

    def add(self, variable: Variable | None) -> int:
        """Allocate a slot for ``variable``, or an anonymous one, and return its index.

        A variable that has a slot keeps it, because code may be compiled again.
        """
        if variable is not None and variable in self.slots:
            return self.slots[variable]
        index = self.size
        self.size += 1
        if variable is not None:
            self.slots[variable] = index
        return index


def enters_library(node: ast.Application) -> bool:
    """Return whether a program calls a library function.

    Such a call is never compiled as a tail call: its frame keeps the place in the program, which errors show.
    """
    target = node.function.target if type(node.function) is ast.Reference else None
    if not isinstance(target, Variable) or not target.is_global or target.span is None:
        return False
    return target.span.source.name.startswith(STD) and not node.span.source.name.startswith(STD)


def undefined(rt: Runtime, name: str, span: Span) -> SceneError:
    """Return the error for a variable ``name`` that is read at ``span``, before its definition.

    The current call is marked as not shareable, because its result would change once the variable is defined.
    """
    rt.drew_random = True
    return SceneError("undefined-yet", f"`{name}` is used before its definition", None, span)


def slot_reader(depth: int, slot: int) -> Node:
    """Return a closure that reads a slot ``depth`` frames outward; the common depths avoid a loop."""
    if depth == 0:
        return lambda frame: frame[slot]
    if depth == 1:
        return lambda frame: frame[0][slot]
    if depth == 2:
        return lambda frame: frame[0][0][slot]

    def read(frame: Frame) -> Any:
        for _ in range(depth):
            frame = frame[0]
        return frame[slot]

    return read


def slot_writer(depth: int, slot: int) -> Any:
    """Return ``write(frame, value)`` for a slot ``depth`` frames outward."""
    if depth == 0:

        def write_here(frame: Frame, value: Any) -> None:
            frame[slot] = value

        return write_here

    def write(frame: Frame, value: Any) -> None:
        for _ in range(depth):
            frame = frame[0]
        frame[slot] = value

    return write


def cell_reader(rt: Runtime, find: Node, name: str, span: Span) -> Node:
    """Return a closure that reads a variable from the cell that ``find`` returns.

    A cell that is older than the current call is recorded as read, so that the call is not shared after it changes.
    """

    def read(frame: Frame) -> Any:
        cell = find(frame)
        if cell.birth < rt.serial:
            rt.read(cell)
        value = cell.value
        if value is UNDEFINED:
            raise undefined(rt, name, span)
        return value

    return read


def checked_reader(rt: Runtime, find: Node, name: str, span: Span) -> Node:
    """Return a closure that reads a variable, and raises ``undefined-yet`` if it has no value yet."""

    def read(frame: Frame) -> Any:
        value = find(frame)
        if value is UNDEFINED:
            raise undefined(rt, name, span)
        return value

    return read
