"""What remains of evaluated functions: expressions and statements of the helper API, and loops."""

from __future__ import annotations

import ast
import copy
import itertools
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from scenelang.interpreter.transpile.evaluation import UnsupportedPython, check_widths, weigh
from scenelang.interpreter.transpile.evaluation.modules import Elapsed
from scenelang.interpreter.transpile.evaluation.objects import (
    MISSING,
    BoundMethod,
    Evaluating,
    IntMember,
    Native,
    PythonObject,
    TextMember,
    ValueObject,
    type_name,
)

# Steps for each residual value, whose expression is walked, held, named and written. With 16, programs that make much
# residual code take 3 to 15 microseconds a step (with none, up to 60), where plain loops take 1.3; with 64, up to 3, so
# that the limit of steps takes about 10 s of CPU whatever the program does.
_STEPS_OF_RESIDUAL = 64


_Error = TypeVar("_Error", bound=Exception)


class Holder(Protocol):
    """What residual values need of the function that is being written."""

    loops: Any

    def hold(self, value: Residual) -> Residual:
        """Return a residual value that is computed once."""
        ...

    def tick(self, count: int) -> None:
        """Count steps of the evaluation."""
        ...


class Poison:
    """Value of a variable after a loop that has assigned it; nobody may read it."""


class Known:
    """Values of a residual value in the turns of a loop; ``row`` computes the one of a turn when it is asked for."""

    def __init__(self, loop: Any, row: Callable[[int], Any]) -> None:
        self.loop, self._compute = loop, row
        self._rows: dict[int, Any] = {}

    def row(self, number: int) -> Any:
        """Return the value in a turn."""
        if number not in self._rows:
            self._rows[number] = self._compute(number)
        return self._rows[number]

    def values(self) -> list[Any]:
        """Return the values in all turns."""
        return [self.row(number) for number in range(self.loop.count)]


def known_result(function: Callable[..., Any], operands: tuple[Any, ...]) -> Known | None:
    """Return the values of a function of values that are known in the turns of one loop, else None."""
    loop = None
    for each in residuals(operands):
        if each.known is None or (loop is not None and each.known.loop is not loop):
            return None
        loop = each.known.loop
    return None if loop is None else Known(loop, lambda number: function(*(_row(each, number) for each in operands)))


def _row(value: Any, number: int) -> Any:
    """Return a value as it is in a turn of a loop."""
    if type(value) is Residual:
        return value.known.row(number) if value.known is not None else value
    if type(value) in (tuple, list) and has_residual(value):
        return type(value)(_row(each, number) for each in value)
    if isinstance(value, np.ndarray) and value.dtype == object and has_residual(value):
        return np.array([_row(each, number) for each in value.ravel().tolist()]).reshape(value.shape)
    return value


@dataclass(slots=True, eq=False)
class Residual:
    """Value that is known when the translated program runs: an expression of Python.

    ``kind`` is "shape", "pose", "array", "int", "float", "number" (one of both, or numpy's), "bool" or "any"; ``name``
    is its variable in the residual program. ``primitives`` returns those of a shape, if they are known; ``size`` is the
    length of an array, if it is.
    """

    node: ast.expr
    kind: str
    holder: Holder
    name: str = ""
    primitives: Callable[[], list[Residual]] | None = None
    known: Known | None = None
    size: int | None = None
    python_name: ClassVar[str] = "list"

    def __post_init__(self) -> None:
        self.holder.tick(_STEPS_OF_RESIDUAL)

    def __bool__(self) -> bool:
        if self.kind == "shape":
            return self.primitives is None or bool(self.primitives())
        if self.known is None or not is_decided(self):
            raise undecided(self)
        return bool(self.known.row(0))

    def __getitem__(self, index: Any) -> Residual:
        return self.parts()[index] if self.kind == "shape" else residual(self.holder, "item", (self, index))

    def __iter__(self) -> Iterator[Residual]:
        if self.kind != "shape":
            raise UnsupportedPython("the length of a random value is not known here")
        return iter(self.parts())

    def parts(self) -> list[Residual]:
        """Return the primitives of a shape."""
        if self.primitives is None:
            raise UnsupportedPython("the primitives of this shape cannot be taken apart here")
        return self.primitives()

    def __hash__(self) -> int:
        if self.kind != "shape":
            raise undecided(self)
        return id(self) >> 4

    def __eq__(self, other: object) -> Any:
        if self is other or (self.kind != "any" and (other is None or isinstance(other, str))):
            return self is other
        if self.kind == "shape":
            raise UnsupportedPython("shapes cannot be compared here")
        return residual(self.holder, "eq", (self, other))

    def __ne__(self, other: object) -> Any:
        result = self.__eq__(other)
        return not result if isinstance(result, bool) else residual(self.holder, "ne", (self, other))

    def __str__(self) -> str:
        raise because(UnsupportedPython("a value of the finished scene cannot be part of a text here"), (self,))

    __repr__ = __str__

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)


Residual.__array_ufunc__ = None  # type: ignore[attr-defined]
Residual.__iadd__ = lambda self, other: self.holder.extended(self, other)  # type: ignore
_OPERATORS: dict[str, type[ast.operator]] = {
    "add": ast.Add, "sub": ast.Sub, "mul": ast.Mult, "truediv": ast.Div, "floordiv": ast.FloorDiv, "mod": ast.Mod,
    "pow": ast.Pow, "matmul": ast.MatMult,
}  # fmt: skip
_COMPARED: dict[str, type[ast.cmpop]] = {
    "lt": ast.Lt, "le": ast.LtE, "gt": ast.Gt, "ge": ast.GtE, "eq": ast.Eq, "ne": ast.NotEq,
}  # fmt: skip


def has_kind(value: Any, *kinds: str) -> bool:
    """Return whether a value is residual and of one of some kinds."""
    return type(value) is Residual and value.kind in kinds


def is_decided(value: Residual) -> bool:
    """Return whether a value is true, or false, in all turns of a loop."""
    return value.known is not None and len({bool(each) for each in value.known.values()}) == 1


def is_open(value: Any) -> bool:
    """Return whether a value is true in some turns of a loop only."""
    return type(value) is Residual and value.known is not None and not is_decided(value)


def is_identity(value: Any) -> bool:
    """Return whether a value is the identity matrix."""
    return (
        isinstance(value, np.ndarray)
        and value.shape == (4, 4)
        and value.dtype != object
        and bool((value == np.eye(4)).all())
    )


def is_shape(value: Any) -> bool:
    """Return whether a value is a shape of the finished scene."""
    return type(value) is Residual and value.kind == "shape"


def residual(holder: Holder, operation: str, operands: tuple[Any, ...]) -> Residual:
    """Return the residual result of an operation: an operator's name, "item", "neg" or "abs"."""
    if operation == "matmul":
        for one, other in (operands, operands[::-1]):
            if is_identity(one) and has_kind(other, "pose"):
                return other  # type: ignore[no-any-return]
    function = _FUNCTIONS.get(operation) or getattr(operator, operation)
    known = known_result(function, operands)
    if operation in _COMPARED and any(map(_is_object, operands)):  # which has no literal of its own
        if known is None:
            raise UnsupportedPython("objects of different loops cannot be compared here")
        return holder.loops.general(known.loop, known.values(), "value")  # type: ignore[no-any-return]
    result = _residual(holder, operation, operands)
    result.known = known
    return result


def _is_object(value: Any) -> bool:
    if type(value) is Residual and value.known is not None and value.kind == "any":
        return any(type(each) is PythonObject for each in value.known.values())
    return type(value) is PythonObject


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "item": operator.getitem, "abs": abs, "not": operator.not_, "and": lambda *each: all(each),
    "or": lambda *each: any(each),
}  # fmt: skip


def _residual(holder: Holder, operation: str, operands: tuple[Any, ...]) -> Residual:
    """Return the residual expression of an operation, with the kind of its result."""
    nodes = [node_of(each) for each in operands]
    kinds = [each.kind for each in operands if type(each) is Residual]
    if operation == "item":
        kind = operands[0].kind if operands[0].kind in ("int", "float") else "any"
        return Residual(ast.Subscript(nodes[0], nodes[1], ast.Load()), kind, holder)
    if operation == "not":
        return Residual(ast.UnaryOp(ast.Not(), nodes[0]), "bool", holder)
    if operation in ("and", "or"):
        return Residual(ast.BoolOp(ast.And() if operation == "and" else ast.Or(), nodes), "bool", holder)
    if operation == "neg":
        return Residual(ast.UnaryOp(ast.USub(), nodes[0]), kinds[0], holder)
    if operation == "abs":
        return Residual(call_node("abs", nodes), kinds[0], holder)
    if operation in _COMPARED:
        return Residual(ast.Compare(nodes[0], [_COMPARED[operation]()], [nodes[1]]), "bool", holder)
    if "bool" in kinds:
        raise UnsupportedPython("arithmetic with a condition that is not known is not supported here")
    kind = "pose" if "pose" in kinds and operation == "matmul" else "array" if _has_array(operands) else "number"
    return Residual(ast.BinOp(nodes[0], _OPERATORS[operation](), nodes[1]), kind, holder)


def _has_array(operands: tuple[Any, ...]) -> bool:
    return any(
        isinstance(each, np.ndarray) or (type(each) is Residual and each.kind in ("array", "pose")) for each in operands
    )


def _residual_operation(name: str, *, is_reflected: bool) -> Callable[[Residual, Any], Any]:
    def operation(self: Residual, other: Any) -> Any:
        if self.kind == "shape":
            if name != "add" or not (type(other) is list or is_shape(other)):
                return NotImplemented
            return [other, self] if is_reflected else [self, other]
        if isinstance(other, (PythonObject, list, str)) or (isinstance(other, tuple) and name != "matmul"):
            return NotImplemented
        return residual(self.holder, name, (other, self) if is_reflected else (self, other))

    return operation


for _name in _OPERATORS:
    setattr(Residual, f"__{_name}__", _residual_operation(_name, is_reflected=False))
    setattr(Residual, f"__r{_name}__", _residual_operation(_name, is_reflected=True))
for _name in ("lt", "le", "gt", "ge"):
    setattr(Residual, f"__{_name}__", lambda self, other, _name=_name: residual(self.holder, _name, (self, other)))
for _name in ("neg", "abs"):
    setattr(Residual, f"__{_name}__", lambda self, _name=_name: residual(self.holder, _name, (self,)))


def call_node(path: str, arguments: list[ast.expr], named: dict[str, ast.expr] | None = None) -> ast.Call:
    """Return a call of a function by its dotted name."""
    first, *rest = path.split(".")
    function: ast.expr = ast.Name(first, ast.Load())
    for name in rest:
        function = ast.Attribute(function, name, ast.Load())
    return ast.Call(function, arguments, [ast.keyword(name, node) for name, node in (named or {}).items()])


def node_of(value: Any) -> ast.expr:
    """Return an expression of a value. Raises UnsupportedPython for a value that has none."""
    if type(value) is Residual:
        return value.holder.hold(value).node
    if isinstance(value, (np.generic, IntMember)):
        value = value.item() if isinstance(value, np.generic) else int(value)
    if isinstance(value, ValueObject):
        value = value.plain()
    if isinstance(value, Elapsed):
        bool(value)  # raises an exception
    if isinstance(value, TextMember):
        value = str.__str__(value)
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
        return call_node("float", [ast.Constant(repr(value))])
    if isinstance(value, (int, float)) and not isinstance(value, bool) and (value < 0 or str(value).startswith("-")):
        return ast.UnaryOp(ast.USub(), ast.Constant(-value))
    if value is None or isinstance(value, (bool, int, float, str)):
        return ast.Constant(value)
    if isinstance(value, np.ndarray):
        return call_node("np.array", [node_of(value.tolist())])
    if isinstance(value, tuple):
        return ast.Tuple([node_of(item) for item in value], ast.Load())
    if isinstance(value, list):
        return ast.List([node_of(item) for item in value], ast.Load())
    if isinstance(value, dict):
        return ast.Dict([node_of(key) for key in value], [node_of(item) for item in value.values()])
    if isinstance(value, slice):
        bounds = [node_of(each) if each is not None else None for each in (value.start, value.stop, value.step)]
        return ast.Slice(*bounds)
    if hasattr(type(value), "__float__") and not isinstance(value, PythonObject):  # such as a fraction
        return node_of(float(value))
    if isinstance(value, PythonObject) and value.cls.members is not None:
        return ast.Constant(value.fields["name"])
    raise UnsupportedPython(f"a value of the type `{type_name(value)}` cannot be written as a literal")


def is_kind_of(value: Residual, kind: Any) -> bool:
    """Return whether a residual value has a type."""
    kinds: dict[str, tuple[Any, ...]] = {
        "shape": (list,), "pose": (np.ndarray,), "array": (np.ndarray,), "int": (int,), "float": (float,),
        "bool": (bool,), "number": (int, float, np.integer, np.floating), "any": (int, str, tuple, object()),
    }  # fmt: skip
    answers = {isinstance(each, type) and issubclass(each, kind) for each in kinds[value.kind]}
    if len(answers) > 1:
        raise undecided(value)
    return True in answers


def undecided(value: Residual) -> UnsupportedPython:
    """Return the error of a program that depends on a residual value."""
    is_drawn = value.kind in ("int", "float", "number", "bool", "any")
    what = "a random number" if is_drawn else "a value of the finished scene"
    hint = "write this part with plain functions, loops and lists"
    return because(UnsupportedPython(f"{what} decides here which part of the program runs", hint), (value,))


def because(error: _Error, values: Iterable[Any]) -> _Error:
    """Return an exception with the values that are not known, if it has none yet: they may be its reason."""
    if not getattr(error, "because", ()):
        error.because = tuple(residuals(values))  # type: ignore[attr-defined]
    return error


def residuals(values: Iterable[Any]) -> Iterator[Residual]:
    """Iterate over the residual values in some values."""
    for value in values:
        if type(value) is Residual:
            yield value
        elif isinstance(value, (list, tuple)):
            yield from residuals(value)
        elif isinstance(value, np.ndarray) and value.dtype == object:
            yield from residuals(value.ravel().tolist())


def has_residual(value: Any) -> bool:
    """Return whether a value is residual, or contains one that is."""
    return next(residuals((value,)), None) is not None


def formatted(value: Any, specification: str) -> str:
    """Format a value. Raises UnsupportedPython for a residual value or a width that is too large."""
    if type(value) is Residual:
        raise UnsupportedPython("a random value cannot be part of a text here")
    check_widths(specification)
    weigh(value)
    return format(value, specification)


def attribute_of_residual(evaluator: Evaluating, value: Residual, name: str) -> Any:
    if value.kind == "shape":
        return value.holder.method_of(value, name)  # type: ignore[attr-defined]
    if value.known is not None and evaluator.loops is not None:
        return _of_known(evaluator, value, name)
    if name == "T":
        return Residual(ast.Attribute(node_of(value), "T", ast.Load()), value.kind, value.holder)
    if name in ("copy", "tolist", "sum", "min", "max", "mean", "astype", "dot"):
        kind = value.kind if name in ("copy", "tolist", "astype") else "number"

        def method(*arguments: Any) -> Residual:
            nodes = [node_of(each) for each in arguments if type(each) is not Native]
            return Residual(ast.Call(ast.Attribute(node_of(value), name, ast.Load()), nodes, []), kind, value.holder)

        return Native(name, method) if name != "astype" else Native(name, lambda kind: value)
    return MISSING


def _of_known(evaluator: Evaluating, value: Residual, name: str) -> Any:
    """Return an attribute of a value that is another in every turn of a loop; methods are those of constants."""
    assert value.known is not None
    attributes = [evaluator.attribute(each, name) for each in value.known.values()]
    if not isinstance(attributes[0], (Native, BoundMethod)):
        return evaluator.loops.general(value.known.loop, attributes, name)

    def method(*arguments: Any) -> Any:
        call = lambda each, *rest: evaluator.call(evaluator.attribute(each, name), rest, {})
        return evaluator.loops.computed(call, (value, *arguments))

    return Native(name, method)


def parameter_in(node: ast.expr) -> str | None:
    """Return the name of the parameter of which an expression is a part, None for another expression."""
    while isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
        node = node.value
    return node.id if isinstance(node, ast.Name) else None


# --- parts --------------------------------------------------------------------------------------------------------


_MAX_COLUMNS, _MAX_COLUMNS_OF_FRAMES = 24, 500  # of tables that replace similar expressions
_ALIASES = {"np": "numpy_module", "math": "math_module", "random": "random_module"}


@dataclass(eq=False, slots=True)
class PartNames:
    """Names of the values of all functions, with the parts that they are in, and those of the loops."""

    parts: dict[str, Part] = field(default_factory=dict)
    columns: set[str] = field(default_factory=set)


@dataclass(eq=False, slots=True)
class Part:
    """Residual function, or body of a loop, that is being written: draws and calls in order, values by name.

    ``function`` is the function, ``outer`` the part around a loop, ``taken`` are the names of the loops of a function
    with their kinds, ``parameters`` those of the function with the lengths of the tuples that they are and contain.
    """

    names: PartNames
    statements: list[tuple[str, ast.expr]] = field(default_factory=list)
    values: dict[str, Residual] = field(default_factory=dict)
    result: ast.expr | None = None
    outer: Part | None = None
    loop: KeptLoop | None = None
    parameters: dict[str, dict[str, int]] = field(default_factory=dict)
    taken: dict[str, str] = field(default_factory=dict)
    function: ast.AST | None = None

    def new_name(self, prefix: str) -> str:
        """Return a name that no function has yet."""
        name = f"{prefix}:{len(self.names.parts) + 1}"  # no name of the program
        self.names.parts[name] = self
        return name

    def around(self) -> Iterator[Part]:
        """Iterate over the part, and the parts around it, from inside out."""
        part: Part | None = self
        while part is not None:
            yield part
            part = part.outer

    @property
    def root(self) -> Part:
        """The part of the function."""
        *_, root = self.around()
        return root

    def reaches(self, other: Part) -> bool:
        """Return whether the values of another part can be used in this one."""
        return any(part is other for part in self.around())

    def names_in(self, node: ast.AST) -> set[str]:
        """Return the variables that an expression needs: parameters, draws, and what differs from turn to turn."""
        names: set[str] = set()
        seen: set[str] = set()
        pending = [node]
        while pending:
            for each in ast.walk(pending.pop()):
                if not isinstance(each, ast.Name) or each.id in seen:
                    continue
                seen.add(each.id)
                home = self.names.parts.get(each.id)
                if home is not None and each.id in home.values:
                    pending.append(home.values[each.id].node)
                elif home is not None or each.id in self.names.columns or each.id in self.root.parameters:
                    names.add(each.id)
        return names

    def known(self) -> set[str]:
        """Return the names that may be used in this part."""
        outer = self.outer.known() if self.outer is not None else {*self.parameters}
        turns = {*self.loop.columns, *self.loop.carried} if self.loop is not None else set()
        return outer | turns | {name for name, _ in self.statements}


@dataclass(eq=False, slots=True)
class KeptLoop:
    """Loop that remains: what its body is, and the values that differ from turn to turn, by name."""

    part: Part
    range: range | None
    count: int
    reached: Mapping[int, Any]  # values that exist before the loop, by their numbers
    columns: dict[str, list[Any]] = field(default_factory=dict)
    numbers: ast.expr | None = None  # a range that is known when the program runs
    carried: dict[str, Any] = field(default_factory=dict)  # numbers that a turn hands on to the next
    item: Any = None


class LoopNode(ast.expr):
    """List of what a loop makes, or, if ``result`` is None, a loop that only draws or prints."""

    _fields = ()

    def __init__(self, loop: KeptLoop, result: ast.expr | None, name: str = "") -> None:
        super().__init__()
        self.loop, self.result, self.name = loop, result, name


@dataclass(eq=False)
class Variant:
    """Residual function for some arguments: the test of the arguments, and the part."""

    test: dict[str, ast.expr]
    part: Part

    @cached_property
    def statements(self) -> list[ast.stmt]:
        """The body of the function."""
        return written(self.part)

    @cached_property
    def text(self) -> str:
        """The body as a text, to compare it."""
        return "".join(map(ast.dump, self.statements))


def place(node: ast.AST, origin: ast.AST) -> None:
    if "lineno" in node._attributes and not hasattr(node, "lineno"):
        ast.copy_location(node, origin)
        node.end_lineno, node.end_col_offset = node.lineno, node.col_offset  # type: ignore[attr-defined]


def written(part: Part) -> list[ast.stmt]:
    """Return the statements of a residual function: values that are used once stand where they are used."""
    assert part.result is not None
    uses: dict[str, int] = {}
    _count_uses([part.result, *(node for _, node in part.statements)], part, uses)
    writer = _Writer(part, uses)
    writer.write_statements()
    result = writer.frames(part.result) if isinstance(part.result, ast.List) else writer.visit(part.result)
    statements = [*writer.statements, ast.Return(result)]
    numbers = _Numbered(part.names, {n.id for each in statements for n in ast.walk(each) if isinstance(n, ast.Name)})
    return [numbers.visit(each) for each in statements]


class _Numbered(ast.NodeTransformer):
    """Numbers the names of the values of a function in the order of their appearance."""

    def __init__(self, names: PartNames, used: set[str]) -> None:
        self._names = names
        self._taken = used - names.parts.keys()
        self._found: dict[str, str] = {}
        self._count = 0

    def visit_Name(self, node: ast.Name) -> ast.Name:
        if node.id not in self._names.parts:
            return node
        while node.id not in self._found:
            self._count += 1
            name = f"{node.id.rpartition(':')[0]}_{self._count}"
            if name not in self._taken:
                self._found[node.id] = name
        return ast.Name(self._found[node.id], node.ctx)


def _count_uses(nodes: list[ast.expr], part: Part, uses: dict[str, int]) -> None:
    """Count how often the values of a function are used; a use in a loop around which they are counts as two."""
    names: set[str] = set()
    pending: list[ast.AST] = [*nodes]
    while pending:
        node = pending.pop()
        if isinstance(node, LoopNode):
            pending += [node.loop.numbers] if node.loop.numbers is not None else []
            inner = [each for _, each in node.loop.part.statements]
            _count_uses([*inner, *([node.result] if node.result is not None else [])], node.loop.part, uses)
        elif isinstance(node, ast.Name):
            home = next((each for each in part.around() if node.id in each.values), None)
            if home is None:
                names.add(node.id)
                continue
            is_first = node.id not in uses
            uses[node.id] = uses.get(node.id, 0) + (1 if home is part else 2)
            if is_first and home is part:
                pending.append(home.values[node.id].node)
            elif is_first:
                _count_uses([home.values[node.id].node], home, uses)
        else:
            pending += ast.iter_child_nodes(node)
    if any(name in part.names.parts or name in part.names.columns for name in names - part.known()):
        raise UnsupportedPython("a random value of another function cannot be used here")


class _Writer(ast.NodeTransformer):
    """Replaces the names of residual values by their expressions, or assigns them before the statement."""

    def __init__(self, part: Part, uses: Mapping[str, int], outer: _Writer | None = None) -> None:
        self._part, self._uses, self._outer = part, uses, outer
        self._done: set[str] = set()
        self.statements: list[ast.stmt] = []

    def write_statements(self) -> None:
        """Write the draws and calls of the part."""
        for name, node in self._part.statements:
            if isinstance(node, LoopNode):
                self.loop(node, name)
                continue
            value = self.visit(node)
            self.statements.append(_assigned(name, value) if name else ast.Expr(value))

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self._part.values:
            value = self._part.values[node.id].node
            if self._uses[node.id] == 1:
                return self.visit(value)  # type: ignore[no-any-return]
            if node.id not in self._done:
                self._done.add(node.id)
                made = self.visit(value)
                if not (isinstance(made, ast.Name) and made.id == node.id):
                    self.statements.append(_assigned(node.id, made))
            return ast.Name(node.id, ast.Load())
        if self._outer is not None:
            return self._outer.visit_Name(node)
        return ast.Name(_ALIASES.get(node.id, node.id), node.ctx)

    def visit_Tuple(self, node: ast.Tuple) -> ast.expr:
        return self._parameter(node)

    def visit_List(self, node: ast.List) -> ast.expr:
        return self._parameter(node)

    def _parameter(self, node: ast.Tuple | ast.List) -> ast.expr:
        """Return a parameter, or a part of one, in place of a tuple of all its items."""
        first = node.elts[0] if node.elts else None
        if isinstance(first, ast.Subscript):
            lengths = self._part.root.parameters.get(parameter_in(first) or "", {})
            if lengths.get(ast.dump(first.value)) == len(node.elts):
                whole = [
                    ast.dump(ast.Subscript(first.value, ast.Constant(i), ast.Load())) for i in range(len(node.elts))
                ]
                if [ast.dump(each) for each in node.elts] == whole:
                    return first.value
        self.generic_visit(node)
        return node

    def visit_LoopNode(self, node: LoopNode) -> ast.expr:
        return self.loop(node, node.name, is_expression=True)

    def loop(self, node: LoopNode, name: str, is_expression: bool = False) -> ast.expr:
        """Write a loop: a comprehension if it may be one, else a statement before."""
        inner = _Writer(node.loop.part, self._uses, self)
        if node.loop.numbers is not None:
            node.loop.numbers = self.visit(node.loop.numbers)
        inner.write_statements()
        result = inner.visit(node.result) if node.result is not None else None
        target, items = _turns(node.loop, [*inner.statements, *([result] if result is not None else [])])
        if is_expression and result is not None and not inner.statements:
            return ast.ListComp(result, [ast.comprehension(target, items, [], 0)])
        body = inner.statements
        if result is not None:
            self.statements.append(_assigned(name, ast.List([], ast.Load())))
            body = [*body, ast.Expr(call_node(f"{name}.append", [result]))]
        self.statements.append(ast.For(target, items, body, []))
        return ast.Name(name, ast.Load())

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id == "concat_shapes":
            if len(node.args) == 1 and not isinstance(node.args[0], ast.Starred):
                return node.args[0]
            return ast.Call(node.func, rolled(_unnested(node.args)), [])
        return node

    def frames(self, node: ast.List) -> ast.expr:
        """Write the frames of an animation, as a comprehension if they are similar."""
        expressions = rolled([self.visit(each) for each in node.elts], _MAX_COLUMNS_OF_FRAMES)
        only = expressions[0] if len(expressions) == 1 else None
        return only.value if isinstance(only, ast.Starred) else ast.List(expressions, ast.Load())


def _assigned(name: str, value: ast.expr) -> ast.stmt:
    return ast.Assign([ast.Name(name, ast.Store())], value)


def _turns(loop: KeptLoop, body: Sequence[ast.AST]) -> tuple[ast.expr, ast.expr]:
    """Return the target and the items of a loop: numbers, or a table of what the body uses."""
    used = {each.id for node in body for each in ast.walk(node) if isinstance(each, ast.Name)}
    names = [name for name in loop.columns if name in used]
    targets: list[ast.expr] = [ast.Name(name, ast.Store()) for name in names]
    first = loop.columns[names[0]] if names else []
    numbers = loop.range if loop.range is not None and names and first == list(loop.range) else None
    if loop.numbers is not None:
        return (targets[0] if names else ast.Name("_", ast.Store())), loop.numbers
    if not names:
        return ast.Name("_", ast.Store()), _range_node(range(loop.count))
    if len(names) == 1 and numbers is not None:
        return targets[0], _range_node(numbers)
    counted = next((name for name in names if _is_count(loop.columns[name])), None)
    if len(names) == 1 and counted is not None:
        return targets[0], _range_node(range(loop.count))
    rest = [name for name in names if name != counted]
    if any(type(value) is PythonObject for name in rest for value in loop.columns[name]):
        raise UnsupportedPython("an object cannot be written as a literal")
    table = [[node_of(value) for value in loop.columns[name]] for name in rest]
    rows: list[ast.expr] = table[0] if len(rest) == 1 else [ast.Tuple(list(row), ast.Load()) for row in zip(*table)]
    values = [each for name, each in zip(names, targets) if name != counted]
    target = values[0] if len(values) == 1 else ast.Tuple(values, ast.Store())
    items: ast.expr = ast.List(rows, ast.Load())
    if counted is None:
        return target, items
    return ast.Tuple([ast.Name(counted, ast.Store()), target], ast.Store()), call_node("enumerate", [items])


def _is_count(values: Sequence[Any]) -> bool:
    return all(type(each) is int and each == number for number, each in enumerate(values))


def _range_node(numbers: range) -> ast.expr:
    bounds = [numbers.start, numbers.stop, numbers.step]
    given = bounds if numbers.step != 1 else bounds[:2] if numbers.start else [numbers.stop]
    return call_node("range", [node_of(each) for each in given])


def _unnested(nodes: Sequence[ast.expr]) -> Iterator[ast.expr]:
    for node in nodes:
        is_union = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "concat_shapes"
        if is_union and isinstance(node, ast.Call):
            yield from node.args
        else:
            yield node


# Loops from lists of similar expressions: `f(1, 2), f(1, 3)` becomes `*[f(1, x) for x in (2, 3)]`. The expressions are
# generalised to their least general common form (anti-unification; Plotkin 1970); what differs becomes a table.


_MIN_LOOP_TURNS = 3  # expressions that become a loop


def rolled(nodes: Iterable[ast.expr], most: int = _MAX_COLUMNS) -> list[ast.expr]:
    """Return expressions with loops, over tables of at most ``most`` columns, in place of runs of similar ones."""
    expressions: list[ast.expr] = []
    run: list[ast.expr] = []
    shape = ""
    for node in nodes:
        own = _shape(node)
        if own != shape:
            expressions += _loop(run, most)
            run, shape = [], own
        run.append(node)
    return expressions + _loop(run, most)


def _shape(node: ast.expr) -> str:
    """Return the form of an expression without its numbers and texts."""
    if isinstance(node, ast.Starred):
        return f"*{id(node)}"  # a loop remains
    parts: list[str] = []
    pending: list[Any] = [node]
    while pending:
        each = pending.pop()
        if _is_number(each):
            parts.append("0")
        elif isinstance(each, ast.AST):
            parts.append(type(each).__name__)
            values = [getattr(each, name, None) for name in each._fields if name not in ("ctx", "kind")]
            pending += values
        elif isinstance(each, list):
            parts.append(f"[{len(each)}")
            pending += each
        else:
            parts.append(repr(each))
    return " ".join(parts)


def _is_number(node: ast.AST) -> bool:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        node = node.operand
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def _loop(run: Sequence[ast.expr], most: int) -> list[ast.expr]:
    if len(run) < _MIN_LOOP_TURNS or isinstance(run[0], ast.Starred):
        return list(run)
    rows = [_numbers(node) for node in run]
    columns = list(zip(*rows))
    taken = {n.id for n in ast.walk(run[0]) if isinstance(n, ast.Name)}
    free = (name for name in _names() if name not in taken)
    varying = [i for i, column in enumerate(columns) if len({ast.dump(each) for each in column}) > 1]
    groups: dict[str, str] = {}  # names by the values of a column
    names: dict[int, str] = {}
    kept: list[int] = []
    for i in varying:
        text = "".join(map(ast.dump, columns[i]))
        if text not in groups:
            groups[text] = next(free)
            kept.append(i)
        names[i] = groups[text]
    if not varying or len(kept) > most:
        return list(run)
    template: Any = _Named(names).visit(copy.deepcopy(run[0]))
    table: list[ast.expr] = [
        columns[kept[0]][row] if len(kept) == 1 else ast.Tuple([columns[i][row] for i in kept], ast.Load())
        for row in range(len(run))
    ]
    targets: list[ast.expr] = [ast.Name(name, ast.Store()) for name in groups.values()]
    target = targets[0] if len(targets) == 1 else ast.Tuple(targets, ast.Store())
    loop = ast.comprehension(target, ast.List(table, ast.Load()), [], 0)
    return [ast.Starred(ast.ListComp(template, [loop]), ast.Load())]


def _names() -> Iterator[str]:
    for number in itertools.count():
        for letter in "xyzwuvabcdefghijklmnopqrst":
            yield f"{letter}{number or ''}"


def _numbers(node: ast.AST) -> list[ast.expr]:
    """Return the numbers in an expression, in order."""
    if _is_number(node) and isinstance(node, ast.expr):
        return [node]
    return [each for child in ast.iter_child_nodes(node) for each in _numbers(child)]


class _Named(ast.NodeTransformer):
    """Replaces numbers, by their position, by names."""

    def __init__(self, names: dict[int, str]) -> None:
        self._names, self._count = names, 0

    def visit(self, node: ast.AST) -> ast.AST:
        if _is_number(node):
            name = self._names.get(self._count)
            self._count += 1
            return ast.Name(name, ast.Load()) if name is not None else node
        return self.generic_visit(node)
