"""The pictures of the tutorial: every program in it that a picture follows is drawn."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

_STEP = re.compile(r'^```scene\n(.*?)^```\n\n!\[[^\]]*\]\(([^)\s]+)(?: "([^"]*)")?\)$', re.M | re.S)
_CAMERA = "azimuth=30,elevation=16"


@dataclass(frozen=True, slots=True)
class Step:
    """A program of the tutorial; ``picture`` is relative to the page, ``frame`` the one drawn of a 4D scene."""

    program: str
    picture: str
    camera: str
    frame: int | None


def steps(page: Path) -> Iterator[Step]:
    """The programs of a page that a picture follows.

    The picture's title may have ``frame N``, and parameters of a camera or ``camera NAME`` of the program.
    """
    for match in _STEP.finditer(page.read_text("utf-8")):
        words = (match[3] or "").split()
        frame = int(words.pop(words.index("frame") + 1)) if "frame" in words else None
        named = words[words.index("camera") + 1 :][:1] if "camera" in words else []
        cameras = named or [word for word in words if "=" in word]
        yield Step(match[1], match[2], cameras[0] if cameras else _CAMERA, frame)
