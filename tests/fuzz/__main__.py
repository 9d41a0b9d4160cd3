"""``python -m fuzz [target] [count] [folder]`` in the folder of the tests: fuzz one target, or all, until ``count`` inputs
were tried; a later run with a larger count goes on from there."""

from __future__ import annotations

import sys
from pathlib import Path

from fuzz.running import run
from fuzz.targets import ALL


def main(name: str = "", count: str = "20000", folder: str = "../.fuzz") -> int:
    chosen = [target for target in ALL if name in ("", "all") or target.name in name.split(",")]
    if not chosen:
        print(f"there is no target {name}; there are {', '.join(target.name for target in ALL)}")
        return 2
    failed = False
    for target in chosen:
        told = run(target, int(count), Path(folder))
        failed = failed or bool(told["findings"])
        print(
            f"{target.name}: {told['tried']:,} inputs in {told['seconds']:.0f} s, {len(told['findings'])} kinds of findings",
            flush=True,
        )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
