// The playground: the studio's page with the interpreter in the browser, examples, links and downloads.
import { byId, el, fill } from "./dom.js";
import { Local } from "./local.js";
import { decodeText, encodeText } from "./share.js";
import { Studio } from "./studio.js";

const FIRST = "chessboard.scene";
const FRAMED = new URLSearchParams(location.search).has("embed");

// A short name for a text.
function hashOf(text) {
  let hash = 5381;
  for (let i = 0; i < text.length; i += 1) hash = ((hash * 33) ^ text.charCodeAt(i)) >>> 0;
  return hash.toString(36);
}

class Playground extends Studio {
  async begin() {
    this.say("Loading the interpreter …");
    this.server.onProgress = (step) => this.say(step === "modules" ? "Evaluating …" : "Loading the language …");
    this.server.onReplaced = () => {
      this.shownVersion = undefined; // the next worker counts its pictures from the beginning
      this.editor?.reconnect();
      this.announce("the program was stopped");
    };
    this.examples = await (await fetch("examples.json")).json();
    const { name, text } = await this.fromAddress();
    const others = Object.fromEntries(this.examples.map((example) => [example.name, example.text]));
    await this.server.open({ ...others, [name]: text }, [name]);
    this.fillExamples(name);
    await this.start();
    if (this.isDamaged) this.announce("the link is damaged, so this is an example");
  }

  // The program of the address: `#code=...` is a shared one, `#example=name` an example. Each shared program has a name
  // of its own, so that the draft of another one does not take its place.
  async fromAddress() {
    const [kind, value] = location.hash.slice(1).split(/=(.*)/s);
    try {
      if (kind === "code") return { name: `shared-${hashOf(value)}.scene`, text: await decodeText(value) };
      const name = kind === "example" ? decodeURIComponent(value) : FIRST;
      const example = this.examples.find((each) => each.name === name);
      if (example) return example;
    } catch { /* told below */ }
    this.isDamaged = true;
    return this.examples.find((each) => each.name === FIRST);
  }

  fillExamples(chosen) {
    const chooser = byId("examples");
    const known = this.examples.some((example) => example.name === chosen);
    fill(chooser, known ? null : el("option", { value: "" }, "Examples"), ...this.examples.map(({ name, title }) => el("option", { value: name, title }, name.replace(/\.scene$/, ""))));
    chooser.value = known ? chosen : "";
    chooser.addEventListener("change", () => { location.hash = `example=${encodeURIComponent(chooser.value)}`; });
    addEventListener("hashchange", () => location.reload());
  }

  async share() {
    const address = `${location.href.split("#")[0]}#code=${await encodeText(this.editor.text)}`;
    history.replaceState(null, "", address);
    try {
      await navigator.clipboard.writeText(address);
      this.announce(`link copied (${address.length} characters)`);
    } catch {
      byId("copied-text").value = address;
      byId("copied").showModal();
      byId("copied-text").select();
    }
  }

  async saveAs(kind) {
    const stem = this.fileName.split("/").pop().replace(/\.scene$/, "");
    if (kind === "scene") this.download(new Blob([this.editor.text], { type: "text/plain" }), `${stem}.scene`);
    else if (kind === "png") byId("canvas").toBlob((blob) => this.download(blob, `${stem}.png`));
    else {
      try {
        this.download(new Blob([await this.server.export(this.file, kind)]), `${stem}.${kind}`);
      } catch (error) {
        this.announce(error.message);
      }
    }
  }
}

function begin() {
  const page = new Playground(new Local(document.baseURI));
  byId("share").addEventListener("click", () => page.share());
  byId("save-as").addEventListener("change", (event) => { page.saveAs(event.target.value); event.target.value = ""; });
  page.begin().catch((error) => page.say(`The interpreter could not be loaded: ${error.message}`));
  window.scenelangPage = page; // for the console and the tests
  if ("serviceWorker" in navigator) navigator.serviceWorker.register("offline.js");
}

document.body.classList.add("playground");
if (FRAMED) document.body.classList.add("embedded");
if (location.protocol !== "file:") begin();
else byId("message").textContent = "The playground needs a web server: run `python3 -m http.server` in its folder, and open http://localhost:8000.";
