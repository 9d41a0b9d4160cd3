"""Ownership of derived files, the card and the folders of formats: which of them a dataset has written.

``derived.json`` lists them with their digests. No other file is ever replaced, and a check finds damaged ones.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from scenelang.datasets.spec import SHARD_FORMATS
from scenelang.datasets.store import Plan, Store
from scenelang.grammar.diagnostics import SceneError

DERIVED, CARD = "derived.json", "README.md"
CARD_TITLE = "# A labeled dataset made with scenelang"
# Digests by path within a folder ("" for a file), None while it is being written.
_Own = Mapping[str, str] | None


def other_formats(plan: Plan) -> list[str]:
    """Return the formats that are derived from the shards."""
    return [name for name in plan.formats if name not in SHARD_FORMATS]


def _read(store: Store) -> dict[str, _Own] | None:
    """Return the files that the dataset has written, by the name of the folder or file; None if that is unknown."""
    try:
        written = json.loads(store.read(DERIVED))
    except (SceneError, ValueError, RecursionError):
        return None
    is_map = isinstance(written, dict) and all(digests is None or _is_own(digests) for digests in written.values())
    return written if is_map else None


def _is_own(value: Any) -> bool:
    """Return whether JSON data are digests by path, none of which leaves its folder."""
    is_map = isinstance(value, dict) and all(isinstance(digest, str) for digest in value.values())
    return is_map and not any(path.startswith("/") or ".." in path.split("/") for path in value)


def _write(store: Store, written: Mapping[str, _Own]) -> None:
    """Write the list of derived files."""
    store.write(DERIVED, json.dumps(written, indent=1, sort_keys=True).encode("utf-8", "surrogatepass"))


def _paths(store: Store, name: str) -> list[str]:
    """Return the paths of the files in a folder of a local store, relative to it, or "" for a file."""
    root = store.path(name)
    if not root.is_dir():
        return [""]
    return sorted(
        os.path.relpath(os.path.join(folder, file), root).replace(os.sep, "/")
        for folder, _, files in os.walk(root)
        for file in files
    )


def check_owned(store: Store, plan: Plan) -> None:
    """Raise SceneError("file") if a file to replace does not belong to this dataset."""
    written = _read(store) or {}
    for name in (*other_formats(plan), CARD):
        stray = _stray(store, name, written) if store.exists(name) else None
        if stray is not None:
            hint = "move it elsewhere, or choose a new folder for the dataset"
            raise SceneError("file", f"`{stray}` in {store.address} was not written by this dataset", hint)


def _stray(store: Store, name: str, written: Mapping[str, _Own]) -> str | None:
    """Return the path of a file at a derived name that does not belong to this dataset, None if all belong to it."""
    if name == CARD:
        is_known = name in written or CARD_TITLE.encode() in store.read(name)
        return None if is_known else name
    if name not in written:
        return name
    digests = written[name]
    strays = [path for path in _paths(store, name) if digests is not None and path not in digests]
    return f"{name}/{strays[0]}".rstrip("/") if strays else None


@contextmanager
def writing_derived(store: Store, plan: Plan) -> Iterator[None]:
    """Claim the card and the folders of the formats before they are written, and record their files afterwards."""
    check_owned(store, plan)
    names = [*other_formats(plan), CARD]
    written = dict(_read(store) or {}) | dict.fromkeys(names)
    _write(store, written)
    yield
    for name in names:
        written[name] = _digests(store, name)
    _write(store, written)


def _digests(store: Store, name: str) -> dict[str, str]:
    """Return the digests of the files at a derived name."""
    if name == CARD:
        return {"": store.digest(name)[0]}
    paths = _paths(store, name) if store.exists(name) else []  # a format of videos is not written for still scenes
    return {path: store.digest(f"{name}/{path}")[0] for path in paths}


def derived_problems(store: Store, plan: Plan) -> Iterator[str]:
    """Yield the problems of the card and the folders of the formats of a complete dataset."""
    written = _read(store)
    if written is None:
        yield f"`{DERIVED}` is missing or damaged"
        return
    for name in (*other_formats(plan), CARD):
        digests = written.get(name)
        label = "the folder `{}`" if name != CARD else "`{}`"
        if digests is None:
            yield f"{label.format(name)} is not finished"
        elif digests and not store.exists(name):
            yield f"{label.format(name)} is missing"
        else:
            yield from _file_problems(store, name, digests)


def _file_problems(store: Store, name: str, digests: Mapping[str, str]) -> Iterator[str]:
    """Yield missing, damaged and foreign files at a derived name."""
    for path, digest in digests.items():
        file_name = f"{name}/{path}".rstrip("/")
        if not store.exists(file_name):
            yield f"`{file_name}` is missing"
        elif store.digest(file_name)[0] != digest:
            yield f"`{file_name}` is damaged: its digest differs from that in `{DERIVED}`"
    if name != CARD and store.exists(name):
        yield from (f"`{name}/{path}` belongs to no dataset" for path in _paths(store, name) if path not in digests)


def names_of_files(names: Sequence[str]) -> list[str]:
    """Return the names in a folder, without temporary files of runs that were killed."""
    return [name for name in names if not name.startswith(".scenelang-")]
