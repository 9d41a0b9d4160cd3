"""Tagged plain data as the language's values again: the inverse of ``plain.plain_value(value, tagged=True)``."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenelang.interpreter.arrays import array_literal, from_numpy
from scenelang.interpreter.equality import table_key
from scenelang.interpreter.plain import MAX_DEPTH
from scenelang.interpreter.values import Embedding, Table, make_list


def value_of(plain: Any, depth: int = 0) -> Any:
    """The value that tagged JSON data stands for; raises ValueError where it stands for none."""
    if depth > MAX_DEPTH:
        raise ValueError("an attribute is nested too deeply")
    if isinstance(plain, list):
        return make_list([value_of(item, depth + 1) for item in plain])
    if not isinstance(plain, dict):
        return plain
    if "array" in plain:
        return _array(plain["array"])
    if "table" in plain:
        pairs = [(value_of(key, depth + 1), value_of(item, depth + 1)) for key, item in plain["table"]]
        return Table({table_key(key): (key, item) for key, item in pairs}, -1)
    if "embedding" in plain:
        handle, text, attributes = plain["embedding"]
        return Embedding(handle, text, {name: value_of(item, depth + 1) for name, item in attributes.items()})
    raise ValueError("an attribute is malformed")


def _array(data: Any) -> Any:
    if not isinstance(data, list):
        raise ValueError("an array is no list")
    if all(isinstance(x, (int, float)) for x in data):
        return array_literal(data)
    return from_numpy(np.array(data))
