"""Images of the subject of an error or a finding (640 x 480, PNG); ``surfaces/exhibit`` makes the scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scenelang.backends.files import check_folder
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend, save_image
from scenelang.backends.surfaces.marks import Marks, exhibit, marked_scene
from scenelang.grammar.diagnostics import UsageError
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives.mesh import Mesh
from scenelang.interpreter.values.values import Matrix


def check_picture(output: Path) -> None:
    """Check before the work starts that ``output`` can be a picture; raises UsageError, and SceneError("file")."""
    if output.suffix.lower() != ".png":
        raise UsageError("value", f"--picture writes PNG files, not `{output}`")
    check_folder(output)


def save_exhibit(subject: Entity | Mesh, path: Path) -> None:
    """Write a picture (640 x 480, PNG) of what an error is about; raises SceneError if it has nothing to show."""
    save_image(draw(exhibit(subject), PictureOptions(width=640, height=480), picture_backend("draft")), path)


def save_marked(root: Entity, marks: Marks, path: Path) -> None:
    """Write a picture (640 x 480, PNG) of what a finding is about, seen from near."""

    frame = flatten_entity(root)
    found = [marks.points, marks.centers, marks.lines.reshape(-1, 3)]
    for row in sorted(marks.subject):
        shape = frame.primitives[int(frame.index[row])].shape
        if shape is not None and shape.has_geometry:
            found.append(np.array(shape.box_under(Matrix(frame.matrices[row].ravel().tolist()))).reshape(2, 3))
    points = np.concatenate(found)
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = ((low + high) / 2.0).tolist()
    view = Viewpoint(35.0, 18.0, distance=2.4 * max(float(np.linalg.norm(high - low)), 1e-6), target=(x, y, z))
    options = PictureOptions(width=640, height=480, camera=view, settings={"shading": "pixel"})
    save_image(draw(marked_scene(root, marks), options, picture_backend("draft")), path)
