"""What remains of evaluated functions: expressions and statements of the helper API, and loops."""

from __future__ import annotations

import ast
import copy
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from scenelang.interpreter.transpile.evaluation import UnsupportedPython
from scenelang.interpreter.transpile.evaluation.objects import Residual, call_node, node_of

_MOST_COLUMNS, _MOST_COLUMNS_OF_FRAMES = 24, 500
_ALIASES = {"np": "numpy_module", "math": "math_module", "random": "random_module"}


@dataclass(eq=False, slots=True)
class Names:
    """Names of the values of all functions, with the parts that they are in, and those of the loops."""

    parts: dict[str, Part] = field(default_factory=dict)
    columns: set[str] = field(default_factory=set)


@dataclass(eq=False, slots=True)
class Part:
    """Residual function, or body of a loop, that is being written: draws and calls in order, values by name.

    ``outer`` is the part around a loop, ``taken`` are the names of the loops of a function with their kinds.
    """

    names: Names
    statements: list[tuple[str, ast.expr]] = field(default_factory=list)
    values: dict[str, Residual] = field(default_factory=dict)
    result: ast.expr | None = None
    outer: Part | None = None
    loop: Loop | None = None
    parameters: set[str] = field(default_factory=set)
    taken: dict[str, str] = field(default_factory=dict)

    def new_name(self, prefix: str) -> str:
        """Return a name that no function has yet."""
        name = f"{prefix}_{len(self.names.parts) + 1}"
        self.names.parts[name] = self
        return name

    def reaches(self, other: Part) -> bool:
        """Return whether the values of another part can be used in this one."""
        part: Part | None = self
        while part is not None and part is not other:
            part = part.outer
        return part is not None

    def known(self) -> set[str]:
        """Return the names that may be used in this part."""
        outer = self.outer.known() if self.outer is not None else {*self.parameters}
        return outer | {name for name, _ in self.statements} | {*(self.loop.columns if self.loop is not None else ())}


@dataclass(eq=False, slots=True)
class Loop:
    """Loop that remains: what its body is, and the values that differ from turn to turn, by name."""

    part: Part
    range: range | None
    count: int
    reached: Mapping[int, Any]  # values that exist before the loop, by their numbers
    columns: dict[str, list[Any]] = field(default_factory=dict)
    item: Any = None


class LoopNode(ast.expr):
    """List of what a loop makes, or, if ``result`` is None, a loop that only draws or prints."""

    _fields = ()

    def __init__(self, loop: Loop, result: ast.expr | None, name: str = "") -> None:
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
    numbers = _Numbered(part.names)
    return [numbers.visit(each) for each in (*writer.statements, ast.Return(result))]


class _Numbered(ast.NodeTransformer):
    """Numbers the names of the values of a function in the order of their appearance."""

    def __init__(self, names: Names) -> None:
        self._names = names
        self._found: dict[str, str] = {}

    def visit_Name(self, node: ast.Name) -> ast.Name:
        if node.id in self._names.parts:
            prefix = node.id.rpartition("_")[0]
            self._found.setdefault(node.id, f"{prefix}_{len(self._found) + 1}")
            return ast.Name(self._found[node.id], node.ctx)
        return node


def _count_uses(nodes: list[ast.expr], part: Part, uses: dict[str, int]) -> None:
    """Count how often the values of a function are used; a use in a loop around which they are counts as two."""
    names: set[str] = set()
    pending: list[ast.AST] = [*nodes]
    while pending:
        node = pending.pop()
        if isinstance(node, LoopNode):
            inner = [each for _, each in node.loop.part.statements]
            _count_uses([*inner, *([node.result] if node.result is not None else [])], node.loop.part, uses)
        elif isinstance(node, ast.Name):
            home: Part | None = part
            while home is not None and node.id not in home.values:
                home = home.outer
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

    def visit_LoopNode(self, node: LoopNode) -> ast.expr:
        return self.loop(node, node.name, is_expression=True)

    def loop(self, node: LoopNode, name: str, is_expression: bool = False) -> ast.expr:
        """Write a loop: a comprehension if it may be one, else a statement before."""
        inner = _Writer(node.loop.part, self._uses, self)
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
        found = rolled([self.visit(each) for each in node.elts], _MOST_COLUMNS_OF_FRAMES)
        only = found[0] if len(found) == 1 else None
        return only.value if isinstance(only, ast.Starred) else ast.List(found, ast.Load())


def _assigned(name: str, value: ast.expr) -> ast.stmt:
    return ast.Assign([ast.Name(name, ast.Store())], value)


def _turns(loop: Loop, body: Sequence[ast.AST]) -> tuple[ast.expr, ast.expr]:
    """Return the target and the items of a loop: numbers, or a table of what the body uses."""
    used = {each.id for node in body for each in ast.walk(node) if isinstance(each, ast.Name)}
    names = [name for name in loop.columns if name in used]
    targets: list[ast.expr] = [ast.Name(name, ast.Store()) for name in names]
    first = loop.columns[names[0]] if names else []
    numbers = loop.range if loop.range is not None and names and first == list(loop.range) else None
    if not names:
        return ast.Name("_", ast.Store()), _range_node(range(loop.count))
    if len(names) == 1 and numbers is not None:
        return targets[0], _range_node(numbers)
    counted = next((name for name in names if _is_count(loop.columns[name])), None)
    if len(names) == 1 and counted is not None:
        return targets[0], _range_node(range(loop.count))
    rest = [name for name in names if name != counted]
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


_FEWEST = 3  # expressions that become a loop


def rolled(nodes: Iterable[ast.expr], most: int = _MOST_COLUMNS) -> list[ast.expr]:
    """Return expressions with loops, over tables of at most ``most`` columns, in place of runs of similar ones."""
    found: list[ast.expr] = []
    run: list[ast.expr] = []
    shape = ""
    for node in nodes:
        own = _shape(node)
        if own != shape:
            found += _loop(run, most)
            run, shape = [], own
        run.append(node)
    return found + _loop(run, most)


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
    if len(run) < _FEWEST or isinstance(run[0], ast.Starred):
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
