"""What holds for all tests: how long searches look, which cases of a test run every time, and how little the collection
of garbage looks at.

A worker holds twelve thousand tests and large packages. Each full collection of garbage would walk through all of them,
which made programs with many small objects several times slower than they are. It looks more rarely, too.
"""

from __future__ import annotations

import gc

import pytest
import sampling
import searching

searching.register()


_MODULES = 8  # between two collections


class _Settled:
    """Takes what is there when the tests of some modules begin out of the collection of garbage."""

    def __init__(self) -> None:
        self._module: object = None
        self._count = 0

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        module = item.getparent(pytest.Module)
        if module is not self._module:
            self._module = module
            if self._count % _MODULES == 0:
                gc.collect()
                gc.freeze()
            self._count += 1


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    sampling.mark(items)
    sampling.take_turns(items)


def pytest_report_header() -> str:
    return (
        f"long tests: those of day {sampling.DAY} of {sampling.DAYS} (SCENELANG_TEST_DAY={sampling.DAY} repeats them)"
    )


def pytest_configure(config: pytest.Config) -> None:
    gc.set_threshold(20_000, 20, 50)
    config.pluginmanager.register(_Settled())
