"""The commands embeddings and embed: what Z says of a scene's embeddings, and what numbers say in words."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from scenelang.backends.neural.wording import DEFAULT, LIMIT, check_template
from scenelang.cli.models import add_spending, live_stream, service_of
from scenelang.cli.neural import add_granularity, granularity_of, z_of
from scenelang.cli.options import (
    UsageError,
    add_common,
    add_models,
    models_of,
    scene_of,
    usage_errors,
    whole,
    z_path,
)
from scenelang.cli.output import check_folder, done, print_json, say, tell
from scenelang.embedding_reports import rows_table, similar_table, wording_table
from scenelang.embeddings import Embeddings, attribute_of, check_export, check_program, handle_name
from scenelang.inference.generation import describer


def add_embeddings(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (told, add, _) in _ACTIONS.items():
        action = actions.add_parser(name, help=told)
        add(action)
        add_common(action)


def run_embeddings(arguments: argparse.Namespace) -> int:
    run: Callable[[argparse.Namespace], int] = _ACTIONS[arguments.action][2]
    return run(arguments)


def _add_list(parser: argparse.ArgumentParser) -> None:
    """Nothing of its own."""


def _add_set(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("handle", metavar="'<z5>'", help="a handle as `tree` shows it")
    parser.add_argument("--text", help="the text of the embedding")
    named = "an attribute, such as color=[1,0,0]"
    parser.add_argument("--attribute", action="append", default=[], metavar="NAME=VALUE", help=named)
    parser.add_argument("--image", metavar="FILE", help="a picture, which gives the handle a vector (a pseudo-word)")
    parser.add_argument("--start", metavar="TEXT", help="the word that the picture's vector starts from (object)")
    parser.add_argument("--model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder, for --image")
    parser.add_argument("--clear", action="store_true", help="forget what Z says of the handle first")
    add_models(parser)


def _add_encode(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder")
    add_granularity(parser)
    add_models(parser)


def _add_swap(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("handle", metavar="'<z2>'")
    parser.add_argument("other", metavar="'<z3>'")


def _add_similar(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("query", metavar="'<z2>'|TEXT|PICTURE")
    parser.add_argument("-n", "--number", type=whole, default=10, metavar="N", help="how many (default 10)")
    add_models(parser)


def _add_export(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help=".npz .safetensors .json")


def add_embed(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Turn colours, surfaces, proportions and other numbers of every primitive into words, and store "
        "these texts, with the templates that use them, in Z beside the program."
    )
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


def _list(arguments: argparse.Namespace) -> int:
    scene = scene_of(arguments)
    rows = Embeddings(z_path(arguments)).table(scene)
    return tell(arguments, [row.data() for row in rows], rows_table(rows))


def _set(arguments: argparse.Namespace) -> int:
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
    key, sign, text = item.partition("=")
    if not sign or not key or not text.strip():
        raise UsageError("value", f"--attribute wants NAME=VALUE, got `{item}`")
    return key.lstrip(":").strip(), attribute_of(text)


def _swap(arguments: argparse.Namespace) -> int:
    with usage_errors():
        one, other = handle_name(arguments.handle), handle_name(arguments.other)
    z = Embeddings(z_path(arguments))
    z.swap(one, other)
    if not arguments.quiet:
        say(f"wrote {z.path}: <{one}> and <{other}> swapped; `encode` again if their sentences are needed")
    return 0


def _encode(arguments: argparse.Namespace) -> int:
    scene = scene_of(arguments)
    z = z_of(arguments)
    found = z.encode(
        scene, model=arguments.model, template=arguments.template, granularity=granularity_of(arguments),
        models=models_of(arguments),
    )  # fmt: skip
    if not arguments.quiet:
        count = sum(len(row.handles) for row in found.rows)
        say(f"wrote {z.path}: {len(found.rows):,} sentences of {count:,} embeddings, by {found.model}")
    return 0


def _similar(arguments: argparse.Namespace) -> int:
    found = Embeddings(z_path(arguments)).similar(arguments.query, arguments.number, models=models_of(arguments))
    return tell(arguments, [row.data() for row in found], similar_table(found))


def _export(arguments: argparse.Namespace) -> int:
    output = Path(arguments.output)
    with usage_errors():
        check_export(output)
    check_folder(output)
    done(arguments, Embeddings(z_path(arguments)).export(output))
    return 0


def run_embed(arguments: argparse.Namespace) -> int:
    with usage_errors():
        check_template(DEFAULT if arguments.template is None else arguments.template)
    if not arguments.only_print and arguments.file != "-":
        check_program(arguments.file, "embed the program that made it, or look at the words with --print")
    if not arguments.only_print and z_path(arguments) is None and arguments.file == "-":
        raise UsageError("file", "say where Z is: --z FILE", "or look at the words with --print")
    z = Embeddings(z_path(arguments)) if arguments.only_print else z_of(arguments)
    scene = scene_of(arguments, fresh=not arguments.only_print and not z.exists)
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
        say(wording_table(found.wording))
    elif not arguments.quiet:
        before = f"; {found.known:,} were there before (--force describes them anew)" if found.known else ""
        say(f"wrote {z.path}: {found}{before}")
    if describe is not None and not arguments.quiet:
        print(f"asking cost ${describe.spent:.4f}", file=sys.stderr)
    return 0


# The actions of ``embeddings``: help, what declares their arguments, and the work.
_ACTIONS: Mapping[str, tuple[str, Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int]]] = {
    "list": ("every entity's handle, word, text and attributes", _add_list, _list),
    "set": ("give a handle a text, attributes or the vector of a picture", _add_set, _set),
    "encode": ("encode every primitive's sentence by OpenCLIP, and keep that in Z", _add_encode, _encode),
    "swap": ("exchange what Z says of two handles", _add_swap, _swap),
    "similar": ("what is most like a handle, a text or a picture", _add_similar, _similar),
    "export": ("write the vectors in Z for other programs", _add_export, _export),
}
