"""Options that commands share, and how they become a session."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.limits import Limits
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.session import Options, Session


class UsageError(SceneError):
    """An option that makes no sense, whatever the program: exit code 2."""


@contextmanager
def usage_errors() -> Iterator[None]:
    """Mistakes found in this block are the command line's, not the program's."""
    try:
        yield
    except SceneError as error:
        raise UsageError(error.name, error.message, error.hint) from None


_LIMIT_HELP = {
    "steps": "steps of evaluation",
    "depth": "nested calls",
    "entities": "distinct entities",
    "primitives": "primitives when the scene is expanded",
    "size": "items of a list or array, characters of a string",
    "memory": "bytes of memory (suffixes k, M, G)",
    "seconds": "wall time",
}
_SUFFIXES = {"k": 10**3, "m": 10**6, "g": 10**9}


def amount(text: str) -> float:
    """A positive number, with an optional suffix k, M or G."""
    scale = _SUFFIXES.get(text[-1:].lower(), 1)
    try:
        value = float(text[:-1] if scale > 1 else text) * scale
    except ValueError:
        raise argparse.ArgumentTypeError(f"`{text}` is no number") from None
    if not 0 < value < 1e18:
        raise argparse.ArgumentTypeError(f"`{text}` is no positive number")
    return value


def whole(text: str) -> int:
    """A number of things: 0, 1, 2, ..."""
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"`{text}` is no number of things")
    return int(text)


def add_file(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a program, `-` for standard input")


def program_files(names: Iterable[str]) -> list[str]:
    """The files that are meant, each once: of a folder those that end in .scene, hidden ones left out."""
    found: dict[str, str] = {}
    for name in names:
        programs = [name]
        if name != "-" and os.path.isdir(name):
            programs = [str(path) for path in _programs(Path(name))] or [name]
        for each in programs:
            found.setdefault(each if each == "-" else os.path.realpath(each), each)
    return list(found.values())


def _programs(folder: Path) -> list[Path]:
    found = [path for path in folder.rglob("*.scene") if path.is_file()]
    return sorted(p for p in found if not any(part.startswith(".") for part in p.relative_to(folder).parts))


def add_output(parser: argparse.ArgumentParser) -> None:
    """How much is said, and how."""
    group = parser.add_argument_group("output")
    group.add_argument("-q", "--quiet", action="store_true", help="no warnings, no log, no progress")
    group.add_argument("-v", "--verbose", action="store_true", help="also steps and times")
    group.add_argument("--no-color", action="store_true", help="no colours in diagnostics")
    group.add_argument("--json", action="store_true", help="machine-readable output")


def add_common(parser: argparse.ArgumentParser) -> None:
    """What every command that evaluates understands."""
    add_output(parser)
    group = parser.add_argument_group("evaluation")
    group.add_argument("--root", metavar="WORD", help="the word to evaluate (default: see docs/language.md)")
    group.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the random streams (default 0)")
    group.add_argument(
        "--define", action="append", default=[], metavar="NAME=VALUE", help="override a `param` of the program"
    )
    group.add_argument("--z", metavar="FILE", help="embeddings (default: FILE.z.safetensors beside the program)")
    group.add_argument("--allow-outside", action="store_true", help="let files import from outside the project folder")
    add_limits(parser)


def add_limits(parser: argparse.ArgumentParser) -> None:
    """What bounds an evaluation."""
    limits = parser.add_argument_group("limits")
    for field in fields(Limits):
        if field.name in _LIMIT_HELP:
            text = f"{_LIMIT_HELP[field.name]} (default {field.default:,})"
            limits.add_argument(f"--max-{field.name}", type=amount, metavar="N", help=text)


def limits_of(arguments: argparse.Namespace) -> Limits:
    chosen: dict[str, Any] = {}
    for field in fields(Limits):
        value = getattr(arguments, f"max_{field.name}", None)
        if value is not None:
            chosen[field.name] = value if field.name == "seconds" else int(value)
    return Limits(**chosen)


def z_path(arguments: argparse.Namespace) -> Path | None:
    """The file of embeddings to use: the one named, else the one beside the program if it exists."""
    from scenelang.zfile import beside

    if arguments.z is not None:
        return Path(arguments.z)
    if arguments.file == "-":
        return None
    path = beside(arguments.file)
    return path if path.exists() else None


def z_entries(arguments: argparse.Namespace) -> dict[str, ZEntry]:
    if arguments.z is None and (arguments.file == "-" or not _has_z(arguments.file)):
        return {}
    from scenelang.zfile import read_entries

    path = z_path(arguments)
    return read_entries(path) if path is not None else {}


def _has_z(program: str) -> bool:
    """Whether Z lies beside a program; asked before anything is imported for it."""
    path = Path(program)
    return bool(path.name) and path.with_suffix(".z.safetensors").exists()


def session_of(arguments: argparse.Namespace, strict: bool = False) -> Session:
    """The session that a command works with; raises SceneError for a malformed option."""
    defines = {}
    for item in arguments.define:
        name, sign, text = item.partition("=")
        if not sign or not name:
            raise UsageError("param", f"--define wants NAME=VALUE, got `{item}`")
        defines[name.strip()] = text
    options = Options(
        root=arguments.root,
        seed=arguments.seed % (1 << 32),
        defines=defines,
        limits=limits_of(arguments),
        allow_outside=arguments.allow_outside,
        strict=strict,
        z_entries=z_entries(arguments),
    )
    return Session(options)
