"""Python statements -> bodies. Straight-line code becomes definitions, branches become values; only what outlives a
turn of a loop or is seen by a closure is assigned in place."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.transpile.analysis.collect import PURE, Effect
from scenelang.interpreter.transpile.analysis.inference import DICT
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, PythonVariable
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, Collecting, assemble
from scenelang.interpreter.transpile.writing.branches import BranchWriter
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    lambda_list,
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.writer import (
    Jump,
    Mode,
    breaks_out,
    comment_lines,
    docstring_lines,
    has_inner_star,
    leaves,
    only_loop,
    text_of,
)

# `for` and `while`: clauses, guards, early exits.


class LoopWriter(BranchWriter):
    """Writes loops."""

    def _For_statement(self, node: ast.For, block: Block, note: Code) -> None:
        code = self._for(node, "", Mode(ast.Continue, lambda b: None), None)
        self._add_loop(node, code, block, note)

    def _add_loop(self, node: ast.For | ast.While, code: Code, block: Block, note: Code) -> None:
        jump = self._last_break
        effect = self.effect(node)
        if jump.variable is not None or (node.orelse and breaks_out(node.body)):
            orelse = self._effect_body(node.orelse) if node.orelse else []
            code = form("let/ec", VariableRef(jump.escape()), code, *orelse, span=self.span(node))
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
            nested_inner = only_loop(inner.body, collecting)
            nested = nested or nested_inner is not None
            clauses += self._for_clauses(inner, parallel=not nested, prefix=prefix)
            statements = list(inner.body)
            if prefix:
                break
            statements = self._guards(statements, clauses, breaks=depth == 0 and not collecting and not node.orelse)
            following = only_loop(statements, collecting)
            if following is None or breaks_out(following.body) or (depth and jump.variable):
                break
            if following in self.places.before:
                break  # variables are defined between the two
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
        return FormCode([head, FormCode(clauses), *(body or [none()])], self.span(node))

    def _for_clauses(self, node: ast.For, parallel: bool, prefix: list[Code]) -> list[Code]:
        """The clauses of one ``for``; targets that are assigned in place are set first thing in the body."""
        target = node.target
        if self._interleaves(node):
            lazily = self._lazy_clauses(node, prefix)
            if lazily is not None:
                return lazily
        names = [n for n in ast.walk(target) if isinstance(n, ast.Name)]
        if isinstance(target, (ast.Name, ast.Tuple, ast.List)) and not any(
            self.names.variables[n].is_cell for n in names if n in self.names.variables
        ):
            if not isinstance(target, ast.Name) and any(
                not isinstance(n, (ast.Name, ast.Tuple, ast.List, ast.Starred, ast.Store)) for n in ast.walk(target)
            ):
                raise self.unsupported("this target of a loop", target)
            if has_inner_star(target):
                variable = PythonVariable("item", None, is_temporary=True)
                block = Block()
                assert isinstance(target, (ast.Tuple, ast.List))
                self._unpack_code(node, target, VariableRef(variable), PURE, block, Code(None))
                prefix += list(assemble(block.items, None))
                return [FormCode([VariableRef(variable), self.iterable(node.iter)])]
            return self.clauses(target, node.iter, parallel)
        variable = PythonVariable(target.id if isinstance(target, ast.Name) else "item", None, is_temporary=True)
        block = Block()
        self.store(node, target, VariableRef(variable), PURE, block, Code(None))
        prefix += [
            item.value if item.kind == "effect" else form("define-values", item.target or none(), item.value)
            for item in block.items
        ]
        return [FormCode([VariableRef(variable), self.iterable(node.iter)])]

    def _interleaves(self, node: ast.For) -> bool:
        """Whether what the loop runs through and its body both draw random numbers, turn by turn."""
        return self.effect(node.iter).draws and self.effect(*node.body).draws

    def _lazy_clauses(self, node: ast.For, prefix: list[Code]) -> list[Code] | None:
        """A generator expression or ``map`` whose items are worked out turn by turn, as in Python; a generator function
        of the program draws first here, which is said."""
        source = node.iter
        if isinstance(source, ast.Call) and any(t.is_generator for t in self.facts.targets.get(source, ())):
            message = "this generator and the loop both draw random numbers; here the generator draws all of its first"
            self.warn("draw-order", message, source)
        if not isinstance(node.target, ast.Name) or self.names.variables[node.target].is_cell:
            return None
        target = VariableRef(self.names.variables[node.target], self.span(node.target))
        if isinstance(source, ast.GeneratorExp) and len(source.generators) == 1:
            clauses = self.loop_head("", source.generators)[1]
            assert isinstance(clauses, FormCode)
            prefix.append(form("define", target, self.expr(source.elt)))
            return clauses.items
        if isinstance(source, ast.Call) and self.paths.of(source.func) == "map" and len(source.args) == 2:
            item = PythonVariable("item", None, is_temporary=True)
            prefix.append(form("define", target, FormCode([self.expr(source.args[0]), VariableRef(item)])))
            return [FormCode([VariableRef(item), self.iterable(source.args[1])])]
        return None

    def _guards(self, statements: list[ast.stmt], clauses: list[Code], breaks: bool) -> list[ast.stmt]:
        """Leading ``if c: continue`` and ``if c: break``, and an ``if`` around all, become clauses."""
        while statements and isinstance(statements[0], ast.If) and statements[0] not in self.places.before:
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
                self.close_comments(note, first.lineno, first.end_lineno or first.lineno)
                clauses += [Key("break"), test]
                clauses[-2].before, test.after = note.before, note.after
                statements = statements[1:]
                break
            elif not first.orelse and len(statements) == 1 and not leaves(first, ast.Break):
                self._guard(first, clauses, holds=True)
                statements = first.body
            else:
                break
        return statements

    def _guard(self, node: ast.If, clauses: list[Code], holds: bool) -> None:
        note = Code(None)
        self._open_note(note, node)
        key, test = self.condition_clause(node.test, holds)
        if not holds:  # the `continue` goes, with its comment
            self.close_comments(note, node.lineno, node.end_lineno or node.lineno)
        key.before, test.after = note.before, note.after
        clauses += [key, test]

    def _loop_body(
        self, statements: Sequence[ast.stmt], mode: Mode, collecting: Collecting | None, prefix: list[Code]
    ) -> list[Code]:
        jump = Jump("continue")
        self.place.continues.append(jump)
        block = Block()
        if collecting is not None:
            block.collecting.append(Collecting(collecting.collection, collecting.unites, False))
            jump.value = (lambda: form("union")) if collecting.unites else (lambda: quote(FormCode([])))
        body = self.body(statements, mode, block)
        self.place.continues.pop()
        if jump.variable is not None:
            body = [form("let/ec", VariableRef(jump.variable), *body)]
        return [*prefix, *body]

    def _While_statement(self, node: ast.While, block: Block, note: Code) -> None:
        jump = Jump("break")
        self.place.breaks.append(jump)
        test = self.test(node.test)
        body = self._loop_body(node.body, Mode(ast.Continue, lambda b: None), None, [])
        self.place.breaks.pop()
        self._last_break = jump
        code = FormCode([Name("while"), test, *(body or [none()])], self.span(node))
        self._add_loop(node, code, block, note)


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
            frames = VariableRef(self.place.yields)
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
        assert isinstance(code, FormCode)
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
        message: Code = LiteralCode("error")
        if isinstance(node.exc, ast.Call) and node.exc.args:
            message = self.expr(node.exc.args[0])
        elif isinstance(node.exc, ast.Name):
            message = LiteralCode(node.exc.id)
        block.add_effect(form("error", message, span=self.span(node)), Effect(changes=True), note, leaves=True)

    def _Return_statement(self, node: ast.Return, block: Block, note: Code) -> None:
        if self.place.function is self.names.module:
            raise self.error("python-syntax", "`return` outside a function", node)
        jump = self.place.returns.escape()
        code = self._returned(node, block)
        is_nothing = type(code) is LiteralCode and code.value is None
        block.add_effect(
            FormCode([VariableRef(jump), *([] if is_nothing else [code])], self.span(node)),
            Effect(changes=True),
            note,
            leaves=True,
        )

    def _Break_statement(self, node: ast.Break, block: Block, note: Code) -> None:
        if not self.place.breaks:
            raise self.error("python-syntax", "`break` outside a loop", node)
        block.add_effect(
            FormCode([VariableRef(self.place.breaks[-1].escape())], self.span(node)),
            Effect(changes=True),
            note,
            leaves=True,
        )

    def _Continue_statement(self, node: ast.Continue, block: Block, note: Code) -> None:
        if not self.place.continues:
            raise self.error("python-syntax", "`continue` outside a loop", node)
        jump = self.place.continues[-1]
        items = [VariableRef(jump.escape()), *([jump.value()] if jump.value is not None else [])]
        block.add_effect(FormCode(items, self.span(node)), Effect(changes=True), note, leaves=True)

    def _Delete_statement(self, node: ast.Delete, block: Block, note: Code) -> None:
        for target in node.targets:
            if isinstance(target, ast.Name):
                continue
            if not isinstance(target, ast.Subscript):
                raise self.unsupported("this `del`", node)
            if isinstance(target.slice, ast.Slice):
                code = self.set_item(target, quote(FormCode([])))
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
            code = FormCode([Name("set!"), VariableRef(function.variable), self.as_lambda(function)], self.span(node))
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
        block.add(BlockItem("function", code, PURE, (function.variable,), None, note))
        if function.is_registered:  # from now on its word means this one
            bind = form("bind", LiteralCode(function.word), VariableRef(function.variable), span=self.span(node))
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

    def define_function(self, function: Function, variable: PythonVariable) -> FormCode:
        """``(define (name parameter ...) body ...)``."""
        signature = self.parameters(function)
        header = FormCode(
            [VariableRef(variable, self.span(function.node)), *signature.items], signature.span, signature.rest
        )
        return FormCode([Name("define"), header, *self.function_body(function)], self.span(function.node))

    def as_lambda(self, function: Function) -> FormCode:
        """``(lambda (parameter ...) body ...)``."""
        return FormCode(
            [Name("lambda"), lambda_list(self.parameters(function)), *self.function_body(function)],
            self.span(function.node),
        )

    def hoist_defaults(self, function: Function, block: Block) -> None:
        """Python evaluates defaults once, at the definition: those that could differ later become variables."""
        for parameter in function.parameters:
            node = parameter.default
            if node is None or self.may_stay(node):
                continue
            variable = PythonVariable(f"{function.name}_{parameter.variable.name}", None, is_temporary=True)
            block.define(variable, self.expr(node), self.effect(node), Code(None), nests=False)
            self.defaults[node] = variable

    def _ClassDef_statement(self, node: ast.ClassDef, block: Block, note: Code) -> None:
        from scenelang.interpreter.transpile.writing.user_calls import class_items

        record: Class = self.names.classes[node]
        text = text_of(node.body[0]) if node.body else None
        note.before = (*note.before, *(comment_lines(text) if text else ()))
        for position, item in enumerate(class_items(self, record)):
            if position == 0:
                item.note = note
            block.add(item)
