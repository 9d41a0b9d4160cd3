// Builds ../static: the scripts, one style sheet, one page, and the licenses of what the scripts contain. With the name
// of a folder, builds the playground there: a static site, with Pyodide and manifold-3d beside it.
import { build } from "esbuild";
import { createHash, randomBytes } from "node:crypto";
import { copyFile, mkdir, readdir, readFile, unlink, writeFile } from "node:fs/promises";
import { join } from "node:path";

const [folder] = process.argv.slice(2);
const ARCHIVES = ["scenelang", "packages"]; // of the playground's Python: the interpreter, and what others wrote
const common = { bundle: true, minify: true, target: "es2022", legalComments: "none", logLevel: "warning" };

async function licenses() {
  const packages = JSON.parse(await readFile("package.json", "utf8")).devDependencies;
  const texts = await Promise.all(
    Object.keys(packages).filter((name) => name !== "esbuild").map(async (name) => {
      const { version } = JSON.parse(await readFile(`node_modules/${name}/package.json`, "utf8"));
      const files = (await readdir(`node_modules/${name}`)).filter((file) => /^licen[cs]e/i.test(file));
      const text = files.length ? await readFile(`node_modules/${name}/${files[0]}`, "utf8") : "Mozilla Public License 2.0";
      return `${name} ${version}:\n\n${text.trim()}\n`;
    }),
  );
  return `The scripts contain, or the playground has beside it:\n\n${texts.join("\n\n")}`;
}

async function buildStatic() {
  const out = new URL("../static/", import.meta.url);
  for (const [entry, name] of [["main", "viewer"], ["studio-main", "studio"]]) {
    await build({ ...common, entryPoints: [`src/${entry}.js`], outfile: new URL(`${name}.js`, out).pathname, format: "iife" });
  }
  await copyFile("src/viewer.css", new URL("viewer.css", out));
  await copyFile("src/page.html", new URL("page.html", out));
  await writeFile(new URL("THIRD-PARTY.txt", out), await licenses());
}

const NONCE = randomBytes(12).toString("base64url"); // of the styles that the editor makes
const POLICY =
  "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'nonce-" + NONCE + "'; img-src data: blob:; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'";

// Compiles the archives' sources with Pyodide, which halves the time until the first image. A tar compressed as a whole
// is two thirds of a zip, since modules resemble each other.
async function compile(out) {
  const { loadPyodide } = await import("pyodide");
  const python = await loadPyodide();
  python.runPython(`
import io, importlib._bootstrap_external as bootstrap, lzma, tarfile, types, zipfile
from importlib.util import source_hash

def without_lines(code):  # line numbers are two fifths of the code's size; errors of programs have places of their own
    inner = tuple(without_lines(value) if isinstance(value, types.CodeType) else value for value in code.co_consts)
    return code.replace(co_linetable=b"", co_consts=inner)

def compiled(name, content):
    code = compile(content, "/modules/" + name, "exec", dont_inherit=True, optimize=2)
    return bytes(bootstrap._code_to_hash_pyc(without_lines(code), source_hash(content), False))

def packed(data):
    result = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data.to_py())) as sources, tarfile.open(fileobj=result, mode="w:xz", preset=9 | lzma.PRESET_EXTREME) as archive:
        for name in sources.namelist():
            content = sources.read(name)
            is_module = name.endswith(".py")
            entry = tarfile.TarInfo(name + "c" if is_module else name)
            content = compiled(name, content) if is_module else content
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    return result.getvalue()
`);
  const packed = python.globals.get("packed");
  for (const name of ARCHIVES) {
    const source = join(out, `${name}.zip`);
    await writeFile(join(out, `${name}.tar.xz`), packed(new Uint8Array(await readFile(source))).toJs());
    await unlink(source);
  }
}

async function buildPlayground(out) {
  await mkdir(out, { recursive: true });
  await compile(out);
  await build({ ...common, entryPoints: ["src/playground.js"], outfile: join(out, "playground.js"), format: "iife" });
  await build({ ...common, entryPoints: ["src/worker.js"], outfile: join(out, "worker.js"), format: "esm", external: ["node:*", "module", "fs", "path", "url", "vm", "crypto", "ws", "child_process"] });
  await copyFile("src/viewer.css", join(out, "viewer.css"));
  for (const file of ["pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json"]) await copyFile(`node_modules/pyodide/${file}`, join(out, file));
  await copyFile("node_modules/manifold-3d/manifold.wasm", join(out, "manifold.wasm"));
  await writeFile(join(out, "THIRD-PARTY.txt"), await licenses());
  const page = await readFile("src/page.html", "utf8");
  const head = `<meta http-equiv="Content-Security-Policy" content="${POLICY}">\n<meta name="style-nonce" content="${NONCE}">\n<meta name="description" content="Write, see and share Scene Language programs in the browser.">\n<link rel="stylesheet" href="viewer.css">`;
  const hint = '<noscript>The playground needs JavaScript.</noscript>\n<script src="playground.js" defer></script>';
  await writeFile(join(out, "index.html"), page.replace("<!--head-->", head).replace("<!--body-->", hint).replace("<title>scenelang</title>", "<title>Scene Language playground</title>"));
  const files = ["index.html", "playground.js", "worker.js", "viewer.css", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json", "manifold.wasm", ...ARCHIVES.map((name) => `${name}.tar.xz`), "examples.json"];
  const hash = createHash("sha256");
  for (const file of files) hash.update(await readFile(join(out, file)));
  const script = await readFile("src/offline.js", "utf8");
  await writeFile(join(out, "offline.js"), script.replace("VERSION", hash.digest("hex").slice(0, 12)).replace("FILES", JSON.stringify(files)));
}

if (folder) await buildPlayground(folder);
else await buildStatic();
process.exit(0); // Pyodide keeps the process alive
