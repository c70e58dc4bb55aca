"use strict";
/* How the view draws on the graphics device. Grains and points are balls that are exact in every pixel; lines of contacts are round. What is away is in front of
   the plane of the cut, or behind the slice where only that is shown. The eye looks along -z. */

const LIGHT = "const vec3 light = vec3(-0.45, 0.65, 0.61);";
const CUT = `uniform vec4 plane; uniform bool cut; uniform float thick;
    bool away(vec3 place) { float s = dot(plane.xyz, place) - plane.w; return cut && (s > 0.0 || s < -thick); }
    // depths between which the line of sight through a place is not away: the nearer one first
    vec2 open(vec2 place) {
      if (!cut) return vec2(1e30, -1e30);
      float steep = abs(plane.z) < 1e-6 ? 1e-6 : plane.z;
      float s = dot(plane.xy, place) - plane.w;
      vec2 ends = vec2(-s, -s - thick) / steep;
      return vec2(max(ends.x, ends.y), min(ends.x, ends.y));
    }`;
const DEPTH = "gl_FragDepth = 0.5 * (projectionMatrix[2][2] * place.z + projectionMatrix[3][2]) + 0.5;";
/* Radius in which a point fills the cut, over its own: as far as the corners of a cube of its volume. */
const FILL = Math.sqrt(3);
/* How much deeper than the cut a place there lies, over its distance from the point that fills it: the nearest point is seen. */
const DEEPER = 0.02;

const ball = (fills) => ({
  vertex: `in vec3 centre; in float radius; in vec3 tone; out vec2 at; out vec3 middle; out float r; out vec3 colour; ${CUT}
    void main() {
      vec4 c = modelViewMatrix * vec4(centre, 1.0);
      float s = dot(plane.xyz, c.xyz) - plane.w;
      bool wide = ${fills} && cut && min(abs(s), abs(s + thick)) < ${FILL} * radius;
      at = position.xy * (wide ? ${FILL} : 1.0); middle = c.xyz; r = radius; colour = tone;
      gl_Position = projectionMatrix * (c + vec4(at * radius, 0.0, 0.0));
    }`,
  fragment: `uniform mat4 projectionMatrix; in vec2 at; in vec3 middle; in float r; in vec3 colour; out vec4 seen; ${CUT} ${LIGHT}
    void main() {
      float square = dot(at, at);
      float rise = sqrt(max(1.0 - square, 0.0));
      vec3 place = middle + r * vec3(at, rise);
      vec3 normal = vec3(at, rise);
      vec2 ends = open(place.xy);
      float apart = length(vec3(r * at, ends.x - middle.z));
      bool filled = ${fills} && cut && apart < ${FILL} * r;
      float shade = 1.0;
      if (filled || place.z > ends.x) {
        place.z = ends.x;
        normal = plane.z < 0.0 ? -plane.xyz : plane.xyz;
        shade = 0.86;
      }
      if (filled) place.z -= ${DEEPER} * apart;
      else if (square > 1.0 || place.z < max(middle.z - r * rise, ends.y)) discard;
      float brightness = 0.52 + 0.5 * max(dot(normal, light), 0.0);
      seen = vec4(colour * brightness * shade, 1.0);
      ${DEPTH}
    }`,
});
const SHADERS = {
  grains: ball(false),
  points: ball(true),
  surface: {
    vertex: `in vec3 tone; out vec3 place; out vec3 colour;
    void main() { vec4 p = modelViewMatrix * vec4(position, 1.0); place = p.xyz; colour = tone; gl_Position = projectionMatrix * p; }`,
    fragment: `in vec3 place; in vec3 colour; out vec4 seen; ${CUT} ${LIGHT}
    void main() {
      if (away(place)) discard;
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      float brightness = gl_FrontFacing ? 0.52 + 0.5 * max(dot(normal, light), 0.0) : 0.4;
      seen = vec4(colour * brightness, 1.0);
    }`,
  },
  // a contact is drawn whole, or not at all where its middle is away
  contacts: {
    vertex: `in vec3 from; in vec3 to; in float width; in vec3 tone; uniform float least; out vec2 at; out vec3 place; out float w; out float reach; out vec3 colour; ${CUT}
    void main() {
      vec3 a = (modelViewMatrix * vec4(from, 1.0)).xyz, b = (modelViewMatrix * vec4(to, 1.0)).xyz;
      vec2 way = b.xy - a.xy;
      reach = length(way);
      vec2 along = reach > 0.0 ? way / reach : vec2(1.0, 0.0);
      w = max(width, least);
      vec2 shift = w * position.xy;
      place = (position.x < 0.0 ? a : b) + vec3(along * shift.x + vec2(-along.y, along.x) * shift.y, 0.0);
      at = vec2((position.x < 0.0 ? 0.0 : reach) + shift.x, shift.y);
      colour = tone;
      gl_Position = away(0.5 * (a + b)) ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * vec4(place, 1.0);
    }`,
    fragment: `uniform mat4 projectionMatrix; in vec2 at; in vec3 place; in float w; in float reach; in vec3 colour; out vec4 seen;
    void main() {
      float beyond = at.x - clamp(at.x, 0.0, reach);
      float square = (beyond * beyond + at.y * at.y) / (w * w);
      if (square > 1.0) discard;
      float rise = sqrt(1.0 - square);
      seen = vec4(colour * (0.6 + 0.4 * rise), 1.0);
      gl_FragDepth = 0.5 * (projectionMatrix[2][2] * (place.z + w * rise) + projectionMatrix[3][2]) + 0.5;
    }`,
  },
};
SHADERS.point_contacts = SHADERS.contacts;
