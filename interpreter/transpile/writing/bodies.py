"""The bodies of functions and branches: blocks in tail position, where `return` and `continue` end them."""

from __future__ import annotations

import ast
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import partial

from scenelang.interpreter.transpile.analysis.collect import PURE, Collection, Effect
from scenelang.interpreter.transpile.analysis.inference import LIST, SHAPE
from scenelang.interpreter.transpile.analysis.liveness import CellPlaces
from scenelang.interpreter.transpile.analysis.scopes import Function, PythonVariable
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, Collecting, assemble
from scenelang.interpreter.transpile.writing.code import Code, FormCode, LiteralCode, Name, VariableRef, form, none
from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter
from scenelang.interpreter.transpile.writing.operators import conditional, unless
from scenelang.interpreter.transpile.writing.writer import (
    Analysed,
    ExitTarget,
    Finish,
    Jump,
    Mode,
    always_leaves,
    leaves,
    without_docstring,
)


class BodyWriter(ExpressionWriter, ABC):
    """Writes bodies."""

    def __init__(self, analysed: Analysed) -> None:
        super().__init__(analysed)
        self.places = CellPlaces(analysed.names, analysed.liveness)
        self.place = ExitTarget(analysed.names.module)
        self._last_break = Jump("break")
        self.pending_texts: list[str] = []

    @abstractmethod
    def statement(self, node: ast.stmt, block: Block) -> None:
        """Add a statement to a block."""

    @abstractmethod
    def _guarded_value(self, node: ast.Try, mode: Mode) -> Code:
        """``try`` as ``guard``."""

    @abstractmethod
    def _start(self, collection: Collection, value: ast.expr, block: Block, note: Code) -> None:
        """Begin to collect a list."""

    @abstractmethod
    def _for(self, node: ast.For, kind: str, mode: Mode, collecting: Collecting | None) -> Code:
        """A loop as ``(for/kind (clauses) body ...)``."""

    @abstractmethod
    def _interleaves(self, node: ast.For) -> bool:
        """Whether what a loop runs through and its body both draw random numbers."""

    # --- bodies ---

    def function_body(self, function: Function) -> list[Code]:
        """The forms of a function's body, its docstring left out."""
        saved = self.place, self.pending_texts
        self.place, self.pending_texts = ExitTarget(function), []
        body = without_docstring(function.body)
        try:
            forms = self._generator(function, body) if function.is_generator else self._plain_body(function, body)
        finally:
            escape = self.place.returns.variable
            self.place, self.pending_texts = saved
        if escape is not None:
            forms = [form("let/ec", VariableRef(escape), *forms)]
        return self._returned_frames(function, forms) if forms else [none()]

    def _returned_frames(self, function: Function, forms: list[Code]) -> list[Code]:
        """An animation may return the list of its frames in place of yielding them."""
        returned = self.facts.returns.get(function)
        gives_list = returned is not None and bool(returned.kinds & LIST) and not returned.kinds & SHAPE
        if not function.is_animation or function.is_generator or not gives_list:
            return forms
        return [*forms[:-1], form("frames", forms[-1])]

    def _plain_body(self, function: Function, body: Sequence[ast.stmt]) -> list[Code]:
        returned = self.facts.returns.get(function)
        needs_value = function.is_registered or (returned is not None and returned.kinds & ~16 != 0)
        finish: Finish = lambda block: none() if needs_value else None
        return self.body(body, Mode(ast.Return, finish))

    def _generator(self, function: Function, body: Sequence[ast.stmt]) -> list[Code]:
        """What a generator yields, as a list."""
        block = Block()
        collection = self.analysed.collections.by_generator.get(function)
        if collection is not None:
            collecting = Collecting(collection, False, False)
            block.collecting.append(collecting)
            mode = Mode(None, lambda b: b.collecting[0].combined(), collection=collecting)
            forms = self.body(body, mode, block)
        else:
            variable = self.place.yields = PythonVariable(
                "frames" if function.is_animation else "items", None, is_temporary=True
            )
            block.add(BlockItem("define", form("mutable-list"), PURE, (variable,), VariableRef(variable)))
            inner = self.body(body, Mode(None, lambda b: None))
            escape = self.place.returns.variable
            if escape is not None:  # `return` ends the generator; what was yielded so far stands
                self.place.returns.variable = None
                inner = [form("let/ec", VariableRef(escape), *inner)]
            forms = [*assemble(block.items, None)[:1], *inner, VariableRef(variable)]
        if function.is_animation:
            frames = form("frames", forms[-1])
            frames.blank, forms[-1].blank = forms[-1].blank, False
            return [*forms[:-1], frames]
        return forms

    def body(self, statements: Sequence[ast.stmt], mode: Mode, block: Block | None = None) -> list[Code]:
        """The forms of a block in tail position."""
        block = block or Block()
        for position, statement in enumerate(statements):
            rest = statements[position + 1 :]
            self._define_cells(statement, block)
            if mode.leaving is not None and isinstance(statement, mode.leaving):
                return assemble(block.items, self._leave(statement, mode, block))
            if isinstance(statement, ast.If) and mode.leaving is not None and leaves(statement, mode.leaving):
                final = self._leaving_branch(statement, rest, mode, block)
                if final is not None:
                    return assemble(block.items, final)
            if isinstance(statement, ast.Try) and mode.leaving is ast.Return and always_leaves([statement], ast.Return):
                return assemble(
                    block.items, self._noted(block, statement, partial(self._guarded_value, statement, mode))
                )
            if mode.leaving is ast.Continue and block.collecting and leaves(statement, ast.Continue):
                self._keep_collected(block)
            self.statement(statement, block)
        if block.has_left and mode.collection is None:
            return assemble(block.items, None)
        return assemble(block.items, mode.finish(block))

    def _define_cells(self, statement: ast.stmt, block: Block) -> None:
        """Define the variables that are assigned in place from ``statement`` on."""
        for cell in self.places.before.pop(statement, ()):
            block.add(BlockItem("define", none(), Effect(writes=frozenset((cell,))), (cell,), VariableRef(cell)))

    def _keep_collected(self, block: Block) -> None:
        """A ``continue`` deep inside the next statement gives what this turn has collected so far."""
        collecting = block.collecting[0]
        block.name_pieces(collecting)
        if collecting.pieces:
            self.place.continues[-1].value = collecting.combined

    def _leave(self, statement: ast.stmt, mode: Mode, block: Block) -> Code | None:
        if isinstance(statement, ast.Return):
            return self._noted(block, statement, lambda: self._returned(statement, block))
        code = self._noted(block, statement, lambda: mode.finish(block) or none())
        is_nothing = type(code) is LiteralCode and code.value is None
        if is_nothing and block.items and block.items[-1].kind == "effect":  # what it does is enough
            block.items[-1].note.before = (*block.items[-1].note.before, *code.before)
            return None
        return code

    def _returned(self, statement: ast.Return, block: Block) -> Code:
        if statement.value is None:
            return none()
        if (
            isinstance(statement.value, (ast.List, ast.Tuple))
            and not statement.value.elts
            and self._is_shape_function()
        ):
            return form("union")
        return self.expr(statement.value)

    def _is_shape_function(self) -> bool:
        function = self.place.function
        returned = self.facts.returns.get(function)
        return function.is_registered or (returned is not None and bool(returned.kinds & SHAPE))

    def _noted(self, block: Block, statement: ast.stmt, write: Callable[[], Code]) -> Code:
        """Write a final statement with its comments."""
        saved = self.begin_statement(statement.lineno, statement.end_lineno or statement.lineno)
        note = Code(None)
        self._open_note(note, statement)
        try:
            code = write()
        finally:
            self.end_statement(saved)
        if isinstance(statement, ast.If):
            self._finish_note(note, None)
        else:
            self._finish_note(note, statement)
        code.before = (*note.before, *code.before)
        code.after = code.after or note.after
        code.blank = note.blank or code.blank
        return code

    def _open_note(self, note: Code, statement: ast.stmt) -> None:
        """The comments above a statement; of a compound one also that at the end of its head."""
        body = getattr(statement, "body", None)
        body = body or []
        head_end = body[0].lineno - 1 if body else 0
        note.before = (*self.pending_texts, *note.before)
        self.pending_texts = []
        first = (
            statement.decorator_list[0].lineno
            if isinstance(statement, ast.FunctionDef) and statement.decorator_list
            else statement.lineno
        )
        self.open_comments(note, first)
        if head_end >= statement.lineno and not isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
            for comment in self._unused(statement.lineno, head_end):
                if not comment.alone or comment.line < body[0].lineno - 1:
                    note.before = (*note.before, self._take(comment))

    def _finish_note(self, note: Code, statement: ast.stmt | None) -> None:
        if statement is not None and not hasattr(statement, "body"):
            self.close_comments(note, statement.lineno, statement.end_lineno or statement.lineno)

    # --- branches that leave ---

    def _leaving_branch(self, node: ast.If, rest: Sequence[ast.stmt], mode: Mode, block: Block) -> Code | None:
        """``if c: return a`` and what follows, as one ``cond``. None where an escape says it better."""
        assert mode.leaving is not None
        if mode.collection is not None and block.collecting and block.collecting[0].pieces:
            block.name_pieces(block.collecting[0])
        clauses: list[Code] = []
        if not self._leaving_clauses(node, list(rest), mode, block, clauses, dry=True):
            return None
        note = Code(None)
        self._open_note(note, node)
        self._leaving_clauses(node, list(rest), mode, block, clauses, dry=False)
        code = unless(clauses) or conditional(clauses)
        code.before = (*note.before, *code.before)
        code.blank = note.blank
        return code

    def _leaving_clauses(
        self, node: ast.If, rest: list[ast.stmt], mode: Mode, block: Block, clauses: list[Code], dry: bool
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
            test = self.test(node.test)
            self._take_head_comment(node)
            clauses.append(self._clause(test, self._inner(body, mode, block), node.test))
        if len(orelse) >= 1 and isinstance(orelse[0], ast.If) and leaves(orelse[0], mode.leaving):
            inner_rest = list(orelse[1:])
            if self._leaving_clauses(orelse[0], inner_rest, mode, block, [], dry=True):
                if dry:
                    return True
                note = Code(None)
                self._open_note(note, orelse[0])
                more: list[Code] = []
                self._leaving_clauses(orelse[0], inner_rest, mode, block, more, dry=False)
                if more:
                    more[0].before = (*note.before, *more[0].before)
                    more[0].blank = note.blank
                clauses += more
                return True
        if not dry:
            clauses.append(self._clause(Name("else"), self._inner(orelse, mode, block), None))
        return True

    def _take_head_comment(self, node: ast.stmt) -> None:
        """A comment at the end of ``if c:`` that nobody took goes above what comes next."""
        return

    def _clause(self, test: Code, body: list[Code], node: ast.expr | None) -> FormCode:
        return FormCode([test, *(body or [none()])], self.span(node) if node is not None else None)

    def _inner(self, statements: Sequence[ast.stmt], mode: Mode, outer: Block) -> list[Code]:
        """A branch in tail position, with what has been collected so far."""
        block = Block()
        for collecting in outer.collecting:
            copy = Collecting(collecting.collection, collecting.unites, collecting.is_mutated, list(collecting.pieces))
            block.collecting.append(copy)
        return self.body(statements, mode, block)
