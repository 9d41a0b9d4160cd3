"""Images and videos of a scene graph as objects: the classes ``Camera``, ``Image`` and ``Film`` of the Python API."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress
from scenelang.backends.pictures import film as drawing
from scenelang.backends.pictures.camera import Camera as PlacedCamera
from scenelang.backends.pictures.camera import Viewpoint, camera_at
from scenelang.backends.pictures.declared import ProgramView, view_of
from scenelang.backends.pictures.figures import check_drawable, figured
from scenelang.backends.pictures.film import Painter, PictureBackend, PictureOptions, picture_backend
from scenelang.backends.pictures.stage import Shot
from scenelang.backends.pictures.stage import film as film_shots
from scenelang.backends.pictures.surroundings import settled
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import fits, typed
from scenelang.interpreter.scene.entity import Scene

Size = tuple[int, int]
View = Viewpoint | PlacedCamera | ProgramView | str  # a text names a camera of the program, or is as of `--camera`
_DEFAULT_SIZE = (512, 512)  # pixels
_VIEW_NUMBERS = {
    "azimuth": "float", "elevation": "float", "fov": "float", "aperture": "float", "roll": "float",
    "distance": "float | None", "orbit": "float | None", "focus": "float | None", "lens": "float | None",
}  # fmt: skip


class ApiScene(Protocol):
    """A scene of the Python API, of which images and maps need the entity graph."""

    @property
    def graph(self) -> Scene:
        """Entity graph."""


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
    eye : (x, y, z), optional
        Position of the camera, instead of ``azimuth``, ``elevation`` and ``distance``. It looks at ``target``, by
        default the center of the scene.
    roll : float
        Turn of the camera around its view direction, clockwise, in degrees.
    lens : float, optional
        Focal length in millimeters for an image 36 mm wide, instead of ``fov``.
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
        for name in ("target", "eye"):
            point = getattr(self, name)
            if point is not None and (len(point) != 3 or not all(fits(x, "float") for x in point)):
                raise SceneError("value", f"`{name}`: expected three finite numbers, got {point!r}")

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
        from scenelang.backends.pictures.viewpoints import views_of

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
        sRGB with alpha, which is below 255 only for the grounds "transparent" and "shadow".
    radiance : (H, W, 3) float32
        Linear sRGB radiance, without labels, multiplied by alpha.
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
        alpha = None if self._is_opaque else self.pixels[:, :, 3]
        drawing.save_image(drawing.Image(np.ascontiguousarray(self.pixels[:, :, :3]), self.radiance, alpha), path)
        return Path(path)

    @property
    def _is_opaque(self) -> bool:
        return bool((self.pixels[:, :, 3] == 255).all())

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
        return drawing.png_of(np.ascontiguousarray(self.pixels[:, :, : 3 if self._is_opaque else 4]))

    def __repr__(self) -> str:
        return f"<Image {self.size[0]} x {self.size[1]}>"


@dataclass(frozen=True, slots=True, eq=False)
class Film:
    """A video that is rendered lazily, when it is iterated or saved.

    Attributes
    ----------
    scene : Scene
        The scene of the Python API that it shows.
    cameras : tuple of PlacedCamera
        One camera for each frame.
    """

    scene: ApiScene = field(repr=False)
    _options: PictureOptions = field(repr=False)
    _quality: str | Sequence[str] = field(repr=False)
    _shots: tuple[Shot, ...] = field(repr=False)
    _graph: Scene | None = field(default=None, repr=False)  # of the figure, if it is not that of the scene

    def __len__(self) -> int:
        return len(self._shots)

    @property
    def cameras(self) -> tuple[PlacedCamera, ...]:
        """Camera of each frame."""
        return tuple(shot.camera for shot in self._shots)

    def __iter__(self) -> Iterator[Image]:
        painters = self._painters()
        for shot in self._shots:
            yield _image(drawing.paint_shot(painters, shot), shot.camera)

    @typed
    def save(self, path: str | Path, fps: float = 24.0, progress: Progress | None = None) -> Path:
        """Render and write an .mp4, .gif, .apng or .webp, atomically. Returns the path."""
        drawing.save_film(self._painters(), self._shots, Path(path), fps, progress)
        return Path(path)

    def _painters(self) -> list[Painter]:
        return drawing.painters(self._graph or self.scene.graph, self._options, _backends(self._quality), self._shots)

    def __repr__(self) -> str:
        return f"<Film of {len(self):,} pictures>"


def picture_options(camera: View | None = None, size: Size | None = None, **fields: Any) -> PictureOptions:
    """Return rendering options with the defaults of the Python API.

    Parameters
    ----------
    camera : Camera, optional
        A camera, or the name of one of the program. Default: the program's first, else one that frames the scene.
    size : (width, height), optional
        In pixels; default: that of a placed camera, else 512 x 512.
    fields
        Other fields of ``PictureOptions``.
    """
    view = view_of(camera) if camera is None or isinstance(camera, str) else camera
    if isinstance(view, PlacedCamera):
        size = size or (view.width, view.height)
    width, height = size or _DEFAULT_SIZE
    given = {
        name: value for name, value in fields.items() if name not in ("environment", "ground") or value is not None
    }
    stated = (*given, *(("size",) if size else ()))
    return PictureOptions(camera=view, width=width, height=height, stated=stated, **given)


def image_of(graph: Scene, options: PictureOptions, quality: str | Sequence[str] = "draft") -> Image:
    """Render one image, by one backend or by several side by side; raises SceneError."""
    return shot_of(graph, options, quality)[0]


def shot_of(
    graph: Scene, options: PictureOptions, quality: str | Sequence[str] = "draft", seen: Sequence[int] | None = None
) -> tuple[Image, Shot]:
    """Render one image as ``image_of`` does, and return its shot too: the camera and the frame of the scene.

    ``seen`` are the frames that the camera frames, by default the rendered one.
    """
    backends = _backends(quality)
    options = settled(graph, options)
    drawing.check(options, backends)
    graph, shot = drawing.figure_shot(graph, options, seen)
    painted = drawing.paint_shot(drawing.painters(graph, options, backends, [shot]), shot, options.progress)
    return _image(painted, shot.camera), shot


def video_of(
    scene: ApiScene,
    options: PictureOptions,
    quality: str | Sequence[str] = "draft",
    frames: int | None = None,
    orbit: float | None = None,
) -> Film:
    """Return a video that is rendered when it is saved: a turntable of a static scene, or the frames of a 4D scene.

    ``orbit`` is the total rotation of the camera in degrees.
    """
    options = settled(scene.graph, options)
    drawing.check(options, _backends(quality))
    check_drawable(options.figure, None, is_video=True)
    graph = figured(scene.graph, options.figure, options.limit, options.warn)
    shots = film_shots(graph, options.camera, options.width, options.height, frames, orbit)
    return Film(scene, options, quality, tuple(shots), graph)


def _backends(quality: str | Sequence[str]) -> list[PictureBackend]:
    """Return the backends of one quality or several; raises SceneError."""
    names = [quality] if isinstance(quality, str) else list(quality)
    if not names:
        raise SceneError("value", "`quality`: expected a quality or several, got none")
    return [picture_backend(name) for name in names]


def _image(painted: drawing.Image, camera: PlacedCamera) -> Image:
    """Return a drawn shot as an image of the API, with the alpha channel that viewers expect."""
    return Image(painted.rgba, painted.radiance, camera)
