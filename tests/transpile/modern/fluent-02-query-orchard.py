from helper import *
from functools import cmp_to_key

"""
an orchard planned with a lazy query object in the style of LINQ
"""


class Query:
    def __init__(self, source):
        self._source = source

    def __iter__(self):
        return iter(self._source)

    def where(self, predicate):
        return Query(x for x in self if predicate(x))

    def select(self, fn):
        return Query(map(fn, self))

    def enumerate(self, start=0):
        return Query(enumerate(self, start))

    def take(self, n):
        def generate():
            for i, x in enumerate(self):
                if i >= n:
                    return
                yield x
        return Query(generate())

    def order_by(self, key, descending=False):
        return Query(sorted(self, key=key, reverse=descending))

    def group_by(self, key):
        groups = {}
        for x in self:
            groups.setdefault(key(x), []).append(x)
        return Query(groups.items())

    def select_many(self, fn):
        return Query(y for x in self for y in fn(x))

    def fold(self, start, fn):
        for x in self:
            start = fn(start, x)
        return start

    def to_list(self):
        return list(self)

    def first(self, default=None):
        return next(iter(self), default)


TREES = [dict(kind=k, age=a, row=r) for r, line in enumerate(["apple3 pear7 apple9", "plum2 plum8", "pear1 apple5 fig4 plum6"]) for k, a in [(w.rstrip("0123456789"), int(w[-1])) for w in line.split()]]
FRUIT = {"apple": (0.8, 0.1, 0.1), "pear": (0.7, 0.8, 0.2), "plum": (0.4, 0.1, 0.5), "fig": (0.3, 0.2, 0.3)}


@register()
def tree(kind: str, age: int) -> Shape:
    h = 0.4 + 0.15 * age
    trunk = primitive_call('cylinder', color=(0.4, 0.3, 0.2), shape_kwargs={'radius': 0.05 + 0.01 * age, 'p0': (0, 0, 0), 'p1': (0, h, 0)})
    crown = transform_shape(primitive_call('sphere', color=(0.2, 0.5, 0.2), shape_kwargs={'radius': 0.3 + 0.04 * age}), translation_matrix((0, h + 0.2, 0)))
    fruit = loop(age // 2, lambda i: transform_shape(primitive_call('sphere', color=FRUIT[kind], shape_kwargs={'radius': 0.07}), translation_matrix((0.5 * math.cos(2 * i), h + 0.2, 0.5 * math.sin(2 * i)))))
    return concat_shapes(trunk, crown, fruit)


@register()
def orchard() -> Shape:
    rows = Query(TREES).where(lambda t: t["age"] > 1).group_by(lambda t: t["kind"]).order_by(lambda g: (len(g[1]), g[0]), descending=True)
    placed = (
        rows.enumerate()
        .select_many(lambda item: ((item[0], c, t) for c, t in enumerate(sorted(item[1][1], key=lambda t: t["age"]))))
        .select(lambda p: transform_shape(library_call('tree', kind=p[2]["kind"], age=p[2]["age"]), translation_matrix((1.5 * p[1], 0, 1.6 * p[0]))))
        .to_list()
    )
    total = Query(TREES).select(lambda t: t["age"]).fold(0, lambda a, b: a + b)
    oldest = Query(TREES).order_by(cmp_to_key(lambda a, b: b["age"] - a["age"])).take(3).select(lambda t: t["age"]).to_list()
    fence = [primitive_call('cylinder', color=(0.5, 0.4, 0.3), shape_kwargs={'radius': 0.04, 'p0': (0.4 * i - 1, 0, -1), 'p1': (0.4 * i - 1, 0.1 * oldest[i % len(oldest)], -1)}) for i in range(total // 3)]
    missing = Query([]).first(default=(0.35, 0.5, 0.3))
    lawn = transform_shape(primitive_call('cube', color=missing, shape_kwargs={'scale': (6, 0.05, 7)}), translation_matrix((1.5, -0.03, 2)))
    return concat_shapes(lawn, *placed, *fence)
