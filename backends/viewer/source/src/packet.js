// The packet of a scene (backends/viewer/packet.py): a JSON header and typed columns.

const TYPES = { f4: Float32Array, i4: Int32Array, u4: Uint32Array, u1: Uint8Array };

// The magic and the header of a buffer, and where what follows starts.
function headerOf(buffer) {
  const magic = String.fromCharCode(...new Uint8Array(buffer, 0, 4));
  const length = new DataView(buffer).getUint32(4, true);
  return { magic, header: JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length))), start: 8 + length };
}

// The packet that an answer of the server is, or that its changes make of the `old` one.
export function withChanges(old, answer) {
  const { magic, header: parts, start } = headerOf(answer);
  if (magic !== "SCNC") return answer;
  const made = new Uint8Array(parts.reduce((sum, [, length]) => sum + length, 0));
  let [end, next] = [0, start];
  for (const [at, length] of parts) {
    made.set(at < 0 ? new Uint8Array(answer, next, length) : new Uint8Array(old, at, length), end);
    end += length;
    if (at < 0) next += length;
  }
  return made.buffer;
}

// The header's fields together with `columns`, arrays by name; throws where the bytes are no packet.
export function decode(buffer) {
  const { magic, header, start } = headerOf(buffer);
  if (magic !== "SCNV") throw new Error("these bytes are no scene");
  const columns = {};
  for (const [name, [type, offset, size]] of Object.entries(header.columns)) {
    columns[name] = new TYPES[type](buffer, start + offset, size);
  }
  return { ...header, columns };
}
