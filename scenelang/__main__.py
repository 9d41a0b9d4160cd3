"""``python -m scenelang`` and the console scripts: run the command line; no failure at startup shows a traceback.

Importing the commands takes a while and may be interrupted by Ctrl-C; standard streams may be closed from the start.
"""

from __future__ import annotations

import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn


def entry() -> NoReturn:
    """Run the command line, and exit the process with its status."""
    # importing `signal`, which is this module in Python, takes a while
    from _signal import SIGINT, default_int_handler, getsignal, signal  # type: ignore[import-not-found]

    handles_sigint = getsignal(SIGINT) is default_int_handler  # SIGINT is ignored in background jobs of a script
    if handles_sigint:
        signal(SIGINT, _leave)
    _run(handles_sigint=handles_sigint)


def _run(*, handles_sigint: bool) -> NoReturn:
    """Complete a command line for the shell, print help, or run a command; importing as little as each needs."""
    import gc
    from signal import SIG_IGN, SIGINT, default_int_handler, signal

    _open_streams()
    _set_encodings()
    gc.disable()  # what is imported stays: collections on the way took a fifth of the start-up
    if "_ARGCOMPLETE" in os.environ:  # called by the shell's completion
        from scenelang.cli.main import build_parser
        from scenelang.console.shell_completion import complete

        complete(build_parser)
    if not sys.warnoptions:  # library warnings are for developers
        if "warnings" in sys.modules:
            sys.modules["warnings"].simplefilter("ignore")
        else:
            sys.warnoptions.append("ignore")  # read when the module is imported
    from scenelang.cli.command_table import prints_help

    if prints_help(sys.argv[1:]):
        os._exit(0)
    from scenelang.cli.main import main
    from scenelang.sandbox.supervision import INTERRUPTED, after_imports

    if handles_sigint:
        signal(SIGINT, after_imports(default_int_handler))
    try:
        status = main(supervised=True)
    except KeyboardInterrupt:  # outside the handlers of the command itself
        _leave()
    signal(SIGINT, SIG_IGN)  # the work is done: ignore late interruptions
    _end(status, waits=status != INTERRUPTED)


def _end(status: int, *, waits: bool) -> NoReturn:
    """Exit the process without freeing its memory object by object.

    That takes a second after deep recursion, and the interpreter's finalization can crash while threads of native
    libraries still run.
    """
    import atexit
    import threading

    if waits:
        threading._shutdown()  # type: ignore[attr-defined]  # joins threads, as normal finalization does first
    atexit._run_exitfuncs()
    from scenelang.sandbox.supervision import CLOSED

    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError as error:
        status = status or (CLOSED if isinstance(error, BrokenPipeError) else 1)
    os._exit(status)


def _leave(*_: object) -> NoReturn:
    """Exit at Ctrl-C before the command has its own handler."""
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


def _set_encodings() -> None:
    """Write UTF-8 to files and pipes, as programs are, whatever the locale; escape what a terminal cannot show.

    An encoding in PYTHONIOENCODING is kept. The escapes are those of strings in the language, ``\\x6728;``.
    """
    from codecs import register_error
    from io import TextIOWrapper

    register_error("scenelang", _escaped)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            keeps = stream.isatty() or bool(os.environ.get("PYTHONIOENCODING"))
            stream.reconfigure(encoding=stream.encoding if keeps else "utf-8", errors="scenelang")


_PLAIN = {"├": "|", "└": "`", "│": "|", "─": "-", "…": "...", "→": "->", "×": "x", "°": " degrees"}


def _escaped(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    letters = error.object[error.start : error.end]
    return "".join(_PLAIN.get(letter) or f"\\x{ord(letter):x};" for letter in letters), error.end


if __name__ == "__main__":
    entry()
