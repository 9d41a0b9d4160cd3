"""`if` and `try`, for what they do or for the variables that they set."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence

from scenelang.interpreter.transpile.analysis.collect import Effect
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    none,
)
from scenelang.interpreter.transpile.writing.collecting import CollectionWriter
from scenelang.interpreter.transpile.writing.operators import branch_value, branch_values, conditional
from scenelang.interpreter.transpile.writing.writer import Mode, is_main_guard, leaves

_ERRORS: dict[str, tuple[str, ...]] = {
    "ZeroDivisionError": ("zero-division",), "IndexError": ("index",), "KeyError": ("key",),
    "AssertionError": ("assert",),
    "LookupError": ("index", "key"), "ValueError": ("value", "domain", "type", "user"), "TypeError": ("type",),
}  # fmt: skip


class BranchWriter(CollectionWriter):
    """Writes branches."""

    def _If_statement(self, node: ast.If, block: Block, note: Code) -> None:
        if is_main_guard(node):
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
            assert isinstance(clause, FormCode)
            test = clause.items[0]
            if is_form(test, "not") and isinstance(test, FormCode):
                return FormCode([Name("unless"), test.items[1], *clause.items[1:]], self.span(node))
            return FormCode([Name("when"), *clause.items], self.span(node))
        return conditional(clauses)

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

    def _set_and_needed(self, node: ast.stmt) -> list[PythonVariable]:
        """The variables that a compound statement sets, not in place, and that are read after it."""
        after = self.liveness.after.get(node, frozenset())
        found: dict[PythonVariable, None] = {}
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
        self, node: ast.stmt, variables: list[PythonVariable], block: Block, note: Code, write: Callable[[Mode], Code]
    ) -> None:
        """``if c: x = a else: x = b`` is ``(define x (if c a b))``; several variables come as a list."""
        missing = {variable for variable in variables if not self.is_set_before(variable, node)}
        if len(variables) == 1:
            variable = variables[0]
            code = write(Mode(None, lambda b: branch_value(b, variable, variable in missing)))
            block.define(variable, code, self.effect(node), note)
            return
        code = write(Mode(None, lambda b: branch_values(b, variables, missing)))
        targets = FormCode([VariableRef(v) for v in variables])
        block.add(BlockItem("define", code, self.effect(node), tuple(variables), targets, note))

    def is_set_before(self, variable: PythonVariable, node: ast.AST) -> bool:
        """Whether a variable has a value where ``node`` begins, as far as the blocks around it tell."""
        if variable.is_parameter or variable.function is not self.place.function:
            return True
        current: ast.AST | None = node
        while current is not None and not isinstance(current, (ast.FunctionDef, ast.Module)):
            outer = self.parent(current)
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

    def _if_value(self, node: ast.If, mode: Mode) -> Code:
        clauses: list[Code] = []
        self._value_clauses(node, mode, clauses, Block)
        return conditional(clauses)

    def _Try_statement(self, node: ast.Try, block: Block, note: Code) -> None:
        leaving = any(
            leaves(s, kind) for h in node.handlers for s in h.body for kind in (ast.Return, ast.Continue, ast.Break)
        )
        if node.finalbody and leaving:
            raise self.unsupported("`finally` after a handler that leaves", node)
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
        error = PythonVariable("error", None, is_temporary=True)
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
            if (
                not kinds
                or None in kinds
                or (len(node.handlers) == 1 and len({k for ks in kinds for k in ks or ()}) > 1)
            ):
                test: Code = LiteralCode(True)
            else:
                tests = [
                    form("error-is?", VariableRef(error), LiteralCode(kind))
                    for kind in dict.fromkeys(k for ks in kinds for k in ks or ())
                ]
                test = tests[0] if len(tests) == 1 else form("or", *tests)
            clauses.append(FormCode([test, *(self.body(handler.body, mode) or [none()])]))
        body = self.body([*node.body, *node.orelse], mode)
        return form("guard", FormCode([VariableRef(error), *clauses]), *(body or [none()]), span=self.span(node))


def _stands_in(node: ast.AST, outer: ast.AST) -> bool:
    """Whether ``node`` stands in the text of ``outer``."""
    start = (getattr(outer, "lineno", 0), getattr(outer, "col_offset", 0))
    end = (getattr(outer, "end_lineno", 0), getattr(outer, "end_col_offset", 0))
    return start <= (getattr(node, "lineno", 0), getattr(node, "col_offset", 0)) < end
