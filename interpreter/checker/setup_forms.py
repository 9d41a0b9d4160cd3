"""Cameras, lights, environment and render settings that a program declares: their literal values, names and places."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix, SceneError, near_names
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.checker.common import is_keyword
from scenelang.interpreter.compile.analyze import called_builtin, walk
from scenelang.interpreter.scene.setup import (
    COLOR,
    PROPERTIES,
    TARGET,
    Declared,
    Setup,
    check_together,
    checked_name,
    checked_property,
    misplaced_setup,
    with_declared,
)

if TYPE_CHECKING:
    from scenelang.interpreter.checker.program import Program

_UNKNOWN = object()  # value of an expression that is no literal
_PATH = lazy_pattern(r"\s*/\s*")
_INDEX = lazy_pattern(r"\[[^\]]*\]\Z")
_ANY = ("*", "**")  # of a path, in place of words


def is_setup(node: Any) -> bool:
    """Return whether an expression is a call of ``camera``, ``light``, ``environment`` or ``render-settings``."""
    return called_builtin(node) in PROPERTIES


def setup_problems(program: Program) -> list[Diagnostic]:
    """Return the errors of the declarations of a program, in its main file and in imported ones."""
    problems: list[Diagnostic] = []
    for facts in program.facts:
        if any(name in facts.builtins for name in PROPERTIES):
            problems += _misplaced(facts.form)
            problems += (problem for node in walk(facts.form) if is_setup(node) for problem in _of_call(node))
    setup: Setup = ()
    for form in program.own_forms:
        if not is_setup(form):
            continue
        try:
            setup = with_declared(setup, _declared(form))
        except SceneError as error:
            problems.append(error.diagnostic)
        problems += _unknown_words(program, form)
    return problems


def _misplaced(form: Any) -> Iterator[Diagnostic]:
    """Report declarations in the function of a word, which makes an object."""
    functions = [node.function for node in walk(form) if type(node) is ast.Bind]
    for node in walk(*functions):
        if is_setup(node):
            message, hint = misplaced_setup(called_builtin(node) or "")
            yield Diagnostic("misplaced", message, node.span, hint)


def _keywords(node: Any) -> dict[str, Any]:
    """Return the keyword arguments of a call, by name."""
    return {str(key.value): value for key, value in pairwise(node.arguments) if is_keyword(key)}


def _name(node: Any) -> Any:
    """Return the name that a declaration is given, None without one."""
    first = node.arguments[0] if node.arguments else None
    return None if first is None or is_keyword(first) else _literal(first)


def _of_call(node: Any) -> Iterator[Diagnostic]:
    """Report literal values that a declaration does not take, and keywords that exclude or need each other."""
    form = called_builtin(node) or ""
    known = {key: value for key, value in _keywords(node).items() if key in PROPERTIES[form]}
    for key, value in known.items():
        literal = _literal(value)
        is_named_color = PROPERTIES[form][key].kind is COLOR and type(literal) is str
        if literal is _UNKNOWN or literal is None or is_named_color:
            continue
        try:
            checked_property(form, key, literal)
        except SceneError as error:
            yield Diagnostic(error.name, error.message, value.span, error.hint)
            return
    try:
        if type(_name(node)) is str:
            checked_name(form, _name(node))
        check_together(form, frozenset(known))
    except SceneError as error:
        yield Diagnostic(error.name, error.message, node.span, error.hint)


def _declared(node: Any) -> Declared:
    """Return a declaration without its values; a name that is computed differs from all others."""
    name = _name(node)
    if type(name) is not str:
        name = "" if name is None else f"computed at {node.span.start}"
    return Declared(called_builtin(node) or "", name, {}, node.span)


def _unknown_words(program: Program, node: Any) -> Iterator[Diagnostic]:
    """Report words that a camera or light looks at, which the program does not mention anywhere else."""
    form = called_builtin(node) or ""
    for key, value in _keywords(node).items():
        prop = PROPERTIES[form].get(key)
        literal = _literal(value)
        if prop is None or prop.kind is not TARGET or type(literal) is not str:
            continue
        if any(facts.computes_strings for facts in program.facts):
            return
        known = {*program.all_words, *(text for facts in program.facts for text in facts.strings)}
        for step in _PATH.split(literal) if "\\" not in literal else ():  # which escapes characters of words
            word = _INDEX.sub("", step).strip()
            if word and word not in _ANY and word not in known and not word.startswith("<"):
                near = near_names(word, known)
                listed = " or ".join(f'"{name}"' for name in near)
                hint = f"did you mean {listed}?" if near else None
                fixes = tuple(Fix(f'Change to "{name}"', (Edit(value.span, f'"{name}"'),)) for name in near
                              if step == literal)  # fmt: skip
                message = f'`:{key}` of `{form}` names "{word}", which is no word of the scene'
                yield Diagnostic("declaration-subject", message, value.span, hint, fixes=fixes, near=tuple(near))
                return


def _literal(node: Any) -> Any:
    """Return the value of a literal: a number, text, boolean, or a list of these; else ``_UNKNOWN``."""
    if type(node) is ast.Constant:
        return node.value if type(node.value) in (int, float, str, bool) else _UNKNOWN
    if type(node) is ast.ArrayLiteral or called_builtin(node) == "list":
        items = [_literal(item) for item in (node.items if type(node) is ast.ArrayLiteral else node.arguments)]
        return _UNKNOWN if any(item is _UNKNOWN for item in items) else items
    return _UNKNOWN
