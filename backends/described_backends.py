"""Writes ``descriptions.json``: ``python -m scenelang.backends.described_backends`` (`make descriptions`)."""

from __future__ import annotations

import json
from pathlib import Path

from scenelang.backends.base import BACKENDS, description_of
from scenelang.interpreter.loading import entry_points_of


def current_descriptions() -> dict[str, dict[str, object]]:
    """Return the descriptions of our own backends, which are imported, by the values of their entry points."""
    points = entry_points_of(BACKENDS.group).items()
    ours = {name: point for name, point in points if point.value.startswith("scenelang.")}
    return {point.value: description_of(BACKENDS.find(name)) for name, point in sorted(ours.items())}


if __name__ == "__main__":
    path = Path(__file__).with_name("descriptions.json")
    path.write_text(json.dumps(current_descriptions(), indent=1, ensure_ascii=False) + "\n", "utf-8")
