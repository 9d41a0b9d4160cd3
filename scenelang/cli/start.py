"""What the installed commands call: the command line, from its first moment without a traceback.

Importing the commands takes a while, and Ctrl-C may come in the middle of it; streams may be closed from the start.
"""

from __future__ import annotations

import atexit
import os
import sys
import threading
import warnings
from signal import SIG_IGN, SIGINT, default_int_handler, getsignal, signal
from typing import NoReturn


def entry() -> NoReturn:
    """Run the command line, and end the process with its exit status."""
    heeds = getsignal(SIGINT) is default_int_handler  # not so in the background of a script
    if heeds:
        signal(SIGINT, _leave)
    _open_streams()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks, and waits
        from scenelang.cli.commands import build_parser
        from scenelang.shell_completion import complete

        complete(build_parser)
    if not sys.warnoptions:  # those of libraries are for developers; what users must know is a diagnostic
        warnings.simplefilter("ignore")
    from scenelang.cli.main import main
    from scenelang.sandbox.supervision import INTERRUPTED

    if heeds:
        signal(SIGINT, default_int_handler)
    try:
        status = main(supervised=True)
    except KeyboardInterrupt:  # between two commands' own handling of it
        _leave()
    signal(SIGINT, SIG_IGN)  # the work is done
    _end(status, waits=status != INTERRUPTED)


def _end(status: int, waits: bool) -> NoReturn:
    """End the process without giving back its memory piece by piece: after a deep recursion that takes a second, and
    threads of native libraries may still be at work, which Python's own end does not survive."""
    if waits:
        threading._shutdown()  # type: ignore[attr-defined]  # what Python's own end does first: waits for threads
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:
        status = status or 1
    os._exit(status)


def _leave(*_: object) -> NoReturn:
    os.write(2, b"interrupted\n")
    os._exit(130)


def _open_streams() -> None:
    """Nothing takes the numbers of streams that were closed, and what is written to them goes nowhere."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is None:
            try:
                os.fstat(number)
            except OSError:
                os.dup2(os.open(os.devnull, os.O_RDWR), number)
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115
