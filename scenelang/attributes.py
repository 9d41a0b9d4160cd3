"""What primitives and their attributes mean: one line on each, for help and completion."""

from __future__ import annotations

from scenelang.backends.appearance import MATERIALS
from scenelang.interpreter.shapes import ATTRIBUTES, READ


def attributes_of(word: str) -> tuple[str, ...]:
    """The attributes that the primitive ``word`` reads, those of its geometry first. A word that names no primitive
    of its own is a semantic one: a box."""
    own = READ.get(word, ("scale", "color"))
    return (*own, *MATERIALS) if "color" in own else own  # without a colour there is nothing to see


def attribute_doc(word: str | None, name: str) -> str | None:
    """What the attribute ``name`` means to the primitive ``word``, or to any primitive: meaning, range, default in one
    line. None for an attribute that is not read."""
    if word is not None and name not in attributes_of(word):
        return None
    return ATTRIBUTES.get(name) or MATERIALS.get(name)


def attribute_names() -> tuple[str, ...]:
    """Every attribute that some primitive reads."""
    return (*ATTRIBUTES, *MATERIALS)
