"""What the tests of pictures with the game's looks share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from deepslate.packs import pack_files, write_zip


@pytest.fixture(autouse=True)
def nowhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """No game of the machine's own gets into a test, but those in a browser."""
    if request.node.get_closest_marker("browser") is not None:
        return
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.delenv("SCENELANG_MINECRAFT", raising=False)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("APPDATA", str(home))
    monkeypatch.setattr("sys.platform", "linux" if os.name != "nt" else "win32")
    monkeypatch.chdir(home)


@pytest.fixture
def pack(tmp_path: Path) -> Path:
    return write_zip(tmp_path / "pack.zip", pack_files())
