"""The optimisation: g_reparam as the minimum of the paper's loss over theta_j and t_j (appendix, "Primitive
Reparameterization via SDS Guidance").

Each step is the turn of one figure: four pictures of it for the term of MVDream, its L_reg and L_layout. Where there is
a model for whole scenes, the first step of a round, in which each figure has one turn, has the term of the
depth-conditioned ControlNet too, for one picture of a frame: the paper's sum has it once, and the others once for each
figure. Each figure follows what that term says at its own turn. All that is random depends on the seed, on whose turn
it is and on its number, so that a run goes on after a break as it would have, and what one figure is told changes no
other one but through the scene's term.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.distillation.sds import WEIGHTINGS, Guiding, Heard, sds_loss, window_at
from scenelang.backends.neural.distillation.theta import (
    Poses,
    Theta,
    beginning,
    changed,
    copies,
    on_stage,
    outside,
    resting,
    shown_by_figure,
    too_long,
)
from scenelang.backends.neural.prompts import PromptCondition, PromptLeaf, prompt_text
from scenelang.backends.neural.splats.gaussians import Splats, joined, posed, view_of
from scenelang.backends.neural.splats.initial import gaussians_of
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.backends.pictures.camera import Camera, Viewpoint, axes_of, camera_at, place
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import setting, whole
from scenelang.interpreter.scene.entity import Entity

if TYPE_CHECKING:
    from torch import Generator, Tensor

    from scenelang.backends.neural.clip import Prompt
    from scenelang.backends.neural.diffusion import DiffusionModel
    from scenelang.backends.neural.splats.gaussians import Gaussians, Splats
    from scenelang.backends.pictures.camera import Camera


# What is learned for a scene: one set of Gaussians for all leaves of the same sentence and shape of box, and where
# each leaf stands in every frame.
#
# The Gaussians of a figure live in a frame of their own, in which the leaf's box is centred and its half sizes have
# the norm 1. The pose of a leaf takes that to the world: in the paper's words the primitive is normalised, and leaves
# with equal ``z`` and equal ``S_t / ||S_t||`` share ``theta``.


FloatArray = npt.NDArray[np.float64]

_ALIKE = 1e-3  # boxes whose half sizes differ by less are equal
_THINNEST = 1e-3  # of the largest half size: a flat thing is as thick
_MOST_GUIDANCE = 1e4


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """What some leaves have in common: the sentence, the half sizes ``box`` (3,) of norm 1, and the entity that the
    first of them is, which ``local`` (3, 4) takes to the figure's frame."""

    condition: PromptCondition
    box: FloatArray
    entity: Entity
    local: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Actor:
    """One leaf over time: which figure it is, and for each of F frames where that stands: ``poses`` (F, 3, 4) from the
    figure's frame to the world, and whether it is there, ``shown`` (F,)."""

    figure: int
    name: str
    handle: str
    poses: FloatArray
    shown: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Cast:
    """All figures of a scene of ``frames`` frames, and who plays them."""

    figures: tuple[Figure, ...]
    actors: tuple[Actor, ...]
    frames: int


def cast_of(frames: Sequence[Sequence[PromptLeaf]]) -> Cast:
    """The cast of a scene from the leaves of its frames; those at the same path under the same word are one over
    time, as the paper's 4D scenes have them."""
    over_time: dict[tuple[tuple[int, ...], str], dict[int, PromptLeaf]] = {}
    for number, leaves in enumerate(frames):
        for leaf in leaves:
            over_time.setdefault((leaf.path, leaf.entity.word), {})[number] = leaf
    figures: list[Figure] = []
    known: dict[object, int] = {}
    actors = []
    for seen in over_time.values():
        first = next(iter(seen.values()))
        box, local = _normalised(first)
        key = (first.condition.prompt, tuple(np.round(box / _ALIKE).astype(int).tolist()))
        if key not in known:
            known[key] = len(figures)
            figures.append(Figure(first.condition, box, first.entity, local))
        actors.append(_actor(known[key], figures[known[key]].box, seen, len(frames)))
    return Cast(tuple(figures), tuple(actors), len(frames))


def _actor(figure: int, box: FloatArray, seen: dict[int, PromptLeaf], frames: int) -> Actor:
    poses = np.zeros((frames, 3, 4))
    for number, leaf in seen.items():
        center, half = _center_and_half(leaf)
        poses[number, :, :3] = leaf.pose[:, :3] * (half / box)
        poses[number, :, 3] = leaf.pose[:, :3] @ center + leaf.pose[:, 3]
    first = next(iter(seen.values()))
    shown = np.array([number in seen for number in range(frames)])
    return Actor(figure, first.name, first.handle, poses, shown)


def _center_and_half(leaf: PromptLeaf) -> tuple[FloatArray, FloatArray]:
    """The middle and the half sizes (3,) of a leaf's box in its own frame, no side thinner than can be drawn."""
    low, high = np.array(leaf.box[:3]), np.array(leaf.box[3:])
    half = (high - low) / 2.0
    return (low + high) / 2.0, np.maximum(half, _THINNEST * max(float(half.max()), 1e-9))


def _normalised(leaf: PromptLeaf) -> tuple[FloatArray, FloatArray]:
    """The box of norm 1 as the world sees it, unturned; and what takes the leaf's own frame to the figure's."""
    center, half = _center_and_half(leaf)
    sizes = np.linalg.norm(leaf.pose[:, :3] * half, axis=0)
    box = np.maximum(sizes, _THINNEST * max(float(sizes.max()), 1e-9))
    box = box / np.linalg.norm(box)
    scale = box / half
    return box, np.hstack([np.diag(scale), (-scale * center)[:, None]])


# What a user may choose of a distillation.


BACKGROUND = 0.5  # grey, sRGB: behind previews; what the models see has another grey in each step


@dataclass(frozen=True, slots=True)
class Rates:
    """Learning rates: the Gaussians' in a figure's frame, whose box has half sizes of norm 1, and the poses'."""

    means: float = 5e-3
    opacities: float = 5e-2
    log_scales: float = 1e-2
    quaternions: float = 1e-2
    colors: float = 5e-2
    turns: float = 1e-3
    shifts: float = 2e-3
    pose_scales: float = 2e-3


@dataclass(frozen=True, slots=True)
class Weights:
    """What each term of the loss counts."""

    figure: float = 1.0
    scene: float = 1.0
    shape: float = 10.0
    layout: float = 100.0


@dataclass(frozen=True, slots=True)
class DistillationSettings:
    """All numbers of a distillation; ``of`` chooses the usual ones to fit.

    Parameters
    ----------
    seed : int
        Of all that is random.
    steps : int
        For each figure.
    first, most : int
        Gaussians of a figure at the beginning (or as many as it takes to grow to ``most``) and at the end.
    every, until : int, float
        Every so many of its steps a figure gets more Gaussians and loses some, until that share of its steps is done.
    guiding, scene_guiding : Guiding
        Guidance scale and weighting of the terms of single things and of the scene.
    weights, rates : Weights, Rates
        Of the terms of the loss; the learning rates.
    hull : int
        Gaussians of the surface that gives a figure's depth.
    """

    seed: int = 0
    steps: int = setting(2000, "for each thing to learn (2000)", metavar="N", read=whole)
    first: int = 1000
    most: int = setting(20_000, "of each thing at most (20,000)", "--gaussians", metavar="N", read=whole)
    every: int = 100
    until: float = 0.7
    guiding: Guiding = field(default_factory=Guiding)
    scene_guiding: Guiding = field(default_factory=lambda: Guiding(weighting="sds"))
    weights: Weights = field(default_factory=Weights)
    rates: Rates = field(default_factory=Rates)
    hull: int = 2000

    @staticmethod
    def of(
        steps: int = 2000,
        gaussians: int = 20_000,
        guidance: float = 50.0,
        weighting: str = "reconstruction",
        seed: int = 0,
    ) -> DistillationSettings:
        """The settings that matter most, the others chosen to fit.

        Parameters
        ----------
        steps : int
            For each thing to learn.
        gaussians : int
            Of each thing at most; 16 or more.
        guidance : float
            The guidance scale of both models, 0 to 10,000.
        weighting : str
            Of the steps of noise, in the term of single things: "reconstruction", "sds", "uniform".
        seed : int
            Of all that is random.

        Raises
        ------
        SceneError
            A number that makes no sense.

        Examples
        --------
        >>> DistillationSettings.of(steps=50).every
        10
        """
        if not 0.0 <= guidance <= _MOST_GUIDANCE:
            raise SceneError("value", f"`--guidance` must be 0 to {_MOST_GUIDANCE:,.0f}, not {guidance:g}")
        if steps < 1 or gaussians < 16:
            raise SceneError("value", "there is at least 1 step, and 16 Gaussians")
        if weighting not in WEIGHTINGS:
            raise SceneError("value", f"`--weighting` is one of {', '.join(WEIGHTINGS)}, not `{weighting}`")
        plain = DistillationSettings()
        return replace(
            plain,
            seed=seed,
            steps=steps,
            first=min(plain.first, gaussians),
            most=gaussians,
            every=max(1, min(plain.every, steps // 5)),
            guiding=replace(plain.guiding, guidance=guidance, weighting=weighting),
            scene_guiding=replace(plain.scene_guiding, guidance=guidance),
        )

    @property
    def growths(self) -> int:
        """How often the Gaussians of a figure become more, each time twice as many at most."""
        return int(self.until * self.steps + 1e-9) // self.every

    @property
    def start(self) -> int:
        """The Gaussians of a figure at the beginning."""
        return min(self.most, max(self.first, math.ceil(self.most / 2.0 ** min(self.growths, 60))))


# One figure while it is learned: its Gaussians, their optimiser, and how strongly each is pulled.


class FigureLearning:
    """``theta`` are leaves of torch's graph; ``turns`` counts the steps made."""

    def __init__(self, box: Tensor, settings: DistillationSettings, generator: Generator) -> None:
        self.box, self._settings = box, settings
        self.turns = 0
        self._take(beginning(box, settings.start, generator))

    def _take(self, theta: Theta) -> None:
        """Optimise ``theta`` from now on, of which the optimiser knows nothing yet."""
        import torch

        columns = {name: column.detach().clone().requires_grad_(True) for name, column in theta.columns().items()}
        self.theta = Theta(**columns)
        rates = self._settings.rates
        groups = [{"params": [column], "lr": getattr(rates, name)} for name, column in columns.items()]
        self._adam = torch.optim.Adam(groups, eps=1e-15)
        self._pull = torch.zeros(len(theta), device=theta.means.device)
        self._pulls = 0

    @property
    def done(self) -> float:
        """The share of the steps that is done."""
        return self.turns / max(self._settings.steps, 1)

    def step(self) -> None:
        """Follow the gradients that are there: of the figure's own terms, and of the scene's since its last turn."""
        gradient = self.theta.means.grad
        if gradient is not None:
            self._pull += gradient.norm(dim=1)
            self._pulls += 1
        self._adam.step()
        self._adam.zero_grad(set_to_none=True)

    def turned(self, generator: Generator) -> None:
        """Count a step of the figure's own; now and then change how many Gaussians there are."""
        self.turns += 1
        settings = self._settings
        left = settings.growths - self.turns // settings.every + 1
        if self.turns % settings.every == 0 and left > 0:
            growth = max(settings.most / len(self.theta), 1.0) ** (1.0 / left)
            self._densify(min(math.ceil(growth * len(self.theta)), settings.most), generator)

    def _densify(self, most: int, generator: Generator) -> None:
        """More Gaussians, up to ``most``, and fewer; the optimiser goes on with those that stay."""
        found = changed(self.theta, self.box, self._pull / max(self._pulls, 1), most, generator)
        before = {name: self._adam.state.get(column, {}) for name, column in self.theta.columns().items()}
        self._take(found.theta)
        for name, column in self.theta.columns().items():
            if before[name]:
                self._adam.state[column] = {
                    key: self._moved(value, found.source, found.is_new) for key, value in before[name].items()
                }

    @staticmethod
    def _moved(value: Any, source: Tensor, is_new: Tensor) -> Any:
        """An optimiser's numbers for the rows that stay, 0 for new ones; its count of steps as it is."""
        if value.ndim == 0:
            return value
        rows = value[source].clone()
        rows[is_new] = 0.0
        return rows

    def state(self) -> dict[str, Tensor]:
        """All that is needed to go on, as tensors."""
        import torch

        found = {"turns": torch.tensor(self.turns), "pull": self._pull, "pulls": torch.tensor(self._pulls)}
        for name, column in self.theta.columns().items():
            found[f"theta/{name}"] = column.detach()
            if column.grad is not None:
                found[f"gradient/{name}"] = column.grad
            for key, value in self._adam.state.get(column, {}).items():
                found[f"adam/{name}/{key}"] = value
        return found

    def restore(self, state: dict[str, Tensor]) -> None:
        """Go on where ``state`` ended."""
        device = self.box.device
        self._take(Theta(**{name: state[f"theta/{name}"].to(device) for name in self.theta.columns()}))
        for name, column in self.theta.columns().items():
            if f"gradient/{name}" in state:
                column.grad = state[f"gradient/{name}"].to(device).clone()
            kept = {key.rpartition("/")[2]: state[key] for key in state if key.startswith(f"adam/{name}/")}
            if kept:
                self._adam.state[column] = {
                    key: value.clone() if value.ndim == 0 else value.to(device).clone() for key, value in kept.items()
                }
        self.turns, self._pulls = int(state["turns"]), int(state["pulls"])
        self._pull = state["pull"].to(device).clone()


# Cameras of the two terms, and what they see: four at equal steps around a figure, as MVDream was trained; one before
# the scene.


FIELDS = (30.0, 50.0)  # degrees
ELEVATIONS = (0.0, 30.0)
_NEAR, _FAR = 1.0, 1.2  # distances at which a ball of radius 1 nearly fills the picture
_SCENE_FIELD = 40.0


def around(count: int, size: int, generator: Generator) -> list[Camera]:
    """``count`` cameras at equal steps around the middle of a figure, for pictures of ``size`` pixels square."""
    import torch

    start, up, far, wide = torch.rand(4, generator=generator).tolist()
    elevation = ELEVATIONS[0] + up * (ELEVATIONS[1] - ELEVATIONS[0])
    field = FIELDS[0] + wide * (FIELDS[1] - FIELDS[0])
    return ring(count, size, 360.0 * start, elevation, field, _NEAR + far * (_FAR - _NEAR))


def ring(
    count: int, size: int, azimuth: float = 30.0, elevation: float = 15.0, field: float = 40.0, far: float = 1.1
) -> list[Camera]:
    """Cameras from ``azimuth`` on, angles in degrees; at the distance ``far`` / tan(field / 2)."""
    tangent = math.tan(math.radians(field) / 2.0)
    cameras = []
    for number in range(count):
        axes = axes_of(azimuth + 360.0 * number / count, elevation)
        cameras.append(camera_at(-far / tangent * axes[2], axes, size / (2.0 * tangent), size, size))
    return cameras


def before(low: npt.NDArray[np.float64], high: npt.NDArray[np.float64], size: int, generator: Generator) -> Camera:
    """A camera that sees the whole box from ``low`` to ``high`` (3,) from anywhere around."""
    import torch

    turn, up = torch.rand(2, generator=generator).tolist()
    elevation = ELEVATIONS[0] + up * (ELEVATIONS[1] - ELEVATIONS[0])
    return place(Viewpoint(360.0 * turn, elevation, fov=_SCENE_FIELD), low, high, size, size)


def depth_pictures(depth: Tensor, alpha: Tensor) -> Tensor:
    """A depth picture (1, 3, H, W) as ControlNet reads it: the nearest is white, nothing is black; from ``depth`` and
    ``alpha`` (H, W)."""
    import torch

    seen = alpha > 0.5
    inverse = torch.where(seen, 1.0 / depth.clamp_min(1e-6), 0.0)
    if bool(seen.any()):
        low, high = inverse[seen].min(), inverse[seen].max()
        inverse = torch.where(seen, 0.1 + 0.9 * (inverse - low) / (high - low).clamp_min(1e-9), 0.0)
    return inverse[None, None].expand(1, 3, -1, -1)


def alone(gaussians: Gaussians) -> Splats:
    """A figure's Gaussians where they are in its own frame."""
    import torch

    like = gaussians.means
    return posed(gaussians, torch.eye(3).to(like), torch.zeros(3).to(like))


def background(generator: Generator) -> float:
    """The grey, sRGB, behind the pictures of one step: over a fixed one, a thing of just that grey would have no
    gradient by its opacities."""
    import torch

    return float(torch.rand((), generator=generator))


def pictured(splats: Splats, camera: Camera, behind: float = BACKGROUND) -> Tensor:
    """Splats as the models see them, (H, W, 3) sRGB over the grey ``behind``; differentiable."""
    drawn = rasterise(splats, view_of(camera, splats.means))
    return drawn.color + (1.0 - drawn.alpha[..., None]) * behind


def stacked(pictures: Sequence[Tensor]) -> Tensor:
    """Pictures (H, W, 3) as (B, 3, H, W)."""
    import torch

    return torch.stack([picture.permute(2, 0, 1) for picture in pictures])


@dataclass(frozen=True, slots=True, eq=False)
class Teachers:
    """The models: ``figures`` denoises views of one thing together; ``scene``, which may be None, keeps to a depth
    picture. ``vectors`` stand for learned handles; ``prompt`` is what the scene is."""

    figures: DiffusionModel
    scene: DiffusionModel | None
    vectors: Mapping[str, Tensor]
    prompt: Prompt


@dataclass(frozen=True, slots=True)
class Losses:
    """What the terms of one step were; ``scene`` is 0 without a model for it, and in steps that begin no round."""

    figure: float
    scene: float
    shape: float
    layout: float


class Learning:
    """A distillation in progress. ``frozen`` figures keep what they are given and have no turns."""

    def __init__(
        self,
        cast: Cast,
        teachers: Teachers,
        settings: DistillationSettings,
        device: str,
        frozen: Mapping[int, dict[str, Tensor]],
    ) -> None:
        import torch

        self.cast, self._teachers, self._settings, self._device = cast, teachers, settings, device
        self._names = [figure_key(figure) for figure in cast.figures]
        self.figures = [self._figure(number) for number in range(len(cast.figures))]
        for number, state in frozen.items():
            self.figures[number].restore(state)
        self.frozen = tuple(sorted(frozen))
        self._active = [number for number in range(len(cast.figures)) if number not in frozen]
        starts = np.stack([actor.poses for actor in cast.actors])
        self._starts = torch.from_numpy(starts).float().to(device)
        self.poses = _leaves(resting(len(cast.actors), cast.frames, self._starts))
        rates = settings.rates
        paces = (rates.turns, rates.shifts, rates.pose_scales)
        self._adam = torch.optim.Adam(
            [{"params": [column], "lr": pace} for column, pace in zip(self.poses.columns().values(), paces)]
        )
        self.step_number = 0
        self._heard: dict[int, Heard] = {}
        self._hulls: dict[int, Splats] = {}

    @property
    def learned(self) -> int:
        """How many figures have turns."""
        return len(self._active)

    @property
    def steps(self) -> int:
        """All steps of the run."""
        return self._settings.steps * len(self._active)

    def step(self, share: float | None = None) -> Losses:
        """One step; ``share`` of the work that is done, where not steps but time ends it."""
        import torch

        number = self._active[self.step_number % len(self._active)]
        figure = self.figures[number]
        generator = self._generator(f"{self._names[number]}/{figure.turns}")
        done = max(figure.done, share or 0.0)
        told, shape, layout = self._figure_terms(number, done, generator)
        weights = self._settings.weights
        loss = weights.figure * told + weights.shape * shape + weights.layout * layout
        begins = self.step_number % len(self._active) == 0
        scene = self._scene_term(done) if begins and self._teachers.scene is not None else None
        if scene is not None:
            loss = loss + weights.scene * scene
        if not bool(torch.isfinite(loss)):
            said = self.cast.figures[number].condition.plain
            message = f"step {self.step_number + 1} gives no numbers for `{said}`: the models say nothing of use"
            raise SceneError("unsupported", message, hint="less --guidance, whole weights, or no half precision")
        torch.autograd.backward(loss)
        self._follow(figure, scene is not None)
        figure.turned(generator)
        self.step_number += 1
        terms = (told, scene, shape, layout)
        return Losses(*(0.0 if term is None else float(term.detach()) for term in terms))

    def _follow(self, figure: FigureLearning, has_scene: bool) -> None:
        """A step of the figure, and of the poses where there is the scene's term, whose gradients by other figures wait
        for the turns of these."""
        figure.step()
        if not has_scene:
            return
        self._adam.step()
        self._adam.zero_grad(set_to_none=True)
        for number in self.frozen:  # what is frozen has gradients all the same
            for column in self.figures[number].theta.columns().values():
                column.grad = None

    # --- the terms ----------------------------------------------------------------------------------------------

    def _figure_terms(self, number: int, done: float, generator: Generator) -> tuple[Tensor, Tensor, Tensor]:
        """The term of MVDream, L_reg and L_layout of one figure."""
        model, learning = self._teachers.figures, self.figures[number]
        gaussians = learning.theta.gaussians()
        cameras = around(model.views, model.size, generator)
        splats = alone(gaussians)
        behind = background(generator)
        pictures = stacked([pictured(splats, camera, behind) for camera in cameras])
        told = sds_loss(
            model, pictures, self._told(number, cameras), self._settings.guiding, window_at(done), generator
        )
        shape = too_long(gaussians.axes, self._matrices(number))
        return told, shape, outside(learning.theta, learning.box)

    def _matrices(self, number: int) -> Tensor:
        """The poses (M, 3, 3) of a figure's first actors, each in the first frame that shows it."""
        import torch

        firsts: dict[int, list[int]] = {}
        mine = [i for i, actor in enumerate(self.cast.actors) if actor.figure == number][:_MOST_POSES]
        for i in mine:
            firsts.setdefault(int(np.argmax(self.cast.actors[i].shown)), []).append(i)
        found = [self.poses.of(torch.tensor(which), frame, self._starts)[0] for frame, which in firsts.items()]
        return torch.cat(found)

    def _scene_term(self, done: float) -> Tensor:
        """The term of the ControlNet: one frame as one camera sees it, kept to the depth of what the program has."""
        model = self._teachers.scene
        assert model is not None
        generator = self._generator(f"scene/{self.step_number}")
        shown = np.flatnonzero(np.any([actor.shown for actor in self.cast.actors], axis=0))
        frame = int(shown[int(generator.initial_seed() % len(shown))])
        splats = self.splats(frame)
        camera = before(*self._reach(frame), model.size, generator)
        picture = pictured(splats, camera, background(generator))
        heard = self._told_scene(self._depth(frame, camera))
        return sds_loss(
            model, stacked([picture]), heard, self._settings.scene_guiding, window_at(done), generator
        )  # fmt: skip

    def splats(self, frame: int) -> Splats:
        """All that is on the stage in a frame, colours sRGB; differentiable."""
        thetas = [figure.theta.gaussians() for figure in self.figures]
        return on_stage(thetas, self.cast.actors, self._starts, self.poses, frame)

    def _depth(self, frame: int, camera: Camera) -> Tensor:
        """The depth picture (1, 3, H, W) of the program's own primitives where they stand now."""
        import torch

        with torch.no_grad():
            parts = []
            for number, which in shown_by_figure(self.cast.actors, frame, self._starts).items():
                hull = self._hull(number)
                poses = (each.repeat_interleave(len(hull), 0) for each in self.poses.of(which, frame, self._starts))
                parts.append(hull.take(copies(len(hull), which)).moved(*poses))
            drawn = rasterise(joined(parts), view_of(camera, parts[0].means))
            return depth_pictures(drawn.depth, drawn.alpha)

    def _hull(self, number: int) -> Splats:
        """What the figure is in the program, in its frame."""
        import torch

        if number not in self._hulls:
            figure = self.cast.figures[number]
            local = torch.from_numpy(figure.local)
            made = gaussians_of(figure.entity, self._settings.hull).splats.moved(local[:, :3], local[:, 3])
            columns = (made.means, made.covariances, made.opacities, made.colors)
            self._hulls[number] = Splats(*(column.float().to(self._device) for column in columns))
        return self._hulls[number]

    def _reach(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """The box around all actors of a frame where the program put them."""
        corners = []
        for actor in self.cast.actors:
            if actor.shown[frame]:
                half = np.abs(actor.poses[frame, :, :3]) @ self.cast.figures[actor.figure].box
                corners += [actor.poses[frame, :, 3] - half, actor.poses[frame, :, 3] + half]
        return np.min(corners, axis=0), np.max(corners, axis=0)

    # --- what the models hear -----------------------------------------------------------------------------------

    def _told(self, number: int, cameras: Sequence[Camera]) -> Heard:
        import torch

        from scenelang.backends.neural.diffusion import camera_rows

        model = self._teachers.figures
        if number not in self._heard:
            prompt = self.cast.figures[number].condition.prompt
            self._heard[number] = self._said(model, prompt, model.views)
        heard = self._heard[number]
        rows = camera_rows(cameras).to(self._device, torch.float32) if model.views > 1 else None
        return Heard(heard.states, heard.unsaid, rows)

    def _told_scene(self, depth: Tensor) -> Heard:
        model = self._teachers.scene
        assert model is not None
        if -1 not in self._heard:
            self._heard[-1] = self._said(model, self._teachers.prompt, 1)
        heard = self._heard[-1]
        return Heard(heard.states, heard.unsaid, None, depth if model.control is not None else None)

    def _said(self, model: DiffusionModel, prompt: Prompt, count: int) -> Heard:
        import torch

        with torch.no_grad():
            said, unsaid = model.text_encoder.encode([prompt, ("",)], self._teachers.vectors)
            return Heard(said.expand(count, -1, -1), unsaid.expand(count, -1, -1))

    # --- going on -----------------------------------------------------------------------------------------------

    def _figure(self, number: int) -> FigureLearning:
        import torch

        box = torch.from_numpy(self.cast.figures[number].box).float().to(self._device)
        shape = np.round(self.cast.figures[number].box, 3).tolist()
        return FigureLearning(box, self._settings, self._generator(f"beginning/{shape}"))

    def _generator(self, what: str) -> Generator:
        """Random numbers for one purpose."""
        import torch

        digest = hashlib.sha256(f"{self._settings.seed}/{what}".encode()).digest()
        return torch.Generator().manual_seed(int.from_bytes(digest[:7], "big"))

    def state(self) -> dict[str, Tensor]:
        """All that is needed to go on, as tensors on the CPU."""
        import torch

        found = {"step": torch.tensor(self.step_number), "starts": self._starts}
        for name, column in self.poses.columns().items():
            found[f"poses/{name}"] = column.detach()
            found |= {f"poses/adam/{name}/{key}": value for key, value in self._adam.state.get(column, {}).items()}
        for number, figure in enumerate(self.figures):
            found |= {f"figure/{number}/{name}": tensor for name, tensor in figure.state().items()}
        return {name: tensor.detach().cpu().contiguous() for name, tensor in found.items()}

    def restore(self, state: Mapping[str, Tensor]) -> None:
        """Go on where ``state`` ended."""
        import torch

        self.step_number = int(state["step"])
        with torch.no_grad():
            for name, column in self.poses.columns().items():
                column.copy_(state[f"poses/{name}"])
                start = f"poses/adam/{name}/"
                kept = {key.removeprefix(start): value for key, value in state.items() if key.startswith(start)}
                if kept:
                    self._adam.state[column] = {
                        key: value.clone() if value.ndim == 0 else value.to(self._device) for key, value in kept.items()
                    }
        for number, figure in enumerate(self.figures):
            figure.restore(figure_state(state, number))


_MOST_POSES = 64  # of one figure that L_reg looks at


def figure_state(state: Mapping[str, Tensor], number: int) -> dict[str, Tensor]:
    """The part of a state that belongs to one figure."""
    start = f"figure/{number}/"
    return {key.removeprefix(start): value for key, value in state.items() if key.startswith(start)}


def figure_key(figure: Figure) -> str:
    """What a figure depends on: its sentence and its box."""
    return f"{prompt_text(figure.condition.prompt)} {np.round(figure.box, 3).tolist()}"


def _leaves(poses: Poses) -> Poses:
    return Poses(*(column.requires_grad_(True) for column in poses.columns().values()))
