"""ReplyCache kept on disk: which question finds which, what is kept, and processes side by side."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest
from support import wait_until

from models.server import ModelServer, Said, serving
from models.services import KEY, anthropic_at, request, set_apart
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
from scenelang.backends.language_models.client import (
    Budget,
    Client,
    ReplyCache,
    digest_of,
    reply_cache_folder,
    reply_data,
    reply_of,
)

ASKED = request()
REPLY = Reply("a cube: \u2603\n", StopReason.END, Usage(1, 2, 3, 4), "claude-opus-5-5", "a note")


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    set_apart(monkeypatch, tmp_path)


def client(server: ModelServer, monkeypatch: pytest.MonkeyPatch) -> Client:
    return Client(
        anthropic_at(server.url, monkeypatch),
        find_model("claude-opus-5-5"),
        Budget(5.0),
        ReplyCache(reply_cache_folder()),
    )


def ask(of: Client, asked: Request = ASKED, sample: int = 1, attempt: int = 1) -> str:
    return of.ask(asked, sample, attempt, str).reply.text


# --- what is found -------------------------------------------------------------------------------------------------------


def test_the_same_question_is_sent_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with serving([Said("one"), Said("two")]) as server:
        assert ask(client(server, monkeypatch)) == "one"
        monkeypatch.setenv("ANTHROPIC_API_KEY", "sk-ant-of-somebody-else")  # the answer is the same for everybody
        second = client(server, monkeypatch).ask(ASKED, 1, 1, str)
    assert (second.reply.text, second.was_cached, second.cost) == ("one", True, 0.0)
    assert len(server.requests) == len(server.counted) == 1


def test_replies_lie_in_the_cache_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert reply_cache_folder() == tmp_path / "cache" / "scenelang" / "replies"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert reply_cache_folder() == tmp_path / ".cache" / "scenelang" / "replies"


OTHERS = [
    replace(ASKED, model="claude-opus-5"),
    replace(ASKED, system=TextContent("other rules", is_cacheable=True)),
    replace(ASKED, system=TextContent("rules")),
    replace(ASKED, messages=(text_message("user", "a sphere"),)),
    replace(ASKED, messages=(*ASKED.messages, text_message("assistant", "x"), text_message("user", "y"))),
    replace(ASKED, messages=(Message("user", (ImageContent("image/png", b"1"), TextContent("a cube"))),)),
    replace(ASKED, messages=(Message("user", (ImageContent("image/png", b"2"), TextContent("a cube"))),)),
    replace(ASKED, max_tokens=1001),
    replace(ASKED, thinking="adaptive"),
    replace(ASKED, effort="low"),
]


def test_every_field_of_a_question_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(lambda body: Said(f"answer {len(body['messages'])}")) as server:
        asking = client(server, monkeypatch)
        for asked in (ASKED, *OTHERS):
            ask(asking, asked)
        assert len(server.requests) == 1 + len(OTHERS)
        ask(asking, ASKED, sample=2)
        ask(asking, ASKED, attempt=2)
        assert len(server.requests) == 3 + len(OTHERS)
        for asked in (ASKED, *OTHERS):
            ask(asking, asked)
        assert len(server.requests) == 3 + len(OTHERS)


def test_another_service_is_another_question(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("one")]) as first, serving([Said("two")]) as second:
        assert ask(client(first, monkeypatch)) == "one"
        assert ask(client(second, monkeypatch)) == "two"


def test_digests_tell_facts_apart() -> None:
    assert digest_of("a", {"x": 1, "y": 2}) == digest_of("a", {"y": 2, "x": 1})
    assert (
        len({digest_of("a", 1), digest_of("a", "1"), digest_of("a1"), digest_of("a", 1, 0), digest_of(["a", 1])}) == 5
    )


# --- what is kept --------------------------------------------------------------------------------------------------------


def test_a_reply_comes_back_as_it_was(tmp_path: Path) -> None:
    ReplyCache(tmp_path).put("k", REPLY)
    assert ReplyCache(tmp_path).get("k") == REPLY
    assert reply_of(json.loads(json.dumps(reply_data(REPLY)))) == REPLY


@pytest.mark.parametrize("stop", [stop for stop in StopReason if stop is not StopReason.END])
def test_only_complete_replies_are_kept(stop: StopReason, tmp_path: Path) -> None:
    ReplyCache(tmp_path).put("k", replace(REPLY, stop=stop))
    assert ReplyCache(tmp_path).get("k") is None
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "said_", [Said("half", stop="max_tokens"), Said("x" * 200, breaks_after=64), Said("", stop="refusal")]
)
def test_an_incomplete_answer_is_asked_for_again(said_: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([said_, Said("whole")]) as server:
        asking = client(server, monkeypatch)
        ask(asking)
        assert ask(asking) == "whole"
        assert ask(asking) == "whole"
    assert len(server.requests) == 2


def data(**changes: object) -> str:
    return json.dumps(reply_data(REPLY) | changes)


DAMAGED = [
    "", "{", "[]", "5", "null", '"text"', "{}", "[" * 100_000, data(stop="maybe"), data(usage=5), data(usage={"sent": "x"}),
    data(usage={"other": 1}), data(usage={"sent": float("inf")}), data(usage={"sent": None}), data()[:-20],
]  # fmt: skip


@pytest.mark.parametrize("text", DAMAGED, ids=range(len(DAMAGED)))
def test_a_damaged_file_is_as_good_as_none(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("new")]) as server:
        asking = client(server, monkeypatch)
        path = reply_cache_folder() / f"{asking.key(ASKED, 1, 1)}.json"
        path.parent.mkdir(parents=True)
        path.write_text(text)
        assert ask(asking) == "new"
        assert ask(asking) == "new"
    assert len(server.requests) == 1


def test_a_file_that_is_no_text_is_as_good_as_none(tmp_path: Path) -> None:
    (tmp_path / "k.json").write_bytes(b"\xff\xfe")
    assert ReplyCache(tmp_path).get("k") is None
    (tmp_path / "d.json").mkdir()
    assert ReplyCache(tmp_path).get("d") is None
    ReplyCache(tmp_path).put("d", REPLY)  # cannot be kept, which is no reason to fail


def test_where_nothing_can_be_kept_answers_come_all_the_same(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file where the folder would be")
    with serving([Said("one"), Said("two")]) as server:
        assert ask(client(server, monkeypatch)) == "one"
        assert ask(client(server, monkeypatch)) == "two"


def test_what_is_kept_is_private_and_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said(f"it is {KEY}", model=KEY)]) as server:
        ask(client(server, monkeypatch))
    folder = reply_cache_folder()
    (file,) = folder.iterdir()  # neither locks nor temporary files stay
    assert file.suffix == ".json"
    assert KEY not in file.read_text()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_nothing_stays_of_a_question_that_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(_: str) -> None:
        raise KeyboardInterrupt

    with serving([Said("yes"), Said("yes")]) as server:
        asking = client(server, monkeypatch)
        with pytest.raises(KeyboardInterrupt):
            asking.ask(ASKED, 1, 1, interrupt)
        assert list(reply_cache_folder().iterdir()) == []
        assert ask(asking) == "yes"


def test_a_batch_keeps_its_answers_in_a_new_folder(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "there"
    ReplyCache(folder).put("k", REPLY)
    assert ReplyCache(folder).get("k") == REPLY
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


# --- side by side --------------------------------------------------------------------------------------------------------

ASKING = """
import sys
from models.services import request
from scenelang.inference.records import InferenceSettings
client = InferenceSettings().client()
print("ready", flush=True)
sys.stdin.readline()
answer = client.ask(request(), 1, int(sys.argv[1]), str)
print(answer.reply.text, answer.was_cached, flush=True)
"""


def start(attempt: int = 1) -> subprocess.Popen[str]:
    paths = os.pathsep.join(path for path in sys.path if path)
    running = subprocess.Popen(
        [sys.executable, "-c", ASKING, str(attempt)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": paths},
    )  # fmt: skip
    return running


def together(*processes: subprocess.Popen[str]) -> list[str]:
    """What each says when all ask at once."""
    for running in processes:
        assert running.stdout is not None
        assert running.stdout.readline() == "ready\n", running.communicate()[1]
    for running in processes:
        assert running.stdin is not None
        running.stdin.write("\n")
        running.stdin.flush()
    outputs = [running.communicate() for running in processes]
    assert [errors for _, errors in outputs if errors] == []
    return sorted(out.strip() for out, _ in outputs)


@pytest.mark.slow
def test_two_processes_that_ask_the_same_send_one_request(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(lambda body: Said("slowly", waits=0.5)) as server:
        monkeypatch.setenv("ANTHROPIC_BASE_URL", server.url)
        assert together(start(), start()) == ["slowly False", "slowly True"]
    assert len(server.requests) == 1
    assert [path.suffix for path in reply_cache_folder().iterdir()] == [".json"]


@pytest.mark.slow
def test_a_process_that_is_killed_does_not_keep_others_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(lambda body: Said("at last", waits=0.0 if len(server.requests) > 1 else 30.0)) as server:
        monkeypatch.setenv("ANTHROPIC_BASE_URL", server.url)
        with start() as first:
            assert first.stdin is not None
            first.stdin.write("\n")
            first.stdin.flush()
            wait_until(lambda: server.requests)
            first.kill()
        assert ask(client(server, monkeypatch)) == "at last"
    assert len(server.requests) == 2


def test_many_threads_that_ask_a_few_questions_send_each_once(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(lambda body: Said(body["messages"][0]["content"][0]["text"], waits=0.02)) as server:
        asking = client(server, monkeypatch)
        questions = [f"question {number % 5}" for number in range(40)]
        with ThreadPoolExecutor(16) as pool:
            answers = list(pool.map(lambda text: ask(asking, request(text)), questions))
    assert answers == questions
    assert len(server.requests) == 5
    assert sorted(path.suffix for path in reply_cache_folder().iterdir()) == [".json"] * 5
