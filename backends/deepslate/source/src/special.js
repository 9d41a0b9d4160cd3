// Blocks without models: those that deepslate draws by itself, and two kinds that it could draw but does not know.
import { BlockState, Identifier } from "deepslate/core";
import { SpecialRenderers } from "deepslate/render";

const WALL_HEAD = /^minecraft:(\w+)_wall_(head|skull)$/;
const TURNS = { south: "0", east: "4", north: "8", west: "12" }; // deepslate's rotation of a head that faces there
const BEHIND = { south: [0, -1], east: [-1, 0], north: [0, 1], west: [1, 0] }; // the way to the wall, along x and z
const OFF = 1 / 4; // of a cell: how far a head at a wall is above the floor, and behind the cell's centre

export function specialMesh(name, properties, atlas, cull) {
  const drawn = (other, has, textures = atlas) => SpecialRenderers.getBlockMesh(new BlockState(other, has), undefined, textures, cull);
  if (name === "minecraft:shulker_box") return drawn("minecraft:purple_shulker_box", properties, undyed(atlas));
  const [, kind, part] = name.match(WALL_HEAD) ?? [];
  if (!kind) return drawn(name, properties);
  const facing = properties.facing ?? "north";
  const mesh = drawn(`minecraft:${kind}_${part}`, { rotation: TURNS[facing] });
  const [x, z] = BEHIND[facing];
  for (const vertex of mesh.quads.flatMap((quad) => quad.vertices())) vertex.pos = vertex.pos.add({ x: OFF * x, y: OFF, z: OFF * z });
  return mesh;
}

function undyed(atlas) {
  return { getTextureUV: (id) => atlas.getTextureUV(id.path === "entity/shulker/shulker_purple" ? Identifier.create("entity/shulker/shulker") : id) };
}
