"""The commands of neural models, and the options that they share."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import session_of, whole, z_path
from scenelang.cli.output import report_run

if TYPE_CHECKING:
    from scenelang.backends.neural.sentences import Granularity
    from scenelang.backends.neural.weights import Models
    from scenelang.embeddings import Embeddings
    from scenelang.scene import Scene


# --- shared options --------------------------------------------------------------------------------------------------


def add_models(parser: argparse.ArgumentParser) -> None:
    """Where weights are, and what computes."""
    group = parser.add_argument_group("neural models")
    group.add_argument(
        "--models-dir", metavar="DIR", help="a folder that holds models, each in a folder of its own (SCENELANG_MODELS)"
    )
    group.add_argument("--offline", action="store_true", help="ask no hub for weights that are not on this machine")
    group.add_argument("--device", metavar="NAME", help="cpu, cuda, mps (default: the fastest there is)")


def models_of(arguments: argparse.Namespace) -> Models:
    from scenelang.backends.neural.weights import Models

    return Models(arguments.models_dir, arguments.offline, arguments.device)


def add_granularity(parser: Any) -> None:
    """Which entities are taken as one, and the sentence of each."""
    parser.add_argument("--depth", type=whole, metavar="N", help="take entities N below the root as one each")
    parser.add_argument(
        "--entity", action="append", default=[], metavar="NAME",
        help="take an entity as one: its handle '<z5>', its word, or the places of children from the root, 0/2; "
        "may be repeated",
    )  # fmt: skip
    parser.add_argument("--template", metavar="TEXT", help="the sentence, with {embedding}, {word} and {style}")


def granularity_of(arguments: argparse.Namespace) -> Granularity:
    from scenelang.backends.neural.sentences import Granularity

    return Granularity(arguments.depth, tuple(arguments.entity))


def z_of(arguments: argparse.Namespace) -> Embeddings:
    """The file of embeddings to write: the one named, else that beside the program, which may not be there yet."""
    from scenelang.embeddings import Embeddings
    from scenelang.zfile import beside

    return Embeddings(z_path(arguments) or (None if arguments.file == "-" else beside(arguments.file)))


def scene_from(arguments: argparse.Namespace, fresh: bool = False) -> Scene | None:
    """Evaluate the command's file and print what the run said; None for a wrong program. ``fresh``: the file of
    embeddings is only to be made."""
    from scenelang.scene import Scene

    known = argparse.Namespace(**{**vars(arguments), "z": None, "file": "-"}) if fresh else arguments
    session = session_of(known)
    result = session.evaluate(session.source(arguments.file))
    report_run(arguments, result)
    if result.scene is None:
        return None
    return Scene(result.scene, arguments.file, result.log, result.diagnostics, result.program, session.options)
