"""File format of embeddings (Z), stored by handle name beside the program (docs/language.md, section 4).

The format is safetensors. The header entry ``scenelang`` contains texts and attributes as JSON; a tensor named after a
handle contains its learned token vectors (K, width), and ``scenelang-made`` their provenance. ``scenelang-wording``
contains the result of ``scenelang embed``, ``scenelang-encodings`` and the tensor ``/encodings`` that of ``scenelang
embeddings encode``; evaluation does not read these (docs/embeddings.md). Writing one of them preserves the others.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from scenelang.backends.files import atomic_write, lock_folder, read_regular
from scenelang.grammar.datum import asdict, dataclass
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.show import NotPlain, plain_value, value_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from scenelang.interpreter.runtime.runtime import ZEntry

# Keys of the header, and the name of a tensor.
_KEY = "scenelang"
WORDING = "scenelang-wording"
_PROVENANCE = "scenelang-made"
ENCODINGS = "scenelang-encodings"
MATRIX = "/encodings"  # not a valid handle name
_MAX_HEADER_SIZE = 4_000_000  # bytes
Decoded = TypeVar("Decoded")
Vectors: TypeAlias = "Mapping[str, npt.NDArray[Any]]"


def read_z(path: Path) -> tuple[dict[str, ZEntry], dict[str, npt.NDArray[Any]]]:
    """Read entries and vectors by handle name; raises SceneError if the file is missing or malformed."""
    from scenelang.interpreter.runtime.runtime import ZEntry

    with _read_errors(path):
        header, vectors = _contents(path)
        entries = {str(name): _named_entry(name, fields) for name, fields in _parsed(header, _KEY).items()}
    learned = {name: vector for name, vector in vectors.items() if name != MATRIX}
    for name in learned:
        entries.setdefault(name, ZEntry())
    return entries, learned


def read_entries(path: Path) -> dict[str, ZEntry]:
    """Read only the entries by handle name, without the potentially large vectors; raises SceneError."""
    from safetensors import safe_open

    from scenelang.interpreter.runtime.runtime import ZEntry

    with _read_errors(path):
        _check_header(path)
        with safe_open(str(path), framework="numpy") as file:
            names, header = list(file.keys()), file.metadata() or {}
        entries = {str(name): _named_entry(name, fields) for name, fields in _parsed(header, _KEY).items()}
    for name in names:
        if name != MATRIX:
            entries.setdefault(name, ZEntry())
    return entries


def write_z(path: Path, entries: Mapping[str, ZEntry], vectors: Vectors) -> None:
    """Write entries and vectors atomically; stored descriptions and the provenance of the vectors are preserved."""
    with lock_folder(path.parent):
        _write_z(path, entries, vectors)


def set_entry(path: Path, name: str, text: str | None, attributes: Mapping[str, Any], clear: bool = False) -> None:
    """Change one entry, creating the file if necessary; concurrent changes by other processes are preserved.

    Parameters
    ----------
    text : str, optional
        New text; None leaves it unchanged.
    attributes : mapping
        Attributes to add.
    clear : bool
        First remove the existing text, attributes and vectors.
    """
    from scenelang.interpreter.runtime.runtime import ZEntry

    with lock_folder(path.parent):
        entries, vectors = read_z(path) if os.path.exists(path) else ({}, {})
        old = ZEntry() if clear else entries.get(name, ZEntry())
        entry = ZEntry(text if text is not None else old.text, {**old.attributes, **attributes})
        if clear:
            vectors.pop(name, None)
        if clear and entry == ZEntry():
            entries.pop(name, None)
        else:
            entries[name] = entry
        _write_z(path, entries, vectors)


def _write_z(path: Path, entries: Mapping[str, ZEntry], vectors: Vectors) -> None:
    """Write entries and vectors in a folder that is locked, with the provenance of the vectors that remain."""
    data = {
        name: {"text": entry.text, "attributes": {key: _to_json(value) for key, value in entry.attributes.items()}}
        for name, entry in entries.items()
    }
    header, old = _old(path)
    encodings = {MATRIX: old[MATRIX]} if MATRIX in old else {}
    if _PROVENANCE in header:
        provenance = _table(path, header, _PROVENANCE)
        header[_PROVENANCE] = json.dumps({name: record for name, record in provenance.items() if name in vectors})
    _write(path, {**header, _KEY: json.dumps(data)}, {**vectors, **encodings})


@dataclass(frozen=True, slots=True)
class Made:
    """Provenance of learned vectors.

    Attributes
    ----------
    how
        Method: ``inversion``, ``style`` or ``picture``.
    source
        What they were learned from.
    model
        Name of the model.
    when
        Time in ISO 8601.
    """

    how: str
    source: str
    model: str
    when: str


def read_made(path: Path) -> dict[str, Made]:
    """Read the provenance of the vectors by handle, as far as it is recorded; raises SceneError."""
    with _read_errors(path):
        records = _parsed(_contents(path)[0], _PROVENANCE)
        return {str(name): _made(name, fields) for name, fields in records.items()}


def _made(name: str, fields: Any) -> Made:
    """Parse a provenance record; raises ValueError that names the handle."""
    try:
        return Made(**{key: str(value) for key, value in fields.items()})
    except (TypeError, AttributeError) as error:
        raise ValueError(f"provenance of <{name[:40]}>: {error}") from None


def write_vectors(path: Path, vectors: Vectors, made: Mapping[str, Made]) -> None:
    """Add or replace learned vectors atomically.

    Parameters
    ----------
    path
        Z file, which is created if it does not exist.
    vectors
        Tensors by name.
    made
        How each of them was learned, by name.
    """
    with lock_folder(path.parent):
        header, old = _old(path)
        provenance = _table(path, header, _PROVENANCE) | {name: asdict(record) for name, record in made.items()}
        _write(path, {**header, _PROVENANCE: json.dumps(provenance)}, {**old, **vectors})


def read_stored(path: Path, key: str, tensor: str | None = None) -> tuple[Any, npt.NDArray[Any] | None] | None:
    """Read data that is not part of evaluation: a header entry as JSON, with a tensor.

    Returns None if there is no such entry; raises SceneError if the file is missing or malformed.
    """
    with _read_errors(path):
        header, vectors = _contents(path)
        if key not in header:
            return None
        return json.loads(header[key]), vectors[tensor] if tensor is not None else None


def decoded(path: Path, decode: Callable[[], Decoded]) -> Decoded:
    """Return the result of ``decode()``; errors of malformed data become SceneError("z-file"), which names ``path``."""
    with _read_errors(path):
        return decode()


def write_stored(path: Path, key: str, data: Any, vectors: Vectors | None = None) -> None:
    """Write an entry of the header and tensors to a Z file, atomically; everything else in the file is preserved.

    Parameters
    ----------
    path
        File, which is created if it does not exist.
    key
        Key of the header entry.
    data
        Value of the entry, which is stored as JSON.
    vectors
        Tensors by name, which replace those of the same names.
    """
    with lock_folder(path.parent):
        header, old = _old(path)
        _write(path, {**header, key: json.dumps(data)}, {**old, **(vectors or {})})


def swap_handles(path: Path, one: str, other: str) -> bool:
    """Swap text, attributes, vectors and provenance of two handles, and remove encodings of the old prompts.

    Returns
    -------
    bool
        Whether the file has an entry of either.
    """
    with lock_folder(path.parent):
        return _swap_handles(path, one, other)


def _swap_handles(path: Path, one: str, other: str) -> bool:
    """Swap two handles in a folder that is locked."""
    header, vectors = _old(path)
    tables = {key: _table(path, header, key) for key in (_KEY, _PROVENANCE)}
    swapped = [_swapped(table, one, other) for table in (*tables.values(), vectors)]
    if not any(name in table for table in (*tables.values(), vectors) for name in (one, other)):
        return False
    header = {**header, _KEY: json.dumps(swapped[0]), _PROVENANCE: json.dumps(swapped[1])}
    header.pop(ENCODINGS, None)
    _write(path, header, {name: vector for name, vector in swapped[2].items() if name != MATRIX})
    return True


def _swapped(table: Mapping[str, Any], one: str, other: str) -> dict[str, Any]:
    """Return a table with two of its keys swapped."""
    names = {one: other, other: one}
    return {names.get(name, name): value for name, value in table.items()}


def _old(path: Path) -> tuple[dict[str, str], dict[str, npt.NDArray[Any]]]:
    """Return header and tensors of the file, both empty if it does not exist."""
    if not os.path.exists(path):
        return {}, {}
    with _read_errors(path):
        return _contents(path)


def _table(path: Path, header: Mapping[str, str], key: str) -> dict[str, Any]:
    """Parse a header entry as a table by handle name; raises SceneError if it is malformed."""
    with _read_errors(path):
        return _parsed(header, key)


def _contents(path: Path) -> tuple[dict[str, str], dict[str, npt.NDArray[Any]]]:
    """Return header and tensors of a file; raises any of the exceptions that ``_read_errors`` converts."""
    from safetensors import safe_open

    _check_header(path)
    with safe_open(str(path), framework="numpy") as file:
        vectors = {name: np.asarray(file.get_tensor(name)) for name in file.keys()}  # noqa: SIM118
        return file.metadata() or {}, vectors


def _check_header(path: Path) -> None:
    """Raise ValueError if the header is too large to read, OSError if the file is not a regular file."""
    start = read_regular(path, 8)
    if len(start) == 8 and int.from_bytes(start, "little") > _MAX_HEADER_SIZE:
        raise ValueError(f"header exceeds {_MAX_HEADER_SIZE:,} bytes")


@contextmanager
def _read_errors(path: Path) -> Iterator[None]:
    """Convert exceptions while reading the file to SceneError."""
    from safetensors import SafetensorError

    try:
        yield
    except FileNotFoundError:
        raise SceneError("file", f"cannot read {path}: No such file or directory") from None
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise SceneError("z-file", f"{path} is not a valid embeddings file: {str(error)[:200]}") from None


def _write(path: Path, header: Mapping[str, str], vectors: Vectors) -> None:
    """Write header and tensors atomically."""
    from safetensors.numpy import save

    data = save(dict(vectors), metadata=dict(header))
    with atomic_write(path) as temporary:
        temporary.write_bytes(data)


def _parsed(header: Mapping[str, str], key: str) -> dict[str, Any]:
    """Parse a JSON table of the header; raises ValueError that names the entry."""
    try:
        table = json.loads(header.get(key, "{}"))
    except ValueError as error:
        raise ValueError(f"header entry `{key}` is not valid JSON ({error})") from None
    if not isinstance(table, dict):
        raise ValueError(f"header entry `{key}` is not a JSON object")
    return table


def _named_entry(name: str, fields: Any) -> ZEntry:
    """Parse an entry; raises ValueError that names the entry and the malformed field."""
    try:
        if not isinstance(fields, dict):
            raise ValueError("expected a JSON object with `text` and `attributes`")
        return _entry(fields)
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise ValueError(f"entry <{name[:40]}>: {error}") from None


def _entry(fields: Mapping[str, Any]) -> ZEntry:
    """Parse an entry; raises ValueError."""
    from scenelang.interpreter.runtime.runtime import ZEntry

    text = fields.get("text")
    if text is not None and not isinstance(text, str):
        raise ValueError("`text` must be a string")
    attributes = fields.get("attributes") or {}
    if not isinstance(attributes, dict):
        raise ValueError("`attributes` must be a JSON object")
    return ZEntry(text, {str(name): _attribute(str(name), value) for name, value in attributes.items()})


def _attribute(name: str, value: Any) -> Any:
    """Parse the value of an attribute; raises ValueError that names it."""
    try:
        return value_of(value)
    except (ValueError, TypeError, KeyError) as error:
        raise ValueError(f"attribute `{name[:40]}`: {error}") from None


def _to_json(value: Any) -> Any:
    """Return the value of an attribute as JSON data; raises SceneError if it has none."""
    try:
        return plain_value(value, tagged=True)
    except NotPlain:
        raise SceneError("value", "attribute value cannot be stored in a file") from None
