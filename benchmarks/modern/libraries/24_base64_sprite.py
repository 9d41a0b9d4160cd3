"""
a sprite of packed bits
"""
from helper import *
import base64
import struct

ENCODED = base64.b64encode(struct.pack('>8B', 0x18, 0x3C, 0x7E, 0xDB, 0xFF, 0x24, 0x5A, 0xA5)).decode('ascii')


def decode(text: str):
    raw = base64.b64decode(text)
    return [[bool(byte >> (7 - bit) & 1) for bit in range(8)] for byte in struct.unpack(f'>{len(raw)}B', raw)]


@register()
def invader(depth: float = 1.0) -> Shape:
    return concat_shapes(*[
        transform_shape(primitive_call('cube', color=(.2, .9, .3), shape_kwargs={'scale': (1, 1, depth)}), translation_matrix((x, -y, 0)))
        for y, row in enumerate(decode(ENCODED)) for x, on in enumerate(row) if on
    ])
