"""What is handed out: the sdist and the wheel, built as `make wheel` does, looked into."""

from __future__ import annotations

import email
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = {
    "grammar": "scenelang/grammar",
    "interpreter": "scenelang/interpreter",
    "stdlib": "scenelang/stdlib",
    "backends": "scenelang/backends",
    "scenelang": "scenelang",
}
_LEFT_OUT = (
    ".git",
    ".venv",
    "node_modules",
    "build",
    "dist",
    "out",
    "__pycache__",
    "*.egg-info",
    ".*_cache",
    ".hypothesis",
)


@dataclass(frozen=True, slots=True)
class Built:
    """The files of the sdist, without its folder, and of the wheel that is built from it; the tree that it was made
    of."""

    sdist: dict[str, bytes]
    wheel: dict[str, bytes]
    tree: Path


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    folder = tmp_path_factory.mktemp("packaging")
    tree = folder / "tree"
    shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(*_LEFT_OUT))
    _build(tree, folder / "both")
    (sdist,) = (folder / "both").glob("*.tar.gz")
    (wheel,) = (folder / "both").glob("*.whl")
    return Built(_tar(sdist), _zip(wheel), tree)


def _build(tree: Path, to: Path, *options: str) -> None:
    command = [sys.executable, "-P", "-m", "build", "--no-isolation", "--outdir", str(to), *options, str(tree)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def _tar(path: Path) -> dict[str, bytes]:
    with tarfile.open(path) as archive:
        members = [
            (member.name.partition("/")[2], archive.extractfile(member)) for member in archive if member.isfile()
        ]
        return {name: file.read() for name, file in members if file is not None}


def _zip(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _sources(*endings: str) -> dict[str, bytes]:
    """The files of the rooms with these endings, by their names in the wheel."""
    found = {}
    for room, target in ROOMS.items():
        for path in (ROOT / room).rglob("*"):
            if path.suffix in endings and not {"source", "node_modules"} & set(path.parts):
                found[f"{target}/{path.relative_to(ROOT / room)}"] = path.read_bytes()
    return found


def test_the_wheel_has_every_module_and_data_file_and_no_other(built: Built) -> None:
    static = {
        f"scenelang/backends/{page}/static/{path.name}": path.read_bytes()
        for page in ("viewer", "deepslate")
        for path in (ROOT / f"backends/{page}/static").iterdir()
    }
    study = {
        f"scenelang/evaluation/study.{kind}": (ROOT / f"scenelang/evaluation/study.{kind}").read_bytes()
        for kind in ("js", "css")
    }
    fonts = {
        f"scenelang/interpreter/scene/modelling/fonts/{path.name}": path.read_bytes()
        for path in (ROOT / "interpreter/scene/modelling/fonts").iterdir()
    }
    examples = {f"scenelang/examples/{path.name}": path.read_bytes() for path in (ROOT / "examples").glob("*.scene")}
    examples |= {
        f"scenelang/examples/datasets/{path.name}": path.read_bytes()
        for path in (ROOT / "examples/datasets").glob("*.py")
    }
    examples |= {
        f"scenelang/examples/blender/{path.name}": path.read_bytes()
        for path in (ROOT / "examples/blender").glob("*.py")
    }
    wanted = (
        _sources(".py", ".lark", ".json", ".scene", ".toml", ".md", ".gz")
        | static
        | study
        | fonts
        | examples
        | {"scenelang/py.typed": b""}
    )
    inside = {name: text for name, text in built.wheel.items() if ".dist-info/" not in name}
    assert set(inside) == set(wanted)
    assert inside == wanted


def test_nothing_else_is_in_the_wheel(built: Built) -> None:
    assert {name.partition("/")[0].partition("-")[0] for name in built.wheel} == {"scenelang"}
    assert not [
        name for name in built.wheel if "node_modules" in name or Path(name).name.startswith(("test_", "conftest"))
    ]


@pytest.mark.slow
def test_the_sdist_builds_the_same_wheel(built: Built, tmp_path: Path) -> None:
    _build(built.tree, tmp_path, "--wheel")
    (direct,) = tmp_path.glob("*.whl")
    assert built.wheel == _zip(direct)


def test_the_sdist_has_what_people_and_builders_need(built: Built) -> None:
    wanted = {"LICENSE", "README.md", "Makefile", "constraints.txt", "pyproject.toml", "docs/tutorial.md",
              "docs/reference/combinators.md", "docs/reference/pictures/ring.png", "examples/chessboard.scene",
              "tests/test_packaging.py", "tests/bad/E101-end.scene", "backends/viewer/source/src/main.js",
              "backends/deepslate/source/src/main.js",
              "docs/generator/__main__.py", "editors/vscode/package.json"}  # fmt: skip
    assert wanted <= set(built.sdist)
    assert not [name for name in built.sdist if "node_modules" in name or name.endswith(".pyc")]
    for name in ("LICENSE", "grammar/core.lark"):
        assert built.sdist[name] == (ROOT / name).read_bytes()


def test_commands_and_backends_are_entry_points(built: Built) -> None:
    (name,) = (name for name in built.wheel if name.endswith("entry_points.txt"))
    text = built.wheel[name].decode()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    groups = {"console_scripts": project["scripts"], **project["entry-points"]}
    assert {"scenelang", "scene"} <= set(project["scripts"])
    for group, entries in groups.items():
        assert f"[{group}]" in text
        for entry, target in entries.items():
            assert f"{entry} = {target}" in text
            assert f"{target.partition(':')[0].replace('.', '/')}.py" in built.wheel


def test_the_metadata_tells_what_it_is(built: Built) -> None:
    (name,) = (name for name in built.wheel if name.endswith("METADATA"))
    metadata = email.message_from_bytes(built.wheel[name])
    assert metadata["Name"] == "scenelang"
    assert metadata["License-Expression"] == "MIT"
    assert metadata["Requires-Python"] == ">=3.11"
    assert "LICENSE" in metadata.get_all("License-File", [])
    assert "Typing :: Typed" in metadata.get_all("Classifier", [])
    assert metadata["Keywords"]
    assert {"usd", "video"} <= set(metadata.get_all("Provides-Extra", []))
    assert metadata["Description-Content-Type"] == "text/markdown"
    for licence in metadata.get_all("License-File", []):
        assert [entry for entry in built.wheel if entry.endswith(f"licenses/{licence}")]
