// The entity DAG: what the tree, paths, handles and counts are worked out from, without ever expanding it.

export class Graph {
  constructor(packet) {
    this.packet = packet;
    const { nodeStart, nodeChild, nodePrimitive, nodeEmbedding } = packet.columns;
    this.start = nodeStart;
    this.child = nodeChild;
    const count = nodePrimitive.length;
    this.leaves = new Float64Array(count); // primitives below and including each node
    this.unhandled = new Float64Array(count); // instances below and including it whose embedding has no handle
    for (let node = 0; node < count; node += 1) {
      let leaves = nodePrimitive[node];
      let unhandled = this.ownHandle(nodeEmbedding[node]) === null ? 1 : 0;
      for (let edge = nodeStart[node]; edge < nodeStart[node + 1]; edge += 1) {
        leaves += this.leaves[nodeChild[edge]];
        unhandled += this.unhandled[nodeChild[edge]];
      }
      this.leaves[node] = leaves;
      this.unhandled[node] = unhandled;
    }
  }

  ownHandle(embedding) {
    return embedding < 0 ? null : this.packet.embeddings[embedding].handle;
  }

  root(frame) {
    return this.packet.roots[frame];
  }

  word(node) {
    return this.packet.words[this.packet.columns.nodeWord[node]];
  }

  isPrimitive(node) {
    return this.packet.columns.nodePrimitive[node] === 1;
  }

  embedding(node) {
    const number = this.packet.columns.nodeEmbedding[node];
    return number < 0 ? null : this.packet.embeddings[number];
  }

  // Where the calls stand that made a primitive, and where the word of another entity is bound; empty where unknown.
  places(node) {
    const at = (number) => (number < 0 ? [] : this.packet.places[number]);
    const { nodePlace, nodeDefinition } = this.packet.columns;
    return { calls: at(nodePlace[node]), definition: at(nodeDefinition[node]) };
  }

  size(node) {
    return this.start[node + 1] - this.start[node];
  }

  // The child of `node` at a position, or null.
  at(node, position) {
    return position >= 0 && position < this.size(node) ? this.child[this.start[node] + position] : null;
  }

  // The nodes on the way along child positions, the root first; null where the path leaves the graph.
  nodesOn(frame, path) {
    const nodes = [this.root(frame)];
    for (const position of path) {
      const next = this.at(nodes[nodes.length - 1], position);
      if (next === null) return null;
      nodes.push(next);
    }
    return nodes;
  }

  // The primitives [low, high) of a frame that are below a path, counted depth first; null where there is none.
  leafRange(frame, path) {
    let node = this.root(frame);
    let low = 0;
    for (const position of path) {
      if (this.at(node, position) === null) return null;
      for (let i = 0; i < position; i += 1) low += this.leaves[this.child[this.start[node] + i]];
      node = this.at(node, position);
    }
    return [low, low + this.leaves[node]];
  }

  // The path of the outermost entity of which all primitives are among [low, high) of a frame.
  pathOfRange(frame, low, high) {
    const path = this.pathOfLeaf(frame, low);
    while (path.length > 1) {
      const [first, last] = this.leafRange(frame, path.slice(0, -1));
      if (first < low || last > high) break;
      path.pop();
    }
    return path;
  }

  // The child positions that lead to the primitive number `leaf` of a frame.
  pathOfLeaf(frame, leaf) {
    return this.descend(frame, leaf, this.leaves, (node) => this.isPrimitive(node));
  }

  // Follows cumulative `counts`: to the item number `index` below the root, where `isItem` tells items.
  descend(frame, index, counts, isItem) {
    let node = this.root(frame);
    const path = [];
    for (;;) {
      if (isItem(node)) {
        if (index === 0) return path;
        index -= 1;
      }
      let position = 0;
      for (; position < this.size(node); position += 1) {
        const below = counts[this.child[this.start[node] + position]];
        if (index < below) break;
        index -= below;
      }
      if (position === this.size(node)) return null;
      path.push(position);
      node = this.at(node, position);
    }
  }

  // The path of the first instance that the form around a place of the text made; null where there is none.
  pathMadeAt(frame, file, line, column) {
    const { places } = this.packet;
    let best = null;
    places.forEach((rows, number) => {
      for (const place of rows) {
        const isBefore = place.line < line || (place.line === line && place.column <= column);
        if (!isBefore || !place.file.endsWith(file)) continue;
        if (best === null || place.line > best.line || (place.line === best.line && place.column > best.column)) best = { ...place, number };
      }
    });
    if (best === null) return null;
    const { nodePlace, nodeDefinition } = this.packet.columns;
    const isMade = (node) => nodePlace[node] === best.number || nodeDefinition[node] === best.number;
    const counts = this.countsWhere(isMade);
    return counts[this.root(frame)] ? this.descend(frame, 0, counts, isMade) : null;
  }

  // How many instances of `word` are below and including each node.
  countsOf(word) {
    return this.countsWhere((node) => this.word(node) === word);
  }

  countsWhere(isItem) {
    const counts = new Float64Array(this.leaves.length);
    for (let node = 0; node < counts.length; node += 1) {
      let count = isItem(node) ? 1 : 0;
      for (let edge = this.start[node]; edge < this.start[node + 1]; edge += 1) count += counts[this.child[edge]];
      counts[node] = count;
    }
    return counts;
  }

  // Instances of every word in a frame: [[word, count], ...] in order of first appearance.
  wordCounts(frame) {
    const instances = new Float64Array(this.leaves.length);
    const root = this.root(frame);
    instances[root] = 1;
    for (let node = root; node >= 0; node -= 1) {
      if (!instances[node]) continue;
      for (let edge = this.start[node]; edge < this.start[node + 1]; edge += 1) instances[this.child[edge]] += instances[node];
    }
    const totals = new Map(this.wordsInOrder(root).map((word) => [word, 0]));
    for (let node = 0; node <= root; node += 1) {
      if (instances[node]) totals.set(this.word(node), totals.get(this.word(node)) + instances[node]);
    }
    return [...totals];
  }

  wordsInOrder(root) {
    const seen = new Uint8Array(this.leaves.length);
    const words = new Set();
    const stack = [root];
    while (stack.length) {
      const node = stack.pop();
      if (seen[node]) continue;
      seen[node] = 1;
      words.add(this.word(node));
      for (let edge = this.start[node + 1] - 1; edge >= this.start[node]; edge -= 1) stack.push(this.child[edge]);
    }
    return [...words];
  }

  // The handle of the instance at a path: its embedding's own, or its number's in the first frame; null beyond it.
  handle(frame, path) {
    const nodes = this.nodesOn(frame, path);
    const own = this.ownHandle(this.packet.columns.nodeEmbedding[nodes[nodes.length - 1]]);
    if (own !== null) return own;
    const first = frame === 0 ? nodes : this.nodesOn(0, path);
    if (first === null) return null;
    let rank = 1;
    for (let i = 0; i < path.length; i += 1) {
      if (this.ownHandle(this.packet.columns.nodeEmbedding[first[i]]) === null) rank += 1;
      for (let j = 0; j < path[i]; j += 1) rank += this.unhandled[this.child[this.start[first[i]] + j]];
    }
    return rank > Number.MAX_SAFE_INTEGER ? null : `z${this.numbered(rank)}`;
  }

  // The number of the instance that is the `rank`-th without a handle: numbers that handles use are left out.
  numbered(rank) {
    let number = rank;
    for (const taken of this.packet.taken) {
      if (taken > number) break;
      number += 1;
    }
    return number;
  }

  // The path as people and `edit_instance` read it: word[i] counts the equal words among siblings.
  spelled(frame, path) {
    const nodes = this.nodesOn(frame, path);
    const parts = [escaped(this.word(nodes[0]))];
    path.forEach((position, depth) => {
      const word = this.word(nodes[depth + 1]);
      let index = 0;
      let same = 0;
      for (let i = 0; i < this.size(nodes[depth]); i += 1) {
        if (this.word(this.at(nodes[depth], i)) !== word) continue;
        if (i < position) index += 1;
        same += 1;
      }
      parts.push(same > 1 ? `${escaped(word)}[${index}]` : escaped(word));
    });
    return parts.join("/");
  }

  // The attribute of the first primitive at or below a node, as text; null without one.
  attribute(node, name) {
    let first = node;
    while (!this.isPrimitive(first) && this.size(first)) first = this.at(first, 0);
    return this.embedding(first)?.attributes?.find(([key]) => key === name)?.[1] ?? null;
  }
}

// A word as a step of a path (`instance_paths.escaped`).
function escaped(word) {
  const text = word.replace(/[/[\]\\]/g, "\\$&");
  return text === "*" || text.startsWith("<") ? `\\${text}` : text;
}
