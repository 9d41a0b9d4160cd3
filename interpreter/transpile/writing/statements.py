"""Python statements, definitions of functions and classes, and the whole program. Straight-line code becomes
definitions, branches become values; only what outlives a turn of a loop or is seen by a closure is assigned in place.

Each kind of statement has its function in a table. What stands inside a statement is written by ``w.expr`` and
``w.statement``, which comes back to this table.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.transpile.analysis.collect import PURE, Effect
from scenelang.interpreter.transpile.analysis.inference import DICT, NOTHING, AbstractType
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, PythonVariable
from scenelang.interpreter.transpile.writing.assignments import (
    set_item,
    write_annotated_assign,
    write_assign,
    write_augmented_assign,
)
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, assemble
from scenelang.interpreter.transpile.writing.bodies import (
    define_cells,
    finish_note,
    function_body,
    open_note,
    returned_value,
    write_if,
    write_try,
)
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
    quote,
)
from scenelang.interpreter.transpile.writing.conversions import write_test
from scenelang.interpreter.transpile.writing.expressions import check_path
from scenelang.interpreter.transpile.writing.helpers import possible_words
from scenelang.interpreter.transpile.writing.loops import (
    add_to,
    adds_to,
    finish_collections,
    start_collection,
    write_for,
    write_while,
)
from scenelang.interpreter.transpile.writing.user_calls import may_stay, write_parameters
from scenelang.interpreter.transpile.writing.writer import Writer, comment_lines, docstring_lines, text_of

# The program: constants, functions, words and the root, from the Python's top level.


def opening_texts(w: Writer) -> list[str]:
    """The strings that open the program, which say what it is: lines of its header."""
    lines: list[str] = []
    for statement in w.text.tree.body:
        text = text_of(statement)
        if text is not None:
            lines += [*([""] if lines else []), *comment_lines(text)]
        elif not _opens(statement):
            break
    return lines


def write_program(w: Writer) -> list[Code]:
    """The forms of the program in the order of the Python, the root last."""
    block = Block()
    body = w.text.tree.body
    opening = next((i for i, s in enumerate(body) if not _opens(s)), len(body))
    for statement in body[opening:]:
        w.statement(statement, block)
    forms = [_top_form(item) for item in block.items]
    if w.analysed.root is not None and w.analysed.root.word is not None:
        scene = form("scene", LiteralCode(w.analysed.root.word), span=w.span(w.analysed.root.node))
        scene.blank = True
        forms.append(scene)
    imports: list[Code] = [form("import", LiteralCode(path)) for path in sorted(w.imports)]
    return [*imports, *forms]


def _top_form(item: BlockItem) -> Code:
    if item.kind == "define":
        assert item.target is not None
        head = "define" if type(item.target) is VariableRef else "define-values"
        code: Code = form(head, item.target, item.value, span=item.value.span)
    else:
        code = item.value
    code.before = (*item.note.before, *code.before)
    code.after = code.after or item.note.after
    code.blank = code.blank or item.note.blank
    return code


def _opens(statement: ast.stmt) -> bool:
    return isinstance(statement, (ast.Import, ast.ImportFrom)) or text_of(statement) is not None


# Statements.


def write_statement(w: Writer, node: ast.stmt, block: Block) -> None:
    """Add a statement to a block. A mistake is noted, so that others show as well."""
    note = Code(None)
    try:
        if text_of(node) is not None:
            w.pending_texts += comment_lines(text_of(node) or "")
            return
        if isinstance(node, (ast.Pass, ast.Global, ast.Nonlocal, ast.Import, ast.ImportFrom)):
            return  # an import that is not used is ignored; a use is looked at where it stands
        open_note(w, note, node)
        define_cells(w, node, block)
        write = _STATEMENTS.get(type(node))
        if write is None:
            raise w.unsupported(f"`{type(node).__name__.lower()}`", node)
        collecting = adds_to(w, node, block)
        if collecting is not None:
            add_to(w, collecting, node, block, note)
        elif not start_collection(w, node, block, note):
            write(w, node, block, note)
        finish_note(w, note, node)
        finish_collections(w, node, block)
    except SceneError as error:
        if error.span is None:
            error.span = w.span(node)
        w.diagnostics.append(error.diagnostic)
        finish_note(w, note, node)


def _expression(w: Writer, node: ast.Expr, block: Block, note: Code) -> None:
    if w.place.function is w.names.module:
        path = w.paths.of(node.value.func) if isinstance(node.value, ast.Call) else None
        if path in ("numpy.random.seed", "random.seed"):
            w.warn(
                "python-ignored",
                "a seed set here has no effect: the streams are seeded when the scene begins", node,
                "`--seed N` sets the seed",
            )  # fmt: skip
            return
        if path == "library_call":
            return  # a scene that is thrown away
    value = node.value
    if isinstance(value, (ast.Yield, ast.YieldFrom)):
        if w.place.yields is None:
            raise w.error("python-syntax", "`yield` outside a function", node)
        frames = VariableRef(w.place.yields)
        code = w.expr(value.value) if value.value is not None else none()
        head = "push!" if isinstance(value, ast.Yield) else "extend!"
        block.add_effect(form(head, frames, code, span=w.span(node)), Effect(changes=True), note)
        return
    if node in w.analysed.collections.functional:
        _functional(w, node, block, note)
        return
    if isinstance(value, ast.Constant):
        return
    effect = w.effect(value)
    if not effect.acts and not isinstance(value, ast.Call):
        return
    block.add_effect(w.expr(value), effect, note)


def _functional(w: Writer, node: ast.Expr, block: Block, note: Code) -> None:
    """``random.shuffle(xs)``, ``xs.sort()`` of a list that was just made: a new list instead."""
    call = node.value
    assert isinstance(call, ast.Call)
    target = call.func.value if isinstance(call.func, ast.Attribute) and not w.paths.of(call.func) else call.args[0]
    variable = w.names.variables[target]
    code = w.expr(call)
    if any(site.is_mutated for site in w.type(target).sites):
        block.add_effect(code, w.effect(call) | Effect(changes=True), note)
        return
    assert isinstance(code, FormCode)
    head = code.items[0]
    assert isinstance(head, Name)
    code.items[0] = Name(head.text.rstrip("!"))
    block.define(variable, code, w.effect(call), note)


def _assert(w: Writer, node: ast.Assert, block: Block, note: Code) -> None:
    items = [write_test(w, node.test)]
    if node.msg is not None and isinstance(node.msg, ast.Constant):
        items.append(w.expr(node.msg))
    block.add_effect(form("assert", *items, span=w.span(node)), w.effect(node.test) | Effect(changes=True), note)


def _raise(w: Writer, node: ast.Raise, block: Block, note: Code) -> None:
    message: Code = LiteralCode("error")
    if isinstance(node.exc, ast.Call) and node.exc.args:
        message = w.expr(node.exc.args[0])
    elif isinstance(node.exc, ast.Name):
        message = LiteralCode(node.exc.id)
    block.add_effect(form("error", message, span=w.span(node)), Effect(changes=True), note, leaves=True)


def _return(w: Writer, node: ast.Return, block: Block, note: Code) -> None:
    if w.place.function is w.names.module:
        raise w.error("python-syntax", "`return` outside a function", node)
    jump = w.place.returns.escape()
    code = returned_value(w, node)
    is_nothing = type(code) is LiteralCode and code.value is None
    block.add_effect(
        FormCode([VariableRef(jump), *([] if is_nothing else [code])], w.span(node)),
        Effect(changes=True),
        note,
        leaves=True,
    )


def _break(w: Writer, node: ast.Break, block: Block, note: Code) -> None:
    if not w.place.breaks:
        raise w.error("python-syntax", "`break` outside a loop", node)
    block.add_effect(
        FormCode([VariableRef(w.place.breaks[-1].escape())], w.span(node)),
        Effect(changes=True),
        note,
        leaves=True,
    )


def _continue(w: Writer, node: ast.Continue, block: Block, note: Code) -> None:
    if not w.place.continues:
        raise w.error("python-syntax", "`continue` outside a loop", node)
    jump = w.place.continues[-1]
    items = [VariableRef(jump.escape()), *([jump.value()] if jump.value is not None else [])]
    block.add_effect(FormCode(items, w.span(node)), Effect(changes=True), note, leaves=True)


def _delete(w: Writer, node: ast.Delete, block: Block, note: Code) -> None:
    for target in node.targets:
        if isinstance(target, ast.Name):
            continue
        if not isinstance(target, ast.Subscript):
            raise w.unsupported("this `del`", node)
        if isinstance(target.slice, ast.Slice):
            code = set_item(w, target, quote(FormCode([])))
            block.add_effect(code, Effect(changes=True), note)
            continue
        head = "remove-key!" if w.type(target.value).only(DICT) else "remove-at!"
        block.add_effect(form(head, w.expr(target.value), w.expr(target.slice)), Effect(changes=True), note)


def _with(w: Writer, node: ast.With, block: Block, note: Code) -> None:
    for item in node.items:
        w.expr(item.context_expr)
    raise w.unsupported("`with`", node)


# Definitions of functions.


def _function(w: Writer, node: ast.FunctionDef, block: Block, note: Code) -> None:
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


def _class(w: Writer, node: ast.ClassDef, block: Block, note: Code) -> None:
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


_STATEMENTS: Mapping[type[ast.stmt], Callable[[Writer, Any, Block, Code], None]] = MappingProxyType({
    ast.AnnAssign: write_annotated_assign, ast.Assert: _assert, ast.Assign: write_assign,
    ast.AugAssign: write_augmented_assign, ast.Break: _break, ast.ClassDef: _class, ast.Continue: _continue,
    ast.Delete: _delete, ast.Expr: _expression, ast.For: write_for, ast.FunctionDef: _function, ast.If: write_if,
    ast.Raise: _raise, ast.Return: _return, ast.Try: write_try, ast.While: write_while, ast.With: _with,
})  # fmt: skip
