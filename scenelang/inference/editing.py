"""Editing a scene by an instruction: the program goes to the model and comes back changed (the paper, appendix
"Scene Editing"); what the edit did is told as differences of text, of things, and in pictures."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Source
from scenelang.inference.answers import Verdict, geometry_findings, has_blocks
from scenelang.inference.listing import listing, program_of
from scenelang.inference.task import Ablation, Kind, Notation, Task
from scenelang.interpreter.entity import Scene
from scenelang.interpreter.library import STD
from scenelang.interpreter.program import Program
from scenelang.interpreter.transpile.response import code_of, find_code
from scenelang.scene_changes import Changes, changes_between, paired_by_path, sheets_of
from scenelang.session import Options, Session, is_python, is_scene_file

if TYPE_CHECKING:
    from scenelang.backends.picture import Picture
    from scenelang.inference.inference import Result

_SIZE = 512


@dataclass(frozen=True, slots=True)
class Edit:
    """``text`` is the unified difference of the programs, as the model was sent and as it wrote them."""

    text: str
    changes: Changes


def edit_task(source: Source, scene: Scene, instruction: str, ablation: Ablation, seed: int) -> Task:
    """The task of changing the program ``source``, which makes ``scene``. Raises SceneError for a scene that is no
    program, or too large for a list."""
    if is_scene_file(source):
        hint = "edit the program that made it, or try --ablate P on that"
        raise SceneError("unsupported", f"{source.name} is a finished scene, which has no program to edit", hint)
    if ablation.takes_program:
        program, notation = listing(scene, not ablation.takes_words), Notation.LIST
    elif is_python(source):
        program, notation = code_of(source.text), Notation.PYTHON
    else:
        program, notation = source.text, Notation.LANGUAGE
    return Task(instruction, kind_of(scene), notation, ablation, (), program, seed)


def imported_files(program: Program | None) -> frozenset[Path]:
    """The files that a program imports: an edit of it may import these and no others."""
    sources = program.sources if program is not None else ()
    return frozenset(Path(source.name).resolve() for source in sources if not source.name.startswith((STD, "<")))


def kind_of(scene: Scene) -> Kind:
    """What a scene is."""
    if scene.animated:
        return Kind.FILM
    return Kind.BLOCKS if has_blocks(scene) else Kind.STILL


def scene_before(path: Path, task: Task, options: Options) -> Scene:
    """The scene of the program that is edited, as it was sent. Raises SceneError where that makes none any more."""
    assert task.program is not None
    if task.notation is Notation.LIST:
        source = Source(str(path), program_of(task.program, task.text))
    else:
        source = Source(str(path.with_suffix(".py") if task.notation is Notation.PYTHON else path), task.program)
    scene = Session(options).evaluate(source).scene
    if scene is None:
        raise SceneError("run", f"the program of {path} makes no scene any more, so there is nothing to compare with")
    return scene


def edit_of(name: str, task: Task, before: Scene, after: Verdict, limit: int) -> Edit:
    """What an edit did. Raises SceneError for scenes of more than ``limit`` primitives."""
    assert after.scene is not None
    assert task.program is not None
    written = listing(after.scene, task.ablation is Ablation.P) if task.notation is Notation.LIST else after.code
    lines = difflib.unified_diff(
        task.program.splitlines(), written.splitlines(), f"{name} before", f"{name} after", lineterm=""
    )
    changes = changes_between(sheets_of(before, limit), sheets_of(after.scene, limit))
    return Edit("\n".join(lines), paired_by_path(changes))


def without_known(result: Result, before: Scene) -> Result:
    """A result without what was odd about the scene's geometry before the edit already."""
    known = {finding.message for finding in geometry_findings(before)}
    findings = tuple(finding for finding in result.best.findings if finding.message not in known)
    return replace(result, best=replace(result.best, findings=findings))


def written_as(path: Path, task: Task, after: Verdict) -> str:
    """The edited program as the file ``path`` holds it: in the notation of the edit where its ending says so."""
    if task.notation is Notation.LANGUAGE:
        return after.code
    if task.notation is Notation.PYTHON and path.suffix == ".py":
        return after.code
    if task.notation is Notation.PYTHON and path.suffix == ".txt":
        return _in_response(path, after.code)
    return after.program


def _in_response(path: Path, code: str) -> str:
    """The response that a file holds with other code in it; a new file has the code alone."""
    text = path.read_text("utf-8") if path.exists() else ""
    found = find_code(text)
    if not text[: found.start].strip():
        return f"```python\n{code}```\n"
    return text[: found.start] + code + text[found.end :]


def before_and_after(before: Scene, after: Scene) -> Picture:
    """Both scenes from one camera, side by side, (H, 2 W, 3): from where the larger one is seen whole. Raises
    SceneError for a scene that cannot be drawn."""
    from scenelang.backends.film import side_by_side
    from scenelang.backends.picture import PictureOptions, render
    from scenelang.backends.shots import box_of, still
    from scenelang.backends.viewpoint import Viewpoint

    scenes = (before, after)
    larger = max(scenes, key=lambda scene: float((box_of(scene)[1] - box_of(scene)[0]).max()))
    camera = still(larger, Viewpoint(), None, _SIZE, _SIZE).camera
    frame = min(len(scene.frames) for scene in scenes) // 2
    pictures = []
    for scene in scenes:
        options = PictureOptions(width=_SIZE, height=_SIZE, camera=camera, frame=frame if scene.animated else None)
        pictures.append(render(scene, options))
    return side_by_side(pictures)
