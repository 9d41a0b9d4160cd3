"""
bricks whose colours are hashed
"""
from helper import *
import hashlib


def shade(name: str) -> tuple[float, float, float]:
    digest = hashlib.sha256(name.encode('utf-8')).hexdigest()
    return tuple(int(digest[i:i + 2], 16) / 255 for i in (0, 2, 4))


def jitter(*key) -> float:
    h = hashlib.md5(repr(key).encode()).digest()
    return int.from_bytes(h[:4], 'big') / 2 ** 32


@register()
def brick(name: str) -> Shape:
    return primitive_call('cube', color=shade(name), shape_kwargs={'scale': (.95, .45, .5)})


@register()
def brick_wall(rows: int = 5, columns: int = 6) -> Shape:
    return concat_shapes(*[
        transform_shape(library_call('brick', name=f'brick-{r}-{c}'), translation_matrix((c + .5 * (r % 2), r * .5, .1 * jitter(r, c))))
        for r in range(rows) for c in range(columns)
    ])
