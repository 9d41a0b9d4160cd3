"""The programs of ``programs`` in Hy and in Guile, timed where these are installed."""

from __future__ import annotations

import shutil
import subprocess
import time
from importlib.util import find_spec

HY = {
    "fib 22": "(defn fib [n] (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2))))) (fib 22)",
    "loop of 1e6 turns": "(defn turns [] (setv s 0) (for [i (range 1000000)] (setv s (+ s i))) s) (turns)",
    "tak 14 8 2": "(defn tak [x y z] (if (< y x) (tak (tak (- x 1) y z) (tak (- y 1) z x) (tak (- z 1) x y)) z))"
    " (tak 14 8 2)",
}
GUILE = {
    "fib 22": "(define (fib n) (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2))))) (time (fib 22))",
    "loop of 1e6 turns": "(time (let loop ((i 0) (s 0)) (if (= i 1000000) s (loop (+ i 1) (+ s i)))))",
    "tak 14 8 2": "(define (tak x y z) (if (< y x) (tak (tak (- x 1) y z) (tak (- y 1) z x) (tak (- z 1) x y)) z))"
    " (time (tak 14 8 2))",
}
_TIME = (
    "(define-syntax time (syntax-rules () ((_ e) (let ((t (get-internal-real-time))) e "
    "(display (/ (- (get-internal-real-time) t) internal-time-units-per-second 1.0))))))\n"
)


def seconds() -> dict[str, dict[str, float]]:
    """Return the seconds of each program, by the name of the Lisp and of the program; empty for one that is missing."""
    return {"Hy": _of_hy() if find_spec("hy") else {}, "Guile": _of_guile() if shutil.which("guile") else {}}


def _of_hy() -> dict[str, float]:
    import hy

    def once(text: str) -> float:
        started = time.perf_counter()
        hy.eval(hy.read_many(text), {})
        return time.perf_counter() - started

    return {name: min(once(text) for _ in range(3)) for name, text in HY.items()}


def _of_guile() -> dict[str, float]:
    def once(text: str) -> float:
        return float(subprocess.run(["guile", "-c", _TIME + text], check=True, capture_output=True, text=True).stdout)

    return {name: min(once(text) for _ in range(3)) for name, text in GUILE.items()}
