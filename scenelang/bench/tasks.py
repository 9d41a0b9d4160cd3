"""Tasks of the benchmark: what a model is asked for, and the declarations that its scene must fulfill.

Tasks are data: TOML files, one per group, in the folder ``tasks`` of this package or in a folder of the user's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.backends.geometry.acceptance import holds_always
from scenelang.bench.sizes import everyday_sizes
from scenelang.files.toml_places import TomlTable, parsed
from scenelang.grammar.datum import Source, dataclass
from scenelang.grammar.diagnostics import ABOUT_GEOMETRY, SceneError, suggest
from scenelang.grammar.reader import read
from scenelang.inference.brief import TaskKind
from scenelang.interpreter.inspection.instance_paths import is_plain
from scenelang.interpreter.scene.declarations import Declaration
from scenelang.interpreter.scene.primitives import block_words, solid_words
from scenelang.session.declarations import declaration_source
from scenelang.session.session import Session

KEEP = "keep"  # the predicate of an edit that leaves alone what it must, besides declarations
GEOMETRY = "geometry"  # the predicate that `check --geometry` warns of nothing
_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
_MAX_TASKS = 10_000
_MAX_NAME = 80  # characters; it is part of file names
_NO_SPACE = ".,;:!?)"  # at the start of a clause: it follows the one before without a space


@dataclass(frozen=True, slots=True)
class PromptClause:
    """A clause of a prompt with the predicates that decide whether a scene fulfills it.

    Attributes
    ----------
    says
        Its text. The prompt is the sequence of its clauses.
    that
        Declarations about the whole scene that must hold, as texts.
    keep
        Words whose instances an edit must leave where and as they are.
    is_checked
        Whether predicates decide it: declarations, what an edit keeps, or, for "stands on the ground" and its like, the
        warnings of `check --geometry`. Otherwise it states a subject or a convention, such as where the front is.
    """

    says: str
    that: tuple[str, ...]
    keep: tuple[str, ...]
    is_checked: bool


@dataclass(frozen=True, slots=True)
class WrongScene:
    """A program that breaks one clause of its task, and why."""

    breaks: str
    why: str
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
    clauses
        The prompt in pieces, each with its predicates.
    that
        Declarations about the whole scene that must hold, as texts: those of all clauses.
    keep
        Words whose instances an edit must leave where and as they are.
    allows
        Names of warnings of `check --geometry` that a scene may have, such as "floating" for planets.
    program, python
        The program to edit in the language and in Python; None where there is none.
    is_hard
        Whether it belongs to the hard split, which runs only when it is asked for: `hard = true` of its file.
    is_image
        Whether the model is given a picture of the scene of ``passes``.
    passes
        A program that fulfills the task.
    wrong
        Plausible programs that each break a clause.
    declarations
        ``that``, as declarations.
    """

    name: str
    group: str
    kind: TaskKind
    clauses: tuple[PromptClause, ...]
    that: tuple[str, ...]
    keep: tuple[str, ...]
    allows: frozenset[str]
    program: str | None
    python: str | None
    is_hard: bool
    is_image: bool
    passes: str
    wrong: tuple[WrongScene, ...]
    declarations: tuple[Declaration, ...]

    @property
    def prompt(self) -> str:
        """What the model is asked for, without the words that the declarations use (``text`` has them)."""
        return "".join(
            f"{'' if clause.says[0] in _NO_SPACE or not number else ' '}{clause.says}"
            for number, clause in enumerate(self.clauses)
        )

    @property
    def words(self) -> tuple[str, ...]:
        """Words that the declarations are about, in their order, without primitives, handles and paths."""
        own = {*solid_words(), *block_words()}
        named = dict.fromkeys(thing for each in self.declarations for thing in each.things)
        return tuple(word for word in named if word not in own and is_plain(word))

    @property
    def text(self) -> str:
        """The prompt with the words that the scene must use, without which it could not be judged."""
        new = [word for word in self.words if f'"{word}"' not in (self.program or "")]
        if not new:
            return self.prompt
        listed = ", ".join(f'"{word}"' for word in new)
        return f"{self.prompt}\n\nName the things in the program exactly so: {listed}."


def load_tasks(folder: Path | None = None) -> tuple[BenchTask, ...]:
    """Load the tasks of a TOML file or of a folder of these, by default those of the package.

    Raises
    ------
    SceneError
        For a folder without tasks, and with the place of the first mistake in a file.
    """
    if folder is None:
        return _own_tasks()
    tasks = _distinct(_sources(folder))
    if not tasks:
        raise SceneError("file", f"no task in {folder}", "write TOML files with [[task]] tables")
    return tasks


@cache  # reading them takes 5 s, and a measurement needs them three times
def _own_tasks() -> tuple[BenchTask, ...]:
    entries = [e for e in (files("scenelang.bench") / "tasks").iterdir() if e.name.endswith(".toml")]
    return _distinct(Source(e.name, e.read_text("utf-8")) for e in sorted(entries, key=lambda e: e.name))


def _distinct(sources: Iterable[Source]) -> tuple[BenchTask, ...]:
    """Return the tasks of files; raises SceneError if two have the same name."""
    tasks = [task for source in sources for task in tasks_of(source)]
    names: set[str] = set()
    for task in tasks:
        if task.name in names:
            raise SceneError("value", f"two tasks are named `{task.name}`")
        names.add(task.name)
    return tuple(tasks)


def _sources(folder: Path) -> Iterable[Source]:
    if folder.is_file():
        return [Source(str(folder), _text(folder))]
    if not folder.is_dir():
        raise SceneError("file", f"no file or folder of tasks: {folder}")
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
    is_hard = document.flag("hard", False)
    tasks = [_task(table, group, is_hard=is_hard) for table in tables]
    document.finish()
    return tasks


def _task(table: TomlTable, group: str, *, is_hard: bool) -> BenchTask:
    name = _required(table, "name")
    if not _NAME.fullmatch(name) or len(name) > _MAX_NAME:
        expected = f"at most {_MAX_NAME} small letters, digits and hyphens"
        table.fail("name", f"`name`: expected {expected}, got {name[:_MAX_NAME]!r}")
    kind = TaskKind(table.text("kind", "3d", [kind.value for kind in TaskKind]))
    passes = _required(table, "passes")
    program, python = table.text("program", None), table.text("python", None)
    clauses = [_clause(each, is_edit=program is not None) for each in table.tables("clause")]
    if not any(clause.is_checked for clause, _ in clauses):
        table.fail_missing("clause", "a task has at least one clause with predicates")
    for key, text in (("passes", passes), ("program", program)):
        _check_text(table, key, text)
    declared = dict(entry for clause, stated in clauses for entry in zip(clause.that, stated))
    allows = frozenset(table.texts("allows", (), ABOUT_GEOMETRY))
    is_image = table.flag("image", False)
    prompt = "" if is_image else " ".join(clause.says for clause, _ in clauses)
    wrong = tuple(_wrong(each, prompt, passes) for each in table.tables("wrong"))
    table.finish()
    return BenchTask(
        name, group, kind, tuple(clause for clause, _ in clauses), tuple(declared),
        tuple(dict.fromkeys(word for clause, _ in clauses for word in clause.keep)), allows, program, python, is_hard,
        is_image, passes, wrong, tuple(declared.values()),
    )  # fmt: skip


def _clause(table: TomlTable, *, is_edit: bool) -> tuple[PromptClause, tuple[Declaration, ...]]:
    """Read a clause, and return it with its declarations."""
    says = _required(table, "says").strip()
    that, keep, sizes = table.texts("that"), table.texts("keep"), table.texts("sizes")
    is_metric, by_geometry, is_given = (table.flag(key, False) for key in ("metres", "geometry", "given"))
    if keep and not is_edit:
        table.fail("keep", "`keep` has no meaning without a `program` to edit")
    is_checked = bool(that or keep or sizes or by_geometry)
    if is_checked == is_given:
        problem = "a clause without predicates" if is_given is False else "`given` of a clause that has predicates"
        table.fail("says", f"{problem}: {says}", "state `that`, `keep`, `sizes`, `geometry = true` or `given = true`")
    that = (*that, *_size_declarations(table, sizes, is_metric=is_metric))
    declarations = _declarations(table, that)
    for text, declaration in zip(that, declarations, strict=True):
        if holds_always(declaration):
            table.fail("that", f"`that`: {text} holds for every scene", "state a number, or a range that excludes some")
    table.finish()
    return PromptClause(says, that, keep, is_checked), declarations


def _size_declarations(table: TomlTable, sizes: Sequence[str], *, is_metric: bool) -> list[str]:
    """Return declarations about the sizes of everyday objects, in metres, or of each relative to the one before."""
    everyday, named = everyday_sizes(), []
    for entry in sizes:
        word, _, noun = (part.strip() for part in entry.partition(":"))
        noun = noun or word
        if noun not in everyday:
            table.fail("sizes", f'`sizes`: no everyday size of "{noun}"', suggest(noun, everyday))
        named.append((word, everyday[noun]))
    if is_metric:
        return [text for word, size in named for text in size.in_metres(word)]
    if len(named) == 1:
        table.fail("sizes", "`sizes` compares at least two words, or with `metres = true` one")
    return [text for one, other in pairwise(named) for text in one[1].relative_to(one[0], *other)]


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
        declarations = Session().declarations(together) if texts else ()
    except SceneError:
        declarations = ()
    return declarations if len(declarations) == len(texts) else tuple(_declaration(table, text) for text in texts)


def _declaration(table: TomlTable, text: str) -> Declaration:
    try:
        declarations = Session().declarations(declaration_source(text))
    except SceneError as error:
        table.fail("that", f"`that`: {text}: {error.message}", error.hint)
    if len(declarations) != 1:
        table.fail("that", f"`that`: expected one declaration per string, got {len(declarations)}")
    return declarations[0]


def _wrong(table: TomlTable, prompt: str, passes: str) -> WrongScene:
    """Read a wrong scene: a whole program, or the passing one with a text that occurs once replaced.

    It names the words of the prompt that it breaks; an empty prompt, that of an image, has none.
    """
    breaks, why = _required(table, "breaks"), _required(table, "why")
    if prompt and breaks not in prompt:
        table.fail("breaks", f"`breaks`: the prompt does not say {breaks!r}")
    program = table.text("program", None)
    if program is None:
        old, new = _required(table, "replace"), str(table.text("by", ""))
        count = passes.count(old)
        if count != 1:
            table.fail("replace", f"`replace`: the text occurs {count} times in `passes`, expected once")
        program = passes.replace(old, new)
    if str(program).split() == passes.split():
        table.fail("breaks", "the wrong scene is that of `passes`")
    table.finish()
    return WrongScene(breaks, why, str(program))
