"""a stroboscopic photo of a bouncing ball, with ghost balls fading over time"""
from helper import *
from dataclasses import dataclass
from itertools import islice


@dataclass
class Ball:
    x: float = -4.0
    y: float = 3.0
    vx: float = 1.6
    vy: float = 0.0
    radius: float = 0.25
    restitution: float = 0.78
    g: float = 9.81

    def step(self, dt: float) -> None:
        self.vy -= self.g * dt
        self.x += self.vx * dt
        self.y += self.vy * dt
        if self.y < self.radius and self.vy < 0:
            self.y = self.radius
            self.vy *= -self.restitution

    @property
    def energy(self) -> float:
        return 0.5 * (self.vx ** 2 + self.vy ** 2) + self.g * self.y


def strobe(ball: Ball, dt: float = 0.005, every: int = 16):
    tick = 0
    while True:
        if tick % every == 0:
            yield ball.x, ball.y, ball.energy
        ball.step(dt)
        tick += 1


@register()
def ghost(x: float, y: float, radius: float, shade: float) -> Shape:
    color = (1.0, 0.2 + 0.6 * shade, 0.1 + 0.8 * shade)
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': radius}, color=color), translation_matrix([x, y, 0]))


@register()
def trajectory(frames: int = 60) -> Shape:
    ball = Ball()
    samples = list(islice(strobe(ball), frames))
    e0 = samples[0][2]
    assert all(e <= e0 * 1.05 for *_, e in samples), "energy should not grow"
    return concat_shapes(*[
        library_call('ghost', x=x, y=y, radius=ball.radius * (0.5 + 0.5 * i / frames), shade=1 - i / (frames - 1))
        for i, (x, y, _) in enumerate(samples)
    ])


@register()
def stage(width: float = 12.0) -> Shape:
    floor = primitive_call('cube', shape_kwargs={'scale': (width, 0.2, 3)}, color=(0.3, 0.3, 0.35))
    ruler = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.03, 0.02, 2.8)}, color=(1, 1, 1)),
                             translation_matrix((x, 0.1, 0))) for x in range(-5, 6)]
    return transform_shape(concat_shapes(floor, *ruler), translation_matrix((0, -0.1, 0)))


@register()
def strobe_photo() -> Shape:
    return concat_shapes(library_call('stage'), library_call('trajectory', frames=64))
