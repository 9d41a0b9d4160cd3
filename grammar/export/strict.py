"""The paper's grammar over text, from the strict rules of ``core.lark``."""

from __future__ import annotations

from importlib import resources

from scenelang.grammar.core import STRICT_HEADS, STRICT_MEASURES, STRICT_OPERATORS
from scenelang.grammar.export.model import Expression, Literal, Ref, Terminal, choice
from scenelang.grammar.export.notation import parse_expression, parse_rules, substitute

_BRACKETS = {"LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]"}


def strict_rules() -> dict[str, Expression]:
    """Every rule of the strict language by name, its terminals spelled out as they stand in a program."""
    text = resources.files("scenelang.grammar").joinpath("core.lark").read_text(encoding="utf-8")
    rules = parse_rules(text[text.index("strict_start:") :])
    rules["start"] = rules.pop("strict_start")
    heads = {terminal: head for head, terminal in STRICT_HEADS.items()} | _BRACKETS
    spelled: dict[str, Expression] = {terminal: Literal(text) for terminal, text in heads.items()}
    spelled |= {"OPERATOR": Ref("operator"), "MEASURE": Ref("measure"), "PARAMETER": Ref("parameter")}
    value = rules.pop("strict_value")
    rules = {name: substitute(expression, spelled) for name, expression in rules.items()}
    rules["strict_value"] = substitute(value, {**spelled, "PARAMETER": Terminal("NAME")})  # where none has a type
    rules["operator"] = choice(*(Literal(word) for word in sorted(STRICT_OPERATORS)))
    rules["measure"] = choice(*(Literal(word) for word in sorted(STRICT_MEASURES)))
    rules["parameter"] = parse_expression("NAME | ANNOTATED")
    return rules
