// Load a GLB file with three.js and print what it shows of textures: node three_textures.mjs FOLDER_OF_THE_MODULE FILE
// One JSON list: for each mesh the world corners of some hundred of its triangles, their texture coordinates, and of its map the number of
// the image in the file, whether rows are upside down, the modes of wrapping (1000 repeats) and the space of colors.
import { readFile } from "node:fs/promises";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const root = join(resolve(process.argv[2]), "node_modules", "three");
const load = (name) => import(pathToFileURL(join(root, name)));
// What the loader of images needs of a browser; the pixels are read from the file by the test.
globalThis.self = globalThis;
globalThis.createImageBitmap = async (blob) => ({ width: 1, height: 1, blob, close() {} });
const { Vector3 } = await load("build/three.module.js");
const { GLTFLoader } = await load("examples/jsm/loaders/GLTFLoader.js");
const data = await readFile(process.argv[3]);
const { scene, parser } = await new GLTFLoader().parseAsync(new Uint8Array(data).buffer, "");
scene.updateMatrixWorld(true);
const found = [];
scene.traverse((mesh) => {
  if (!mesh.isMesh || !mesh.material.map) return;
  const { geometry, material } = mesh;
  const { map } = material;
  const [position, uv] = [geometry.attributes.position, geometry.attributes[map.channel ? `uv${map.channel}` : "uv"]];
  const [corners, places] = [[], []];
  const step = 3 * Math.ceil(geometry.index.count / 900);
  for (let i = 0; i < geometry.index.count; i++) {
    if (i % step > 2) continue;
    const k = geometry.index.getX(i);
    corners.push(...new Vector3().fromBufferAttribute(position, k).applyMatrix4(mesh.matrixWorld).toArray());
    places.push(uv.getX(k), uv.getY(k));
  }
  const image = parser.json.textures[parser.associations.get(map).textures].source;
  const { flipY, wrapS, wrapT, colorSpace, repeat, offset } = map;
  const state = { image, flipY, wrapS, wrapT, colorSpace, repeat: repeat.toArray(), offset: offset.toArray() };
  found.push({ corners, places, color: material.color.toArray(), ...state });
});
console.log(JSON.stringify(found));
