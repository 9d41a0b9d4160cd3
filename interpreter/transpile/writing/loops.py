"""Loops, and the lists that loops and branches collect, which become comprehensions and unions."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from functools import partial

from scenelang.interpreter.transpile.analysis.collect import PURE, Collection, Effect, additions
from scenelang.interpreter.transpile.analysis.inference import LIST, SHAPE
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable, is_annotation
from scenelang.interpreter.transpile.writing.assignments import store, unpack_code
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, CollectedPiece, Collecting, assemble, total
from scenelang.interpreter.transpile.writing.bodies import (
    conditional,
    effect_body,
    move_note,
    take_leading_comments,
    take_trailing_comments,
    value_clauses,
    write_body,
)
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    Key,
    Name,
    VariableRef,
    form,
    is_form,
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.operators import (
    condition_clause,
    loop_clauses,
    loop_head,
    write_iterable,
    write_test,
)
from scenelang.interpreter.transpile.writing.writer import (
    ExitPoint,
    Mode,
    Writer,
    has_break,
    has_inner_star,
    is_continue_guard,
    is_only_combined,
    may_exit,
    sole_loop,
)

# `for` and `while`: clauses, guards, early exits.


def write_for(w: Writer, node: ast.For, block: Block, note: Code) -> None:
    """Generate a ``for`` that is evaluated for its effects."""
    code, exit_point = _loop(w, node, "", Mode(ast.Continue, lambda b: None), None)
    _add_loop(w, node, code, exit_point, block, note)


def write_while(w: Writer, node: ast.While, block: Block, note: Code) -> None:
    """Generate a ``while``."""
    exit_point = ExitPoint("break")
    w.exits.breaks.append(exit_point)
    test = write_test(w, node.test)
    body = _loop_body(w, node.body, Mode(ast.Continue, lambda b: None), None, [])
    w.exits.breaks.pop()
    code = FormCode([Name("while"), test, *(body or [none()])], w.span(node))
    _add_loop(w, node, code, exit_point, block, note)


def _add_loop(
    w: Writer, node: ast.For | ast.While, code: Code, exit_point: ExitPoint, block: Block, note: Code
) -> None:
    """Add a loop and its ``else`` block, which a `break` skips. ``exit_point`` is the target of `break`."""
    effect = w.effect(node)
    if exit_point.variable is not None or (node.orelse and has_break(node.body)):
        orelse = effect_body(w, node.orelse) if node.orelse else []
        code = form("let/ec", VariableRef(exit_point.escape()), code, *orelse, span=w.span(node))
        block.add_effect(code, effect | Effect(changes=True), note)
        return
    block.add_effect(code, effect, note)
    for statement in node.orelse:
        w.statement(statement, block)


def _loop(w: Writer, node: ast.For, kind: str, mode: Mode, collecting: Collecting | None) -> tuple[Code, ExitPoint]:
    """Return a loop as ``(for/kind (clauses) body ...)``, and the target of its `break`.

    Directly nested loops become ``for*``.
    """
    exit_point = ExitPoint("break")
    w.exits.breaks.append(exit_point)
    clauses: list[Code] = []
    nested = False
    inner: ast.For = node
    prefix: list[Code] = []
    statements: list[ast.stmt] = []
    depth = 0
    while True:
        nested_inner = sole_loop(inner.body, collecting)
        nested = nested or nested_inner is not None
        clauses += _for_clauses(w, inner, parallel=not nested, prefix=prefix)
        statements = list(inner.body)
        if prefix:
            break
        statements = _guards(w, statements, clauses, breaks=depth == 0 and not collecting and not node.orelse)
        following = sole_loop(statements, collecting)
        if following is None or has_break(following.body) or (depth and exit_point.variable):
            break
        if following in w.cell_definitions.before:
            break  # cells are defined between the two loops
        nested = True
        note = Code(None)
        take_leading_comments(w, note, following)
        clauses[-1].before = (*clauses[-1].before, *note.before)
        inner = following
        depth += 1
    body = _loop_body(w, statements, mode, collecting, prefix)
    w.exits.breaks.pop()
    head = Name(f"for{'*' if depth else ''}{kind}")
    return FormCode([head, FormCode(clauses), *(body or [none()])], w.span(node)), exit_point


def _for_clauses(w: Writer, node: ast.For, prefix: list[Code], *, parallel: bool) -> list[Code]:
    """Return the clauses of one ``for``; targets that are cells are assigned at the start of the body."""
    target = node.target
    if _interleaves(w, node):
        lazy = _lazy_clauses(w, node, prefix)
        if lazy is not None:
            return lazy
    names = [n for n in walk_tree(target) if isinstance(n, ast.Name)]
    if isinstance(target, (ast.Name, ast.Tuple, ast.List)) and not any(
        w.names.variables[n].is_cell for n in names if n in w.names.variables
    ):
        if not isinstance(target, ast.Name) and any(
            not isinstance(n, (ast.Name, ast.Tuple, ast.List, ast.Starred, ast.Store)) for n in walk_tree(target)
        ):
            raise w.unsupported("this loop target", target)
        if has_inner_star(target):
            variable = PythonVariable("item", None, is_temporary=True)
            block = Block()
            assert isinstance(target, (ast.Tuple, ast.List))
            unpack_code(w, node, target, VariableRef(variable), PURE, block, Code(None))
            prefix += list(assemble(block.items, None))
            return [FormCode([VariableRef(variable), write_iterable(w, node.iter)])]
        return loop_clauses(w, target, node.iter, parallel)
    variable = PythonVariable(target.id if isinstance(target, ast.Name) else "item", None, is_temporary=True)
    block = Block()
    store(w, node, target, VariableRef(variable), PURE, block, Code(None))
    prefix += [
        item.value if item.kind == "effect" else form("define-values", item.target or none(), item.value)
        for item in block.items
    ]
    return [FormCode([VariableRef(variable), write_iterable(w, node.iter)])]


def _interleaves(w: Writer, node: ast.For) -> bool:
    """Return whether the iterable and the body of a loop both draw random numbers, in alternation."""
    return w.effect(node.iter).draws and w.effect(*node.body).draws


def _lazy_clauses(w: Writer, node: ast.For, prefix: list[Code]) -> list[Code] | None:
    """Return clauses that compute the items of a generator expression or ``map`` in each iteration, as Python does.

    For a generator function of the program this is not possible: it draws its numbers first, which is reported.
    """
    source = node.iter
    if isinstance(source, ast.Call) and any(t.is_generator for t in w.facts.targets.get(source, ())):
        message = "the generator and the loop both draw random numbers; in the translation, the generator draws first"
        w.warn("draw-order", message, source)
    if not isinstance(node.target, ast.Name) or w.names.variables[node.target].is_cell:
        return None
    target = VariableRef(w.names.variables[node.target], w.span(node.target))
    if isinstance(source, ast.GeneratorExp) and len(source.generators) == 1:
        clauses = loop_head(w, "", source.generators)[1]
        assert isinstance(clauses, FormCode)
        prefix.append(form("define", target, w.expr(source.elt)))
        return clauses.items
    if isinstance(source, ast.Call) and w.paths.of(source.func) == "map" and len(source.args) == 2:
        item = PythonVariable("item", None, is_temporary=True)
        prefix.append(form("define", target, FormCode([w.expr(source.args[0]), VariableRef(item)])))
        return [FormCode([VariableRef(item), write_iterable(w, source.args[1])])]
    return None


def _guards(w: Writer, statements: list[ast.stmt], clauses: list[Code], *, breaks: bool) -> list[ast.stmt]:
    """Convert leading ``if c: continue`` and ``if c: break``, and an ``if`` around the whole body, to clauses."""
    while statements and isinstance(statements[0], ast.If) and statements[0] not in w.cell_definitions.before:
        first = statements[0]
        if (
            not first.orelse
            and len(first.body) == 1
            and isinstance(first.body[0], ast.Continue)
            and len(statements) > 1
        ):
            _guard(w, first, clauses, holds=False)
            statements = statements[1:]
        elif not first.orelse and len(first.body) == 1 and isinstance(first.body[0], ast.Break) and breaks:
            note = Code(None)
            take_leading_comments(w, note, first)
            test = write_test(w, first.test)
            w.comments.take_trailing(note, first.lineno, first.end_lineno or first.lineno)
            clauses += [Key("break"), test]
            clauses[-2].before, test.after = note.before, note.after
            statements = statements[1:]
            break
        elif not first.orelse and len(statements) == 1 and not may_exit(first, ast.Break):
            _guard(w, first, clauses, holds=True)
            statements = first.body
        else:
            break
    return statements


def _guard(w: Writer, node: ast.If, clauses: list[Code], *, holds: bool) -> None:
    note = Code(None)
    take_leading_comments(w, note, node)
    key, test = condition_clause(w, node.test, holds)
    if not holds:  # the comment of the removed `continue`
        w.comments.take_trailing(note, node.lineno, node.end_lineno or node.lineno)
    key.before, test.after = note.before, note.after
    clauses += [key, test]


def _loop_body(
    w: Writer, statements: Sequence[ast.stmt], mode: Mode, collecting: Collecting | None, prefix: list[Code]
) -> list[Code]:
    exit_point = ExitPoint("continue")
    w.exits.continues.append(exit_point)
    block = Block()
    if collecting is not None:
        block.collecting.append(Collecting(collecting.collection, collecting.as_union, False))
        exit_point.value = (lambda: form("union")) if collecting.as_union else (lambda: quote(FormCode([])))
    body = write_body(w, statements, mode, block)
    w.exits.continues.pop()
    if exit_point.variable is not None:
        body = [form("let/ec", VariableRef(exit_point.variable), *body)]
    return [*prefix, *body]


# Collected lists.


def start_collection(w: Writer, node: ast.stmt, block: Block, note: Code) -> bool:
    """Start collecting the list that an assignment creates; return whether it is collected."""
    collection = w.analysed.collections.by_start.get(node)
    value = node.value if isinstance(node, (ast.Assign, ast.AnnAssign)) else None
    if collection is None or value is None or is_annotation(w.paths, value):
        return False
    block.collecting.append(_new_collecting(w, collection, value, note))
    return True


def _new_collecting(w: Writer, collection: Collection, value: ast.expr, note: Code) -> Collecting:
    """Return the state of a collected list with its initial items."""
    collecting = Collecting(
        collection, _is_combined(w, collection), any(s.is_mutated for s in w.type(value).sites), note=note
    )
    if collecting.as_union and not collecting.is_mutated:
        w.unions.add(collection.variable)
    if isinstance(value, ast.List):
        for element in value.elts:
            is_many = isinstance(element, ast.Starred)
            code = write_iterable(w, element.value) if isinstance(element, ast.Starred) else w.expr(element)
            collecting.pieces.append(CollectedPiece(w.comment_item(code, element), is_many, w.effect(element)))
    elif isinstance(value, ast.ListComp):
        head = loop_head(w, "/union" if collecting.as_union else "/list", value.generators)
        collecting.pieces.append(CollectedPiece(FormCode([*head, w.expr(value.elt)]), True, w.effect(value)))
    elif collection.is_union and not _is_empty(value):
        collecting.pieces.append(CollectedPiece(w.expr(value), False, w.effect(value)))
    elif isinstance(value, ast.Call) and value.args:
        collecting.pieces.append(CollectedPiece(write_iterable(w, value.args[0]), True, w.effect(value)))
    return collecting


def _is_combined(w: Writer, collection: Collection) -> bool:
    if collection.is_union:
        return True
    element_types = [s.element for r in w.reads_of(collection.variable) for s in w.type(r).sites]
    if not element_types or not any(t.kinds & SHAPE for t in element_types):
        return False
    return all(t.only(SHAPE | LIST) for t in element_types) and is_only_combined(w, collection.variable)


def adds_to(w: Writer, node: ast.stmt, block: Block) -> Collecting | None:
    """Return the collected list that a statement adds to, or None."""
    return next((c for c in block.collecting if node in c.collection.adders), None)


def add_to(w: Writer, collecting: Collecting, node: ast.stmt, block: Block, note: Code) -> None:
    """Add the pieces of a statement to a collected list."""
    added = additions(node, collecting.collection.variable, w.names)
    if added is not None:
        codes = [_added(w, value, collecting, is_many=is_many) for value, is_many in added]
        take_trailing_comments(w, note, node)
        move_note(codes[0], note)
        for (value, is_many), code in zip(added, codes):
            for piece in _split(w, value, code, is_many=is_many):
                block.add_piece(collecting, piece)
        return
    if isinstance(node, ast.For):
        code = _collecting_for(w, node, collecting, note)
        block.add_piece(collecting, CollectedPiece(code, True, w.effect(node)))
    elif isinstance(node, ast.If):
        piece = _collecting_if(w, node, collecting)
        move_note(piece.code, note)
        block.add_piece(collecting, piece)
    else:
        raise w.unsupported("this way of building a list", node)


def _added(w: Writer, value: ast.expr, collecting: Collecting, *, is_many: bool) -> Code:
    if is_many and not (collecting.as_union and w.type(value).kinds & SHAPE):
        return write_iterable(w, value)
    return w.expr(value)


def _split(w: Writer, value: ast.expr, code: Code, *, is_many: bool) -> list[CollectedPiece]:
    """Return ``xs += [a, b]`` as two pieces."""
    if is_many and isinstance(value, (ast.List, ast.Tuple)) and is_form(code, "list") and isinstance(code, FormCode):
        if code.before and len(code.items) > 1:
            code.items[1].before = (*code.before, *code.items[1].before)
        if code.after and len(code.items) > 1:
            code.items[-1].after = code.after
        effect = w.effect(value)
        return [CollectedPiece(item, False, effect) for item in code.items[1:]]
    return [CollectedPiece(code, is_many, w.effect(value))]


def _collecting_for(w: Writer, node: ast.For, collecting: Collecting, note: Code) -> Code:
    adds_one = not collecting.as_union and _adds_one(
        w, node.body, collecting.collection, is_loop=_is_mergeable(w, node)
    )
    kind = "/union" if collecting.as_union else "/list" if adds_one else "/append"
    inner = Collecting(collecting.collection, collecting.as_union, False)

    code, _ = _loop(
        w, node, kind, Mode(ast.Continue, partial(_collected_value, adds_one=adds_one), collection=inner), inner
    )
    move_note(code, note)
    return code


def _adds_one(w: Writer, body: Sequence[ast.stmt], collection: Collection, *, is_loop: bool = True) -> bool:
    """Return whether every path through a body adds exactly one item.

    In the body of a loop, a sole ``if`` or loop and leading ``if c: continue`` become clauses of the loop.
    """
    while is_loop and len(body) > 1 and is_continue_guard(body[0]):
        body = body[1:]
    adders = [s for s in body if s in collection.adders]
    if len(adders) != 1 or any(may_exit(s, ast.Continue) for s in body):
        return False
    added = additions(adders[0], collection.variable, w.names)
    if added is not None:
        return len(added) == 1 and not added[0][1]
    if isinstance(adders[0], ast.If) and adders[0].orelse:
        branches = (adders[0].body, adders[0].orelse)
        return all(_adds_one(w, branch, collection, is_loop=False) for branch in branches)
    if is_loop and len(body) == 1 and isinstance(adders[0], ast.For) and adders[0] not in w.cell_definitions.before:
        return _adds_one(w, adders[0].body, collection, is_loop=_is_mergeable(w, adders[0]))
    if is_loop and len(body) == 1 and isinstance(adders[0], ast.If):
        return _adds_one(w, adders[0].body, collection)
    return False


def _is_mergeable(w: Writer, node: ast.For) -> bool:
    """Return whether the sole statement of a loop's body can become clauses of the loop, because nothing precedes
    it."""
    names = (w.names.variables.get(n) for n in walk_tree(node.target))
    is_cell = any(variable is not None and variable.is_cell for variable in names)
    return not is_cell and not has_inner_star(node.target) and not _interleaves(w, node)


def _collecting_if(w: Writer, node: ast.If, collecting: Collecting) -> CollectedPiece:
    adds_one = (
        bool(node.orelse) and not collecting.as_union and _adds_one(w, [node], collecting.collection, is_loop=False)
    )

    mode = Mode(None, partial(_collected_value, adds_one=adds_one), collection=collecting)
    clauses: list[Code] = []
    value_clauses(w, node, mode, clauses, lambda: _collecting_block(w, collecting))
    return CollectedPiece(conditional(clauses), not adds_one, w.effect(node))


def _collecting_block(w: Writer, collecting: Collecting) -> Block:
    block = Block()
    block.collecting.append(Collecting(collecting.collection, collecting.as_union, False))
    return block


def finish_collections(w: Writer, node: ast.stmt, block: Block) -> None:
    """Define the collected lists whose last addition is ``node``."""
    for collecting in list(block.collecting):
        if collecting.collection.last is not node or collecting.collection.variable.is_temporary:
            continue
        if collecting.collection.start is None:
            continue
        block.collecting.remove(collecting)
        variable = collecting.collection.variable
        code = collecting.combined()
        effect = total(piece.effect for piece in collecting.pieces)
        if collecting.is_mutated:
            code = form("mutable", code)
        if variable.is_cell:
            is_definition = variable in w.cell_definitions.definitions.get(collecting.collection.start, ())
            writes = effect | Effect(writes=frozenset((variable,)))
            if is_definition:
                block.add(BlockItem("define", code, writes, (variable,), VariableRef(variable), collecting.note))
            else:
                block.add_effect(form("set!", VariableRef(variable), code), writes, collecting.note)
        else:
            block.define(variable, code, effect, collecting.note, nests=False)


def _collected_value(block: Block, *, adds_one: bool) -> Code:
    """Return what a block has collected: its only item, or everything."""
    collecting = block.collecting[0]
    if adds_one:
        return collecting.pieces[0].code
    return collecting.combined()


def _is_empty(node: ast.expr) -> bool:
    return isinstance(node, (ast.List, ast.Tuple)) and not node.elts
