// The two programs: what lies behind and below, and the blocks.
export const BLOCKS = {
  vertex: `#version 300 es
    in vec3 position; in vec2 place; in vec4 color;
    uniform mat4 matrix;
    centroid out vec2 vPlace; out vec3 vColor; // never a place outside of the face
    void main() { gl_Position = matrix * vec4(position, 1.0); vPlace = place; vColor = color.rgb; }`,
  fragment: `#version 300 es
    precision highp float;
    centroid in vec2 vPlace; in vec3 vColor;
    uniform sampler2D atlas; uniform vec3 light; uniform float least;
    out vec4 result;
    void main() {
      vec4 texel = texture(atlas, vPlace);
      if (texel.a < least) discard;
      result = vec4(min(texel.rgb * vColor * light, 1.0), texel.a);
    }`,
};

// A ray for every pixel, in the frame where the scene has unit size.
export const BEHIND = {
  vertex: `#version 300 es
    const vec2 corners[3] = vec2[3](vec2(-1.0, -1.0), vec2(3.0, -1.0), vec2(-1.0, 3.0));
    void main() { gl_Position = vec4(corners[gl_VertexID], 0.0, 1.0); }`,
  fragment: `#version 300 es
    precision highp float;
    uniform vec2 size; uniform vec4 lens; uniform bool isParallel; uniform float unit;
    uniform vec3 eye; uniform vec3 right; uniform vec3 down; uniform vec3 forward;
    uniform vec3 backdrop; uniform bool hasGround; uniform float height; uniform vec3 ground; uniform vec3 other; uniform float checker;
    uniform sampler2D shadow; uniform vec3 shadowPlace;
    out vec4 result;
    void main() {
      vec2 pixel = vec2(gl_FragCoord.x, size.y - gl_FragCoord.y);
      vec2 q = (pixel - lens.zw) / lens.xy;
      vec3 start = isParallel ? eye + unit * (q.x * right + q.y * down) : eye;
      vec3 ray = isParallel ? forward : q.x * right + q.y * down + forward;
      float t = (height - start.y) / ray.y;
      result = vec4(backdrop, 1.0);
      if (!hasGround || t <= 0.0 || abs(ray.y) < 1e-9) return;
      vec2 hit = start.xz + t * ray.xz;
      vec2 at = (hit - shadowPlace.xy) / shadowPlace.z;
      bool isInside = all(greaterThan(at, vec2(0.0))) && all(lessThan(at, vec2(1.0)));
      float dark = isInside ? texture(shadow, at).r : 0.0;
      vec2 square = floor(hit / checker);
      vec3 color = mod(square.x + square.y, 2.0) == 0.0 ? ground : other;
      result = vec4(color * pow(1.0 - dark, 1.0 / 2.2), 1.0);
    }`,
};

export class Program {
  constructor(gl, { vertex, fragment }) {
    this.gl = gl;
    this.program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) throw new Error(`WebGL: ${gl.getProgramInfoLog(this.program)}`);
  }

  at(name) {
    return this.gl.getUniformLocation(this.program, name);
  }

  attribute(name) {
    return this.gl.getAttribLocation(this.program, name);
  }
}
