"""Providers of language models: interface, discovery, and translation of errors."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any, Protocol, TypeVar

from scenelang.backends.language_models.catalogue import TIMEOUT, Account, Reply, Request, load_account
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.plugins import PluginRegistry

Piece = TypeVar("Piece")
OnText = Callable[[str], None]  # called with every chunk of text as it arrives; an exception cancels the request


class Provider(Protocol):
    """Connection to a service. Its methods raise SceneError: "model-offline", "model-key", "model-request"."""

    @property
    def name(self) -> str: ...

    @property
    def address(self) -> str:
        """Base URL without secrets."""

    def redact(self, text: str) -> str:
        """Remove the API key and other secrets from a text."""

    def payload(self, request: Request) -> dict[str, Any]:
        """Return the body of a request as JSON data."""

    def count(self, request: Request) -> int:
        """Return the number of input tokens, as counted by the service, or an upper bound."""

    def send(self, request: Request, on_text: OnText) -> Reply:
        """Send a request and stream the reply; an interrupted reply has ``StopReason.INTERRUPTED``."""


class BatchProvider(Provider, Protocol):
    """Provider with batch processing of requests, at lower prices and with longer delays."""

    def submit(self, requests: Mapping[str, Request]) -> str:
        """Submit requests by name; returns the identifier of the batch."""

    def pending(self, batch: str) -> int:
        """Return the number of unfinished requests of a batch."""

    def collect(self, batch: str) -> dict[str, Reply | SceneError]:
        """Return the replies of a finished batch by name."""


@dataclass(frozen=True, slots=True)
class Family:
    """Type of provider, registered in the entry-point group ``scenelang.providers``.

    Attributes
    ----------
    name, doc
        Name, and one-line description.
    default_model
        Model that is used by default.
    connect
        Creates a provider for an account.
    key_variables, address_variable
        Environment variables of API key and base URL.
    default_address
        Default base URL.
    needs_key
        Whether an API key is required.
    package
        Package that is imported to send requests.
    """

    name: str
    doc: str
    default_model: str | None
    connect: Callable[[Account], Provider]
    key_variables: tuple[str, ...]
    address_variable: str
    default_address: str
    needs_key: bool = True
    package: str | None = None


PROVIDERS = PluginRegistry("scenelang.providers", "provider", Family, error="value")


def find_family(name: str) -> Family:
    """Return the provider type ``name``; raises SceneError if it does not exist."""
    return PROVIDERS.find(name)


def connect(name: str, timeout: float = TIMEOUT) -> Provider:
    """Return the provider ``name``, with API key and base URL from the environment or the configuration file.

    Raises SceneError.
    """
    family = find_family(name)
    if family.package is not None and not is_installed(family.package):
        message = f"the provider `{name}` requires the package `{family.package}`"
        raise SceneError("model-request", message, "install it with `pip install 'scenelang[lm]'`")
    return family.connect(replace(account_of(family), timeout=timeout))


def is_installed(package: str) -> bool:
    """Return whether a package can be imported, without importing it."""
    try:
        return find_spec(package) is not None
    except ValueError:  # it was imported without a spec, or its import is blocked
        return False


def account_of(family: Family) -> Account:
    """Return API key and base URL of a provider, from the environment or the configuration file; raises SceneError."""
    variables = family.key_variables
    return load_account(family.name, variables, family.address_variable, family.default_address, family.needs_key)


def offline_provider(name: str) -> Provider:
    """Return the provider ``name`` without an API key, for use without sending requests, such as estimates."""
    family = find_family(name)
    account = load_account(family.name, (), family.address_variable, family.default_address, needs_key=False)
    return family.connect(account)


MAX_REPLY_LENGTH = 2_000_000  # characters, ten times the longest replies of current models


class StreamError(Exception):
    """Error while reading a streamed reply."""


def read_stream(pieces: Iterable[Piece]) -> Iterator[Piece]:
    """Iterate over a streamed reply, with any error raised while reading converted to StreamError.

    The libraries' errors have no common class. Errors of the code that consumes the pieces are not converted.
    """
    received = 0
    try:
        for piece in pieces:
            received += len(piece) if isinstance(piece, str) else 0
            if received > MAX_REPLY_LENGTH:
                raise StreamError(f"it is longer than {MAX_REPLY_LENGTH:,} characters")
            yield piece
    except StreamError:
        raise
    except Exception as error:
        raise StreamError(getattr(error, "api_message", None) or str(error) or "the stream ended early") from None


@contextmanager
def translate_errors(package: Any, base: type[Exception], account: Account) -> Iterator[None]:
    """Translate the exceptions of an SDK to SceneError.

    The SDKs of OpenAI and Anthropic have equal class names; ``base`` is the base class of all exceptions of
    ``package``.
    """
    try:
        yield
    except package.APIStatusError as error:
        reason = getattr(error, "api_message", None) or error.message
        raise request_error(error.status_code, reason, account) from None
    except package.APITimeoutError:
        message = (
            f"no response from {account.public_address} within {account.timeout:g} seconds, after several attempts"
        )
        raise SceneError("model-offline", message, "increase the limit with --timeout") from None
    except package.APIConnectionError as error:
        raise offline_error(account, str(error.__cause__ or error)) from None
    except base as error:
        raise request_error(None, str(error), account) from None


def request_error(status: int | None, reason: str, account: Account) -> SceneError:
    """Return the error for a failed request, by its HTTP status."""
    name, message, hint = _STATUS_ERRORS.get(status or 0, ("model-request", "the service failed", None))
    if status is not None and status >= 500 and status not in _STATUS_ERRORS:
        message, hint = "the service failed", "try again later"
    shown = account.redact(" ".join(reason.split()))[:300]
    code = f" ({status})" if status else ""
    return SceneError(name, f"{message}{code}" + (f": {shown}" if shown else ""), hint)


_STATUS_ERRORS: dict[int, tuple[str, str, str | None]] = {
    400: ("model-request", "the service rejected the request", None),
    401: ("model-key", "the service rejected the API key", "check it in the environment or the configuration file"),
    402: ("model-key", "the account has no credit", None),
    403: ("model-key", "the API key lacks the permission", None),
    404: ("model-request", "unknown model or base URL", "check --model and the base URL"),
    413: ("model-request", "the request is too large", "send smaller or fewer images"),
    429: (
        "model-request",
        "the rate limit of the account is exceeded",
        "wait a while, then go on with --resume, `bench` without",
    ),
    529: ("model-request", "the service is overloaded", "wait a while, then go on with --resume, `bench` without"),
}


def offline_error(account: Account, reason: str) -> SceneError:
    """Return the error for a machine without network or a service that is down."""
    shown = account.redact(" ".join(reason.split()))[:160]
    return SceneError(
        "model-offline", f"cannot reach {account.public_address}" + (f": {shown}" if shown else ""),
        "check the network connection; `--dry-run` shows requests without sending them",
    )  # fmt: skip
