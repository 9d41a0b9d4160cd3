// Each program of a page gets a button that opens it in the playground, in place. Without a web server there is none.
const place = document.querySelector(".page-programs")?.dataset.playground;

async function encoded(text) {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let letters = "";
  for (const byte of bytes) letters += String.fromCharCode(byte);
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

function addButton(block) {
  const button = Object.assign(document.createElement("button"), { className: "md-button try-it", textContent: "Try it" });
  let frame = null;
  button.addEventListener("click", async () => {
    if (frame) {
      frame.remove();
      frame = null;
      block.hidden = false;
      button.textContent = "Try it";
      return;
    }
    const text = block.querySelector("code").textContent;
    frame = Object.assign(document.createElement("iframe"), { className: "try", title: "The program in the playground", src: `${place}index.html?embed#code=${await encoded(text)}` });
    block.after(frame);
    block.hidden = true;
    button.textContent = "Close";
  });
  block.before(button);
}

if (place && location.protocol.startsWith("http")) for (const block of document.querySelectorAll(".language-scene.highlight")) addButton(block);
