"""Forms of a top level that goes on: what each defines, which replaces which, which are taken together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Atom, Datum, ListDatum, Symbol
from scenelang.grammar.source import Source
from scenelang.interpreter.scope import base_name
from scenelang.interpreter.top_forms import Import, TopForm

_DEFINING = frozenset(
    ["define", "define-values", "define-record", "define-syntax", "define-macro", "bind", "import", "param", "scene"]
)  # forms that may see one another when they are given together


def source_of(form: TopForm) -> Source:
    return form.datums[0].span.source


def names_of(form: TopForm) -> set[str]:
    """The names that a form defines and the words that it binds; words in quotes."""
    bound = form.scan.record.bound if form.scan is not None and not form.imports else {}
    return {base_name(symbol) for symbol in bound} | {f'"{word}"' for word, _ in form.words}


def fresh(form: TopForm) -> TopForm:
    """The form as it was read."""
    return TopForm(form.datums, form.read)


def replaces(new: TopForm, old: TopForm, defined: set[str]) -> bool:
    """Whether all that an old form made is made by a new one."""
    if new.scene is not None and old.scene is not None:
        return True
    if new.imports or old.imports:
        return bool(new.imports and old.imports) and _text(new) == _text(old)
    made = names_of(old)
    return bool(made) and made <= defined


def is_assignment(form: TopForm) -> bool:
    """Whether a form is ``(define name value)``, which can be said again as ``(set! name value)``."""
    datum = form.datums[0]
    return (
        len(form.datums) == 1
        and isinstance(datum, ListDatum)
        and len(datum.items) == 3
        and datum.items[0].span.text == "define"
        and isinstance(datum.items[1], Atom)
    )


def computes(form: TopForm) -> bool:
    """Whether evaluating a form runs anything: not for functions, macros and records."""
    trees = [tree for tree in form.asts if not isinstance(tree, Import)]
    head = form.datums[0].items[0] if isinstance(form.datums[0], ListDatum) and form.datums[0].items else None
    is_record = head is not None and head.span.text == "define-record"
    return not is_record and not all(makes_function(tree) for tree in trees)


def _text(form: TopForm) -> str:
    return " ".join(datum.span.text for datum in form.datums)


def makes_function(tree: Any) -> bool:
    value = tree.value if type(tree) is ast.Define else tree.function if type(tree) is ast.Bind else None
    return type(value) is ast.Lambda


def groups(forms: Sequence[TopForm]) -> Iterator[list[TopForm]]:
    """Definitions that stand side by side and define different names; every other form alone."""
    group: list[TopForm] = []
    names: set[str] = set()
    for form in forms:
        name = _defined_name(form.datums[0])
        if name is None or name in names:
            if group:
                yield group
            group, names = [], set()
        if name is None:
            yield [form]
        else:
            group.append(form)
            names.add(name)
    if group:
        yield group


def _defined_name(datum: Datum) -> str | None:
    """What a form seems to define, None for an expression."""
    if not isinstance(datum, ListDatum) or len(datum.items) < 2:
        return None
    head, target = datum.items[0], datum.items[1]
    if not isinstance(head, Atom) or str(head.value) not in _DEFINING or not isinstance(head.value, Symbol):
        return None
    while isinstance(target, ListDatum) and target.items:
        target = target.items[0]
    return str(target.span.text)


def placed(forms: Sequence[TopForm], form: TopForm) -> list[TopForm]:
    """The forms that made what there is, with a new one among them, so that they make it again in their order.

    What computes nothing by itself (functions, macros, records) takes the place of what it replaces. A value comes
    last; if something was computed since the old value was, which may have used it, both stay.
    """
    defined = names_of(form)
    replaced = [i for i, old in enumerate(forms) if replaces(form, old, defined)]
    if replaced and is_assignment(form) and any(computes(old) for old in forms[replaced[-1] + 1 :]):
        replaced = []
    kept = [old for i, old in enumerate(forms) if i not in replaced]
    kept.insert(replaced[0] if replaced and not computes(form) else len(kept), form)
    return kept
