"""Makes the gallery, docs/gallery.md and docs/gallery/*, from the examples: ``python docs/gallery.py [NAME ...]``.

Every example is path traced, and turned once round in a draft video; a 4D one plays its frames.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
GALLERY = DOCS / "gallery"
SIZE = "640x480"
FILM = "240x180"
FILM_FRAMES = 24
COLUMNS = 2
QUALITY = 88  # percent, of JPEG: 30 to 90 KB an image in all its colors

# What is shown, the most telling first: example, camera, the frame of a 4D example that stands for it.
SHOWN: dict[str, tuple[str, str, int | None]] = {
    "water-mill": ("water-mill", "azimuth=35,elevation=25", None),
    "chessboard": ("chessboard", "azimuth=28,elevation=26", None),
    "toys": ("toys", "azimuth=20,elevation=18", None),
    "materials": ("materials", "azimuth=14,elevation=32", None),
    "orrery": ("orrery", "azimuth=20,elevation=22", 2),
    "still-life": ("still-life", "main", None),
    "dolly": ("dolly", "dolly", 14),
    "nesting-dolls": ("nesting-dolls", "azimuth=10,elevation=12", None),
    "making-mug": ("making/mug", "azimuth=-25,elevation=30", None),
    "spiral-staircase": ("spiral-staircase", "azimuth=30,elevation=18", None),
    "fractal-tree": ("fractal-tree", "azimuth=30,elevation=16", None),
    "making-chess-king": ("making/chess-king", "azimuth=20,elevation=14", None),
    "moai": ("moai", "azimuth=20,elevation=9", None),
    "making-gear-pair": ("making/gear-pair", "azimuth=25,elevation=40", None),
    "jenga": ("jenga", "azimuth=32,elevation=20", None),
    "making-lamp": ("making/lamp", "azimuth=20,elevation=14", None),
    "making-terrain": ("making/terrain", "azimuth=25,elevation=35", None),
    "making-bracket": ("making/bracket", "azimuth=40,elevation=26", None),
    "datasets-clevr": ("datasets/clevr", "azimuth=25,elevation=30", None),
    "menger-sponge": ("menger-sponge", "azimuth=32,elevation=26", None),
    "making-vase": ("making/vase", "azimuth=20,elevation=20", None),
    "making-chair": ("making/chair", "azimuth=28,elevation=18", None),
    "making-bottle": ("making/bottle", "azimuth=25,elevation=16", None),
    "making-name-plate": ("making/name-plate", "azimuth=15,elevation=20", None),
    "words": ("words", "azimuth=25,elevation=24", None),
    "combinators": ("combinators", "azimuth=20,elevation=28", None),
    "macros": ("macros", "azimuth=28,elevation=24", None),
    "strict": ("strict", "azimuth=30,elevation=14", None),
    "paper-chessboard": ("paper/chessboard", "azimuth=205,elevation=32", None),
}


def title(example: str) -> str:
    """Return the heading of an example: the words of its name, without its folder.

    >>> title("making/gear-pair"), title("water-mill")
    ('Gear pair', 'Water mill')
    """
    name = example.rpartition("/")[2].replace("-", " ")
    return f"{name.capitalize()} of the paper" if example.startswith("paper/") else name.capitalize()


def scenelang(command: str, example: str, output: Path, *options: str) -> None:
    """One run of the command line."""
    start = [sys.executable, "-P", "-m", "scenelang", command, str(EXAMPLES / f"{example}.scene")]
    subprocess.run([*start, "-o", str(output), "-q", *options], check=True)


def draw(name: str) -> int:
    """Draw the image and the video of one example; gives their bytes."""
    example, camera, frame = SHOWN[name]
    chosen = ["--camera", camera, *(["--frame", str(frame)] if frame is not None else [])]
    image, film = GALLERY / f"{name}.jpg", GALLERY / f"{name}.webp"
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / "image.png"
        scenelang("render", example, drawn, "--size", SIZE, "--quality", "final", *chosen)
        Image.open(drawn).convert("RGB").save(image, quality=QUALITY, optimize=True)
    frames = ["--frames", str(FILM_FRAMES)]
    scenelang("render", example, film, "--size", FILM, "--camera", camera, "--fps", "12", *frames)
    return image.stat().st_size + film.stat().st_size


def page() -> str:
    """The text of docs/gallery.md: a grid of the images, each with its program and its video."""
    cells = []
    for name, (example, _, _) in SHOWN.items():
        label = title(example)
        links = f"[{label}](../examples/{example}.scene) · [video](gallery/{name}.webp)"
        cells.append(f"![{label}](gallery/{name}.jpg)<br>{links}")
    cells += [""] * (-len(cells) % COLUMNS)
    rows = [f"| {' | '.join(cells[i : i + COLUMNS])} |" for i in range(0, len(cells), COLUMNS)]
    return "\n".join([
        "# Gallery",
        "",
        "Every example in the language, path traced (`--quality final`), and as a draft video: `make gallery` "
        "draws them.",
        "A name leads to its program.",
        "",
        "|  " * COLUMNS + "|",
        "|---" * COLUMNS + "|",
        *rows,
        "",
    ])  # fmt: skip


def main(names: list[str]) -> int:
    """Draw the examples named, or all of them, and write the page."""
    unknown = [name for name in names if name not in SHOWN]
    if unknown:
        print(f"no such example: {', '.join(unknown)}; there are {', '.join(SHOWN)}", file=sys.stderr)
        return 2
    GALLERY.mkdir(exist_ok=True)
    for name in names or SHOWN:
        print(f"{name}: {draw(name):,} bytes", flush=True)
    (DOCS / "gallery.md").write_text(page())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
