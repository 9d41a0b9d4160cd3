// Color swatches and hints of parameters in the text, which the language server knows and the editor's client does not ask.
import { Decoration, ViewPlugin, WidgetType } from "@codemirror/view";

const DELAY = 350; // milliseconds after the last change

const hex = ({ red, green, blue }) => `#${[red, green, blue].map((x) => Math.round(x * 255).toString(16).padStart(2, "0")).join("")}`;
const channels = (text) => ({ red: parseInt(text.slice(1, 3), 16) / 255, green: parseInt(text.slice(3, 5), 16) / 255, blue: parseInt(text.slice(5, 7), 16) / 255, alpha: 1 });

class Swatch extends WidgetType {
  constructor(color, range, pick) {
    super();
    Object.assign(this, { color, range, pick });
  }

  eq(other) {
    return other.color === this.color && JSON.stringify(other.range) === JSON.stringify(this.range);
  }

  toDOM() {
    const input = Object.assign(document.createElement("input"), { type: "color", value: this.color, className: "swatch", title: "Pick a color" });
    input.setAttribute("aria-label", `Color ${this.color}`);
    input.addEventListener("change", () => this.pick(this.range, channels(input.value)));
    return input;
  }

  ignoreEvent() {
    return true;
  }
}

class Hint extends WidgetType {
  constructor(label) {
    super();
    this.label = label;
  }

  eq(other) {
    return other.label === this.label;
  }

  toDOM() {
    return Object.assign(document.createElement("span"), { className: "hint", textContent: `${this.label} ` });
  }
}

// The offset of a position of the protocol, which counts UTF-16 units as the editor does.
function offsetOf(doc, { line, character }) {
  return line < doc.lines ? Math.min(doc.line(line + 1).from + character, doc.length) : doc.length;
}

export function swatches(client, uri) {
  return ViewPlugin.fromClass(
    class {
      constructor(view) {
        this.view = view;
        this.decorations = Decoration.none;
        this.ask();
      }

      update(update) {
        if (!update.docChanged) return;
        this.decorations = this.decorations.map(update.changes);
        this.ask();
      }

      ask() {
        clearTimeout(this.timer);
        this.timer = setTimeout(() => this.refresh().catch(() => {}), DELAY);
      }

      async refresh() {
        const { doc } = this.view.state;
        await client.initializing;
        client.sync();
        const textDocument = { uri };
        const range = { start: { line: 0, character: 0 }, end: { line: doc.lines, character: 0 } };
        const [colors, hints] = await Promise.all([client.request("textDocument/documentColor", { textDocument }), client.request("textDocument/inlayHint", { textDocument, range })]);
        if (this.view.state.doc !== doc) return;
        const pick = (place, color) => this.pick(place, color);
        const made = [
          ...(colors ?? []).map((each) => Decoration.widget({ widget: new Swatch(hex(each.color), each.range, pick), side: -1 }).range(offsetOf(doc, each.range.start))),
          ...(hints ?? []).map((each) => Decoration.widget({ widget: new Hint(typeof each.label === "string" ? each.label : each.label.map((part) => part.value).join("")), side: -1 }).range(offsetOf(doc, each.position))),
        ];
        this.decorations = Decoration.set(made, true);
        this.view.dispatch({});
      }

      // Writes a picked color in the notation that the text has.
      async pick(range, color) {
        const { doc } = this.view.state;
        const [notation] = await client.request("textDocument/colorPresentation", { textDocument: { uri }, color, range });
        if (!notation || this.view.state.doc !== doc) return;
        const insert = notation.textEdit?.newText ?? notation.label;
        this.view.dispatch({ changes: { from: offsetOf(doc, range.start), to: offsetOf(doc, range.end), insert }, userEvent: "input.color" });
      }

      destroy() {
        clearTimeout(this.timer);
      }
    },
    { decorations: (plugin) => plugin.decorations },
  );
}
