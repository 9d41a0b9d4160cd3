"""What neural backends are told of each primitive: its sentence, with learned vectors where Z has them (the paper,
section 4: the template c and z = g_CLIP(c))."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from scenelang.backends.clip.prompts import Prompt, parse_prompt, slots, with_texts
from scenelang.grammar.diagnostics import SceneError


@dataclass(frozen=True, slots=True)
class Condition:
    """What is said of primitives of one look: ``prompt`` with slots for learned vectors only, ``plain`` the sentence
    for models that read plain text, and the ``handles`` of their embeddings."""

    word: str
    prompt: Prompt
    plain: str
    handles: tuple[str, ...]


def together(conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """Each sentence once, with the handles of all that it is said of."""
    found: dict[tuple[str, Prompt], tuple[str, dict[str, None]]] = {}
    for each in conditions:
        _, handles = found.setdefault((each.word, each.prompt), (each.plain, {}))
        handles.update(dict.fromkeys(each.handles))
    return tuple(Condition(word, prompt, plain, tuple(handles)) for (word, prompt), (plain, handles) in found.items())


def resolved(text: str, texts: Mapping[str, str], learned: frozenset[str]) -> Prompt:
    """A prompt in which only handles with vectors are left open, the others written out.

    Raises SceneError("value") for a handle that has neither.
    """
    prompt = with_texts(parse_prompt(text), lambda name: None if name in learned else texts.get(name))
    unknown = [name for name in slots(prompt) if name not in learned]
    if unknown:
        raise SceneError(
            "value",
            f"<{unknown[0]}> has neither vectors nor a text",
            hint=f"give it one: scenelang embeddings FILE set '<{unknown[0]}>' --text \"...\"",
        )
    return prompt
