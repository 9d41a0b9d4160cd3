"""Planted faults: each replaces one line of one function, which is found by the function's name and the line itself.

So a record holds for every commit that has this line in a function of this name, whichever module the function is in.
"""

from __future__ import annotations

import ast
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

FOLDERS = ("grammar", "interpreter", "stdlib", "backends", "scenelang")
RECORDS = Path(__file__).with_name("faults.json")


@dataclass(frozen=True, slots=True)
class Fault:
    function: str  # with its classes and outer functions, without the module: "Reader.read_string"
    line: str
    fault: str
    kind: str

    @property
    def name(self) -> str:
        return f"{self.function}: {self.line} -> {self.fault}"


@dataclass(frozen=True, slots=True)
class Place:
    path: str  # in the checkout
    number: int

    @property
    def package(self) -> str:
        return self.path.partition("/")[0]


Index = dict[tuple[str, str], list[Place]]


def read_records(path: Path = RECORDS) -> list[Fault]:
    return [Fault(**record) for record in json.loads(path.read_text("utf-8"))]


def write_records(faults: Sequence[Fault], path: Path = RECORDS) -> None:
    rows = ",\n".join(json.dumps(asdict(fault), ensure_ascii=False) for fault in faults)
    path.write_text(f"[\n{rows}\n]\n", "utf-8")


def modules(tree: Path) -> list[Path]:
    found = [path for folder in FOLDERS for path in sorted((tree / folder).rglob("*.py"))]
    return [path for path in found if "node_modules" not in path.parts]


def owners(root: ast.AST, names: tuple[str, ...] = ()) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """The functions below a node with their names, outer ones before those in them."""
    for node in ast.iter_child_nodes(root):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield ".".join([*names, node.name]), node
            yield from owners(node, (*names, node.name))
        elif isinstance(node, ast.ClassDef):
            yield from owners(node, (*names, node.name))
        else:
            yield from owners(node, names)


def lines_of_functions(source: str) -> dict[int, str]:
    """The innermost function of each line of a body."""
    found: dict[int, str] = {}
    for name, function in owners(ast.parse(source)):
        found |= dict.fromkeys(range(function.body[0].lineno, (function.end_lineno or 0) + 1), name)
    return found


def index_of(tree: Path) -> Index:
    """Where each line of each function is in a checkout."""
    found: Index = {}
    for path in modules(tree):
        source = path.read_text("utf-8")
        lines = source.splitlines()
        for number, function in lines_of_functions(source).items():
            key = function, lines[number - 1].strip()
            found.setdefault(key, []).append(Place(str(path.relative_to(tree)), number))
    return found


def place_of(fault: Fault, index: Index) -> Place | None:
    """The one place of a fault; None where the commit has no such line, or several."""
    places = index.get((fault.function, fault.line), [])
    return places[0] if len(places) == 1 else None


def with_fault(source: str, place: Place, fault: Fault) -> str:
    """The module with the fault in it."""
    lines = source.splitlines(keepends=True)
    lines[place.number - 1] = lines[place.number - 1].replace(fault.line, fault.fault, 1)
    return "".join(lines)
