// The camera: the angles and framing of backends/camera.py, moved by mouse, touch and keyboard.
import { MathUtils, OrthographicCamera, PerspectiveCamera, Vector3 } from "three";

const FILL = 0.91; // share of the picture's limiting side that what is framed takes
const HORIZON = 2e4; // farthest point of the ground
export const DEFAULT_VIEW = { azimuth: 30, elevation: 25, roll: 0, fov: 35 };

// Right, up and forward of a camera, for angles in degrees; the roll turns it clockwise.
export function axesOf(azimuth, elevation, roll = 0) {
  const a = MathUtils.degToRad(azimuth);
  const e = MathUtils.degToRad(elevation);
  const right = new Vector3(Math.cos(a), 0, -Math.sin(a));
  const forward = new Vector3(-Math.sin(a) * Math.cos(e), -Math.sin(e), -Math.cos(a) * Math.cos(e));
  const up = new Vector3().crossVectors(right, forward);
  if (!roll) return { right, up, forward };
  const [c, s] = [Math.cos(MathUtils.degToRad(roll)), Math.sin(MathUtils.degToRad(roll))];
  return { right: right.clone().multiplyScalar(c).addScaledVector(up, -s), up: up.clone().multiplyScalar(c).addScaledVector(right, s), forward };
}

// The support function of a box: its corner that is farthest in a direction.
export function cornerOf(low, high) {
  return (d) => new Vector3(d.x < 0 ? low.x : high.x, d.y < 0 ? low.y : high.y, d.z < 0 ? low.z : high.z);
}

// Azimuth, elevation, roll, distance and target (stage frame), and the three.js camera placed by them.
export class Viewpoint {
  constructor() {
    Object.assign(this, DEFAULT_VIEW);
    this.distance = 4;
    this.target = new Vector3();
    this.orthographic = false;
    this.aspect = 1;
    this.floor = -1; // height of the ground
    this.perspectiveCamera = new PerspectiveCamera(DEFAULT_VIEW.fov, 1, 0.01, 1000);
    this.orthographicCamera = new OrthographicCamera();
  }

  get camera() {
    return this.orthographic ? this.orthographicCamera : this.perspectiveCamera;
  }

  get axes() {
    return axesOf(this.azimuth, this.elevation, this.roll);
  }

  get tangent() {
    return Math.tan(MathUtils.degToRad(this.fov) / 2);
  }

  // What is needed to look from here again.
  saved() {
    const { azimuth, elevation, roll, fov, orthographic, distance, target } = this;
    return { azimuth, elevation, roll, fov, orthographic, distance, target: target.toArray() };
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
    const { right, up, forward } = this.axes;
    const { camera } = this;
    camera.position.copy(this.target).addScaledVector(forward, -this.distance);
    camera.matrix.makeBasis(right, up, forward.clone().negate());
    camera.quaternion.setFromRotationMatrix(camera.matrix);
    const reach = camera.position.length();
    // the scene and its shadows lie within 1.9 of the origin; a far near plane tells depths apart where solids touch
    const fall = this.tangent * (Math.abs(up.y) + this.aspect * Math.abs(right.y)) - forward.y; // of the lowest corner, at distance 1
    const above = fall > 0 ? Math.max(camera.position.y - this.floor, 0) / fall : Infinity; // to the nearest ground
    camera.near = Math.max(0.005 * this.distance, Math.min(0.9 * (reach - 1.9), 0.9 * above), 1e-5);
    camera.far = reach + HORIZON;
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

  // Frames a solid whose farthest point in a direction `farthest` gives, as pictures do (backends/pictures/camera.py,
  // framed): its rectangle in the picture is in the middle, as large as fits.
  frame(farthest) {
    const { right, up, forward } = this.axes;
    const reach = (direction) => farthest(direction).dot(direction);
    const [low, high] = [-1, 1].map((sign) => new Vector3(...[0, 1, 2].map((i) => farthest(new Vector3().setComponent(i, sign)).getComponent(i))));
    const center = new Vector3().addVectors(low, high).multiplyScalar(0.5);
    const extent = Math.max(...high.clone().sub(low).toArray());
    const k = this.tangent * FILL;
    const fitted = (axis, slope) => (this.orthographic
      ? (reach(axis) + reach(axis.clone().negate())) / 2 / slope
      : [1, -1].reduce((sum, sign) => sum + reach(axis.clone().multiplyScalar(sign / slope).sub(forward)) + center.dot(forward), 0) / 2);
    const nearest = Math.max(fitted(right, k * this.aspect), fitted(up, k));
    const front = reach(forward.clone().negate()) + center.dot(forward);
    this.distance = Math.max(nearest, 1e-3 * extent, this.orthographic ? 0 : front + 1e-5 * extent) || 1;
    this.target.copy(center);
    for (const axis of [right, up]) this.target.addScaledVector(axis, this.middle(farthest, axis, forward, center));
  }

  // Whether a solid is in the picture: whether its farthest points are on the inner sides of the planes around the view.
  holds(farthest) {
    const { right, up, forward } = this.axes;
    const eye = this.orthographic ? this.target : this.camera.position;
    return [[right, this.tangent * this.aspect], [up, this.tangent]].every(([axis, slope]) => [1, -1].every((sign) => {
      const outward = axis.clone().multiplyScalar(sign).addScaledVector(forward, this.orthographic ? 0 : -slope);
      return farthest(outward).sub(eye).dot(outward) <= (this.orthographic ? slope * this.distance : 0);
    }));
  }

  // How far from `center` along an axis the picture's middle is, if the solid projects as far to one side as to the
  // other. Of two points it projects to both sides by t = (x1 - x2) / (z1 + z2), and those for which this is largest are
  // found by the points that are farthest along the axis tilted by the last t (Dinkelbach, 1967).
  middle(farthest, axis, forward, center) {
    const depth = (p) => (this.orthographic ? 1 : Math.max(p.sub(center).dot(forward) + this.distance, 1e-9));
    let [tilt, found] = [0, 0];
    for (let step = 0; step < 20; step += 1) {
      const [a, b] = [1, -1].map((sign) => farthest(axis.clone().multiplyScalar(sign).addScaledVector(forward, this.orthographic ? 0 : -tilt)));
      const [xa, xb] = [a, b].map((p) => p.dot(axis) - center.dot(axis));
      const [za, zb] = [a, b].map((p) => depth(p.clone()));
      found = (xa * zb + xb * za) / (za + zb);
      const next = (xa - xb) / (za + zb);
      if (Math.abs(next - tilt) <= 1e-9 * Math.abs(next)) break;
      tilt = next;
    }
    return found;
  }

  // The text that `render --camera` understands, lengths in the scene's units.
  text({ center, scale }) {
    const target = this.target.toArray().map((x, i) => x / scale + center[i]);
    const number = (x) => String(Number(x.toPrecision(6)));
    const parts = [
      `azimuth=${number(wrapped(this.azimuth))}`,
      `elevation=${number(this.elevation)}`,
      ...(this.roll ? [`roll=${number(this.roll)}`] : []),
      `distance=${number(this.distance / scale)}`,
      `fov=${number(this.fov)}`,
      `target=${target.map(number).join(":")}`,
    ];
    return (this.orthographic ? [...parts, "orthographic"] : parts).join(",");
  }

  // The camera's JSON form (docs: "camera"), for a picture of width x height pixels.
  json({ center, scale }, width, height) {
    const { right, up, forward } = this.axes;
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
      axes: "camera: x right, y down, z forward; world: x right, y up, z towards the viewer; pixel centers at halves",
      aperture: 0,
      focus: this.distance / scale,
    };
  }
}

function wrapped(degrees) {
  return MathUtils.euclideanModulo(degrees + 180, 360) - 180;
}

// Lets pointer, wheel and arrow keys over `element` move `viewpoint`; calls `moved(isTurn)` after each step, which may only
// turn. While `isHeld()`, the pointer holds something else.
export function control(element, viewpoint, moved, isHeld = () => false) {
  const pointers = new Map();
  const turn = (dx, dy) => {
    viewpoint.azimuth -= dx * 0.4;
    viewpoint.elevation = MathUtils.clamp(viewpoint.elevation + dy * 0.4, -90, 90);
  };
  const pan = (dx, dy) => {
    const { right, up } = viewpoint.axes;
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
    if (isHeld()) pointers.clear(); // a finger takes hold of something only after it went down
    const last = pointers.get(event.pointerId);
    if (last === undefined) return;
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    const before = pointers.size === 2 ? spread() : 0;
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const isTurn = pointers.size === 1 && !(event.buttons & 6) && !event.shiftKey;
    if (isTurn) turn(dx, dy);
    else if (pointers.size === 2) {
      pan(dx / 2, dy / 2);
      zoom(before / Math.max(spread(), 1));
    } else pan(dx, dy);
    moved(isTurn);
  });
  for (const name of ["pointerup", "pointercancel"]) element.addEventListener(name, (event) => pointers.delete(event.pointerId));
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(MathUtils.clamp(event.deltaY, -200, 200) * 0.0012));
    moved(false);
  }, { passive: false });
  element.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [20, 0], ArrowRight: [-20, 0], ArrowUp: [0, 20], ArrowDown: [0, -20] }[event.key];
    const isTurn = step !== undefined && !event.shiftKey;
    if (isTurn) turn(...step);
    else if (step) pan(...step);
    else if (event.key === "+" || event.key === "=") zoom(0.9);
    else if (event.key === "-") zoom(1 / 0.9);
    else return;
    event.preventDefault();
    moved(isTurn);
  });
}
