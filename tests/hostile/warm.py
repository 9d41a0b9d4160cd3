"""What commands import while they work, loaded ahead; Mitsuba, which `maps` loads, has threads that copies would lack."""

from __future__ import annotations

import contextlib
import io
import tempfile
from importlib import import_module
from pathlib import Path


def load() -> None:
    """Run the commands once on a small program, without a monitor."""
    from scenelang.cli.main import main

    with (
        tempfile.TemporaryDirectory() as name,
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        program = Path(name) / "a.scene"
        program.write_text('(bind "a" (lambda () (call "cube")))\n')
        (Path(name) / "a.py").write_text("def f():\n    return 1\n")
        for words in (["run"], ["check"], ["count"], ["bounds"], ["flatten"]):
            main([*words, str(program)])
        main(["transpile", str(Path(name) / "a.py")])
        main(["render", str(program), "-o", str(Path(name) / "a.png"), "--size", "8x8"])
        main(["export", str(program), "-o", str(Path(name) / "a.glb")])
    for module in ("repl.commands", "repl.loop", "repl.plain", "cli.programs"):
        import_module(f"scenelang.{module}")
