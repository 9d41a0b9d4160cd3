"""What pictures show, as sentences with the pseudo-words that are to be learned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenelang.backends.clip.prompts import Prompt, Slot, parse_prompt, with_texts
from scenelang.backends.diffusion.words import Words
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Tensor

TEMPLATE = "<class>, 3d model, in the style of <style>"  # the paper's
STYLE = "style"  # the pseudo-word that all pictures of an inversion share


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """``picture`` (3, H, W), sRGB in [0, 1], is what ``prompt`` says; H and W are those of the model's pictures."""

    picture: Tensor
    prompt: Prompt


def sentence_of(name: str) -> Prompt:
    """The template with the pseudo-word ``name`` for the class."""
    return tuple(Slot(name) if piece == Slot("class") else piece for piece in parse_prompt(TEMPLATE))


def sentence_about(word: str) -> Prompt:
    """The template with ``word`` written out for the class, so that the style alone is left to learn."""
    return with_texts(parse_prompt(TEMPLATE), lambda name: word if name == "class" else None)


def start_of(words: Words, text: str) -> Tensor:
    """The vector (1, width) that a pseudo-word starts from: that of the word ``text``, of several tokens their mean.

    Raises SceneError("value") for a text without tokens.
    """
    vectors = words.vectors_of(text).detach()
    if not len(vectors):
        raise SceneError("value", f'a pseudo-word cannot start from "{text}", which has no tokens')
    return vectors.float().mean(0, keepdim=True)
