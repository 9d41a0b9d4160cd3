"""Runs that generate or edit scenes with a language model, and their results."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, TextIO

from scenelang.backends.base import Progress
from scenelang.backends.files import read_regular, rewrite, write_text
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, UsageError, to_json, usage_errors
from scenelang.grammar.settings import typed
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
from scenelang.interpreter.checker.program import Program
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene.entity import Scene as SceneGraph
from scenelang.interpreter.transpile.analysis.python_text import code_of, find_code
from scenelang.interpreter.values.limits import Limits
from scenelang.session.loaded import AnyScene, LoadedScene
from scenelang.session.scene_changes import Changes, changes_between, compared_frames, paired_by_path
from scenelang.session.session import Evaluated, Options, Session, is_python, is_scene_file

if TYPE_CHECKING:
    from scenelang.backends.language_models.catalogue import Usage
    from scenelang.backends.pictures.images import Image

_MAX_TASK_LENGTH = 100_000  # characters of a task
_MAX_IMAGES = 20  # of a task
_DESCRIPTION_TOKENS = 8_000  # of an answer that describes primitives
_IMAGE_PX = 512  # of images that are sent to the model
_DRAFT_PX = 768  # of the draft next to a program


# --- tasks -----------------------------------------------------------------------------------------------------------


def task_of(
    text: str,
    images: Sequence[str | Path] = (),
    kind: TaskKind = TaskKind.STILL,
    notation: Notation = Notation.PYTHON,
    ablation: Ablation = Ablation.NONE,
    seed: int = 0,
) -> Task:
    """Create the task of generating a scene. Raises UsageError, and SceneError for an unreadable image."""
    text = text.strip()
    if not text and not images:
        raise UsageError("value", "expected a text prompt, or an image with --image", 'such as `"a wooden chair"`')
    if len(text) > _MAX_TASK_LENGTH or len(images) > _MAX_IMAGES:
        raise UsageError("value", f"the task exceeds {_MAX_TASK_LENGTH:,} characters or {_MAX_IMAGES} images")
    if ablation.takes_program:
        if notation is Notation.LANGUAGE:
            raise UsageError("value", "--dsl cannot be combined with --ablate P")
        notation = Notation.LIST
    return Task(text, kind, notation, ablation, tuple(read_picture(str(path)) for path in images), None, seed)


def edit_task(source: Source, scene: SceneGraph, instruction: str, ablation: Ablation, seed: int) -> Task:
    """Create the task of editing the program ``source`` of ``scene``.

    Raises SceneError if the source is not a program, or the scene is too large for a list.
    """
    if is_scene_file(source):
        hint = "edit its source program instead, possibly with --ablate P"
        raise SceneError("unsupported", f"{source.name} is a flattened scene, not a program", hint)
    if ablation.takes_program:
        program, notation = listing(scene, not ablation.takes_words), Notation.LIST
    elif is_python(source):
        program, notation = code_of(source.text), Notation.PYTHON
    else:
        program, notation = source.text, Notation.LANGUAGE
    return Task(instruction, kind_of(scene), notation, ablation, (), program, seed)


def kind_of(scene: SceneGraph) -> TaskKind:
    """Return the kind of a scene."""
    if scene.animated:
        return TaskKind.FILM
    return TaskKind.BLOCKS if has_blocks(scene) else TaskKind.STILL


def imported_files(program: Program | None) -> frozenset[Path]:
    """Return the files that a program imports; an edited program may import only these."""
    sources = program.sources if program is not None else ()
    return frozenset(Path(source.name).resolve() for source in sources if not source.name.startswith((STD, "<")))


@dataclass(frozen=True, slots=True)
class Estimate:
    """The first request of a run, without sending it.

    ``tokens`` and ``cost`` (US dollars) are upper bounds before repairs and critiques; ``grammar`` constrains the
    answers if the server supports it.
    """

    address: str
    payload: Mapping[str, Any] = field(repr=False)
    grammar: str | None = field(repr=False)
    tokens: int
    cost: float

    def __str__(self) -> str:
        """Format the request and its maximum cost."""
        grammar = (
            f"\ngrammar: {len(self.grammar):,} characters, if supported by the server\n"
            if self.grammar is not None
            else ""
        )
        most = f"at most {self.tokens:,} tokens and ${self.cost:.4f} before repairs and critiques"
        return f"{payload_text(self.payload)}\n{grammar}\nto {self.address}: {most}"

    def data(self) -> dict[str, Any]:
        """The estimate as JSON data."""
        return {"address": self.address, "request": self.payload, "tokens": self.tokens, "cost": self.cost}


def first_estimate(inference: Inference) -> Estimate:
    """Return the first request of a run and its maximum cost, without key or network. Raises UsageError."""
    from scenelang.backends.language_models.openai_chat import estimate_tokens
    from scenelang.backends.language_models.provider import offline_provider

    settings = inference.settings
    with usage_errors():
        provider = offline_provider(settings.provider)
        model = settings.known_model(provider)
        speaker = settings.speaker(model, inference.task.notation)
    request = inference.first_request(speaker)
    tokens = estimate_tokens(request)
    cost = settings.samples * model.max_cost(tokens, request.max_tokens, settings.is_batch)
    payload = provider.payload(replace(request, grammar=None))
    return Estimate(provider.address, payload, request.grammar, tokens, cost)


def describer(settings: InferenceSettings, live: TextIO | None = None) -> Describer:
    """Connect a describer of primitives to the model. Raises SceneError."""
    from scenelang.inference.brief import Prompts

    settings = replace(settings, max_tokens=settings.max_tokens or _DESCRIPTION_TOKENS)
    client = settings.client()
    speaker = settings.speaker(client.model, Notation.PYTHON)
    return Describer(client, Prompts(settings.prompts_folder), speaker, LiveCount(live))


# --- runs ------------------------------------------------------------------------------------------------------------


def begin(inference: Inference, command: str, name: str, runs: str | None = None, **facts: Any) -> Run:
    """Create a run. Raises UsageError for settings that the model or the provider does not support."""
    client = inference.settings.client()
    with usage_errors():
        inference.settings.speaker(client.model, inference.task.notation)
        if inference.settings.is_batch:
            client.batches()
    run = new_run(runs_folder(runs), name, client.redact)
    inference.begin(run, command, **facts)
    return run


def resumed(name: str, command: str, runs: str | None = None) -> tuple[Inference, Run]:
    """Load the run to resume by name, "last" or folder. Raises UsageError if another command created it."""
    folder = runs_folder(runs)
    run = find_run(folder, name)
    if run.path.resolve().parent != folder.resolve():
        hint = f"if you trust it, add --runs {run.path.parent}"
        raise UsageError(
            "run", f"{run.path} is outside the folder of runs; resuming it may overwrite files and cost money", hint
        )
    made_by = run.facts.get("command")
    if made_by == "repl":
        hint = f"its result is in {run.path / 'best.scene'}"
        raise UsageError("run", f"the run {run.name} was created in the REPL and cannot be resumed", hint)
    if made_by != command:
        hint = f"scenelang {made_by} --resume {run.name}"
        raise UsageError("run", f"the run {run.name} was created by `{made_by}`", hint)
    return inference_of(run), run


@contextmanager
def recorded(run: Run) -> Iterator[None]:
    """Lock a run, and record its final state."""
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
    """Run or resume inference to its end; recorded answers are reused. Raises SceneError."""
    client = inference.settings.client(run.spent)
    run = Run(run.path, client.redact)
    run.note(settings=inference.settings.data())
    result = inference.run(run, client, live)
    run.keep_text("best.scene", result.best.program)
    run.note(state="done", sample=result.sample, cost=result.spent)
    return result


# --- results ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Generated(Generic[AnyScene]):
    """A scene generated by a language model.

    ``program`` is the source text, ``scene`` its evaluation, ``warnings`` the diagnostics of both, ``sample`` the
    number of the best sample, ``stopped`` the errors of samples that ended early, ``cost`` in US dollars, ``run`` the
    folder with all requests and answers.
    """

    program: str = field(repr=False)
    scene: AnyScene
    warnings: tuple[Diagnostic, ...] = field(repr=False)
    sample: int
    usage: Usage = field(repr=False)
    cost: float
    run: Path
    stopped: tuple[SceneError, ...] = field(default=(), repr=False)

    @typed
    def save(self, path: str | Path) -> Path:
        """Write the program; returns the path."""
        return _write(Path(path), self.program)

    def __str__(self) -> str:
        """Return sample, tokens, cost and run folder as one line."""
        sent, answered = f"{self.usage.prompt:,} input tokens", f"{self.usage.answered:,} output tokens"
        return f"sample {self.sample}; {sent}, {answered}, ${self.cost:.4f}; saved in {self.run}"

    def data(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        return {
            "run": str(self.run),
            "sample": self.sample,
            "program": self.program,
            "diagnostics": [to_json(d) for d in self.warnings],
            "stopped": [error.message for error in self.stopped],
            "tokens": {"sent": self.usage.prompt, "answered": self.usage.answered},
            "cost": self.cost,
        }


def draw_draft(scene: LoadedScene, program: Path, progress: Progress | None = None) -> Path:
    """Render a scene next to its program, to a PNG, or to a GIF if it is animated. Returns the path."""
    from scenelang.backends.pictures.images import image_of, picture_options, video_of

    size = _DRAFT_PX
    if scene.animated:
        video = video_of(scene, picture_options(size=(size // 2, size // 2)))
        return video.save(program.with_suffix(".gif"), progress=progress)
    options = picture_options(size=(size, size), progress=progress)
    return image_of(scene.graph, options).save(program.with_suffix(".png"))


@dataclass(frozen=True, slots=True)
class SceneEdit:
    """Effect of an edit: ``text`` is the unified diff of both programs, ``changes`` the changes of the scene."""

    text: str
    changes: Changes


@dataclass(frozen=True, slots=True)
class Edited(Generic[AnyScene]):
    """Program edited by a language model.

    ``diff`` and ``changes`` describe the edit, ``before`` is the original scene, ``result`` the edited one. No file is
    overwritten before ``save`` or ``apply``.
    """

    path: Path
    diff: str = field(repr=False)
    changes: Changes
    before: AnyScene = field(repr=False)
    result: Generated[AnyScene]
    task: Task = field(repr=False)
    verdict: Verdict = field(repr=False)
    digest: str | None = field(repr=False)

    @property
    def scene(self) -> AnyScene:
        """The edited scene."""
        return self.result.scene

    def picture(self) -> Image:
        """Render both scenes side by side from one camera. Raises SceneError if a scene cannot be rendered."""
        return before_and_after(self.before.graph, self.result.scene.graph)

    @typed
    def save(self, path: str | Path) -> Path:
        """Write the edited program, in the notation given by the extension of ``path``; returns the path."""
        return _write(Path(path), written_as(Path(path), self.task, self.verdict))

    def apply(self) -> Path:
        """Overwrite the original file; raises SceneError if it changed in the meantime."""
        if digest_of(self.path) != self.digest:
            hint = "write the edit to another file with -o"
            raise SceneError("file", f"{self.path} was modified since its program was sent", hint)
        return self.save(self.path)

    def data(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        return self.result.data() | {"diff": self.diff, "changes": self.changes.data()}


def digest_of(path: Path) -> str:
    """Return a hash of a file, to detect changes."""
    return sha256(read_regular(path)).hexdigest()


def _write(target: Path, text: str) -> Path:
    """Write a program to a new or existing file, and return it."""
    if target.exists():
        rewrite(target, text)
        return target
    write_text(target, text)
    return target


def generated(run: Run, result: Result, options: Options, kind: type[AnyScene]) -> Generated[AnyScene]:
    """Return the result of a run, with a scene of the class ``kind``."""
    best = result.best
    assert best.scene is not None
    scene = kind(best.scene, "answer.scene", (), best.diagnostics, None, options)
    warnings = (*best.diagnostics, *best.findings)
    return Generated(best.program, scene, warnings, result.sample, result.usage, result.spent, run.path, result.stopped)


def edited(
    inference: Inference, run: Run, path: Path, kind: type[AnyScene], live: TextIO | None = None
) -> Edited[AnyScene]:
    """Run the edit to its end, and compute its effect, with scenes of the class ``kind``. Raises SceneError."""
    result = play(inference, run, live)
    before = scene_before(path, inference.task, inference.options)
    effect = edit_of(path.name, inference.task, before, result.best, inference.options.limits.primitives)
    run.keep_text("edit.diff", effect.text + "\n")
    new = generated(run, without_known(result, before), inference.options, kind)
    saved_digest = run.facts.get("digest")
    scene = kind(before, str(path), options=inference.options)
    digest = str(saved_digest) if saved_digest is not None else None
    return Edited(path, effect.text, effect.changes, scene, new, inference.task, result.best, digest)


def scene_before(path: Path, task: Task, options: Options) -> SceneGraph:
    """Return the scene of the program to edit, as it was sent. Raises SceneError if it no longer evaluates."""
    assert task.program is not None
    if task.notation is Notation.LIST:
        source = Source(str(path), program_of(task.program, task.text))
    else:
        source = Source(str(path.with_suffix(".py") if task.notation is Notation.PYTHON else path), task.program)
    scene = Session(options).evaluate(source).scene
    if scene is None:
        raise SceneError(
            "run", f"the original program of {path} no longer evaluates, so the edit cannot be compared with it"
        )
    return scene


def edit_of(name: str, task: Task, before: SceneGraph, after: Verdict, limit: int) -> SceneEdit:
    """Compute the effect of an edit. Raises SceneError for scenes of more than ``limit`` primitives."""
    assert after.scene is not None
    assert task.program is not None
    written = listing(after.scene, task.ablation is Ablation.P) if task.notation is Notation.LIST else after.code
    lines = difflib.unified_diff(
        task.program.splitlines(), written.splitlines(), f"{name} before", f"{name} after", lineterm=""
    )
    changes = changes_between(compared_frames(before, limit), compared_frames(after.scene, limit))
    return SceneEdit("\n".join(lines), paired_by_path(changes))


def without_known(result: Result, before: SceneGraph) -> Result:
    """Remove geometry warnings from a result that already applied before the edit."""
    known = {finding.message for finding in geometry_findings(before)}
    findings = tuple(finding for finding in result.best.findings if finding.message not in known)
    return replace(result, best=replace(result.best, findings=findings))


def written_as(path: Path, task: Task, after: Verdict) -> str:
    """Return the edited program for the file ``path``: in the notation of the edit if the extension matches."""
    if task.notation is Notation.LANGUAGE:
        return after.code
    if task.notation is Notation.PYTHON and path.suffix == ".py":
        return after.code
    if task.notation is Notation.PYTHON and path.suffix == ".txt":
        return _in_response(path, after.code)
    return after.program


def _in_response(path: Path, code: str) -> str:
    """Replace the code in the response that a file contains; a new file contains only the code."""
    text = path.read_text("utf-8") if path.exists() else ""
    code_span = find_code(text)
    if not text[: code_span.start].strip():
        return f"```python\n{code}```\n"
    return text[: code_span.start] + code + text[code_span.end :]


def before_and_after(before: SceneGraph, after: SceneGraph) -> Image:
    """Render both scenes side by side from one camera, which frames the larger one.

    Raises SceneError if a scene cannot be rendered.
    """
    from scenelang.backends.pictures.camera import Viewpoint
    from scenelang.backends.pictures.images import image_of, picture_options
    from scenelang.backends.pictures.stage import stills

    larger = max((before, after), key=_largest_side)
    camera = stills(larger, Viewpoint(), range(len(larger.frames)), _IMAGE_PX, _IMAGE_PX)[0].camera
    middle = min(len(before.frames), len(after.frames)) // 2
    first, second = (
        image_of(scene, picture_options(camera, frame=middle if scene.animated else None)) for scene in (before, after)
    )
    return first.beside(second)


def _largest_side(scene: SceneGraph) -> float:
    """Return the longest side of a scene's box."""
    from scenelang.backends.pictures.stage import box_of

    low, high = box_of(scene)
    return float((high - low).max())


# --- public functions ------------------------------------------------------------------------------------------------


def editing(
    path: Path, instruction: str, settings: InferenceSettings, options: Options, ablation: Ablation = Ablation.NONE
) -> tuple[Evaluated, Inference | None]:
    """Evaluate a program and prepare its edit; the inference is None if the program has errors."""
    options = replace(options, project=path.resolve().parent)
    session = Session(options)
    source = session.source(str(path))
    result = session.evaluate(source)
    if result.scene is None:
        return result, None
    task = edit_task(source, result.scene, instruction.strip(), ablation, options.seed)
    options = replace(options, imports=imported_files(result.program))
    return result, Inference(task, settings, options, str(path))


@typed
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
    """Return the first request of ``generate``, or of ``edit`` with ``path``, and its maximum cost; nothing is sent.

    Raises
    ------
    UsageError
        If an argument is invalid, or the price of the model is unknown.

    Examples
    --------
    >>> estimate("a chess board", model="claude-opus-5-5").cost < 10
    True
    """
    chosen = settings_with(settings, model)
    if path is not None:
        return first_estimate(prepared_edit(Path(path), task, chosen, ablation, 0, None))
    request = task_of(task, images, TaskKind(kind), Notation(notation), Ablation(ablation))
    return first_estimate(Inference(request, chosen, Options()))


@typed
def runs(folder: str | None = None) -> list[Run]:
    """Return the runs of ``generate`` and ``edit`` in a folder (default: in the user's state folder), oldest first."""
    return all_runs(runs_folder(folder))


def renewed(inference: Inference, settings: Mapping[str, Any], as_flags: bool = False) -> Inference:
    """Apply new limits to a resumed run. Raises UsageError for settings that cannot change."""
    fixed = [name for name in settings if name not in RENEWABLE]
    if fixed:
        hint = f"settings that can change: {', '.join(sorted(RENEWABLE))}"
        raise UsageError("value", f"`{fixed[0]}` cannot be changed for a resumed run", hint)
    check_limits(settings, as_flags)
    return replace(inference, settings=replace(inference.settings, **settings))


def settings_with(settings: InferenceSettings | None, model: str | None) -> InferenceSettings:
    """Return the settings, or the defaults, with the model if one is given. Raises UsageError for invalid limits."""
    chosen = settings or InferenceSettings()
    check_limits(asdict(chosen))
    return chosen if model is None else replace(chosen, model=model)


def prepared_edit(
    path: Path, instruction: str, settings: InferenceSettings, ablation: str, seed: int, limits: Limits | None
) -> Inference:
    """Prepare the edit of a program. Raises SceneError if the program has errors."""
    if not instruction.strip():
        raise UsageError("value", "expected a program and an instruction")
    options = Options(seed=seed, limits=limits or Limits())
    result, inference = editing(path, instruction, settings, options, Ablation(ablation))
    result.require()
    assert inference is not None
    return inference
