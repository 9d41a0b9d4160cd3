"""A small class as a record: its definition, constructor and methods."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenelang.interpreter.transpile.analysis.effects import PURE
from scenelang.interpreter.transpile.analysis.scopes import Class, Function
from scenelang.interpreter.transpile.writing.blocks import Block, Item, assemble
from scenelang.interpreter.transpile.writing.code import Code, Form, Name, Ref, form, none
from scenelang.interpreter.transpile.writing.control import docstring_lines
from scenelang.interpreter.transpile.writing.records import default_factory

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.statements import StatementWriter


def class_items(w: StatementWriter, record: Class) -> list[Item]:
    """``(define-record name field ...)``, then the constructor and the methods as functions."""
    _check_class(w, record)
    constructor = record.methods.get("__init__")
    fields: list[Code] = []
    for name, default in record.fields:
        value = default_factory(default, w.facts.types)
        if constructor is not None:
            fields.append(Form([w.field_name(name), none()]))
        elif value is not None:
            fields.append(Form([w.field_name(name), w.expr(value)]))
        else:
            fields.append(w.field_name(name))
    definition = form("define-record", Ref(record.variable), *fields, span=w.span(record.node))
    items = [Item("function", definition, PURE, (record.variable,))]
    for name, value in record.constants.items():
        variable = w.records.part(record, "constant", name)
        items.append(Item("define", w.expr(value), w.effect(value), (variable,), Ref(variable)))
    if constructor is not None:
        items.append(_constructor(w, record, constructor))
    for name, method in record.methods.items():
        if name != "__init__":
            items.append(_method(w, record, name, method))
    return items


def _check_class(w: StatementWriter, record: Class) -> None:
    bases = [ast.unparse(base) for base in record.node.bases]
    if any(base not in ("object", "NamedTuple", "typing.NamedTuple") for base in bases):
        raise w.unsupported("a class that inherits", record.node, "use a plain class or a dataclass")
    for name, method in record.methods.items():
        for decorator in getattr(method.node, "decorator_list", []):
            if ast.unparse(decorator) not in ("staticmethod", "property"):
                raise w.unsupported(f"`@{ast.unparse(decorator)}`", decorator)
        if name.startswith("__") and name not in ("__init__", "__post_init__"):
            raise w.error("python-forbidden", f"`{name}` reaches Python's own insides", method.node)


def _constructor(w: StatementWriter, record: Class, constructor: Function) -> Item:
    """A function that makes the record and then does what ``__init__`` does."""
    own, *parameters = constructor.parameters
    header = w.parameters(Function(constructor.node, "", None, parameters=parameters))
    variable = w.records.part(record, "make")
    block = Block()
    made = Form([Ref(record.variable)])
    block.add(Item("define", made, PURE, (own.variable,), Ref(own.variable)))
    body = [*assemble(block.items, None), *w.function_body(constructor), Ref(own.variable)]
    body = [c for c in body if not (type(c) is type(none()) and getattr(c, "value", 0) is None)]
    code = Form(
        [Name("define"), Form([Ref(variable), *header.items], None, header.rest), *body], w.span(constructor.node)
    )
    return Item("function", code, PURE, (variable,))


def _method(w: StatementWriter, record: Class, name: str, method: Function) -> Item:
    variable = w.records.part(record, "method", name)
    code = w.define_function(method, variable)
    note = Code(None)
    note.before = tuple(docstring_lines(method))
    note.blank = True
    return Item("function", code, PURE, (variable,), None, note)
