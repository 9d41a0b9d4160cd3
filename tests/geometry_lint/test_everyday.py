"""Everyday scenes by people who did not know the rules: faults are found, sound scenes silent (docs/facts.md)."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
sys.path.append(str(BENCHMARKS))  # behind the tests, whose packages have the names of some benchmarks
from everyday import findings_of, is_found, is_note

SETS = (BENCHMARKS / "everyday", BENCHMARKS / "everyday" / "second")
FAULTS = [(folder, fault) for folder in SETS for fault in json.loads((folder / "faults" / "faults.json").read_text())]
SOUND = [
    path
    for folder in SETS
    for pattern in ("sound/*.scene", "faults/*.good.scene")
    for path in sorted(folder.glob(pattern))
]
MISSED = {"23_ulmet.scene"}  # the leg of a table whose top alone is in balance on the other three
ALARMED = {  # known false alarms: parts of buildings that run into each other, deep legs, solid models of hollow things
    "15_truss_bridge", "25_leiterwagen", "30_bahnhof", "50_hux", "51_arax", "53_cadge", "54_tubb", "06_lap_counter",
    "07_sand_castle", "10_goat_pasture", "16_bauernstube.good",
}  # fmt: skip


@pytest.mark.parametrize(
    ("folder", "fault"), FAULTS, ids=lambda value: value["file"][:-6] if isinstance(value, dict) else value.name
)
@pytest.mark.sampled(12)
def test_faults_are_found(folder: Path, fault: dict[str, Any]) -> None:
    is_known = fault["file"] not in MISSED
    assert is_found(findings_of(folder / "faults" / fault["file"]), fault) == is_known


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.stem)
@pytest.mark.sampled(12)
def test_sound_scenes_have_no_warnings(path: Path) -> None:
    warnings = [d for d in findings_of(path) if not is_note(d)]
    assert bool(warnings) == (path.stem in ALARMED)
