"""Lists that are collected: the pieces that statements add become comprehensions and unions."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from functools import partial

from scenelang.interpreter.transpile.analysis.collect import Collection, Effect, additions
from scenelang.interpreter.transpile.analysis.inference import LIST, SHAPE
from scenelang.interpreter.transpile.writing.assignments import AssignmentWriter
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, CollectedPiece, Collecting, total
from scenelang.interpreter.transpile.writing.code import Code, FormCode, Name, VariableRef, form, is_form
from scenelang.interpreter.transpile.writing.operators import conditional, hang
from scenelang.interpreter.transpile.writing.writer import Mode, has_inner_star, is_skip, leaves


class CollectionWriter(AssignmentWriter):
    """Writes the statements that build lists."""

    def _start(self, collection: Collection, value: ast.expr, block: Block, note: Code) -> None:
        collecting = Collecting(
            collection, self._unites_all(collection), any(s.is_mutated for s in self.type(value).sites), note=note
        )
        if collecting.unites and not collecting.is_mutated:
            self.united.add(collection.variable)
        if isinstance(value, ast.List):
            for element in value.elts:
                is_many = isinstance(element, ast.Starred)
                code = self.iterable(element.value) if isinstance(element, ast.Starred) else self.expr(element)
                collecting.pieces.append(
                    CollectedPiece(self.comment_item(code, element), is_many, self.effect(element))
                )
        elif isinstance(value, ast.ListComp):
            head = self.loop_head("/union" if collecting.unites else "/list", value.generators)
            collecting.pieces.append(CollectedPiece(FormCode([*head, self.expr(value.elt)]), True, self.effect(value)))
        elif collection.is_union and not _is_empty(value):
            collecting.pieces.append(CollectedPiece(self.expr(value), False, self.effect(value)))
        elif isinstance(value, ast.Call) and value.args:
            collecting.pieces.append(CollectedPiece(self.iterable(value.args[0]), True, self.effect(value)))
        block.collecting.append(collecting)

    def _unites_all(self, collection: Collection) -> bool:
        if collection.is_union:
            return True
        element_types = [s.element for r in self.reads_of(collection.variable) for s in self.type(r).sites]
        if not element_types or not any(t.kinds & SHAPE for t in element_types):
            return False
        return all(t.only(SHAPE | LIST) for t in element_types) and self.is_united(collection.variable)

    def _adds_to(self, node: ast.stmt, block: Block) -> Collecting | None:
        return next((c for c in block.collecting if node in c.collection.adders), None)

    def _add_to(self, collecting: Collecting, node: ast.stmt, block: Block, note: Code) -> None:
        """Add the pieces that a statement gives to a list under collection."""
        found = additions(node, collecting.collection.variable, self.names)
        if found is not None:
            codes = [self._added(value, is_many, collecting) for value, is_many in found]
            self._finish_note(note, node)
            hang(codes[0], note)
            for (value, is_many), code in zip(found, codes):
                for piece in self._split(value, code, is_many):
                    block.add_piece(collecting, piece)
            return
        if isinstance(node, ast.For):
            code = self._collecting_for(node, collecting, note)
            block.add_piece(collecting, CollectedPiece(code, True, self.effect(node)))
        elif isinstance(node, ast.If):
            piece = self._collecting_if(node, collecting)
            hang(piece.code, note)
            block.add_piece(collecting, piece)
        else:
            raise self.unsupported("this way of building a list", node)

    def _added(self, value: ast.expr, is_many: bool, collecting: Collecting) -> Code:
        if is_many and not (collecting.unites and self.type(value).kinds & SHAPE):
            return self.iterable(value)
        return self.expr(value)

    def _split(self, value: ast.expr, code: Code, is_many: bool) -> list[CollectedPiece]:
        """``xs += [a, b]`` adds two items."""
        if (
            is_many
            and isinstance(value, (ast.List, ast.Tuple))
            and is_form(code, "list")
            and isinstance(code, FormCode)
        ):
            if code.before and len(code.items) > 1:
                code.items[1].before = (*code.before, *code.items[1].before)
            if code.after and len(code.items) > 1:
                code.items[-1].after = code.after
            effect = self.effect(value)
            return [CollectedPiece(item, False, effect) for item in code.items[1:]]
        return [CollectedPiece(code, is_many, self.effect(value))]

    def _collecting_for(self, node: ast.For, collecting: Collecting, note: Code) -> Code:
        one_each = not collecting.unites and self._adds_one(node.body, collecting.collection, self._merges(node))
        kind = "/union" if collecting.unites else "/list" if one_each else "/append"
        inner = Collecting(collecting.collection, collecting.unites, False)

        code = self._for(node, kind, Mode(ast.Continue, partial(_finished, one_each), collection=inner), inner)
        hang(code, note)
        return code

    def _adds_one(self, body: Sequence[ast.stmt], collection: Collection, is_loop: bool = True) -> bool:
        """Whether every path through a body adds exactly one item. In a loop's body a lone ``if`` or loop and leading
        ``if c: continue`` become clauses of the loop."""
        while is_loop and len(body) > 1 and is_skip(body[0]):
            body = body[1:]
        adders = [s for s in body if s in collection.adders]
        if len(adders) != 1 or any(leaves(s, ast.Continue) for s in body):
            return False
        found = additions(adders[0], collection.variable, self.names)
        if found is not None:
            return len(found) == 1 and not found[0][1]
        if isinstance(adders[0], ast.If) and adders[0].orelse:
            branches = (adders[0].body, adders[0].orelse)
            return all(self._adds_one(branch, collection, is_loop=False) for branch in branches)
        if is_loop and len(body) == 1 and isinstance(adders[0], ast.For) and adders[0] not in self.places.before:
            return self._adds_one(adders[0].body, collection, self._merges(adders[0]))
        if is_loop and len(body) == 1 and isinstance(adders[0], ast.If):
            return self._adds_one(adders[0].body, collection)
        return False

    def _merges(self, node: ast.For) -> bool:
        """Whether what is alone in a loop's body can become clauses of the loop: nothing has to be done before it."""
        names = (self.names.variables.get(n) for n in ast.walk(node.target))
        is_cell = any(variable is not None and variable.is_cell for variable in names)
        return not is_cell and not has_inner_star(node.target) and not self._interleaves(node)

    def _collecting_if(self, node: ast.If, collecting: Collecting) -> CollectedPiece:
        one_each = (
            bool(node.orelse) and not collecting.unites and self._adds_one([node], collecting.collection, is_loop=False)
        )

        mode = Mode(None, partial(_finished, one_each), collection=collecting)
        clauses: list[Code] = []
        self._value_clauses(node, mode, clauses, lambda: self._collecting_block(collecting))
        return CollectedPiece(conditional(clauses), not one_each, self.effect(node))

    def _collecting_block(self, collecting: Collecting) -> Block:
        block = Block()
        block.collecting.append(Collecting(collecting.collection, collecting.unites, False))
        return block

    def _value_clauses(self, node: ast.If, mode: Mode, clauses: list[Code], new_block: Callable[[], Block]) -> None:
        """The clauses of an ``if`` whose branches give values."""
        test = self.test(node.test)
        clauses.append(self._clause(test, self.body(node.body, mode, new_block()), node.test))
        if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
            inner = node.orelse[0]
            note = Code(None)
            self._open_note(note, inner)
            position = len(clauses)
            self._value_clauses(inner, mode, clauses, new_block)
            clauses[position].before = (*note.before, *clauses[position].before)
            return
        clauses.append(self._clause(Name("else"), self.body(node.orelse, mode, new_block()), None))

    def _finish_collections(self, node: ast.stmt, block: Block) -> None:
        """When the last statement that adds to a list is done the list gets its definition."""
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
                is_definition = variable in self.places.definitions.get(collecting.collection.start, ())
                writes = effect | Effect(writes=frozenset((variable,)))
                if is_definition:
                    block.add(BlockItem("define", code, writes, (variable,), VariableRef(variable), collecting.note))
                else:
                    block.add_effect(form("set!", VariableRef(variable), code), writes, collecting.note)
            else:
                block.define(variable, code, effect, collecting.note, nests=False)


def _finished(one_each: bool, block: Block) -> Code:
    """What a block has collected: its one item, or everything."""
    collecting = block.collecting[0]
    if one_each:
        return collecting.pieces[0].code
    return collecting.combined()


def _is_empty(node: ast.expr) -> bool:
    return isinstance(node, (ast.List, ast.Tuple)) and not node.elts
