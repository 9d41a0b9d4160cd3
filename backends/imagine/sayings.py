"""What the model is told of each place of a layout, and of the whole picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from scenelang.backends.clip.conditions import Condition, resolved
from scenelang.backends.clip.prompts import Prompt, Slot
from scenelang.backends.imagine.layout import Layout, Place
from scenelang.backends.maps.truth import Truth
from scenelang.backends.wording.readable import has_meaning, thing
from scenelang.backends.wording.templates import DEFAULT, filled, plain_text, template_for
from scenelang.backends.wording.wording import Wording
from scenelang.interpreter.entity import Entity


@dataclass(frozen=True, slots=True)
class Book:
    """All that is known in words: the scene's ``wording``, the ``texts`` that Z has for handles, which beat it, and the
    handles that have ``learned`` vectors which the model can read."""

    wording: Wording
    texts: Mapping[str, str]
    learned: frozenset[str]

    @property
    def style(self) -> str:
        return self.texts.get(self.wording.style, self.wording.style_text)

    def known(self) -> dict[str, str]:
        """The text of every handle."""
        found = {handle: row.text for row in self.wording.rows for handle in row.handles}
        return {**found, self.wording.style: self.wording.style_text, **self.texts}

    def scene_prompt(self, text: str) -> Prompt:
        """A sentence of the user's, in which handles may stand; raises SceneError("value") for one that nothing has."""
        return resolved(text, self.known(), self.learned)


def conditions_in(layout: Layout, truth: Truth, handles: Sequence[str], book: Book) -> list[Condition]:
    """The condition of every place; ``handles`` are those of all instances. Raises SceneError("value").

    An entity taken as one is told by its own text, else by that of the primitive of it that shows most.
    """
    rows = {(handle, row.word): row for row in book.wording.rows for handle in row.handles}
    found = []
    for place in layout.places:
        word = _named(truth, place.instance)
        handle = handles[place.instance]
        row = rows.get((handle, word))
        if row is None:
            shown = _shown_most(truth, place)
            row_below = rows.get((handles[shown], _named(truth, shown)))
            own = (truth.ancestry.entity(place.instance).embedding.text or "").strip()
            text = own or (row_below.text if row_below is not None else "")
            template = template_for(DEFAULT, word, book.wording.style)
        else:
            text, template = row.text, row.template
        text = book.texts.get(handle, text)
        known = {book.wording.style: book.style, handle: text}
        found.append(
            Condition(word, resolved(filled(template, handle), known, book.learned), plain_text(word, text), (handle,))
        )
    return found


def readable(prompt: Prompt) -> str:
    """A prompt as a person writes it, handles in angle brackets."""
    return "".join(f"<{piece.name}>" if isinstance(piece, Slot) else piece for piece in prompt)


def _named(truth: Truth, instance: int) -> str:
    """What an instance is called: its word, or that of the nearest one around it that says what it is."""
    ancestry, start = truth.ancestry, instance
    while instance >= 0:
        entity: Entity = ancestry.entity(instance)
        if has_meaning(entity.word):
            return thing(entity)
        instance = int(ancestry.parent[instance])
    return thing(ancestry.entity(start))


def _shown_most(truth: Truth, place: Place) -> int:
    """The primitive of an instance that shows in most pixels."""
    ancestry = truth.ancestry
    x0, y0, x1, y1 = place.box
    window = truth.instance[int(y0) : int(y1) + 1, int(x0) : int(x1) + 1]
    at_level = ancestry.at_depth(int(ancestry.depth[place.instance]))
    inside = window[(window >= 0) & (at_level[np.maximum(window, 0)] == place.instance)]
    numbers, counts = np.unique(inside, return_counts=True)
    return int(numbers[np.argmax(counts)])
