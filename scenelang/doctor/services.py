"""Services that commands may ask: whether there is a key for each family of language models. Nothing is sent."""

from __future__ import annotations

from collections.abc import Iterator

from scenelang.backends.language_models.provider import FAMILIES, connection
from scenelang.doctor.check import Check, State
from scenelang.grammar.diagnostics import SceneError


def service_checks() -> Iterator[Check]:
    """A finding for each provider: its address and whether it has a key."""
    for family in FAMILIES:
        try:
            found = connection(family)
        except SceneError as error:
            yield Check("services", family.name, State.MISSING, error.message, error.hint or "")
            continue
        key = "a key" if found.key is not None else "no key"
        yield Check("services", family.name, State.NOTE, f"{key} for {found.shown_address}; not asked")
