// Starts `scenelang lsp` and runs the command line in a terminal.
"use strict";

const { spawnSync } = require("node:child_process");
const vscode = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");

const TERMINAL = "scenelang";
let client;

function settings() {
  const found = vscode.workspace.getConfiguration("scene");
  return { path: found.get("path"), arguments: found.get("arguments") };
}

function workingFolder() {
  return vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
}

/** Why the command cannot be run, or undefined when it can. */
function problemWith(path) {
  const found = spawnSync(path, ["--version"], { cwd: workingFolder(), timeout: 20000, encoding: "utf8" });
  if (found.error?.code === "ENOENT") {
    return `\`${path}\` was not found: install scenelang, or set "scene.path" to where it is.`;
  }
  if (found.error) return `\`${path}\` cannot be run: ${found.error.message}`;
  return found.status === 0 ? undefined : `\`${path} --version\` failed: ${(found.stderr || "").trim()}`;
}

async function report(message) {
  const chosen = await vscode.window.showErrorMessage(message, "Open settings");
  if (chosen) await vscode.commands.executeCommand("workbench.action.openSettings", "scene.path");
}

async function start() {
  const { path, arguments: args } = settings();
  const problem = problemWith(path);
  if (problem) return void report(problem);
  const server = { command: path, args, transport: TransportKind.stdio, options: { cwd: workingFolder() } };
  const documents = { documentSelector: [{ language: "scene" }] };
  client = new LanguageClient("scene", "Scene Language", server, documents);
  try {
    await client.start();
  } catch (error) {
    client = undefined;
    await report(`The language server did not start: ${error.message}`);
  }
}

async function stop() {
  const running = client;
  client = undefined;
  if (running) await running.stop().catch(() => undefined);
}

async function restart() {
  await stop();
  await start();
}

/** The file of the active editor, saved; undefined with a message when it is no program. */
async function program() {
  const document = vscode.window.activeTextEditor?.document;
  if (document?.languageId !== "scene" || document.isUntitled) {
    await vscode.window.showInformationMessage("Open and save a .scene file first.");
    return undefined;
  }
  if (document.isDirty) await document.save();
  return document.uri.fsPath;
}

/** Runs `scenelang` with arguments in the terminal, without a shell that could read a file's name as a command. */
async function run(name, args) {
  const task = new vscode.Task(
    { type: "process", task: name },
    vscode.TaskScope.Workspace,
    name,
    TERMINAL,
    new vscode.ProcessExecution(settings().path, args, { cwd: workingFolder() }),
  );
  await vscode.tasks.executeTask(task);
}

async function renderDraft() {
  const file = await program();
  if (!file) return;
  const picture = file.replace(/\.scene$/, "") + ".png";
  await run("Render draft", ["render", file, "--quality", "draft", "-o", picture]);
}

async function openViewer() {
  const file = await program();
  if (file) await run("Open viewer", ["view", file]);
}

async function activate(context) {
  context.subscriptions.push(
    vscode.commands.registerCommand("scene.renderDraft", renderDraft),
    vscode.commands.registerCommand("scene.openViewer", openViewer),
    vscode.commands.registerCommand("scene.restartServer", restart),
    vscode.workspace.onDidChangeConfiguration((change) => {
      if (change.affectsConfiguration("scene")) restart();
    }),
  );
  await start();
}

module.exports = { activate, deactivate: stop };
