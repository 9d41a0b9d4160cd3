// The entity tree: rows are made when a node is opened, so that a scene of any number of instances is at hand.
import { brief, counted, el } from "./dom.js";

const CHUNK = 200; // children shown at first
const AROUND = 20; // children shown on both sides of one that is looked for
const same = (a, b) => a !== null && b !== null && a.length === b.length && a.every((x, i) => x === b[i]);

export class Tree {
  constructor(element, select) {
    this.element = element;
    this.select = select;
    this.selected = null;
    element.addEventListener("keydown", (event) => this.onKey(event));
    element.addEventListener("click", (event) => this.onClick(event));
  }

  clear() {
    this.selected = null;
    this.graph = null;
    this.element.replaceChildren();
  }

  // Shows a frame's tree; what was open stays open as far as it is still there.
  take(graph, frame) {
    const open = this.graph ? [...this.element.querySelectorAll('[aria-expanded="true"]')].map((item) => item.path) : [[]];
    this.graph = graph;
    this.frame = frame;
    this.element.replaceChildren(this.item([], graph.root(frame)));
    for (const path of open) {
      const item = this.find(path);
      if (item) this.expand(item);
    }
    this.mark(this.selected);
  }

  item(path, node) {
    const below = this.graph.size(node);
    const item = el("li", { role: "treeitem", tabIndex: path.length ? -1 : 0, "aria-level": path.length + 1 });
    item.path = path;
    item.node = node;
    const count = this.graph.leaves[node];
    const mark = el("span", { className: "twist", "aria-hidden": "true" }, below ? "▸" : "");
    const label = el("span", { className: "row" }, mark, el("span", { className: "name" }, this.graph.word(node)));
    if (!this.graph.isPrimitive(node)) label.append(el("span", { className: "count", title: `${counted(count)} primitives` }, brief(count)));
    item.append(label);
    if (below) item.setAttribute("aria-expanded", "false");
    return item;
  }

  expand(item) {
    if (item.getAttribute("aria-expanded") !== "false") return;
    item.setAttribute("aria-expanded", "true");
    item.querySelector(".twist").textContent = "▾";
    const group = el("ul", { role: "group" });
    item.append(group);
    group.append(this.gap(item, 0, this.graph.size(item.node)));
    this.open(group.firstElementChild, 0, CHUNK);
  }

  collapse(item) {
    if (item.getAttribute("aria-expanded") !== "true") return;
    item.setAttribute("aria-expanded", "false");
    item.querySelector(".twist").textContent = "▸";
    item.querySelector(":scope > ul").remove();
  }

  // A row that stands for the children [from, to) of an opened item.
  gap(item, from, to) {
    const row = el("li", { className: "more", role: "treeitem", tabIndex: -1 }, `${counted(to - from)} more …`);
    return Object.assign(row, { item, from, to });
  }

  // Puts the children [from, to) in a gap's place, and what is left of it around them.
  open(gap, from, to) {
    const { item } = gap;
    const low = Math.max(from, gap.from);
    const high = Math.min(to, gap.to);
    const rows = [];
    if (low > gap.from) rows.push(this.gap(item, gap.from, low));
    for (let i = low; i < high; i += 1) rows.push(this.item([...item.path, i], this.graph.at(item.node, i)));
    if (high < gap.to) rows.push(this.gap(item, high, gap.to));
    gap.replaceWith(...rows);
    return rows[0];
  }

  find(path) {
    let item = this.element.firstElementChild;
    for (let depth = 0; depth < path.length && item; depth += 1) item = this.childOf(item, path[depth]);
    return item ?? null;
  }

  // The row of a child, if it is shown.
  childOf(item, position) {
    return [...(item.querySelector(":scope > ul")?.children ?? [])].find((row) => row.path?.[row.path.length - 1] === position);
  }

  // Opens the way to a path, marks it and brings it into view; null marks nothing.
  reveal(path) {
    this.selected = path;
    if (path !== null) {
      let item = this.element.firstElementChild;
      for (const position of path) {
        this.expand(item);
        const gap = [...item.querySelector(":scope > ul").children].find((row) => row.from <= position && position < row.to);
        if (gap) this.open(gap, position - AROUND, position + AROUND);
        item = this.childOf(item, position);
      }
    }
    this.mark(path);
    this.element.querySelector('[aria-selected="true"] > .row')?.scrollIntoView({ block: "nearest" });
  }

  mark(path) {
    for (const item of this.element.querySelectorAll("[aria-selected]")) item.removeAttribute("aria-selected");
    const item = path && this.find(path);
    if (item && same(item.path, path)) item.setAttribute("aria-selected", "true");
  }

  onClick(event) {
    const item = event.target.closest("li");
    if (!item) return;
    if (!item.item) this.focus(item);
    if (item.item) this.focus(this.open(item, item.from, item.from + 5 * CHUNK));
    else if (event.target.closest(".twist")) item.getAttribute("aria-expanded") === "true" ? this.collapse(item) : this.expand(item);
    else this.select(item.path);
  }

  focus(item) {
    for (const other of this.element.querySelectorAll('[tabindex="0"]')) other.tabIndex = -1;
    item.tabIndex = 0;
    item.focus({ preventScroll: true });
    item.firstElementChild?.scrollIntoView({ block: "nearest" });
  }

  onKey(event) {
    const item = event.target.closest("li");
    if (!item) return;
    const rows = [...this.element.querySelectorAll("li")];
    const at = rows.indexOf(item);
    const isOpen = item.getAttribute("aria-expanded") === "true";
    const actions = {
      ArrowDown: () => rows[at + 1] && this.focus(rows[at + 1]),
      ArrowUp: () => rows[at - 1] && this.focus(rows[at - 1]),
      Home: () => this.focus(rows[0]),
      End: () => this.focus(rows[rows.length - 1]),
      ArrowRight: () => (isOpen ? rows[at + 1] && this.focus(rows[at + 1]) : this.expand(item)),
      ArrowLeft: () => (isOpen ? this.collapse(item) : item.parentElement.closest("li") && this.focus(item.parentElement.closest("li"))),
      Enter: () => (item.item ? this.focus(this.open(item, item.from, item.from + 5 * CHUNK)) : this.select(item.path)),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    actions[event.key]();
  }
}
