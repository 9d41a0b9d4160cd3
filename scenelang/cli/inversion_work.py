"""Pseudo-words learned from pictures and stored in Z: what invert, style and generate have in common."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.backends.neural.diffusion import Diffusion
    from scenelang.backends.neural.grounding import Bytes
    from scenelang.backends.neural.inversion import (
        InversionOutcome,
        InversionProgress,
        InversionSettings,
        InversionTarget,
        LearnedSubject,
        SavedInversion,
    )
    from scenelang.backends.neural.weights import Shelf


@dataclass(frozen=True, slots=True)
class Way:
    """How to learn: models by name (None: the usual ones), and what the pseudo-words start from."""

    shelf: Shelf
    device: str
    settings: InversionSettings
    model: str | None = None
    detector: str | None = None
    segmenter: str | None = None
    class_word: str | None = None
    style_word: str = "photo"
    quiet: bool = False


@dataclass(frozen=True, slots=True)
class TargetPlace:
    """The folder of a run and the file Z. ``resume`` goes on with the run there, ``force`` begins anew."""

    folder: Path
    z: Path
    resume: bool = False
    force: bool = False


@dataclass(frozen=True, slots=True)
class InversionInput:
    """A picture as PIL has it (RGB), and where it is from."""

    name: str
    picture: Any = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What is to be learned of one target: ``square`` (S, S, 3) is it, cut out of the picture called ``source``."""

    target: InversionTarget
    source: str
    square: Bytes = field(repr=False)

    @property
    def word(self) -> str:
        return self.target.text


# --- pictures --------------------------------------------------------------------------------------------------------


def before_of(place: TargetPlace) -> SavedInversion | None:
    """The run that is to go on; raises SceneError where there is none, or one that would be lost."""
    from scenelang.backends.neural.inversion import STATE, kept_in

    if place.resume:
        return kept_in(place.folder)
    if (place.folder / STATE).exists() and not place.force and not kept_in(place.folder).finished:
        hint = "--resume goes on with it, --force begins anew"
        raise SceneError("file", f"{place.folder} holds a run that is not finished", hint=hint)
    return None


def masked_part(target: InversionTarget, given: InversionInput, mask: Path | None, seed: int) -> Part:
    """The part that a mask file shows, of the whole picture without one."""
    import numpy as np

    from scenelang.backends.neural.grounding import cut_out, random_grey, read_mask

    width, height = given.picture.size
    shown = np.ones((height, width), np.bool_) if mask is None else read_mask(mask, width, height)
    return Part(target, given.name, cut_out(np.asarray(given.picture), shown, random_grey(seed)))


def found_parts(
    way: Way, targets: Sequence[InversionTarget], texts: Sequence[str], given: Sequence[InversionInput]
) -> list[Part]:
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

    detector = load_detector(way.detector or DETECTOR, way.shelf, way.device)
    segmenter = load_segmenter(way.segmenter or SEGMENTER, way.shelf, way.device)
    grounding, grey = Grounding(detector, segmenter), random_grey(way.settings.seed)
    found = []
    for target, text in zip(targets, texts, strict=True):
        seen = found_in(grounding, [each.picture for each in given], text, grey)
        if seen is not None:
            found.append(Part(target, given[seen[0]].name, seen[1]))
    return found


def kept_parts(place: TargetPlace, kept: SavedInversion, targets: Sequence[InversionTarget]) -> list[Part]:
    """The parts of a run that goes on, as it has kept them; raises SceneError("file" or "value")."""
    import numpy as np

    from scenelang.backends.neural.clip import open_picture

    told = kept.asked.get("parts")
    sources = {str(name): str(source) for name, source in told.items()} if isinstance(told, Mapping) else {}
    found = [target for target in targets if target.name in sources]
    if len(found) != len(sources):
        raise SceneError("value", f"the run in {place.folder} is of other entities", hint="--force begins anew")
    return [
        Part(each, sources[each.name], np.asarray(open_picture(_cut_file(place.folder, each.name)))) for each in found
    ]


def _keep_parts(folder: Path, parts: Sequence[Part]) -> None:
    """What was cut out, for people, and for the run when it goes on."""
    from PIL import Image

    from scenelang.backends.files import written_whole

    for part in parts:
        with written_whole(_cut_file(folder, part.target.name)) as temporary:
            Image.fromarray(part.square).save(temporary)


def _cut_file(folder: Path, name: str) -> Path:
    return folder / f"{name.replace('*', '-')}.png"


# --- learning --------------------------------------------------------------------------------------------------------


def learn(
    way: Way, place: TargetPlace, parts: Sequence[Part], styles: Sequence[str], style_only: bool = False
) -> InversionOutcome:
    """Learn the pseudo-words of ``parts`` and their common style; store the first for the handles of each target, the
    style for the handles ``styles``. ``style_only``: the class is what the target is called.

    Raises SceneError; KeyboardInterrupt where it was stopped: the run is kept.
    """
    from scenelang.backends.neural.diffusion import memory_told
    from scenelang.backends.neural.inversion import STYLE, Inverting, asked_of, run, start_of
    from scenelang.cli.interruptions import interruptions
    from scenelang.cli.neural_scene import folder_of

    before = before_of(place)
    folder_of(str(place.folder))
    with memory_told():
        model = _model(way)
        words = {} if style_only else {part.target.name: way.class_word or part.word for part in parts}
        words[STYLE] = way.style_word
        subjects = [_subject(way, model, part, style_only) for part in parts]
        starts = {name: start_of(model.words, word) for name, word in words.items()}
        asked = asked_of(way.settings, model.name, subjects, words)
        asked["parts"] = {part.target.name: part.source for part in parts}
        _keep_parts(place.folder, parts)
        learning = Inverting(model, subjects, starts, way.settings)
        with interruptions() as stopped:
            outcome = run(learning, place.folder, asked, before, _teller(way), stopped)
    if not outcome.finished:
        print(f"{place.folder} is kept; `--resume` goes on", file=sys.stderr)
        raise KeyboardInterrupt
    _store(place.z, learning.vectors(), parts, styles, model.name, style_only)
    return outcome


def _model(way: Way) -> Diffusion:
    from scenelang.backends.neural.diffusion_loading import MULTIVIEW, load_any

    return load_any(way.model or MULTIVIEW, way.shelf, way.device)


def _subject(way: Way, model: Diffusion, part: Part, style_only: bool) -> LearnedSubject:
    import torch

    from scenelang.backends.neural.grounding import resized
    from scenelang.backends.neural.inversion import LearnedSubject, sentence_about, sentence_of

    picture = torch.tensor(resized(part.square, model.size)).permute(2, 0, 1).float() / 255.0
    about = sentence_about(way.class_word or part.word) if style_only else sentence_of(part.target.name)
    return LearnedSubject(picture, about)


def _teller(way: Way) -> Callable[[InversionProgress], None]:
    """A line with the loss on a terminal."""
    if way.quiet or not sys.stderr.isatty():
        return lambda _: None

    def tell(told: InversionProgress) -> None:
        end = "\n" if told.done >= told.steps else ""
        sys.stderr.write(f"\rstep {told.done:,}/{told.steps:,}  loss {told.loss:.4g}\033[K{end}")
        sys.stderr.flush()

    return tell


def _store(
    z: Path, vectors: Mapping[str, Any], parts: Sequence[Part], styles: Sequence[str], model: str, style_only: bool
) -> None:
    """Write the vectors into Z, with how they came to be."""
    from scenelang.backends.neural.inversion import STYLE
    from scenelang.zfile import Made, write_vectors

    when = datetime.now(UTC).isoformat(timespec="seconds")
    found, made = {}, {}
    for part in () if style_only else parts:
        for handle in part.target.handles:
            found[handle] = vectors[part.target.name]
            made[handle] = Made("inversion", part.source, model, when)
    sources = ", ".join(dict.fromkeys(part.source for part in parts))
    for handle in styles:
        found[handle], made[handle] = vectors[STYLE], Made("style", sources, model, when)
    write_vectors(z, found, made)


def check_replaced(place: TargetPlace, handles: Sequence[str]) -> None:
    """Raises SceneError("value") where a style would take the place of something learned of a picture."""
    from scenelang.zfile import read_made

    made = read_made(place.z) if place.z.exists() else {}
    lost = next((handle for handle in handles if handle in made and made[handle].how != "style"), None)
    if lost is not None and not place.force and not place.resume:
        message = f"Z has vectors of <{lost}> already, learned of {made[lost].source}"
        raise SceneError("value", message, hint="--force puts the style in their place")
