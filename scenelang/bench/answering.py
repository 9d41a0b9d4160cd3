"""Where answers come from: a service, a recording that is replayed by a digest of the request, or a user's function."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

from scenelang.backends.files import read_regular
from scenelang.backends.language_models.catalogue import ImageContent, Reply, Request, StopReason, Usage
from scenelang.backends.language_models.client import Answer, Client, digest_of, reply_data, reply_of
from scenelang.backends.language_models.openai_chat import estimate_tokens, max_token_count
from scenelang.bench.mutations import MAX_MISTAKES, mutated, repaired_by_check
from scenelang.bench.tasks import BenchTask
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.brief import NO_CHANGES, Notation, fenced
from scenelang.inference.steps import program_text

RECORDING = "answers.jsonl"
_MAX_SIZE = 500_000_000  # bytes of a recording


@dataclass(frozen=True, slots=True)
class BenchRequest:
    """A request of a trial: which one it is, its purpose, and what is sent."""

    task: str
    mode: str
    sample: int
    number: int
    purpose: str
    request: Request

    @property
    def place(self) -> tuple[str, str, int, int]:
        """What identifies it within a run, whatever its text is."""
        return self.task, self.mode, self.sample, self.number

    @property
    def digest(self) -> str:
        """Digest of what the model is told, which depends on neither the model nor the provider."""
        return request_digest(self.request, self.sample)


def request_digest(request: Request, sample: int) -> str:
    """Return a digest of a request's texts and images; those of different samples differ."""
    turns = [[turn.role, [_part(part) for part in turn.parts]] for turn in request.messages]
    return digest_of(request.system.text, turns, request.grammar is not None, sample)


def _part(part: Any) -> str:
    if isinstance(part, ImageContent):
        return f"{part.media_type} {hashlib.sha256(part.data).hexdigest()}"
    return str(getattr(part, "text", part))


@dataclass(frozen=True, slots=True)
class TimedAnswer:
    """An answer, and the seconds that it took; of a recorded one, those that it took then."""

    answer: Answer
    seconds: float


class Answerer(Protocol):
    """What answers requests; raises SceneError for one that it cannot answer."""

    def __call__(self, asked: BenchRequest) -> TimedAnswer: ...


class ServiceAnswerer:
    """Answers of a language model."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def __call__(self, asked: BenchRequest) -> TimedAnswer:
        started = time.monotonic()
        answer = self._client.ask(asked.request, asked.sample, asked.number, lambda _: None)
        if answer.was_cached:  # the figures tell what it cost when it was given
            answer = replace(answer, cost=self._client.model.cost(answer.reply.usage))
        return TimedAnswer(answer, time.monotonic() - started)


class Recorder:
    """Answers of another source, each of which is appended to a recording."""

    def __init__(self, source: Answerer, file: Path) -> None:
        self._source = source
        self._file = file
        self._lock = Lock()

    def __call__(self, asked: BenchRequest) -> TimedAnswer:
        answer = self._source(asked)
        data = {
            "task": asked.task,
            "mode": asked.mode,
            "sample": asked.sample,
            "number": asked.number,
            "purpose": asked.purpose,
            "digest": asked.digest,
            "reply": reply_data(answer.answer.reply),
            "cost": answer.answer.cost,
            "seconds": round(answer.seconds, 3),
        }
        with self._lock, self._file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(data, ensure_ascii=False) + "\n")
        return answer


class Replay:
    """Answers of a recording.

    An answer is found by the digest of its request. With ``any_prompt`` one that was given to another wording of the
    same request, after a prompt was changed, is taken as well; ``outdated`` counts these, ``missing`` the requests that
    have no answer, and ``found`` those that have one.
    """

    name = "recorded"

    def __init__(self, path: Path, any_prompt: bool = False) -> None:
        self.outdated = self.missing = self.found = 0
        self._any_prompt = any_prompt
        self._by_digest: dict[tuple[Any, ...], TimedAnswer] = {}
        self._by_place: dict[tuple[str, str, int, int], TimedAnswer] = {}
        for place, digest, answer in _recorded(path):
            self._by_digest[*place[:2], place[3], digest] = answer
            self._by_digest.setdefault((*place[:2], digest), answer)
            self._by_place[place] = answer

    @property
    def modes(self) -> tuple[str, ...]:
        """Modes of the recorded answers, in their order."""
        return tuple(dict.fromkeys(place[1] for place in self._by_place))

    def tasks(self, mode: str) -> tuple[str, ...]:
        """Return the tasks that have answers in a mode, in their order."""
        return tuple(dict.fromkeys(task for task, each, _, _ in self._by_place if each == mode))

    @property
    def samples(self) -> int:
        return max((place[2] for place in self._by_place), default=1)

    def __call__(self, asked: BenchRequest) -> TimedAnswer:
        here = asked.task, asked.mode
        answer = self._by_digest.get((*here, asked.number, asked.digest)) or self._by_digest.get((*here, asked.digest))
        if answer is None and self._any_prompt and (answer := self._by_place.get(asked.place)) is not None:
            self.outdated += 1
        if answer is None:
            self.missing += 1
            known = asked.place in self._by_place
            hint = "its answer is to another wording; replay it with --any-prompt" if known else None
            what = f"request {asked.number} of `{asked.task}` in mode {asked.mode}"
            raise SceneError("model-answer", f"the recording has no answer to {what}", hint)
        self.found += 1
        return answer


class MutationModel:
    """The deterministic mutation model as a source of answers, for modes of the language.

    It answers with the passing program of the task, into which one to three mistakes are planted, and repairs it by
    nothing but the fixes and names in what ``check --json`` reports. It measures the diagnostics, and runs offline.
    """

    name = "mutations"

    def __init__(self, tasks: Sequence[BenchTask], seed: int = 0) -> None:
        self._programs = {task.name: task.passes for task in tasks}
        self._seed = seed

    def __call__(self, asked: BenchRequest) -> TimedAnswer:
        started = time.monotonic()
        text = NO_CHANGES if asked.purpose == "critique" else fenced(self._program(asked), Notation.LANGUAGE)
        usage = Usage(sent=estimate_tokens(asked.request), answered=max_token_count(text))
        answer = Answer(Reply(text, StopReason.END, usage, self.name), 0.0)
        return TimedAnswer(answer, time.monotonic() - started)

    def _program(self, asked: BenchRequest) -> str:
        if asked.purpose == "repair":
            *_, answer, _ = asked.request.messages
            return repaired_by_check(program_text("\n".join(map(_part, answer.parts))))
        sound = self._programs[asked.task]
        number = self._seed * 1000 + asked.sample
        made = mutated(sound, number, 1 + (number + len(asked.task)) % MAX_MISTAKES)
        return sound if made is None else made.text


def recording_of(path: Path) -> Path:
    """Return the recording that a path means: the file, or that of a run's folder. Raises SceneError."""
    file = path / RECORDING if path.is_dir() else path
    if not file.is_file():
        raise SceneError("file", f"no recorded answers in {path}", f"give a run, or a file such as {RECORDING}")
    return file


def _recorded(path: Path) -> Iterator[tuple[tuple[str, str, int, int], str, TimedAnswer]]:
    """Yield the answers of a recording; an incomplete last line, of a run that was interrupted, is left out."""
    lines = read_regular(path, _MAX_SIZE).decode("utf-8", "replace").split("\n")
    for number, line in enumerate(lines[:-1], 1):
        try:
            if not line.strip():
                continue
            data: Mapping[str, Any] = json.loads(line)
            cost, seconds = float(data["cost"]), float(data["seconds"])
            if not (0.0 <= cost < math.inf and 0.0 <= seconds < math.inf):
                raise ValueError
            place = str(data["task"]), str(data["mode"]), int(data["sample"]), int(data["number"])
            reply = reply_of(data["reply"])
            if min(asdict(reply.usage).values()) < 0:
                raise ValueError
            yield place, str(data["digest"]), TimedAnswer(Answer(reply, cost), seconds)
        except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
            raise SceneError("file", f"cannot read line {number} of the recording {path}") from None
