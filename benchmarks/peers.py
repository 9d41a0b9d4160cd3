"""What stands beside ours in packages of ``peers.txt``: ``.venv/bench/bin/python benchmarks/peers.py TASK ...``.

Prints JSON: seconds of processor time, and peak memory in bytes. No file here imports scenelang.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

from measuring import NOT_INSTALLED, peak_memory

HY = {
    "fib": "(defn fib [n] (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2))))) (fib 22)",
    "loop": "(defn turns [] (setv s 0) (for [i (range 1000000)] (setv s (+ s i))) s) (turns)",
    "tak": "(defn tak [x y z] (if (< y x) (tak (tak (- x 1) y z) (tak (- y 1) z x) (tak (- z 1) x y)) z)) (tak 14 8 2)",
}


def hy(name: str) -> Callable[[], Any]:
    """A program in Hy; its last form is timed, as ours."""
    import hy

    *before, last = hy.read_many(HY[name])
    names: dict[str, Any] = {}
    for form in before:
        hy.eval(form, names)
    return lambda: hy.eval(last, names)


def primitives(count: int) -> list[tuple[bool, tuple[int, int, int], tuple[float, float, float]]]:
    """What ``programs.PRIMITIVES`` places: whether it is a sphere, where, and its colour."""
    return [
        (i % 2 == 1, (2 * (i % 15), 0, 2 * (i // 15)), (0.2 + 0.003 * i, 0.5, 0.8 - 0.003 * i)) for i in range(count)
    ]


def pyvista(size: str, count: str) -> Callable[[], Any]:
    """A picture without shadows by rasterisation, as a command: with the import of the package."""

    def picture() -> Any:
        import pyvista as pv

        plotter = pv.Plotter(off_screen=True, window_size=(int(size), int(size)))
        for is_sphere, place, color in primitives(int(count)):
            solid = pv.Sphere(radius=0.5, center=place) if is_sphere else pv.Cube(center=place)
            plotter.add_mesh(solid, color=color)
        return plotter.screenshot(return_img=True)

    return picture


def pyrender(size: str, count: str) -> Callable[[], Any]:
    """A picture without shadows by OpenGL without a display, as a command: with the import of the package."""

    def picture() -> Any:
        os.environ.setdefault("PYOPENGL_PLATFORM", "egl")  # before OpenGL is imported
        import numpy as np
        import pyrender
        import trimesh

        scene = pyrender.Scene()
        for is_sphere, place, color in primitives(int(count)):
            solid = trimesh.creation.icosphere(radius=0.5) if is_sphere else trimesh.creation.box()
            solid.visual = trimesh.visual.ColorVisuals(
                solid, vertex_colors=np.tile([*color, 1.0], (len(solid.vertices), 1))
            )
            pose = np.eye(4)
            pose[:3, 3] = place
            scene.add(pyrender.Mesh.from_trimesh(solid, smooth=is_sphere), pose=pose)
        view = np.eye(4)
        view[:3, 3] = (14.0, 13.0, 60.0)
        scene.add(pyrender.PerspectiveCamera(yfov=0.7), pose=view)
        scene.add(pyrender.DirectionalLight(intensity=3.0), pose=view)
        return pyrender.OffscreenRenderer(int(size), int(size)).render(scene)

    return picture


def mitsuba(size: str, count: str, samples: str) -> Callable[[], Any]:
    """A path traced picture of the same by Mitsuba alone, on one thread, with the import of the package."""

    def picture() -> Any:
        import mitsuba as mi
        import numpy as np

        mi.set_variant("scalar_rgb")  # an LLVM that does not fit Mitsuba's ends the process
        look = mi.ScalarTransform4f().look_at(origin=[40, 30, -30], target=[14, 0, 13], up=[0, 1, 0])
        film = {"type": "hdrfilm", "width": int(size), "height": int(size)}
        scene: dict[str, Any] = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "sensor": {"type": "perspective", "fov": 40, "to_world": look, "film": film},
            "light": {"type": "constant"},
        }
        for i, (is_sphere, place, color) in enumerate(primitives(int(count))):
            pose = mi.ScalarTransform4f().translate(list(place)).scale(0.5)
            paint = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(color)}}
            scene[f"s{i}"] = {"type": "sphere" if is_sphere else "cube", "to_world": pose, "bsdf": paint}
        return np.array(mi.render(mi.load_dict(scene), spp=int(samples)))

    return picture


def mitsuba_file(path: str, samples: str) -> Callable[[], Any]:
    """The path traced picture of a scene in a file by Mitsuba alone, from reading the file."""
    import mitsuba as mi
    import numpy as np

    mi.set_variant("scalar_rgb")
    return lambda: np.array(mi.render(mi.load_file(path), spp=int(samples)))


def usd(count: str, path: str) -> Callable[[], Any]:
    """As many copies of a cube as one PointInstancer, from positions that numpy has, written by usd-core."""
    import numpy as np
    from pxr import Usd, UsdGeom, Vt

    places = np.arange(3 * int(count), dtype=np.float32).reshape(-1, 3)

    def written() -> None:
        stage = Usd.Stage.CreateNew(path)
        instancer = UsdGeom.PointInstancer.Define(stage, "/copies")
        cube = UsdGeom.Cube.Define(stage, "/copies/cube")
        instancer.CreatePrototypesRel().AddTarget(cube.GetPath())
        instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(np.zeros(int(count), np.int32)))
        instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(places))
        stage.GetRootLayer().Save()

    return written


def trimesh(count: str, path: str) -> Callable[[], Any]:
    """As many placements of one cube in trimesh's scene, flattened to world matrices and written as GLB."""
    import numpy as np
    import trimesh

    def written() -> None:
        scene = trimesh.Scene()
        scene.add_geometry(trimesh.creation.box(), geom_name="cube", node_name="first")
        poses = np.tile(np.eye(4), (int(count), 1, 1))
        poses[:, 0, 3] = np.arange(int(count))
        for i, pose in enumerate(poses):
            scene.graph.update(f"n{i}", matrix=pose, geometry="cube")
        scene.export(path)

    return written


TASKS = {task.__name__: task for task in (hy, pyvista, pyrender, mitsuba, mitsuba_file, usd, trimesh)}


def main(name: str, *words: str) -> int:
    fifth = name == "fifth"  # of five runs in one process
    task, rest = (words[0], words[1:]) if fifth else (name, words)
    try:
        action = TASKS[task](*rest)
        for _ in range(4 * fifth):
            action()
        gc.collect()
        gc.disable()
        started = time.process_time()
        action()
        taken = time.process_time() - started
    except ImportError as error:
        print(f"{task} is not installed ({error})", file=sys.stderr)
        return NOT_INSTALLED
    print(json.dumps({"seconds": taken, "memory": peak_memory()}))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
