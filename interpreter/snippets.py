"""The shape of a form as a snippet that editors fill in: `(if ${1:test} ${2:then})`."""

from __future__ import annotations

import re

from scenelang.interpreter.forms import Form

_KEPT = frozenset({"else", "=>", "syntax-rules", "_"})  # words of a shape that stand in programs as they are
_RULES = "(syntax-rules () ((_ pattern) template))"
_TOKEN = re.compile(r'"[^"]*"|[()]|[^\s()"]+|\s+')


def snippet(form: Form) -> str:
    """The first shape of ``form`` without what may be left out, its parts numbered, the last place `$0`."""
    usage = form.usage.split(" or ")[0].replace("(syntax-rules ...)", _RULES)
    usage = re.sub(r"\s*\[[^\]]*\]", "", usage)  # optional parts
    usage = re.sub(r"\s+:\w+ test", "", usage)
    usage = re.sub(r" \([^()]*\) \.\.\.(?= \()", "", usage).replace(" ...", "")
    number = 0
    pieces = []
    for position, token in enumerate(_TOKEN.findall(usage)):
        name = token.strip('"')
        if position == 1 or token in ("(", ")") or token.isspace() or name in _KEPT or name.startswith(":"):
            pieces.append(token)
            continue
        number += 1
        place = f"${{{number}:{name}}}"
        pieces.append(f'"{place}"' if token.startswith('"') else place)
    return "".join(pieces) + "$0"
