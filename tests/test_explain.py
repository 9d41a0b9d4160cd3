"""The command explain, and where it is named."""

from __future__ import annotations

import argparse
import io
import json

import pytest

from scenelang.cli.main import main
from scenelang.cli.options import report
from scenelang.grammar.diagnostics import CODES, REMEDIES, Diagnostic


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("asked", ["E301", "e301", "unbound", "Unbound"])
def test_a_code_or_its_name(asked: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", asked]) == 0
    assert capsys.readouterr().out == f"E301 unbound\n  {CODES['unbound'].why}\n  {REMEDIES['unbound']}\n"


def test_several_and_all(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "W601", "arity"]) == 0
    assert [line[:4] for line in capsys.readouterr().out.splitlines() if line[:1] not in ("", " ")] == ["W601", "E402"]
    assert main(["explain"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(" ")[0] for line in lines] == sorted(entry.code for entry in CODES.values())


def test_as_data(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "E402", "--json"]) == 0
    (told,) = json.loads(capsys.readouterr().out)
    assert told == {"code": "E402", "name": "arity", "why": CODES["arity"].why, "remedy": REMEDIES["arity"]}
    assert main(["explain", "--json"]) == 0
    assert {each["name"] for each in json.loads(capsys.readouterr().out)} == set(CODES)


def test_an_unknown_code_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "unbond"]) == 2
    said = capsys.readouterr().err
    assert "unknown diagnostic code or name `unbond`" in said
    assert "did you mean `unbound`?" in said


@pytest.mark.parametrize(("quiet", "hint", "shown"), [(False, None, True), (False, "so", False), (True, None, False)])
def test_a_terminal_names_the_command_where_no_hint_helps(quiet: bool, hint: str | None, shown: bool) -> None:
    stream = Terminal()
    arguments = argparse.Namespace(quiet=quiet, json=False, no_color=True)
    report(
        arguments, [Diagnostic("duplicate", "twice", hint=hint), Diagnostic("duplicate", "again", hint=hint)], stream
    )
    assert stream.getvalue().endswith("scenelang explain E205\n") == shown
    plain = io.StringIO()
    report(arguments, [Diagnostic("duplicate", "twice")], plain)
    assert "explain" not in plain.getvalue()
