"""Liveness analysis: variables that are read after a statement, and variables that must be cells.

A cell is assigned in place, so that closures and later iterations of a loop observe the assignment.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Sequence

from scenelang.interpreter.transpile.analysis.python_text import child_nodes, walk_tree
from scenelang.interpreter.transpile.analysis.scopes import (
    COMPREHENSIONS,
    Comprehension,
    Function,
    PythonNames,
    PythonVariable,
)

# Escape analysis: closures that may be called after the loop iteration or the comprehension that creates them.


_STORING_METHODS = frozenset(("append", "add", "insert", "extend", "appendleft", "setdefault", "update"))
_EAGER_CONSUMERS = frozenset(("list", "tuple", "set", "frozenset", "sorted", "dict", "deque", "reversed"))
_DISPLAYS = (
    ast.List, ast.Tuple, ast.Set, ast.Dict, ast.Starred, ast.IfExp, ast.BoolOp, ast.BinOp, ast.Subscript, ast.NamedExpr,
)  # fmt: skip
_MAX_DEPTH = 12  # steps from a closure to the place that stores it


class Escapes:
    """Follows closures through displays, variables and calls.

    A call is assumed not to retain a function argument, unless it is a method that stores its argument, or a function
    of the program that does.
    """

    def __init__(self, names: PythonNames) -> None:
        self._names = names
        self._parents: dict[ast.AST, ast.AST] = {}
        self._reads: dict[PythonVariable, list[ast.Name]] = {}
        for outer in walk_tree(names.module.node):
            for child in child_nodes(outer):
                self._parents[child] = outer
        for node, variable in names.variables.items():
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                self._reads.setdefault(variable, []).append(node)

    def outlives_iteration(self, closure: ast.AST, loop: ast.AST) -> bool:
        """Return whether a closure created in an iteration of ``loop`` may be called after that iteration."""
        return any(self._outlives(occurrence, loop, _MAX_DEPTH) for occurrence in self._occurrences(closure))

    def comprehensions(self, closure: ast.AST) -> Iterator[Comprehension]:
        """Iterate over the comprehensions whose result contains a closure, and which finish before the closure can be
        called."""
        for occurrence in self._occurrences(closure):
            node, parent = occurrence, self._parents.get(occurrence)
            while parent is not None and not isinstance(parent, (ast.stmt, ast.Lambda)):
                if isinstance(parent, COMPREHENSIONS):
                    if self._is_result(node, parent) and not self._is_lazy(parent):
                        yield parent
                elif not isinstance(parent, (*_DISPLAYS, ast.comprehension)) and not self._is_eager(parent):
                    break
                elif isinstance(parent, ast.comprehension):
                    break  # the iterable of another comprehension
                node, parent = parent, self._parents.get(parent)

    def _occurrences(self, closure: ast.AST) -> Iterator[ast.AST]:
        """Iterate over the expressions that denote a closure: the lambda itself, or every read of the function's
        name."""
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

    def _is_eager(self, node: ast.AST) -> bool:
        return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _EAGER_CONSUMERS

    def _is_lazy(self, node: Comprehension) -> bool:
        """Return whether the items of a generator expression are computed one by one as they are used."""
        parent = self._parents.get(node)
        return isinstance(node, ast.GeneratorExp) and not (parent is not None and self._is_eager(parent))

    def _outlives(self, node: ast.AST, loop: ast.AST, depth: int) -> bool:
        """Return whether the value of an expression outlives an iteration of ``loop``."""
        parent = self._parents.get(node)
        if parent is None or not depth:
            return False
        if isinstance(parent, ast.Call):
            return self._call_retains(parent, node, loop, depth)
        if isinstance(parent, ast.keyword):
            call = self._parents.get(parent)
            return isinstance(call, ast.Call) and self._call_retains(call, node, loop, depth)
        if isinstance(parent, (ast.Yield, ast.Return)):
            is_last = isinstance(loop, (ast.For, ast.While))  # no iteration follows a return
            if isinstance(parent, ast.Yield):
                return self._is_consumed_eagerly(parent)
            return not is_last and self._is_inside(parent, loop)
        if isinstance(parent, COMPREHENSIONS):
            return self._is_result(node, parent) and self._outlives(parent, loop, depth - 1)
        if isinstance(parent, ast.NamedExpr):
            return self._assignment_retains(parent.target, loop, depth) or self._outlives(parent, loop, depth - 1)
        if isinstance(parent, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
            targets = parent.targets if isinstance(parent, ast.Assign) else [parent.target]
            return any(self._assignment_retains(target, loop, depth) for target in targets)
        return isinstance(parent, _DISPLAYS) and self._outlives(parent, loop, depth - 1)

    def _is_consumed_eagerly(self, node: ast.Yield) -> bool:
        """Return whether all items of a generator function are computed before any is used, for example by ``list``."""
        function: ast.AST | None = node
        while function is not None and not isinstance(function, ast.FunctionDef):
            function = self._parents.get(function)
        for read in self._occurrences(function) if function is not None else ():
            call = self._parents.get(read)
            user = self._parents.get(call) if isinstance(call, ast.Call) and call.func is read else None
            if user is not None and (self._is_eager(user) or isinstance(user, ast.Starred)):
                return True
        return False

    def _call_retains(self, call: ast.Call, node: ast.AST, loop: ast.AST, depth: int) -> bool:
        if call.func is node:
            return False
        if isinstance(call.func, ast.Attribute) and call.func.attr in _STORING_METHODS:
            return True
        if self._is_eager(call):
            return self._outlives(call, loop, depth - 1)
        variable = self._names.variables.get(call.func)
        functions = variable.functions if variable is not None else []
        return any(
            self._parameter_escapes(parameter, depth)
            for f in functions
            for parameter in self._bound_parameters(f.node, call, node)
        )

    def _bound_parameters(self, function: ast.AST, call: ast.Call, node: ast.AST) -> list[PythonVariable]:
        """Return the parameters that an argument may be bound to."""
        known = self._names.functions[function]
        if node in call.args and not any(isinstance(a, ast.Starred) for a in call.args):
            position = call.args.index(node)
            return [p.variable for p in known.parameters[position : position + 1]]
        named = {k.arg for k in call.keywords if k.value is node}
        return [p.variable for p in known.parameters if p.variable.name in named]

    def _parameter_escapes(self, parameter: PythonVariable, depth: int) -> bool:
        """Return whether a function stores its parameter where it outlives the call."""
        if parameter.function is None:
            return False
        body = parameter.function.node
        return any(self._outlives(read, body, depth - 2) for read in self._reads.get(parameter, ()) if depth > 2)

    def _assignment_retains(self, target: ast.expr, loop: ast.AST, depth: int) -> bool:
        if isinstance(target, (ast.Subscript, ast.Attribute)):
            return True
        if isinstance(target, (ast.Tuple, ast.List)):
            return any(self._assignment_retains(element, loop, depth) for element in target.elts)
        variable = self._names.variables.get(target)
        if variable is None:
            return False
        reads = self._reads.get(variable, [])
        if any(not self._is_inside(read, loop) or _position(read) < _position(target) for read in reads):
            return True
        return any(self._outlives(read, loop, depth - 1) for read in reads)

    def _is_inside(self, node: ast.AST, outer: ast.AST) -> bool:
        parent: ast.AST | None = node
        while parent is not None and parent is not outer:
            parent = self._parents.get(parent)
        return parent is outer


def _position(node: ast.AST) -> tuple[int, int]:
    return getattr(node, "lineno", 0), getattr(node, "col_offset", 0)


Live = frozenset[PythonVariable]
_EMPTY: Live = frozenset()


class Liveness:
    """Live variables of a program. The analysis also sets ``Variable.is_cell``.

    Attributes
    ----------
    after
        For each statement, the variables whose value at its end may be read later.
    carried
        For each variable, the loops whose iterations its value must outlive.
    """

    def __init__(self, names: PythonNames) -> None:
        self._names = names
        self.after: dict[ast.stmt, Live] = {}
        self.carried: dict[PythonVariable, set[ast.AST]] = {}
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
            self._block(function.body, _read_elsewhere(function) if function is names.module else _EMPTY)
        for function in names.ordered:
            self._find_captured(function)
        self._find_late_reads()

    def _carry(self, variable: PythonVariable, loop: ast.AST) -> None:
        self.carried.setdefault(variable, set()).add(loop)

    # --- uses --------------------------------------------------------------------------------------------------

    def uses(self, node: ast.AST | None) -> Live:
        """Return the variables of the current function that ``node`` reads, including in nested functions."""
        if node is None:
            return _EMPTY
        live = self._used.get(node)
        if live is None:
            variables = self._names.variables
            live = self._used[node] = frozenset(
                variables[n]
                for n in walk_tree(node)
                if type(n) is ast.Name
                and n in variables
                and not variables[n].is_comprehension
                and (type(n.ctx) is ast.Load or _is_augmented(n, node))
            )
        return live

    def _assigned(self, *targets: ast.AST) -> Live:
        variables = self._names.variables
        return frozenset(
            variables[n]
            for target in targets
            for n in walk_tree(target)
            if type(n) is ast.Name
            and type(n.ctx) is not ast.Load
            and n in variables
            and not variables[n].is_comprehension
        )

    def _inner_uses(self, closure: ast.AST) -> Live:
        """Return the variables that the body of a closure reads; its defaults are evaluated when it is created."""
        return frozenset[PythonVariable]().union(*(self.uses(node) for node in _body_of(closure)))

    # --- backward pass -----------------------------------------------------------------------------------------

    def _block(self, body: Sequence[ast.stmt], live: Live) -> Live:
        for statement in reversed(body):
            self.after[statement] = self.after.get(statement, _EMPTY) | live
            live = self._statement(statement, live)
        return live

    def _statement(self, node: ast.stmt, live: Live) -> Live:
        """Return the variables that are live before a statement, given those that are live after it."""
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
            handlers = frozenset[PythonVariable]().union(*(self._block(h.body, after) for h in node.handlers))
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
            own = frozenset((function.variable,)) if function and function.variable else _EMPTY
            return (live - own) | self.uses(node)
        return live | self.uses(node)

    def _store(self, targets: Iterable[ast.expr], value: ast.expr, live: Live) -> Live:
        targets = list(targets)
        plain = [t for t in targets if isinstance(t, (ast.Name, ast.Tuple, ast.List, ast.Starred))]
        reads = frozenset[PythonVariable]().union(*(self.uses(t) for t in targets))
        return (live - self._assigned(*plain)) | self.uses(value) | reads

    def _loop(self, node: ast.For | ast.While, live: Live) -> Live:
        after = self._block(node.orelse, live)
        targets = self._assigned(node.target) if isinstance(node, ast.For) else _EMPTY
        test = self.uses(node.test) if isinstance(node, ast.While) else _EMPTY
        exposed = self._exposed.get(node)
        if exposed is None:  # variables that an iteration reads from earlier ones
            self._loops.append((_EMPTY, _EMPTY))
            exposed = self._exposed[node] = self._block(node.body, _EMPTY) - targets
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
        """Mark as cells the variables that are assigned after a closure that reads them is created."""
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
                            if self._escapes.outlives_iteration(closure, loop):
                                self._carry(variable, loop)
        for closure in closures:
            for loop in _loops_around(closure, loops):
                if self._escapes.outlives_iteration(closure, loop):
                    self._share_across_iterations(function, closure, loop, loops)

    def _share_across_iterations(
        self, function: Function, closure: ast.AST, loop: ast.AST, loops: dict[ast.AST, ast.AST]
    ) -> None:
        """Use one variable for all iterations of ``loop`` if a closure that outlives its iteration reads it, as Python
        does."""
        for variable in self._inner_uses(closure):
            if variable.function is function and any(
                around is loop for store in variable.stores for around in _loops_around(store, loops)
            ):
                variable.is_cell = True
                self._carry(variable, loop)

    def _find_late_reads(self) -> None:
        """Mark as cells the variables of comprehensions that are read by closures called after the comprehension."""
        nodes = {variable: node for node, variable in self._names.variables.items() if variable.is_comprehension}
        if not nodes:
            return
        for function in self._names.ordered:
            closure = function.node
            if isinstance(closure, ast.Module):
                continue
            read = {self._names.variables.get(n) for part in _body_of(closure) for n in walk_tree(part)} & nodes.keys()
            for comprehension in self._escapes.comprehensions(closure) if read else ():
                targets = {n for g in comprehension.generators for n in walk_tree(g.target)}
                for variable in read:
                    if variable is not None and any(store in targets for store in variable.stores):
                        variable.is_cell = True


def _loops_around(node: ast.AST, loops: dict[ast.AST, ast.AST]) -> list[ast.AST]:
    """Return the loops around a node of a function's body, innermost first."""
    around: list[ast.AST] = []
    loop = loops.get(node)
    while loop is not None:
        around.append(loop)
        loop = loops.get(loop)
    return around


def _body_of(closure: ast.AST) -> list[ast.AST]:
    if isinstance(closure, ast.Lambda):
        return [closure.body]
    return list(closure.body) if isinstance(closure, ast.FunctionDef) else [closure]


def _is_augmented(name: ast.Name, node: ast.AST) -> bool:
    return isinstance(node, ast.AugAssign) and node.target is name


def _is_reassigned(variable: PythonVariable) -> bool:
    stores = [store for store in variable.stores if not isinstance(store, (ast.FunctionDef, ast.ClassDef, ast.alias))]
    return len(stores) > 1


def _enclosing_loops(body: Sequence[ast.stmt]) -> dict[ast.AST, ast.AST]:
    """Map the nodes of a body that are inside a loop to the innermost loop."""
    innermost: dict[ast.AST, ast.AST] = {}

    def visit(node: ast.AST, loop: ast.AST | None) -> None:
        if loop is not None:
            innermost[node] = loop
        if isinstance(node, (ast.For, ast.While)):
            loop = node
        if isinstance(node, (ast.FunctionDef, ast.Lambda)):
            return
        for child in child_nodes(node):
            visit(child, loop)

    for statement in body:
        visit(statement, None)
    return innermost


def _read_elsewhere(function: Function) -> Live:
    """Return the variables of ``function`` that other functions read."""
    return frozenset(variable for variable in function.locals.values() if variable.is_captured)


def _changes_later(
    variable: PythonVariable, closure: ast.AST, loops: dict[ast.AST, ast.AST], body: Sequence[ast.stmt]
) -> bool:
    """Return whether ``variable`` is assigned after ``closure`` is created, other than by its only definition."""
    later = [s for s in variable.stores if _position(s) > _position(closure) and not isinstance(s, ast.arg)]
    if not later:
        return False
    if len(variable.stores) == 1 and isinstance(closure, ast.FunctionDef):
        return not any(isinstance(s, ast.Assign) and any(n is later[0] for n in walk_tree(s)) for s in body)
    return True


# Positions of the definitions of cells.


class CellDefinitions:
    """Positions of the definitions of cells.

    Attributes
    ----------
    definitions
        Assignments that define a cell.
    before
        Cells to define, as none, before a statement.
    """

    def __init__(self, names: PythonNames, liveness: Liveness) -> None:
        self._names = names
        self._liveness = liveness
        self.definitions: dict[ast.stmt, set[PythonVariable]] = {}
        self.before: dict[ast.stmt, list[PythonVariable]] = {}
        cells: dict[Function, list[PythonVariable]] = {}
        for variable in dict.fromkeys(names.variables.values()):
            is_local = not variable.is_parameter and not variable.is_comprehension
            if variable.is_cell and variable.function is not None and is_local:
                cells.setdefault(variable.function, []).append(variable)
        for function, variables in cells.items():
            for variable in variables:
                self._place(function.body, variable)

    def _place(self, block: Sequence[ast.stmt], variable: PythonVariable) -> None:
        mentioning = [s for s in block if self._mentions(s, variable)]
        if not mentioning:
            return
        first = mentioning[0]
        if len(mentioning) == 1 and self._descend(first, variable):
            return
        if _is_plain_assignment(first, variable, self._names) and variable not in self._liveness.uses(_value(first)):
            self.definitions.setdefault(first, set()).add(variable)
        else:
            self.before.setdefault(first, []).append(variable)

    def _descend(self, statement: ast.stmt, variable: PythonVariable) -> bool:
        """Define the variable inside a compound statement if all its occurrences are in one block.

        Returns whether that is the case.
        """
        if variable.function is self._names.module:
            return False  # the definition must be visible to all functions
        is_loop = isinstance(statement, (ast.For, ast.While))
        if not isinstance(statement, (ast.If, ast.For, ast.While)) or (
            is_loop and statement in self._liveness.carried.get(variable, ())
        ):
            return False
        blocks = [statement.body, statement.orelse]
        head = [statement.target, statement.iter] if isinstance(statement, ast.For) else [statement.test]
        if any(self._mentions(node, variable) for node in head):
            return False
        mentioning_blocks = [b for b in blocks if any(self._mentions(s, variable) for s in b)]
        if len(mentioning_blocks) != 1:
            return False
        self._place(mentioning_blocks[0], variable)
        return True

    def _mentions(self, node: ast.AST, variable: PythonVariable) -> bool:
        return any(self._names.variables.get(n) is variable for n in walk_tree(node))


def _is_plain_assignment(statement: ast.stmt, variable: PythonVariable, names: PythonNames) -> bool:
    if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
        target = statement.targets[0]
    elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
        target = statement.target
    else:
        return False
    if isinstance(target, (ast.Tuple, ast.List)):
        return all(isinstance(e, ast.Name) for e in target.elts) and any(
            names.variables.get(e) is variable for e in target.elts
        )
    return names.variables.get(target) is variable


def _value(statement: ast.stmt) -> ast.expr | None:
    return statement.value if isinstance(statement, (ast.Assign, ast.AnnAssign)) else None
