"""`scenelang eval` with small models in the places of the real ones."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from small_models import seeded
from support import interruptible, wait_until

from scenelang.backends.neural.metrics import read_film
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError

CANS = """; task: three red cans
(bind "can" (lambda () (call "cylinder" :color [.8 .1 .1])))
(bind "cans" (lambda () (union-loop 3 (lambda (i) (transform (call "can") (translate (list (* 3 i) 0 0)))))))
"""
MOAI = '; A stone head.\n(bind "moai" (lambda () (call "cube" :scale [1 2 1] :color [.3 .3 .3])))'
BALL = """; task: a ball that moves
(bind "ball" (lambda (:x) (transform (call "sphere" :radius .3) (translate (list x 0 0)))))
(bind "way" (lambda () (frames (for/list ((i (iota 4))) (call "ball" :x i)))))
(scene "way")
"""
QUICK = ("--size", "64x64", "--clip-views", "4", "--lpips-views", "3", "--fps", "8", "--device", "cpu", "--offline")


@pytest.fixture
def place(tmp_path: Path, models: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    seeded()
    monkeypatch.setenv("SCENELANG_MODELS", str(models))
    monkeypatch.chdir(tmp_path)
    for name, text in (("cans", CANS), ("moai", MOAI), ("ball", BALL)):
        (tmp_path / f"{name}.scene").write_text(text, "utf-8")
    Image.fromarray(np.random.default_rng(1).integers(0, 256, (50, 70, 3), np.uint8)).save("wanted.png")
    return tmp_path


@pytest.fixture
def said(place: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    def run(*words: str, code: int = 0) -> Any:
        capsys.readouterr()
        assert main(["eval", *words, *QUICK, "--json"]) == code
        return json.loads(capsys.readouterr().out)

    return run


def values(found: Any) -> dict[tuple[str, str], dict[str, Any]]:
    return {(record["place"], record["metric"]): record["values"] for record in found["records"]}


def listed(place: Path, *entries: dict[str, Any]) -> str:
    (place / "list.json").write_text(json.dumps(entries))
    return "list.json"


# --- metrics ---------------------------------------------------------------------------------------------------------


def test_every_metric_of_what_it_is_for(said: Callable[..., Any], place: Path, models: Path) -> None:
    from support import evaluate

    from scenelang.backends.neural.metrics import ClipScore, render_shots, turntable_shots
    from scenelang.backends.neural.weights import ModelHub
    from scenelang.backends.pictures.film import PictureOptions

    entries = [{"scene": "cans.scene"}, {"scene": "moai.scene", "image": "wanted.png"}, {"scene": "ball.scene"}]
    found = said(listed(place, *entries))
    kept = values(found)
    assert list(kept) == [
        ("cans.scene", "clip"), ("cans.scene", "count"), ("moai.scene", "clip"), ("moai.scene", "lpips"),
        ("ball.scene", "clip"), ("ball.scene", "dynamic"),
    ]  # fmt: skip
    assert kept["cans.scene", "count"] == {
        "value": 1.0, "things": [{"asked": "red can", "count": 3, "words": ["can"], "found": 3}]
    }  # fmt: skip
    assert [record["group"] for record in found["records"]] == ["numeric"] * 2 + ["generic"] * 2 + ["4d"] * 2
    assert [record["prompt"] for record in found["records"]][::2] == [
        "three red cans",
        "A stone head",
        "a ball that moves",
    ]
    scene, options = evaluate(CANS), PictureOptions(width=64, height=64, labels=False)
    pictures = render_shots(scene, turntable_shots(scene, 4, 64, 64), options, "draft")
    expected = ClipScore(hub=ModelHub(models, False)).cosines("three red cans", pictures)
    assert kept["cans.scene", "clip"]["views"] == pytest.approx(expected, abs=1e-6)
    assert kept["cans.scene", "clip"]["value"] == pytest.approx(np.mean(expected))
    assert len(kept["moai.scene", "lpips"]["views"]) == 3
    assert set(kept["ball.scene", "dynamic"]) == {"value", "pixels", "is_dynamic"}
    assert [table["name"] for table in found["tables"]] == ["text", "4d", "image"]
    assert found["left_out"] == []


@pytest.mark.slow
def test_backends_side_by_side(said: Callable[..., Any], place: Path) -> None:
    found = said("moai.scene", "--metric", "clip", "--backend", "draft,splats", "--clip-views", "2")
    (table,) = found["tables"]
    assert [row["method"] for row in table["rows"]] == ["GraphDreamer", "MVDream", "Ours", "draft", "splats"]
    one, two = (record["values"]["views"] for record in found["records"])
    assert one != two


@pytest.mark.slow
def test_films_of_others(said: Callable[..., Any], place: Path) -> None:
    rows = np.random.default_rng(2).integers(0, 256, (5, 48, 64, 3), np.uint8)
    first, *rest = (Image.fromarray(row) for row in rows)
    first.save("theirs.webp", save_all=True, append_images=rest, lossless=True)
    assert np.array_equal(read_film("theirs.webp"), rows)
    entries = [
        {"film": "theirs.webp", "prompt": "a ball", "method": "4D-fy", "image": "wanted.png", "dynamic": True},
        {"film": "wanted.png", "prompt": "2 balls", "method": "Theirs"},
    ]
    kept = values(said(listed(place, *entries)))
    assert list(kept) == [("theirs.webp", m) for m in ("clip", "lpips", "dynamic")] + [("wanted.png", "clip")]
    assert [len(kept["theirs.webp", name]["views"]) for name in ("clip", "lpips")] == [4, 3]
    (place / "a.txt").write_text("x")
    with pytest.raises(SceneError, match=r"a\.txt is not a video"):
        read_film("a.txt")
    for name in ("a.gif", "a.mp4"):
        (place / name).write_text("x")
        with pytest.raises(SceneError, match=f"cannot read {name} as a video"):
            read_film(name)


def test_a_film_for_programs_that_moves(said: Callable[..., Any], place: Path) -> None:
    av = pytest.importorskip("av")
    assert av
    assert main(["render", "ball.scene", "-o", "ball.mp4", "--size", "64x64", "-q"]) == 0
    assert [picture.shape for picture in read_film("ball.mp4")] == [(64, 64, 3)] * 4


# --- results ---------------------------------------------------------------------------------------------------------


def test_it_goes_on(said: Callable[..., Any], place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = said("cans.scene", "-o", "out")
    before = (place / "out" / "results.json").read_bytes()
    monkeypatch.setenv("SCENELANG_MODELS", str(place / "out"))  # no model is here
    assert said("cans.scene", "-o", "out") == first
    assert (place / "out" / "results.json").read_bytes() == before
    both = said("cans.scene", "moai.scene", "-o", "out", code=1)
    assert both["records"] == first["records"]
    assert both["left_out"] == ["clip"]


def test_a_kill_loses_nothing(place: Path) -> None:
    """Killed without warning in the middle of many; what was there then is there, and whole."""
    for n in range(300):
        (place / f"s{n}.scene").write_text(CANS)
    names = [f"s{n}.scene" for n in range(300)]
    command = [sys.executable, "-m", "scenelang", "eval", *names, "--metric", "count", "-o", "out", "-q"]
    results = place / "out" / "results.json"
    with interruptible(command, place) as running:
        wait_until(lambda: results.exists() or running.poll() is not None)
        running.send_signal(signal.SIGKILL)
        running.wait()
    kept = json.loads(results.read_text())["records"]
    assert 0 < len(kept) < 300
    assert main(["eval", *names[: len(kept) + 5], "--metric", "count", "-o", "out", "-q", "--json"]) == 0
    after = json.loads(results.read_text())["records"]
    assert after[: len(kept)] == kept
    assert len(after) == len(kept) + 5


def test_foreign_results_are_told(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (place / "out").mkdir()
    (place / "out" / "results.json").write_text("{}")
    assert main(["eval", "cans.scene", "-o", "out", *QUICK]) == 1
    assert "E701" in capsys.readouterr().err
    assert (place / "out" / "results.json").read_text() == "{}"


# --- what is missing or wrong ----------------------------------------------------------------------------------------


def test_a_metric_without_weights_is_left_out(
    place: Path, models: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (place / "few").mkdir()
    (place / "few" / "alexnet").symlink_to(models / "alexnet")
    monkeypatch.setenv("SCENELANG_MODELS", str(place / "few"))
    monkeypatch.setenv("TORCH_HOME", str(place))
    entries = listed(place, *({"scene": f"{name}.scene", "image": "wanted.png"} for name in ("cans", "moai", "ball")))
    assert main(["eval", entries, *QUICK]) == 1
    out, err = capsys.readouterr()
    lines = [line for line in err.splitlines() if "error" in line]
    assert len(lines) == 2, "one line for each metric, however many scenes"
    assert all("E707" in line for line in lines)
    assert ["`clip` is skipped" in lines[0], "`dynamic` is skipped" in lines[1]] == [True, True]
    assert "LPIPS" in out
    assert "Count" in out


def test_a_wrong_program_stops_no_other(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (place / "broken.scene").write_text('(bind "a" (lambda () (call "cube" :scale (car 3))))')
    (place / "empty.scene").write_text('; task: a cube\n(bind "a" (lambda () (union)))')
    files = ("broken.scene", "none.scene", "empty.scene", "cans.scene")
    assert main(["eval", *files, *QUICK]) == 1
    out, err = capsys.readouterr()
    assert "E701" in err
    assert "empty.scene: " in err
    assert "draft" in out


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 2, "expected programs"),
        (["cans.scene", "--metric", "clop"], 2, "clip"),
        (["cans.scene", "--backend", "nothing"], 2, "nothing"),
        (["cans.scene", "--backend", "gltf"], 2, "does not draw pictures"),
        (["cans.scene", "--clip-views", "0"], 2, "--clip-views"),
        (["cans.scene", "--study", "page.txt"], 2, ".html"),
        (["--study", "page.html"], 2, "expected programs"),
        (["cans.scene", "--study", "page.html"], 1, "has 1 methods"),
        (["none.json"], 1, "cannot read"),
        (["--study-results", "none.json"], 1, "cannot read the answers"),
        (["cans.scene", "--environment", "mars"], 2, "mars"),
    ],
)
@pytest.mark.sampled(2)
def test_mistakes(place: Path, capsys: pytest.CaptureFixture[str], words: list[str], code: int, text: str) -> None:
    assert main(["eval", *words, "--size", "32x32"]) == code
    assert text in capsys.readouterr().err


# --- the study -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_study_from_scenes_and_films(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    entries = listed(
        place,
        {"scene": "cans.scene", "method": "Ours"},
        {"film": "wanted.png", "prompt": "three red cans", "method": "Noise"},
        {"scene": "ball.scene", "method": "Ours"},
        {"film": "wanted.png", "prompt": "a ball that moves", "method": "Noise"},
    )
    assert main(["eval", entries, "--study", "study.html", "--size", "32x32"]) == 0
    assert "wrote study.html" in capsys.readouterr().out
    text = (place / "study.html").read_text("utf-8")
    assert text.count("data:image/webp;base64,") == 2
    assert text.count("data:image/png;base64,") == 2


def test_what_people_said(said: Callable[..., Any], place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number, choice in enumerate(["draft", "draft", "Noise", "draft"]):
        answer = {"prompt": "three red cans", "methods": ["Noise", "draft"], "choice": choice}
        told = {"format": "scenelang-study-answers", "version": 1, "study": "s", "participant": str(number)}
        (place / f"{number}.json").write_text(json.dumps(told | {"answers": [answer]}))
    files = [f"{number}.json" for number in range(4)]
    assert main(["eval", "--study-results", *files]) == 0
    out = capsys.readouterr().out
    assert [line.split() for line in out.splitlines()] == [
        ["preferred,", "%", "Noise", "draft"], ["three", "red", "cans", "25.00", "75.00"],
        ["all", "25.00", "±", "0.00", "75.00", "±", "0.00"], ["4", "participants"],
    ]  # fmt: skip
    (table,) = said("cans.scene", "--metric", "count", "--study-results", *files)["tables"]
    cells = {row["method"]: row["cells"] for row in table["rows"] if not row["paper"]}
    assert cells["draft"][0]["value"] == 75.0
    assert cells["draft"][2]["value"] == 1.0
    assert cells["Noise"][0]["value"] == 25.0
