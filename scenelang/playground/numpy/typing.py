"""Names of types, for annotations that are evaluated."""

from typing import Any

ArrayLike = Any


class NDArray:
    """Array of a type of elements."""

    def __class_getitem__(cls, item: Any) -> Any:
        return cls
