"""The paper's user study: a self-contained page on which participants choose the result that fits a prompt best."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import random
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.console.reports import table
from scenelang.grammar.diagnostics import SceneError

FORMAT, VERSION = "scenelang-study", 1
_MAX_BYTES = 500_000_000  # maximum size of a page
_NUMBERS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 7: "seven", 8: "eight", 9: "nine"}
_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
_KINDS = {".mp4": "video/mp4", ".gif": "image/gif", ".webp": "image/webp", ".apng": "image/apng", ".png": "image/png",
          ".jpg": "image/jpeg", ".jpeg": "image/jpeg"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class StudyResult:
    """Result of a method for a prompt: the bytes of an image or video file with that extension."""

    method: str
    data: bytes
    ending: str


@dataclass(frozen=True, slots=True)
class StudyQuestion:
    """A prompt and the results to choose from, in display order."""

    prompt: str
    results: tuple[StudyResult, ...]


def questions_of(tasks: Sequence[StudyQuestion], seed: int) -> list[StudyQuestion]:
    """Create the questions, with questions and results shuffled by the seed.

    Raises SceneError("value") without tasks, or if a prompt has fewer than 2, more than 26, or duplicate methods.
    """
    if not tasks:
        raise SceneError("value", "expected at least one prompt")
    for task in tasks:
        methods = [result.method for result in task.results]
        if not 2 <= len(methods) <= len(_LETTERS):
            message = f'"{task.prompt[:60]}" has {len(methods)} methods, expected 2 to {len(_LETTERS)}'
            raise SceneError("value", message, hint=_HINT)
        if len(set(methods)) != len(methods):
            raise SceneError("value", f'"{task.prompt[:60]}" has two results of one method', hint=_HINT)
    draws = random.Random(f"study {seed}")
    shown = [StudyQuestion(task.prompt, tuple(draws.sample(task.results, len(task.results)))) for task in tasks]
    draws.shuffle(shown)
    return shown


_HINT = 'a list of {"prompt": TEXT, "method": NAME, "scene" or "film": FILE} with several methods for each prompt'


def study_page(questions: Sequence[StudyQuestion]) -> str:
    """Return the page as self-contained HTML. The assignment of results to methods is only in its data.

    Raises SceneError("unsupported") if the results are too large for one page.
    """
    if sum(len(result.data) for question in questions for result in question.results) > _MAX_BYTES // 4 * 3:
        raise SceneError("unsupported", "the videos are too large for one page", hint="use a smaller --size")
    data_of_page = {
        "format": FORMAT,
        "version": VERSION,
        "study": study_id(questions),
        "questions": [{"prompt": q.prompt, "methods": [result.method for result in q.results]} for q in questions],
    }
    script, style = (files(__package__).joinpath(f"study.{kind}").read_text("utf-8") for kind in ("js", "css"))
    policy = (
        f"default-src 'none'; img-src data:; media-src data:; script-src '{_digest(script)}'; "
        f"style-src '{_digest(style)}'; base-uri 'none'; form-action 'none'"
    )
    data = json.dumps(data_of_page).replace("<", "\\u003c")
    fieldsets = "".join(_fieldset(number, question) for number, question in enumerate(questions))
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><title>User study</title>'
        f'<style>{style}</style></head>\n<body><main><h1>User study</h1><p id="instruction">'
        f'{html.escape(instruction(questions))}</p>\n<form id="form">{fieldsets}</form>\n'
        '<p id="progress" role="status"></p><button id="save" type="button" disabled>Download the answers</button>'
        f'</main>\n<script type="application/json" id="study">{data}</script>\n<script>{script}</script>'
        "</body></html>\n"
    )


def instruction(questions: Sequence[StudyQuestion]) -> str:
    """Return the paper's instruction for this number of results."""
    counts = {len(question.results) for question in questions}
    many = _NUMBERS.get(counts.pop(), "several") if len(counts) == 1 else "several"
    return (
        f"In the following questions, you'll be provided a list of text descriptions and corresponding {many} "
        "generation results. Please choose the one that has best text-alignment, taking into account both the "
        "visual quality and the adherence to the layout structure outlined in the text prompt."
    )


def study_id(questions: Sequence[StudyQuestion]) -> str:
    """Return an identifier of a study, independent of the display order."""
    content = sorted(
        [question.prompt, sorted([r.method, hashlib.sha256(r.data).hexdigest()] for r in question.results)]
        for question in questions
    )
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]


def _fieldset(number: int, question: StudyQuestion) -> str:
    choices = "".join(
        f'<label><input type="radio" name="q{number}" value="{place}">{_media(result, _LETTERS[place])}'
        f"<span>{_LETTERS[place]}</span></label>"
        for place, result in enumerate(question.results)
    )
    legend = f"{number + 1}. {html.escape(question.prompt)}"
    return f'<fieldset><legend>{legend}</legend><div class="results">{choices}</div></fieldset>\n'


def _media(result: StudyResult, letter: str) -> str:
    source = f"data:{_KINDS[result.ending]};base64,{base64.b64encode(result.data).decode()}"
    if result.ending == ".mp4":
        return f'<video src="{source}" autoplay loop muted playsinline aria-label="Result {letter}"></video>'
    return f'<img src="{source}" alt="Result {letter}">'


def _digest(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


# Answers of a study: files saved by participants, evaluated as percentages of preference.


_FORMAT, _VERSION = "scenelang-study-answers", 1
_MAX_ANSWER_BYTES = 4_000_000


@dataclass(frozen=True, slots=True)
class Answers:
    """Answers of one participant: for each prompt the available methods, and the chosen one."""

    study: str
    participant: str
    choices: Mapping[str, tuple[tuple[str, ...], str]]


@dataclass(frozen=True, slots=True)
class Preferences:
    """Number of participants, and for each prompt the percentage that chose each method."""

    participants: int
    percentages: Mapping[str, Mapping[str, float]]

    @property
    def methods(self) -> list[str]:
        return sorted({method for shares in self.percentages.values() for method in shares})

    def of(self, method: str) -> tuple[float, float]:
        """Return the mean percentage of a method and its standard deviation across prompts."""
        values = [shares[method] for shares in self.percentages.values() if method in shares]
        return float(np.mean(values)), float(np.std(values))

    def data(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        means = {method: dict(zip(("mean", "deviation"), self.of(method), strict=True)) for method in self.methods}
        prompts = [{"prompt": prompt, "percentages": dict(p)} for prompt, p in self.percentages.items()]
        return {"participants": self.participants, "methods": means, "prompts": prompts}

    def __str__(self) -> str:
        """Return a table of the percentages, and the number of participants."""
        rows = [("preferred, %", *self.methods)]
        for prompt, shares in self.percentages.items():
            cells = (f"{shares[method]:.2f}" if method in shares else "-" for method in self.methods)
            rows.append((prompt if len(prompt) <= 60 else f"{prompt[:57]}...", *cells))
        rows.append(("all", *("{:.2f} ± {:.2f}".format(*self.of(method)) for method in self.methods)))
        people = f"{self.participants:,} {'participant' if self.participants == 1 else 'participants'}"
        return f"{table(rows, (False, *(True for _ in self.methods)))}\n{people}"


def preferences(paths: Sequence[Path]) -> Preferences:
    """Evaluate the answers in files.

    Raises SceneError: "file" for an invalid file, "value" if answers belong to different studies, or two files to one
    participant.
    """
    by_file = [read_answers(path) for path in paths]
    seen: dict[str, Path] = {}
    for path, answers in zip(paths, by_file, strict=True):
        if answers.study != by_file[0].study or _methods_by_prompt(answers) != _methods_by_prompt(by_file[0]):
            raise SceneError("value", f"{path} and {paths[0]} contain answers to different studies")
        if answers.participant in seen:
            raise SceneError("value", f"{path} and {seen[answers.participant]} contain answers of the same participant")
        seen[answers.participant] = path
    percentages = {}
    for prompt, (methods, _) in by_file[0].choices.items():
        chosen = Counter(answers.choices[prompt][1] for answers in by_file)
        percentages[prompt] = {method: 100.0 * chosen[method] / len(by_file) for method in methods}
    return Preferences(len(by_file), percentages)


def _methods_by_prompt(answers: Answers) -> dict[str, tuple[str, ...]]:
    return {prompt: methods for prompt, (methods, _) in answers.choices.items()}


def read_answers(path: Path) -> Answers:
    """Read one file of answers; raises SceneError("file")."""
    try:
        if path.stat().st_size > _MAX_ANSWER_BYTES:
            raise ValueError("file too large")
        data = json.loads(path.read_text("utf-8"))
        if not isinstance(data, dict):
            raise ValueError("not an answers file")
        if data["format"] != _FORMAT or data["version"] != _VERSION:
            raise ValueError("unsupported format or version")
        choices = dict(_choice(item) for item in data["answers"])
        if not choices or len(choices) != len(data["answers"]):
            raise ValueError("no answers, or duplicate answers to a question")
        return Answers(_text(data["study"]), _text(data["participant"]), choices)
    except KeyError as error:
        message = f"missing {error}"
    except (OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        message = str(error)[:120]
    raise SceneError("file", f"cannot read the answers in {path}: {message}")


def _choice(item: Any) -> tuple[str, tuple[tuple[str, ...], str]]:
    methods = tuple(sorted({_text(method) for method in item["methods"]}))
    if item["choice"] not in methods:
        raise ValueError("a choice is not one of the methods")
    return _text(item["prompt"]), (methods, item["choice"])


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError("expected a string")
    return value
