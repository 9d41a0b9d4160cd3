"""A limit on what requests cost together: money is reserved before a request is sent and settled after it."""

from __future__ import annotations

from threading import Condition

from scenelang.grammar.diagnostics import SceneError

_SLACK = 1e-9  # dollars that sums of floats may be off by


class Spending:
    """Dollars spent and reserved, safe for requests that run side by side."""

    def __init__(self, limit: float, spent: float = 0.0) -> None:
        self.limit = limit
        self._spent = spent
        self._reserved = 0.0
        self._changed = Condition()

    @property
    def spent(self) -> float:
        return self._spent

    def reserve(self, amount: float) -> None:
        """Set ``amount`` dollars aside. Raises SceneError where the limit does not allow it."""
        with self._changed:
            self._reserve(amount)

    def reserve_when_free(self, amount: float) -> None:
        """``reserve``, but wait while others have money set aside, of which they may give back enough."""
        with self._changed:
            while self._reserved > _SLACK and amount > self._left + _SLACK:
                self._changed.wait()
            self._reserve(amount)

    @property
    def _left(self) -> float:
        return self.limit - self._spent - self._reserved

    def _reserve(self, amount: float) -> None:
        if amount > self._left + _SLACK:
            left = max(0.0, self._left)
            message = f"the next request could cost ${amount:.4f}, and ${left:.4f} is left of --max-cost"
            raise SceneError("model-cost", message, "raise --max-cost, or lower --max-tokens, -n or --critique")
        self._reserved += amount

    def settle(self, reserved: float, cost: float) -> None:
        """A request for which ``reserved`` was set aside has cost ``cost``."""
        with self._changed:
            self._reserved = max(0.0, self._reserved - reserved)
            self._spent += cost
            self._changed.notify_all()
