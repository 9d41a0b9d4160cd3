"""Attributes that a primitive does not use, and the attribute or form that was meant."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix, SceneError
from scenelang.interpreter.runtime.values import Keyword
from scenelang.interpreter.scene.primitives import (
    COLOR,
    MATERIALS,
    SCALE,
    find,
    geometry_attributes,
    is_word,
    solid_words,
)

_NEAR = 0.75
_TYPO = 0.8

# What people write for what is no attribute of a primitive, and what to write instead. Rows of a word come before "*".
_PLACED = 'a part is placed by `transform`: `(transform (call "{word}") (translate [x y z]))`'
_TURNED = 'a part is turned by `transform`: `(transform (call "{word}") (rotate angle [0 1 0]))`'
_ENDS = "the axis goes from `:p0` to `:p1`: `:p1 [0 {name} 0]`"
_SIDES = "the sizes along x, y and z are one attribute: `:scale [x y z]`"
_DIAMETER = "half the diameter is the `:radius`"
_MATERIAL = "a material is made of `:color`, `:roughness`, `:metallic`, `:opacity`, `:emission` and `:ior`"
_SMOOTH = "surfaces are exact; `export --tolerance` says how finely they are divided"
_AXIS = {
    "height h length depth": _ENDS,
    "diameter d": _DIAMETER,
    "r2 top-radius radius-top": 'the radius is constant; that of a "cone" decreases to 0',
}
_BOX = {
    "width height depth length w h x-size y-size z-size": _SIDES,
    "bevel fillet corner-radius": '"rounded-cube" has rounded edges: `:rounding`',
}
_ROUND = {"diameter d": _DIAMETER, "minor-radius tube-radius thickness r2": "the radius of the tube is `:tube`"}
_ANY = {
    "position pos location center centre at origin offset translate translation place": _PLACED,
    "rotation rotate angle orientation axis euler yaw pitch": _TURNED,
    "texture material shader image uv texture-map bump": _MATERIAL,
    "segments sides resolution subdivisions facets fn slices stacks": _SMOOTH,
    "transparency": "`:opacity` is 1 for an opaque surface and 0 for an invisible one",
}


def _by_name(rows: Mapping[str, str]) -> dict[str, str]:
    return {name: meant for names, meant in rows.items() for name in names.split()}


MEANT: Mapping[str, Mapping[str, str]] = {
    **{word: _by_name(_AXIS) for word in ("cylinder", "cone", "capsule")},
    **{word: _by_name(_BOX) for word in ("cube", "rounded-cube")},
    **{word: _by_name(_ROUND) for word in ("sphere", "torus")},
    "*": _by_name(_ANY),
}


def unread_attributes(nodes: Iterable[Any]) -> Iterator[tuple[str, Diagnostic]]:
    """Yield attributes of calls of geometric primitives that are probably meant to be another, by the word."""
    for node in nodes:
        word = node.word.value if type(node) is ast.Call and type(node.word) is ast.Constant else None
        if word is None or type(word) is not str:
            continue
        for argument in node.arguments:
            if type(argument) is ast.Constant and type(argument.value) is Keyword:
                name, span = str(argument.value), argument.span
                is_geometric = geometry_attributes(word) is not None
                hint = unread_hint(word, name) if is_geometric else _semantic_hint(word, name)
                if hint is not None:
                    near = near_attribute(word, name)
                    fixes = (Fix(f"Change to `:{near}`", (Edit(span, f":{near}"),)),) if near else ()
                    message = f'the primitive "{word}" does not use the attribute `:{name}`'
                    yield (
                        word,
                        Diagnostic(
                            "idle-attribute", message, span, hint, fixes=fixes, found=f":{name}",
                            expected=" ".join(f":{n}" for n in geometry_attributes(word) or ()),
                            near=(f":{near}",) if near else (),
                        ),
                    )  # fmt: skip


def near_attribute(word: str, name: str) -> str | None:
    """Return the attribute of a primitive that ``name`` is a synonym or a misspelling of."""
    try:
        cls = find(word)
    except SceneError:
        cls = None
    known = [*(cls.attributes if cls is not None else (SCALE,)), COLOR, *MATERIALS]
    for attribute in known:
        if name.lower() in attribute.aliases and name != "transparency":
            return attribute.name
    from difflib import get_close_matches

    near = get_close_matches(name.lower(), [attribute.name for attribute in known], n=1, cutoff=_NEAR)
    return near[0] if near else None


def unread_hint(word: str, name: str) -> str | None:
    """Return a hint for an attribute that a geometric primitive does not use, but that was meant to change it.

    None for an attribute that is read, and for one that may be the program's own.
    """
    read = geometry_attributes(word) or ()
    if name in read or any(name == attribute.name for attribute in MATERIALS):
        return None
    for table in (MEANT.get(word, {}), MEANT["*"]):
        if name in table:
            return table[name].format(word=word, name=name)
    near = near_attribute(word, name)
    if near:
        return f"did you mean `:{near}`?"
    return "it uses " + ", ".join(f"`:{n}`" for n in read) if name in _all_geometry() else None


def _semantic_hint(word: str, name: str) -> str | None:
    """Return a hint for an attribute of a word without geometry that is one letter away from one that is read."""
    if is_word(word):
        return None  # blocks and mesh files check their own
    near = near_attribute(word, name)
    from difflib import SequenceMatcher

    is_typo = near is not None and near != name and SequenceMatcher(None, near, name).ratio() >= _TYPO
    return f"did you mean `:{near}`?" if is_typo else None


def _all_geometry() -> frozenset[str]:
    """Return the attributes that the geometry of some primitive reads."""
    return frozenset(name for word in solid_words() for name in geometry_attributes(word) or ())
