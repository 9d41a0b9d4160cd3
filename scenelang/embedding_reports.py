"""Embeddings of a scene as people read them: tables."""

from __future__ import annotations

from collections.abc import Sequence

from scenelang.backends.neural.wording import Wording, filled
from scenelang.embeddings import MOST_ROWS, EmbeddingRow, SimilarEmbedding
from scenelang.interpreter.runtime.show import show
from scenelang.reports import table

_SHOWN = 3  # handles of a row that are spelled out


def rows_table(rows: Sequence[EmbeddingRow]) -> str:
    """What ``Embeddings.table`` finds, without the column of learned vectors where there are none."""
    shown = 5 if any(row.learned for row in rows) else 4
    cells = [("handle", "word", "text", "attributes", "learned vectors"), *map(_row_cells, rows)]
    text = table([row[:shown] for row in cells], (False,) * shown)
    return f"{text}\n... only the first {MOST_ROWS} are shown" if len(rows) == MOST_ROWS else text


def _row_cells(row: EmbeddingRow) -> tuple[str, ...]:
    attributes = " ".join(f":{key} {show(value, 40)}" for key, value in row.attributes.items())
    return f"<{row.handle}>", row.word, row.text or "", attributes, row.learned


def similar_table(found: Sequence[SimilarEmbedding]) -> str:
    """What ``Embeddings.similar`` finds."""
    cells = [(f"{row.cosine:.3f}", _some(row.handles, "({:,})"), row.prompt) for row in found]
    return table([("cosine", "handles", "sentence"), *cells], (True, False, False))


def wording_table(wording: Wording) -> str:
    """The words for what a scene is made of."""
    titles = ("handle", "word", "text", "template")
    rows = [
        (_some(row.handles, "{:,} in all"), row.word, row.text, filled(row.template, row.handles[0]))
        for row in wording.rows[:MOST_ROWS]
    ]
    rest = [f"... only the first {MOST_ROWS} rows are shown"] if len(wording.rows) > MOST_ROWS else []
    head = f"the style is <{wording.style}>, {wording.style_text}"
    return "\n".join([head, "", table([titles, *rows], (False,) * 4), *rest])


def _some(handles: tuple[str, ...], rest: str) -> str:
    """The first handles; ``rest`` tells of how many there are."""
    shown = " ".join(f"<{handle}>" for handle in handles[:_SHOWN])
    return shown if len(handles) <= _SHOWN else f"{shown} ... {rest.format(len(handles))}"
