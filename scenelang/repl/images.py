"""Pictures in the terminal: iTerm2's protocol, kitty's, sixel; each an escape sequence that a terminal may know."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any

from scenelang.backends.base import need

_CHUNK = 4096
_SIXEL_COLORS = 128


class Protocol(Enum):
    ITERM = "iterm2"
    KITTY = "kitty"
    SIXEL = "sixel"


def protocol_of(environment: Mapping[str, str]) -> Protocol | None:
    """What the terminal of an environment can show; ``SCENELANG_IMAGES`` says it (a name, or ``none``)."""
    said = environment.get("SCENELANG_IMAGES")
    if said is not None:
        return next((p for p in Protocol if p.value == said), None)
    if "TMUX" in environment or environment.get("TERM", "").startswith("screen"):
        return None  # they swallow the sequences
    program, term = environment.get("TERM_PROGRAM", ""), environment.get("TERM", "")
    if program in ("iTerm.app", "WezTerm", "vscode") or environment.get("LC_TERMINAL") == "iTerm2":
        return Protocol.ITERM
    if "KITTY_WINDOW_ID" in environment or term in ("xterm-kitty", "xterm-ghostty") or program == "ghostty":
        return Protocol.KITTY
    if term.startswith(("foot", "mlterm", "yaft")) or "sixel" in term:
        return Protocol.SIXEL
    return None


def inline(path: Path, protocol: Protocol, rows: int) -> str:
    """The sequence that shows a picture file, ``rows`` lines of text high. Raises SceneError without pillow."""
    image = need("PIL.Image", "pillow").open(path).convert("RGB")
    if protocol is Protocol.SIXEL:
        return _sixel(image, rows * 18)
    data = io.BytesIO()
    image.save(data, "PNG")
    encoded = base64.b64encode(data.getvalue()).decode("ascii")
    if protocol is Protocol.ITERM:
        size = f"size={len(data.getvalue())};height={rows};preserveAspectRatio=1"
        return f"\x1b]1337;File=inline=1;{size}:{encoded}\a"
    return _kitty(encoded, rows)


def _kitty(encoded: str, rows: int) -> str:
    pieces = [encoded[i : i + _CHUNK] for i in range(0, len(encoded), _CHUNK)]
    sequence = []
    for number, piece in enumerate(pieces):
        head = f"a=T,f=100,r={rows}," if number == 0 else ""
        sequence.append(f"\x1b_G{head}m={int(number < len(pieces) - 1)};{piece}\x1b\\")
    return "".join(sequence)


def _sixel(image: Any, height: int) -> str:
    """The picture with a palette, in bands of six rows, each colour's row run-length encoded."""
    width = max(1, round(image.width * height / image.height))
    small = image.resize((width, height)).quantize(_SIXEL_COLORS)
    palette = small.getpalette()
    pixels = small.load()
    out = [f'\x1bPq"1;1;{width};{height}']
    for number in sorted({index for _, index in small.getcolors(_SIXEL_COLORS)}):
        red, green, blue = (round(100 * c / 255) for c in palette[3 * number : 3 * number + 3])
        out.append(f"#{number};2;{red};{green};{blue}")
    for top in range(0, height, 6):
        rows = range(top, min(top + 6, height))
        used = sorted({pixels[x, y] for y in rows for x in range(width)})
        for color in used:
            bits = [sum(1 << (y - top) for y in rows if pixels[x, y] == color) for x in range(width)]
            out.append(f"#{color}{_runs(bits)}$")
        out.append("-")
    return "".join(out) + "\x1b\\"


def _runs(bits: list[int]) -> str:
    out: list[str] = []
    start = 0
    for x in range(1, len(bits) + 1):
        if x == len(bits) or bits[x] != bits[start]:
            out.append(f"!{x - start}{chr(63 + bits[start])}")
            start = x
    return "".join(out)
