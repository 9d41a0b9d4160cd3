"""Inference of kinds by abstract interpretation of the core AST, one top-level form at a time.

Each expression is given a kind that contains every value it can have. Assigned variables, parameters without a type,
and everything that another file or a loop can change have the kind ANY, so that nothing is concluded from them. An
expression with a reported mistake has the kind ANY too, so that one mistake gives one finding.

A finding is an error if its expression fails whenever it is evaluated. After a test that can be false it is a warning,
and inside the body of a ``guard`` it is not reported.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

from scenelang.grammar import ast
from scenelang.grammar.datum import Span, dataclass, field
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import piece_at
from scenelang.interpreter.checker import calls, scene_forms, truths
from scenelang.interpreter.checker.common import accepts, kind_of_type, may_be_parts, name_of, number_of
from scenelang.interpreter.compile.analyze import called_builtin, pattern_variables, walk
from scenelang.interpreter.compile.kinds import (
    ANY,
    ARRAY,
    BOOLEAN,
    EMBEDDING,
    EMPTY,
    ENTITY,
    HANDLES,
    INTEGER,
    LIST,
    MATRIX,
    MAX_ITEMS,
    NEVER,
    NONE,
    NUMERIC,
    PARTS,
    SET,
    TABLE,
    Kind,
    describe,
    is_number,
    item_of,
    join,
    join_all,
    kind_of_value,
    length_of,
    list_of,
    list_with,
    union_of,
    vector_of,
    without_falsy,
)
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.procedures import MAKE_RECORD
from scenelang.interpreter.runtime.types import Builtin

_MAX_DEPTH = 400  # levels of nested expressions; deeper ones have the kind ANY


_MAX_COMPUTED = 60  # characters of an arithmetic expression that is computed; longer ones are rarely constants
_ARITHMETIC: dict[str | None, Callable[[float, float], float]] = {
    "+": float.__add__,
    "-": float.__sub__,
    "*": float.__mul__,
    "/": lambda a, b: a / b if b else math.nan,
}


class World(Protocol):
    """Global variables and words that a form can refer to."""

    def kind_of(self, variable: Variable) -> Kind:
        """Return the kind of a global variable."""

    def word_function(self, word: str) -> ast.Lambda | None:
        """Return the function of a word that is bound exactly once and never in a body; None if it is not certain."""

    def may_be_bound(self, word: str) -> bool:
        """Return whether the program may bind a word."""

    def is_assigned(self, variable: Variable) -> bool:
        """Return whether a global variable is changed by ``set!``."""

    def is_later(self, variable: Variable) -> bool:
        """Return whether a global variable is defined by a form that runs after this one."""

    def constant_of(self, variable: Variable) -> float | None:
        """Return the number that a global variable is defined as and always has."""

    def array_of(self, variable: Variable) -> ast.ArrayLiteral | None:
        """Return the array literal that a global variable is defined as and always has."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordCode:
    """Procedure of a record type.

    Attributes
    ----------
    name, record
        Names of the procedure and of the record type.
    role
        What it does: "new", "test", "get" or "set".
    fields
        Fields in the order of the constructor's parameters, those without a default first.
    required
        Fields without a default.
    types
        Types of the fields.
    """

    name: str
    record: str
    role: str
    fields: tuple[str, ...] = ()
    required: frozenset[str] = frozenset()
    types: tuple[Any, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Need:
    """Use of a parameter in the body of its function that every call of the function reaches.

    Attributes
    ----------
    place
        Description of the use in messages, such as "called here".
    span
        Location of the use.
    types
        Types that it accepts, any of them.
    expected
        Description of these types.
    error
        Name of the diagnostic of a run that fails.
    passed
        Parameter of another function to which the value is passed unchanged.
    """

    place: str
    span: Span
    types: tuple[Any, ...] = ()
    expected: str = ""
    error: str = "type"
    passed: Variable | None = None
    count: int | None = None  # of the arguments with which a function is called
    rejects: frozenset[str] = frozenset()  # tags of kinds that fail
    fails: Callable[[float], bool] | None = None  # whether a number fails


@dataclass(frozen=True, slots=True, eq=False)
class Passed:
    """Argument of a known kind for a parameter without a type.

    Attributes
    ----------
    parameter
        The parameter.
    owner, usage
        Name and parameter list of its function, for messages.
    argument, kind
        Expression that is passed, and its kind.
    call
        The call.
    is_certain
        Whether the call is certainly evaluated.
    number
        Value of the argument, if it is a number that is known.
    """

    parameter: Variable
    owner: str
    argument: Any
    kind: Kind
    call: Any
    is_certain: bool
    usage: str
    number: float | None = None


@dataclass(slots=True)
class FormKinds:
    """Result of the inference of one top-level form.

    Attributes
    ----------
    kinds
        Kind of each expression.
    findings
        Errors and warnings.
    failing
        The expressions that always fail, with the names of their diagnostics.
    defined
        Kinds of the variables that the form defines.
    always_calls
        Calls that a function makes whenever it is called: caller, callee and the location of the call.
    needs
        Uses of parameters that every call of their function reaches.
    passed
        Arguments of calls that must meet the needs of a parameter.
    """

    kinds: dict[Any, Kind] = field(default_factory=dict)
    findings: list[Diagnostic] = field(default_factory=list)
    failing: list[tuple[Any, str]] = field(default_factory=list)
    defined: dict[Variable, Kind] = field(default_factory=dict)
    always_calls: list[tuple[ast.Lambda, ast.Lambda, Span]] = field(default_factory=list)
    needs: dict[Variable, list[Need]] = field(default_factory=dict)
    passed: list[Passed] = field(default_factory=list)


class KindInference:
    """Inference of one form."""

    def __init__(self, world: World) -> None:
        """Start with an empty environment; ``world`` answers for everything outside the form."""
        self.world = world
        self.result = FormKinds()
        self.env: dict[Variable, Kind] = {}
        self.is_certain = True
        self.is_guarded = False  # inside the body of a ``guard``, where failures are expected
        self.nodes: list[Any] = []  # the enclosing expressions, and last the one being inferred
        self.narrowed: set[Variable] = set()  # variables whose kind a test may have narrowed
        self.caller: ast.Lambda | None = None  # the enclosing function
        self.is_reached = True  # whether every call of the enclosing function reaches this expression
        self.exits = 0  # number of earlier calls that may leave the enclosing function
        self.may_escape = False  # whether an earlier call of a program's function may call an escape procedure
        self.pending: frozenset[Variable] = frozenset()  # variables of the enclosing bodies that are not defined yet
        self.runs_now = True  # whether the form itself runs this code, not a call of a function
        self.numbers: dict[Variable, float] = {}  # local variables that are defined as a number
        self.loops: dict[Variable, Any] = {}  # indices of loops, with the expression whose items they are
        self.arrays: dict[Variable, ast.ArrayLiteral] = {}  # local variables that are defined as an array

    # --- findings ----------------------------------------------------------------------------------------------

    def report(
        self,
        name: str,
        message: str,
        span: Span,
        hint: str | None = None,
        *,
        fixes: tuple[Fix, ...] = (),
        always: bool = True,
        expected: str | None = None,
        found: str | None = None,
        signature: str | None = None,
        near: Sequence[str] = (),
    ) -> Kind:
        """Report a mistake in the current expression and return ANY.

        Parameters
        ----------
        name
            Name of the diagnostic; it becomes a conditional failure in code that may not run.
        message, hint
            What is wrong, and what to do.
        span
            Location in the text.
        fixes
            Edits that correct the mistake; dropped in the expansion of a macro.
        always
            Whether every evaluation of the expression fails.
        expected, found, signature, near
            Fields of the diagnostic for programs that read it.
        """
        if self.is_guarded:
            return ANY
        if not (self.is_certain and always):
            name = "conditional-failure"
        if span.expansion is not None:
            fixes = ()
        self.result.failing.append((self.nodes[-1], name))
        self.result.findings.append(
            Diagnostic(
                name, message, span, hint, fixes=fixes, expected=expected, found=found, signature=signature,
                near=tuple(near),
            )
        )  # fmt: skip
        return ANY

    def warn(
        self,
        name: str,
        message: str,
        span: Span,
        hint: str | None = None,
        fixes: tuple[Fix, ...] = (),
        *,
        expected: str | None = None,
        found: str | None = None,
    ) -> None:
        """Add a warning, which does not change the kind of the expression.

        The parameters are those of ``report``.
        """
        self.result.findings.append(Diagnostic(name, message, span, hint, fixes=fixes, expected=expected, found=found))

    @contextmanager
    def uncertain(self, *tests: Any) -> Iterator[None]:
        """Context of code that may not run; variables that ``tests`` mention may have a narrower kind in it."""
        before, narrowed, reached, exits = self.is_certain, self.narrowed, self.is_reached, self.exits
        self.is_certain = self.is_reached = False
        if tests:
            mentioned = {node.target for node in walk(*tests) if type(node) is ast.Reference}
            self.narrowed = narrowed | {target for target in mentioned if isinstance(target, Variable)}
        try:
            yield
        finally:
            self.is_certain, self.narrowed, self.is_reached = before, narrowed, reached and exits == self.exits

    # --- expressions -------------------------------------------------------------------------------------------

    def infer(self, node: Any) -> Kind:
        """Return the kind of an expression, and record it."""
        nodes = self.nodes
        nodes.append(node)
        kind = _HANDLERS[type(node)](self, node) if len(nodes) < _MAX_DEPTH else ANY
        nodes.pop()
        self.result.kinds[node] = kind
        return kind

    def infer_all(self, nodes: Sequence[Any]) -> list[Kind]:
        """Return the kinds of expressions that are evaluated one after another."""
        return [self.infer(node) for node in nodes]

    def variable(self, variable: Variable) -> Kind:
        """Return the kind of a variable's value where it is read."""
        known = self.world.kind_of(variable) if variable.is_global else ANY  # always read, so that an edit is noticed
        if self.is_assigned(variable) or variable in self.narrowed:
            return ANY
        return self.env.get(variable, known)

    def is_assigned(self, variable: Variable) -> bool:
        """Return whether a variable is changed by ``set!``, so that its value is unknown."""
        return variable.assigned and (not variable.is_global or self.world.is_assigned(variable))

    def bind(self, target: Any, kind: Kind, span: Span) -> None:
        """Record the kind of a value for the variable that it is bound to; pass its items to a destructuring pattern.

        ``target`` is a variable, a pattern or None, ``span`` the location of the definition.
        """
        if isinstance(target, Variable):
            self.env[target] = kind
        elif isinstance(target, tuple):
            self._take_apart(target, kind, span)

    def number_of(self, node: Any) -> float | None:
        """Return the number that an expression always has: a literal, or a variable that is defined as one."""
        if type(node) is ast.Reference and isinstance(node.target, Variable) and not self.is_assigned(node.target):
            if node.target.is_global:
                return self.world.constant_of(node.target)
            return self.numbers.get(node.target)
        if called_builtin(node) in _ARITHMETIC and len(node.arguments) == 2 and len(node.span.text) < _MAX_COMPUTED:
            return self._computed(node)
        return number_of(node)

    def array_of(self, node: Any) -> ast.ArrayLiteral | None:
        """Return the array that a variable always has, if its definition shows it."""
        if type(node) is not ast.Reference or not isinstance(node.target, Variable) or self.is_assigned(node.target):
            return None
        if node.target.is_global:
            return self.world.array_of(node.target)
        return self.arrays.get(node.target)

    def _computed(self, node: ast.Application) -> float | None:
        """Return the result of arithmetic with two numbers."""
        a, b = map(self.number_of, node.arguments)
        result = _ARITHMETIC[called_builtin(node)](a, b) if a is not None and b is not None else math.nan
        return result if math.isfinite(result) else None

    def count_of(self, node: Any) -> int | None:
        """Return the number of turns of a loop over the value of an expression, if that is certain and small."""
        kind = self.result.kinds[node]
        if kind.tag in ("List", "Vector"):
            return length_of(kind)
        number = self.number_of(node) if kind is INTEGER or kind.tag == "Float" else None
        return int(number) if number is not None and number.is_integer() and 0 <= number <= MAX_ITEMS else None

    def _take_apart(self, pattern: tuple[Any, ...], kind: Kind, span: Span) -> None:
        """Bind the variables of a pattern ``(items, rest)``, and check the length of the sequence."""
        items, rest = pattern
        has_rest = rest is not False
        if kind is not ANY and not accepts("Sequence", kind):
            shown = describe(kind)
            self.report("type", f"expected a sequence to take apart, got {shown}", span, expected="a sequence",
                        found=shown)  # fmt: skip
            kind = ANY
        item_kinds = kind.items if kind.tag in ("List", "Vector") else None
        if item_kinds is not None and (len(item_kinds) < len(items) or (len(item_kinds) > len(items) and not has_rest)):
            expected = f"{'at least ' if has_rest else ''}{len(items)} item{'s' * (len(items) != 1)}"
            self.report("pattern", f"the pattern needs {expected}, but the value has {len(item_kinds)}", span,
                        expected=expected, found=f"{len(item_kinds)} items")  # fmt: skip
            item_kinds = None
        item_kind = ANY if kind is ANY or len(kind.options) > 1 else item_of(kind)
        for index, item in enumerate(items):
            self.bind(item, item_kinds[index] if item_kinds is not None else _or_any(item_kind), span)
        if has_rest:
            others = LIST if kind.tag in ("List", "Vector") else ANY  # the second of a pair may be anything
            self.bind(rest, list_of(item_kinds[len(items) :]) if item_kinds is not None else others, span)

    # --- functions ---------------------------------------------------------------------------------------------

    def function(self, node: ast.Lambda, entity_word: bool = False, arguments: Sequence[Kind] | None = None) -> Kind:
        """Infer the body of a function once, and return the kind of the function.

        Parameters
        ----------
        node
            The function.
        entity_word
            Whether it is the function of a word, whose positional parameters are an embedding and a list of embeddings.
        arguments
            Kinds of the arguments, if the function is called once, here; None if it may run later.
        """
        caller, reached, exits, may_escape = self.caller, self.is_reached, self.exits, self.may_escape
        self.caller, self.is_reached, self.may_escape = node, True, False
        pending, runs_now = self.pending, self.runs_now
        if arguments is None:  # the body may run later
            self.pending, self.runs_now = frozenset(), False
        position = 0
        for parameter in node.parameters:
            kind = _kind_of_parameter(parameter, position, entity_word=entity_word)
            if kind is ANY and arguments is not None and position < len(arguments) and parameter.kind == "required":
                kind = arguments[position]
            if parameter.kind in ("required", "optional"):
                position += 1
            if parameter.default is not None:
                with self.uncertain():
                    default = self.infer(parameter.default)
                    self._pass_default(node, parameter, default)
            if isinstance(parameter.target, Variable):
                self.env[parameter.target] = kind
            elif parameter.target is not None:
                for variable in pattern_variables(parameter.target):
                    self.env[variable] = ANY
        result = self.infer(node.body)
        self.caller, self.is_reached, self.exits, self.may_escape = caller, reached, exits, may_escape
        self.pending, self.runs_now = pending, runs_now
        return Kind("Function", None, result, node)

    def _pass_default(self, function: ast.Lambda, parameter: ast.Parameter, kind: Kind) -> None:
        """Record a default as an argument that is not always passed."""
        target = parameter.target
        if not isinstance(target, Variable) or target.assigned or kind is ANY or kind is NEVER or kind.tag == "None":
            return
        if parameter.type is None:
            self.result.passed.append(
                Passed(
                    target, name_of(function), parameter.default, kind, parameter.default, False, function.usage,
                    self.number_of(parameter.default),
                )
            )  # fmt: skip

    def note_call(self, callee: Any, span: Span) -> None:
        """Record a call that the enclosing function always makes; after a call that may escape, there are none."""
        if isinstance(callee, ast.Lambda):
            if self.is_reached and self.caller is not None:
                self.result.always_calls.append((self.caller, callee, span))
        elif callee is None or isinstance(callee, str):
            self.is_reached = False
            self.exits += 1

    def need(
        self,
        node: Any,
        place: str,
        types: tuple[Any, ...],
        expected: str,
        error: str = "type",
        count: int | None = None,
        rejects: frozenset[str] = frozenset(),
        fails: Callable[[float], bool] | None = None,
    ) -> None:
        """Record a requirement on ``node``, if it is a parameter of the enclosing function.

        Parameters
        ----------
        place
            The use in the function's body, for the note of a finding: "passed to `sqrt`".
        types
            Accepted types of the registry; empty if only ``rejects`` or ``fails`` decide.
        expected
            Required value, for error messages.
        error
            Name of the diagnostic.
        count
            Number of arguments with which a function is called.
        rejects
            Tags of kinds that fail.
        fails
            Whether a number fails.
        """
        parameter = self._parameter(node)
        if parameter is not None:
            self.result.needs.setdefault(parameter, []).append(
                Need(place, node.span, types, expected, error, count=count, rejects=rejects, fails=fails)
            )

    def need_numbers(self, array: ast.ArrayLiteral, place: str) -> None:
        """Record that the items of an array are numbers, not rows."""
        for item in array.items:
            if self.result.kinds[item] is ANY:
                self.need(item, place, ("Number",), "a number")

    def pass_argument(self, parameter: ast.Parameter, owner: str, argument: Any, usage: str) -> None:
        """Record the argument of a call for a parameter without a type.

        Parameters
        ----------
        parameter
            The parameter.
        owner, usage
            Name and parameter list of its function, for messages.
        argument
            Expression that is passed.
        """
        target, kind = parameter.target, self.result.kinds[argument]
        if not isinstance(target, Variable) or target.assigned or self.is_guarded:
            return
        if kind is ANY:
            reader = self._parameter(argument)
            if reader is not None:
                self.result.needs.setdefault(reader, []).append(Need(owner, argument.span, passed=target))
        elif kind is not NEVER:
            call = self.nodes[-1]
            number = self.number_of(argument)
            self.result.passed.append(Passed(target, owner, argument, kind, call, self.is_certain, usage, number))

    def _parameter(self, node: Any) -> Variable | None:
        """Return the parameter of the enclosing function that ``node`` reads, if every call reaches this expression."""
        if type(node) is not ast.Reference or self.caller is None or self.is_guarded:
            return None
        if not (self.is_certain and self.is_reached) or self.may_escape:
            return None
        target = node.target
        if not isinstance(target, Variable) or target.assigned or target in self.narrowed:
            return None
        return target if any(target is parameter.target for parameter in self.caller.parameters) else None

    # --- loops -------------------------------------------------------------------------------------------------

    def items(self, node: Any, kind: Kind) -> Kind:
        """Return the kind of the items over which a ``for`` clause iterates; report a value that is not iterable."""
        if kind is ANY:
            self.need(node, "iterated over", ("Integer", "Sequence"), "a sequence")
        if kind is ANY or kind is NEVER:
            return ANY
        item = NEVER
        for option in kind.options:
            if option.tag == "Integer":
                item = join(item, INTEGER)
            elif accepts("Sequence", option) and option.tag not in ("Entity", "Handles"):
                item = join(item, _or_any(item_of(option)))
        if item is NEVER and not any(option.tag in ("Integer", "List") for option in kind.options):
            shown = describe(kind)
            hint = None
            if kind is ENTITY:
                hint = "the list of its parts is `(cdr entity)`"
            elif kind.tag == "Float":
                hint = "iterate over an Integer: `(round n)`, `(floor n)`"
            elif kind is HANDLES:
                hint = "take a finite part: `(list-head gamma n)`"
            return self.report("type", f"expected a sequence to iterate over, got {shown}", node.span, hint,
                               expected="a sequence", found=shown)  # fmt: skip
        return _or_any(item)

    # --- parts -------------------------------------------------------------------------------------------------

    def check_parts(self, node: Any, kind: Kind, place: str) -> None:
        """Report a value that cannot be parts of an entity.

        Parameters
        ----------
        node, kind
            Expression, and its kind.
        place
            Form that expects parts, at the start of the message.
        """
        if kind is ANY:
            self.need(node, f"a part of {place}", ("Parts",), "an entity", "parts")
        self.check_certain_parts(node, kind, place)

    def check_certain_parts(self, node: Any, kind: Kind, place: str) -> None:
        """Report a value whose kind excludes parts, always or in some cases."""
        if not may_be_parts(kind):
            scene_forms.report_parts(self, node, kind, place)
        elif scene_forms.are_no_parts(kind):
            scene_forms.report_parts(self, node, kind, place, always=False)
        else:
            scene_forms.report_missing_branch(self, node, kind, place)


def _or_any(kind: Kind) -> Kind:
    """Return ANY for NEVER, which items of an empty sequence have."""
    return ANY if kind is NEVER else kind


def _kind_of_parameter(parameter: ast.Parameter, position: int, *, entity_word: bool) -> Kind:
    """Return the kind of a parameter; the first one of a word's function holds the embedding."""
    if parameter.type is not None:
        return kind_of_type(parameter.type.name) if parameter.kind != "rest" else LIST
    if parameter.kind == "rest":
        return ANY if entity_word else LIST
    if parameter.kind == "keys":
        return TABLE
    if entity_word and parameter.kind == "required" and position == 0:
        return EMBEDDING
    return ANY


# --- handlers of nodes ---------------------------------------------------------------------------------------------
#
# One function for each node of the core AST, in the order of ``_HANDLERS``.


def _constant(inference: KindInference, node: ast.Constant) -> Kind:
    if node.value is None and _ATOM.fullmatch(node.span.text):
        return ANY  # the reader returns `none` for an atom that it cannot read
    return kind_of_value(node.value)


_ATOM = lazy_pattern(r"(?!none$|None$)[^\s()\[\]]+")


def _handle(inference: KindInference, node: ast.HandleLiteral) -> Kind:
    return EMBEDDING


def _reference(inference: KindInference, node: ast.Reference) -> Kind:
    target = node.target
    if isinstance(target, Builtin):
        return calls.function_of(target)
    if not isinstance(target, Variable):
        return ANY
    if target in inference.pending or (target.is_global and inference.runs_now and inference.world.is_later(target)):
        if target.hides is not None and target.span is not None and target.hides.span is not None:
            return _report_hidden(inference, target, target.span, target.hides.span)
        message = f"`{target.name}` is used before its definition"
        return inference.report("undefined-yet", message, node.span, "move its definition above this use")
    return inference.variable(target)


def _report_hidden(inference: KindInference, variable: Variable, span: Span, hidden: Span) -> Kind:
    """Report a variable of a body that hides one outside, which was meant: a definition does not change a variable."""
    line = hidden.source.position(hidden.start)[0]
    message = f"this `define` makes a new `{variable.name}` and does not change the `{variable.name}` of line {line}"
    text = span.source.text
    start = text.rfind("(", 0, span.start)
    form = text[slice(*piece_at(text, start))] if start >= 0 else ""
    fixes: tuple[Fix, ...] = ()
    hint = "give it another name, or define it before its first use"
    if re.match(r"\(define\s", form) is not None and span.expansion is None:
        written = f"(set!{form.removeprefix('(define')}"
        hint = f"a variable is changed by `{written}`" if "\n" not in form else "a variable is changed by `set!`"
        fixes = (Fix("Change the variable", (Edit(Span(span.source, start, start + len("(define")), "(set!"),)),)
    return inference.report("undefined-yet", message, span, hint, fixes=fixes)


def _assignment(inference: KindInference, node: ast.Assignment) -> Kind:
    inference.infer(node.value)
    return NONE


def _if(inference: KindInference, node: ast.If) -> Kind:
    """Infer a conditional: the kind of either branch, or of the one that a constant test chooses."""
    truths.check_test(inference, node.test, inference.infer(node.test))
    if type(node.test) is ast.Constant:
        return _branch_of_constant(inference, node, node.test)
    with inference.uncertain(node.test):
        then = inference.infer(node.then)
        otherwise = inference.infer(node.otherwise) if node.otherwise is not None else NONE
    return join(then, otherwise)


def _branch_of_constant(inference: KindInference, node: ast.If, test: ast.Constant) -> Kind:
    """Infer a conditional with a constant test; the branch that never runs is checked for its own mistakes only."""
    taken, excluded = (node.then, node.otherwise) if _truth(test.value) else (node.otherwise, node.then)
    if excluded is not None:
        with inference.uncertain(test):
            inference.infer(excluded)
    return NONE if taken is None else inference.infer(taken)


def _truth(value: Any) -> bool:
    """Return whether a value is true: all but ``#f`` and ``none`` are."""
    return value is not False and value is not None


def _and(inference: KindInference, node: ast.And) -> Kind:
    if not node.items:
        return BOOLEAN
    kinds = _tests(inference, node.items)
    falsy = [_falsy(kind) for kind in kinds[:-1]]
    return join_all([*falsy, kinds[-1]])


def _falsy(kind: Kind) -> Kind:
    """Return the kind of a value that failed a test."""
    if kind is ANY:
        return union_of((BOOLEAN, NONE))
    return union_of(option for option in kind.options if option.tag in ("Boolean", "None"))


def _or(inference: KindInference, node: ast.Or) -> Kind:
    if not node.items:
        return BOOLEAN
    kinds = _tests(inference, node.items)
    return join_all([*map(without_falsy, kinds[:-1]), kinds[-1]])


def _tests(inference: KindInference, items: Sequence[Any]) -> list[Kind]:
    """Return the kinds of the items of ``and`` or ``or``, each of which runs after tests of those before."""
    kinds = [inference.infer(items[0])]
    for index, item in enumerate(items[1:], 1):
        with inference.uncertain(*items[:index]):
            kinds.append(inference.infer(item))
    return kinds


def _lambda(inference: KindInference, node: ast.Lambda) -> Kind:
    return inference.function(node)


def _define(inference: KindInference, node: ast.Define) -> Kind:
    """Infer a definition; a function is bound before its body is inferred, since it may call itself."""
    value = node.value
    if isinstance(node.target, Variable) and type(value) is ast.Lambda:
        inference.env[node.target] = Kind("Function", None, ANY, value)
    kind = inference.infer(value)
    record = _record(node)
    if record is not None:
        inference.env.update(record)
    else:
        inference.bind(node.target, kind, value.span)
        number = inference.number_of(value)
        if isinstance(node.target, Variable) and not node.target.assigned:
            if number is not None:
                inference.numbers[node.target] = number
            elif type(value) is ast.ArrayLiteral:
                inference.arrays[node.target] = value
    return NONE


def _record(node: ast.Define) -> dict[Variable, Kind] | None:
    """Return the kinds of the procedures of a ``define-record``; None for any other definition."""
    value = node.value
    if not (type(value) is ast.Application and type(value.function) is ast.Reference):
        return None
    if value.function.target is not MAKE_RECORD or type(value.arguments[0]) is not ast.Constant:
        return None
    name, fields, types = value.arguments[0].value
    defaults = value.arguments[1:]
    required = frozenset(
        field for field, default in zip(fields, defaults) if type(default) is ast.Constant and default.value is False
    )
    variables = list(node.target[0])
    codes = [
        RecordCode(name, name, "new", fields, required, types),
        RecordCode(f"{name}?", name, "test"),
        *(RecordCode(f"{name}-{field}", name, "get") for field in fields),
        *(RecordCode(f"set-{name}-{field}!", name, "set") for field in fields),
    ]
    results = {"new": Kind("Record", code=name), "test": BOOLEAN, "get": ANY, "set": NONE}
    return {
        variable: Kind("Function", None, results[code.role], code)
        for variable, code in zip(variables, codes)
        if isinstance(variable, Variable)
    }


def _body(inference: KindInference, node: ast.Body) -> Kind:
    """Infer the forms of a body in order; forms after one that never returns are unreachable."""
    for item in node.items:  # functions may be called before their definition in the text
        if type(item) is ast.Define and isinstance(item.target, Variable) and type(item.value) is ast.Lambda:
            inference.env.setdefault(item.target, Kind("Function", None, ANY, item.value))
    outside = inference.pending
    later = {v: index for index, item in enumerate(node.items) for v in _defined(item)}
    kind = NONE
    for index, item in enumerate(node.items):
        if later:
            inference.pending = outside | {variable for variable, position in later.items() if position >= index}
        kind = inference.infer(item)
        inference.pending = outside
        if index + 1 < len(node.items):
            following = node.items[index + 1]
            if kind is NEVER:
                _report_unreachable(inference, following)
                return NEVER
            if type(item) is not ast.Define:
                scene_forms.report_dropped(inference, item, kind)
    return kind


def _defined(node: Any) -> Iterator[Variable]:
    """Iterate over the variables that a form of a body defines."""
    if type(node) is ast.Define:
        yield from pattern_variables(node.target)


def _report_unreachable(inference: KindInference, node: Any) -> None:
    if node.span.expansion is None and type(node) is not ast.Constant:
        inference.warn("unreachable-code", "unreachable code: the expression before it never returns", node.span)


def _first(inference: KindInference, node: ast.First) -> Kind:
    return inference.infer_all(node.items)[0]


def _application(inference: KindInference, node: ast.Application) -> Kind:
    """Infer a call, and check it against the function if that is known."""
    function = node.function
    if type(function) is ast.Lambda:
        arguments = inference.infer_all(node.arguments)
        kind = inference.function(function, arguments=arguments)
        inference.result.kinds[function] = kind
        return calls.call(inference, node, kind, arguments)
    kind = inference.infer(function)
    arguments = _infer_arguments(inference, node, kind)
    if kind is ANY and not (type(function) is ast.Reference and getattr(function.target, "shadows", False)):
        count = len(node.arguments) if calls.written_keyword(node.arguments) is None else None
        inference.need(function, "called here", ("Function",), "a Function", "not-a-procedure", count)
    inference.note_call(kind.code, node.span)
    result = calls.call(inference, node, kind, arguments)
    if isinstance(kind.code, Builtin) and kind.code.name == "primitive":
        scene_forms.call_primitive(inference, node)
    if isinstance(kind.code, ast.Lambda) and any(k is ANY or k.tag == "Function" for k in arguments):
        inference.may_escape = True
    if result is NEVER or _calls_back(kind.code):  # such as `raise`; a callback may escape
        inference.note_call(None, node.span)
    return result


def _infer_arguments(inference: KindInference, node: ast.Application, function: Kind) -> list[Kind]:
    """Infer the arguments of a call.

    A ``lambda`` that is passed to a library function which calls it has parameters of the kinds that it is called with.
    """
    infer_callback = _callback_kinds_of(function)
    if infer_callback is None or not any(type(argument) is ast.Lambda for argument in node.arguments):
        return inference.infer_all(node.arguments)
    lambdas = [argument for argument in node.arguments if type(argument) is ast.Lambda]
    inference.infer_all([argument for argument in node.arguments if type(argument) is not ast.Lambda])
    kinds = inference.result.kinds
    callback_kinds = infer_callback(node, kinds)
    for argument in lambdas:
        is_callback = argument is node.arguments[0] or isinstance(function.code, ast.Lambda)
        kind = inference.function(argument, arguments=callback_kinds if is_callback else None)
        kinds[argument] = kind
    return [kinds[argument] for argument in node.arguments]


def _callback_kinds_of(function: Kind) -> Callable[[Any, Any], list[Kind]] | None:
    """Return how to infer the kinds of the arguments that a library function passes to its callback.

    The result takes the call and the kinds of its other arguments, by node. It is None for functions of the program and
    for library functions that do not call the callback before they return.
    """
    code = function.code
    if isinstance(code, Builtin):
        return _CALLBACK_KINDS.get(code.name)
    if not isinstance(code, ast.Lambda) or code.name not in calls.INDICES:
        return None
    # A function of the program may have the same name as one of these combinators, which pass indices of copies.
    if not all(map(calls.is_library_parameter, code.parameters)):
        return None
    return lambda node, kinds: [INTEGER] * calls.INDICES[code.name]


def _items_given(node: ast.Application, kinds: Any) -> list[Kind]:
    """Return the kinds of the items of all sequences."""
    return [calls.item_given(kinds.get(argument, ANY)) for argument in node.arguments[1:]]


def _folded_given(node: ast.Application, kinds: Any) -> list[Kind]:
    """Return the kinds of the items, then of the accumulator."""
    return [*(calls.item_given(kinds.get(argument, ANY)) for argument in node.arguments[2:]), ANY]


def _left_given(node: ast.Application, kinds: Any) -> list[Kind]:
    """Return the kinds of the accumulator, then of the items."""
    return [ANY, *(calls.item_given(kinds.get(argument, ANY)) for argument in node.arguments[2:])]


_CALLBACK_KINDS: dict[str, Callable[[Any, Any], list[Kind]]] = {
    **dict.fromkeys(("map", "for-each", "append-map", "filter-map", "any", "every"), _items_given),
    **dict.fromkeys(("filter", "remove", "partition", "find", "list-index"), _items_given),
    "fold": _folded_given, "fold-left": _left_given, "fold-right": _folded_given,
}  # fmt: skip


def _calls_back(code: Any) -> bool:
    """Return whether a builtin takes functions."""
    if not isinstance(code, Builtin):
        return False
    signature = code.signature
    parameters = (*signature.required, *signature.optional, *signature.keywords)
    return any(parameter.type.name == "Function" for parameter in parameters)


def _array(inference: KindInference, node: ast.ArrayLiteral) -> Kind:
    """Infer an array literal: numbers, or rows of one length."""
    kinds = inference.infer_all(node.items)
    for item, kind in zip(node.items, kinds):
        if kind is ANY:
            types = ("Number",) if any(map(is_number, kinds)) else ("ArrayItem",)
            inference.need(item, "an item of an array", types, "a number")
        elif not accepts("ArrayItem", kind):
            scene_forms.report_array_item(inference, node, item, kind)
            return ANY
        else:
            calls.report_half(inference, item, kind, "Number")
    if not scene_forms.check_rows(inference, node, kinds):
        return ANY
    if any(is_number(kind) for kind in kinds):  # items of other shapes would fail
        return vector_of(len(kinds), all(kind is INTEGER for kind in kinds))
    return union_of((vector_of(len(kinds)), ARRAY, MATRIX))  # of numbers, or of rows


def _while(inference: KindInference, node: ast.While) -> Kind:
    truths.check_test(inference, node.test, inference.infer(node.test))
    always = type(node.test) is ast.Constant and _truth(node.test.value)
    if always:
        inference.infer(node.body)
    else:
        with inference.uncertain(node.test):
            inference.infer(node.body)
    return NONE


def _for(inference: KindInference, node: ast.For) -> Kind:
    """Infer a ``for`` form, whose body may not run and whose accumulators may change their kinds."""
    for accumulator in node.accumulators:
        inference.infer(accumulator.value)
        for variable in pattern_variables(accumulator.target):
            inference.env[variable] = ANY  # its kind may change from one iteration to the next
    certain, narrowed, reached = inference.is_certain, inference.narrowed, inference.is_reached
    exits = inference.exits
    for index, clause in enumerate(node.clauses):
        inference.is_reached = reached and index == 0  # the first sequence is evaluated exactly once
        if clause.kind == "each":
            for target, value in zip(clause.targets, clause.values):
                inference.bind(target, inference.items(value, inference.infer(value)), value.span)
                if isinstance(target, Variable) and inference.env[target] is INTEGER:
                    inference.loops[target] = value
        else:
            inference.infer(clause.values[0])
            inference.is_certain = False
            mentioned = {part.target for part in walk(clause.values[0]) if type(part) is ast.Reference}
            inference.narrowed = inference.narrowed | {t for t in mentioned if isinstance(t, Variable)}
    inference.is_reached = False
    body = inference.infer(node.body)
    is_wrong = False
    if node.kind == "each":
        scene_forms.report_unused_result(inference, value_of(node.body))
    if node.kind == "union":
        inference.check_parts(value_of(node.body), body, "`for/union`")
    elif node.kind in ("append", "sum", "table"):
        is_wrong = not scene_forms.check_collected(inference, node.kind, value_of(node.body), body)
    inference.is_certain, inference.narrowed = certain, narrowed
    inference.is_reached = reached and exits == inference.exits
    if is_wrong:
        return ANY
    if node.kind == "list" and body is not NEVER and len(node.clauses) == 1 and node.clauses[0].kind == "each":
        counts = [inference.count_of(value) for value in node.clauses[0].values]
        if len(counts) == 1 and counts[0] is not None:
            return list_of([body] * counts[0])
    return _result_of_loop(node, body)


def _result_of_loop(node: ast.For, body: Kind) -> Kind:
    """Return the kind of the result of a ``for`` form."""
    if node.kind == "list":
        return list_with(body) if body is not NEVER else LIST
    if node.kind in _LOOP_RESULTS:
        return _LOOP_RESULTS[node.kind]
    return ANY


_LOOP_RESULTS = {"each": NONE, "union": PARTS, "append": LIST, "table": TABLE, "set": SET, "sum": NUMERIC}


def value_of(node: Any) -> Any:
    """Return the expression whose value a body has."""
    while type(node) is ast.Body and node.items and type(node.items[-1]) is not ast.Define:
        node = node.items[-1]
    return node


def _let_escape(inference: KindInference, node: ast.LetEscape) -> Kind:
    inference.env[node.target] = Kind("Function", None, NEVER, "escape")
    inference.infer(node.body)
    return ANY


def _guard(inference: KindInference, node: ast.Guard) -> Kind:
    guarded = inference.is_guarded
    with inference.uncertain():
        inference.is_guarded = True
        body = inference.infer(node.body)
        inference.is_guarded = guarded
        inference.env[node.target] = ANY
        handler = inference.infer(node.handler)
    return join(body, handler)


def _bind(inference: KindInference, node: ast.Bind) -> Kind:
    """Infer ``bind``: the word's function must return parts, or frames if it is the root."""
    word = inference.infer(node.word)
    if not accepts("Word", word):
        scene_forms.report_word(inference, node.word, word, "bind")
    function = node.function
    if type(function) is not ast.Lambda:
        kind = inference.infer(function)
        if not accepts("Function", kind):
            scene_forms.report_bound_value(inference, node, kind)
        return NONE
    kind = inference.function(function, entity_word=True)
    inference.result.kinds[function] = kind
    result = kind.item or ANY
    name = node.word.value if type(node.word) is ast.Constant else None
    place = f'"{name}"' if name else "the word's function"
    if _has_frames(result):
        scene_forms.report_missing_branch(inference, value_of(function.body), result, place)
    else:
        inference.check_certain_parts(value_of(function.body), result, place)
    return NONE


def _has_frames(kind: Kind) -> bool:
    """Return whether a value may be frames."""
    return any(option.tag == "Frames" for option in kind.options)


def _call(inference: KindInference, node: ast.Call) -> Kind:
    word = inference.infer(node.word)
    if word is ANY:
        inference.need(node.word, "called as a word", ("Word",), "a String", "word")
    if type(node.word) is ast.Constant and type(node.word.value) is str:
        function = inference.world.word_function(node.word.value)
        if function is not None:
            inference.note_call(function, node.span)
    return scene_forms.call_word(inference, node, word, inference.infer_all(node.arguments))


def _union(inference: KindInference, node: ast.Union) -> Kind:
    for member in node.members:
        inference.check_parts(value_of(member), inference.infer(member), "`union`")
    return PARTS if node.members else EMPTY


def _union_loop(inference: KindInference, node: ast.UnionLoop) -> Kind:
    """Infer ``union-loop``: a count, and a function of the index that returns parts."""
    count = inference.infer(node.count)
    is_body = count.tag == "Function" or (count is not ANY and count is not NEVER and may_be_parts(count))
    other = inference.infer(node.function) if is_body else ANY
    if is_body and (other.tag == "Integer" or (other is ANY and count.tag == "Function")):
        scene_forms.report_swapped_loop(inference, node)
        return PARTS
    if count is ANY:
        inference.need(node.count, "the count of `union-loop`", ("Integer",), "an Integer")
    if not accepts("Integer", count) or (type(node.count) is ast.Constant and _is_fraction(node.count.value)):
        scene_forms.report_count(inference, node.count, count)
    number = inference.number_of(node.count)
    runs = number is not None and number > 0
    if number is not None and (number < 0 or (number == 0 and type(node.count) is ast.Constant)):
        inference.warn("out-of-range", f"`union-loop` runs {number:g} times, that is never", node.count.span,
                       expected="a positive count", found=f"{number:g}")  # fmt: skip
    if type(node.function) is ast.Lambda:
        if node.function.parameters and count is INTEGER:
            inference.loops[node.function.parameters[0].target] = node.count
        function = inference.function(node.function, arguments=[INTEGER])
        inference.result.kinds[node.function] = function
        if function.item is not None:
            inference.check_parts(value_of(node.function.body), function.item, "`union-loop`")
    else:
        function = inference.infer(node.function)
    if not accepts("Function", function):
        scene_forms.report_loop_body(inference, node, function)
    else:
        calls.check_callback(inference, node.function, function, [INTEGER], "`union-loop`", runs)
    return PARTS


def _is_fraction(value: Any) -> bool:
    """Return whether a value is a Float that is not whole."""
    return type(value) is float and not value.is_integer()


def _transform(inference: KindInference, node: ast.Transform) -> Kind:
    part, matrix = inference.infer(node.part), inference.infer(node.matrix)
    return scene_forms.transform(inference, node, part, matrix)


_HANDLERS: dict[type, Callable[[KindInference, Any], Kind]] = {
    ast.Constant: _constant,
    ast.HandleLiteral: _handle,
    ast.Reference: _reference,
    ast.Assignment: _assignment,
    ast.If: _if,
    ast.And: _and,
    ast.Or: _or,
    ast.Lambda: _lambda,
    ast.Define: _define,
    ast.Body: _body,
    ast.First: _first,
    ast.Application: _application,
    ast.ArrayLiteral: _array,
    ast.While: _while,
    ast.For: _for,
    ast.LetEscape: _let_escape,
    ast.Guard: _guard,
    ast.Bind: _bind,
    ast.Call: _call,
    ast.Union: _union,
    ast.UnionLoop: _union_loop,
    ast.Transform: _transform,
}


def infer_form(world: World, form: Any) -> FormKinds:
    """Infer the kinds of a top-level form."""
    inference = KindInference(world)
    inference.infer(form)
    if type(form) is ast.Application and not form.span.source.name.startswith("<"):  # an input of a session is printed
        scene_forms.report_unused_result(inference, form)
    if type(form) is ast.Define:
        inference.result.defined = {v: inference.env.get(v, ANY) for v in pattern_variables(form.target)}
    return inference.result
