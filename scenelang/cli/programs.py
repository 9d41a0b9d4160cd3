"""Commands about programs: check, run, expand, tree, flatten, count, bounds."""

from __future__ import annotations

import argparse
import codecs
import sys
import time
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.files import read_regular, rewrite
from scenelang.cli.options import UsageError, add_common, add_file, limits_of, program_files, session_of, whole
from scenelang.cli.output import print_json, report, report_run, say, table
from scenelang.grammar.datum import Atom, Datum, ListDatum, Source, Symbol, walk
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.scene.entity import count_words
from scenelang.primer import summary, summary_rows
from scenelang.sandbox.supervision import limited
from scenelang.session import Evaluated, Session

if TYPE_CHECKING:
    from scenelang.interpreter.program.program import Program

_FIRST_LINES = 10_000


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


# --- check, run, expand --------------------------------------------------------------------------------------------


def add_check(subparsers: Any) -> None:
    parser = subparsers.add_parser("check", help="find mistakes without running the program")
    parser.add_argument("files", metavar="FILE", nargs="+", help="programs, folders of them, `-` for standard input")
    parser.add_argument("--strict", action="store_true", help="hold the program to the paper's grammar")
    parser.add_argument("--run", action="store_true", dest="evaluate", help="evaluate the programs as well")
    parser.add_argument("--geometry", action="store_true", help="evaluate, and look for odd overlaps, gaps and faces")
    parser.add_argument("--fix", action="store_true", help="mend what can be mended without changing what programs do")
    add_common(parser)
    parser.set_defaults(run=check, file="-")


def check(arguments: argparse.Namespace) -> int:
    found: list[Diagnostic] = []
    session: Session | None = None
    files = program_files(arguments.files)
    if arguments.fix and not all(path.endswith(".scene") for path in files):
        raise UsageError("value", "--fix mends files of the language (.scene)")
    for path in files:
        arguments.file = path
        session = session or session_of(arguments, arguments.strict)
        try:
            source = _mended(arguments, session, path) if arguments.fix else session.source(path)
            if arguments.geometry:
                found += session.check_geometry(source)
            else:
                found += (session.evaluate(source) if arguments.evaluate else session.check(source)).diagnostics
        except SceneError as error:
            found.append(error.diagnostic)
    report(arguments, found, sys.stdout if arguments.json else None)
    return 1 if any(d.is_error for d in found) else 0


def _mended(arguments: argparse.Namespace, session: Session, path: str) -> Source:
    """The program after every safe fix, written back to its file."""
    before = session.source(path)
    source, number = session.mended(before)
    if number:
        mark = "\ufeff" if read_regular(path, 3).startswith(codecs.BOM_UTF8) else ""
        rewrite(Path(path), mark + source.text)
        if not arguments.quiet:
            print(f"{path}: {number} {'fix' if number == 1 else 'fixes'} applied", file=sys.stderr)
    return source


def add_run(subparsers: Any) -> None:
    parser = subparsers.add_parser("run", help="evaluate a program and say what the scene is")
    add_file(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    session = session_of(arguments)
    source = session.source(arguments.file)
    started = time.perf_counter()
    with limited(session.options.limits):
        result = session.evaluate(source)
        seconds = time.perf_counter() - started
        facts = summary(result.scene) if result.scene is not None else None
    report_run(arguments, result)
    if facts is None:
        return 1
    if arguments.json:
        print_json(facts | {"seconds": seconds})
    else:
        say(table([*summary_rows(facts), ("time", f"{seconds:.3f} s")], (False, False)))
    return 0


def add_expand(subparsers: Any) -> None:
    parser = subparsers.add_parser("expand", help="print the program after macro expansion")
    add_file(parser)
    add_common(parser)
    parser.set_defaults(run=expand)


def expand(arguments: argparse.Namespace) -> int:
    session = session_of(arguments)
    checked = session.check(session.source(arguments.file))
    report_needed = [d for d in checked.diagnostics if d.is_error]
    if not report_needed and checked.program is None:
        raise SceneError("unsupported", f"{arguments.file} is a scene, not a program, so there is nothing to expand")
    if report_needed or checked.program is None:
        report(arguments, checked.diagnostics)
        return 1
    print(expansion(session, checked.program), end="")
    return 0


def expansion(session: Session, program: Program) -> str:
    """The text of a program after macro expansion."""
    from scenelang.grammar.layout import layout
    from scenelang.grammar.reader import read
    from scenelang.interpreter.compile.analyse import mentioned
    from scenelang.interpreter.compile.unparse import unparse
    from scenelang.interpreter.expand.forms import INDENTS

    forms = [*program.forms, *([program.scene] if program.scene else [])]
    params = {param.span for param in program.params}
    imports = (f'(import "{module}")' for module in session.library_imports(program))
    datums: list[Datum] = list(read(Source("<expansion>", "\n".join(imports))).forms)
    spelling: dict[int, str] = {}
    kept = frozenset(variable for form in forms if form.span in params for variable in mentioned(form))
    for datum, form in zip(unparse(forms, kept), forms):
        if form.span in params:  # as written, so that the expansion can be overridden too
            (datum,) = read(Source(form.span.source.name, form.span.text)).forms
            spelling |= {id(atom): atom.span.text for atom in walk(datum) if isinstance(atom, Atom)}
        elif form is program.scene and isinstance(datum, ListDatum):
            datum = ListDatum((Atom(Symbol("scene"), datum.span), *datum.items[1:]), None, datum.span)
        datums.append(datum)
    return layout(datums, indents=INDENTS, spelling=spelling)


# --- count, bounds -------------------------------------------------------------------------------------------------


def add_count(subparsers: Any) -> None:
    parser = subparsers.add_parser("count", help="count the instances of every word")
    add_file(parser)
    parser.add_argument("--frame", type=whole, default=0, metavar="N", help="frame of a 4D scene (default 0)")
    add_common(parser)
    parser.set_defaults(run=count)


def count(arguments: argparse.Namespace) -> int:
    with limited(limits_of(arguments)):
        result = evaluated(arguments)
        if result.scene is None:
            return 1
        frames = result.scene.frames
        if arguments.frame >= len(frames):
            said = f"there is no frame {arguments.frame}; the scene has {len(frames)}, counted from 0"
            raise SceneError("value", said)
        counts = count_words(frames[arguments.frame])
    if arguments.json:
        print_json(counts)
    else:
        if result.scene.animated:
            say(f"frame {arguments.frame} of {len(frames)}:")
        say(table([(f"{n:,}", word) for word, n in counts.items()], (True, False)))
    return 0


def add_bounds(subparsers: Any) -> None:
    parser = subparsers.add_parser("bounds", help="the exact bounding box of the scene, or of a word's entities")
    add_file(parser)
    parser.add_argument("--word", help="only the entities of this word, in the world's frame")
    add_common(parser)
    parser.set_defaults(run=bounds)


def bounds(arguments: argparse.Namespace) -> int:
    from scenelang.interpreter.scene.bounds import word_box

    with limited(limits_of(arguments)):
        result = evaluated(arguments)
        if result.scene is None:
            return 1
        box = word_box(result.scene, arguments.word)
    if box is None:
        what = f'"{arguments.word}"' if arguments.word else "the scene"
        raise SceneError("empty-scene", f"{what} has no geometry, so it has no bounding box")
    low, high = list(box[:3]), list(box[3:])
    facts = {
        "min": low,
        "max": high,
        "center": [(a + b) / 2 for a, b in zip(low, high)],
        "sizes": [b - a for a, b in zip(low, high)],
    }
    if arguments.json:
        print_json(facts)
    else:
        rows = [(name, *(f"{x:.6g}" for x in values)) for name, values in facts.items()]
        say(table(rows, (False, True, True, True)))
    return 0


# --- tree, flatten -------------------------------------------------------------------------------------------------


def add_tree(subparsers: Any) -> None:
    parser = subparsers.add_parser("tree", help="print the entity hierarchy")
    add_file(parser)
    parser.add_argument("--depth", type=whole, metavar="N", help="levels below the root")
    parser.add_argument("--poses", action="store_true", help="also the pose of every part")
    parser.add_argument("--all", action="store_true", help="every instance: no counts of repeated parts")
    add_common(parser)
    parser.set_defaults(run=tree)


def tree(arguments: argparse.Namespace) -> int:
    from scenelang.interpreter.scene.outline import outline, outline_data

    with limited(limits_of(arguments)):
        result = evaluated(arguments)
        if result.scene is None:
            return 1
        if arguments.json:
            data = outline_data(result.scene, arguments.depth)
        else:
            lines = outline(result.scene, arguments.depth, arguments.poses, arguments.all)
            first = list(islice(lines, _FIRST_LINES))
    if arguments.json:
        print_json(data)
        return 0
    for line in chain(first, lines):  # who reads them may take their time
        say(line)
    return 0


def add_flatten(subparsers: Any) -> None:
    parser = subparsers.add_parser("flatten", help="the primitives with their world matrices")
    add_file(parser)
    add_common(parser)
    parser.set_defaults(run=flatten)


def flatten(arguments: argparse.Namespace) -> int:
    from scenelang.interpreter.scene.flatten import flatten as flatten_scene
    from scenelang.interpreter.scene.numbering import primitive_handles

    with limited(limits_of(arguments)):
        result = evaluated(arguments)
        if result.scene is None:
            return 1
        flat = flatten_scene(result.scene, session_limit(arguments))
        handles = primitive_handles(result.scene, flat) if arguments.json else []
    if not arguments.json:
        for number, frame in enumerate(flat.frames):
            label = f"frame {number}: " if flat.animated else ""
            say(f"{label}{len(frame):,} primitives, {len(frame.primitives):,} distinct")
        return 0
    _write_flat(flat, handles)
    return 0


def session_limit(arguments: argparse.Namespace) -> int:
    return limits_of(arguments).primitives


def _write_flat(flat: Any, handles: Any) -> None:
    """The flattened scene as JSON, primitive by primitive, so that memory stays small."""
    import json

    from scenelang.interpreter.runtime.show import primitive_attributes

    out = sys.stdout
    out.write(f'{{"root": {json.dumps(flat.word)}, "frames": [')
    for position, (frame, names) in enumerate(zip(flat.frames, handles)):
        out.write((", " if position else "") + '{"primitives": [')
        words = [json.dumps(entity.word) for entity in frame.primitives]
        attributes = [json.dumps(primitive_attributes(entity)) for entity in frame.primitives]
        paths = [json.dumps(path) for path in frame.paths]
        for i in range(len(frame)):
            k = frame.index[i]
            matrix = [*frame.matrices[i].tolist(), [0.0, 0.0, 0.0, 1.0]]
            handle, path = json.dumps(f"<{names[i]}>"), paths[frame.path_index[i]]
            out.write(
                f'{", " if i else ""}{{"word": {words[k]}, "attributes": {attributes[k]}, '
                f'"handle": {handle}, "matrix": {matrix}, "path": {path}}}'
            )
        out.write("]}")
    out.write("]}\n")


COMMANDS = (add_check, add_run, add_tree, add_flatten, add_count, add_bounds, add_expand)
