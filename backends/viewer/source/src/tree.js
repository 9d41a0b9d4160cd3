// The entity tree: rows are made when a node is opened, so that a scene of any number of instances is at hand.
import { counted, el } from "./dom.js";

const CHUNK = 200; // children shown at a time
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
    if (!this.graph.isPrimitive(node)) label.append(el("span", { className: "count" }, counted(count)));
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
    this.more(item, group, 0, CHUNK);
  }

  collapse(item) {
    if (item.getAttribute("aria-expanded") !== "true") return;
    item.setAttribute("aria-expanded", "false");
    item.querySelector(".twist").textContent = "▸";
    item.querySelector(":scope > ul").remove();
  }

  // Adds the children [from, to) of an opened item, and a row for those that are left.
  more(item, group, from, to) {
    const size = this.graph.size(item.node);
    const end = Math.min(to, size);
    for (let i = from; i < end; i += 1) group.append(this.item([...item.path, i], this.graph.at(item.node, i)));
    if (end === size) return;
    const rest = el("li", { className: "more", role: "treeitem", tabIndex: -1 }, `${counted(size - end)} more …`);
    rest.open = () => {
      rest.remove();
      this.more(item, group, end, end + 5 * CHUNK);
    };
    group.append(rest);
  }

  find(path) {
    let item = this.element.firstElementChild;
    for (let depth = 0; depth < path.length && item; depth += 1) {
      item = [...(item.querySelector(":scope > ul")?.children ?? [])].find((child) => child.path?.[depth] === path[depth]);
    }
    return item ?? null;
  }

  // Opens the way to a path, marks it and brings it into view; null marks nothing.
  reveal(path) {
    this.selected = path;
    if (path !== null) {
      let item = this.element.firstElementChild;
      for (const [depth, position] of path.entries()) {
        this.expand(item);
        const group = item.querySelector(":scope > ul");
        const known = [...group.children].filter((child) => child.path).length;
        if (position >= known) {
          group.querySelector(":scope > .more")?.remove();
          this.more(item, group, known, position + CHUNK);
        }
        item = group.children[position];
        if (!item || item.path[depth] !== position) break;
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
    this.focus(item);
    if (item.open) item.open();
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
      Enter: () => (item.open ? item.open() : this.select(item.path)),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    actions[event.key]();
  }
}
