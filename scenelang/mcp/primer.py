"""The language on a few pages, for an agent that is to write it."""

from __future__ import annotations

from scenelang.primer import primer

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
_END = "\nThe tool `help` tells what each name does."


def primer_text() -> str:
    """The primer as Markdown, with an example."""
    return "\n".join([_START, primer(), _END])
