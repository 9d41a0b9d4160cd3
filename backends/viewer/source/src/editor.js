// The text of a program: CodeMirror with the language server's diagnostics, completion, help, renaming and formatting.
import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyField, historyKeymap, indentWithTab, isolateHistory } from "@codemirror/commands";
import { bracketMatching, HighlightStyle, indentUnit, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { lintGutter, lintKeymap } from "@codemirror/lint";
import { formatDocument, languageServerExtensions, LSPClient } from "@codemirror/lsp-client";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState, StateEffect, StateField } from "@codemirror/state";
import { Decoration, drawSelection, EditorView, highlightActiveLine, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { swatches } from "./swatches.js";

const NUMBER = /[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?/;
const ATOM = /[^\s()[\]{}";,'`]+/;

// Colors of tokens while one types; the language server knows more, but answers later.
const language = StreamLanguage.define({
  name: "scenelang",
  startState: () => ({ isHead: false, depth: 0 }),
  token(stream, state) {
    if (stream.eatSpace()) return null;
    if (state.depth || stream.match("#|")) {
      state.depth ||= 1;
      while (!stream.eol()) {
        if (stream.match("|#")) state.depth -= 1;
        else if (stream.match("#|")) state.depth += 1;
        else stream.next();
        if (!state.depth) break;
      }
      return "comment";
    }
    if (stream.eat(";")) {
      stream.skipToEnd();
      return "comment";
    }
    if (stream.eat('"')) {
      let escaped = false;
      while (!stream.eol()) {
        const letter = stream.next();
        if (letter === '"' && !escaped) break;
        escaped = letter === "\\" && !escaped;
      }
      state.isHead = false;
      return "string";
    }
    if (stream.match(/[()[\]{}]/)) {
      state.isHead = stream.current() === "(";
      return "bracket";
    }
    if (stream.match(/['`,@]+/)) return "operator";
    const { isHead } = state;
    state.isHead = false;
    if (!stream.match(ATOM)) {
      stream.next();
      return null;
    }
    const text = stream.current();
    if (text.startsWith(":")) return "propertyName";
    if (text.startsWith("<") && text.endsWith(">")) return "labelName";
    if (new RegExp(`^(?:${NUMBER.source})$`).test(text)) return "number";
    if (/^#[tf]$|^none$/.test(text)) return "atom";
    return isHead ? "keyword" : "variableName";
  },
  languageData: { commentTokens: { line: ";" }, closeBrackets: { brackets: ["(", "[", '"'] } },
});

const colors = HighlightStyle.define([
  { tag: tags.comment, color: "var(--code-comment)", fontStyle: "italic" },
  { tag: tags.string, color: "var(--code-string)" },
  { tag: tags.number, color: "var(--code-number)" },
  { tag: tags.atom, color: "var(--code-number)" },
  { tag: tags.keyword, color: "var(--code-head)" },
  { tag: tags.propertyName, color: "var(--code-key)" },
  { tag: tags.labelName, color: "var(--code-key)" },
  { tag: tags.bracket, color: "var(--quiet)" },
]);

// The source of the selection in the picture, and of what the text's cursor is at.
const setMarks = StateEffect.define();
const marks = StateField.define({
  create: () => Decoration.none,
  update(value, transaction) {
    for (const effect of transaction.effects) if (effect.is(setMarks)) return effect.value;
    return value.map(transaction.changes);
  },
  provide: (field) => EditorView.decorations.from(field),
});
const mark = Decoration.mark({ class: "made-here" });

// Numbers are dragged sideways with Alt held: a step is the last decimal that is written.
const dragNumbers = EditorView.domEventHandlers({
  mousedown(event, view) {
    if (!event.altKey || event.button !== 0) return false;
    const number = numberAt(view.state, view.posAtCoords({ x: event.clientX, y: event.clientY }));
    if (!number) return false;
    event.preventDefault();
    dragNumber(view, number, event.clientX);
    return true;
  },
});

// The literal number around a position: its start and text.
export function numberAt(state, position) {
  if (position === null) return null;
  const line = state.doc.lineAt(position);
  for (const match of line.text.matchAll(new RegExp(`(?<![^\\s()\\[\\]])(?:${NUMBER.source})(?![^\\s()\\[\\]])`, "g"))) {
    const start = line.from + match.index;
    if (start <= position && position <= start + match[0].length) return { start, text: match[0] };
  }
  return null;
}

// The text of a number that is moved by `steps` of its last decimal, written as the number is: `.5`, or `0.5`.
export function stepped(text, steps) {
  const [, decimals = "", exponent = "0"] = /^[-+]?\d*\.?(\d*)(?:[eE]([-+]?\d+))?$/.exec(text);
  const last = Number(exponent) - decimals.length; // the power of ten of the last decimal
  const next = (Number(text) + steps * 10 ** last).toFixed(Math.min(Math.max(-last, 0), 100));
  const unsigned = Number(next) === 0 ? next.replace("-", "") : next;
  return /^[-+]?\./.test(text) ? unsigned.replace(/^(-?)0\./, "$1.") : unsigned;
}

function dragNumber(view, { start, text }, from) {
  let length = text.length;
  let isFirst = true;
  const move = (event) => {
    const next = stepped(text, Math.round((event.clientX - from) / 4));
    const annotations = isFirst ? [isolateHistory.of("before")] : [];
    view.dispatch({ changes: { from: start, to: start + length, insert: next }, annotations, userEvent: "input.drag" });
    length = next.length;
    isFirst = false;
  };
  const end = () => {
    document.removeEventListener("mousemove", move);
    document.body.classList.remove("dragging-number");
  };
  document.body.classList.add("dragging-number");
  document.addEventListener("mousemove", move);
  document.addEventListener("mouseup", end, { once: true });
}

export class Editor {
  // `actions`: changed(text), cursor(line, column), save().
  constructor(parent, transport, actions) {
    this.actions = actions;
    this.client = transport ? new LSPClient({ timeout: 20000, extensions: languageServerExtensions() }) : null;
    this.transport = transport;
    this.client?.connect(transport);
    this.view = new EditorView({ parent, state: this.stateOf("", null, null) });
    this.isQuiet = false;
  }

  // The state of a text; `saved` restores an earlier one with its history of undo.
  stateOf(text, uri, saved) {
    const extensions = [
      lineNumbers(), history(), drawSelection(), bracketMatching(), closeBrackets(), highlightActiveLine(), highlightSelectionMatches(),
      indentUnit.of("  "), EditorState.tabSize.of(2), language, syntaxHighlighting(colors), autocompletion(), lintGutter(), marks, dragNumbers,
      EditorView.cspNonce.of(document.querySelector('meta[name="style-nonce"]')?.content ?? ""),
      EditorView.contentAttributes.of({ "aria-label": "Program", tabindex: "0" }), EditorView.lineWrapping,
      keymap.of([
        { key: "Mod-s", run: () => (this.actions.save(), true), preventDefault: true },
        { key: "Shift-Alt-f", run: (view) => (this.client ? formatDocument(view) : false) },
        ...closeBracketsKeymap, ...completionKeymap, ...searchKeymap, ...historyKeymap, ...lintKeymap, ...defaultKeymap, indentWithTab,
      ]),
      EditorView.updateListener.of((update) => this.updated(update)),
      this.client && uri ? [this.client.plugin(uri, "scenelang"), swatches(this.client, uri)] : [],
    ];
    if (saved) {
      try {
        return EditorState.fromJSON(saved, { extensions }, { history: historyField });
      } catch { /* a state of another version: the text alone */ }
    }
    return EditorState.create({ doc: text, extensions });
  }

  updated(update) {
    if (update.docChanged && !this.isQuiet) this.actions.changed(this.text);
    if (update.selectionSet && !update.docChanged) {
      const head = update.state.selection.main.head;
      const line = update.state.doc.lineAt(head);
      this.actions.cursor(line.number, head - line.from + 1);
    }
  }

  get text() {
    return this.view.state.doc.toString();
  }

  // Shows another text; nothing is reported as a change.
  open(text, uri, saved = null) {
    this.isQuiet = true;
    this.view.setState(this.stateOf(text, uri, saved?.doc === text ? saved : null));
    this.isQuiet = false;
  }

  // Takes over another text as one edit of what differs, so that undo and the cursor survive.
  replace(text) {
    const old = this.text;
    let start = 0;
    while (start < old.length && start < text.length && old[start] === text[start]) start += 1;
    let end = 0;
    while (end < old.length - start && end < text.length - start && old.at(-1 - end) === text.at(-1 - end)) end += 1;
    this.edit([{ from: start, to: old.length - end, insert: text.slice(start, text.length - end) }]);
  }

  edit(changes) {
    this.view.dispatch({ changes, annotations: [isolateHistory.of("full")] });
  }

  // What is needed to go on after a reload: text, selection and undo.
  saved() {
    return this.view.state.toJSON({ history: historyField });
  }

  // Starts anew with a language server that has taken the place of another.
  reconnect() {
    this.client.disconnect();
    this.client.connect(this.transport);
  }

  format() {
    if (this.client) formatDocument(this.view);
  }

  focus() {
    this.view.focus();
  }

  // Where words are called by name, [line, column] counted from 1.
  callsOf(word) {
    const { doc } = this.view.state;
    const name = word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
    return [...this.text.matchAll(new RegExp(`\\(call\\s+"${name}"`, "g"))].map(({ index }) => {
      const line = doc.lineAt(index);
      return [line.number, index - line.from + 1];
    });
  }

  // Marks the forms that begin at places, [line, column] counted from 1, and brings the first into view.
  mark(places, reveals) {
    const { doc } = this.view.state;
    const ranges = [];
    for (const [line, column] of places) {
      if (line > doc.lines) continue;
      const from = doc.line(line).from + column - 1;
      const to = endOfForm(doc.sliceString(from, Math.min(doc.length, from + 20000)));
      if (to) ranges.push(mark.range(from, from + to));
    }
    const effects = [setMarks.of(Decoration.set(ranges, true))];
    if (reveals && ranges.length) effects.push(EditorView.scrollIntoView(ranges[0].from, { y: "center" }));
    this.view.dispatch({ effects });
  }

  destroy() {
    this.client?.disconnect();
    this.view.destroy();
  }
}

// The length of the form that a text begins with.
export function endOfForm(text) {
  let depth = 0;
  const tokens = /;[^\n]*|"(?:\\[^]|[^"\\])*"|[([]|[)\]]|[^\s()[\]";]+|\s+/g;
  for (const { 0: token, index } of text.matchAll(tokens)) {
    if (token === "(" || token === "[") depth += 1;
    else if (token === ")" || token === "]") depth -= 1;
    else if (depth || /^[\s;]/.test(token)) continue;
    if (depth <= 0) return index + token.length;
  }
  return 0;
}
