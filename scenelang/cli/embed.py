"""The command embed: what numbers say in words, so that neural backends get a text for every primitive."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.model_options import add_spending, describer
from scenelang.cli.options import UsageError, add_common, add_file, session_of, usage_errors, z_path
from scenelang.cli.output import print_json, report_run, say, table
from scenelang.cli.programs import evaluated
from scenelang.grammar.diagnostics import SceneError
from scenelang.session import Evaluated, Session, is_scene_file

if TYPE_CHECKING:
    from scenelang.backends.neural.wording import Wording, WordingRow

MAX_ROWS = 500
_SHOWN = 3  # handles of a row that are spelled out


def add_embed(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "embed",
        help="describe every primitive in words, for neural backends",
        description="Turn colours, surfaces, proportions and other numbers of every primitive into words, and store "
        "these texts, with the templates that use them, in Z beside the program.",
    )
    add_file(parser)
    parser.add_argument(
        "--template",
        metavar="TEXT",
        help="the sentence about a primitive; {embedding}, {word} and {style} stand for its handle, what it is and the "
        "root's handle (default: a {embedding} {word}, in the style of {style}, 3D model)",
    )
    parser.add_argument(
        "--model", nargs="?", const="", metavar="NAME", help="let a language model find the words (default: a table)"
    )
    add_spending(parser)
    parser.add_argument("--force", action="store_true", help="describe anew what Z describes already")
    parser.add_argument("--print", action="store_true", dest="only_print", help="show the words, write nothing")
    add_common(parser)
    parser.set_defaults(run=embed)


def embed(arguments: argparse.Namespace) -> int:
    from scenelang.backends.neural.wording import DEFAULT, LIMIT, check_template, merged, wording_of
    from scenelang.zfile import read_wording, write_wording

    template = DEFAULT if arguments.template is None else arguments.template
    with usage_errors():
        check_template(template)
    path = z_path(arguments)
    target = None if arguments.only_print else _target(arguments, path)
    is_new = target is not None and not target.exists()
    result = _evaluated_without_z(arguments) if is_new else evaluated(arguments)
    if result.scene is None:
        return 1
    old = None if path is None or is_new or arguments.force else read_wording(path)
    if arguments.model is not None and old is not None:
        raise UsageError("value", "Z describes this scene already", "--force lets the model find words anew")
    describe = None if arguments.model is None else describer(arguments)
    wording = wording_of(result.scene, template, describe, int(arguments.max_primitives or LIMIT))
    wording, known = (wording, 0) if old is None else merged(old, wording)
    if target is not None:
        write_wording(target, wording)
    if arguments.json:
        print_json(_data(wording))
    elif target is None:
        say(_table(wording))
    elif not arguments.quiet:
        say(_summary(target, wording, known))
    if describe is not None and not arguments.quiet:
        print(f"asking cost ${describe.spent:.4f}", file=sys.stderr)
    return 0


def _evaluated_without_z(arguments: argparse.Namespace) -> Evaluated:
    """Evaluate the command's file; the Z that `--z` names is only to be made."""
    without = argparse.Namespace(**{**vars(arguments), "z": None})
    session = Session(replace(session_of(without).options, z_entries={}))
    result = session.evaluate(session.source(arguments.file))
    report_run(arguments, result)
    return result


def _target(arguments: argparse.Namespace, path: Path | None) -> Path:
    """Where the wording goes; raises SceneError where there is no such place."""
    from scenelang.zfile import beside

    if arguments.file == "-":
        if path is None:
            raise UsageError("file", "say where Z is: --z FILE", "or look at the words with --print")
        return path
    if is_scene_file(Session().source(arguments.file)):
        hint = "embed the program that made it, or look at the words with --print"
        raise SceneError("unsupported", f"{arguments.file} is a finished scene, which takes no embeddings", hint)
    return path or beside(arguments.file)


def _summary(target: Path, wording: Wording, known: int) -> str:
    handles = {handle for row in wording.rows for handle in row.handles}
    texts = {row.text for row in wording.rows}
    said = f"wrote {target}: {_counted(len(texts), 'text')} for {_counted(len(handles), 'embedding')}"
    return f"{said}; {known:,} were there before (--force describes them anew)" if known else said


def _counted(number: int, what: str) -> str:
    return f"{number:,} {what}{'' if number == 1 else 's'}"


def _table(wording: Wording) -> str:
    from scenelang.backends.neural.wording import filled

    rows = [
        (_handles(row), row.word, row.text, filled(row.template, row.handles[0])) for row in wording.rows[:MAX_ROWS]
    ]
    lines = [f"the style is <{wording.style}>, {wording.style_text}", ""]
    lines.append(table([("handle", "word", "text", "template"), *rows], (False,) * 4))
    if len(wording.rows) > MAX_ROWS:
        lines.append(f"... only the first {MAX_ROWS} rows are shown")
    return "\n".join(lines)


def _handles(row: WordingRow) -> str:
    shown = " ".join(f"<{handle}>" for handle in row.handles[:_SHOWN])
    return shown if len(row.handles) <= _SHOWN else f"{shown} ... {len(row.handles):,} in all"


def _data(wording: Wording) -> Mapping[str, Any]:
    from scenelang.backends.neural.wording import plain_text

    return {
        "style": {"handle": f"<{wording.style}>", "text": wording.style_text},
        "rows": [
            {
                "word": row.word,
                "text": row.text,
                "template": row.template,
                "plain": plain_text(row.word, row.text),
                "handles": [f"<{handle}>" for handle in row.handles],
            }
            for row in wording.rows
        ],
    }


COMMANDS = (add_embed,)
