"""Measure the programs beside this file with OpenSCAD itself: `python tests/openscad/measure.py` writes volumes.json.

Needs the command `openscad`; the tests only read the table. Programs that it already has are measured again only if named.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import trimesh

HERE = Path(__file__).parent
TABLE = HERE / "volumes.json"


def volume_of(program: Path) -> float:
    """The volume of what OpenSCAD makes of a program."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "made.off"
        command = ["openscad", "--export-format", "off", "-o", str(made), str(program)]
        subprocess.run(command, check=True, timeout=1800, capture_output=True)
        mesh = trimesh.load(made, process=True)
    return abs(float(mesh.volume))


def main() -> None:
    known = json.loads(TABLE.read_text("utf-8")) if TABLE.exists() else {}
    for program in sorted((HERE / "programs").glob("*.scad")):
        if program.stem not in known or program.stem in sys.argv[1:]:
            known[program.stem] = round(volume_of(program), 6)
            print(program.stem, known[program.stem], flush=True)
            TABLE.write_text(json.dumps(dict(sorted(known.items())), indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
