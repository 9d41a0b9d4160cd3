"""Generator of Python functions for hot code: one function per ``lambda`` or loop of the core AST.

Variables are Python's local variables; those that closures capture are also stored in the frame, with the addresses that
the closures of ``compile`` use, so that code of both tiers shares frames. Statements are written one per line: the line
number of a call in a traceback is the key of its *site* (see ``generated``), so that no call needs a ``try``. No text of
a program enters the source: variables are numbered, and values are constants of the function's namespace.

What has no translation here is compiled to a closure and called with the frame (``_embed``). Code that is too deep or
too long for CPython stays with the closures.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from operator import itemgetter
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile import calls, generated
from scenelang.interpreter.compile.analyse import (
    FrameLayout,
    Loop,
    children,
    pattern_variables,
    walk,
)
from scenelang.interpreter.compile.generated import BuiltinSite, CallSite, Local
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.procedures import TAIL, UNDEFINED, Cell, Closure, ClosureCode, Frame, Node
from scenelang.interpreter.runtime.show import array_literal
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.runtime.values import IDENTITY, NIL, Matrix, MutableList, Pair, Table, Vector
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.pose import compose

if TYPE_CHECKING:
    from scenelang.interpreter.compile.compile import Compiler

_MAX_NODES = 3_000  # longer code stays with the closures
_MAX_LINES = 20_000  # written, including those that are taken back
_MAX_INDENT = 60  # CPython allows 100
_MAX_BLOCKS = 16  # CPython allows 20 nested loops and handlers
_MAX_ARITY = 8
_BLOCK = 2048  # turns of a loop between two charges
_MIN_CHARGED = 32  # builtins with more arguments are charged by their call
_SMALL = (1 << 30) - 1  # comparisons with numbers of one digit are the fast ones of CPython
_MAX_BITS = 1_000  # Integers of fewer bits are added and multiplied without a check of their size


_FRAME = re.compile(r"\bF\b")


class Unsupported(Exception):
    """Raised for code that cannot be generated."""


@dataclass(frozen=True, slots=True)
class Kind:
    """What is known of a value: its type (``?`` if nothing), and a bound for the bits of an Integer (0 if none).

    The types are ``i`` (Integer), ``f`` (Float), ``n`` (either), ``b`` (Boolean), ``s`` (String), ``t`` (any type that is true).
    """

    type: str
    bits: int = 0


ANY, INTEGER, FLOAT, NUMBER, BOOLEAN, STRING, TRUE = map(Kind, "?ifnbst")


def joined(a: Kind | None, b: Kind | None) -> Kind:
    """Return the kind of a value that has one of two kinds; None is the kind of no value."""
    if a is None or b is None:
        return b or a or ANY
    if a.type == b.type:
        return Kind(a.type, max(a.bits, b.bits) if a.bits and b.bits else 0)
    if a.type in "ifn" and b.type in "ifn":
        return NUMBER
    return TRUE if a.type in "ifnst" and b.type in "ifnst" else ANY


@dataclass(frozen=True, slots=True)
class Code:
    """Python expression. ``pure`` is set if it cannot fail, and its value does not change before it is used."""

    text: str
    kind: Kind = ANY
    pure: bool = True
    atomic: bool = True


@dataclass(eq=False, slots=True)
class LoopCode:
    """Loop that is being written: its parameters by variable, the counter of its turns, and its parent in the tail."""

    variable: Variable
    function: ast.Lambda
    counter: str | None
    number: int
    is_left: bool = False  # whether an inner loop continues an outer one


@dataclass(frozen=True, slots=True)
class Dest:
    """Where a value goes: a variable, the end of the function, or nowhere. ``loops`` end with it, the innermost last."""

    name: str | None = None
    returns: bool = False
    loops: tuple[LoopCode, ...] = ()

    @property
    def exits(self) -> bool:
        return self.returns or bool(self.loops)


NOWHERE = Dest()
_OPERATORS = {"add": "+", "sub": "-", "mul": "*", "lt": "<", "gt": ">", "le": "<=", "ge": ">=", "eq": "=="}
_COMPARISONS = frozenset({"lt", "gt", "le", "ge", "eq"})
_EMBEDDED = (ast.For, ast.Guard, ast.LetEscape, ast.While)


def replace_function(compiler: Compiler, node: ast.Lambda, code: ClosureCode, layout: FrameLayout) -> None:
    """Replace the body of a function by generated code, if possible."""
    try:
        writer = _Writer(compiler, layout, node.body)
        entry = writer.function(node, code)
    except (Unsupported, RecursionError, SyntaxError, MemoryError):
        return
    code.entry = entry
    code.direct, code.returns_tail = entry, writer.returns_tail
    code.body = _ADAPTERS[code.arity](entry) if code.arity >= 0 else entry


def loop_function(
    compiler: Compiler, loop: Loop, layout: FrameLayout, tail: bool
) -> Callable[[Frame, int], Any] | None:
    """Return a function of the frame that continues a loop after a number of turns, if it can be generated."""
    try:
        return _Writer(compiler, layout, loop.function.body).loop(loop, tail)
    except (Unsupported, RecursionError, SyntaxError, MemoryError):
        return None


def body_function(compiler: Compiler, node: Any, layout: FrameLayout) -> Node | None:
    """Return a function of the frame that evaluates an expression, if it can be generated."""
    try:
        return _Writer(compiler, layout, node).expression(node)
    except (Unsupported, RecursionError, SyntaxError, MemoryError):
        return None


_ADAPTERS: tuple[Callable[[Any], Node], ...] = (
    lambda g: lambda f: g(f[0]),
    lambda g: lambda f: g(f[0], f[1]),
    lambda g: lambda f: g(f[0], f[1], f[2]),
    lambda g: lambda f: g(f[0], f[1], f[2], f[3]),
    lambda g: lambda f: g(f[0], f[1], f[2], f[3], f[4]),
    lambda g: lambda f: g(f[0], f[1], f[2], f[3], f[4], f[5]),
    lambda g: lambda f: g(f[0], f[1], f[2], f[3], f[4], f[5], f[6]),
    lambda g: lambda f: g(f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7]),
    lambda g: lambda f: g(f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8]),
)


class _Writer:
    """Writer of one function."""

    def __init__(self, compiler: Compiler, layout: FrameLayout, root: Any) -> None:
        self.compiler = compiler
        self.rt = compiler.rt
        self.base = self.layout = layout
        self.lines: list[str] = []
        self.indent = 0
        self.blocks = 1
        self.sites: dict[int, Any] = {}
        self.constants: dict[str, Any] = {
            "CAUGHT": generated.CAUGHT, "placed": generated.placed, generated.SITES: self.sites, "rt": self.rt,
            "ticks": self.rt.meter.ticks, "charge": self.rt.charge, "spend": self.rt.meter.spend, "TAIL": TAIL, "U": UNDEFINED,
            "NIL": NIL, "Pair": Pair, "Closure": Closure, "Vector": Vector, "Matrix": Matrix, "Entity": Entity,
            "MutableList": MutableList, "Table": Table, "Cell": Cell, "BLOCK": range(1, _BLOCK + 1),
            "bounce": compiler.bounce, "bind_cell": compiler.bind_cell, "compose": compose, "isfinite": isfinite, "IDENTITY": IDENTITY,
        }  # fmt: skip
        self.numbered: dict[int, str] = {}  # names of constants by id
        self.count = 0
        self.names: dict[Variable, str] = {}  # local variables
        self.kinds: dict[str, Kind] = {}
        self.frames: dict[FrameLayout, str] = {}
        self.direct: tuple[Closure, str] | None = None  # this function as a global, and its cell
        self.self_tail: tuple[str, ...] | None = None  # parameters, if tail calls of itself are turns of a loop
        self.embedded: set[Variable] = set()
        self.unshared: set[Variable] = set()  # only in the frame, as embedded code defines or assigns them
        self.loop_names: dict[int, list[str]] = {}  # next values of the parameters of loops with frames, by number
        self.mutable: set[str] = set()  # local variables that the program assigns
        self.literals: dict[str, Any] = {}  # values of constants in the source
        self.written = 0
        self.returns_tail = False  # whether the function may request a tail call of its caller
        self.own_checks: list[int] = []  # lines after calls of itself that look for such a request
        self.survey(root)

    # --- preparation ---------------------------------------------------------------------------------------------

    def survey(self, root: Any) -> None:
        """Find the variables that embedded code uses; refuse code that is too long."""
        stack, count = [root], 0
        while stack:
            node = stack.pop()
            count += 1
            if count > _MAX_NODES:
                raise Unsupported
            if type(node) is ast.Lambda:
                continue  # its variables are captured
            loop = self.compiler.analysis.loops.get(id(node))
            if loop is not None:
                stack += [loop.function.body, *loop.start.arguments]
                continue
            if self.is_embedded(node):
                self._survey_embedded(node)
            else:
                stack.extend(children(node))

    def is_embedded(self, node: Any) -> bool:
        if type(node) is ast.Define:
            return isinstance(node.target, tuple)
        return isinstance(node, _EMBEDDED)

    def _survey_embedded(self, root: Any) -> None:
        for node in walk(root):
            if type(node) is ast.Reference and isinstance(node.target, Variable):
                self.embedded.add(node.target)
                if node.target.assigned:
                    self.unshared.add(node.target)
            elif type(node) is ast.Assignment:
                self.unshared.add(node.target)
            elif type(node) is ast.Define:
                self.unshared.update(pattern_variables(node.target))

    # --- whole functions -----------------------------------------------------------------------------------------

    def function(self, node: ast.Lambda, code: ClosureCode) -> Callable[..., Any]:
        plain = code.arity >= 0
        if code.arity > _MAX_ARITY:
            raise Unsupported
        names = [self.fresh("v") for _ in node.parameters]
        self._find_itself(code)
        self.line(f"def g({', '.join(['e', *names]) if plain else 'f'}):")
        self.indent = 1
        self.line("try:")
        self.indent = 2
        looping = plain and self.direct is not None and self._has_self_tail(node.body)
        if looping:
            self.open("while True:")
            self.self_tail = tuple(names)
        place = self.prologue(plain)
        for parameter, name, slot in zip(node.parameters, names, range(1, len(names) + 1)):
            target = parameter.target
            if not plain:
                self.line(f"{name} = f[{slot}]")
            if target is not None and not self.in_frame_only(target):
                self.names[target] = name
                if target.assigned:
                    self.mutable.add(name)
        self.into(node.body, Dest(returns=True))
        self._finish_frame(place, names, plain)
        if not self.returns_tail:
            for number in self.own_checks:
                text = self.lines[number]
                self.lines[number] = text[: len(text) - len(text.lstrip())] + "pass"
        return self._compiled()

    def prologue(self, plain: bool) -> int:
        """Write the creation of the frame; return its line, which is completed when its size is known."""
        self.frames[self.base] = "F" if plain else "f"
        self.line("pass")
        return len(self.lines) - 1

    def _finish_frame(self, place: int, names: Sequence[str], plain: bool) -> None:
        text = self.lines[place]
        assert text.strip() == "pass"
        start = text[: text.index("pass")]
        missing = self.base.size - 1 - len(names)
        if not plain:
            if missing:
                self.lines[place] = f"{start}f.extend({self.constant((None,) * missing)})"
        elif self.uses_frame:
            self.lines[place] = f"{start}F = [{', '.join(['e', *names, *['None'] * missing])}]"

    @property
    def uses_frame(self) -> bool:
        return any(_FRAME.search(line) for line in self.lines)

    def loop(self, loop: Loop, tail: bool) -> Callable[[Frame, int], Any]:
        self.line("def g(f, done):")
        self.indent = 1
        self.line("try:")
        self.indent = 2
        self.frames[self.base] = "f"
        self.preload(loop.function.body)
        parameters = [p.target for p in loop.function.parameters]
        for target in parameters:
            if target is None:
                raise Unsupported
            if not self.in_frame_only(target):
                self.line(f"{self.name_of(target)} = f[{self.base.slots[target]}]")
        dest = Dest(returns=True) if tail else Dest(self.fresh("t"))
        inference = Inference(self)
        self.write_loop(loop, dest, [inference.kind(start) for start in loop.start.arguments], resumed=True)
        if not tail:
            self.line(f"return {dest.name}")
        return self._compiled()

    def expression(self, node: Any) -> Node:
        self.line("def g(f):")
        self.indent = 1
        self.line("try:")
        self.indent = 2
        self.frames[self.base] = "f"
        self.preload(node)
        result = self.fresh("t")
        self.into(node, Dest(result))
        self.line(f"return {result}")
        return self._compiled()

    def preload(self, root: Any) -> None:
        """Read the constant variables of the enclosing code from the frame."""
        bound = {v for node in walk(root) if type(node) is ast.Define for v in pattern_variables(node.target)}
        for node in walk(root):
            target = node.target if type(node) is ast.Reference else None
            if not isinstance(target, Variable) or target.is_global or target in bound or target in self.names:
                continue
            if target.assigned or target.recursive or target not in self.base.slots:
                continue
            self.line(f"{self.name_of(target)} = f[{self.base.slots[target]}]")

    def _compiled(self) -> Callable[..., Any]:
        self.indent = 1
        self.line("except CAUGHT as error:")
        self.indent = 2
        self.line("found = placed(error, SITES)")
        self.line("if found is error:")
        self.line(" raise")
        self.line("raise found from None")
        source = "\n".join(self.lines) + "\n"
        exec(compile(source, "<generated>", "exec", dont_inherit=True), self.constants)  # noqa: S102
        self.rt.units.append(self.constants)
        entry: Callable[..., Any] = self.constants["g"]
        return entry

    def _find_itself(self, code: ClosureCode) -> None:
        for cell in self.compiler.global_cells_of(code):
            self.direct = (cell.value, self.constant(cell))

    def _has_self_tail(self, body: Any) -> bool:
        assert self.direct is not None
        for node in tail_nodes(body, self.compiler.analysis.loops):
            if type(node) is ast.Application and type(node.function) is ast.Reference:
                target = node.function.target
                if isinstance(target, Variable) and self.known_global(target) is self.direct[0]:
                    return len(node.arguments) == self.direct[0].arity
        return False

    # --- lines and names -----------------------------------------------------------------------------------------

    def line(self, text: str, site: Any = None) -> None:
        self.written += 1
        if self.indent > _MAX_INDENT or self.written > _MAX_LINES:
            raise Unsupported
        self.lines.append(" " * self.indent + text)
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
        self.indent -= 1
        self.blocks -= 1

    def fresh(self, letter: str) -> str:
        self.count += 1
        return f"{letter}{self.count}"

    def constant(self, value: Any) -> str:
        """Return the name of a constant of the function."""
        name = self.numbered.get(id(value))
        if name is None:
            name = self.numbered[id(value)] = self.fresh("k")
            self.constants[name] = value
        return name

    def temporary(self, code: Code) -> Code:
        name = self.fresh("t")
        self.line(f"{name} = {code.text}")
        self.kinds[name] = code.kind
        return Code(name, code.kind)

    def named(self, code: Code) -> Code:
        """Return a variable: CPython warns of ``is`` with a literal."""
        return self.temporary(code) if not code.atomic or code.text in self.literals else code

    def atom(self, code: Code) -> Code:
        return code if code.atomic else self.temporary(code)

    def name_of(self, variable: Variable) -> str:
        """Return the name of the local variable of Python for a variable."""
        name = self.names.get(variable)
        if name is None:
            name = self.names[variable] = self.fresh("v")
            if variable.assigned:
                self.mutable.add(name)
        return name

    def kind_of(self, code: Code) -> Kind:
        return self.kinds.get(code.text, code.kind)

    # --- variables -----------------------------------------------------------------------------------------------

    def in_cell(self, variable: Variable) -> bool:
        return variable.assigned and variable.captured

    def in_frame_only(self, variable: Variable) -> bool:
        return self.in_cell(variable) or variable in self.unshared

    def is_stored(self, variable: Variable) -> bool:
        """Whether the frame has a copy of a variable for closures or embedded code."""
        return variable.captured or variable in self.embedded

    def slot_text(self, variable: Variable) -> str:
        """Return the place of a variable in the frames."""
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

    def reference(self, node: ast.Reference) -> Code:
        target = node.target
        if not isinstance(target, Variable):
            return Code(self.constant(target), TRUE)
        if target.is_global:
            return self._global_reference(target, node)
        name = self.names.get(target)
        if name is None:
            text = self.slot_text(target)
            if self.in_cell(target):
                return self._read_cell(text, target, node)
            if target.recursive:
                found = self.temporary(Code(text))
                self._check_defined(found.text, target, node)
                return found
            return self.temporary(Code(text)) if target.assigned else Code(text, ANY, True, False)
        if target.recursive and name not in self.kinds:
            self._check_defined(name, target, node)
        if target.assigned:
            return self.temporary(Code(name))
        return Code(name, self.kinds.get(name, ANY))

    def _check_defined(self, name: str, target: Variable, node: ast.Reference) -> None:
        fail = self.constant(generated.undefined_raiser(self.rt, target.name, node.span))
        self.line(f"if {name} is U: {fail}()")

    def _read_cell(self, text: str, target: Variable, node: ast.Reference) -> Code:
        cell, value = self.fresh("t"), self.fresh("t")
        self.line(f"{cell} = {text}")
        self.line(f"if {cell}.birth < rt.serial: rt.read({cell})")
        self.line(f"{value} = {cell}.value")
        self._check_defined(value, target, node)
        return Code(value)

    def _global_reference(self, target: Variable, node: ast.Reference) -> Code:
        cell = self.compiler.global_cell(target)
        name = self.constant(cell)
        if target.assigned:
            return self._read_cell(name, target, node)
        found = self.temporary(Code(f"{name}.value"))
        if cell.value is UNDEFINED:
            self._check_defined(found.text, target, node)
        return found

    def known_global(self, target: Variable) -> Any:
        """Return the closure that a global variable has now and will have unless it is defined again, or None."""
        if not target.is_global or target.assigned:
            return None
        value = self.compiler.global_cell(target).value
        return value if type(value) is Closure else None

    def bind(self, variable: Variable, text: str, kind: Kind) -> None:
        """Write the definition of a local variable of this function."""
        if self.in_cell(variable):
            frame, slot = self._slot_of(variable)
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

    def _slot_of(self, variable: Variable) -> tuple[str, int]:
        text = self.slot_text(variable)
        frame, _, slot = text.rpartition("[")
        return frame, int(slot[:-1])

    # --- expressions ---------------------------------------------------------------------------------------------

    def value(self, node: Any) -> Code:
        """Write what a node needs, and return the Python expression of its value."""
        kind = type(node)
        if kind is ast.Constant:
            return self._constant(node.value)
        if kind is ast.Reference:
            return self.reference(node)
        if kind is ast.Application and type(node.function) is ast.Reference:
            target = node.function.target
            if isinstance(target, Builtin):
                return self.builtin(target, node)
        simple = _VALUES.get(kind)
        if simple is not None:
            found: Code = simple(self, node)
            return found
        if self.is_embedded(node):
            return self._embed(node)
        if kind is ast.Application:
            return self.call(node)
        name = self.fresh("t")
        result = self.into(node, Dest(name))
        self.kinds[name] = result or ANY
        return Code(name, self.kinds[name])

    def _constant(self, value: Any) -> Code:
        kind = type(value)
        if kind is bool or value is None:
            return Code(self._literal(value), BOOLEAN if kind is bool else ANY)
        if kind is int and abs(value) < 1 << 60:
            return Code(self._literal(value), Kind("i", max(1, value.bit_length())))
        if kind is float and isfinite(value):
            return Code(self._literal(value), FLOAT)
        known = {float: FLOAT, int: INTEGER, str: STRING}.get(kind, TRUE)
        return Code(self.constant(value), known)

    def _literal(self, value: Any) -> str:
        text = repr(value)
        if text[0] == "-":
            text = f"({text})"
        self.literals[text] = value
        return text

    def operands(self, nodes: Sequence[Any], atomic: bool = True) -> list[Code]:
        """Return the values of several nodes, evaluated in order, as names or constants, or pure expressions."""
        found = []
        for node in nodes:
            code = self.value(node)
            found.append(code if code.atomic or (code.pure and not atomic) else self.temporary(code))
        return found

    def _embed(self, node: Any) -> Code:
        run = self.compiler.embedded(node, self.layout)
        return self.temporary(Code(f"{self.constant(run)}({self.frames[self.layout]})"))

    def by_values(self, make: Callable[[list[Node]], Node], nodes: Sequence[Any]) -> Code:
        """Evaluate nodes, and call a closure that expects them as compiled nodes with the list of their values."""
        run = make([itemgetter(i) for i in range(len(nodes))])
        values = self.operands(nodes)
        return self.temporary(Code(f"{self.constant(run)}(({''.join(f'{v.text}, ' for v in values)}))"))

    def _lambda(self, node: ast.Lambda) -> Code:
        code = self.compiler.codes.get(id(node))
        if code is None:
            raise Unsupported
        return self.temporary(Code(f"Closure({self.constant(code)}, {self.frames[self.layout]})", TRUE))

    def _assignment(self, node: ast.Assignment) -> Code:
        value = self.atom(self.value(node.value))
        target = node.target
        if target.is_global or self.in_cell(target):
            store = self.constant(generated.cell_storer(self.rt, target.name, node.span))
            cell = self.constant(self.compiler.global_cell(target)) if target.is_global else self.slot_text(target)
            self.line(f"{store}({cell}, {value.text})")
        elif target in self.names:
            self.line(f"{self.names[target]} = {value.text}")
        else:
            self.line(f"{self.slot_text(target)} = {value.text}")
        return Code("None")

    def _array(self, node: ast.ArrayLiteral) -> Code:
        if all(type(item) is ast.Constant for item in node.items):
            try:
                return Code(self.constant(array_literal([item.value for item in node.items])), TRUE)  # type: ignore[union-attr]
            except SceneError:
                pass  # reported at run time
        if len(node.items) != 3:
            return self.by_values(lambda nodes: calls.array_node(self.rt, nodes, node.span), node.items)
        values = self.operands(node.items)
        texts = [v.text for v in values]
        kinds = [self.kind_of(v) for v in values]
        if all(k.type == "f" for k in kinds) or all(k.type == "i" for k in kinds):
            return self.temporary(Code(f"Vector(({', '.join(texts)}))", TRUE))
        run = self.constant(generated.vector_maker(self.rt, node.span))
        return self.temporary(Code(f"{run}({', '.join(texts)})"))

    def _first(self, node: ast.First) -> Code:
        first = self.temporary(self.value(node.items[0]))
        for item in node.items[1:]:
            self.effect(item)
        return first

    def _transform(self, node: ast.Transform) -> Code:
        part, matrix = self.operands((node.part, node.matrix))
        slow = self.constant(calls.transform_node(self.rt, itemgetter(0), itemgetter(1), node.span))
        test = f"type({part.text}) is Entity and type({matrix.text}) is Matrix and isfinite(sum({matrix.text}))"
        text = f"Pair({part.text}, {matrix.text}) if {test} else {slow}(({part.text}, {matrix.text}))"
        return self.temporary(Code(text, TRUE))

    def _union(self, node: ast.Union) -> Code:
        return self.by_values(lambda nodes: calls.union_node(self.rt, nodes, node), node.members)

    def _union_loop(self, node: ast.UnionLoop) -> Code:
        make = lambda nodes: calls.union_loop_node(self.rt, nodes[0], nodes[1], node.span)
        return self.by_values(make, (node.count, node.function))

    def _bind(self, node: ast.Bind) -> Code:
        make = lambda nodes: calls.bind_node(self.rt, nodes[0], nodes[1], node.span)
        return self.by_values(make, (node.word, node.function))

    def _entity(self, node: ast.Call) -> Code:
        make = lambda nodes: calls.call_node(self.rt, nodes[0], nodes[1:], node)
        return self.by_values(make, (node.word, *calls.call_operands(node)))

    def _handle(self, node: ast.HandleLiteral) -> Code:
        return Code(self.constant(self.rt.handle(node.name)), TRUE)

    # --- tests ---------------------------------------------------------------------------------------------------

    def truth(self, code: Code) -> str:
        """Return the Python condition for whether a value is true."""
        kind = self.kind_of(code)
        if kind.type == "b":
            return code.text
        if code.text in self.literals:
            return repr(code.text != "None")
        if kind.type in "ifnst":
            if not code.pure:
                self.temporary(code)
            return "True"
        name = self.atom(code).text
        return f"({name} is not False and {name} is not None)"

    def test(self, node: Any) -> str:
        """Write what a test needs, and return its Python condition."""
        kind = type(node)
        if kind is ast.Application and type(node.function) is ast.Reference:
            target = node.function.target
            if isinstance(target, Builtin) and target.intrinsic == "not" and len(node.arguments) == 1:
                return f"(not {self.test(node.arguments[0])})"
        if kind in (ast.And, ast.Or) and node.items:
            text = self._joined_test(node)
            if text is not None:
                return text
        return self.truth(self.value(node))

    def _joined_test(self, node: Any) -> str | None:
        """Return the condition of ``and`` or ``or``, if the tests after the first need no statements; else None."""
        lines, kinds, names = len(self.lines), dict(self.kinds), dict(self.names)
        first = self.test(node.items[0])
        start = len(self.lines)
        texts = [first]
        for item in node.items[1:]:
            texts.append(self.test(item))
            if len(self.lines) != start:
                self._roll_back(lines, kinds, names)
                return None
            self.kinds = dict(kinds)
        return "(" + (" and " if type(node) is ast.And else " or ").join(texts) + ")"

    def _roll_back(self, lines: int, kinds: dict[str, Kind], names: dict[Variable, str]) -> None:
        del self.lines[lines:]
        for number in [number for number in self.sites if number > lines]:
            del self.sites[number]
        self.kinds, self.names = kinds, names

    # --- statements ----------------------------------------------------------------------------------------------

    def effect(self, node: Any) -> None:
        self.into(node, NOWHERE)

    def into(self, node: Any, dest: Dest) -> Kind | None:
        """Write a node and send its value to ``dest``; return the kind of the value, or None if there is none."""
        kind = type(node)
        if kind is ast.If:
            return self._if(node, dest)
        if kind is ast.Body:
            return self._body(node, dest)
        if kind is ast.And or kind is ast.Or:
            return self._and_or(node, dest)
        if kind is ast.Application and not (
            type(node.function) is ast.Reference and isinstance(node.function.target, Builtin)
        ):
            return self._application(node, dest)
        if kind is ast.Application and dest.returns and node.function.target.name == "apply":
            run = calls.tail_apply(
                self.rt, node.function.target, [itemgetter(i) for i in range(len(node.arguments))], node.span
            )
            values = self.operands(node.arguments)
            self.returns_tail = True
            code = self.temporary(Code(f"{self.constant(run)}(({''.join(f'{v.text}, ' for v in values)}))"))
            return self.finish(dest, code)
        return self.finish(dest, self.value(node))

    def finish(self, dest: Dest, code: Code) -> Kind:
        """Send a value to its destination, and leave the loops that end with it."""
        kind = self.kind_of(code)
        if dest.loops and not (code.atomic and code.pure):
            code = self.temporary(code)
        if dest.returns:
            self._leave(dest.loops)
            self.line(f"return {code.text}")
            return kind
        if dest.name is not None:
            self.line(f"{dest.name} = {code.text}")
        elif not code.atomic:
            self.line(code.text)
        if dest.loops:
            self._leave(dest.loops)
            if len(dest.loops) > 1:
                self.line("q = 0")
            self.line("break")
        return kind

    def _leave(self, loops: Sequence[LoopCode]) -> None:
        for loop in reversed(loops):
            if loop.counter is not None:
                self.line(f"charge({loop.counter})")

    def _if(self, node: ast.If, dest: Dest) -> Kind | None:
        test = self.test(node.test)
        kinds = dict(self.kinds)
        self.line(f"if {test}:")
        self.indent += 1
        then = self.into(node.then, dest)
        self.line("pass")
        self.indent -= 1
        self.kinds = dict(kinds)
        if not dest.exits:
            if node.otherwise is None and dest.name is None:
                return ANY
            self.line("else:")
            self.indent += 1
        if node.otherwise is None:
            other: Kind | None = self.finish(dest, Code("None"))
        else:
            other = self.into(node.otherwise, dest)
        if not dest.exits:
            self.line("pass")
            self.indent -= 1
        self.kinds = kinds
        return joined(then, other)

    def _and_or(self, node: Any, dest: Dest) -> Kind | None:
        is_and = type(node) is ast.And
        if not node.items:
            return self.finish(dest, Code(repr(is_and), BOOLEAN))
        *tests, last = node.items
        kinds, indent = None, self.indent
        result: Kind | None = None
        for item in tests:
            code = self.value(item)
            if self.kind_of(code).type == "b":
                truth, code = code.text, Code(repr(not is_and), BOOLEAN)
            else:
                code, result = self.atom(code), ANY
                truth = self.truth(code)
            kinds = dict(self.kinds) if kinds is None else kinds
            self.line(f"if not {truth}:" if is_and else f"if {truth}:")
            self.indent += 1
            self.finish(dest, code)
            self.line("pass")
            self.indent -= 1
            if not dest.exits:
                self.line("else:")
                self.indent += 1
        found = self.into(last, dest)
        if self.indent != indent:
            self.line("pass")
        self.indent = indent
        if kinds is not None:
            self.kinds = kinds
        return joined(BOOLEAN if tests and result is None else result, found)

    def _body(self, node: ast.Body, dest: Dest) -> Kind | None:
        loop = self.compiler.analysis.loops.get(id(node))
        if loop is not None:
            return self._loop_body(loop, dest)
        self._prepare(node)
        for item in node.items[:-1]:
            self._define(item) if type(item) is ast.Define else self.effect(item)
        last = node.items[-1]
        if type(last) is ast.Define:
            self._define(last)
            return self.finish(dest, Code("None"))
        return self.into(last, dest)

    def _prepare(self, node: ast.Body) -> None:
        for item in node.items:
            if type(item) is not ast.Define:
                continue
            for variable in pattern_variables(item.target):
                if variable.is_global:
                    raise Unsupported
                self.layout.add(variable)
                if self.in_cell(variable):
                    self.line(f"{self.slot_text(variable)} = Cell(U, rt.clock)")
                elif variable.recursive:
                    if variable in self.unshared:
                        self.line(f"{self.slot_text(variable)} = U")
                        continue
                    name = self.name_of(variable)
                    self.kinds.pop(name, None)
                    self.line(f"{name} = U")
                    if self.is_stored(variable):
                        self.line(f"{self.slot_text(variable)} = U")

    def _define(self, node: ast.Define) -> None:
        if self.is_embedded(node):
            self._embed(node)
            return
        if node.target is None:
            self.effect(node.value)
            return
        code = self.value(node.value)
        self.bind(node.target, code.text, self.kind_of(code))

    # --- loops ---------------------------------------------------------------------------------------------------

    def _loop_body(self, loop: Loop, dest: Dest) -> Kind | None:
        function = loop.function
        region = self.compiler.analysis.regions[id(function)]
        starts = self.operands(loop.start.arguments)
        parameters = [p.target for p in function.parameters]
        if any(p is None for p in parameters):
            raise Unsupported
        kinds = [self.kind_of(code) for code in starts]
        if region.has_frame:
            return self._framed_loop(loop, dest, starts)
        for variable, code in zip(parameters, starts):
            self.layout.add(variable)
            self._set_parameter(variable, code.text)
        return self.write_loop(loop, dest, kinds)

    def _set_parameter(self, variable: Variable, text: str) -> None:
        if self.in_frame_only(variable):
            if self.in_cell(variable):
                raise Unsupported
            self.line(f"{self.slot_text(variable)} = {text}")
            return
        name = self.name_of(variable)
        self.line(f"{name} = {text}")
        if self.is_stored(variable):
            self.line(f"{self.slot_text(variable)} = {name}")

    def write_loop(self, loop: Loop, dest: Dest, kinds: Sequence[Kind], resumed: bool = False) -> Kind | None:
        """Write a loop whose parameters have their first values; ``kinds`` are those of the values."""
        parameters = [p.target for p in loop.function.parameters]
        known = Inference(self).loop(loop, kinds)
        counter = self.fresh("n")
        record = LoopCode(loop.variable, loop.function, counter, self.fresh_number())
        before = dict(self.kinds)
        if resumed:
            self.line(f"turns = range(done + 1, {_BLOCK + 1})")
        self.open("while True:")
        self.open(f"for {counter} in turns:" if resumed else f"for {counter} in BLOCK:")
        for variable, kind in zip(parameters, known):
            name = self.names.get(variable)
            if name is not None and not variable.assigned:
                self.kinds[name] = kind
        inner = Dest(dest.name, dest.returns, (*dest.loops, record))
        result = self.into(loop.function.body, inner)
        self.close()
        self.line("else:")
        self.indent += 1
        self.line(f"spend({_BLOCK})")
        if resumed:
            self.line("turns = BLOCK")
        self.line("continue")
        self.indent -= 1
        self.line("break")
        self.close()
        self.kinds = before
        self._after_loop(record, dest)
        return result

    def fresh_number(self) -> int:
        self.count += 1
        return self.count

    def _after_loop(self, record: LoopCode, dest: Dest) -> None:
        """Write what follows an inner loop in the tail of an outer one: its value leaves, or the outer continues."""
        if not dest.loops:
            return
        parent = dest.loops[-1]
        if record.is_left:
            self.line(f"if q == {parent.number}: continue")
        self.line("break")

    def _framed_loop(self, loop: Loop, dest: Dest, starts: Sequence[Code]) -> Kind | None:
        """Write a loop with a frame for each turn, because closures capture its variables."""
        function = loop.function
        layout = self.compiler.layouts.get(id(function))
        if layout is None or layout.parent is not self.layout:
            raise Unsupported
        parameters = [p.target for p in function.parameters]
        names = [self.fresh("p") for _ in parameters]
        for name, code in zip(names, starts):
            self.line(f"{name} = {code.text}")
        record = LoopCode(loop.variable, function, None, self.fresh_number())
        self.loop_names[record.number] = names
        before, outer = dict(self.kinds), self.layout
        self.open("while True:")
        self.line("next(ticks)")
        frame = self.frames[layout] = self.fresh("F")
        self.line("pass")
        place = len(self.lines) - 1
        self.layout = layout
        for variable, name in zip(parameters, names):
            self.bind(variable, name, ANY)
        result = self.into(function.body, Dest(dest.name, dest.returns, (*dest.loops, record)))
        self.layout = outer
        self.lines[place] = self.lines[place].replace(
            "pass", f"{frame} = [{self.frames[outer]}{', None' * (layout.size - 1)}]"
        )
        self.close()
        self.kinds = before
        self._after_loop(record, dest)
        return result

    def _next_turn(self, node: ast.Application, dest: Dest, index: int) -> None:
        """Write the continuation of a loop that ends with ``dest``; inner loops are left."""
        record = dest.loops[index]
        values = self.operands(node.arguments, atomic=False)
        if record.counter is None:
            targets = self.loop_names[record.number]
            self.line(f"{', '.join(targets)} = {', '.join(v.text for v in values)}" if targets else "pass")
        else:
            self._assign_parameters(record, values)
        inner = dest.loops[index + 1 :]
        self._leave(inner)
        if not inner:
            self.line("continue")
            return
        for loop in inner:
            loop.is_left = True
        self.line(f"q = {record.number}")
        self.line("break")

    def _assign_parameters(self, record: LoopCode, values: Sequence[Code]) -> None:
        targets, texts, slots = [], [], []
        for parameter, value in zip(record.function.parameters, values):
            variable = parameter.target
            if self.in_frame_only(variable):
                targets.append(self.slot_text(variable))
                texts.append(value.text)
                continue
            name = self.names[variable]
            if name != value.text:
                targets.append(name)
                texts.append(value.text)
                if self.is_stored(variable):
                    slots.append(f"{self.slot_text(variable)} = {name}")
        if targets:
            self.line(f"{', '.join(targets)} = {', '.join(texts)}")
        for text in slots:
            self.line(text)

    # --- calls of procedures -------------------------------------------------------------------------------------

    def _application(self, node: ast.Application, dest: Dest) -> Kind | None:
        head = node.function
        target = head.target if type(head) is ast.Reference else None
        for index, loop in enumerate(dest.loops):
            if loop.variable is target:
                self._next_turn(node, dest, index)
                return None
        if dest.returns:
            self._tail_call(node, dest)
            return ANY
        return self.finish(dest, self.call(node))

    def _head(self, node: ast.Application) -> tuple[Code | None, str, Any]:
        """Return the function of a call if it is evaluated first, or the cell of a global, and its closure if known."""
        head = node.function
        target = head.target if type(head) is ast.Reference else None
        if isinstance(target, Variable) and target.is_global and not target.assigned:
            return None, self.constant(self.compiler.global_cell(target)), self.known_global(target)
        return self.atom(self.value(head)), "", None

    def _global_head(self, node: ast.Application) -> Any:
        head = node.function
        if type(head) is ast.Reference and isinstance(head.target, Variable):
            return calls.GlobalHead(None, head.target.name, head.span)  # type: ignore[arg-type]
        return None

    def call(self, node: ast.Application) -> Code:
        """Write a call that is not in tail position."""
        head, cell, known = self._head(node)
        values = self.operands(node.arguments, atomic=False)
        result = self.fresh("t")
        texts = [v.text for v in values]
        if known is not None and known.arity == len(values):
            self._known_call(result, cell, known, texts, node)
            return Code(result)
        function = self.fresh("p")
        self.line(f"{function} = {cell}.value" if head is None else f"{function} = {head.text}")
        site = CallSite(Local(function), node.span)
        call = ", ".join([f"{function}.code.entry({function}.env", *texts])
        test = f"type({function}) is Closure and {function}.arity == {len(values)} and next(ticks) is None"
        other = self.constant(generated.caller(self.rt, self._global_head(node), node.span))
        arguments = "".join(f"{text}, " for text in texts)
        self.line(f"{result} = {call}) if {test} else {other}({function}, ({arguments}))", site)
        self.line(f"if {result} is TAIL: {result} = bounce()", site)
        return Code(result)

    def _known_call(self, result: str, cell: str, known: Closure, texts: Sequence[str], node: ast.Application) -> None:
        """Write a call of a global function that is known, unless it is defined again."""
        code = known.code
        itself = self.direct is not None and known is self.direct[0]
        callee = "g" if itself else self.constant(code.direct) if code.direct else f"{self.constant(code)}.entry"
        site = CallSite(self.constants[cell], node.span)
        call = ", ".join([f"{callee}({self.constant(known.env)}", *texts])
        other = self._other(cell, node)
        test = f"{cell}.value is {self.constant(known)} and next(ticks) is None"
        self.line(f"{result} = {call}) if {test} else {other}({', '.join(texts)})", site)
        if itself:
            self.own_checks.append(len(self.lines))
        if itself or code.direct is None or code.returns_tail:
            self.line(f"if {result} is TAIL: {result} = bounce()", site)

    def _other(self, cell: str, node: ast.Application) -> str:
        """Return the constant that calls whatever a global variable is when it is called."""
        return self.constant(generated.global_caller(self.rt, self.constants[cell], self._global_head(node), node.span))

    def _tail_call(self, node: ast.Application, dest: Dest) -> None:
        head, cell, known = self._head(node)
        values = self.operands(node.arguments, atomic=False)
        function = self.fresh("p")
        found = f"{cell}.value" if head is None else head.text
        itself = self.direct is not None and known is self.direct[0] and self.self_tail is not None
        if itself and not dest.loops and known.arity == len(values):
            self.line(f"if {found} is {self.constant(known)}:")
            self.indent += 1
            self._assign_own(values)
            self.line("next(ticks)")
            self.line("continue")
            self.indent -= 1
            # The function is defined again: a single call that is not a tail call.
            site = CallSite(self.constants[cell], node.span)
            self.line(f"return {self._other(cell, node)}({', '.join(v.text for v in values)})", site)
            return
        self.returns_tail = True
        self.line(f"{function} = {found}")
        self.line(f"if type({function}) is Closure and {function}.arity == {len(values)}:")
        self.indent += 1
        self.line(f"rt.next_body = {function}.code.body")
        self.line(f"rt.next_frame = [{function}.env{''.join(f', {v.text}' for v in values)}]")
        self._leave(dest.loops)
        self.line("return TAIL")
        self.indent -= 1
        result = self.fresh("t")
        other = self.constant(generated.tail_caller(self.rt, self._global_head(node), node.span))
        self.line(f"{result} = {other}({function}, ({''.join(f'{v.text}, ' for v in values)}))")
        self._leave(dest.loops)
        self.line(f"return {result}")

    def _assign_own(self, values: Sequence[Code]) -> None:
        assert self.self_tail is not None
        pairs = [(name, v.text) for name, v in zip(self.self_tail, values) if name != v.text]
        if pairs:
            self.line(f"{', '.join(name for name, _ in pairs)} = {', '.join(text for _, text in pairs)}")

    # --- builtins ------------------------------------------------------------------------------------------------

    def builtin(self, builtin: Builtin, node: ast.Application) -> Code:
        if builtin.intrinsic is not None:
            code = self._intrinsic(builtin, builtin.intrinsic, node)
            if code is not None:
                return code
        signature = builtin.signature
        parameters = (*signature.required, *signature.optional)
        count = len(node.arguments)
        few = count < len(signature.required) or (count > len(parameters) and signature.rest is None)
        if signature.keywords or few or count > _MIN_CHARGED:
            make = lambda nodes: calls.builtin_call(self.rt, builtin, nodes, node.span)
            return self.by_values(make, node.arguments)
        values = self.operands(node.arguments)
        if builtin.name == "list" and signature.rest is not None and count <= 4:
            return self._list(values)
        return self._checked_call(builtin, node, values)

    def _list(self, values: Sequence[Code]) -> Code:
        text = "NIL"
        for value in reversed(values):
            text = f"Pair({value.text}, {text})"
        return self.temporary(Code(text, TRUE))

    def _checked_call(self, builtin: Builtin, node: ast.Application, values: Sequence[Code]) -> Code:
        signature = builtin.signature
        parameters = (*signature.required, *signature.optional)
        checks, texts, given = [], [], []
        for index, value in enumerate(values):
            parameter = parameters[index] if index < len(parameters) else signature.rest
            assert parameter is not None
            is_checked = not builtin.checks_arguments and parameter.type.is_checked
            check = parameter.type.checker(self.rt) if is_checked else None
            checks.append(check)
            needs = check is not None and not self._fits(parameter.type.name, value)
            texts.append(self._checked(parameter.type.name, check, value) if needs else value.text)
            given.append(self._operand(value.text))
        site = BuiltinSite(builtin, tuple(checks), tuple(given), node.span)
        name = self.fresh("t")
        self.line(f"{name} = {self.constant(builtin.function)}(rt{''.join(f', {t}' for t in texts)})", site)
        kind = _RESULTS.get(builtin.result, ANY)
        self.kinds[name] = kind
        return Code(name, kind)

    def _checked(self, expected: str, check: Any, value: Code) -> str:
        """Return the Python expression for the converted argument of a builtin."""
        test, text = _FITTING.get(expected), f"{self.constant(check)}({value.text})"
        if value.text in self.literals:
            return text
        return f"{value.text} if {test.format(value.text)} else {text}" if test is not None else text

    def _operand(self, text: str) -> Any:
        if text in self.literals:
            return self.literals[text]
        return self.constants[text] if text in self.constants else Local(text)

    def _fits(self, expected: str, value: Code) -> bool:
        kind = self.kind_of(value).type
        if kind == "s":
            return expected in ("String", "Word")
        return (kind == "i" and expected in ("Integer", "Float", "Number")) or (
            kind in ("f", "n") and expected in ("Float", "Number")
        )

    def slow(self, builtin: Builtin, node: ast.Application) -> Callable[[Any, Any], Any]:
        slow = calls.slow_call(self.rt, builtin, node.span)
        return lambda x, y: slow([x, y])

    def _intrinsic(self, builtin: Builtin, name: str, node: ast.Application) -> Code | None:
        operands = node.arguments
        if len(operands) == 1 and name in _UNARY:
            return self._unary(builtin, name, node)
        if name == "cons" and len(operands) == 2:
            x, y = self.operands(operands)
            slow = self.constant(self.slow(builtin, node))
            text = f"Pair({x.text}, {y.text}) if type({y.text}) is not MutableList else {slow}({x.text}, {y.text})"
            return self.temporary(Code(text, TRUE))
        if name not in _BINARY:
            return None
        if len(operands) > 2 and name in ("add", "mul", "matmul"):
            nested = ast.Application(node.function, operands[:-1], node.span)
            return self._intrinsic(builtin, name, ast.Application(node.function, (nested, operands[-1]), node.span))
        if len(operands) != 2:
            return None
        x, y = self.operands(operands)
        slow = self.slow(builtin, node)
        if name in _COMPARISONS:
            return self._comparison(_OPERATORS[name], x, y, self.constant(slow))
        if name == "matmul":
            text = f"compose({x.text}, {y.text}) if type({x.text}) is type({y.text}) is Matrix else "
            return self.temporary(Code(f"{text}{self.constant(slow)}({x.text}, {y.text})"))
        if name == "div":
            return self._division(x, y, self.constant(generated.divider(slow)))
        if name in ("floordiv", "mod"):
            return self._integer_division(name, x, y, self.constant(slow))
        return self._arithmetic(name, x, y, self.constant(generated.ARITHMETIC[name](slow)))

    def _unary(self, builtin: Builtin, name: str, node: ast.Application) -> Code:
        if name == "not":
            return Code(f"(not {self.test(node.arguments[0])})", BOOLEAN, True, False)
        x = self.named(self.value(node.arguments[0])).text
        call = calls.slow_call(self.rt, builtin, node.span)
        slow = self.constant(lambda value: call([value]))
        if name == "null?":
            return Code(f"({x} is NIL or (type({x}) is not Pair and {slow}({x})))", BOOLEAN, False, False)
        field = name
        return Code(f"({x}.{field} if type({x}) is Pair else {slow}({x}))", ANY, False, False)

    def _is_number(self, code: Code) -> str:
        """Return the Python condition for whether a value is a number; empty if it is known to be one."""
        if self.kind_of(code).type in "ifn":
            return ""
        return f"(type({code.text}) is int or type({code.text}) is float)"

    def _comparison(self, operator: str, x: Code, y: Code, slow: str) -> Code:
        tests = [test for test in (self._is_number(x), self._is_number(y)) if test]
        text = f"{x.text} {operator} {y.text}"
        for code in (x, y):
            if code.text[0] in "vt" and code.text not in self.mutable and self.kind_of(code).type not in "ifn":
                self.kinds[code.text] = NUMBER
        if not tests:
            return Code(f"({text})", BOOLEAN, True, False)
        test = " and ".join(tests)
        return Code(f"({text} if {test} else {slow}({x.text}, {y.text}))", BOOLEAN, False, False)

    def _arithmetic(self, name: str, x: Code, y: Code, slow: str) -> Code:
        operator, left, right = _OPERATORS[name], self.kind_of(x), self.kind_of(y)
        text = f"({x.text} {operator} {y.text})"
        kind = arithmetic_kind(name, left, right)
        if kind.type == "f" and self._safe_float(left) and self._safe_float(right):
            return Code(text, FLOAT, True, False)
        if kind.type == "i" and 0 < kind.bits <= _MAX_BITS:
            return Code(text, kind, True, False)
        if kind.type in "in" and name != "mul" and self._is_small(left, right):
            return Code(text, kind, True, False)  # grows by a constant per step, so the step limit bounds it
        result = self.fresh("t")
        self._guarded_arithmetic(result, operator, x, y, slow)
        self.kinds[result] = kind
        return Code(result, kind)

    def _safe_float(self, kind: Kind) -> bool:
        """Whether the conversion of a number to a Float cannot overflow."""
        return kind.type == "f" or (kind.type == "i" and 0 < kind.bits <= _MAX_BITS)

    def _is_small(self, left: Kind, right: Kind) -> bool:
        return any(k.type == "i" and 0 < k.bits <= 64 for k in (left, right))

    def _guarded_arithmetic(self, result: str, operator: str, x: Code, y: Code, slow: str) -> None:
        text = f"{x.text} {operator} {y.text}"
        left, right = self.kind_of(x).type, self.kind_of(y).type
        fallback = f"{result} = {slow}({x.text}, {y.text})"
        ints = self._types("int", "i", x, y)
        floats = self._types("float", "f", x, y)
        keyword = "if"
        if "i" in (left, right) and self._is_small(self.kind_of(x), self.kind_of(y)) and operator != "*":
            numbers = " and ".join(test for test in (self._is_number(x), self._is_number(y)) if test)
            self.line(f"if {numbers or 'True'}: {result} = {text}")
            keyword = "elif"
        elif left in "?ni" and right in "?ni":
            self.line(f"if {ints}:")
            self.line(f" {result} = {text}")
            self.line(f" if {result} > {_SMALL} or {result} < -{_SMALL}: {fallback}")
            keyword = "elif"
        if left in "?nf" and right in "?nf":
            self.line(f"{keyword} {floats}: {result} = {text}")
            keyword = "elif"
        if keyword == "elif":
            self.line(f"else: {fallback}")
        else:
            self.line(fallback)

    def _types(self, python: str, letter: str, *codes: Code) -> str:
        tests = [f"type({c.text}) is {python}" for c in dict.fromkeys(codes) if self.kind_of(c).type != letter]
        return " and ".join(tests) or "True"

    def _division(self, x: Code, y: Code, slow: str) -> Code:
        left, right = self.kind_of(x), self.kind_of(y)
        if self._safe_float(left) and self._safe_float(right):
            text = f"({x.text} / {y.text} if {y.text} else {slow}({x.text}, {y.text}))"
            return Code(text, FLOAT, False, False)
        tests = [f"type({c.text}) is float" for c in (x, y) if not self._safe_float(self.kind_of(c))]
        test = " and ".join([*tests, y.text])
        return self.temporary(Code(f"{x.text} / {y.text} if {test} else {slow}({x.text}, {y.text})"))

    def _integer_division(self, name: str, x: Code, y: Code, slow: str) -> Code:
        left, right = self.kind_of(x), self.kind_of(y)
        operator = "//" if name == "floordiv" else "%"
        tests = [f"type({c.text}) is int" for c in (x, y) if self.kind_of(c).type != "i"]
        test = " and ".join([*tests, y.text])
        kind = ANY
        if left.type == right.type == "i":
            kind = Kind("i", left.bits if name == "floordiv" else right.bits)
        elif left.type in "ifn" and right.type in "ifn":
            kind = NUMBER
        return self.temporary(Code(f"{x.text} {operator} {y.text} if {test} else {slow}({x.text}, {y.text})", kind))


_UNARY = frozenset({"not", "car", "cdr", "null?"})
_BINARY = frozenset({*_OPERATORS, "div", "floordiv", "mod", "matmul"})
_FITTING = {  # types whose conversion of fitting values does nothing
    "String": "type({0}) is str", "Word": "type({0}) is str", "Integer": "type({0}) is int",
    "Float": "type({0}) is float or type({0}) is int", "Number": "type({0}) is float or type({0}) is int",
    "List": "type({0}) is Pair or {0} is NIL", "Vector": "type({0}) is Vector",
    "Point": "type({0}) is Vector and len({0}) == 3", "Matrix": "type({0}) is Matrix",
}  # fmt: skip
_RESULTS = {"Boolean": BOOLEAN, "String": STRING, "List": TRUE, "Matrix": TRUE, "Vector": TRUE}
_VALUES: dict[type, Any] = {
    ast.Lambda: _Writer._lambda, ast.Assignment: _Writer._assignment, ast.ArrayLiteral: _Writer._array,
    ast.First: _Writer._first, ast.Transform: _Writer._transform, ast.Union: _Writer._union,
    ast.UnionLoop: _Writer._union_loop, ast.Bind: _Writer._bind, ast.Call: _Writer._entity,
    ast.HandleLiteral: _Writer._handle,
}  # fmt: skip


def arithmetic_kind(name: str, left: Kind, right: Kind) -> Kind:
    """Return the kind of a sum, difference or product."""
    if left.type == right.type == "i":
        if not (left.bits and right.bits):
            return INTEGER
        bits = left.bits + right.bits if name == "mul" else max(left.bits, right.bits) + 1
        return Kind("i", bits if bits <= _MAX_BITS else 0)
    if left.type in "ifn" and right.type in "ifn":
        return FLOAT if "f" in (left.type, right.type) else NUMBER
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


class Inference:
    """Inference of the kinds of a loop's parameters, from their first values and all continuations of the loop.

    The bits of an Integer are bounded where a continuation adds a constant: there are fewer than 2^64 turns. Next, they
    are bounded where it adds a bounded number.
    """

    def __init__(self, writer: _Writer) -> None:
        self.writer = writer
        self.known: dict[Variable, Kind] = {}

    def loop(self, loop: Loop, starts: Sequence[Kind]) -> list[Kind]:
        parameters = [p.target for p in loop.function.parameters]
        turns: list[tuple[Any, ...]] = []
        plain = self._continuations(loop.function.body, loop.variable, turns)
        if not plain:
            return [ANY] * len(parameters)
        types = [Kind(k.type) if not p.assigned else ANY for p, k in zip(parameters, starts)]
        for _ in range(len(parameters) + 2):
            self.known.update(zip(parameters, types))
            found = [
                joined_types(kind, [self.kind(arguments[i]) for arguments in turns]) for i, kind in enumerate(types)
            ]
            if found == types:
                break
            types = found
        else:
            return [ANY] * len(parameters)
        self._bound(parameters, types, starts, turns)
        return [self.known[p] for p in parameters]

    def _continuations(self, body: Any, variable: Variable, found: list[tuple[Any, ...]]) -> bool:
        for node in walk(body):
            if type(node) is ast.Application and type(node.function) is ast.Reference:
                if node.function.target is variable:
                    found.append(node.arguments)
        return True

    def _bound(
        self,
        parameters: Sequence[Variable],
        types: Sequence[Kind],
        starts: Sequence[Kind],
        turns: list[tuple[Any, ...]],
    ) -> None:
        self.known.update(zip(parameters, types))
        for _ in parameters:
            for index, variable in enumerate(parameters):
                kind = self.known[variable]
                if kind.type != "i" or kind.bits or not starts[index].bits:
                    continue
                steps = [self._step(arguments[index], variable) for arguments in turns]
                if all(step > 0 for step in steps):
                    bits = max([starts[index].bits, *steps]) + 65
                    if bits <= _MAX_BITS:
                        self.known[variable] = Kind("i", bits)

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
        kind = self.kind(node)
        return kind.bits if kind.type == "i" else 0

    def kind(self, node: Any) -> Kind:
        kind = type(node)
        if kind is ast.Constant:
            return self.writer._constant(node.value).kind
        if kind is ast.Reference:
            if node.target in self.known:
                return self.known[node.target]
            name = self.writer.names.get(node.target) if isinstance(node.target, Variable) else None
            return self.writer.kinds.get(name, ANY) if name is not None else ANY
        if kind is ast.If and node.otherwise is not None:
            return joined(self.kind(node.then), self.kind(node.otherwise))
        if kind is ast.Application and type(node.function) is ast.Reference and len(node.arguments) == 2:
            target = node.function.target
            name = target.intrinsic if isinstance(target, Builtin) else None
            if name in ("add", "sub", "mul"):
                return arithmetic_kind(name, self.kind(node.arguments[0]), self.kind(node.arguments[1]))
        return ANY


def joined_types(kind: Kind, others: Sequence[Kind]) -> Kind:
    found: Kind = kind
    for other in others:
        found = joined(found, Kind(other.type))
    return Kind(found.type)
