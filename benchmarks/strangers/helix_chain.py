# A chain of beads and links, each placed by one more step of the same turn and shift: a double helix; 2026-11-29.
from __future__ import annotations

from math import pi

from things import AT_HOME, Pose, Thing, count, product, translate, turn_x, turn_y

STEP = product(product(translate(0, 0.05, 0), turn_y(0.2)), turn_x(0.01))


def strand(beads: int, pose: Pose, paint: tuple[float, float, float]) -> list[tuple[Thing, Pose]]:
    out = []
    for i in range(beads):
        if i % 5 == 0:
            bead = Thing("cube", scale=0.2, color=paint)
        else:
            bead = Thing("sphere", radius=0.08 + 0.02 * (i % 3), color=paint)
        out.append((bead, product(pose, translate(1, 0, 0))))
        pose = product(pose, STEP)
    return out


def run(beads: int = 10000) -> int:
    first = strand(beads, AT_HOME, (0.8, 0.2, 0.2))
    return count(Thing("double helix", first + strand(beads, turn_y(pi), (0.2, 0.3, 0.8))))
