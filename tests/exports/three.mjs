// Load GLB files with three.js: node three.mjs FOLDER_OF_THE_MODULE < JOBS
// A job is {file, times}. Prints one JSON list: for each job the name of the scene, the names of the meshes of the file as
// three.js reads them, and all objects in depth-first order; or an error. An object is of a node or a part of a mesh:
// its name, as three.js has it and as it reads that of the file; the word; the mesh; the world matrix at each time.
import { readFile } from "node:fs/promises";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const root = join(resolve(process.argv[2]), "node_modules", "three");
const load = (name) => import(pathToFileURL(join(root, name)));
const { AnimationMixer, LoopOnce, PropertyBinding } = await load("build/three.module.js");
const { GLTFLoader } = await load("examples/jsm/loaders/GLTFLoader.js");
const clean = (name) => PropertyBinding.sanitizeNodeName(name ?? "");

const read = async ({ file, times }) => {
  const data = await readFile(file);
  const { scene, animations, parser } = await new GLTFLoader().parseAsync(new Uint8Array(data).buffer, "");
  const found = [];
  scene.traverse((object) => {
    const own = parser.associations.get(object) ?? {};
    if (own.nodes === undefined && own.meshes === undefined) return;
    const { name, word } = object.userData;
    const node = own.nodes ?? null;
    found.push({ object, node, name: object.name, read: clean(name), word: word ?? null, mesh: own.meshes ?? null });
  });
  const mixer = new AnimationMixer(scene);
  const actions = animations.map((clip) => mixer.clipAction(clip).setLoop(LoopOnce).play());
  for (const action of actions) action.clampWhenFinished = true;
  const worlds = found.map(() => []);
  for (const time of times) {
    for (const action of actions) action.paused = false;
    mixer.setTime(Math.fround(time));
    scene.updateMatrixWorld(true);
    found.forEach(({ object }, i) => worlds[i].push(object.matrixWorld.toArray()));
  }
  const objects = found.map(({ object, ...rest }, i) => ({ ...rest, worlds: worlds[i] }));
  return { scene: scene.name, meshes: parser.json.meshes.map((mesh) => clean(mesh.name)), objects };
};

let text = "";
for await (const piece of process.stdin) text += piece;
const answers = JSON.parse(text).map((job) => read(job).catch((error) => ({ error: String(error) })));
console.log(JSON.stringify(await Promise.all(answers)));
