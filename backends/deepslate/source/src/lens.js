// A camera in its JSON form (docs: "camera") as the numbers that WebGL wants.

// Where the camera stands and looks, in cells from the build's corner: rows right, down, forward.
export function lensOf(camera, corner) {
  const rows = camera.world_to_camera.slice(0, 3);
  const axes = rows.map((row) => row.slice(0, 3));
  const offset = rows.map((row) => row[3] + row[0] * corner[0] + row[1] * corner[1] + row[2] * corner[2]);
  const eye = [0, 1, 2].map((i) => -(axes[0][i] * offset[0] + axes[1][i] * offset[1] + axes[2][i] * offset[2]));
  const [[fx, , cx], [, fy, cy]] = camera.K;
  return { axes, eye, fx, fy, cx, cy, width: camera.width, height: camera.height, isParallel: camera.projection === "orthographic" };
}

export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// How deep a place lies along the axis of view.
export function depthOf(lens, place) {
  return dot(lens.axes[2], place.map((n, i) => n - lens.eye[i]));
}

// The nearest and farthest depth of a box that can be drawn.
export function depths(lens, low, high) {
  const found = [];
  for (const x of [low[0], high[0]]) for (const y of [low[1], high[1]]) for (const z of [low[2], high[2]]) found.push(depthOf(lens, [x, y, z]));
  const room = 2; // models may reach out of their cells
  const far = Math.max(Math.max(...found) + room, 1);
  const near = Math.min(...found) - room;
  return lens.isParallel ? [near, far] : [Math.max(near, far * 1e-4, 0.01), far];
}

// The matrix (column by column) from cells around `origin` to WebGL's clip space.
export function matrixOf(lens, origin, [near, far]) {
  const { axes, fx, fy, cx, cy, width, height } = lens;
  const [right, down, forward] = axes.map((axis) => [...axis, dot(axis, origin.map((n, i) => n - lens.eye[i]))]);
  const [x, y] = [(2 * cx) / width - 1, 1 - (2 * cy) / height];
  const last = lens.isParallel ? [0, 0, 0, 1] : forward;
  const [a, b] = lens.isParallel ? [2 / (far - near), -(far + near) / (far - near)] : [(far + near) / (far - near), (-2 * far * near) / (far - near)];
  const rows = [
    right.map((n, i) => ((2 * fx) / width) * n + x * last[i]),
    down.map((n, i) => ((-2 * fy) / height) * n + y * last[i]),
    forward.map((n, i) => a * n + (i === 3 ? b : 0)),
    last,
  ];
  return new Float32Array([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])));
}
