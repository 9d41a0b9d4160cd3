// What people press and click: the picture, the buttons above it, the keys.
import { control } from "./camera.js";
import { byId } from "./dom.js";

const NARROW = 560; // pixels: a narrower window begins with the scene alone
const CRAMPED = 1000; // beside the editor, the details have no room at first

// Connects the elements of the document to `page`.
export function listen(page) {
  control(byId("canvas"), page.viewpoint, (isTurn) => (isTurn ? page.turned() : page.moved()), () => Boolean(page.gizmo?.isHeld));
  let pressed = null;
  byId("canvas").addEventListener("pointerdown", (event) => { pressed = page.gizmo?.isHeld ? null : [event.offsetX, event.offsetY]; });
  byId("canvas").addEventListener("pointerup", (event) => {
    if (pressed && event.button === 0 && !page.gizmo?.isHeld && Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) < 4) page.pick(event.offsetX, event.offsetY, event.ctrlKey || event.metaKey);
    pressed = null;
  });
  const on = (id, action) => byId(id).addEventListener("click", action);
  on("frame-all", () => page.frameAll());
  on("toggle-labels", (event) => { page.labels.isOn = press(event.target); page.draw(); });
  on("toggle-ground", (event) => { page.stage.hasGround = press(event.target); page.draw(); });
  on("toggle-left", (event) => document.body.classList.toggle("no-left", !press(event.target)));
  on("toggle-right", (event) => document.body.classList.toggle("no-right", !press(event.target)));
  const [hidesTree, hidesDetails] = [innerWidth < NARROW, innerWidth < NARROW || (page.editor && innerWidth <= CRAMPED)];
  for (const [id, hides] of [["toggle-left", hidesTree], ["toggle-right", hidesDetails]]) if (hides && byId(id).getAttribute("aria-pressed") === "true") byId(id).click();
  on("copy-camera", () => page.copyCamera((box) => page.viewpoint.text(box), "camera for render --camera"));
  on("copy-json", () => page.copyCamera((box, width, height) => JSON.stringify(page.viewpoint.json(box, width, height)), "camera as JSON"));
  byId("view").addEventListener("change", (event) => page.setView(event.target.value));
  byId("mode").addEventListener("change", (event) => { page.stage.setMode(Number(event.target.value)); page.draw(); });
  const cut = () => {
    const axis = byId("section-axis").value;
    byId("section").disabled = axis === "";
    page.stage.cut(axis === "" ? null : Number(axis), Number(byId("section").value));
    page.draw();
  };
  byId("section-axis").addEventListener("change", cut);
  byId("section").addEventListener("input", cut);
  byId("files").addEventListener("change", (event) => page.choose(Number(event.target.value)));
  for (const button of document.querySelectorAll("#sheets [data-sheet]")) button.addEventListener("click", () => showSheet(button.dataset.sheet));
  document.addEventListener("keydown", (event) => onKey(page, event));
}

// Whether keys go into a field or the program.
export function isTyping(event) {
  return event.target.matches("input:not([type=range]):not([type=checkbox]):not([type=radio]), select, textarea, [contenteditable=true]");
}

function onKey(page, event) {
  if (event.target.closest("dialog")) return;
  if (event.key === "Escape") {
    if (isTyping(event)) event.target.blur(); // with the selection kept: Tab leads to what changes it
    else page.escape();
    return;
  }
  if (isTyping(event) || event.ctrlKey || event.metaKey || event.altKey) return;
  const keys = { f: () => page.frameSelection(), l: () => byId("toggle-labels").click(), g: () => byId("toggle-ground").click(), "/": () => byId("search").focus(), ...page.ownKeys };
  if (event.key === " " && !event.target.matches("button, input[type=checkbox]")) keys[" "] = () => page.timeline.toggle();
  const action = keys[event.key.toLowerCase()];
  if (!action) return;
  event.preventDefault();
  action();
}

// Turns a toggle button over; whether it is on now.
function press(button) {
  const isOn = button.getAttribute("aria-pressed") !== "true";
  button.setAttribute("aria-pressed", String(isOn));
  return isOn;
}

// On a phone one panel at a time lies over the lower half of the picture; pressing its button again hides it.
export function showSheet(name) {
  const next = document.body.dataset.sheet === name ? "" : name;
  document.body.dataset.sheet = next;
  for (const button of document.querySelectorAll("#sheets [data-sheet]")) button.setAttribute("aria-pressed", String(button.dataset.sheet === next));
}
