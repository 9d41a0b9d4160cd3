"""Publication figures: what may be asked of one, beyond an image of the scene.

A section, an exploded view and a style change the scene; outlines, callouts and dimensions are drawn over its image
(``drawn_over``). This module has the options, and the changed scene.
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import names, setting, whole, within
from scenelang.interpreter.inspection.instance_paths import read_path
from scenelang.interpreter.scene.pose import AXES
from scenelang.stdlib.colors import color_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenelang.grammar.diagnostics import Diagnostic
    from scenelang.interpreter.scene.entity import Scene

STYLES = MappingProxyType({
    "shaded": "the scene's own materials", "clay": "one matte color", "line": "outlines on white surfaces",
    "wire": "edges of the triangles on white surfaces",
})  # fmt: skip
OUTLINE_WIDTH = 1.5  # pixels, of outlines whose width is not given
WIRE_WIDTH = 0.75  # pixels, of the edges of triangles
WIDTHS = (0.25, 20.0)  # pixels
MOST = 100.0  # times the offset of a part
INK = "#1c1e24"
EVERYTHING = "*"  # callouts of all top-level objects
WHOLE = "."  # dimensions of the whole scene


@dataclass(frozen=True, slots=True)
class Figure:
    """Options of a publication figure.

    Parameters
    ----------
    section : str, optional
        Plane that cuts the scene open, as ``x=0.2`` or ``-y=50%``; two or three remove a corner.
    explode : float, optional
        Parts move away from the center of what contains them, by this times their offset.
    explode_axis : str, optional
        Axis of the world along which they move, "x", "y" or "z".
    explode_depth : int, optional
        Levels of the hierarchy whose parts move; by default all.
    outline : float, optional
        Width in pixels of lines at silhouettes, creases and between objects.
    outline_color : str
        CSS name or ``#rrggbb``.
    style : str
        "shaded", "clay", "line" (a technical drawing) or "wire".
    callouts : sequence of str, optional
        Words or paths of objects that get a label beside the image of the objects; ``*`` means all top-level objects.
    dimensions : str, optional
        Path of the objects whose width, height and depth are drawn; "." means the whole scene.

    Examples
    --------
    >>> Figure(section="x=50%").section
    'x=50%'
    """

    section: str | None = setting(
        None, "cut the scene open at a plane: x=0.2, =-x=0.2 (keeps the other side), y=50%, or x=50%,z=50%: a corner",
        metavar="PLANE",
    )  # fmt: skip
    explode: float | None = setting(
        None, "move parts away from the center of what contains them, by this times their offset", metavar="AMOUNT",
        read=within(0.0, MOST),
    )  # fmt: skip
    explode_axis: str | None = setting(None, "move them along this axis only", choices=AXES)
    explode_depth: int | None = setting(None, "move the parts of so many levels only", metavar="N", read=whole)
    outline: float | None = setting(
        None, "draw lines at silhouettes, creases and between objects (default 1.5 pixels wide)", metavar="PIXELS",
        read=within(*WIDTHS), alone=str(OUTLINE_WIDTH),
    )  # fmt: skip
    outline_color: str = setting(INK, "color of lines: a CSS name or #rrggbb", metavar="COLOR")
    style: str = setting("shaded", "; ".join(f"{name}: {doc}" for name, doc in STYLES.items()), choices=tuple(STYLES))
    callouts: tuple[str, ...] | None = setting(
        None, "label these objects beside the image, with leader lines (default: all top-level objects)",
        metavar="WORD,...", read=names, alone=EVERYTHING,
    )  # fmt: skip
    dimensions: str | None = setting(
        None, "draw width, height and depth of the scene, or of an object", metavar="PATH", alone=WHOLE
    )

    @property
    def has_lines(self) -> bool:
        """Whether lines are drawn over the image."""
        return self.outline is not None or self.style in ("line", "wire")

    @property
    def has_notes(self) -> bool:
        """Whether text is drawn beside the objects, which needs room."""
        return self.callouts is not None or self.dimensions is not None

    @property
    def is_drawn_over(self) -> bool:
        """Whether anything is drawn over the image of the scene."""
        return self.has_lines or self.has_notes


PLAIN = Figure()


def check_figure(figure: Figure) -> None:
    """Validate a figure independently of a scene; raises SceneError("value")."""
    if figure.section is not None:
        from scenelang.backends.surfaces.cuts import planes_of

        planes_of(figure.section)
    if figure.style not in STYLES:
        raise SceneError("value", f"unknown style `{figure.style}`", hint=f"expected one of {', '.join(STYLES)}")
    _check_range("explode", figure.explode, 0.0, MOST)
    _check_range("outline", figure.outline, *WIDTHS)
    if figure.explode_axis not in (None, *AXES):
        raise SceneError("value", f"unknown axis `{figure.explode_axis}`", hint="expected x, y or z")
    color_of(figure.outline_color)
    for path in figure.callouts or ():
        read_path(path)
    for name in ("axis", "depth"):
        if getattr(figure, f"explode_{name}") is not None and figure.explode is None:
            message = f"`explode_{name}` has no effect without `explode`"
            raise SceneError("value", message, hint=f"write `--explode 0.5 --explode-{name} ...`")


def _check_range(name: str, value: float | None, low: float, high: float) -> None:
    """Raise SceneError for a number that is not from ``low`` to ``high``."""
    if value is not None and not low <= value <= high:
        raise SceneError("value", f"`{name}` must be from {low:g} to {high:g}, not {value:g}")


def check_drawable(figure: Figure, path: Path | None, is_video: bool) -> None:
    """Raise SceneError for what is drawn over images, if the file is a video or has no tone curve."""
    if is_video and figure.has_notes:
        name = "callouts" if figure.callouts is not None else "dimensions"
        message = f"a video has no `{name}`, whose text would jump from image to image"
        raise SceneError("value", message, hint="draw one image: write a .png file, or give `--frame N`")
    if path is not None and path.suffix.lower() == ".exr" and (figure.is_drawn_over):
        message = "an .exr file has radiance, over which no lines or text are drawn"
        raise SceneError("value", message, hint=f"write `-o {path.stem}.png`")


def figured(
    scene: Scene, figure: Figure, limit: int = 2_000_000, warn: Callable[[Diagnostic], None] | None = None
) -> Scene:
    """Return the scene that a figure shows: exploded, then cut, in its style.

    Raises
    ------
    SceneError
        For invalid options, or a section that leaves nothing.
    LimitError
        For a section through too many primitives.
    """
    check_figure(figure)
    if figure.explode is not None:
        from scenelang.interpreter.scene.exploding import exploded

        scene = exploded(scene, figure.explode, figure.explode_axis, figure.explode_depth)
    if figure.section is not None:
        from scenelang.backends.surfaces.cuts import cut, planes_of

        scene = cut(scene, planes_of(figure.section), limit, warn)
    if figure.style in ("clay", "wire"):
        from scenelang.backends.surfaces.restyling import in_clay, in_triangles

        scene = in_clay(scene, limit, warn) if figure.style == "clay" else in_triangles(scene, limit, warn)
    return scene
