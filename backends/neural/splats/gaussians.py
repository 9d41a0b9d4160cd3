"""3D Gaussians as tensors, their transformation by poses, and their projection to an image.

A Gaussian is ``exp(-(x - mu)' Sigma^-1 (x - mu) / 2)`` times its opacity. Under ``x -> A x + p`` its mean becomes
``A mu + p`` and its covariance ``A Sigma A'``, for any invertible A: rotations, non-uniform scales, reflections and
shear. If A is a rotation times a uniform scale, this is the paper's ``((R_t R)(S_t S))((R_t R)(S_t S))'``.
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
    """Parameters of N Gaussians, unconstrained except for ``colors``.

    Attributes
    ----------
    means
        (N, 3).
    log_scales
        (N, 3), logarithms of the standard deviations along the principal axes.
    quaternions
        (N, 4), w first, nonzero, not necessarily normalised.
    opacity_logits
        (N,).
    colors
        (N, 3), linear sRGB in [0, 1], larger for emission.
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
        """Principal axes (N, 3, 3) as columns, with the standard deviations as lengths."""
        return rotations(self.quaternions) * self.log_scales.exp()[:, None, :]

    @property
    def covariances(self) -> Tensor:
        """Covariance matrices (N, 3, 3)."""
        axes = self.axes
        return axes @ axes.mT

    @property
    def opacities(self) -> Tensor:
        """Opacities (N,) in (0, 1)."""
        return self.opacity_logits.sigmoid()

    def take(self, indices: Any) -> Gaussians:
        """Return the Gaussians selected by a mask or indices."""
        return Gaussians(*(column[indices] for column in _columns(self)))


@dataclass(frozen=True, slots=True, eq=False)
class Splats:
    """N Gaussians in world space, ready for rendering.

    Attributes
    ----------
    means
        (N, 3).
    covariances
        (N, 3, 3).
    opacities
        (N,), in [0, 1].
    colors
        (N, 3), linear sRGB.
    """

    means: Tensor
    covariances: Tensor
    opacities: Tensor
    colors: Tensor

    def __len__(self) -> int:
        return len(self.means)

    def take(self, indices: Any) -> Splats:
        """Return the splats selected by a mask or indices."""
        return Splats(self.means[indices], self.covariances[indices], self.opacities[indices], self.colors[indices])

    def transformed(self, matrix: Tensor, translation: Tensor) -> Splats:
        """Apply ``x -> matrix x + translation``, with shapes (3, 3) and (3,), or (N, 3, 3) and (N, 3)."""
        means = (matrix @ self.means[:, :, None])[:, :, 0] + translation
        return Splats(means, matrix @ self.covariances @ matrix.mT, self.opacities, self.colors)


def apply_pose(gaussians: Gaussians, matrix: Tensor, translation: Tensor) -> Splats:
    """Apply the pose ``x -> matrix x + translation``, with shapes (3, 3) and (3,), or (N, 3, 3) and (N, 3).

    Differentiable in Gaussians and pose; ``matrix`` may be any invertible matrix.
    """
    spread = matrix @ gaussians.axes  # as a product A A' the covariance stays symmetric and positive after rounding
    means = (matrix @ gaussians.means[:, :, None])[:, :, 0] + translation
    return Splats(means, spread @ spread.mT, gaussians.opacities, gaussians.colors)


def concatenate_splats(parts: Sequence[Splats]) -> Splats:
    """Concatenate at least one set of splats."""
    import torch

    columns = zip(*((s.means, s.covariances, s.opacities, s.colors) for s in parts), strict=True)
    return Splats(*(torch.cat(column) for column in columns))


def concatenate_gaussians(parts: Sequence[Gaussians]) -> Gaussians:
    """Concatenate at least one set of Gaussians."""
    import torch

    return Gaussians(*(torch.cat(column) for column in zip(*map(_columns, parts), strict=True)))


def _columns(gaussians: Gaussians) -> tuple[Tensor, ...]:
    g = gaussians
    return g.means, g.log_scales, g.quaternions, g.opacity_logits, g.colors


def gaussians_from(splats: Splats) -> Gaussians:
    """Return Gaussians equal to ``splats``, by eigendecomposition of the covariances; not differentiable."""
    import torch

    with torch.no_grad():
        variances, axes = torch.linalg.eigh(splats.covariances.double())
        axes = axes * torch.where(torch.linalg.det(axes) < 0.0, -1.0, 1.0)[:, None, None]  # proper rotations
        dtype = splats.means.dtype
        floor = torch.finfo(torch.float32).tiny
        log_scales = variances.clamp_min(floor).log() / 2.0
        return Gaussians(
            splats.means,
            log_scales.to(dtype),
            quaternions_from(axes).to(dtype),
            torch.logit(splats.opacities, 1e-6),
            splats.colors,
        )


def rotations(quaternions: Tensor) -> Tensor:
    """Return the rotation matrices (N, 3, 3) of nonzero quaternions (N, 4), w first."""
    import torch

    w, x, y, z = torch.nn.functional.normalize(quaternions, dim=-1).unbind(-1)
    rows = (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip
    return torch.stack(rows, dim=-1).reshape(*quaternions.shape[:-1], 3, 3)


def quaternions_from(matrices: Tensor) -> Tensor:
    """Return the unit quaternions (N, 4), w first, of rotation matrices (N, 3, 3)."""
    import torch

    (a, b, c), (d, e, f), (g, h, i) = (row.unbind(-1) for row in matrices.unbind(-2))
    # the quaternion times 4 w, 4 x, 4 y and 4 z (Shepperd 1978); the multiple with the largest factor is accurate
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


# Projection to ellipses in the image, sorted by depth; all constants and formulas are those of gsplat.
#
# EWA splatting (Zwicker et al. 2001): the covariance is projected by the Jacobian of the projection at the mean (with
# the mean clamped near the field of view), then dilated by ``EPS2D``, so that no splat is thinner than a pixel. With
# antialiasing the opacity is reduced by the ratio of the areas (Yu et al., "Mip-Splatting", 2024, section 5.2).


EPS2D = 0.3  # pixels squared
NEAR, FAR = 0.01, 1e10
MIN_ALPHA = 1.0 / 255.0  # smaller contributions to a pixel are skipped
MAX_ALPHA = 0.999
MIN_TRANSMITTANCE = 1e-4  # a pixel is finished before it would be less
_CUTOFF = 3.33  # standard deviations; there, an opacity of 1 has decreased to MIN_ALPHA
_CLAMP_MARGIN = 0.3  # in half sizes of the image, on every side
_MIN_AREA = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class ProjectedSplats:
    """The M visible splats, sorted from near to far; the order of equal depths is preserved.

    Attributes
    ----------
    index
        (M,), indices in the input.
    centers
        (M, 2), in pixels.
    conics
        (M, 3), inverse covariances [[a, b], [b, c]] as a, b, c.
    depths, opacities
        (M,).
    radii
        (M, 2), half sizes of the bounding boxes in whole pixels, x and y.
    """

    index: Tensor
    centers: Tensor
    conics: Tensor
    depths: Tensor
    opacities: Tensor
    radii: Tensor

    def __len__(self) -> int:
        return len(self.index)


def project(splats: Splats, view: View, antialiased: bool = False) -> ProjectedSplats:
    """Project splats; differentiable in the splats except for ``index`` and ``radii``, not in the view."""
    rotation, translation = view.world_to_camera[:3, :3], view.world_to_camera[:3, 3]
    local = splats.means @ rotation.T + translation
    in_front = ((local[:, 2] > NEAR) & (local[:, 2] < FAR)).nonzero()[:, 0]
    local = local[in_front]
    depths = local[:, 2]
    covariances = rotation @ splats.covariances[in_front] @ rotation.T
    centers, (xx, xy, yy) = (_orthographic if view.is_parallel else _perspective)(local, covariances, view)
    undilated = xx * yy - xy * xy
    xx, yy = xx + EPS2D, yy + EPS2D
    determinant = (xx * yy - xy * xy).clamp_min(_MIN_AREA)
    opacities = splats.opacities[in_front]
    if antialiased:
        opacities = opacities * (undilated / determinant).clamp_min(0.0).sqrt()
    conics = _stack(yy / determinant, -xy / determinant, xx / determinant)
    radii = _radii(xx, yy, opacities)
    visible = _visible(centers, conics, radii, opacities, view)
    order = visible[depths[visible].detach().sort(stable=True).indices]
    return ProjectedSplats(
        in_front[order], centers[order], conics[order], depths[order], opacities[order], radii[order]
    )  # fmt: skip


def _perspective(local: Tensor, covariances: Tensor, view: View) -> tuple[Tensor, tuple[Tensor, Tensor, Tensor]]:
    """Project means (M, 3) and covariances (M, 3, 3) in camera space to centers (M, 2) and covariances xx, xy, yy."""
    fx, fy, cx, cy = (float(view.intrinsics[i, j]) for i, j in ((0, 0), (1, 1), (0, 2), (1, 2)))
    x, y, z = local.unbind(-1)
    centers = _stack(fx * (x / z) + cx, fy * (y / z) + cy)
    # far outside the image the linear approximation would make splats arbitrarily large
    margin_x, margin_y = _CLAMP_MARGIN * 0.5 * view.width / fx, _CLAMP_MARGIN * 0.5 * view.height / fy
    x = (x / z).clamp(-cx / fx - margin_x, (view.width - cx) / fx + margin_x)
    y = (y / z).clamp(-cy / fy - margin_y, (view.height - cy) / fy + margin_y)
    row_x = _stack(fx / z, 0.0 * z, -fx * x / z)
    row_y = _stack(0.0 * z, fy / z, -fy * y / z)
    return centers, _project_covariances(row_x, row_y, covariances)


def _orthographic(local: Tensor, covariances: Tensor, view: View) -> tuple[Tensor, tuple[Tensor, Tensor, Tensor]]:
    fx, fy, cx, cy = (float(view.intrinsics[i, j]) for i, j in ((0, 0), (1, 1), (0, 2), (1, 2)))
    centers = _stack(fx * local[:, 0] + cx, fy * local[:, 1] + cy)
    c = covariances
    return centers, (fx * fx * c[:, 0, 0], fx * fy * c[:, 0, 1], fy * fy * c[:, 1, 1])


def _project_covariances(row_x: Tensor, row_y: Tensor, covariances: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Return xx, xy, yy of ``J Sigma J'`` for Jacobians with the rows ``row_x`` and ``row_y`` (M, 3)."""
    product_x = (covariances @ row_x[:, :, None])[:, :, 0]
    product_y = (covariances @ row_y[:, :, None])[:, :, 0]
    return (row_x * product_x).sum(-1), (row_y * product_x).sum(-1), (row_y * product_y).sum(-1)


def _stack(*columns: Tensor) -> Tensor:
    import torch

    return torch.stack(columns, dim=-1)


def _radii(xx: Tensor, yy: Tensor, opacities: Tensor) -> Tensor:
    """Return the distances (M, 2) from the center, in pixels, at which alpha decreases to MIN_ALPHA."""
    ratio = (opacities.detach() / MIN_ALPHA).clamp_min(1.0)
    deviations = (2.0 * ratio.log()).sqrt().clamp_max(_CUTOFF)[:, None]
    # larger than any image, but small enough for integers
    return (deviations * _stack(xx, yy).detach().sqrt()).ceil().nan_to_num(0.0).clamp_max(2.0**20)


def _visible(centers: Tensor, conics: Tensor, radii: Tensor, opacities: Tensor, view: View) -> Tensor:
    """Return the indices of the splats that are finite, overlap the image and are not too transparent."""
    import torch

    size = torch.tensor([view.width, view.height], dtype=centers.dtype, device=centers.device)
    inside = ((centers + radii > 0.0) & (centers - radii < size)).all(-1)
    inside &= conics.isfinite().all(-1)
    return (inside & (opacities >= MIN_ALPHA) & (radii > 0.0).all(-1)).nonzero()[:, 0]


# Views for rasterisation.


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Camera as tensors: ``world_to_camera`` (4, 4) and ``intrinsics`` (3, 3), with the conventions of
    ``camera.Camera`` and gsplat (x right, y down, z forward, pixel centers at half integers)."""

    world_to_camera: Tensor
    intrinsics: Tensor
    width: int
    height: int
    is_parallel: bool = False


def view_of(camera: Camera, like: Tensor) -> View:
    """Return the view of ``camera``, without depth of field; its tensors have the dtype and device of ``like``."""
    import torch

    pose, intrinsics = (torch.as_tensor(m).to(like) for m in (camera.world_to_camera, camera.intrinsics))
    return View(pose, intrinsics, camera.width, camera.height, camera.is_parallel)
