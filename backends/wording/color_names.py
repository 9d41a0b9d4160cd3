"""The names that people have for colours: words a person would say, with what they mean on a screen (sRGB)."""

from __future__ import annotations

from functools import cache

# One family a paragraph; `name:digits`, several digits where a name covers more than one point. Neutral light tones
# that are not quite white are ivory, as in the paper (section 5): [.9 .9 .9] is.
_NAMES = """
white:ffffff, ivory:fffff0:f4f4f4:f6f3ea:efefed, cream:fff6d0, eggshell:f0ead6, pearl:eae6df, bone:e3dac9,
light grey:d6d6d6:c9c9c9:bcbcbc, silver:c0c0c0, grey:a8a8a8:9a9a9a:919191:8a8a8a:808080, stone grey:8d897c,
ash grey:b5b8b1, dark grey:707070:606060:525252, charcoal:454545:3d3d3d:333537, graphite:292b2e, soot:201f1d,
black:000000:0b0b0b:151515, very light grey:e4e4e4:eaeaea, slate grey:708090, warm grey:aba39a, gunmetal:4a545c,
steel grey:6f7a83, pale blue grey:c3ccd6, dark slate:3a4752,

red:ff0000:e60000, light red:f05a5a, dark red:8b0000, deep red:b00000, crimson:dc143c, scarlet:ff2400:f03010,
cherry red:c8102e, ruby:9b111e, brick red:a8402f, blood red:7a0a0a, maroon:5e0a14, burgundy:6e0f2c, wine red:722f37,
rose red:c21e56, tomato red:ff6347, coral red:ff5a50, coral:ff7f50, salmon:fa8072, light coral:f08080,
dusty red:b9484e, raspberry:d01c6a, strawberry:fc5a6e, rust:b7410e, dark rust:86310c, vermilion:e34234,
terracotta:cc6a4a, dark terracotta:a85439, clay:b66a50, reddish brown:7f2b0a,

pink:ffc0cb, light pink:ffd6df, hot pink:ff69b4, deep pink:ff1493, rose:ff5c8d, dusty rose:c08081, dusty pink:d58a94,
blush:f4cdc6, baby pink:f9b7d0, bubblegum pink:fd8ac8, salmon pink:ff91a4, fuchsia:e0218a, magenta:ff00ff:e000d0,
dark pink:cb416b, pale rose:f0d5d5, flamingo pink:fc8eac, mauve:ae7181, shell pink:fbe3dc,

orange:ff8c00:ff7f00, bright orange:ff5b00, dark orange:d2600a, light orange:fdaa48, burnt orange:bf5500,
pumpkin:e8711c, tangerine:ff9408, apricot:ffb16d, peach:ffcba4, light peach:ffe0c7, amber:ffbf00, mango:ffa62b,
copper:b87333, dark copper:8a4f23, bronze:a97142, dark bronze:6e5b2a, pale orange:ffc58f, melon:fdb094,

yellow:ffff00:f5e400, bright yellow:fff200, lemon yellow:fdee59:fff44f, pale yellow:fff9b0, light yellow:fffde0,
gold:ffd700:e6b422, dark gold:b5940f, old gold:cfb53b, mustard:d0a41c, dark mustard:a17d10, ochre:cc7722, sand:e2ca94,
dark sand:c2a86c, straw:e4d96f, honey:e0a02c, butter yellow:ffee8c, champagne:f4e3c1, khaki:c3b091, dark khaki:a8995f,
wheat:f5deb3, vanilla:f3e5ab, caramel:c68e4d, banana yellow:ffe135, saffron:f4c430,

brown:8b5a2b:7b4a24, light brown:b08050, dark brown:4b2e17, reddish chestnut:954535, chestnut:80422c,
chocolate:5a3018, dark chocolate:36200f, coffee:6f4e37, espresso:3b2a22, walnut:5c4033, mahogany:57190f:641d10,
oak:b98a55, light oak:d3ad78, dark oak:80603a, dark oak brown:63472a, light wood:e2be86, birch:ebd9b4, teak:9c6b3a,
ebony:251d18, cinnamon:c0642a, sienna:a0522d, tan:d2b48c, beige:ece0c0, dark beige:b7a582, camel:c19a6b, taupe:8b7d6d,
dark taupe:5f5348, light taupe:b3a191, fawn:dcae7a, hazel:8e7618, golden brown:996515, greyish brown:6b5d52,
buff:e8c48e, sandstone:d6b791, rosy brown:bc8f8f, biscuit:f3d3ae, skin:e8b896, tawny:cd6f1e,

green:008000:00a000:00ff00, lime green:32cd32, lime:b0f000, light green:90ee90, pale green:c4f2bf,
dark green:004d10:005a1c, forest green:228b22, grass green:5a9a32, leaf green:5ca904, olive:808000,
olive green:6b7a2a, dark olive:4b5320, moss green:6f8a4a, sage green:9cae88, fern green:4f7942, emerald green:2fb872,
jade:00a86b, mint green:a0f5cc, pale mint:d8f7e6, sea green:2e8b57, spring green:00ff7f, pine green:1b4d3e,
hunter green:355e3b, bottle green:0f3d2e, avocado:8a9a3a, pear green:cbe05a, yellow green:9acd32, chartreuse:7fff00,
pistachio:b5d99c, apple green:76cd26, light sage:c9d5bd, khaki green:72804a, army green:565a34, dusty green:76a973,
dark sea green:8fbc8f, light olive:acb25c, greenish grey:8a9a86, deep green:02300f, kelly green:3fae2a,
pea green:a3b94c,

turquoise:40e0d0, dark turquoise:0a9a96, pale turquoise:aff0ea, teal:008080, dark teal:0b4d50, light teal:6fbfb6,
cyan:00ffff:1de9ee, dark cyan:0a8a93, light cyan:d5fbff, aqua:3fd9e8, aquamarine:7fffd4, seafoam:80d8b0,
petrol:0f5a68, verdigris:43a39a, lagoon blue:1fa6c0,

blue:0000ff:1a34f0, bright blue:0a65ff, dark blue:00008b, light blue:add8e6:9cc8f0, sky blue:87ceeb:75bbfd,
navy:000060:000080, navy blue:0c2148, midnight blue:141a52, royal blue:2f55d4, cobalt blue:0047ab, azure:0a84f0,
baby blue:bfe2fb, powder blue:c3dfe6, pale blue:dcecfb, ice blue:e6f6ff, steel blue:4682b4, denim blue:3f5f8f,
slate blue:5b74a0, cornflower blue:6495ed, ocean blue:1a6c9c, deep blue:0a2c78, electric blue:2a9cff, cerulean:1f8fcf,
indigo:3c0a82, periwinkle:9a9cf5, ultramarine:2a12b0, sapphire:1848b0, dusty blue:7d9ebf, greyish blue:8097b3,
light steel blue:b0c4de, dark denim:26405f, lavender blue:c5c8f8, ink blue:101c30, medium blue:3c6ec8,

purple:800080:7a1fa0, bright purple:a01ef0, light purple:b98ae8, dark purple:44104f, violet:8a2be2,
pale violet:d8bdf5, lavender:e3e0fa, lilac:cfa5dc, mauve purple:9a6ba8, plum:7f2f63, light plum:dda0dd, orchid:da70d6,
aubergine:3a1230, amethyst:9966cc, grape:6a2f7a, mulberry:a03a74, thistle:d8bfd8, dusty purple:80617f, berry:8c1c50,
deep violet:4a00a0, heather:a78fb3, royal purple:5a2a9a, pale lilac:ecd8ef, iris:5a4fcf, slate purple:5d5480,
dark violet:9400d3"""


@cache
def color_names() -> tuple[tuple[str, str], ...]:
    """Every name with the hexadecimal digits of one of its points, in the order of the table."""
    rows = (entry.strip().split(":") for entry in _NAMES.split(","))
    return tuple((name, digits) for name, *points in rows for digits in points)
