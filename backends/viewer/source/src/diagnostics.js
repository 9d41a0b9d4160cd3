// Errors and warnings of a program, as the command line shows them, and findings about its geometry.
import { el, fill } from "./dom.js";

const MOST = 50;

// `actions` are those of findings: apply(edits), number(index) of those in the picture, highlight(index), select(index),
// closed(); without them, nothing can be pressed.
export function showDiagnostics(element, diagnostics, keepsPicture, actions = null) {
  element.hidden = diagnostics.length === 0;
  const errors = diagnostics.filter((d) => d.severity === "error").length;
  const items = diagnostics.slice(0, MOST).map((diagnostic, index) => item(diagnostic, index, actions));
  if (diagnostics.length > MOST) items.push(el("p", { className: "quiet" }, `and ${diagnostics.length - MOST} more`));
  const close = el("button", { className: "close", "aria-label": "Close the diagnostics", onclick: () => { element.hidden = true; actions?.closed(); } }, "Close");
  const note = errors && keepsPicture ? el("p", { className: "quiet" }, "The picture is the last good one.") : null;
  fill(element, close, note, ...items);
}

// The lines of a program that a diagnostic is about; folded where the picture shows it.
function textOf(text, isFolded) {
  const lines = el("pre", {}, text);
  return isFolded ? el("details", {}, el("summary", {}, "Program"), lines) : lines;
}

function item(diagnostic, index, actions) {
  const number = actions?.number(index) ?? null;
  const head = [el("span", { className: "code" }, diagnostic.code), ` ${diagnostic.message}`];
  const show = number === null ? null : el("button", { className: "finding", "data-finding": index, title: "Select and show it", onclick: () => actions.select(index) }, el("span", { className: "number" }, String(number)), ...head);
  const article = el(
    "article",
    { className: diagnostic.severity },
    el("h2", {}, ...(show ? [show] : head)),
    diagnostic.text ? textOf(diagnostic.text, show !== null) : null,
    diagnostic.edits && actions ? el("button", { onclick: () => actions.apply(diagnostic.edits) }, "Apply this fix") : null,
  );
  if (show) {
    for (const name of ["pointerenter", "focusin"]) article.addEventListener(name, () => actions.highlight(index));
    for (const name of ["pointerleave", "focusout"]) article.addEventListener(name, () => actions.highlight(null));
  }
  return article;
}
