"""The answers of a study: files that its page gave people, as percentages of preference."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError

_FORMAT, _VERSION = "scenelang-study-answers", 1
_MOST_BYTES = 4_000_000


@dataclass(frozen=True, slots=True)
class Answers:
    """One participant's: for each prompt the methods there were, and the one chosen."""

    study: str
    participant: str
    choices: Mapping[str, tuple[tuple[str, ...], str]]


@dataclass(frozen=True, slots=True)
class Preferences:
    """How many participants there were, and for each prompt the percentage of them that chose each method."""

    participants: int
    percentages: Mapping[str, Mapping[str, float]]

    @property
    def methods(self) -> list[str]:
        return sorted({method for shares in self.percentages.values() for method in shares})

    def of(self, method: str) -> tuple[float, float]:
        """The mean percentage of a method and its standard deviation, across the prompts that it has results for."""
        values = [shares[method] for shares in self.percentages.values() if method in shares]
        return float(np.mean(values)), float(np.std(values))


def preferences(paths: Sequence[Path]) -> Preferences:
    """What the answers in files amount to.

    Raises SceneError: "file" for one that is no file of answers, "value" where they are of different studies, or two
    are of one participant.
    """
    found = [read_answers(path) for path in paths]
    seen: dict[str, Path] = {}
    for path, answers in zip(paths, found, strict=True):
        if answers.study != found[0].study or _asked(answers) != _asked(found[0]):
            raise SceneError("value", f"{path} has answers to another study than {paths[0]}")
        if answers.participant in seen:
            raise SceneError("value", f"{path} and {seen[answers.participant]} are answers of one participant")
        seen[answers.participant] = path
    percentages = {}
    for prompt, (methods, _) in found[0].choices.items():
        chosen = Counter(answers.choices[prompt][1] for answers in found)
        percentages[prompt] = {method: 100.0 * chosen[method] / len(found) for method in methods}
    return Preferences(len(found), percentages)


def _asked(answers: Answers) -> dict[str, tuple[str, ...]]:
    return {prompt: methods for prompt, (methods, _) in answers.choices.items()}


def read_answers(path: Path) -> Answers:
    """One file of answers; raises SceneError("file")."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise ValueError("it is too large")
        data = json.loads(path.read_text("utf-8"))
        if not isinstance(data, dict):
            raise ValueError("it is another kind of file")
        if data["format"] != _FORMAT or data["version"] != _VERSION:
            raise ValueError("it is another kind of file")
        choices = dict(_choice(item) for item in data["answers"])
        if not choices or len(choices) != len(data["answers"]):
            raise ValueError("it has no answers, or two to one question")
        return Answers(_text(data["study"]), _text(data["participant"]), choices)
    except KeyError as error:
        said = f"there is no {error}"
    except (OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        said = str(error)[:120]
    raise SceneError("file", f"{path} holds no answers that can be read: {said}")


def _choice(item: Any) -> tuple[str, tuple[tuple[str, ...], str]]:
    methods = tuple(sorted({_text(method) for method in item["methods"]}))
    if item["choice"] not in methods:
        raise ValueError("a choice is none of its methods")
    return _text(item["prompt"]), (methods, item["choice"])


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError("a text of it is none")
    return value
