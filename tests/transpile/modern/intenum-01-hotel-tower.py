from enum import IntEnum
from helper import *

"""
a hotel tower whose floors get more luxurious towards the top
"""

class Tier(IntEnum):
    BASIC = 0
    COMFORT = 1
    DELUXE = 2
    SUITE = 3

WINDOW_COLORS = {
    Tier.BASIC: (0.5, 0.6, 0.7),
    Tier.COMFORT: (0.55, 0.7, 0.8),
    Tier.DELUXE: (0.9, 0.85, 0.5),
    Tier.SUITE: (1.0, 0.9, 0.3),
}

def tier_for(floor: int, floors: int) -> Tier:
    """Map a floor to its tier, higher is better."""
    return Tier(min(floor * len(Tier) // floors, Tier.SUITE))

@register()
def hotel_floor(tier: int, width: float = 4.0) -> Shape:
    tier = Tier(tier)
    inset = 0.25 * tier
    body = primitive_call('cube', color=(0.8, 0.78, 0.74), shape_kwargs={'scale': (width - inset, 0.9, 2 - inset / 2)})
    count = 8 - 2 * tier
    pitch = (width - inset) / count
    def window(i: int) -> Shape:
        pane = primitive_call('cube', color=WINDOW_COLORS[tier], shape_kwargs={'scale': (pitch * 0.7, 0.5, 0.05)})
        return transform_shape(pane, translation_matrix(((i - (count - 1) / 2) * pitch, 0.05, 1 - inset / 4)))
    shapes = [body, loop(count, window)]
    if tier >= Tier.DELUXE:
        balcony = primitive_call('cube', color=(0.3, 0.3, 0.32), shape_kwargs={'scale': (width - inset, 0.1, 0.4)})
        shapes.append(transform_shape(balcony, translation_matrix((0, -0.35, 1.2))))
    return concat_shapes(*shapes)

@register()
def hotel(floors: int = 12) -> Shape:
    stack = []
    totals = {t: 0 for t in Tier}
    for f in range(floors):
        tier = tier_for(f, floors)
        totals[tier] += 1
        stack.append(transform_shape(library_call('hotel_floor', tier=int(tier)), translation_matrix((0, 0.5 + f, 0))))
    assert sum(totals.values()) == floors
    # sum of int enums is an int: the antenna grows with it
    antenna_height = 0.2 * sum(t * n for t, n in totals.items()) / floors + 1
    antenna = primitive_call('cylinder', color=(0.8, 0.1, 0.1), shape_kwargs={'radius': 0.05, 'p0': (0, floors, 0), 'p1': (0, floors + antenna_height, 0)})
    return concat_shapes(*stack, antenna)
