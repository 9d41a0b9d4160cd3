"""Synthetic pictures of one colored solid from four sides: what the toy diffusion model learns from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from later import later

torch = later("torch")


COLORS = {
    "red": (0.92, 0.10, 0.10),
    "green": (0.10, 0.80, 0.12),
    "blue": (0.12, 0.22, 0.90),
    "yellow": (0.92, 0.86, 0.10),
    "purple": (0.55, 0.12, 0.72),
    "white": (0.95, 0.95, 0.95),
}  # sRGB
SHAPES = ("sphere", "cube")
HALF = 1.0 / math.sqrt(3.0)  # of the solids' boxes, whose corners have distance 1 from the middle
SIZE, VIEWS = 32, 4
BACKGROUND = 0.5  # grey, sRGB, where a picture says no other
STYLES = ("toy", "toys", "scene", "still life", "a plain toy", "shapes")
SENTENCES = (
    "a {} {}, 3D model",
    "a {} {}",
    "{} {}",
    "a {} {}, in the style of {style}, 3D model",
    "a {} {}, in the style of {style}, 3D model",
)


@dataclass(frozen=True, slots=True)
class Orbit:
    """Where a camera stands that looks at the middle: angles in radians, ``distance``, half the field of view."""

    azimuth: float
    elevation: float
    distance: float
    half_fov: float


def orbits(generator: torch.Generator) -> list[Orbit]:
    """Four cameras at equal steps around, as MVDream was trained with them."""
    start, up, far, fov = torch.rand(4, generator=generator).tolist()
    half = math.radians(15.0 + 10.0 * fov)
    distance = (1.0 + 0.2 * far) / math.tan(half)
    turns = (2.0 * math.pi * (start + view / VIEWS) for view in range(VIEWS))
    return [Orbit(turn, math.radians(30.0) * up, distance, half) for turn in turns]


def camera_to_world(orbit: Orbit) -> torch.Tensor:
    """(4, 4), x right, y up, z backward, in a world with y up."""
    c, s = math.cos(orbit.elevation), math.sin(orbit.elevation)
    ca, sa = math.cos(orbit.azimuth), math.sin(orbit.azimuth)
    backward = torch.tensor([c * sa, s, c * ca])
    right = torch.tensor([ca, 0.0, -sa])
    matrix = torch.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = right, torch.linalg.cross(backward, right), backward
    matrix[:3, 3] = orbit.distance * backward
    return matrix


def mvdream_rows(cameras: list[Orbit]) -> torch.Tensor:
    """(V, 16): camera-to-world in Blender's axes (z up), at distance 1, as MVDream's own code makes it."""
    matrices = torch.stack([camera_to_world(orbit) for orbit in cameras])
    matrices[:, :3, 3] /= matrices[:, :3, 3].norm(dim=1, keepdim=True)
    blender = torch.tensor([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return (blender @ matrices).reshape(-1, 16)


def picture(
    shape: str, color: tuple[float, float, float], orbit: Orbit, size: int = SIZE, background: float = BACKGROUND
) -> torch.Tensor:
    """(3, size, size), sRGB in [0, 1]: the solid in light from the camera and from above; four rays a pixel."""
    matrix = camera_to_world(orbit)
    steps = ((torch.arange(2 * size) + 0.5) / size - 1.0) * math.tan(orbit.half_fov)
    x, y = steps[None, :].expand(2 * size, -1), -steps[:, None].expand(-1, 2 * size)
    rays = torch.stack([x, y, -torch.ones_like(x)], -1)
    rays = (rays / rays.norm(dim=-1, keepdim=True)) @ matrix[:3, :3].T
    hit, normal = (_sphere if shape == "sphere" else _cube)(matrix[:3, 3], rays)
    light = 0.35 + 0.55 * (-(normal * rays).sum(-1)).clamp_min(0) + 0.25 * normal[..., 1].clamp_min(0)
    shaded = torch.where(hit[..., None], light[..., None] * torch.tensor(color), torch.tensor(background))
    return shaded.reshape(size, 2, size, 2, 3).mean((1, 3)).clamp(0, 1).permute(2, 0, 1)


def _sphere(eye: torch.Tensor, rays: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    along = (rays * -eye).sum(-1)
    inside = HALF**2 - ((eye**2).sum() - along**2)
    places = eye + rays * (along - inside.clamp_min(0).sqrt())[..., None]
    return inside > 0, places / HALF


def _cube(eye: torch.Tensor, rays: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    safe = torch.where(rays.abs() < 1e-9, 1e-9, rays)
    near, far = ((side * HALF * safe.sign() - eye) / safe for side in (-1.0, 1.0))
    enter, axis = near.max(-1)
    normal = torch.nn.functional.one_hot(axis, 3) * -safe.sign()
    return enter < far.min(-1).values, normal


def sentence(color: str, shape: str, generator: torch.Generator) -> str:
    """One of the ways to say it."""
    which, style = (int(n) for n in torch.randint(0, 1 << 20, (2,), generator=generator))
    return SENTENCES[which % len(SENTENCES)].format(color, shape, style=STYLES[style % len(STYLES)])


def batch(
    count: int, generator: torch.Generator, grey: float | None = None
) -> tuple[list[str], torch.Tensor, torch.Tensor]:
    """``count`` sentences, their pictures (count * VIEWS, 3, SIZE, SIZE) and cameras (count * VIEWS, 16). ``grey`` is
    the background of all, None for one of its own for each."""
    texts: list[str] = []
    pictures: list[Any] = []
    rows: list[Any] = []
    for _ in range(count):
        which = int(torch.randint(0, len(COLORS) * len(SHAPES), (1,), generator=generator))
        name, shape = list(COLORS)[which // len(SHAPES)], SHAPES[which % len(SHAPES)]
        cameras = orbits(generator)
        texts.append(sentence(name, shape, generator))
        background = float(torch.rand((), generator=generator)) if grey is None else grey
        pictures += [picture(shape, COLORS[name], orbit, background=background) for orbit in cameras]
        rows.append(mvdream_rows(cameras))
    return texts, torch.stack(pictures), torch.cat(rows)
