from typing import Generic, TypeVar, Callable, Optional, Any
from helper import *

"""
garden beds planned with a Result type instead of exceptions
"""

T = TypeVar("T")
U = TypeVar("U")


class Result(Generic[T]):
    __match_args__ = ("value",)

    def __init__(self, value: Optional[T] = None, error: str = ""):
        self.value, self.error = value, error

    def map(self, fn: Callable[[T], U]) -> "Result[U]":
        return self if self.error else Result(fn(self.value))

    def bind(self, fn: "Callable[[T], Result[U]]") -> "Result[U]":
        return self if self.error else fn(self.value)

    def or_else(self, default: T) -> T:
        return default if self.error else self.value

    def __bool__(self) -> bool:
        return not self.error


def parse_number(text: str) -> Result[float]:
    cleaned = text.strip().removesuffix("m")
    if cleaned.replace(".", "", 1).isdigit():
        return Result(float(cleaned))
    return Result(error=f"not a number: {text!r}")


def positive(x: float) -> Result[float]:
    return Result(x) if x > 0 else Result(error="not positive")


PLAN = ["2.0m", "1.5", "zero", " 3m ", "0", "0.8m"]


@register()
def plant(height: float) -> Shape:
    stem = primitive_call('cylinder', color=(0.2, 0.5, 0.2), shape_kwargs={'radius': 0.02, 'p0': (0, 0, 0), 'p1': (0, height, 0)})
    bloom = transform_shape(primitive_call('sphere', color=(0.9, 0.3 + height / 3, 0.5), shape_kwargs={'radius': 0.08}), translation_matrix((0, height, 0)))
    return concat_shapes(stem, bloom)


@register()
def bed(width: float, color: tuple) -> Shape:
    soil = primitive_call('cube', color=color, shape_kwargs={'scale': (width, 0.2, 0.8)})
    n = int(width // 0.4)
    return concat_shapes(soil, loop(n, lambda i: transform_shape(library_call('plant', height=0.3 + 0.1 * (i % 3)), translation_matrix((-width / 2 + 0.2 + 0.4 * i, 0.1, 0)))))


@register()
def garden() -> Shape:
    results = [parse_number(text).bind(positive).map(lambda w: w * 1.1) for text in PLAN]
    shapes: list[Any] = []
    for row, (text, result) in enumerate(zip(PLAN, results)):
        color = (0.35, 0.22, 0.12) if result else (0.7, 0.2, 0.2)
        width = result.or_else(0.05 * len(result.error))
        match result:
            case Result(None):
                shapes.append(transform_shape(primitive_call('sphere', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.3}), translation_matrix((2.5, 0, 1.2 * row))))
            case Result(value):
                print(text, "->", round(value, 2))
        shapes.append(transform_shape(library_call('bed', width=width, color=color), translation_matrix((0, 0, 1.2 * row))))
    return concat_shapes(*shapes)
