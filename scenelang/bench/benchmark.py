"""``scenelang.benchmark``: runs the tasks of the benchmark with a language model, or from recorded answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from scenelang.backends.files import write_json, write_text
from scenelang.bench.answering import (
    RECORDING,
    Answerer,
    MutationModel,
    Recorder,
    Replay,
    ServiceAnswerer,
    recording_of,
)
from scenelang.bench.mutations import MutationReport, measure
from scenelang.bench.results import (
    BenchComparison,
    ModeResults,
    compared,
    markdown,
    results_data,
    results_of,
    save_contact_sheet,
)
from scenelang.bench.tasks import BenchTask, load_tasks
from scenelang.bench.trials import (
    MODES,
    BenchMode,
    BenchRun,
    BenchSettings,
    Planned,
    Trial,
    applicable,
    planned,
    run_trials,
)
from scenelang.grammar.diagnostics import SceneError, UsageError, usage_errors
from scenelang.grammar.settings import typed
from scenelang.inference.brief import Notation
from scenelang.inference.records import InferenceSettings
from scenelang.inference.steps import Speaker

TABLE, DATA, SHEET = "results.md", "results.json", "sheet.png"
_RECORDED_TOKENS = 32_000


@dataclass(frozen=True, slots=True)
class BenchReport:
    """Results of a run of the benchmark.

    Attributes
    ----------
    folder : Path
        Folder of the run: settings, answers, trials, programs.
    results : tuple of ModeResults
        Figures of each mode: ``results[0].figures["pass@1"].value``.
    trials : tuple of Trial
        What came of each sample of each task.
    outdated, missing : int
        Number of recorded answers that were given to another wording of their request, and of requests without a
        recorded answer.
    """

    folder: Path
    results: tuple[ModeResults, ...]
    trials: tuple[Trial, ...] = field(repr=False)
    outdated: int = 0
    missing: int = 0

    def __str__(self) -> str:
        """Return the tables in Markdown."""
        return markdown(self.results).rstrip()

    def data(self) -> dict[str, Any]:
        """Return the figures as JSON data."""
        return {
            "run": str(self.folder),
            "outdated": self.outdated,
            "missing": self.missing,
            "modes": results_data(self.results),
        }

    @typed
    def save(self, sheet: bool = True) -> list[Path]:
        """Write ``results.md``, ``results.json`` and ``sheet.png`` into the folder; returns their paths."""
        written = [self.folder / TABLE, self.folder / DATA]
        write_text(written[0], markdown(self.results, f"Benchmark: {self.folder.name}"))
        write_json(written[1], self.data())
        if sheet and self.trials:
            save_contact_sheet(BenchRun(self.folder), self.trials, self.folder / SHEET)
            written.append(self.folder / SHEET)
        return written


@typed
def benchmark(
    output: str | Path,
    *,
    modes: Sequence[str] = (),
    tasks: Sequence[str] = (),
    groups: Sequence[str] = (),
    hard: bool = False,
    task_folder: str | Path | None = None,
    settings: InferenceSettings | None = None,
    replay: str | Path | None = None,
    any_prompt: bool = False,
    mutations: int | None = None,
    simulates: bool = False,
    progress: Callable[[float], None] | None = None,
) -> BenchReport:
    """Run the benchmark; a run that was interrupted goes on where it stopped.

    Parameters
    ----------
    output : path
        Folder of the run, new or that of an earlier run with the same options.
    modes : sequence of str
        Modes: "python", "dsl" and "dsl-grammar", each also with "+critique"; by default "python" and "dsl", or those of
        the recording.
    tasks, groups : sequence of str
        Names of tasks and groups; by default all but the hard split.
    hard : bool
        Whether the hard split is run: alone, or besides ``tasks`` and ``groups``.
    task_folder : path, optional
        TOML file with tasks, or a folder of these, in place of the package's.
    settings : InferenceSettings, optional
        Model, limits, number of samples and of repairs.
    replay : path, optional
        A run, or its ``answers.jsonl``, whose answers are used in place of a model.
    any_prompt : bool
        Also use recorded answers that were given to another wording of their request.
    mutations : int, optional
        Seed of the mutation model, which is used in place of a language model, in modes of the language: it plants
        mistakes in the tasks' passing programs, and repairs them by what ``check --json`` says.
    simulates : bool
        Whether static scenes are simulated, for the share of stable ones.
    progress : callable, optional
        Called with the finished share of the trials.

    Returns
    -------
    BenchReport
        Figures of each mode.

    Raises
    ------
    UsageError
        For unknown modes, tasks or groups, or a folder of another run.
    SceneError
        If a service fails or the cost limit is reached; what is finished is saved.

    Examples
    --------
    >>> report = benchmark("out/bench", replay="benchmarks/answers/after.jsonl")  # doctest: +SKIP
    >>> report.results[0].figures["pass@1"].value  # doctest: +SKIP
    1.0
    """
    settings = settings or InferenceSettings()
    if replay is not None and mutations is not None:
        raise UsageError("value", "a recording and the mutation model cannot be combined")
    recording = Replay(recording_of(Path(replay)), any_prompt) if replay is not None else None
    known = load_tasks(Path(task_folder) if task_folder is not None else None)
    is_as_recorded = recording is not None and not (tasks or groups or hard)
    chosen = known if is_as_recorded else applicable(known, tasks, groups, hard)
    chosen_modes = tuple(modes) or _default_modes(recording, mutations)
    samples = recording.samples if recording is not None and settings.samples == 1 else settings.samples
    asked = BenchSettings(chosen_modes, samples, settings.repairs, simulates, settings.prompt_dir)
    asked.check()
    plan = _plan(chosen, asked, None if tasks or groups else recording)
    run = BenchRun(Path(output))
    model_of_mistakes = MutationModel(chosen, mutations) if mutations is not None else None
    answerer, speaker, model = _source(recording or model_of_mistakes, settings, asked)
    named = list(dict.fromkeys(task.name for task, _, _ in plan))
    run.begin({"settings": asdict(asked), "model": model, "tasks": named, "folder": _text(task_folder)})
    if recording is None:
        answerer = Recorder(answerer, run.folder / RECORDING)
    side_by_side = settings.side_by_side if recording is None and mutations is None else 1
    trials = run_trials(run, plan, asked, speaker, answerer, side_by_side, progress)
    used = [task for task in chosen if task.name in named]
    outdated, missing = _unanswered(recording)
    return BenchReport(run.folder, tuple(results_of(trials, used)), tuple(trials), outdated, missing)


def _plan(chosen: Sequence[BenchTask], asked: BenchSettings, recording: Replay | None) -> list[Planned]:
    """Return the trials to run, of a recording only those that it answers; raises UsageError if there are none."""
    plan = planned(chosen, asked)
    if recording is not None:
        answered = {mode: set(recording.tasks(mode)) for mode in asked.modes}
        plan = [each for each in plan if each[0].name in answered[each[1].name]]
    if not plan:
        raise UsageError("value", "no task to run in these modes")
    return plan


def _unanswered(recording: Replay | None) -> tuple[int, int]:
    """Return how many answers are to another wording, and how many requests have none; raises SceneError if all."""
    if recording is None:
        return 0, 0
    if recording.missing and not recording.found:
        hint = "the prompts are other ones than when it was made: replay it with --any-prompt"
        raise SceneError("run", f"none of {recording.missing} requests has an answer in the recording", hint)
    return recording.outdated, recording.missing


def _default_modes(recording: Replay | None, mutations: int | None) -> tuple[str, ...]:
    if recording is not None:
        return recording.modes
    return BenchSettings().modes if mutations is None else ("dsl",)


def _text(path: str | Path | None) -> str | None:
    return None if path is None else str(path)


def _source(
    offline: Replay | MutationModel | None, settings: InferenceSettings, asked: BenchSettings
) -> tuple[Answerer, Callable[[BenchMode], Speaker], str]:
    """Return what answers, the parameters of requests by mode, and the name of the model."""
    if isinstance(offline, MutationModel) and any(MODES[m].notation is not Notation.LANGUAGE for m in asked.modes):
        raise UsageError("value", "the mutation model writes the language only", "choose modes such as dsl")
    if offline is not None:
        return offline, _recorded_speaker, offline.name
    if settings.is_batch:
        raise UsageError("value", "the benchmark does not support batches", "omit --batch")
    constrained = [mode for mode in asked.modes if MODES[mode].is_constrained]
    if constrained and not settings.sends_grammar(Notation.LANGUAGE):
        hint = "use --provider openai with a local server"
        raise UsageError("value", f"{settings.provider} has no grammars, which mode {constrained[0]} requires", hint)
    client = settings.client()
    with usage_errors():
        speakers = {mode: settings.speaker(client.model, MODES[mode].notation) for mode in asked.modes}
    chosen = lambda mode: speakers[mode.name] if mode.is_constrained else replace(speakers[mode.name], grammar=None)
    return ServiceAnswerer(client), chosen, client.model.name


def _recorded_speaker(mode: BenchMode) -> Speaker:
    """Return the parameters of requests that a recording answers; only whether there is a grammar matters."""
    return Speaker("recorded", _RECORDED_TOKENS, _RECORDED_TOKENS, grammar="recorded" if mode.is_constrained else None)


@typed
def measure_diagnostics(
    per_kind: int = 20,
    *,
    tasks: Sequence[str] = (),
    groups: Sequence[str] = (),
    hard: bool = False,
    task_folder: str | Path | None = None,
    seed: int = 0,
) -> MutationReport:
    """Measure the checker: plant mistakes in the passing programs of tasks, and repair them by what it says.

    Parameters
    ----------
    per_kind : int
        Number of programs with a mistake of each kind.
    tasks, groups, hard, task_folder
        As of ``benchmark``.
    seed : int
        The same seed plants the same mistakes.

    Returns
    -------
    MutationReport
        The share of mistakes that the fixes and names in ``check --json`` repair within one turn, by kind.
    """
    if not 1 <= per_kind <= 10_000:
        raise UsageError("value", f"expected 1 to 10,000 mistakes of each kind, got {per_kind:,}")
    chosen = applicable(load_tasks(Path(task_folder) if task_folder is not None else None), tasks, groups, hard)
    return measure({task.name: task.passes for task in chosen}, per_kind, seed)


@typed
def benchmark_report(folder: str | Path) -> BenchReport:
    """Return the results of a run so far. Raises SceneError for a folder that is no run of the benchmark."""
    run = BenchRun(Path(folder))
    trials = run.trials()
    return BenchReport(run.folder, tuple(results_of(trials, _tasks_of(run))), tuple(trials))


@typed
def compare_benchmarks(before: str | Path, after: str | Path) -> list[BenchComparison]:
    """Compare two runs on the trials that both have, by mode. Raises SceneError if they have none in common."""
    first, second = BenchRun(Path(before)), BenchRun(Path(after))
    return compared(first.trials(), second.trials(), _tasks_of(second))


def comparison_data(comparisons: Sequence[BenchComparison]) -> list[dict[str, Any]]:
    """Return a comparison as JSON data."""
    return [asdict(each) for each in comparisons]


def _tasks_of(run: BenchRun) -> tuple[BenchTask, ...]:
    folder = run.facts.get("folder")
    return load_tasks(Path(folder) if folder is not None else None)
