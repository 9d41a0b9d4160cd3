"""The language on a few pages, for a model that is to write it: made of the records that the reference is made of."""

from __future__ import annotations

from collections.abc import Iterator

from scenelang.attributes import attribute_doc, attributes_of
from scenelang.interpreter.shapes import PRIMITIVES
from scenelang.stdlib.reference import TOPICS, records

_TOPICS = ("paper", "forms", "poses", "combinators", "entities", "colors", "random")
_START = """# The Scene Language

A scene is a program of words and functions. `bind` binds a function to a word, `call` makes an entity of a word,
`transform` puts it under a pose (a 4x4 matrix), `union` brings several together. A word that nothing binds is a
primitive: one of those below, or a box with its word on it. The scene is the word that no other function calls.

y is up, lengths are the scene's units, angles radians. Colours are linear, `[red green blue]` from 0 to 1, or
`(color "ivory")`. `[1 2 3]` is an array, `:name` a keyword argument, `;` begins a comment.

```scene
(bind "step"
  (lambda (:width)
    (call "cube" :scale [width .2 .6] :color [.6 .4 .3])))

(bind "stairs"
  (lambda ()
    (union-loop 8
      (lambda (i)
        (transform (call "step" :width 2) (translate [0 (* i .2) (* i -.6)]))))))
```

A 4D scene is a root whose value is `(frames list)`, one entity for every moment.
"""
_SURFACE = ("color", "emission", "opacity", "metallic", "roughness", "ior")


def primer() -> str:
    """The primer as Markdown."""
    return "\n".join([_START, *_primitives(), *_names(), _rest()])


def _primitives() -> Iterator[str]:
    yield "## Primitives\n"
    for word, doc in PRIMITIVES.items():
        yield f"- `{word}`: {doc}"
        own = (name for name in attributes_of(word) if name not in _SURFACE)
        yield from (f"  - `:{name}` {attribute_doc(word, name)}" for name in own)
    yield "\nAll that can be seen has the attributes of surfaces:\n"
    yield from (f"- `:{name}` {attribute_doc(None, name)}" for name in _SURFACE)


def _names() -> Iterator[str]:
    for topic in _TOPICS:
        title, intro = TOPICS[topic]
        yield f"\n## {title}\n\n{intro}\n" if intro else f"\n## {title}\n"
        for record in records():
            if record.topic == topic and record.module is None:
                yield f"- `{record.signature}`: {record.doc}"


def _rest() -> str:
    """The other names, to be looked up with `help`."""
    lines = ["\n## Other names\n\nThe tool `help` tells what each of them does.\n"]
    for topic, (title, _) in TOPICS.items():
        names = [record.name for record in records() if record.topic == topic and record.module is None]
        if topic not in _TOPICS and names:
            lines.append(f"- {title}: {', '.join(f'`{name}`' for name in names)}")
    return "\n".join(lines)
