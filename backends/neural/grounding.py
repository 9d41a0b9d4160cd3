"""Grounded segmentation: detection of a described object by GroundingDINO, and its mask by SAM."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.neural.diffusion import silence_libraries, translate_out_of_memory
from scenelang.backends.neural.mvdream import weights_mismatch
from scenelang.backends.neural.weights import INSTALL, ModelHub
from scenelang.backends.pictures.film import open_image
from scenelang.grammar.diagnostics import SceneError

# Networks of transformers with their processors, by name.


@dataclass(frozen=True, slots=True, eq=False)
class LoadedNetwork:
    """Network of transformers with frozen weights, and the processor of its inputs."""

    name: str
    network: Any
    processor: Any


def load_network(name: str, network: str, processor: str, hub: ModelHub | None, device: str) -> LoadedNetwork:
    """Load the model ``name`` with the classes ``network`` and ``processor`` of transformers, in float32.

    Raises SceneError: "weights" if the weights are unavailable or of another model, "backend" without the packages.
    """
    transformers = require("transformers", INSTALL)
    require("torchvision", INSTALL)  # imported by the image processors
    classes = (getattr(transformers, network), getattr(transformers, processor))
    loaded, loaded_processor = (hub or ModelHub()).load(
        name,
        lambda folder: _load(classes, str(folder), device, offline=True),
        lambda repository, offline: _load(classes, repository, device, offline=offline),
    )
    return LoadedNetwork(name, loaded, loaded_processor)


def _load(classes: tuple[Any, Any], name: str, device: str, *, offline: bool) -> tuple[Any, Any]:
    torch = require("torch", INSTALL)
    with silence_libraries(progress_bars=not Path(name).is_dir()):
        processor = classes[1].from_pretrained(name, local_files_only=offline)
        network, loading_info = classes[0].from_pretrained(
            name,
            local_files_only=offline,
            output_loading_info=True,
            ignore_mismatched_sizes=True,  # reported below in one line
            dtype=torch.float32,
        )
    mismatch = _first_mismatch(loading_info)
    if mismatch is not None:
        raise weights_mismatch(name, mismatch)
    with translate_out_of_memory():
        return network.to(device).eval().requires_grad_(False), processor


def _first_mismatch(loading_info: Mapping[str, Any]) -> str | None:
    """Describe the first mismatch of the weights; None if there is none.

    Unexpected keys are allowed, since the published weights contain some.
    """
    if loading_info["missing_keys"]:
        return f"missing key `{min(loading_info['missing_keys'])}`"
    if loading_info["mismatched_keys"]:
        return f"shape mismatch of `{min(key for key, *_ in loading_info['mismatched_keys'])}`"
    return None


# Open-vocabulary object detection (Liu et al., "Grounding DINO", 2023).


DETECTOR = "IDEA-Research/grounding-dino-base"
MIN_SCORE = 0.25  # the box threshold of its documentation
_MAX_TEXT = 200  # characters of a description
Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Detection:
    """Detected ``box`` in pixels (left, top, right, bottom), with its confidence ``score`` from 0 to 1."""

    box: Box
    score: float


def load_detector(name: str = DETECTOR, hub: ModelHub | None = None, device: str = "cpu") -> LoadedNetwork:
    """Load the detector ``name``; raises the errors of ``load_network``."""
    return load_network(name, "GroundingDinoForObjectDetection", "GroundingDinoProcessor", hub, device)


def normalize_text(text: str) -> str:
    """Return a description in the form the detector requires: lower case, with a final full stop.

    Raises SceneError("value") for an empty or too long text.
    """
    normalized = " ".join(text.lower().split()).strip(" .")
    if not normalized or len(normalized) > _MAX_TEXT:
        raise SceneError("value", f"the description of an object must have 1 to {_MAX_TEXT} characters")
    return f"{normalized}."


def detect(detector: LoadedNetwork, picture: Any, text: str, min_score: float = MIN_SCORE) -> list[Detection]:
    """Detect ``text`` in the PIL image ``picture`` (RGB); returns boxes scored above ``min_score``, best first."""
    torch = require("torch", INSTALL)
    inputs = detector.processor(images=picture, text=normalize_text(text), return_tensors="pt")
    inputs = inputs.to(detector.network.device)
    with torch.no_grad(), translate_out_of_memory():
        output = detector.network(**inputs)
    scores = output.logits[0].sigmoid().amax(-1).float().cpu()  # maximum over the tokens of the text
    centers, sizes = output.pred_boxes[0].float().cpu().split(2, dim=-1)
    scale = torch.tensor([picture.width, picture.height] * 2)
    corners = torch.cat([centers - sizes / 2.0, centers + sizes / 2.0], -1).clamp(0.0, 1.0) * scale
    order = torch.argsort(scores, descending=True, stable=True).tolist()
    return [_detection(corners[i], scores[i]) for i in order if float(scores[i]) > min_score]


def _detection(corners: Any, score: Any) -> Detection:
    left, top, right, bottom = corners.tolist()
    return Detection((left, top, right, bottom), float(score))


# Segmentation (Kirillov et al., "Segment Anything", 2023).


SEGMENTER = "facebook/sam-vit-huge"
Mask = npt.NDArray[np.bool_]


def load_segmenter(name: str = SEGMENTER, hub: ModelHub | None = None, device: str = "cpu") -> LoadedNetwork:
    """Load the segmenter ``name``; raises the errors of ``load_network``."""
    return load_network(name, "SamModel", "SamProcessor", hub, device)


def mask_in(segmenter: LoadedNetwork, picture: Any, box: Box) -> Mask:
    """Return the mask (H, W) of the object in ``box`` of the PIL image ``picture`` (RGB).

    Of the masks that the network predicts, this is the one with the highest predicted IoU.
    """
    torch = require("torch", INSTALL)
    network = segmenter.network
    inputs = segmenter.processor(images=picture, input_boxes=[[list(box)]], return_tensors="pt")
    with torch.no_grad(), translate_out_of_memory():
        output = network(
            pixel_values=inputs["pixel_values"].to(network.device),
            input_boxes=inputs["input_boxes"].float().to(network.device),  # the processor returns float64
        )
    (masks,) = segmenter.processor.image_processor.post_process_masks(
        output.pred_masks.float().cpu(), inputs["original_sizes"], inputs["reshaped_input_sizes"]
    )
    best = int(output.iou_scores[0, 0].argmax())
    mask: Mask = masks[0, best].numpy()
    return mask


# Training images for Textual Inversion: the masked object centered in a square on plain grey, similar to the renderings
# on which multi-view diffusion models are trained (the paper, appendix "Textual Inversion Optimization").


Bytes = npt.NDArray[np.uint8]
_MASK_THRESHOLD = 128  # minimum brightness of foreground pixels in a mask file


def read_mask(path: Path | str, width: int, height: int) -> Mask:
    """Read a mask (H, W) from an image file, light where the object is; raises SceneError("file" or "value")."""
    picture = open_image(path)
    if picture.size != (width, height):
        message = (
            f"expected a mask of the image's size {width} x {height}, {path} has {picture.width} x {picture.height}"
        )
        raise SceneError("value", message)
    mask: Mask = np.asarray(picture.convert("L")) >= _MASK_THRESHOLD
    return mask


def mask_box(mask: Mask) -> tuple[int, int, int, int]:
    """Return the bounding box of ``mask`` (H, W): left, top, right, bottom, the last two exclusive.

    Raises SceneError("value") for an empty mask.
    """
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    if not len(rows):
        raise SceneError("value", "the mask is empty: no pixel of the image is selected")
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def random_grey(seed: int) -> int:
    """Return a random brightness of the background, 0 to 255."""
    return int(np.random.default_rng(seed % (1 << 63)).integers(256))


def crop_masked(picture: Bytes, mask: Mask, grey: int) -> Bytes:
    """Return the masked part of ``picture`` (H, W, 3), centered in the smallest square (S, S, 3) on ``grey``.

    If the margin is odd, the larger half is right and below. Raises SceneError("value") for an empty mask.
    """
    left, top, right, bottom = mask_box(mask)
    width, height = right - left, bottom - top
    side = max(width, height)
    x, y = (side - width) // 2, (side - height) // 2
    square: Bytes = np.full((side, side, 3), grey, np.uint8)
    inside = mask[top:bottom, left:right, None]
    square[y : y + height, x : x + width] = np.where(inside, picture[top:bottom, left:right], np.uint8(grey))
    return square


def resize(square: Bytes, size: int) -> Bytes:
    """Resize a square image to ``size`` x ``size`` pixels."""
    image = require("PIL.Image", "pillow")
    resized: Bytes = np.asarray(image.fromarray(square).resize((size, size), image.Resampling.LANCZOS))
    return resized


@dataclass(frozen=True, slots=True, eq=False)
class Grounding:
    """Detector and segmenter, with the minimum score of a detection."""

    detector: LoadedNetwork
    segmenter: LoadedNetwork
    min_score: float = MIN_SCORE


def find_object(grounding: Grounding, pictures: Sequence[Any], text: str, grey: int) -> tuple[int, Bytes] | None:
    """Find the object described by ``text`` in PIL images (RGB).

    Returns the index of the image with the most confident detection, and the object cropped on ``grey`` (S, S, 3); None
    if it is not detected in any image.
    """
    best: tuple[float, int, Any] | None = None
    for number, picture in enumerate(pictures):
        for detected in detect(grounding.detector, picture, text, grounding.min_score)[:1]:
            if best is None or detected.score > best[0]:
                best = (detected.score, number, detected.box)
    if best is None:
        return None
    _, number, box = best
    mask = mask_in(grounding.segmenter, pictures[number], box)
    return (number, crop_masked(np.asarray(pictures[number]), mask, grey)) if mask.any() else None
