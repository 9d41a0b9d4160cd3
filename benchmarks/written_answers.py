"""Answers to tasks of the benchmark that are written from nothing but the prompt, without a service.

``python benchmarks/written_answers.py prompts DIR --task NAME ...`` writes what a model would be sent, one file for
each task and mode: ``DIR/MODE/TASK.prompt.md``. Whoever answers writes ``TASK.answer.md`` beside it, before any program
is run. ``collect DIR -o answers.jsonl`` makes a recording of these, which ``scenelang bench --replay`` judges. Tokens
are estimated.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

from scenelang.backends.language_models.catalogue import Message, Reply, Request, StopReason, TextContent, Usage
from scenelang.backends.language_models.client import reply_data
from scenelang.backends.language_models.openai_chat import estimate_tokens
from scenelang.bench.answering import request_digest
from scenelang.bench.tasks import load_tasks
from scenelang.bench.trials import MODES, task_in
from scenelang.inference.brief import Brief, Prompts

SYSTEM, USER = "<system>\n", "\n</system>\n\n<user>\n"
END = "\n</user>\n"
LETTERS_PER_TOKEN = 3.5


def prompts(folder: Path, names: list[str], modes: list[str]) -> None:
    """Write the prompts of tasks; those with pictures are left out."""
    for task in load_tasks():
        for mode in modes:
            asked = task_in(task, MODES[mode])
            if asked is None or task.is_image or (names and task.name not in names):
                continue
            brief = Brief(asked, Prompts(), MODES[mode].is_constrained)
            user = "\n".join(part.text for part in brief.first.parts if isinstance(part, TextContent))
            path = folder / mode / f"{task.name}.prompt.md"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(f"{SYSTEM}{brief.system}{USER}{user}{END}", "utf-8")


def collected(folder: Path) -> Iterator[dict[str, object]]:
    """Yield the entries of a recording: the first answers to the prompts of a folder."""
    for path in sorted(folder.glob("*/*.answer.md")):
        task, mode = path.name.removesuffix(".answer.md"), path.parent.name
        prompt = path.with_name(f"{task}.prompt.md").read_text("utf-8")
        system, user = prompt.removeprefix(SYSTEM).removesuffix(END).split(USER)
        turn = Message("user", (TextContent(user),))
        request = Request("written", TextContent(system), (turn,), 32_000)
        text = path.read_text("utf-8")
        usage = Usage(sent=estimate_tokens(request), answered=round(len(text) / LETTERS_PER_TOKEN))
        yield {
            "task": task, "mode": mode, "sample": 1, "number": 1, "purpose": "draft",
            "digest": request_digest(request, 1), "cost": 0.0, "seconds": 0.0,
            "reply": reply_data(Reply(text, StopReason.END, usage, "written", "")),
        }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=("prompts", "collect"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--task", action="append", default=[])
    parser.add_argument("--mode", action="append", default=[])
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    if arguments.command == "prompts":
        prompts(arguments.folder, arguments.task, arguments.mode or ["python", "dsl"])
        return
    if arguments.output is None:
        parser.error("collect requires -o")
    lines = [json.dumps(entry, ensure_ascii=False) + "\n" for entry in collected(arguments.folder)]
    arguments.output.write_text("".join(lines), "utf-8")


if __name__ == "__main__":
    main()
