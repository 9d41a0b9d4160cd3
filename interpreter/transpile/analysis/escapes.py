"""Which closures may be called after the turn of a loop, or the comprehension, that made them."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from scenelang.interpreter.transpile.analysis.scopes import COMPREHENSIONS, Comprehension, Names, Variable

_ADDING = frozenset(("append", "add", "insert", "extend", "appendleft", "setdefault", "update"))
_COLLECTING = frozenset(("list", "tuple", "set", "frozenset", "sorted", "dict", "deque", "reversed"))
_DISPLAYS = (
    ast.List, ast.Tuple, ast.Set, ast.Dict, ast.Starred, ast.IfExp, ast.BoolOp, ast.BinOp, ast.Subscript, ast.NamedExpr,
)  # fmt: skip
_DEEPEST = 12


class Escapes:
    """Follows the value of a closure through displays, names and calls. A call is taken to have done with a function
    that it is given, unless it is a method that keeps its argument, or a function of the program that does."""

    def __init__(self, names: Names) -> None:
        self._names = names
        self._parents: dict[ast.AST, ast.AST] = {}
        self._reads: dict[Variable, list[ast.Name]] = {}
        for outer in ast.walk(names.module.node):
            for child in ast.iter_child_nodes(outer):
                self._parents[child] = outer
        for node, variable in names.variables.items():
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                self._reads.setdefault(variable, []).append(node)

    def turn(self, closure: ast.AST, loop: ast.AST) -> bool:
        """Whether a closure that is made in a turn of ``loop`` may be called after that turn."""
        return any(self._is_kept(place, loop, _DEEPEST) for place in self._places(closure))

    def comprehensions(self, closure: ast.AST) -> Iterator[Comprehension]:
        """The comprehensions whose results hold a closure, and which are worked out before it can be called."""
        for place in self._places(closure):
            node, parent = place, self._parents.get(place)
            while parent is not None and not isinstance(parent, (ast.stmt, ast.Lambda)):
                if isinstance(parent, COMPREHENSIONS):
                    if self._is_result(node, parent) and not self._runs_in_step(parent):
                        yield parent
                elif not isinstance(parent, (*_DISPLAYS, ast.comprehension)) and not self._collects(parent):
                    break
                elif isinstance(parent, ast.comprehension):
                    break  # what another comprehension runs through
                node, parent = parent, self._parents.get(parent)

    def _places(self, closure: ast.AST) -> Iterator[ast.AST]:
        """The expressions that are the closure: itself, or every read of its name."""
        if not isinstance(closure, ast.FunctionDef):
            yield closure
            return
        variable = self._names.functions[closure].variable
        yield from self._reads.get(variable, ()) if variable is not None else ()

    @staticmethod
    def _is_result(node: ast.AST, comprehension: ast.AST) -> bool:
        if isinstance(comprehension, ast.DictComp):
            return node in (comprehension.key, comprehension.value)
        return node is getattr(comprehension, "elt", None)

    def _collects(self, node: ast.AST) -> bool:
        return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _COLLECTING

    def _runs_in_step(self, node: Comprehension) -> bool:
        """A generator expression that is not collected is worked out item by item, as its items are used."""
        parent = self._parents.get(node)
        return isinstance(node, ast.GeneratorExp) and not (parent is not None and self._collects(parent))

    def _is_kept(self, node: ast.AST, loop: ast.AST, depth: int) -> bool:
        """Whether the value of an expression outlives a turn of ``loop``."""
        parent = self._parents.get(node)
        if parent is None or not depth:
            return False
        if isinstance(parent, ast.Call):
            return self._is_kept_by_call(parent, node, loop, depth)
        if isinstance(parent, ast.keyword):
            call = self._parents.get(parent)
            return isinstance(call, ast.Call) and self._is_kept_by_call(call, node, loop, depth)
        if isinstance(parent, (ast.Yield, ast.Return)):
            is_last = isinstance(loop, (ast.For, ast.While))  # nothing changes after the turn that returns
            if isinstance(parent, ast.Yield):
                return self._is_collected(parent)
            return not is_last and self._is_inside(parent, loop)
        if isinstance(parent, COMPREHENSIONS):
            return self._is_result(node, parent) and self._is_kept(parent, loop, depth - 1)
        if isinstance(parent, ast.NamedExpr):
            return self._is_kept_as(parent.target, loop, depth) or self._is_kept(parent, loop, depth - 1)
        if isinstance(parent, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
            targets = parent.targets if isinstance(parent, ast.Assign) else [parent.target]
            return any(self._is_kept_as(target, loop, depth) for target in targets)
        return isinstance(parent, _DISPLAYS) and self._is_kept(parent, loop, depth - 1)

    def _is_collected(self, node: ast.Yield) -> bool:
        """Whether all items of a generator function are worked out before any is used, by ``list`` or its like."""
        function: ast.AST | None = node
        while function is not None and not isinstance(function, ast.FunctionDef):
            function = self._parents.get(function)
        for read in self._places(function) if function is not None else ():
            call = self._parents.get(read)
            user = self._parents.get(call) if isinstance(call, ast.Call) and call.func is read else None
            if user is not None and (self._collects(user) or isinstance(user, ast.Starred)):
                return True
        return False

    def _is_kept_by_call(self, call: ast.Call, node: ast.AST, loop: ast.AST, depth: int) -> bool:
        if call.func is node:
            return False
        if isinstance(call.func, ast.Attribute) and call.func.attr in _ADDING:
            return True
        if self._collects(call):
            return self._is_kept(call, loop, depth - 1)
        variable = self._names.variables.get(call.func)
        functions = variable.functions if variable is not None else []
        return any(self._keeps(parameter, depth) for f in functions for parameter in self._filled(f.node, call, node))

    def _filled(self, function: ast.AST, call: ast.Call, node: ast.AST) -> list[Variable]:
        """The parameters that an argument may fill."""
        known = self._names.functions[function]
        if node in call.args and not any(isinstance(a, ast.Starred) for a in call.args):
            position = call.args.index(node)
            return [p.variable for p in known.parameters[position : position + 1]]
        named = {k.arg for k in call.keywords if k.value is node}
        return [p.variable for p in known.parameters if p.variable.name in named]

    def _keeps(self, parameter: Variable, depth: int) -> bool:
        """Whether a function gives what fills its parameter to something that outlives the call."""
        if parameter.function is None:
            return False
        body = parameter.function.node
        return any(self._is_kept(read, body, depth - 2) for read in self._reads.get(parameter, ()) if depth > 2)

    def _is_kept_as(self, target: ast.expr, loop: ast.AST, depth: int) -> bool:
        if isinstance(target, (ast.Subscript, ast.Attribute)):
            return True
        if isinstance(target, (ast.Tuple, ast.List)):
            return any(self._is_kept_as(element, loop, depth) for element in target.elts)
        variable = self._names.variables.get(target)
        if variable is None:
            return False
        reads = self._reads.get(variable, [])
        if any(not self._is_inside(read, loop) or _position(read) < _position(target) for read in reads):
            return True
        return any(self._is_kept(read, loop, depth - 1) for read in reads)

    def _is_inside(self, node: ast.AST, outer: ast.AST) -> bool:
        parent: ast.AST | None = node
        while parent is not None and parent is not outer:
            parent = self._parents.get(parent)
        return parent is outer


def _position(node: ast.AST) -> tuple[int, int]:
    return getattr(node, "lineno", 0), getattr(node, "col_offset", 0)
