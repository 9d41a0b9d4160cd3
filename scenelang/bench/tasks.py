"""Tasks of the benchmark: what a model is asked for, and the declarations that its scene must fulfill.

Tasks are data: TOML files, one per group, in the folder ``tasks`` of this package or in a folder of the user's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from importlib.resources import files
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.files.toml_places import TomlTable, parsed
from scenelang.grammar.datum import Source, dataclass
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.grammar.reader import read
from scenelang.inference.brief import TaskKind
from scenelang.interpreter.scene.declarations import Declaration
from scenelang.interpreter.scene.primitives import block_words, solid_words
from scenelang.session.declarations import declaration_source
from scenelang.session.session import Session

KEEP = "keep"  # what a near miss of an edit fails, besides declarations
_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
_MAX_TASKS = 10_000
_MAX_NAME = 80  # characters; it is part of file names


@dataclass(frozen=True, slots=True)
class NearMiss:
    """A program that fails one predicate of its task: ``fails`` is a declaration of the task, or "keep"."""

    fails: str
    program: str


@dataclass(frozen=True, slots=True)
class BenchTask:
    """A task of the benchmark.

    Attributes
    ----------
    name, group
        Its name, which is unique, and that of its file.
    kind
        Kind of the scene.
    prompt
        What the model is asked for, without the words that the declarations use (``text`` has them).
    that
        Declarations about the whole scene that must hold, as texts.
    keep
        Words whose instances an edit must leave where and as they are.
    program, python
        The program to edit in the language and in Python; None where there is none.
    is_image
        Whether the model is given a picture of the scene of ``passes``.
    passes
        A program that fulfills the task.
    near
        Programs that fail one predicate each.
    declarations
        ``that``, as declarations.
    """

    name: str
    group: str
    kind: TaskKind
    prompt: str
    that: tuple[str, ...]
    keep: tuple[str, ...]
    program: str | None
    python: str | None
    is_image: bool
    passes: str
    near: tuple[NearMiss, ...]
    declarations: tuple[Declaration, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """Words that the declarations are about, in their order, without primitives, handles and paths."""
        own = {*solid_words(), *block_words()}
        named = dict.fromkeys(thing for each in self.declarations for thing in each.things)
        return tuple(word for word in named if word not in own and "/" not in word and not word.startswith("<"))

    @property
    def text(self) -> str:
        """The prompt with the words that the scene must use, without which it could not be judged."""
        new = [word for word in self.words if f'"{word}"' not in (self.program or "")]
        if not new:
            return self.prompt
        listed = ", ".join(f'"{word}"' for word in new)
        return f"{self.prompt}\n\nName the things in the program exactly so: {listed}."


def load_tasks(folder: Path | None = None) -> tuple[BenchTask, ...]:
    """Load the tasks of a folder of TOML files, by default those of the package.

    Raises
    ------
    SceneError
        For a folder without tasks, and with the place of the first mistake in a file.
    """
    found = [task for source in _sources(folder) for task in tasks_of(source)]
    names: set[str] = set()
    for task in found:
        if task.name in names:
            raise SceneError("value", f"two tasks are named `{task.name}`")
        names.add(task.name)
    if not found:
        raise SceneError("file", f"no task in {folder}", "write TOML files with [[task]] tables")
    return tuple(found)


def _sources(folder: Path | None) -> Iterable[Source]:
    if folder is None:
        entries = [e for e in (files("scenelang.bench") / "tasks").iterdir() if e.name.endswith(".toml")]
        return [Source(e.name, e.read_text("utf-8")) for e in sorted(entries, key=lambda e: e.name)]
    if not folder.is_dir():
        raise SceneError("file", f"not a folder of tasks: {folder}")
    return [Source(str(path), _text(path)) for path in sorted(folder.glob("*.toml"))]


def _text(path: Path) -> str:
    try:
        return read_regular(path).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise SceneError("file", f"cannot read the tasks {path}: {reason}") from None


def tasks_of(source: Source) -> list[BenchTask]:
    """Parse one file of tasks. Raises SceneError with the place of the first mistake."""
    document = parsed(source, "value")
    group = Path(source.name).stem
    tables = document.tables("task")
    if len(tables) > _MAX_TASKS:
        document.fail("task", f"more than {_MAX_TASKS:,} tasks")
    found = [_task(table, group) for table in tables]
    document.finish()
    return found


def _task(table: TomlTable, group: str) -> BenchTask:
    name = _required(table, "name")
    if not _NAME.fullmatch(name) or len(name) > _MAX_NAME:
        expected = f"at most {_MAX_NAME} small letters, digits and hyphens"
        table.fail("name", f"`name`: expected {expected}, got {name[:_MAX_NAME]!r}")
    kind = TaskKind(table.text("kind", "3d", [kind.value for kind in TaskKind]))
    prompt, passes = _required(table, "prompt").strip(), _required(table, "passes")
    that, keep = table.texts("that"), table.texts("keep")
    program, python = table.text("program", None), table.text("python", None)
    if keep and program is None:
        table.fail("keep", "`keep` has no meaning without a `program` to edit")
    if not that and not keep:
        table.fail_missing("that", "a task has at least one declaration in `that`")
    for key, text in (("passes", passes), ("program", program)):
        _check_text(table, key, text)
    declarations = _declarations(table, that)
    near = tuple(_near(each, passes, that, keep) for each in table.tables("near"))
    is_image = table.flag("image", False)
    table.finish()
    return BenchTask(
        name, group, kind, prompt, that, keep, program, python, is_image, passes, near, declarations
    )  # fmt: skip


def _required(table: TomlTable, key: str) -> str:
    value = table.text(key, None)
    if not value:
        table.fail(key if key in table else None, f"`{key}` is missing" if value is None else f"`{key}` is empty")
    return str(value)


def _check_text(table: TomlTable, key: str, text: str | None) -> None:
    """Fail for a program that cannot be read; what it means is seen when it is evaluated."""
    problem = next((d for d in read(Source(key, text or "")).diagnostics if d.is_error), None)
    if problem is not None:
        table.fail(key, f"`{key}`: {problem.message}", problem.hint)


def _declarations(table: TomlTable, texts: Sequence[str]) -> tuple[Declaration, ...]:
    """Parse declarations: all of a task at once, or if there is a mistake each by itself, to tell which it is in."""
    together = Source("<declarations>", "\n".join(declaration_source(text).text for text in texts))
    try:
        found = Session().declarations(together) if texts else ()
    except SceneError:
        found = ()
    return found if len(found) == len(texts) else tuple(_declaration(table, text) for text in texts)


def _declaration(table: TomlTable, text: str) -> Declaration:
    try:
        found = Session().declarations(declaration_source(text))
    except SceneError as error:
        table.fail("that", f"`that`: {text}: {error.message}", error.hint)
    if len(found) != 1:
        table.fail("that", f"`that`: expected one declaration per string, got {len(found)}")
    return found[0]


def _near(table: TomlTable, passes: str, that: Sequence[str], keep: Sequence[str]) -> NearMiss:
    """Read a near miss: a whole program, or the passing one with a text that occurs once replaced."""
    fails = _required(table, "fails")
    known = [*that, *([KEEP] if keep else [])]
    if fails not in known:
        table.fail("fails", f"`fails`: the task has no predicate {fails}", suggest(fails, known))
    program = table.text("program", None)
    if program is None:
        old, new = _required(table, "replace"), str(table.text("by", ""))
        count = passes.count(old)
        if count != 1:
            table.fail("replace", f"`replace`: the text occurs {count} times in `passes`, expected once")
        program = passes.replace(old, new)
    table.finish()
    return NearMiss(fails, str(program))
