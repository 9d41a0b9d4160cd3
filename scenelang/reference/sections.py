"""Sections of prompts, about films, solids, relations and blocks: by kind of scene, by words of the task, or by name.

What each names comes from the registries of builtins, relations and primitives. A prompt without a section stays short;
a task about a pipe or a sign gets the one that says how to make these.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.grammar.python_helpers import HELPERS
from scenelang.interpreter.runtime.modelling_helpers import python_name
from scenelang.interpreter.scene.declarations import FRAME_FLAGS, RELATIONS
from scenelang.interpreter.scene.primitives import block_words
from scenelang.reference.primer import (
    group_lines,
    primitive_lines,
    python_lines,
    python_relation,
    relation_usage,
    taught_groups,
)
from scenelang.reference.searching import is_like, synonyms_of
from scenelang.stdlib.reference import in_python_terms, python_primitives

MAX_SECTION = 1_500  # characters


@dataclass(frozen=True, slots=True)
class PromptSection:
    """Section of a prompt.

    Attributes
    ----------
    title
        Its heading.
    groups
        Names of the language that it teaches by group, as those of the primer: a tilde for every sentence that explains
        a name.
    relations
        Relations that it teaches.
    words
        Words of tasks that ask for it, besides the names in ``groups`` and their synonyms: nouns for what is made so.
    primitives
        Primitives that it teaches.
    helpers
        Decorators of the helper API that it teaches.
    text
        Further text.
    """

    title: str
    groups: Mapping[str, str] = field(default_factory=dict)
    relations: tuple[str, ...] = ()
    words: str = ""
    primitives: tuple[str, ...] = ()
    helpers: tuple[str, ...] = ()
    text: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the language that it teaches."""
        return tuple(name.rstrip("~") for text in self.groups.values() for name in text.split())


SECTIONS: Mapping[str, PromptSection] = MappingProxyType({
    "films": PromptSection(
        "Films",
        {"Frames": "frames~~"},
        ("moves", "turns", "path"),
        helpers=("register_animation",),
        text="Every relation holds in all frames, or with one of {flags} in that frame, in one, or in none.",
    ),
    "solids": PromptSection(
        "More solids",
        {
            "Solids": "intersection solid-union hull~ sweep~ loft rounded~ shell~ text~",
            "Profiles": "regular-polygon~ star spline profile-union profile-difference offset-profile~",
            "Paths": "polyline bezier catmull-rom helix~",
        },
        words="arch bent bottle bowl cable chain coil cup curved engraved flute funnel gear handle hollow hose jug knot"
        " inscription letter logo mug pot rail rope ship sign smooth spring teapot thread trumpet vase vault wheel",
        text="Profiles are in the plane of x and y, paths arrays of points [x y z]; lengths are in scene units, angles"
        " in radians.",
    ),
    "relations": PromptSection(
        "More relations",
        relations=(
            "proportion", "aspect", "outline", "encircles", "rising", "elevation", "reachable", "visible-from",
        ),
        words="accessible blocked circle door entrance heights oval proportions reach reachable round see seen spiral"
        " staircase surround twice view visible",
    ),
    "blocks": PromptSection("Minecraft blocks", relations=("made-of",), words="minecraft", primitives=block_words()),
})  # fmt: skip


def section_text(name: str, is_python: bool = False) -> str:
    """Return a section as Markdown.

    Parameters
    ----------
    name
        Key of ``SECTIONS``.
    is_python
        For Python mode; else for the language.

    Raises
    ------
    SceneError
        "value" for an unknown name.

    Examples
    --------
    >>> "(helix radius height turns)" in section_text("solids")
    True
    """
    if name not in SECTIONS:
        hint = suggest(name, SECTIONS) or f"expected one of {', '.join(SECTIONS)}"
        raise SceneError("value", f"unknown section `{name}` of the primer", hint)
    section = SECTIONS[name]
    groups = taught_groups(section.groups)
    lines = [*_primitives(section, is_python=is_python), *(python_lines(groups) if is_python else group_lines(groups))]
    flags = ", ".join(f"`{flag}=True`" if is_python else f"`:{flag}`" for flag in FRAME_FLAGS)
    told = in_python_terms(section.text) if is_python else section.text
    text = [told.format(flags=flags)] if told else []
    return "\n".join([f"## {section.title}\n", *lines, *_relations(section, is_python=is_python), *text])


def _primitives(section: PromptSection, *, is_python: bool) -> Iterator[str]:
    """Yield the primitives of a section, and its decorators of Python mode."""
    yield from (f"- `@{name}()`: {HELPERS[name].note}" for name in section.helpers if is_python)
    if section.primitives and is_python:
        yield "`primitive_call` also takes:"
        yield from (line for line in python_primitives(section.primitives) if line)
    elif section.primitives:
        yield from list(primitive_lines(section.primitives))[1:]  # without the heading


def _relations(section: PromptSection, *, is_python: bool) -> Iterator[str]:
    """Yield the relations of a section."""
    for name in section.relations:
        usage, doc = (python_relation if is_python else relation_usage)(name), RELATIONS[name].doc
        told = re.sub(r"`:(\w+)`", r"`\1`", doc) if is_python else doc
        yield f"- `{usage}`: {told}"


def fitting_sections(text: str, program: str = "") -> tuple[str, ...]:
    """Return the sections that a task asks for by its words, or that a program to edit uses.

    Examples
    --------
    >>> fitting_sections("a bent pipe")
    ('solids',)
    >>> fitting_sections("two boxes")
    ()
    """
    words = re.findall(r"[a-z]+", text.lower())
    called = set(re.findall(r"[\w-]+", program))
    return tuple(
        name
        for name, section in SECTIONS.items()
        if any(is_like(word, known) for word in words for known in _index(name)) or called & _calls(section)
    )


@cache
def _index(name: str) -> frozenset[str]:
    """Return the words that ask for a section: those of its names, what people call these, and its own."""
    section = SECTIONS[name]
    parts = {part for each in section.names for part in each.split("-")} - _GENERAL
    return frozenset({*parts, *synonyms_of(section.names), *section.words.split()}) - _GENERAL


# Words of names and synonyms that say nothing of how an object is made: "a union of", "the regular shape".
_GENERAL = frozenset(
    ("union", "difference", "solid", "profile", "regular", "polygon", "rom", "text", "merge", "combine", "group")
)


def _calls(section: PromptSection) -> set[str]:
    """Return the names that a program calls which uses what a section teaches."""
    return {written for name in (*section.names, *section.primitives) for written in (name, python_name(name))}


def with_sections(text: str, names: Sequence[str], is_python: bool = False) -> str:
    """Return a primer followed by sections, each once."""
    return "\n\n".join([text, *(section_text(name, is_python) for name in dict.fromkeys(names))])
