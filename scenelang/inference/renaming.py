"""Random names in place of words (the paper, appendix "Ablations": No-W), and the words back again."""

from __future__ import annotations

import ast
import random
import re
import string
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from scenelang.formatting import formatted
from scenelang.grammar.datum import Atom, Datum, ListDatum, Symbol
from scenelang.grammar.printer import print_datum
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source
from scenelang.interpreter.transpile.helper_api import HELPERS

_LENGTH = 8
_LETTER_RUN = re.compile(r"[a-z]{8}")
_DEFINERS = ("define", "bind", "define-record")


@dataclass(frozen=True, slots=True)
class Renamed:
    """A program under other names. ``words`` leads from each random name back to what it stands for."""

    text: str
    words: Mapping[str, str]

    def restored(self, text: str) -> str:
        """A text of a model's with the words back in place of the random names."""
        return _LETTER_RUN.sub(lambda match: self.words.get(match[0], match[0]), text)


def rename_python(text: str, seed: int) -> Renamed:
    """Python with random names for its functions, without comments and docstrings. Raises SyntaxError, ValueError or
    RecursionError for text that is no Python; it is not run."""
    tree = ast.parse(text)
    names = _random_names(_functions(tree), seed, text)
    return Renamed(ast.unparse(ast.fix_missing_locations(_Renaming(names).visit(tree))) + "\n", _turned(names))


def _functions(tree: ast.Module) -> list[str]:
    found = [node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    return [name for name in dict.fromkeys(found) if name not in HELPERS]


class _Renaming(ast.NodeTransformer):
    """Renames functions where they are defined, named and called by word; docstrings are left out."""

    def __init__(self, names: Mapping[str, str]) -> None:
        self._names = names

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.name = self._names.get(node.name, node.name)
        self.generic_visit(node)
        node.body = node.body or [ast.Pass()]
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        node.id = self._names.get(node.id, node.id)
        return node

    def visit_Expr(self, node: ast.Expr) -> ast.AST | None:
        is_docstring = isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        return None if is_docstring else self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """A primitive's word and the names of its attributes stay, also where a function is called the same."""
        if not (isinstance(node.func, ast.Name) and node.func.id == "primitive_call"):
            return self.generic_visit(node)
        node.args = [node.args[0], *map(self._value, node.args[1:])] if node.args else []
        for keyword in node.keywords:
            keyword.value = keyword.value if keyword.arg == "name" else self._value(keyword.value)
        return node

    def _value(self, node: ast.expr) -> ast.expr:
        if isinstance(node, ast.Dict):
            node.values = [self.visit(value) for value in node.values]
            return node
        found: ast.expr = self.visit(node)
        return found

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, str):
            node.value = self._names.get(node.value, node.value)
        return node


def rename_language(text: str, seed: int) -> Renamed:
    """A program of the language with random names for its words and definitions, without comments."""
    forms = read(Source("<program>", text)).forms
    names = _random_names(_defined(forms), seed, text)
    lines = [print_datum(_renamed_datum(form, names)) for form in forms]
    return Renamed(formatted("\n\n".join(lines) + "\n"), _turned(names))


def _defined(forms: Iterable[Datum]) -> list[str]:
    """Words that are bound and names that are defined at the top level."""
    found: list[str] = []
    for form in forms:
        if not isinstance(form, ListDatum) or len(form.items) < 2 or _symbol(form.items[0]) not in _DEFINERS:
            continue
        named: Datum = form.items[1]
        while isinstance(named, ListDatum) and named.items:
            named = named.items[0]
        if isinstance(named, Atom) and isinstance(named.value, str) and named.value:
            found.append(str(named.value))
    return list(dict.fromkeys(found))


def _symbol(datum: Datum) -> str:
    return str(datum.value) if isinstance(datum, Atom) and isinstance(datum.value, Symbol) else ""


def _renamed_datum(datum: Datum, names: Mapping[str, str]) -> Datum:
    if isinstance(datum, Atom):
        value = datum.value
        if isinstance(value, Symbol) and str(value) in names:
            return replace(datum, value=Symbol(names[str(value)]))
        if type(value) is str and value in names:
            return replace(datum, value=names[value])
        return datum
    return replace(datum, items=tuple(_renamed_datum(item, names) for item in datum.items))


def _random_names(names: Iterable[str], seed: int, text: str) -> dict[str, str]:
    """A name of eight letters for each, none of which the text holds."""
    letters = random.Random(seed)
    taken: set[str] = set()
    found: dict[str, str] = {}
    for name in names:
        while True:
            chosen = "".join(letters.choices(string.ascii_lowercase, k=_LENGTH))
            if chosen not in taken and chosen not in text:
                break
        taken.add(chosen)
        found[name] = chosen
    return found


def _turned(names: Mapping[str, str]) -> dict[str, str]:
    return {random_name: name for name, random_name in names.items()}
