"""What is asked for: a scene of some kind, in some notation, anew or as an edit."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from scenelang.backends.language_models.conversation import Picture


class Kind(Enum):
    """What a scene is: still, a film, or made of Minecraft's blocks."""

    STILL = "3d"
    FILM = "4d"
    BLOCKS = "minecraft"


class Notation(Enum):
    """What the model writes: Python against the helper API, the language, or a list of primitives (the paper's
    ablation "No-P")."""

    PYTHON = "python"
    LANGUAGE = "language"
    LIST = "list"


class Ablation(Enum):
    """What is taken from the model (the paper, appendix "Ablations"): the program, words, or both."""

    NONE = ""
    P = "P"
    W = "W"
    PW = "PW"

    @property
    def takes_program(self) -> bool:
        return self in (Ablation.P, Ablation.PW)

    @property
    def takes_words(self) -> bool:
        return self in (Ablation.W, Ablation.PW)


@dataclass(frozen=True, slots=True)
class Task:
    """``text`` describes the scene, or says how ``program`` is to be changed. ``seed`` makes the random names that
    stand for words."""

    text: str
    kind: Kind = Kind.STILL
    notation: Notation = Notation.PYTHON
    ablation: Ablation = Ablation.NONE
    pictures: tuple[Picture, ...] = ()
    program: str | None = None
    seed: int = 0

    @property
    def is_edit(self) -> bool:
        return self.program is not None
