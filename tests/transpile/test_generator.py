"""Drawn programs run in the model of the reference implementation and keep to its limits."""

from __future__ import annotations

import math

from hypothesis import HealthCheck, given, settings
from searching import many

from transpile.generator import programs
from transpile.reference_model import flatten


@settings(
    max_examples=many(200), deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
@given(programs())
def test_drawn_programs_run(code: str) -> None:
    scene = flatten(code)
    assert (scene["kind"], scene["root"]) == ("3d", "scene")
    primitives = scene["frames"][0]["primitives"]
    assert 1 <= len(primitives) <= 400
    assert all(math.isfinite(x) for p in primitives for row in p["matrix"] for x in row)
    assert flatten(code) == scene
