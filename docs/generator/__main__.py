"""``cd docs && python -m generator [FOLDER]``: writes the reference, and draws its pictures and those of the tutorial
and the cookbook, into this folder of documents or another."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from generator.architecture import architecture_svg
from generator.cheat_sheet import cheat_sheet_page
from generator.cli_page import cli_page
from generator.diagnostics_page import diagnostics_page
from generator.figure_images import save_figure_images
from generator.install_page import install_page
from generator.library_page import PICTURES, forms_page, library_pages, picture_program, relations_page
from generator.parts_page import parts_page, picture_path
from generator.performance_page import performance_page
from generator.pictures import drawn, save
from generator.recipes import cookbook_page, save_recipe_images
from generator.tolerances_page import tolerances_page
from generator.tutorial import steps
from scenelang.interpreter.scene.declarations import RELATIONS, example_of
from scenelang.stdlib.reference import RecordKind, parts, records

DOCS = Path(__file__).parents[1]
PAGES = {
    "reference/forms.md": forms_page,
    "reference/relations.md": relations_page,
    "reference/diagnostics.md": diagnostics_page,
    "reference/tolerances.md": tolerances_page,
    "reference/cli.md": cli_page,
    "cheat-sheet.md": cheat_sheet_page,
    "install.md": install_page,
    "cookbook.md": cookbook_page,
    "parts.md": parts_page,
    "performance.md": performance_page,
    "architecture.svg": architecture_svg,
    **{f"reference/{name}": page for name, page in library_pages().items()},
}
SMALL = (160, 120)
PART = (240, 180)
CAMERA = "azimuth=28,elevation=24"
TUTORIAL = (360, 270)


def pages() -> Iterator[tuple[str, str]]:
    """Yield the file names of all generated pages, relative to the folder of documents, and their texts."""
    yield from ((name, page()) for name, page in PAGES.items())


def main(folder: Path = DOCS) -> int:
    """Write every page and picture."""
    for name, text in pages():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    for record in records():
        if record.picture is not None and record.kind is not RecordKind.PART:
            save(drawn(picture_program(record), SMALL, CAMERA), folder / "reference" / PICTURES / f"{record.name}.png")
    for relation in RELATIONS.values():
        save(
            drawn(example_of(relation), SMALL, CAMERA),
            folder / "reference" / PICTURES / f"relation-{relation.name}.png",
        )
    for part in parts():
        save(drawn(picture_program(part.record), PART, CAMERA), folder / picture_path(part))
    for step in steps(DOCS / "tutorial.md"):
        save(drawn(step.program, TUTORIAL, step.camera, step.frame), folder / step.picture)
    save_recipe_images(folder / "cookbook")
    save_figure_images(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:2])))
