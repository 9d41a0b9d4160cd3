"""How the uses of a text's macros are indented, learnt from the macros' definitions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from scenelang.grammar.datum import Atom, Datum, ListDatum, Symbol, walk
from scenelang.grammar.layout_rules import head_of

_BODY_NAMES = frozenset(("body", "bodies", "forms", "expressions", "statements", "clauses", "rows"))


def learnt_indents(forms: Iterable[Datum], indents: Mapping[str, int | None]) -> dict[str, int | None]:
    """``indents`` with the macros that ``forms`` define, wherever they stand. A macro whose rule ends in a body
    (``body ...``, or a rest parameter) has the operands before it on the head's line. A macro without one is like an
    ordinary function, even where a form has its name."""
    known = dict(indents)
    for datum in walk(*forms):
        if not isinstance(datum, ListDatum):
            continue
        head, items = head_of(datum), datum.items
        if head == "define-syntax" and len(items) == 3:
            _learn(known, _symbol(items[1]), _rules_indent(items[2], indents))
        elif head == "define-macro" and len(items) > 2 and isinstance(items[1], ListDatum) and items[1].items:
            rest = items[1].tail is not None
            _learn(known, _symbol(items[1].items[0]), len(items[1].items) - 1 if rest else None)
        elif head in ("let-syntax", "letrec-syntax") and len(items) > 1 and isinstance(items[1], ListDatum):
            for binding in items[1].items:
                if isinstance(binding, ListDatum) and len(binding.items) == 2:
                    _learn(known, _symbol(binding.items[0]), _rules_indent(binding.items[1], indents))
    return known


def _learn(known: dict[str, int | None], name: str | None, indent: int | None) -> None:
    if name is None:
        return
    if indent is None:
        known.pop(name, None)
    else:
        known[name] = indent


def _symbol(datum: Datum) -> str | None:
    return str(datum.value) if isinstance(datum, Atom) and type(datum.value) is Symbol else None


def _rules_indent(rules: Datum, indents: Mapping[str, int | None]) -> int | None:
    """Operands on the head's line for a macro of ``syntax-rules``, by its rule with the most; None: no body."""
    if not isinstance(rules, ListDatum) or head_of(rules) != "syntax-rules" or len(rules.items) < 3:
        return None
    named = _symbol(rules.items[1])
    ellipsis = named or "..."
    found = [_rule_indent(rule, ellipsis, indents) for rule in rules.items[3 if named else 2 :]]
    return max((indent for indent in found if indent is not None), default=None)


def _rule_indent(rule: Datum, ellipsis: str, indents: Mapping[str, int | None]) -> int | None:
    if not isinstance(rule, ListDatum) or len(rule.items) != 2 or not isinstance(rule.items[0], ListDatum):
        return None
    pattern, template = rule.items
    if pattern.tail is not None:
        variable, before = pattern.tail, len(pattern.items) - 1
    elif len(pattern.items) > 2 and _symbol(pattern.items[-1]) == ellipsis:
        variable, before = pattern.items[-2], len(pattern.items) - 3
    else:
        return None
    name = _symbol(variable)
    if name is None:  # such as `(key value) ...`: clauses
        return before
    return before if name in _BODY_NAMES or _is_body(name, template, indents) else None


def _is_body(name: str, template: Datum, indents: Mapping[str, int | None]) -> bool:
    """Whether a template puts a variable where a form has its body."""
    for datum in walk(template):
        if isinstance(datum, ListDatum):
            indent = indents.get(head_of(datum) or "")
            parts = [*datum.items, *([datum.tail] if datum.tail is not None else [])]
            if indent is not None and any(_symbol(part) == name for part in parts[1 + indent :]):
                return True
    return False
