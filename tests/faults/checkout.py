"""A commit in a folder of its own with an interpreter that imports it, so that faults never touch the working tree."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path

from faults.runner import MARKERS

ROOT = Path(__file__).parents[2]
TESTS = Path(__file__).parents[1]
# The packages of this environment, behind the checkout's own: an installed scenelang must not be found first.
_LINK = """import sys; sys.path.append({packages!r}); found = [x for x in sys.meta_path if "editable" in repr(x).lower()]; \
[sys.meta_path.remove(x) or sys.meta_path.insert(0, x) for x in found]
"""


@dataclass(frozen=True, slots=True)
class Checkout:
    folder: Path

    @property
    def tree(self) -> Path:
        return self.folder / "tree"

    @property
    def python(self) -> Path:
        return self.folder / "venv" / "bin" / "python"

    @property
    def results(self) -> Path:
        return self.folder / "results.jsonl"

    def run(self, *words: str, **variables: str) -> int:
        """A command of the interpreter in the checkout, on one core."""
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **variables}
        return subprocess.run([self.python, "-P", *words], cwd=self.tree, env=environment).returncode


def checkout(folder: Path, commit: str = "HEAD") -> Checkout:
    """``commit`` under ``folder``; what is there of the same commit is used again."""
    found = subprocess.run(
        ["git", "rev-parse", "--short", commit], cwd=ROOT, capture_output=True, text=True, check=True
    )
    made = Checkout((folder / found.stdout.strip()).resolve())
    if not made.python.exists():
        made.folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "clone", "--quiet", "--shared", ROOT, made.tree], check=True)
        subprocess.run(["git", "checkout", "--quiet", found.stdout.strip()], cwd=made.tree, check=True)
        _install(made)
    return made


def _install(made: Checkout) -> None:
    venv.create(made.folder / "venv", with_pip=False)
    site = sysconfig.get_path("purelib", vars={"base": str(made.folder / "venv")})
    link = _LINK.format(packages=sysconfig.get_path("purelib"))
    (Path(site) / "zz_packages.pth").write_text(link)
    pip = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--editable", "."]
    if made.run(*pip):
        raise SystemExit("the checkout could not be installed")


def probe(made: Checkout) -> None:
    """Run the suite once with probes, which says what reaches what: as long as the suite takes on one core."""
    if (made.folder / "names.json").is_file():
        return
    hook = str(Path(__file__).with_name("hook"))
    places = {"PYTHONPATH": hook, "FAULT_PROBE": str(made.folder), "FAULT_TREE": str(made.tree)}
    made.run("-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "fault_probe", "--tb=no", "-m", MARKERS, **places)


def plant(made: Checkout, records: Path) -> None:
    """Run the tests of each fault that has no result yet."""
    start = (
        f"import sys; sys.path.append({str(TESTS)!r}); from faults.runner import main; sys.exit(main(*sys.argv[1:]))"
    )
    words = [str(each) for each in (made.tree, made.folder, records, made.results)]
    if made.run("-c", start, *words):
        print(f"the run ended early; start again to go on from {made.results}", file=sys.stderr)
