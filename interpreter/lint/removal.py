"""When a piece of program may be taken out without a change of what the program does."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Datum, ListDatum, subdatums
from scenelang.grammar.diagnostics import Fix, SceneError
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.analyse import children
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.scope import Variable

if TYPE_CHECKING:
    from scenelang.interpreter.program import Program


def written_nodes(form: Any) -> Iterator[Any]:
    """The nodes of a form that stand in the text for themselves: what a macro was given may be used for anything."""
    stack = [form]
    while stack:
        node = stack.pop()
        if node.span.expansion is None:
            yield node
            stack.extend(children(node))


def is_inert(node: Any, ready: Collection[Any] = ()) -> bool:
    """Whether evaluating an expression does nothing, cannot fail, and draws nothing. ``ready``: variables of bodies
    that have their values by then."""
    kind = type(node)
    if kind is ast.Constant or kind is ast.Lambda:
        return True
    if kind is ast.Reference:
        target = node.target
        return isinstance(target, Builtin) or target in ready or (isinstance(target, Variable) and not target.recursive)
    return kind is ast.ArrayLiteral and all(
        type(item) is ast.Constant and type(item.value) in (int, float) for item in node.items
    )


def keeps_root(fix: Fix, program: Program) -> bool:
    """Whether a fix leaves alone which word is the root: where no form says so, the one that nothing mentions."""
    if program.scene is not None:
        return True
    for edit in fix.edits:
        before = edit.span.text
        if "\\" in before or any(before.count(f'"{w}"') > edit.text.count(f'"{w}"') for w in program.all_words):
            return False
    return True


def is_followed(form: Any, span: Span) -> bool:
    """Whether another form, which is no string, follows the one at ``span`` in the same parentheses."""
    found = _list_around(form.span, span)
    if found is None:
        return False
    items = found.items
    position = next(i for i, item in enumerate(items) if item.span.start == span.start - form.span.start)
    if position + 1 >= len(items) or found.tail is not None:
        return False
    following = items[position + 1]
    return isinstance(following, ListDatum) or type(getattr(following, "value", "")) is not str


def _list_around(outer: Span, inner: Span) -> ListDatum | None:
    """The list whose direct item stands at ``inner``."""
    try:
        forms = read(Source("<form>", outer.text)).forms
    except SceneError:
        return None
    wanted = inner.start - outer.start
    stack: list[Datum] = list(forms)
    while stack:
        datum = stack.pop()
        if isinstance(datum, ListDatum) and any(item.span.start == wanted for item in datum.items[1:]):
            return datum
        stack.extend(part for part in subdatums(datum) if part.span.start <= wanted < part.span.end)
    return None


def spaced(span: Span, text: str) -> str | None:
    """``text`` to stand at ``span``, apart from its neighbours; None where it would join a prefix before it."""
    around = span.source.text
    before, after = around[: span.start][-1:], around[span.end : span.end + 1]
    if before == "," and text.startswith("@"):
        return None
    lead = " " if before and before not in " \t\r\n([{'`,@" else ""
    trail = " " if after and after not in " \t\r\n)]};" else ""
    return f"{lead}{text}{trail}" if text else " " if lead and trail else ""
