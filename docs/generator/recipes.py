"""The cookbook: its page of all recipes, and the images that their programs draw."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from generator.markdown import NOTICE, anchor
from generator.pictures import drawn, save
from generator.tutorial import Step, steps

COOKBOOK = Path(__file__).parents[1] / "cookbook"
SIZE = (320, 240)
_CHAPTERS = ("modeling", "rooms", "appearance", "films", "data")
_COLUMNS = 4
_RECIPE = re.compile(r"^## (?P<task>.*?)$.*?^!\[(?P<caption>[^\]]*)\]\((?P<image>[^)\s]+)", re.M | re.S)
_START = """
Recipes by task. Each has a program that runs as it is, the image that it draws, and what to change. Where commands
follow, the first comment is the name of the file, such as `; door.scene`.
""".strip()
_END = """
More programs are in the [gallery](gallery.md), and everyday objects in [parts](parts.md). If you come from
[OpenSCAD](from-openscad.md), [CadQuery](from-cadquery.md), [Blender](from-blender.md), [trimesh](from-trimesh.md),
[Three.js](from-threejs.md) or [the authors' Python](from-paper-python.md), there is a page with a table of
correspondences.
""".strip()


def recipes(folder: Path = COOKBOOK) -> Iterator[Step]:
    """The illustrated programs of all chapters; the paths of their images are relative to the cookbook's folder."""
    for chapter in _CHAPTERS:
        yield from steps(folder / f"{chapter}.md")


def save_recipe_images(folder: Path) -> None:
    """Draw the images of all recipes into a folder, except those that are there and show the same."""
    for recipe in recipes():
        save(drawn(recipe.program, SIZE, recipe.camera, recipe.frame), folder / recipe.picture)


def cookbook_page() -> str:
    """The page that shows every recipe by its image, Markdown."""
    lines = ["# Cookbook", "", NOTICE, "", _START, ""]
    for chapter in _CHAPTERS:
        lines += [*_chapter(chapter, (COOKBOOK / f"{chapter}.md").read_text("utf-8")), ""]
    return "\n".join([*lines, _END]) + "\n"


def _chapter(name: str, text: str) -> Iterator[str]:
    """A heading, and a table of the recipes of a chapter."""
    cells = [_cell(name, recipe) for recipe in _RECIPE.finditer(text)]
    title = text.partition("\n")[0].removeprefix("# ")
    yield from (f"## {title}", "", "| " * _COLUMNS + "|", "|---" * _COLUMNS + "|")
    for start in range(0, len(cells), _COLUMNS):
        row = cells[start : start + _COLUMNS]
        yield f"| {' | '.join([*row, *[''] * (_COLUMNS - len(row))])} |"


def _cell(chapter: str, recipe: re.Match[str]) -> str:
    """The image of a recipe above a link to it."""
    image = f"![{recipe['caption']}](cookbook/{recipe['image']})"
    return f"{image}<br>[{recipe['task']}](cookbook/{chapter}.md#{anchor(recipe['task'])})"
