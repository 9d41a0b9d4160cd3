"""Tools that look at a scene: measures, instances, relations, contact sheets with overlays, and reference images.

They run in a worker, and are thin calls of the library.
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
MAX_CAMERAS = 6
MAX_REFERENCE = 20_000_000  # bytes
_SHEET = 1024  # pixels of the longer side of a sheet
_REFERENCE_HEIGHT = 384  # pixels
_LEGEND = 24  # entries
_ROW = 14  # pixels of a line of the legend
_SHARE = 0.6  # of an overlay, over the image
_THINGS = 20  # that are measured in one call
_PAIRS = 400
_SINGLE = ("supported", "symmetric", "evenly-spaced", "aligned")
_DOUBLE = (
    "on", "inside", "touching", "clear-of", "facing", "above", "below", "left-of", "right-of", "in-front-of", "behind",
)  # fmt: skip


def _api(result: Evaluated, project: Project) -> LoadedScene:
    return scene_from(LoadedScene, result, "<program>", Options(limits=project.limits, project=project.root))


def _number(value: float) -> str:
    return f"{value + 0.0:.5g}"


def _triple(values: Any) -> str:
    return "[" + " ".join(_number(float(x)) for x in values) + "]"


def _rounded(values: Any) -> list[float]:
    return [round(float(x), 6) for x in values]


# --- query -----------------------------------------------------------------------------------------------------------


def query(project: Project, program: ProjectProgram, path: str, frame: int) -> ToolAnswer:
    """Return the instances that a path means: poses, boxes, attributes and places in the text."""

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        number = frame_in(scene, frame)
        count = len(Locator(scene, number).find(path or "*"))
        found = _api(result, project).instances(path or "*", number, _THINGS)
        lines = [f"{count:,} instance{'s' * (count != 1)} of {path or '*'}"]
        for each in found:
            parts = [each.path, f"<{each.handle}>"]
            parts.append(f"at {_triple(each.pose[:3, 3])}")
            if each.box is not None:
                parts.append(f"box {_triple(each.box[0])} to {_triple(each.box[1])}")
            if each.attributes:
                parts.append(" ".join(f":{name} {value}" for name, value in each.attributes.items())[:120])
            places = [("defined", each.definition), ("made", each.place)]
            parts += [f"{what} in line {span.source.position(span.start)[0]}" for what, span in places if span]
            lines.append("  ".join(parts))
        left = count - len(found)
        lines += [f"... and {left:,} more; name fewer, such as {path or '*'}[{len(found)}]"] if left else []
        data: dict[str, Any] = {"ok": True, "count": count, "instances": [_with_rounded(each.data()) for each in found]}
        return answer(lines, data | ({"instances_left_out": left} if left else {}))

    return of_scene(project, program, reply)


def _with_rounded(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data of an instance with its place instead of its whole pose, and short numbers."""
    pose, box = data.pop("pose"), data["box"]
    data["at"] = _rounded(row[3] for row in pose)
    if any(abs(pose[i][j] - (i == j)) > 1e-9 for i in range(3) for j in range(3)):
        data["axes"] = [_rounded(row[:3]) for row in pose]
    data["box"] = None if box is None else [_rounded(corner) for corner in box]
    return data


# --- measure ---------------------------------------------------------------------------------------------------------


def measure(project: Project, program: ProjectProgram, a: str, b: str, that: Sequence[str], frame: int) -> ToolAnswer:
    """Measure the scene, the things of a path, or two things; and test declarations."""

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        number = frame_in(scene, frame)
        data: dict[str, Any] = {"ok": True}
        lines: list[str] = []
        here = Arrangement(scene, number)
        if b and not a:
            raise SceneError("value", "`b` needs `a`, the thing that is compared with it")
        _add_boxes(here, [name for name in (a, b) if name] or [""], lines, data)
        if a and not b:
            _add_volume(_api(result, project), a, number, lines, data)
        if a and b:
            _add_distance(here, a, b, lines, data)
        stated = [f'({name} "{_quoted(a)}" "{_quoted(b)}")' for name in _DOUBLE] if b else []
        stated += [f'({name} "{_quoted(a)}")' for name in _SINGLE] if a and not b else []
        _add_relations(scene, project, [*that], stated, lines, data)
        return answer(lines, data)

    return of_scene(project, program, reply)


def _quoted(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')


def _things(here: Arrangement, name: str) -> list[PlacedObject]:
    """Return the things of a path; raises SceneError with a hint if there are none."""
    found = here.objects(name)
    if not found:
        Locator(here.scene, here.scene.frames.index(here.root)).find(name)  # raises, or it has no primitives
        raise SceneError("empty-scene", f"`{name}` has no geometry")
    return found


def _add_boxes(here: Arrangement, names: Sequence[str], lines: list[str], data: dict[str, Any]) -> None:
    boxes: list[dict[str, Any]] = []
    for name in names:
        things = _things(here, name) if name else [here.object_at(0)]
        for thing in things[:_THINGS]:
            low, high = here.box(thing)
            path = here.path(thing)
            lines.append(f"{path}: box {_triple(low)} to {_triple(high)}, size {_triple(high - low)}")
            boxes.append({"path": path, "box": [_rounded(low), _rounded(high)], "size": _rounded(high - low)})
        if len(things) > _THINGS:
            lines.append(f"... and {len(things) - _THINGS:,} more of `{name}`")
    data["boxes"] = boxes


def _add_volume(scene: LoadedScene, path: str, frame: int, lines: list[str], data: dict[str, Any]) -> None:
    try:
        found = scene.measure(path, frame)
    except SceneError as error:
        lines.append(f"no volume: {error.message}")
        return
    lines.append(f"volume {_number(found.volume)}, surface {_number(found.area)}, centre {_triple(found.centroid)}")
    data |= {"volume": round(found.volume, 9), "area": round(found.area, 9), "centroid": _rounded(found.centroid)}


def _add_distance(here: Arrangement, a: str, b: str, lines: list[str], data: dict[str, Any]) -> None:
    """Add the distance, or the depth of the overlap, of the nearest pair of things."""
    first, second = _things(here, a), _things(here, b)
    pairs = [(one, other) for one in first for other in second if one.instance != other.instance]
    if len(pairs) > _PAIRS:
        raise SceneError("primitives", f"{len(pairs):,} pairs are too many to measure; name fewer, such as `{a}[0]`")
    found = [(pair, separation) for pair in pairs if (separation := here.separation(*pair)) is not None]
    if not found:
        lines.append("there is no second thing with a solid part to measure")
        return
    (one, other), nearest = min(found, key=lambda each: each[1].distance)
    names = f"{here.path(one)} and {here.path(other)}"
    low, high = here.box(one)
    under, over = here.box(other)
    gaps = np.maximum(low - over, under - high)
    what = (
        f"overlap by {_number(-nearest.distance)}" if nearest.distance < 0 else f"distance {_number(nearest.distance)}"
    )
    lines.append(f"{names}: {what}; clearance of the boxes along x y z {_triple(gaps)}")
    data |= {
        "nearest": [here.path(one), here.path(other)],
        "distance": round(nearest.distance, 9),
        "clearance": _rounded(gaps),
        "centres": _rounded(here.center(other) - here.center(one)),
    }
    lines.append(f"from centre to centre {_triple(here.center(other) - here.center(one))}")


def _add_relations(
    scene: Scene, project: Project, asked: Sequence[str], usual: Sequence[str], lines: list[str], data: dict[str, Any]
) -> None:
    """Add which declarations hold, and how far the asked ones are from holding."""
    from scenelang.backends.geometry.relations import violations

    session = Session(Options(limits=project.limits, project=project.root))
    results: list[dict[str, Any]] = []
    for text in [*asked, *usual]:
        stated = declarations_of(session, text)
        try:
            failed = violations(scene, stated, partial(_is_among, stated))
        except SceneError as error:
            if text in asked:
                raise
            lines.append(f"{text}: {error.message}")
            continue
        if failed and text in asked:
            worst = max(failed, key=lambda each: each.amount)
            move = f"; {_triple(worst.move)} would fix it" if worst.move is not None else ""
            lines.append(f"{text}: no, {worst.message}{move}")
            moved = {"move": _rounded(worst.move)} if worst.move is not None else {}
            results.append({"that": text, "holds": False, "message": worst.message, **moved})
        elif not failed:
            lines.append(f"{text}: holds")
            results.append({"that": text, "holds": True})
        else:
            results.append({"that": text, "holds": False})
    false = [each["that"] for each in results if not each["holds"] and each["that"] not in asked]
    if false:
        lines.append(f"do not hold: {', '.join(text.split(' ')[0].strip('(') for text in false)}")
    if results:
        data["holds"] = [each["that"] for each in results if each["holds"]]
        data["fails"] = [each for each in results if not each["holds"] and each["that"] in asked]


def _is_among(stated: Sequence[Declaration], declaration: Declaration) -> bool:
    return any(declaration is each for each in stated)


def _pixels(scene: Scene, camera: View | None, size: Size, frame: int) -> Pixels:
    """Return a draft image (H, W, 3) of a frame."""
    image = image_of(scene, picture_options(camera, size, frame=frame))
    return np.ascontiguousarray(image.pixels[:, :, :3])


def related(project: Project, program: ProjectProgram, words: Sequence[str], frame: int) -> ToolAnswer:
    """Return what is on, inside of, touching or overlapping what."""

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        found = scene_relations(scene, set(words) or None, frame_in(scene, frame))
        lines = [
            f"{r.subject_word} <{r.subject}> {r.relation} {r.other_word} <{r.other}>"
            + (f" by {_number(-r.distance)}" if r.relation == "overlapping" else "")
            for r in found
        ]
        data = [[r.subject_word, r.subject, r.relation, r.other_word, r.other] for r in found]
        return answer(lines or ["nothing touches anything"], {"ok": True, "relations": data})

    return of_scene(project, program, reply)


# --- contact sheets --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SheetView:
    """What a contact sheet shows: cameras, an overlay, a frame, the path of a part (empty: everything), and the side of
    each image in pixels."""

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
    side = min(view.side, _SHEET // columns)

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        frame = frame_in(scene, view.frame)
        sheet = _Sheet(_api(result, project), scene, frame, view)
        cells = [sheet.cell(camera, (side, side)) for camera in cameras]
        png = sheet.png(cells, columns, view.cameras)
        about = view.part or scene.word
        lines = [f"{about}, {len(cells)} views from left to right and top to bottom: {'; '.join(view.cameras)}"]
        return ToolAnswer("\n".join([*lines, *sheet.legend_lines()]), None, png)

    return of_scene(project, program, reply)


def _wrong(message: str) -> Exception:
    from scenelang.mcp.tools import WrongArguments

    return WrongArguments(message)


class _Sheet:
    """Images of a scene with an overlay, and the legend of its colors."""

    def __init__(self, api: LoadedScene, scene: Scene, frame: int, view: SheetView) -> None:
        self._scene = api.part(view.part) if view.part else api
        self._frame, self._overlay = frame, view.overlay
        self._locator = Locator(scene, frame)
        found = list(outermost(self._locator.find(view.part))) if view.part else []
        self._origins = [each.positions for each in found if each.positions]
        self._legend: dict[str, tuple[int, int, int]] = {}
        self._depths: list[tuple[float, float]] = []

    def cell(self, camera: Any, size: tuple[int, int]) -> Pixels:
        """Draw one image."""
        if self._overlay == "none":
            return _pixels(self._scene.graph, camera, size, self._frame)
        maps = maps_of(self._scene.graph, picture_options(camera, size, frame=self._frame))
        if self._overlay == "depth":
            return self._depth(maps["depth"])
        picture = maps["color"].astype(np.float64)
        for mask, name in self._masks(maps):
            picture[mask] = (1.0 - _SHARE) * picture[mask] + _SHARE * np.array(self._color(name))
        return picture.astype(np.uint8)

    def _masks(self, maps: Any) -> list[tuple[npt.NDArray[np.bool_], str]]:
        """Return the pixels of each visible word or thing, with its name."""
        from scenelang.backends.labels.object_labels import objects_of

        truth = maps.truth
        objects = objects_of(truth)
        found = []
        for number, instance in enumerate(objects.shown.tolist(), 1):
            mask = objects.ids == number
            if mask.any():
                entity = truth.ancestry.entity(instance)
                name = entity.word if self._overlay == "word" else self._path(truth.ancestry.path(instance))
                found.append((mask, name))
        return found

    def _path(self, positions: tuple[int, ...]) -> str:
        """Return the path in the scene of an instance of the image."""
        if self._origins and positions:
            positions = (*self._origins[positions[0]], *positions[1:])
        return self._locator.path(positions)

    def _color(self, name: str) -> tuple[int, int, int]:
        if name not in self._legend:
            hue = (0.61803398875 * len(self._legend)) % 1.0  # far from those before
            r, g, b = colorsys.hsv_to_rgb(hue, 0.85, 1.0 if len(self._legend) % 2 else 0.75)
            self._legend[name] = (int(255 * r), int(255 * g), int(255 * b))
        return self._legend[name]

    def _depth(self, depth: npt.NDArray[np.float64]) -> Pixels:
        """Draw near as white and far as dark gray, on black."""
        seen = np.isfinite(depth)
        if not seen.any():
            return np.zeros((*depth.shape, 3), np.uint8)
        near, far = float(depth[seen].min()), float(depth[seen].max())
        self._depths.append((near, far))
        shade = np.where(seen, 255.0 - 205.0 * (depth - near) / max(far - near, 1e-12), 0.0)
        return np.repeat(np.nan_to_num(shade)[:, :, None], 3, axis=2).astype(np.uint8)

    def legend_lines(self) -> list[str]:
        """Return the legend as text."""
        if self._overlay == "depth":
            return [f"view {k}: white is {near:.4g} from the camera, dark grey {far:.4g}"
                    for k, (near, far) in enumerate(self._depths, 1)]  # fmt: skip
        names = [f"{name} #{r:02x}{g:02x}{b:02x}" for name, (r, g, b) in self._legend.items()]
        left = len(names) - _LEGEND
        return [*names[:_LEGEND], *([f"... and {left:,} more colours"] if left > 0 else [])]

    def png(self, cells: Sequence[Pixels], columns: int, labels: Sequence[str]) -> bytes:
        """Return the sheet with the cameras above the images and the legend below."""
        from PIL import Image, ImageDraw

        height, width = cells[0].shape[:2]
        rows = -(-len(cells) // columns)
        names = list(self._legend.items())[:_LEGEND]
        per_row = max(1, columns * width // 160)
        below = _ROW * -(-len(names) // per_row)
        sheet = Image.new("RGB", (columns * width, rows * (height + _ROW) + below), "white")
        draw = ImageDraw.Draw(sheet)
        for k, cell in enumerate(cells):
            x, y = k % columns * width, k // columns * (height + _ROW)
            draw.text((x + 3, y + 1), _ascii(labels[k])[: width // 6], fill="black")
            sheet.paste(Image.fromarray(np.ascontiguousarray(cell)), (x, y + _ROW))
        for k, (name, color) in enumerate(names):
            x, y = k % per_row * (columns * width // per_row), rows * (height + _ROW) + k // per_row * _ROW
            draw.rectangle((x + 3, y + 2, x + 12, y + 11), fill=color)
            draw.text((x + 16, y + 1), _ascii(name)[:22], fill="black")
        return _png(sheet)


def _ascii(text: str) -> str:
    return text.encode("ascii", "replace").decode("ascii")


def _png(image: Any) -> bytes:
    stream = io.BytesIO()
    image.save(stream, "PNG")
    return stream.getvalue()


# --- reference images ----------------------------------------------------------------------------------------------


def compare(
    project: Project, program: ProjectProgram, reference: str, camera: str, frame: int, score: bool = False
) -> ToolAnswer:
    """Draw the scene beside an image of the project; with ``score`` also how similar they are for CLIP."""
    from scenelang.backends.pictures.film import open_image

    file = project.file(reference)
    if file.stat().st_size > MAX_REFERENCE:
        raise _wrong(f"the picture exceeds {MAX_REFERENCE:,} bytes")
    placed = camera_in(project, camera)
    try:
        wanted = open_image(file)
    except SceneError as error:
        raise _wrong(error.message.replace(str(project.root), ".")) from None

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        from PIL import Image

        number = frame_of(scene, frame)
        height = _REFERENCE_HEIGHT
        width = int(np.clip(round(wanted.width * height / max(wanted.height, 1)), 128, 640))
        ours = Image.fromarray(_pixels(scene, placed, (width, height), number))
        sheet = Image.new("RGB", (2 * width, height), "white")
        sheet.paste(wanted.resize((width, height)), (0, 0))
        sheet.paste(ours, (width, 0))
        lines = [f"left: {file.name}; right: {scene.word}", *([_score(wanted, ours)] if score else [])]
        return ToolAnswer("\n".join(lines), None, _png(sheet))

    return of_scene(project, program, reply)


def _score(wanted: Any, ours: Any) -> str:
    """Return the similarity of two images for CLIP, or why there is none."""
    if find_spec("open_clip") is None or find_spec("torch") is None:
        return "no score: CLIP is not installed"
    try:
        cosine = SERVICES.find("image-similarity")(wanted, ours)
    except (SceneError, OSError) as error:
        return f"no score: {getattr(error, 'message', None) or type(error).__name__}"
    return f"CLIP similarity {cosine:.3f} (1: the same)"
