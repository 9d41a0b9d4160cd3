"""What all exports share: their options, the parts that they write one file each of, files that come together."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from scenelang.backends.base import LOOKS, Accepts, Backend, Option, Options, Progress, Work, check_settings
from scenelang.backends.exports.items import Item, Plan, planned
from scenelang.backends.exports.timeline import Moving, matched
from scenelang.backends.files import written_together
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter import pose
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Entity, Scene
from scenelang.interpreter.values import ANONYMOUS, IDENTITY, Matrix, Pair

DEPTH = Option("depth", "merge what is below each entity of level N into one part; the root is level 0", None, least=0)
PARTS = Option("parts", "write one file for each part (of --depth 1 where none is given): OUT-001-word.ext", False)
FPS = Option("fps", "frames per second of a 4D scene", 24.0, least=0.01, most=1000.0)
INSTANCES = Option(
    "instance-limit",
    "nodes beyond which repeated parts are merged into shared meshes with vertex colours",
    100_000,
    least=1,
    most=1_000_000,
)
MOST_FILES = 10_000


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """What a writer makes a file of. ``limit`` bounds the primitives that are expanded."""

    plan: Plan
    fps: float = 24.0
    instances: int = 100_000
    limit: int = 2_000_000
    progress: Progress = field(default=lambda _: None)


Writer = Callable[[Job, Path], None]  # writes the file, and what belongs to it in the same folder


def mesh_backend(
    name: str,
    doc: str,
    endings: tuple[str, ...],
    write: Writer,
    animated: bool = False,
    options: tuple[Option, ...] = (),
    packages: tuple[str, ...] = (),
    install: str = "scenelang",
    attributes: tuple[str, ...] = LOOKS,
) -> Backend:
    """The backend that writes meshes with ``write``: ``--depth`` and ``--parts`` come by themselves."""

    def run(scene: Scene, path: Path, given: Options) -> list[Path]:
        return _export(made, write, scene, Path(path), given)

    accepts = Accepts(attributes=attributes, animated=animated)
    made = Backend(name, doc, Work.EXPORT, endings, run, (DEPTH, PARTS, *options), accepts, packages, install)
    return made


def _export(backend: Backend, write: Writer, scene: Scene, path: Path, options: Options) -> list[Path]:
    """Write the files, and give those that were asked for: one, or one for each part."""
    check_settings(options, [backend])
    depth, parts = backend.setting(options, "depth"), backend.setting(options, "parts")
    frame = options.frame if options.frame is not None or backend.accepts.animated else 0
    plan = planned(scene, frame, 1 if parts and depth is None else depth, options.limit, options.warn)
    named = {option.name for option in backend.options}
    job = Job(
        plan,
        fps=backend.setting(options, "fps") if "fps" in named else 24.0,
        instances=backend.setting(options, "instance-limit") if "instance-limit" in named else 100_000,
        limit=options.limit,
        progress=options.progress or (lambda _: None),
    )
    with written_together(path.parent) as folder:
        names = _write_parts(write, job, folder, path) if parts else [path.name]
        if not parts:
            write(job, folder / path.name)
    job.progress(1.0)
    return [path.parent / name for name in names]


def _write_parts(write: Writer, job: Job, folder: Path, path: Path) -> list[str]:
    found = list(parts_of(job.plan))
    if len(found) > MOST_FILES:
        raise LimitError("size", f"there are {len(found):,} parts, more than the {MOST_FILES:,} files of an export")
    digits = max(3, len(str(len(found))))
    names = []
    for number, plan in enumerate(found, start=1):
        name = f"{path.stem}-{number:0{digits}d}-{safe_name(plan.word)}{path.suffix}"
        quiet = replace(job, plan=plan, progress=lambda _: None)
        write(quiet, folder / name)
        names.append(name)
        job.progress(0.99 * number / len(found))
    return names


def safe_name(word: str) -> str:
    """``word`` as part of a file's name: letters, digits and dashes, never empty."""
    return re.sub(r"[^A-Za-z0-9]+", "-", word)[:60].strip("-") or "part"


# --- parts -----------------------------------------------------------------------------------------------------


def parts_of(plan: Plan) -> Iterator[Plan]:
    """One plan for each part with geometry: the leaves of the hierarchy, where they stand in the world, over time."""
    frames = len(plan.roots)
    stack: list[tuple[Moving, tuple[Matrix, ...]]] = [(matched(plan.roots), (IDENTITY,) * frames)]
    room = MOST_FILES
    while stack:
        moving, above = stack.pop()
        world = tuple(pose.compose(a, b) for a, b in zip(above, moving.filled_poses(), strict=True))
        children = moving.children if moving.fixed is None else _still_parts(moving)
        stack.extend((child, world) for child in reversed(children))
        leaves = [item if item is not None and item.is_leaf else None for item in moving.items]
        if any(item is not None and entity_box(item.entity) is not None for item in leaves):
            room -= 1
            if room < 0:
                raise LimitError("size", f"there are more than {MOST_FILES:,} parts, each of which would be a file")
            yield Plan(moving.word, tuple(_alone(moving.word, i, w) for i, w in zip(leaves, world)), plan.animated)


def _still_parts(moving: Moving) -> list[Moving]:
    """The parts of something that never changes, each in the frames that it is in."""
    item = moving.first
    return [
        Moving(
            child.word,
            tuple(child if shown else None for shown in moving.shown),
            tuple(place if shown else None for shown in moving.shown),
            child,
        )
        for child, place in item.parts
    ]


def _alone(word: str, item: Item | None, world: Matrix) -> Item:
    """A root with nothing but ``item`` in it."""
    if item is None:
        return Item(Entity(word, ANONYMOUS, ()))
    return Item(Entity(word, ANONYMOUS, (Pair(item.entity, world),)), ((item, world),))


def unsupported_frames(roots: Sequence[Item], ending: str) -> None:
    """Raises SceneError("unsupported") for several frames in a file that holds one."""
    if len(roots) > 1:
        raise SceneError("unsupported", f"a {ending} file holds one frame", hint="choose one with --frame N")
