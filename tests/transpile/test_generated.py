"""Random programs give the same primitives in CPython, with a model of the helper library, and translated."""

from __future__ import annotations

import json
import os

from hypothesis import HealthCheck, given, settings

from scenelang.grammar.printer import print_datum
from scenelang.grammar.source import Source
from scenelang.session import Session
from transpile.cases import first_difference, flattened, printed, told
from transpile.generator import programs
from transpile.reference_model import flatten

EXAMPLES = int(os.environ.get("SCENELANG_EXAMPLES", "250"))  # by hand: 2,000
SESSION = Session()


@settings(max_examples=EXAMPLES, deadline=None, derandomize=EXAMPLES <= 250, database=None,
          suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])  # fmt: skip
@given(programs())
def test_the_same_primitives(code: str) -> None:
    translation = SESSION.transpile(Source("drawn.py", code))
    assert translation.ok, f"{told(translation.diagnostics)}\n{code}"
    assert printed(translation.text) == [print_datum(form) for form in translation.forms]
    result = SESSION.evaluate(Source("drawn.scene", translation.text))
    assert result.scene is not None, f"{told(result.diagnostics)}\n{code}\n{translation.text}"
    golden = json.loads(json.dumps(flatten(code)))
    difference = first_difference(flattened(result.scene), golden)
    assert difference is None, f"{difference}\n{code}\n{translation.text}"
