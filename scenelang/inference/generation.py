"""Scenes that a language model makes or changes: what ``scenelang.generate`` and ``scenelang.edit`` do."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TextIO

from scenelang.backends.base import Progress
from scenelang.backends.files import read_regular, rewrite, write_text
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, UsageError, to_json, usage_errors
from scenelang.inference.brief import Ablation, Notation, Task, TaskKind
from scenelang.inference.conductor import Describer, Inference, LiveCount, Result, inference_of, payload_text
from scenelang.inference.listing import listing, program_of
from scenelang.inference.records import (
    RENEWABLE,
    InferenceSettings,
    Run,
    all_runs,
    check_limits,
    find_run,
    new_run,
    runs_folder,
)
from scenelang.inference.steps import Verdict, geometry_findings, has_blocks, read_picture
from scenelang.interpreter.program.program import Program
from scenelang.interpreter.runtime.limits import Limits
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene.entity import Scene as SceneGraph
from scenelang.interpreter.transpile.python_text import code_of, find_code
from scenelang.scene_changes import Changes, changes_between, paired_by_path, sheets_of
from scenelang.session import Evaluated, Options, Session, is_python, is_scene_file

if TYPE_CHECKING:
    from scenelang.backends.language_models.catalogue import Usage
    from scenelang.scene import Image, Scene

_LONGEST_TASK = 100_000  # characters
_MOST_PICTURES = 20
_TOKENS_OF_WORDS = 8_000
_SIZE = 512
_DRAFT_SIZE = 768


# --- what is asked for -----------------------------------------------------------------------------------------------


def task_of(
    text: str,
    images: Sequence[str | Path] = (),
    kind: TaskKind = TaskKind.STILL,
    notation: Notation = Notation.PYTHON,
    ablation: Ablation = Ablation.NONE,
    seed: int = 0,
) -> Task:
    """The task of making a scene of words and pictures. Raises UsageError, and SceneError for a bad picture."""
    text = text.strip()
    if not text and not images:
        raise UsageError("value", "say what the scene shows, or give a picture with --image")
    if len(text) > _LONGEST_TASK or len(images) > _MOST_PICTURES:
        raise UsageError("value", f"a task has at most {_LONGEST_TASK:,} characters and {_MOST_PICTURES} pictures")
    if ablation.takes_program:
        if notation is Notation.LANGUAGE:
            raise UsageError("value", "--dsl asks for a program, which --ablate P takes away")
        notation = Notation.LIST
    return Task(text, kind, notation, ablation, tuple(read_picture(str(path)) for path in images), None, seed)


def edit_task(source: Source, scene: SceneGraph, instruction: str, ablation: Ablation, seed: int) -> Task:
    """The task of changing the program ``source``, which makes ``scene``. Raises SceneError for a scene that is no
    program, or too large for a list."""
    if is_scene_file(source):
        hint = "edit the program that made it, or try --ablate P on that"
        raise SceneError("unsupported", f"{source.name} is a finished scene, which has no program to edit", hint)
    if ablation.takes_program:
        program, notation = listing(scene, not ablation.takes_words), Notation.LIST
    elif is_python(source):
        program, notation = code_of(source.text), Notation.PYTHON
    else:
        program, notation = source.text, Notation.LANGUAGE
    return Task(instruction, kind_of(scene), notation, ablation, (), program, seed)


def kind_of(scene: SceneGraph) -> TaskKind:
    """What a scene is."""
    if scene.animated:
        return TaskKind.FILM
    return TaskKind.BLOCKS if has_blocks(scene) else TaskKind.STILL


def imported_files(program: Program | None) -> frozenset[Path]:
    """The files that a program imports: an edit of it may import these and no others."""
    sources = program.sources if program is not None else ()
    return frozenset(Path(source.name).resolve() for source in sources if not source.name.startswith((STD, "<")))


@dataclass(frozen=True, slots=True)
class Estimate:
    """The first request as the service takes it, without sending it: ``tokens`` and ``cost`` (US dollars) are upper
    bounds before repairs and critiques; ``grammar`` is what answers are held to, where the server can."""

    address: str
    payload: Mapping[str, Any] = field(repr=False)
    grammar: str | None = field(repr=False)
    tokens: int
    cost: float

    def __str__(self) -> str:
        """The request and what it costs, as people read them."""
        grammar = (
            f"\ngrammar: {len(self.grammar):,} characters, where the server takes one\n"
            if self.grammar is not None
            else ""
        )
        most = f"at most {self.tokens:,} tokens and ${self.cost:.4f} before repairs and critiques"
        return f"{payload_text(self.payload)}\n{grammar}\nto {self.address}: {most}"

    def data(self) -> dict[str, Any]:
        """The estimate as JSON data."""
        return {"address": self.address, "request": self.payload, "tokens": self.tokens, "cost": self.cost}


def first_estimate(inference: Inference) -> Estimate:
    """What a run would send first and cost at most; needs neither key nor network. Raises UsageError."""
    from scenelang.backends.language_models.openai_chat import upper_estimate
    from scenelang.backends.language_models.provider import unconnected

    settings = inference.settings
    with usage_errors():
        provider = unconnected(settings.provider)
        model = settings.known_model(provider)
        speaker = settings.speaker(model, inference.task.notation)
    request = inference.first_request(speaker)
    tokens = upper_estimate(request)
    cost = settings.samples * model.highest_cost(tokens, request.max_tokens, settings.is_batch)
    payload = provider.payload(replace(request, grammar=None))
    return Estimate(provider.address, payload, request.grammar, tokens, cost)


def describer(settings: InferenceSettings, live: TextIO | None = None) -> Describer:
    """What asks a model how things look. Raises SceneError."""
    from scenelang.inference.brief import Prompts

    settings = replace(settings, max_tokens=settings.max_tokens or _TOKENS_OF_WORDS)
    client = settings.client()
    speaker = settings.speaker(client.model, Notation.PYTHON)
    return Describer(client, Prompts(settings.prompts_folder), speaker, LiveCount(live))


# --- runs ------------------------------------------------------------------------------------------------------------


def begin(inference: Inference, command: str, name: str, runs: str | None = None, **facts: Any) -> Run:
    """A new run's folder. Raises UsageError for what the model or the provider cannot do."""
    client = inference.settings.client()
    with usage_errors():
        inference.settings.speaker(client.model, inference.task.notation)
        if inference.settings.is_batch:
            client.batches()
    run = new_run(runs_folder(runs), name, client.clean)
    inference.begin(run, command, **facts)
    return run


def resumed(name: str, command: str, runs: str | None = None) -> tuple[Inference, Run]:
    """The run to continue: its name, "last", or its folder. Raises UsageError for one of another command."""
    folder = runs_folder(runs)
    run = find_run(folder, name)
    if run.path.resolve().parent != folder.resolve():
        hint = f"--runs {run.path.parent} says that you trust it"
        raise UsageError("run", f"{run.path} is not among your runs; it may overwrite files and spend money", hint)
    made_by = run.facts.get("command")
    if made_by == "repl":
        hint = f"what it came to is in {run.path / 'best.scene'}"
        raise UsageError("run", f"the run {run.name} was made in the REPL, which alone could go on with it", hint)
    if made_by != command:
        hint = f"scenelang {made_by} --resume {run.name}"
        raise UsageError("run", f"the run {run.name} was made by `{made_by}`", hint)
    return inference_of(run), run


@contextmanager
def recorded(run: Run) -> Iterator[None]:
    """Holds a run, and notes in its folder how it ends."""
    with run.claimed():
        try:
            run.note(state="running")
            yield
        except KeyboardInterrupt:
            run.note(state="interrupted")
            raise
        except SceneError as error:
            run.note(state="failed", error=error.message)
            raise


def play(inference: Inference, run: Run, live: TextIO | None = None) -> Result:
    """Ask until the run is done; what its records hold is not asked again. Raises SceneError."""
    client = inference.settings.client(run.spent)
    run = Run(run.path, client.clean)
    run.note(settings=inference.settings.data())
    result = inference.run(run, client, live)
    run.keep_text("best.scene", result.best.program)
    run.note(state="done", sample=result.sample, cost=result.spent)
    return result


# --- results ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Generated:
    """A scene that a language model made.

    ``program`` is its text, ``scene`` what it evaluates to, ``warnings`` what is odd about both, ``sample`` the number
    of the best sample, ``stopped`` the errors of samples that ended early, ``cost`` in US dollars, ``run`` the folder
    with every question and answer.
    """

    program: str = field(repr=False)
    scene: Scene
    warnings: tuple[Diagnostic, ...] = field(repr=False)
    sample: int
    usage: Usage = field(repr=False)
    cost: float
    run: Path
    stopped: tuple[SceneError, ...] = field(default=(), repr=False)

    def save(self, path: str | Path) -> Path:
        """Write the program; returns its path."""
        return _write(Path(path), self.program)

    def __str__(self) -> str:
        """Which sample it is, what it cost and where the run is, in a line."""
        sent, answered = f"{self.usage.prompt:,} tokens sent", f"{self.usage.answered:,} answered"
        return f"sample {self.sample}; {sent}, {answered}, ${self.cost:.4f}; kept in {self.run}"

    def data(self) -> dict[str, Any]:
        """The result as JSON data."""
        return {
            "run": str(self.run),
            "sample": self.sample,
            "program": self.program,
            "diagnostics": [to_json(d) for d in self.warnings],
            "stopped": [error.message for error in self.stopped],
            "tokens": {"sent": self.usage.prompt, "answered": self.usage.answered},
            "cost": self.cost,
        }


def draw_draft(scene: Scene, beside: Path, progress: Progress | None = None) -> Path:
    """Draw a scene beside its program, and give the file: a picture, of a film a GIF."""
    size = _DRAFT_SIZE
    if scene.animated:
        return scene.film(size=(size // 2, size // 2)).save(beside.with_suffix(".gif"), progress=progress)
    return scene.render(size=(size, size), progress=progress).save(beside.with_suffix(".png"))


@dataclass(frozen=True, slots=True)
class SceneEdit:
    """What an edit did: ``text`` is the unified difference of the programs, as the model was sent and as it wrote
    them; ``changes`` what that did to the scene."""

    text: str
    changes: Changes


@dataclass(frozen=True, slots=True)
class Edited:
    """A program that a language model changed: ``diff`` and ``changes`` say how, ``before`` is the scene as it was;
    ``result`` is what came back. Nothing is overwritten before ``save`` or ``apply``."""

    path: Path
    diff: str = field(repr=False)
    changes: Changes
    before: Scene = field(repr=False)
    result: Generated
    task: Task = field(repr=False)
    verdict: Verdict = field(repr=False)
    digest: str | None = field(repr=False)

    @property
    def scene(self) -> Scene:
        """The scene as it is now."""
        return self.result.scene

    def picture(self) -> Image:
        """Both scenes from one camera, side by side. Raises SceneError for a scene that cannot be drawn."""
        return before_and_after(self.before, self.result.scene)

    def save(self, path: str | Path) -> Path:
        """Write the changed program, in the notation that the ending of ``path`` says; returns its path."""
        return _write(Path(path), written_as(Path(path), self.task, self.verdict))

    def apply(self) -> Path:
        """Write it over the file that was edited; raises SceneError for one that somebody changed meanwhile."""
        if digest_of(self.path) != self.digest:
            hint = "write the edit elsewhere with -o"
            raise SceneError("file", f"{self.path} has changed since its program was sent", hint)
        return self.save(self.path)

    def data(self) -> dict[str, Any]:
        """The result as JSON data."""
        return self.result.data() | {"diff": self.diff, "changes": self.changes.data()}


def digest_of(path: Path) -> str:
    """What tells whether a file has changed."""
    return sha256(read_regular(path)).hexdigest()


def _write(target: Path, text: str) -> Path:
    if target.exists():
        rewrite(target, text)
        return target
    write_text(target, text)
    return target


def generated(run: Run, result: Result, options: Options) -> Generated:
    """What a run came to."""
    from scenelang.scene import Scene

    best = result.best
    assert best.scene is not None
    scene = Scene(best.scene, "answer.scene", (), best.diagnostics, None, options)
    warnings = (*best.diagnostics, *best.findings)
    return Generated(best.program, scene, warnings, result.sample, result.usage, result.spent, run.path, result.stopped)


def edited(inference: Inference, run: Run, path: Path, live: TextIO | None = None) -> Edited:
    """Play the run of an edit to its end, and work out what the edit did. Raises SceneError."""
    from scenelang.scene import Scene

    result = play(inference, run, live)
    before = scene_before(path, inference.task, inference.options)
    made = edit_of(path.name, inference.task, before, result.best, inference.options.limits.primitives)
    run.keep_text("edit.diff", made.text + "\n")
    came_to = generated(run, without_known(result, before), inference.options)
    kept = run.facts.get("digest")
    scene = Scene(before, str(path), options=inference.options)
    digest = str(kept) if kept is not None else None
    return Edited(path, made.text, made.changes, scene, came_to, inference.task, result.best, digest)


def scene_before(path: Path, task: Task, options: Options) -> SceneGraph:
    """The scene of the program that is edited, as it was sent. Raises SceneError where that makes none any more."""
    assert task.program is not None
    if task.notation is Notation.LIST:
        source = Source(str(path), program_of(task.program, task.text))
    else:
        source = Source(str(path.with_suffix(".py") if task.notation is Notation.PYTHON else path), task.program)
    scene = Session(options).evaluate(source).scene
    if scene is None:
        raise SceneError("run", f"the program of {path} makes no scene any more, so there is nothing to compare with")
    return scene


def edit_of(name: str, task: Task, before: SceneGraph, after: Verdict, limit: int) -> SceneEdit:
    """What an edit did. Raises SceneError for scenes of more than ``limit`` primitives."""
    assert after.scene is not None
    assert task.program is not None
    written = listing(after.scene, task.ablation is Ablation.P) if task.notation is Notation.LIST else after.code
    lines = difflib.unified_diff(
        task.program.splitlines(), written.splitlines(), f"{name} before", f"{name} after", lineterm=""
    )
    changes = changes_between(sheets_of(before, limit), sheets_of(after.scene, limit))
    return SceneEdit("\n".join(lines), paired_by_path(changes))


def without_known(result: Result, before: SceneGraph) -> Result:
    """A result without what was odd about the scene's geometry before the edit already."""
    known = {finding.message for finding in geometry_findings(before)}
    findings = tuple(finding for finding in result.best.findings if finding.message not in known)
    return replace(result, best=replace(result.best, findings=findings))


def written_as(path: Path, task: Task, after: Verdict) -> str:
    """The edited program as the file ``path`` holds it: in the notation of the edit where its ending says so."""
    if task.notation is Notation.LANGUAGE:
        return after.code
    if task.notation is Notation.PYTHON and path.suffix == ".py":
        return after.code
    if task.notation is Notation.PYTHON and path.suffix == ".txt":
        return _in_response(path, after.code)
    return after.program


def _in_response(path: Path, code: str) -> str:
    """The response that a file holds with other code in it; a new file has the code alone."""
    text = path.read_text("utf-8") if path.exists() else ""
    found = find_code(text)
    if not text[: found.start].strip():
        return f"```python\n{code}```\n"
    return text[: found.start] + code + text[found.end :]


def before_and_after(before: Scene, after: Scene) -> Image:
    """Both scenes from one camera, side by side: from where the larger one is seen whole. Raises SceneError for a
    scene that cannot be drawn."""
    larger = max((before, after), key=_largest_side)
    camera = larger.placed(size=(_SIZE, _SIZE))
    frame = min(len(before.frames), len(after.frames)) // 2
    first, second = (scene.render(camera, frame=frame if scene.animated else None) for scene in (before, after))
    return first.beside(second)


def _largest_side(scene: Scene) -> float:
    from scenelang.backends.pictures.stage import box_of

    low, high = box_of(scene.graph)
    return float((high - low).max())


# --- the whole of it -------------------------------------------------------------------------------------------------


def editing(
    path: Path, instruction: str, settings: InferenceSettings, options: Options, ablation: Ablation = Ablation.NONE
) -> tuple[Evaluated, Inference | None]:
    """The edit to ask for, None for a program that is wrong already, and what evaluating the program said."""
    options = replace(options, project=path.resolve().parent)
    session = Session(options)
    source = session.source(str(path))
    result = session.evaluate(source)
    if result.scene is None:
        return result, None
    task = edit_task(source, result.scene, instruction.strip(), ablation, options.seed)
    options = replace(options, imports=imported_files(result.program))
    return result, Inference(task, settings, options, str(path))


def generate(
    task: str = "",
    *,
    model: str | None = None,
    images: Sequence[str | Path] = (),
    kind: Literal["3d", "4d", "minecraft"] = "3d",
    notation: Literal["python", "language"] = "python",
    ablation: Literal["", "P", "W", "PW"] = "",
    settings: InferenceSettings | None = None,
    seed: int = 0,
    limits: Limits | None = None,
    runs: str | None = None,
    live: TextIO | None = None,
) -> Generated:
    """Make a scene of words and pictures, by a language model.

    The model's program is checked and evaluated, mistakes go back to it, the best of several samples is taken. What
    the model answers is never executed as Python.

    Parameters
    ----------
    task : str
        What the scene shows; may be empty where there are pictures.
    model : str, optional
        The model's name; that of ``settings``, or the provider's default, where there is none.
    images : sequence of path
        Pictures to reconstruct.
    kind : str
        "3d", "4d" (a scene that moves) or "minecraft" (a build of blocks).
    notation : str
        What the model writes: "python" against the helper API, or the "language" itself.
    ablation : str
        What is taken from the model, as in the paper's ablations: "P" programs, "W" words.
    settings : InferenceSettings, optional
        Provider, model, samples, repairs, critiques and the limit of cost (default 5 US dollars).
    seed : int
        Seed of the random streams of the program.
    limits : Limits, optional
        Bounds of each evaluation.
    runs : str, optional
        The folder that keeps runs; the user's state folder by default.
    live : text stream, optional
        Where answers are counted as they arrive. Ctrl-C ends the run, which `scenelang generate --resume` continues.

    Raises
    ------
    UsageError
        An argument makes no sense.
    SceneError
        The model cannot be asked, or no answer came to a program that works.

    Examples
    --------
    A key and a connection are needed::

        made = sl.generate("a chess board", model="claude-opus-5-5", settings=sl.InferenceSettings(samples=3))
        made.scene.render().save("board.png")
    """
    asked = task_of(task, images, TaskKind(kind), Notation(notation), Ablation(ablation), seed)
    options = Options(seed=seed, limits=limits or Limits())
    inference = Inference(asked, _settings(settings, model), options)
    facts = {"output": None, "render": False, "invert": False}
    run = begin(inference, "generate", task or "reconstruction", runs, **facts)
    with recorded(run):
        return generated(run, play(inference, run, live), options)


def edit(
    path: str | Path,
    instruction: str,
    *,
    model: str | None = None,
    ablation: Literal["", "P", "W", "PW"] = "",
    settings: InferenceSettings | None = None,
    seed: int = 0,
    limits: Limits | None = None,
    runs: str | None = None,
    live: TextIO | None = None,
) -> Edited:
    """Change a program by an instruction, by a language model. The arguments are those of ``generate``; nothing is
    overwritten before ``Edited.save`` or ``apply``.

    Parameters
    ----------
    path : path
        The program: .scene, or a model's .txt or .py.
    instruction : str
        Such as "make the tower twice as high".

    Raises
    ------
    SceneError
        The program is wrong already, the model cannot be asked, or no answer came to a program that works.
    """
    file = Path(path)
    inference = _edit_of(file, instruction, _settings(settings, model), ablation, seed, limits)
    facts = {"file": str(file.resolve()), "digest": digest_of(file)}
    run = begin(inference, "edit", f"{file.stem} {instruction}", runs, **facts)
    with recorded(run):
        return edited(inference, run, file, live)


def estimate(
    task: str,
    path: str | Path | None = None,
    *,
    model: str | None = None,
    images: Sequence[str | Path] = (),
    kind: Literal["3d", "4d", "minecraft"] = "3d",
    notation: Literal["python", "language"] = "python",
    ablation: Literal["", "P", "W", "PW"] = "",
    settings: InferenceSettings | None = None,
) -> Estimate:
    """What ``generate`` would send first and cost at most, or ``edit`` where ``path`` names a program; nothing is sent.

    Raises
    ------
    UsageError
        An argument makes no sense, or the price of the model is not known.

    Examples
    --------
    >>> estimate("a chess board", model="claude-opus-5-5").cost < 10
    True
    """
    chosen = _settings(settings, model)
    if path is not None:
        return first_estimate(_edit_of(Path(path), task, chosen, ablation, 0, None))
    asked = task_of(task, images, TaskKind(kind), Notation(notation), Ablation(ablation))
    return first_estimate(Inference(asked, chosen, Options()))


def resume(
    name: str = "last",
    *,
    settings: Mapping[str, Any] | None = None,
    runs: str | None = None,
    live: TextIO | None = None,
) -> Generated | Edited:
    """Go on with a run of ``generate`` or ``edit`` that was interrupted or failed; what it was told is not asked again.

    Parameters
    ----------
    name : str
        The run's name, the beginning of one, its folder, or "last".
    settings : mapping, optional
        New values of limits, such as ``{"max_cost": 10.0}``; what decides the answers cannot change.
    runs : str, optional
        The folder that keeps runs; the user's state folder by default.
    live : text stream, optional
        Where answers are counted as they arrive.

    Raises
    ------
    UsageError
        There is no such run, or a setting cannot change.
    SceneError
        As ``generate``.
    """
    command = find_run(runs_folder(runs), name).facts.get("command")
    inference, run = resumed(name, str(command), runs)
    inference = renewed(inference, settings or {})
    with recorded(run):
        if command == "edit":
            return edited(inference, run, Path(str(run.facts["file"])), live)
        return generated(run, play(inference, run, live), inference.options)


def runs(folder: str | None = None) -> list[Run]:
    """The runs of ``generate`` and ``edit`` in a folder (the user's state folder by default), oldest first."""
    return all_runs(runs_folder(folder))


def renewed(inference: Inference, settings: Mapping[str, Any], as_flags: bool = False) -> Inference:
    """With new limits for a run that goes on. Raises UsageError for settings that cannot change."""
    fixed = [name for name in settings if name not in RENEWABLE]
    if fixed:
        hint = f"these can: {', '.join(sorted(RENEWABLE))}"
        raise UsageError("value", f"`{fixed[0]}` cannot change when a run goes on", hint)
    check_limits(settings, as_flags)
    return replace(inference, settings=replace(inference.settings, **settings))


def _settings(settings: InferenceSettings | None, model: str | None) -> InferenceSettings:
    found = settings or InferenceSettings()
    check_limits(asdict(found))
    return found if model is None else replace(found, model=model)


def _edit_of(
    path: Path, instruction: str, settings: InferenceSettings, ablation: str, seed: int, limits: Limits | None
) -> Inference:
    """The edit to ask for. Raises SceneError for a program that is wrong already."""
    if not instruction.strip():
        raise UsageError("value", "say which program is to be edited, and how")
    options = Options(seed=seed, limits=limits or Limits())
    result, inference = editing(path, instruction, settings, options, Ablation(ablation))
    result.require()
    assert inference is not None
    return inference
