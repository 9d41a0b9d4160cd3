"""The limit on what requests cost together: nothing goes beyond it, and every token has its price."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.server import ModelServer, Said, serving
from models.services import anthropic_at, one_line, request, set_apart
from scenelang.backends.language_models.catalogue import StopReason, Usage, find_model
from scenelang.backends.language_models.client import Budget, Client, ReplyCache
from scenelang.grammar.diagnostics import SceneError

CENT = 0.01
SONNET = find_model("claude-sonnet-5-5")  # 2, 10, 2.5 and 0.2 dollars


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    set_apart(monkeypatch, tmp_path)


def quiet(_: str) -> None:
    pass


# --- reserve and settle --------------------------------------------------------------------------------------------------

PENNIES = st.integers(0, 500)
STEPS = st.lists(st.tuples(st.booleans(), PENNIES, st.floats(0, 1)), max_size=60)


def reserves(spending: Budget, amount: float) -> bool:
    """Whether the limit allows it."""
    try:
        spending.reserve(amount)
    except SceneError as error:
        return error.name != "model-cost"
    return True


@given(limit=PENNIES, spent=PENNIES, steps=STEPS)
def test_no_sequence_spends_beyond_the_limit(limit: int, spent: int, steps: list[tuple[bool, int, float]]) -> None:
    """Against a ledger in whole cents: what is allowed is exactly what fits."""
    spending = Budget(limit * CENT, spent * CENT)
    open_: list[int] = []
    gone, most = float(spent), max(limit, spent)
    for is_reserve, cents, share in steps:
        if is_reserve:
            fits = cents + sum(open_) + gone <= limit + 1e-6
            assert reserves(spending, cents * CENT) == fits
            open_ += [cents] if fits else []
        elif open_:
            reserved = open_.pop(cents % len(open_))
            spending.settle(reserved * CENT, share * reserved * CENT)
            gone += share * reserved
        assert spending.spent == pytest.approx(gone * CENT, abs=1e-9)
        assert gone + sum(open_) <= most + 1e-6


def test_threads_do_not_spend_beyond_the_limit_together() -> None:
    """Far more than there is is asked for at once; in the end less than the smallest wish is left."""
    spending = Budget(1.0)

    def work(seed: int) -> float:
        random, paid = Random(seed), 0.0
        for _ in range(400):
            amount = random.uniform(0.001, 0.01)
            if not reserves(spending, amount):
                continue
            assert spending.spent + amount <= 1.0 + 1e-6
            cost = amount * random.random()
            spending.settle(amount, cost)
            paid += cost
        return paid

    with ThreadPoolExecutor(8) as pool:
        paid = sum(pool.map(work, range(8)))
    assert spending.spent == pytest.approx(paid)
    assert 0.98 <= paid <= 1.0 + 1e-6
    spending.reserve(1.0 - spending.spent)  # nothing stays set aside


def test_what_is_left_is_told() -> None:
    spending = Budget(1.0, spent=0.25)
    spending.reserve(0.5)
    with pytest.raises(SceneError) as caught:
        spending.reserve(0.2501)
    assert one_line(caught.value).startswith(
        "the next request could cost $0.2501, but only $0.2500 of --max-cost remains | "
    )
    spending.reserve(0.25)


def test_an_overdrawn_limit_is_told_as_nothing_left() -> None:
    with pytest.raises(SceneError, match=r"\$0\.0000 of --max-cost remains"):
        Budget(1.0, spent=3.0).reserve(0.01)


# --- what requests set aside and cost ------------------------------------------------------------------------------------


def client(
    server: ModelServer, monkeypatch: pytest.MonkeyPatch, limit: float, replies: ReplyCache | None = None
) -> Client:
    server.count = lambda body: 10_000
    return Client(anthropic_at(server.url, monkeypatch), SONNET, Budget(limit), replies)


ASKED = request(model=SONNET.name, max_tokens=2_000)
HIGHEST = (10_000 * 2.5 + 2_000 * 10) / 1e6  # $0.045: the prompt may be written to the cache


def test_what_is_set_aside_is_counted_tokens_and_the_longest_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("yes")]) as server:
        with pytest.raises(SceneError) as caught:
            client(server, monkeypatch, HIGHEST - 0.0001).ask(ASKED, 1, 1, quiet)
        assert caught.value.name == "model-cost"
        assert "could cost $0.0450, but only $0.0449 of --max-cost remains" in caught.value.message
        assert server.requests == []
        assert client(server, monkeypatch, HIGHEST).ask(ASKED, 1, 1, quiet).reply.text == "yes"


@pytest.mark.parametrize(
    ("usage", "cost"),
    [
        ({"input_tokens": 10_000, "output_tokens": 500}, (10_000 * 2 + 500 * 10) / 1e6),
        (
            {"input_tokens": 0, "cache_creation_input_tokens": 10_000, "output_tokens": 500},
            (10_000 * 2.5 + 500 * 10) / 1e6,
        ),
        ({"input_tokens": 0, "cache_read_input_tokens": 10_000, "output_tokens": 500}, (10_000 * 0.2 + 500 * 10) / 1e6),
        (
            {
                "input_tokens": 100,
                "cache_read_input_tokens": 9_000,
                "cache_creation_input_tokens": 900,
                "output_tokens": 1,
            },
            (100 * 2 + 9_000 * 0.2 + 900 * 2.5 + 10) / 1e6,
        ),
    ],
)
def test_a_request_costs_what_its_usage_says(
    usage: dict[str, int], cost: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    with serving([Said("yes", usage=usage)]) as server:
        asking = client(server, monkeypatch, 1.0)
        answer = asking.ask(ASKED, 1, 1, quiet)
    assert answer.cost == pytest.approx(cost)
    assert asking.budget.spent == pytest.approx(cost)
    asking.budget.reserve(1.0 - cost)  # the rest is free again


def test_a_kept_reply_costs_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with serving([Said("yes")]) as server:
        client(server, monkeypatch, 1.0, ReplyCache(tmp_path)).ask(ASKED, 1, 1, quiet)
        poor = client(server, monkeypatch, 0.0001, ReplyCache(tmp_path))
        answer = poor.ask(ASKED, 1, 1, quiet)
    assert (answer.cost, answer.was_cached, answer.reply.text) == (0.0, True, "yes")
    assert poor.budget.spent == 0.0


def test_what_is_interrupted_costs_what_was_set_aside(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(_: str) -> None:
        raise KeyboardInterrupt

    with serving([Said("yes")]) as server:
        asking = client(server, monkeypatch, 1.0)
        with pytest.raises(KeyboardInterrupt):
            asking.ask(ASKED, 1, 1, interrupt)
    assert asking.budget.spent == pytest.approx(HIGHEST)


def test_a_broken_answer_costs_what_was_set_aside(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("yes" * 100, breaks_after=64)]) as server:
        asking = client(server, monkeypatch, 1.0)
        answer = asking.ask(ASKED, 1, 1, quiet)
    assert answer.reply.stop is StopReason.INTERRUPTED
    assert answer.cost == asking.budget.spent == pytest.approx(HIGHEST)


@pytest.mark.slow
def test_requests_side_by_side_share_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twenty at once, each of which could cost $0.045 and costs $0.02005, with $0.2 in all."""
    usage = {"input_tokens": 10_000, "output_tokens": 5}
    with serving(lambda body: Said("yes", usage=usage, waits=0.05)) as server:
        asking = client(server, monkeypatch, 0.2)

        def ask(number: int) -> float | None:
            try:
                return asking.ask(ASKED, number, 1, quiet).cost
            except SceneError as error:
                return None if error.name == "model-cost" else -1.0

        with ThreadPoolExecutor(20) as pool:
            costs = [cost for cost in pool.map(ask, range(20)) if cost is not None]
    assert 4 <= len(costs) <= 9
    assert len(server.requests) == len(costs)
    assert asking.budget.spent == pytest.approx(sum(costs)) == pytest.approx(len(costs) * 0.02005)
    assert asking.budget.spent <= 0.2


def test_usage_adds_up() -> None:
    assert Usage(1, 2, 3, 4) + Usage(10, 20, 30, 40) == Usage(11, 22, 33, 44)
    assert Usage(1, 2, 3, 4).prompt == 6
