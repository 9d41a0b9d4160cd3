"""Which backends work, by trying them in other processes within a few seconds."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from scenelang.backends import base
from scenelang.backends.base import Backend, Work
from scenelang.backends.language_models.provider import PROVIDERS, connection
from scenelang.backends.pictures.mitsuba import NAMES, trial_command
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.reports import colored
from scenelang.session import Session

# Small works that are really done, one after the other, in a process of their own: a native library that crashes takes
# only that process with it. ``python -P -m scenelang.doctor NAME ...`` prints a line of JSON before each and one after
# it.


_PROGRAM = '(bind "trial" (lambda () (union (call "cube") (call "sphere" :color [1 0 0]))))'
_SIDE = 16  # pixels
LANGUAGE, PICTURE, VIEWER = "language", "draft", "viewer"
FILMS = {"film .gif": ".gif", "film .mp4": ".mp4"}


def trials() -> Mapping[str, Callable[[Path], str]]:
    """Every trial by name: it works in a folder, says what came out, and raises where nothing did."""
    found: dict[str, Callable[[Path], str]] = {LANGUAGE: _evaluate, PICTURE: _draw, VIEWER: _view}
    found |= {name: partial(_film, ending) for name, ending in FILMS.items()}
    return found | {backend.name: partial(_export, backend) for backend in base.every(Work.EXPORT)}


def _scene() -> Scene:
    return _evaluated(_PROGRAM)


def _evaluated(text: str) -> Scene:
    result = Session().evaluate(Source("<trial>", text))
    if result.scene is None:
        raise SceneError("value", "; ".join(diagnostic.message for diagnostic in result.diagnostics))
    return result.scene


def _build() -> Scene:
    """A scene for backends that write nothing but blocks."""
    return _evaluated('(bind "trial" (lambda () (call "set-cuboid" :block-type "stone" :scale [3 2 1])))')


def _evaluate(folder: Path) -> str:
    return f"evaluates a scene of {len(_scene().root.children)} parts"


def _draw(folder: Path) -> str:
    from scenelang.backends.pictures.film import PictureOptions, render, save_picture

    path = folder / "trial.png"
    save_picture(render(_scene(), PictureOptions(width=_SIDE, height=_SIDE)), path)
    return f"draws a picture of {_SIDE}x{_SIDE} pixels ({path.stat().st_size} bytes)"


def _film(ending: str, folder: Path) -> str:
    from scenelang.backends.pictures.film import PictureOptions, painters, picture_backend, save_film
    from scenelang.backends.pictures.stage import still

    scene, options = _scene(), PictureOptions(width=_SIDE, height=_SIDE)
    shots = [still(scene, options.camera, None, _SIDE, _SIDE)] * 2
    path = folder / f"trial{ending}"
    save_film(painters(scene, options, [picture_backend("draft")], shots), shots, path)
    return f"writes a film ({path.stat().st_size} bytes)"


def _view(folder: Path) -> str:
    from scenelang.backends.viewer.page import STATIC, served_page, static

    size = len(served_page()) + sum(len(static(name)) for name in STATIC)
    return f"its page is complete ({size:,} bytes)"


def _export(backend: Backend, folder: Path) -> str:
    path = folder / f"trial{backend.endings[0]}"
    scene = _scene() if backend.accepts.any_word else _build()
    written = backend.run(scene, path, base.BackendOptions()) or [path]
    return f"writes {' '.join(backend.endings)} ({sum(each.stat().st_size for each in written)} bytes)"


def main(names: list[str]) -> int:
    """Run the trials of these names, or all."""
    known = trials()
    for name in names or known:
        _say({"name": name})
        try:
            with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
                _say({"name": name, "ok": True, "detail": known[name](Path(folder))})
        except SceneError as error:
            _say({"name": name, "ok": False, "detail": error.message})
        except Exception as error:  # a backend may be anybody's
            _say({"name": name, "ok": False, "detail": f"{type(error).__name__}: {error}"})
    return 0


def _say(line: Mapping[str, object]) -> None:
    print(json.dumps(line), flush=True)


# One finding about the installation.


class CheckState(Enum):
    OK = "ok"
    NOTE = "note"  # neither good nor bad
    MISSING = "missing"  # comes with an extra, or is better to have
    BROKEN = "broken"  # promised without extras


@dataclass(frozen=True, slots=True)
class Check:
    """``topic`` groups the findings, ``remedy`` is what mends it: a command line, or empty."""

    topic: str
    name: str
    state: CheckState
    detail: str
    remedy: str = ""

    def data(self) -> dict[str, str]:
        """The finding as JSON data."""
        return asdict(self) | {"state": self.state.value}


def checks() -> Iterator[Check]:
    """All findings; a group that fails to be looked at is a finding itself."""
    groups: tuple[tuple[str, Callable[[], Iterable[Check]]], ...] = (
        ("system", system_checks),
        ("limits", limit_checks),
        ("works", work_checks),
        ("packages", package_checks),
        ("services", service_checks),
        ("folders", folder_checks),
        ("terminal", terminal_checks),
    )
    for topic, group in groups:
        try:
            yield from group()
        except Exception as error:  # whatever is wrong with the installation, the others are told
            yield Check(topic, topic, CheckState.BROKEN, f"{type(error).__name__}: {error}")


# Packages: the versions of those that are needed, and what the extras lack.


_REQUIREMENT = re.compile(r"([A-Za-z0-9][A-Za-z0-9._-]*)[^;]*(?:;(.*))?")
_EXTRA = re.compile(r"""extra\s*==\s*['"]([^'"]+)['"]""")
_FOR_DEVELOPMENT = ("dev", "blender", "all")


def version_of(package: str) -> str | None:
    """The version of an installed distribution, None for one that is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def in_pipx() -> bool:
    """Whether pipx made the environment that runs this: pip does not reach it from outside."""
    return (Path(sys.prefix) / "pipx_metadata.json").exists()


def package_checks() -> Iterator[Check]:
    """What the package needs, then each extra."""
    try:
        stated = requires("scenelang") or []
    except PackageNotFoundError:
        yield Check("packages", "scenelang", CheckState.NOTE, "runs from its sources, so its needs are not known")
        return
    extras: dict[str, list[str]] = {}
    for line in stated:
        match = _REQUIREMENT.match(line)
        if match is None:
            continue
        name, marker = match[1], match[2] or ""
        extra = _EXTRA.search(marker)
        if extra is None:
            yield _needed(name, bool(marker.strip()))
        else:
            extras.setdefault(extra[1], []).append(name)
    for extra_name, packages in extras.items():
        if extra_name not in _FOR_DEVELOPMENT:
            yield _extra(extra_name, packages)


def _needed(package: str, only_sometimes: bool) -> Check:
    found = version_of(package)
    if found is not None:
        return Check("packages", package, CheckState.OK, found)
    if only_sometimes:
        return Check("packages", package, CheckState.NOTE, "not installed; not every platform has it")
    return Check("packages", package, CheckState.BROKEN, "not installed", f"pip install {package}")


def _extra(name: str, packages: Sequence[str]) -> Check:
    """An extra with the versions of its packages, or with those that it lacks."""
    versions = {package: version_of(package) for package in packages}
    lacking = [package for package, found in versions.items() if found is None]
    if lacking:
        remedy = f"pipx inject scenelang {' '.join(lacking)}" if in_pipx() else f"pip install 'scenelang[{name}]'"
        return Check("extras", name, CheckState.MISSING, f"not installed: {', '.join(lacking)}", remedy)
    return Check("extras", name, CheckState.OK, ", ".join(f"{package} {found}" for package, found in versions.items()))


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
            yield Check("works", name, CheckState.MISSING, "not installed", remedy)
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
        with _Lines([sys.executable, "-P", "-m", "scenelang.doctor", *left], end) as lines:
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
        return Check("works", name, CheckState.NOTE, f"not tried: {_SECONDS:g} seconds were over")
    ok, detail = told[name]
    if ok:
        return Check("works", name, CheckState.OK, detail)
    promised = name in (*_OWN, LANGUAGE, VIEWER, "film .gif")
    return Check("works", name, CheckState.BROKEN if promised else CheckState.MISSING, detail)


def _variant_checks(variants: Mapping[str, subprocess.Popen[str] | None], end: float) -> Iterator[Check]:
    for name in NAMES:
        if name not in variants:
            yield Check("works", f"mitsuba {name}", CheckState.NOTE, "no NVIDIA driver here")
            continue
        text = _output(variants[name], end)
        if text is None:
            yield Check("works", f"mitsuba {name}", CheckState.NOTE, f"not ready within {_SECONDS:g} seconds")
        elif text.strip() == "True":
            yield Check("works", f"mitsuba {name}", CheckState.OK, "draws a picture")
        elif name == "scalar":
            yield Check(
                "works", "mitsuba scalar", CheckState.BROKEN, "draws nothing", "pip install --force-reinstall mitsuba"
            )
        else:
            what = "finds no LLVM (Debian: libllvm19)" if name == "llvm" else "draws nothing on this GPU"
            yield Check("works", f"mitsuba {name}", CheckState.NOTE, f"{what}; `scalar` works without")


# The machine: Python, folders, terminal, browser, GPU.


_BROWSERS = ("firefox", "chromium", "chromium-browser", "google-chrome", "microsoft-edge", "safari", "brave-browser")
_IMAGE_TERMINALS = ("iTerm.app", "WezTerm", "ghostty", "kitty")
_PATIENCE = 2.0  # seconds, for a driver's tool


def system_checks() -> Iterator[Check]:
    """Versions, and where the program stands."""
    yield Check("system", "scenelang", CheckState.OK, version_of("scenelang") or "from its sources")
    yield Check("system", "Python", CheckState.OK, f"{platform.python_version()}, {sys.executable}")
    cores = os.cpu_count() or 1
    yield Check("system", "platform", CheckState.OK, f"{platform.platform()}, {platform.machine()}, {cores} cores")
    yield _gpu()


def limit_checks() -> Iterator[Check]:
    """What holds programs within their limits, and away from files and the network."""
    from scenelang.sandbox.confinement import has_seccomp, landlock_version
    from scenelang.sandbox.supervision import is_supported

    if is_supported():
        yield Check("limits", "processes", CheckState.OK, "programs are evaluated in processes that can be ended")
    else:
        detail = "only soft limits, which a builtin may overrun: ending processes needs Linux 5.4 or newer"
        yield Check("limits", "processes", CheckState.NOTE, detail)
    version = landlock_version()
    files = f"Landlock {version}: evaluation may only read the project" if version else "this kernel has no Landlock"
    yield Check("limits", "files", CheckState.OK if version else CheckState.NOTE, files)
    calls = "seccomp: no sockets, no other programs" if has_seccomp() else "no seccomp on this system"
    yield Check("limits", "calls", CheckState.OK if has_seccomp() else CheckState.NOTE, calls)


def folder_checks() -> Iterator[Check]:
    """The user's folders for caches and settings."""
    home = Path(os.path.expanduser("~"))
    for name, variable, default in (
        ("cache", "XDG_CACHE_HOME", home / ".cache"),
        ("settings", "XDG_CONFIG_HOME", home / ".config"),
    ):
        folder = Path(os.environ.get(variable) or default) / "scenelang"
        if _is_writable(folder):
            yield Check("folders", name, CheckState.OK, str(folder))
        else:
            yield Check(
                "folders", name, CheckState.MISSING, f"{folder} cannot be written", f"set {variable} to a folder"
            )


def _is_writable(folder: Path) -> bool:
    """Whether files can be made in a folder, or the folder itself where it is not there yet."""
    try:
        there = next(parent for parent in (folder, *folder.parents) if parent.exists())
        with tempfile.TemporaryFile(dir=there):
            return True
    except (OSError, StopIteration):
        return False


def terminal_checks() -> Iterator[Check]:
    """What the terminal can show, and whether there is a browser for the viewer."""
    if sys.stdout.isatty():
        size = shutil.get_terminal_size()
        colors = "no colours" if "NO_COLOR" in os.environ else _colors()
        yield Check("terminal", "output", CheckState.OK, f"a terminal of {size.columns}x{size.lines}, {colors}")
    else:
        yield Check("terminal", "output", CheckState.NOTE, "no terminal")
    yield Check("terminal", "text", CheckState.OK, f"{sys.stdout.encoding}, TERM={os.environ.get('TERM', '')}")
    shown = _shows_images()
    yield Check(
        "terminal", "pictures", CheckState.OK if shown else CheckState.NOTE, "inline" if shown else "not shown inline"
    )
    yield _browser()


def _colors() -> str:
    if os.environ.get("COLORTERM") in ("truecolor", "24bit"):
        return "16 million colours"
    return "256 colours" if "256" in os.environ.get("TERM", "") else "colours"


def _shows_images() -> bool:
    program = os.environ.get("TERM_PROGRAM", "")
    return program in _IMAGE_TERMINALS or "kitty" in os.environ.get("TERM", "") or "KITTY_WINDOW_ID" in os.environ


def _browser() -> Check:
    found = next((path for name in _BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        try:
            found = getattr(webbrowser.get(), "name", "the system's own")
        except webbrowser.Error:
            detail = "none found; `scenelang view --html FILE` writes a page for another machine"
            return Check("terminal", "browser", CheckState.MISSING, detail)
    return Check("terminal", "browser", CheckState.OK, str(found))


def _gpu() -> Check:
    tool = shutil.which("nvidia-smi")
    if tool is None:
        return Check("system", "GPU", CheckState.NOTE, "no NVIDIA GPU found; nothing needs one")
    try:
        # a list of words, no shell: our interpreter or a program by its own name
        done = subprocess.run([tool, "-L"], capture_output=True, text=True, timeout=_PATIENCE)  # noqa: S603  # nosec B603
    except (OSError, subprocess.SubprocessError):
        return Check("system", "GPU", CheckState.NOTE, "its driver does not answer; nothing needs one")
    cards = [line.partition(" (UUID")[0] for line in done.stdout.splitlines() if line.startswith("GPU")]
    if done.returncode != 0 or not cards:
        return Check("system", "GPU", CheckState.NOTE, "its driver finds none; nothing needs one")
    return Check("system", "GPU", CheckState.OK, ", ".join(cards))


# Services that commands may ask: whether there is a key for each family of language models. Nothing is sent.


def service_checks() -> Iterator[Check]:
    """A finding for each provider: its address and whether it has a key."""
    for family in PROVIDERS.every():
        try:
            found = connection(family)
        except SceneError as error:
            yield Check("services", family.name, CheckState.MISSING, error.message, error.hint or "")
            continue
        key = "a key" if found.key is not None else "no key"
        yield Check("services", family.name, CheckState.NOTE, f"{key} for {found.shown_address}; not asked")


# The report.


_TITLES = {
    "system": "System",
    "works": "What works",
    "packages": "Packages",
    "extras": "Extras",
    "services": "Services",
    "folders": "Folders",
    "terminal": "Terminal and browser",
}
_MARKS = {"ok": "ok", "note": "--", "missing": "no", "broken": "BROKEN"}
_STATES = {"ok": "32", "note": "0", "missing": "33", "broken": "1;31"}


def report_lines(found: Sequence[Check], color: bool) -> Iterator[str]:
    """The findings for people, by topic, with what adds what is missing."""
    width = max(len(check.name) for check in found)
    for topic, title in _TITLES.items():
        mine = [check for check in found if check.topic == topic]
        if mine:
            yield title
            yield from (_line_of(check, width, color) for check in mine)
    broken = sum(check.state.value == "broken" for check in found)
    remedies = list(dict.fromkeys(check.remedy for check in found if check.remedy.startswith(("pip ", "pipx "))))
    yield ""
    yield f"{broken} broken." if broken else "Everything that needs no extra works."
    if remedies:
        yield "To add what is missing:"
        yield from (f"  {remedy}" for remedy in remedies)


def _line_of(check: Check, width: int, color: bool) -> str:
    mark = colored(_MARKS[check.state.value], _STATES[check.state.value] if color else None)
    remedy = f"; {check.remedy}" if check.remedy else ""
    return f"  {mark} {' ' * max(0, 2 - len(_MARKS[check.state.value]))}{check.name:<{width}}  {check.detail}{remedy}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
