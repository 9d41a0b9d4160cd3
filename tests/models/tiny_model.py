"""A tiny language model of bytes, trained on the example programs, which can decode under a GBNF grammar."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable
from pathlib import Path
from random import Random

from grammar_export.decoders import END, matcher
from llguidance.gbnf_to_lark import gbnf_to_lark

EXAMPLES = Path(__file__).parents[2] / "examples"
ORDER = 7  # bytes that the next one depends on
CLOSING = (END, *b')]"')


class TinyModel:
    """Counts of the byte that follows each of up to ``ORDER`` bytes; the longest known context decides."""

    def __init__(self, texts: Iterable[str]) -> None:
        self._following: dict[bytes, Counter[int]] = defaultdict(Counter)
        for text in texts:
            data = [*text.encode(), END]
            for at, value in enumerate(data):
                for length in range(min(ORDER, at) + 1):
                    self._following[bytes(data[at - length : at])][value] += 1

    def answer(self, grammar: str | None, seed: int, most: int = 400) -> str:
        """Draw a text; beyond ``most`` bytes under a grammar, what closes is preferred."""
        run = matcher(gbnf_to_lark(grammar)) if grammar is not None else None
        draw, data = Random(seed), bytearray()
        while len(data) < 4 * most:
            allowed = None
            if run is not None:
                mask = run.compute_logit_bias()
                allowed = {value for value in range(END + 1) if mask[value]} - {*b";#"}  # comments may have no end
            value = self._next(bytes(data[-ORDER:]), allowed, draw, len(data) > most, data.count(b'"') % 2 == 1)
            if value == END or (run is None and len(data) >= most):
                break
            data.append(value)
            if run is not None:
                assert run.consume_token(value)
        return data.decode("utf-8", "replace")

    def _next(self, context: bytes, allowed: set[int] | None, draw: Random, closes: bool, is_in_string: bool) -> int:
        if closes and allowed is not None:
            preferred = (*b'"',) if is_in_string else CLOSING
            for value in preferred:
                if value in allowed:
                    return value
        for start in range(len(context) + 1):
            counts = self._following.get(context[start:], Counter())
            found = {v: n for v, n in counts.items() if allowed is None or v in allowed}
            if found:
                return draw.choices(list(found), list(found.values()))[0]
        assert allowed
        return draw.choice(sorted(allowed))


def trained() -> TinyModel:
    texts = (path.read_text("utf-8") for path in sorted(EXAMPLES.glob("*.scene")))
    return TinyModel(re.sub(r"^;.*\n", "", text, flags=re.MULTILINE).strip() + "\n" for text in texts)
