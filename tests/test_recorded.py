"""Numbers that tasks state, in the recorded responses (`make eval-recorded`)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "benchmarks" / "recorded.py"


def test_the_recorded_responses_have_what_their_tasks_state() -> None:
    done = subprocess.run([sys.executable, str(SCRIPT)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "17 of 17 as stated" in done.stdout
    assert "10 red discs and 9 yellow discs" in done.stdout


def test_a_number_that_differs_is_told(tmp_path: Path) -> None:
    code = (
        f"import sys; sys.path.insert(0, {str(SCRIPT.parent)!r}); import recorded\n"
        "recorded.STATED = (recorded.Stated('t02-moai', 'moai', 8, (recorded.Counted('moai'),)),)\n"
        "sys.exit(recorded.main())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    assert done.stdout.rstrip().endswith("0 of 1 as stated")
    assert " NO" in done.stdout
