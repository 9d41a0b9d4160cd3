// Path-traced still images of what the picture shows, made on request, with progress.
import { byId, el, fill } from "./dom.js";

const POLL = 400; // milliseconds between questions about the progress
const SIDE = 1600; // pixels of the longer side

export class Still {
  constructor(page) {
    this.page = page;
    this.isRunning = false;
    byId("render").addEventListener("click", () => this.start());
    byId("still-stop").addEventListener("click", () => this.stop());
    byId("still").addEventListener("close", () => this.stop());
  }

  async start() {
    const { page } = this;
    if (!page.packet?.box) {
      page.announce("there is no picture to render");
      return;
    }
    if (!byId("still").open) byId("still").showModal();
    if (this.isRunning) return;
    this.begin();
    try {
      const { png } = await page.server.still(page.file, page.editor.text, this.view());
      this.finish(png);
    } catch (error) {
      fill(byId("still-image"), el("p", { className: "error" }, error.message));
    }
    this.isRunning = false;
    byId("still-progress").hidden = byId("still-stop").hidden = true;
  }

  // The camera and the size of what is seen.
  view() {
    const { page } = this;
    const { clientWidth, clientHeight } = page.viewport;
    const ratio = Math.min(Math.min(devicePixelRatio, 2), SIDE / Math.max(clientWidth, clientHeight));
    return { camera: page.viewpoint.text(page.packet.box), frame: page.frame, width: Math.round(clientWidth * ratio), height: Math.round(clientHeight * ratio) };
  }

  begin() {
    this.isRunning = true;
    byId("still-progress").value = 0;
    byId("still-progress").hidden = byId("still-stop").hidden = false;
    byId("still-save").hidden = true;
    fill(byId("still-image"), el("p", { className: "quiet" }, "Rendering …"));
    this.follow();
  }

  async follow() {
    while (this.isRunning) {
      await new Promise((resolve) => setTimeout(resolve, POLL));
      if (!this.isRunning) return;
      const { progress } = await this.page.server.progress().catch(() => ({ progress: 0 }));
      byId("still-progress").value = progress;
    }
  }

  finish(png) {
    const { page } = this;
    const address = `data:image/png;base64,${png}`;
    const name = `${page.fileName.split("/").pop().replace(/\.scene$/, "")}.png`;
    fill(byId("still-image"), el("img", { src: address, alt: "The scene, path traced" }));
    const save = byId("still-save");
    save.href = address;
    save.download = name;
    save.hidden = false;
    save.focus();
  }

  stop() {
    if (this.isRunning) this.page.server.stop("still").catch((error) => this.page.announce(error.message));
  }
}
