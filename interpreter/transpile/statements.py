"""Python statements -> bodies. Straight-line code becomes definitions, branches become values; only what outlives a
turn of a loop or is seen by a closure is assigned in place."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.transpile.blocks import Block, Collecting, Item, Piece, assemble, total
from scenelang.interpreter.transpile.cells import CellPlaces
from scenelang.interpreter.transpile.code import (
    Code,
    Form,
    Key,
    Literal,
    Name,
    Ref,
    form,
    is_form,
    none,
    number,
    quote,
)
from scenelang.interpreter.transpile.collect import Collection, addition
from scenelang.interpreter.transpile.domain import ARRAY, DICT, LIST, POSE, SEQUENCES, SHAPE
from scenelang.interpreter.transpile.effects import PURE, Effect
from scenelang.interpreter.transpile.expressions import ExpressionWriter, is_constant
from scenelang.interpreter.transpile.operators import axes, numeric
from scenelang.interpreter.transpile.paths import is_annotation
from scenelang.interpreter.transpile.records import write_field
from scenelang.interpreter.transpile.scopes import Class, Function, Variable
from scenelang.interpreter.transpile.writer import Analysed

Finish = Callable[[Block], Code | None]


@dataclass(eq=False)
class Jump:
    """A place that `return`, `break` or `continue` may have to leave early; used when a plain branch cannot say it."""

    name: str
    variable: Variable | None = None

    def escape(self) -> Variable:
        if self.variable is None:
            self.variable = Variable(self.name, None, is_temporary=True)
        return self.variable


@dataclass(eq=False)
class Mode:
    """What a body is for. ``leaving``: the statement that ends it early in tail position (``return`` of a function,
    ``continue`` of a loop's body); ``finish`` gives the value when its end is reached."""

    leaving: type[ast.stmt] | None
    finish: Finish
    is_tail: bool = True
    collection: Collecting | None = None


@dataclass(eq=False)
class Place:
    """The function being written, and the loops around the statement."""

    function: Function
    returns: Jump = field(default_factory=lambda: Jump("return"))
    breaks: list[Jump] = field(default_factory=list)
    continues: list[Jump] = field(default_factory=list)
    yields: Variable | None = None


class StatementWriter(ExpressionWriter):
    def __init__(self, analysed: Analysed) -> None:
        super().__init__(analysed)
        self.places = CellPlaces(analysed.names, analysed.liveness)
        self.place = Place(analysed.names.module)
        self._last_break = Jump("break")
        self.pending_texts: list[str] = []

    # --- bodies ------------------------------------------------------------------------------------------------

    def function_body(self, function: Function) -> list[Code]:
        """The forms of a function's body, its docstring left out."""
        saved = self.place, self.pending_texts
        self.place, self.pending_texts = Place(function), []
        body = _without_docstring(function.body)
        try:
            forms = self._generator(function, body) if function.is_generator else self._plain_body(function, body)
        finally:
            escape = self.place.returns.variable
            self.place, self.pending_texts = saved
        if escape is not None:
            forms = [form("let/ec", Ref(escape), *forms)]
        return forms or [none()]

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
            variable = self.place.yields = Variable(
                "frames" if function.is_animation else "items", None, is_temporary=True
            )
            block.add(Item("define", form("mutable-list"), PURE, (variable,), Ref(variable)))
            forms = self.body(body, Mode(None, lambda b: Ref(variable)), block)
            escape = self.place.returns.variable
            if escape is not None:  # `return` ends the generator; what was yielded so far stands
                self.place.returns.variable = None
                forms = [forms[0], form("let/ec", Ref(escape), *forms[1:-1]), forms[-1]]
        if function.is_animation:
            return [*forms[:-1], form("frames", forms[-1])]
        return forms

    def body(self, statements: Sequence[ast.stmt], mode: Mode, block: Block | None = None) -> list[Code]:
        """The forms of a block in tail position."""
        block = block or Block()
        for position, statement in enumerate(statements):
            rest = statements[position + 1 :]
            if mode.leaving is not None and isinstance(statement, mode.leaving):
                return assemble(block.items, self._leave(statement, mode, block))
            if isinstance(statement, ast.If) and mode.leaving is not None and _leaves(statement, mode.leaving):
                final = self._leaving_branch(statement, rest, mode, block)
                if final is not None:
                    return assemble(block.items, final)
            if (
                isinstance(statement, ast.Try)
                and mode.leaving is ast.Return
                and _always_leaves([statement], ast.Return)
            ):
                return assemble(
                    block.items, self._noted(block, statement, partial(self._guarded_value, statement, mode))
                )
            self.statement(statement, block)
        return assemble(block.items, mode.finish(block))

    def _leave(self, statement: ast.stmt, mode: Mode, block: Block) -> Code | None:
        if isinstance(statement, ast.Return):
            return self._noted(block, statement, lambda: self._returned(statement, block))
        self._noted(block, statement, none)
        return mode.finish(block)

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

    # --- branches that leave -----------------------------------------------------------------------------------

    def _leaving_branch(self, node: ast.If, rest: Sequence[ast.stmt], mode: Mode, block: Block) -> Code | None:
        """``if c: return a`` and what follows, as one ``cond``. None where an escape says it better."""
        assert mode.leaving is not None
        if mode.collection is not None and block.collecting and block.collecting[0].pieces:
            block._name_pieces(block.collecting[0])
        clauses: list[Code] = []
        if not self._leaving_clauses(node, list(rest), mode, block, clauses, dry=True):
            return None
        note = Code(None)
        self._open_note(note, node)
        self._leaving_clauses(node, list(rest), mode, block, clauses, dry=False)
        code = _unless(clauses) or _conditional(clauses)
        code.before = (*note.before, *code.before)
        code.blank = note.blank
        return code

    def _leaving_clauses(
        self, node: ast.If, rest: list[ast.stmt], mode: Mode, block: Block, clauses: list[Code], dry: bool
    ) -> bool:
        """Append the clauses of ``node`` followed by ``rest``; ``dry`` only tells whether that is possible."""
        assert mode.leaving is not None
        body_leaves = _always_leaves(node.body, mode.leaving)
        else_leaves = bool(node.orelse) and _always_leaves(node.orelse, mode.leaving)
        if not body_leaves and not else_leaves and len(rest) > 1:
            return False  # the rest would be written twice
        body = node.body if body_leaves else [*node.body, *rest]
        orelse = node.orelse if else_leaves else [*node.orelse, *rest]
        if not dry:
            test = self.test(node.test)
            self._take_head_comment(node)
            clauses.append(self._clause(test, self._inner(body, mode, block), node.test))
        if len(orelse) >= 1 and isinstance(orelse[0], ast.If) and _leaves(orelse[0], mode.leaving):
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

    def _clause(self, test: Code, body: list[Code], node: ast.expr | None) -> Form:
        return Form([test, *(body or [none()])], self.span(node) if node is not None else None)

    def _inner(self, statements: Sequence[ast.stmt], mode: Mode, outer: Block) -> list[Code]:
        """A branch in tail position, with what has been collected so far."""
        block = Block()
        for collecting in outer.collecting:
            copy = Collecting(collecting.collection, collecting.unites, collecting.is_mutated, list(collecting.pieces))
            block.collecting.append(copy)
        return self.body(statements, mode, block)

    # --- statements --------------------------------------------------------------------------------------------

    def statement(self, node: ast.stmt, block: Block) -> None:
        """Add a statement to a block. A mistake is noted, so that others show as well."""
        saved = self.begin_statement(node.lineno, node.end_lineno or node.lineno)
        note = Code(None)
        try:
            if _text_of(node) is not None:
                self.pending_texts += _comment_lines(_text_of(node) or "")
                return
            if isinstance(node, (ast.Pass, ast.Global, ast.Nonlocal, ast.Import, ast.ImportFrom)):
                self._check_import(node)
                return
            self._open_note(note, node)
            for cell in self.places.before.get(node, ()):
                block.add(Item("define", none(), Effect(writes=frozenset((cell,))), (cell,), Ref(cell)))
            handler = getattr(self, f"_{type(node).__name__}_statement", None)
            if handler is None:
                raise self.unsupported(f"`{type(node).__name__.lower()}`", node)
            collecting = self._adds_to(node, block)
            if collecting is not None:
                self._add_to(collecting, node, block, note)
            else:
                handler(node, block, note)
            self._finish_note(note, node)
            self._finish_collections(node, block)
        except SceneError as error:
            if error.span is None:
                error.span = self.span(node)
            self.diagnostics.append(error.diagnostic)
            self._finish_note(note, node)
        finally:
            self.end_statement(saved)

    def _check_import(self, node: ast.stmt) -> None:
        """An unused import is ignored, whatever it imports; a use is looked at where it stands."""

    def _Expr_statement(self, node: ast.Expr, block: Block, note: Code) -> None:
        value = node.value
        if isinstance(value, (ast.Yield, ast.YieldFrom)):
            assert self.place.yields is not None
            frames = Ref(self.place.yields)
            assert value.value is not None or isinstance(value, ast.Yield)
            code = self.expr(value.value) if value.value is not None else none()
            head = "push!" if isinstance(value, ast.Yield) else "extend!"
            block.add_effect(form(head, frames, code, span=self.span(node)), Effect(changes=True), note)
            return
        if node in self.analysed.collections.functional:
            self._functional(node, block, note)
            return
        if isinstance(value, ast.Constant):
            return
        effect = self.effect(value)
        if not effect.acts and not isinstance(value, ast.Call):
            return
        block.add_effect(self.expr(value), effect, note)

    def _functional(self, node: ast.Expr, block: Block, note: Code) -> None:
        """``random.shuffle(xs)``, ``xs.sort()`` of a list that was just made: a new list instead."""
        call = node.value
        assert isinstance(call, ast.Call)
        target = (
            call.func.value if isinstance(call.func, ast.Attribute) and not self.paths.of(call.func) else call.args[0]
        )
        variable = self.names.variables[target]
        code = self.expr(call)
        if any(site.is_mutated for site in self.type(target).sites):
            block.add_effect(code, self.effect(call) | Effect(changes=True), note)
            return
        assert isinstance(code, Form)
        head = code.items[0]
        assert isinstance(head, Name)
        code.items[0] = Name(head.text.rstrip("!"))
        block.define(variable, code, self.effect(call), note)

    def _Assert_statement(self, node: ast.Assert, block: Block, note: Code) -> None:
        items = [self.test(node.test)]
        if node.msg is not None and isinstance(node.msg, ast.Constant):
            items.append(self.expr(node.msg))
        block.add_effect(
            form("assert", *items, span=self.span(node)), self.effect(node.test) | Effect(changes=True), note
        )

    def _Raise_statement(self, node: ast.Raise, block: Block, note: Code) -> None:
        message: Code = Literal("error")
        if isinstance(node.exc, ast.Call) and node.exc.args:
            message = self.expr(node.exc.args[0])
        elif isinstance(node.exc, ast.Name):
            message = Literal(node.exc.id)
        block.add_effect(form("error", message, span=self.span(node)), Effect(changes=True), note)

    def _Return_statement(self, node: ast.Return, block: Block, note: Code) -> None:
        jump = self.place.returns.escape()
        code = self._returned(node, block)
        is_nothing = type(code) is Literal and code.value is None
        block.add_effect(
            Form([Ref(jump), *([] if is_nothing else [code])], self.span(node)), Effect(changes=True), note
        )

    def _Break_statement(self, node: ast.Break, block: Block, note: Code) -> None:
        if not self.place.breaks:
            raise self.error("python-syntax", "`break` outside a loop", node)
        block.add_effect(Form([Ref(self.place.breaks[-1].escape())], self.span(node)), Effect(changes=True), note)

    def _Continue_statement(self, node: ast.Continue, block: Block, note: Code) -> None:
        if not self.place.continues:
            raise self.error("python-syntax", "`continue` outside a loop", node)
        block.add_effect(Form([Ref(self.place.continues[-1].escape())], self.span(node)), Effect(changes=True), note)

    def _Delete_statement(self, node: ast.Delete, block: Block, note: Code) -> None:
        for target in node.targets:
            if isinstance(target, ast.Name):
                continue
            if not isinstance(target, ast.Subscript) or isinstance(target.slice, ast.Slice):
                raise self.unsupported("this `del`", node)
            head = "remove-key!" if self.type(target.value).only(DICT) else "remove-at!"
            block.add_effect(form(head, self.expr(target.value), self.expr(target.slice)), Effect(changes=True), note)

    def _With_statement(self, node: ast.With, block: Block, note: Code) -> None:
        for item in node.items:
            self.expr(item.context_expr)
        raise self.unsupported("`with`", node)

    # --- assignment --------------------------------------------------------------------------------------------

    def _Assign_statement(self, node: ast.Assign, block: Block, note: Code) -> None:
        if is_annotation(self.paths, node.value):
            return
        collection = self.analysed.collections.by_start.get(node)
        if collection is not None:
            self._start(collection, node.value, block, note)
            return
        if len(node.targets) == 1:
            self.assign(node, node.targets[0], node.value, block, note)
            return
        first = node.targets[0]
        shared: Code
        if isinstance(first, ast.Name) and not self.names.variables[first].is_cell:
            self.assign(node, first, node.value, block, note)
            shared = Ref(self.names.variables[first])
            rest = node.targets[1:]
        elif is_constant(node.value):
            for target in node.targets:
                self.assign(node, target, node.value, block, note if target is first else Code(None))
            return
        else:
            shared = self._temporary(self.expr(node.value), self.effect(node.value), block, note)
            rest = node.targets
        for target in rest:
            self.store(node, target, shared, PURE, block, Code(None))

    def _AnnAssign_statement(self, node: ast.AnnAssign, block: Block, note: Code) -> None:
        if node.value is None:
            return
        collection = self.analysed.collections.by_start.get(node)
        if collection is not None:
            self._start(collection, node.value, block, note)
        else:
            self.assign(node, node.target, node.value, block, note)

    def assign(self, node: ast.stmt, target: ast.expr, value: ast.expr, block: Block, note: Code) -> None:
        """``target = value``."""
        if isinstance(target, (ast.Tuple, ast.List)):
            if isinstance(value, (ast.Tuple, ast.List)) and self._parallel(node, target.elts, value.elts, block, note):
                return
            self.unpack(node, target, value, block, note)
            return
        if isinstance(target, ast.Subscript):
            effect = self.effect(target, value) | Effect(changes=True)
            block.add_effect(self.set_item(target, self.expr(value)), effect, note)
            return
        self.store(node, target, self.expr(value), self.effect(value), block, note)

    def store(self, node: ast.stmt, target: ast.expr, code: Code, effect: Effect, block: Block, note: Code) -> None:
        """Assign a value that is written already."""
        if isinstance(target, ast.Name):
            variable = self.names.variables[target]
            if not variable.is_cell:
                if variable.name == "_" and not variable.reads:
                    block.add_effect(code, effect, note)
                else:
                    block.define(variable, code, effect, note)
            elif variable in self.places.definitions.get(node, ()):
                writes = effect | Effect(writes=frozenset((variable,)))
                block.add(Item("define", code, writes, (variable,), Ref(variable, self.span(target)), note))
            else:
                writes = effect | Effect(writes=frozenset((variable,)))
                block.add_effect(form("set!", Ref(variable), code, span=self.span(node)), writes, note)
        elif isinstance(target, ast.Subscript):
            block.add_effect(self.set_item(target, code), effect | self.effect(target) | Effect(changes=True), note)
        elif isinstance(target, ast.Attribute):
            block.add_effect(write_field(self, target, code), effect | Effect(changes=True), note)
        elif isinstance(target, (ast.Tuple, ast.List)):
            self._unpack_code(node, target, code, effect, block, note)
        else:
            raise self.unsupported("this target", target)

    def set_item(self, target: ast.Subscript, value: Code) -> Code:
        """``container[key] = value``."""
        keys: list[Code] = []
        inner: ast.expr = target
        while isinstance(inner, ast.Subscript) and not isinstance(inner.slice, ast.Slice):
            if isinstance(inner.slice, ast.Tuple) and self.type(inner.value).kinds & (ARRAY | POSE):
                keys = [*axes(self, inner.slice.elts), *keys]
            elif inner is not target and self.type(inner.value).kinds & DICT:
                break
            elif inner is target or self.type(inner.value).only(SEQUENCES | ARRAY):
                keys = [numeric(self, inner.slice), *keys]
            else:
                break
            inner = inner.value
            if self.type(inner).kinds & DICT and isinstance(inner, ast.Subscript):
                break
        if inner is target:
            assert isinstance(target.slice, ast.Slice)
            if not self.type(target.value).kinds & ARRAY:
                return self._splice(target, value)
            keys, inner = axes(self, [target.slice]), target.value
        return form("set-ref!", self.expr(inner), *keys, value, span=self.span(target))

    def _splice(self, target: ast.Subscript, value: Code) -> Code:
        """``xs[a:b] = items``."""
        bounds = target.slice
        assert isinstance(bounds, ast.Slice)
        if bounds.step is not None:
            raise self.unsupported("assigning a slice with a step", target)
        lower, upper = (self.expr(b) if b is not None else none() for b in (bounds.lower, bounds.upper))
        return form("splice!", self.expr(target.value), lower, upper, value, span=self.span(target))

    def _temporary(self, code: Code, effect: Effect, block: Block, note: Code) -> Ref:
        variable = Variable("value", None, is_temporary=True)
        block.define(variable, code, effect, note, nests=False)
        return Ref(variable)

    def _parallel(
        self, node: ast.stmt, targets: list[ast.expr], values: list[ast.expr], block: Block, note: Code
    ) -> bool:
        """``a, b = x, y`` as separate definitions; runs of constants as one ``define-values``."""
        if len(targets) != len(values) or any(isinstance(e, ast.Starred) for e in (*targets, *values)):
            return False
        if any(not isinstance(t, ast.Name) for t in targets):
            return False
        variables = [self.names.variables[t] for t in targets]
        if self._interferes(variables, values):
            if any(v.is_cell for v in variables):
                self._through_temporaries(node, targets, values, block, note)
                return True
            codes = [self.expr(value) for value in values]
            self._define_pattern(targets, form("list", *codes), self.effect(*values), block, note)
            return True
        position = 0
        while position < len(targets):
            end = position
            while end < len(targets) and is_constant(values[end]) and not variables[end].is_cell:
                end += 1
            if end - position > 1:
                data = quote(Form([self.expr(v) for v in values[position:end]]))
                self._define_pattern(targets[position:end], data, PURE, block, note)
                position = end
            else:
                self.store(
                    node, targets[position], self.expr(values[position]), self.effect(values[position]), block, note
                )
                position += 1
            note = Code(None)
        return True

    def _interferes(self, variables: list[Variable], values: list[ast.expr]) -> bool:
        """Whether a later value reads an earlier target."""
        seen: set[Variable] = set()
        for variable, value in zip(variables, values):
            if seen & self.liveness.uses(value):
                return True
            seen.add(variable)
        return False

    def _through_temporaries(
        self, node: ast.stmt, targets: list[ast.expr], values: list[ast.expr], block: Block, note: Code
    ) -> None:
        variables = [Variable("value", None, is_temporary=True) for _ in targets]
        bindings = Form([Form([Ref(v), self.expr(value)]) for v, value in zip(variables, values)])
        inner = Block()
        for target, variable in zip(targets, variables):
            self.store(node, target, Ref(variable), PURE, inner, Code(None))
        effect = self.effect(*values) | total(item.effect for item in inner.items)
        if all(item.kind == "effect" for item in inner.items):
            block.add_effect(form("let", bindings, *(item.value for item in inner.items)), effect, note)
            return
        for variable, value in zip(variables, values):
            block.define(variable, self.expr(value), self.effect(value), note, nests=False)
            note = Code(None)
        for item in inner.items:
            block.add(item)

    def unpack(self, node: ast.stmt, target: ast.Tuple | ast.List, value: ast.expr, block: Block, note: Code) -> None:
        """``a, (b, c) = value``."""
        code = self.iterable(value) if self.type(value).kinds & SHAPE else self.expr(value)
        self._unpack_code(node, target, code, self.effect(value), block, note, value)

    def _unpack_code(
        self, node: ast.stmt, target: ast.Tuple | ast.List, code: Code, effect: Effect, block: Block, note: Code,
        value: ast.expr | None = None,
    ) -> None:  # fmt: skip
        elements = target.elts
        star = next((i for i, e in enumerate(elements) if isinstance(e, ast.Starred)), None)
        if star is not None and star < len(elements) - 1:
            self._unpack_star(node, elements, star, code, effect, block, note)
            return
        names = [n for n in ast.walk(target) if isinstance(n, ast.Name)]
        is_plain = all(isinstance(e, (ast.Name, ast.Tuple, ast.List, ast.Starred)) for e in elements)
        defined = self.places.definitions.get(node, set())
        if is_plain and all(not self.names.variables[n].is_cell or self.names.variables[n] in defined for n in names):
            self._define_pattern(elements, code, effect, block, note)
            return
        self._unpack_to_cells(node, target, code, effect, block, note)

    def _unpack_to_cells(
        self, node: ast.stmt, target: ast.Tuple | ast.List, code: Code, effect: Effect, block: Block, note: Code
    ) -> None:
        """Targets that are assigned in place get their values from temporaries."""
        variables: list[Variable] = []
        patterns: list[Code] = []
        defined = self.places.definitions.get(node, set())
        rest: Code | None = None
        for element in target.elts:
            if isinstance(element, ast.Starred):
                variable = Variable("rest", None, is_temporary=True)
                rest = Ref(variable)
                variables.append(variable)
                patterns.append(rest)
                continue
            own = self.names.variables.get(element)
            if own is not None and (not own.is_cell or own in defined):
                variables.append(own)
                patterns.append(self.pattern(element))
                continue
            is_ignored = own is not None and own.name == "_" and not own.reads
            name = element.id if isinstance(element, ast.Name) else "value"
            variable = Variable(name, None, is_temporary=True)
            variables.append(variable)
            patterns.append(Name("_") if is_ignored else Ref(variable))
        inner = Block()
        for element, variable, pattern in zip(target.elts, variables, patterns):
            if type(pattern) is not Ref or not variable.is_temporary:
                continue
            if isinstance(element, ast.Starred):
                self.store(node, element.value, self._starred_list(element, Ref(variable)), PURE, inner, Code(None))
            else:
                self.store(node, element, Ref(variable), PURE, inner, Code(None))
        plain = patterns[:-1] if rest is not None else patterns
        whole = Form(plain, None, rest)
        if all(item.kind == "effect" for item in inner.items) and all(v.is_temporary for v in variables):
            bindings = Form([Form([whole, code])])
            total_effect = effect | total(item.effect for item in inner.items)
            block.add_effect(form("let", bindings, *(item.value for item in inner.items)), total_effect, note)
            return
        block.add(Item("define", code, effect, tuple(variables), whole, note))
        for item in inner.items:
            block.add(item)

    def _unpack_star(
        self, node: ast.stmt, elements: list[ast.expr], star: int, code: Code, effect: Effect, block: Block, note: Code
    ) -> None:
        """``*a, b = xs``: a slice for the star, a pattern for what stands behind it."""
        starred = elements[star]
        assert isinstance(starred, ast.Starred)
        after = len(elements) - star - 1
        is_ignored = isinstance(starred.value, ast.Name) and not self.names.variables[starred.value].reads
        if star == 0 and is_ignored:
            self._define_pattern(elements[1:], form("slice", code, number(-after)), effect, block, note)
            return
        source = code if type(code) is Ref else self._temporary(code, effect, block, note)
        assert type(source) is Ref
        note = Code(None) if source is not code else note
        if star:
            pattern = Form([*(self.pattern(e) for e in elements[:star])], None, Name("_"))
            variables = tuple(
                self.names.variables[n] for e in elements[:star] for n in ast.walk(e) if isinstance(n, ast.Name)
            )
            block.add(Item("define", Ref(source.variable), PURE, variables, pattern, note))
        middle = self._starred_list(starred, form("slice", Ref(source.variable), number(star), number(-after)))
        self.store(node, starred.value, middle, PURE, block, Code(None))
        self._define_pattern(
            elements[star + 1 :], form("slice", Ref(source.variable), number(-after)), PURE, block, Code(None)
        )

    def _define_pattern(
        self, targets: Sequence[ast.expr], code: Code, effect: Effect, block: Block, note: Code
    ) -> None:
        last = targets[-1] if targets else None
        rest = last.value if isinstance(last, ast.Starred) else None
        if isinstance(last, ast.Starred) and self._is_mutated_star(last) and isinstance(rest, ast.Name):
            given = Variable(rest.id, None, is_temporary=True)
            pattern = Form([self.pattern(t) for t in targets[:-1]], None, Ref(given))
            names = [n for t in targets[:-1] for n in ast.walk(t) if isinstance(n, ast.Name)]
            bound = (*(self.names.variables[n] for n in names), given)
            block.add(Item("define", code, effect, bound, pattern, note))
            block.define(self.names.variables[rest], form("mutable", Ref(given)), PURE, Code(None), nests=False)
            return
        plain = targets[:-1] if rest is not None else targets
        pattern = Form([self.pattern(t) for t in plain], None, self.pattern(rest) if rest is not None else None)
        variables = tuple(
            self.names.variables[n] for t in targets for n in ast.walk(t)
            if isinstance(n, ast.Name) and not (n.id == "_" and not self.names.variables[n].reads)
        )  # fmt: skip
        block.add(Item("define", code, effect, variables, pattern, note))

    def _is_mutated_star(self, node: ast.Starred) -> bool:
        return any(site.is_mutated and site.node is node for site in self.type(node.value).sites)

    def _starred_list(self, node: ast.Starred, code: Code) -> Code:
        """What a star takes is a new list, which may change."""
        return form("mutable", code) if self._is_mutated_star(node) else code

    def _AugAssign_statement(self, node: ast.AugAssign, block: Block, note: Code) -> None:
        target, found = node.target, self.type(node.target)
        if isinstance(node.op, ast.Add) and found.kinds & LIST and not found.kinds & ~(LIST | SHAPE):
            self._extend_in_place(node, block, note)
            return
        if found.kinds & ARRAY and found.only(ARRAY) and any(site.is_mutated for site in found.sites):
            if self._update_array(node, block, note):
                return
        load = self.loaded(target)
        operation = ast.copy_location(ast.BinOp(load, node.op, node.value), node)
        self.facts.types[operation] = self.type(node)
        effect = self.effect(node.value, target)
        if isinstance(target, ast.Subscript):
            effect = effect | Effect(changes=True, looks=True)
            if self.effect(target.value, target.slice).acts:
                raise self.unsupported("updating an item whose index does something", node)
        self.store(node, target, self.expr(operation), effect, block, note)

    def loaded(self, target: ast.expr) -> ast.expr:
        """The same place, read."""
        load: ast.expr
        if isinstance(target, ast.Name):
            load = ast.Name(target.id, ast.Load())
            self.names.variables[load] = self.names.variables[target]
        elif isinstance(target, ast.Subscript):
            load = ast.Subscript(target.value, target.slice, ast.Load())
        elif isinstance(target, ast.Attribute):
            load = ast.Attribute(target.value, target.attr, ast.Load())
        else:
            raise self.unsupported("this target", target)
        self.facts.types[load] = self.type(target)
        return ast.copy_location(load, target)

    def _extend_in_place(self, node: ast.AugAssign, block: Block, note: Code) -> None:
        effect = self.effect(node.value) | Effect(changes=True)
        target = self.loaded(node.target)
        if (
            isinstance(node.value, ast.List)
            and len(node.value.elts) == 1
            and not isinstance(node.value.elts[0], ast.Starred)
        ):
            code = form("push!", self.expr(target), self.expr(node.value.elts[0]), span=self.span(node))
        else:
            code = form("extend!", self.expr(target), self.iterable(node.value), span=self.span(node))
        block.add_effect(code, effect, note)

    def _update_array(self, node: ast.AugAssign, block: Block, note: Code) -> bool:
        """``a += b`` changes the array itself, which others may see."""
        if not isinstance(node.target, ast.Name):
            return False
        load = self.loaded(node.target)
        operation = ast.copy_location(ast.BinOp(load, node.op, node.value), node)
        self.facts.types[operation] = self.type(node)
        code = form("set-ref!", self.expr(load), Key("all"), self.expr(operation), span=self.span(node))
        block.add_effect(code, self.effect(node.value) | Effect(changes=True, looks=True), note)
        return True

    # --- collections -------------------------------------------------------------------------------------------

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
                collecting.pieces.append(Piece(self.comment_item(code, element), is_many, self.effect(element)))
        elif isinstance(value, ast.ListComp):
            head = self.loop_head("/union" if collecting.unites else "/list", value.generators)
            collecting.pieces.append(Piece(Form([*head, self.expr(value.elt)]), True, self.effect(value)))
        elif isinstance(value, ast.Call) and value.args:
            collecting.pieces.append(Piece(self.iterable(value.args[0]), True, self.effect(value)))
        block.collecting.append(collecting)

    def _unites_all(self, collection: Collection) -> bool:
        element_types = [s.element for r in self.reads_of(collection.variable) for s in self.type(r).sites]
        if not element_types or not any(t.kinds & SHAPE for t in element_types):
            return False
        return all(t.only(SHAPE | LIST) for t in element_types) and self.is_united(collection.variable)

    def _adds_to(self, node: ast.stmt, block: Block) -> Collecting | None:
        return next((c for c in block.collecting if node in c.collection.adders), None)

    def _add_to(self, collecting: Collecting, node: ast.stmt, block: Block, note: Code) -> None:
        """Add the pieces that a statement gives to a list under collection."""
        found = addition(node, collecting.collection.variable, self.names)
        if found is not None:
            value, is_many = found
            code = self._added(value, is_many, collecting)
            self._finish_note(note, node)
            _hang(code, note)
            pieces = self._split(value, code, is_many)
            for piece in pieces:
                block.add_piece(collecting, piece)
            return
        if isinstance(node, ast.For):
            code = self._collecting_for(node, collecting, note)
            block.add_piece(collecting, Piece(code, True, self.effect(node)))
        elif isinstance(node, ast.If):
            piece = self._collecting_if(node, collecting)
            _hang(piece.code, note)
            block.add_piece(collecting, piece)
        else:
            raise self.unsupported("this way of building a list", node)

    def _added(self, value: ast.expr, is_many: bool, collecting: Collecting) -> Code:
        if is_many and not (collecting.unites and self.type(value).kinds & SHAPE):
            return self.iterable(value)
        return self.expr(value)

    def _split(self, value: ast.expr, code: Code, is_many: bool) -> list[Piece]:
        """``xs += [a, b]`` adds two items."""
        if is_many and isinstance(value, (ast.List, ast.Tuple)) and is_form(code, "list") and isinstance(code, Form):
            if code.before and len(code.items) > 1:
                code.items[1].before = (*code.before, *code.items[1].before)
            if code.after and len(code.items) > 1:
                code.items[-1].after = code.after
            effect = self.effect(value)
            return [Piece(item, False, effect) for item in code.items[1:]]
        return [Piece(code, is_many, self.effect(value))]

    def _collecting_for(self, node: ast.For, collecting: Collecting, note: Code) -> Code:
        one_each = not collecting.unites and self._adds_one(node.body, collecting.collection)
        kind = "/union" if collecting.unites else "/list" if one_each else "/append"
        inner = Collecting(collecting.collection, collecting.unites, False)

        def finish(block: Block) -> Code:
            pieces = block.collecting[0].pieces
            if one_each:
                return pieces[0].code
            return (
                block.collecting[0].combined() if pieces else (form("union") if collecting.unites else quote(Form([])))
            )

        code = self._for(node, kind, Mode(ast.Continue, finish, collection=inner), inner)
        _hang(code, note)
        return code

    def _adds_one(self, body: Sequence[ast.stmt], collection: Collection) -> bool:
        """Whether every path through a loop's body adds exactly one item."""
        adders = [s for s in body if s in collection.adders]
        if len(adders) != 1 or any(_leaves(s, ast.Continue) for s in body):
            return False
        found = addition(adders[0], collection.variable, self.names)
        if found is not None:
            return not found[1]
        if isinstance(adders[0], ast.If) and adders[0].orelse:
            return self._adds_one(adders[0].body, collection) and self._adds_one(adders[0].orelse, collection)
        if isinstance(adders[0], ast.For) and len(body) == 1:
            return self._adds_one(adders[0].body, collection)
        if isinstance(adders[0], ast.If) and len(body) == 1:
            return self._adds_one(adders[0].body, collection)
        return False

    def _collecting_if(self, node: ast.If, collecting: Collecting) -> Piece:
        one_each = bool(node.orelse) and not collecting.unites and self._adds_one([node], collecting.collection)

        def finish(block: Block) -> Code:
            pieces = block.collecting[0].pieces
            if one_each:
                return pieces[0].code
            return (
                block.collecting[0].combined() if pieces else (form("union") if collecting.unites else quote(Form([])))
            )

        mode = Mode(None, finish, collection=collecting)
        clauses: list[Code] = []
        self._value_clauses(node, mode, clauses, lambda: self._collecting_block(collecting))
        return Piece(_conditional(clauses), not one_each, self.effect(node))

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
                    block.add(Item("define", code, writes, (variable,), Ref(variable), collecting.note))
                else:
                    block.add_effect(form("set!", Ref(variable), code), writes, collecting.note)
            else:
                block.define(variable, code, effect, collecting.note, nests=False)

    # --- branches ----------------------------------------------------------------------------------------------

    def _If_statement(self, node: ast.If, block: Block, note: Code) -> None:
        if _is_main_guard(node):
            return
        variables = self._set_and_needed(node)
        if variables:
            self._phi(node, variables, block, note, lambda mode: self._if_value(node, mode))
            return
        block.add_effect(self._if_effect(node), self.effect(node), note)

    def _if_effect(self, node: ast.If) -> Code:
        """An ``if`` for what it does."""
        clauses: list[Code] = []
        self._effect_clauses(node, clauses)
        if len(clauses) == 1:
            clause = clauses[0]
            assert isinstance(clause, Form)
            test = clause.items[0]
            if is_form(test, "not") and isinstance(test, Form):
                return Form([Name("unless"), test.items[1], *clause.items[1:]], self.span(node))
            return Form([Name("when"), *clause.items], self.span(node))
        return _conditional(clauses)

    def _effect_clauses(self, node: ast.If, clauses: list[Code]) -> None:
        test = self.test(node.test)
        clauses.append(self._clause(test, self._effect_body(node.body), node.test))
        if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If) and not self._set_and_needed(node.orelse[0]):
            note = Code(None)
            self._open_note(note, node.orelse[0])
            position = len(clauses)
            self._effect_clauses(node.orelse[0], clauses)
            clauses[position].before = (*note.before, *clauses[position].before)
        elif node.orelse:
            clauses.append(self._clause(Name("else"), self._effect_body(node.orelse), None))

    def _effect_body(self, statements: Sequence[ast.stmt]) -> list[Code]:
        return self.body(statements, Mode(None, lambda block: None))

    def _set_and_needed(self, node: ast.stmt) -> list[Variable]:
        """The variables that a compound statement sets, not in place, and that are read after it."""
        after = self.liveness.after.get(node, frozenset())
        found: dict[Variable, None] = {}
        for inner in ast.walk(node):
            if isinstance(inner, (ast.Name, ast.FunctionDef)) and not (
                isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Load)
            ):
                variable = (
                    self.names.variables.get(inner)
                    if isinstance(inner, ast.Name)
                    else self.names.functions[inner].variable
                )
                if variable is not None and variable in after and not variable.is_cell:
                    found[variable] = None
        return list(found)

    def _phi(
        self, node: ast.stmt, variables: list[Variable], block: Block, note: Code, write: Callable[[Mode], Code]
    ) -> None:
        """``if c: x = a else: x = b`` is ``(define x (if c a b))``; several variables come as a list."""
        if len(variables) == 1:
            variable = variables[0]
            code = write(Mode(None, lambda b: Ref(variable)))
            block.define(variable, code, self.effect(node), note)
            return
        code = write(Mode(None, lambda b: _values(b, variables)))
        targets = Form([Ref(v) for v in variables])
        block.add(Item("define", code, self.effect(node), tuple(variables), targets, note))

    def _if_value(self, node: ast.If, mode: Mode) -> Code:
        clauses: list[Code] = []
        self._value_clauses(node, mode, clauses, Block)
        return _conditional(clauses)

    def _Try_statement(self, node: ast.Try, block: Block, note: Code) -> None:
        variables = self._set_and_needed(node)
        effect = self.effect(node) | Effect(changes=True)
        if variables:
            self._phi(node, variables, block, note, lambda mode: self._guarded_value(node, mode))
        else:
            block.add_effect(self._guarded_value(node, Mode(None, lambda b: None)), effect, note)
        for statement in node.finalbody:
            self.statement(statement, block)

    def _guarded_value(self, node: ast.Try, mode: Mode) -> Code:
        """``try`` as ``guard``; what is caught by name is told by the error's name."""
        clauses: list[Code] = []
        error = Variable("error", None, is_temporary=True)
        for handler in node.handlers:
            if handler.name:
                error = self.names.variables.get(handler, error)
        for handler in node.handlers:
            names = (
                []
                if handler.type is None
                else handler.type.elts
                if isinstance(handler.type, ast.Tuple)
                else [handler.type]
            )
            kinds = [_ERRORS.get(self.paths.of(n) or "") for n in names]
            if not kinds or None in kinds:
                test: Code = Literal(True)
            else:
                tests = [
                    form("error-is?", Ref(error), Literal(kind))
                    for kind in dict.fromkeys(k for ks in kinds for k in ks or ())
                ]
                test = tests[0] if len(tests) == 1 else form("or", *tests)
            clauses.append(Form([test, *(self.body(handler.body, mode) or [none()])]))
        body = self.body([*node.body, *node.orelse], mode)
        return form("guard", Form([Ref(error), *clauses]), *(body or [none()]), span=self.span(node))

    # --- loops -------------------------------------------------------------------------------------------------

    def _For_statement(self, node: ast.For, block: Block, note: Code) -> None:
        code = self._for(node, "", Mode(ast.Continue, lambda b: None), None)
        self._add_loop(node, code, block, note)

    def _add_loop(self, node: ast.For | ast.While, code: Code, block: Block, note: Code) -> None:
        jump = self._last_break
        effect = self.effect(node)
        if jump.variable is not None or (node.orelse and _leaves_loop(node.body)):
            orelse = self._effect_body(node.orelse) if node.orelse else []
            code = form("let/ec", Ref(jump.escape()), code, *orelse, span=self.span(node))
            block.add_effect(code, effect | Effect(changes=True), note)
            return
        block.add_effect(code, effect, note)
        for statement in node.orelse:
            self.statement(statement, block)

    def _for(self, node: ast.For, kind: str, mode: Mode, collecting: Collecting | None) -> Code:
        """A loop as ``(for/kind (clauses) body ...)``; loops that hold nothing but a loop become ``for*``."""
        jump = Jump("break")
        self.place.breaks.append(jump)
        clauses: list[Code] = []
        nested = False
        inner: ast.For = node
        prefix: list[Code] = []
        statements: list[ast.stmt] = []
        depth = 0
        while True:
            nested_inner = _only_loop(inner.body, collecting)
            nested = nested or nested_inner is not None
            clauses += self._for_clauses(inner, parallel=not nested, prefix=prefix)
            statements = list(inner.body)
            if prefix:
                break
            statements = self._guards(statements, clauses, breaks=depth == 0 and not collecting and not node.orelse)
            following = _only_loop(statements, collecting)
            if following is None or _own_breaks(following.body) or (depth and jump.variable):
                break
            nested = True
            note = Code(None)
            self._open_note(note, following)
            clauses[-1].before = (*clauses[-1].before, *note.before)
            inner = following
            depth += 1
        if nested and depth == 0:
            nested = False
        body = self._loop_body(statements, mode, collecting, prefix)
        self.place.breaks.pop()
        self._last_break = jump
        head = Name(f"for{'*' if depth else ''}{kind}")
        return Form([head, Form(clauses), *(body or [none()])], self.span(node))

    def _for_clauses(self, node: ast.For, parallel: bool, prefix: list[Code]) -> list[Code]:
        """The clauses of one ``for``; targets that are assigned in place are set first thing in the body."""
        target = node.target
        names = [n for n in ast.walk(target) if isinstance(n, ast.Name)]
        if isinstance(target, (ast.Name, ast.Tuple, ast.List)) and not any(
            self.names.variables[n].is_cell for n in names if n in self.names.variables
        ):
            if not isinstance(target, ast.Name) and any(
                not isinstance(n, (ast.Name, ast.Tuple, ast.List, ast.Starred, ast.Store)) for n in ast.walk(target)
            ):
                raise self.unsupported("this target of a loop", target)
            if _has_inner_star(target):
                variable = Variable("item", None, is_temporary=True)
                block = Block()
                assert isinstance(target, (ast.Tuple, ast.List))
                self._unpack_code(node, target, Ref(variable), PURE, block, Code(None))
                prefix += list(assemble(block.items, None))
                return [Form([Ref(variable), self.iterable(node.iter)])]
            return self.clauses(target, node.iter, parallel)
        variable = Variable(target.id if isinstance(target, ast.Name) else "item", None, is_temporary=True)
        block = Block()
        self.store(node, target, Ref(variable), PURE, block, Code(None))
        prefix += [
            item.value if item.kind == "effect" else form("define-values", item.target or none(), item.value)
            for item in block.items
        ]
        return [Form([Ref(variable), self.iterable(node.iter)])]

    def _guards(self, statements: list[ast.stmt], clauses: list[Code], breaks: bool) -> list[ast.stmt]:
        """Leading ``if c: continue`` and ``if c: break``, and an ``if`` around all, become clauses."""
        while statements and isinstance(statements[0], ast.If):
            first = statements[0]
            if (
                not first.orelse
                and len(first.body) == 1
                and isinstance(first.body[0], ast.Continue)
                and len(statements) > 1
            ):
                self._guard(first, clauses, holds=False)
                statements = statements[1:]
            elif not first.orelse and len(first.body) == 1 and isinstance(first.body[0], ast.Break) and breaks:
                note = Code(None)
                self._open_note(note, first)
                test = self.test(first.test)
                clauses += [Key("break"), test]
                clauses[-2].before = note.before
                statements = statements[1:]
                break
            elif not first.orelse and len(statements) == 1 and not _leaves(first, ast.Break):
                self._guard(first, clauses, holds=True)
                statements = first.body
            else:
                break
        return statements

    def _guard(self, node: ast.If, clauses: list[Code], holds: bool) -> None:
        note = Code(None)
        self._open_note(note, node)
        key, test = self.condition_clause(node.test, holds)
        key.before = note.before
        clauses += [key, test]

    def _loop_body(
        self, statements: Sequence[ast.stmt], mode: Mode, collecting: Collecting | None, prefix: list[Code]
    ) -> list[Code]:
        jump = Jump("continue")
        self.place.continues.append(jump)
        block = Block()
        if collecting is not None:
            block.collecting.append(Collecting(collecting.collection, collecting.unites, False))
        body = self.body(statements, mode, block)
        self.place.continues.pop()
        if jump.variable is not None:
            body = [form("let/ec", Ref(jump.variable), *body)]
        return [*prefix, *body]

    def _While_statement(self, node: ast.While, block: Block, note: Code) -> None:
        jump = Jump("break")
        self.place.breaks.append(jump)
        test = self.test(node.test)
        body = self._loop_body(node.body, Mode(ast.Continue, lambda b: None), None, [])
        self.place.breaks.pop()
        self._last_break = jump
        code = Form([Name("while"), test, *(body or [none()])], self.span(node))
        self._add_loop(node, code, block, note)

    # --- functions and classes ---------------------------------------------------------------------------------

    def _FunctionDef_statement(self, node: ast.FunctionDef, block: Block, note: Code) -> None:
        function = self.names.functions[node]
        assert function.variable is not None
        if node.args.defaults or node.args.kw_defaults:
            self.hoist_defaults(function, block)
        note.before = (*note.before, *docstring_lines(function))
        code = self.define_function(function, function.variable)
        self._finish_note(note, None)
        if function.variable.is_cell:
            code = Form([Name("set!"), Ref(function.variable), self.as_lambda(function)], self.span(node))
            effect = Effect(writes=frozenset((function.variable,)))
            if function.variable in self.places.definitions.get(node, ()):
                code.items[0] = Name("define")
            block.add_effect(code, effect, note)
            return
        if len(function.variable.stores) > 1 and len(function.variable.functions) < len(function.variable.stores):
            block.define(function.variable, self.as_lambda(function), PURE, note, nests=False)
            return
        if function.variable.functions[-1] is not function and len(set(function.variable.functions)) > 1:
            block.define(function.variable, self.as_lambda(function), PURE, note, nests=False)
            return
        block.add(Item("function", code, PURE, (function.variable,), None, note))

    def define_function(self, function: Function, variable: Variable) -> Form:
        """``(define (name parameter ...) body ...)``."""
        signature = self.parameters(function)
        header = Form([Ref(variable, self.span(function.node)), *signature.items], None, signature.rest)
        return Form([Name("define"), header, *self.function_body(function)], self.span(function.node))

    def as_lambda(self, function: Function) -> Form:
        """``(lambda (parameter ...) body ...)``."""
        return Form(
            [Name("lambda"), self.parameters(function), *self.function_body(function)], self.span(function.node)
        )

    def hoist_defaults(self, function: Function, block: Block) -> None:
        """Python evaluates defaults once, at the definition: those that could differ later become variables."""
        for parameter in function.parameters:
            node = parameter.default
            if node is None or self.may_stay(node):
                continue
            variable = Variable(f"{function.name}_{parameter.variable.name}", None, is_temporary=True)
            block.define(variable, self.expr(node), self.effect(node), Code(None), nests=False)
            self.defaults[node] = variable

    def _ClassDef_statement(self, node: ast.ClassDef, block: Block, note: Code) -> None:
        from scenelang.interpreter.transpile.classes import class_items

        record: Class = self.names.classes[node]
        for position, item in enumerate(class_items(self, record)):
            if position == 0:
                item.note = note
            block.add(item)


_ERRORS: dict[str, tuple[str, ...]] = {
    "ZeroDivisionError": ("zero-division",), "IndexError": ("index",), "KeyError": ("key",),
    "AssertionError": ("assert",),
    "LookupError": ("index", "key"), "ValueError": ("value", "domain", "type", "user"), "TypeError": ("type",),
}  # fmt: skip


def _values(block: Block, variables: list[Variable]) -> Code:
    """The list of several variables at the end of a branch; plain definitions go straight into it."""
    items = block.items
    if (
        [item.variables for item in items] == [(v,) for v in variables]
        and all(item.kind == "define" and type(item.target) is Ref for item in items)
        and not any(item.mentions(v) for item in items for v in variables)
        and not any(item.note.before or item.note.after for item in items)
    ):
        values = [item.value for item in items]
        items.clear()
        if all(type(value) is Literal for value in values):
            return quote(Form(values))
        return form("list", *values)
    if len(items) == 1 and isinstance(items[0].target, Form) and items[0].variables == tuple(variables):
        return items.pop().value
    return form("list", *(Ref(v) for v in variables))


def _conditional(clauses: list[Code]) -> Code:
    """``(if test a b)`` where two short branches do, else ``cond``; nested conditions are flattened."""
    last = clauses[-1]
    while isinstance(last, Form) and len(last.items) == 2 and is_form(last, "else") and not last.before:
        inner = last.items[1]
        if not (is_form(inner, "cond") and isinstance(inner, Form)) or inner.before:
            break
        clauses = [*clauses[:-1], *inner.items[1:]]
        last = clauses[-1]
    if len(clauses) == 2 and is_form(clauses[1], "else"):
        first, second = clauses
        assert isinstance(first, Form)
        assert isinstance(second, Form)
        if len(first.items) == 2 and len(second.items) == 2 and not first.before and not second.before:
            return Form([Name("if"), first.items[0], first.items[1], second.items[1]], first.span)
    return Form([Name("cond"), *clauses], clauses[0].span)


def _unless(clauses: list[Code]) -> Code | None:
    """``(cond (test none) (else body ...))``, for what it does, is ``(unless test body ...)``."""
    if len(clauses) != 2:
        return None
    first, second = clauses
    assert isinstance(first, Form)
    assert isinstance(second, Form)
    is_nothing = type(first.items[-1]) is Literal and first.items[-1].value is None and len(first.items) == 2
    if not is_nothing or first.before or first.items[-1].before or second.before or not is_form(second, "else"):
        return None
    if type(second.items[-1]) is Literal or len(second.items) < 2:
        return None
    test = first.items[0]
    if is_form(test, "not") and isinstance(test, Form):
        return Form([Name("when"), test.items[1], *second.items[1:]], first.span)
    return Form([Name("unless"), test, *second.items[1:]], first.span)


def _hang(code: Code, note: Code) -> None:
    code.before = (*note.before, *code.before)
    code.after = code.after or note.after
    code.blank = code.blank or note.blank
    note.before, note.after, note.blank = (), None, False


def _leaves(statement: ast.stmt, kind: type[ast.stmt]) -> bool:
    """Whether ``statement`` holds a ``return``, ``continue`` or ``break`` that leaves what it stands in."""
    if isinstance(statement, kind):
        return True
    if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
        return False
    if isinstance(statement, (ast.For, ast.While)) and kind is not ast.Return:
        return any(_leaves(s, kind) for s in statement.orelse)
    blocks = [getattr(statement, name, None) or [] for name in ("body", "orelse", "finalbody")]
    blocks += [handler.body for handler in getattr(statement, "handlers", ())]
    return any(_leaves(s, kind) for block in blocks for s in block)


def _always_leaves(body: Sequence[ast.stmt], kind: type[ast.stmt]) -> bool:
    """Whether the end of ``body`` is never reached."""
    for statement in body:
        if isinstance(statement, (kind, ast.Raise)):
            return True
        if isinstance(statement, ast.If) and statement.orelse:
            if _always_leaves(statement.body, kind) and _always_leaves(statement.orelse, kind):
                return True
        if isinstance(statement, ast.Try) and not statement.finalbody:
            blocks = [[*statement.body, *statement.orelse], *(h.body for h in statement.handlers)]
            if all(_always_leaves(block, kind) for block in blocks):
                return True
    return False


def _leaves_loop(body: Sequence[ast.stmt]) -> bool:
    return any(_leaves(statement, ast.Break) for statement in body)


def _own_breaks(body: Sequence[ast.stmt]) -> bool:
    return _leaves_loop(body)


def _only_loop(body: Sequence[ast.stmt], collecting: Collecting | None) -> ast.For | None:
    """The loop that is all of a loop's body."""
    if len(body) == 1 and isinstance(body[0], ast.For) and not body[0].orelse and not _leaves_loop(body[0].body):
        return body[0]
    return None


def _has_inner_star(target: ast.expr) -> bool:
    """Whether a pattern has a star elsewhere than at its end."""
    if isinstance(target, (ast.Tuple, ast.List)):
        return any(isinstance(e, ast.Starred) for e in target.elts[:-1]) or any(_has_inner_star(e) for e in target.elts)
    return False


def _is_main_guard(node: ast.If) -> bool:
    """``if __name__ == "__main__":``."""
    return any(isinstance(n, ast.Name) and n.id == "__name__" for n in ast.walk(node.test))


def _text_of(node: ast.stmt) -> str | None:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
        return node.value.value
    return None


def _without_docstring(body: Sequence[ast.stmt]) -> Sequence[ast.stmt]:
    return body[1:] if body and _text_of(body[0]) is not None else body


def _comment_lines(text: str) -> list[str]:
    """The lines of a docstring, without its indentation."""
    lines = [line.rstrip() for line in text.strip().splitlines()]
    indents = [len(line) - len(line.lstrip()) for line in lines[1:] if line.strip()]
    cut = min(indents, default=0)
    return [line if position == 0 else line[cut:] for position, line in enumerate(lines)]


def docstring_lines(function: Function) -> list[str]:
    """The docstring of a function as lines of comment."""
    body = function.body
    text = _text_of(body[0]) if body else None
    return _comment_lines(text) if text and text.strip() else []
