"""What polygons that cross themselves wind around: areas and moments of it, in fractions.

A sweep over vertical slabs between all corners and crossings: exact, and of another kind than the clipping of polygons
that the product does.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import combinations, pairwise

Points = list[tuple[float, float]]
Rule = Callable[[int], bool]
Corner = tuple[Fraction, Fraction]
Edge = tuple[Corner, Corner]

RULES: dict[str, Rule] = {"nonzero": lambda winding: winding != 0, "even-odd": lambda winding: winding % 2 == 1}


def moment(
    contours: list[Points], is_inside: Rule, weight: Callable[[Fraction], Fraction] = lambda x: Fraction(1)
) -> float:
    """The integral of a weight, linear in x, over what is inside."""
    edges = [edge for contour in contours for edge in edges_of(contour) if edge[0][0] != edge[1][0]]
    meetings = [crossing(one, other) for one, other in combinations(edges, 2)]
    cuts = sorted({x for a, b in edges for x in (a[0], b[0])} | {x for x in meetings if x is not None})
    total = Fraction(0)
    for low, high in pairwise(cuts):
        middle = (low + high) / 2
        over = [edge for edge in edges if min(edge[0][0], edge[1][0]) < middle < max(edge[0][0], edge[1][0])]
        over.sort(key=lambda edge: height(edge, middle))
        winding = 0
        for below, above in pairwise(over):
            winding += 1 if below[1][0] > below[0][0] else -1
            if is_inside(winding):
                areas = [(height(above, x) - height(below, x)) * weight(x) for x in (low, middle, high)]
                total += (high - low) * (areas[0] + 4 * areas[1] + areas[2]) / 6
    return float(total)


def edges_of(contour: Points) -> list[Edge]:
    corners = [(Fraction(x), Fraction(y)) for x, y in contour]
    return list(zip(corners, corners[1:] + corners[:1]))


def height(edge: Edge, x: Fraction) -> Fraction:
    (x0, y0), (x1, y1) = edge
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)


def crossing(one: Edge, other: Edge) -> Fraction | None:
    """The x at which two edges meet, neither of which is vertical."""
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in (one, other)]
    if slopes[0] == slopes[1]:
        return None
    x = one[0][0] + (height(other, one[0][0]) - one[0][1]) / (slopes[0] - slopes[1])
    return x if all(min(a[0], b[0]) <= x <= max(a[0], b[0]) for a, b in (one, other)) else None


def side(a: Corner, b: Corner, c: Corner) -> int:
    turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (turn > 0) - (turn < 0)


def crosses(contour: Points) -> bool:
    """Whether two edges cross inside of both."""
    return any(
        side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
        for (a, b), (c, d) in combinations(edges_of(contour), 2)
    )


def is_simple(contour: Points) -> bool:
    """Whether no corner is on an edge but at its ends, and no two edges cross."""
    on_edge = (
        side(a, b, c) == 0 and min(a, b) <= c <= max(a, b) and c not in (a, b)
        for a, b in edges_of(contour)
        for c, _ in edges_of(contour)
    )
    return len(set(contour)) == len(contour) and not crosses(contour) and not any(on_edge)


def signed_area(points: Points) -> float:
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1])) / 2.0
