"""Which variables are still needed after a statement, and which must be cells that are assigned in place."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Sequence

from scenelang.interpreter.transpile.analysis.escapes import Escapes
from scenelang.interpreter.transpile.analysis.scopes import Function, Names, Variable

Live = frozenset[Variable]
_NONE: Live = frozenset()


class Liveness:
    """``after[statement]``: the variables whose value at its end may be read later. Marks ``Variable.is_cell``;
    ``carried``: the loops whose turns the value of a variable must outlive."""

    def __init__(self, names: Names) -> None:
        self._names = names
        self.after: dict[ast.stmt, Live] = {}
        self.carried: dict[Variable, set[ast.AST]] = {}
        self._function = names.module
        self._loops: list[tuple[Live, Live]] = []
        self._used: dict[ast.AST, Live] = {}
        self._exposed: dict[ast.AST, Live] = {}
        self._escapes = Escapes(names)
        for target in names.walrus:
            names.variables[target].is_cell = True
        for function in names.ordered:
            self._function = function
            self._loops = []
            self._block(function.body, _read_elsewhere(function) if function is names.module else _NONE)
        for function in names.ordered:
            self._find_captured(function)
        self._find_late()

    def _carry(self, variable: Variable, loop: ast.AST) -> None:
        self.carried.setdefault(variable, set()).add(loop)

    # --- uses --------------------------------------------------------------------------------------------------

    def uses(self, node: ast.AST | None) -> Live:
        """The variables of the current function that ``node`` reads, nested functions included."""
        if node is None:
            return _NONE
        found = self._used.get(node)
        if found is None:
            variables = self._names.variables
            found = self._used[node] = frozenset(
                variables[n]
                for n in ast.walk(node)
                if type(n) is ast.Name
                and n in variables
                and not variables[n].is_comprehension
                and (type(n.ctx) is ast.Load or _is_augmented(n, node))
            )
        return found

    def _assigned(self, *targets: ast.AST) -> Live:
        variables = self._names.variables
        return frozenset(
            variables[n]
            for target in targets
            for n in ast.walk(target)
            if type(n) is ast.Name
            and type(n.ctx) is not ast.Load
            and n in variables
            and not variables[n].is_comprehension
        )

    def _inner_uses(self, closure: ast.AST) -> Live:
        """What the body of a closure reads; its defaults are evaluated when it is made."""
        return frozenset[Variable]().union(*(self.uses(node) for node in _body_of(closure)))

    # --- the backward pass -------------------------------------------------------------------------------------

    def _block(self, body: Sequence[ast.stmt], live: Live) -> Live:
        for statement in reversed(body):
            self.after[statement] = self.after.get(statement, _NONE) | live
            live = self._statement(statement, live)
        return live

    def _statement(self, node: ast.stmt, live: Live) -> Live:
        if isinstance(node, ast.Assign):
            return self._store(node.targets, node.value, live)
        if isinstance(node, ast.AnnAssign):
            return live if node.value is None else self._store([node.target], node.value, live)
        if isinstance(node, ast.AugAssign):
            return live | self.uses(node.value) | self.uses(node.target) | self._assigned(node.target)
        if isinstance(node, (ast.Return, ast.Raise)):
            return self.uses(node)
        if isinstance(node, ast.If):
            first, second = self._block(node.body, live), self._block(node.orelse, live)
            return first | second | self.uses(node.test)
        if isinstance(node, (ast.For, ast.While)):
            return self._loop(node, live)
        if isinstance(node, ast.Try):
            after = self._block(node.finalbody, live)
            handlers = frozenset[Variable]().union(*(self._block(h.body, after) for h in node.handlers))
            body = self._block(node.body, self._block(node.orelse, after) | handlers)
            return body | handlers
        if isinstance(node, ast.Break):
            return self._loops[-1][1] if self._loops else live
        if isinstance(node, ast.Continue):
            return self._loops[-1][0] if self._loops else live
        if isinstance(node, ast.With):
            return self._block(node.body, live) | frozenset().union(*(self.uses(i.context_expr) for i in node.items))
        if isinstance(node, ast.FunctionDef):
            function = self._names.functions.get(node)
            own = frozenset((function.variable,)) if function and function.variable else _NONE
            return (live - own) | self.uses(node)
        return live | self.uses(node)

    def _store(self, targets: Iterable[ast.expr], value: ast.expr, live: Live) -> Live:
        targets = list(targets)
        plain = [t for t in targets if isinstance(t, (ast.Name, ast.Tuple, ast.List, ast.Starred))]
        reads = frozenset[Variable]().union(*(self.uses(t) for t in targets))
        return (live - self._assigned(*plain)) | self.uses(value) | reads

    def _loop(self, node: ast.For | ast.While, live: Live) -> Live:
        after = self._block(node.orelse, live)
        targets = self._assigned(node.target) if isinstance(node, ast.For) else _NONE
        test = self.uses(node.test) if isinstance(node, ast.While) else _NONE
        exposed = self._exposed.get(node)
        if exposed is None:  # what a turn reads of those before it
            self._loops.append((_NONE, _NONE))
            exposed = self._exposed[node] = self._block(node.body, _NONE) - targets
            self._loops.pop()
        head = after | exposed | test
        self._loops.append((head, live))
        body = self._block(node.body, head)
        self._loops.pop()
        head = head | (body - targets)
        assigned = targets | self._assigned(*node.body)
        carried = (assigned & (body | test) - targets) | (assigned & (after | live))
        for variable in carried:
            variable.is_cell = True
            self._carry(variable, node)
        return head | (self.uses(node.iter) if isinstance(node, ast.For) else test)

    # --- closures ----------------------------------------------------------------------------------------------

    def _find_captured(self, function: Function) -> None:
        """Mark variables that a closure sees change after it was made."""
        if isinstance(function.node, ast.Lambda):
            return
        is_module = isinstance(function.node, ast.Module)
        loops = _enclosing_loops(function.body)
        closures = [
            inner.node
            for inner in self._names.ordered
            if inner.parent is function and not isinstance(inner.node, ast.Module)
        ]
        for variable in function.locals.values():
            if variable.is_cell:
                continue
            if variable.is_assigned_elsewhere or (is_module and _is_reassigned(variable)):
                variable.is_cell = True
            elif variable.is_captured and not variable.functions:
                for closure in closures:
                    if variable in self._inner_uses(closure) and _changes_later(
                        variable, closure, loops, function.body
                    ):
                        variable.is_cell = True
                        for loop in _loops_around(closure, loops):
                            if self._escapes.turn(closure, loop):
                                self._carry(variable, loop)
        for closure in closures:
            for loop in _loops_around(closure, loops):
                if self._escapes.turn(closure, loop):
                    self._share(function, closure, loop, loops)

    def _share(self, function: Function, closure: ast.AST, loop: ast.AST, loops: dict[ast.AST, ast.AST]) -> None:
        """One variable for all turns of ``loop``, where a closure that outlives its turn reads it."""
        for variable in self._inner_uses(closure):
            if variable.function is function and any(
                around is loop for store in variable.stores for around in _loops_around(store, loops)
            ):
                variable.is_cell = True
                self._carry(variable, loop)

    def _find_late(self) -> None:
        """Mark the variables of comprehensions that closures read which are called after it."""
        nodes = {variable: node for node, variable in self._names.variables.items() if variable.is_comprehension}
        if not nodes:
            return
        for function in self._names.ordered:
            closure = function.node
            if isinstance(closure, ast.Module):
                continue
            read = {self._names.variables.get(n) for part in _body_of(closure) for n in ast.walk(part)} & nodes.keys()
            for comprehension in self._escapes.comprehensions(closure) if read else ():
                targets = {n for g in comprehension.generators for n in ast.walk(g.target)}
                for variable in read:
                    if variable is not None and any(store in targets for store in variable.stores):
                        variable.is_cell = True


def _loops_around(node: ast.AST, loops: dict[ast.AST, ast.AST]) -> list[ast.AST]:
    """The loops around a node of a function's body, innermost first."""
    found: list[ast.AST] = []
    loop = loops.get(node)
    while loop is not None:
        found.append(loop)
        loop = loops.get(loop)
    return found


def _body_of(closure: ast.AST) -> list[ast.AST]:
    if isinstance(closure, ast.Lambda):
        return [closure.body]
    return list(closure.body) if isinstance(closure, ast.FunctionDef) else [closure]


def _is_augmented(name: ast.Name, node: ast.AST) -> bool:
    return isinstance(node, ast.AugAssign) and node.target is name


def _is_reassigned(variable: Variable) -> bool:
    stores = [store for store in variable.stores if not isinstance(store, (ast.FunctionDef, ast.ClassDef, ast.alias))]
    return len(stores) > 1


def _enclosing_loops(body: Sequence[ast.stmt]) -> dict[ast.AST, ast.AST]:
    """The innermost loop around every node of a body that is inside one."""
    found: dict[ast.AST, ast.AST] = {}

    def visit(node: ast.AST, loop: ast.AST | None) -> None:
        if loop is not None:
            found[node] = loop
        if isinstance(node, (ast.For, ast.While)):
            loop = node
        if isinstance(node, (ast.FunctionDef, ast.Lambda)):
            return
        for child in ast.iter_child_nodes(node):
            visit(child, loop)

    for statement in body:
        visit(statement, None)
    return found


def _position(node: ast.AST) -> tuple[int, int]:
    return getattr(node, "lineno", 0), getattr(node, "col_offset", 0)


def _read_elsewhere(function: Function) -> Live:
    """The variables of ``function`` that other functions read."""
    return frozenset(variable for variable in function.locals.values() if variable.is_captured)


def _changes_later(
    variable: Variable, closure: ast.AST, loops: dict[ast.AST, ast.AST], body: Sequence[ast.stmt]
) -> bool:
    """Whether ``variable`` is assigned after ``closure`` was made, other than by its one plain definition."""
    later = [s for s in variable.stores if _position(s) > _position(closure) and not isinstance(s, ast.arg)]
    if not later:
        return False
    if len(variable.stores) == 1 and isinstance(closure, ast.FunctionDef):
        return not any(isinstance(s, ast.Assign) and any(n is later[0] for n in ast.walk(s)) for s in body)
    return True
