// Builds ../static: one script, one style sheet, one page, and the licence of what the script contains.
import { build } from "esbuild";
import { copyFile, readFile, writeFile } from "node:fs/promises";

const out = new URL("../static/", import.meta.url);

await build({
  entryPoints: ["src/main.js"],
  outfile: new URL("viewer.js", out).pathname,
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  legalComments: "none",
  logLevel: "warning",
});
await copyFile("src/viewer.css", new URL("viewer.css", out));
await copyFile("src/page.html", new URL("page.html", out));
const three = JSON.parse(await readFile("node_modules/three/package.json", "utf8"));
const licence = await readFile("node_modules/three/LICENSE", "utf8");
await writeFile(
  new URL("THIRD-PARTY.txt", out),
  `viewer.js contains three.js ${three.version}, used under this licence:\n\n${licence.trim()}\n`,
);
