"""Functions of the Python API: load, check and evaluate programs, and work with scenes (docs/python.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TextIO

from scenelang.grammar.datum import Source, replace
from scenelang.grammar.diagnostics import Diagnostic, SceneError, error_of, explained, require_diagnostic
from scenelang.grammar.reader import ReadResult, read
from scenelang.grammar.settings import typed
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.interpreter.values.limits import Limits
from scenelang.scene import Scene
from scenelang.session.loaded import literal, scene_of
from scenelang.session.session import Checked, Options, Session, TranslatedProgram

if TYPE_CHECKING:
    from scenelang.backends.base import Backend
    from scenelang.doctor.doctor import Check
    from scenelang.inference.conductor import Inference
    from scenelang.inference.generation import Edited, Generated
    from scenelang.inference.records import InferenceSettings
    from scenelang.reference.searching import SearchResult
    from scenelang.repairs.instance_edits import EditedText
    from scenelang.repairs.repairing import Repair
    from scenelang.session.scene_changes import Changes


@typed
def parse(text: str, name: str = "<text>") -> ReadResult:
    """Parse text into datums with spans; errors are collected in ``.diagnostics`` and never raised.

    Examples
    --------
    >>> len(parse('(call "cube")').forms)
    1
    """
    return read(Source(name, text))


@typed
def check(text: str, name: str = "<text>", options: Options | None = None) -> Checked:
    """Check a program without running it; errors are returned as diagnostics and never raised.

    Examples
    --------
    >>> check('(bind "a" (lambda () (call "cube")))').ok
    True
    """
    return Session(options).check(Source(name, text))


@typed
def load(
    path: str | Path,
    *,
    seed: int = 0,
    defines: Mapping[str, Any] | None = None,
    root: str | None = None,
    embeddings: str | Path | Literal["auto"] | None = "auto",
    limits: Limits | None = None,
    project: str | Path | None = None,
    allow_outside: bool = False,
    strict: bool = False,
) -> Scene:
    """Load a scene from a program file, a language model's Python, or JSON written by ``export``.

    Parameters
    ----------
    path : path
        ``.scene``, ``.py``, ``.ipynb`` or ``.txt`` (a model response; its Python is translated, never executed),
        ``.json``.
    seed : int
        Random seed.
    defines : mapping, optional
        Values that override the program's params: numbers, booleans, strings or sequences of numbers.
    root : str, optional
        Word to evaluate; see docs/language.md for the default.
    embeddings : path, optional
        Embeddings file; "auto" uses the one beside the program if it exists, None disables embeddings.
    limits : Limits, optional
        Limits of time, memory and size, enforced within this process only (docs/security.md).
    project : path, optional
        Folder to which imports and assets are restricted; default: the program's folder.
    allow_outside : bool
        Allow imports and assets from outside the project folder.
    strict : bool
        Require the paper's grammar.

    Raises
    ------
    SceneError
        If the file cannot be read or the program has errors; the text shows code, position, source line and hint.

    Examples
    --------
    >>> import scenelang as sl
    >>> sl.load("examples/menger-sponge.scene", defines={"level": 1}).count()["cube"]
    20
    """
    entries = _entries(Path(path), embeddings)
    plain = Options(root=root, seed=int(seed), allow_outside=allow_outside, strict=strict, z_entries=entries)
    options = _with_given(plain, defines, limits, project)
    return scene_of(Scene, Session(options).source(str(path)), options)


@typed
def evaluate(
    text: str,
    name: str = "<text>",
    *,
    seed: int = 0,
    defines: Mapping[str, Any] | None = None,
    root: str | None = None,
    limits: Limits | None = None,
    project: str | Path | None = None,
    allow_outside: bool = False,
    strict: bool = False,
) -> Scene:
    """Evaluate the source text of a program.

    The arguments are those of ``load``; ``name`` is the file name shown in diagnostics.

    Examples
    --------
    >>> evaluate('(bind "dot" (lambda () (call "sphere" :radius 2)))')
    <Scene "dot": 1 primitive>
    """
    plain = Options(root=root, seed=int(seed), allow_outside=allow_outside, strict=strict)
    options = _with_given(plain, defines, limits, project)
    return scene_of(Scene, Source(name, text), options)


@typed
def transpile(text: str, name: str = "<response>.py", *, literal: bool = False) -> TranslatedProgram:
    """Translate a language model's response, or its Python, to a program of the language; Python is never executed.

    ``.text`` is the program, empty if ``.ok`` is false; ``.diagnostics`` contains the errors. The program is lifted
    (see `simplify`), unless ``literal`` is true.

    Examples
    --------
    >>> response = 'def dot():\\n    return primitive_call("sphere", shape_kwargs={"radius": 2})'
    >>> transpile("from helper import *\\n@register()\\n" + response).ok
    True
    """
    return Session().transpile(Source(name, text), literal)


@typed
def simplify(text: str, name: str = "<program>.scene") -> str:
    """Rewrite a program as a person would write it: rings, grids, tables of similar parts, params, composed poses.

    Parameters
    ----------
    text
        Program of the language; imports are found relative to the working directory.
    name
        Name of the program in messages.

    Returns
    -------
    str
        Text of a program with the same primitives in the same order, the same words, hierarchy, handles, attributes,
        random draws and frames; poses may differ by rounding. It is never longer.

    Raises
    ------
    SceneError
        If the program has errors.

    Examples
    --------
    >>> program = '(bind "s" (lambda () (define dot (call "sphere")) (union dot)))'
    >>> print(simplify(program).strip())
    (bind "s"
      (lambda ()
        (union (call "sphere"))))  ; dot
    """
    lifted, diagnostics = Session().lift(Source(name, text))
    if lifted is None:
        raise error_of(next(d for d in diagnostics if d.is_error))
    return lifted


@typed
def format(text: str, lines: tuple[int, int] | None = None) -> str:
    """Format a program in the uniform style of the language; only white space changes.

    ``lines`` are the first and the last line, from 1, of a range whose forms alone are formatted.

    Raises
    ------
    SceneError
        If the text cannot be parsed.

    Examples
    --------
    >>> format('(union   (call "cube") )')
    '(union (call "cube"))\\n'
    """
    from scenelang.grammar.formatter import format_range, format_text
    from scenelang.interpreter.expand.forms import INDENTS

    return format_text(text, INDENTS) if lines is None else format_range(text, *lines, INDENTS)


@typed
def repair(text: str, *declarations: str, name: str = "<text>", geometry: bool = True, effort: float = 30.0) -> Repair:
    """Edit a program so that findings of the geometry lint and failed declarations are resolved, without a model.

    Parameters
    ----------
    text : str
        Program in the Scene Language.
    declarations : str
        Declarations about the scene besides those of the program, such as ``(on "cup" "table")``.
    name : str
        File name for diagnostics.
    geometry : bool
        Whether to resolve the findings of the lint too, and not only declarations.
    effort : float
        How much is searched, about a second for each unit; the result does not depend on the machine.

    Returns
    -------
    Repair
        The repaired text, its edits, what remains, and how far objects moved on average, in scene units.

    Raises
    ------
    SceneError
        If the program is wrong, or a declaration cannot be tested.

    Examples
    --------
    >>> box = '(bind "box" (lambda () (call "cube")))'
    >>> pile = '(bind "pile" (lambda () (union (call "box") (transform (call "cube") (translate [0 1.5 0])))))'
    >>> repair(box + pile + '(scene "pile")', '(count "box" 1)', '(on "cube" "box" :any)').edits[0].new
    '1'
    """
    from scenelang.repairs.repairing import repaired
    from scenelang.session.declarations import declarations_of

    session = Session()
    stated = [declaration for stated_text in declarations for declaration in declarations_of(session, stated_text)]
    return repaired(session, Source(name, text), stated, effort=effort, geometry=geometry)


@typed
def edit_instance(
    text: str,
    path: str,
    *,
    move: Sequence[float] | None = None,
    attribute: tuple[str, str] | None = None,
    form: str | None = None,
    remove: bool = False,
    shared: bool = False,
    name: str = "<text>",
) -> EditedText:
    """Edit a program so that only the instances of a path change, which evaluation proves.

    One instance of a loop, or of a function that is called several times, gets an exception.

    Parameters
    ----------
    text : str
        Program in the Scene Language.
    path : str
        The instances, as for ``Scene.instances``.
    move : (x, y, z), optional
        Translation along the axes of the scene.
    attribute : (name, value), optional
        Attribute to set, and the text of its value.
    form : str, optional
        Text of a form that takes the place of the one that makes the instances.
    remove : bool
        Remove the instances. Give exactly one of these four.
    shared : bool
        Edit the number or form that others share, so that these change, too.
    name : str
        File name for diagnostics.

    Returns
    -------
    EditedText
        The text after the edit, the line of the form, the form before and after, and the number of instances.

    Raises
    ------
    SceneError
        If the program is wrong, the path matches no instance, or no form makes these instances only; with ``shared``,
        if no others share the numbers and forms.

    Examples
    --------
    >>> pair = '(bind "pair" (lambda () (union (call "cube") (transform (call "cone") (translate [2 0 0])))))'
    >>> edit_instance(pair, "cone", move=(0, 1, 0)).new
    '(transform (call "cone") (translate [2 1 0]))'
    """
    from scenelang.repairs.instance_edits import InstanceEdit, edited

    offset = None if move is None else tuple(map(float, move))
    if offset is not None and len(offset) != 3:
        raise SceneError("value", f"`move`: expected three numbers, got {len(offset)}")
    return edited(Session(), Source(name, text), InstanceEdit(path, offset, attribute, form, remove, shared=shared))


@typed
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
) -> Generated[Scene]:
    """Generate a scene from text and images with a language model.

    The model's program is checked and evaluated, errors are sent back for repair, and the best of several samples is
    selected. Python written by the model is translated, never executed.

    Parameters
    ----------
    task : str
        Description of the scene; may be empty if there are images.
    model : str, optional
        Name of the model; default: that of ``settings``, else the provider's default.
    images : sequence of path
        Input images to reconstruct.
    kind : str
        "3d", "4d" (an animated scene) or "minecraft" (a build of blocks).
    notation : str
        Notation of the model's output: "python" with the helper API, or "language" for the Scene Language.
    ablation : str
        Ablation of the paper: without programs "P", words "W" or both "PW".
    settings : InferenceSettings, optional
        Provider, model, samples, repairs, critiques and cost limit (default 5 US dollars).
    seed : int
        Random seed of the program.
    limits : Limits, optional
        Limits of each evaluation.
    runs : str, optional
        Folder of runs; default: in the user's state folder.
    live : text stream, optional
        Stream for live token counts. Ctrl-C ends the run; resume it with `scenelang generate --resume`.

    Raises
    ------
    UsageError
        If an argument is invalid.
    SceneError
        If the model cannot be reached, or no sample produced a valid program.

    Examples
    --------
    Requires an API key and a network connection::

        made = sl.generate("a chess board", model="claude-opus-5-5", settings=sl.InferenceSettings(samples=3))
        made.scene.render().save("board.png")
    """
    from scenelang.inference.brief import Ablation, Notation, TaskKind
    from scenelang.inference.conductor import Inference
    from scenelang.inference.generation import settings_with, task_of

    request = task_of(task, images, TaskKind(kind), Notation(notation), Ablation(ablation), seed)
    options = Options(seed=seed, limits=limits or Limits())
    return _played(Inference(request, settings_with(settings, model), options), "generate", task, runs, live)


def _played(inference: Inference, command: str, task: str, runs: str | None, live: TextIO | None) -> Generated[Scene]:
    """Begin the run of a command and play it to its end."""
    from scenelang.inference.generation import begin, generated, play, recorded

    run = begin(inference, command, task or "reconstruction", runs, output=None, render=False, invert=False)
    with recorded(run):
        return generated(run, play(inference, run, live), inference.options, Scene)


@typed
def primer(
    task: str = "",
    *,
    kind: Literal["3d", "4d", "minecraft"] = "3d",
    notation: Literal["python", "language"] = "language",
    sections: Sequence[str] = (),
) -> str:
    """Return what a language model must know to write a scene: the system prompt of ``generate``, and sections.

    For a task, objects of the library that fit it and examples of programs follow, as in the prompts of ``generate``.

    It is for those who bring their own model. An answer is read by ``evaluate``, which takes responses too.

    Parameters
    ----------
    task : str
        Description of the scene, whose words add the sections that they ask for: "a bent pipe" that about solids.
    kind : str
        "3d", "4d" or "minecraft".
    notation : str
        "language" for the Scene Language, or "python" for Python with the helper API.
    sections : sequence of str
        Further sections by name: "films", "solids", "relations" or "blocks".

    Returns
    -------
    str
        Some 12,000 characters of Markdown, and 4,000 for a task; a section has at most 1,500.

    Raises
    ------
    SceneError
        For an unknown section.

    Examples
    --------
    >>> "(assert-that" in primer()
    True
    >>> "(sweep profile path" in primer("a bent pipe"), "(sweep profile path" in primer()
    (True, False)
    """
    from scenelang.inference.brief import Brief, Notation, Prompts, Task, TaskKind

    return Brief(Task(task, TaskKind(kind), Notation(notation)), Prompts()).teaching(sections)


@typed
def build(
    task: str = "",
    *,
    model: str | None = None,
    images: Sequence[str | Path] = (),
    kind: Literal["3d", "4d", "minecraft"] = "3d",
    notation: Literal["python", "language"] = "python",
    settings: InferenceSettings | None = None,
    seed: int = 0,
    limits: Limits | None = None,
    runs: str | None = None,
    live: TextIO | None = None,
) -> Generated[Scene]:
    """Build a scene step by step with a language model.

    The model plans the parts and states what must hold, writes part by part and then the whole; a critic, who sees only
    the task, facts and images, says what is wrong, and the model revises. A revision after which a statement fails that
    held, or the geometry warns of more, is rolled back. The program states its acceptance at its end.

    Parameters
    ----------
    task, model, images, kind, notation, seed, limits, runs, live
        As for ``generate``.
    settings : InferenceSettings, optional
        As for ``generate``, with ``revisions`` (default 6), ``max_cost``, ``max_run_tokens`` and ``max_run_seconds``.

    Returns
    -------
    Generated
        The scene; its folder ``run`` has every request and answer, ``acceptance.scene`` and ``steps.txt``.

    Raises
    ------
    UsageError
        If an argument is invalid.
    SceneError
        If the model cannot be reached, or the best scene does not fulfill its acceptance.

    Examples
    --------
    Requires an API key and a network connection::

        made = sl.build("a kitchen for two", settings=sl.InferenceSettings(max_cost=2.0))
        print((made.run / "steps.txt").read_text())
    """
    from scenelang.grammar.datum import replace
    from scenelang.inference.brief import Notation, TaskKind
    from scenelang.inference.conductor import Inference
    from scenelang.inference.generation import settings_with, task_of
    from scenelang.inference.records import REVISIONS

    chosen = settings_with(settings, model)
    if chosen.revisions is None:
        chosen = replace(chosen, revisions=REVISIONS)
    request = task_of(task, images, TaskKind(kind), Notation(notation), seed=seed)
    options = Options(seed=seed, limits=limits or Limits())
    return _played(Inference(request, chosen, options), "build", task, runs, live)


@typed
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
) -> Edited[Scene]:
    """Edit a program by an instruction with a language model. Nothing is overwritten before ``Edited.save`` or
    ``apply``; the other arguments are those of ``generate``.

    Parameters
    ----------
    path : path
        Program to edit: .scene, or a model's response (.txt, .py).
    instruction : str
        Edit instruction, such as "make the tower twice as high".

    Raises
    ------
    SceneError
        If the program has errors, the model cannot be reached, or no sample produced a valid program.
    """
    from scenelang.inference.generation import begin, digest_of, edited, prepared_edit, recorded, settings_with

    file = Path(path)
    inference = prepared_edit(file, instruction, settings_with(settings, model), ablation, seed, limits)
    facts = {"file": str(file.resolve()), "digest": digest_of(file)}
    run = begin(inference, "edit", f"{file.stem} {instruction}", runs, **facts)
    with recorded(run):
        return edited(inference, run, file, Scene, live)


@typed
def resume(
    name: str = "last",
    *,
    settings: Mapping[str, Any] | None = None,
    runs: str | None = None,
    live: TextIO | None = None,
) -> Generated[Scene] | Edited[Scene]:
    """Resume an interrupted or failed run of ``generate`` or ``edit``; recorded answers are reused.

    Parameters
    ----------
    name : str
        Name, prefix of a name or folder of the run, or "last".
    settings : mapping, optional
        New limits, such as ``{"max_cost": 10.0}``; other settings are fixed.
    runs : str, optional
        Folder of runs; default: in the user's state folder.
    live : text stream, optional
        Stream for live token counts.

    Raises
    ------
    UsageError
        If the run does not exist, or a setting cannot change.
    SceneError
        As ``generate``.
    """
    from scenelang.inference.generation import edited, generated, play, recorded, renewed, resumed
    from scenelang.inference.records import find_run, runs_folder

    command = find_run(runs_folder(runs), name).facts.get("command")
    inference, run = resumed(name, str(command), runs)
    inference = renewed(inference, settings or {})
    with recorded(run):
        if command == "edit":
            return edited(inference, run, Path(str(run.facts["file"])), Scene, live)
        return generated(run, play(inference, run, live), inference.options, Scene)


@typed
def search(query: str, limit: int = 8) -> list[SearchResult]:
    """Search forms, functions, primitives, attributes, relations, diagnostics and examples by meaning, best first.

    Examples
    --------
    >>> [found.name for found in search("repeat along a curve", 1)]
    ['along']
    """
    from scenelang.reference.searching import search as found

    return found(query, limit)


@typed
def diff(a: Scene, b: Scene, tolerance: float = 1e-5, limit: int = 2_000_000) -> Changes:
    """Compare two scenes and return the list of changes.

    Parameters
    ----------
    a, b : Scene
        Scenes to compare by the world-space appearance of their primitives, not by the text of their programs.
    tolerance : float
        Distances and attributes that differ by at most this value are considered equal.
    limit : int
        Maximum number of primitives to expand.

    Examples
    --------
    >>> red = evaluate('(bind "a" (lambda () (call "cube" :color [1 0 0])))')
    >>> diff(red, red).equal
    True
    """
    return a.diff(b, tolerance, limit)


@typed
def expand(text: str, name: str = "<text>", options: Options | None = None) -> str:
    """Return the text of a program after macro expansion.

    Raises
    ------
    SceneError
        The first error of ``check``, if the program has errors.

    Examples
    --------
    >>> expand('(bind "a" (lambda () (when #t (call "cube"))))').splitlines()[-1].strip()
    '(if #t (call "cube"))))'
    """
    session = Session(options)
    checked = session.check(Source(name, text))
    for diagnostic in checked.diagnostics:
        if diagnostic.is_error:
            raise error_of(diagnostic)
    assert checked.program is not None
    return session.expansion(checked.program)


@typed
def import_build(path: str | Path, warn: Callable[[Diagnostic], None] | None = None) -> str:
    """Convert a Minecraft build to a program with merged cuboids and one word per block state.

    Parameters
    ----------
    path : path
        ``.schem``, ``.litematic`` or ``.nbt``.
    warn : callable, optional
        Called with a ``Diagnostic`` for content that the program cannot represent, such as items in chests.

    Raises
    ------
    SceneError
        If the file cannot be read, is damaged, or contains no blocks.
    """
    from scenelang.backends.minecraft.export import imported

    text, warnings = imported(Path(path))
    for warning in warnings:
        if warn is not None:
            warn(warning)
    return text


@typed
def explain(code: str) -> str:
    """Explain the cause of a diagnostic and how to fix it, by its code or name.

    Examples
    --------
    >>> explain("E201").splitlines()[0].startswith("E201")
    True
    """
    return explained([require_diagnostic(code)])


@typed
def grammar_text(form: Literal["lark", "llguidance", "gbnf", "ebnf", "textmate"], strict: bool = False) -> str:
    """Return the grammar of programs for constrained decoding and editors (docs/grammar.md).

    Parameters
    ----------
    form : str
        Output format.
    strict : bool
        Use the paper's grammar without extensions.

    Examples
    --------
    >>> grammar_text("ebnf", strict=True).isascii()
    True
    """
    from scenelang.stdlib import reference

    return reference.grammar_text(form, strict)


def list_backends() -> tuple[Backend, ...]:
    """Return all backends, including those of installed plug-ins.

    Examples
    --------
    >>> "gltf" in [backend.name for backend in list_backends()]
    True
    """
    from scenelang.backends.base import all_backends

    return tuple(all_backends())


def check_installation() -> tuple[Check, ...]:
    """Check the installation: run a quick test of every feature in a separate process, and report what is missing."""
    from scenelang.doctor.doctor import checks

    return tuple(checks())


def _with_given(
    options: Options, defines: Mapping[str, Any] | None, limits: Limits | None, project: str | Path | None
) -> Options:
    """Return options with optional arguments of the API; values of params become literals."""
    return replace(
        options,
        defines={name: literal(value) for name, value in (defines or {}).items()},
        limits=limits or Limits(),
        project=Path(project) if project is not None else None,
    )


def _entries(path: Path, embeddings: str | Path | None) -> Mapping[str, ZEntry]:
    """Return the entries of an embeddings file; "auto" is the one beside the program, if it exists."""
    from scenelang.files import existing_beside, zfile

    if embeddings is None:
        return {}
    if embeddings != "auto":
        return zfile.read_entries(Path(embeddings))
    beside_program = existing_beside(str(path))
    return zfile.read_entries(beside_program) if beside_program is not None else {}
