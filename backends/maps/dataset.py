"""Sets of labelled pictures: where their files lie, what each holds, and going on where a run stopped.

One shot alone lies in the folder itself; of several each has a folder ``NAME/camera-000/frame-000``, without the parts
that there is only one of. Every shot's files are complete once its ``shot.json`` is there.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, part_of
from scenelang.backends.camera import Camera, camera_to_json
from scenelang.backends.files import write_json, written_together, written_whole
from scenelang.backends.maps import coco, motion
from scenelang.backends.maps.shot_files import FORMAT, VERSION, ShotMaps
from scenelang.backends.maps.truth import Truth, truth_of
from scenelang.backends.minecraft.cubes import as_cubes
from scenelang.backends.picture import Painter, PictureBackend, PictureOptions, painters
from scenelang.backends.shots import Shot, box_of, still
from scenelang.backends.stage import unit_size
from scenelang.backends.viewpoint import Viewpoint
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Scene
from scenelang.interpreter.numbering import frame_numbers, instance_handles


@dataclass(frozen=True, slots=True)
class MapOptions:
    """``pictures`` says size, light, backend settings, seed and limit; ``views`` are the cameras, of which
    those that are placed keep their own size unless ``resize``; ``tracks`` how many
    points of a 4D scene are followed; ``annotations`` how many instances of a shot COCO may list; ``digest`` tells the
    program and all that it was run with apart from others."""

    pictures: PictureOptions
    views: tuple[Viewpoint | Camera, ...]
    resize: bool = True
    tracks: int = 64
    annotations: int = 20_000
    digest: str = ""


@dataclass(frozen=True, slots=True)
class Item:
    """One shot to make: ``view`` and ``frame`` are numbers, ``folder`` is where it goes."""

    name: str
    view: int
    frame: int
    folder: Path


def items_of(folder: Path, name: str, scene: Scene, views: int, alone: bool, frame: int | None) -> list[Item]:
    """The shots of one scene, camera by camera; ``alone`` when it is the only scene of its set."""
    frames = range(len(scene.frames)) if frame is None else [frame]
    found = []
    for view in range(views):
        for number in frames:
            parts = [] if alone else [name]
            parts += [f"camera-{view:03d}"] if views > 1 else []
            parts += [f"frame-{number:03d}"] if len(frames) > 1 else []
            found.append(Item(name, view, number, folder.joinpath(*parts)))
    return found


def random_views(count: int, seed: int, like: Viewpoint) -> tuple[Viewpoint, ...]:
    """``count`` viewpoints all around and above a scene, the same for the same ``seed``."""
    random = np.random.default_rng(seed)
    azimuths, elevations = random.uniform(-180.0, 180.0, count), random.uniform(5.0, 65.0, count)
    pairs = zip(azimuths.tolist(), elevations.tolist(), strict=True)
    return tuple(replace(like, azimuth=azimuth, elevation=elevation) for azimuth, elevation in pairs)


def write_maps(
    scene: Scene,
    items: Sequence[Item],
    options: MapOptions,
    backend: PictureBackend,
    progress: Progress | None = None,
    skipped: Callable[[Item], None] | None = None,
) -> None:
    """Make the shots ``items`` of one scene that are not there yet; calls ``skipped`` for each that is.

    Raises SceneError, and leaves no shot half-written.
    """
    box_of(scene)  # an empty scene is told before anything is written
    scene = as_cubes(scene, options.pictures.limit, options.pictures.warn)  # what is labelled is what is drawn
    total = len(items)
    for view in dict.fromkeys(item.view for item in items):
        mine = [item for item in items if item.view == view]
        missing = [item for item in mine if not _is_done(item, options)]
        for item in mine:
            if item not in missing and skipped is not None:
                skipped(item)
        if missing:
            start = items.index(mine[0]) / total
            share = part_of(progress, start, start + len(mine) / total)
            _write_view(scene, mine, missing, options, backend, share)
    if progress is not None:
        progress(1.0)


def _is_done(item: Item, options: MapOptions) -> bool:
    """Whether a shot is complete and was made of the same program with the same options."""
    try:
        found = json.loads((item.folder / "shot.json").read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(found, dict) and found.get("digest") == _digest(item, options)


def _digest(item: Item, options: MapOptions) -> str:
    settings = replace(options.pictures, progress=None, warn=None, camera=Viewpoint())
    view = options.views[item.view]
    shown = json.dumps(camera_to_json(view)) if isinstance(view, Camera) else repr(view)
    own = (options.digest, options.resize, options.tracks, options.annotations)
    told = repr((FORMAT, VERSION, own, settings, shown, item.frame))
    return hashlib.sha256(told.encode()).hexdigest()


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """What the shots of one camera share."""

    scene: Scene
    options: MapOptions
    painter: Painter
    shots: dict[int, Shot]
    center: npt.NDArray[np.float64]
    scale: float
    paths: motion.PathNumbers
    numbers: dict[tuple[int, ...], int] | None  # of handles by path; None for a scene of one frame
    recent: dict[int, Truth] = field(default_factory=dict)

    def truth(self, frame: int) -> Truth:
        """The truth of a frame; the last two are kept, since every frame is compared with the next."""
        if frame not in self.recent:
            for old in list(self.recent)[: len(self.recent) - 1]:
                del self.recent[old]
            limit = self.options.pictures.limit
            self.recent[frame] = truth_of(self.scene, self.shots[frame], limit, self.center, self.scale)
        return self.recent[frame]


def _write_view(
    scene: Scene,
    items: Sequence[Item],
    missing: Sequence[Item],
    options: MapOptions,
    backend: PictureBackend,
    progress: Progress | None,
) -> None:
    camera = options.views[items[0].view]
    asked = replace(options.pictures, camera=camera)
    if isinstance(camera, Camera) and not options.resize:
        asked = replace(asked, width=camera.width, height=camera.height)
    shots = {item.frame: still(scene, asked.camera, item.frame, asked.width, asked.height) for item in items}
    (painter,) = painters(scene, asked, [backend], list(shots.values()))
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    view = _View(scene, options, painter, shots, *unit_size(scene), motion.PathNumbers(), numbers)
    tracks = _tracks(view) if len(shots) > 1 else None
    for i, item in enumerate(missing):
        following = item.frame + 1 if item.frame + 1 in shots else None
        _write_shot(view, item, following, tracks, part_of(progress, i / len(missing), (i + 1) / len(missing)))
    if tracks is not None:
        _write_tracks(items[0].folder.parent, tracks)


def _tracks(view: _View) -> motion.Tracks:
    """The ways of points that the first frame shows, through all frames of a camera."""
    places: motion.Places | None = None
    found = []
    for frame in view.shots:
        truth = view.truth(frame)
        paths = view.paths.of(truth.ancestry)
        if places is None:
            places = motion.start_places(truth, paths, view.options.tracks, view.options.pictures.seed)
        found.append(motion.found_in(places, truth, paths))
    return motion.tracks_of(found)


def _write_tracks(folder: Path, tracks: motion.Tracks) -> None:
    with written_whole(folder / "tracks.npz") as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, pixels=tracks.pixels, world=tracks.world, state=tracks.state)


# --- one shot --------------------------------------------------------------------------------------------------


def _write_shot(
    view: _View, item: Item, following: int | None, tracks: motion.Tracks | None, progress: Progress | None
) -> None:
    picture = view.painter.paint(view.shots[item.frame], part_of(progress, 0.0, 0.7)).picture
    maps = ShotMaps(view.truth(item.frame), picture)
    if following is not None:
        there = view.truth(following)
        paths = view.paths.of(maps.truth.ancestry), view.paths.of(there.ancestry)
        maps.add_flow(motion.flow_between(maps.truth, there, *paths))
    if tracks is not None:
        maps.add_tracks(tracks, list(view.shots).index(item.frame), view.paths.of(maps.truth.ancestry))
    handles = instance_handles(view.scene, maps.truth.ancestry, view.numbers)
    shot = {"format": FORMAT, "version": VERSION, "name": item.name, "camera": item.view, "frame": item.frame}
    _make_anew(item.folder)
    with written_together(item.folder) as target:
        maps.write(target, handles, view.options.annotations)
    write_json(item.folder / "shot.json", shot | {"digest": _digest(item, view.options)})
    if progress is not None:
        progress(1.0)


# --- files -----------------------------------------------------------------------------------------------------


def _make_anew(folder: Path) -> None:
    """A folder that does not count as complete."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "shot.json").unlink(missing_ok=True)
    except OSError as error:
        raise SceneError("file", f"`{folder}` cannot be written: {error.strerror or error}") from error


def write_coco(folder: Path, items: Sequence[Item]) -> None:
    """``coco.json`` of all shots of a set, from what each wrote; raises SceneError."""
    images, annotations = [], []
    for item in items:
        camera = json.loads((item.folder / "camera.json").read_text("utf-8"))
        name = (item.folder / "color.png").relative_to(folder).as_posix()
        size = {"width": camera["width"], "height": camera["height"]}
        images.append({"file_name": name, **size, "scene": item.name, "camera": camera, "frame": item.frame})
        annotations.append(json.loads((item.folder / "annotations.json").read_text("utf-8")))
    write_json(folder / "coco.json", coco.dataset(images, annotations))
