"use strict";
/* What stands under the pointer: the first grain, point, body or contact that the line of sight meets, cut as it is drawn. */

/* Lengths along the line of sight between which it is not away; `slab`: normal, place along it, thickness; null where nothing is cut. */
function openPart({ origin, direction }, slab) {
  if (!slab) return [-Infinity, Infinity];
  const s = dot(slab.normal, origin) - slab.at;
  const rise = dot(slab.normal, direction);
  if (Math.abs(rise) < 1e-9) return s > 0 || s < -slab.thickness ? [Infinity, -Infinity] : [-Infinity, Infinity];
  const ends = [-s / rise, (-s - slab.thickness) / rise];
  return [Math.min(...ends), Math.max(...ends)];
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The nearest hit of a ray (origin, unit direction, both unit vectors across it) on layers: layer, index, length along the ray; null for none. */
function hit(ray, layers, slab, least) {
  const open = openPart(ray, slab);
  let best = null;
  if (!(open[0] <= open[1])) return best;
  const meets = { grains: ballsMet, points: ballsMet, surface: trianglesMet, contacts: linesMet, point_contacts: linesMet };
  for (const layer of layers) {
    const found = meets[layer.kind]?.(ray, layer, open, slab, least);
    if (found && (!best || found.length < best.length)) best = { layer, ...found };
  }
  return best;
}

function ballsMet({ origin: o, direction: d }, { kind, count, centres, radii }, [low, high], slab) {
  let [length, index] = [Infinity, -1];
  const filled = slab && kind === "points" && Number.isFinite(low);
  for (let i = 0; i < count; i++) {
    const [x, y, z] = [centres[3 * i] - o[0], centres[3 * i + 1] - o[1], centres[3 * i + 2] - o[2]];
    const along = x * d[0] + y * d[1] + z * d[2];
    const across = x * x + y * y + z * z - along * along;
    const square = radii[i] * radii[i];
    if (across > FILL * FILL * square) continue;
    let at = Infinity;
    if (filled) {
      const distance = Math.sqrt(across + (along - low) * (along - low));
      if (distance < FILL * radii[i]) at = low + DEEPER * distance;
    }
    if (at === Infinity && across <= square) {
      const half = Math.sqrt(square - across);
      const front = Math.max(along - half, low);
      if (front <= Math.min(along + half, high)) at = front;
    }
    if (at < length) [length, index] = [at, i];
  }
  return index < 0 ? null : { index, length };
}

function trianglesMet({ origin: o, direction: d }, { count, corners: c }, [low, high]) {
  let [length, index] = [Infinity, -1];
  for (let i = 0; i < count; i++) {
    const k = 9 * i;
    const [ax, ay, az] = [c[k + 3] - c[k], c[k + 4] - c[k + 1], c[k + 5] - c[k + 2]];
    const [bx, by, bz] = [c[k + 6] - c[k], c[k + 7] - c[k + 1], c[k + 8] - c[k + 2]];
    const [px, py, pz] = [d[1] * bz - d[2] * by, d[2] * bx - d[0] * bz, d[0] * by - d[1] * bx];
    const size = ax * px + ay * py + az * pz;
    if (size === 0) continue;
    const [x, y, z] = [o[0] - c[k], o[1] - c[k + 1], o[2] - c[k + 2]];
    const u = (x * px + y * py + z * pz) / size;
    if (u < 0 || u > 1) continue;
    const [qx, qy, qz] = [y * az - z * ay, z * ax - x * az, x * ay - y * ax];
    const v = (d[0] * qx + d[1] * qy + d[2] * qz) / size;
    if (v < 0 || u + v > 1) continue;
    const at = (bx * qx + by * qy + bz * qz) / size;
    if (at >= low && at <= high && at < length) [length, index] = [at, i];
  }
  return index < 0 ? null : { index, length };
}

function linesMet({ origin: o, direction: d, right, up }, { count, ends, widths }, open, slab, least) {
  let [length, index] = [Infinity, -1];
  const seen = (k) => {
    const way = [ends[k] - o[0], ends[k + 1] - o[1], ends[k + 2] - o[2]];
    return [dot(way, right), dot(way, up), dot(way, d)];
  };
  for (let i = 0; i < count; i++) {
    const k = 6 * i;
    const width = Math.max(widths[i], least);
    const [a, b] = [seen(k), seen(k + 3)];
    const [x, y] = [b[0] - a[0], b[1] - a[1]];
    const square = x * x + y * y;
    const share = square > 0 ? Math.min(1, Math.max(0, -(a[0] * x + a[1] * y) / square)) : 0;
    if ((a[0] + share * x) ** 2 + (a[1] + share * y) ** 2 > width * width) continue;
    if (slab) {
      const s = dot(slab.normal, [0, 1, 2].map((j) => (ends[k + j] + ends[k + 3 + j]) / 2)) - slab.at;
      if (s > 0 || s < -slab.thickness) continue;
    }
    const at = a[2] + share * (b[2] - a[2]) - width;
    if (at < length) [length, index] = [at, i];
  }
  return index < 0 ? null : { index, length };
}

/* Calls `act` with the place of the first number of each triangle of the body to which a triangle belongs. */
function ofBody({ count, numbers }, index, act) {
  for (let i = 0; i < count; i++) {
    if (numbers ? numbers[i] === numbers[index] : i === index) act(9 * i);
  }
}

/* Centre and radius of what stands at an index of a layer, for a mark around it. */
function around(layer, index) {
  const { centres, radii, corners, ends } = layer;
  if (centres) return { centre: [0, 1, 2].map((a) => centres[3 * index + a]), radius: radii[index] };
  if (ends) {
    const [from, to] = [0, 3].map((k) => [0, 1, 2].map((a) => ends[6 * index + k + a]));
    return { centre: from.map((x, a) => (x + to[a]) / 2), radius: Math.hypot(...from.map((x, a) => x - to[a])) / 2 };
  }
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  ofBody(layer, index, (at) => {
    for (let k = 0; k < 9; k++) {
      low[k % 3] = Math.min(low[k % 3], corners[at + k]);
      high[k % 3] = Math.max(high[k % 3], corners[at + k]);
    }
  });
  const centre = low.map((x, a) => (x + high[a]) / 2);
  let square = 0;
  ofBody(layer, index, (at) => {
    for (let k = 0; k < 9; k += 3) square = Math.max(square, centre.reduce((sum, x, a) => sum + (corners[at + k + a] - x) ** 2, 0));
  });
  return { centre, radius: Math.sqrt(square) };
}

/* Where the next larger number of a layer stands, or with `way` -1 the next smaller one, after that at `index` or of all; null for none. Balls that are cut
   away do not count. */
function neighbour(layer, index, way, slab) {
  const number = (i) => (layer.numbers ? layer.numbers[i] : i);
  let best = null;
  for (let i = 0; i < layer.count; i++) {
    if (index !== undefined && way * (number(i) - number(index)) <= 0) continue;
    if (best !== null && way * (number(i) - number(best)) >= 0) continue;
    if (slab && layer.centres) {
      const s = dot(slab.normal, layer.centres.subarray(3 * i, 3 * i + 3)) - slab.at;
      if (s > layer.radii[i] || s < -slab.thickness - layer.radii[i]) continue;
    }
    best = i;
  }
  return best;
}

/* Diameter, m, of a ball of the volume within the triangles of the body to which a triangle belongs; of a flat one of a disc of its area. */
function sizeOf(layer, index) {
  const { corners: c } = layer;
  let [six, twice] = [0, 0];
  ofBody(layer, index, (at) => {
    // from a corner of the body, so that nothing is lost to its distance from the origin
    const [a, b, e] = [0, 3, 6].map((k) => [0, 1, 2].map((j) => c[at + k + j] - c[9 * index + j]));
    const across = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    six += dot(a, across(b, e));
    twice += Math.hypot(...across(b.map((x, j) => x - a[j]), e.map((x, j) => x - a[j])));
  });
  return six === 0 ? [Math.sqrt((2 * twice) / Math.PI), "disc of its area"] : [Math.cbrt(Math.abs(six) / Math.PI), "ball of its volume"];
}

/* A quantity in words: name, value, unit that suits its size. */
function told(what, x, unit, count = 4) {
  const [factor, named] = scaled(unit, Math.abs(x));
  return `${what} ${digits(factor * x, count)}${named && named !== "–" ? ` ${named}` : ""}`;
}

/* What stands at an index of a layer, in words: what it is, its size, generation and the quantity that colours (`field`). */
function described(layer, index, field, all) {
  const number = layer.numbers ? layer.numbers[index] : index;
  const lines = [];
  if (layer.ends) {
    const grain = (i) => all.find((other) => other.kind === "grains").numbers[i];
    const first = grain(layer.grain[index]);
    const other = layer.other[index];
    const second = layer.kind === "point_contacts" ? `point ${other}` : index < layer.between ? `grain ${grain(other)}` : `wall ${layer.walls[other]}`;
    return [`contact of grain ${first} and ${second}`, told("normal force", layer.force[index], "N")];
  }
  if (layer.kind === "grains") lines.push(`grain ${number}`, told("radius", layer.radii[index], "m"));
  else if (layer.kind === "points") {
    lines.push(`point ${number}`);
    if (layer.sized) lines.push(told("edge", 2 * layer.radii[index], "m"));
  } else {
    const [size, meant] = sizeOf(layer, index);
    lines.push(`body ${number}`, `${told("diameter", size, "m")} (${meant})`);
  }
  const value = (name) => (layer.fields[name] === undefined ? null : layer.part(layer.fields[name], layer.count)[index]);
  if (value("generation") !== null) lines.push(`generation ${value("generation")}`);
  if (field && !["generation", "radius"].includes(field.name) && value(field.name) !== null) {
    const x = value(field.name);
    lines.push(field.name === "strength" && x === Infinity ? "cannot break" : told(field.what, x, field.unit));
  }
  return lines;
}
