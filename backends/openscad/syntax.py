"""Parser of OpenSCAD: text to a syntax tree with places. The text is untrusted: size and nesting are bounded.

The tree keeps the comments that stand before a statement, or behind it on its line.

It is a recursive descent of our own. The MIT packages `openscad-parser` and `openscad-lalr-parser` read all of
OpenSCAD's examples, but the first exceeds Python's recursion limit at thirty nested parentheses and takes seconds for
a long sum, the second needs Lark when it runs, both print mistakes instead of returning them, and both keep pickled
trees on disk.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple, NoReturn, TypeAlias

from scenelang.grammar.datum import Source, Span, dataclass
from scenelang.grammar.diagnostics import SceneError

MAX_SIZE = 1_000_000  # characters
MAX_TOKENS = 200_000
MAX_NESTING = 100

# --- the tree --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ConstantValue:
    """``undef``, a truth value, a string, or a number with its text."""

    span: Span
    value: float | str | bool | None
    text: str = ""


@dataclass(frozen=True, slots=True)
class VariableName:
    """Variable, perhaps special (``$fn``)."""

    span: Span
    name: str


@dataclass(frozen=True, slots=True)
class Items:
    """List ``[a, b]``, with comprehensions among its items."""

    span: Span
    items: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Range:
    """Range ``[first : step : last]``."""

    span: Span
    first: Expr
    step: Expr | None
    last: Expr


@dataclass(frozen=True, slots=True)
class Operation:
    """Operator with its operands; chains of ``+``, ``*``, ``&&`` and ``||`` have more than two, ``?`` has three."""

    span: Span
    operator: str
    operands: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Argument:
    """Argument of a call, with its name if it has one."""

    name: str | None
    value: Expr


@dataclass(frozen=True, slots=True)
class ScadCall:
    """Call of a function."""

    span: Span
    function: Expr
    arguments: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class ItemAt:
    """Item of a list, ``x[i]``; the index of ``x.y`` is a constant."""

    span: Span
    value: Expr
    index: Expr


@dataclass(frozen=True, slots=True)
class Let:
    """``let (a = 1) body``."""

    span: Span
    bindings: tuple[Argument, ...]
    body: Expr


@dataclass(frozen=True, slots=True)
class ScadCheck:
    """``assert (condition, message) body`` or ``echo (...) body``."""

    span: Span
    is_assert: bool
    arguments: tuple[Argument, ...]
    body: Expr | None


@dataclass(frozen=True, slots=True)
class FunctionValue:
    """``function (x) body``."""

    span: Span
    parameters: tuple[ScadParameter, ...]
    body: Expr


@dataclass(frozen=True, slots=True)
class Each:
    """``each list`` among items."""

    span: Span
    value: Expr


@dataclass(frozen=True, slots=True)
class ItemLoop:
    """``for (a = range) item`` among items."""

    span: Span
    bindings: tuple[Argument, ...]
    body: Expr


@dataclass(frozen=True, slots=True)
class ItemCondition:
    """``if (test) item else item`` among items."""

    span: Span
    test: Expr
    yes: Expr
    no: Expr | None


Expr: TypeAlias = (
    ConstantValue
    | VariableName
    | Items
    | Range
    | Operation
    | ScadCall
    | ItemAt
    | Let
    | ScadCheck
    | FunctionValue
    | Each
    | ItemLoop
    | ItemCondition
)


@dataclass(frozen=True, slots=True)
class ScadParameter:
    """Parameter of a function or module."""

    span: Span
    name: str
    default: Expr | None


@dataclass(frozen=True, slots=True)
class ScadAssignment:
    """``name = value;``."""

    span: Span
    name: str
    value: Expr
    comments: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FunctionDefinition:
    """``function name(parameters) = body;``."""

    span: Span
    name: str
    parameters: tuple[ScadParameter, ...]
    body: Expr
    comments: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ModuleDefinition:
    """``module name(parameters) { ... }``."""

    span: Span
    name: str
    parameters: tuple[ScadParameter, ...]
    body: tuple[Statement, ...]
    comments: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Instance:
    """Call of a module with its children; a block is an instance of ``union``."""

    span: Span
    name: str
    arguments: tuple[Argument, ...] = ()
    children: tuple[Statement, ...] = ()
    modifiers: str = ""
    comments: tuple[str, ...] = ()

    @property
    def is_check(self) -> bool:
        """Whether it is an assertion that counts."""
        return self.name == "assert" and not set(self.modifiers) & {"*", "%"}


@dataclass(frozen=True, slots=True)
class Branch:
    """``if (test) ... else ...``."""

    span: Span
    test: Expr
    yes: tuple[Statement, ...]
    no: tuple[Statement, ...]
    modifiers: str = ""
    comments: tuple[str, ...] = ()


Statement: TypeAlias = ScadAssignment | FunctionDefinition | ModuleDefinition | Instance | Branch


# --- tokens ----------------------------------------------------------------------------------------------------------


class ScadToken(NamedTuple):
    """Token: its kind (``name``, ``number``, ``string``, ``path``, ``end`` or the text of a sign), text and place."""

    kind: str
    text: str
    start: int


_TOKEN = re.compile(
    r"""(?P<space>[\s\ufeff]+)
    | (?P<comment>//[^\n]*|/\*.*?\*/)
    | (?P<path>(?:use|include)\s*<[^>\n]*>)
    | (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![A-Za-z0-9_]))
    | (?P<name>\$?[A-Za-z0-9_]*[A-Za-z_][A-Za-z0-9_]*)
    | (?P<string>"(?:[^"\\]|\\.)*")
    | (?P<sign><=|>=|==|!=|&&|\|\||/(?!\*)|[-+*%^!<>=?:;,.#(){}\[\]])""",
    re.VERBOSE | re.DOTALL,
)
_ESCAPE = re.compile(r"\\(x[0-7][0-9a-fA-F]|u[0-9a-fA-F]{4}|U[0-9a-fA-F]{6}|.)", re.DOTALL)
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r"}


def failure(span: Span, message: str, hint: str | None = None) -> NoReturn:
    """Raise the error of a text that is not OpenSCAD."""
    raise SceneError("openscad-syntax", message, hint, span)


def unsupported(span: Span, message: str, hint: str | None = None) -> NoReturn:
    """Raise the error of what cannot be converted."""
    raise SceneError("openscad-unsupported", message, hint, span)


def _tokens(source: Source) -> Iterator[ScadToken]:
    text, at = source.text, 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            what = "comment" if text.startswith("/*", at) else "string" if text[at] == '"' else ""
            end = Span(source, at, at + 1)
            failure(end, f"this {what} is never closed" if what else f"unexpected character {text[at]!r}")
        kind = match.lastgroup
        assert kind is not None
        if kind != "space":
            yield ScadToken(match[0] if kind == "sign" else kind, match[0], at)
        at = match.end()
    yield ScadToken("end", "", at)


def _unescaped(text: str) -> str:
    def character(match: re.Match[str]) -> str:
        code = match[1]
        if len(code) > 1:
            number = int(code[1:], 16)
            is_character = number <= 0x10FFFF and not 0xD800 <= number < 0xE000
            return chr(number) if is_character else "�"
        return _ESCAPES.get(code, code)

    return _ESCAPE.sub(character, text[1:-1])


def comment_lines(text: str) -> list[str]:
    """Return the lines of a comment without its marks."""
    if text.startswith("//"):
        return [text[2:].strip()]
    lines = [line.strip().lstrip("*").strip() for line in text[2:-2].splitlines()]
    return [line for line in lines if line]


# --- parsing ---------------------------------------------------------------------------------------------------------


_LEVELS = {
    "||": 1, "&&": 2, "==": 3, "!=": 3, "<": 4, ">": 4, "<=": 4, ">=": 4, "+": 5, "-": 5, "*": 6, "/": 6, "%": 6,
}  # fmt: skip
_UNARY, _POWER = 7, 8
_CHAINS = ("+", "*", "&&", "||")
_COORDINATES = {"x": 0, "y": 1, "z": 2}
_ABSENT = {
    "surface": "height maps", "import": "files", "import_dxf": "files", "import_stl": "files", "dxf_cross": "files",
    "dxf_dim": "files", "dxf_linear_extrude": "files", "dxf_rotate_extrude": "files",
}  # fmt: skip


def parse(text: str, name: str) -> tuple[Statement, ...]:
    """Return the statements of a program; raises SceneError with the place of the first mistake."""
    source = Source(name, text)
    if len(text) > MAX_SIZE:
        failure(Span(source, 0, 1), f"the program has {len(text):,} characters, more than {MAX_SIZE:,}")
    return _Parser(source).program()


class _Parser:
    """Recursive descent with one token of lookahead."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._tokens: list[ScadToken] = []
        self._comments: dict[int, list[ScadToken]] = {}  # by the index of the token behind
        for token in _tokens(source):
            if token.kind == "comment":
                self._comments.setdefault(len(self._tokens), []).append(token)
            else:
                self._tokens.append(token)
            if len(self._tokens) > MAX_TOKENS:
                failure(self._span(token.start, token.start + 1), f"the program has more than {MAX_TOKENS:,} tokens")
        self._at = 0
        self._depth = 0

    # --- tools -------------------------------------------------------------------------------------------------------

    def _span(self, start: int, end: int) -> Span:
        return Span(self._source, start, max(end, start + 1))

    def _since(self, start: int) -> Span:
        last = self._tokens[max(self._at - 1, 0)]
        return self._span(start, last.start + len(last.text))

    @property
    def _token(self) -> ScadToken:
        return self._tokens[self._at]

    def _next(self) -> ScadToken:
        token = self._tokens[self._at]
        self._at = min(self._at + 1, len(self._tokens) - 1)
        return token

    def _takes(self, kind: str) -> bool:
        if self._token.kind != kind:
            return False
        self._next()
        return True

    def _is_word(self, word: str, ahead: int = 0) -> bool:
        token = self._tokens[min(self._at + ahead, len(self._tokens) - 1)]
        return token.kind == "name" and token.text == word

    def _takes_word(self, word: str) -> bool:
        if not self._is_word(word):
            return False
        self._next()
        return True

    def _expect(self, kind: str) -> ScadToken:
        token = self._token
        if token.kind != kind:
            shown = "the end of the file" if token.kind == "end" else f"`{token.text[:30]}`"
            wanted = "a name" if kind == "name" else f"`{kind}`"
            failure(self._span(token.start, token.start + len(token.text)), f"expected {wanted}, got {shown}")
        return self._next()

    def _enter(self, levels: int = 1) -> None:
        self._depth += levels
        if self._depth > MAX_NESTING:
            start = self._token.start
            failure(self._span(start, start + 1), f"nested more than {MAX_NESTING} levels deep", "use variables")

    # --- statements --------------------------------------------------------------------------------------------------

    def program(self) -> tuple[Statement, ...]:
        statements = self._statements("end")
        return tuple(statements)

    def _statements(self, end: str) -> list[Statement]:
        statements: list[Statement] = []
        while self._token.kind != end:
            if not self._takes(";"):
                statements += self._statement()
        self._next()
        return statements

    def _comments_before(self) -> tuple[str, ...]:
        """Return the comments between the statement before and this one, and forget them."""
        lines: list[str] = []
        for token in self._comments.pop(self._at, ()):
            lines += comment_lines(token.text)
        return tuple(lines)

    def _comment_behind(self) -> tuple[str, ...]:
        """Return a comment that follows on the same line."""
        waiting = self._comments.get(self._at)
        if not waiting or not self._at:
            return ()
        last = self._tokens[self._at - 1]
        if "\n" in self._source.text[last.start + len(last.text) : waiting[0].start]:
            return ()
        return tuple(comment_lines(waiting.pop(0).text))

    def _statement(self) -> list[Statement]:
        """Return the next statement; a block stands for an instance of ``union``."""
        comments, token = self._comments_before(), self._token
        self._enter()
        try:
            if token.kind == "path":
                unsupported(
                    self._span(token.start, token.start + len(token.text)), f"`{token.text[:60]}`: files are not read",
                    "paste the modules and functions that it uses into this file",
                )  # fmt: skip
            if self._takes_word("module"):
                return [self._module(token.start, comments)]
            if self._is_word("function"):
                return [self._function(comments)]
            if token.kind == "name" and self._tokens[self._at + 1].kind == "=":
                return [self._assignment(comments)]
            return [self._instance(comments)]
        finally:
            self._depth -= 1

    def _assignment(self, comments: tuple[str, ...]) -> ScadAssignment:
        start, name = self._token.start, self._next().text
        self._next()
        value = self._expression()
        self._expect(";")
        return ScadAssignment(self._since(start), name, value, comments + self._comment_behind())

    def _module(self, start: int, comments: tuple[str, ...]) -> ModuleDefinition:
        name = self._expect("name").text
        parameters = self._parameters()
        body = self._body()
        return ModuleDefinition(self._since(start), name, parameters, tuple(body), comments)

    def _function(self, comments: tuple[str, ...]) -> FunctionDefinition:
        start = self._next().start
        name = self._expect("name").text
        parameters = self._parameters()
        self._expect("=")
        body = self._expression()
        self._expect(";")
        return FunctionDefinition(self._since(start), name, parameters, body, comments + self._comment_behind())

    def _parameters(self) -> tuple[ScadParameter, ...]:
        self._expect("(")
        parameters: list[ScadParameter] = []
        while not self._takes(")"):
            start, name = self._token.start, self._expect("name").text
            default = self._expression() if self._takes("=") else None
            if any(each.name == name for each in parameters):
                failure(self._since(start), f"the parameter `{name}` occurs twice")
            parameters.append(ScadParameter(self._since(start), name, default))
            if not self._takes(","):
                self._expect(")")
                break
        return tuple(parameters)

    def _body(self) -> list[Statement]:
        """Return the statements of a module: a block, or one statement."""
        if self._takes("{"):
            return self._statements("}")
        return [] if self._takes(";") else self._statement()

    def _instance(self, comments: tuple[str, ...]) -> Instance | Branch:
        start, modifiers = self._token.start, ""
        while self._token.kind in ("!", "#", "%", "*"):
            modifiers += self._next().kind
        if self._takes("{"):
            inside = self._statements("}")
            return Instance(self._since(start), "union", (), tuple(inside), modifiers, comments)
        if self._takes_word("if"):
            return self._branch(start, modifiers, comments)
        name = self._expect("name")
        if name.text in _ABSENT:
            unsupported(
                self._span(name.start, name.start + len(name.text)), f"`{name.text}`: no {_ABSENT[name.text]} are read"
            )
        arguments = self._arguments()
        children = self._children()
        return Instance(
            self._since(start), name.text, arguments, children, modifiers, comments + self._comment_behind()
        )

    def _children(self) -> tuple[Statement, ...]:
        if self._takes(";"):
            return ()
        if self._takes("{"):
            return tuple(self._statements("}"))
        return tuple(self._statement())

    def _branch(self, start: int, modifiers: str, comments: tuple[str, ...]) -> Branch:
        self._expect("(")
        test = self._expression()
        self._expect(")")
        yes = self._children()
        no = self._children() if self._takes_word("else") else ()
        return Branch(self._since(start), test, yes, no, modifiers, comments)

    def _arguments(self) -> tuple[Argument, ...]:
        self._expect("(")
        arguments: list[Argument] = []
        while not self._takes(")"):
            name = None
            if self._token.kind == "name" and self._tokens[self._at + 1].kind == "=":
                name = self._next().text
                self._next()
            arguments.append(Argument(name, self._expression()))
            if not self._takes(","):
                self._expect(")")
                break
        return tuple(arguments)

    # --- expressions -------------------------------------------------------------------------------------------------

    def _expression(self) -> Expr:
        """Return an expression, with ``let``, ``assert``, ``echo`` and functions in front of it."""
        self._enter()
        try:
            start = self._token.start
            if self._token.kind == "name" and (self._tokens[self._at + 1].kind == "("):
                special = self._prefixed(start)
                if special is not None:
                    return special
            test = self._operations(1)
            if not self._takes("?"):
                return test
            yes = self._expression()
            self._expect(":")
            no = self._expression()
            return Operation(self._since(start), "?", (test, yes, no))
        finally:
            self._depth -= 1

    def _prefixed(self, start: int) -> Expr | None:
        word = self._token.text
        if word == "function":
            self._next()
            parameters = self._parameters()
            return FunctionValue(self._since(start), parameters, self._expression())
        if word == "let":
            self._next()
            bindings = self._bindings()
            return Let(self._since(start), bindings, self._expression())
        if word in ("assert", "echo"):
            self._next()
            arguments = self._arguments()
            has_body = self._token.kind not in (";", ",", ")", "]", ":", "end")
            return ScadCheck(self._since(start), word == "assert", arguments, self._expression() if has_body else None)
        return None

    def _bindings(self) -> tuple[Argument, ...]:
        start, bindings = self._token.start, self._arguments()
        if not all(each.name for each in bindings):
            failure(self._since(start), "expected `name = value`")
        return bindings

    def _operations(self, level: int) -> Expr:
        """Return operations of at least this level, by precedence climbing."""
        start, entered, chain = self._token.start, 0, ""
        left = self._unary()
        while (precedence := _LEVELS.get(self._token.kind, 0)) >= level:
            operator = self._next().kind
            right = self._operations(precedence + 1)
            if operator == chain and operator in _CHAINS:
                assert isinstance(left, Operation)
                left = Operation(self._since(start), operator, (*left.operands, right))
            else:
                left = Operation(self._since(start), operator, (left, right))
                entered += 1
                self._enter()
            chain = operator
        self._depth -= entered
        return left

    def _unary(self) -> Expr:
        start = self._token.start
        if self._token.kind in ("-", "+", "!"):
            operator = self._next().kind
            self._enter()
            value = self._unary()
            self._depth -= 1
            return value if operator == "+" else Operation(self._since(start), f"unary {operator}", (value,))
        base = self._postfix()
        if not self._takes("^"):
            return base
        self._enter()
        power = self._unary()
        self._depth -= 1
        return Operation(self._since(start), "^", (base, power))

    def _postfix(self) -> Expr:
        start, value, entered = self._token.start, self._primary(), 0
        while self._token.kind in ("(", "[", "."):
            entered += 1
            self._enter()
            value = self._applied(start, value)
        self._depth -= entered
        return value

    def _applied(self, start: int, value: Expr) -> Expr:
        if self._token.kind == "(":
            arguments = self._arguments()
            return ScadCall(self._since(start), value, arguments)
        if self._takes("["):
            index = self._expression()
            self._expect("]")
            return ItemAt(self._since(start), value, index)
        self._next()
        name = self._expect("name")
        if name.text not in _COORDINATES:
            failure(
                self._span(name.start, name.start + len(name.text)), f"expected `.x`, `.y` or `.z`, got `.{name.text}`"
            )
        number = _COORDINATES[name.text]
        return ItemAt(self._since(start), value, ConstantValue(self._since(start), float(number), str(number)))

    def _primary(self) -> Expr:
        """Return a literal, a variable, a list, a range, or an expression in parentheses."""
        token = self._token
        span = self._span(token.start, token.start + len(token.text))
        if token.kind == "number":
            self._next()
            return ConstantValue(span, float(token.text), token.text)
        if token.kind == "string":
            self._next()
            return ConstantValue(span, _unescaped(token.text))
        if token.kind == "name":
            self._next()
            constants = {"true": True, "false": False, "undef": None}
            return (
                ConstantValue(span, constants[token.text])
                if token.text in constants
                else VariableName(span, token.text)
            )
        if self._takes("("):
            inside = self._expression()
            self._expect(")")
            return inside
        if self._takes("["):
            return self._list(token.start)
        failure(span, "expected a value" if token.kind == "end" else f"expected a value, got `{token.text[:30]}`")

    def _list(self, start: int) -> Expr:
        items: list[Expr] = []
        while not self._takes("]"):
            items.append(self._item())
            if len(items) == 1 and self._takes(":"):
                return self._range(start, items[0])
            if not self._takes(","):
                self._expect("]")
                break
        return Items(self._since(start), tuple(items))

    def _range(self, start: int, first: Expr) -> Range:
        middle = self._expression()
        last = self._expression() if self._takes(":") else None
        self._expect("]")
        span = self._since(start)
        return Range(span, first, None, middle) if last is None else Range(span, first, middle, last)

    def _item(self) -> Expr:
        """Return an item of a list: a value or a comprehension."""
        self._enter()
        try:
            return self._element()
        finally:
            self._depth -= 1

    def _element(self) -> Expr:
        """Return an item of a list; the caller limits the depth of nesting."""
        start = self._token.start
        # a comprehension in parentheses is not an expression, so `_primary` cannot read it
        if self._token.kind == "(" and self._tokens[self._at + 1].text in ("for", "each", "if", "let"):
            self._next()
            inside = self._item()
            self._expect(")")
            return inside
        if self._takes_word("each"):
            return Each(self._since(start), self._item())
        if self._takes_word("for"):
            return self._loop(start)
        if self._takes_word("if"):
            self._expect("(")
            test = self._expression()
            self._expect(")")
            yes = self._item()
            no = self._item() if self._takes_word("else") else None
            return ItemCondition(self._since(start), test, yes, no)
        if self._is_word("let") and self._tokens[self._at + 1].kind == "(":
            self._next()
            bindings = self._bindings()
            return Let(self._since(start), bindings, self._item())
        return self._expression()

    def _loop(self, start: int) -> Expr:
        opening = self._at
        depth = 0
        for ahead in range(opening, len(self._tokens)):  # `for (i = 0; i < n; i = i + 1)` has semicolons inside
            kind = self._tokens[ahead].kind
            depth += (kind in ("(", "[")) - (kind in (")", "]"))
            if kind == ";" and depth:
                unsupported(
                    self._since(start), "`for (a = ...; test; ...)` in a list", "use a range or a recursive function"
                )
            if depth <= 0:
                break
        bindings = self._bindings()
        return ItemLoop(self._since(start), bindings, self._item())


def assigned(statements: Sequence[Statement]) -> dict[str, ScadAssignment]:
    """Return the assignments of a scope: each name at its first place, with its last value."""
    assignments: dict[str, ScadAssignment] = {}
    for each in statements:
        if isinstance(each, ScadAssignment):
            before = assignments.get(each.name)
            comments = each.comments if before is None else (*before.comments, *each.comments)
            assignments[each.name] = ScadAssignment(each.span, each.name, each.value, comments)
    return assignments


# --- what statements do ----------------------------------------------------------------------------------------------


def uses_children(tree: object) -> bool:
    """Return whether a module's body mentions its children."""
    stack = [tree]
    while stack:
        each = stack.pop()
        if isinstance(each, tuple):
            stack += each
        elif (isinstance(each, Instance) and each.name == "children") or (
            isinstance(each, VariableName) and each.name == "$children"
        ):
            return True
        elif hasattr(each, "__match_args__") and not isinstance(each, Span):
            stack += [getattr(each, name) for name in each.__match_args__ if name not in ("span", "comments")]
    return False


def _known_number(expr: Expr) -> float | None:
    """Return the number that an expression is written as, perhaps with a sign."""
    if isinstance(expr, Operation) and expr.operator == "unary -":
        number = _known_number(expr.operands[0])
        return None if number is None else -number
    return expr.value if isinstance(expr, ConstantValue) and isinstance(expr.value, float) else None


def runs(argument: Argument) -> bool:
    """Return whether a loop runs at least once for certain."""
    value = argument.value
    if isinstance(value, Items):
        return any(isinstance(each, ConstantValue | Items) for each in value.items)
    if not isinstance(value, Range):
        return False
    if value.step is not None:
        first, step, last = map(_known_number, (value.first, value.step, value.last))
        return None not in (first, step, last) and (last - first) * step >= 0  # type: ignore[operator]
    return True  # `[0 : n - 1]`: taken to run, so that programs stay short
