"""What annotations say about types; inference falls back on them where no call site tells more."""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.domain import (
    ARRAY,
    NOTHING,
    T_BOOL,
    T_FLOAT,
    T_INT,
    T_NONE,
    T_SHAPE,
    T_STR,
    Type,
)

_SIMPLE = {"int": T_INT, "float": T_FLOAT, "bool": T_BOOL, "str": T_STR, "Shape": T_SHAPE, "None": T_NONE}


def annotated(annotation: ast.expr | None) -> Type:
    """The type that an annotation tells for sure; NOTHING where it does not."""
    if isinstance(annotation, ast.Name):
        return _SIMPLE.get(annotation.id, NOTHING)
    if isinstance(annotation, ast.Constant):
        return T_NONE if annotation.value is None else _SIMPLE.get(str(annotation.value), NOTHING)
    if isinstance(annotation, ast.Attribute) and annotation.attr == "ndarray":
        return Type(ARRAY)
    if isinstance(annotation, ast.Subscript) and isinstance(annotation.value, ast.Name):
        if annotation.value.id == "Optional":
            return annotated(annotation.slice) | T_NONE
    if isinstance(annotation, ast.BinOp):
        return annotated(annotation.left) | annotated(annotation.right)
    return NOTHING
