"""The core, without any extra: what it weighs, what it does, and what it says when an extra is missing."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib.metadata import Distribution, distribution, packages_distributions
from pathlib import Path

import pytest

packaging = pytest.importorskip("packaging.requirements")

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
ROOMS = ("grammar", "interpreter", "stdlib", "backends", "scenelang")
BUDGET = 150_000_000  # bytes
BYTECODE = 1.6  # bytes of bytecode for a byte of source, as measured in an installed copy (14.5 MB of 9.2)
SCENE = '(bind "pawns" (lambda () (union-loop 3 (lambda (i) (transform (call "sphere") (translate [i 0 0]))))))'


def closure(requirements: list[str]) -> dict[str, Distribution]:
    """The installed distributions that requirements bring, by name."""
    found: dict[str, Distribution] = {}
    waiting = [(line, "") for line in requirements]
    while waiting:
        line, extra = waiting.pop()
        requirement = packaging.Requirement(line)
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": extra}):
            continue
        each = distribution(requirement.name)
        if each.name not in found or requirement.extras:
            found[each.name] = each
            waiting += [(line, extra) for line in each.requires or () for extra in ("", *requirement.extras)]
    return found


def size_on_disk(each: Distribution) -> int:
    """The size of what a distribution installed, with bytecode where it was made."""
    paths = (Path(str(each.locate_file(file))) for file in each.files or ())
    return sum(path.stat().st_size for path in paths if path.is_file())


def own_files() -> Iterator[Path]:
    for room in ROOMS:
        for path in (ROOT / room).rglob("*"):
            if path.is_file() and not {"source", "node_modules", "__pycache__"} & set(path.parts):
                yield path


def test_the_core_stays_light() -> None:
    sizes = {name: size_on_disk(each) for name, each in closure(PROJECT["dependencies"]).items()}
    own = sum(path.stat().st_size * (1 + BYTECODE * (path.suffix == ".py")) for path in own_files())
    assert {"numpy", "pillow"} <= {name.lower() for name in sizes}
    assert min(sizes.values()) > 10_000
    assert sum(sizes.values()) + own < BUDGET, {**sizes, "scenelang": own}


def test_fixed_packages_are_declared() -> None:
    declared = {
        re.split(r"[<>=;\[ ]", line)[0]
        for lines in (PROJECT["dependencies"], *PROJECT["optional-dependencies"].values())
        for line in lines
    }
    assert {"lark", "numpy", "torch", "open-clip-torch", "diffusers", "trimesh", "anthropic", "mitsuba"} <= declared


def test_the_extra_all_has_what_users_can_ask_for() -> None:
    extras = PROJECT["optional-dependencies"]
    (everything,) = extras["all"]
    named = set(everything.partition("[")[2].rstrip("]").split(","))
    assert named == set(extras) - {"all", "dev", "blender", "site", "cuda"}


# --- what works, and what says what to install -----------------------------------------------------------------------


@cache
def hidden() -> str:
    """The modules of all distributions that are not the core's, joined by commas."""
    core = {name.lower() for name in closure(PROJECT["dependencies"])} | {"scenelang"}
    others = packages_distributions().items()
    return ",".join(name for name, owners in others if not {owner.lower() for owner in owners} & core)


def surroundings() -> dict[str, str]:
    """The environment of a process for which only the core is installed."""
    paths = [str(Path(__file__).parent / "blocked"), *filter(None, [os.environ.get("PYTHONPATH")])]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths), "SCENELANG_TEST_HIDDEN": hidden()}


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """``scenelang`` in such a process."""
    command = [sys.executable, "-P", "-m", "scenelang", *words]
    return subprocess.run(command, cwd=folder, env=surroundings(), capture_output=True, text=True)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "pawns.scene").write_text(SCENE)
    (tmp_path / "letters.scene").write_text('(bind "letters" (lambda () (text "ab" :depth 1)))')
    (tmp_path / "drawing.scene").write_text('(bind "bar" (lambda () (extrude (svg-path "M0 0 H4 V-2 H0 Z") 1)))')
    (tmp_path / "mesh.scene").write_text('(bind "chair" (lambda () (call "mesh" :file "a.ply")))')
    (tmp_path / "a.ply").write_text("ply\n")
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        ("check", "--run", "--geometry", "pawns.scene"),
        ("run", "pawns.scene"),
        ("export", "pawns.scene", "-o", "a.json"),
        ("export", "pawns.scene", "-o", "a.glb"),
        ("render", "pawns.scene", "-o", "a.png", "--quality", "draft", "--size", "32x24"),
        ("render", "pawns.scene", "-o", "a.gif", "--frames", "2", "--size", "32x24"),
    ],
    ids=" ".join,
)
def test_the_core_does_its_work_alone(words: tuple[str, ...], folder: Path) -> None:
    done = run(folder, *words)
    assert (done.returncode, done.stderr) == (0, "")
    if "-o" in words:
        assert (folder / words[words.index("-o") + 1]).stat().st_size > 100


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        (("render", "pawns.scene", "-o", "a.png", "--quality", "final", "--size", "32x24"), "final"),
        (("render", "pawns.scene", "-o", "a.exr", "--size", "32x24"), "final"),
        (("export", "pawns.scene", "-o", "a.xml"), "final"),
        (("run", "letters.scene"), "text"),
        (("run", "drawing.scene"), "text"),
        (("render", "mesh.scene", "-o", "a.png", "--size", "32x24"), "meshes"),
        (("render", "pawns.scene", "-o", "a.mp4", "--frames", "2", "--size", "32x24"), "video"),
        (("export", "pawns.scene", "-o", "a.usda"), "usd"),
        (("check", "--physics", "pawns.scene"), "physics"),
        (("lsp",), "lsp"),
        (("mcp",), "mcp"),
    ],
    ids=lambda each: each if isinstance(each, str) else each[0],
)
def test_what_is_missing_names_its_extra(words: tuple[str, ...], extra: str, folder: Path) -> None:
    done = run(folder, *words)
    assert done.returncode in (1, 2)
    assert f"install it with `pip install 'scenelang[{extra}]'`\n" in done.stderr
    assert extra in PROJECT["optional-dependencies"]
    assert "Traceback" not in done.stderr


def test_doctor_finds_nothing_broken_in_the_core(folder: Path) -> None:
    done = run(folder, "doctor")
    assert "All required features work." in done.stdout, done.stdout
    assert "  pip install 'scenelang[final]'\n" in done.stdout
    assert done.returncode == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_the_repl_in_a_terminal_works_without_its_extra(folder: Path) -> None:
    import pty

    ours, theirs = pty.openpty()
    os.write(ours, b"(+ 40 2)\n,quit\n")
    command = [sys.executable, "-P", "-m", "scenelang", "repl"]
    environment = surroundings() | {"TERM": "xterm"}
    done = subprocess.run(command, cwd=folder, env=environment, stdin=theirs, stdout=theirs, stderr=subprocess.PIPE)
    shown = os.read(ours, 10_000).decode()
    os.close(ours)
    os.close(theirs)
    assert (done.returncode, "\n42" in shown.replace("> ", "\n")) == (0, True), shown
    assert b"install them with `pip install 'scenelang[repl]'`\n" in done.stderr
