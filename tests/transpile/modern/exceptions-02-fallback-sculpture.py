from typing import Any, Callable
from helper import *

"""
a sculpture park where broken plans fall back to simpler ones
"""

class PlanError(RuntimeError):
    def __init__(self, message, *, severity=1):
        super().__init__(message)
        self.severity = severity

    def __str__(self):
        return f"[{self.severity}] {super().__str__()}"

def attempt(*plans: Callable[[], Any]) -> tuple[Any, int]:
    """The first plan that works, with the number of failures before it."""
    failures = 0
    for plan in plans:
        try:
            result = plan()
        except (PlanError, ArithmeticError, LookupError) as problem:
            failures += getattr(problem, "severity", 1)
            print("failed:", problem)
        else:
            return result, failures
    raise PlanError("no plan worked", severity=failures)

def spiral(turns: int, pitch: float):
    if turns > 5:
        raise PlanError(f"{turns} turns are too many", severity=2)
    steps = int(8 / pitch)
    return [(math.cos(k * turns / steps * 6.28), k * 2 / steps, math.sin(k * turns / steps * 6.28)) for k in range(steps)]

def column(index: int):
    heights = (1.5, 2.5)
    return [(0, y * heights[index] / 6, 0) for y in range(6)]

@register()
def sculpture(points: list, failures: int) -> Shape:
    bronze = (0.6 - 0.1 * failures, 0.4, 0.2 + 0.15 * failures)
    base = primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 1.2, 'p0': (0, -0.3, 0), 'p1': (0, -0.1, 0)})
    beads = [transform_shape(primitive_call('sphere', color=bronze, shape_kwargs={'radius': 0.15}), translation_matrix(p)) for p in points]
    return concat_shapes(base, *beads)

def cleanup_order() -> list[str]:
    order = []
    def work():
        try:
            order.append("try")
            return "result"
        finally:
            order.append("finally")
    order.append(work())
    for word in ("a", "b", "c"):
        try:
            if word == "b":
                continue
            order.append(word)
        finally:
            order.append(word.upper())
    return order

@register()
def sculpture_park() -> Shape:
    requests = [
        (lambda: spiral(2, 0.5), lambda: column(0)),
        (lambda: spiral(9, 0.5), lambda: column(1)),
        (lambda: spiral(1, 0), lambda: column(5), lambda: spiral(1, 1.0)),
        (lambda: column(2),),
    ]
    shapes = []
    for k, plans in enumerate(requests):
        try:
            points, failures = attempt(*plans)
        except PlanError as e:
            points, failures = [(0, 0.3 * i, 0) for i in range(len(str(e)) // 8)], e.severity
        shapes.append(transform_shape(library_call('sculpture', points=points, failures=failures), translation_matrix((3 * k, 0, 0))))
    posts = [primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.05, 'p0': (i, 0, 2), 'p1': (i, 0.15 * len(word), 2)}) for i, word in enumerate(cleanup_order())]
    return concat_shapes(*shapes, *posts)
