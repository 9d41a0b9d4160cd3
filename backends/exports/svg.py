"""Export to SVG: a section of the scene as one solid, or its silhouette, for drawings, lasers and plotters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Accepts, Backend, BackendOptions, Option, Work, check_settings
from scenelang.backends.exports.export import SECTION
from scenelang.backends.exports.plan import SEGMENTS, chosen
from scenelang.backends.files import atomic_write
from scenelang.backends.surfaces.cuts import CutPlane, planes_of
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.modelling.computing import manifold_of
from scenelang.interpreter.scene.modelling.solid import joined
from scenelang.interpreter.scene.pose import AXES

if TYPE_CHECKING:
    from manifold3d import CrossSection

FloatArray = npt.NDArray[np.float64]

# Directions to the right, up, and toward the viewer, by the side of the view.
_SIDES = {
    "front": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "top": ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
    "right": ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)),
}
_ACROSS = {"x": "right", "y": "top", "z": "front"}
_UNITS = {"millimeter": "mm", "centimeter": "cm", "inch": "in"}
SIDE = Option("side", "side that a silhouette is seen from", "front", tuple(_SIDES))
SIDES = Option("segments", "sides of a full circle", SEGMENTS, minimum=3, maximum=1024)
UNIT = Option("unit", "what a scene unit is in print", "millimeter", tuple(_UNITS))


def _run(scene: Scene, path: Path, options: BackendOptions) -> None:
    """Write the outline of one frame."""
    check_settings(options, [SVG])
    frame = drawn_scene(chosen(scene, options.frame or 0), options.limit, options.warn)
    plane, side = _plane(frame, str(SVG.setting(options, "section"))), str(SVG.setting(options, "side"))
    drawn = outline_of(frame.root, plane, side, int(SVG.setting(options, "segments")))
    with atomic_write(path) as temporary, temporary.open("w", encoding="ascii", newline="\n") as file:
        file.writelines(_document(drawn, _UNITS[str(SVG.setting(options, "unit"))]))


def _plane(frame: Scene, section: str) -> CutPlane | None:
    """Return the plane of a section, None for a silhouette; raises SceneError("value") for several."""
    planes = planes_of(section) if section else ()
    if len(planes) > 1 or any(plane.keeps_far for plane in planes):
        raise SceneError("value", f"an .svg file draws one plane, not `{section[:40]}`", "write `--section y=1.5`")
    if not planes or not planes[0].is_share:
        return planes[0] if planes else None
    box, axis = entity_box(frame.root), planes[0].axis
    assert box is not None  # of a scene that was chosen for an export
    return CutPlane(axis, box[axis] + planes[0].position * (box[axis + 3] - box[axis]))


def outline_of(root: Entity, plane: CutPlane | None, side: str, segments: int = SEGMENTS) -> list[FloatArray]:
    """Return the contours (K, 2) of a section, or of a silhouette without a plane, in scene units.

    Outer contours are counter-clockwise, holes clockwise. Raises SceneError("solid") if there is nothing.
    """
    expression = joined(root, lambda _: segments)
    if expression is None:
        raise SceneError("solid", f'the scene "{root.word}" has nothing with a volume')
    axes = np.array(_SIDES[side if plane is None else _ACROSS[AXES[plane.axis]]])
    rotated = manifold_of(expression).manifold.transform(np.concatenate([axes, np.zeros((3, 1))], axis=1))
    drawn: CrossSection = rotated.project() if plane is None else rotated.slice(plane.position)
    contours = [np.array(polygon, np.float64) for polygon in drawn.to_polygons()]
    if not contours:
        where = "" if plane is None else f" {AXES[plane.axis]}={plane.position:g}"
        raise SceneError("solid", f"the plane{where} meets nothing of the scene")
    return contours


def _document(contours: Sequence[FloatArray], unit: str) -> Iterator[str]:
    """Yield the lines of the SVG, with y down and the origin at the top left corner."""
    points = np.concatenate(contours)
    (min_x, min_y), (max_x, max_y) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    width, height = max_x - min_x, max_y - min_y
    yield '<svg xmlns="http://www.w3.org/2000/svg" '
    yield f'width="{width:.6g}{unit}" height="{height:.6g}{unit}" viewBox="0 0 {width:.6g} {height:.6g}">\n'
    yield '<path fill="#404040" fill-rule="evenodd" d="'
    for contour in contours:
        x, y = contour[:, 0] - min_x, max_y - contour[:, 1]
        yield "M" + "L".join(f"{a:.6g} {b:.6g}" for a, b in zip(x.tolist(), y.tolist(), strict=True)) + "Z"
    yield '"/>\n</svg>\n'


SVG = Backend(
    "svg", "SVG of a section or of the silhouette", Work.EXPORT, (".svg",), _run,
    (SECTION, SIDE, SIDES, UNIT), accepts=Accepts(attributes=()),
)  # fmt: skip
