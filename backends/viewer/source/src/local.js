// The playground's source of scenes: the interpreter in a worker, which is replaced when a program does not end.

const PATIENCE = 25000; // milliseconds after which a worker that does not answer is replaced

export class Local {
  constructor(base) {
    this.base = base;
    this.isLive = true;
    this.stores = false;
    this.heard = new Set();
    this.texts = {};
    this.names = [];
    this.lsp = {
      send: (message) => this.tell("lsp", [message]),
      subscribe: (handler) => this.heard.add(handler),
      unsubscribe: (handler) => this.heard.delete(handler),
    };
    this.current = this.hire();
  }

  // Starts a worker; it answers once the interpreter is loaded.
  hire() {
    const worker = new Worker(new URL("worker.js", this.base), { type: "module" });
    const hired = { worker, pending: new Map(), next: 0 };
    worker.addEventListener("message", ({ data }) => this.answered(hired, data));
    worker.addEventListener("error", (event) => this.failed(hired, event.message ?? "the worker could not be started"));
    return hired;
  }

  answered(hired, data) {
    if (data.lsp !== undefined) {
      if (hired === this.current) for (const handler of [...this.heard]) handler(data.lsp);
      return;
    }
    if (data.progress !== undefined) {
      if (hired === this.current && !this.isReady) this.onProgress?.(data.progress);
      return;
    }
    if (data.fatal !== undefined) {
      this.failed(hired, data.fatal);
      return;
    }
    const { resolve, reject, timer } = hired.pending.get(data.id) ?? {};
    if (!resolve) return;
    clearTimeout(timer);
    hired.pending.delete(data.id);
    if (data.error !== undefined) reject(new Error(data.error));
    else resolve(data.result);
  }

  failed(hired, message) {
    for (const { reject, timer } of hired.pending.values()) {
      clearTimeout(timer);
      reject(new Error(message));
    }
    hired.pending.clear();
  }

  ask(method, values, patience = PATIENCE) {
    const hired = this.current;
    return new Promise((resolve, reject) => {
      hired.next += 1;
      const timer = this.isReady ? setTimeout(() => hired === this.current && this.replace("the program did not end in time"), patience) : 0;
      hired.pending.set(hired.next, { resolve, reject, timer });
      hired.worker.postMessage({ id: hired.next, method, values });
    });
  }

  tell(method, values) {
    this.current.worker.postMessage({ method, values });
  }

  // Opens programs by name; the first question starts the interpreter.
  async open(texts, names) {
    this.texts = { ...texts };
    this.names = await this.ask("open", [texts, names]);
    this.isReady = true;
    setTimeout(() => { this.spare ??= this.hire(); }, 1500); // loaded while nothing happens, so that Stop costs nothing
  }

  // Ends what runs: the spare worker takes over, with the texts of before.
  stop() {
    return this.replace("stopped");
  }

  async replace(reason) {
    const old = this.current;
    this.current = this.spare ?? this.hire();
    this.spare = null;
    old.worker.terminate();
    this.failed(old, reason);
    this.isReady = false;
    await this.open(this.texts, this.names);
    this.onReplaced?.();
  }

  async files() {
    return this.names;
  }

  async text(file) {
    return { name: this.names[file], text: this.texts[this.names[file]] };
  }

  uri(file) {
    return `file:///scenes/${this.names[file]}`;
  }

  state(file) {
    return this.ask("state", [file]);
  }

  async picture(file) {
    const bytes = await this.ask("picture", [file]);
    return bytes.buffer;
  }

  edit(file, text) {
    if (text !== null) this.texts[this.names[file]] = text;
    return this.ask("edit", [file, text]);
  }

  set(file, name, value) {
    return this.ask("set", [file, name, value]);
  }

  change(file, text, change) {
    return this.ask("change", [file, text, change]);
  }

  literal(file, name, value, text) {
    return this.ask("literal", [file, name, value, text]);
  }

  export(file, kind) {
    return this.ask("export", [file, kind]);
  }

  watch(changed, connected) {
    connected(true);
  }
}
