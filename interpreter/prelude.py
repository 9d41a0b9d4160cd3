"""What every program sees without defining it: forms, builtins, constants, the library's modules in the language."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.source import Source
from scenelang.interpreter.files import SourceFile
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.library import STD, Library
from scenelang.interpreter.scope import ConstantBinding, PaperForm, Scope, Special, Variable
from scenelang.interpreter.top_forms import top_forms

PAPER_FORMS = {"call": "CALL", "union": "UNION", "union-loop": "UNION_LOOP", "transform": "TRANSFORM"}
_DEFINED = re.compile(r"^\(define \(?([^\s()]+)", re.M)


class Prelude:
    """The definitions that every program sees, from the library's modules, expanded once per process and only when a
    program uses a name that is neither a form nor a builtin."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.scope = Scope(None, self._lookup)
        self.definitions: dict[Variable, ast.Define] = {}
        self._exports: dict[str, Any] = {}
        self._pending = list(library.prelude)
        self._homes = {name: module for module in library.prelude for name in _DEFINED.findall(library.modules[module])}
        self._loading = False

    def _lookup(self, name: str) -> Any:
        if name in FORMS:
            return Special(name)
        if name.startswith(STD):
            name = name[len(STD) :]
        builtin = self.library.builtins.get(name)
        if builtin is not None:
            return builtin
        if name in self.library.constants:
            return ConstantBinding(self.library.constants[name])
        module = self._homes.get(name)
        while module in self._pending and not self._loading:
            self._load(self._pending.pop(0))
        return self._exports.get(name)

    def _load(self, module: str) -> None:
        self._loading = True
        source = Source(f"{STD}{module}", self.library.modules[module])
        unit = SourceFile(source, self.scope)
        unit.forms = top_forms(source)
        unit.scan()
        unit.finish()
        for form in unit.asts():
            assert isinstance(form, ast.Define)
            self.definitions[form.target] = form
        errors = [d for d in unit.diagnostics() if d.is_error]
        assert not errors, errors[0].message
        for symbol, binding in unit.scope.bindings.items():
            name = str(symbol)
            if name in PAPER_FORMS:
                binding = PaperForm(PAPER_FORMS[name], binding)
            self._exports[name] = binding
        self._loading = False

    def names(self) -> Iterator[str]:
        """Every name that programs see without defining it."""
        while self._pending and not self._loading:
            self._load(self._pending.pop(0))
        yield from self.library.builtins
        yield from self.library.constants
        yield from (name for name in self._exports if not name.startswith("%"))  # those are the library's own


@lru_cache(maxsize=4)
def prelude_of(library: Library) -> Prelude:
    return Prelude(library)
