// The page of the notebook's widget: a frame without rights, whose interpreter is the kernel. Questions go to the parent.
import { Studio } from "./studio.js";

class Kernel {
  constructor() {
    this.isLive = true;
    this.stores = false;
    this.heard = new Set();
    this.sent = new Set();
    this.pending = new Map();
    this.next = 0;
    this.lsp = {
      send: (message) => this.ask("lsp", [message]).catch(() => {}),
      subscribe: (handler) => this.heard.add(handler),
      unsubscribe: (handler) => this.heard.delete(handler),
    };
    addEventListener("message", ({ data, source }) => source === parent && this.answered(data));
  }

  answered({ id, result, error, bytes, lsp, text }) {
    if (lsp !== undefined) for (const handler of [...this.heard]) handler(lsp);
    if (text !== undefined && !this.sent.delete(text)) this.onText?.(text);
    const { resolve, reject } = this.pending.get(id) ?? {};
    this.pending.delete(id);
    if (error !== undefined) reject?.(new Error(error));
    else resolve?.(bytes ?? result);
  }

  ask(method, values) {
    this.next += 1;
    parent.postMessage({ id: this.next, method, values }, "*");
    return new Promise((resolve, reject) => this.pending.set(this.next, { resolve, reject }));
  }

  files() { return this.ask("files", []); }
  text(file) { return this.ask("text", [file]); }
  uri(file) { return this.uris[file]; }
  state(file) { return this.ask("state", [file]); }
  picture(file) { return this.ask("picture", [file]); }
  edit(file, text) {
    this.sent.add(text); // comes back as the widget's text, maybe after newer ones
    return this.ask("edit", [file, text]);
  }

  set(file, name, value) { return this.ask("set", [file, name, value]); }
  literal(file, name, value, text) { return this.ask("literal", [file, name, value, text]); }
  change(file, text, change) { return this.ask("change", [file, text, change]); }
  watch(changed, connected) { connected(true); }
}

class Widget extends Studio {
  select(path) {
    super.select(path);
    const spelled = path === null || !this.graph ? "" : this.graph.spelled(this.frame, path);
    this.server.ask("selected", [spelled]).catch(() => {});
  }
}

// Starts the page of a widget.
export async function startWidget() {
  document.body.classList.add("widget");
  const kernel = new Kernel();
  const page = new Widget(kernel);
  kernel.onText = (text) => { if (page.editor && text !== page.editor.text) page.editor.replace(text); };
  kernel.uris = await kernel.ask("uris", []);
  await page.start();
  return page;
}
