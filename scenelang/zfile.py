"""Z as a file: embeddings by handle name, beside the program (docs/language.md, section 4).

A safetensors file. Its header's ``scenelang`` entry holds texts and attributes as JSON; tensors hold vectors. The
``scenelang-wording`` entry holds what ``scenelang embed`` found, which evaluation never reads (docs/embeddings.md).
Writing one of these leaves the others as they are in the file.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import written_whole
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.plain import NotPlain, plain_value
from scenelang.interpreter.runtime import Entry
from scenelang.interpreter.unplain import value_of

if TYPE_CHECKING:
    from scenelang.backends.wording.wording import Wording

_KEY = "scenelang"
_WORDING = "scenelang-wording"
Vectors = Mapping[str, npt.NDArray[Any]]


def beside(program: str) -> Path:
    """Where Z of a program lives: ``chess.scene`` has ``chess.z.safetensors``."""
    return Path(program).with_suffix(".z.safetensors")


def read_z(path: Path) -> tuple[dict[str, Entry], dict[str, npt.NDArray[Any]]]:
    """Entries and vectors by handle name; raises SceneError for a file that is missing or malformed."""
    with _faults(path):
        header, vectors = _contents(path)
        entries = {str(name): _entry(fields) for name, fields in json.loads(header.get(_KEY, "{}")).items()}
    for name in vectors:
        entries.setdefault(name, Entry())
    return entries, vectors


def write_z(path: Path, entries: Mapping[str, Entry], vectors: Vectors) -> None:
    """Write Z atomically; a wording that the file holds stays."""
    data = {
        name: {"text": entry.text, "attributes": {key: _to_json(value) for key, value in entry.attributes.items()}}
        for name, entry in entries.items()
    }
    _write(path, {**_header(path), _KEY: json.dumps(data)}, vectors)


def read_wording(path: Path) -> Wording | None:
    """The wording in Z; None where the file holds none. Raises SceneError for one that is missing or malformed."""
    from scenelang.backends.wording.stored import from_json

    with _faults(path):
        text = _contents(path)[0].get(_WORDING)
        return None if text is None else from_json(json.loads(text))


def write_wording(path: Path, wording: Wording) -> None:
    """Write the wording into Z atomically, a new file where there is none; entries and vectors stay."""
    from scenelang.backends.wording.stored import to_json

    with _faults(path):
        header, vectors = _contents(path) if path.exists() else ({}, {})
    _write(path, {**header, _WORDING: json.dumps(to_json(wording))}, vectors)


def _header(path: Path) -> dict[str, str]:
    if not path.exists():
        return {}
    with _faults(path):
        return _contents(path)[0]


def _contents(path: Path) -> tuple[dict[str, str], dict[str, npt.NDArray[Any]]]:
    from safetensors import safe_open

    with safe_open(str(path), framework="numpy") as file:
        vectors = {name: np.asarray(file.get_tensor(name)) for name in file.keys()}  # noqa: SIM118
        return file.metadata() or {}, vectors


@contextmanager
def _faults(path: Path) -> Iterator[None]:
    """Failures to read the file as SceneErrors."""
    from safetensors import SafetensorError

    try:
        yield
    except FileNotFoundError:
        raise SceneError("file", f"cannot read {path}: No such file or directory") from None
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise SceneError("z-file", f"{path} is no file of embeddings: {str(error)[:120]}") from None


def _write(path: Path, header: Mapping[str, str], vectors: Vectors) -> None:
    from safetensors.numpy import save

    data = save(dict(vectors), metadata=dict(header))
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
