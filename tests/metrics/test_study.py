"""The page of the user study, as text, and what its answers amount to."""

from __future__ import annotations

import base64
import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from scenelang.evaluation.study import (
    StudyQuestion,
    StudyResult,
    instruction,
    preferences,
    questions_of,
    study_id,
    study_page,
)
from scenelang.grammar.diagnostics import SceneError

METHODS = ("Ours", "MVDream", "GraphDreamer")
TASKS = [
    StudyQuestion(prompt, tuple(StudyResult(method, f"{prompt} {method}".encode(), ".webp") for method in METHODS))
    for prompt in ("a cube", "a sphere", "two cones", "three trees")
]


class Page(HTMLParser):
    """What a browser would find: texts by tag, attributes, legends with their pictures in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.legends: list[str] = []
        self.pictures: list[list[str]] = []
        self.scripts: list[str] = []
        self._inside = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.tags.append((tag, values))
        self._inside = tag
        if tag == "fieldset":
            self.pictures.append([])
        if tag == "legend":
            self.legends.append("")
        if tag == "script":
            self.scripts.append("")
        if tag in ("img", "video"):
            data = (values["src"] or "").partition("base64,")[2]
            self.pictures[-1].append(base64.b64decode(data).decode())

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside == "legend":
            self.legends[-1] += data
        if self._inside == "script":
            self.scripts[-1] += data


def page(seed: int = 0, tasks: list[StudyQuestion] = TASKS) -> Page:
    return Page(study_page(questions_of(tasks, seed)))


def test_every_question_and_every_result_is_there() -> None:
    found = page()
    assert sorted(legend.partition(". ")[2] for legend in found.legends) == sorted(task.prompt for task in TASKS)
    told = json.loads(found.scripts[0])
    for legend, pictures, question in zip(found.legends, found.pictures, told["questions"], strict=True):
        prompt = legend.partition(". ")[2]
        assert question["prompt"] == prompt
        assert pictures == [f"{prompt} {method}" for method in question["methods"]], "an answer names what was seen"
        assert sorted(question["methods"]) == sorted(METHODS)
    inputs = [values for tag, values in found.tags if tag == "input"]
    assert [(one["name"], one["value"]) for one in inputs] == [(f"q{q}", str(n)) for q in range(4) for n in range(3)]


def test_the_question_is_the_papers() -> None:
    assert instruction(TASKS) == (
        "In the following questions, you'll be provided a list of text descriptions and corresponding three generation "
        "results. Please choose the one that has best text-alignment, taking into account both the visual quality and the "
        "adherence to the layout structure outlined in the text prompt."
    )
    two = StudyQuestion("p", TASKS[0].results[:2])
    assert "corresponding two generation" in instruction([two])
    assert "corresponding several generation" in instruction([two, *TASKS])


def test_the_order_is_drawn_by_the_seed() -> None:
    orders = {seed: (page(seed).legends, page(seed).pictures) for seed in range(8)}
    assert orders[3] == (page(3).legends, page(3).pictures)
    assert len({json.dumps(order) for order in orders.values()}) > 5
    firsts = {pictures[0].rpartition(" ")[2] for _, found in orders.values() for pictures in found}
    assert firsts == set(METHODS), "no method is always at one place"
    assert len({study_id(questions_of(TASKS, seed)) for seed in range(8)}) == 1, "answers to all of them go together"


def test_names_of_methods_are_not_shown() -> None:
    text = study_page(questions_of(TASKS, 0))
    data = text.index('<script type="application/json"')
    assert not any(method in text[:data] for method in METHODS)


def test_it_loads_nothing() -> None:
    found = page()
    for tag, values in found.tags:
        assert tag not in ("link", "iframe", "object", "base")
        assert tag != "script" or "src" not in values
        assert all(not (value or "").startswith(("http:", "https:", "//")) for value in values.values())
    (policy,) = (v["content"] or "" for _, v in found.tags if v.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy


def test_hostile_texts_stay_texts() -> None:
    evil = '</legend><script>alert(1)</script><img src="x" onerror=alert(1)> & </script><!--'
    tasks = [StudyQuestion(evil, (StudyResult(evil, b"1", ".png"), StudyResult("'\"><b>", b"2", ".mp4")))]
    found = page(0, tasks)
    assert found.legends == [f"1. {evil}"]
    assert len(found.scripts) == 2
    assert [tag for tag, _ in found.tags if tag in ("img", "video", "b")] in (["img", "video"], ["video", "img"])
    assert not any(name.startswith("on") for _, values in found.tags for name in values)
    (question,) = json.loads(found.scripts[0])["questions"]
    assert (question["prompt"], sorted(question["methods"])) == (evil, sorted([evil, "'\"><b>"]))


@pytest.mark.parametrize(
    ("tasks", "text"),
    [
        ([], "expected at least one prompt"),
        ([StudyQuestion("a cube", TASKS[0].results[:1])], r"\"a cube\" has 1 methods"),
        ([StudyQuestion("a cube", TASKS[0].results[:1] * 2)], "two results of one method"),
        (
            [StudyQuestion("a cube", tuple(StudyResult(str(n), b"", ".png") for n in range(27)))],
            r"\"a cube\" has 27 methods",
        ),
    ],
)
def test_studies_that_make_no_sense(tasks: list[StudyQuestion], text: str) -> None:
    with pytest.raises(SceneError, match=text) as caught:
        questions_of(tasks, 0)
    assert caught.value.name == "value"


# --- answers ---------------------------------------------------------------------------------------------------------


def answers(participant: str, *choices: str, **more: Any) -> dict[str, Any]:
    given = [
        {"prompt": f"p{n}", "methods": ["A", "B"] if n else ["A", "B", "C"], "choice": choice}
        for n, choice in enumerate(choices)
    ]
    told = {
        "format": "scenelang-study-answers",
        "version": 1,
        "study": "s",
        "participant": participant,
        "answers": given,
    }
    return told | more


def written(folder: Path, *data: Any) -> list[Path]:
    paths = [folder / f"{n}.json" for n in range(len(data))]
    for path, one in zip(paths, data, strict=True):
        path.write_text(one if isinstance(one, str) else json.dumps(one))
    return paths


def test_percentages(tmp_path: Path) -> None:
    files = written(
        tmp_path, answers("1", "A", "A"), answers("2", "A", "B"), answers("3", "B", "A"), answers("4", "A", "A")
    )
    found = preferences(files)
    assert found.participants == 4
    assert found.percentages == {"p0": {"A": 75.0, "B": 25.0, "C": 0.0}, "p1": {"A": 75.0, "B": 25.0}}
    assert found.methods == ["A", "B", "C"]
    assert found.of("A") == (75.0, 0.0)
    assert found.of("C") == (0.0, 0.0)
    assert preferences(written(tmp_path, answers("1", "A", "B"))).of("A") == (50.0, 50.0)


@pytest.mark.parametrize(
    ("second", "text"),
    [
        (answers("1", "A", "B"), "answers of the same participant"),
        (answers("2", "A", "B", study="t"), "different studies"),
        (answers("2", "A"), "different studies"),
    ],
)
def test_answers_that_do_not_go_together(tmp_path: Path, second: Any, text: str) -> None:
    with pytest.raises(SceneError, match=text) as caught:
        preferences(written(tmp_path, answers("1", "A", "A"), second))
    assert caught.value.name == "value"


@pytest.mark.parametrize(
    "data",
    ["", "[]", "{}", answers("1"), answers("1", "D"), answers("1", "A", format="x"), answers("1", "A", version=2),
     answers("1", "A", answers=[{"prompt": "p"}]), answers("1", "A", answers=3),
     answers("1", "A", answers=[{"prompt": "p", "methods": ["A"], "choice": "A"}] * 2),
     answers("1", "A", answers=[{"prompt": "p", "methods": ["A"], "choice": ["A"]}]), "[" * 100_000],
)  # fmt: skip
def test_files_that_hold_no_answers(tmp_path: Path, data: Any) -> None:
    with pytest.raises(SceneError, match="cannot read the answers") as caught:
        preferences(written(tmp_path, data))
    assert caught.value.name == "file"
    with pytest.raises(SceneError, match="cannot read the answers"):
        preferences([tmp_path / "none.json"])
