"""The rooms of the code keep to the map in docs/architecture.md."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from scenelang.interpreter.expand.derived import HANDLERS
from scenelang.interpreter.expand.forms import FORMS
from scenelang.stdlib.library import build_library

ROOT = Path(__file__).parent.parent
ROOMS = ["grammar", "interpreter", "stdlib", "backends", "scenelang"]  # each may import those before it
HEAVY = {"torch", "pxr", "mitsuba", "trimesh", "diffusers", "transformers", "open_clip", "anthropic"}


def imports(path: Path) -> Iterator[tuple[str, bool]]:
    """Modules that a file imports, and whether it does so when it is loaded."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        for name in names:
            yield name, node in tree.body


FILES = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_go_one_way(path: Path) -> None:
    room = ROOMS.index(path.relative_to(ROOT).parts[0])
    for name, at_load in imports(path):
        parts = name.split(".")
        if parts[0] == "scenelang":
            target = ROOMS.index(parts[1]) if len(parts) > 1 and parts[1] in ROOMS[:4] else ROOMS.index("scenelang")
            assert target <= room, f"{path} imports {name}"
        if room < ROOMS.index("backends") or at_load:
            assert parts[0] not in HEAVY, f"{path} imports {name}"
        if ROOMS[room] == "grammar" and parts[0] not in ("scenelang", "__future__"):
            assert parts[0] == "lark" or parts[0] in sys.stdlib_module_names, f"{path} imports {name}"


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
