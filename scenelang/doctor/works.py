"""Which backends work, by trying them in other processes within a few seconds."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from scenelang.backends import base
from scenelang.backends.base import Work
from scenelang.backends.mitsuba.variants import NAMES, trial_command
from scenelang.doctor.check import Check, State
from scenelang.doctor.packages import in_pipx
from scenelang.doctor.trials import FILMS, LANGUAGE, PICTURE, VIEWER

_SECONDS = 4.2  # for all trials together
_NVIDIA = Path("/proc/driver/nvidia/version")
_OWN = ("draft", "gltf", "obj", "ply", "stl", "json", "mitsuba-xml")  # promised without extras


def work_checks() -> Iterator[Check]:
    """A finding for the language, each backend, each variant of Mitsuba, films and the viewer."""
    end = time.monotonic() + _SECONDS
    variants = {name: _start(trial_command(name)) for name in NAMES if name != "cuda" or _NVIDIA.exists()}
    exports = {backend.name: backend for backend in base.every(Work.EXPORT)}
    installs = {name: backend.install for name, backend in exports.items() if not backend.is_installed}
    installs |= {} if _has("av") else {"film .mp4": "'scenelang[video]'"}
    names = [name for name in (LANGUAGE, PICTURE, *exports, *FILMS, VIEWER) if name not in installs]
    told = _tried(names, end)
    for name in (LANGUAGE, PICTURE):
        yield _finding(name, told)
    yield from _variant_checks(variants, end)
    for name in (*exports, *FILMS, VIEWER):
        if name in installs:
            remedy = "" if in_pipx() else f"pip install {installs[name]}"  # what pipx injects stands with the extras
            yield Check("works", name, State.MISSING, "not installed", remedy)
        else:
            yield _finding(name, told)


def _has(package: str) -> bool:
    from importlib.util import find_spec

    return find_spec(package) is not None


def _start(command: Sequence[str]) -> subprocess.Popen[str] | None:
    try:
        # a list of words, no shell: our own interpreter
        return subprocess.Popen(  # noqa: S603  # nosec B603
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
    except OSError:
        return None


def _output(process: subprocess.Popen[str] | None, end: float) -> str | None:
    """What a process wrote until its end, or until ``end``; None where it had to be stopped then."""
    if process is None:
        return ""
    try:
        return process.communicate(timeout=max(0.05, end - time.monotonic()))[0]
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return None


def _tried(names: Sequence[str], end: float) -> Mapping[str, tuple[bool, str]]:
    """What came of each trial; those that time did not suffice for are left out. One that ends the process is begun no
    more, the others are."""
    told: dict[str, tuple[bool, str]] = {}
    left = list(names)
    while left and time.monotonic() < end:
        begun = ""
        with _Lines([sys.executable, "-P", "-m", "scenelang.doctor.trials", *left], end) as lines:
            for line in lines:
                begun = str(line["name"])
                if "ok" in line:
                    told[begun] = (bool(line["ok"]), str(line["detail"]))
        if time.monotonic() < end and begun not in told:
            told[begun or left[0]] = (False, "the process that tried it broke off")
        left = [name for name in left if name not in told]
    return told


class _Lines:
    """The lines of JSON that a process prints until ``end``."""

    def __init__(self, command: Sequence[str], end: float) -> None:
        self._process = _start(command)
        self._end = end

    def __enter__(self) -> Iterator[Mapping[str, object]]:
        return self._lines()

    def _lines(self) -> Iterator[Mapping[str, object]]:
        if self._process is None or self._process.stdout is None:
            return
        from threading import Timer

        timer = Timer(max(0.0, self._end - time.monotonic()), self._process.kill)
        timer.start()
        try:
            for line in self._process.stdout:
                if line.startswith("{") and line.endswith("}\n"):
                    yield json.loads(line)
        finally:
            timer.cancel()

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            if self._process.stdout is not None:
                self._process.stdout.close()


def _finding(name: str, told: Mapping[str, tuple[bool, str]]) -> Check:
    if name not in told:
        return Check("works", name, State.NOTE, f"not tried: {_SECONDS:g} seconds were over")
    ok, detail = told[name]
    if ok:
        return Check("works", name, State.OK, detail)
    promised = name in (*_OWN, LANGUAGE, VIEWER, "film .gif")
    return Check("works", name, State.BROKEN if promised else State.MISSING, detail)


def _variant_checks(variants: Mapping[str, subprocess.Popen[str] | None], end: float) -> Iterator[Check]:
    for name in NAMES:
        if name not in variants:
            yield Check("works", f"mitsuba {name}", State.NOTE, "no NVIDIA driver here")
            continue
        text = _output(variants[name], end)
        if text is None:
            yield Check("works", f"mitsuba {name}", State.NOTE, f"not ready within {_SECONDS:g} seconds")
        elif text.strip() == "True":
            yield Check("works", f"mitsuba {name}", State.OK, "draws a picture")
        elif name == "scalar":
            yield Check(
                "works", "mitsuba scalar", State.BROKEN, "draws nothing", "pip install --force-reinstall mitsuba"
            )
        else:
            what = "finds no LLVM (Debian: libllvm19)" if name == "llvm" else "draws nothing on this GPU"
            yield Check("works", f"mitsuba {name}", State.NOTE, f"{what}; `scalar` works without")
