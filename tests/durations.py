"""Which tests are long: ``python tests/durations.py RESULTS.xml`` writes ``long_tests.txt`` from a run with ``--junitxml``.

A test is long if its cases take 0.15 s on average. ``make test`` runs a fifth of their cases, others on each day, and
all others: 6 minutes instead of 17 on two cores.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path
from xml.etree import ElementTree

TESTS = Path(__file__).parent
LONG_TESTS = TESTS / "long_tests.txt"
ALWAYS = (  # what no later change may give back unseen, or what is drawn by date already: files, or single tests
    "tests/test_domains.py",
    "tests/test_packaging.py::test_the_wheel_has_every_module_and_data_file_and_no_other",
    "tests/test_start_up.py",
    "tests/test_structure.py",
)
SECONDS = 0.15  # 900 of 3,700 tests take longer, and four fifths of the time of all


def long_tests(results: Path) -> list[str]:
    """Return the long tests of a run, as ``tests/fuzz/test_rewrites.py::test_it``, sorted."""
    seconds: dict[str, list[float]] = defaultdict(list)
    for case in ElementTree.parse(results).iter("testcase"):
        name = f"{case.attrib['classname'].replace('.', '/')}.py::{case.attrib['name'].partition('[')[0]}"
        seconds[name].append(float(case.attrib["time"]))
    slow = (name for name, taken in seconds.items() if sum(taken) >= SECONDS * len(taken))
    return sorted(name for name in slow if not {name, name.partition("::")[0]} & set(ALWAYS))


if __name__ == "__main__":
    LONG_TESTS.write_text("\n".join(long_tests(Path(sys.argv[1]))) + "\n", "utf-8")
