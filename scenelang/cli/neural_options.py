"""Options that commands with neural models share."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenelang.backends.neural.weights import Shelf


def add_models(parser: argparse.ArgumentParser) -> None:
    """Where weights are, and what computes."""
    group = parser.add_argument_group("neural models")
    group.add_argument(
        "--models-dir", metavar="DIR", help="a folder that holds models, each in a folder of its own (SCENELANG_MODELS)"
    )
    group.add_argument("--offline", action="store_true", help="ask no hub for weights that are not on this machine")
    group.add_argument("--device", metavar="NAME", help="cpu, cuda, mps (default: the fastest there is)")


def shelf_of(arguments: argparse.Namespace) -> Shelf:
    """The shelf that the options name; raises SceneError("file")."""
    from scenelang.backends.neural.weights import shelf

    return shelf(arguments.models_dir, fetch=not arguments.offline)


def device_of(arguments: argparse.Namespace) -> str:
    """The device that the options name, or the fastest; raises SceneError("value") for one that is not here."""
    from scenelang.backends.neural.weights import device

    return device(arguments.device)
