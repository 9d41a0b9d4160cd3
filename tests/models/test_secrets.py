"""The key is nowhere but in the header of requests, also where a service says it back."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import pytest
from PIL import Image

from models.conftest import KEY, Done, Place, answers, cubes
from models.server import Said
from models.services import hurry

pytestmark = pytest.mark.usefixtures("untried")

ECHO = cubes(2).replace("a test", f"a test for {KEY}")


def nowhere(place: Place, *done: Done) -> None:
    """The key is in no file but the configuration, and in nothing that was printed."""
    looked_at = 0
    for path in place.folder.rglob("*"):
        assert KEY.lower() not in path.name.lower()
        if path.is_file() and path.name != "config.toml":
            looked_at += 1
            assert KEY.encode() not in path.read_bytes(), path
    assert looked_at
    for each in done:
        assert KEY not in each.out
        assert KEY not in each.err


def script(*said: Said) -> list[Said]:
    return list(said)


RUNS: dict[str, tuple[list[Said], list[str]]] = {
    "answer": (script(Said(ECHO)), ["cubes", "-o", "out.scene"]),
    "output": (script(Said(ECHO)), ["cubes"]),
    "json": (script(Said(ECHO)), ["cubes", "--json"]),
    "word": (script(Said(cubes().replace('"cube"', f'"{KEY}"')), Said(cubes())), ["cubes", "-o", "out.scene"]),
    "mistake": (script(*[Said(f"no program: {KEY}")] * 2), ["cubes", "--repair", "1"]),
    "400": (script(Said(f"your key {KEY} is odd", status=400)), ["cubes"]),
    "401": (script(Said(f"invalid x-api-key {KEY}", status=401)), ["cubes"]),
    "401, json": (script(Said(f"invalid x-api-key {KEY}", status=401)), ["cubes", "--json"]),
    "429": (script(*[Said(f"{KEY} asks too much", status=429)] * 4), ["cubes"]),
    "529": (script(*[Said(f"{KEY} overloaded", status=529)] * 4), ["cubes"]),
    "refusal": (
        script(Said("", stop="refusal", details={"type": "refusal", "category": "x", "explanation": KEY})),
        ["cubes"],
    ),
    "broken": (script(*[Said(ECHO, breaks_after=192)] * 3), ["cubes", "--max-cost", "50"]),
    "pause": (script(Said(KEY + " ", stop="pause_turn"), Said(cubes())), ["cubes", "-o", "out.scene"]),
    "task": (script(Said(cubes())), [f"the key {KEY}", "-o", "out.scene"]),
    "samples": (script(Said(ECHO), Said(ECHO), Said(f"BEST: 2 {KEY}")), ["cubes", "-n", "2", "--critique", "0", "-o", "out.scene"]),
    "batch": (script(Said(ECHO)), ["cubes", "--batch", "-o", "out.scene"]),
    "failed batch": (script(Said(f"no {KEY}", status=400)), ["cubes", "--batch"]),
    "critique": (script(Said(ECHO), Said(ECHO)), ["cubes", "--critique", "1", "-o", "out.scene"]),
    "language": (script(Said(f'```scene\n; {KEY}\n(bind "a" (lambda () (call "cube" "{KEY}")))\n```')), ["c", "--dsl", "-o", "out.scene"]),
}  # fmt: skip


@pytest.mark.usefixtures("small_pictures")
@pytest.mark.parametrize("name", RUNS)
@pytest.mark.sampled(2)
def test_what_a_service_says_back(place: Place, name: str) -> None:
    said, words = RUNS[name]
    server = place.serve(said)
    done = [place.run("generate", *words)]
    assert server.requests
    if place.runs.exists():
        done.append(place.run("runs"))
        done.append(place.run("generate", "--resume", "last"))
    nowhere(place, *done)


def test_a_model_that_is_called_like_the_key(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    from models import server as module

    message = module.message

    def named(said: Said, body: dict[str, Any]) -> dict[str, Any]:
        return message(said, body) | {"model": KEY}

    monkeypatch.setattr(module, "message", named)
    place.serve(answers(cubes()))
    nowhere(place, place.run("generate", "a cube", "-o", "out.scene"))


def test_dry_runs_and_other_commands(place: Place) -> None:
    Image.new("RGB", (8, 8)).save(place.work / "a.png")
    dry = place.run("generate", "a cube", "--image", "a.png", "--dry-run")
    place.serve(answers(cubes(), ECHO))
    made = place.run("generate", "a cube", "-o", "out.scene")
    nowhere(place, dry, made, place.run("runs"), place.run("edit", "out.scene", "two cubes"))


def test_a_key_in_the_address_and_the_configuration(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    hurry(monkeypatch)
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    folder = place.folder / "config" / "scenelang"
    folder.mkdir()
    (folder / "config.toml").write_text(f'[anthropic]\napi_key = "{KEY}"\n')
    (folder / "config.toml").chmod(0o644)
    server = place.serve(answers(ECHO))
    refused = place.run("generate", "cubes")
    assert refused.code == 1
    assert "chmod 600" in refused.err
    assert not server.requests
    (folder / "config.toml").chmod(0o600)
    done = place.run("generate", "cubes", "-o", "out.scene")
    assert done.code == 0, done.err
    monkeypatch.setenv("ANTHROPIC_BASE_URL", f"http://user:{KEY}@127.0.0.1:9/?key={KEY}")
    offline = place.run("generate", "other cubes")
    assert offline.code == 1
    nowhere(place, refused, done, offline, place.run("generate", "x", "--dry-run"))


@pytest.mark.slow
@pytest.mark.parametrize("level", ["debug", "info"])
def test_the_packages_own_log(place: Place, level: str) -> None:
    """With ANTHROPIC_LOG the package writes what it sends; the key is not in it."""
    server = place.serve(answers(ECHO))
    environment = {**os.environ, "ANTHROPIC_LOG": level}
    words = [sys.executable, "-m", "scenelang", "generate", "cubes", "-o", "out.scene"]
    done = subprocess.run(words, cwd=place.work, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert len(server.requests) == 1
    nowhere(place, Done(done.returncode, done.stdout, done.stderr))


def test_files_of_runs_and_replies_are_private(place: Place) -> None:
    place.serve(answers(cubes()))
    place.generate("a cube", "-o", "out.scene")
    (kept,) = (place.folder / "cache").rglob("*.json")
    assert kept.stat().st_mode & 0o077 == 0
    assert place.runs.stat().st_mode & 0o077 == 0


def test_the_planted_key_would_be_found(place: Place) -> None:
    (place.work / "leak.txt").write_text(f"x{KEY}x")
    with pytest.raises(AssertionError):
        nowhere(place)
