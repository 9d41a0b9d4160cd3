"""The loop of `generate`: repair, critique, the best of several samples, kept replies, cut and broken answers, money."""

from __future__ import annotations

import base64
import json
from io import BytesIO
from typing import Any

import pytest
from PIL import Image

from models.conftest import WRONG, Place, answers, cubes, pictures, python, recorded, system, texts
from models.server import Said
from scenelang.session.session import Session

pytestmark = pytest.mark.usefixtures("untried")

FLOATING = python("""
@register()
def pile() -> Shape:
    cube = primitive_call("cube", shape_kwargs={"scale": (1, 1, 1)})
    return concat_shapes(*[transform_shape(cube, translation_matrix((0, y, 0))) for y in (0.5, 1.6)])
""")


def count(place: Place, name: str = "out.scene") -> dict[str, int]:
    found: dict[str, int] = json.loads(place.run("count", name, "--json").out)
    return found


def roles(request: dict[str, Any]) -> list[str]:
    return [turn["role"] for turn in request["messages"]]


# --- repair --------------------------------------------------------------------------------------------------------


def test_what_a_person_sees_goes_back(place: Place) -> None:
    server = place.serve(answers(WRONG, cubes(2)))
    place.generate("two cubes", "-o", "out.scene")
    first, second = server.requests
    assert roles(second) == ["user", "assistant", "user"]
    assert second["messages"][0] == first["messages"][0]
    assert system(second) == system(first)
    assert texts(second["messages"][1]) == WRONG
    (place.work / "answer.txt").write_text(WRONG)
    seen = place.run("count", "answer.txt", "--no-color").err.strip()
    assert "pillar" in seen
    assert "answer.txt:" in seen
    assert seen in texts(second["messages"][2])
    assert count(place)["cube"] == 2


def test_errors_while_it_runs_go_back_too(place: Place) -> None:
    endless = python("@register()\ndef pile() -> Shape:\n    while True:\n        pass\n    return concat_shapes()")
    server = place.serve(answers(endless, cubes()))
    place.generate("a cube", "--max-steps", "10k")
    assert "steps" in texts(server.requests[1]["messages"][-1])


def test_only_the_last_answer_goes_back(place: Place) -> None:
    other = WRONG.replace("pillar", "column")
    server = place.serve(answers(WRONG, other, cubes()))
    place.generate("a cube")
    third = server.requests[2]
    assert roles(third) == ["user", "assistant", "user"]
    assert texts(third["messages"][1]) == other
    assert "column" in texts(third["messages"][2])
    assert "pillar" not in texts(third["messages"][2])


def test_an_empty_answer_is_asked_for_anew(place: Place) -> None:
    server = place.serve(answers("", "no program here", cubes()))
    place.generate("a cube")
    assert texts(server.requests[1]["messages"][1]) == "(no text)"
    assert "the answer is empty" in texts(server.requests[1]["messages"][2])
    assert len(server.requests) == 3


def test_at_the_limit_of_repairs_the_mistakes_are_shown(place: Place) -> None:
    (place.work / "out.scene").write_text("; mine\n")
    server = place.serve(answers(WRONG, WRONG, WRONG))
    done = place.run("generate", "a cube", "--repair", "2", "-o", "out.scene")
    assert done.code == 1
    assert len(server.requests) == 3
    assert "pillar" in done.err
    assert "no sample produced a valid program" in done.err
    assert f"the run is saved in {place.run_folder()}" in done.err
    assert (place.work / "out.scene").read_text() == "; mine\n"
    assert "pillar" in (place.run_folder() / "sample-1" / "03-repair" / "diagnostics.txt").read_text()
    assert json.loads((place.run_folder() / "run.json").read_text())["state"] == "failed"


def test_without_repairs_one_answer_decides(place: Place) -> None:
    server = place.serve(answers(WRONG))
    assert place.run("generate", "a cube", "--repair", "0").code == 1
    assert len(server.requests) == 1


# --- critique ------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("small_pictures")
def test_pictures_go_back_and_an_improvement_is_taken(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenelang.inference.steps._REPAIR_EFFORT", 0.0)  # leaves the finding to the model
    better = cubes(3)
    server = place.serve(answers(FLOATING, better, "NO CHANGES"))
    place.generate("three cubes", "--critique", "5", "-o", "out.scene")
    draft, critique, last = server.requests
    turn = critique["messages"][-1]
    sent = pictures(turn)
    assert len(sent) == 4
    assert len({picture["data"] for picture in sent}) == 4
    with Image.open(BytesIO(base64.b64decode(sent[0]["data"]))) as image:
        assert len(set(image.convert("RGB").tobytes())) > 4, "the picture shows something"
    assert [part["type"] for part in turn["content"][:2]] == ["text", "image"]
    assert turn["content"][0]["text"] == "The scene, from the front:"
    assert "NO CHANGES" in texts(turn)
    assert "The checker noticed" in texts(turn)
    assert "W612" in texts(turn)
    assert texts(critique["messages"][1]) == FLOATING
    assert critique["messages"][0] == draft["messages"][0]
    assert texts(last["messages"][1]) == better
    assert roles(last) == ["user", "assistant", "user"]
    assert "The checker noticed" not in texts(last["messages"][2])
    assert count(place)["cube"] == 3


@pytest.mark.usefixtures("small_pictures")
def test_findings_are_repaired_before_the_model_sees_them(place: Place) -> None:
    server = place.serve(answers(FLOATING, "NO CHANGES"))
    place.generate("cubes", "--critique", "1", "-o", "out.scene")
    assert "The checker noticed" not in texts(server.requests[1]["messages"][-1])
    assert [d.code for d in Session().check_geometry(Session().source(str(place.work / "out.scene")))] == []


@pytest.mark.usefixtures("small_pictures")
@pytest.mark.parametrize("answer", ["NO CHANGES", "  no changes.\n", "**NO CHANGES**", "`NO CHANGES`"])
@pytest.mark.sampled(2)
def test_no_changes_ends_it(place: Place, answer: str) -> None:
    server = place.serve(answers(cubes(2), answer))
    place.generate("two cubes", "--critique", "3", "-o", "out.scene")
    assert len(server.requests) == 2
    assert count(place)["cube"] == 2


@pytest.mark.slow
@pytest.mark.usefixtures("small_pictures")
def test_a_broken_improvement_is_repaired_or_left(place: Place) -> None:
    server = place.serve(answers(cubes(2), WRONG, cubes(4)))
    place.generate("cubes", "--critique", "1", "-o", "repaired.scene")
    assert "pillar" in texts(server.requests[2]["messages"][-1])
    assert len(pictures(server.requests[2]["messages"][2])) == 4
    assert count(place, "repaired.scene")["cube"] == 4
    server = place.serve(answers(cubes(2), WRONG, WRONG))
    place.generate("cubes", "--critique", "3", "--repair", "1", "-o", "left.scene")
    assert len(server.requests) == 3
    assert count(place, "left.scene")["cube"] == 2


@pytest.mark.usefixtures("small_pictures")
def test_an_improvement_with_more_findings_is_not_taken(place: Place) -> None:
    place.serve(answers(cubes(2), FLOATING))
    place.generate("cubes", "--critique", "1", "-o", "out.scene")
    assert "translate [(* 2 i) 0.5 0]" in (place.work / "out.scene").read_text()


HOVERING = """```scene
(bind "table" (lambda () (transform (call "cube" :scale [2 1 2]) (translate [0 .5 0]))))
(bind "cup" (lambda () (call "cylinder" :radius .2 :p0 [0 0 0] :p1 [0 .3 0])))
(bind "scene" (lambda () (union (call "table") (transform (call "cup") (translate [0 1.11 0])))))
(scene "scene")
```"""


@pytest.mark.usefixtures("small_pictures")
def test_a_repair_without_the_model_is_told_in_one_line(place: Place) -> None:
    server = place.serve(answers(HOVERING, "NO CHANGES"))
    place.generate("a cup on a table", "--dsl", "--critique", "1", "-o", "out.scene")
    *_, answer, turn = server.requests[1]["messages"]
    assert "1.11" not in texts(answer)  # the model sees the program as it is now
    (told,) = [line for line in texts(turn).splitlines() if line.startswith("Numbers of the program were")]
    assert "cup" in told
    assert "The checker noticed" not in texts(turn)
    assert "1.11" not in (place.work / "out.scene").read_text()


@pytest.mark.usefixtures("small_pictures")
def test_a_failure_in_the_critique_keeps_the_draft(place: Place) -> None:
    place.serve([Said(cubes(2)), Said("not now", status=400)])
    done = place.generate("cubes", "--critique", "1", "-o", "out.scene")
    assert "a sample ended early" in done.err
    assert count(place)["cube"] == 2


@pytest.mark.usefixtures("small_pictures")
@pytest.mark.slow
def test_a_film_is_shown_at_several_times(place: Place) -> None:
    server = place.serve(answers(recorded("n13-carousel"), "NO CHANGES"))
    place.generate("a carousel", "--animate", "--critique", "1")
    turn = server.requests[1]["messages"][-1]
    captions = [part["text"] for part in turn["content"] if part["type"] == "text"][:-1]
    assert len(captions) == len(pictures(turn)) == 4
    assert captions[0].startswith("The scene, frame 0 of ")
    assert len(set(captions)) == 4


# --- samples -------------------------------------------------------------------------------------------------------


def test_the_sample_with_the_fewest_findings_is_taken(place: Place) -> None:
    server = place.serve(answers(FLOATING, cubes(2), WRONG))
    done = place.generate("cubes", "-n", "3", "--jobs", "1", "--repair", "0", "-o", "out.scene")
    assert len(server.requests) == 3, "nothing is left to judge"
    assert server.requests[0] == server.requests[1] == server.requests[2]
    assert "sample 2;" in done.err
    assert count(place)["cube"] == 2


@pytest.mark.usefixtures("small_pictures")
@pytest.mark.parametrize(
    ("verdict", "best"),
    [("BEST: 3", 3), ("best: #2\nsince ...", 2), ("I cannot say.", 1), ("BEST: 99", 1), ("BEST: " + "9" * 5000, 1), ("", 1)],
)  # fmt: skip
@pytest.mark.sampled(3)
def test_the_judge_looks_at_a_contact_sheet(place: Place, verdict: str, best: int) -> None:
    server = place.serve(answers(cubes(1), cubes(2), cubes(3), verdict))
    done = place.generate("many cubes", "-n", "3", "--jobs", "1", "-o", "out.scene")
    judge = server.requests[3]
    (turn,) = judge["messages"]
    (sheet,) = pictures(turn)
    with Image.open(BytesIO(base64.b64decode(sheet["data"]))) as image:
        assert image.size == (2 * 56 + 8, 2 * 56 + 8)
    assert "3 scenes" in texts(turn)
    assert "many cubes" in texts(turn)
    assert "You compare pictures" in system(judge)
    assert count(place)["cube"] == best
    assert f"sample {best};" in done.err


@pytest.mark.usefixtures("small_pictures")
def test_the_judge_sees_the_pictures_of_the_task(place: Place) -> None:
    Image.new("RGB", (20, 20), "red").save(place.work / "a.png")
    server = place.serve(answers(cubes(1), cubes(2), "BEST: 2"))
    place.generate("--image", "a.png", "-n", "2", "--jobs", "1", "-o", "out.scene")
    (turn,) = server.requests[2]["messages"]
    assert pictures(turn)[0] == pictures(server.requests[0]["messages"][0])[0]
    assert len(pictures(turn)) == 2
    assert "Reconstruct the scene of the pictures before." in texts(turn)


@pytest.mark.usefixtures("small_pictures")
def test_without_a_judge_the_first_is_taken(place: Place) -> None:
    place.serve([*answers(cubes(1), cubes(2)), Said("no", status=400)])
    place.generate("cubes", "-n", "2", "--jobs", "1", "-o", "out.scene")
    assert count(place)["cube"] == 1


def test_samples_side_by_side_each_have_an_answer(place: Place) -> None:
    server = place.serve(lambda body: Said(FLOATING if len(server.requests) == 1 else cubes(2)))
    done = place.generate("cubes", "-n", "2", "-o", "out.scene")
    assert len(server.requests) == 2
    assert count(place)["cube"] == 2
    assert "2,000 input tokens" in done.err


def test_a_sample_that_fails_does_not_stop_the_others(place: Place) -> None:
    place.serve([Said("", stop="refusal"), Said(cubes(2))])
    done = place.generate("cubes", "-n", "2", "--jobs", "1", "-o", "out.scene")
    assert "a sample ended early: the model refused" in done.err
    assert "sample 2;" in done.err


# --- kept replies --------------------------------------------------------------------------------------------------


def test_what_was_asked_before_is_not_sent_again(place: Place) -> None:
    server = place.serve(answers(WRONG, cubes(2)))
    place.generate("two cubes", "-o", "one.scene")
    done = place.generate("two cubes", "-o", "two.scene")
    assert len(server.requests) == 2
    assert len(server.counted) == 2
    assert (place.work / "one.scene").read_text() == (place.work / "two.scene").read_text()
    assert "0 input tokens, 0 output tokens, $0.0000" in done.err


def test_another_task_or_no_cache_is_asked_anew(place: Place) -> None:
    server = place.serve(answers(cubes(1), cubes(2), cubes(3), cubes(4)))
    place.generate("a", "-o", "out.scene")
    place.generate("b", "-o", "out.scene")
    place.generate("a", "-o", "out.scene", "--no-cache")
    place.generate("a", "-o", "out.scene", "--effort", "low")
    assert len(server.requests) == 4
    assert count(place)["cube"] == 4


def test_a_kept_reply_that_is_damaged_is_asked_anew(place: Place) -> None:
    server = place.serve(answers(cubes(1), cubes(2), cubes(3)))
    place.generate("a", "-o", "out.scene")
    (kept,) = (place.folder / "cache" / "scenelang" / "replies").glob("*.json")
    kept.write_text(kept.read_text()[:50])
    place.generate("a", "-o", "out.scene")
    kept.write_text('{"text": 3, "stop": "end", "usage": [], "model": 1, "note": null}')
    place.generate("a", "-o", "out.scene")
    assert len(server.requests) == 3
    assert count(place)["cube"] == 3


# --- how answers end -----------------------------------------------------------------------------------------------


def test_a_cut_answer_gets_more_room_then_is_to_be_shorter(place: Place) -> None:
    cut = Said(cubes()[:150], stop="max_tokens")
    server = place.serve([cut, cut, cut, Said(cubes(2))])
    place.generate("cubes", "-o", "out.scene", "--max-cost", "50")
    assert [request["max_tokens"] for request in server.requests] == [32_000, 64_000, 128_000, 128_000]
    assert [len(request["messages"]) for request in server.requests] == [1, 1, 1, 3]
    told = texts(server.requests[3]["messages"][-1])
    assert "The answer was cut off after 128,000 tokens" in told
    assert "more compactly" in told
    assert texts(server.requests[3]["messages"][1]) == cut.text
    assert count(place)["cube"] == 2


def test_a_length_that_was_chosen_is_not_exceeded(place: Place) -> None:
    server = place.serve([Said("x", stop="max_tokens"), Said(cubes())])
    place.generate("cubes", "--max-tokens", "900")
    assert [request["max_tokens"] for request in server.requests] == [900, 900]
    assert "The answer was cut off after 900 tokens" in texts(server.requests[1]["messages"][-1])


def test_answers_that_stay_cut(place: Place) -> None:
    place.serve([Said("x", stop="max_tokens")] * 2)
    done = place.run("generate", "cubes", "--max-tokens", "900", "--repair", "1")
    assert done.code == 1
    assert "the answer was truncated after 900 tokens" in done.err


def test_a_refusal_is_told(place: Place) -> None:
    server = place.serve(
        [Said("", stop="refusal", details={"type": "refusal", "category": "bio", "explanation": "no"})]
    )
    done = place.run("generate", "cubes", "-o", "out.scene")
    assert done.code == 1
    assert "the model refused to answer" in done.err
    assert len(server.requests) == 1
    assert not (place.work / "out.scene").exists()


def test_a_full_context_is_told(place: Place) -> None:
    place.serve([Said("x", stop="model_context_window_exceeded")])
    done = place.run("generate", "cubes")
    assert done.code == 1
    assert "the model's context window is full" in done.err


def test_a_broken_stream_is_a_new_attempt(place: Place) -> None:
    answer = recorded("t02-moai")
    server = place.serve(
        [Said(answer, breaks_after=300), Said(answer, breaks_after=900, is_error_event=True), Said(answer)]
    )
    place.generate("moai", "-o", "out.scene")
    assert len(server.requests) == 3
    assert server.requests[0] == server.requests[2]
    attempts = sorted(path.name for path in (place.run_folder() / "sample-1").iterdir())
    assert attempts == ["01-draft", "02-draft", "03-draft"]
    kept = (place.run_folder() / "sample-1" / "01-draft" / "answer.txt").read_text()
    assert answer.startswith(kept)
    assert 300 <= len(kept) < len(answer)


def test_streams_that_keep_breaking(place: Place) -> None:
    server = place.serve([Said(cubes(), breaks_after=64)] * 3)
    done = place.run("generate", "cubes", "--max-cost", "50")
    assert done.code == 1
    assert "the answer was incomplete 3 times" in done.err
    assert len(server.requests) == 3


def test_a_pause_is_continued(place: Place) -> None:
    whole = cubes(2)
    server = place.serve([Said(whole[:80], stop="pause_turn"), Said(whole[80:])])
    place.generate("cubes", "-o", "out.scene")
    assert server.requests[1]["messages"][-1]["role"] == "assistant"
    assert texts(server.requests[1]["messages"][-1]) == whole[:80]
    assert count(place)["cube"] == 2


def test_thinking_is_no_part_of_the_answer(place: Place) -> None:
    place.serve([Said(cubes(2), thinks=True)])
    place.generate("cubes", "-o", "out.scene")
    assert (place.run_folder() / "sample-1" / "01-draft" / "answer.txt").read_text() == cubes(2)


# --- money ---------------------------------------------------------------------------------------------------------


def test_the_limit_is_kept_before_the_first_request(place: Place) -> None:
    server = place.serve([])
    done = place.run("generate", "a cube", "--max-cost", "0.10")
    assert done.code == 1
    assert "the next request could cost $0.6" in done.err
    assert "--max-cost" in done.err
    assert not server.requests
    assert len(server.counted) == 1


@pytest.mark.usefixtures("small_pictures")
def test_the_limit_in_the_middle_keeps_the_best_so_far(place: Place) -> None:
    dear = {"output_tokens": 30_000}
    server = place.serve([Said(cubes(2), usage=dear), Said(cubes(3))])
    done = place.generate("cubes", "--critique", "3", "--max-cost", "0.8", "-o", "out.scene")
    assert len(server.requests) == 1
    assert "a sample ended early: the next request could cost" in done.err
    assert count(place)["cube"] == 2


def test_the_limit_between_samples(place: Place) -> None:
    server = place.serve([Said(cubes(2), usage={"output_tokens": 30_000})])
    done = place.generate("cubes", "-n", "3", "--jobs", "1", "--max-cost", "0.8", "-o", "out.scene")
    assert len(server.requests) == 1
    assert done.err.count("a sample ended early") == 2
    assert count(place)["cube"] == 2


# --- batches -------------------------------------------------------------------------------------------------------


def test_batches_ask_all_samples_at_once(place: Place) -> None:
    server = place.serve(answers(WRONG, FLOATING, cubes(2)))
    done = place.generate("cubes", "-n", "2", "--batch", "-o", "out.scene")
    assert [len(batch) for batch in server.batches.values()] == [2, 1]
    ids = [entry["custom_id"] for batch in server.batches.values() for entry in batch]
    assert ids == ["sample-1-1", "sample-2-1", "sample-1-2"]
    assert "sample 1;" in done.err
    assert count(place)["cube"] == 2


def test_a_film_that_stands_still_is_mended(place: Place) -> None:
    def film(moves: str) -> str:
        return python(f"""
@register_animation()
def film():
    for i in range(3):
        yield transform_shape(primitive_call('cube', shape_kwargs={{'scale': 1}}), translation_matrix(({moves}, 0, 0)))
""")

    server = place.serve(answers(film("0"), film("i")))
    place.generate("a sliding cube", "--animate", "-o", "film.scene")
    assert "all frames are equal" in texts(server.requests[1]["messages"][-1])


def test_samples_wait_for_money_that_others_may_give_back(place: Place) -> None:
    server = place.serve(lambda body: Said(cubes(2)))
    done = place.generate("two cubes", "-n", "4", "--max-cost", "0.75", "-o", "a.scene")
    assert "ended early" not in done.err
    assert len(server.requests) == 4, "equal programs need no judge"
