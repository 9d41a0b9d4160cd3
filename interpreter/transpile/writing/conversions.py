"""Conversion of expressions to the type that their context requires, and patterns and clauses of loops."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    BOOL,
    CONTAINERS,
    DICT,
    FLOAT,
    FUNCTION,
    INT,
    LIST,
    NONE,
    POSE,
    RECORD,
    SEQUENCES,
    SHAPE,
    STR,
    STREAM,
    UNKNOWN,
    AbstractType,
)
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable
from scenelang.interpreter.transpile.writing.code import (
    Brackets,
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    number,
)
from scenelang.interpreter.transpile.writing.writer import Writer

ALWAYS_TRUE = FUNCTION | RECORD | POSE | STREAM


# Tests and numbers.


def write_test(w: Writer, node: ast.expr) -> Code:
    """Return a test, which is #f or none in the language wherever it is false in Python."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        inner = write_test(w, node.operand)
        if is_form(inner, "not") and isinstance(inner, FormCode):
            return inner.items[1]
        return form("not", inner, span=w.span(node))
    if isinstance(node, ast.BoolOp):
        head = "and" if isinstance(node.op, ast.And) else "or"
        return form(head, *(write_test(w, value) for value in node.values), span=w.span(node))
    if isinstance(node, ast.Constant):
        return LiteralCode(bool(node.value), w.span(node))
    return truth(w, node, w.type(node))


def truth(w: Writer, node: ast.expr, found: AbstractType) -> Code:
    """Return the truth value of ``node`` in Python."""
    code = w.expr(node)
    if not found.kinds or found.only(BOOL | NONE | ALWAYS_TRUE):
        return code
    rest = found.without(NONE | BOOL)
    some = _non_empty_test(w, code, node, rest)
    if some is None or (found.kinds & BOOL and rest.kinds):
        return dynamic(w, "py-truthy?", code)
    if found.kinds & (NONE | BOOL):
        if not w.is_simple(node):
            return dynamic(w, "py-truthy?", code)
        return form("and", w.expr(node), some, span=w.span(node))
    return some


def _non_empty_test(w: Writer, code: Code, node: ast.expr, found: AbstractType) -> Code | None:
    """Return the test that a value of a known kind is not zero or empty, or None for other kinds."""
    if found.only(INT | FLOAT):
        return form("not", form("zero?", code), span=w.span(node))
    if found.only(CONTAINERS | STR):
        if is_form(code, "set-intersection") or not is_form(code, "primitives"):
            return form("not", form("empty?", code), span=w.span(node))
    if found.only(SHAPE | LIST):
        return form("not", form("empty?", form("primitives", code)), span=w.span(node))
    return None


def numeric(w: Writer, node: ast.expr) -> Code:
    """Return an operand of arithmetic, with a Boolean as 1 or 0."""
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return number(int(node.value), w.span(node))
    if w.type(node).only(BOOL):
        return form("if", write_test(w, node), number(1), number(0), span=w.span(node))
    return w.expr(node)


def printable(w: Writer, node: ast.expr) -> Code:
    """Return a value that is formatted as in Python."""
    found = w.type(node)
    if not found.kinds or found.only(INT | FLOAT | STR):
        return w.expr(node)
    return dynamic(w, "py-str", w.expr(node))


def dynamic(w: Writer, operator: str, *arguments: Code) -> Code:
    """Return a call of a dynamic operator, for operands whose types inference does not determine."""
    w.imports.add("std/python.scene")
    return form(operator, *arguments)


def is_constant(node: ast.expr) -> bool:
    """Return whether ``node`` is a literal constant, possibly a number with a sign."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        return isinstance(node.operand, ast.Constant) and isinstance(node.operand.value, (int, float))
    return isinstance(node, ast.Constant)


# Vectors, arrays and sequences.


def write_vector(w: Writer, node: ast.expr) -> Code:
    """Return an expression where a vector or colour is expected; displays become arrays."""
    if isinstance(node, (ast.Tuple, ast.List)) and node.elts and not w.is_mutated(node):
        if not any(isinstance(e, ast.Starred) for e in node.elts):
            items = [w.comment_item(numeric(w, element), element) for element in node.elts]
            return Brackets(items, w.span(node))
    if isinstance(node, ast.Call) and len(node.args) == 1 and not isinstance(node.args[0], ast.Starred):
        path = w.paths.of(node.func)
        if path in ("numpy.array", "numpy.asarray") and not w.is_mutated(node):
            return write_vector(w, node.args[0])
        if path in ("tuple", "list") and w.type(node.args[0]).only(ARRAY | SEQUENCES):
            return write_vector(w, node.args[0])
    if isinstance(node, ast.IfExp):
        return form(
            "if", write_test(w, node.test), write_vector(w, node.body), write_vector(w, node.orelse), span=w.span(node)
        )
    return w.expr(node)


def write_array(w: Writer, node: ast.expr) -> Code:
    """Return an operand of array arithmetic; sequences become arrays."""
    if isinstance(node, (ast.Tuple, ast.List)) and node.elts and not w.is_mutated(node):
        if not any(isinstance(e, ast.Starred) for e in node.elts):
            return Brackets([write_array(w, e) for e in node.elts], w.span(node))
    if isinstance(node, ast.Call) and w.paths.of(node.func) in ("tuple", "list") and len(node.args) == 1:
        return write_array(w, node.args[0])
    found = w.type(node)
    code = w.expr(node)
    if found.only(SEQUENCES) and not isinstance(code, Brackets):
        return form("array", code, span=w.span(node))
    return code


def write_iterable(w: Writer, node: ast.expr) -> Code:
    """Return the iterable of a loop."""
    found = w.type(node)
    if found.kinds & SHAPE:
        return form("primitives", w.expr(node), span=w.span(node))
    if found.kinds & UNKNOWN and not isinstance(node, ast.Call):
        return dynamic(w, "py-iter", w.expr(node))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "keys":
        if w.type(node.func.value).only(DICT):
            return w.expr(node.func.value)
    if _copies_view(w, node):
        assert isinstance(node, ast.Call)
        return w.expr(node.args[0])  # already a new list, independent of the table
    if isinstance(node, ast.Call) and w.paths.of(node.func) in ("list", "tuple", "iter") and len(node.args) == 1:
        if not isinstance(node.args[0], ast.Starred) and not w.is_mutated(node):
            inner = w.type(node.args[0])
            if inner.kinds & CONTAINERS and not any(s.is_mutated for s in inner.sites):
                return write_iterable(w, node.args[0])
    return w.expr(node)


def _copies_view(w: Writer, node: ast.expr) -> bool:
    """Return whether ``node`` copies a view of a table, as in ``list(table.keys())``."""
    if not isinstance(node, ast.Call) or w.paths.of(node.func) not in ("list", "tuple") or len(node.args) != 1:
        return False
    inner = node.args[0]
    return (
        isinstance(inner, ast.Call)
        and isinstance(inner.func, ast.Attribute)
        and inner.func.attr in ("keys", "values", "items")
    )


# Patterns, and the clauses of loops and comprehensions.


def write_pattern(w: Writer, target: ast.expr) -> Code:
    """Return the pattern of a loop or assignment target; a starred element must be the last."""
    if isinstance(target, ast.Name):
        variable = w.names.variables[target]
        return _binder(w, variable, target)
    if isinstance(target, (ast.Tuple, ast.List)):
        elements = target.elts
        if any(isinstance(e, ast.Starred) for e in elements[:-1]):
            raise w.unsupported("a starred element before the end of this target", target)
        if elements and isinstance(elements[-1], ast.Starred):
            return FormCode(
                [write_pattern(w, e) for e in elements[:-1]], w.span(target), write_pattern(w, elements[-1].value)
            )
        return FormCode([write_pattern(w, e) for e in elements], w.span(target))
    raise w.unsupported("this assignment target", target)


def _binder(w: Writer, variable: PythonVariable, node: ast.AST) -> Code:
    """Return a variable in a pattern; ``_`` if it has that name and is never read."""
    if variable in w.late_variables:
        return VariableRef(w.late_variables[variable], w.span(node))
    if variable.name == "_" and not variable.reads:
        return Name("_", w.span(node))
    return VariableRef(variable, w.span(node))


def loop_head(w: Writer, kind: str, generators: list[ast.comprehension]) -> list[Code]:
    """Return the head and clauses of a comprehension."""
    nested = len(generators) > 1
    clauses: list[Code] = []
    for generator in generators:
        clauses += loop_clauses(w, generator.target, generator.iter, parallel=not nested)
        for condition in generator.ifs:
            clauses += condition_clause(w, condition)
    return [Name(f"for{'*' if nested else ''}{kind}"), FormCode(clauses)]


def condition_clause(w: Writer, condition: ast.expr, holds: bool = True) -> list[Code]:
    """Return ``:when test``, or ``:unless`` for a negated test."""
    while isinstance(condition, ast.UnaryOp) and isinstance(condition.op, ast.Not):
        condition, holds = condition.operand, not holds
    return [Key("when" if holds else "unless"), write_test(w, condition)]


def loop_clauses(w: Writer, target: ast.expr, iterable: ast.expr, parallel: bool) -> list[Code]:
    """Return the clauses of ``for target in iterable``; ``zip`` becomes parallel clauses where these are allowed."""
    path = w.paths.of(iterable.func) if isinstance(iterable, ast.Call) else None
    if (
        parallel
        and path == "zip"
        and isinstance(iterable, ast.Call)
        and isinstance(target, (ast.Tuple, ast.List))
        and len(target.elts) == len(iterable.args)
        and not any(isinstance(e, ast.Starred) for e in (*target.elts, *iterable.args))
    ):
        sources = parallel_sources(w, iterable.args)
        return [FormCode([write_pattern(w, t), source]) for t, source in zip(target.elts, sources)]
    return [FormCode([write_pattern(w, target), write_iterable(w, iterable)])]


def parallel_sources(w: Writer, sources: Sequence[ast.expr]) -> list[Code]:
    """Return the sequences of a ``zip``; ``cycle(xs)`` is repeated to the length of the first other sequence."""
    is_cycle = [isinstance(s, ast.Call) and w.paths.of(s.func) == "itertools.cycle" for s in sources]
    other = next((s for s, cycles in zip(sources, is_cycle) if not cycles), None)
    codes: list[Code] = []
    for source, cycles in zip(sources, is_cycle):
        if cycles and other is not None and isinstance(source, ast.Call) and len(source.args) == 1:
            if w.effect(other).has_effect:
                raise w.unsupported("`cycle` zipped with a sequence that has side effects", source)
            codes.append(form("repeat", write_iterable(w, source.args[0]), form("length", write_iterable(w, other))))
        else:
            codes.append(write_iterable(w, source))
    return codes
