// What is known of the selected entity: path, handle, attributes, and the form that made it.
import { counted, el, fill } from "./dom.js";

// `size` is the extent of the selection along x, y and z, or null.
export function inspect(element, graph, frame, path, size) {
  const nodes = path === null ? null : graph.nodesOn(frame, path);
  if (nodes === null) {
    fill(element, el("p", { className: "quiet" }, "Click an object or a row of the tree."));
    return;
  }
  const node = nodes[nodes.length - 1];
  const handle = graph.handle(frame, path);
  const embedding = graph.embedding(node);
  const facts = [];
  const add = (name, value, className) => facts.push(el("dt", {}, name), el("dd", className ? { className } : {}, value));
  add("path", graph.spelled(frame, path), "path");
  if (handle !== null) add("handle", `<${handle}>`, "code");
  if (embedding?.text) add("text", embedding.text);
  for (const [name, value] of embedding?.attributes ?? []) add(`:${name}`, shortened(value), "code");
  if (size) add("size", size.map((value) => Number(value.toPrecision(4))).join(" × "));
  if (!graph.isPrimitive(node)) add("primitives", counted(graph.leaves[node]));
  const { calls, definition } = graph.places(node);
  calls.forEach((place, i) => add(i ? "or at" : "made at", placed(place)));
  definition.forEach((place) => add("bound at", placed(place)));
  fill(element, el("h3", {}, graph.word(node)), el("dl", {}, ...facts));
}

function placed(place) {
  const name = place.file.split("/").pop();
  return el("span", { className: "place" }, `${name}, line ${place.line}`, el("code", {}, place.text));
}

// A value as text, its numbers with at most four digits: those of a named color have seventeen.
function shortened(value) {
  return value.replace(/(?<![\w"])-?\d+\.\d{4,}(?:e-?\d+)?/g, (number) => String(Number(Number(number).toPrecision(4))));
}
