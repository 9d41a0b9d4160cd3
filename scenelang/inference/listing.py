"""A scene as the flat list of its primitives with words and poses, and such a list as a scene (the paper's No-P).

One item is ``{"word": ..., "shape": ..., "attributes": {...}, "pose": [[...], [...], [...]]}``: ``word`` names what the
primitive belongs to, ``pose`` are the upper three rows of its matrix in the world. A film is a list of such lists.
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

from scenelang.formatting import formatted
from scenelang.grammar.datum import Atom, Datum, ListDatum, Source, Symbol, number_text, print_datum, string_text
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import FlatFrame, flatten
from scenelang.interpreter.scene.primitives import is_word
from scenelang.interpreter.transpile.python_text import HELPERS

MOST_ITEMS = 5_000
_FENCE = re.compile(r"^[ \t]*+```[ \t]*+(?:json)?[ \t]*+\n(.*?)^[ \t]*+```", re.M | re.S)
_DIGITS = 6
_NOTHING = 1e-12  # what turning by a quarter leaves of a zero
_DEEPEST = 20
_ROOT = "scene"


def listing(scene: Scene, with_words: bool) -> str:
    """The primitives of a scene as JSON, one in a line. Raises SceneError for more than ``MOST_ITEMS``."""
    flat = flatten(scene, MOST_ITEMS)
    frames = [_frame(frame, with_words) for frame in flat.frames]
    return _lines(frames[0]) if not flat.animated else "[\n" + ",\n".join(map(_lines, frames)) + "\n]"


def _lines(items: Sequence[Mapping[str, Any]]) -> str:
    return "[\n" + ",\n".join(json.dumps(item, ensure_ascii=False) for item in items) + "\n]"


def _frame(frame: FlatFrame, with_words: bool) -> list[dict[str, Any]]:
    found = []
    for i in range(len(frame)):
        entity, path = frame.primitives[frame.index[i]], frame.paths[frame.path_index[i]]
        found.append(_item(entity, path, frame.matrices[i].tolist(), with_words))
    return found


def _item(entity: Entity, path: tuple[str, ...], matrix: list[list[float]], with_words: bool) -> dict[str, Any]:
    has_geometry = is_word(entity.word)
    word = path[-1] if has_geometry and path else entity.word
    item: dict[str, Any] = {"word": word} if with_words else {}
    item["shape"] = entity.word if has_geometry else "box"
    item["attributes"] = {name: _rounded(_table(name, value)) for name, value in primitive_attributes(entity).items()}
    if with_words and entity.embedding.text:
        item["text"] = entity.embedding.text
    return item | {"pose": _rounded(matrix)}


def _table(name: str, value: Any) -> Any:
    """The states of a block as an object: the language has them as a list of pairs."""
    is_states = name == "block-kwargs" and isinstance(value, list)
    return dict(value) if is_states and all(isinstance(pair, list) and len(pair) == 2 for pair in value) else value


def _rounded(value: Any) -> Any:
    """Numbers with few digits: the model reads every one."""
    if isinstance(value, float):
        value = 0.0 if abs(value) < _NOTHING else value
        return int(value) if value == round(value) and abs(value) < 1e9 else float(f"{value:.{_DIGITS}g}")
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return {name: _rounded(item) for name, item in value.items()} if isinstance(value, dict) else value


# --- reading a list back -------------------------------------------------------------------------------------------


def program_of(answer: str, task: str) -> str:
    """The program of the scene that a list describes, in an answer that may hold more. Raises SceneError("listing")."""
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
        raise SceneError("listing", f"the answer holds no list in JSON: {error.msg} (line {error.lineno})") from None
    except (ValueError, RecursionError) as error:
        raise SceneError("listing", f"the list cannot be read: {str(error)[:80]}") from None


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number of JSON")


def _whole(text: str) -> int:
    if len(text) > 18:
        raise ValueError(f"{text[:20]} is too large")
    return int(text)


def _frames(data: Any) -> list[list[Any]]:
    if not isinstance(data, list) or not data:
        raise SceneError("listing", "the answer is no list of primitives")
    frames = data if all(isinstance(item, list) for item in data) else [data]
    if sum(map(len, frames)) > MOST_ITEMS:
        raise SceneError("listing", f"the list has more than {MOST_ITEMS:,} primitives")
    return frames


def _part(item: Any) -> str:
    """An item as a form: its primitive under its pose, inside an entity of its word."""
    if not isinstance(item, dict):
        raise SceneError("listing", f"an item of the list is no object: {json.dumps(item)[:60]}")
    shape, word = item.get("shape"), item.get("word")
    if not isinstance(shape, str) or not shape or not (word is None or isinstance(word, str)):
        raise SceneError("listing", f"an item lacks `shape`, a name: {json.dumps(item)[:80]}")
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
        raise SceneError("listing", f"`attributes` of an item is no object: {json.dumps(item)[:80]}")
    for name, value in attributes.items():
        if not _is_name(name):
            raise SceneError("listing", f"`{name[:40]}` is no name of an attribute")
        if value is not None:
            yield f" :{name} {_literal(value)}"


@lru_cache(1024)
def _is_name(text: str) -> bool:
    """Whether ``:text`` reads as one keyword."""
    result = read(Source("<attribute>", f":{text}"))
    return len(result.forms) == 1 and not result.diagnostics and result.forms[0].span.end == len(text) + 1


def _literal(value: Any, depth: int = 0) -> str:
    """JSON data as an expression of the language: arrays of numbers, lists, association lists."""
    if depth > _DEEPEST:
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
        raise SceneError("listing", f"`pose` of an item is not three rows of four numbers: {json.dumps(item)[:80]}")
    written = [f"[{' '.join(map(_number, row))}]" for row in [*rows[:3], [0, 0, 0, 1]]]
    return f"(pose [{' '.join(written)}])"


def _is_matrix(rows: list[Any]) -> bool:
    """Whether rows are the upper three of a pose's matrix, or all four."""
    if len(rows) not in (3, 4) or not all(isinstance(row, list) and len(row) == 4 for row in rows):
        return False
    if not all(isinstance(x, (int, float)) and not isinstance(x, bool) for row in rows for x in row):
        return False
    return len(rows) == 3 or rows[3] == [0, 0, 0, 1]


# Random names in place of words (the paper, appendix "Ablations": No-W), and the words back again.


_LENGTH = 8
_LETTER_RUN = re.compile(r"[a-z]{8}")
_DEFINERS = ("define", "bind", "define-record")


@dataclass(frozen=True, slots=True)
class Renamed:
    """A program under other names. ``words`` leads from each random name back to what it stands for."""

    text: str
    words: Mapping[str, str]

    def restored(self, text: str) -> str:
        """A text of a model's with the words back in place of the random names."""
        return _LETTER_RUN.sub(lambda match: self.words.get(match[0], match[0]), text)


def rename_python(text: str, seed: int) -> Renamed:
    """Python with random names for its functions, without comments and docstrings. Raises SyntaxError, ValueError or
    RecursionError for text that is no Python; it is not run."""
    tree = ast.parse(text)
    names = _random_names(_functions(tree), seed, text)
    return Renamed(ast.unparse(ast.fix_missing_locations(_Renaming(names).visit(tree))) + "\n", _turned(names))


def _functions(tree: ast.Module) -> list[str]:
    found = [node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    return [name for name in dict.fromkeys(found) if name not in HELPERS]


class _Renaming(ast.NodeTransformer):
    """Renames functions where they are defined, named and called by word; docstrings are left out."""

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
        """A primitive's word and the names of its attributes stay, also where a function is called the same."""
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
        found: ast.expr = self.visit(node)
        return found

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, str):
            node.value = self._names.get(node.value, node.value)
        return node


def rename_language(text: str, seed: int) -> Renamed:
    """A program of the language with random names for its words and definitions, without comments."""
    forms = read(Source("<program>", text)).forms
    names = _random_names(_defined(forms), seed, text)
    lines = [print_datum(_renamed_datum(form, names)) for form in forms]
    return Renamed(formatted("\n\n".join(lines) + "\n"), _turned(names))


def _defined(forms: Iterable[Datum]) -> list[str]:
    """Words that are bound and names that are defined at the top level."""
    found: list[str] = []
    for form in forms:
        if not isinstance(form, ListDatum) or len(form.items) < 2 or _symbol(form.items[0]) not in _DEFINERS:
            continue
        named: Datum = form.items[1]
        while isinstance(named, ListDatum) and named.items:
            named = named.items[0]
        if isinstance(named, Atom) and isinstance(named.value, str) and named.value:
            found.append(str(named.value))
    return list(dict.fromkeys(found))


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
    """A name of eight letters for each, none of which the text holds."""
    letters = random.Random(seed)
    taken: set[str] = set()
    found: dict[str, str] = {}
    for name in names:
        while True:
            chosen = "".join(letters.choices(string.ascii_lowercase, k=_LENGTH))
            if chosen not in taken and chosen not in text:
                break
        taken.add(chosen)
        found[name] = chosen
    return found


def _turned(names: Mapping[str, str]) -> dict[str, str]:
    return {random_name: name for name, random_name in names.items()}
