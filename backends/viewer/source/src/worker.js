// The interpreter in a web worker: Pyodide, the archive of modules, and npm's manifold-3d for solids. All files are the
// site's own; the worker fetches nothing else, and a program cannot fetch at all.
import Module from "manifold-3d";
import { loadPyodide } from "pyodide";

const at = (name) => new URL(name, self.location.href).href;
let queue = start();

async function start() {
  const archives = ["scenelang", "packages"].map((name) => fetch(at(`${name}.tar.xz`)).then((answer) => answer.arrayBuffer()));
  const solids = Module({ locateFile: () => at("manifold.wasm") }).then((module) => { module.setup(); return module; });
  const env = { HOME: "/home", XDG_CACHE_HOME: "/dev/null" }; // no folder, so that nothing is cached: memory is all there is
  const python = await loadPyodide({ indexURL: at("./"), env, jsglobals: bridge() });
  self.postMessage({ progress: "interpreter" });
  python.registerJsModule("manifold_js", { module: await solids });
  python.registerJsModule("page_js", { send: (message) => self.postMessage({ lsp: message }) });
  for (const [i, archive] of archives.entries()) python.FS.writeFile(`/${i}.tar.xz`, new Uint8Array(await archive));
  await python.runPythonAsync(`
import os, sys, tarfile, time
for name in ("/0.tar.xz", "/1.tar.xz"):
    with tarfile.open(name) as archive:
        archive.extractall("/modules", filter="fully_trusted")  # ours; with the usual checks it takes three times as long
    os.remove(name)
sys.path.insert(0, "/modules")
if not hasattr(time, "thread_time"):
    time.thread_time = time.process_time  # a browser's interpreter has one thread
from page_js import send
from scenelang.playground.in_browser import Playground
playground = Playground(send)
`);
  self.postMessage({ progress: "modules" });
  return python.globals.get("playground");
}

// What Python sees of JavaScript: arrays and objects, no fetch, no page.
function bridge() {
  return { Array, Object, Float32Array, Uint32Array, Float64Array, setTimeout: self.setTimeout.bind(self), clearTimeout: self.clearTimeout.bind(self), Uint8Array, Map, Set, Promise, Error, Symbol, JSON, AbortController: self.AbortController };
}

self.addEventListener("message", ({ data: { id, method, values } }) => {
  queue = queue.then((playground) => {
    try {
      const answer = playground.call(method, JSON.stringify(values));
      reply(id, answer);
    } catch (error) {
      self.postMessage({ id, error: lastLine(error) });
    }
    return playground;
  }, (error) => {
    self.postMessage({ fatal: lastLine(error) });
    throw error;
  });
});

function reply(id, answer) {
  if (id === undefined) return;
  if (answer === undefined || answer === null) self.postMessage({ id, result: null });
  else if (typeof answer === "string") {
    const result = JSON.parse(answer);
    if (result?.error !== undefined) self.postMessage({ id, error: result.hint ? `${result.error}; ${result.hint}` : result.error });
    else self.postMessage({ id, result });
  } else {
    const bytes = answer.toJs();
    answer.destroy();
    self.postMessage({ id, result: bytes }, [bytes.buffer]);
  }
}

function lastLine(error) {
  return String(error.message ?? error).trim().split("\n").pop();
}
