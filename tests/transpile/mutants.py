"""Programs spoilt at random: what a language model might write on a bad day, and worse."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

_TOKEN = re.compile(r"\"\"\".*?\"\"\"|'''.*?'''|\"[^\"\n]*\"|'[^'\n]*'|#[^\n]*|\w+|\s+|[^\w\s]", re.S)
_NAME = re.compile(r"[A-Za-z_]\w*\Z")
_NUMBER = re.compile(r"\d[\w.]*\Z")
_PYTHON_NAMES = ("shapes", "i", "None", "math", "np", "random", "self", "list", "library_call", "len", "lambda", "x")
_CONSTANTS = ("0", "-1", "None", "True", "1e400", "10**9", "'text'", "[]", "()", "{}", "1j", "b'x'", "...", "f'{i}'")
_STRAY = (
    "pass", "break", "continue", "return", "return None", "yield", "del shapes", "global shapes", "nonlocal x",
    "raise ValueError('no')", "assert False", "import os", "from math import *", "x: int", "x = yield", "await x",
    "lambda: (yield)", "with x as y: pass", "class A: pass", "def f(*, a, **k): return f", "a = b = c = []",
    "a, *b = 1, 2", "a[b].c += 1", "[x for x in x if x]", "(y := 1)", "match 1:\n    case _: pass", "print('x')",
    "try:\n    pass\nfinally:\n    pass", "while True: pass", "for i in []: pass\nelse: pass", "async def f(): pass",
)  # fmt: skip

Change = Callable[[random.Random, str], str]


def _pieces(code: str) -> tuple[list[str], list[int]]:
    """The tokens of a program with the spaces between them, and the places of those that are no spaces."""
    tokens = _TOKEN.findall(code)
    return tokens, [i for i, token in enumerate(tokens) if token.strip()]


def _delete_token(rng: random.Random, code: str) -> str:
    tokens, solid = _pieces(code)
    for i in sorted(rng.sample(solid, min(rng.randint(1, 3), len(solid))), reverse=True):
        del tokens[i]
    return "".join(tokens)


def _duplicate_token(rng: random.Random, code: str) -> str:
    tokens, solid = _pieces(code)
    i = rng.choice(solid)
    tokens.insert(i, tokens[i] + " ")
    return "".join(tokens)


def _swap_tokens(rng: random.Random, code: str) -> str:
    tokens, solid = _pieces(code)
    i = rng.randrange(len(solid) - 1)
    j = i + 1 if rng.random() < 0.5 else rng.randrange(len(solid))
    tokens[solid[i]], tokens[solid[j]] = tokens[solid[j]], tokens[solid[i]]
    return "".join(tokens)


def _rename(rng: random.Random, code: str) -> str:
    """One use of a name, or all of them, becomes another name of the program or a common one."""
    tokens, solid = _pieces(code)
    names = [i for i in solid if _NAME.match(tokens[i])]
    old = tokens[rng.choice(names)]
    new = rng.choice([tokens[rng.choice(names)], rng.choice(_PYTHON_NAMES)])
    places = [i for i in names if tokens[i] == old]
    for i in places if rng.random() < 0.4 else [rng.choice(places)]:
        tokens[i] = new
    return "".join(tokens)


def _replace_constant(rng: random.Random, code: str) -> str:
    tokens, solid = _pieces(code)
    constants = [i for i in solid if _NUMBER.match(tokens[i]) or tokens[i][0] in "\"'"]
    tokens[rng.choice(constants or solid)] = rng.choice(_CONSTANTS)
    return "".join(tokens)


def _replace_by_expression(rng: random.Random, code: str) -> str:
    """A name or number becomes some other piece of the program between brackets."""
    tokens, solid = _pieces(code)
    atoms = [i for i in solid if _NAME.match(tokens[i]) or _NUMBER.match(tokens[i])]
    inner = rng.choice(re.findall(r"\([^()\n]*\)|\[[^\[\]\n]*\]", code) or ["()"])
    tokens[rng.choice(atoms)] = inner
    return "".join(tokens)


def _drop_argument(rng: random.Random, code: str) -> str:
    found = list(re.finditer(r"(?<=[(,])[^(),\n]+,|,[^(),\n]+(?=\))", code))
    if not found:
        return code
    match = rng.choice(found)
    return code[: match.start()] + code[match.end() :]


def _change_lines(rng: random.Random, code: str) -> str:
    lines = code.split("\n")
    full = [i for i, line in enumerate(lines) if line.strip()]
    i, j = rng.choice(full), rng.choice(full)
    match rng.randrange(5):
        case 0:
            del lines[i]
        case 1:
            lines.insert(j, lines[i])
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case 3:
            lines[i] = rng.choice(("    ", "", "  ", "\t")) + (lines[i].lstrip() if rng.random() < 0.5 else lines[i])
        case _:
            del lines[i : i + rng.randint(2, 8)]
    return "\n".join(lines)


def _insert_statement(rng: random.Random, code: str) -> str:
    lines = code.split("\n")
    i = rng.choice([i for i, line in enumerate(lines) if line.strip()])
    margin = lines[i][: len(lines[i]) - len(lines[i].lstrip())]
    lines[i:i] = [margin + line for line in rng.choice(_STRAY).split("\n")]
    return "\n".join(lines)


_WRAPPERS = (
    "try:", "if True:", "while True:", "for q in range(2):", "def inner():", "with open('x') as f:", "class Inner:",
    "async def inner():", "for a, (b, *c) in [(1, (2, 3))]:", "if 0:",
)  # fmt: skip


def _wrap_lines(rng: random.Random, code: str) -> str:
    """A run of lines of equal depth goes under a `try` or the like."""
    lines = code.split("\n")
    start = rng.choice([i for i, line in enumerate(lines) if line.strip()])
    margin = len(lines[start]) - len(lines[start].lstrip())
    end = start + 1
    while end < len(lines) and (not lines[end].strip() or lines[end].startswith(" " * margin)):
        end += 1
        if rng.random() < 0.2:
            break
    head = rng.choice(_WRAPPERS)
    body = ["    " + line if line.strip() else line for line in lines[start:end]]
    tail = [" " * margin + "except Exception:", " " * margin + "    pass"] if head == "try:" else []
    lines[start:end] = [" " * margin + head, *body, *tail]
    return "\n".join(lines)


def _deepen(rng: random.Random, code: str) -> str:
    """An expression or a block is nested much deeper."""
    depth = rng.choice((3, 10, 40))
    tokens, solid = _pieces(code)
    atoms = [i for i in solid if _NAME.match(tokens[i]) or _NUMBER.match(tokens[i])]
    i = rng.choice(atoms)
    before, after = rng.choice((("(", ")"), ("[", "]"), ("-", ""), ("not ", ""), ("f(", ")"), ("(lambda: ", ")()")))
    tokens[i] = before * depth + tokens[i] + after * depth
    return "".join(tokens)


def _cut(rng: random.Random, code: str) -> str:
    return code[: rng.randrange(len(code))]


CHANGES: tuple[Change, ...] = (
    _delete_token, _duplicate_token, _swap_tokens, _rename, _rename, _replace_constant, _replace_constant,
    _replace_by_expression, _drop_argument, _change_lines, _change_lines, _insert_statement, _insert_statement,
    _wrap_lines, _deepen, _cut,
)  # fmt: skip


def mutant(rng: random.Random, code: str) -> str:
    """The program with one to three changes."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if len(code) > 20:
            code = rng.choice(CHANGES)(rng, code)
    return code
