// Measuring: the distance of two points of surfaces, and the gap between two objects.
import { byId, el, fill } from "./dom.js";
import { lengthText } from "./overlay.js";

const SNAP = 10; // pixels around a corner in which it is taken
const AXES = ["x", "y", "z"];

export class Measure {
  constructor(page) {
    this.page = page;
    this.mode = null; // "points", "objects", or null
    this.clear();
    byId("measure").addEventListener("click", () => this.turn(this.mode ? null : "points"));
    byId("measure-close").addEventListener("click", () => this.turn(null));
    byId("measure-clear").addEventListener("click", () => { this.clear(); this.draw(); });
    for (const choice of document.querySelectorAll('input[name="measured"]')) choice.addEventListener("change", () => this.turn(choice.value));
    byId("canvas").addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || this.mode !== "points") return;
      const { clientWidth, clientHeight } = page.viewport;
      this.click(clientWidth / 2, clientHeight / 2);
    });
  }

  clear() {
    this.points = []; // of the stage
    this.pair = []; // paths
    this.gap = null;
  }

  // Starts measuring points or objects; null ends it.
  turn(mode) {
    this.mode = mode;
    this.clear();
    const { selection } = this.page;
    if (mode === "objects" && selection?.length) this.pair = [selection];
    byId("measure").setAttribute("aria-pressed", String(mode !== null));
    document.body.classList.toggle("measuring", mode === "points");
    for (const choice of document.querySelectorAll('input[name="measured"]')) choice.checked = choice.value === mode;
    this.draw();
  }

  // Takes the point of the surface that is seen at a place of the canvas.
  click(x, y) {
    const point = this.page.stage.pointAt(this.page.viewpoint, x, y);
    if (!point) {
      this.page.announce("there is no surface at this point");
      return;
    }
    if (this.points.length === 2) this.points = [];
    this.points.push(this.snapped(point, x, y));
    this.draw();
  }

  // The corner of the primitive's box that is near a point in space and in the picture, or the point.
  snapped(point, x, y) {
    const { page } = this;
    const leaf = page.stage.pick(page.viewpoint, x, y);
    const box = leaf === null ? null : page.instances.box(leaf, leaf + 1);
    if (!box) return point;
    const corner = point.map((value, i) => (Math.abs(value - box.low[i]) < Math.abs(value - box.high[i]) ? box.low[i] : box.high[i]));
    const apart = Math.hypot(...corner.map((value, i) => value - point[i]));
    return apart <= SNAP * page.viewpoint.lengthOfPixel(point, page.viewport.clientHeight) ? corner : point;
  }

  // Takes an object as the first or the second of a pair.
  async take(path) {
    if (!path?.length) return;
    if (this.pair.length === 2) this.pair = [];
    this.pair.push(path);
    this.gap = null;
    this.draw();
    if (this.pair.length < 2) return;
    const pair = this.pair;
    const gap = await this.exact(pair);
    if (this.pair !== pair) return;
    this.gap = gap;
    this.draw();
  }

  // The gap that the interpreter measures; null where it cannot.
  async exact(pair) {
    const { page } = this;
    if (!page.server.gap) return null;
    const [from, to] = pair.map((path) => page.graph.spelled(page.frame, path));
    try {
      return await page.server.gap(page.file, page.editor.text, { from, to, frame: page.frame });
    } catch (error) {
      page.announce(error.message);
      return null;
    }
  }

  // What was measured belongs to a picture: another one is measured anew.
  stale() {
    if (!this.mode) return;
    this.clear();
    this.draw();
  }

  draw() {
    const { page } = this;
    byId("measured").hidden = this.mode === null;
    page.overlay.show("measure", this.mode === "points" ? this.marksOfPoints() : this.marksOfPair());
    fill(byId("measured-result"), ...(this.mode === "objects" ? this.gapText() : this.pointText()));
    page.draw();
  }

  marksOfPoints() {
    const points = this.points.map((at) => ({ kind: "point", at, className: "measured" }));
    return this.points.length === 2 ? [{ kind: "line", at: this.points, className: "measured" }, ...points] : points;
  }

  boxes() {
    const { page } = this;
    return this.pair.map((path) => page.boxOfPath(path)).filter(Boolean);
  }

  marksOfPair() {
    return this.mode === "objects" ? this.boxes().map(({ low, high }) => ({ kind: "box", at: [low, high], className: "measured" })) : [];
  }

  pointText() {
    if (this.points.length < 2) return [el("p", {}, this.points.length ? "Choose the second point." : "Choose two points: click surfaces, or turn the picture and press Enter for the point in its middle.")];
    const [a, b] = this.points;
    const offset = b.map((value, i) => (value - a[i]) / this.page.packet.box.scale);
    const distance = Math.hypot(...offset);
    const decimals = Math.min(Math.max(2 - Math.floor(Math.log10(distance || 1)), 0), 20); // three digits of the distance: what is less is rounding
    const parts = offset.map((part) => String(Number(part.toFixed(decimals)) + 0));
    return [el("p", { className: "length" }, `distance ${lengthText(distance)}`), el("p", {}, AXES.map((axis, i) => `d${axis} ${parts[i]}`).join("  "))];
  }

  gapText() {
    const { page } = this;
    if (this.pair.length < 2) return [el("p", {}, this.pair.length ? "Choose the second object." : "Choose two objects in the picture or the tree.")];
    const names = this.pair.map((path) => page.graph.word(page.graph.nodesOn(page.frame, path).at(-1)));
    const boxes = this.boxes();
    const lines = [el("p", {}, names.join(" and "))];
    if (this.gap) lines.push(el("p", { className: "length" }, this.gap.distance > 0 ? `gap ${lengthText(this.gap.distance)}${this.gap.exact ? "" : " or more"}` : `they touch or overlap${this.gap.exact ? "" : ", as far as their boxes tell"}`));
    if (boxes.length === 2) lines.push(el("p", {}, `between their boxes: ${AXES.map((axis, i) => `${axis} ${lengthText(this.apart(boxes, i))}`).join("  ")}`));
    return lines;
  }

  // How far two boxes are apart along an axis; less than 0 if they overlap there.
  apart([a, b], axis) {
    return Math.max(b.low[axis] - a.high[axis], a.low[axis] - b.high[axis]) / this.page.packet.box.scale;
  }
}
