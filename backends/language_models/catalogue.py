"""What is known of models: prices with their date, the longest answer, ways of thinking, efforts."""

from __future__ import annotations

import os
import re
import stat
import tomllib
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from enum import Enum
from functools import cache
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import Any
from urllib.parse import SplitResult, unquote, urlsplit, urlunsplit

from scenelang.backends.files import user_folder
from scenelang.grammar.diagnostics import SceneError, suggest

# What is said to a language model and what it answers, whichever family it is of.


@dataclass(frozen=True, slots=True)
class TextContent:
    """A piece of text. ``is_fixed``: what was said up to its end is the same in many requests, so services may keep
    it."""

    text: str
    is_fixed: bool = False


@dataclass(frozen=True, slots=True)
class ImageContent:
    """An encoded picture; ``media_type`` such as ``image/png``."""

    media_type: str
    data: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class Blocks:
    """What a provider answered, in its own form, to be sent back to it as it came (a turn that was paused)."""

    blocks: tuple[Mapping[str, Any], ...]


Part = TextContent | ImageContent | Blocks


@dataclass(frozen=True, slots=True)
class Turn:
    """What one side said. ``role`` is "user" or "assistant"."""

    role: str
    parts: tuple[Part, ...]


def said(role: str, text: str) -> Turn:
    """A turn of text alone."""
    return Turn(role, (TextContent(text),))


@dataclass(frozen=True, slots=True)
class Request:
    """One question. ``system`` is said before all turns. ``thinking`` is how the model is to think, None to leave that
    to it, and ``effort`` how much it is to work: both as the model's row of the catalogue allows. ``grammar`` is a GBNF
    grammar that the answer must follow, for services that can."""

    model: str
    system: TextContent
    turns: tuple[Turn, ...]
    max_tokens: int
    thinking: str | None = None
    effort: str | None = None
    grammar: str | None = None


class Stop(Enum):
    """Why an answer ended. CUT: at ``max_tokens``. FULL: the model's context has no more room. PAUSED: to be sent back
    as it came, so that the model goes on. BROKEN: the connection ended first."""

    END = "end"
    CUT = "cut"
    FULL = "full"
    REFUSED = "refused"
    PAUSED = "paused"
    BROKEN = "broken"


@dataclass(frozen=True, slots=True)
class Usage:
    """Tokens: sent and read anew, sent and read from the service's cache, written to it, and answered."""

    sent: int = 0
    cache_read: int = 0
    cache_written: int = 0
    answered: int = 0

    def __add__(self, other: Usage) -> Usage:
        return Usage(
            self.sent + other.sent,
            self.cache_read + other.cache_read,
            self.cache_written + other.cache_written,
            self.answered + other.answered,
        )

    @property
    def prompt(self) -> int:
        """All that was sent."""
        return self.sent + self.cache_read + self.cache_written


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer. ``note`` says more about why it ended, such as a refusal's explanation; ``blocks`` are the provider's
    own form of it where it was paused."""

    text: str
    stop: Stop
    usage: Usage
    model: str
    note: str = ""
    blocks: tuple[Mapping[str, Any], ...] = ()


# Keys and addresses of services: from the environment or the configuration file, and never shown.


_SHORTEST_SECRET = 8  # a shorter key would blot out ordinary text
_LARGEST_FILE = 1_000_000
_HEADERS = ("ANTHROPIC_CUSTOM_HEADERS", "OPENAI_CUSTOM_HEADERS")
_HIDDEN = "[key]"
_KEY = re.compile(r"[!#-\[\]-~]+")  # what headers can carry and JSON writes as it is
TIMEOUT = 120.0
CONNECT_TIMEOUT = 10.0
NO_KEY = "none"  # what the packages are given where a service wants no key


@dataclass(frozen=True, slots=True)
class Account:
    """How a provider is reached. ``secrets`` are texts that must not be shown or kept, the key among them. ``timeout``:
    seconds without a byte from the service, at each try."""

    key: str | None = field(repr=False)
    address: str = field(repr=False)
    settings: Mapping[str, Any] = field(default_factory=dict, repr=False)
    secrets: tuple[str, ...] = field(default=(), repr=False)
    timeout: float = TIMEOUT

    def clean(self, text: str) -> str:
        """A text without secrets."""
        return cleaned(text, self.secrets)

    @property
    def shown_address(self) -> str:
        """The address without user, password and query."""
        parts = urlsplit(self.address)
        host = parts.hostname or ""
        place = f"[{host}]" if ":" in host else host
        return urlunsplit((parts.scheme, f"{place}:{parts.port}" if parts.port else place, parts.path, "", ""))


def cleaned(text: str, secrets: Sequence[str]) -> str:
    """A text with every secret blotted out, and without half characters, which JSON can carry and no file can hold."""
    text = text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    for secret in secrets:
        text = text.replace(secret, _HIDDEN)
    return text


def config_file() -> Path:
    """Where the configuration is looked for."""
    return user_folder("CONFIG") / "config.toml"


def configuration() -> dict[str, Any]:
    """The configuration, empty where there is none. Raises SceneError for a file that is malformed, or that holds a key
    and that others may read."""
    path = config_file()
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise SceneError("file", f"{path} is too large for a configuration")
        text = path.read_text("utf-8")
        mode = path.stat().st_mode
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError("file", f"cannot read {path}: {getattr(error, 'strerror', None) or 'no UTF-8 text'}") from None
    try:
        found = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError("file", f"{path} is no TOML: {error}") from None
    except RecursionError:
        raise SceneError("file", f"{path} is nested too deeply") from None
    holds_key = any(isinstance(table, dict) and "api_key" in table for table in found.values())
    if holds_key and os.name == "posix" and stat.S_IMODE(mode) & 0o077:
        raise SceneError("model-key", f"{path} holds a key and others may read it", f"chmod 600 {path}")
    return found


def account(
    family: str, key_variables: Sequence[str], address_variable: str, default_address: str, needs_key: bool
) -> Account:
    """The account for a family: the environment comes before the configuration's table of that name. Raises SceneError
    where there is no key and one is needed."""
    table = configuration().get(family, {})
    if not isinstance(table, dict):
        raise SceneError("file", f"{config_file()}: expected `{family}` to be a TOML table")
    key = next((os.environ[name] for name in key_variables if os.environ.get(name)), None) or table.get("api_key")
    if key is not None and not (isinstance(key, str) and _KEY.fullmatch(key.strip())):
        raise SceneError("model-key", f"the API key for `{family}` contains characters that no HTTP header can carry")
    if key is None and needs_key:
        message = f"no API key for `{family}` in the environment or in {config_file()}"
        raise SceneError("model-key", message, f"export {key_variables[0]}=...")
    address = os.environ.get(address_variable) or table.get("base_url") or default_address
    if not isinstance(address, str) or not _is_address(address.strip()):
        raise SceneError("value", f"invalid base URL for `{family}`", "use a URL that starts with http:// or https://")
    key, address = key.strip() if key is not None else None, address.strip().rstrip("/")
    return Account(key, address, table, _secrets(key, address))


def _is_address(text: str) -> bool:
    try:
        parts = urlsplit(text)
        return parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0 and text.isprintable()
    except ValueError:
        return False


def _secrets(key: str | None, address: str) -> tuple[str, ...]:
    parts = urlsplit(address)
    found = {key, parts.query, *_login(parts), *_sent_along()}
    kept = {secret for secret in found if secret and len(secret) >= _SHORTEST_SECRET}
    return tuple(sorted(kept, key=len, reverse=True))


def _login(parts: SplitResult) -> Iterator[str]:
    """What of an address lets people in, in every form that it is sent in."""
    name, password = parts.username or "", parts.password or ""
    alone = password or name  # some services take a token as the name
    yield from (alone, unquote(alone))
    if alone:
        yield b64encode(f"{unquote(name)}:{unquote(password)}".encode()).decode()


def _sent_along() -> Iterator[str]:
    """The values of the headers that the environment adds to requests, and their words, such as a token's."""
    lines = [line for name in _HEADERS for line in os.environ.get(name, "").splitlines()]
    for line in lines:
        value = line.partition(":")[2].strip()
        yield from (value, *value.split())


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
        raise SceneError("file", f"{config_file()}: expected `models` to be a table of tables")
    return found


def _given(text: str) -> dict[str, float]:
    try:
        numbers = [float(piece) for piece in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 2 or not all(isfinite(x) and x >= 0 for x in numbers):
        raise SceneError("value", f"invalid price `{text}`", "write INPUT,OUTPUT in dollars per million tokens: 2,10")
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
        raise ValueError(f"expected a number of tokens, got {number}")
    return int(number)


def _prices(row: Mapping[str, Any]) -> Prices:
    """Prices of a row. What it leaves out is no lower than it can be: writing to a cache costs a quarter more."""
    sent, answered = float(row["input"]), float(row["output"])
    prices = (sent, answered, float(row.get("cache_write", 1.25 * sent)), float(row.get("cache_read", sent)))
    if not all(isfinite(price) and price >= 0 for price in prices):
        raise ValueError("a price must be an amount in US dollars")
    return Prices(*prices)
