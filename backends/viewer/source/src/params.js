// Params: sliders, fields and color pickers; trying a value out, and writing it back to the file.
import { debounced, el, fill } from "./dom.js";

const DELAY = 120; // milliseconds between the last movement and the evaluation

export class Params {
  // `actions`: set(name, value) tries a value out (null: the file's own again), save(name) writes it to the file.
  constructor(element, actions) {
    this.element = element;
    this.actions = actions;
    this.set = debounced((name, value) => actions.set(name, value), DELAY);
  }

  // Shows the params; the one that is being moved keeps its control.
  take(params) {
    const focused = document.activeElement?.closest?.("[data-param]")?.dataset.param;
    if (!params.length) {
      fill(this.element, el("p", { className: "quiet" }, "The program has no ", el("code", {}, "(param …)"), "."));
      return;
    }
    const old = new Map([...this.element.querySelectorAll("[data-param]")].map((row) => [row.dataset.param, row]));
    const rows = params.map((param) => {
      const known = old.get(param.name);
      if (known && param.name === focused && known.shape === shapeOf(param)) {
        known.update(param);
        return known;
      }
      return this.row(param);
    });
    const kept = rows.find((row) => row.dataset.param === focused && row.isConnected);
    if (kept) {
      for (const child of [...this.element.children]) if (child !== kept) child.remove();
      kept.before(...rows.slice(0, rows.indexOf(kept)));
      kept.after(...rows.slice(rows.indexOf(kept) + 1));
    } else fill(this.element, ...rows);
  }

  row(param) {
    const id = `param-${param.name}`;
    const change = (value) => this.set(param.name, value);
    const control = this.control(param, id, change);
    const save = el("button", { onclick: () => this.actions.save(param.name) }, "Save");
    const reset = el("button", { onclick: () => this.actions.set(param.name, null) }, "Reset");
    const note = el("p", { className: "quiet" });
    const row = el(
      "div",
      { className: "param", "data-param": param.name },
      el("label", { for: id }, param.name),
      control.element,
      param.doc ? el("p", { className: "doc" }, param.doc) : null,
      el("div", { className: "buttons" }, save, reset),
      note,
    );
    row.shape = shapeOf(param);
    row.update = (next) => {
      if (!row.contains(document.activeElement)) control.write(next.value);
      save.hidden = reset.hidden = !next.changed;
      save.disabled = !next.writable;
      note.textContent = next.reason ?? "";
      note.hidden = !next.reason;
    };
    row.update(param);
    return row;
  }

  control(param, id, change) {
    const disabled = param.kind === "computed" || !param.live;
    if (param.kind === "integer" || param.kind === "number") return numberControl(param, id, change, disabled);
    if (param.kind === "boolean") {
      const box = el("input", { type: "checkbox", id, disabled, onchange: () => change(box.checked) });
      return { element: box, write: (value) => { box.checked = value; } };
    }
    if (param.kind === "color") {
      const picker = el("input", { type: "color", id, disabled, oninput: () => change(picker.value) });
      return { element: picker, write: (value) => { picker.value = value; } };
    }
    const text = el("input", { type: "text", id, disabled, spellcheck: false, onchange: () => change(text.value) });
    return { element: text, write: (value) => { text.value = value; } };
  }
}

function shapeOf(param) {
  return JSON.stringify([param.kind, param.min, param.max, param.doc, param.live]);
}

function numberControl(param, id, change, disabled) {
  const step = param.kind === "integer" ? 1 : "any";
  const field = el("input", { type: "number", id, step, min: param.min, max: param.max, disabled });
  const allowed = (value) => {
    const bounded = Math.min(param.max ?? Infinity, Math.max(param.min ?? -Infinity, value));
    return param.kind === "integer" ? Math.round(bounded) : bounded;
  };
  const send = (value) => Number.isFinite(value) && change(allowed(value));
  field.addEventListener("input", () => field.value !== "" && send(Number(field.value)));
  // what is shown at the end is what was taken
  field.addEventListener("change", () => { if (field.value !== "") field.value = String(allowed(Number(field.value))); });
  if (param.min === null || param.max === null) return { element: field, write: (value) => { field.value = String(value); } };
  const fine = param.kind === "integer" ? 1 : 10 ** Math.floor(Math.log10((param.max - param.min) / 100));
  const slider = el("input", { type: "range", min: param.min, max: param.max, step: fine, disabled, "aria-label": `${param.name}, slider` });
  slider.addEventListener("input", () => {
    const value = param.kind === "integer" ? Number(slider.value) : Number(Number(slider.value).toPrecision(12));
    field.value = String(value);
    send(value);
  });
  field.addEventListener("input", () => { slider.value = field.value; });
  return {
    element: el("div", { className: "number" }, slider, field),
    write: (value) => { field.value = slider.value = String(value); },
  };
}
