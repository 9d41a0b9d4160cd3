"""The names that are visible at a cursor inside a form, found by expanding the form with a marker there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from scenelang.grammar.datum import Atom
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source
from scenelang.interpreter.expand import Expander
from scenelang.interpreter.file_expander import FileExpander
from scenelang.interpreter.files import SourceFile
from scenelang.interpreter.incremental import Version
from scenelang.interpreter.scope import Scope, base_name
from scenelang.interpreter.top_forms import TopForm
from scenelang.lsp.context import closed
from scenelang.session import run_with_room

_MARKER = "cursor-stands-here"
_DEPTH = 20_000


class _FoundError(Exception):
    """The expansion has come to the marker."""

    def __init__(self, scope: Scope) -> None:
        super().__init__()
        self.scope = scope


class _ProbeExpander(FileExpander):
    def unbound(self, atom: Atom, scope: Scope) -> SceneError:
        if base_name(atom.value) == _MARKER:
            raise _FoundError(scope)
        return Expander.unbound(self, atom, scope)


def local_bindings(version: Version, text: str, start: int, end: int, cursor: int, token: str) -> dict[str, Any]:
    """The local names at a cursor in the top-level form at ``start`` to ``end``, inner ones first."""
    whole = f"{text[start : cursor - len(token)]} {_MARKER} {text[cursor:end]}"
    for probe in (whole, closed(text, start, cursor, token, f" {_MARKER} ")):
        scope = run_with_room(lambda probe=probe: _scope_at_marker(version, probe), _DEPTH)  # type: ignore[misc]
        if scope is not None:
            return dict(_locals(scope, version))
    return {}


def _scope_at_marker(version: Version, text: str) -> Scope | None:
    source = Source("<probe>", text)
    file = SourceFile(source, version.file.scope)
    file.expander = _ProbeExpander(file, version.file.expander.run_macro)
    file.expander.record_names = set(version.file.expander.record_names)
    file.forms = [TopForm(read(source).forms)]
    try:
        file.scan()
        file.finish()
    except _FoundError as found:
        return found.scope
    except (SceneError, RecursionError):
        pass
    return None


def _locals(scope: Scope | None, version: Version) -> Iterator[tuple[str, Any]]:
    seen = set()
    while scope is not None and scope is not version.file.scope:
        for symbol, binding in scope.bindings.items():
            name = base_name(symbol)
            if name not in seen and name != _MARKER:
                seen.add(name)
                yield name, binding
        scope = scope.parent
