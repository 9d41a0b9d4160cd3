"""Runs of the benchmark: every task in every mode, as ``generate`` would run it, judged by the task's predicates.

A run is a folder: ``run.json`` has its settings, ``answers.jsonl`` all answers, ``trials.jsonl`` one line for each
finished trial, and ``programs`` what came of them. A run that was interrupted goes on where it stopped.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from scenelang.backends.files import make_folder, read_regular, write_json, write_text
from scenelang.backends.language_models.catalogue import ImageContent
from scenelang.bench.answering import RECORDING, Answerer, BenchRequest
from scenelang.bench.scoring import Score, scene_of, score_of
from scenelang.bench.tasks import BenchTask
from scenelang.grammar.diagnostics import CODES, SceneError, UsageError, suggest
from scenelang.inference.brief import Brief, Notation, Prompts, Task
from scenelang.inference.steps import (
    EVALUATING,
    AnswerReader,
    Ask,
    SamplePlan,
    SampleProgress,
    Speaker,
    Steps,
    Verdict,
    best_view,
    encoded,
    sample_steps,
)
from scenelang.session.session import Options

TRIALS, PROGRAMS, SETTINGS = "trials.jsonl", "programs", "run.json"
_FORMAT = 1


@dataclass(frozen=True, slots=True)
class BenchMode:
    """How a model is asked: the notation, whether a grammar constrains its answers, and whether it sees pictures of
    what it made."""

    name: str
    notation: Notation
    is_constrained: bool = False
    critiques: int = 0


_CRITIQUE = "+critique"
_MODES = (
    BenchMode("python", Notation.PYTHON),
    BenchMode("dsl", Notation.LANGUAGE),
    BenchMode("dsl-grammar", Notation.LANGUAGE, is_constrained=True),
)
MODES: Mapping[str, BenchMode] = {
    mode.name + end: replace(mode, name=mode.name + end, critiques=1 if end else 0)
    for end in ("", _CRITIQUE)
    for mode in _MODES
}


@dataclass(frozen=True, slots=True)
class BenchAttempt:
    """One answer: its purpose ("draft", "repair" or "critique"), the codes of the errors in it, and what it cost."""

    purpose: str
    digest: str
    codes: tuple[str, ...]
    sent: int
    answered: int
    cost: float
    seconds: float


@dataclass(frozen=True, slots=True)
class Trial:
    """One sample of one task in one mode.

    ``first`` is the score of the first answer, ``final`` that of the result, None where no valid program came of it;
    ``failed`` are the predicates that the result fails, ``error`` is why there is none.
    """

    task: str
    group: str
    mode: str
    sample: int
    first: Score | None
    final: Score | None
    failed: tuple[str, ...]
    attempts: tuple[BenchAttempt, ...]
    error: str | None = None

    @property
    def key(self) -> tuple[str, str, int]:
        return self.task, self.mode, self.sample

    @property
    def passed_first(self) -> bool:
        return self.first is not None and self.first.passed

    @property
    def passed(self) -> bool:
        return self.final is not None and self.final.passed

    def data(self) -> dict[str, Any]:
        return asdict(self)


def trial_of(data: Mapping[str, Any]) -> Trial:
    """Parse the result of ``Trial.data``; raises KeyError or TypeError for invalid data."""
    first, final = (_score(data[name]) for name in ("first", "final"))
    attempts = tuple(BenchAttempt(**{**each, "codes": tuple(each["codes"])}) for each in data["attempts"])
    rest = {**data, "first": first, "final": final, "failed": tuple(data["failed"]), "attempts": attempts}
    return _checked(Trial(**rest))


def _score(data: Mapping[str, Any] | None) -> Score | None:
    if data is None:
        return None
    return Score(**{**data, "reasons": tuple(data["reasons"]), "warnings": tuple(data["warnings"])})


def _checked(trial: Trial) -> Trial:
    """Return a trial that was read, if its values have the types that are counted with."""
    texts = [trial.task, trial.group, trial.mode, *trial.failed, *(a.purpose for a in trial.attempts)]
    texts += [code for a in trial.attempts for code in a.codes]
    numbers = [x for a in trial.attempts for x in (a.cost, a.seconds, a.sent, a.answered)]
    for score in (trial.first, trial.final):
        if score is not None:
            texts += score.warnings
            measured = (score.locality, score.collides, score.floats, score.stable)
            numbers += [x for x in measured if x is not None]
    if not all(isinstance(x, str) for x in texts) or not all(isinstance(x, int | float) for x in numbers):
        raise TypeError("a value of a trial")
    if not all(0.0 <= x < math.inf for x in numbers) or trial.mode not in MODES:
        raise ValueError("a value of a trial")
    return trial


@dataclass(frozen=True, slots=True)
class BenchSettings:
    """What determines the results of a run, besides its tasks and the model."""

    modes: tuple[str, ...] = ("python", "dsl")
    samples: int = 1
    repairs: int = 3
    simulates: bool = False
    prompt_dir: str | None = None

    def check(self) -> None:
        """Raise UsageError for an unknown mode, or values out of range."""
        for mode in self.modes:
            if mode not in MODES:
                raise UsageError("value", f"unknown mode `{mode}`", f"expected some of {', '.join(MODES)}")
        if not self.modes or not 1 <= self.samples <= 1000 or not 0 <= self.repairs <= 100:
            raise UsageError("value", "expected at least one mode, 1 to 1,000 samples and 0 to 100 repairs")


class ServiceFailure(Exception):
    """Raised if a service fails, or the cost limit is reached; the trial under way is not finished."""

    def __init__(self, error: SceneError) -> None:
        super().__init__(error.message)
        self.error = error


# --- one trial -------------------------------------------------------------------------------------------------------


def task_in(task: BenchTask, mode: BenchMode) -> Task | None:
    """Return the task of a model in a mode; None for an edit whose program does not exist in the mode's notation."""
    program = task.program
    if program is not None and mode.notation is Notation.PYTHON:
        program = task.python
        if program is None:
            return None
    pictures = (_picture(task),) if task.is_image else ()
    return Task(task.text, task.kind, mode.notation, pictures=pictures, program=program)


def _picture(task: BenchTask) -> ImageContent:
    with EVALUATING:
        return encoded(best_view(scene_of(task.passes)))


def run_trial(
    task: BenchTask, mode: BenchMode, sample: int, speaker: Speaker, settings: BenchSettings, answerer: Answerer,
    folder: Path,
) -> tuple[Trial, str]:  # fmt: skip
    """Run one sample of a task; returns what came of it, and its program. Nothing that a model answers raises."""
    asked = task_in(task, mode)
    assert asked is not None
    prompts = Prompts(Path(settings.prompt_dir) if settings.prompt_dir is not None else None)
    brief = Brief(asked, prompts, mode.is_constrained)
    reader = AnswerReader(brief, Options(project=folder, imports=frozenset()), "answer.scene")
    steps = sample_steps(brief, reader, speaker, SamplePlan(settings.repairs, mode.critiques))
    verdicts, attempts, result, error = _played(steps, task.name, mode.name, sample, answerer)
    is_python = mode.notation is Notation.PYTHON
    first = _judged(task, verdicts[0], simulates=False, is_python=is_python) if verdicts else None
    final: Score | None = None
    if result is not None:
        is_first = bool(verdicts) and result is verdicts[0] and not settings.simulates
        final = first if is_first else _judged(task, result, simulates=settings.simulates, is_python=is_python)
    if error is None and final is None:
        error = _why(result)
    failed = tuple(final.failed(task)) if final is not None else ()
    program = result.program if result is not None else ""
    return Trial(task.name, task.group, mode.name, sample, first, final, failed, tuple(attempts), error), program


def _played(
    steps: Steps, task: str, mode: str, sample: int, answerer: Answerer
) -> tuple[list[Verdict], list[BenchAttempt], Verdict | None, str | None]:
    """Answer the requests of a sample to its end; returns all verdicts and attempts, the result, and why there is
    none."""
    verdicts: list[Verdict] = []
    attempts: list[BenchAttempt] = []
    try:
        step = next(steps)
        while True:
            if isinstance(step, SampleProgress):
                verdicts.append(step.verdict)
                attempts[-1] = replace(attempts[-1], codes=codes_of(step.verdict))
                step = steps.send(None)
                continue
            assert isinstance(step, Ask)
            request = BenchRequest(task, mode, sample, len(attempts) + 1, step.purpose.value, step.request)
            try:
                answer = answerer(request)
            except SceneError as error:
                if error.name != "model-answer":  # the service failed, not the model
                    raise ServiceFailure(error) from None
                step = steps.throw(error)
                continue
            reply, cost = answer.answer.reply, answer.answer.cost
            tokens = (reply.usage.prompt, reply.usage.answered)
            attempts.append(
                BenchAttempt(step.purpose.value, request.digest, (), *tokens, cost, round(answer.seconds, 3))
            )
            step = steps.send(reply)
    except StopIteration as end:
        return verdicts, attempts, end.value.verdict, None
    except SceneError as error:
        return verdicts, attempts, None, error.message


def codes_of(verdict: Verdict) -> tuple[str, ...]:
    """Return the codes of the errors in an answer, each once."""
    return tuple(dict.fromkeys(CODES[d.name].code for d in verdict.diagnostics if d.is_error))


def _judged(task: BenchTask, verdict: Verdict, *, simulates: bool, is_python: bool) -> Score | None:
    if not verdict.is_usable or verdict.scene is None:
        return None
    try:
        with EVALUATING:
            return score_of(task, verdict.scene, simulates, is_python)
    except SceneError:
        return None  # such as a scene beyond a limit


def _why(result: Verdict | None) -> str:
    errors = [d.message for d in result.diagnostics if d.is_error] if result is not None else []
    return errors[0] if errors else "the scene cannot be judged"


def _settings(data: Mapping[str, Any]) -> BenchSettings:
    settings = BenchSettings(**{**data, "modes": tuple(data["modes"])})
    counts = settings.samples + settings.repairs
    if not all(isinstance(mode, str) for mode in settings.modes) or not isinstance(counts, int):
        raise TypeError("a setting of a run")
    return settings


# --- a run -----------------------------------------------------------------------------------------------------------


class BenchRun:
    """The folder of a run."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @property
    def facts(self) -> dict[str, Any]:
        """What the run is of: settings, model, names of tasks. Raises SceneError for a folder that is no run."""
        path = self.folder / SETTINGS
        try:
            facts = json.loads(read_regular(path))
            if facts["format"] != _FORMAT or not all(isinstance(name, str) for name in facts["tasks"]):
                raise ValueError
            _settings(facts["settings"]).check()
            if not isinstance(facts["folder"], str | None) or isinstance(facts["tasks"], str):
                raise TypeError
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            raise SceneError("run", f"{self.folder} is not a run of `bench`") from None
        return dict(facts)

    def begin(self, facts: Mapping[str, Any]) -> None:
        """Create the folder, or go on with a run of the same facts. Raises UsageError if it is of others."""
        data = {"format": _FORMAT, **json.loads(json.dumps(facts))}
        if (self.folder / SETTINGS).exists():
            earlier = self.facts
            changed = sorted(name for name in data if earlier.get(name) != data[name])
            if changed:
                hint = "write the results to another folder, or give the same options to go on"
                raise UsageError("run", f"{self.folder} is a run with other {', '.join(changed)}", hint)
        elif self.folder.exists() and any(self.folder.iterdir()):
            raise UsageError("file", f"{self.folder} is not empty", "give a new folder, or one of an earlier run")
        make_folder(self.folder / PROGRAMS)
        write_json(self.folder / SETTINGS, data)

    def trials(self) -> list[Trial]:
        """Return the finished trials, in the order of tasks, modes and samples. Raises SceneError."""
        path = self.folder / TRIALS
        if not path.exists():
            return []
        by_key: dict[tuple[str, str, int], Trial] = {}
        lines = read_regular(path).decode("utf-8", "replace").split("\n")
        for number, line in enumerate(lines[:-1], 1):  # the last one is empty, or was not written to its end
            try:
                trial = trial_of(json.loads(line))
            except (ValueError, KeyError, TypeError, RecursionError):
                raise SceneError("run", f"cannot read line {number} of {path}") from None
            by_key[trial.key] = trial
        order = {name: number for number, name in enumerate(self.facts["tasks"])}
        modes = {name: number for number, name in enumerate(self.facts["settings"]["modes"])}
        return sorted(by_key.values(), key=lambda t: (order.get(t.task, -1), modes.get(t.mode, -1), t.sample))

    def add(self, trial: Trial, program: str) -> None:
        """Save a finished trial and its program."""
        if program:
            write_text(self.program_path(trial.key), program)
        with (self.folder / TRIALS).open("a", encoding="utf-8") as file:
            file.write(json.dumps(trial.data(), ensure_ascii=False) + "\n")

    def program_path(self, key: tuple[str, str, int]) -> Path:
        task, mode, sample = key
        return self.folder / PROGRAMS / f"{task}.{mode}.{sample}.scene"

    def drop_broken_line(self) -> None:
        """Remove a last line that was not written to its end."""
        for path in (self.folder / TRIALS, self.folder / RECORDING):
            if path.exists():
                text = read_regular(path).decode("utf-8", "replace")
                if text and not text.endswith("\n"):
                    write_text(path, text[: text.rfind("\n") + 1])


Planned = tuple[BenchTask, BenchMode, int]


def planned(tasks: Sequence[BenchTask], settings: BenchSettings) -> list[Planned]:
    """Return the trials of a run, all modes of a task one after the other."""
    return [
        (task, MODES[mode], sample)
        for task in tasks
        for mode in settings.modes
        if not (task.program is not None and MODES[mode].notation is Notation.PYTHON and task.python is None)
        for sample in range(1, settings.samples + 1)
    ]


def run_trials(
    run: BenchRun,
    plan: Sequence[Planned],
    settings: BenchSettings,
    speaker: Callable[[BenchMode], Speaker],
    answerer: Answerer,
    side_by_side: int = 4,
    progress: Callable[[float], None] | None = None,
) -> list[Trial]:
    """Run the trials that a run has not finished, several at a time, and return all.

    Ctrl-C ends the run after the trials that are under way; what is finished is saved.
    """
    run.drop_broken_line()
    finished = {trial.key for trial in run.trials()}
    waiting = [(t, m, s) for t, m, s in plan if (t.name, m.name, s) not in finished]
    with ThreadPoolExecutor(max(1, side_by_side)) as pool:
        futures = [
            pool.submit(run_trial, task, mode, sample, speaker(mode), settings, answerer, run.folder)
            for task, mode, sample in waiting
        ]
        try:
            for number, future in enumerate(as_completed(futures), 1):
                run.add(*future.result())
                if progress is not None:
                    progress(number / len(waiting))
        except ServiceFailure as failure:
            pool.shutdown(wait=False, cancel_futures=True)
            raise failure.error from None
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return run.trials()


def applicable(
    tasks: Sequence[BenchTask], names: Sequence[str], groups: Sequence[str], is_hard: bool = False
) -> list[BenchTask]:
    """Return the tasks with some names, of some groups or, if ``is_hard``, of the hard split; by default all others.

    Raises UsageError for unknown names and groups.
    """
    for asked, known, what in ((names, [t.name for t in tasks], "task"), (groups, [t.group for t in tasks], "group")):
        for name in asked:
            if name not in known:
                listed = ", ".join(dict.fromkeys(known)) if what == "group" else None
                raise UsageError("value", f"unknown {what} `{name}`", suggest(name, known) or listed)
    is_split = is_hard or not (names or groups)
    return [t for t in tasks if t.name in names or t.group in groups or (is_split and t.is_hard == is_hard)]
