"""Runs that end early go on: after a kill, after Ctrl-C, after a failure; and one process at a time works on one."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from pathlib import Path
from shutil import copytree
from threading import Event
from typing import Any

import pytest
from support import PATIENCE, below, interruptible, is_running, wait_until

from models.conftest import WRONG, Place, answers, cubes, texts
from models.server import Said

pytestmark = pytest.mark.usefixtures("untried")


class Slow:
    """Answers in order; the answer of ``number`` waits until it is let go."""

    def __init__(self, number: int, *texts_: str) -> None:
        self.asked, self.let_go = 0, Event()
        self._number, self._texts = number, texts_

    def __call__(self, body: dict[str, Any]) -> Said:
        self.asked += 1
        if self.asked == self._number:
            self.let_go.wait(PATIENCE)
        return Said(self._texts[self.asked - 1])

    @property
    def is_waiting(self) -> bool:
        return self.asked >= self._number


def forget_replies(place: Place) -> None:
    for kept in (place.folder / "cache").rglob("*.json"):
        kept.unlink()


COMMAND = [sys.executable, "-m", "scenelang", "generate", "cubes", "-n", "2", "--jobs", "1", "-o", "out.scene"]


def kill_at_second(place: Place) -> None:
    """Run until the second sample's first answer is under way, then kill the process.

    The process below it, which asks the model, is told by the kernel and ends a moment later: an answer that came
    before would be recorded.
    """
    script = Slow(3, WRONG, cubes(2), cubes(3))
    server = place.serve(script)
    with subprocess.Popen(COMMAND, cwd=place.work, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        wait_until(lambda: script.is_waiting)
        workers = below(running.pid)
        running.send_signal(signal.SIGKILL)
        assert running.wait() == -signal.SIGKILL
    wait_until(lambda: not any(map(is_running, workers)))
    script.let_go.set()
    assert len(server.requests) == 3
    assert not (place.work / "out.scene").exists()


@pytest.mark.usefixtures("small_pictures")
def test_a_run_goes_on_after_a_kill(place: Place) -> None:
    kill_at_second(place)
    run = place.run_folder()
    assert json.loads((run / "run.json").read_text())["state"] == "running"
    assert (run / "sample-2" / "01-draft" / "request.json").exists()
    assert not (run / "sample-2" / "01-draft" / "reply.json").exists()
    sent = json.loads((run / "sample-2" / "01-draft" / "request.json").read_text())
    forget_replies(place)  # the run itself is enough
    server = place.serve(answers(cubes(3), "BEST: 2"))
    done = place.generate("--resume", "last")
    draft, judge = server.requests
    assert draft["messages"][0] == sent["messages"][0], "the question that had no answer is asked again"
    assert "2 scenes" in texts(judge["messages"][0])
    assert len(list(place.runs.iterdir())) == 1
    assert json.loads(place.run("count", "out.scene", "--json").out)["cube"] == 3
    assert "4,000 input tokens" in done.err, "what the killed process was answered counts"
    facts = json.loads((run / "run.json").read_text())
    assert facts["state"] == "done"
    spent = sum(json.loads(path.read_text())["cost"] for path in run.rglob("reply.json"))
    lost = sum(json.loads(path.read_text())["lost"] for path in run.rglob("sent.json"))
    assert lost > 32_000 * 20 / 1e6, "the killed request counts as dear as it could have been"
    assert facts["cost"] == pytest.approx(spent + lost)
    assert spent > 4 * 1000 * 4 / 1e6


def test_money_that_was_spent_before_counts(place: Place) -> None:
    dear = {"output_tokens": 30_000}
    place.serve([Said(WRONG, usage=dear)])
    done = place.run("generate", "cubes", "--repair", "1", "--max-cost", "0.8", "-o", "out.scene")
    assert done.code == 1
    assert "the next request could cost" in done.err
    server = place.serve(answers(cubes(2)))
    done = place.run("generate", "--resume", "last")
    assert done.code == 1
    assert "of --max-cost remains" in done.err
    assert not server.requests


@pytest.mark.slow
def test_ctrl_c_leaves_a_run_that_can_go_on(place: Place) -> None:
    script = Slow(2, WRONG, cubes(2))
    server = place.serve(script)
    words = [*COMMAND[:4], "cubes", "-o", "out.scene"]
    with interruptible(words, place.work) as running:
        wait_until(lambda: script.is_waiting)
        running.send_signal(signal.SIGINT)
        _, err = running.communicate()
        assert running.returncode == 130
    script.let_go.set()
    run = place.run_folder()
    told = err.decode()
    assert told.splitlines() == [f"interrupted; to resume: scenelang generate --resume {run.name}", "interrupted"]
    assert json.loads((run / "run.json").read_text())["state"] == "interrupted"
    server = place.serve(answers(cubes(4)))
    place.generate("--resume", run.name)
    (request,) = server.requests
    assert texts(request["messages"][1]) == WRONG, "the repair goes on where it was"
    assert json.loads(place.run("count", "out.scene", "--json").out)["cube"] == 4


@pytest.mark.slow
def test_two_processes_cannot_work_on_one_run(place: Place) -> None:
    script = Slow(1, cubes(2))
    server = place.serve(script)
    with subprocess.Popen(
        [*COMMAND[:4], "cubes", "-o", "out.scene"], cwd=place.work, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        wait_until(lambda: script.is_waiting)
        done = place.run("generate", "--resume", "last")
        assert done.code == 1
        assert "another process is using the run" in done.err
        script.let_go.set()
        running.communicate()
        assert running.returncode == 0
    assert len(server.requests) == 1
    assert json.loads((place.run_folder() / "run.json").read_text())["state"] == "done"
    assert (place.work / "out.scene").exists()


# --- finding a run -------------------------------------------------------------------------------------------------


@pytest.fixture
def finished(place: Place) -> tuple[Place, Path]:
    """A run that is done; what it wrote is gone."""
    place.serve(answers(cubes(2)))
    place.generate("two cubes", "-o", "out.scene")
    (place.work / "out.scene").unlink()
    return place, place.run_folder()


@pytest.mark.parametrize("how", ["name", "prefix", "last", "path"])
def test_a_finished_run_is_written_again_for_nothing(finished: tuple[Place, Path], how: str) -> None:
    place, run = finished
    forget_replies(place)
    server = place.serve([])
    name = {"name": run.name, "prefix": run.name[:12], "last": "last", "path": str(run)}[how]
    done = place.generate("--resume", name)
    assert not server.requests
    assert not server.counted
    assert (place.work / "out.scene").read_text() == (run / "best.scene").read_text()
    assert "$0.0053" in done.err, "what it cost at first"


def test_runs_in_another_folder(place: Place) -> None:
    place.serve(answers(cubes(2)))
    place.generate("two cubes", "--runs", "mine", "-o", "out.scene")
    assert not place.runs.exists()
    (place.work / "out.scene").unlink()
    place.generate("--resume", "last", "--runs", "mine")
    assert (place.work / "out.scene").exists()
    assert place.run("generate", "--resume", "last").code == 1


def test_last_is_the_last_one_and_a_prefix_of_two_is_none(place: Place) -> None:
    place.serve(answers(cubes(1), cubes(2)))
    place.generate("first", "-o", "1.scene")
    place.generate("second", "-o", "2.scene")
    (place.work / "1.scene").unlink()
    (place.work / "2.scene").unlink()
    place.generate("--resume", "last")
    assert (place.work / "2.scene").exists()
    assert not (place.work / "1.scene").exists()
    done = place.run("generate", "--resume", "2")
    assert done.code == 1
    assert "-first, " in done.err
    done = place.run("generate", "--resume", "nothing")
    assert done.code == 1
    assert "unknown run `nothing`" in done.err


DAMAGED = {
    "cut": lambda text: text[: len(text) // 2],
    "no object": lambda text: "[]",
    "nested": lambda text: "[" * 100_000,
    "version": lambda text: text.replace('"version": 1', '"version": 99'),
    "empty": lambda text: "",
    "kind": lambda text: text.replace('"3d"', '"5d"'),
    "no text": lambda text: text.replace('"text": "two cubes"', '"text": null'),
    "limits": lambda text: text.replace('"steps"', '"leaps"'),
    "setting": lambda text: text.replace('"samples"', '"simples"'),
    "samples": lambda text: text.replace('"samples": 1', '"samples": "many"'),
    "steps": lambda text: re.sub(r'"steps": \d+', '"steps": "many"', text),
    "seed": lambda text: text.replace('"seed": 0', '"seed": []'),
    "program": lambda text: text.replace('"program": null', '"program": 3'),
    "picture": lambda text: text.replace('"pictures": []', '"pictures": ["image/png"]'),
    "task": lambda text: text.replace('"task"', '"tusk"'),
}


@pytest.mark.parametrize("damage", DAMAGED)
@pytest.mark.sampled(3)
def test_a_damaged_run_is_told(finished: tuple[Place, Path], damage: str) -> None:
    place, run = finished
    path = run / "run.json"
    text = path.read_text()
    path.write_text(DAMAGED[damage](text))
    assert path.read_text() != text, "there is something to damage"
    server = place.serve([])
    done = place.run("generate", "--resume", run.name)
    assert done.code == 1, done.err
    assert done.err.startswith("error["), done.err
    assert not server.requests


def test_an_answer_that_is_damaged_is_asked_anew(finished: tuple[Place, Path]) -> None:
    place, run = finished
    forget_replies(place)
    reply = run / "sample-1" / "01-draft" / "reply.json"
    whole = reply.read_text()
    wrong = ('"cost": "much"', '"cost": NaN', '"cost": -5.0', '"cost": {}')
    damaged = [whole[:40], '{"key": 3}', "[" * 100_000, "[]", *(re.sub(r'"cost": [\d.e-]+', x, whole) for x in wrong)]
    for number, text in enumerate(damaged, 3):
        assert text != whole
        reply.write_text(text)
        server = place.serve(answers(cubes(number)))
        place.generate("--resume", run.name, "-q")
        assert len(server.requests) == 1, text[:60]
        assert json.loads(place.run("count", "out.scene", "--json").out)["cube"] == number
        forget_replies(place)


def test_a_run_is_of_one_command(finished: tuple[Place, Path]) -> None:
    place, run = finished
    path = run / "run.json"
    path.write_text(path.read_text().replace('"generate"', '"edit"'))
    done = place.run("generate", "--resume", run.name)
    assert done.code == 2
    assert f"scenelang edit --resume {run.name}" in done.err


def test_a_batch_under_way_is_waited_for(place: Place) -> None:
    """A run that was killed after its batch was sent asks for the answers of that batch, and sends no other."""
    server = place.serve(answers(cubes(2)))
    place.generate("cubes", "--batch", "-o", "out.scene")
    run = place.run_folder()
    reply = run / "sample-1" / "01-draft" / "reply.json"
    key = json.loads(reply.read_text())["key"]
    reply.unlink()
    facts = json.loads((run / "run.json").read_text())
    facts |= {
        "state": "running",
        "batch": {"id": "msgbatch_0", "reserved": {"sample-1-1": 0.1}, "keys": {"sample-1-1": key}},
    }
    (run / "run.json").write_text(json.dumps(facts))
    forget_replies(place)
    server.script = answers(cubes(2), cubes(5))
    place.generate("--resume", "last")
    assert list(server.batches) == ["msgbatch_0"]
    assert json.loads(place.run("count", "out.scene", "--json").out)["cube"] == 5
    (run / "run.json").write_text(
        json.dumps(facts | {"batch": {"id": 3, "reserved": 0.1, "keys": {"sample-1-1": key}}})
    )
    reply.unlink()
    forget_replies(place)
    done = place.run("generate", "--resume", "last")
    assert done.code == 1
    assert "cannot read its batch" in done.err


def test_a_run_goes_on_with_new_limits(place: Place) -> None:
    """One that had too little money, too few tries or no output gets more of them."""
    server = place.serve([Said("nothing"), Said("nothing"), Said(cubes(2))])
    done = place.run("generate", "two cubes", "--max-cost", "0.0001")
    assert (done.code, "of --max-cost remains" in done.err) == (1, True)
    done = place.run("generate", "--resume", "last", "--max-cost", "2", "--repair", "1")
    assert (done.code, len(server.requests)) == (1, 2)
    done = place.run("generate", "--resume", "last", "--repair", "2", "-o", "two.scene")
    assert done.code == 0, done.err
    assert len(server.requests) == 3
    assert json.loads(place.run("count", "two.scene", "--json").out)["cube"] == 2
    assert json.loads((place.run_folder() / "run.json").read_text())["settings"]["max_cost"] == 2


@pytest.mark.parametrize(
    "words", [("another task",), ("--image", "x.png"), ("--animate",), ("--model", "claude-haiku-5-5"), ("--dry-run",)]
)
def test_what_a_run_is_about_does_not_change(finished: tuple[Place, Path], words: tuple[str, ...]) -> None:
    place, _ = finished
    done = place.run("generate", *words, "--resume", "last")
    assert (done.code, "cannot be changed for a resumed run" in done.err) == (2, True), done.err


def test_a_run_from_elsewhere_is_not_gone_on_with(finished: tuple[Place, Path]) -> None:
    place, run = finished
    copy = place.work / "got"
    copytree(run, copy)
    facts = json.loads((copy / "run.json").read_text())
    victim = place.work / "mine.scene"
    victim.write_text("mine")
    (copy / "run.json").write_text(json.dumps(facts | {"output": str(victim)}))
    done = place.run("generate", "--resume", str(copy))
    assert (done.code, "is outside the folder of runs" in done.err) == (2, True)
    assert victim.read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "value"),
    [("samples", -1), ("samples", 1_000_000), ("repairs", -5), ("side_by_side", 0), ("max_tokens", -1)],
)
def test_settings_out_of_bounds_are_damage(finished: tuple[Place, Path], name: str, value: int) -> None:
    place, run = finished
    facts = json.loads((run / "run.json").read_text())
    facts["settings"][name] = value
    (run / "run.json").write_text(json.dumps(facts))
    done = place.run("generate", "--resume", "last")
    assert (done.code, f"`{name}` is {value}" in done.err) == (1, True), done.err
