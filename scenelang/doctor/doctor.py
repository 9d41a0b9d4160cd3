"""Installation check: runs a quick test of every backend in separate processes, within a few seconds."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from threading import Timer

from scenelang.backends import base
from scenelang.backends.base import Backend, Work
from scenelang.console.reports import colored
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import REINSTALL, SceneError
from scenelang.interpreter.loading import is_present
from scenelang.interpreter.scene.entity import Scene
from scenelang.session.session import Session

# Each test does a small amount of real work in a separate process, so that a crashing native library ends only that
# process. ``python -P -m scenelang.doctor.doctor NAME ...`` prints a line of JSON before each test and one after it.


_PROGRAM = '(bind "trial" (lambda () (union (call "cube") (call "sphere" :color [1 0 0]))))'
_IMAGE_SIDE = 16  # pixels
LANGUAGE, PICTURE, VIEWER = "language", "draft", "viewer"
FILMS = {"film .gif": ".gif", "film .mp4": ".mp4"}
_PICTURES = "scenelang.backends.pictures"
_DOMAINS = {PICTURE: _PICTURES, VIEWER: "scenelang.backends.viewer", **dict.fromkeys(FILMS, _PICTURES)}


def tests() -> Mapping[str, Callable[[Path], str]]:
    """Return all tests by name: each works in a folder, returns a summary, and raises if it fails."""
    tests_by_name: dict[str, Callable[[Path], str]] = {LANGUAGE: _evaluate, PICTURE: _draw, VIEWER: _view}
    tests_by_name |= {name: partial(_film, ending) for name, ending in FILMS.items()}
    return tests_by_name | {backend.name: partial(_export, backend) for backend in base.all_backends(Work.EXPORT)}


def _scene() -> Scene:
    """Return a scene of two primitives."""
    return _evaluated(_PROGRAM)


def _evaluated(text: str) -> Scene:
    """Evaluate a program; raises SceneError."""
    result = Session().evaluate(Source("<trial>", text))
    if result.scene is None:
        raise SceneError("value", "; ".join(diagnostic.message for diagnostic in result.diagnostics))
    return result.scene


def _build() -> Scene:
    """Create a scene for backends that only support Minecraft blocks."""
    return _evaluated('(bind "trial" (lambda () (call "set-cuboid" :block-type "stone" :scale [3 2 1])))')


def _evaluate(folder: Path) -> str:
    """Test the language."""
    return f"evaluated a scene of {len(_scene().root.children)} parts"


def _draw(folder: Path) -> str:
    """Test drafts."""
    from scenelang.backends.pictures.film import PictureOptions, render, save_picture

    path = folder / "trial.png"
    save_picture(render(_scene(), PictureOptions(width=_IMAGE_SIDE, height=_IMAGE_SIDE)), path)
    return f"rendered an image of {_IMAGE_SIDE}x{_IMAGE_SIDE} pixels ({path.stat().st_size} bytes)"


def _film(ending: str, folder: Path) -> str:
    """Test videos of one format."""
    from scenelang.backends.pictures.film import PictureOptions, painters, picture_backend, save_film
    from scenelang.backends.pictures.stage import still

    scene, options = _scene(), PictureOptions(width=_IMAGE_SIDE, height=_IMAGE_SIDE)
    shots = [still(scene, options.camera, None, _IMAGE_SIDE, _IMAGE_SIDE)] * 2
    path = folder / f"trial{ending}"
    save_film(painters(scene, options, [picture_backend("draft")], shots), shots, path)
    return f"wrote a video ({path.stat().st_size} bytes)"


def _view(folder: Path) -> str:
    """Test that the page of the viewer is complete."""
    from scenelang.backends.viewer.packet import STATIC, served_page, static

    size = len(served_page()) + sum(len(static(name)) for name in STATIC)
    return f"page complete ({size:,} bytes)"


def _export(backend: Backend, folder: Path) -> str:
    """Test an export backend."""
    path = folder / f"trial{backend.endings[0]}"
    scene = _scene() if backend.accepts.any_word else _build()
    written = backend.run(scene, path, base.BackendOptions()) or [path]
    return f"wrote {' '.join(backend.endings)} ({sum(file.stat().st_size for file in written)} bytes)"


def main(names: list[str]) -> int:
    """Run the named tests, or all of them."""
    known = tests()
    for name in names or known:
        _say({"name": name})
        try:
            with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
                _say({"name": name, "ok": True, "detail": known[name](Path(folder))})
        except SceneError as error:
            _say({"name": name, "ok": False, "detail": error.message})
        except Exception as error:  # plug-in backends may raise anything
            _say({"name": name, "ok": False, "detail": f"{type(error).__name__}: {error}"})
    return 0


def _say(line: Mapping[str, object]) -> None:
    """Print a line for the parent process."""
    print(json.dumps(line), flush=True)


# --- results ---------------------------------------------------------------------------------------------------------


class CheckState(Enum):
    """State of a check."""

    OK = "ok"
    NOTE = "note"  # informational
    MISSING = "missing"  # optional
    BROKEN = "broken"  # required


@dataclass(frozen=True, slots=True)
class Check:
    """Result of one check. ``topic`` groups the results; ``remedy`` is a command that fixes the problem, or empty."""

    topic: str
    name: str
    state: CheckState
    detail: str
    remedy: str = ""

    def data(self) -> dict[str, str]:
        """Return the result as JSON data."""
        return asdict(self) | {"state": self.state.value}


def checks() -> Iterator[Check]:
    """Run all checks; a group that raises is reported as a broken check."""
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
        except Exception as error:  # one broken group must not hide the others
            yield Check(topic, topic, CheckState.BROKEN, f"{type(error).__name__}: {error}")


# --- packages --------------------------------------------------------------------------------------------------------


_REQUIREMENT = re.compile(r"([A-Za-z0-9][A-Za-z0-9._-]*)[^;]*(?:;(.*))?")
_EXTRA = re.compile(r"""extra\s*==\s*['"]([^'"]+)['"]""")
_FOR_DEVELOPMENT = ("dev", "blender", "all")


def version_of(package: str) -> str | None:
    """Return the version of an installed distribution, or None."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def in_pipx() -> bool:
    """Return whether the environment was created by pipx, in which case pip cannot install into it from outside."""
    return (Path(sys.prefix) / "pipx_metadata.json").exists()


def package_checks() -> Iterator[Check]:
    """Check the required packages, then each extra."""
    try:
        stated = requires("scenelang") or []
    except PackageNotFoundError:
        yield Check("packages", "scenelang", CheckState.NOTE, "not installed as a package; requirements unknown")
        return
    extras: dict[str, list[str]] = {}
    for line in stated:
        match = _REQUIREMENT.match(line)
        if match is None:
            continue
        name, marker = match[1], match[2] or ""
        extra = _EXTRA.search(marker)
        if extra is None:
            yield _needed(name, only_sometimes=bool(marker.strip()))
        elif name != "scenelang":  # another extra, which is checked by itself
            extras.setdefault(extra[1], []).append(name)
    for extra_name, packages in extras.items():
        if extra_name not in _FOR_DEVELOPMENT:
            yield _extra(extra_name, packages)


def _needed(package: str, *, only_sometimes: bool) -> Check:
    """Check a required package, which some platforms have ``only_sometimes``."""
    version = version_of(package)
    if version is not None:
        return Check("packages", package, CheckState.OK, version)
    if only_sometimes:
        return Check("packages", package, CheckState.NOTE, "not installed; not available on every platform")
    return Check("packages", package, CheckState.BROKEN, "not installed", f"pip install {package}")


def _extra(name: str, packages: Sequence[str]) -> Check:
    """Return the versions of an extra's packages, or the packages that are missing."""
    versions = {package: version_of(package) for package in packages}
    missing = [package for package, number in versions.items() if number is None]
    if missing:
        remedy = f"pipx inject scenelang {' '.join(missing)}" if in_pipx() else f"pip install 'scenelang[{name}]'"
        return Check("extras", name, CheckState.MISSING, f"not installed: {', '.join(missing)}", remedy)
    installed = ", ".join(f"{package} {number}" for package, number in versions.items())
    return Check("extras", name, CheckState.OK, installed)


_TEST_SECONDS = 30.0  # timeout of one test; on a loaded machine the slowest takes 5 s
_FINAL_REMEDY = "pip install 'scenelang[final]'"
_NVIDIA = Path("/proc/driver/nvidia/version")
_REQUIRED = ("draft", "gltf", "obj", "ply", "stl", "json")  # required without extras


def work_checks() -> Iterator[Check]:
    """Check the language, each backend, each variant of Mitsuba, videos and the viewer."""
    variants = _variant_trials() if is_present(_PICTURES) and is_present("mitsuba") else {}
    exports = {backend.name: backend for backend in base.all_backends(Work.EXPORT)}
    remedies = {name: backend.remedy for name, backend in exports.items() if not backend.is_installed}
    remedies |= {} if is_present("av") else {"film .mp4": "pip install 'scenelang[video]'"}
    remedies |= {name: f"pip install {REINSTALL}" for name, domain in _DOMAINS.items() if not is_present(domain)}
    names = [name for name in (LANGUAGE, PICTURE, *exports, *FILMS, VIEWER) if name not in remedies]
    results = _tried(names)
    for name in (LANGUAGE, PICTURE, *exports, *FILMS, VIEWER):
        yield _not_installed(name, remedies[name]) if name in remedies else _finding(name, results)
        if name == PICTURE:
            yield from _variant_checks(variants) if variants else (_not_installed("mitsuba", _FINAL_REMEDY),)


def _not_installed(name: str, remedy: str) -> Check:
    """Return the result for a feature that is missing, or whose packages are."""
    # with pipx, see the remedies of the extras
    return Check("works", name, CheckState.MISSING, "not installed", "" if in_pipx() else remedy)


def _variant_trials() -> dict[str, subprocess.Popen[str] | None]:
    """Start a process for each variant of Mitsuba that renders a trial image."""
    from scenelang.backends.pictures.mitsuba import NAMES, trial_command

    return {name: _start(trial_command(name)) for name in NAMES if name != "cuda" or _NVIDIA.exists()}


def _start(command: Sequence[str]) -> subprocess.Popen[str] | None:
    """Start a process; None if it cannot be started."""
    try:
        # no shell: our own interpreter with a list of arguments
        return subprocess.Popen(  # noqa: S603  # nosec B603
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
    except OSError:
        return None


def _output(process: subprocess.Popen[str] | None) -> str | None:
    """Return the output of a process, or None if it had to be killed."""
    if process is None:
        return ""
    try:
        return process.communicate(timeout=_TEST_SECONDS)[0]
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return None


def _tried(names: Sequence[str]) -> Mapping[str, tuple[bool | None, str]]:
    """Run tests; the result of each is None if it took too long.

    A test that crashes or blocks the process is not repeated; the others continue in a new process, because an
    incompatible
    native library can end the process that loads it.
    """
    results: dict[str, tuple[bool | None, str]] = {}
    left = list(names)
    while left:
        current = ""
        lines = _Lines([sys.executable, "-P", "-m", "scenelang.doctor.doctor", *left])
        with lines as printed:
            for line in printed:
                current = str(line["name"])
                if "ok" in line:
                    results[current] = (bool(line["ok"]), str(line["detail"]))
        if current not in results:
            late = (None, f"not tested: it took more than {_TEST_SECONDS:g} seconds")
            results[current or left[0]] = late if lines.is_late else (False, "the test process crashed")
        left = [name for name in left if name not in results]
    return results


class _Lines:
    """Context manager that yields the JSON lines printed by a process, which ends if it prints none for too long."""

    def __init__(self, command: Sequence[str]) -> None:
        self._process = _start(command)
        self.is_late = False

    def __enter__(self) -> Iterator[Mapping[str, object]]:
        return self._lines()

    def _lines(self) -> Iterator[Mapping[str, object]]:
        """Yield lines until the process ends, or prints none for too long."""
        if self._process is None or self._process.stdout is None:
            return
        while True:
            timer = Timer(_TEST_SECONDS, self._stop)
            timer.start()
            try:
                line = self._process.stdout.readline()
            finally:
                timer.cancel()
            if not line:
                return
            if line.startswith("{") and line.endswith("}\n"):
                yield json.loads(line)

    def _stop(self) -> None:
        """Kill the process, because it is late."""
        self.is_late = True
        if self._process is not None:
            self._process.kill()

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            if self._process.stdout is not None:
                self._process.stdout.close()


def _finding(name: str, results: Mapping[str, tuple[bool | None, str]]) -> Check:
    """Return the result of a test; a failure is broken only for features that need no extra."""
    ok, detail = results[name]
    if ok is None:
        return Check("works", name, CheckState.NOTE, detail)
    if ok:
        return Check("works", name, CheckState.OK, detail)
    promised = name in (*_REQUIRED, LANGUAGE, VIEWER, "film .gif")
    return Check("works", name, CheckState.BROKEN if promised else CheckState.MISSING, detail)


def _variant_checks(variants: Mapping[str, subprocess.Popen[str] | None]) -> Iterator[Check]:
    """Return the results of Mitsuba's variants; without `llvm` and `cuda`, `scalar` works."""
    for name in ("scalar", "llvm", "cuda"):
        if name not in variants:
            yield Check("works", f"mitsuba {name}", CheckState.NOTE, "no NVIDIA driver")
            continue
        text = _output(variants[name])
        if text is None:
            yield Check("works", f"mitsuba {name}", CheckState.NOTE, f"timed out after {_TEST_SECONDS:g} seconds")
        elif text.strip() == "True":
            yield Check("works", f"mitsuba {name}", CheckState.OK, "renders an image")
        elif name == "scalar":
            yield Check(
                "works", "mitsuba scalar", CheckState.BROKEN, "cannot render", "pip install --force-reinstall mitsuba"
            )
        else:
            what = "LLVM not found (Debian: libllvm19)" if name == "llvm" else "cannot render on this GPU"
            yield Check("works", f"mitsuba {name}", CheckState.NOTE, f"{what}; `scalar` works without it")


# --- machine: Python, folders, terminal, browser, GPU ----------------------------------------------------------------


_BROWSERS = ("firefox", "chromium", "chromium-browser", "google-chrome", "microsoft-edge", "safari", "brave-browser")
_IMAGE_TERMINALS = ("iTerm.app", "WezTerm", "ghostty", "kitty")
_GPU_SECONDS = 2.0  # timeout of nvidia-smi


def system_checks() -> Iterator[Check]:
    """Report versions and the location of the installation."""
    yield Check("system", "scenelang", CheckState.OK, version_of("scenelang") or "source checkout")
    yield Check("system", "Python", CheckState.OK, f"{platform.python_version()}, {sys.executable}")
    cores = os.cpu_count() or 1
    yield Check("system", "platform", CheckState.OK, f"{platform.platform()}, {platform.machine()}, {cores} cores")
    yield _gpu()


def limit_checks() -> Iterator[Check]:
    """Report how programs are confined: resource limits, file access and system calls."""
    from scenelang.sandbox.confinement import has_seccomp, landlock_version
    from scenelang.sandbox.supervision import is_supported

    if is_supported():
        yield Check("limits", "processes", CheckState.OK, "hard limits: programs are evaluated in separate processes")
    else:
        detail = "soft limits only: hard limits require Linux 5.4 or newer"
        yield Check("limits", "processes", CheckState.NOTE, detail)
    version = landlock_version()
    files = (
        f"Landlock {version}: evaluation may only read the project"
        if version
        else "Landlock is not supported by this kernel"
    )
    yield Check("limits", "files", CheckState.OK if version else CheckState.NOTE, files)
    calls = "seccomp: no sockets, no other programs" if has_seccomp() else "seccomp is not supported by this system"
    yield Check("limits", "calls", CheckState.OK if has_seccomp() else CheckState.NOTE, calls)


def folder_checks() -> Iterator[Check]:
    """Check the user's folders for caches and settings."""
    home = Path(os.path.expanduser("~"))
    for name, variable, default in (
        ("cache", "XDG_CACHE_HOME", home / ".cache"),
        ("settings", "XDG_CONFIG_HOME", home / ".config"),
    ):
        folder = Path(os.environ.get(variable) or default) / "scenelang"
        if _is_writable(folder):
            yield Check("folders", name, CheckState.OK, str(folder))
        else:
            yield Check("folders", name, CheckState.MISSING, f"{folder} is not writable", f"set {variable} to a folder")


def _is_writable(folder: Path) -> bool:
    """Return whether files can be created in a folder, or the folder itself if it does not exist."""
    try:
        existing = next(parent for parent in (folder, *folder.parents) if parent.exists())
        with tempfile.TemporaryFile(dir=existing):
            return True
    except (OSError, StopIteration):
        return False


def terminal_checks() -> Iterator[Check]:
    """Report the capabilities of the terminal, and whether a browser is available for the viewer."""
    if sys.stdout.isatty():
        size = shutil.get_terminal_size()
        colors = "no colors" if "NO_COLOR" in os.environ else _colors()
        yield Check("terminal", "output", CheckState.OK, f"a terminal of {size.columns}x{size.lines}, {colors}")
    else:
        yield Check("terminal", "output", CheckState.NOTE, "no terminal")
    yield Check("terminal", "text", CheckState.OK, f"{sys.stdout.encoding}, TERM={os.environ.get('TERM', '')}")
    shown = _shows_images()
    yield Check(
        "terminal", "pictures", CheckState.OK if shown else CheckState.NOTE, "inline" if shown else "no inline images"
    )
    yield _browser()


def _colors() -> str:
    """Describe the number of colors of the terminal."""
    if os.environ.get("COLORTERM") in ("truecolor", "24bit"):
        return "24-bit color"
    return "256 colors" if "256" in os.environ.get("TERM", "") else "colors"


def _shows_images() -> bool:
    """Return whether the terminal shows inline images."""
    program = os.environ.get("TERM_PROGRAM", "")
    return program in _IMAGE_TERMINALS or "kitty" in os.environ.get("TERM", "") or "KITTY_WINDOW_ID" in os.environ


def _browser() -> Check:
    """Find a browser for the viewer."""
    browser = next((path for name in _BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        try:
            browser = getattr(webbrowser.get(), "name", "the system's own")
        except webbrowser.Error:
            detail = "no browser found; `scenelang view --html FILE` writes a page to open elsewhere"
            return Check("terminal", "browser", CheckState.MISSING, detail)
    return Check("terminal", "browser", CheckState.OK, str(browser))


def _gpu() -> Check:
    """List the NVIDIA GPUs."""
    tool = shutil.which("nvidia-smi")
    if tool is None:
        return Check("system", "GPU", CheckState.NOTE, "no NVIDIA GPU found (optional)")
    try:
        # no shell: a fixed program with a list of arguments
        done = subprocess.run([tool, "-L"], capture_output=True, text=True, timeout=_GPU_SECONDS)  # noqa: S603  # nosec B603
    except (OSError, subprocess.SubprocessError):
        return Check("system", "GPU", CheckState.NOTE, "the NVIDIA driver does not respond (optional)")
    cards = [line.partition(" (UUID")[0] for line in done.stdout.splitlines() if line.startswith("GPU")]
    if done.returncode != 0 or not cards:
        return Check("system", "GPU", CheckState.NOTE, "the NVIDIA driver finds no GPU (optional)")
    return Check("system", "GPU", CheckState.OK, ", ".join(cards))


# --- services: API keys of the language model providers; nothing is sent ---------------------------------------------


def service_checks() -> Iterator[Check]:
    """Report the address of each provider, and whether an API key is configured."""
    if not is_present("scenelang.backends.language_models"):
        return
    from scenelang.backends.language_models.provider import PROVIDERS, account_of

    for family in PROVIDERS.all():
        try:
            account = account_of(family)
        except SceneError as error:
            yield Check("services", family.name, CheckState.MISSING, error.message, error.hint or "")
            continue
        key = "API key found" if account.key is not None else "no API key"
        yield Check("services", family.name, CheckState.NOTE, f"{key} for {account.public_address}; not contacted")


# --- report ----------------------------------------------------------------------------------------------------------


_TITLES = {
    "system": "System",
    "works": "Features",
    "packages": "Packages",
    "extras": "Extras",
    "services": "Services",
    "folders": "Folders",
    "terminal": "Terminal and browser",
}
_MARKS = {"ok": "ok", "note": "--", "missing": "no", "broken": "BROKEN"}
_STATES = {"ok": "32", "note": "0", "missing": "33", "broken": "1;31"}


def report_lines(results: Sequence[Check], color: bool) -> Iterator[str]:
    """Format the results by topic, with commands that install what is missing."""
    width = max(len(check.name) for check in results)
    for topic, title in _TITLES.items():
        of_topic = [check for check in results if check.topic == topic]
        if of_topic:
            yield title
            yield from (_line_of(check, width, color=color) for check in of_topic)
    broken = sum(check.state.value == "broken" for check in results)
    remedies = list(dict.fromkeys(check.remedy for check in results if check.remedy.startswith(("pip ", "pipx "))))
    yield ""
    yield f"{broken} broken." if broken else "All required features work."
    if remedies:
        yield "To install missing features:"
        yield from (f"  {remedy}" for remedy in remedies)


def _line_of(check: Check, width: int, *, color: bool) -> str:
    """Format one result."""
    mark = colored(_MARKS[check.state.value], _STATES[check.state.value] if color else None)
    remedy = f"; {check.remedy}" if check.remedy else ""
    return f"  {mark} {' ' * max(0, 2 - len(_MARKS[check.state.value]))}{check.name:<{width}}  {check.detail}{remedy}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
