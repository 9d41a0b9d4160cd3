"""What the tools do: a program in, an answer out. A wrong program is an answer; a call that makes no sense raises
WrongArguments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from scenelang.backends.base import frame_of
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.entity import Scene, count_words
from scenelang.mcp.answers import MOST_ITEMS, Answer, answer, bounded_text, diagnosed, printed, refused
from scenelang.mcp.project import Program, Project, WrongArguments, wrong_arguments
from scenelang.sandbox.supervision import limited
from scenelang.scene_changes import TOLERANCE, change_lines, changes_between, sheets_in, sheets_of
from scenelang.summary import summary, summary_rows

if TYPE_CHECKING:
    from scenelang.backends.camera import Camera
    from scenelang.backends.viewpoint import Viewpoint
    from scenelang.interpreter.difference import Sheet
    from scenelang.session import Evaluated

LARGEST = 1024  # pixels of a picture's side
SIZE = 512
_MOST_WORDS = 200
_LONGEST_WORD = 200
_CHANGES_TOLD = 20


@dataclass(frozen=True, slots=True)
class View:
    """What a picture shows: a frame of a 4D scene (None: the first), from where, in how many pixels."""

    camera: str = ""
    frame: int | None = None
    width: int = SIZE
    height: int = SIZE


def check(project: Project, program: Program, geometry: bool) -> Answer:
    """Every error and warning; ``geometry`` evaluates the program and looks for odd overlaps and gaps too."""
    try:
        with limited(project.limits):
            session, source = project.opened(program)
            found = session.check_geometry(source) if geometry else session.check(source).diagnostics
    except SceneError as error:
        return refused([error.diagnostic])
    lines, data = diagnosed(found)
    ok = not any(diagnostic.is_error for diagnostic in found)
    return answer(lines or ["no errors and no warnings"], {"ok": ok, **data})


def run(project: Project, program: Program) -> Answer:
    """What the scene is: root, entities, instances, primitives, bounding box, frames, what the program printed."""

    def told(scene: Scene, result: Evaluated) -> Answer:
        facts = summary(scene)
        lines, data = diagnosed(result.diagnostics)
        said, log = printed(result.log)
        rows = [f"{name}: {value}" for name, value in summary_rows(facts)]
        return answer([*rows, *said, *lines], {"ok": True, **facts, **log, **data})

    return _of_scene(project, program, told)


def count(project: Project, program: Program, frame: int) -> Answer:
    """The instances of every word in a frame, in the order of first appearance."""

    def told(scene: Scene, _: Evaluated) -> Answer:
        counts = count_words(scene.frames[_frame(scene, frame)])
        shown = dict(islice(((word, n) for word, n in counts.items() if len(word) <= _LONGEST_WORD), _MOST_WORDS))
        left = len(counts) - len(shown)
        lines = [f"{n:,} {word}" for word, n in shown.items()] + ([f"... and {left:,} words more"] if left else [])
        data: dict[str, Any] = {"ok": True, "frame": frame, "counts": shown}
        return answer(lines, data | ({"counts_left_out": left} if left else {}))

    return _of_scene(project, program, told)


def render(project: Project, program: Program, view: View) -> Answer:
    """A draft picture of a frame."""
    camera = _camera(project, view.camera)

    def told(scene: Scene, result: Evaluated) -> Answer:
        from scenelang.backends import picture

        frame = _frame(scene, view.frame)
        warned = list(result.diagnostics)
        options = picture.PictureOptions(
            frame=frame,
            limit=project.limits.primitives,
            warn=warned.append,
            width=view.width,
            height=view.height,
            camera=camera,
        )
        png = picture.png_of(picture.render(scene, options))
        of = f", frame {frame} of {len(scene.frames)} (0 to {len(scene.frames) - 1})" if scene.animated else ""
        lines, _ = diagnosed(warned)
        return Answer(bounded_text([f"{scene.word}{of}, {view.width} x {view.height} pixels", *lines]), None, png)

    return _of_scene(project, program, told)


def diff(project: Project, a: Program, b: Program, tolerance: float = TOLERANCE) -> Answer:
    """What moved, was recoloured, is missing or new in B."""
    sides: list[list[Sheet]] = []
    for name, program in (("a", a), ("b", b)):
        try:
            side = _sheets(project, program)
        except WrongArguments as error:
            raise WrongArguments(f"scene {name.upper()}: {error}") from None
        if isinstance(side, Answer):
            return Answer(f"scene {name.upper()} is wrong:\n{side.text}", {"side": name, **(side.data or {})})
        sides.append(side)
    try:
        with limited(project.limits):
            found = changes_between(sides[0], sides[1], tolerance)
    except SceneError as error:
        return refused([error.diagnostic])
    data = found.data(MOST_ITEMS)
    left = len(found.changes) - MOST_ITEMS
    more = {"changes_left_out": left} if left > 0 else {}
    return answer(change_lines(found, _CHANGES_TOLD), {"ok": True, **data, **more})


def explain(name: str) -> Answer:
    """What a name of the language, a primitive, an attribute or a diagnostic is; without a name, the primer."""
    from scenelang.descriptions import description, known_names
    from scenelang.mcp.primer import primer_text

    asked = name.strip()
    if not asked:
        return Answer(primer_text())
    lines = description(asked)
    if not lines:
        hint = suggest(asked, known_names()) or "help without a name gives an overview"
        raise WrongArguments(f"there is nothing known of `{asked[:80]}`; {hint}")
    return Answer(bounded_text(lines))


# --- what they share -----------------------------------------------------------------------------------------------


def _of_scene(project: Project, program: Program, told: Callable[[Scene, Evaluated], Answer]) -> Answer:
    """What ``told`` says of the program's scene; its diagnostics where it has none, or where nothing can be said."""
    try:
        with limited(project.limits):
            session, source = project.opened(program)
            result = session.evaluate(source)
            if result.scene is None:
                return refused(result.diagnostics, result.log)
            return told(result.scene, result)
    except SceneError as error:
        return refused([error.diagnostic])


def _sheets(project: Project, program: Program) -> list[Sheet] | Answer:
    """The frames of a program or of a flattened scene (.json), or the answer that says why there are none."""
    limit = project.limits.primitives
    try:
        sheets = sheets_in(str(project.file(program.path)), limit) if program.path and not program.text else None
        if sheets is not None:
            return sheets
        with limited(project.limits):
            session, source = project.opened(program)
            result = session.evaluate(source)
            return refused(result.diagnostics, result.log) if result.scene is None else sheets_of(result.scene, limit)
    except SceneError as error:
        return refused([error.diagnostic])


def _frame(scene: Scene, frame: int | None) -> int:
    try:
        return frame_of(scene, frame)
    except SceneError as error:
        raise wrong_arguments(error) from None


def _camera(project: Project, text: str) -> Viewpoint | Camera:
    """What `--camera` understands; the file of a camera must lie in the project folder."""
    from scenelang.backends.viewpoint import parse_viewpoint

    asked = text.strip()
    try:
        return parse_viewpoint(str(project.file(asked)) if asked.lower().endswith(".json") else asked)
    except SceneError as error:
        raise wrong_arguments(error) from None
