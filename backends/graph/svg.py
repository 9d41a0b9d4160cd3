"""Computation graphs as SVG: words in boxes, handles below them, arrows with counts."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from itertools import pairwise
from pathlib import Path

from scenelang.backends.base import frame_of, need
from scenelang.backends.files import written_whole
from scenelang.backends.graph.layout import Place, laid_out
from scenelang.backends.graph.model import CallGraph, Node, call_graph
from scenelang.backends.maps.pictures import word_color
from scenelang.backends.picture import PictureOptions, render
from scenelang.grammar.diagnostics import printable
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Scene

_FONT = 14.0
_SMALL = 11.0
_THUMBNAIL = 72
_MARGIN = 18.0
_LONGEST = 36
_HEIGHTS = (0.42, 0.58, 0.74)  # of labels along their arrows
_FAMILY = "ui-sans-serif, system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif"
_WIDE = 0.6  # the width of a letter over its height


def write_graph(
    scene: Scene, path: Path | str, frame: int | None = None, depth: int | None = None, thumbnails: bool = False
) -> None:
    """Draw the computation graph of one frame as SVG, whole or not at all; with ``thumbnails``, of every node a draft
    picture. Raises SceneError."""
    graph = call_graph(scene, frame_of(scene, frame), depth)
    pictures = [_thumbnail(node) if thumbnails else None for node in graph.nodes]
    text = drawing(graph, pictures)
    with written_whole(path) as temporary:
        temporary.write_text(text, "utf-8")


def drawing(graph: CallGraph, pictures: Sequence[str | None]) -> str:
    """The SVG text; ``pictures`` are the nodes' PNG files in base64, or None."""
    sizes = [_size(node, picture) for node, picture in zip(graph.nodes, pictures, strict=True)]
    layout = laid_out(sizes, [(edge.start, edge.end) for edge in graph.edges])
    places = layout.places
    left = min(place.x - place.width / 2.0 for place in places) - _MARGIN
    right = max(place.x + place.width / 2.0 for place in places) + _MARGIN
    bottom = max(place.y + place.height / 2.0 for place in places) + _MARGIN + (24.0 if graph.hidden else 0.0)
    box = f"{left:.1f} {-_MARGIN:.1f} {right - left:.1f} {bottom + _MARGIN:.1f}"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" width="{right - left:.0f}" '
        f'height="{bottom + _MARGIN:.0f}" font-family="{_FAMILY}">',
        f"<title>{escape(printable(graph.nodes[0].word))}</title>",
        '<defs><marker id="arrow" viewBox="0 0 8 8" refX="7.5" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto-start-reverse"><path d="M0 0.6 L8 4 L0 7.4 z" fill="#6b7280"/></marker></defs>',
        f'<rect x="{left:.1f}" y="{-_MARGIN:.1f}" width="100%" height="100%" fill="#ffffff"/>',
    ]
    lines += [
        _arrow(places[edge.start], places[edge.end], way, edge.label, number)
        for number, (edge, way) in enumerate(zip(graph.edges, layout.ways, strict=True))
    ]
    for node, place, picture in zip(graph.nodes, places, pictures, strict=True):
        lines += _box(node, place, picture)
    if graph.hidden:
        lines.append(_text(left + _MARGIN, bottom - 8.0, f"and {graph.hidden} more", _SMALL, "#6b7280", "start"))
    return "\n".join([*lines, "</svg>", ""])


def _size(node: Node, picture: str | None) -> tuple[float, float]:
    letters = max(len(_shown(node.word)) * _FONT, len(_handles(node)) * _SMALL) * _WIDE
    height = 34.0 + (15.0 if node.handles else 0.0) + (_THUMBNAIL + 4.0 if picture else 0.0)
    return max(letters + 26.0, 58.0, _THUMBNAIL + 16.0 if picture else 0.0), height


def _shown(word: str) -> str:
    plain = "".join(c if c.isprintable() else " " for c in word)
    return plain if len(plain) <= _LONGEST else plain[: _LONGEST - 1] + "…"


def _handles(node: Node) -> str:
    return " ".join(handle if handle == "…" else f"<{handle}>" for handle in node.handles)


def _box(node: Node, place: Place, picture: str | None) -> list[str]:
    x, y = place.x - place.width / 2.0, place.y - place.height / 2.0
    red, green, blue = word_color(node.word)
    fill = "#f8fafc" if node.is_primitive else f"rgba({red},{green},{blue},0.22)"
    radius = 4.0 if node.is_primitive else 10.0
    said = f"{node.word}: {node.instances:,} instances, {node.distinct:,} distinct"
    lines = [
        "<g>",
        f"<title>{escape(printable(said))}</title>",
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{place.width:.1f}" height="{place.height:.1f}" rx="{radius}" '
        f'fill="#ffffff"/>',
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{place.width:.1f}" height="{place.height:.1f}" rx="{radius}" '
        f'fill="{fill}" stroke="rgb({red},{green},{blue})" stroke-width="1.5"/>',
    ]
    at = y + 22.0
    if picture:
        lines.append(
            f'<image x="{place.x - _THUMBNAIL / 2:.1f}" y="{y + 6:.1f}" width="{_THUMBNAIL}" height="{_THUMBNAIL}" '
            f'href="data:image/png;base64,{picture}"/>'
        )
        at += _THUMBNAIL + 2.0
    lines.append(_text(place.x, at, _shown(node.word), _FONT, "#111827", "middle"))
    if node.handles:
        lines.append(_text(place.x, at + 16.0, _handles(node), _SMALL, "#6b7280", "middle"))
    return [*lines, "</g>"]


def _arrow(start: Place, end: Place, way: Sequence[Place], label: str, number: int) -> str:
    """A curve from the lower edge of one box to the upper edge of the other, upright at the places of ``way``.

    The label stands on the last stretch, at another height for every ``number``, so that neighbours do not overlap.
    """
    points = [(start.x, start.y + start.height / 2.0), *((p.x, p.y) for p in way), (end.x, end.y - end.height / 2.0)]
    path = f"M{points[0][0]:.1f} {points[0][1]:.1f}"
    for (x0, y0), (x1, y1) in pairwise(points):
        bend = (y1 - y0) / 2.0
        path += f" C{x0:.1f} {y0 + bend:.1f} {x1:.1f} {y1 - bend:.1f} {x1:.1f} {y1:.1f}"
    line = f'<path d="{path}" fill="none" stroke="#9ca3af" stroke-width="1.3" marker-end="url(#arrow)"/>'
    if not label:
        return line
    (x0, y0), (x1, y1) = points[-2:]
    t = _HEIGHTS[number % len(_HEIGHTS)]
    share = 3.0 * t * t - 2.0 * t**3
    x, y = x0 + (x1 - x0) * share, y0 + (y1 - y0) * (1.5 * t * (1.0 - t) + t**3)
    shown = _text(x, y + 4.0, label, _SMALL, "#374151", "middle")
    return line + shown.replace("<text ", '<text stroke="#fff" stroke-width="4" paint-order="stroke" ', 1)


def _text(x: float, y: float, text: str, size: float, color: str, anchor: str) -> str:
    shown = escape(printable(text))
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}" fill="{color}" text-anchor="{anchor}">{shown}</text>'


def _thumbnail(node: Node) -> str | None:
    """A small draft picture of a node's entity, in base64; None where there is nothing to draw."""
    if entity_box(node.sample) is None:
        return None
    side = 2 * _THUMBNAIL
    picture = render(Scene(node.word, [node.sample], False), PictureOptions(width=side, height=side, labels=False))
    out = io.BytesIO()
    need("PIL.Image", "pillow").fromarray(picture).quantize(128).save(out, "PNG", optimize=True)
    return base64.b64encode(out.getvalue()).decode("ascii")
