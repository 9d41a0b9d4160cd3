// Lines, boxes and notes over the picture, at places of the scene: findings and measures. They are drawn as SVG.
import { Vector3 } from "three";

const SVG = "http://www.w3.org/2000/svg";
const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]]; // of the corners in binary order
const MOST = 400; // marks that are drawn

// An SVG element with attributes.
function svg(tag, attributes) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== undefined) element.setAttribute(name, String(value));
  return element;
}

export class Overlay {
  constructor(layer) {
    this.layer = layer;
    this.groups = new Map(); // marks by the name of what they belong to
    this.drawn = [];
  }

  // Shows marks under a name in place of those before. A mark is a `box`, `line`, `point` or `note` with places of the
  // stage `at`, and a `className`; a note has a `text`, and an `onclick` if it can be pressed.
  show(name, marks) {
    if (marks.length) this.groups.set(name, marks);
    else this.groups.delete(name);
    this.drawn = [...this.groups.values()].flat().slice(0, MOST).map((mark) => ({ mark, element: made(mark) }));
    this.layer.replaceChildren(...this.drawn.map(({ element }) => element));
  }

  place(camera, width, height) {
    const seen = (point) => {
      const at = new Vector3(...point).project(camera);
      return at.z > -1 && at.z < 1 ? [((at.x + 1) / 2) * width, ((1 - at.y) / 2) * height] : null;
    };
    for (const { mark, element } of this.drawn) placed(mark, element, seen);
  }
}

function made(mark) {
  if (mark.kind === "box" || mark.kind === "line") return svg("path", { class: mark.className });
  if (mark.kind === "point") return svg("circle", { class: mark.className, r: 4 });
  const group = svg("g", { class: mark.className });
  const text = svg("text", { y: 4 });
  text.textContent = mark.text;
  const width = 10 + 7 * mark.text.length;
  group.append(svg("rect", { x: -width / 2, y: -9, width, height: 18, rx: 9 }), text);
  if (mark.onclick) group.addEventListener("click", mark.onclick);
  return group;
}

// Puts an element where its mark is seen; one that is not in front of the camera is hidden.
function placed(mark, element, seen) {
  if (mark.kind === "box" || mark.kind === "line") {
    const ends = mark.kind === "box" ? edgesOf(mark.at) : [mark.at];
    const parts = ends.map(([a, b]) => [seen(a), seen(b)]).filter(([a, b]) => a && b);
    element.setAttribute("d", parts.map(([a, b]) => `M${spelled(a)}L${spelled(b)}`).join(""));
    return;
  }
  const at = seen(mark.at);
  element.setAttribute("visibility", at ? "visible" : "hidden");
  if (at) element.setAttribute("transform", `translate(${spelled(at)})`);
}

const spelled = ([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`;

// The edges of a box [low, high] as pairs of corners.
function edgesOf([low, high]) {
  const corner = (bits) => [0, 1, 2].map((axis) => (bits & (4 >> axis) ? high[axis] : low[axis]));
  return EDGES.map(([a, b]) => [corner(a), corner(b)]);
}

// A length with three digits.
export function lengthText(value) {
  return String(Number(value.toPrecision(3)));
}
