"""What is known of models, and that requests say only what the model's row allows."""

from __future__ import annotations

import math
import re
import tomllib
from datetime import date
from pathlib import Path
from typing import Any

import pytest

from models.server import Said, serving
from models.services import configure, one_line, set_apart
from scenelang.backends.language_models.catalogue import (
    BATCH_DISCOUNT,
    Prices,
    Usage,
    catalogue_date,
    find_model,
    known_models,
    text_message,
)
from scenelang.backends.language_models.provider import PROVIDERS
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.brief import Notation
from scenelang.inference.records import InferenceSettings

FILE = Path(__file__).parents[2] / "backends" / "language_models" / "catalogue.toml"
ROWS: dict[str, dict[str, Any]] = tomllib.loads(FILE.read_text("utf-8"))["models"]
EFFORTS = ["low", "medium", "high", "xhigh", "max"]
FIELDS = {"input", "output", "cache_write", "cache_read", "max_output"}


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    set_apart(monkeypatch, tmp_path)


def refused(name: str, price: str | None = None) -> SceneError:
    with pytest.raises(SceneError) as caught:
        find_model(name, price)
    one_line(caught.value)
    return caught.value


# --- the table -----------------------------------------------------------------------------------------------------------


def test_prices_are_dated() -> None:
    assert date(2026, 1, 1) <= catalogue_date() <= date.today()


@pytest.mark.parametrize("name", ROWS)
def test_a_row_is_well_formed(name: str) -> None:
    row, found = ROWS[name], find_model(name)
    assert re.fullmatch(r"claude-[a-z]+(-\d+)+", name)
    assert set(row) >= FIELDS
    assert set(row) <= FIELDS | {"thinking", "efforts", "over"}
    for prices in (found.prices, *([found.over] if found.over else [])):
        assert 0 < prices.cache_read <= prices.input <= prices.cache_write < prices.output
        assert math.isfinite(prices.output)
        assert prices.cache_write == pytest.approx(1.25 * prices.input)
    assert 8_000 <= found.max_output <= 1_000_000
    assert found.thinking in (None, "adaptive")
    assert found.efforts == tuple(sorted(found.efforts, key=EFFORTS.index))
    assert (found.over is None) == (found.threshold is None)


def test_the_models_that_are_taken_by_default_are_known() -> None:
    assert {found.default_model for found in PROVIDERS.all()} - {None} <= set(ROWS)


@pytest.mark.parametrize("name", ROWS)
def test_a_dated_snapshot_has_the_row_of_its_model(name: str) -> None:
    dated = find_model(f"{name}-20251001")
    assert dated.name == f"{name}-20251001"  # what is sent
    assert (dated.prices, dated.max_output, dated.efforts) == (
        find_model(name).prices, find_model(name).max_output, find_model(name).efforts,
    )  # fmt: skip


# --- prices --------------------------------------------------------------------------------------------------------------


def test_every_kind_of_token_has_its_price() -> None:
    prices = Prices(input=2.0, output=10.0, cache_write=2.5, cache_read=0.2)
    assert prices.cost(Usage(1_000_000)) == 2.0
    assert prices.cost(Usage(cache_read=1_000_000)) == 0.2
    assert prices.cost(Usage(cache_written=1_000_000)) == 2.5
    assert prices.cost(Usage(answered=1_000_000)) == 10.0
    assert prices.cost(Usage(100_000, 200_000, 300_000, 400_000)) == pytest.approx(0.2 + 0.04 + 0.75 + 4.0)


def test_long_prompts_cost_more() -> None:
    """The tier of the longest prompts goes by all that was sent, and has a price of its own for what is answered."""
    haiku = find_model("claude-haiku-5-5")
    assert haiku.cost(Usage(sent=100_000, answered=1000)) == pytest.approx((100_000 * 0.1 + 1000 * 0.5) / 1e6)
    assert haiku.cost(Usage(sent=100_001, answered=1000)) == pytest.approx((100_001 * 0.5 + 1000 * 2.5) / 1e6)
    parts = Usage(sent=1, cache_read=60_000, cache_written=40_000)
    assert haiku.cost(parts) == pytest.approx((0.5 + 60_000 * 0.05 + 40_000 * 0.625) / 1e6)
    assert haiku.max_cost(100_001, 1000) == pytest.approx((100_001 * 0.625 + 1000 * 2.5) / 1e6)


def test_a_batch_is_half_the_price() -> None:
    usage = Usage(1000, 2000, 3000, 4000)
    opus = find_model("claude-opus-5-5")
    assert BATCH_DISCOUNT == 0.5
    assert opus.cost(usage, is_batch=True) == pytest.approx(opus.cost(usage) / 2)
    assert opus.max_cost(500, 600, is_batch=True) == pytest.approx(opus.max_cost(500, 600) / 2)


@pytest.mark.parametrize("name", ROWS)
def test_no_usage_costs_more_than_the_highest_cost(name: str) -> None:
    found = find_model(name)
    for prompt in (0, 10, 99_999, 100_000, 100_001, 900_000):
        for usage in (
            Usage(prompt),
            Usage(0, prompt),
            Usage(0, 0, prompt),
            Usage(prompt // 2, 0, prompt - prompt // 2),
        ):
            cost = found.cost(Usage(usage.sent, usage.cache_read, usage.cache_written, 700))
            assert cost <= found.max_cost(prompt, 700) + 1e-12


# --- models that are not in it -------------------------------------------------------------------------------------------


def test_an_unknown_model_is_refused() -> None:
    error = refused("claude-opus-5-6")
    assert error.name == "model-price"
    assert "claude-opus-5-5" in (error.hint or "")
    assert "--price" in (error.hint or "")


@pytest.mark.parametrize(
    "name", ["claude-opus-5-5-2025100", "claude-opus-5-5-20251001-v2", "claude-opus", "", "x" * 5000]
)
def test_a_name_that_only_looks_like_a_known_one_is_refused(name: str) -> None:
    assert refused(name).name == "model-price"


def test_a_price_makes_a_model_known() -> None:
    found = find_model("claude-next", "3,15")
    assert found.prices == Prices(3.0, 15.0, 3.75, 3.0)  # what is not said is as dear as it can be
    assert (found.thinking, found.efforts, found.max_output) == (None, (), 8_192)


def test_a_price_goes_before_a_known_one() -> None:
    found = find_model("claude-haiku-5-5", "7,8")
    assert (found.prices.input, found.prices.output) == (7.0, 8.0)
    assert found.cost(Usage(sent=1_000_000)) == 7.0  # the tier of long prompts had the old price
    assert found.efforts == find_model("claude-haiku-5-5").efforts


@pytest.mark.parametrize("price", ["", "3", "3,4,5", "a,b", "-1,2", "1,-2", "nan,1", "inf,1", "1,1e999", "1;2"])
def test_what_is_no_price_is_refused(price: str) -> None:
    assert refused("claude-next", price).name == "value"


def test_models_can_be_configured(tmp_path: Path) -> None:
    configure(
        tmp_path,
        '[models.house-model]\ninput = 1\noutput = 2\nmax_output = 4096\nefforts = ["low"]\n'
        "over = { tokens = 10, input = 3, output = 4 }\n[models.claude-opus-5-5]\ninput = 9\noutput = 99\n",
    )
    found = find_model("house-model")
    assert (found.prices, found.max_output, found.efforts) == (Prices(1.0, 2.0, 1.25, 1.0), 4096, ("low",))
    assert (found.threshold, found.over) == (10, Prices(3.0, 4.0, 3.75, 3.0))
    assert find_model("claude-opus-5-5").prices.output == 99.0
    assert find_model("house-model-20261101").prices == found.prices
    assert "house-model" in known_models()


@pytest.mark.parametrize(
    "row",
    [
        "input = 1", 'input = "x"\noutput = 2', "input = -1\noutput = 2", "input = 1\noutput = nan", "input = inf\noutput = 2",
        "input = 1\noutput = 2\ncache_read = -1", "input = 1\noutput = 2\nmax_output = 0", 'input = 1\noutput = 2\nmax_output = "x"',
        "input = 1\noutput = 2\nmax_output = inf", "input = 1\noutput = 2\nefforts = 5", 'input = 1\noutput = 2\nefforts = "high"',
        "input = 1\noutput = 2\nthinking = 5", "input = 1\noutput = 2\nover = 5", "input = 1\noutput = 2\nover = { input = 1, output = 2 }",
        "input = 1\noutput = 2\nover = { tokens = 5, input = -1, output = 2 }",
    ],
)  # fmt: skip
def test_a_malformed_row_of_the_configuration(row: str, tmp_path: Path) -> None:
    path = configure(tmp_path, f"[models.house-model]\n{row}\n")
    error = refused("house-model")
    assert error.name == "file"
    assert f"{path}: the model `house-model` is malformed" in error.message


@pytest.mark.parametrize("text", ["models = 5", "[models]\nx = 5"])
def test_malformed_models_of_the_configuration(text: str, tmp_path: Path) -> None:
    configure(tmp_path, text)
    assert "expected `models` to be a table of tables" in refused("claude-opus-5-5").message


# --- what is sent to which -----------------------------------------------------------------------------------------------

KINDS = [
    ("claude-opus-5-5", "xhigh", True, True),
    ("claude-sonnet-4-6", "max", True, True),
    ("claude-opus-4-5", "high", False, True),
    ("claude-sonnet-4-5", None, False, False),
    ("claude-haiku-4-5-20251001", None, False, False),
]


@pytest.mark.filterwarnings("ignore:The model:DeprecationWarning")  # some of these models are old
@pytest.mark.parametrize(("name", "effort", "thinks", "works"), KINDS)
def test_requests_say_what_the_row_allows(
    name: str, effort: str | None, thinks: bool, works: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = InferenceSettings(model=name, effort=effort, uses_replies=False)
    with serving([Said("yes")]) as server:
        monkeypatch.setenv("ANTHROPIC_BASE_URL", server.url)
        client = settings.client()
        speaker = settings.speaker(client.model, Notation.LANGUAGE)
        client.ask(speaker.request("rules", (text_message("user", "a cube"),)), 1, 1, str)
    (body,) = server.requests
    assert body["model"] == name
    assert body.get("thinking") == ({"type": "adaptive"} if thinks else None)
    assert body.get("output_config") == ({"effort": effort} if works else None)
    assert body["max_tokens"] == 32_000
    assert not {"temperature", "top_p", "top_k", "grammar", "stop_sequences"} & set(body)


@pytest.mark.parametrize("name", ROWS)
def test_an_effort_is_sent_only_where_it_is_wanted(name: str) -> None:
    assert InferenceSettings(model=name).speaker(find_model(name), Notation.PYTHON).effort is None


@pytest.mark.parametrize(
    ("name", "effort", "hint"),
    [
        ("claude-opus-4-5", "xhigh", "supported efforts: low, medium, high"),
        ("claude-opus-4-6", "xhigh", "supported efforts: low, medium, high, max"),
        ("claude-sonnet-4-5", "low", "omit --effort for this model"),
        ("claude-opus-5-5", "utmost", "supported efforts: low, medium, high, xhigh, max"),
    ],
)
def test_an_effort_that_a_model_does_not_know(name: str, effort: str, hint: str) -> None:
    with pytest.raises(SceneError) as caught:
        InferenceSettings(model=name, effort=effort).speaker(find_model(name), Notation.PYTHON)
    assert (caught.value.name, caught.value.hint) == ("value", hint)


def test_answers_are_no_longer_than_the_model_has() -> None:
    settings = InferenceSettings(model="claude-haiku-4-5", max_tokens=64_001)
    with pytest.raises(SceneError, match="does not support answers of 64,001 tokens"):
        settings.speaker(find_model("claude-haiku-4-5"), Notation.PYTHON)
    assert (
        InferenceSettings(model="new", price="1,2").speaker(find_model("new", "1,2"), Notation.PYTHON).max_tokens
        == 8_192
    )
