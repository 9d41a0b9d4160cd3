"""The expander of one file, which knows the program around it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Atom
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.expand import Expander, RunMacro
from scenelang.interpreter.library import STD
from scenelang.interpreter.scope import Scope, Variable

if TYPE_CHECKING:
    from scenelang.interpreter.files import SourceFile

_PLAIN_TYPES = frozenset(("Embedding", "List[Embedding]", "Integer", "Float", "Number", "Vector", "Matrix", "Entity"))


class FileExpander(Expander):
    """An expander that knows the program around its file, for hints."""

    def __init__(self, file: SourceFile, run_macro: RunMacro) -> None:
        super().__init__(run_macro)
        self._file = file
        self._globals: dict[str, Variable] = {}
        self.declared: set[str] = set()  # in this version of the file

    def begin(self) -> None:
        """Start with a new version of the file."""
        self.record_names.clear()
        self.expansions = self.expanded = 0
        self.declared.clear()

    def known_names(self) -> Iterable[str]:
        state = self._file.state
        return state.prelude.names() if state is not None else ()

    def importable_from(self, name: str) -> str | None:
        state = self._file.state
        module = state.prelude.library.module_of(name.removeprefix(STD)) if state is not None else None
        return f"{STD}{module}" if module is not None else None

    def bound_words(self) -> Iterable[str]:
        state = self._file.state
        return [word for file in (self._file, *(state.files.values() if state else ())) for word in file.words]

    def unbound(self, atom: Atom, scope: Scope) -> SceneError:
        self._file.names.record.open_ended = True  # the hint depends on every name
        return super().unbound(atom, scope)

    def note_chance(self) -> None:
        self._file.names.record.open_ended = True

    def annotated_type(self, text: str, span: Span) -> Any:
        if text not in _PLAIN_TYPES:
            self._file.names.record.open_ended = True  # it depends on the program's records
        return super().annotated_type(text, span)

    def global_variable(self, name: str, span: Span) -> Variable:
        """The variable that a name had in the last version too; a second definition in one file has its own."""
        known = None if name in self.declared else self._globals.get(name)
        variable = known or super().global_variable(name, span)
        if name not in self.declared:
            self._globals[name] = variable
        self.declared.add(name)
        variable.span = span
        return variable
