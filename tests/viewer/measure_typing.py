"""Measure the studio: milliseconds from a key to the frame that shows it, over 50 edits of a program.

    python tests/viewer/measure_typing.py [FILE] [EDITS]

Each edit types a digit of a number and waits until the picture is drawn. Printed are the median, the quartiles and the
slowest until it is drawn, and until the page has its evaluation. The browser draws without a graphics processor, so that
the first say much about the machine.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from playwright.sync_api import sync_playwright
from support import chromium_path
from viewer.conftest import FLAGS, open_session

from scenelang.sandbox.worker import Worker
from scenelang.viewer.program_tools import tools
from scenelang.viewer.server import ViewServer
from scenelang.viewer.workspace import Workspace, evaluator

PROGRAM = """(bind "row" (lambda () (union-loop 20 (lambda (i)
  (transform (call "sphere" :radius .4 :color (color "tomato")) (translate [i 0 0]))))))
"""

# Types a key in the page and resolves to the milliseconds until the frame of the next version is drawn, and until it
# has been evaluated.
EDIT = """([from, to, insert]) => new Promise((resolve) => {
  const { body } = document;
  const { version } = body.dataset;
  const started = performance.now();
  const look = () => {
    if (body.dataset.version === version || scenelangPage.isEvaluating || scenelangPage.pending) requestAnimationFrame(look);
    else resolve([performance.now() - started, Number(body.dataset.latency)]);
  };
  scenelangPage.editor.view.dispatch({ changes: { from, to, insert }, userEvent: 'input.type' });
  requestAnimationFrame(look);
})"""


def measured(file: Path, edits: int) -> list[list[float]]:
    """Return the milliseconds of each edit until it is drawn, and until it is evaluated; the digit that changes is the first one after a point."""
    worker = Worker(evaluator(open_session, 2_000_000), keeps=True)
    workspace = Workspace([str(file)], worker.ask, tools(open_session), lambda what: worker.interrupt())
    server = ViewServer(workspace, edits=True)
    threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
    at = file.read_text().index(".") + 1
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium_path(), args=FLAGS)
        page: Any = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(server.address)
        page.wait_for_selector("body[data-refined=yes]", state="attached")
        times = []
        for number in range(edits):
            times.append(page.evaluate(EDIT, [at, at + 1, str(3 + number % 5)]))
            page.wait_for_timeout(100)
        browser.close()
    server.shutdown()
    server.server_close()
    worker.close()
    return times


def main() -> None:
    """Print the figures of the program that is given, or of a row of balls."""
    edits = int(sys.argv[2]) if len(sys.argv) > 2 else 50
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "row.scene")
        file.write_text(PROGRAM if len(sys.argv) < 2 else Path(sys.argv[1]).read_text("utf-8"), "utf-8")
        times = measured(file, edits)
    for what, values in zip(("drawn", "evaluated"), zip(*times)):
        low, median, high = statistics.quantiles(values, n=4)
        print(f"{what}: median {median:.0f} ms, quartiles {low:.0f} and {high:.0f} ms, slowest {max(values):.0f} ms")


if __name__ == "__main__":
    main()
