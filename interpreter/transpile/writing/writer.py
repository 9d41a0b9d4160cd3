"""The writer, the context of code generation, with predicates on the analysed program, comments, and exits of
bodies."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.runtime.modelling_helpers import is_vector, scene_helpers
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
from scenelang.interpreter.transpile.analysis.liveness import CellDefinitions, Liveness
from scenelang.interpreter.transpile.analysis.python_text import PythonComment, PythonText, child_nodes, walk_tree
from scenelang.interpreter.transpile.analysis.scopes import (
    Class,
    Function,
    LibraryPaths,
    PythonNames,
    PythonVariable,
    inner_blocks,
)
from scenelang.interpreter.transpile.writing.blocks import Block, Collecting
from scenelang.interpreter.transpile.writing.code import Code


@dataclass(eq=False)
class Analysed:
    """Python program with the results of all analyses. ``spread`` are names of parameters passed with ``**``."""

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


# Control flow: early exits from bodies and loops.


Finish = Callable[[Block], Code | None]


@dataclass(eq=False)
class ExitPoint:
    """Point that `return`, `break` or `continue` exits to; an escape procedure is created if a plain branch cannot
    express it.

    ``value`` returns what an iteration of a collecting loop has collected so far.
    """

    name: str
    variable: PythonVariable | None = None
    value: Callable[[], Code] | None = None

    def escape(self) -> PythonVariable:
        if self.variable is None:
            self.variable = PythonVariable(self.name, None, is_temporary=True)
        return self.variable


@dataclass(eq=False)
class Mode:
    """How a body is generated.

    Attributes
    ----------
    exit_kind
        Statement that ends the body early in tail position: ``return`` of a function, ``continue`` of a loop.
    finish
        Returns the value of the body when its end is reached.
    is_tail
        Whether the body is in tail position.
    collection
        List that the body collects.
    """

    exit_kind: type[ast.stmt] | None
    finish: Finish
    is_tail: bool = True
    collection: Collecting | None = None


@dataclass(eq=False)
class Exits:
    """Exit points of the function being generated and of the loops around the current statement."""

    function: Function
    returns: ExitPoint = field(default_factory=lambda: ExitPoint("return"))
    breaks: list[ExitPoint] = field(default_factory=list)
    continues: list[ExitPoint] = field(default_factory=list)
    yields: PythonVariable | None = None


class Comments:
    """Comments of the Python code in order; each is attached once."""

    def __init__(self, text: PythonText) -> None:
        self._text = text
        self._comments = text.comments
        self._next = 0

    @property
    def has_unused(self) -> bool:
        return self._next < len(self._comments)

    def take_above(self, note: Code, line: int) -> None:
        """Attach the comments above a statement that starts at ``line``."""
        above = self._unused(0, line - 1)
        top = min([line, *(c.line for c in above if c.alone)])
        self._attach(note, above, None)
        note.blank = note.blank or self._text.blank_before(top)

    def take_head(self, note: Code, first: int, last: int) -> None:
        """Attach the comments in the head of a compound statement, except those directly above its body."""
        for comment in self._unused(first, last):
            if not comment.alone or comment.line < last:
                note.before = (*note.before, _take(comment))

    def take_trailing(self, note: Code, first: int, last: int) -> None:
        """Attach the comment at the end of a statement, and unused comments inside it."""
        trailing = self._trailing(last)
        inner = [comment for comment in self._unused(first, last) if comment is not trailing]
        self._attach(note, inner, trailing)

    def take_inside(self, code: Code, opened: int, line: int, end: int | None) -> None:
        """Attach the comments above an item of a display that opens at line ``opened``, and the one at its ``end``."""
        self._attach(code, self._unused(opened + 1, line - 1), self._trailing(end) if end is not None else None)

    def take_until(self, line: int) -> list[str]:
        """Return the unused comments up to and including a line."""
        return [_take(c) for c in self._unused(0, line)]

    def _attach(self, code: Code, before: Sequence[PythonComment], after: PythonComment | None) -> None:
        code.before = (*code.before, *(_take(c) for c in before))
        if after is not None:
            text = _take(after)
            code.after = f"{code.after}; {text}" if code.after else text

    def _unused(self, first: int, last: int) -> list[PythonComment]:
        unused = []
        comments = self._comments
        while self._next < len(comments) and comments[self._next].used:
            self._next += 1
        for comment in comments[self._next :]:
            if comment.line > last:
                break
            if comment.line >= first and not comment.used:
                unused.append(comment)
        return unused

    def _trailing(self, line: int) -> PythonComment | None:
        for comment in self._unused(line, line):
            if not comment.alone:
                return comment
        return None


def _take(comment: PythonComment) -> str:
    comment.used = True
    return comment.text


class Records:
    """Variables for the procedures that a record definition creates: accessors, setters and methods."""

    def __init__(self) -> None:
        self._variables: dict[tuple[Class, str, str], PythonVariable] = {}

    def part(self, record: Class, kind: str, name: str = "") -> PythonVariable:
        """Return the variable of a procedure.

        ``kind`` is ``make`` (the constructor of a class with ``__init__``), ``get``, ``set``, ``is``, ``method`` or
        ``constant``.
        """
        key = (record, kind, name)
        variable = self._variables.get(key)
        if variable is None:
            stem = record.name
            spelled = {
                "make": f"make_{stem}", "get": f"{stem}-{name}", "set": f"set-{stem}-{name}!", "is": f"{stem}?",
                "method": f"{stem}-{name}", "constant": f"{stem}-{name}",
            }[kind]  # fmt: skip
            variable = self._variables[key] = PythonVariable(spelled, record.variable.function, is_temporary=True)
            variable.record = (record.variable, kind, name)
        return variable


WriteExpression: TypeAlias = "Callable[[Writer, ast.expr], Code]"
WriteStatement: TypeAlias = "Callable[[Writer, ast.stmt, Block], None]"


class Writer:
    """Context of code generation: the analysed program, the generated parts, and the recursion over the tree.

    Functions that generate code take the writer as their first argument and call ``expr`` and ``statement`` for child
    nodes, so that their modules do not depend on each other.
    """

    def __init__(
        self,
        analysed: Analysed,
        write_expression: WriteExpression,
        write_statement: WriteStatement,
    ) -> None:
        self._write_expression = write_expression
        self._write_statement = write_statement
        self.analysed = analysed
        self.text = analysed.text
        self.names = analysed.names
        self.paths = analysed.paths
        self.facts = analysed.facts
        self.liveness = analysed.liveness
        self.effects = Effects(analysed.names, analysed.facts)
        self.cell_definitions = CellDefinitions(analysed.names, analysed.liveness)
        self.exits = Exits(analysed.names.module)
        self.comments = Comments(analysed.text)
        self.pending_texts: list[str] = []
        self.records = Records()
        self.diagnostics: list[Diagnostic] = []
        self.imports: set[str] = set()
        self.is_telling = False  # whether only people read what is written: a message
        self.unions: set[PythonVariable] = set()
        self.late_variables: dict[PythonVariable, PythonVariable] = {}
        self.defaults: dict[ast.expr, PythonVariable] = {}
        self._reads: dict[PythonVariable, list[ast.Name]] = {}

    def expr(self, node: ast.expr) -> Code:
        """Return the code of an expression."""
        return self._write_expression(self, node)

    def message(self, node: ast.expr) -> Code:
        """Return the code of a text that the program does not compute with."""
        self.is_telling = True
        try:
            return self.expr(node)
        finally:
            self.is_telling = False

    def statement(self, node: ast.stmt, block: Block) -> None:
        """Append the code of a statement to a block."""
        self._write_statement(self, node, block)

    # --- locations and errors ----------------------------------------------------------------------------------

    def span(self, node: ast.AST) -> Span:
        return self.text.span(node)

    def error(self, name: str, message: str, node: ast.AST, hint: str | None = None) -> SceneError:
        return SceneError(name, message, hint, self.span(node))

    def unsupported(self, what: str, node: ast.AST, hint: str | None = None) -> SceneError:
        return self.error("python-unsupported", f"{what} is not supported", node, hint)

    def warn(self, name: str, message: str, node: ast.AST, hint: str | None = None) -> None:
        self.diagnostics.append(Diagnostic(name, message, self.span(node), hint))

    # --- predicates --------------------------------------------------------------------------------------------

    def type(self, node: ast.AST) -> AbstractType:
        return self.facts.type(node)

    def effect(self, *nodes: ast.AST | None) -> Effect:
        return self.effects.of(*nodes)

    def is_mutated(self, node: ast.AST) -> bool:
        """Return whether the container that ``node`` creates is modified anywhere."""
        return any(site.is_mutated and _same_position(site.node, node) for site in self.type(node).sites)

    def may_change(self, node: ast.AST) -> bool:
        """Return whether the value of ``node`` may be a container or array that is modified anywhere."""
        return any(site.is_mutated for site in self.type(node).sites)

    def variable(self, node: ast.AST) -> PythonVariable | None:
        return self.names.variables.get(node)

    def is_simple(self, node: ast.expr) -> bool:
        """Return whether ``node`` can be evaluated twice without cost or effect."""
        return isinstance(node, (ast.Name, ast.Constant))

    def reads_of(self, variable: PythonVariable) -> list[ast.Name]:
        """Return the nodes that read ``variable``."""
        if not self._reads:
            for node, read in self.names.variables.items():
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                    self._reads.setdefault(read, []).append(node)
        return self._reads.get(variable, [])

    def parent(self, node: ast.AST) -> ast.AST | None:
        if not self.analysed.parents:
            for outer in walk_tree(self.text.tree):
                for child in child_nodes(outer):
                    self.analysed.parents[child] = outer
        return self.analysed.parents.get(node)

    def single_function(self, node: ast.expr) -> Function | None:
        """Return the function that a name always refers to, or None."""
        variable = self.variable(node)
        if variable is None or not variable.functions:
            return None
        if len(variable.functions) == len(variable.stores) or not variable.is_cell:
            return variable.functions[-1] if len(variable.functions) == len(variable.stores) else None
        return None

    def is_numeric(self, node: ast.expr) -> bool:
        inferred = self.type(node)
        return not inferred.kinds or inferred.only(NUMBERS)

    def is_vector_literal(self, node: ast.expr) -> bool:
        """Return whether ``node`` is a tuple or list display of numbers."""
        return (
            isinstance(node, (ast.Tuple, ast.List))
            and bool(node.elts)
            and all(not isinstance(e, ast.Starred) and self.is_numeric(e) for e in node.elts)
        )

    def known_length(self, node: ast.expr) -> int | None:
        """Return the length of a sequence if inference knows it, else None."""
        inferred = self.type(node)
        lengths = {len(site.items) if site.items is not None else None for site in inferred.sites}
        return lengths.pop() if len(lengths) == 1 and not inferred.kinds & ~SEQUENCES else None

    def is_python_stream(self, node: ast.expr) -> bool:
        """Return whether a stream belongs to Python's ``random`` rather than numpy."""
        return "random.Random" in self.type(node).names

    # --- comments ----------------------------------------------------------------------------------------------

    def comment_item(self, code: Code, node: ast.AST) -> Code:
        """Attach the comments at an item of a display or call that spans several lines."""
        container = self.parent(node)
        opened = getattr(container, "lineno", 0)
        closed = getattr(container, "end_lineno", 0)
        line, end = getattr(node, "lineno", 0), getattr(node, "end_lineno", 0)
        if container is None or opened == closed or line == opened or not self.comments.has_unused:
            return code
        is_last = end < closed and not any(
            getattr(other, "lineno", 0) == end and getattr(other, "col_offset", 0) > getattr(node, "col_offset", 0)
            for other in child_nodes(container)
            if other is not node
        )
        self.comments.take_inside(code, opened, line, end if is_last else None)
        return code

    def comment_pair(self, key: Code, value: Code, node: ast.AST) -> list[Code]:
        """Return ``:key value`` with its comments; those above are placed above the key."""
        self.comment_item(value, node)
        key.before, value.before = (*value.before, *key.before), ()
        return [key, value]


def _same_position(a: ast.AST, b: ast.AST) -> bool:
    """Return whether two nodes are the same, or one was created to replace the other."""
    return a is b or (
        isinstance(a, ast.Call) and isinstance(b, ast.Call)
        and (a.lineno, a.col_offset, a.end_lineno) == (b.lineno, b.col_offset, b.end_lineno)
        and a.end_col_offset == b.end_col_offset
    )  # fmt: skip


# Control flow: statements that exit a body or a loop early.


def may_exit(statement: ast.stmt, kind: type[ast.stmt]) -> bool:
    """Return whether ``statement`` contains a ``return``, ``continue`` or ``break`` that exits the enclosing body or
    loop."""
    if isinstance(statement, kind):
        return True
    if isinstance(statement, (ast.For, ast.While)) and kind is not ast.Return:
        return any(may_exit(s, kind) for s in statement.orelse)
    return any(may_exit(s, kind) for block in inner_blocks(statement) for s in block)


def always_exits(body: Sequence[ast.stmt], kind: type[ast.stmt]) -> bool:
    """Return whether the end of ``body`` is unreachable."""
    for statement in body:
        if isinstance(statement, (kind, ast.Raise)):
            return True
        if isinstance(statement, ast.If) and statement.orelse and _exits_both(statement, kind):
            return True
        if isinstance(statement, ast.Try) and not statement.finalbody:
            blocks = [[*statement.body, *statement.orelse], *(h.body for h in statement.handlers)]
            if all(always_exits(block, kind) for block in blocks):
                return True
    return False


def _exits_both(statement: ast.If, kind: type[ast.stmt]) -> bool:
    """Return whether both branches exit; it is remembered, since a chain of ``elif`` asks for every rest of it."""
    known: dict[type[ast.stmt], bool] = statement.__dict__.setdefault("exits", {})
    if kind not in known:
        known[kind] = always_exits(statement.body, kind) and always_exits(statement.orelse, kind)
    return known[kind]


def is_continue_guard(statement: ast.stmt) -> bool:
    """Return whether ``statement`` is ``if c: continue``."""
    is_guard = isinstance(statement, ast.If) and not statement.orelse and len(statement.body) == 1
    return isinstance(statement, ast.If) and is_guard and isinstance(statement.body[0], ast.Continue)


def has_break(body: Sequence[ast.stmt]) -> bool:
    """Return whether the body of a loop contains a ``break`` that exits it."""
    return any(may_exit(statement, ast.Break) for statement in body)


def sole_loop(body: Sequence[ast.stmt], collecting: Collecting | None) -> ast.For | None:
    """Return the loop that is the only statement of a loop's body, or None."""
    if len(body) == 1 and isinstance(body[0], ast.For) and not body[0].orelse and not has_break(body[0].body):
        return body[0]
    return None


def has_inner_star(target: ast.expr) -> bool:
    """Return whether a pattern has a starred element other than the last."""
    if isinstance(target, (ast.Tuple, ast.List)):
        return any(isinstance(e, ast.Starred) for e in target.elts[:-1]) or any(has_inner_star(e) for e in target.elts)
    return False


def is_main_guard(node: ast.If) -> bool:
    """Return whether ``node`` is ``if __name__ == "__main__":``."""
    return any(isinstance(n, ast.Name) and n.id == "__name__" for n in walk_tree(node.test))


def text_of(node: ast.stmt) -> str | None:
    """Return the string of a statement that consists of a string, else None."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
        return node.value.value
    return None


def without_docstring(body: Sequence[ast.stmt]) -> Sequence[ast.stmt]:
    """Return a body without its docstring."""
    return body[1:] if body and text_of(body[0]) is not None else body


def comment_lines(text: str) -> list[str]:
    """Return the lines of a docstring without indentation."""
    lines = [line.rstrip() for line in text.strip().splitlines()]
    indents = [len(line) - len(line.lstrip()) for line in lines[1:] if line.strip()]
    cut = min(indents, default=0)
    return [line if position == 0 else line[cut:] for position, line in enumerate(lines)]


def docstring_lines(function: Function) -> list[str]:
    """Return the docstring of a function as lines of a comment."""
    body = function.body
    text = text_of(body[0]) if body else None
    return comment_lines(text) if text and text.strip() else []


# Uses of values: lists of shapes that are only combined.


def is_parts(w: Writer, node: ast.expr) -> bool:
    """Return whether a list of shapes is only ever combined with ``concat_shapes``, so that parts can represent it."""
    sites = w.type(node).sites
    if not sites or any(not s.element.only(SHAPE) and not _is_empty_list(s.element) for s in sites):
        return False
    if not any(s.element.kinds & SHAPE for s in sites):
        return False
    parent = w.parent(node)
    if isinstance(parent, ast.Starred):
        return _is_combined(w, parent)
    if isinstance(parent, ast.Call):
        return _is_combined_argument(w, parent, node)
    if isinstance(parent, (ast.Assign, ast.AnnAssign)):
        target = parent.targets[0] if isinstance(parent, ast.Assign) else parent.target
        variable = w.variable(target)
        return variable is not None and is_only_combined(w, variable)
    if isinstance(parent, ast.Return):
        return _returns_shape(w, parent)
    return False


def is_only_combined(w: Writer, variable: PythonVariable) -> bool:
    """Return whether all uses of the list in ``variable`` combine its shapes."""
    reads = w.reads_of(variable)
    return bool(reads) and all(_read_combines(w, read) for read in reads)


def _read_combines(w: Writer, read: ast.Name) -> bool:
    parent = w.parent(read)
    if isinstance(parent, ast.Starred):
        return _is_combined(w, parent)
    if isinstance(parent, ast.Call):
        return _is_combined_argument(w, parent, read)
    if isinstance(parent, ast.Attribute):  # the additions of a collection
        grand = w.parent(parent)
        return grand in w.analysed.collections.additions
    if isinstance(parent, ast.Return):
        return _returns_shape(w, parent)
    return False


def _returns_shape(w: Writer, node: ast.Return) -> bool:
    outer: ast.AST | None = node
    while outer is not None and not isinstance(outer, (ast.FunctionDef, ast.Module)):
        outer = w.parent(outer)
    function = w.names.functions.get(outer) if outer is not None else None
    if function is None or function.is_animation:  # the items of an animation are frames
        return False
    return function.is_registered and not function.is_called_directly


def _is_combined(w: Writer, starred: ast.Starred) -> bool:
    call = w.parent(starred)
    return isinstance(call, ast.Call) and w.paths.of(call.func) == "concat_shapes"


def _is_combined_argument(w: Writer, call: ast.Call, node: ast.expr) -> bool:
    path = w.paths.of(call.func)
    return path == "concat_shapes" or (path == "transform_shape" and bool(call.args) and call.args[0] is node)


def _is_empty_list(inferred: AbstractType) -> bool:
    return inferred.only(SHAPE | LIST) and all(not site.element.kinds & ~SHAPE for site in inferred.sites)


# Sequences of numbers that are only used as vectors.


def is_used_as_vector(w: Writer, node: ast.expr) -> bool:
    """Return whether all uses of a display accept a vector."""
    return _flows_to_vector(w, node, set())


def _flows_to_vector(w: Writer, node: ast.AST, seen: set[object]) -> bool:
    """Return whether a value reaches only uses that accept a vector, also through variables and parameters."""
    parent = w.parent(node)
    if isinstance(parent, ast.IfExp) and node is not parent.test:
        return _flows_to_vector(w, parent, seen)
    if isinstance(parent, ast.Assign) and len(parent.targets) == 1 and isinstance(parent.targets[0], ast.Name):
        return _variable_is_vector(w, w.names.variables.get(parent.targets[0]), seen)
    if isinstance(parent, ast.AnnAssign):
        return _variable_is_vector(w, w.names.variables.get(parent.target), seen)
    if isinstance(parent, ast.arguments):
        function = w.names.functions.get(w.parent(parent) or parent)
        parameters = function.parameters if function is not None else []
        parameter = next((p for p in parameters if p.default is node), None)
        return parameter is not None and _variable_is_vector(w, parameter.variable, seen)
    if isinstance(parent, ast.keyword):
        call = w.parent(parent)
        if isinstance(call, ast.Call):
            if _is_vector_keyword(w.paths.of(call.func), parent.arg):
                return True
            return _parameter_is_vector(w, call, parent.arg, None, seen)
        return False
    if isinstance(parent, ast.Dict):
        position = next((i for i, v in enumerate(parent.values) if v is node), None)
        key = parent.keys[position] if position is not None else None
        is_attribute = isinstance(key, ast.Constant) and key.value in ("p0", "p1", "scale")
        holder = w.parent(parent)
        return is_attribute and isinstance(holder, (ast.keyword, ast.Call))
    if isinstance(parent, ast.Call):
        path = w.paths.of(parent.func)
        position = next((i for i, a in enumerate(parent.args) if a is node), None)
        if position is None:
            return False
        if path is not None:
            return _is_vector_argument(path, position)
        return _parameter_is_vector(w, parent, None, position, seen)
    if isinstance(parent, ast.BinOp):
        other = parent.right if parent.left is node else parent.left
        return w.type(other).only(ARRAY)
    if isinstance(parent, ast.Subscript) and parent.value is node:
        return isinstance(parent.ctx, ast.Load)
    return False


def _parameter_is_vector(w: Writer, call: ast.Call, name: str | None, position: int | None, seen: set[object]) -> bool:
    targets = w.facts.targets.get(call, [])
    if not targets:
        return False
    for target in targets:
        if name is not None:
            parameter = target.parameter(name)
        else:
            plain = [p for p in target.parameters if p.kind == "plain"]
            parameter = plain[position] if position is not None and position < len(plain) else None
        if parameter is None or not _variable_is_vector(w, parameter.variable, seen):
            return False
    return True


def _variable_is_vector(w: Writer, variable: PythonVariable | None, seen: set[object]) -> bool:
    if variable is None or variable.is_assigned_elsewhere:
        return False
    if variable in seen:
        return True
    seen.add(variable)
    reads = w.reads_of(variable)
    return bool(reads) and all(_flows_to_vector(w, read, seen) or _is_unpacked(w, read) for read in reads)


def _is_unpacked(w: Writer, read: ast.Name) -> bool:
    parent = w.parent(read)
    return isinstance(parent, ast.Assign) and isinstance(parent.targets[0], ast.Tuple) and parent.value is read


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
    helper = scene_helpers().get(path or "")
    if helper is not None:
        return is_vector(next((each for each in helper.signature.parameters if each.name == name), None))
    return path is not None and name in _VECTOR_KEYWORDS.get(path, ())


def _is_vector_argument(path: str, position: int) -> bool:
    helper = scene_helpers().get(path)
    if helper is not None:
        return is_vector(next(iter(helper.signature.positional[position:]), None))
    return position in _VECTOR_ARGUMENTS.get(path, ())
