"""Blocks in tail position, where `return` and `continue` end them, and the branches inside them.

The statements of a block are written by ``w.statement``: the recursion over the tree goes through the writer.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from functools import partial

from scenelang.interpreter.transpile.analysis.collect import PURE, Effect
from scenelang.interpreter.transpile.analysis.inference import LIST, SHAPE
from scenelang.interpreter.transpile.analysis.scopes import Function, PythonVariable
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, Collecting, assemble
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.conversions import write_test
from scenelang.interpreter.transpile.writing.writer import (
    ExitTarget,
    Finish,
    Mode,
    Writer,
    always_leaves,
    is_main_guard,
    leaves,
    without_docstring,
)

# Bodies.


def function_body(w: Writer, function: Function) -> list[Code]:
    """The forms of a function's body, its docstring left out."""
    saved = w.place, w.pending_texts
    w.place, w.pending_texts = ExitTarget(function), []
    body = without_docstring(function.body)
    try:
        forms = _generator_body(w, function, body) if function.is_generator else _plain_body(w, function, body)
    finally:
        escape = w.place.returns.variable
        w.place, w.pending_texts = saved
    if escape is not None:
        forms = [form("let/ec", VariableRef(escape), *forms)]
    return _returned_frames(w, function, forms) if forms else [none()]


def _returned_frames(w: Writer, function: Function, forms: list[Code]) -> list[Code]:
    """An animation may return the list of its frames in place of yielding them."""
    returned = w.facts.returns.get(function)
    gives_list = returned is not None and bool(returned.kinds & LIST) and not returned.kinds & SHAPE
    if not function.is_animation or function.is_generator or not gives_list:
        return forms
    return [*forms[:-1], form("frames", forms[-1])]


def _plain_body(w: Writer, function: Function, body: Sequence[ast.stmt]) -> list[Code]:
    returned = w.facts.returns.get(function)
    needs_value = function.is_registered or (returned is not None and returned.kinds & ~16 != 0)
    finish: Finish = lambda block: none() if needs_value else None
    return write_body(w, body, Mode(ast.Return, finish))


def _generator_body(w: Writer, function: Function, body: Sequence[ast.stmt]) -> list[Code]:
    """What a generator yields, as a list."""
    block = Block()
    collection = w.analysed.collections.by_generator.get(function)
    if collection is not None:
        collecting = Collecting(collection, False, False)
        block.collecting.append(collecting)
        mode = Mode(None, lambda b: b.collecting[0].combined(), collection=collecting)
        forms = write_body(w, body, mode, block)
    else:
        variable = w.place.yields = PythonVariable(
            "frames" if function.is_animation else "items", None, is_temporary=True
        )
        block.add(BlockItem("define", form("mutable-list"), PURE, (variable,), VariableRef(variable)))
        inner = write_body(w, body, Mode(None, lambda b: None))
        escape = w.place.returns.variable
        if escape is not None:  # `return` ends the generator; what was yielded so far stands
            w.place.returns.variable = None
            inner = [form("let/ec", VariableRef(escape), *inner)]
        forms = [*assemble(block.items, None)[:1], *inner, VariableRef(variable)]
    if function.is_animation:
        frames = form("frames", forms[-1])
        frames.blank, forms[-1].blank = forms[-1].blank, False
        return [*forms[:-1], frames]
    return forms


def write_body(w: Writer, statements: Sequence[ast.stmt], mode: Mode, block: Block | None = None) -> list[Code]:
    """The forms of a block in tail position."""
    block = block or Block()
    for position, statement in enumerate(statements):
        rest = statements[position + 1 :]
        define_cells(w, statement, block)
        if mode.leaving is not None and isinstance(statement, mode.leaving):
            return assemble(block.items, _leave(w, statement, mode, block))
        if isinstance(statement, ast.If) and mode.leaving is not None and leaves(statement, mode.leaving):
            final = _leaving_branch(w, statement, rest, mode, block)
            if final is not None:
                return assemble(block.items, final)
        if isinstance(statement, ast.Try) and mode.leaving is ast.Return and always_leaves([statement], ast.Return):
            return assemble(block.items, _noted(w, statement, partial(_guarded_value, w, statement, mode)))
        if mode.leaving is ast.Continue and block.collecting and leaves(statement, ast.Continue):
            _keep_collected(w, block)
        w.statement(statement, block)
    if block.has_left and mode.collection is None:
        return assemble(block.items, None)
    return assemble(block.items, mode.finish(block))


def define_cells(w: Writer, statement: ast.stmt, block: Block) -> None:
    """Define the variables that are assigned in place from ``statement`` on."""
    for cell in w.places.before.pop(statement, ()):
        block.add(BlockItem("define", none(), Effect(writes=frozenset((cell,))), (cell,), VariableRef(cell)))


def _keep_collected(w: Writer, block: Block) -> None:
    """A ``continue`` deep inside the next statement gives what this turn has collected so far."""
    collecting = block.collecting[0]
    block.name_pieces(collecting)
    if collecting.pieces:
        w.place.continues[-1].value = collecting.combined


def _leave(w: Writer, statement: ast.stmt, mode: Mode, block: Block) -> Code | None:
    if isinstance(statement, ast.Return):
        return _noted(w, statement, lambda: returned_value(w, statement))
    code = _noted(w, statement, lambda: mode.finish(block) or none())
    is_nothing = type(code) is LiteralCode and code.value is None
    if is_nothing and block.items and block.items[-1].kind == "effect":  # what it does is enough
        block.items[-1].note.before = (*block.items[-1].note.before, *code.before)
        return None
    return code


def returned_value(w: Writer, statement: ast.Return) -> Code:
    """What a ``return`` gives; a list of no shapes is an empty union."""
    if statement.value is None:
        return none()
    if isinstance(statement.value, (ast.List, ast.Tuple)) and not statement.value.elts and _is_shape_function(w):
        return form("union")
    return w.expr(statement.value)


def _is_shape_function(w: Writer) -> bool:
    function = w.place.function
    returned = w.facts.returns.get(function)
    return function.is_registered or (returned is not None and bool(returned.kinds & SHAPE))


def effect_body(w: Writer, statements: Sequence[ast.stmt]) -> list[Code]:
    """The forms of a block that is there for what it does."""
    return write_body(w, statements, Mode(None, lambda block: None))


# Comments at statements.


def _noted(w: Writer, statement: ast.stmt, write: Callable[[], Code]) -> Code:
    """Write a final statement with its comments."""
    note = Code(None)
    open_note(w, note, statement)
    code = write()
    finish_note(w, note, statement)
    code.before = (*note.before, *code.before)
    code.after = code.after or note.after
    code.blank = note.blank or code.blank
    return code


def open_note(w: Writer, note: Code, statement: ast.stmt) -> None:
    """The comments above a statement; of a compound one also that at the end of its head."""
    body = getattr(statement, "body", None) or []
    head_end = body[0].lineno - 1 if body else 0
    note.before = (*w.pending_texts, *note.before)
    w.pending_texts = []
    first = (
        statement.decorator_list[0].lineno
        if isinstance(statement, ast.FunctionDef) and statement.decorator_list
        else statement.lineno
    )
    w.comments.open(note, first)
    if head_end >= statement.lineno and not isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
        w.comments.take_head(note, statement.lineno, head_end)


def finish_note(w: Writer, note: Code, statement: ast.stmt) -> None:
    """The comments at the end of a simple statement; those of a compound one are its body's."""
    if not hasattr(statement, "body"):
        w.comments.close(note, statement.lineno, statement.end_lineno or statement.lineno)


def hang(code: Code, note: Code) -> None:
    """Move the comments of a note to its code."""
    code.before = (*note.before, *code.before)
    code.after = code.after or note.after
    code.blank = code.blank or note.blank
    note.before, note.after, note.blank = (), None, False


# Branches that leave.


def _leaving_branch(w: Writer, node: ast.If, rest: Sequence[ast.stmt], mode: Mode, block: Block) -> Code | None:
    """``if c: return a`` and what follows, as one ``cond``. None where an escape says it better."""
    assert mode.leaving is not None
    if mode.collection is not None and block.collecting and block.collecting[0].pieces:
        block.name_pieces(block.collecting[0])
    clauses: list[Code] = []
    if not _leaving_clauses(w, node, list(rest), mode, block, clauses, dry=True):
        return None
    note = Code(None)
    open_note(w, note, node)
    _leaving_clauses(w, node, list(rest), mode, block, clauses, dry=False)
    code = unless(clauses) or conditional(clauses)
    code.before = (*note.before, *code.before)
    code.blank = note.blank
    return code


def _leaving_clauses(
    w: Writer, node: ast.If, rest: list[ast.stmt], mode: Mode, block: Block, clauses: list[Code], dry: bool
) -> bool:
    """Append the clauses of ``node`` followed by ``rest``; ``dry`` only tells whether that is possible."""
    assert mode.leaving is not None
    body_leaves = always_leaves(node.body, mode.leaving)
    else_leaves = bool(node.orelse) and always_leaves(node.orelse, mode.leaving)
    if not body_leaves and not else_leaves and len(rest) > 1:
        return False  # the rest would be written twice
    body = node.body if body_leaves else [*node.body, *rest]
    orelse = node.orelse if else_leaves else [*node.orelse, *rest]
    if not dry:
        test = write_test(w, node.test)
        clauses.append(_clause(w, test, _inner_body(w, body, mode, block), node.test))
    if len(orelse) >= 1 and isinstance(orelse[0], ast.If) and leaves(orelse[0], mode.leaving):
        inner_rest = list(orelse[1:])
        if _leaving_clauses(w, orelse[0], inner_rest, mode, block, [], dry=True):
            if dry:
                return True
            note = Code(None)
            open_note(w, note, orelse[0])
            more: list[Code] = []
            _leaving_clauses(w, orelse[0], inner_rest, mode, block, more, dry=False)
            if more:
                more[0].before = (*note.before, *more[0].before)
                more[0].blank = note.blank
            clauses += more
            return True
    if not dry:
        clauses.append(_clause(w, Name("else"), _inner_body(w, orelse, mode, block), None))
    return True


def _inner_body(w: Writer, statements: Sequence[ast.stmt], mode: Mode, outer: Block) -> list[Code]:
    """A branch in tail position, with what has been collected so far."""
    block = Block()
    for collecting in outer.collecting:
        copy = Collecting(collecting.collection, collecting.unites, collecting.is_mutated, list(collecting.pieces))
        block.collecting.append(copy)
    return write_body(w, statements, mode, block)


# `if`, for what it does or for the variables that it sets.


def write_if(w: Writer, node: ast.If, block: Block, note: Code) -> None:
    """``if``, for what it does or for the variables that it sets."""
    if is_main_guard(node):
        w.comments.until(node.end_lineno or node.lineno)
        return
    variables = _set_and_needed(w, node)
    if variables:
        _phi(w, node, variables, block, note, lambda mode: _if_value(w, node, mode))
        return
    block.add_effect(_if_effect(w, node), w.effect(node), note)


def _if_effect(w: Writer, node: ast.If) -> Code:
    """An ``if`` for what it does."""
    clauses: list[Code] = []
    _effect_clauses(w, node, clauses)
    if len(clauses) == 1:
        clause = clauses[0]
        assert isinstance(clause, FormCode)
        test = clause.items[0]
        if is_form(test, "not") and isinstance(test, FormCode):
            return FormCode([Name("unless"), test.items[1], *clause.items[1:]], w.span(node))
        return FormCode([Name("when"), *clause.items], w.span(node))
    return conditional(clauses)


def _effect_clauses(w: Writer, node: ast.If, clauses: list[Code]) -> None:
    test = write_test(w, node.test)
    clauses.append(_clause(w, test, effect_body(w, node.body), node.test))
    if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If) and not _set_and_needed(w, node.orelse[0]):
        note = Code(None)
        open_note(w, note, node.orelse[0])
        position = len(clauses)
        _effect_clauses(w, node.orelse[0], clauses)
        clauses[position].before = (*note.before, *clauses[position].before)
    elif node.orelse:
        clauses.append(_clause(w, Name("else"), effect_body(w, node.orelse), None))


def value_clauses(w: Writer, node: ast.If, mode: Mode, clauses: list[Code], new_block: Callable[[], Block]) -> None:
    """The clauses of an ``if`` whose branches give values."""
    test = write_test(w, node.test)
    clauses.append(_clause(w, test, write_body(w, node.body, mode, new_block()), node.test))
    if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
        inner = node.orelse[0]
        note = Code(None)
        open_note(w, note, inner)
        position = len(clauses)
        value_clauses(w, inner, mode, clauses, new_block)
        clauses[position].before = (*note.before, *clauses[position].before)
        return
    clauses.append(_clause(w, Name("else"), write_body(w, node.orelse, mode, new_block()), None))


def _clause(w: Writer, test: Code, body: list[Code], node: ast.expr | None) -> FormCode:
    return FormCode([test, *(body or [none()])], w.span(node) if node is not None else None)


def _if_value(w: Writer, node: ast.If, mode: Mode) -> Code:
    clauses: list[Code] = []
    value_clauses(w, node, mode, clauses, Block)
    return conditional(clauses)


def _set_and_needed(w: Writer, node: ast.stmt) -> list[PythonVariable]:
    """The variables that a compound statement sets, not in place, and that are read after it."""
    after = w.liveness.after.get(node, frozenset())
    found: dict[PythonVariable, None] = {}
    for inner in ast.walk(node):
        if isinstance(inner, (ast.Name, ast.FunctionDef)) and not (
            isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Load)
        ):
            variable = (
                w.names.variables.get(inner) if isinstance(inner, ast.Name) else w.names.functions[inner].variable
            )
            if variable is not None and variable in after and not variable.is_cell:
                found[variable] = None
    return list(found)


def _phi(
    w: Writer, node: ast.stmt, variables: list[PythonVariable], block: Block, note: Code, write: Callable[[Mode], Code]
) -> None:
    """``if c: x = a else: x = b`` is ``(define x (if c a b))``; several variables come as a list."""
    missing = {variable for variable in variables if not _is_set_before(w, variable, node)}
    if len(variables) == 1:
        variable = variables[0]
        code = write(Mode(None, lambda b: _branch_value(b, variable, variable in missing)))
        block.define(variable, code, w.effect(node), note)
        return
    code = write(Mode(None, lambda b: _branch_values(b, variables, missing)))
    targets = FormCode([VariableRef(v) for v in variables])
    block.add(BlockItem("define", code, w.effect(node), tuple(variables), targets, note))


def _is_set_before(w: Writer, variable: PythonVariable, node: ast.AST) -> bool:
    """Whether a variable has a value where ``node`` begins, as far as the blocks around it tell."""
    if variable.is_parameter or variable.function is not w.place.function:
        return True
    current: ast.AST | None = node
    while current is not None and not isinstance(current, (ast.FunctionDef, ast.Module)):
        outer = w.parent(current)
        for name in ("body", "orelse", "finalbody"):
            block = getattr(outer, name, None)
            if isinstance(block, list) and current in block:
                before = block[: block.index(current)]
                if any(_stands_in(store, statement) for store in variable.stores for statement in before):
                    return True
        if isinstance(outer, ast.For) and any(_stands_in(store, outer.target) for store in variable.stores):
            return True
        current = outer
    return False


def _stands_in(node: ast.AST, outer: ast.AST) -> bool:
    """Whether ``node`` stands in the text of ``outer``."""
    start = (getattr(outer, "lineno", 0), getattr(outer, "col_offset", 0))
    end = (getattr(outer, "end_lineno", 0), getattr(outer, "end_col_offset", 0))
    return start <= (getattr(node, "lineno", 0), getattr(node, "col_offset", 0)) < end


def _branch_value(block: Block, variable: PythonVariable, is_missing: bool) -> Code:
    """A variable at the end of a branch; none where it was set neither in the branch nor before."""
    is_set = any(variable in item.variables for item in block.items)
    return none() if is_missing and not is_set else VariableRef(variable)


def _branch_values(block: Block, variables: list[PythonVariable], missing: set[PythonVariable]) -> Code:
    """The list of several variables at the end of a branch; plain definitions go straight into it."""
    items = block.items
    if (
        [item.variables for item in items] == [(v,) for v in variables]
        and all(item.kind == "define" and type(item.target) is VariableRef for item in items)
        and not any(item.mentions(v) for item in items for v in variables)
        and not any(item.note.before or item.note.after for item in items)
    ):
        values = [item.value for item in items]
        items.clear()
        if all(type(value) is LiteralCode for value in values):
            return quote(FormCode(values))
        return form("list", *values)
    if len(items) == 1 and _binds_in_order(items[0].target, variables):
        return items.pop().value
    return form("list", *(_branch_value(block, v, v in missing) for v in variables))


def _binds_in_order(target: Code | None, variables: list[PythonVariable]) -> bool:
    """Whether a pattern is just these variables, side by side."""
    if not isinstance(target, FormCode) or target.rest is not None or len(target.items) != len(variables):
        return False
    return all(type(item) is VariableRef and item.variable is v for item, v in zip(target.items, variables))


def conditional(clauses: list[Code]) -> Code:
    """``(if test a b)`` where two short branches do, else ``cond``; nested conditions are flattened."""
    last = clauses[-1]
    while isinstance(last, FormCode) and len(last.items) == 2 and is_form(last, "else") and not last.before:
        inner = last.items[1]
        if not (is_form(inner, "cond") and isinstance(inner, FormCode)) or inner.before:
            break
        clauses = [*clauses[:-1], *inner.items[1:]]
        last = clauses[-1]
    if len(clauses) == 2 and is_form(clauses[1], "else"):
        first, second = clauses
        assert isinstance(first, FormCode)
        assert isinstance(second, FormCode)
        if len(first.items) == 2 and len(second.items) == 2 and not first.before and not second.before:
            return FormCode([Name("if"), first.items[0], first.items[1], second.items[1]], first.span)
    return FormCode([Name("cond"), *clauses], clauses[0].span)


def unless(clauses: list[Code]) -> Code | None:
    """``(cond (test none) (else body ...))``, for what it does, is ``(unless test body ...)``."""
    if len(clauses) != 2:
        return None
    first, second = clauses
    assert isinstance(first, FormCode)
    assert isinstance(second, FormCode)
    is_nothing = type(first.items[-1]) is LiteralCode and first.items[-1].value is None and len(first.items) == 2
    if not is_nothing or first.before or first.items[-1].before or second.before or not is_form(second, "else"):
        return None
    if type(second.items[-1]) is LiteralCode or len(second.items) < 2:
        return None
    test = first.items[0]
    if is_form(test, "not") and isinstance(test, FormCode):
        return FormCode([Name("when"), test.items[1], *second.items[1:]], first.span)
    return FormCode([Name("unless"), test, *second.items[1:]], first.span)


# `try`.


_ERRORS: dict[str, tuple[str, ...]] = {
    "ZeroDivisionError": ("zero-division",), "IndexError": ("index",), "KeyError": ("key",),
    "AssertionError": ("assert",),
    "LookupError": ("index", "key"), "ValueError": ("value", "domain", "type", "user"), "TypeError": ("type",),
}  # fmt: skip


def write_try(w: Writer, node: ast.Try, block: Block, note: Code) -> None:
    """``try`` as ``guard``, and what its ``finally`` holds after it."""
    leaving = any(
        leaves(s, kind) for h in node.handlers for s in h.body for kind in (ast.Return, ast.Continue, ast.Break)
    )
    if node.finalbody and leaving:
        raise w.unsupported("`finally` after a handler that leaves", node)
    variables = _set_and_needed(w, node)
    effect = w.effect(node) | Effect(changes=True)
    if variables:
        _phi(w, node, variables, block, note, lambda mode: _guarded_value(w, node, mode))
    else:
        block.add_effect(_guarded_value(w, node, Mode(None, lambda b: None)), effect, note)
    for statement in node.finalbody:
        w.statement(statement, block)


def _guarded_value(w: Writer, node: ast.Try, mode: Mode) -> Code:
    """``try`` as ``guard``; what is caught by name is told by the error's name."""
    clauses: list[Code] = []
    error = PythonVariable("error", None, is_temporary=True)
    for handler in node.handlers:
        if handler.name:
            error = w.names.variables.get(handler, error)
    for handler in node.handlers:
        names = (
            [] if handler.type is None else handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
        )
        kinds = [_ERRORS.get(w.paths.of(n) or "") for n in names]
        if not kinds or None in kinds or (len(node.handlers) == 1 and len({k for ks in kinds for k in ks or ()}) > 1):
            test: Code = LiteralCode(True)
        else:
            tests = [
                form("error-is?", VariableRef(error), LiteralCode(kind))
                for kind in dict.fromkeys(k for ks in kinds for k in ks or ())
            ]
            test = tests[0] if len(tests) == 1 else form("or", *tests)
        clauses.append(FormCode([test, *(write_body(w, handler.body, mode) or [none()])]))
    body = write_body(w, [*node.body, *node.orelse], mode)
    return form("guard", FormCode([VariableRef(error), *clauses]), *(body or [none()]), span=w.span(node))
