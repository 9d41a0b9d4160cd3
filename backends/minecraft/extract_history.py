"""Writes what older versions of the game had of the blocks in the table (`make blocks`): FOLDER VERSION OUT.

Run by hand after ``extract``; never by the package. One line for each block that was not always as it is: its name,
then in tabs its eras: the release from which on, and its properties with their values, a dash where it was none yet.
"""

from __future__ import annotations

import gzip
import json
import re
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

from scenelang.backends.minecraft.table import RENAMES

FIRST = "1.13"  # the release that gave blocks their names and properties


def main(folder: Path, version: str, out: Path) -> None:
    """Write the eras of all blocks of ``version`` to ``out``, compressed, the same bytes for the same data."""
    data = folder / "node_modules/minecraft-data/minecraft-data/data"
    releases = _releases(data, version)
    known = {release: _blocks(data / path) for release, path in releases.items()}
    lines = [line for name in known[version] if (line := _line(name, known))]
    out.write_bytes(gzip.compress(("\n".join(lines) + "\n").encode("ascii"), 9, mtime=0))
    print(f"{out}: {len(lines)} blocks, {out.stat().st_size:,} bytes")


def _releases(data: Path, version: str) -> dict[str, str]:
    """The folder of each release from FIRST to ``version`` whose blocks are known, oldest first."""
    paths = json.loads((data / "dataPaths.json").read_text("utf-8"))["pc"]
    rows = json.loads((data / "pc/common/protocolVersions.json").read_text("utf-8"))
    order = [row["minecraftVersion"] for row in rows]  # newest first
    chosen = order[order.index(version) : order.index(FIRST) + 1]
    released = [v for v in reversed(chosen) if re.fullmatch(r"[\d.]+", v) and "blocks" in paths.get(v, {})]
    return {v: paths[v]["blocks"] for v in released}


def _blocks(folder: Path) -> dict[str, str]:
    """The properties of every block, as ``name=value|value name=...``."""
    blocks: list[dict[str, Any]] = json.loads((folder / "blocks.json").read_text("utf-8"))
    return {block["name"]: _properties(block["states"]) for block in blocks}


def _properties(states: list[dict[str, Any]]) -> str:
    values = {state["name"]: state.get("values") or _counted(state) for state in states}
    return " ".join(f"{name}={'|'.join(map(str, values[name]))}" for name in sorted(values))


def _counted(state: dict[str, Any]) -> list[str]:
    """The values that the data leaves out: numbers, or a yes and no."""
    return [str(n) for n in range(state["num_values"])] if state["type"] == "int" else ["true", "false"]


def _line(name: str, known: dict[str, dict[str, str]]) -> str:
    """The eras of a block; empty where it has one."""
    former = [old for old, new in RENAMES if new == name]
    seen: list[tuple[str, str]] = []
    for release, blocks in known.items():
        there = next((each for each in (name, *former) if each in blocks), None)
        seen.append((release, blocks[there] if there is not None else "-"))
    changes = [seen[0], *(b for a, b in pairwise(seen) if a[1] != b[1])]
    return "\t".join([name, *(f"{release} {era}".rstrip() for release, era in changes)]) if len(changes) > 1 else ""


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
