"""The encoded conditions of a scene: one embedding in Z_CLIP for each sentence, and whose it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.clip.conditions import Condition
from scenelang.backends.clip.prompts import Prompt, Slot
from scenelang.backends.clip.splicing import Vectors
from scenelang.backends.clip.text import TextEncoder
from scenelang.backends.wording.handles import packed, unpacked

FloatArray = npt.NDArray[np.float32]
VERSION = 1
_BATCH = 32


@dataclass(frozen=True, slots=True)
class Row:
    """The sentence ``prompt`` of things called ``word``, and the handles of their embeddings."""

    word: str
    prompt: str
    handles: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Encodings:
    """``matrix`` (K, D) holds the embedding of each row, of length 1; ``model`` made them."""

    model: str
    rows: tuple[Row, ...]
    matrix: FloatArray

    def row_of(self, handle: str) -> int | None:
        """The row of a handle; None where there is none."""
        return next((i for i, row in enumerate(self.rows) if handle in row.handles), None)

    def nearest(self, wanted: FloatArray) -> list[tuple[int, float]]:
        """The rows with their cosines to ``wanted`` (D,), the most similar first."""
        cosines = self.matrix @ (wanted / max(float(np.linalg.norm(wanted)), 1e-12))
        return [(int(i), float(cosines[i])) for i in np.argsort(-cosines, kind="stable")]


def encoded(
    conditions: Sequence[Condition], encoder: TextEncoder, vectors: Vectors, model: str, batch: int = _BATCH
) -> Encodings:
    """Every condition as g_CLIP encodes it; raises SceneError as ``TextEncoder.encode`` does."""
    parts = []
    for start in range(0, len(conditions), batch):
        prompts = [condition.prompt for condition in conditions[start : start + batch]]
        pooled = encoder.encode(prompts, vectors).pooled.detach().float().cpu().numpy()
        parts.append(pooled / np.maximum(np.linalg.norm(pooled, axis=1, keepdims=True), 1e-12))
    rows = tuple(Row(each.word, written(each.prompt), each.handles) for each in conditions)
    matrix = np.concatenate(parts) if parts else np.zeros((0, 0), np.float32)
    return Encodings(model, rows, matrix.astype(np.float32))


def written(prompt: Prompt) -> str:
    """A prompt as text, its slots as handles."""
    return "".join(f"<{piece.name}>" if isinstance(piece, Slot) else piece for piece in prompt)


def to_json(encodings: Encodings) -> dict[str, Any]:
    """All but the matrix, as JSON data."""
    rows = [{"word": row.word, "prompt": row.prompt, "handles": packed(row.handles)} for row in encodings.rows]
    return {"version": VERSION, "model": encodings.model, "rows": rows}


def from_json(data: Mapping[str, Any], matrix: FloatArray) -> Encodings:
    """The inverse of ``to_json``; raises ValueError, KeyError or TypeError for what is none."""
    if data["version"] != VERSION:
        raise ValueError(f"its encodings are of version {str(data['version'])[:20]}; this program knows {VERSION}")
    rows = tuple(Row(str(row["word"]), str(row["prompt"]), unpacked(row["handles"])) for row in data["rows"])
    if matrix.ndim != 2 or len(matrix) != len(rows):
        raise ValueError("its encodings have another number of rows than their matrix")
    return Encodings(str(data["model"]), rows, np.asarray(matrix, np.float32))
