"""One object that the command line, the REPL, editors and language-model loops all use: text in, value and diagnostics
out. It puts library and interpreter together; meaning lives below."""

from __future__ import annotations

import errno
import gc
import os
import re
import sys
import threading
from codecs import BOM_UTF8
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, TypeVar

from scenelang.backends.files import read_regular, rewrite
from scenelang.grammar import ast, reader
from scenelang.grammar.ast import check_strict
from scenelang.grammar.datum import Atom, Datum, ListDatum, Source, Span, Symbol, walk
from scenelang.grammar.diagnostics import Diagnostic, Note, SceneError, UsageError, error_of
from scenelang.grammar.reader import read
from scenelang.interpreter.lint.lint import (
    apply_fixes,
    find_root,
    lint,
    lint_of_forms,
    not_allowed,
    with_fixes,
    word_warnings,
)
from scenelang.interpreter.program.interactive import JournaledRuntime, TopLevel, Version, Versions
from scenelang.interpreter.program.program import Program, load_program, prelude_of
from scenelang.interpreter.runtime.evaluate import ProgramRun, macro_runner
from scenelang.interpreter.runtime.limits import Limits, fork_safe_lock, recursion_room
from scenelang.interpreter.runtime.procedures import Closure
from scenelang.interpreter.runtime.runtime import Runtime, ZEntry
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.numbering import automatic_entries, graft, serials_at
from scenelang.sandbox.supervision import limited, link
from scenelang.sandbox.worker import trial
from scenelang.stdlib.library import build_library

if TYPE_CHECKING:
    from scenelang.backends.geometry.assets import AssetFiles
    from scenelang.interpreter.program.interactive import TopLevel
    from scenelang.interpreter.transpile.translate import Translation


T = TypeVar("T")
IMPORT_FORM = re.compile(r'\(import\s+"([^"\n]*)"')
_REGISTERS = re.compile(r"^[ \t]*@register", re.M)
_STACK = 512 * 1024 * 1024
_STARTING = fork_safe_lock()  # the size of new threads' stacks is the process's
_LARGEST_FILE = 16_000_000
MACRO_LIMITS = Limits(steps=2_000_000, seconds=10.0, depth=20_000)
EXPANSION_DEPTH = 60_000
_KEPT_FRAMES = 400
_FIX_ROUNDS = 20
_MOST_IMPORTERS = 300
_LARGEST_IMPORTER = 500_000  # bytes


@dataclass(frozen=True, slots=True)
class Options:
    """How programs are read and run. ``defines`` overrides params, as text; ``project`` bounds what may be imported
    (None: the main file's folder), and ``imports`` are the only files in it that may be, None for all; ``handles`` is Z
    by handle name."""

    root: str | None = None
    seed: int = 0
    defines: Mapping[str, str] = field(default_factory=dict)
    limits: Limits = field(default_factory=Limits)
    project: Path | None = None
    allow_outside: bool = False
    imports: frozenset[Path] | None = None
    strict: bool = False
    z_entries: Mapping[str, ZEntry] = field(default_factory=dict)


def definition(item: str) -> tuple[str, str]:
    """The name and the text of ``NAME=VALUE``; raises UsageError."""
    name, sign, text = item.partition("=")
    if not sign or not name:
        raise UsageError("param", f"--define wants NAME=VALUE, got `{item}`")
    return name.strip(), text


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A program and what was found wrong with it, in reading order."""

    program: Program | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def ok(self) -> bool:
        return not any(d.is_error for d in self.diagnostics)


@dataclass(frozen=True, slots=True, eq=False)
class Evaluated:
    """``scene`` is None when something went wrong. ``log`` holds what the program printed."""

    program: Program | None = field(repr=False)
    scene: Scene | None
    diagnostics: tuple[Diagnostic, ...]
    log: tuple[str, ...] = ()
    steps: int = 0

    @property
    def ok(self) -> bool:
        return self.scene is not None

    def require(self) -> Scene:
        """The scene; raises SceneError with the first mistake where there is none."""
        if self.scene is None:
            raise error_of(next(d for d in self.diagnostics if d.is_error))
        return self.scene


def run_with_room(
    action: Callable[[], T], depth: int, cancel: Callable[[], None] | None = None, folders: tuple[str, ...] = ()
) -> T:
    """Run ``action`` in a thread whose stack allows deep recursion. Ctrl-C calls ``cancel``, then waits for the end. In
    a watched process the thread may only read, and only ``folders``."""
    watched = link()
    if watched is not None:
        reader.prepare()
        ast.prepare()
    outcome: list[Any] = []
    done = threading.Event()  # Ctrl-C during Thread.join makes Python 3.11 believe that the thread has ended

    def target() -> None:
        try:
            with recursion_room(depth), watched.evaluating(folders) if watched is not None else nullcontext():
                outcome.append((True, action()))
        except BaseException as error:
            outcome.append((False, error))
        finally:
            done.set()

    with _STARTING:
        old = threading.stack_size(_STACK)
        try:
            thread = threading.Thread(target=target, daemon=True)
            thread.start()
        finally:
            threading.stack_size(old)
    interrupted = False
    while not done.is_set():
        try:
            done.wait(0.5)
        except KeyboardInterrupt:
            if cancel is None or interrupted:
                raise
            interrupted = True
            cancel()
    ok, value = outcome[0]
    if ok:
        result: T = value
        return result
    raise value


class Session:
    """Checks and evaluates programs under one set of options."""

    def __init__(self, options: Options | None = None) -> None:
        self.options = options or Options()
        self.library = build_library()

    # --- sources ---------------------------------------------------------------------------------------------------

    def source(self, path: str) -> Source:
        """The text of a file, ``-`` for standard input; raises SceneError when it cannot be read."""
        return _read_source(path, path)

    @staticmethod
    def _folder(main: Source) -> Path:
        return Path(main.name).parent if not main.name.startswith("<") else Path.cwd()

    def _project(self, main: Source) -> Path:
        """The folder that programs may not leave: the one that was set, else the main file's."""
        return (self.options.project or self._folder(main)).resolve()

    def _assets(self, main: Source) -> AssetFiles:
        """Where the mesh files of a program are looked for."""
        from scenelang.backends.geometry.assets import AssetFiles

        return AssetFiles(self._folder(main), self._project(main), self.options.allow_outside)

    def folders(self, main: Source) -> tuple[str, ...]:
        """What an evaluation may read beside the package."""
        return ("/",) if self.options.allow_outside else (str(self._project(main)), str(self._folder(main).resolve()))

    def importer(self, main: Source, texts: Mapping[Path, str] | None = None) -> Callable[[str, Source, Span], Source]:
        """Finds imported files: relative to the importing one, inside the project folder. ``texts`` holds, by resolved
        path, those that are open in an editor."""
        project = self._project(main)

        def load(path: str, importing: Source, span: Span) -> Source:
            folder = Path(importing.name).parent if not importing.name.startswith("<") else Path.cwd()
            try:
                target = (folder / path).resolve()
            except (OSError, ValueError, RuntimeError):
                raise SceneError("file", f"`{path[:80]}` is no path", None, span) from None
            if not self.options.allow_outside and not target.is_relative_to(project):
                hint = "files may import only from the project folder; --allow-outside lifts this"
                raise SceneError("import-outside", f"`{path}` leads out of {project}", hint, span)
            shown = os.path.relpath(target)
            if self.options.imports is not None and target not in self.options.imports:
                raise SceneError("import-outside", f"this program may not import `{path[:80]}`", None, span)
            if texts and target in texts:
                return Source(shown, texts[target])
            try:
                return _read_source(str(target), shown)
            except SceneError as error:
                error.span = span
                raise

        return load

    # --- checking ----------------------------------------------------------------------------------------------

    def check(self, source: Source) -> Checked:
        """Read, expand and analyse; never raises for a mistake in a program."""
        if is_scene_file(source):
            return Checked(None, self._read_scene(source).diagnostics)
        try:
            with limited(self.options.limits):
                check = lambda: self._check(source, self._translation(source))
                return run_with_room(check, EXPANSION_DEPTH, folders=self.folders(source))
        except RecursionError:
            return Checked(None, (Diagnostic("nesting", "the program is nested too deeply", Span(source, 0, 1)),))

    def mended(self, source: Source) -> tuple[Source, int]:
        """The source with every safe fix applied, and how many there were. One fix may bring forth another."""
        total = 0
        for _ in range(_FIX_ROUNDS):
            text, number = apply_fixes(source, self.check(source).diagnostics)
            if not number:
                break
            source, total = Source(source.name, text), total + number
        return source, total

    def fix_file(self, path: str) -> tuple[Source, int]:
        """As ``mended``, written back to the file; raises SceneError where it cannot be read or written."""
        source, number = self.mended(self.source(path))
        if number:
            mark = "\ufeff" if read_regular(path, 3).startswith(BOM_UTF8) else ""
            rewrite(Path(path), mark + source.text)
        return source, number

    def expansion(self, program: Program) -> str:
        """The text of a program after macro expansion."""
        from scenelang.grammar.layout import layout
        from scenelang.interpreter.compile.analyse import mentioned
        from scenelang.interpreter.compile.unparse import unparse
        from scenelang.interpreter.expand.forms import INDENTS

        forms = [*program.forms, *([program.scene] if program.scene else [])]
        params = {param.span for param in program.params}
        imports = (f'(import "{module}")' for module in self.library_imports(program))
        datums: list[Datum] = list(read(Source("<expansion>", "\n".join(imports))).forms)
        spelling: dict[int, str] = {}
        kept = frozenset(variable for form in forms if form.span in params for variable in mentioned(form))
        for datum, form in zip(unparse(forms, kept), forms, strict=True):
            if form.span in params:  # as written, so that the expansion can be overridden too
                (datum,) = read(Source(form.span.source.name, form.span.text)).forms
                spelling |= {id(atom): atom.span.text for atom in walk(datum) if isinstance(atom, Atom)}
            elif form is program.scene and isinstance(datum, ListDatum):
                datum = ListDatum((Atom(Symbol("scene"), datum.span), *datum.items[1:]), None, datum.span)
            datums.append(datum)
        return layout(datums, indents=INDENTS, spelling=spelling)

    def transpile(self, source: Source) -> Translation:
        """A language model's response, or its Python, as a program, checked; never raises for a mistake in it."""
        from scenelang.interpreter.transpile.translate import Translation, translate

        def work() -> Translation:
            translation = translate(source)
            checked = self._check(source, translation)
            return translation.checked(checked.diagnostics)

        try:
            with limited(self.options.limits):
                return run_with_room(work, EXPANSION_DEPTH, folders=self.folders(source))
        except RecursionError:
            problem = Diagnostic("nesting", "the Python is nested too deeply", Span(source, 0, 1))
            return Translation((), "", (problem,))

    @staticmethod
    def _translation(source: Source) -> Translation | None:
        """The forms of a language model's Python, None for a program of the language."""
        if not is_python(source):
            return None
        from scenelang.interpreter.transpile.translate import translate

        return translate(source, with_text=False)

    def _check(self, source: Source, translation: Translation | None) -> Checked:
        try:
            overrides = {name: _value_datum(name, text) for name, text in self.options.defines.items()}
        except SceneError as error:
            return Checked(None, (error.diagnostic,))
        found = translation.diagnostics if translation is not None else ()
        if translation is not None and not translation.ok:
            return Checked(None, found)
        watched = link()
        if watched is not None:
            watched.note(Span(source, 0, 1))
        datums = translation.forms if translation is not None else None
        program = load_program(
            source,
            self.library,
            self.importer(source),
            macro_runner(self.library, self._macro_limits),
            overrides,
            datums,
        )
        diagnostics = [*found, *program.diagnostics]
        if self.options.strict and program.ok:
            try:
                check_strict(read(source).forms if datums is None else datums)
            except SceneError as error:
                diagnostics.append(error.diagnostic)
        diagnostics += self.warnings(program, translation is None)
        return Checked(program, settled(diagnostics, program.sources))

    def warnings(self, program: Program, is_written: bool = True) -> list[Diagnostic]:
        """What is suspicious about a program that has no errors, its root included. ``is_written``: somebody wrote it
        in the language, rather than a model in Python, and cares for what is left over."""
        if not program.ok:
            return lint_of_forms(program) if is_written else []
        try:
            root = self._root(program)[1]
        except SceneError as error:
            root = [] if error.name == "no-root" else [error.diagnostic]
            has_one_root = False
        else:
            has_one_root = not root
        if not is_written:
            return [*word_warnings(program), *root]
        return [*lint(program, lambda: has_one_root and not self._is_imported(program.main)), *root]

    def _is_imported(self, source: Source) -> bool:
        """Whether a program beside this one, or in the folder around it, imports it."""
        if source.name.startswith("<"):
            return False
        path = Path(source.name).resolve()
        names = {path.name, f"{path.parent.name}/{path.name}"}
        around = [*path.parent.glob("*.scene"), *path.parent.parent.glob("*.scene")][:_MOST_IMPORTERS]
        return any(other != path and _imports(other, names) for other in around)

    def _root(self, program: Program) -> tuple[str, list[Diagnostic]]:
        if self.options.root is not None:
            return self.options.root, []
        return find_root(program)

    def library_imports(self, program: Program) -> list[str]:
        """The modules of builtins that a program imports, such as ``std/python.scene``: its expansion needs them."""
        modules = {f"{STD}{module}" for module in self.library.imported}
        return [source.name for source in program.sources if source.name in modules]

    # --- evaluating --------------------------------------------------------------------------------------------

    def evaluate(self, source: Source) -> Evaluated:
        """Check and run a program, or read the scene in a JSON file; never raises for a mistake in it."""
        with limited(self.options.limits) as started:
            return self._evaluate(source, started)

    def _evaluate(self, source: Source, started: float) -> Evaluated:
        """``started``: when the time that the limits give began."""
        if is_scene_file(source):
            return self._read_scene(source)
        checked = self.check(source)
        if not checked.ok or checked.program is None:
            return Evaluated(checked.program, None, checked.diagnostics)
        program = checked.program
        runtime = self._runtime(source)
        runtime.meter.renew(started)
        run = lambda: self._run(program, runtime)
        try:
            scene = run_with_room(run, self.options.limits.depth, runtime.meter.cancel, self.folders(source))
            problem = None
        except (SceneError, RecursionError, MemoryError) as error:
            scene, problem = None, self.problem_of(error)
        if problem is not None and self.options.z_entries:
            used = ", ".join(f"<{name}>" for name in list(self.options.z_entries)[:8])
            note = Note(f"a file of embeddings is in use, for {used}; `embeddings FILE set HANDLE --clear` forgets one")
            problem = replace(problem, notes=(*problem.notes, note))
        warnings = not_allowed(runtime.warnings.values(), program.sources)
        diagnostics = [*checked.diagnostics, *warnings, *([problem] if problem else [])]
        return Evaluated(program, scene, tuple(diagnostics), tuple(runtime.log), runtime.meter.total)

    def check_geometry(self, source: Source) -> list[Diagnostic]:
        """What ``evaluate`` says, and what is suspicious about the geometry of the scene."""
        from scenelang.backends.geometry.lint import check_geometry

        with limited(self.options.limits):
            result = self.evaluate(source)
            if result.scene is None:
                return list(result.diagnostics)
            try:
                found = check_geometry(result.scene)
            except SceneError as error:
                found = [error.diagnostic]
        sources = result.program.sources if result.program is not None else ()
        return [*result.diagnostics, *not_allowed(found, sources)]

    @property
    def _macro_limits(self) -> Limits:
        """Those of macros' bodies: their own, and no more memory and hardly more time than the program has, whose limit
        is told of first where processes hold it."""
        most = self.options.limits
        return replace(
            MACRO_LIMITS,
            seconds=min(MACRO_LIMITS.seconds, most.seconds + 1.0),
            memory=min(MACRO_LIMITS.memory, most.memory),
        )

    def top_level(self, main: Source, started: Callable[[Runtime], None]) -> TopLevel:
        """A top level that goes on, form by form, beside the file ``main``. ``started`` is told of every runtime that
        macros run in, so that they can be cancelled. Raises SceneError for a malformed ``--define``."""
        options, library = self.options, self.library
        overrides = {name: _value_datum(name, text) for name, text in options.defines.items()}
        assets = self._assets(main)
        runtime = JournaledRuntime(library, options.limits, options.seed, options.z_entries, asset=assets.measure)
        new_macros = lambda: macro_runner(library, self._macro_limits, started)
        return TopLevel(library, runtime, main, self.importer(main), new_macros, overrides)

    def problem_of(self, error: BaseException) -> Diagnostic | None:
        """What users get to see of an error that ended an evaluation; None for one that is no fault of a program."""
        if isinstance(error, SceneError):
            return _outside_library(error.diagnostic)
        if isinstance(error, RecursionError):
            return _too_deep(self.options.limits, error)
        if isinstance(error, MemoryError):
            hint = "the machine has no more; lower the limit with --max-memory"
            return Diagnostic("memory", "the program ran out of memory", None, hint)
        return None

    def _read_scene(self, source: Source) -> Evaluated:
        """The scene that ``export`` wrote as JSON."""
        from scenelang.backends.exports.scene_json import read_scene

        try:
            scene = read_scene(source.name, self._project(source), self.options.allow_outside)
        except SceneError as error:
            return Evaluated(None, None, (error.diagnostic,))
        return Evaluated(None, scene, ())

    def _run(self, program: Program, runtime: Runtime) -> Scene:
        thresholds = gc.get_threshold()
        gc.set_threshold(200_000, 50, 100)
        try:
            try:
                word, _ = self._root(program)
            except SceneError:
                ProgramRun(self.library, runtime).run_forms(program)  # its own mistakes come first
                raise
            scene = self._run_once(program, runtime, word)
            return self._with_entries(program, runtime, word, scene) if self.options.z_entries else scene
        finally:
            gc.set_threshold(*thresholds)

    def _runtime(self, main: Source, snapshots: frozenset[int] = frozenset()) -> Runtime:
        options = self.options
        assets = self._assets(main)
        return Runtime(
            self.library, options.limits, options.seed, options.z_entries, snapshots=snapshots, asset=assets.measure
        )

    def _run_once(self, program: Program, runtime: Runtime, word: str) -> Scene:
        run = ProgramRun(self.library, runtime)
        watched = link()
        for form in program.forms:
            if watched is not None:
                watched.note(form.span)
            run.run_form(form)
        if watched is not None:
            watched.note(program.all_words.get(word), f'"{word}"')
        return run.run_root(program, word, self.options.seed)

    def _with_entries(self, program: Program, runtime: Runtime, word: str, scene: Scene) -> Scene:
        """The scene with Z's entries for automatic numbers; the program runs again to keep the streams' states."""
        entries, unused = automatic_entries(scene, self.options.z_entries)
        for name in unused:
            runtime.warn("unused-entry", f"the entry `<{name}>` of Z names nothing in the scene")
        if not entries:
            return scene
        again = self._runtime(program.main, serials_at(scene, entries))
        grafted = graft(again, self._run_once(program, again, word), entries)
        runtime.warnings.update(again.warnings)
        return grafted


def program_files(names: Iterable[str]) -> list[str]:
    """The files that are meant, each once: of a folder those that end in .scene, hidden ones left out."""
    found: dict[str, str] = {}
    for name in names:
        programs = [name]
        if name != "-" and os.path.isdir(name):
            programs = [str(path) for path in _programs(Path(name))] or [name]
        for each in programs:
            found.setdefault(each if each == "-" else os.path.realpath(each), each)
    return list(found.values())


def _programs(folder: Path) -> list[Path]:
    found = [path for path in folder.rglob("*.scene") if path.is_file()]
    return sorted(p for p in found if not any(part.startswith(".") for part in p.relative_to(folder).parts))


def is_scene_file(source: Source) -> bool:
    """Whether a source is a scene as JSON rather than a program."""
    return source.name.endswith(".json")


def is_python(source: Source) -> bool:
    """Whether a source is a language model's Python: by its ending; standard input by what it holds."""
    if source.name.endswith((".py", ".txt")):
        return True
    return source.name.startswith("<") and bool(_REGISTERS.search(source.text))


def _outside_library(diagnostic: Diagnostic) -> Diagnostic:
    """An error inside a function of the standard library, shown where the program called it."""
    if diagnostic.span is None or not diagnostic.span.source.name.startswith(STD):
        return diagnostic
    for _, place in diagnostic.chain:
        if place is not None and not place.source.name.startswith(STD):
            note = Note("the standard library was here", diagnostic.span)
            return replace(diagnostic, span=place, notes=(note, *diagnostic.notes))
    return diagnostic


def _too_deep(limits: Limits, error: RecursionError) -> Diagnostic:
    """The error for a recursion without end; the innermost calls are read off Python's own stack."""
    innermost: deque[FrameType] = deque(maxlen=_KEPT_FRAMES)
    traceback = error.__traceback__
    while traceback is not None:
        innermost.append(traceback.tb_frame)
        traceback = traceback.tb_next
    chain: list[tuple[str, Span | None]] = []
    running: str | None = None
    for frame in reversed(innermost):
        names = frame.f_locals
        function, word, span = names.get("function"), names.get("name"), names.get("span")
        if frame.f_code.co_name == "call" and isinstance(word, str):
            running = f'"{word}"'
        elif isinstance(function, Closure) and not function.code.name.startswith('"'):  # words are told by `call`
            running = f"`{function.code.name}`"
        if running is not None and isinstance(span, Span):
            chain.append((running, span))
            running = None
    hint = "is there a recursion without end? raise the limit with --max-depth"
    return Diagnostic(
        "depth",
        f"calls were nested deeper than {limits.depth:,}",
        chain[0][1] if chain else None,
        hint,
        (),
        tuple(chain),
    )


def settled(diagnostics: Iterable[Diagnostic], sources: Iterable[Source]) -> tuple[Diagnostic, ...]:
    """What users get to see of what was found: each thing once, by place, without what comments allow."""
    return tuple(with_fixes(d) for d in _sorted(not_allowed(diagnostics, sources)))


def _sorted(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Errors and warnings by place, each once."""
    unique: dict[Any, Diagnostic] = {}
    names: set[str] = set()  # reported as undefined: one line for a name, however often it is used
    for d in sorted(diagnostics, key=lambda d: d.span.start if d.span else -1):
        place = (d.span.source.name, d.span.start) if d.span else ("", -1)
        if d.name == "unbound":
            if d.message in names:
                continue
            names.add(d.message)
        unique.setdefault((place, d.name, d.message), d)
    return [unique[key] for key in sorted(unique, key=lambda k: k[0])]


def _imports(path: Path, names: set[str]) -> bool:
    """Whether a file says that it imports one of the files ``names``."""
    try:
        data = read_regular(path, _LARGEST_IMPORTER + 1)
        text = data.decode("utf-8") if len(data) <= _LARGEST_IMPORTER else ""
    except (OSError, ValueError):
        return False
    return any(match[1].removeprefix("./") in names for match in IMPORT_FORM.finditer(text))


def _reading_hint(error: Exception) -> str | None:
    """What to do about a file that cannot be read as a program."""
    number = getattr(error, "errno", None)
    if number == errno.EISDIR:
        return "name a file in it; `check` and `fmt` take folders"
    return "`-` reads standard input" if number == errno.EINVAL else None


def _read_source(path: str, shown: str) -> Source:
    try:
        if path == "-":
            data = sys.stdin.buffer.read(_LARGEST_FILE + 1)
        else:
            data = read_regular(path, _LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it is not a path"
        raise SceneError("file", f"cannot read {shown}: {reason}", _reading_hint(error)) from None
    if len(data) > _LARGEST_FILE:
        raise SceneError("file", f"{shown} is larger than {_LARGEST_FILE:,} bytes, which no program is")
    name = "<stdin>" if path == "-" else shown
    try:
        return Source(name, data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise SceneError(
            "encoding", f"{name} is not UTF-8 text (line {line}, byte {error.start + 1})", "save it as UTF-8"
        ) from None


def _value_datum(name: str, text: str) -> Datum:
    """The literal that ``--define name=text`` gives; a bare word is a string."""
    result = read(Source(f"<--define {name}>", text))
    if len(result.forms) == 1 and not result.diagnostics:
        form = result.forms[0]
        if isinstance(form, Atom) and isinstance(form.value, Symbol):
            return Atom(str(form.value), form.span)
        if not isinstance(form, ListDatum):
            return form
    raise SceneError(
        "param", f"--define {name}: `{text[:60]}` is no value", 'give a number, "string", #t, #f or [array]'
    )


# A program while somebody edits it: every version checked, only what changed looked at again.


_MACRO_LIMITS = replace(MACRO_LIMITS, seconds=2.0, memory=1_000_000_000)  # somebody waits
_TRIAL_LIMITS = replace(_MACRO_LIMITS, seconds=4.0)  # with what is checked beside the macros
_PROCEDURAL = "define-macro"


@dataclass(frozen=True, slots=True, eq=False)
class VersionAnalysis:
    """A version of a text and what ``Session.check`` says of it. ``version`` is None when it is nested too deeply."""

    source: Source
    version: Version | None
    diagnostics: tuple[Diagnostic, ...]


class Editing:
    """One file that is open in an editor. ``texts`` holds what other open files say, by resolved path."""

    def __init__(self, session: Session, texts: dict[Path, str] | None = None) -> None:
        self.session = session
        self.texts = texts if texts is not None else {}
        self._versions = Versions(prelude_of(session.library))
        self._imported: tuple[str, ...] | None = None  # the texts of imported files, None when not known

    def check(self, source: Source) -> VersionAnalysis:
        """Analyse the next version; never raises for a mistake in the program. Macros that are procedures run in a copy
        of this process first, which can be ended."""
        problem = trial(lambda: self._try(source)) if self._may_run_macros(source) else None
        if problem is not None:
            return VersionAnalysis(source, None, (_in_source(problem, source),))
        try:
            return run_with_room(lambda: self._check(source), EXPANSION_DEPTH)
        except RecursionError:
            self._versions = Versions(prelude_of(self.session.library))
            problem = Diagnostic("nesting", "the program is nested too deeply", Span(source, 0, 1))
            return VersionAnalysis(source, None, (problem,))

    def _may_run_macros(self, source: Source) -> bool:
        """Whether the text, or a file that it imports, may define macros by procedures."""
        if _PROCEDURAL in source.text:
            return True
        if IMPORT_FORM.search(source.text) is None:
            return False
        return self._imported is None or any(_PROCEDURAL in text for text in self._imported)

    def _try(self, source: Source) -> None:
        with limited(_TRIAL_LIMITS):
            run_with_room(lambda: self._check(source), EXPANSION_DEPTH, folders=self.session.folders(source))

    def _check(self, source: Source) -> VersionAnalysis:
        runner = macro_runner(self.session.library, _MACRO_LIMITS)
        version = self._versions.analyse(source, self.session.importer(source, self.texts), runner)
        program = version.program
        found = [*program.diagnostics, *self.session.warnings(program)]
        sources = (source, *program.sources[1:])
        self._imported = tuple(each.text for each in program.sources[1:])
        return VersionAnalysis(source, version, settled((version.diagnostic(d) for d in found), sources))


def _in_source(problem: Diagnostic, source: Source) -> Diagnostic:
    """A problem of another process at its place in our text, or at the beginning of it."""
    span = problem.span
    if span is None or span.source.name != source.name:
        return replace(problem, span=Span(source, 0, 1), chain=())
    line, column = span.source.position(span.start)
    start = min(source.line_start(line) + column - 1, len(source.text))
    return replace(problem, span=Span(source, start, start + max(1, span.end - span.start)), chain=())
