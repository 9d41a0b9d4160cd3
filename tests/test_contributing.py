"""The recipes of CONTRIBUTING.md, followed as they are written in a copy of the repository; the last one makes a package
that adds a primitive, a backend, a provider of language models and a quality of pictures."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("grammar", "interpreter", "stdlib", "backends", "scenelang")
TEXT = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
# The copy is imported even where the repository is installed in editable mode.
_START = (
    "import sys; sys.meta_path[:] = [f for f in sys.meta_path if 'editable' not in repr(f).lower()]; "
    "from scenelang.__main__ import entry; entry()"
)
_TABLES = (
    "import sys; sys.meta_path[:] = [f for f in sys.meta_path if 'editable' not in repr(f).lower()]; "
    "from pathlib import Path; from scenelang.stdlib import library; "
    "Path(library.__file__).with_name('builtin_names.py').write_text(library.index_text())"
)  # what `make tables` does for builtins
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
_TARGET = re.compile(r"[#;] (?:(append to|create) )?(\S+\.\w+)$")


@dataclass(frozen=True, slots=True)
class Recipe:
    """A section under "Recipes": its blocks with their languages, in order."""

    title: str
    blocks: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        return self.title


def _recipes() -> list[Recipe]:
    sections = re.split(r"^### ", TEXT.split("\n## Recipes\n")[1].split("\n## ")[0], flags=re.M)[1:]
    return [Recipe(section.split("\n", 1)[0], tuple(_BLOCK.findall(section))) for section in sections]


RECIPES = [recipe for recipe in _recipes() if recipe.blocks]


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("checkout")
    ignored = shutil.ignore_patterns("node_modules", "__pycache__", "source")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    return folder


def follow(checkout: Path, kind: str, block: str) -> None:
    """Do what a block of a recipe says."""
    if kind == "diff":
        _patch(checkout, block)
        return
    first, _, rest = block.partition("\n")
    match = _TARGET.match(first)
    assert match is not None, f"a block does not say where it goes: {first}"
    path = checkout / match[2]
    path.parent.mkdir(exist_ok=True)
    before = path.read_text("utf-8") + "\n\n" if match[1] == "append to" else ""
    assert match[1] == "append to" or not path.exists()
    path.write_text(before + rest, "utf-8")


def _patch(checkout: Path, diff: str) -> None:
    """Apply a diff whose hunks have context instead of line numbers, which must stand in the file once."""
    for part in re.split(r"^--- a/.*\n", diff, flags=re.M)[1:]:
        head, *hunks = part.split("@@\n")
        path = checkout / head.strip().removeprefix("+++ b/")
        for hunk in hunks:
            lines = hunk.splitlines()
            old = "".join(f"{line[1:]}\n" for line in lines if line[0] != "+")
            text = path.read_text("utf-8")
            assert text.count(old) == 1, f"{path} does not have once: {old}"
            path.write_text(text.replace(old, "".join(f"{line[1:]}\n" for line in lines if line[0] != "-")), "utf-8")


def run(checkout: Path, line: str) -> None:
    """Run a line of a shell block, and see that it says what its comment says."""
    command, _, expected = (part.strip() for part in line.partition("    # "))
    words = shlex.split(command)
    site = checkout / "site"
    if words[0] == "scenelang":
        words = [sys.executable, "-P", "-c", _START, *words[1:]]
    elif words == ["make", "tables"]:
        words = [sys.executable, "-P", "-c", _TABLES]
    elif words[0] == "python":
        words[0] = sys.executable
    elif words[:2] == ["pip", "install"]:
        words = [
            sys.executable,
            "-m",
            *words[:2],
            "-q",
            "--no-deps",
            "--no-build-isolation",
            "--target",
            str(site),
            words[2],
        ]
    path = os.pathsep.join([str(checkout), str(site)])
    environment = {**os.environ, "PYTHONPATH": path, "XDG_STATE_HOME": str(checkout / "state")}
    done = subprocess.run(words, cwd=checkout, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    if expected.startswith("{"):
        assert json.loads(done.stdout).items() >= json.loads(expected).items()
    else:
        assert expected in done.stdout + done.stderr, done.stdout + done.stderr


@pytest.mark.parametrize("recipe", RECIPES, ids=str)
@pytest.mark.sampled(3)
def test_a_recipe_works_as_it_is_written(checkout: Path, recipe: Recipe) -> None:
    for kind, block in recipe.blocks:
        if kind == "sh":
            for line in block.splitlines():
                run(checkout, line)
        else:
            follow(checkout, kind, block)


def test_the_package_of_the_recipe_added_all_four_kinds(checkout: Path) -> None:
    """After the recipe: the picture shows something, the model's program was taken, and what is not there is told."""
    if not (checkout / "perch.scene").exists():
        pytest.skip("the recipe did not run in this process")
    from PIL import Image

    assert Image.open(checkout / "ramp.png").size == (80, 60)
    assert len(Image.open(checkout / "ramp.png").convert("RGB").getcolors(10_000) or []) > 100
    assert (checkout / "ramp.xyz").read_text() == "0.0 0.0 0.0\n3.0 0.5 0.0\n"
    assert "wedge" in (checkout / "perch.scene").read_text()
    run(checkout, "scenelang backends    # where primitives are, as text")
    run(checkout, "scenelang check ramp.scene")


def test_every_recipe_is_tried() -> None:
    assert [recipe.title for recipe in RECIPES] == [
        "A builtin",
        "A lint",
        "A primitive",
        "A label",
        "A command",
        "A plug-in: primitive, backend, provider, quality",
    ]
    assert "### A diagnostic" in TEXT, "tests/test_bad.py holds every row of the table to what it says"
