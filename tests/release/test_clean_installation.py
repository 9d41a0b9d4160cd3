"""The Dockerfile, and the light core on other Pythons, in environments that have nothing else."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
INSTRUCTIONS = re.findall(r"^([A-Z]+) (.*)$", (ROOT / "Dockerfile").read_text("utf-8"), re.M)


def values(instruction: str) -> list[str]:
    return [value for name, value in INSTRUCTIONS if name == instruction]


def copied(tree: Path) -> Path:
    """The files that the build of the image sees, by ``.dockerignore``: all but what it takes back are left out."""
    lines = (ROOT / ".dockerignore").read_text("utf-8").split()
    assert lines[0] == "*"
    for name in (line[1:] for line in lines if line.startswith("!")):
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, tree / name, ignore=shutil.ignore_patterns("node_modules", "__pycache__"))
        else:
            shutil.copy(source, tree / name)
    return tree


def test_the_image_runs_the_command_as_a_user_without_rights() -> None:
    assert values("FROM") == ["python:3.11-slim"]
    assert values("ENTRYPOINT") == ['["scenelang"]']
    (user,) = values("USER")
    assert int(user.partition(":")[0]) > 0
    assert [name for name, _ in INSTRUCTIONS].index("USER") > max(
        place for place, (name, _) in enumerate(INSTRUCTIONS) if name == "RUN"
    )


def test_the_image_has_path_tracing() -> None:
    assert any(".[final]" in line for line in values("RUN"))


@pytest.mark.slow
def test_the_commands_of_the_dockerfile_run(tmp_path: Path) -> None:
    """Those of apt and the paths of the image are left out; the environment stands for the image."""
    (tmp_path / "tree").mkdir()
    tree = copied(tmp_path / "tree")
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "image")], check=True)
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment |= {"PATH": f"{tmp_path}/image/bin:{os.environ['PATH']}", "HOME": str(tmp_path)}
    lines = [line for line in values("RUN") if not line.startswith("apt-get ")]
    assert len(lines) >= 2
    for line in lines:
        done = subprocess.run(line, shell=True, cwd=tree, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, f"{line}\n{done.stderr}"
    command = [str(tmp_path / "image/bin/scenelang"), "render", str(tree / "examples/moai.scene"), "-o", "moai.png"]
    options = ["--quality", "final", "--samples", "1", "--size", "16x12"]
    done = subprocess.run([*command, *options], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow
@pytest.mark.parametrize("version", ["3.11", "3.12", "3.13"])
def test_the_core_resolves_from_wheels(version: str, tmp_path: Path) -> None:
    """On Linux, for Pythons that need not be here: nothing has to be compiled."""
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    listed = text.partition("\ndependencies = [")[2].partition("\n]")[0]
    requirements = re.findall(r'^ +"([^"]+)"', listed, re.M)
    assert len(requirements) > 5
    options = ["--dry-run", "--quiet", "--target", str(tmp_path), "--python-version", version, "--only-binary=:all:"]
    command = [sys.executable, "-m", "pip", "install", *options, "-c", str(ROOT / "constraints.txt"), *requirements]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
