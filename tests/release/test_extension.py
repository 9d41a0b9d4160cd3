"""The manifest of the extension for VS Code: all that the marketplace asks for, and files that exist."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[2] / "editors/vscode"
MANIFEST: dict[str, Any] = json.loads((FOLDER / "package.json").read_text("utf-8"))


def included() -> set[str]:
    """The patterns that ``.vscodeignore`` takes back, which leaves out everything else."""
    lines = (FOLDER / ".vscodeignore").read_text("utf-8").split()
    assert lines[0] == "**"
    return {line.removeprefix("!").removesuffix("/**") for line in lines[1:]}


def test_the_manifest_has_what_the_marketplace_asks_for() -> None:
    fields = {"name", "displayName", "description", "version", "publisher", "license", "engines", "categories", "icon"}
    assert fields <= {name for name, value in MANIFEST.items() if value}
    assert re.fullmatch(r"[a-z0-9][a-z0-9-]*", MANIFEST["name"])
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9-]*", MANIFEST["publisher"])
    assert re.fullmatch(r"\d+\.\d+\.\d+", MANIFEST["version"])
    assert len(MANIFEST["keywords"]) <= 30


def test_files_of_the_manifest_exist_and_are_packaged() -> None:
    contributed = MANIFEST["contributes"]
    named = [each["path"] for kind in ("grammars", "snippets") for each in contributed[kind]]
    named += [each["configuration"] for each in contributed["languages"]]
    for path in (
        MANIFEST["icon"],
        "README.md",
        "CHANGELOG.md",
        "LICENSE",
        *(name.removeprefix("./") for name in named),
    ):
        assert (FOLDER / path).is_file(), path
        assert {path, path.partition("/")[0]} & included(), path


def test_the_icon_is_a_square_of_enough_pixels() -> None:
    data = (FOLDER / MANIFEST["icon"]).read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", data[16:24])
    assert width == height >= 128


def test_commands_of_menus_are_declared() -> None:
    declared = {each["command"] for each in MANIFEST["contributes"]["commands"]}
    used = {each["command"] for menu in MANIFEST["contributes"]["menus"].values() for each in menu}
    source = (FOLDER / "src/extension.js").read_text("utf-8")
    assert used <= declared
    assert [command for command in declared if command not in source] == []


@pytest.mark.parametrize("name", ["build", "package", "publish"])
def test_scripts_that_the_readme_names_exist(name: str) -> None:
    assert name in MANIFEST["scripts"]
    if name != "build":
        assert f"npm run {name}" in (FOLDER / "README.md").read_text("utf-8")
    assert set(re.findall(r"npm run ([\w:]+)", (FOLDER / "README.md").read_text("utf-8"))) <= set(MANIFEST["scripts"])


def test_the_changelog_has_the_version() -> None:
    assert f"\n## {MANIFEST['version']}\n" in (FOLDER / "CHANGELOG.md").read_text("utf-8")
