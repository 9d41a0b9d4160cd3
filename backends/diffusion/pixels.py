"""From pictures to what a diffusion model denoises, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL

if TYPE_CHECKING:
    from torch import Tensor


class Pixels(Protocol):
    """Both ways are differentiable. Pictures (B, 3, H, W) are sRGB in [0, 1], H and W multiples of ``factor``;
    latents (B, C, H / factor, W / factor). What comes back of a picture keeps its type and device."""

    @property
    def factor(self) -> int:
        """Pixels of a picture for one of the latents, along a side."""

    def encode(self, pictures: Tensor) -> Tensor:
        """The latents of pictures."""

    def decode(self, latents: Tensor) -> Tensor:
        """The pictures of latents, not cut to [0, 1]."""


class Autoencoder:
    """Latents of an AutoencoderKL: the mean of what it takes a picture for, times its scaling factor."""

    def __init__(self, network: Any) -> None:
        self._network = network
        self._scale = float(network.config.scaling_factor)

    @property
    def factor(self) -> int:
        return 1 << (len(self._network.config.block_out_channels) - 1)

    def encode(self, pictures: Tensor) -> Tensor:
        found = self._network.encode((2.0 * pictures - 1.0).to(self._network.dtype)).latent_dist.mean
        return (found * self._scale).to(pictures.dtype)  # type: ignore[no-any-return]

    def decode(self, latents: Tensor) -> Tensor:
        found = self._network.decode((latents / self._scale).to(self._network.dtype)).sample
        return (found.to(latents.dtype) + 1.0) / 2.0  # type: ignore[no-any-return]


class Unshuffled:
    """Latents of models without an autoencoder: the pixels of squares of ``factor`` x ``factor`` as channels."""

    def __init__(self, factor: int) -> None:
        self._functional = need("torch.nn.functional", INSTALL)
        self._factor = factor

    @property
    def factor(self) -> int:
        return self._factor

    def encode(self, pictures: Tensor) -> Tensor:
        return self._functional.pixel_unshuffle(2.0 * pictures - 1.0, self._factor)  # type: ignore[no-any-return]

    def decode(self, latents: Tensor) -> Tensor:
        return (self._functional.pixel_shuffle(latents, self._factor) + 1.0) / 2.0  # type: ignore[no-any-return]
