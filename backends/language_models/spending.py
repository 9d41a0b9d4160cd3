"""A limit on what requests cost together: money is reserved before a request is sent and settled after it."""

from __future__ import annotations

from threading import Lock

from scenelang.grammar.diagnostics import SceneError

_SLACK = 1e-9  # dollars that sums of floats may be off by


class Spending:
    """Dollars spent and reserved, safe for requests that run side by side."""

    def __init__(self, limit: float, spent: float = 0.0) -> None:
        self.limit = limit
        self._spent = spent
        self._reserved = 0.0
        self._lock = Lock()

    @property
    def spent(self) -> float:
        return self._spent

    def reserve(self, amount: float) -> None:
        """Set ``amount`` dollars aside. Raises SceneError where the limit does not allow it."""
        with self._lock:
            left = self.limit - self._spent - self._reserved
            if amount > left + _SLACK:
                message = f"the next request could cost ${amount:.4f}, and ${max(0.0, left):.4f} is left of --max-cost"
                raise SceneError("model-cost", message, "raise --max-cost, or lower --max-tokens, -n or --critique")
            self._reserved += amount

    def settle(self, reserved: float, cost: float) -> None:
        """A request for which ``reserved`` was set aside has cost ``cost``."""
        with self._lock:
            self._reserved -= reserved
            self._spent += cost
