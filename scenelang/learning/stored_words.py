"""Descriptions and encodings in an embeddings file (``files/zfile``), which evaluation does not read.

They are not entries of Z, because a text in an entry evaluates the call again with the merged embedding: with 2,000
entries, a row of 1,000 equal pawns takes 0.54 s instead of 0.07 s and has 1,003 distinct entities instead of 4, and the
time grows quadratically.
"""

from __future__ import annotations

from pathlib import Path

from scenelang.backends.neural import prompts, wording
from scenelang.backends.neural.prompts import Encodings
from scenelang.backends.neural.wording import Wording
from scenelang.files.zfile import ENCODINGS, MATRIX, WORDING, decoded, read_stored, write_stored


def read_wording(path: Path) -> Wording | None:
    """Read the stored descriptions, or return None; raises SceneError if the file is missing or malformed."""
    stored = read_stored(path, WORDING)
    return None if stored is None else decoded(path, lambda: wording.from_json(stored[0]))


def write_wording(path: Path, descriptions: Wording) -> None:
    """Write the descriptions atomically, creating the file if necessary; entries and vectors are preserved."""
    write_stored(path, WORDING, wording.to_json(descriptions))


def read_encodings(path: Path) -> Encodings | None:
    """Read the stored encodings, or return None; raises SceneError if the file is malformed."""
    stored = read_stored(path, ENCODINGS, MATRIX)
    if stored is None:
        return None
    data, matrix = stored
    assert matrix is not None
    return decoded(path, lambda: prompts.from_json(data, matrix))


def write_encodings(path: Path, encodings: Encodings) -> None:
    """Write the encodings atomically, creating the file if necessary."""
    write_stored(path, ENCODINGS, prompts.to_json(encodings), {MATRIX: encodings.matrix})
