# A tree whose every branch draws its lean, its length and whether it forks (after Weber and Penn 1995); 2026-11-29.
from __future__ import annotations

from math import tau

import numpy as np
from things import AT_HOME, Pose, Thing, count, product, translate, turn_y, turn_z


class Tree:
    def __init__(self) -> None:
        self.source = np.random.RandomState(0)

    def draw(self, low: float = 0.0, high: float = 1.0) -> float:
        return self.source.uniform(low, high)

    def twig(self) -> Thing:
        leaf = Thing("sphere", radius=0.05, color=(self.draw(0.1, 0.3), self.draw(0.5, 0.8), 0.1))
        return Thing("twig", [(leaf, translate(0, 0.05, 0))])

    def child(self, level: int, length: float, tip: Pose) -> tuple[Thing, Pose]:
        branch = self.branch(level - 1, length * self.draw(0.7, 0.9))
        return branch, product(product(tip, turn_y(self.draw(0, tau))), turn_z(self.draw(-0.7, 0.7)))

    def branch(self, level: int, length: float) -> Thing:
        tip = translate(0, length, 0)
        limb = Thing("cylinder", radius=0.08 * length, p1=(0, length, 0), color=(0.4, 0.3, 0.2))
        if level == 0:
            parts = [(self.twig(), tip)]
        elif self.draw() < 0.85:
            parts = [self.child(level, length, tip), self.child(level, length, tip)]
        else:
            parts = [self.child(level, length, tip)]
        return Thing("branch", [(limb, AT_HOME), *parts], level=level, length=length)


def run(levels: int = 13) -> int:
    return count(Tree().branch(levels, 1.0))
