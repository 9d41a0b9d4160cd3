"""Cameras and lights of a program in the REPL, in completion and in the reference."""

from __future__ import annotations

import pytest

from scenelang.interpreter.expand.forms import full_grammar
from scenelang.interpreter.scene.setup import PROPERTIES
from scenelang.repl.evaluation import ReplEvaluation, program_text
from scenelang.session.formatting import formatted
from scenelang.session.session import Session
from scenelang.stdlib.reference import lookup

VASE = '(bind "vase" (lambda () (call "cylinder")))'


def typed(*inputs: str) -> ReplEvaluation:
    evaluation = ReplEvaluation(Session())
    for text in inputs:
        outcome = evaluation.evaluate(evaluation.source(text))
        assert not [d for d in outcome.diagnostics if d.is_error], text
    return evaluation


def test_a_session_keeps_the_last_of_a_name() -> None:
    evaluation = typed(
        VASE, '(camera "a" :eye [0 0 5])', "(light :position [0 1 0])", '(environment "night")', "(light :position [1 1 0])",
        '(camera "a" :eye [0 0 7])', '(environment "sunny")',
    )  # fmt: skip
    stated = [item.to_plain() for item in evaluation.root().setup]
    assert [item["form"] for item in stated] == ["light", "light", "camera", "environment"]
    assert stated[2]["eye"] == [0.0, 0.0, 7.0]
    assert stated[3]["name"] == "sunny"
    assert '(camera "a" :eye [0 0 7])' in program_text(evaluation.top)


def test_what_fails_declares_nothing() -> None:
    evaluation = typed(VASE)
    outcome = evaluation.evaluate(evaluation.source('(begin (camera "a" :eye [0 0 5]) (error "no"))'))
    assert [d.name for d in outcome.diagnostics if d.is_error] == ["user"]
    assert evaluation.root().setup == ()


@pytest.mark.parametrize("form", PROPERTIES)
def test_every_keyword_is_in_the_reference(form: str) -> None:
    record = lookup(form)
    assert record is not None
    assert {name.lstrip(":") for name in record.keywords} == set(PROPERTIES[form])
    assert all(prop.doc in record.doc for prop in PROPERTIES[form].values())


def test_no_form_is_reserved() -> None:
    assert not any(f'"{name}"' in str(full_grammar().rules) for name in PROPERTIES)


def test_the_formatter_keeps_keywords_with_their_values() -> None:
    text = '(camera "main" :eye [3 2 5] :look-at "vase" :fov 35 :aperture .05 :focus 3 :roll 0 :orthographic #f :orbit 20)\n'
    lines = formatted(text).splitlines()
    assert all(line.split()[-1].startswith(":") is False for line in lines)
