"""The grammar against `check`: sentences of the grammar have the right shape, and what has it is a sentence."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, Source, Span, Symbol, print_datum
from scenelang.grammar.diagnostics import CODES
from scenelang.grammar.export.model import Expression, Literal, Ref
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import full_grammar, strict_grammar
from scenelang.session.session import Options, Session

from .cases import GOOD, SHAPE
from .decoders import FORMATS, acceptor
from .sentences import Writer

# What the grammar allows for the sake of macros, or what needs names: `check` has the last word there.
LOOSE: frozenset[Expression] = frozenset({
    Literal("else"), Literal("=>"), Ref("definition"), Literal("scene"), Literal("param"), Ref("set_form"),
    Ref("import_form"), Literal("_"),
})  # fmt: skip
NAMES = ("list", "append", "car", "sphere?", "deg", "min", "iota", "->x", "*", "<=")
TOKENS = {
    "NUMBER": ("1", "-2.5", ".5", "1e-3"), "STRING": ('"cube"', '"a\\n"', '""'), "BOOLEAN": ("#t", "#false"),
    "NONE": ("none",), "KEYWORD": (":scale", ":p0"), "HANDLE": ("<z1>", "<style*>"),
    "ANNOTATED_KEYWORD": (":c::Vector",), "TEMPLATE_SYMBOL": ("a", "if", "..."), "PATTERN_SYMBOL": ("a", "list"),
    "SYMBOL": ("a", "if", "else", "b"),
}  # fmt: skip


def _words(random: Random) -> Callable[[str], str]:
    """Tokens for sentences. Names are new each time, so that nothing is a macro by chance and nothing is there twice."""
    numbers = itertools.count()

    def word(terminal: str) -> str:
        if terminal in TOKENS:
            return random.choice(TOKENS[terminal])
        return f"n{next(numbers)}" + ("::List[Float]" if terminal == "ANNOTATED" else "")

    return word


def _shape_mistakes(text: str, strict: bool = False) -> list[str]:
    checked = Session(Options(strict=strict)).check(Source("<test>", text))
    codes = SHAPE - {"E212"}  # which explains other mistakes too
    codes = codes | {"E210"} if strict else codes - {"E205"}
    return [f"{CODES[d.name].code} {d.message}" for d in checked.diagnostics if CODES[d.name].code in codes]


@settings(deadline=None)
@given(st.integers(0, 10**9))
def test_sentences_of_the_grammar_have_the_right_shape(seed: int) -> None:
    random = Random(seed)
    writer = Writer(full_grammar(), random, _words(random), LOOSE)
    text = " ".join(writer.sentence("top", 12))
    assert not _shape_mistakes(text), text
    assert all(acceptor(form)(text.encode()) for form in FORMATS), text


@settings(deadline=None)
@given(st.integers(0, 10**9))
def test_sentences_of_the_strict_grammar_are_strict(seed: int) -> None:
    random = Random(seed)
    writer = Writer(strict_grammar(), random, _words(random), frozenset())
    text = " ".join(writer.sentence("start", 12))
    assert not _shape_mistakes(text, strict=True), text
    assert all(acceptor(form, True)(text.encode()) for form in FORMATS), text
    assert all(acceptor(form)(text.encode()) for form in FORMATS), text


# --- programs changed in one place ---------------------------------------------------------------------------------


@cache
def forms_of(path: Path) -> list[Datum]:
    return read(Source(path.name, path.read_text("utf-8"))).forms


PLACE = Span(Source("<test>", ""), 0, 0)
NEW = [Atom(Symbol("if"), PLACE), Atom("text", PLACE), Atom(3, PLACE), ListDatum((), None, PLACE),
       ArrayDatum((Atom(1, PLACE),), PLACE), Atom(Symbol("x"), PLACE)]  # fmt: skip


def _changed(datum: Datum, random: Random) -> Datum:
    """The datum with one change somewhere in it."""
    if isinstance(datum, Atom) or not datum.items or random.random() < 0.15:
        return random.choice([*NEW, ListDatum((datum,), None, PLACE)])
    items = list(datum.items)
    position = random.randrange(len(items))
    kind = random.choice(("drop", "double", "swap", "brackets", "inside", "inside", "inside", "inside"))
    if kind == "drop":
        del items[position]
    elif kind == "double":
        items.insert(position, items[position])
    elif kind == "swap":
        items[position], items[0] = items[0], items[position]
    elif kind == "inside":
        items[position] = _changed(items[position], random)
    square = isinstance(datum, ArrayDatum) != (kind == "brackets")
    return ArrayDatum(tuple(items), PLACE) if square else ListDatum(tuple(items), None, PLACE)


@settings(deadline=None)
@given(st.integers(0, len(GOOD) - 1), st.integers(0, 10**9))
def test_a_program_that_is_rejected_has_a_mistake(file: int, seed: int) -> None:
    random = Random(seed)
    changed = list(forms_of(GOOD[file]))
    position = random.randrange(len(changed))
    changed[position] = _changed(changed[position], random)
    text = "\n".join(map(print_datum, changed))
    verdicts = {form: acceptor(form)(text.encode()) for form in FORMATS}
    assert len(set(verdicts.values())) == 1, (verdicts, print_datum(changed[position]))
    if not verdicts["llguidance"]:
        assert any(d.is_error for d in Session().check(Source("<test>", text)).diagnostics), print_datum(
            changed[position]
        )
