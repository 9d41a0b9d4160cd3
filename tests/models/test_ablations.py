"""The paper's ablations: without programs, words or both; what is sent, and what edited answers come to."""

from __future__ import annotations

import json
import re
from functools import lru_cache
from pathlib import Path

import pytest

from models.conftest import RESPONSES, Place, answers, python, recorded, system, texts
from scenelang.grammar.datum import Source
from scenelang.inference.brief import Ablation, Brief, Notation, Prompts, Task, TaskKind
from scenelang.inference.listing import MAX_ITEMS, listing, program_of, rename_language, rename_python
from scenelang.inference.steps import AnswerReader, Verdict
from scenelang.interpreter.scene.entity import Scene, primitive_count
from scenelang.session.scene_changes import Changes, changes_between, compared_frames
from scenelang.session.session import Options, Session

pytestmark = pytest.mark.usefixtures("untried")

INSTRUCTION = "move the apple to the left"
BALL = '{"shape": "sphere", "attributes": {"radius": 2}, "pose": [[1,0,0,0],[0,1,0,2],[0,0,1,0]]}'
APPLE = ("apple_pos = np.array([0, ", "apple_pos = np.array([-0.8, ")


def code(name: str) -> str:
    return recorded(name).split("```python\n")[1].split("```")[0]


@lru_cache(maxsize=2)
def scene_of(name: str) -> Scene:
    scene = Session().evaluate(Source(f"{name}.txt", recorded(name))).scene
    assert scene is not None
    return scene


def changes(a: Scene, b: Scene, tolerance: float = 1e-4) -> Changes:
    return changes_between(compared_frames(a, 50_000), compared_frames(b, 50_000), tolerance)


def brief(ablation: Ablation, notation: Notation, program: str | None, seed: int = 0) -> Brief:
    return Brief(Task(INSTRUCTION, TaskKind.STILL, notation, ablation, (), program, seed), Prompts())


def read(chosen: Brief, answer: str) -> Verdict:
    verdict = AnswerReader(chosen, Options()).read(answer)
    assert verdict.is_usable, verdict.report_text()
    return verdict


# --- generate ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("ablation", ["P", "PW"])
def test_generate_without_programs(place: Place, ablation: str) -> None:
    server = place.serve(answers("no list", f"```json\n[{BALL}, {BALL.replace('0,1,0,2', '0,1,0,6')}]\n```"))
    place.generate("two balls", "--ablate", ablation, "-o", "out.scene")
    first, second = server.requests
    assert "lists of primitives" in system(first)
    assert "def " not in system(first) + texts(first["messages"][0])
    shown = json.loads(texts(first["messages"][0]).split("```json\n")[1].split(",\n...")[0] + "]")
    assert all(("word" in item) is (ablation == "P") for item in shown)
    assert ("`word`" in system(first)) is (ablation == "P")
    assert "the answer" in texts(second["messages"][2])
    assert json.loads(place.run("count", "out.scene", "--json").out)["sphere"] == 2


@pytest.mark.parametrize("words", [(), ("--dsl",)])
def test_generate_without_words(place: Place, words: tuple[str, ...]) -> None:
    answer = (
        '```scene\n(bind "qwertyui" (lambda () (call "cube")))\n```'
        if words
        else python("@register()\ndef qwertyui() -> Shape:\n    return primitive_call('cube', {})")
    )
    server = place.serve(answers(answer))
    place.generate("a cube", "--ablate", "W", "-o", "out.scene", *words)
    (request,) = server.requests
    assert "eight random lower-case letters" in system(request)
    shown = texts(request["messages"][0])
    assert "tulip" not in shown
    assert '(bind "bench"' not in shown
    assert len(set(re.findall(r'(?:def |bind ")([a-z]{8})\b', shown))) >= 3
    assert '"""' not in shown
    assert '(bind "qwertyui"' in (place.work / "out.scene").read_text()


def test_a_film_without_programs(place: Place) -> None:
    server = place.serve(answers(f"[[{BALL}], [{BALL.replace('0,1,0,2', '0,1,0,3')}]]"))
    place.generate("a ball", "--ablate", "P", "--animate", "-o", "out.scene")
    assert "a list of frames" in system(server.requests[0])
    assert len(json.loads(place.run("flatten", "out.scene", "--json", "-q").out)["frames"]) == 2


# --- edits of a recorded scene -------------------------------------------------------------------------------------


def test_no_words_the_random_names_come_back_as_words() -> None:
    program = code("t06-son-of-man")
    chosen = brief(Ablation.W, Notation.PYTHON, program, seed=7)
    assert chosen.renamed is not None
    sent = chosen.renamed.text
    assert "apple(" not in sent
    assert "son_of_man" not in sent
    assert APPLE[0] in sent
    verdict = read(chosen, f"```python\n{sent.replace(*APPLE)}```")
    assert '(bind "green_apple"' in verdict.program
    assert '(scene "son_of_man")' in verdict.program
    assert not any(name in verdict.program for name in chosen.renamed.words)
    assert verdict.scene is not None
    found = changes(scene_of("t06-son-of-man"), verdict.scene)
    assert found.counts == {"moved": 6}, "the apple, its stem and four leaves"


def test_no_words_in_the_language() -> None:
    program = Session().transpile(Source("t06.txt", recorded("t06-son-of-man"))).text
    chosen = brief(Ablation.W, Notation.LANGUAGE, program, seed=7)
    assert chosen.renamed is not None
    sent = chosen.renamed.text
    assert "green_apple" not in sent
    verdict = read(chosen, f"```scene\n{sent}```")
    assert verdict.scene is not None
    assert '(bind "green_apple"' in verdict.program
    assert changes(scene_of("t06-son-of-man"), verdict.scene).equal


@pytest.mark.parametrize("ablation", [Ablation.P, Ablation.PW])
def test_no_program_a_list_is_edited(ablation: Ablation) -> None:
    before = scene_of("t06-son-of-man")
    text = listing(before, not ablation.takes_words)
    chosen = brief(ablation, Notation.LIST, text)
    assert text in texts_of(chosen)
    assert ("green_apple" in text) is (ablation is Ablation.P)
    items = json.loads(text)
    apple = [number for number, entry in enumerate(json.loads(listing(before, True))) if entry["word"] == "green_apple"]
    for number in apple:
        items[number]["pose"][0][3] -= 0.8
    verdict = read(chosen, f"Here it is.\n```json\n{json.dumps(items)}\n```\nDone.")
    assert verdict.scene is not None
    found = changes(before, verdict.scene)
    assert found.counts == {"moved": len(apple)}
    assert len(apple) == 6


def texts_of(chosen: Brief) -> str:
    return "\n".join(getattr(part, "text", "") for part in chosen.first.parts)


# --- round trips ---------------------------------------------------------------------------------------------------


BRIEF = ("n01-table-apples-bananas", "n22-greek-temple", "t02-moai", "t04-jenga", "t06-son-of-man", "t13-stonehenge")
CORPUS = [
    pytest.param(path, id=path.stem, marks=[] if path.stem in BRIEF else [pytest.mark.slow])
    for path in sorted(RESPONSES.glob("*.txt"))
]


@pytest.mark.parametrize("path", CORPUS)
@pytest.mark.sampled(3)
def test_lists_of_the_corpus_round_trip(path: Path) -> None:
    before = scene_of(path.stem)
    if sum(primitive_count(frame) for frame in before.frames) > MAX_ITEMS:
        pytest.skip("a list holds fewer primitives")
    result = Session().evaluate(Source("list.scene", program_of(listing(before, True), "a task")))
    assert result.scene is not None, [d.message for d in result.diagnostics]
    assert changes(before, result.scene).equal


@pytest.mark.parametrize("path", sorted(RESPONSES.glob("*.txt")), ids=lambda path: path.stem)
@pytest.mark.sampled(8)
def test_programs_under_random_names_give_the_same_scene(path: Path) -> None:
    renamed = rename_python(code(path.stem), 3)
    assert renamed == rename_python(code(path.stem), 3)
    assert set(renamed.words) != set(rename_python(code(path.stem), 4).words)
    result = Session().evaluate(Source("renamed.txt", f"```python\n{renamed.text}```"))
    assert result.scene is not None
    assert changes(scene_of(path.stem), result.scene).equal


def test_seeds_give_the_same_names_in_the_language() -> None:
    program = '(define (size) 2) (bind "thing" (lambda () (call "cube" :scale (size)))) (bind "all" (lambda () (call "thing")))'
    one = rename_language(program, 5)
    assert one == rename_language(program, 5)
    assert one != rename_language(program, 6)
    assert set(one.words.values()) == {"size", "thing", "all"}
    assert "cube" in one.text
    assert one.restored(one.text) == rename_language(program, 6).restored(rename_language(program, 6).text)
