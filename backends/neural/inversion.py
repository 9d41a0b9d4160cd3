"""Textual Inversion: optimization of token embeddings (pseudo-words), with all networks frozen.

The method is that of Gal et al., "An Image is Worth One Word" (2022), with the template of the paper's appendix.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.files import atomic_write
from scenelang.backends.neural.clip import (
    ClipModel,
    Prompt,
    Slot,
    TextEncoder,
    encode_images,
    parse_prompt,
    substitute_texts,
)
from scenelang.backends.neural.descriptions import has_meaning, noun_of
from scenelang.backends.neural.diffusion import DiffusionModel, PromptEncoder, translate_out_of_memory
from scenelang.backends.neural.prompts import prompt_text
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.datum import asdict, dataclass
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.settings import setting, whole, within
from scenelang.interpreter.inspection.numbering import (
    Ancestry,
    ancestry_of,
    frame_numbers,
    instance_handles,
    number_scene,
)
from scenelang.interpreter.scene.entity import Scene, primitive_count

if TYPE_CHECKING:
    from torch import Tensor


# Pseudo-word of an image: the token embedding for which the prompt is most similar to the image in Z_CLIP.
#
# CLIP's image embedding is in the output space of the text encoder, not in that of its token embeddings, so it cannot
# be used as a token. Instead, a token embedding is optimized to maximize the cosine similarity.


PROMPT = "a photo of <picture>"
INITIAL_WORD = "object"
STEPS = 300
_LEARNING_RATE = 1e-2


@dataclass(frozen=True, slots=True, eq=False)
class PictureWord:
    """Learned ``vectors`` (1, width), with the cosine similarity of prompt and image after and ``before``."""

    vectors: npt.NDArray[np.float32]
    cosine: float
    before: float


def learn_picture_word(
    model: ClipModel, picture: Any, initial_word: str = INITIAL_WORD, steps: int = STEPS
) -> PictureWord:
    """Learn the pseudo-word of a PIL image, initialized with the mean of the token embeddings of ``initial_word``.

    The result is the best of all ``steps``, so never worse than the initial vector, and deterministic. Raises
    SceneError("value") for a text without tokens.
    """
    torch = require("torch", INSTALL)
    encoder, prompt = TextEncoder(model), [parse_prompt(PROMPT)]
    tokens = encoder.token_embeddings(initial_word).detach().float()
    if not len(tokens):
        raise SceneError("value", f'cannot initialize a pseudo-word with "{initial_word}", which has no tokens')
    with translate_out_of_memory():
        target = encode_images(model, [picture])[0].detach().float()
        vector = tokens.mean(0, keepdim=True).clone().requires_grad_(True)
        optimizer = torch.optim.Adam([vector], lr=_LEARNING_RATE)
        best, best_vector, initial = -2.0, vector.detach().clone(), 0.0
        for number in range(steps + 1):
            pooled = encoder.encode(prompt, {"picture": vector}).pooled[0].float()
            cosine = torch.nn.functional.cosine_similarity(pooled, target, dim=0)
            current = float(cosine.detach())
            initial = current if number == 0 else initial
            if current > best:
                best, best_vector = current, vector.detach().clone()
            if number < steps:
                optimizer.zero_grad()
                (-cosine).backward()
                optimizer.step()
    return PictureWord(best_vector.cpu().numpy().astype(np.float32), best, initial)


# Training objective.


def denoising_loss(
    model: DiffusionModel, latents: Tensor, hidden_states: Tensor, timesteps: Tensor, noise: Tensor
) -> Tensor:
    """Return the mean squared error of the network's prediction: the training loss of diffusion models.

    ``latents`` (B, C, h, w) are noised with ``noise`` at ``timesteps`` (B,), and conditioned on ``hidden_states``
    (B, T, D). Every image is denoised independently and without camera, MVDream's mode for single images.
    """
    functional = require("torch.nn.functional", INSTALL)
    noisy = model.schedule.add_noise(latents, noise, timesteps)
    output = model.predict(noisy, timesteps, hidden_states)
    target = model.schedule.training_target(latents, noise, timesteps)
    return functional.mse_loss(output, target)  # type: ignore[no-any-return]


# Settings.


_MAX_STEPS = 100_000
_MAX_BATCH = 256


@dataclass(frozen=True, slots=True)
class InversionSettings:
    """Settings of Textual Inversion; the defaults of steps and learning rate are the paper's.

    Parameters
    ----------
    steps : int
        Number of AdamW steps.
    learning_rate : float
        Greater than 0, and at most 1.
    batch_size : int
        Noisy copies of each image per step.
    seed : int
        Random seed.
    loss_samples : int
        Noisy copies of each image, the same each time, from which the loss before and after is computed.

    Raises
    ------
    SceneError
        If a number is out of range.

    Examples
    --------
    >>> InversionSettings(steps=200).learning_rate
    0.01
    """

    steps: int = setting(100, "number of steps (default 100)", metavar="N", read=whole)
    learning_rate: float = setting(1e-2, "learning rate (default 0.01)", "--rate", metavar="X", read=within(1e-9, 10.0))
    batch_size: int = setting(
        4, "batch size: noisy copies of each image per step (default 4)", "--batch", metavar="N", read=whole
    )
    seed: int = 0
    loss_samples: int = 16

    def __post_init__(self) -> None:
        if not 1 <= self.steps <= _MAX_STEPS:
            raise SceneError("value", f"`--steps` must be 1 to {_MAX_STEPS:,}, not {self.steps:,}")
        if not 0.0 < self.learning_rate <= 1.0:
            message = f"the learning rate must be greater than 0 and at most 1, not {self.learning_rate:g}"
            raise SceneError("value", message)
        if not 1 <= self.batch_size <= _MAX_BATCH:
            raise SceneError("value", f"the batch size must be 1 to {_MAX_BATCH}, not {self.batch_size:,}")


# Prompts with pseudo-words.


TEMPLATE = "<class>, 3d model, in the style of <style>"  # the paper's
STYLE = "style"  # pseudo-word shared by all images of an inversion


@dataclass(frozen=True, slots=True, eq=False)
class LearnedSubject:
    """Training image ``picture`` (3, H, W), sRGB in [0, 1] and of the model's size, with its ``prompt``."""

    picture: Tensor
    prompt: Prompt


def entity_prompt(name: str) -> Prompt:
    """Return the template with the pseudo-word ``name`` for the class."""
    return tuple(Slot(name) if piece == Slot("class") else piece for piece in parse_prompt(TEMPLATE))


def style_prompt(word: str) -> Prompt:
    """Return the template with the text ``word`` for the class, so that only the style is learned."""
    return substitute_texts(parse_prompt(TEMPLATE), lambda name: word if name == "class" else None)


def initial_vector(text_encoder: PromptEncoder, text: str) -> Tensor:
    """Return the initial vector (1, width) of a pseudo-word: the mean of the token embeddings of ``text``.

    Raises SceneError("value") for a text without tokens.
    """
    vectors = text_encoder.token_embeddings(text).detach()
    if not len(vectors):
        raise SceneError("value", f'cannot initialize a pseudo-word with "{text}", which has no tokens')
    return vectors.float().mean(0, keepdim=True)


# Training.


_MOMENTS = ("exp_avg", "exp_avg_sq")  # names in the state of AdamW
_LOSS_SEED = 1 << 40  # larger than any step number, so that the loss is measured with noise not used for training


class InversionTrainer:
    """Optimizer of the vectors (1, width) of pseudo-words, from the images of all ``subjects`` jointly.

    ``initial`` maps names to initial vectors. The noise of a step depends only on the seed and the step number, so a
    resumed run has the same result as an uninterrupted one.
    """

    def __init__(
        self,
        model: DiffusionModel,
        subjects: Sequence[LearnedSubject],
        initial: Mapping[str, Tensor],
        settings: InversionSettings,
    ) -> None:
        self._torch = torch = require("torch", INSTALL)
        self._model, self._subjects, self._settings = model, tuple(subjects), settings
        self._device = model.network.device
        with torch.no_grad():
            pictures = [subject.picture[None].to(self._device) for subject in subjects]
            self._latents = [model.codec.encode(picture) for picture in pictures]
        self._vectors = {name: vector.detach().clone().to(self._device) for name, vector in initial.items()}
        for vector in self._vectors.values():
            vector.requires_grad_(True)
        self._optimizer = torch.optim.AdamW(list(self._vectors.values()), lr=settings.learning_rate)
        self.done = 0

    @property
    def steps(self) -> int:
        return self._settings.steps

    def step(self) -> float:
        """Make one optimization step; returns the mean loss of all subjects before it."""
        generator = self._generator(self.done)
        self._optimizer.zero_grad()
        total = 0.0
        for number in range(len(self._subjects)):  # gradient accumulation, to hold one subject's activations at a time
            sample = self._sample(number, self._settings.batch_size, generator)
            loss = self._loss(number, *sample) / len(self._subjects)
            loss.backward()  # type: ignore[no-untyped-call]
            total += float(loss.detach())
        self._optimizer.step()
        self.done += 1
        return total

    def mean_loss(self) -> float:
        """Return the mean loss with fixed noise, at timesteps evenly distributed over the schedule."""
        generator, samples = self._generator(_LOSS_SEED), self._settings.loss_samples
        timesteps = (self._torch.arange(samples) + 0.5) / samples * self._model.schedule.num_timesteps
        total = 0.0
        with self._torch.no_grad():
            for number, latents in enumerate(self._latents):
                for timestep in timesteps.long():
                    noise = self._torch.randn(latents.shape, generator=generator).to(self._device)
                    total += float(self._loss(number, timestep[None].to(self._device), noise))
        return total / (samples * len(self._subjects))

    def vectors(self) -> dict[str, npt.NDArray[np.float32]]:
        """Return the current vectors by name."""
        return {name: vector.detach().float().cpu().numpy().copy() for name, vector in self._vectors.items()}

    def _generator(self, number: int) -> Any:
        """Return the random generator of a step."""
        mixed = np.random.SeedSequence([self._settings.seed % (1 << 64), number]).generate_state(1, np.uint64)[0]
        return self._torch.Generator().manual_seed(int(mixed) >> 1)

    def _sample(self, number: int, count: int, generator: Any) -> tuple[Tensor, Tensor]:
        """Sample timesteps and noise on the CPU, so that they are the same for every device."""
        torch, shape = self._torch, self._latents[number].shape[1:]
        timesteps = torch.randint(0, self._model.schedule.num_timesteps, (count,), generator=generator)
        noise = torch.randn((count, *shape), generator=generator)
        return timesteps.to(self._device), noise.to(self._device)

    def _loss(self, number: int, timesteps: Tensor, noise: Tensor) -> Tensor:
        states = self._model.text_encoder.encode([self._subjects[number].prompt], self._vectors)
        count = len(timesteps)
        latents = self._latents[number].expand(count, -1, -1, -1)
        return denoising_loss(self._model, latents, states.expand(count, -1, -1), timesteps, noise)

    # --- checkpoints -------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Tensor]:
        """Return the tensors needed to resume, in addition to the number ``done`` of steps."""
        tensors = {}
        for name, vector in self._vectors.items():
            tensors[f"vector/{name}"] = vector.detach().cpu().clone()
            for moment in _MOMENTS if self.done else ():
                tensors[f"{moment}/{name}"] = self._optimizer.state[vector][moment].detach().cpu().clone()
        return tensors

    def restore(self, state: Mapping[str, Tensor], done: int) -> None:
        """Load the ``state`` after ``done`` steps; raises KeyError or ValueError for one of other pseudo-words."""
        with self._torch.no_grad():
            for name, vector in self._vectors.items():
                if state[f"vector/{name}"].shape != vector.shape:
                    raise ValueError(f"the vector of {name} has another shape")
                vector.copy_(state[f"vector/{name}"])
                if done:
                    moments = {moment: state[f"{moment}/{name}"].to(self._device) for moment in _MOMENTS}
                    if any(moment.shape != vector.shape for moment in moments.values()):
                        raise ValueError(f"the moments of {name} have another shape")
                    self._optimizer.state[vector] = {"step": self._torch.tensor(float(done)), **moments}
        self.done = done


# Entities whose embeddings are learned: those named by the user, or all with a meaningful word.


MAX_PRIMITIVES = 100_000  # of all frames
_MAX_HANDLES = 2_000  # per target, since Z stores a vector for each
_MAX_TARGETS = 50  # per run, since each step processes all of them


@dataclass(frozen=True, slots=True)
class InversionTarget:
    """Entities that share a learned embedding.

    Attributes
    ----------
    text
        Noun of the entities.
    handles
        Handles that get the embedding.
    whole
        True if the root is among them, whose embedding is the style of the scene.
    """

    text: str
    handles: tuple[str, ...]
    whole: bool

    @property
    def name(self) -> str:
        """Name of the pseudo-word: the first handle."""
        return self.handles[0]


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    ancestry: Ancestry
    handles: list[str]


def targets_named(scene: Scene, names: Sequence[str]) -> list[InversionTarget]:
    """Return the target of each name.

    A name is a handle `<z4>`, a word, a path of words `tower/roof`, or a path of child indices from the root `0/2`.
    Raises SceneError("value") for a name without an entity; LimitError for a too large scene.
    """
    frames = _frames(scene)
    return [_target_named(frames, name) for name in dict.fromkeys(names)]


def named_parts(scene: Scene) -> list[InversionTarget]:
    """Return a target for each meaningful word of the primitives or of their nearest ancestors with one.

    The root is not a target. Raises SceneError("value") if there is none; LimitError for a too large scene.
    """
    by_word: dict[str, list[tuple[_Frame, int]]] = {}
    for frame in _frames(scene):
        for primitive in frame.ancestry.primitives.tolist():
            chain = [i for i in _self_and_ancestors(frame.ancestry, primitive) if i]
            named = next((i for i in chain if has_meaning(frame.ancestry.entity(i).word)), chain[0] if chain else None)
            if named is not None:
                by_word.setdefault(frame.ancestry.entity(named).word, []).append((frame, named))
    if not by_word:
        raise SceneError("value", f'the scene "{scene.word}" has no parts whose embeddings can be learned')
    if len(by_word) > _MAX_TARGETS:
        hint = "select some of them with --entity"
        raise LimitError("entities", f"the scene has {len(by_word):,} words, more than {_MAX_TARGETS}", hint=hint)
    return [_target(instances) for instances in by_word.values()]


def style_handle(scene: Scene) -> str:
    """Return the handle of the root, whose embedding is the style of the scene."""
    return number_scene(scene).handle(scene.root, 0)


def _frames(scene: Scene) -> list[_Frame]:
    if sum(map(primitive_count, scene.frames)) > MAX_PRIMITIVES:
        raise LimitError("primitives", f"the scene has more than {MAX_PRIMITIVES:,} primitives")
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    ancestries = [ancestry_of(root) for root in scene.frames]
    return [_Frame(each, instance_handles(scene, each, numbers)) for each in ancestries]


def _target_named(frames: Sequence[_Frame], name: str) -> InversionTarget:
    if name.startswith("<"):
        matches = [(f, i) for f in frames for i, handle in enumerate(f.handles) if f"<{handle}>" == name]
    else:
        matches = [(f, i) for f in frames for i in _with_word(f.ancestry, name)]
        matches = matches or [(f, i) for f in frames for i in _at_path(f.ancestry, name)]
    if not matches:
        shown = f"handle {name}" if name.startswith("<") else f'word "{name}"'
        raise SceneError("value", f"the scene has no visible entity with the {shown}")
    return _target(matches)


def _with_word(ancestry: Ancestry, word: str) -> list[int]:
    return [i for i in range(len(ancestry)) if ancestry.entity(i).word == word]


def _at_path(ancestry: Ancestry, path: str) -> Iterator[int]:
    """Yield the instance at child indices from the root `0/2`, or those whose words from the root end in ``path``."""
    if all(part.isdecimal() for part in path.split("/")):
        indices = tuple(map(int, path.split("/")))
        level = (i for i in range(len(ancestry)) if ancestry.depth[i] == len(indices))
        yield from (i for i in level if ancestry.path(i) == indices)
        return
    words = [word for word in path.split("/") if word][::-1]
    for i in _with_word(ancestry, words[0]) if words else ():
        chain = [ancestry.entity(k).word for k in _self_and_ancestors(ancestry, i)]
        if chain[: len(words)] == words:
            yield i


def _self_and_ancestors(ancestry: Ancestry, instance: int) -> Iterator[int]:
    """Iterate over an instance and its ancestors, the root last."""
    while instance >= 0:
        yield instance
        instance = int(ancestry.parent[instance])


def _target(instances: Sequence[tuple[_Frame, int]]) -> InversionTarget:
    handles = tuple(dict.fromkeys(frame.handles[i] for frame, i in instances))
    frame, first = instances[0]
    entity = frame.ancestry.entity(first)
    if len(handles) > _MAX_HANDLES:
        message = f'"{entity.word}" has {len(handles):,} embeddings, more than {_MAX_HANDLES:,}'
        hint = "specify a common ancestor instead, whose embedding applies to all its descendants"
        raise LimitError("entities", message, hint=hint)
    return InversionTarget(noun_of(entity), handles, any(i == 0 for _, i in instances))


# Checkpoints of a run: `inversion.safetensors` in the run folder, written atomically.


CHECKPOINT = "inversion.safetensors"
VERSION = 1
_METADATA_KEY = "scenelang-inversion"
_FORCE_HINT = "use --force to start over"


@dataclass(frozen=True, slots=True, eq=False)
class SavedInversion:
    """Checkpoint of a run.

    Attributes
    ----------
    tensors
        State of the trainer.
    done
        Number of completed steps.
    config
        Configuration of the run, as JSON data.
    losses
        Loss of each step.
    initial_loss
        Mean loss before the first step.
    """

    tensors: Mapping[str, Tensor]
    done: int
    config: Mapping[str, Any]
    losses: tuple[float, ...]
    initial_loss: float

    @property
    def finished(self) -> bool:
        return self.done >= int(self.config["steps"])


def run_config(
    settings: InversionSettings, model: str, subjects: Sequence[LearnedSubject], words: Mapping[str, str]
) -> dict[str, Any]:
    """Return the configuration of a run, which must be equal to resume it, except for the number of steps.

    ``words`` maps names of pseudo-words to the words that initialize them.
    """
    pictures = [
        [prompt_text(subject.prompt), hashlib.sha256(subject.picture.cpu().numpy().tobytes()).hexdigest()]
        for subject in subjects
    ]
    return {**asdict(settings), "model": model, "pictures": pictures, "words": dict(words)}


def save_checkpoint(
    folder: Path, trainer: InversionTrainer, config: Mapping[str, Any], losses: Sequence[float], initial_loss: float
) -> None:
    """Write the checkpoint of a run; raises SceneError("file")."""
    save = require("safetensors.torch", INSTALL).save
    header = {
        "version": VERSION, "done": trainer.done, "asked": config, "losses": list(losses), "first": initial_loss
    }  # fmt: skip
    data = save(trainer.state(), metadata={_METADATA_KEY: json.dumps(header)})
    with atomic_write(folder / CHECKPOINT) as temporary:
        temporary.write_bytes(data)


def load_checkpoint(folder: Path) -> SavedInversion:
    """Load the checkpoint of the run in ``folder``; raises SceneError("file") if it does not exist or is invalid."""
    safetensors = require("safetensors", INSTALL)
    try:
        with safetensors.safe_open(str(folder / CHECKPOINT), framework="pt") as file:
            header = json.loads((file.metadata() or {})[_METADATA_KEY])
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        if header["version"] != VERSION:
            raise ValueError(f"unsupported version {str(header['version'])[:20]}, expected {VERSION}")
        losses = tuple(map(float, header["losses"]))
        saved = SavedInversion(tensors, int(header["done"]), dict(header["asked"]), losses, float(header["first"]))
        if not 0 <= saved.done == len(saved.losses) or int(saved.config["steps"]) < 1:
            raise ValueError("the number of steps differs from the number of losses")
        return saved
    except FileNotFoundError:
        raise SceneError("file", f"no inversion in {folder}") from None
    except (safetensors.SafetensorError, OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise _unreadable(folder, error) from None


def restore(trainer: InversionTrainer, saved: SavedInversion, config: Mapping[str, Any], folder: Path) -> None:
    """Restore the state of ``trainer`` from a checkpoint.

    Raises SceneError: "value" if the run has another configuration, "file" if the tensors do not fit its vectors.
    """
    current = json.loads(json.dumps(dict(config)))
    different = sorted(name for name in current if name != "steps" and saved.config.get(name) != current[name])
    if different:
        message = f"the inversion in {folder} has other settings: {', '.join(different)}"
        raise SceneError("value", message, hint=_FORCE_HINT)
    if saved.done > trainer.steps:
        message = f"the inversion in {folder} has completed {saved.done} steps already, more than {trainer.steps}"
        raise SceneError("value", message, hint=_FORCE_HINT)
    try:
        trainer.restore(saved.tensors, saved.done)
    except (KeyError, ValueError) as error:
        raise _unreadable(folder, error) from None


def _unreadable(folder: Path, error: Exception) -> SceneError:
    return SceneError("file", f"{folder / CHECKPOINT} is not a readable inversion checkpoint: {str(error)[:120]}")


# Training loop.


_CHECKPOINT_INTERVAL = 10.0  # seconds


@dataclass(frozen=True, slots=True)
class InversionProgress:
    """Progress of a run: ``done`` of ``steps`` steps, and the ``loss`` of the last one."""

    done: int
    steps: int
    loss: float

    @property
    def share(self) -> float:
        """Completed fraction of the run, 0 to 1."""
        return self.done / self.steps

    def __str__(self) -> str:
        return f"step {self.done:,}/{self.steps:,}  loss {self.loss:.4g}"


@dataclass(frozen=True, slots=True)
class InversionOutcome:
    """Mean loss ``before`` and ``after`` the run, and whether all steps are ``finished``."""

    before: float
    after: float
    finished: bool


def run(
    trainer: InversionTrainer,
    folder: Path,
    config: Mapping[str, Any],
    saved: SavedInversion | None = None,
    on_step: Callable[[InversionProgress], None] = lambda _: None,
    stop: Callable[[], bool] = lambda: False,
) -> InversionOutcome:
    """Run the remaining steps, and save checkpoints in ``folder``.

    Parameters
    ----------
    trainer : InversionTrainer
        Trainer in its initial state.
    folder : Path
        Run folder; a checkpoint is written every ten seconds and at the end.
    config : mapping
        Configuration of the run.
    saved : SavedInversion, optional
        Checkpoint from which to resume.
    on_step : callable
        Called after each step.
    stop : callable
        Called before each step; the run ends if it returns True.

    Raises
    ------
    SceneError
        Errors of ``restore``, and "file" if a checkpoint cannot be written.
    """
    if saved is not None:
        restore(trainer, saved, config, folder)
    initial_loss = trainer.mean_loss() if saved is None else saved.initial_loss
    losses = [] if saved is None else list(saved.losses)
    last = time.monotonic()
    while trainer.done < trainer.steps and not stop():
        losses.append(trainer.step())
        on_step(InversionProgress(trainer.done, trainer.steps, losses[-1]))
        if time.monotonic() - last > _CHECKPOINT_INTERVAL:
            save_checkpoint(folder, trainer, config, losses, initial_loss)
            last = time.monotonic()
    save_checkpoint(folder, trainer, config, losses, initial_loss)
    finished = trainer.done >= trainer.steps
    after = trainer.mean_loss() if finished else losses[-1] if losses else initial_loss
    return InversionOutcome(initial_loss, after, finished)
