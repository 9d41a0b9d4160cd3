from typing import Protocol
import numpy as np
from helper import *

"""
three sample terrains behind a HeightField protocol
"""

class HeightField(Protocol):
    name: str
    def height(self, x: float, z: float) -> float: ...

class Dome:
    name = "dome"
    def __init__(self, radius: float) -> None:
        self.radius = radius
    def height(self, x: float, z: float) -> float:
        return float(np.sqrt(max(self.radius ** 2 - x * x - z * z, 0.0)))

class Ripple:
    name = "ripple"
    def __init__(self, waves: float = 3.0, amplitude: float = 0.4) -> None:
        self.waves, self.amplitude = waves, amplitude
    def height(self, x: float, z: float) -> float:
        return self.amplitude * (1 + np.cos(self.waves * np.hypot(x, z)))

class Terrace:
    """Wraps another field and quantizes it."""
    def __init__(self, inner: HeightField, steps: int) -> None:
        self.inner, self.steps = inner, steps
        self.name = f"terraced {inner.name}"
    def height(self, x: float, z: float) -> float:
        return np.floor(self.inner.height(x, z) * self.steps) / self.steps

def sample(field: HeightField, n: int, half: float = 1.5):
    for x in np.linspace(-half, half, n):
        for z in np.linspace(-half, half, n):
            yield x, z, field.height(x, z)

@register()
def terrain(field: HeightField, n: int = 8) -> Shape:
    columns = []
    pitch = 3.0 / (n - 1)
    for x, z, h in sample(field, n):
        h = max(h, 0.02)
        green = min(0.3 + h / 3, 1.0)
        column = primitive_call('cube', color=(0.3, green, 0.25), shape_kwargs={'scale': (pitch, h, pitch)})
        columns.append(transform_shape(column, translation_matrix((x, h / 2, z))))
    label_width = 0.1 * len(field.name)
    label = primitive_call('cube', color=(0.9, 0.9, 0.9), shape_kwargs={'scale': (label_width, 0.1, 0.3)})
    return concat_shapes(*columns, transform_shape(label, translation_matrix((0, 0.05, 2.2))))

@register()
def model_table() -> Shape:
    fields: List[HeightField] = [Dome(1.4), Ripple(), Terrace(Dome(1.6), 3), Terrace(Ripple(2.0, 0.6), 4)]
    shapes = []
    for k, field in enumerate(fields):
        shapes.append(transform_shape(library_call('terrain', field=field), translation_matrix((4.0 * k, 0, 0))))
    return concat_shapes(*shapes)
