// What deepslate makes of a state of a block: quads of a unit cube's cell, each as plain numbers.
import { Identifier } from "deepslate/core";
import { BlockColors, BlockDefinition, BlockModel, Mesh } from "deepslate/render";
import { specialMesh } from "./special.js";

// The tints of a temperate plain, those of the average colours in backends/minecraft/textures.py.
const GRASS = [0x91 / 255, 0xbd / 255, 0x59 / 255];
const LEAVES = [0x77 / 255, 0xab / 255, 0x2f / 255];
const WATER = [0x3f / 255, 0x76 / 255, 0xe4 / 255];
const SIDES = ["down", "up", "north", "south", "west", "east"];
const INSET = 1 / 64; // of a texture's pixel: its neighbours in the picture must not show at the edges
const WITHIN = 1 / 1000; // of a cell
const SHADES = { x: 0.6, down: 0.5, up: 1.0, z: 0.8 }; // the game's light on faces

for (const [own, color] of [[BlockColors.grass({}), GRASS], [BlockColors.oak_leaves({}), LEAVES], [BlockColors.water({}), WATER]]) {
  const alike = Object.keys(BlockColors).filter((name) => BlockColors[name]({}).join() === own.join());
  for (const name of alike) BlockColors[name] = () => color;
}

export class Quads {
  constructor({ states, models, atlas }) {
    this.states = states;
    this.atlas = atlas;
    const textures = Object.fromEntries(Object.keys(atlas.places).map((name) => [name, name])); // faces name them in full
    this.models = new Map(Object.entries(models).map(([name, model]) => [name, BlockModel.fromJson({ elements: model.elements, textures })]));
    this.translucent = atlas.translucent.map((name) => atlas.places[name]);
    this.known = new Map();
  }

  // The places of textures and of models, as deepslate asks for them.
  getTextureUV(id) {
    const { side, places } = this.atlas;
    return (places[id.toString()] ?? places["minecraft:missing"]).map((pixel) => pixel / side);
  }

  getBlockModel(id) {
    return this.models.get(id.toString()) ?? null;
  }

  // The quads of state `number` without those that cull towards `hidden` sides (bits, as `SIDES`). Water hides that of
  // its neighbours, but no block that stands in it, whose sides only solid cubes hide.
  of(number, hidden, solid) {
    const state = this.states[number];
    const own = state.isWet ? solid : hidden;
    const key = (number * 64 + hidden) * 64 + own;
    if (!this.known.has(key)) this.known.set(key, [...this.made(state, culled(own)), ...(state.isWet ? this.water(culled(hidden)) : [])]);
    return this.known.get(key);
  }

  made({ name, properties, parts, isSpecial }, cull) {
    const definition = new BlockDefinition(undefined, parts.map((part) => ({ apply: part })));
    const mesh = new Mesh();
    mesh.merge(definition.getMesh(Identifier.parse(name), properties, this, this, cull));
    if (isSpecial) mesh.merge(specialMesh(name, { ...properties, waterlogged: "false" }, this, cull));
    return mesh.quads.map((quad) => this.plain(quad));
  }

  // The water around a block, its sides a little within the cell: the block's own sides there lie before it, as in the game.
  water(cull) {
    const mesh = specialMesh("minecraft:water", { level: "0" }, this, cull);
    return mesh.quads.map((quad) => {
      const plain = this.plain(quad);
      return { ...plain, positions: plain.positions.map((n, i) => n - WITHIN * plain.axis[i % 3]) };
    });
  }

  plain(quad) {
    const vertices = quad.vertices();
    const normal = quad.normal().components();
    const us = vertices.map((vertex) => vertex.texture[0]);
    const vs = vertices.map((vertex) => vertex.texture[1]);
    const [u, v] = [middle(us), middle(vs)];
    const inset = INSET / this.atlas.side;
    return {
      positions: vertices.flatMap((vertex) => vertex.pos.components()),
      places: vertices.flatMap((_, i) => [us[i] + Math.sign(u - us[i]) * inset, vs[i] + Math.sign(v - vs[i]) * inset]),
      color: vertices[0].color.map((part) => part * shade(normal)),
      axis: axisOf(normal),
      isClear: this.isClear(u * this.atlas.side, v * this.atlas.side),
    };
  }

  isClear(x, y) {
    return this.translucent.some(([left, top, right, bottom]) => left < x && x < right && top < y && y < bottom);
  }
}

// The sides whose bits are set, as deepslate asks for them.
function culled(bits) {
  return Object.fromEntries(SIDES.map((side, k) => [side, Boolean(bits & (1 << k))]));
}

function middle(values) {
  return (Math.min(...values) + Math.max(...values)) / 2;
}

// The game's light on a face; between its six directions, in proportion.
function shade([x, y, z]) {
  return x * x * SHADES.x + z * z * SHADES.z + y * y * (y < 0 ? SHADES.down : SHADES.up);
}

// The step along the axis in which a quad faces, null where it leans.
function axisOf(normal) {
  const k = normal.findIndex((part) => Math.abs(part) > 0.999);
  return k < 0 ? null : [0, 1, 2].map((i) => (i === k ? Math.sign(normal[i]) : 0));
}
