"""a warehouse aisle with pallet racks stocked from an inventory list, and a forklift"""
from helper import *
from collections import Counter, namedtuple
from itertools import chain, cycle, repeat
import random
import textwrap

INVENTORY = textwrap.dedent("""\
    # item, quantity
    box, 14
    barrel, 6
    crate, 9
    sack, 5
""")

Slot = namedtuple('Slot', 'bay level side')


def parse_inventory(text: str) -> Counter:
    stock = Counter()
    for lineno, raw in enumerate(text.splitlines(), 1):
        line = raw.split('#')[0].strip()
        if not line:
            continue
        try:
            name, qty = (t.strip() for t in line.split(','))
            stock[name] += int(qty)
        except ValueError as e:
            raise SystemExit(f"line {lineno}: {e}")
    return stock


STOCK = parse_inventory(INVENTORY)


def cube(size, at=(0, 0, 0), color=(1, 1, 1)):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix(at))


@register()
def item(kind: str = 'box', tone: float = 1.0) -> Shape:
    match kind:
        case 'box':
            return concat_shapes(cube((0.6, 0.5, 0.6), (0, 0.25, 0), (0.7 * tone, 0.52 * tone, 0.33 * tone)), cube((0.1, 0.51, 0.61), (0, 0.25, 0), (0.85, 0.75, 0.55)))
        case 'crate':
            slats = [cube((0.7, 0.1, 0.7), (0, 0.06 + 0.15 * k, 0), (0.55 * tone, 0.4 * tone, 0.2 * tone)) for k in range(4)]
            return concat_shapes(*slats)
        case 'barrel':
            return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, a, 0), 'p1': (0, b, 0)}, color=(0.15, 0.3, 0.55)) for r, a, b in ((0.28, 0, 0.7), (0.3, 0.2, 0.24), (0.3, 0.46, 0.5))])
        case 'sack':
            return loop(3, lambda k: transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.22}, color=(0.85, 0.8, 0.65)), translation_matrix((0.15 * (k - 1), 0.2, 0))))
        case unknown:
            raise ValueError(f'unknown item {unknown}')


@register()
def rack(bays: int = 3, levels: int = 3, bay: float = 1.8, height: float = 1.1, depth: float = 0.9) -> Shape:
    uprights = [cube((0.08, levels * height, 0.08), (b * bay, levels * height / 2, s * depth / 2), (0.15, 0.3, 0.6)) for b in range(bays + 1) for s in (-1, 1)]
    beams = [cube((bays * bay, 0.1, 0.06), (bays * bay / 2, l * height + 0.05, s * depth / 2), (0.95, 0.5, 0.1)) for l in range(levels) for s in (-1, 1)]
    decks = [cube((bays * bay, 0.03, depth), (bays * bay / 2, l * height + 0.1, 0), (0.6, 0.6, 0.6)) for l in range(levels)]
    return concat_shapes(*uprights, *beams, *decks)


@register()
def stocked_racks(seed: int = 8) -> Shape:
    rng = random.Random(seed)
    goods = list(chain.from_iterable(repeat(name, n) for name, n in STOCK.most_common()))
    rng.shuffle(goods)
    slots = cycle(Slot(b, l, s) for s in (0, 1) for l in range(3) for b in range(3))
    used: Counter = Counter()
    out = []
    for name, slot in zip(goods, slots):
        k = used[slot]
        used[slot] += 1
        x = slot.bay * 1.8 + 0.4 + 0.75 * (k % 2) 
        z = (-2 if slot.side else 2)
        y = slot.level * 1.1 + 0.12
        out.append(transform_shape(library_call('item', kind=name, tone=rng.uniform(0.8, 1.0)), translation_matrix((x, y, z))))
    for z in (-2, 2):
        out.append(transform_shape(library_call('rack'), translation_matrix((0, 0, z))))
    return sum(out, [])


@register()
def forklift() -> Shape:
    body = [cube((1.3, 0.6, 0.8), (0, 0.55, 0), (0.95, 0.75, 0.1)), cube((0.4, 0.5, 0.6), (-0.3, 1.05, 0), (0.1, 0.1, 0.1))]
    posts = [cube((0.06, 1.2, 0.06), (x, 1.4, z), (0.1, 0.1, 0.1)) for x in (-0.55, 0.45) for z in (-0.35, 0.35)]
    forks = [cube((0.9, 0.05, 0.12), (1.2, 0.3, z), (0.3, 0.3, 0.3)) for z in (-0.2, 0.2)]
    wheels = [primitive_call('cylinder', shape_kwargs={'radius': 0.25, 'p0': (x, 0.25, z), 'p1': (x, 0.25, z * 1.3)}, color=(0.08, 0.08, 0.08)) for x in (-0.45, 0.45) for z in (-0.35, 0.35)]
    return concat_shapes(*body, *posts, *forks, *wheels, cube((0.08, 2, 0.5), (0.7, 1.1, 0), (0.3, 0.3, 0.3)))


@register()
def warehouse() -> Shape:
    floor = cube((9, 0.1, 7), (2.7, -0.05, 0), (0.62, 0.62, 0.6))
    return concat_shapes(floor, library_call('stocked_racks'), transform_shape(library_call('forklift'), translation_matrix((1.5, 0, 0))))
