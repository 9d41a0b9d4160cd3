"""The TextMate grammar in the engine of VS Code; skipped where `make test` found no npm to install it with."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from scenelang.stdlib.reference import grammar_text

from .cases import GOOD, ROOT

MODULES = Path(os.environ.get("SCENELANG_TEXTMATE") or ROOT / ".venv" / "textmate" / "node_modules")
NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(
    NODE is None or not (MODULES / "vscode-textmate").exists(), reason="no node with vscode-textmate"
)

PROGRAM = """#| a #| b |# |# (define (f x::List[Float]) (if #t 1.5 none)) ; end
(bind "tower" (lambda (:height) (call "cube" :scale [1 2 3] <z1> "a\\n")))
(list #; (hidden "(" 1) 7 #;gone 'quoted pi)
(union-loop 3 (lambda (i) (for/list ((x xs)) (my-own-if x))))
"""


def _scopes(folder: Path, files: list[Path]) -> dict[str, list[tuple[str, str]]]:
    assert NODE is not None
    grammar = folder / "grammar.json"
    grammar.write_text(grammar_text("textmate"), encoding="utf-8")
    script = Path(__file__).with_name("tokenise.cjs")
    words = [NODE, script, grammar, MODULES, *files]
    done = subprocess.run(words, capture_output=True, check=False, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    found: dict[str, list[tuple[str, str]]] = json.loads(done.stdout)
    return found


def test_scopes(tmp_path: Path) -> None:
    file = tmp_path / "program.scene"
    file.write_text(PROGRAM, encoding="utf-8")
    tokens = _scopes(tmp_path, [file])[str(file)]
    scopes: dict[str, str] = {}
    for text, scope in tokens:
        scopes.setdefault(text.strip(), scope)
    wanted = {
        " b ": "comment.block", "; end": "comment.line", "define": "storage.type", "f": "entity.name.function",
        "x": "variable.parameter", "List[Float]": "storage.type.annotation", "if": "keyword.control",
        "#t": "constant.language", "1.5": "constant.numeric", "none": "constant.language", "bind": "keyword.other.paper",
        '"tower"': "entity.name.type.word", ":scale": "constant.other.keyword", "<z1>": "constant.other.handle",
        '"cube"': "entity.name.type.word", "\\n": "constant.character.escape", "lambda": "keyword.control",
        "union-loop": "keyword.other.paper", "for/list": "keyword.control", "my-own-if": "variable.other",
        "list": "support.function", "#;gone": "comment.block.datum", "hidden": "comment.block.datum",
        "pi": "support.constant",
    }  # fmt: skip
    missing = {
        text: scopes.get(text.strip()) for text, scope in wanted.items() if scope not in scopes.get(text.strip(), "")
    }
    assert not missing, missing
    assert [scope for text, scope in tokens if text.strip() == "7"] == ["constant.numeric.scene"]


def test_every_example_is_colored_whole(tmp_path: Path) -> None:
    for path, tokens in _scopes(tmp_path, GOOD).items():
        assert "".join(text for text, _ in tokens) == Path(path).read_text("utf-8").replace("\n", "")
        bare = [text for text, scope in tokens if text.strip() and not scope]
        assert not bare, (path, bare)
        assert not [text for text, scope in tokens if "invalid" in scope]
        assert tokens[-1][1] == "" or "comment.line" in tokens[-1][1], "something is still open at the end"
