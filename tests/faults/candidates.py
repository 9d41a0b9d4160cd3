"""Candidates for planted faults, drawn at random from the lines that two checkouts have in common.

``python -m faults.candidates NEWER OLDER COUNT`` in the folder of the tests prints records, as many in each package as
it has lines. What is never changed: texts, annotations, defaults, how long something waits, processes, and CUDA.
"""

from __future__ import annotations

import ast
import json
import random
import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache
from pathlib import Path

from faults.patches import FOLDERS, Fault, Index, index_of, modules, owners, place_of, with_fault

SEED = 18
PER_FUNCTION = 2
LEFT_LINES = re.compile(
    r"cuda|gpu|gsplat|device|timeout|seconds|sleep|deadline|monotonic|add_argument|help=|"
    r"unlink|rmtree|remove\(|logger|TYPE_CHECKING|version_info|platform|numba|\bgc\b"
)
LEFT_FUNCTIONS = re.compile(r"\b(kill|killpg|fork|_exit|waitpid|setrlimit|prctl)\b")
LEFT_NAMES = {"__repr__", "__str__"}
LEFT_CALLS = {
    "close",
    "flush",
    "print",
    "add_argument",
    "set_defaults",
    "simplefilter",
    "filterwarnings",
    "cache_clear",
}
LEFT_FILES = ("backends/neural/splats/kernels.py", "scenelang/doctor/doctor.py")

COMPARISONS = {
    ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">"), ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="), ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is"), ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}  # fmt: skip
ARITHMETIC = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "+"),
}  # fmt: skip
OBVIOUS = {"argument order": 0.25, "return": 0.4, "condition": 0.6}
LEAST_GREATEST = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}


class _Line:
    """One line of a module, and how to replace parts of it; columns of the syntax tree count bytes."""

    def __init__(self, text: str) -> None:
        self.raw = text.encode()

    def replaced(self, start: int, end: int, by: str) -> str:
        return (self.raw[:start] + by.encode() + self.raw[end:]).decode().strip()

    def part(self, start: int, end: int) -> str:
        return self.raw[start:end].decode()

    def operator(self, left: ast.expr, right: ast.expr, pair: tuple[str, str]) -> str | None:
        """The line with the operator between two operands changed."""
        start, end = left.end_col_offset or 0, right.col_offset
        between = self.part(start, end)
        if len(re.findall(rf"(?<![\w*/<>=!]){re.escape(pair[0])}(?![\w*/=])", between)) != 1:
            return None
        return self.replaced(start, end, between.replace(pair[0], pair[1], 1))


def changes(node: ast.AST, line: _Line) -> Iterator[tuple[str, str | None]]:
    """Kind and line of each fault that a node of the syntax tree can have."""
    match node:
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in COMPARISONS:
            yield "comparison", line.operator(left, right, COMPARISONS[type(op)])
        case ast.BinOp(left=left, op=op, right=right) if type(op) in ARITHMETIC and not _is_text(left, right):
            yield "arithmetic", line.operator(left, right, ARITHMETIC[type(op)])
        case ast.BoolOp(op=op, values=[*_, left, right]):
            pair = ("and", "or") if isinstance(op, ast.And) else ("or", "and")
            yield "and/or", line.operator(left, right, pair)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield "not dropped", line.replaced(node.col_offset, operand.col_offset, "")
        case ast.Constant(value=bool() as value):
            yield "constant", line.replaced(node.col_offset, node.end_col_offset or 0, repr(not value))
        case ast.Constant(value=int() | float() as value):
            yield "constant", line.replaced(node.col_offset, node.end_col_offset or 0, repr(value + 1))
        case ast.If(test=test) | ast.IfExp(test=test) | ast.While(test=test) if not isinstance(test, ast.Constant):
            inside = line.part(test.col_offset, test.end_col_offset or 0)
            yield "condition", line.replaced(test.col_offset, test.end_col_offset or 0, f"not ({inside})")
        case ast.Return(value=ast.expr() as value) if not isinstance(value, ast.Constant) or value.value is not None:
            yield "return", line.replaced(node.col_offset, node.end_col_offset or 0, f"return {_nothing(value)}")
        case ast.Expr(value=ast.Call(func=function)) if _name(function) not in LEFT_CALLS:
            yield "call removed", line.replaced(node.col_offset, node.end_col_offset or 0, "pass")
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name) as function) if name in LEAST_GREATEST:
            end = function.end_col_offset or 0
            yield "min/max", line.replaced(end - len(name), end, LEAST_GREATEST[name])
        case ast.Call(func=function, args=[first, second, *_]) if _can_swap(function, first, second):
            texts = [line.part(each.col_offset, each.end_col_offset or 0) for each in (first, second)]
            between = line.part(first.end_col_offset or 0, second.col_offset)
            swapped = f"{texts[1]}{between}{texts[0]}"
            yield "argument order", line.replaced(first.col_offset, second.end_col_offset or 0, swapped)


def _nothing(value: ast.expr) -> str:
    match value:
        case ast.Constant(value=bool()) | ast.Compare() | ast.UnaryOp(op=ast.Not()):
            return "None" if isinstance(value, ast.Constant) else "False"
        case ast.List() | ast.ListComp():
            return "[]"
        case ast.Dict() | ast.DictComp():
            return "{}"
    return "None"


def _name(function: ast.expr) -> str:
    return getattr(function, "attr", "") or getattr(function, "id", "")


def _is_text(*operands: ast.expr) -> bool:
    return any(isinstance(each, ast.JoinedStr) or isinstance(getattr(each, "value", None), str) for each in operands)


def _can_swap(function: ast.expr, first: ast.expr, second: ast.expr) -> bool:
    if any(isinstance(each, ast.Starred | ast.GeneratorExp) for each in (first, second)):
        return False
    return ast.dump(first) != ast.dump(second) and _name(function) not in {"isinstance", "cast", "print"}


def nodes_of(function: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a function that may be changed: none of texts, annotations, errors, or functions inside."""
    for child in ast.iter_child_nodes(function):
        if isinstance(child, ast.Raise | ast.Assert | ast.JoinedStr | ast.arguments | ast.FunctionDef | ast.ClassDef):
            continue
        yield child
        if isinstance(child, ast.AnnAssign):
            yield from nodes_of(ast.Expression(child.value)) if child.value else ()
        else:
            yield from nodes_of(child)


def _of_body(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[ast.AST]:
    yield from nodes_of(ast.Module(function.body, []))


def candidates_in(source: str) -> Iterator[Fault]:
    lines = source.splitlines()
    for name, function in owners(ast.parse(source)):
        text = "\n".join(lines[function.lineno - 1 : function.end_lineno])
        if function.name in LEFT_NAMES or LEFT_FUNCTIONS.search(text):
            continue
        for node in _of_body(function):
            number = getattr(node, "lineno", 0)
            if not number or LEFT_LINES.search(lines[number - 1]):
                continue
            span = node.test if isinstance(node, ast.If | ast.While) else node
            if span.lineno != number or span.end_lineno != number:
                continue
            for kind, changed in changes(node, _Line(lines[number - 1])):
                if changed is not None and changed != lines[number - 1].strip():
                    yield Fault(name, lines[number - 1].strip(), changed, kind)


def compiles(fault: Fault, tree: Path, index: Index) -> bool:
    """Whether the fault has one place in a checkout, where it is a program other than the right one."""
    place = place_of(fault, index)
    if place is None:
        return False
    source, right = _parsed(tree / place.path)
    try:
        return ast.dump(ast.parse(with_fault(source, place, fault))) != right
    except SyntaxError:
        return False


@cache
def _parsed(path: Path) -> tuple[str, str]:
    source = path.read_text("utf-8")
    return source, ast.dump(ast.parse(source))


def shares(tree: Path, count: int) -> dict[str, int]:
    """How many faults each package gets: in proportion to its lines of functions."""
    sizes: Counter[str] = Counter()
    for places in index_of(tree).values():
        sizes.update(place.package for place in places)
    return {folder: round(count * sizes[folder] / sizes.total()) for folder in FOLDERS}


def drawn(trees: list[Path], count: int, seed: int = SEED) -> list[Fault]:
    """Faults that all ``trees`` can have, in an order that is random throughout."""
    draw, newest = random.Random(seed), trees[0]
    indices, wanted = {tree: index_of(tree) for tree in trees}, shares(newest, count)
    by_line: dict[tuple[str, str, str], list[Fault]] = {}
    for path in modules(newest):
        name = str(path.relative_to(newest))
        if name in LEFT_FILES:
            continue
        for fault in candidates_in(path.read_text("utf-8")):
            by_line.setdefault((name, fault.function, fault.line), []).append(fault)
    lines = sorted(by_line)
    draw.shuffle(lines)
    chosen: list[Fault] = []
    functions: Counter[tuple[str, str]] = Counter()
    for key in lines:
        package = key[0].partition("/")[0]
        fault = _one(by_line[key], draw)
        obvious = OBVIOUS.get(fault.kind, 1.0) < draw.random()
        if obvious or not wanted[package] or functions[key[:2]] == PER_FUNCTION:
            continue
        if all(compiles(fault, tree, indices[tree]) for tree in trees):
            chosen.append(fault)
            functions[key[:2]] += 1
            wanted[package] -= 1
    return chosen


def _one(faults: list[Fault], draw: random.Random) -> Fault:
    """One of the faults of a line; those that any run of the line shows are drawn less often."""
    kinds = sorted({fault.kind for fault in faults})
    kind = draw.choices(kinds, [OBVIOUS.get(kind, 1.0) for kind in kinds])[0]
    return draw.choice([fault for fault in faults if fault.kind == kind])


if __name__ == "__main__":
    *paths, count = sys.argv[1:]
    print(
        "[\n"
        + ",\n".join(json.dumps(asdict(each)) for each in drawn([Path(each) for each in paths], int(count)))
        + "\n]"
    )
