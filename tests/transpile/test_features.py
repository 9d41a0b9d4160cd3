"""Features of current Python, one by one, give the geometry that CPython gives."""

from __future__ import annotations

import sys

import pytest

from scenelang.grammar.datum import Source
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.features import features
from transpile.reference_model import flatten

SESSION = Session()
FEATURES = features()
NEWER = {"type parameters"} if sys.version_info < (3, 12) else set[str]()  # which this Python does not know


@pytest.mark.parametrize("name", [name for name in FEATURES if name not in NEWER])
@pytest.mark.sampled(5)
def test_the_geometry_is_that_of_cpython(name: str) -> None:
    code = FEATURES[name]
    translation = SESSION.transpile(Source("feature.py", code))
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("feature.scene", translation.text))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
    assert first_difference(flattened(evaluated.scene), flatten(code)) is None


@pytest.mark.parametrize("name", sorted(NEWER))
def test_newer_syntax_is_read(name: str) -> None:
    assert SESSION.evaluate(Source("feature.py", FEATURES[name])).scene is not None
