"""Options and output that several commands share: sessions from options; diagnostics, JSON, logs and progress."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Any, TextIO, TypeVar

from scenelang.backends.files import check_folder as check_folder
from scenelang.console.reports import once, print_diagnostics, print_json, progress_line, say
from scenelang.files import existing_beside
from scenelang.grammar import settings
from scenelang.grammar.diagnostics import Diagnostic, capped, printable
from scenelang.grammar.diagnostics import UsageError as UsageError
from scenelang.grammar.diagnostics import usage_errors as usage_errors
from scenelang.grammar.settings import Setting, settings_in
from scenelang.interpreter.loading import is_present
from scenelang.interpreter.values.limits import Limits

if TYPE_CHECKING:
    from pathlib import Path

    from scenelang.backends import base
    from scenelang.backends.neural.weights import Models
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.runtime.runtime import ZEntry
    from scenelang.interpreter.scene.entity import Entity
    from scenelang.interpreter.scene.entity import Scene as EntityScene
    from scenelang.session.loaded import LoadedScene
    from scenelang.session.session import Evaluated, Session


Fields = TypeVar("Fields")


class ReportedError(Exception):
    """An error that has already been reported; the command exits with status 1."""


def reader(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """Wrap ``read`` as an argparse type whose ValueError becomes argparse's error message."""
    if read in (int, float):
        return read

    @wraps(read)
    def convert(text: str) -> Any:
        """Read a value, with argparse's error for an invalid one."""
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return convert


whole, picture_size = reader(settings.whole), reader(settings.picture_size)


def add_settings(group: Any, known: Mapping[str, Setting], prefix: str = "", **helps: str) -> None:
    """Add an option for each setting; an option that is not given has the value None.

    Parameters
    ----------
    group
        Parser or argument group to add the options to.
    known
        Settings by field name.
    prefix
        Prefix of the namespace attributes, which keeps the options of different backends apart.
    helps
        Help texts that replace a setting's own, by field name.
    """
    for name, field in known.items():
        more: dict[str, Any] = {"help": helps.get(name, field.help).replace("%", "%%"), "dest": prefix + _long(field)}
        if type(field.default) is bool:
            more |= {"action": "store_true"}
        else:
            more |= {"metavar": field.metavar, "type": field.read and reader(field.read), "choices": field.choices}
            more |= {"action": "append"} if field.repeated else {}
            more |= {"nargs": "?", "const": field.alone} if field.alone is not None else {}
        group.add_argument(*field.flags, **more)


def given_settings(arguments: argparse.Namespace, known: Mapping[str, Setting], prefix: str = "") -> dict[str, Any]:
    """Return the values of the settings that were given as options, by field name."""
    values = {}
    for name, field in known.items():
        value = getattr(arguments, prefix + _long(field), None)
        if value is not None and value is not False:
            values[name] = not field.default if value is True else tuple(value) if field.repeated else value
    return values


def _long(field: Setting) -> str:
    """Return the namespace attribute that argparse derives from a setting's long option."""
    return next(flag for flag in field.flags if flag.startswith("--"))[2:].replace("-", "_")


def add_fields(group: Any, kind: type, names: Iterable[str] | None = None, **helps: str) -> None:
    """Add an option for each field of a settings dataclass, or only for those in ``names``."""
    known = settings_in(kind)
    add_settings(group, {name: known[name] for name in (known if names is None else names)}, **helps)


def given(arguments: argparse.Namespace, kind: type) -> dict[str, Any]:
    """Return the dataclass fields that were given as options, by name."""
    return given_settings(arguments, settings_in(kind))


def fields_of(arguments: argparse.Namespace, kind: type[Fields], **more: Any) -> Fields:
    """Construct a settings dataclass from the options that were given and the values in ``more``."""
    return kind(**given(arguments, kind) | more)


def add_camera(group: Any, size_help: str, several: bool = False) -> None:
    """Add the options for image size and camera; ``several`` allows the camera to be repeated."""
    group.add_argument("--size", type=picture_size, metavar="WxH", help=size_help)
    group.add_argument(
        "--camera",
        metavar="VIEW",
        action="append" if several else "store",
        help="preset (three-quarter, hero, catalogue, isometric, plan, elevation, front, right, back, left, top, "
        "bottom, turntable, follow), the name of a camera of the program (default: its first), parameters (azimuth=40,"
        "elevation=20,distance=5,fov=35,target=0:1:0,aperture=.1,focus=4), position (eye=1:2:3,target=0:1:0), or a "
        "JSON file; omitted parameters are chosen to frame the scene",
    )


def add_backend_options(parser: argparse.ArgumentParser, work: base.Work) -> None:
    """Add the options of the backends that do ``work``; read them with ``backend_settings_of``."""
    from scenelang.backends import base

    add_settings(parser.add_argument_group("options of backends"), base.settings_for(work), "backend_")
    parser.set_defaults(work=work)


def backend_settings_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the backend options that were given, by name."""
    from scenelang.backends import base

    return given_settings(arguments, base.settings_for(arguments.work), "backend_")


@contextmanager
def naming_other_commands(command: str, arguments: argparse.Namespace) -> Iterator[None]:
    """Add the command that writes such files to the error about an output that this command does not write."""
    try:
        yield
    except UsageError as error:
        from scenelang.cli.wrong_usage import other_command

        output = getattr(arguments, "output", None)
        other = other_command(command, arguments.file, output) if error.name == "backend" and output else None
        if other is None:
            raise
        raise UsageError(error.name, error.message, other) from None


def add_file(parser: argparse.ArgumentParser) -> None:
    """Add the program file."""
    parser.add_argument("file", metavar="FILE", help="program file, or `-` for standard input")


def add_output(parser: argparse.ArgumentParser) -> None:
    """Add the options that control verbosity and output format."""
    group = parser.add_argument_group("output")
    group.add_argument("-q", "--quiet", action="store_true", help="suppress warnings, logs and progress")
    group.add_argument("-v", "--verbose", action="store_true", help="also report steps and times")
    group.add_argument("--no-color", action="store_true", help="disable colored diagnostics")
    group.add_argument("--json", action="store_true", help="machine-readable output")


def add_common(parser: argparse.ArgumentParser) -> None:
    """Add the options shared by all commands that evaluate programs."""
    add_output(parser)
    group = parser.add_argument_group("evaluation")
    group.add_argument("--root", metavar="WORD", help="word to evaluate (default: the one no other word calls)")
    add_seed(group)
    group.add_argument(
        "--define", action="append", default=[], metavar="NAME=VALUE", help="override a `param` of the program"
    )
    group.add_argument("--z", metavar="FILE", help="embeddings file (default: FILE.z.safetensors beside the program)")
    group.add_argument("--allow-outside", action="store_true", help="allow imports from outside the project folder")
    add_limits(parser)


def add_seed(group: Any) -> None:
    """Add the random seed."""
    group.add_argument("--seed", type=reader(settings.seed), default=0, metavar="N", help="random seed (default 0)")


def add_physics(parser: Any, seconds: str) -> None:
    """Add the options of all commands that simulate."""
    parser.add_argument(
        "--seconds", type=reader(settings.amount), metavar="S", help=f"simulated time (default {seconds})"
    )
    parser.add_argument(
        "--metres-per-unit", type=reader(settings.metres), metavar="M",
        help="metres per scene unit (default: such that the diagonal of the scene is 2 m)",
    )  # fmt: skip


def add_limits(parser: argparse.ArgumentParser) -> None:
    """Add the options for the resource limits of an evaluation."""
    add_fields(parser.add_argument_group("limits"), Limits)


def limits_of(arguments: argparse.Namespace) -> Limits:
    """Return the resource limits that the options give; raises UsageError."""
    with usage_errors():
        return fields_of(arguments, Limits)


def add_models(parser: argparse.ArgumentParser) -> None:
    """Add the options for model weights and the compute device, where this installation has neural models."""
    if not is_present("scenelang.backends.neural"):
        return
    from scenelang.backends.neural.weights import Models

    add_fields(parser.add_argument_group("neural models"), Models)


def models_of(arguments: argparse.Namespace) -> Models:
    """Return the model weights and the device that the options select."""
    from scenelang.backends.neural.weights import Models

    return fields_of(arguments, Models)


def z_path(arguments: argparse.Namespace) -> Path | None:
    """Return the embeddings file to use: the given one, else the one beside the program if it exists."""
    if arguments.z is not None:
        from pathlib import Path

        return Path(arguments.z)
    if arguments.file == "-":
        return None
    return existing_beside(arguments.file)


def z_entries(arguments: argparse.Namespace) -> dict[str, ZEntry]:
    """Return the entries of the embeddings file, if there is one; raises SceneError."""
    path = z_path(arguments)
    if path is None:
        return {}
    from scenelang.files.zfile import read_entries

    return read_entries(path)


def session_of(arguments: argparse.Namespace) -> Session:
    """Create the session of a command.

    Raises
    ------
    SceneError
        If an option is malformed.
    """
    from scenelang.session.session import Options, Session, definition

    options = Options(
        root=arguments.root,
        seed=arguments.seed,
        defines=dict(map(definition, arguments.define)),
        limits=limits_of(arguments),
        allow_outside=arguments.allow_outside,
        strict=getattr(arguments, "strict", False),
        z_entries=z_entries(arguments),
    )
    return Session(options)


def opened(arguments: argparse.Namespace, session: Session | None = None) -> tuple[Evaluated, Source, Session]:
    """Evaluate the command's file, and print the log and diagnostics of the run."""
    session = session or session_of(arguments)
    source = session.source(arguments.file)
    result = explained_run(session, source)
    report_run(arguments, result)
    return result, source, session


def explained_run(session: Session, source: Source) -> Evaluated:
    """Evaluate a program; without a scene, its errors are told as ``check`` tells them."""
    result = session.evaluate(source)
    if result.scene is not None:
        return result
    from scenelang.grammar.datum import replace
    from scenelang.session.checking import explained

    return replace(result, diagnostics=tuple(explained(session, source, result.diagnostics)))


def evaluated(arguments: argparse.Namespace) -> EntityScene:
    """Return the entity graph of the command's file; raises ReportedError if the program has errors."""
    scene = opened(arguments)[0].scene
    if scene is None:
        raise ReportedError
    return scene


def scene_of(arguments: argparse.Namespace, fresh: bool = False) -> LoadedScene:
    """Return the scene of the command's file; raises ReportedError if the program has errors.

    With ``fresh``, the embeddings file does not exist yet and is not read.
    """
    from scenelang.session.loaded import LoadedScene, scene_from

    session_arguments = argparse.Namespace(**{**vars(arguments), "z": None, "file": "-"}) if fresh else arguments
    result, source, session = opened(arguments, session_of(session_arguments))
    if result.scene is None or any(d.is_error for d in result.diagnostics):
        raise ReportedError
    compute_solids(arguments, result.scene.frames)
    return scene_from(LoadedScene, result, source.name, session.options)


def compute_solids(arguments: argparse.Namespace, roots: Sequence[Entity]) -> None:
    """Compute the solids of frames within the limits of a command."""
    from scenelang.interpreter.scene.modelling.solid import compute_all
    from scenelang.sandbox.supervision import noting

    with bounded(arguments):
        compute_all(roots, noting())


def bounded(arguments: argparse.Namespace) -> AbstractContextManager[object]:
    """Apply the time and memory limits of a command to the work inside the context."""
    from scenelang.sandbox.supervision import limited

    return limited(limits_of(arguments))


def session_limit(arguments: argparse.Namespace) -> int:
    """Return the maximum number of primitives to expand."""
    return limits_of(arguments).primitives


def use_color(arguments: argparse.Namespace, stream: TextIO) -> bool:
    """Return whether diagnostics on a stream are colored."""
    return stream.isatty() and not getattr(arguments, "no_color", False) and "NO_COLOR" not in os.environ


def report(arguments: argparse.Namespace, diagnostics: Iterable[Diagnostic], stream: TextIO | None = None) -> None:
    """Print diagnostics: errors always, warnings unless quiet; as one JSON list with ``--json``."""
    quiet = getattr(arguments, "quiet", False)
    shown = capped([d for d in diagnostics if d.is_error or not quiet])
    if any(d.name == "interrupted" for d in shown):
        arguments.was_interrupted = True
    stream = stream or sys.stderr
    hints = stream.isatty() and not quiet  # only for interactive use
    print_diagnostics(shown, stream, getattr(arguments, "json", False), use_color(arguments, stream), hints)


def report_run(arguments: argparse.Namespace, result: Evaluated) -> None:
    """Print the log and the diagnostics of a run to standard error; standard output is for data."""
    if not arguments.quiet:
        for line in result.log:
            print(printable(line) if sys.stderr.isatty() else line, file=sys.stderr)
    if result.diagnostics:
        report(arguments, result.diagnostics)
    if arguments.verbose:
        print(f"{result.steps:,} steps", file=sys.stderr)


def print_result(arguments: argparse.Namespace, data: Any, text: object) -> int:
    """Print a command's result as JSON or text, and return exit code 0."""
    if arguments.json:
        print_json(data)
    else:
        say(str(text))
    return 0


def warnings(arguments: argparse.Namespace) -> Callable[[Diagnostic], None]:
    """Return a callback that reports warnings of backends, each message only once."""
    return once(lambda diagnostic: report(arguments, [diagnostic]))


def progress(arguments: argparse.Namespace, label: str) -> Callable[[float], None] | None:
    """Return a callback for a progress line on standard error, or None without a terminal or when quiet."""
    if arguments.quiet or not sys.stderr.isatty():
        return None
    return progress_line(sys.stderr, label)


def done(arguments: argparse.Namespace, *written: Path) -> None:
    """Report the files that were written."""
    if not arguments.quiet:
        for output in written:
            say(f"wrote {output}")
