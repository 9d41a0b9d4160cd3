"""Mitsuba's scene dictionaries as the elements of its XML format."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from xml.sax.saxutils import quoteattr  # writes only  # nosec B406

import numpy as np

from scenelang.grammar.diagnostics import printable

_TAGS = {
    "path": "integrator",
    "perspective": "sensor",
    "thinlens": "sensor",
    "orthographic": "sensor",
    "hdrfilm": "film",
    "multijitter": "sampler",
    "box": "rfilter",
    "constant": "emitter",
    "area": "emitter",
    "diffuse": "bsdf",
    "twosided": "bsdf",
    "principled": "bsdf",
    "mask": "bsdf",
    "mesh_attribute": "texture",
    "checkerboard": "texture",
    "ply": "shape",
    "sphere": "shape",
    "cube": "shape",
    "cylinder": "shape",
    "disk": "shape",
    "rectangle": "shape",
    "shapegroup": "shape",
    "instance": "shape",
}


def _quoted(text: str) -> str:
    """An attribute's value; XML has no control characters, not even escaped ones."""
    return quoteattr(printable(text))


def elements(name: str | None, value: Any, indent: str = "  ") -> list[str]:
    """The lines of the property ``name``: a plugin (a mapping with a "type"), a transform (a matrix) or a plain value.

    The key "id" of a plugin names it, and a value ``{"ref": id}`` refers to it.
    """
    named = "" if name is None else f" name={_quoted(name)}"
    if isinstance(value, Mapping):
        return _plugin(named, value, indent)
    if isinstance(value, np.ndarray):
        matrix = " ".join(f"{number:.17g}" for number in value.ravel().tolist())
        return [f'{indent}<transform{named}><matrix value="{matrix}"/></transform>']
    if isinstance(value, bool):
        return [f'{indent}<boolean{named} value="{str(value).lower()}"/>']
    if isinstance(value, int):
        return [f'{indent}<integer{named} value="{value}"/>']
    if isinstance(value, float):
        return [f'{indent}<float{named} value="{value:.9g}"/>']
    if isinstance(value, str):
        return [f"{indent}<string{named} value={_quoted(value)}/>"]
    return [f'{indent}<point{named} value="{_numbers(value)}"/>']


def _plugin(named: str, value: Mapping[str, Any], indent: str) -> list[str]:
    if "ref" in value:
        return [f"{indent}<ref id={_quoted(value['ref'])}/>"]
    if value["type"] == "rgb":
        return [f'{indent}<rgb{named} value="{_numbers(value["value"])}"/>']
    tag = _TAGS[value["type"]]
    label = f" id={_quoted(value['id'])}" if "id" in value else named if tag == "texture" else ""
    lines = [f'{indent}<{tag} type="{value["type"]}"{label}>']
    for key, item in value.items():
        if key not in ("type", "id"):
            lines += elements(key, item, indent + "  ")
    return [*lines, f"{indent}</{tag}>"]


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{float(number):.9g}" for number in values)
