"""The grammar of programs as text, full and strict: the forms' shapes and the paper's rules in one model."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from scenelang.grammar.export.model import Expression, Grammar, Literal, Ref, choice, literals, sequence, used_terminals
from scenelang.grammar.export.notation import parse_expression, parse_rules
from scenelang.grammar.export.strict import strict_rules
from scenelang.grammar.export.tokens import tokens
from scenelang.interpreter import form_shapes

_GROUPS: Mapping[str, Mapping[str, str]] = MappingProxyType({
    "form": form_shapes.EXPRESSIONS,
    "definition": form_shapes.DEFINITIONS,
    "macro_definition": form_shapes.MACROS,
    "top_form": form_shapes.TOP_LEVEL,
})  # fmt: skip


@cache
def full_grammar() -> Grammar:
    """Programs that read and whose special forms have the right shape."""
    rules = parse_rules(form_shapes.RULES)
    for group, shapes in _GROUPS.items():
        rules |= _forms(group, shapes)
    return _grammar(rules, literals(rules), "The Scene Language")


@cache
def strict_grammar() -> Grammar:
    """Programs of exactly the paper's grammar, as ``check --strict`` has it."""
    full = full_grammar().rules
    rules = {**strict_rules(), **{name: full[name] for name in ("datum", "list", "literal")}}  # what `#;` hides
    reserved = literals(rules) | literals(full)
    return _grammar(rules, reserved, "The Scene Language, exactly the paper's grammar")


def _grammar(rules: Mapping[str, Expression], reserved: frozenset[str], title: str) -> Grammar:
    used = used_terminals(rules)
    known = {name: token for name, token in tokens(reserved).items() if name in used}
    return Grammar("start", MappingProxyType(dict(rules)), MappingProxyType(known), title)


def _forms(group: str, shapes: Mapping[str, str]) -> dict[str, Expression]:
    """A rule for each shape, named by the first form that has it, and the rule that offers them all."""
    heads: dict[str, list[str]] = {}
    for head, shape in shapes.items():
        heads.setdefault(shape, []).append(head)
    rules: dict[str, Expression] = {}
    for shape, names in heads.items():
        word = choice(*(Literal(name) for name in names))
        rules[_rule_name(names[0])] = sequence(Literal("("), word, parse_expression(shape), Literal(")"))
    return {group: choice(*(Ref(name) for name in rules)), **rules}


def _rule_name(head: str) -> str:
    """``let*-values`` as a rule's name."""
    spelled = head.replace("*", "_star").replace("!", "").replace("/", "_").replace("-", "_")
    return f"{spelled}_form"
