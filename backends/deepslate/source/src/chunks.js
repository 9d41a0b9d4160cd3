// The blocks of a frame as WebGL buffers, one or a few for each chunk; corners get darker beside solid cubes.
const CHUNK = 32; // as in backends/deepslate/visible.py
const FLOATS = 4; // 32-bit words of a vertex: x, y, z, u/v (16 bits each) - and one more for the colour
const WORDS = FLOATS + 1;
const MOST = 16384; // quads in one buffer: their corners have 16-bit numbers
const STEPS = [[0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1], [-1, 0, 0], [1, 0, 0]]; // `SIDES` there
const OCCLUSION = [0.4, 0.6, 0.8, 1.0];

// A frame's chunks: `{ corner, solid: [part], clear: [part] }`, a part `{ buffer, count, data }`.
export function buildChunks(gl, frame, quads) {
  const chunks = [];
  let start = 0;
  while (start < frame.count) {
    const corner = chunkOf(frame, start);
    let end = start + 1;
    while (end < frame.count && same(corner, chunkOf(frame, end))) end += 1;
    chunks.push(buildChunk(gl, frame, quads, corner.map((n) => n * CHUNK), start, end));
    start = end;
  }
  return chunks;
}

export function freeChunks(gl, chunks) {
  for (const { solid, clear } of chunks) for (const { buffer } of [...solid, ...clear]) gl.deleteBuffer(buffer);
}

function chunkOf({ cells }, i) {
  return cells.map((axis) => Math.floor(axis[i] / CHUNK));
}

function same(a, b) {
  return a[0] === b[0] && a[1] === b[1] && a[2] === b[2];
}

function buildChunk(gl, frame, quads, corner, start, end) {
  const solid = new Writer();
  const clear = new Writer();
  for (let i = start; i < end; i += 1) {
    const around = frame.around[i];
    const at = frame.cells.map((axis, k) => axis[i] - corner[k]);
    for (const quad of quads.of(frame.states[i], around >>> 26, solidSides(around))) (quad.isClear ? clear : solid).add(quad, at, around);
  }
  return { corner, solid: solid.parts(gl, false), clear: clear.parts(gl, true) };
}

// Quads as vertices, in an array that grows.
class Writer {
  constructor() {
    this.floats = new Float32Array(1024);
    this.words = new Uint32Array(this.floats.buffer); // the same memory
    this.used = 0;
  }

  add(quad, [x, y, z], around) {
    if (this.used + 4 * WORDS > this.floats.length) this.grow();
    const { floats, words } = this;
    const { positions, places, axis, color } = quad;
    for (let k = 0; k < 4; k += 1) {
      const [px, py, pz] = [positions[3 * k], positions[3 * k + 1], positions[3 * k + 2]];
      const light = axis === null ? 1 : occlusion(px, py, pz, axis, around);
      floats[this.used] = px + x;
      floats[this.used + 1] = py + y;
      floats[this.used + 2] = pz + z;
      words[this.used + 3] = Math.round(65535 * places[2 * k]) | (Math.round(65535 * places[2 * k + 1]) << 16);
      words[this.used + 4] = byte(color[0] * light) | (byte(color[1] * light) << 8) | (byte(color[2] * light) << 16) | (255 << 24);
      this.used += WORDS;
    }
  }

  grow() {
    const larger = new Float32Array(2 * this.floats.length);
    larger.set(this.floats);
    this.floats = larger;
    this.words = new Uint32Array(larger.buffer);
  }

  parts(gl, isClear) {
    const parts = [];
    const step = MOST * 4 * WORDS;
    for (let start = 0; start < this.used; start += step) {
      const data = this.floats.slice(start, Math.min(start + step, this.used));
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      parts.push({ buffer, count: data.length / (4 * WORDS), data: isClear ? data : null });
    }
    return parts;
  }
}

export const LAYOUT = { stride: 4 * WORDS, place: 12, color: 16, words: WORDS, most: MOST };

function byte(value) {
  return Math.max(0, Math.min(255, Math.round(255 * value)));
}

// How bright a corner of a face at the cell's border is, by the three solid cubes that may stand beside it.
function occlusion(x, y, z, axis, around) {
  const at = [x, y, z];
  const k = axis.findIndex((n) => n !== 0);
  if (Math.abs(at[k] - (axis[k] > 0 ? 1 : 0)) > 0.01) return 1;
  const [a, b] = [0, 1, 2].filter((i) => i !== k);
  const beside = (da, db) => {
    const step = [...axis];
    step[a] = da;
    step[b] = db;
    return isSolid(step, around);
  };
  const [da, db] = [Math.sign(at[a] - 0.5), Math.sign(at[b] - 0.5)];
  const one = da !== 0 && beside(da, 0);
  const two = db !== 0 && beside(0, db);
  if (one && two) return OCCLUSION[0];
  const corner = da !== 0 && db !== 0 && beside(da, db);
  return OCCLUSION[3 - one - two - corner];
}

// The sides at which a solid cube stands, as bits.
function solidSides(around) {
  return STEPS.reduce((bits, step, k) => bits | (isSolid(step, around) << k), 0);
}

// Whether a solid cube stands at a step: the bits of `AROUND` in backends/deepslate/visible.py.
function isSolid([x, y, z], around) {
  const index = 9 * (x + 1) + 3 * (y + 1) + (z + 1);
  return (around >>> (index > 13 ? index - 1 : index)) & 1;
}
