"""Random programs in current Python give the geometry that CPython gives, or are refused; few are."""

from __future__ import annotations

import contextlib
import io
import os

from searching import many

from scenelang.grammar.datum import Source
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.modern_generator import modern_program
from transpile.reference_model import flatten

PROGRAMS = int(os.environ.get("SCENELANG_EXAMPLES", many(80)))  # by hand: 5,000
START = int(os.environ.get("SCENELANG_SEED", "0"))
SESSION = Session()


def test_the_geometry_of_cpython() -> None:
    refused = 0
    for seed in range(START, START + PROGRAMS):
        code = modern_program(seed)
        translation = SESSION.transpile(Source("drawn.py", code))
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                expected = flatten(code)
        except Exception:
            assert not translation.ok or SESSION.evaluate(Source("drawn.scene", translation.text)).scene is None, code
            continue
        if not translation.ok:
            refused += 1
            assert {d.name for d in translation.diagnostics if d.is_error} != {"python-exception"}, code
            continue
        result = SESSION.evaluate(Source("drawn.scene", translation.text))
        assert result.scene is not None, f"seed {seed}: {told(result.diagnostics)}"
        difference = first_difference(flattened(result.scene), expected)
        assert difference is None, f"seed {seed}: {difference}"
    assert refused <= PROGRAMS // 50 + 1
