"""One run: a task goes to the model, samples are mended and improved, the best is chosen (the paper, section 5)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, TextIO

from scenelang.backends.language_models.client import Client
from scenelang.backends.language_models.conversation import Picture, Usage
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.answers import Reader, Verdict
from scenelang.inference.brief import Brief
from scenelang.inference.conductor import Conductor, Ended
from scenelang.inference.input_pictures import ENDINGS
from scenelang.inference.live_count import LiveCount
from scenelang.inference.prompts import Prompts
from scenelang.inference.records import Run
from scenelang.inference.selection import candidates, judge_steps
from scenelang.inference.settings import Settings, settings_of, typed
from scenelang.inference.steps import Outcome, Speaker, sample_steps
from scenelang.inference.task import Ablation, Kind, Notation, Task
from scenelang.interpreter.limits import Limits
from scenelang.session import Options

_JUDGE = 0  # the sample under which the judge's question is recorded


@dataclass(frozen=True, slots=True)
class Result:
    """What a run came to. ``best`` is the verdict of ``sample``; ``stopped`` are the errors of samples that ended
    early."""

    best: Verdict
    sample: int
    spent: float
    usage: Usage
    stopped: tuple[SceneError, ...] = ()


@dataclass(frozen=True)
class Inference:
    """A task and how it is to be asked. ``options`` bound the evaluation of answers; ``name`` is what diagnostics
    call a program."""

    task: Task
    settings: Settings
    options: Options
    name: str = "answer.scene"
    brief: Brief = field(init=False)

    def __post_init__(self) -> None:
        is_bare = self.settings.sends_grammar(self.task.notation)
        object.__setattr__(self, "brief", Brief(self.task, Prompts(self.settings.prompts_folder), is_bare))

    def reader(self, run: Run) -> Reader:
        """Reads answers. Their programs import only what ``options`` names, and find assets in its folder, else in the
        run's."""
        project, imports = self.options.project or run.path, self.options.imports or frozenset()
        return Reader(self.brief, replace(self.options, project=project, imports=imports), self.name)

    def first_request(self, speaker: Speaker) -> Any:
        """The request that every sample begins with."""
        return speaker.request(self.brief.system, (self.brief.first,))

    def begin(self, run: Run, command: str, **facts: Any) -> None:
        """Write down what is asked for, so that the run can go on after a kill."""
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
        """Ask, mend, improve and choose. Raises SceneError where no sample came to a program, or to one that works;
        the run folder then holds all that there is."""
        speaker = self.settings.speaker(client.model, self.task.notation)
        conductor = Conductor(client, run, LiveCount(live), self.settings.side_by_side)
        play = conductor.in_batches if self.settings.is_batch else conductor.singly
        plan, reader = self.settings.plan, self.reader(run)
        numbers = range(1, self.settings.samples + 1)
        ended = play({n: sample_steps(self.brief, reader, speaker, plan) for n in numbers})
        outcomes = {sample: outcome for sample, outcome in ended.items() if isinstance(outcome, Outcome)}
        sample = self._best(outcomes, conductor, speaker)
        stopped = tuple(_errors(ended))
        if sample is None:
            raise _nothing(outcomes, stopped)
        usage = sum((_usage(attempt.facts) for attempt in run.attempts()), Usage())
        return Result(outcomes[sample].verdict, sample, client.spending.spent, usage, stopped)

    def _best(self, outcomes: Mapping[int, Outcome], conductor: Conductor, speaker: Speaker) -> int | None:
        """The best sample, chosen by the model's eye where nothing else tells them apart."""
        found = candidates(outcomes)
        if len(found) < 2:
            return found[0] if found else None
        verdicts = [outcomes[sample].verdict for sample in found]
        if len({verdict.program for verdict in verdicts}) == 1:
            return found[0]
        steps = judge_steps(self.brief.prompts, speaker, self.task, verdicts)
        chosen = conductor.singly({_JUDGE: steps})[_JUDGE]
        if isinstance(chosen, SceneError):
            return found[0]  # no judge, no choice: the first is as good as any
        return next(sample for sample, verdict in zip(found, verdicts) if verdict is chosen.verdict)


class NoProgram(SceneError):
    """No sample came to a program that works; ``verdict`` is on the last try of the first."""

    def __init__(self, verdict: Verdict) -> None:
        super().__init__("model-answer", "no answer came to a program that works", "allow more tries with --repair")
        self.verdict = verdict


def _errors(ended: Mapping[int, Ended]) -> list[SceneError]:
    errors = [o if isinstance(o, SceneError) else o.stopped for o in ended.values()]
    return [error for error in errors if error is not None]


def _nothing(outcomes: Mapping[int, Outcome], stopped: tuple[SceneError, ...]) -> SceneError:
    """Why there is no program: what stopped the first sample, else what is wrong with the last try."""
    if not outcomes and stopped:
        return stopped[0]
    return NoProgram(next(iter(outcomes.values())).verdict)


def _usage(facts: Mapping[str, Any]) -> Usage:
    return Usage(**facts["usage"]) if not facts.get("was_kept") else Usage()


def inference_of(run: Run) -> Inference:
    """What a run asks for, to go on with it. Raises SceneError for a run folder that is damaged."""
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


# --- a task as data ------------------------------------------------------------------------------------------------


def task_data(task: Task) -> dict[str, Any]:
    """A task as JSON data; its pictures are files of the run."""
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
    """The task of a run. Raises SceneError for a run folder that is damaged."""
    data = run.facts.get("task", {})
    try:
        pictures = tuple(
            Picture(kind, (run.path / f"input-{number}.{ENDINGS[kind]}").read_bytes())
            for number, kind in enumerate(data["pictures"], 1)
        )
        kind, notation, ablation = Kind(data["kind"]), Notation(data["notation"]), Ablation(data["ablation"])
        text, program = data["text"], data["program"]
        if not isinstance(text, str) or not isinstance(program, str | None):
            raise TypeError("no text")
        return Task(text, kind, notation, ablation, pictures, program, int(data["seed"]))
    except (KeyError, ValueError, TypeError, OSError) as error:
        raise SceneError("run", f"the run {run.name} is damaged: {type(error).__name__} {error}") from None
