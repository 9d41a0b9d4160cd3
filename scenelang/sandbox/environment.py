"""Environment of processes that evaluate programs.

They have the variables of the terminal, the locale, the language and the graphics, but no keys, tokens and passwords,
whose names nobody can list. A forked process keeps the memory from which the kernel shows ``/proc/PID/environ``,
whatever becomes of ``os.environ``, so that memory is overwritten, too.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from scenelang.interpreter.values.limits import fork_safe_lock

_NAMES = """
    PATH HOME USER LOGNAME SHELL PWD LANG LANGUAGE TZ TERM COLORTERM TERM_PROGRAM COLUMNS LINES NO_COLOR FORCE_COLOR
    TMPDIR TEMP TMP DISPLAY WAYLAND_DISPLAY XAUTHORITY DBUS_SESSION_BUS_ADDRESS BROWSER EDITOR VISUAL PAGER
    KITTY_WINDOW_ID VIRTUAL_ENV LD_LIBRARY_PATH DYLD_LIBRARY_PATH SYSTEMROOT
    APPDATA LOCALAPPDATA USERPROFILE PATHEXT COMSPEC WINDIR
"""
_FAMILIES = """
    LC_ XDG_ SCENELANG_ PYTHON CUDA_ NVIDIA_ DRJIT_ MI_ MUJOCO_ PYOPENGL_ OMP_ MKL_ OPENBLAS_ NUMBA_ TORCH_ PYTORCH_
    HYPOTHESIS_ COV_ COVERAGE_ PROMPT_TOOLKIT_
"""  # beginnings of names
_ALLOWED, _BEGINNINGS = frozenset(_NAMES.split()), tuple(_FAMILIES.split())
MORE = "SCENELANG_ENVIRONMENT"  # names of other variables that plug-ins need, separated by commas


def named_variables(environment: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the environment variables that a process for evaluation may keep.

    Parameters
    ----------
    environment
        Variables to select from; by default, those of this process.

    Returns
    -------
    dict of str
        Variables on the list of this module, of its families (``LC_``, ``XDG_``, ...), or named in
        ``SCENELANG_ENVIRONMENT``.

    Examples
    --------
    >>> named_variables({"LANG": "C", "LC_ALL": "C", "ANTHROPIC_API_KEY": "secret"})
    {'LANG': 'C', 'LC_ALL': 'C'}
    """
    given = os.environ if environment is None else environment
    more = {name.strip() for name in given.get(MORE, "").split(",")}
    return {name: value for name, value in given.items() if name in _ALLOWED | more or name.startswith(_BEGINNINGS)}


def keep_named_variables() -> None:
    """Remove all environment variables from this process, except those that ``named_variables`` returns.

    On Linux, the memory from which ``/proc/PID/environ`` is read is overwritten, too.
    """
    allowed = named_variables()
    os.environ.clear()  # before the memory of the values is overwritten
    if sys.platform == "linux":
        _overwrite(b"".join(os.fsencode(f"{name}={value}") + b"\0" for name, value in allowed.items()))
    os.environ.update(allowed)


_LOCK = fork_safe_lock()
_HIDDEN: dict[str, str] = {}  # what evaluations that are running have removed; the environment is the process's, too
_USERS = [0]  # number of running evaluations


@contextmanager
def hidden_variables() -> Iterator[None]:
    """Remove the variables that an evaluation may not see, and restore them afterwards.

    This is for processes that need these variables before and after the evaluation. Evaluations may run at once in
    several threads: the last one to end restores the variables.
    """
    with _LOCK:
        _USERS[0] += 1
        if _USERS[0] == 1:
            allowed = named_variables()
            _HIDDEN.update((name, value) for name, value in os.environ.items() if name not in allowed)
            if _HIDDEN:  # most processes have removed them for good, and evaluate many times
                keep_named_variables()
    try:
        yield
    finally:
        with _LOCK:
            _USERS[0] -= 1
            if not _USERS[0]:
                os.environ.update(_HIDDEN)
                _HIDDEN.clear()


def _overwrite(block: bytes) -> None:
    """Put variables in the place of those with which the program was started."""
    import ctypes

    with open("/proc/self/stat", "rb") as file:
        fields = file.read().rpartition(b")")[2].split()  # from the third on: the second may contain spaces
    start, end = int(fields[_ENV_START - 3]), int(fields[_ENV_END - 3])
    if start and end > start:
        ctypes.memmove(start, block.ljust(end - start, b"\0")[: end - start], end - start)


_ENV_START, _ENV_END = 50, 51  # fields of /proc/PID/stat (man 5 proc)
