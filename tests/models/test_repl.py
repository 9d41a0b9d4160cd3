"""The REPL's ,generate and ,edit."""

from __future__ import annotations

import pytest

from models.conftest import Place, cubes, texts
from models.server import ModelServer, Said

pytestmark = pytest.mark.usefixtures("untried")


def drive(place: Place, monkeypatch: pytest.MonkeyPatch, *inputs: str) -> tuple[str, str]:
    import io
    import sys

    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO("".join(f"{line}\n" for line in inputs).encode())))
    done = place.run("repl", "--plain")
    return done.out, done.err


def serve(place: Place, *answers: str) -> ModelServer:
    return place.serve([Said(answer) for answer in answers])


def test_generate_defines_words(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    server = serve(place, cubes(3))
    out, err = drive(place, monkeypatch, ",generate three of Newton's cubes", ",count", '(call "pile")')
    assert "three of Newton's cubes" in texts(server.requests[0]["messages"][0])
    assert out.splitlines()[:3] == ['of the root "pile":', "1  pile", "3  cube"], err
    assert place.run("runs").out.splitlines()[1].split()[1:3] == ["repl", "done"]


def test_edit_changes_what_is_defined(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    before = '(define size 2)\n(bind "box" (lambda () (call "cube" :scale size)))\n'
    server = serve(place, f"```scene\n{before.replace('size 2', 'size 3')}```")
    lines = [*before.splitlines(), ",edit make it larger", "size", ",bounds"]
    out, err = drive(place, monkeypatch, *lines)
    said = texts(server.requests[0]["messages"][0])
    assert "make it larger" in said
    assert "-(define size 2)" in out.splitlines(), err
    assert "+(define size 3)" in out.splitlines()
    assert "3" in out.splitlines()
    assert "max     [1.5 1.5 1.5]" in out.splitlines()


def test_its_runs_are_not_gone_on_with_outside(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    serve(place, cubes(1))
    drive(place, monkeypatch, ",generate a cube")
    for command in ("generate", "edit"):
        done = place.run(command, "--resume", "last")
        assert (done.code, "was created in the REPL" in done.err) == (2, True)


def test_options_and_mistakes(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    server = serve(place, cubes(1))
    out, err = drive(
        place, monkeypatch, ",generate", ",generate --modle x y", ",generate --resume last", ",edit higher",
        ",generate --model claude-haiku-5-5 --effort low a cube", ",count",
    )  # fmt: skip
    assert "`,generate` requires a text prompt, such as ,generate a lighthouse" in err
    assert "unrecognized arguments: --modle" in err
    assert "`--resume` is only supported on the command line" in err
    assert "no definitions" in err
    (request,) = server.requests
    assert (request["model"], request["output_config"]) == ("claude-haiku-5-5", {"effort": "low"})
    assert "1  cube" in out.splitlines()


def test_a_failure_leaves_the_session_as_it_was(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    serve(place, "no", "no")
    out, err = drive(place, monkeypatch, "(define x 1)", ",generate --repair 1 a cube", "x", "(+ x 1)")
    assert "no sample produced a valid program" in err
    assert out.splitlines()[-2:] == ["1", "2"]
