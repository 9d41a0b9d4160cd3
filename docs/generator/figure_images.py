"""The images of the page about publication figures: each is what the commands of the block above it write."""

from __future__ import annotations

import re
import shlex
import tempfile
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path

from PIL import Image

from generator.pictures import difference
from scenelang.cli.main import main

DOCS = Path(__file__).parents[1]
_EXAMPLES = DOCS.parent / "examples"
_BLOCK = re.compile(r"^```sh\n(?P<commands>.*?)^```\n\n!\[[^\]]*\]\((?P<image>figures/[\w-]+\.png)\)", re.M | re.S)


def figure_blocks() -> Iterator[tuple[list[str], str]]:
    """The commands of each figure, and the path of its image in the folder of documents."""
    text = (DOCS / "figures.md").read_text("utf-8")
    for found in _BLOCK.finditer(text):
        yield found["commands"].splitlines(), found["image"]


def save_figure_images(folder: Path) -> None:
    """Draw all figures into ``folder``, except those that are there and show the same."""
    with tempfile.TemporaryDirectory() as name, chdir(name):
        Path("examples").symlink_to(_EXAMPLES)
        for commands, image in figure_blocks():
            for command in commands:
                if main([*shlex.split(command)[1:], "--quiet"]) != 0:
                    raise ValueError(f"{command} failed")
            with Image.open(Path(image).name) as drawn:
                _save(drawn.convert("RGB"), folder / image)


def _save(picture: Image.Image, path: Path) -> None:
    """Write a picture in all of its colors, unless the one that is there shows the same."""
    if path.exists() and difference(picture, path) < 1:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.save(path, optimize=True)


if __name__ == "__main__":
    save_figure_images(DOCS)
