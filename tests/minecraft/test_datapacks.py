"""Data packs and functions, run by a small interpreter that keeps to the game's limits."""

from __future__ import annotations

import json
import re
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from sampling import one_in
from searching import many

from minecraft.builds import BUILDS, STATES, made, noise
from minecraft.oracle import Cell, of_build
from scenelang.backends.minecraft import build_files
from scenelang.backends.minecraft.blocks import Build
from scenelang.backends.minecraft.build_files import game_version
from scenelang.grammar.diagnostics import SceneError

MAX_FILL, MAX_COMMANDS = 32_768, 65_536
FILL = re.compile(r"fill ~(\S+) ~(\S+) ~(\S+) ~(\S+) ~(\S+) ~(\S+) (\S+?)( strict)?")
SETBLOCK = re.compile(r"setblock ~(\S+) ~(\S+) ~(\S+) (\S+?)( strict)?")
SUMMON = re.compile(r'summon minecraft:(?:marker|armor_stand) ~ ~ ~ \{Tags:\["([a-z0-9_.-]+)"\].*\}')
SCHEDULE = re.compile(r"schedule function (\S+) 1t")
EXECUTE = re.compile(r"execute at @e\[tag=([a-z0-9_.-]+),limit=1\] run function (\S+)")
KILL = re.compile(r"kill @e\[tag=([a-z0-9_.-]+)\]")
NOWHERE = None


@dataclass
class Game:
    """Functions by name, the cells that are laid, the markers that stand, and what the next tick runs."""

    functions: dict[str, list[str]]
    cells: dict[Cell, str] = field(default_factory=dict)
    markers: dict[str, Cell] = field(default_factory=dict)
    scheduled: list[str] = field(default_factory=list)
    run: int = 0

    def start(self, name: str, at: Cell) -> None:
        self.tick(name, at)
        while self.scheduled:
            names, self.scheduled = self.scheduled, []
            for name in names:
                self.tick(name, NOWHERE)

    def tick(self, name: str, at: Cell | None) -> None:
        self.run = 0
        self.function(name, at)

    def function(self, name: str, at: Cell | None) -> None:
        for line in self.functions[name]:
            self.run += 1
            assert self.run <= MAX_COMMANDS
            self.command(line, at)

    def command(self, line: str, at: Cell | None) -> None:
        if found := FILL.fullmatch(line):
            a, b = self.cell(found.groups()[:3], at), self.cell(found.groups()[3:6], at)
            sides = [high - low + 1 for low, high in zip(a, b)]
            assert min(sides) > 0
            assert int(np.prod(sides)) <= MAX_FILL
            for step in np.ndindex(*sides):
                x, y, z = (low + n for low, n in zip(a, step))
                self.lay((x, y, z), found[7])
        elif found := SETBLOCK.fullmatch(line):
            self.lay(self.cell(found.groups()[:3], at), found[4])
        elif found := SUMMON.fullmatch(line):
            assert at is not None
            self.markers[found[1]] = at
        elif found := KILL.fullmatch(line):
            self.markers.pop(found[1], None)
        elif found := SCHEDULE.fullmatch(line):
            self.scheduled.append(found[1])
        else:
            found = EXECUTE.fullmatch(line)
            assert found, line
            self.function(found[2], self.markers[found[1]])

    def lay(self, cell: Cell, state: str) -> None:
        assert cell not in self.cells
        self.cells[cell] = state

    @staticmethod
    def cell(words: tuple[str, ...], at: Cell | None) -> Cell:
        assert at is not None
        x, y, z = (int(word) + n for word, n in zip(words, at))
        return x, y, z


def game_of(path: Path) -> tuple[Game, dict[str, object]]:
    with zipfile.ZipFile(path) as pack:
        assert pack.testzip() is None
        about = json.loads(pack.read("pack.mcmeta"))["pack"]
        functions = {}
        for name in pack.namelist():
            if found := re.fullmatch(r"data/([a-z0-9_.-]+)/functions?/([a-z0-9_./-]+)\.mcfunction", name):
                functions[f"{found[1]}:{found[2]}"] = pack.read(name).decode("utf-8").splitlines()
        assert len(functions) == len(pack.namelist()) - 1
        return Game(functions), about


def laid_around(cells: dict[Cell, str], at: Cell) -> dict[Cell, str]:
    return {(x + at[0], y + at[1], z + at[2]): state for (x, y, z), state in cells.items()}


@settings(max_examples=many(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(build=BUILDS)
def test_a_pack_lays_the_build_around_the_player(tmp_path: Path, build: Build) -> None:
    build_files.write_datapack(build, tmp_path / "My House.zip", game_version())
    game, _ = game_of(tmp_path / "My House.zip")
    game.start("my_house:build", (1000, 64, -1000))
    assert game.cells == laid_around(of_build(build), (1000, 64, -1000))


@pytest.mark.parametrize("version", one_in(3, ["26.1", "1.20", "1.14"]))
def test_many_commands_are_laid_part_by_part(version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_files, "MAX_COMMANDS", build_files.MAX_COMMANDS // 8)
    monkeypatch.setitem(globals(), "MAX_COMMANDS", MAX_COMMANDS // 8)  # those of the game
    build = noise((28, 28, 28), 20)
    build_files.write_datapack(build, tmp_path / "a.zip", game_version(version))
    game, _ = game_of(tmp_path / "a.zip")
    assert sum(map(len, game.functions.values())) > 2 * build_files.MAX_COMMANDS
    game.start("a:build", (5, 6, 7))
    assert game.cells == laid_around(of_build(build), (5, 6, 7))
    assert not game.markers


@pytest.mark.slow
def test_before_functions_could_be_scheduled(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"1\.13\.2") as raised:
        build_files.write_datapack(noise((60, 60, 60), 3), tmp_path / "a.zip", game_version("1.13.2"))
    assert raised.value.name == "unsupported"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("shape", [(70, 70, 70), (40_000, 1, 2), (1, 2, 70_000), (3, 33_000, 1)])
@pytest.mark.sampled(2)
def test_large_cuboids_are_cut(shape: tuple[int, int, int], tmp_path: Path) -> None:
    build = made((-1, 0, 1), np.ones(shape), STATES)
    [path] = build_files.write_function(build, tmp_path / "a.mcfunction", game_version())
    lines = path.read_text("utf-8").splitlines()
    assert len(lines) <= 2 * build.cells.size // MAX_FILL + 2
    game = Game({"a": lines})
    game.start("a", (0, 0, 0))
    assert len(game.cells) == build.cells.size
    assert min(game.cells) == (-1, 0, 1)


@pytest.mark.slow
def test_one_function_runs_only_so_many(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="60,000") as raised:
        build_files.write_function(noise((60, 60, 60), 3), tmp_path / "a.mcfunction", game_version())
    assert raised.value.name == "unsupported"
    assert "zip" in str(raised.value.hint)


ABOUT = {
    "1.13": ({"pack_format": 4}, "functions", False), "1.20.4": ({"pack_format": 26}, "functions", False),
    "1.21": ({"pack_format": 48}, "function", False), "1.21.8": ({"pack_format": 81}, "function", True),
    "1.21.9": ({"min_format": [88, 0], "max_format": [88, 0]}, "function", True),
    "26.1": ({"min_format": [101, 1], "max_format": [101, 1]}, "function", True),
}  # fmt: skip


@pytest.mark.parametrize("version", ABOUT)
def test_what_versions_want(version: str, tmp_path: Path) -> None:
    expected, folder, is_strict = ABOUT[version]
    build_files.write_datapack(made((0, 0, 0), [[[1, 0, 1]]], STATES), tmp_path / "a.zip", game_version(version))
    game, about = game_of(tmp_path / "a.zip")
    assert {key: about[key] for key in about if key != "description"} == expected
    assert f"data/a/{folder}/build.mcfunction" in zipfile.ZipFile(tmp_path / "a.zip").namelist()
    assert all(line.endswith(" strict") == is_strict for line in game.functions["a:build"])


def test_torches_come_after_the_wall_that_they_hang_on(tmp_path: Path) -> None:
    names = [state.name for state in STATES]
    torch, stone = names.index("minecraft:torch") + 1, names.index("minecraft:stone") + 1
    build = made((0, 0, 0), [[[torch, stone], [torch, stone]]], STATES)
    build_files.write_function(build, tmp_path / "a.mcfunction", game_version())
    blocks = [line.split()[-2] for line in (tmp_path / "a.mcfunction").read_text("utf-8").splitlines()]
    assert blocks == ["minecraft:stone", "minecraft:torch"]
