"""On ``PYTHONPATH``: hides the modules of ``SCENELANG_TEST_HIDDEN`` from a process and its children, as if not installed."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

HIDDEN = frozenset(filter(None, os.environ.get("SCENELANG_TEST_HIDDEN", "").split(",")))


class Hiding:
    """Finder before all others, for which hidden packages do not exist."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name.partition(".")[0] in HIDDEN:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return None


sys.meta_path.insert(0, Hiding)  # type: ignore[arg-type]
