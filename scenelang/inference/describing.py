"""How things look, in a language model's words (the paper, section 5: a colour's value described as a word)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence

from scenelang.backends.language_models.client import Client
from scenelang.backends.language_models.conversation import said
from scenelang.backends.wording.describing import Question
from scenelang.inference.live_count import LiveCount
from scenelang.inference.prompts import Prompts
from scenelang.inference.steps import Speaker

_IN_ONE_REQUEST = 60
_LINE = re.compile(r"^\s*(\d{1,4})\s*[.:)]\s*(.+?)\s*$", re.M)
_DIGITS = 3


class Describer:
    """Asks a model for words, some things at a time. What it does not answer comes back empty."""

    def __init__(self, client: Client, prompts: Prompts, speaker: Speaker, live: LiveCount) -> None:
        self._client = client
        self._prompts = prompts
        self._speaker = speaker
        self._live = live

    @property
    def spent(self) -> float:
        """US dollars."""
        return self._client.spending.spent

    def __call__(self, questions: Sequence[Question]) -> list[str]:
        """A text for each question. Raises SceneError where the model cannot be asked."""
        try:
            pieces = range(0, len(questions), _IN_ONE_REQUEST)
            return [text for at in pieces for text in self._asked(questions[at : at + _IN_ONE_REQUEST], at)]
        finally:
            self._live.end()

    def _asked(self, questions: Sequence[Question], at: int) -> Iterator[str]:
        lines = "\n".join(f"{number}. {_told(question)}" for number, question in enumerate(questions, 1))
        turn = said("user", self._prompts.text("words.md", questions=lines))
        request = self._speaker.request(self._prompts.text("words.system.md"), (turn,))
        answer = self._client.ask(request, at, 1, self._live.counting(0, at, "words"))
        found = {int(number): text.strip("\"'") for number, text in _LINE.findall(answer.reply.text)}
        return (found.get(number, "") for number in range(1, len(questions) + 1))


def _told(question: Question) -> str:
    """A question in a line: the thing, its numbers, what the table of colours calls it."""
    attributes = {name: _short(value) for name, value in question.attributes.items()}
    color = f", about {question.color}" if question.color else ""
    return f"{json.dumps(question.word, ensure_ascii=False)}{color}: {json.dumps(attributes, ensure_ascii=False)[:300]}"


def _short(value: object) -> object:
    if isinstance(value, float):
        return round(value, _DIGITS)
    return [_short(item) for item in value] if isinstance(value, list) else value
