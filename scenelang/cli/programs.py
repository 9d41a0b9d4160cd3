"""Commands for programs: check, run, tree, flatten, count, bounds, expand, fmt, diff, transpile, simplify, explain,
grammar, import, doctor; interactive ones and servers: repl, lsp, mcp, completion."""

from __future__ import annotations

import argparse
import os
import re
import sys
import time
from collections.abc import Sequence
from itertools import chain, islice
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import (
    UsageError,
    add_limits,
    add_output,
    add_physics,
    bounded,
    check_folder,
    compute_solids,
    done,
    evaluated,
    explained_run,
    limits_of,
    print_result,
    reader,
    report,
    report_run,
    scene_of,
    session_limit,
    session_of,
    usage_errors,
    use_color,
    whole,
)
from scenelang.console.reports import deliver, painted, print_json, say, table
from scenelang.grammar.diagnostics import (
    Diagnostic,
    SceneError,
    by_code,
    explained,
    explanation_data,
    require_diagnostic,
    to_json,
)
from scenelang.grammar.settings import line_range, part_of_one
from scenelang.interpreter.loading import is_present
from scenelang.interpreter.scene.entity import count_words
from scenelang.session.checking import Examination, declaration_errors
from scenelang.session.declarations import declarations_of

if TYPE_CHECKING:
    from scenelang.backends.surfaces.marks import Marks
    from scenelang.interpreter.inspection.difference import ComparedFrame
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Entity
    from scenelang.interpreter.scene.entity import Scene as EntityScene
    from scenelang.repl.loop import ModelRequest
    from scenelang.session.formatting import FormattedFile
    from scenelang.session.session import Session

_FIRST_LINES = 10_000  # computed within the limits; further ones as fast as they are read


# --- check, run, expand --------------------------------------------------------------------------------------------


def add_check(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``check``."""
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="programs, folders of programs, or `-` for standard input"
    )
    parser.add_argument("--strict", action="store_true", help="require the paper's grammar")
    parser.add_argument("--run", action="store_true", dest="evaluate", help="also evaluate the programs")
    parser.add_argument(
        "--that",
        metavar="DECLARATION",
        action="append",
        help='also evaluate, and test a declaration, such as \'(on "cup" "table")\', or a file of `assert-that` '
        "forms, besides those of the program (repeatable)",
    )
    parser.add_argument(
        "--geometry", action="store_true", help="also evaluate, and run the geometry lint (overlaps, gaps, faces)"
    )
    parser.add_argument(
        "--physics", action="store_true", help="also evaluate, and report what moves, tips or falls under gravity"
    )
    add_physics(parser.add_argument_group("physics"), "1.5")
    parser.add_argument(
        "--picture",
        metavar="FILE",
        help="picture (PNG) of an operand that is no solid, of a declaration that fails, or of the gravest finding",
    )
    parser.add_argument("--fix", action="store_true", help="apply safe fixes, which keep the meaning of programs")


def run_check(arguments: argparse.Namespace) -> int:
    """Report the diagnostics of programs; exit code 1 if there are errors."""
    from scenelang.backends.files import program_files

    diagnostics: list[Diagnostic] = []
    session: Session | None = None
    files = program_files(arguments.files)
    if arguments.fix and not all(path.endswith(".scene") for path in files):
        raise UsageError("value", "--fix supports only .scene files")
    if not arguments.physics and not arguments.seconds is arguments.metres_per_unit is None:
        raise UsageError("value", "--seconds and --metres-per-unit require --physics")
    if arguments.picture:
        if not (arguments.evaluate or arguments.geometry or arguments.physics or arguments.that):
            raise UsageError("value", "--picture requires --run, --that, --geometry or --physics")
        from pathlib import Path

        from scenelang.backends.pictures.exhibit import check_picture

        check_picture(Path(arguments.picture))
    for path in files:
        arguments.file = path
        session = session or session_of(arguments)
        try:
            diagnostics += _diagnostics_in(arguments, session, path)
        except SceneError as error:
            diagnostics.append(error.diagnostic)
    report(arguments, diagnostics, sys.stdout if arguments.json else None)
    if any(d.is_error for d in diagnostics):
        return 1
    if not (arguments.evaluate or arguments.that or arguments.quiet or arguments.json):
        _say_untested(session, files)
    return 0


def _say_untested(session: Session | None, files: Sequence[str]) -> None:
    """Say that the assertions of programs, which need a scene, were not tested."""
    for path in files if session is not None else ():
        if path == "-" or not path.endswith(".scene"):
            continue
        text = session.source(path).text if session is not None else ""
        count = len(_ASSERTION.findall(text)) if "(assert-that" in text else 0
        if count:
            number = "1 assertion was" if count == 1 else f"{count} assertions were"
            print(f"{path}: {number} not tested; `check --run` and `run` do", file=sys.stderr)


_ASSERTION = re.compile(r"^[^;\n]*\(assert-that\b", re.M)


def _diagnostics_in(arguments: argparse.Namespace, session: Session, path: str) -> Sequence[Diagnostic]:
    """Return the diagnostics of one file, after its fixes if requested."""
    if arguments.fix:
        source, number = session.fix_file(path)
        if number and not arguments.quiet:
            print(f"{path}: {number} {'fix' if number == 1 else 'fixes'} applied", file=sys.stderr)
    else:
        source = session.source(path)
    stated = [declaration for text in arguments.that or () for declaration in declarations_of(session, text)]
    simulated = (arguments.seconds, arguments.metres_per_unit) if arguments.physics else None
    examination = Examination(session, arguments.evaluate, arguments.geometry, simulated, stated, arguments.json)
    with bounded(arguments):
        examined = examination.of(source, lambda scene: compute_solids(arguments, scene.frames))
    if arguments.picture and examined.subject is not None:
        _save_picture(arguments, examined.subject)
    elif arguments.picture and examined.scene is not None:
        _picture_finding(arguments, examined.scene, stated)
    return examined.diagnostics


def _picture_finding(arguments: argparse.Namespace, scene: EntityScene, stated: Sequence[Declaration]) -> None:
    """Write an image of the gravest finding, if there is one."""
    from pathlib import Path

    from scenelang.backends.pictures.exhibit import save_marked

    with bounded(arguments):
        marked = _marked_finding(arguments, scene, stated)
        if marked is not None:
            save_marked(*marked, Path(arguments.picture))
            _say_shown(arguments, "finding")


def _marked_finding(
    arguments: argparse.Namespace, scene: EntityScene, stated: Sequence[Declaration]
) -> tuple[Entity, Marks] | None:
    """Return the first declaration that fails, else the gravest finding of the checks that were asked for."""
    from scenelang.backends.geometry.lint import marked_finding
    from scenelang.backends.geometry.relations import marked_violation

    marked = marked_violation(scene, stated)
    if marked is None and arguments.geometry:
        marked = marked_finding(scene)
    if marked is None and arguments.physics:
        from scenelang.backends.physics.verdicts import SECONDS, marked_motion

        marked = marked_motion(scene, arguments.seconds or SECONDS, arguments.metres_per_unit)
    return marked


def _save_picture(arguments: argparse.Namespace, subject: Any) -> None:
    """Write an image of the subject of an error."""
    from pathlib import Path

    from scenelang.backends.pictures.exhibit import save_exhibit

    with bounded(arguments):
        save_exhibit(subject, Path(arguments.picture))
        _say_shown(arguments, "operand")


def _say_shown(arguments: argparse.Namespace, what: str) -> None:
    """Report that the image was written; further findings have none."""
    if not arguments.quiet:
        print(f"the {what} is shown in {arguments.picture}", file=sys.stderr)
    arguments.picture = None  # only the first is shown


def run_run(arguments: argparse.Namespace) -> int:
    """Evaluate a program and print a summary of its scene."""
    from scenelang.interpreter.inspection.outline import summary, summary_rows

    session = session_of(arguments)
    source = session.source(arguments.file)
    started = time.perf_counter()
    with bounded(arguments):
        result = explained_run(session, source)
        seconds = time.perf_counter() - started
        facts = summary(result.scene) if result.scene is not None else None
        failed = declaration_errors(result.scene) if result.scene is not None else []
    report_run(arguments, result)
    if facts is None:
        return 1
    report(arguments, failed)
    text = table([*summary_rows(facts), ("time", f"{seconds:.3f} s")], (False, False))
    return print_result(arguments, facts | {"seconds": seconds}, text) or int(bool(failed))


def run_expand(arguments: argparse.Namespace) -> int:
    """Print a program after macro expansion."""
    session = session_of(arguments)
    checked = session.check(session.source(arguments.file))
    if checked.ok and checked.program is None:
        raise SceneError("unsupported", f"nothing to expand: {arguments.file} is a scene, not a program")
    if not checked.ok or checked.program is None:
        report(arguments, checked.diagnostics)
        return 1
    print(session.expansion(checked.program), end="")
    return 0


# --- tree, flatten, count, bounds ------------------------------------------------------------------------------------


def add_tree(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``tree``."""
    parser.add_argument("--depth", type=whole, metavar="N", help="maximum depth below the root")
    parser.add_argument("--poses", action="store_true", help="also print the pose of every entity")
    parser.add_argument("--all", action="store_true", help="list every instance instead of counts of repeated entities")


def run_tree(arguments: argparse.Namespace) -> int:
    """Print the entity hierarchy; long ones are printed while they are computed."""
    from scenelang.interpreter.inspection.outline import outline, outline_data

    with bounded(arguments):
        scene = evaluated(arguments)
        if arguments.json:
            data = outline_data(scene, arguments.depth)
        else:
            lines = outline(scene, arguments.depth, arguments.poses, arguments.all)
            first = list(islice(lines, _FIRST_LINES))
    if arguments.json:
        print_json(data)
        return 0
    for line in chain(first, lines):  # outside the time limit, since the reader may be a pager
        say(line)
    return 0


def run_flatten(arguments: argparse.Namespace) -> int:
    """List the primitives with world matrices, or their number."""
    from scenelang.interpreter.inspection.numbering import primitive_handles
    from scenelang.interpreter.inspection.outline import flat_json
    from scenelang.interpreter.scene.flatten import flatten as flatten_scene

    with bounded(arguments):
        scene = evaluated(arguments)
        flat = flatten_scene(scene, session_limit(arguments))
        handles = primitive_handles(scene, flat) if arguments.json else []
    if arguments.json:
        sys.stdout.writelines(chain(flat_json(flat, handles), "\n"))
        return 0
    for number, frame in enumerate(flat.frames):
        label = f"frame {number}: " if flat.animated else ""
        noun = "primitive" if len(frame) == 1 else "primitives"
        say(f"{label}{len(frame):,} {noun}, {len(frame.primitives):,} distinct")
    return 0


def add_count(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``count``."""
    parser.add_argument("--frame", type=whole, default=0, metavar="N", help="frame of a 4D scene (default 0)")


def run_count(arguments: argparse.Namespace) -> int:
    """Print the number of instances of every word."""
    with bounded(arguments):
        scene = evaluated(arguments)
        frames = scene.frames
        if arguments.frame >= len(frames):
            raise SceneError(
                "value", f"frame {arguments.frame} is out of range; the scene has {len(frames)}, from 0 on"
            )
        counts = count_words(frames[arguments.frame])
    head = f"frame {arguments.frame} of {len(frames)}:\n" if scene.animated else ""
    rows = [(f"{n:,}", word) for word, n in counts.items()]
    return print_result(arguments, counts, head + table(rows, (True, False)))


def add_bounds(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bounds``."""
    parser.add_argument("--word", help="word or path, such as `chair/leg[2]`, to measure in world coordinates")


def run_bounds(arguments: argparse.Namespace) -> int:
    """Print the bounding box of a scene or of a word."""
    from scenelang.interpreter.scene.bounds import box_data

    with bounded(arguments):
        scene = scene_of(arguments)
        box = scene.bounds if arguments.word is None else scene.bounds_of(arguments.word)
    if box is None:
        what = f'"{arguments.word}"' if arguments.word else "the scene"
        raise SceneError("empty-scene", f"{what} has no geometry and therefore no bounding box")
    low, high = box.tolist()
    facts = box_data((*low, *high))
    rows = [(name, *(f"{x:.6g}" for x in values)) for name, values in facts.items()]
    return print_result(arguments, facts, table(rows, (False, True, True, True)))


def add_measure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``measure``."""
    parser.add_argument("--word", help="word or path, such as `chair/leg[2]`, to measure in world coordinates")
    parser.add_argument("--frame", type=whole, default=0, metavar="N", help="frame to measure (default 0)")


def run_measure(arguments: argparse.Namespace) -> int:
    """Print volume, surface area, center of mass and inertia."""
    with bounded(arguments):
        facts = scene_of(arguments).measure(arguments.word, arguments.frame, session_limit(arguments)).data()
    shown = {name: values if isinstance(values, list) else [values] for name, values in facts.items()}
    rows = [(name, *(f"{x:.6g}" for x in row), *[""] * (3 - len(row))) for name, row in list(shown.items())[:4]]
    return print_result(arguments, facts, table(rows, (False, True, True, True)))


# --- fmt -------------------------------------------------------------------------------------------------------------


def add_fmt(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``fmt``."""
    parser.description = "Format programs in a uniform style, in place. Only white space changes."
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="programs, folders of programs, or `-` to filter standard input"
    )
    parser.add_argument("--check", action="store_true", help="do not write files; exit 1 if a file would change")
    parser.add_argument("--diff", action="store_true", help="do not write files; print the changes as a diff")
    span = "range of lines to format; accepts only one file"
    parser.add_argument("--lines", metavar="A:B", type=reader(line_range), help=span)


def run_fmt(arguments: argparse.Namespace) -> int:
    """Format programs; exit code 1 if one cannot be parsed, or would change with ``--check``."""
    from scenelang.backends.files import program_files
    from scenelang.session.formatting import FormattedFile, format_file

    names = program_files(arguments.files)
    if arguments.lines is not None and len(names) != 1:
        raise UsageError("value", f"--lines accepts only one file, got {len(names)}")
    files: list[FormattedFile] = []
    for name in names:
        file = format_file(name, arguments.lines)
        try:
            _deliver(arguments, name, file)
        except SceneError as error:
            file = FormattedFile(file.name, diagnostics=(error.diagnostic,))
        files.append(file)
    _report_formatted(arguments, files)
    failed = any(file.after is None for file in files)
    return 1 if failed or (arguments.check and any(file.changes for file in files)) else 0


def _deliver(arguments: argparse.Namespace, name: str, file: FormattedFile) -> None:
    """Write or print one formatted file, as the options ask."""
    from pathlib import Path

    if file.after is None:
        return
    only_shown = arguments.check or arguments.diff
    if arguments.diff and file.changes and not arguments.json:
        sys.stdout.writelines(painted(file.difference(), use_color(arguments, sys.stdout)))
    if name == "-" and not only_shown and not arguments.json:
        sys.stdout.flush()
        sys.stdout.buffer.write(file.after.encode("utf-8"))
    elif file.changes and not only_shown and name != "-":
        from scenelang.backends.files import rewrite

        rewrite(Path(name), file.after)
    if file.changes and name != "-" and not arguments.json and not arguments.quiet and not arguments.diff:
        say(f"{'would format' if arguments.check else 'formatted'} {name}")


def _report_formatted(arguments: argparse.Namespace, files: Sequence[FormattedFile]) -> None:
    """Report the diagnostics of formatting, and faults of the formatter."""
    diagnostics = [diagnostic for file in files for diagnostic in file.diagnostics]
    if arguments.json:
        print_json({"files": [file.data() for file in files], "diagnostics": [to_json(d) for d in diagnostics]})
    elif diagnostics:
        report(arguments, diagnostics)
    for file in files:
        if file.fault is not None:
            print(f"internal error: {file.fault} (the file is unchanged; please report it)", file=sys.stderr)


# --- diff ------------------------------------------------------------------------------------------------------------


def add_diff(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``diff``."""
    parser.add_argument("a", metavar="A", help="first program, or flattened scene (.json)")
    parser.add_argument("b", metavar="B", help="second program, or flattened scene (.json)")
    parser.add_argument(
        "--tolerance", type=reader(part_of_one), default=1e-5, metavar="T",
        help="relative tolerance, as a fraction of the scene's size (default 1e-5)",
    )  # fmt: skip
    parser.add_argument(
        "--limit", type=whole, default=20, metavar="N", help="maximum number of changes to print (default 20)"
    )


def run_diff(arguments: argparse.Namespace) -> int:
    """Compare two scenes; exit code 1 if they differ."""
    from scenelang.session.scene_changes import change_lines, changes_between

    if arguments.a == arguments.b == "-":
        raise UsageError("file", "only one of the two inputs can be standard input")
    sides: list[Sequence[ComparedFrame]] = []
    for path in (arguments.a, arguments.b):
        with bounded(arguments):
            sides.append(_compared_frames(arguments, path))
    with bounded(arguments):
        changes = changes_between(sides[0], sides[1], arguments.tolerance)
    print_result(arguments, changes.data(), "\n".join(change_lines(changes, arguments.limit)))
    return 0 if changes.equal else 1


def _compared_frames(arguments: argparse.Namespace, path: str) -> Sequence[ComparedFrame]:
    """Return the frames of a program or a JSON file; raises ReportedError if the program has errors."""
    from scenelang.session.scene_changes import compared_frames, compared_frames_in

    limit = session_limit(arguments)
    sheets = compared_frames_in(path, limit)
    if sheets is not None:
        return sheets
    arguments.file = path  # used to locate the embeddings beside the program
    return compared_frames(evaluated(arguments), limit)


# --- transpile, import, grammar --------------------------------------------------------------------------------------


def add_transpile(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``transpile``."""
    parser.description = "Translate the Python of a language model's response to a program. It is never executed."
    parser.add_argument("file", metavar="FILE", help="response (.txt), Python program (.py), or `-` for standard input")
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="output program (default: standard output)")
    parser.add_argument("--literal", action="store_true", help="follow the Python closely; do not simplify the program")
    add_output(parser)
    add_limits(parser)


def run_transpile(arguments: argparse.Namespace) -> int:
    """Translate Python and print or write the program."""
    from pathlib import Path

    from scenelang.session.session import Options, Session

    if arguments.output is not None and Path(arguments.output).resolve() == Path(arguments.file).resolve():
        raise UsageError("file", "the output would overwrite the input")
    if arguments.file.endswith(".scene"):
        name = Path(arguments.file)
        hint = f"for Python of it: `scenelang export {name} --to python -o {name.with_suffix('.py').name}`"
        raise UsageError("unsupported", f"{name} is a program already; `transpile` reads Python or a response", hint)
    session = Session(Options(limits=limits_of(arguments)))
    translation = session.transpile(session.source(arguments.file), arguments.literal)
    report(arguments, translation.diagnostics)
    if not translation.ok:
        return 1
    deliver(translation.text, arguments.output)
    return 0


def add_simplify(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``simplify``."""
    parser.description = "Rewrite a program as a person would write it, and print the diff. The scene stays the same."
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="write the program; OUT.scene may be FILE itself")


def run_simplify(arguments: argparse.Namespace) -> int:
    """Rewrite a program, and write it or print the diff."""
    from scenelang.session.formatting import difference

    if arguments.output is not None and str(arguments.output).endswith(".py"):
        raise UsageError("value", "`simplify` writes programs of the language", "`export --to python` writes Python")
    session = session_of(arguments)
    source = session.source(arguments.file)
    lifted, diagnostics = session.lift(source)
    report(arguments, diagnostics)
    if lifted is None:
        return 1
    if arguments.output is not None:
        deliver(lifted, arguments.output)
    else:
        changes = difference(source.text, lifted, arguments.file, "simplified")
        sys.stdout.writelines(painted(changes, use_color(arguments, sys.stdout)))
    return 0


def add_import(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``import``."""
    parser.add_argument(
        "file",
        metavar="FILE",
        help="file to import: .scad (OpenSCAD), .py (a Blender script, or .txt), .schem, .litematic or .nbt",
    )
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="output program (default: standard output)")


def run_import(arguments: argparse.Namespace) -> int:
    """Convert a file of another program to a scene program."""
    from pathlib import Path

    from scenelang.session.session import IMPORTED_ENDINGS, SCRIPT_ENDINGS, other_file_error

    output = Path(arguments.output) if arguments.output else None
    if output is not None:
        if output.suffix != ".scene":
            raise UsageError("backend", f"cannot write a program to `{output.name}`", "use .scene")
        check_folder(output)
    path = Path(arguments.file)
    if path.suffix.lower() not in (*IMPORTED_ENDINGS, *SCRIPT_ENDINGS):
        reads = ", ".join((*IMPORTED_ENDINGS, ".py"))
        wrong = other_file_error(str(path))
        if wrong is not None:
            raise SceneError("file", f"{wrong.message}; `import` reads {reads}", wrong.hint)
        message = f"`{path.name}` is no file that can be imported; expected {reads}"
        hint = f'it is a program already; a program uses it by `(import "{path.name}")`'
        raise SceneError("file", message, hint if path.suffix == ".scene" else None)
    if path.suffix.lower() == ".scad":
        from scenelang.backends.openscad.converting import imported
    elif path.suffix.lower() in SCRIPT_ENDINGS:
        from scenelang.backends.blender.importing import imported
    else:
        from scenelang.backends.minecraft.export import imported
    text, warnings = imported(path)
    deliver(text, arguments.output)
    if output is not None:
        done(arguments, output)
    report(arguments, warnings)
    return 0


def add_grammar(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``grammar``."""
    from scenelang.stdlib.reference import GRAMMARS

    parser.description = (
        "Export the grammar of syntactically valid programs with well-formed special forms. "
        "A local model can use it for grammar-constrained decoding (docs/grammar.md)."
    )
    parser.add_argument("--format", required=True, choices=GRAMMARS, help="grammar format")
    parser.add_argument("--strict", action="store_true", help="the paper's grammar, as enforced by check --strict")
    parser.add_argument("-o", "--output", metavar="FILE", help="output file (default: standard output)")


def run_grammar(arguments: argparse.Namespace) -> int:
    """Print or write a grammar."""
    from scenelang.stdlib.reference import grammar_text

    with usage_errors():
        text = grammar_text(arguments.format, arguments.strict)
    deliver(text, arguments.output)
    return 0


# --- explain, doctor -------------------------------------------------------------------------------------------------


def add_explain(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``explain``."""
    parser.description = "Explain diagnostics by code (E301) or name (unbound); without arguments, list all of them."
    parser.add_argument("codes", metavar="CODE", nargs="*", help="code or name of an error or warning")


def run_explain(arguments: argparse.Namespace) -> int:
    """Explain diagnostics, or list all of them."""
    names = [require_diagnostic(code) for code in arguments.codes]
    return print_result(arguments, [explanation_data(name) for name in names or by_code()], explained(names))


def add_search(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``search``."""
    parser.description = "Search the names of the language, its diagnostics and examples by meaning."
    parser.add_argument("words", metavar="WORD", nargs="+", help="what to search for, such as: copies in a circle")
    parser.add_argument("--limit", type=whole, default=8, metavar="N", help="maximum number of results (default 8)")


def run_search(arguments: argparse.Namespace) -> int:
    """Print the reference entries that fit a query best."""
    from scenelang.reference.searching import search

    results = search(" ".join(arguments.words), arguments.limit)
    text = "\n".join(result.text() for result in results)
    return print_result(arguments, [result.data() for result in results], text or "nothing was found")


def add_doctor(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``doctor``."""
    parser.description = (
        "Run a quick test of every feature, and report what is missing and how to install it. "
        "The exit code is 1 only if a feature that needs no extra is broken."
    )


def run_doctor(arguments: argparse.Namespace) -> int:
    """Check the installation; exit code 1 if a required feature is broken."""
    from scenelang.doctor.doctor import CheckState, checks, report_lines

    results = list(checks())
    lines = report_lines(results, use_color(arguments, sys.stdout))
    print_result(arguments, [check.data() for check in results], "\n".join(lines))
    return 1 if any(check.state is CheckState.BROKEN for check in results) else 0


# --- repl, lsp, mcp, completion ---------------------------------------------------------------------------------------


SHELLS = ("bash", "zsh", "fish")


# --- repl ------------------------------------------------------------------------------------------------------------


def add_repl(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``repl``."""
    parser.description = (
        "Enter forms and print their values. `,help` lists the commands. Without a terminal, forms are read "
        "from standard input, values are written to standard output and diagnostics to standard error."
    )
    parser.add_argument("file", metavar="FILE", nargs="?", help="program to load at startup")
    parser.add_argument("--plain", action="store_true", help="disable terminal features (implied without a terminal)")
    parser.add_argument("--prompt", metavar="TEXT", help="prompt written before each line is read, in plain mode")
    parser.add_argument("--strict-errors", action="store_true", help="exit 1 if an input had errors, in plain mode")


def _model_request(command: str, line: str) -> ModelRequest:
    """Parse a command of the REPL that calls a language model; imported only when one is used."""
    from scenelang.cli.models import model_request

    return model_request(command, line)


def run_repl(arguments: argparse.Namespace) -> int:
    """Start an interactive session, with terminal features if there is a terminal."""
    from scenelang.repl.evaluation import ReplEvaluation

    file = arguments.file
    is_terminal = sys.stdin.isatty() and sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    is_plain = arguments.plain or arguments.json or not is_terminal
    arguments.file = file or "-"  # locates the embeddings file
    evaluation = ReplEvaluation(session_of(arguments), file)
    if not is_plain and not all(map(is_present, ("prompt_toolkit", "pygments"))):
        print("no colors, history or completion; install them with `pip install 'scenelang[repl]'`", file=sys.stderr)
        is_plain = True
    if not is_plain:
        from scenelang.repl.console import run

        run(evaluation, use_color(arguments, sys.stdout), arguments.quiet, _model_request)
        return 0
    from scenelang.repl.plain import standard

    prompt = arguments.prompt
    if prompt is None:
        prompt = "> " if sys.stdin.isatty() and not arguments.json else ""
    errors = standard(prompt, arguments.json, arguments.quiet, _model_request).run(evaluation)
    return 1 if errors and arguments.strict_errors else 0


# --- lsp, mcp --------------------------------------------------------------------------------------------------------


def add_lsp(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``lsp``."""
    parser.add_argument(
        "--stdio", action="store_true", help="use standard input and output (the only transport; for compatibility)"
    )


def run_lsp(arguments: argparse.Namespace) -> int:
    """Serve an editor on standard input and output."""
    from scenelang.backends.base import require

    require("pygls", "'scenelang[lsp]'")
    from importlib.metadata import version

    from scenelang.lsp.server import serve
    from scenelang.sandbox.environment import keep_named_variables

    keep_named_variables()  # macros of the programs that are edited run in this process
    serve(version("scenelang"))
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - the server has closed the original stdout
    return 0


def add_mcp(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``mcp``."""
    parser.description = (
        "Start a server of the Model Context Protocol: agents write, check, run, measure, render, compare, repair "
        "and save programs. It reads and writes only in the project folder."
    )
    parser.add_argument(
        "--project",
        metavar="DIR",
        help="project folder, which keeps the sessions in .scenelang/sessions; no other files are read or written "
        "(default: the current folder, which keeps none)",
    )
    parser.add_argument("--read-only", action="store_true", help="leave out the tools that write files")
    add_limits(parser)


def run_mcp(arguments: argparse.Namespace) -> int:
    """Serve agents on standard input and output."""
    from pathlib import Path

    folder = Path(arguments.project or ".")
    if not folder.is_dir():
        raise UsageError("file", f"not a folder: {arguments.project}")
    from scenelang.backends.base import require

    require("mcp", "'scenelang[mcp]'")
    from importlib.metadata import version

    from scenelang.mcp.server import serve

    try:
        keeps = arguments.project is not None
        serve(folder.resolve(), limits_of(arguments), version("scenelang"), not arguments.read_only, keeps)
    except* OSError as group:  # of the tasks that read and write
        raise _first(group) from None
    return 0


def _first(error: BaseException) -> BaseException:
    """Return the first exception in a group of groups."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


# --- completion ------------------------------------------------------------------------------------------------------


def add_completion(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``completion``."""
    parser.description = (
        "Print a completion script for commands, options, choices, files and a program's words. For bash "
        'add `eval "$(scenelang completion bash)"` to ~/.bashrc, for zsh the same with zsh to ~/.zshrc after '
        "`compinit`; for fish write it to ~/.config/fish/completions/scenelang.fish."
    )
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help="shell: bash, zsh or fish")


def run_completion(arguments: argparse.Namespace) -> int:
    """Print a shell's completion script."""
    from argcomplete.shell_integration import shellcode

    code = shellcode(["scenelang", "scene"], shell=arguments.shell, complete_arguments=["-o", "nospace"])  # nosec B604
    sys.stdout.write(code)
    return 0
