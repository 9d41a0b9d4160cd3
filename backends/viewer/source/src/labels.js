// The words of semantic primitives, written over the picture.
import { Vector3 } from "three";
import { el } from "./dom.js";

const MOST = 150;

export class Labels {
  constructor(layer) {
    this.layer = layer;
    this.isOn = true;
    this.items = [];
  }

  // Takes the labels of what is shown.
  take(instances, graph) {
    const found = instances.ready ? instances.semantic(MOST) : [];
    this.items = found.map(({ node, point }) => ({ at: new Vector3(...point), element: el("span", {}, graph.word(node)) }));
    this.layer.replaceChildren(...this.items.map((item) => item.element));
  }

  clear() {
    this.items = [];
    this.layer.replaceChildren();
  }

  place(camera, width, height) {
    this.layer.hidden = !this.isOn;
    if (!this.isOn) return;
    for (const { at, element } of this.items) {
      const seen = at.clone().project(camera);
      const isInView = Math.abs(seen.x) < 1 && Math.abs(seen.y) < 1 && seen.z > -1 && seen.z < 1;
      element.hidden = !isInView;
      if (isInView) element.style.transform = `translate(-50%, -50%) translate(${((seen.x + 1) / 2) * width}px, ${((1 - seen.y) / 2) * height}px)`;
    }
  }
}
