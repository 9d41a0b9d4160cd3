"""Session shared by the command line, the REPL, editors and language-model loops: checks and evaluates programs.

It combines the standard library with the interpreter; the semantics of the language are implemented there."""

from __future__ import annotations

import errno
import os
import re
import sys
import threading
from codecs import BOM_UTF8
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from scenelang.backends.files import read_regular, rewrite
from scenelang.grammar.ast import check_strict
from scenelang.grammar.datum import (
    Atom,
    Datum,
    ListDatum,
    Source,
    Span,
    Symbol,
    dataclass,
    field,
    is_deeper,
    rare_collection,
    replace,
    walk,
    with_edits,
)
from scenelang.grammar.diagnostics import (
    CODES,
    Diagnostic,
    Note,
    SceneError,
    UsageError,
    error_of,
    moved_diagnostic,
)
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import MAX_NESTING, read, read_pieces
from scenelang.grammar.settings import typed
from scenelang.interpreter.checker.book import findings
from scenelang.interpreter.checker.lint import (
    apply_fixes,
    confirmed,
    find_root,
    lint,
    lint_forms,
    with_fixes,
    without_consequences,
    without_suppressed,
    word_warnings,
)
from scenelang.interpreter.checker.program import Program, load_program
from scenelang.interpreter.checker.setup_forms import setup_problems
from scenelang.interpreter.runtime.types import STD, Library
from scenelang.interpreter.values.limits import Limits, fork_safe_lock, recursion_room
from scenelang.sandbox.supervision import limited, link, spent_seconds
from scenelang.stdlib.library import build_library

if TYPE_CHECKING:
    from pathlib import Path

    from scenelang.backends.surfaces.assets import AssetFiles
    from scenelang.interpreter.evaluation.interactive import TopLevel
    from scenelang.interpreter.expand.expand import RunMacro
    from scenelang.interpreter.runtime.runtime import Runtime, ZEntry
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Scene
    from scenelang.interpreter.scene.modelling.outlines import Typeface
    from scenelang.interpreter.scene.primitives.mesh_file import Asset


T = TypeVar("T")
IMPORT_FORM = lazy_pattern(r'\(import\s+"([^"\n]*)"')
_REGISTERS = lazy_pattern(r"^[ \t]*@register", re.M)
_STACK_BYTES = 512 * 1024 * 1024  # of a thread: room for EXPANSION_DEPTH calls
_STACK_BYTES_PER_CALL = 8 * 1024  # assumed of a Python call
_STARTING = fork_safe_lock()  # threading.stack_size is a process-wide setting
_MAX_FILE_SIZE = 16_000_000  # bytes of a program
MACRO_LIMITS = Limits(steps=2_000_000, seconds=10.0, depth=20_000)  # of macros, which run in a check
EXPANSION_DEPTH = 60_000  # Python frames: expansion and compilation recurse over forms, whose depth the reader bounds
_MAX_AUTOFIXES = 20  # of one text, each with a check: one fix may enable another
# A missing bracket is looked for by indentation, then by meaning. Every candidate text (up to 16 for each broken
# chunk) is checked, which the command `check` does, and editors where the text rests: they check at every key.
_MAX_RECOVERED_LENGTH = 30_000  # characters
_MAX_IMPORTERS = 300  # neighboring files that may import a program
_MAX_IMPORTER_SIZE = 500_000  # bytes


@dataclass(frozen=True, slots=True)
class Options:
    """Options for reading and evaluating programs.

    Parameters
    ----------
    root : str, optional
        Word to evaluate.
    seed : int
        Random seed.
    defines : mapping
        Values that override params, as source text by name.
    limits : Limits
        Limits of time, memory and size.
    project : Path, optional
        Folder to which imports are restricted; default: the main file's folder.
    allow_outside : bool
        Allow imports from outside the project folder.
    imports : set of Path, optional
        Only files that may be imported; None allows all files in the project.
    strict : bool
        Require the paper's grammar.
    z_entries : mapping
        Embeddings by handle name.
    """

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
    """Split ``NAME=VALUE`` into name and text; raises UsageError."""
    name, sign, text = item.partition("=")
    if not sign or not name:
        parts = item.strip().replace(":", " ").split()
        written = "=".join(parts) if len(parts) == 2 else f"{item}=VALUE"
        hint = f"write `--define {written}`" if item.strip() and not sign else "such as `--define legs=3`"
        raise UsageError("param", f"expected NAME=VALUE for --define, got `{item}`", hint)
    return name.strip(), text


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """Result of a check: the program and its diagnostics in source order."""

    program: Program | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def ok(self) -> bool:
        """Whether there are no errors."""
        return not any(d.is_error for d in self.diagnostics)


@dataclass(frozen=True, slots=True, eq=False)
class Evaluated:
    """Result of an evaluation.

    Attributes
    ----------
    program
        The program; None for a scene in JSON.
    scene
        The scene; None if there were errors.
    diagnostics
        Errors and warnings in source order.
    log
        Printed lines.
    steps
        Steps of the evaluator, the unit of ``Limits.steps``.
    draws
        Whether it used random numbers; if not, the scene is the same for every seed.
    subject
        Entity or mesh that an error is about, so that `check --picture` can draw it.
    """

    program: Program | None = field(repr=False)
    scene: Scene | None
    diagnostics: tuple[Diagnostic, ...]
    log: tuple[str, ...] = ()
    steps: int = 0
    draws: bool = True
    subject: Any = field(default=None, repr=False)

    @property
    def ok(self) -> bool:
        """Whether there is a scene."""
        return self.scene is not None

    def require(self) -> Scene:
        """Return the scene; raises SceneError with the first error if there is none."""
        if self.scene is None:
            raise error_of(next(d for d in self.diagnostics if d.is_error))
        return self.scene


def _has_room(depth: int) -> bool:
    """Return whether this is the main thread, with a stack for calls of this depth (``ulimit -s``).

    A browser's interpreter has one thread; the playground gives it a depth for which there is room.
    """
    if sys.platform == "emscripten":
        return True
    try:
        import resource
    except ImportError:  # Windows
        return False
    size, _ = resource.getrlimit(resource.RLIMIT_STACK)
    is_large = size == resource.RLIM_INFINITY or size >= min(_STACK_BYTES, depth * _STACK_BYTES_PER_CALL)
    return is_large and threading.current_thread() is threading.main_thread()


def run_with_room(
    action: Callable[[], T], depth: int, cancel: Callable[[], None] | None = None, folders: tuple[str, ...] = ()
) -> T:
    """Run ``action`` with a large stack for deep recursion: in a thread, unless the main thread's stack suffices.

    Parameters
    ----------
    depth
        Python frames that it may need.
    cancel
        Called at Ctrl-C, before waiting for the thread to end; a second Ctrl-C does not wait.
    folders
        In a supervised process, the thread may only read these folders and has no other access to the file system.
    """
    watched = link()
    if watched is None and _has_room(depth):
        with recursion_room(depth):
            return action()
    outcome: list[Any] = []
    done = threading.Event()  # Thread.join cannot be used: in Python 3.11 Ctrl-C marks the thread as ended

    def target() -> None:
        """Record the result or the exception of the action."""
        try:
            with recursion_room(depth), watched.evaluating(folders) if watched is not None else nullcontext():
                outcome.append((True, action()))
        except BaseException as error:
            outcome.append((False, error))
        finally:
            done.set()

    with _STARTING:
        old = threading.stack_size(_STACK_BYTES)
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


def macro_runner(library: Library, limits: Limits, started: Callable[[Runtime], None] | None = None) -> RunMacro:
    """Return a function that runs the bodies of macros; the evaluator is imported when there is one to run."""
    runners: list[RunMacro] = []

    def run(function: Datum, arguments: list[Any]) -> tuple[Any, bool]:
        """Run a macro, with a runner that is created for the first one."""
        if not runners:
            from scenelang.interpreter.evaluation.evaluate import macro_runner

            runners.append(macro_runner(library, limits, started))
        return runners[0](function, arguments)

    return run


def _spliced(datum: Datum) -> Iterator[Datum]:
    """Yield the forms of a `begin` at top level, where they are forms of the program, and any other form itself."""
    if not (isinstance(datum, ListDatum) and datum.items and isinstance(datum.items[0], Atom)):
        yield datum
    elif datum.items[0].value == Symbol("begin") and len(datum.items) > 1 and datum.tail is None:
        for item in datum.items[1:]:
            yield from _spliced(item)
    else:
        yield datum


class Session:
    """Checks and evaluates programs under one set of options: all that leads from a text to its scene.

    The command line, the Python API, editors and servers work through it. A session keeps nothing of a program, so one
    can check and evaluate many, and the same one again after an edit.

    Attributes
    ----------
    options : Options
        Root, seed, values of params, limits, and which files may be imported.
    library : Library
        The builtins of the standard library, and the definitions that programs can import.

    Examples
    --------
    >>> session = Session()
    >>> source = Source("tower.scene", '(bind "tower" (lambda () (call "cube")))')
    >>> session.check(source).ok
    True
    >>> session.evaluate(source).require().frames[0].word
    'tower'
    """

    def __init__(self, options: Options | None = None) -> None:
        self.options = options or Options()
        self.library = build_library()

    # --- sources ---------------------------------------------------------------------------------------------------

    @typed
    def source(self, path: str) -> Source:
        """Read a file, or standard input for ``-``; raises SceneError if it cannot be read."""
        return _read_source(path, path)

    @staticmethod
    def _folder(main: Source) -> Path:
        """Return the folder of a file; the current folder for a text without one."""
        from pathlib import Path

        return Path(main.name).parent if not main.name.startswith("<") else Path.cwd()

    def _project(self, main: Source) -> Path:
        """Return the folder to which imports are restricted: the option's, else the main file's."""
        return (self.options.project or self._folder(main)).resolve()

    def _assets(self, main: Source) -> AssetFiles:
        """Return the resolver of the program's mesh files."""
        from scenelang.backends.surfaces.assets import AssetFiles

        return AssetFiles(self._folder(main), self._project(main), self.options.allow_outside)

    def _measure_asset(self, main: Source) -> Callable[[str, Callable[[int], None]], Asset]:
        """Return the function that measures a mesh file.

        Its arguments are the file, as the program names it, and a function that counts steps of work. The readers of
        mesh formats are imported at the first call.
        """
        files = cache(lambda: self._assets(main))
        return lambda file, charge: files().measure(file, charge)

    def _locate_image(self, main: Source) -> Callable[[str, Callable[[int], None]], str]:
        """Return the function that checks an image of a texture and returns its path."""
        return lambda file, charge: self._assets(main).image(file, charge)

    def _load_font(self, main: Source) -> Callable[[str, Callable[[int], None]], Typeface]:
        """Return the function that loads a font file within the project.

        The font library is imported at the first call.
        """

        def load(file: str, charge: Callable[[int], None]) -> Typeface:
            """Load the font ``file``, as the program names it; ``charge`` counts steps of work."""
            from scenelang.interpreter.scene.modelling.outlines import FontFiles

            return FontFiles(self._folder(main), self._project(main), self.options.allow_outside).load(file, charge)

        return load

    def folders(self, main: Source) -> tuple[str, ...]:
        """Return the folders that an evaluation may read, in addition to the package."""
        if self.options.allow_outside:
            return ("/",)
        folder = (os.path.dirname(main.name) if not main.name.startswith("<") else "") or os.curdir
        return tuple(map(os.path.realpath, (self.options.project or folder, folder)))

    def importer(self, main: Source, texts: Mapping[Path, str] | None = None) -> Callable[[str, Source, Span], Source]:
        """Return a function that loads imported files relative to the importing file, within the project folder.

        ``texts`` contains the unsaved texts of files open in an editor, by resolved path.
        """

        def load(path: str, importing: Source, span: Span) -> Source:
            """Read the file of an ``import`` form at ``span``, after checking that it may be read."""
            from pathlib import Path

            from scenelang.interpreter.scene.primitives.mesh_file import is_hidden

            project = self._project(main)
            folder = Path(importing.name).parent if not importing.name.startswith("<") else Path.cwd()
            try:
                target = (folder / path).resolve()
            except (OSError, ValueError, RuntimeError):
                raise SceneError("file", f"invalid path `{path[:80]}`", None, span) from None
            if not self.options.allow_outside and not target.is_relative_to(project):
                hint = "imports are restricted to the project folder; --allow-outside permits others"
                raise SceneError("import-outside", f"`{path}` is outside the project folder {project}", hint, span)
            if not self.options.allow_outside and is_hidden(target, project):
                hint = "hidden files are not imported; --allow-outside permits them"
                raise SceneError("import-outside", f"`{path}` is hidden", hint, span)
            shown = os.path.relpath(target)
            if self.options.imports is not None and target not in self.options.imports:
                raise SceneError(
                    "import-outside", f"import of `{path[:80]}` is not allowed for this program", None, span
                )
            if texts and target in texts:
                return Source(shown, texts[target])
            try:
                return _read_source(str(target), shown)
            except SceneError as error:
                error.span = span
                raise

        return load

    # --- checking ----------------------------------------------------------------------------------------------

    @typed
    def check(self, source: Source) -> Checked:
        """Parse, expand and analyze a program; errors are returned as diagnostics and never raised."""
        if is_scene_file(source):
            return Checked(None, self._read_scene(source).diagnostics)
        try:
            with limited(self.options.limits), rare_collection():
                if is_python(source):
                    front_end = front_end_of(source)
                    check = partial(front_end.check, self, source)
                else:
                    check = partial(self.check_forms, source)
                return run_with_room(check, EXPANSION_DEPTH, folders=self.folders(source))
        except RecursionError:
            return Checked(None, (Diagnostic("nesting", "the program is nested too deeply", Span(source, 0, 1)),))

    @typed
    def autofix(self, source: Source) -> tuple[Source, int]:
        """Apply all safe fixes, repeatedly, because one fix may enable another.

        Returns
        -------
        source, number
            The fixed source, and the number of fixes.
        """
        total = 0
        for _ in range(_MAX_AUTOFIXES):
            text, number = apply_fixes(source, self.check(source).diagnostics)
            if not number:
                break
            source, total = Source(source.name, text), total + number
        return source, total

    @typed
    def fix_file(self, path: str) -> tuple[Source, int]:
        """Apply ``autofix`` to a file in place; raises SceneError if it cannot be read or written."""
        from pathlib import Path

        source, number = self.autofix(self.source(path))
        if number:
            mark = "\ufeff" if read_regular(path, 3).startswith(BOM_UTF8) else ""
            rewrite(Path(path), mark + source.text)
        return source, number

    def expansion(self, program: Program) -> str:
        """Return the text of a program after macro expansion."""
        try:
            return run_with_room(lambda: self._expansion(program), EXPANSION_DEPTH)
        except RecursionError:
            raise SceneError("nesting", "the expansion is nested too deeply to be printed") from None

    def _expansion(self, program: Program) -> str:
        """Lay out the expanded forms; raises SceneError if they are nested too deeply to be read again."""
        from scenelang.grammar.layout import layout
        from scenelang.interpreter.checker.setup_forms import is_setup
        from scenelang.interpreter.compile.analyze import mentioned
        from scenelang.interpreter.compile.unparse import unparse
        from scenelang.interpreter.expand.forms import INDENTS

        own = set(map(id, program.own_forms))  # cameras and lights of imported files are not those of the program
        forms = [form for form in program.forms if id(form) in own or not is_setup(form)]
        forms += [program.scene] if program.scene else []
        params = {param.span for param in program.params}
        imports = (f'(import "{module}")' for module in self.library_imports(program))
        datums: list[Datum] = list(read(Source("<expansion>", "\n".join(imports))).forms)
        spelling: dict[int, str] = {}
        uninlined = frozenset(variable for form in forms if form.span in params for variable in mentioned(form))
        for datum, form in zip(unparse(forms, uninlined), forms, strict=True):
            if form.span in params:  # unchanged, so that --define works on the expansion too
                (datum,) = read(Source(form.span.source.name, form.span.text)).forms
                spelling |= {id(atom): atom.span.text for atom in walk(datum) if isinstance(atom, Atom)}
            elif form is program.scene and isinstance(datum, ListDatum):
                datum = ListDatum((Atom(Symbol("scene"), datum.span), *datum.items[1:]), None, datum.span)
            datums += _spliced(datum)
        if is_deeper(datums, MAX_NESTING):
            message = f"the expansion has more than {MAX_NESTING:,} levels of parentheses, which could not be read"
            raise SceneError("nesting", message)
        return layout(datums, indents=INDENTS, spelling=spelling)

    @typed
    def transpile(self, source: Source, literal: bool = False) -> TranslatedProgram:
        """Translate a language model's response, or its Python, and check the program; errors are never raised.

        The text is lifted to a program as a person would write it, unless ``literal`` is true.
        """
        return front_end_of(source).transpile(self, source, literal)

    @typed
    def lift(self, source: Source) -> tuple[str | None, Sequence[Diagnostic]]:
        """Return the text of an equal program that is easier to read, or None, and the diagnostics of the program."""
        return front_end_of(source).lift(self, source)

    def recovered(self, source: Source, checked: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
        """Return the diagnostics of a text whose brackets may not match.

        Brackets are assumed where they fit the indentation and the calls best. The diagnostics have fixes that add or
        remove these brackets, and those of the code behind them are reported too.

        Parameters
        ----------
        source
            The text.
        checked
            Diagnostics of its check; they are returned if its brackets match.
        """
        if not any(d.is_error for d in checked) or len(source.text) > _MAX_RECOVERED_LENGTH or is_python(source):
            return checked
        from scenelang.grammar.recovery import wrong_chunks

        is_foreign = any(d.name == "foreign-syntax" for d in checked)
        text = apply_fixes(source, checked)[0] if is_foreign else source.text
        if not (wrong_chunks(text) and wrong_chunks(source.text)):
            return checked
        try:
            with limited(self.options.limits), rare_collection():
                work = partial(self._recovered, source, Checked(None, tuple(checked)))
                return run_with_room(work, EXPANSION_DEPTH, folders=self.folders(source)).diagnostics
        except RecursionError:
            return checked

    def _recovered(self, source: Source, checked: Checked) -> Checked:
        """Return the diagnostics of a text with brackets added or removed, with the fixes that do so.

        Of the edits that contradict the fewest lines of the indentation, those with the fewest errors and warnings are
        chosen, the last of equals. Nothing changes if errors of another kind say more, as in a text of another
        language.
        """
        from scenelang.grammar.recovery import MAX_CHUNKS, Recovered, bracket_edits, quote_edits, wrong_chunks

        best, recovered = Recovered(source, source), checked
        while chunks := wrong_chunks(best.source.text):
            # Of equal edits, `min` takes the first: the shortest string, or the last bracket.
            edits = quote_edits(best.source.text) or bracket_edits(chunks[0])[::-1]
            trials = [best.edited(edit) for edit in edits]
            if not trials or len(best.edits) == MAX_CHUNKS:
                return checked
            results = [self.check_forms(trial.source) for trial in trials]
            chosen = min(range(len(trials)), key=lambda i: _weight(results[i]))
            best, recovered = trials[chosen], results[chosen]
        is_about_brackets = any(d.name in ("unclosed", "extra-close") for d in checked.diagnostics)
        if not is_about_brackets and _weight(recovered)[0] > _weight(checked)[0]:
            return checked
        problems = best.explained([with_fixes(d) for d in read_pieces(source).diagnostics], recovered.ok)
        behind = [d for d in recovered.diagnostics if d.is_error or d.fixes]  # other warnings wait
        moved_behind = [moved_diagnostic(d, best.original) for d in behind]
        return Checked(checked.program, tuple(_sorted([*problems, *moved_behind])))

    def rebracketed(self, source: Source, checked: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
        """Return diagnostics in which an error of a call whose bracket closes too early or too late says so.

        Brackets that match may still close in the wrong place, so that an argument is in the wrong call. A bracket is
        moved where the program has fewer errors with it, and no other ones.
        """
        errors = [d for d in checked if d.is_error]
        wrong = [d for d in errors if d.name in _OF_CALLS and d.span is not None and _GENERAL_HINT.match(d.hint or "")]
        if not wrong or len(source.text) > _MAX_RECOVERED_LENGTH or any(d.code.startswith("E1") for d in errors):
            return checked
        from scenelang.grammar.recovery import moved_brackets

        replaced: dict[int, Diagnostic] = {}
        known = {(d.name, d.message) for d in errors}
        for error in wrong[:_MAX_REBRACKETED]:
            assert error.span is not None
            # `(ref (set 1 2) 0)` has the wrong type, and `(ref (set 1) 2 0)` would have none
            for fix, hint in moved_brackets(error.span, only_lists=error.name == "type"):
                trial = Source(source.name, with_edits(source.text, fix.text_edits))
                left = [d for d in self.check(trial).diagnostics if d.is_error]
                remaining = {(d.name, d.message) for d in left}
                if len(left) < len(errors) and remaining <= known - {(error.name, error.message)}:
                    replaced[id(error)] = replace(error, hint=hint, fixes=(fix,))
                    break
        return [replaced.get(id(d), d) for d in checked]

    def check_forms(
        self,
        source: Source,
        forms: Sequence[Datum] | None = None,
        problems: Sequence[Diagnostic] = (),
    ) -> Checked:
        """Check a program on the current stack; errors are returned as diagnostics and never raised.

        Parameters
        ----------
        source : Source
            The program, or the text in another language that it was translated from.
        forms : sequence of Datum, optional
            The translated program; None reads the text of ``source``.
        problems : sequence of Diagnostic
            Diagnostics of the translation, which are added to those of the program.
        """
        try:
            overrides = {name: value_datum(name, text) for name, text in self.options.defines.items()}
        except SceneError as error:
            return Checked(None, (error.diagnostic,))
        watched = link()
        if watched is not None:
            watched.note(Span(source, 0, 1))
        program = self.load(source, forms, overrides)
        diagnostics = [*problems, *program.diagnostics]
        if self.options.strict and program.ok:
            try:
                check_strict(read(source).forms if forms is None else forms)
            except SceneError as error:
                diagnostics.append(error.diagnostic)
        diagnostics += self.warnings(program, is_written=forms is None)
        return Checked(program, settled(diagnostics, program.sources, program))

    def load(
        self, source: Source, forms: Sequence[Datum] | None = None, overrides: Mapping[str, Datum] | None = None
    ) -> Program:
        """Read and expand a program without checking it.

        Parameters
        ----------
        forms : sequence of Datum, optional
            As for ``check_forms``.
        overrides : mapping, optional
            Values of params by name, which replace their defaults.
        """
        runner = macro_runner(self.library, self._macro_limits)
        return load_program(source, self.library, self.importer(source), runner, overrides or {}, forms)

    def warnings(
        self, program: Program, is_written: bool = True, kind_errors: Sequence[Diagnostic] | None = None
    ) -> list[Diagnostic]:
        """Return errors of value kinds, and the lint warnings of a program without errors.

        Parameters
        ----------
        is_written : bool
            False for programs translated from Python: errors are in terms of Python, and neither unused definitions nor
            the layout of the text are reported.
        kind_errors : sequence of Diagnostic, optional
            The errors of value kinds, where those of the same forms are known.
        """
        word, root = self._root_or_problem(program)
        if kind_errors is None:
            kind_errors = self.kind_errors(program, is_written)
        if not is_written:
            return [*kind_errors, *word_warnings(program), *root] if program.ok else [*kind_errors]
        if not program.ok:
            return [*kind_errors, *lint_forms(program)]

        def is_scene() -> bool:
            """Return whether the program is a scene, not a library; reads other files, so only on demand."""
            return word is not None and not root and not self._is_imported(program.main)

        warnings = lint(program, is_scene)
        if self.options.root is not None:  # other words are other variants of the program
            warnings = [warning for warning in warnings if warning.name != "unreachable-word"]
        return [*kind_errors, *warnings, *root]

    def kind_errors(self, program: Program, is_written: bool = True) -> list[Diagnostic]:
        """Return errors of value kinds and of cameras, lights and settings; ``is_written`` as for ``warnings``."""
        word, _ = self._root_or_problem(program)
        if is_written:
            return [*findings(program, word, is_written=True), *setup_problems(program)]
        in_python = python_front_end().in_python
        return [in_python(d) for d in findings(program, word, is_written=False)] + setup_problems(program)

    def _root_or_problem(self, program: Program) -> tuple[str | None, list[Diagnostic]]:
        """Return the root's word with warnings about its choice; None with the error if there is none to choose."""
        try:
            return self.root_of(program)
        except SceneError as error:
            return None, [] if error.name == "no-root" else [error.diagnostic]

    def _is_imported(self, source: Source) -> bool:
        """Return whether a program in the same or the parent folder imports this one."""
        from pathlib import Path

        if source.name.startswith("<"):
            return False
        path = Path(source.name).resolve()
        names = {path.name, f"{path.parent.name}/{path.name}"}
        neighbors = [*path.parent.glob("*.scene"), *path.parent.parent.glob("*.scene")][:_MAX_IMPORTERS]
        return any(other != path and _imports(other, names) for other in neighbors)

    def root_of(self, program: Program) -> tuple[str, list[Diagnostic]]:
        """Return the root's word and warnings about its choice; raises SceneError if there is none."""
        if self.options.root is not None:
            return self.options.root, []
        return find_root(program)

    def library_imports(self, program: Program) -> list[str]:
        """Return the standard library modules that a program imports, such as ``std/python.scene``."""
        modules = {f"{STD}{module}" for module in self.library.imported}
        return [source.name for source in program.sources if source.name in modules]

    # --- evaluating --------------------------------------------------------------------------------------------

    @typed
    def evaluate(self, source: Source) -> Evaluated:
        """Check and run a program, or read a JSON scene; errors are returned as diagnostics and never raised."""
        with limited(self.options.limits):
            return self._evaluate(source)

    def _evaluate(self, source: Source) -> Evaluated:
        """Evaluate a program, a language model's Python or a JSON scene, within limits that are already set."""
        if is_scene_file(source):
            return self._read_scene(source)
        if is_python(source):
            return front_end_of(source).evaluate(self, source)
        return self.evaluate_checked(source, self.check(source))

    def evaluate_checked(self, source: Source, checked: Checked) -> Evaluated:
        """Run a program that was checked; errors are returned as diagnostics and never raised."""
        program = checked.program
        if program is None or not (checked.ok or may_run(program, checked.diagnostics)):
            return Evaluated(program, None, checked.diagnostics)
        runtime = self.runtime_of(source)
        runtime.meter.reset(spent_seconds())
        run = partial(self._run, program, runtime)
        try:
            scene = run_with_room(run, self.options.limits.depth, runtime.meter.cancel, self.folders(source))
            problem = subject = None
        except (SceneError, RecursionError, MemoryError) as error:
            scene, problem, subject = None, self.problem_of(error), getattr(error, "subject", None)
        if problem is not None and self.options.z_entries:
            # Entries change what the program computes, so one may be the cause.
            used = ", ".join(f"<{name}>" for name in list(self.options.z_entries)[:8])
            note = Note(f"embeddings are applied to {used}; remove one with `embeddings FILE set HANDLE --clear`")
            problem = replace(problem, notes=(*problem.notes, note))
        warnings = without_suppressed(runtime.warnings.values(), program.sources)
        diagnostics = confirmed(checked.diagnostics, problem, warnings)
        draws = runtime.streams.was_used
        return Evaluated(program, scene, tuple(diagnostics), tuple(runtime.log), runtime.meter.total, draws, subject)

    def check_geometry(self, source: Source) -> list[Diagnostic]:
        """Evaluate a program and run the geometry lint on its scene; returns the diagnostics of both."""
        from scenelang.interpreter.plugins import SERVICES

        with limited(self.options.limits):
            result = self.evaluate(source)
            return [*result.diagnostics, *linted(result, SERVICES.find("geometry"))]

    def declarations(self, source: Source) -> tuple[Declaration, ...]:
        """Return the declarations at the top level of a file; raises SceneError with its first error.

        Options of the program that they are about, such as values of its params, do not apply to the file.
        """
        if self.options.defines or self.options.root or self.options.z_entries:
            return Session(replace(self.options, defines={}, root=None, z_entries={})).declarations(source)
        with limited(self.options.limits):
            checked = self.check(source)
            wrong = next((d for d in checked.diagnostics if d.is_error and d.name != "root"), None)
            if wrong is not None or checked.program is None:
                raise error_of(wrong or checked.diagnostics[0])
            runtime, program = self.runtime_of(source), checked.program
            run = partial(_run_forms, self.library, runtime, program)
            run_with_room(run, self.options.limits.depth, runtime.meter.cancel, self.folders(source))
            return tuple(runtime.declarations)

    @property
    def _macro_limits(self) -> Limits:
        """Limits for running macro expanders.

        These are the macro limits, capped by the program's memory and by slightly more than its CPU time, so that the
        program's own limit is reported first.
        """
        program_limits = self.options.limits
        return replace(
            MACRO_LIMITS,
            seconds=min(MACRO_LIMITS.seconds, program_limits.seconds + 1.0),
            memory=min(MACRO_LIMITS.memory, program_limits.memory),
        )

    def top_level(self, main: Source, started: Callable[[Runtime], None]) -> TopLevel:
        """Create an interactive top level in the context of the file ``main``.

        Parameters
        ----------
        started
            Called with each runtime in which macros run, so that it can be cancelled.

        Raises
        ------
        SceneError
            If a ``--define`` is malformed.
        """
        from scenelang.interpreter.evaluation.interactive import TopLevel
        from scenelang.interpreter.runtime.runtime import JournaledRuntime

        options, library = self.options, self.library
        overrides = {name: value_datum(name, text) for name, text in options.defines.items()}
        asset = self._measure_asset(main)
        runtime = JournaledRuntime(
            library,
            options.limits,
            options.seed,
            options.z_entries,
            asset=asset,
            font=self._load_font(main),
            image=self._locate_image(main),
        )
        new_macros = partial(macro_runner, library, self._macro_limits, started)
        return TopLevel(library, runtime, main, self.importer(main), new_macros, overrides)

    def problem_of(self, error: BaseException) -> Diagnostic | None:
        """Convert an exception that ended an evaluation to a diagnostic; None if the program did not cause it."""
        if isinstance(error, SceneError):
            return _outside_library(error.diagnostic)
        if isinstance(error, RecursionError):
            from scenelang.session.recursion import depth_error

            return depth_error(self.options.limits, error)
        if isinstance(error, MemoryError):
            hint = "the machine has no more memory; set a lower limit with --max-memory"
            return Diagnostic("memory", "the program ran out of memory", None, hint)
        return None

    def _read_scene(self, source: Source) -> Evaluated:
        """Read a scene exported as JSON."""
        from scenelang.files.scene_json import read_scene

        try:
            scene = read_scene(source.name, self._project(source), self.options.allow_outside)
        except SceneError as error:
            return Evaluated(None, None, (error.diagnostic,))
        return Evaluated(None, scene, ())

    def _run(self, program: Program, runtime: Runtime) -> Scene:
        """Run a program and apply embeddings."""
        from scenelang.interpreter.evaluation.evaluate import ProgramRun

        with rare_collection():
            try:
                word, _ = self.root_of(program)
            except SceneError:
                ProgramRun(self.library, runtime).run_forms(program)  # errors of the program take precedence
                raise
            scene = self._run_once(program, runtime, word)
            return self._with_entries(program, runtime, word, scene) if self.options.z_entries else scene

    def runtime_of(self, main: Source, snapshots: frozenset[int] = frozenset()) -> Runtime:
        """Create the runtime of a program.

        Parameters
        ----------
        main
            The program's file, to which paths of meshes and fonts are relative.
        snapshots
            Serial numbers of the calls at which the states of the random streams are recorded.
        """
        from scenelang.interpreter.runtime.runtime import Runtime

        options = self.options
        return Runtime(
            self.library, options.limits, options.seed, options.z_entries, snapshots=snapshots,
            asset=self._measure_asset(main), font=self._load_font(main), image=self._locate_image(main),
        )  # fmt: skip

    def _run_once(self, program: Program, runtime: Runtime, word: str) -> Scene:
        """Run the forms and the root; a supervisor is told where, for its report if it has to end the process."""
        from scenelang.interpreter.evaluation.evaluate import ProgramRun

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
        """Apply embeddings to entities with automatic handles.

        Handles are numbered after a run, so the program runs again to record the random streams at the entities
        concerned.
        """
        from scenelang.interpreter.inspection.numbering import apply_overrides, overrides_by_path, serials_at

        entries, unused = overrides_by_path(scene, self.options.z_entries)
        for name in unused:
            runtime.warn("unused-entry", f"the embedding `<{name}>` matches no entity of the scene")
        if not entries:
            return scene
        again = self.runtime_of(program.main, serials_at(scene, entries))
        grafted = apply_overrides(again, self._run_once(program, again, word), entries)
        runtime.warnings.update(again.warnings)
        return grafted


class TranslatedProgram(Protocol):
    """Program translated from a text in another language."""

    @property
    def text(self) -> str:
        """Text of the program; empty if the translation failed."""

    @property
    def ok(self) -> bool:
        """Whether the translation succeeded."""

    @property
    def diagnostics(self) -> Sequence[Diagnostic]:
        """Errors and warnings, at their positions in the translated text."""


class FrontEnd(Protocol):
    """Front end for another language: ``scenelang/translation/python_programs`` for a language model's Python."""

    def check(self, session: Session, source: Source) -> Checked:
        """As ``Session.check``, on the current stack."""

    def evaluate(self, session: Session, source: Source) -> Evaluated:
        """As ``Session.evaluate``."""

    def transpile(self, session: Session, source: Source, literal: bool) -> TranslatedProgram:
        """As ``Session.transpile``."""

    def lift(self, session: Session, source: Source) -> tuple[str | None, Sequence[Diagnostic]]:
        """As ``Session.lift``."""

    def in_python(self, diagnostic: Diagnostic) -> Diagnostic:
        """Return a diagnostic of a translated program in terms of its language."""

    def notebook_code(self, text: str, name: str) -> str:
        """Return the code of a Jupyter notebook; raises SceneError if it is malformed."""


def python_front_end() -> FrontEnd:
    """Return the front end for Python; raises SceneError("backend") if this installation has none."""
    from scenelang.interpreter.plugins import SERVICES

    front_end: FrontEnd = SERVICES.find("python")
    return front_end


def front_end_of(source: Source) -> FrontEnd:
    """Return the front end for a Python source: that for Blender scripts if it imports `bpy`."""
    from scenelang.interpreter.plugins import SERVICES

    if not imports_bpy(source.text):
        return python_front_end()
    front_end: FrontEnd = SERVICES.find("blender")
    return front_end


def linted(result: Evaluated, *lints: Callable[[Scene], list[Diagnostic]]) -> list[Diagnostic]:
    """Return what ``lints`` report about the scene of an evaluation, unless comments of the program suppress it."""
    if result.scene is None:
        return []
    reported: list[Diagnostic] = []
    for check in lints:
        try:
            reported += check(result.scene)
        except SceneError as error:
            reported.append(error.diagnostic)
    return without_suppressed(reported, result.program.sources if result.program is not None else ())


def _run_forms(library: Library, runtime: Runtime, program: Program) -> None:
    """Run the top level of a program without its root."""
    from scenelang.interpreter.evaluation.evaluate import ProgramRun

    ProgramRun(library, runtime).run_forms(program)


def is_scene_file(source: Source) -> bool:
    """Return whether a source is a scene in JSON rather than a program."""
    return source.name.endswith(".json")


def is_python(source: Source) -> bool:
    """Return whether a source is a language model's Python, by file extension, or by content for standard input."""
    if source.name.endswith((".py", ".txt", ".ipynb")):
        return True
    return source.name.startswith("<") and (bool(_REGISTERS.search(source.text)) or imports_bpy(source.text))


_IMPORTS_BPY = lazy_pattern(r"^[ \t]*(?:import[ \t]+(?:[\w.]+[ \t]*,[ \t]*)*bpy\b|from[ \t]+bpy\b)", re.M)


def imports_bpy(text: str) -> bool:
    """Return whether a text is a script for Blender, with or without prose around it."""
    return _IMPORTS_BPY.search(text) is not None


def _outside_library(diagnostic: Diagnostic) -> Diagnostic:
    """Move an error inside the standard library to the program's call."""
    if diagnostic.span is None or not diagnostic.span.source.name.startswith(STD):
        return diagnostic
    for name, place in diagnostic.chain:
        if place is not None and not place.source.name.startswith(STD):
            note = Note("in the standard library", diagnostic.span)
            message = diagnostic.message
            if name.strip('"`') not in message:
                message = f"{name} fails on these values: {message}"
            return replace(diagnostic, message=message, span=place, notes=(note, *diagnostic.notes))
    return diagnostic


def may_run(program: Program, diagnostics: Iterable[Diagnostic]) -> bool:
    """Return whether the only errors are those of kinds, which may concern code that a run never evaluates."""
    return program.ok and all(CODES[d.name].code[:2] in ("E4", "E6") for d in diagnostics if d.is_error)


_OF_CALLS = frozenset(("syntax", "arity", "keyword", "embedding", "attribute", "type", "parts", "pose"))
_GENERAL_HINT = lazy_pattern(r"\Z|call it as|for example|usage|its parameter|it takes")  # not about the mistake itself
_MAX_REBRACKETED = 2  # errors of a text whose brackets are moved; each costs up to a dozen checks


def _weight(checked: Checked) -> tuple[int, int, int]:
    """Rank a checked text by its errors, by those without a fix or about its syntax, and by its warnings."""
    errors = [d for d in checked.diagnostics if d.is_error]
    open_ = [d for d in errors if not d.fixes or d.name == "syntax"]
    return len(errors), len(open_), len(checked.diagnostics) - len(errors)


def settled(
    diagnostics: Iterable[Diagnostic], sources: Iterable[Source], program: Program | None = None
) -> tuple[Diagnostic, ...]:
    """Prepare the diagnostics of a check or a run for display.

    Constructs of other languages are explained, consequences of other errors, duplicates and suppressed diagnostics
    removed, and the rest sorted by position.

    Parameters
    ----------
    diagnostics
        Diagnostics in any order.
    sources
        Texts of the program, which contain the comments that suppress diagnostics.
    program
        The program, if it could be expanded: it shows which errors are consequences of others.
    """
    sources = tuple(sources)
    remaining = list(diagnostics)
    for source in sources:
        if not is_python(source) and any(d.is_error or d.name == "conditional-failure" for d in remaining):
            from scenelang.interpreter.checker.angles import with_meant_conversions
            from scenelang.interpreter.checker.habits import explain

            remaining = explain(source, with_meant_conversions([with_fixes(d) for d in remaining]))
    remaining = without_consequences(remaining, program)
    return tuple(with_fixes(d) for d in _sorted(without_suppressed(remaining, sources)))


def _sorted(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Sort diagnostics by position and remove duplicates."""
    unique: dict[Any, Diagnostic] = {}
    names: set[str] = set()  # each unbound name is reported only once
    for d in sorted(diagnostics, key=lambda d: d.span.start if d.span else -1):
        place = (d.span.source.name, d.span.start) if d.span else ("", -1)
        if d.name == "unbound":
            if d.message in names:
                continue
            names.add(d.message)
        unique.setdefault((place, d.name, d.message), d)
    return [unique[key] for key in sorted(unique, key=lambda k: k[0])]


def _imports(path: Path, names: set[str]) -> bool:
    """Return whether a file contains an import of one of the files ``names``."""
    try:
        data = read_regular(path, _MAX_IMPORTER_SIZE + 1)
        text = data.decode("utf-8") if len(data) <= _MAX_IMPORTER_SIZE else ""
    except (OSError, ValueError):
        return False
    return any(match[1].removeprefix("./") in names for match in IMPORT_FORM.finditer(text))


def _reading_hint(error: Exception) -> str | None:
    """Return a hint for an error while reading a program file."""
    number = getattr(error, "errno", None)
    if number == errno.EISDIR:
        return "name a file in the folder; only `check` and `fmt` accept folders"
    return "use `-` for standard input" if number == errno.EINVAL else None


IMPORTED_ENDINGS = (".scad", ".schem", ".litematic", ".nbt")  # of OpenSCAD, and of Minecraft builds
SCRIPT_ENDINGS = (".py", ".txt")  # of Blender scripts, and of responses that contain one


def other_file_error(path: str) -> SceneError | None:
    """Return the error for a file of another kind, with a hint what to do with it; None if it may be a program."""
    from scenelang.interpreter.scene.primitives import MESH_ENDINGS

    name = os.path.basename(path)
    ending = os.path.splitext(name)[1].lower()
    if ending in MESH_ENDINGS:
        hint = f'use it in a program: `(call "mesh" :file "{name}")`'
        return SceneError("file", f"`{name}` is a mesh, not a program", hint)
    if ending in IMPORTED_ENDINGS:
        hint = f"`scenelang import {name}` writes a program"
        return SceneError("file", f"`{name}` is of another program", hint)
    return None


def _read_source(path: str, shown: str) -> Source:
    """Read a program, ``-`` for standard input; ``shown`` is its name in diagnostics. Raises SceneError."""
    wrong = other_file_error(path) if os.path.exists(path) else None
    if wrong is not None:
        raise wrong
    try:
        if path == "-":
            data = sys.stdin.buffer.read(_MAX_FILE_SIZE + 1)
        else:
            data = read_regular(path, _MAX_FILE_SIZE + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it is not a path"
        from scenelang.backends.unreadable import unreadable

        raise unreadable(path, shown, reason, _reading_hint(error)) from None
    if len(data) > _MAX_FILE_SIZE:
        raise SceneError("file", f"{shown} exceeds the maximum program size of {_MAX_FILE_SIZE:,} bytes")
    name = "<stdin>" if path == "-" else shown
    try:
        text = data.removeprefix(BOM_UTF8).decode("utf-8")
    except UnicodeDecodeError as error:
        from scenelang.backends.unreadable import undecodable

        raise undecodable(data, name, error) from None
    if not name.endswith(".ipynb"):
        return Source(name, text)
    return Source(name, python_front_end().notebook_code(text, name))


def value_datum(name: str, text: str) -> Datum:
    """Parse the value of ``--define name=text``; a bare word is a string."""
    result = read(Source(f"<--define {name}>", text))
    if len(result.forms) == 1 and not result.diagnostics:
        form = result.forms[0]
        if isinstance(form, Atom) and isinstance(form.value, Symbol):
            return Atom(str(form.value), form.span)
        if not isinstance(form, ListDatum):
            return form
    raise SceneError(
        "param", f"--define {name}: invalid value `{text[:60]}`", 'write a number, "string", #t, #f or [array]'
    )
