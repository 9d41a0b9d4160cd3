// Findings about the geometry in the picture: what they are about is outlined, numbered as in the list.
import { lengthText } from "./overlay.js";

const distance = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));

export class Findings {
  constructor(page) {
    this.page = page;
    this.items = [];
    this.active = null;
  }

  // Takes over the diagnostics of an examination; those with marks are shown in the picture.
  take(diagnostics) {
    this.items = diagnostics;
    this.active = null;
    this.draw();
  }

  clear() {
    if (this.items.length) this.take([]);
  }

  // The number that a diagnostic has in the list and in the picture, or null.
  number(index) {
    const marked = this.items.filter((each) => each.marks);
    return this.items[index]?.marks ? marked.indexOf(this.items[index]) + 1 : null;
  }

  // Brings out a finding, or none.
  highlight(index) {
    if (this.active === index || !this.page.packet) return;
    this.active = index;
    this.draw();
    const marks = index === null ? null : this.items[index]?.marks;
    if (marks && marks.frame === this.page.frame) this.page.stage.select(marks.objects[0].subject[0], this.boxOf(marks.objects[0].subject));
    else this.page.showSelection();
    this.page.draw();
  }

  // Selects what a finding is about and shows it with what is near it.
  select(index) {
    const { page } = this;
    const marks = this.items[index]?.marks;
    if (!marks) return;
    if (marks.frame !== page.frame) page.timeline.go(marks.frame);
    const [first] = marks.objects;
    page.select(page.graph.pathOfRange(page.frame, first.subject[0][0], first.subject.at(-1)[1]));
    const boxes = marks.objects.slice(0, 1).flatMap((object) => [object.subject, object.other]).map((runs) => this.boxOf(runs)).filter(Boolean);
    const bound = (pick, side) => [0, 1, 2].map((axis) => pick(...boxes.map((box) => box[side][axis])));
    const lines = first.lines.flat().map((point) => page.staged(point));
    for (const point of lines) boxes.push({ low: point, high: point });
    if (boxes.length) page.frameBox(bound(Math.min, "low"), bound(Math.max, "high"));
    this.draw();
  }

  // The box of primitives of the shown frame.
  boxOf(runs) {
    const { instances } = this.page;
    if (!instances?.ready) return null;
    const boxes = runs.map(([low, high]) => instances.box(low, Math.min(high, instances.count(instances.frame)))).filter(Boolean);
    if (!boxes.length) return null;
    const bound = (pick, side) => [0, 1, 2].map((axis) => pick(...boxes.map((box) => box[side][axis])));
    return { low: bound(Math.min, "low"), high: bound(Math.max, "high") };
  }

  draw() {
    const { page } = this;
    if (!page.overlay) return;
    const shown = this.items.map((each, index) => [each, index]).filter(([each]) => each.marks?.frame === page.frame);
    page.overlay.show("findings", shown.flatMap(([each, index]) => each.marks.objects.flatMap((object) => this.marksOf(object, each, index))));
    page.draw();
  }

  marksOf(object, { severity }, index) {
    const { page } = this;
    const isActive = this.active === index;
    const name = (part) => `${part} ${severity}${isActive ? " active" : ""}`;
    const box = this.boxOf(object.subject);
    const other = isActive ? this.boxOf(object.other) : null;
    const marks = [];
    if (other) marks.push({ kind: "box", at: [other.low, other.high], className: name("other") });
    if (box) marks.push({ kind: "box", at: [box.low, box.high], className: name("subject") });
    for (const ends of object.lines) {
      const [a, b] = ends.map((point) => page.staged(point));
      marks.push({ kind: "line", at: [a, b], className: name("reach") });
      if (isActive && object.lines.length === 1) marks.push({ kind: "note", at: a.map((value, i) => (value + b[i]) / 2), text: lengthText(distance(...ends)), className: name("amount") });
    }
    for (const point of [...object.points.slice(0, 40), ...object.centers]) marks.push({ kind: "point", at: page.staged(point), className: name("contact") });
    if (box) marks.push({ kind: "note", at: [(box.low[0] + box.high[0]) / 2, box.high[1], (box.low[2] + box.high[2]) / 2], text: String(this.number(index)), className: name("number"), onclick: () => page.chooseFinding(index) });
    return marks;
  }
}
