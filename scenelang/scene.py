"""Scenes for Python: what ``scenelang.load`` and ``scenelang.evaluate`` return, and the results of their methods.

A ``Scene`` is immutable and may be shared between threads. Arrays are numpy's, angles are degrees, lengths are the
scene's units, and the world is right-handed with +y up. Methods raise ``SceneError``; its text shows the code, the
place, the source line and a hint.
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
from scenelang.interpreter.runtime.values import Embedding, Pair, Vector
from scenelang.interpreter.scene.entity import Entity, count_words, descendants, primitive_count
from scenelang.interpreter.scene.entity import Scene as SceneGraph
from scenelang.interpreter.scene.primitives.base import color_of

if TYPE_CHECKING:
    from scenelang.backends.labels.ground_truth import Boxes, Truth
    from scenelang.backends.pictures.film import Painter, PictureBackend, PictureOptions
    from scenelang.backends.pictures.stage import Shot
    from scenelang.interpreter.program.program import Program
    from scenelang.scene_changes import Changes
    from scenelang.session import Evaluated, Options

FloatArray = npt.NDArray[np.float64]
Size = tuple[int, int]
View = Viewpoint | PlacedCamera
Warn = Callable[[Diagnostic], None]


@dataclass(frozen=True, slots=True)
class Camera(Viewpoint):
    """A camera that looks at the scene; whatever is left out frames the whole scene.

    Parameters
    ----------
    azimuth, elevation : float
        Direction of the camera from its target, in degrees. At azimuth 0 it looks from +z towards -z; a positive
        azimuth moves it towards +x, a positive elevation upwards.
    distance : float, optional
        From the eye to ``target``, in scene units.
    fov : float
        Vertical field of view in degrees.
    target : (x, y, z), optional
        The point at the centre of the picture.
    orthographic : bool
        Parallel projection.
    aperture, focus : float
        Radius of the lens (0: a pinhole) and the distance that is sharp, in scene units.

    Examples
    --------
    >>> Camera(azimuth=40, elevation=20)
    Camera(azimuth=40, elevation=20)
    """

    def __repr__(self) -> str:
        default = Viewpoint()
        names = Viewpoint.__dataclass_fields__
        given = [f"{n}={getattr(self, n)!r}" for n in names if getattr(self, n) != getattr(default, n)]
        return f"Camera({', '.join(given)})"

    @staticmethod
    def from_pose(
        camera_to_world: npt.ArrayLike,
        fov: float = 35.0,
        *,
        size: Size = (512, 512),
        convention: Literal["opengl", "opencv"] = "opengl",
    ) -> PlacedCamera:
        """A camera at a given pose.

        Parameters
        ----------
        camera_to_world : (4, 4) array
            A rotation and a translation. In the "opengl" convention (trimesh, NeRF, Blender) the camera looks along
            its -z axis with +y up; in the "opencv" convention (COLMAP) along +z with +y down.
        fov : float
            Vertical field of view in degrees.
        size : (width, height)
            Pixels. A picture of another size shows as much of the scene as the height shows.

        Raises
        ------
        SceneError
            The pose is not rigid, or the field of view is not between 0 and 180 degrees.

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
        turn = pose[:3, :3]
        if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-4 or np.linalg.det(turn) < 0.0:
            raise SceneError("value", "expected a rigid camera pose: a rotation and a translation")
        if not 0.0 < fov < 180.0:
            raise SceneError("value", f"the field of view must lie between 0 and 180 degrees, not {fov:g}")
        sign = 1.0 if convention == "opengl" else -1.0
        axes = (turn[:, 0], sign * turn[:, 1], -sign * turn[:, 2])
        width, height = size
        focal = height / (2.0 * np.tan(np.radians(fov) / 2.0))
        return camera_at(pose[:3, 3], axes, float(focal), width, height)


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A rendered picture.

    Attributes
    ----------
    pixels : (H, W, 4) uint8
        sRGB with an opaque alpha channel.
    radiance : (H, W, 3) float32
        Linear sRGB, without labels.
    camera : PlacedCamera
        The camera that took it: ``intrinsics`` (3, 3), ``world_to_camera`` (4, 4), ``project``.
    """

    pixels: npt.NDArray[np.uint8]
    radiance: npt.NDArray[np.float32]
    camera: PlacedCamera

    @property
    def size(self) -> Size:
        """Width and height in pixels."""
        return self.pixels.shape[1], self.pixels.shape[0]

    def save(self, path: str | Path) -> Path:
        """Write a .png, .jpg, .webp, or the radiance as .exr; the file is whole or not there. Returns its path."""
        from scenelang.backends.pictures import film

        film.save_image(film.Image(np.ascontiguousarray(self.pixels[:, :, :3]), self.radiance), path)
        return Path(path)

    def beside(self, *others: Image) -> Image:
        """This picture and others of the same height in a row; ``camera`` stays this one's."""
        images = (self, *others)
        if len({image.size[1] for image in images}) > 1:
            raise SceneError("value", "pictures beside each other must have the same height")
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
    """A film that is drawn when it is iterated or saved.

    Attributes
    ----------
    cameras : tuple of PlacedCamera
        One for each picture.
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

    def save(self, path: str | Path, fps: float = 24.0, progress: Progress | None = None) -> Path:
        """Write an .mp4, .gif, .apng or .webp; the file is whole or not there. Returns its path."""
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
        Each primitive's frame in the world.
    word, handle, shape : (N,) object
        Texts; ``shape`` is "cube", "sphere", ..., and "box" for a word without a geometry of its own.
    path : (N,) object
        Tuples of the words from the root down to the primitive's parent.
    color : (N, 3) float64
        Linear sRGB.
    entity : tuple of Entity
        The entity of each primitive; repeated primitives share one.
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

    def attribute(self, name: str, default: Any = None) -> npt.NDArray[np.object_]:
        """The attribute ``name`` of each primitive (N,), with the defaults of its geometry filled in.

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
        """The primitives that a mask (N,) or indices select."""
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
    """What every pixel of a picture shows, as a mapping from names to arrays (H, W, ...).

    ``color`` is the picture (H, W, 3) uint8. ``instance`` numbers instances (-1: nothing), ``semantic`` words (0:
    nothing, see ``words``), ``depth`` is in scene units along the viewing axis (infinity: nothing), ``normal`` and
    ``position`` are in the world, ``albedo`` is linear sRGB. ``list(maps)`` names the others (docs/maps.md).
    """

    def __init__(self, scene: Scene, truth: Truth, image: Image) -> None:
        from scenelang.backends.labels import dataset

        self.camera = truth.camera
        self.image = image
        self._scene, self._truth = scene, truth
        self._arrays: dict[str, npt.NDArray[Any]] = {"color": image.pixels[:, :, :3], **dataset.arrays_of(truth)}

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    @property
    def words(self) -> dict[int, str]:
        """The word of each number in ``semantic``."""
        from scenelang.backends.labels.dataset import word_numbers

        return {number: word for word, number in word_numbers(self._truth).items()}

    @cached_property
    def _handles(self) -> list[str]:
        from scenelang.interpreter.scene.numbering import frame_numbers, instance_handles

        graph = self._scene.graph
        numbers = frame_numbers(graph) if len(graph.frames) > 1 else None
        return instance_handles(graph, self._truth.ancestry, numbers)

    @cached_property
    def _boxes(self) -> Boxes:
        from scenelang.backends.labels.ground_truth import boxes_in

        return boxes_in(self._truth)

    def annotations(self, limit: int = 20_000) -> list[dict[str, Any]]:
        """The visible instances in the fields of COCO: ``category``, ``bbox``, ``area``, ``segmentation``, ``box3d``,
        ``handle``, ``path`` (docs/maps.md); at most ``limit``, highest in the hierarchy first."""
        from scenelang.backends.labels.dataset import annotations_of

        return annotations_of(self._truth, self._boxes, self._handles, limit)

    def coco(self, limit: int = 20_000) -> dict[str, Any]:
        """One COCO document for this picture; ``json.dumps`` takes it."""
        from scenelang.backends.labels.dataset import dataset

        image = {"file_name": "color.png", "width": self.camera.width, "height": self.camera.height}
        return dataset([image], [self.annotations(limit)])

    def mask(self, word: str) -> npt.NDArray[np.bool_]:
        """The pixels (H, W) that show an entity of ``word`` or a part of one."""
        found = np.zeros(self["instance"].shape, bool)
        ancestry = self._truth.ancestry
        own = np.array([entity.word == word for entity in ancestry.nodes], bool)
        for level in self["instance_by_depth"]:
            found |= (level >= 0) & own[ancestry.node[np.maximum(level, 0)]]
        return found

    def crops(self, word: str | None = None, margin: float = 0.1) -> list[Image]:
        """Square pictures of single instances, as CLIP expects them.

        Parameters
        ----------
        word : str, optional
            Only instances of this word; None takes every visible instance below the root.
        margin : float
            Space around the instance's box, as a share of its longer side.
        """
        found = [a for a in self.annotations() if (a["category"] == word if word else a["depth"] > 0)]
        return [_crop(self.image, annotation["bbox"], margin) for annotation in found]

    def save(self, folder: str | Path) -> Path:
        """Write every map into a new or existing folder: PNG, NPZ, EXR, JSON (docs/maps.md). Returns its path."""
        from scenelang.backends.files import write_json
        from scenelang.backends.labels.dataset import ShotMaps

        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        ShotMaps(self._truth, np.ascontiguousarray(self["color"])).write(target, self._handles, 20_000)
        write_json(target / "coco.json", self.coco())
        return target

    def __repr__(self) -> str:
        return f"<Maps {self.camera.width} x {self.camera.height}: {', '.join(self)}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ViewerPage:
    """The interactive viewer as one page; a notebook shows it in a frame of its own."""

    html: str
    height: int

    def save(self, path: str | Path) -> Path:
        """Write the page as a file that needs no server. Returns its path."""
        from scenelang.backends.files import write_text

        write_text(path, self.html)
        return Path(path)

    def _repr_html_(self) -> str:
        from scenelang.backends.viewer.page import frame

        return frame(self.html, self.height)

    def __repr__(self) -> str:
        return f"<ViewerPage of {len(self.html):,} characters>"


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A scene: one root entity, or one for each frame of a 4D scene.

    ``graph`` is the entity graph, for code that walks it; ``log`` holds the lines that the program printed,
    ``warnings`` what was found suspicious.
    """

    graph: SceneGraph = field(repr=False)
    name: str = "<text>"
    log: tuple[str, ...] = field(default=(), repr=False)
    warnings: tuple[Diagnostic, ...] = field(default=(), repr=False)
    program: Program | None = field(default=None, repr=False)
    options: Options | None = field(default=None, repr=False)

    @staticmethod
    def of(entity: Entity) -> Scene:
        """An entity as a scene of its own, in its own frame."""
        return Scene(SceneGraph(entity.word, [entity], False))

    # --- facts -------------------------------------------------------------------------------------------------

    @property
    def word(self) -> str:
        """The word of the root."""
        return self.graph.word

    @property
    def root(self) -> Entity:
        """The root entity of the first frame."""
        return self.graph.root

    @property
    def frames(self) -> tuple[Entity, ...]:
        """The root entity of each frame."""
        return self.graph.frames

    @property
    def animated(self) -> bool:
        """True for a 4D scene."""
        return self.graph.animated

    @property
    def words(self) -> list[str]:
        """The words of all entities, sorted."""
        return sorted({entity.word for entity in descendants(*self.frames)})

    @property
    def params(self) -> dict[str, str]:
        """The program's params with their defaults as they are written."""
        return {} if self.program is None else {param.name: param.default for param in self.program.params}

    @property
    def bounds(self) -> FloatArray | None:
        """The exact axis-aligned box (2, 3) of all frames, lowest corner first; None without geometry."""
        return self._box(None)

    @property
    def extents(self) -> FloatArray | None:
        """The sizes (3,) of ``bounds``."""
        return None if (box := self.bounds) is None else box[1] - box[0]

    def bounds_of(self, word: str) -> FloatArray | None:
        """The exact box (2, 3) in the world of all entities of ``word``; None where they have no geometry.

        Raises
        ------
        SceneError
            No entity has the word.
        """
        self._require(word)
        return self._box(word)

    def _require(self, word: str) -> None:
        if all(entity.word != word for entity in descendants(*self.frames)):
            raise SceneError("value", f'no entity has the word "{word}"', suggest(word, self.words))

    def _box(self, word: str | None) -> FloatArray | None:
        from scenelang.interpreter.scene.bounds import word_box

        box = word_box(self.graph, word)
        return None if box is None else np.array(box, np.float64).reshape(2, 3)

    def count(self, frame: int = 0) -> dict[str, int]:
        """Instances of every word in a frame, in depth-first order of appearance."""
        return count_words(self._frame(frame))

    def tree(self, depth: int | None = None, *, poses: bool = False, every: bool = False) -> str:
        """The hierarchy of the first frame as text, ``depth`` levels below the root; ``every`` lists repeated parts
        one by one."""
        from scenelang.interpreter.scene.outline import outline

        return "\n".join(outline(self.graph, depth, poses, every))

    def tree_data(self, depth: int | None = None) -> dict[str, Any]:
        """The hierarchy of the first frame as plain data."""
        from scenelang.interpreter.scene.outline import outline_data

        return outline_data(self.graph, depth)

    def flatten(self, frame: int = 0, limit: int = 5_000_000) -> Primitives:
        """The primitives of a frame with their world matrices.

        Raises
        ------
        LimitError
            The scene expands to more than ``limit`` primitives.
        """
        from scenelang.interpreter.scene.flatten import flatten
        from scenelang.interpreter.scene.numbering import frame_handles

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

    def with_params(self, values: Mapping[str, Any]) -> Scene:
        """The scene of the same program with other values of its params, as plain Python values.

        Raises
        ------
        SceneError
            The scene has no program, the program has no such param, or it fails under the new values.
        """
        if self.program is None or self.options is None:
            raise SceneError("unsupported", "a scene that was read from JSON has no params")
        texts = {name: literal(value) for name, value in values.items()}
        options = replace(self.options, defines={**self.options.defines, **texts})
        return scene_of(self.program.main, options)

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
        """The scene with another look of every entity of ``word`` and of all its parts.

        Parameters
        ----------
        word : str
            A word of the scene.
        color : (r, g, b) or str, optional
            Linear sRGB from 0 to 1, or a colour's name or hex code.
        roughness, metallic, opacity, emission, ior : float, optional
            Attributes of surfaces (docs/language.md).

        Raises
        ------
        SceneError
            No entity has the word.
        """
        self._require(word)
        look = {"color": color, "roughness": roughness, "metallic": metallic, "opacity": opacity}
        look |= {"emission": emission, "ior": ior}
        attributes = {name: _look_value(name, value) for name, value in look.items() if value is not None}
        known: dict[tuple[int, bool], Entity] = {}
        frames = [_restyled(root, word, attributes, known) for root in self.frames]
        return replace(self, graph=SceneGraph(self.word, frames, self.animated), program=None)

    def frame(self, number: int) -> Scene:
        """One frame of a 4D scene as a scene of its own."""
        return replace(self, graph=SceneGraph(self.word, [self._frame(number)], False))

    # --- results -----------------------------------------------------------------------------------------------

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
        """Render a picture.

        Parameters
        ----------
        camera : Camera, optional
            Where it is taken from; the default frames the whole scene.
        size : (width, height), optional
            Pixels; default 512 x 512, or the size of a placed camera.
        quality : str or sequence of str
            "draft", "final" (path traced), or the name of a backend that draws; several draw side by side.
        frame : int, optional
            Frame of a 4D scene, from 0.
        environment, ground : str
            The light ("studio", "overcast", "sunny", "sunset", "night", "flat") and the ground ("seamless", "none",
            "white", "dark", "meadow", "earth", "checker"; the environment's own by default).
        labels : bool
            Write the words of semantic primitives onto their boxes.
        seed : int
            Of the sampling: the same seed gives the same picture.
        settings : mapping, optional
            Options of the backend by name, such as ``{"samples": 64}``; ``scenelang backends -v`` lists them.
        limit : int
            Most primitives that are expanded.
        progress : callable, optional
            Called with a fraction from 0 to 1. An exception that it raises cancels the work.
        warn : callable, optional
            Called with a ``Diagnostic`` for what is not drawn as the program asks.

        Raises
        ------
        SceneError
            Nothing would be drawn, a package is missing, or an argument makes no sense.
        """
        options = _picture_options(
            camera, size, frame, environment, ground, labels, seed, settings, limit, progress, warn
        )
        return _drawn(self.graph, options, quality)[0]

    def placed(self, camera: View | None = None, size: Size = (512, 512), frame: int = 0) -> PlacedCamera:
        """The camera of a picture: where it stands, its intrinsics, what it projects where."""
        from scenelang.backends.pictures.stage import still

        return still(self.graph, Viewpoint() if camera is None else camera, frame, *size).camera

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
        """A film of ``frames`` pictures, drawn when it is saved or iterated.

        A static scene is filmed on a turntable, a 4D scene frame by frame; ``orbit`` says how many degrees the camera
        goes round the scene. The other arguments are those of ``render``.
        """
        from scenelang.backends.pictures.film import check
        from scenelang.backends.pictures.stage import film

        options = _picture_options(camera, size, None, environment, ground, labels, seed, settings, limit, None, warn)
        check(options, _backends(quality))
        shots = film(self.graph, options.camera, options.width, options.height, frames, orbit)
        return Film(self, options, quality, tuple(shots))

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
        limit: int = 2_000_000,
        progress: Progress | None = None,
        warn: Warn | None = None,
    ) -> Maps:
        """What every pixel shows: instances, words, depth, normals and more. The arguments are those of ``render``."""
        from scenelang.backends.labels.ground_truth import truth_of
        from scenelang.backends.minecraft.models import as_cubes
        from scenelang.backends.pictures.stage import unit_size

        options = _picture_options(
            camera, size, frame, environment, ground, True, seed, settings, limit, progress, warn
        )
        cubes = as_cubes(self.graph, limit, warn)  # the maps label what is drawn
        image, shot = _drawn(cubes, options, quality)
        truth = truth_of(cubes, shot, limit, *unit_size(cubes))
        return Maps(replace(self, graph=cubes), truth, image)

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
        """Write the scene for another program, by the ending of ``path`` or with the named backend.

        Returns the files written: .glb .gltf .usda .usdz .obj .ply .stl .json .xml, Minecraft builds and more
        (docs/exports.md). Each is whole or not there.

        Raises
        ------
        SceneError
            No backend writes such files, a package is missing, or the file cannot be written.
        """
        from scenelang.backends import base

        target = Path(path)
        chosen = base.find(backend) if backend is not None else base.for_file(target, base.Work.EXPORT)
        options = BackendOptions(frame, limit, progress, dict(settings or {}), warn)
        base.check_settings(options, [chosen])
        return list(chosen.run(self.graph, target, options) or [target])

    def save_graph(
        self, path: str | Path, depth: int | None = None, frame: int | None = None, thumbnails: bool = False
    ) -> Path:
        """Write what is made of what as an .svg drawing, as in the paper's Figure 2. Returns its path."""
        from scenelang.backends.pictures.call_graph import write_graph

        write_graph(self.graph, Path(path), frame, depth, thumbnails)
        return Path(path)

    def html(self) -> str:
        """The interactive viewer as one page that needs no server."""
        from scenelang.backends.viewer.packet import packet_of
        from scenelang.backends.viewer.page import SavedScene, self_contained

        state: dict[str, Any] = {"name": self.word, "version": 1, "ok": True, "picture": 1}
        state |= {"diagnostics": [], "params": []}
        return self_contained([SavedScene(self.word, state, packet_of(self.graph))])

    def show(self, height: int = 520) -> ViewerPage:
        """The interactive viewer, for a notebook cell; ``height`` in pixels."""
        return ViewerPage(self.html(), height)

    def diff(self, other: Scene, tolerance: float = 1e-5, limit: int = 2_000_000) -> Changes:
        """What differs in ``other``; see ``scenelang.diff``."""
        from scenelang.scene_changes import changes_between, sheets_of

        return changes_between(sheets_of(self.graph, limit), sheets_of(other.graph, limit), tolerance)

    def to_json(self) -> dict[str, Any]:
        """The scene in the schema of the JSON export (docs/exports.md); mesh files relative to the current folder."""
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


def scene_of(source: Source, options: Options) -> Scene:
    """The scene of a program; raises SceneError with its first mistake."""
    from scenelang.session import Session

    result = Session(options).evaluate(source)
    result.require()
    return scene_from(result, source.name, options)


def scene_from(result: Evaluated, name: str, options: Options) -> Scene:
    """The scene of a program that was evaluated without a mistake."""
    assert result.scene is not None
    return Scene(result.scene, name, result.log, result.diagnostics, result.program, options)


def literal(value: Any) -> str:
    """A plain Python value as a literal of the language, as ``defines`` takes it.

    Raises
    ------
    SceneError
        The value is not a number, a boolean, a string or a sequence of these.

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
    raise SceneError("param", f"a param takes a number, boolean, string or sequence, not {type(value).__name__}")


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

    return [picture_backend(name) for name in ([quality] if isinstance(quality, str) else quality)]


def _drawn(graph: SceneGraph, options: PictureOptions, quality: str | Sequence[str]) -> tuple[Image, Shot]:
    """One picture, drawn by one backend or by several side by side, and the shot that it is."""
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
    """An array (N,) of anything, tuples included."""
    found = np.empty(len(values), object)
    for i, value in enumerate(values):
        found[i] = value
    return found


def _crop(image: Image, bbox: Sequence[float], margin: float) -> Image:
    """The square around a box (x, y, width, height) of pixels, cut off at the picture's edges."""
    x, y, width, height = bbox
    half = max(width, height) * (0.5 + margin)
    columns, rows = image.size
    x0, x1 = max(0, int(x + width / 2 - half)), min(columns, int(np.ceil(x + width / 2 + half)))
    y0, y1 = max(0, int(y + height / 2 - half)), min(rows, int(np.ceil(y + height / 2 + half)))
    intrinsics = image.camera.intrinsics.copy()
    intrinsics[:2, 2] -= (x0, y0)
    camera = replace(image.camera, width=x1 - x0, height=y1 - y0, intrinsics=intrinsics)
    return Image(image.pixels[y0:y1, x0:x1].copy(), image.radiance[y0:y1, x0:x1].copy(), camera)


def _look_value(name: str, value: Any) -> Any:
    if name == "color" and isinstance(value, str):
        from scenelang.stdlib.colors import color_of

        return color_of(value)
    if isinstance(value, (int, float)):
        return float(value)
    return Vector(float(x) for x in value)


def _restyled(entity: Entity, word: str, look: Mapping[str, Any], known: dict[tuple[int, bool], Entity]) -> Entity:
    """A copy of the graph below ``entity`` in which everything at or below ``word`` has the attributes ``look``;
    shared parts stay shared. Iterative, since graphs may be deep."""
    stack = [(entity, False)]
    while stack:
        top, inherited = stack[-1]
        inside = inherited or top.word == word
        if (id(top), inherited) in known:
            stack.pop()
            continue
        waiting = [(part.car, inside) for part in top.children if (id(part.car), inside) not in known]
        if waiting:
            stack.extend(waiting)
            continue
        stack.pop()
        children = tuple(Pair(known[id(part.car), inside], part.cdr) for part in top.children)
        known[id(top), inherited] = _copy(top, children, look if inside else {})
    return known[id(entity), False]


def _copy(entity: Entity, children: tuple[Any, ...], look: Mapping[str, Any]) -> Entity:
    own = entity.embedding
    embedding = Embedding(own.handle, own.text, {**own.attributes, **look}) if look else own
    shape = entity.shape
    if shape is not None and "color" in look:
        shape = replace(shape, color=color_of(entity.word, look["color"]))
    return Entity(entity.word, embedding, children, shape, entity.tainted, entity.places)
