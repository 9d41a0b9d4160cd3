"""``python -m scenelang`` and the console scripts: run the command line; no failure at startup shows a traceback.

Importing the commands takes a while and may be interrupted by Ctrl-C; standard streams may be closed from the start.
"""

from __future__ import annotations

import atexit
import gc
import os
import sys
import threading
import warnings
from signal import SIG_IGN, SIGINT, default_int_handler, getsignal, signal
from typing import NoReturn


def entry() -> NoReturn:
    """Run the command line, and exit the process with its status."""
    handles_sigint = getsignal(SIGINT) is default_int_handler  # SIGINT is ignored in background jobs of a script
    if handles_sigint:
        signal(SIGINT, _leave)
    _open_streams()
    gc.set_threshold(50_000, 20, 50)  # what is imported stays
    if "_ARGCOMPLETE" in os.environ:  # called by the shell's completion
        from scenelang.cli.main import build_parser
        from scenelang.shell_completion import complete

        complete(build_parser)
    if not sys.warnoptions:  # library warnings are for developers
        warnings.simplefilter("ignore")
    from scenelang.cli.main import main
    from scenelang.sandbox.supervision import INTERRUPTED

    if handles_sigint:
        signal(SIGINT, default_int_handler)
    try:
        status = main(supervised=True)
    except KeyboardInterrupt:  # outside the handlers of the command itself
        _leave()
    signal(SIGINT, SIG_IGN)  # the work is done: ignore late interruptions
    _end(status, waits=status != INTERRUPTED)


def _end(status: int, waits: bool) -> NoReturn:
    """Exit the process without freeing its memory object by object: that takes a second after deep recursion, and
    the interpreter's finalization can crash while threads of native libraries still run."""
    if waits:
        threading._shutdown()  # type: ignore[attr-defined]  # joins threads, as normal finalization does first
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
    """Open /dev/null in place of closed standard streams, so that no file is assigned their descriptors."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is None:
            try:
                os.fstat(number)
            except OSError:
                os.dup2(os.open(os.devnull, os.O_RDWR), number)
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115


if __name__ == "__main__":
    entry()
