"""The file Z: wording, entries and vectors live side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.backends.neural.wording import (
    Wording,
    WordingRow,
    from_json,
    pack_handles,
    sort_handles,
    to_json,
    unpack_handles,
)
from scenelang.files.zfile import read_z, write_z
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.learning.stored_words import read_wording, write_wording

WORDING = Wording(
    "z1", "a room", (WordingRow("sofa", "ivory", "a {embedding} sofa", ("young", "z2", "z4", "z6", "z8")),)
)
TEXTS = st.text(st.characters(codec="utf-8"), min_size=1, max_size=20)
HANDLES = st.lists(
    st.one_of(st.integers(1, 10**17).map("z{}".format), st.integers(1, 60).map("z{}".format), TEXTS), max_size=60
)


@given(HANDLES)
def test_handles_come_back(handles: list[str]) -> None:
    ordered = sort_handles(handles)
    assert sorted(ordered) == sorted(set(handles))
    assert unpack_handles(json.loads(json.dumps(pack_handles(ordered)))) == ordered


@given(st.integers(1, 9), st.lists(st.integers(1, 30), min_size=1, max_size=20), st.integers(5, 200))
def test_a_rhythm_is_one_item(first: int, steps: list[int], turns: int) -> None:
    numbers = [first]
    for step in steps * turns:
        numbers.append(numbers[-1] + step)
    handles = tuple(f"z{number}" for number in numbers)
    items = pack_handles(handles)
    assert len(items) <= 1 + len(steps)  # a short run at the start may be taken for a rhythm
    assert unpack_handles(items) == handles


@given(TEXTS, TEXTS, st.lists(st.tuples(TEXTS, TEXTS, TEXTS, HANDLES), max_size=5))
def test_wordings_come_back(style: str, text: str, rows: list[tuple[str, str, str, list[str]]]) -> None:
    wording = Wording(style, text, tuple(WordingRow(a, b, c, sort_handles(handles)) for a, b, c, handles in rows))
    assert from_json(json.loads(json.dumps(to_json(wording)))) == wording


def test_each_survives_changes_of_the_others(tmp_path: Path) -> None:
    path = tmp_path / "a.z.safetensors"
    write_wording(path, WORDING)
    assert read_z(path) == ({}, {})
    vector = np.arange(4, dtype=np.float32)
    write_z(path, {"z5": ZEntry("oak", {"h": 2})}, {"z5": vector})
    assert read_wording(path) == WORDING
    other = Wording("z1", "b", ())
    write_wording(path, other)
    entries, vectors = read_z(path)
    assert entries == {"z5": ZEntry("oak", {"h": 2})}
    assert np.array_equal(vectors["z5"], vector)
    assert vectors["z5"].dtype == vector.dtype
    assert read_wording(path) == other


def test_a_file_without_wording(tmp_path: Path) -> None:
    path = tmp_path / "a.z.safetensors"
    write_z(path, {"z5": ZEntry("oak")}, {})
    assert read_wording(path) is None


@pytest.mark.parametrize(
    "data",
    [
        [], {}, {"version": 2}, 3, None,
        {"version": 1, "style": {"handle": "z1", "text": ""}, "rows": []},
        {**to_json(WORDING), "rows": [{"word": "a", "text": "b", "template": "c", "handles": [[1, 10**12, 1]]}]},
        {**to_json(WORDING), "rows": [{"word": "a", "text": "b", "template": "c", "handles": [[1, 5, 0]]}]},
        {**to_json(WORDING), "rows": [{"word": "a", "text": "b", "template": "c", "handles": [[1, 5]]}]},
        {**to_json(WORDING), "rows": [{"word": "a", "text": "b", "handles": []}]},
        {**to_json(WORDING), "rows": [{"word": 3, "text": "b", "template": "c", "handles": []}]},
    ],
)  # fmt: skip
def test_a_malformed_wording_is_said_to_be_one(data: Any, tmp_path: Path) -> None:
    from safetensors.numpy import save

    path = tmp_path / "a.z.safetensors"
    path.write_bytes(save({}, metadata={"scenelang-wording": json.dumps(data)}))
    with pytest.raises(SceneError) as caught:
        read_wording(path)
    assert caught.value.name == "z-file"


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        read_wording(tmp_path / "none.safetensors")
    assert caught.value.name == "file"
