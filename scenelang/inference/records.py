"""Run folders: record every request, answer and evaluation of a run, so that it can be inspected and resumed.

run.json                  task, settings and state
input-1.png               input images of the task
sample-1/01-draft/        request.json, picture-1.png ..., reply.json, answer.txt, program.scene, diagnostics.txt
best.scene                resulting program
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime
from ipaddress import ip_address
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, get_type_hints
from urllib.parse import urlsplit

from scenelang.backends.files import atomic_write, write_json
from scenelang.backends.language_models import catalogue
from scenelang.backends.language_models.catalogue import TIMEOUT
from scenelang.backends.language_models.client import (
    Answer,
    Budget,
    Client,
    ReplyCache,
    reply_cache_folder,
    reply_data,
    reply_of,
)
from scenelang.backends.language_models.provider import Provider, connect, find_family
from scenelang.console.reports import table
from scenelang.grammar.datum import asdict, dataclass
from scenelang.grammar.diagnostics import SceneError, UsageError, printable, suggest, to_json
from scenelang.grammar.settings import dollars, seconds, setting, settings_in, whole
from scenelang.inference.brief import Notation
from scenelang.inference.steps import SamplePlan, Speaker, Verdict
from scenelang.interpreter.loading import user_folder

_PRIVATE = 0o700
_VERSION = 1
_SLUG = re.compile(r"[^a-z0-9]+")
_MAX_SLUG_LENGTH = 40
_ATTEMPT = re.compile(r"(\d+)-([a-z]+)\Z")


def runs_folder(chosen: str | None) -> Path:
    """Return the folder of runs: ``chosen``, else $SCENELANG_RUNS, else the user's state folder."""
    given = chosen or os.environ.get("SCENELANG_RUNS")
    if given:
        return Path(given)
    return user_folder("STATE") / "runs"


@dataclass(frozen=True, slots=True)
class Attempt:
    """A recorded request of a run."""

    sample: int
    number: int
    purpose: str
    facts: Mapping[str, Any]

    @property
    def cost(self) -> float:
        return float(self.facts.get("cost", 0.0))

    def data(self) -> dict[str, Any]:
        """Return the request's result as JSON data; ``usable`` is None if the answer was not evaluated."""
        usage = self.facts.get("usage", {})
        sent = sum(int(usage.get(name, 0)) for name in ("sent", "cache_read", "cache_written"))
        return {
            "sample": self.sample,
            "number": self.number,
            "purpose": self.purpose,
            "ended": str(self.facts.get("stop", "")),
            "tokens": {"sent": sent, "answered": int(usage.get("answered", 0))},
            "cost": self.cost,
            "was_kept": bool(self.facts.get("was_kept")),
            "usable": self.facts.get("usable"),
            "errors": sum(d.get("severity") == "error" for d in self.facts.get("diagnostics", [])),
            "findings": len(self.facts.get("findings", [])),
        }


class Run:
    """A run of ``generate`` or ``edit``: its folder with every request and answer.

    ``summary()`` returns JSON data, ``attempts()`` the requests. ``clean`` removes secrets from everything written.
    """

    def __init__(self, path: Path, clean: Callable[[str], str] = str) -> None:
        self.path = path
        self._clean = clean

    # --- the run ---------------------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        return f"<Run {self.name} in {self.path.parent}>"

    @property
    def name(self) -> str:
        return self.path.name

    @property
    def facts(self) -> dict[str, Any]:
        """Contents of run.json. Raises SceneError if the folder is not a run."""
        try:
            data = json.loads((self.path / "run.json").read_text("utf-8"))
        except (OSError, ValueError, RecursionError):
            raise SceneError("run", f"{self.path} is not a run folder") from None
        if not isinstance(data, dict) or data.get("version") != _VERSION:
            raise SceneError("run", f"{self.path} was written by an incompatible version")
        return data

    def note(self, **facts: Any) -> None:
        """Update fields of run.json."""
        path = self.path / "run.json"
        old = self.facts if path.exists() else {"version": _VERSION}
        write_json(path, json.loads(self._clean(json.dumps({**old, **facts}))))

    def keep(self, name: str, data: bytes) -> None:
        """Write a file of the run atomically."""
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as temporary:
            temporary.write_bytes(data)

    def keep_text(self, name: str, text: str) -> None:
        """Write a text file of the run, with secrets removed."""
        self.keep(name, self._clean(text).encode("utf-8", "replace"))

    # --- attempts --------------------------------------------------------------------------------------------------

    def recorded(self, sample: int, number: int, key: str) -> Answer | None:
        """Return the recorded answer to a request with the same key, or None."""
        facts = self._reply_facts(sample, number)
        if facts is None or facts.get("key") != key:
            return None
        return _answer_of(facts)

    def _reply_facts(self, sample: int, number: int) -> dict[str, Any] | None:
        """Return the record of a request's answer, or None if it is missing or damaged."""
        replies = map(_reply_in, self._folder(sample).glob(f"{number:02d}-*"))
        return next((facts for facts in replies if facts is not None), None)

    def asked(self, sample: int, number: int, purpose: str, payload: Mapping[str, Any]) -> None:
        """Record a request before it is sent; images are saved as files."""
        folder = self._attempt(sample, number, purpose)
        pictures: list[bytes] = []
        data = _without_pictures(payload, pictures)
        for position, picture in enumerate(pictures, 1):
            self.keep(f"{folder}/picture-{position}.png", picture)
        self.keep_text(f"{folder}/request.json", json.dumps(data, indent=1, ensure_ascii=False))

    @contextmanager
    def sending(self, sample: int, number: int, purpose: str) -> Iterator[Callable[[float], None]]:
        """Record the maximum cost of a request while it is in flight. If the process is killed or interrupted the
        record remains and counts as spent, since the service may charge for the request."""
        path = f"{self._attempt(sample, number, purpose)}/sent.json"
        before = _lost(self.path / path)
        amounts: list[float] = []

        def note(amount: float) -> None:
            amounts.append(amount)
            self.keep_text(path, json.dumps({"lost": before + sum(amounts)}))

        def settle() -> None:
            if amounts:
                self.keep_text(path, json.dumps({"lost": before}))

        try:
            yield note
        except SceneError:
            settle()
            raise
        settle()

    def answered(self, sample: int, number: int, purpose: str, key: str, answer: Answer) -> None:
        """Record an answer."""
        folder = self._attempt(sample, number, purpose)
        facts = reply_data(answer.reply) | {"key": key, "cost": answer.cost, "was_kept": answer.was_cached}
        self.keep_text(f"{folder}/answer.txt", answer.reply.text)
        self.keep_text(f"{folder}/reply.json", json.dumps(facts))

    def judged(self, sample: int, number: int, purpose: str, verdict: Verdict) -> None:
        """Record the evaluation of an answer."""
        folder = self._attempt(sample, number, purpose)
        self.keep_text(f"{folder}/program.scene", verdict.program)
        self.keep_text(f"{folder}/diagnostics.txt", verdict.report_text())
        facts = {
            "usable": verdict.is_usable,
            "diagnostics": [to_json(d) for d in verdict.diagnostics],
            "findings": [to_json(d) for d in verdict.findings],
        }
        self.keep_text(f"{folder}/verdict.json", json.dumps(facts))

    def attempts(self) -> Iterator[Attempt]:
        """Yield all answered requests, ordered by sample and number."""
        for folder in sorted(self.path.glob("sample-*/*")):
            match = _ATTEMPT.fullmatch(folder.name)
            sample = folder.parent.name.removeprefix("sample-")
            facts = _reply_in(folder) if match and sample.isdecimal() else None
            if match is not None and facts is not None:
                yield Attempt(int(sample), int(match[1]), match[2], facts | _json_object(folder / "verdict.json"))

    @property
    def spent(self) -> float:
        """Cost in US dollars, including the possible cost of interrupted requests."""
        lost = sum(_lost(path) for path in self.path.glob("sample-*/*/sent.json"))
        return lost + sum(attempt.cost for attempt in self.attempts())

    def summary(self) -> dict[str, Any]:
        """Return a summary as JSON data; the ``state`` of an unreadable folder is "damaged"."""
        summary = {"name": self.name, "path": str(self.path)}
        try:
            facts = self.facts
            task = facts["task"]["text"] or "a reconstruction"
            command, state = str(facts["command"]), self.state
        except (SceneError, KeyError, TypeError):
            return summary | {"command": "", "state": "damaged", "attempts": 0, "cost": 0.0, "task": ""}
        shown = printable(" ".join(str(task).split()))
        attempts = len(list(self.attempts()))
        return summary | {
            "command": command, "state": state, "attempts": attempts, "cost": self.spent, "task": shown,
        }  # fmt: skip

    def _folder(self, sample: int) -> Path:
        return self.path / f"sample-{sample}"

    @staticmethod
    def _attempt(sample: int, number: int, purpose: str) -> str:
        return f"sample-{sample}/{number:02d}-{purpose}"

    # --- locking: one process at a time ----------------------------------------------------------------------------

    @property
    def state(self) -> str:
        """State of the run; a run recorded as running that no process has locked was interrupted."""
        state = str(self.facts.get("state", "?"))
        if state != "running":
            return state
        try:
            with self.claimed():
                return "interrupted"
        except SceneError:
            return state

    @contextmanager
    def claimed(self) -> Iterator[None]:
        """Lock the run. Raises SceneError if another process has locked it."""
        try:
            import fcntl
        except ImportError:
            yield
            return
        file = os.open(self.path / ".lock", os.O_RDWR | os.O_CREAT, 0o600)
        try:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise SceneError("run", f"another process is using the run {self.name}") from None
            yield
        finally:
            os.close(file)


def _reply_in(folder: Path) -> dict[str, Any] | None:
    """Return the recorded answer in an attempt's folder, or None if it is missing or damaged."""
    facts = _json_object(folder / "reply.json")
    return facts if facts and _answer_of(facts) is not None else None


def _answer_of(facts: Mapping[str, Any]) -> Answer | None:
    """Parse a recorded answer; returns None if it is damaged."""
    try:
        answer = Answer(reply_of(facts), float(facts["cost"]), bool(facts["was_kept"]))
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        return None
    return answer if isfinite(answer.cost) and answer.cost >= 0 else None


def _lost(path: Path) -> float:
    """Return the possible cost of unanswered requests in US dollars."""
    try:
        amount = float(_json_object(path).get("lost", 0.0))
    except (TypeError, ValueError, OverflowError):
        return 0.0
    return amount if isfinite(amount) and amount > 0 else 0.0


def _json_object(path: Path) -> dict[str, Any]:
    """Read a JSON object; returns an empty one if the file cannot be read."""
    try:
        data = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return data if isinstance(data, dict) else {}


def _without_pictures(data: Any, pictures: list[bytes]) -> Any:
    """Replace the image data in a payload by file names, and collect the images."""
    if isinstance(data, Mapping):
        return {name: _without_pictures(value, pictures) for name, value in data.items()}
    if isinstance(data, list):
        return [_without_pictures(item, pictures) for item in data]
    if isinstance(data, str) and len(data) > 2_000:
        encoded = data.rpartition(";base64,")[2] if data.startswith("data:") else data
        try:
            picture = base64.b64decode(encoded, validate=True)
        except ValueError:
            return data
        pictures.append(picture)
        return f"picture-{len(pictures)}.png, sha256 {hashlib.sha256(picture).hexdigest()}"
    return data


# --- run folders ---------------------------------------------------------------------------------------------------


def new_run(folder: Path, text: str, clean: Callable[[str], str]) -> Run:
    """Create a run folder named by time and task. Raises SceneError if that fails."""
    slug = _SLUG.sub("-", clean(text).lower()).strip("-")[:_MAX_SLUG_LENGTH].rstrip("-") or "run"
    stamp = datetime.now().strftime("%Y%m%d-%H%M%S-%f")[:-3]  # milliseconds, so that names sort by time
    try:
        folder.mkdir(mode=_PRIVATE, parents=True, exist_ok=True)
        for number in range(1, 1000):
            path = folder / (f"{stamp}-{slug}" if number == 1 else f"{stamp}-{slug}-{number}")
            try:
                path.mkdir(mode=_PRIVATE)
            except FileExistsError:
                continue
            return Run(path, clean)
    except OSError as error:
        raise SceneError("file", f"cannot create a run in {folder}: {error.strerror or error}") from None
    raise SceneError("file", f"cannot create a run in {folder}: too many runs started at once")


def all_runs(folder: Path) -> list[Run]:
    """Return the runs in a folder, oldest first."""
    if not folder.is_dir():
        return []
    return [Run(path) for path in sorted(folder.iterdir()) if (path / "run.json").is_file()]


def find_run(folder: Path, name: str, clean: Callable[[str], str] = str) -> Run:
    """Find a run by name, unambiguous prefix, path, or ``last``. Raises SceneError."""
    if (Path(name) / "run.json").is_file():
        return Run(Path(name), clean)
    runs = all_runs(folder)
    if name == "last" and runs:
        return Run(runs[-1].path, clean)
    exact = [run for run in runs if run.name == name]
    matching = exact or [run for run in runs if run.name.startswith(name)]
    if len(matching) == 1:
        return Run(matching[0].path, clean)
    if matching:
        raise SceneError("run", f"ambiguous run name `{name[:60]}`: {', '.join(run.name for run in matching[:5])}")
    hint = suggest(name, [run.name for run in runs]) or f"see `scenelang runs` for the runs in {folder}"
    raise SceneError("run", f"unknown run `{name[:60]}`", hint)


# Settings of a run: model, limits, number of samples; saved in the run folder for resuming.


_DEFAULT_TOKENS = 32_000
REVISIONS = 6  # of a scene that is built, by default
# Inclusive ranges of settings.
LIMITS: Mapping[str, tuple[float, float]] = MappingProxyType({
    "samples": (1, 64),
    "repairs": (0, 20),
    "critiques": (0, 20),
    "revisions": (0, 100),
    "max_run_tokens": (1, 1_000_000_000),
    "max_run_seconds": (1, 1_000_000),
    "side_by_side": (1, 64),
    "max_tokens": (1, 10_000_000),
    "max_cost": (1e-9, 1e9),
    "timeout": (0.1, 86_400),
})  # fmt: skip
RENEWABLE = (
    "samples",
    "repairs",
    "critiques",
    "revisions",
    "side_by_side",
    "max_cost",
    "max_run_tokens",
    "max_seconds",
)  # fmt: skip; may change when a run is resumed
Typed = TypeVar("Typed")


@dataclass(frozen=True, slots=True)
class InferenceSettings:
    """Settings of language-model inference.

    ``max_cost`` is in US dollars; ``price`` has the form "INPUT,OUTPUT", in dollars per million tokens.
    """

    provider: str = setting(
        "anthropic",
        "provider: anthropic (default), openai (any chat completions server), or a plug-in's",
        metavar="NAME",
    )
    model: str | None = setting(None, "model (default: the provider's)", metavar="NAME")
    price: str | None = setting(
        None, "dollars per million input and output tokens, for a model of unknown price", metavar="IN,OUT"
    )
    effort: str | None = setting(
        None, "reasoning effort: low, medium, high, xhigh or max, as supported by the model", metavar="LEVEL"
    )
    max_tokens: int | None = setting(
        None, "maximum tokens of one answer (default 32,000, or the model's maximum)", metavar="N", read=whole
    )
    max_cost: float = setting(5.0, "maximum cost of the run (default 5)", metavar="DOLLARS", read=dollars)
    samples: int = setting(
        1, "number of samples, of which the best is selected (default 1)", "-n", "--samples", metavar="N", read=whole
    )
    repairs: int = setting(3, "maximum number of repairs per sample (default 3)", "--repair", metavar="N", read=whole)
    critiques: int = setting(
        0, "number of critiques by rendered images (default 0)", "--critique", metavar="N", read=whole
    )
    acceptance: bool = setting(
        False, "let the model state first what must hold, and test its scene and every later edit against it"
    )
    revisions: int | None = setting(
        None, "maximum number of revisions of a scene that is built (default 6)", "--turns", metavar="N", read=whole
    )
    max_run_tokens: int | None = setting(
        None, "maximum tokens of the run, sent and answered (default: no limit)", metavar="N", read=whole
    )
    max_run_seconds: float | None = setting(
        None, "seconds after which no further request is sent (default: no limit)", metavar="SECONDS", read=seconds
    )
    sends_images: bool = setting(True, "send no images of scenes, for a model that reads none", "--no-images")
    side_by_side: int = setting(4, "number of concurrent samples (default 4)", "--jobs", metavar="N", read=whole)
    is_batch: bool = setting(False, "use the batch API: half the price, up to a day", "--batch")
    uses_replies: bool = setting(True, "disable the cache of answers", "--no-cache")
    prompt_dir: str | None = setting(None, "folder of prompt templates that override the package's", metavar="DIR")
    timeout: float = setting(
        TIMEOUT, "timeout without data from the service, for each of three attempts (default 120)",
        metavar="SECONDS", read=seconds,
    )  # fmt: skip

    def data(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def plan(self) -> SamplePlan:
        return SamplePlan(self.repairs, self.critiques, self.acceptance, self.revisions, self.sends_images)

    @property
    def prompts_folder(self) -> Path | None:
        return Path(self.prompt_dir) if self.prompt_dir is not None else None

    @property
    def model_name(self) -> str:
        """Name of the model. Raises SceneError if none is selected and the provider has no default."""
        name = self.model or find_family(self.provider).default_model
        if name is None:
            raise SceneError("value", f"the provider `{self.provider}` has no default model", "select one with --model")
        return name

    def known_model(self, provider: Provider | None) -> catalogue.Model:
        """Return the properties of the model; local models are free. Raises SceneError for an unknown price."""
        is_free = self.provider != "anthropic" and provider is not None and is_local(provider.address)
        return catalogue.find_model(self.model_name, self.price, is_free)

    def client(self, spent: float = 0.0) -> Client:
        """Connect to the provider; ``spent`` dollars of the cost limit are already used. Raises SceneError."""
        provider = connect(self.provider, self.timeout)
        replies = ReplyCache(reply_cache_folder()) if self.uses_replies else None
        return Client(provider, self.known_model(provider), Budget(self.max_cost, spent), replies)

    def sends_grammar(self, notation: Notation) -> bool:
        """Return whether answers are constrained by the language's grammar, if the server supports it."""
        return notation is Notation.LANGUAGE and self.provider != "anthropic"

    def speaker(self, model: catalogue.Model, notation: Notation) -> Speaker:
        """Return the request parameters of the model. Raises SceneError for an unsupported effort."""
        tokens = self.max_tokens or min(_DEFAULT_TOKENS, model.max_output)
        if tokens > model.max_output:
            hint = f"its maximum is {model.max_output:,}"
            raise SceneError("value", f"`{model.name}` does not support answers of {tokens:,} tokens", hint)
        grammar = _grammar() if self.sends_grammar(notation) else None
        most_tokens = self.max_tokens or model.max_output
        return Speaker(model.name, tokens, most_tokens, model.thinking, model.check_effort(self.effort), grammar)


def check_limits(given: Mapping[str, Any], as_flags: bool = False) -> None:
    """Raise UsageError for a setting out of its range; ``as_flags`` names it by its command-line option."""
    flags = {name: each.flags[0] for name, each in settings_in(InferenceSettings).items()}
    for name, (low, high) in LIMITS.items():
        value = given.get(name)
        if value is not None and not low <= value <= high:
            shown = flags[name] if as_flags else f"`{name}`"
            raise UsageError("value", f"expected {shown} between {low:,} and {high:,}, got {value:,}")


def settings_of(data: Mapping[str, Any]) -> InferenceSettings:
    """Parse saved settings, the inverse of ``InferenceSettings.data``. Raises SceneError for invalid data."""
    try:
        settings = typed(InferenceSettings, data)
    except TypeError:
        raise SceneError("run", "cannot read the settings of the run") from None
    for name, (low, high) in LIMITS.items():
        value = getattr(settings, name)
        if value is not None and not low <= value <= high:
            raise SceneError("run", f"cannot read the settings of the run: `{name}` is {value}")
    return settings


def typed(kind: type[Typed], data: Mapping[str, Any]) -> Typed:
    """Construct a dataclass from JSON data. Raises TypeError for unknown fields or wrong types."""
    instance = kind(**data)
    for name, hint in get_type_hints(kind).items():
        expected_type = (int, float) if hint is float else hint
        if not isinstance(getattr(instance, name), expected_type):
            raise TypeError(name)
    return instance


def is_local(address: str) -> bool:
    """Return whether an address refers to this machine."""
    host = urlsplit(address).hostname or ""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _grammar() -> str:
    from scenelang.grammar.export.notations import gbnf_text
    from scenelang.interpreter.expand.forms import full_grammar

    return gbnf_text(full_grammar())


# Formatting: a list of runs, and the attempts of one run.


_MAX_TASK_LENGTH = 60


def list_of_runs(summaries: Iterable[Mapping[str, Any]]) -> str:
    """Format the summaries of runs as a table."""
    rows = [
        (f["name"], f["command"], f["state"], str(f["attempts"]), f"${f['cost']:.4f}", _short(f["task"]))
        for f in summaries
    ]
    header = ("run", "command", "state", "attempts", "cost", "task")
    return table([header, *rows], (False, False, False, True, True, False))


def run_facts(run: Run) -> tuple[dict[str, Any], list[Attempt]]:
    """Return the summary of a run and its attempts; raises SceneError if the run is damaged."""
    facts = run.summary()
    if facts["state"] == "damaged":
        raise SceneError("run", f"the run {run.name} is damaged")
    return facts, list(run.attempts())


def run_report(run: Run, facts: Mapping[str, Any], attempts: Sequence[Attempt]) -> str:
    """Format a run and its attempts."""
    header = ("sample", "attempt", "purpose", "stop", "input", "output", "cost", "result")
    rows = [header, *map(_attempt_row, attempts)]
    return "\n".join((
        f"{facts['name']}: {facts['command']}, {facts['state']}, ${facts['cost']:.4f}",
        _short(facts["task"]),
        str(run.path),
        table(rows, (True, True, False, False, True, True, True, False)),
    ))  # fmt: skip


def _short(text: str) -> str:
    return text if len(text) <= _MAX_TASK_LENGTH else text[: _MAX_TASK_LENGTH - 3] + "..."


def _attempt_row(attempt: Attempt) -> tuple[str, ...]:
    data = attempt.data()
    cost = "cached" if data["was_kept"] else f"${data['cost']:.4f}"
    sample = str(attempt.sample) if attempt.sample else "-"
    sent, answered = f"{data['tokens']['sent']:,}", f"{data['tokens']['answered']:,}"
    return sample, str(attempt.number), attempt.purpose, data["ended"], sent, answered, cost, _came_to(data)


def _came_to(data: Mapping[str, Any]) -> str:
    if data["usable"] is None:
        return ""
    if data["usable"]:
        return f"a scene, {data['findings']} findings" if data["findings"] else "a scene"
    return f"{data['errors']} error{'' if data['errors'] == 1 else 's'}"
