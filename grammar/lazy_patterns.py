"""Regular expressions that are compiled when they are first used.

A command uses a few of the hundred patterns of the modules that it imports; compiling all of them took a twelfth of
``check``.
"""

from __future__ import annotations

import re
from typing import Any, cast

_METHODS = ("finditer", "findall", "fullmatch", "match", "search", "split", "sub")


class _Pattern:
    """Stands for a compiled pattern, whose methods become attributes at the first use of any of them."""

    def __init__(self, text: str, flags: int) -> None:
        self._text, self._flags = text, flags

    def __getattr__(self, name: str) -> Any:
        compiled = re.compile(self._text, self._flags)
        self.__dict__ |= {method: getattr(compiled, method) for method in _METHODS}
        return getattr(compiled, name)


def lazy_pattern(text: str, flags: int = 0) -> re.Pattern[str]:
    """Return a pattern, as ``re.compile`` does; an error in it appears at its first use."""
    return cast("re.Pattern[str]", _Pattern(text, flags))
