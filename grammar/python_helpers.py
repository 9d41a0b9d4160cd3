"""The helper API that a language model's Python uses: the paper's macros as Python functions (section 5).

The transpiler, the prompts and the reference take names, parameters and counterparts from this table.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from scenelang.grammar.lazy_patterns import lazy_pattern

_PARAMETER = lazy_pattern(r"(\w+):[^=]*?(=[^,]*?(?:\([^)]*\))?)?(?:,|$)")


@dataclass(frozen=True, slots=True)
class Helper:
    """Function of the helper API.

    Attributes
    ----------
    signature
        Parameters with types and defaults, as in Python.
    result
        Type of the result.
    counterpart
        Function of the language that it is translated to, None for a decorator.
    note
        Additional documentation of the Python function.
    """

    name: str
    signature: str
    result: str
    counterpart: str | None
    note: str = ""

    @property
    def parameters(self) -> str:
        """Names of the parameters in order, with a question mark after an optional one: ``angle direction point?``."""
        parameters = _PARAMETER.findall(self.signature)
        return " ".join(name + ("?" if default else "") for name, default in parameters)


_ALL = (
    Helper(
        "register", "docstring: str | None = None", "Callable", None,
        "Decorator for a function that returns a shape; `library_call` finds it by its name.",
    ),
    Helper(
        "register_animation", "docstring: str | None = None", "Callable", None,
        "Decorator for the one function that creates the animation: a generator that yields the shape of every frame.",
    ),
    Helper(
        "library_call", "func_name: str, **kwargs", "Shape", "call",
        "Call the registered function `func_name`; pass all its arguments by name.",
    ),
    Helper("primitive_call", "name: str, shape_kwargs: dict, color: P = (1, 1, 1)", "Shape", "call"),
    Helper("loop", "n: int, fn: Callable[[int], Shape]", "Shape", "union-loop"),
    Helper("concat_shapes", "*shapes: Shape", "Shape", "union"),
    Helper("transform_shape", "shape: Shape, pose: T", "Shape", "transform"),
    Helper("translation_matrix", "offset: P", "T", "translate"),
    Helper("rotation_matrix", "angle: float, direction: P, point: P = (0, 0, 0)", "T", "rotate"),
    Helper("scale_matrix", "scale: float | P, origin: P = (0, 0, 0)", "T", "scale"),
    Helper("reflection_matrix", "point: P, normal: P", "T", "reflect"),
    Helper("identity_matrix", "", "T", "identity-pose"),
    Helper("compute_shape_center", "shape: Shape", "P", "compute-shape-center"),
    Helper("compute_shape_min", "shape: Shape", "P", "compute-shape-min"),
    Helper("compute_shape_max", "shape: Shape", "P", "compute-shape-max"),
    Helper("compute_shape_sizes", "shape: Shape", "P", "compute-shape-sizes"),
)  # fmt: skip

HELPERS: Mapping[str, Helper] = MappingProxyType({helper.name: helper for helper in _ALL})
