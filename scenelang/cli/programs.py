"""Commands about programs: check, run, tree, flatten, count, bounds, expand, fmt, diff, transpile, explain, grammar,
import, doctor."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.cli.options import (
    UsageError,
    add_limits,
    add_output,
    bounded,
    evaluated,
    limits_of,
    reader,
    session_limit,
    session_of,
    usage_errors,
    whole,
)
from scenelang.cli.output import check_folder, done, report, report_run, tell, use_color
from scenelang.grammar.diagnostics import (
    Diagnostic,
    SceneError,
    by_code,
    diagnostic_asked,
    explained,
    explanation_data,
    to_json,
)
from scenelang.grammar.settings import line_range, part_of_one
from scenelang.interpreter.scene.entity import count_words
from scenelang.reports import deliver, painted, print_json, say, table

if TYPE_CHECKING:
    from scenelang.formatting import FormattedFile
    from scenelang.interpreter.scene.difference import Sheet
    from scenelang.session import Session

_FIRST_LINES = 10_000


# --- check, run, expand --------------------------------------------------------------------------------------------


def add_check(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", metavar="FILE", nargs="+", help="programs, folders of them, `-` for standard input")
    parser.add_argument("--strict", action="store_true", help="hold the program to the paper's grammar")
    parser.add_argument("--run", action="store_true", dest="evaluate", help="evaluate the programs as well")
    parser.add_argument("--geometry", action="store_true", help="evaluate, and look for odd overlaps, gaps and faces")
    parser.add_argument("--fix", action="store_true", help="mend what can be mended without changing what programs do")


def run_check(arguments: argparse.Namespace) -> int:
    from scenelang.session import program_files

    found: list[Diagnostic] = []
    session: Session | None = None
    files = program_files(arguments.files)
    if arguments.fix and not all(path.endswith(".scene") for path in files):
        raise UsageError("value", "--fix mends files of the language (.scene)")
    for path in files:
        arguments.file = path
        session = session or session_of(arguments)
        try:
            found += _found_in(arguments, session, path)
        except SceneError as error:
            found.append(error.diagnostic)
    report(arguments, found, sys.stdout if arguments.json else None)
    return 1 if any(d.is_error for d in found) else 0


def _found_in(arguments: argparse.Namespace, session: Session, path: str) -> Sequence[Diagnostic]:
    """What is wrong with one file, after its fixes."""
    if arguments.fix:
        source, number = session.fix_file(path)
        if number and not arguments.quiet:
            print(f"{path}: {number} {'fix' if number == 1 else 'fixes'} applied", file=sys.stderr)
    else:
        source = session.source(path)
    if arguments.geometry:
        return session.check_geometry(source)
    return (session.evaluate(source) if arguments.evaluate else session.check(source)).diagnostics


def run_run(arguments: argparse.Namespace) -> int:
    from scenelang.primer import summary, summary_rows

    session = session_of(arguments)
    source = session.source(arguments.file)
    started = time.perf_counter()
    with bounded(arguments):
        result = session.evaluate(source)
        seconds = time.perf_counter() - started
        facts = summary(result.scene) if result.scene is not None else None
    report_run(arguments, result)
    if facts is None:
        return 1
    text = table([*summary_rows(facts), ("time", f"{seconds:.3f} s")], (False, False))
    return tell(arguments, facts | {"seconds": seconds}, text)


def run_expand(arguments: argparse.Namespace) -> int:
    session = session_of(arguments)
    checked = session.check(session.source(arguments.file))
    if checked.ok and checked.program is None:
        raise SceneError("unsupported", f"{arguments.file} is a scene, not a program, so there is nothing to expand")
    if not checked.ok or checked.program is None:
        report(arguments, checked.diagnostics)
        return 1
    print(session.expansion(checked.program), end="")
    return 0


# --- tree, flatten, count, bounds ------------------------------------------------------------------------------------


def add_tree(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--depth", type=whole, metavar="N", help="levels below the root")
    parser.add_argument("--poses", action="store_true", help="also the pose of every part")
    parser.add_argument("--all", action="store_true", help="every instance: no counts of repeated parts")


def run_tree(arguments: argparse.Namespace) -> int:
    from scenelang.interpreter.scene.outline import outline, outline_data

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
    for line in chain(first, lines):  # who reads them may take their time
        say(line)
    return 0


def run_flatten(arguments: argparse.Namespace) -> int:
    from scenelang.interpreter.scene.flatten import flatten as flatten_scene
    from scenelang.interpreter.scene.numbering import primitive_handles
    from scenelang.interpreter.scene.outline import flat_json

    with bounded(arguments):
        scene = evaluated(arguments)
        flat = flatten_scene(scene, session_limit(arguments))
        handles = primitive_handles(scene, flat) if arguments.json else []
    if arguments.json:
        sys.stdout.writelines(chain(flat_json(flat, handles), "\n"))
        return 0
    for number, frame in enumerate(flat.frames):
        label = f"frame {number}: " if flat.animated else ""
        say(f"{label}{len(frame):,} primitives, {len(frame.primitives):,} distinct")
    return 0


def add_count(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--frame", type=whole, default=0, metavar="N", help="frame of a 4D scene (default 0)")


def run_count(arguments: argparse.Namespace) -> int:
    with bounded(arguments):
        scene = evaluated(arguments)
        frames = scene.frames
        if arguments.frame >= len(frames):
            said = f"there is no frame {arguments.frame}; the scene has {len(frames)}, counted from 0"
            raise SceneError("value", said)
        counts = count_words(frames[arguments.frame])
    head = f"frame {arguments.frame} of {len(frames)}:\n" if scene.animated else ""
    return tell(arguments, counts, head + table([(f"{n:,}", word) for word, n in counts.items()], (True, False)))


def add_bounds(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--word", help="only the entities of this word, in the world's frame")


def run_bounds(arguments: argparse.Namespace) -> int:
    from scenelang.interpreter.scene.bounds import box_facts, word_box

    with bounded(arguments):
        scene = evaluated(arguments)
        box = word_box(scene, arguments.word)
    if box is None:
        what = f'"{arguments.word}"' if arguments.word else "the scene"
        raise SceneError("empty-scene", f"{what} has no geometry, so it has no bounding box")
    facts = box_facts(box)
    rows = [(name, *(f"{x:.6g}" for x in values)) for name, values in facts.items()]
    return tell(arguments, facts, table(rows, (False, True, True, True)))


# --- fmt -------------------------------------------------------------------------------------------------------------


def add_fmt(parser: argparse.ArgumentParser) -> None:
    parser.description = "Format programs in one style. Only white space changes. Without options files are rewritten."
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="programs, folders of them, `-` for standard input to output"
    )
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 if a file would change")
    parser.add_argument("--diff", action="store_true", help="change nothing; show what would change")
    span = "only the forms on lines A to B of one file"
    parser.add_argument("--lines", metavar="A:B", type=reader(line_range), help=span)


def run_fmt(arguments: argparse.Namespace) -> int:
    from scenelang.formatting import FormattedFile, format_file
    from scenelang.session import program_files

    names = program_files(arguments.files)
    if arguments.lines is not None and len(names) != 1:
        raise UsageError("value", f"--lines is for one file, got {len(names)}")
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
    found = [diagnostic for file in files for diagnostic in file.diagnostics]
    if arguments.json:
        print_json({"files": [file.data() for file in files], "diagnostics": [to_json(each) for each in found]})
    elif found:
        report(arguments, found)
    for file in files:
        if file.fault is not None:
            print(f"internal error: {file.fault} (the file is as it was; please report it)", file=sys.stderr)


# --- diff ------------------------------------------------------------------------------------------------------------


def add_diff(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("a", metavar="A", help="a program, or a flattened scene (.json)")
    parser.add_argument("b", metavar="B", help="a program, or a flattened scene (.json)")
    parser.add_argument(
        "--tolerance", type=reader(part_of_one), default=1e-5, metavar="T",
        help="differences up to this part of the scene's size do not count (default 1e-5)",
    )  # fmt: skip
    parser.add_argument("--limit", type=whole, default=20, metavar="N", help="changes to print (default 20)")


def run_diff(arguments: argparse.Namespace) -> int:
    from scenelang.scene_changes import change_lines, changes_between

    if arguments.a == arguments.b == "-":
        raise UsageError("file", "only one of the two can be standard input")
    sides: list[Sequence[Sheet]] = []
    for path in (arguments.a, arguments.b):
        with bounded(arguments):
            sides.append(_sheets(arguments, path))
    with bounded(arguments):
        found = changes_between(sides[0], sides[1], arguments.tolerance)
    tell(arguments, found.data(), "\n".join(change_lines(found, arguments.limit)))
    return 0 if found.equal else 1


def _sheets(arguments: argparse.Namespace, path: str) -> Sequence[Sheet]:
    """The frames of a program or a JSON file; raises Told for a wrong program."""
    from scenelang.scene_changes import sheets_in, sheets_of

    limit = session_limit(arguments)
    sheets = sheets_in(path, limit)
    if sheets is not None:
        return sheets
    arguments.file = path  # what the shared options look at: embeddings lie beside it
    return sheets_of(evaluated(arguments), limit)


# --- transpile, import, grammar --------------------------------------------------------------------------------------


def add_transpile(parser: argparse.ArgumentParser) -> None:
    parser.description = "Turn the Python of a language model's response into a program. The Python is never run."
    parser.add_argument(
        "file", metavar="FILE", help="a response (.txt), a Python program (.py), `-` for standard input"
    )
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="where to write it (default: standard output)")
    add_output(parser)
    add_limits(parser)


def run_transpile(arguments: argparse.Namespace) -> int:
    from scenelang.session import Options, Session

    if arguments.output is not None and Path(arguments.output).resolve() == Path(arguments.file).resolve():
        raise UsageError("file", "the output would replace the Python that it is made of")
    session = Session(Options(limits=limits_of(arguments)))
    translation = session.transpile(session.source(arguments.file))
    report(arguments, translation.diagnostics)
    if not translation.ok:
        return 1
    deliver(translation.text, arguments.output)
    return 0


def add_import(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="the build: .schem, .litematic or .nbt")
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="the program to write (default: standard output)")


def run_import(arguments: argparse.Namespace) -> int:
    from scenelang.backends.minecraft.export import imported

    output = Path(arguments.output) if arguments.output else None
    if output is not None:
        if output.suffix != ".scene":
            raise UsageError("backend", f"a program cannot be written as `{output.name}`", "use .scene")
        check_folder(output)
    text, warnings = imported(Path(arguments.file))
    deliver(text, arguments.output)
    if output is not None:
        done(arguments, output)
    report(arguments, warnings)
    return 0


def add_grammar(parser: argparse.ArgumentParser) -> None:
    from scenelang.stdlib.reference import GRAMMARS

    parser.description = (
        "Write the grammar of programs: text that reads and whose special forms have the right shape. "
        "Given to a decoder, it makes a local model write nothing else (docs/grammar.md)."
    )
    parser.add_argument("--format", required=True, choices=GRAMMARS, help="who is to read it")
    parser.add_argument("--strict", action="store_true", help="exactly the paper's grammar, as check --strict has it")
    parser.add_argument("-o", "--output", metavar="FILE", help="where to write it (default: standard output)")


def run_grammar(arguments: argparse.Namespace) -> int:
    from scenelang.stdlib.reference import grammar_text

    with usage_errors():
        text = grammar_text(arguments.format, arguments.strict)
    deliver(text, arguments.output)
    return 0


# --- explain, doctor -------------------------------------------------------------------------------------------------


def add_explain(parser: argparse.ArgumentParser) -> None:
    parser.description = "Explain codes such as E301, or names such as unbound; without any, list them all."
    parser.add_argument("codes", metavar="CODE", nargs="*", help="codes or names of errors and warnings")


def run_explain(arguments: argparse.Namespace) -> int:
    names = [diagnostic_asked(asked) for asked in arguments.codes]
    return tell(arguments, [explanation_data(name) for name in names or by_code()], explained(names))


def add_doctor(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Try all that scenelang can do, each for a moment, and say what is missing and how to get it. "
        "The exit code is 1 only where something that needs no extra is broken."
    )


def run_doctor(arguments: argparse.Namespace) -> int:
    from scenelang.doctor import CheckState, checks, report_lines

    found = list(checks())
    text = "\n".join(report_lines(found, use_color(arguments, sys.stdout)))
    if arguments.json:
        print_json([check.data() for check in found])
    else:
        print(text)
    return 1 if any(check.state is CheckState.BROKEN for check in found) else 0
