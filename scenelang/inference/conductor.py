"""Runs samples: sends their requests concurrently or in batches, records everything, and replays recorded answers."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from threading import Event, Lock, Thread
from typing import Any, Protocol, TextIO

from scenelang.backends.language_models.catalogue import ImageContent, Reply, Request, Usage, text_message
from scenelang.backends.language_models.client import Answer, Client
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.brief import Ablation, Brief, Notation, Prompts, Task, TaskKind
from scenelang.inference.building import accepted_steps, build_steps
from scenelang.inference.records import InferenceSettings, Run, settings_of, typed
from scenelang.inference.steps import (
    ENDINGS,
    AnswerReader,
    Ask,
    SampleOutcome,
    SamplePlan,
    SampleProgress,
    Speaker,
    Steps,
    Verdict,
    candidates,
    judge_steps,
    sample_steps,
)
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import Options

# Display of a request.


def payload_text(payload: Mapping[str, Any]) -> str:
    """Format a request for display: texts unchanged, images by size."""
    lines = [f"{name}: {json.dumps(value)}" for name, value in payload.items() if name not in ("system", "messages")]
    system = payload.get("system")
    if system is not None:
        lines += ["", "--- system ---", *(_part_text(part) for part in _parts(system))]
    for message in payload.get("messages", ()):
        lines += ["", f"--- {message['role']} ---", *(_part_text(part) for part in _parts(message["content"]))]
    return "\n".join(lines)


def _parts(content: Any) -> list[Any]:
    return [{"type": "text", "text": content}] if isinstance(content, str) else list(content)


def _part_text(part: Mapping[str, Any]) -> str:
    if part.get("type") == "text":
        return str(part["text"])
    return f"[image, {len(json.dumps(part)) * 3 // 4:,} bytes]"


# Progress line on a terminal while answers arrive.


_BETWEEN = 0.1  # minimum interval between updates, in seconds
# Services state about 4 letters per token of English text; programs have more punctuation. Only the progress line uses
# this estimate: costs are computed from the tokens that the service reports.
_LETTERS_PER_TOKEN = 3.5


class LiveCount:
    """Progress line with the estimated tokens and the lines of concurrent answers. Without ``stream`` nothing is
    written."""

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self._lock = Lock()
        self._counts: dict[int, tuple[str, int, int]] = {}
        self._shown = 0.0
        self._width = 0

    def counting(self, sample: int, number: int, purpose: str) -> Callable[[str], None]:
        """Register an answer and return the callback for its chunks."""
        label = f"sample {sample} {purpose}" if sample else purpose
        letters, lines = 0, 0

        def count(text: str) -> None:
            nonlocal letters, lines
            letters, lines = letters + len(text), lines + text.count("\n")
            with self._lock:
                self._counts[sample] = (label, round(letters / _LETTERS_PER_TOKEN), lines)
                if time.monotonic() - self._shown >= _BETWEEN:
                    self._show(self._line())

        with self._lock:
            self._counts[sample] = (label, 0, 0)
            self._show(self._line())
        return count

    def waiting(self, count: int) -> None:
        """Show that a batch is in progress."""
        with self._lock:
            self._show(f"waiting for a batch: {count} requests left")

    def say(self, text: str) -> None:
        """Write a line that stays."""
        with self._lock:
            if self._stream is not None:
                self._stream.write(f"\r{text.ljust(self._width)}\n")
                self._stream.flush()

    def end(self) -> None:
        """Clear the line."""
        with self._lock:
            self._counts.clear()
            if self._width:
                self._show("")
                self._width = 0

    def _line(self) -> str:
        labels = [
            f"{label}: ~{tokens:,} tokens, {lines:,} lines" if tokens else f"{label}: waiting for the service"
            for label, tokens, lines in self._counts.values()
        ]
        return "; ".join(labels)

    def _show(self, line: str) -> None:
        if self._stream is None:
            return
        self._shown = time.monotonic()
        self._stream.write(f"\r{line.ljust(self._width)}" + ("\r" if not line else ""))
        self._stream.flush()
        self._width = len(line)


_POLL_INTERVAL = 0.1  # polling interval for Ctrl-C, in seconds
_FIRST_WAIT, _MAX_WAIT, _LONGER = 0.5, 30.0, 1.5  # polling intervals of a batch, in seconds
_MAX_BATCH_TIME = 25 * 3600.0  # batches expire after a day; plus an hour
Ended = SampleOutcome | SceneError


class Cancelled(BaseException):
    """Raised in a sample's thread to stop it after Ctrl-C."""


class _Progress:
    """A running sample: its generator and its pending request."""

    def __init__(self, sample: int, steps: Steps, say: Callable[[str], None]) -> None:
        self.sample = sample
        self._say = say
        self.number = 0
        self.ask: Ask | None = None
        self.ended: Ended | None = None
        self._steps = steps

    def begin(self, run: Run) -> None:
        self._go(run, lambda: next(self._steps))

    def answer(self, run: Run, reply: Reply) -> None:
        self._go(run, lambda: self._steps.send(reply))

    def fail(self, run: Run, error: SceneError) -> None:
        self._go(run, lambda: self._steps.throw(error))

    def _go(self, run: Run, first: Callable[[], Ask | SampleProgress]) -> None:
        """Advance to the next request, or to the end."""
        try:
            step = first()
            while isinstance(step, SampleProgress):
                assert self.ask is not None
                run.judged(self.sample, self.number, self.ask.purpose.value, step.verdict)
                if step.note:
                    self._say(f"{'' if self.sample < 2 else f'sample {self.sample}, '}{step.note}")
                step = self._steps.send(None)
        except StopIteration as end:
            self.ask, self.ended = None, end.value
        except SceneError as error:
            self.ask, self.ended = None, error
        else:
            self.ask, self.number = step, self.number + 1


class Conductor:
    """Runs the samples of one run with one client."""

    def __init__(self, client: Client, run: Run, live: LiveCount, settings: InferenceSettings) -> None:
        self._client = client
        self._run = run
        self._live = live
        self._side_by_side = settings.side_by_side
        self._most_tokens = settings.max_run_tokens
        self._most_seconds = settings.max_run_seconds
        self._started = time.monotonic()
        self._cancelled = Event()
        self._reserving = Lock()
        self._reserved = 0  # tokens of the requests in flight

    @contextmanager
    def _within_limits(self, requests: Sequence[Request]) -> Iterator[None]:
        """Reserve the most tokens that requests use. Raises SceneError if too few of them, or no seconds, are left."""
        needed = self._tokens_of(requests)
        with self._reserving:
            self._check_limits(needed)
            self._reserved += needed
        try:
            yield
        finally:
            with self._reserving:
                self._reserved -= needed

    def _tokens_of(self, requests: Sequence[Request]) -> int:
        """Return the most tokens that requests use, 0 if no limit asks for them: services count them on request."""
        return 0 if self._most_tokens is None else sum(map(self._client.max_tokens, requests))

    def _check_limits(self, needed: int) -> None:
        """Raise SceneError if fewer tokens than are ``needed``, or no seconds, are left."""
        tokens, seconds = self._most_tokens, self._most_seconds
        if tokens is not None:
            usages = [_usage(attempt.facts) for attempt in self._run.attempts()]
            left = tokens - sum(usage.prompt + usage.answered for usage in usages) - self._reserved
            if needed > left:
                raise SceneError(
                    "model-cost",
                    f"the next request could use {needed:,} tokens, but only {max(0, left):,} of {tokens:,} remain",
                    "allow more with --max-run-tokens",
                )
        if seconds is not None and time.monotonic() - self._started > seconds:
            raise SceneError(
                "model-cost", f"the run has taken more than {seconds:g} s", "allow more with --max-run-seconds"
            )

    # --- single requests -------------------------------------------------------------------------------------------

    def singly(self, samples: Mapping[int, Steps]) -> dict[int, Ended]:
        """Run samples concurrently with separate requests. Ctrl-C ends them; the records are preserved."""
        waiting = [_Progress(sample, steps, self._live.say) for sample, steps in samples.items()]
        done: dict[int, Ended] = {}
        faults: list[BaseException] = []

        def work() -> None:
            while waiting and not self._cancelled.is_set():
                try:
                    progress = waiting.pop(0)
                except IndexError:
                    return
                try:
                    done[progress.sample] = self._played(progress)
                except BaseException as fault:
                    faults.append(fault)
                    return

        threads = [Thread(target=work, daemon=True) for _ in range(min(self._side_by_side, len(waiting)))]
        for thread in threads:
            thread.start()
        try:
            while any(thread.is_alive() for thread in threads):
                threads[0].join(_POLL_INTERVAL) if threads[0].is_alive() else time.sleep(_POLL_INTERVAL)
        except KeyboardInterrupt:
            self._cancelled.set()
            raise
        finally:
            self._live.end()
        if faults:
            raise faults[0]
        return {sample: done[sample] for sample in samples}

    def _played(self, progress: _Progress) -> Ended:
        progress.begin(self._run)
        while progress.ask is not None:
            try:
                answer = self._answer(progress, progress.ask)
            except SceneError as error:
                progress.fail(self._run, error)
            else:
                progress.answer(self._run, answer.reply)
        assert progress.ended is not None
        return progress.ended

    def _answer(self, progress: _Progress, ask: Ask) -> Answer:
        """Return the answer from the records, else from the service."""
        sample, number, purpose = progress.sample, progress.number, ask.purpose.value
        key = self._client.key(ask.request, sample, number)
        answer = self._run.recorded(sample, number, key)
        if answer is not None:
            return answer
        with self._within_limits([ask.request]):
            self._run.asked(sample, number, purpose, self._client.payload(ask.request))
            count = self._live.counting(sample, number, purpose)

            def watch(text: str) -> None:
                if self._cancelled.is_set():
                    raise Cancelled
                count(text)

            with self._run.sending(sample, number, purpose) as note:
                answer = self._client.ask(ask.request, sample, number, watch, note)
            self._run.answered(sample, number, purpose, key, answer)
        return answer

    # --- batches ---------------------------------------------------------------------------------------------------

    def in_batches(self, samples: Mapping[int, Steps]) -> dict[int, Ended]:
        """Run samples in rounds: the pending requests of all samples are sent as one batch."""
        going = [_Progress(sample, steps, self._live.say) for sample, steps in samples.items()]
        for progress in going:
            progress.begin(self._run)
        while any(progress.ask is not None for progress in going):
            self._round([progress for progress in going if progress.ask is not None])
        return {progress.sample: progress.ended for progress in going if progress.ended is not None}

    def _round(self, going: Sequence[_Progress]) -> None:
        """Answer all requests of a round: from the records, from the cache, and the rest in one batch."""
        left: dict[str, tuple[_Progress, Ask, str]] = {}
        for progress in going:
            ask = progress.ask
            assert ask is not None
            key = self._client.key(ask.request, progress.sample, progress.number)
            answer = self._run.recorded(progress.sample, progress.number, key)
            if answer is None and (answer := self._client.cached(key)) is not None:
                self._take(progress, ask, key, answer)
            elif answer is not None:
                progress.answer(self._run, answer.reply)
            else:
                left[f"sample-{progress.sample}-{progress.number}"] = (progress, ask, key)
        if left:
            self._batch(left)

    def _batch(self, left: Mapping[str, tuple[_Progress, Ask, str]]) -> None:
        keys = {name: key for name, (_, _, key) in left.items()}
        try:
            batch, reserved = self._submitted(keys, {name: ask for name, (_, ask, _) in left.items()})
            self._wait(batch)
            answers = self._client.collect(batch, reserved)
        except SceneError as error:
            for progress, _, _ in left.values():
                progress.fail(self._run, error)
            return
        for name, (progress, ask, key) in left.items():
            answer = answers.get(name, SceneError("model-request", "the batch contains no answer to this request"))
            if isinstance(answer, SceneError):
                progress.fail(self._run, answer)
            else:
                self._client.cache(key, answer.reply)
                self._take(progress, ask, key, answer)
        self._run.note(batch=None)

    def _submitted(self, keys: Mapping[str, str], asks: Mapping[str, Ask]) -> tuple[str, dict[str, float]]:
        """Return the batch in progress and the dollars reserved for each request: the batch submitted before the run
        was interrupted, if it covers the requests, else a new one."""
        sent = self._sent(keys)
        if sent is not None:
            self._client.budget.reserve(sum(sent[1].values()))
            return sent
        # Rounds come one after the other, so that nothing else is in flight.
        self._check_limits(self._tokens_of([ask.request for ask in asks.values()]))
        for name, ask in asks.items():
            sample, number = (int(piece) for piece in name.split("-")[1:])
            self._run.asked(sample, number, ask.purpose.value, self._client.payload(ask.request))
        batch, reserved = self._client.submit({name: ask.request for name, ask in asks.items()})
        self._run.note(batch={"id": batch, "reserved": reserved, "keys": dict(keys)})
        return batch, reserved

    def _sent(self, keys: Mapping[str, str]) -> tuple[str, dict[str, float]] | None:
        """Return the recorded batch in progress if it contains all of these requests."""
        sent = self._run.facts.get("batch")
        if sent is None:
            return None
        try:
            if not keys.items() <= sent["keys"].items():
                return None
            return str(sent["id"]), {name: float(sent["reserved"][name]) for name in keys}
        except (KeyError, TypeError, ValueError, AttributeError):
            raise SceneError("run", f"the run {self._run.name} is damaged: cannot read its batch") from None

    def _wait(self, batch: str) -> None:
        """Wait until a batch is finished. Raises SceneError if it exceeds the maximum time."""
        provider, wait, started = self._client.batches(), _FIRST_WAIT, time.monotonic()
        try:
            while count := provider.pending(batch):
                if time.monotonic() - started > _MAX_BATCH_TIME:
                    raise SceneError(
                        "model-request", "the batch is not finished after a day", "check again with --resume"
                    )
                self._live.waiting(count)
                time.sleep(wait)
                wait = min(_MAX_WAIT, wait * _LONGER)
        finally:
            self._live.end()

    def _take(self, progress: _Progress, ask: Ask, key: str, answer: Answer) -> None:
        """Record an answer that was not requested singly, and continue the sample with it."""
        self._run.answered(progress.sample, progress.number, ask.purpose.value, key, answer)
        progress.answer(self._run, answer.reply)


# Descriptions of appearance by a language model (the paper, section 5: a color value described as a word).


# An answer has a line of about 15 tokens for each question: 900 for 60, of the 8,000 that `describer` in `generation`
# allows, which leaves room for the reasoning of a model.
_QUESTIONS_PER_REQUEST = 60
_LINE = re.compile(r"^\s*(\d{1,4})\s*[.:)]\s*(.+?)\s*$", re.M)
_DECIMALS = 3  # of numbers shown to a model; a step of a color of 8 bits is 0.004


class Question(Protocol):
    """Question about the appearance of an entity; ``backends/neural/descriptions`` asks them."""

    @property
    def word(self) -> str: ...

    @property
    def attributes(self) -> Mapping[str, Any]: ...

    @property
    def color(self) -> str | None: ...


class Describer:
    """Describes primitives with a language model, several per request. Missing answers are empty."""

    def __init__(self, client: Client, prompts: Prompts, speaker: Speaker, live: LiveCount) -> None:
        self._client = client
        self._prompts = prompts
        self._speaker = speaker
        self._live = live

    @property
    def spent(self) -> float:
        """Cost in US dollars."""
        return self._client.budget.spent

    def __call__(self, questions: Sequence[Question]) -> list[str]:
        """Return a text for each question. Raises SceneError if the model cannot be reached."""
        try:
            pieces = range(0, len(questions), _QUESTIONS_PER_REQUEST)
            return [text for at in pieces for text in self._answers(questions[at : at + _QUESTIONS_PER_REQUEST], at)]
        finally:
            self._live.end()

    def _answers(self, questions: Sequence[Question], at: int) -> Iterator[str]:
        lines = "\n".join(f"{number}. {_question_line(question)}" for number, question in enumerate(questions, 1))
        turn = text_message("user", self._prompts.text("words.md", questions=lines))
        request = self._speaker.request(self._prompts.text("words.system.md"), (turn,))
        answer = self._client.ask(request, at, 1, self._live.counting(0, at, "words"))
        answers = {int(number): text.strip("\"'") for number, text in _LINE.findall(answer.reply.text)}
        return (answers.get(number, "") for number in range(1, len(questions) + 1))


def _question_line(question: Question) -> str:
    """Format a question as one line: the word, its attributes, and the nearest color name."""
    attributes = {name: _short(value) for name, value in question.attributes.items()}
    color = f", about {question.color}" if question.color else ""
    return f"{json.dumps(question.word, ensure_ascii=False)}{color}: {json.dumps(attributes, ensure_ascii=False)[:300]}"


def _short(value: object) -> object:
    if isinstance(value, float):
        return round(value, _DECIMALS)
    return [_short(item) for item in value] if isinstance(value, list) else value


# A run: samples are generated, repaired and refined, and the best is selected (the paper, section 5).


_JUDGE = 0  # sample number under which the judge's request is recorded


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a run. ``best`` is the verdict of ``sample``; ``stopped`` contains the errors of samples that ended
    early."""

    best: Verdict
    sample: int
    spent: float
    usage: Usage
    stopped: tuple[SceneError, ...] = ()


@dataclass(frozen=True)
class Inference:
    """A task with its settings. ``options`` limit the evaluation of answers; ``name`` is the file name in
    diagnostics."""

    task: Task
    settings: InferenceSettings
    options: Options
    name: str = "answer.scene"
    brief: Brief = field(init=False)

    def __post_init__(self) -> None:
        is_bare = self.settings.sends_grammar(self.task.notation)
        object.__setattr__(self, "brief", Brief(self.task, Prompts(self.settings.prompts_folder), is_bare))

    def reader(self, run: Run) -> AnswerReader:
        """Return the reader of answers. Programs may only import the files in ``options``, and load assets from its
        project folder, else from the run folder."""
        project, imports = self.options.project or run.path, self.options.imports or frozenset()
        return AnswerReader(self.brief, replace(self.options, project=project, imports=imports), self.name)

    def first_request(self, speaker: Speaker) -> Any:
        """Return the first request of every sample."""
        if self.settings.plan.accepts or self.settings.plan.revisions is not None:
            system, turn = self.brief.planning
            return replace(speaker, grammar=None).request(system, (turn,))
        return speaker.request(self.brief.system, (self.brief.first,))

    def begin(self, run: Run, command: str, **facts: Any) -> None:
        """Save task and settings, so that the run can be resumed."""
        endings = [ENDINGS[picture.media_type] for picture in self.task.pictures]
        for number, (picture, ending) in enumerate(zip(self.task.pictures, endings), 1):
            run.keep(f"input-{number}.{ending}", picture.data)
        run.keep_text("system.md", self.brief.system)
        evaluation = {"seed": self.options.seed, "limits": asdict(self.options.limits), "name": self.name}
        evaluation["project"] = str(self.options.project) if self.options.project is not None else None
        evaluation["imports"] = sorted(map(str, self.options.imports or ()))
        settings, task = self.settings.data(), task_data(self.task)
        run.note(command=command, state="running", settings=settings, task=task, evaluation=evaluation, **facts)

    def run(self, run: Run, client: Client, live: TextIO | None) -> Result:
        """Generate, repair, refine and select. Raises SceneError if no sample yields a valid program; the run folder
        then contains all attempts."""
        speaker = self.settings.speaker(client.model, self.task.notation)
        conductor = Conductor(client, run, LiveCount(live), self.settings)
        play = conductor.in_batches if self.settings.is_batch else conductor.singly
        plan, reader = self.settings.plan, self.reader(run)
        numbers = range(1, self.settings.samples + 1)
        ended = play({n: _steps_of(plan)(self.brief, reader, speaker, plan) for n in numbers})
        outcomes = {sample: outcome for sample, outcome in ended.items() if isinstance(outcome, SampleOutcome)}
        sample = self._best(outcomes, conductor, speaker)
        stopped = tuple(_errors(ended))
        if sample is None:
            raise _nothing(run, outcomes, stopped)
        _keep_steps(run, outcomes[sample])
        usage = sum((_usage(attempt.facts) for attempt in run.attempts()), Usage())
        return Result(outcomes[sample].verdict, sample, client.budget.spent, usage, stopped)

    def _best(self, outcomes: Mapping[int, SampleOutcome], conductor: Conductor, speaker: Speaker) -> int | None:
        """Return the best sample; ties are decided by the model from rendered images."""
        best = candidates(outcomes)
        if len(best) < 2:
            return best[0] if best else None
        verdicts = [outcomes[sample].verdict for sample in best]
        if len({verdict.program for verdict in verdicts}) == 1:
            return best[0]
        steps = judge_steps(self.brief.prompts, speaker, self.task, verdicts)
        chosen = conductor.singly({_JUDGE: steps})[_JUDGE]
        if isinstance(chosen, SceneError):
            return best[0]  # without a judge, ties are decided by order
        return next(sample for sample, verdict in zip(best, verdicts) if verdict is chosen.verdict)


def _steps_of(plan: SamplePlan) -> Callable[[Brief, AnswerReader, Speaker, SamplePlan], Steps]:
    """Return what generates a sample: `generate`, the same after its acceptance, or `build`."""
    if plan.revisions is not None:
        return build_steps
    return accepted_steps if plan.accepts else sample_steps


def _keep_steps(run: Run, outcome: SampleOutcome) -> None:
    """Write the acceptance and the steps of the best sample into the run."""
    if outcome.acceptance:
        run.keep_text("acceptance.scene", "".join(f"(assert-that {d})\n" for d in outcome.acceptance))
    if outcome.log:
        run.keep_text("steps.txt", "".join(f"{line}\n" for line in outcome.log))


class NoProgram(SceneError):
    """Raised if no sample yields a valid program; ``verdict`` is that of the first sample's last attempt."""

    def __init__(self, verdict: Verdict, place: Path | None = None) -> None:
        failed = sum(d.name == "declaration" for d in verdict.diagnostics)
        problem, hint = "no sample produced a valid program", "allow more repairs with --repair"
        if verdict.scene is not None and failed and failed == sum(d.is_error for d in verdict.diagnostics):
            problem = f"the best scene does not fulfill {failed} of the statements that it must"
            hint += f"; its program is {place}" if place is not None else ""
        super().__init__("model-answer", problem, hint)
        self.verdict = verdict


def _errors(ended: Mapping[int, Ended]) -> list[SceneError]:
    errors = [o if isinstance(o, SceneError) else o.stopped for o in ended.values()]
    return [error for error in errors if error is not None]


def _nothing(run: Run, outcomes: Mapping[int, SampleOutcome], stopped: tuple[SceneError, ...]) -> SceneError:
    """Return the reason for a failed run: the error that stopped the first sample, else its last verdict.

    The program of a scene that fails statements only is written into the run, for a person to go on with.
    """
    if not outcomes and stopped:
        return stopped[0]
    outcome = next(iter(outcomes.values()))
    _keep_steps(run, outcome)
    if outcome.verdict.scene is not None and outcome.verdict.program:
        run.keep_text("refused.scene", outcome.verdict.program)
        return NoProgram(outcome.verdict, run.path / "refused.scene")
    return NoProgram(outcome.verdict)


def _usage(facts: Mapping[str, Any]) -> Usage:
    return Usage(**facts["usage"]) if not facts.get("was_kept") else Usage()


def inference_of(run: Run) -> Inference:
    """Load the inference of a run, to resume it. Raises SceneError if the run folder is damaged."""
    facts = run.facts
    try:
        evaluation = facts["evaluation"]
        project = Path(evaluation["project"]) if evaluation["project"] is not None else None
        imports = frozenset(Path(str(path)) for path in evaluation["imports"])
        limits = typed(Limits, evaluation["limits"])
        options = Options(seed=int(evaluation["seed"]), limits=limits, project=project, imports=imports)
        return Inference(task_of(run), settings_of(facts["settings"]), options, str(evaluation["name"]))
    except (KeyError, TypeError, ValueError) as error:
        raise SceneError("run", f"the run {run.name} is damaged: {type(error).__name__} {error}") from None


# --- serialization of tasks ----------------------------------------------------------------------------------------


def task_data(task: Task) -> dict[str, Any]:
    """Return a task as JSON data; its images are files of the run."""
    return {
        "text": task.text,
        "kind": task.kind.value,
        "notation": task.notation.value,
        "ablation": task.ablation.value,
        "pictures": [picture.media_type for picture in task.pictures],
        "program": task.program,
        "seed": task.seed,
    }


def task_of(run: Run) -> Task:
    """Load the task of a run. Raises SceneError if the run folder is damaged."""
    data = run.facts.get("task", {})
    try:
        pictures = tuple(
            ImageContent(kind, (run.path / f"input-{number}.{ENDINGS[kind]}").read_bytes())
            for number, kind in enumerate(data["pictures"], 1)
        )
        kind, notation, ablation = TaskKind(data["kind"]), Notation(data["notation"]), Ablation(data["ablation"])
        text, program = data["text"], data["program"]
        if not isinstance(text, str) or not isinstance(program, str | None):
            raise TypeError("no text")
        return Task(text, kind, notation, ablation, pictures, program, int(data["seed"]))
    except (KeyError, ValueError, TypeError, OSError) as error:
        raise SceneError("run", f"the run {run.name} is damaged: {type(error).__name__} {error}") from None
