// The build as backends/deepslate/page.py wrote it: its blocks as typed arrays, frame by frame.
const PLANES = 5; // x, y, z, states, around

export async function readBuild(text) {
  const build = JSON.parse(text);
  const packed = Uint8Array.from(atob(build.cells), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = await new Response(stream).arrayBuffer();
  let at = 0;
  const plane = (Type, count) => {
    const values = new Type(bytes, at, count);
    at += 4 * count;
    return values;
  };
  const distinct = build.counts.map((count) => ({
    count,
    cells: [plane(Int32Array, count), plane(Int32Array, count), plane(Int32Array, count)],
    states: plane(Uint32Array, count),
    around: plane(Uint32Array, count),
  }));
  if (at !== bytes.byteLength || bytes.byteLength !== 4 * PLANES * build.counts.reduce((a, b) => a + b, 0)) throw new Error("the build is damaged");
  const numbers = Object.keys(build.frames).map(Number).sort((a, b) => a - b);
  return { ...build, distinct, numbers };
}

// The picture with all textures, ready for WebGL.
export async function readAtlas(atlas) {
  const image = new Image();
  image.src = atlas.image;
  await image.decode();
  return image;
}
