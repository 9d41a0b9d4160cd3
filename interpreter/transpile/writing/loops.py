"""`for` and `while`: clauses, guards, early exits."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.effects import PURE, Effect
from scenelang.interpreter.transpile.analysis.scopes import Variable
from scenelang.interpreter.transpile.writing.blocks import Block, Collecting, assemble
from scenelang.interpreter.transpile.writing.branches import BranchWriter
from scenelang.interpreter.transpile.writing.code import (
    Code,
    Form,
    Key,
    Name,
    Ref,
    form,
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.control import (
    Jump,
    Mode,
    breaks_out,
    has_inner_star,
    leaves,
    only_loop,
)


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
        return Form([head, Form(clauses), *(body or [none()])], self.span(node))

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
        target = Ref(self.names.variables[node.target], self.span(node.target))
        if isinstance(source, ast.GeneratorExp) and len(source.generators) == 1:
            clauses = self.loop_head("", source.generators)[1]
            assert isinstance(clauses, Form)
            prefix.append(form("define", target, self.expr(source.elt)))
            return clauses.items
        if isinstance(source, ast.Call) and self.paths.of(source.func) == "map" and len(source.args) == 2:
            item = Variable("item", None, is_temporary=True)
            prefix.append(form("define", target, Form([self.expr(source.args[0]), Ref(item)])))
            return [Form([Ref(item), self.iterable(source.args[1])])]
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
            jump.value = (lambda: form("union")) if collecting.unites else (lambda: quote(Form([])))
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
