// Where scenes come from: the server of `scenelang view`, or what stands in a page that was saved.

export class Server {
  constructor() {
    this.isLive = true;
  }

  async files() {
    return (await this.json("files")).files;
  }

  state(file) {
    return this.json(`state?file=${file}`);
  }

  async picture(file, version) {
    const response = await fetch(`picture?file=${file}&version=${version}`);
    if (!response.ok) throw new Error("the scene did not arrive");
    return response.arrayBuffer();
  }

  set(file, name, value) {
    return this.post("set", { file, name, value });
  }

  save(file, name) {
    return this.post("save", { file, name });
  }

  // Calls `changed(file)` when a file's state is new, `connected(flag)` when the server goes or comes back.
  watch(changed, connected) {
    const events = new EventSource("events");
    events.addEventListener("change", (event) => changed(JSON.parse(event.data).file));
    events.addEventListener("open", () => connected(true));
    events.addEventListener("error", () => connected(false));
  }

  async json(path) {
    const response = await fetch(path);
    if (!response.ok) throw new Error(`the server answered ${response.status}`);
    return response.json();
  }

  async post(path, data) {
    const response = await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data) });
    const answer = await response.json();
    if (!response.ok) throw new Error(answer.message ?? `the server answered ${response.status}`);
    return answer;
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
