from helper import *

"""
a bottling line: each bottle passes or fails inspection
"""


class InspectionError(Exception):
    """Base of everything that can be wrong with a bottle."""
    color = (0.9, 0.1, 0.1)


class LevelError(InspectionError):
    def __init__(self, level: float, expected: float) -> None:
        super().__init__(f"level {level:.2f} instead of {expected:.2f}")
        self.missing = expected - level


class CapError(InspectionError):
    color = (0.9, 0.6, 0.1)


class LabelError(InspectionError, ValueError):
    color = (0.6, 0.1, 0.8)


BOTTLES = [
    {"level": 0.80, "cap": True, "label": "lemon"},
    {"level": 0.55, "cap": True, "label": "lemon"},
    {"level": 0.82, "cap": False, "label": "mint"},
    {"level": 0.79, "cap": True, "label": "m1nt"},
    {"level": 0.81, "cap": True},
    {"level": "full", "cap": True, "label": "cola"},
    {"level": 0.80, "cap": True, "label": "cola"},
]


def inspect(bottle: dict, expected: float = 0.8, tolerance: float = 0.05) -> None:
    try:
        level = bottle["level"]
        if abs(level - expected) > tolerance:
            raise LevelError(level, expected)
    except TypeError as error:
        raise LevelError(0.0, expected) from error
    if not bottle["cap"]:
        raise CapError("no cap", bottle["label"])
    if not bottle["label"].isalpha():
        raise LabelError(bottle["label"])


@register()
def bottle(level: float, color: tuple) -> Shape:
    glass = primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.25, 'p0': (0, 0, 0), 'p1': (0, max(level, 0.1), 0)})
    neck = primitive_call('cylinder', color=(0.8, 0.9, 0.9), shape_kwargs={'radius': 0.1, 'p0': (0, 0.9, 0), 'p1': (0, 1.2, 0)})
    return concat_shapes(glass, neck)


@register()
def factory_line() -> Shape:
    shapes, checked, reasons = [], 0, []
    for i, data in enumerate(BOTTLES):
        color, offset = (0.3, 0.8, 0.4), 0.0
        try:
            inspect(data)
        except LevelError as e:
            color, offset = e.color, 1 + e.missing
            reasons.append(str(e))
            if e.__cause__ is not None:
                offset += 1
        except (CapError, LabelError) as e:
            color, offset = type(e).color, 1.5
            reasons.append(f"{type(e).__name__}: {', '.join(map(str, e.args))}")
        except KeyError as e:
            reasons.append(e.args[0])
            color = (0.5, 0.5, 0.5)
        else:
            shapes.append(primitive_call('cylinder', color=(0, 0.6, 0), shape_kwargs={'radius': 0.1, 'p0': (i, 1.2, 0), 'p1': (i, 1.3, 0)}))
        finally:
            checked += 1
        level = data["level"] if isinstance(data["level"], float) else 0.9
        shapes.append(transform_shape(library_call('bottle', level=level, color=color), translation_matrix((i, 0, offset))))
    belt = transform_shape(primitive_call('cube', color=(0.2, 0.2, 0.2), shape_kwargs={'scale': (checked, 0.1, 0.7)}), translation_matrix((checked / 2 - 0.5, -0.05, 0)))
    notes = [transform_shape(primitive_call('cube', color=(1, 1, 0.8), shape_kwargs={'scale': (0.03 * len(r), 0.1, 0.02)}), translation_matrix((0, 2 + 0.2 * k, 0))) for k, r in enumerate(reasons)]
    return concat_shapes(belt, *shapes, *notes)
