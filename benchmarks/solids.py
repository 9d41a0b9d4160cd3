"""Solids: drafts of booleans beside cubes, unions by level beside flat ones, surfaces on disk beside computed ones."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from measuring import ROOT, Goal, Pair, Row, timed

EXAMPLES = ROOT / "examples"
CUBE = '(call "cube" :color [.8 .3 .2])'
BOOLEAN = f'(difference {CUBE} (call "sphere" :radius .6 :color [.2 .4 .9]))'
FIELD = '(bind "field" (lambda () (grid {part} :nx 5 :nz 5 :spacing 1.3)))'
ROUNDED = '(bind "part" (lambda () (rounded (difference (call "cube") (call "cylinder" :radius .2 :p1 [0 2 0])) .1)))'
SIDES = 16


@contextmanager
def no_cache() -> Iterator[None]:
    """An empty folder for the surfaces that are stored on disk."""
    before = os.environ.get("XDG_CACHE_HOME")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        try:
            yield
        finally:
            del os.environ["XDG_CACHE_HOME"]
            if before is not None:
                os.environ["XDG_CACHE_HOME"] = before


def draft(part: str) -> Callable[[], Any]:
    """A draft (640 x 480) of 25 copies, the solid being computed by the first."""
    import scenelang as sl

    scene = sl.evaluate(FIELD.format(part=part))
    camera = sl.Camera(azimuth=30, elevation=35)
    picture = lambda: scene.render(camera=camera, size=(640, 480))
    picture()
    return picture


def drafts() -> Iterator[Pair]:
    with no_cache():
        yield Pair(timed(draft(BOOLEAN)), timed(draft(CUBE)))


def unions(levels: int) -> Iterator[Pair]:
    """The fractal tree joined level by level, and all at once by Manifold alone."""
    import manifold3d

    import scenelang as sl
    from scenelang.interpreter.scene.flatten import flatten_entity
    from scenelang.interpreter.scene.modelling.computing import leaf_mesh, manifold_of, manifold_of_mesh
    from scenelang.interpreter.scene.modelling.solid import joined

    root = sl.load(EXAMPLES / "fractal-tree.scene", defines={"levels": levels}).graph.frames[0]
    expression = joined(root, lambda _: SIDES)
    assert expression is not None
    flat = flatten_entity(root)
    made = [manifold_of_mesh(leaf_mesh(entity.shape, SIDES), entity.word) for entity in flat.primitives if entity.shape]

    def at_once() -> int:
        pieces = [made[which].transform(pose) for which, pose in zip(flat.index, flat.matrices, strict=True)]
        return manifold3d.Manifold.batch_boolean(pieces, manifold3d.OpType.Add).num_tri()

    with no_cache():
        yield Pair(timed(lambda: manifold_of(expression).manifold.num_tri()), timed(at_once))


def surfaces() -> Iterator[Pair]:
    """The surface of a rounded part, read from disk and computed."""
    import scenelang as sl
    from scenelang.interpreter.scene.modelling import stored
    from scenelang.interpreter.scene.modelling.computing import computed
    from scenelang.interpreter.scene.modelling.solid import SolidShape

    with no_cache():
        shape = sl.evaluate(ROUNDED).graph.root.children[0].car.shape
        assert isinstance(shape, SolidShape)
        taken = timed(lambda: computed(shape.expression))()
        assert stored.load(shape.expression.digest) is not None
        yield Pair(timed(lambda: stored.load(shape.expression.digest)), lambda: taken)


ROWS = (
    Row("draft of 25 booleans", drafts, "25 cubes", (Goal(1.3),), rounds=2),
    Row("union of the fractal tree, 6 levels", lambda: unions(6), "Manifold, all at once", (Goal(0.5),), rounds=1),
    Row("surface of a rounded part, stored", surfaces, "computed", (Goal(0.2),), rounds=1),
)
