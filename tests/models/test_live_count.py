"""The line that counts answers as they arrive."""

from __future__ import annotations

import io

import pytest

from scenelang.inference import conductor
from scenelang.inference.conductor import LiveCount


def test_tokens_and_lines_of_answers_side_by_side(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conductor, "_BETWEEN", 0.0)
    stream = io.StringIO()
    live = LiveCount(stream)
    first, second = live.counting(1, 1, "draft"), live.counting(2, 1, "draft")
    first("x" * 35 + "\n" * 2)
    second("y" * 70)
    first("z" * 3_500)
    shown = stream.getvalue().split("\r")
    assert shown[-1].rstrip() == "sample 1 draft: ~1,011 tokens, 2 lines; sample 2 draft: ~20 tokens, 0 lines"
    live.end()
    assert stream.getvalue().endswith("\r")  # the line is gone
    assert stream.getvalue().split("\r")[-2].strip() == ""


def test_a_new_answer_of_a_sample_takes_the_place_of_the_last() -> None:
    stream = io.StringIO()
    live = LiveCount(stream)
    live.counting(1, 1, "draft")("abc")
    live.counting(1, 2, "repair")
    assert stream.getvalue().split("\r")[-1].rstrip() == "sample 1 repair: waiting for the service"


def test_batches_and_no_terminal() -> None:
    stream = io.StringIO()
    LiveCount(stream).waiting(3)
    assert stream.getvalue().strip() == "waiting for a batch: 3 requests left"
    silent = LiveCount(None)
    silent.counting(1, 1, "draft")("abc")
    silent.end()
