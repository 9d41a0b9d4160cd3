from helper import *
import math

"""
a telescope on a tripod, controlled through properties
"""


class Telescope:
    MIN_ALT, MAX_ALT = 0.0, 85.0

    def __init__(self, aperture: float = 0.3, altitude: float = 30, azimuth: float = 0):
        self._aperture = aperture
        self.altitude = altitude
        self.azimuth = azimuth

    @property
    def altitude(self) -> float:
        return self._altitude

    @altitude.setter
    def altitude(self, degrees: float) -> None:
        self._altitude = max(self.MIN_ALT, min(self.MAX_ALT, degrees))

    @property
    def azimuth(self) -> float:
        return self._azimuth

    @azimuth.setter
    def azimuth(self, degrees: float) -> None:
        self._azimuth = degrees % 360

    @property
    def focal_length(self) -> float:
        """Read only: follows from the aperture."""
        return self._aperture * 6

    @property
    def aperture(self):
        return self._aperture

    @aperture.deleter
    def aperture(self):
        self._aperture = 0.1

    def pose(self):
        tilt = rotation_matrix(math.radians(self.altitude), direction=(0, 0, 1), point=(0, 0, 0))
        turn = rotation_matrix(math.radians(self.azimuth), direction=(0, 1, 0), point=(0, 0, 0))
        return translation_matrix((0, 1.5, 0)) @ turn @ tilt

    def tube(self) -> Shape:
        f, r = self.focal_length, self._aperture / 2
        main = primitive_call('cylinder', color=(0.9, 0.9, 0.95), shape_kwargs={'radius': r, 'p0': (-f / 3, 0, 0), 'p1': (f * 2 / 3, 0, 0)})
        eyepiece = primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': r / 3, 'p0': (-f / 3 - 0.2, 0, 0), 'p1': (-f / 3, 0, 0)})
        return transform_shape(concat_shapes(main, eyepiece), self.pose())


@register()
def tripod() -> Shape:
    return loop(3, lambda i: primitive_call('cylinder', color=(0.4, 0.25, 0.1), shape_kwargs={
        'radius': 0.04, 'p0': (0.7 * math.cos(i * 2 * math.pi / 3), 0, 0.7 * math.sin(i * 2 * math.pi / 3)), 'p1': (0, 1.5, 0)}))


@register()
def observatory() -> Shape:
    shapes = []
    for k, target in enumerate([20, 60, 120, -15]):
        scope = Telescope(0.2 + 0.05 * k)
        scope.altitude += target
        scope.azimuth -= 45 * k
        if k == 3:
            del scope.aperture
        try:
            scope.focal_length = 9
        except AttributeError:
            pass
        shapes.append(transform_shape(concat_shapes(library_call('tripod'), scope.tube()), translation_matrix((2.5 * k, 0, 0))))
    return concat_shapes(*shapes)
