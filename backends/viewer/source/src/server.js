// Where scenes come from: the server of `scenelang view`, or what stands in a page that was saved.

import { withChanges } from "./packet.js";

export class Server {
  constructor() {
    this.isLive = true;
    this.last = null; // the last picture: its file, version and bytes
  }

  async files() {
    const { files, uris } = await this.json("files");
    this.uris = uris;
    return files;
  }

  state(file) {
    return this.json(`state?file=${file}`);
  }

  // The packet of a scene. If the last one is of the same file, only the changes are sent.
  async picture(file) {
    const { last } = this;
    const has = last?.file === file ? `&has=${last.version}` : "";
    const response = await fetch(`picture?file=${file}${has}`);
    if (!response.ok) throw new Error("the scene did not arrive");
    const bytes = withChanges(last?.bytes, await response.arrayBuffer());
    this.last = { file, version: JSON.parse(response.headers.get("ETag")), bytes };
    return bytes;
  }

  set(file, name, value) {
    return this.post("set", { file, name, value });
  }

  // --- for the studio

  get stores() {
    return true;
  }

  text(file) {
    return this.json(`text?file=${file}`);
  }

  uri(file) {
    return this.uris[file];
  }

  edit(file, text) {
    return this.post("edit", { file, text });
  }

  store(file, text, before) {
    return this.post("store", { file, text, before });
  }

  change(file, text, change) {
    return this.post("change", { file, text, change });
  }

  create(name) {
    return this.post("create", { name });
  }

  examine(file, text) {
    return this.post("examine", { file, text });
  }

  gap(file, text, change) {
    return this.post("gap", { file, text, change });
  }

  evaluate(file, text, expression) {
    return this.post("evaluate", { file, text, change: { expression } });
  }

  still(file, text, view) {
    return this.post("still", { file, text, change: view });
  }

  progress() {
    return this.json("progress");
  }

  // Ends the evaluation that runs, or what a tool does.
  stop(what = "edit") {
    return this.post("stop", { what });
  }

  literal(file, name, value, text) {
    return this.post("literal", { file, name, value, text });
  }

  // The language server: messages go by requests, one after the other, and come with the events.
  get lsp() {
    this.heard ??= new Set();
    return {
      send: (message) => { this.sent = (this.sent ?? Promise.resolve()).then(() => this.post("lsp", { client: this.client, message })).catch(() => {}); },
      subscribe: (handler) => this.heard.add(handler),
      unsubscribe: (handler) => this.heard.delete(handler),
    };
  }

  save(file, name) {
    return this.post("save", { file, name });
  }

  // Calls `changed(file)` when a file's state is new, `connected(flag)` when the server goes or comes back.
  watch(changed, connected) {
    const open = () => {
      this.events = new EventSource(this.client ? `events?client=${this.client}` : "events");
      this.events.addEventListener("lsp", (event) => this.heard?.forEach((handler) => handler(event.data)));
      this.events.addEventListener("change", (event) => changed(JSON.parse(event.data).file));
      this.events.addEventListener("open", () => connected(true));
      this.events.addEventListener("error", () => connected(false));
    };
    open();
    // A browser keeps six connections to a server, so a page that is not seen gives its own up.
    document.addEventListener("visibilitychange", () => {
      this.events.close();
      if (!document.hidden) {
        open();
        changed(null);
      }
    });
  }

  async json(path) {
    const response = await reached(path);
    if (!response.ok) throw new Error(`the server answered ${response.status}`);
    return response.json();
  }

  async post(path, data) {
    const response = await reached(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data) });
    const answer = await response.json();
    if (!response.ok) throw new Error(answer.hint ? `${answer.message}; ${answer.hint}` : answer.message ?? `the server answered ${response.status}`);
    return answer;
  }
}

// The answer to a request; a server that has ended is said in words.
async function reached(path, options) {
  try {
    return await fetch(path, options);
  } catch {
    throw new Error("the server does not answer: what is typed stays in this browser as a draft");
  }
}

// A page that was saved: its scenes stand in it, compressed.
export class Saved {
  constructor(element) {
    this.isLive = false;
    this.scenes = JSON.parse(element.textContent);
  }

  async files() {
    return this.scenes.map((scene) => scene.name);
  }

  async state(file) {
    return this.scenes[file].state;
  }

  async picture(file) {
    const bytes = Uint8Array.from(atob(this.scenes[file].picture), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }

  watch() {}
}
