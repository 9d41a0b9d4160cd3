"""The kernel imports no domain, a domain only those that it needs, and each can be deleted (docs/architecture.md)."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from datetime import date
from functools import cache
from pathlib import Path

import pytest
from test_structure import FACADE, FILES, ROOT, file_of, named_modules, reached_from

import scenelang

APPLICATIONS = FACADE | {"scenelang/cli", "scenelang/doctor"}
PACKAGE = Path(scenelang.__file__).parent
TODAY = date.today().toordinal()


@cache
def table() -> dict[str, tuple[tuple[str, ...], frozenset[str]]]:
    """The folders and the needs of each domain, from the table of the documentation."""
    text = (ROOT / "docs/architecture.md").read_text("utf-8")
    rows = re.findall(r"^\| ([^|]+) \| (`[^|]+`) \|([^|]*)\|$", text, re.M)
    return {
        name: (tuple(re.findall(r"`([^`]+)`", folders)), frozenset(filter(None, map(str.strip, needs.split(",")))))
        for name, folders, needs in rows
    }


def domain_of(path: Path) -> str | None:
    """The domain of a file; None in the kernel and in the applications."""
    name = path.relative_to(ROOT).as_posix()
    return next((d for d, (folders, _) in table().items() if name.startswith(tuple(f"{f}/" for f in folders))), None)


def is_application(path: Path) -> bool:
    return path.parent.relative_to(ROOT).as_posix() in APPLICATIONS


@cache
def imported_domains() -> dict[str | None, set[str]]:
    """The domains that each domain, and the kernel (None), imports at any place and for any reason."""
    result: dict[str | None, set[str]] = {None: set(), **{name: set() for name in table()}}
    for path in FILES:
        if not is_application(path):
            for module in named_modules(path):
                target = file_of(module) or file_of(module.rpartition(".")[0])
                other = domain_of(target) if target is not None else None
                if other is not None and other != domain_of(path):
                    result[domain_of(path)].add(other)
    return result


def test_the_table_names_folders_that_exist() -> None:
    assert len(table()) == 20
    assert all((ROOT / folder).is_dir() for folders, _ in table().values() for folder in folders)
    assert all(needs <= set(table()) for _, needs in table().values())


def test_the_kernel_imports_no_domain() -> None:
    assert imported_domains()[None] == set()


@pytest.mark.parametrize("name", table())
def test_a_domain_imports_what_it_needs(name: str) -> None:
    assert imported_domains()[name] == table()[name][1]


def test_needs_have_no_cycle() -> None:
    graph = {name: set(needs) for name, (_, needs) in table().items()}
    assert [name for name in graph if name in reached_from(name, graph)] == []


def test_applications_import_domains_inside_functions_only() -> None:
    """Otherwise a command would fail for want of a domain that it does not use."""
    code = (
        "import sys\n"
        "import scenelang.api, scenelang.cli.main, scenelang.cli.programs, scenelang.doctor.doctor\n"
        "print(*[name for name in sys.modules if name.startswith('scenelang.')])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    files = [file_of(name) for name in run.stdout.split()]
    assert len(files) > 50
    assert sorted({d for path in files if path is not None and (d := domain_of(path)) is not None}) == []
    assert sorted(path.stem for path in (ROOT / "scenelang").glob("*.py")) == ["__init__", "__main__", "api", "scene"]


BUDGETS = {  # a command, and the domains whose modules it may import
    "check": (["check", "examples/chessboard.scene"], set()),
    "run": (["run", "examples/chessboard.scene"], set()),
    "render": (["render", "examples/chessboard.scene", "-o", "OUT.png", "--size", "64x64"], {"pictures"}),
    "export": (["export", "examples/chessboard.scene", "-o", "OUT.glb"], {"exports"}),
    "stl": (["export", "examples/chessboard.scene", "-o", "OUT.stl"], {"exports"}),
}  # fmt: skip


@pytest.mark.parametrize("name", BUDGETS)
def test_a_command_imports_the_domains_that_it_uses(name: str, tmp_path: Path) -> None:
    words, allowed = BUDGETS[name]
    words = [str(tmp_path / word) if word.startswith("OUT") else word for word in words]
    code = (
        "import sys; from scenelang.cli.main import main\n"
        f"assert main({words!r}) == 0\n"
        "print('MODULES', *[name for name in sys.modules if name.startswith('scenelang.')])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    names = next(line for line in run.stdout.splitlines() if line.startswith("MODULES")).split()[1:]
    files = [path for name in names if (path := file_of(name)) is not None]
    assert {domain for path in files if (domain := domain_of(path)) is not None} == allowed
    assert len(files) < 140, len(files)  # 177 when every backend's module was imported for the options


def test_the_help_imports_nothing_but_the_table_of_commands() -> None:
    code = "import sys; from scenelang.cli.command_table import prints_help; prints_help([])\n"
    code += "print('MODULES', *[name for name in sys.modules if name.startswith('scenelang')])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "MODULES scenelang scenelang.cli scenelang.cli.command_table"


def test_the_help_is_that_of_the_parser(capsys: pytest.CaptureFixture[str]) -> None:
    from scenelang.cli.command_table import prints_help
    from scenelang.cli.main import build_parser

    assert prints_help(["--help"])
    assert capsys.readouterr().out == build_parser("").format_help()
    assert not prints_help(["--version"])


def test_descriptions_of_backends_are_up_to_date() -> None:
    """After a change of a backend: `make descriptions`."""
    from scenelang.backends.described_backends import current_descriptions

    saved = json.loads((PACKAGE / "backends/descriptions.json" if (PACKAGE / "backends").is_dir()
                        else ROOT / "backends/descriptions.json").read_text("utf-8"))  # fmt: skip
    assert saved == json.loads(json.dumps(current_descriptions()))


# --- deletion ---------------------------------------------------------------------------------------------------------


def dependents(name: str) -> set[str]:
    """A domain with all that need it."""
    users = {other: {name for name, (_, needs) in table().items() if other in needs} for other in table()}
    return {name} | reached_from(name, users)


def copy_without(name: str, target: Path) -> set[str]:
    """Copy the package without a domain and those that need it; return what was left out."""
    gone = dependents(name)
    for room in ("grammar", "interpreter", "stdlib", "backends", "examples"):
        source = PACKAGE / room if (PACKAGE / room).is_dir() else ROOT / room
        shutil.copytree(source, target / "scenelang" / room, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(
        PACKAGE, target / "scenelang", ignore=shutil.ignore_patterns("__pycache__", "grammar", "interpreter",
        "stdlib", "backends", "examples"), dirs_exist_ok=True,
    )  # fmt: skip
    for domain in gone:
        for folder in table()[domain][0]:
            shutil.rmtree(target / "scenelang" / folder.removeprefix("scenelang/"))
    return gone


PROGRAM = '(bind "dot"\n  (lambda ()\n    (union (call "sphere" :radius 2) (call "cube"))))\n'
USES = {  # a command of each domain, which ends with one line without it
    "pictures": ["render", "a.scene", "-o", "a.png", "--size", "16x16"],
    "exports": ["export", "a.scene", "-o", "a.glb"],
    "Mitsuba export": ["export", "a.scene", "-o", "a.xml"],
    "labels": ["maps", "a.scene", "-o", "maps", "--size", "16x16"],
    "viewer": ["view", "a.scene", "--html", "a.html"],
    "geometry checks": ["check", "--geometry", "a.scene"],
    "physics": ["check", "--physics", "a.scene"],
    "Minecraft": ["export", "a.scene", "-o", "a.schem", "--voxelize", "1"],
    "Minecraft pages": ["view", "a.scene", "--minecraft", "--html", "a.html"],
    "OpenSCAD": ["import", "a.scad"],
    "Python": ["transpile", "a.py"],
    "repair": ["repair", "a.scene"],
    "neural": ["embeddings", "a.scene", "list"],
    "datasets": ["dataset", "status", "folder"],
    "inference": ["runs"],
    "bench": ["bench", "--list"],
    "REPL": ["repl"],
    "LSP": ["lsp"],
    "MCP": ["mcp"],
}
NOT_RUN = {"REPL", "LSP", "MCP", "datasets", "Minecraft pages"}  # they wait for input, or need files of others
KERNEL = [["backends"], ["check", "a.scene"], ["run", "a.scene"], ["flatten", "a.scene"], ["--help"], ["fmt", "--check", "a.scene"],
          ["explain", "E201"], ["check", "--run", "a.scene"], ["tree", "a.scene"], ["measure", "a.scene"], ["expand", "a.scene"]]  # fmt: skip


# An editable installation finds the packages of the checkout whatever the path is.
NO_CHECKOUT = """import sys
sys.meta_path = [f for f in sys.meta_path if "editable" not in f"{getattr(f, '__module__', '')}{f}".lower()]
"""


def command(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line of the package in a folder; ours is not on the path of its interpreter."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(folder),
        "HOME": str(folder),
        "XDG_STATE_HOME": str(folder / "state"),
    }
    code = "from scenelang.__main__ import entry; import sys; sys.exit(entry())"
    return subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, cwd=folder, env=environment,
        stdin=subprocess.DEVNULL, timeout=120,
    )  # fmt: skip


def check_deletion(name: str, folder: Path) -> None:
    gone = copy_without(name, folder)
    (folder / "sitecustomize.py").write_text(NO_CHECKOUT, "utf-8")
    (folder / "a.scene").write_text(PROGRAM, "utf-8")
    (folder / "a.py").write_text(
        "from helper import *\n@register()\ndef dot():\n    return primitive_call('cube', shape_kwargs={'scale': 1})\n",
        "utf-8",
    )
    (folder / "wrong.scene").write_text(PROGRAM.replace(":radius 2", ":radius (ref (list 1) 1)"), "utf-8")
    (folder / "a.scad").write_text("cube(2);\n", "utf-8")
    for words in KERNEL:
        run = command(words, folder)
        assert (run.returncode, run.stderr) == (0, ""), (words, run.stderr)
    wrong = command(["check", "--run", "--json", "wrong.scene"], folder)  # fixes are tried where the domain is there
    assert (wrong.returncode, [d["code"] for d in json.loads(wrong.stdout)]) == (1, ["E405"]), wrong.stdout
    python = "import scenelang as sl; s = sl.evaluate(open('a.scene').read()); print(len(s.flatten()), s.measure().volume > 1)"
    script = subprocess.run([sys.executable, "-c", python], capture_output=True, text=True, cwd=folder,
                            env={**os.environ, "PYTHONPATH": str(folder)})  # fmt: skip
    assert (script.stdout, script.stderr) == ("2 True\n", "")
    used = [name] if name in USES else []
    for domain in used:
        run = command(USES[domain], folder)
        lines = run.stderr.strip().splitlines()
        assert run.returncode in (1, 2), (domain, run.stdout, run.stderr)  # 2: the name of a format is an argument
        assert "Traceback" not in run.stderr
        assert "internal error" not in run.stderr, run.stderr
        assert 1 <= len(lines) <= 3, run.stderr
    for domain in sorted(set(USES) - gone - NOT_RUN):
        run = command(USES[domain], folder)
        assert run.returncode == 0, (domain, run.stderr)
    doctor = command(["doctor", "--json"], folder)
    assert doctor.returncode in (0, 1)
    assert "Traceback" not in doctor.stderr


@pytest.mark.parametrize("name", sorted(table())[TODAY % 2 :: 2][TODAY // 2 % 9 :][:2])
def test_a_domain_can_be_deleted(name: str, tmp_path: Path) -> None:
    check_deletion(name, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(table()))
def test_every_domain_can_be_deleted(name: str, tmp_path: Path) -> None:
    check_deletion(name, tmp_path)


def test_files_that_can_be_imported_are_those_of_the_importers() -> None:
    from scenelang.backends.minecraft.export import ENDINGS
    from scenelang.session.session import IMPORTED_ENDINGS

    assert set(IMPORTED_ENDINGS) == {".scad", *ENDINGS}
