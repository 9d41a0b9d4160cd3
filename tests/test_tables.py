"""The tables in the package are those of the grammars, and driving them gives what Lark's own parser gives."""

from __future__ import annotations

import random
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lark import Lark, Transformer, v_args
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer
from lark_reader import GRAMMARS as FOLDER
from lark_reader import read_by_lark
from searching import many

from scenelang.grammar import ast
from scenelang.grammar.ast import check_strict, parse_core
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Source, Symbol
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.lalr import END, Misfit
from scenelang.grammar.reader import MAX_NESTING, read
from scenelang.grammar.table_making import GRAMMARS, tables_text

ROOT = Path(__file__).parents[1]
PROGRAMS = sorted(
    path for folder in ("examples", "tests", "stdlib", "benchmarks") for path in (ROOT / folder).rglob("*.scene")
)
PIECES = [
    "(", ")", "[", "]", "'", "`", ",", ",@", "#;", ";", "; c\n", "#|", "|#", '"', '"s"', '"\\q"', '"a\nb"', ".", " . ", " ",
    "\n", "\n  ", "\t", "a", "x::List[Float]", "x::", "1.5", "3px", ":k", "::", "<z1>", "#t", "#foo", "...", "a.", "\\", "é", "\x00",
]  # fmt: skip


@pytest.mark.parametrize("name", GRAMMARS)
def test_tables_are_those_of_the_grammar(name: str) -> None:
    """After a change of a grammar: ``make tables``."""
    assert (ROOT / "grammar" / "tables" / f"{name}_tables.py").read_text("utf-8") == tables_text(name)


# --- the reader ------------------------------------------------------------------------------------------------------


def compare(text: str) -> None:
    source = Source("<test>", text)
    ours, theirs = read(source), read_by_lark(source)
    assert ours.completeness is theirs.completeness
    assert ours.diagnostics == theirs.diagnostics
    assert repr(ours.forms) == repr(theirs.forms)


def mutated(text: str, chance: random.Random) -> str:
    """A text with a piece of it removed, repeated elsewhere or replaced."""
    start = chance.randrange(len(text) + 1)
    end = min(len(text), start + chance.choice((0, 1, 1, 2, 5, 40)))
    piece = chance.choice((chance.choice(PIECES), "", text[chance.randrange(len(text) + 1) :][: chance.randrange(30)]))
    return text[:start] + piece + text[end:]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: str(path.relative_to(ROOT)))
@pytest.mark.sampled(5)
def test_programs_read_as_by_lark(path: Path) -> None:
    text = path.read_bytes().decode("utf-8", "replace")
    compare(text)
    chance = random.Random(path.name)
    for _ in range(3):
        text = mutated(text, chance)
        compare(text)


@given(st.lists(st.sampled_from(PIECES), max_size=14).map("".join))
@settings(max_examples=many(600))
def test_texts_of_pieces_read_as_by_lark(text: str) -> None:
    compare(text)


@pytest.mark.parametrize("opener", ["(", "[", "'", "#;", "('", "#;#;a(", "(a (b [", "x[", "#;'("])
@pytest.mark.parametrize("count", [MAX_NESTING // 2, MAX_NESTING, MAX_NESTING + 1])
def test_deep_texts_read_as_by_lark(opener: str, count: int) -> None:
    source = Source("<test>", '(3px "\\q" . b) 4px' + opener * count + "5px")
    assert read(source).diagnostics == read_by_lark(source).diagnostics


# --- the core --------------------------------------------------------------------------------------------------------


class _Token:
    """Token for Lark's parser, with what the builders ask of a datum."""

    start_pos = line = column = end_line = end_column = end_pos = 0

    def __init__(self, kind: str, datum: Any) -> None:
        self.type, self.datum = kind, datum
        self.span = getattr(datum, "span", None)
        self.value = getattr(datum, "value", None)


class _Lexer(Lexer):
    def __init__(self, _: Any) -> None:
        pass

    def lex(self, lexer_state: Any, parser_state: Any = None) -> Iterator[Any]:
        yield from lexer_state


@cache
def _lark(start: str) -> Lark:
    builder = (
        v_args(inline=True)(type("Builder", (Transformer,), dict(vars(ast._Builder))))() if start == "start" else None
    )
    text = (FOLDER / "core.lark").read_text("utf-8")
    return Lark(text, parser="lalr", lexer=_Lexer, start=start, transformer=builder)


def by_lark(datums: tuple[Datum, ...], start: str) -> Any:
    terminal = ast._terminal if start == "start" else ast._strict_terminal
    stack: Any = []
    kinds = ast._tokens(datums, terminal, stack)
    try:
        forms: Any = _lark(start).parse(_Token(*each) for each in kinds if each[0] != END)  # type: ignore[arg-type]
        return forms
    except UnexpectedToken as error:
        datum = error.token.datum if isinstance(error.token, _Token) else None
        misfit = Misfit(error.token.type, datum, frozenset(error.expected))
        return ast._misfit(misfit, stack) if start == "start" else ast._strict_misfit(misfit, stack)


def ours(datums: tuple[Datum, ...], start: str) -> Any:
    try:
        return parse_core(datums) if start == "start" else check_strict(datums)
    except SceneError as error:
        return error


CORE_ATOMS = [ast.Head(name) for name in
    ["BIND", "UNION", "UNION_LOOP", "TRANSFORM", "CALL", "QUOTE", "SET", "IF", "AND", "OR", "LAMBDA", "DEFINE", "BODY", "FIRST", "WHILE", "FOR", "LET_ESCAPE", "GUARD"]
] + [
    ast.Opaque("DATUM", 1), ast.Opaque("PARAMETERS", ("f", (), "(f)")), ast.Opaque("PATTERN", "p"), ast.Opaque("KIND", "each"),
    ast.Opaque("CLAUSE", "when"), Symbol("x"), Symbol("x"), 1, "text", Handle("z"), Keyword("k"), None,
]  # fmt: skip
STRICT_ATOMS = [Symbol(name) for name in [*ast.STRICT_HEADS, "+", "compute-shape-center", "x"]] + [1, "w", None, True, Handle("z"), Keyword("k")]  # fmt: skip


def made(chance: random.Random, atoms: list[Any], depth: int) -> Datum:
    from scenelang.grammar.datum import Span

    span = Span(Source("<test>", "text"), 0, chance.randrange(1, 5))
    if depth == 0 or chance.random() < 0.45:
        return Atom(chance.choice(atoms), span)
    items = tuple(made(chance, atoms, depth - 1) for _ in range(chance.randrange(6)))
    return ArrayDatum(items, span) if chance.random() < 0.1 else ListDatum(items, None, span)


TEMPLATES = """(SET x 1) (IF 1 2) (IF 1 2 3) (AND) (AND 1 2) (OR 1) (LAMBDA PARAMETERS () 1) (LAMBDA PARAMETERS (1 2) 3) (BODY (DEFINE x 1) x)
(BODY 1) (FIRST 1 2) (x 1 2) [1 x] [] (WHILE 1 2) (FOR KIND ((DEFINE x 1)) ((CLAUSE x 1 PATTERN 2) (CLAUSE 1)) 5) (FOR KIND () () 1)
(LET_ESCAPE x 1) (GUARD x 1 2) (BIND "w" 1) (UNION) (UNION 1 2) (UNION_LOOP 1 2) (TRANSFORM 1 2) (CALL "w" 1) (CALL "w") (QUOTE DATUM)
(DEFINE x 1) (DEFINE PATTERN 2) <z> :k none"""


def core_datums(text: str) -> tuple[Datum, ...]:
    """Datums as the expander leaves them: names of terminals are heads and what they stand for."""

    def core(datum: Datum) -> Datum:
        if not isinstance(datum, Atom):
            parts = tuple(core(part) for part in datum.items)
            return (
                ArrayDatum(parts, datum.span) if isinstance(datum, ArrayDatum) else ListDatum(parts, None, datum.span)
            )
        known: dict[str, Any] = {each.terminal: each for each in CORE_ATOMS if isinstance(each, ast.Opaque)}
        known |= {str(each): each for each in CORE_ATOMS if isinstance(each, ast.Head)}
        return Atom(known.get(str(datum.value), datum.value), datum.span) if type(datum.value) is Symbol else datum

    return tuple(core(datum) for datum in read(Source("<core>", text)).forms)


def replaced(chance: random.Random, datum: Datum, atoms: list[Any]) -> Datum:
    """A datum with one of its parts exchanged, left out or repeated."""
    if isinstance(datum, Atom) or not datum.items or chance.random() < 0.2:
        return made(chance, atoms, 2)
    place = chance.randrange(len(datum.items))
    part = chance.choice(((), (replaced(chance, datum.items[place], atoms),), (datum.items[place],) * 2))
    items = (*datum.items[:place], *part, *datum.items[place + 1 :])
    return ArrayDatum(items, datum.span) if isinstance(datum, ArrayDatum) else ListDatum(items, None, datum.span)


def agree(datums: tuple[Datum, ...], start: str) -> None:
    mine, theirs = ours(datums, start), by_lark(datums, start)
    if isinstance(mine, SceneError):
        assert isinstance(theirs, SceneError)
        assert mine.diagnostic == theirs.diagnostic
        assert mine.value == theirs.value
        assert getattr(mine, "form", None) is getattr(theirs, "form", None)
    elif start == "start":
        assert repr(mine) == repr(theirs)
    else:
        assert not isinstance(theirs, SceneError)


def test_every_core_form_parses_as_by_lark() -> None:
    for text in TEMPLATES.replace("\n", " ").replace(") (", ")\n(").splitlines():
        agree(core_datums(text), "start")
    assert not isinstance(ours(core_datums(TEMPLATES), "start"), SceneError)


@pytest.mark.parametrize("seed", range(20))
def test_core_forms_with_mistakes_parse_as_by_lark(seed: int) -> None:
    chance = random.Random(seed)
    forms = core_datums(TEMPLATES)
    for _ in range(40):
        picked = tuple(chance.choice(forms) for _ in range(3))
        agree((*picked, replaced(chance, chance.choice(forms), CORE_ATOMS), *picked), "start")
        agree(tuple(made(chance, CORE_ATOMS, 4) for _ in range(2)), "start")


@pytest.mark.parametrize("seed", range(10))
def test_strict_forms_with_mistakes_parse_as_by_lark(seed: int) -> None:
    chance = random.Random(seed)
    strict = read(Source("<strict>", STRICT_PROGRAM)).forms
    agree(strict, "strict_start")
    assert ours(strict, "strict_start") is None
    for _ in range(60):
        agree(tuple(replaced(chance, form, STRICT_ATOMS) for form in strict), "strict_start")


STRICT_PROGRAM = """
(bind "a" (lambda (l z) (union (transform (call "b" 1 [2 x] (+ 1 2) (if #t 1)) (translate [0 0 0])))))
(bind "b" (lambda (l z) (union-loop 3 (lambda (i) (transform (call "c" (and 1 2) (embedding 1 :k 2)) (@ x y))))))
(bind "c" (lambda () (list (call "a" (compute-shape-center (call "b" none <z>))))))
"""
