"""The paper's tables of results (CVPR 2025, tables 3 and 4, and that of the appendix on 4D): their columns, and what
stands in them there."""

from __future__ import annotations

from dataclasses import dataclass

from scenelang.evaluation.subject import DYNAMIC, GENERIC, NUMERIC

EVERY = ""  # the group of a column that counts all scenes with its metric


@dataclass(frozen=True, slots=True)
class Figure:
    """A number of the paper, with its standard deviation across scenes where it gives one."""

    value: float
    deviation: float | None = None


@dataclass(frozen=True, slots=True)
class Column:
    """``title`` and the group's heading above it; ``part`` of the metric's values is shown, ``scale`` times as large,
    with so many ``digits`` and the ``unit`` after it; ``is_best_high`` tells the arrow."""

    title: str
    metric: str
    group: str = EVERY
    heading: str = ""
    part: str = "value"
    digits: int = 3
    scale: float = 1.0
    unit: str = ""
    is_best_high: bool | None = True
    has_deviation: bool = False

    @property
    def arrow(self) -> str:
        return "" if self.is_best_high is None else "↑" if self.is_best_high else "↓"


@dataclass(frozen=True, slots=True)
class PaperTable:
    """``rows`` are the paper's methods with a figure, or None, for each column."""

    name: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, tuple[Figure | None, ...]], ...]


def _text_columns(group: str, heading: str) -> tuple[Column, ...]:
    alignment = Column("Alignment", "alignment", group, heading, digits=2, has_deviation=True)
    return alignment, Column("CLIP", "clip", group, heading, has_deviation=True)


_COUNT = Column("Count", "count", NUMERIC, "Numeric prompts", digits=2)
TEXT = PaperTable(
    "text",
    "Text-prompted 3D generation",
    (*_text_columns(NUMERIC, "Numeric prompts"), _COUNT, *_text_columns(GENERIC, "Generic prompts")),
    (
        ("GraphDreamer", (Figure(3.56, 7.38), Figure(0.297, 0.085), Figure(0.11), Figure(15.75, 20.39),
                          Figure(0.230, 0.097))),
        ("MVDream", (Figure(10.79, 12.83), Figure(0.312, 0.046), Figure(0.11), Figure(35.13, 31.90),
                     Figure(0.328, 0.031))),
        ("Ours", (Figure(85.65, 13.71), Figure(0.351, 0.051), Figure(1.0), Figure(52.13, 26.83), Figure(0.328, 0.030))),
    ),
)  # fmt: skip
MOVING = PaperTable(
    "4d",
    "Text-prompted 4D generation",
    (
        Column("CLIP", "clip", DYNAMIC),
        Column("Dynamic", "dynamic", DYNAMIC, digits=1, scale=100.0, unit="%"),
        Column("Pixels", "dynamic", DYNAMIC, part="pixels", digits=2),
        Column("VBench", "dynamic", DYNAMIC, part="is_dynamic", digits=2),
    ),
    (
        ("4D-fy", (Figure(0.352), Figure(0.2), None, None)),
        ("4D-fy (w/ prompt variant)", (Figure(0.354), Figure(0.6), None, None)),
        ("Ours", (Figure(0.341), Figure(5.9), None, None)),
    ),
)
IMAGE = PaperTable(
    "image",
    "Image-prompted generation",
    (Column("LPIPS", "lpips", is_best_high=False),),
    (("GraphDreamer", (Figure(0.811),)), ("Ours", (Figure(0.681),))),
)
TABLES = (TEXT, MOVING, IMAGE)
