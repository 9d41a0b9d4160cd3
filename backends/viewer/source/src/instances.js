// What is drawn: one InstancedMesh per geometry and kind of surface, filled with the instances that are to be seen.
import { BufferAttribute, BufferGeometry, DataArrayTexture, DataTexture, DynamicDrawUsage, FloatType, Group, InstancedBufferAttribute, InstancedMesh, LinearFilter, LinearMipmapLinearFilter, Matrix3, Matrix4, NearestFilter, RepeatWrapping, RGBAFormat, SRGBColorSpace, Vector3 } from "three";

const LOOK = 12; // floats a primitive
const PLACEMENT = 24;
const COARSE = 7; // pixels of half diagonal up to which a round solid of few sides looks the same
const MOST_FINE = 4000;
const EVEN = 1e-6; // difference of heights that is rounding
const MOST_FRAMED = 200000; // instances whose silhouette is framed, which takes half a second

export class Instances {
  // `materials(isClear, isTextured, geometry)` gives the material of a kind of surface.
  constructor(packet, materials) {
    this.packet = packet;
    this.group = new Group();
    this.buckets = [];
    this.frame = 0;
    this.shown = 0;
    const { columns } = packet;
    this.ready = columns.rowPose !== undefined;
    if (!this.ready) return;
    this.looks = floatTexture(columns.primitiveLook);
    this.placements = columns.primitiveTexture ? floatTexture(columns.primitiveTexture) : null;
    this.tiles = columns.primitiveTexture ? tileTexture(columns.textureImages, packet.textureSide) : null;
    this.geometries = packet.geometries.map((_, number) => geometryOf(columns, number));
    this.bucketOf = new Int32Array(columns.primitiveGeometry.length).fill(-1);
    const found = new Map();
    columns.primitiveGeometry.forEach((geometry, primitive) => {
      const opacity = columns.primitiveLook[primitive * LOOK + 3];
      if (geometry < 0 || opacity <= 0) return;
      const isTextured = columns.primitiveTexture !== undefined && columns.primitiveTexture[primitive * PLACEMENT] >= 0;
      const key = `${geometry}/${opacity < 1}/${isTextured}`;
      if (!found.has(key)) {
        found.set(key, this.buckets.length);
        const material = materials(opacity < 1, isTextured, packet.geometries[geometry]);
        const { coarse } = packet.geometries[geometry];
        const few = coarse === null ? null : { geometry: coarse, isClear: opacity < 1, material, mesh: null };
        this.buckets.push({ geometry, isClear: opacity < 1, material, mesh: null, few, all: [] });
      }
      this.bucketOf[primitive] = found.get(key);
    });
  }

  dispose() {
    for (const bucket of this.parts()) bucket.mesh?.dispose();
    for (const geometry of this.geometries ?? []) geometry.dispose();
    for (const texture of [this.looks, this.placements, this.tiles]) texture?.dispose();
  }

  get materials() {
    return this.buckets.map((bucket) => bucket.material);
  }

  // The number of primitives in a frame, drawn or not.
  count(frame) {
    return this.ready ? this.packet.columns.frameStart[frame + 1] - this.packet.columns.frameStart[frame] : 0;
  }

  // The row of the instance number `leaf` of a frame.
  row(frame, leaf) {
    return this.packet.columns.frameRow[this.packet.columns.frameStart[frame] + leaf];
  }

  // Fills the meshes with a frame's instances for which `visible(path, node)` holds.
  show(frame, visible) {
    this.frame = frame;
    this.shown = 0;
    if (!this.ready) return;
    const { rowPath, rowPrimitive, primitiveNode } = this.packet.columns;
    const lists = this.buckets.map(() => []);
    const seen = new Map();
    const count = this.count(frame);
    for (let leaf = 0; leaf < count; leaf += 1) {
      const row = this.row(frame, leaf);
      const bucket = this.bucketOf[rowPrimitive[row]];
      if (bucket < 0) continue;
      if (visible) {
        const key = rowPath[row] * 4294967296 + rowPrimitive[row];
        if (!seen.has(key)) seen.set(key, visible(rowPath[row], primitiveNode[rowPrimitive[row]]));
        if (!seen.get(key)) continue;
      }
      lists[bucket].push(leaf);
      this.shown += 1;
    }
    this.buckets.forEach((bucket, number) => {
      bucket.all = lists[number];
      this.fill(bucket, bucket.few ? [] : bucket.all);
      if (bucket.few) this.fill(bucket.few, bucket.all);
    });
  }

  // Every bucket, and those of few sides.
  parts() {
    return this.buckets.flatMap((bucket) => (bucket.few ? [bucket, bucket.few] : [bucket]));
  }

  // Prepares for a camera (`pixels`: of a length 1 at a distance 1): what is large has many sides, what is see-through
  // goes from far to near, so that it covers in the right order.
  arrange(camera, pixels) {
    for (const bucket of this.buckets) {
      const { few, all, isClear } = bucket;
      if (few) {
        const large = this.large(all, camera, pixels);
        const isLarge = new Set(large);
        this.fill(bucket, large);
        this.fill(few, large.length ? all.filter((leaf) => !isLarge.has(leaf)) : all);
      }
      if (isClear) for (const part of few ? [bucket, few] : [bucket]) this.sort(part, camera);
    }
  }

  // Which of `leaves` are larger than COARSE in the picture, at most MOST_FINE of them, the largest.
  large(leaves, camera, pixels) {
    const { rowPose } = this.packet.columns;
    const { x, y, z } = camera.position;
    const found = [];
    for (const leaf of leaves) {
      const at = 12 * this.row(this.frame, leaf);
      let square = 0;
      for (let r = 0; r < 12; r += 4) square += rowPose[at + r] ** 2 + rowPose[at + r + 1] ** 2 + rowPose[at + r + 2] ** 2;
      const distance = camera.isOrthographicCamera ? 1 : Math.hypot(rowPose[at + 3] - x, rowPose[at + 7] - y, rowPose[at + 11] - z);
      const size = (Math.sqrt(square) / Math.max(distance, 1e-6)) * pixels;
      if (size > COARSE) found.push([size, leaf]);
    }
    if (found.length > MOST_FINE) found.sort((a, b) => b[0] - a[0]).length = MOST_FINE;
    return found.map(([, leaf]) => leaf);
  }

  // The number of triangles that are drawn.
  get triangles() {
    return this.parts().reduce((sum, { mesh }) => sum + (mesh ? (mesh.count * mesh.geometry.index.count) / 3 : 0), 0);
  }

  fill(bucket, leaves) {
    if (bucket.mesh === null || bucket.mesh.instanceMatrix.count < leaves.length) this.grow(bucket, leaves.length);
    const { mesh } = bucket;
    if (mesh === null) return;
    bucket.leaves = leaves;
    const poses = mesh.instanceMatrix.array;
    const own = mesh.geometry.getAttribute("instance").array;
    const { rowPose, rowPrimitive } = this.packet.columns;
    leaves.forEach((leaf, i) => {
      const row = this.row(this.frame, leaf);
      for (let r = 0; r < 3; r += 1) for (let c = 0; c < 4; c += 1) poses[16 * i + 4 * c + r] = rowPose[12 * row + 4 * r + c];
      poses[16 * i + 15] = 1;
      own[2 * i] = rowPrimitive[row];
      own[2 * i + 1] = leaf;
    });
    mesh.count = leaves.length;
    mesh.visible = leaves.length > 0;
    mesh.instanceMatrix.needsUpdate = true;
    mesh.geometry.getAttribute("instance").needsUpdate = true;
  }

  grow(bucket, size) {
    if (size === 0) return;
    if (bucket.mesh) {
      this.group.remove(bucket.mesh);
      bucket.mesh.dispose();
    }
    const geometry = this.geometries[bucket.geometry].clone();
    geometry.setAttribute("instance", new InstancedBufferAttribute(new Float32Array(2 * size), 2));
    geometry.getAttribute("instance").setUsage(DynamicDrawUsage);
    bucket.mesh = new InstancedMesh(geometry, bucket.material, size);
    bucket.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    bucket.mesh.frustumCulled = false;
    bucket.mesh.renderOrder = bucket.isClear ? 1 : 0;
    this.group.add(bucket.mesh);
  }

  sort(bucket, camera) {
    const { rowPose } = this.packet.columns;
    const m = camera.matrixWorldInverse.elements;
    if (!bucket.leaves || bucket.leaves.length < 2 || bucket.leaves.length > 20000) return;
    const depth = new Map(bucket.leaves.map((leaf) => {
      const at = 12 * this.row(this.frame, leaf);
      return [leaf, m[2] * rowPose[at + 3] + m[6] * rowPose[at + 7] + m[10] * rowPose[at + 11]];
    }));
    this.fill(bucket, [...bucket.leaves].sort((a, b) => depth.get(a) - depth.get(b)));
  }

  // The farthest point in a direction of what is drawn in all frames, as a function; null without any, or of too many.
  farthest() {
    if (!this.ready) return null;
    const { rowPose, rowPrimitive } = this.packet.columns;
    const rows = Array.from(rowPrimitive.keys()).filter((row) => this.bucketOf[rowPrimitive[row]] >= 0);
    if (!rows.length || rows.length > MOST_FRAMED) return null;
    const extents = this.geometries.map((geometry) => {
      geometry.computeBoundingSphere();
      const { boundingBox: { min, max }, boundingSphere: { center, radius } } = geometry;
      return { center, radius, half: max.clone().sub(min).multiplyScalar(0.5) };
    });
    const bounds = new Float64Array(rows.length);
    return (direction) => {
      const [dx, dy, dz] = direction.toArray();
      let first = 0;
      const local = (at) => [0, 1, 2].map((c) => dx * rowPose[at + c] + dy * rowPose[at + 4 + c] + dz * rowPose[at + 8 + c]);
      rows.forEach((row, i) => {
        const at = 12 * row;
        const { center, radius, half } = extents[this.geometryOf(row)];
        const [x, y, z] = local(at);
        bounds[i] = dx * rowPose[at + 3] + dy * rowPose[at + 7] + dz * rowPose[at + 11] + x * center.x + y * center.y + z * center.z
          + Math.min(radius * Math.hypot(x, y, z), Math.abs(x) * half.x + Math.abs(y) * half.y + Math.abs(z) * half.z);
        if (bounds[i] > bounds[first]) first = i;
      });
      const best = { value: -Infinity, point: new Vector3() };
      this.reach(rows[first], direction, best);
      rows.forEach((row, i) => { if (bounds[i] > best.value + EVEN && i !== first) this.reach(row, direction, best); });
      return best.point;
    };
  }

  geometryOf(row) {
    return this.buckets[this.bucketOf[this.packet.columns.rowPrimitive[row]]].geometry;
  }

  // Replaces `best` by the farthest vertex of an instance if that is farther.
  reach(row, direction, best) {
    const { rowPose } = this.packet.columns;
    const { array, count } = this.geometries[this.geometryOf(row)].getAttribute("position");
    const pose = new Matrix4().set(...rowPose.subarray(12 * row, 12 * row + 12), 0, 0, 0, 1);
    const { x, y, z } = direction.clone().applyMatrix3(new Matrix3().setFromMatrix4(pose).transpose());
    let [farthest, most] = [0, -Infinity];
    for (let i = 0; i < count; i += 1) {
      const value = x * array[3 * i] + y * array[3 * i + 1] + z * array[3 * i + 2];
      if (value > most) [farthest, most] = [i, value];
    }
    const point = new Vector3().fromArray(array, 3 * farthest).applyMatrix4(pose);
    const value = point.dot(direction);
    if (value > best.value) Object.assign(best, { value, point });
  }

  // The box [low, high] in the stage's frame of instances [from, to) of the shown frame; a bound, exact for boxes.
  box(from, to) {
    const { rowPose, rowPrimitive } = this.packet.columns;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let leaf = from; leaf < to; leaf += 1) {
      const row = this.row(this.frame, leaf);
      const bucket = this.bucketOf[rowPrimitive[row]];
      if (bucket < 0) continue;
      const own = this.geometries[this.buckets[bucket].geometry].boundingBox;
      for (let r = 0; r < 3; r += 1) {
        const at = 12 * row + 4 * r;
        let middle = rowPose[at + 3];
        let half = 0;
        ["x", "y", "z"].forEach((axis, c) => {
          middle += (rowPose[at + c] * (own.min[axis] + own.max[axis])) / 2;
          half += (Math.abs(rowPose[at + c]) * (own.max[axis] - own.min[axis])) / 2;
        });
        low[r] = Math.min(low[r], middle - half);
        high[r] = Math.max(high[r], middle + half);
      }
    }
    return low[0] <= high[0] ? { low, high } : null;
  }

  // Where the semantic primitives of the shown frame are, at most `most` of them: [{leaf, x, y, z}].
  semantic(most) {
    const { rowPose, rowPrimitive, primitiveSemantic } = this.packet.columns;
    const found = [];
    for (const bucket of this.buckets) {
      for (const leaf of bucket.all) {
        const row = this.row(this.frame, leaf);
        if (!primitiveSemantic[rowPrimitive[row]]) continue;
        found.push({ node: this.packet.columns.primitiveNode[rowPrimitive[row]], point: [3, 7, 11].map((i) => rowPose[12 * row + i]) });
        if (found.length >= most) return found;
      }
    }
    return found;
  }
}

function geometryOf(columns, number) {
  const geometry = new BufferGeometry();
  const part = (name) => columns[`geometry${number}${name}`];
  geometry.setAttribute("position", new BufferAttribute(part("Positions"), 3));
  geometry.setAttribute("normal", new BufferAttribute(part("Normals"), 3));
  if (part("Colors")) geometry.setAttribute("tint", new BufferAttribute(part("Colors"), 3));
  if (part("Chart")) geometry.setAttribute("chart", new BufferAttribute(part("Chart"), 2));
  geometry.setIndex(new BufferAttribute(part("Indices"), 1));
  geometry.computeBoundingBox();
  return geometry;
}

function floatTexture(floats) {
  const texels = Math.max(1, floats.length / 4);
  const width = Math.min(texels, 3072);
  const height = Math.ceil(texels / width);
  const data = new Float32Array(width * height * 4);
  data.set(floats);
  const texture = new DataTexture(data, width, height, RGBAFormat, FloatType);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

// The images of textures as layers; rows go down.
function tileTexture(images, side) {
  const data = new Uint8Array((images.length / 3) * 4);
  for (let i = 0, at = 0; i < images.length; i += 3, at += 4) {
    data[at] = images[i];
    data[at + 1] = images[i + 1];
    data[at + 2] = images[i + 2];
  }
  const texture = new DataArrayTexture(data, side, side, images.length / (3 * side * side));
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.needsUpdate = true;
  return texture;
}
