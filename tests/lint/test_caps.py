"""Huge numbers of findings: what is shown is bounded, and what is left out is counted."""

from __future__ import annotations

import json
from typing import Any

from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, capped, render_text
from scenelang.session.session import Session


def findings(errors: int, warnings: int, length: int = 20) -> list[Diagnostic]:
    return [
        *(Diagnostic("unused", f"{n} {'x' * length}") for n in range(warnings)),
        *(Diagnostic("unbound", f"{n} {'x' * length}") for n in range(errors)),
    ]


def test_few_findings_stay() -> None:
    assert capped(findings(50, 50)) == findings(50, 50)


def test_many_are_cut_and_counted_errors_first() -> None:
    shown = capped(findings(30, 500))
    assert len(shown) == 101
    assert sum(d.is_error for d in shown) == 30
    assert shown[-1].message == "430 more findings are not shown, 0 errors among them"
    assert [d.message.split()[0] for d in shown[:-1]] == [str(n) for n in (*range(70), *range(30))]


def test_long_ones_are_cut_by_size() -> None:
    shown = capped(findings(50, 0, 10_000))
    assert sum(len(render_text(d)) for d in shown) < 80_000
    assert shown[-1].message.endswith("errors among them")


def test_commands_show_no_more(tmp_path: Any, capsys: Any) -> None:
    path = tmp_path / "a.scene"
    path.write_text("\n".join(f"(undefined-{n})" for n in range(1000)))
    assert main(["check", str(path)]) == 1
    err = capsys.readouterr().err
    assert len(err) < 80_000
    assert "900 more findings are not shown, 900 errors among them" in err
    assert main(["check", "--json", str(path)]) == 1
    assert len(json.loads(capsys.readouterr().out)) <= 101


def test_a_name_of_a_million_characters_is_cut() -> None:
    text = f'(print {"x" * 1_000_000})\n(call "cube")'
    (problem,) = Session().check(Source("<a>", text)).diagnostics
    assert problem.message.startswith("`xxx")
    assert problem.message.endswith("xxx` is not defined")
    assert len(render_text(problem)) < 3_000
