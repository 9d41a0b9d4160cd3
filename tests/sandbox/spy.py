"""The command line with one builtin more, ``(spy go)``: it looks for the canary among the variables of its process and
those above it, names its thread after where it found it, and waits until there is a file ``go``."""

from __future__ import annotations

import ctypes
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from scenelang.stdlib import builtin_names, strings

CANARY = "canary-of-the-tests"
_PR_SET_NAME = 15


def _places() -> Iterator[tuple[str, bytes]]:
    """What a builtin can read, by a letter: Python's variables, C's, the kernel's of this process and of others."""
    libc = ctypes.CDLL(None)
    libc.getenv.restype = ctypes.c_char_p
    yield "P", repr(dict(os.environ)).encode()
    yield "C", libc.getenv(b"ANTHROPIC_API_KEY") or b""
    pids = [os.getppid(), 1, *range(os.getpid() - 5, os.getpid())]
    for letter, path in (("S", "/proc/self/environ"), *(("O", f"/proc/{pid}/environ") for pid in pids)):
        try:
            yield letter, Path(path).read_bytes()
        except OSError:
            pass


def spy(rt: Any, go: str) -> int:
    found = sorted({letter for letter, text in _places() if CANARY.encode() in text})
    ctypes.CDLL(None).prctl(_PR_SET_NAME, f"spy-{''.join(found)}".encode(), 0, 0, 0)
    while not os.path.exists(go):
        time.sleep(0.005)
    return 1


if not __package__:  # in a process of its own: what the tests import changes no library
    builtin_names.NAMES["strings.registry"].append("spy")
    strings.registry.define("spy", "go::String", "Integer", "Looks for the canary.")(spy)

if __name__ == "__main__":
    from scenelang.__main__ import entry

    sys.exit(entry())
