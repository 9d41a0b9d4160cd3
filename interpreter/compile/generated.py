"""Run-time support of generated functions (locations of errors, general calls), and the text of a function in progress.

A generated function has no ``try`` around its calls. One handler around its body asks ``placed`` to find, by the line
number in the traceback, the *site* that failed, and to handle the error as the closure of that call would.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from operator import itemgetter
from types import TracebackType
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile import calls
from scenelang.interpreter.compile.analyze import (
    MAX_BITS,
    FrameLayout,
    arithmetic_kind,
    undefined,
)
from scenelang.interpreter.compile.kinds import (
    ANY,
    BOOLEAN,
    FLOAT,
    LIST,
    MATRIX,
    MAX_LITERAL_BITS,
    NUMBER,
    STRING,
    VECTOR,
    Kind,
    integer_of,
    is_number,
    is_truthy,
    kind_of_operand,
    may_be,
)
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.parts import PartCollector
from scenelang.interpreter.runtime.procedures import (
    TAIL,
    UNDEFINED,
    Cell,
    Closure,
    RecordProcedure,
    iterate,
    python_error,
)
from scenelang.interpreter.runtime.types import Builtin, Mismatch
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.pose import compose, exact_translation
from scenelang.interpreter.values.values import (
    IDENTITY,
    NIL,
    Matrix,
    MutableList,
    Pair,
    Procedure,
    Table,
    Vector,
    make_list,
)

if TYPE_CHECKING:
    from scenelang.interpreter.compile.compile import Compiler
    from scenelang.interpreter.runtime.runtime import Runtime

BLOCK = 2048  # turns of a loop between two charges
SITES = "SITES"  # name of the table of sites among the constants of a generated function
_MAX_LINES = 20_000  # of a function, including lines that are rolled back; more take long to compile
_MAX_INDENT = 60  # levels of nested blocks; CPython's tokenizer allows 100
_MAX_BLOCKS = 16  # nested loops and handlers; CPython allows 20
_SMALL = (1 << 30) - 1  # largest Integer of one digit of CPython (30 bits), with which comparisons are fastest
_COUNTER_BITS = 64  # of a number whose sums need no check: each step adds at most this much, and steps are limited
OPERATORS = {"add": "+", "sub": "-", "mul": "*", "lt": "<", "gt": ">", "le": "<=", "ge": ">=", "eq": "=="}
COMPARISONS = frozenset({"lt", "gt", "le", "ge", "eq"})
_FITTING = {  # tests of the values that the conversion to a type returns unchanged
    "String": "type({0}) is str", "Word": "type({0}) is str", "Integer": "type({0}) is int",
    "Float": "type({0}) is float or type({0}) is int", "Number": "type({0}) is float or type({0}) is int",
    "List": "type({0}) is Pair or {0} is NIL", "Vector": "type({0}) is Vector",
    "Point": "type({0}) is Vector and len({0}) == 3", "Matrix": "type({0}) is Matrix",
}  # fmt: skip
# Kinds of the results of builtins, by their type in the registry. The checker knows more of them (``_BY_TYPE``).
_RESULTS = {"Boolean": BOOLEAN, "String": STRING, "List": LIST, "Matrix": MATRIX, "Vector": VECTOR}
CAUGHT = (SceneError, Mismatch, ArithmeticError, MemoryError)


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
    """Return the error to raise for ``error``, with the span or the call of the site that failed.

    ``sites`` are keyed by the line numbers of the generated function.
    """
    traceback = error.__traceback__
    assert traceback is not None
    site = sites.get(traceback.tb_lineno)
    if type(site) is CallSite and isinstance(error, SceneError):
        calls.locate(error, None if error.span is None else _called(site, traceback), site.span)
    elif type(site) is BuiltinSite:
        return _placed_builtin(error, site, traceback)
    elif type(site) is Span and isinstance(error, SceneError) and error.span is None:
        error.span = site
    return error


def _placed_builtin(error: BaseException, site: BuiltinSite, traceback: TracebackType) -> BaseException:
    """Return the error of a failed builtin, with its location.

    For an argument of the wrong type, the values are read from the local variables of the generated function.
    """
    if isinstance(error, SceneError):
        if error.span is None:
            error.span = site.span
        return error
    if isinstance(error, Mismatch):
        names = traceback.tb_frame.f_locals
        values = [names.get(a.name) if type(a) is Local else a for a in site.arguments]
        return calls.mismatch(site.builtin, site.checks, values, site.span)
    assert isinstance(error, Exception)
    scene_error = python_error(site.builtin.name, error)
    scene_error.span = site.span
    return scene_error


def site_of(traceback: TracebackType) -> tuple[Any, Span] | None:
    """Return the function and span of the call at which a traceback's entry is, if that is in a generated function."""
    frame = traceback.tb_frame
    sites = frame.f_globals.get(SITES)
    site = sites.get(traceback.tb_lineno) if type(sites) is dict else None
    if type(site) is not CallSite:
        return None
    return _called(site, traceback), site.span


def _called(site: CallSite, traceback: TracebackType) -> Any:
    """Return the function that a call site called."""
    function = site.function
    return traceback.tb_frame.f_locals.get(function.name) if isinstance(function, Local) else function.value


def iterator(rt: Runtime, place: Span) -> Callable[[Any], Any]:
    """Return a function that iterates over the sequence of a ``for`` clause."""

    def items(sequence: Any) -> Any:
        try:
            return iterate(rt, sequence)
        except SceneError as error:
            if error.span is None:
                error.span = place
            raise

    return items


def part_adder(rt: Runtime, span: Span) -> Callable[[PartCollector, Any], None]:
    """Return a function that adds the value of a turn to the parts of ``for/union``."""
    return lambda out, value: calls.add_parts(rt, out, value, span)


def forget(rt: Runtime, function: Closure) -> None:
    """Make generated functions call ``function`` like an unknown one, because it is traced now."""
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
    """Return a function ``call(function, arguments)`` that performs a call without a fast path.

    ``head`` is the head of the call, for the name in errors; the site of the caller locates them.
    """
    tick = rt.tick

    def call(function: Any, values: Sequence[Any]) -> Any:
        if type(function) is Closure and function.arity == len(values):
            tick()
            result = function.code.body([function.env, *values])
            while result is TAIL:
                tick()
                result = rt.next_body(rt.next_frame)
            return result
        if type(function) is RecordProcedure:
            return function.call(rt, values)
        if function is UNDEFINED:
            raise undefined(rt, head.name, head.span)
        if not isinstance(function, Procedure):
            raise rt.not_a_procedure(function, span)
        return rt.apply(function, values)

    return call


def global_caller(rt: Runtime, cell: Cell, head: Any, span: Span) -> Callable[..., Any]:
    """Return a function that calls the current value of a global variable.

    Generated code uses it where the variable has another value than when the code was generated.

    Parameters
    ----------
    cell
        Cell of the variable.
    head, span
        Head and location of the call, for errors.
    """
    call = caller(rt, head, span)
    return lambda *values: call(cell.value, values)


def tail_caller(rt: Runtime, head: Any, span: Span) -> Callable[[Any, Sequence[Any]], Any]:
    """Return a function that performs a tail call without a fast path."""

    def call(function: Any, values: Sequence[Any]) -> Any:
        return calls.apply_at(rt, function, values, head, span)

    return call


def undefined_raiser(rt: Runtime, name: str, span: Span) -> Callable[[], Any]:
    """Return a function that raises the error of a variable without a value."""

    def fail() -> Any:
        raise undefined(rt, name, span)

    return fail


def cell_binder(rt: Runtime) -> Callable[[list[Any], int, Any], None]:
    """Return a function that defines a variable in a cell; an undefined cell may be captured already and is reused."""

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


def translation_maker(rt: Runtime, builtin: Builtin, span: Span, place: Span) -> Callable[[Any, Any, Any], Any]:
    """Return a function for ``(translate [x y z])`` at ``span``; its array, at ``place``, is only made for errors."""
    vector = calls.array_node(rt, [itemgetter(0), itemgetter(1), itemgetter(2)], place)
    general = calls.builtin_call(rt, builtin, [vector], span)

    def make(x: Any, y: Any, z: Any) -> Any:
        return exact_translation(x, y, z) or general((x, y, z))  # type: ignore[arg-type]

    return make


# --- text of a function in progress -----------------------------------------------------------------------------------


class Unsupported(Exception):
    """Raised for code that cannot be generated."""


@dataclass(frozen=True, slots=True)
class CodeText:
    """Python expression.

    Attributes
    ----------
    text, kind
        Text of the expression, and the kind of its value.
    pure
        Whether it cannot fail and its value does not change before its use.
    atomic
        Whether it is a name or a literal, which may be written several times.
    """

    text: str
    kind: Kind = ANY
    pure: bool = True
    atomic: bool = True


class Text:
    """Lines, constants and variables of a function that is being written."""

    def __init__(self, compiler: Compiler, layout: FrameLayout) -> None:
        """Create the namespace of the generated function, in which ``lines`` will run."""
        self.compiler = compiler
        self.rt = compiler.rt
        self.base = self.layout = layout  # of the function's frame, and of the innermost loop's
        self.lines: list[str] = []
        self.indent = 0
        self.blocks = 1  # nested blocks of CPython at this point: the handler, and each loop
        self.sites: dict[int, Any] = {}  # calls that locate errors, by line
        # The namespace of the generated function; the text refers to these objects by short names.
        self.constants: dict[str, Any] = {
            "CAUGHT": CAUGHT, "placed": placed, SITES: self.sites, "rt": self.rt, "ticks": self.rt.meter.ticks,
            "charge": self.rt.charge, "spend": self.rt.meter.spend, "TAIL": TAIL, "U": UNDEFINED, "NIL": NIL,
            "Pair": Pair, "Closure": Closure, "Vector": Vector, "Matrix": Matrix, "Entity": Entity,
            "MutableList": MutableList, "Table": Table, "Cell": Cell, "BLOCK": range(1, BLOCK + 1),
            "bounce": compiler.bounce, "bind_cell": compiler.bind_cell, "compose": compose, "isfinite": isfinite,
            "make_list": make_list, "PartCollector": PartCollector, "IDENTITY": IDENTITY,
        }  # fmt: skip
        self.numbered: dict[int, str] = {}  # names of constants by id
        self.count = 0  # names and loop numbers so far
        self.names: dict[Variable, str] = {}  # local variables
        self.kinds: dict[str, Kind] = {}  # of local variables, as far as they are known at this point
        self.frames: dict[FrameLayout, str] = {}  # local variables of the frames
        self.direct: tuple[Closure, str] | None = None  # this function as a global, and its cell
        self.self_tail: tuple[str, ...] | None = None  # parameters, if tail calls of itself are turns of a loop
        self.embedded: set[Variable] = set()  # read by forms that are called as closures, so frames have copies
        self.unshared: set[Variable] = set()  # only in the frame, as embedded code defines or assigns them
        self.loop_names: dict[int, list[str]] = {}  # next values of the parameters of loops with frames, by number
        self.poses: set[str] = set()  # local variables with results of builtins that return a finite Matrix
        self.mutable: set[str] = set()  # local variables that the program assigns
        self.literals: dict[str, Any] = {}  # values of constants in the source
        self.written = 0  # lines, including those that were rolled back
        self.around: Span | None = None  # place of errors without one, in a `while` loop
        self.returns_tail = False  # whether the function may request a tail call of its caller
        self.own_checks: list[int] = []  # indices of the lines after calls of itself that test for such a request

    def line(self, text: str, site: Any = None) -> None:
        """Write a line; ``site`` is the call in it, which locates errors."""
        self.written += 1
        if self.indent > _MAX_INDENT or self.written > _MAX_LINES:
            raise Unsupported
        self.lines.append(" " * self.indent + text)
        if site is None:
            site = self.around
        if site is not None:
            self.sites[len(self.lines)] = site

    def open(self, text: str) -> None:
        """Write the head of a loop, which counts as a block of CPython."""
        self.line(text)
        self.indent += 1
        self.blocks += 1
        if self.blocks > _MAX_BLOCKS:
            raise Unsupported

    def close(self) -> None:
        """End the body of a loop."""
        self.indent -= 1
        self.blocks -= 1

    def fresh(self, letter: str) -> str:
        """Return a new name: v of a variable, t of a temporary, p of an item or function, k of a constant."""
        self.count += 1
        return f"{letter}{self.count}"

    def constant(self, value: Any) -> str:
        """Return the name of a constant of the function."""
        name = self.numbered.get(id(value))
        if name is None:
            name = self.numbered[id(value)] = self.fresh("k")
            self.constants[name] = value
        return name

    def temporary(self, code: CodeText) -> CodeText:
        """Write the assignment of an expression to a new local variable, and return it."""
        name = self.fresh("t")
        self.line(f"{name} = {code.text}")
        self.kinds[name] = code.kind
        return CodeText(name, code.kind)

    def named(self, code: CodeText) -> CodeText:
        """Return an expression as a variable, because CPython warns about ``is`` with a literal."""
        return self.temporary(code) if not code.atomic or code.text in self.literals else code

    def atom(self, code: CodeText) -> CodeText:
        """Return an expression as a name or literal."""
        return code if code.atomic else self.temporary(code)

    def name_of(self, variable: Variable) -> str:
        """Return the name of the local variable of Python for a variable."""
        name = self.names.get(variable)
        if name is None:
            name = self.names[variable] = self.fresh("v")
            if variable.assigned:
                self.mutable.add(name)
        return name

    def kind_of_variable(self, variable: Variable) -> Kind:
        """Return the kind of a variable at this point of the text."""
        name = self.names.get(variable)
        return ANY if name is None else self.kinds.get(name, ANY)

    def kind_of(self, code: CodeText) -> Kind:
        """Return the kind of an expression; that of a variable may have been narrowed since it was written."""
        return self.kinds.get(code.text, code.kind)

    def in_cell(self, variable: Variable) -> bool:
        """Return whether a variable is stored in a cell (see ``Compiler.in_cell``)."""
        return variable.assigned and variable.captured

    def in_frame_only(self, variable: Variable) -> bool:
        """Return whether a variable has no local variable of Python."""
        return self.in_cell(variable) or variable in self.unshared

    def is_stored(self, variable: Variable) -> bool:
        """Return whether the frame has a copy of a variable for closures or embedded code."""
        return variable.captured or variable in self.embedded

    def slot_text(self, variable: Variable) -> str:
        """Return the Python expression of a variable's slot, such as ``f[0][2]``."""
        layout: FrameLayout | None = self.layout
        while layout is not None and variable not in layout.slots and layout is not self.base:
            layout = layout.parent
        assert layout is not None
        text = self.frames[layout]
        if variable not in layout.slots:
            text = "e" if self.frames[self.base] == "F" else "f[0]"
            layout = layout.parent
            while layout is not None and variable not in layout.slots:
                text, layout = f"{text}[0]", layout.parent
            if layout is None:
                raise Unsupported
        return f"{text}[{layout.slots[variable]}]"

    def check_defined(self, name: str, target: Variable, node: ast.Reference) -> None:
        """Write a check that a variable has a value."""
        fail = self.constant(undefined_raiser(self.rt, target.name, node.span))
        self.line(f"if {name} is U: {fail}()")

    def read_cell(self, text: str, target: Variable, node: ast.Reference) -> CodeText:
        """Write the read of a variable in a cell; the counterpart in closures is ``cell_reader``."""
        cell, value = self.fresh("t"), self.fresh("t")
        self.line(f"{cell} = {text}")
        self.line(f"if {cell}.birth < rt.serial: rt.read({cell})")
        self.line(f"{value} = {cell}.value")
        self.check_defined(value, target, node)
        return CodeText(value)

    def _literal(self, value: Any) -> str:
        """Return the Python literal of a value, and remember that its text is one."""
        text = repr(value)
        if text[0] == "-":
            text = f"({text})"
        self.literals[text] = value
        return text

    def slot_of(self, variable: Variable) -> tuple[str, int]:
        """Return the Python expression of a variable's frame, and its slot."""
        text = self.slot_text(variable)
        frame, _, slot = text.rpartition("[")
        return frame, int(slot[:-1])

    def bind(self, variable: Variable, text: str, kind: Kind) -> None:
        """Write the definition of a local variable of this function: ``text``, its value of the kind ``kind``."""
        if self.in_cell(variable):
            frame, slot = self.slot_of(variable)
            self.line(f"bind_cell({frame}, {slot}, {text})")
            return
        if variable in self.unshared:
            self.line(f"{self.slot_text(variable)} = {text}")
            return
        name = self.name_of(variable)
        if text != name:
            self.line(f"{name} = {text}")
        if not variable.assigned:
            self.kinds[name] = kind
        if self.is_stored(variable):
            self.line(f"{self.slot_text(variable)} = {name}")

    def literal(self, value: Any) -> CodeText:
        """Return a constant as a literal if it is short, else as a constant of the function."""
        kind = type(value)
        if kind is bool or value is None:
            return CodeText(self._literal(value), BOOLEAN if kind is bool else ANY)
        is_short = kind is int and value.bit_length() <= MAX_LITERAL_BITS
        if is_short or (kind is float and isfinite(value)):
            return CodeText(self._literal(value), kind_of_operand(value))
        return CodeText(self.constant(value), kind_of_operand(value))

    def roll_back(self, lines: int, kinds: dict[str, Kind], names: dict[Variable, str]) -> None:
        """Remove the lines from number ``lines`` on, and restore the knowledge about variables before them."""
        del self.lines[lines:]
        for number in [number for number in self.sites if number > lines]:
            del self.sites[number]
        self.kinds, self.names = kinds, names

    def list_of(self, values: Sequence[CodeText]) -> CodeText:
        """Write a list as nested pairs."""
        text = "NIL"
        for value in reversed(values):
            text = f"Pair({value.text}, {text})"
        return self.temporary(CodeText(text, LIST))

    def checked_call(self, builtin: Builtin, node: ast.Application, values: Sequence[CodeText]) -> CodeText:
        """Write a call of a builtin; arguments that do not certainly fit are checked inline."""
        signature = builtin.signature
        parameters = signature.positional
        checks, texts, operands = [], [], []
        for index, value in enumerate(values):
            parameter = parameters[index] if index < len(parameters) else signature.rest
            assert parameter is not None
            is_checked = not builtin.checks_arguments and parameter.type.is_checked
            check = parameter.type.checker(self.rt) if is_checked else None
            checks.append(check)
            needs = check is not None and not self._fits(parameter.type.name, value)
            texts.append(self._checked(parameter.type.name, check, value) if needs else value.text)
            operands.append(self.operand_of(value.text))
        site = BuiltinSite(builtin, tuple(checks), tuple(operands), node.span)
        name = self.fresh("t")
        self.line(f"{name} = {self.constant(builtin.function)}(rt{''.join(f', {t}' for t in texts)})", site)
        kind = _RESULTS.get(builtin.result, ANY)
        self.kinds[name] = kind
        if kind is MATRIX:
            self.poses.add(name)
        return CodeText(name, kind)

    def _checked(self, expected: str, check: Any, value: CodeText) -> str:
        """Return the Python expression for the converted argument of a builtin."""
        test, text = _FITTING.get(expected), f"{self.constant(check)}({value.text})"
        if value.text in self.literals:
            return text
        return f"{value.text} if {test.format(value.text)} else {text}" if test is not None else text

    def operand_of(self, text: str) -> Any:
        """Return an atom as the operand of a site: its value if it is constant, else the local variable."""
        if text in self.literals:
            return self.literals[text]
        return self.constants[text] if text in self.constants else Local(text)

    def _fits(self, expected: str, value: CodeText) -> bool:
        """Return whether an argument certainly has the type ``expected``, so that it needs no check."""
        kind = self.kind_of(value)
        if kind.tag == "String":
            return expected in ("String", "Word")
        if kind.tag == "Integer" and expected == "Integer":
            return True
        return expected in ("Float", "Number") and is_number(kind)

    def _is_number(self, code: CodeText) -> str:
        """Return the Python condition for whether a value is a number; empty if it is known to be one."""
        if is_number(self.kind_of(code)):
            return ""
        return f"(type({code.text}) is int or type({code.text}) is float)"

    def comparison(self, operator: str, x: CodeText, y: CodeText, slow: str) -> CodeText:
        """Return a comparison. Afterwards both operands are known to be numbers, since it fails otherwise.

        Parameters
        ----------
        operator
            Operator of Python.
        x, y
            Operands.
        slow
            Name of the function that compares anything else, or fails.
        """
        tests = [test for test in (self._is_number(x), self._is_number(y)) if test]
        text = f"{x.text} {operator} {y.text}"
        for code in (x, y):
            if code.text[0] in "vt" and code.text not in self.mutable and not is_number(self.kind_of(code)):
                self.kinds[code.text] = NUMBER
        if not tests:
            return CodeText(f"({text})", BOOLEAN, True, False)
        test = " and ".join(tests)
        return CodeText(f"({text} if {test} else {slow}({x.text}, {y.text}))", BOOLEAN, False, False)

    def arithmetic(self, name: str, x: CodeText, y: CodeText, slow: str) -> CodeText:
        """Return a sum, difference or product, without checks where the kinds of the operands allow it.

        Parameters
        ----------
        name
            Operation: "add", "sub" or "mul".
        x, y
            Operands.
        slow
            Name of the function that computes all other cases (see ``ARITHMETIC``).
        """
        operator, left, right = OPERATORS[name], self.kind_of(x), self.kind_of(y)
        text = f"({x.text} {operator} {y.text})"
        kind = arithmetic_kind(name, left, right)
        if kind.tag == "Float" and self._safe_float(left) and self._safe_float(right):
            return CodeText(text, FLOAT, True, False)
        if 0 < kind.bits <= MAX_BITS:
            return CodeText(text, kind, True, False)
        if kind.tag != "Float" and is_number(kind) and name != "mul" and self._is_small(left, right):
            return CodeText(text, kind, True, False)  # grows by a constant per step, so the step limit bounds it
        result = self.fresh("t")
        self._guarded_arithmetic(result, operator, x, y, slow)
        self.kinds[result] = kind
        return CodeText(result, kind)

    def _safe_float(self, kind: Kind) -> bool:
        """Return whether the conversion of a number to a Float cannot overflow."""
        return kind.tag == "Float" or 0 < kind.bits <= MAX_BITS

    def _is_small(self, left: Kind, right: Kind) -> bool:
        """Return whether one operand is so small that a sum needs no check of its size."""
        return any(0 < kind.bits <= _COUNTER_BITS for kind in (left, right))

    def _guarded_arithmetic(self, result: str, operator: str, x: CodeText, y: CodeText, slow: str) -> None:
        """Write arithmetic with tests of the types that the operands may have; ``slow`` handles all other values."""
        text = f"{x.text} {operator} {y.text}"
        left, right = self.kind_of(x), self.kind_of(y)
        fallback = f"{result} = {slow}({x.text}, {y.text})"
        ints = self._types("int", "Integer", x, y)
        floats = self._types("float", "Float", x, y)
        keyword = "if"
        if self._is_small(left, right) and operator != "*":
            numbers = " and ".join(test for test in (self._is_number(x), self._is_number(y)) if test)
            self.line(f"if {numbers or 'True'}: {result} = {text}")
            keyword = "elif"
        elif may_be(left, "Integer") and may_be(right, "Integer"):
            self.line(f"if {ints}:")
            self.line(f" {result} = {text}")
            self.line(f" if {result} > {_SMALL} or {result} < -{_SMALL}: {fallback}")
            keyword = "elif"
        if may_be(left, "Float") and may_be(right, "Float"):
            self.line(f"{keyword} {floats}: {result} = {text}")
            keyword = "elif"
        if keyword == "elif":
            self.line(f"else: {fallback}")
        else:
            self.line(fallback)

    def _types(self, python: str, tag: str, *codes: CodeText) -> str:
        """Return the Python condition for whether all values have a type, without those that are known to have it."""
        tests = [f"type({c.text}) is {python}" for c in dict.fromkeys(codes) if self.kind_of(c).tag != tag]
        return " and ".join(tests) or "True"

    def division(self, x: CodeText, y: CodeText, slow: str) -> CodeText:
        """Return the quotient of two numbers; ``slow`` is the name of the function that divides anything else."""
        left, right = self.kind_of(x), self.kind_of(y)
        if self._safe_float(left) and self._safe_float(right):
            text = f"({x.text} / {y.text} if {y.text} else {slow}({x.text}, {y.text}))"
            return CodeText(text, FLOAT, False, False)
        tests = [f"type({c.text}) is float" for c in (x, y) if not self._safe_float(self.kind_of(c))]
        test = " and ".join([*tests, y.text])
        return self.temporary(CodeText(f"{x.text} / {y.text} if {test} else {slow}({x.text}, {y.text})"))

    def integer_division(self, name: str, x: CodeText, y: CodeText, slow: str) -> CodeText:
        """Return ``//`` or ``%``.

        Parameters
        ----------
        name
            Operation: "floordiv" or "mod".
        x, y
            Operands.
        slow
            Name of the function that computes all other cases.
        """
        left, right = self.kind_of(x), self.kind_of(y)
        operator = "//" if name == "floordiv" else "%"
        tests = [f"type({c.text}) is int" for c in (x, y) if self.kind_of(c).tag != "Integer"]
        test = " and ".join([*tests, y.text])
        kind = ANY
        if left.tag == right.tag == "Integer":
            kind = integer_of(left.bits if name == "floordiv" else right.bits)
        elif is_number(left) and is_number(right):
            kind = NUMBER
        return self.temporary(CodeText(f"{x.text} {operator} {y.text} if {test} else {slow}({x.text}, {y.text})", kind))

    def known_call(self, result: str, cell: str, known: Closure, texts: Sequence[str], node: ast.Application) -> None:
        """Write a call of a global function that is known, with a test whether it has been defined again.

        Parameters
        ----------
        result
            Local variable of the result.
        cell
            Constant of the variable's cell.
        known
            Closure that the variable has now.
        texts
            Python expressions of the arguments.
        node
            The call.
        """
        code = known.code
        is_itself = self.direct is not None and known is self.direct[0]
        callee = "g" if is_itself else self.constant(code.direct) if code.direct else f"{self.constant(code)}.entry"
        site = CallSite(self.constants[cell], node.span)
        call = ", ".join([f"{callee}({self.constant(known.env)}", *texts])
        other = self.other(cell, node)
        test = f"{cell}.value is {self.constant(known)} and next(ticks) is None"
        self.line(f"{result} = {call}) if {test} else {other}({', '.join(texts)})", site)
        if is_itself:
            self.own_checks.append(len(self.lines))
        if is_itself or code.direct is None or code.returns_tail:
            self.line(f"if {result} is TAIL: {result} = bounce()", site)

    def other(self, cell: str, node: ast.Application) -> str:
        """Return the constant of a function that calls the current value of a global variable."""
        return self.constant(global_caller(self.rt, self.constants[cell], self.global_head(node), node.span))

    def global_head(self, node: ast.Application) -> Any:
        """Return the head of a call of a global variable, for errors, or None."""
        head = node.function
        if type(head) is ast.Reference and isinstance(head.target, Variable):
            return calls.GlobalHead(None, head.target.name, head.span)  # type: ignore[arg-type]
        return None

    def known_global(self, target: Variable) -> Any:
        """Return the closure that a global variable is defined as, or None.

        Callers must test that the variable has not been defined again. There is none for a variable that ``set!``
        changes, or whose value is not a closure.
        """
        if not target.is_global or target.assigned:
            return None
        value = self.compiler.global_cell(target).value
        return value if type(value) is Closure else None

    def leave_all(self, leaves: str, loops: Sequence[int]) -> None:
        """Write the end of all loops of a ``for`` form, inside a condition."""
        self.indent += 1
        self.line(f"{leaves} = True")
        if loops:
            self.line("break")
        self.indent -= 1
        if not loops:
            raise Unsupported

    def choice_step(self, kind: str, code: CodeText, out: str, leaves: str, loops: Sequence[int]) -> None:
        """Write the end of a turn of ``for/and``, ``for/or`` or ``for/first``.

        Parameters
        ----------
        kind
            "and", "or" or "first".
        code
            Value of the body.
        out, leaves
            Local variables of the result, and of whether the loops end.
        loops
            Indentation of the loops of the form.
        """
        truth = self.truth(code)
        if kind == "or":
            self.line(f"if {truth}: {out} = {code.text}")
            self.line(f"if {truth}:")
        elif kind == "and":
            self.line(f"{out} = {code.text} if {truth} else False")
            self.line(f"if not {truth}:")
        else:
            self.line(f"{out} = {code.text}")
            self.line("if True:")
        self.leave_all(leaves, loops)

    def slow(self, builtin: Builtin, node: ast.Application) -> Callable[[Any, Any], Any]:
        """Return a function of two operands that calls a builtin itself."""
        slow = calls.slow_call(self.rt, builtin, node.span)
        return lambda x, y: slow([x, y])

    def truth(self, code: CodeText) -> str:
        """Return the Python condition for whether a value is true: all but ``#f`` and ``none`` are."""
        kind = self.kind_of(code)
        if kind.tag == "Boolean":
            return code.text
        if code.text in self.literals:
            return repr(code.text != "None")
        if is_truthy(kind):
            if not code.pure:
                self.temporary(code)
            return "True"
        name = self.atom(code).text
        return f"({name} is not False and {name} is not None)"
