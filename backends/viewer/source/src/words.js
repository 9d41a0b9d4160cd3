// The list of words: counts, search, hiding and isolating.
import { brief, counted, el, fill } from "./dom.js";

export class Words {
  // `actions`: changed() after hide or isolate, reveal(word) to go to the word's next instance.
  constructor(list, search, actions) {
    this.list = list;
    this.search = search;
    this.actions = actions;
    this.counts = [];
    this.hidden = new Set();
    this.isolated = new Set();
    search.addEventListener("input", () => this.render());
    search.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      const [first] = this.matches();
      if (first) actions.reveal(first[0]);
    });
  }

  // Takes the words of a scene; those still there stay hidden or isolated.
  take(counts) {
    this.counts = counts;
    const known = new Set(counts.map(([word]) => word));
    for (const set of [this.hidden, this.isolated]) for (const word of set) if (!known.has(word)) set.delete(word);
    this.render();
  }

  clear() {
    this.hidden.clear();
    this.isolated.clear();
    this.search.value = "";
    this.take([]);
  }

  get isFiltering() {
    return this.hidden.size > 0 || this.isolated.size > 0;
  }

  // Whether an instance whose way from the root has these words is to be seen.
  sees(words) {
    if (words.some((word) => this.hidden.has(word))) return false;
    return this.isolated.size === 0 || words.some((word) => this.isolated.has(word));
  }

  matches() {
    const sought = this.search.value.trim().toLowerCase();
    return this.counts.filter(([word]) => word.toLowerCase().includes(sought));
  }

  reset() {
    this.hidden.clear();
    this.isolated.clear();
    this.render();
    this.actions.changed();
  }

  toggle(set, word) {
    if (!set.delete(word)) set.add(word);
    this.render();
    this.actions.changed();
  }

  render() {
    const focused = document.activeElement?.dataset?.key;
    const found = this.matches();
    const rows = found.slice(0, 500).map(([word, count]) => this.row(word, count));
    if (!found.length && this.counts.length) rows.push(el("li", { className: "quiet" }, "no word matches"));
    if (this.isFiltering) rows.push(el("li", {}, el("button", { className: "wide", onclick: () => this.reset() }, "Show everything")));
    fill(this.list, ...rows);
    if (focused) [...this.list.querySelectorAll("[data-key]")].find((button) => button.dataset.key === focused)?.focus();
  }

  row(word, count) {
    const isHidden = this.hidden.has(word);
    const isIsolated = this.isolated.has(word);
    return el(
      "li",
      { className: `word${isHidden ? " hidden" : ""}` },
      el("button", { className: "name", title: "Go to its next instance", "data-key": `n${word}`, onclick: () => this.actions.reveal(word) }, word),
      el("span", { className: "count", title: counted(count) }, brief(count)),
      el("button", { className: "toggle", title: "Show only this word", "aria-label": `Only ${word}`, "aria-pressed": isIsolated, "data-key": `i${word}`, onclick: () => this.toggle(this.isolated, word) }, "Only"),
      el("button", { className: "toggle", title: "Hide this word", "aria-label": `Hide ${word}`, "aria-pressed": isHidden, "data-key": `h${word}`, onclick: () => this.toggle(this.hidden, word) }, "Hide"),
    );
  }
}
