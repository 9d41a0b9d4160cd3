// The dome around a scene (backends/surfaces/dome.py): its radiance by direction, sharp, blurred by rough surfaces, and
// the light that it sends onto surfaces. The page makes these tables from the gradient and the softboxes of the studio,
// or from a panorama.
import { ClampToEdgeWrapping, DataArrayTexture, DataTexture, DataUtils, HalfFloatType, LinearFilter, RepeatWrapping, RGBAFormat } from "three";

const [HEIGHT, SOURCE, TABLE] = [128, 32, 24]; // rows of images in latitude and longitude
const BLURS = [0.25, 0.5, 0.75, 1]; // roughnesses of blurred images

// The textures `dome`, and `domeTables` in layers: one for each blur, then light from above the horizon and from all
// around.
export function domeOf({ sky, ambient }, panorama) {
  const image = panorama ?? gradient(sky, ambient);
  const height = Math.sqrt(image.length / 6);
  const dome = prepared(new DataTexture(halves(image), 2 * height, height, RGBAFormat, HalfFloatType));
  const domeTables = prepared(new DataArrayTexture(halves(tabled(smaller(image, height))), 2 * TABLE, TABLE, BLURS.length + 2));
  domeTables.type = HalfFloatType;
  return { dome, domeTables };
}

function prepared(texture) {
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.wrapS = RepeatWrapping;
  texture.wrapT = ClampToEdgeWrapping;
  texture.needsUpdate = true;
  return texture;
}

function halves(colors) {
  const data = new Uint16Array((colors.length / 3) * 4);
  for (let i = 0; i < colors.length; i += 1) data[Math.floor(i / 3) * 4 + (i % 3)] = DataUtils.toHalfFloat(colors[i]);
  return data;
}

// The directions of an image's pixels.
function directions(height) {
  const found = new Float64Array(height * 2 * height * 3);
  for (let row = 0, at = 0; row < height; row += 1) {
    const polar = ((row + 0.5) / height) * Math.PI;
    for (let column = 0; column < 2 * height; column += 1, at += 3) {
      const around = ((column + 0.5) / (2 * height) - 0.5) * 2 * Math.PI;
      found.set([Math.sin(polar) * Math.sin(around), Math.cos(polar), Math.sin(polar) * Math.cos(around)], at);
    }
  }
  return found;
}

// The solid angle of a pixel, by row.
function solidAngles(height) {
  const edge = (row) => Math.cos((row / height) * Math.PI);
  return Float64Array.from({ length: height }, (_, row) => (edge(row) - edge(row + 1)) * (Math.PI / height));
}

function gradient(sky, ambient) {
  const boxes = sky.softboxes.map(softbox);
  const toward = directions(HEIGHT);
  const image = new Float64Array(toward.length);
  const angles = solidAngles(HEIGHT);
  const mean = [0, 0, 0];
  let weights = 0;
  for (let at = 0; at < image.length; at += 3) {
    const d = toward.subarray(at, at + 3);
    const weight = Math.max(d[1], 0) * angles[Math.floor(at / (6 * HEIGHT))];
    const shares = boxes.map((share) => share(d));
    for (let c = 0; c < 3; c += 1) {
      let value = sky.horizon[c] + (sky.zenith[c] - sky.horizon[c]) * Math.max(d[1], 0) + (sky.nadir[c] - sky.horizon[c]) * Math.sqrt(Math.max(-d[1], 0));
      sky.softboxes.forEach(({ radiance }, i) => { value += shares[i] * radiance[c]; });
      image[at + c] = value;
      mean[c] += weight * value;
    }
    weights += weight;
  }
  return image.map((value, i) => (value / mean[i % 3]) * weights * ambient[i % 3]);
}

// The share of a softbox's radiance by direction; its edges are soft.
function softbox({ azimuth, elevation, width, height }) {
  const [a, e, w, h] = [azimuth, elevation, width, height].map((degrees) => (degrees * Math.PI) / 180);
  const middle = [Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)];
  const right = [Math.cos(a), 0, -Math.sin(a)];
  const up = [-middle[1] * Math.sin(a), Math.cos(e), -middle[1] * Math.cos(a)];
  const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  return (d) => {
    const ahead = dot(d, middle);
    return ahead <= 0 ? 0 : step(1 - Math.abs(dot(d, right)) / ahead / Math.tan(w)) * step(1 - Math.abs(dot(d, up)) / ahead / Math.tan(h));
  };
}

function step(inside) {
  const t = Math.min(Math.max(inside * 4, 0), 1);
  return t * t * (3 - 2 * t);
}

// An image of `height` rows with SOURCE rows.
function smaller(image, height) {
  const found = new Float64Array(SOURCE * 2 * SOURCE * 3);
  const [fine, coarse, block] = [solidAngles(height), solidAngles(SOURCE), height / SOURCE];
  for (let at = 0; at < image.length; at += 3) {
    const [row, column] = [Math.floor(at / (6 * height)), (at / 3) % (2 * height)];
    const [low, over] = [Math.floor(row / block), Math.floor(column / block)];
    const share = fine[row] / coarse[low];
    for (let c = 0; c < 3; c += 1) found[(low * 2 * SOURCE + over) * 3 + c] += share * image[at + c];
  }
  return found;
}

// Blurred images for a viewer along the normal (GGX facets), and irradiance divided by pi.
function tabled(source) {
  const [toward, normals] = [directions(SOURCE), directions(TABLE)];
  const layers = BLURS.length + 2;
  const size = normals.length;
  const found = new Float64Array(layers * size);
  const angles = solidAngles(SOURCE);
  const alphas = BLURS.map((roughness) => roughness ** 4);
  for (let n = 0; n < size; n += 3) {
    const totals = new Float64Array(BLURS.length);
    for (let s = 0; s < source.length; s += 3) {
      const cosine = normals[n] * toward[s] + normals[n + 1] * toward[s + 1] + normals[n + 2] * toward[s + 2];
      if (cosine <= 0) continue;
      const light = cosine * angles[Math.floor(s / (6 * SOURCE))];
      const straight = 0.5 + 0.5 * cosine; // square of the cosine between the normal and the facet that reflects
      for (let layer = 0; layer < layers; layer += 1) {
        if (layer === BLURS.length && toward[s + 1] <= 0) continue;
        const alpha = alphas[layer];
        const weight = layer < BLURS.length ? (alpha / (straight * (alpha - 1) + 1) ** 2) * light : light / Math.PI;
        if (layer < BLURS.length) totals[layer] += weight;
        for (let c = 0; c < 3; c += 1) found[layer * size + n + c] += weight * source[s + c];
      }
    }
    for (let layer = 0; layer < BLURS.length; layer += 1) for (let c = 0; c < 3; c += 1) found[layer * size + n + c] /= totals[layer];
  }
  return found;
}
