"""What all parts of the translation share: the analysed program, diagnostics, comments, small judgements."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.transpile.analysis.collect import Collections, Effect, Effects
from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    LIST,
    NUMBERS,
    SEQUENCES,
    SHAPE,
    AbstractType,
    TypeFacts,
)
from scenelang.interpreter.transpile.analysis.liveness import Liveness
from scenelang.interpreter.transpile.analysis.scopes import (
    Function,
    LibraryPaths,
    PythonNames,
    PythonVariable,
    inner_blocks,
)
from scenelang.interpreter.transpile.python_text import PythonComment, PythonText
from scenelang.interpreter.transpile.writing.blocks import Block, Collecting
from scenelang.interpreter.transpile.writing.code import Code


@dataclass(eq=False)
class Analysed:
    """A Python program and all that was found out about it before a word of it is written. ``spread``:
    names of parameters that tables give by ``**``."""

    text: PythonText
    names: PythonNames
    paths: LibraryPaths
    liveness: Liveness
    collections: Collections
    facts: TypeFacts
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
        self.united: set[PythonVariable] = set()
        self.defaults: dict[ast.expr, PythonVariable] = {}
        self._reads: dict[PythonVariable, list[ast.Name]] = {}
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

    def type(self, node: ast.AST) -> AbstractType:
        return self.facts.type(node)

    def effect(self, *nodes: ast.AST | None) -> Effect:
        return self.effects.of(*nodes)

    def is_mutated(self, node: ast.AST) -> bool:
        """Whether the container that ``node`` makes is changed somewhere."""
        return any(site.is_mutated and _same_place(site.node, node) for site in self.type(node).sites)

    def may_change(self, node: ast.AST) -> bool:
        """Whether the value of ``node`` may be a container or array that is changed somewhere."""
        return any(site.is_mutated for site in self.type(node).sites)

    def variable(self, node: ast.AST) -> PythonVariable | None:
        return self.names.variables.get(node)

    def is_simple(self, node: ast.expr) -> bool:
        """Whether evaluating ``node`` twice costs nothing and does nothing."""
        return isinstance(node, (ast.Name, ast.Constant))

    def reads_of(self, variable: PythonVariable) -> list[ast.Name]:
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

    def _hang(self, code: Code, before: Sequence[PythonComment], after: PythonComment | None) -> None:
        code.before = (*code.before, *(self._take(c) for c in before))
        if after is not None:
            text = self._take(after)
            code.after = f"{code.after}; {text}" if code.after else text

    def _take(self, comment: PythonComment) -> str:
        comment.used = True
        return comment.text

    def _unused(self, first: int, last: int) -> list[PythonComment]:
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

    def _trailing(self, line: int) -> PythonComment | None:
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


# Where control goes: what leaves a body or a loop early, and the places that it can leave.


Finish = Callable[[Block], Code | None]


@dataclass(eq=False)
class Jump:
    """A place that `return`, `break` or `continue` may have to leave early; used when a plain branch cannot say it.
    ``value`` is what a turn of a collecting loop has collected by then."""

    name: str
    variable: PythonVariable | None = None
    value: Callable[[], Code] | None = None

    def escape(self) -> PythonVariable:
        if self.variable is None:
            self.variable = PythonVariable(self.name, None, is_temporary=True)
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
class ExitTarget:
    """The function being written, and the loops around the statement."""

    function: Function
    returns: Jump = field(default_factory=lambda: Jump("return"))
    breaks: list[Jump] = field(default_factory=list)
    continues: list[Jump] = field(default_factory=list)
    yields: PythonVariable | None = None


def leaves(statement: ast.stmt, kind: type[ast.stmt]) -> bool:
    """Whether ``statement`` holds a ``return``, ``continue`` or ``break`` that leaves what it stands in."""
    if isinstance(statement, kind):
        return True
    if isinstance(statement, (ast.For, ast.While)) and kind is not ast.Return:
        return any(leaves(s, kind) for s in statement.orelse)
    return any(leaves(s, kind) for block in inner_blocks(statement) for s in block)


def always_leaves(body: Sequence[ast.stmt], kind: type[ast.stmt]) -> bool:
    """Whether the end of ``body`` is never reached."""
    for statement in body:
        if isinstance(statement, (kind, ast.Raise)):
            return True
        if isinstance(statement, ast.If) and statement.orelse:
            if always_leaves(statement.body, kind) and always_leaves(statement.orelse, kind):
                return True
        if isinstance(statement, ast.Try) and not statement.finalbody:
            blocks = [[*statement.body, *statement.orelse], *(h.body for h in statement.handlers)]
            if all(always_leaves(block, kind) for block in blocks):
                return True
    return False


def is_skip(statement: ast.stmt) -> bool:
    """``if c: continue``."""
    is_guard = isinstance(statement, ast.If) and not statement.orelse and len(statement.body) == 1
    return isinstance(statement, ast.If) and is_guard and isinstance(statement.body[0], ast.Continue)


def breaks_out(body: Sequence[ast.stmt]) -> bool:
    return any(leaves(statement, ast.Break) for statement in body)


def only_loop(body: Sequence[ast.stmt], collecting: Collecting | None) -> ast.For | None:
    """The loop that is all of a loop's body."""
    if len(body) == 1 and isinstance(body[0], ast.For) and not body[0].orelse and not breaks_out(body[0].body):
        return body[0]
    return None


def has_inner_star(target: ast.expr) -> bool:
    """Whether a pattern has a star elsewhere than at its end."""
    if isinstance(target, (ast.Tuple, ast.List)):
        return any(isinstance(e, ast.Starred) for e in target.elts[:-1]) or any(has_inner_star(e) for e in target.elts)
    return False


def is_main_guard(node: ast.If) -> bool:
    """``if __name__ == "__main__":``."""
    return any(isinstance(n, ast.Name) and n.id == "__name__" for n in ast.walk(node.test))


def text_of(node: ast.stmt) -> str | None:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
        return node.value.value
    return None


def without_docstring(body: Sequence[ast.stmt]) -> Sequence[ast.stmt]:
    return body[1:] if body and text_of(body[0]) is not None else body


def comment_lines(text: str) -> list[str]:
    """The lines of a docstring, without its indentation."""
    lines = [line.rstrip() for line in text.strip().splitlines()]
    indents = [len(line) - len(line.lstrip()) for line in lines[1:] if line.strip()]
    cut = min(indents, default=0)
    return [line if position == 0 else line[cut:] for position, line in enumerate(lines)]


def docstring_lines(function: Function) -> list[str]:
    """The docstring of a function as lines of comment."""
    body = function.body
    text = text_of(body[0]) if body else None
    return comment_lines(text) if text and text.strip() else []


# Where values go: whether a list of shapes is only united, whether a sequence of numbers only serves as a vector.


class Flows(Writer):
    """Judges by the uses of a value how it is best written."""

    # --- shapes ---

    def is_parts(self, node: ast.expr) -> bool:
        """Whether a list of shapes is only ever united, so that parts do as well."""
        sites = self.type(node).sites
        if not sites or any(not s.element.only(SHAPE) and not _is_empty_list(s.element) for s in sites):
            return False
        if not any(s.element.kinds & SHAPE for s in sites):
            return False
        parent = self.parent(node)
        if isinstance(parent, ast.Starred):
            return self._unites(parent)
        if isinstance(parent, ast.Call):
            return self._unites_argument(parent, node)
        if isinstance(parent, (ast.Assign, ast.AnnAssign)):
            target = parent.targets[0] if isinstance(parent, ast.Assign) else parent.target
            variable = self.variable(target)
            return variable is not None and self.is_united(variable)
        if isinstance(parent, ast.Return):
            return self._returns_shape(parent)
        return False

    def is_united(self, variable: PythonVariable) -> bool:
        """Whether all that happens to the list in ``variable`` is that its shapes are united."""
        reads = self.reads_of(variable)
        return bool(reads) and all(self._read_unites(read) for read in reads)

    def _read_unites(self, read: ast.Name) -> bool:
        parent = self.parent(read)
        if isinstance(parent, ast.Starred):
            return self._unites(parent)
        if isinstance(parent, ast.Call):
            return self._unites_argument(parent, read)
        if isinstance(parent, ast.Attribute):  # the additions of a collection
            grand = self.parent(parent)
            return grand in self.analysed.collections.additions
        if isinstance(parent, ast.Return):
            return self._returns_shape(parent)
        return False

    def _returns_shape(self, node: ast.Return) -> bool:
        outer: ast.AST | None = node
        while outer is not None and not isinstance(outer, (ast.FunctionDef, ast.Module)):
            outer = self.parent(outer)
        function = self.names.functions.get(outer) if outer is not None else None
        if function is None or function.is_animation:  # the items that an animation returns are frames
            return False
        return function.is_registered and not function.is_called_directly

    def _unites(self, starred: ast.Starred) -> bool:
        call = self.parent(starred)
        return isinstance(call, ast.Call) and self.paths.of(call.func) == "concat_shapes"

    def _unites_argument(self, call: ast.Call, node: ast.expr) -> bool:
        path = self.paths.of(call.func)
        return path == "concat_shapes" or (path == "transform_shape" and bool(call.args) and call.args[0] is node)

    # --- vectors ---

    def wants_vector(self, node: ast.expr) -> bool:
        """Whether a display flows only to places that want a vector."""
        return self._flows_to_vector(node, set())

    def _flows_to_vector(self, node: ast.AST, seen: set[object]) -> bool:
        parent = self.parent(node)
        if isinstance(parent, ast.IfExp) and node is not parent.test:
            return self._flows_to_vector(parent, seen)
        if isinstance(parent, ast.Assign) and len(parent.targets) == 1 and isinstance(parent.targets[0], ast.Name):
            return self._variable_wants_vector(self.names.variables.get(parent.targets[0]), seen)
        if isinstance(parent, ast.AnnAssign):
            return self._variable_wants_vector(self.names.variables.get(parent.target), seen)
        if isinstance(parent, ast.arguments):
            function = self.names.functions.get(self.parent(parent) or parent)
            parameters = function.parameters if function is not None else []
            found = next((p for p in parameters if p.default is node), None)
            return found is not None and self._variable_wants_vector(found.variable, seen)
        if isinstance(parent, ast.keyword):
            call = self.parent(parent)
            if isinstance(call, ast.Call):
                if _is_vector_keyword(self.paths.of(call.func), parent.arg):
                    return True
                return self._parameter_wants_vector(call, parent.arg, None, seen)
            return False
        if isinstance(parent, ast.Dict):
            position = next((i for i, v in enumerate(parent.values) if v is node), None)
            key = parent.keys[position] if position is not None else None
            is_attribute = isinstance(key, ast.Constant) and key.value in ("p0", "p1", "scale")
            holder = self.parent(parent)
            return is_attribute and isinstance(holder, (ast.keyword, ast.Call))
        if isinstance(parent, ast.Call):
            path = self.paths.of(parent.func)
            position = next((i for i, a in enumerate(parent.args) if a is node), None)
            if position is None:
                return False
            if path is not None:
                return _is_vector_argument(path, position)
            return self._parameter_wants_vector(parent, None, position, seen)
        if isinstance(parent, ast.BinOp):
            other = parent.right if parent.left is node else parent.left
            return self.type(other).only(ARRAY)
        if isinstance(parent, ast.Subscript) and parent.value is node:
            return isinstance(parent.ctx, ast.Load)
        return False

    def _parameter_wants_vector(
        self, call: ast.Call, name: str | None, position: int | None, seen: set[object]
    ) -> bool:
        targets = self.facts.targets.get(call, [])
        if not targets:
            return False
        for target in targets:
            if name is not None:
                parameter = target.parameter(name)
            else:
                plain = [p for p in target.parameters if p.kind == "plain"]
                parameter = plain[position] if position is not None and position < len(plain) else None
            if parameter is None or not self._variable_wants_vector(parameter.variable, seen):
                return False
        return True

    def _variable_wants_vector(self, variable: PythonVariable | None, seen: set[object]) -> bool:
        if variable is None or variable.is_assigned_elsewhere:
            return False
        if variable in seen:
            return True
        seen.add(variable)
        reads = self.reads_of(variable)
        return bool(reads) and all(self._flows_to_vector(read, seen) or self._is_unpacked(read) for read in reads)

    def _is_unpacked(self, read: ast.Name) -> bool:
        parent = self.parent(read)
        return isinstance(parent, ast.Assign) and isinstance(parent.targets[0], ast.Tuple) and parent.value is read


def _is_empty_list(found: AbstractType) -> bool:
    return found.only(SHAPE | LIST) and all(not site.element.kinds & ~SHAPE for site in found.sites)


_VECTOR_KEYWORDS = {
    "primitive_call": ("color", "scale"),
    "translation_matrix": ("offset",),
    "rotation_matrix": ("direction", "point"),
    "scale_matrix": ("scale", "origin"),
    "reflection_matrix": ("point", "normal"),
}
_VECTOR_ARGUMENTS = {
    "primitive_call": (2,),
    "translation_matrix": (0,),
    "rotation_matrix": (1, 2),
    "scale_matrix": (0, 1),
    "reflection_matrix": (0, 1),
    "numpy.array": (0,),
    "numpy.asarray": (0,),
    "numpy.linalg.norm": (0,),
    "numpy.dot": (0, 1),
    "numpy.cross": (0, 1),
}


def _is_vector_keyword(path: str | None, name: str | None) -> bool:
    return path is not None and name in _VECTOR_KEYWORDS.get(path, ())


def _is_vector_argument(path: str, position: int) -> bool:
    return position in _VECTOR_ARGUMENTS.get(path, ())
