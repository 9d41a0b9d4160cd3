"""A task as the turns of a conversation: what is said first, and what is said of an answer."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from importlib.resources import files
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.backends.language_models.catalogue import ImageContent, TextContent, Turn, said
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.inference.listing import MOST_ITEMS, Renamed, listing, rename_language, rename_python
from scenelang.interpreter.scene.primitives import (
    attributes_read,
    block_words,
    docs_of_attributes,
    docs_of_words,
    solid_words,
)
from scenelang.interpreter.transpile.python_text import HELPERS, code_of
from scenelang.primer import primer
from scenelang.session import Session
from scenelang.stdlib.reference import helper_header, in_json

# The texts of prompts: files with places to fill, ``{{name}}``, each of which a file of the user's may replace.


_PLACE = re.compile(r"\{\{(\w+)\}\}")
_NEEDED = frozenset(("task", "program", "instruction", "diagnostics", "questions"))
_LARGEST = 1_000_000  # bytes


class Prompts:
    """Prompts from ``folder`` where it has a file of the name, else the package's own. Raises SceneError for files that
    nothing reads, and for places that nothing fills or that must be there: before anything is paid for."""

    def __init__(self, folder: Path | None = None) -> None:
        self._texts = {name: _own(name) for name in prompt_names()}
        self._replaced = _replaced(folder, self._texts) if folder is not None else {}

    def text(self, name: str, **values: str) -> str:
        """The text of the file ``name`` with its places filled."""
        template = self._replaced.get(name, self._texts[name])
        return _PLACE.sub(lambda match: values[match[1]], template.strip("\n"))

    def is_replaced(self, name: str) -> bool:
        """Whether a prompt is the user's."""
        return name in self._replaced


def prompt_names() -> tuple[str, ...]:
    """The files that there are."""
    folder = files("scenelang.inference") / "prompts"
    return tuple(sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".md")))


def _own(name: str) -> str:
    return (files("scenelang.inference") / "prompts" / name).read_text("utf-8")


def _replaced(folder: Path, own: Mapping[str, str]) -> dict[str, str]:
    """The prompts that a folder has, checked."""
    if not folder.is_dir():
        raise SceneError("prompt", f"--prompt-dir: there is no folder {folder}")
    found: dict[str, str] = {}
    for path in sorted(folder.glob("*.md")):
        if path.name not in own:
            hint = suggest(path.name, own) or f"there are {' '.join(own)}"
            raise SceneError("prompt", f"{path} is no prompt that is read", hint)
        found[path.name] = _file_text(path)
        _check_places(path, found[path.name], own[path.name])
    return found


def _check_places(path: Path, text: str, own: str) -> None:
    places, known = set(_PLACE.findall(text)), set(_PLACE.findall(own))
    for place in sorted(places - known):
        message = f"the prompt {path} has the place {{{{{place}}}}}, for which there is no text"
        listed = ", ".join(sorted(known)) or "none"
        raise SceneError("prompt", message, suggest(place, known) or f"it may have: {listed}")
    for place in sorted((known & _NEEDED) - places):
        raise SceneError("prompt", f"the prompt {path} lacks the place {{{{{place}}}}}: the model would not see it")


def _file_text(path: Path) -> str:
    try:
        if path.stat().st_size > _LARGEST:
            raise SceneError("prompt", f"{path} is too large for a prompt")
        return read_regular(path).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no UTF-8 text"
        raise SceneError("prompt", f"cannot read the prompt {path}: {reason}") from None


# What is asked for: a scene of some kind, in some notation, anew or as an edit.


class TaskKind(Enum):
    """What a scene is: still, a film, or made of Minecraft's blocks."""

    STILL = "3d"
    FILM = "4d"
    BLOCKS = "minecraft"


class Notation(Enum):
    """What the model writes: Python against the helper API, the language, or a list of primitives (the paper's
    ablation "No-P")."""

    PYTHON = "python"
    LANGUAGE = "language"
    LIST = "list"


class Ablation(Enum):
    """What is taken from the model (the paper, appendix "Ablations"): the program, words, or both."""

    NONE = ""
    P = "P"
    W = "W"
    PW = "PW"

    @property
    def takes_program(self) -> bool:
        return self in (Ablation.P, Ablation.PW)

    @property
    def takes_words(self) -> bool:
        return self in (Ablation.W, Ablation.PW)


@dataclass(frozen=True, slots=True)
class Task:
    """``text`` describes the scene, or says how ``program`` is to be changed. ``seed`` makes the random names that
    stand for words."""

    text: str
    kind: TaskKind = TaskKind.STILL
    notation: Notation = Notation.PYTHON
    ablation: Ablation = Ablation.NONE
    pictures: tuple[ImageContent, ...] = ()
    program: str | None = None
    seed: int = 0

    @property
    def is_edit(self) -> bool:
        return self.program is not None


NO_CHANGES = "NO CHANGES"
_GAP = re.compile(r"\n{3,}")  # what an empty place leaves
_SHOWN = 9  # lines of a list that serves as an example
_FENCES = {Notation.PYTHON: "python", Notation.LANGUAGE: "scene", Notation.LIST: "json"}
_TURNED = ("rotation_matrix", "reflection_matrix")  # what blocks cannot do
_TURNED_HERE = ("rotate", "reflect", "ring", "mirror", "jitter", "scatter")
# What a program of one scene has no use for: macros, files, the inside of entities, the streams of translated Python.
_UNTOLD = (
    "define-syntax", "syntax-rules", "define-macro", "let-syntax", "letrec-syntax", "quasiquote", "define-record",
    "import", "param", "let/ec", "guard", "assert", "begin0", "while", "let*-values", "for/table", "for/set",
    *(f"for*/{kind}" for kind in ("append", "sum", "and", "or", "first", "table", "set", "fold")),
    "retrieve", "no-entities", "bound?", "call-embeddings", "apply-entity-function", "make-entity", "embedding",
    "embedding-text", "embedding-handle", "embedding-attributes", "entity-word", "entity-embedding", "entity-children",
    "primitive?", "random-state", "set-random-state!", "random-stream", "default-rng", "py-random-stream",
    "py-set-seed!", "py-random", "py-uniform", "py-gauss", "py-randint", "py-randrange", "py-choice", "py-choices",
    "py-sample", "py-shuffle", "py-shuffle!",
)  # fmt: skip
_FIELDS = {
    "word": "what it belongs to, a name such as \"chair\"; parts of one thing have one name",
    "shape": "the kind of primitive",
    "attributes": "an object with the primitive's attributes",
    "pose": "the upper three rows of its 4x4 matrix in the world, three lists of four numbers",
}  # fmt: skip


def helpers_of(kind: TaskKind) -> tuple[str, ...]:
    """The helpers that programs of a kind are told of."""
    left_out = {"identity_matrix"}
    if kind is not TaskKind.FILM:
        left_out.add("register_animation")
    if kind is TaskKind.BLOCKS:
        left_out |= {*_TURNED}
    return tuple(name for name in HELPERS if name not in left_out)


def words_of(kind: TaskKind) -> tuple[str, ...]:
    """The primitives that programs of a kind are told of."""
    return block_words() if kind is TaskKind.BLOCKS else solid_words()


def untold(kind: TaskKind) -> tuple[str, ...]:
    """The names of the language that programs of a kind are not told of."""
    turned = _TURNED_HERE if kind is TaskKind.BLOCKS else ()
    return (*_UNTOLD, *turned) if kind is TaskKind.FILM else (*_UNTOLD, *turned, "frames")


def fenced(text: str, notation: Notation) -> str:
    """A program as a model is shown it."""
    return f"```{_FENCES[notation]}\n{text.strip()}\n```"


@dataclass(frozen=True)
class Brief:
    """What is said to the model about one task, from the prompts' files. ``is_bare``: a grammar allows nothing around
    the program."""

    task: Task
    prompts: Prompts
    is_bare: bool = False

    @cached_property
    def system(self) -> str:
        """The system prompt: the notation and the rules. An edit has the same as what it edits."""
        task = self.task
        rules = self.prompts.text(f"rules.{task.kind.value}.md", **self._of_frames())
        if task.ablation is Ablation.W and not task.is_edit:
            rules = f"{rules}\n\n{self.prompts.text('names.md')}"
        if task.notation is Notation.PYTHON:
            header = helper_header(helpers_of(task.kind), words_of(task.kind)).strip()
            return self.prompts.text("system.python.md", header=header, rules=rules)
        if task.notation is Notation.LANGUAGE:
            text = primer(words_of(task.kind), untold(task.kind))
            answer = self.prompts.text("bare.md" if self.is_bare else "fenced.md")
            return self.prompts.text("system.language.md", primer=text, rules=rules, answer=answer)
        fields, primitives, most = self._fields(), self._primitives(), f"{MOST_ITEMS:,}"
        return self.prompts.text("system.list.md", fields=fields, primitives=primitives, rules=rules, most=most)

    def _of_frames(self) -> dict[str, str]:
        if self.task.kind is not TaskKind.FILM:
            return {}
        return {"frames": self.prompts.text(f"frames.{self.task.notation.value}.md")}

    def _fields(self) -> str:
        names = [name for name in _FIELDS if not (name == "word" and self.task.ablation.takes_words)]
        return "\n".join(f"- `{name}`: {_FIELDS[name]}" for name in names)

    def _primitives(self) -> str:
        words = words_of(self.task.kind)
        lines = [f'- "{word}": {in_json(docs_of_words()[word])}; takes {", ".join(_read(word))}' for word in words]
        names = dict.fromkeys(name for word in words for name in _read(word))
        return "\n".join([*lines, *(f"- {name}: {in_json(docs_of_attributes()[name])}" for name in names)])

    @cached_property
    def first(self) -> Turn:
        """The task. Its end is fixed: samples, repairs and critiques all say the same up to here."""
        task, pictures = self.task, self.task.pictures
        if task.program is not None:
            program = fenced(self.renamed.text if self.renamed else task.program, task.notation)
            text = self.prompts.text("user.edit.md", program=program, instruction=task.text)
        else:
            name = "user.image.md" if pictures else "user.text.md"
            text = self.prompts.text(name, example=self.example, task=task.text)
        return Turn("user", (*pictures, TextContent(text.strip(), is_fixed=True)))

    @cached_property
    def example(self) -> str:
        """A program that is right, in the task's notation; of a list, its first primitives."""
        task = self.task
        name = f"example.{task.kind.value}.md"
        answer = self.prompts.text(name)
        source = Source("example.txt", answer)
        if self.prompts.is_replaced(name) and not Session().check(source).ok:
            raise SceneError("prompt", f"the prompt {name} holds no program that is right", "`scenelang check` tells")
        if task.notation is Notation.LIST:
            return f'An example, "{_docstring(answer)}":\n\n{fenced(_example_list(source, task), task.notation)}'
        text = code_of(answer) if task.notation is Notation.PYTHON else Session().transpile(source).text
        if task.ablation.takes_words:
            rename = rename_python if task.notation is Notation.PYTHON else rename_language
            text = rename(text, task.seed).text
        return f"An example of a program:\n\n{fenced(text, task.notation)}"

    @cached_property
    def renamed(self) -> Renamed | None:
        """The program that is edited under random names, None where it keeps its words."""
        task = self.task
        if task.program is None or task.ablation is not Ablation.W:
            return None
        return (rename_python if task.notation is Notation.PYTHON else rename_language)(task.program, task.seed)

    def restored(self, answer: str) -> str:
        """An answer with words in place of the random names that it was given."""
        return self.renamed.restored(answer) if self.renamed is not None else answer

    # --- about an answer ------------------------------------------------------------------------------------------

    def repair(self, diagnostics: str) -> Turn:
        return said("user", self.prompts.text("repair.md", diagnostics=diagnostics))

    def cut(self, tokens: int) -> Turn:
        return said("user", self.prompts.text("cut.md", tokens=f"{tokens:,}"))

    def critique(self, views: Sequence[tuple[str, ImageContent]], findings: str) -> Turn:
        """Pictures with a caption each, then what to do with them."""
        parts = [part for caption, picture in views for part in (TextContent(caption), picture)]
        notes = [self.prompts.text("blocks.md")] if self.task.kind is TaskKind.BLOCKS else []
        notes += [f"The checker noticed:\n\n{findings}"] if findings else []
        text = _GAP.sub("\n\n", self.prompts.text("critique.md", notes="\n\n".join(notes)))
        return Turn("user", (*parts, TextContent(text)))


def _read(word: str) -> list[str]:
    """The attributes of a primitive that a list is told of; blocks have the colours of their kind."""
    return [name for name in attributes_read(word) if not (name == "color" and word in block_words())]


def _docstring(answer: str) -> str:
    pieces = code_of(answer).split('"""')
    return pieces[1].strip() if len(pieces) > 1 else "a scene"


def _example_list(source: Source, task: Task) -> str:
    scene = Session().evaluate(source).scene
    assert scene is not None, "the example of the prompts is a right program"
    lines = listing(scene, not task.ablation.takes_words).splitlines()
    ends = ["...", "],", "...", "]"] if scene.animated else ["...", "]"]
    return "\n".join([*lines[:_SHOWN], *ends]) if len(lines) > _SHOWN + len(ends) else "\n".join(lines)
