// The picture: the studio's light, the ground, the key light's shadow map, the film, and picking by numbers.
import { Box3, Box3Helper, CircleGeometry, Color, DepthTexture, DoubleSide, FloatType, HalfFloatType, Matrix3, Matrix4, Mesh, NearestFilter, NoBlending, OrthographicCamera, PlaneGeometry, Scene, ShaderMaterial, Vector2, Vector3, WebGLRenderer, WebGLRenderTarget } from "three";
import * as shaders from "./shaders.js";

const HALF = 1.02; // half the width of the shadow map: the scene lies in the unit ball
const DISTANCE = 3;
const BELOW = 1e-4; // the ground lies this far under the lowest point, so that flat floors hide it
const ACCENT = new Vector3(0.03, 0.24, 0.85);
const DEFINES = { SHADOW_HALF: HALF.toFixed(4), SHADOW_DISTANCE: "3.0", SHADOW_NEAR: "1.5", SHADOW_FAR: "4.5" };
const MOST_SHADOWED = 1_500_000;

export class Stage {
  constructor(canvas) {
    this.renderer = new WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true });
    this.renderer.autoClear = false;
    this.canvas = canvas;
    this.scene = new Scene();
    this.instances = null;
    this.hasGround = true;
    this.shadowFor = null;
    const size = Math.min(2048, this.renderer.capabilities.maxTextureSize);
    this.shadow = new WebGLRenderTarget(size, size, { depthTexture: new DepthTexture(size, size, FloatType) });
    this.shadow.depthTexture.minFilter = this.shadow.depthTexture.magFilter = NearestFilter;
    this.light = new OrthographicCamera(-HALF, HALF, HALF, -HALF, 1.5, 4.5);
    this.film = new WebGLRenderTarget(1, 1, { type: HalfFloatType, samples: 4 });
    this.pickTarget = new WebGLRenderTarget(1, 1);
    this.uniforms = sharedUniforms(this.shadow.depthTexture, (2 * HALF) / size);
    this.ground = this.makeGround();
    this.outline = new Box3Helper(new Box3(), new Color(ACCENT.x, ACCENT.y, ACCENT.z));
    this.outline.visible = false;
    this.scene.add(this.ground, this.outline);
    this.depthMaterial = this.material(shaders.SOLID_VERTEX, shaders.DEPTH_FRAGMENT, { side: DoubleSide });
    this.pickMaterial = this.material(shaders.SOLID_VERTEX, shaders.PICK_FRAGMENT, { side: DoubleSide, blending: NoBlending });
    this.screen = new Mesh(new PlaneGeometry(2, 2), new ShaderMaterial({
      vertexShader: shaders.FILM_VERTEX, fragmentShader: shaders.FILM_FRAGMENT,
      uniforms: { picture: { value: this.film.texture } }, depthTest: false, depthWrite: false,
    }));
    this.screen.frustumCulled = false;
  }

  material(vertexShader, fragmentShader, options) {
    return new ShaderMaterial({ vertexShader, fragmentShader, uniforms: this.uniforms, defines: { ...DEFINES, ...options.defines }, ...without(options, "defines") });
  }

  // The material of solids; mirrored instances are wound the other way round, so both sides are drawn.
  solidMaterial(isClear, { colors, closed }) {
    return this.material(shaders.SOLID_VERTEX, shaders.SOLID_FRAGMENT, {
      side: DoubleSide, transparent: isClear, depthWrite: !isClear, defines: { ...(colors && { HAS_COLORS: "1" }), ...(isClear && closed && { CLOSED: "1" }) },
    });
  }

  makeGround() {
    const mesh = new Mesh(new CircleGeometry(150, 96).rotateX(-Math.PI / 2), this.material(shaders.GROUND_VERTEX, shaders.GROUND_FRAGMENT, {}));
    mesh.frustumCulled = false;
    mesh.renderOrder = -1;
    return mesh;
  }

  // Takes over the instances of a packet; `groundHeight` in the stage's frame.
  take(instances, packet) {
    if (this.instances) {
      this.scene.remove(this.instances.group);
      this.instances.dispose();
    }
    this.instances = instances;
    this.scene.add(instances.group);
    const { studio, box } = packet;
    const value = (name, next) => { this.uniforms[name].value = next; };
    for (const name of ["backdrop", "ambient", "key"]) value(name, new Vector3(...studio[name]));
    value("brightest", studio.brightest);
    value("shoulder", studio.shoulder);
    value("keySpread", Math.tan(studio.keyRadius));
    this.studio = studio;
    this.renderer.setClearColor(new Color().setRGB(...studio.backdrop), 1);
    const height = box ? (box.low[1] - box.center[1]) * box.scale - BELOW : -1;
    value("groundHeight", height);
    this.ground.position.y = height;
    if (instances.ready) {
      value("looks", instances.looks);
      value("looksWidth", instances.looks.image.width);
    }
    this.shadowFor = null;
  }

  // What is drawn has changed, so the shadow map is old.
  changed() {
    this.shadowFor = null;
  }

  resize(width, height, ratio) {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.film.setSize(Math.round(width * ratio), Math.round(height * ratio));
  }

  select(range, box) {
    this.uniforms.selected.value.set(range ? range[0] : 0, range ? range[1] : 0);
    this.outline.visible = Boolean(box);
    if (box) this.outline.box.set(new Vector3(...box.low), new Vector3(...box.high));
  }

  // The key light stands left of the camera and above, and turns with it.
  turnLight(azimuth) {
    const turn = (azimuth * Math.PI) / 180 + this.studio.keyTurn;
    const flat = Math.cos(this.studio.keyHeight);
    const towards = new Vector3(Math.sin(turn) * flat, Math.sin(this.studio.keyHeight), Math.cos(turn) * flat);
    const right = new Vector3().crossVectors(new Vector3(0, 1, 0), towards).normalize();
    const up = new Vector3().crossVectors(towards, right);
    const axes = new Matrix4().makeBasis(right, up, towards);
    this.uniforms.lightAxes.value.setFromMatrix4(axes);
    const { ambient, key, backdrop, ground } = this.uniforms;
    for (const c of ["x", "y", "z"]) ground.value[c] = backdrop.value[c] / (ambient.value[c] + key.value[c] * towards.y);
    this.light.position.copy(towards).multiplyScalar(DISTANCE);
    this.light.quaternion.setFromRotationMatrix(axes);
    this.light.updateMatrixWorld(true);
  }

  draw(viewpoint) {
    const { renderer, scene } = this;
    if (!this.instances) return;
    if (this.shadowFor !== viewpoint.azimuth) {
      this.turnLight(viewpoint.azimuth);
      this.drawShadow();
      this.shadowFor = viewpoint.azimuth;
    }
    this.ground.visible = this.hasGround && viewpoint.camera.position.y > this.ground.position.y;
    renderer.setRenderTarget(this.film);
    renderer.clear();
    renderer.render(scene, viewpoint.camera);
    renderer.setRenderTarget(null);
    renderer.render(this.screen, viewpoint.camera);
  }

  drawShadow() {
    const { renderer } = this;
    renderer.setRenderTarget(this.shadow);
    renderer.clear();
    if (this.instances.shown <= MOST_SHADOWED) this.drawWith(this.depthMaterial, this.light);
    renderer.setRenderTarget(null);
  }

  drawWith(material, camera) {
    const group = this.instances.group;
    this.scene.overrideMaterial = material;
    const others = [this.ground, this.outline].map((object) => [object, object.visible]);
    for (const [object] of others) object.visible = false;
    if (group.children.length) this.renderer.render(this.scene, camera);
    for (const [object, visible] of others) object.visible = visible;
    this.scene.overrideMaterial = null;
  }

  // The number of the instance at a point of the canvas (CSS pixels), or null.
  pick(viewpoint, x, y) {
    const { renderer } = this;
    const { camera } = viewpoint;
    camera.setViewOffset(this.canvas.clientWidth, this.canvas.clientHeight, x, y, 1, 1);
    renderer.setRenderTarget(this.pickTarget);
    renderer.setClearColor(0, 0);
    renderer.clear();
    this.drawWith(this.pickMaterial, camera);
    const pixel = new Uint8Array(4);
    renderer.readRenderTargetPixels(this.pickTarget, 0, 0, 1, 1, pixel);
    renderer.setRenderTarget(null);
    renderer.setClearColor(new Color().setRGB(...this.studio.backdrop), 1);
    camera.clearViewOffset();
    camera.updateProjectionMatrix();
    const id = pixel[0] + 256 * pixel[1] + 65536 * pixel[2];
    return id ? id - 1 : null;
  }
}

function without(object, name) {
  const { [name]: _, ...rest } = object;
  return rest;
}

function sharedUniforms(depth, texel) {
  const vector = () => ({ value: new Vector3() });
  return {
    shadowMap: { value: depth }, shadowTexel: { value: texel }, lightAxes: { value: new Matrix3() }, keySpread: { value: 0 },
    backdrop: vector(), ambient: vector(), key: vector(), ground: vector(), brightest: { value: 1 }, shoulder: { value: 1 },
    groundHeight: { value: -1 }, looks: { value: null }, looksWidth: { value: 1 }, selected: { value: new Vector2() }, accent: { value: ACCENT },
  };
}
