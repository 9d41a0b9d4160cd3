// node tokenise.cjs GRAMMAR MODULES FILE...: the scopes of every piece of text, as JSON, by vscode-textmate.
"use strict";

const fs = require("node:fs");
const path = require("node:path");

const [grammarFile, modules, ...files] = process.argv.slice(2);
const oniguruma = require(path.join(modules, "vscode-oniguruma"));
const { Registry, parseRawGrammar, INITIAL } = require(path.join(modules, "vscode-textmate"));

async function main() {
  const wasm = fs.readFileSync(path.join(modules, "vscode-oniguruma", "release", "onig.wasm"));
  await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.byteLength));
  const onigLib = {
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  };
  const loadGrammar = async () => parseRawGrammar(fs.readFileSync(grammarFile, "utf8"), "scene.json");
  const grammar = await new Registry({ onigLib: Promise.resolve(onigLib), loadGrammar }).loadGrammar("source.scene");
  const found = {};
  for (const file of files) {
    let stack = INITIAL;
    found[file] = [];
    for (const line of fs.readFileSync(file, "utf8").split("\n")) {
      const result = grammar.tokenizeLine(line, stack);
      stack = result.ruleStack;
      for (const token of result.tokens) {
        found[file].push([line.slice(token.startIndex, token.endIndex), token.scopes.slice(1).join(" ")]);
      }
    }
  }
  process.stdout.write(JSON.stringify(found));
}

main();
