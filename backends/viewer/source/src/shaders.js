// The light and the film of backends/pictures/draft_light.py and draft.py as shaders, so that the page agrees with draft pictures.

// Where a texture lies (backends/viewer/texture_columns.py), six texels a primitive.
const PLACEMENT = /* glsl */ `
  #ifdef TEXTURED
    uniform sampler2D placements;
    vec4 placement(float primitive, int part) {
      int at = int(primitive + 0.5) * 6 + part;
      int width = textureSize(placements, 0).x;
      return texelFetch(placements, ivec2(at % width, at / width), 0);
    }
  #endif
`;

// What the vertex shader of instances passes on: place, normal, tint and number, and whether the pose mirrors.
const VARYINGS = /* glsl */ `
  varying vec3 vPoint;
  varying vec3 vNormal;
  varying vec3 vTint;
  flat varying vec2 vInstance;
  flat varying float vMirrored;
`;

// An instance: its pose, its primitive's row of looks, its number in the frame.
const INSTANCE = /* glsl */ `
  ${PLACEMENT}
  attribute vec2 instance; // primitive, number
  ${VARYINGS}
  #ifdef HAS_COLORS
    attribute vec3 tint;
  #endif
  #ifdef HAS_CHART
    attribute vec2 chart; // texture coordinates of a mesh file
  #endif
  #ifdef TEXTURED
    varying vec3 vOwnPoint, vOwnNormal; // in the frame of the primitive, or a point in texture coordinates
    flat varying float vGrowth; // of lengths, from the stage to that frame
    void placeTexture(mat3 m) {
      vec4 x = placement(instance.x, 2), y = placement(instance.x, 3), z = placement(instance.x, 4);
      mat3 own = transpose(mat3(x.xyz, y.xyz, z.xyz));
      float volume = determinant(own);
      vOwnPoint = own * position + vec3(x.w, y.w, z.w);
      vOwnNormal = mat3(cross(own[1], own[2]), cross(own[2], own[0]), cross(own[0], own[1])) * normal * sign(volume);
      vGrowth = pow(abs(volume) / max(abs(determinant(m)), 1e-30), 1.0 / 3.0);
      #ifdef HAS_CHART
        vOwnPoint = vec3(chart, 0.0);
      #endif
    }
  #endif
  vec4 placed() {
    mat3 m = mat3(instanceMatrix);
    // cofactors turn normals right under shear and scale; a mirror turns them inwards, the fragment out again
    vNormal = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
    vInstance = instance;
    vMirrored = dot(m[0], cross(m[1], m[2])) < 0.0 ? 1.0 : 0.0;
    #ifdef HAS_COLORS
      vTint = tint;
    #else
      vTint = vec3(1.0);
    #endif
    #ifdef TEXTURED
      placeTexture(m);
    #endif
    vec4 point = instanceMatrix * vec4(position, 1.0);
    vPoint = point.xyz;
    return point;
  }
`;

export const SOLID_VERTEX = /* glsl */ `
  ${INSTANCE}
  void main() { gl_Position = projectionMatrix * viewMatrix * placed(); }
`;

export const GROUND_VERTEX = /* glsl */ `
  varying vec3 vPoint;
  void main() {
    vPoint = (modelMatrix * vec4(position, 1.0)).xyz;
    gl_Position = projectionMatrix * viewMatrix * vec4(vPoint, 1.0);
  }
`;

const LOOK = /* glsl */ `
  uniform sampler2D looks; // three texels a primitive: color and opacity; emission and ior; roughness, metallic, coat, sheen
  uniform float looksWidth;
  vec4 look(int part) {
    int at = int(vInstance.x + 0.5) * 3 + part;
    int width = int(looksWidth);
    return texelFetch(looks, ivec2(at % width, at / width), 0);
  }
`;

// The color of a texture at a point of a surface: surfaces/tiles.py, over the square that a pixel covers.
const TEXTURE = /* glsl */ `
  ${PLACEMENT}
  #ifdef TEXTURED
    varying vec3 vOwnPoint, vOwnNormal;
    flat varying float vGrowth;
    uniform sampler2DArray tiles;
    uniform float pixel; // side of what a pixel covers at distance 1, or everywhere in a parallel projection
    vec2 ontoBox(vec3 p, vec3 n) {
      vec3 along = abs(n);
      if (along.x >= along.y && along.x >= along.z) return vec2(n.x < 0.0 ? p.z : -p.z, p.y);
      if (along.y >= along.z) return vec2(p.x, n.y < 0.0 ? p.z : -p.z);
      return vec2(n.z < 0.0 ? -p.x : p.x, p.y);
    }
    // The plane coordinates of a point by a projection; \`around\` is the length of a radian.
    vec2 projected(int projection, vec3 p, vec3 n, float around) {
      if (projection == 0) return ontoBox(p, n);
      if (projection == 1 || projection == 4) return p.xy;
      float angle = atan(p.x, abs(p.z) < 1e-9 ? 1e-9 : p.z) * around;
      return vec2(angle, projection == 2 ? p.y : atan(p.y, max(length(p.xz), 1e-9)) * around);
    }
    // The direction that the side of a decal faces: front, back, right, left, top, bottom.
    vec3 facing(int side) {
      float end = side % 2 == 0 ? 1.0 : -1.0;
      return side < 2 ? vec3(0.0, 0.0, end) : side < 4 ? vec3(end, 0.0, 0.0) : vec3(0.0, end, 0.0);
    }
    // The place in the image that a point shows, in periods: a corner of its margin where it shows no decal.
    vec2 placeOf(vec3 p, vec3 n) {
      vec4 image = placement(vInstance.x, 0), turn = placement(vInstance.x, 1);
      int projection = int(image.y + 0.5);
      vec2 flat_ = projection < 5 ? projected(projection, p, n, turn.w) : ontoBox(p, facing(projection - 5)) - placement(vInstance.x, 5).zw;
      vec2 at = vec2(dot(flat_, turn.xy), dot(flat_, vec2(-turn.y, turn.x))) / image.zw + turn.z;
      if (projection < 5) return at;
      return dot(normalize(n), facing(projection - 5)) > 0.05 ? clamp(at, 0.002, 0.998) : vec2(0.002);
    }
    // The level of detail at which a pixel covers one texel.
    float levelHere() {
      vec4 image = placement(vInstance.x, 0);
      float away = isOrthographic ? 1.0 : -(viewMatrix * vec4(vPoint, 1.0)).z;
      float covered = away * pixel * vGrowth / sqrt(image.z * image.w) * float(textureSize(tiles, 0).x);
      return log2(max(covered, 1.0));
    }
    vec3 textured(vec3 color, float side) {
      float layer = placement(vInstance.x, 0).x;
      if (layer < 0.0) return color;
      vec2 at = placeOf(vOwnPoint, vOwnNormal * side);
      return textureLod(tiles, vec3(at.x, 1.0 - at.y, layer), levelHere()).rgb;
    }
    // The normal of a relief (draft_light.py, relieved), by Mikkelsen's way (2010): the height at the pixel and beside it.
    vec3 relieved(vec3 n, vec3 v, float side) {
      vec4 bump = placement(vInstance.x, 5);
      vec3 right = dFdx(vPoint), up = dFdy(vPoint), ownRight = dFdx(vOwnPoint), ownUp = dFdy(vOwnPoint);
      if (bump.x < 0.0) return n;
      float level = levelHere(), heights[3];
      for (int k = 0; k < 3; k++) {
        vec2 at = placeOf(vOwnPoint + (k == 1 ? ownRight : k == 2 ? ownUp : vec3(0.0)), vOwnNormal * side);
        heights[k] = textureLod(tiles, vec3(at.x, 1.0 - at.y, bump.x), level).r * bump.y / vGrowth;
      }
      vec3 first = cross(up, n), second = cross(n, right);
      float area = dot(right, first);
      vec3 slope = sign(area) * ((heights[1] - heights[0]) * first + (heights[2] - heights[0]) * second);
      vec3 raised = normalize(abs(area) * n - side * slope);
      return normalize(raised + max(0.6 * dot(n, v) - dot(raised, v), 0.0) * v);
    }
  #endif
`;

const NOISE = /* glsl */ `
  uniform float seed; // another one for each sample of a still picture
  float noise(vec2 pixel) { return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))) + seed * 0.61803399); }
`;

// Percentage-closer soft shadows: the penumbra widens with the blocker's distance, as a light far away casts it whose
// radius has the tangent `spread`. A map is a tile of a texture: its corner, and its share of the side.
const SHADOW = /* glsl */ `
  uniform sampler2D shadowMap;
  uniform mat3 lightAxes; // columns: right, up, towards the light
  uniform float keySpread; // tan(keyRadius)
  uniform float shadowTexel; // in stage units
  const vec3 WHOLE = vec3(0.0, 0.0, 1.0);
  ${NOISE}
  vec2 tap(int i, float count, float turn) {
    float angle = float(i) * 2.399963229728653 + turn;
    return vec2(cos(angle), sin(angle)) * sqrt((float(i) + 0.5) / count);
  }
  float mapped(sampler2D map, vec3 tile, vec2 at) {
    vec2 uv = at / (2.0 * SHADOW_HALF) + 0.5;
    if (uv.x <= 0.0 || uv.y <= 0.0 || uv.x >= 1.0 || uv.y >= 1.0) return 1e9;
    float depth = texture2D(map, tile.xy + uv * tile.z).r;
    return depth >= 1.0 ? 1e9 : SHADOW_NEAR + depth * (SHADOW_FAR - SHADOW_NEAR);
  }
  float farShare(sampler2D map, vec3 tile, mat3 axes, float spread, float texel, vec3 point, vec3 normal) {
    vec3 tilt = normal * axes;
    if (tilt.z <= 0.0) return 0.0;
    vec3 local = (point + normal * texel * (0.8 + 1.6 * sqrt(1.0 - tilt.z * tilt.z))) * axes;
    float depth = SHADOW_DISTANCE - local.z;
    vec2 slope = tilt.xy / max(tilt.z, 0.2);
    float turn = 6.2831853 * noise(gl_FragCoord.xy);
    float widest = 0.22 * SHADOW_HALF;
    float reach = clamp((depth - SHADOW_DISTANCE + 1.0) * spread, 2.0 * texel, widest);
    float blockers = 0.0;
    float distance = 0.0;
    for (int i = 0; i < 16; i++) {
      vec2 d = tap(i, 16.0, turn) * reach;
      float above = depth + dot(d, slope) - mapped(map, tile, local.xy + d);
      if (above > 0.5 * texel) { blockers += 1.0; distance += above; }
    }
    if (blockers == 0.0) return 1.0;
    float radius = clamp(distance / blockers * spread, 0.9 * texel, widest);
    float lit = 0.0;
    for (int i = 0; i < 24; i++) {
      vec2 d = tap(i, 24.0, turn + 2.0) * radius;
      lit += depth + dot(d, slope) - mapped(map, tile, local.xy + d) > 0.5 * texel ? 0.0 : 1.0;
    }
    return lit / 24.0;
  }
  float keyShare(vec3 point, vec3 normal) {
    return farShare(shadowMap, WHOLE, lightAxes, keySpread, shadowTexel, point, normal);
  }
`;

// The share of the surrounding light that nothing hides, by one direction of the sky a sample: the mean over all
// samples is that of drafts, a single one may be below zero.
const SKY = /* glsl */ `
  uniform sampler2D skyMap;
  uniform mat3 skyAxes;
  uniform vec3 skyDirections[SKY_SAMPLES];
  uniform float skyTexel;
  uniform bool hasSky;
  float skyShare(vec3 point, vec3 normal) {
    if (!hasSky) return 1.0;
    vec3 tilt = normal * skyAxes;
    if (tilt.z <= 0.0) return 1.0;
    float total = 0.1;
    for (int i = 0; i < SKY_SAMPLES; i++) total += max(dot(normal, skyDirections[i]), 0.0);
    vec3 local = (point + normal * skyTexel * (0.6 + 1.2 * sqrt(1.0 - tilt.z * tilt.z))) * skyAxes;
    vec2 slope = tilt.xy / max(tilt.z, 0.2);
    float turn = 6.2831853 * noise(gl_FragCoord.xy);
    float hidden = 0.0;
    for (int i = 0; i < 4; i++) {
      vec2 d = tap(i, 4.0, turn) * 3.0 * skyTexel;
      hidden += SHADOW_DISTANCE - local.z + dot(d, slope) - mapped(skyMap, WHOLE, local.xy + d) > skyTexel ? 0.25 : 0.0;
    }
    return 1.0 - float(SKY_SAMPLES) * tilt.z / total * hidden;
  }
`;

const TONE = /* glsl */ `
  uniform float shoulder, exposure;
  vec3 tone(vec3 c) {
    c *= exposure;
    vec3 over = max(c - shoulder, 0.0);
    return mix(max(c, 0.0), 1.0 - (1.0 - shoulder) * exp(-over / (1.0 - shoulder)), step(shoulder, c));
  }
`;

const LIGHT = /* glsl */ `
  uniform vec3 ambient, key, groundLight; // the last: radiance of the ground without shadows
  uniform sampler2D dome; // radiance by longitude and latitude
  uniform sampler2DArray domeTables; // the same blurred in four steps, light from above, light from all around
  uniform float domeTurn; // share of a turn
  uniform bool hasGround;
  vec2 onDome(vec3 d) {
    return vec2(atan(d.x, abs(d.z) < 1e-9 ? 1e-9 : d.z) / 6.2831853 + 0.5 - domeTurn, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265);
  }
  uniform float groundHeight;
  ${TONE}
  uniform bool isToned; // else samples are added up first
  vec3 exposed(vec3 c) { return isToned ? tone(c) : c; }
  // The surrounding light: from below comes the ground's, but near it lies the solid's own shadow.
  vec3 around(vec3 point, vec3 normal) {
    vec3 sky = textureLod(domeTables, vec3(onDome(normal), hasGround ? 4.0 : 5.0), 0.0).rgb;
    if (!hasGround) return sky;
    float height = clamp(point.y - groundHeight, 0.0, 10.0);
    float turnedAway = 0.5 - 0.5 * dot(normal, lightAxes[2]);
    float shaded = 0.7 * turnedAway * exp(-height / 0.35);
    return sky + (0.5 - 0.5 * normal.y) * groundLight * (1.0 - shaded);
  }
  // What hides the surrounding light is itself lit, and taken to have the color albedo.
  vec3 surrounding(vec3 light, vec3 albedo, float share) {
    vec3 bounced = albedo * (0.5 * ambient + 0.28 * key) * 0.65;
    return bounced + (light - bounced) * share;
  }
`;

// Highlights of the key light (GGX, Schlick) and reflections of the dome above and the ground below, with the energy of
// surfaces/microfacets.py.
const GLOSS = /* glsl */ `
  const float SHEEN_STRENGTH = 100.0, SHEEN_ALBEDO = 0.12;
  uniform float facetAlbedo[11], facetGrazing[11]; // by roughness
  float tabled(float table[11], float rough) {
    float at = clamp(rough, 0.0, 1.0) * 10.0;
    int below = min(int(at), 9);
    return mix(table[below], table[below + 1], at - float(below));
  }
  float atNormal(float ior) {
    float base = (ior - 1.0) / (ior + 1.0);
    return base * base;
  }
  float dielectricAlbedo(float base, float rough) {
    float grazing = tabled(facetGrazing, rough);
    return (tabled(facetAlbedo, rough) - grazing) * base + (base > 0.0 ? grazing : 0.0);
  }
  vec3 schlick(vec3 reflectance, float cosine, float rough) {
    vec3 limit = max(vec3(1.0 - rough), reflectance) * step(1e-6, reflectance);
    return reflectance + (limit - reflectance) * pow(1.0 - cosine, 5.0);
  }
  vec3 room(vec3 v, vec3 n, float toward, float rough) {
    vec3 d = 2.0 * toward * n - v;
    vec2 at = onDome(d);
    float level = clamp(rough * 4.0, 0.0, 4.0);
    float below = min(floor(level), 3.0);
    vec3 sharp = below < 0.5 ? textureLod(dome, at, 0.0).rgb : textureLod(domeTables, vec3(at, below - 1.0), 0.0).rgb;
    vec3 sky = mix(sharp, textureLod(domeTables, vec3(at, below), 0.0).rgb, level - below);
    return hasGround ? mix(groundLight, sky, clamp(0.5 + 0.5 * d.y / rough, 0.0, 1.0)) : sky;
  }
  vec3 facets(vec3 n, vec3 v, vec3 l, vec3 reflectance, float toward, float rough) {
    vec3 h = normalize(l + v);
    float alpha2 = rough * rough * rough * rough;
    float facing = clamp(dot(n, l), 0.0, 1.0);
    float straight = clamp(dot(n, h), 0.0, 1.0);
    float d = straight * straight * (alpha2 - 1.0) + 1.0;
    float spread = alpha2 / (3.14159265 * d * d);
    float masked = 0.5 / max(facing * sqrt(toward * toward * (1.0 - alpha2) + alpha2) + toward * sqrt(facing * facing * (1.0 - alpha2) + alpha2), 1e-4);
    return schlick(reflectance, clamp(dot(h, l), 0.0, 1.0), rough) * spread * masked;
  }
  vec3 highlight(vec3 n, vec3 v, vec3 l, vec3 reflectance, float toward, float rough) {
    return facets(n, v, l, reflectance, toward, rough) * clamp(dot(n, l), 0.0, 1.0) * 3.14159265 * key;
  }
`;

// Radiance of a glossy surface whose matte part would have `color`; `reach` is how much of the surroundings and of the
// key light reaches it.
const SURFACE = /* glsl */ `
  vec3 reflected(vec3 reflectance, float rough, vec3 n, vec3 v, vec2 reach) {
    float toward = clamp(dot(n, v), 1e-3, 1.0);
    vec3 mirrored = schlick(reflectance, toward, rough) * tabled(facetAlbedo, rough) * room(v, n, toward, rough);
    return mirrored * reach.x + highlight(n, v, lightAxes[2], reflectance, toward, rough) * reach.y;
  }
  vec3 glossy(vec3 color, vec3 albedo, vec3 n, vec3 v, vec2 reach, float ior, vec4 finish) {
    float rough = max(finish.x, 0.06), metallic = finish.y, coat = finish.z, sheen = finish.w;
    float base = atNormal(ior), missed = 1.0 - tabled(facetAlbedo, rough);
    vec3 later = metallic * albedo * missed / (1.0 - albedo * missed); // bounces between the facets of metals
    vec3 found = color * (1.0 - metallic) * (1.0 - dielectricAlbedo(base, rough));
    found += reflected(mix(vec3(base), albedo, metallic), rough, n, v, reach) * (1.0 + later);
    if (sheen > 0.0) {
      float rim = 0.75 * pow(1.0 - clamp(dot(n, v), 1e-3, 1.0), 2.16);
      found += sheen * (rim * around(vPoint, n) * reach.x - SHEEN_ALBEDO * found);
    }
    if (coat > 0.0) {
      float varnish = atNormal(1.5);
      found = found * (1.0 - coat * dielectricAlbedo(varnish, 0.06)) + coat * reflected(vec3(varnish), 0.06, n, v, reach);
    }
    return found;
  }
`;

// The lights of the program (backends/pictures/draft_lamps.py), of eight texels each (lamps.js); their shadow maps are
// tiles of one texture.
const LAMPS = /* glsl */ `
  #ifdef LAMPS
    uniform sampler2D lamps, lampMaps;
    uniform int lampCount;
    uniform float lampTiles; // on a side of the texture
    vec4 lamp(int number, int part) { return texelFetch(lamps, ivec2(part, number), 0); }
    vec3 tileOf(float number) { return vec3(mod(number, lampTiles), floor(number / lampTiles), 1.0) / lampTiles; }
    // A vector in the axes of a face of the cube around a lamp: ahead, to the sides, and behind.
    vec3 onFace(int face, vec3 p) {
      if (face == 0) return p;
      if (face == 1) return vec3(-p.z, p.y, p.x);
      if (face == 2) return vec3(p.z, p.y, -p.x);
      if (face == 3) return vec3(p.x, -p.z, p.y);
      return face == 4 ? vec3(p.x, p.z, -p.y) : vec3(-p.x, p.y, -p.z);
    }
    int faceOf(vec3 p) {
      vec3 along = abs(p);
      if (along.z >= along.x && along.z >= along.y) return p.z > 0.0 ? 0 : 5;
      if (along.x >= along.y) return p.x > 0.0 ? 1 : 2;
      return p.y > 0.0 ? 3 : 4;
    }
    // The share of a lamp of the radius \`extent\` that is visible from a point at p with the normal n, in its axes.
    float nearShare(int number, vec3 p, vec3 n, float extent) {
      vec4 maps = lamp(number, 6), planes = lamp(number, 7); // first tile, faces, half width of a face at distance 1
      int face = maps.y < 1.5 ? 0 : faceOf(p);
      p = onFace(face, p);
      n = onFace(face, n);
      vec3 tile = tileOf(maps.x + float(face));
      float size = float(textureSize(lampMaps, 0).x) * tile.z;
      float perTexel = 2.0 * maps.z / size;
      p += n * 0.7 * max(p.z, 1e-9) * perTexel;
      float z = max(p.z, 1e-9), plane = dot(n, p), turn = 6.2831853 * noise(gl_FragCoord.xy);
      float radius = clamp(extent / z, perTexel, 0.12 * size * perTexel);
      float blockers = 0.0, above = 0.0, lit = 0.0;
      for (int i = 0; i < 40; i++) {
        if (i == 16) {
          if (blockers == 0.0) return 1.0;
          float blocker = max(z - above / blockers, 1e-9);
          radius = clamp(extent * max(z - blocker, 0.0) / blocker / z, perTexel, 0.12 * size * perTexel);
        }
        vec2 at = p.xy / z + (i < 16 ? tap(i, 16.0, turn) : tap(i - 16, 24.0, turn + 2.0)) * radius;
        float slope = dot(n, vec3(at, 1.0));
        float reach = clamp(slope < -1e-6 ? plane / slope : 2.0 * z, 0.25 * z, 2.0 * z) * 0.999;
        vec2 uv = clamp(0.5 + 0.5 * at / maps.z, 0.5 / size, 1.0 - 0.5 / size);
        float depth = texture2D(lampMaps, tile.xy + uv * tile.z).r;
        float blocked = reach - (depth >= 1.0 ? 1e9 : planes.x * planes.y / (planes.y - depth * (planes.y - planes.x)));
        if (i >= 16) lit += blocked > 0.0 ? 0.0 : 1.0;
        else if (blocked > 0.0) { blockers += 1.0; above += blocked; }
      }
      return lit / 24.0;
    }
    // The irradiance at a point, without shadows; \`toward\` becomes the direction to the lamp.
    vec3 irradiance(int number, vec3 point, vec3 n, out vec3 toward) {
      vec4 place = lamp(number, 0), right = lamp(number, 1), up = lamp(number, 2), ahead = lamp(number, 3), flux = lamp(number, 4), size = lamp(number, 5);
      if (place.w < 0.5) { // a sun
        toward = -ahead.xyz;
        return flux.rgb * max(dot(n, toward), 0.0);
      }
      vec3 offset = place.xyz - point;
      float distance = max(length(offset), 1e-6);
      toward = offset / distance;
      if (place.w > 2.5) { // an area
        float total = 0.0;
        for (int k = 0; k < 16; k++) {
          vec2 at = (vec2(k % 4, k / 4) + 0.5) / 4.0 - 0.5;
          vec3 d = place.xyz + at.x * size.x * right.xyz + at.y * size.y * up.xyz - point;
          float away = max(length(d), 1e-6);
          total += max(dot(n, d), 0.0) * max(-dot(d, ahead.xyz), 0.0) / pow(away, 4.0);
        }
        return flux.rgb * total / (16.0 * 3.14159265);
      }
      vec3 found = flux.rgb * max(dot(n, toward), 0.0) / (4.0 * 3.14159265 * distance * distance);
      if (place.w < 1.5) return found;
      float angle = acos(clamp(-dot(toward, ahead.xyz), -1.0, 1.0));
      return found * clamp((right.w - angle) / (right.w * up.w), 0.0, 1.0);
    }
    vec3 laterBounces(vec3 albedo, vec4 finish) { // between the facets of metals
      float missed = 1.0 - tabled(facetAlbedo, max(finish.x, 0.06));
      return finish.y * albedo * missed / (1.0 - albedo * missed);
    }
    // The radiance that a surface reflects of all lamps.
    vec3 lampLight(vec3 point, vec3 n, vec3 v, vec3 albedo, float ior, vec4 finish) {
      vec3 total = vec3(0.0);
      float cosine = clamp(dot(n, v), 1e-3, 1.0);
      for (int i = 0; i < lampCount; i++) {
        vec3 toward, light = irradiance(i, point, n, toward);
        if (max(light.r, max(light.g, light.b)) <= 0.0) continue;
        vec4 place = lamp(i, 0), ahead = lamp(i, 3);
        mat3 axes = mat3(lamp(i, 1).xyz, lamp(i, 2).xyz, ahead.xyz);
        if (place.w < 0.5) {
          axes[2] = -axes[2];
          vec3 tile = tileOf(lamp(i, 6).x);
          light *= farShare(lampMaps, tile, axes, ahead.w, 2.0 * SHADOW_HALF / (float(textureSize(lampMaps, 0).x) * tile.z), point, n);
        } else light *= nearShare(i, (point - place.xyz) * axes, n * axes, ahead.w);
        vec3 found = albedo * light / 3.14159265;
        if (finish.x >= 0.0) {
          float base = atNormal(ior), rough = max(finish.x, 0.06), coat = finish.z, sheen = finish.w;
          vec3 shine = facets(n, v, toward, mix(vec3(base), albedo, finish.y), cosine, rough);
          found *= (1.0 - finish.y) * (1.0 - dielectricAlbedo(base, rough));
          found += shine * light * (1.0 + laterBounces(albedo, finish));
          float rim = SHEEN_STRENGTH * pow(1.0 - sqrt(0.5 + 0.5 * clamp(dot(toward, v), -1.0, 1.0)), 5.0);
          found += sheen * SHEEN_ALBEDO * (rim * light - found);
          float varnish = atNormal(1.5);
          found *= 1.0 - coat * dielectricAlbedo(varnish, 0.06);
          found += coat * facets(n, v, toward, vec3(varnish), cosine, 0.06) * light;
        }
        total += found;
      }
      return total;
    }
    // The radiance of the lamps on a ground of the given color that a glossy surface mirrors (draft_light.py).
    vec3 mirroredLamps(vec3 point, vec3 n, vec3 v, vec3 albedo, vec3 ground, float ior, vec4 finish) {
      float rough = max(finish.x, 0.06), toward = clamp(dot(n, v), 1e-3, 1.0);
      vec3 d = 2.0 * toward * n - v, up = vec3(0.0, 1.0, 0.0);
      vec3 at = point + d * max(point.y - groundHeight, 0.0) / max(-d.y, max(0.5 * finish.x, 0.02));
      at.y = groundHeight;
      vec3 light = lampLight(at, up, up, ground, 1.0, vec4(-1.0)) * (1.0 - clamp(0.5 + 0.5 * d.y / rough, 0.0, 1.0));
      vec3 share = schlick(mix(vec3(atNormal(ior)), albedo, finish.y), toward, rough) * tabled(facetAlbedo, rough);
      return light * share * (1.0 + laterBounces(albedo, finish));
    }
  #else
    vec3 lampLight(vec3 point, vec3 n, vec3 v, vec3 albedo, float ior, vec4 finish) { return vec3(0.0); }
  #endif
`;

// What is in front of the section plane is not there.
const SECTION = /* glsl */ `
  uniform vec4 section; // normal, and the offset beyond which nothing is drawn
  bool isCut(vec3 point) { return dot(section.xyz, point) > section.w; }
`;

const SELECTED = /* glsl */ `
  uniform vec2 selected; // instances from .x up to .y
  bool isSelected(float instance) { return instance >= selected.x && instance < selected.y; }
`;

export const SOLID_FRAGMENT = /* glsl */ `
  ${VARYINGS}
  ${SELECTED}
  uniform vec3 ground[2]; // reflectance of its squares
  uniform int mode; // 0: natural, 1: instances, 2: normals, 3: depth, 4: x-ray
  uniform vec2 depths; // distances from the camera of the nearest and the farthest point
  ${LOOK}
  ${SHADOW}
  ${SKY}
  ${LIGHT}
  ${GLOSS}
  ${SURFACE}
  ${LAMPS}
  uniform bool isUnlit;
  ${TEXTURE}
  ${SECTION}
  // A hue for a number, far from those of the numbers beside it.
  vec3 hue(float number) {
    vec3 c = abs(fract(number * 0.61803399 + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0;
    return mix(vec3(0.35), clamp(c, 0.0, 1.0), 0.75) * (0.55 + 0.45 * fract(number * 0.754877666));
  }
  void main() {
    if (isCut(vPoint)) discard;
    if (mode == 4 && !isSelected(vInstance.y) && noise(gl_FragCoord.xy + vInstance.y) > 0.25) discard;
    vec3 v = isOrthographic ? vec3(viewMatrix[0][2], viewMatrix[1][2], viewMatrix[2][2]) : normalize(cameraPosition - vPoint);
    vec3 n = normalize(vNormal);
    n = gl_FrontFacing ? n : -n;
    #ifdef CLOSED
      // light passes a closed solid's surface twice, which the nearer side stands for
      if (gl_FrontFacing == (vMirrored > 0.5)) discard;
    #endif
    vec4 surface = look(0), glow = look(1), finish = look(2);
    vec3 l = lightAxes[2];
    float lit = dot(n, l) > 0.0 ? keyShare(vPoint, n) : 0.0;
    float sky = skyShare(vPoint, n);
    #ifdef TEXTURED
      float outside = gl_FrontFacing == (vMirrored > 0.5) ? -1.0 : 1.0;
      vec3 albedo = textured(surface.rgb, outside);
      n = relieved(n, v, outside);
    #else
      vec3 albedo = surface.rgb * vTint;
    #endif
    float facing = max(dot(n, l), 0.0);
    vec3 color = albedo * (surrounding(around(vPoint, n), albedo, sky) + key * facing * lit);
    if (finish.x >= 0.0) color = glossy(color, albedo, n, v, vec2(sky, lit), glow.w, finish);
    #ifdef LAMPS
      vec3 floorColor = 0.5 * (ground[0] + ground[1]);
      if (hasGround && finish.x >= 0.0) color += sky * mirroredLamps(vPoint, n, v, albedo, floorColor, glow.w, finish);
    #endif
    color = isUnlit ? albedo : color + lampLight(vPoint, n, v, albedo, glow.w, finish);
    color = exposed(color + glow.rgb);
    if (mode == 1) color = hue(vInstance.y) * (0.6 + 0.4 * abs(dot(n, v)));
    else if (mode == 2) color = pow(0.5 + 0.5 * n, vec3(2.2));
    else if (mode == 3) color = vec3(pow(1.0 - clamp((length(cameraPosition - vPoint) - depths.x) / (depths.y - depths.x), 0.0, 1.0), 2.2));
    else if (section.w < 1e8 && gl_FrontFacing == (vMirrored > 0.5)) color = 0.5 * albedo; // the inside, as if it were full
    #ifdef CLOSED
      float opacity = 1.0 - (1.0 - surface.a) * (1.0 - surface.a);
    #else
      float opacity = surface.a;
    #endif
    gl_FragColor = vec4(color, opacity);
  }
`;

export const GROUND_FRAGMENT = /* glsl */ `
  varying vec3 vPoint;
  uniform vec3 ground[2]; // reflectance of the squares
  uniform float checker; // their side
  uniform vec3 fade; // distances from the scene between which light falls off, and to which share
  ${SHADOW}
  ${SKY}
  ${LIGHT}
  ${GLOSS}
  ${LAMPS}
  void main() {
    vec3 n = vec3(0.0, 1.0, 0.0);
    vec2 square = floor(vPoint.xz / checker);
    vec3 albedo = mod(square.x + square.y, 2.0) < 0.5 ? ground[0] : ground[1];
    vec3 light = albedo * (surrounding(ambient, vec3(0.4), skyShare(vPoint, n)) + key * lightAxes[2].y * keyShare(vPoint, n));
    float far = clamp(log(max(length(vPoint.xz), fade.x) / fade.x) / log(fade.y / fade.x), 0.0, 1.0);
    light += lampLight(vPoint, n, n, albedo, 1.0, vec4(-1.0));
    light *= mix(1.0, fade.z, smoothstep(0.0, 1.0, far));
    gl_FragColor = vec4(exposed(light), 1.0);
  }
`;

// What is behind the scene, all over the picture: a color, or the dome.
export const BACKDROP_VERTEX = /* glsl */ `
  varying vec3 vView;
  void main() {
    mat4 p = projectionMatrix;
    vec3 d = isOrthographic ? vec3(0.0, 0.0, -1.0) : vec3((position.xy + p[2].xy) / vec2(p[0][0], p[1][1]), -1.0);
    vView = d * mat3(viewMatrix);
    gl_Position = vec4(position.xy, 1.0, 1.0);
  }
`;

export const BACKDROP_FRAGMENT = /* glsl */ `
  varying vec3 vView;
  uniform vec3 backdrop;
  uniform bool showsDome;
  ${SHADOW}
  ${LIGHT}
  void main() {
    gl_FragColor = vec4(exposed(showsDome ? textureLod(dome, onDome(normalize(vView)), 0.0).rgb : backdrop), 1.0);
  }
`;

// A lamp that is seen, a sphere or a rectangle.
export const SHINING_FRAGMENT = /* glsl */ `
  varying vec3 vPoint;
  uniform vec3 radiance;
  ${TONE}
  uniform bool isToned;
  void main() { gl_FragColor = vec4(isToned ? tone(radiance) : radiance, 1.0); }
`;

// Depth from the key light; what is see-through lets a share of its texels pass.
export const DEPTH_FRAGMENT = /* glsl */ `
  ${VARYINGS}
  ${LOOK}
  ${NOISE}
  ${SECTION}
  void main() {
    if (isCut(vPoint)) discard;
    float opacity = look(0).a;
    if (opacity < 1.0 && noise(gl_FragCoord.xy) >= opacity) discard;
    gl_FragColor = vec4(1.0);
  }
`;

// The instance's number, plus one, in base 256.
export const PICK_FRAGMENT = /* glsl */ `
  ${VARYINGS}
  ${SECTION}
  void main() {
    if (isCut(vPoint)) discard;
    float id = vInstance.y + 1.0;
    gl_FragColor = vec4(mod(id, 256.0), mod(floor(id / 256.0), 256.0), mod(floor(id / 65536.0), 256.0), 255.0) / 255.0;
  }
`;

// White where the selected instances are, whatever is before them; others are left out before they cover pixels.
export const SELECTED_VERTEX = /* glsl */ `
  ${INSTANCE}
  ${SELECTED}
  void main() {
    vec4 point = placed();
    gl_Position = isSelected(vInstance.y) ? projectionMatrix * viewMatrix * point : vec4(2.0, 2.0, 2.0, 1.0);
  }
`;

export const SELECTED_FRAGMENT = /* glsl */ `
  ${VARYINGS}
  ${SECTION}
  void main() {
    if (isCut(vPoint)) discard;
    gl_FragColor = vec4(1.0);
  }
`;

// The depth of the surface in base 256, the largest digit first.
export const PLACE_FRAGMENT = /* glsl */ `
  ${VARYINGS}
  ${SECTION}
  void main() {
    if (isCut(vPoint)) discard;
    float depth = floor(gl_FragCoord.z * 16777215.0);
    gl_FragColor = vec4(floor(depth / 65536.0), mod(floor(depth / 256.0), 256.0), mod(depth, 256.0), 255.0) / 255.0;
  }
`;

export const FILM_VERTEX = /* glsl */ `
  varying vec2 vUv;
  void main() { vUv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }
`;

// Linear radiance after the tone curve to sRGB. Around what is selected there is a line, which leaves its colors as they
// are; the light rim sets it off from surroundings of the same color.
export const FILM_FRAGMENT = /* glsl */ `
  varying vec2 vUv;
  uniform sampler2D picture;
  uniform bool isRaw; // the tone curve is still to come
  uniform sampler2D selection;
  uniform bool hasSelection;
  uniform vec2 line; // its width in the picture's coordinates
  uniform vec3 accent;
  ${TONE}
  // Whether the selection is within so many widths of the line.
  float selectedWithin(float widths) {
    float most = 0.0;
    for (int i = 0; i < 16; i += 1) {
      float angle = float(i) * 0.39269908;
      most = max(most, texture2D(selection, vUv + widths * line * vec2(cos(angle), sin(angle))).r);
    }
    return most;
  }
  void main() {
    vec3 c = texture2D(picture, vUv).rgb;
    c = clamp(isRaw ? tone(c) : c, 0.0, 1.0);
    if (hasSelection && texture2D(selection, vUv).r < 0.5) c = mix(mix(c, vec3(1.0), 0.8 * selectedWithin(1.5)), accent, selectedWithin(1.0));
    gl_FragColor = vec4(mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, step(c, vec3(0.0031308))), 1.0);
  }
`;

// A sample of a still picture, weighed by `share` against those before it.
export const ADD_FRAGMENT = /* glsl */ `
  varying vec2 vUv;
  uniform sampler2D picture;
  uniform float share;
  void main() { gl_FragColor = vec4(texture2D(picture, vUv).rgb, share); }
`;

// A quad over a Gaussian's ellipse in the picture: the covariance under the derivative of the projection, widened by
// 0.3 pixels squared, as backends/splats/projection.py has it.
export const SPLAT_VERTEX = /* glsl */ `
  attribute float splat;
  uniform sampler2D data;
  uniform vec2 viewport; // pixels
  varying vec2 vCorner;
  varying vec4 vColor;
  const float REACH = 3.33; // standard deviations
  vec4 texel(int number, int part) {
    int at = 4 * number + part;
    return texelFetch(data, ivec2(at % 4096, at / 4096), 0);
  }
  void main() {
    int number = int(splat);
    vec4 a = texel(number, 1), b = texel(number, 2);
    mat3 spread = mat3(a.x, a.y, a.z, a.y, a.w, b.x, a.z, b.x, b.y);
    vec3 q = (viewMatrix * vec4(texel(number, 0).xyz, 1.0)).xyz;
    vec2 focal = 0.5 * viewport * vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
    float z = max(-q.z, 1e-6);
    mat3 jacobian = isOrthographic
      ? mat3(focal.x, 0.0, 0.0, 0.0, focal.y, 0.0, 0.0, 0.0, 0.0)
      : mat3(focal.x / z, 0.0, 0.0, 0.0, focal.y / z, 0.0, focal.x * q.x / (z * z), focal.y * q.y / (z * z), 0.0);
    mat3 turn = jacobian * mat3(viewMatrix);
    mat3 flat_ = turn * spread * transpose(turn);
    float xx = flat_[0][0] + 0.3, yy = flat_[1][1] + 0.3, xy = flat_[0][1];
    float middle = 0.5 * (xx + yy);
    float radius = length(vec2(0.5 * (xx - yy), xy));
    vec2 axis = abs(xy) < 1e-9 ? (xx >= yy ? vec2(1.0, 0.0) : vec2(0.0, 1.0)) : normalize(vec2(xy, middle + radius - xx));
    vec2 sizes = sqrt(max(vec2(middle + radius, middle - radius), 0.1));
    vCorner = REACH * position.xy;
    vColor = texel(number, 3);
    vec2 offset = vCorner.x * sizes.x * axis + vCorner.y * sizes.y * vec2(-axis.y, axis.x);
    gl_Position = projectionMatrix * vec4(q, 1.0);
    gl_Position.xy += 2.0 * offset / viewport * gl_Position.w;
    if (!isOrthographic && q.z > -0.01) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  }
`;

export const SPLAT_FRAGMENT = /* glsl */ `
  varying vec2 vCorner;
  varying vec4 vColor;
  void main() {
    float alpha = min(0.999, vColor.a * exp(-0.5 * dot(vCorner, vCorner)));
    if (alpha < 1.0 / 255.0) discard;
    vec3 c = vColor.rgb;
    vec3 linear = mix(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, step(c, vec3(0.04045)));
    gl_FragColor = vec4(linear * alpha, alpha);
  }
`;
