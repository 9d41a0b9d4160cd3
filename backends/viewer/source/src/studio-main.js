// The page of `scenelang studio`, and of the widget in notebooks.
import { startWidget } from "./frame.js";
import { Server } from "./server.js";
import { Studio } from "./studio.js";

async function startStudio() {
  const server = new Server();
  server.client = crypto.randomUUID();
  await server.files();
  const page = new Studio(server);
  await page.start();
  return page;
}

const isWidget = document.querySelector('meta[name="widget"]') !== null;
(isWidget ? startWidget() : startStudio()).then((page) => { window.scenelangPage = page; }); // for the console and the tests
