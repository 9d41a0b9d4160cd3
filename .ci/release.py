"""``make release``: builds the sdist and the wheel, checks them in a clean environment, and says what is left to do.

The README's pictures and links are relative, for readers of the repository. A package index has no files beside it, so
they become absolute in a copy of the tree, and only the copy is built. The address is that of ``.ci/repository``.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
_LINK = re.compile(r"(?P<picture>!?)\[(?P<text>[^\]]*)\]\((?P<path>(?!https?:|#|mailto:)[^)\s]+)\)")
_URLS = "[project.urls]\n"


# --- the copy that is built ------------------------------------------------------------------------------------------


def repository_of(text: str) -> str:
    """Return the address in the text of ``.ci/repository``, or "" if it names none yet."""
    lines = (line.strip().rstrip("/") for line in text.splitlines())
    return next((line for line in lines if line and not line.startswith("#")), "")


def absolute_links(text: str, repository: str, version: str) -> str:
    """Return Markdown whose relative pictures and links lead to the files of a release in the repository."""

    def absolute(link: re.Match[str]) -> str:
        kind = "raw" if link["picture"] else "blob"
        return f"{link['picture']}[{link['text']}]({repository}/{kind}/v{version}/{link['path']})"

    # A picture inside a link is none of ours; the pattern would need nesting for it.
    return _LINK.sub(absolute, text)


def with_urls(project: str, repository: str) -> str:
    """Return the text of ``pyproject.toml`` with the addresses that follow from that of the repository."""
    added = {"Repository": "", "Issues": "/issues", "Changelog": "/blob/main/CHANGELOG.md"}
    lines = "".join(f'{name} = "{repository}{path}"\n' for name, path in added.items())
    return project.replace(_URLS, _URLS + lines)


def staged(folder: Path, version: str) -> Path:
    """Copy the files that git tracks into a folder, as they are released."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout  # noqa: S607
    for name in filter(None, listed.split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    repository = repository_of((ROOT / ".ci/repository").read_text("utf-8"))
    if repository:
        _rewrite(folder / "README.md", absolute_links((ROOT / "README.md").read_text("utf-8"), repository, version))
        _rewrite(folder / "pyproject.toml", with_urls((ROOT / "pyproject.toml").read_text("utf-8"), repository))
    return folder


def _rewrite(path: Path, text: str) -> None:
    path.write_text(text, "utf-8")


# --- what is checked -------------------------------------------------------------------------------------------------


def unready(version: str) -> list[str]:
    """Return what speaks against a release of the tree as it is, a line each."""
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    newest = re.search(r"^## \[(\d[^\]]*)\]", changelog, re.M)
    unreleased = changelog.partition("## [Unreleased]")[2].partition("\n## [")[0].strip()
    changed = subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, text=True).stdout  # noqa: S607
    reasons = {
        f"CHANGELOG.md has no section [{version}] at its head": newest is None or newest[1] != version,
        "CHANGELOG.md has entries under [Unreleased]: move them into the section of a version": bool(unreleased),
        "there are changes that are not committed": bool(changed.strip()),
        ".ci/repository names no address: the README's pictures would be missing on a package index": not repository_of(
            (ROOT / ".ci/repository").read_text("utf-8")
        ),
    }
    return [reason for reason, holds in reasons.items() if holds]


def built(version: str) -> list[Path]:
    """Build the sdist, and the wheel from it, into ``dist``; returns the files."""
    shutil.rmtree(DIST, ignore_errors=True)
    with tempfile.TemporaryDirectory() as folder:
        _run(sys.executable, "-m", "build", "--outdir", str(DIST), str(staged(Path(folder), version)))
    files = sorted(DIST.iterdir())
    _run(sys.executable, "-m", "twine", "check", "--strict", *map(str, files))
    return files


def try_out(wheel: Path) -> None:
    """Install a wheel into a clean environment, and run the first commands of a user there."""
    with tempfile.TemporaryDirectory() as folder:
        _run(sys.executable, "-m", "venv", folder)
        constraints = str(ROOT / "constraints.txt")
        _run(f"{folder}/bin/pip", "install", "--quiet", "--disable-pip-version-check", "-c", constraints, str(wheel))
        command = f"{folder}/bin/scenelang"
        _run(command, "doctor", cwd=folder)
        picture = ("render", str(ROOT / "examples/chessboard.scene"), "-o", "first.png", "--quality", "draft")
        _run(command, *picture, cwd=folder)
        print(f"the first picture has {(Path(folder) / 'first.png').stat().st_size:,} bytes")


def _run(*command: str, cwd: str | None = None) -> None:
    """Run a command, without this process's own paths of modules; ends this process if it fails."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    print("$", *command, flush=True)
    if subprocess.run(command, cwd=cwd, env=environment).returncode != 0:  # noqa: S603  # words of this file, no shell
        sys.exit(f"failed: {' '.join(command)}")


def next_steps(version: str, files: Sequence[Path], reasons: Sequence[str]) -> str:
    """Return what a maintainer does now, as text; ``reasons`` speak against publication."""
    before = "".join(f"  - {reason}\n" for reason in reasons)
    shown = " ".join(f"dist/{file.name}" for file in files)
    return (
        "Built and checked.\n"
        + (f"Before it can be published:\n{before}Then:\n" if reasons else "What is left:\n")
        + f"  git tag -a v{version} -m 'scenelang {version}' && git push origin v{version}\n"
        f"  {Path(sys.executable).parent}/twine upload {shown}\n"
        "  the release's page: its section of CHANGELOG.md\n"
        '  the extension of VS Code: editors/vscode/README.md, "Publishing it"\n'
    )


def main() -> int:
    """Build, check and report."""
    version = str(tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"])
    files = built(version)
    try_out(next(file for file in files if file.suffix == ".whl"))
    print(next_steps(version, files, unready(version)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
