from collections import Counter
from itertools import groupby
from helper import *

"""
a pixel art mushroom in Minecraft, with runs of equal blocks merged
"""

PICTURE = """
....rrrrrr....
..rrrrwwrrrr..
.rrwwrwwrwwrr.
.rrwwrrrrwwrr.
rrrrrrrrrrrrrr
rrwwrrrrrrwwrr
.kkcccccccckk.
...cckcckcc...
...cckcckcc...
...cccccccc...
....cccccc....
"""

BLOCKS = {"r": "red_concrete", "w": "white_concrete", "c": "sandstone", "k": "black_wool"}

def runs(line: str):
    """(start, length, symbol) of each run."""
    start = 0
    for symbol, group in groupby(line):
        length = sum(1 for _ in group)
        if symbol != ".":
            yield start, length, symbol
        start += length

class Canvas:
    def __init__(self, text: str):
        self.lines = text.strip().splitlines()

    def __len__(self):
        return len(self.lines)

    def __getitem__(self, row: int) -> str:
        return self.lines[len(self) - 1 - row]

    @property
    def width(self) -> int:
        return max(map(len, self.lines))

    def palette(self) -> Counter:
        return Counter(ch for line in self.lines for ch in line if ch in BLOCKS)

@register("one run of blocks")
def run(symbol: str, length: int) -> Shape:
    return primitive_call('set_cuboid', block_type=f"minecraft:{BLOCKS[symbol]}", scale=(length, 1, 1), fill=True)

@register("frame")
def frame(width: int, height: int) -> Shape:
    sides = [((width + 2, 1, 1), (-1, -1, 0)), ((width + 2, 1, 1), (-1, height, 0)), ((1, height, 1), (-1, 0, 0)), ((1, height, 1), (width, 0, 0))]
    return concat_shapes(*(transform_shape(primitive_call('set_cuboid', block_type='minecraft:stripped_spruce_log', block_kwargs={'axis': 'x' if size[0] > 1 else 'y'}, scale=size, fill=True), translation_matrix(at)) for size, at in sides))

@register("pixel art")
def pixel_art() -> Shape:
    canvas = Canvas(PICTURE)
    shapes = []
    for y in range(len(canvas)):
        for x, length, symbol in runs(canvas[y]):
            shapes.append(transform_shape(library_call('run', symbol=symbol, length=length), translation_matrix((x, y, 0))))
    legend = []
    for i, (symbol, n) in enumerate(canvas.palette().most_common()):
        height = max(1, n // 10)
        column = primitive_call('set_cuboid', block_type="minecraft:" + BLOCKS[symbol], block_kwargs={}, scale=(1, height, 1), fill=True)
        legend.append(transform_shape(column, translation_matrix((canvas.width + 2 + 2 * i, -1, 0))))
    return concat_shapes(library_call('frame', width=canvas.width, height=len(canvas)), *shapes, *legend)
