// The open programs as tabs, with marks of those that are not saved.
import { byId, el, fill } from "./dom.js";

// Key of the store of the browser's tab, and of all its tabs: a browser that was killed keeps the second one only.
const OPEN = "scenelang-tabs";

export class Tabs {
  // `actions`: choose(file), closed(file); `isUnsaved(file)` tells marks.
  constructor(element, actions) {
    this.element = element;
    this.actions = actions;
    this.open = [];
    this.names = [];
    this.active = 0;
    element.addEventListener("keydown", (event) => this.onKey(event));
  }

  // Takes over the names of all files; those that were open stay open, by name.
  take(names) {
    this.names = names;
    this.draw();
  }

  // Opens what was open in this tab of the browser, or in its last one, and returns the file that was shown, or null.
  restore(names, unsaved) {
    this.names = names;
    let saved = {};
    try {
      saved = JSON.parse(sessionStorage.getItem(OPEN) ?? localStorage.getItem(OPEN)) ?? {};
    } catch { /* no store: nothing was open */ }
    const files = [...(saved.open ?? []), ...unsaved].map((name) => names.indexOf(name)).filter((file) => file >= 0);
    this.open = [...new Set(files)];
    return names.includes(saved.active) ? names.indexOf(saved.active) : null;
  }

  show(file) {
    if (!this.open.includes(file)) this.open.push(file);
    this.active = file;
    this.draw();
    const state = JSON.stringify({ open: this.open.map((each) => this.names[each]), active: this.names[file] });
    try {
      for (const store of [sessionStorage, localStorage]) store.setItem(OPEN, state);
    } catch { /* no store: a reload begins anew */ }
  }

  close(file) {
    const at = this.open.indexOf(file);
    if (at < 0 || this.open.length < 2) return;
    this.open.splice(at, 1);
    this.actions.closed(file);
    if (file === this.active) this.actions.choose(this.open[Math.max(0, at - 1)]);
    else this.show(this.active);
  }

  draw() {
    this.element.hidden = this.names.length < 2;
    const hadFocus = this.element.contains(document.activeElement);
    fill(this.element, ...this.open.map((file) => this.tab(file)));
    if (hadFocus) this.element.querySelector('[aria-selected="true"]')?.focus();
  }

  tab(file) {
    const name = this.names[file].split("/").pop();
    const isUnsaved = this.actions.isUnsaved(file);
    const isActive = file === this.active;
    const tab = el(
      "button",
      { role: "tab", "aria-selected": isActive, "aria-controls": "code", "aria-label": isUnsaved ? `${name}, not saved` : name, "data-file": file, tabIndex: isActive ? 0 : -1, title: this.names[file], onclick: () => this.actions.choose(file) },
      isUnsaved ? `${name} •` : name,
    );
    const close = this.open.length < 2 ? null : el("button", { className: "close", tabIndex: -1, "aria-label": `Close ${name}`, title: "Close (Delete)", onclick: () => this.close(file) }, "×");
    return el("span", { role: "presentation", className: "tab" }, tab, close);
  }

  // Marks that the unsaved state of a file has changed, without making other elements.
  mark(file) {
    const tab = this.element.querySelector(`[data-file="${file}"]`);
    if (!tab) return;
    const name = this.names[file].split("/").pop();
    const isUnsaved = this.actions.isUnsaved(file);
    tab.textContent = isUnsaved ? `${name} •` : name;
    tab.setAttribute("aria-label", isUnsaved ? `${name}, not saved` : name);
  }

  onKey(event) {
    const at = this.open.indexOf(this.active);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1 + this.open.length, Home: 0, End: this.open.length - 1 }[event.key];
    if (event.key === "Delete") this.close(this.active);
    else if (to === undefined) return;
    else this.actions.choose(this.open[to % this.open.length]);
    event.preventDefault();
    event.stopPropagation();
  }
}
