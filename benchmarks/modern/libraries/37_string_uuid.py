"""
boxes with labels
"""
from helper import *
import string
import itertools
import zlib


@register()
def crate(label: str) -> Shape:
    tone = (zlib.crc32(label.encode()) & 0xFF) / 255
    return primitive_call('cube', color=(tone, .5, .3), shape_kwargs={'scale': .9})


@register()
def crates() -> Shape:
    names = [''.join(pair) for pair in itertools.product(string.ascii_uppercase[:3], string.digits[:4])]
    return concat_shapes(*[transform_shape(library_call('crate', label=n), translation_matrix((ord(n[0]) - 65, 0, int(n[1])))) for n in names])
