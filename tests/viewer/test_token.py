"""The token of the viewer's addresses is no argument of any process: the browser is given a private file that leads
there. Without a browser the address is printed, and nothing else happens."""

from __future__ import annotations

import html
import os
import re
import signal
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from urllib.parse import urlsplit
from urllib.request import url2pathname, urlopen

import pytest
from support import PATIENCE, below, wait_until

from scenelang.backends.viewer import packet

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="modes of files")
PROGRAM = '(bind "a" (lambda () (call "cube")))\n'
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


class View:
    """The command ``view``: its folders, and a browser that writes its arguments to a file."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.cache, self.record = folder, folder / "cache", folder / "arguments.txt"
        self.program, self.browser = folder / "a.scene", folder / "browser"
        self.program.write_text(PROGRAM)
        self.browser.write_text(
            f'#!/bin/sh\nprintf "%s\\n" "$@" >> "{self.record}.part"\nmv "{self.record}.part" "{self.record}"\n'
        )
        self.browser.chmod(0o755)

    @contextmanager
    def run(self, *options: str, umask: int = 0o022, **more: str) -> Iterator[tuple[Popen[str], str]]:
        """The process and the address that it prints; interrupted at the end of the block."""
        environment = {k: v for k, v in os.environ.items() if k not in SCREENS} | {
            "XDG_CACHE_HOME": str(self.cache),
            **more,
        }
        words = [sys.executable, "-P", "-m", "scenelang", "view", str(self.program), *options]

        def prepare() -> None:
            os.umask(umask)
            signal.signal(signal.SIGINT, signal.default_int_handler)

        with Popen(
            words, env=environment, stdin=DEVNULL, stdout=PIPE, stderr=PIPE, text=True, preexec_fn=prepare
        ) as process:
            assert process.stdout is not None
            try:
                yield process, process.stdout.readline().strip()
                process.send_signal(signal.SIGINT)
                _, said = process.communicate(timeout=PATIENCE)
                assert "Traceback" not in said
                assert process.returncode in (0, 130)
            finally:
                process.kill()

    def opened(self) -> Path:
        """The file that the browser is given."""
        wait_until(self.record.exists)
        (argument,) = self.record.read_text().splitlines()
        assert argument.startswith("file://")
        return Path(url2pathname(urlsplit(argument).path))

    def pages(self) -> list[Path]:
        return list(self.folder.rglob("view-*.html"))


@pytest.fixture
def view(tmp_path: Path) -> View:
    return View(tmp_path)


def token_of(address: str) -> str:
    found = re.fullmatch(r"http://127\.0\.0\.1:\d+/([\w-]{16,})/", address)
    assert found is not None, address
    return found[1]


def arguments_of_all() -> bytes:
    """The arguments of all processes of this machine."""
    found = b""
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            found += path.read_bytes()
        except OSError:
            pass
    return found


def target_of(page: Path) -> str:
    (found,) = re.findall(r'http-equiv="refresh" content="0;url=([^"]*)"', page.read_text("utf-8"))
    return html.unescape(found)


@pytest.mark.parametrize("umask", [0o000, 0o022, 0o077])
def test_the_browser_gets_a_private_file_that_leads_to_the_page(view: View, umask: int) -> None:
    with view.run(umask=umask, BROWSER=str(view.browser)) as (process, address):
        token = token_of(address)
        page = view.opened()
        assert page.is_relative_to(view.cache)
        assert stat.S_IMODE(page.stat().st_mode) == 0o600
        assert page.stat().st_uid == os.getuid()
        assert not page.is_symlink()
        assert token not in str(page)
        assert token not in view.record.read_text()
        assert target_of(page) == address
        with urlopen(target_of(page), timeout=PATIENCE) as answer:
            assert b"viewer.js" in answer.read()
        if Path("/proc/self/cmdline").exists():
            assert token.encode() not in arguments_of_all()
            for each in [process.pid, *below(process.pid)]:
                assert token.encode() not in Path(f"/proc/{each}/environ").read_bytes()
    assert view.pages() == []


def test_each_view_has_its_own_token_and_file(view: View) -> None:
    with view.run(BROWSER=str(view.browser)) as (_, one):
        first = view.opened()
        view.record.unlink()
        with view.run(BROWSER=str(view.browser)) as (_, other):
            assert view.opened() != first
            assert token_of(one) != token_of(other)
            assert len(view.pages()) == 2
        assert view.pages() == [first]


@pytest.mark.parametrize(
    ("options", "more"),
    [([], {}), (["--no-browser"], {"BROWSER": "{}"}), (["--no-browser"], {"DISPLAY": ":0"}), (["-q"], {"DISPLAY": ""})],
)
def test_without_a_browser_the_address_is_printed_and_nothing_opened(
    view: View, options: list[str], more: dict[str, str]
) -> None:
    with view.run(*options, **{name: each.format(view.browser) for name, each in more.items()}) as (_, address):
        token_of(address)
        with urlopen(address, timeout=PATIENCE) as answer:
            assert answer.status == 200
        assert view.pages() == []
    assert not view.record.exists()


def test_a_cache_that_cannot_be_written_opens_nothing(view: View) -> None:
    view.cache.write_text("no folder")
    with view.run(BROWSER=str(view.browser)) as (_, address):
        token_of(address)
        with urlopen(address, timeout=PATIENCE) as answer:
            assert answer.status == 200
    assert not view.record.exists()


def test_a_page_in_a_file_opens_no_browser(view: View) -> None:
    page = view.folder / "page.html"
    with view.run("--html", str(page), BROWSER=str(view.browser)) as (process, _):
        process.wait(PATIENCE)
    assert page.exists()
    assert not view.record.exists()


@pytest.mark.parametrize("address", ["http://127.0.0.1:5/secret-token/", "http://127.0.0.1:5/a\"b<c>&d'/"])
def test_what_is_opened_says_nothing_of_the_address(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda url, *_: opened.append(url))
    assert packet.open_in_browser(address)
    (url,) = opened
    assert urlsplit(address).path.strip("/") not in url
    page = Path(url2pathname(urlsplit(url).path))
    assert target_of(page) == address
    assert stat.S_IMODE(page.stat().st_mode) == 0o600
    page.unlink()


def test_a_page_without_a_token_is_opened_itself(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    opened: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("webbrowser.open", lambda url, *_: opened.append(url))
    assert packet.open_in_browser("file:///tmp/build.html")
    assert opened == ["file:///tmp/build.html"]
    assert list(tmp_path.iterdir()) == []
