"""Optimization of the paper's loss over theta_j and t_j (appendix, "Primitive Reparameterization via SDS Guidance").

Each step optimizes one group, in round-robin order: SDS by the multi-view model on four views, L_reg and L_layout. With
a model for whole scenes, the first step of a round also computes SDS by the depth-conditioned ControlNet on one view of
a frame, since the paper's sum contains this term once, but the others once per group. Each group applies the scene's
gradient in its own step. All random numbers depend only on the seed, the group and its step number, so a resumed run
has the same result as an uninterrupted one, and the prompt of one group affects others only through the scene's term.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.distillation.terms import (
    WEIGHTINGS,
    Conditioning,
    Guidance,
    PoseOffsets,
    Theta,
    annealed_range,
    axis_ratio_loss,
    compose,
    densify_and_prune,
    initial_theta,
    layout_loss,
    repeat_indices,
    sds_loss,
    visible_by_group,
    zero_offsets,
)
from scenelang.backends.neural.prompts import PromptCondition, PromptLeaf, prompt_text
from scenelang.backends.neural.splats.gaussians import Splats, apply_pose, concatenate_splats, view_of
from scenelang.backends.neural.splats.initial import gaussians_of
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.backends.pictures.camera import Camera, Viewpoint, axes_of, camera_at, place
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import setting, whole
from scenelang.interpreter.scene.entity import Entity

if TYPE_CHECKING:
    from torch import Generator, Tensor

    from scenelang.backends.neural.clip import Prompt
    from scenelang.backends.neural.diffusion import DiffusionModel
    from scenelang.backends.neural.splats.gaussians import Gaussians, Splats
    from scenelang.backends.pictures.camera import Camera


# Groups: one set of Gaussians for all leaves with the same prompt and the same shape of box.
#
# The Gaussians of a group are in a frame of their own, in which the leaf's box is centered and its half sizes have norm
# 1. The pose of an instance maps it to the world. In the paper's terms, the primitive is normalised, and leaves with
# equal ``z`` and equal ``S_t / ||S_t||`` share ``theta``.


FloatArray = npt.NDArray[np.float64]

_BOX_TOLERANCE = 1e-3  # difference of half sizes up to which boxes are equal
_MIN_THICKNESS = 1e-3  # minimum half size of flat entities, relative to the largest half size
_MAX_GUIDANCE = 1e4


@dataclass(frozen=True, slots=True, eq=False)
class GaussianGroup:
    """Leaves with a common set of Gaussians.

    Attributes
    ----------
    condition
        Prompt.
    box
        (3,), half sizes with norm 1.
    entity
        Entity of the first leaf.
    local
        (3, 4), from the entity's frame to the group's.
    """

    condition: PromptCondition
    box: FloatArray
    entity: Entity
    local: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class GroupInstance:
    """Instance of a group over F frames.

    Attributes
    ----------
    group
        Index of the group.
    name, handle
        Words from the root, and handle.
    poses
        (F, 3, 4), from the group's frame to the world.
    visible
        (F,), whether the instance exists in each frame.
    """

    group: int
    name: str
    handle: str
    poses: FloatArray
    visible: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class SceneGroups:
    """Groups of a scene with ``frames`` frames, and their instances."""

    groups: tuple[GaussianGroup, ...]
    instances: tuple[GroupInstance, ...]
    frames: int


def group_leaves(frames: Sequence[Sequence[PromptLeaf]]) -> SceneGroups:
    """Group the leaves of a scene's frames.

    Leaves of several frames with the same path and word are one instance over time, as in the paper's 4D scenes.
    """
    over_time: dict[tuple[tuple[int, ...], str], dict[int, PromptLeaf]] = {}
    for number, leaves in enumerate(frames):
        for leaf in leaves:
            over_time.setdefault((leaf.path, leaf.entity.word), {})[number] = leaf
    groups: list[GaussianGroup] = []
    indices: dict[object, int] = {}
    instances = []
    for by_frame in over_time.values():
        first = next(iter(by_frame.values()))
        box, local = _normalize(first)
        key = (first.condition.prompt, tuple(np.round(box / _BOX_TOLERANCE).astype(int).tolist()))
        if key not in indices:
            indices[key] = len(groups)
            groups.append(GaussianGroup(first.condition, box, first.entity, local))
        instances.append(_instance(indices[key], groups[indices[key]].box, by_frame, len(frames)))
    return SceneGroups(tuple(groups), tuple(instances), len(frames))


def _instance(group: int, box: FloatArray, by_frame: dict[int, PromptLeaf], frames: int) -> GroupInstance:
    poses = np.zeros((frames, 3, 4))
    for number, leaf in by_frame.items():
        center, half = _center_and_half_sizes(leaf)
        poses[number, :, :3] = leaf.pose[:, :3] * (half / box)
        poses[number, :, 3] = leaf.pose[:, :3] @ center + leaf.pose[:, 3]
    first = next(iter(by_frame.values()))
    visible = np.array([number in by_frame for number in range(frames)])
    return GroupInstance(group, first.name, first.handle, poses, visible)


def _center_and_half_sizes(leaf: PromptLeaf) -> tuple[FloatArray, FloatArray]:
    """Return the center and the half sizes (3,) of a leaf's box in its own frame, with a minimum thickness."""
    low, high = np.array(leaf.box[:3]), np.array(leaf.box[3:])
    half = (high - low) / 2.0
    return (low + high) / 2.0, np.maximum(half, _MIN_THICKNESS * max(float(half.max()), 1e-9))


def _normalize(leaf: PromptLeaf) -> tuple[FloatArray, FloatArray]:
    """Return the half sizes (3,) in the world scaled to norm 1, and the matrix (3, 4) from the leaf's frame to its
    group's."""
    center, half = _center_and_half_sizes(leaf)
    sizes = np.linalg.norm(leaf.pose[:, :3] * half, axis=0)
    box = np.maximum(sizes, _MIN_THICKNESS * max(float(sizes.max()), 1e-9))
    box = box / np.linalg.norm(box)
    scale = box / half
    return box, np.hstack([np.diag(scale), (-scale * center)[:, None]])


# Settings.


BACKGROUND = 0.5  # grey of previews, sRGB; in training, each step has a random grey


@dataclass(frozen=True, slots=True)
class LearningRates:
    """Learning rates of the Gaussians, in the frame of their group, and of the pose offsets."""

    means: float = 5e-3
    opacities: float = 5e-2
    log_scales: float = 1e-2
    quaternions: float = 1e-2
    colors: float = 5e-2
    rotations: float = 1e-3
    translations: float = 2e-3
    pose_scales: float = 2e-3


@dataclass(frozen=True, slots=True)
class LossWeights:
    """Weights of the loss terms: SDS of a ``group`` and of the ``scene``, ``axis_ratio`` (L_reg) and ``layout``."""

    group: float = 1.0
    scene: float = 1.0
    axis_ratio: float = 10.0
    layout: float = 100.0


@dataclass(frozen=True, slots=True)
class DistillationSettings:
    """Settings of a distillation; ``of`` derives them from the most important ones.

    Parameters
    ----------
    seed : int
        Random seed.
    steps : int
        Number of steps per group.
    initial_gaussians, max_gaussians : int
        Number of Gaussians of a group at the start (more if required to reach ``max_gaussians``) and at the end.
    densify_interval : int
        Steps of a group between densifications.
    densify_until : float
        Fraction of the steps after which there are no more densifications.
    guidance, scene_guidance : Guidance
        Guidance of the group's and the scene's SDS terms.
    loss_weights : LossWeights
        Weights of the loss terms.
    learning_rates : LearningRates
        Learning rates.
    depth_gaussians : int
        Gaussians per group for rendering the program's geometry as a depth map.
    """

    seed: int = 0
    steps: int = setting(2000, "number of steps per object (default 2000)", metavar="N", read=whole)
    initial_gaussians: int = 1000
    max_gaussians: int = setting(
        20_000, "maximum number of Gaussians per object (default 20,000)", "--gaussians", metavar="N", read=whole
    )
    densify_interval: int = 100
    densify_until: float = 0.7
    guidance: Guidance = field(default_factory=Guidance)
    scene_guidance: Guidance = field(default_factory=lambda: Guidance(weighting="sds"))
    loss_weights: LossWeights = field(default_factory=LossWeights)
    learning_rates: LearningRates = field(default_factory=LearningRates)
    depth_gaussians: int = 2000

    @staticmethod
    def of(
        steps: int = 2000,
        gaussians: int = 20_000,
        guidance: float = 50.0,
        weighting: str = "reconstruction",
        seed: int = 0,
    ) -> DistillationSettings:
        """Return settings with the given values, and the others derived from them.

        Parameters
        ----------
        steps : int
            Number of steps per object.
        gaussians : int
            Maximum number of Gaussians per object, at least 16.
        guidance : float
            Classifier-free guidance scale of both models, 0 to 10,000.
        weighting : str
            Timestep weighting of the objects' SDS terms: "reconstruction", "sds" or "uniform".
        seed : int
            Random seed.

        Raises
        ------
        SceneError
            If a number is out of range or the weighting is unknown.

        Examples
        --------
        >>> DistillationSettings.of(steps=50).densify_interval
        10
        """
        if not 0.0 <= guidance <= _MAX_GUIDANCE:
            raise SceneError("value", f"`--guidance` must be 0 to {_MAX_GUIDANCE:,.0f}, not {guidance:g}")
        if steps < 1 or gaussians < 16:
            raise SceneError("value", f"expected at least 1 step and 16 Gaussians, got {steps} and {gaussians}")
        if weighting not in WEIGHTINGS:
            raise SceneError("value", f"`--weighting` is one of {', '.join(WEIGHTINGS)}, not `{weighting}`")
        default = DistillationSettings()
        return replace(
            default,
            seed=seed,
            steps=steps,
            initial_gaussians=min(default.initial_gaussians, gaussians),
            max_gaussians=gaussians,
            densify_interval=max(1, min(default.densify_interval, steps // 5)),
            guidance=replace(default.guidance, scale=guidance, weighting=weighting),
            scene_guidance=replace(default.scene_guidance, scale=guidance),
        )

    @property
    def densifications(self) -> int:
        """Number of densifications of a group; each at most doubles the number of Gaussians."""
        return int(self.densify_until * self.steps + 1e-9) // self.densify_interval

    @property
    def start_gaussians(self) -> int:
        """Number of Gaussians from which doubling in each densification reaches the maximum."""
        required = math.ceil(self.max_gaussians / 2.0 ** min(self.densifications, 60))
        return min(self.max_gaussians, max(self.initial_gaussians, required))


# Optimization of one group.


class GroupOptimizer:
    """Gaussians ``theta`` of a group, as leaf tensors, with their optimizer and gradient statistics."""

    def __init__(self, box: Tensor, settings: DistillationSettings, generator: Generator) -> None:
        self.box, self._settings = box, settings
        self.step_count = 0
        self._reset(initial_theta(box, settings.start_gaussians, generator))

    def _reset(self, theta: Theta) -> None:
        """Replace the parameters, with a new optimizer."""
        import torch

        columns = {name: column.detach().clone().requires_grad_(True) for name, column in theta.columns().items()}
        self.theta = Theta(**columns)
        rates = self._settings.learning_rates
        groups = [{"params": [column], "lr": getattr(rates, name)} for name, column in columns.items()]
        # eps as in 3D Gaussian Splatting: gradients of small Gaussians are much smaller than the default 1e-8
        self._adam = torch.optim.Adam(groups, eps=1e-15)
        self._gradient_norms = torch.zeros(len(theta), device=theta.means.device)
        self._gradient_count = 0

    @property
    def done(self) -> float:
        """Completed fraction of the steps."""
        return self.step_count / max(self._settings.steps, 1)

    def step(self) -> None:
        """Apply the gradients of the group's terms, and of the scene's accumulated since the group's last step."""
        gradient = self.theta.means.grad
        if gradient is not None:
            self._gradient_norms += gradient.norm(dim=1)
            self._gradient_count += 1
        self._adam.step()
        self._adam.zero_grad(set_to_none=True)

    def finish_step(self, generator: Generator) -> None:
        """Increment the step count, and densify the Gaussians at intervals."""
        self.step_count += 1
        settings = self._settings
        remaining = settings.densifications - self.step_count // settings.densify_interval + 1
        if self.step_count % settings.densify_interval == 0 and remaining > 0:
            growth = max(settings.max_gaussians / len(self.theta), 1.0) ** (1.0 / remaining)
            self._densify(min(math.ceil(growth * len(self.theta)), settings.max_gaussians), generator)

    def _densify(self, max_count: int, generator: Generator) -> None:
        """Densify and prune the Gaussians; unchanged ones keep their optimizer state."""
        gradient = self._gradient_norms / max(self._gradient_count, 1)
        change = densify_and_prune(self.theta, self.box, gradient, max_count, generator)
        before = {name: self._adam.state.get(column, {}) for name, column in self.theta.columns().items()}
        self._reset(change.theta)
        for name, column in self.theta.columns().items():
            if before[name]:
                self._adam.state[column] = {
                    key: self._carry_over(value, change.source, change.is_new) for key, value in before[name].items()
                }

    @staticmethod
    def _carry_over(value: Any, source: Tensor, is_new: Tensor) -> Any:
        """Return an optimizer state for the new rows, 0 for new Gaussians; the scalar step count is unchanged."""
        if value.ndim == 0:
            return value
        rows = value[source].clone()
        rows[is_new] = 0.0
        return rows

    def state(self) -> dict[str, Tensor]:
        """Return everything needed to resume, as tensors."""
        import torch

        tensors = {
            "turns": torch.tensor(self.step_count),
            "pull": self._gradient_norms,
            "pulls": torch.tensor(self._gradient_count),
        }
        for name, column in self.theta.columns().items():
            tensors[f"theta/{name}"] = column.detach()
            if column.grad is not None:
                tensors[f"gradient/{name}"] = column.grad
            for key, value in self._adam.state.get(column, {}).items():
                tensors[f"adam/{name}/{key}"] = value
        return tensors

    def restore(self, state: dict[str, Tensor]) -> None:
        """Load a state."""
        device = self.box.device
        self._reset(Theta(**{name: state[f"theta/{name}"].to(device) for name in self.theta.columns()}))
        for name, column in self.theta.columns().items():
            if f"gradient/{name}" in state:
                column.grad = state[f"gradient/{name}"].to(device).clone()
            adam_state = {key.rpartition("/")[2]: state[key] for key in state if key.startswith(f"adam/{name}/")}
            if adam_state:
                self._adam.state[column] = {
                    key: value.clone() if value.ndim == 0 else value.to(device).clone()
                    for key, value in adam_state.items()
                }
        self.step_count, self._gradient_count = int(state["turns"]), int(state["pulls"])
        self._gradient_norms = state["pull"].to(device).clone()


# Cameras and renderings of both SDS terms: equidistant views around a group, in the ranges of MVDream's training data,
# and one view of the scene.


FIELDS_OF_VIEW = (30.0, 50.0)  # degrees
ELEVATIONS = (0.0, 30.0)  # degrees
_DISTANCES = (1.0, 1.2)  # times 1 / tan(fov / 2), the distance at which a unit ball nearly fills the image
_SCENE_FIELD_OF_VIEW = 40.0  # degrees


def random_views(count: int, size: int, generator: Generator) -> list[Camera]:
    """Return ``count`` cameras at equal angles around a group, at a random viewpoint, for images of ``size`` pixels."""
    import torch

    azimuth, u, v, w = torch.rand(4, generator=generator).tolist()
    elevation = ELEVATIONS[0] + u * (ELEVATIONS[1] - ELEVATIONS[0])
    fov = FIELDS_OF_VIEW[0] + w * (FIELDS_OF_VIEW[1] - FIELDS_OF_VIEW[0])
    distance = _DISTANCES[0] + v * (_DISTANCES[1] - _DISTANCES[0])
    return orbit_cameras(count, size, 360.0 * azimuth, elevation, fov, distance)


def orbit_cameras(
    count: int, size: int, azimuth: float = 30.0, elevation: float = 15.0, fov: float = 40.0, distance: float = 1.1
) -> list[Camera]:
    """Return ``count`` cameras at equal angles, starting at ``azimuth``; angles are in degrees.

    The distance from the origin is ``distance`` / tan(fov / 2).
    """
    tangent = math.tan(math.radians(fov) / 2.0)
    cameras = []
    for number in range(count):
        axes = axes_of(azimuth + 360.0 * number / count, elevation)
        cameras.append(camera_at(-distance / tangent * axes[2], axes, size / (2.0 * tangent), size, size))
    return cameras


def random_scene_view(
    low: npt.NDArray[np.float64], high: npt.NDArray[np.float64], size: int, generator: Generator
) -> Camera:
    """Return a camera with a random viewpoint that frames the box from ``low`` to ``high`` (3,)."""
    import torch

    azimuth, u = torch.rand(2, generator=generator).tolist()
    elevation = ELEVATIONS[0] + u * (ELEVATIONS[1] - ELEVATIONS[0])
    return place(Viewpoint(360.0 * azimuth, elevation, fov=_SCENE_FIELD_OF_VIEW), low, high, size, size)


def local_splats(gaussians: Gaussians) -> Splats:
    """Return a group's Gaussians as splats in its own frame."""
    import torch

    like = gaussians.means
    return apply_pose(gaussians, torch.eye(3).to(like), torch.zeros(3).to(like))


def random_background(generator: Generator) -> float:
    """Return a random grey, sRGB, for the background of one step.

    With a fixed background, opacities of Gaussians of the same grey would have no gradient.
    """
    import torch

    return float(torch.rand((), generator=generator))


def render(splats: Splats, camera: Camera, background: float = BACKGROUND) -> Tensor:
    """Render splats over a grey background: (H, W, 3) sRGB, differentiable."""
    drawn = rasterise(splats, view_of(camera, splats.means))
    return drawn.color + (1.0 - drawn.alpha[..., None]) * background


def to_batch(pictures: Sequence[Tensor]) -> Tensor:
    """Stack images (H, W, 3) to a batch (B, 3, H, W)."""
    import torch

    return torch.stack([picture.permute(2, 0, 1) for picture in pictures])


@dataclass(frozen=True, slots=True, eq=False)
class Teachers:
    """Diffusion models that supervise the distillation.

    Attributes
    ----------
    multiview
        Model for single groups, which denoises several views jointly.
    scene
        Model for the whole scene, with a depth ControlNet, or None.
    vectors
        Learned vectors by handle.
    prompt
        Prompt of the scene.
    """

    multiview: DiffusionModel
    scene: DiffusionModel | None
    vectors: Mapping[str, Tensor]
    prompt: Prompt


@dataclass(frozen=True, slots=True)
class Losses:
    """Loss terms of one step; ``scene`` is 0 without a scene model, and in all but the first step of a round."""

    group: float
    scene: float
    axis_ratio: float
    layout: float

    def data(self) -> dict[str, float]:
        """Return the terms by their names in the log of losses."""
        return {"figure": self.group, "scene": self.scene, "shape": self.axis_ratio, "layout": self.layout}


class DistillationTrainer:
    """Optimization of a scene; groups with a ``frozen`` state are not optimized."""

    def __init__(
        self,
        scene: SceneGroups,
        teachers: Teachers,
        settings: DistillationSettings,
        device: str,
        frozen: Mapping[int, dict[str, Tensor]],
    ) -> None:
        import torch

        self.scene, self._teachers, self._settings, self._device = scene, teachers, settings, device
        self._keys = [group_key(group) for group in scene.groups]
        self.groups = [self._group_optimizer(number) for number in range(len(scene.groups))]
        for number, state in frozen.items():
            self.groups[number].restore(state)
        self.frozen = tuple(sorted(frozen))
        self._active = [number for number in range(len(scene.groups)) if number not in frozen]
        poses = np.stack([instance.poses for instance in scene.instances])
        self._initial_poses = torch.from_numpy(poses).float().to(device)
        self.offsets = _as_leaves(zero_offsets(len(scene.instances), scene.frames, self._initial_poses))
        rates = settings.learning_rates
        pose_rates = (rates.rotations, rates.translations, rates.pose_scales)
        self._adam = torch.optim.Adam(
            [{"params": [column], "lr": rate} for column, rate in zip(self.offsets.columns().values(), pose_rates)]
        )
        self.step_number = 0
        self._prompts: dict[int, Conditioning] = {}  # cached; -1 is the scene
        self._surfaces: dict[int, Splats] = {}

    @property
    def learned(self) -> int:
        """Number of optimized groups."""
        return len(self._active)

    @property
    def steps(self) -> int:
        """Total number of steps."""
        return self._settings.steps * len(self._active)

    def step(self, share: float | None = None) -> Losses:
        """Make one step; ``share`` is the completed fraction of a run that is limited by time."""
        import torch

        number = self._active[self.step_number % len(self._active)]
        group = self.groups[number]
        generator = self._generator(f"{self._keys[number]}/{group.step_count}")
        done = max(group.done, share or 0.0)
        sds, axis_ratio, layout = self._group_terms(number, done, generator)
        weights = self._settings.loss_weights
        loss = weights.group * sds + weights.axis_ratio * axis_ratio + weights.layout * layout
        starts_round = self.step_number % len(self._active) == 0
        scene = self._scene_term(done) if starts_round and self._teachers.scene is not None else None
        if scene is not None:
            loss = loss + weights.scene * scene
        if not bool(torch.isfinite(loss)):
            prompt = self.scene.groups[number].condition.plain
            message = f"the loss of step {self.step_number + 1} for `{prompt}` is not finite"
            raise SceneError("unsupported", message, hint="reduce --guidance, check the weights, or omit --half")
        torch.autograd.backward(loss)
        self._apply_gradients(group, has_scene=scene is not None)
        group.finish_step(generator)
        self.step_number += 1
        terms = (sds, scene, axis_ratio, layout)
        return Losses(*(0.0 if term is None else float(term.detach()) for term in terms))

    def _apply_gradients(self, group: GroupOptimizer, *, has_scene: bool) -> None:
        """Update the group and, after a scene term, the pose offsets.

        The scene's gradients for other groups accumulate until their own steps.
        """
        group.step()
        if not has_scene:
            return
        self._adam.step()
        self._adam.zero_grad(set_to_none=True)
        for number in self.frozen:  # the scene term produces gradients for frozen groups too
            for column in self.groups[number].theta.columns().values():
                column.grad = None

    # --- loss terms ---------------------------------------------------------------------------------------------

    def _group_terms(self, number: int, done: float, generator: Generator) -> tuple[Tensor, Tensor, Tensor]:
        """Return the SDS term of the multi-view model, L_reg and L_layout of one group."""
        model, group = self._teachers.multiview, self.groups[number]
        gaussians = group.theta.gaussians()
        cameras = random_views(model.views, model.size, generator)
        splats = local_splats(gaussians)
        background = random_background(generator)
        pictures = to_batch([render(splats, camera, background) for camera in cameras])
        conditioning = self._group_conditioning(number, cameras)
        sds = sds_loss(model, pictures, conditioning, self._settings.guidance, annealed_range(done), generator)
        axis_ratio = axis_ratio_loss(gaussians.axes, self._matrices(number))
        return sds, axis_ratio, layout_loss(group.theta, group.box)

    def _matrices(self, number: int) -> Tensor:
        """Return the matrices (M, 3, 3) of a group's first instances, each in its first visible frame."""
        import torch

        by_frame: dict[int, list[int]] = {}
        members = [i for i, each in enumerate(self.scene.instances) if each.group == number][:_MAX_POSES]
        for i in members:
            by_frame.setdefault(int(np.argmax(self.scene.instances[i].visible)), []).append(i)
        matrices = [
            self.offsets.apply(torch.tensor(indices), frame, self._initial_poses)[0]
            for frame, indices in by_frame.items()
        ]
        return torch.cat(matrices)

    def _scene_term(self, done: float) -> Tensor:
        """Return the SDS term of the scene model for one view of a frame, conditioned on the program's depth."""
        model = self._teachers.scene
        assert model is not None
        generator = self._generator(f"scene/{self.step_number}")
        frames = np.flatnonzero(np.any([instance.visible for instance in self.scene.instances], axis=0))
        frame = int(frames[int(generator.initial_seed() % len(frames))])
        splats = self.splats(frame)
        camera = random_scene_view(*self._bounds(frame), model.size, generator)
        picture = render(splats, camera, random_background(generator))
        conditioning = self._scene_conditioning(self._depth(frame, camera))
        guidance, timestep_range = self._settings.scene_guidance, annealed_range(done)
        return sds_loss(model, to_batch([picture]), conditioning, guidance, timestep_range, generator)

    def splats(self, frame: int) -> Splats:
        """Return all Gaussians of a frame in the world, colors sRGB; differentiable."""
        groups = [group.theta.gaussians() for group in self.groups]
        return compose(groups, self.scene.instances, self._initial_poses, self.offsets, frame)

    def _depth(self, frame: int, camera: Camera) -> Tensor:
        """Return the depth map (1, 3, H, W) of the program's primitives at their current poses."""
        import torch

        with torch.no_grad():
            parts = []
            for number, members in visible_by_group(self.scene.instances, frame, self._initial_poses).items():
                surface = self._surface(number)
                poses = (
                    each.repeat_interleave(len(surface), 0)
                    for each in self.offsets.apply(members, frame, self._initial_poses)
                )
                parts.append(surface.take(repeat_indices(len(surface), members)).transformed(*poses))
            drawn = rasterise(concatenate_splats(parts), view_of(camera, parts[0].means))
            from scenelang.backends.neural.diffusion import depth_condition

            return depth_condition(drawn.depth, drawn.alpha > 0.5)

    def _surface(self, number: int) -> Splats:
        """Return Gaussians on the surface of the program's entity, in the frame of its group."""
        import torch

        if number not in self._surfaces:
            group = self.scene.groups[number]
            local = torch.from_numpy(group.local)
            made = gaussians_of(group.entity, self._settings.depth_gaussians).splats.transformed(
                local[:, :3], local[:, 3]
            )
            columns = (made.means, made.covariances, made.opacities, made.colors)
            self._surfaces[number] = Splats(*(column.float().to(self._device) for column in columns))
        return self._surfaces[number]

    def _bounds(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the bounding box of a frame's instances at their initial poses."""
        corners = []
        for instance in self.scene.instances:
            if instance.visible[frame]:
                half = np.abs(instance.poses[frame, :, :3]) @ self.scene.groups[instance.group].box
                corners += [instance.poses[frame, :, 3] - half, instance.poses[frame, :, 3] + half]
        return np.min(corners, axis=0), np.max(corners, axis=0)

    # --- conditioning -------------------------------------------------------------------------------------------

    def _group_conditioning(self, number: int, cameras: Sequence[Camera]) -> Conditioning:
        import torch

        from scenelang.backends.neural.diffusion import camera_rows

        model = self._teachers.multiview
        if number not in self._prompts:
            prompt = self.scene.groups[number].condition.prompt
            self._prompts[number] = self._encode(model, prompt, model.views)
        encoded = self._prompts[number]
        rows = camera_rows(cameras).to(self._device, torch.float32) if model.views > 1 else None
        return Conditioning(encoded.prompt, encoded.empty, rows)

    def _scene_conditioning(self, depth: Tensor) -> Conditioning:
        model = self._teachers.scene
        assert model is not None
        if -1 not in self._prompts:
            self._prompts[-1] = self._encode(model, self._teachers.prompt, 1)
        encoded = self._prompts[-1]
        return Conditioning(encoded.prompt, encoded.empty, None, depth if model.control is not None else None)

    def _encode(self, model: DiffusionModel, prompt: Prompt, count: int) -> Conditioning:
        import torch

        with torch.no_grad():
            encoded, empty = model.text_encoder.encode([prompt, ("",)], self._teachers.vectors)
            return Conditioning(encoded.expand(count, -1, -1), empty.expand(count, -1, -1))

    # --- checkpoints --------------------------------------------------------------------------------------------

    def _group_optimizer(self, number: int) -> GroupOptimizer:
        import torch

        box = torch.from_numpy(self.scene.groups[number].box).float().to(self._device)
        shape = np.round(self.scene.groups[number].box, 3).tolist()
        return GroupOptimizer(box, self._settings, self._generator(f"beginning/{shape}"))

    def _generator(self, purpose: str) -> Generator:
        """Return a random generator for one purpose, on the CPU."""
        import torch

        digest = hashlib.sha256(f"{self._settings.seed}/{purpose}".encode()).digest()
        return torch.Generator().manual_seed(int.from_bytes(digest[:7], "big"))

    def state(self) -> dict[str, Tensor]:
        """Return everything needed to resume, as tensors on the CPU."""
        import torch

        tensors = {"step": torch.tensor(self.step_number), "starts": self._initial_poses}
        for name, column in self.offsets.columns().items():
            tensors[f"poses/{name}"] = column.detach()
            tensors |= {f"poses/adam/{name}/{key}": value for key, value in self._adam.state.get(column, {}).items()}
        for number, group in enumerate(self.groups):
            tensors |= {f"figure/{number}/{name}": tensor for name, tensor in group.state().items()}
        return {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}

    def restore(self, state: Mapping[str, Tensor]) -> None:
        """Load a state."""
        import torch

        self.step_number = int(state["step"])
        with torch.no_grad():
            for name, column in self.offsets.columns().items():
                column.copy_(state[f"poses/{name}"])
                prefix = f"poses/adam/{name}/"
                adam_state = {key.removeprefix(prefix): value for key, value in state.items() if key.startswith(prefix)}
                if adam_state:
                    self._adam.state[column] = {
                        key: value.clone() if value.ndim == 0 else value.to(self._device)
                        for key, value in adam_state.items()
                    }
        for number, group in enumerate(self.groups):
            group.restore(group_state(state, number))


_MAX_POSES = 64  # poses of a group for which L_reg is computed


def group_state(state: Mapping[str, Tensor], number: int) -> dict[str, Tensor]:
    """Return the part of a trainer's state that belongs to one group."""
    prefix = f"figure/{number}/"
    return {key.removeprefix(prefix): value for key, value in state.items() if key.startswith(prefix)}


def group_key(group: GaussianGroup) -> str:
    """Return a key that identifies a group by its prompt and box."""
    return f"{prompt_text(group.condition.prompt)} {np.round(group.box, 3).tolist()}"


def _as_leaves(offsets: PoseOffsets) -> PoseOffsets:
    """Return offsets that require gradients."""
    return PoseOffsets(*(column.requires_grad_(True) for column in offsets.columns().values()))
