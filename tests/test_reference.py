"""The pages under docs/reference and the tutorial's pictures: up to date, complete, and every block runs."""

from __future__ import annotations

import random
import re
import shutil
import time
from pathlib import Path

import pytest
from generator.__main__ import CAMERA, PAGES, PART, SMALL, TUTORIAL, main
from generator.diagnostics_page import BAD, FIXED, ROOT, shown_case
from generator.errors import altered, errors_in, errors_of, examined, observed
from generator.library_page import PICTURES, picture_program
from generator.markdown import formatted, identifier
from generator.parts_page import picture_path
from generator.pictures import difference, drawn, save
from generator.recipes import COOKBOOK, SIZE, recipes
from generator.tutorial import steps
from test_bad import CASES, ELSEWHERE, _command, _directives
from test_docs import blocks

import scenelang as sl
from scenelang import Options, Session, Source
from scenelang.cli import main as cli
from scenelang.cli.main import build_parser
from scenelang.console.shell_completion import subcommands
from scenelang.grammar.diagnostics import CODES, REMEDIES, render_text
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import FORM_EXAMPLES, FORMS
from scenelang.interpreter.scene.declarations import RELATIONS
from scenelang.interpreter.scene.primitives import all_primitives
from scenelang.stdlib.reference import RecordKind, ReferenceRecord, combinators, parts, records

DOCS = ROOT / "docs"
STEPS = list(steps(DOCS / "tutorial.md"))
RECIPES = list(recipes())
_ALIKE = 2.0  # of 255: what the fewer colors of a file and the softer edges of its picture may change


@pytest.mark.parametrize("name", PAGES)
def test_pages_are_up_to_date(name: str) -> None:
    assert (DOCS / name).read_text("utf-8") == PAGES[name](), "run: make docs"


@pytest.mark.parametrize("record", combinators(), ids=lambda record: record.name)
@pytest.mark.sampled(3)
def test_every_combinator_has_its_picture(record) -> None:
    path = DOCS / "reference" / PICTURES / f"{record.name}.png"
    assert difference(drawn(picture_program(record), SMALL, CAMERA, oversampling=1), path) < _ALIKE, "run: make docs"


@pytest.mark.parametrize("part", parts(), ids=lambda part: part.word)
@pytest.mark.sampled(6)
def test_every_part_has_its_picture(part) -> None:
    picture = drawn(picture_program(part.record), PART, CAMERA, oversampling=1)
    assert difference(picture, DOCS / picture_path(part)) < _ALIKE, "run: make docs"


@pytest.mark.parametrize("step", STEPS, ids=lambda step: step.picture)
@pytest.mark.sampled(4)
def test_every_step_of_the_tutorial_has_its_picture(step) -> None:
    picture = drawn(step.program, TUTORIAL, step.camera, step.frame, oversampling=1)
    assert difference(picture, DOCS / step.picture) < _ALIKE, "run: make docs"


def test_every_program_of_the_tutorial_is_drawn_and_no_picture_is_left_over() -> None:
    assert [step.program for step in STEPS] == [text for _, text in blocks("docs/tutorial.md", "scene")]
    assert {path.name for path in (DOCS / "tutorial").iterdir()} == {Path(step.picture).name for step in STEPS}
    own = [record for record in records() if record.picture is not None and record.kind is not RecordKind.PART]
    drawn_names = {f"{record.name}.png" for record in own} | {Path(picture_path(part)).name for part in parts()}
    drawn_names |= {f"relation-{name}.png" for name in RELATIONS}
    assert {path.name for path in (DOCS / "reference" / PICTURES).iterdir()} == drawn_names


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.picture)
@pytest.mark.sampled(8)
def test_every_recipe_has_its_image(recipe) -> None:
    image = drawn(recipe.program, SIZE, recipe.camera, recipe.frame)
    assert difference(image, COOKBOOK / recipe.picture) < _ALIKE, "run: make docs"


def test_every_recipe_is_drawn_and_no_image_is_left_over() -> None:
    programs = [text for page in COOKBOOK.glob("*.md") for _, text in blocks(f"docs/cookbook/{page.name}", "scene")]
    assert sorted(programs) == sorted(recipe.program for recipe in RECIPES)
    assert sorted(path.name for path in (COOKBOOK / "images").iterdir()) == sorted(
        Path(recipe.picture).name for recipe in RECIPES
    )
    assert len(RECIPES) == 41


@pytest.mark.slow
def test_the_command_writes_everything(tmp_path: Path) -> None:
    assert main(tmp_path) == 0
    written = {path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file()}
    folders = (DOCS / "reference", DOCS / "tutorial", DOCS / "figures", COOKBOOK / "images")
    known = {path.relative_to(DOCS) for folder in folders for path in folder.rglob("*") if path.is_file()}
    assert written == known | {Path(name) for name in PAGES}


def test_a_picture_that_shows_the_same_is_not_written_again(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    program = '(bind "a" (lambda () (call "cube")))'
    save(drawn(program, SMALL, CAMERA), path)
    before = path.read_bytes()
    path.write_bytes(before + b"tail")  # which readers of PNG skip
    save(drawn(program, SMALL, CAMERA), path)
    assert path.read_bytes() == before + b"tail"
    save(drawn(program.replace("cube", "cone"), SMALL, CAMERA), path)
    assert path.read_bytes() not in (before, before + b"tail")


def test_a_wrong_program_is_not_drawn() -> None:
    with pytest.raises(ValueError, match="E301"):
        drawn("(cal)", SMALL, CAMERA)


# --- forms -------------------------------------------------------------------------------------------------------------


def test_every_form_has_an_example_that_uses_it() -> None:
    assert set(FORM_EXAMPLES) == set(FORMS)
    for name, (program, _) in FORM_EXAMPLES.items():
        assert f"({name} " in program or (name == "quasiquote" and "`" in program), name


@pytest.mark.parametrize("text", [text for _, text in blocks("docs/reference/forms.md", "scene")])
def test_examples_of_forms_run_and_give_what_they_say(text: str) -> None:
    program, _, value = text.rstrip().partition("  ; => ")
    if value:
        span = read(Source("<block>", program)).forms[-1].span
        program = f'{program[: span.start]}(print (list {program[span.start : span.end]}))\n(bind "b" (lambda () (call "cube")))'
    result = Session(Options(project=ROOT)).evaluate(Source("<block>", program))
    assert [render_text(d) for d in result.diagnostics] == []
    assert result.log == ((f"({value})",) if value else ())


# --- diagnostics -------------------------------------------------------------------------------------------------------


def test_every_code_says_how_to_mend() -> None:
    assert set(REMEDIES) == set(CODES)
    assert all(remedy[0].isupper() and remedy.endswith(".") for remedy in REMEDIES.values())


def test_every_code_has_a_section_and_a_program() -> None:
    page = (DOCS / "reference/diagnostics.md").read_text("utf-8")
    for name, entry in CODES.items():
        assert f"### {entry.code} {name}\n" in page
        assert (shown_case(entry.code) is None) == (entry.code in ELSEWHERE)


_WRONG = re.compile(r"^```(scene|python) wrong ([EW]\d{3})\n(.*?)^```$", re.M | re.S)
WRONG = _WRONG.findall((DOCS / "reference/diagnostics.md").read_text("utf-8"))


@pytest.mark.parametrize(("language", "code", "text"), WRONG, ids=[code for _, code, _ in WRONG])
def test_wrong_blocks_give_the_code_they_claim(
    language: str,
    code: str,
    text: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert f"[{code}]" in _said(
        "wrong" + (".scene" if language == "scene" else ".py"), text, tmp_path, monkeypatch, capsys
    )


def test_most_codes_show_a_wrong_program() -> None:
    shown = {code for _, code, _ in WRONG}
    assert len(shown) >= len(CODES) - len(ELSEWHERE) - 10  # folders, long files, bytes that are no text


@pytest.mark.parametrize("path", sorted(FIXED.iterdir()), ids=lambda path: path.stem)
def test_mended_programs_are_right(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code = path.name.partition("-")[0]
    assert path.name in {case.name for case in CASES}
    shown = shown_case(code)
    assert shown is not None
    assert shown.name == path.name, "one fixed program for each code"
    said = _said(path.name, path.read_text("utf-8"), tmp_path, monkeypatch, capsys)
    assert "error[" not in said
    assert "warning[" not in said
    text = path.read_text("utf-8")
    assert path.suffix != ".scene" or formatted(text) == text.rstrip("\n")
    assert text != (BAD / path.name).read_text("utf-8")


def _said(
    name: str, text: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> str:
    """What the command line says of a program, which is run as its first lines ask for."""
    monkeypatch.chdir(folder)
    (folder / name).write_text(text, "utf-8")
    asked = _directives(folder / name)
    if "before" in asked:
        assert cli.main(_command(asked["before"], name, [])) == 0
    cli.main(_command(asked.get("command", ["run"]), name, asked.get("args", [])))
    return capsys.readouterr().err


# --- the command line --------------------------------------------------------------------------------------------------


def test_every_command_and_option_is_on_the_page() -> None:
    page = (DOCS / "reference/cli.md").read_text("utf-8")
    for name, (parser, _) in subcommands(build_parser()).items():
        assert f"\n## {name}" in page
        for command in (parser, *(child for child, _ in subcommands(parser).values())):
            assert all(
                flags[-1] in page or flags[-1] == "--help" for a in command._actions if (flags := a.option_strings)
            )


def test_pages_do_not_depend_on_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    assert PAGES["reference/cli.md"]() == (DOCS / "reference/cli.md").read_text("utf-8")
    assert shutil.get_terminal_size().columns == 40


def test_every_option_has_an_anchor_of_its_own() -> None:
    page = (DOCS / "reference" / "cli.md").read_text("utf-8")
    anchors = re.findall(r'<a id="([^"]+)"', page)
    assert len(anchors) == len(set(anchors)) > 300
    assert {"render-quality", "options-of-view-camera", "options-of-limits-max-steps"} <= set(anchors)


@pytest.mark.parametrize("record", examined(), ids=lambda record: record.name)
def test_a_recorded_call_raises_each_error_of_a_function(record: ReferenceRecord) -> None:
    for error, expression in observed().get(record.name, {}).items():
        assert error in errors_in(record, expression), expression


def test_altered_calls_raise_no_error_that_is_not_recorded() -> None:
    """A sample of what the search for errors tries, which is other calls each week."""
    drawn = random.Random(int(time.time() // 604_800))
    for record in drawn.sample(examined(), 40):
        expressions = list(altered(record))
        for expression in drawn.sample(expressions, min(10, len(expressions))):
            assert set(errors_in(record, expression)) <= set(observed().get(record.name, ())), expression


def test_errors_are_listed_in_the_reference() -> None:
    page = (DOCS / "reference/lists.md").read_text("utf-8").split("## iota", 1)[1].split("\n## ", 1)[0]
    assert "Errors: [E408]" in page
    assert set(errors_of(next(each for each in examined() if each.name == "iota"))) == {"domain", "value", "size"}


def test_every_primitive_has_an_example_and_typed_attributes() -> None:
    page = (DOCS / "reference/primitives.md").read_text("utf-8")
    for cls in all_primitives():
        section = page.split(f"### {cls.word}\n", 1)[1].split("\n### ", 1)[0]
        assert f'(call "{cls.word}"' in section.split("```scene", 1)[1], cls.word
        assert all(f":{each.name}::" in section for each in cls.attributes if each.accepts), cls.word


def test_pages_of_the_documentation_in_remedies_are_links() -> None:
    page = (DOCS / "reference/diagnostics.md").read_text("utf-8")
    assert "[`docs/from-openscad.md`](../from-openscad.md)" in page
    assert not re.search(r"(?<![\[`/\w])docs/[\w-]+\.md", page)


def test_no_two_names_share_an_anchor() -> None:
    by_page: dict[str, list[str]] = {}
    for record in records():
        by_page.setdefault(record.topic, []).append(identifier(record.name))
    assert all(len(names) == len(set(names)) for names in by_page.values())


def test_an_upright_book_stands_in_the_middle_of_its_place() -> None:
    scene = sl.evaluate(
        '(import "std/furniture.scene") (bind "s" (lambda () (transform (call "book") (book-upright))))'
    )
    assert scene.bounds.ravel().tolist() == pytest.approx([-0.015, 0, -0.075, 0.015, 0.22, 0.075], abs=1e-9)
