"""Making of samples: evaluates the program of a draw, and renders and labels it as files in memory."""

from __future__ import annotations

import hashlib
import io
import json
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Backend, require
from scenelang.backends.geometry.arrangement import scene_relations
from scenelang.backends.geometry.lint import check_geometry
from scenelang.backends.geometry.relations import violations
from scenelang.backends.labels import object_labels as labels
from scenelang.backends.labels.object_labels import ObjectLabels
from scenelang.backends.labels.views import LabeledView, SceneFacts
from scenelang.backends.pictures.camera import Camera, camera_to_json
from scenelang.backends.pictures.declared import View
from scenelang.backends.pictures.film import Painter, PictureOptions, painters, picture_backend
from scenelang.backends.pictures.stage import Shot, box_of
from scenelang.backends.surfaces.environments import ENVIRONMENTS
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.solids import is_object
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.datasets.naming import classes_of, named_program
from scenelang.datasets.sampler import Draw, draw_sample, key_of, split_of_scene, stream, views_of
from scenelang.datasets.spec import CODE, PREDICATES, Spec
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.plugins import SERVICES, PluginRegistry
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import count_words, descendants, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.modelling.solid import compute_all
from scenelang.session.declarations import declarations_in
from scenelang.session.loaded import LoadedScene, literal
from scenelang.session.session import Options, Session

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

Files = Mapping[str, bytes]
Part = bytes | partial[bytes]  # content of a file, or a function that encodes it
_MAX_CACHED_SCENES = 4  # evaluated scenes that are cached, since draws repeat them
_LARGE_SCENE_PRIMITIVES = 200_000  # primitives of a scene from which it is cached alone, to bound the memory
_LIMIT_OPTION = re.compile(r"--max-(steps|depth|entities|primitives|size|memory|seconds)\b")
_FIELD = re.compile(r"\{([^{}]*)\}")
_DEFAULT_CAPTIONS = ("{things}",)


class EncodedFiles(Files):
    """Contents by ending; each is encoded when it is first read, so that another thread can do it."""

    def __init__(self, parts: Mapping[str, Part]) -> None:
        self._parts = dict(parts)

    def __getitem__(self, ending: str) -> bytes:
        """Return the content of a file, encoded on first access."""
        part = self._parts[ending]
        if not isinstance(part, bytes):
            part = self._parts[ending] = part()
        return part

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)


@dataclass(frozen=True, slots=True)
class LabeledItem:
    """One image with its labels: ``files`` by ending (``color.png``), which follow the ``key`` of the item."""

    key: str
    files: Files


@dataclass(frozen=True, slots=True)
class Sample:
    """Made sample: its draw, its items by camera and frame, its first camera, and the visible objects by word."""

    draw: Draw
    items: tuple[LabeledItem, ...]
    camera: Mapping[str, float]
    shown: Mapping[str, int]


class SampleFailure(Exception):
    """Failure of a sample; ``is_of_machine`` if another run may succeed, as after a limit of time."""

    def __init__(self, diagnostic: Diagnostic, is_of_machine: bool = False) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic, self.is_of_machine = diagnostic, is_of_machine


@dataclass(frozen=True, slots=True)
class Candidate:
    """Sample that a predicate of an installed package judges.

    It has the evaluated scene as the ``Scene`` of the Python API, the drawn values, and the visible objects of each
    camera in the first frame.
    """

    scene: LoadedScene
    values: Mapping[str, Any]
    things: Sequence[ObjectLabels]


@dataclass(frozen=True, slots=True)
class Predicate:
    """A filter of an installed package, in the entry-point group ``scenelang.filters``.

    ``accepts`` decides whether a sample is kept; it must depend on its argument only.
    """

    name: str
    doc: str
    accepts: Callable[[Candidate], bool]


FILTERS = PluginRegistry(PREDICATES, "filter", Predicate, CODE)


@dataclass(frozen=True, eq=False)
class _Stage:
    """Evaluated scene, with the data that its images share."""

    scene: LoadedScene
    facts: SceneFacts
    text: str
    draws: bool
    painters: dict[Any, Painter] = field(default_factory=dict)

    @cached_property
    def digest(self) -> str:
        """Digest that is equal for scenes that look alike, whatever their program, seed or params."""
        total = hashlib.sha256()
        for root in self.scene.frames:
            flat = flatten_entity(root)
            for array in (flat.index, flat.matrices):
                total.update(array.tobytes())
            for entity in flat.primitives:
                described = repr((entity.word, sorted(primitive_attributes(entity).items())))
                total.update(described.encode("utf-8", "surrogatepass"))
        return total.hexdigest()


# --- samples ---------------------------------------------------------------------------------------------------------


class Maker:
    """Makes the samples of a spec; evaluated scenes and their light are reused while draws repeat them.

    ``watch`` is called with True before and with False after each evaluation of a program.

    Examples
    --------
    >>> from pathlib import Path
    >>> from scenelang.datasets.spec import spec_of
    >>> spec = spec_of('programs = "chessboard.scene"\\n[images]\\nsize = 16', "spec", Path("examples").resolve())
    >>> [item.key for item in Maker(spec).make(3).items]
    ['000000003']
    """

    def __init__(
        self, spec: Spec, classes: Mapping[str, int] | None = None, watch: Callable[[bool], None] | None = None
    ) -> None:  # fmt: skip
        """Find the backends and predicates of a spec; ``classes`` are by default those of its programs."""
        self.spec = spec
        self._watch = watch or (lambda _: None)
        self.classes = dict(classes) if classes is not None else classes_of(spec)
        self._backends = {str(name): picture_backend(str(name)) for name in spec.pictures.quality.values}
        self._cached_stages: dict[str, _Stage] = {}
        self._predicates = [FILTERS.find(name) for name in spec.filters.predicates]

    def make(self, index: int) -> Sample:
        """Make one sample; raises SampleFailure."""
        rejections: Counter[str] = Counter()
        for attempt in range(self.spec.filters.attempts):
            draw = draw_sample(self.spec, index, attempt)
            if draw is None:
                rejections["in no split"] += 1
                continue
            try:
                sample, reason = self._make(draw)
            except SceneError as error:
                if error.name == "interrupted":  # by Ctrl-C, in the process that evaluates
                    raise KeyboardInterrupt from error
                raise SampleFailure(_in_terms_of_specs(error.diagnostic)) from error
            except (RecursionError, MemoryError, ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
                message = f"the sample cannot be made: {type(error).__name__}: {error}"
                raise SampleFailure(Diagnostic("sample", message), isinstance(error, MemoryError)) from error
            if sample is not None:
                return sample
            rejections[reason] += 1
        reasons = ", ".join(f"{count} {reason}" for reason, count in rejections.most_common())
        raise SampleFailure(Diagnostic("sample", f"no draw passes the filters: {reasons}"))

    def _make(self, draw: Draw) -> tuple[Sample | None, str]:
        """Return the sample of a draw, or None and the filter that it does not pass."""
        stage = self._stage(draw)
        if self.spec.splits is not None and self.spec.splits.by == "scene":
            draw = replace(draw, split=split_of_scene(self.spec, stage.digest))
        if self.spec.filters.geometry and check_geometry(stage.scene.graph):
            return None, "with findings of the geometry"
        reason = self._unsound(stage.scene)
        if reason:
            return None, reason
        frames = self._frames(stage)
        views = [self._view(stage, draw, view, frames) for view in views_of(self.spec, draw)]
        if self.spec.filters.visible or self._predicates:
            reason = self._filtered(stage, draw, views, frames)
            if reason:
                return None, reason
        items = []
        shown: Counter[str] = Counter()
        for number, view in enumerate(views):
            film = self._film(view, frames)
            for frame in frames:
                key = key_of(draw.index) + (f"-v{number:03d}" if len(views) > 1 else "")
                key += f"-f{frame:04d}" if len(frames) > 1 else ""
                writer = _ItemWriter(self, stage, draw, view, number, frame, key, film)
                items.append(LabeledItem(key, writer.files()))
                shown.update(writer.seen)
        first = views[0].shots[frames[0]].camera
        return Sample(draw, tuple(items), _placed(first), shown), ""

    def _unsound(self, scene: LoadedScene) -> str:
        """Return why a scene does not pass the filters of declarations and stability; empty if it does."""
        stated = self.spec.filters.that
        if stated and violations(scene.graph, declarations_in(scene.options, stated)):
            return "with a declaration that does not hold"
        if self.spec.filters.stable:
            report = SERVICES.find("physics").report_of(scene.graph)
            if any(body.kind != "rests" for body in report.bodies):
                return "with bodies that move"
        return ""

    def _filtered(self, stage: _Stage, draw: Draw, views: Sequence[LabeledView], frames: Sequence[int]) -> str:
        """Return why a sample does not pass the filters of visibility and the predicates; empty if it does."""
        min_shares = self.spec.filters.visible
        first = []
        for view in views:
            for frame in frames if min_shares else frames[:1]:
                objects = view.objects(frame, self.spec.labels.words)
                first += [objects] if frame == frames[0] else []
                shares = objects.shares(list(min_shares))
                for word in min_shares:
                    if shares[word] < min_shares[word]:
                        return f'with too little of "{word}"'
        if not self._predicates:
            return ""
        candidate = Candidate(SERVICES.find("scene")(stage.scene), draw.values, first)
        for predicate in self._predicates:
            try:
                accepted = predicate.accepts(candidate)
            except Exception as error:  # code of another package
                message = f"the filter `{predicate.name}` fails: {type(error).__name__}: {error}"
                raise SceneError("sample", message) from error
            if not accepted:
                return f"rejected by `{predicate.name}`"
        return ""

    def _film(self, view: LabeledView, frames: Sequence[int]) -> frozenset[int]:
        """Return the numbers of the paths of objects that any frame shows; none for a single frame."""
        if len(frames) < 2 or "boxes" not in self.spec.labels.write:
            return frozenset()
        words = self.spec.labels.words
        shown = (view.paths(frame)[view.objects(frame, words).shown] for frame in frames)
        return frozenset(int(number) for numbers in shown for number in numbers)

    # --- scenes ---

    def _stage(self, draw: Draw) -> _Stage:
        """Return the evaluated scene of a draw, from the cache if the draw repeats it."""
        unseeded = replace(draw, seed=0).scene_key  # of programs without random draws, which are equal for all seeds
        cached = self._cached_stages.get(draw.scene_key) or self._cached_stages.get(f"any {unseeded}")
        if cached is not None:
            return cached
        stage = self._evaluated(draw)
        is_large = any(
            primitive_count(other.scene.graph.root) > _LARGE_SCENE_PRIMITIVES
            for other in (stage, *self._cached_stages.values())
        )
        max_cached = 0 if is_large else _MAX_CACHED_SCENES - 1
        for old in list(self._cached_stages)[: max(0, len(self._cached_stages) - max_cached)]:
            del self._cached_stages[old]
        self._cached_stages[draw.scene_key if stage.draws else f"any {unseeded}"] = stage
        return stage

    def _evaluated(self, draw: Draw) -> _Stage:
        """Evaluate the program of a draw, and apply its looks; raises SceneError."""
        spec = self.spec
        bound = tuple(f"(bind {literal(word)}\n{text})" for word, text in draw.binds.items())
        source, params = named_program(draw.program, bound)[:2]
        known = {param.name for param in params}
        defines = {name: literal(_listed(value)) for name, value in draw.params.items() if name in known}
        options = Options(
            root=spec.root, seed=draw.seed, defines=defines, limits=spec.limits, project=Path(spec.folder),
            allow_outside=not Path(draw.program).is_relative_to(spec.folder),
        )  # fmt: skip
        self._watch(True)
        try:
            result = Session(options).evaluate(source)
            compute_all(() if result.scene is None else result.scene.frames)
        finally:
            self._watch(False)
        graph = result.require()
        scene = LoadedScene(graph, source.name, result.log, result.diagnostics, result.program, options)
        words = set(scene.words)
        for word, look in draw.looks.items():
            if word in words:
                scene = scene.restyled(word, **{name: _listed(value) for name, value in look.items()})
        box_of(scene.graph)
        scene = replace(scene, graph=drawn_scene(scene.graph, spec.limits.primitives))
        return _Stage(scene, SceneFacts(scene.graph), source.text, result.draws)

    def _frames(self, stage: _Stage) -> list[int]:
        """Return the numbers of the frames to render; raises SceneError if one does not exist."""
        count = len(stage.scene.frames)
        chosen = self.spec.pictures.frames
        first, last = chosen if chosen is not None else (0, count - 1)
        if last >= count:
            frames = f"{count} frame{'s' * (count != 1)}"
            raise SceneError("value", f"the scene has {frames}; frame {last} does not exist")
        return list(range(first, last + 1))

    def _view(self, stage: _Stage, draw: Draw, view: View, frames: Sequence[int]) -> LabeledView:
        """Return the view of a camera; painters, with the light of a scene, are shared by its cameras."""
        plan, backend = self.spec.pictures, self._backends[draw.quality]
        seed = int(stream(self.spec.seed, draw.index, draw.attempt, "noise").integers(1 << 31))
        options = PictureOptions(
            limit=self.spec.limits.primitives, settings=_settings_of(backend, plan.settings), width=plan.width,
            height=plan.height, camera=view, environment=draw.environment, seed=seed, labels=False,
            ground=draw.ground or ENVIRONMENTS[draw.environment].ground,  # its tone must not depend on other images
        )  # fmt: skip

        def painter(shots: Sequence[Shot]) -> Painter:
            """Return the painter of the stage for the same light and quality."""
            key = (
                draw.environment,
                draw.ground,
                tuple(frames),
                draw.quality,
                None if backend.name == "draft" else seed,
            )
            if key not in stage.painters:
                stage.painters.clear()
                (stage.painters[key],) = painters(stage.scene.graph, options, [backend], shots)
            return stage.painters[key]

        return LabeledView(stage.facts, options, frames, self.spec.labels.tracks, painter)


def _settings_of(backend: Backend, settings: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the spec's settings for a backend.

    Drafts are shaded by pixel: inside a surface once, with ambient light at every fourth pixel and shadow maps of the
    image's size. They differ from drafts of ``render`` by one level of 255 on average; with the light that cameras
    share, a labeled sample takes a fifth of the time of ``maps``. ``shading = "sample"`` in the settings gives the
    images of ``render``.
    """
    option_names = {option.name for option in backend.options}
    defaults = {"shading": "pixel"} if backend.name == "draft" else {}
    return {**defaults, **{name: value for name, value in (settings or {}).items() if name in option_names}}


def _in_terms_of_specs(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic whose hint names the keys of [limits] instead of the options of other commands."""
    if diagnostic.hint is None:
        return diagnostic
    return replace(diagnostic, hint=_LIMIT_OPTION.sub(r"`\1` in [limits]", diagnostic.hint))


def _listed(value: Any) -> Any:
    """Return a tuple as a list, other values unchanged."""
    return list(value) if isinstance(value, tuple) else value


# --- the files of one image ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _ItemWriter:
    """Makes the files of one image."""

    maker: Maker
    stage: _Stage
    draw: Draw
    view: LabeledView
    number: int
    frame: int
    key: str
    film: frozenset[int]

    @cached_property
    def objects(self) -> ObjectLabels:
        """Objects of the frame."""
        return self.view.objects(self.frame, self.maker.spec.labels.words)

    def files(self) -> Files:
        """Return the files by ending, encoded when they are read."""
        spec = self.maker.spec
        wanted = set(spec.labels.write)
        record = self._record(wanted)
        files: dict[str, Part] = {"color.png": partial(png, self.view.image(self.frame).picture)}
        files |= self._maps(wanted, record) | self._motion(wanted)
        if "captions" in wanted:
            record["caption"] = self._caption()
            files["txt"] = str(record["caption"]).encode()
        if "graph" in wanted:
            handles = lambda rows: self.view.some_handles(self.frame, rows)
            graph = labels.graph_data(self.objects.truth, handles, spec.labels.words)
            graph["relations"] = self._relations(graph["nodes"])
            files["graph.json"] = _json(graph)
        if "program" in wanted:
            files["program.scene"] = self.stage.text.encode("utf-8", "surrogatepass")
        return EncodedFiles({"json": _json(record), **files})

    def _relations(self, nodes: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
        """Return the relations of objects, by positions in the nodes of the scene graph."""
        place = {node["handle"]: number for number, node in enumerate(nodes)}
        words = sorted({node["word"] for node in nodes})
        relations = scene_relations(self.stage.scene.graph, words, self.frame)
        return [
            {"relation": r.relation, "subject": place[r.subject], "other": place[r.other], "distance": r.distance}
            for r in relations
            if r.subject in place and r.other in place
        ]

    def _record(self, wanted: set[str]) -> dict[str, Any]:
        """Return the JSON record of the image."""
        draw, spec = self.draw, self.maker.spec
        record: dict[str, Any] = {
            "key": self.key, "sample": key_of(draw.index), "index": draw.index, "attempt": draw.attempt,
            "split": draw.split, "view": self.number, "frame": self.frame, "spec": spec.digest,
            "values": draw.values, "word": self.stage.scene.word,
            "camera": _camera_data(self.view.shots[self.frame].camera),
            "counts": {word: n for word, n in count_words(self._root).items() if word in self.maker.classes},
        }  # fmt: skip
        if spec.splits is not None:
            record["scene"] = self.stage.digest[:32]
        if "boxes" in wanted or "visibility" in wanted or "instance" in wanted:
            covered = labels.pixels_alone(self.objects, *self.view.facts.unit) if "visibility" in wanted else None
            handles = self.view.some_handles(self.frame, self.objects.shown.tolist())
            record["things"] = labels.object_records(self.objects, handles, self.maker.classes, covered)
        if "boxes" in wanted and self.film:
            record["hidden"] = self._hidden()
        if "keypoints" in wanted:
            record["keypoints"] = labels.keypoint_records(self.objects, spec.labels.keypoints)
        return record

    def _hidden(self) -> list[dict[str, Any]]:
        """Return the objects inside the image that only other frames show."""
        paths, objects = self.view.paths(self.frame), self.objects
        others = np.flatnonzero(np.isin(paths, list(self.film)))
        return labels.hidden_records(objects, np.setdiff1d(others, objects.shown))

    @property
    def _root(self) -> Any:
        """Root of the frame."""
        return self.stage.scene.graph.frames[self.frame]

    def _maps(self, wanted: set[str], record: dict[str, Any]) -> dict[str, Part]:
        """Return the files of the maps; records of levels go to ``record``."""
        truth, files = self.objects.truth, dict[str, Part]()
        if "instance" in wanted:
            files["instance.png"] = partial(png, self.objects.ids)
        if "semantic" in wanted:
            files["semantic.png"] = partial(png, self.objects.classes(self.maker.classes))
        if "levels" in wanted:
            levels = labels.levels_data(self.objects, self.maker.spec.labels.levels)
            record["levels"] = [records for _, records in levels]
            files |= {f"level{depth}.png": partial(png, ids) for depth, (ids, _) in enumerate(levels, start=1)}
        if "depth" in wanted:
            files["depth.npy"] = partial(npy, truth.depth.astype(np.float32))
        if "normals" in wanted:
            code = np.where(truth.seen[:, :, None], np.rint(127.5 * (truth.normal + 1.0)), 0.0).astype(np.uint8)
            files["normals.png"] = partial(png, code)
        if "albedo" in wanted:
            files["albedo.png"] = partial(png, encode(truth.albedo))
        return files

    def _motion(self, wanted: set[str]) -> dict[str, Part]:
        """Return the files of flow, and of tracks with the first frame."""
        files: dict[str, Part] = {}
        flow = self.view.flow(self.frame) if "flow" in wanted else None
        if flow is not None:
            files |= {"flow.npy": partial(npy, flow.motion), "flow_state.png": partial(png, flow.state)}
        is_first = self.frame == next(iter(self.view.shots))
        if "tracks" in wanted and is_first and self.view.tracks is not None:
            tracks = self.view.tracks
            buffer = io.BytesIO()
            np.savez(buffer, pixels=tracks.pixels, world=tracks.world, state=tracks.state)
            files["tracks.npz"] = buffer.getvalue()
        return files

    def _caption(self) -> str:
        """Return a caption from a randomly chosen template."""
        templates = self.maker.spec.labels.captions or _DEFAULT_CAPTIONS
        random = stream(self.maker.spec.seed, self.draw.index, self.draw.attempt, "caption", self.number)
        template = templates[int(random.integers(len(templates)))]
        return _FIELD.sub(lambda match: self._field(match[1]), template)

    def _field(self, name: str) -> str:
        """Return the value of a field of a caption's template."""
        kind, _, rest = name.partition(":")
        counts = count_words(self._root)
        if kind == "count":
            return str(counts.get(rest, 0))
        if kind == "param" and rest in self.draw.params:
            return _spoken(self.draw.params[rest])
        if name == "word":
            return self.stage.scene.word
        if name == "environment":
            return self.draw.environment
        if name in ("things", "seen"):
            return self._listing(counts if name == "things" else self.seen)
        message = f"a caption has the unknown field `{{{name[:60]}}}`"
        hint = "known are {things}, {seen}, {word}, {environment}, {count:WORD} and {param:NAME}"
        raise SceneError(CODE, message, hint)

    @cached_property
    def seen(self) -> Mapping[str, int]:
        """Numbers of visible objects by word."""
        ancestry = self.objects.truth.ancestry
        return Counter(ancestry.entity(i).word for i in self.objects.shown.tolist())

    def _listing(self, counts: Mapping[str, int]) -> str:
        """Return the words of objects with their numbers, such as "3 pawns and 1 king"."""
        spec = self.maker.spec
        entities = {e.word: e for e in descendants(self._root)}
        chosen = spec.labels.words or [w for w, e in entities.items() if is_object(e) and e is not self._root]
        parts = [f"{counts[word]} {_plural(word, counts[word])}" for word in counts if word in chosen]
        return " and ".join(filter(None, [", ".join(parts[:-1]), *parts[-1:]])) or self.stage.scene.word


def _plural(word: str, count: int) -> str:
    """Return a word in the plural unless ``count`` is 1."""
    if count == 1 or word.endswith("s"):
        return word
    return word[:-1] + "ies" if word.endswith("y") and word[-2:-1] not in "aeiou" else word + "s"


def _spoken(value: Any) -> str:
    """Return a value as text of a caption."""
    if isinstance(value, tuple):
        return ", ".join(map(_spoken, value))
    return f"{value:.3g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)


def _placed(camera: Camera) -> dict[str, float]:
    """Return the direction of a camera in degrees, and its field of view, for statistics."""
    x, y, z = (-camera.forward).tolist()
    azimuth, elevation = math.degrees(math.atan2(x, z)), math.degrees(math.asin(min(1.0, max(-1.0, y))))
    angles = {"camera.azimuth": azimuth, "camera.elevation": elevation}
    if not camera.is_parallel:
        angles["camera.fov"] = 2.0 * math.degrees(math.atan(camera.height / 2.0 / camera.focal[1]))
    return {name: round(value, 3) for name, value in angles.items()}


def _camera_data(camera: Camera) -> dict[str, Any]:
    """Return a camera as JSON data, with its position."""
    return {**camera_to_json(camera), "eye": camera.eye.tolist()}


def _json(data: Any) -> bytes:
    """Return JSON data as bytes, sorted, so that equal records have equal bytes."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), default=_listed).encode("utf-8", "surrogatepass")


def png(values: npt.NDArray[Any]) -> bytes:
    """Encode (H, W) or (H, W, 3) of 8 bits, or (H, W) of 16 bits, as PNG."""
    buffer = io.BytesIO()
    image = require("PIL.Image", "pillow").fromarray(np.ascontiguousarray(values))
    image.save(buffer, "PNG", compress_level=1)
    return buffer.getvalue()


def npy(values: npt.NDArray[Any]) -> bytes:
    """Encode an array in numpy's own format."""
    buffer = io.BytesIO()
    np.save(buffer, np.ascontiguousarray(values), allow_pickle=False)
    return buffer.getvalue()


def decoded(name: str, data: bytes) -> Any:
    """Return the contents of a file of an item: an array, JSON data or a text; raises ValueError or OSError."""
    if name.endswith(".png"):
        with require("PIL.Image", "pillow").open(io.BytesIO(data)) as image:
            return np.asarray(image)
    if name.endswith((".npy", ".npz")):
        arrays = np.load(io.BytesIO(data), allow_pickle=False)
        return dict(arrays) if name.endswith(".npz") else arrays
    return json.loads(data) if name.endswith("json") else data.decode("utf-8", "replace")
