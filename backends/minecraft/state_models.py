"""Which models the game draws for a state of a block, from the block's definition (``blockstates/NAME.json``)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def variants(definition: Mapping[str, Any], properties: Mapping[str, str], every: bool = False) -> Iterator[Any]:
    """What is applied for a state, each with its ``model``; of all states where ``every``. Of models among which the
    game chooses by chance, the first."""
    for key, variant in definition.get("variants", {}).items():
        wanted = dict(pair.split("=", 1) for pair in key.split(",") if "=" in pair)
        if every or all(properties.get(name) == value for name, value in wanted.items()):
            yield _first(variant)
    for part in definition.get("multipart", []):
        if every or _holds(part.get("when", {}), properties):
            yield _first(part["apply"])


def _first(variant: Any) -> Any:
    return variant[0] if isinstance(variant, list) else variant


def _holds(when: Mapping[str, Any], properties: Mapping[str, str]) -> bool:
    if "OR" in when:
        return any(_holds(each, properties) for each in when["OR"])
    if "AND" in when:
        return all(_holds(each, properties) for each in when["AND"])
    return all(properties.get(key) in str(value).split("|") for key, value in when.items())
