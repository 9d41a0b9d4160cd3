"""Pseudo-words learned step by step; only their vectors move."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.files import written_whole
from scenelang.backends.neural.clip import ClipModel, Prompt, Slot, TextEncoder, encode_images, parse_prompt, with_texts
from scenelang.backends.neural.describing import has_meaning, thing
from scenelang.backends.neural.diffusion import Diffusion, Words, memory_told
from scenelang.backends.neural.sentences import written
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.settings import setting, whole
from scenelang.interpreter.scene.entity import Scene, primitive_count
from scenelang.interpreter.scene.numbering import Ancestry, ancestry_of, frame_numbers, instance_handles, number_scene

if TYPE_CHECKING:
    from torch import Tensor


# A pseudo-word for a picture: the token vector with which a sentence comes nearest to the picture in Z_CLIP.
#
# A picture's own embedding lies where sentences end, not where their tokens begin, so it cannot stand in a sentence.
# The
# vector is looked for that makes the sentence's embedding point the way of the picture's.


SENTENCE = "a photo of <picture>"
START = "object"
STEPS = 300
_RATE = 1e-2


@dataclass(frozen=True, slots=True, eq=False)
class PictureWord:
    """``vectors`` (1, width), and the cosine of the sentence to the picture with them and at the start."""

    vectors: npt.NDArray[np.float32]
    cosine: float
    before: float


def picture_word(model: ClipModel, picture: Any, start: str = START, steps: int = STEPS) -> PictureWord:
    """The pseudo-word of a PIL picture, begun at the mean of the tokens of ``start``; the best of all ``steps``, so
    never worse than the start. The same every time.

    Raises SceneError("value") for a text without tokens.
    """
    torch = need("torch", INSTALL)
    encoder, prompt = TextEncoder(model), [parse_prompt(SENTENCE)]
    tokens = encoder.vectors_of(start).detach().float()
    if not len(tokens):
        raise SceneError("value", f'a pseudo-word cannot start from "{start}", which has no tokens')
    with memory_told():
        wanted = encode_images(model, [picture])[0].detach().float()
        vector = tokens.mean(0, keepdim=True).clone().requires_grad_(True)
        optimiser = torch.optim.Adam([vector], lr=_RATE)
        best, found, first = -2.0, vector.detach().clone(), 0.0
        for number in range(steps + 1):
            pooled = encoder.encode(prompt, {"picture": vector}).pooled[0].float()
            cosine = torch.nn.functional.cosine_similarity(pooled, wanted, dim=0)
            now = float(cosine.detach())
            first = now if number == 0 else first
            if now > best:
                best, found = now, vector.detach().clone()
            if number < steps:
                optimiser.zero_grad()
                (-cosine).backward()
                optimiser.step()
    return PictureWord(found.cpu().numpy().astype(np.float32), best, first)


# Blocks of Minecraft by meaning: the name that says most nearly what an unknown one does (the paper, appendix
# "Minecraft Renderer").


# How well a diffusion model takes a sentence for a picture: the loss that it was trained with.


def denoising_loss(model: Diffusion, latents: Tensor, states: Tensor, steps: Tensor, noise: Tensor) -> Tensor:
    """The mean square between what the network says of noisy ``latents`` (B, C, h, w) after ``steps`` (B,), told
    ``states`` (B, T, D), and what it was trained to say, which is ``noise`` itself for most models.

    Every row is denoised alone and without a camera: MVDream's mode for single pictures.
    """
    functional = need("torch.nn.functional", INSTALL)
    noisy = model.schedule.noised(latents, noise, steps)
    output = model.predict(noisy, steps, states)
    return functional.mse_loss(output, model.schedule.target(latents, noise, steps))  # type: ignore[no-any-return]


# What an inversion may be asked for.


_MOST_STEPS = 100_000
_LARGEST_BATCH = 256


@dataclass(frozen=True, slots=True)
class InversionSettings:
    """Numbers of Textual Inversion; steps and learning rate are the paper's.

    Parameters
    ----------
    steps : int
        Steps of AdamW.
    rate : float
        The learning rate, above 0 and at most 1.
    batch : int
        Noisy copies of each picture in a step.
    seed : int
        Of the noise.
    draws : int
        Noisy copies, the same every time, that measure the loss before and after.

    Raises
    ------
    SceneError
        A number out of its range.

    Examples
    --------
    >>> InversionSettings(steps=200).rate
    0.01
    """

    steps: int = setting(100, "of each run (100)", metavar="N", read=whole)
    rate: float = setting(1e-2, "how far a step goes (0.01)", metavar="X", read=float)
    batch: int = setting(4, "noisy copies of a picture in a step (4)", metavar="N", read=whole)
    seed: int = 0
    draws: int = 16

    def __post_init__(self) -> None:
        """Raises SceneError("value")."""
        if not 1 <= self.steps <= _MOST_STEPS:
            raise SceneError("value", f"an inversion has 1 to {_MOST_STEPS:,} steps")
        if not 0.0 < self.rate <= 1.0:
            raise SceneError("value", "the rate is above 0, and at most 1")
        if not 1 <= self.batch <= _LARGEST_BATCH:
            raise SceneError("value", f"a step takes 1 to {_LARGEST_BATCH} noisy copies of a picture")


# What pictures show, as sentences with the pseudo-words that are to be learned.


TEMPLATE = "<class>, 3d model, in the style of <style>"  # the paper's
STYLE = "style"  # the pseudo-word that all pictures of an inversion share


@dataclass(frozen=True, slots=True, eq=False)
class LearnedSubject:
    """``picture`` (3, H, W), sRGB in [0, 1], is what ``prompt`` says; H and W are those of the model's pictures."""

    picture: Tensor
    prompt: Prompt


def sentence_of(name: str) -> Prompt:
    """The template with the pseudo-word ``name`` for the class."""
    return tuple(Slot(name) if piece == Slot("class") else piece for piece in parse_prompt(TEMPLATE))


def sentence_about(word: str) -> Prompt:
    """The template with ``word`` written out for the class, so that the style alone is left to learn."""
    return with_texts(parse_prompt(TEMPLATE), lambda name: word if name == "class" else None)


def start_of(words: Words, text: str) -> Tensor:
    """The vector (1, width) that a pseudo-word starts from: that of the word ``text``, of several tokens their mean.

    Raises SceneError("value") for a text without tokens.
    """
    vectors = words.vectors_of(text).detach()
    if not len(vectors):
        raise SceneError("value", f'a pseudo-word cannot start from "{text}", which has no tokens')
    return vectors.float().mean(0, keepdim=True)


_MOMENTS = ("exp_avg", "exp_avg_sq")  # AdamW's own names
_MEASURING = 1 << 40  # away from the numbers of steps, so that what is measured is not what is learned from


class Inverting:
    """Vectors (1, width) by the names of pseudo-words, which begin at ``starts`` and meet the pictures of all
    ``subjects`` together, each under its own sentence.

    The noise of a step depends on the seed and the step's number alone, so that a run that was broken off and restored
    goes on as if it had not been.
    """

    def __init__(
        self,
        model: Diffusion,
        subjects: Sequence[LearnedSubject],
        starts: Mapping[str, Tensor],
        settings: InversionSettings,
    ) -> None:
        self._torch = torch = need("torch", INSTALL)
        self._model, self._subjects, self._settings = model, tuple(subjects), settings
        self._device = model.network.device
        with torch.no_grad():
            pictures = [subject.picture[None].to(self._device) for subject in subjects]
            self._latents = [model.pixels.encode(picture) for picture in pictures]
        self._vectors = {name: start.detach().clone().to(self._device) for name, start in starts.items()}
        for vector in self._vectors.values():
            vector.requires_grad_(True)
        self._optimiser = torch.optim.AdamW(list(self._vectors.values()), lr=settings.rate)
        self.done = 0

    @property
    def steps(self) -> int:
        return self._settings.steps

    def step(self) -> float:
        """One step of all subjects; returns the mean of their losses before it."""
        generator = self._generator(self.done)
        self._optimiser.zero_grad()
        total = 0.0
        for number in range(len(self._subjects)):  # one after the other, since each holds a network's activations
            loss = self._loss(number, *self._drawn(number, self._settings.batch, generator)) / len(self._subjects)
            loss.backward()  # type: ignore[no-untyped-call]
            total += float(loss.detach())
        self._optimiser.step()
        self.done += 1
        return total

    def measured(self) -> float:
        """The mean loss with the same steps and noise at every call, those evenly over the schedule."""
        generator, draws = self._generator(_MEASURING), self._settings.draws
        steps = (self._torch.arange(draws) + 0.5) / draws * self._model.schedule.steps
        total = 0.0
        with self._torch.no_grad():
            for number, latents in enumerate(self._latents):
                for step in steps.long():
                    noise = self._torch.randn(latents.shape, generator=generator).to(self._device)
                    total += float(self._loss(number, step[None].to(self._device), noise))
        return total / (draws * len(self._subjects))

    def vectors(self) -> dict[str, npt.NDArray[np.float32]]:
        """The vectors as they are now, by name."""
        return {name: vector.detach().float().cpu().numpy().copy() for name, vector in self._vectors.items()}

    def _generator(self, number: int) -> Any:
        mixed = np.random.SeedSequence([self._settings.seed % (1 << 64), number]).generate_state(1, np.uint64)[0]
        return self._torch.Generator().manual_seed(int(mixed) >> 1)

    def _drawn(self, number: int, count: int, generator: Any) -> tuple[Tensor, Tensor]:
        """Random steps and noise, the same on every device."""
        torch, shape = self._torch, self._latents[number].shape[1:]
        steps = torch.randint(0, self._model.schedule.steps, (count,), generator=generator)
        noise = torch.randn((count, *shape), generator=generator)
        return steps.to(self._device), noise.to(self._device)

    def _loss(self, number: int, steps: Tensor, noise: Tensor) -> Tensor:
        states = self._model.words.encode([self._subjects[number].prompt], self._vectors)
        count = len(steps)
        latents = self._latents[number].expand(count, -1, -1, -1)
        return denoising_loss(self._model, latents, states.expand(count, -1, -1), steps, noise)

    # --- breaks ------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Tensor]:
        """All that a later run needs to go on, beside the number of steps ``done``."""
        found = {}
        for name, vector in self._vectors.items():
            found[f"vector/{name}"] = vector.detach().cpu().clone()
            for moment in _MOMENTS if self.done else ():
                found[f"{moment}/{name}"] = self._optimiser.state[vector][moment].detach().cpu().clone()
        return found

    def restore(self, state: Mapping[str, Tensor], done: int) -> None:
        """Go on from ``state`` after ``done`` steps; raises KeyError or ValueError for that of other pseudo-words."""
        with self._torch.no_grad():
            for name, vector in self._vectors.items():
                if state[f"vector/{name}"].shape != vector.shape:
                    raise ValueError(f"the vector of {name} has another shape")
                vector.copy_(state[f"vector/{name}"])
                if done:
                    moments = {moment: state[f"{moment}/{name}"].to(self._device) for moment in _MOMENTS}
                    if any(moment.shape != vector.shape for moment in moments.values()):
                        raise ValueError(f"the moments of {name} have another shape")
                    self._optimiser.state[vector] = {"step": self._torch.tensor(float(done)), **moments}
        self.done = done


# Entities of a scene whose embeddings are to be learned: those that a user names, or all that have a name.


MOST = 100_000  # primitives of all frames
_MOST_HANDLES = 2_000  # of one word: each has a vector of its own in Z
_MOST_WORDS = 50  # learned together: a step takes each of them


@dataclass(frozen=True, slots=True)
class InversionTarget:
    """``handles`` of entities that one picture shows, and ``text``, what they are in words. ``whole``: the root is
    among them, whose embedding is the style of the scene."""

    text: str
    handles: tuple[str, ...]
    whole: bool

    @property
    def name(self) -> str:
        """The first handle, which stands for all."""
        return self.handles[0]


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    ancestry: Ancestry
    handles: list[str]


def targets_named(scene: Scene, names: Sequence[str]) -> list[InversionTarget]:
    """The target of each name: a handle `<z4>`, a word, or words down to entities with
    slashes between, `tower/roof`, or places of children from the root, `0/2`.

    Raises SceneError("value") for a name that no entity has, LimitError for too large scenes.
    """
    frames = _frames(scene)
    return [_named(frames, name) for name in dict.fromkeys(names)]


def named_parts(scene: Scene) -> list[InversionTarget]:
    """One target for each word that says what primitives are: their own, else that of the nearest thing around them.

    The root is left out. Raises SceneError("value") where nothing is left, LimitError for too large scenes.
    """
    found: dict[str, list[tuple[_Frame, int]]] = {}
    for frame in _frames(scene):
        for primitive in frame.ancestry.primitives.tolist():
            chain = [i for i in _upward(frame.ancestry, primitive) if i]
            named = next((i for i in chain if has_meaning(frame.ancestry.entity(i).word)), chain[0] if chain else None)
            if named is not None:
                found.setdefault(frame.ancestry.entity(named).word, []).append((frame, named))
    if not found:
        raise SceneError("value", f'the scene "{scene.word}" has no parts whose embeddings could be learned')
    if len(found) > _MOST_WORDS:
        hint = "name some of them with --entity"
        raise LimitError("entities", f"the scene has {len(found):,} words, more than {_MOST_WORDS}", hint=hint)
    return [_target(instances) for instances in found.values()]


def style_handle(scene: Scene) -> str:
    """The handle of the root, which is the style of the scene."""
    return number_scene(scene).handle(scene.root, 0)


def _frames(scene: Scene) -> list[_Frame]:
    if sum(map(primitive_count, scene.frames)) > MOST:
        raise LimitError("primitives", f"the scene has more than the {MOST:,} primitives that can be distinguished")
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    ancestries = [ancestry_of(root) for root in scene.frames]
    return [_Frame(each, instance_handles(scene, each, numbers)) for each in ancestries]


def _named(frames: Sequence[_Frame], name: str) -> InversionTarget:
    if name.startswith("<"):
        found = [(f, i) for f in frames for i, handle in enumerate(f.handles) if f"<{handle}>" == name]
    else:
        found = [(f, i) for f in frames for i in _of_word(f.ancestry, name)]
        found = found or [(f, i) for f in frames for i in _at_path(f.ancestry, name)]
    if not found:
        called = f"handle {name}" if name.startswith("<") else f'word "{name}"'
        raise SceneError("value", f"no entity of the scene that is to be seen has the {called}")
    return _target(found)


def _of_word(ancestry: Ancestry, word: str) -> list[int]:
    return [i for i in range(len(ancestry)) if ancestry.entity(i).word == word]


def _at_path(ancestry: Ancestry, path: str) -> Iterator[int]:
    """The instance at places of children from the root, `0/2`; else those whose words, and those above, end in
    ``path``."""
    if all(part.isdecimal() for part in path.split("/")):
        places = tuple(map(int, path.split("/")))
        yield from (i for i in range(len(ancestry)) if ancestry.depth[i] == len(places) and ancestry.path(i) == places)
        return
    words = [word for word in path.split("/") if word][::-1]
    for i in _of_word(ancestry, words[0]) if words else ():
        above = [ancestry.entity(k).word for k in _upward(ancestry, i)]
        if above[: len(words)] == words:
            yield i


def _upward(ancestry: Ancestry, instance: int) -> Iterator[int]:
    """An instance and those around it, the root last."""
    while instance >= 0:
        yield instance
        instance = int(ancestry.parent[instance])


def _target(instances: Sequence[tuple[_Frame, int]]) -> InversionTarget:
    handles = tuple(dict.fromkeys(frame.handles[i] for frame, i in instances))
    frame, first = instances[0]
    entity = frame.ancestry.entity(first)
    if len(handles) > _MOST_HANDLES:
        message = f'"{entity.word}" has {len(handles):,} embeddings, more than {_MOST_HANDLES:,} that are stored alike'
        raise LimitError(
            "entities", message, hint="name an entity around them, whose embedding applies to everything in it"
        )
    return InversionTarget(thing(entity), handles, any(i == 0 for _, i in instances))


# An inversion as a file, so that it goes on after a break: `inversion.safetensors` in its folder, written whole or
# not at all.


STATE = "inversion.safetensors"
VERSION = 1
_ENTRY = "scenelang-inversion"
_AGAIN = "use --force to start over"


@dataclass(frozen=True, slots=True, eq=False)
class SavedInversion:
    """What a run's file holds: ``tensors`` after ``done`` steps, what was ``asked`` (JSON data), the loss of each step,
    and the loss measured at the start."""

    tensors: Mapping[str, Tensor]
    done: int
    asked: Mapping[str, Any]
    losses: tuple[float, ...]
    first: float

    @property
    def finished(self) -> bool:
        return self.done >= int(self.asked["steps"])


def asked_of(
    settings: InversionSettings, model: str, subjects: Sequence[LearnedSubject], starts: Mapping[str, str]
) -> dict[str, Any]:
    """What must be the same for a run to go on; more steps may be asked for. ``starts`` are the words by name."""
    shown = [
        [written(subject.prompt), hashlib.sha256(subject.picture.cpu().numpy().tobytes()).hexdigest()]
        for subject in subjects
    ]
    return {**asdict(settings), "model": model, "pictures": shown, "words": dict(starts)}


def keep(folder: Path, learning: Inverting, asked: Mapping[str, Any], losses: Sequence[float], first: float) -> None:
    """Write a run's file; raises SceneError("file")."""
    save = need("safetensors.torch", INSTALL).save
    told = {"version": VERSION, "done": learning.done, "asked": asked, "losses": list(losses), "first": first}
    data = save(learning.state(), metadata={_ENTRY: json.dumps(told)})
    with written_whole(folder / STATE) as temporary:
        temporary.write_bytes(data)


def kept_in(folder: Path) -> SavedInversion:
    """The run in ``folder``; raises SceneError("file") where there is none, or none that can be read."""
    safetensors = need("safetensors", INSTALL)
    try:
        with safetensors.safe_open(str(folder / STATE), framework="pt") as file:
            told = json.loads((file.metadata() or {})[_ENTRY])
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        if told["version"] != VERSION:
            raise ValueError(f"its version is {str(told['version'])[:20]}; this program knows {VERSION}")
        kept = SavedInversion(
            tensors, int(told["done"]), dict(told["asked"]), tuple(map(float, told["losses"])), float(told["first"])
        )
        if not 0 <= kept.done == len(kept.losses) or int(kept.asked["steps"]) < 1:
            raise ValueError("its steps are not those of its losses")
        return kept
    except FileNotFoundError:
        raise SceneError("file", f"no inversion in {folder}") from None
    except (safetensors.SafetensorError, OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise _unreadable(folder, error) from None


def restore(learning: Inverting, kept: SavedInversion, asked: Mapping[str, Any], folder: Path) -> None:
    """Have ``learning`` go on from ``kept``; raises SceneError: "value" for a run that was asked for something else,
    "file" for tensors that are not those of its vectors."""
    mine = json.loads(json.dumps(dict(asked)))
    different = sorted(name for name in mine if name != "steps" and kept.asked.get(name) != mine[name])
    if different:
        raise SceneError("value", f"the inversion in {folder} had other {', '.join(different)}", hint=_AGAIN)
    if kept.done > learning.steps:
        message = f"the inversion in {folder} has made {kept.done} steps already, more than {learning.steps}"
        raise SceneError("value", message, hint=_AGAIN)
    try:
        learning.restore(kept.tensors, kept.done)
    except (KeyError, ValueError) as error:
        raise _unreadable(folder, error) from None


def _unreadable(folder: Path, error: Exception) -> SceneError:
    return SceneError("file", f"{folder / STATE} is not a readable inversion checkpoint: {str(error)[:120]}")


# An inversion from its beginning or a break to its end: steps, a file now and then, a stop when it is asked for.


_PAUSE = 10.0  # seconds between two files


@dataclass(frozen=True, slots=True)
class InversionProgress:
    """Where a run stands: steps ``done`` of ``steps``, and the loss of the last."""

    done: int
    steps: int
    loss: float

    @property
    def share(self) -> float:
        """How much of the run is done, 0 to 1."""
        return self.done / self.steps

    def __str__(self) -> str:
        return f"step {self.done:,}/{self.steps:,}  loss {self.loss:.4g}"


@dataclass(frozen=True, slots=True)
class InversionOutcome:
    """The loss measured before the first step and now, and whether all steps are made."""

    before: float
    after: float
    finished: bool


def run(
    learning: Inverting,
    folder: Path,
    asked: Mapping[str, Any],
    kept: SavedInversion | None = None,
    tell: Callable[[InversionProgress], None] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
) -> InversionOutcome:
    """Make the steps that are left, from ``kept`` on where that is given, and keep the run in ``folder``.

    The file is written every ten seconds, at the end and where ``stopped`` says so: a kill loses no more. Raises
    SceneError as ``keeping.restore`` does, and "file".
    """
    if kept is not None:
        restore(learning, kept, asked, folder)
    first = learning.measured() if kept is None else kept.first
    losses = [] if kept is None else list(kept.losses)
    last = time.monotonic()
    while learning.done < learning.steps and not stopped():
        losses.append(learning.step())
        tell(InversionProgress(learning.done, learning.steps, losses[-1]))
        if time.monotonic() - last > _PAUSE:
            keep(folder, learning, asked, losses, first)
            last = time.monotonic()
    keep(folder, learning, asked, losses, first)
    finished = learning.done >= learning.steps
    return InversionOutcome(first, learning.measured() if finished else losses[-1] if losses else first, finished)
