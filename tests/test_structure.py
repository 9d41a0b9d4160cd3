"""The rooms of the code keep to the map in docs/architecture.md."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Hashable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TypeVar

from scenelang.interpreter.expand.derived import HANDLERS
from scenelang.interpreter.expand.forms import FORMS
from scenelang.stdlib.library import build_library

Node = TypeVar("Node", bound=Hashable)
ROOT = Path(__file__).parent.parent
ROOMS = ["grammar", "interpreter", "stdlib", "backends", "scenelang"]  # each may import those before it
HEAVY = {"mujoco", "coacd", "torch", "pxr", "mitsuba", "trimesh", "diffusers", "transformers", "open_clip", "anthropic"}


@cache
def parsed(path: Path) -> tuple[ast.Module, list[ast.AST]]:
    """A file, and all that is in it."""
    tree = ast.parse(path.read_text("utf-8"))
    return tree, list(ast.walk(tree))


def imports(path: Path) -> Iterator[tuple[str, bool]]:
    """Modules that a file imports, and whether it does so when it is loaded."""
    tree, nodes = parsed(path)
    for node in nodes:
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        for name in names:
            yield name, node in tree.body


FILES = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]


def forbidden(path: Path) -> Iterator[str]:
    """The imports of a file that its room may not have."""
    room = ROOMS.index(path.relative_to(ROOT).parts[0])
    for name, at_load in imports(path):
        parts = name.split(".")
        if parts[0] == "scenelang":
            target = ROOMS.index(parts[1]) if len(parts) > 1 and parts[1] in ROOMS[:4] else ROOMS.index("scenelang")
            is_right = target <= room
        elif parts[0] in HEAVY:
            is_right = room >= ROOMS.index("backends") and not at_load
        elif ROOMS[room] == "grammar":
            is_right = parts[0] in ("lark", "__future__") or parts[0] in sys.stdlib_module_names
        else:
            is_right = True
        if not is_right:
            yield f"{path.relative_to(ROOT)} imports {name}"


def test_imports_go_one_way() -> None:
    assert len(FILES) > 200
    assert [told for path in FILES for told in forbidden(path)] == []


def test_checking_a_program_imports_nothing_heavy(tmp_path: Path) -> None:
    program = tmp_path / "a.scene"
    program.write_text('(bind "a" (lambda () (call "cube")))')
    code = (
        "import sys; from scenelang.cli.main import main\n"
        f"assert main(['check', {str(program)!r}]) == 0\n"
        f"print(sorted({HEAVY | {'PIL', 'rich', 'prompt_toolkit', 'safetensors', 'mcp', 'pydantic'}!r} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert result.stdout.strip() == "[]"


def test_every_form_is_handled_and_documented() -> None:
    assert set(HANDLERS) == set(FORMS)
    assert all(form.doc and form.usage.startswith(f"({form.name}") for form in FORMS.values())


def test_every_builtin_is_documented_and_its_signature_parses() -> None:
    library = build_library()
    for builtin in (b for group in (library.builtins, *library.imported.values()) for b in group.values()):
        assert builtin.doc.rstrip().endswith((".", "`")), builtin.name
        assert builtin.result, builtin.name
        assert builtin.signature.text == builtin.parameters


# --- sizes and cycles -------------------------------------------------------------------------------------------------


MODULES = [path for path in FILES if path.name != "__init__.py"]
TOGETHER = [  # functions that recurse on the same tree
    {"interpreter/compile/compile.py", "interpreter/compile/comprehension.py"},
    {"interpreter/expand/derived.py", "interpreter/expand/expand.py"},
]


def imported_files(path: Path) -> set[Path]:
    """The files of ours that a file imports when it runs, at any place of it."""
    _, nodes = parsed(path)
    typing = {
        node
        for block in nodes
        if isinstance(block, ast.If) and isinstance(block.test, ast.Name) and block.test.id == "TYPE_CHECKING"
        for statement in block.body
        for node in ast.walk(statement)
    }
    found = set()
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node not in typing and (node.module or "").startswith("scenelang"):
            for alias in node.names:
                found |= {file_of(f"{node.module}.{alias.name}") or file_of(str(node.module))}
    return {target for target in found if target is not None} - {path}


def file_of(module: str) -> Path | None:
    parts = module.split(".")[1:]
    base = ROOT.joinpath(*parts) if parts and parts[0] in ROOMS else ROOT.joinpath("scenelang", *parts)
    return next((path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file()), None)


def reached_from(start: Node, graph: Mapping[Node, set[Node]]) -> set[Node]:
    found: set[Node] = set()
    stack = [start]
    while stack:
        for target in graph.get(stack.pop(), set()) - found:
            found.add(target)
            stack.append(target)
    return found


def test_only_what_recurses_on_one_tree_imports_each_other() -> None:
    graph = {path: imported_files(path) for path in MODULES}
    reached = {path: reached_from(path, graph) for path in graph}
    cycles = {
        frozenset(str(o.relative_to(ROOT)) for o in reached[path] if path in reached.get(o, ()))
        for path in graph
        if path in reached[path]
    }
    assert cycles == set(map(frozenset, TOGETHER))


# --- folders ----------------------------------------------------------------------------------------------------------

FACADE = {"scenelang"}  # __init__, __main__ and api, which nothing imports


def named_modules(path: Path) -> Iterator[str]:
    """The modules of ours that a file names: in imports of any place, for types too, and in calls of ``import_module``."""
    for node in parsed(path)[1]:
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "scenelang":
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "scenelang")
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module") and node.args:
            named = node.args[0]
            if isinstance(named, ast.Constant) and str(named.value).startswith("scenelang"):
                yield str(named.value)


def folder_graph() -> dict[str, set[str]]:
    """Which folders' own files import which others'."""
    graph: dict[str, set[str]] = {}
    for path in FILES:
        own = path.parent.relative_to(ROOT).as_posix()
        for module in named_modules(path):
            target = file_of(module) or file_of(module.rpartition(".")[0])
            if target is not None and target.parent != path.parent:
                graph.setdefault(own, set()).add(target.parent.relative_to(ROOT).as_posix())
    return graph


def test_folders_are_layers() -> None:
    """No folder imports one that imports it, whatever the way; a folder means its own files."""
    graph = folder_graph()
    assert len(graph) > 40
    knots = {folder for folder in graph if folder in reached_from(folder, graph)}
    assert sorted(knots) == []


def test_nothing_imports_the_facade() -> None:
    importers = {folder for folder, targets in folder_graph().items() if targets & FACADE}
    assert sorted(importers) == []


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> list[str]:
    """The parameters of a function, without the object or class of a method."""
    stated = function.args
    named = [*stated.posonlyargs, *stated.args, *stated.kwonlyargs, stated.vararg, stated.kwarg]
    return [each.arg for each in named if each is not None and each.arg not in ("self", "cls")]


@cache
def private_functions() -> list[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """Functions and methods that begin with one underscore, with their places."""
    private = [
        (f"{path.relative_to(ROOT)}: {node.name}", node)
        for path in FILES
        for node in parsed(path)[1]
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and re.match(r"_(?!_)", node.name)
    ]
    assert len(private) > 2_000
    return private


def test_private_functions_have_at_most_seven_parameters() -> None:
    """More are a data class; public functions have the parameters that users know."""
    assert [place for place, node in private_functions() if len(parameters(node)) > 7] == []


POSITIONAL_BOOLEANS = {"scenelang/viewer/workspace.py: _evaluate"}  # one caller


def test_private_functions_take_booleans_by_name() -> None:
    """``f(x, True)`` does not say what is true."""
    positional = {
        place
        for place, node in private_functions()
        for each in (*node.args.posonlyargs, *node.args.args)
        if isinstance(each.annotation, ast.Name) and each.annotation.id == "bool"
    }
    assert positional <= POSITIONAL_BOOLEANS


def test_few_names_mean_two_things() -> None:
    stems = Counter(path.stem for path in MODULES)
    assert sum(count > 1 for count in stems.values()) <= 24  # `random` is one of numpy's names
    classes = Counter(
        node.name
        for path in MODULES
        for node in parsed(path)[0].body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert sum(count > 1 for count in classes.values()) <= 8


def test_the_command_line_is_one_user_of_the_api_among_others() -> None:
    outside = [path for path in MODULES if "cli" not in path.relative_to(ROOT).parts]
    assert [path.name for path in outside if re.search(r"argparse\.Namespace", path.read_text("utf-8"))] == []
    importers = [path for path in outside if any(name.startswith("scenelang.cli") for name, _ in imports(path))]
    assert [path.name for path in importers] == ["__main__.py"]


def test_every_package_says_what_it_must_not_know() -> None:
    packages = [path for path in FILES if path.name == "__init__.py" and path.parent != ROOT / "scenelang"]
    for path in packages:
        doc = ast.get_docstring(parsed(path)[0]) or ""
        assert len(doc.splitlines()) >= 3, path


def test_no_module_mixes_two_kinds_of_data_classes() -> None:
    """Fields of ``grammar.datum`` and of ``dataclasses`` do not mix in one class."""
    names = {"dataclass", "field", "fields", "replace", "asdict"}
    mixed = []
    for path in MODULES:
        nodes = [node for node in parsed(path)[1] if isinstance(node, ast.ImportFrom)]
        sources = {node.module for node in nodes if names & {alias.name for alias in node.names}}
        if {"dataclasses", "scenelang.grammar.datum"} <= sources and path.name != "datum.py":
            mixed.append(str(path.relative_to(ROOT)))
    assert mixed == []


REGISTRIES = {  # what imports modules by names in tables: plug-ins and services, primitives, commands, the public names
    "interpreter/loading.py",  # entry points, packages of extras
    "interpreter/scene/primitives/__init__.py",
    "scenelang/__init__.py",
    "scenelang/cli/command_table.py",
}


def test_only_registries_import_by_computed_names() -> None:
    importers = set()
    for path in FILES:
        for node in parsed(path)[1]:
            if isinstance(node, ast.Call) and node.args and ast.unparse(node.func).endswith("import_module"):
                if not any(isinstance(part, ast.Constant) and isinstance(node.args[0], ast.Constant | ast.IfExp)
                           for part in ast.walk(node.args[0])):  # fmt: skip
                    importers.add(path.relative_to(ROOT).as_posix())
    assert importers == REGISTRIES
