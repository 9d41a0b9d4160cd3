"""The command that shows and changes Z, the embeddings of a scene."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from scenelang.cli.embedding_vectors import add_actions, vector_of_picture
from scenelang.cli.neural_options import add_models
from scenelang.cli.options import UsageError, add_common, add_file, z_path
from scenelang.cli.output import print_json, say, table
from scenelang.cli.programs import evaluated
from scenelang.grammar.datum import Handle, Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.macros import quoted_value
from scenelang.interpreter.runtime.show import plain_attributes, show
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.numbering import frame_numbers, instances, number_scene
from scenelang.session import Session, is_scene_file

MAX_ROWS = 500


def add_embeddings(subparsers: Any) -> None:
    parser = subparsers.add_parser("embeddings", help="the embeddings of a scene: list, change, encode, compare")
    add_file(parser)
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    listing = actions.add_parser("list", help="every entity's handle, word, text and attributes")
    add_common(listing)
    listing.set_defaults(run=list_embeddings)
    setting = actions.add_parser("set", help="give a handle a text, attributes or the vector of a picture")
    setting.add_argument("handle", metavar="'<z5>'", help="a handle as `tree` shows it")
    setting.add_argument("--text", help="the text of the embedding")
    setting.add_argument(
        "--attribute", action="append", default=[], metavar="NAME=VALUE", help="an attribute, such as color=[1,0,0]"
    )
    setting.add_argument("--image", metavar="FILE", help="a picture, which gives the handle a vector (a pseudo-word)")
    setting.add_argument("--start", metavar="TEXT", help="the word that the picture's vector starts from (object)")
    setting.add_argument("--model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder, for --image")
    setting.add_argument("--clear", action="store_true", help="forget what Z says of the handle first")
    add_models(setting)
    add_common(setting)
    setting.set_defaults(run=set_embedding)
    add_actions(actions)


def list_embeddings(arguments: argparse.Namespace) -> int:
    result = evaluated(arguments)
    if result.scene is None:
        return 1
    rows, learned = _rows(result.scene), _learned(z_path(arguments))
    if arguments.json:
        print_json(
            [
                {"handle": f"<{name}>", "word": e.word, "text": e.embedding.text, "attributes": plain_attributes(e)}
                | ({"vectors": learned[name]} if name in learned else {})
                for name, e in rows.items()
            ]
        )
        return 0
    cells = [
        (f"<{name}>", e.word, e.embedding.text or "", _attributes(e), learned.get(name, "")) for name, e in rows.items()
    ]
    shown = 5 if learned else 4
    titles = ("handle", "word", "text", "attributes", "learned vectors")
    say(table([row[:shown] for row in (titles, *cells)], (False,) * shown))
    if len(rows) == MAX_ROWS:
        say(f"... only the first {MAX_ROWS} are shown")
    return 0


def _learned(path: Path | None) -> dict[str, str]:
    """How the vectors came to be that Z has of handles, in words: how many, how wide, by what, of what."""
    if path is None or not path.exists():
        return {}
    from scenelang.zfile import read_made, read_z

    vectors, made = read_z(path)[1], read_made(path)
    found = {}
    for name, vector in vectors.items():
        shape = " x ".join(map(str, vector.shape))
        told = made.get(name)
        found[name] = f"{shape}, {told.how} of {told.source}" if told is not None else shape
    return found


def _attributes(entity: Entity) -> str:
    return " ".join(f":{key} {show(value, 40)}" for key, value in entity.embedding.attributes.items())


def _rows(scene: Scene) -> dict[str, Entity]:
    """The first entities by handle, each handle once."""
    numbers = frame_numbers(scene) if scene.animated else {}
    numbering = number_scene(scene)
    rows: dict[str, Entity] = {}
    rank = 0
    for root in scene.frames:
        for path, entity in instances(root):
            name = entity.embedding.handle
            if name is None:
                rank += 1
                name = f"z{numbers[path] if scene.animated else numbering.number(rank)}"
            rows.setdefault(name, entity)
            if len(rows) >= MAX_ROWS:
                return rows
    return rows


def set_embedding(arguments: argparse.Namespace) -> int:
    from scenelang.zfile import beside, set_entry, write_vectors

    name = handle_of(arguments.handle)
    if arguments.file != "-":
        source = Session().source(arguments.file)  # a program that cannot be read has no embeddings
        if is_scene_file(source):
            hint = "set them for the program that made it"
            raise SceneError("unsupported", f"{arguments.file} is a finished scene, which takes no embeddings", hint)
    path = z_path(arguments) or beside(arguments.file)
    if arguments.file == "-" and arguments.z is None:
        raise SceneError("file", "say where Z is: --z FILE")
    if arguments.text is None and not arguments.attribute and not arguments.clear and arguments.image is None:
        raise UsageError("value", "nothing to set", "give --text, --attribute or --image")
    if arguments.start is not None and arguments.image is None:
        raise UsageError("value", "`--start` is the word that a picture's vector starts from: give one with --image")
    attributes = dict(map(_attribute, arguments.attribute))
    learned = None if arguments.image is None else vector_of_picture(arguments)
    set_entry(path, name, arguments.text, attributes, arguments.clear)
    if learned is not None:
        write_vectors(path, {name: learned.word.vectors}, {name: learned.made})
    if not arguments.quiet:
        told = f"; cosine {learned.word.before:.3f} -> {learned.word.cosine:.3f}" if learned is not None else ""
        say(f"wrote {path}: <{name}>{told}")
    return 0


def _attribute(item: str) -> tuple[str, Any]:
    """The name and value of `NAME=VALUE`; raises UsageError."""
    key, sign, text = item.partition("=")
    if not sign or not key or not text.strip():
        raise UsageError("value", f"--attribute wants NAME=VALUE, got `{item}`")
    return key.lstrip(":").strip(), _value(text)


def handle_of(text: str) -> str:
    """The name of a handle as a user writes it; raises UsageError."""
    inner = text if text.startswith("<") else f"<{text}>"
    forms = read(Source("<handle>", inner)).forms
    if len(forms) == 1 and type(getattr(forms[0], "value", None)) is Handle:
        return str(forms[0].value)  # type: ignore[union-attr]
    raise UsageError("value", f"`{text}` is no handle", "a handle is `<z5>`; quote it for the shell: '<z5>'")


def _value(text: str) -> Any:
    """The value of an attribute: a literal of the language, `[1,0,0]` with commas too; a bare word is a string."""
    written = text.replace(",", " ") if text.strip().startswith("[") else text
    result = read(Source("<attribute>", written))
    if len(result.forms) != 1 or result.diagnostics:
        return text
    value = quoted_value(result.forms[0])
    return text if type(value).__name__ == "Symbol" else value


COMMANDS = (add_embeddings,)
