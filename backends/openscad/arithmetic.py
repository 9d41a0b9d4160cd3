"""Values of OpenSCAD as expressions of the Scene Language, with what is known of their kinds.

OpenSCAD has one operator ``*`` for numbers, vectors and matrices, and one kind of list; here arrays and lists differ.
The kinds of parameters and results come from earlier rounds of the conversion (``Facts``), so that `a * b` becomes
``(* a b)`` where both are numbers, and a call of a helper only where that is unknown.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from typing import NamedTuple, Self

from scenelang.backends.openscad.syntax import (
    Argument,
    ConstantValue,
    Each,
    Expr,
    FunctionDefinition,
    FunctionValue,
    ItemAt,
    ItemCondition,
    ItemLoop,
    Items,
    Let,
    ModuleDefinition,
    Operation,
    Range,
    ScadCall,
    ScadCheck,
    ScadParameter,
    VariableName,
    failure,
    unsupported,
)
from scenelang.grammar.datum import Span, dataclass, field
from scenelang.grammar.diagnostics import Diagnostic, suggest
from scenelang.stdlib.colors import named_colors

# --- kinds -----------------------------------------------------------------------------------------------------------


class SnippetKind(NamedTuple):
    """What is known of a value: ``name``, the ``size`` of a vector (0: unknown) and the kind of a list's items."""

    name: str
    size: int = 0
    item: SnippetKind | None = None


UNKNOWN, ANY, INT, NUM, BOOL, STR = (SnippetKind(name) for name in ("unknown", "any", "int", "num", "bool", "str"))
UNDEF, FUNCTION = SnippetKind("undef"), SnippetKind("function")
MAX_SEGMENTS = 1024
LEAST_RESOLUTION = 0.01  # to which OpenSCAD raises smaller `$fa` and `$fs`
_MAX_DEPTH = 4  # of kinds of lists in lists


def vector(size: int) -> SnippetKind:
    """Return the kind of a vector of numbers."""
    return SnippetKind("vec", size, NUM)


def list_of(item: SnippetKind) -> SnippetKind:
    """Return the kind of a list."""
    return SnippetKind("list", 0, item if _depth(item) < _MAX_DEPTH else ANY)


def _depth(kind: SnippetKind) -> int:
    return 0 if kind.item is None else 1 + _depth(kind.item)


def is_number(kind: SnippetKind) -> bool:
    """Return whether a value is a number for certain."""
    return kind.name in ("int", "num")


def is_sequence(kind: SnippetKind) -> bool:
    """Return whether a value is a vector, a matrix or a list."""
    return kind.name in ("vec", "mat", "list")


def joined(a: SnippetKind, b: SnippetKind) -> SnippetKind:
    """Return the kind of a value that may be of either."""
    if a == b or b == UNKNOWN:
        return a
    if a == UNKNOWN:
        return b
    if is_number(a) and is_number(b):
        return NUM
    if is_sequence(a) and is_sequence(b):
        first, second = a.item or ANY, b.item or ANY
        size = a.size if a.size == b.size else 0
        return SnippetKind(a.name, size, joined(first, second)) if a.name == b.name else list_of(joined(first, second))
    return ANY


# --- facts and scopes ------------------------------------------------------------------------------------------------


@dataclass(eq=False)
class Facts:
    """What rounds of the conversion find out; keys are the places of definitions. ``changed`` says whether it grew."""

    kinds: dict[tuple[int, str], SnippetKind] = field(default_factory=dict)
    marks: set[tuple[object, ...]] = field(default_factory=set)
    changed: bool = False

    def kind(self, place: int, name: str) -> SnippetKind:
        return self.kinds.get((place, name), UNKNOWN)

    def join(self, place: int, name: str, kind: SnippetKind) -> None:
        before = self.kind(place, name)
        after = joined(before, kind)
        if after != before:
            self.kinds[place, name] = after
            self.changed = True

    def mark(self, *fact: object) -> None:
        if fact not in self.marks:
            self.marks.add(fact)
            self.changed = True

    def holds(self, *fact: object) -> bool:
        return fact in self.marks

    def all(self, *start: object) -> list[object]:
        """Return the last items of the marks that begin so."""
        return sorted((fact[-1] for fact in self.marks if fact[:-1] == start), key=str)


class Snippet(NamedTuple):
    """Expression of the Scene Language, its kind, and its number if that is fixed."""

    text: str
    kind: SnippetKind
    number: float | None = None
    parts: tuple[Snippet, ...] | None = None  # of a vector that is written out
    string: str | None = None  # that it is, if that is fixed


@dataclass(frozen=True, slots=True, eq=False)
class Definition:
    """Definition of a function or module: its name, and its parameters' names here."""

    definition: FunctionDefinition | ModuleDefinition
    name: str
    names: tuple[str, ...]
    scope: NameScope
    takes_children: bool = False

    @property
    def place(self) -> int:
        return self.definition.span.start


@dataclass(eq=False)
class NameScope:
    """Names that are visible: variables, functions and modules are apart."""

    parent: NameScope | None = None
    variables: dict[str, Snippet] = field(default_factory=dict)
    functions: dict[str, Definition] = field(default_factory=dict)
    modules: dict[str, Definition] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)
    builtins: frozenset[str] = frozenset()  # names that no function or module may get, of the outermost scope

    def variable(self, name: str) -> Snippet | None:
        return self.variables.get(name) or (self.parent.variable(name) if self.parent else None)

    def function(self, name: str) -> Definition | None:
        return self.functions.get(name) or (self.parent.function(name) if self.parent else None)

    def module(self, name: str) -> Definition | None:
        return self.modules.get(name) or (self.parent.module(name) if self.parent else None)

    def is_taken(self, name: str, is_called: bool = False) -> bool:
        if name in self.taken or (is_called and name in self.builtins):
            return True
        return self.parent is not None and self.parent.is_taken(name, is_called)

    def fresh(self, name: str, what: str) -> str:
        """Return a name of the Scene Language for a name of OpenSCAD, unlike those that are visible."""
        base = re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-") or "x"
        base = base if base[0].isalpha() else f"x-{base}"
        endings = ["", f"-{what}", *(f"-{number}" for number in range(2, 10_000))]
        unique = next(base + ending for ending in endings if not self.is_taken(base + ending, what != "value"))
        self.taken.add(unique)
        return unique


class Converter:
    """What all parts of a conversion share: facts, warnings and the helpers that the program needs."""

    def __init__(self, facts: Facts, helpers: Mapping[str, object]) -> None:
        self.facts = facts
        self.known_helpers = helpers
        self.helpers: set[str] = set()
        self.is_waiting = False  # for the dimensions of an object, which a later round may know
        self.warnings: dict[str, Diagnostic] = {}

    def helper(self, name: str) -> str:
        """Return the name of a helper, which the program will define."""
        assert name in self.known_helpers, name
        self.helpers.add(name)
        return name

    def warn(self, span: Span, message: str, hint: str | None = None) -> None:
        """Report once that something is left out or replaced."""
        self.warnings.setdefault(message, Diagnostic("openscad-ignored", message, span, hint))


# --- text ------------------------------------------------------------------------------------------------------------


def number_text(value: float) -> str:
    """Return a number as it is written, whole ones without a fraction."""
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def constant(value: float) -> Snippet:
    """Return the code of a number."""
    if not math.isfinite(value):
        value = math.copysign(1e300, value)
    return Snippet(number_text(value), INT if value == int(value) else NUM, value)


def string_text(value: str) -> str:
    """Return a string as it is written."""
    escapes = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    return '"' + "".join(escapes.get(each, each) for each in value) + '"'


def call(name: str, *operands: str) -> str:
    """Return the text of a call."""
    return f"({' '.join((name, *operands))})"


def with_comments(comments: Sequence[str], text: str) -> str:
    """Return a text below its comments."""
    return "".join(f"; {line}\n" for line in comments) + text


def long_call(name: str, operands: Sequence[str]) -> str:
    """Return a call, with an operand per line if it is long, which the formatter keeps."""
    is_long = sum(map(len, operands)) > 70 and len(operands) > 1
    return f"({name}\n" + "\n".join(operands) + ")" if is_long else call(name, *operands)


def vector_code(parts: Sequence[Snippet]) -> Snippet:
    """Return a vector of numbers, written out."""
    return Snippet(f"[{' '.join(part.text for part in parts)}]", vector(len(parts)), None, tuple(parts))


def fragments_of(radius: float, angle: float, length: float) -> int:
    """Return the number of sides of a circle, from ``$fa`` and ``$fs``."""
    if radius < 1e-6:
        return 5
    angle, length = max(angle, LEAST_RESOLUTION), max(length, LEAST_RESOLUTION)
    return min(MAX_SEGMENTS, math.ceil(max(min(360.0 / angle, radius * math.tau / length), 5)))


def half(value: Snippet) -> str:
    """Return half of a number."""
    if value.number is not None and value.text == number_text(value.number):
        return number_text(value.number / 2)
    return call("/", value.text, "2")


def own_name(special: str) -> str:
    """Return the parameter by which a module gets a special variable that differs from the file's."""
    return f"{re.sub(r'[^A-Za-z0-9]+', '-', special).strip('-')}-here"


def look_of(c: Converter, color: Snippet, alpha: Snippet | None, span: Span) -> str:
    """Return the attributes of a color: nothing of a text that names none."""
    opacity = alpha
    if color.parts is not None and len(color.parts) in (3, 4):
        opacity = alpha or (color.parts[3] if len(color.parts) == 4 else None)
        text = call("rgb", *map(_component, color.parts[:3]))
    elif color.string is not None:
        name, own = _named_color(color.string)
        if not name:
            c.warn(span, f"the color {string_text(color.string)} is unknown, and left out")
            return ""
        opacity = alpha or own
        text = call("color", color.text if name == color.string else f'"{name}"')
    elif color.kind == STR:
        text = call("color", color.text)
    else:
        text = call(c.helper("color-of"), color.text)
    return f":color {text}" + (f" :opacity {opacity.text}" if opacity is not None and opacity.number != 1 else "")


def _component(part: Snippet) -> str:
    if part.number is not None and part.text == number_text(part.number):
        return number_text(round(255 * min(max(part.number, 0.0), 1.0), 6))
    return f"(* 255 {part.text})"


def _named_color(name: str) -> tuple[str, Snippet | None]:
    """Return a color as the Scene Language writes it, empty if it is none, and its opacity if it has one."""
    if name.lower() == "transparent":
        return "black", constant(0)
    if not name.startswith("#"):
        return (name if name.lower() in named_colors() else ""), None
    digits = name[1:]
    if re.fullmatch(r"([0-9a-fA-F]{3,4}){1,2}", digits) is None or len(digits) == 7:
        return "", None
    width = 1 if len(digits) < 6 else 2
    own = digits[3 * width :]
    return f"#{digits[: 3 * width]}", constant(round(int(own, 16) / (16**width - 1), 4)) if own else None


# --- expressions -----------------------------------------------------------------------------------------------------


_ROUNDING = {"floor": "floor", "ceil": "ceiling"}
_DIRECT = {"abs": "abs", "sqrt": "sqrt", "exp": "exp", "ln": "log", "sign": "sign"}
_ANGLES = {"sin", "cos", "tan"}
_INVERSE = {"asin", "acos", "atan"}
_COMPARED = {"<": "<", ">": ">", "<=": "<=", ">=": ">="}
_TESTS = {"is_num": "number?", "is_string": "string?", "is_bool": "boolean?", "is_function": "procedure?"}
_ABSENT_FUNCTIONS = {
    "search": "write a recursive function or a comprehension", "parent_module": None, "dxf_cross": None,
    "dxf_dim": None,
}  # fmt: skip


_MAX_RANDOM = 1_000  # numbers of `rands` that are written out


def random_numbers(low: float, high: float, count: int, seed: int) -> list[float]:
    """Return what `rands` of OpenSCAD does: doubles of libstdc++ from a Mersenne Twister, two words each."""
    from numpy.random import RandomState

    words = RandomState(seed % 2**32)._bit_generator.random_raw(2 * max(0, count))
    return [low + (high - low) * (a + b * 2.0**32) / 2.0**64 for a, b in words.reshape(-1, 2).tolist()]


class Expressions:
    """Converts expressions; ``scope`` and ``specials`` are those of the place where one stands."""

    def __init__(self, converter: Converter, scope: NameScope, specials: Mapping[str, Snippet], owner: int) -> None:
        self.c = converter
        self.scope = scope
        self.specials = dict(specials)
        self.owner = owner  # the place of the module or function that this is inside of; -1 outside

    # --- variables ---------------------------------------------------------------------------------------------------

    def inside(self) -> Self:
        """Return the same place with a scope of its own."""
        inner = copy(self)
        inner.scope, inner.specials = NameScope(self.scope), dict(self.specials)
        return inner

    def bind(self, name: str, kind: SnippetKind, number: float | None = None, string: str | None = None) -> str:
        """Declare a variable; returns its name."""
        unique = self.scope.fresh(name, "value")
        self.scope.variables[name] = Snippet(unique, kind, number, None, string)
        if name.startswith("$"):
            self.specials[name] = Snippet(unique, kind, number)
        return unique

    def special(self, name: str) -> Snippet:
        """Return the value of a variable that modules hand down to those that they call, as ``$fn``."""
        self.c.facts.mark("uses", self.owner, name)
        return self.specials[name]

    def _variable(self, expr: VariableName) -> Snippet:
        """Return the value of a variable; raises SceneError if it is undefined or cannot be converted."""
        name = expr.name
        if name == "$t":
            self.c.facts.mark("moment")
            self.c.warn(expr.span, "`$t` became a param, 0 unless it is given", "give it by `--define moment=.5`")
            return Snippet("moment", NUM)
        if name.startswith("$"):
            if name in self.specials:
                return self.special(name)
            unsupported(expr.span, f"the special variable `{name}` is not set here")
        snippet = self.scope.variable(name)
        if snippet is not None:
            return snippet
        # after the scope, since a file can define `PI` itself
        if name == "PI":
            return Snippet("pi", NUM)
        function = self.scope.function(name)
        if function is not None:
            unsupported(expr.span, f"`{name}` is a function; only `{name} = function (...) ...` is a value")
        near = suggest(name, self._names())
        failure(expr.span, f"the variable `{name}` is not defined here", f"did you mean `{near}`?" if near else None)

    def _names(self) -> list[str]:
        names: list[str] = []
        scope: NameScope | None = self.scope
        while scope is not None:
            names += scope.variables
            scope = scope.parent
        return names

    # --- dispatch ----------------------------------------------------------------------------------------------------

    def code(self, expr: Expr) -> Snippet:
        """Convert an expression."""
        if isinstance(expr, ConstantValue):
            return self._constant(expr)
        if isinstance(expr, VariableName):
            return self._variable(expr)
        if isinstance(expr, Operation):
            return self._operation(expr)
        if isinstance(expr, Items):
            return self._items(expr)
        if isinstance(expr, ScadCall):
            return self._call(expr)
        if isinstance(expr, ItemAt):
            return self._item(expr)
        if isinstance(expr, Range):
            return self._range(expr)
        if isinstance(expr, Let):
            inner, bindings = self.bound(expr.bindings)
            body = inner.code(expr.body)
            return Snippet(f"(let* ({bindings}) {body.text})", body.kind)
        if isinstance(expr, ScadCheck):
            return self._checked(expr)
        if isinstance(expr, FunctionValue):
            inner = self.inside()
            names = [inner.bind(each.name, ANY) for each in expr.parameters]
            return Snippet(f"(lambda ({' '.join(names)}) {inner.code(expr.body).text})", FUNCTION)
        failure(expr.span, "expected a value; `for`, `if` and `each` stand in lists only")

    def text(self, expr: Expr) -> str:
        """Convert an expression to text."""
        return self.code(expr).text

    def bound(self, arguments: Iterable[Argument]) -> tuple[Self, str]:
        """Return the place inside of a `let`, and the text of its bindings."""
        inner, texts = self.inside(), []
        for each in arguments:
            value = inner.code(each.value)
            texts.append(f"({inner.bind(str(each.name), value.kind, value.number)} {value.text})")
        return inner, " ".join(texts)

    def _constant(self, expr: ConstantValue) -> Snippet:
        value = expr.value
        if value is None:
            return Snippet("none", UNDEF)
        if isinstance(value, bool):
            return Snippet("#t" if value else "#f", BOOL)
        return Snippet(string_text(value), STR, string=value) if isinstance(value, str) else constant(value)

    def _checked(self, expr: ScadCheck) -> Snippet:
        body = self.code(expr.body) if expr.body is not None else Snippet("none", UNDEF)
        if not expr.is_assert or not expr.arguments:
            return body
        message = [self.text(each.value) for each in expr.arguments[1:2]]
        return Snippet(
            f"(begin {call('assert', self.condition(expr.arguments[0].value), *message)} {body.text})", body.kind
        )

    # --- operators ---------------------------------------------------------------------------------------------------

    def condition(self, expr: Expr) -> str:
        """Convert a test: 0, "", [] and undef are false in OpenSCAD."""
        return self.truth(self.code(expr))

    def truth(self, code: Snippet) -> str:
        """Return a value as a test."""
        if code.kind in (BOOL, FUNCTION):
            return code.text
        if is_number(code.kind):
            return f"(not (= {code.text} 0))"
        if code.kind == STR or is_sequence(code.kind):
            return f"(not (empty? {code.text}))"
        return call(self.c.helper("true?"), code.text)

    def _operation(self, expr: Operation) -> Snippet:
        operator = expr.operator
        if operator == "?":
            return self._ternary(expr)
        if operator in ("&&", "||"):
            tests = [self.condition(each) for each in expr.operands]
            return Snippet(call("and" if operator == "&&" else "or", *tests), BOOL)
        if operator == "unary !":
            return Snippet(call("not", self.condition(expr.operands[0])), BOOL)
        operands = [self.code(each) for each in expr.operands]
        if operator == "unary -":
            return self.negative(operands[0])
        if operator in ("==", "!="):
            return self._equal(operator, *operands)
        if operator in _COMPARED:
            return Snippet(call(operator, *(each.text for each in operands)), BOOL)
        return self._arithmetic(operator, [self.array(each) for each in operands])

    def _ternary(self, expr: Operation) -> Snippet:
        test, yes, no = expr.operands
        if isinstance(test, VariableName) and test.name == "$preview":
            return self.code(no)
        condition = self.condition(test)
        first, second = self.code(yes), self.code(no)
        if first.kind != second.kind and is_sequence(first.kind) and is_sequence(second.kind):
            first, second = self.array(first), self.array(second)
        return Snippet(call("if", condition, first.text, second.text), joined(first.kind, second.kind))

    def negative(self, value: Snippet) -> Snippet:
        """Return a number or vector with its sign changed."""
        if value.number is not None and value.text == number_text(value.number):
            return constant(-value.number)
        if value.parts is not None:
            return vector_code([self.negative(part) for part in value.parts])
        value = self.array(value)
        return Snippet(call("-", value.text), value.kind)

    def array(self, value: Snippet) -> Snippet:
        """Return a value for arithmetic, which takes arrays and no lists."""
        if value.kind.name != "list":
            return value
        item = value.kind.item or ANY
        return Snippet(call("array", value.text), vector(0) if is_number(item) else SnippetKind("mat", 0, item))

    def _equal(self, operator: str, a: Snippet, b: Snippet) -> Snippet:
        if UNDEF in (a.kind, b.kind):
            text = call("none?", a.text if b.kind == UNDEF else b.text)
        elif is_number(a.kind) and is_number(b.kind):
            text = call("=", a.text, b.text)
        elif (a.kind == b.kind and a.kind in (STR, BOOL)) or STR in (a.kind, b.kind):
            text = call("equal?", a.text, b.text)
        else:
            text = call(self.c.helper("same?"), a.text, b.text)
        return Snippet(text if operator == "==" else call("not", text), BOOL)

    def _arithmetic(self, operator: str, operands: list[Snippet]) -> Snippet:
        if operator == "*":
            return self._product(operands)
        names = {"%": "remainder", "^": "expt"}
        kind = operands[0].kind
        for each in operands[1:]:
            kind = _sum_kind(kind, each.kind) if operator in "+-" else kind if operator == "/" else NUM
        if operator == "/":
            kind = NUM if is_number(kind) else kind
        return Snippet(call(names.get(operator, operator), *(each.text for each in operands)), kind)

    def _product(self, operands: list[Snippet]) -> Snippet:
        """Return a product: of numbers item by item, of vectors and matrices as in linear algebra."""
        result = operands[0]
        flat = [result.text]
        for each in operands[1:]:
            if is_number(result.kind) or is_number(each.kind):
                kind = _sum_kind(result.kind, each.kind) if is_number(result.kind) and is_number(each.kind) else (
                    each.kind if is_number(result.kind) else result.kind
                )  # fmt: skip
                flat.append(each.text)
                result = Snippet(call("*", *flat), kind)
                continue
            result = self._inner_product(result, each)
            flat = [result.text]
        return result

    def _inner_product(self, a: Snippet, b: Snippet) -> Snippet:
        names = (a.kind.name, b.kind.name)
        if names == ("vec", "vec"):
            return Snippet(call("dot", a.text, b.text), NUM)
        if set(names) <= {"vec", "mat"}:
            return Snippet(
                call("@", a.text, b.text), SnippetKind("mat", 0, vector(0)) if names == ("mat", "mat") else vector(0)
            )
        return Snippet(call(self.c.helper("times"), a.text, b.text), ANY)

    # --- lists -------------------------------------------------------------------------------------------------------

    def _items(self, expr: Items) -> Snippet:
        if any(isinstance(each, ItemLoop | ItemCondition | Each | Let) for each in expr.items):
            pieces = [self._generated(each) for each in expr.items]
            if len(pieces) == 1:
                return pieces[0]
            kinds = [piece.kind.item or ANY for piece in pieces]
            return Snippet(call("append", *(piece.text for piece in pieces)), list_of(_all_joined(kinds)))
        return self.list_code([self.code(each) for each in expr.items])

    def list_code(self, items: list[Snippet]) -> Snippet:
        """Return a list: an array if all items are numbers, or vectors of one length."""
        kinds = [each.kind for each in items]
        if not items:
            return Snippet("(list)", list_of(UNKNOWN))
        if all(is_number(kind) or kind in (ANY, UNKNOWN) for kind in kinds):
            code = vector_code(items)
            return (
                code
                if all(map(is_number, kinds))
                else Snippet(code.text, SnippetKind("vec", len(items), ANY), None, code.parts)
            )
        first = kinds[0]
        if first.name == "vec" and first.size and all(kind.name == "vec" and kind.size == first.size for kind in kinds):
            text = f"[{' '.join(each.text for each in items)}]"
            return Snippet(text, SnippetKind("mat", 0, first), None, tuple(items))
        return Snippet(call("list", *(each.text for each in items)), list_of(_all_joined(kinds)), None, tuple(items))

    def _generated(self, expr: Expr) -> Snippet:
        """Return the list that an item of a list stands for."""
        if isinstance(expr, Each):
            value = (
                self._generated(expr.value)
                if isinstance(expr.value, ItemLoop | ItemCondition)
                else self.code(expr.value)
            )
            return Snippet(value.text, list_of(value.kind.item or ANY))
        if isinstance(expr, Let):
            inner, bindings = self.bound(expr.bindings)
            body = inner._generated(expr.body)
            return Snippet(f"(let* ({bindings}) {body.text})", body.kind)
        if isinstance(expr, ItemCondition):
            yes = self._generated(expr.yes)
            no = self._generated(expr.no) if expr.no is not None else Snippet("(list)", list_of(UNKNOWN))
            return Snippet(call("if", self.condition(expr.test), yes.text, no.text), joined(yes.kind, no.kind))
        if isinstance(expr, ItemLoop):
            return self._loop(expr)
        value = self.code(expr)
        return Snippet(call("list", value.text), list_of(value.kind))

    def _loop(self, expr: ItemLoop) -> Snippet:
        inner, clauses, count = self.clauses(expr.bindings)
        body, tests = expr.body, ""
        definitions = ""
        while isinstance(body, Let) or (isinstance(body, ItemCondition) and body.no is None and not definitions):
            if isinstance(body, Let):
                for each in body.bindings:
                    value = inner.code(each.value)
                    definitions += f"(define {inner.bind(str(each.name), value.kind)} {value.text})\n"
            else:
                tests += f" :when {inner.condition(body.test)}"
            body = body.body if isinstance(body, Let) else body.yes
        name = "for*" if count > 1 else "for"
        if isinstance(body, ItemLoop | ItemCondition | Each):
            inside = inner._generated(body)
            return Snippet(f"({name}/append ({clauses}{tests}) {definitions}{inside.text})", inside.kind)
        value = inner.code(body)
        return Snippet(f"({name}/list ({clauses}{tests}) {definitions}{value.text})", list_of(value.kind))

    def clauses(self, bindings: Sequence[Argument]) -> tuple[Self, str, int]:
        """Return the place inside of a loop, the text of its clauses, and their number."""
        inner, texts = self.inside(), []
        for each in bindings:
            values = inner.code(each.value)
            if is_number(values.kind) or values.kind in (BOOL, UNDEF):
                values = Snippet(call("list", values.text), list_of(values.kind))
            item = STR if values.kind == STR else values.kind.item or ANY
            texts.append(f"({inner.bind(str(each.name), item)} {values.text})")
        return inner, " ".join(texts), len(texts)

    def _range(self, expr: Range) -> Snippet:
        first, last = self.code(expr.first), self.code(expr.last)
        step = self.code(expr.step) if expr.step is not None else constant(1)
        if first.kind == INT and last.kind == INT and step.number == 1:
            is_literal = last.number is not None and _is_literal(last)
            if (
                expr.step is None
                and first.number is not None
                and last.number is not None
                and first.number > last.number
            ):
                return Snippet(call(self.c.helper("rising"), first.text, last.text), list_of(INT))
            end = constant((last.number or 0) + 1).text if is_literal else _one_more(last.text)
            return Snippet(call("range", first.text, end), list_of(INT))
        kind = INT if first.kind == step.kind == INT else NUM
        return Snippet(call(self.c.helper("span"), first.text, step.text, last.text), list_of(kind))

    def _item(self, expr: ItemAt) -> Snippet:
        value, index = self.code(expr.value), self.code(expr.index)
        if value.parts is not None and index.number is not None and 0 <= index.number < len(value.parts):
            part = value.parts[int(index.number)]
            return part
        kind = STR if value.kind == STR else value.kind.item or ANY
        place = index.text if index.kind == INT else call("floor", index.text)
        return Snippet(call("ref", value.text, place), kind)

    # --- calls -------------------------------------------------------------------------------------------------------

    def _call(self, expr: ScadCall) -> Snippet:
        if not isinstance(expr.function, VariableName):
            return Snippet(call(self.text(expr.function), *self._plain(expr)), ANY)
        name = expr.function.name
        function = self.scope.function(name)
        if function is not None:
            definition = function.definition
            self.c.facts.mark("called", function.place)
            operands = self.operands(function, definition.parameters, expr.arguments, expr.span)
            return Snippet(call(function.name, *operands), self.c.facts.kind(function.place, "result"))
        variable = self.scope.variable(name)
        if variable is not None:
            return Snippet(call(variable.text, *self._plain(expr)), ANY)
        return self._builtin(expr, name, [self.code(each.value) for each in expr.arguments])

    def _plain(self, expr: ScadCall) -> list[str]:
        if any(each.name for each in expr.arguments):
            unsupported(expr.span, "named arguments in the call of a function that is a value")
        return [self.text(each.value) for each in expr.arguments]

    def operands(
        self, function: Definition, parameters: Sequence[ScadParameter], arguments: Sequence[Argument], span: Span
    ) -> list[str]:  # fmt: skip
        """Return the operands of a call: by position for parameters without defaults, by keyword for others."""
        given: dict[int, Snippet] = {}
        position = 0
        for each in arguments:
            if each.name is None:
                index, position = position, position + 1
            else:
                names = [parameter.name for parameter in parameters]
                if each.name not in names:
                    if not each.name.startswith("$"):
                        self.c.warn(span, f"`{function.definition.name}` has no parameter `{each.name}`: ignored")
                    continue
                index = names.index(each.name)
            value = self.code(each.value)
            if index < len(parameters):
                given[index] = value
                self.c.facts.join(function.place, parameters[index].name, value.kind)
        texts = []
        for index, parameter in enumerate(parameters):
            if index not in given:
                if parameter.default is None:
                    self.c.facts.mark("omitted", function.place, parameter.name)
                    self.c.facts.join(function.place, parameter.name, UNDEF)
                continue
            is_keyword = parameter.default is not None or self.c.facts.holds("omitted", function.place, parameter.name)
            texts.append(f":{function.names[index]} {given[index].text}" if is_keyword else given[index].text)
        return sorted(texts, key=lambda text: text.startswith(":"))

    def parameters(self, function: Definition, outside: Expressions) -> str:
        """Declare the parameters of a function in this place; returns their text."""
        plain, keywords = [], []
        for parameter, name in zip(function.definition.parameters, function.names, strict=True):
            kind = self.c.facts.kind(function.place, parameter.name)
            if parameter.default is not None:
                default = outside.code(parameter.default)
                kind = joined(kind, default.kind)
                keywords.append(f"(:{name} {default.text})")
            elif self.c.facts.holds("omitted", function.place, parameter.name):
                keywords.append(f"(:{name} none)")
            else:
                plain.append(name)
            self.scope.taken.add(name)
            self.scope.variables[parameter.name] = Snippet(name, kind)
            if parameter.name.startswith("$"):
                self.specials[parameter.name] = Snippet(name, kind)
        return " ".join((*plain, *keywords))

    def _builtin(self, expr: ScadCall, name: str, values: list[Snippet]) -> Snippet:
        count = len(values)
        if name in _ABSENT_FUNCTIONS:
            unsupported(expr.span, f"the function `{name}`", _ABSENT_FUNCTIONS[name])
        if name == "rands":
            return self._random_numbers(expr, values)
        handler = _BUILTINS.get(name)
        if handler is None:
            near = suggest(name, [*_BUILTINS, *self._functions()])
            failure(expr.span, f"the function `{name}` is not defined", f"did you mean `{near}`?" if near else None)
        least, most, make = handler
        if not least <= count <= most:
            failure(expr.span, f"`{name}` with {count} arguments")
        return make(self, values)

    def _random_numbers(self, expr: ScadCall, values: list[Snippet]) -> Snippet:
        """Convert `rands`: with a seed, and numbers that are known, to the same numbers as OpenSCAD's."""
        if not 3 <= len(values) <= 4:
            failure(expr.span, f"`rands` with {len(values)} arguments")
        known = [each.number for each in values if each.number is not None]
        if len(known) == 4 and known[2] <= _MAX_RANDOM and known[3] == int(known[3]):
            numbers = random_numbers(known[0], known[1], int(known[2]), int(known[3]))
            return self.list_code([constant(value) for value in numbers])
        self.c.warn(expr.span, "`rands` draws other numbers than OpenSCAD; `--seed` changes them")
        return Snippet(call(self.c.helper("random-numbers"), *(each.text for each in values[:3])), list_of(NUM))

    def _functions(self) -> list[str]:
        functions: list[str] = []
        scope: NameScope | None = self.scope
        while scope is not None:
            functions += scope.functions
            scope = scope.parent
        return functions


def _is_literal(code: Snippet) -> bool:
    return code.number is not None and code.text == number_text(code.number)


def _one_more(text: str) -> str:
    """Return ``text`` plus one; ``(- n 1)`` plus one is ``n``."""
    match = re.fullmatch(r"\(- (\S+|\([^()]*\)) 1\)", text)
    return match[1] if match else call("+", text, "1")


def _sum_kind(a: SnippetKind, b: SnippetKind) -> SnippetKind:
    if is_number(a) and is_number(b):
        return INT if a == b == INT else NUM
    if is_sequence(a) and is_sequence(b):
        return joined(a, b)
    return ANY


def _all_joined(kinds: Iterable[SnippetKind]) -> SnippetKind:
    result = UNKNOWN
    for kind in kinds:
        result = joined(result, kind)
    return result


# --- functions of OpenSCAD -------------------------------------------------------------------------------------------


_Make = Callable[[Expressions, list[Snippet]], Snippet]


def _number(name: str, kind: SnippetKind = NUM) -> _Make:
    return lambda place, values: Snippet(call(name, *(each.text for each in values)), kind)


def _angle(name: str) -> _Make:
    return lambda place, values: Snippet(call(name, call("deg", values[0].text)), NUM)


def _in_degrees(name: str) -> _Make:
    return lambda place, values: Snippet(call("to-degrees", call(name, *(each.text for each in values))), NUM)


def _extreme(name: str) -> _Make:
    def make(place: Expressions, values: list[Snippet]) -> Snippet:
        if len(values) == 1 and not is_number(values[0].kind):
            return Snippet(call(f"{name}-of", values[0].text), NUM)
        kind = INT if all(each.kind == INT for each in values) else NUM
        return Snippet(call(name, *(each.text for each in values)), kind)

    return make


def _helped(name: str, kind: SnippetKind) -> _Make:
    return lambda place, values: Snippet(call(place.c.helper(name), *(each.text for each in values)), kind)


def _test(name: str) -> _Make:
    return lambda place, values: Snippet(call(name, values[0].text), BOOL)


def _concat(place: Expressions, values: list[Snippet]) -> Snippet:
    texts, kinds = [], []
    for each in values:
        is_item = is_number(each.kind) or each.kind in (STR, BOOL)
        texts.append(call("list", each.text) if is_item else each.text)
        kinds.append(each.kind if is_item else each.kind.item or ANY)
    return Snippet(call("append", *texts), list_of(_all_joined(kinds)))


def _norm(place: Expressions, values: list[Snippet]) -> Snippet:
    return Snippet(call("norm", place.array(values[0]).text), NUM)


def _cross(place: Expressions, values: list[Snippet]) -> Snippet:
    a, b = (place.array(each) for each in values)
    if a.kind.size == 2:
        return Snippet(call("determinant", f"[{a.text} {b.text}]"), NUM)
    if 3 in (a.kind.size, b.kind.size):
        return Snippet(call("cross", a.text, b.text), vector(3))
    return Snippet(call(place.c.helper("cross-of"), a.text, b.text), ANY)


def _str(place: Expressions, values: list[Snippet]) -> Snippet:
    texts = [each.text if each.kind == STR else call(place.c.helper("shown"), each.text) for each in values]
    return Snippet(texts[0] if len(texts) == 1 else call("string-append", *texts), STR)


def _power(place: Expressions, values: list[Snippet]) -> Snippet:
    return Snippet(call("expt", values[0].text, values[1].text), NUM)


def _version(place: Expressions, values: list[Snippet]) -> Snippet:
    return vector_code([constant(2021), constant(1), constant(0)])


_BUILTINS: dict[str, tuple[int, int, _Make]] = {
    **{name: (1, 1, _number(target)) for name, target in _DIRECT.items()},
    **{name: (1, 1, _number(target, INT)) for name, target in _ROUNDING.items()},
    **{name: (1, 1, _angle(name)) for name in _ANGLES},
    **{name: (1, 1, _in_degrees(name)) for name in _INVERSE},
    **{name: (1, 1, _test(target)) for name, target in _TESTS.items()},
    "atan2": (2, 2, _in_degrees("atan")),
    "round": (1, 1, _helped("rounded-number", INT)),
    "log": (1, 1, _number("log10")),
    "pow": (2, 2, _power),
    "len": (1, 1, _number("length", INT)),
    "min": (1, 1000, _extreme("min")),
    "max": (1, 1000, _extreme("max")),
    "norm": (1, 1, _norm),
    "cross": (2, 2, _cross),
    "concat": (0, 1000, _concat),
    "str": (1, 1000, _str),
    "chr": (1, 1, _number("chr", STR)),
    "ord": (1, 1, _number("ord", INT)),
    "lookup": (2, 2, _helped("lookup", NUM)),
    "is_undef": (1, 1, _test("none?")),
    "is_list": (1, 1, _helped("list-or-array?", BOOL)),
    "version": (0, 0, _version),
    "version_num": (0, 1, lambda place, values: constant(20210100)),
}
