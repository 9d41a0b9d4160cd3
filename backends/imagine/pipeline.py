"""From a shot of a scene to pictures: its layout, what is said of each place, and a model that draws them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from scenelang.backends.base import Progress, need
from scenelang.backends.clip.conditions import Condition
from scenelang.backends.clip.granularity import Granularity, IntArray, check_named, units_of
from scenelang.backends.clip.prompts import Prompt
from scenelang.backends.clip.sentences import Sayings, Sentences
from scenelang.backends.imagine.gligen import Gligen
from scenelang.backends.imagine.layout import MOST, Layout, layout_of
from scenelang.backends.imagine.migc import MOST as MIGC_MOST
from scenelang.backends.imagine.migc import MigcSteering
from scenelang.backends.imagine.migc_files import Migc
from scenelang.backends.imagine.models import Checkpoint, check_control
from scenelang.backends.imagine.regional import WEIGHT, Regional
from scenelang.backends.imagine.sampling import Control, Picture, Sampling, draw
from scenelang.backends.imagine.sayings import conditions_in, handles_in
from scenelang.backends.imagine.steering import Region, Steering
from scenelang.backends.maps.pictures import depth_picture
from scenelang.backends.maps.truth import Truth, truth_of
from scenelang.backends.minecraft.cubes import as_cubes
from scenelang.backends.shots import Shot
from scenelang.backends.stage import unit_size
from scenelang.backends.weights import INSTALL
from scenelang.backends.wording.templates import check_template
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.entity import Scene
from scenelang.interpreter.numbering import frame_numbers, instance_handles

METHODS = ("regional", "gligen", "migc")
Warn = Callable[[Diagnostic], None]
Vectors = Mapping[str, npt.NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Sketch:
    """A shot as a layout, before any model: ``handles`` are those of all instances of the truth, ``units`` (M,) what
    each counts as."""

    truth: Truth
    layout: Layout
    handles: tuple[str, ...]
    units: IntArray

    def sentences(self, sayings: Sayings) -> Sentences:
        """What can be said of each thing; raises SceneError("value") for a template that means nothing."""
        check_template(sayings.template)
        return Sentences(self.truth.ancestry, self.handles, sayings)

    def conditions(self, sentences: Sentences) -> list[Condition]:
        """What is said of each place."""
        return conditions_in(self.layout, self.truth, self.units, sentences)


def most_for(method: str) -> int:
    """How many instances a method can be told of."""
    return MIGC_MOST if method == "migc" else MOST


def sketch_of(scene: Scene, shot: Shot, granularity: Granularity, most: int, limit: int, warn: Warn) -> Sketch:
    """The layout of ``shot``, at most ``most`` instances. Warns of what is left out. Raises SceneError, and LimitError
    beyond ``limit`` primitives."""
    scene = as_cubes(scene, limit, warn)
    truth = truth_of(scene, shot, limit, *unit_size(scene))
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    handles = tuple(instance_handles(scene, truth.ancestry, numbers))
    check_named([(truth.ancestry, handles)], granularity)
    units = units_of(truth.ancestry, handles, granularity)
    layout = layout_of(truth, units, most)
    if layout.left_out:
        message = f"{layout.left_out:,} instances are left out: only the {len(layout.places)} largest are drawn"
        warn(Diagnostic("crowded-layout", message, hint="take whole entities as one: --depth N, --entity NAME"))
    return Sketch(truth, layout, handles, units)


def readable_vectors(checkpoint: Checkpoint, vectors: Vectors) -> dict[str, Any]:
    """The learned vectors of Z that the checkpoint's text encoder can read, as tensors."""
    torch = need("torch", INSTALL)
    width = checkpoint.words.width
    fitting = {handle: each for handle, each in vectors.items() if each.ndim == 2 and each.shape[1] == width}
    return {handle: torch.from_numpy(each).to(checkpoint.device) for handle, each in fitting.items()}


def warn_of_unread(conditions: Sequence[Condition], style: str, vectors: Vectors, read: Vectors, warn: Warn) -> None:
    """Tell which learned vectors were to be read, but fit another text encoder."""
    meant = {style, *handles_in(conditions)}
    unread = sorted(meant & (vectors.keys() - read.keys()))
    if unread:
        shown = ", ".join(f"<{handle}>" for handle in unread[:3]) + (", ..." if len(unread) > 3 else "")
        message = f"the vectors of {shown} are not of the width that this model reads, so texts take their place"
        warn(Diagnostic("unread-vectors", message, hint="vectors of OpenCLIP ViT-H fit Stable Diffusion 2"))


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """What is to be drawn: the scene's ``prompt``, the ``negative`` one, the ``conditions`` of the sketch's places,
    learned ``vectors`` by handle, and how: a ``method`` of METHODS, ``weight`` of regional attention, ``migc``'s
    weights, a ``control`` network for depth."""

    prompt: Prompt
    negative: str
    conditions: Sequence[Condition]
    vectors: Mapping[str, Any]
    method: str = "regional"
    weight: float = WEIGHT
    migc: Migc | None = None
    control: Any = None


def imagine(
    checkpoint: Checkpoint, sketch: Sketch, order: Order, sampling: Sampling, progress: Progress | None = None
) -> Picture:
    """One picture (H, W, 3) of a sketch, 8-bit sRGB; raises SceneError."""
    torch = need("torch", INSTALL)
    with torch.no_grad():
        asked = [order.prompt, *(condition.prompt for condition in order.conditions)]
        encoded = checkpoint.words.encoded(asked, order.vectors)
        words = encoded.words[:1]
        if sampling.guided:
            negative = (order.negative,) if order.negative else ()
            words = torch.cat([checkpoint.words.encode([negative]), words])
    regions = [
        Region(sketch.layout.fractions(place), encoded.words[i : i + 1], encoded.pooled[i : i + 1])
        for i, place in enumerate(sketch.layout.places, start=1)
    ]
    control = None
    if order.control is not None:
        check_control(order.control, checkpoint.unet)
        control = Control(order.control, depth_picture(sketch.truth.depth))
    steering = _steering(checkpoint, order, regions, sampling)
    return draw(checkpoint, words, sampling, steering, control, progress)


def _steering(checkpoint: Checkpoint, order: Order, regions: Sequence[Region], sampling: Sampling) -> Steering:
    latent, guided = sampling.latent(checkpoint.factor), sampling.guided
    if order.method == "gligen":
        return Gligen(checkpoint.unet, regions, guided)
    if order.method == "migc" and order.migc is not None:
        return MigcSteering(checkpoint.unet, order.migc, regions, latent, guided, sampling.seed)
    return Regional(checkpoint.unet, regions, latent, guided, order.weight)
