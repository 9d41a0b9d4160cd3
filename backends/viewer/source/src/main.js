// The viewer of `scenelang view`, and of a page that was saved.
import { byId } from "./dom.js";
import { Page } from "./page.js";
import { Saved, Server } from "./server.js";

const saved = byId("scenes");
const page = new Page(saved ? new Saved(saved) : new Server());
page.start();
window.scenelangPage = page; // for the console and the tests
