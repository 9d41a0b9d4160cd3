"""Replies kept on disk, so that the same question is not paid for twice; safe for processes side by side.

A reply is kept under a digest of all that was sent and of the numbers of sample and attempt, so that samples differ. A
lock per question makes a second process wait for the first one's answer.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from scenelang.backends.files import user_folder, written_whole
from scenelang.backends.language_models.conversation import Reply, Stop, Usage
from scenelang.grammar.diagnostics import SceneError

_PRIVATE = 0o600


def reply_folder() -> Path:
    """Where replies are kept."""
    return user_folder("CACHE") / "replies"


def digest(*facts: Any) -> str:
    """A name for what was asked."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def reply_data(reply: Reply) -> dict[str, Any]:
    """A reply as JSON data, without what only continues a conversation."""
    return {
        "text": reply.text,
        "stop": reply.stop.value,
        "usage": asdict(reply.usage),
        "model": reply.model,
        "note": reply.note,
    }


def reply_of(data: Mapping[str, Any]) -> Reply:
    """The inverse of ``reply_data``; raises KeyError, TypeError or ValueError for other data."""
    usage = Usage(**{name: int(number) for name, number in data["usage"].items()})
    return Reply(str(data["text"]), Stop(data["stop"]), usage, str(data["model"]), str(data["note"]))


class Replies:
    """Replies in a folder that only its owner can read."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def find(self, key: str) -> Reply | None:
        """The reply that is kept under a digest; one that cannot be read counts as none."""
        try:
            return reply_of(json.loads(self._path(key).read_text("utf-8")))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
            return None

    def keep(self, key: str, reply: Reply) -> None:
        """Keep a complete reply. Where the folder cannot be written nothing is kept."""
        if reply.stop is not Stop.END:
            return
        try:
            self._make_folder()
            with written_whole(self._path(key), mode=_PRIVATE) as temporary:
                temporary.write_text(json.dumps(reply_data(reply)), "utf-8")
        except (SceneError, OSError):
            return

    @contextmanager
    def asking(self, key: str) -> Iterator[None]:
        """Only one process asks a question at a time; without locks on this system they ask side by side."""
        path = self._path(key).with_suffix(".lock")
        try:
            self._make_folder()
            file = _locked(path)
        except (ImportError, OSError):
            yield
            return
        try:
            yield
        finally:
            path.unlink(missing_ok=True)
            os.close(file)  # lets go of the lock too

    def _make_folder(self) -> None:
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def _path(self, key: str) -> Path:
        return self._folder / f"{key}.json"


def _locked(path: Path) -> int:
    """A file that this process holds alone, as a descriptor. Raises ImportError or OSError where there are no locks."""
    import fcntl

    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT, _PRIVATE)
        try:
            fcntl.flock(file, fcntl.LOCK_EX)
            if os.path.samestat(os.fstat(file), path.stat()):
                return file
        except FileNotFoundError:
            pass
        except OSError:
            os.close(file)
            raise
        os.close(file)  # whoever held it before took it away
