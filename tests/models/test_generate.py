"""`generate`: what is sent to the model for each way of asking, and the scene that its answer becomes."""

from __future__ import annotations

import base64
import json
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from models.conftest import GOLDEN, KEY, Place, answers, cubes, pictures, python, recorded, system, texts
from models.server import Said
from models.services import hurry
from scenelang.inference import generation

LANGUAGE = """```scene
; two balls
(bind "balls"
  (lambda () (union-loop 2 (lambda (i) (transform (call "sphere" :radius 1) (translate [(* 3 i) 1 0]))))))
```"""


def test_a_task_becomes_a_program(place: Place) -> None:
    server = place.serve(answers(recorded("t01-chessboard")))
    done = place.generate("a chessboard at game start", "-o", "chess.scene")
    (request,) = server.requests
    assert request["stream"] is True
    assert request["model"] == "claude-opus-5-5"
    assert request["max_tokens"] == 32_000
    assert request["thinking"] == {"type": "adaptive"}
    assert "output_config" not in request
    assert not {"temperature", "top_p", "top_k", "grammar"} & set(request)
    (turn,) = request["messages"]
    assert turn["role"] == "user"
    assert texts(turn).endswith("The task:\n\na chessboard at game start")
    assert "a garden bench between two flower pots" in texts(turn)
    assert "def rotation_matrix(angle: float, direction: P, point: P = (0, 0, 0)) -> T:" in system(request)
    assert "register_animation" not in system(request)
    assert not pictures(turn)
    assert "; a chessboard at game start\n" in place.work.joinpath("chess.scene").read_text()
    assert not place.differs(place.work / "chess.scene", GOLDEN / "t01-chessboard.json")
    assert done.out == "wrote chess.scene\n"
    assert "sample 1; 1,000 input tokens" in done.err


def test_the_fixed_part_is_kept_by_the_service(place: Place) -> None:
    server = place.serve(answers(cubes()))
    place.generate("a cube")
    (request,) = server.requests
    assert request["system"][-1]["cache_control"] == {"type": "ephemeral"}
    assert request["messages"][0]["content"][-1]["cache_control"] == {"type": "ephemeral"}


def test_the_key_is_sent_in_its_header_alone(place: Place) -> None:
    server = place.serve(answers(cubes()))
    place.generate("a cube")
    assert len(server.headers) == 2
    for headers in server.headers:
        assert [value.removeprefix("Bearer ") for value in headers.values() if KEY in value] == [KEY]
    assert KEY not in json.dumps([server.requests, server.counted])


def test_effort_model_and_length_are_sent(place: Place) -> None:
    server = place.serve(answers(cubes()))
    place.generate("a cube", "--model", "claude-sonnet-5-5", "--effort", "high", "--max-tokens", "5000")
    (request,) = server.requests
    assert (request["model"], request["max_tokens"]) == ("claude-sonnet-5-5", 5000)
    assert request["output_config"] == {"effort": "high"}


@pytest.mark.filterwarnings("ignore:The model:DeprecationWarning")
def test_a_model_that_takes_no_thinking_is_sent_none(place: Place) -> None:
    server = place.serve(answers(cubes()))
    place.generate("a cube", "--model", "claude-sonnet-4-5")
    assert "thinking" not in server.requests[0]


def test_the_program_goes_to_standard_output(place: Place) -> None:
    place.serve(answers(cubes(3)))
    done = place.generate("three cubes", "-q")
    (place.work / "out.scene").write_text(done.out)
    assert json.loads(place.run("count", "out.scene", "--json").out)["cube"] == 3
    assert done.err == ""


# --- pictures ------------------------------------------------------------------------------------------------------


def save(path: Path, kind: str, size: tuple[int, int] = (40, 30)) -> bytes:
    Image.new("RGB", size, (200, 30, 30)).save(path, kind)
    return path.read_bytes()


@pytest.mark.parametrize(("name", "kind", "media"), [("a.png", "PNG", "image/png"), ("a.jpg", "JPEG", "image/jpeg")])
def test_a_picture_is_sent_as_it_is(place: Place, name: str, kind: str, media: str) -> None:
    data = save(place.work / name, kind)
    server = place.serve(answers(cubes()))
    place.generate("--image", name, "-o", "out.scene")
    (turn,) = server.requests[0]["messages"]
    assert turn["content"][0]["type"] == "image", "pictures stand before the text"
    (sent,) = pictures(turn)
    assert (sent["media_type"], base64.b64decode(sent["data"])) == (media, data)
    assert texts(turn).endswith("The task:\n\nReconstruct the input scene.")


def test_several_pictures_and_words(place: Place) -> None:
    one, two = save(place.work / "1.png", "PNG"), save(place.work / "2.png", "PNG", (10, 10))
    server = place.serve(answers(cubes()))
    place.generate("Only the cube.", "--image", "1.png", "--image", "2.png")
    (turn,) = server.requests[0]["messages"]
    assert [base64.b64decode(sent["data"]) for sent in pictures(turn)] == [one, two]
    assert texts(turn).endswith("Reconstruct the input scene. Only the cube.")


def test_a_picture_that_is_too_large_or_of_another_format_is_made_smaller(place: Place) -> None:
    save(place.work / "large.jpg", "JPEG", (4000, 1000))
    save(place.work / "old.bmp", "BMP")
    server = place.serve(answers(cubes()))
    place.generate("--image", "large.jpg", "--image", "old.bmp")
    large, old = pictures(server.requests[0]["messages"][0])
    assert large["media_type"] == old["media_type"] == "image/jpeg"
    with Image.open(BytesIO(base64.b64decode(large["data"]))) as image:
        assert image.size == (1568, 392)


@pytest.mark.slow
def test_photos_come_upright_on_white_and_small(place: Place) -> None:
    photo = Image.new("RGB", (2000, 1000), "red")
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was held upright
    photo.save(place.work / "photo.jpg", exif=exif)
    Image.new("RGB", (300, 100), "red").save(place.work / "small.jpg", exif=exif)
    Image.new("RGBA", (3000, 10), (0, 0, 0, 0)).save(place.work / "clear.png")
    noise = np.random.default_rng(0).integers(0, 255, (1500, 1500, 3), np.uint8)
    Image.fromarray(noise).save(place.work / "noise.png")
    server = place.serve(answers(cubes()))
    names = ("photo.jpg", "small.jpg", "clear.png", "noise.png")
    place.generate(*(word for name in names for word in ("--image", name)))
    sent = [base64.b64decode(picture["data"]) for picture in pictures(server.requests[0]["messages"][0])]
    found = [Image.open(BytesIO(data)) for data in sent]
    assert [image.size for image in found[:2]] == [(784, 1568), (100, 300)]
    assert np.asarray(found[2].convert("L")).min() > 250
    assert all(len(data) < 3_500_000 for data in sent)


def test_files_that_are_no_pictures_are_not_sent(place: Place) -> None:
    server = place.serve([])
    (place.work / "text.png").write_text("no picture")
    whole = save(place.work / "whole.png", "PNG", (300, 300))
    (place.work / "cut.png").write_bytes(whole[: len(whole) // 2])
    (place.work / "huge.png").write_bytes(_png_that_claims(60_000))
    (place.work / "folder.png").mkdir()
    (place.work / "empty.png").touch()
    (place.work / "drawing.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"/>')
    (place.work / "post.eps").write_text("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n(x) print\n")
    names = ("text.png", "cut.png", "huge.png", "folder.png", "empty.png", "drawing.svg", "post.eps", "missing.png")
    for name in names:
        done = place.run("generate", "a", "--image", name)
        assert done.code == 1, name
        assert f"cannot read the image {name}" in done.err, done.err
        assert done.err.count("\n") <= 2, done.err
    assert not server.requests
    assert not place.runs.exists()


def _png_that_claims(side: int) -> bytes:
    import struct
    import zlib

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


# --- kinds and notations -------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_animate(place: Place) -> None:
    server = place.serve(answers(recorded("n13-carousel")))
    place.generate("a carousel", "--animate", "-o", "out.scene")
    (request,) = server.requests
    assert "def register_animation(" in system(request)
    assert "lighthouse_at_work" in texts(request["messages"][0])
    facts = json.loads(place.run("flatten", "out.scene", "--json", "-q").out)
    assert len(facts["frames"]) > 1


@pytest.mark.slow
def test_animate_asks_again_for_what_stands_still(place: Place) -> None:
    server = place.serve(answers(cubes(), recorded("n16-newtons-cradle")))
    place.generate("a cradle", "--animate", "-o", "out.scene")
    assert "the scene is not animated: it has only one frame" in texts(server.requests[1]["messages"][-1])
    assert not place.differs(place.work / "out.scene", GOLDEN / "n16-newtons-cradle.json")


def test_minecraft(place: Place) -> None:
    server = place.serve(answers(cubes(), recorded("n24-castle")))
    place.generate("a castle", "--minecraft", "-o", "out.scene")
    first, second = server.requests
    assert "rotation_matrix" not in system(first)
    assert "reflection_matrix" not in system(first)
    assert "'set_cuboid'" in system(first)
    assert "'sphere'" not in system(first)
    assert "a small stone bridge" in texts(first["messages"][0])
    assert "the scene has no blocks" in texts(second["messages"][-1])
    assert not place.differs(place.work / "out.scene", GOLDEN / "n24-castle.json")


def test_dsl(place: Place) -> None:
    server = place.serve(answers(LANGUAGE))
    place.generate("two balls", "--dsl", "-o", "out.scene")
    (request,) = server.requests
    assert "Scene Language, a Lisp" in system(request)
    assert '(bind "bench"' in texts(request["messages"][0])
    assert "def " not in texts(request["messages"][0])
    assert json.loads(place.run("count", "out.scene", "--json").out)["sphere"] == 2
    assert (place.work / "out.scene").read_text().startswith("; two balls\n")


def test_a_scene_without_primitives_goes_back(place: Place) -> None:
    empty = python("@register()\ndef nothing() -> Shape:\n    return concat_shapes()")
    server = place.serve(answers(empty, cubes()))
    place.generate("a cube")
    assert "the scene has no primitives" in texts(server.requests[1]["messages"][-1])


# --- what is printed and drawn -------------------------------------------------------------------------------------


def test_render_draws_beside_the_program(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generation, "_DRAFT_PX", 64)
    place.serve(answers(cubes()))
    place.generate("a cube", "-o", "out.scene", "--render")
    with Image.open(place.work / "out.png") as image:
        assert image.size == (64, 64)
        assert len(set(image.convert("RGB").tobytes())) > 4


def test_render_of_a_film_is_a_gif(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generation, "_DRAFT_PX", 64)
    film = python("""
@register()
def ball(x: float) -> Shape:
    return transform_shape(primitive_call("sphere", shape_kwargs={"radius": 1}), translation_matrix((x, 1, 0)))

@register_animation()
def rolling():
    for i in range(3):
        yield library_call("ball", x=i)
""")
    place.serve(answers(film))
    place.generate("a ball", "--animate", "-o", "out.scene", "--render")
    with Image.open(place.work / "out.gif") as image:
        assert image.n_frames == 3


def test_json(place: Place) -> None:
    place.serve(answers(cubes(2)))
    done = place.generate("two cubes", "--json", "-o", "out.scene")
    facts = json.loads(done.out)
    assert facts["program"] == (place.work / "out.scene").read_text()
    assert facts["sample"] == 1
    assert facts["tokens"]["sent"] == 1000
    assert facts["cost"] == pytest.approx((1000 * 4 + facts["tokens"]["answered"] * 20) / 1e6)
    assert Path(facts["run"]) == place.run_folder()
    assert done.err == ""


def test_the_run_is_kept(place: Place) -> None:
    place.serve(answers(cubes()))
    place.generate("A cube, please!", "-o", "out.scene")
    run = place.run_folder()
    assert run.name.endswith("-a-cube-please")
    attempt = run / "sample-1" / "01-draft"
    assert (attempt / "answer.txt").read_text() == cubes()
    assert (attempt / "program.scene").read_text() == (place.work / "out.scene").read_text()
    assert json.loads((attempt / "request.json").read_text())["model"] == "claude-opus-5-5"
    assert json.loads((run / "run.json").read_text())["state"] == "done"
    assert (run / "best.scene").read_text() == (place.work / "out.scene").read_text()
    assert run.stat().st_mode & 0o077 == 0


# --- dry runs ------------------------------------------------------------------------------------------------------


def test_dry_run_prints_what_would_be_sent(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    save(place.work / "a.png", "PNG")
    words = ("a cube", "--image", "a.png", "--effort", "low")
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    dry = json.loads(place.generate(*words, "--dry-run", "--json").out)
    shown = place.generate(*words, "--dry-run").out
    assert not place.runs.exists()
    monkeypatch.setenv("ANTHROPIC_API_KEY", KEY)
    server = place.serve(answers(cubes()))
    place.generate(*words)
    sent = {name: value for name, value in server.requests[0].items() if name != "stream"}
    assert dry["request"] == sent
    assert system(sent) in shown
    assert texts(sent["messages"][0]) in shown
    assert "[image, " in shown
    assert 'output_config: {"effort": "low"}' in shown
    assert dry["tokens"] >= len(json.dumps(sent)) / 4
    assert dry["cost"] > 0


# --- prompts of the user's -----------------------------------------------------------------------------------------


def test_a_prompt_is_replaced_by_a_file(place: Place) -> None:
    (place.work / "mine").mkdir()
    (place.work / "mine" / "user.text.md").write_text("MAKE {{task}} NOW {{example}}")
    server = place.serve(answers(cubes()))
    place.generate("a cube", "--prompt-dir", "mine")
    assert texts(server.requests[0]["messages"][0]).startswith("MAKE a cube NOW An example")


def test_prompts_that_cannot_be_filled(place: Place) -> None:
    server = place.serve([])
    (place.work / "mine").mkdir()
    (place.work / "mine" / "user.text.md").write_text("{{tusk}}")
    done = place.run("generate", "a cube", "--prompt-dir", "mine")
    assert done.code == 1
    assert "{{tusk}}" in done.err
    assert "task" in done.err
    (place.work / "mine" / "user.text.md").rename(place.work / "mine" / "user.txet.md")
    done = place.run("generate", "a cube", "--prompt-dir", "mine")
    assert done.code == 1
    assert "unknown prompt template" in done.err
    assert "user.text.md" in done.err
    done = place.run("generate", "a cube", "--prompt-dir", "nowhere")
    assert done.code == 1
    assert "--prompt-dir: not a folder: nowhere" in done.err
    assert not server.requests


# --- wrong usage ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "expected a text prompt, or an image with --image"),
        (["  "], "expected a text prompt, or an image with --image"),
        (["a", "--animate", "--minecraft"], "not allowed with"),
        (["a", "--render"], "requires -o"),
        (["a", "--dsl", "--ablate", "P"], "cannot be combined with --ablate P"),
        (["a", "-n", "0"], "expected -n between 1 and 64"),
        (["a", "--repair", "99"], "expected --repair between 0 and 20"),
        (["a", "--critique", "-1"], "usage: see `scenelang generate --help`"),
        (["a", "--max-cost", "free"], "expected a positive amount of dollars"),
        (["a", "--max-cost", "nan"], "expected a positive amount of dollars"),
        (["a", "--provider", "antropic"], "unknown provider `antropic` (available"),
        (["a", "--effort", "enormous"], "does not support the effort `enormous`"),
        (["a", "--model", "claude-haiku-4-5", "--effort", "low"], "omit --effort"),
        (["a", "--max-tokens", "9000000"], "does not support answers of 9,000,000 tokens"),
        (["a", "--ablate", "Q"], "`P`, `W` or `PW`"),
        (["x" * 100_001], "100,000 characters"),
    ],
)  # fmt: skip
def test_wrong_usage(place: Place, words: list[str], said: str) -> None:
    server = place.serve([])
    done = place.run("generate", *words)
    assert done.code == 2, done.err
    assert said in done.err
    assert not server.requests
    assert not place.runs.exists()


def test_what_cannot_be_asked(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    server = place.serve([])
    done = place.run("generate", "a", "--model", "claude-opus-9")
    assert done.code in (1, 2)
    assert "unknown model `claude-opus-9`" in done.err
    done = place.run("generate", "a", "-o", "nowhere/out.scene")
    assert done.code in (1, 2)
    assert "nowhere" in done.err
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    done = place.run("generate", "a")
    assert done.code == 1
    assert "no API key for `anthropic`" in done.err
    assert not server.requests
    assert not server.counted
    assert not place.runs.exists()


def test_a_machine_that_is_offline_says_so_in_one_line(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    hurry(monkeypatch)
    done = place.run("generate", "a cube")
    assert done.code == 1
    assert "cannot reach http://127.0.0.1:9" in done.err
    assert "--dry-run" in done.err


def test_errors_of_the_service(place: Place) -> None:
    for status, said in ((400, "rejected the request"), (401, "rejected the API key")):
        server = place.serve([Said("never", status=status)])
        done = place.run("generate", f"a cube {status}", "-o", "out.scene")
        assert done.code == 1
        assert said in done.err
        assert f"({status})" in done.err
        assert len(server.requests) == 1
    assert not (place.work / "out.scene").exists()


@pytest.mark.slow
def test_parts_are_learned_from_the_pictures(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    """`--invert`, once the program is written: with its scene and what the model saw, also when the run goes on."""
    data = save(place.work / "a.png", "PNG")
    calls: list[tuple[str, list[bytes], Path, bool]] = []

    def note(arguments: Any, scene: Any, shown: Any, program: Path) -> None:
        calls.append((scene.word, [each.data for each in shown], program, program.exists()))

    monkeypatch.setattr("scenelang.cli.neural.invert_generated", note)
    place.serve(answers(cubes(), cubes()))
    place.generate("--image", "a.png", "-o", "out.scene")
    assert calls == []
    place.generate("--image", "a.png", "-o", "out.scene", "--invert", "--no-cache")
    assert calls == [("pile", [data], Path("out.scene"), True)]
    place.generate("--resume", "last")
    assert calls[1] == ("pile", [data], place.work / "out.scene", True)
