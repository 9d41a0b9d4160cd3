"""Z as a file: embeddings by handle name, beside the program (docs/language.md, section 4).

A safetensors file. Its header's ``scenelang`` entry holds texts and attributes as JSON; a tensor called after a handle
holds the learned vectors (K, width) that stand in its place, and ``scenelang-made`` says how they came to be. The
``scenelang-wording`` entry holds what ``scenelang embed`` found, ``scenelang-encodings`` and the tensor ``/encodings``
what ``scenelang embeddings encode`` did; evaluation reads neither (docs/embeddings.md). Writing one of these leaves the
others as they are in the file.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
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
    from scenelang.backends.clip.encodings import Encodings
    from scenelang.backends.wording.wording import Wording

_KEY = "scenelang"
_WORDING = "scenelang-wording"
_MADE = "scenelang-made"
_ENCODINGS = "scenelang-encodings"
_MATRIX = "/encodings"  # no handle is called so
Vectors = Mapping[str, npt.NDArray[Any]]


def beside(program: str) -> Path:
    """Where Z of a program lives: ``chess.scene`` has ``chess.z.safetensors``."""
    return Path(program).with_suffix(".z.safetensors")


def read_z(path: Path) -> tuple[dict[str, Entry], dict[str, npt.NDArray[Any]]]:
    """Entries and vectors by handle name; raises SceneError for a file that is missing or malformed."""
    with _faults(path):
        header, vectors = _contents(path)
        entries = {str(name): _entry(fields) for name, fields in json.loads(header.get(_KEY, "{}")).items()}
    learned = {name: vector for name, vector in vectors.items() if name != _MATRIX}
    for name in learned:
        entries.setdefault(name, Entry())
    return entries, learned


def write_z(path: Path, entries: Mapping[str, Entry], vectors: Vectors) -> None:
    """Write Z atomically; a wording that the file holds stays, and how the vectors came to be that are written."""
    data = {
        name: {"text": entry.text, "attributes": {key: _to_json(value) for key, value in entry.attributes.items()}}
        for name, entry in entries.items()
    }
    header, old = _old(path)
    kept = {_MATRIX: old[_MATRIX]} if _MATRIX in old else {}
    if _MADE in header:
        made = json.loads(header[_MADE])
        header[_MADE] = json.dumps({name: each for name, each in made.items() if name in vectors})
    _write(path, {**header, _KEY: json.dumps(data)}, {**vectors, **kept})


def read_wording(path: Path) -> Wording | None:
    """The wording in Z; None where the file holds none. Raises SceneError for one that is missing or malformed."""
    from scenelang.backends.wording.stored import from_json

    with _faults(path):
        text = _contents(path)[0].get(_WORDING)
        return None if text is None else from_json(json.loads(text))


def write_wording(path: Path, wording: Wording) -> None:
    """Write the wording into Z atomically, a new file where there is none; entries and vectors stay."""
    from scenelang.backends.wording.stored import to_json

    header, vectors = _old(path)
    _write(path, {**header, _WORDING: json.dumps(to_json(wording))}, vectors)


@dataclass(frozen=True, slots=True)
class Made:
    """How vectors came to be: by what (``inversion``, ``style``, ``picture``), of what, by which model, and when (ISO
    8601)."""

    how: str
    source: str
    model: str
    when: str


def read_made(path: Path) -> dict[str, Made]:
    """How the vectors of each handle came to be, where the file tells; raises SceneError."""
    with _faults(path):
        found = json.loads(_contents(path)[0].get(_MADE, "{}"))
        return {str(name): Made(**{key: str(value) for key, value in fields.items()}) for name, fields in found.items()}


def write_vectors(path: Path, vectors: Vectors, made: Mapping[str, Made]) -> None:
    """Add learned vectors to Z atomically, a new file where there is none; those of the same handles are replaced."""
    header, old = _old(path)
    told = json.loads(header.get(_MADE, "{}")) | {name: asdict(each) for name, each in made.items()}
    _write(path, {**header, _MADE: json.dumps(told)}, {**old, **vectors})


def swap_handles(path: Path, one: str, other: str) -> bool:
    """Exchange what Z says of two handles: texts, attributes, vectors and how these came to be; False where it says
    nothing of either. Encodings of the old sentences are dropped."""
    header, vectors = _old(path)
    tables = {key: json.loads(header.get(key, "{}")) for key in (_KEY, _MADE)}
    swapped = [_swapped(each, one, other) for each in (*tables.values(), vectors)]
    if not any(name in each for each in (*tables.values(), vectors) for name in (one, other)):
        return False
    header = {**header, _KEY: json.dumps(swapped[0]), _MADE: json.dumps(swapped[1])}
    header.pop(_ENCODINGS, None)
    _write(path, header, {name: vector for name, vector in swapped[2].items() if name != _MATRIX})
    return True


def _swapped(table: Mapping[str, Any], one: str, other: str) -> dict[str, Any]:
    names = {one: other, other: one}
    return {names.get(name, name): value for name, value in table.items()}


def read_encodings(path: Path) -> Encodings | None:
    """The encoded conditions in Z; None where it holds none. Raises SceneError for what is malformed."""
    from scenelang.backends.clip.encodings import from_json

    with _faults(path):
        header, vectors = _contents(path)
        return from_json(json.loads(header[_ENCODINGS]), vectors[_MATRIX]) if _ENCODINGS in header else None


def write_encodings(path: Path, encodings: Encodings) -> None:
    """Write encoded conditions into Z atomically, a new file where there is none."""
    from scenelang.backends.clip.encodings import to_json

    header, vectors = _old(path)
    header[_ENCODINGS] = json.dumps(to_json(encodings))
    _write(path, header, {**vectors, _MATRIX: encodings.matrix})


def _old(path: Path) -> tuple[dict[str, str], dict[str, npt.NDArray[Any]]]:
    """Header and tensors of the file; none where there is no file."""
    if not path.exists():
        return {}, {}
    with _faults(path):
        return _contents(path)


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
