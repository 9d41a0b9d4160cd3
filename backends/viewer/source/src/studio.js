// The page with an editor: what is typed is evaluated at once, and the picture and the text show each other's selection.
import { Color } from "three";
import { Console } from "./console.js";
import { isTyping, showSheet } from "./controls.js";
import { showDiagnostics } from "./diagnostics.js";
import { byId, debounced, el, fill } from "./dom.js";
import { Editor } from "./editor.js";
import { Findings } from "./findings.js";
import { bothChanges, changeByKey, Gizmo, gridStep } from "./gizmo.js";
import { Measure } from "./measure.js";
import { Overlay } from "./overlay.js";
import { Page } from "./page.js";
import { Still } from "./still.js";
import { Tabs } from "./tabs.js";

const DRAFT = "scenelang-draft:"; // keys of the local store
const OTHER = "#other"; // ends the key of a draft of another window
const WINDOW = crypto.randomUUID?.() ?? String(Math.random()); // tells the windows apart that show the same file
const MOST_CELLS = 4e6; // of the table for a difference: 2,000 lines beside 2,000
const PATIENCE = 400; // milliseconds that an evaluation has before a newer text ends it
const SMALL = matchMedia("(max-width: 800px)");

export class Studio extends Page {
  async start() {
    document.body.classList.add("studio", "no-left"); // the tree lies over the details when it is asked for
    byId("toggle-left").setAttribute("aria-pressed", "false");
    this.drafts = draftsOf();
    this.overlay = new Overlay(byId("marks"));
    this.findings = new Findings(this);
    this.measure = new Measure(this);
    this.still = new Still(this);
    this.console = new Console((text) => this.server.evaluate(this.file, this.editor.text, text), () => this.server.stop("evaluate"));
    this.unsaved = new Set();
    this.views = new Map(); // of the tabs
    this.tabs = new Tabs(byId("tabs"), { choose: (file) => this.choose(file), closed: () => this.saveDraft(), isUnsaved: (file) => this.unsaved.has(file) });
    this.editor = new Editor(byId("code"), this.server.lsp, {
      changed: (text) => this.changed(text),
      cursor: (line, column) => this.cursorMoved(line, column),
      save: () => this.store(),
    });
    this.saveDraftLater = debounced(() => this.saveDraft(), 400);
    this.findLater = debounced((line, column) => this.selectAt(line, column), 150);
    listen(this);
    addEventListener("pagehide", () => this.saveDraft());
    await this.openFile(await this.firstFile());
    await super.start();
    if (!this.stage) return;
    this.gizmo = new Gizmo(this.viewpoint.camera, byId("canvas"), {
      redraw: () => this.draw(),
      preview: (offset) => this.preview(offset),
      change: (change) => this.changeSelection(change),
    });
  }

  // --- files

  async choose(file) {
    if (file === this.file) return;
    this.saveDraft();
    if (this.packet) this.views.set(this.file, [this.viewpoint.saved(), this.shown]);
    this.findings.clear();
    this.measure.turn(null);
    await this.openFile(file);
    byId("files").value = String(file);
    await super.choose(file);
    if (!this.views.has(file) || !this.packet || file !== this.file) return;
    const [view, shown] = this.views.get(file);
    this.viewpoint.take(view);
    this.moved();
    this.shown = shown;
  }

  // Opens the tabs of before, and those of drafts that were not saved; returns the file to begin with.
  async firstFile() {
    const names = await this.server.files();
    names.forEach((name, file) => {
      const draft = this.drafts.read(this.server.uri(file) ?? name);
      if (draft && draft.text !== draft.base) this.unsaved.add(file);
    });
    return this.tabs.restore(names, [...this.unsaved].map((file) => names[file])) ?? 0;
  }

  async listFiles() {
    await super.listFiles();
    this.tabs.take(await this.server.files());
  }

  // Shows a file's text, or the draft that was left of it.
  async openFile(file) {
    this.file = file;
    this.wantedText = null; // what was typed last into another file is in its draft
    const { name, text } = await this.server.text(file);
    if (file !== this.file) return;
    this.fileName = name;
    this.tabs.show(file);
    const draft = this.drafts.read(this.draftName);
    const isNewer = draft !== null && draft.text !== text;
    this.hasTyped = false;
    if (draft) this.drafts.adopt(this.draftName, draft.text);
    this.disk = isNewer ? draft.base : text; // until the question is answered, saving is refused
    this.editor.open(isNewer ? draft.text : text, this.server.uri(file), isNewer || draft?.text === text ? draft?.state : null);
    this.conflict(isNewer && draft.base !== text ? text : null);
    this.showDirty();
    this.offerDraft(this.drafts.other(this.draftName));
    await this.server.edit(file, this.editor.text); // what another page of this server showed may differ
  }

  // A change on disk, of the file or of one that it imports.
  async fileChanged() {
    await this.lookAtDisk();
    if (!this.isEvaluating) this.changed(this.editor.text);
  }

  async create(name) {
    try {
      const { file } = await this.server.create(name);
      await this.listFiles();
      await this.choose(file);
    } catch (error) {
      this.announce(error.message);
      byId("new-name").value = name;
      byId("naming").returnValue = "";
      byId("naming").showModal();
    }
  }

  // The name under which drafts of the shown file are kept.
  get draftName() {
    return this.server.uri(this.file) ?? this.fileName;
  }

  get isDirty() {
    return this.editor.text !== this.disk;
  }

  showDirty() {
    document.body.classList.toggle("dirty", this.isDirty);
    byId("store").disabled = !this.isDirty || !this.server.stores;
    if (this.unsaved.has(this.file) === this.isDirty) return;
    if (this.isDirty) this.unsaved.add(this.file);
    else this.unsaved.delete(this.file);
    this.tabs.mark(this.file);
  }

  saveDraft() {
    if (!this.hasTyped) return; // another page may have a draft that is newer
    this.drafts.write(this.draftName, { text: this.editor.text, base: this.disk, state: this.editor.saved() });
  }

  async store() {
    if (!this.server.stores) {
      this.download(new Blob([this.editor.text], { type: "text/plain" }), this.fileName.split("/").pop());
      return;
    }
    const { text } = this.editor;
    try {
      await this.server.store(this.file, text, this.disk);
      this.disk = text;
      this.announce("saved");
      this.saveDraft();
    } catch (error) {
      this.announce(error.message);
      await this.lookAtDisk();
    }
    this.showDirty();
  }

  // A file that changed on disk: an unchanged text follows it, a changed one is kept and the difference is shown.
  async lookAtDisk() {
    const { text } = await this.server.text(this.file);
    if (text === this.disk) return;
    if (!this.isDirty) {
      this.disk = text;
      this.editor.replace(text);
    } else if (text === this.editor.text) this.disk = text;
    else this.conflict(text);
    this.showDirty();
  }

  conflict(text) {
    if (text === null) byId("conflict").hidden = true;
    else this.askWhich("The file on disk is another than the one that this text was made from.", text, "Take the file", () => { this.disk = text; });
  }

  // A draft that another window left of this file.
  offerDraft(draft) {
    if (draft === null || draft.text === this.editor.text || draft.text === this.disk || !byId("conflict").hidden) return;
    const { draftName } = this;
    this.askWhich("Another window left another text of this file.", draft.text, "Take that text", () => this.drafts.forget(draftName));
  }

  // Shows how another text differs from this one, to take it or to keep this one; `decided` is called for both.
  askWhich(question, text, take, decided) {
    const bar = byId("conflict");
    const close = () => {
      decided();
      this.hasTyped = true;
      this.saveDraft();
      bar.hidden = true;
      this.showDirty();
    };
    bar.hidden = false;
    fill(
      bar,
      el("p", {}, question),
      el("pre", {}, ...differenceOf(text, this.editor.text)),
      el("button", { onclick: () => { this.editor.replace(text); close(); } }, take),
      el("button", { onclick: close }, "Keep this text"),
    );
  }

  download(blob, name) {
    const link = el("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  // --- evaluation: while one runs, only the newest text waits

  changed(text) {
    this.hasTyped = true;
    if (text !== this.examined) this.forgetFindings();
    if (this.offered && text !== this.offered.text) this.offer(null);
    this.showDirty();
    this.saveDraftLater();
    this.wantedText = text;
    this.typedAt ??= performance.now();
    if (!this.isEvaluating) this.evaluate();
    else if (this.server.stores && performance.now() - this.startedAt > PATIENCE) this.server.stop();
  }

  async evaluate() {
    this.isEvaluating = true;
    const busy = setTimeout(() => { byId("busy").hidden = false; byId("stop").hidden = false; }, 300);
    while (this.wantedText !== null && this.wantedText !== undefined) {
      const [text, { file }] = [this.wantedText, this];
      this.wantedText = null;
      this.startedAt = performance.now();
      try {
        const state = await this.server.edit(file, text);
        if (this.wantedText === null && file === this.file) await this.takeState(state);
      } catch (error) {
        this.announce(error.message);
      }
    }
    clearTimeout(busy);
    byId("busy").hidden = byId("stop").hidden = true;
    this.isEvaluating = false;
    if (this.typedAt) document.body.dataset.latency = String(Math.round(performance.now() - this.typedAt));
    this.typedAt = undefined;
  }

  // Errors and warnings, with buttons for their fixes.
  showProblems(state) {
    const actions = { apply: (edits) => this.applyEdits(edits), number: () => null, closed: () => {} };
    showDiagnostics(byId("diagnostics"), state.diagnostics, state.picture !== null, actions);
  }

  async takeState(state) {
    await super.takeState(state);
    const errors = state.diagnostics.filter((d) => d.severity === "error").length;
    byId("verdict").textContent = errors ? counted(errors, "error") : counted(state.diagnostics.length, "hint");
    byId("verdict").className = errors ? "error" : "";
    document.body.classList.toggle("wrong", errors > 0);
    if (this.examined === this.editor.text) this.showFindings();
  }

  takePacket(packet) {
    if (this.nextSelection) this.selection = this.nextSelection;
    this.nextSelection = null;
    super.takePacket(packet);
    this.measure.stale();
  }

  // A param is written into the text, where undo reaches it.
  async setParam(name, value) {
    if (value === null || value === undefined) return;
    try {
      const { start, end, text } = await this.server.literal(this.file, name, value, this.editor.text);
      if (this.isEvaluating || this.wantedText) return;
      const [from, to] = [this.offset(start), this.offset(end)];
      this.editor.view.dispatch({ changes: { from, to, insert: text }, userEvent: "input.param" });
    } catch (error) {
      this.announce(error.message);
    }
  }

  // A position in characters, as Python counts them, in JavaScript's units.
  offset(position) {
    const { text } = this.editor;
    let at = 0;
    for (let i = 0; i < position; i += 1) at += text.codePointAt(at) > 0xffff ? 2 : 1;
    return at;
  }

  // --- changes of objects in the picture

  // Changes the selected object by an edit of the program, which the interpreter proves to change nothing else.
  async changeSelection(change) {
    const precision = this.packet.box ? gridStep(this.packet.box.scale) / 10 : 0; // of numbers that the edit writes
    const request = { path: this.graph.spelled(this.frame, this.selection), precision, ...change };
    const { text } = this.editor;
    this.offer(null);
    byId("busy").hidden = false;
    try {
      const result = await this.server.change(this.file, text, request);
      if (this.editor.text !== text) return;
      if (change.duplicate) this.nextSelection = [...this.selection.slice(0, -1), this.selection.at(-1) + 1]; // the copy
      this.editor.replace(result.text);
      this.announce(result.instances > 1 ? `changed ${result.instances} objects in line ${result.line}` : `changed line ${result.line}`);
    } catch (error) {
      this.announce(error.message);
      this.showSelection();
    } finally {
      byId("busy").hidden = true;
    }
    if (!change.rename) await this.offerShared(text, request);
  }

  // Offers the same change of all objects that share the number or form, where there is one.
  async offerShared(text, request) {
    const { file } = this;
    const now = this.editor.text;
    try {
      const result = await this.server.change(file, text, { ...request, shared: true });
      if (result.text && result.text !== now && this.editor.text === now && this.file === file) this.offer(result, now);
    } catch (error) {
      this.announce(error.message);
    }
  }

  offer(result, text = "") {
    byId("shared").hidden = !result;
    this.offered = result && { result, text };
    if (result) byId("shared-count").textContent = `${counted(result.others, "other part")} in line ${result.line}`;
  }

  takeOffer() {
    const { offered } = this;
    this.offer(null);
    if (!offered || this.editor.text !== offered.text) return;
    this.editor.replace(offered.result.text);
    this.announce(`changed all in line ${offered.result.line}`);
  }

  // Adds a copy of the selected object beside it.
  duplicate() {
    const box = this.selection?.length ? this.selectionBox() : null;
    if (!box) return;
    const { scale } = this.packet.box;
    const size = box.high.map((high, i) => (high - box.low[i]) / scale);
    const step = 1.1 * (size[0] || size[2] || Math.max(...size));
    this.changeSelection({ duplicate: [Number(step.toPrecision(2)), 0, 0] });
  }

  // Asks for another word of the selected object: for all that are called so, or in place of this one's.
  askWord() {
    if (!this.selection?.length) return;
    const node = this.graph.nodesOn(this.frame, this.selection).at(-1);
    fill(byId("known-words"), ...this.words.counts.map(([word]) => el("option", { value: word })));
    const isBound = this.graph.places(node).definition.length > 0;
    for (const choice of document.querySelectorAll('input[name="renamed"]')) choice.checked = choice.value === (isBound ? "rename" : "word");
    byId("new-word").value = this.graph.word(node);
    byId("renaming").returnValue = "";
    byId("renaming").showModal();
    byId("new-word").select();
  }

  takeWord() {
    const word = byId("new-word").value.trim();
    const kind = document.querySelector('input[name="renamed"]:checked').value;
    if (byId("renaming").returnValue === "change" && word) this.changeSelection({ [kind]: word });
  }

  // Shows what is wrong with the scene's geometry, with edits that were tried.
  async examine() {
    const { text } = this.editor;
    const { file } = this;
    byId("busy").hidden = false;
    try {
      const { diagnostics } = await this.server.examine(file, text);
      if (this.editor.text !== text || file !== this.file) return;
      this.examined = text;
      this.findings.take(diagnostics);
      this.showFindings();
      if (!diagnostics.length) this.announce("nothing floats, overlaps or is hidden");
    } catch (error) {
      this.announce(error.message);
    } finally {
      byId("busy").hidden = true;
    }
  }

  showFindings() {
    showDiagnostics(byId("diagnostics"), this.findings.items, true, {
      apply: (edits) => this.applyEdits(edits),
      number: (index) => this.findings.number(index),
      highlight: (index) => this.findings.highlight(index),
      select: (index) => this.findings.select(index),
      closed: () => this.forgetFindings(),
    });
  }

  forgetFindings() {
    this.examined = null;
    this.findings.clear();
  }

  // Selects a finding from the picture: its row in the list comes into view.
  chooseFinding(index) {
    this.findings.select(index);
    const row = byId("diagnostics").querySelector(`[data-finding="${index}"]`);
    row?.scrollIntoView({ block: "nearest" });
    row?.focus({ preventScroll: true });
  }

  applyEdits(edits) {
    this.editor.edit(edits.map(({ start, end, text }) => ({ from: this.offset(start), to: this.offset(end), insert: text })));
    byId("diagnostics").hidden = true;
  }

  // Changes the selected object by a key that is pressed at the button of a mode; keys add up while a change is made.
  async changeByKey(mode, event) {
    const change = this.packet?.box && changeByKey(mode, event.key, event.shiftKey, this.packet.box.scale);
    if (!change) return;
    event.preventDefault();
    this.nextChange = bothChanges(this.nextChange, change);
    if (this.isChanging) return;
    this.isChanging = true;
    while (this.nextChange) {
      const next = this.nextChange;
      this.nextChange = null;
      await this.changeSelection(next);
    }
    this.isChanging = false;
  }

  preview(offset) {
    const box = offset && this.selectionBox();
    if (!box) return;
    const { scale } = this.packet.box;
    const moved = (corner) => corner.map((value, i) => value + offset[i] * scale);
    this.stage.outline.box.min.set(...moved(box.low));
    this.stage.outline.box.max.set(...moved(box.high));
    this.announce(`move ${offset.join(" ")}`);
  }

  setMode(mode) {
    this.gizmoMode = mode;
    for (const button of document.querySelectorAll("#tools [data-mode]")) button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
    this.showGizmo();
    this.draw();
  }

  showGizmo() {
    const box = this.selection?.length ? this.selectionBox() : null;
    byId("tools").hidden = !box;
    if (!this.gizmo) return;
    if (!box || !this.gizmoMode) this.gizmo.hide();
    else this.gizmo.show(this.gizmoMode, box.low.map((low, i) => (low + box.high[i]) / 2), this.packet.box.scale);
  }

  // --- selection: the outermost named object first, then inward

  select(path) {
    super.select(path);
    if (this.measure?.mode === "objects" && this.packet && !this.fromText) this.measure.take(path);
  }

  showFrame() {
    super.showFrame();
    this.findings.draw();
    this.measure.stale();
  }

  escape() {
    if (this.measure.mode) this.measure.turn(null);
    else super.escape();
  }

  get ownKeys() {
    return { m: () => byId("measure").click() };
  }

  // Selects what is clicked; `isSecond` measures from the selection to it.
  pick(x, y, isSecond) {
    if (!this.instances?.ready) return;
    if (this.measure.mode === "points") {
      this.measure.click(x, y);
      return;
    }
    if (isSecond && this.measure.mode === null) this.measure.turn("objects");
    const leaf = this.stage.pick(this.viewpoint, x, y);
    const path = leaf === null ? null : this.graph.pathOfLeaf(this.frame, leaf);
    this.select(path === null ? null : this.inward(path));
    this.draw();
  }

  // The ancestor of a clicked primitive that is one step inside the selection, or the outermost object below the root.
  inward(path) {
    const { selection } = this;
    const isInside = selection !== null && selection.length && selection.length < path.length && selection.every((step, i) => step === path[i]);
    let depth = isInside ? selection.length + 1 : 1;
    while (depth < path.length && this.sizeAt(path, depth - 1) === 1) depth += 1;
    return path.slice(0, Math.max(1, depth));
  }

  // How many children the node at a depth of a path has: one that has a single child is only a wrapper.
  sizeAt(path, depth) {
    return this.graph.size(this.graph.nodesOn(this.frame, path.slice(0, depth)).at(-1));
  }

  showSelection() {
    super.showSelection();
    this.showGizmo();
    const nodes = this.selection && this.graph ? this.graph.nodesOn(this.frame, this.selection) : null;
    this.showBreadcrumb(nodes);
    const places = nodes ? this.nearestPlaces(nodes) : [];
    this.editor?.mark(places, this.selection !== null && !this.fromText);
    byId("recolor").value = hexOf(nodes && this.graph.attribute(nodes.at(-1), "color"));
  }

  // Where this file makes the innermost of some nodes: of imported words it has the calls only.
  nearestPlaces(nodes) {
    for (const node of nodes.slice(1).reverse()) {
      const places = this.placesOf(node);
      const forms = places.length ? places : this.editor.callsOf(this.graph.word(node));
      if (forms.length) return forms;
    }
    return this.placesOf(nodes[0]);
  }

  placesOf(node) {
    const { calls, definition } = this.graph.places(node);
    return (calls.length ? calls : definition).filter((place) => place.file.endsWith(this.fileName)).map((place) => [place.line, place.column]);
  }

  showBreadcrumb(nodes) {
    const bar = byId("breadcrumb");
    bar.hidden = !nodes;
    if (!nodes) return;
    const { selection } = this;
    fill(bar, ...nodes.map((node, i) => el("button", { "aria-current": i === selection.length ? "true" : null, onclick: () => this.select(selection.slice(0, i)) }, this.graph.word(node))));
    bar.scrollTop = bar.scrollHeight; // the selected object is at the end
  }

  cursorMoved(line, column) {
    this.findLater(line, column);
  }

  // Selects the first instance that the form around the cursor made.
  selectAt(line, column) {
    if (!this.graph || this.isEvaluating) return;
    const path = this.graph.pathMadeAt(this.frame, this.fileName, line, column);
    if (path === null) return;
    this.fromText = true;
    this.select(path);
    this.fromText = false;
  }
}

// A number of things, nothing for none.
function counted(number, noun) {
  return number ? `${number} ${noun}${number === 1 ? "" : "s"}` : "";
}

// Drafts in the browser's local store, so that a reload or a crash loses nothing.
function draftsOf() {
  const key = (name) => `${DRAFT}${name}`;
  const kept = new Map(); // what the store did not take
  const adopted = new Map(); // texts that this window took over when it opened a file
  const stored = (name) => {
    try {
      return JSON.parse(localStorage.getItem(key(name)));
    } catch {
      return null;
    }
  };
  return {
    read(name) {
      return kept.has(name) ? kept.get(name) : stored(name);
    },
    // What another window left, since a later one wrote a draft of the same file; null if there is none.
    other(name) {
      return stored(`${name}${OTHER}`);
    },
    adopt(name, text) {
      adopted.set(name, text);
    },
    forget(name) {
      try {
        localStorage.removeItem(`${key(name)}${OTHER}`);
      } catch { /* no store */ }
    },
    write(name, given) {
      const draft = { ...given, window: WINDOW };
      kept.delete(name);
      const before = this.read(name);
      const isOwn = !before || before.window === WINDOW || before.text === adopted.get(name);
      if (!isOwn && before.text !== draft.text && before.text !== before.base) {
        try {
          localStorage.setItem(`${key(name)}${OTHER}`, JSON.stringify({ ...before, state: null }));
        } catch { /* no store */ }
      }
      try {
        localStorage.setItem(key(name), JSON.stringify(draft));
      } catch {
        try {
          localStorage.setItem(key(name), JSON.stringify({ ...draft, state: null })); // a long history does not fit
        } catch {
          kept.set(name, draft); // no store: the text is in the page only
        }
      }
    },
  };
}

// The lines in which two texts differ, as elements, by the longest common subsequence; equal ends are left out.
function differenceOf(old, now) {
  let [a, b] = [old.split("\n"), now.split("\n")];
  let start = 0;
  while (start < a.length && start < b.length && a[start] === b[start]) start += 1;
  let end = 0;
  while (end < a.length - start && end < b.length - start && a.at(-1 - end) === b.at(-1 - end)) end += 1;
  [a, b] = [a.slice(start, a.length - end), b.slice(start, b.length - end)];
  return editsOf(a, b).map(([sign, line]) => el("span", { className: { "-": "removed", "+": "added", " ": "" }[sign] }, `${sign} ${line}\n`));
}

// Lines that are removed (-), added (+) or equal; texts of many lines are removed and added as a whole.
function editsOf(a, b) {
  if (a.length * b.length > MOST_CELLS) return [...a.map((line) => ["-", line]), ...b.map((line) => ["+", line])];
  const width = b.length + 1;
  const common = new Uint32Array((a.length + 1) * width); // of the lines from here on
  for (let i = a.length - 1; i >= 0; i -= 1) {
    for (let j = b.length - 1; j >= 0; j -= 1) {
      common[i * width + j] = a[i] === b[j] ? common[(i + 1) * width + j + 1] + 1 : Math.max(common[(i + 1) * width + j], common[i * width + j + 1]);
    }
  }
  const edits = [];
  let [i, j] = [0, 0];
  while (i < a.length || j < b.length) {
    if (i < a.length && j < b.length && a[i] === b[j]) {
      edits.push([" ", a[i]]);
      i += 1;
      j += 1;
    } else if (j === b.length || (i < a.length && common[(i + 1) * width + j] >= common[i * width + j + 1])) {
      edits.push(["-", a[i]]);
      i += 1;
    } else {
      edits.push(["+", b[j]]);
      j += 1;
    }
  }
  return edits;
}

// A linear color such as "[1.0 0.12 0.06]" as the color field has it; gray for another text.
function hexOf(text) {
  const parts = /^\[([\d.e+-]+) ([\d.e+-]+) ([\d.e+-]+)\]$/.exec(text ?? "");
  if (!parts) return "#808080";
  return `#${new Color(...parts.slice(1).map(Number)).getHexString()}`;
}

function listen(page) {
  const on = (id, action) => byId(id)?.addEventListener("click", action);
  on("store", () => page.store());
  on("create", () => { byId("new-name").value = ""; byId("naming").showModal(); });
  byId("naming").addEventListener("close", () => { if (byId("naming").returnValue === "create" && byId("new-name").value) page.create(byId("new-name").value); });
  on("format", () => page.editor.format());
  on("examine", () => page.examine());
  on("stop", () => page.server.stop());
  on("duplicate", () => page.duplicate());
  on("rename", () => page.askWord());
  byId("renaming").addEventListener("close", () => page.takeWord());
  for (const id of ["toggle-console", "sheet-console"]) on(id, () => showConsole(byId("console").hidden));
  for (const button of document.querySelectorAll("#sheets [data-sheet]")) button.addEventListener("click", () => SMALL.matches && showConsole(false));
  document.addEventListener("keydown", (event) => changesByKey(page, event));
  on("shared-all", () => page.takeOffer());
  on("shared-one", () => page.offer(null));
  on("remove", () => page.changeSelection({ remove: true }));
  byId("recolor").addEventListener("change", (event) => page.changeSelection({ recolor: `(color "${event.target.value}")` }));
  for (const button of document.querySelectorAll("#tools [data-mode]")) {
    const { mode } = button.dataset;
    button.addEventListener("click", () => page.setMode(page.gizmoMode === mode ? null : mode));
    button.addEventListener("keydown", (event) => page.changeByKey(mode, event));
  }
  showSheet(SMALL.matches ? "code" : "");
}

// Keys that change the selected object while nothing is typed: Ctrl+D and F2.
function changesByKey(page, event) {
  if (isTyping(event) || event.target.closest("dialog") || !page.selection?.length) return;
  if (event.key === "F2") page.askWord();
  else if (event.key.toLowerCase() === "d" && (event.ctrlKey || event.metaKey)) page.duplicate();
  else return;
  event.preventDefault();
}

function showConsole(isShown) {
  byId("console").hidden = !isShown;
  for (const id of ["toggle-console", "sheet-console"]) byId(id).setAttribute("aria-pressed", String(isShown));
  if (!isShown) return;
  if (SMALL.matches && document.body.dataset.sheet) showSheet(document.body.dataset.sheet); // one panel at a time
  byId("expression").focus();
}
