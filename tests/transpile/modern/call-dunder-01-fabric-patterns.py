from helper import *
import math

"""
flags of cloth whose height comes from callable wave objects
"""

class Wave:
    def __init__(self, amplitude: float, frequency: float, phase: float = 0.0):
        self.amplitude, self.frequency, self.phase = amplitude, frequency, phase
        self.calls = 0

    def __call__(self, t: float) -> float:
        self.calls += 1
        return self.amplitude * math.sin(self.frequency * t + self.phase)

    def __add__(self, other):
        return Sum(self, other)

class Sum:
    def __init__(self, *terms):
        self.terms = terms

    def __call__(self, t):
        return sum(term(t) for term in self.terms)

    def __add__(self, other):
        return Sum(*self.terms, other)

class Clip:
    def __init__(self, low, high):
        self.low, self.high = low, high

    def __call__(self, fn):
        # also usable as a decorator
        def clipped(t):
            return min(max(fn(t), self.low), self.high)
        return clipped

@Clip(0, 0.3)
def ramp(t: float) -> float:
    return t / 10

@register()
def cloth(profile: Callable[[float], float], color: tuple, strips: int = 20) -> Shape:
    width = 0.2
    def strip(i):
        x = width * i
        shape = primitive_call('cube', color=tuple(c * (0.8 + 0.2 * (i % 2)) for c in color), shape_kwargs={'scale': (width, 1.0, 0.04)})
        return transform_shape(shape, translation_matrix((x, 0, profile(x))))
    return loop(strips, strip)

@register()
def fabric_display() -> Shape:
    slow, fast = Wave(0.3, 1.5), Wave(0.1, 6, math.pi / 2)
    profiles = [slow, slow + fast, slow + fast + ramp, Clip(-0.2, 0.2)(slow), lambda t: abs(fast(t))]
    palette = [(0.8, 0.2, 0.2), (0.2, 0.6, 0.3), (0.2, 0.3, 0.8), (0.8, 0.7, 0.2), (0.6, 0.2, 0.6)]
    shapes = []
    for k, (profile, color) in enumerate(zip(profiles, palette)):
        assert callable(profile)
        shapes.append(transform_shape(library_call('cloth', profile=profile, color=color), translation_matrix((0, -1.2 * k, 0))))
    rail = primitive_call('cylinder', color=(0.4, 0.4, 0.4), shape_kwargs={'radius': 0.05, 'p0': (-0.2, 0.6, 0), 'p1': (0.05 * slow.calls, 0.6, 0)})
    return concat_shapes(*shapes, rail)
