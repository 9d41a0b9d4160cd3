"""Requests and replies; API keys and configuration; catalogue of models with prices, limits and reasoning options."""

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

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.loading import user_folder

# Requests to language models and their replies, independent of the provider.


@dataclass(frozen=True, slots=True)
class TextContent:
    """Text block; with ``is_cacheable``, the prompt up to its end is shared by many requests and may be cached."""

    text: str
    is_cacheable: bool = False


@dataclass(frozen=True, slots=True)
class ImageContent:
    """Encoded image; ``media_type`` is a MIME type such as ``image/png``."""

    media_type: str
    data: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class Blocks:
    """Content blocks of a paused reply in the provider's format, to be sent back unchanged."""

    blocks: tuple[Mapping[str, Any], ...]


Part = TextContent | ImageContent | Blocks


@dataclass(frozen=True, slots=True)
class Message:
    """Message of a conversation; ``role`` is "user" or "assistant"."""

    role: str
    parts: tuple[Part, ...]


def text_message(role: str, text: str) -> Message:
    """Return a message with a single text."""
    return Message(role, (TextContent(text),))


@dataclass(frozen=True, slots=True)
class Request:
    """Request to a language model.

    Attributes
    ----------
    model
        Name of the model.
    system
        System prompt.
    messages
        Conversation so far.
    max_tokens
        Maximum number of output tokens.
    thinking, effort
        Reasoning mode and effort, as supported by the model according to the catalogue; None: its default.
    grammar
        GBNF grammar of the reply, for services that support constrained decoding.
    """

    model: str
    system: TextContent
    messages: tuple[Message, ...]
    max_tokens: int
    thinking: str | None = None
    effort: str | None = None
    grammar: str | None = None


class StopReason(Enum):
    """Reason for the end of a reply.

    MAX_TOKENS: the limit ``max_tokens`` was reached. CONTEXT_FULL: the context window is full. PAUSED: the model
    continues if the reply is sent back. INTERRUPTED: the connection failed.
    """

    END = "end"
    MAX_TOKENS = "cut"
    CONTEXT_FULL = "full"
    REFUSED = "refused"
    PAUSED = "paused"
    INTERRUPTED = "broken"


@dataclass(frozen=True, slots=True)
class Usage:
    """Token usage of a request.

    Attributes
    ----------
    sent
        Input tokens that are not in the service's prompt cache.
    cache_read, cache_written
        Input tokens read from the prompt cache, and written to it.
    answered
        Output tokens.
    """

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
        """Total number of input tokens."""
        return self.sent + self.cache_read + self.cache_written


@dataclass(frozen=True, slots=True)
class Reply:
    """Reply of a language model.

    Attributes
    ----------
    text
        Text of the reply.
    stop
        Reason for its end.
    usage
        Token usage.
    model
        Name of the model that replied.
    note
        Details about the end, such as the explanation of a refusal.
    blocks
        Content blocks of a paused reply, in the provider's format.
    """

    text: str
    stop: StopReason
    usage: Usage
    model: str
    note: str = ""
    blocks: tuple[Mapping[str, Any], ...] = ()


# API keys and base URLs, from the environment or the configuration file; they are redacted in all output.


_MIN_SECRET_LENGTH = 8  # redacting shorter secrets would affect ordinary text
_MAX_CONFIG_BYTES = 1_000_000
_HEADERS = ("ANTHROPIC_CUSTOM_HEADERS", "OPENAI_CUSTOM_HEADERS")
_REDACTED = "[key]"
_KEY = re.compile(r"[!#-\[\]-~]+")  # characters allowed in HTTP headers and not escaped in JSON
TIMEOUT = 120.0  # seconds
CONNECT_TIMEOUT = 10.0  # seconds
NO_KEY = "none"  # placeholder for the SDKs, which require a key, if the service does not


@dataclass(frozen=True, slots=True)
class Account:
    """Credentials for a provider.

    Attributes
    ----------
    key
        API key.
    address
        Base URL.
    settings
        Table of the provider in the configuration file.
    secrets
        Texts to redact, including the key.
    timeout
        Seconds without data from the service after which an attempt fails.
    """

    key: str | None = field(repr=False)
    address: str = field(repr=False)
    settings: Mapping[str, Any] = field(default_factory=dict, repr=False)
    secrets: tuple[str, ...] = field(default=(), repr=False)
    timeout: float = TIMEOUT

    def redact(self, text: str) -> str:
        """Remove secrets from a text."""
        return redact(text, self.secrets)

    @property
    def public_address(self) -> str:
        """Base URL without user, password and query."""
        parts = urlsplit(self.address)
        hostname = parts.hostname or ""
        host = f"[{hostname}]" if ":" in hostname else hostname
        return urlunsplit((parts.scheme, f"{host}:{parts.port}" if parts.port else host, parts.path, "", ""))


def redact(text: str, secrets: Sequence[str]) -> str:
    """Replace every secret in a text, and lone surrogates, which JSON may contain but UTF-8 cannot encode."""
    text = text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    for secret in secrets:
        text = text.replace(secret, _REDACTED)
    return text


def config_file() -> Path:
    """Return the path of the configuration file."""
    return user_folder("CONFIG") / "config.toml"


def load_config() -> dict[str, Any]:
    """Load the configuration file; empty if it does not exist.

    Raises SceneError for a malformed file, or one that contains an API key and is readable by other users.
    """
    path = config_file()
    try:
        if path.stat().st_size > _MAX_CONFIG_BYTES:
            raise SceneError("file", f"{path} is larger than {_MAX_CONFIG_BYTES:,} bytes")
        text = path.read_text("utf-8")
        mode = path.stat().st_mode
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError("file", f"cannot read {path}: {getattr(error, 'strerror', None) or 'not UTF-8'}") from None
    try:
        config = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError("file", f"{path} is not valid TOML: {error}") from None
    except RecursionError:
        raise SceneError("file", f"{path} is nested too deeply") from None
    has_key = any(isinstance(table, dict) and "api_key" in table for table in config.values())
    if has_key and os.name == "posix" and stat.S_IMODE(mode) & 0o077:
        message = f"{path} contains an API key but is readable by other users"
        raise SceneError("model-key", message, f"run `chmod 600 {path}`")
    return config


def load_account(
    family: str, key_variables: Sequence[str], address_variable: str, default_address: str, needs_key: bool
) -> Account:
    """Load the account for a provider; the environment overrides the table of that name in the configuration file.

    Raises SceneError if a required API key is missing or a value is invalid.
    """
    table = load_config().get(family, {})
    if not isinstance(table, dict):
        raise SceneError("file", f"{config_file()}: expected `{family}` to be a TOML table")
    key = next((os.environ[name] for name in key_variables if os.environ.get(name)), None) or table.get("api_key")
    if key is not None and not (isinstance(key, str) and _KEY.fullmatch(key.strip())):
        raise SceneError("model-key", f"the API key for `{family}` contains characters that no HTTP header can carry")
    if key is None and needs_key:
        message = f"no API key for `{family}` in the environment or in {config_file()}"
        raise SceneError("model-key", message, f"set it with `export {key_variables[0]}=...`")
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
    values = {key, parts.query, *_url_credentials(parts), *_custom_header_values()}
    secrets = {secret for secret in values if secret and len(secret) >= _MIN_SECRET_LENGTH}
    return tuple(sorted(secrets, key=len, reverse=True))  # longest first, since one may contain another


def _url_credentials(parts: SplitResult) -> Iterator[str]:
    """Yield the credentials in a URL, in every encoding in which they are sent."""
    name, password = parts.username or "", parts.password or ""
    secret = password or name  # some services use a token as the user name
    yield from (secret, unquote(secret))
    if secret:
        yield b64encode(f"{unquote(name)}:{unquote(password)}".encode()).decode()


def _custom_header_values() -> Iterator[str]:
    """Yield the values of custom headers in the environment, and their words, such as a bearer token."""
    lines = [line for name in _HEADERS for line in os.environ.get(name, "").splitlines()]
    for line in lines:
        value = line.partition(":")[2].strip()
        yield from (value, *value.split())


# Models and prices.


_MILLION = 1_000_000
_DATED = re.compile(r"-20\d{6}\Z")  # suffix of a snapshot: claude-opus-4-5-20251101
_PRICES = ("input", "output", "cache_write", "cache_read", "over")
_DEFAULT_MAX_OUTPUT = 8_192  # tokens, of models that are not in the catalogue
BATCH_DISCOUNT = 0.5


@dataclass(frozen=True, slots=True)
class Prices:
    """Prices in US dollars per million tokens."""

    input: float
    output: float
    cache_write: float
    cache_read: float

    def cost(self, usage: Usage) -> float:
        """Return the cost in US dollars."""
        sent = usage.sent * self.input + usage.cache_written * self.cache_write + usage.cache_read * self.cache_read
        return (sent + usage.answered * self.output) / _MILLION


@dataclass(frozen=True, slots=True)
class Model:
    """Model with its prices and limits.

    Attributes
    ----------
    name
        Name of the model.
    prices
        Prices.
    max_output
        Maximum number of output tokens.
    thinking
        Default reasoning mode.
    efforts
        Supported reasoning efforts.
    threshold, over
        Number of input tokens above which the prices ``over`` apply.
    """

    name: str
    prices: Prices
    max_output: int
    thinking: str | None = None
    efforts: tuple[str, ...] = ()
    threshold: int | None = None
    over: Prices | None = None

    def cost(self, usage: Usage, is_batch: bool = False) -> float:
        """Return the cost of a request in US dollars."""
        is_long = self.over is not None and self.threshold is not None and usage.prompt > self.threshold
        prices = self.over if is_long and self.over is not None else self.prices
        return prices.cost(usage) * (BATCH_DISCOUNT if is_batch else 1.0)

    def max_cost(self, prompt: int, max_tokens: int, is_batch: bool = False) -> float:
        """Return the maximum cost of a request: with the prompt uncached or written to the cache."""
        uncached, written = Usage(sent=prompt, answered=max_tokens), Usage(cache_written=prompt, answered=max_tokens)
        return max(self.cost(uncached, is_batch), self.cost(written, is_batch))

    def check_effort(self, effort: str | None) -> str | None:
        """Return ``effort``; raises SceneError if the model does not support it."""
        if effort is not None and effort not in self.efforts:
            known = ", ".join(self.efforts)
            hint = f"supported efforts: {known}" if known else "omit --effort for this model"
            raise SceneError("value", f"`{self.name}` does not support the effort `{effort}`", hint)
        return effort


@cache
def _data() -> Mapping[str, Any]:
    return tomllib.loads((files("scenelang.backends.language_models") / "catalogue.toml").read_text("utf-8"))


def catalogue_date() -> date:
    """Return the date of the prices."""
    day: date = _data()["date"]
    return day


def known_models() -> tuple[str, ...]:
    """Return the names of the models in the catalogue and the configuration file."""
    return (*_data()["models"], *_configured_models())


def find_model(name: str, price: str | None = None, is_free: bool = False) -> Model:
    """Return a model by name.

    ``price`` is "INPUT,OUTPUT" in US dollars per million tokens and overrides the catalogue; with ``is_free``, unknown
    models have no cost. Raises SceneError for a model with unknown price.
    """
    row = _row(name)
    if price is not None:
        row = dict(row or {}) | _parse_price(price)
        row.pop("over", None)
    if row is None and is_free:
        row = {"input": 0.0, "output": 0.0}
    if row is None:
        near = suggest(name, known_models())
        price = "specify its price with --price INPUT,OUTPUT in dollars per million tokens, so that its cost is limited"
        hint = f"{near + ' If the name is right, ' if near else ''}{price}"
        message = f"unknown model `{name}`"
        raise SceneError("model-price", message, hint)
    return _model(name, row)


def _row(name: str) -> Mapping[str, Any] | None:
    tables = (_data()["models"], _configured_models())
    known, configured = (rows.get(name, rows.get(_DATED.sub("", name))) for rows in tables)
    if known is None and configured is None:
        return None
    if "input" in (configured or {}):  # configured prices replace all of the catalogue's
        known = {name: value for name, value in (known or {}).items() if name not in _PRICES}
    return {**(known or {}), **(configured or {})}


def _configured_models() -> Mapping[str, Any]:
    models = load_config().get("models", {})
    if not isinstance(models, dict) or not all(isinstance(row, dict) for row in models.values()):
        raise SceneError("file", f"{config_file()}: expected `models` to be a table of tables")
    return models


def _parse_price(text: str) -> dict[str, float]:
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
            raise ValueError("expected a string for `thinking` and a list of strings for `efforts`")
        return Model(
            name,
            _prices(row),
            _tokens(row.get("max_output", _DEFAULT_MAX_OUTPUT)),
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
    """Return the prices of a row; the defaults for the cache are upper bounds (writing costs a quarter more)."""
    input_, output = float(row["input"]), float(row["output"])
    prices = (input_, output, float(row.get("cache_write", 1.25 * input_)), float(row.get("cache_read", input_)))
    if not all(isfinite(price) and price >= 0 for price in prices):
        raise ValueError("a price must be an amount in US dollars")
    return Prices(*prices)
