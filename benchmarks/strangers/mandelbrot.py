# Iterations of points near the Mandelbrot set, drawn as text (Brooks and Matelski 1978); 2026-11-29.
from __future__ import annotations

SHADES = " .:-=+*#%@"


def escape(a: float, b: float, most: int) -> int:
    x = y = 0.0
    n = 0
    while n != most and x * x + y * y <= 4:
        x, y = x * x - y * y + a, 2 * x * y + b
        n += 1
    return n


def run(width: int = 80, most: int = 60) -> str:
    height = width // 2
    rows = []
    for j in range(height):
        b = 2.4 * (j / height) - 1.2
        rows.append("".join(SHADES[escape(3 * (i / width) - 2.1, b, most) % 10] for i in range(width)))
    return "\n".join(rows)
