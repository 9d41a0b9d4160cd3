"""
a table set for the guests that a small parser reads from a text
"""
from helper import *
import re
from dataclasses import dataclass
from collections import ChainMap
import math

PLAN = """
# name      dish     drink
Ada         soup     wine
Brook       pasta    water
Casey       salad    juice
Devi        soup
Ellis       steak    wine
Farah       pasta    tea
"""

DEFAULTS = {'dish': 'salad', 'drink': 'water'}
COLORS = {'soup': (0.85, 0.5, 0.2), 'pasta': (0.95, 0.85, 0.5), 'salad': (0.3, 0.7, 0.3), 'steak': (0.45, 0.2, 0.12)}
DRINKS = {'wine': (0.5, 0.05, 0.15), 'water': (0.7, 0.85, 0.95), 'juice': (0.95, 0.6, 0.1), 'tea': (0.6, 0.35, 0.1)}


@dataclass
class Guest:
    name: str
    dish: str
    drink: str

    @staticmethod
    def parse(line: str) -> 'Guest | None':
        m = re.match(r'(?P<name>\w+)\s+(?P<dish>\w+)(?:\s+(?P<drink>\w+))?$', line.strip())
        if m is None:
            return None
        found = {k: v for k, v in m.groupdict().items() if v}
        return Guest(**ChainMap(found, DEFAULTS))


def guests(text: str):
    for line in text.splitlines():
        if not line.strip() or line.startswith('#'):
            continue
        if (guest := Guest.parse(line)) is not None:
            yield guest


@register()
def plate(dish: str) -> Shape:
    rim = primitive_call('cylinder', color=(0.97, 0.97, 0.97), shape_kwargs={'radius': 0.3, 'p0': (0, 0, 0), 'p1': (0, 0.03, 0)})
    food = transform_shape(primitive_call('sphere', color=COLORS.get(dish, (0.5, 0.5, 0.5)), shape_kwargs={'radius': 0.18}), scale_matrix(0.5, (0, 0, 0)))
    return concat_shapes(rim, transform_shape(food, translation_matrix((0, 0.05, 0))))


@register()
def glass(drink: str, height: float = 0.3) -> Shape:
    level = height * (0.5 if drink == 'wine' else 0.85)
    return concat_shapes(
        primitive_call('cylinder', color=DRINKS[drink], shape_kwargs={'radius': 0.08, 'p0': (0, 0, 0), 'p1': (0, level, 0)}),
        primitive_call('cylinder', color=(0.9, 0.95, 1.0), shape_kwargs={'radius': 0.09, 'p0': (0, 0, 0), 'p1': (0, 0.02, 0)}))


@register()
def dinner(radius: float = 1.6) -> Shape:
    party = sorted(guests(PLAN), key=lambda g: (-len(g.name), g.name))
    table = primitive_call('cylinder', color=(0.5, 0.33, 0.2), shape_kwargs={'radius': radius + 0.4, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)})
    shapes = [table]
    for i, guest in enumerate(party):
        angle = 2 * math.pi * i / len(party)
        setting = concat_shapes(
            library_call('plate', dish=guest.dish),
            transform_shape(library_call('glass', drink=guest.drink), translation_matrix((0.35, 0, -0.25))))
        shapes.append(transform_shape(setting, translation_matrix((radius * math.sin(angle), 0, radius * math.cos(angle))) @ rotation_matrix(angle, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(*shapes)
