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
from scenelang.cli.command_table import COMMANDS
from scenelang.grammar.domains import DOMAINS, domain_of_module

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
    assert len(table()) == 22
    assert all((ROOT / folder).is_dir() for folders, _ in table().values() for folder in folders)
    assert all(needs <= set(table()) for _, needs in table().values())


def test_messages_call_domains_as_the_table_does() -> None:
    assert {folder: name for name, (folders, _) in table().items() for folder in folders} == DOMAINS
    assert domain_of_module("scenelang.interpreter.lift.simplify") == "Python"
    assert domain_of_module("scenelang.mcp") == "MCP"
    assert domain_of_module("scenelang.session.session") is None
    assert domain_of_module("numpy") is None


def test_the_kernel_imports_no_domain() -> None:
    assert imported_domains()[None] == set()


@pytest.mark.parametrize("name", table())
def test_a_domain_imports_what_it_needs(name: str) -> None:
    assert imported_domains()[name] == table()[name][1]


def test_needs_have_no_cycle() -> None:
    graph = {name: set(needs) for name, (_, needs) in table().items()}
    assert [name for name in graph if name in reached_from(name, graph)] == []


COMMANDS_OF = {  # modules of commands that all belong to one domain, which import it and what it needs when they are loaded
    "scenelang.cli.pictures": "pictures",
    "scenelang.cli.models": "inference",
    "scenelang.cli.bench": "bench",
    "scenelang.cli.neural": "neural",
    "scenelang.cli.embed_eval": "neural",
}
APPLICATION_MODULES = sorted(
    ".".join(("scenelang", *path.with_suffix("").relative_to(ROOT / "scenelang").parts))
    for path in FILES
    if is_application(path) and path.name not in ("__init__.py", "__main__.py")
)


@pytest.mark.parametrize("module", APPLICATION_MODULES)
def test_applications_import_domains_inside_functions_only(module: str) -> None:
    """Otherwise a command would fail for want of a domain that it does not use."""
    code = f"import sys, {module}; print(*[name for name in sys.modules if name.startswith('scenelang.')])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    files = [path for name in run.stdout.split() if (path := file_of(name)) is not None]
    own = COMMANDS_OF.get(module)
    needs = {name: set(needs) for name, (_, needs) in table().items()}
    allowed = set() if own is None else {own} | reached_from(own, needs)
    assert len(files) > 1
    assert {domain for path in files if (domain := domain_of(path)) is not None} <= allowed


def test_commands_of_a_domain_are_in_modules_of_their_own() -> None:
    """A command whose module imports a domain needs the domain."""
    assert set(COMMANDS_OF) <= set(APPLICATION_MODULES)
    for name, row in COMMANDS.items():
        own = COMMANDS_OF.get(f"scenelang.cli.{row.module}")
        assert own is None or NEEDED_BY[name] in dependents(own), name
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
    assert len(files) < 153, len(files)  # 177 when every backend's module was imported for the options


def test_the_help_imports_nothing_but_the_table_of_commands() -> None:
    code = "import sys; from scenelang.cli.command_table import prints_help; prints_help([])\n"
    code += "print('MODULES', *[name for name in sys.modules if name.startswith('scenelang')])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "MODULES scenelang scenelang.cli scenelang.cli.command_table"


def test_the_help_of_model_commands_imports_no_checks_of_geometry() -> None:
    code = (
        "import sys; from scenelang.cli.main import main\n"
        "try:\n    main(['generate', '--help'])\nexcept SystemExit:\n    pass\n"
        "print('MODULES', *[name for name in sys.modules if name.startswith('scenelang.backends.')])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    names = run.stdout.splitlines()[-1].split()[1:]
    assert names
    assert [name for name in names if domain_of_module(name) in ("geometry checks", "pictures")] == []


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
BLOCKS = '(bind "wall" (lambda () (call "set-cuboid" :block-type "stone" :scale [3 1 2])))\n'
STUDY = json.dumps({
    "format": "scenelang-study-answers", "version": 1, "study": "s", "participant": "p",
    "answers": [{"prompt": "a dot", "methods": ["a", "b"], "choice": "a"}],
})  # fmt: skip
USES = {  # commands of each domain, which end with one line without it
    "pictures": [["render", "a.scene", "-o", "a.png", "--size", "16x16"], ["graph", "a.scene", "-o", "a.svg"]],
    "exports": [["export", "a.scene", "-o", "a.glb"], ["export", "a.scene", "-o", "a.stl"]],
    "Mitsuba export": [["export", "a.scene", "-o", "a.xml"]],
    "labels": [["labels", "a.scene", "-o", "maps", "--size", "16x16"]],
    "viewer": [["view", "a.scene", "--html", "a.html"]],
    "geometry checks": [["check", "--geometry", "a.scene"]],
    "physics": [["check", "--physics", "a.scene"], ["settle", "a.scene", "-o", "settled.json"]],
    "Minecraft": [["export", "a.scene", "-o", "a.schem", "--voxelize", "1"]],
    "Minecraft pages": [["view", "a.scene", "--minecraft", "--html", "a.html"]],
    "OpenSCAD": [["import", "a.scad"]],
    "Blender": [["import", "b.py"], ["run", "b.py"], ["export", "a.scene", "-o", "b2.py", "--to", "bpy"]],
    "Python": [["transpile", "a.py"], ["simplify", "a.scene"]],
    "repair": [["repair", "a.scene", "--only-declarations"]],
    "neural": [
        ["embeddings", "a.scene", "list"],
        ["embed", "a.scene", "--print"],
        ["eval", "--study-results", "study.json"],
    ],
    "datasets": [["dataset", "status", "folder"]],
    "inference": [["runs"]],
    "bench": [["bench", "--list"]],
    "REPL": [["repl"]],
    "LSP": [["lsp"]],
    "MCP": [["mcp"]],
}
USES_OF_BLOCKS = {  # commands of scenes with blocks, which need Minecraft and one more domain
    "pictures": ["render", "blocks.scene", "-o", "blocks.png", "--size", "16x16"],
    "exports": ["export", "blocks.scene", "-o", "blocks.glb"],
}
NEEDED_BY = {  # the domain of each command that the kernel alone cannot do; its help may need the domain too
    "transpile": "Python", "lift": "Python", "repl": "REPL", "lsp": "LSP", "mcp": "MCP",
    "render": "pictures", "sheet": "pictures", "graph": "pictures", "view": "viewer", "studio": "viewer", "labels": "labels", "dataset": "datasets",
    "simulate": "physics", "settle": "physics", "repair": "repair",
    "generate": "inference", "build": "inference", "edit": "inference", "runs": "inference", "bench": "bench",
    "embeddings": "neural", "embed": "neural", "imagine": "neural", "invert": "neural", "style": "neural",
    "distill": "neural", "eval": "neural",
}  # fmt: skip
METHODS = {  # uses of the Python API, and their domains
    "s.render(size=(16, 16))": "pictures", "s.film(frames=1, size=(16, 16)).save('a.gif')": "pictures",
    "s.save_graph('b.svg')": "pictures", "s.maps(size=(16, 16))": "labels", "s.html()": "viewer", "s.show()": "viewer",
    "s.export('b.glb')": "exports", "s.export('b.json')": None, "s._repr_png_()": None,
    "s.relations()": "geometry checks", "s.violations('(count \"dot\" 1)')": "geometry checks", "s.physics()": "physics",
    "sl.repair(open('a.scene').read())": "repair", "sl.transpile(open('a.py').read())": "Python",
    "sl.Embeddings.of(s)": "neural", "sl.runs()": "inference", "sl.BenchReport": "bench", "sl.DatasetReport": "datasets",
}  # fmt: skip
NOT_RUN = {"REPL", "LSP", "MCP", "datasets", "Minecraft pages"}  # they wait for input, or need files of others
KERNEL = [["backends"], ["check", "a.scene"], ["run", "a.scene"], ["flatten", "a.scene"], ["--help"], ["fmt", "--check", "a.scene"],
          ["explain", "E201"], ["check", "--run", "a.scene"], ["tree", "a.scene"], ["measure", "a.scene"], ["expand", "a.scene"]]  # fmt: skip


# An editable installation finds the packages of the checkout whatever the path is.
NO_CHECKOUT = """import sys
sys.meta_path = [f for f in sys.meta_path if "editable" not in f"{getattr(f, '__module__', '')}{f}".lower()]
"""


HELP = """import contextlib, io, json
from scenelang.cli.command_table import COMMANDS
from scenelang.cli.main import main
told = {}
for name in COMMANDS:
    out, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            code = main([name, "--help"])
        except SystemExit as end:
            code = end.code
    told[name] = code, errors.getvalue()
print(json.dumps(told))
"""
API = """import json
import scenelang as sl
s = sl.evaluate(open("a.scene").read())
told = {}
for text in TEXTS:
    try:
        eval(text)
        told[text] = ""
    except sl.SceneError as error:
        told[text] = error.diagnostic.code
print(json.dumps(told))
"""


def python(code: str, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a script with the package of a folder; ours is not on the path of its interpreter."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(folder),
        "HOME": str(folder),
        "XDG_STATE_HOME": str(folder / "state"),
        "PYTHONDONTWRITEBYTECODE": "",  # each command would compile the copy again
    }
    return subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, cwd=folder, env=environment,
        stdin=subprocess.DEVNULL, timeout=120,
    )  # fmt: skip


def command(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line of the package in a folder."""
    return python("from scenelang.__main__ import entry; import sys; sys.exit(entry())", folder, *words)


COMMANDS_OF_ONE_PROCESS = """import contextlib, io, json, sys
from scenelang.cli.main import main
told = []
for words in json.loads(sys.argv[1]):
    out, errors = io.TextIOWrapper(io.BytesIO(), "utf-8"), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            code = main(words)
        except SystemExit as end:
            code = end.code
        out.flush()
    told.append((words, code, out.buffer.getvalue().decode(), errors.getvalue()))
print(json.dumps(told))
"""


def commands(listed: list[list[str]], folder: Path, *, apart: bool) -> list[subprocess.CompletedProcess[str]]:
    """Run commands of the package in a folder: in processes of their own, or in one, since to start takes most of the
    time; there an import of an earlier command may stand in for one that a later command lacks."""
    if apart:
        return [command(words, folder) for words in listed]
    run = python(COMMANDS_OF_ONE_PROCESS, folder, json.dumps(listed))
    assert run.returncode == 0, run.stderr
    return [subprocess.CompletedProcess(*told) for told in json.loads(run.stdout)]


def check_deletion(name: str, folder: Path, most: int | None = None) -> None:
    """Check an installation without a domain: at most ``most`` commands of each domain that remains, in one process, or
    all in processes of their own."""
    apart = most is None
    gone = copy_without(name, folder)
    (folder / "sitecustomize.py").write_text(NO_CHECKOUT, "utf-8")
    (folder / "a.scene").write_text(PROGRAM, "utf-8")
    (folder / "a.py").write_text(
        "from helper import *\n@register()\ndef dot():\n    return primitive_call('cube', shape_kwargs={'scale': 1})\n",
        "utf-8",
    )
    (folder / "wrong.scene").write_text(PROGRAM.replace(":radius 2", ":radius (ref (list 1) 1)"), "utf-8")
    (folder / "blocks.scene").write_text(BLOCKS, "utf-8")
    (folder / "a.scad").write_text("cube(2);\n", "utf-8")
    (folder / "b.py").write_text("import bpy\nbpy.ops.mesh.primitive_cube_add()\n", "utf-8")
    (folder / "study.json").write_text(STUDY, "utf-8")
    for run in [command(["run", "a.scene"], folder), *commands(KERNEL, folder, apart=apart)]:
        assert (run.returncode, run.stderr) == (0, ""), (run.args, run.stderr)
    wrong = command(["check", "--run", "--json", "wrong.scene"], folder)  # fixes are tried where the domain is there
    assert (wrong.returncode, [d["code"] for d in json.loads(wrong.stdout)]) == (1, ["E405"]), wrong.stdout
    script = python(
        "import scenelang as sl; s = sl.load('a.scene'); print(len(s.flatten()), s.measure().volume > 1)", folder
    )
    assert (script.stdout, script.stderr) == ("2 True\n", "")
    check_what_is_gone(gone, folder, apart=apart)
    left = [words for domain in sorted(set(USES) - gone - NOT_RUN) for words in USES[domain][:most]]
    for run in commands(left, folder, apart=apart):
        assert run.returncode == 0, (run.args, run.stderr)
    check_help(gone, folder)
    check_api(gone, folder)
    listed = json.loads(command(["backends", "--json"], folder).stdout)
    described = json.loads((folder / "scenelang/backends/descriptions.json").read_text("utf-8"))
    modules = {data["name"]: value.partition(":")[0].replace(".", "/") for value, data in described.items()}
    for backend in listed:
        path = folder / f"{modules[backend['name']]}.py"
        if not path.is_file():
            assert (backend["installed"], backend["install"]) == (False, "--force-reinstall scenelang"), backend["name"]
    doctor = command(["doctor", "--json"], folder)
    assert doctor.returncode in (0, 1)
    assert "Traceback" not in doctor.stderr


def check_what_is_gone(gone: set[str], folder: Path, *, apart: bool) -> None:
    """Commands of domains that are gone, dependents included, end with one line that names the domain, and a hint."""
    uses = [words for domain in sorted(gone) for words in USES.get(domain, ())]
    if "Minecraft" in gone:
        uses += [words for domain, words in USES_OF_BLOCKS.items() if domain not in gone]
    for run in commands(uses, folder, apart=apart):
        lacks = re.fullmatch(
            r"error\[E705\]: this installation lacks the part (.+), which is needed here \(`scenelang\.[\w.]+`\)\n"
            r" *hint: reinstall it: `pip install --force-reinstall scenelang`",
            run.stderr.strip(),
        )
        assert lacks is not None, (run.args, run.stdout, run.stderr)
        assert lacks[1] in gone, (run.args, run.stderr)
        assert run.returncode == 1, run.args


def check_help(gone: set[str], folder: Path) -> None:
    """The help of every command that remains works; that of the others does, or names what is missing."""
    told = json.loads(python(HELP, folder).stdout)
    assert set(told) == set(COMMANDS)
    for name, (code, errors) in told.items():
        if NEEDED_BY.get(name) not in gone:
            assert (code, errors) == (0, ""), (name, errors)
        else:
            assert (code, errors) == (0, "") or (
                code == 1 and errors.startswith("error[E705]: this installation lacks the part ")
            )


def check_api(gone: set[str], folder: Path) -> None:
    """What is gone of the Python API is an error of it; all else works, and so does an import of all names."""
    run = python(f"TEXTS = {list(METHODS)!r}\n{API}", folder)
    assert run.stderr == ""
    for text, code in json.loads(run.stdout).items():
        assert code == ("E705" if METHODS[text] in gone else ""), (text, code)
    run = python("from scenelang import *; print(evaluate(open('a.scene').read()).word)", folder)
    assert (run.stdout, run.stderr) == ("dot\n", "")
    run = python("import scenelang.notebook.magic", folder)
    assert (run.returncode == 0) == ("notebook" not in gone), run.stderr


def drawn(day: int) -> list[str]:
    """Two domains, others on each day until all were drawn."""
    names = sorted(table())
    return [names[number % len(names)] for number in (2 * day, 2 * day + 1)]


def test_every_domain_is_drawn_in_turn() -> None:
    days = len(table()) // 2 + 1
    assert {name for day in range(TODAY, TODAY + days) for name in drawn(day)} == set(table())


@pytest.mark.parametrize("name", drawn(TODAY))
def test_a_domain_can_be_deleted(name: str, tmp_path: Path) -> None:
    check_deletion(name, tmp_path, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(table()))
def test_every_domain_can_be_deleted(name: str, tmp_path: Path) -> None:
    check_deletion(name, tmp_path)


def test_files_that_can_be_imported_are_those_of_the_importers() -> None:
    from scenelang.backends.minecraft.export import ENDINGS
    from scenelang.session.session import IMPORTED_ENDINGS

    assert set(IMPORTED_ENDINGS) == {".scad", *ENDINGS}
