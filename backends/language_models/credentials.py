"""Keys and addresses of services: from the environment or the configuration file, and never shown."""

from __future__ import annotations

import os
import re
import stat
import tomllib
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import SplitResult, unquote, urlsplit, urlunsplit

from scenelang.backends.files import user_folder
from scenelang.grammar.diagnostics import SceneError

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
        raise SceneError("file", f"{config_file()}: `{family}` is no table")
    key = next((os.environ[name] for name in key_variables if os.environ.get(name)), None) or table.get("api_key")
    if key is not None and not (isinstance(key, str) and _KEY.fullmatch(key.strip())):
        raise SceneError("model-key", f"the key for `{family}` is no text that a key can be")
    if key is None and needs_key:
        message = f"there is no key for `{family}`: neither in the environment nor in {config_file()}"
        raise SceneError("model-key", message, f"export {key_variables[0]}=...")
    address = os.environ.get(address_variable) or table.get("base_url") or default_address
    if not isinstance(address, str) or not _is_address(address.strip()):
        raise SceneError("value", f"the base URL for `{family}` is no address", "it begins with http:// or https://")
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
