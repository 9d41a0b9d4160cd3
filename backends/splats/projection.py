"""Splats as a camera sees them: ellipses in the picture, nearest first, exactly as gsplat makes them.

The covariance is projected by the derivative of the projection at the centre (held near the field of view where the
derivative is taken), then widened by ``EPS2D`` pixels squared, so that nothing is thinner than a pixel. In the
antialiased mode the opacity is lowered by as much as that made the ellipse larger.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.splats.gaussians import Splats
    from scenelang.backends.splats.view import View

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
