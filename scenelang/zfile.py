"""Z as a file: embeddings by handle name, beside the program (docs/language.md, section 4).

A safetensors file. Its header's ``scenelang`` entry holds texts and attributes as JSON; tensors hold vectors.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import written_whole
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.plain import NotPlain, plain_value
from scenelang.interpreter.runtime import Entry
from scenelang.interpreter.unplain import value_of

_KEY = "scenelang"
Vectors = Mapping[str, npt.NDArray[Any]]


def beside(program: str) -> Path:
    """Where Z of a program lives: ``chess.scene`` has ``chess.z.safetensors``."""
    return Path(program).with_suffix(".z.safetensors")


def read_z(path: Path) -> tuple[dict[str, Entry], dict[str, npt.NDArray[Any]]]:
    """Entries and vectors by handle name; raises SceneError for a file that is missing or malformed."""
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(str(path), framework="numpy") as file:
            header = json.loads((file.metadata() or {}).get(_KEY, "{}"))
            vectors = {name: np.asarray(file.get_tensor(name)) for name in file.keys()}  # noqa: SIM118
        entries = {str(name): _entry(fields) for name, fields in header.items()}
    except FileNotFoundError:
        raise SceneError("file", f"cannot read {path}: No such file or directory") from None
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise SceneError("z-file", f"{path} is no file of embeddings: {str(error)[:120]}") from None
    for name in vectors:
        entries.setdefault(name, Entry())
    return entries, vectors


def write_z(path: Path, entries: Mapping[str, Entry], vectors: Vectors) -> None:
    """Write Z atomically."""
    from safetensors.numpy import save

    header = {
        name: {"text": entry.text, "attributes": {key: _to_json(value) for key, value in entry.attributes.items()}}
        for name, entry in entries.items()
    }
    data = save(dict(vectors), metadata={_KEY: json.dumps(header)})
    with written_whole(path) as temporary:
        temporary.write_bytes(data)


def _entry(fields: Mapping[str, Any]) -> Entry:
    text = fields.get("text")
    if text is not None and not isinstance(text, str):
        raise ValueError("a text must be a string")
    return Entry(text, {str(name): value_of(value) for name, value in (fields.get("attributes") or {}).items()})


def _to_json(value: Any) -> Any:
    try:
        return plain_value(value, tagged=True)
    except NotPlain:
        raise SceneError("value", "an attribute cannot be stored in a file") from None
