"""Claude by the Messages API: what is sent, what is made of every kind of answer, and how often anything is sent."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from models.server import RESPONSES_PER_PIECE, ModelServer, Said, serving
from models.services import KEY, anthropic_at, hurry, one_line, request, set_apart
from scenelang.backends.language_models.catalogue import (
    ImageContent,
    Message,
    Reply,
    Request,
    StopReason,
    TextContent,
    Usage,
    find_model,
    text_message,
)
from scenelang.backends.language_models.client import Budget, Client
from scenelang.backends.language_models.openai_chat import estimate_tokens
from scenelang.backends.language_models.provider import connect
from scenelang.grammar.diagnostics import SceneError

ASKED = request()
TRIES = 3  # the SDK's: one and two more
LONG = "".join(f"line {i}\n" for i in range(60))


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    set_apart(monkeypatch, tmp_path)
    hurry(monkeypatch)


def quiet(_: str) -> None:
    pass


def client_at(url: str, monkeypatch: pytest.MonkeyPatch, limit: float = 5.0) -> Client:
    return Client(anthropic_at(url, monkeypatch), find_model("claude-opus-5-5"), Budget(limit), None)


def answered(
    monkeypatch: pytest.MonkeyPatch, *script: Said, asked: Request = ASKED
) -> tuple[Reply, list[str], ModelServer]:
    """The reply of a server, the pieces that were told as they arrived, and the server."""
    pieces: list[str] = []
    with serving(script) as server:
        reply = anthropic_at(server.url, monkeypatch).send(asked, pieces.append)
    return reply, pieces, server


def refused(monkeypatch: pytest.MonkeyPatch, answer: Said) -> tuple[SceneError, ModelServer]:
    with serving([answer] * 2 * TRIES) as server, pytest.raises(SceneError) as caught:
        anthropic_at(server.url, monkeypatch).send(ASKED, quiet)
    return caught.value, server


# --- what is sent ----------------------------------------------------------------------------------------------------


def test_all_that_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    picture = ImageContent("image/jpeg", b"\xff\xd8 a picture \xff")
    turns = (
        Message("user", (picture, TextContent("a chair", is_cacheable=True))),
        text_message("assistant", "a program"),
        text_message("user", "mend it"),
    )
    asked = replace(ASKED, messages=turns, thinking="adaptive", effort="high", grammar='root ::= "a"')
    _, _, server = answered(monkeypatch, Said("yes"), asked=asked)
    kept = {"cache_control": {"type": "ephemeral"}}
    data = base64.b64encode(picture.data).decode()
    assert server.requests == [
        {
            "model": "claude-opus-5-5",
            "max_tokens": 1000,
            "stream": True,
            "system": [{"type": "text", "text": "rules", **kept}],
            "thinking": {"type": "adaptive"},
            "output_config": {"effort": "high"},
            "messages": [
                {
                    "role": "user",
                    "content": [
                        {"type": "image", "source": {"type": "base64", "media_type": "image/jpeg", "data": data}},
                        {"type": "text", "text": "a chair", **kept},
                    ],
                },
                {"role": "assistant", "content": [{"type": "text", "text": "a program"}]},
                {"role": "user", "content": [{"type": "text", "text": "mend it"}]},
            ],
        }
    ]
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"


def test_nothing_is_sent_that_was_not_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    _, _, server = answered(monkeypatch, Said("yes"))
    assert set(server.requests[0]) == {"model", "max_tokens", "stream", "system", "messages"}
    assert server.requests[0]["messages"][-1]["role"] == "user"


def test_no_credential_of_the_environment_goes_along(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_AUTH_TOKEN", "another-secret-token")
    _, _, server = answered(monkeypatch, Said("yes"))
    assert "another-secret-token" not in json.dumps(server.headers)


def test_counting_sends_the_prompt_and_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([]) as server:
        server.count = lambda body: 4321
        provider = anthropic_at(server.url, monkeypatch)
        assert provider.count(replace(ASKED, thinking="adaptive", effort="low")) == 4321
    assert [set(body) for body in server.counted] == [{"model", "system", "messages", "thinking"}]
    assert server.counted[0]["messages"] == [{"role": "user", "content": [{"type": "text", "text": "a cube"}]}]


@pytest.mark.parametrize("status", [400, 404, 500])
def test_where_counting_fails_tokens_are_estimated(status: int, monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([]) as server:
        server.count = lambda body: -status
        assert anthropic_at(server.url, monkeypatch).count(ASKED) == estimate_tokens(ASKED)
    assert len(server.counted) == (TRIES if status == 500 else 1)


def test_a_wrong_key_is_told_before_anything_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([]) as server:
        server.count = lambda body: -401
        with pytest.raises(SceneError) as caught:
            client_at(server.url, monkeypatch).ask(ASKED, 1, 1, quiet)
    assert caught.value.name == "model-key"
    assert server.requests == []


# --- answers ---------------------------------------------------------------------------------------------------------


def test_pieces_are_told_in_the_order_in_which_they_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    usage = {"input_tokens": 11, "cache_read_input_tokens": 22, "cache_creation_input_tokens": 33, "output_tokens": 44}
    reply, pieces, _ = answered(monkeypatch, Said(LONG, usage=usage))
    assert pieces == [LONG[i : i + RESPONSES_PER_PIECE] for i in range(0, len(LONG), RESPONSES_PER_PIECE)]
    assert reply == Reply(LONG, StopReason.END, Usage(11, 22, 33, 44), "claude-opus-5-5")


def test_thinking_is_neither_told_nor_part_of_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    reply, pieces, _ = answered(monkeypatch, Said("a cube", thinks=True))
    assert (pieces, reply.text, reply.blocks) == (["a cube"], "a cube", ())


def test_half_characters_become_whole_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """An event may end amid a pair of surrogates, and a model may say one alone."""
    text = "." * (RESPONSES_PER_PIECE - 1) + "\ud83d\ude00 and \ud800"
    reply, _, _ = answered(monkeypatch, Said(text))
    assert reply.text == "." * (RESPONSES_PER_PIECE - 1) + "\U0001f600 and \ufffd"


def test_what_watches_can_stop_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its exception is its own, and no broken stream that would be asked for anew."""

    def stop(_: str) -> None:
        raise OSError("the terminal is gone")

    with serving([Said(LONG)]) as server, pytest.raises(OSError, match="the terminal is gone"):
        anthropic_at(server.url, monkeypatch).send(ASKED, stop)


STOPS = [
    ("end_turn", StopReason.END),
    ("stop_sequence", StopReason.END),
    ("max_tokens", StopReason.MAX_TOKENS),
    ("model_context_window_exceeded", StopReason.CONTEXT_FULL),
    ("refusal", StopReason.REFUSED),
    ("pause_turn", StopReason.PAUSED),
    ("something_new", StopReason.INTERRUPTED),
]


@pytest.mark.parametrize(("reason", "stop"), STOPS)
def test_every_reason_to_stop(reason: str, stop: StopReason, monkeypatch: pytest.MonkeyPatch) -> None:
    reply, _, _ = answered(monkeypatch, Said("half", stop=reason))
    assert (reply.stop, reply.text) == (stop, "half")
    assert reply.note == ("unknown stop reason `something_new`" if stop is StopReason.INTERRUPTED else "")


def test_a_refusal_explains_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    details = {"type": "refusal", "category": "bio", "explanation": "It could do harm."}
    reply, _, _ = answered(monkeypatch, Said("", stop="refusal", details=details))
    assert (reply.stop, reply.note) == (StopReason.REFUSED, "It could do harm.")
    reply, _, _ = answered(monkeypatch, Said("", stop="refusal", details=details | {"explanation": None}))
    assert reply.note == "bio"


# --- streams that break ------------------------------------------------------------------------------------------------


def broken(monkeypatch: pytest.MonkeyPatch, answer: Said) -> Reply:
    """An answer that breaks off is no error, is asked for once, and costs what was set aside for it."""
    with serving([answer]) as server:
        client = client_at(server.url, monkeypatch)
        got = client.ask(ASKED, 1, 1, quiet)
    assert len(server.requests) == 1
    assert got.reply.stop is StopReason.INTERRUPTED
    assert got.cost == client.budget.spent == client.model.max_cost(len(json.dumps(server.counted[0])) // 4, 1000)
    return got.reply


@pytest.mark.parametrize("after", [0, 2 * RESPONSES_PER_PIECE])
def test_a_connection_that_breaks_in_an_answer(after: int, monkeypatch: pytest.MonkeyPatch) -> None:
    reply = broken(monkeypatch, Said(LONG, breaks_after=after))
    assert reply.text == LONG[:after]
    assert reply.note
    assert reply.usage.sent == 1000
    assert reply.usage.answered >= after / 4


def test_an_error_within_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    reply = broken(monkeypatch, Said(LONG, breaks_after=64, is_error_event=True))
    assert (reply.text, reply.note) == (LONG[:64], "overloaded in mid-stream")


GARBLED = [
    "event: content_block_delta\ndata: {broken\n\n",
    'event: content_block_delta\ndata: {"type": "content_block_delta", "index": 77, "delta": {"type": "text_delta", "text": "x"}}\n\n',
    'event: content_block_delta\ndata: {"type": "content_block_delta"}\n\n',
    'event: message_delta\ndata: {"type": "message_delta"}\n\n',
    'event: message_delta\ndata: {"type": "message_delta", "delta": {"stop_reason": "end_turn", "stop_sequence": null}, "usage": {"output_tokens": "x"}}\n\nevent: message_stop\ndata: {"type": "message_stop"}\n\n',
    "event: message_delta\ndata: [1, 2]\n\n",
    'event: message_delta\ndata: "text"\n\n',
    "\ufffd\x00\n\n",
]


@pytest.mark.parametrize("words", GARBLED)
def test_events_that_make_no_sense(words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert broken(monkeypatch, Said(LONG, breaks_after=64, last_words=words)).text.startswith(LONG[:64])


# --- errors ------------------------------------------------------------------------------------------------------------

ERRORS = [
    (400, "model-request", 1, "rejected the request (400): why", None),
    (401, "model-key", 1, "rejected the API key (401): why", "check it in the environment"),
    (402, "model-key", 1, "no credit (402): why", None),
    (403, "model-key", 1, "the API key lacks the permission (403): why", None),
    (404, "model-request", 1, "unknown model or base URL (404): why", "--model"),
    (413, "model-request", 1, "the request is too large (413): why", "send smaller or fewer images"),
    (429, "model-request", TRIES, "the rate limit of the account is exceeded (429): why", "--resume"),
    (500, "model-request", TRIES, "the service failed (500): why", "later"),
    (503, "model-request", TRIES, "the service failed (503): why", "later"),
    (529, "model-request", TRIES, "overloaded (529): why", "--resume"),
]


@pytest.mark.parametrize(("status", "name", "tries", "message", "hint"), ERRORS)
def test_an_error_is_one_line(
    status: int, name: str, tries: int, message: str, hint: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    error, server = refused(monkeypatch, Said("why\n  so", status=status))
    assert error.name == name
    assert f"{message} so" in one_line(error)
    assert (hint is None) == (error.hint is None)
    assert hint is None or hint in (error.hint or "")
    assert len(server.requests) == tries


def test_a_long_error_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    error, _ = refused(monkeypatch, Said("why " * 10_000, status=400))
    assert len(one_line(error)) < 500


def test_an_error_that_passes_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    reply, _, server = answered(monkeypatch, Said("busy", status=529), Said("a cube"))
    assert (reply.text, len(server.requests)) == ("a cube", 2)


def test_what_was_refused_costs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("no", status=400), Said("yes")]) as server:
        client = client_at(server.url, monkeypatch)
        with pytest.raises(SceneError):
            client.ask(ASKED, 1, 1, quiet)
        assert client.budget.spent == 0.0
        assert client.ask(ASKED, 1, 1, quiet).reply.text == "yes"


def test_a_connection_dropped_before_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    error, server = refused(monkeypatch, Said(drops=True))
    assert error.name == "model-offline"
    assert f"cannot reach {server.url}" in one_line(error)
    assert len(server.requests) == TRIES


def test_offline_is_one_line() -> None:
    with pytest.raises(SceneError) as caught:
        connect("anthropic").send(ASKED, quiet)
    assert caught.value.name == "model-offline"
    assert one_line(caught.value).startswith("cannot reach http://127.0.0.1:9: ")
    assert "--dry-run" in (caught.value.hint or "")


# --- pauses ------------------------------------------------------------------------------------------------------------


def test_a_paused_answer_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    script = [Said("one, ", stop="pause_turn", thinks=True), Said("two, ", stop="pause_turn"), Said("three")]
    with serving(script) as server:
        client = client_at(server.url, monkeypatch)
        answer = client.ask(ASKED, 1, 1, quiet)
    first = [
        {"type": "thinking", "thinking": "hm", "signature": "c2ln"},
        {"type": "text", "text": "one, "},
    ]
    asked = {"role": "user", "content": [{"type": "text", "text": "a cube"}]}
    sent = [_bare(body["messages"]) for body in server.requests]
    assert sent[0] == [asked]
    assert sent[1] == [asked, {"role": "assistant", "content": first}]
    assert sent[2] == [*sent[1], {"role": "assistant", "content": [{"type": "text", "text": "two, "}]}]
    assert (answer.reply.text, answer.reply.stop, answer.reply.usage.sent) == ("one, two, three", StopReason.END, 3000)
    each = [client.model.cost(Usage(1000, answered=1)) for _ in range(3)]
    assert answer.cost == pytest.approx(sum(each)) == pytest.approx(client.budget.spent)


def _bare(messages: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Messages without what blocks say of nothing."""
    return [
        turn | {"content": [{k: v for k, v in block.items() if v is not None} for block in turn["content"]]}
        for turn in messages
    ]


def test_endless_pauses_end(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(lambda body: Said("and ", stop="pause_turn")) as server:
        answer = client_at(server.url, monkeypatch).ask(ASKED, 1, 1, quiet)
    assert len(server.requests) == 8
    assert (answer.reply.stop, answer.reply.text) == (StopReason.INTERRUPTED, "and " * 8)
    assert answer.reply.usage.sent == 8000


def test_pauses_stop_where_the_money_does(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(lambda body: Said("and ", stop="pause_turn")) as server:
        client = client_at(server.url, monkeypatch, limit=0.03)  # 1000 tokens of answer are $0.02
        with pytest.raises(SceneError) as caught:
            client.ask(ASKED, 1, 1, quiet)
    assert caught.value.name == "model-cost"
    assert 1 <= len(server.requests) < 8
    assert client.budget.spent <= 0.03


# --- a server that repeats secrets -------------------------------------------------------------------------------------


@pytest.fixture
def echo() -> dict[str, str]:
    return {"request-id": KEY, "x-api-key": KEY}


def test_an_echoed_key_is_not_in_an_answer(echo: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    text = "." * (RESPONSES_PER_PIECE - 8) + f"{KEY} is it"  # in two events
    details = {"type": "refusal", "category": None, "explanation": f"not with {KEY}"}
    reply, _, _ = answered(monkeypatch, Said(text, model=f"claude {KEY}", headers=echo))
    assert KEY not in repr(reply)
    assert reply.text.endswith("[key] is it")
    reply, _, _ = answered(monkeypatch, Said("", stop="refusal", details=details))
    assert reply.note == "not with [key]"
    reply, _, _ = answered(monkeypatch, Said("", stop=KEY))
    assert KEY not in repr(reply)


def test_an_echoed_key_is_not_in_a_broken_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    event = {"type": "error", "error": {"type": "api_error", "message": f"bad {KEY}"}}
    words = f"event: error\ndata: {json.dumps(event)}\n\n"
    reply = broken(monkeypatch, Said(f"{KEY}{LONG}", breaks_after=64, last_words=words))
    assert reply.note == "bad [key]"
    assert KEY not in repr(reply)
    reply = broken(monkeypatch, Said("", breaks_after=0, last_words=f"event: error\ndata: {KEY} {{\n\n"))
    assert KEY not in repr(reply)


@pytest.mark.parametrize("status", [400, 401, 500])
def test_an_echoed_key_is_not_in_an_error(status: int, echo: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    error, _ = refused(monkeypatch, Said(f"x{'y' * 290}{KEY} {KEY}", status=status, headers=echo))
    assert KEY[:9] not in one_line(error)
    assert KEY not in repr(error)
