"""The entity DAG as tables and columns: words, embeddings, places, edges. Its size follows distinct entities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Entity, Scene, descendants
from scenelang.interpreter.library import STD
from scenelang.interpreter.numbering import number_scene
from scenelang.interpreter.show import show
from scenelang.interpreter.values import Embedding

_LONGEST_VALUE = 200
_LONGEST_LINE = 200


@dataclass(slots=True)
class _Table:
    """Rows of plain data, each kept once and known by its number."""

    rows: list[Any] = field(default_factory=list)
    numbers: dict[Any, int] = field(default_factory=dict)

    def number(self, key: Any, row: Any) -> int:
        found = self.numbers.get(key)
        if found is None:
            found = self.numbers[key] = len(self.rows)
            self.rows.append(row() if callable(row) else row)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """``tables`` are JSON data; ``number`` maps ``id(entity)`` to its node, children before parents.

    ``columns``, per node: ``nodeWord``; ``nodeEmbedding``, ``nodePlace`` and ``nodeDefinition`` (-1: none);
    ``nodePrimitive``; ``nodeStart`` (V + 1), so that the children of node n are
    ``nodeChild[nodeStart[n]:nodeStart[n + 1]]``.
    """

    tables: dict[str, Any]
    columns: dict[str, npt.NDArray[Any]]
    number: dict[int, int]


def graph_of(scene: Scene, definitions: Mapping[str, Span]) -> Graph:
    """The distinct entities of all frames of ``scene``; ``definitions`` says where words are bound."""
    nodes = list(descendants(*scene.frames))
    words, embeddings, places = _Table(), _Table(), _Table()
    number = {id(entity): i for i, entity in enumerate(nodes)}
    start = np.zeros(len(nodes) + 1, np.int32)
    np.cumsum([len(entity.children) for entity in nodes], out=start[1:])
    columns: dict[str, npt.NDArray[Any]] = {
        "nodeWord": _column(words.number(entity.word, entity.word) for entity in nodes),
        "nodeEmbedding": _column(_embedding(embeddings, entity.embedding) for entity in nodes),
        "nodePlace": _column(_places(places, entity.places) for entity in nodes),
        "nodeDefinition": _column(_places(places, _definition(entity, definitions)) for entity in nodes),
        "nodeStart": start,
        "nodeChild": _column(number[id(part.car)] for entity in nodes for part in entity.children),
        "nodePrimitive": np.array([entity.is_primitive for entity in nodes], np.uint8),
    }
    tables = {
        "words": words.rows,
        "embeddings": embeddings.rows,
        "places": places.rows,
        "roots": [number[id(root)] for root in scene.frames],
        "taken": list(number_scene(scene).taken),
    }
    return Graph(tables, columns, number)


def _column(numbers: Any) -> npt.NDArray[np.int32]:
    return np.fromiter(numbers, np.int32)


def _embedding(table: _Table, embedding: Embedding) -> int:
    if embedding.handle is None and not embedding.text and not embedding.attributes:
        return -1
    return table.number(id(embedding), lambda: _embedding_row(embedding))


def _embedding_row(embedding: Embedding) -> dict[str, Any]:
    attributes = [[name, show(value, _LONGEST_VALUE)] for name, value in embedding.attributes.items()]
    return {"handle": embedding.handle, "text": embedding.text, "attributes": attributes}


def _definition(entity: Entity, definitions: Mapping[str, Span]) -> tuple[Span, ...]:
    """Where the word of an entity that is no primitive is bound, as far as that is known."""
    span = None if entity.is_primitive else definitions.get(entity.word)
    return () if span is None else (span,)


def _places(table: _Table, spans: Sequence[Span]) -> int:
    """The number of a list of places, -1 where there is none outside the standard library."""
    own = [span for span in spans if not span.source.name.startswith(STD)]
    if not own:
        return -1
    key = tuple((id(span.source), span.start) for span in own)
    return table.number(key, lambda: [_place_row(span) for span in own])


def _place_row(span: Span) -> dict[str, Any]:
    line, column = span.source.position(span.start)
    text = span.source.line(line).strip()
    shown = text if len(text) <= _LONGEST_LINE else text[: _LONGEST_LINE - 3] + "..."
    return {"file": span.source.name, "line": line, "column": column, "text": shown}
