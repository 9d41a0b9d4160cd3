"""Services that do not answer, or do not stop: left within bounds, with one line that says so."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from models.server import Said, serving
from models.services import anthropic_at, hurry, one_line, request, set_apart
from scenelang.backends.language_models.catalogue import StopReason
from scenelang.backends.language_models.provider import MAX_REPLY_LENGTH, connect
from scenelang.grammar.diagnostics import SceneError


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    set_apart(monkeypatch, tmp_path)
    hurry(monkeypatch)


@pytest.fixture
def silent() -> Iterator[str]:
    """The address of a service that takes connections and says nothing."""
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen(16)
        yield f"http://127.0.0.1:{listening.getsockname()[1]}"


@pytest.mark.parametrize(("family", "variable"), [("anthropic", "ANTHROPIC_BASE_URL"), ("openai", "OPENAI_BASE_URL")])
def test_a_service_that_never_answers(family: str, variable: str, silent: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(variable, silent)
    provider = connect(family, timeout=0.2)
    with pytest.raises(SceneError) as caught:
        provider.send(request(), lambda _: None)
    assert caught.value.name == "model-offline"
    assert "within 0.2 seconds, after several attempts" in one_line(caught.value)


def test_an_answer_without_end_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("x" * (MAX_REPLY_LENGTH + 100_000))]) as server:
        provider = anthropic_at(server.url, monkeypatch)
        reply = provider.send(replace(request(), max_tokens=10_000_000), lambda _: None)
    assert reply.stop is StopReason.INTERRUPTED
    assert f"longer than {MAX_REPLY_LENGTH:,} characters" in reply.note
    assert len(reply.text) <= MAX_REPLY_LENGTH + 100_000
