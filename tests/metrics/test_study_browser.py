"""The page of the user study in a real browser (`make test-browser`): what is chosen is kept, and comes as a file."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenelang.backends.deepslate.backend import find_browser
from scenelang.backends.pictures.film import png_of
from scenelang.evaluation.study import StudyQuestion, StudyResult, preferences, questions_of, study_page
from scenelang.grammar.diagnostics import SceneError

pytestmark = pytest.mark.browser


def result(method: str, seed: int) -> StudyResult:
    picture = np.random.default_rng(seed).integers(0, 256, (16, 16, 3), np.uint8)
    return StudyResult(method, png_of(picture), ".png")


def test_choosing(tmp_path: Path) -> None:
    try:
        executable = find_browser()
    except SceneError as error:
        pytest.skip(error.message)
    playwright = pytest.importorskip("playwright.sync_api")
    tasks = [StudyQuestion(f"<b>{n}</b> & so", (result("Ours", n), result("Theirs", 9 + n))) for n in range(3)]
    questions = questions_of(tasks, 1)
    page_file = tmp_path / "study.html"
    page_file.write_text(study_page(questions), "utf-8")
    wanted = {question.prompt: question.results[n % 2].method for n, question in enumerate(questions)}
    with playwright.sync_playwright() as driver:
        context = driver.chromium.launch_persistent_context(
            str(tmp_path / "profile"), executable_path=executable, headless=True, accept_downloads=True
        )
        faults: list[Any] = []
        page = context.new_page()
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda fault: faults.append(str(fault)))
        page.goto(page_file.as_uri())
        shown = page.evaluate("[...document.images].every(one => one.complete && one.naturalWidth === 16)")
        assert shown, "the policy lets pictures through"
        assert page.locator("#save").is_disabled()
        for n in range(3):
            page.locator(f'input[name="q{n}"]').nth(n % 2).check(force=True)
        assert page.inner_text("#progress") == "3 of 3 answered"
        page.reload()
        assert page.inner_text("#progress") == "3 of 3 answered", "answers are kept"
        with page.expect_download() as waiting:
            page.locator("#save").click()
        waiting.value.save_as(tmp_path / "answers.json")
        context.close()
    assert faults == []
    told = json.load(io.BytesIO((tmp_path / "answers.json").read_bytes()))
    assert {answer["prompt"]: answer["choice"] for answer in told["answers"]} == wanted
    assert preferences([tmp_path / "answers.json"]).participants == 1
