"""What the reader of meshes logs of a broken file is nothing that users see."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

BROKEN = (
    b"solid a\nfacet normal 0 0 x\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
    * 2
)
SCENE = '(bind "a" (lambda () (call "mesh" :file "a.stl")))\n'


def test_a_broken_mesh_shows_no_traceback_of_its_reader(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(BROKEN)
    (tmp_path / "a.scene").write_text(SCENE)
    command = [sys.executable, "-P", "-m", "scenelang", "bounds", "a.scene"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    assert "trimesh" not in done.stderr
