"""Definitions of functions, words and classes."""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.collect import PURE, Effect
from scenelang.interpreter.transpile.analysis.inference import NOTHING, AbstractType
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, PythonVariable
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, assemble
from scenelang.interpreter.transpile.writing.bodies import function_body
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    LiteralCode,
    Name,
    VariableRef,
    form,
    kebab,
    lambda_list,
    none,
)
from scenelang.interpreter.transpile.writing.expressions import check_path
from scenelang.interpreter.transpile.writing.helpers import possible_words
from scenelang.interpreter.transpile.writing.user_calls import may_stay, write_parameters
from scenelang.interpreter.transpile.writing.writer import Writer, comment_lines, docstring_lines, text_of

# Functions.


def write_function(w: Writer, node: ast.FunctionDef, block: Block, note: Code) -> None:
    """``def``: a definition, and the word of a registered function."""
    function = w.names.functions[node]
    for decorator in node.decorator_list:
        _check_decorator(w, decorator)
    if function.parent is w.names.module:
        _write_top_function(w, function, node, block, note)
    else:
        _write_inner_function(w, function, node, block, note)


def _write_inner_function(w: Writer, function: Function, node: ast.FunctionDef, block: Block, note: Code) -> None:
    assert function.variable is not None
    if node.args.defaults or node.args.kw_defaults:
        _hoist_defaults(w, function, block)
    note.before = (*note.before, *docstring_lines(function))
    code = _define_function(w, function, function.variable)
    if function.variable.is_cell:
        code = FormCode([Name("set!"), VariableRef(function.variable), _as_lambda(w, function)], w.span(node))
        effect = Effect(writes=frozenset((function.variable,)))
        if function.variable in w.places.definitions.get(node, ()):
            code.items[0] = Name("define")
        block.add_effect(code, effect, note)
        return
    if len(function.variable.stores) > 1 and len(function.variable.functions) < len(function.variable.stores):
        block.define(function.variable, _as_lambda(w, function), PURE, note, nests=False)
        return
    if function.variable.functions[-1] is not function and len(set(function.variable.functions)) > 1:
        block.define(function.variable, _as_lambda(w, function), PURE, note, nests=False)
        return
    block.add(BlockItem("function", code, PURE, (function.variable,), None, note))
    if function.is_registered:  # from now on its word means this one
        bind = form("bind", LiteralCode(function.word), VariableRef(function.variable), span=w.span(node))
        block.add_effect(bind, Effect(changes=True))


def _check_decorator(w: Writer, decorator: ast.expr) -> None:
    called = decorator.func if isinstance(decorator, ast.Call) else decorator
    path = w.paths.of(called) or ""
    if path in ("register", "register_animation"):
        arguments = [*decorator.args, *(k.value for k in decorator.keywords)] if isinstance(decorator, ast.Call) else []
        for argument in arguments:
            if not isinstance(argument, ast.Constant):
                raise w.unsupported("a computed text in `register`", argument)
        return
    if path in ("functools.lru_cache", "functools.cache", "staticmethod", "property", "lru_cache", "cache"):
        return
    check_path(w, called, path) if path else None
    raise w.unsupported(f"the decorator `@{w.text.text(decorator)}`", decorator)


def _define_function(w: Writer, function: Function, variable: PythonVariable) -> FormCode:
    """``(define (name parameter ...) body ...)``."""
    signature = write_parameters(w, function)
    header = FormCode([VariableRef(variable, w.span(function.node)), *signature.items], signature.span, signature.rest)
    return FormCode([Name("define"), header, *function_body(w, function)], w.span(function.node))


def _as_lambda(w: Writer, function: Function) -> FormCode:
    """``(lambda (parameter ...) body ...)``."""
    return FormCode(
        [Name("lambda"), lambda_list(write_parameters(w, function)), *function_body(w, function)],
        w.span(function.node),
    )


def _hoist_defaults(w: Writer, function: Function, block: Block) -> None:
    """Python evaluates defaults once, at the definition: those that could differ later become variables."""
    for parameter in function.parameters:
        node = parameter.default
        if node is None or may_stay(w, node):
            continue
        variable = PythonVariable(f"{function.name}_{parameter.variable.name}", None, is_temporary=True)
        block.define(variable, w.expr(node), w.effect(node), Code(None), nests=False)
        w.defaults[node] = variable


# Functions of the top level, which may be words.


def _write_top_function(w: Writer, function: Function, node: ast.FunctionDef, block: Block, note: Code) -> None:
    is_last = function.variable is None or function.variable.functions[-1] is function
    is_word = function.is_registered and w.analysed.words.get(function.word or "") is function
    if not is_word and not is_last:
        w.comments.until(node.end_lineno or node.lineno)
        return  # replaced before anything could call it
    _hoist_defaults(w, function, block)
    note.blank = True
    note.before = (*note.before, *docstring_lines(function), *_register_text(function))
    if not function.is_registered or not is_word:
        assert function.variable is not None
        block.add(BlockItem("function", _define_function(w, function, function.variable), PURE, (), None, note))
        return
    assert function.word is not None
    word = LiteralCode(function.word)
    if is_last and (function.is_called_directly or function.is_passed_on) and function.variable is not None:
        block.add(BlockItem("function", _define_function(w, function, function.variable), PURE, (), None, note))
        bind = form("bind", word, VariableRef(function.variable), span=w.span(node))
        block.add(BlockItem("function", bind, PURE))
    else:
        bind = form("bind", word, _as_lambda(w, function), span=w.span(node))
        block.add(BlockItem("function", bind, PURE, (), None, note))
    texts = dict.fromkeys(text for text in (function.text, function.text.partition(";")[0].strip()) if text)
    if texts and _calls_by_text(w):
        for text in texts:
            if text != function.word and w.analysed.words.get(text) is function:
                block.add(BlockItem("function", form("bind", LiteralCode(text), form("retrieve", word)), PURE))


def _calls_by_text(w: Writer) -> bool:
    """Whether a word that is worked out while the program runs may be the text of a registration."""
    computed = [
        node.args[0] for node in ast.walk(w.text.tree)
        if isinstance(node, ast.Call) and w.paths.of(node.func) == "library_call" and node.args
        and not isinstance(node.args[0], ast.Constant)
    ]  # fmt: skip
    words = w.analysed.words
    return any(
        not known or any(text not in words or words[text].word != text for text in known)
        for known in (possible_words(w, node) for node in computed)
    )


def _register_text(function: Function) -> list[str]:
    """The text that a function is registered with, unless it only repeats the name."""
    text = function.text.strip()
    is_name = text.replace(" ", "_").lower() == (function.word or "").lower()
    return text.splitlines() if text and not is_name else []


# A small class as a record: its definition, constructor and methods.


def write_class(w: Writer, node: ast.ClassDef, block: Block, note: Code) -> None:
    """A small class as a record."""
    record: Class = w.names.classes[node]
    text = text_of(node.body[0]) if node.body else None
    note.before = (*note.before, *(comment_lines(text) if text else ()))
    for position, item in enumerate(_class_items(w, record)):
        if position == 0:
            item.note = note
        block.add(item)


def _class_items(w: Writer, record: Class) -> list[BlockItem]:
    """``(define-record name field ...)``, then the constructor and the methods as functions."""
    _check_class(w, record)
    constructor = record.methods.get("__init__")
    fields: list[Code] = []
    for name, default in record.fields:
        value = _default_factory(default, w.facts.types)
        if constructor is not None:
            fields.append(FormCode([Name(kebab(name)), none()]))
        elif value is not None:
            fields.append(FormCode([Name(kebab(name)), w.expr(value)]))
        else:
            fields.append(Name(kebab(name)))
    definition = form("define-record", VariableRef(record.variable), *fields, span=w.span(record.node))
    items = [BlockItem("function", definition, PURE, (record.variable,))]
    for name, value in record.constants.items():
        variable = w.records.part(record, "constant", name)
        items.append(BlockItem("define", w.expr(value), w.effect(value), (variable,), VariableRef(variable)))
    if constructor is not None:
        items.append(_constructor(w, record, constructor))
    for name, method in record.methods.items():
        if name != "__init__":
            items.append(_method(w, record, name, method))
    return items


def _check_class(w: Writer, record: Class) -> None:
    bases = [ast.unparse(base) for base in record.node.bases]
    if any(base not in ("object", "NamedTuple", "typing.NamedTuple") for base in bases):
        raise w.unsupported("a class that inherits", record.node, "use a plain class or a dataclass")
    for name, method in record.methods.items():
        for decorator in getattr(method.node, "decorator_list", []):
            if ast.unparse(decorator) not in ("staticmethod", "property"):
                raise w.unsupported(f"`@{ast.unparse(decorator)}`", decorator)
        if name.startswith("__") and name not in ("__init__", "__post_init__"):
            raise w.error("python-forbidden", f"`{name}` reaches Python's own insides", method.node)


def _constructor(w: Writer, record: Class, constructor: Function) -> BlockItem:
    """A function that makes the record and then does what ``__init__`` does."""
    own, *parameters = constructor.parameters
    header = write_parameters(w, Function(constructor.node, "", None, parameters=parameters))
    variable = w.records.part(record, "make")
    block = Block()
    made = FormCode([VariableRef(record.variable)])
    block.add(BlockItem("define", made, PURE, (own.variable,), VariableRef(own.variable)))
    body = [*assemble(block.items, None), *function_body(w, constructor), VariableRef(own.variable)]
    body = [c for c in body if not (type(c) is type(none()) and getattr(c, "value", 0) is None)]
    code = FormCode(
        [Name("define"), FormCode([VariableRef(variable), *header.items], None, header.rest), *body],
        w.span(constructor.node),
    )
    return BlockItem("function", code, PURE, (variable,))


def _method(w: Writer, record: Class, name: str, method: Function) -> BlockItem:
    variable = w.records.part(record, "method", name)
    code = _define_function(w, method, variable)
    note = Code(None)
    note.before = tuple(docstring_lines(method))
    note.blank = True
    return BlockItem("function", code, PURE, (variable,), None, note)


def _default_factory(node: ast.expr | None, *tables: dict[ast.AST, AbstractType]) -> ast.expr | None:
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
