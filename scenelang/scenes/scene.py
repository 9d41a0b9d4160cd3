"""Scenes of the Python API, as returned by ``scenelang.load`` and ``scenelang.evaluate``, and their results.

A ``Scene`` is immutable and can be shared between threads. Arrays are NumPy arrays, angles are in degrees, lengths in
scene units, and the world is right-handed with +y up. Methods raise ``SceneError``, whose text shows the code, the
position, the source line and a hint.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import BackendOptions, Progress, frame_of
from scenelang.backends.pictures.camera import Camera as PlacedCamera
from scenelang.backends.pictures.camera import Viewpoint, camera_at
from scenelang.grammar.datum import Source, atom_text
from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest
from scenelang.grammar.settings import fits, typed
from scenelang.interpreter.inspection.instance_paths import Locator, is_plain, part_of, selected
from scenelang.interpreter.runtime.show import plain_attributes
from scenelang.interpreter.scene.bounds import parts_box
from scenelang.interpreter.scene.entity import Entity, count_words, descendants, primitive_count
from scenelang.interpreter.scene.entity import Scene as SceneGraph
from scenelang.interpreter.values.values import Pair
from scenelang.session.declarations import declarations_of
from scenelang.session.materials import look_value, restyled
from scenelang.session.motion import MAX_SPEED, checked_scale

if TYPE_CHECKING:
    from scenelang.backends.geometry.relations import Violation
    from scenelang.backends.labels.ground_truth import Tracks
    from scenelang.backends.labels.views import LabelledView
    from scenelang.backends.physics.verdicts import PhysicsReport
    from scenelang.backends.pictures.film import Painter, PictureBackend, PictureOptions
    from scenelang.backends.pictures.stage import Shot
    from scenelang.grammar.datum import Span
    from scenelang.interpreter.checker.program import Program
    from scenelang.interpreter.scene.modelling.measuring import Measures
    from scenelang.session.scene_changes import Changes
    from scenelang.session.session import Evaluated, Options

FloatArray = npt.NDArray[np.float64]
Size = tuple[int, int]
View = Viewpoint | PlacedCamera
_VIEW_NUMBERS = {
    "azimuth": "float", "elevation": "float", "fov": "float", "aperture": "float",
    "distance": "float | None", "orbit": "float | None", "focus": "float | None",
}  # fmt: skip
Warn = Callable[[Diagnostic], None]


@dataclass(frozen=True, slots=True)
class Camera(Viewpoint):
    """A camera; omitted parameters are chosen to frame the whole scene.

    Parameters
    ----------
    azimuth, elevation : float
        Direction of the camera from its target, in degrees. At azimuth 0 it looks from +z towards -z; a positive
        azimuth moves it towards +x, a positive elevation upwards.
    distance : float, optional
        Distance from the eye to ``target``, in scene units.
    fov : float
        Vertical field of view in degrees.
    target : (x, y, z), optional
        Point at the center of the image.
    orthographic : bool
        Use a parallel projection.
    aperture, focus : float
        Lens radius (0: pinhole camera) and focus distance, in scene units.

    Examples
    --------
    >>> Camera(azimuth=40, elevation=20)
    Camera(azimuth=40, elevation=20)
    """

    def __post_init__(self) -> None:
        for name, annotation in _VIEW_NUMBERS.items():
            value = getattr(self, name)
            if not fits(value, annotation):
                raise SceneError("value", f"`{name}`: expected a finite number, got {value!r}")
        if self.target is not None and (len(self.target) != 3 or not all(fits(x, "float") for x in self.target)):
            raise SceneError("value", f"`target`: expected three finite numbers, got {self.target!r}")

    def __repr__(self) -> str:
        default = Viewpoint()
        names = Viewpoint.__dataclass_fields__
        given = [f"{n}={getattr(self, n)!r}" for n in names if getattr(self, n) != getattr(default, n)]
        return f"Camera({', '.join(given)})"

    @typed
    def random(self, count: int, seed: int = 0) -> list[Camera]:
        """Return ``count`` random cameras around and above a scene, which have this one's other settings.

        Examples
        --------
        >>> [round(camera.azimuth) for camera in Camera(fov=50).random(3)]
        [49, -83, -165]
        """
        from scenelang.backends.labels.views import views_of

        return [Camera(**{name: getattr(view, name) for name in Viewpoint.__dataclass_fields__})
                for view in views_of([self], count, seed)]  # fmt: skip

    @staticmethod
    @typed
    def from_pose(
        camera_to_world: npt.ArrayLike,
        fov: float = 35.0,
        *,
        size: Size = (512, 512),
        convention: Literal["opengl", "opencv"] = "opengl",
    ) -> PlacedCamera:
        """Create a camera at a given pose.

        Parameters
        ----------
        camera_to_world : (4, 4) array
            A rotation and a translation. In the "opengl" convention (trimesh, NeRF, Blender) the camera looks along
            its -z axis with +y up; in the "opencv" convention (COLMAP) along +z with +y down.
        fov : float
            Vertical field of view in degrees.
        size : (width, height)
            Image size in pixels. At another size the vertical field of view is preserved.

        Raises
        ------
        SceneError
            If the pose is not rigid, or the field of view is not between 0 and 180 degrees.

        Examples
        --------
        >>> import numpy as np
        >>> pose = np.eye(4)
        >>> pose[2, 3] = 10
        >>> Camera.from_pose(pose).eye
        array([ 0.,  0., 10.])
        """
        pose = np.asarray(camera_to_world, np.float64)
        if pose.shape != (4, 4) or not np.isfinite(pose).all() or not (pose[3] == [0, 0, 0, 1]).all():
            raise SceneError("value", "expected a camera pose as a 4 x 4 matrix with the last row [0 0 0 1]")
        rotation = pose[:3, :3]
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-4 or np.linalg.det(rotation) < 0.0:
            raise SceneError("value", "expected a rigid camera pose: a rotation and a translation")
        if not 0.0 < fov < 180.0:
            raise SceneError("value", f"expected a field of view between 0 and 180 degrees, got {fov:g}")
        sign = 1.0 if convention == "opengl" else -1.0
        axes = (rotation[:, 0], sign * rotation[:, 1], -sign * rotation[:, 2])
        width, height = size
        focal = height / (2.0 * np.tan(np.radians(fov) / 2.0))
        return camera_at(pose[:3, 3], axes, float(focal), width, height)


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A rendered image.

    Attributes
    ----------
    pixels : (H, W, 4) uint8
        sRGB with an opaque alpha channel.
    radiance : (H, W, 3) float32
        Linear sRGB radiance, without labels.
    camera : PlacedCamera
        Camera of the image: ``intrinsics`` (3, 3), ``world_to_camera`` (4, 4), ``project``.
    """

    pixels: npt.NDArray[np.uint8]
    radiance: npt.NDArray[np.float32]
    camera: PlacedCamera

    @property
    def size(self) -> Size:
        """Width and height in pixels."""
        return self.pixels.shape[1], self.pixels.shape[0]

    @typed
    def save(self, path: str | Path) -> Path:
        """Write a .png, .jpg or .webp, or the radiance as .exr, atomically. Returns the path."""
        from scenelang.backends.pictures import film

        film.save_image(film.Image(np.ascontiguousarray(self.pixels[:, :, :3]), self.radiance), path)
        return Path(path)

    @typed
    def beside(self, *others: Image) -> Image:
        """Concatenate this image with others of the same height in a row; ``camera`` is that of the first."""
        images = (self, *others)
        if len({image.size[1] for image in images}) > 1:
            raise SceneError("value", "expected images of the same height")
        pixels = np.concatenate([image.pixels for image in images], axis=1)
        return Image(pixels, np.concatenate([image.radiance for image in images], axis=1), self.camera)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.pixels, dtype) if not copy else np.array(self.pixels, dtype)

    def _repr_png_(self) -> bytes:
        from scenelang.backends.pictures.film import png_of

        return png_of(np.ascontiguousarray(self.pixels[:, :, :3]))

    def __repr__(self) -> str:
        return f"<Image {self.size[0]} x {self.size[1]}>"


@dataclass(frozen=True, slots=True, eq=False)
class Film:
    """A video that is rendered lazily, when it is iterated or saved.

    Attributes
    ----------
    cameras : tuple of PlacedCamera
        One camera for each frame.
    """

    scene: Scene = field(repr=False)
    _options: PictureOptions = field(repr=False)
    _quality: str | Sequence[str] = field(repr=False)
    _shots: tuple[Shot, ...] = field(repr=False)

    def __len__(self) -> int:
        return len(self._shots)

    @property
    def cameras(self) -> tuple[PlacedCamera, ...]:
        return tuple(shot.camera for shot in self._shots)

    def __iter__(self) -> Iterator[Image]:
        from scenelang.backends.pictures.film import paint_shot

        painters = self._painters()
        for shot in self._shots:
            yield _image(paint_shot(painters, shot), shot.camera)

    @typed
    def save(self, path: str | Path, fps: float = 24.0, progress: Progress | None = None) -> Path:
        """Render and write an .mp4, .gif, .apng or .webp, atomically. Returns the path."""
        from scenelang.backends.pictures import film

        film.save_film(self._painters(), self._shots, Path(path), fps, progress)
        return Path(path)

    def _painters(self) -> list[Painter]:
        from scenelang.backends.pictures.film import painters

        return painters(self.scene.graph, self._options, _backends(self._quality), self._shots)

    def __repr__(self) -> str:
        return f"<Film of {len(self):,} pictures>"


@dataclass(frozen=True, slots=True, eq=False)
class Primitives:
    """The primitives of a frame as arrays, in depth-first order.

    Attributes
    ----------
    matrix : (N, 4, 4) float64
        World matrix of each primitive.
    word, handle, shape : (N,) object
        Strings; ``shape`` is "cube", "sphere", ..., or "box" for a word without a defined geometry.
    path : (N,) object
        Tuples of words from the root to the primitive's parent.
    color : (N, 3) float64
        Linear sRGB.
    entity : tuple of Entity
        Entity of each primitive; repeated primitives share one.
    """

    matrix: FloatArray
    word: npt.NDArray[np.object_]
    path: npt.NDArray[np.object_]
    handle: npt.NDArray[np.object_]
    shape: npt.NDArray[np.object_]
    color: FloatArray
    entity: tuple[Entity, ...] = field(repr=False)

    def __len__(self) -> int:
        return len(self.matrix)

    @typed
    def attribute(self, name: str, default: Any = None) -> npt.NDArray[np.object_]:
        """Return the attribute ``name`` of each primitive (N,), with the defaults of its geometry filled in.

        Examples
        --------
        >>> import scenelang as sl
        >>> sl.evaluate('(bind "a" (lambda () (call "sphere" :radius 2)))').flatten().attribute("radius")
        array([2.0], dtype=object)
        """
        from scenelang.interpreter.runtime.show import primitive_attributes

        found = {id(e): primitive_attributes(e).get(name, default) for e in {id(e): e for e in self.entity}.values()}
        return _objects([found[id(entity)] for entity in self.entity])

    def __getitem__(self, mask: Any) -> Primitives:
        """Return the primitives selected by a mask (N,) or by indices."""
        rows = np.arange(len(self))[mask].reshape(-1)
        entity = tuple(self.entity[i] for i in rows.tolist())
        return Primitives(
            self.matrix[rows],
            self.word[rows],
            self.path[rows],
            self.handle[rows],
            self.shape[rows],
            self.color[rows],
            entity,
        )

    def __repr__(self) -> str:
        words = len(set(self.word.tolist()))
        return f"<Primitives: {len(self):,} of {words:,} {'word' if words == 1 else 'words'}>"


class Maps(Mapping[str, npt.NDArray[Any]]):
    """Ground-truth maps of a rendered image, as a mapping from names to arrays (H, W, ...).

    ``color`` is the image (H, W, 3) uint8. ``instance`` contains instance ids (-1: background), ``semantic`` word ids
    (0: background, see ``words``), ``depth`` the distance along the viewing axis in scene units (infinity: background),
    ``normal`` and ``position`` are in world space, ``albedo`` is linear sRGB. 4D scenes also have ``flow`` (pixels to
    the next frame), ``path`` and ``local``, which are equal where two frames show the same point. ``list(maps)`` lists
    all of them (docs/maps.md).
    """

    def __init__(self, scene: Scene, options: PictureOptions, frame: int, tracked: int, image: Image) -> None:
        from scenelang.backends.labels.dataset import ShotMaps

        self.image = image
        self.graph = scene.graph
        self._scene, self._options, self._frame, self._tracked = scene, options, frame, tracked
        view = self._view(range(frame, min(frame + 2, len(scene.graph.frames))))
        self.truth = view.truth(frame)
        self.camera = self.truth.camera
        self._maps = ShotMaps(self.truth, np.ascontiguousarray(image.pixels[:, :, :3]))
        if scene.animated:
            self._maps.add_identities(view.paths(frame))
        flow = view.flow(frame)
        if flow is not None:
            self._maps.add_flow(flow)
        self._arrays: dict[str, npt.NDArray[Any]] = {"color": image.pixels[:, :, :3], **self._maps.arrays}

    def _view(self, frames: Sequence[int]) -> LabelledView:
        """Return what the camera sees of some frames."""
        from scenelang.backends.labels.views import LabelledView, SceneFacts

        facts = SceneFacts(self.graph)
        facts.number_paths(frames[-1] + 1)
        return LabelledView(facts, self._options, frames, self._tracked)

    @cached_property
    def tracks(self) -> Tracks | None:
        """Trajectories, through all frames, of points that are visible in the first one; None for a single frame."""
        return self._view(range(len(self.graph.frames))).tracks

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    @property
    def words(self) -> dict[int, str]:
        """Mapping from ids in ``semantic`` to words."""
        from scenelang.backends.labels.dataset import word_numbers

        return {number: word for word, number in word_numbers(self.truth).items()}

    @cached_property
    def _handles(self) -> list[str]:
        from scenelang.interpreter.inspection.numbering import frame_numbers, instance_handles

        graph = self._scene.graph
        numbers = frame_numbers(graph) if len(graph.frames) > 1 else None
        return instance_handles(graph, self.truth.ancestry, numbers)

    @typed
    def annotations(self, limit: int = 20_000) -> list[dict[str, Any]]:
        """Return the visible instances as COCO annotations, at most ``limit``, highest in the hierarchy first.

        Fields: ``category``, ``bbox``, ``area``, ``segmentation``, ``box3d``, ``handle``, ``path`` (docs/maps.md).
        """
        from scenelang.backends.labels.dataset import annotations_of

        return annotations_of(self.truth, self._maps.boxes, self._handles, limit)

    @typed
    def coco(self, limit: int = 20_000) -> dict[str, Any]:
        """Return a COCO document of this image, as JSON-serializable data."""
        from scenelang.backends.labels.dataset import dataset

        image = {"file_name": "color.png", "width": self.camera.width, "height": self.camera.height}
        return dataset([image], [self.annotations(limit)])

    @typed
    def mask(self, word: str) -> npt.NDArray[np.bool_]:
        """Return the mask (H, W) of the pixels that show an entity of ``word`` or one of its parts."""
        self._scene._require(word)
        found = np.zeros(self["instance"].shape, bool)
        ancestry = self.truth.ancestry
        own = np.array([entity.word == word for entity in ancestry.nodes], bool)
        for level in self["instance_by_depth"]:
            found |= (level >= 0) & own[ancestry.node[np.maximum(level, 0)]]
        return found

    @typed
    def crops(self, word: str | None = None, margin: float = 0.1) -> list[Image]:
        """Crop square images of single instances, as input for CLIP.

        Parameters
        ----------
        word : str, optional
            Word of the instances; None selects every visible instance below the root.
        margin : float
            Margin around the instance's box, as a fraction of its longer side.
        """
        if word is not None:
            self._scene._require(word)
        if margin < 0.0:
            raise SceneError("value", f"`margin`: expected at least 0, got {margin:g}")
        found = [a for a in self.annotations() if (a["category"] == word if word else a["depth"] > 0)]
        return [_crop(self.image, annotation["bbox"], margin) for annotation in found]

    @typed
    def save(self, folder: str | Path, annotations: int = 20_000) -> Path:
        """Write all maps to a new or existing folder as PNG, NPZ, EXR and JSON (docs/maps.md). Returns it.

        ``annotations`` is the maximum number of annotated instances. Trajectories are written for 4D scenes.
        """
        from scenelang.backends.files import new_folder, write_json
        from scenelang.backends.labels.dataset import write_tracks

        with new_folder(Path(folder)) as target:
            if self.tracks is not None:
                self._maps.add_tracks(self.tracks, self._frame)
                write_tracks(target, self.tracks)
            self._maps.write(target, self._handles, annotations)
            write_json(target / "coco.json", self.coco(annotations))
        return target

    def __repr__(self) -> str:
        return f"<Maps {self.camera.width} x {self.camera.height}: {', '.join(self)}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ViewerPage:
    """The interactive viewer as a self-contained HTML page; notebooks display it in an iframe."""

    html: str
    height: int

    @typed
    def save(self, path: str | Path) -> Path:
        """Write the page to a file. Returns the path."""
        from scenelang.backends.files import write_text

        write_text(path, self.html)
        return Path(path)

    def _repr_html_(self) -> str:
        from scenelang.backends.viewer.packet import iframe

        return iframe(self.html, self.height)

    def __repr__(self) -> str:
        return f"<ViewerPage of {len(self.html):,} characters>"


@dataclass(frozen=True, slots=True, eq=False)
class SceneInstance:
    """An instance of a scene.

    Attributes
    ----------
    path
        The path that means this instance only, such as "chair[1]/leg[2]".
    handle
        Its handle, such as "z3".
    word
        Its word.
    pose : (4, 4) float64
        Its pose in the scene.
    box : (2, 3) float64 or None
        Its exact bounding box in the scene, low corner first; None without geometry.
    attributes
        The attributes of its embedding, as JSON data.
    entity
        The entity, which equal instances share.
    definition, place
        Where the program binds the word, and where it calls the instance, or its first primitive; None if unknown.
    """

    path: str
    handle: str
    word: str
    pose: FloatArray
    box: FloatArray | None
    attributes: dict[str, Any]
    entity: Entity
    definition: Span | None
    place: Span | None

    def data(self) -> dict[str, Any]:
        """Return the instance as JSON data."""
        box = None if self.box is None else self.box.tolist()
        data = {"path": self.path, "handle": self.handle, "word": self.word, "pose": self.pose[:3].tolist(), "box": box}
        if self.attributes:
            data["attributes"] = self.attributes
        for name, span in (("defined", self.definition), ("called", self.place)):
            if span is not None:
                data[name] = {"file": span.source.name, "line": span.source.position(span.start)[0]}
        return data

    def __repr__(self) -> str:
        return f"<SceneInstance {self.path}>"


@dataclass(frozen=True, slots=True, eq=False)
class MovedScene:
    """A scene whose bodies have moved under gravity.

    Attributes
    ----------
    scene : Scene
        The scene at rest, or a 4D scene of its motion.
    report : PhysicsReport
        What became of each body.
    """

    scene: Scene
    report: PhysicsReport

    def __repr__(self) -> str:
        moved = sum(body.kind != "rests" for body in self.report.bodies)
        return f"<MovedScene: {moved:,} of {len(self.report.bodies):,} bodies moved>"


@dataclass(frozen=True, slots=True)
class SceneRelation:
    """A relation that holds between two things.

    Attributes
    ----------
    relation : str
        "on", "inside", "touching" or "overlapping".
    subject, other : str
        Handles of the two things, such as "z3".
    subject_word, other_word : str
        Their words.
    distance : float
        Signed distance of their surfaces in scene units, negative where they overlap.
    """

    relation: str
    subject: str
    other: str
    subject_word: str
    other_word: str
    distance: float


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A scene: one root entity, or one root entity per frame of a 4D scene.

    ``graph`` is the entity graph, ``log`` the lines printed by the program, and ``warnings`` the diagnostics of its
    evaluation.
    """

    graph: SceneGraph = field(repr=False)
    name: str = "<text>"
    log: tuple[str, ...] = field(default=(), repr=False)
    warnings: tuple[Diagnostic, ...] = field(default=(), repr=False)
    program: Program | None = field(default=None, repr=False)
    options: Options | None = field(default=None, repr=False)

    @staticmethod
    @typed
    def of(entity: Entity) -> Scene:
        """Create a scene from an entity, in the entity's local frame."""
        return Scene(SceneGraph(entity.word, [entity], False))

    # --- facts -------------------------------------------------------------------------------------------------

    @property
    def word(self) -> str:
        """Word of the root."""
        return self.graph.word

    @property
    def root(self) -> Entity:
        """Root entity of the first frame."""
        return self.graph.root

    @property
    def frames(self) -> tuple[Entity, ...]:
        """Root entity of each frame."""
        return self.graph.frames

    @property
    def animated(self) -> bool:
        """Whether the scene is 4D."""
        return self.graph.animated

    @property
    def words(self) -> list[str]:
        """Sorted words of all entities."""
        return sorted({entity.word for entity in descendants(*self.frames)})

    @property
    def params(self) -> dict[str, str]:
        """The program's params with the source text of their defaults."""
        return {} if self.program is None else {param.name: param.default for param in self.program.params}

    @property
    def bounds(self) -> FloatArray | None:
        """Exact axis-aligned bounding box (2, 3) of all frames, minimum corner first; None without geometry."""
        return self._box(None)

    @property
    def extents(self) -> FloatArray | None:
        """Extents (3,) of ``bounds``; None without geometry."""
        return None if (box := self.bounds) is None else box[1] - box[0]

    @typed
    def bounds_of(self, word: str) -> FloatArray | None:
        """Return the exact world-space bounding box (2, 3) of all entities of ``word``; None without geometry.

        ``word`` may be a path, such as ``chair/leg[2]``; see ``instances``.

        Raises
        ------
        SceneError
            If no entity has the word.
        """
        self._require(word)
        return self._box(word)

    def _require(self, word: str) -> None:
        if is_plain(word) and all(entity.word != word for entity in descendants(*self.frames)):
            raise SceneError("value", f'no entity has the word "{word}"', suggest(word, self.words))

    def _box(self, word: str | None) -> FloatArray | None:
        from scenelang.interpreter.inspection.instance_paths import box_of

        box = box_of(self.graph, word)
        return None if box is None else np.array(box, np.float64).reshape(2, 3)

    @typed
    def measure(self, word: str | None = None, frame: int = 0, limit: int = 100_000) -> Measures:
        """Return volume, surface, centre of mass and inertia of a frame, or of all entities of a word or path in it.

        What overlaps counts once; density is 1. A primitive that meets no other is measured exactly.

        Examples
        --------
        >>> import scenelang as sl
        >>> sl.evaluate('(bind "it" (lambda () (call "cube" :scale [1 2 3])))').measure().volume
        6.0

        Raises
        ------
        SceneError
            If no entity has the word, or something has no volume, such as Minecraft blocks.
        """
        from scenelang.interpreter.scene.modelling.measuring import measures_of

        if word is not None:
            self._require(word)
        if word is not None and not is_plain(word):
            return measures_of(selected(self.graph, word, frame_of(self.graph, frame)), None, limit)
        return measures_of(self._frame(frame), word, limit)

    @typed
    def count(self, frame: int = 0) -> dict[str, int]:
        """Return the number of instances of every word in a frame, in depth-first order of appearance."""
        return count_words(self._frame(frame))

    @typed
    def tree(self, depth: int | None = None, *, poses: bool = False, every: bool = False) -> str:
        """Return the hierarchy of the first frame as text, to ``depth`` below the root; ``every`` lists each part."""
        from scenelang.interpreter.inspection.outline import outline

        return "\n".join(outline(self.graph, depth, poses, every))

    @typed
    def tree_data(self, depth: int | None = None) -> dict[str, Any]:
        """Return the hierarchy of the first frame as JSON data."""
        from scenelang.interpreter.inspection.outline import outline_data

        return outline_data(self.graph, depth)

    @typed
    def flatten(self, frame: int = 0, limit: int = 5_000_000) -> Primitives:
        """Return the primitives of a frame with their world matrices.

        Raises
        ------
        LimitError
            If the scene expands to more than ``limit`` primitives.
        """
        from scenelang.interpreter.inspection.numbering import frame_handles
        from scenelang.interpreter.scene.flatten import flatten

        found = flatten(SceneGraph(self.word, [self._frame(frame)], False), limit).frames[0]
        handles = frame_handles(self.graph, frame, found)
        matrix = np.zeros((len(found), 4, 4))
        matrix[:, :3], matrix[:, 3, 3] = found.matrices, 1.0
        shapes = [entity.shape for entity in found.primitives]
        kinds = _objects(["" if shape is None else shape.word or "box" for shape in shapes])
        colors = np.array([shape.color if shape is not None else (1.0, 1.0, 1.0) for shape in shapes])
        index = found.index
        return Primitives(
            matrix,
            _objects([entity.word for entity in found.primitives])[index],
            _objects(found.paths)[found.path_index],
            _objects([f"<{handle}>" for handle in handles]),
            kinds[index],
            colors.reshape(-1, 3)[index],
            tuple(found.primitives[i] for i in index.tolist()),
        )

    # --- variants ----------------------------------------------------------------------------------------------

    @typed
    def with_params(self, values: Mapping[str, Any]) -> Scene:
        """Evaluate the same program again with other values of its params, given as plain Python values.

        Raises
        ------
        SceneError
            If the scene has no program, the program has no such param, or the evaluation fails.
        """
        if self.program is None or self.options is None:
            raise SceneError("unsupported", "scenes loaded from JSON have no params")
        texts = {name: literal(value) for name, value in values.items()}
        options = replace(self.options, defines={**self.options.defines, **texts})
        return scene_of(self.program.main, options)

    @typed
    def restyled(
        self,
        word: str,
        *,
        color: Sequence[float] | str | None = None,
        roughness: float | None = None,
        metallic: float | None = None,
        opacity: float | None = None,
        emission: Sequence[float] | float | None = None,
        ior: float | None = None,
    ) -> Scene:
        """Return a copy of the scene with another material for all entities of ``word`` and their parts.

        Parameters
        ----------
        word : str
            A word of the scene.
        color : (r, g, b) or str, optional
            Linear sRGB from 0 to 1, a color name or a hex code.
        roughness, metallic, opacity, emission, ior : float, optional
            Material attributes (docs/language.md).

        Raises
        ------
        SceneError
            If no entity has the word.
        """
        self._require(word)
        look = {"color": color, "roughness": roughness, "metallic": metallic, "opacity": opacity}
        look |= {"emission": emission, "ior": ior}
        attributes = {name: look_value(name, value) for name, value in look.items() if value is not None}
        known: dict[tuple[int, bool], Entity] = {}
        frames = [restyled(root, word, attributes, known) for root in self.frames]
        return replace(self, graph=SceneGraph(self.word, frames, self.animated), program=None)

    @typed
    def frame(self, number: int) -> Scene:
        """Return one frame of a 4D scene as a static scene."""
        return replace(self, graph=SceneGraph(self.word, [self._frame(number)], False))

    # --- results -----------------------------------------------------------------------------------------------

    @typed
    def render(
        self,
        camera: View | None = None,
        *,
        size: Size | None = None,
        quality: str | Sequence[str] = "draft",
        frame: int | None = None,
        environment: str = "studio",
        ground: str | None = None,
        labels: bool = True,
        seed: int = 0,
        settings: Mapping[str, Any] | None = None,
        limit: int = 2_000_000,
        progress: Progress | None = None,
        warn: Warn | None = None,
    ) -> Image:
        """Render an image.

        Parameters
        ----------
        camera : Camera, optional
            Camera of the image; the default frames the whole scene.
        size : (width, height), optional
            Image size in pixels; default: 512 x 512, or the size of a placed camera.
        quality : str or sequence of str
            "draft", "final" (path traced), or the name of a rendering backend; several render side by side.
        frame : int, optional
            Frame of a 4D scene, counted from 0.
        environment, ground : str
            Environment light ("studio", "overcast", "sunny", "sunset", "night", "flat") and ground ("seamless",
            "none", "white", "dark", "meadow", "earth", "checker"; default: that of the environment).
        labels : bool
            Draw the words of semantic primitives onto their boxes.
        seed : int
            Random seed of the sampling; the same seed gives the same image.
        settings : mapping, optional
            Backend options by name, such as ``{"samples": 64}``; listed by ``scenelang backends -v``.
        limit : int
            Maximum number of primitives to expand.
        progress : callable, optional
            Called with a fraction from 0 to 1; an exception raised by it cancels the rendering.
        warn : callable, optional
            Called with a ``Diagnostic`` for content that cannot be rendered exactly.

        Raises
        ------
        SceneError
            If the scene is empty, a package is missing, or an argument is invalid.
        """
        options = _picture_options(
            camera, size, frame, environment, ground, labels, seed, settings, limit, progress, warn
        )
        return _drawn(self.graph, options, quality)[0]

    @typed
    def placed(self, camera: View | None = None, size: Size = (512, 512), frame: int = 0) -> PlacedCamera:
        """Return the camera that ``render`` would use, with its pose, intrinsics and projection."""
        from scenelang.backends.pictures.stage import still

        return still(self.graph, Viewpoint() if camera is None else camera, frame, *size).camera

    @typed
    def film(
        self,
        camera: View | None = None,
        *,
        frames: int | None = None,
        orbit: float | None = None,
        size: Size | None = None,
        quality: str | Sequence[str] = "draft",
        environment: str = "studio",
        ground: str | None = None,
        labels: bool = True,
        seed: int = 0,
        settings: Mapping[str, Any] | None = None,
        limit: int = 2_000_000,
        warn: Warn | None = None,
    ) -> Film:
        """Create a video of ``frames`` frames, rendered when it is saved or iterated.

        A static scene is shown on a turntable, a 4D scene frame by frame; ``orbit`` is the total camera rotation
        in degrees. The other arguments are those of ``render``.
        """
        from scenelang.backends.pictures.film import check
        from scenelang.backends.pictures.stage import film

        options = _picture_options(camera, size, None, environment, ground, labels, seed, settings, limit, None, warn)
        check(options, _backends(quality))
        shots = film(self.graph, options.camera, options.width, options.height, frames, orbit)
        return Film(self, options, quality, tuple(shots))

    @typed
    def maps(
        self,
        camera: View | None = None,
        *,
        size: Size | None = None,
        quality: str | Sequence[str] = "draft",
        frame: int | None = None,
        environment: str = "studio",
        ground: str | None = None,
        seed: int = 0,
        settings: Mapping[str, Any] | None = None,
        tracks: int = 64,
        limit: int = 2_000_000,
        progress: Progress | None = None,
        warn: Warn | None = None,
    ) -> Maps:
        """Render ground-truth maps (instances, words, depth, normals ...). The arguments are those of ``render``.

        ``tracks`` is the number of points of a 4D scene that ``Maps.tracks`` follows.
        """
        from scenelang.backends.minecraft.models import as_cubes

        options = _picture_options(
            camera, size, frame, environment, ground, True, seed, settings, limit, progress, warn
        )
        cubes = as_cubes(self.graph, limit, warn)  # the maps must match the rendered geometry
        image, shot = _drawn(cubes, options, quality)
        return Maps(replace(self, graph=cubes), replace(options, progress=None), shot.frame, tracks, image)

    @typed
    def export(
        self,
        path: str | Path,
        *,
        backend: str | None = None,
        frame: int | None = None,
        settings: Mapping[str, Any] | None = None,
        limit: int = 2_000_000,
        progress: Progress | None = None,
        warn: Warn | None = None,
    ) -> list[Path]:
        """Export the scene to a file, in the format given by the extension of ``path`` or with the named backend.

        Returns the files written: .glb .gltf .usda .usdz .obj .ply .stl .json .xml, Minecraft builds and more
        (docs/exports.md). Each file is written atomically.

        Raises
        ------
        SceneError
            If no backend writes such files, a package is missing, or the file cannot be written.
        """
        from scenelang.backends import base

        target = Path(path)
        chosen = base.find(backend) if backend is not None else base.for_file(target, base.Work.EXPORT)
        options = BackendOptions(frame, limit, progress, dict(settings or {}), warn)
        base.check_settings(options, [chosen])
        return list(chosen.run(self.graph, target, options) or [target])

    @typed
    def save_graph(
        self, path: str | Path, depth: int | None = None, frame: int | None = None, thumbnails: bool = False
    ) -> Path:
        """Write the dependency graph of words as an .svg drawing, as in the paper's Figure 2. Returns the path."""
        from scenelang.backends.pictures.call_graph import write_graph

        write_graph(self.graph, Path(path), frame, depth, thumbnails)
        return Path(path)

    @typed
    def html(
        self,
        *,
        splats: bool = False,
        distilled: str | Path | None = None,
        minecraft: bool = False,
        textures: str | Path | None = None,
        limit: int = 2_000_000,
    ) -> str:
        """Return the interactive viewer as a self-contained HTML page.

        Parameters
        ----------
        splats : bool
            Show Gaussians on the surfaces instead of solids.
        distilled : path, optional
            Show the Gaussians of a run folder of ``distill``.
        minecraft : bool
            Show a Minecraft build with the game's block models.
        textures : path, optional
            Resource pack or game file for ``minecraft`` (default: the installed game).
        """
        from scenelang.backends.viewer.packet import (
            SavedScene,
            distilled_splats,
            packet_of,
            self_contained_page,
            surface_splats,
        )

        if minecraft:
            from scenelang.backends.deepslate.backend import page_of_scene

            return page_of_scene(self.graph, str(textures or ""), limit).text
        drawn = surface_splats if splats else None
        shown = drawn if distilled is None else distilled_splats(Path(distilled))
        state: dict[str, Any] = {"name": self.word, "version": 1, "ok": True, "picture": 1}
        state |= {"diagnostics": [], "params": []}
        return self_contained_page([SavedScene(self.word, state, packet_of(self.graph, limit, splats=shown))])

    @typed
    def show(self, height: int = 520) -> ViewerPage:
        """Return the interactive viewer for a notebook cell; ``height`` is in pixels."""
        return ViewerPage(self.html(), height)

    @typed
    def diff(self, other: Scene, tolerance: float = 1e-5, limit: int = 2_000_000) -> Changes:
        """Return the changes from this scene to ``other``; see ``scenelang.diff``."""
        from scenelang.session.scene_changes import changes_between, compared_frames

        return changes_between(compared_frames(self.graph, limit), compared_frames(other.graph, limit), tolerance)

    def to_json(self) -> dict[str, Any]:
        """Return the scene as the JSON export has it (docs/exports.md), mesh paths relative to the current folder."""
        from scenelang.backends.exports.scene_json import scene_text

        data: dict[str, Any] = json.loads("".join(scene_text(self.graph, Path.cwd())))
        return data

    def _frame(self, number: int) -> Entity:
        return self.frames[frame_of(self.graph, number)]

    def _repr_png_(self) -> bytes | None:
        try:
            return self.render(size=(480, 360))._repr_png_()
        except SceneError:
            return None

    def __repr__(self) -> str:
        count = primitive_count(self.root)
        frames = f", {len(self.frames)} frames" if self.animated else ""
        return f'<Scene "{self.word}": {count:,} {"primitive" if count == 1 else "primitives"}{frames}>'

    @typed
    def instances(self, path: str, frame: int = 0, limit: int = 20_000) -> list[SceneInstance]:
        """Return the instances that a path means, in the order of the tree.

        Parameters
        ----------
        path : str
            Words from the root down, such as ``chair/leg[2]``: every outermost instance of "chair", and in each the
            third "leg". ``<z3>`` is the instance with a handle, ``*`` every direct part; a backslash escapes a
            character.
        frame : int
            Frame of a 4D scene, counted from 0.
        limit : int
            Maximum number of instances to return.

        Raises
        ------
        SceneError
            If the path is malformed, or there is no such instance.

        Examples
        --------
        >>> import scenelang as sl
        >>> pair = '(bind "pair" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
        >>> sl.evaluate(pair).instances("cube[1]")
        [<SceneInstance cube[1]>]
        """
        locator = Locator(self.graph, frame_of(self.graph, frame))
        words: Mapping[str, Span] = {} if self.program is None else self.program.words
        found = []
        for each in locator.find(path)[:limit]:
            pose = np.eye(4)
            pose[:3] = np.array(each.pose, np.float64).reshape(3, 4)
            box = parts_box((Pair(each.entity, each.pose),))
            found.append(
                SceneInstance(
                    locator.path(each.positions),
                    locator.handle(each.positions),
                    each.entity.word,
                    pose,
                    None if box is None else np.array(box, np.float64).reshape(2, 3),
                    plain_attributes(each.entity),
                    each.entity,
                    words.get(each.entity.word),
                    next((span for entity in descendants(each.entity) for span in entity.call_sites[:1]), None),
                )
            )
        return found

    @typed
    def part(self, path: str) -> Scene:
        """Return the scene of the instances that a path means, where they are in this scene; see ``instances``.

        Examples
        --------
        >>> import scenelang as sl
        >>> pair = '(bind "pair" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
        >>> sl.evaluate(pair).part("cube[1]").bounds[0].tolist()
        [0.5, -0.5, -0.5]
        """
        return replace(self, graph=part_of(self.graph, path), program=None)

    @typed
    def physics(
        self,
        frame: int = 0,
        *,
        seconds: float = 1.5,
        metres_per_unit: float | None = None,
        progress: Progress | None = None,
    ) -> PhysicsReport:
        """Simulate a frame under gravity and return which bodies rest, move, tip over, fall or explode.

        Parameters
        ----------
        frame : int
            Frame of a 4D scene, counted from 0.
        seconds : float
            Simulated time.
        metres_per_unit : float, optional
            Scale; by default the diagonal of the scene is 2 m.
        progress : callable, optional
            Called with a fraction from 0 to 1; an exception raised by it ends the simulation.

        Raises
        ------
        SceneError
            If the scene cannot be simulated, or the packages of ``scenelang[physics]`` are missing.
        """
        from scenelang.backends.physics.verdicts import report_of

        self._frame(frame)
        return report_of(self.graph, frame, seconds, checked_scale(metres_per_unit), progress)

    @typed
    def settle(
        self, *, seconds: float = 5.0, metres_per_unit: float | None = None, progress: Progress | None = None
    ) -> MovedScene:
        """Return the first frame with its bodies where they come to rest. The arguments are those of ``physics``."""
        from scenelang.backends.physics.settling import settled

        found = settled(self.graph, seconds, checked_scale(metres_per_unit), progress)
        return MovedScene(replace(self, graph=found.scene, program=None), found.report)

    @typed
    def simulate(
        self,
        *,
        seconds: float = 2.0,
        fps: float = 24.0,
        metres_per_unit: float | None = None,
        velocities: Mapping[str, Sequence[float]] | None = None,
        progress: Progress | None = None,
    ) -> MovedScene:
        """Return the motion of the first frame as a 4D scene of ``fps`` frames per second.

        ``velocities`` are initial velocities by word, (x, y, z) in scene units per second, of all bodies with that
        word on their path. The other arguments are those of ``physics``.
        """
        from scenelang.backends.physics.settling import simulated

        for word, velocity in (velocities or {}).items():
            if len(velocity) != 3 or not all(fits(x, "float") and abs(x) <= MAX_SPEED for x in velocity):
                expected = f"three numbers of at most {MAX_SPEED:g}"
                raise SceneError("value", f"`velocities`: expected {expected} for {word!r}, got {velocity!r}")
        if not 0.0 < fps <= 1000.0:
            raise SceneError("value", f"`fps`: expected a number above 0, at most 1000, got {fps:g}")
        graph, report = simulated(self.graph, seconds, fps, checked_scale(metres_per_unit), velocities, progress)
        return MovedScene(replace(self, graph=graph, program=None), report)

    @typed
    def violations(self, *declarations: str) -> list[Violation]:
        """Return the declarations that do not hold: those of the program, and the given ones about the whole scene.

        Parameters
        ----------
        declarations : str
            Each a declaration such as ``(on "cup" "table")``, or the path of a file of ``assert-that`` forms.

        Returns
        -------
        list of Violation
            In the order of frames; ``message`` says why, ``move`` is a translation in scene units that fixes it.

        Raises
        ------
        SceneError
            For a declaration that is malformed, whose words do not occur, or that has no meaning for a word.

        Examples
        --------
        >>> import scenelang as sl
        >>> scene = sl.evaluate('(bind "cup" (lambda () (call "cube")))')
        >>> scene.violations('(count "cup" 1)')
        []
        """
        from scenelang.backends.geometry.relations import violations as found_in
        from scenelang.session.session import Options, Session

        session = Session(self.options or Options())
        extra = [each for text in declarations for each in declarations_of(session, text)]
        return found_in(self.graph, extra)

    @typed
    def relations(
        self, words: str | Sequence[str] | None = None, frame: int = 0, limit: int = 20_000
    ) -> list[SceneRelation]:
        """Return the relations of things that touch or overlap: what is on, inside of, touching or overlapping what.

        Parameters
        ----------
        words : str or sequence of str, optional
            Words of the things; by default all that the program binds, and semantic primitives. Things are compared
            with those that have the same thing around them.
        frame : int
            Frame of a 4D scene, counted from 0.
        limit : int
            Most pairs of nearby things.

        Raises
        ------
        SceneError
            For a frame that does not exist, or too many pairs.

        Examples
        --------
        >>> import scenelang as sl
        >>> table, cup = '(call "cube")', '(transform (call "cup") (translate [0 .75 0]))'
        >>> text = f'(bind "cup" (lambda () (call "cube" :scale .5))) (bind "table" (lambda () (union {table} {cup})))'
        >>> [each.relation for each in sl.evaluate(text).relations()]
        []
        """
        from scenelang.backends.geometry.arrangement import Arrangement, related
        from scenelang.backends.labels.things import is_thing
        from scenelang.interpreter.inspection.numbering import frame_numbers, some_handles

        root = self._frame(frame)
        chosen = None if words is None else {words} if isinstance(words, str) else set(words)
        here = Arrangement(self.graph, self.graph.frames.index(root))
        ancestry = here.ancestry
        counts = [e.word in chosen if chosen is not None else is_thing(e) and e is not root for e in ancestry.nodes]
        rows = [row for row, node in enumerate(ancestry.node.tolist()) if counts[node]]
        found = related(here, rows, limit)
        numbers = frame_numbers(self.graph) if len(self.graph.frames) > 1 else None
        named = some_handles(self.graph, ancestry, sorted({n for r in found for n in (r.subject, r.other)}), numbers)
        words_of = {row: ancestry.entity(row).word for row in named}
        return [
            SceneRelation(
                r.relation, named[r.subject], named[r.other], words_of[r.subject], words_of[r.other], r.distance
            )
            for r in found
        ]


def scene_of(source: Source, options: Options) -> Scene:
    """Evaluate a program to a scene; raises SceneError with its first error."""
    from scenelang.session.session import Session

    if not 0 <= options.seed < 1 << 32:
        raise SceneError("value", f"`seed`: expected a whole number from 0 to {(1 << 32) - 1}, got {options.seed}")
    result = Session(options).evaluate(source)
    result.require()
    return scene_from(result, source.name, options)


def scene_from(result: Evaluated, name: str, options: Options) -> Scene:
    """Create the scene of a program that was evaluated without errors."""
    assert result.scene is not None
    return Scene(result.scene, name, result.log, result.diagnostics, result.program, options)


def literal(value: Any) -> str:
    """Convert a plain Python value to a literal of the language, as accepted by ``defines``.

    Raises
    ------
    SceneError
        If the value is not a number, a boolean, a string or a sequence of these.

    Examples
    --------
    >>> literal([1, 2.5]), literal(True), literal("oak")
    ('[1 2.5]', '#t', '"oak"')
    """
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, bool | int | float | str):
        return atom_text(value)
    if isinstance(value, list | tuple):
        return f"[{' '.join(literal(item) for item in value)}]"
    raise SceneError("param", f"expected a number, boolean, string or sequence for a param, got {type(value).__name__}")


def _picture_options(
    camera: View | None,
    size: Size | None,
    frame: int | None,
    environment: str,
    ground: str | None,
    labels: bool,
    seed: int,
    settings: Mapping[str, Any] | None,
    limit: int,
    progress: Progress | None,
    warn: Warn | None,
) -> PictureOptions:
    from scenelang.backends.pictures.film import PictureOptions

    view = camera if camera is not None else Viewpoint()
    own = (view.width, view.height) if isinstance(view, PlacedCamera) else (512, 512)
    width, height = size or own
    return PictureOptions(
        frame, limit, progress, dict(settings or {}), warn, width, height, view, environment, ground, seed, labels
    )


def _backends(quality: str | Sequence[str]) -> list[PictureBackend]:
    from scenelang.backends.pictures.film import picture_backend

    chosen = [quality] if isinstance(quality, str) else list(quality)
    if not chosen:
        raise SceneError("value", "`quality`: expected a quality or several, got none")
    return [picture_backend(name) for name in chosen]


def _drawn(graph: SceneGraph, options: PictureOptions, quality: str | Sequence[str]) -> tuple[Image, Shot]:
    """Render one image, by one backend or by several side by side, and return it with its shot."""
    from scenelang.backends.pictures.film import check, paint_shot, painters
    from scenelang.backends.pictures.stage import still

    backends = _backends(quality)
    check(options, backends)
    shot = still(graph, options.camera, options.frame, options.width, options.height)
    drawn = paint_shot(painters(graph, options, backends, [shot]), shot, options.progress)
    return _image(drawn, shot.camera), shot


def _image(drawn: Any, camera: PlacedCamera) -> Image:
    picture = drawn.picture
    opaque = np.full((*picture.shape[:2], 1), 255, np.uint8)
    return Image(np.concatenate([picture, opaque], axis=2), drawn.radiance, camera)


def _objects(values: Sequence[Any]) -> npt.NDArray[np.object_]:
    """Create an object array (N,) of arbitrary values; unlike ``np.array`` it does not unpack tuples."""
    found = np.empty(len(values), object)
    for i, value in enumerate(values):
        found[i] = value
    return found


def _crop(image: Image, bbox: Sequence[float], margin: float) -> Image:
    """Crop a square around a pixel box (x, y, width, height), clipped to the image."""
    x, y, width, height = bbox
    half = max(width, height) * (0.5 + margin)
    x0, x1 = max(0, int(x + width / 2 - half)), min(image.size[0], int(np.ceil(x + width / 2 + half)))
    y0, y1 = max(0, int(y + height / 2 - half)), min(image.size[1], int(np.ceil(y + height / 2 + half)))
    intrinsics = image.camera.intrinsics.copy()
    intrinsics[:2, 2] -= (x0, y0)
    camera = replace(image.camera, width=x1 - x0, height=y1 - y0, intrinsics=intrinsics)
    return Image(image.pixels[y0:y1, x0:x1].copy(), image.radiance[y0:y1, x0:x1].copy(), camera)
