"""Typing mistakes in sound programs, by a generator: letters swapped or left out, brackets and quotes lost."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from random import Random

_TOKEN = re.compile(r';[^\n]*|"[^"\n]*"|[^\s()\[\]";]+|[()\[\]]')
_NAMES = ("translate", "rotate", "transform", "union", "define", "call", "bind", "lambda", "color", "iota", "scale")


def _misspelled(pick: Random, text: str) -> str:
    at = pick.randrange(1, len(text) - 1)
    return text[:at] + text[at + 1] + text[at] + text[at + 2 :] if pick.random() < 0.5 else text[:at] + text[at + 1 :]


def _in_place(pick: Random, token: str) -> str:
    """A token with its text misspelled, inside its quotes or behind its colon."""
    if token.startswith('"'):
        return f'"{_misspelled(pick, token[1:-1])}"'
    return f":{_misspelled(pick, token[1:])}" if token.startswith(":") else _misspelled(pick, token)


# Which tokens a kind of mistake is about, and what becomes of one.
KINDS: dict[str, tuple[Callable[[str], bool], Callable[[Random, str], str]]] = {
    "name": (lambda t: t in _NAMES, _in_place),
    "keyword": (lambda t: re.fullmatch(r":[a-z]{5,}", t) is not None, _in_place),
    "word": (lambda t: re.fullmatch(r'"[a-z]{5,}"', t) is not None, _in_place),
    "closing bracket": (lambda t: t == ")", lambda pick, t: ""),
    "opening bracket": (lambda t: t == "(", lambda pick, t: ""),
    "one bracket more": (lambda t: t == ")", lambda pick, t: "))"),
    "quote": (lambda t: t.startswith('"'), lambda pick, t: t[:-1]),
}


def typos(text: str, seed: int, count: int) -> Iterator[tuple[str, str, str]]:
    """``count`` programs, each with one mistake: its kind, what was changed, the program."""
    pick = Random(seed)
    tokens = list(_TOKEN.finditer(text))
    while count:
        kind = pick.choice(list(KINDS))
        fits, change = KINDS[kind]
        chosen = [token for token in tokens if fits(token[0])]
        if not chosen:
            continue
        token = pick.choice(chosen)
        new = change(pick, token[0])
        if new != token[0]:
            yield kind, f"{token[0]} -> {new}", text[: token.start()] + new + text[token.end() :]
            count -= 1
