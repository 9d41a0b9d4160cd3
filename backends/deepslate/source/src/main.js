// The page of a build: it turns under the mouse, its frames play, and `shoot` takes pictures of it.
import { Vector3 } from "three";
import { control, cornerOf, Viewpoint } from "../../../viewer/source/src/camera.js";
import { byId } from "../../../viewer/source/src/dom.js";
import { Timeline } from "../../../viewer/source/src/timeline.js";
import { readAtlas, readBuild } from "./build.js";
import { Drawing } from "./drawing.js";
import { Quads } from "./quads.js";

async function start() {
  const build = await readBuild(byId("build").textContent);
  const canvas = byId("canvas");
  const drawing = new Drawing(canvas, build, await readAtlas(build.atlas), new Quads(build));
  document.title = build.name;
  watch(canvas, build, drawing);
  // A frame from a camera (JSON) as a PNG `factor` times its size, in base64.
  window.shoot = (frame, camera, factor) => {
    canvas.width = camera.width * factor;
    canvas.height = camera.height * factor;
    drawing.draw(frame, camera);
    return canvas.toDataURL("image/png").split(",")[1];
  };
  byId("message").hidden = true;
  document.body.dataset.ready = "yes";
}

// Lets people look: the orbit, the timeline, a picture for every change.
function watch(canvas, build, drawing) {
  const { box } = build;
  const world = { center: box.center.map((n, i) => n + build.corner[i]), scale: box.scale };
  const staged = (place) => new Vector3(...place.map((n, i) => (n - box.center[i]) * box.scale));
  const viewpoint = new Viewpoint();
  let frame = build.numbers[0];
  let waits = false;
  const draw = () => {
    waits = false;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    viewpoint.aspect = canvas.width / canvas.height;
    viewpoint.apply();
    drawing.draw(frame, viewpoint.json(world, canvas.width, canvas.height));
  };
  const soon = () => {
    if (!waits) requestAnimationFrame(draw);
    waits = true;
  };
  viewpoint.aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1);
  viewpoint.frame(cornerOf(staged(box.low), staged(box.high)));
  control(canvas, viewpoint, soon);
  window.addEventListener("resize", soon);
  const parts = { bar: byId("timeline"), play: byId("play"), slider: byId("frame"), label: byId("frame-label"), rate: byId("rate") };
  const timeline = new Timeline(parts, (place) => { frame = build.numbers[place]; soon(); }, soon);
  timeline.take(build.numbers.length);
  soon();
}

start().catch((error) => {
  byId("message").textContent = `The build cannot be shown: ${error.message}`;
  document.body.dataset.ready = "no";
});
