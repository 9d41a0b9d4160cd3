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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenelang.backends.distillation.cast import Cast, Figure
from scenelang.backends.distillation.figure_learning import FigureLearning
from scenelang.backends.distillation.regularisers import outside, too_long
from scenelang.backends.distillation.sds import Heard, sds_loss, window_at
from scenelang.backends.distillation.settings import Settings
from scenelang.backends.distillation.theta import Poses, copies, on_stage, resting, shown_by_figure
from scenelang.backends.distillation.views import alone, around, background, before, depth_pictures, pictured, stacked
from scenelang.backends.splats.gaussians import Splats, joined
from scenelang.backends.splats.initial import gaussians_of
from scenelang.backends.splats.rasterise import rasterise
from scenelang.backends.splats.view import view_of
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Generator, Tensor

    from scenelang.backends.camera import Camera
    from scenelang.backends.clip.prompts import Prompt
    from scenelang.backends.diffusion.model import Diffusion


@dataclass(frozen=True, slots=True, eq=False)
class Teachers:
    """The models: ``figures`` denoises views of one thing together; ``scene``, which may be None, keeps to a depth
    picture. ``vectors`` stand for learned handles; ``prompt`` is what the scene is."""

    figures: Diffusion
    scene: Diffusion | None
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
        self, cast: Cast, teachers: Teachers, settings: Settings, device: str, frozen: Mapping[int, dict[str, Tensor]]
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

        from scenelang.backends.diffusion.multiview import camera_rows

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

    def _said(self, model: Diffusion, prompt: Prompt, count: int) -> Heard:
        import torch

        with torch.no_grad():
            said, unsaid = model.words.encode([prompt, ("",)], self._teachers.vectors)
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
    from scenelang.backends.clip.encodings import written

    return f"{written(figure.condition.prompt)} {np.round(figure.box, 3).tolist()}"


def _leaves(poses: Poses) -> Poses:
    return Poses(*(column.requires_grad_(True) for column in poses.columns().values()))
