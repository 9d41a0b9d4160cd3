// The page with an editor: what is typed is evaluated at once, and the picture and the text show each other's selection.
import { showSheet } from "./controls.js";
import { showDiagnostics } from "./diagnostics.js";
import { byId, debounced, el, fill } from "./dom.js";
import { Editor } from "./editor.js";
import { Gizmo } from "./gizmo.js";
import { Page } from "./page.js";

const DRAFT = "scenelang-draft:"; // keys of the local store
const PATIENCE = 400; // milliseconds that an evaluation has before a newer text ends it
const SMALL = matchMedia("(max-width: 800px)");

export class Studio extends Page {
  async start() {
    document.body.classList.add("studio", "no-left"); // the tree lies over the details when it is asked for
    byId("toggle-left").setAttribute("aria-pressed", "false");
    this.drafts = draftsOf();
    this.editor = new Editor(byId("code"), this.server.lsp, {
      changed: (text) => this.changed(text),
      cursor: (line, column) => this.cursorMoved(line, column),
      save: () => this.store(),
    });
    this.saveDraftLater = debounced(() => this.saveDraft(), 400);
    this.findLater = debounced((line, column) => this.selectAt(line, column), 150);
    listen(this);
    addEventListener("pagehide", () => this.saveDraft());
    await this.openFile(0);
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
    this.saveDraft();
    await this.openFile(file);
    await super.choose(file);
  }

  // Shows a file's text, or the draft that was left of it.
  async openFile(file) {
    this.file = file;
    const { name, text } = await this.server.text(file);
    this.fileName = name;
    const draft = this.drafts.read(this.server.uri(file) ?? name);
    const isNewer = draft !== null && draft.text !== text;
    this.hasTyped = false;
    this.disk = isNewer ? draft.base : text; // until the question is answered, saving is refused
    this.editor.open(isNewer ? draft.text : text, this.server.uri(file), isNewer || draft?.text === text ? draft?.state : null);
    this.conflict(isNewer && draft.base !== text ? text : null);
    this.showDirty();
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
      byId("files").value = String(file);
    } catch (error) {
      this.announce(error.message);
    }
  }

  get isDirty() {
    return this.editor.text !== this.disk;
  }

  showDirty() {
    document.body.classList.toggle("dirty", this.isDirty);
    byId("store").disabled = !this.isDirty || !this.server.stores;
  }

  saveDraft() {
    if (!this.hasTyped) return; // another page may have a draft that is newer
    this.drafts.write(this.server.uri(this.file) ?? this.fileName, { text: this.editor.text, base: this.disk, state: this.editor.saved() });
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
    const bar = byId("conflict");
    bar.hidden = text === null;
    if (text === null) return;
    fill(
      bar,
      el("p", {}, "The file on disk is another than the one that this text was made from."),
      el("pre", {}, ...differenceOf(text, this.editor.text)),
      el("button", { onclick: () => { this.disk = text; this.editor.replace(text); this.conflict(null); this.showDirty(); } }, "Take the file"),
      el("button", { onclick: () => { this.disk = text; this.conflict(null); this.showDirty(); } }, "Keep this text"),
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
      const text = this.wantedText;
      this.wantedText = null;
      this.startedAt = performance.now();
      try {
        const state = await this.server.edit(this.file, text);
        if (this.wantedText === null) await this.takeState(state);
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

  async takeState(state) {
    await super.takeState(state);
    const errors = state.diagnostics.filter((d) => d.severity === "error").length;
    byId("verdict").textContent = errors ? `${errors} ${errors === 1 ? "error" : "errors"}` : state.diagnostics.length ? `${state.diagnostics.length} hints` : "";
    byId("verdict").className = errors ? "error" : "";
    document.body.classList.toggle("wrong", errors > 0);
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
    const path = this.graph.spelled(this.frame, this.selection);
    const { text } = this.editor;
    byId("busy").hidden = false;
    try {
      const result = await this.server.change(this.file, text, { path, ...change });
      if (this.editor.text !== text) return;
      this.editor.replace(result.text);
      this.announce(result.instances > 1 ? `changed ${result.instances} objects in line ${result.line}` : `changed line ${result.line}`);
    } catch (error) {
      this.announce(error.message);
      this.showSelection();
    } finally {
      byId("busy").hidden = true;
    }
  }

  // Shows what is wrong with the scene's geometry, with edits that were tried.
  async examine() {
    const { text } = this.editor;
    byId("busy").hidden = false;
    try {
      const { diagnostics } = await this.server.examine(this.file, text);
      if (this.editor.text !== text) return;
      showDiagnostics(byId("diagnostics"), diagnostics, true, (edits) => this.applyEdits(edits));
      if (!diagnostics.length) this.announce("nothing floats, overlaps or is hidden");
    } catch (error) {
      this.announce(error.message);
    } finally {
      byId("busy").hidden = true;
    }
  }

  applyEdits(edits) {
    this.editor.edit(edits.map(({ start, end, text }) => ({ from: this.offset(start), to: this.offset(end), insert: text })));
    byId("diagnostics").hidden = true;
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

  pick(x, y) {
    if (!this.instances?.ready) return;
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
    const places = nodes ? this.placesOf(nodes.at(-1)) : [];
    this.editor?.mark(places, this.selection !== null && !this.fromText);
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

// Drafts in the browser's local store, so that a reload or a crash loses nothing.
function draftsOf() {
  const key = (name) => `${DRAFT}${name}`;
  return {
    read(name) {
      try {
        return JSON.parse(localStorage.getItem(key(name)));
      } catch {
        return null;
      }
    },
    write(name, draft) {
      try {
        localStorage.setItem(key(name), JSON.stringify(draft));
      } catch {
        try {
          localStorage.setItem(key(name), JSON.stringify({ ...draft, state: null })); // a long history does not fit
        } catch { /* no store: the text is in the page only */ }
      }
    },
  };
}

// The lines in which two texts differ, as elements; what is equal at both ends is left out.
function differenceOf(old, now) {
  const [a, b] = [old.split("\n"), now.split("\n")];
  let start = 0;
  while (start < a.length && start < b.length && a[start] === b[start]) start += 1;
  let end = 0;
  while (end < a.length - start && end < b.length - start && a.at(-1 - end) === b.at(-1 - end)) end += 1;
  const rows = (lines, sign, name) => lines.slice(start, lines.length - end).map((line) => el("span", { className: name }, `${sign} ${line}\n`));
  return [...rows(a, "-", "removed"), ...rows(b, "+", "added")];
}

function listen(page) {
  const on = (id, action) => byId(id)?.addEventListener("click", action);
  on("store", () => page.store());
  on("create", () => { byId("new-name").value = ""; byId("naming").showModal(); });
  byId("naming").addEventListener("close", () => { if (byId("naming").returnValue === "create" && byId("new-name").value) page.create(byId("new-name").value); });
  on("format", () => page.editor.format());
  on("examine", () => page.examine());
  on("stop", () => page.server.stop());
  on("remove", () => page.changeSelection({ remove: true }));
  byId("recolor").addEventListener("change", (event) => page.changeSelection({ recolor: `(color "${event.target.value}")` }));
  for (const button of document.querySelectorAll("#tools [data-mode]")) button.addEventListener("click", () => page.setMode(page.gizmoMode === button.dataset.mode ? null : button.dataset.mode));
  showSheet(SMALL.matches ? "code" : "");
}
