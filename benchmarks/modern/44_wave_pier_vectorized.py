"""a wooden pier over a wavy sea with a small sailboat"""
from helper import *
import numpy as np

rng = np.random.default_rng(2025)


def gerstner_height(x: np.ndarray, z: np.ndarray, waves: int = 4) -> np.ndarray:
    dirs = rng.normal(size=(waves, 2))
    dirs /= np.linalg.norm(dirs, axis=1, keepdims=True)
    amp = 0.25 / (1 + np.arange(waves))
    freq = 0.6 * 1.6 ** np.arange(waves)
    phase = rng.uniform(0, 2 * np.pi, waves)
    proj = np.einsum('wd,dij->wij', dirs, np.stack([x, z]))
    return np.sum(amp[:, None, None] * np.sin(freq[:, None, None] * proj + phase[:, None, None]), axis=0)


X, Z = np.meshgrid(np.arange(-8, 8, 0.8), np.arange(-8, 8, 0.8), indexing='ij')
H = gerstner_height(X, Z)
H_NORM = (H - H.min()) / (H.max() - H.min())


@register()
def sea() -> Shape:
    deep, foam = np.array([0.05, 0.25, 0.5]), np.array([0.6, 0.85, 0.9])
    out = []
    for x, z, h, t in np.nditer([X, Z, H, H_NORM]):
        c = (1 - t) * deep + t ** 2 * foam
        block = primitive_call('cube', shape_kwargs={'scale': (0.8, 1.0, 0.8)}, color=np.clip(c, 0, 1).tolist())
        out.append(transform_shape(block, translation_matrix((float(x), float(h) - 0.5, float(z)))))
    return concat_shapes(*out)


@register()
def pier(length: float = 7.0, width: float = 1.4, deck_y: float = 1.2) -> Shape:
    planks = int(length / 0.25)
    deck = loop(planks, lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (width, 0.06, 0.21)}, color=(0.5 + 0.03 * (i % 3), 0.37, 0.25)),
        translation_matrix((0, deck_y, -8 + 0.25 * i))))
    posts = [primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': (s * width / 2, -1.5, z), 'p1': (s * width / 2, deck_y + 0.3, z)}, color=(0.35, 0.25, 0.17))
             for z in np.linspace(-7.8, -8 + length, 5) for s in (-1, 1)]
    return concat_shapes(deck, *posts)


@register()
def sailboat(hull=(0.85, 0.2, 0.2)) -> Shape:
    body = loop(4, lambda k: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.5 + 0.1 * k, 0.12, 1.4 + 0.2 * k)}, color=hull), translation_matrix((0, 0.12 * k, 0))))
    mast = primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (0, 0.4, 0.1), 'p1': (0, 3, 0.1)}, color=(0.5, 0.35, 0.2))
    widths = np.linspace(1.2, 0.1, 10)
    sail = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.02, 0.22, w)}, color=(0.98, 0.97, 0.93)), translation_matrix((0, 0.9 + 0.22 * i, 0.1 - w / 2)))
            for i, w in enumerate(widths)]
    return concat_shapes(body, mast, *sail)


@register()
def harbor() -> Shape:
    i, j = np.unravel_index(np.argmin((X - 4) ** 2 + (Z - 3) ** 2), X.shape)
    boat = transform_shape(library_call('sailboat'), rotation_matrix(0.6, (0, 1, 0), (0, 0, 0)))
    boat = transform_shape(boat, translation_matrix((X[i, j], H[i, j], Z[i, j])))
    return concat_shapes(library_call('sea'), library_call('pier'), boat)
