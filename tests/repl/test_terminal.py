"""The REPL in a real pseudo-terminal: keys go in, what a terminal would show comes out."""

from __future__ import annotations

import os
import re
import signal
import stat
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from PIL import Image
from support import PATIENCE, rewrite, wait_for_more_work

from scenelang.sandbox.supervision import is_supported

pexpect = pytest.importorskip("pexpect")
PROMPT = "scene> "
ROGUE = str(Path(__file__).parents[1] / "sandbox" / "rogue.py")
UP, LEFT, TAB, CTRL_C, CTRL_D, CTRL_R = "\x1b[A", "\x1b[D", "\t", "\x03", "\x04", "\x12"


def _hear_interrupts() -> None:
    """What runs in the background, as tests may, begins deaf to Ctrl-C, and its children with it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Terminal:
    """One REPL in a terminal of 100 columns."""

    def __init__(
        self, folder: Path, *arguments: str, program: Sequence[str] = ("-m", "scenelang"), **variables: str
    ) -> None:
        environment = {k: v for k, v in os.environ.items() if k not in ("TMUX", "NO_COLOR", "TERM_PROGRAM")}
        environment |= {"XDG_STATE_HOME": str(folder / "state"), "TERM": "xterm-256color", **variables}
        environment["PROMPT_TOOLKIT_NO_CPR"] = "1"
        self.child = pexpect.spawn(
            sys.executable, [*program, "repl", *arguments],
            env=environment, dimensions=(40, 100), timeout=PATIENCE, encoding="utf-8", cwd=str(folder),
            preexec_fn=_hear_interrupts,
        )  # fmt: skip
        self.wait(PROMPT)
        self.rest(0.1)

    def wait(self, pattern: str) -> re.Match[str]:
        self.child.expect(pattern)
        found: re.Match[str] = self.child.match
        return found

    def rest(self, seconds: float = 0.3) -> str:
        """What comes until nothing comes any more, without escape sequences."""
        found = ""
        while True:
            try:
                found += self.child.read_nonblocking(10_000, seconds)
            except pexpect.TIMEOUT:
                return _plain(found)
            except pexpect.EOF:
                return found

    def sees(self, *wanted: str) -> str:
        """What comes until all that is wanted stands there."""
        found = ""
        while not all(text in _plain(found) for text in wanted):
            try:
                found += self.child.read_nonblocking(10_000, PATIENCE)
            except (pexpect.TIMEOUT, pexpect.EOF):
                pytest.fail(_plain(found))
        return _plain(found)

    def type(self, text: str) -> None:
        self.child.send(text)

    def enter(self, text: str, *wanted: str) -> str:
        """Type a line, send it, and read until what is wanted stands there, else until the next prompt does."""
        self.rest(0.05)
        self.child.send(text + "\r")
        return self.sees(*wanted) if wanted else self.rest(0.3)


def _plain(text: str) -> str:
    return re.sub(r"\x1b(\[[0-9;?]*[A-Za-z]|[()][A-Z0-9]|[=>])|\r", "", text)


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Terminal]:
    found = Terminal(tmp_path, "--max-steps", "100G")
    yield found
    found.child.close(force=True)


@pytest.mark.slow
def test_an_unfinished_form_goes_on_indented(terminal: Terminal) -> None:
    terminal.type("(define (f x)\r")
    terminal.type("(+ x\r")
    terminal.type("100))\r")
    terminal.rest()
    terminal.enter("(f 7)", "107")
    terminal.enter(",source f", "(define (f x)\n  (+ x\n     100))")


@pytest.mark.slow
def test_pasted_lines_are_one_input(terminal: Terminal) -> None:
    terminal.type("\x1b[200~(define (f x)\n  (* x 2))\n(f 21)\x1b[201~")
    terminal.enter("", "42")


@pytest.mark.slow
def test_completion_of_names_words_attributes_and_commands(terminal: Terminal) -> None:
    terminal.enter('(bind "chess-board" (lambda ((:squares 8)) (call "cube" :scale squares)))')
    terminal.type('(call "chess' + TAB)
    terminal.sees("chess-board")
    terminal.rest(0.1)
    terminal.type('" :sq' + TAB)
    terminal.sees(":squares")
    terminal.rest(0.1)
    terminal.enter(" 3)", "chess-board  :squares 3", "cube  :scale 3")
    terminal.rest(0.1)
    terminal.type("(compute-shape-si" + TAB)
    terminal.sees("compute-shape-sizes")
    terminal.type(CTRL_C)
    terminal.rest(0.2)
    terminal.type(",rel" + TAB)
    terminal.sees(",reload")
    terminal.type(CTRL_C)
    terminal.rest(0.2)
    terminal.type("(compute-shape-" + TAB)
    terminal.sees("compute-shape-max", "bounding box")


def test_an_error_keeps_the_session(terminal: Terminal) -> None:
    terminal.enter("(define k 5)")
    terminal.enter("(car k)", "error[E", "<repl 2>:1:1", "^")
    terminal.enter("k", "5")


def test_ctrl_c_stops_an_evaluation_and_keeps_the_session(terminal: Terminal) -> None:
    terminal.enter("(define k 5) (+ k 37)", "42")
    terminal.type("(begin (set! k 6) (while #t 1))\r")
    wait_for_more_work(terminal.child.pid, 1.0)
    terminal.child.sendintr()
    terminal.wait("interrupted")
    terminal.wait(PROMPT)
    terminal.enter("k", "5")


@pytest.mark.slow
def test_ctrl_c_stops_a_render_and_leaves_no_file(terminal: Terminal, tmp_path: Path) -> None:
    terminal.enter(
        '(bind "dots" (lambda () (for/union ((i (iota 20000))) (transform (call "sphere") (translate [i 0 0])))))'
    )
    terminal.enter("(+ 20 22)", "42")
    terminal.type(",render -o slow.png\r")
    wait_for_more_work(terminal.child.pid, 0.5)
    terminal.child.sendintr()
    terminal.wait("interrupted")
    terminal.wait(PROMPT)
    assert [path.name for path in tmp_path.iterdir()] == ["state"]
    terminal.enter("(+ 40 2)", "42")


@pytest.mark.slow
def test_ctrl_c_clears_the_line_and_ctrl_d_leaves(terminal: Terminal) -> None:
    terminal.type("(nonsense" + CTRL_C)
    terminal.rest()
    shown = terminal.enter("(+ 40 2)")
    assert "42" in shown
    assert "error" not in shown
    terminal.type(CTRL_D)
    terminal.wait(pexpect.EOF)
    terminal.child.close()
    assert terminal.child.exitstatus == 0


def test_a_wrong_closing_bracket_is_marked(terminal: Terminal) -> None:
    terminal.child.send("(list 1]")
    terminal.child.expect(r"41m\]")  # red behind it
    terminal.type(CTRL_C)


@pytest.mark.slow
def test_render_makes_a_picture(terminal: Terminal) -> None:
    terminal.type(',render (call "sphere" :color [1 0.2 0.1])\r')
    path = Path(terminal.wait(r"wrote (\S+\.png)")[1])
    image = Image.open(path).convert("RGB")
    assert image.size == (640, 480)
    red, green, _ = image.getpixel((320, 230))
    assert red > 1.5 * green


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variables", "sequence"),
    [
        ({"TERM_PROGRAM": "iTerm.app"}, r"\x1b\]1337;File=inline=1;"),
        ({"KITTY_WINDOW_ID": "1"}, r"\x1b_Ga=T,f=100,"),
        ({"TERM": "foot"}, r"\x1bPq"),
    ],
)
def test_pictures_show_where_the_terminal_can(tmp_path: Path, variables: dict[str, str], sequence: str) -> None:
    terminal = Terminal(tmp_path, **variables)
    terminal.type(',render (call "sphere")\r')
    terminal.wait(sequence)
    terminal.wait("wrote ")
    terminal.child.close(force=True)


@pytest.mark.slow
def test_history_lasts_over_a_restart(tmp_path: Path) -> None:
    first = Terminal(tmp_path)
    first.enter("(define answer 42)")
    first.enter("(+ 1 1)")
    first.type(CTRL_D)
    first.wait(pexpect.EOF)
    path = tmp_path / "state" / "scenelang" / "history"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    second = Terminal(tmp_path)
    second.type("(def" + UP)  # what begins alike
    assert "(define answer 42)" in second.rest()
    second.enter("")
    second.enter("answer", "42")
    second.type(CTRL_R + "+ 1")
    assert "(+ 1 1)" in second.rest()
    second.child.close(force=True)


@pytest.mark.slow
def test_a_history_that_cannot_be_written_does_no_harm(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("a file, not a folder")
    terminal = Terminal(tmp_path)
    terminal.enter("(+ 1 2)", "3")
    terminal.child.close(force=True)


@pytest.mark.slow
def test_watch_writes_above_the_prompt(tmp_path: Path) -> None:
    program = tmp_path / "a.scene"
    rewrite(program, '(bind "a" (lambda () (call "cube")))')
    terminal = Terminal(tmp_path, "a.scene")
    terminal.enter(",watch", "watching a.scene")
    rewrite(program, '(bind "a" (lambda () (union (call "cube") (call "sphere"))))')
    terminal.wait("a.scene changed: 1 -> 2 primitives")
    terminal.enter(",watch", "no longer watched")
    terminal.child.close(force=True)


@pytest.mark.skipif(not is_supported(), reason="hard limits need Linux")
@pytest.mark.slow
def test_the_prompt_outlives_a_killed_evaluation_of_a_watched_file(tmp_path: Path) -> None:
    program = tmp_path / "a.scene"
    rewrite(program, '(bind "a" (lambda () (call "cube")))')
    terminal = Terminal(tmp_path, "--max-seconds", "0.5", "a.scene", program=["-P", ROGUE])
    terminal.enter("(define y 7)")
    terminal.enter(",watch", "watching a.scene")
    terminal.type("(* y 6")
    rewrite(program, '(rogue "hold")')
    terminal.wait("E507")
    assert "(* y 6" in terminal.rest()  # what was typed remains
    terminal.type(")\r")
    terminal.wait("42")
    rewrite(program, '(bind "a" (lambda () (union (call "cube") (call "sphere"))))')
    terminal.wait("a.scene changed: 1 -> 2 primitives")
    terminal.type(CTRL_D)
    terminal.wait(pexpect.EOF)
    terminal.child.close()
    assert terminal.child.exitstatus == 0


def test_ctrl_c_interrupts_the_evaluation_of_a_watched_file(tmp_path: Path) -> None:
    program = tmp_path / "a.scene"
    rewrite(program, '(bind "a" (lambda () (call "cube")))')
    terminal = Terminal(tmp_path, "a.scene", "--max-steps", "100G")  # which no machine reaches in a second
    terminal.enter(",watch", "watching a.scene")
    rewrite(program, "(print 1)\n(let loop () (loop))")
    wait_for_more_work(terminal.child.pid, 1.0)
    terminal.type(CTRL_C)
    terminal.wait("E508")
    terminal.enter("(* 6 7)", "42")
    terminal.child.close(force=True)


def test_save_asks_before_it_overwrites(tmp_path: Path) -> None:
    (tmp_path / "b.scene").write_text("old")
    terminal = Terminal(tmp_path)
    terminal.enter("(define k 1)")
    terminal.type(",save b.scene\r")
    terminal.wait("overwrite b.scene")
    terminal.type("n\r")
    terminal.wait("already exists")
    assert (tmp_path / "b.scene").read_text() == "old"
    terminal.enter("")
    terminal.type(",save b.scene\r")
    terminal.wait("overwrite b.scene")
    terminal.type("y\r")
    terminal.wait("wrote b.scene")
    assert (tmp_path / "b.scene").read_text() == "(define k 1)\n"
    terminal.child.close(force=True)
