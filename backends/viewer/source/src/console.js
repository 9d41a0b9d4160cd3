// A console: expressions are evaluated after the program, as in the REPL.
import { byId, el } from "./dom.js";

const MOST = 200; // answers that are kept

export class Console {
  // `ask(expression)` resolves to values, log and diagnostics; `stop()` ends it.
  constructor(ask, stop) {
    this.ask = ask;
    this.output = byId("answers");
    this.input = byId("expression");
    this.history = [];
    this.at = 0;
    this.running = 0;
    byId("console-stop").addEventListener("click", () => stop());
    byId("asking").addEventListener("submit", (event) => { event.preventDefault(); this.submit(); });
    this.input.addEventListener("keydown", (event) => this.onKey(event));
  }

  async submit() {
    const text = this.input.value.trim();
    if (!text) return;
    if (this.history.at(-1) !== text) this.history.push(text);
    this.at = this.history.length;
    this.input.value = "";
    const answer = el("div", { className: "answer" }, el("code", { className: "asked" }, text));
    this.output.append(answer);
    while (this.output.children.length > MOST) this.output.firstElementChild.remove();
    this.show(1);
    try {
      answer.append(...linesOf(await this.ask(text)));
    } catch (error) {
      answer.append(el("pre", { className: "error" }, error.message));
    }
    this.show(-1);
  }

  show(change) {
    this.running += change;
    byId("console-stop").hidden = this.running === 0;
    this.output.scrollTop = this.output.scrollHeight;
  }

  onKey(event) {
    const isLast = !this.input.value.slice(this.input.selectionEnd).includes("\n");
    const isFirst = !this.input.value.slice(0, this.input.selectionStart).includes("\n");
    if (event.key === "Enter" && !event.shiftKey && !event.isComposing) this.submit();
    else if (event.key === "ArrowUp" && isFirst && this.at > 0) this.recall(this.at - 1);
    else if (event.key === "ArrowDown" && isLast && this.at < this.history.length) this.recall(this.at + 1);
    else return;
    event.preventDefault();
  }

  recall(at) {
    this.at = at;
    this.input.value = this.history[at] ?? "";
  }
}

// The lines of an answer: what was printed, values, and what was wrong.
function linesOf({ values, log, diagnostics }) {
  const said = diagnostics.map((each) => el("pre", { className: each.severity }, `${each.code} ${each.message}\n${each.text}`));
  const nothing = values.length || said.length ? [] : [el("pre", { className: "quiet" }, "no value")];
  return [...log.map((line) => el("pre", { className: "quiet" }, line)), ...values.map((value) => el("pre", {}, value)), ...said, ...nothing];
}
