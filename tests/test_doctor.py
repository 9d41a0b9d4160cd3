"""The command doctor: it tells what is so, whatever is broken."""

from __future__ import annotations

import json
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from scenelang.backends import base
from scenelang.backends.base import Work
from scenelang.cli.main import main
from scenelang.doctor import doctor
from scenelang.doctor.doctor import Check, CheckState


@pytest.mark.slow
def test_it_tells_what_works(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["doctor", "--json"])
    found = json.loads(capsys.readouterr().out)
    by_name = {(each["topic"], each["name"]): each for each in found}
    assert [each for each in found if each["state"] == "broken"] == []
    assert code == 0
    assert by_name["packages", "numpy"]["detail"].count(".") >= 1
    for name in ("language", "draft", "viewer", *(backend.name for backend in base.all_backends(Work.EXPORT))):
        assert ("works", name) in by_name
    assert by_name["works", "language"]["state"] in ("ok", "note")
    assert {"system", "limits", "works", "packages", "extras", "services", "folders", "terminal"} == {
        topic for topic, _ in by_name
    }


def test_as_text(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    found = [
        Check("works", "draft", CheckState.OK, "draws"),
        Check("works", "usd", CheckState.MISSING, "not installed", "pip install 'scenelang[usd]'"),
        Check("folders", "cache", CheckState.MISSING, "/x cannot be written", "set XDG_CACHE_HOME to a folder"),
    ]
    monkeypatch.setattr(doctor, "checks", lambda: iter(found))
    assert main(["doctor"]) == 0
    text = capsys.readouterr().out
    assert "All required features work." in text
    assert text.endswith("To install missing features:\n  pip install 'scenelang[usd]'\n")
    monkeypatch.setattr(doctor, "checks", lambda: iter([*found, Check("works", "gltf", CheckState.BROKEN, "no")]))
    assert main(["doctor"]) == 1
    assert "BROKEN gltf" in capsys.readouterr().out


def test_a_group_that_fails_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails() -> list[Check]:
        raise RuntimeError("a driver is mad")

    for place in ("system_checks", "work_checks", "terminal_checks"):
        monkeypatch.setattr(f"scenelang.doctor.doctor.{place}", fails)
    found = list(doctor.checks())
    assert [check.topic for check in found if check.detail == "RuntimeError: a driver is mad"] == [
        "system",
        "works",
        "terminal",
    ]
    assert any(check.name == "numpy" for check in found)


@pytest.mark.parametrize("name", doctor.tests())
@pytest.mark.sampled(3)
def test_every_trial_does_what_it_says(name: str, tmp_path: Path) -> None:
    for package, needs in (("av", name == "film .mp4"), ("pxr", name == "usd")):
        if needs:
            pytest.importorskip(package)
    assert doctor.tests()[name](tmp_path)


def test_trials_that_fail_or_crash_leave_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first process writes one line and dies, as a native library would let it; the next does the rest."""
    start = doctor._start
    deadly = 'import json, os; print(json.dumps({"name": "bad"}), flush=True); os.abort()'
    commands = iter([[sys.executable, "-c", deadly]])
    monkeypatch.setattr(doctor, "_start", lambda asked: start(next(commands, asked)))
    told = doctor._tried(["bad", "no such trial", "language"])
    assert told["bad"] == (False, "the test process crashed")
    assert told["no such trial"][0] is False
    assert told["language"][0] is True
    assert doctor._finding("gltf", {"gltf": (False, "x")}).state is CheckState.BROKEN
    assert doctor._finding("somebody's", {"somebody's": (False, "x")}).state is CheckState.MISSING


def test_time_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    start = doctor._start
    sleeper = [sys.executable, "-c", "import time; time.sleep(3600)"]
    monkeypatch.setattr(doctor, "_start", lambda asked: start(sleeper))
    monkeypatch.setattr(doctor, "_TEST_SECONDS", 0.1)
    found = list(doctor.work_checks())
    assert {check.state for check in found} <= {CheckState.NOTE, CheckState.MISSING}
    assert any("not tested" in check.detail for check in found)


def test_packages_that_are_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    stated = ["numpy>=2.0", "lost>=1", 'rare>=1; sys_platform == "plan9"', 'usd-core>=24; extra == "usd"',
              "gone; extra == 'usd'", 'pytest; extra == "dev"']  # fmt: skip
    monkeypatch.setattr(doctor, "requires", lambda _: stated)
    monkeypatch.setattr(doctor, "version_of", lambda name: "1.0" if name in ("numpy", "usd-core") else None)
    assert [(c.name, c.state, c.remedy) for c in doctor.package_checks()] == [
        ("numpy", CheckState.OK, ""),
        ("lost", CheckState.BROKEN, "pip install lost"),
        ("rare", CheckState.NOTE, ""),
        ("usd", CheckState.MISSING, "pip install 'scenelang[usd]'"),
    ]

    monkeypatch.setattr(doctor, "in_pipx", lambda: True)
    assert list(doctor.package_checks())[-1].remedy == "pipx inject scenelang gone"

    def unknown(_: str) -> list[str]:
        raise PackageNotFoundError("scenelang")

    monkeypatch.setattr(doctor, "requires", unknown)
    assert [check.state for check in doctor.package_checks()] == [CheckState.NOTE]


def test_folders_that_cannot_be_written(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(file))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "new"))
    cache, settings = doctor.folder_checks()
    assert (cache.state, settings.state) == (CheckState.MISSING, CheckState.OK)
    assert not (tmp_path / "new").exists()


def test_a_bare_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor.shutil, "which", lambda name: None)
    monkeypatch.setattr(doctor.webbrowser, "get", _no_browser)
    found = {check.name: check for check in (*doctor.terminal_checks(), *doctor.system_checks())}
    assert found["browser"].state is CheckState.MISSING
    assert found["GPU"].state is CheckState.NOTE


def _no_browser() -> None:
    raise doctor.webbrowser.Error("none")


def test_services_tell_of_keys_and_show_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from scenelang.doctor.doctor import service_checks

    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    for name in ("ANTHROPIC_API_KEY", "ANTHROPIC_BASE_URL", "OPENAI_API_KEY", "OPENAI_BASE_URL"):
        monkeypatch.delenv(name, raising=False)
    first, second = service_checks()
    assert (first.name, first.state, first.remedy) == (
        "anthropic",
        CheckState.MISSING,
        "set it with `export ANTHROPIC_API_KEY=...`",
    )
    assert (second.name, second.state) == ("openai", CheckState.NOTE)
    monkeypatch.setenv("ANTHROPIC_API_KEY", "sk-secret-secret")
    first, _ = service_checks()
    assert (first.state, first.detail) == (
        CheckState.NOTE,
        "API key found for https://api.anthropic.com; not contacted",
    )
