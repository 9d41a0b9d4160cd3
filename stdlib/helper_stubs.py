"""The helper API as Python stubs, for a language model to write against (the paper, appendix "Language Model Prompts").

Names and parameters are the transpiler's, descriptions the registry's: what each helper says is what its counterpart in
the language says, in Python's words.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from scenelang.interpreter.shapes import ATTRIBUTES, BLOCK_WORDS, PRIMITIVES, READ
from scenelang.interpreter.transpile.helper_api import HELPERS, Helper
from scenelang.stdlib.reference import lookup

_CLAUSE = re.compile(r"(?<=[^.])(?:: |; |\. ).*", re.S)
_LISP = re.compile(r"[,:;] `\(.*", re.S)
_ARRAY = re.compile(r"\[([^\][]+)\]")
# What the language calls otherwise than Python does.
_WORDS: Mapping[str, str] = {
    "an entity or parts": "a shape", "An entity": "A shape", "The entity of a word": "The shape of a word",
    "list of parts": "shape", "members": "shapes", "`count`": "`n`", "`axis`": "`direction`", "the function": "`fn`",
    "an association list or table": "a dictionary", "#t": "True", "#f": "False",
}  # fmt: skip

# What the language calls otherwise than JSON does.
_JSON_WORDS: Mapping[str, str] = {"an association list or table": "an object", "#t": "true", "#f": "false"}

_HEAD = """import math
import random
from collections.abc import Callable, Generator
from typing import Any

import numpy as np

P = Any  # a point or vector: three numbers, as a tuple, list or array
T = Any  # a pose: a 4x4 matrix, from the functions below; `A @ B` does B first, then A
Shape = Any  # primitives, each with its pose
"""


def helper_header(names: Sequence[str], words: Sequence[str]) -> str:
    """The stubs of the helpers ``names``, whose ``primitive_call`` makes the primitives ``words``."""
    pieces = [_HEAD]
    for name in names:
        helper = HELPERS[name]
        doc = _primitives(words) if name == "primitive_call" else [_described(helper)]
        signature = (
            _block_signature() if name == "primitive_call" and set(words) <= set(BLOCK_WORDS) else helper.signature
        )
        pieces.append(_stub(helper, signature, doc))
    return "\n\n".join(pieces)


def in_json(text: str) -> str:
    """What the registry says of a primitive or attribute, in the words of JSON."""
    text = _without_lisp(_without_colons(text))
    for words, others in _JSON_WORDS.items():
        text = text.replace(words, others)
    return _ARRAY.sub(lambda match: f"[{', '.join(match[1].split())}]", text)


def python_word(word: str) -> str:
    """A primitive's word as Python's programs write it."""
    return word.replace("-", "_") if word in BLOCK_WORDS else word


def _stub(helper: Helper, signature: str, doc: Sequence[str]) -> str:
    body = doc[0] if len(doc) == 1 else "\n".join([doc[0], *(f"    {line}".rstrip() for line in doc[1:]), "    "])
    return f'def {helper.name}({signature}) -> {helper.result}:\n    """{body}"""\n'


def _described(helper: Helper) -> str:
    """The first statement of the counterpart's description, then what only Python has to say."""
    record = lookup(helper.counterpart) if helper.counterpart is not None else None
    if record is None:
        return helper.note
    return f"{_in_python(_CLAUSE.sub('', _LISP.sub('', record.doc)).rstrip('.'))}. {helper.note}".rstrip()


def _in_python(text: str) -> str:
    for words, others in _WORDS.items():
        text = text.replace(words, others)
    return _ARRAY.sub(lambda match: f"({', '.join(match[1].split())})", text)


def _primitives(words: Sequence[str]) -> list[str]:
    """What each primitive is and what it takes, then what each argument means."""
    are_blocks = set(words) <= set(BLOCK_WORDS)
    lines = ["Makes a primitive.", ""]
    for word in words:
        taken = [name for name in READ[word] if name != "color"]
        keys = ", ".join(f"'{name}'" if not are_blocks else name.replace("-", "_") for name in taken)
        lines.append(f"'{python_word(word)}': {_plain(PRIMITIVES[word])}; takes {keys}")
    lines.append("")
    return [*lines, *_arguments(words, are_blocks)]


def _arguments(words: Sequence[str], are_blocks: bool) -> Iterator[str]:
    read = dict.fromkeys(name for word in words for name in READ[word])
    for name in read:
        if not (are_blocks and name == "color"):
            yield f"{name.replace('-', '_')}: {_plain(_without_lisp(ATTRIBUTES[name]))}"


def _without_lisp(text: str) -> str:
    return "; ".join(piece for piece in text.split("; ") if "`(" not in piece)


def _plain(text: str) -> str:
    return _in_python(_without_colons(text))


def _without_colons(text: str) -> str:
    return re.sub(r":(p0|p1)\b", r"\1", text)


def _block_signature() -> str:
    return "name: str, **block_arguments"
