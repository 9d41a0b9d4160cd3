"""Textual Inversion: learn token embeddings of entities, or the style of a scene, from images.

The method is described in docs/inversion.md (Gal et al., "An Image is Worth One Word", 2022).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.base import Progress, require
from scenelang.backends.neural.weights import INSTALL, Models
from scenelang.files import zfile
from scenelang.grammar.datum import dataclass, field
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import setting, typed
from scenelang.learning.embeddings import Embeddings
from scenelang.session.loaded import LoadedScene

if TYPE_CHECKING:
    from scenelang.backends.neural.grounding import Bytes
    from scenelang.backends.neural.inversion import (
        InversionOutcome,
        InversionProgress,
        InversionSettings,
        InversionTarget,
        LearnedSubject,
        SavedInversion,
    )

PictureSource = Any  # a path or a PIL image
_RESUME_HINT = "use --resume to continue it, or --force to overwrite it"


# --- settings --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class RunFolder:
    """Run folder of an optimization, and how to treat an existing run in it.

    Parameters
    ----------
    folder : path, optional
        Created if it does not exist; None: beside the program.
    resume : bool
        Resume the run in the folder.
    force : bool
        Overwrite an existing run or existing embeddings.
    start : path, optional
        Folder of an earlier run from which ``distill`` reuses all unchanged objects.

    Raises
    ------
    SceneError
        If ``resume`` is combined with ``force`` or ``start``.

    Examples
    --------
    >>> RunFolder("run", resume=True)
    RunFolder(folder='run', resume=True, force=False, start=None)
    """

    folder: str | Path | None = setting(
        None, "run folder (default: beside the program)", "-o", "--output", metavar="DIR"
    )
    resume: bool = setting(False, "resume the run in the folder")
    force: bool = setting(False, "overwrite an existing run")
    start: str | Path | None = setting(None, "earlier run from which to reuse unchanged objects", metavar="DIR")

    def __post_init__(self) -> None:
        """Raise SceneError for exclusive options."""
        if self.resume and self.force:
            raise SceneError("value", "`--resume` cannot be combined with `--force`")
        if self.resume and self.start is not None:
            raise SceneError("value", "`--start` cannot be combined with `--resume`")

    def path(self, scene: LoadedScene, ending: str) -> Path:
        """Return the run folder; the default is the program's path with the suffix ``ending``. Raises SceneError."""
        if self.folder is not None:
            return Path(self.folder)
        if scene.name.startswith("<"):
            raise SceneError("value", "expected a run folder, since the scene has no file")
        return Path(scene.name).with_suffix(ending)


@dataclass(frozen=True, slots=True)
class PictureSubject:
    """Region of an image to learn from, and the words that initialize the learned embeddings.

    Parameters
    ----------
    text : str, optional
        Description of the object to detect in the image; default: the entity's word.
    mask : path, optional
        Mask image of the same size, white where the object is.
    whole : bool
        Use the whole image, without segmentation.
    class_word : str, optional
        Class word that initializes the embedding; default: the entity's word.
    style_word : str
        Word that initializes the style embedding.

    Raises
    ------
    SceneError
        If arguments are mutually exclusive, or a word is empty.

    Examples
    --------
    >>> PictureSubject(whole=True, style_word="painting").style_word
    'painting'
    """

    text: str | None = setting(None, "description of the object to detect in the image", metavar="TEXT")
    mask: str | Path | None = setting(None, "mask image of the same size, white where the object is", metavar="FILE")
    whole: bool = setting(False, "use the whole image, without segmentation", "--no-segment")
    class_word: str | None = setting(None, "class word (default: the entity's word)", metavar="TEXT")
    style_word: str = setting("photo", "word that initializes the style embedding (default photo)", metavar="TEXT")

    def __post_init__(self) -> None:
        """Raise SceneError for exclusive options and empty words."""
        if self.whole and (self.text or self.mask):
            raise SceneError("value", "`--no-segment` cannot be combined with `--text` or `--mask`")
        if self.text and self.mask:
            message = "`--mask` cannot be combined with `--text`"
            raise SceneError("value", message)
        for option, word in (("class-word", self.class_word), ("style-word", self.style_word)):
            if word is not None and not word.strip():
                raise SceneError("value", f"expected a word for `--{option}`, got an empty text")

    @typed
    def check_single(self, entities: Sequence[str]) -> None:
        """Check that options about a single entity are used with exactly one; raises SceneError("value")."""
        options = {"text": self.text, "mask": self.mask, "class-word": self.class_word, "no-segment": self.whole}
        single = next((option for option, value in options.items() if value), None)
        if single is not None and len(entities) != 1:
            raise SceneError("value", f"`--{single}` requires exactly one --entity")


@dataclass(frozen=True, slots=True)
class InversionModels:
    """Neural networks used for inversion, each by name or as a folder.

    Parameters
    ----------
    model : str, optional
        Diffusion model; default ``MVDream/MVDream``.
    detector : str, optional
        Open-vocabulary object detector; default ``IDEA-Research/grounding-dino-base``.
    segmenter : str, optional
        Segmentation model; default ``facebook/sam-vit-huge``.

    Examples
    --------
    >>> InversionModels(model="stabilityai/stable-diffusion-2-1-base").detector is None
    True
    """

    model: str | None = setting(None, "diffusion model (default MVDream/MVDream), or a folder", metavar="NAME")
    detector: str | None = setting(
        None, "object detector (default IDEA-Research/grounding-dino-base), or a folder", metavar="NAME"
    )
    segmenter: str | None = setting(
        None, "segmentation model (default facebook/sam-vit-huge), or a folder", metavar="NAME"
    )


def check_installed() -> None:
    """Check that the packages for inversion are installed; raises SceneError("backend") otherwise."""
    for package in ("torch", "diffusers", "transformers"):
        require(package, INSTALL)


# --- results ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class LearnedPart:
    """A learned entity: its description ``text``, and the ``handles`` that share its token embedding."""

    text: str
    handles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InversionStart:
    """Summary of a run before it starts: the ``parts`` to learn, and the texts of those not found in any image."""

    parts: tuple[LearnedPart, ...]
    missing: tuple[str, ...]
    folder: Path

    def __str__(self) -> str:
        """Return a line that lists the missing parts; empty if there are none."""
        named = ", ".join(f'"{text}"' for text in self.missing)
        return f"not found in the image and left unchanged: {named}" if named else ""


@dataclass(frozen=True, slots=True, repr=False)
class Inversion:
    """Result of an inversion run.

    Attributes
    ----------
    embeddings : Embeddings
        File with the token embeddings; written when the run is ``finished``.
    folder : Path
        Run folder, with the state and the cropped images.
    parts : tuple of LearnedPart
        Entities that were learned.
    styles : tuple of str
        Handles that have the style embedding.
    missing : tuple of str
        Descriptions of entities not found in any image, which are unchanged.
    before, after : float
        Denoising loss before and after, measured with the same noise.
    finished : bool
        False if ``stop`` ended the run; resume it with ``RunFolder(resume=True)``.
    """

    embeddings: Embeddings
    folder: Path
    parts: tuple[LearnedPart, ...]
    styles: tuple[str, ...]
    missing: tuple[str, ...]
    before: float
    after: float
    finished: bool

    @property
    def handles(self) -> tuple[str, ...]:
        """Handles that have learned embeddings, without duplicates."""
        return tuple(dict.fromkeys([*(handle for part in self.parts for handle in part.handles), *self.styles]))

    def data(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        parts = [{"text": part.text, "handles": list(part.handles)} for part in self.parts]
        loss = {"before": self.before, "after": self.after}
        return {"z": str(self.embeddings.path), "loss": loss, "style": list(self.styles), "parts": parts}

    def __str__(self) -> str:
        """Return the handles and the change of the loss."""
        learned = [handle for part in self.parts for handle in part.handles]
        shown = " ".join(f"<{handle}>" for handle in dict.fromkeys([*learned[:8], *self.styles[:8]]))
        return f"{shown}; loss {self.before:.4g} -> {self.after:.4g}"

    def __repr__(self) -> str:
        return f"<Inversion of {self}{'' if self.finished else ', stopped'}>"


# --- invert, learn_style ---------------------------------------------------------------------------------------------


@typed
def invert(
    scene: LoadedScene,
    pictures: PictureSource,
    *,
    entities: Sequence[str] = (),
    subject: PictureSubject | None = None,
    settings: InversionSettings | None = None,
    networks: InversionModels | None = None,
    run: RunFolder | None = None,
    embeddings: Embeddings | str | Path | None = "auto",
    models: Models | None = None,
    missing_ok: bool = False,
    progress: Progress | None = None,
    on_start: Callable[[InversionStart], None] | None = None,
    on_step: Callable[[InversionProgress], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Inversion:
    """Learn token embeddings of entities from images, and store them in the embeddings file.

    Parameters
    ----------
    scene : LoadedScene
        Scene that contains the entities.
    pictures : path or PIL image, or a sequence of them
        Input images; each entity is learned from the image with the most confident detection.
    entities : sequence of str
        Words, paths of words (``tower/roof``) or of child indices (``0/2``), or handles (``<z4>``); default: all
        named parts that are visible.
    subject : PictureSubject, optional
        Region of the image that shows the entity, and its class word.
    settings : InversionSettings, optional
        Steps, learning rate, batch size and seed.
    networks : InversionModels, optional
        Networks to use.
    run : RunFolder, optional
        Run folder and resume policy; default folder ``beach.inversion`` for ``beach.scene``.
    embeddings : Embeddings or path, optional
        Embeddings file to write; "auto": beside the program.
    models : Models, optional
        Location of the weights, and compute device.
    missing_ok : bool
        Do not raise an error if no entity is found in the images.
    progress : callable, optional
        Called with a fraction from 0 to 1; an exception raised by it cancels the run.
    on_start, on_step : callable, optional
        Called with the summary before the first step, and with the loss after each step.
    stop : callable, optional
        Called before each step; if it returns True, the run is saved and ends, and can be resumed later.

    Raises
    ------
    SceneError
        If an entity does not exist or is not found in an image, a file cannot be read, weights are unavailable, or
        arguments are invalid.

    Examples
    --------
    >>> invert(scene, "photo.png", entities=["moai"], models=Models("weights"))  # doctest: +SKIP
    <Inversion of <z2> <z1>; loss 0.1203 -> 0.1094>
    """
    from scenelang.backends.neural.inversion import style_handle

    subject = subject or PictureSubject()
    subject.check_single(entities)
    place = _place(scene, run, embeddings, ".inversion")
    work = _work(scene, place, subject, settings, networks, models)
    targets = _targets(scene, entities)
    before = _before(work)
    missing: list[str] = []
    if before is not None:
        parts = _load_parts(work, before, targets)
    else:
        parts, missing = _parts(work, _opened(pictures), targets, named=bool(entities), missing_ok=missing_ok)
    learned = tuple(LearnedPart(part.target.text, part.target.handles) for part in parts)
    if on_start is not None:
        on_start(InversionStart(learned, tuple(missing), work.folder))
    if not parts:
        return Inversion(work.z, work.folder, (), (), tuple(missing), float("nan"), float("nan"), True)
    styles = (style_handle(scene.graph),)
    outcome = _learn(work, before, parts, styles, _step_callback(progress, on_step), stop, style_only=False)
    return Inversion(
        work.z, work.folder, learned, styles, tuple(missing), outcome.before, outcome.after, outcome.finished
    )


@typed
def learn_style(
    scene: LoadedScene,
    picture: PictureSource,
    *,
    entity: str | None = None,
    subject: PictureSubject | None = None,
    settings: InversionSettings | None = None,
    networks: InversionModels | None = None,
    run: RunFolder | None = None,
    embeddings: Embeddings | str | Path | None = "auto",
    models: Models | None = None,
    progress: Progress | None = None,
    on_start: Callable[[InversionStart], None] | None = None,
    on_step: Callable[[InversionProgress], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Inversion:
    """Learn a style embedding from an image, for a scene or a part of it, and store it in the embeddings file.

    Parameters
    ----------
    scene : LoadedScene
        Scene that gets the style.
    picture : path or PIL image
        Image with the style; ``subject`` restricts it to a region.
    entity : str, optional
        Part of the scene, specified as in ``invert``; default: the whole scene.
    run : RunFolder, optional
        Run folder, default ``beach.style``; ``force`` also allows a style to replace embeddings learned by ``invert``.

    The other parameters are those of ``invert``.

    Raises
    ------
    SceneError
        As ``invert``; also if embeddings learned by ``invert`` would be overwritten.

    Examples
    --------
    >>> learn_style(scene, "painting.png", models=Models("weights"))  # doctest: +SKIP
    <Inversion of <z1>; loss 0.1311 -> 0.1287>
    """
    subject = subject or PictureSubject()
    place = _place(scene, run, embeddings, ".style")
    work = _work(scene, place, subject, settings, networks, models)
    target = _styled(scene, entity)
    _check_replaced(work, target.handles)
    before = _before(work)
    if before is not None:
        parts = _load_parts(work, before, [target])
    else:
        inputs = _opened(picture)
        detected = _found_parts(work, [target], [subject.text], inputs) if subject.text else None
        parts = [_masked_part(work, target, inputs[0])] if detected is None else detected
        if not parts:
            raise SceneError("value", f'no "{subject.text}" detected in {inputs[0].name}')
    if on_start is not None:
        on_start(InversionStart((LearnedPart(target.text, target.handles),), (), work.folder))
    outcome = _learn(work, before, parts, target.handles, _step_callback(progress, on_step), stop, style_only=True)
    return Inversion(work.z, work.folder, (), target.handles, (), outcome.before, outcome.after, outcome.finished)


# --- shared by invert and learn_style --------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Place:
    """Where an inversion writes: its run folder with the policy for existing files, and the embeddings file."""

    run: RunFolder
    folder: Path
    z: Embeddings


@dataclass(frozen=True, slots=True)
class _Work:
    """Validated inputs of an inversion."""

    place: _Place
    subject: PictureSubject
    settings: InversionSettings
    networks: InversionModels
    models: Models

    @property
    def run(self) -> RunFolder:
        """Policy for existing files."""
        return self.place.run

    @property
    def folder(self) -> Path:
        """Run folder."""
        return self.place.folder

    @property
    def z(self) -> Embeddings:
        """Embeddings file."""
        return self.place.z


@dataclass(frozen=True, slots=True)
class _Input:
    """An RGB PIL image with its name."""

    name: str
    picture: Any = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Training image of one target: ``square`` (S, S, 3) is cropped from the image named ``source``."""

    target: InversionTarget
    source: str
    square: Bytes = field(repr=False)


def _place(
    scene: LoadedScene, run: RunFolder | None, embeddings: Embeddings | str | Path | None, ending: str
) -> _Place:
    """Return where an inversion writes; raises SceneError for a scene without a file."""
    run = run or RunFolder()
    place = _Place(run, run.path(scene, ending), Embeddings.of(scene, embeddings))
    place.z.place()
    return place


def _work(
    scene: LoadedScene,
    place: _Place,
    subject: PictureSubject,
    settings: InversionSettings | None,
    networks: InversionModels | None,
    models: Models | None,
) -> _Work:
    """Validate the arguments of an inversion and check the installed packages; raises SceneError."""
    from scenelang.backends.base import require
    from scenelang.backends.neural.inversion import InversionSettings
    from scenelang.backends.neural.prompts import check_not_empty

    check_not_empty(scene.graph)
    for package in ("torch", "diffusers", "transformers"):
        require(package, INSTALL)
    return _Work(place, subject, settings or InversionSettings(), networks or InversionModels(), models or Models())


def _targets(scene: LoadedScene, names: Sequence[str]) -> list[InversionTarget]:
    """Return the entities to learn; raises SceneError for the root, and for entities that share an embedding."""
    from scenelang.backends.neural.inversion import named_parts, targets_named

    if not names:
        return named_parts(scene.graph)
    targets = targets_named(scene.graph, names)
    if any(target.whole for target in targets):
        hint = "use `scenelang style` to learn a style from an image"
        raise SceneError("value", "cannot invert the root: its embedding is the style of the scene", hint=hint)
    claimed = [handle for target in targets for handle in target.handles]
    if len(set(claimed)) != len(claimed):
        raise SceneError("value", "two of the entities share an embedding; name only one of them")
    return targets


def _styled(scene: LoadedScene, name: str | None) -> InversionTarget:
    """Return the entity that gets the style: the root, or the named entity."""
    from scenelang.backends.neural.descriptions import noun_of
    from scenelang.backends.neural.inversion import InversionTarget, style_handle, targets_named

    if name is None:
        return InversionTarget(noun_of(scene.root), (style_handle(scene.graph),), True)
    return targets_named(scene.graph, [name])[0]


def _check_replaced(work: _Work, handles: Sequence[str]) -> None:
    """Raise SceneError("value") if the style would overwrite embeddings learned by ``invert``."""
    provenance = work.z.made
    overwritten = next(
        (handle for handle in handles if handle in provenance and provenance[handle].how != "style"), None
    )
    if overwritten is not None and not work.run.force and not work.run.resume:
        message = f"<{overwritten}> already has an embedding, learned from {provenance[overwritten].source}"
        raise SceneError("value", message, hint="use --force to overwrite it")


def _before(work: _Work) -> SavedInversion | None:
    """Return the run to resume, or None; raises SceneError if it is missing, or would be overwritten."""
    from scenelang.backends.neural.inversion import CHECKPOINT, load_checkpoint

    if work.run.resume:
        return load_checkpoint(work.folder)
    if (work.folder / CHECKPOINT).exists() and not work.run.force and not load_checkpoint(work.folder).finished:
        raise SceneError("file", f"{work.folder} already contains an unfinished run", hint=_RESUME_HINT)
    return None


# --- images ----------------------------------------------------------------------------------------------------------


def _opened(pictures: PictureSource) -> list[_Input]:
    """Open the input images; images that are not files are named by number."""
    from scenelang.backends.pictures.film import open_image

    sources = pictures if isinstance(pictures, (list, tuple)) else [pictures]
    if not sources:
        raise SceneError("value", "expected at least one image")
    return [
        _Input(Path(source).name, open_image(source))
        if isinstance(source, (str, Path))
        else _Input(f"picture {number}", source.convert("RGB"))
        for number, source in enumerate(sources, start=1)
    ]


def _parts(
    work: _Work, inputs: Sequence[_Input], targets: Sequence[InversionTarget], *, named: bool, missing_ok: bool
) -> tuple[list[_Part], list[str]]:
    """Locate the targets in the images; return their parts, and the texts of the missing ones.

    Raises SceneError if none is detected, or an explicitly named target is missing.
    """
    if work.subject.whole or work.subject.mask:
        return [_masked_part(work, targets[0], inputs[0])], []
    texts = [work.subject.text or target.text for target in targets]
    parts = _found_parts(work, targets, texts, inputs)
    detected = [part.target for part in parts]
    missing = [text for target, text in zip(targets, texts, strict=True) if target not in detected]
    if missing and not missing_ok and (named or not parts):
        hint = "describe it with --text, or mark it with --mask"
        names = ", ".join(image.name for image in inputs)
        raise SceneError("value", f'no "{missing[0]}" detected in {names}', hint=hint)
    return parts, missing


def _masked_part(work: _Work, target: InversionTarget, image: _Input) -> _Part:
    """Return the part shown by the mask file, or by the whole image without a mask."""
    import numpy as np

    from scenelang.backends.neural.grounding import crop_masked, random_grey, read_mask

    width, height = image.picture.size
    mask = work.subject.mask
    region = read_mask(Path(mask), width, height) if mask else np.ones((height, width), np.bool_)
    return _Part(target, image.name, crop_masked(np.asarray(image.picture), region, random_grey(work.settings.seed)))


def _found_parts(
    work: _Work, targets: Sequence[InversionTarget], texts: Sequence[str], inputs: Sequence[_Input]
) -> list[_Part]:
    """Detect ``targets`` in the images by their ``texts``, and crop each from the image with the most confident
    detection."""
    from scenelang.backends.neural.grounding import (
        DETECTOR,
        SEGMENTER,
        Grounding,
        find_object,
        load_detector,
        load_segmenter,
        random_grey,
    )

    hub, device = work.models.hub(), work.models.resolve_device()
    detector = load_detector(work.networks.detector or DETECTOR, hub, device)
    segmenter = load_segmenter(work.networks.segmenter or SEGMENTER, hub, device)
    grounding, grey = Grounding(detector, segmenter), random_grey(work.settings.seed)
    parts = []
    for target, text in zip(targets, texts, strict=True):
        detection = find_object(grounding, [image.picture for image in inputs], text, grey)
        if detection is not None:
            parts.append(_Part(target, inputs[detection[0]].name, detection[1]))
    return parts


def _load_parts(work: _Work, saved: SavedInversion, targets: Sequence[InversionTarget]) -> list[_Part]:
    """Load the saved training images of a run to resume; raises SceneError("file" or "value")."""
    import numpy as np

    from scenelang.backends.pictures.film import open_image

    parts = saved.config.get("parts")
    sources = {str(name): str(source) for name, source in parts.items()} if isinstance(parts, Mapping) else {}
    saved_targets = [target for target in targets if target.name in sources]
    if len(saved_targets) != len(sources):
        raise SceneError("value", f"the run in {work.folder} is for other entities", hint="use --force to overwrite it")
    return [
        _Part(target, sources[target.name], np.asarray(open_image(_cut_file(work.folder, target.name))))
        for target in saved_targets
    ]


def _save_parts(folder: Path, parts: Sequence[_Part]) -> None:
    """Save the cropped training images, for inspection and for resuming the run."""
    from PIL import Image

    from scenelang.backends.files import atomic_write

    for part in parts:
        with atomic_write(_cut_file(folder, part.target.name)) as temporary:
            Image.fromarray(part.square).save(temporary)


def _cut_file(folder: Path, name: str) -> Path:
    """Return the file of a cropped training image."""
    return folder / f"{name.replace('*', '-')}.png"


# --- training --------------------------------------------------------------------------------------------------------


def _learn(
    work: _Work,
    before: SavedInversion | None,
    parts: Sequence[_Part],
    styles: Sequence[str],
    on_step: Callable[[InversionProgress], None],
    stop: Callable[[], bool] | None,
    *,
    style_only: bool,
) -> InversionOutcome:
    """Optimize the embeddings of ``parts`` and their common style.

    At the end, each part's embedding is stored for the handles of its target, and the style for the handles ``styles``.
    With ``style_only``, the prompt uses the plain class word instead of a learned embedding.
    """
    from scenelang.backends.files import new_folder
    from scenelang.backends.neural.diffusion import translate_out_of_memory
    from scenelang.backends.neural.diffusion_loading import MULTIVIEW_MODEL, load_any
    from scenelang.backends.neural.inversion import STYLE, InversionTrainer, initial_vector, run_config
    from scenelang.backends.neural.inversion import run as run_steps

    with new_folder(work.folder), translate_out_of_memory():
        model = load_any(work.networks.model or MULTIVIEW_MODEL, work.models.hub(), work.models.resolve_device())
        words = {} if style_only else {p.target.name: work.subject.class_word or p.target.text for p in parts}
        words[STYLE] = work.subject.style_word
        subjects = [_subject(work, part, model.size, style_only=style_only) for part in parts]
        initial = {name: initial_vector(model.text_encoder, word) for name, word in words.items()}
        config = run_config(work.settings, model.name, subjects, words)
        config["parts"] = {part.target.name: part.source for part in parts}
        _save_parts(work.folder, parts)
        trainer = InversionTrainer(model, subjects, initial, work.settings)
        outcome = run_steps(trainer, work.folder, config, before, on_step, stop or (lambda: False))
    if outcome.finished:
        _store(work.z.place(), trainer.vectors(), parts, styles, model.name, style_only=style_only)
    return outcome


def _subject(work: _Work, part: _Part, size: int, *, style_only: bool) -> LearnedSubject:
    """Return a training image with its prompt; the style alone is learned with the plain class word."""
    import torch

    from scenelang.backends.neural.grounding import resize
    from scenelang.backends.neural.inversion import LearnedSubject, entity_prompt, style_prompt

    picture = torch.tensor(resize(part.square, size)).permute(2, 0, 1).float() / 255.0
    word = work.subject.class_word or part.target.text
    return LearnedSubject(picture, style_prompt(word) if style_only else entity_prompt(part.target.name))


def _step_callback(
    progress: Progress | None, on_step: Callable[[InversionProgress], None] | None
) -> Callable[[InversionProgress], None]:
    """Combine both callbacks into one that is called after each step."""

    def report(state: InversionProgress) -> None:
        if on_step is not None:
            on_step(state)
        if progress is not None:
            progress(state.share)

    return report


def _store(
    z: Path, vectors: Mapping[str, Any], parts: Sequence[_Part], styles: Sequence[str], model: str, *, style_only: bool
) -> None:
    """Write the embeddings with their provenance to the embeddings file."""
    from scenelang.backends.neural.inversion import STYLE

    when = datetime.now(UTC).isoformat(timespec="seconds")
    arrays, provenance = {}, {}
    for part in () if style_only else parts:
        for handle in part.target.handles:
            arrays[handle] = vectors[part.target.name]
            provenance[handle] = zfile.Made("inversion", part.source, model, when)
    sources = ", ".join(dict.fromkeys(part.source for part in parts))
    for handle in styles:
        arrays[handle], provenance[handle] = vectors[STYLE], zfile.Made("style", sources, model, when)
    zfile.write_vectors(z, arrays, provenance)
