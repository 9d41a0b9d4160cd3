"""Layouts of instances in an image, and attention that is conditioned on their boxes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.labels.dataset import instance_color
from scenelang.backends.labels.ground_truth import Boxes, Truth, boxes_in
from scenelang.backends.neural.prompts import PromptBuilder, PromptCondition, prompt_text
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
Box = tuple[float, float, float, float]

MAX_INSTANCES = 30  # GLIGEN's number of grounding tokens


@dataclass(frozen=True, slots=True)
class LayoutInstance:
    """Instance in an image.

    Attributes
    ----------
    instance
        Index in the ancestry.
    box
        x0, y0, x1, y1 in pixels from the top left corner.
    depth
        Minimum depth of its visible pixels, in scene units.
    area
        Number of its visible pixels.
    """

    instance: int
    box: Box
    depth: float
    area: int


@dataclass(frozen=True, slots=True)
class PictureLayout:
    """Layout of an image of ``width`` x ``height`` pixels.

    ``instances`` are ordered from near to far; ``left_out`` is the number of smaller visible instances without a box.
    """

    width: int
    height: int
    instances: tuple[LayoutInstance, ...]
    left_out: int

    def fractions(self, instance: LayoutInstance) -> Box:
        """Return the instance's box in fractions of the image size, 0 to 1."""
        x0, y0, x1, y1 = instance.box
        return x0 / self.width, y0 / self.height, x1 / self.width, y1 / self.height


def layout_of(truth: Truth, units: IntArray, max_instances: int = MAX_INSTANCES) -> PictureLayout:
    """Return the layout of a shot: the ``max_instances`` visible units with the largest boxes.

    ``units`` (M,) is the unit of every instance.
    """
    boxes = boxes_in(truth)
    used = np.unique(units[truth.ancestry.primitives])
    depths = _min_depths(truth, units)
    visible = used[np.isfinite(depths[used])]
    clipped = clip_boxes(boxes, truth.camera.width, truth.camera.height)
    sizes = (clipped[visible, 2] - clipped[visible, 0]) * (clipped[visible, 3] - clipped[visible, 1])
    largest = visible[np.argsort(-sizes, kind="stable")[:max_instances]]
    ordered = largest[np.argsort(depths[largest], kind="stable")]
    instances = tuple(_instance(int(i), clipped[i], depths[i], boxes.area[i]) for i in ordered)
    return PictureLayout(truth.camera.width, truth.camera.height, instances, len(visible) - len(instances))


def clip_boxes(boxes: Boxes, width: int, height: int) -> FloatArray:
    """Clip the boxes (M, 4) to the image: those of full projections, or the visible ones behind the camera plane."""
    edges = np.array([width, height, width, height], np.float64)
    return np.clip(np.where(np.isnan(boxes.full), boxes.visible, boxes.full), 0.0, edges)


def _instance(instance: int, box: FloatArray, depth: float, area: int) -> LayoutInstance:
    x0, y0, x1, y1 = box.tolist()
    return LayoutInstance(instance, (x0, y0, x1, y1), float(depth), int(area))


def _min_depths(truth: Truth, units: IntArray) -> FloatArray:
    """Return the minimum depth (M,) of the visible pixels of every unit; infinity without pixels."""
    out = np.full(len(truth.ancestry), np.inf)
    np.minimum.at(out, units[truth.instance[truth.seen]], truth.depth[truth.seen])
    return out


# Visualization of layouts: an image with colored, labeled boxes, and JSON.


Picture = npt.NDArray[np.uint8]

FORMAT, VERSION = "scenelang-layout", 1
_BACKGROUND = 24
_FILL_OPACITY = 0.35
_MAX_LABEL = 100  # characters
_LINE_HEIGHT = 13  # pixels


def layout_picture(layout: PictureLayout, conditions: Sequence[PromptCondition]) -> Picture:
    """Draw the boxes (H, W, 3) from far to near, each in its own color with as much of its prompt as fits."""
    picture = np.full((layout.height, layout.width, 3), _BACKGROUND, np.uint8)
    rows = list(enumerate(zip(layout.instances, conditions, strict=True)))
    for number, (instance, _) in reversed(rows):
        x0, y0, x1, y1 = (round(edge) for edge in instance.box)
        part = picture[y0:y1, x0:x1]
        part[:] = np.rint((1.0 - _FILL_OPACITY) * part + _FILL_OPACITY * np.array(instance_color(number)))
    image = require("PIL.Image", "pillow").fromarray(picture)
    pen = require("PIL.ImageDraw", "pillow").Draw(image)
    font = require("PIL.ImageFont", "pillow").load_default(11)
    for number, (instance, condition) in reversed(rows):
        left, top, right, bottom = instance.box
        color = instance_color(number)
        pen.rectangle((left, top, max(left, right - 1), max(top, bottom - 1)), outline=color)
        lines = _wrap_text(
            f"{number + 1} {condition.plain}"[:_MAX_LABEL], right - left - 4, lambda t: pen.textlength(t, font)
        )
        shown = "\n".join(lines[: max(1, int((bottom - top) // _LINE_HEIGHT))])
        light = tuple((255 + part) // 2 for part in color)
        pen.text((left + 2, top + 1), shown, fill=light, font=font, stroke_width=1, stroke_fill=(0, 0, 0), spacing=0)
    return np.asarray(image, np.uint8).copy()


def _wrap_text(text: str, width: float, length: Callable[[str], float]) -> list[str]:
    """Break a text into lines of at most ``width``; a single longer word is not broken."""
    lines: list[str] = []
    for word in "".join(c if c.isprintable() else " " for c in text).split():
        if lines and length(f"{lines[-1]} {word}") <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def layout_json(
    layout: PictureLayout, conditions: Sequence[PromptCondition], truth: Truth, prompt: str
) -> dict[str, Any]:
    """Return the layout as JSON data; boxes are x0, y0, x1, y1 in fractions of the image, nearest instance first."""
    ancestry = truth.ancestry
    return {
        "format": FORMAT,
        "version": VERSION,
        "width": layout.width,
        "height": layout.height,
        "prompt": prompt,
        "left_out": layout.left_out,
        "instances": [
            {
                "path": list(ancestry.path(each.instance)),
                "handle": f"<{condition.handles[0]}>",
                "word": ancestry.entity(each.instance).word,
                "prompt": prompt_text(condition.prompt),
                "text": condition.plain,
                "box": list(layout.fractions(each)),
                "depth": each.depth,
                "area": each.area,
            }
            for each, condition in zip(layout.instances, conditions, strict=True)
        ],
    }


# Prompts of the instances.


def conditions_in(
    layout: PictureLayout, truth: Truth, units: IntArray, prompts: PromptBuilder
) -> list[PromptCondition]:
    """Return the prompt of every instance of the layout; ``units`` (M,) is the unit of every instance of the scene.

    Raises SceneError("value").
    """
    primitives = truth.ancestry.primitives
    primitive_units = units[primitives]
    return [
        prompts.condition(each.instance, primitives[np.flatnonzero(primitive_units == each.instance)].tolist())
        for each in layout.instances
    ]


def handles_in(conditions: Sequence[PromptCondition]) -> set[str]:
    """Return all handles of the conditions."""
    return {handle for condition in conditions for handle in condition.handles}


@dataclass(frozen=True, slots=True, eq=False)
class AttentionRegion:
    """Region of the image with its prompt.

    Attributes
    ----------
    box
        x0, y0, x1, y1 in fractions of the image size.
    hidden_states
        (1, T, D), of the prompt.
    pooled
        (1, D), of the prompt.
    """

    box: Box
    hidden_states: Any
    pooled: Any


class LayoutConditioning(Protocol):
    """Layout conditioning of one image: a context manager that modifies the UNet and restores it at the end."""

    def __enter__(self) -> LayoutConditioning: ...

    def __exit__(self, *_: object) -> None: ...

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        """Prepare step ``number`` of ``steps``, from 0; returns additional ``cross_attention_kwargs`` for the UNet."""


class NoConditioning:
    """No layout conditioning: leaves the UNet unchanged."""

    def __enter__(self) -> LayoutConditioning:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        return None


@contextmanager
def attention_processors(unet: Any, replaced: Mapping[str, Any]) -> Iterator[None]:
    """Replace attention processors of ``unet`` by name for the duration of the block."""
    before = dict(unet.attn_processors)
    unet.set_attn_processor({**before, **replaced})
    try:
        yield
    finally:
        unet.set_attn_processor(before)


def feature_shape(tokens: int, latent: tuple[int, int]) -> tuple[int, int]:
    """Return height and width of the UNet level with ``tokens`` image tokens, for a ``latent`` of (height, width).

    Each level halves both, rounded up. Raises ValueError if no level has that many tokens.
    """
    height, width = latent
    while height * width > tokens and height * width > 1:
        height, width = (height + 1) // 2, (width + 1) // 2
    if height * width != tokens:
        raise ValueError(f"no level of a {latent[0]} x {latent[1]} latent has {tokens} tokens")
    return height, width


def cells_in(box: Box, shape: tuple[int, int]) -> list[int]:
    """Return the row-major indices of the grid cells whose centers are in ``box``, or else of the nearest cell.

    ``shape`` is the height and width of the grid.
    """
    height, width = shape
    columns = _interval(box[0], box[2], width)
    rows = _interval(box[1], box[3], height)
    return [row * width + column for row in rows for column in columns]


def _interval(low: float, high: float, cells: int) -> Sequence[int]:
    inside = [i for i in range(cells) if low <= (i + 0.5) / cells <= high]
    return inside or [min(cells - 1, max(0, int(0.5 * (low + high) * cells)))]


# Regional attention: training-free layout conditioning, where the prompt of an instance affects only its box.
#
# The output of each cross-attention layer is ``(global + w sum m_i inst_i) / (1 + w sum m_i)``, where m_i is 1 inside
# the box of instance i and 0 elsewhere. With guidance, the unconditional half of the batch is unchanged.


DEFAULT_WEIGHT = 10.0


class Regional:
    """Regional attention in every cross-attention layer of ``unet``, for a ``latent`` of (height, width).

    With ``guided``, the first half of a batch is unconditional.
    """

    def __init__(
        self,
        unet: Any,
        regions: Sequence[AttentionRegion],
        latent: tuple[int, int],
        guided: bool,
        weight: float = DEFAULT_WEIGHT,
    ) -> None:
        self._unet = unet
        self._processors = {
            name: RegionalAttention(before, regions, latent, guided, weight)
            for name, before in unet.attn_processors.items()
            if ".attn2." in name
        }
        self._stack = ExitStack()

    def __enter__(self) -> LayoutConditioning:
        self._stack.enter_context(attention_processors(self._unet, self._processors))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        return None


class RegionalAttention:
    """Attention processor of one layer; ``before`` is the processor that it wraps."""

    def __init__(
        self, before: Any, regions: Sequence[AttentionRegion], latent: tuple[int, int], guided: bool, weight: float
    ) -> None:
        self._before = before
        self._regions = regions
        self._latent = latent
        self._guided = guided
        self._weight = weight

    def __call__(
        self,
        attn: Any,
        hidden_states: Any,
        encoder_hidden_states: Any = None,
        attention_mask: Any = None,
        temb: Any = None,
    ) -> Any:
        """Attend from image states (B, HW, C) to the prompt's (B, T, D), blended with attention to the regions'."""
        torch = require("torch", INSTALL)
        out = self._before(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
        start = len(hidden_states) // 2 if self._guided else 0
        own = hidden_states[start:]
        shape = feature_shape(own.shape[1], self._latent)
        total, weights = out[start:].clone(), torch.ones_like(out[0, :, :1])
        for region in self._regions:
            rows = torch.tensor(cells_in(region.box, shape), device=own.device)
            states = region.hidden_states.to(own).expand(len(own), -1, -1)
            total[:, rows] += self._weight * self._before(attn, own[:, rows], states, None, temb)
            weights[rows] += self._weight
        return torch.cat([out[:start], total / weights])


# GLIGEN (Li et al. 2023): gated self-attention over grounding tokens of boxes and prompts, with trained weights.


DEFAULT_MODEL = "masterful/gligen-1-4-generation-text-box"
SCHEDULED_SAMPLING_BETA = 0.3  # fraction of the steps, from the first, with grounding; diffusers' default


class Gligen:
    """GLIGEN conditioning of ``unet``. With ``guided``, the first half of a batch is unconditional and has no boxes.

    Raises SceneError("weights") for a model without gated attention.
    """

    def __init__(
        self, unet: Any, regions: Sequence[AttentionRegion], guided: bool, beta: float = SCHEDULED_SAMPLING_BETA
    ) -> None:
        if getattr(unet.config, "attention_type", "default") != "gated":
            hint = f"use --model {DEFAULT_MODEL}, or a folder with weights of GLIGEN for boxes and text"
            raise SceneError("weights", "the model has no gated attention layers of GLIGEN", hint=hint)
        self._unet = unet
        self._beta = beta
        self._tokens = {"gligen": grounding_tokens(unet, regions, guided)}

    def __enter__(self) -> LayoutConditioning:
        return self

    def __exit__(self, *_: object) -> None:
        enable_gates(self._unet, True)  # the default of diffusers

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        enable_gates(self._unet, number < int(self._beta * steps))
        return self._tokens


def grounding_tokens(unet: Any, regions: Sequence[AttentionRegion], guided: bool) -> dict[str, Any]:
    """Return the inputs of diffusers' position network.

    These are ``boxes`` (B, 30, 4), ``positive_embeddings`` (B, 30, D) and ``masks`` (B, 30), where B is 2 if ``guided``
    and 1 otherwise.
    """
    torch = require("torch", INSTALL)
    weight = next(unet.position_net.parameters())
    width = int(unet.position_net.positive_len)
    boxes, masks = weight.new_zeros(1, MAX_INSTANCES, 4), weight.new_zeros(1, MAX_INSTANCES)
    texts = weight.new_zeros(1, MAX_INSTANCES, width)
    for i, region in enumerate(regions[:MAX_INSTANCES]):
        if region.pooled.shape[-1] != width:
            message = f"GLIGEN expects text embeddings of width {width}, got {region.pooled.shape[-1]}"
            raise SceneError("weights", message)
        boxes[0, i] = weight.new_tensor(region.box)
        texts[0, i] = region.pooled[0].to(weight)
        masks[0, i] = 1.0
    if guided:
        boxes, texts, masks = torch.cat([boxes, boxes]), torch.cat([texts, texts]), torch.cat([masks * 0.0, masks])
    return {"boxes": boxes, "positive_embeddings": texts, "masks": masks}


def enable_gates(unet: Any, enabled: bool) -> None:
    """Enable or disable gated self-attention."""
    for module in unet.modules():
        if hasattr(module, "alpha_attn") and hasattr(module, "alpha_dense"):
            module.enabled = enabled
