"""Confinement of the evaluating thread: Landlock for files and TCP, seccomp for system calls.

Both apply to one thread and the threads it starts, and are irreversible; other threads of the process can still render
and write files. References: landlock(7), seccomp(2), and the kernel's ``include/uapi/linux/landlock.h``.
"""

from __future__ import annotations

import ctypes
import os
import struct
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import user_folder

_LANDLOCK_CREATE, _LANDLOCK_ADD, _LANDLOCK_RESTRICT = 444, 445, 446  # the same on every architecture
_PR_SET_SECCOMP, _PR_SET_NO_NEW_PRIVS = 22, 38  # <linux/prctl.h>
_SECCOMP_FILTER = 2  # SECCOMP_MODE_FILTER of <linux/seccomp.h>

# LANDLOCK_ACCESS_FS_*: execute, write, read file, read folder, ...; later ABI versions define more rights.
_READ_FILE, _READ_DIR, _WRITE_FILE = 1 << 2, 1 << 3, 1 << 1
_FS_RIGHTS = {1: 13, 2: 14, 3: 15, 4: 15, 5: 16}
_NET_RIGHTS = 0b11  # bind and connect TCP, from version 4
_SCOPES = 0b01  # abstract UNIX sockets, from version 6

# SECCOMP_RET_ERRNO and SECCOMP_RET_ALLOW, errors, and opcodes of classic BPF (<linux/bpf_common.h>).
_PR_ERRNO = 0x0005_0000
_ALLOW = 0x7FFF_0000
_EPERM, _ENOSYS = 1, 38
_LD, _JEQ, _JSET, _JGE, _RET = 0x20, 0x15, 0x45, 0x35, 0x06
_CLONE_THREAD = 0x0001_0000  # <linux/sched.h>
_X32 = 0x4000_0000  # bit of the calls of the x32 ABI, which would bypass the numbers below


@dataclass(frozen=True, slots=True)
class _Architecture:
    """Architecture data of seccomp: AUDIT_ARCH_*, the denied system calls, and those that start processes."""

    audit: int
    refused: tuple[int, ...]
    clone: int
    clone3: int = 435


# Numbers from the kernel's tables: sockets, execution, signals to others, tracing, mounts and namespaces, kernel
# modules and BPF, and changes of files that Landlock does not cover (modes, owners, times, attributes).
_ARCHITECTURES = {
    "x86_64": _Architecture(
        0xC000_003E,
        (41, 42, 43, 49, 50, 53, 288, 57, 58, 59, 322, 62, 200, 129, 297, 424, 101, 310, 311, 165, 166, 161, 155, 272,
         308, 321, 323, 298, 425, 304, 248, 249, 250, 175, 313, 246, 320, 169, 167, 90, 91, 268, 92, 93, 94, 260, 132,
         235, 261, 280, 188, 189, 190, 197, 198, 199, 452, 463, 466),
        56,
    ),
    "aarch64": _Architecture(
        0xC000_00B7,
        (198, 199, 200, 201, 202, 203, 242, 221, 281, 129, 130, 138, 240, 424, 117, 270, 271, 40, 39, 51, 41, 97, 268,
         280, 282, 241, 425, 265, 217, 218, 219, 105, 273, 104, 294, 142, 224, 52, 53, 54, 55, 88, 5, 6, 7, 14, 15, 16,
         452, 463, 466),
        220,
    ),
}  # fmt: skip


@cache
def _libc() -> Any:
    """Return the C library."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    return libc


@cache
def landlock_version() -> int:
    """Return the version of the kernel's Landlock ABI, or 0 if it is not supported."""
    if not sys.platform.startswith("linux"):
        return 0
    version = _libc().syscall(_LANDLOCK_CREATE, None, ctypes.c_size_t(0), ctypes.c_uint32(1))
    return max(0, int(version))


def has_seccomp() -> bool:
    """Return whether seccomp is supported on this machine."""
    if not sys.platform.startswith("linux") or os.uname().machine not in _ARCHITECTURES:
        return False
    try:
        return "Seccomp:" in Path("/proc/self/status").read_text("ascii", "replace")
    except OSError:
        return False


def confine(folders: Iterable[str | Path]) -> None:
    """Restrict this thread to reading the package, its libraries and ``folders``.

    Restrictions that the kernel does not support are skipped; nothing is raised.
    """
    if not sys.platform.startswith("linux"):
        return
    if _libc().prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        return
    _restrict_files([*_libraries(), *folders])
    _restrict_calls()


@cache
def _libraries() -> tuple[str, ...]:
    """Return the paths that Python and its packages read at run time, and that of the solids on disk."""
    paths = [sys.prefix, sys.base_prefix, *(path or os.getcwd() for path in sys.path), str(Path(__file__).parents[2])]
    system = ("/usr/lib", "/usr/local/lib", "/lib", "/lib64", "/usr/share", "/etc/ld.so.cache", "/etc/localtime")
    with suppress(RuntimeError):  # no home folder
        paths.append(str(user_folder("CACHE") / "solids"))
    return tuple(dict.fromkeys([*paths, *system, "/proc/cpuinfo", "/proc/meminfo", "/sys/devices/system"]))


def _restrict_files(folders: Iterable[str | Path]) -> None:
    """Allow this thread to read some folders, and deny other file access and TCP, as far as the kernel supports it."""
    version = landlock_version()
    if version < 1:
        return
    rights = (1 << _FS_RIGHTS.get(version, 16)) - 1
    attributes = struct.pack("=QQQ", rights, _NET_RIGHTS if version >= 4 else 0, _SCOPES if version >= 6 else 0)
    attributes = attributes[: 8 if version < 4 else 16 if version < 6 else 24]
    ruleset = _libc().syscall(_LANDLOCK_CREATE, attributes, ctypes.c_size_t(len(attributes)), ctypes.c_uint32(0))
    if ruleset < 0:
        return
    try:
        for folder in (*folders, f"/proc/{os.getpid()}", "/dev/urandom"):
            _allow(ruleset, str(folder), _READ_FILE | _READ_DIR)
        _allow(ruleset, os.devnull, _READ_FILE | _WRITE_FILE)
        _libc().syscall(_LANDLOCK_RESTRICT, ctypes.c_int(ruleset), ctypes.c_uint32(0))
    finally:
        os.close(ruleset)


def _allow(ruleset: int, path: str, rights: int) -> None:
    """Add access rights beneath ``path``, if it exists."""
    try:
        handle = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except (OSError, ValueError):
        return
    try:
        if not os.path.isdir(path):
            rights &= ~_READ_DIR
        rule = struct.pack("=Qi", rights, handle)
        _libc().syscall(_LANDLOCK_ADD, ctypes.c_int(ruleset), ctypes.c_int(1), rule, ctypes.c_uint32(0))
    finally:
        os.close(handle)


class _Program(ctypes.Structure):
    """``struct sock_fprog``."""

    _fields_ = (("length", ctypes.c_ushort), ("filter", ctypes.c_char_p))


def _restrict_calls() -> None:
    """Deny the system calls of the architecture by a seccomp filter."""
    architecture = _ARCHITECTURES.get(os.uname().machine)
    if architecture is None:
        return
    code = b"".join(struct.pack("=HBBI", *line) for line in _filter(architecture))
    program = _Program(len(code) // 8, code)
    _libc().prctl(_PR_SET_SECCOMP, _SECCOMP_FILTER, ctypes.byref(program), 0, 0)


def _filter(architecture: _Architecture) -> list[tuple[int, int, int, int]]:
    """Build a classic BPF filter for ``struct seccomp_data``.

    In it, the system call is at 0, the architecture at 4, and the arguments begin at 16.
    """
    refuse = (_RET, 0, 0, _PR_ERRNO | _EPERM)
    lines = [(_LD, 0, 0, 4), (_JEQ, 1, 0, architecture.audit), refuse, (_LD, 0, 0, 0), (_JGE, 0, 1, _X32), refuse]
    for number in architecture.refused:
        lines += [(_JEQ, 0, 1, number), refuse]
    # clone3 is denied, since its flags are behind a pointer; glibc then falls back to clone, whose flags can be checked
    lines += [(_JEQ, 0, 1, architecture.clone3), (_RET, 0, 0, _PR_ERRNO | _ENOSYS)]
    lines += [(_JEQ, 0, 3, architecture.clone), (_LD, 0, 0, 16), (_JSET, 1, 0, _CLONE_THREAD), refuse]
    return [*lines, (_RET, 0, 0, _ALLOW)]
