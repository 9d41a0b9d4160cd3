import zlib


def shade(seed):
    return zlib.crc32(str(seed).encode()) % 100 / 100


@register()
def stone(seed: int = 1) -> Shape:
    return primitive_call('cube', color=(shade(seed), 0.5, 0.5))
