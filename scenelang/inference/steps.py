"""Generation loop of one sample: draft, repairs, critiques, as a generator of requests.

As a generator, the same loop runs with single requests, in batches, and from recorded answers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from io import BytesIO
from itertools import islice
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from scenelang.backends.files import read_regular
from scenelang.backends.language_models.catalogue import (
    ImageContent,
    Message,
    Reply,
    Request,
    StopReason,
    TextContent,
    text_message,
)
from scenelang.backends.language_models.catalogue import ImageContent as Encoded
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, render_text
from scenelang.inference.brief import NO_CHANGES, Brief, Notation, Prompts, Task, TaskKind, fenced
from scenelang.inference.listing import program_of
from scenelang.interpreter.inspection.instance_paths import box_of
from scenelang.interpreter.scene.bounds import box_diagonal, entity_box
from scenelang.interpreter.scene.declarations import Declaration
from scenelang.interpreter.scene.entity import Scene, count_words, descendants, primitive_count
from scenelang.interpreter.scene.primitives import block_words
from scenelang.interpreter.transpile.analysis.python_text import code_of
from scenelang.sandbox.supervision import limited
from scenelang.sandbox.worker import trial
from scenelang.session.checking import declaration_errors
from scenelang.session.declarations import declared_in_python, with_acceptance
from scenelang.session.formatting import formatted
from scenelang.session.scene_changes import changes_between, compared_frames
from scenelang.session.session import Options, Session, linted
from scenelang.stdlib.reference import about_names

if TYPE_CHECKING:
    from scenelang.backends.pictures.film import Picture


# Evaluation of answers: extracted, checked and evaluated under limits; nothing is executed as Python.


_FENCE = re.compile(r"^[ \t]*+(?:```|~~~)[ \t]*+([\w+-]*+)[^\n]*+\n(.*?)(?:^[ \t]*(?:```|~~~)[ \t]*$|\Z)", re.M | re.S)
_MAX_COMPARED = 200_000  # primitives; larger films are not checked for motion
_MAX_REPORTED = 12  # diagnostics sent to the model
_REPAIR_EFFORT = 5.0  # of a repair without the model: about 5 s
_PATCH = re.compile(r"^<{5,9} SEARCH *\n(.*?)\n={5,9} *\n(.*?)\n?>{5,9} REPLACE", re.DOTALL | re.MULTILINE)
_PYTHON_START = re.compile(r"^(?:from \w|import \w|def \w|@register)", re.MULTILINE)
_LANGUAGE_START = re.compile(r"\s*(?:;[^\n]*\n\s*)*\((?:bind|define|param|scene|import|assert-that)\b")
_MAX_COUNTED = 40  # words whose counts are told
_MAX_ANSWER_LENGTH = 500_000  # characters; more than the longest answers of models
_MAX_LINE_LENGTH = 500  # characters per line sent to the model
# Evaluation sets process-wide limits and forks, and a fork beside a thread that computes can leave a lock held forever:
# one thread evaluates, judges or draws at a time.
EVALUATING = Lock()


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """Evaluation of an answer.

    ``program`` is the program in the language, formatted if valid, empty if none was found; ``findings`` are warnings
    of the geometry lint. ``code`` is the program as written by the model; ``repairs`` are what edits without the model
    resolved in it.
    """

    program: str
    scene: Scene | None
    diagnostics: tuple[Diagnostic, ...]
    findings: tuple[Diagnostic, ...] = ()
    code: str = ""
    repairs: tuple[str, ...] = ()

    @property
    def is_usable(self) -> bool:
        return self.scene is not None and not any(d.is_error for d in self.diagnostics)

    def report_text(self) -> str:
        """Render the diagnostics for the model, errors first, followed by the signatures of the names in question."""
        ordered = sorted(self.diagnostics, key=lambda d: not d.is_error)
        texts = [_shortened(render_text(d, color=False)) for d in ordered[:_MAX_REPORTED]]
        if len(ordered) > _MAX_REPORTED:
            texts.append(f"... and {len(ordered) - _MAX_REPORTED} more")
        usages = list(islice(about_names(ordered[:_MAX_REPORTED]), _MAX_REPORTED))
        if usages:
            texts.append("\n".join(["Signatures and examples of what the errors are about:", *usages]))
        return "\n\n".join(texts)


def _shortened(text: str) -> str:
    return "\n".join(f"{x[:_MAX_LINE_LENGTH]}..." if len(x) > _MAX_LINE_LENGTH else x for x in text.split("\n"))


@dataclass(frozen=True, slots=True)
class AnswerReader:
    """Reader of the answers to one brief. ``name`` is the file name in diagnostics, relative to which imports are
    resolved; ``options`` limit the evaluation. ``base`` is a program, of which an answer may replace pieces, and
    ``prefix`` one that an answer continues."""

    brief: Brief
    options: Options
    name: str = "answer.scene"
    base: str | None = None
    prefix: str = ""

    def read(self, answer: str) -> Verdict:
        """Evaluate an answer; errors in it are returned as diagnostics and never raised."""
        if len(answer) > _MAX_ANSWER_LENGTH:
            return _refused("model-answer", f"the answer exceeds {_MAX_ANSWER_LENGTH:,} characters")
        if not answer.strip():
            return _refused("model-answer", "the answer is empty")
        with EVALUATING:
            restored = self.brief.restored(answer)
            # Evaluated in a forked process first, which can be killed; what the lint does is bounded by the scene.
            problem = trial(lambda: self._read(restored, has_findings=False))
            verdict = self._read(restored) if problem is None else Verdict("", None, (problem,))
        return self.with_layout(verdict) if any(d.name == "declaration" for d in verdict.diagnostics) else verdict

    def _read(self, answer: str, *, has_findings: bool = True) -> Verdict:
        with limited(self.options.limits):
            return self._judged(answer, has_findings=has_findings)

    def with_layout(self, verdict: Verdict) -> Verdict:
        """Return the verdict of the program whose literals are edited so that findings and declarations are resolved.

        This needs no model, and saves a turn with it. Edits of a person's program and lists of primitives stay as they
        are, and so does a program with other errors, which the model has to repair anyway.
        """
        from scenelang.repairs.repairing import repaired

        unresolved = [d for d in verdict.diagnostics if d.is_error and d.name != "declaration"]
        failed = any(d.name == "declaration" for d in verdict.diagnostics)
        is_own = not self.brief.task.is_edit and self.brief.task.notation is not Notation.LIST
        if verdict.scene is None or unresolved or not is_own or not (verdict.findings or failed):
            return verdict
        session = Session(self.options)
        try:
            with EVALUATING:
                repair = repaired(session, Source(self.name, verdict.program), effort=_REPAIR_EFFORT)
        except SceneError:
            return verdict
        if not repair.changed:
            return verdict
        result = session.evaluate(Source(self.name, repair.text))
        if result.scene is None:
            return verdict
        before, after = (box_diagonal(entity_box(scene.root)) for scene in (verdict.scene, result.scene))
        if after > _MAX_GROWTH * before:
            return verdict
        left = linted(result, declaration_errors)
        code = repair.text if self.brief.task.notation is Notation.LANGUAGE else verdict.code
        findings = self._findings(result.scene)
        repairs = tuple(edit.resolves for edit in repair.edits)
        return Verdict(repair.text, result.scene, (*result.diagnostics, *left), findings, code, repairs)

    def _judged(self, answer: str, *, has_findings: bool) -> Verdict:
        """Return the verdict on an answer, with the findings of the geometry lint if ``has_findings``."""
        session = Session(self.options)
        task = self.brief.task
        notation = task.notation if task.is_edit else _notation_of(answer, task.notation)
        try:
            base = self.base if task.program is None else task.program
            if base is not None and task.notation is not Notation.LIST and _PATCH.search(answer):
                answer = fenced(patched(base, answer), notation)
            code = _code(answer, notation, task.text)
            # the model may have repeated the program that it was asked to continue
            if self.prefix and not _defined(self.prefix) <= _defined(code):
                code = f"{self.prefix.rstrip()}\n\n\n{code}"
                answer = fenced(code, notation)
        except SceneError as error:
            return Verdict("", None, (error.diagnostic,))
        source = Source("answer.txt", answer)
        if notation is Notation.PYTHON:
            program = session.transpile(source).text
            code = code if task.notation is Notation.PYTHON else program
        else:
            program, source = code, Source(self.name, code)
        result = session.evaluate(source)
        scene = result.scene
        if scene is not None and notation is not Notation.PYTHON:
            program = _formatted(code)
        unlike: list[Diagnostic] = []
        if scene is not None:
            accepted = self.acceptance(scene)
            program = with_acceptance(program, accepted)
            unlike = [*_unlike(scene, task), *linted(result, lambda graph: declaration_errors(graph, accepted))]
        is_linted = has_findings and task.kind is not TaskKind.BLOCKS
        findings = self._findings(scene) if is_linted and scene is not None else ()
        return Verdict(program, scene, (*result.diagnostics, *unlike), findings, code)

    def _findings(self, scene: Scene) -> tuple[Diagnostic, ...]:
        """Return the warnings of the geometry lint, but not that an object floats which is accepted as floating."""
        floating = {d.things[0] for d in self.acceptance(scene) if d.relation == "floating" and not d.options}
        findings = geometry_findings(scene)
        return tuple(f for f in findings if f.name != "floating" or not floating & set((_path_in(f) or "").split("/")))

    def acceptance(self, scene: Scene) -> tuple[Declaration, ...]:
        """Return the declarations that the scene must fulfill; words of Python may have underscores for hyphens."""
        stated = self.brief.acceptance
        if self.brief.task.notation is not Notation.PYTHON:
            return stated
        words = {entity.word for entity in descendants(*scene.frames)}
        return tuple(declared_in_python(declaration, words) for declaration in stated)


# Words and functions that a program defines at its top level, in either notation.
_DEFINED = re.compile(r'^(?:\(bind "([^"]+)"|\(define \(?([^\s()]+)|def (\w+)|([A-Za-z_]\w*) *=)', re.M)


def _defined(program: str) -> frozenset[str]:
    """Return what a program defines. The text itself is formatted anew when numbers are edited without the model."""
    return frozenset(next(filter(None, match.groups())) for match in _DEFINED.finditer(program))


def _notation_of(answer: str, asked: Notation) -> Notation:
    """Return the notation that an answer is in: Python and the language are taken for each other."""
    if asked is Notation.LIST:
        return asked
    names = {match[1].lower() for match in _FENCE.finditer(answer)}
    is_python = bool(names & {"python", "py"})
    is_language = bool(names & {"scene", "scenelang", "lisp", "scheme"})
    if is_python != is_language:
        return Notation.PYTHON if is_python else Notation.LANGUAGE
    if names:
        return asked
    if _PYTHON_START.search(answer):
        return Notation.PYTHON
    return Notation.LANGUAGE if _LANGUAGE_START.match(answer) else asked


def patched(program: str, answer: str) -> str:
    """Return a program with the search/replace blocks of an answer applied, in order.

    Raises SceneError("model-answer") for a text that does not occur exactly once.
    """
    for number, match in enumerate(_PATCH.finditer(answer), 1):
        old, new = match[1], match[2]
        count = program.count(old) if old.strip() else 0
        if count != 1:
            problem = "is empty" if not old.strip() else f"occurs {count} times in the program"
            hint = "copy lines of the program exactly, with enough around them that they occur once"
            raise SceneError("model-answer", f"the text that block {number} searches {problem}", hint)
        program = program.replace(old, new)
    return program


def _code(answer: str, notation: Notation, task: str) -> str:
    """Extract the program of an answer; a list is converted to a program. Raises SceneError for an invalid list."""
    if notation is Notation.PYTHON:
        return code_of(answer)
    return program_of(answer, task) if notation is Notation.LIST else program_text(answer)


def program_text(answer: str) -> str:
    """Extract the program from an answer: the longest block fenced as a program or without a language, else all of
    it."""
    blocks = [(match[1].lower(), match[2]) for match in _FENCE.finditer(answer)]
    named = [text for name, text in blocks if name in ("scene", "scenelang", "lisp", "scheme", "")]
    chosen = named or [text for _, text in blocks] or [answer]
    return max(chosen, key=len).strip() + "\n"


def _formatted(text: str) -> str:
    try:
        return formatted(text)
    except SceneError:
        return text


def _unlike(scene: Scene, task: Task) -> list[Diagnostic]:
    """Return errors for properties of the task that a scene lacks. Edits may change the kind of scene."""
    if not any(primitive_count(frame) for frame in scene.frames):
        return [Diagnostic("empty-scene", "the scene has no primitives", None)]
    kind = None if task.is_edit else task.kind
    if kind is TaskKind.FILM and not scene.animated:
        hint = "the last function must yield one shape per frame"
        return [Diagnostic("model-answer", "the scene is not animated: it has only one frame", None, hint)]
    if kind is TaskKind.FILM and _stands_still(scene):
        return [Diagnostic("model-answer", "the scene is not animated: all frames are equal", None)]
    if kind is TaskKind.BLOCKS and not has_blocks(scene):
        return [Diagnostic("model-answer", "the scene has no blocks", None, "create blocks with set_cuboid")]
    return []


def has_blocks(scene: Scene) -> bool:
    """Return whether a scene contains Minecraft blocks."""
    return any(word in count_words(frame) for frame in scene.frames for word in block_words())


def _stands_still(scene: Scene) -> bool:
    """Return whether all frames are equal; films too large to compare count as animated."""
    try:
        first, *others = compared_frames(scene, _MAX_COMPARED)
    except SceneError:
        return False
    return all(changes_between([first], [other]).equal for other in others)


# A wrong statement may be fulfilled by a number that moves objects out of the scene: hydrogen was put 20 m beside its
# carbon. A correction moves objects within it.
_MAX_GROWTH = 2.0


def geometry_findings(scene: Scene) -> tuple[Diagnostic, ...]:
    """Return the warnings of the geometry lint; empty if the scene cannot be checked."""
    from scenelang.backends.geometry.lint import check_geometry

    try:
        return tuple(check_geometry(scene))
    except SceneError:
        return ()


def _refused(name: str, message: str) -> Verdict:
    return Verdict("", None, (Diagnostic(name, message, None),))


# Input images, converted for language models.


ENDINGS = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp", "image/gif": "gif"}  # supported by models
_MAX_SIDE = 1568  # pixels; services downscale larger images
_MAX_FILE_SIZE = 3_500_000  # bytes, before base64 encoding
_MAX_BYTES = 100_000_000
_ORIENTATION = 0x0112  # EXIF tag of the camera's orientation


def read_picture(path: str) -> ImageContent:
    """Read an image file for a model: unchanged if format and size are supported, else rotated upright, downscaled,
    flattened onto white and encoded as JPEG. Raises SceneError if the file is not an image."""
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        if Path(path).stat().st_size > _MAX_BYTES:
            raise SceneError("file", f"the image {path} exceeds {_MAX_BYTES:,} bytes")
        data = read_regular(path)
        with Image.open(BytesIO(data)) as image:
            image.load()
            media_type = Image.MIME.get(image.format or "", "")
            is_upright = image.getexif().get(_ORIENTATION, 1) == 1
            fits = is_upright and max(image.size) <= _MAX_SIDE and len(data) <= _MAX_FILE_SIZE
            if fits and media_type in ENDINGS:
                return ImageContent(media_type, data)
            upright = ImageOps.exif_transpose(image).convert("RGBA")
    except (OSError, ValueError, UnidentifiedImageError, Image.DecompressionBombError, SyntaxError) as error:
        reason = getattr(error, "strerror", None) or "not an image"
        raise SceneError("file", f"cannot read the image {path}: {reason}") from None
    upright.thumbnail((_MAX_SIDE, _MAX_SIDE))
    flat = Image.new("RGBA", upright.size, "white")
    flat.alpha_composite(upright)
    buffer = BytesIO()
    flat.convert("RGB").save(buffer, "JPEG", quality=90)
    return ImageContent("image/jpeg", buffer.getvalue())


# Renderings of a scene for a model: several views of one scene, or one view of several scenes.


# Side of a view in pixels: the largest contact sheet has 3 x 3 views, 1,376 pixels, and is not downscaled (_MAX_SIDE).
_VIEW_PX = 448
_STILL = (
    ("from the front", "azimuth=0,elevation=15"),
    ("from the front right", "azimuth=40,elevation=25"),
    ("from behind on the left", "azimuth=220,elevation=25"),
    ("from above", "top"),
)
_FILM_VIEW = "azimuth=30,elevation=20"
_MOMENTS = (0.0, 0.13, 0.41, 0.77)  # of a film; avoids fractions at which periodic motion repeats
_MAX_CLOSE_UPS = 3  # of one request
_CLOSE_UP_VIEW = "azimuth=40,elevation=8"  # low, so that a gap below an object is seen
# Distance of a close-up in diagonals of the object's box: at 1.6 it fills the field of view of 35 degrees.
_CLOSE_UP_DIAGONALS = 3.5
_MARGIN_PX = 8  # pixels between the views of a contact sheet


def views(scene: Scene) -> list[tuple[str, Encoded]]:
    """Render several images with captions: a static scene from several directions, a film at several times. Empty if
    the scene cannot be rendered."""
    shown: list[tuple[str, str, int | None]] = [(caption, view, None) for caption, view in _STILL]
    if scene.animated:
        count = len(scene.frames)
        chosen = sorted({int(moment * count) for moment in _MOMENTS})
        shown = [(f"frame {frame} of {count}", _FILM_VIEW, frame) for frame in chosen]
    try:
        return [(f"The scene, {caption}:", encoded(picture(scene, view, frame))) for caption, view, frame in shown]
    except SceneError:
        return []


def close_ups(scene: Scene, findings: Sequence[Diagnostic]) -> list[tuple[str, Encoded]]:
    """Render the objects that the first findings name, each from near and with what is around it, with captions.

    A finding without the path of an object has none, and so has an object that cannot be rendered.
    """
    shown = []
    named = dict.fromkeys(path for finding in findings if (path := _path_in(finding)) is not None)
    for path in list(named)[:_MAX_CLOSE_UPS]:
        try:
            box = box_of(scene, path)
            if box is not None:
                low, high = np.array(box[:3]), np.array(box[3:])
                target, distance = (
                    ":".join(map(str, (low + high) / 2.0)),
                    _CLOSE_UP_DIAGONALS * float(np.linalg.norm(high - low)),
                )
                view = f"{_CLOSE_UP_VIEW},target={target},distance={distance}"
                shown.append((f'"{path}", from near:', encoded(picture(scene, view))))
        except SceneError:
            continue
    return shown


def _path_in(finding: Diagnostic) -> str | None:
    """Return the path of the object that the message of a finding begins with."""
    from scenelang.backends.geometry.lint import quoted_path

    return quoted_path(finding) if finding.message.startswith('"') else None


def picture(scene: Scene, view: str, frame: int | None = None, size: int = _VIEW_PX) -> Picture:
    """Render a draft of a scene, (size, size, 3). Raises SceneError if it cannot be rendered."""
    from scenelang.backends.pictures.camera import parse_viewpoint
    from scenelang.backends.pictures.film import PictureOptions, render

    options = PictureOptions(width=size, height=size, camera=parse_viewpoint(view), frame=frame)
    return render(scene, options)


def best_view(scene: Scene) -> Picture:
    """Render the most informative view; of a film, the middle frame."""
    return picture(scene, _STILL[1][1], len(scene.frames) // 2 if scene.animated else None)


def contact_sheet(scenes: Sequence[Scene]) -> Encoded:
    """Render one view of each scene in a grid, numbered from 1."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    columns = math.ceil(math.sqrt(len(scenes)))
    rows = math.ceil(len(scenes) / columns)
    step = _VIEW_PX + _MARGIN_PX
    sheet = Pillow.new("RGB", (columns * step + _MARGIN_PX, rows * step + _MARGIN_PX), "white")
    font = ImageFont.load_default(40)
    for number, scene in enumerate(scenes):
        corner = (_MARGIN_PX + number % columns * step, _MARGIN_PX + number // columns * step)
        sheet.paste(Pillow.fromarray(best_view(scene)), corner)
        draw = ImageDraw.Draw(sheet)
        place = (corner[0] + 10, corner[1] + 6)
        draw.text(place, str(number + 1), fill="black", font=font, stroke_width=4, stroke_fill="white")
    return encoded(np.asarray(sheet))


def encoded(picture: Picture) -> Encoded:
    """Encode an image for a model."""
    from scenelang.backends.pictures.film import png_of

    return Encoded("image/png", png_of(picture))


_MAX_BROKEN = 2  # consecutive incomplete answers before a sample fails
_MAX_FINDINGS = 6  # of the checks in a request; those that remain after the repair are in the next one
_MAX_RESOLVED = 120  # characters told of a finding that was resolved


class Purpose(Enum):
    """Purpose of a request."""

    PLAN = "plan"
    PART = "part"
    DRAFT = "draft"
    REPAIR = "repair"
    CRITIQUE = "critique"
    CRITIC = "critic"
    REVISE = "revise"
    JUDGE = "judge"


@dataclass(frozen=True, slots=True)
class Ask:
    """A request to send; its answer is sent back into the generator."""

    purpose: Purpose
    request: Request


@dataclass(frozen=True, slots=True)
class SampleProgress:
    """Evaluation of the last answer, for the records; ``note`` is one line about it for a person who waits."""

    verdict: Verdict
    note: str = ""


@dataclass(frozen=True, slots=True)
class SampleOutcome:
    """Best result of a sample, usable or not. ``stopped`` is the error that prevented further refinement.

    ``acceptance`` are the declarations that were written before the program, ``log`` one line for each step.
    """

    verdict: Verdict
    stopped: SceneError | None = None
    acceptance: tuple[Declaration, ...] = ()
    log: tuple[str, ...] = ()


Step = Ask | SampleProgress
Steps = Generator[Step, Reply | None, SampleOutcome]


@dataclass(frozen=True, slots=True)
class Speaker:
    """Request parameters: the model and its settings. ``most_tokens`` is the maximum length of its answers."""

    model: str
    max_tokens: int
    most_tokens: int
    thinking: str | None = None
    effort: str | None = None
    grammar: str | None = None

    def request(self, system: str, turns: tuple[Message, ...]) -> Request:
        fixed = TextContent(system, is_cacheable=True)
        return Request(self.model, fixed, turns, self.max_tokens, self.thinking, self.effort, self.grammar)


@dataclass(frozen=True, slots=True)
class SamplePlan:
    """Maximum numbers of repairs and critiques of a sample.

    ``accepts``: the model first writes what must hold. ``revisions`` of a scene that is built part by part, with a
    critic; None for a sample of `generate`. ``sees``: the model reads images.
    """

    repairs: int = 3
    critiques: int = 0
    accepts: bool = False
    revisions: int | None = None
    sees: bool = True

    def shown(self, render: Callable[[], list[tuple[str, Encoded]]]) -> list[tuple[str, Encoded]]:
        """Return rendered images with their captions; none for a model that reads no images."""
        if not self.sees:
            return []
        with EVALUATING:
            return render()


def sample_steps(brief: Brief, reader: AnswerReader, speaker: Speaker, plan: SamplePlan) -> Steps:
    """Generate one sample. Raises SceneError, such as ``model-refusal`` or one thrown in for a failed request, if no
    valid program results."""
    best, answer = yield from with_repairs(brief, reader, speaker, plan, Purpose.DRAFT, (brief.first,))
    return (yield from criticized(brief, reader, speaker, plan, best, answer))


def criticized(
    brief: Brief, reader: AnswerReader, speaker: Speaker, plan: SamplePlan, best: Verdict, answer: str
) -> Steps:
    """Refine a program by critiques of its pictures, while the model changes it and its findings do not increase."""
    for _ in range(plan.critiques):
        best = reader.with_layout(best)
        scene = best.scene if best.is_usable else None
        shown = plan.shown(partial(views, scene)) if scene is not None else []
        if scene is None or (plan.sees and not shown):
            break
        if best.repairs and brief.task.notation is Notation.LANGUAGE:
            answer = fenced(best.program, Notation.LANGUAGE)
        turns = (brief.first, text_message("assistant", answer), brief.critique(shown, noticed(best), facts_of(best)))
        try:
            better, improved = yield from with_repairs(brief, reader, speaker, plan, Purpose.CRITIQUE, turns, best)
        except SceneError as error:
            return SampleOutcome(best, error)
        if better is best or not better.is_usable or len(better.findings) > len(best.findings):
            break
        best, answer = better, improved
    return SampleOutcome(best)


def facts_of(verdict: Verdict) -> str:
    """Return what the program knows of its scene: how many things of each word, and how large it is."""
    assert verdict.scene is not None
    repaired = _told(verdict.repairs)
    counts = count_words(verdict.scene.root)
    told = ", ".join(f"{count} {word}" for word, count in list(counts.items())[:_MAX_COUNTED])
    box = entity_box(verdict.scene.root)
    if box is None:
        return f"{repaired}It consists of: {told}."
    low, high = (" ".join(f"{x:.3g}" for x in corner) for corner in (box[:3], box[3:]))
    return f"{repaired}It consists of: {told}. Its bounding box is [{low}] to [{high}]."


def _told(repairs: Sequence[str]) -> str:
    """Return one line about edits that were made without the model; empty without edits."""
    if not repairs:
        return ""
    what = "; ".join(text.splitlines()[0][:_MAX_RESOLVED] for text in repairs[:_MAX_FINDINGS])
    return f"Numbers of the program were already edited so that these findings are resolved: {what}.\n\n"


def noticed(verdict: Verdict) -> str:
    return "\n\n".join(render_text(d, color=False) for d in verdict.findings[:_MAX_FINDINGS])


def with_repairs(
    brief: Brief,
    reader: AnswerReader,
    speaker: Speaker,
    plan: SamplePlan,
    purpose: Purpose,
    turns: tuple[Message, ...],
    kept: Verdict | None = None,
) -> Generator[Step, Reply | None, tuple[Verdict, str]]:
    """Send a request, and repair requests while the answer has errors. Returns the last verdict and its answer;
    ``kept`` is the verdict to return if the model replies that no changes are needed."""
    asked = turns
    for repair in range(plan.repairs + 1):
        reply, speaker = yield from complete(speaker, brief.system, purpose if repair == 0 else Purpose.REPAIR, asked)
        if reply.stop is StopReason.MAX_TOKENS:
            verdict = Verdict("", None, (_cut(speaker),))
            yield SampleProgress(verdict)
            asked = (*turns, *shown_answer(reply.text), brief.cut(speaker.max_tokens))
            continue
        if kept is not None and repair == 0 and wants_nothing(reply.text):
            yield SampleProgress(kept)
            return kept, reply.text
        verdict = reader.read(reply.text)
        yield SampleProgress(verdict)
        if verdict.is_usable:
            return verdict, reply.text
        asked = (*turns, *shown_answer(reply.text), brief.repair(verdict.report_text()))
    return verdict, reply.text


def shown_answer(answer: str) -> tuple[Message, ...]:
    """Convert an answer to a turn; services reject empty turns."""
    return (text_message("assistant", answer),) if answer.strip() else (text_message("assistant", "(no text)"),)


def wants_nothing(answer: str) -> bool:
    return answer.strip().strip(".*`\"'").upper() == NO_CHANGES


def complete(
    speaker: Speaker, system: str, purpose: Purpose, turns: tuple[Message, ...]
) -> Generator[Step, Reply | None, tuple[Reply, Speaker]]:
    """Request an answer until it is complete, or truncated at the model's maximum length. Incomplete answers are
    requested again, truncated ones with a higher token limit. Returns the answer and the updated speaker."""
    broken = 0
    while True:
        reply = yield Ask(purpose, speaker.request(system, turns))
        assert reply is not None
        if reply.stop is StopReason.REFUSED:
            note = f": {' '.join(reply.note.split())}" if reply.note else ""
            raise SceneError("model-refusal", f"the model refused to answer{note}", "rephrase the task")
        if reply.stop is StopReason.CONTEXT_FULL:
            raise SceneError(
                "model-answer", "the model's context window is full", "use fewer images or a smaller program"
            )
        if reply.stop is StopReason.INTERRUPTED:
            broken += 1
            if broken > _MAX_BROKEN:
                why = f": {reply.note}" if reply.note else ""
                raise SceneError("model-answer", f"the answer was incomplete {broken} times{why}")
            continue
        if reply.stop is StopReason.MAX_TOKENS and speaker.max_tokens < speaker.most_tokens:
            speaker = replace(speaker, max_tokens=min(speaker.most_tokens, 2 * speaker.max_tokens))
            continue
        return reply, speaker


def _cut(speaker: Speaker) -> Diagnostic:
    return Diagnostic("model-answer", f"the answer was truncated after {speaker.max_tokens:,} tokens", None)


# Selection among samples: no errors, then the fewest geometry warnings, then the model's judgement of renderings.


_MAX_JUDGED = 9  # samples whose renderings are compared: a contact sheet of 3 x 3 (see _VIEW_PX)
_ANSWER = re.compile(r"BEST:\s*#?(\d+)", re.I)


def candidates(outcomes: Mapping[int, SampleOutcome]) -> list[int]:
    """Return the samples that are equally good by errors and warnings."""
    usable = {sample: outcome.verdict for sample, outcome in outcomes.items() if outcome.verdict.is_usable}
    if not usable:
        return []
    fewest = min(len(verdict.findings) for verdict in usable.values())
    return [sample for sample, verdict in usable.items() if len(verdict.findings) == fewest]


def judge_steps(prompts: Prompts, speaker: Speaker, task: Task, verdicts: Sequence[Verdict]) -> Steps:
    """Ask the model which rendered scene fulfills the task best, as a separate sample. The outcome is the selected
    verdict, or the first one if the answer names none."""
    judged = verdicts[:_MAX_JUDGED]
    scenes = [verdict.scene for verdict in judged if verdict.scene is not None]
    try:
        with EVALUATING:
            sheet = contact_sheet(scenes)
    except SceneError:
        return SampleOutcome(judged[0])  # scenes that cannot be rendered cannot be compared
    wanted = f"Reconstruct the scene of the pictures before. {task.text}".strip() if task.pictures else task.text
    text = prompts.text("judge.md", count=str(len(scenes)), task=wanted)
    turn = Message("user", (*task.pictures, sheet, TextContent(text)))
    request = replace(speaker, grammar=None).request(prompts.text("judge.system.md"), (turn,))
    reply = yield Ask(Purpose.JUDGE, request)
    match = _ANSWER.search(reply.text) if reply is not None else None
    number = int(match[1]) if match is not None and len(match[1]) < 4 else 1
    return SampleOutcome(judged[number - 1 if 1 <= number <= len(judged) else 0])
