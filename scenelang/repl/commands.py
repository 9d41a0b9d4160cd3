"""REPL commands: lines that begin with a comma, such as ``,doc grid``."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.backends.files import check_folder
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest
from scenelang.interpreter.runtime.types import STD, Builtin
from scenelang.interpreter.scene.entity import Scene, count_words, primitive_count
from scenelang.repl.display import clean, signature_of
from scenelang.repl.evaluation import LiveView, checked_program, description, function_of, known_names
from scenelang.repl.loop import Command, ModelRequest, Quit, Repl, find
from scenelang.viewer.workspace import FileWatch, Stamps, stamps_of, with_missing

if TYPE_CHECKING:
    from scenelang.inference.conductor import Inference, Result


@cache
def commands() -> tuple[Command, ...]:
    """Return all commands in the order of the help."""

    every = (*ABOUT_COMMANDS, *SCENE_COMMANDS, *FILE_COMMANDS, *MODEL_COMMANDS)
    order = _ORDER.split()
    return tuple(sorted(every, key=lambda command: order.index(command.name)))


_ORDER = """help doc apropos source tree count bounds expand time trace load reload watch render view export generate
edit seed transpile reset save quit"""


def operand_of(rest: str, command: str, what: str) -> str:
    """Return the operand of a command. Raises SceneError if it is missing."""
    if not rest:
        raise SceneError("value", f"`,{command}` requires {what}")
    return rest


def unquoted(text: str) -> str:
    """Remove the quotes around a file name, if any."""
    text = text.strip()
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text


def table(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Format two aligned columns."""
    across = max((len(left) for left, _ in rows), default=0)
    return [f"{left.ljust(across)}  {right}".rstrip() for left, right in rows]


# Commands for names and forms: help, doc, apropos, source, expand, time, trace, seed, reset, quit.


_MAX_FOUND = 40


def _help(repl: Repl, rest: str) -> None:
    chosen = (find(repl.commands, rest.lstrip(",")),) if rest else commands()
    repl.screen.rows(table([(command.usage, command.doc) for command in chosen]))
    if not rest:
        repl.screen.rows(["*1 *2 *3 are the last values, *e is the last error. Ctrl-C interrupts, Ctrl-D exits."])


# --- names ---------------------------------------------------------------------------------------------------------


def _doc(repl: Repl, rest: str) -> None:
    name = operand_of(rest, "doc", "a name")
    lines = description(repl.evaluation.top, name)
    if not lines:
        known = known_names(repl.evaluation.top)
        raise SceneError("unbound", f"unknown name `{name[:40]}`", suggest(name, known))
    repl.screen.prose(lines)


def _apropos(repl: Repl, rest: str) -> None:
    from scenelang.stdlib.reference import records

    text = operand_of(rest, "apropos", "a search text").lower()
    own = [(name, "") for name, binding in repl.evaluation.top.names() if not isinstance(binding, Builtin)]
    matches = [(name, _kind(repl, name)) for name, _ in own if text in name.lower() and not name.startswith("*")]
    matches += [(f'"{w}"', "word of this session") for w in repl.evaluation.top.file.words if text in w.lower()]
    near = [record for record in records() if text in record.name.lower()]
    far = [record for record in records() if record not in near and text in record.doc.lower()]
    rows = [*matches, *((record.name, record.doc) for record in [*near, *far])]
    if not rows:
        repl.screen.rows([f"no results for `{rest[:40]}`"])
        return
    repl.screen.rows(table(rows[:_MAX_FOUND]))
    if len(rows) > _MAX_FOUND:
        repl.screen.rows([f"... {len(rows) - _MAX_FOUND} more"])


def _kind(repl: Repl, name: str) -> str:
    function = function_of(repl.evaluation.top, name)
    return signature_of(function) if function is not None else "defined in this session"


def _source(repl: Repl, rest: str) -> None:
    name = operand_of(rest, "source", "a name or a word")
    top = repl.evaluation.top
    form = top.definition_of(name) or top.definition_of(f'"{name.strip(chr(34))}"')
    if form is not None:
        repl.screen.rows([*top.comment_of(form), *(line for d in form.datums for line in d.span.text.split("\n"))])
        return
    text = _library_source(repl, name)
    if text is None:
        raise SceneError("unbound", f"`{name[:40]}` is not defined", suggest(name, [n for n, _ in top.names()]))
    repl.screen.rows(text.split("\n"))


def _library_source(repl: Repl, name: str) -> str | None:
    """Return the source of a library function written in the language, or None."""
    from scenelang.grammar.reader import read

    library = repl.evaluation.session.library
    start = re.compile(rf"^\(define \(?{re.escape(name)}[\s)]", re.M)
    for module, text in library.modules.items():
        if start.search(text):
            for datum in read(Source(module, text)).forms:
                if start.match(datum.span.text):
                    return datum.span.text
    if name in library.builtins:
        raise SceneError("value", f"`{name}` is built in and has no source; see `,doc {name}`")
    return None


# --- forms ---------------------------------------------------------------------------------------------------------


def _expand(repl: Repl, rest: str) -> None:
    from scenelang.grammar.layout import layout
    from scenelang.interpreter.compile.unparse import unparse
    from scenelang.interpreter.expand.forms import INDENTS

    evaluation = repl.evaluation
    source = evaluation.source(operand_of(rest, "expand", "a form"))
    trees = evaluation.run(lambda: evaluation.top.expansion(source))
    text = layout(unparse(trees), indents=INDENTS)
    repl.screen.rows(text.rstrip("\n").split("\n"))


def _time(repl: Repl, rest: str) -> None:
    evaluation = repl.evaluation
    outcome = evaluation.evaluate(evaluation.source(operand_of(rest, "time", "a form")))
    repl.show(outcome)
    if outcome.ok:
        repl.screen.write(f"{outcome.seconds:.3f} s, {outcome.steps:,} steps, {outcome.entities:,} entities created")
    repl.changed()


def _trace(repl: Repl, rest: str) -> None:
    evaluation = repl.evaluation
    if not rest:
        repl.screen.rows([f"traced: {name}" for name in sorted(evaluation.tracer.names)] or ["no functions are traced"])
        return
    top, name = evaluation.top, rest
    if function_of(top, name) is None:
        name = f'"{rest.strip(chr(34))}"'
        if function_of(top, name) is None and name not in evaluation.tracer.names:
            known = [*(n for n, _ in top.names()), *top.file.words]
            raise SceneError(
                "unbound", f"`{rest[:40]}` is not a function or word of this session", suggest(rest, known)
            )
    traced = evaluation.tracer.toggle(top, name)
    repl.screen.write(f"{name} is {'traced' if traced else 'no longer traced'}")


# --- the session ---------------------------------------------------------------------------------------------------


def _seed(repl: Repl, rest: str) -> None:
    try:
        seed = int(operand_of(rest, "seed", "an integer"))
    except ValueError:
        raise SceneError("value", f"expected an integer, got `{rest[:40]}`") from None
    repl.evaluation.set_seed(seed)


def _reset(repl: Repl, rest: str) -> None:
    repl.evaluation.reset()
    repl.screen.write("all definitions removed")


def _quit(repl: Repl, rest: str) -> None:
    raise Quit


ABOUT_COMMANDS = (
    Command("help", ",help [COMMAND]", "list the commands", _help, "COMMAND"),
    Command("doc", ",doc NAME", "describe a name, word, primitive, `:attribute` or code such as E401", _doc, "NAME"),
    Command("apropos", ",apropos TEXT", "search names and descriptions", _apropos, "TEXT"),
    Command("source", ",source NAME", "print the source of a function or word", _source, "NAME"),
    Command("expand", ",expand FORM", "print a form after macro expansion", _expand, "FORM"),
    Command("time", ",time FORM", "evaluate a form, and print seconds, steps and entities", _time, "FORM"),
    Command("trace", ",trace [NAME]", "toggle tracing of a function or word; without NAME, list them", _trace,
            "NAME"),
    Command("seed", ",seed N", "seed the random streams", _seed, "N"),
    Command("reset", ",reset", "remove all definitions", _reset),
    Command("quit", ",quit", "exit the REPL", _quit),
)  # fmt: skip


# Commands for files: load, reload, watch, transpile, save.


def _load(repl: Repl, rest: str) -> None:
    path = unquoted(operand_of(rest, "load", "a file"))
    outcome = repl.evaluation.load(path)
    repl.show(outcome)
    if outcome.ok:
        repl.evaluation.loaded = path
        repl.screen.write(f"loaded {path}")
    repl.changed()


def _reload(repl: Repl, rest: str) -> None:
    path = _file_of(repl, "reload")
    outcome = repl.evaluation.reload(path)
    repl.show(outcome)
    if outcome.ok:
        repl.screen.write(f"loaded {path}")
    repl.changed()


def _file_of(repl: Repl, command: str) -> str:
    path = repl.evaluation.loaded or repl.evaluation.file
    if path is None:
        raise SceneError("value", "no file has been loaded", "load a file with `,load FILE`")
    return path


def _watch(repl: Repl, rest: str) -> None:
    if repl.watch is not None:
        repl.watch.stop()
        repl.screen.write(f"{repl.watch.path} is no longer watched")
        repl.watch = None
        if not rest:
            return
    path = unquoted(rest) if rest else _file_of(repl, "watch")
    if path != (repl.evaluation.loaded or repl.evaluation.file):
        _load(repl, path)
        if repl.evaluation.loaded != path:
            return
    repl.watch = Watch(repl, path)
    repl.screen.write(f"watching {path}; stop with `,watch`")


def _transpile(repl: Repl, rest: str) -> None:
    path = unquoted(operand_of(rest, "transpile", "a file with a language model's Python"))
    evaluation = repl.evaluation
    translation = evaluation.session.transpile(evaluation.session.source(path))
    repl.screen.report(translation.diagnostics)
    if not translation.ok:
        repl.errors += 1
        return
    before = len(evaluation.top.forms)
    outcome = evaluation.evaluate(Source(f"<{Path(path).name}>", translation.text), whole=True)
    repl.show(outcome)
    if outcome.ok:
        forms = [form for form in evaluation.top.forms if form.datums[0].span.source.name == f"<{Path(path).name}>"]
        words = sum(len(form.words) for form in forms)
        repl.screen.write(f"{len(forms) or len(evaluation.top.forms) - before} definitions, {words} of them words")
    repl.changed()


def _save(repl: Repl, rest: str) -> None:
    from scenelang.backends.files import atomic_write

    is_forced = rest.startswith("!") or rest.endswith(" !")
    name = unquoted(operand_of(rest.strip("! "), "save", "a file"))
    if name == "-":
        raise SceneError("value", "`,save` cannot write to standard output", "use `./-` for a file of that name")
    path = Path(name)
    text = checked_program(repl.evaluation.session, repl.evaluation.top, str(path))
    if path.is_dir() or not path.parent.is_dir():
        why = "it is a folder" if path.is_dir() else f"no such folder: {path.parent}"
        raise SceneError("file", f"cannot write {path}: {why}")
    if path.exists() and not is_forced and not _may_replace(repl, path):
        raise SceneError("file", f"{path} already exists", f"overwrite it with `,save! {path}`")
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8", newline="\n")
    repl.screen.write(f"wrote {path}")


def _may_replace(repl: Repl, path: Path) -> bool:
    return repl.screen.ask is not None and repl.screen.ask(f"overwrite {path}?")


FILE_COMMANDS = (
    Command("load", ",load FILE", "evaluate a file", _load, "FILE"),
    Command("reload", ",reload", "evaluate the file again", _reload),
    Command(
        "watch", ",watch [FILE]", "evaluate a file on each change, and print the changes; again: stop", _watch, "FILE"
    ),
    Command(
        "transpile", ",transpile FILE", "evaluate the definitions of a language model's Python", _transpile, "FILE"
    ),
    Command("save", ",save FILE", "write the definitions as a program; `,save! FILE` overwrites", _save, "FILE"),
)


# Commands that call a language model: generate, edit. They accept the options of the command line.


_MAX_CHANGES = 12


def _request(repl: Repl, command: str, rest: str, what: str) -> ModelRequest:
    """Parse the request of a command. Raises SceneError."""
    request = repl.request(command, operand_of(rest, command, what))
    if not request.text:
        raise SceneError("value", f"`,{command}` requires {what}")
    return request


def _generate(repl: Repl, rest: str) -> None:
    from scenelang.inference.conductor import Inference

    request = _request(repl, "generate", rest, "a text prompt, such as ,generate a lighthouse")
    assert request.task is not None
    inference = Inference(request.task, request.settings, repl.evaluation.session.options)
    result = _run_inference(repl, request, inference)
    repl.screen.report(result.best.diagnostics)
    _evaluate_program(repl, request.text, result.best.program)


def _edit(repl: Repl, rest: str) -> None:
    """Let a language model edit the program of the session, and apply the edit after confirmation."""
    from scenelang.inference.brief import Ablation
    from scenelang.inference.conductor import Inference
    from scenelang.inference.generation import edit_of, edit_task, imported_files
    from scenelang.session.scene_changes import OF_AN_EDIT, change_lines

    request = _request(repl, "edit", rest, "an instruction, such as ,edit make the tower higher")
    evaluation = repl.evaluation
    name = evaluation.file or "<repl>"
    program = checked_program(evaluation.session, evaluation.top, name)
    before = evaluation.root()
    ablation = request.ablation or Ablation.NONE
    task = edit_task(Source(name, program), before, request.text, ablation, request.seed)
    imports = imported_files(evaluation.session.check(Source(name, program)).program)
    options = replace(evaluation.session.options, imports=imports)
    result = _run_inference(repl, request, Inference(task, request.settings, options, name))
    done = edit_of("the session", task, before, result.best, evaluation.limits.primitives)
    repl.screen.rows(done.text.splitlines())
    repl.screen.rows(change_lines(done.changes, _MAX_CHANGES, OF_AN_EDIT))
    if repl.screen.ask is not None and not repl.screen.ask("apply the edit?"):
        return
    # definitions that the edit removed would remain
    evaluation.reset()
    _evaluate_program(repl, request.text, result.best.code)


def _run_inference(repl: Repl, request: ModelRequest, inference: Inference) -> Result:
    """Run inference to its end, in a run folder as on the command line. Raises SceneError."""
    from scenelang.inference.conductor import NoProgram
    from scenelang.inference.generation import begin, play, recorded

    run = begin(inference, "repl", request.text, request.runs)
    try:
        with recorded(run):
            return play(inference, run, request.live)
    except SceneError as error:
        if isinstance(error, NoProgram):
            repl.screen.report(error.verdict.diagnostics)
        if not repl.screen.quiet:
            repl.screen.complain(f"the run is saved in {run.path}")
        raise


def _evaluate_program(repl: Repl, name: str, program: str) -> None:
    """Evaluate the model's program as one input."""
    outcome = repl.evaluation.evaluate(Source(f"<{name[:40]}>", program), whole=True)
    repl.show(outcome)
    repl.changed()


MODEL_COMMANDS = (
    Command(
        "generate", ",generate [OPTIONS] TEXT", "generate a scene with a language model; options as for "
        "`scenelang generate`", _generate, "TEXT",
    ),
    Command(
        "edit", ",edit [OPTIONS] INSTRUCTION", "edit the definitions with a language model", _edit, "TEXT",
    ),
)  # fmt: skip


# Watched files: evaluated again when the file or an import changes, with a summary of the changes.


_COMPARED = 50_000  # primitives; for larger scenes only counts are compared


class Watch:
    """Evaluates a file whenever it or an import changes, until ``stop``."""

    def __init__(self, repl: Repl, path: str, stamps: Stamps | None = None) -> None:
        self.path = path
        self._repl = repl
        self._scene, _ = self._root()
        self._stamps = stamps_of(self._names()) if stamps is None else stamps
        self._watch = FileWatch(lambda: self._stamps.folders, self._look)

    def again(self) -> Watch:
        """Create a new watch in place of one whose thread did not survive a fork."""
        return Watch(self._repl, self.path, self._stamps)  # the file may have changed in the meantime

    def stop(self) -> None:
        """Stop watching."""
        self._watch.stop()

    def _names(self) -> list[str]:
        files = self._repl.evaluation.top.file.imports
        return [self.path, *(file.source.name for file in files if not file.source.name.startswith(("<", STD)))]

    def _look(self) -> None:
        if self._stamps.are_old():
            self._repl.ask(self._again)

    def _again(self) -> None:
        repl = self._repl
        if self._watch.is_stopped or not self._stamps.are_old():
            return
        before = stamps_of(self._names())
        outcome = repl.evaluation.reload(self.path)
        names = with_missing(self._names(), outcome.diagnostics)
        self._stamps = stamps_of(names).since(before)  # a file may have changed since it was read
        repl.show(outcome)
        if not outcome.ok:
            return
        old = self._scene
        self._scene, problem = self._root()
        if problem is not None:
            repl.screen.report([problem])
        repl.screen.write(clean(f"{Path(self.path).name} changed: {', '.join(what_changed(old, self._scene))}"))
        repl.changed()

    def _root(self) -> tuple[Scene | None, Diagnostic | None]:
        """Return the scene, or the error that its evaluation ends with; a file without a root has neither."""
        evaluation = self._repl.evaluation
        try:
            return evaluation.root(), None
        except (SceneError, RecursionError, MemoryError) as error:
            problem = evaluation.session.problem_of(error)
            return None, problem if problem is not None and problem.name != "no-root" else None


def what_changed(old: Scene | None, new: Scene | None) -> Iterator[str]:
    """Yield a brief summary of the changes in the first frame of a scene."""
    if new is None:
        yield "no scene"
        return
    count = primitive_count(new.root)
    if old is None:
        yield f"{count:,} primitives"
        return
    before = primitive_count(old.root)
    yield f"{count:,} primitives" if count == before else f"{before:,} -> {count:,} primitives"
    yield from _changed_size(old, new)
    if max(count, before) <= _COMPARED:
        yield from _differences(old, new)


def _changed_size(old: Scene, new: Scene) -> Iterator[str]:
    from scenelang.interpreter.scene.bounds import word_box

    a, b = word_box(old, None), word_box(new, None)
    if b is not None and (a is None or any(abs(x - y) > 1e-9 for x, y in zip(a, b))):
        yield "sizes [" + " ".join(f"{b[i + 3] - b[i]:.4g}" for i in range(3)) + "]"


def _differences(old: Scene, new: Scene) -> Iterator[str]:
    from scenelang.interpreter.inspection.difference import compare_frames, compared_frame
    from scenelang.interpreter.scene.flatten import flatten

    before, after = (compared_frame(flatten(scene, 2 * _COMPARED).frames[0]) for scene in (old, new))
    comparison = compare_frames(before, after)
    if comparison.equal:
        yield "no primitive changed"
        return
    for number, what in (
        (len(comparison.moved), "moved"), (len(comparison.recolored), "recolored"),
        (len(comparison.missing), "removed"), (len(comparison.extra), "added"),
    ):  # fmt: skip
        if number:
            yield f"{number:,} {what}"


# Commands for scenes: tree, count, bounds, render, view, export. Without a form they use the last input's value if it
# is a scene, else the root, and print which.


_WIDTH, _HEIGHT = 640, 480
_ROWS_OF_IMAGE = 20
_OUTPUT = re.compile(r"""(?:^|\s)-o\s+("[^"]*"|\S+)\s*$""")


def _scene(repl: Repl, form: str) -> Scene:
    """Return the scene that a command operates on, and print which one if the command did not specify it."""
    subject = repl.evaluation.subject_of(form)
    if subject.what is not None:
        repl.screen.write(clean(f"of {subject.what}:"))
    return subject.scene


def _tree(repl: Repl, rest: str) -> None:
    from scenelang.interpreter.inspection.outline import outline

    scene = _scene(repl, rest)
    repl.screen.rows(outline(scene))


def _count(repl: Repl, rest: str) -> None:
    scene = _scene(repl, rest)
    counts = count_words(scene.root)
    across = max((len(f"{n:,}") for n in counts.values()), default=0)
    if scene.animated:
        repl.screen.write(f"frame 0 of {len(scene.frames):,}:")
    repl.screen.rows([f"{n:{across},}  {word}" for word, n in counts.items()])


def _bounds(repl: Repl, rest: str) -> None:
    from scenelang.interpreter.scene.bounds import box_data, word_box

    box = word_box(_scene(repl, rest), None)
    if box is None:
        raise SceneError("empty-scene", "the scene has no geometry and therefore no bounding box")
    rows = [(name, "[" + " ".join(map(_number, values)) + "]") for name, values in box_data(box).items()]
    repl.screen.rows(table(rows))


def _number(x: float) -> str:
    return f"{round(x, 12) + 0.0:.6g}"  # hide rounding errors and negative zero


# --- images and files ----------------------------------------------------------------------------------------------


def _render(repl: Repl, rest: str) -> None:
    form, output = _output_of(rest)
    path = Path(output) if output else _next_picture(repl)
    _check_picture(path)
    scene = _scene(repl, form)
    _draw(repl, scene, path)
    if repl.screen.images is not None and path.suffix.lower() in (".png", ".jpg", ".jpeg", ".webp"):
        from scenelang.repl.display import inline

        rows = max(4, min(_ROWS_OF_IMAGE, repl.screen.height - 6))
        repl.screen.write(inline(path, repl.screen.images, rows))
    repl.screen.write(f"wrote {path}")


def _output_of(rest: str) -> tuple[str, str]:
    """Split ``FORM -o FILE`` into form and file."""
    match = _OUTPUT.search(rest)
    return (rest[: match.start()].strip(), unquoted(match[1])) if match else (rest, "")


def _next_picture(repl: Repl) -> Path:
    if repl.pictures is None:
        repl.pictures = Path(tempfile.mkdtemp(prefix="scenelang-"))
    return repl.pictures / f"render-{len(list(repl.pictures.iterdir())) + 1}.png"


def _check_picture(path: Path) -> None:
    from scenelang.backends.pictures.film import STILL_ENDINGS

    if path.suffix.lower() not in STILL_ENDINGS:
        hint = f"supported: {' '.join(sorted(STILL_ENDINGS))}; render videos with `scenelang render`"
        raise SceneError("backend", f"cannot write an image to `{path.name}`", hint)
    check_folder(path)


def _draw(repl: Repl, scene: Scene, path: Path) -> None:
    from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend, save_image

    options = PictureOptions(
        limit=repl.evaluation.limits.primitives,
        warn=lambda diagnostic: repl.screen.report([diagnostic]),
        width=_WIDTH,
        height=_HEIGHT,
        seed=repl.evaluation.seed,
    )
    save_image(draw(scene, options, picture_backend("draft")), path)


def _export(repl: Repl, rest: str) -> None:
    from scenelang.backends import base

    path = Path(unquoted(operand_of(rest, "export", "a file, such as scene.glb")))
    backend = base.for_file(path, base.Work.EXPORT)
    check_folder(path)
    scene = _scene(repl, "")
    limit = repl.evaluation.limits.primitives
    options = base.BackendOptions(limit=limit, warn=lambda diagnostic: repl.screen.report([diagnostic]))
    for written in backend.run(scene, path, options) or [path]:
        repl.screen.write(f"wrote {written}")


def _view(repl: Repl, rest: str) -> None:
    if repl.live_view is None:
        repl.live_view = LiveView(repl.evaluation)
    repl.screen.write(f"{repl.live_view.address} shows the root and updates with the session")
    repl.live_view.open_browser()


SCENE_COMMANDS = (
    Command("tree", ",tree [FORM]", "print the entity hierarchy", _tree, "FORM"),
    Command("count", ",count [FORM]", "count the instances of every word", _count, "FORM"),
    Command("bounds", ",bounds [FORM]", "print the exact bounding box", _bounds, "FORM"),
    Command(
        "render",
        ",render [FORM] [-o FILE]",
        "render a draft image, displayed inline if the terminal supports it",
        _render,
        "FORM",
    ),
    Command("view", ",view", "open the live viewer in a browser", _view),
    Command("export", ",export FILE", "export the scene, in the format of the file extension", _export, "FILE"),
)
