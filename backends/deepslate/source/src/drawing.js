// Draws a frame of the build from a camera: what lies behind, solid blocks, then what one sees through, far to near.
import { buildChunks, freeChunks, LAYOUT } from "./chunks.js";
import { depthOf, depths, lensOf, matrixOf } from "./lens.js";
import { BEHIND, BLOCKS, Program } from "./shaders.js";
import { shadowOf } from "./shadow.js";

const MOST_KEPT = 3_000_000; // blocks of all frames whose buffers are kept
const CHECKER = 0.25; // backends/studio.py

export class Drawing {
  constructor(canvas, build, atlas, quads) {
    Object.assign(this, { canvas, build, quads, frames: new Map() });
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    this.blocks = new Program(gl, BLOCKS);
    this.behind = new Program(gl, BEHIND);
    this.empty = gl.createVertexArray();
    this.atlas = this.texture(gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, atlas);
    this.indices = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indicesOf(Array.from({ length: LAYOUT.most }, (_, i) => i)), gl.STATIC_DRAW);
    this.sorted = gl.createBuffer();
  }

  texture(filter) {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, filter);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return texture;
  }

  // The buffers of a frame; those of other frames are kept while there is room.
  frame(number) {
    const key = this.build.frames[number];
    if (!this.frames.has(key)) {
      const source = this.build.distinct[key];
      let kept = source.count;
      for (const count of this.frames.values()) kept += count.count;
      if (kept > MOST_KEPT) this.forget();
      const { box, studio } = this.build;
      const ground = studio.height / box.scale + box.center[1];
      this.frames.set(key, { count: source.count, chunks: buildChunks(this.gl, source, this.quads), shadow: this.shade(shadowOf(source, box.low, box.high, ground)) });
    }
    return this.frames.get(key);
  }

  forget() {
    for (const { chunks, shadow } of this.frames.values()) {
      freeChunks(this.gl, chunks);
      this.gl.deleteTexture(shadow.texture);
    }
    this.frames.clear();
  }

  shade({ side, corner, size, values }) {
    const { gl } = this;
    const texture = this.texture(gl.LINEAR);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, side, side, 0, gl.RED, gl.UNSIGNED_BYTE, values);
    return { texture, corner, size };
  }

  // Draws frame `number` from `camera` (JSON) over the whole canvas.
  draw(number, camera) {
    const { gl, canvas, build } = this;
    if (gl.drawingBufferWidth !== canvas.width || gl.drawingBufferHeight !== canvas.height) throw new Error("the picture is too large for this browser");
    const { chunks, shadow } = this.frame(number);
    const lens = lensOf(camera, build.corner);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.DEPTH_BUFFER_BIT | gl.COLOR_BUFFER_BIT);
    this.drawBehind(lens, shadow);
    gl.useProgram(this.blocks.program);
    gl.bindVertexArray(null);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindTexture(gl.TEXTURE_2D, this.atlas);
    gl.uniform3fv(this.blocks.at("light"), build.studio.light.map((part) => Math.max(part, 0) ** (1 / 2.2)));
    const range = depths(lens, build.box.low, build.box.high);
    gl.uniform1f(this.blocks.at("least"), 0.5);
    for (const { corner, solid } of chunks) for (const part of solid) this.drawPart(part, this.indices, matrixOf(lens, corner, range));
    gl.uniform1f(this.blocks.at("least"), 0.02);
    gl.depthMask(false);
    for (const { corner, clear } of farFirst(chunks, lens)) for (const part of clear) this.drawClear(part, corner, lens, range);
    gl.depthMask(true);
  }

  drawClear(part, corner, lens, range) {
    const { gl } = this;
    const { words } = LAYOUT;
    const depth = new Float32Array(part.count);
    for (let i = 0; i < part.count; i += 1) {
      const at = 4 * words * i;
      depth[i] = depthOf(lens, [0, 1, 2].map((k) => corner[k] + (part.data[at + k] + part.data[at + 2 * words + k]) / 2));
    }
    const order = Array.from(depth.keys()).sort((a, b) => depth[b] - depth[a]);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.sorted);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indicesOf(order), gl.DYNAMIC_DRAW);
    this.drawPart(part, this.sorted, matrixOf(lens, corner, range));
  }

  drawPart({ buffer, count }, indices, matrix) {
    const { gl, blocks } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
    for (const [name, size, type, isNormal, offset] of [
      ["position", 3, gl.FLOAT, false, 0],
      ["place", 2, gl.UNSIGNED_SHORT, true, LAYOUT.place],
      ["color", 4, gl.UNSIGNED_BYTE, true, LAYOUT.color],
    ]) {
      const at = blocks.attribute(name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, type, isNormal, LAYOUT.stride, offset);
    }
    gl.uniformMatrix4fv(blocks.at("matrix"), false, matrix);
    gl.drawElements(gl.TRIANGLES, 6 * count, gl.UNSIGNED_SHORT, 0);
  }

  drawBehind(lens, shadow) {
    const { gl, behind, canvas } = this;
    const { box, studio } = this.build;
    const staged = (place) => place.map((n, i) => (n - box.center[i]) * box.scale);
    const eye = staged(lens.eye);
    const factor = canvas.height / lens.height;
    gl.useProgram(behind.program);
    gl.bindVertexArray(this.empty);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
    gl.bindTexture(gl.TEXTURE_2D, shadow.texture);
    gl.uniform2f(behind.at("size"), canvas.width, canvas.height);
    gl.uniform4f(behind.at("lens"), lens.fx * factor, lens.fy * factor, lens.cx * factor, lens.cy * factor);
    gl.uniform1i(behind.at("isParallel"), Number(lens.isParallel));
    gl.uniform1f(behind.at("unit"), box.scale);
    gl.uniform3fv(behind.at("eye"), eye);
    for (const [i, name] of ["right", "down", "forward"].entries()) gl.uniform3fv(behind.at(name), lens.axes[i]);
    gl.uniform3fv(behind.at("backdrop"), studio.backdrop);
    gl.uniform1i(behind.at("hasGround"), Number(studio.ground !== null && eye[1] > studio.height + 1e-3));
    gl.uniform1f(behind.at("height"), studio.height);
    gl.uniform3fv(behind.at("ground"), studio.ground?.[0] ?? studio.backdrop);
    gl.uniform3fv(behind.at("other"), studio.ground?.[1] ?? studio.backdrop);
    gl.uniform1f(behind.at("checker"), CHECKER);
    const [x, , z] = staged([shadow.corner[0], 0, shadow.corner[1]]);
    gl.uniform3f(behind.at("shadowPlace"), x, z, shadow.size * box.scale);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}

function indicesOf(order) {
  const indices = new Uint16Array(6 * order.length);
  order.forEach((quad, i) => indices.set([0, 1, 2, 0, 2, 3].map((corner) => 4 * quad + corner), 6 * i));
  return indices;
}

function farFirst(chunks, lens) {
  const middle = (chunk) => depthOf(lens, chunk.corner.map((n) => n + 16));
  return chunks.filter(({ clear }) => clear.length).sort((a, b) => middle(b) - middle(a));
}
