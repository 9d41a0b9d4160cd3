// Validate glTF files with the Khronos validator: node validate.mjs FOLDER_OF_THE_MODULE FILE...
// Prints one JSON list: for each file its errors, warnings and messages.
import { createRequire } from "node:module";
import { readFile } from "node:fs/promises";
import { basename, dirname, join, resolve } from "node:path";

const [folder, ...files] = process.argv.slice(2);
const validator = createRequire(join(resolve(folder), "package.json"))("gltf-validator");
const found = [];
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: basename(file),
    maxIssues: 20,
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(join(dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, messages } = report.issues;
  found.push({ file, errors: numErrors, warnings: numWarnings, messages });
}
console.log(JSON.stringify(found));
