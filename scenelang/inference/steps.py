"""The loop of one sample as a conversation: a draft, repairs, critiques. Whoever drives it sends what it yields.

Written as generators, so that the same loop runs with single requests, with batches, and from a run's records.
"""

from __future__ import annotations

import math
import re
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from io import BytesIO
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from scenelang.backends.files import read_regular
from scenelang.backends.language_models.catalogue import ImageContent, Reply, Request, Stop, TextContent, Turn, said
from scenelang.backends.language_models.catalogue import ImageContent as Encoded
from scenelang.formatting import formatted
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, render_text
from scenelang.inference.brief import NO_CHANGES, Brief, Notation, Prompts, Task, TaskKind
from scenelang.inference.listing import program_of
from scenelang.interpreter.scene.entity import Scene, count_words, primitive_count
from scenelang.interpreter.scene.primitives import block_words
from scenelang.interpreter.transpile.python_text import code_of
from scenelang.sandbox.supervision import limited
from scenelang.sandbox.worker import trial
from scenelang.scene_changes import changes_between, sheets_of
from scenelang.session import Options, Session

if TYPE_CHECKING:
    from scenelang.backends.pictures.film import Picture


# A model's answer on its way to a scene: read, checked, evaluated with limits; nothing of it is executed as Python.


_FENCE = re.compile(r"^[ \t]*+(?:```|~~~)[ \t]*+([\w+-]*+)[^\n]*+\n(.*?)(?:^[ \t]*(?:```|~~~)[ \t]*$|\Z)", re.M | re.S)
_MOST_LOOKED_AT = 200_000  # primitives of a film that is looked at for motion
_MOST_TOLD = 12  # diagnostics that go back to the model
_LONGEST_ANSWER = 500_000  # characters; the longest answers of models have fewer
_LONGEST_LINE = 500  # characters of a line that goes back
_EVALUATING = Lock()  # evaluation sets limits of the whole interpreter, so answers are read one at a time


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What an answer came to. ``program`` is its program in the language, formatted where it works, empty where there
    is none; ``findings`` are what is odd about the scene's geometry. ``code`` is the program as the model wrote it."""

    program: str
    scene: Scene | None
    diagnostics: tuple[Diagnostic, ...]
    findings: tuple[Diagnostic, ...] = ()
    code: str = ""

    @property
    def is_usable(self) -> bool:
        return self.scene is not None and not any(d.is_error for d in self.diagnostics)

    def told(self) -> str:
        """The diagnostics as people see them: errors first, a few of many."""
        ordered = sorted(self.diagnostics, key=lambda d: not d.is_error)
        texts = [_shortened(render_text(d, color=False)) for d in ordered[:_MOST_TOLD]]
        if len(ordered) > _MOST_TOLD:
            texts.append(f"... and {len(ordered) - _MOST_TOLD} more")
        return "\n\n".join(texts)


def _shortened(text: str) -> str:
    return "\n".join(f"{x[:_LONGEST_LINE]}..." if len(x) > _LONGEST_LINE else x for x in text.split("\n"))


@dataclass(frozen=True, slots=True)
class AnswerReader:
    """Reads answers to one brief. ``name`` is what diagnostics call the program, a file beside which it may import;
    ``options`` bound its evaluation."""

    brief: Brief
    options: Options
    name: str = "answer.scene"

    def read(self, answer: str) -> Verdict:
        """The verdict on an answer; never raises for a mistake in it."""
        if len(answer) > _LONGEST_ANSWER:
            return _refused("model-answer", f"the answer is longer than {_LONGEST_ANSWER:,} characters")
        if not answer.strip():
            return _refused("model-answer", "the answer is empty")
        with _EVALUATING:
            restored = self.brief.restored(answer)
            problem = trial(lambda: self._read(restored))  # what does not stay within its limits there is not read here
            return self._read(restored) if problem is None else Verdict("", None, (problem,))

    def _read(self, answer: str) -> Verdict:
        with limited(self.options.limits):
            return self._judged(answer)

    def _judged(self, answer: str) -> Verdict:
        session = Session(self.options)
        task = self.brief.task
        source = Source("answer.txt", answer)
        try:
            code = _code(answer, task.notation, task.text)
        except SceneError as error:
            return Verdict("", None, (error.diagnostic,))
        if task.notation is Notation.PYTHON:
            program = session.transpile(source).text
        else:
            program, source = code, Source(self.name, code)
        result = session.evaluate(source)
        scene = result.scene
        if scene is not None and task.notation is not Notation.PYTHON:
            program = _formatted(code)
        unlike = _unlike(scene, task) if scene is not None else []
        findings = geometry_findings(scene) if scene is not None and task.kind is not TaskKind.BLOCKS else ()
        return Verdict(program, scene, (*result.diagnostics, *unlike), findings, code)


def _code(answer: str, notation: Notation, task: str) -> str:
    """The program of an answer as the model wrote it; of a list, the program that it stands for. Raises SceneError for
    a list that is none."""
    if notation is Notation.PYTHON:
        return code_of(answer)
    return program_of(answer, task) if notation is Notation.LIST else program_text(answer)


def program_text(answer: str) -> str:
    """The program in an answer: its longest block that is fenced as one or as nothing, else all of it."""
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
    """What a scene lacks to be what was asked for. An edit may well make another kind of scene."""
    if not any(primitive_count(frame) for frame in scene.frames):
        return [Diagnostic("empty-scene", "the scene has no primitives", None)]
    kind = None if task.is_edit else task.kind
    if kind is TaskKind.FILM and not scene.animated:
        hint = "a film's last function yields one shape for every frame"
        return [Diagnostic("model-answer", "the scene does not move: it has one frame", None, hint)]
    if kind is TaskKind.FILM and _stands_still(scene):
        return [Diagnostic("model-answer", "the scene does not move: all its frames are the same", None)]
    if kind is TaskKind.BLOCKS and not has_blocks(scene):
        return [Diagnostic("model-answer", "the scene has no blocks", None, "blocks are made by set_cuboid")]
    return []


def has_blocks(scene: Scene) -> bool:
    """Whether a scene has blocks of Minecraft in it."""
    return any(word in count_words(frame) for frame in scene.frames for word in block_words())


def _stands_still(scene: Scene) -> bool:
    """Whether all frames show the same; a film too large to look at is taken to move."""
    try:
        first, *others = sheets_of(scene, _MOST_LOOKED_AT)
    except SceneError:
        return False
    return all(changes_between([first], [other]).equal for other in others)


def geometry_findings(scene: Scene) -> tuple[Diagnostic, ...]:
    """What is odd about a scene's geometry; nothing for one that cannot be looked at."""
    from scenelang.backends.geometry.lint import check_geometry

    try:
        return tuple(check_geometry(scene))
    except SceneError:
        return ()


def _refused(name: str, message: str) -> Verdict:
    return Verdict("", None, (Diagnostic(name, message, None),))


# Pictures of users, as models take them.


ENDINGS = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp", "image/gif": "gif"}  # what models take
_LARGEST_SIDE = 1568  # pixels; services make larger ones smaller
_LARGEST_FILE = 3_500_000  # bytes, before they are written in base 64
_MOST_BYTES = 100_000_000
_ORIENTATION = 0x0112  # in EXIF: how a camera was held


def read_picture(path: str) -> ImageContent:
    """A picture file as models take it: as it is where its format and size allow, else upright, smaller, on white
    and as JPEG. Raises SceneError for a file that is none."""
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        if Path(path).stat().st_size > _MOST_BYTES:
            raise SceneError("file", f"the picture {path} is larger than {_MOST_BYTES:,} bytes")
        data = read_regular(path)
        with Image.open(BytesIO(data)) as image:
            image.load()
            media_type = Image.MIME.get(image.format or "", "")
            is_upright = image.getexif().get(_ORIENTATION, 1) == 1
            fits = is_upright and max(image.size) <= _LARGEST_SIDE and len(data) <= _LARGEST_FILE
            if fits and media_type in ENDINGS:
                return ImageContent(media_type, data)
            upright = ImageOps.exif_transpose(image).convert("RGBA")
    except (OSError, ValueError, UnidentifiedImageError, Image.DecompressionBombError, SyntaxError) as error:
        reason = getattr(error, "strerror", None) or "it is no picture"
        raise SceneError("file", f"cannot read the picture {path}: {reason}") from None
    upright.thumbnail((_LARGEST_SIDE, _LARGEST_SIDE))
    flat = Image.new("RGBA", upright.size, "white")
    flat.alpha_composite(upright)
    buffer = BytesIO()
    flat.convert("RGB").save(buffer, "JPEG", quality=90)
    return ImageContent("image/jpeg", buffer.getvalue())


# Pictures of a scene for a model to look at: several views of one, one view of several.


_SIZE = 448
_STILL = (
    ("from the front", "azimuth=0,elevation=15"),
    ("from the front right", "azimuth=40,elevation=25"),
    ("from behind on the left", "azimuth=220,elevation=25"),
    ("from above", "top"),
)
_FILM_VIEW = "azimuth=30,elevation=20"
_MOMENTS = (0.0, 0.13, 0.41, 0.77)  # of a film; no fractions at which things that go round look as they began
_MARGIN = 8


def views(scene: Scene) -> list[tuple[str, Encoded]]:
    """Several pictures with their captions: of a still scene from around, of a film at several times. Empty for a
    scene that cannot be drawn."""
    shown: list[tuple[str, str, int | None]] = [(caption, view, None) for caption, view in _STILL]
    if scene.animated:
        count = len(scene.frames)
        chosen = sorted({int(moment * count) for moment in _MOMENTS})
        shown = [(f"frame {frame} of {count}", _FILM_VIEW, frame) for frame in chosen]
    try:
        return [(f"The scene, {caption}:", encoded(picture(scene, view, frame))) for caption, view, frame in shown]
    except SceneError:
        return []


def picture(scene: Scene, view: str, frame: int | None = None, size: int = _SIZE) -> Picture:
    """A draft of a scene, (size, size, 3). Raises SceneError for a scene that cannot be drawn."""
    from scenelang.backends.pictures.camera import parse_viewpoint
    from scenelang.backends.pictures.film import PictureOptions, render

    options = PictureOptions(width=size, height=size, camera=parse_viewpoint(view), frame=frame)
    return render(scene, options)


def best_view(scene: Scene) -> Picture:
    """One picture that shows most: of a film its middle."""
    return picture(scene, _STILL[1][1], len(scene.frames) // 2 if scene.animated else None)


def contact_sheet(scenes: Sequence[Scene]) -> Encoded:
    """One view of each scene in a grid, with its number from 1."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    columns = math.ceil(math.sqrt(len(scenes)))
    rows = math.ceil(len(scenes) / columns)
    step = _SIZE + _MARGIN
    sheet = Pillow.new("RGB", (columns * step + _MARGIN, rows * step + _MARGIN), "white")
    font = ImageFont.load_default(40)
    for number, scene in enumerate(scenes):
        corner = (_MARGIN + number % columns * step, _MARGIN + number // columns * step)
        sheet.paste(Pillow.fromarray(best_view(scene)), corner)
        draw = ImageDraw.Draw(sheet)
        place = (corner[0] + 10, corner[1] + 6)
        draw.text(place, str(number + 1), fill="black", font=font, stroke_width=4, stroke_fill="white")
    return encoded(np.asarray(sheet))


def encoded(picture: Picture) -> Encoded:
    """A picture as models take it."""
    from scenelang.backends.pictures.film import png_of

    return Encoded("image/png", png_of(picture))


_MOST_BROKEN = 2  # answers in a row that may break off before a sample is given up
_MOST_FINDINGS = 6


class Purpose(Enum):
    """Why something is asked."""

    DRAFT = "draft"
    REPAIR = "repair"
    CRITIQUE = "critique"
    JUDGE = "judge"


@dataclass(frozen=True, slots=True)
class Ask:
    """A question to send; its answer comes back into the generator."""

    purpose: Purpose
    request: Request


@dataclass(frozen=True, slots=True)
class SampleProgress:
    """What became of the last answer, for the records."""

    verdict: Verdict


@dataclass(frozen=True, slots=True)
class SampleOutcome:
    """The best that a sample came to, usable or not. ``stopped`` says what kept it from being improved further."""

    verdict: Verdict
    stopped: SceneError | None = None


Step = Ask | SampleProgress
Steps = Generator[Step, Reply | None, SampleOutcome]


@dataclass(frozen=True, slots=True)
class Speaker:
    """How requests are made: the model and its settings. ``most_tokens`` is as long as its answers can be."""

    model: str
    max_tokens: int
    most_tokens: int
    thinking: str | None = None
    effort: str | None = None
    grammar: str | None = None

    def request(self, system: str, turns: tuple[Turn, ...]) -> Request:
        fixed = TextContent(system, is_fixed=True)
        return Request(self.model, fixed, turns, self.max_tokens, self.thinking, self.effort, self.grammar)


@dataclass(frozen=True, slots=True)
class SamplePlan:
    """How often a sample is mended and improved."""

    repairs: int = 3
    critiques: int = 0


def sample_steps(brief: Brief, reader: AnswerReader, speaker: Speaker, plan: SamplePlan) -> Steps:
    """One sample. Raises SceneError, such as ``model-refusal`` and what is thrown in for a request that cannot be
    answered, where that leaves it without a program that works."""
    best, answer = yield from _mended(brief, reader, speaker, plan, Purpose.DRAFT, (brief.first,))
    for _ in range(plan.critiques):
        shown = views(best.scene) if best.is_usable and best.scene is not None else []
        if not shown:
            break
        turns = (brief.first, said("assistant", answer), brief.critique(shown, _noticed(best)))
        try:
            better, improved = yield from _mended(brief, reader, speaker, plan, Purpose.CRITIQUE, turns, best)
        except SceneError as error:
            return SampleOutcome(best, error)
        if better is best or not better.is_usable or len(better.findings) > len(best.findings):
            break
        best, answer = better, improved
    return SampleOutcome(best)


def _noticed(verdict: Verdict) -> str:
    return "\n\n".join(render_text(d, color=False) for d in verdict.findings[:_MOST_FINDINGS])


def _mended(
    brief: Brief,
    reader: AnswerReader,
    speaker: Speaker,
    plan: SamplePlan,
    purpose: Purpose,
    turns: tuple[Turn, ...],
    kept: Verdict | None = None,
) -> Generator[Step, Reply | None, tuple[Verdict, str]]:
    """Ask, then have what is wrong mended; the last verdict and its answer. ``kept`` is the verdict that stays where
    the model says that nothing needs to change."""
    asked = turns
    for repair in range(plan.repairs + 1):
        reply, speaker = yield from _complete(speaker, brief.system, purpose if repair == 0 else Purpose.REPAIR, asked)
        if reply.stop is Stop.CUT:
            verdict = Verdict("", None, (_cut(speaker),))
            yield SampleProgress(verdict)
            asked = (*turns, *_shown(reply.text), brief.cut(speaker.max_tokens))
            continue
        if kept is not None and repair == 0 and _wants_nothing(reply.text):
            yield SampleProgress(kept)
            return kept, reply.text
        verdict = reader.read(reply.text)
        yield SampleProgress(verdict)
        if verdict.is_usable:
            return verdict, reply.text
        asked = (*turns, *_shown(reply.text), brief.repair(verdict.told()))
    return verdict, reply.text


def _shown(answer: str) -> tuple[Turn, ...]:
    """An answer as a turn; services take no empty ones."""
    return (said("assistant", answer),) if answer.strip() else (said("assistant", "(no text)"),)


def _wants_nothing(answer: str) -> bool:
    return answer.strip().strip(".*`\"'").upper() == NO_CHANGES


def _complete(
    speaker: Speaker, system: str, purpose: Purpose, turns: tuple[Turn, ...]
) -> Generator[Step, Reply | None, tuple[Reply, Speaker]]:
    """An answer that is complete, or cut at the greatest length that the model has; and the speaker that got it. One
    that broke off is asked for anew, one that was cut is asked for with more room."""
    broken = 0
    while True:
        reply = yield Ask(purpose, speaker.request(system, turns))
        assert reply is not None
        if reply.stop is Stop.REFUSED:
            note = f": {' '.join(reply.note.split())}" if reply.note else ""
            raise SceneError("model-refusal", f"the model declines to answer{note}", "word the task differently")
        if reply.stop is Stop.FULL:
            raise SceneError("model-answer", "the model's context is full", "give fewer pictures or a smaller program")
        if reply.stop is Stop.BROKEN:
            broken += 1
            if broken > _MOST_BROKEN:
                why = f": {reply.note}" if reply.note else ""
                raise SceneError("model-answer", f"the answer broke off {broken} times{why}")
            continue
        if reply.stop is Stop.CUT and speaker.max_tokens < speaker.most_tokens:
            speaker = replace(speaker, max_tokens=min(speaker.most_tokens, 2 * speaker.max_tokens))
            continue
        return reply, speaker


def _cut(speaker: Speaker) -> Diagnostic:
    return Diagnostic("model-answer", f"the answer was cut off after {speaker.max_tokens:,} tokens", None)


# The best of several samples: no errors, then the fewest findings in its geometry, then the model's eye.


_MOST_JUDGED = 9
_ANSWER = re.compile(r"BEST:\s*#?(\d+)", re.I)


def candidates(outcomes: Mapping[int, SampleOutcome]) -> list[int]:
    """The samples that are equally good by what can be counted."""
    usable = {sample: outcome.verdict for sample, outcome in outcomes.items() if outcome.verdict.is_usable}
    if not usable:
        return []
    fewest = min(len(verdict.findings) for verdict in usable.values())
    return [sample for sample, verdict in usable.items() if len(verdict.findings) == fewest]


def judge_steps(prompts: Prompts, speaker: Speaker, task: Task, verdicts: Sequence[Verdict]) -> Steps:
    """Asks the model which scene fulfils a task best, as a sample of its own, with the task's pictures; the outcome has
    the verdict that it chose, the first where it names none."""
    judged = verdicts[:_MOST_JUDGED]
    scenes = [verdict.scene for verdict in judged if verdict.scene is not None]
    try:
        sheet = contact_sheet(scenes)
    except SceneError:
        return SampleOutcome(judged[0])  # what cannot be drawn cannot be judged
    wanted = f"Reconstruct the scene of the pictures before. {task.text}".strip() if task.pictures else task.text
    text = prompts.text("judge.md", count=str(len(scenes)), task=wanted)
    turn = Turn("user", (*task.pictures, sheet, TextContent(text)))
    request = replace(speaker, grammar=None).request(prompts.text("judge.system.md"), (turn,))
    reply = yield Ask(Purpose.JUDGE, request)
    match = _ANSWER.search(reply.text) if reply is not None else None
    number = int(match[1]) if match is not None and len(match[1]) < 4 else 1
    return SampleOutcome(judged[number - 1 if 1 <= number <= len(judged) else 0])
