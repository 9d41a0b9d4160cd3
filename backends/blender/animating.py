"""Keyframes of objects: F-curves as Blender evaluates them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from scenelang.backends.blender.vectors import VectorValue
from scenelang.interpreter.transpile.evaluation import UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.objects import HostObject

_MAX_KEYS = 20_000


class Keyframe(HostObject):
    """Keyframe of one number."""

    python_name = "Keyframe"
    shown = frozenset(words("co interpolation handle_left_type handle_right_type easing type"))

    def __init__(self, frame: float, value: float, interpolation: str) -> None:
        self.co = VectorValue((frame, value))
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
        self._solved: tuple[Any, list[float]] = ((), [])

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
            return self._outside(frame, 0, 1) if frame < keys[0].co[0] else float(keys[0].co[1])
        if frame >= keys[-1].co[0]:
            return self._outside(frame, -1, -2) if frame > keys[-1].co[0] else float(keys[-1].co[1])
        number = next(i for i in range(len(keys) - 1) if frame < keys[i + 1].co[0])
        return self._between(number, frame)

    def _outside(self, frame: float, end: int, next_to: int) -> float:
        keys = self.keyframe_points
        if self.extrapolation != "LINEAR" or len(keys) == 1:
            return float(keys[end].co[1])
        if keys[end].interpolation not in ("LINEAR", "BEZIER"):
            return float(keys[end].co[1])
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
        """Return the left and the right handle of a keyframe; each spans a third of the frames to its neighbor."""
        keys = self.keyframe_points
        x, y = keys[number].co
        before = x - keys[number - 1].co[0] if number > 0 else 1.0
        after = keys[number + 1].co[0] - x if number + 1 < len(keys) else before
        if number == 0 and len(keys) > 1:
            before = after
        if keys[number].handle_left_type == "VECTOR":
            low = (keys[number - 1].co[1] - y) / 3 if number > 0 else 0.0
            high = (keys[number + 1].co[1] - y) / 3 if number + 1 < len(keys) else 0.0
            return (x - before / 3, y + low), (x + after / 3, y + high)
        slope = self._slopes()[number]
        return (x - before / 3, y - slope * before / 3), (x + after / 3, y + slope * after / 3)

    def _slopes(self) -> list[float]:
        """Return the slopes of the automatic handles, for which the acceleration has no jumps.

        They are 0 at the ends and, if clamped, at extremes; between these they solve the equations of Blender's
        `bezier_handle_calc_smooth_fcurve`, which say that the second derivative is continuous.
        """
        key = tuple((*each.co, each.handle_left_type) for each in self.keyframe_points)
        if key != self._solved[0]:
            self._solved = key, _smooth_slopes(self.keyframe_points)
        return self._solved[1]

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


def _smooth_slopes(keys: list[Keyframe]) -> list[float]:
    count = len(keys)
    x, y = [key.co[0] for key in keys], [key.co[1] for key in keys]
    secants = [(y[i + 1] - y[i]) / (x[i + 1] - x[i]) for i in range(count - 1)]
    fixed: dict[int, float] = {0: 0.0, count - 1: 0.0}
    limits: dict[int, tuple[float, float]] = {}
    for i in range(1, count - 1):
        before, after = secants[i - 1], secants[i]
        if keys[i].handle_left_type == "VECTOR" or (keys[i].handle_left_type == "AUTO_CLAMPED" and before * after <= 0):
            fixed[i] = 0.0
        elif keys[i].handle_left_type == "AUTO_CLAMPED":  # no handle is higher or lower than the neighbors
            most = 3 * min(abs(before), abs(after))
            limits[i] = (0.0, most) if before > 0 else (-most, 0.0)
    while True:
        slopes = _solved_slopes(x, secants, fixed)
        outside = [i for i, (low, high) in limits.items() if i not in fixed and not low <= slopes[i] <= high]
        if not outside:
            return slopes
        for i in outside:
            fixed[i] = min(max(slopes[i], limits[i][0]), limits[i][1])


def _solved_slopes(x: list[float], secants: list[float], fixed: dict[int, float]) -> list[float]:
    """Return all slopes, of which some are given (Thomas's algorithm)."""
    upper: list[float] = []
    values: list[float] = []
    for i in range(len(x)):
        if i in fixed:
            upper.append(0.0)
            values.append(fixed[i])
            continue
        before, after = 1 / (x[i] - x[i - 1]), 1 / (x[i + 1] - x[i])
        value = 3 * (secants[i - 1] * before + secants[i] * after)
        middle = 2 * (before + after) - before * upper[-1]
        upper.append(after / middle)
        values.append((value - before * values[-1]) / middle)
    for i in range(len(values) - 2, -1, -1):
        values[i] -= upper[i] * values[i + 1]
    return values


def _bezier(
    start: tuple[float, float],
    first: tuple[float, float],
    second: tuple[float, float],
    end: tuple[float, float],
    x: float,
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

        ease_in: Callable[[float], float] = lambda u: 1 - math.cos(u * math.pi / 2)
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

    def insert(self, data_path: str, index: int, frame: float, value: float) -> None:
        """Insert a keyframe, of a Bezier curve whatever the preferences say, as scripts do."""
        curve = self.curves.setdefault((data_path, index), Curve(data_path, index))
        curve.insert(frame, value, "BEZIER")

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
    shown = frozenset(
        words("name layers strips channelbags channelbag slots frame_range groups fcurve_ensure_for_datablock")
    )
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
    def frame_range(self) -> VectorValue:
        """Return the first and the last frame."""
        return VectorValue(self.animation.span())

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
