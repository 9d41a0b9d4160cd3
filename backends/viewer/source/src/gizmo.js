// Handles of the selected object in the picture: arrows that move it, rings that turn it, boxes that scale it. What is
// dragged becomes an edit of the program when the pointer is released.
import { MathUtils, Object3D, Scene } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";

const MODES = { move: "translate", turn: "rotate", scale: "scale" };
const SHARE = 1 / 200; // of the scene's extent: the grid to which moves are rounded

// The step of that grid in world units; `scale` is what world units become on the stage.
export function gridStep(scale) {
  return 10 ** Math.floor(Math.log10((2 * SHARE) / scale));
}

// What a key does in a mode, where the handles cannot be dragged: arrows along x and y, the page keys along z; with `isFine`
// a small step. Null for other keys.
export function changeByKey(mode, key, isFine, scale) {
  const direction = { ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, -1], PageDown: [0, 0, 1] }[key];
  if (!direction) return null;
  if (mode === "move") return { move: direction.map((part) => Number((part * (isFine ? 1 : 5) * gridStep(scale)).toPrecision(6))) };
  if (mode === "turn") return { rotate: [{ ArrowLeft: "y", ArrowRight: "y", ArrowUp: "x", ArrowDown: "x" }[key] ?? "z", (direction[0] - direction[1] + direction[2]) * (isFine ? 1 : 15)] };
  const factor = (isFine ? 1.01 : 1.1) ** (direction[0] + direction[1] - direction[2]);
  return { scale: [factor, factor, factor].map((each) => Number(each.toFixed(3))) };
}

// Two changes by keys as one: of another kind, the later one alone.
export function bothChanges(first, second) {
  const rounded = (value) => Number(value.toPrecision(6));
  if (first?.move && second.move) return { move: first.move.map((part, i) => rounded(part + second.move[i])) };
  if (first?.scale && second.scale) return { scale: first.scale.map((factor, i) => rounded(factor * second.scale[i])) };
  if (first?.rotate?.[0] === second.rotate?.[0] && second.rotate) return { rotate: [second.rotate[0], first.rotate[1] + second.rotate[1]] };
  return second;
}

export class Gizmo {
  // `actions`: redraw(), preview(offset) while an object is moved, change(edit) at the end.
  constructor(camera, canvas, actions) {
    this.actions = actions;
    this.scene = new Scene();
    this.anchor = new Object3D();
    this.scene.add(this.anchor);
    this.controls = new TransformControls(camera, canvas);
    this.controls.attach(this.anchor);
    this.controls.size = 0.8;
    this.scene.add(this.controls.getHelper());
    this.mode = null;
    this.controls.addEventListener("change", () => actions.redraw());
    this.controls.addEventListener("objectChange", () => actions.preview(this.mode === "move" ? this.offset() : null));
    this.controls.addEventListener("mouseUp", () => this.released());
    this.hide();
  }

  get isHeld() {
    return this.controls.dragging || (this.controls.enabled && this.controls.axis !== null);
  }

  // Shows the handles of a mode at a point of the stage; `scale` is what world units become there.
  show(mode, center, scale) {
    this.mode = mode;
    this.scale = scale;
    this.center = center;
    this.anchor.position.set(...center);
    this.anchor.rotation.set(0, 0, 0);
    this.anchor.scale.set(1, 1, 1);
    this.controls.setMode(MODES[mode]);
    this.controls.enabled = true;
    this.controls.getHelper().visible = true;
  }

  hide() {
    this.controls.enabled = false;
    this.controls.axis = null;
    this.controls.getHelper().visible = false;
  }

  // The move in world units, rounded to a grid that fits the scene.
  offset() {
    const step = gridStep(this.scale);
    const decimals = Math.max(0, -Math.log10(step));
    return ["x", "y", "z"].map((axis, i) => Number((Math.round((this.anchor.position[axis] - this.center[i]) / this.scale / step) * step).toFixed(decimals)));
  }

  released() {
    if (this.mode === "move") {
      const move = this.offset();
      if (move.some((value) => value)) this.actions.change({ move });
    } else if (this.mode === "turn") {
      const { rotation } = this.anchor;
      const axis = ["x", "y", "z"].reduce((best, each) => (Math.abs(rotation[each]) > Math.abs(rotation[best]) ? each : best), "y");
      const angle = Math.round(MathUtils.radToDeg(rotation[axis]));
      if (angle) this.actions.change({ rotate: [axis, angle] });
    } else {
      const scale = ["x", "y", "z"].map((axis) => Math.max(0.01, Math.round(this.anchor.scale[axis] * 100) / 100));
      if (scale.some((value) => value !== 1)) this.actions.change({ scale });
    }
  }

  draw(renderer, camera) {
    if (!this.controls.getHelper().visible) return;
    this.controls.camera = camera;
    renderer.setRenderTarget(null);
    renderer.clearDepth();
    renderer.render(this.scene, camera);
  }
}
