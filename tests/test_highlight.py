"""The Pygments lexer: no text is lost, nothing is an error, half-typed text is fine."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pygments.lexers import get_lexer_by_name, get_lexer_for_filename
from pygments.token import Comment, Error, Keyword, Name, Number, Punctuation, String

from scenelang.interpreter.expand.forms import FORMS
from scenelang.reference.highlight import SceneLexer
from scenelang.stdlib.library import build_library

ROOT = Path(__file__).parents[1]
FILES = sorted([*(ROOT / "examples").rglob("*.scene"), *(ROOT / "stdlib").glob("*.scene"),
                *(ROOT / "tests" / "bad").glob("*.scene")])  # fmt: skip


def _tokens(text: str) -> list[tuple[object, str]]:
    return [(token, value) for _, token, value in SceneLexer().get_tokens_unprocessed(text)]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_nothing_is_lost_and_nothing_is_an_error(path: Path) -> None:
    text = path.read_bytes().decode("utf-8", "replace")
    tokens = _tokens(text)
    assert "".join(value for _, value in tokens) == text
    assert not [value for token, value in tokens if token is Error]


@given(st.text(alphabet="()[]\"\\;#|:'`,@<>.*z1 +\n\r\tλ\x00", max_size=40))
def test_any_text_is_colored_whole(text: str) -> None:
    tokens = _tokens(text)
    assert "".join(value for _, value in tokens) == text
    assert Error not in {token for token, _ in tokens}


def test_every_beginning_of_a_program() -> None:
    text = '#| a |# (define (f x::List[Float]) "a\\n" #;(g "b" [1]) (call "tower" :n <z1>)) ; c'
    for end in range(len(text) + 1):
        assert "".join(value for _, value in _tokens(text[:end])) == text[:end]


def test_what_tokens_are() -> None:
    found = {value: token for token, value in _tokens(
        '(define (f x::Float) (if #t -1.5 3)) (bind "dot" (lambda () (call "cube" :scale [1 2 3] <z1>)))'
        ' (for/list ((y xs)) (deg y)) #;(gone "\\"") pi (mine) (union-loop 3 g) ; end\n"a\\n"'
    )}  # fmt: skip
    wanted = {
        "define": Keyword.Declaration, "f": Name.Function, "x": Name.Variable, "Float": Keyword.Type, "if": Keyword,
        "#t": Keyword.Constant, "-1.5": Number.Float, "3": Number.Integer, "bind": Keyword.Namespace,
        "dot": Name.Class, "cube": Name.Class, ":scale": Name.Attribute, "[": Punctuation, "<z1>": Name.Decorator,
        "for/list": Keyword, "deg": Name.Builtin, "gone ": Comment.Preproc, "pi": Name.Constant, "mine": Name,
        "union-loop": Keyword.Namespace, "; end": Comment.Single, "\\n": String.Escape,
    }  # fmt: skip
    assert {value: found.get(value) for value in wanted} == wanted


def test_every_name_of_the_language_is_known() -> None:
    names = [*FORMS, *build_library().builtins]
    assert not [name for name in names if _tokens(name) != [(_tokens(name)[0][0], name)] or _tokens(name)[0][0] is Name]


def test_it_is_an_entry_point() -> None:
    assert type(get_lexer_by_name("scene")) is SceneLexer
    assert type(get_lexer_by_name("scenelang")) is SceneLexer
    assert type(get_lexer_for_filename("town.scene")) is SceneLexer


def test_importing_it_is_cheap() -> None:
    code = "import sys, scenelang.reference.highlight; print([m for m in sys.modules if m.startswith('scenelang.')], 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['scenelang.reference', 'scenelang.reference.highlight'] False"
