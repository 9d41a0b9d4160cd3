"""What is made from all shards, the card and the folders of formats: which files of it a dataset has written.

``derived.json`` names them with their digests. Nothing else is ever replaced, and a check finds what is damaged.
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
CARD_TITLE = "# A labelled dataset made with scenelang"
# Digests by path within a folder ("" for a file), None while it is being written.
_Own = Mapping[str, str] | None


def other_formats(plan: Plan) -> list[str]:
    """Return the formats that are made from the shards."""
    return [name for name in plan.formats if name not in SHARD_FORMATS]


def _read(store: Store) -> dict[str, _Own] | None:
    """Return what the dataset has written, by the name of the folder or file, None if that is not known."""
    try:
        found = json.loads(store.read(DERIVED))
    except (SceneError, ValueError, RecursionError):
        return None
    is_map = isinstance(found, dict) and all(each is None or _is_own(each) for each in found.values())
    return found if is_map else None


def _is_own(value: Any) -> bool:
    """Return whether JSON data are digests by path, none of which leaves its folder."""
    is_map = isinstance(value, dict) and all(isinstance(digest, str) for digest in value.values())
    return is_map and not any(path.startswith("/") or ".." in path.split("/") for path in value)


def _write(store: Store, written: Mapping[str, _Own]) -> None:
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
    """Raise SceneError("file") if something that would be replaced is not of this dataset."""
    written = _read(store) or {}
    for name in (*other_formats(plan), CARD):
        stray = _stray(store, name, written) if store.exists(name) else None
        if stray is not None:
            hint = "move it elsewhere, or choose a new folder for the dataset"
            raise SceneError("file", f"`{stray}` in {store.address} was not written by this dataset", hint)


def _stray(store: Store, name: str, written: Mapping[str, _Own]) -> str | None:
    """Return what is at the place of a file or folder and not of this dataset, None if all is."""
    if name == CARD:
        is_known = name in written or CARD_TITLE.encode() in store.read(name)
        return None if is_known else name
    if name not in written:
        return name
    own = written[name]
    strays = [path for path in _paths(store, name) if own is not None and path not in own]
    return f"{name}/{strays[0]}".rstrip("/") if strays else None


@contextmanager
def writing_derived(store: Store, plan: Plan) -> Iterator[None]:
    """Claim the card and the folders of the formats before they are written, and note their files afterwards."""
    check_owned(store, plan)
    names = [*other_formats(plan), CARD]
    written = dict(_read(store) or {}) | dict.fromkeys(names)
    _write(store, written)
    yield
    for name in names:
        written[name] = _digests(store, name)
    _write(store, written)


def _digests(store: Store, name: str) -> dict[str, str]:
    if name == CARD:
        return {"": store.digest(name)[0]}
    paths = _paths(store, name) if store.exists(name) else []  # a format of videos has nothing for still scenes
    return {path: store.digest(f"{name}/{path}")[0] for path in paths}


def derived_problems(store: Store, plan: Plan) -> Iterator[str]:
    """Yield what is wrong with the card and the folders of the formats of a complete dataset."""
    written = _read(store)
    if written is None:
        yield f"`{DERIVED}` is missing or damaged"
        return
    for name in (*other_formats(plan), CARD):
        own = written.get(name)
        what = "the folder `{}`" if name != CARD else "`{}`"
        if own is None:
            yield f"{what.format(name)} is not finished"
        elif own and not store.exists(name):
            yield f"{what.format(name)} is missing"
        else:
            yield from _file_problems(store, name, own)


def _file_problems(store: Store, name: str, own: Mapping[str, str]) -> Iterator[str]:
    for path, digest in own.items():
        shown = f"{name}/{path}".rstrip("/")
        if not store.exists(shown):
            yield f"`{shown}` is missing"
        elif store.digest(shown)[0] != digest:
            yield f"`{shown}` is damaged: its digest differs from that in `{DERIVED}`"
    if name != CARD and store.exists(name):
        yield from (f"`{name}/{path}` belongs to no dataset" for path in _paths(store, name) if path not in own)


def names_of_files(names: Sequence[str]) -> list[str]:
    """Return the names in a folder but those of temporary files of runs that were killed."""
    return [name for name in names if not name.startswith(".scenelang-")]
