"use strict";
/* What a snapshot holds: grains, points, triangles of bodies and walls, contacts, each with its numbers. */

/* The numbers of a blob: single precision, little-endian, in base 64; whole numbers stand in it as they are. */
function numbers(id) {
  const text = atob(document.getElementById(`blob-${id}`).textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}

/* Half the width of the widest contact, over the median length of all. */
const WIDEST = 0.16;
/* Drawn share of the line of a contact of a grain and a point, at the point's end: every grain has many. */
const OUTER = 0.4;
/* Thickness of a slice over the median distance of two grains in contact, as in the figure of force chains. */
const SLICE = 2;

/* The layers of a snapshot of a run; `field` colours, `size` is the length of all, `most` the force of the widest contact, N. */
function layersOf(run, frame, field, size, most) {
  const layers = frame.layers.map((layer) => {
    const data = numbers(run.firstBlob + layer.blob);
    const part = (at, count) => data.subarray(at, at + count);
    const whole = (at, count) => new Uint32Array(data.buffer, 4 * at, count);
    const values = layer.fields[field] === undefined ? null : part(layer.fields[field], layer.count);
    const known = layer.places.number === undefined ? null : whole(layer.places.number, layer.count);
    return { ...layer, part, whole, values, numbers: known };
  });
  for (const layer of layers) {
    if (["grains", "points"].includes(layer.kind)) placeBalls(layer, size);
    else if (["contacts", "point_contacts"].includes(layer.kind)) placeLines(layer, layers, most);
    else layer.corners = layer.part(0, 9 * layer.count);
  }
  return layers;
}

function placeBalls(layer, size) {
  const { count, part, places } = layer;
  layer.centres = part(0, 3 * count);
  const radii = part(places.radius, count);
  layer.sized = radii[0] > 0;
  layer.radii = layer.sized ? radii : new Float32Array(count).fill((0.3 * size) / Math.cbrt(count));
}

/* Ends, forces and half the widths of contacts: `between` of them are between two grains, the others have their ends in the blob. */
function placeLines(layer, layers, most) {
  const { count, between, places, kind } = layer;
  const { centres } = layers.find((other) => other.kind === "grains");
  layer.grain = layer.whole(places.grain, count);
  layer.other = layer.whole(places.other, count);
  layer.force = layer.part(places.force, count);
  const beyond = layer.part(places.end, 3 * (count - between));
  layer.ends = new Float32Array(6 * count);
  const lengths = new Float32Array(count);
  for (let i = 0; i < count; i++) {
    const [to, at] = i < between ? [centres, 3 * layer.other[i]] : [beyond, 3 * (i - between)];
    const grain = 3 * layer.grain[i];
    let square = 0;
    for (let a = 0; a < 3; a++) {
      const way = to[at + a] - centres[grain + a];
      square += way * way;
      layer.ends[6 * i + a] = kind === "point_contacts" ? to[at + a] - OUTER * way : centres[grain + a];
      layer.ends[6 * i + 3 + a] = to[at + a];
    }
    lengths[i] = Math.sqrt(square);
  }
  layer.length = lengths.sort()[count >> 1];
  const widest = WIDEST * layer.length * (kind === "point_contacts" ? OUTER : 1);
  layer.widths = Float32Array.from(layer.force, (force) => widest * Math.min(1, force / most));
}

/* The force, N, that all but half a percent of the contacts of each of these snapshots are below. */
function strongest(frames) {
  return Math.max(0, ...frames.flatMap((frame) => frame.layers.map((layer) => layer.large || 0)));
}

/* Thickness of a slice, m, of all that is `size` long. */
function sliceOf(layers, size) {
  const [chains, grown] = [layers.find((l) => l.kind === "contacts"), layers.find((l) => l.radii)];
  if (chains) return SLICE * chains.length;
  return grown ? 2 * SLICE * grown.radii.slice().sort()[grown.count >> 1] : 0.1 * size;
}
