"""Which pixels of a box are the thing in it: SAM."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.diffusion.memory import memory_told
from scenelang.backends.grounding.detector import Box
from scenelang.backends.grounding.loading import Loaded, load_network
from scenelang.backends.weights import INSTALL, Shelf

SEGMENTER = "facebook/sam-vit-huge"
Mask = npt.NDArray[np.bool_]


def load_segmenter(name: str = SEGMENTER, shelf: Shelf | None = None, device: str = "cpu") -> Loaded:
    """The segmenter ``name``; raises SceneError as ``load_network`` does."""
    return load_network(name, "SamModel", "SamProcessor", shelf, device)


def mask_in(segmenter: Loaded, picture: Any, box: Box) -> Mask:
    """The mask (H, W) of the thing in ``box`` of the PIL ``picture`` (RGB): of the several that the network offers,
    that which it thinks best."""
    torch = need("torch", INSTALL)
    network = segmenter.network
    given = segmenter.processor(images=picture, input_boxes=[[list(box)]], return_tensors="pt")
    with torch.no_grad(), memory_told():
        output = network(
            pixel_values=given["pixel_values"].to(network.device),
            input_boxes=given["input_boxes"].float().to(network.device),  # the processor makes float64
        )
    (masks,) = segmenter.processor.image_processor.post_process_masks(
        output.pred_masks.float().cpu(), given["original_sizes"], given["reshaped_input_sizes"]
    )
    best = int(output.iou_scores[0, 0].argmax())
    found: Mask = masks[0, best].numpy()
    return found
