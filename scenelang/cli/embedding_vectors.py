"""Actions of the command embeddings that work with vectors: encode, similar, export; and swap; vectors of pictures
for set."""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.neural_options import add_models, device_of, shelf_of
from scenelang.cli.neural_scene import add_granularity, granularity_of, sayings_of, tensors_of
from scenelang.cli.options import UsageError, add_common, whole, z_path
from scenelang.cli.output import print_json, say, table
from scenelang.cli.pictures import check_folder, done
from scenelang.cli.programs import evaluated
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenelang.backends.neural.picture_words import PictureWord
    from scenelang.backends.neural.sentences import Encodings, PromptCondition
    from scenelang.interpreter.scene.entity import Scene
    from scenelang.zfile import Made

_PICTURES = (".png", ".jpg", ".jpeg", ".webp")
_EXPORTS = (".npz", ".safetensors", ".json")


def add_actions(actions: Any) -> None:
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
    exporting.add_argument("-o", "--output", metavar="OUT", required=True, help=" ".join(_EXPORTS))
    add_common(exporting)
    exporting.set_defaults(run=export)


# --- encode ----------------------------------------------------------------------------------------------------------


def encode(arguments: argparse.Namespace) -> int:
    from scenelang.backends.neural.clip import TEXT_SPACE, ClipName, TextEncoder, load_clip
    from scenelang.backends.neural.sentences import encoded
    from scenelang.zfile import beside, write_encodings

    result = evaluated(arguments)
    if result.scene is None:
        return 1
    if arguments.file == "-" and arguments.z is None:
        raise SceneError("file", "say where Z is: --z FILE")
    path = z_path(arguments) or beside(arguments.file)
    name = ClipName.parse(arguments.model) if arguments.model else TEXT_SPACE
    conditions, vectors = _said(arguments, result.scene)
    model = load_clip(name, shelf_of(arguments), device_of(arguments))
    found = encoded(conditions, TextEncoder(model), tensors_of(vectors, device_of(arguments)), str(model.name))
    write_encodings(path, found)
    if not arguments.quiet:
        count = sum(len(row.handles) for row in found.rows)
        say(f"wrote {path}: {len(found.rows):,} sentences of {count:,} embeddings, by {found.model}")
    return 0


def _said(arguments: argparse.Namespace, scene: Scene) -> tuple[tuple[PromptCondition, ...], Mapping[str, Any]]:
    """The sentences of a scene, each once, and the learned vectors of Z by handle; texts and vectors in Z win."""
    from scenelang.backends.neural.sentences import leaves_of, together

    sayings, vectors = sayings_of(arguments)
    frames = leaves_of(scene, granularity_of(arguments), sayings)
    return together(leaf.condition for leaves in frames for leaf in leaves), vectors


# --- set -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PictureVector:
    """A pseudo-word of a picture, and how it came to be."""

    word: PictureWord
    made: Made


def vector_of_picture(arguments: argparse.Namespace) -> PictureVector:
    """The vector of ``--image``; raises SceneError."""
    from scenelang.backends.neural.clip import TEXT_SPACE, ClipName, load_clip, open_picture
    from scenelang.backends.neural.picture_words import START, picture_word
    from scenelang.zfile import Made

    picture = open_picture(arguments.image)
    name = ClipName.parse(arguments.model) if arguments.model else TEXT_SPACE
    model = load_clip(name, shelf_of(arguments), device_of(arguments))
    word = picture_word(model, picture, arguments.start or START)
    when = datetime.now(UTC).isoformat(timespec="seconds")
    return PictureVector(word, Made("picture", Path(arguments.image).name, str(model.name), when))


# --- swap ------------------------------------------------------------------------------------------------------------


def swap(arguments: argparse.Namespace) -> int:
    from scenelang.cli.embeddings import handle_of
    from scenelang.zfile import swap_handles

    one, other = handle_of(arguments.handle), handle_of(arguments.other)
    path = z_path(arguments)
    if path is None or not path.exists():
        raise SceneError("file", "there is no file of embeddings to swap in", hint="`embeddings FILE set` makes one")
    if not swap_handles(path, one, other):
        raise SceneError("value", f"Z says nothing of <{one}> and <{other}>, so there is nothing to swap")
    if not arguments.quiet:
        say(f"wrote {path}: <{one}> and <{other}> swapped; `encode` again if their sentences are needed")
    return 0


# --- similar ---------------------------------------------------------------------------------------------------------


def similar(arguments: argparse.Namespace) -> int:
    encodings = _kept(arguments)
    wanted, own = _wanted(arguments, encodings)
    rows = [(i, cosine) for i, cosine in encodings.nearest(wanted) if i != own][: arguments.number]
    if arguments.json:
        print_json([
            {"cosine": cosine, "word": encodings.rows[i].word, "prompt": encodings.rows[i].prompt,
             "handles": [f"<{handle}>" for handle in encodings.rows[i].handles]}
            for i, cosine in rows
        ])  # fmt: skip
        return 0
    cells = [(f"{cosine:.3f}", _some(encodings.rows[i].handles), encodings.rows[i].prompt) for i, cosine in rows]
    say(table([("cosine", "handles", "sentence"), *cells], (True, False, False)))
    return 0


def _kept(arguments: argparse.Namespace) -> Encodings:
    from scenelang.zfile import read_encodings

    path = z_path(arguments)
    found = read_encodings(path) if path is not None and path.exists() else None
    if found is None:
        hint = f"scenelang embeddings {arguments.file} encode"
        raise SceneError("value", "nothing of this scene has been encoded yet", hint=hint)
    return found


def _wanted(arguments: argparse.Namespace, encodings: Encodings) -> tuple[Any, int | None]:
    """The embedding of the query, and its own row where it is a handle."""
    query = arguments.query
    if query.startswith("<") and query.endswith(">"):
        row = encodings.row_of(query[1:-1])
        if row is None:
            raise SceneError("value", f"nothing was encoded for {query}")
        return encodings.matrix[row], row
    from scenelang.backends.neural.clip import ClipName, TextEncoder, encode_images, load_clip, open_picture

    model = load_clip(ClipName.parse(encodings.model), shelf_of(arguments), device_of(arguments))
    if Path(query).suffix.lower() in _PICTURES:
        return encode_images(model, [open_picture(query)])[0].float().cpu().numpy(), None
    return TextEncoder(model).encode([(query,)]).pooled[0].float().cpu().numpy(), None


def _some(handles: tuple[str, ...]) -> str:
    shown = " ".join(f"<{handle}>" for handle in handles[:3])
    return shown if len(handles) <= 3 else f"{shown} ... ({len(handles):,})"


# --- export ----------------------------------------------------------------------------------------------------------


def export(arguments: argparse.Namespace) -> int:
    from scenelang.backends.files import written_whole
    from scenelang.zfile import read_encodings, read_z

    output = Path(arguments.output)
    if output.suffix.lower() not in _EXPORTS:
        raise UsageError("backend", f"vectors cannot be written as `{output.name}`", f"use {' '.join(_EXPORTS)}")
    check_folder(output)
    path = z_path(arguments)
    if path is None or not path.exists():
        raise SceneError("file", "there is no file of embeddings to export")
    arrays = dict(read_z(path)[1])
    encodings = read_encodings(path)
    names: dict[str, Any] = {}
    if encodings is not None:
        arrays["encodings"] = encodings.matrix
        names = {handle: i for i, row in enumerate(encodings.rows) for handle in row.handles}
    if not arrays:
        raise SceneError("value", "Z holds no vectors", hint=f"scenelang embeddings {arguments.file} encode")
    with written_whole(output) as temporary:
        _write(temporary, output.suffix.lower(), arrays, names)
    done(arguments, output)
    return 0


def _write(path: Path, ending: str, arrays: dict[str, Any], rows: dict[str, int]) -> None:
    """The arrays by handle, and the row of ``encodings`` that belongs to each handle."""
    if ending == ".npz":
        import numpy as np

        with path.open("wb") as file:
            np.savez(file, **arrays, rows=np.array(json.dumps(rows)))
    elif ending == ".safetensors":
        from safetensors.numpy import save

        path.write_bytes(save(arrays, metadata={"rows": json.dumps(rows)}))
    else:
        listed = {name: array.tolist() for name, array in arrays.items()}
        path.write_text(json.dumps({"vectors": listed, "rows": rows}), "utf-8")
