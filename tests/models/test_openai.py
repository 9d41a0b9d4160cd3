"""Servers of chat completions: what is sent in each dialect, and what is made of their answers."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from pathlib import Path

import pytest

from models.chat_server import LETTERS_PER_PIECE, Chat, ChatServer, chatting
from models.services import KEY, configure, hurry, one_line, openai_at, request, set_apart
from scenelang.backends.language_models.catalogue import (
    ImageContent,
    Message,
    Reply,
    StopReason,
    TextContent,
    Usage,
    text_message,
)
from scenelang.backends.language_models.client import Budget, Client
from scenelang.backends.language_models.openai_chat import estimate_tokens, max_token_count
from scenelang.backends.language_models.provider import connect
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.export.notations import gbnf_text
from scenelang.inference.brief import Notation
from scenelang.inference.records import InferenceSettings
from scenelang.interpreter.expand.forms import full_grammar

ASKED = request(model="qwen")
TRIES = 3  # the package's: one and two more
LONG = "".join(f"line {i}\n" for i in range(20))


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    set_apart(monkeypatch, tmp_path)
    hurry(monkeypatch)


def quiet(_: str) -> None:
    pass


def answered(monkeypatch: pytest.MonkeyPatch, chat: Chat) -> tuple[Reply, list[str], ChatServer]:
    pieces: list[str] = []
    with chatting([chat]) as server:
        reply = openai_at(server.url, monkeypatch).send(ASKED, pieces.append)
    assert len(server.requests) == 1
    return reply, pieces, server


# --- what is sent ----------------------------------------------------------------------------------------------------


def test_all_that_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    picture = ImageContent("image/webp", b"RIFF a picture")
    turns = (
        Message("user", (picture, TextContent("a chair"))),
        text_message("assistant", "a program"),
        text_message("user", "mend it"),
    )
    with chatting([Chat("yes")]) as server:
        monkeypatch.setenv("OPENAI_API_KEY", KEY)
        openai_at(server.url, monkeypatch).send(replace(ASKED, messages=turns, effort="low"), quiet)
    data = base64.b64encode(picture.data).decode()
    assert server.requests == [
        {
            "model": "qwen",
            "max_tokens": 1000,
            "reasoning_effort": "low",
            "stream": True,
            "stream_options": {"include_usage": True},
            "messages": [
                {"role": "system", "content": "rules"},
                {
                    "role": "user",
                    "content": [
                        {"type": "image_url", "image_url": {"url": f"data:image/webp;base64,{data}"}},
                        {"type": "text", "text": "a chair"},
                    ],
                },
                {"role": "assistant", "content": "a program"},
                {"role": "user", "content": "mend it"},
            ],
        }
    ]
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"
    assert server.probed == []  # without a grammar it does not matter which server it is


def test_the_key_of_another_service_is_not_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    _, _, server = answered(monkeypatch, Chat("yes"))
    assert KEY not in json.dumps([server.headers, server.requests])


# --- grammars ----------------------------------------------------------------------------------------------------------

DIALECTS = [("llama.cpp", ["grammar"]), ("vllm", ["structured_outputs", "grammar"]), ("plain", None)]


def sent_grammar(body: dict[str, object], path: list[str] | None) -> object:
    """What lies at a path of a request, which may say nothing of grammars anywhere else."""
    found: object = body.pop(path[0]) if path else None
    for name in path[1:] if path else ():
        assert isinstance(found, dict)
        assert set(found) == {name}
        found = found[name]
    assert not {"grammar", "structured_outputs", "guided_grammar", "response_format"} & set(body)
    return found


@pytest.mark.parametrize(("kind", "path"), DIALECTS)
def test_a_grammar_goes_where_the_server_takes_it(
    kind: str, path: list[str] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    with chatting([Chat("yes")] * 2, kind) as server:
        provider = openai_at(server.url, monkeypatch)
        for _ in range(2):
            provider.send(replace(ASKED, grammar='root ::= "a"'), quiet)
    assert server.probed == ["/props"] if kind == "llama.cpp" else ["/props", "/version"]  # asked once
    assert [sent_grammar(body, path) for body in server.requests] == [path and 'root ::= "a"'] * 2


@pytest.mark.parametrize(("kind", "path"), DIALECTS)
def test_the_language_is_asked_for_with_its_grammar(
    kind: str,
    path: list[str] | None,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    answer = '```scene\n(bind "box" (lambda () (primitive "cube")))\n```'.replace("primitive", "call")
    with chatting([Chat(answer)], kind) as server:
        monkeypatch.setenv("OPENAI_BASE_URL", server.url)
        output = tmp_path / "box.scene"
        words = ["generate", "a box", "--provider", "openai", "--model", "qwen", "--dsl", "-o", str(output)]
        code = main(words)
    assert code == 0, capsys.readouterr().err
    (body,) = server.requests
    assert sent_grammar(body, path) == (gbnf_text(full_grammar()) if path else None)
    assert '(call "cube")' in output.read_text()


def test_python_is_asked_for_without_a_grammar() -> None:
    model = InferenceSettings(provider="openai", model="qwen", price="1,2").known_model(None)
    assert InferenceSettings(provider="openai").speaker(model, Notation.PYTHON).grammar is None


def test_the_configuration_says_which_dialect(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    configure(tmp_path, '[openai]\ngrammar = "vllm"\n')
    with chatting([Chat("yes")], "llama.cpp") as server:
        openai_at(server.url, monkeypatch).send(replace(ASKED, grammar="root"), quiet)
    assert server.probed == []
    assert server.requests[0]["structured_outputs"] == {"grammar": "root"}


def test_a_dialect_that_there_is_not(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    configure(tmp_path, '[openai]\ngrammar = "latin"\n')
    with chatting([]) as server, pytest.raises(SceneError, match=r"one of llama\.cpp, vllm, none"):
        openai_at(server.url, monkeypatch).send(replace(ASKED, grammar="root"), quiet)


# --- answers ---------------------------------------------------------------------------------------------------------


def test_pieces_are_told_in_the_order_in_which_they_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    reply, pieces, _ = answered(monkeypatch, Chat(LONG))
    assert pieces == [LONG[i : i + LETTERS_PER_PIECE] for i in range(0, len(LONG), LETTERS_PER_PIECE)]
    assert reply == Reply(LONG, StopReason.END, Usage(100, answered=20), "qwen")


@pytest.mark.parametrize(
    ("told", "usage"),
    [
        ({"prompt_tokens": 100, "completion_tokens": 20}, Usage(100, answered=20)),
        (
            {"prompt_tokens": 100, "completion_tokens": 20, "prompt_tokens_details": {"cached_tokens": 64}},
            Usage(36, cache_read=64, answered=20),
        ),
        ({"prompt_tokens": 100, "completion_tokens": 20, "prompt_tokens_details": None}, Usage(100, answered=20)),
        ({"prompt_tokens": 9, "prompt_tokens_details": {"cached_tokens": 64}}, Usage(0, cache_read=64)),
        (None, Usage(estimate_tokens(ASKED), answered=max_token_count(LONG))),
    ],
)
def test_tokens(told: dict[str, object] | None, usage: Usage, monkeypatch: pytest.MonkeyPatch) -> None:
    reply, _, _ = answered(monkeypatch, Chat(LONG, usage=told))
    assert reply.usage == usage
    assert reply.stop is StopReason.END


@pytest.mark.parametrize(
    ("reason", "stop", "note"),
    [
        ("stop", StopReason.END, ""),
        ("length", StopReason.MAX_TOKENS, ""),
        ("content_filter", StopReason.REFUSED, ""),
        ("abort", StopReason.INTERRUPTED, "unknown stop reason `abort`"),
        (None, StopReason.INTERRUPTED, "the stream ended early"),
    ],
)
def test_every_reason_to_stop(reason: str | None, stop: StopReason, note: str, monkeypatch: pytest.MonkeyPatch) -> None:
    reply, _, _ = answered(monkeypatch, Chat("half", stop=reason))
    assert (reply.text, reply.stop, reply.note) == ("half", stop, note)


def test_a_refusal_explains_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    reply, pieces, _ = answered(monkeypatch, Chat("", refusal="I will not."))
    assert (reply.stop, reply.note.strip(), pieces) == (StopReason.REFUSED, "I will not.", [])


def test_servers_may_leave_out_what_they_have_nothing_to_say_about(monkeypatch: pytest.MonkeyPatch) -> None:
    pieces = [
        "{}",
        '{"choices": null}',
        '{"choices": [{"index": 0}]}',
        '{"choices": [{"index": 0, "delta": null}]}',
        '{"choices": [{"index": 0, "delta": {"content": "a "}}]}',
        '{"choices": [{"index": 0, "delta": {"content": "cube"}, "finish_reason": "stop"}]}',
        '{"usage": {"prompt_tokens": 5}}',
    ]
    reply, _, _ = answered(monkeypatch, Chat(pieces=pieces))
    assert reply == Reply("a cube", StopReason.END, Usage(5), "qwen")


def test_half_characters_become_whole_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "." * (LETTERS_PER_PIECE - 1) + "\ud83d\ude00 and \ud800"
    reply, _, _ = answered(monkeypatch, Chat(text, usage=None))
    assert reply.text == "." * (LETTERS_PER_PIECE - 1) + "\U0001f600 and \ufffd"


BROKEN = [
    Chat(LONG, breaks_after=0),
    Chat(LONG, breaks_after=64),
    Chat(LONG, breaks_after=64, last_words="data: {broken\n\n"),
    Chat(LONG, breaks_after=64, last_words='data: {"error": {"message": "out of memory"}}\n\n'),
    Chat(LONG, breaks_after=64, last_words='data: {"choices": [{"delta": {"content": 5}}]}\n\n'),
    Chat(LONG, breaks_after=64, last_words='data: {"usage": {"completion_tokens": "many"}}\n\n'),
    Chat(LONG, breaks_after=64, last_words='data: {"model": 5, "choices": [{"finish_reason": {"a": []}}]}\n\n'),
]


@pytest.mark.parametrize("chat", BROKEN)
def test_an_answer_that_breaks_off(chat: Chat, monkeypatch: pytest.MonkeyPatch) -> None:
    reply, _, _ = answered(monkeypatch, chat)
    assert reply.stop is StopReason.INTERRUPTED
    assert reply.text == LONG[: chat.breaks_after]
    assert reply.note
    assert ("out of memory" in chat.last_words) == (reply.note == "out of memory")
    assert reply.usage.prompt > 0


def test_what_watches_can_stop_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(_: str) -> None:
        raise OSError("the terminal is gone")

    with chatting([Chat(LONG)]) as server, pytest.raises(OSError, match="the terminal is gone"):
        openai_at(server.url, monkeypatch).send(ASKED, stop)


# --- errors ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("status", "name", "tries"),
    [
        (400, "model-request", 1),
        (401, "model-key", 1),
        (404, "model-request", 1),
        (429, "model-request", TRIES),
        (500, "model-request", TRIES),
        (503, "model-request", TRIES),
    ],
)
def test_an_error_is_one_line(status: int, name: str, tries: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    with chatting([Chat(f"why\nso {KEY}", status=status)] * TRIES) as server, pytest.raises(SceneError) as caught:
        openai_at(server.url, monkeypatch).send(ASKED, quiet)
    assert caught.value.name == name
    assert f"({status}): " in one_line(caught.value)
    assert "why so [key]" in caught.value.message
    assert len(server.requests) == tries


def test_an_echoed_key_is_not_in_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    reply, _, _ = answered(monkeypatch, Chat(f"it is {KEY}!", model=f"m-{KEY}"))
    assert (reply.text, reply.model) == ("it is [key]!", "m-[key]")
    reply, _, _ = answered(monkeypatch, Chat("", refusal=f"not with {KEY} though"))
    assert reply.note.strip() == "not with [key] though"


def test_offline_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SceneError) as caught:
        openai_at("http://127.0.0.1:9/v1", monkeypatch).send(replace(ASKED, grammar="root"), quiet)
    assert caught.value.name == "model-offline"
    assert one_line(caught.value).startswith("cannot reach http://127.0.0.1:9/v1: ")


# --- keys, prices, batches -----------------------------------------------------------------------------------------------


def test_a_server_on_this_machine_needs_neither_key_nor_price(monkeypatch: pytest.MonkeyPatch) -> None:
    with chatting([Chat(LONG)]) as server:
        monkeypatch.setenv("OPENAI_BASE_URL", server.url)
        client = InferenceSettings(provider="openai", model="qwen", uses_replies=False).client()
        assert client.ask(ASKED, 1, 1, quiet).cost == 0.0
    assert client.max_cost(ASKED) == 0.0


@pytest.mark.parametrize(
    "address", ["https://models.example.com/v1", "http://192.168.1.7/v1", "http://localhost.example.com"]
)
def test_other_servers_have_a_price(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_BASE_URL", address)
    with pytest.raises(SceneError) as caught:
        InferenceSettings(provider="openai", model="qwen").client()
    assert caught.value.name == "model-price"
    client = InferenceSettings(provider="openai", model="qwen", price="1,2").client()
    assert client.max_cost(ASKED) == pytest.approx((1.25 * estimate_tokens(ASKED) + 2 * 1000) / 1e6)


def test_a_model_has_to_be_named() -> None:
    with pytest.raises(SceneError, match="has no default model"):
        InferenceSettings(provider="openai").client()


def test_there_are_no_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client(
        connect("openai"),
        InferenceSettings(provider="openai", model="q", price="1,2").known_model(None),
        Budget(5),
        None,
    )
    with pytest.raises(SceneError, match="does not support batches"):
        client.batches()
