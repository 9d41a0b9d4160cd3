"""Responses of language models become programs: right, short, readable, with their comments."""

from __future__ import annotations

import ast
import io
import json
import os
import re
import statistics
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest
from corpus.compare import compare
from formatter.texts import INDENTS
from sampling import one_in

from scenelang.cli.main import main
from scenelang.grammar.concrete import LINE_COMMENT, tokens
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, Source, Symbol, print_datum
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.formatter import WIDTH, format_text
from scenelang.session.session import Checked, Session
from transpile.cases import (
    CORPUS,
    HERE,
    IMITATIONS,
    Case,
    evaluated,
    flattened,
    flattened_case,
    printed,
    scene_of_case,
    told,
    translated,
)

UPDATE = bool(os.environ.get("SCENELANG_UPDATE_GOLDENS"))
SCENES = HERE / "scenes"
LONGEST_LINE = 120
MEDIAN_LENGTH, GREATEST_LENGTH = 1.05, 1.3
DYNAMIC = frozenset(Session().library.imported["python.scene"])

# Rejected on purpose: the code of the error, and why.
# Kept as files that a person has read, in `scenes`: one for each kind of program.
KEPT = (
    "t13-stonehenge",  # nested functions, sets, one random stream
    "t11-bookshelf",  # both random streams, a running total
    "t03-bramante-staircase",  # closures
    "n02-connect-four",  # a table of what stands where, names given anew
    "n16-newtons-cradle",  # frames, a list changed in place
    "n20-medieval-tower",  # blocks, loops with several appends
    "towers-of-hanoi-recursive-moves-animation",  # a generator that yields in several places
    "maze-depth-first-search-random",  # while, break, a stack, a grid changed in place
    "dataclass-record-train",  # records
    "solar-system-dict-of-parameters",  # dicts of parameters
)

# of the module, so that all tests of a case come one after the other and share its scene
every = pytest.mark.parametrize("case", CORPUS, ids=lambda case: case.name, scope="module")
imitation = pytest.mark.parametrize("case", one_in(6, IMITATIONS), ids=lambda case: case.name, scope="module")
both = pytest.mark.parametrize("case", [*CORPUS, *one_in(6, IMITATIONS)], ids=lambda case: case.name, scope="module")


def test_the_cases_are_there() -> None:
    assert len(CORPUS) == 25
    assert len(IMITATIONS) >= 104
    assert len({case.name for case in [*CORPUS, *IMITATIONS]}) == len(CORPUS) + len(IMITATIONS)


# --- the geometry ------------------------------------------------------------------------------------------------


@both
def test_the_geometry_is_the_golden_one(case: Case) -> None:
    golden = case.golden_scene()
    result = compare(flattened_case(case), golden)
    assert result["equal"], result
    assert result["matched"] == sum(len(frame["primitives"]) for frame in golden["frames"])


@both
def test_the_root_is_the_same(case: Case) -> None:
    assert scene_of_case(case).word == case.golden_scene()["root"]


@every
def test_diff_finds_nothing(case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    golden, program = tmp_path / "golden.json", tmp_path / f"{case.name}.scene"
    golden.write_text(json.dumps(case.golden_scene()))
    program.write_text(translated(case).text)
    assert main(["diff", str(program), str(golden)]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("equal: ")
    assert "error" not in err


@pytest.mark.parametrize("case", [*CORPUS, *one_in(12, IMITATIONS)], ids=lambda case: case.name, scope="module")
def test_a_response_runs_directly(case: Case) -> None:
    """A .txt file, evaluated, is the program that its translation is."""
    result = evaluated(f"{case.name}.txt", case.text)
    assert result.scene is not None, told(result.diagnostics)
    assert flattened(result.scene) == flattened_case(case)


# --- the text ----------------------------------------------------------------------------------------------------


def _mistakes(checked: Checked) -> list[Diagnostic]:
    """What is wrong with a translation, save what its model left over or composed oddly."""
    leftovers = ("unused", "unreachable-word", "turned-after-moved", "constant-condition")
    return [d for d in checked.diagnostics if d.name not in leftovers]


@every
def test_no_diagnostics(case: Case) -> None:
    translation = translated(case)
    assert not translation.diagnostics, told(translation.diagnostics)
    checked = Session().check(Source(f"{case.name}.scene", translation.text))
    assert not _mistakes(checked), told(checked.diagnostics)


@imitation
@pytest.mark.sampled(3)
def test_imitations_check_without_warning(case: Case) -> None:
    checked = Session().check(Source(f"{case.name}.scene", translated(case).text))
    assert not _mistakes(checked), told(checked.diagnostics)


@both
def test_it_reads_back(case: Case) -> None:
    """The text holds the forms, and what the printer makes of it reads back unchanged too."""
    forms = [print_datum(form) for form in translated(case).forms]
    assert printed(translated(case).text) == forms
    assert printed("\n".join(forms)) == forms


@both
def test_lines_are_not_long(case: Case) -> None:
    """Only what nothing can break may be wider: a string, one atom, or a comment without spaces."""
    for line in translated(case).text.splitlines():
        assert line == line.rstrip()
        assert "\t" not in line
        bare = re.sub(r'"(?:[^"\\]|\\.)*"', '""', line)
        assert len(bare) <= LONGEST_LINE or len(bare.split()) <= 2, line


@both
def test_it_is_formatted(case: Case) -> None:
    text = translated(case).text
    assert format_text(text, INDENTS) == text
    assert not _could_be_broken(text)


def _could_be_broken(text: str) -> list[str]:
    """The lines that are too long although they could be broken: comments, and one token on a line, cannot."""
    found = list(tokens(text))
    lines = []
    for line in text.splitlines():
        if len(line) > WIDTH and not any(t.kind == LINE_COMMENT and line.endswith(t.text.rstrip()) for t in found):
            words = line.strip().strip("()[]'")
            if not (words.startswith('"') and words.endswith('"')) and '"' not in words:
                lines.append(line)
    return lines


def _length(text: str) -> int:
    return len("".join(text.split()))


def _ratio(case: Case) -> float:
    return _length(translated(case).text) / _length(case.code)


@every
def test_it_is_not_longer_than_the_python(case: Case) -> None:
    assert _ratio(case) <= GREATEST_LENGTH


def test_it_is_as_short_as_the_python() -> None:
    assert statistics.median(map(_ratio, CORPUS)) <= MEDIAN_LENGTH


@pytest.mark.parametrize(
    "cases", [CORPUS, pytest.param(IMITATIONS, marks=pytest.mark.slow)], ids=["corpus", "imitations"]
)
def test_dynamic_operators_are_rare(cases: list[Case]) -> None:
    used = {case.name: found for case in cases if (found := _dynamic(case))}
    assert len(used) <= len(cases) / 10, used


@both
def test_the_import_is_there_when_it_is_needed(case: Case) -> None:
    assert ('(import "std/python.scene")' in translated(case).text) == bool(_dynamic(case))


def _dynamic(case: Case) -> set[str]:
    return {name for form in translated(case).forms for name in _symbols(form)} & DYNAMIC


def _symbols(datum: Datum) -> Iterator[str]:
    if isinstance(datum, Atom):
        if isinstance(datum.value, Symbol):
            yield str(datum.value)
    elif isinstance(datum, (ListDatum, ArrayDatum)):
        for item in datum.items:
            yield from _symbols(item)


# --- the comments ------------------------------------------------------------------------------------------------


@both
def test_comments_stay(case: Case) -> None:
    """Every comment and docstring of what is translated stands in comments of the output, perhaps wrapped."""
    kept = _words(" ".join(re.findall(r"(?m)(?:^|\s);+(.*)$", translated(case).text)))
    lost = [text for text in _python_comments(case.code) if f" {_words(text)} " not in f" {kept} "]
    assert not lost


def _words(text: str) -> str:
    return " ".join(text.split())


def _python_comments(code: str) -> list[str]:
    """The comments and the lines of docstrings outside of what has no effect."""
    code = code.replace("\r\n", "\n")
    tree = ast.parse(code)
    left_out = {line for node in _left_out(tree) for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)}
    found = []
    for token in tokenize.generate_tokens(io.StringIO(code).readline):
        if token.type == tokenize.COMMENT and token.start[0] not in left_out:
            found.append(token.string.lstrip("#"))
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.Module)) and (doc := ast.get_docstring(node)):
            if node.body[0].lineno not in left_out:
                found += doc.splitlines()
    return [text for text in found if text.strip()]


def _left_out(tree: ast.Module) -> Iterator[ast.stmt]:
    """Functions that a later definition replaces, and `if __name__ == "__main__"`."""
    last = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    for node in tree.body:
        replaced = isinstance(node, ast.FunctionDef) and last[node.name] is not node
        if replaced or (isinstance(node, ast.If) and "__name__" in ast.unparse(node.test)):
            yield node


# --- programs that a person has read -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", KEPT)
def test_kept_programs(name: str) -> None:
    case = next(case for case in [*CORPUS, *IMITATIONS] if case.name == name)
    golden = SCENES / f"{name}.scene"
    if UPDATE:
        golden.write_text(translated(case).text, "utf-8")
    assert translated(case).text == golden.read_text("utf-8")


def test_nothing_else_is_kept() -> None:
    assert {path.name for path in SCENES.iterdir()} == {f"{name}.scene" for name in KEPT}
