"""Embeddings learned from pictures by Textual Inversion: those of entities, and the style of a scene.

docs/inversion.md tells of the method.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang import zfile
from scenelang.backends.base import Progress, need
from scenelang.backends.neural.weights import INSTALL, Models
from scenelang.embeddings import Embeddings
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import setting
from scenelang.scene import Scene

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

PictureSource = Any  # a path, or a picture as PIL has it
_ANEW = "--resume goes on with it, --force begins anew"


# --- what may be asked for -------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class RunFolder:
    """The folder that keeps a run of an optimisation, and what is done with a run that is there.

    Parameters
    ----------
    folder : path, optional
        Made where it is not there; None: beside the program.
    resume : bool
        Go on with the run in the folder.
    force : bool
        Begin anew, and replace what would be lost.
    start : path, optional
        The folder of an earlier run: ``distill`` takes over the things that are still the same.

    Raises
    ------
    SceneError
        ``resume`` together with ``force`` or ``start``.

    Examples
    --------
    >>> RunFolder("run", resume=True)
    RunFolder(folder='run', resume=True, force=False, start=None)
    """

    folder: str | Path | None = setting(
        None, "the folder of the run (default: beside the program)", "-o", "--output", metavar="DIR"
    )
    resume: bool = setting(False, "go on with the run in the folder")
    force: bool = setting(False, "begin anew, and replace what would be lost")
    start: str | Path | None = setting(None, "take over the things of an earlier run that are the same", metavar="DIR")

    def __post_init__(self) -> None:
        if self.resume and self.force:
            raise SceneError("value", "`--resume` goes on and `--force` begins anew: choose one")
        if self.resume and self.start is not None:
            raise SceneError("value", "`--start` begins a run, and `--resume` knows what it took over: choose one")

    def path(self, scene: Scene, ending: str) -> Path:
        """The folder, for a scene whose program has it beside itself with ``ending``. Raises SceneError."""
        if self.folder is not None:
            return Path(self.folder)
        if scene.name.startswith("<"):
            raise SceneError("value", "a scene without a file has no place for a run: name a folder")
        return Path(scene.name).with_suffix(ending)


@dataclass(frozen=True, slots=True)
class PictureSubject:
    """What of a picture is learned, and the words that the learning starts from.

    Parameters
    ----------
    text : str, optional
        What to look for in the picture; default: the entity's word.
    mask : path, optional
        A picture of the same size, light where the thing is.
    whole : bool
        The whole picture is the entity.
    class_word : str, optional
        What the picture shows; default: the entity's word.
    style_word : str
        What the style starts from.

    Raises
    ------
    SceneError
        Arguments that do not belong together, or a word without letters.

    Examples
    --------
    >>> PictureSubject(whole=True, style_word="painting").style_word
    'painting'
    """

    text: str | None = setting(None, "what to look for in the picture", metavar="TEXT")
    mask: str | Path | None = setting(None, "a picture of the same size, white where the thing is", metavar="FILE")
    whole: bool = setting(False, "the whole picture is the entity", "--no-segment")
    class_word: str | None = setting(None, "what the picture shows (default: the entity's word)", metavar="TEXT")
    style_word: str = setting("photo", "what the style starts from (photo)", metavar="TEXT")

    def __post_init__(self) -> None:
        if self.whole and (self.text or self.mask):
            raise SceneError("value", "`--no-segment` takes the whole picture: leave out --text and --mask")
        if self.text and self.mask:
            message = "`--mask` says where the thing is, so there is nothing to look for: leave out --text"
            raise SceneError("value", message)
        for option, word in (("class-word", self.class_word), ("style-word", self.style_word)):
            if word is not None and not word.strip():
                raise SceneError("value", f"`--{option}` is a word to start from, not nothing")

    def check_single(self, entities: Sequence[str]) -> None:
        """Raises SceneError("value") where this is about one entity, but another number is named."""
        told = {"text": self.text, "mask": self.mask, "class-word": self.class_word, "no-segment": self.whole}
        single = next((option for option, value in told.items() if value), None)
        if single is not None and len(entities) != 1:
            raise SceneError("value", f"`--{single}` is about one entity: name it with --entity")


@dataclass(frozen=True, slots=True)
class InversionModels:
    """The networks by name, or a folder each.

    Parameters
    ----------
    model : str, optional
        The diffusion model; default ``MVDream/MVDream``.
    detector : str, optional
        What finds things in pictures; default ``IDEA-Research/grounding-dino-base``.
    segmenter : str, optional
        What cuts them out; default ``facebook/sam-vit-huge``.

    Examples
    --------
    >>> InversionModels(model="stabilityai/stable-diffusion-2-1-base").detector is None
    True
    """

    model: str | None = setting(None, "MVDream/MVDream, another diffusion model, or a folder", metavar="NAME")
    detector: str | None = setting(None, "IDEA-Research/grounding-dino-base, or a folder", metavar="NAME")
    segmenter: str | None = setting(None, "facebook/sam-vit-huge, or a folder", metavar="NAME")


def check_installed() -> None:
    """Raises SceneError("backend") where a package that learns from pictures is missing."""
    for package in ("torch", "diffusers", "transformers"):
        need(package, INSTALL)


# --- what comes of it ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class LearnedPart:
    """What was learned of one thing in a picture: ``text``, what it is, and the ``handles`` that have its vector."""

    text: str
    handles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InversionStart:
    """What a run is about to learn: the ``parts``, and the texts of those that no picture shows."""

    parts: tuple[LearnedPart, ...]
    missing: tuple[str, ...]
    folder: Path

    def __str__(self) -> str:
        """What is missing, in a line; empty where nothing is."""
        named = ", ".join(f'"{text}"' for text in self.missing)
        return f"not found in the picture, so left as they are: {named}" if named else ""


@dataclass(frozen=True, slots=True, repr=False)
class Inversion:
    """A run that learned embeddings.

    Attributes
    ----------
    embeddings : Embeddings
        Where the vectors are; written when the run is ``finished``.
    folder : Path
        The run: its state, and the pictures that were cut out.
    parts : tuple of LearnedPart
        The entities that were learned.
    styles : tuple of str
        The handles that have the vector of the style.
    missing : tuple of str
        What no picture shows, so that it was left as it is.
    before, after : float
        The denoising loss, measured with the same noise.
    finished : bool
        False where ``stop`` ended it; ``RunFolder(resume=True)`` goes on.
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
        """The handles that have learned vectors, each once."""
        return tuple(dict.fromkeys([*(handle for part in self.parts for handle in part.handles), *self.styles]))

    def data(self) -> dict[str, Any]:
        """What was learned, as JSON data."""
        parts = [{"text": part.text, "handles": list(part.handles)} for part in self.parts]
        loss = {"before": self.before, "after": self.after}
        return {"z": str(self.embeddings.path), "loss": loss, "style": list(self.styles), "parts": parts}

    def __str__(self) -> str:
        """The handles, and how much better the sentences fit the pictures."""
        learned = [handle for part in self.parts for handle in part.handles]
        shown = " ".join(f"<{handle}>" for handle in dict.fromkeys([*learned[:8], *self.styles[:8]]))
        return f"{shown}; loss {self.before:.4g} -> {self.after:.4g}"

    def __repr__(self) -> str:
        return f"<Inversion of {self}{'' if self.finished else ', stopped'}>"


# --- invert, learn_style ---------------------------------------------------------------------------------------------


def invert(
    scene: Scene,
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
    """Learn the embeddings of entities from pictures of them, and keep these in Z.

    Parameters
    ----------
    scene : Scene
        What has the entities.
    pictures : path or PIL picture, or a sequence of them
        What shows them; each entity is learned from that where it is found most surely.
    entities : sequence of str
        Words, words down to one (``tower/roof``), places of children (``0/2``) or handles (``<z4>``); default: all
        parts with names that can be seen.
    subject : PictureSubject, optional
        What of the picture is the entity, and what it is called.
    settings : InversionSettings, optional
        Steps, learning rate, batch size and seed.
    networks : InversionModels, optional
        Names of the networks.
    run : RunFolder, optional
        Where the run is kept; default ``beach.inversion`` beside ``beach.scene``.
    embeddings : Embeddings or path, optional
        Where the vectors go; "auto": beside the program.
    models : Models, optional
        Where weights are, and what computes.
    missing_ok : bool
        Nothing needs to be found: the result may have no parts.
    progress : callable, optional
        Called with a fraction from 0 to 1. An exception that it raises cancels the work.
    on_start, on_step : callable, optional
        Told what is about to be learned, and after each step its loss.
    stop : callable, optional
        Asked before each step; where it says True the run ends, with everything saved, so that it can go on.

    Raises
    ------
    SceneError
        No entity or nothing in the picture is called so, a file is not to be read, weights are not to be had, or the
        arguments make no sense.

    Examples
    --------
    >>> invert(scene, "photo.png", entities=["moai"], models=Models("weights"))  # doctest: +SKIP
    <Inversion of <z2> <z1>; loss 0.1203 -> 0.1094>
    """
    from scenelang.backends.neural.inversion import style_handle

    subject = subject or PictureSubject()
    subject.check_single(entities)
    work = _work(scene, subject, settings, networks, run, embeddings, models, ".inversion")
    targets = _targets(scene, entities)
    before = _before(work)
    missing: list[str] = []
    if before is not None:
        parts = _kept_parts(work, before, targets)
    else:
        parts, missing = _parts(work, _opened(pictures), targets, bool(entities), missing_ok)
    told = tuple(LearnedPart(part.target.text, part.target.handles) for part in parts)
    if on_start is not None:
        on_start(InversionStart(told, tuple(missing), work.folder))
    if not parts:
        return Inversion(work.z, work.folder, (), (), tuple(missing), float("nan"), float("nan"), True)
    styles = (style_handle(scene.graph),)
    outcome = _learn(work, before, parts, styles, False, _tellers(progress, on_step), stop)
    return Inversion(work.z, work.folder, told, styles, tuple(missing), outcome.before, outcome.after, outcome.finished)


def learn_style(
    scene: Scene,
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
    """Learn a style from a picture, for a scene or a part of it, and keep it in Z.

    Parameters
    ----------
    scene : Scene
        What gets the style.
    picture : path or PIL picture
        What has it: all of it, unless ``subject`` says which part.
    entity : str, optional
        A part of the scene, named as in ``invert``; default: the whole.
    run : RunFolder, optional
        Where the run is kept, default ``beach.style``; ``force`` also puts the style in the place of a likeness.

    The other parameters are those of ``invert``.

    Raises
    ------
    SceneError
        As ``invert``; and where the vectors of a likeness would be lost.

    Examples
    --------
    >>> learn_style(scene, "painting.png", models=Models("weights"))  # doctest: +SKIP
    <Inversion of <z1>; loss 0.1311 -> 0.1287>
    """
    subject = subject or PictureSubject()
    work = _work(scene, subject, settings, networks, run, embeddings, models, ".style")
    target = _styled(scene, entity)
    _check_replaced(work, target.handles)
    before = _before(work)
    if before is not None:
        parts = _kept_parts(work, before, [target])
    else:
        given = _opened(picture)
        found = _found_parts(work, [target], [subject.text], given) if subject.text else None
        parts = [_masked_part(work, target, given[0])] if found is None else found
        if not parts:
            raise SceneError("value", f'nothing in {given[0].name} looks like "{subject.text}"')
    if on_start is not None:
        on_start(InversionStart((LearnedPart(target.text, target.handles),), (), work.folder))
    outcome = _learn(work, before, parts, target.handles, True, _tellers(progress, on_step), stop)
    return Inversion(work.z, work.folder, (), target.handles, (), outcome.before, outcome.after, outcome.finished)


# --- what both have in common ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Work:
    """What one inversion is made with."""

    subject: PictureSubject
    settings: InversionSettings
    networks: InversionModels
    run: RunFolder
    folder: Path
    z: Embeddings
    models: Models


@dataclass(frozen=True, slots=True)
class _Input:
    """A picture as PIL has it (RGB), and where it is from."""

    name: str
    picture: Any = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """What is to be learned of one target: ``square`` (S, S, 3) is it, cut out of the picture called ``source``."""

    target: InversionTarget
    source: str
    square: Bytes = field(repr=False)


def _work(
    scene: Scene,
    subject: PictureSubject,
    settings: InversionSettings | None,
    networks: InversionModels | None,
    run: RunFolder | None,
    embeddings: Embeddings | str | Path | None,
    models: Models | None,
    ending: str,
) -> _Work:
    """All that is needed for an inversion, with the packages at hand. Raises SceneError for what makes no sense."""
    from scenelang.backends.base import need
    from scenelang.backends.neural.inversion import InversionSettings
    from scenelang.backends.neural.sentences import check_anything

    run = run or RunFolder()
    folder, z = run.path(scene, ending), Embeddings.of(scene, embeddings)
    z.place()
    check_anything(scene.graph)
    for package in ("torch", "diffusers", "transformers"):
        need(package, INSTALL)
    networks, models = networks or InversionModels(), models or Models()
    return _Work(subject, settings or InversionSettings(), networks, run, folder, z, models)


def _targets(scene: Scene, names: Sequence[str]) -> list[InversionTarget]:
    from scenelang.backends.neural.inversion import named_parts, targets_named

    if not names:
        return named_parts(scene.graph)
    targets = targets_named(scene.graph, names)
    if any(target.whole for target in targets):
        hint = "`scenelang style` learns one from a picture"
        raise SceneError("value", "the embedding of the root is the style of the scene", hint=hint)
    claimed = [handle for target in targets for handle in target.handles]
    if len(set(claimed)) != len(claimed):
        raise SceneError("value", "two of the entities have an embedding in common, which can be learned once")
    return targets


def _styled(scene: Scene, name: str | None) -> InversionTarget:
    """The entity that gets a style: the root, or what a name says."""
    from scenelang.backends.neural.describing import thing
    from scenelang.backends.neural.inversion import InversionTarget, style_handle, targets_named

    if name is None:
        return InversionTarget(thing(scene.root), (style_handle(scene.graph),), True)
    return targets_named(scene.graph, [name])[0]


def _check_replaced(work: _Work, handles: Sequence[str]) -> None:
    """Raises SceneError("value") where a style would take the place of something learned of a picture."""
    made = work.z.made
    lost = next((handle for handle in handles if handle in made and made[handle].how != "style"), None)
    if lost is not None and not work.run.force and not work.run.resume:
        message = f"Z has vectors of <{lost}> already, learned of {made[lost].source}"
        raise SceneError("value", message, hint="--force puts the style in their place")


def _before(work: _Work) -> SavedInversion | None:
    """The run that is to go on; raises SceneError where there is none, or one that would be lost."""
    from scenelang.backends.neural.inversion import STATE, kept_in

    if work.run.resume:
        return kept_in(work.folder)
    if (work.folder / STATE).exists() and not work.run.force and not kept_in(work.folder).finished:
        raise SceneError("file", f"{work.folder} holds a run that is not finished", hint=_ANEW)
    return None


# --- pictures --------------------------------------------------------------------------------------------------------


def _opened(pictures: PictureSource) -> list[_Input]:
    """Pictures with their names; those that are no files are numbered."""
    from scenelang.backends.neural.clip import open_picture

    given = pictures if isinstance(pictures, (list, tuple)) else [pictures]
    if not given:
        raise SceneError("value", "there is no picture to learn from")
    return [
        _Input(Path(each).name, open_picture(each))
        if isinstance(each, (str, Path))
        else _Input(f"picture {number}", each.convert("RGB"))
        for number, each in enumerate(given, start=1)
    ]


def _parts(
    work: _Work, given: Sequence[_Input], targets: Sequence[InversionTarget], named: bool, missing_ok: bool
) -> tuple[list[_Part], list[str]]:
    """What the pictures show of the targets, and the texts of the others; raises SceneError where nothing is found, or
    not all that was named."""
    if work.subject.whole or work.subject.mask:
        return [_masked_part(work, targets[0], given[0])], []
    texts = [work.subject.text or target.text for target in targets]
    parts = _found_parts(work, targets, texts, given)
    seen = [part.target for part in parts]
    missing = [text for target, text in zip(targets, texts, strict=True) if target not in seen]
    if missing and not missing_ok and (named or not parts):
        hint = "say otherwise what to look for with --text, or where it is with --mask"
        names = ", ".join(each.name for each in given)
        raise SceneError("value", f'nothing in {names} looks like "{missing[0]}"', hint=hint)
    return parts, missing


def _masked_part(work: _Work, target: InversionTarget, given: _Input) -> _Part:
    """The part that a mask file shows, of the whole picture without one."""
    import numpy as np

    from scenelang.backends.neural.grounding import cut_out, random_grey, read_mask

    width, height = given.picture.size
    mask = work.subject.mask
    shown = read_mask(Path(mask), width, height) if mask else np.ones((height, width), np.bool_)
    return _Part(target, given.name, cut_out(np.asarray(given.picture), shown, random_grey(work.settings.seed)))


def _found_parts(
    work: _Work, targets: Sequence[InversionTarget], texts: Sequence[str], given: Sequence[_Input]
) -> list[_Part]:
    """Those of ``targets`` that can be seen in one of the pictures, looked for as ``texts``, each cut out of that where
    it is surest."""
    from scenelang.backends.neural.grounding import (
        DETECTOR,
        SEGMENTER,
        Grounding,
        found_in,
        load_detector,
        load_segmenter,
        random_grey,
    )

    shelf, device = work.models.shelf(), work.models.computes_on()
    detector = load_detector(work.networks.detector or DETECTOR, shelf, device)
    segmenter = load_segmenter(work.networks.segmenter or SEGMENTER, shelf, device)
    grounding, grey = Grounding(detector, segmenter), random_grey(work.settings.seed)
    found = []
    for target, text in zip(targets, texts, strict=True):
        seen = found_in(grounding, [each.picture for each in given], text, grey)
        if seen is not None:
            found.append(_Part(target, given[seen[0]].name, seen[1]))
    return found


def _kept_parts(work: _Work, kept: SavedInversion, targets: Sequence[InversionTarget]) -> list[_Part]:
    """The parts of a run that goes on, as it has kept them; raises SceneError("file" or "value")."""
    import numpy as np

    from scenelang.backends.neural.clip import open_picture

    told = kept.asked.get("parts")
    sources = {str(name): str(source) for name, source in told.items()} if isinstance(told, Mapping) else {}
    found = [target for target in targets if target.name in sources]
    if len(found) != len(sources):
        raise SceneError("value", f"the run in {work.folder} is of other entities", hint="--force begins anew")
    return [
        _Part(each, sources[each.name], np.asarray(open_picture(_cut_file(work.folder, each.name)))) for each in found
    ]


def _keep_parts(folder: Path, parts: Sequence[_Part]) -> None:
    """What was cut out, for people, and for the run when it goes on."""
    from PIL import Image

    from scenelang.backends.files import written_whole

    for part in parts:
        with written_whole(_cut_file(folder, part.target.name)) as temporary:
            Image.fromarray(part.square).save(temporary)


def _cut_file(folder: Path, name: str) -> Path:
    return folder / f"{name.replace('*', '-')}.png"


# --- learning --------------------------------------------------------------------------------------------------------


def _learn(
    work: _Work,
    before: SavedInversion | None,
    parts: Sequence[_Part],
    styles: Sequence[str],
    style_only: bool,
    tell: Callable[[InversionProgress], None],
    stop: Callable[[], bool] | None,
) -> InversionOutcome:
    """Learn the pseudo-words of ``parts`` and their common style; at the end store the first for the handles of each
    target, the style for the handles ``styles``. ``style_only``: the class is what the target is called."""
    from scenelang.backends.files import made_folder
    from scenelang.backends.neural.diffusion import memory_told
    from scenelang.backends.neural.diffusion_loading import MULTIVIEW, load_any
    from scenelang.backends.neural.inversion import STYLE, Inverting, asked_of, start_of
    from scenelang.backends.neural.inversion import run as run_steps

    made_folder(work.folder)
    with memory_told():
        model = load_any(work.networks.model or MULTIVIEW, work.models.shelf(), work.models.computes_on())
        words = {} if style_only else {p.target.name: work.subject.class_word or p.target.text for p in parts}
        words[STYLE] = work.subject.style_word
        subjects = [_subject(work, part, model.size, style_only) for part in parts]
        starts = {name: start_of(model.words, word) for name, word in words.items()}
        asked = asked_of(work.settings, model.name, subjects, words)
        asked["parts"] = {part.target.name: part.source for part in parts}
        _keep_parts(work.folder, parts)
        learning = Inverting(model, subjects, starts, work.settings)
        outcome = run_steps(learning, work.folder, asked, before, tell, stop or (lambda: False))
    if outcome.finished:
        _store(work.z.place(), learning.vectors(), parts, styles, model.name, style_only)
    return outcome


def _subject(work: _Work, part: _Part, size: int, style_only: bool) -> LearnedSubject:
    import torch

    from scenelang.backends.neural.grounding import resized
    from scenelang.backends.neural.inversion import LearnedSubject, sentence_about, sentence_of

    picture = torch.tensor(resized(part.square, size)).permute(2, 0, 1).float() / 255.0
    word = work.subject.class_word or part.target.text
    return LearnedSubject(picture, sentence_about(word) if style_only else sentence_of(part.target.name))


def _tellers(
    progress: Progress | None, on_step: Callable[[InversionProgress], None] | None
) -> Callable[[InversionProgress], None]:
    """What is told of each step, one callback for both."""

    def tell(told: InversionProgress) -> None:
        if on_step is not None:
            on_step(told)
        if progress is not None:
            progress(told.share)

    return tell


def _store(
    z: Path, vectors: Mapping[str, Any], parts: Sequence[_Part], styles: Sequence[str], model: str, style_only: bool
) -> None:
    """Write the vectors into Z, with how they came to be."""
    from scenelang.backends.neural.inversion import STYLE

    when = datetime.now(UTC).isoformat(timespec="seconds")
    found, made = {}, {}
    for part in () if style_only else parts:
        for handle in part.target.handles:
            found[handle] = vectors[part.target.name]
            made[handle] = zfile.Made("inversion", part.source, model, when)
    sources = ", ".join(dict.fromkeys(part.source for part in parts))
    for handle in styles:
        found[handle], made[handle] = vectors[STYLE], zfile.Made("style", sources, model, when)
    zfile.write_vectors(z, found, made)
