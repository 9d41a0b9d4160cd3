"""Images of the subject of an error or a finding (640 x 480, PNG); ``surfaces/marks`` makes the scenes."""

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

_WIDTH, _HEIGHT = 640, 480  # pixels
_DISTANCE = 2.4  # of the camera, in diagonals of the marked objects


def check_picture(output: Path) -> None:
    """Check before the work starts that ``output`` can be an image; raises UsageError, and SceneError("file")."""
    if output.suffix.lower() != ".png":
        raise UsageError("value", f"--picture writes PNG files, not `{output}`")
    check_folder(output)


def save_exhibit(subject: Entity | Mesh, path: Path) -> None:
    """Write an image of the subject of an error; raises SceneError if it has nothing to show."""
    save_image(draw(exhibit(subject), PictureOptions(width=_WIDTH, height=_HEIGHT), picture_backend("draft")), path)


def save_marked(root: Entity, marks: Marks, path: Path) -> None:
    """Write a close-up image of a finding."""

    frame = flatten_entity(root)
    marked = [marks.points, marks.centers, marks.lines.reshape(-1, 3)]
    for row in sorted(marks.subject):
        shape = frame.primitives[int(frame.index[row])].shape
        if shape is not None and shape.has_geometry:
            marked.append(np.array(shape.box_under(Matrix(frame.matrices[row].ravel().tolist()))).reshape(2, 3))
    points = np.concatenate(marked)
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = ((low + high) / 2.0).tolist()
    view = Viewpoint(35.0, 18.0, distance=_DISTANCE * max(float(np.linalg.norm(high - low)), 1e-6), target=(x, y, z))
    options = PictureOptions(width=_WIDTH, height=_HEIGHT, camera=view, settings={"shading": "pixel"})
    save_image(draw(marked_scene(root, marks), options, picture_backend("draft")), path)
