// The picture: the studio's light, the ground, the key light's shadow map, the film, and picking by numbers.
import { Box3, Box3Helper, CircleGeometry, Color, DepthTexture, DoubleSide, FloatType, HalfFloatType, Matrix3, Matrix4, Mesh, NearestFilter, NoBlending, PlaneGeometry, RingGeometry, Scene, ShaderMaterial, Vector2, Vector3, Vector4, WebGLRenderer, WebGLRenderTarget } from "three";
import { domeOf } from "./dome.js";
import { aim, DISTANCE, farView, HALF, Lamps } from "./lamps.js";
import * as shaders from "./shaders.js";

const BELOW = 1e-4; // the ground lies this far under the lowest point, so that flat floors hide it
const LINE = 2; // width of the line around the selection, in CSS pixels
const ACCENT = new Vector3(0.03, 0.24, 0.85);
const SKY_SIZE = 512;
const SAMPLES = 32; // of a still picture: sky directions, places in the pixel, turns of the shadows' taps
const [GROUND, HORIZON] = [150, 2e4]; // radius of the ground where it has shadows, and of all of it
const NOTHING = 1e9; // offset of a section plane that cuts nothing
const SLOW = 120; // milliseconds; where a sample takes longer, a still picture stays as it is
const DEFINES = { SHADOW_HALF: HALF.toFixed(4), SHADOW_DISTANCE: "3.0", SHADOW_NEAR: "1.5", SHADOW_FAR: "4.5", SKY_SAMPLES: String(SAMPLES) };

const AXES = [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, -1)];

export class Stage {
  constructor(canvas) {
    this.renderer = new WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true });
    this.renderer.autoClear = false;
    this.canvas = canvas;
    this.scene = new Scene();
    this.instances = null;
    this.splats = null;
    this.hasGround = true;
    this.shadowFor = null;
    const size = Math.min(2048, this.renderer.capabilities.maxTextureSize);
    this.shadow = depthTarget(size);
    this.light = farView(AXES);
    this.sky = depthTarget(SKY_SIZE);
    this.skyLight = farView(AXES);
    this.lamps = null;
    this.lampMaps = null;
    this.lampsAreOld = false;
    this.plain = new WebGLRenderTarget(1, 1, { type: HalfFloatType }); // a sample of a still picture
    this.sum = new WebGLRenderTarget(1, 1, { type: HalfFloatType, depthBuffer: false });
    this.samples = SAMPLES;
    this.film = new WebGLRenderTarget(1, 1, { type: HalfFloatType, samples: 4 });
    this.pickTarget = new WebGLRenderTarget(1, 1);
    this.selection = new WebGLRenderTarget(1, 1); // where the selected instances are
    this.uniforms = sharedUniforms(this.shadow, this.sky);
    this.ground = this.makeGround();
    this.backdrop = fullScreen(shaders.BACKDROP_FRAGMENT, this.uniforms, { vertexShader: shaders.BACKDROP_VERTEX, defines: DEFINES });
    this.backdrop.renderOrder = -2;
    this.outline = new Box3Helper(new Box3(), new Color(ACCENT.x, ACCENT.y, ACCENT.z));
    this.outline.visible = false;
    this.scene.add(this.backdrop, this.ground, this.outline);
    this.depthMaterial = this.material(shaders.SOLID_VERTEX, shaders.DEPTH_FRAGMENT, { side: DoubleSide });
    this.pickMaterial = this.material(shaders.SOLID_VERTEX, shaders.PICK_FRAGMENT, { side: DoubleSide, blending: NoBlending });
    this.placeMaterial = this.material(shaders.SOLID_VERTEX, shaders.PLACE_FRAGMENT, { side: DoubleSide, blending: NoBlending });
    this.selectedMaterial = this.material(shaders.SELECTED_VERTEX, shaders.SELECTED_FRAGMENT, { side: DoubleSide, blending: NoBlending });
    const selection = { selection: { value: this.selection.texture }, hasSelection: { value: false }, line: { value: new Vector2() }, accent: { value: ACCENT } };
    this.screen = fullScreen(shaders.FILM_FRAGMENT, { picture: { value: null }, isRaw: { value: false }, ...selection, shoulder: this.uniforms.shoulder, exposure: this.uniforms.exposure }, {});
    this.adder = fullScreen(shaders.ADD_FRAGMENT, { picture: { value: this.plain.texture }, share: { value: 1 } }, { transparent: true });
  }

  material(vertexShader, fragmentShader, options) {
    return new ShaderMaterial({ vertexShader, fragmentShader, uniforms: this.uniforms, defines: { ...DEFINES, ...options.defines }, ...without(options, "defines") });
  }

  // The material of solids; mirrored instances are wound the other way round, so both sides are drawn.
  solidMaterial(isClear, isTextured, { colors, chart, closed }) {
    const defines = { ...(colors && { HAS_COLORS: "1" }), ...(chart && { HAS_CHART: "1" }), ...(isClear && closed && { CLOSED: "1" }), ...(isTextured && { TEXTURED: "1" }) };
    return this.material(shaders.SOLID_VERTEX, shaders.SOLID_FRAGMENT, { side: DoubleSide, transparent: isClear, depthWrite: !isClear, defines });
  }

  makeGround() {
    const material = this.material(shaders.GROUND_VERTEX, shaders.GROUND_FRAGMENT, {});
    const parts = [new CircleGeometry(GROUND, 96), new RingGeometry(GROUND, HORIZON, 96)].map((geometry) => new Mesh(geometry.rotateX(-Math.PI / 2), material));
    for (const part of parts) Object.assign(part, { frustumCulled: false, renderOrder: -1 });
    return parts[0].add(parts[1]);
  }

  // Takes over the instances of a packet, and the Gaussians that are seen in their place, or null.
  take(instances, splats, packet) {
    this.leave();
    this.instances = instances;
    this.splats = splats;
    this.scene.add(instances.group);
    if (splats) {
      this.scene.add(splats.mesh);
      splats.resize(this.film.width, this.film.height);
    }
    const { studio, box } = packet;
    const value = (name, next) => { this.uniforms[name].value = next; };
    this.takeStudio(studio, packet.columns.panorama);
    this.takeLights(studio.lights);
    const height = box ? (box.low[1] - box.center[1]) * box.scale - BELOW : -1;
    value("groundHeight", height);
    this.ground.position.y = height;
    if (instances.ready) {
      value("looks", instances.looks);
      value("looksWidth", instances.looks.image.width);
      value("placements", instances.placements);
      value("tiles", instances.tiles);
    }
    this.shadowFor = null;
  }

  takeStudio(studio, panorama) {
    const { uniforms } = this;
    const isNew = !this.studio || JSON.stringify([studio.environment, studio.sky, studio.ambient]) !== JSON.stringify([this.studio.environment, this.studio.sky, this.studio.ambient]);
    this.studio = studio;
    for (const name of ["ambient", "key"]) uniforms[name].value.fromArray(studio[name]);
    uniforms.backdrop.value.fromArray(studio.backdrop ?? studio.ambient);
    uniforms.showsDome.value = studio.backdrop === null;
    (studio.ground ?? [[0, 0, 0], [0, 0, 0]]).forEach((color, i) => uniforms.ground.value[i].fromArray(color));
    for (const name of ["shoulder", "exposure", "isUnlit", "checker"]) uniforms[name].value = studio[name];
    uniforms.fade.value.fromArray(studio.fade);
    uniforms.keySpread.value = Math.tan(studio.keyRadius);
    uniforms.facetAlbedo.value = studio.albedo;
    uniforms.facetGrazing.value = studio.grazing;
    this.restoreClearColor();
    if (!isNew) return;
    for (const [name, texture] of Object.entries(domeOf(studio, panorama))) {
      uniforms[name].value?.dispose();
      uniforms[name].value = texture;
    }
  }

  // Takes over the lights of the program.
  takeLights(lights) {
    const { uniforms } = this;
    const defines = lights.length ? { ...DEFINES, LAMPS: "1" } : DEFINES;
    for (const material of [this.ground.material, ...this.instances.materials]) {
      if (Boolean(material.defines.LAMPS) === Boolean(lights.length)) continue;
      material.defines = { ...material.defines, ...defines };
      if (!lights.length) delete material.defines.LAMPS;
      material.needsUpdate = true;
    }
    if (this.lamps) {
      this.scene.remove(this.lamps.group);
      this.lamps.dispose();
    }
    this.lamps = lights.length ? new Lamps(lights, (own) => new ShaderMaterial({ vertexShader: shaders.GROUND_VERTEX, fragmentShader: shaders.SHINING_FRAGMENT, uniforms: { ...uniforms, ...own } }), this.renderer.capabilities.maxTextureSize) : null;
    if (this.lampMaps && this.lampMaps.width !== this.lamps?.side) {
      this.lampMaps.depthTexture.dispose();
      this.lampMaps.dispose();
      this.lampMaps = null;
    }
    if (!this.lamps) return;
    this.lampMaps ??= depthTarget(this.lamps.side);
    this.scene.add(this.lamps.group);
    uniforms.lamps.value = this.lamps.texture;
    uniforms.lampMaps.value = this.lampMaps.depthTexture;
    uniforms.lampCount.value = lights.length;
    uniforms.lampTiles.value = this.lamps.perSide;
  }

  leave() {
    if (this.instances) {
      this.scene.remove(this.instances.group);
      this.instances.dispose();
    }
    if (this.splats) {
      this.scene.remove(this.splats.mesh);
      this.splats.dispose();
    }
    this.instances = this.splats = null;
  }

  // Shows the backdrop alone.
  clear() {
    if (!this.instances) return;
    this.leave();
    this.renderer.setRenderTarget(null);
    this.renderer.clear();
  }

  // What is drawn has changed, so the shadow map is old.
  changed() {
    this.shadowFor = null;
  }

  resize(width, height, ratio) {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.film.setSize(Math.round(width * ratio), Math.round(height * ratio));
    this.plain.setSize(this.film.width, this.film.height);
    this.selection.setSize(this.film.width, this.film.height);
    this.screen.material.uniforms.line.value.set(LINE / width, LINE / height);
    this.sum.setSize(this.film.width, this.film.height);
    this.splats?.resize(this.film.width, this.film.height);
  }

  select(range, box) {
    this.uniforms.selected.value.set(range ? range[0] : 0, range ? range[1] : 0);
    this.outline.visible = Boolean(box);
    if (box) this.outline.box.set(new Vector3(...box.low), new Vector3(...box.high));
  }

  // Shows surfaces by their own colors (0), instances (1), normals (2), depth (3), or see-through but the selection (4).
  setMode(mode) {
    this.uniforms.mode.value = mode;
  }

  // Cuts off what lies beyond `offset` (of the stage, from -1 to 1) along an axis; null cuts nothing.
  cut(axis, offset) {
    const { value } = this.uniforms.section;
    if (axis === null) value.set(0, 0, 0, NOTHING);
    else value.set(...[0, 1, 2].map((i) => (i === axis ? 1 : 0)), offset);
    this.shadowFor = null;
  }

  // The key light stands left of the camera and above, and turns with it, as the dome does, unless both are fixed.
  turnLight(azimuth) {
    const { studio, uniforms } = this;
    const around = (azimuth * Math.PI) / 180;
    uniforms.domeTurn.value = (around + studio.domeTurn) / (2 * Math.PI);
    const flat = Math.cos(studio.keyHeight);
    const towards = new Vector3(Math.sin(around + studio.keyTurn) * flat, Math.sin(studio.keyHeight), Math.cos(around + studio.keyTurn) * flat);
    aim(this.light, this.takeAxes("lightAxes", towards));
    const { ambient, key, ground, groundLight } = uniforms;
    groundLight.value.copy(key.value).multiplyScalar(towards.y).add(ambient.value);
    groundLight.value.multiply(new Vector3().addVectors(...ground.value).multiplyScalar(0.5));
  }

  // Sets a uniform to the axes right, up and towards a light; they, with forward in place of the last, are the answer.
  takeAxes(name, towards) {
    const right = new Vector3().crossVectors(Math.abs(towards.y) < 0.999 ? new Vector3(0, 1, 0) : new Vector3(1, 0, 0), towards).normalize();
    const up = new Vector3().crossVectors(towards, right);
    this.uniforms[name].value.setFromMatrix4(new Matrix4().makeBasis(right, up, towards));
    return [right, up, towards.clone().negate()];
  }

  // Draws at once; `refine` makes it better while nothing moves.
  draw(viewpoint, isMoving) {
    if (!this.instances) return;
    const distance = viewpoint.camera.position.length();
    this.uniforms.depths.value.set(Math.max(0, distance - 1), distance + 1);
    this.uniforms.hasSky.value = false;
    this.uniforms.isToned.value = true;
    this.uniforms.seed.value = 0;
    const isKept = isMoving && this.isSlow && this.shadowFor !== null; // the light follows when the camera rests
    const azimuth = this.studio.isFixed ? 0 : viewpoint.azimuth;
    if (this.shadowFor !== azimuth && !isKept) {
      this.turnLight(azimuth);
      if (this.shadowFor === null) this.lampsAreOld = this.lamps !== null;
      this.drawShadow();
      this.shadowFor = azimuth;
    }
    this.uniforms.hasGround.value = this.ground.visible = this.hasGround && this.studio.ground !== null && viewpoint.camera.position.y > this.ground.position.y;
    this.uniforms.pixel.value = 2 / (viewpoint.camera.projectionMatrix.elements[5] * this.film.height);
    this.expose(viewpoint.camera, this.film);
    this.drawSelection(viewpoint.camera);
    this.show(this.film.texture, viewpoint.camera, false);
    this.samples = 0;
  }

  // Resolves to whether the graphics processor has done all that it was told within `milliseconds`.
  async finished(milliseconds) {
    const gl = this.renderer.getContext();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const end = performance.now() + milliseconds;
    for (;;) {
      await new Promise((resolve) => setTimeout(resolve, 4));
      const status = gl.clientWaitSync(fence, 0, 0);
      const isDone = status === gl.ALREADY_SIGNALED || status === gl.CONDITION_SATISFIED;
      if (!isDone && performance.now() < end) continue;
      gl.deleteSync(fence);
      return isDone;
    }
  }

  // Adds a sample to a still picture: soft light from all around, smooth shadows and edges. Resolves to whether there
  // is more to add; it is given up where the machine is too slow for it.
  async refine(viewpoint) {
    if (!this.instances || this.splats || this.samples >= SAMPLES) return false; // Gaussians have their light in them
    if (this.samples === 0 && !(await this.finished(10 * SLOW))) {
      this.isSlow = true;
      return false;
    }
    this.addSample(viewpoint);
    this.isSlow = !(await this.finished(SLOW));
    return !this.isSlow && this.samples < SAMPLES;
  }

  addSample(viewpoint) {
    const { camera } = viewpoint;
    const { width, height } = this.film;
    const number = this.samples;
    this.uniforms.seed.value = number;
    this.uniforms.isToned.value = false;
    if (this.instances.buckets.some((bucket) => bucket.isClear)) {
      this.lampsAreOld = this.lamps !== null;
      this.drawShadow();
    }
    this.drawSky(number);
    camera.setViewOffset(width, height, ((number * 0.7548777) % 1) - 0.5, ((number * 0.5698403) % 1) - 0.5, width, height);
    this.expose(camera, this.plain);
    camera.clearViewOffset();
    this.adder.material.uniforms.share.value = 1 / (number + 1);
    this.renderer.setRenderTarget(this.sum);
    this.renderer.render(this.adder, camera);
    this.samples += 1;
    // fewer samples would look at one side of the sky only
    if (this.samples === SAMPLES) this.show(this.sum.texture, camera, true);
  }

  // Takes the scene onto a film.
  expose(camera, target) {
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.instances.group.visible = !this.splats;
    this.renderer.render(this.scene, camera);
    this.instances.group.visible = true;
  }

  // Draws where the selected instances are, around which `show` puts a line; Gaussians are marked by their box alone.
  drawSelection(camera) {
    const { x, y } = this.uniforms.selected.value;
    const hasSelection = y > x && !this.splats;
    this.screen.material.uniforms.hasSelection.value = hasSelection;
    if (!hasSelection) return;
    this.renderer.setRenderTarget(this.selection);
    this.renderer.setClearColor(0, 0);
    this.renderer.clear();
    this.drawWith(this.selectedMaterial, camera);
    this.renderer.setRenderTarget(null);
    this.restoreClearColor();
  }

  restoreClearColor() {
    this.renderer.setClearColor(new Color().setRGB(...this.uniforms.backdrop.value.toArray()), 1);
  }

  show(texture, camera, isRaw) {
    this.screen.material.uniforms.isRaw.value = isRaw;
    this.screen.material.uniforms.picture.value = texture;
    this.renderer.setRenderTarget(null);
    this.renderer.render(this.screen, camera);
  }

  drawShadow() {
    if (this.studio.key.some((channel) => channel > 0)) this.drawDepth(this.shadow, this.light);
    if (!this.lampsAreOld) return;
    this.lamps.cast(this.renderer, this.lampMaps, (camera) => this.drawWith(this.depthMaterial, camera));
    this.renderer.setRenderTarget(null);
    this.lampsAreOld = false;
  }

  drawSky(number) {
    aim(this.skyLight, this.takeAxes("skyAxes", this.uniforms.skyDirections.value[number]));
    this.uniforms.hasSky.value = true;
    this.drawDepth(this.sky, this.skyLight);
  }

  drawDepth(target, light) {
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.drawWith(this.depthMaterial, light);
    this.renderer.setRenderTarget(null);
  }

  drawWith(material, camera) {
    const group = this.instances.group;
    this.scene.overrideMaterial = material;
    const others = [this.backdrop, this.ground, this.outline, ...(this.lamps ? [this.lamps.group] : []), ...(this.splats ? [this.splats.mesh] : [])].map((object) => [object, object.visible]);
    for (const [object] of others) object.visible = false;
    if (group.children.length) this.renderer.render(this.scene, camera);
    for (const [object, visible] of others) object.visible = visible;
    this.scene.overrideMaterial = null;
  }

  // The number of the instance at a point of the canvas (CSS pixels), or null.
  pick(viewpoint, x, y) {
    const [red, green, blue] = this.probe(viewpoint.camera, this.pickMaterial, x, y);
    const id = red + 256 * green + 65536 * blue;
    return id ? id - 1 : null;
  }

  // The point of the surface, in the stage's frame, that is seen at a point of the canvas, or null.
  pointAt({ camera }, x, y) {
    const [red, green, blue, hit] = this.probe(camera, this.placeMaterial, x - 0.5, y - 0.5);
    if (!hit) return null;
    const depth = (65536 * red + 256 * green + blue) / 16777215;
    const { clientWidth, clientHeight } = this.canvas;
    return new Vector3((2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight, 2 * depth - 1).unproject(camera).toArray();
  }

  // The four bytes that a material draws at a point of the canvas; zeros where nothing is.
  probe(camera, material, x, y) {
    const { renderer } = this;
    camera.setViewOffset(this.canvas.clientWidth, this.canvas.clientHeight, x, y, 1, 1);
    renderer.setRenderTarget(this.pickTarget);
    renderer.setClearColor(0, 0);
    renderer.clear();
    this.drawWith(material, camera);
    const pixel = new Uint8Array(4);
    renderer.readRenderTargetPixels(this.pickTarget, 0, 0, 1, 1, pixel);
    renderer.setRenderTarget(null);
    this.restoreClearColor();
    camera.clearViewOffset();
    camera.updateProjectionMatrix();
    return pixel;
  }
}

function without(object, name) {
  const { [name]: _, ...rest } = object;
  return rest;
}

function depthTarget(size) {
  const depthTexture = new DepthTexture(size, size, FloatType);
  depthTexture.minFilter = depthTexture.magFilter = NearestFilter;
  return new WebGLRenderTarget(size, size, { depthTexture });
}

function fullScreen(fragmentShader, uniforms, options) {
  const material = new ShaderMaterial({ vertexShader: shaders.FILM_VERTEX, fragmentShader, uniforms, depthTest: false, depthWrite: false, ...options });
  const mesh = new Mesh(new PlaneGeometry(2, 2), material);
  mesh.frustumCulled = false;
  return mesh;
}

// Directions spread evenly over the sky, as those of drafts, neighbors in number far apart.
function skyDirections() {
  return Array.from({ length: SAMPLES }, (_, i) => {
    const y = 1 - (((i * 11) % SAMPLES) + 0.5) / SAMPLES * 0.97;
    const turn = ((i * 11) % SAMPLES) * 2.399963229728653;
    const flat = Math.sqrt(1 - y * y);
    return new Vector3(flat * Math.cos(turn), y, flat * Math.sin(turn));
  });
}

function sharedUniforms(shadow, sky) {
  const vector = () => ({ value: new Vector3() });
  return {
    shadowMap: { value: shadow.depthTexture }, shadowTexel: { value: (2 * HALF) / shadow.width }, seed: { value: 0 }, hasSky: { value: false }, isToned: { value: true },
    skyMap: { value: sky.depthTexture }, skyTexel: { value: (2 * HALF) / sky.width }, skyAxes: { value: new Matrix3() }, skyDirections: { value: skyDirections() }, lightAxes: { value: new Matrix3() }, keySpread: { value: 0 },
    backdrop: vector(), ambient: vector(), key: vector(), ground: { value: [new Vector3(), new Vector3()] }, groundLight: vector(), checker: { value: 1 }, fade: vector(), showsDome: { value: false }, isUnlit: { value: false }, exposure: { value: 1 },
    lamps: { value: null }, lampMaps: { value: null }, lampCount: { value: 0 }, lampTiles: { value: 1 }, shoulder: { value: 1 },
    dome: { value: null }, domeTables: { value: null }, domeTurn: { value: 0 }, hasGround: { value: true }, facetAlbedo: { value: [] }, facetGrazing: { value: [] },
    placements: { value: null }, tiles: { value: null }, pixel: { value: 0 },
    mode: { value: 0 }, section: { value: new Vector4(0, 0, 0, NOTHING) }, depths: { value: new Vector2(1, 2) },
    groundHeight: { value: -1 }, looks: { value: null }, looksWidth: { value: 1 }, selected: { value: new Vector2() },
  };
}
