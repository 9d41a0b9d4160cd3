"""The last values of a top level that goes on, ``*1 *2 *3``, and its last error, ``*e``, as variables."""

from __future__ import annotations

from typing import Any

from scenelang.grammar.datum import Symbol
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.evaluate import Run
from scenelang.interpreter.procedures import Cell
from scenelang.interpreter.runtime import raised_value
from scenelang.interpreter.scope import Scope, Variable

VALUES = ("*1", "*2", "*3")
ERROR = "*e"


class Latest:
    """Binds the names in ``scope``; all hold none at first."""

    def __init__(self, run: Run, scope: Scope) -> None:
        self._rt = run.rt
        self._cells: dict[str, Cell] = {}
        for name in (*VALUES, ERROR):
            variable = Variable(name, None, is_global=True)
            variable.assigned = True  # so that a call that reads it is shared only until it changes
            scope.bind(Symbol(name), variable)
            self._cells[name] = run.globals[variable] = Cell(None, 0)

    @property
    def value(self) -> Any:
        """``*1``."""
        return self._cells[VALUES[0]].value

    def remember(self, value: Any) -> None:
        """Make a value ``*1``; what that was becomes ``*2``, and so on."""
        cells = [self._cells[name] for name in VALUES]
        for cell, each in zip(cells, [value, *(cell.value for cell in cells[:-1])]):
            self._put(cell, each)

    def remember_error(self, error: SceneError) -> None:
        """Make an error the value of ``*e``."""
        self._put(self._cells[ERROR], raised_value(error))

    def _put(self, cell: Cell, value: Any) -> None:
        if cell.observed:  # a stored call read it
            self._rt.forget_calls()
            cell.observed = False
        cell.value = value
