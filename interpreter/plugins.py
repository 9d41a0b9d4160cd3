"""The entry points of installed packages: how packages add primitives, backends, providers and qualities."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def entry_points_of(group: str) -> Mapping[str, EntryPoint]:
    """The entry points of ``group`` by name; the first package on ``sys.path`` wins. Loads none of them.

    They are looked up once for each ``sys.path``: ``forget`` lets packages be seen that were installed meanwhile.
    """
    path = tuple(sys.path)
    return _points(group, path) if _is_named(group, path) else {}


@cache
def _is_named(group: str, path: tuple[str, ...]) -> bool:
    """Whether a package names the group: ``importlib.metadata`` is slow to import, and most have no group of ours."""
    return any(f"[{group}]" in text for folder in path for text in _entry_point_files(folder))


@cache
def _entry_point_files(folder: str) -> tuple[str, ...]:
    """The texts of ``entry_points.txt`` of the packages in ``folder``."""
    try:
        found = [entry.path for entry in os.scandir(folder or ".") if entry.name.endswith((".dist-info", ".egg-info"))]
    except OSError:
        return ()
    return tuple(filter(None, (_text(os.path.join(path, "entry_points.txt")) for path in found)))


def _text(path: str) -> str:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read()
    except OSError:
        return ""


@cache
def _points(group: str, path: tuple[str, ...]) -> Mapping[str, EntryPoint]:
    from importlib.metadata import entry_points

    points: dict[str, EntryPoint] = {}
    for point in entry_points(group=group):
        points.setdefault(point.name, point)
    return points


def forget() -> None:
    """Look for packages again."""
    _is_named.cache_clear()
    _entry_point_files.cache_clear()
    _points.cache_clear()
