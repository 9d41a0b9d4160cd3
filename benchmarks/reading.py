"""The front end in this process: reading, checking and formatting programs."""

from __future__ import annotations

import json

from measuring import ROOT, Goal, Pair, Row, timed
from programs import reader_text

PUBLISHED = ROOT / "tests" / "corpus" / "n16-newtons-cradle.scene"


def read_beside_json() -> list[Pair]:
    from scenelang.grammar.datum import Source
    from scenelang.grammar.reader import read

    text = reader_text(100_000)
    table = {ord("("): "[", ord(")"): "],"}
    ours, other = (lambda: read(Source("<bench>", text))), (lambda: json.loads(json.dumps(text.translate(table))))
    return [Pair(timed(ours), timed(other))]


def check_beside_reading() -> list[Pair]:
    from scenelang.grammar.datum import Source
    from scenelang.grammar.reader import read
    from scenelang.session.session import Session

    session, text = Session(), reader_text(20_000)
    return [Pair(timed(lambda: session.check(Source("<bench>", text))), timed(lambda: read(Source("<bench>", text))))]


def check_published() -> list[Pair]:
    from scenelang.grammar.datum import Source
    from scenelang.session.session import Session

    session, text = Session(), PUBLISHED.read_text("utf-8")
    return [Pair(timed(lambda: session.check(Source("<bench>", text))))]


def format_beside_check() -> list[Pair]:
    from scenelang.grammar.datum import Source
    from scenelang.grammar.formatter import format_text
    from scenelang.interpreter.expand.forms import INDENTS
    from scenelang.session.session import Session

    session, text = Session(), reader_text(100_000)
    check = timed(lambda: session.check(Source("<bench>", text)))
    return [Pair(timed(lambda: format_text(text, INDENTS)), check)]


ROWS = (
    Row("read 100 KB of text", read_beside_json, "json of the same bytes", counts=True),
    Row("check 20 KB (expand, analyse)", check_beside_reading, "reading it", counts=True),
    Row("check a program of 4 KB", check_published, goals=(Goal(0.003, "ours"),), counts=True),
    Row("format 100 KB", format_beside_check, "check", rounds=3),
)
