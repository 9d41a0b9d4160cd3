"""Type inference: what kinds of values every expression of the Python may have.

The whole program is interpreted over abstract values (``domain``): flow-sensitive inside a function, the arguments of
all call sites joined, containers by the place that makes them. Functions are looked at again until nothing grows.
"""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.infer_statements import StatementInference
from scenelang.interpreter.transpile.analysis.inference import (
    Facts,
)
from scenelang.interpreter.transpile.analysis.paths import Paths
from scenelang.interpreter.transpile.analysis.scopes import Function, Names


def infer(
    names: Names, paths: Paths, words: dict[str, Function], root: Function | None, additions: set[ast.AST]
) -> Facts:
    """Infer the types of a program. ``words`` maps what ``library_call`` may say to registered functions; what
    ``additions`` add to lists does not count as changing them."""
    inference = StatementInference(names, paths, words, additions)
    inference.enqueue(names.module)
    inference.run()
    if root is not None:
        inference.call_function(root, root.node, [], {})
    inference.run()
    for function in names.ordered:  # functions that nothing calls are looked at with what their annotations say
        if function not in inference.facts.reached:
            inference.assume_annotations(function)
            inference.enqueue(function)
            inference.run()
    _propagate_effects(inference)
    return inference.facts


def _propagate_effects(inference: StatementInference) -> None:
    effects, callees = inference.facts.effects, inference.callees
    changed = True
    while changed:
        changed = False
        for function, called in callees.items():
            total = effects.get(function, 0)
            for callee in called:
                total |= effects.get(callee, 0)
            if total != effects.get(function, 0):
                effects[function] = total
                changed = True
