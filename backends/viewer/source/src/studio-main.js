// The page of `scenelang studio`.
import { Server } from "./server.js";
import { Studio } from "./studio.js";

const server = new Server();
server.client = crypto.randomUUID();
const page = new Studio(server);
server.files().then(() => page.start());
window.scenelangPage = page; // for the console and the tests
