"""Whether files have changed since they were looked at."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass

Stamp = tuple[int, int, int] | None  # time of change, size, inode; None where there is no such file


@dataclass(frozen=True, slots=True)
class Stamps:
    """The files that were looked at, and how they were then."""

    files: tuple[tuple[str, Stamp], ...] = ()

    def are_old(self) -> bool:
        """True when one of the files is not as it was."""
        return any(_stamp(name) != stamp for name, stamp in self.files)


def stamps_of(names: Iterable[str]) -> Stamps:
    """The stamps of files and folders as they are now."""
    return Stamps(tuple((name, _stamp(name)) for name in names))


def _stamp(name: str) -> Stamp:
    try:
        found = os.stat(name)
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
