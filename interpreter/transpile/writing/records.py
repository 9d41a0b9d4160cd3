"""Small classes and dataclasses: records, their constructors, fields and methods."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import suggest
from scenelang.interpreter.transpile.analysis.domain import NOTHING, Type
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, Variable
from scenelang.interpreter.transpile.writing.code import Code, Form, Ref
from scenelang.interpreter.transpile.writing.user_calls import call_known

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter
    from scenelang.interpreter.transpile.writing.writer import Writer


class Records:
    """The variables that stand for what a record's definition makes: accessors, setters, methods."""

    def __init__(self) -> None:
        self._made: dict[tuple[Class, str, str], Variable] = {}

    def part(self, record: Class, kind: str, name: str = "") -> Variable:
        """``kind``: ``make`` the constructor of a class with ``__init__``, ``get``, ``set``, ``is``, ``method``."""
        key = (record, kind, name)
        found = self._made.get(key)
        if found is None:
            stem = record.name
            spelled = {
                "make": f"make_{stem}", "get": f"{stem}-{name}", "set": f"set-{stem}-{name}!", "is": f"{stem}?",
                "method": f"{stem}-{name}", "constant": f"{stem}-{name}",
            }[kind]  # fmt: skip
            found = self._made[key] = Variable(spelled, record.variable.function, is_temporary=True)
            found.record = (record.variable, kind, name)
        return found


def _record(w: Writer, node: ast.expr) -> Class:
    classes = w.type(node).classes
    if len(classes) != 1:
        names = ", ".join(sorted(c.name for c in classes)) or "several classes"
        raise w.unsupported("a value of one of several classes", node, f"it may be one of {names}" if classes else None)
    return classes[0]


def read_field(w: ExpressionWriter, node: ast.Attribute) -> Code:
    record = _record(w, node.value)
    if node.attr in record.properties:
        return Form([Ref(w.records.part(record, "method", node.attr)), w.expr(node.value)])
    if node.attr in record.constants:
        return Ref(w.records.part(record, "constant", node.attr))
    fields = [name for name, _ in record.fields]
    if node.attr not in fields:
        hint = suggest(node.attr, [*fields, *record.methods])
        raise w.error("python-name", f"`{record.name}` has no attribute `{node.attr}`", node, hint)
    return Form([Ref(w.records.part(record, "get", node.attr), w.span(node)), w.expr(node.value)])


def write_field(w: ExpressionWriter, target: ast.Attribute, value: Code) -> Code:
    record = _record(w, target.value)
    return Form([Ref(w.records.part(record, "set", target.attr), w.span(target)), w.expr(target.value), value])


def predicate(w: ExpressionWriter, name: ast.expr, value: ast.expr) -> Code:
    variable = w.variable(name)
    record = next(c for c in w.names.classes.values() if c.variable is variable)
    return Form([Ref(w.records.part(record, "is")), w.expr(value)])


def call_record_method(w: ExpressionWriter, node: ast.Call, func: ast.Attribute) -> Code:
    record = _record(w, func.value)
    method = record.methods.get(func.attr)
    if method is None:
        if func.attr in [name for name, _ in record.fields]:
            return Form([w.expr(func), *(w.expr(a) for a in node.args)])
        raise w.error(
            "python-name", f"`{record.name}` has no method `{func.attr}`", func, suggest(func.attr, record.methods)
        )
    function = Ref(w.records.part(record, "method", func.attr), w.span(func))
    is_class = (
        any(c.variable is w.variable(func.value) for c in w.names.classes.values()) if w.variable(func.value) else False
    )
    first = [] if method.is_static or is_class else [w.expr(func.value)]
    return call_known(w, node, function, method, first)


def construct(w: ExpressionWriter, node: ast.Call, record: Class) -> Code:
    """``Point(1, y=2)``."""
    constructor = record.methods.get("__init__")
    if constructor is not None:
        function: Code = Ref(w.records.part(record, "make"), w.span(node.func))
        self_less = _without_self(constructor)
        return call_known(w, node, function, self_less, [])
    fields = [name for name, _ in record.fields]
    if len(node.args) > len(fields):
        raise w.error("python-call", f"`{record.name}` has {len(fields)} fields, got {len(node.args)} values", node)
    items: list[Code] = [w.expr(a) for a in node.args]
    given = set(fields[: len(node.args)])
    for keyword in node.keywords:
        if keyword.arg is None or keyword.arg not in fields:
            raise w.error(
                "python-call",
                f"`{record.name}` has no field `{keyword.arg}`",
                keyword,
                suggest(str(keyword.arg), fields),
            )
        given.add(keyword.arg)
        items += [w.field_key(keyword.arg), w.expr(keyword.value)]
    missing = [name for name, default in record.fields if default is None and name not in given]
    if missing:
        raise w.error("python-call", f"`{record.name}` lacks {', '.join(f'`{m}`' for m in missing)}", node)
    return Form([Ref(record.variable, w.span(node.func)), *items])


def _without_self(constructor: Function) -> Function:
    copy = Function(constructor.node, constructor.name, constructor.parent, parameters=constructor.parameters[1:])
    return copy


def default_factory(node: ast.expr | None, *tables: dict[ast.AST, Type]) -> ast.expr | None:
    """The default of a dataclass's field: the value, or the call that ``field(default_factory=f)`` makes, with the
    type that ``tables`` have for it."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "field":
        for keyword in node.keywords:
            if keyword.arg == "default":
                return keyword.value
            if keyword.arg == "default_factory":
                made = ast.copy_location(ast.Call(keyword.value, [], []), node)
                for table in tables:
                    table[made] = table.get(node, NOTHING)
                return made
        return None
    return node
