"""Keyframes of objects: F-curves as Blender evaluates them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from scenelang.backends.blender.vectors import Vector
from scenelang.interpreter.transpile.evaluation import UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.objects import HostObject

_MAX_KEYS = 20_000


class Keyframe(HostObject):
    """Keyframe of one number."""

    python_name = "Keyframe"
    shown = frozenset(words("co interpolation handle_left_type handle_right_type easing type"))

    def __init__(self, frame: float, value: float, interpolation: str) -> None:
        self.co = Vector((frame, value))
        self.interpolation = interpolation
        self.easing, self.type = "AUTO", "KEYFRAME"
        self.handle_left_type = self.handle_right_type = "AUTO_CLAMPED"

    def assign(self, name: str, value: Any) -> None:
        if name == "interpolation":
            self.interpolation = str(value)
        elif name in ("handle_left_type", "handle_right_type"):
            if value not in ("AUTO_CLAMPED", "AUTO", "VECTOR"):
                raise UnsupportedPython(f"handles of the kind {value} are not supported")
            setattr(self, name, value)
        elif name == "easing":
            self.easing = str(value)
        elif name in ("co",):
            self.co.set(value)
        else:
            super().assign(name, value)


class Curve(HostObject):
    """F-curve of one number."""

    python_name = "FCurve"
    shown = frozenset(words("data_path array_index keyframe_points evaluate update modifiers extrapolation"))

    def __init__(self, data_path: str, array_index: int) -> None:
        self.data_path, self.array_index = data_path, array_index
        self.keyframe_points: list[Keyframe] = []
        self.extrapolation = "CONSTANT"

    @property
    def modifiers(self) -> Any:
        """Return the modifiers."""
        return _CurveModifiers()

    def assign(self, name: str, value: Any) -> None:
        if name == "extrapolation":
            self.extrapolation = str(value)
        elif name not in ("mute", "color_mode", "group"):
            super().assign(name, value)

    def update(self) -> None:
        """Do nothing."""

    def insert(self, frame: float, value: float, interpolation: str) -> None:
        """Insert a keyframe, or replace the one of this frame."""
        for key in self.keyframe_points:
            if abs(key.co[0] - frame) < 1e-3:
                key.co[1] = value
                return
        if len(self.keyframe_points) > _MAX_KEYS:
            raise UnsupportedPython("this animation has too many keyframes")
        self.keyframe_points.append(Keyframe(frame, value, interpolation))
        self.keyframe_points.sort(key=lambda key: key.co[0])

    def evaluate(self, frame: float) -> float:
        """Return the value at a frame."""
        keys = self.keyframe_points
        if not keys:
            return 0.0
        if frame <= keys[0].co[0] or len(keys) == 1:
            return self._outside(frame, 0, 1) if frame < keys[0].co[0] else keys[0].co[1]  # type: ignore[no-any-return]
        if frame >= keys[-1].co[0]:
            return self._outside(frame, -1, -2) if frame > keys[-1].co[0] else keys[-1].co[1]  # type: ignore[no-any-return]
        number = next(i for i in range(len(keys) - 1) if frame < keys[i + 1].co[0])
        return self._between(number, frame)

    def _outside(self, frame: float, end: int, next_to: int) -> float:
        keys = self.keyframe_points
        if self.extrapolation != "LINEAR" or len(keys) == 1:
            return keys[end].co[1]  # type: ignore[no-any-return]
        if keys[end].interpolation not in ("LINEAR", "BEZIER"):
            return keys[end].co[1]  # type: ignore[no-any-return]
        (x0, y0), (x1, y1) = keys[end].co, keys[next_to].co
        if keys[end].interpolation == "BEZIER":
            handle = self._handles(end % len(keys))[0 if end == 0 else 1]
            slope = (handle[1] - y0) / (handle[0] - x0)
        else:
            slope = (y1 - y0) / (x1 - x0)
        return float(y0 + slope * (frame - x0))

    def _between(self, number: int, frame: float) -> float:
        first, second = self.keyframe_points[number], self.keyframe_points[number + 1]
        (x0, y0), (x1, y1) = first.co, second.co
        share = (frame - x0) / (x1 - x0)
        if first.interpolation == "CONSTANT":
            return float(y0)
        if first.interpolation == "LINEAR":
            return float(y0 + (y1 - y0) * share)
        if first.interpolation == "BEZIER":
            return _bezier((x0, y0), self._handles(number)[1], self._handles(number + 1)[0], (x1, y1), frame)
        return float(y0 + (y1 - y0) * eased(first.interpolation, first.easing, share))

    def _handles(self, number: int) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the left and right handle of a keyframe (BKE_nurb_handle_calc of Blender)."""
        keys = self.keyframe_points
        x, y = keys[number].co
        has_before, has_after = number > 0, number + 1 < len(keys)
        after = tuple(keys[number + 1].co) if has_after else None
        before = tuple(keys[number - 1].co) if has_before else None
        if before is None:
            before = (2 * x - after[0], 2 * y - after[1]) if after else (x - 1, y)
        if after is None:
            after = (2 * x - before[0], 2 * y - before[1])
        kind = keys[number].handle_left_type
        ends = not has_before or not has_after
        a, b = (x - before[0], y - before[1]), (after[0] - x, after[1] - y)
        if kind == "VECTOR":
            return (x - a[0] / 3, y - a[1] / 3), (x + b[0] / 3, y + b[1] / 3)
        is_extreme = ends or (before[1] - y) * (after[1] - y) >= 0
        if kind == "AUTO_CLAMPED" and is_extreme:
            return (x - a[0] / 3, y), (x + b[0] / 3, y)
        # The tangent of an automatic handle is the mean of the slopes to the neighbours; a handle spans a third of the
        # frames. Blender then smooths the acceleration over several keyframes, which is left out here.
        slope = (b[1] / b[0] + a[1] / a[0]) / 2
        low, high = (x - a[0] / 3, y - slope * a[0] / 3), (x + b[0] / 3, y + slope * b[0] / 3)
        if kind == "AUTO_CLAMPED":
            low = (low[0], min(max(low[1], min(before[1], y)), max(before[1], y)))
            high = (high[0], min(max(high[1], min(after[1], y)), max(after[1], y)))
            low, high = _aligned((x, y), low, high)
        return low, high

    def copy(self) -> Curve:
        """Return a copy."""
        made = Curve(self.data_path, self.array_index)
        made.extrapolation = self.extrapolation
        for key in self.keyframe_points:
            copied = Keyframe(key.co[0], key.co[1], key.interpolation)
            copied.easing, copied.handle_left_type = key.easing, key.handle_left_type
            copied.handle_right_type = key.handle_right_type
            made.keyframe_points.append(copied)
        return made


def _aligned(
    center: tuple[float, float], low: tuple[float, float], high: tuple[float, float]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return clamped handles on one line through the keyframe, with the lesser slope."""
    left = (center[1] - low[1]) / (center[0] - low[0])
    right = (high[1] - center[1]) / (high[0] - center[0])
    slope = left if abs(left) < abs(right) else right
    return (
        (low[0], center[1] - slope * (center[0] - low[0])),
        (high[0], center[1] + slope * (high[0] - center[0])),
    )


def _bezier(
    start: tuple[float, float], first: tuple[float, float], second: tuple[float, float], end: tuple[float, float], x: float
) -> float:
    """Return the height of a cubic at ``x``, its handles shortened where they cross as in Blender."""
    width = end[0] - start[0]
    out, back = first[0] - start[0], end[0] - second[0]
    if out + back > width:
        factor = width / (out + back)
        first = (start[0] + out * factor, start[1] + (first[1] - start[1]) * factor)
        second = (end[0] - back * factor, end[1] + (second[1] - end[1]) * factor)
    low, high = 0.0, 1.0
    for _ in range(50):
        t = (low + high) / 2
        if _cubic(start[0], first[0], second[0], end[0], t) < x:
            low = t
        else:
            high = t
    return _cubic(start[1], first[1], second[1], end[1], (low + high) / 2)


def _cubic(a: float, b: float, c: float, d: float, t: float) -> float:
    s = 1 - t
    return s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d


def eased(kind: str, easing: str, t: float) -> float:
    """Return the share of a change by an easing of Blender."""
    powers = {"QUAD": 2, "CUBIC": 3, "QUART": 4, "QUINT": 5}
    if kind == "SINE":
        import math

        ease_in = lambda u: 1 - math.cos(u * math.pi / 2)
    elif kind in powers:
        ease_in = lambda u: u ** powers[kind]
    else:
        raise UnsupportedPython(f"the interpolation {kind} is not supported")
    if easing in ("AUTO", "EASE_IN"):
        return float(ease_in(t))
    if easing == "EASE_OUT":
        return float(1 - ease_in(1 - t))
    return float(ease_in(2 * t) / 2 if t < 0.5 else 1 - ease_in(2 - 2 * t) / 2)


class _CurveModifiers(HostObject):
    python_name = "FCurveModifiers"
    shown = frozenset(("new",))

    def new(self, type: str = "") -> Any:
        """Add a modifier."""
        raise UnsupportedPython("modifiers of F-curves are not supported", "insert the keyframes of all turns")

    def __iter__(self) -> Iterator[Any]:
        return iter(())


@dataclass(eq=False)
class _Curves:
    curves: dict[tuple[str, int], Curve] = field(default_factory=dict)


class Animation(HostObject, _Curves):
    """Animation data of an object, its action, layers, strips and channel bags at once."""

    python_name = "AnimData"
    shown = frozenset(words("action action_slot drivers nla_tracks"))
    drivers = nla_tracks = ()

    def __init__(self, name: str) -> None:
        _Curves.__init__(self)
        self.name = name
        self.action = _Action(self)
        self.action_slot = None

    def insert(self, data_path: str, index: int, frame: float, value: float, interpolation: str) -> None:
        """Insert a keyframe."""
        curve = self.curves.setdefault((data_path, index), Curve(data_path, index))
        curve.insert(frame, value, interpolation)

    def apply(self, owner: Any, frame: float) -> None:
        """Give an object the values of a frame."""
        for (path, index), curve in self.curves.items():
            getattr(owner, path)[index] = curve.evaluate(frame)

    def span(self) -> tuple[float, float]:
        """Return the first and the last frame with a keyframe."""
        frames = [key.co[0] for curve in self.curves.values() for key in curve.keyframe_points]
        return min(frames), max(frames)

    def copy(self) -> Animation:
        """Return a copy."""
        made = Animation(self.name)
        made.curves = {key: curve.copy() for key, curve in self.curves.items()}
        return made

    def assign(self, name: str, value: Any) -> None:
        if name == "action" and isinstance(value, _Action):
            self.curves = value.animation.curves
        elif name not in ("action_slot", "use_nla"):
            super().assign(name, value)


class _Action(HostObject):
    """Action with one layer, one strip and one channel bag, each of which is this object."""

    python_name = "Action"
    shown = frozenset(words("name layers strips channelbags channelbag slots frame_range groups fcurve_ensure_for_datablock"))
    groups = ()

    def __init__(self, animation: Animation) -> None:
        self.animation = animation
        self.name = f"{animation.name}Action"

    def read(self, name: str) -> Any:
        # A channel bag has the F-curves. Actions of Blender 5 have none: scripts for older ones ask by `hasattr`.
        if name == "fcurves" and isinstance(self, _Bag):
            return FCurves(self.animation)
        return super().read(name)

    layers = strips = channelbags = slots = property(lambda self: [_Bag(self.animation)])

    @property
    def frame_range(self) -> Vector:
        """Return the first and the last frame."""
        return Vector(self.animation.span())

    def channelbag(self, slot: Any = None, ensure: bool = False) -> Any:
        """Return the channel bag."""
        return _Bag(self.animation)

    def assign(self, name: str, value: Any) -> None:
        if name not in ("name", "use_cyclic", "frame_start", "frame_end", "use_frame_range"):
            super().assign(name, value)


class FCurves(HostObject):
    """F-curves of an animation."""

    python_name = "ActionChannelbagFCurves"
    shown = frozenset(("find",))

    def __init__(self, animation: Animation) -> None:
        self._curves = animation.curves

    def find(self, data_path: str, index: int = 0) -> Curve | None:
        """Return a curve, None if there is none."""
        return self._curves.get((data_path, index))

    def __iter__(self) -> Iterator[Curve]:
        return iter(list(self._curves.values()))

    def __len__(self) -> int:
        return len(self._curves)

    def __getitem__(self, index: int) -> Curve:
        return list(self._curves.values())[index]


class _Bag(_Action):
    """Layer, strip or channel bag of an action."""

    python_name = "ActionChannelbag"

