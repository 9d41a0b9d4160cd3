"""Language templates: the sentence that describes one primitive to a neural backend (paper, section 4)."""

from __future__ import annotations

import re

from scenelang.grammar.diagnostics import SceneError

DEFAULT = "a {embedding} {word}, in the style of {style}, 3D model"
HOLE = "{embedding}"
MAX_TEMPLATE = 500  # characters
_HOLES = (HOLE, "{word}", "{style}")
_LONE = re.compile(r"\{[^{}]*\}|[{}]")
_ADJECTIVE = 3  # words of the longest part of a text that stands before the thing
_CONSONANT = ("uni", "use", "eu", "one")  # written with a vowel, spoken with a consonant


def check_template(template: str) -> None:
    """Raises SceneError("value") for a template that is no line of text, or whose braces mean nothing."""
    known = "a template knows {embedding}, {word} and {style}"
    for brace in _LONE.findall(template):
        if brace not in _HOLES:
            raise SceneError("value", f"`{brace}` means nothing in a template", known)
    if HOLE not in template:
        raise SceneError("value", "a template without {embedding} says nothing of how a thing looks", known)
    if len(template) > MAX_TEMPLATE or not template.isprintable():
        raise SceneError("value", f"a template is one line of at most {MAX_TEMPLATE} characters")


def template_for(template: str, word: str, style: str) -> str:
    """The template of things called ``word`` under the root's handle ``style``; only ``{embedding}`` is left open."""
    return template.replace("{style}", f"<{style}>").replace("{word}", word)


def filled(template: str, handle: str) -> str:
    """The sentence for the primitive with ``handle``: `a <z68> pawn, in the style of <z1>, 3D model`."""
    return template.replace(HOLE, f"<{handle}>")


def plain_text(word: str, text: str) -> str:
    """The sentence without handles, for models that read plain text: `an ivory pawn, 3D model`. Longer parts of the
    text, and numbers, follow the thing: `a tall door, height 3, 3D model`."""
    parts = [part for part in re.split(r"\s*[,;\n]\s*", text) if part]
    before = [part for part in parts if len(part.split()) <= _ADJECTIVE and not re.search(r"\d", part)]
    after = [part for part in parts if part not in before]
    phrase = f"{', '.join(before)} {word}".strip()
    return ", ".join([with_article(f"a {phrase}"), *after, "3D model"])


def with_article(sentence: str) -> str:
    """A sentence that begins with "a" with "an" where that is how it is spoken: `an ivory pawn`."""
    rest = sentence.removeprefix("a ")
    vowel = rest[:1].lower() in tuple("aeiou") and not rest.lower().startswith(_CONSONANT)
    return f"an {rest}" if vowel and rest != sentence else sentence
