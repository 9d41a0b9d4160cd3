"""The prompts: golden files of what is said, and whether what they tell is true of the transpiler and the language.

SCENELANG_UPDATE_GOLDENS=1 writes the goldens anew; read what changed as a model would.
"""

from __future__ import annotations

import ast
import json
import os
import re
from dataclasses import replace
from pathlib import Path

import pytest

import scenelang as sl
from models.conftest import WRONG, cubes, python, recorded
from scenelang.backends.language_models.catalogue import ImageContent, TextContent
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.python_helpers import HELPERS
from scenelang.inference.brief import (
    Ablation,
    Brief,
    Notation,
    Prompts,
    Task,
    TaskKind,
    helpers_of,
    prompt_names,
    sections_of,
    untold,
    words_of,
)
from scenelang.inference.steps import AnswerReader, Verdict
from scenelang.interpreter.runtime.modelling_helpers import (
    ASSERT_THAT,
    modelling_helpers,
    python_name,
    relation_helpers,
)
from scenelang.interpreter.scene.declarations import RELATIONS
from scenelang.interpreter.scene.entity import count_words
from scenelang.interpreter.scene.primitives import attributes_read, block_words
from scenelang.reference.primer import relation_usage, taught
from scenelang.reference.sections import MAX_SECTION, SECTIONS, section_text
from scenelang.session.declarations import declarations_in
from scenelang.session.scene_changes import changes_between, compared_frames
from scenelang.session.session import Options, Session
from scenelang.stdlib.reference import helper_header, in_python_terms, parts, records

pytestmark = pytest.mark.usefixtures("untried")

GOLDENS = Path(__file__).parent / "prompts"
TASK = "a chessboard at game start"
DINNER = "A dining room: a table with four chairs and a lamp, laid with plates, cups, bowls and a vase; a bookcase"
EDIT = "move the apple to the left"
LETTERS_PER_TOKEN = 3.5


def program_in(name: str, notation: Notation) -> str:
    answer = recorded(name)
    if notation is Notation.PYTHON:
        return answer.split("```python\n")[1].split("```")[0]
    return Session().transpile(Source(name, answer)).text


def task(kind: TaskKind, notation: Notation, ablation: Ablation = Ablation.NONE) -> Task:
    return Task(TASK, kind, notation, ablation)


TASKS = {
    **{
        f"{kind.value}.{notation.value}": task(kind, notation)
        for kind in TaskKind
        for notation in (Notation.PYTHON, Notation.LANGUAGE)
    },
    **{f"{kind.value}.P": task(kind, Notation.LIST, Ablation.P) for kind in TaskKind},
    "3d.language.objects": Task(DINNER, notation=Notation.LANGUAGE),
    "3d.python.objects": Task(DINNER, notation=Notation.PYTHON),
    "3d.PW": task(TaskKind.STILL, Notation.LIST, Ablation.PW),
    "3d.python.W": task(TaskKind.STILL, Notation.PYTHON, Ablation.W),
    "4d.language.W": task(TaskKind.FILM, Notation.LANGUAGE, Ablation.W),
    "image": Task("Only the board.", pictures=(ImageContent("image/png", b"png"),)),
    "edit.python": Task(EDIT, program=program_in("t06-son-of-man", Notation.PYTHON)),
    "edit.language": Task(EDIT, notation=Notation.LANGUAGE, program=program_in("t06-son-of-man", Notation.LANGUAGE)),
    "edit.python.W": Task(
        EDIT, ablation=Ablation.W, program=program_in("t06-son-of-man", Notation.PYTHON), seed=7
    ),
}  # fmt: skip


def brief(chosen: Task) -> Brief:
    return Brief(chosen, Prompts())


def first_text(chosen: Task) -> str:
    parts = brief(chosen).first.parts
    assert isinstance(parts[-1], TextContent)
    return parts[-1].text


def compare(name: str, text: str) -> None:
    path = GOLDENS / f"{name}.md"
    if os.environ.get("SCENELANG_UPDATE_GOLDENS"):
        path.write_text(text + "\n", "utf-8")
    assert path.read_text("utf-8") == text + "\n", f"{path.name}: SCENELANG_UPDATE_GOLDENS=1 writes it anew"


@pytest.mark.parametrize("name", TASKS)
def test_what_is_said_first(name: str) -> None:
    chosen = brief(TASKS[name])
    shown = "\n".join("[a picture]" if isinstance(part, ImageContent) else part.text for part in chosen.first.parts)  # type: ignore[union-attr]
    compare(name, f"--- system ---\n\n{chosen.system}\n\n--- user ---\n\n{shown}")


def test_what_is_said_of_an_answer() -> None:
    chosen = brief(TASKS["3d.python"])
    verdict = AnswerReader(chosen, Options()).read(WRONG)
    picture = ImageContent("image/png", b"png")
    turns = {
        "repair": chosen.repair(verdict.report_text()),
        "cut": chosen.cut(64_000),
        "critique": chosen.critique([("The scene, from above:", picture)], "warning: a cube floats"),
        "critique without findings": chosen.critique([("The scene, from above:", picture)], ""),
    }
    pieces = []
    for name, turn in turns.items():
        said = "\n".join("[a picture]" if isinstance(part, ImageContent) else part.text for part in turn.parts)  # type: ignore[union-attr]
        pieces.append(f"--- {name} ---\n\n{said}")
    judge = Prompts().text("judge.md", count="3", task=TASK)
    pieces += [f"--- judge, system ---\n\n{Prompts().text('judge.system.md')}", f"--- judge ---\n\n{judge}"]
    compare("answers", "\n\n".join(pieces))


def test_no_golden_is_left_over() -> None:
    assert {path.stem for path in GOLDENS.glob("*.md")} == {*TASKS, "answers"}


def test_every_prompt_is_read_and_has_its_places_filled() -> None:
    read: set[str] = set()

    class Watching(Prompts):
        def text(self, name: str, **values: str) -> str:
            read.add(name)
            return super().text(name, **values)

    for chosen in (*TASKS.values(), task(TaskKind.FILM, Notation.LANGUAGE)):
        told = Brief(chosen, Watching())
        assert "{{" not in told.system + told.example
        _ = told.first, told.repair(""), told.cut(1), told.critique([], "")
        _ = (
            told.planning,
            told.replanning(["x"]),
            told.reconsidering(["x"]),
            told.part("a", "b", []),
            told.whole("x"),
            told.critic([], ""),
        )
        _ = told.revision("x", "y", "z", ["w"])
    accepted = declarations_in(None, ['(count "a" 1)'])
    assert '(count "a" 1)' in str(Brief(TASKS["3d.language"], Watching(), acceptance=tuple(accepted)).first)
    assert "no fence" in Brief(TASKS["3d.language"], Watching(), is_bare=True).system
    listed = task(TaskKind.STILL, Notation.LIST)
    _ = Brief(replace(listed, program="[]"), Watching()).first
    left = set(prompt_names()) - read
    assert left <= {"judge.md", "judge.system.md", "words.md", "words.system.md"}


@pytest.mark.parametrize("name", TASKS)
def test_prompts_have_a_bounded_size(name: str) -> None:
    chosen = TASKS[name]
    most = {Notation.PYTHON: 2_450, Notation.LANGUAGE: 4_300, Notation.LIST: 900}[chosen.notation]
    tokens = len(brief(chosen).system) / LETTERS_PER_TOKEN
    assert tokens < most, f"{name}: about {tokens:.0f} tokens"
    assert len(first_text(chosen)) / LETTERS_PER_TOKEN < 2_500


def test_the_system_prompt_does_not_depend_on_the_task() -> None:
    one, two = (brief(Task(text, kind, notation)) for text, kind, notation in (("a", *MODE), ("b", *MODE)))
    assert one.system == two.system
    assert brief(Task("c", *MODE, program="x")).system == one.system, "an edit has the same"


MODE = (TaskKind.FILM, Notation.LANGUAGE)


# --- examples ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", TaskKind)
@pytest.mark.parametrize("notation", [Notation.PYTHON, Notation.LANGUAGE])
@pytest.mark.parametrize("ablation", [Ablation.NONE, Ablation.W])
@pytest.mark.sampled(6)
def test_examples_are_right(kind: TaskKind, notation: Notation, ablation: Ablation) -> None:
    chosen = brief(task(kind, notation, ablation))
    programs = re.findall(r"```\w+\n.*?```", chosen.example, re.DOTALL)
    assert len(programs) == (2 if notation is Notation.LANGUAGE and kind is not TaskKind.BLOCKS else 1)
    for number, program in enumerate(programs):
        own = chosen if number == len(programs) - 1 else brief(task(TaskKind.STILL, notation, ablation))
        verdict = AnswerReader(own, Options()).read(program)
        assert verdict.is_usable, verdict.report_text()
        assert verdict.diagnostics == ()
        assert verdict.findings == ()
        if ablation is Ablation.NONE and kind is not TaskKind.FILM:  # of a film it is what the findings are of
            checked = Session().check_geometry(Source("example.scene", verdict.program))
            assert [d.message for d in checked] == []


OBJECTS = "Objects of a library"


def test_objects_of_the_library_are_told_where_they_fit() -> None:
    told = first_text(Task("two sofas in front of a bookcase", notation=Notation.LANGUAGE))
    section = told[told.index(OBJECTS) : told.index("Examples of programs:")]
    assert section.count("\n- `(call ") == 2
    for expected in ('(import "std/furniture.scene")', '(call "sofa" ', '(call "bookcase" ', "(sofa-seats :width "):
        assert expected in section
    film = Task("a car drives by", TaskKind.FILM, Notation.LANGUAGE)
    assert '(call "car" ' in first_text(film)
    for other in (
        replace(film, text="a carousel turns"), replace(film, kind=TaskKind.BLOCKS), replace(film, notation=Notation.LIST),
        replace(film, ablation=Ablation.W), replace(film, program='(bind "a" (lambda () (call "cube")))'),
    ):  # fmt: skip
        assert OBJECTS not in first_text(other)


def test_objects_of_the_library_are_told_in_python() -> None:
    told = first_text(Task("a potted plant beside a table", notation=Notation.PYTHON))
    section = told[told.index(OBJECTS) :].partition("An example")[0]
    assert "`table(width=1.4, depth=0.8, height=0.75, color=None)`" in section
    assert "`potted_plant(height=0.55, radius=0.2," in section
    assert "`table_seats(width, depth, count, gap)` (a list)" in section
    assert "import" not in section


def test_the_section_of_objects_has_a_limit() -> None:
    everything = " ".join(part.word for part in parts())
    told = first_text(Task(everything, notation=Notation.LANGUAGE))
    section = told[told.index(OBJECTS) : told.index("Examples of programs:")].strip()
    assert 1_000 < len(section) <= 1_500
    assert 4 <= section.count("\n- `(call ") <= 8
    for line in section.splitlines():
        if line.startswith("(import "):
            assert Session().check(Source("a.scene", f'{line} (bind "a" (lambda () (call "cube")))')).ok


def is_told(name: str, text: str) -> bool:
    """Whether a prompt has a name: in a call, alone, or in a list of names between backquotes."""
    return re.search(rf"`(\(|[^`\n(]* )?{re.escape(name)}[ )`]", text) is not None


@pytest.mark.parametrize("notation", [Notation.LANGUAGE, Notation.PYTHON])
@pytest.mark.parametrize("kind", TaskKind)
def test_prompts_are_short(kind: TaskKind, notation: Notation) -> None:
    chosen = brief(task(kind, notation))
    text = chosen.system + "".join(part.text for part in chosen.first.parts if isinstance(part, TextContent))
    assert len(text) <= 13_000 + MAX_SECTION * len(sections_of(kind))


@pytest.mark.parametrize("name", RELATIONS)
def test_usages_of_relations_are_balanced(name: str) -> None:
    """Options are left out as a whole, those that have options of their own included."""
    usage = relation_usage(name)
    assert all(usage.count(a) == usage.count(b) for a, b in ("()", "[]"))
    assert usage.startswith(f"({name} A")


def test_the_primer_of_a_task_has_what_its_prompt_has() -> None:
    text = "a table with a vase on it, and a chair that is reachable"
    first = str(Brief(Task(text, TaskKind.STILL, Notation.LANGUAGE), Prompts()).first)
    told = sl.primer(text)
    assert '(import "std/furniture.scene")' in told
    assert "(reachable A B)" in told
    for part in ('(call "table"', "(reachable A B)", "three benches in a row"):
        assert part in first
        assert part in told


@pytest.mark.parametrize("is_python", [False, True])
@pytest.mark.parametrize("name", SECTIONS)
def test_sections_are_short_and_tell_what_they_name(name: str, is_python: bool) -> None:
    text, section = section_text(name, is_python), SECTIONS[name]
    assert 500 < len(text) <= MAX_SECTION
    told = [*section.names, *section.relations] if not is_python else [
        each for each in map(python_name, (*section.names, *section.relations))
        if each in {*modelling_helpers(), *relation_helpers()}
    ]  # fmt: skip
    assert told
    for each in told:
        assert re.search(rf"`[@(]?{re.escape(each)}[ (`]", text), each


@pytest.mark.parametrize("kind", TaskKind)
def test_the_prompt_of_the_language_tells_what_it_names(kind: TaskKind) -> None:
    system = brief(task(kind, Notation.LANGUAGE)).system
    groups = taught(untold(kind))
    missing = [name for name in groups if f"\n{name}:" not in system]
    assert len(missing) == (3 if kind is TaskKind.BLOCKS else 0)
    listed = [r for name, members in groups.items() for r, _ in members if name not in missing]
    assert 80 < len(listed) < 150
    for record in listed:
        assert is_told(record.name, system), record.name


ASKING = {
    "a bent pipe": True, "a sign with the word OPEN in letters": True, "a spiral staircase of stone": True,
    "three mugs": True, "a hollow ball": True, "two boxes on a table": False, "a chessboard at game start": False,
    "a circle of six chairs": False,
}  # fmt: skip


@pytest.mark.parametrize("notation", [Notation.LANGUAGE, Notation.PYTHON])
@pytest.mark.parametrize("text", ASKING)
def test_sections_are_added_by_words(text: str, notation: Notation) -> None:
    section = section_text("solids", notation is Notation.PYTHON)
    assert (section in first_text(Task(text, notation=notation))) is ASKING[text]
    assert section not in brief(Task(text, notation=notation)).system
    given = sl.primer(text, notation=notation.value)
    assert (section in given) is ASKING[text]
    assert sl.primer(text, notation=notation.value, sections=["solids"]).count(section) == 1


def test_sections_are_added_by_the_program_to_edit_by_kind_and_by_name() -> None:
    program = '(bind "a" (lambda () (rounded (call "cube") .1)))'
    assert "## More solids" in first_text(Task("make it red", notation=Notation.LANGUAGE, program=program))
    assert "## More solids" not in first_text(Task("make it red", notation=Notation.LANGUAGE, program='(scene "a")'))
    for kind, name in ((TaskKind.FILM, "films"), (TaskKind.BLOCKS, "blocks")):
        for notation in (Notation.LANGUAGE, Notation.PYTHON):
            section = section_text(name, notation is Notation.PYTHON)
            assert brief(task(kind, notation)).system.count(section) == 1
            assert section not in brief(task(TaskKind.STILL, notation)).system
            assert section in sl.primer(notation=notation.value, sections=[name])
    with pytest.raises(SceneError, match="unknown section `solid`") as caught:
        sl.primer(sections=["solid"])
    assert "solids" in (caught.value.hint or "")


# Names whose lengths, angles and directions a model must know, with what their lines say of them.
ORIENTED = {
    "translate": "scene units", "rotate": "radians", "look-at": "+z towards", "grid": "towards +x", "ring": "From +z",
    "row": "from -x to +x", "stack": "upwards", "jitter": "radians", "scatter": "scene units", "along": "+z along",
    "extrude": "along +z", "lathe": "around the y axis", "compute-shape-min": "scene units", "circle": "plane of x and y",
    "rectangle": "in x", "helix": "around the y axis", "sweep": "upwards", "text": "faces +z", "rounded": "scene units",
    "shell": "scene units",
}  # fmt: skip


@pytest.mark.parametrize("name", ORIENTED)
def test_signatures_say_orientation_and_units(name: str) -> None:
    told = sl.primer(sections=["solids"])
    (line,) = [line for line in told.splitlines() if line.startswith(f"- `({name} ")]
    assert ORIENTED[name] in line
    helper = python_name(name)
    if helper in modelling_helpers():
        python_told = sl.primer(notation="python", sections=["solids"])
        (line,) = [line for line in python_told.splitlines() if line.startswith(f"- `{helper}(")]
        assert in_python_terms(ORIENTED[name]) in line


@pytest.mark.parametrize("kind", TaskKind)
def test_functions_that_python_mode_is_told_translate(kind: TaskKind) -> None:
    told = sl.primer(kind=kind.value, notation="python", sections=["solids"])
    names = set(re.findall(r"[`, ]([a-z_]+)\(", told))
    stated = told.split("Relations: `")[1].split("`")[0]
    assert {python_name(name) for name in ("on", "clear-of", "evenly-spaced", "has-color")} <= names
    assert set(re.findall(r"(\w+)\(", stated)) <= set(relation_helpers())
    assert {"sweep", "helix"} <= names
    assert ("lathe" in names) is (kind is not TaskKind.BLOCKS)


@pytest.mark.parametrize("ablation", [Ablation.P, Ablation.PW])
@pytest.mark.parametrize("kind", TaskKind)
def test_examples_of_lists_are_right(kind: TaskKind, ablation: Ablation) -> None:
    chosen = brief(task(kind, Notation.LIST, ablation))
    shown = chosen.example.split("```json\n")[1].split("```")[0]
    whole = re.sub(r",\n\.\.\.\n", "\n", shown)
    verdict = read_list(kind, ablation, whole)
    assert [d for d in verdict.diagnostics if "not animated" not in d.message] == [], verdict.report_text()
    items = json.loads(whole)[0] if kind is TaskKind.FILM else json.loads(whole)
    assert len(items) >= 7
    assert all(("word" in item) is (ablation is Ablation.P) for item in items)
    for item in items:
        assert set(item["attributes"]) <= set(attributes_read(item["shape"]))
        assert f'- "{item["shape"]}": ' in chosen.system


def read_list(kind: TaskKind, ablation: Ablation, text: str) -> Verdict:
    return AnswerReader(brief(task(kind, Notation.LIST, ablation)), Options()).read(f"```json\n{text}\n```")


@pytest.mark.parametrize("kind", TaskKind)
def test_examples_use_only_what_is_told(kind: TaskKind) -> None:
    chosen = brief(task(kind, Notation.PYTHON))
    code = chosen.example.split("```python\n")[1].split("```")[0]
    called = {
        node.func.id
        for node in ast.walk(ast.parse(code))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert called & set(HELPERS) <= set(helpers_of(kind))
    language = brief(task(kind, Notation.LANGUAGE))
    example = "\n".join(re.findall(r"```scene\n(.*?)```", language.example, re.DOTALL))
    names = {record.name for record in records()} & set(re.findall(r"(?<=\()[^\s()\[\]]+", example))
    assert names, "the example calls something"
    assert [name for name in names if not is_told(name, language.system)] == []


# --- the header ----------------------------------------------------------------------------------------------------


def defined(kind: TaskKind) -> dict[str, ast.FunctionDef]:
    tree = ast.parse(helper_header(helpers_of(kind), words_of(kind)))
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_the_header_has_the_helpers_of_each_kind() -> None:
    still, film, blocks = (set(defined(kind)) for kind in (TaskKind.STILL, TaskKind.FILM, TaskKind.BLOCKS))
    assert film == set(HELPERS) - {"identity_matrix"}
    assert film - still == {"register_animation"}
    assert still - blocks == {"rotation_matrix", "reflection_matrix"}
    assert blocks <= still


def test_blocks_have_their_own_primitive_call() -> None:
    texts = {kind: ast.unparse(defined(kind)["primitive_call"]) for kind in TaskKind}
    assert texts[TaskKind.STILL] == texts[TaskKind.FILM] != texts[TaskKind.BLOCKS]
    for word in words_of(TaskKind.STILL):
        assert f"'{python_name(word)}'" in texts[TaskKind.STILL]
        assert f"'{word}'" not in texts[TaskKind.BLOCKS]
    for word in block_words():
        assert f"'{python_name(word)}'" in texts[TaskKind.BLOCKS]
        assert f"'{python_name(word)}'" not in texts[TaskKind.STILL]


@pytest.mark.parametrize("kind", TaskKind)
def test_the_header_is_python_and_says_something_of_each_helper(kind: TaskKind) -> None:
    for name, node in defined(kind).items():
        doc = ast.get_docstring(node)
        assert doc, name
        assert len(doc) > 15, name
        assert not re.search(r"\[\d|#t|#f|`\(|:p0", doc), doc


def test_the_header_of_a_kind_is_named_in_its_rules() -> None:
    for kind in TaskKind:
        system = brief(task(kind, Notation.PYTHON)).system
        for name in set(re.findall(r"`@?([a-z_]+_[a-z_]+)\b", system)):
            known = (*helpers_of(kind), *modelling_helpers(), *relation_helpers(), ASSERT_THAT, "func_name")
            assert name in known, f"{kind}: {name}"


def test_names_that_are_not_told_exist() -> None:
    names = {record.name for record in records()}
    for kind in TaskKind:
        assert set(untold(kind)) <= names
        system = brief(task(kind, Notation.LANGUAGE)).system
        for name in untold(kind):
            assert f"`({name} " not in system, name


# What a parameter of each helper may be.
BALL = 'primitive_call("sphere", shape_kwargs={"radius": 1})'
VALUES = {
    "docstring": "'an object'", "func_name": "'part'", "name": "'cube'", "shape_kwargs": "{'scale': (1, 2, 3)}",
    "color": "(1, 0, 0)", "n": "3", "fn": "lambda i: part", "shape": "part", "pose": "translation_matrix((1, 0, 0))",
    "offset": "(1, 2, 3)", "angle": "0.5", "direction": "(0, 1, 0)", "point": "(1, 0, 0)", "scale": "(1, 2, 1)",
    "origin": "(0, 1, 0)", "normal": "(0, 1, 0)",
}  # fmt: skip
DECORATORS = ("register", "register_animation")


def using(helper: str, call: str) -> str:
    """A program that uses a call of a helper."""
    if helper in DECORATORS:
        moved = "transform_shape(part, translation_matrix((1, 0, 0)))"
        body = f"    yield part\n    yield {moved}" if helper == "register_animation" else "    return part"
        return python(f"part = {BALL}\n\n\n@{call}\ndef thing():\n{body}")
    result = HELPERS[helper].result
    used = {
        "Shape": call,
        "T": f"transform_shape(part, {call})",
        "P": f"transform_shape(part, translation_matrix({call}))",
    }
    return python(f"""
@register()
def part(size: float = 1) -> Shape:
    return {BALL}

@register()
def thing() -> Shape:
    part = library_call("part")
    return {used[result]}
""")


def verdict_on(helper: str, arguments: list[str]) -> Verdict:
    kind = TaskKind.FILM if helper == "register_animation" else TaskKind.STILL
    answer = using(helper, f"{helper}({', '.join(arguments)})")
    return AnswerReader(brief(task(kind, Notation.PYTHON)), Options()).read(answer)


def parameters(helper: str) -> list[str]:
    node = defined(TaskKind.FILM).get(helper) or ast.parse(f"def f({HELPERS[helper].signature}): pass").body[0]
    assert isinstance(node, ast.FunctionDef)
    return [argument.arg for argument in node.args.args]


@pytest.mark.parametrize("helper", HELPERS)
@pytest.mark.sampled(2)
def test_all_parameters_by_position_and_by_name(helper: str) -> None:
    names = parameters(helper)
    positions = [VALUES[name] for name in names]
    if helper == "concat_shapes":
        positions = ["part", "part", "[part]"]
    for arguments in (positions, [f"{name}={VALUES[name]}" for name in names] or positions):
        verdict = verdict_on(helper, arguments)
        assert verdict.is_usable, f"{arguments}\n{verdict.report_text()}"
        assert not verdict.diagnostics, verdict.report_text()


# Decorators take whatever they are given: nothing of the scene depends on it.
@pytest.mark.parametrize("helper", [name for name in HELPERS if name not in ("concat_shapes", *DECORATORS)])
@pytest.mark.sampled(3)
def test_one_parameter_too_many(helper: str) -> None:
    verdict = verdict_on(helper, [*(VALUES[name] for name in parameters(helper)), "7"])
    assert not verdict.is_usable


@pytest.mark.parametrize("helper", [name for name in HELPERS if name not in ("primitive_call", *DECORATORS)])
@pytest.mark.sampled(3)
def test_an_unknown_parameter(helper: str) -> None:
    positions = ["part"] if helper == "concat_shapes" else [VALUES[name] for name in parameters(helper)]
    verdict = verdict_on(helper, [*positions, "sice=7"])
    assert not verdict.is_usable


@pytest.mark.parametrize(
    "helper", [name for name in HELPERS if name not in ("concat_shapes", "identity_matrix", *DECORATORS)]
)
@pytest.mark.sampled(3)
def test_a_parameter_that_is_missing(helper: str) -> None:
    assert not verdict_on(helper, []).is_usable


def test_what_an_attribute_of_a_primitive_is_not_called_is_told() -> None:
    verdict = verdict_on("primitive_call", ["'cube'", "{'scale': 1, 'sice': 2}"])
    assert any("sice" in d.message for d in verdict.diagnostics)


def test_defaults_of_the_header_are_the_languages() -> None:
    """Leaving an argument out is the same as writing the default that the header states."""
    for helper, short, long in (
        ("rotation_matrix", "0.5, (0, 1, 0)", "0.5, (0, 1, 0), (0, 0, 0)"),
        ("scale_matrix", "(1, 2, 1)", "(1, 2, 1), (0, 0, 0)"),
        ("primitive_call", "'cube', {}", "'cube', {'scale': (1, 1, 1)}, (1, 1, 1)"),
        ("primitive_call", "'sphere', {}", "'sphere', {'radius': 1}"),
        ("primitive_call", "'cone', {}", "'cone', {'radius': 1, 'p0': (0, 0, 0), 'p1': (0, 1, 0)}"),
    ):
        one, two = verdict_on(helper, [short]), verdict_on(helper, [long])
        assert one.scene is not None, one.report_text()
        assert two.scene is not None, two.report_text()
        assert changes_between(compared_frames(one.scene, 10), compared_frames(two.scene, 10)).equal, (helper, short)


def test_the_last_function_is_the_scene_and_needs_no_mark() -> None:
    """What rule 6 says: of several functions that nobody calls, the last is the scene."""
    answer = cubes(1, word="one") + "\n"
    two = answer.replace(
        "\n```", '\n\n@register()\ndef two() -> Shape:\n    return loop(2, lambda i: library_call("one"))\n```'
    )
    verdict = AnswerReader(brief(task(TaskKind.STILL, Notation.PYTHON)), Options()).read(two)
    assert '(scene "two")' in verdict.program


# --- answers in another form -----------------------------------------------------------------------------------------

CUBES_IN_PYTHON = """from helper import *

@register()
def pair() -> Shape:
    return loop(2, lambda i: transform_shape(primitive_call("cube"), translation_matrix((2 * i, 0.5, 0))))
"""
CUBES = """; two cubes
(bind "pair" (lambda () (union-loop 2 (lambda (i) (transform (call "cube") (translate (vector (* 2 i) .5 0)))))))
(scene "pair")
"""


@pytest.mark.parametrize("notation", [Notation.PYTHON, Notation.LANGUAGE])
@pytest.mark.parametrize("answer", [
    f"```python\n{CUBES_IN_PYTHON}```", CUBES_IN_PYTHON, f"```scene\n{CUBES}```", f"```lisp\n{CUBES}```", CUBES,
])  # fmt: skip
def test_python_and_the_language_are_taken_for_each_other(notation: Notation, answer: str) -> None:
    verdict = AnswerReader(brief(task(TaskKind.STILL, notation)), Options()).read(answer)
    assert verdict.is_usable, verdict.report_text()
    assert verdict.scene is not None
    assert count_words(verdict.scene.root)["cube"] == 2
    assert Session().evaluate(Source("a.scene", verdict.program)).ok


def patch(old: str, new: str) -> str:
    return f"<<<<<<< SEARCH\n{old}\n=======\n{new}\n>>>>>>> REPLACE\n"


def edit_reader(program: str) -> AnswerReader:
    return AnswerReader(Brief(Task("three", notation=Notation.LANGUAGE, program=program), Prompts(None)), Options())


def test_edits_may_be_patches() -> None:
    lines = CUBES.splitlines()
    answer = patch(lines[1], lines[1].replace("union-loop 2", "union-loop 3")) + patch("; two cubes", "; three cubes")
    verdict = edit_reader(CUBES).read(answer)
    assert verdict.is_usable, verdict.report_text()
    assert verdict.code == CUBES.replace("union-loop 2", "union-loop 3").replace("two", "three")
    whole = edit_reader(CUBES).read(f"```scene\n{CUBES}```")
    assert whole.code == CUBES


@pytest.mark.parametrize(("old", "text"), [("; four cubes", "occurs 0 times"), ("", "is empty"), ("call", "occurs")])
def test_patches_that_do_not_fit_are_told(old: str, text: str) -> None:
    program = CUBES + '(bind "other" (lambda () (call "cube")))\n'
    verdict = edit_reader(program).read(patch(old, "x"))
    assert not verdict.is_usable
    assert text in verdict.report_text()


def test_a_local_patch_is_a_tenth_of_the_program() -> None:
    program = Path("examples/chessboard.scene").read_text()
    line = next(line for line in program.splitlines() if program.count(line) == 1 and "define" in line)
    assert len(patch(line, line)) < len(program) / 10
