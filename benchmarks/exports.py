"""Exports of 100,000 primitives beside trimesh's and usd-core's: ``exports.py WAY SCENE ENDING`` runs one.

``WAY`` is ``ours``, from an evaluated scene to the file, or ``trimesh``, from a ``trimesh.Scene`` with one geometry for
each shape and look and one transform for each primitive. Trimesh joins that to one mesh for all formats but GLB, as
users do. It prints seconds of processor time, peak memory and the size of the file.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from measuring import Child, Goal, Pair, Row, peak_memory, peer

from scenelang.backends.base import BackendOptions, for_file
from scenelang.backends.exports.plan import SEGMENTS, segments_for, surface_of
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.session.session import Session

COUNT = 100_000
_COLORS = '(define paint (list (color "gold") (color "tomato") (color "steelblue") (color "ivory") (color "seagreen")))'
_PLACE = "(translate (vector (* 3 (modulo i 100)) (* 3 (modulo (quotient i 100) 100)) (* 3 (quotient i 10000))))"
_TURN = "(rotate (* 0.01 i) [0 1 0])"
SCENES = {
    "boxes": f"""{_COLORS}
(bind "boxes" (lambda () (union-loop {COUNT} (lambda (i)
  (transform (call "cube" :color (list-ref paint (modulo i 5))) (@ {_PLACE} {_TURN}))))))""",
    "balls": f"""{_COLORS}
(bind "balls" (lambda () (union-loop {COUNT} (lambda (i)
  (transform (call (if (even? i) "cube" "sphere") :color (list-ref paint (modulo i 5))) {_PLACE})))))""",
    "bolts": f"""{_COLORS}
(bind "bolt" (lambda () (union
  (call "cylinder" :radius .2 :color (color "silver"))
  (transform (call "cube" :scale [1 .3 1] :color (color "gold")) (translate [0 1 0]))
  (transform (call "cube" :scale .4) (translate [0 1.3 0]))
  (transform (call "cone" :radius .2 :color (color "silver")) (scale [1 -1 1])))))
(bind "bolts" (lambda () (union-loop {COUNT // 4} (lambda (i) (transform (call "bolt") (@ {_PLACE} {_TURN}))))))""",
}


def scene_of(name: str) -> Scene:
    scene = Session().evaluate(Source("<bench>", SCENES[name])).scene
    assert scene is not None
    return scene


def ours(scene: Scene, path: Path, settings: dict[str, Any]) -> float:
    """Seconds of processor time of our export."""
    backend = for_file(path)
    started = time.process_time()
    backend.run(scene, path, BackendOptions(settings=settings))
    return time.process_time() - started


def theirs(scene: Scene, path: Path) -> float:
    """Seconds of processor time of trimesh's export of the same triangles."""
    made = trimesh_of(scene, SEGMENTS if path.suffix == ".glb" else segments_for([scene.root], "the file"))
    started = time.process_time()
    if path.suffix != ".glb":
        made = made.to_mesh()
    made.export(path)
    return time.process_time() - started


def trimesh_of(scene: Scene, segments: int) -> Any:
    """The scene in trimesh, with normals and colours as our files have them."""
    import trimesh

    flat, made = flatten_entity(scene.root), trimesh.Scene()
    for number, primitive in enumerate(flat.primitives):
        surface = surface_of(primitive, segments)
        assert surface is not None
        color = [*np.rint(255.0 * to_srgb(np.array(look_of(primitive).color))).astype(np.uint8).tolist(), 255]
        mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False, vertex_normals=surface.normals)
        mesh.visual.vertex_colors = np.tile(np.array(color, np.uint8), (len(surface.vertices), 1))
        made.add_geometry(mesh, geom_name=str(number), node_name=f"shape-{number}")
        made.graph.transforms.remove_node(f"shape-{number}")
    for row, (number, matrix) in enumerate(zip(flat.index.tolist(), flat.matrices, strict=True)):
        made.graph.update(f"n{row}", matrix=np.vstack([matrix, [0.0, 0.0, 0.0, 1.0]]), geometry=str(number))
    return made


def of(*words: str) -> Child:
    """Return the probe of one export in a process of its own."""
    return Child("exports.py", words, "memory")


def beside_usd() -> Iterator[Pair]:
    with tempfile.TemporaryDirectory() as folder:
        yield Pair(of("ours", "balls", ".usdc", "instancing=2"), peer("usd", str(COUNT), f"{folder}/a.usdc"))


def beside_trimesh() -> Iterator[Pair]:
    with tempfile.TemporaryDirectory() as folder:
        yield Pair(of("ours", "boxes", ".glb", "instancing=0"), peer("trimesh", str(COUNT), f"{folder}/a.glb"))


def _instanced(name: str, ending: str) -> list[Pair]:
    return [Pair(*(of("ours", name, ending, f"instancing={least}") for least in (2, 0)))]


def _rows() -> Iterator[Row]:
    # without .ply and the like, for which trimesh joins the scene: a minute each
    for name, count, ending in (("boxes", "100,000 boxes", ".glb"), ("bolts", "25,000 bolts of four parts", ".glb")):
        words = name, ending
        pair = Pair(of("ours", *words), of("trimesh", *words))
        yield Row(f"export {count}, {ending}", lambda pair=pair: [pair], "trimesh", (Goal(2.0),), rounds=1)
    for ending, other in ((".glb", "one node each"), (".usdc", "one prim each")):
        yield Row(f"export 100,000 boxes, {ending}, instanced", partial(_instanced, "boxes", ending), other, rounds=1)


ROWS = (
    *_rows(),
    Row("export 100,000 nodes, .glb", beside_trimesh, "trimesh, one cube", rounds=1),
    Row("export 100,000 copies, .usdc", beside_usd, "usd-core alone", rounds=1),
)


def main(way: str, name: str, ending: str, *settings: str) -> None:
    scene = scene_of(name)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{ending}"
        given = {key: json.loads(value) for key, value in (word.split("=") for word in settings)}
        seconds = ours(scene, path, given) if way == "ours" else theirs(scene, path)
        size = sum(file.stat().st_size for file in Path(folder).iterdir())
    print(json.dumps({"seconds": seconds, "memory": peak_memory(), "size": size}))


if __name__ == "__main__":
    main(*sys.argv[1:])
