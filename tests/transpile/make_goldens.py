#!/usr/bin/env python3
"""Write `golden_programs/*.json.gz` from `programs/*.txt`: `make_goldens.py [NAME ..]`; without names, all."""

from __future__ import annotations

import gzip
import json
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from transpile.reference_model import extract, flatten

FEWEST, MOST = 4, 20_000  # primitives of a scene


def make(path: Path) -> str:
    """Write one golden file; a line of what is in it, or of why there is none."""
    started = time.perf_counter()
    try:
        scene = flatten(extract(path.read_text()))
    except Exception as error:
        return f"FAIL {path.stem}: {type(error).__name__}: {error}"
    counts = [len(frame["primitives"]) for frame in scene["frames"]]
    if not counts or max(counts) < FEWEST or sum(counts) > MOST:
        return f"FAIL {path.stem}: {sum(counts)} primitives in {len(counts)} frames"
    data = json.dumps(scene, separators=(",", ":")).encode()
    (HERE / "golden_programs" / f"{path.stem}.json.gz").write_bytes(gzip.compress(data, mtime=0))
    seconds = time.perf_counter() - started
    return f"{path.stem}: {scene['kind']} {scene['root']} {len(counts)}x{counts[0]} {seconds:.1f} s"


def main() -> int:
    names = set(sys.argv[1:])
    lines = [make(path) for path in sorted((HERE / "programs").glob("*.txt")) if not names or path.stem in names]
    print("\n".join(lines))
    return int(any(line.startswith("FAIL") for line in lines))


if __name__ == "__main__":
    sys.exit(main())
