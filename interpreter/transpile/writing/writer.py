"""What all parts of the translation share: the analysed program, diagnostics, comments, small judgements."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.transpile.analysis.collect import Collections
from scenelang.interpreter.transpile.analysis.domain import NUMBERS, SEQUENCES, Type
from scenelang.interpreter.transpile.analysis.effects import Effect, Effects
from scenelang.interpreter.transpile.analysis.inference import Facts
from scenelang.interpreter.transpile.analysis.liveness import Liveness
from scenelang.interpreter.transpile.analysis.paths import Paths
from scenelang.interpreter.transpile.analysis.scopes import Function, Names, Variable
from scenelang.interpreter.transpile.python_text import Comment, PythonText
from scenelang.interpreter.transpile.writing.code import Code


@dataclass(eq=False)
class Analysed:
    """A Python program and all that was found out about it before a word of it is written. ``spread``:
    names of parameters that tables give by ``**``."""

    text: PythonText
    names: Names
    paths: Paths
    liveness: Liveness
    collections: Collections
    facts: Facts
    words: dict[str, Function]
    root: Function | None
    spread: set[str]
    parents: dict[ast.AST, ast.AST] = field(default_factory=dict)


class Writer:
    """Holds the analysed program; the subclasses write expressions, statements and the file."""

    def __init__(self, analysed: Analysed) -> None:
        self.analysed = analysed
        self.text = analysed.text
        self.names = analysed.names
        self.paths = analysed.paths
        self.facts = analysed.facts
        self.liveness = analysed.liveness
        self.effects = Effects(analysed.names, analysed.facts)
        self.diagnostics: list[Diagnostic] = []
        self.imports: set[str] = set()
        self.united: set[Variable] = set()
        self.defaults: dict[ast.expr, Variable] = {}
        self._reads: dict[Variable, list[ast.Name]] = {}
        self._comments = analysed.text.comments
        self._next_comment = 0
        self._statement_lines = (0, 0)

    # --- places and mistakes -----------------------------------------------------------------------------------

    def span(self, node: ast.AST) -> Span:
        return self.text.span(node)

    def error(self, name: str, message: str, node: ast.AST, hint: str | None = None) -> SceneError:
        return SceneError(name, message, hint, self.span(node))

    def unsupported(self, what: str, node: ast.AST, hint: str | None = None) -> SceneError:
        return self.error("python-unsupported", f"{what} cannot be translated", node, hint)

    def warn(self, name: str, message: str, node: ast.AST, hint: str | None = None) -> None:
        self.diagnostics.append(Diagnostic(name, message, self.span(node), hint))

    # --- judgements --------------------------------------------------------------------------------------------

    def type(self, node: ast.AST) -> Type:
        return self.facts.type(node)

    def effect(self, *nodes: ast.AST | None) -> Effect:
        return self.effects.of(*nodes)

    def is_mutated(self, node: ast.AST) -> bool:
        """Whether the container that ``node`` makes is changed somewhere."""
        return any(site.is_mutated and _same_place(site.node, node) for site in self.type(node).sites)

    def may_change(self, node: ast.AST) -> bool:
        """Whether the value of ``node`` may be a container or array that is changed somewhere."""
        return any(site.is_mutated for site in self.type(node).sites)

    def variable(self, node: ast.AST) -> Variable | None:
        return self.names.variables.get(node)

    def is_simple(self, node: ast.expr) -> bool:
        """Whether evaluating ``node`` twice costs nothing and does nothing."""
        return isinstance(node, (ast.Name, ast.Constant))

    def reads_of(self, variable: Variable) -> list[ast.Name]:
        """The nodes that read ``variable``."""
        if not self._reads:
            for node, found in self.names.variables.items():
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                    self._reads.setdefault(found, []).append(node)
        return self._reads.get(variable, [])

    def parent(self, node: ast.AST) -> ast.AST | None:
        if not self.analysed.parents:
            for outer in ast.walk(self.text.tree):
                for child in ast.iter_child_nodes(outer):
                    self.analysed.parents[child] = outer
        return self.analysed.parents.get(node)

    def single_function(self, node: ast.expr) -> Function | None:
        """The one function that a name means, when it is the name of a definition."""
        variable = self.variable(node)
        if variable is None or not variable.functions:
            return None
        if len(variable.functions) == len(variable.stores) or not variable.is_cell:
            return variable.functions[-1] if len(variable.functions) == len(variable.stores) else None
        return None

    def is_numeric(self, node: ast.expr) -> bool:
        found = self.type(node)
        return not found.kinds or found.only(NUMBERS)

    def is_vector_literal(self, node: ast.expr) -> bool:
        """A tuple or list display of numbers."""
        return (
            isinstance(node, (ast.Tuple, ast.List))
            and bool(node.elts)
            and all(not isinstance(e, ast.Starred) and self.is_numeric(e) for e in node.elts)
        )

    def known_length(self, node: ast.expr) -> int | None:
        """The length of a sequence, where inference knows it."""
        found = self.type(node)
        lengths = {len(site.items) if site.items is not None else None for site in found.sites}
        return lengths.pop() if len(lengths) == 1 and not found.kinds & ~SEQUENCES else None

    # --- comments ----------------------------------------------------------------------------------------------

    def begin_statement(self, first: int, last: int) -> tuple[int, int]:
        """Enter a statement of these lines; gives what ``end_statement`` wants back."""
        saved = self._statement_lines
        self._statement_lines = (first, last)
        return saved

    def end_statement(self, saved: tuple[int, int]) -> None:
        self._statement_lines = saved

    def comment_item(self, code: Code, node: ast.AST) -> Code:
        """Hang the comments that stand at an item of a display or call on several lines on its code."""
        container = self.parent(node)
        opened = getattr(container, "lineno", 0)
        closed = getattr(container, "end_lineno", 0)
        line, end = getattr(node, "lineno", 0), getattr(node, "end_lineno", 0)
        if container is None or opened == closed or line == opened or not self._has_comments:
            return code
        is_last = end < closed and not any(
            getattr(other, "lineno", 0) == end and getattr(other, "col_offset", 0) > getattr(node, "col_offset", 0)
            for other in ast.iter_child_nodes(container)
            if other is not node
        )
        self._hang(code, self._unused(opened + 1, line - 1), self._trailing(end) if is_last else None)
        return code

    def comment_pair(self, key: Code, value: Code, node: ast.AST) -> list[Code]:
        """``:key value`` with the comments at it: those above stand above the key."""
        self.comment_item(value, node)
        key.before, value.before = (*value.before, *key.before), ()
        return [key, value]

    @property
    def _has_comments(self) -> bool:
        return self._next_comment < len(self._comments)

    def open_comments(self, note: Code, line: int) -> None:
        """Take the comments above a statement that begins at ``line``."""
        above = self._unused(0, line - 1)
        top = min([line, *(c.line for c in above if c.alone)])
        self._hang(note, above, None)
        note.blank = note.blank or self.text.blank_before(top)

    def close_comments(self, note: Code, first: int, last: int) -> None:
        """Take the comment at the end of a statement, and those inside it that nobody took."""
        trailing = self._trailing(last)
        inner = [comment for comment in self._unused(first, last) if comment is not trailing]
        self._hang(note, inner, trailing)

    def comments_until(self, line: int) -> list[str]:
        """The comments up to and including a line that nobody took."""
        return [self._take(c) for c in self._unused(0, line)]

    def _hang(self, code: Code, before: Sequence[Comment], after: Comment | None) -> None:
        code.before = (*code.before, *(self._take(c) for c in before))
        if after is not None:
            text = self._take(after)
            code.after = f"{code.after}; {text}" if code.after else text

    def _take(self, comment: Comment) -> str:
        comment.used = True
        return comment.text

    def _unused(self, first: int, last: int) -> list[Comment]:
        found = []
        comments = self._comments
        while self._next_comment < len(comments) and comments[self._next_comment].used:
            self._next_comment += 1
        for comment in comments[self._next_comment :]:
            if comment.line > last:
                break
            if comment.line >= first and not comment.used:
                found.append(comment)
        return found

    def _trailing(self, line: int) -> Comment | None:
        for comment in self._unused(line, line):
            if not comment.alone:
                return comment
        return None


def _same_place(a: ast.AST, b: ast.AST) -> bool:
    """Whether two nodes are one, or one was made in the place of the other."""
    return a is b or (
        isinstance(a, ast.Call) and isinstance(b, ast.Call)
        and (a.lineno, a.col_offset, a.end_lineno) == (b.lineno, b.col_offset, b.end_lineno)
        and a.end_col_offset == b.end_col_offset
    )  # fmt: skip


def any_effect(effects: Iterable[Effect]) -> Effect:
    total = Effect()
    for effect in effects:
        total = total | effect
    return total
