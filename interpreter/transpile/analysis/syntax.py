"""Questions about Python's syntax that several parts of the transpiler ask."""

from __future__ import annotations

import ast


def is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def inner_blocks(statement: ast.stmt) -> list[list[ast.stmt]]:
    """The blocks of a compound statement that are of the same function."""
    if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
        return []
    blocks = [getattr(statement, name, None) for name in ("body", "orelse", "finalbody")]
    found = [block for block in blocks if block]
    for handler in getattr(statement, "handlers", ()):
        found.append(handler.body)
    return found
