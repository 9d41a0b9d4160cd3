"""3D Gaussians as tensors, and the law by which a pose moves them.

A Gaussian is ``exp(-(x - mu)' Sigma^-1 (x - mu) / 2)`` times its opacity. Under ``x -> A x + p`` its centre becomes
``A mu + p`` and its covariance ``A Sigma A'``, for any invertible A: turns, unequal scales, mirrors and shear. Where A
is a turn times one scale, this is the paper's ``((R_t R)(S_t S))((R_t R)(S_t S))'``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.backends.pictures.camera import Camera

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True, slots=True, eq=False)
class Gaussians:
    """N Gaussians by what an optimiser changes; no value needs to be kept in bounds but ``colors``.

    ``means`` (N, 3); ``log_scales`` (N, 3), the logarithms of the standard deviations along the own axes;
    ``quaternions`` (N, 4), w first, of any length but 0; ``opacity_logits`` (N,); ``colors`` (N, 3), linear sRGB in
    [0, 1], or more where something glows.
    """

    means: Tensor
    log_scales: Tensor
    quaternions: Tensor
    opacity_logits: Tensor
    colors: Tensor

    def __len__(self) -> int:
        return len(self.means)

    @property
    def axes(self) -> Tensor:
        """(N, 3, 3): the columns are the own axes, as long as the standard deviations."""
        return rotations(self.quaternions) * self.log_scales.exp()[:, None, :]

    @property
    def covariances(self) -> Tensor:
        """(N, 3, 3)"""
        axes = self.axes
        return axes @ axes.mT

    @property
    def opacities(self) -> Tensor:
        """(N,) in (0, 1)"""
        return self.opacity_logits.sigmoid()

    def take(self, which: Any) -> Gaussians:
        """The Gaussians that a mask or indices select."""
        return Gaussians(*(column[which] for column in _columns(self)))


@dataclass(frozen=True, slots=True, eq=False)
class Splats:
    """N Gaussians where they stand in the world, ready to be drawn: ``means`` (N, 3), ``covariances`` (N, 3, 3),
    ``opacities`` (N,) in [0, 1], ``colors`` (N, 3) in linear sRGB."""

    means: Tensor
    covariances: Tensor
    opacities: Tensor
    colors: Tensor

    def __len__(self) -> int:
        return len(self.means)

    def take(self, which: Any) -> Splats:
        """The splats that a mask or indices select."""
        return Splats(self.means[which], self.covariances[which], self.opacities[which], self.colors[which])

    def moved(self, matrix: Tensor, place: Tensor) -> Splats:
        """The splats after ``x -> matrix x + place``, (3, 3) and (3,), or (N, 3, 3) and (N, 3) of each its own."""
        means = (matrix @ self.means[:, :, None])[:, :, 0] + place
        return Splats(means, matrix @ self.covariances @ matrix.mT, self.opacities, self.colors)


def posed(gaussians: Gaussians, matrix: Tensor, place: Tensor) -> Splats:
    """The Gaussians under the pose ``x -> matrix x + place``, (3, 3) and (3,), or one for each, (N, 3, 3) and (N, 3).

    Differentiable in the Gaussians and in the pose; ``matrix`` may be any invertible one.
    """
    spread = matrix @ gaussians.axes  # keeps the covariance symmetric and positive, however the pose is rounded
    means = (matrix @ gaussians.means[:, :, None])[:, :, 0] + place
    return Splats(means, spread @ spread.mT, gaussians.opacities, gaussians.colors)


def joined(parts: Sequence[Splats]) -> Splats:
    """All splats of at least one part, one after the other."""
    import torch

    columns = zip(*((s.means, s.covariances, s.opacities, s.colors) for s in parts), strict=True)
    return Splats(*(torch.cat(column) for column in columns))


def joined_gaussians(parts: Sequence[Gaussians]) -> Gaussians:
    """All Gaussians of at least one part, one after the other."""
    import torch

    return Gaussians(*(torch.cat(column) for column in zip(*map(_columns, parts), strict=True)))


def _columns(gaussians: Gaussians) -> tuple[Tensor, ...]:
    one = gaussians
    return one.means, one.log_scales, one.quaternions, one.opacity_logits, one.colors


def gaussians_from(splats: Splats) -> Gaussians:
    """The Gaussians that, unposed, are ``splats``: a turn and three scales for each covariance, which a posed Gaussian
    always has. Not differentiable."""
    import torch

    with torch.no_grad():
        squares, axes = torch.linalg.eigh(splats.covariances.double())
        axes = axes * torch.where(torch.linalg.det(axes) < 0.0, -1.0, 1.0)[:, None, None]
        dtype = splats.means.dtype
        floor = torch.finfo(torch.float32).tiny
        scales = squares.clamp_min(floor).log() / 2.0
        return Gaussians(
            splats.means,
            scales.to(dtype),
            quaternions_from(axes).to(dtype),
            torch.logit(splats.opacities, 1e-6),
            splats.colors,
        )


def rotations(quaternions: Tensor) -> Tensor:
    """Rotation matrices (N, 3, 3) of quaternions (N, 4), w first, of any length but 0."""
    import torch

    w, x, y, z = torch.nn.functional.normalize(quaternions, dim=-1).unbind(-1)
    rows = (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip
    return torch.stack(rows, dim=-1).reshape(*quaternions.shape[:-1], 3, 3)


def quaternions_from(turns: Tensor) -> Tensor:
    """Unit quaternions (N, 4), w first, of rotation matrices (N, 3, 3)."""
    import torch

    (a, b, c), (d, e, f), (g, h, i) = (row.unbind(-1) for row in turns.unbind(-2))
    # four forms of each quaternion, times 4 w, 4 x, 4 y and 4 z: the one with the largest factor is exact
    forms = torch.stack(
        [
            torch.stack([1.0 + a + e + i, h - f, c - g, d - b], -1),
            torch.stack([h - f, 1.0 + a - e - i, b + d, c + g], -1),
            torch.stack([c - g, b + d, 1.0 - a + e - i, f + h], -1),
            torch.stack([d - b, c + g, f + h, 1.0 - a - e + i], -1),
        ],
        dim=-2,
    )
    best = forms.diagonal(dim1=-2, dim2=-1).argmax(-1)
    return torch.nn.functional.normalize(forms[torch.arange(len(forms), device=forms.device), best], dim=-1)


# Splats as a camera sees them: ellipses in the picture, nearest first, exactly as gsplat makes them.
#
# The covariance is projected by the derivative of the projection at the centre (held near the field of view where the
# derivative is taken), then widened by ``EPS2D`` pixels squared, so that nothing is thinner than a pixel. In the
# antialiased mode the opacity is lowered by as much as that made the ellipse larger.


EPS2D = 0.3  # pixels squared
NEAR, FAR = 0.01, 1e10
LEAST_ALPHA = 1.0 / 255.0  # what hides less of a pixel than this is not drawn there
MOST_ALPHA = 0.999
LEAST_LIGHT = 1e-4  # a pixel is done before what would let less than this through
_REACH = 3.33  # standard deviations at which an opacity of 1 has fallen to LEAST_ALPHA
_BEYOND = 0.3  # of half the picture, on every side
_LEAST_AREA = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class Projected:
    """The M splats that can be seen, nearest first; those of equal depth in the order they came in.

    ``index`` (M,) says which they are; ``centers`` (M, 2) in pixels; ``conics`` (M, 3), the inverse covariances
    [[a, b], [b, c]] as a, b, c; ``depths`` (M,); ``opacities`` (M,); ``radii`` (M, 2), whole pixels across and down,
    beyond which a splat is not drawn.
    """

    index: Tensor
    centers: Tensor
    conics: Tensor
    depths: Tensor
    opacities: Tensor
    radii: Tensor

    def __len__(self) -> int:
        return len(self.index)


def project(splats: Splats, view: View, antialiased: bool = False) -> Projected:
    """What ``view`` sees of ``splats``; differentiable but for ``index`` and ``radii``, and not in the view."""
    turn, shift = view.world_to_camera[:3, :3], view.world_to_camera[:3, 3]
    local = splats.means @ turn.T + shift
    before = ((local[:, 2] > NEAR) & (local[:, 2] < FAR)).nonzero()[:, 0]
    local = local[before]
    depths = local[:, 2]
    spread = turn @ splats.covariances[before] @ turn.T
    centers, (xx, xy, yy) = (_parallel if view.is_parallel else _perspective)(local, spread, view)
    tight = xx * yy - xy * xy
    xx, yy = xx + EPS2D, yy + EPS2D
    area = (xx * yy - xy * xy).clamp_min(_LEAST_AREA)
    opacities = splats.opacities[before]
    if antialiased:
        opacities = opacities * (tight / area).clamp_min(0.0).sqrt()
    conics = _stacked(yy / area, -xy / area, xx / area)
    radii = _radii(xx, yy, opacities)
    seen = _seen(centers, conics, radii, opacities, view)
    order = seen[depths[seen].detach().sort(stable=True).indices]
    return Projected(
        before[order], centers[order], conics[order], depths[order], opacities[order], radii[order]
    )  # fmt: skip


def _perspective(local: Tensor, spread: Tensor, view: View) -> tuple[Tensor, tuple[Tensor, Tensor, Tensor]]:
    """Centres (M, 2) in pixels and the covariances there, xx, xy, yy, of (M, 3) and (M, 3, 3) before the camera."""
    fx, fy, cx, cy = (float(view.intrinsics[i, j]) for i, j in ((0, 0), (1, 1), (0, 2), (1, 2)))
    x, y, z = local.unbind(-1)
    centers = _stacked(fx * (x / z) + cx, fy * (y / z) + cy)
    more_x, more_y = _BEYOND * 0.5 * view.width / fx, _BEYOND * 0.5 * view.height / fy
    x = (x / z).clamp(-cx / fx - more_x, (view.width - cx) / fx + more_x)
    y = (y / z).clamp(-cy / fy - more_y, (view.height - cy) / fy + more_y)
    across = _stacked(fx / z, 0.0 * z, -fx * x / z)
    down = _stacked(0.0 * z, fy / z, -fy * y / z)
    return centers, _between(across, down, spread)


def _parallel(local: Tensor, spread: Tensor, view: View) -> tuple[Tensor, tuple[Tensor, Tensor, Tensor]]:
    fx, fy, cx, cy = (float(view.intrinsics[i, j]) for i, j in ((0, 0), (1, 1), (0, 2), (1, 2)))
    centers = _stacked(fx * local[:, 0] + cx, fy * local[:, 1] + cy)
    return centers, (fx * fx * spread[:, 0, 0], fx * fy * spread[:, 0, 1], fy * fy * spread[:, 1, 1])


def _between(across: Tensor, down: Tensor, spread: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """The products of the rows (M, 3) of a derivative with (M, 3, 3) between them."""
    wide = (spread @ across[:, :, None])[:, :, 0]
    high = (spread @ down[:, :, None])[:, :, 0]
    return (across * wide).sum(-1), (down * wide).sum(-1), (down * high).sum(-1)


def _stacked(*columns: Tensor) -> Tensor:
    import torch

    return torch.stack(columns, dim=-1)


def _radii(xx: Tensor, yy: Tensor, opacities: Tensor) -> Tensor:
    """How many pixels (M, 2) from its centre a splat can still hide LEAST_ALPHA of one."""
    strength = (opacities.detach() / LEAST_ALPHA).clamp_min(1.0)
    reach = (2.0 * strength.log()).sqrt().clamp_max(_REACH)[:, None]
    # more than the picture can be wide would overflow whole numbers
    return (reach * _stacked(xx, yy).detach().sqrt()).ceil().nan_to_num(0.0).clamp_max(2.0**20)


def _seen(centers: Tensor, conics: Tensor, radii: Tensor, opacities: Tensor, view: View) -> Tensor:
    """The numbers of the splats that are finite, reach into the picture and hide enough of it."""
    import torch

    size = torch.tensor([view.width, view.height], dtype=centers.dtype, device=centers.device)
    inside = ((centers + radii > 0.0) & (centers - radii < size)).all(-1)
    inside &= conics.isfinite().all(-1)
    return (inside & (opacities >= LEAST_ALPHA) & (radii > 0.0).all(-1)).nonzero()[:, 0]


# From the project's one camera to what the rasteriser takes.


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A camera as tensors: ``world_to_camera`` (4, 4) and ``intrinsics`` (3, 3), as ``camera.Camera`` defines them,
    which is also gsplat's convention (x right, y down, z forward, pixel centres at halves)."""

    world_to_camera: Tensor
    intrinsics: Tensor
    width: int
    height: int
    is_parallel: bool = False


def view_of(camera: Camera, like: Tensor) -> View:
    """``camera`` as a view, its tensors of the type and on the device of ``like``. Its lens is taken for a pinhole."""
    import torch

    pose, intrinsics = (torch.as_tensor(m).to(like) for m in (camera.world_to_camera, camera.intrinsics))
    return View(pose, intrinsics, camera.width, camera.height, camera.is_parallel)
