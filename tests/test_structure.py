"""The rooms of the code keep to the map in docs/architecture.md."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

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
    assert len(FILES) > 250
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
