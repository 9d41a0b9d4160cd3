"""`scenelang edit`: the program that is sent, what comes back, what the edit did, and where it is written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from sampling import only

from models.conftest import GOLDEN, RESPONSES, Place, recorded, system, texts
from models.server import Said
from scenelang.inference import generation
from scenelang.session.scene_changes import changes_between, compared_frames, compared_frames_in
from scenelang.session.session import Session

pytestmark = pytest.mark.usefixtures("untried")

TOWER = """; a tower

(param floors 3)

(bind "tower"
  (lambda ()
    (union-loop floors
      (lambda (i)
        (transform (call "cube" :color [.2 .3 .8])   ; a floor
                   (translate [0 (+ i .5) 0]))))))
"""
TALLER = TOWER.replace("floors 3", "floors 5").replace("[.2 .3 .8]", "[.8 .1 .1]")
EDITS = [("t03-bramante-staircase", "shrink staircase radius by 80%"),
         ("t04-jenga", "remove 2 blocks from second top layer and the tower should not fall"),
         ("t06-son-of-man", "move the apple to the left")]  # fmt: skip


@pytest.fixture(autouse=True)
def _small_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generation, "_IMAGE_PX", 48)


def fenced(text: str) -> Said:
    return Said(f"Here it is:\n\n```scene\n{text}```\n")


@pytest.fixture
def tower(place: Place) -> Path:
    path = place.work / "tower.scene"
    path.write_text(TOWER)
    return path


@pytest.mark.parametrize(("name", "instruction"), only(EDITS[1:2], EDITS))
def test_recorded_edits_of_python(place: Place, name: str, instruction: str) -> None:
    server = place.serve([Said(recorded(f"{name}.edit"))])
    source = RESPONSES / f"{name}.txt"
    done = place.run("edit", str(source), instruction, "-o", "edited.scene", "--picture", "both.png")
    assert done.code == 0, done.err
    (request,) = server.requests
    (turn,) = request["messages"]
    assert turn["role"] == "user"
    said = texts(turn)
    code = recorded(name).split("```python\n")[1].split("```")[0].strip()
    assert code in said
    assert instruction in said
    assert "An example" not in said
    made = place.run("generate", instruction, "--dry-run", "--json")
    assert system(request) == json.loads(made.out)["request"]["system"][0]["text"]  # the system prompt stays the same
    session = Session()
    scene = session.evaluate(session.source(str(place.work / "edited.scene"))).scene
    assert scene is not None
    expected = compared_frames_in(str(GOLDEN / f"{name}.edit.json"), 100_000)
    assert expected is not None
    assert changes_between(expected, compared_frames(scene, 100_000)).equal
    assert done.out.startswith(f"--- {name}.txt before\n+++ {name}.txt after\n@@")
    picture = np.asarray(Image.open(place.work / "both.png").convert("RGB"), np.int64)
    assert picture.shape == (48, 96, 3)
    assert np.abs(picture[:, :48] - picture[:, 48:]).max() > 30


def test_the_scene_difference_is_told_by_path(place: Place, tower: Path) -> None:
    place.serve([fenced(TALLER)])
    done = place.run("edit", "tower.scene", "make it red and five high")
    assert done.code == 0, done.err
    lines = done.out.splitlines()
    assert "-(param floors 3)" in lines
    assert "+(param floors 5)" in lines
    assert "different: 0 matched, 3 recolored, 2 added" in lines
    assert "  recolored tower[0] at [0 0.5 0]: [0.2 0.3 0.8] -> [0.8 0.1 0.1]" in lines
    assert "  added tower[4] at [0 4.5 0]" in lines
    assert tower.read_text() == TOWER
    assert "to apply the edit" in done.err


def test_apply_keeps_what_the_model_did_not_touch(place: Place, tower: Path) -> None:
    tower.chmod(0o640)
    server = place.serve([fenced(TALLER)])
    done = place.run("edit", "tower.scene", "make it red and five high", "--apply", "-q")
    assert done.code == 0, done.err
    assert tower.read_text() == TALLER  # comments and line breaks as they were
    assert tower.stat().st_mode & 0o777 == 0o640
    assert TOWER.strip() in texts(server.requests[0]["messages"][0])
    assert "You write 3D scenes in the Scene Language" in system(server.requests[0])


def test_taking_an_edit_later_costs_nothing(place: Place, tower: Path) -> None:
    server = place.serve([fenced(TALLER)])
    assert place.run("edit", "tower.scene", "higher").code == 0
    assert place.run("edit", "--resume", "last", "--apply").code == 0
    assert len(server.requests) == 1
    assert tower.read_text() == TALLER


def test_a_file_that_changed_is_not_overwritten(place: Place, tower: Path) -> None:
    place.serve([fenced(TALLER)])
    assert place.run("edit", "tower.scene", "higher").code == 0
    tower.write_text(TOWER + "; mine\n")
    done = place.run("edit", "--resume", "last", "--apply")
    assert done.code == 1
    assert "was modified since its program was sent" in done.err
    assert tower.read_text() == TOWER + "; mine\n"
    assert place.run("edit", "--resume", "last", "-o", "new.scene").code == 0
    assert (place.work / "new.scene").read_text() == TALLER


def test_an_edit_that_fails_is_mended(place: Place, tower: Path) -> None:
    server = place.serve([fenced(TALLER.replace("translate", "tranlate")), fenced(TALLER)])
    done = place.run("edit", "tower.scene", "higher", "-o", "new.scene")
    assert done.code == 0, done.err
    turns = server.requests[1]["messages"]
    assert [turn["role"] for turn in turns] == ["user", "assistant", "user"]
    assert turns[0] == server.requests[0]["messages"][0]
    assert "error[E301]" in texts(turns[2])
    assert "did you mean `translate`" in texts(turns[2])
    assert (place.work / "new.scene").read_text() == TALLER


def test_imports_of_the_program_stay(place: Place) -> None:
    (place.work / "parts.scene").write_text('(bind "leg" (lambda () (call "cube")))')
    main = '(import "parts.scene")\n(bind "table" (lambda () (call "leg")))\n'
    (place.work / "table.scene").write_text(main)
    place.serve([fenced(main.replace('(call "leg")', '(transform (call "leg") (translate [1 0 0]))'))])
    done = place.run("edit", "table.scene", "to the right", "--apply")
    assert done.code == 0, done.err
    assert "moved table/leg" in done.out


@pytest.mark.slow
def test_films_and_blocks(place: Place) -> None:
    film = '(bind "f" (lambda () (frames (for/list ((i 3)) (transform (call "cube") (translate [i 0 0]))))))\n'
    (place.work / "film.scene").write_text(film)
    server = place.serve([fenced(film.replace("[i 0 0]", "[0 i 0]")), fenced(film.replace("[i", "[(* 2 i)"))])
    done = place.run("edit", "film.scene", "let it rise")
    assert done.code == 0, done.err
    assert "  frame 2: moved f: [2 0 0] -> [0 2 0]" in done.out.splitlines()
    assert "`(frames list)`" in system(server.requests[0])
    place.run("transpile", str(RESPONSES / "n24-castle.txt"), "-o", "castle.scene", "-q")
    castle = (place.work / "castle.scene").read_text()
    server = place.serve([fenced(castle.replace("minecraft:water", "minecraft:lava"))])
    done = place.run("edit", "castle.scene", "a moat of lava")
    assert done.code == 0, done.err
    assert "minecraft:water[level=0] -> minecraft:lava[level=0]" in done.out
    assert "(rotate " not in system(server.requests[0])


def test_json(place: Place, tower: Path) -> None:
    place.serve([fenced(TALLER)])
    done = place.run("edit", "tower.scene", "higher", "--json")
    data = json.loads(done.out)
    assert (data["changes"]["extra"], data["changes"]["recolored"]) == (2, 3)
    assert "+(param floors 5)" in data["diff"]
    assert Path(data["picture"]).is_file()
    assert data["cost"] > 0


def test_dry_run_sends_nothing(place: Place, tower: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    done = place.run("edit", "tower.scene", "higher", "--dry-run")
    assert done.code == 0, done.err
    assert TOWER.strip() in done.out
    assert not place.runs.exists()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ((), 2, "expected a program and an instruction"),
        (("tower.scene", " "), 2, "expected a program and an instruction"),
        (("-", "x"), 2, "cannot edit standard input"),
        (("tower.scene", "x", "--apply", "-o", "y.scene"), 2, "--apply overwrites FILE"),
        (("tower.scene", "x", "-o", "no/y.scene"), 1, "the folder no does not exist"),
        (("tower.scene", "x", "--picture", "a.glb"), 2, "cannot write an image"),
        (("missing.scene", "x"), 1, "there is no file missing.scene"),
        (("wrong.scene", "x"), 1, "E301"),
        (("scene.json", "x"), 1, "flattened scene"),
        (("--resume", "nothing"), 1, "unknown run `nothing`"),
        (("tower.scene", "x", "-n", "0"), 2, "expected -n between 1 and 64"),
        (("tower.scene", "x", "--effort", "huge"), 2, "does not support the effort `huge`"),
        (("tower.scene", "x", "--max-tokens", "900000"), 2, "does not support answers of 900,000 tokens"),
    ],
)
def test_wrong_usage(place: Place, tower: Path, words: tuple[str, ...], code: int, said: str) -> None:
    (place.work / "wrong.scene").write_text('(bind "a" (lambda () (cal "cube")))')
    place.run("export", "tower.scene", "-o", "scene.json", "-q")
    done = place.run("edit", *words)
    assert (done.code, said in done.err) == (code, True), done.err


@pytest.mark.parametrize("ablation", ["P", "W", "PW"])
def test_ablated_edits(place: Place, tower: Path, ablation: str) -> None:
    """The model answers with what it was sent, with a cube less or another number."""

    def answer(body: dict[str, object]) -> Said:
        sent = texts(body["messages"][0])  # type: ignore[index]
        if ablation == "W":
            assert '"tower"' not in sent
            assert "a floor" not in sent
            return fenced(sent.split("```scene\n")[1].split("```")[0].replace("floors 3", "floors 2"))
        items = json.loads(sent.split("```json\n")[1].split("```")[0])
        assert [item.get("word") for item in items] == ([None] * 3 if ablation == "PW" else ["tower"] * 3)
        return Said(f"```json\n{json.dumps(items[:2])}\n```")

    place.serve(answer)
    done = place.run("edit", "tower.scene", "one floor less", "--ablate", ablation, "-o", "new.scene")
    assert done.code == 0, done.err
    assert "different: 2 matched, 1 removed" in done.out
    count = json.loads(place.run("count", "new.scene", "--json").out)
    assert count["cube"] == 2
    assert ("tower" in count) == (ablation != "PW")


@pytest.mark.parametrize("path", [".env", "other.scene", "parts/../.env", "secret/notes.txt"])
@pytest.mark.sampled(2)
def test_an_edit_imports_nothing_new(place: Place, tower: Path, path: str) -> None:
    """What the answer imports would be quoted to the model."""
    (place.work / "secret").mkdir()
    (place.work / "parts").mkdir()
    for name in (".env", "other.scene", "secret/notes.txt"):
        (place.work / name).write_text("password = hunter2 (")
    hidden = f'(define-syntax get (syntax-rules () ((_) (import "{path}"))))\n(get)\n{TOWER}'
    server = place.serve([fenced(f'(import "{path}")\n{TOWER}'), fenced(hidden), fenced(TALLER)])
    done = place.run("edit", "tower.scene", "x", "-o", "new.scene")
    assert done.code == 0, done.err
    told = texts(server.requests[1]["messages"][-1])
    assert "is not allowed for this program" in told or "is hidden" in told
    assert "hunter2" not in json.dumps(server.requests)
    assert not any("hunter2" in file.read_text() for file in place.runs.rglob("*.*") if file.suffix != ".png")


def test_what_has_another_size_is_told_as_one_thing(place: Place, tower: Path) -> None:
    place.serve([fenced(TOWER.replace('(call "cube"', '(call "cube" :scale [2 1 2]'))])
    done = place.run("edit", "tower.scene", "wider")
    assert "different: 0 matched, 3 resized" in done.out
    assert "  resized tower[1] at [0 1.5 0]" in done.out.splitlines()


def test_the_prose_of_a_response_stays(place: Place) -> None:
    prose = ["Here is a box:\n\n```python\n", "```\n\nHave fun!\n"]
    code = "@register()\ndef box():\n    return primitive_call('cube', shape_kwargs={'scale': 1})\n"
    (place.work / "box.txt").write_text(code.join(prose))
    changed = code.replace("'scale': 1", "'scale': 2")
    place.serve([Said(f"```python\n{changed}```")])
    assert place.run("edit", "box.txt", "larger", "--apply").code == 0
    assert (place.work / "box.txt").read_text() == changed.join(prose)


def test_an_edit_may_end_a_motion(place: Place) -> None:
    film = '(bind "f" (lambda () (frames (for/list ((i 3)) (transform (call "cube") (translate [i 0 0]))))))\n'
    (place.work / "film.scene").write_text(film)
    server = place.serve([fenced(film.replace("[i 0 0]", "[0 0 0]"))])
    done = place.run("edit", "film.scene", "let it stand still")
    assert (done.code, len(server.requests)) == (0, 1), done.err
