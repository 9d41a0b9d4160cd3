// The packet of a scene (backends/viewer/packet.py): a JSON header and typed columns.

const TYPES = { f4: Float32Array, i4: Int32Array, u4: Uint32Array, u1: Uint8Array };

// The header's fields together with `columns`, arrays by name; throws where the bytes are no packet.
export function decode(buffer) {
  const bytes = new Uint8Array(buffer, 0, 4);
  if (String.fromCharCode(...bytes) !== "SCNV") throw new Error("these bytes are no scene");
  const length = new DataView(buffer).getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const start = 8 + length;
  const columns = {};
  for (const [name, [type, offset, size]] of Object.entries(header.columns)) {
    columns[name] = new TYPES[type](buffer, start + offset, size);
  }
  return { ...header, columns };
}
