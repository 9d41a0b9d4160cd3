"""The paper's user study: which of several results fits a text best, asked by one page that needs no network."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import random
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

from scenelang.grammar.diagnostics import SceneError

FORMAT, VERSION = "scenelang-study", 1
_MOST_BYTES = 500_000_000  # of one page
_NUMBERS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 7: "seven", 8: "eight", 9: "nine"}
_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
_KINDS = {".mp4": "video/mp4", ".gif": "image/gif", ".webp": "image/webp", ".apng": "image/apng", ".png": "image/png",
          ".jpg": "image/jpeg", ".jpeg": "image/jpeg"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Result:
    """What a method made of a text: a picture or film as the bytes of a file with that ending."""

    method: str
    data: bytes
    ending: str


@dataclass(frozen=True, slots=True)
class Question:
    """A text and the results to choose from, in the order in which they are shown."""

    prompt: str
    results: tuple[Result, ...]


def questions_of(tasks: Sequence[Question], seed: int) -> list[Question]:
    """The tasks and their results, each in an order that the seed draws.

    Raises SceneError("value") for no task, for a text with fewer than two results, more than 26, or two of one method.
    """
    if not tasks:
        raise SceneError("value", "there is nothing to choose from")
    for task in tasks:
        methods = [result.method for result in task.results]
        if not 2 <= len(methods) <= len(_LETTERS):
            said = f'"{task.prompt[:60]}" has {len(methods)} to choose from, not 2 to {len(_LETTERS)}'
            raise SceneError("value", said, hint=_HINT)
        if len(set(methods)) != len(methods):
            raise SceneError("value", f'"{task.prompt[:60]}" has two results of one method', hint=_HINT)
    draws = random.Random(f"study {seed}")
    shown = [Question(task.prompt, tuple(draws.sample(task.results, len(task.results)))) for task in tasks]
    draws.shuffle(shown)
    return shown


_HINT = 'a list of {"prompt": TEXT, "method": NAME, "scene" or "film": FILE} has several methods for each prompt'


def study_page(questions: Sequence[Question]) -> str:
    """The page as HTML: it loads nothing and may load nothing. Which method is which stands in its data alone.

    Raises SceneError("unsupported") where the results are too large for one page.
    """
    if sum(len(result.data) for question in questions for result in question.results) > _MOST_BYTES // 4 * 3:
        raise SceneError("unsupported", "the films are too large for one page", hint="choose a smaller --size")
    told = {
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
    data = json.dumps(told).replace("<", "\\u003c")
    asked = "".join(_fieldset(number, question) for number, question in enumerate(questions))
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><title>User study</title>'
        f'<style>{style}</style></head>\n<body><main><h1>User study</h1><p id="instruction">'
        f'{html.escape(instruction(questions))}</p>\n<form id="form">{asked}</form>\n'
        '<p id="progress" role="status"></p><button id="save" type="button" disabled>Download the answers</button>'
        f'</main>\n<script type="application/json" id="study">{data}</script>\n<script>{script}</script>'
        "</body></html>\n"
    )


def instruction(questions: Sequence[Question]) -> str:
    """The paper's, for as many results as there are."""
    counts = {len(question.results) for question in questions}
    many = _NUMBERS.get(counts.pop(), "several") if len(counts) == 1 else "several"
    return (
        f"In the following questions, you'll be provided a list of text descriptions and corresponding {many} "
        "generation results. Please choose the one that has best text-alignment, taking into account both the "
        "visual quality and the adherence to the layout structure outlined in the text prompt."
    )


def study_id(questions: Sequence[Question]) -> str:
    """What tells a study from others, whatever the order in which it is shown."""
    content = sorted(
        [question.prompt, sorted([r.method, hashlib.sha256(r.data).hexdigest()] for r in question.results)]
        for question in questions
    )
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]


def _fieldset(number: int, question: Question) -> str:
    choices = "".join(
        f'<label><input type="radio" name="q{number}" value="{place}">{_media(result, _LETTERS[place])}'
        f"<span>{_LETTERS[place]}</span></label>"
        for place, result in enumerate(question.results)
    )
    legend = f"{number + 1}. {html.escape(question.prompt)}"
    return f'<fieldset><legend>{legend}</legend><div class="results">{choices}</div></fieldset>\n'


def _media(result: Result, letter: str) -> str:
    source = f"data:{_KINDS[result.ending]};base64,{base64.b64encode(result.data).decode()}"
    if result.ending == ".mp4":
        return f'<video src="{source}" autoplay loop muted playsinline aria-label="Result {letter}"></video>'
    return f'<img src="{source}" alt="Result {letter}">'


def _digest(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
