// Builds ../static: one script, one style sheet, one page, the textures of blocks without models, and the licences.
import { build } from "esbuild";
import { copyFile, readFile, writeFile } from "node:fs/promises";
import { gunzipSync } from "node:zlib";
import { specialMesh } from "./src/special.js";

const out = new URL("../static/", import.meta.url);

const made = await build({
  entryPoints: ["src/main.js"],
  outfile: new URL("page.js", out).pathname,
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  legalComments: "none",
  logLevel: "warning",
  metafile: true,
  nodePaths: ["node_modules"], // the viewer's camera finds three.js here
});
await copyFile("src/page.css", new URL("page.css", out));
await copyFile("src/page.html", new URL("page.html", out));
await writeFile(new URL("special.json", out), `${JSON.stringify(await specialTextures())}\n`);
await writeFile(new URL("THIRD-PARTY.txt", out), await licences(Object.entries(made.metafile.outputs)[0][1].inputs));

// The textures that deepslate asks for where it draws a block by itself, by block.
async function specialTextures() {
  const table = gunzipSync(await readFile("../../minecraft/blocks.tsv.gz")).toString("ascii");
  const found = {};
  for (const line of table.split("\n").slice(1)) {
    const name = `minecraft:${line.split("\t")[0]}`;
    const asked = new Set();
    const atlas = { getTextureUV: (id) => { asked.add(id.toString()); return [0, 0, 1, 1]; } };
    if (line) specialMesh(name, {}, atlas, {});
    if (asked.size) found[name] = [...asked].sort();
  }
  return found;
}

// The licences of the packages of which something is in the script.
async function licences(inputs) {
  const used = Object.entries(inputs).filter(([, input]) => input.bytesInOutput > 0).map(([path]) => path);
  const names = [...new Set(used.map((path) => path.match(/node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1]).filter(Boolean))].sort();
  const texts = await Promise.all(names.map(async (name) => {
    const { version } = JSON.parse(await readFile(`node_modules/${name}/package.json`, "utf8"));
    const file = ["LICENSE", "LICENSE.md", "LICENSE.mkd"].map((each) => readFile(`node_modules/${name}/${each}`, "utf8"));
    return `page.js contains ${name} ${version}, used under this licence:\n\n${(await Promise.any(file)).trim()}\n`;
  }));
  return texts.join(`\n${"-".repeat(80)}\n\n`);
}
