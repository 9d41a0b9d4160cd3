"""Packages that take seconds to import, which only the tests that use them should wait for."""

from __future__ import annotations

from typing import Any

import pytest

_ASKED_OF_ALL = ("pytestmark", "_mock_name")  # pytest looks for these in everything that a module holds


class _Later:
    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("__") or attribute in _ASKED_OF_ALL:
            raise AttributeError(attribute)
        return getattr(pytest.importorskip(self._name), attribute)


def later(name: str) -> Any:
    """A module that is imported where something is first asked of it; a test that asks where it is absent is skipped."""
    return _Later(name)
