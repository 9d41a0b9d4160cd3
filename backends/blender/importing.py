"""Converts a Blender script to a program of the Scene Language (docs/from-blender.md).

The script is followed to the scene that it builds; then the scene is written: a word for each object, and for each
function of the script that has made several, with equal ones shared. Objects below a parent are parts of its word,
those of a collection or of a call are parts of a union. The root turns nothing: all axes are those of a scene.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender.blend_model import Blend, Object, ScriptCall
from scenelang.backends.blender.following import Followed, followed
from scenelang.backends.blender.pieces import MeshPiece
from scenelang.backends.blender.shader_looks import SurfaceLook, look_of
from scenelang.backends.blender.shapes import (
    HELPERS,
    ShapeWriter,
    moved,
    number,
    pose_parts,
    rigid,
    upright,
    vector,
)
from scenelang.backends.files import read_program
from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import FORMS, INDENTS
from scenelang.interpreter.transpile.evaluation import UnsupportedPython
from scenelang.stdlib.library import build_library

FloatArray = npt.NDArray[np.float64]
_MAX_SIZE = 1_000_000
_VERBS = re.compile(r"^_*(?:create|make|build|add|generate|spawn|place|draw|new|setup|construct|gen)_+(?=.)")
_NUMBER = re.compile(r"[\s_.-]*\d+$")
_RESERVED = {"scene", "pi", "tau", "none", "else", "frame", "look", "mesh", "union", "call", "transform"}
_ROOT_MARK = "\x00root\x00"
# Images of an animation: an even number of steps, so that the middle is one of them.
_STEPS = 24


def imported(path: Path) -> tuple[str, list[Diagnostic]]:
    """Convert a file; returns the program and warnings. Raises SceneError with the place in the file."""
    return converted(Source(str(path), read_program(path, _MAX_SIZE * 4)), path.stem)


def converted(source: Source, word: str = "scene") -> tuple[str, list[Diagnostic]]:
    """Convert a script, or a response that contains one; ``word`` becomes the word of the root."""
    result = followed(source)
    whole = Span(source, 0, 1)
    program = ProgramWriter(result, spaced(word) or "scene")
    text = program.text(whole)
    warnings = [
        Diagnostic("blender-ignored", message, result.text.span(node) if node is not None else whole)
        for message, node in result.blend.warnings.items()
    ]
    return format_text(text, INDENTS), warnings


def spaced(name: str) -> str:
    """Return a name of Python as words."""
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", re.sub(r"[^\w ]+", " ", name))
    return re.sub(r"^\d+ ", "", " ".join(name.replace("_", " ").lower().split()))


@dataclass(eq=False)
class ScenePart:
    """Part of the scene: an object, a call or a collection, with the parts in it."""

    name: str
    thing: Object | None = None
    site: ScriptCall | None = None
    parts: list[ScenePart] = field(default_factory=list)
    is_animated: bool = False


class ProgramWriter:
    """Writes the scene that a script has built."""

    def __init__(self, result: Followed, word: str) -> None:
        self.blend: Blend = result.blend
        self.result = result
        self.word = word
        self.shapes = ShapeWriter()
        self.words: dict[tuple[str, str], tuple[str, bool]] = {}  # of bodies and stems, with whether they move
        self.names: dict[str, list[str]] = {}  # words, with the names of what they stand for
        self.order: list[str] = []
        self.looks: dict[int, SurfaceLook] = {}
        self.colors: dict[tuple[str, str], str] = {}
        self.frames: list[float] = []
        self._taken = {*build_library().builtins, *FORMS, *HELPERS, *_RESERVED}

    def text(self, whole: Span) -> str:
        """Return the program."""
        shown = self._shown()
        if not shown:
            raise SceneError("empty-scene", "the script builds no meshes that a picture shows", None, whole)
        self._find_frames()
        tree = self._tree(shown)
        root = self._root(tree)
        lines = [f"; Converted from {Path(self.result.text.source.name).name} (Blender) by `scenelang import`."]
        lines += [text.strip() for name, text in HELPERS.items() if name in self.shapes.used]
        lines += [f"(define {name} {text})" for name, text in self.shapes.constants.items()]
        lines += [f"(define {name} {text})" for (_, text), name in self.colors.items()]
        lines += self.order
        lines.append(root)
        for note in self.shapes.notes:
            self.blend.warn(note, self.result.text.tree.body[0] if self.result.text.tree.body else None)
        return self._named("\n\n".join(lines)) + "\n"

    # --- what is shown, and how it is ordered

    def _shown(self) -> list[Object]:
        """Return the meshes that a picture shows, in the order in which they were made."""
        meshes: dict[int, Object] = {}

        def visit(collection: Any) -> None:
            if collection.hide_render:
                return
            for each in collection.objects.items_:
                if each.instance_collection is not None:
                    raise self._refused(each, "instances of collections are not supported")
                if each.type == "MESH" and not each.hide_render:
                    meshes[id(each)] = each
            for child in collection.children.items_:
                visit(child)

        visit(self.blend.scene.collection)
        return sorted((o for o in meshes.values() if self._has_faces(o)), key=lambda o: o.number)

    def _has_faces(self, obj: Object) -> bool:
        pieces = obj.data.settled()
        return any(
            piece.operation is not None
            or (piece.form is not None and (piece.form.kind != "circle" or piece.form.fill != "NOTHING"))
            or (piece.mesh is not None and bool(piece.mesh.faces))
            for piece in pieces
        )

    def _refused(self, obj: Object, message: str, hint: str | None = None) -> SceneError:
        node = obj.node
        span = self.result.text.span(node) if node is not None else Span(self.result.text.source, 0, 1)
        return SceneError("blender-unsupported", message, hint, span)

    def _find_frames(self) -> None:
        spans = [
            o.animation.span()
            for o in self.blend.objects.listed()
            if o.animation is not None and any(c.keyframe_points for c in o.animation.curves.values())
        ]
        if not spans:
            return
        start, end = min(first for first, _ in spans), max(last for _, last in spans)
        if end > start:
            steps = min(_STEPS, int(end - start) + int(end - start) % 2) or 1
            self.frames = [start + (end - start) * i / steps for i in range(steps + 1)]

    def _moves(self, obj: Object) -> bool:
        return bool(self.frames) and obj.animation is not None and bool(obj.animation.curves)

    def _tree(self, shown: Sequence[Object]) -> list[ScenePart]:
        """Return the parts at the top: collections, calls, and objects without a parent."""
        needed: dict[int, Object] = {}
        for each in shown:
            above: Object | None = each
            while above is not None and id(above) not in needed:
                needed[id(above)] = above
                above = above.parent
        visible = {id(each) for each in shown}
        parts = {key: ScenePart(each.name, each) for key, each in needed.items()}
        for key, each in sorted(needed.items(), key=lambda pair: pair[1].number):
            if each.parent is not None:
                parts[id(each.parent)].parts.append(parts[key])
        self._visible = visible
        tops = [parts[key] for key, each in needed.items() if each.parent is None]
        tops.sort(key=lambda part: part.thing.number if part.thing is not None else 0)
        for top in tops:
            self._mark(top)
        return self._by_collection(tops)

    def _mark(self, part: ScenePart) -> bool:
        below = [self._mark(each) for each in part.parts]
        part.is_animated = any(below) or (part.thing is not None and self._moves(part.thing))
        return part.is_animated

    def _by_collection(self, tops: list[ScenePart]) -> list[ScenePart]:
        """Group top-level objects by the script's own collections, and in each by the calls that made them."""
        groups: dict[int, ScenePart] = {}
        made: list[ScenePart] = []
        for top in tops:
            assert top.thing is not None, "tops are objects"
            own = [c for c in top.thing.users_collection if c.name not in ("Collection", "Scene Collection")]
            # one collection besides the default one usually contains the whole scene
            if not own or len(self.blend.collections.by_name) < 3:
                made.append(top)
                continue
            key = id(own[0])
            if key not in groups:
                groups[key] = ScenePart(own[0].name)
                made.append(groups[key])
            groups[key].parts.append(top)
        result: list[ScenePart] = []
        for part in made:
            if part.thing is None:
                part.parts = self._by_call(part.parts, 0)
                part.is_animated = any(each.is_animated for each in part.parts)
                result.append(part)
        plain = self._by_call([part for part in made if part.thing is not None], 0)
        return [*plain, *result]

    def _by_call(self, tops: list[ScenePart], depth: int) -> list[ScenePart]:
        """Group objects by the calls that have made them; a call with one object, or with all, is no group."""
        groups: dict[int, ScenePart] = {}
        made: list[ScenePart] = []
        for top in tops:
            assert top.thing is not None, "tops are objects"
            if len(top.thing.origin) <= depth:
                made.append(top)
                continue
            site = top.thing.origin[depth]
            if site.number not in groups:
                groups[site.number] = ScenePart(_VERBS.sub("", site.name), None, site)
                made.append(groups[site.number])
            groups[site.number].parts.append(top)
        result: list[ScenePart] = []
        for part in made:
            if part.thing is not None:
                result.append(part)
                continue
            inner = self._by_call(part.parts, depth + 1)
            if len(inner) == 1 or len(made) == 1:
                result += inner
            else:
                part.parts = inner
                part.is_animated = any(each.is_animated for each in inner)
                result.append(part)
        return result

    # --- writing

    def _root(self, parts: Sequence[ScenePart]) -> str:
        texts = [self._placed(part, np.eye(4)) for part in parts]
        body = texts[0] if len(texts) == 1 else _union(texts)
        if not self.frames:
            return f"(bind {_ROOT_MARK} (lambda () {body}))\n\n(scene {_ROOT_MARK})"
        listed = " ".join(map(number, self.frames))
        return (
            f"(bind {_ROOT_MARK} (lambda () (frames (for/list ((frame [{listed}])) (union {body})))))\n\n"
            f"(scene {_ROOT_MARK})"
        )

    def _placed(self, part: ScenePart, frame: FloatArray) -> str:
        """Return a part in its parent's frame, whose own matrix in Blender's axes is ``frame``."""
        if part.thing is None:
            return self._group(part, frame)
        if part.is_animated:
            return self._moving(part, frame)
        return self._still(part, frame)

    def _group(self, part: ScenePart, frame: FloatArray) -> str:
        own = np.eye(4)
        place = _location_of(part.site) if part.site is not None else None
        if place is not None and not part.is_animated:
            own[:3, 3] = place
        inner = [self._placed(each, own) for each in part.parts]
        call = self._call(part.name, _union(inner), is_moving=part.is_animated)
        return moved(call, upright(np.linalg.inv(frame) @ own))

    def _still(self, part: ScenePart, frame: FloatArray) -> str:
        obj = part.thing
        assert obj is not None, "a part with an object"
        world = obj.computed_world()
        split = rigid(world)
        own, sizes = split if split is not None else (world, np.ones(3))
        texts: list[str] = []
        if id(obj) in self._visible:
            pieces = [piece.moved(np.diag([*sizes, 1.0])) for piece in self._pieces(obj)]
            if len(pieces) == 1 and not part.parts:
                text, placed = self._written(obj, pieces[0])
                call = self._call(obj.name, text, is_moving=False)
                return moved(call, upright(np.linalg.inv(frame) @ own @ placed))
            texts += [moved(text, upright(placed)) for text, placed in (self._written(obj, piece) for piece in pieces)]
        texts += [self._placed(each, own) for each in part.parts]
        return moved(self._call(obj.name, _union(texts), is_moving=False), upright(np.linalg.inv(frame) @ own))

    def _moving(self, part: ScenePart, frame: FloatArray) -> str:
        """Return a part that moves, or with parts that do: its frame is the object's own, with its scale."""
        obj = part.thing
        assert obj is not None, "a part with an object"
        texts: list[str] = []
        if id(obj) in self._visible:
            for piece in self._pieces(obj):
                text, placed = self._written(obj, piece)
                texts.append(moved(text, upright(placed)))
        for each in part.parts:
            inner = each.thing
            assert inner is not None, "parts of an object are objects"
            if each.is_animated:
                texts.append(self._moving(each, np.eye(4)))
            else:
                texts.append(self._relative(each))
        is_inside = any(each.is_animated for each in part.parts)
        call = self._call(obj.name, _union(texts), is_moving=is_inside)
        before = np.array(
            obj.matrix_parent_inverse.numbers if obj.parent is not None else np.linalg.inv(frame), np.float64
        )
        return _posed(call, [*pose_parts(upright(before)), *self._motion(obj)])

    def _relative(self, part: ScenePart) -> str:
        """Return a part that does not move, in the frame of a parent that does."""
        parent = part.thing.parent if part.thing is not None else None
        assert parent is not None, "a part below an object"
        return self._still(part, parent.computed_world())

    def _motion(self, obj: Object) -> list[str]:
        """Return the factors of the pose of an object that moves, by the moment."""
        if not self._moves(obj):
            return pose_parts(upright(obj.basis()))
        animation = obj.animation
        assert animation is not None, "an object that moves has an animation"
        paths = {path for path, _ in animation.curves}
        if obj.rotation_mode == "QUATERNION" or "rotation_quaternion" in paths:
            if obj.rotation_mode == "QUATERNION" and "rotation_quaternion" in paths:
                raise self._refused(obj, "keyframes of quaternions are not supported", "use Euler angles")
        value = partial(self._channel, obj)
        x, y, z = (value("location", i, sign) for i, sign in ((0, 1.0), (2, 1.0), (1, -1.0)))
        parts = [f"(translate [{x} {y} {z}])"]
        axes = {"X": "[1 0 0]", "Y": "[0 0 -1]", "Z": "[0 1 0]"}
        if obj.rotation_mode in ("QUATERNION", "AXIS_ANGLE"):
            turn = np.eye(4)
            turn[:3, :3] = obj.rotation()
            parts += pose_parts(upright(turn))
        else:
            for axis in reversed(obj.rotation_mode):
                angle = value("rotation_euler", "XYZ".index(axis))
                if angle != "0":
                    parts.append(f"(rotate {angle} {axes[axis]})")
        factors = [value("scale", i) for i in (0, 2, 1)]
        if factors != ["1", "1", "1"]:
            parts.append(f"(scale [{' '.join(factors)}])")
        return parts if parts[0] != "(translate [0 0 0])" else parts[1:]

    def _channel(self, obj: Object, path: str, index: int, sign: float = 1.0) -> str:
        assert obj.animation is not None, "an object that moves"
        curve = obj.animation.curves.get((path, index))
        if curve is None:
            return number(sign * float(getattr(obj, path)[index]))
        values = [sign * curve.evaluate(moment) for moment in self.frames]
        if max(values) - min(values) < 1e-9:
            return number(values[0])
        keys = curve.keyframe_points
        if all(key.interpolation == "LINEAR" for key in keys) and curve.extrapolation == "CONSTANT":
            moments = [key.co[0] for key in keys]
            values = [sign * key.co[1] for key in keys]
        else:
            moments = self.frames
        return f"(interp frame {vector(moments)} {vector(values)})"

    def _pieces(self, obj: Object) -> list[MeshPiece]:
        try:
            return [piece for piece in self.blend.evaluated(obj) if piece.mesh is None or piece.mesh.faces]
        except UnsupportedPython as error:
            raise self._refused(obj, f"{error.message}, in `{obj.name}`", error.hint) from None

    def _written(self, obj: Object, piece: MeshPiece) -> tuple[str, FloatArray]:
        try:
            return self.shapes.piece(piece, self._look(obj, piece))
        except UnsupportedPython as error:
            raise self._refused(obj, f"{error.message}, in `{obj.name}`", error.hint) from None

    def _call(self, name: str, body: str, *, is_moving: bool) -> str:
        """Bind a body to a word, or use the word that has it; return the call.

        The word is a mark in the text until all names of what it stands for are known.
        """
        key = body, " ".join(_stem(name))
        known = self.words.get(key)
        if known is None:
            known = self.words[key] = f"\x00{len(self.words)}\x00", is_moving
            parameters = "((:frame 0))" if is_moving else "()"
            self.order.append(f"(bind {known[0]}\n(lambda {parameters} {body}))")
        self.names.setdefault(known[0], []).append(name)
        return f"(call {known[0]}{' :frame frame' if is_moving else ''})"

    def _named(self, text: str) -> str:
        """Return a text with the words in place of their marks."""
        chosen: dict[str, str] = {}
        taken = {*PRIMITIVES}
        for mark, names in self.names.items():
            stem = _common_name(names)
            choices = (stem, *(f"{stem} {i}" for i in range(2, 100_000)))
            word = next(each for each in choices if each not in taken)
            taken.add(word)
            chosen[mark] = _string(word)
        root = next(word for word in (self.word, f"{self.word} scene", f"whole {self.word} scene") if word not in taken)
        chosen[_ROOT_MARK] = _string(root)
        return re.sub("\x00\\w+\x00", lambda match: chosen[match[0]], text)

    # --- materials

    def _look(self, obj: Object, piece: MeshPiece) -> str:
        materials = obj.materials()
        slots = piece.mesh.slots() if piece.mesh is not None else (piece.slot,)
        if len(set(slots)) > 1 and len({id(materials[min(s, len(materials) - 1)]) for s in slots if materials}) > 1:
            self.blend.warn("faces of one mesh with several materials get that of most faces")
        slot = max(set(slots), key=slots.count) if slots else 0
        material = materials[min(slot, len(materials) - 1)] if materials else None
        key = id(material)
        if key not in self.looks:
            self.looks[key] = look_of(self.blend, material)
        return self._look_text(self.looks[key])

    def _look_text(self, look: SurfaceLook) -> str:
        color = vector(look.color)
        if look.name:
            color = self._color_name(look.name, color)
        text = f" :color {color}"
        if look.roughness is not None:
            text += f" :roughness {number(look.roughness)}"
        if look.metallic:
            text += f" :metallic {number(look.metallic)}"
        if look.emission is not None:
            text += f" :emission {vector(look.emission)}"
        if look.opacity < 1:
            text += f" :opacity {number(look.opacity)}"
        if look.ior is not None:
            text += f" :ior {number(look.ior)}"
        return text

    def _color_name(self, material: str, color: str) -> str:
        key = material, color
        if key not in self.colors:
            stem = re.sub(r"[^a-z0-9]+", "-", spaced(material)).strip("-") or "color"
            stem = f"color-{stem}" if stem[0].isdigit() else stem
            used = {*self._taken, *self.colors.values()}
            choices = (stem, f"{stem}-color", *(f"{stem}-color-{i}" for i in range(2, 10_000)))
            self.colors[key] = next(name for name in choices if name not in used)
        return self.colors[key]


PRIMITIVES = frozenset(
    ["cube", "sphere", "cylinder", "cone", "capsule", "torus", "rounded-cube", "mesh", "set-cuboid", "delete-blocks"]
)


# Words of a name that tell equal objects apart.
_SIDES = frozenset((
    "l", "r", "left", "right", "fl", "fr", "bl", "br", "rl", "rr", "tl", "tr",
    "front", "back", "rear", "top", "bottom", "upper", "lower", "inner", "outer", "north", "south", "east",
    "west", "n", "s", "e", "w",
))  # fmt: skip


def _stem(name: str) -> list[str]:
    """Return the words of a name without numbers and sides."""
    words = re.sub(r"\d+", " ", spaced(name)).split()
    return [word for word in words if word not in _SIDES and len(word) > 1] or words


def _common_name(names: Sequence[str]) -> str:
    """Return the name of what several names stand for: without numbers and sides where these differ."""
    stems = [_NUMBER.sub("", name).strip(" _.-") or name for name in names]
    if len(set(stems)) > 1:
        stems = [re.sub(r"[\s_.-]*\d+", "", name).strip(" _.-") or name for name in names]
    if len(set(stems)) > 1:
        kept = _stem(names[0])
        parts = re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[^\W\d_]+", names[0])
        stems = [" ".join(part for part in parts if part.lower() in kept)]
    return " ".join(stems[0].replace("_", " ").split()) or "part"


def _posed(text: str, parts: Sequence[str]) -> str:
    if not parts:
        return text
    return f"(transform {text} {parts[0] if len(parts) == 1 else '(@ ' + ' '.join(parts) + ')'})"


def _union(texts: Sequence[str]) -> str:
    return texts[0] if len(texts) == 1 else f"(union {' '.join(texts)})"


def _string(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


_PLACES = ("location", "loc", "pos", "position", "center", "origin", "at", "base", "offset", "co", "coords")


def _location_of(site: ScriptCall) -> FloatArray | None:
    """Return where a call has made its objects, by its arguments."""
    given = site.arguments
    for name, value in given.items():
        if name.lower() in _PLACES:
            numbers = _numbers(value)
            if numbers is not None and len(numbers) in (2, 3):
                return np.array([*numbers, 0.0][:3])
    if {"x", "y"} <= given.keys():
        numbers = _numbers([given["x"], given["y"], given.get("z", 0.0)])
        if numbers is not None:
            return np.array(numbers)
    return None


def _numbers(values: Any) -> list[float] | None:
    try:
        numbers = [float(value) for value in values]
    except (TypeError, ValueError):
        return None
    return numbers if np.isfinite(numbers).all() else None
