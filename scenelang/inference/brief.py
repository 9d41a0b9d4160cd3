"""Prompts of a task: the initial request to the model, and the replies to its answers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from importlib.resources import files
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.backends.language_models.catalogue import ImageContent, Message, TextContent, text_message
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.grammar.python_helpers import HELPERS
from scenelang.inference.listing import MAX_ITEMS, Renamed, listing, rename_language, rename_python
from scenelang.interpreter.runtime.modelling_helpers import python_name
from scenelang.interpreter.scene.declarations import RELATIONS, Declaration
from scenelang.interpreter.scene.primitives import (
    attributes_read,
    block_words,
    docs_of_attributes,
    docs_of_words,
    solid_words,
)
from scenelang.interpreter.transpile.analysis.python_text import code_of
from scenelang.reference.primer import primer, python_modelling
from scenelang.reference.searching import fitting_parts
from scenelang.reference.sections import fitting_sections, with_sections
from scenelang.session.session import Session
from scenelang.stdlib.reference import LibraryPart, ReferenceRecord, helper_header, in_json

# Prompt templates: files with placeholders ``{{name}}``. A user's file of the same name overrides the package's file.


_PLACE = re.compile(r"\{\{(\w+)\}\}")
_NEEDED = frozenset(("task", "program", "instruction", "diagnostics", "questions"))
_MAX_SIZE = 1_000_000  # bytes


class Prompts:
    """Prompt templates from ``folder``, with the package's templates as fallback.

    All templates are validated on construction, before any request costs money: SceneError is raised for unknown files
    and for unknown or missing placeholders.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._texts = {name: _own(name) for name in prompt_names()}
        self._replaced = _replaced(folder, self._texts) if folder is not None else {}

    def text(self, name: str, **values: str) -> str:
        """Return the template ``name`` with its placeholders filled."""
        template = self._replaced.get(name, self._texts[name])
        return _PLACE.sub(lambda match: values[match[1]], template.strip("\n"))

    def is_replaced(self, name: str) -> bool:
        """Return whether a template is overridden by the user."""
        return name in self._replaced


def prompt_names() -> tuple[str, ...]:
    """Return the file names of all templates."""
    folder = files("scenelang.inference") / "prompts"
    return tuple(sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".md")))


def _own(name: str) -> str:
    return (files("scenelang.inference") / "prompts" / name).read_text("utf-8")


def _replaced(folder: Path, own: Mapping[str, str]) -> dict[str, str]:
    """Read and validate the templates in a user's folder."""
    if not folder.is_dir():
        raise SceneError("prompt", f"--prompt-dir: not a folder: {folder}")
    templates: dict[str, str] = {}
    for path in sorted(folder.glob("*.md")):
        if path.name not in own:
            hint = suggest(path.name, own) or f"expected one of {' '.join(own)}"
            raise SceneError("prompt", f"unknown prompt template {path}", hint)
        templates[path.name] = _file_text(path)
        _check_places(path, templates[path.name], own[path.name])
    return templates


def _check_places(path: Path, text: str, own: str) -> None:
    places, known = set(_PLACE.findall(text)), set(_PLACE.findall(own))
    for place in sorted(places - known):
        message = f"unknown placeholder {{{{{place}}}}} in the prompt template {path}"
        listed = ", ".join(sorted(known)) or "none"
        raise SceneError("prompt", message, suggest(place, known) or f"known placeholders: {listed}")
    for place in sorted((known & _NEEDED) - places):
        raise SceneError("prompt", f"missing placeholder {{{{{place}}}}} in the prompt template {path}")


def _file_text(path: Path) -> str:
    try:
        if path.stat().st_size > _MAX_SIZE:
            raise SceneError("prompt", f"the prompt template {path} is too large")
        return read_regular(path).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise SceneError("prompt", f"cannot read the prompt template {path}: {reason}") from None


# Tasks: the kind of scene, the notation, and whether a scene is generated or edited.


class TaskKind(Enum):
    """Kind of a scene: static, animated, or a Minecraft build."""

    STILL = "3d"
    FILM = "4d"
    BLOCKS = "minecraft"


class Notation(Enum):
    """Notation of the model's output: Python with the helper API, the Scene Language, or a list of primitives (the
    paper's ablation "No-P")."""

    PYTHON = "python"
    LANGUAGE = "language"
    LIST = "list"


class Ablation(Enum):
    """Ablation of the paper's appendix "Ablations": without programs, words, or both."""

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
    """A task for the model. ``text`` describes the scene, or the edit of ``program``. ``seed`` generates the random
    names that replace words in an ablation."""

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
_GAP = re.compile(r"\n{3,}")  # left by empty placeholders
_FENCED = re.compile(r"```scene\n(.*?)```", re.DOTALL)
_MOST_OBJECTS = 8  # parts of the library in a prompt
_LONGEST_OBJECTS = 1_500  # characters of their section
_SHOWN = 9  # maximum number of lines of an example list
_FENCES = {Notation.PYTHON: "python", Notation.LANGUAGE: "scene", Notation.LIST: "json"}
_TURNED = ("rotation_matrix", "reflection_matrix")  # not supported for blocks
_TURNED_HERE = ("rotate", "reflect", "ring", "mirror", "jitter", "scatter")
# Omitted from the primer: macros, files, entity internals, and the random streams of translated Python.
_UNTOLD = (
    "define-syntax", "syntax-rules", "define-macro", "let-syntax", "letrec-syntax", "quasiquote", "define-record",
    "import", "let/ec", "guard", "assert", "declare-that", "begin0", "while",
    "let*-values", "for/table", "for/set",
    *(f"for*/{kind}" for kind in ("append", "sum", "and", "or", "first", "table", "set", "fold")),
    "retrieve", "no-entities", "bound?", "call-embeddings", "apply-entity-function", "make-entity", "embedding",
    "embedding-text", "embedding-handle", "embedding-attributes", "entity-word", "entity-embedding", "entity-children",
    "primitive?", "random-state", "set-random-state!", "random-stream", "default-rng", "py-random-stream",
    "py-set-seed!", "py-random", "py-uniform", "py-gauss", "py-randint", "py-randrange", "py-choice", "py-choices",
    "py-sample", "py-shuffle", "py-shuffle!",
)  # fmt: skip
_FIELDS = {
    "word": "what it belongs to, a name such as \"chair\"; parts of one object have one name",
    "shape": "the kind of primitive",
    "attributes": "an object with the primitive's attributes",
    "pose": "the upper three rows of its 4x4 matrix in the world, three lists of four numbers",
}  # fmt: skip


def helpers_of(kind: TaskKind) -> tuple[str, ...]:
    """Return the helper functions documented for programs of a kind."""
    left_out = {"identity_matrix"}
    if kind is not TaskKind.FILM:
        left_out.add("register_animation")
    if kind is TaskKind.BLOCKS:
        left_out |= {*_TURNED}
    return tuple(name for name in HELPERS if name not in left_out)


def words_of(kind: TaskKind) -> tuple[str, ...]:
    """Return the primitives documented for programs of a kind."""
    return block_words() if kind is TaskKind.BLOCKS else solid_words()


def _captioned(views: Sequence[tuple[str, ImageContent]]) -> list[TextContent | ImageContent]:
    """Return images as parts of a message, each after its caption."""
    return [part for caption, picture in views for part in (TextContent(caption), picture)]


def sections_of(kind: TaskKind) -> tuple[str, ...]:
    """Return the sections of the system prompt of a kind."""
    return _SECTIONS.get(kind, ())


_SECTIONS = {TaskKind.FILM: ("films",), TaskKind.BLOCKS: ("blocks",)}
_BY_WORDS = ("solids", "relations")  # the others are those of a kind


def _listed(kind: TaskKind) -> tuple[str, ...]:
    """Return the primitives that stand before the sections: those of blocks are in theirs."""
    return () if kind is TaskKind.BLOCKS else words_of(kind)


def untold(kind: TaskKind) -> tuple[str, ...]:
    """Return the names of the language that are omitted from the primer for programs of a kind."""
    turned = _TURNED_HERE if kind is TaskKind.BLOCKS else ()
    return (*_UNTOLD, *turned)


def fenced(text: str, notation: Notation) -> str:
    """Return a program as a fenced code block."""
    return f"```{_FENCES[notation]}\n{text.strip()}\n```"


@dataclass(frozen=True)
class Brief:
    """Prompts of one task, from the templates. ``is_bare``: a grammar allows only the program, without a fence.

    ``acceptance`` are declarations that the scene must fulfill.
    """

    task: Task
    prompts: Prompts
    is_bare: bool = False
    acceptance: tuple[Declaration, ...] = ()

    @cached_property
    def system(self) -> str:
        """System prompt with notation and rules; the same for generating and editing."""
        task = self.task
        rules = self.prompts.text(f"rules.{task.kind.value}.md", **self._of_frames())
        if task.ablation is Ablation.W and not task.is_edit:
            rules = f"{rules}\n\n{self.prompts.text('names.md')}"
        if task.notation is Notation.PYTHON:
            header = helper_header(helpers_of(task.kind), _listed(task.kind)).strip()
            modelling = python_modelling(task.kind is not TaskKind.BLOCKS)
            modelling = with_sections(modelling, sections_of(task.kind), is_python=True)
            return self.prompts.text("system.python.md", header=header, modelling=modelling, rules=rules)
        if task.notation is Notation.LANGUAGE:
            text = with_sections(primer(_listed(task.kind), untold(task.kind)), sections_of(task.kind))
            answer = self.prompts.text("bare.md" if self.is_bare else "fenced.md")
            return self.prompts.text("system.language.md", primer=text, rules=rules, answer=answer)
        fields, primitives, most = self._fields(), self._primitives(), f"{MAX_ITEMS:,}"
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
    def first(self) -> Message:
        """First user turn, which states the task. It is a fixed prefix shared by samples, repairs and critiques, for
        prompt caching."""
        task, pictures = self.task, self.task.pictures
        if task.program is not None:
            program = fenced(self.renamed.text if self.renamed else task.program, task.notation)
            takes_patches = task.notation is not Notation.LIST and not self.is_bare
            answer = self.prompts.text("patch.md" if takes_patches else "whole.md")
            text = self.prompts.text("user.edit.md", program=program, instruction=task.text, answer=answer)
        else:
            name = "user.image.md" if pictures else "user.text.md"
            text = self.prompts.text(name, example=self.example, task=task.text)
            text = f"{self._objects()}\n\n{text}"
        text = f"{self._sections()}\n\n{text}"
        if self.acceptance:
            stated = "\n".join(map(str, self.acceptance))
            text = f"{text.strip()}\n\n{self.prompts.text('accepted.md', declarations=stated)}"
        return Message("user", (*pictures, TextContent(text.strip(), is_cacheable=True)))

    def teaching(self, names: Sequence[str] = ()) -> str:
        """Return all that a prompt teaches: for a task also objects of the library, and examples of programs."""
        further = [self._objects(), self.example] if self.task.text else []
        return "\n\n".join(text for text in (self.with_sections(names), *further) if text)

    def with_sections(self, names: Sequence[str] = ()) -> str:
        """Return the system prompt with the sections of the task and others by name, each once."""
        given = [name for name in names if name not in sections_of(self.task.kind)]
        is_python = self.task.notation is Notation.PYTHON
        return with_sections(self.system, [*self._fitting(), *given], is_python)

    def _sections(self) -> str:
        """Return the sections that the task asks for by its words, or whose names the program to edit calls.

        They stand in the first turn, so that all tasks of a kind share the system prompt. A list has no functions, and
        blocks have no solids.
        """
        return with_sections("", self._fitting(), self.task.notation is Notation.PYTHON)

    def _fitting(self) -> list[str]:
        """Return the names of the sections that the task asks for."""
        task = self.task
        if task.notation is Notation.LIST or task.kind is TaskKind.BLOCKS:
            return []
        return [name for name in fitting_sections(task.text, task.program or "") if name in _BY_WORDS]

    def _objects(self) -> str:
        """Return the section about the parts of the library that fit the task, "" if there are none.

        Names are random in the ablation of words, and a list has no calls.
        """
        task = self.task
        if task.notation is Notation.LIST or task.kind is TaskKind.BLOCKS or task.ablation is not Ablation.NONE:
            return ""
        fitting = fitting_parts(task.text, _MOST_OBJECTS)
        sections = (self._section(fitting[:count]) for count in range(len(fitting), 0, -1))
        return next((section for section in sections if len(section) <= _LONGEST_OBJECTS), "")

    def _section(self, objects: Sequence[LibraryPart]) -> str:
        """Return the section about some parts of the library."""
        is_python = self.task.notation is Notation.PYTHON
        lines = "\n".join(_object_line(part, is_python=is_python) for part in objects)
        if is_python:
            return self.prompts.text("objects.python.md", objects=lines)
        modules = dict.fromkeys(f'(import "{part.record.module}")' for part in objects)
        return self.prompts.text("objects.md", modules=fenced("\n".join(modules), Notation.LANGUAGE), objects=lines)

    @cached_property
    def example(self) -> str:
        """Example program in the task's notation; of a list, the first primitives."""
        task = self.task
        language = "language." if task.notation is Notation.LANGUAGE else ""
        name = f"example.{language}{task.kind.value}.md"
        answer = self.prompts.text(name)
        programs = _FENCED.findall(answer) if language else [answer]
        sources = [Source("example.scene" if language else "example.txt", program) for program in programs]
        if self.prompts.is_replaced(name) and not (programs and all(Session().check(each).ok for each in sources)):
            raise SceneError(
                "prompt", f"the prompt template {name} contains no valid program", "run `scenelang check` on it"
            )
        if task.notation is Notation.LIST:
            return f'An example, "{_docstring(answer)}":\n\n{fenced(_example_list(sources[0], task), task.notation)}'
        texts = programs if language else [code_of(answer)]
        if task.ablation.takes_words:
            rename = rename_language if language else rename_python
            texts = [rename(text, task.seed).text for text in texts]
        head = "An example of a program:" if len(texts) == 1 else "Examples of programs:"
        return "\n\n".join([head, *(fenced(text, task.notation) for text in texts)])

    @cached_property
    def renamed(self) -> Renamed | None:
        """The program to edit, with random names for its words; None if the words are kept."""
        task = self.task
        if task.program is None or task.ablation is not Ablation.W:
            return None
        return (rename_python if task.notation is Notation.PYTHON else rename_language)(task.program, task.seed)

    def restored(self, answer: str) -> str:
        """Replace the random names in an answer by the original words."""
        return self.renamed.restored(answer) if self.renamed is not None else answer

    # --- before the program -----------------------------------------------------------------------------------------

    @cached_property
    def planning(self) -> tuple[str, Message]:
        """System prompt and turn that ask for a plan: the parts, and the declarations that the scene must fulfill."""
        lines = [f"- `{relation.usage}`: {relation.doc}" for relation in RELATIONS.values()]
        frames = self.prompts.text("plan.4d.md") if self.task.kind is TaskKind.FILM else ""
        joiner = "underscores" if self.task.notation is Notation.PYTHON else "hyphens"
        system = self.prompts.text("plan.system.md", relations="\n".join(lines), frames=frames)
        text = self.prompts.text("plan.md", task=self.task.text, joiner=joiner)
        return system, Message("user", (*self.task.pictures, TextContent(text.strip(), is_cacheable=True)))

    def replanning(self, problems: Sequence[str]) -> Message:
        """Return the turn that sends a plan back with what is wrong with it."""
        return text_message("user", self.prompts.text("replan.md", problems="\n".join(f"- {p}" for p in problems)))

    def reconsidering(self, problems: Sequence[str]) -> Message:
        """Return the turn that asks whether statements that fail say what the task does."""
        return text_message("user", self.prompts.text("reconsider.md", problems="\n".join(f"- {p}" for p in problems)))

    def part(self, word: str, described: str, written: Sequence[str]) -> Message:
        """Return the turn that asks for the function of one part."""
        known = ", ".join(f'"{each}"' for each in written) or "none"
        return text_message("user", self.prompts.text("part.md", word=word, described=described, written=known))

    def whole(self, program: str) -> Message:
        """Return the turn that asks for the function that places the parts."""
        return text_message("user", self.prompts.text("whole.parts.md", program=fenced(program, self.task.notation)))

    # --- about a scene that is built --------------------------------------------------------------------------------

    def critic(self, views: Sequence[tuple[str, ImageContent]], facts: str) -> tuple[str, Message]:
        """System prompt and turn of the critic, who sees only the task, facts and images."""
        parts = _captioned(views)
        text = self.prompts.text("critic.md", task=self.task.text, facts=facts)
        return self.prompts.text("critic.system.md"), Message("user", (*self.task.pictures, *parts, TextContent(text)))

    def revision(
        self,
        program: str,
        report: str,
        facts: str,
        tried: Sequence[str],
        views: Sequence[tuple[str, ImageContent]] = (),
    ) -> Message:
        """Return the turn that asks for a revision of a program.

        ``tried`` are revisions that made it worse, ``views`` close-ups of what is wrong, with captions.
        """
        parts = _captioned(views)
        notes = "\n\n".join(["These changes were tried and made it worse; do something else:", *tried]) if tried else ""
        text = self.prompts.text(
            "revise.md", program=fenced(program, self.task.notation), report=report, facts=facts, tried=notes,
            patch=self.prompts.text("patch.md"),
        )  # fmt: skip
        return Message("user", (*parts, TextContent(_GAP.sub("\n\n", text))))

    # --- about an answer ------------------------------------------------------------------------------------------

    def repair(self, diagnostics: str) -> Message:
        return text_message("user", self.prompts.text("repair.md", diagnostics=diagnostics))

    def cut(self, tokens: int) -> Message:
        return text_message("user", self.prompts.text("cut.md", tokens=f"{tokens:,}"))

    def critique(self, views: Sequence[tuple[str, ImageContent]], findings: str, facts: str = "") -> Message:
        """Return the critique turn: captioned images, facts and findings about the scene, then the instructions."""
        parts = _captioned(views)
        notes = [self.prompts.text("blocks.md")] if self.task.kind is TaskKind.BLOCKS else []
        notes += [facts] if facts else []
        notes += [f"The checker noticed:\n\n{findings}"] if findings else []
        text = _GAP.sub("\n\n", self.prompts.text("critique.md", notes="\n\n".join(notes)))
        return Message("user", (*parts, TextContent(text)))


def _read(word: str) -> list[str]:
    """Return the attributes of a primitive that are documented for lists; blocks have the color of their type."""
    return [name for name in attributes_read(word) if not (name == "color" and word in block_words())]


def _object_line(part: LibraryPart, *, is_python: bool) -> str:
    """Return the call of a part, its size, its front and its sockets."""
    size = " x ".join(f"{side:g}" for side in part.size)
    sockets = ", ".join(_socket_usage(socket, is_python=is_python) for socket in part.sockets)
    usage = part.python_usage if is_python else part.usage
    return f"- `{usage}`: {size}; {part.front.rstrip('.')}{f' | {sockets}' if sockets else ''}"


def _socket_usage(socket: ReferenceRecord, *, is_python: bool) -> str:
    """Return the call of a socket with its keywords, and whether it returns a list."""
    if is_python:
        call = f"{python_name(socket.name)}({', '.join(map(python_name, socket.keywords))})"
    else:
        call = f"({' '.join([socket.name, *(f':{name}' for name in socket.keywords)])})"
    return f"`{call}`{' (a list)' if 'List[' in socket.signature else ''}"


def _docstring(answer: str) -> str:
    pieces = code_of(answer).split('"""')
    return pieces[1].strip() if len(pieces) > 1 else "a scene"


def _example_list(source: Source, task: Task) -> str:
    scene = Session().evaluate(source).scene
    assert scene is not None, "the example in the prompt template must be valid"
    lines = listing(scene, not task.ablation.takes_words).splitlines()
    ends = ["...", "],", "...", "]"] if scene.animated else ["...", "]"]
    return "\n".join([*lines[:_SHOWN], *ends]) if len(lines) > _SHOWN + len(ends) else "\n".join(lines)
