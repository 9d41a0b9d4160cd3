"""A diffusion model with all that belongs to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.backends.diffusion.multiview import fold_views
from scenelang.backends.diffusion.pixels import Pixels
from scenelang.backends.diffusion.schedule import Schedule
from scenelang.backends.diffusion.words import Words
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True, slots=True, eq=False)
class Diffusion:
    """``network`` is a UNet2DConditionModel of diffusers, made ready for its views here; ``size`` the pixels of a
    picture's side that it was trained on, ``views`` how many pictures it denoises together, 1 where it knows no
    cameras; ``control`` a ControlNetModel that keeps pictures to a depth map."""

    name: str
    network: Any
    schedule: Schedule
    pixels: Pixels
    words: Words
    size: int
    views: int = 1
    control: Any = None

    def __post_init__(self) -> None:
        for network in (self.network, self.control):
            if self.views > 1 and network is not None and network.class_embedding is not None:
                fold_views(network)

    def predict(
        self, latents: Tensor, steps: Tensor, states: Tensor, cameras: Tensor | None = None, depth: Tensor | None = None
    ) -> Tensor:
        """The network's output (B, C, h, w) for noisy ``latents`` of that shape after ``steps`` (B,), told ``states``
        (B, T, D) of the prompts.

        ``cameras`` (B, 16), rows of ``multiview.camera_rows``: each run of ``views`` rows is denoised together, so B
        is a multiple of that. Without them every picture is denoised alone and without camera. ``depth`` (B, 3, H, W)
        in [0, 1] is the control's picture. The weights' type is used inside, that of ``latents`` comes back. Raises
        SceneError("value") for cameras or depth that this model cannot take.
        """
        if cameras is not None:
            self._check(cameras, len(latents))
        residuals = {} if depth is None else self._controlled(latents, steps, states, cameras, depth)
        kind = self.network.dtype
        output = self.network(
            latents.to(kind),
            steps,
            encoder_hidden_states=states.to(kind),
            **self._conditions(self.network, latents, cameras),
            **residuals,
            return_dict=False,
        )[0]
        return output.to(latents.dtype)  # type: ignore[no-any-return]

    def _controlled(
        self, latents: Tensor, steps: Tensor, states: Tensor, cameras: Tensor | None, depth: Tensor
    ) -> dict[str, Any]:
        """What the control adds to the network's own features."""
        if self.control is None:
            hint = "name a ControlNet for depth that belongs to it"
            raise SceneError(
                "value", f"the model `{self.name}` has no control, so it cannot keep to a depth", hint=hint
            )
        kind, own = self.control.dtype, self.network.dtype
        down, middle = self.control(
            latents.to(kind),
            steps,
            encoder_hidden_states=states.to(kind),
            controlnet_cond=depth.to(kind),
            **self._conditions(self.control, latents, cameras),
            return_dict=False,
        )
        return {
            "down_block_additional_residuals": [part.to(own) for part in down],
            "mid_block_additional_residual": middle.to(own),
        }

    def _conditions(self, network: Any, latents: Tensor, cameras: Tensor | None) -> dict[str, Any]:
        """Cameras and groups as ``network`` takes them."""
        if self.views == 1 or network.class_embedding is None:
            return {}
        rows = latents.new_zeros((len(latents), 16)) if cameras is None else cameras
        views = 1 if cameras is None else self.views
        return {
            "class_labels": rows.to(latents.device, network.dtype),
            "cross_attention_kwargs": {"views": views},
        }

    def _check(self, cameras: Tensor, count: int) -> None:
        if self.views == 1:
            raise SceneError("value", f"the model `{self.name}` denoises single pictures and knows no cameras")
        if cameras.shape != (count, 16) or count % self.views:
            shape = " x ".join(map(str, cameras.shape))
            message = f"{count} pictures with cameras of {shape} numbers; `{self.name}` wants groups of {self.views}"
            raise SceneError("value", f"{message}, and 16 numbers each")
