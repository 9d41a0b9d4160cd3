"""What a provider of language models is, how one is found, and what goes wrong with them in users' words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any, Protocol, TypeVar

from scenelang.backends.base import PluginRegistry
from scenelang.backends.language_models.catalogue import TIMEOUT, Account, Reply, Request, account
from scenelang.grammar.diagnostics import SceneError

Piece = TypeVar("Piece")
Watch = Callable[[str], None]  # told of every piece of text as it arrives; raises to stop


class Provider(Protocol):
    """A family of models behind a service. Its methods raise SceneError: ``model-offline``, ``model-key``,
    ``model-request``."""

    @property
    def name(self) -> str: ...

    @property
    def address(self) -> str:
        """Where requests go, without anything secret."""

    def clean(self, text: str) -> str:
        """A text without the key and other secrets."""

    def payload(self, request: Request) -> dict[str, Any]:
        """What is sent for a request, as JSON data."""

    def count(self, request: Request) -> int:
        """The tokens of what is sent, as the service counts them or as an upper estimate."""

    def send(self, request: Request, watch: Watch) -> Reply:
        """Send a request and read the answer as it comes. An answer that breaks off has ``Stop.BROKEN``."""


class BatchProvider(Provider, Protocol):
    """A provider that also takes many requests at once, cheaper and later."""

    def submit(self, requests: Mapping[str, Request]) -> str:
        """Send requests by name; the batch's identifier."""

    def pending(self, batch: str) -> int:
        """How many requests of a batch are not done yet."""

    def collect(self, batch: str) -> dict[str, Reply | SceneError]:
        """The answers of a batch that is done, by name."""


@dataclass(frozen=True, slots=True)
class Family:
    """A provider before it is connected: where its key and address come from, and how it is made. Packages add their
    own through the entry-point group ``scenelang.providers``."""

    name: str
    doc: str
    default_model: str | None
    connect: Callable[[Account], Provider]
    key_variables: tuple[str, ...]
    address_variable: str
    default_address: str
    needs_key: bool = True
    package: str | None = None  # that it imports when a request is sent


PROVIDERS = PluginRegistry("scenelang.providers", "provider", Family, error="value")


def family(name: str) -> Family:
    """The family of a name; raises SceneError with the nearest one."""
    return PROVIDERS.find(name)


def connect(name: str, timeout: float = TIMEOUT) -> Provider:
    """The provider of a name, with its key and address from the environment or the configuration. Raises SceneError."""
    found = family(name)
    if found.package is not None and not is_installed(found.package):
        message = f"the provider `{name}` needs the package `{found.package}`"
        raise SceneError("model-request", message, "pip install 'scenelang[lm]'")
    return found.connect(replace(connection(found), timeout=timeout))


def is_installed(package: str) -> bool:
    """Whether a package can be imported; imports nothing."""
    try:
        return find_spec(package) is not None
    except ValueError:  # it was imported without a spec, or its import is blocked
        return False


def connection(family: Family) -> Account:
    """The key and the address of a family, from the environment or the configuration. Raises SceneError."""
    variables = family.key_variables
    return account(family.name, variables, family.address_variable, family.default_address, family.needs_key)


def unconnected(name: str) -> Provider:
    """The provider of a name for what needs no service: it has no key, and nothing may be sent through it."""
    found = family(name)
    return found.connect(account(found.name, (), found.address_variable, found.default_address, needs_key=False))


LONGEST_ANSWER = 2_000_000  # characters; the longest answers of models have a tenth


class BrokenStream(Exception):
    """An answer ended too early, or made no sense on its way."""


def arriving(pieces: Iterable[Piece]) -> Iterator[Piece]:
    """The pieces of an answer. Whatever goes wrong while they are read, which libraries have no common class for, is a
    BrokenStream; what goes wrong where they are used is not."""
    received = 0
    try:
        for piece in pieces:
            received += len(piece) if isinstance(piece, str) else 0
            if received > LONGEST_ANSWER:
                raise BrokenStream(f"it is longer than {LONGEST_ANSWER:,} characters")
            yield piece
    except BrokenStream:
        raise
    except Exception as error:
        raise BrokenStream(getattr(error, "api_message", None) or str(error) or "the stream ended early") from None


@contextmanager
def told(package: Any, base: type[Exception], account: Account) -> Iterator[None]:
    """Turns what an SDK raises into errors in users' words. The SDKs of both families name their exceptions alike;
    ``base`` is what all those of ``package`` derive from."""
    try:
        yield
    except package.APIStatusError as error:
        said = getattr(error, "api_message", None) or error.message
        raise failure(error.status_code, said, account) from None
    except package.APITimeoutError:
        said = f"{account.shown_address} did not answer within {account.timeout:g} seconds, several times"
        raise SceneError("model-offline", said, "--timeout waits longer") from None
    except package.APIConnectionError as error:
        raise unreachable(account, str(error.__cause__ or error)) from None
    except base as error:
        raise failure(None, str(error), account) from None


def failure(status: int | None, said: str, account: Account) -> SceneError:
    """What a service's refusal of a request means, by its HTTP status."""
    name, message, hint = _FAILURES.get(status or 0, ("model-request", "the service failed", None))
    if status is not None and status >= 500 and status not in _FAILURES:
        message, hint = "the service failed", "try again later"
    shown = account.clean(" ".join(said.split()))[:300]
    code = f" ({status})" if status else ""
    return SceneError(name, f"{message}{code}" + (f": {shown}" if shown else ""), hint)


_FAILURES: dict[int, tuple[str, str, str | None]] = {
    400: ("model-request", "the service does not accept the request", None),
    401: ("model-key", "the service does not accept the key", "check the key in the environment or the configuration"),
    402: ("model-key", "the account has no credit", None),
    403: ("model-key", "the key may not do this", None),
    404: ("model-request", "the service does not know the model or the address", "check --model and the base URL"),
    413: ("model-request", "the request is too large", "send smaller or fewer pictures"),
    429: ("model-request", "too many requests for this account", "wait a while, then continue with --resume"),
    529: ("model-request", "the service is overloaded", "wait a while, then continue with --resume"),
}


def unreachable(account: Account, reason: str) -> SceneError:
    """The one line for a machine that is offline, or a service that is down."""
    shown = account.clean(" ".join(reason.split()))[:160]
    return SceneError(
        "model-offline", f"cannot reach {account.shown_address}" + (f": {shown}" if shown else ""),
        "is this machine offline? `--dry-run` shows what would be sent",
    )  # fmt: skip
