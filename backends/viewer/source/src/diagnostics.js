// Errors and warnings of a program, as the command line shows them.
import { el, fill } from "./dom.js";

// `apply(edits)` carries out the edits of a finding that has some.
export function showDiagnostics(element, diagnostics, keepsPicture, apply) {
  element.hidden = diagnostics.length === 0;
  const errors = diagnostics.filter((d) => d.severity === "error").length;
  const items = diagnostics.slice(0, 50).map((d) =>
    el(
      "article",
      { className: d.severity },
      el("h3", {}, el("span", { className: "code" }, d.code), ` ${d.message}`),
      d.text ? el("pre", {}, d.text) : null,
      d.edits && apply ? el("button", { onclick: () => apply(d.edits) }, "Apply this fix") : null,
    ),
  );
  if (diagnostics.length > 50) items.push(el("p", { className: "quiet" }, `and ${diagnostics.length - 50} more`));
  const close = el("button", { className: "close", "aria-label": "Close the diagnostics", onclick: () => { element.hidden = true; } }, "Close");
  const note = errors && keepsPicture ? el("p", { className: "quiet" }, "The picture is the last good one.") : null;
  fill(element, close, note, ...items);
}
