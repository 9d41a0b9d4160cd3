"""Functions of the Python API: programs in, scenes out (docs/python.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, diagnostic_asked, error_of, explained
from scenelang.grammar.reader import ReadResult, read
from scenelang.interpreter.runtime.limits import Limits
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.scene import Scene, literal, scene_of
from scenelang.session import Checked, Options, Session

if TYPE_CHECKING:
    from scenelang.backends.base import Backend
    from scenelang.doctor import Check
    from scenelang.interpreter.transpile.translate import Translation
    from scenelang.scene_changes import Changes


def parse(text: str, name: str = "<text>") -> ReadResult:
    """Read a text into datums with spans; never raises: mistakes are in ``.diagnostics``.

    Examples
    --------
    >>> len(parse('(call "cube")').forms)
    1
    """
    return read(Source(name, text))


def check(text: str, name: str = "<text>", options: Options | None = None) -> Checked:
    """Find the mistakes of a program without running it; never raises for a mistake in the program.

    Examples
    --------
    >>> check('(bind "a" (lambda () (call "cube")))').ok
    True
    """
    return Session(options).check(Source(name, text))


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
    """Evaluate a program file, a language model's Python, or a scene that ``export`` wrote as JSON.

    Parameters
    ----------
    path : path
        ``.scene``, ``.py`` or ``.txt`` (a language model's response; its Python is translated, never run), ``.json``.
    seed : int
        Seed of the random streams.
    defines : mapping, optional
        Values of the program's params: numbers, booleans, strings, sequences of numbers.
    root : str, optional
        The word to evaluate (docs/language.md says which one is the default).
    embeddings : path, optional
        The file of embeddings; "auto" takes the one beside the program, None takes none.
    limits : Limits, optional
        Bounds of time, memory and size; they hold within this process only (docs/security.md).
    project : path, optional
        The folder that imports and assets may not leave; the program's own by default.
    allow_outside : bool
        Lift that restriction.
    strict : bool
        Hold the program to the paper's grammar.

    Raises
    ------
    SceneError
        The file cannot be read, or the program is wrong; the text shows code, place, source line and hint.

    Examples
    --------
    >>> import scenelang as sl
    >>> sl.load("examples/menger-sponge.scene", defines={"level": 1}).count()["cube"]
    20
    """
    entries = _entries(Path(path), embeddings)
    options = _options(seed, defines, root, entries, limits, project, allow_outside, strict)
    return scene_of(Session(options).source(str(path)), options)


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
    """Evaluate the text of a program; the arguments are those of ``load``, ``name`` is what errors call the text.

    Examples
    --------
    >>> evaluate('(bind "dot" (lambda () (call "sphere" :radius 2)))')
    <Scene "dot": 1 primitive>
    """
    options = _options(seed, defines, root, {}, limits, project, allow_outside, strict)
    return scene_of(Source(name, text), options)


def transpile(text: str, name: str = "<response>.py") -> Translation:
    """Translate a language model's response, or its Python, into a program of the language; the Python is never run.

    ``.text`` is the program, empty where ``.ok`` is false; ``.diagnostics`` say why.

    Examples
    --------
    >>> response = 'def dot():\\n    return primitive_call("sphere", shape_kwargs={"radius": 2})'
    >>> transpile("from helper import *\\n@register()\\n" + response).ok
    True
    """
    return Session().transpile(Source(name, text))


def format(text: str) -> str:
    """A program in the one style of the language; only white space changes.

    Raises
    ------
    SceneError
        The text cannot be read.

    Examples
    --------
    >>> format('(union   (call "cube") )')
    '(union (call "cube"))\\n'
    """
    from scenelang.formatting import formatted

    return formatted(text)


def diff(a: Scene, b: Scene, tolerance: float = 1e-5, limit: int = 2_000_000) -> Changes:
    """What differs between two scenes, change by change.

    Parameters
    ----------
    a, b : Scene
        Compared by what their primitives look like in the world, not by how the programs are written.
    tolerance : float
        Distances and attributes that differ by no more are equal.
    limit : int
        Most primitives that are expanded.

    Examples
    --------
    >>> red = evaluate('(bind "a" (lambda () (call "cube" :color [1 0 0])))')
    >>> diff(red, red).equal
    True
    """
    return a.diff(b, tolerance, limit)


def expand(text: str, name: str = "<text>", options: Options | None = None) -> str:
    """A program after macro expansion, as text.

    Raises
    ------
    SceneError
        The program is wrong; the first error of ``check``.

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


def import_build(path: str | Path, warn: Callable[[Diagnostic], None] | None = None) -> str:
    """The program of a Minecraft build: few merged cuboids, a word for each block state.

    Parameters
    ----------
    path : path
        ``.schem``, ``.litematic`` or ``.nbt``.
    warn : callable, optional
        Called with a ``Diagnostic`` for what the program does not have, such as items in chests.

    Raises
    ------
    SceneError
        The file cannot be read, is damaged, or holds no blocks.
    """
    from scenelang.backends.minecraft.export import imported

    text, warnings = imported(Path(path))
    for warning in warnings:
        if warn is not None:
            warn(warning)
    return text


def explain(code: str) -> str:
    """Why a diagnostic arises and how to fix the program, by its code or name.

    Examples
    --------
    >>> explain("E201").splitlines()[0].startswith("E201")
    True
    """
    return explained([diagnostic_asked(code)])


def grammar_text(form: Literal["lark", "llguidance", "gbnf", "ebnf", "textmate"], strict: bool = False) -> str:
    """The grammar of programs for constrained decoding and editors (docs/grammar.md); ``strict``: the paper's own.

    Examples
    --------
    >>> grammar_text("ebnf", strict=True).isascii()
    True
    """
    from scenelang.stdlib import reference

    return reference.grammar_text(form, strict)


def list_backends() -> tuple[Backend, ...]:
    """What scenes can be turned into: every backend, those of installed plug-ins too.

    Examples
    --------
    >>> "gltf" in [backend.name for backend in list_backends()]
    True
    """
    from scenelang.backends.base import every

    return tuple(every())


def check_installation() -> tuple[Check, ...]:
    """What is installed, which backends work here, and what is missing; tries each in a process of its own."""
    from scenelang.doctor import checks

    return tuple(checks())


def _options(
    seed: int,
    defines: Mapping[str, Any] | None,
    root: str | None,
    entries: Mapping[str, ZEntry],
    limits: Limits | None,
    project: str | Path | None,
    allow_outside: bool,
    strict: bool,
) -> Options:
    return Options(
        root=root,
        seed=seed,
        defines={name: literal(value) for name, value in (defines or {}).items()},
        limits=limits or Limits(),
        project=Path(project) if project is not None else None,
        allow_outside=allow_outside,
        strict=strict,
        z_entries=entries,
    )


def _entries(path: Path, embeddings: str | Path | None) -> Mapping[str, ZEntry]:
    from scenelang import zfile

    if embeddings is None:
        return {}
    if embeddings != "auto":
        return zfile.read_entries(Path(embeddings))
    own = zfile.beside(str(path))
    return zfile.read_entries(own) if own.exists() else {}
