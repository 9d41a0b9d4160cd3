"""The part of a picture that words name: boxes by the detector, the best one's mask by the segmenter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.neural.clip import open_picture
from scenelang.backends.neural.diffusion import memory_told, quiet_libraries
from scenelang.backends.neural.mvdream import other_model
from scenelang.backends.neural.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

# Networks of transformers with what prepares their inputs, by name.


@dataclass(frozen=True, slots=True, eq=False)
class LoadedNetwork:
    """A frozen ``network`` of transformers on its device, and the ``processor`` of its inputs."""

    name: str
    network: Any
    processor: Any


def load_network(name: str, network: str, processor: str, shelf: Shelf | None, device: str) -> LoadedNetwork:
    """The model ``name`` as the classes ``network`` and ``processor`` of transformers, in float32.

    Raises SceneError: "weights" where these are not to be had, or are of another model; "backend" without the packages.
    """
    transformers = need("transformers", INSTALL)
    need("torchvision", INSTALL)  # the processors of pictures import it
    kinds = (getattr(transformers, network), getattr(transformers, processor))
    made, prepare = (shelf or Shelf()).load(
        name,
        lambda folder: _made(kinds, str(folder), True, device),
        lambda repository, offline: _made(kinds, repository, offline, device),
    )
    return LoadedNetwork(name, made, prepare)


def _made(kinds: tuple[Any, Any], name: str, offline: bool, device: str) -> tuple[Any, Any]:
    torch = need("torch", INSTALL)
    with quiet_libraries(bars=not Path(name).is_dir()):
        prepare = kinds[1].from_pretrained(name, local_files_only=offline)
        network, found = kinds[0].from_pretrained(
            name,
            local_files_only=offline,
            output_loading_info=True,
            ignore_mismatched_sizes=True,  # told below, in one line
            dtype=torch.float32,
        )
    wrong = _first_wrong(found)
    if wrong is not None:
        raise other_model(name, wrong)
    with memory_told():
        return network.to(device).eval().requires_grad_(False), prepare


def _first_wrong(found: Mapping[str, Any]) -> str | None:
    """What is wrong with the weights, in words. Some that a network has no use for come with the published ones."""
    if found["missing_keys"]:
        return f"`{min(found['missing_keys'])}` is missing"
    if found["mismatched_keys"]:
        return f"`{min(key for key, *_ in found['mismatched_keys'])}` has another shape"
    return None


# Where in a picture the thing is that words name: GroundingDINO.


DETECTOR = "IDEA-Research/grounding-dino-base"
LEAST = 0.25  # score of a box that counts
_LONGEST = 200  # characters of what is looked for
Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Detection:
    """A ``box`` in pixels (left, top, right, bottom), and how surely it holds what was looked for, from 0 to 1."""

    box: Box
    score: float


def load_detector(name: str = DETECTOR, shelf: Shelf | None = None, device: str = "cpu") -> LoadedNetwork:
    """The detector ``name``; raises SceneError as ``load_network`` does."""
    return load_network(name, "GroundingDinoForObjectDetection", "GroundingDinoProcessor", shelf, device)


def phrase(text: str) -> str:
    """A text as the detector reads one: lower-case, ending in a full stop; raises SceneError("value") for none."""
    said = " ".join(text.lower().split()).strip(" .")
    if not said or len(said) > _LONGEST:
        raise SceneError("value", f"what is looked for in a picture has 1 to {_LONGEST} characters")
    return f"{said}."


def detect(detector: LoadedNetwork, picture: Any, text: str, least: float = LEAST) -> list[Detection]:
    """The boxes in the PIL ``picture`` (RGB) whose score for ``text`` is above ``least``, the surest first."""
    torch = need("torch", INSTALL)
    given = detector.processor(images=picture, text=phrase(text), return_tensors="pt").to(detector.network.device)
    with torch.no_grad(), memory_told():
        output = detector.network(**given)
    scores = output.logits[0].sigmoid().amax(-1).float().cpu()  # of the likeliest of the words
    middles, sizes = output.pred_boxes[0].float().cpu().split(2, dim=-1)
    scale = torch.tensor([picture.width, picture.height] * 2)
    limits = torch.cat([middles - sizes / 2.0, middles + sizes / 2.0], -1).clamp(0.0, 1.0) * scale
    order = torch.argsort(scores, descending=True, stable=True).tolist()
    return [_found(limits[i], scores[i]) for i in order if float(scores[i]) > least]


def _found(limits: Any, score: Any) -> Detection:
    left, top, right, bottom = limits.tolist()
    return Detection((left, top, right, bottom), float(score))


# Which pixels of a box are the thing in it: SAM.


SEGMENTER = "facebook/sam-vit-huge"
Mask = npt.NDArray[np.bool_]


def load_segmenter(name: str = SEGMENTER, shelf: Shelf | None = None, device: str = "cpu") -> LoadedNetwork:
    """The segmenter ``name``; raises SceneError as ``load_network`` does."""
    return load_network(name, "SamModel", "SamProcessor", shelf, device)


def mask_in(segmenter: LoadedNetwork, picture: Any, box: Box) -> Mask:
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


# A part of a picture cut out along its mask, as diffusion models were trained to see things: in the middle of a
# square, on plain grey (the paper, appendix "Textual Inversion Optimization").


Bytes = npt.NDArray[np.uint8]
_THING = 128  # a mask file's brightness from which a pixel belongs to the thing


def read_mask(path: Path | str, width: int, height: int) -> Mask:
    """The mask (H, W) of a picture file, light where the thing is; raises SceneError("file" or "value")."""
    picture = open_picture(path)
    if picture.size != (width, height):
        message = f"{path} has {picture.width} x {picture.height} pixels; the picture that it masks {width} x {height}"
        raise SceneError("value", message)
    found: Mask = np.asarray(picture.convert("L")) >= _THING
    return found


def mask_box(mask: Mask) -> tuple[int, int, int, int]:
    """The smallest box around what ``mask`` (H, W) shows: the first column and row in it, the first ones after it.

    Raises SceneError("value") for a mask that shows nothing.
    """
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    if not len(rows):
        raise SceneError("value", "the mask shows nothing of the picture")
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def random_grey(seed: int) -> int:
    """A background's brightness, any of 256."""
    return int(np.random.default_rng(seed % (1 << 63)).integers(256))


def cut_out(picture: Bytes, mask: Mask, grey: int) -> Bytes:
    """What ``mask`` (H, W) shows of ``picture`` (H, W, 3) in the middle of the smallest square (S, S, 3) that holds it,
    on ``grey``. Of an odd number of pixels around it the larger half is right and below.

    Raises SceneError("value") for a mask that shows nothing.
    """
    left, top, right, bottom = mask_box(mask)
    width, height = right - left, bottom - top
    side = max(width, height)
    x, y = (side - width) // 2, (side - height) // 2
    square: Bytes = np.full((side, side, 3), grey, np.uint8)
    inside = mask[top:bottom, left:right, None]
    square[y : y + height, x : x + width] = np.where(inside, picture[top:bottom, left:right], np.uint8(grey))
    return square


def resized(square: Bytes, size: int) -> Bytes:
    """The picture with ``size`` pixels along each side."""
    image = need("PIL.Image", "pillow")
    found: Bytes = np.asarray(image.fromarray(square).resize((size, size), image.Resampling.LANCZOS))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Grounding:
    """Both networks, and the score that a box must have at least."""

    detector: LoadedNetwork
    segmenter: LoadedNetwork
    least: float = LEAST


def found_in(grounding: Grounding, pictures: Sequence[Any], text: str, grey: int) -> tuple[int, Bytes] | None:
    """The number of the PIL picture (RGB) in which ``text`` is found most surely, and that part of it cut out on
    ``grey`` (S, S, 3); None where it is in none of them."""
    best: tuple[float, int, Any] | None = None
    for number, picture in enumerate(pictures):
        for found in detect(grounding.detector, picture, text, grounding.least)[:1]:
            if best is None or found.score > best[0]:
                best = (found.score, number, found.box)
    if best is None:
        return None
    _, number, box = best
    mask = mask_in(grounding.segmenter, pictures[number], box)
    return (number, cut_out(np.asarray(pictures[number]), mask, grey)) if mask.any() else None
