"""The numbers of an evaluation as a file that grows: one record per scene, method and metric."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from scenelang.backends.files import write_json
from scenelang.grammar.diagnostics import SceneError

FILE = "results.json"
_FORMAT, _VERSION = "scenelang-evaluation", 1
_MOST_BYTES = 256_000_000

Key = tuple[str, str, str]


@dataclass(frozen=True, slots=True)
class Record:
    """One number: ``place`` is the file of the scene, ``made`` the fingerprint of what was measured, ``group`` that of
    the paper's tables, ``values`` what the metric says, as JSON data."""

    place: str
    method: str
    metric: str
    made: str
    group: str
    prompt: str | None
    values: Mapping[str, Any]

    @property
    def key(self) -> Key:
        return self.place, self.method, self.metric

    @property
    def value(self) -> float:
        return float(self.values["value"])


@dataclass(frozen=True, slots=True)
class Results:
    """Records by scene, method and metric."""

    records: Mapping[Key, Record] = field(default_factory=dict)

    def known(self, key: Key, made: str) -> Record | None:
        """The record of just this measurement; None where there is none, or one of something that has changed."""
        record = self.records.get(key)
        return record if record is not None and record.made == made else None

    def and_also(self, record: Record) -> Results:
        """These, and one more in the place of what was measured before."""
        return Results({**self.records, record.key: record})


def read_results(folder: Path) -> Results:
    """The results in ``folder``, none where nothing is there yet; raises SceneError("file") for a file that is none."""
    path = folder / FILE
    try:
        if not path.exists():
            return Results()
        if path.stat().st_size > _MOST_BYTES:
            raise ValueError("it is too large")
        data = json.loads(path.read_text("utf-8"))
        if data["format"] != _FORMAT:
            raise ValueError("it is another kind of file")
        if data["version"] != _VERSION:
            raise ValueError(f"its version is {str(data['version'])[:20]}; this program knows {_VERSION}")
        records = [_record(item) for item in data["records"]]
    except KeyError as error:
        raise _damaged(path, f"there is no {error}") from None
    except (OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise _damaged(path, str(error)[:120]) from None
    return Results({record.key: record for record in records})


def write_results(folder: Path, results: Results) -> None:
    """Write the results, whole or not at all; raises SceneError("file")."""
    records = [asdict(record) for record in results.records.values()]
    write_json(folder / FILE, {"format": _FORMAT, "version": _VERSION, "records": records})


def _record(item: Any) -> Record:
    record = Record(**item)
    texts = (record.place, record.method, record.metric, record.made, record.group, record.prompt or "")
    if not all(isinstance(text, str) for text in texts) or not math.isfinite(record.value):
        raise ValueError("a record of it is malformed")
    return record


def _damaged(path: Path, said: str) -> SceneError:
    hint = "move it away, or choose another folder with -o"
    return SceneError("file", f"{path} holds no results that can be read: {said}", hint=hint)
