"""Where the variables that are assigned in place get their definition."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.liveness import Liveness
from scenelang.interpreter.transpile.analysis.scopes import Function, Names, Variable


class CellPlaces:
    """``definitions``: assignments that define a cell; ``before``: cells to define, as none, before a statement."""

    def __init__(self, names: Names, liveness: Liveness) -> None:
        self._names = names
        self._liveness = liveness
        self.definitions: dict[ast.stmt, set[Variable]] = {}
        self.before: dict[ast.stmt, list[Variable]] = {}
        cells: dict[Function, list[Variable]] = {}
        for variable in dict.fromkeys(names.variables.values()):
            is_local = not variable.is_parameter and not variable.is_comprehension
            if variable.is_cell and variable.function is not None and is_local:
                cells.setdefault(variable.function, []).append(variable)
        for function, variables in cells.items():
            for variable in variables:
                self._place(function.body, variable)

    def _place(self, block: Sequence[ast.stmt], variable: Variable) -> None:
        mentioning = [s for s in block if self._mentions(s, variable)]
        if not mentioning:
            return
        first = mentioning[0]
        if len(mentioning) == 1 and self._descend(first, variable):
            return
        if _plainly_assigns(first, variable, self._names) and variable not in self._liveness.uses(_value(first)):
            self.definitions.setdefault(first, set()).add(variable)
        else:
            self.before.setdefault(first, []).append(variable)

    def _descend(self, statement: ast.stmt, variable: Variable) -> bool:
        """Place the definition inside a compound statement when one block of it holds all mentions."""
        if variable.function is self._names.module:
            return False  # functions must see it
        is_loop = isinstance(statement, (ast.For, ast.While))
        if not isinstance(statement, (ast.If, ast.For, ast.While)) or (
            is_loop and statement in self._liveness.carried.get(variable, ())
        ):
            return False
        blocks = [statement.body, statement.orelse]
        head = [statement.target, statement.iter] if isinstance(statement, ast.For) else [statement.test]
        if any(self._mentions(node, variable) for node in head):
            return False
        holding = [b for b in blocks if any(self._mentions(s, variable) for s in b)]
        if len(holding) != 1:
            return False
        self._place(holding[0], variable)
        return True

    def _mentions(self, node: ast.AST, variable: Variable) -> bool:
        return any(self._names.variables.get(n) is variable for n in ast.walk(node))


def _plainly_assigns(statement: ast.stmt, variable: Variable, names: Names) -> bool:
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
