// The page: joins the source of scenes, the picture and the panels.
import { Vector3 } from "three";
import { cornerOf, DEFAULT_VIEW, Viewpoint } from "./camera.js";
import { listen } from "./controls.js";
import { showDiagnostics } from "./diagnostics.js";
import { byId, counted, debounced, el, fill } from "./dom.js";
import { Graph } from "./graph.js";
import { inspect } from "./inspector.js";
import { Instances } from "./instances.js";
import { Labels } from "./labels.js";
import { decode } from "./packet.js";
import { Params } from "./params.js";
import { Splats } from "./splats.js";
import { Stage } from "./stage.js";
import { Timeline } from "./timeline.js";
import { Tree } from "./tree.js";
import { Words } from "./words.js";

// The view of the whole scene is made again when the scene leaves it, when its distance would be so many times as short,
// or its middle moved by such a share of it: a step of a slider keeps the picture still. Any view is left at a scene of
// another size.
const [SHRUNK, SHIFTED, FAR] = [1.5, 0.12, 4];
const ALL = "all"; // the view that frames the whole scene
const TURNED = "turned"; // the same, from an angle that a person chose
const VIEWS = { default: [30, 25, false], front: [0, 0, false], right: [90, 0, false], top: [0, 90, false], isometric: [45, 35.2644, true] };

export class Page {
  // `server` is where scenes come from: a Server, Saved scenes, or the worker of the playground.
  constructor(server) {
    this.server = server;
    this.viewport = byId("viewport");
    this.viewpoint = new Viewpoint();
    this.file = 0;
    this.packet = null;
    this.selection = null;
    this.isFramed = false;
    this.shown = null; // camera of the program, ALL or TURNED, while nobody has moved the view
    this.busy = null;
    this.labels = new Labels(byId("labels"));
    this.overlay = null;
    this.tree = new Tree(byId("tree"), (path) => this.select(path));
    this.words = new Words(byId("words"), byId("search"), { changed: () => this.refill(), reveal: (word) => this.revealNext(word) });
    this.params = new Params(byId("params"), { set: (name, value) => this.setParam(name, value), save: (name) => this.saveParam(name) });
    this.timeline = new Timeline({ bar: byId("timeline"), play: byId("play"), slider: byId("frame"), label: byId("frame-label"), rate: byId("rate") }, () => this.showFrame(), () => this.showFrame());
    this.wanted = new Map();
    this.refineLater = debounced(() => this.refine(), 250);
    this.arrangeLater = debounced(() => this.arrange(), 80);
    this.frameLater = debounced(() => this.frameAgain(), 80);
  }

  async start() {
    try {
      this.stage = new Stage(byId("canvas"));
    } catch {
      this.say("This browser shows no WebGL 2, which the picture needs.");
      return;
    }
    listen(this);
    new ResizeObserver(() => this.resize()).observe(this.viewport);
    this.resize();
    await this.listFiles();
    this.server.watch((file) => (file === null || file === this.file) && this.fileChanged(), (connected) => { byId("offline").hidden = connected; });
    await this.load();
  }

  fileChanged() {
    return this.load();
  }

  async listFiles() {
    const names = await this.server.files();
    const chooser = byId("files");
    const short = names.map((name) => name.split("/").pop());
    const isClear = new Set(short).size === names.length; // names alone tell the files apart
    fill(chooser, ...names.map((name, i) => el("option", { value: String(i), title: name }, isClear ? short[i] : name)));
    chooser.value = String(this.file);
    chooser.hidden = names.length < 2;
    byId("file-name").textContent = names.length < 2 ? short[0] : "";
    byId("file-name").title = names.length < 2 ? names[0] : "";
  }

  // --- scenes

  async choose(file) {
    this.file = file;
    this.packet = null;
    this.shownVersion = undefined;
    this.isFramed = false;
    this.selection = null;
    this.timeline.pause();
    this.timeline.frame = 0;
    this.tree.clear();
    this.words.clear();
    this.stage.clear();
    this.labels.clear();
    inspect(byId("inspector"), null, 0, null);
    this.say("Loading …");
    await this.load();
  }

  // Fetches the file's state, and its picture when that is new; a later call waits for the earlier.
  async load() {
    const mine = (this.busy ?? Promise.resolve()).then(() => this.loadNow()).catch((error) => this.say(`The scene could not be loaded: ${error.message}.`));
    this.busy = mine;
    await mine;
  }

  async loadNow() {
    const { file } = this;
    const state = await this.server.state(file);
    if (file !== this.file) return;
    await this.takeState(state);
  }

  showProblems(state) {
    showDiagnostics(byId("diagnostics"), state.diagnostics, state.picture !== null);
  }

  async takeState(state) {
    const { file } = this;
    this.params.take(state.params);
    if (state.picture !== null && state.picture !== this.shownVersion) {
      const packet = decode(await this.server.picture(file, state.picture));
      if (file !== this.file) return;
      this.takePacket(packet);
      this.shownVersion = state.picture;
    }
    this.showProblems(state);
    if (state.picture === null) this.takeNothing(state);
    document.title = `${state.ok ? "" : "! "}${state.name} - scenelang`;
    document.body.dataset.version = String(state.version);
  }

  takeNothing(state) {
    const evaluating = state.diagnostics.length === 0;
    byId("summary").textContent = "";
    this.say(evaluating ? "The program is being evaluated …" : "The program has a mistake; there is no picture yet.");
  }

  takePacket(packet) {
    const { selection } = this;
    const before = this.packet?.box;
    this.packet = packet;
    this.graph = new Graph(packet);
    this.instances = new Instances(packet, (...kind) => this.stage.solidMaterial(...kind));
    this.pathWords = packet.paths.map((path) => path.map((word) => packet.words[word]));
    this.splats = packet.columns.splatStart ? new Splats(packet) : null;
    this.stage.take(this.instances, this.splats, packet);
    this.viewpoint.floor = this.stage.ground.position.y;
    this.timeline.take(packet.frames);
    this.words.take(this.graph.wordCounts(this.timeline.frame));
    this.tree.take(this.graph, this.timeline.frame);
    const distinct = packet.columns.nodeWord.length;
    const frames = packet.animated ? `${counted(packet.frames)} frames, ` : "";
    byId("summary").textContent = `“${packet.word}”: ${frames}${counted(packet.primitives)} primitives, ${counted(distinct)} distinct entities`;
    this.say(packet.notice ?? "");
    const isThere = selection !== null && this.graph.nodesOn(this.timeline.frame, selection) !== null;
    this.selection = isThere ? selection : null;
    this.refill();
    this.listCameras();
    if (!packet.box) this.isFramed = false;
    else if (!this.isFramed) this.lookFrom(packet.cameras[0] ?? null);
    else if (this.shown?.poses) this.lookFrom(this.shown);
    else if (before) this.keepView(before);
    this.showSelection();
  }

  say(text) {
    byId("message").textContent = text;
    byId("message").hidden = !text;
  }

  // --- what is seen

  get frame() {
    return this.timeline.frame;
  }

  showFrame() {
    if (!this.packet) return;
    if (!this.timeline.playing) {
      this.tree.take(this.graph, this.frame);
      this.words.take(this.graph.wordCounts(this.frame));
    }
    if (this.shown?.poses?.length > 1) this.lookFrom(this.shown);
    this.refill();
    this.showSelection();
  }

  // Fills the picture anew: another frame, other words hidden.
  refill() {
    if (!this.packet) return;
    const { words, graph, pathWords } = this;
    this.instances.show(this.frame, words.isFiltering ? (path, node) => words.sees([...pathWords[path], graph.word(node)]) : null);
    this.splats?.show(this.frame);
    this.labels.take(this.instances, graph);
    this.arrange();
  }

  arrange() {
    this.isMoving = false;
    const { viewpoint } = this;
    viewpoint.apply();
    const pixels = this.viewport.clientHeight / (2 * viewpoint.tangent * (viewpoint.orthographic ? viewpoint.distance : 1));
    if (this.instances?.ready) this.instances.arrange(viewpoint.camera, pixels);
    this.splats?.arrange(viewpoint.camera);
    this.stage.changed();
    this.draw();
  }

  // Keeps what is seen in its place: the stage of a changed scene has another middle and another scale. The view of the
  // whole scene is made again when the scene has outgrown it, or become small in it.
  keepView(before) {
    const { center, scale } = this.packet.box;
    const { viewpoint, shown } = this;
    viewpoint.target.fromArray(viewpoint.target.toArray().map((x, i) => (x / before.scale + before.center[i] - center[i]) * scale));
    viewpoint.distance *= scale / before.scale;
    const now = viewpoint.saved();
    this.frameAll();
    const framed = viewpoint.saved();
    const growth = viewpoint.distance / now.distance;
    const shift = viewpoint.target.distanceTo(new Vector3(...now.target)) / viewpoint.distance;
    viewpoint.take(now);
    const isOther = growth > FAR || growth < 1 / FAR;
    const isAway = (shown === ALL || shown === TURNED) && !this.holdsAll();
    const isFramed = isOther || isAway || (shown === ALL && (growth < 1 / SHRUNK || shift > SHIFTED));
    if (isFramed) viewpoint.take(framed);
    this.moved();
    this.shown = isFramed ? ALL : shown;
  }

  // Whether all of the scene is in the view.
  holdsAll() {
    this.viewpoint.apply();
    return this.viewpoint.holds(this.farthest());
  }

  // The view of the whole scene is turned: the scene stays in it when it changes.
  turned() {
    const isAll = this.shown === ALL || this.shown === TURNED;
    this.moved();
    if (isAll) this.shown = TURNED;
  }

  moved() {
    this.shown = null;
    this.viewpoint.apply();
    this.isMoving = true;
    this.arrangeLater();
    this.draw();
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    document.body.dataset.refined = "no";
    requestAnimationFrame(() => {
      this.pending = false;
      this.drawNow();
    });
  }

  drawNow() {
    this.viewpoint.apply();
    this.stage.draw(this.viewpoint, this.isMoving);
    this.gizmo?.draw(this.stage.renderer, this.viewpoint.camera);
    this.labels.place(this.viewpoint.camera, this.viewport.clientWidth, this.viewport.clientHeight);
    this.overlay?.place(this.viewpoint.camera, this.viewport.clientWidth, this.viewport.clientHeight);
    document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
    this.refineLater();
  }

  // While nothing moves, makes the picture better sample by sample.
  async refine() {
    const { drawn } = document.body.dataset;
    const isStill = () => !this.pending && !this.timeline.playing && document.body.dataset.drawn === drawn;
    while (isStill()) {
      if (await this.stage.refine(this.viewpoint)) continue;
      this.gizmo?.draw(this.stage.renderer, this.viewpoint.camera);
      if (isStill()) document.body.dataset.refined = "yes";
      return;
    }
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.viewport;
    if (!width || !height) return;
    this.stage.resize(width, height, Math.min(window.devicePixelRatio, 2));
    this.viewpoint.aspect = width / height;
    document.body.dataset.refined = "no";
    this.drawNow(); // a canvas of another size is empty until then
    this.frameLater();
  }

  // Frames the whole scene again in a picture of another shape, if nobody has moved the view.
  frameAgain() {
    const { shown } = this;
    if (!this.packet?.box) return;
    if (shown?.isFramed) this.lookFrom(shown);
    else if (shown === ALL || (shown === TURNED && !this.holdsAll())) this.frameAll();
  }

  // Frames what `farthest` gives the farthest points of.
  frameSolid(farthest) {
    this.viewpoint.frame(farthest);
    this.isFramed = true;
    this.moved();
  }

  frameBox(low, high) {
    this.frameSolid(cornerOf(new Vector3(...low), new Vector3(...high)));
  }

  // The farthest points of what is seen in all frames; of very many instances, those of their box.
  farthest() {
    const { low, high } = this.packet.box;
    return this.instances.farthest() ?? cornerOf(...[low, high].map((corner) => new Vector3(...this.staged(corner))));
  }

  // Frames what is seen of all frames.
  frameAll() {
    if (!this.packet?.box) return;
    this.frameSolid(this.farthest());
    this.shown = ALL;
  }

  // A point of the scene in the stage's frame.
  staged(point) {
    const { center, scale } = this.packet.box;
    return point.map((x, i) => (x - center[i]) * scale);
  }

  // Lists the cameras of the program among the views.
  listCameras() {
    const { cameras } = this.packet;
    const options = cameras.map(({ name }, i) => el("option", { value: `camera ${i}` }, name || "Camera"));
    const group = byId("program-cameras");
    fill(group, ...options);
    group.hidden = !options.length;
    if (this.shown?.poses) this.shown = cameras.find(({ name }) => name === this.shown.name) ?? ALL;
  }

  // Looks as a camera of the program does, and follows it over the frames and changes until the view is moved; without
  // one, shows everything.
  lookFrom(camera) {
    if (camera) {
      const { poses } = camera;
      this.viewpoint.take(poses[Math.round((this.frame * (poses.length - 1)) / Math.max(1, this.packet.frames - 1))]);
    }
    if (!camera || camera.isFramed) this.frameAll();
    else {
      this.isFramed = true;
      this.moved();
    }
    this.shown = camera ?? ALL;
  }

  frameSelection() {
    const box = this.selection && this.selectionBox();
    if (box) this.frameBox(box.low, box.high);
    else this.frameAll();
  }

  setView(name) {
    const [, number] = name.split("camera ");
    if (number) this.lookFrom(this.packet?.cameras[Number(number)] ?? null);
    const view = VIEWS[name];
    if (!view) return;
    [this.viewpoint.azimuth, this.viewpoint.elevation, this.viewpoint.orthographic] = view;
    Object.assign(this.viewpoint, { fov: DEFAULT_VIEW.fov, roll: 0 });
    this.frameAll();
  }

  // --- selection

  pick(x, y) {
    if (!this.instances?.ready) return;
    const leaf = this.stage.pick(this.viewpoint, x, y);
    this.select(leaf === null ? null : this.graph.pathOfLeaf(this.frame, leaf));
    this.draw();
  }

  select(path) {
    this.selection = path;
    if (!this.packet) return;
    this.timeline.pause();
    this.tree.reveal(path);
    this.showSelection();
  }

  selectionBox() {
    return this.boxOfPath(this.selection);
  }

  boxOfPath(path) {
    const range = this.graph.leafRange(this.frame, path);
    return this.instances.ready && range ? this.instances.box(...range) : null;
  }

  escape() {
    this.select(null);
  }

  // What single keys do here besides those of every page.
  get ownKeys() {
    return {};
  }

  showSelection() {
    const range = this.selection && this.graph.leafRange(this.frame, this.selection);
    const box = range && this.selectionBox();
    inspect(byId("inspector"), this.graph, this.frame, range ? this.selection : null, box && box.high.map((high, i) => (high - box.low[i]) / this.packet.box.scale));
    const isWhole = this.selection !== null && this.selection.length === 0;
    this.stage.select(isWhole ? null : range, box);
    this.draw();
  }

  // Selects the word's next instance after the selected one, round about.
  revealNext(word) {
    const counts = this.graph.countsOf(word);
    const total = counts[this.graph.root(this.frame)];
    if (!total) return;
    const next = this.revealed?.word === word ? (this.revealed.index + 1) % total : 0;
    this.revealed = { word, index: next };
    this.select(this.graph.descend(this.frame, next, counts, (node) => this.graph.word(node) === word));
  }

  // --- params and camera

  // Tries a value out; while an evaluation runs only the last wanted value of each param waits.
  async setParam(name, value) {
    this.wanted.set(name, value);
    if (this.isSetting) return;
    this.isSetting = true;
    while (this.wanted.size) {
      const [[next, last]] = this.wanted;
      this.wanted.delete(next);
      await this.ask(() => this.server.set(this.file, next, last));
    }
    this.isSetting = false;
  }

  async saveParam(name) {
    await this.ask(() => this.server.save(this.file, name));
    this.announce(`${name} is saved`);
  }

  async ask(action) {
    byId("busy").hidden = false;
    try {
      await action();
      await this.load();
    } catch (error) {
      this.announce(error.message);
    } finally {
      byId("busy").hidden = true;
    }
  }

  // Copies what `write(box, width, height)` makes of the camera.
  async copyCamera(write, what) {
    if (!this.packet?.box) {
      this.announce("there is no picture, so no camera");
      return;
    }
    const text = write(this.packet.box, this.viewport.clientWidth, this.viewport.clientHeight);
    try {
      await navigator.clipboard.writeText(text);
      this.announce(`copied: ${what}`);
    } catch {
      byId("copied-text").value = text;
      byId("copied").showModal();
      byId("copied-text").select();
    }
  }

  announce(text) {
    const status = byId("status");
    status.textContent = text;
    clearTimeout(this.statusTimer);
    this.statusTimer = setTimeout(() => { status.textContent = ""; }, 4000 + 50 * text.length);
  }
}
