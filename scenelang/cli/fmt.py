"""The command fmt: programs in the one style of the language, changed in white space only."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path
from typing import Any

from scenelang.backends.files import read_regular
from scenelang.cli.options import UsageError, add_output, program_files
from scenelang.cli.output import print_json, report, say, use_color
from scenelang.grammar.diagnostics import Diagnostic, SceneError, to_json
from scenelang.grammar.formatter import FormatFault, UnreadableError, format_range, format_text

_LARGEST_FILE = 16_000_000  # bytes
_COLORS = {"+": "\x1b[32m", "-": "\x1b[31m", "@": "\x1b[36m"}
_OFF = "\x1b[0m"


def add_fmt(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "fmt",
        help="format programs: line breaks and indentation",
        description="Format programs in one style. Only white space changes. Without options files are rewritten.",
    )
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="programs, folders of them, `-` for standard input to output"
    )
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 if a file would change")
    parser.add_argument("--diff", action="store_true", help="change nothing; show what would change")
    parser.add_argument("--lines", metavar="A:B", type=_lines, help="only the forms on lines A to B of one file")
    add_output(parser)
    parser.set_defaults(evaluates=False, run=fmt)


def _lines(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,9}):(\d{1,9})", text)
    if match is None or not 0 < int(match[1]) <= int(match[2]):
        raise argparse.ArgumentTypeError(f"`{text}` is no range of lines such as 3:10")
    return int(match[1]), int(match[2])


@dataclass(frozen=True, slots=True)
class _Done:
    """A file that was looked at. ``after`` is None where it could not be formatted."""

    name: str
    before: str = ""
    after: str | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    fault: str | None = None

    @property
    def changes(self) -> bool:
        return self.after is not None and self.after != self.before


def fmt(arguments: argparse.Namespace) -> int:
    files = program_files(arguments.files)
    if arguments.lines is not None and len(files) != 1:
        raise UsageError("value", f"--lines is for one file, got {len(files)}")
    done = [_one(arguments, name) for name in files]
    found = [diagnostic for each in done for diagnostic in each.diagnostics]
    if arguments.json:
        _print_json(done, found)
    elif found:
        report(arguments, found)
    for each in done:
        if each.fault is not None:
            print(f"internal error: {each.fault} (the file is as it was; please report it)", file=sys.stderr)
    failed = any(each.after is None for each in done)
    return 1 if failed or (arguments.check and any(each.changes for each in done)) else 0


def _one(arguments: argparse.Namespace, name: str) -> _Done:
    """Format one file; write it, or show what would change."""
    shown = "<stdin>" if name == "-" else name
    try:
        before = _text_of(name)
        done = _Done(shown, before, _formatted(arguments, name, shown, before))
        _deliver(arguments, name, done)
    except UnreadableError as error:
        return _Done(shown, diagnostics=error.diagnostics)
    except SceneError as error:
        return _Done(shown, diagnostics=(error.diagnostic,))
    except FormatFault as fault:
        return _Done(shown, fault=str(fault))
    return done


def _text_of(name: str) -> str:
    """The text of a program, with its byte order mark and its line ends; raises SceneError."""
    if name.endswith((".py", ".txt")):
        hint = "`scenelang transpile` makes a program of it"
        raise SceneError("unsupported", f"{name} is Python or a response, not a program", hint)
    if name.endswith(".json"):
        raise SceneError("unsupported", f"{name} is a scene as JSON, not a program")
    if name != "-" and os.path.isdir(name):
        raise SceneError("file", f"there are no programs (.scene) in {name}")
    try:
        if name == "-":
            data = sys.stdin.buffer.read(_LARGEST_FILE + 1)
        else:
            data = read_regular(name, _LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        raise SceneError("file", f"cannot read {name}: {getattr(error, 'strerror', None) or 'is no path'}") from None
    if len(data) > _LARGEST_FILE:
        raise SceneError("file", f"{name} is larger than {_LARGEST_FILE:,} bytes, which no program is")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        message = f"{name} is not UTF-8 text (line {line}, byte {error.start + 1})"
        raise SceneError("encoding", message, "save it as UTF-8") from None


def _formatted(arguments: argparse.Namespace, name: str, shown: str, text: str) -> str:
    from scenelang.formatting import indents_of

    indents = indents_of(text, Path.cwd() if name == "-" else Path(name).parent)
    if arguments.lines is not None:
        first, last = arguments.lines
        return format_range(text, first, last, indents, name=shown)
    return format_text(text, indents, name=shown)


# --- what comes of it ----------------------------------------------------------------------------------------------


def _deliver(arguments: argparse.Namespace, name: str, done: _Done) -> None:
    assert done.after is not None
    only_shown = arguments.check or arguments.diff
    if arguments.diff and done.changes and not arguments.json:
        sys.stdout.writelines(_difference(done, use_color(arguments, sys.stdout)))
    if name == "-" and not only_shown and not arguments.json:
        sys.stdout.flush()
        sys.stdout.buffer.write(done.after.encode("utf-8"))
    elif done.changes and not only_shown and name != "-":
        from scenelang.backends.files import rewrite

        rewrite(Path(name), done.after)
    if done.changes and name != "-" and not arguments.json and not arguments.quiet and not arguments.diff:
        say(f"{'would format' if arguments.check else 'formatted'} {name}")


def _difference(done: _Done, color: bool) -> Iterator[str]:
    assert done.after is not None
    before, after = _shown_lines(done.before), _shown_lines(done.after)
    for line in unified_diff(before, after, done.name, f"{done.name} (formatted)", lineterm=""):
        paint = _COLORS.get(line[:1]) if color else None
        yield f"{paint}{line}{_OFF}\n" if paint else f"{line}\n"


def _shown_lines(text: str) -> list[str]:
    lines = text.split("\n")
    return lines if lines[-1] else lines[:-1]


def _print_json(done: Iterable[_Done], found: Iterable[Diagnostic]) -> None:
    files = [{"file": each.name, "changed": each.changes, "formatted": each.after is not None} for each in done]
    print_json({"files": files, "diagnostics": [to_json(diagnostic) for diagnostic in found]})


COMMANDS = (add_fmt,)
