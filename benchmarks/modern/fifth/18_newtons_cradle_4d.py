"""a Newton's cradle swinging on a desk (animated)"""
from helper import *
import math
from typing import Generator

FRAMES = 24
STRING = 1.0
RADIUS = 0.12


@register()
def pendulum(angle: float = 0.0, color: tuple[float, float, float] = (0.8, 0.8, 0.83), span: float = 0.35) -> Shape:
    ball = transform_shape(primitive_call('sphere', shape_kwargs={'radius': RADIUS}, color=color), translation_matrix((0, -STRING, 0)))
    strings = [primitive_call('cylinder', shape_kwargs={'radius': 0.006, 'p0': (0, 0, s * span), 'p1': (0, -STRING, 0)}, color=(0.9, 0.9, 0.9)) for s in (-1, 1)]
    return transform_shape(concat_shapes(ball, *strings), rotation_matrix(angle, (0, 0, 1), (0, 0, 0)))


@register()
def frame(balls: int = 5, span: float = 0.35) -> Shape:
    half = balls * RADIUS + 0.2
    top = 0.0
    bars = []
    for z in (-span, span):
        corners = [(-half, -STRING - 0.35, z), (-half, top, z), (half, top, z), (half, -STRING - 0.35, z)]
        bars += [primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': a, 'p1': b}, color=(0.7, 0.7, 0.72)) for a, b in zip(corners, corners[1:])]
        bars += [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.035}, color=(0.7, 0.7, 0.72)), translation_matrix(c)) for c in corners[1:3]]
    base = transform_shape(primitive_call('cube', shape_kwargs={'scale': (2 * half + 0.2, 0.1, 2 * span + 0.2)}, color=(0.2, 0.12, 0.08)), translation_matrix((0, -STRING - 0.4, 0)))
    return concat_shapes(base, *bars)


def swing(phase: float, amplitude: float) -> tuple[float, float]:
    """Angles of the left and the right ball: half a period each."""
    c = amplitude * math.cos(2 * math.pi * phase)
    return (-c, 0.0) if c > 0 else (0.0, -c)


@register()
def cradle(phase: float = 0.0, balls: int = 5, amplitude: float = 0.7) -> Shape:
    left, right = swing(phase, amplitude)
    shapes = [library_call('frame', balls=balls)]
    for i in range(balls):
        angle = left if i == 0 else right if i == balls - 1 else 0.0
        p = library_call('pendulum', angle=angle, color=(0.85, 0.7, 0.3) if angle else (0.8, 0.8, 0.83))
        shapes.append(transform_shape(p, translation_matrix(((i - (balls - 1) / 2) * 2 * RADIUS, 0, 0))))
    return concat_shapes(*shapes)


@register()
def desk_top() -> Shape:
    return loop(6, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (3, 0.08, 0.39)}, color=(0.5 + 0.03 * (i % 2), 0.35, 0.2)), translation_matrix((0, -STRING - 0.49, -1 + 0.4 * i))))


@register_animation()
def animate() -> Generator[Shape, None, None]:
    damping = 0.985
    amplitude = 0.7
    for frame_index in range(FRAMES):
        yield concat_shapes(library_call('desk_top'), library_call('cradle', phase=frame_index / FRAMES * 2, amplitude=amplitude))
        amplitude *= damping
