"""Flattened scenes from JSON, as primitives to compare: golden files of the corpus, and what ``flatten --json`` prints.

Both are ``{"frames": [{"primitives": [...]}, ...]}``. A primitive of a golden file has its attributes beside ``shape``
and ``matrix`` (4x4), one of ``flatten`` has ``word``, ``attributes`` and ``matrix``; ``path`` may tell the words from
the root to its parent. Files are data from anywhere: whatever is wrong with one is a SceneError.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np

from scenelang.backends.files import read_regular
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.difference import Sheet, Solid, solid_of

_LARGEST_FILE = 128_000_000  # bytes; as Python data a hostile one takes thirty times as much
_LONGEST_PATH = 1_000


def read_sheets(path: str, limit: int) -> list[Sheet]:
    """The frames of a file, at most ``limit`` primitives in all; raises SceneError for a file that holds none."""
    try:
        data = json.loads(_text(path), parse_constant=_refuse_constant)
        return _sheets(data, path, limit)
    except RecursionError:
        raise SceneError("file", f"{path} is nested too deeply for a flattened scene") from None
    except MemoryError:
        raise LimitError("memory", f"{path} does not fit into memory") from None
    except ValueError as error:  # malformed JSON too
        raise SceneError("file", f"{path} is no flattened scene: {error}", _HINT) from None


_HINT = "`scenelang flatten FILE --json` prints one"


def _text(path: str) -> str:
    try:
        data = read_regular(path, _LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        raise SceneError("file", f"cannot read {path}: {getattr(error, 'strerror', None) or 'is no path'}") from None
    if len(data) > _LARGEST_FILE:
        raise SceneError("file", f"{path} is larger than {_LARGEST_FILE:,} bytes")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError("encoding", f"{path} is not UTF-8 text") from None


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"it holds {name}, which is no number")


def _member(data: Any, name: str, where: str) -> list[Any]:
    value = data.get(name) if isinstance(data, dict) else None
    if not isinstance(value, list):
        raise ValueError(f'{where} has no list "{name}"')
    return value


def _sheets(data: Any, path: str, limit: int) -> list[Sheet]:
    frames = _member(data, "frames", "the file")
    lists = [_member(frame, "primitives", f"frames[{i}]") for i, frame in enumerate(frames)]
    total = sum(map(len, lists))
    if total > limit:
        message = f"{path} holds {total:,} primitives, more than the limit of {limit:,}"
        raise LimitError("primitives", message, hint="raise it with --max-primitives")
    return [_sheet(primitives, i) for i, primitives in enumerate(lists)]


def _sheet(primitives: Sequence[Any], frame: int) -> Sheet:
    solids: dict[Solid, int] = {}
    paths: dict[tuple[str, ...], int] = {}
    count = len(primitives)
    index, path_index = np.zeros(count, np.int64), np.zeros(count, np.int64)
    matrices = np.zeros((count, 3, 4))
    for i, primitive in enumerate(primitives):
        try:
            solid = _solid(primitive)
            index[i] = solids.setdefault(solid, len(solids))
            matrices[i] = _matrix(primitive.get("matrix"))
            path_index[i] = paths.setdefault(_path(primitive.get("path")), len(paths))
        except (ValueError, OverflowError) as error:
            raise ValueError(f"frames[{frame}].primitives[{i}] {error}") from None
    return Sheet(tuple(solids), index, matrices, tuple(paths), path_index)


def _solid(primitive: Any) -> Solid:
    if not isinstance(primitive, dict):
        raise ValueError("is no primitive")
    attributes = primitive.get("attributes")
    if not attributes:  # a golden file's: they stand beside the shape
        attributes = primitive
    if not isinstance(attributes, dict):
        raise ValueError("has attributes that are no table")
    word = primitive.get("shape") or primitive.get("word")
    if not isinstance(word, str):
        raise ValueError('has no "shape" and no "word"')
    return solid_of(word, attributes, scaled_blocks="block_type" not in primitive)


def _matrix(value: Any) -> list[list[float]]:
    """The upper three rows of a 4x4 matrix."""
    rows = value if isinstance(value, list) else []
    if len(rows) == 16:
        rows = [rows[i : i + 4] for i in range(0, 16, 4)]
    if len(rows) != 4 or not all(isinstance(row, list) and len(row) == 4 for row in rows):
        raise ValueError("has no 4x4 matrix")
    for row in rows:
        for number in row:
            if type(number) not in (int, float) or not math.isfinite(number):
                raise ValueError("has a matrix that holds more than numbers")
    if rows[3] != [0, 0, 0, 1]:
        raise ValueError("has a matrix whose last row is not 0 0 0 1")
    return rows[:3]


def _path(value: Any) -> tuple[str, ...]:
    if value is None:
        return ()
    if not isinstance(value, list) or len(value) > _LONGEST_PATH or not all(isinstance(word, str) for word in value):
        raise ValueError("has a path that is no list of words")
    return tuple(value)
