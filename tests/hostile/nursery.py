"""A process that has the command line's modules loaded, and runs each command that a line of standard input asks for in
a copy of itself: what start-up costs is paid once. The copy goes on exactly as the command does."""

from __future__ import annotations

import gc
import json
import os
import sys
import time

from scenelang.cli.main import build_parser, main
from scenelang.console.shell_completion import complete


def run(request: dict[str, object]) -> int:
    """The command, in the copy."""
    os.chdir(str(request["folder"]))
    for number, name in ((1, "out"), (2, "err")):
        handle = os.open(str(request[name]), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(handle, number)
        os.close(handle)
    given = os.open(str(request.get("given", os.devnull)), os.O_RDONLY)
    os.dup2(given, 0)
    sys.stdin = open(0, encoding="utf-8", errors=sys.stdin.errors, closefd=False)  # noqa: SIM115
    if "environment" in request:
        os.environ.clear()
        os.environ.update(request["environment"])  # type: ignore[call-overload]
    if "_ARGCOMPLETE" in os.environ:  # as the entry point does
        complete(build_parser)
    try:
        return main(list(request["words"]), supervised=True)  # type: ignore[call-overload]
    except SystemExit as leaving:
        return leaving.code if isinstance(leaving.code, int) else 1


def serve() -> None:
    from hostile import warm

    warm.load()
    gc.freeze()
    for line in sys.stdin:
        request = json.loads(line)
        start = time.monotonic()
        pid = os.fork()
        if pid == 0:
            code = 1
            try:
                code = run(request)
                sys.stdout.flush()
                sys.stderr.flush()
            finally:
                os._exit(code)
        print(pid, flush=True)
        _, status = os.waitpid(pid, 0)
        print(os.waitstatus_to_exitcode(status), time.monotonic() - start, flush=True)


if __name__ == "__main__":
    serve()
