"""The class ``Scene`` of the Python API, as returned by ``scenelang.load`` and ``scenelang.evaluate``.

A ``Scene`` is immutable and can be shared between threads. Arrays are NumPy arrays, angles are in degrees, lengths in
scene units, and the world is right-handed with +y up. Methods raise ``SceneError``, whose text shows the code, the
position, the source line and a hint. Each method is a call into one domain, which is imported then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends import base
from scenelang.backends.base import BackendOptions, Progress, frame_of
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.settings import typed
from scenelang.session.declarations import declarations_in
from scenelang.session.loaded import LoadedScene

if TYPE_CHECKING:
    from scenelang.backends.geometry.arrangement import SceneRelation
    from scenelang.backends.geometry.relations import Violation
    from scenelang.backends.labels.maps import Maps
    from scenelang.backends.physics.verdicts import PhysicsReport
    from scenelang.backends.pictures.camera import Camera as PlacedCamera
    from scenelang.backends.pictures.figures import Figure
    from scenelang.backends.pictures.images import Film, Image, Size, View
    from scenelang.backends.pictures.sheets import Comparison, Sheet
    from scenelang.backends.viewer.packet import ViewerPage

Warn = Callable[[Diagnostic], None]


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


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Scene(LoadedScene):
    """A scene: one root entity, or one root entity per frame of a 4D scene.

    ``graph`` is the entity graph, ``log`` the lines printed by the program, and ``warnings`` the diagnostics of its
    evaluation.
    """

    @typed
    def render(
        self,
        camera: View | None = None,
        *,
        size: Size | None = None,
        quality: str | Sequence[str] = "draft",
        frame: int | None = None,
        environment: str | None = None,
        ground: str | None = None,
        background: str | None = None,
        exposure: float | str | None = None,
        tone: str | None = None,
        shutter: float = 0.0,
        labels: bool = True,
        figure: Figure | None = None,
        seed: int = 0,
        settings: Mapping[str, Any] | None = None,
        limit: int = 2_000_000,
        progress: Progress | None = None,
        warn: Warn | None = None,
    ) -> Image:
        """Render an image.

        Parameters
        ----------
        camera : Camera or str, optional
            Camera of the image, or the name of one that the program declares; by default the program's first, else
            one that frames the whole scene.
        size : (width, height), optional
            Image size in pixels; default: 512 x 512, or the size of a placed camera.
        quality : str or sequence of str
            "draft", "final" (path traced), or the name of a rendering backend; several render side by side.
        frame : int, optional
            Frame of a 4D scene, counted from 0.
        environment, ground : str
            Environment light ("studio", "softboxes", "overcast", "sunny", "sunset", "night", "flat", "sky,hour=15", or
            the path of a panorama, .hdr or .exr; with ",turn=30,strength=1.5") and ground ("seamless",
            "none", "white", "dark", "meadow", "earth", "checker"; default: that of the environment). By default those
            that the program declares, else "studio", or "softboxes" for polished metal and glass. The grounds
            "transparent" and "shadow" give an image with alpha: of the objects alone, or with their shadow in black.
        background : str, optional
            Flat color behind the objects, without a ground: a CSS name or ``#rrggbb``.
        exposure : float or "auto", optional
            Stops by which the image is brighter; default: what the program declares, else 0. "auto" is the exposure at
            which what the image shows is neither dark nor burnt out.
        tone : str, optional
            Tone curve: "soft" (colors of matte surfaces stay as they are) or "agx" (bright colors fade to white).
        shutter : float
            Motion blur of a 4D scene or a moving camera, over this share of the time between two frames, from 0 to 1.
        labels : bool
            Draw the words of semantic primitives onto their boxes.
        figure : Figure, optional
            Section, exploded view, outlines, callouts, dimensions. ``Image.radiance`` has no lines and text.
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
        from scenelang.backends.pictures.figures import Figure
        from scenelang.backends.pictures.images import image_of, picture_options

        options = picture_options(
            camera, size, frame=frame, environment=environment, ground=ground, background=background,
            exposure=exposure, tone=tone, shutter=shutter, labels=labels, figure=figure or Figure(), seed=seed,
            settings=dict(settings or {}), limit=limit,
            progress=progress, warn=warn,
        )  # fmt: skip
        return image_of(self.graph, options, quality)

    @typed
    def placed(self, camera: View | None = None, size: Size = (512, 512), frame: int = 0) -> PlacedCamera:
        """Return the camera that ``render`` would use, with its pose, intrinsics and projection."""
        from scenelang.backends.pictures.images import picture_options
        from scenelang.backends.pictures.stage import still

        return still(self.graph, picture_options(camera).camera, frame, *size).camera

    @typed
    def film(
        self,
        camera: View | None = None,
        *,
        frames: int | None = None,
        orbit: float | None = None,
        size: Size | None = None,
        quality: str | Sequence[str] = "draft",
        environment: str | None = None,
        ground: str | None = None,
        background: str | None = None,
        exposure: float | str | None = None,
        tone: str | None = None,
        shutter: float = 0.0,
        labels: bool = True,
        figure: Figure | None = None,
        seed: int = 0,
        settings: Mapping[str, Any] | None = None,
        limit: int = 2_000_000,
        warn: Warn | None = None,
    ) -> Film:
        """Create a video of ``frames`` frames, rendered when it is saved or iterated.

        A static scene is shown on a turntable, a 4D scene frame by frame; ``orbit`` is the total camera rotation
        in degrees. The other arguments are those of ``render``.
        """
        from scenelang.backends.pictures.figures import Figure
        from scenelang.backends.pictures.images import picture_options, video_of

        options = picture_options(
            camera, size, environment=environment, ground=ground, background=background, exposure=exposure,
            tone=tone, shutter=shutter, labels=labels, figure=figure or Figure(), seed=seed,
            settings=dict(settings or {}), limit=limit, warn=warn,
        )  # fmt: skip
        return video_of(self, options, quality, frames, orbit)

    @typed
    def sheet(
        self,
        views: Sequence[str] | None = None,
        *,
        frames: int | None = None,
        vary: Mapping[str, Sequence[Any]] | None = None,
        seeds: int | None = None,
        columns: int | None = None,
        camera: View | None = None,
        size: Size = (320, 240),
        quality: str = "draft",
        environment: str | None = None,
        ground: str | None = None,
        background: str | None = None,
        exposure: float | str | None = None,
        tone: str | None = None,
        labels: bool = True,
        figure: Figure | None = None,
        settings: Mapping[str, Any] | None = None,
        limit: int = 2_000_000,
    ) -> Sheet:
        """Draw a contact sheet: a grid of images with captions, in one light and before one backdrop.

        Parameters
        ----------
        views : sequence of str, optional
            Cameras, as the command line takes them; by default front, right, top and three-quarter. Views from a side
            are parallel projections to one scale.
        frames : int, optional
            Number of frames of a 4D scene, or of a turntable of a static one, instead of views.
        vary : mapping, optional
            The values of one param, instead of views; one camera sees all of them.
        seeds : int, optional
            Number of seeds of random numbers, counted from 0, instead of views.
        columns : int, optional
            Cells of a row.
        size : (width, height)
            Of a cell, in pixels.

        The other arguments are those of ``render``.

        Raises
        ------
        SceneError
            If several of these are given, or a scene cannot be drawn.
        """
        from scenelang.backends.pictures.figures import Figure
        from scenelang.backends.pictures.film import picture_backend
        from scenelang.backends.pictures.images import picture_options
        from scenelang.backends.pictures.sheets import SheetOptions, cells_of, cells_of_scenes, check_wanted, sheet_of
        from scenelang.backends.pictures.surroundings import settled

        names = None if vary is None else ", ".join(vary)
        wanted = SheetOptions(None if views is None else tuple(views), frames, names, seeds, columns)
        check_wanted(wanted, 1)
        options = picture_options(
            camera, size, environment=environment, ground=ground, background=background, exposure=exposure,
            tone=tone, labels=labels, figure=figure or Figure(), settings=dict(settings or {}), limit=limit,
        )  # fmt: skip
        options = settled(self.graph, options)
        if vary is None and seeds is None:
            cells = cells_of(self.graph, wanted, options)
        else:
            named = [(f"seed {seed}", self.with_seed(seed).graph) for seed in range(seeds or 0)]
            for name, values in (vary or {}).items():
                named += [(f"{name} = {value}", self.with_params({name: value}).graph) for value in values]
            cells = cells_of_scenes(named, options, to_scale=True)
        return sheet_of(cells, options, picture_backend(quality), columns)

    @typed
    def comparison(
        self,
        other: LoadedScene,
        camera: View | None = None,
        *,
        size: Size = (320, 240),
        quality: str = "draft",
        frame: int | None = None,
        environment: str | None = None,
        ground: str | None = None,
        background: str | None = None,
        figure: Figure | None = None,
        tolerance: float = 1e-5,
        limit: int = 2_000_000,
    ) -> Comparison:
        """Draw this scene and another side by side, with what is removed, added, moved and recolored in color.

        ``tolerance`` is that of ``diff``; the other arguments are those of ``render``.
        """
        from scenelang.backends.pictures.figures import Figure
        from scenelang.backends.pictures.film import picture_backend
        from scenelang.backends.pictures.images import picture_options
        from scenelang.backends.pictures.sheets import compared
        from scenelang.backends.pictures.surroundings import settled

        options = picture_options(
            camera, size, frame=frame, environment=environment, ground=ground, background=background,
            figure=figure or Figure(), limit=limit,
        )  # fmt: skip
        options = settled(self.graph, options)
        named = [(Path(scene.name).stem or scene.word, scene.graph) for scene in (self, other)]
        return compared(named, options, picture_backend(quality), tolerance)

    @typed
    def maps(
        self,
        camera: View | None = None,
        *,
        size: Size | None = None,
        quality: str | Sequence[str] = "draft",
        frame: int | None = None,
        environment: str | None = None,
        ground: str | None = None,
        exposure: float | str | None = None,
        tone: str | None = None,
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
        from scenelang.backends.labels.maps import maps_of
        from scenelang.backends.pictures.images import picture_options

        options = picture_options(
            camera, size, frame=frame, environment=environment, ground=ground,
            exposure=exposure, tone=tone, seed=seed,
            settings=dict(settings or {}), limit=limit, progress=progress, warn=warn,
        )  # fmt: skip
        return maps_of(self.graph, options, quality, tracks)

    @typed
    def exploded(self, amount: float, axis: str | None = None, depth: int | None = None) -> Scene:
        """Return the scene with its parts moved away from the center of what contains them, by ``amount`` times their
        offset: along ``axis`` of the world only ("x", "y" or "z"), and to a ``depth`` of the hierarchy.

        Examples
        --------
        >>> import scenelang as sl
        >>> row = '(bind "row" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
        >>> sl.evaluate(row).exploded(1.0).extents.tolist()
        [3.0, 1.0, 1.0]
        """
        return self._figured(explode=amount, explode_axis=axis, explode_depth=depth)

    @typed
    def cut(self, section: str) -> Scene:
        """Return the scene cut open at a plane such as ``x=0.2`` or ``-y=50%``; two or three remove a corner.

        Examples
        --------
        >>> import scenelang as sl
        >>> sl.evaluate('(bind "it" (lambda () (call "cube")))').cut("x=0").extents.tolist()
        [0.5, 1.0, 1.0]
        """
        return self._figured(section=section)

    def _figured(self, **changes: Any) -> Scene:
        """Return the scene that a figure shows, without its program."""
        from scenelang.backends.pictures.figures import Figure, figured

        return replace(self, graph=figured(self.graph, Figure(**changes)), program=None)

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
        if minecraft:
            from scenelang.backends.deepslate.backend import page_of_scene

            return page_of_scene(self.graph, str(textures or ""), limit).text
        from scenelang.backends.viewer.packet import SplatsOf, page_of

        gaussians: SplatsOf | None = None
        if splats or distilled is not None:
            from scenelang.backends.neural.painting.shown import distilled_splats, surface_splats

            gaussians = surface_splats if distilled is None else distilled_splats(Path(distilled))
        return page_of(self.graph, limit, gaussians)

    @typed
    def show(self, height: int = 520) -> ViewerPage:
        """Return the interactive viewer for a notebook cell; ``height`` is in pixels."""
        from scenelang.backends.viewer.packet import ViewerPage

        return ViewerPage(self.html(), height)

    def _repr_png_(self) -> bytes | None:
        try:
            return self.render(size=(480, 360))._repr_png_()
        except SceneError:
            return None

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
        return report_of(self.graph, frame, seconds, metres_per_unit, progress)

    @typed
    def settle(
        self, *, seconds: float = 5.0, metres_per_unit: float | None = None, progress: Progress | None = None
    ) -> MovedScene:
        """Return the first frame with its bodies where they come to rest. The arguments are those of ``physics``."""
        from scenelang.backends.physics.settling import settled

        rest = settled(self.graph, seconds, metres_per_unit, progress)
        return MovedScene(replace(self, graph=rest.scene, program=None), rest.report)

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

        graph, report = simulated(self.graph, seconds, fps, metres_per_unit, velocities, progress)
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
        from scenelang.backends.geometry.relations import violations

        return violations(self.graph, declarations_in(self.options, declarations))

    @typed
    def relations(
        self, words: str | Sequence[str] | None = None, frame: int = 0, limit: int = 20_000
    ) -> list[SceneRelation]:
        """Return the relations of objects that touch or overlap: what is on, inside of, touching or overlapping what.

        Parameters
        ----------
        words : str or sequence of str, optional
            Words of the objects; by default all that the program binds, and semantic primitives. Objects are compared
            with those that have the same object around them.
        frame : int
            Frame of a 4D scene, counted from 0.
        limit : int
            Most pairs of nearby objects.

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
        from scenelang.backends.geometry.arrangement import scene_relations

        chosen = None if words is None else {words} if isinstance(words, str) else set(words)
        return scene_relations(self.graph, chosen, frame_of(self.graph, frame), limit)


def public_scene(scene: LoadedScene) -> Scene:
    """Return a scene of a domain as the class of the Python API; a service for filters of datasets."""
    return Scene(**{field.name: getattr(scene, field.name) for field in fields(scene)})
