"""Budget of a search that evaluates edited programs, in counted work.

A deadline would make the result depend on the machine and its load. Counted work gives the same result everywhere, and
tells about how long a search takes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenelang.session.session import Evaluated

# Microseconds on one core of the test machine, measured over the examples and the rooms of `benchmarks`: a check takes
# 2 to 5 for each character of the program; the evaluator 1 to 2 for each step. The geometry checks take 30 to 290 ms
# for rooms of 20 to 90 primitives, and 80 to 800 microseconds for each primitive of the larger examples.
_CHARACTER = 4
_STEP = 2
_BOX = 2  # the corners of one primitive
_EXAMINATION = 50_000
_EXAMINED = 300  # one primitive
_UNIT = 1_000_000


class Effort:
    """Work that a search may still do.

    Parameters
    ----------
    units
        One unit takes about a second on one core.

    Examples
    --------
    >>> effort = Effort(0.1)
    >>> effort.spend_examination(200)
    >>> effort.is_spent
    True
    """

    def __init__(self, units: float) -> None:
        self._left = units * _UNIT

    @property
    def is_spent(self) -> bool:
        return self._left <= 0

    def spend_evaluation(self, text: str, result: Evaluated) -> None:
        """Count the check and the evaluation of a program."""
        self._left -= _CHARACTER * len(text) + _STEP * result.steps

    def spend_boxes(self, primitives: int) -> None:
        """Count the boxes of some primitives."""
        self._left -= _BOX * primitives

    def spend_examination(self, primitives: int) -> None:
        """Count the geometry checks and the declarations of a scene."""
        self._left -= _EXAMINATION + _EXAMINED * primitives
