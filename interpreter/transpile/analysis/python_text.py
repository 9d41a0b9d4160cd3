"""The Python source: extraction from the response, parsing, locations of nodes, and comments."""

from __future__ import annotations

import ast
import json
import re
import symtable
import textwrap
import warnings
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from keyword import iskeyword
from typing import Any, TypeAlias, TypeGuard

from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError

# Walks of syntax trees. Those of ``ast`` look at every field of a node; these know which contain nodes, and leave out
# the contexts of names. Analyses walk a program some twenty times.

_LEAF_FIELDS = {"ctx", "id", "attr", "arg", "kind", "type_comment", "conversion", "level", "module", "asname"}
_NODE_FIELDS: dict[type, tuple[str, ...]] = {
    kind: tuple(name for name in kind._fields if name not in _LEAF_FIELDS and kind is not ast.Constant)
    for kind in vars(ast).values()
    if isinstance(kind, type) and issubclass(kind, ast.AST)
}


def child_nodes(node: ast.AST) -> list[ast.AST]:
    """Return the nodes in a node, in order, without contexts."""
    children: list[ast.AST] = []
    for name in _NODE_FIELDS[node.__class__]:
        value = getattr(node, name, None)
        if value.__class__ is list:
            children += [each for each in value if isinstance(each, ast.AST)]
        elif isinstance(value, ast.AST):
            children.append(value)
    return children


def walk_tree(*nodes: ast.AST) -> list[ast.AST]:
    """Return nodes and all nodes in them, without contexts; outer nodes come first."""
    reached = [*nodes]
    for node in reached:  # which grows
        reached += child_nodes(node)
    return reached


def variable_of(node: ast.AST) -> ast.Name | None:
    """Return the variable before all dots and indices of an expression, None if there is none."""
    while isinstance(node, (ast.Attribute, ast.Subscript)):
        node = node.value
    return node if isinstance(node, ast.Name) else None


_CONSTRUCTS = {  # by the name of a node's class: as Python writes it, and what to write instead
    "AsyncFor": ("`async for`", "there is nothing to wait for: write `for`"),
    "AsyncFunctionDef": ("`async def`", "there is nothing to wait for: write `def`"),
    "AsyncWith": ("`async with`", "there is nothing to wait for: write `with`"),
    "AugAssign": ("an assignment such as `+=`", None),
    "Await": ("`await`", "there is nothing to wait for: call the function without it"),
    "ClassDef": ("`class`", None),
    "Delete": ("`del`", None),
    "DictComp": ("a dict comprehension", None),
    "FunctionDef": ("`def`", None),
    "GeneratorExp": ("a generator expression", None),
    "IfExp": ("`... if ... else ...`", None),
    "JoinedStr": ("an f-string", None),
    "ListComp": ("a list comprehension", None),
    "NamedExpr": ("`:=`", None),
    "SetComp": ("a set comprehension", None),
    "Starred": ("`*` before a value", None),
    "TryStar": ("`except*`", "write `except` without the star"),
    "TypeAlias": ("`type`", "leave it out: types have no effect"),
    "YieldFrom": ("`yield from`", None),
}


def construct_of(node: ast.AST) -> tuple[str, str | None]:
    """Return a statement or expression as Python writes it, and what to write instead of it, if that is known."""
    name = type(node).__name__
    return _CONSTRUCTS.get(name, (f"`{name.lower()}`", None))


# Location of the program in a language model's response, which consists of prose, fenced code and prose.


_FENCE = re.compile(r"^[ \t]*+(?:```++|~~~++)[ \t]*+([\w+-]*+)[^\n`]*+$", re.M)
_PYTHON_FENCE = re.compile(r"^[ \t]*(?:```|~~~)[ \t]*(?:python3?|py)[ \t]*$", re.M | re.I)
_CLOSING = re.compile(r"^[ \t]*(?:```|~~~)", re.M)
_REGISTERS = re.compile(r"^[ \t]*@register", re.M)
_BLANK = re.compile(r"[^\n]")
_MAGIC = re.compile(r"\s*(?:[!%]{1,2}[a-zA-Z]|\?|[\w.]+\?{1,2}$)")
_OTHER_LANGUAGE = re.compile(r"%%(?!time\b|timeit\b|capture\b|prun\b)")


# A block: start of the opening fence, start and end of the code, end of the closing fence.
Block: TypeAlias = tuple[int, int, int, int]


@dataclass(frozen=True, slots=True)
class Response:
    """Location of the code in a response.

    Attributes
    ----------
    start, end
        Offsets of the code.
    before, after
        Prose around the code.
    ignored
        Number of further code blocks.
    gaps
        Offsets of what is no code between the start and the end: prose and fences between blocks that are one program.
    """

    start: int
    end: int
    before: str
    after: str
    ignored: int = 0
    gaps: tuple[tuple[int, int], ...] = ()

    def code(self, text: str) -> str:
        """Return the code, with blank lines in place of the gaps."""
        for start, end in self.gaps:
            text = text[:start] + _BLANK.sub(" ", text[start:end]) + text[end:]
        return text[self.start : self.end]


def find_code(text: str) -> Response:
    """Find the code of a response.

    As in the paper's tool, it starts at the first line "```python" and ends at the next "```". If that block registers
    nothing, the first block that does is used. Other blocks are added that continue this one: see ``_parts``. If there
    are no fences, or the whole text is valid Python (so that fences are inside strings), the whole text is used.
    """
    blocks = _python_blocks(text) or _blocks(text)
    if not blocks or _is_python(text):
        return Response(0, len(text), "", "")
    chosen = next((i for i, block in enumerate(blocks) if _REGISTERS.search(text, block[1], block[2])), 0)
    parts = _parts(text, blocks, chosen)
    gaps = tuple((before[2], after[1]) for before, after in pairwise(parts))
    start, end = parts[0][1], parts[-1][2]
    before = _FENCE.sub("", _without_blocks(text, blocks, 0, parts[0][0]))
    after = _FENCE.sub("", _without_blocks(text, blocks, parts[0][3], len(text)))
    return Response(start, end, before.strip(), after.strip(), len(blocks) - len(parts), gaps)


def _parts(text: str, blocks: list[Block], chosen: int) -> list[Block]:
    """Return the blocks that are one program with the chosen one.

    These are earlier blocks that define what it needs, and later ones that define what it needs, that register further
    functions and use what it defines, or that define some of its functions anew, except for its root. A later block
    that is a whole program itself is another version, and one that only calls functions is an example of their use.
    """
    outlines = [_outline(text[start:end]) for _, start, end, _ in blocks]
    known = outlines[chosen]
    if known is None:
        return [blocks[chosen]]
    numbers = {chosen}
    for _ in blocks:  # one that is added may need others
        for i, outline in enumerate(outlines):
            if i not in numbers and outline is not None and _continues(outline, known, is_earlier=i < chosen):
                numbers.add(i)
                known = known.joined(outline)
    parts = [blocks[i] for i in sorted(numbers)]
    gaps = tuple((before[2], after[1]) for before, after in pairwise(parts))
    is_program = len(parts) == 1 or _is_python(Response(parts[0][1], parts[-1][2], "", "", 0, gaps).code(text))
    return parts if is_program else [blocks[chosen]]


@dataclass(frozen=True, slots=True)
class _Outline:
    """Names that a block defines at its top level, those of its registered functions, and those that it uses."""

    defined: frozenset[str]
    registered: frozenset[str]
    used: frozenset[str]
    roots: frozenset[str]

    def joined(self, other: _Outline) -> _Outline:
        """Return the outline of both blocks."""
        pairs = zip((self.defined, self.registered, self.used), (other.defined, other.registered, other.used))
        defined, registered, used = (a | b for a, b in pairs)
        return _Outline(defined, registered, used, (self.roots - other.used) | (other.roots - self.used))


def _continues(outline: _Outline, known: _Outline, *, is_earlier: bool) -> bool:
    """Return whether a block belongs to a program that is known in part."""
    if outline.defined & (known.used - known.defined):
        return True
    if is_earlier or not outline.registered:
        return False
    if outline.registered - known.registered:
        return bool(known.defined & (outline.used - outline.defined)) and not known.roots & outline.registered
    return outline.defined <= known.defined and not known.roots & outline.registered


def _outline(code: str) -> _Outline | None:
    """Return the outline of a block, None if it does not parse."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(textwrap.dedent(code))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    registered: set[str] = set()
    defined: set[str] = set()
    used: set[str] = set()
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            defined.add(node.name)
            if any("register" in ast.unparse(each) for each in node.decorator_list):
                registered.add(node.name)
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            defined |= {n.id for n in walk_tree(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        own = node.name if isinstance(node, ast.FunctionDef) else ""
        names = [n for n in walk_tree(node) if isinstance(n, ast.Name)]
        bound = {n.id for n in names if not isinstance(n.ctx, ast.Load)}
        bound |= {n.arg for n in walk_tree(node) if isinstance(n, ast.arg)}
        used |= {n.id for n in names if isinstance(n.ctx, ast.Load)} - bound - {own}
        calls = [n for n in walk_tree(node) if isinstance(n, ast.Call) and n.args]
        words = {c.args[0].value for c in calls if "library_call" in ast.unparse(c.func) and _is_word(c.args[0])}
        used |= {str(word) for word in words} - {own}
    return _Outline(frozenset(defined), frozenset(registered), frozenset(used), frozenset(registered - used))


def _is_word(node: ast.expr) -> TypeGuard[ast.Constant]:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def notebook_code(text: str, name: str) -> str:
    """Return the Python of a Jupyter notebook: its code cells, with the text cells as comments before them.

    Lines for IPython (``%`` and ``!``) are left out, and cells in other languages. Places in it are those of the code
    cells as one file. Raises SceneError if ``text`` is not a notebook.
    """
    try:
        parts = [_code_of_cell(cell) for cell in json.loads(text).get("cells", ())]
    except (ValueError, AttributeError, TypeError, RecursionError):
        hint = "save it as a notebook, or its code as a .py file"
        raise SceneError("file", f"{name} is not a notebook", hint) from None
    return "\n\n".join(part for part in parts if part.strip()) + "\n"


def _code_of_cell(cell: Any) -> str:
    source = cell.get("source", "")
    lines = ("".join(source) if isinstance(source, list) else str(source)).splitlines()
    if cell.get("cell_type") == "markdown":
        return "\n".join(f"# {line}".rstrip() for line in lines)
    if cell.get("cell_type") != "code" or (lines and _OTHER_LANGUAGE.match(lines[0])):
        return ""
    return "\n".join("" if _MAGIC.match(line) else line for line in lines)


def _is_python(text: str) -> bool:
    """Return whether a whole text parses as Python and contains more than strings."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(textwrap.dedent(text))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return any(not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Constant) for node in tree.body)


def code_of(text: str) -> str:
    """Return the code of a response, ending in one newline."""
    located = find_code(text)
    return located.code(text).strip() + "\n"


def _python_blocks(text: str) -> list[Block]:
    """Return the blocks that are marked as Python, each up to the next fence of any kind."""
    python_blocks: list[Block] = []
    position = 0
    while opening := _PYTHON_FENCE.search(text, position):
        start = _next_line(text, opening)
        closing = _CLOSING.search(text, start)
        end = closing.start() if closing else len(text)
        line_end = text.find("\n", end) if closing else -1
        position = line_end if line_end >= 0 else len(text)
        python_blocks.append((opening.start(), start, end, position))
    return python_blocks


def _blocks(text: str) -> list[Block]:
    """Return all fenced blocks."""
    all_blocks: list[Block] = []
    opening: re.Match[str] | None = None
    for match in _FENCE.finditer(text):
        if opening is None:
            opening = match
        elif not match.group(1):
            all_blocks.append((opening.start(), _next_line(text, opening), match.start(), match.end()))
            opening = None
    if opening is not None:  # the response is truncated
        all_blocks.append((opening.start(), _next_line(text, opening), len(text), len(text)))
    return all_blocks


def _next_line(text: str, fence: re.Match[str]) -> int:
    return min(fence.end() + 1, len(text))


def _without_blocks(text: str, blocks: list[Block], start: int, end: int) -> str:
    pieces = []
    for opening, _, _, closing in blocks:
        if start <= opening and closing <= end:
            pieces.append(text[start:opening])
            start = closing
    pieces.append(text[start:end])
    return "\n".join(pieces)


_TOKENS = re.compile(
    r'"""(?:[^\\]|\\.)*?"""' r"|'''(?:[^\\]|\\.)*?'''" r'|"(?:[^"\\\n]|\\.)*"' r"|'(?:[^'\\\n]|\\.)*'" r"|(#[^\n]*)",
    re.S,
)
_MAX_SYNTAX_ERRORS = 5  # that are reported
# Of the syntax tree. Models do not write larger programs, and parts of the analysis are not linear.
_MAX_SYNTAX_NODES, _MAX_SYNTAX_DEPTH = 80_000, 400


@dataclass(slots=True)
class PythonComment:
    """Comment in the Python code. ``alone`` is set if it is the only content of its line."""

    line: int
    column: int
    text: str
    alone: bool
    used: bool = False


@dataclass(eq=False)
class PythonText:
    """Parsed code of ``source``. Line numbers count from 1 within the code."""

    source: Source
    response: Response
    tree: ast.Module
    diagnostics: list[Diagnostic]
    lines: list[str]
    starts: list[int]
    indent: int
    comments: list[PythonComment] = field(default_factory=list)

    def offset(self, line: int, byte_column: int) -> int:
        """Return the offset in the source of a position given by ``ast`` as line and byte column."""
        if line > len(self.lines):
            return self.response.end
        text = self.lines[line - 1]
        column = byte_column if text.isascii() else len(text.encode()[:byte_column].decode(errors="ignore"))
        return min(self.starts[line - 1] + (self.indent if text else 0) + column, len(self.source.text))

    def span(self, node: ast.AST) -> Span:
        """Return the span of a node in the source."""
        line: int = getattr(node, "lineno", 1)
        end_line: int = getattr(node, "end_lineno", line) or line
        start = self.offset(line, getattr(node, "col_offset", 0))
        end = self.offset(end_line, getattr(node, "end_col_offset", 0) or 0)
        return Span(self.source, start, max(end, start))

    def text(self, node: ast.AST) -> str:
        return self.span(node).text

    def blank_before(self, line: int) -> bool:
        """Return whether the line above ``line`` is empty."""
        return 1 < line <= len(self.lines) + 1 and not self.lines[line - 2].strip()


def parse_python(source: Source) -> PythonText:
    """Parse the code of a response. After a syntax error, the block around it is skipped to find further errors."""
    response = find_code(source.text)
    code = response.code(source.text)
    raw = code.split("\n")
    indent = _common_indent(raw)
    lines = [line[indent:].rstrip("\r") if line.strip() else "" for line in raw]
    starts, offset = [], response.start
    for line in raw:
        starts.append(offset)
        offset += len(line) + 1
    result = PythonText(source, response, ast.Module([], []), [], lines, starts, indent)
    _parse(result)
    result.comments = _comments(lines)
    return result


def _common_indent(lines: list[str]) -> int:
    widths = [len(line) - len(line.lstrip()) for line in lines if line.strip()]
    return min(widths, default=0)


def _parse(text: PythonText) -> None:
    lines = list(text.lines)
    while True:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                code = "\n".join(lines)
                tree = ast.parse(code)
                problem = _too_large(text, tree)
                if problem is not None:
                    text.diagnostics.append(problem)
                    return
                text.tree = _with_named_tuples(_with_separate_lists(tree))
                symtable.symtable(
                    code, "<python>", "exec"
                )  # reports scope errors that the parser does not detect; executes nothing
            return
        except SyntaxError as error:
            older = ["" if _MAGIC.match(line) else line for line in without_type_parameters(lines)]
            if older != lines:
                lines = older
                continue
            text.diagnostics.append(_syntax_diagnostic(text, error))
            if len(text.diagnostics) >= _MAX_SYNTAX_ERRORS or not _skip_block(lines, error.lineno or 1):
                return
        except (ValueError, RecursionError, MemoryError) as error:
            message = "the Python code is nested too deeply" if not isinstance(error, ValueError) else str(error)
            text.diagnostics.append(
                Diagnostic("python-syntax", message, Span(text.source, text.starts[0], text.starts[0]))
            )
            return


_PARAMETERS = re.compile(r"^(\s*(?:def|class)\s+\w+\s*)(\[(?:[^\[\]]|\[[^\[\]]*\])*\])(?=\s*[(:])")
_TYPE = re.compile(r"^(\s*)type (\s*)(\w+)(\s*)(\[(?:[^\[\]]|\[[^\[\]]*\])*\])?(?=\s*=[^=])")


def without_type_parameters(lines: list[str]) -> list[str]:
    """Return lines without the type parameters and type statements of Python 3.12; all columns stay."""
    reduced = [_PARAMETERS.sub(lambda m: m[1] + " " * len(m[2]), line) for line in lines]
    name = lambda m: m[1] + m[3] + " " * (len(m[0]) - len(m[1]) - len(m[3]))
    return [_TYPE.sub(name, line) for line in reduced]


def _too_large(text: PythonText, tree: ast.Module) -> Diagnostic | None:
    """Return a diagnostic for a program far larger than models write; parts of the analysis are not linear."""
    level: list[ast.AST] = [tree]
    count = 0
    for _ in range(_MAX_SYNTAX_DEPTH):
        count += len(level)
        level = [child for node in level for child in child_nodes(node)]
        if not level or count > _MAX_SYNTAX_NODES:
            break
    if not level:
        return None
    where = next((node for node in level if hasattr(node, "lineno")), tree)
    if count > _MAX_SYNTAX_NODES:
        return Diagnostic(
            "size", f"the syntax tree of the Python code has more than {_MAX_SYNTAX_NODES:,} nodes", text.span(where)
        )
    return Diagnostic(
        "nesting", f"the Python code is nested more than {_MAX_SYNTAX_DEPTH} levels deep", text.span(where)
    )


def _with_separate_lists(tree: ast.Module) -> ast.Module:
    """Split ``shapes, y = [], 0`` into two statements, which makes lists easier to analyse."""
    for node in walk_tree(tree):
        for name in ("body", "orelse", "finalbody"):
            block = getattr(node, name, None)
            if isinstance(block, list) and any(isinstance(s, ast.Assign) for s in block):
                setattr(node, name, [part for statement in block for part in _separated(statement)])
    return tree


def _with_named_tuples(tree: ast.Module) -> ast.Module:
    """Convert ``P = namedtuple("P", "x y")`` to a class definition."""
    tree.body = [_named_tuple(statement) or statement for statement in tree.body]
    return tree


def _named_tuple(statement: ast.stmt) -> ast.ClassDef | None:
    """Return the class that ``P = namedtuple("P", "x y")`` defines, None for other statements."""
    if not isinstance(statement, ast.Assign) or not isinstance(statement.targets[0], ast.Name):
        return None
    call = statement.value
    if not isinstance(call, ast.Call) or len(call.args) != 2 or any(k.arg != "defaults" for k in call.keywords):
        return None
    func = call.func
    name = func.id if isinstance(func, ast.Name) else func.attr if isinstance(func, ast.Attribute) else ""
    fields = call.args[1]
    if name != "namedtuple":
        return None
    if isinstance(fields, ast.Constant) and isinstance(fields.value, str):
        names = fields.value.replace(",", " ").split()
    elif isinstance(fields, (ast.List, ast.Tuple)) and all(isinstance(e, ast.Constant) for e in fields.elts):
        names = [str(e.value) for e in fields.elts if isinstance(e, ast.Constant)]
    else:
        return None
    if not all(field.isidentifier() and not iskeyword(field) for field in names):
        return None
    given = call.keywords[0].value if call.keywords else ast.Tuple([], ast.Load())
    if not isinstance(given, (ast.Tuple, ast.List)) or len(given.elts) > len(names):
        return None
    # defaults belong to the last fields
    defaults: list[ast.expr | None] = [*([None] * (len(names) - len(given.elts))), *given.elts]
    body: list[ast.stmt] = [
        ast.AnnAssign(ast.Name(field, ast.Store()), ast.Name("Any", ast.Load()), default, simple=1)
        for field, default in zip(names, defaults)
    ]
    class_def = ast.ClassDef(statement.targets[0].id, [ast.Name("NamedTuple", ast.Load())], [], body, [])
    for node in walk_tree(class_def):
        ast.copy_location(node, statement)
    return class_def


def _separated(statement: ast.stmt) -> list[ast.stmt]:
    if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
        return [statement]
    targets, values = statement.targets[0], statement.value
    if not isinstance(targets, ast.Tuple) or not isinstance(values, ast.Tuple) or len(targets.elts) != len(values.elts):
        return [statement]
    names = {target.id for target in targets.elts if isinstance(target, ast.Name)}
    is_plain = len(names) == len(targets.elts) and any(isinstance(v, ast.List) and not v.elts for v in values.elts)
    if not is_plain or any(isinstance(n, ast.Name) and n.id in names for n in walk_tree(values)):
        return [statement]
    return [
        ast.copy_location(ast.Assign([target], value), statement) for target, value in zip(targets.elts, values.elts)
    ]


def _syntax_diagnostic(text: PythonText, error: SyntaxError) -> Diagnostic:
    line = min(max(error.lineno or 1, 1), len(text.lines))
    start = text.starts[line - 1] + text.indent + max((error.offset or 1) - 1, 0)
    end = start + 1
    if error.end_offset and (error.end_lineno or line) == line and error.end_offset > (error.offset or 1):
        end = text.starts[line - 1] + text.indent + error.end_offset - 1
    last = len(text.source.text)
    hint = None
    if not text.source.name.endswith(".py") and "```" not in text.source.text:
        hint = "put the program between ```python and ```"
    return Diagnostic(
        "python-syntax", f"Python: {error.msg}", Span(text.source, min(start, last), min(end, last)), hint
    )


def _skip_block(lines: list[str], line: int) -> bool:
    """Clear the top-level block around ``line``; return whether it had any text."""
    first = min(line, len(lines)) - 1
    while first > 0 and (not lines[first].strip() or lines[first][0] in " \t)]}"):
        first -= 1
    after = first + 1
    while after < len(lines) and (not lines[after].strip() or lines[after][0] in " \t)]}"):
        after += 1
    while first > 0 and lines[first - 1].startswith("@"):
        first -= 1
    had_text = any(text.strip() for text in lines[first:after])
    lines[first:after] = [""] * (after - first)
    return had_text


def _comments(lines: list[str]) -> list[PythonComment]:
    text = "\n".join(lines)
    comments = []
    line, position = 1, 0
    for match in _TOKENS.finditer(text):
        if match.group(1) is None:
            continue
        line += text.count("\n", position, match.start())
        position = match.start()
        start = text.rfind("\n", 0, position) + 1
        body = match.group(1)[1:].rstrip()
        alone = not text[start:position].strip()
        comments.append(PythonComment(line, position - start, body.removeprefix(" "), alone))
    return comments


@lru_cache(maxsize=1_000)  # each keeps the tree of a function
def scope_of(node: ast.FunctionDef | ast.Lambda) -> tuple[frozenset[str], dict[str, bool], bool]:
    """Return the names that a function assigns, those that it declares global or nonlocal, and whether it yields."""
    given = node.args
    arguments = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    local = {each.arg for each in arguments if each is not None}
    shared: dict[str, bool] = {}
    is_generator = False
    pending: list[ast.AST] = list(node.body) if isinstance(node, ast.FunctionDef) else [node.body]
    while pending:
        each = pending.pop()
        if isinstance(each, (ast.FunctionDef, ast.ClassDef)):
            local.add(each.name)
            pending += each.decorator_list
            continue
        if isinstance(each, ast.Lambda):
            continue
        if isinstance(each, (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)):
            local |= {n.target.id for n in walk_tree(each) if isinstance(n, ast.NamedExpr)}
            continue
        if isinstance(each, (ast.Global, ast.Nonlocal)):
            shared |= dict.fromkeys(each.names, isinstance(each, ast.Global))
        elif isinstance(each, (ast.Yield, ast.YieldFrom)):
            is_generator = True
        elif isinstance(each, ast.Name) and not isinstance(each.ctx, ast.Load):
            local.add(each.id)
        elif isinstance(each, (ast.ExceptHandler, ast.MatchAs, ast.MatchStar)) and each.name:
            local.add(each.name)
        elif isinstance(each, ast.MatchMapping) and each.rest:
            local.add(each.rest)
        elif isinstance(each, (ast.Import, ast.ImportFrom)):
            local |= {(alias.asname or alias.name).partition(".")[0] for alias in each.names}
        pending += child_nodes(each)
    return frozenset(local), shared, is_generator
