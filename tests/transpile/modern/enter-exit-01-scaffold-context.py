from __future__ import annotations
import math
from helper import *

"""
a crane built with a scene context that keeps a stack of poses
"""


class Scene:
    def __init__(self) -> None:
        self._shapes: list = []
        self._pose = [identity_matrix()]
        self.log: list[str] = []

    def add(self, shape: Shape) -> None:
        self._shapes.append(transform_shape(shape, self._pose[-1]))

    def at(self, *offset: float) -> Placement:
        return Placement(self, translation_matrix(offset), f"at{offset}")

    def turned(self, degrees: float, axis=(0, 1, 0)) -> Placement:
        return Placement(self, rotation_matrix(math.radians(degrees), axis, (0, 0, 0)), f"turned {degrees}")

    def __enter__(self) -> Scene:
        self.log.append("open")
        return self

    def __exit__(self, exc_type, exc, tb) -> bool:
        self.log.append("close")
        return exc_type is not None and issubclass(exc_type, OverflowError)

    def build(self) -> Shape:
        return concat_shapes(*self._shapes)


class Placement:
    def __init__(self, scene: Scene, pose, name: str) -> None:
        self.scene, self.pose, self.name = scene, pose, name

    def __enter__(self) -> Scene:
        self.scene._pose.append(self.scene._pose[-1] @ self.pose)
        self.scene.log.append(self.name)
        return self.scene

    def __exit__(self, *details) -> None:
        self.scene._pose.pop()


@register()
def truss(length: float, color=(0.95, 0.7, 0.1)) -> Shape:
    n = int(length / 0.5)
    rails = [primitive_call('cube', color=color, shape_kwargs={'scale': (length, 0.06, 0.06)}) for _ in range(2)]
    rails[1] = transform_shape(rails[1], translation_matrix((0, 0.4, 0)))
    struts = loop(n, lambda i: primitive_call('cylinder', color=color, shape_kwargs={
        'radius': 0.03, 'p0': (-length / 2 + i * 0.5, 0.4 * (i % 2), 0), 'p1': (-length / 2 + (i + 1) * 0.5, 0.4 * ((i + 1) % 2), 0)}))
    return concat_shapes(*rails, struts)


@register()
def crane() -> Shape:
    with Scene() as scene:
        with scene.at(0, 3, 0), scene.turned(90, (0, 0, 1)):
            scene.add(library_call('truss', length=6))
        with scene.at(0, 6, 0), scene.turned(30):
            with scene.at(1.5, 0, 0):
                scene.add(library_call('truss', length=5))
            with scene.at(3.5, -1, 0) as load:
                load.add(primitive_call('cube', color=(0.5, 0.2, 0.1), shape_kwargs={'scale': 0.6}))
            scene.add(primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.02, 'p0': (3.5, 0, 0), 'p1': (3.5, -0.7, 0)}))
    with scene:
        scene.add(primitive_call('cube', color=(0.4, 0.4, 0.4), shape_kwargs={'scale': (2, 0.3, 2)}))
        raise OverflowError("swallowed by __exit__")
    for i, line in enumerate(scene.log):
        scene.add(transform_shape(primitive_call('sphere', color=(0.9, 0.1, 0.1), shape_kwargs={'radius': 0.02 * len(line)}), translation_matrix((i - 4, 0, 2))))
    return scene.build()
