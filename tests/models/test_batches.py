"""Batches: what all samples ask goes out in rounds at half the price, and nothing is submitted twice."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from models.server import ModelServer, Said, serving
from models.services import KEY, hurry, one_line, set_apart
from scenelang.backends.language_models.catalogue import Model, Usage
from scenelang.backends.language_models.client import Client
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference import conductor, steps
from scenelang.inference.brief import Notation, Task
from scenelang.inference.conductor import Inference, Result
from scenelang.inference.records import InferenceSettings, Run, new_run
from scenelang.interpreter.scene.entity import primitive_count
from scenelang.session.session import Options

pytestmark = pytest.mark.usefixtures("untried")

WRONG = '```scene\n(bind "pile" (lambda () (pillar 2)))\n```'
PROMPT = 2_000  # tokens of every prompt, as the server counts them


def cubes(count: int) -> str:
    return f'```scene\n(bind "pile" (lambda () (union-loop {count} (lambda (i) (transform (call "cube") (translate [(* 3 i) 0.5 0]))))))\n```'


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    set_apart(monkeypatch, tmp_path)
    hurry(monkeypatch)
    monkeypatch.setattr(conductor, "_FIRST_WAIT", 0.01)
    draw = steps.picture
    monkeypatch.setattr(steps, "picture", lambda scene, view, frame=None: draw(scene, view, frame, 48))
    monkeypatch.setattr(steps, "_VIEW_PX", 48)


class Place:
    """One run folder, and a server that answers batches from ``drafts`` in their order, single questions with BEST: 2."""

    def __init__(self, folder: Path, server: ModelServer) -> None:
        self.server = server
        self.run_ = new_run(folder / "runs", "a pile", str)
        server.count = lambda body: PROMPT

    def client(self, **settings: Any) -> tuple[Inference, Client]:
        chosen = InferenceSettings(
            **{"is_batch": True, "samples": 2, "max_tokens": 1_000, "uses_replies": False, **settings}
        )
        return Inference(Task("a pile", notation=Notation.LANGUAGE), chosen, Options()), chosen.client(self.run_.spent)

    def play(self, **settings: Any) -> Result:
        inference, client = self.client(**settings)
        run = Run(self.run_.path, client.redact)
        inference.begin(run, "generate")
        return inference.run(run, client, None)

    @property
    def submitted(self) -> list[list[str]]:
        """The questions of each batch, by name."""
        return [[entry["custom_id"] for entry in batch] for batch in self.server.batches.values()]

    @property
    def single(self) -> list[dict[str, Any]]:
        return [body for body in self.server.requests if body.get("stream")]


Make = Callable[..., Place]


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    servers = []

    def made(*drafts: Said | str) -> Place:
        left = [Said(draft) if isinstance(draft, str) else draft for draft in drafts]
        context = serving(lambda body: Said("BEST: 2") if body.get("stream") else left.pop(0))
        server = context.__enter__()
        servers.append(context)
        monkeypatch.setenv("ANTHROPIC_BASE_URL", server.url)
        return Place(tmp_path, server)

    yield made
    for context in servers:
        context.__exit__(None, None, None)


def opus(place: Place) -> Model:
    return place.client()[1].model


# --- rounds --------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_samples_go_on_in_rounds(make: Make) -> None:
    """Sample 1 needs a repair and sample 3 two; then the judge, who is asked singly, takes the second."""
    place = make(WRONG, cubes(2), WRONG, cubes(1), WRONG, cubes(3))
    place.server.patience = 3
    result = place.play(samples=3)
    assert place.submitted == [["sample-1-1", "sample-2-1", "sample-3-1"], ["sample-1-2", "sample-3-2"], ["sample-3-3"]]
    assert [place.server.polled.count(name) for name in place.server.batches] == [5, 5, 5]  # the last for the results
    assert len(place.single) == 1
    assert result.sample == 2
    assert result.best.scene is not None
    assert primitive_count(result.best.scene.frames[0]) == 2
    recorded = [(a.sample, a.number, a.purpose) for a in place.run_.attempts() if a.sample]
    assert recorded == [
        (1, 1, "draft"),
        (1, 2, "repair"),
        (2, 1, "draft"),
        (3, 1, "draft"),
        (3, 2, "repair"),
        (3, 3, "repair"),
    ]


def test_what_a_batch_sends(make: Make) -> None:
    """Each entry is what a single request says, and a repair shows the mistake."""
    place = make(WRONG, cubes(1))
    place.play(samples=1, model="claude-opus-4-5", effort="low")
    (first,), (second,) = place.server.batches.values()
    assert set(first) == {"custom_id", "params"}
    assert set(first["params"]) == {"model", "max_tokens", "system", "messages", "output_config"}
    assert (first["params"]["model"], first["params"]["max_tokens"]) == ("claude-opus-4-5", 1_000)
    assert first["params"]["system"][0]["cache_control"] == {"type": "ephemeral"}
    question, answer, repair = second["params"]["messages"]
    assert [question] == first["params"]["messages"]
    assert answer == {"role": "assistant", "content": [{"type": "text", "text": WRONG}]}
    assert "pillar" in repair["content"][0]["text"]
    kept = json.loads((place.run_.path / "sample-1" / "01-draft" / "request.json").read_text())
    assert kept == first["params"]


def test_a_batch_costs_half(make: Make) -> None:
    usage = {
        "input_tokens": 500,
        "cache_creation_input_tokens": 1_000,
        "cache_read_input_tokens": 500,
        "output_tokens": 200,
    }
    place = make(Said(cubes(1), usage=usage))
    result = place.play(samples=1)
    cost = (500 * 4 + 1_000 * 5 + 500 * 0.2 + 200 * 20) / 1e6 / 2
    assert result.spent == pytest.approx(cost)
    assert place.run_.spent == pytest.approx(cost)
    assert result.usage == Usage(500, 500, 1_000, 200)


# --- money ---------------------------------------------------------------------------------------------------------------


def test_a_batch_is_submitted_only_where_all_of_it_can_be_paid(make: Make) -> None:
    place = make(cubes(1), cubes(2))
    together = 2 * opus(place).max_cost(PROMPT, 1_000, is_batch=True)
    with pytest.raises(SceneError) as caught:
        place.play(max_cost=together - 0.0001)
    assert caught.value.name == "model-cost"
    assert f"could cost ${together:.4f}" in one_line(caught.value)
    assert place.submitted == []
    assert place.play(max_cost=together).sample == 1  # the judge, at full price, is no longer within the limit
    assert place.single == []


def test_what_a_batch_did_not_use_is_free_for_the_next(make: Make) -> None:
    place = make(WRONG, cubes(1))
    once = opus(place).max_cost(PROMPT, 1_000, is_batch=True)
    assert place.play(samples=1, max_cost=1.5 * once).sample == 1
    assert len(place.submitted) == 2


def test_what_is_set_aside_becomes_what_answers_cost(make: Make) -> None:
    place = make(cubes(1), Said("not allowed", status=400))
    place.server.patience = 0
    inference, client = place.client(max_cost=1.0)
    speaker = inference.settings.speaker(client.model, Notation.LANGUAGE)
    asked = inference.first_request(speaker)
    batch, reserved = client.submit({"a": asked, "b": asked})
    each = client.model.max_cost(PROMPT, 1_000, is_batch=True)
    assert reserved == {"a": each, "b": each}
    with pytest.raises(SceneError):
        client.budget.reserve(1.0 - 2 * each + 0.001)
    answers = client.collect(batch, reserved)
    assert isinstance(answers["b"], SceneError)
    cost = client.model.cost(Usage(1_000, answered=len(cubes(1)) // 4), is_batch=True)
    assert client.budget.spent == pytest.approx(cost)
    client.budget.reserve(1.0 - cost)


# --- entries that fail -----------------------------------------------------------------------------------------------------


def test_a_sample_whose_entry_failed_ends_alone(make: Make) -> None:
    place = make(Said(f"no {KEY}\nat all", status=400), cubes(2))
    result = place.play()
    assert (result.sample, place.single) == (2, [])
    (error,) = result.stopped
    assert "the request in the batch failed: no [key] at all" in one_line(error)
    assert result.spent == pytest.approx(opus(place).cost(Usage(1_000, answered=len(cubes(2)) // 4), is_batch=True))


def test_where_every_entry_failed_it_is_said_why(make: Make) -> None:
    place = make(Said("first", status=400), Said("second", status=400))
    with pytest.raises(SceneError, match="the request in the batch failed: first"):
        place.play()
    assert place.run_.spent == 0.0


def test_an_answer_that_is_missing_is_an_error(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    place = make(cubes(1), cubes(2))
    monkeypatch.setattr(conductor.Client, "collect", lambda self, batch, reserved: {})
    with pytest.raises(SceneError, match="the batch contains no answer to this request"):
        place.play()


def test_a_paused_answer_is_asked_for_anew(make: Make) -> None:
    """A batch cannot go on with it, and half an answer is none."""
    place = make(Said("half", stop="pause_turn"), cubes(2))
    assert place.play(samples=1).sample == 1
    (first,), (second,) = place.server.batches.values()
    assert first["params"] == second["params"]


def test_results_that_cannot_be_read_are_one_line(make: Make) -> None:
    place = make(cubes(1), cubes(2))
    place.server.tail = f"\n{{broken {KEY}"
    with pytest.raises(SceneError) as caught:
        place.play()
    assert one_line(caught.value).startswith("the service failed: cannot read the replies of the batch")


# --- a batch under way -----------------------------------------------------------------------------------------------------


class Killed(BaseException):
    """Stands for the end of the process."""


def killed(*_: object) -> None:
    raise Killed


def test_a_batch_under_way_is_asked_after_again(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    place = make(WRONG, cubes(2), cubes(3))
    place.server.patience = 2
    with monkeypatch.context() as patch:
        patch.setattr(conductor.time, "sleep", killed)
        with pytest.raises(Killed):
            place.play()
    assert place.submitted == [["sample-1-1", "sample-2-1"]]
    result = place.play()
    assert place.submitted == [["sample-1-1", "sample-2-1"], ["sample-1-2"]]  # the first was not sent again
    assert place.server.polled[:3] == ["msgbatch_0"] * 3
    assert result.sample == 2
    assert place.run_.facts["batch"] is None
    assert place.run_.spent == pytest.approx(result.spent)


def test_a_run_that_ends_amid_the_answers_of_a_batch(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """The answers that were not written down yet are taken from the same batch, and paid for once."""
    place = make(cubes(1), cubes(2), cubes(1), cubes(2))  # the server makes the answers up each time
    answered = Run.answered

    def once(self: Run, sample: int, *rest: Any) -> None:
        if sample == 2:
            raise Killed
        answered(self, sample, *rest)

    limit = 2 * opus(place).max_cost(PROMPT, 1_000, is_batch=True)
    with monkeypatch.context() as patch:
        patch.setattr(Run, "answered", once)
        with pytest.raises(Killed):
            place.play(max_cost=limit)
    result = place.play(max_cost=limit)
    assert place.submitted == [["sample-1-1", "sample-2-1"]]
    assert place.run_.spent == pytest.approx(result.spent)


def test_other_questions_are_another_batch(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    place = make(cubes(1), cubes(2))
    with monkeypatch.context() as patch:
        patch.setattr(conductor.time, "sleep", killed)
        with pytest.raises(Killed):
            place.play(samples=1)
    assert place.play(samples=1, max_tokens=2_000).sample == 1
    assert [batch[0]["params"]["max_tokens"] for batch in place.server.batches.values()] == [1_000, 2_000]


def test_a_run_that_is_done_asks_nothing(make: Make) -> None:
    place = make(cubes(1), cubes(2))
    first = place.play()
    sent = len(place.server.requests)
    again = place.play()
    assert len(place.submitted) == 1
    assert len(place.server.requests) == sent
    assert (again.sample, again.best.program, again.spent) == (
        first.sample,
        first.best.program,
        pytest.approx(first.spent),
    )


def test_what_an_earlier_run_asked_is_not_submitted(make: Make, tmp_path: Path) -> None:
    place = make(cubes(1), cubes(2), cubes(3))
    place.play(uses_replies=True)
    another = Place(tmp_path, place.server)
    result = another.play(uses_replies=True, samples=3)
    assert place.submitted == [["sample-1-1", "sample-2-1"], ["sample-3-1"]]
    assert another.run_.path != place.run_.path
    costs = {attempt.sample: attempt.cost for attempt in another.run_.attempts()}
    assert costs[1] == costs[2] == 0.0 < costs[3]
    assert result.best.scene is not None


def test_a_batch_that_never_ends_is_given_up(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    place = make(cubes(1))
    place.server.patience = 1_000_000
    monkeypatch.setattr(conductor, "_MAX_BATCH_TIME", 0.1)
    with pytest.raises(SceneError, match="not finished after a day"):
        place.play(samples=1)
    assert place.run_.facts["batch"]["id"] == "msgbatch_0"  # it may be looked at again


def test_a_batch_that_is_gone_is_one_line(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    place = make(cubes(1))
    with monkeypatch.context() as patch:
        patch.setattr(conductor.time, "sleep", killed)
        with pytest.raises(Killed):
            place.play(samples=1)
    place.server.batches.clear()
    with pytest.raises(SceneError) as caught:
        place.play(samples=1)
    assert "(404)" in one_line(caught.value)
