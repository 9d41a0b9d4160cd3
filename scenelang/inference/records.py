"""Run folders: every question, answer and verdict of one run, so that it can be read and continued.

run.json                  what was asked for, how it stands
input-1.png               pictures that came with the task
sample-1/01-draft/        request.json, picture-1.png ..., reply.json, answer.txt, program.scene, diagnostics.txt
best.scene                what the run came to
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import datetime
from ipaddress import ip_address
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, get_type_hints
from urllib.parse import urlsplit

from scenelang.backends.files import user_folder, write_json, written_whole
from scenelang.backends.language_models import catalogue
from scenelang.backends.language_models.catalogue import TIMEOUT
from scenelang.backends.language_models.client import (
    Answer,
    Client,
    Replies,
    Spending,
    reply_data,
    reply_folder,
    reply_of,
)
from scenelang.backends.language_models.provider import Provider, connect, family
from scenelang.grammar.diagnostics import SceneError, UsageError, printable, suggest, to_json
from scenelang.grammar.settings import dollars, seconds, setting, settings_in, whole
from scenelang.inference.brief import Notation
from scenelang.inference.steps import SamplePlan, Speaker, Verdict
from scenelang.reports import table

_PRIVATE = 0o700
_VERSION = 1
_SLUG = re.compile(r"[^a-z0-9]+")
_LONGEST_SLUG = 40
_ATTEMPT = re.compile(r"(\d+)-([a-z]+)\Z")


def runs_folder(chosen: str | None) -> Path:
    """Where runs are kept: the folder that was chosen, SCENELANG_RUNS, else the user's state folder."""
    given = chosen or os.environ.get("SCENELANG_RUNS")
    if given:
        return Path(given)
    return user_folder("STATE") / "runs"


@dataclass(frozen=True, slots=True)
class Attempt:
    """One question of a run as it is recorded."""

    sample: int
    number: int
    purpose: str
    facts: Mapping[str, Any]

    @property
    def cost(self) -> float:
        return float(self.facts.get("cost", 0.0))

    def data(self) -> dict[str, Any]:
        """What became of the question, as JSON data; ``usable`` is None where nothing was judged."""
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
    """One run of ``generate`` or ``edit``: its folder, with every question and answer. ``summary()`` is JSON data,
    ``attempts()`` what was asked. ``clean`` takes secrets out of all that is written."""

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
        """What run.json says. Raises SceneError for a folder that is no run."""
        try:
            data = json.loads((self.path / "run.json").read_text("utf-8"))
        except (OSError, ValueError, RecursionError):
            raise SceneError("run", f"{self.path} is no folder of a run") from None
        if not isinstance(data, dict) or data.get("version") != _VERSION:
            raise SceneError("run", f"{self.path} was written by another version")
        return data

    def note(self, **facts: Any) -> None:
        """Change what run.json says."""
        path = self.path / "run.json"
        old = self.facts if path.exists() else {"version": _VERSION}
        write_json(path, json.loads(self._clean(json.dumps({**old, **facts}))))

    def keep(self, name: str, data: bytes) -> None:
        """Write a file of the run, whole or not at all."""
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(path) as temporary:
            temporary.write_bytes(data)

    def keep_text(self, name: str, text: str) -> None:
        """Write a text of the run without secrets."""
        self.keep(name, self._clean(text).encode("utf-8", "replace"))

    # --- attempts --------------------------------------------------------------------------------------------------

    def recorded(self, sample: int, number: int, key: str) -> Answer | None:
        """The answer that this run got to a question already."""
        facts = self._reply_facts(sample, number)
        if facts is None or facts.get("key") != key:
            return None
        return _answer_of(facts)

    def _reply_facts(self, sample: int, number: int) -> dict[str, Any] | None:
        """What is recorded of a question, None where it has no answer or a damaged one."""
        found = map(_reply_in, self._folder(sample).glob(f"{number:02d}-*"))
        return next((facts for facts in found if facts is not None), None)

    def asked(self, sample: int, number: int, purpose: str, payload: Mapping[str, Any]) -> None:
        """Record a question before it is sent; its pictures become files."""
        folder = self._attempt(sample, number, purpose)
        pictures: list[bytes] = []
        data = _without_pictures(payload, pictures)
        for position, picture in enumerate(pictures, 1):
            self.keep(f"{folder}/picture-{position}.png", picture)
        self.keep_text(f"{folder}/request.json", json.dumps(data, indent=1, ensure_ascii=False))

    @contextmanager
    def sending(self, sample: int, number: int, purpose: str) -> Iterator[Callable[[float], None]]:
        """For the time of a request: note what it can cost. A kill leaves the note, which then counts as spent; so does
        Ctrl-C, since the service may charge for it."""
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
        facts = reply_data(answer.reply) | {"key": key, "cost": answer.cost, "was_kept": answer.was_kept}
        self.keep_text(f"{folder}/answer.txt", answer.reply.text)
        self.keep_text(f"{folder}/reply.json", json.dumps(facts))

    def judged(self, sample: int, number: int, purpose: str, verdict: Verdict) -> None:
        """Record what became of an answer."""
        folder = self._attempt(sample, number, purpose)
        self.keep_text(f"{folder}/program.scene", verdict.program)
        self.keep_text(f"{folder}/diagnostics.txt", verdict.told())
        facts = {
            "usable": verdict.is_usable,
            "diagnostics": [to_json(d) for d in verdict.diagnostics],
            "findings": [to_json(d) for d in verdict.findings],
        }
        self.keep_text(f"{folder}/verdict.json", json.dumps(facts))

    def attempts(self) -> Iterator[Attempt]:
        """All that was answered, by sample and number."""
        for folder in sorted(self.path.glob("sample-*/*")):
            match = _ATTEMPT.fullmatch(folder.name)
            sample = folder.parent.name.removeprefix("sample-")
            facts = _reply_in(folder) if match and sample.isdecimal() else None
            if match is not None and facts is not None:
                yield Attempt(int(sample), int(match[1]), match[2], facts | _json_object(folder / "verdict.json"))

    @property
    def spent(self) -> float:
        """US dollars, with what interrupted requests may have cost."""
        lost = sum(_lost(path) for path in self.path.glob("sample-*/*/sent.json"))
        return lost + sum(attempt.cost for attempt in self.attempts())

    def summary(self) -> dict[str, Any]:
        """The run in a few facts, as JSON data; the ``state`` of a folder that cannot be read is "damaged"."""
        found = {"name": self.name, "path": str(self.path)}
        try:
            facts = self.facts
            task = facts["task"]["text"] or "a reconstruction"
            command, state = str(facts["command"]), self.state
        except (SceneError, KeyError, TypeError):
            return found | {"command": "", "state": "damaged", "attempts": 0, "cost": 0.0, "task": ""}
        shown = printable(" ".join(str(task).split()))
        attempts = len(list(self.attempts()))
        return found | {
            "command": command, "state": state, "attempts": attempts, "cost": self.spent, "task": shown,
        }  # fmt: skip

    def _folder(self, sample: int) -> Path:
        return self.path / f"sample-{sample}"

    @staticmethod
    def _attempt(sample: int, number: int, purpose: str) -> str:
        return f"sample-{sample}/{number:02d}-{purpose}"

    # --- one process at a time -------------------------------------------------------------------------------------

    @property
    def state(self) -> str:
        """How the run stands: one that says that it is running, and that no process holds, was interrupted."""
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
        """Hold the run for this block. Raises SceneError where another process has it."""
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
                raise SceneError("run", f"another process is at work on the run {self.name}") from None
            yield
        finally:
            os.close(file)


def _reply_in(folder: Path) -> dict[str, Any] | None:
    """What is recorded of the answer in an attempt's folder, None where there is none or a damaged one."""
    found = _json_object(folder / "reply.json")
    return found if found and _answer_of(found) is not None else None


def _answer_of(facts: Mapping[str, Any]) -> Answer | None:
    """A recorded answer, None where it is damaged."""
    try:
        answer = Answer(reply_of(facts), float(facts["cost"]), bool(facts["was_kept"]))
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        return None
    return answer if isfinite(answer.cost) and answer.cost >= 0 else None


def _lost(path: Path) -> float:
    """What requests that had no answer may have cost, in US dollars."""
    try:
        amount = float(_json_object(path).get("lost", 0.0))
    except (TypeError, ValueError, OverflowError):
        return 0.0
    return amount if isfinite(amount) and amount > 0 else 0.0


def _json_object(path: Path) -> dict[str, Any]:
    """What a file says, nothing where it cannot be read."""
    try:
        found = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _without_pictures(data: Any, pictures: list[bytes]) -> Any:
    """A payload with the name of a file in place of each picture's data."""
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


# --- many runs -----------------------------------------------------------------------------------------------------


def new_run(folder: Path, text: str, clean: Callable[[str], str]) -> Run:
    """A new folder for a run, named by the time and its task. Raises SceneError where it cannot be made."""
    slug = _SLUG.sub("-", clean(text).lower()).strip("-")[:_LONGEST_SLUG].rstrip("-") or "run"
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
        raise SceneError("file", f"no run can be kept in {folder}: {error.strerror or error}") from None
    raise SceneError("file", f"no run can be kept in {folder}: too many begin at once")


def all_runs(folder: Path) -> list[Run]:
    """The runs in a folder, oldest first."""
    if not folder.is_dir():
        return []
    return [Run(path) for path in sorted(folder.iterdir()) if (path / "run.json").is_file()]


def find_run(folder: Path, name: str, clean: Callable[[str], str] = str) -> Run:
    """The run of a name, of an unambiguous beginning of one, of a path, or the ``last`` one. Raises SceneError."""
    if (Path(name) / "run.json").is_file():
        return Run(Path(name), clean)
    runs = all_runs(folder)
    if name == "last" and runs:
        return Run(runs[-1].path, clean)
    exact = [run for run in runs if run.name == name]
    found = exact or [run for run in runs if run.name.startswith(name)]
    if len(found) == 1:
        return Run(found[0].path, clean)
    if found:
        raise SceneError("run", f"`{name[:60]}` could be {', '.join(run.name for run in found[:5])}")
    hint = suggest(name, [run.name for run in runs]) or f"`scenelang runs` lists those in {folder}"
    raise SceneError("run", f"there is no run `{name[:60]}`", hint)


# How a run asks: model, limits, number of samples; as data that a run folder keeps, so that it can go on.


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
RENEWABLE = ("samples", "repairs", "critiques", "side_by_side", "max_cost")  # a run that goes on may have new ones
Typed = TypeVar("Typed")


@dataclass(frozen=True, slots=True)
class InferenceSettings:
    """``max_cost`` in US dollars; ``price`` as "INPUT,OUTPUT" in dollars per million tokens."""

    provider: str = setting(
        "anthropic", "anthropic (default), openai: any server of chat completions, or a package's own", metavar="NAME"
    )
    model: str | None = setting(None, "the model (default: the provider's)", metavar="NAME")
    price: str | None = setting(
        None, "dollars per million tokens, for a model whose price is not known", metavar="IN,OUT"
    )
    effort: str | None = setting(
        None, "how much the model works: low, medium, high, xhigh, max, as it allows", metavar="LEVEL"
    )
    max_tokens: int | None = setting(
        None, "tokens of one answer (default 32,000, or what the model has)", metavar="N", read=whole
    )
    max_cost: float = setting(5.0, "what the run may cost (default 5)", metavar="DOLLARS", read=dollars)
    samples: int = setting(
        1, "samples, of which the best is taken (default 1)", "-n", "--samples", metavar="N", read=whole
    )
    repairs: int = setting(
        3, "times that mistakes go back to the model (default 3)", "--repair", metavar="N", read=whole
    )
    critiques: int = setting(0, "times that pictures go back to it (default 0)", "--critique", metavar="N", read=whole)
    side_by_side: int = setting(4, "samples side by side (default 4)", "--jobs", metavar="N", read=whole)
    is_batch: bool = setting(False, "by batches: half the price, within a day", "--batch")
    uses_replies: bool = setting(True, "ask anew what was asked before", "--no-cache")
    prompt_dir: str | None = setting(None, "prompts that replace the package's, file by file", metavar="DIR")
    timeout: float = setting(
        TIMEOUT, "seconds without a word from the service, at each of three tries (default 120)",
        metavar="SECONDS", read=seconds,
    )  # fmt: skip

    def data(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def plan(self) -> SamplePlan:
        return SamplePlan(self.repairs, self.critiques)

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


def check_limits(given: Mapping[str, Any], as_flags: bool = False) -> None:
    """Raises UsageError for a field of settings that is out of its limits; ``as_flags``: named as the command line's
    options."""
    flags = {name: each.flags[0] for name, each in settings_in(InferenceSettings).items()}
    for name, (low, high) in LIMITS.items():
        value = given.get(name)
        if value is not None and not low <= value <= high:
            shown = flags[name] if as_flags else f"`{name}`"
            raise UsageError("value", f"{shown} may be {low:,} to {high:,}, not {value:,}")


def settings_of(data: Mapping[str, Any]) -> InferenceSettings:
    """The inverse of ``Settings.data``. Raises SceneError for data that is none."""
    try:
        found = typed(InferenceSettings, data)
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
    from scenelang.interpreter.expand.forms import full_grammar

    return gbnf_text(full_grammar())


# Runs as people read them: a list of all, and every attempt of one.


_LONGEST_TASK = 60


def list_of_runs(summaries: Iterable[Mapping[str, Any]]) -> str:
    """A table of what ``Run.summary`` says of each run."""
    rows = [
        (f["name"], f["command"], f["state"], str(f["attempts"]), f"${f['cost']:.4f}", _short(f["task"]))
        for f in summaries
    ]
    header = ("run", "command", "state", "attempts", "cost", "task")
    return table([header, *rows], (False, False, False, True, True, False))


def run_facts(run: Run) -> tuple[dict[str, Any], list[Attempt]]:
    """What a run says of itself, and its attempts; raises SceneError for one that is damaged."""
    facts = run.summary()
    if facts["state"] == "damaged":
        raise SceneError("run", f"the run {run.name} is damaged")
    return facts, list(run.attempts())


def run_report(run: Run, facts: Mapping[str, Any], attempts: Sequence[Attempt]) -> str:
    """A run and its attempts."""
    header = ("sample", "attempt", "why", "ended", "sent", "answered", "cost", "came to")
    rows = [header, *map(_attempt_row, attempts)]
    return "\n".join((
        f"{facts['name']}: {facts['command']}, {facts['state']}, ${facts['cost']:.4f}",
        _short(facts["task"]),
        str(run.path),
        table(rows, (True, True, False, False, True, True, True, False)),
    ))  # fmt: skip


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST_TASK else text[: _LONGEST_TASK - 3] + "..."


def _attempt_row(attempt: Attempt) -> tuple[str, ...]:
    data = attempt.data()
    cost = "kept" if data["was_kept"] else f"${data['cost']:.4f}"
    sample = str(attempt.sample) if attempt.sample else "-"
    sent, answered = f"{data['tokens']['sent']:,}", f"{data['tokens']['answered']:,}"
    return sample, str(attempt.number), attempt.purpose, data["ended"], sent, answered, cost, _came_to(data)


def _came_to(data: Mapping[str, Any]) -> str:
    if data["usable"] is None:
        return ""
    if data["usable"]:
        return f"a scene, {data['findings']} findings" if data["findings"] else "a scene"
    return f"{data['errors']} error{'' if data['errors'] == 1 else 's'}"
