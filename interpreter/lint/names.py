"""Names that nothing uses, and names of the library that are called where something else is meant by them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.interpreter.lint.removal import is_followed, is_inert, written_nodes
from scenelang.interpreter.scope import Variable

_MACROS = ("define-syntax", "let-syntax", "letrec-syntax", "define-macro")


def is_written(variable: Variable) -> bool:
    """Whether the name stands in the program as a name that somebody gave: no macro's, no form's own."""
    span = variable.span
    if span is None or span.expansion is not None or variable.from_macro:
        return False
    return span.text.lstrip(":").partition("::")[0] == variable.name


def unused_locals(nodes: Sequence[Any], form: Any) -> Iterator[Diagnostic]:
    """Local definitions and parameters that nothing reads. What a caller prescribes is left alone: the positional
    parameters of functions without a name of their own, and of entity functions."""
    if any(head in form.span.text for head in _MACROS):
        return  # a macro that nobody has used yet may read them
    used = {node.target for node in nodes if type(node) is ast.Reference}
    named = _named_functions(nodes, form)
    removable = _removable(form)
    for node in nodes:
        if type(node) is ast.Define and node is not form:
            if isinstance(node.target, Variable):
                fixes = (remove(node),) if id(node) in removable else ()
                yield from _unused(node.target, used, "is never used", fixes)
        elif type(node) is ast.Lambda:
            for parameter in node.parameters:
                free = parameter.kind in ("keyword", "optional") or (parameter.kind == "required" and id(node) in named)
                if free and isinstance(parameter.target, Variable):
                    yield from _unused(parameter.target, used, "is a parameter that is never used")


def _named_functions(nodes: Iterable[Any], form: Any) -> set[int]:
    """Functions that only their name calls, as far as can be seen."""
    found = {id(node.value) for node in nodes if type(node) is ast.Define}
    passed = set()
    for node in nodes:
        operands = node.arguments if type(node) in (ast.Application, ast.Call) else ()
        passed |= {item.target for item in operands if type(item) is ast.Reference}
        if type(node) is ast.UnionLoop and type(node.function) is ast.Reference:
            passed.add(node.function.target)
    for node in nodes:
        if type(node) is ast.Define and node.target in passed:
            found.discard(id(node.value))
    if type(form) is ast.Define:
        found.discard(id(form.value))  # other forms may pass it on
    return found


def _removable(form: Any) -> set[int]:
    """Definitions of bodies that may go if nothing reads them: they do nothing else, nothing assigns them, and a value
    comes after them."""
    found = set()
    for node in written_nodes(form):
        if type(node) is not ast.Body:
            continue
        ready: set[Any] = set()
        for item in node.items[:-1]:
            if type(item) is not ast.Define or not isinstance(item.target, Variable):
                continue
            if can_go(item, ready) and not item.target.assigned and is_followed(form, item.span):
                found.add(id(item))
            ready.add(item.target)
    return found


def can_go(form: Any, ready: Collection[Any] = ()) -> bool:
    """Whether a form is a ``define`` that does nothing but define; ``ready``: the variables defined before it."""
    if type(form) is not ast.Define or not form.span.text.startswith("(define ") or form.span.expansion is not None:
        return False
    return isinstance(form.target, Variable) and is_inert(form.value, ready)


def remove(form: Any, safe: bool = True) -> Fix:
    """The fix that takes out a definition."""
    return Fix("Remove it", (Edit(form.span, ""),), safe)


def _unused(variable: Variable, used: set[Any], what: str, fixes: tuple[Fix, ...] = ()) -> Iterator[Diagnostic]:
    if variable not in used and is_written(variable) and not variable.name.startswith("_"):
        yield Diagnostic("unused", f"`{variable.name}` {what}", variable.span, fixes=fixes)


# --- names of the library -------------------------------------------------------------------------------------------


def shadowed_calls(nodes: Sequence[Any], form: Any) -> Iterator[Diagnostic]:
    """Calls of a parameter or local that cannot be a function, though the library has a function of that name."""
    values = _values(nodes)
    for node in nodes:
        if type(node) is not ast.Application or type(node.function) is not ast.Reference:
            continue
        variable = node.function.target
        if isinstance(variable, Variable) and values.get(variable) and variable.shadows:
            name = variable.name
            message = f"`{name}` is {values[variable]} here, not the function of the library"
            hint = f"the library's function is always `std/{name}`"
            yield Diagnostic("shadowed-builtin", message, node.function.span, hint)


def _values(nodes: Iterable[Any]) -> dict[Variable, str]:
    """What the variables are that hold no function, as far as the text tells."""
    found: dict[Variable, str] = {}
    for node in nodes:
        if type(node) is ast.Lambda:
            for parameter in node.parameters:
                if isinstance(parameter.target, Variable) and _is_data(parameter):
                    found[parameter.target] = "a parameter"
        elif type(node) is ast.Define and isinstance(node.target, Variable) and not node.target.assigned:
            if type(node.value) in (ast.Constant, ast.ArrayLiteral, ast.Call, ast.Transform, ast.Union):
                found[node.target] = "a variable"
    return found


def _is_data(parameter: ast.Parameter) -> bool:
    if parameter.type is not None:
        return parameter.type.name not in ("Function", "Any")
    return parameter.kind == "keyword" and (
        parameter.default is None or type(parameter.default) in (ast.Constant, ast.ArrayLiteral)
    )
