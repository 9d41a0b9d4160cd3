"""Clauses as `if`, `cond`, `when` and `unless`."""

from __future__ import annotations

from scenelang.interpreter.transpile.analysis.scopes import Variable
from scenelang.interpreter.transpile.writing.blocks import Block
from scenelang.interpreter.transpile.writing.code import (
    Code,
    Form,
    Literal,
    Name,
    Ref,
    form,
    is_form,
    none,
    quote,
)


def branch_value(block: Block, variable: Variable, is_missing: bool) -> Code:
    """A variable at the end of a branch; none where it was set neither in the branch nor before."""
    is_set = any(variable in item.variables for item in block.items)
    return none() if is_missing and not is_set else Ref(variable)


def branch_values(block: Block, variables: list[Variable], missing: set[Variable]) -> Code:
    """The list of several variables at the end of a branch; plain definitions go straight into it."""
    items = block.items
    if (
        [item.variables for item in items] == [(v,) for v in variables]
        and all(item.kind == "define" and type(item.target) is Ref for item in items)
        and not any(item.mentions(v) for item in items for v in variables)
        and not any(item.note.before or item.note.after for item in items)
    ):
        values = [item.value for item in items]
        items.clear()
        if all(type(value) is Literal for value in values):
            return quote(Form(values))
        return form("list", *values)
    if len(items) == 1 and _binds_in_order(items[0].target, variables):
        return items.pop().value
    return form("list", *(branch_value(block, v, v in missing) for v in variables))


def _binds_in_order(target: Code | None, variables: list[Variable]) -> bool:
    """Whether a pattern is just these variables, side by side."""
    if not isinstance(target, Form) or target.rest is not None or len(target.items) != len(variables):
        return False
    return all(type(item) is Ref and item.variable is v for item, v in zip(target.items, variables))


def conditional(clauses: list[Code]) -> Code:
    """``(if test a b)`` where two short branches do, else ``cond``; nested conditions are flattened."""
    last = clauses[-1]
    while isinstance(last, Form) and len(last.items) == 2 and is_form(last, "else") and not last.before:
        inner = last.items[1]
        if not (is_form(inner, "cond") and isinstance(inner, Form)) or inner.before:
            break
        clauses = [*clauses[:-1], *inner.items[1:]]
        last = clauses[-1]
    if len(clauses) == 2 and is_form(clauses[1], "else"):
        first, second = clauses
        assert isinstance(first, Form)
        assert isinstance(second, Form)
        if len(first.items) == 2 and len(second.items) == 2 and not first.before and not second.before:
            return Form([Name("if"), first.items[0], first.items[1], second.items[1]], first.span)
    return Form([Name("cond"), *clauses], clauses[0].span)


def unless(clauses: list[Code]) -> Code | None:
    """``(cond (test none) (else body ...))``, for what it does, is ``(unless test body ...)``."""
    if len(clauses) != 2:
        return None
    first, second = clauses
    assert isinstance(first, Form)
    assert isinstance(second, Form)
    is_nothing = type(first.items[-1]) is Literal and first.items[-1].value is None and len(first.items) == 2
    if not is_nothing or first.before or first.items[-1].before or second.before or not is_form(second, "else"):
        return None
    if type(second.items[-1]) is Literal or len(second.items) < 2:
        return None
    test = first.items[0]
    if is_form(test, "not") and isinstance(test, Form):
        return Form([Name("when"), test.items[1], *second.items[1:]], first.span)
    return Form([Name("unless"), test, *second.items[1:]], first.span)


def hang(code: Code, note: Code) -> None:
    code.before = (*note.before, *code.before)
    code.after = code.after or note.after
    code.blank = code.blank or note.blank
    note.before, note.after, note.blank = (), None, False
