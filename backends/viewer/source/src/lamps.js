// The lights of a program: their numbers for the shaders, their shadow maps, and those that are seen.
import { DataTexture, FloatType, Group, Matrix4, Mesh, NearestFilter, OrthographicCamera, PerspectiveCamera, PlaneGeometry, RGBAFormat, SphereGeometry, Vector3 } from "three";

export const HALF = 1.02; // half the width of a shadow map of parallel light: the scene lies in the unit ball
export const DISTANCE = 3;
const TEXELS = 8; // of a light
const KINDS = ["sun", "point", "spot", "area"];
const WIDE = Math.PI / 3; // half angle of a spot from which one map would be too coarse
const OVERLAP = 1.04; // of the faces of a cube, so that taps find what is beside
const [SUN_SIDE, FACE_SIDE, MOST_SIDE] = [2048, 1024, 4096]; // texels
// Right, up and forward of the faces of a cube, in the axes of the lamp.
const FACES = [
  [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 0, -1], [0, 1, 0], [1, 0, 0]], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
  [[1, 0, 0], [0, 0, -1], [0, 1, 0]], [[1, 0, 0], [0, 0, 1], [0, -1, 0]], [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
];

export class Lamps {
  // `lights` are those of the packet; `material(uniforms)` gives the material of what shines; `most` is the largest side of
  // a texture.
  constructor(lights, material, most) {
    this.group = new Group();
    this.views = []; // a camera for each tile
    const data = new Float32Array(TEXELS * 4 * Math.max(1, lights.length));
    lights.forEach((light, number) => {
      const first = this.views.length;
      const views = light.kind === "sun" ? [farView(light.axes.map((axis) => new Vector3(...axis)))] : facesOf(light);
      this.views.push(...views);
      data.set(numbersOf(light, first, views), 4 * TEXELS * number);
      this.addShape(light, material);
    });
    this.texture = new DataTexture(data, TEXELS, Math.max(1, lights.length), RGBAFormat, FloatType);
    this.texture.minFilter = this.texture.magFilter = NearestFilter;
    this.texture.needsUpdate = true;
    this.perSide = Math.max(1, Math.ceil(Math.sqrt(this.views.length)));
    const tile = Math.max(SUN_SIDE / this.perSide, lights.every(({ kind }) => kind === "sun") ? SUN_SIDE : FACE_SIDE);
    this.side = this.perSide * Math.floor(Math.min(tile, Math.min(MOST_SIDE, most) / this.perSide)); // tiles are whole texels
  }

  // Draws the shadow maps: `draw(camera)` draws the depths of the scene onto `target`, of `this.side` texels.
  cast(renderer, target, draw) {
    const side = this.side / this.perSide;
    target.scissorTest = true;
    this.views.forEach((camera, number) => {
      const place = [side * (number % this.perSide), side * Math.floor(number / this.perSide), side, side];
      target.viewport.set(...place);
      target.scissor.set(...place);
      renderer.setRenderTarget(target);
      renderer.clear();
      draw(camera);
    });
  }

  // Adds the mesh of a sphere or a rectangle.
  addShape({ kind, position, axes, flux, radius, size }, material) {
    if (kind !== "area" && !(kind === "point" && radius > 0)) return;
    const surface = kind === "area" ? size[0] * size[1] : 4 * Math.PI * radius * radius;
    const radiance = { value: new Vector3(...flux).divideScalar(Math.PI * surface) };
    const mesh = new Mesh(kind === "area" ? new PlaneGeometry(...size) : new SphereGeometry(radius, 64, 32), material({ radiance }));
    const [right, up, ahead] = axes.map((axis) => new Vector3(...axis));
    if (kind === "area") mesh.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(right.negate(), up, ahead));
    mesh.position.set(...position);
    this.group.add(mesh);
  }

  dispose() {
    this.texture.dispose();
    for (const { geometry, material } of this.group.children) {
      geometry.dispose();
      material.dispose();
    }
  }
}

// The rotation of a camera that looks along `forward`.
function facing(right, up, forward) {
  return new Matrix4().makeBasis(right, up, forward.clone().negate());
}

// The eight texels of a light (shaders.js, LAMPS).
function numbersOf({ kind, position, axes: [right, up, ahead], flux, radius, angle, blend, size }, first, views) {
  const extent = kind === "sun" ? Math.tan(radius) : kind === "area" ? 0.5 * Math.sqrt(size[0] * size[1]) : radius;
  const { near, far, halfWidth = 1 } = views[0];
  const numbers = [
    [...position, KINDS.indexOf(kind)], [...right, angle / 2], [...up, Math.max(blend, 1e-3)], [...ahead, extent],
    [...flux, 0], [...size, 0, 0], [first, views.length, halfWidth, 0], [near, far, 0, 0],
  ];
  return numbers.flat();
}

// The cameras of a lamp: one of a narrow spot, else the faces of a cube, without the one behind for those that shine to
// one side.
function facesOf({ kind, position, axes, angle }) {
  const isNarrow = kind === "spot" && angle / 2 <= WIDE;
  const halfWidth = OVERLAP * (isNarrow ? Math.tan(angle / 2) : 1);
  const away = Math.hypot(...position);
  const world = (row) => axes.reduce((sum, axis, i) => sum.addScaledVector(new Vector3(...axis), row[i]), new Vector3());
  return FACES.slice(0, isNarrow ? 1 : kind === "point" ? 6 : 5).map((rows) => {
    const camera = new PerspectiveCamera((2 * Math.atan(halfWidth) * 180) / Math.PI, 1, Math.max(0.01, away - 1.1), away + 1.1);
    camera.position.set(...position);
    camera.quaternion.setFromRotationMatrix(facing(...rows.map(world)));
    camera.updateMatrixWorld(true);
    return Object.assign(camera, { halfWidth });
  });
}

// A camera that sees the whole scene from far away, in parallel; `axes` are right, up and forward.
export function farView(axes) {
  const camera = new OrthographicCamera(-HALF, HALF, HALF, -HALF, DISTANCE - 1.5, DISTANCE + 1.5);
  aim(camera, axes);
  return camera;
}

export function aim(camera, [right, up, forward]) {
  camera.position.copy(forward).multiplyScalar(-DISTANCE);
  camera.quaternion.setFromRotationMatrix(facing(right, up, forward));
  camera.updateMatrixWorld(true);
}
