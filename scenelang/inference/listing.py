"""Conversion between scenes and flat lists of primitives with words and poses (the paper's ablation "No-P").

An item is ``{"word": ..., "shape": ..., "attributes": {...}, "pose": [[...], [...], [...]]}``: ``word`` is the entity
to which the primitive belongs, ``pose`` the upper three rows of its world matrix. A film is a list of such lists.
"""

from __future__ import annotations

import ast
import json
import math
import random
import re
import string
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NoReturn

from scenelang.grammar.datum import Atom, Datum, ListDatum, Source, Symbol, number_text, print_datum, string_text
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.python_helpers import HELPERS
from scenelang.grammar.reader import read
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import FlatFrame, flatten
from scenelang.interpreter.scene.primitives import is_word
from scenelang.session.formatting import formatted

MAX_ITEMS = 5_000
_FENCE = re.compile(r"^[ \t]*+```[ \t]*+(?:json)?[ \t]*+\n(.*?)^[ \t]*+```", re.M | re.S)
_DIGITS = 6
_NOTHING = 1e-12  # rounding residue of a quarter rotation
_MAX_DEPTH = 20
_ROOT = "scene"


def listing(scene: Scene, with_words: bool) -> str:
    """Return the primitives of a scene as JSON, one per line. Raises SceneError for more than ``MAX_ITEMS``."""
    flat = flatten(scene, MAX_ITEMS)
    frames = [_frame(frame, with_words=with_words) for frame in flat.frames]
    return _lines(frames[0]) if not flat.animated else "[\n" + ",\n".join(map(_lines, frames)) + "\n]"


def _lines(items: Sequence[Mapping[str, Any]]) -> str:
    return "[\n" + ",\n".join(json.dumps(item, ensure_ascii=False) for item in items) + "\n]"


def _frame(frame: FlatFrame, *, with_words: bool) -> list[dict[str, Any]]:
    items = []
    for i in range(len(frame)):
        entity, path = frame.primitives[frame.index[i]], frame.paths[frame.path_index[i]]
        items.append(_item(entity, path, frame.matrices[i].tolist(), with_words=with_words))
    return items


def _item(entity: Entity, path: tuple[str, ...], matrix: list[list[float]], *, with_words: bool) -> dict[str, Any]:
    has_geometry = is_word(entity.word)
    word = path[-1] if has_geometry and path else entity.word
    item: dict[str, Any] = {"word": word} if with_words else {}
    item["shape"] = entity.word if has_geometry else "box"
    item["attributes"] = {name: _rounded(_table(name, value)) for name, value in primitive_attributes(entity).items()}
    if with_words and entity.embedding.text:
        item["text"] = entity.embedding.text
    return item | {"pose": _rounded(matrix)}


def _table(name: str, value: Any) -> Any:
    """Convert the states of a block from a list of pairs to a JSON object."""
    is_states = name == "block-kwargs" and isinstance(value, list)
    return dict(value) if is_states and all(isinstance(pair, list) and len(pair) == 2 for pair in value) else value


def _rounded(value: Any) -> Any:
    """Round numbers to save tokens."""
    if isinstance(value, float):
        value = 0.0 if abs(value) < _NOTHING else value
        return int(value) if value == round(value) and abs(value) < 1e9 else float(f"{value:.{_DIGITS}g}")
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return {name: _rounded(item) for name, item in value.items()} if isinstance(value, dict) else value


# --- parsing a list ------------------------------------------------------------------------------------------------


def program_of(answer: str, task: str) -> str:
    """Extract the list from an answer and convert it to a program. Raises SceneError("listing")."""
    frames = _frames(_parsed(answer))
    header = "".join(f"; {line}\n" for line in task.splitlines() if line.strip())
    scenes = ["(union" + "".join(f"\n  {line}" for line in map(_part, frame)) + ")" for frame in frames]
    body = scenes[0] if len(scenes) == 1 else "(frames (list\n" + "\n".join(scenes) + "))"
    return f"{header}\n(bind {string_text(_ROOT)} (lambda () {body}))\n"


def _parsed(answer: str) -> Any:
    fenced = _FENCE.search(answer)
    text = fenced[1] if fenced is not None else answer[answer.find("[") : answer.rfind("]") + 1]
    try:
        return json.loads(text, parse_constant=_refuse, parse_int=_whole)
    except json.JSONDecodeError as error:
        raise SceneError("listing", f"no valid JSON list in the answer: {error.msg} (line {error.lineno})") from None
    except (ValueError, RecursionError) as error:
        raise SceneError("listing", f"cannot parse the list: {str(error)[:80]}") from None


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not a JSON number")


def _whole(text: str) -> int:
    if len(text) > 18:
        raise ValueError(f"{text[:20]} is too large")
    return int(text)


def _frames(data: Any) -> list[list[Any]]:
    if not isinstance(data, list) or not data:
        raise SceneError("listing", "the answer is not a list of primitives")
    frames = data if all(isinstance(item, list) for item in data) else [data]
    if sum(map(len, frames)) > MAX_ITEMS:
        raise SceneError("listing", f"the list has more than {MAX_ITEMS:,} primitives")
    return frames


def _part(item: Any) -> str:
    """Convert an item to a form: the primitive with its pose, inside an entity of its word."""
    if not isinstance(item, dict):
        raise SceneError("listing", f"expected a JSON object as an item of the list, got: {json.dumps(item)[:60]}")
    shape, word = item.get("shape"), item.get("word")
    if not isinstance(shape, str) or not shape or not (word is None or isinstance(word, str)):
        raise SceneError("listing", f"expected a name as the `shape` of an item: {json.dumps(item)[:80]}")
    is_semantic = not is_word(shape)
    name = word if is_semantic and word else shape
    text = f" {string_text(item['text'])}" if isinstance(item.get("text"), str) else ""
    primitive = f"(call {string_text(name)}{text}{''.join(_attributes(item))})"
    if word and not is_semantic and word != shape:
        primitive = f"(make-entity {string_text(word)} (embedding) {primitive})"
    return f"(transform {primitive} {_pose(item)})"


def _attributes(item: Mapping[str, Any]) -> Iterator[str]:
    attributes = item.get("attributes", {})
    if not isinstance(attributes, dict):
        raise SceneError("listing", f"expected a JSON object as the `attributes` of an item: {json.dumps(item)[:80]}")
    for name, value in attributes.items():
        if not _is_name(name):
            raise SceneError("listing", f"invalid attribute name `{name[:40]}`")
        if value is not None:
            yield f" :{name} {_literal(value)}"


@lru_cache(1024)
def _is_name(text: str) -> bool:
    """Return whether ``:text`` parses as one keyword."""
    result = read(Source("<attribute>", f":{text}"))
    return len(result.forms) == 1 and not result.diagnostics and result.forms[0].span.end == len(text) + 1


def _literal(value: Any, depth: int = 0) -> str:
    """Convert JSON data to an expression of the language: arrays of numbers, lists, association lists."""
    if depth > _MAX_DEPTH:
        raise SceneError("listing", "an attribute of the list is nested too deeply")
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "#t" if value else "#f"
    if isinstance(value, (int, float)):
        return _number(value)
    if isinstance(value, str):
        return string_text(value)
    if isinstance(value, dict):
        pairs = (f" (list {string_text(name)} {_literal(item, depth + 1)})" for name, item in value.items())
        return f"(list{''.join(pairs)})"
    items: list[Any] = value
    inner = [_literal(item, depth + 1) for item in items]
    are_numbers = bool(items) and all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in items)
    return f"[{' '.join(inner)}]" if are_numbers else f"(list{''.join(f' {text}' for text in inner)})"


def _number(value: float) -> str:
    if not math.isfinite(value):
        raise SceneError("listing", "a number of the list is too large")
    return number_text(value)


def _pose(item: Mapping[str, Any]) -> str:
    rows = item.get("pose")
    if not isinstance(rows, list) or not _is_matrix(rows):
        raise SceneError(
            "listing", f"expected three rows of four numbers as the `pose` of an item: {json.dumps(item)[:80]}"
        )
    written = [f"[{' '.join(map(_number, row))}]" for row in [*rows[:3], [0, 0, 0, 1]]]
    return f"(pose [{' '.join(written)}])"


def _is_matrix(rows: list[Any]) -> bool:
    """Return whether rows are the upper three or all four rows of a pose matrix."""
    if len(rows) not in (3, 4) or not all(isinstance(row, list) and len(row) == 4 for row in rows):
        return False
    if not all(isinstance(x, (int, float)) and not isinstance(x, bool) for row in rows for x in row):
        return False
    return len(rows) == 3 or rows[3] == [0, 0, 0, 1]


# Random names in place of words (the paper, appendix "Ablations": No-W), and their inverse.


_LENGTH = 8
_LETTER_RUN = re.compile(r"[a-z]{8}")
_DEFINERS = ("define", "bind", "define-record")


@dataclass(frozen=True, slots=True)
class Renamed:
    """A program with random names. ``words`` maps each random name to the original."""

    text: str
    words: Mapping[str, str]

    def restored(self, text: str) -> str:
        """Replace the random names in a model's text by the original words."""
        return _LETTER_RUN.sub(lambda match: self.words.get(match[0], match[0]), text)


def rename_python(text: str, seed: int) -> Renamed:
    """Replace function names in Python by random names, and remove comments and docstrings; nothing is executed. Raises
    SyntaxError, ValueError or RecursionError for invalid Python."""
    tree = ast.parse(text)
    names = _random_names(_functions(tree), seed, text)
    return Renamed(ast.unparse(ast.fix_missing_locations(_Renaming(names).visit(tree))) + "\n", _turned(names))


def _functions(tree: ast.Module) -> list[str]:
    functions = [node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    return [name for name in dict.fromkeys(functions) if name not in HELPERS]


class _Renaming(ast.NodeTransformer):
    """Rename functions at definitions, references and calls by word; remove docstrings."""

    def __init__(self, names: Mapping[str, str]) -> None:
        self._names = names

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.name = self._names.get(node.name, node.name)
        self.generic_visit(node)
        node.body = node.body or [ast.Pass()]
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        node.id = self._names.get(node.id, node.id)
        return node

    def visit_Expr(self, node: ast.Expr) -> ast.AST | None:
        is_docstring = isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        return None if is_docstring else self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Preserve the primitive's word and attribute names, even if a function has the same name."""
        if not (isinstance(node.func, ast.Name) and node.func.id == "primitive_call"):
            return self.generic_visit(node)
        node.args = [node.args[0], *map(self._value, node.args[1:])] if node.args else []
        for keyword in node.keywords:
            keyword.value = keyword.value if keyword.arg == "name" else self._value(keyword.value)
        return node

    def _value(self, node: ast.expr) -> ast.expr:
        if isinstance(node, ast.Dict):
            node.values = [self.visit(value) for value in node.values]
            return node
        visited: ast.expr = self.visit(node)
        return visited

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, str):
            node.value = self._names.get(node.value, node.value)
        return node


def rename_language(text: str, seed: int) -> Renamed:
    """Replace words and definitions of a program by random names, and remove comments."""
    forms = read(Source("<program>", text)).forms
    names = _random_names(_defined(forms), seed, text)
    lines = [print_datum(_renamed_datum(form, names)) for form in forms]
    return Renamed(formatted("\n\n".join(lines) + "\n"), _turned(names))


def _defined(forms: Iterable[Datum]) -> list[str]:
    """Return the words and names defined at the top level."""
    names: list[str] = []
    for form in forms:
        if not isinstance(form, ListDatum) or len(form.items) < 2 or _symbol(form.items[0]) not in _DEFINERS:
            continue
        named: Datum = form.items[1]
        while isinstance(named, ListDatum) and named.items:
            named = named.items[0]
        if isinstance(named, Atom) and isinstance(named.value, str) and named.value:
            names.append(str(named.value))
    return list(dict.fromkeys(names))


def _symbol(datum: Datum) -> str:
    return str(datum.value) if isinstance(datum, Atom) and isinstance(datum.value, Symbol) else ""


def _renamed_datum(datum: Datum, names: Mapping[str, str]) -> Datum:
    if isinstance(datum, Atom):
        value = datum.value
        if isinstance(value, Symbol) and str(value) in names:
            return replace(datum, value=Symbol(names[str(value)]))
        if type(value) is str and value in names:
            return replace(datum, value=names[value])
        return datum
    return replace(datum, items=tuple(_renamed_datum(item, names) for item in datum.items))


def _random_names(names: Iterable[str], seed: int, text: str) -> dict[str, str]:
    """Return a random name of eight letters for each name, chosen not to occur in the text."""
    letters = random.Random(seed)
    taken: set[str] = set()
    random_names: dict[str, str] = {}
    for name in names:
        while True:
            chosen = "".join(letters.choices(string.ascii_lowercase, k=_LENGTH))
            if chosen not in taken and chosen not in text:
                break
        taken.add(chosen)
        random_names[name] = chosen
    return random_names


def _turned(names: Mapping[str, str]) -> dict[str, str]:
    return {random_name: name for name, random_name in names.items()}
