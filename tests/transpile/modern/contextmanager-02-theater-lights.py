from contextlib import contextmanager, ExitStack, nullcontext, suppress
from helper import *

"""
a theater rig: colors are set within with blocks
"""

class Style:
    def __init__(self):
        self.color = (1.0, 1.0, 1.0)
        self.brightness = 1.0

    @contextmanager
    def override(self, **changes):
        before = {name: getattr(self, name) for name in changes}
        for name, value in changes.items():
            setattr(self, name, value)
        try:
            yield self
        finally:
            for name, value in before.items():
                setattr(self, name, value)

    @property
    def rgb(self):
        return tuple(min(c * self.brightness, 1) for c in self.color)

style = Style()

@register()
def spotlight(tilt: float) -> Shape:
    can = primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.2, 'p0': (0, 0, 0), 'p1': (0, -0.5, 0)})
    lens = transform_shape(primitive_call('sphere', color=style.rgb, shape_kwargs={'radius': 0.18}), translation_matrix((0, -0.5, 0)))
    return transform_shape(concat_shapes(can, lens), rotation_matrix(tilt, direction=(1, 0, 0), point=(0, 0, 0)))

@register()
def rig(count: int, *, dimmed: bool) -> Shape:
    lights = [primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.05, 'p0': (-0.5, 0, 0), 'p1': (count - 0.5, 0, 0)})]
    for i in range(count):
        manager = style.override(brightness=0.3) if dimmed and i % 2 else nullcontext(style)
        with manager as current:
            lights.append(transform_shape(library_call('spotlight', tilt=0.2 * i * current.brightness), translation_matrix((i, -0.1, 0))))
    return concat_shapes(*lights)

@register()
def theater() -> Shape:
    shapes = []
    with style.override(color=(1, 0.3, 0.2)):
        shapes.append(library_call('rig', count=5, dimmed=False))
        with style.override(color=(0.2, 0.4, 1), brightness=0.8):
            shapes.append(transform_shape(library_call('rig', count=4, dimmed=True), translation_matrix((0, 1, -1))))
        shapes.append(transform_shape(library_call('rig', count=3, dimmed=True), translation_matrix((0, 2, -2))))
    with ExitStack() as stack:
        for level in (0.9, 0.6, 0.4):
            stack.enter_context(style.override(brightness=level))
            bulb = primitive_call('sphere', color=style.rgb, shape_kwargs={'radius': 0.2 * level})
            shapes.append(transform_shape(bulb, translation_matrix((level * 5, -3, 1))))
    with suppress(ZeroDivisionError):
        shapes.append(primitive_call('cube', color=(0.3, 0.2, 0.1), shape_kwargs={'scale': (6, 0.2, 4)}))
        shapes.append(primitive_call('cube', shape_kwargs={'scale': 1 / 0}))
    try:
        with style.override(color=(0, 0, 0)):
            raise RuntimeError("fuse")
    except RuntimeError:
        shapes.append(transform_shape(primitive_call('cube', color=style.rgb, shape_kwargs={'scale': (0.2, 0.2, 0.2)}), translation_matrix((-1, 0, 0))))
    return concat_shapes(*shapes)
