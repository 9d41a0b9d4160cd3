"""The cheat sheet: the names that most programs use, on one page that can be printed."""

from __future__ import annotations

import re
from collections.abc import Iterator

from generator.library_page import place_of
from generator.markdown import NOTICE, block, formatted, table
from scenelang.cli.main import build_parser
from scenelang.console.shell_completion import subcommands
from scenelang.interpreter.scene.declarations import RELATIONS
from scenelang.interpreter.scene.primitives import all_primitives
from scenelang.interpreter.scene.primitives.base import Primitive
from scenelang.reference.primer import TAUGHT, attribute_doc, attributes_of
from scenelang.stdlib.reference import lookup

_PROGRAM = """; a comment
(param legs 3 "number of legs")            ; a slider: --define legs=4
(bind "stool"                              ; what the word "stool" means
  (lambda (:height (:color [.6 .3 .1]))    ; keyword parameters, the second with a default
    (define seat (call "cylinder" :radius .2 :p1 [0 .04 0] :color color))
    (define leg (call "cylinder" :radius .02 :p1 [0 height 0] :color color))
    (union (ring legs leg :radius .15) (transform seat (translate [0 height 0])))))
(bind "bar"
  (lambda ()
    (for/union ((x '(-1 0 1)))
      (transform (call "stool" "a bar stool" :height .7) (translate (vector x 0 0))))))
(scene "bar")                              ; the root
(assert-that (count "stool" 3))            ; tested by run
"""
_SENTENCE = re.compile(r"^.*?\.(?= [A-Z(]|$)")
_COMMANDS = (
    "check", "run", "render", "view", "export", "fmt", "repl", "labels", "maps", "dataset", "repair", "generate",
    "build", "edit", "doctor",
)  # fmt: skip
_NUMBERS = ("Numbers", "Lists", "Vectors", "Others")  # groups whose names say what they are


def cheat_sheet_page() -> str:
    """Return the cheat sheet, Markdown."""
    lines = ["# Cheat sheet", "", NOTICE, ""]
    lines += [
        "Right-handed, +x right, +y up, +z towards the viewer. Angles are radians in programs, degrees in options.",
        "Scenes stand on y = 0. The [reference](reference/index.md) has everything.", "",
    ]  # fmt: skip
    lines += block("scene", formatted(_PROGRAM))
    lines += ["## Primitives", "", *table(("call", "meaning"), list(map(_primitive, all_primitives())))]
    material = [name for name in attributes_of("cube") if name not in ("scale",)]
    rows = [(_linked(f":{name}"), _first(attribute_doc(None, name) or "")) for name in material]
    lines += ["## Materials and bodies", "", *table(("attribute", "meaning"), rows)]
    for title, names in TAUGHT.items():
        lines += [f"## {title}", "", *_group(title, names.replace("~", "").split())]
    usages = [(_linked(name), f"`{relation.usage}`") for name, relation in RELATIONS.items()]
    lines += ["## Relations", "", "In `(assert-that ...)` and after `check --that`.", ""]
    lines += table(("relation", "usage"), usages)
    lines += ["## Commands", "", *table(("command", ""), list(_commands()))]
    return "\n".join(lines).rstrip("\n") + "\n"


def _group(title: str, names: list[str]) -> Iterator[str]:
    """Yield a table of names with their usage and meaning, or one line of names that are known from elsewhere."""
    if title in _NUMBERS:
        yield from (", ".join(_linked(name) for name in names), "")
        return
    rows = []
    for name in names:
        record = lookup(name)
        assert record is not None, name
        usage = record.signature.partition(" -> ")[0]
        rows.append((f"[`{usage}`](reference/{place_of(name)})", _first(record.doc)))
    yield from table(("usage", "meaning"), rows)


def _primitive(cls: type[Primitive]) -> tuple[str, str]:
    """Return the row of a primitive: the call with the attributes of its geometry, and its meaning."""
    names = " ".join(f":{name}" for name in cls.attribute_names() if name != "color")
    return f'[`(call "{cls.word}" {names})`](reference/{place_of(cls.word)})', _first(cls.doc)


def _linked(name: str) -> str:
    return f"[`{name}`](reference/{place_of(name)})"


def _first(text: str) -> str:
    """Return the first sentence of a documentation, without its period."""
    match = _SENTENCE.match(text)
    return (match[0] if match else text).rstrip(".").removeprefix("Return ")


def _commands() -> Iterator[tuple[str, str]]:
    known = {name: brief for name, (_, brief) in subcommands(build_parser()).items()}
    for name in _COMMANDS:
        if name in known:
            yield f"[`scenelang {name}`](reference/cli.md#{name})", known[name]
