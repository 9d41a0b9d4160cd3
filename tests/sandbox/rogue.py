"""The command line with one builtin more, ``(rogue what)``, which breaks every rule of builtins: it works on in C without
the meter, takes memory at once, crashes, and tries what evaluation may not do."""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from scenelang.stdlib import builtin_names, strings


def hold() -> None:
    """Keep the interpreter's lock for minutes."""
    sum(range(10**11))


def grow() -> None:
    """Take memory and the lock."""
    held = [bytearray(b"x") * 50_000_000 for _ in range(200)]
    sum(range(10**11))
    del held


def sleep() -> None:
    """Do nothing, without the lock."""
    time.sleep(3600)


def crash() -> None:
    ctypes.string_at(0)


def attempt(action: Any) -> str:
    try:
        action()
    except OSError as error:
        return f"refused: {error.strerror}"
    return "done"


def fork() -> None:
    if os.fork() == 0:
        os._exit(0)


def kill_parent() -> None:
    os.kill(os.getppid(), signal.SIGTERM)


ATTEMPTS = {
    "write": lambda: Path("written.txt").write_text("x"),
    "append": lambda: open("prog.scene", "a").close(),
    "delete": lambda: os.unlink("victim.txt"),
    "rename": lambda: os.rename("victim.txt", "other.txt"),
    "truncate": lambda: os.truncate("victim.txt", 0),
    "mode": lambda: os.chmod("victim.txt", 0o777),
    "folder": lambda: os.mkdir("new"),
    "link": lambda: os.symlink("/etc", "link"),
    "read": lambda: Path("/etc/passwd").read_text(),
    "read above": lambda: Path("../secret.txt").read_text(),
    "read here": lambda: Path("victim.txt").read_text(),
    "socket": lambda: socket.socket().close(),
    "pair": lambda: socket.socketpair()[0].close(),
    "execute": lambda: subprocess.run(["/bin/true"], check=True),
    "replace": lambda: os.execv("/bin/true", ["true"]),
    "fork": fork,
    "signal": kill_parent,
}


builtin_names.NAMES["strings.registry"].append("rogue")


@strings.registry.define("rogue", "what::String", "Any", "Breaks the rules.")
def rogue(rt: Any, what: str) -> str:
    if what in ATTEMPTS:
        return attempt(ATTEMPTS[what])
    {"hold": hold, "grow": grow, "sleep": sleep, "crash": crash}[what]()
    return "done"


if __name__ == "__main__":
    from scenelang.__main__ import entry

    sys.exit(entry())
