"""Options that commands share, and how they become a session."""

from __future__ import annotations

import argparse
import re
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.output import report_run
from scenelang.grammar.diagnostics import UsageError as UsageError
from scenelang.grammar.diagnostics import usage_errors as usage_errors
from scenelang.interpreter.runtime.limits import Limits
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.session import Evaluated, Options, Session

if TYPE_CHECKING:
    from scenelang.scene import Scene


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


def picture_size(text: str) -> tuple[int, int]:
    """``WIDTHxHEIGHT`` in pixels."""
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if match is None or not (1 <= int(match[1]) <= 16384 and 1 <= int(match[2]) <= 16384):
        raise argparse.ArgumentTypeError(f"`{text}` is no size; write WIDTHxHEIGHT, such as 800x600")
    return int(match[1]), int(match[2])


def add_camera(group: Any, size_help: str, several: bool = False) -> None:
    """How large pictures are, and where they are taken from: by one camera or ``several``."""
    group.add_argument("--size", type=picture_size, metavar="WxH", help=size_help)
    group.add_argument(
        "--camera",
        metavar="VIEW",
        action="append" if several else "store",
        help="turntable, top, isometric, follow; azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0,aperture=.1,"
        "focus=4; or a camera's JSON file; what is left out frames the scene",
    )


def add_file(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a program, `-` for standard input")


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


def evaluated(arguments: argparse.Namespace) -> Evaluated:
    """Evaluate the command's file and print what the run said."""
    return evaluated_text(arguments)[0]


def evaluated_text(arguments: argparse.Namespace) -> tuple[Evaluated, str]:
    """As ``evaluated``, with the file's text."""
    session = session_of(arguments)
    source = session.source(arguments.file)
    result = session.evaluate(source)
    report_run(arguments, result)
    return result, source.text


def scene_of(arguments: argparse.Namespace, fresh: bool = False) -> Scene | None:
    """The scene of the command's file; None for a wrong program, which is then told. ``fresh``: the file of embeddings
    is only to be made."""
    from scenelang.scene import scene_from

    session = session_of(argparse.Namespace(**{**vars(arguments), "z": None, "file": "-"}) if fresh else arguments)
    source = session.source(arguments.file)
    result = session.evaluate(source)
    report_run(arguments, result)
    return None if result.scene is None else scene_from(result, source.name, session.options)


def session_limit(arguments: argparse.Namespace) -> int:
    """How many primitives may be expanded."""
    return limits_of(arguments).primitives
