"""How a run asks: model, limits, number of samples; as data that a run folder keeps, so that it can go on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from ipaddress import ip_address
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, get_type_hints
from urllib.parse import urlsplit

from scenelang.backends.language_models import catalogue
from scenelang.backends.language_models.client import Client
from scenelang.backends.language_models.credentials import TIMEOUT
from scenelang.backends.language_models.provider import Provider, connect, family
from scenelang.backends.language_models.replies import Replies, reply_folder
from scenelang.backends.language_models.spending import Spending
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.steps import Plan, Speaker
from scenelang.inference.task import Notation

_DEFAULT_TOKENS = 32_000
# What settings may be, both ends included.
LIMITS: Mapping[str, tuple[float, float]] = MappingProxyType({
    "samples": (1, 64),
    "repairs": (0, 20),
    "critiques": (0, 20),
    "side_by_side": (1, 64),
    "max_tokens": (1, 10_000_000),
    "max_cost": (1e-9, 1e9),
    "timeout": (0.1, 86_400),
})  # fmt: skip
Typed = TypeVar("Typed")


@dataclass(frozen=True, slots=True)
class Settings:
    """``max_cost`` in US dollars; ``price`` as "INPUT,OUTPUT" in dollars per million tokens."""

    provider: str = "anthropic"
    model: str | None = None
    price: str | None = None
    effort: str | None = None
    max_tokens: int | None = None
    max_cost: float = 5.0
    samples: int = 1
    repairs: int = 3
    critiques: int = 0
    side_by_side: int = 4
    is_batch: bool = False
    uses_replies: bool = True
    prompt_dir: str | None = None
    timeout: float = TIMEOUT

    def data(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def plan(self) -> Plan:
        return Plan(self.repairs, self.critiques)

    @property
    def prompts_folder(self) -> Path | None:
        return Path(self.prompt_dir) if self.prompt_dir is not None else None

    @property
    def model_name(self) -> str:
        """The model to ask. Raises SceneError where none is chosen and the provider has no default."""
        name = self.model or family(self.provider).default_model
        if name is None:
            raise SceneError("value", f"the provider `{self.provider}` has no default model", "name one with --model")
        return name

    def known_model(self, provider: Provider | None) -> catalogue.Model:
        """What is known of the model; one on this machine costs nothing. Raises SceneError for an unknown price."""
        is_free = self.provider != "anthropic" and provider is not None and is_local(provider.address)
        return catalogue.model(self.model_name, self.price, is_free)

    def client(self, spent: float = 0.0) -> Client:
        """Connected to the provider, with ``spent`` dollars of the limit gone. Raises SceneError."""
        provider = connect(self.provider, self.timeout)
        replies = Replies(reply_folder()) if self.uses_replies else None
        return Client(provider, self.known_model(provider), Spending(self.max_cost, spent), replies)

    def sends_grammar(self, notation: Notation) -> bool:
        """Whether answers are held to the language's grammar, where the server can."""
        return notation is Notation.LANGUAGE and self.provider != "anthropic"

    def speaker(self, model: catalogue.Model, notation: Notation) -> Speaker:
        """How requests to the model are made. Raises SceneError for an effort that it does not know."""
        wanted = self.max_tokens or min(_DEFAULT_TOKENS, model.max_output)
        if wanted > model.max_output:
            hint = f"its answers have at most {model.max_output:,}"
            raise SceneError("value", f"`{model.name}` does not answer with {wanted:,} tokens", hint)
        grammar = _grammar() if self.sends_grammar(notation) else None
        most = self.max_tokens or model.max_output
        return Speaker(model.name, wanted, most, model.thinking, model.effort(self.effort), grammar)


def settings_of(data: Mapping[str, Any]) -> Settings:
    """The inverse of ``Settings.data``. Raises SceneError for data that is none."""
    try:
        found = typed(Settings, data)
    except TypeError:
        raise SceneError("run", "the settings of the run cannot be read") from None
    for name, (low, high) in LIMITS.items():
        value = getattr(found, name)
        if value is not None and not low <= value <= high:
            raise SceneError("run", f"the settings of the run cannot be read: `{name}` is {value}")
    return found


def typed(kind: type[Typed], data: Mapping[str, Any]) -> Typed:
    """A data class of JSON data. Raises TypeError for fields that it has not, or of another type."""
    found = kind(**data)
    for name, hint in get_type_hints(kind).items():
        wanted = (int, float) if hint is float else hint
        if not isinstance(getattr(found, name), wanted):
            raise TypeError(name)
    return found


def is_local(address: str) -> bool:
    """Whether an address is this machine's own."""
    host = urlsplit(address).hostname or ""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _grammar() -> str:
    from scenelang.grammar.export.gbnf import gbnf_text
    from scenelang.interpreter.surface import full_grammar

    return gbnf_text(full_grammar())
