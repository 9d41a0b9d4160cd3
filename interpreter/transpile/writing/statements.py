"""Python statements -> bodies. Straight-line code becomes definitions, branches become values; only what outlives a
turn of a loop or is seen by a closure is assigned in place."""

from __future__ import annotations

import ast

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.transpile.analysis.domain import DICT
from scenelang.interpreter.transpile.analysis.effects import PURE, Effect
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, Variable
from scenelang.interpreter.transpile.writing.blocks import Block, Item
from scenelang.interpreter.transpile.writing.code import (
    Code,
    Form,
    Literal,
    Name,
    Ref,
    form,
    lambda_list,
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.control import (
    comment_lines,
    docstring_lines,
    text_of,
)
from scenelang.interpreter.transpile.writing.loops import LoopWriter


class StatementWriter(LoopWriter):
    """Writes statements: each kind has its method, found by the name of its node."""

    def statement(self, node: ast.stmt, block: Block) -> None:
        """Add a statement to a block. A mistake is noted, so that others show as well."""
        saved = self.begin_statement(node.lineno, node.end_lineno or node.lineno)
        note = Code(None)
        try:
            if text_of(node) is not None:
                self.pending_texts += comment_lines(text_of(node) or "")
                return
            if isinstance(node, (ast.Pass, ast.Global, ast.Nonlocal, ast.Import, ast.ImportFrom)):
                self._check_import(node)
                return
            self._open_note(note, node)
            self._define_cells(node, block)
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
            if self.place.yields is None:
                raise self.error("python-syntax", "`yield` outside a function", node)
            frames = Ref(self.place.yields)
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
        block.add_effect(form("error", message, span=self.span(node)), Effect(changes=True), note, leaves=True)

    def _Return_statement(self, node: ast.Return, block: Block, note: Code) -> None:
        if self.place.function is self.names.module:
            raise self.error("python-syntax", "`return` outside a function", node)
        jump = self.place.returns.escape()
        code = self._returned(node, block)
        is_nothing = type(code) is Literal and code.value is None
        block.add_effect(
            Form([Ref(jump), *([] if is_nothing else [code])], self.span(node)), Effect(changes=True), note, leaves=True
        )

    def _Break_statement(self, node: ast.Break, block: Block, note: Code) -> None:
        if not self.place.breaks:
            raise self.error("python-syntax", "`break` outside a loop", node)
        block.add_effect(
            Form([Ref(self.place.breaks[-1].escape())], self.span(node)), Effect(changes=True), note, leaves=True
        )

    def _Continue_statement(self, node: ast.Continue, block: Block, note: Code) -> None:
        if not self.place.continues:
            raise self.error("python-syntax", "`continue` outside a loop", node)
        jump = self.place.continues[-1]
        items = [Ref(jump.escape()), *([jump.value()] if jump.value is not None else [])]
        block.add_effect(Form(items, self.span(node)), Effect(changes=True), note, leaves=True)

    def _Delete_statement(self, node: ast.Delete, block: Block, note: Code) -> None:
        for target in node.targets:
            if isinstance(target, ast.Name):
                continue
            if not isinstance(target, ast.Subscript):
                raise self.unsupported("this `del`", node)
            if isinstance(target.slice, ast.Slice):
                code = self.set_item(target, quote(Form([])))
                block.add_effect(code, Effect(changes=True), note)
                continue
            head = "remove-key!" if self.type(target.value).only(DICT) else "remove-at!"
            block.add_effect(form(head, self.expr(target.value), self.expr(target.slice)), Effect(changes=True), note)

    def _With_statement(self, node: ast.With, block: Block, note: Code) -> None:
        for item in node.items:
            self.expr(item.context_expr)
        raise self.unsupported("`with`", node)

    # --- functions and classes ---

    def _FunctionDef_statement(self, node: ast.FunctionDef, block: Block, note: Code) -> None:
        function = self.names.functions[node]
        assert function.variable is not None
        for decorator in node.decorator_list:
            self.check_decorator(decorator)
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
        if function.is_registered:  # from now on its word means this one
            bind = form("bind", Literal(function.word), Ref(function.variable), span=self.span(node))
            block.add_effect(bind, Effect(changes=True))

    def check_decorator(self, decorator: ast.expr) -> None:
        called = decorator.func if isinstance(decorator, ast.Call) else decorator
        path = self.paths.of(called) or ""
        if path in ("register", "register_animation"):
            arguments = (
                [*decorator.args, *(k.value for k in decorator.keywords)] if isinstance(decorator, ast.Call) else []
            )
            for argument in arguments:
                if not isinstance(argument, ast.Constant):
                    raise self.unsupported("a computed text in `register`", argument)
            return
        if path in ("functools.lru_cache", "functools.cache", "staticmethod", "property", "lru_cache", "cache"):
            return
        self.check_path(called, path) if path else None
        raise self.unsupported(f"the decorator `@{self.text.text(decorator)}`", decorator)

    def define_function(self, function: Function, variable: Variable) -> Form:
        """``(define (name parameter ...) body ...)``."""
        signature = self.parameters(function)
        header = Form([Ref(variable, self.span(function.node)), *signature.items], signature.span, signature.rest)
        return Form([Name("define"), header, *self.function_body(function)], self.span(function.node))

    def as_lambda(self, function: Function) -> Form:
        """``(lambda (parameter ...) body ...)``."""
        return Form(
            [Name("lambda"), lambda_list(self.parameters(function)), *self.function_body(function)],
            self.span(function.node),
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
        from scenelang.interpreter.transpile.writing.classes import class_items

        record: Class = self.names.classes[node]
        text = text_of(node.body[0]) if node.body else None
        note.before = (*note.before, *(comment_lines(text) if text else ()))
        for position, item in enumerate(class_items(self, record)):
            if position == 0:
                item.note = note
            block.add(item)
