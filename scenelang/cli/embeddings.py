"""The commands embeddings and embed: what Z says of a scene's embeddings, and what numbers say in words."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.models import add_spending, live_stream, service_of
from scenelang.cli.neural import add_granularity, add_models, granularity_of, models_of, z_of
from scenelang.cli.options import UsageError, add_common, add_file, scene_of, usage_errors, whole, z_path
from scenelang.cli.output import check_folder, done, print_json, say, table

if TYPE_CHECKING:
    from scenelang.backends.neural.wording import Wording
    from scenelang.embeddings import EmbeddingRow

_SHOWN = 3  # handles of a row that are spelled out


def add_embeddings(parser: argparse.ArgumentParser) -> None:
    add_file(parser)
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    listing = actions.add_parser("list", help="every entity's handle, word, text and attributes")
    add_common(listing)
    listing.set_defaults(run=list_embeddings)
    setting = actions.add_parser("set", help="give a handle a text, attributes or the vector of a picture")
    setting.add_argument("handle", metavar="'<z5>'", help="a handle as `tree` shows it")
    setting.add_argument("--text", help="the text of the embedding")
    named = "an attribute, such as color=[1,0,0]"
    setting.add_argument("--attribute", action="append", default=[], metavar="NAME=VALUE", help=named)
    setting.add_argument("--image", metavar="FILE", help="a picture, which gives the handle a vector (a pseudo-word)")
    setting.add_argument("--start", metavar="TEXT", help="the word that the picture's vector starts from (object)")
    setting.add_argument("--model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder, for --image")
    setting.add_argument("--clear", action="store_true", help="forget what Z says of the handle first")
    add_models(setting)
    add_common(setting)
    setting.set_defaults(run=set_embedding)
    _add_vectors(actions)


def _add_vectors(actions: Any) -> None:
    """The actions that work with vectors."""
    encoding = actions.add_parser("encode", help="encode every primitive's sentence by OpenCLIP, and keep that in Z")
    encoding.add_argument("--model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder")
    add_granularity(encoding)
    add_models(encoding)
    add_common(encoding)
    encoding.set_defaults(run=encode)
    swapping = actions.add_parser("swap", help="exchange what Z says of two handles")
    swapping.add_argument("handle", metavar="'<z2>'")
    swapping.add_argument("other", metavar="'<z3>'")
    add_common(swapping)
    swapping.set_defaults(run=swap)
    comparing = actions.add_parser("similar", help="what is most like a handle, a text or a picture")
    comparing.add_argument("query", metavar="'<z2>'|TEXT|PICTURE")
    comparing.add_argument("-n", "--number", type=whole, default=10, metavar="N", help="how many (default 10)")
    add_models(comparing)
    add_common(comparing)
    comparing.set_defaults(run=similar)
    exporting = actions.add_parser("export", help="write the vectors in Z for other programs")
    exporting.add_argument("-o", "--output", metavar="OUT", required=True, help=".npz .safetensors .json")
    add_common(exporting)
    exporting.set_defaults(run=export)


def add_embed(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Turn colours, surfaces, proportions and other numbers of every primitive into words, and store "
        "these texts, with the templates that use them, in Z beside the program."
    )
    add_file(parser)
    parser.add_argument(
        "--template", metavar="TEXT",
        help="the sentence about a primitive; {embedding}, {word} and {style} stand for its handle, what it is and the "
        "root's handle (default: a {embedding} {word}, in the style of {style}, 3D model)",
    )  # fmt: skip
    words = "let a language model find the words (default: a table)"
    parser.add_argument("--model", nargs="?", const="", metavar="NAME", help=words)
    add_spending(parser)
    parser.add_argument("--force", action="store_true", help="describe anew what Z describes already")
    parser.add_argument("--print", action="store_true", dest="only_print", help="show the words, write nothing")
    add_common(parser)
    parser.set_defaults(run=embed)


def list_embeddings(arguments: argparse.Namespace) -> int:
    from scenelang.embeddings import MOST_ROWS, Embeddings

    scene = scene_of(arguments)
    if scene is None:
        return 1
    rows = Embeddings(z_path(arguments)).table(scene)
    if arguments.json:
        print_json([row.data() for row in rows])
        return 0
    shown = 5 if any(row.learned for row in rows) else 4
    cells = [("handle", "word", "text", "attributes", "learned vectors"), *map(_row_cells, rows)]
    say(table([row[:shown] for row in cells], (False,) * shown))
    if len(rows) == MOST_ROWS:
        say(f"... only the first {MOST_ROWS} are shown")
    return 0


def _row_cells(row: EmbeddingRow) -> tuple[str, ...]:
    from scenelang.interpreter.runtime.show import show

    attributes = " ".join(f":{key} {show(value, 40)}" for key, value in row.attributes.items())
    return f"<{row.handle}>", row.word, row.text or "", attributes, row.learned


def set_embedding(arguments: argparse.Namespace) -> int:
    from scenelang.embeddings import check_program, handle_name

    with usage_errors():
        name = handle_name(arguments.handle)
    if arguments.file != "-":
        check_program(arguments.file)
    z = z_of(arguments)
    path = z.place()
    if arguments.text is arguments.image is None and not arguments.attribute and not arguments.clear:
        raise UsageError("value", "nothing to set", "give --text, --attribute or --image")
    if arguments.start is not None and arguments.image is None:
        raise UsageError("value", "`--start` is the word that a picture's vector starts from: give one with --image")
    attributes = dict(map(_attribute, arguments.attribute))
    word = z.set(
        name, text=arguments.text, attributes=attributes, image=arguments.image, start=arguments.start,
        model=arguments.model, clear=arguments.clear, models=models_of(arguments),
    )  # fmt: skip
    if not arguments.quiet:
        told = f"; cosine {word.before:.3f} -> {word.cosine:.3f}" if word is not None else ""
        say(f"wrote {path}: <{name}>{told}")
    return 0


def _attribute(item: str) -> tuple[str, Any]:
    """The name and value of `NAME=VALUE`; raises UsageError."""
    from scenelang.embeddings import attribute_of

    key, sign, text = item.partition("=")
    if not sign or not key or not text.strip():
        raise UsageError("value", f"--attribute wants NAME=VALUE, got `{item}`")
    return key.lstrip(":").strip(), attribute_of(text)


def swap(arguments: argparse.Namespace) -> int:
    from scenelang.embeddings import Embeddings, handle_name

    with usage_errors():
        one, other = handle_name(arguments.handle), handle_name(arguments.other)
    z = Embeddings(z_path(arguments))
    z.swap(one, other)
    if not arguments.quiet:
        say(f"wrote {z.path}: <{one}> and <{other}> swapped; `encode` again if their sentences are needed")
    return 0


def encode(arguments: argparse.Namespace) -> int:
    scene = scene_of(arguments)
    if scene is None:
        return 1
    z = z_of(arguments)
    found = z.encode(
        scene, model=arguments.model, template=arguments.template, granularity=granularity_of(arguments),
        models=models_of(arguments),
    )  # fmt: skip
    if not arguments.quiet:
        count = sum(len(row.handles) for row in found.rows)
        say(f"wrote {z.path}: {len(found.rows):,} sentences of {count:,} embeddings, by {found.model}")
    return 0


def similar(arguments: argparse.Namespace) -> int:
    from scenelang.embeddings import Embeddings

    found = Embeddings(z_path(arguments)).similar(arguments.query, arguments.number, models=models_of(arguments))
    if arguments.json:
        print_json([row.data() for row in found])
        return 0
    cells = [(f"{row.cosine:.3f}", _some(row.handles, "({:,})"), row.prompt) for row in found]
    say(table([("cosine", "handles", "sentence"), *cells], (True, False, False)))
    return 0


def _some(handles: tuple[str, ...], rest: str) -> str:
    """The first handles; ``rest`` tells of how many there are."""
    shown = " ".join(f"<{handle}>" for handle in handles[:_SHOWN])
    return shown if len(handles) <= _SHOWN else f"{shown} ... {rest.format(len(handles))}"


def export(arguments: argparse.Namespace) -> int:
    from scenelang.embeddings import Embeddings, check_export

    output = Path(arguments.output)
    with usage_errors():
        check_export(output)
    check_folder(output)
    done(arguments, Embeddings(z_path(arguments)).export(output))
    return 0


def embed(arguments: argparse.Namespace) -> int:
    from scenelang.backends.neural.wording import DEFAULT, LIMIT, check_template
    from scenelang.embeddings import Embeddings, check_program
    from scenelang.inference.generation import describer

    with usage_errors():
        check_template(DEFAULT if arguments.template is None else arguments.template)
    if not arguments.only_print and arguments.file != "-":
        check_program(arguments.file, "embed the program that made it, or look at the words with --print")
    if not arguments.only_print and z_path(arguments) is None and arguments.file == "-":
        raise UsageError("file", "say where Z is: --z FILE", "or look at the words with --print")
    z = Embeddings(z_path(arguments)) if arguments.only_print else z_of(arguments)
    scene = scene_of(arguments, fresh=not arguments.only_print and not z.exists)
    if scene is None:
        return 1
    if arguments.model is not None and not arguments.force:
        with usage_errors():
            z.check_undescribed()
    describe = None if arguments.model is None else describer(service_of(arguments), live_stream(arguments))
    work = z.words_of if arguments.only_print else z.describe
    limit = int(arguments.max_primitives or LIMIT)
    found = work(scene, template=arguments.template, describe=describe, force=arguments.force, limit=limit)
    if arguments.json:
        print_json(found.data())
    elif arguments.only_print:
        say(_wording_table(found.wording))
    elif not arguments.quiet:
        before = f"; {found.known:,} were there before (--force describes them anew)" if found.known else ""
        say(f"wrote {z.path}: {found}{before}")
    if describe is not None and not arguments.quiet:
        print(f"asking cost ${describe.spent:.4f}", file=sys.stderr)
    return 0


def _wording_table(wording: Wording) -> str:
    from scenelang.backends.neural.wording import filled
    from scenelang.embeddings import MOST_ROWS

    titles = ("handle", "word", "text", "template")
    rows = [
        (_some(row.handles, "{:,} in all"), row.word, row.text, filled(row.template, row.handles[0]))
        for row in wording.rows[:MOST_ROWS]
    ]
    rest = [f"... only the first {MOST_ROWS} rows are shown"] if len(wording.rows) > MOST_ROWS else []
    head = f"the style is <{wording.style}>, {wording.style_text}"
    return "\n".join([head, "", table([titles, *rows], (False,) * 4), *rest])
