"""Numbers that have names."""

from __future__ import annotations

import math

CONSTANTS: dict[str, tuple[float, str]] = {
    "pi": (math.pi, "Half the circumference of the unit circle; half a turn in radians."),
    "tau": (math.tau, "The circumference of the unit circle; a full turn in radians."),
    "e": (math.e, "The base of the natural logarithm."),
    "inf": (math.inf, "Infinity; poses and the attributes of primitives refuse it."),
    "nan": (math.nan, "Not a number, as `(- inf inf)`; it equals nothing, not even itself."),
}
