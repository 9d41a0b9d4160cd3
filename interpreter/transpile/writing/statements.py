"""Python statements and the whole program. Straight-line code becomes definitions, branches become values; only what
outlives a turn of a loop or is seen by a closure is assigned in place.

Each kind of statement has its function in a table. What stands inside a statement is written by ``w.expr`` and
``w.statement``, which comes back to this table.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.transpile.analysis.collect import Effect
from scenelang.interpreter.transpile.analysis.inference import DICT
from scenelang.interpreter.transpile.writing.assignments import (
    set_item,
    write_annotated_assign,
    write_assign,
    write_augmented_assign,
)
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem
from scenelang.interpreter.transpile.writing.bodies import (
    define_cells,
    finish_note,
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
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.conversions import write_test
from scenelang.interpreter.transpile.writing.definitions import write_class, write_function
from scenelang.interpreter.transpile.writing.loops import (
    add_to,
    adds_to,
    finish_collections,
    start_collection,
    write_for,
    write_while,
)
from scenelang.interpreter.transpile.writing.writer import Writer, comment_lines, text_of

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


_STATEMENTS: Mapping[type[ast.stmt], Callable[[Writer, Any, Block, Code], None]] = MappingProxyType({
    ast.AnnAssign: write_annotated_assign, ast.Assert: _assert, ast.Assign: write_assign,
    ast.AugAssign: write_augmented_assign, ast.Break: _break, ast.ClassDef: write_class, ast.Continue: _continue,
    ast.Delete: _delete, ast.Expr: _expression, ast.For: write_for, ast.FunctionDef: write_function, ast.If: write_if,
    ast.Raise: _raise, ast.Return: _return, ast.Try: write_try, ast.While: write_while, ast.With: _with,
})  # fmt: skip
