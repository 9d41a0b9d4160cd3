"""Mitsuba's variants, ways to compute: ``scalar`` always works, ``llvm`` compiles for the CPU, ``cuda`` for a GPU.

A compiler of the wrong version ends the whole process, so a variant is tried in a process of its own before it is used.
"""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from typing import Any

from scenelang.backends.base import need
from scenelang.grammar.diagnostics import SceneError

NAMES = {"scalar": "scalar_rgb", "llvm": "llvm_ad_rgb", "cuda": "cuda_ad_rgb"}
CHOICES = ("auto", *NAMES)
MANY_SAMPLES = 64 * 1024 * 1024  # of a whole picture, from which compiling pays
_PATIENCE = 120.0  # seconds

_TRIAL = """
import sys, mitsuba as mi
mi.set_variant(sys.argv[1])
mi.set_log_level(mi.LogLevel.Error)
film = {"type": "hdrfilm", "width": 4, "height": 4}
scene = mi.load_dict({"type": "scene", "integrator": {"type": "path"}, "light": {"type": "constant"},
    "ball": {"type": "sphere", "bsdf": {"type": "principled"}},
    "sensor": {"type": "perspective", "film": film,
               "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0])}})
print(float(sum(mi.render(scene, spp=2).numpy().ravel())) > 0)
"""


def use(choice: str, samples: int, has_instances: bool) -> Any:
    """The module mitsuba under the variant that ``choice`` means for a picture of so many samples in all.

    ``auto`` takes llvm for many samples of scenes without instances (its compile time explodes with these), where it
    works, else scalar. Raises SceneError("backend") where Mitsuba, or the variant that was asked for, does not work.
    """
    mi = need("mitsuba", "mitsuba mitsuba-oidn")
    chosen = choice
    if choice == "auto":
        chosen = "llvm" if samples >= MANY_SAMPLES and not has_instances and works("llvm") else "scalar"
    elif choice != "scalar" and not works(choice):
        what = "no LLVM that it can use (Debian: libllvm19)" if choice == "llvm" else "no NVIDIA GPU that it can use"
        raise SceneError("backend", f"Mitsuba's variant `{choice}` does not work here: it finds {what}",
                         hint="`--variant scalar` works everywhere")  # fmt: skip
    if mi.variant() != NAMES[chosen]:
        mi.set_variant(NAMES[chosen])
    mi.set_log_level(mi.LogLevel.Error)
    return mi


@cache
def works(name: str) -> bool:
    """Whether a small picture comes out of the variant ``name`` in another process."""
    try:
        # a list of words, no shell: our interpreter or a program by its own name
        done = subprocess.run(trial_command(name), capture_output=True, text=True, timeout=_PATIENCE)  # noqa: S603  # nosec B603
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0 and done.stdout.strip() == "True"


def trial_command(name: str) -> list[str]:
    """The command that prints ``True`` where a small picture comes out of the variant ``name``."""
    return [sys.executable, "-P", "-c", _TRIAL, NAMES[name]]
