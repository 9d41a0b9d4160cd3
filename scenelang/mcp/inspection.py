"""Tools that inspect a scene: measures, instances, relations, contact sheets with overlays, and reference images.

They run in a worker, and only call the library.
"""

from __future__ import annotations

import colorsys
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import frame_of
from scenelang.backends.geometry.arrangement import Arrangement, PlacedObject, scene_relations
from scenelang.backends.labels.maps import maps_of
from scenelang.backends.pictures.images import Size, View, image_of, picture_options
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.inspection.instance_paths import Locator, outermost
from scenelang.interpreter.plugins import SERVICES
from scenelang.mcp.tools import Project, ProjectProgram, ToolAnswer, answer, camera_in, frame_in, of_scene
from scenelang.session.declarations import declarations_of
from scenelang.session.loaded import LoadedScene, scene_from
from scenelang.session.session import Options, Session

if TYPE_CHECKING:
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Scene
    from scenelang.session.session import Evaluated

Pixels = npt.NDArray[np.uint8]

OVERLAYS = ("none", "word", "instance", "depth")
CAMERAS = ("isometric", "azimuth=0,elevation=5", "azimuth=90,elevation=5", "top")
MAX_CAMERAS = 6  # of a contact sheet
MAX_REFERENCE_BYTES = 20_000_000  # of a reference image
STRIP_FRAMES = (3, 8)  # least and greatest number of frames of a strip
_SHEET_PX = 1024  # longer side of a sheet
_STRIP_PX = 2048  # width of a strip
_REFERENCE_HEIGHT_PX = 384  # of both images of a comparison
_MAX_LEGEND_ENTRIES = 24  # entries
_LEGEND_ROW_PX = 14  # line of the legend
_OVERLAY_OPACITY = 0.6  # opacity of an overlay over the image
_MAX_INSTANCES = 20  # instances that are listed in one call
_MAX_PAIRS = 400  # of instances whose distance is measured in one call
_SINGLE = ("supported", "symmetric", "evenly-spaced", "aligned")
_DOUBLE = (
    "on", "inside", "touching", "clear-of", "facing", "above", "below", "left-of", "right-of", "in-front-of", "behind",
)  # fmt: skip


def _api(result: Evaluated, project: Project) -> LoadedScene:
    """Return the scene of an evaluation as a Python object."""
    return scene_from(LoadedScene, result, "<program>", Options(limits=project.limits, project=project.root))


def _number(value: float) -> str:
    """Return a number with five digits."""
    return f"{value + 0.0:.5g}"


def _triple(values: Any) -> str:
    """Return numbers as a vector of the language."""
    return "[" + " ".join(_number(float(x)) for x in values) + "]"


def _rounded(values: Any) -> list[float]:
    """Return numbers for JSON data, rounded."""
    return [round(float(x), 6) for x in values]


# --- query -----------------------------------------------------------------------------------------------------------


def query(project: Project, program: ProjectProgram, path: str, frame: int) -> ToolAnswer:
    """Return the instances that a path denotes: poses, boxes, attributes and lines of the text."""

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        """Return the answer for an evaluated scene."""
        number = frame_in(scene, frame)
        count = len(Locator(scene, number).find(path or "*"))
        instances = _api(result, project).instances(path or "*", number, _MAX_INSTANCES)
        lines = [f"{count:,} instance{'s' * (count != 1)} of {path or '*'}"]
        for instance in instances:
            parts = [instance.path, f"<{instance.handle}>"]
            parts.append(f"at {_triple(instance.pose[:3, 3])}")
            if instance.box is not None:
                parts.append(f"box {_triple(instance.box[0])} to {_triple(instance.box[1])}")
            if instance.attributes:
                parts.append(" ".join(f":{name} {value}" for name, value in instance.attributes.items())[:120])
            places = [("defined", instance.definition), ("made", instance.place)]
            parts += [f"{role} in line {span.source.position(span.start)[0]}" for role, span in places if span]
            lines.append("  ".join(parts))
        omitted = count - len(instances)
        lines += [f"... and {omitted:,} more; name fewer, such as {path or '*'}[{len(instances)}]"] if omitted else []
        data: dict[str, Any] = {
            "ok": True,
            "count": count,
            "instances": [_with_rounded(instance.data()) for instance in instances],
        }
        return answer(lines, data | ({"instances_left_out": omitted} if omitted else {}))

    return of_scene(project, program, reply)


def _with_rounded(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data of an instance with its position instead of its whole pose, and short numbers."""
    pose, box = data.pop("pose"), data["box"]
    data["at"] = _rounded(row[3] for row in pose)
    if any(abs(pose[i][j] - (i == j)) > 1e-9 for i in range(3) for j in range(3)):
        data["axes"] = [_rounded(row[:3]) for row in pose]
    data["box"] = None if box is None else [_rounded(corner) for corner in box]
    return data


# --- measure ---------------------------------------------------------------------------------------------------------


def measure(project: Project, program: ProjectProgram, a: str, b: str, that: Sequence[str], frame: int) -> ToolAnswer:
    """Measure the scene, the instances of a path, or two paths; and test declarations."""

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        """Return the answer for an evaluated scene."""
        number = frame_in(scene, frame)
        data: dict[str, Any] = {"ok": True}
        lines: list[str] = []
        arrangement = Arrangement(scene, number)
        if b and not a:
            raise SceneError("value", "`b` needs `a`, the thing that is compared with it")
        _add_boxes(arrangement, [name for name in (a, b) if name] or [""], lines, data)
        if a and not b:
            _add_volume(_api(result, project), a, number, lines, data)
        if a and b:
            _add_distance(arrangement, a, b, lines, data)
        declarations = [f'({name} "{_quoted(a)}" "{_quoted(b)}")' for name in _DOUBLE] if b else []
        declarations += [f'({name} "{_quoted(a)}")' for name in _SINGLE] if a and not b else []
        _add_relations(scene, project, [*that], declarations, lines, data)
        return answer(lines, data)

    return of_scene(project, program, reply)


def _quoted(text: str) -> str:
    """Return a text with backslashes and quotes escaped."""
    return text.replace("\\", "\\\\").replace('"', '\\"')


def _instances_named(arrangement: Arrangement, name: str) -> list[PlacedObject]:
    """Return the outermost instances of a path; raises SceneError with a hint if there are none."""
    instances = arrangement.objects(name)
    if not instances:
        Locator(arrangement.scene, arrangement.scene.frames.index(arrangement.root)).find(
            name
        )  # raises, or it has no primitives
        raise SceneError("empty-scene", f"`{name}` has no geometry")
    return instances


def _add_boxes(arrangement: Arrangement, names: Sequence[str], lines: list[str], data: dict[str, Any]) -> None:
    """Add the boxes of the instances of each path; an empty one is the whole scene."""
    boxes: list[dict[str, Any]] = []
    for name in names:
        instances = _instances_named(arrangement, name) if name else [arrangement.object_at(0)]
        for instance in instances[:_MAX_INSTANCES]:
            low, high = arrangement.box(instance)
            path = arrangement.path(instance)
            lines.append(f"{path}: box {_triple(low)} to {_triple(high)}, size {_triple(high - low)}")
            boxes.append({"path": path, "box": [_rounded(low), _rounded(high)], "size": _rounded(high - low)})
        if len(instances) > _MAX_INSTANCES:
            lines.append(f"... and {len(instances) - _MAX_INSTANCES:,} more of `{name}`")
    data["boxes"] = boxes


def _add_volume(scene: LoadedScene, path: str, frame: int, lines: list[str], data: dict[str, Any]) -> None:
    """Add volume, surface and centroid, or the reason why they are unknown."""
    try:
        measures = scene.measure(path, frame)
    except SceneError as error:
        lines.append(f"no volume: {error.message}")
        return
    lines.append(
        f"volume {_number(measures.volume)}, surface {_number(measures.area)}, center {_triple(measures.centroid)}"
    )
    data |= {
        "volume": round(measures.volume, 9),
        "area": round(measures.area, 9),
        "centroid": _rounded(measures.centroid),
    }


def _add_distance(arrangement: Arrangement, a: str, b: str, lines: list[str], data: dict[str, Any]) -> None:
    """Add the distance, or the penetration depth, of the nearest pair of instances."""
    first, second = _instances_named(arrangement, a), _instances_named(arrangement, b)
    pairs = [
        (a_instance, b_instance)
        for a_instance in first
        for b_instance in second
        if a_instance.instance != b_instance.instance
    ]
    if len(pairs) > _MAX_PAIRS:
        raise SceneError("primitives", f"{len(pairs):,} pairs are too many to measure; name fewer, such as `{a}[0]`")
    separations = [(pair, separation) for pair in pairs if (separation := arrangement.separation(*pair)) is not None]
    if not separations:
        lines.append("there is no second thing with a solid part to measure")
        return
    (a_instance, b_instance), nearest = min(separations, key=lambda candidate: candidate[1].distance)
    names = f"{arrangement.path(a_instance)} and {arrangement.path(b_instance)}"
    low, high = arrangement.box(a_instance)
    under, over = arrangement.box(b_instance)
    gaps = np.maximum(low - over, under - high)
    relation = (
        f"overlap by {_number(-nearest.distance)}" if nearest.distance < 0 else f"distance {_number(nearest.distance)}"
    )
    lines.append(f"{names}: {relation}; clearance of the boxes along x y z {_triple(gaps)}")
    data |= {
        "nearest": [arrangement.path(a_instance), arrangement.path(b_instance)],
        "distance": round(nearest.distance, 9),
        "clearance": _rounded(gaps),
        "centers": _rounded(arrangement.center(b_instance) - arrangement.center(a_instance)),
    }
    lines.append(f"from center to center {_triple(arrangement.center(b_instance) - arrangement.center(a_instance))}")


def _add_relations(
    scene: Scene,
    project: Project,
    requested: Sequence[str],
    usual: Sequence[str],
    lines: list[str],
    data: dict[str, Any],
) -> None:
    """Add which declarations hold, and how far the requested ones are from holding."""
    from scenelang.backends.geometry.relations import violations

    session = Session(Options(limits=project.limits, project=project.root))
    results: list[dict[str, Any]] = []
    for text in [*requested, *usual]:
        declarations = declarations_of(session, text)
        try:
            failed = violations(scene, declarations, partial(_is_among, declarations))
        except SceneError as error:
            if text in requested:
                raise
            lines.append(f"{text}: {error.message}")
            continue
        if failed and text in requested:
            worst = max(failed, key=lambda violation: violation.amount)
            move = f"; {_triple(worst.move)} would fix it" if worst.move is not None else ""
            lines.append(f"{text}: no, {worst.message}{move}")
            moved = {"move": _rounded(worst.move)} if worst.move is not None else {}
            results.append({"that": text, "holds": False, "message": worst.message, **moved})
        elif not failed:
            lines.append(f"{text}: holds")
            results.append({"that": text, "holds": True})
        else:
            results.append({"that": text, "holds": False})
    failed_texts = [result["that"] for result in results if not result["holds"] and result["that"] not in requested]
    if failed_texts:
        lines.append(f"do not hold: {', '.join(text.split(' ')[0].strip('(') for text in failed_texts)}")
    if results:
        data["holds"] = [result["that"] for result in results if result["holds"]]
        data["fails"] = [result for result in results if not result["holds"] and result["that"] in requested]


def _is_among(declarations: Sequence[Declaration], declaration: Declaration) -> bool:
    """Return whether a declaration is one of several, by identity."""
    return any(declaration is other for other in declarations)


def _pixels(scene: Scene, camera: View | None, size: Size, frame: int) -> Pixels:
    """Return a draft image (H, W, 3) of a frame."""
    image = image_of(scene, picture_options(camera, size, frame=frame))
    return np.ascontiguousarray(image.pixels[:, :, :3])


def related(project: Project, program: ProjectProgram, words: Sequence[str], frame: int) -> ToolAnswer:
    """Return the pairs of objects that are on, inside, touching or overlapping each other."""

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        """Return the answer for an evaluated scene."""
        relations = scene_relations(scene, set(words) or None, frame_in(scene, frame))
        lines = [
            f"{r.subject_word} <{r.subject}> {r.relation} {r.other_word} <{r.other}>"
            + (f" by {_number(-r.distance)}" if r.relation == "overlapping" else "")
            for r in relations
        ]
        data = [[r.subject_word, r.subject, r.relation, r.other_word, r.other] for r in relations]
        return answer(lines or ["nothing touches anything"], {"ok": True, "relations": data})

    return of_scene(project, program, reply)


# --- contact sheets --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SheetView:
    """Contents of a contact sheet.

    These are cameras, an overlay, a frame, the path of a part (empty: the whole scene), and the side of each image in
    pixels.
    """

    cameras: tuple[str, ...] = CAMERAS
    overlay: str = "none"
    frame: int = 0
    part: str = ""
    side: int = 384


def views(project: Project, program: ProjectProgram, view: SheetView) -> ToolAnswer:
    """Draw a contact sheet."""
    if view.overlay not in OVERLAYS:
        raise _wrong(f"unknown overlay `{view.overlay[:40]}`; expected {', '.join(OVERLAYS)}")
    if not 1 <= len(view.cameras) <= MAX_CAMERAS:
        raise _wrong(f"expected 1 to {MAX_CAMERAS} cameras, got {len(view.cameras)}")
    cameras = [camera_in(project, camera) for camera in view.cameras]
    columns = min(len(cameras), 3 if len(cameras) > 4 else 2)
    side = min(view.side, _SHEET_PX // columns)

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        """Return the answer for an evaluated scene."""
        frame = frame_in(scene, view.frame)
        sheet = _Sheet(_api(result, project), scene, frame, view)
        cells = [sheet.cell(camera, (side, side)) for camera in cameras]
        png = sheet.png(cells, columns, view.cameras)
        about = view.part or scene.word
        lines = [f"{about}, {len(cells)} views from left to right and top to bottom: {'; '.join(view.cameras)}"]
        return ToolAnswer("\n".join([*lines, *sheet.legend_lines()]), None, png)

    return of_scene(project, program, reply)


def _wrong(message: str) -> Exception:
    """Return the error for an invalid call."""
    from scenelang.mcp.tools import WrongArguments

    return WrongArguments(message)


class _Sheet:
    """Images of a scene with an overlay, and the legend of its colors."""

    def __init__(self, api: LoadedScene, scene: Scene, frame: int, view: SheetView) -> None:
        """Select the part of the view; paths in the legend remain those of the whole scene."""
        self._scene = api.part(view.part) if view.part else api
        self._frame, self._overlay = frame, view.overlay
        self._locator = Locator(scene, frame)
        roots = list(outermost(self._locator.find(view.part))) if view.part else []
        self._origins = [root.positions for root in roots if root.positions]
        self._legend: dict[str, tuple[int, int, int]] = {}
        self._depths: list[tuple[float, float]] = []

    def cell(self, camera: Any, size: tuple[int, int]) -> Pixels:
        """Draw one image."""
        if self._overlay == "none":
            return self.picture(camera, size, self._frame)
        maps = maps_of(self._scene.graph, picture_options(camera, size, frame=self._frame))
        if self._overlay == "depth":
            return self._depth(maps["depth"])
        picture = maps["color"].astype(np.float64)
        for mask, name in self._masks(maps):
            picture[mask] = (1.0 - _OVERLAY_OPACITY) * picture[mask] + _OVERLAY_OPACITY * np.array(self._color(name))
        return picture.astype(np.uint8)

    def picture(self, camera: Any, size: tuple[int, int], frame: int) -> Pixels:
        """Draw a frame without an overlay."""
        return _pixels(self._scene.graph, camera, size, frame)

    def _masks(self, maps: Any) -> list[tuple[npt.NDArray[np.bool_], str]]:
        """Return the pixels of each visible word or object, with its name."""
        from scenelang.backends.labels.object_labels import objects_of

        truth = maps.truth
        objects = objects_of(truth)
        masks = []
        for number, instance in enumerate(objects.shown.tolist(), 1):
            mask = objects.ids == number
            if mask.any():
                entity = truth.ancestry.entity(instance)
                name = entity.word if self._overlay == "word" else self._path(truth.ancestry.path(instance))
                masks.append((mask, name))
        return masks

    def _path(self, positions: tuple[int, ...]) -> str:
        """Return the path in the scene of an instance of the image."""
        if self._origins and positions:
            positions = (*self._origins[positions[0]], *positions[1:])
        return self._locator.path(positions)

    def _color(self, name: str) -> tuple[int, int, int]:
        """Return the color of a name; a golden-ratio sequence of hues keeps successive colors apart."""
        if name not in self._legend:
            hue = (0.61803398875 * len(self._legend)) % 1.0
            r, g, b = colorsys.hsv_to_rgb(hue, 0.85, 1.0 if len(self._legend) % 2 else 0.75)
            self._legend[name] = (int(255 * r), int(255 * g), int(255 * b))
        return self._legend[name]

    def _depth(self, depth: npt.NDArray[np.float64]) -> Pixels:
        """Draw near as white and far as dark gray, on black."""
        is_visible = np.isfinite(depth)
        if not is_visible.any():
            return np.zeros((*depth.shape, 3), np.uint8)
        near, far = float(depth[is_visible].min()), float(depth[is_visible].max())
        self._depths.append((near, far))
        shade = np.where(is_visible, 255.0 - 205.0 * (depth - near) / max(far - near, 1e-12), 0.0)
        return np.repeat(np.nan_to_num(shade)[:, :, None], 3, axis=2).astype(np.uint8)

    def legend_lines(self) -> list[str]:
        """Return the legend as text."""
        if self._overlay == "depth":
            return [f"view {k}: white is {near:.4g} from the camera, dark grey {far:.4g}"
                    for k, (near, far) in enumerate(self._depths, 1)]  # fmt: skip
        names = [f"{name} #{r:02x}{g:02x}{b:02x}" for name, (r, g, b) in self._legend.items()]
        left = len(names) - _MAX_LEGEND_ENTRIES
        return [*names[:_MAX_LEGEND_ENTRIES], *([f"... and {left:,} more colors"] if left > 0 else [])]

    def png(self, cells: Sequence[Pixels], columns: int, labels: Sequence[str]) -> bytes:
        """Return the sheet with the cameras above the images and the legend below."""
        from PIL import Image, ImageDraw

        height, width = cells[0].shape[:2]
        rows = -(-len(cells) // columns)
        names = list(self._legend.items())[:_MAX_LEGEND_ENTRIES]
        per_row = max(1, columns * width // 160)
        below = _LEGEND_ROW_PX * -(-len(names) // per_row)
        sheet = Image.new("RGB", (columns * width, rows * (height + _LEGEND_ROW_PX) + below), "white")
        draw = ImageDraw.Draw(sheet)
        for k, cell in enumerate(cells):
            x, y = k % columns * width, k // columns * (height + _LEGEND_ROW_PX)
            draw.text((x + 3, y + 1), _ascii(labels[k])[: width // 6], fill="black")
            sheet.paste(Image.fromarray(np.ascontiguousarray(cell)), (x, y + _LEGEND_ROW_PX))
        for k, (name, color) in enumerate(names):
            x, y = (
                k % per_row * (columns * width // per_row),
                rows * (height + _LEGEND_ROW_PX) + k // per_row * _LEGEND_ROW_PX,
            )
            draw.rectangle((x + 3, y + 2, x + 12, y + 11), fill=color)
            draw.text((x + 16, y + 1), _ascii(name)[:22], fill="black")
        return _png(sheet)


def _ascii(text: str) -> str:
    """Return a text with other characters replaced, which the font lacks."""
    return text.encode("ascii", "replace").decode("ascii")


def _png(image: Any) -> bytes:
    """Return an image as PNG."""
    stream = io.BytesIO()
    image.save(stream, "PNG")
    return stream.getvalue()


# --- strips ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class StripView:
    """Contents of a strip: the frames (empty: ``count`` of them, evenly apart), camera, part and side in pixels."""

    frames: tuple[int, ...] = ()
    count: int = 5
    camera: str = ""
    part: str = ""
    side: int = 256


def strip(project: Project, program: ProjectProgram, view: StripView) -> ToolAnswer:
    """Draw frames of a film side by side, with their numbers."""
    camera = camera_in(project, view.camera)

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        """Return the answer for an evaluated scene."""
        last = len(scene.frames) - 1
        if not scene.animated or last == 0:
            raise _wrong("the scene has one frame; call `views`")
        even = sorted({round(last * k / (view.count - 1)) for k in range(view.count)})
        numbers = [frame_in(scene, number) for number in view.frames or even]
        side = min(view.side, _STRIP_PX // len(numbers))
        sheet = _Sheet(_api(result, project), scene, 0, SheetView(part=view.part))
        cells = [sheet.picture(camera, (side, side), number) for number in numbers]
        labels = [f"frame {number}" for number in numbers]
        lines = [f"{view.part or scene.word}, from left to right frames {', '.join(map(str, numbers))} of 0 to {last}"]
        return ToolAnswer("\n".join(lines), None, sheet.png(cells, len(cells), labels))

    return of_scene(project, program, reply)


# --- reference images ----------------------------------------------------------------------------------------------


def compare(
    project: Project, program: ProjectProgram, reference: str, camera: str, frame: int, score: bool = False
) -> ToolAnswer:
    """Draw the scene next to an image of the project; with ``score``, also their CLIP similarity."""
    from scenelang.backends.pictures.film import open_image

    file = project.file(reference)
    if file.stat().st_size > MAX_REFERENCE_BYTES:
        raise _wrong(f"the picture exceeds {MAX_REFERENCE_BYTES:,} bytes")
    placed = camera_in(project, camera)
    try:
        wanted = open_image(file)
    except SceneError as error:
        raise _wrong(error.message.replace(str(project.root), ".")) from None

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        """Return the answer for an evaluated scene."""
        from PIL import Image

        number = frame_of(scene, frame)
        height = _REFERENCE_HEIGHT_PX
        width = int(np.clip(round(wanted.width * height / max(wanted.height, 1)), 128, 640))
        ours = Image.fromarray(_pixels(scene, placed, (width, height), number))
        sheet = Image.new("RGB", (2 * width, height), "white")
        sheet.paste(wanted.resize((width, height)), (0, 0))
        sheet.paste(ours, (width, 0))
        lines = [f"left: {file.name}; right: {scene.word}", *([_score(wanted, ours)] if score else [])]
        return ToolAnswer("\n".join(lines), None, _png(sheet))

    return of_scene(project, program, reply)


def _score(wanted: Any, ours: Any) -> str:
    """Return the CLIP similarity of two images, or why it is unknown."""
    if find_spec("open_clip") is None or find_spec("torch") is None:
        return "no score: CLIP is not installed"
    try:
        cosine = SERVICES.find("image-similarity")(wanted, ours)
    except (SceneError, OSError) as error:
        return f"no score: {getattr(error, 'message', None) or type(error).__name__}"
    return f"CLIP similarity {cosine:.3f} (1: the same)"
