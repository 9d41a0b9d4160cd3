"""The page of parts: everyday objects of the library, with their pictures and sockets."""

from __future__ import annotations

from collections.abc import Iterator

from generator.library_page import PICTURES, picture_program
from generator.markdown import NOTICE, anchor, block
from scenelang.stdlib.reference import LibraryPart, ReferenceRecord, parts

_START = """
Everyday objects in metres, as words that a program calls. Each stands on y = 0 with the middle of its foot at the
origin, and its front is +z. `scenelang search "couch"` finds them by other names and by their places, too.

```scene
(import "std/furniture.scene")
(import "std/kitchen.scene")

(bind "dining room"
  (lambda ()
    (union
      (call "table" :width 1.6)
      (transform (call "vase") (table-top))
      (for/union ((place (table-seats :width 1.6 :count 6)))
        (transform (call "chair" :height .95) place)))))
```

**Sockets** are poses in the frame of a part, for the same parameters. `(transform object (table-top :height .6))` puts
the foot of an object there, with its front to the socket's +z; `(@ pose (table-top))` is that place on a table that is
moved by `pose`. A socket in the plural returns a list of poses. Some place the part itself: `(book-upright)` stands a
book on its edge, so `(@ board (book-upright))` stands it on a board.

A word that a program binds itself belongs to the program, so one part can be replaced and the others kept.

In Python mode, parts and sockets are functions beside the helpers, with keyword arguments: `chair(height=.95)`,
`transform_shape(vase(), table_top())`. The translation imports their modules.
""".strip()


def parts_page() -> str:
    """Every part by module, Markdown."""
    modules = dict.fromkeys(part.record.module for part in parts())
    links = " · ".join(f"[{_title(module)}](#{anchor(_title(module))})" for module in modules)
    lines = ["# Parts", "", NOTICE, "", *_START.splitlines(), "", links, ""]
    for module in modules:
        lines += [f"## {_title(module)}", "", f'`(import "{module}")`', ""]
        for part in parts():
            lines += _part(part) if part.record.module == module else ()
    return "\n".join(lines).rstrip("\n") + "\n"


def _title(module: str | None) -> str:
    """The title of a module: its name."""
    return (module or "").removeprefix("std/").removesuffix(".scene").capitalize()


def _part(part: LibraryPart) -> Iterator[str]:
    """The section of a part."""
    width, height, depth = part.size
    yield from (f"### {part.word}", "", f"`{part.record.signature}`", "")
    yield from (f"{part.summary} {part.parameters}", "", f"![{part.word}]({picture_path(part)})", "")
    yield from (f"{width:g} wide, {height:g} high, {depth:g} deep. Front: {part.front}", "")
    yield from map(_socket, part.sockets)
    yield from ("",) if part.sockets else ()
    yield from block("scene", picture_program(part.record))


def _socket(socket: ReferenceRecord) -> str:
    """The line of a socket."""
    examples = "".join(f" `{each.expression}` gives `{each.value}`." for each in socket.examples)
    return f"- `{socket.signature}`: {socket.doc}{examples}"


def picture_path(part: LibraryPart) -> str:
    """Where the picture of a part is, from the page."""
    return f"reference/{PICTURES}/part-{part.word.replace(' ', '-')}.png"
