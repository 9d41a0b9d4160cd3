"""What is known of models: prices with their date, the longest answer, ways of thinking, efforts."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from functools import cache
from importlib.resources import files
from math import isfinite
from typing import Any

from scenelang.backends.language_models.conversation import Usage
from scenelang.backends.language_models.credentials import config_file, configuration
from scenelang.grammar.diagnostics import SceneError, suggest

_MILLION = 1_000_000
_DATED = re.compile(r"-20\d{6}\Z")  # a snapshot of a model: claude-opus-4-5-20251101
_PRICES = ("input", "output", "cache_write", "cache_read", "over")
_MAX_OUTPUT = 8_192  # of models that are not in the catalogue
BATCH_DISCOUNT = 0.5


@dataclass(frozen=True, slots=True)
class Prices:
    """US dollars per million tokens."""

    input: float
    output: float
    cache_write: float
    cache_read: float

    def of(self, usage: Usage) -> float:
        """US dollars."""
        sent = usage.sent * self.input + usage.cache_written * self.cache_write + usage.cache_read * self.cache_read
        return (sent + usage.answered * self.output) / _MILLION


@dataclass(frozen=True, slots=True)
class Model:
    """A model. Prompts of more than ``threshold`` tokens have the prices ``over``."""

    name: str
    prices: Prices
    max_output: int
    thinking: str | None = None
    efforts: tuple[str, ...] = ()
    threshold: int | None = None
    over: Prices | None = None

    def cost(self, usage: Usage, is_batch: bool = False) -> float:
        """What a request of this usage costs, in US dollars."""
        is_long = self.over is not None and self.threshold is not None and usage.prompt > self.threshold
        prices = self.over if is_long and self.over is not None else self.prices
        return prices.of(usage) * (BATCH_DISCOUNT if is_batch else 1.0)

    def highest_cost(self, prompt: int, max_tokens: int, is_batch: bool = False) -> float:
        """What a request can cost at most: its prompt is read anew or written to the cache, whichever is dearer."""
        anew, written = Usage(sent=prompt, answered=max_tokens), Usage(cache_written=prompt, answered=max_tokens)
        return max(self.cost(anew, is_batch), self.cost(written, is_batch))

    def effort(self, wanted: str | None) -> str | None:
        """The effort to send; raises SceneError for one that the model does not know."""
        if wanted is not None and wanted not in self.efforts:
            known = ", ".join(self.efforts)
            hint = f"it knows {known}" if known else "leave --effort out for it"
            raise SceneError("value", f"`{self.name}` has no effort `{wanted}`", hint)
        return wanted


@cache
def _data() -> Mapping[str, Any]:
    return tomllib.loads((files("scenelang.backends.language_models") / "catalogue.toml").read_text("utf-8"))


def catalogue_date() -> date:
    """When the prices were published."""
    found: date = _data()["date"]
    return found


def known_models() -> tuple[str, ...]:
    """The models of the catalogue and the configuration."""
    return (*_data()["models"], *_configured())


def model(name: str, price: str | None = None, is_free: bool = False) -> Model:
    """A model by name. ``price`` is "INPUT,OUTPUT" in US dollars per million tokens and goes before what is known;
    ``is_free``: a model that is not known costs nothing. Raises SceneError for a model whose price is not known."""
    row = _row(name)
    if price is not None:
        row = dict(row or {}) | _given(price)
        row.pop("over", None)
    if row is None and is_free:
        row = {"input": 0.0, "output": 0.0}
    if row is None:
        near = suggest(name, known_models())
        hint = f"{near + ', or ' if near else ''}give its price: --price INPUT,OUTPUT in dollars per million tokens"
        raise SceneError("model-price", f"the price of the model `{name}` is not known, so its cost has no limit", hint)
    return _model(name, row)


def _row(name: str) -> Mapping[str, Any] | None:
    known, configured = (rows.get(name, rows.get(_DATED.sub("", name))) for rows in (_data()["models"], _configured()))
    if known is None and configured is None:
        return None
    if "input" in (configured or {}):  # its own prices, not a mixture
        known = {name: value for name, value in (known or {}).items() if name not in _PRICES}
    return {**(known or {}), **(configured or {})}


def _configured() -> Mapping[str, Any]:
    found = configuration().get("models", {})
    if not isinstance(found, dict) or not all(isinstance(row, dict) for row in found.values()):
        raise SceneError("file", f"{config_file()}: `models` is no table of tables")
    return found


def _given(text: str) -> dict[str, float]:
    try:
        numbers = [float(piece) for piece in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 2 or not all(isfinite(x) and x >= 0 for x in numbers):
        raise SceneError("value", f"`{text}` is no price", "write INPUT,OUTPUT in dollars per million tokens: 2,10")
    return {"input": numbers[0], "output": numbers[1], "cache_write": numbers[0] * 1.25, "cache_read": numbers[0]}


def _model(name: str, row: Mapping[str, Any]) -> Model:
    try:
        thinking, efforts, over = row.get("thinking"), row.get("efforts", []), row.get("over")
        if not isinstance(efforts, list) or not all(isinstance(word, str) for word in [*efforts, thinking or ""]):
            raise ValueError("`thinking` is a word and `efforts` a list of words")
        return Model(
            name,
            _prices(row),
            _tokens(row.get("max_output", _MAX_OUTPUT)),
            thinking,
            tuple(efforts),
            _tokens(over["tokens"]) if over else None,
            _prices(over) if over else None,
        )
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise SceneError("file", f"{config_file()}: the model `{name}` is malformed: {error}") from None


def _tokens(number: Any) -> int:
    if int(number) < 1:
        raise ValueError(f"{number} is no number of tokens")
    return int(number)


def _prices(row: Mapping[str, Any]) -> Prices:
    """Prices of a row. What it leaves out is no lower than it can be: writing to a cache costs a quarter more."""
    sent, answered = float(row["input"]), float(row["output"])
    prices = (sent, answered, float(row.get("cache_write", 1.25 * sent)), float(row.get("cache_read", sent)))
    if not all(isfinite(price) and price >= 0 for price in prices):
        raise ValueError("a price is no amount of dollars")
    return Prices(*prices)
