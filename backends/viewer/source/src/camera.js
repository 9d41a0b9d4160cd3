// The camera: the angles and framing of backends/camera.py, moved by mouse, touch and keyboard.
import { MathUtils, OrthographicCamera, PerspectiveCamera, Vector3 } from "three";

const MARGIN = 0.06; // of the half picture, on each side
export const DEFAULT_VIEW = { azimuth: 30, elevation: 25, fov: 35 };

export function axesOf(azimuth, elevation) {
  const a = MathUtils.degToRad(azimuth);
  const e = MathUtils.degToRad(elevation);
  const right = new Vector3(Math.cos(a), 0, -Math.sin(a));
  const forward = new Vector3(-Math.sin(a) * Math.cos(e), -Math.sin(e), -Math.cos(a) * Math.cos(e));
  return { right, up: new Vector3().crossVectors(right, forward), forward };
}

// Azimuth, elevation, distance and target (stage frame), and the three.js camera placed by them.
export class Viewpoint {
  constructor() {
    Object.assign(this, DEFAULT_VIEW);
    this.distance = 4;
    this.target = new Vector3();
    this.orthographic = false;
    this.aspect = 1;
    this.perspectiveCamera = new PerspectiveCamera(DEFAULT_VIEW.fov, 1, 0.01, 1000);
    this.orthographicCamera = new OrthographicCamera();
  }

  get camera() {
    return this.orthographic ? this.orthographicCamera : this.perspectiveCamera;
  }

  get tangent() {
    return Math.tan(MathUtils.degToRad(this.fov) / 2);
  }

  // What is needed to look from here again.
  saved() {
    const { azimuth, elevation, fov, orthographic, distance, target } = this;
    return { azimuth, elevation, fov, orthographic, distance, target: target.toArray() };
  }

  take({ target, ...view }) {
    Object.assign(this, view);
    this.target.fromArray(target);
  }

  // The length at a point that a pixel shows of a picture with `height` pixels.
  lengthOfPixel(point, height) {
    const distance = this.orthographic ? this.distance : this.camera.position.distanceTo(new Vector3(...point));
    return (2 * this.tangent * distance) / height;
  }

  // Puts the three.js camera where the angles say.
  apply() {
    const { right, up, forward } = axesOf(this.azimuth, this.elevation);
    const { camera } = this;
    camera.position.copy(this.target).addScaledVector(forward, -this.distance);
    camera.matrix.makeBasis(right, up, forward.clone().negate());
    camera.quaternion.setFromRotationMatrix(camera.matrix);
    const reach = camera.position.length();
    // the scene and its shadows lie within 1.9 of the origin; a far near plane tells depths apart where solids touch
    camera.near = Math.max(0.005 * this.distance, 0.9 * (reach - 1.9), 1e-5);
    camera.far = reach + 200;
    if (this.orthographic) {
      const half = this.tangent * this.distance;
      Object.assign(camera, { left: -half * this.aspect, right: half * this.aspect, top: half, bottom: -half });
      camera.near = -reach - 3;
      camera.far = reach + 6;
    } else {
      camera.fov = this.fov;
      camera.aspect = this.aspect;
    }
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld(true);
  }

  // Frames the box from `low` to `high`: as near as its corners allow with a margin on every side.
  frame(low, high) {
    const { right, up, forward } = axesOf(this.azimuth, this.elevation);
    const center = new Vector3().addVectors(low, high).multiplyScalar(0.5);
    const corners = [];
    for (const x of [low.x, high.x]) for (const y of [low.y, high.y]) for (const z of [low.z, high.z]) corners.push(new Vector3(x, y, z).sub(center));
    const along = (axis) => corners.map((corner) => corner.dot(axis));
    const z = along(forward);
    const k = this.tangent * (1 - MARGIN);
    const [x, y] = [along(right), along(up)];
    const extent = Math.max(high.x - low.x, high.y - low.y, high.z - low.z);
    const nearest = Math.max(fitted(x, z, k * this.aspect, this.orthographic), fitted(y, z, k, this.orthographic));
    this.distance = Math.max(nearest, 1e-3 * extent) || 1;
    const depth = z.map((value) => (this.orthographic ? 1 : Math.max(value + this.distance, 1e-9)));
    this.target.copy(center).addScaledVector(right, middle(x, depth)).addScaledVector(up, middle(y, depth));
  }

  // The text that `render --camera` understands, lengths in the scene's units.
  text({ center, scale }) {
    const target = this.target.toArray().map((x, i) => x / scale + center[i]);
    const number = (x) => String(Number(x.toPrecision(6)));
    const parts = [
      `azimuth=${number(wrapped(this.azimuth))}`,
      `elevation=${number(this.elevation)}`,
      `distance=${number(this.distance / scale)}`,
      `fov=${number(this.fov)}`,
      `target=${target.map(number).join(":")}`,
    ];
    return (this.orthographic ? [...parts, "orthographic"] : parts).join(",");
  }

  // The camera's JSON form (docs: "camera"), for a picture of width x height pixels.
  json({ center, scale }, width, height) {
    const { right, up, forward } = axesOf(this.azimuth, this.elevation);
    const back = this.orthographic ? 4 : 0; // nothing may stand behind a camera of parallel projection
    const eye = this.camera.position.clone().addScaledVector(forward, -back).toArray().map((x, i) => x / scale + center[i]);
    const down = up.clone().negate();
    const row = (axis) => [...axis.toArray(), -(axis.x * eye[0] + axis.y * eye[1] + axis.z * eye[2])];
    const focal = this.orthographic ? height / ((2 * this.tangent * this.distance) / scale) : height / (2 * this.tangent);
    return {
      format: "scenelang-camera",
      version: 1,
      width,
      height,
      projection: this.orthographic ? "orthographic" : "perspective",
      K: [[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]],
      world_to_camera: [row(right), row(down), row(forward), [0, 0, 0, 1]],
      axes: "camera: x right, y down, z forward; world: x right, y up, z towards the viewer; pixel centres at halves",
      aperture: 0,
      focus: this.distance / scale,
    };
  }
}

function wrapped(degrees) {
  return MathUtils.euclideanModulo(degrees + 180, 360) - 180;
}

// The least distance from which all corners are in view.
function fitted(x, z, k, orthographic) {
  if (orthographic) return (Math.max(...x) - Math.min(...x)) / 2 / k;
  const a = Math.max(...x.map((value, i) => value - k * z[i]));
  const b = Math.max(...x.map((value, i) => -value - k * z[i]));
  return (a + b) / (2 * k);
}

// Where the corners project as far to one side as to the other.
function middle(x, depth) {
  let [best, found] = [-Infinity, 0];
  for (let i = 0; i < x.length; i++)
    for (let j = 0; j < x.length; j++) {
      const ratio = (x[i] - x[j]) / (depth[i] + depth[j]);
      if (ratio > best) [best, found] = [ratio, (x[i] * depth[j] + x[j] * depth[i]) / (depth[i] + depth[j])];
    }
  return found;
}

// Lets pointer, wheel and arrow keys over `element` move `viewpoint`; calls `moved` after each step. While `isHeld()`, the
// pointer holds something else.
export function control(element, viewpoint, moved, isHeld) {
  const pointers = new Map();
  const turn = (dx, dy) => {
    viewpoint.azimuth -= dx * 0.4;
    viewpoint.elevation = MathUtils.clamp(viewpoint.elevation + dy * 0.4, -90, 90);
  };
  const pan = (dx, dy) => {
    const { right, up } = axesOf(viewpoint.azimuth, viewpoint.elevation);
    const unit = (2 * viewpoint.tangent * viewpoint.distance) / element.clientHeight;
    viewpoint.target.addScaledVector(right, -dx * unit).addScaledVector(up, dy * unit);
  };
  const zoom = (factor) => {
    viewpoint.distance = MathUtils.clamp(viewpoint.distance * factor, 1e-3, 500);
  };
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  element.addEventListener("pointerdown", (event) => {
    if (isHeld()) return;
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  element.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (last === undefined) return;
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    const before = pointers.size === 2 ? spread() : 0;
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (pointers.size === 2) {
      pan(dx / 2, dy / 2);
      zoom(before / Math.max(spread(), 1));
    } else if (event.buttons & 6 || event.shiftKey) pan(dx, dy);
    else turn(dx, dy);
    moved();
  });
  for (const name of ["pointerup", "pointercancel"]) element.addEventListener(name, (event) => pointers.delete(event.pointerId));
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(MathUtils.clamp(event.deltaY, -200, 200) * 0.0012));
    moved();
  }, { passive: false });
  element.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [20, 0], ArrowRight: [-20, 0], ArrowUp: [0, 20], ArrowDown: [0, -20] }[event.key];
    if (step && event.shiftKey) pan(...step);
    else if (step) turn(step[0], step[1]);
    else if (event.key === "+" || event.key === "=") zoom(0.9);
    else if (event.key === "-") zoom(1 / 0.9);
    else return;
    event.preventDefault();
    moved();
  });
}
