"""Draws the pictures of the gallery, docs/gallery/*.png, from the examples: ``python docs/gallery.py [NAME ...]``."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
GALLERY = DOCS / "gallery"
SIZE = (320, 240)
LARGEST = 60_000  # bytes of one picture
OVERSAMPLING = 2

# The options of `scenelang render` by picture: example, camera, further options.
PICTURES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "paper-chessboard": ("paper/chessboard", "azimuth=205,elevation=32", ()),
    "chessboard": ("chessboard", "azimuth=28,elevation=26", ("--quality", "final")),
    "moai": ("moai", "azimuth=20,elevation=9", ("--quality", "final")),
    "spiral-staircase": ("spiral-staircase", "azimuth=30,elevation=18", ("--quality", "final")),
    "jenga": ("jenga", "azimuth=32,elevation=20", ("--quality", "final")),
    "fractal-tree": ("fractal-tree", "azimuth=30,elevation=16", ("--quality", "final")),
    "menger-sponge": ("menger-sponge", "azimuth=32,elevation=26", ("--quality", "final")),
    "nesting-dolls": ("nesting-dolls", "azimuth=10,elevation=12", ("--quality", "final")),
    "orrery": ("orrery", "azimuth=20,elevation=22", ("--quality", "final", "--frame", "2")),
    "strict": ("strict", "azimuth=30,elevation=14", ("--quality", "final")),
    "macros": ("macros", "azimuth=28,elevation=24", ("--quality", "final")),
    "words": ("words", "azimuth=25,elevation=24", ()),
    "combinators": ("combinators", "azimuth=20,elevation=28", ("--quality", "final")),
}


def draw(name: str) -> int:
    """Draw one picture at twice its size, shrink it and save it with as many colours as fit; gives its bytes."""
    example, camera, options = PICTURES[name]
    width, height = (OVERSAMPLING * side for side in SIZE)
    target = GALLERY / f"{name}.png"
    with tempfile.TemporaryDirectory() as folder:
        large = Path(folder) / "large.png"
        command = [sys.executable, "-P", "-m", "scenelang.cli.main", "render", str(EXAMPLES / f"{example}.scene")]
        command += ["-o", str(large), "--size", f"{width}x{height}", "--camera", camera, "-q", *options]
        subprocess.run(command, check=True)
        small = Image.open(large).convert("RGB").resize(SIZE, Image.Resampling.LANCZOS)
    for colors in (256, 192, 128, 96, 64):
        small.quantize(colors, Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG).save(target, optimize=True)
        if target.stat().st_size <= LARGEST:
            break
    return target.stat().st_size


def main(names: list[str]) -> int:
    """Draw the pictures named, or all of them."""
    unknown = [name for name in names if name not in PICTURES]
    if unknown:
        print(f"no such picture: {', '.join(unknown)}; there are {', '.join(PICTURES)}", file=sys.stderr)
        return 2
    GALLERY.mkdir(exist_ok=True)
    for name in names or PICTURES:
        print(f"{name}: {draw(name):,} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
