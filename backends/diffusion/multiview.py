"""What makes a UNet of diffusers one of several views: cameras as conditions, self-attention over all views (MVDream).

The network is a ``UNet2DConditionModel(class_embed_type="projection", projection_class_embeddings_input_dim=16)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.backends.base import need
from scenelang.backends.camera import Camera, FloatArray
from scenelang.backends.weights import INSTALL

if TYPE_CHECKING:
    from torch import Tensor

VIEWS = 4  # that MVDream was trained on

# Our world in MVDream's. Ours has +y up, and the front of a thing at +z (azimuth 0). MVDream's is Blender's, +z up,
# with the front at +x: its sampling script begins with the view of azimuth 90, where `get_camera` puts the eye at +x,
# and threestudio, which trains with its cameras, counts azimuths from +x with the front at 0. So +z becomes +x, +y
# becomes +z and, since the turn keeps handedness, +x becomes +y.
_WORLD = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


# --- cameras ---------------------------------------------------------------------------------------------------------


def camera_row(world_to_camera: FloatArray) -> FloatArray:
    """The 16 numbers that MVDream knows a camera by, which looks at a thing around the origin.

    ``world_to_camera`` (4, 4) is rigid, its axes those of ``camera.Camera``. The numbers are the rows of the matrix
    from camera (x right, y up, z back) to Blender's world, the eye moved to distance 1.
    """
    turn = world_to_camera[:3, :3].T
    eye = -turn @ world_to_camera[:3, 3]
    pose = np.eye(4)
    pose[:3, :3] = _WORLD @ turn @ np.diag([1.0, -1.0, -1.0])
    pose[:3, 3] = _WORLD @ eye / max(float(np.linalg.norm(eye)), 1e-8)
    return pose.reshape(16)


def camera_rows(cameras: Sequence[Camera]) -> Tensor:
    """(V, 16) of cameras whose thing stands around the origin."""
    torch = need("torch", INSTALL)
    rows = np.stack([camera_row(camera.world_to_camera) for camera in cameras])
    return torch.from_numpy(rows).float()  # type: ignore[no-any-return]


# --- the network -----------------------------------------------------------------------------------------------------


def fold_views(network: Any) -> None:
    """Gives ``network``, a UNet or ControlNet with cameras for classes, what it needs to denoise views together.

    It then takes ``cross_attention_kwargs={"views": V}``: each run of V rows of a batch is one group. A row of zeros
    in ``class_labels`` stands for no camera, and adds nothing to the embedding of the step.
    """
    if any(isinstance(processor, FoldedAttention) for processor in network.attn_processors.values()):
        return
    network.set_attn_processor(FoldedAttention())
    network.class_embedding.register_forward_hook(_without_camera)


class FoldedAttention:
    """Attention of diffusers whose tokens look at those of all views of their group; words are looked at as usual."""

    def __init__(self) -> None:
        self._plain = need("diffusers.models.attention_processor", INSTALL).AttnProcessor2_0()

    def __call__(
        self,
        attn: Any,
        hidden_states: Tensor,
        encoder_hidden_states: Tensor | None = None,
        attention_mask: Tensor | None = None,
        temb: Tensor | None = None,
        views: int = 1,
    ) -> Tensor:
        """``hidden_states`` (B, L, C), B a multiple of ``views``; the same shape comes back."""
        if encoder_hidden_states is not None:
            found = self._plain(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
            return found  # type: ignore[no-any-return]
        batch, length, width = hidden_states.shape
        together = hidden_states.reshape(batch // views, views * length, width)
        return self._plain(attn, together).reshape(batch, length, -1)  # type: ignore[no-any-return]


def _without_camera(module: Any, given: tuple[Tensor, ...], embedding: Tensor) -> Tensor:
    """Nothing for rows without a camera; a camera's own row is never zero, since it ends in 1."""
    return embedding * (given[0] != 0).any(-1, keepdim=True)
