// Gaussians of a scene in place of its solids: one quad each, drawn from far to near.
import { BufferAttribute, CustomBlending, DataTexture, DynamicDrawUsage, FloatType, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, NearestFilter, OneFactor, OneMinusSrcAlphaFactor, RGBAFormat, ShaderMaterial, Vector2 } from "three";
import { SPLAT_FRAGMENT, SPLAT_VERTEX } from "./shaders.js";

const TEXELS = 4; // a Gaussian: place, covariance (two), color
const WIDTH = 4096;
const LEVELS = 65536; // of depth, for the order

export class Splats {
  constructor(packet) {
    this.columns = packet.columns;
    const { splatStart, splatPlace } = this.columns;
    const most = Math.max(...[...splatStart.slice(1)].map((end, i) => end - splatStart[i]), 1);
    this.order = new InstancedBufferAttribute(new Float32Array(most), 1);
    this.order.setUsage(DynamicDrawUsage);
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]), 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    geometry.setAttribute("splat", this.order);
    this.data = dataTexture(this.columns, splatPlace.length / 3);
    const uniforms = { data: { value: this.data }, viewport: { value: new Vector2(1, 1) } };
    const blending = { blending: CustomBlending, blendSrc: OneFactor, blendDst: OneMinusSrcAlphaFactor, transparent: true, depthWrite: false };
    this.mesh = new Mesh(geometry, new ShaderMaterial({ vertexShader: SPLAT_VERTEX, fragmentShader: SPLAT_FRAGMENT, uniforms, ...blending }));
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
    this.depths = new Uint16Array(most);
    this.counts = new Uint32Array(LEVELS + 1);
    this.show(0);
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.data.dispose();
  }

  show(frame) {
    [this.first, this.end] = [this.columns.splatStart[frame], this.columns.splatStart[frame + 1]];
    this.mesh.geometry.instanceCount = this.end - this.first;
    this.mesh.visible = this.end > this.first;
  }

  // Orders the shown frame from far to near; a counting sort, so that a hundred thousand take a few milliseconds.
  arrange(camera) {
    const { first, end, depths, counts, columns: { splatPlace } } = this;
    const m = camera.matrixWorldInverse.elements;
    const depth = (i) => m[2] * splatPlace[3 * i] + m[6] * splatPlace[3 * i + 1] + m[10] * splatPlace[3 * i + 2];
    let [low, high] = [Infinity, -Infinity];
    for (let i = first; i < end; i += 1) {
      const d = depth(i);
      if (d < low) low = d;
      if (d > high) high = d;
    }
    const scale = (LEVELS - 1) / Math.max(high - low, 1e-9);
    counts.fill(0);
    for (let i = first; i < end; i += 1) {
      const level = Math.round((depth(i) - low) * scale);
      depths[i - first] = level;
      counts[level + 1] += 1;
    }
    for (let level = 0; level < LEVELS; level += 1) counts[level + 1] += counts[level];
    const out = this.order.array;
    for (let i = first; i < end; i += 1) {
      out[counts[depths[i - first]]] = i;
      counts[depths[i - first]] += 1;
    }
    this.order.needsUpdate = true;
  }

  resize(width, height) {
    this.mesh.material.uniforms.viewport.value.set(width, height);
  }
}

function dataTexture({ splatPlace, splatSpread, splatColor }, count) {
  const height = Math.max(1, Math.ceil((count * TEXELS) / WIDTH));
  const data = new Float32Array(WIDTH * height * 4);
  for (let i = 0; i < count; i += 1) {
    const at = 4 * TEXELS * i;
    data.set(splatPlace.subarray(3 * i, 3 * i + 3), at);
    data.set(splatSpread.subarray(6 * i, 6 * i + 6), at + 4);
    for (let c = 0; c < 4; c += 1) data[at + 12 + c] = splatColor[4 * i + c] / 255;
  }
  const texture = new DataTexture(data, WIDTH, height, RGBAFormat, FloatType);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}
