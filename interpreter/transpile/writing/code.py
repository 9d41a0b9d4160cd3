"""The program under construction: like datums, but variables have no names yet and comments hang on their places."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from scenelang.grammar.source import Span
    from scenelang.interpreter.transpile.analysis.scopes import Variable


class Code:
    """A node. ``span`` is its place in the Python; ``before``, ``after`` and ``blank`` are comments and spacing."""

    __slots__ = ("after", "before", "blank", "span")

    def __init__(self, span: Span | None) -> None:
        self.span = span
        self.before: tuple[str, ...] = ()
        self.after: str | None = None
        self.blank = False


class Literal(Code):
    """A number, string, Boolean or ``none``; ``text`` keeps the spelling of a number."""

    __slots__ = ("text", "value")

    def __init__(self, value: Any, span: Span | None = None, text: str | None = None) -> None:
        super().__init__(span)
        self.value = value
        self.text = text


class Name(Code):
    """A name of the language: a form's head, a builtin, a keyword such as ``else``."""

    __slots__ = ("text",)

    def __init__(self, text: str, span: Span | None = None) -> None:
        super().__init__(span)
        self.text = text


class Key(Code):
    """``:name`` of the library."""

    __slots__ = ("text",)

    def __init__(self, text: str, span: Span | None = None) -> None:
        super().__init__(span)
        self.text = text


class Ref(Code):
    """A variable of the Python program, read or bound; ``is_keyword`` prints it as ``:name``."""

    __slots__ = ("is_keyword", "variable")

    def __init__(self, variable: Variable, span: Span | None = None, is_keyword: bool = False) -> None:
        super().__init__(span)
        self.variable = variable
        self.is_keyword = is_keyword


class ArgumentName(Code):
    """``:name`` of a keyword argument; it is spelled as the parameters of that name are."""

    __slots__ = ("python",)

    def __init__(self, python: str, span: Span | None = None) -> None:
        super().__init__(span)
        self.python = python


class Form(Code):
    """``(a b c)``; ``rest`` is what stands behind a dot, in a list of parameters."""

    __slots__ = ("items", "rest")

    def __init__(self, items: Sequence[Code], span: Span | None = None, rest: Code | None = None) -> None:
        super().__init__(span)
        self.items = list(items)
        self.rest = rest


def lambda_list(parameters: Form) -> Code:
    """What stands behind ``lambda``: a list, or the name of the rest where there is nothing else."""
    return parameters if parameters.items or parameters.rest is None else parameters.rest


class Brackets(Code):
    """``[a b c]``."""

    __slots__ = ("items",)

    def __init__(self, items: Sequence[Code], span: Span | None = None) -> None:
        super().__init__(span)
        self.items = list(items)


Node: TypeAlias = Literal | Name | Key | Ref | ArgumentName | Form | Brackets


def children(code: Code) -> Sequence[Code]:
    """The direct parts of a node."""
    if isinstance(code, Form):
        return code.items if code.rest is None else [*code.items, code.rest]
    return code.items if isinstance(code, Brackets) else ()


def walk(*codes: Code) -> Iterator[Code]:
    """Every node below and including ``codes``, in reading order."""
    stack = list(reversed(codes))
    while stack:
        code = stack.pop()
        yield code
        if type(code) is Form or type(code) is Brackets:
            stack.extend(reversed(children(code)))


def count_refs(code: Code, variable: Variable) -> int:
    """How often ``variable`` occurs in ``code``."""
    return sum(1 for node in walk(code) if type(node) is Ref and node.variable is variable)


def replace(code: Code, match: Callable[[Code], bool], by: Code) -> bool:
    """Put ``by`` in the place of the first node inside ``code`` that matches; tells whether there was one."""
    stack: list[Code] = [code]
    while stack:
        node = stack.pop()
        if isinstance(node, (Form, Brackets)):
            for position, item in enumerate(node.items):
                if match(item):
                    move_comments(item, by)
                    node.items[position] = by
                    return True
            stack.extend(reversed(node.items))
    return False


def move_comments(source: Code, target: Code) -> None:
    """Hang the comments of ``source`` on ``target`` as well, before those that it has."""
    target.before = (*source.before, *target.before)
    if source.after:
        if target.after:
            target.before = (*target.before, source.after)
        else:
            target.after = source.after
    target.blank = source.blank or target.blank


# --- short ways to write code ----------------------------------------------------------------------------------


def form(head: str, *items: Code, span: Span | None = None) -> Form:
    """``(head item ...)``."""
    return Form([Name(head), *items], span)


def number(value: int | float, span: Span | None = None) -> Literal:
    return Literal(value, span)


def quote(code: Code, span: Span | None = None) -> Form:
    return Form([Name("quote"), code], span)


def none(span: Span | None = None) -> Literal:
    return Literal(None, span)


def is_form(code: Code, head: str) -> bool:
    """Whether ``code`` is ``(head ...)`` with a name of the language as its head."""
    return type(code) is Form and bool(code.items) and type(code.items[0]) is Name and code.items[0].text == head


def is_literal(code: Code) -> bool:
    return type(code) is Literal


def gives_parts(code: Code) -> bool:
    """Whether the value is parts already, so that a ``union`` of it alone adds nothing."""
    head = code.items[0] if isinstance(code, Form) and code.items else None
    if type(head) is not Name:
        return False
    return head.text in ("union", "union-loop", "primitives") or head.text.endswith("/union")
