"""The builders of scenes that the tests of other backends use."""

from __future__ import annotations

import pytest
from backends.conftest import Make


@pytest.fixture(scope="session")
def make() -> Make:
    return Make()
