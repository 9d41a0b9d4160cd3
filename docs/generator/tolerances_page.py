"""The page of tolerances: every constant of the facts, with its unit and reason."""

from __future__ import annotations

from generator.markdown import NOTICE, table
from scenelang.backends.facts import tolerances
from scenelang.backends.facts.tolerances import Tolerance


def tolerances_page() -> str:
    """Return the table of constants, Markdown."""
    rows = [
        (f"`{name}`", f"{value:.4g}", value.unit, value.reason)
        for name, value in vars(tolerances).items()
        if isinstance(value, Tolerance)
    ]
    lines = [
        NOTICE,
        "# Tolerances",
        "",
        "The constants of the [facts of a scene](../facts.md), and of the checks that read them.",
        "",
        *table(("name", "value", "unit", "reason"), rows),
    ]
    return "\n".join(lines) + "\n"
