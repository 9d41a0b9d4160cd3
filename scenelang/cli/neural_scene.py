"""What commands of neural backends have in common: which things of a scene are taken as a whole, and what is said of
each."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import whole, z_path

if TYPE_CHECKING:
    from scenelang.backends.neural.sentences import Granularity, Sayings
    from scenelang.interpreter.scene.entity import Scene


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


def sayings_of(arguments: argparse.Namespace) -> tuple[Sayings, Mapping[str, Any]]:
    """What Z says besides the program, and its learned vectors as arrays by handle; raises SceneError."""
    from scenelang.backends.neural.sentences import Sayings
    from scenelang.backends.neural.wording import DEFAULT
    from scenelang.zfile import read_wording, read_z

    template = arguments.template or DEFAULT
    path = z_path(arguments)
    if path is None or not path.exists():
        return Sayings(template=template), {}
    entries, vectors = read_z(path)
    wording = read_wording(path)
    texts = {handle: row.text for row in wording.rows for handle in row.handles} if wording is not None else {}
    if wording is not None:
        texts[wording.style] = wording.style_text
    texts |= {handle: entry.text for handle, entry in entries.items() if entry.text}
    kept = wording.rows if wording is not None and arguments.template is None else ()
    templates = {handle: row.template for row in kept for handle in row.handles}
    return Sayings(frozenset(vectors), texts, template, templates), vectors


def scene_prompt(arguments: argparse.Namespace, text: str, scene: Scene) -> str:
    """What the whole scene is: `--prompt`, else what the head of the file says, else the root's word."""
    from scenelang.backends.neural.describing import thing
    from scenelang.primer import stated_task

    stated = stated_task(text) if arguments.prompt is None else arguments.prompt
    return stated or thing(scene.root)


def tensors_of(vectors: Mapping[str, Any], device: str) -> dict[str, Any]:
    """Arrays by handle as tensors."""
    import torch

    return {handle: torch.from_numpy(vector).float().to(device) for handle, vector in vectors.items()}


def folder_of(text: str) -> Path:
    """A folder to write to, made where it is not there; raises SceneError("file")."""
    from scenelang.grammar.diagnostics import SceneError

    path = Path(text)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SceneError("file", f"`{path}` cannot be a folder: {error.strerror or error}") from error
    return path
