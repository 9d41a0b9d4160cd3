"""The machine: Python, folders, terminal, browser, GPU."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import webbrowser
from collections.abc import Iterator
from pathlib import Path

from scenelang.doctor.check import Check, State
from scenelang.doctor.packages import version_of

_BROWSERS = ("firefox", "chromium", "chromium-browser", "google-chrome", "microsoft-edge", "safari", "brave-browser")
_IMAGE_TERMINALS = ("iTerm.app", "WezTerm", "ghostty", "kitty")
_PATIENCE = 2.0  # seconds, for a driver's tool


def system_checks() -> Iterator[Check]:
    """Versions, and where the program stands."""
    yield Check("system", "scenelang", State.OK, version_of("scenelang") or "from its sources")
    yield Check("system", "Python", State.OK, f"{platform.python_version()}, {sys.executable}")
    cores = os.cpu_count() or 1
    yield Check("system", "platform", State.OK, f"{platform.platform()}, {platform.machine()}, {cores} cores")
    yield _gpu()


def limit_checks() -> Iterator[Check]:
    """What holds programs within their limits, and away from files and the network."""
    from scenelang.sandbox.confinement import has_seccomp, landlock_version
    from scenelang.sandbox.supervision import is_supported

    if is_supported():
        yield Check("limits", "processes", State.OK, "programs are evaluated in processes that can be ended")
    else:
        detail = "only soft limits, which a builtin may overrun: ending processes needs Linux 5.4 or newer"
        yield Check("limits", "processes", State.NOTE, detail)
    version = landlock_version()
    files = f"Landlock {version}: evaluation may only read the project" if version else "this kernel has no Landlock"
    yield Check("limits", "files", State.OK if version else State.NOTE, files)
    calls = "seccomp: no sockets, no other programs" if has_seccomp() else "no seccomp on this system"
    yield Check("limits", "calls", State.OK if has_seccomp() else State.NOTE, calls)


def folder_checks() -> Iterator[Check]:
    """The user's folders for caches and settings."""
    home = Path(os.path.expanduser("~"))
    for name, variable, default in (
        ("cache", "XDG_CACHE_HOME", home / ".cache"),
        ("settings", "XDG_CONFIG_HOME", home / ".config"),
    ):
        folder = Path(os.environ.get(variable) or default) / "scenelang"
        if _is_writable(folder):
            yield Check("folders", name, State.OK, str(folder))
        else:
            yield Check("folders", name, State.MISSING, f"{folder} cannot be written", f"set {variable} to a folder")


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
        yield Check("terminal", "output", State.OK, f"a terminal of {size.columns}x{size.lines}, {colors}")
    else:
        yield Check("terminal", "output", State.NOTE, "no terminal")
    yield Check("terminal", "text", State.OK, f"{sys.stdout.encoding}, TERM={os.environ.get('TERM', '')}")
    shown = _shows_images()
    yield Check("terminal", "pictures", State.OK if shown else State.NOTE, "inline" if shown else "not shown inline")
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
            return Check("terminal", "browser", State.MISSING, detail)
    return Check("terminal", "browser", State.OK, str(found))


def _gpu() -> Check:
    tool = shutil.which("nvidia-smi")
    if tool is None:
        return Check("system", "GPU", State.NOTE, "no NVIDIA GPU found; nothing needs one")
    try:
        # a list of words, no shell: our interpreter or a program by its own name
        done = subprocess.run([tool, "-L"], capture_output=True, text=True, timeout=_PATIENCE)  # noqa: S603  # nosec B603
    except (OSError, subprocess.SubprocessError):
        return Check("system", "GPU", State.NOTE, "its driver does not answer; nothing needs one")
    cards = [line.partition(" (UUID")[0] for line in done.stdout.splitlines() if line.startswith("GPU")]
    if done.returncode != 0 or not cards:
        return Check("system", "GPU", State.NOTE, "its driver finds none; nothing needs one")
    return Check("system", "GPU", State.OK, ", ".join(cards))
