// The soft shadow that a build casts on the ground: how much of the light from all sides its lowest blocks take.
const SIDE = 256;
const REACH = 8; // cells above the ground that still darken it
const STRENGTH = 0.6;

// `{ side, low, size, values }`: a square of the ground (x, z in cells), and its darkness from 0 to 255.
export function shadowOf(frame, low, high, ground) {
  const extent = Math.max(high[0] - low[0], high[2] - low[2]);
  const size = 1.5 * extent + 12;
  const corner = [(low[0] + high[0] - size) / 2, (low[2] + high[2] - size) / 2];
  const cell = size / SIDE;
  let dark = new Float32Array(SIDE * SIDE);
  for (let i = 0; i < frame.count; i += 1) {
    const weight = 1 - (frame.cells[1][i] - ground) / REACH;
    if (weight > 0) cover(dark, frame.cells[0][i] - corner[0], frame.cells[2][i] - corner[1], cell, Math.min(weight, 1));
  }
  const radius = Math.max(1, Math.round(Math.max(1.2, 0.04 * extent) / cell));
  for (let pass = 0; pass < 3; pass += 1) dark = blurred(blurred(dark, radius, 1, SIDE), radius, SIDE, 1);
  return { side: SIDE, corner, size, values: Uint8Array.from(dark, (value) => Math.round(255 * STRENGTH * value)) };
}

function cover(dark, x, z, cell, weight) {
  const [x0, x1] = [Math.floor(x / cell), Math.max(Math.floor(x / cell), Math.ceil((x + 1) / cell) - 1)];
  const [z0, z1] = [Math.floor(z / cell), Math.max(Math.floor(z / cell), Math.ceil((z + 1) / cell) - 1)];
  for (let j = Math.max(z0, 0); j <= Math.min(z1, SIDE - 1); j += 1) {
    for (let i = Math.max(x0, 0); i <= Math.min(x1, SIDE - 1); i += 1) dark[j * SIDE + i] = Math.max(dark[j * SIDE + i], weight);
  }
}

// The mean of 2 `radius` + 1 neighbours along the lines whose steps are `step`.
function blurred(values, radius, step, line) {
  const result = new Float32Array(values.length);
  for (let k = 0; k < SIDE; k += 1) {
    let sum = 0;
    const at = (i) => (i < 0 || i >= SIDE ? 0 : values[k * line + i * step]);
    for (let i = -radius; i < radius; i += 1) sum += at(i);
    for (let i = 0; i < SIDE; i += 1) {
      sum += at(i + radius) - at(i - radius - 1);
      result[k * line + i * step] = sum / (2 * radius + 1);
    }
  }
  return result;
}
