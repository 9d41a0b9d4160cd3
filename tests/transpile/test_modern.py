"""Modern Python: classes, enumerations, `match`, generators, decorators, numpy, give the geometry that CPython gives."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import pytest
from sampling import one_in

from scenelang.grammar.datum import Source
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.reference_model import flatten

PROGRAMS = one_in(3, sorted(Path(__file__).with_name("modern").glob("*.py")))  # all of them in `make test-nightly`
REFUSED = {"random-06-flower-meadow-species": "E802"}  # it asks a class for its subclasses
SESSION = Session()


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
@pytest.mark.sampled(8)
def test_the_geometry_of_cpython(path: Path) -> None:
    code = path.read_text("utf-8")
    translation = SESSION.transpile(Source(str(path), code))
    if path.stem in REFUSED:
        assert REFUSED[path.stem] in told(translation.diagnostics)
        return
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("modern.scene", translation.text))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
    with contextlib.redirect_stdout(io.StringIO()):
        expected = flatten(code)
    assert first_difference(flattened(evaluated.scene), expected) is None


def test_all_commands_evaluate_what_the_checker_finds_wrong() -> None:
    path = Path(__file__).with_name("modern") / "dataclass-02-mountain-refuges.py"
    evaluated = SESSION.evaluate(Source(str(path), path.read_text("utf-8")))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
