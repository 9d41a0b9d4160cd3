"""Images of the cookbook: each program that an image follows is drawn."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from generator.pictures import drawn, save
from generator.tutorial import Step, steps

COOKBOOK = Path(__file__).parents[1] / "cookbook"
SIZE = (320, 240)


def recipes(folder: Path = COOKBOOK) -> Iterator[Step]:
    """The illustrated programs of all pages of the cookbook; images are relative to ``folder``."""
    for page in sorted(folder.glob("*.md")):
        yield from steps(page)


def save_recipe_images(folder: Path) -> None:
    """Draw the images of all recipes into a folder, or keep those that show the same."""
    for recipe in recipes():
        save(drawn(recipe.program, SIZE, recipe.camera, recipe.frame), folder / recipe.picture)
