"""Colors from CSS names, hexadecimal digits, RGB and HSV, converted to the linear sRGB of scenes."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError, near_names
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.scene.primitives.base import linear, texture_of
from scenelang.interpreter.values.values import Vector, make_list
from scenelang.stdlib.operands import wrong_type

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("colors")

# The named colors of CSS (CSS Color Module Level 4, section 6.1).
_NAMES = """
aliceblue:f0f8ff antiquewhite:faebd7 aqua:00ffff aquamarine:7fffd4 azure:f0ffff beige:f5f5dc bisque:ffe4c4
black:000000 blanchedalmond:ffebcd blue:0000ff blueviolet:8a2be2 brown:a52a2a burlywood:deb887 cadetblue:5f9ea0
chartreuse:7fff00 chocolate:d2691e coral:ff7f50 cornflowerblue:6495ed cornsilk:fff8dc crimson:dc143c cyan:00ffff
darkblue:00008b darkcyan:008b8b darkgoldenrod:b8860b darkgray:a9a9a9 darkgreen:006400 darkgrey:a9a9a9
darkkhaki:bdb76b darkmagenta:8b008b darkolivegreen:556b2f darkorange:ff8c00 darkorchid:9932cc darkred:8b0000
darksalmon:e9967a darkseagreen:8fbc8f darkslateblue:483d8b darkslategray:2f4f4f darkslategrey:2f4f4f
darkturquoise:00ced1 darkviolet:9400d3 deeppink:ff1493 deepskyblue:00bfff dimgray:696969 dimgrey:696969
dodgerblue:1e90ff firebrick:b22222 floralwhite:fffaf0 forestgreen:228b22 fuchsia:ff00ff gainsboro:dcdcdc
ghostwhite:f8f8ff gold:ffd700 goldenrod:daa520 gray:808080 green:008000 greenyellow:adff2f grey:808080
honeydew:f0fff0 hotpink:ff69b4 indianred:cd5c5c indigo:4b0082 ivory:fffff0 khaki:f0e68c lavender:e6e6fa
lavenderblush:fff0f5 lawngreen:7cfc00 lemonchiffon:fffacd lightblue:add8e6 lightcoral:f08080 lightcyan:e0ffff
lightgoldenrodyellow:fafad2 lightgray:d3d3d3 lightgreen:90ee90 lightgrey:d3d3d3 lightpink:ffb6c1
lightsalmon:ffa07a lightseagreen:20b2aa lightskyblue:87cefa lightslategray:778899 lightslategrey:778899
lightsteelblue:b0c4de lightyellow:ffffe0 lime:00ff00 limegreen:32cd32 linen:faf0e6 magenta:ff00ff maroon:800000
mediumaquamarine:66cdaa mediumblue:0000cd mediumorchid:ba55d3 mediumpurple:9370db mediumseagreen:3cb371
mediumslateblue:7b68ee mediumspringgreen:00fa9a mediumturquoise:48d1cc mediumvioletred:c71585
midnightblue:191970 mintcream:f5fffa mistyrose:ffe4e1 moccasin:ffe4b5 navajowhite:ffdead navy:000080
oldlace:fdf5e6 olive:808000 olivedrab:6b8e23 orange:ffa500 orangered:ff4500 orchid:da70d6 palegoldenrod:eee8aa
palegreen:98fb98 paleturquoise:afeeee palevioletred:db7093 papayawhip:ffefd5 peachpuff:ffdab9 peru:cd853f
pink:ffc0cb plum:dda0dd powderblue:b0e0e6 purple:800080 rebeccapurple:663399 red:ff0000 rosybrown:bc8f8f
royalblue:4169e1 saddlebrown:8b4513 salmon:fa8072 sandybrown:f4a460 seagreen:2e8b57 seashell:fff5ee
sienna:a0522d silver:c0c0c0 skyblue:87ceeb slateblue:6a5acd slategray:708090 slategrey:708090 snow:fffafa
springgreen:00ff7f steelblue:4682b4 tan:d2b48c teal:008080 thistle:d8bfd8 tomato:ff6347 turquoise:40e0d0
violet:ee82ee wheat:f5deb3 white:ffffff whitesmoke:f5f5f5 yellow:ffff00 yellowgreen:9acd32"""


@cache
def named_colors() -> dict[str, str]:
    """Return the hexadecimal digits of the named colors, by name."""
    return dict(entry.split(":") for entry in _NAMES.split())


def _from_hex(text: str) -> Vector | None:
    """Return the linear sRGB of ``#rrggbb`` or ``#rgb``, or None if it is malformed."""
    digits = text[1:]
    if len(digits) == 3:
        digits = "".join(digit * 2 for digit in digits)
    if len(digits) != 6 or not all(digit in "0123456789abcdef" for digit in digits):
        return None
    return Vector([linear(int(digits[start : start + 2], 16) / 255) for start in (0, 2, 4)])


def color_of(name: str) -> Vector:
    """Return the linear sRGB of a color given as text.

    Raises SceneError("value") for an unknown color, with similar names.
    """
    text = name.strip().lower()
    if not text.startswith("#"):
        digits = named_colors().get(text.replace(" ", ""))
        if digits is None:
            near = tuple(near_names(text, named_colors()))
            hint = f"did you mean {' or '.join(map(show, near))}?" if near else 'write a CSS name, "#c08040" or "#c84"'
            raise SceneError("value", f"unknown color {show(name, 40)}", hint=hint, near=near)
        text = "#" + digits
    vector = _from_hex(text)
    if vector is None:
        raise SceneError("value", f"unknown color {show(name, 40)}", hint='write a CSS name, "#c08040" or "#c84"')
    return vector


@registry.define(
    "color",
    "name::String",
    "Vector",
    "Return the color `#rrggbb`, `#rgb` or with a CSS name, as the linear sRGB that `:color` expects.",
    ('(list (color "#f00") (color "white"))', "([1.0 0.0 0.0] [1.0 1.0 1.0])"),
    check=color_of,
)
def color(rt: Runtime, name: str) -> Vector:
    rt.charge(len(name) >> 6)  # the name may be a computed string of any length
    return color_of(name)


def check_components(*components: Any) -> None:
    """Raise SceneError for a component outside 0 to 255."""
    for component in components:
        if not 0 <= component <= 255:
            raise SceneError("value", f"`rgb` expects components from 0 to 255, got {show(component, 30)}")


@registry.define(
    "rgb",
    "red::Number green::Number blue::Number",
    "Vector",
    "Return the color with sRGB components from 0 to 255, as the linear sRGB that `:color` expects.",
    ("(rgb 255 0 0)", "[1.0 0.0 0.0]"),
    check=check_components,
)
def rgb(rt: Runtime, *components: Any) -> Vector:
    check_components(*components)
    return Vector([linear(component / 255) for component in components])


@registry.define(
    "hsv",
    "hue::Number saturation::Number value::Number",
    "Vector",
    "Return the color with a hue from 0 to 1 (0 red, 1/3 green, 2/3 blue) and saturation and value from 0 to 1, "
    "converted as by Python's `colorsys`. The components are taken as linear.",
    ("(hsv 0 1 .5)", "[0.5 0.0 0.0]"),
)
def hsv(rt: Runtime, hue: Any, saturation: Any, value: Any) -> Vector:
    from colorsys import hsv_to_rgb

    if not abs(hue) < 1e15:
        raise wrong_type("hsv", "a finite number for `hue`", hue)
    return Vector(map(float, hsv_to_rgb(hue, saturation, value)))


def check_texture(name: str, **settings: Any) -> None:
    """Raise SceneError for a texture that does not exist, and for invalid settings."""
    _checked(name, settings)


def _checked(name: str, settings: Mapping[str, Any]) -> Any:
    """Return the list that describes a texture; raises SceneError."""
    value = make_list([name, *(item for setting in settings.items() for item in setting)])
    texture_of("texture", "texture", value, "`texture`")
    return value


@registry.define(
    "texture",
    "name::String [:scale::Number] [:turn::Number] [:colors] [:projection::String] [:text::String] [:side::String] "
    "[:at] [:bump::Number]",
    "List",
    "Return a texture for `:texture`: the pattern or image `name`, with elements of size `:scale` in scene "
    "units, turned by `:turn` degrees, in two `:colors`. `:projection` is box, planar, cylindrical, spherical, or uv "
    "for mesh files: where the coordinates of the file put it. The pattern text shows `:text`. With `:side` (front, "
    "back, left, right, top or bottom), an image or a text is on that side alone, once, and displaced by `:at` [right "
    "up]. `:bump` is the depth of a relief in units of `:scale`: the first color is higher than the second.",
    ('(texture "brick" :scale .3)', '("brick" "scale" 0.3)'),
    check=check_texture,
    picture='(call "cube" :texture (texture "brick" :scale .4))',
)
def texture(rt: Runtime, name: str, **settings: Any) -> Any:
    return _checked(name, settings)
