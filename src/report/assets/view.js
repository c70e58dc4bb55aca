"use strict";
/* The specimen in three dimensions: three.js draws. Grains and points are balls, cut by the plane where it passes through them; bodies are their surfaces,
   walls their edges, contacts lines as wide as their forces are large. */

/* Loads the modules that the page holds. */
async function modules() {
  const held = (id) => document.getElementById(id).textContent;
  const address = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  const core = address(held("module-three-core"));
  const three = address(held("module-three").replaceAll('"./three.core.min.js"', JSON.stringify(core)));
  const orbit = address(held("module-orbit").replace("'three'", JSON.stringify(three)));
  const [THREE, { OrbitControls }] = await Promise.all([import(three), import(orbit)]);
  return { THREE, OrbitControls };
}

const KINDS = {
  grains: "grains", points: "points of the continuum", surface: "bodies", walls: "walls",
  contacts: "contacts of grains (force chains)", point_contacts: "contacts of grains and points",
};
/* A thickness that nothing has. */
const EVERYTHING = 1e30;
/* What one of a kind is called with its number. */
const NAMES = { grains: "grain", points: "point", surface: "body" };
const CHAINS = ["contacts", "point_contacts"];
/* Fills `section` with the view and its controls; `runs` are those with snapshots. */
async function view(section, runs) {
  const stage = make("div", { class: "stage" });
  const controls = make("div", { class: "controls" });
  section.append(make("div", { class: "solid" }, stage, controls));
  const { THREE, OrbitControls } = await modules();
  THREE.ColorManagement.enabled = false; // colours are written as they are
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  } catch {
    stage.append(make("p", {}, "This browser shows no WebGL 2: the specimen in three dimensions is left out."));
    return;
  }
  renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
  const canvas = renderer.domElement;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "The specimen: arrow keys turn it, plus and minus zoom, 0 shows all, N and P choose the next and the previous body");
  const tip = make("div", { class: "tip", "aria-hidden": "true" });
  tip.hidden = true;
  stage.append(canvas, tip);
  const scene = new THREE.Scene();
  const camera = new THREE.OrthographicCamera();
  camera.up.set(0, 0, 1);
  const orbit = new OrbitControls(camera, canvas);
  orbit.enableZoom = true;
  const shared = { plane: { value: new THREE.Vector4() }, cut: { value: false }, thick: { value: EVERYTHING }, least: { value: 0 } };
  const materials = Object.fromEntries(Object.entries(SHADERS).map(([kind, { vertex, fragment }]) => [kind, new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3, vertexShader: vertex, fragmentShader: fragment, uniforms: shared, side: THREE.DoubleSide,
  })]));
  const edge = new THREE.LineBasicMaterial();
  const state = { run: runs[0], frame: 0, field: "", log: false, own: false, axis: "", at: 0.5, flip: false, slice: false, hidden: new Set(CHAINS), chosen: null };
  report.view = { state, pixels, under: (x, y) => telling(under(x, y)), layers: () => layers.map((l) => ({ kind: l.kind, count: l.count })), limits: [0, 1] };
  let layers = [];
  let reach = [1, 1];
  let slice = 0;

  function pixels() {
    render();
    return canvas.toDataURL("image/png");
  }
  function frames() { return state.run.frames; }
  function box() {
    const [low, high] = frames().bounds;
    return { low, high, centre: low.map((v, a) => (v + high[a]) / 2), size: Math.hypot(...low.map((v, a) => high[a] - v)) || 1e-9 };
  }
  /* Draws at the next frame, however often it is asked to until then. */
  let due = 0;
  function draw() {
    due ||= requestAnimationFrame(render);
  }
  function render() {
    cancelAnimationFrame(due);
    due = 0;
    aim();
    mark();
    renderer.render(scene, camera);
  }
  /* The cut: unit normal, place along it, thickness of what is shown behind; null where nothing is cut. */
  function slab() {
    if (state.axis === "") return null;
    const a = "xyz".indexOf(state.axis);
    const { low, high } = box();
    const sign = state.flip ? -1 : 1;
    const normal = [0, 0, 0];
    normal[a] = sign;
    return { normal, at: sign * (low[a] + state.at * (high[a] - low[a])), thickness: state.slice ? slice : EVERYTHING };
  }
  /* The cut in the eye's axes, and the width of a pixel. */
  function aim() {
    camera.updateMatrixWorld();
    const cut = slab();
    shared.cut.value = cut !== null;
    shared.least.value = pixel() / 2;
    if (!cut) return;
    const normal = new THREE.Vector3(...cut.normal);
    const place = normal.clone().multiplyScalar(cut.at).applyMatrix4(camera.matrixWorldInverse);
    normal.transformDirection(camera.matrixWorldInverse);
    shared.plane.value.set(normal.x, normal.y, normal.z, normal.dot(place));
    shared.thick.value = cut.thickness;
  }
  function pixel() {
    return (camera.right - camera.left) / camera.zoom / (stage.clientWidth || 1);
  }

  /* What is chosen or pointed at: its layer and its index there. */
  const shownLayers = () => layers.filter((layer) => !state.hidden.has(layer.kind));
  function under(x, y) {
    camera.updateMatrixWorld();
    const { width, height } = canvas.getBoundingClientRect();
    const origin = new THREE.Vector3((2 * x) / width - 1, 1 - (2 * y) / height, -1).unproject(camera);
    const axis = (column) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, column).toArray();
    const ray = { origin: origin.toArray(), direction: axis(2).map((v) => -v), right: axis(0), up: axis(1) };
    return hit(ray, shownLayers(), slab(), pixel() / 2);
  }
  /* What was chosen by its kind and number, in the snapshot that is shown; null where it is not there. */
  function chosen() {
    if (!state.chosen) return null;
    const layer = shownLayers().find((l) => l.kind === state.chosen.kind);
    const index = layer ? (layer.numbers ? layer.numbers.indexOf(state.chosen.number) : state.chosen.number) : -1;
    return index >= 0 && index < layer.count ? { layer, index } : null;
  }
  const telling = (found) => (found ? described(found.layer, found.index, fieldOf(), layers) : null);
  function choose(found) {
    state.chosen = found ? { kind: found.layer.kind, number: found.layer.numbers ? found.layer.numbers[found.index] : found.index } : null;
    tell();
    draw();
  }
  function tell() {
    const found = chosen();
    // a contact has no number by which it would be found again
    if (!found && CHAINS.includes(state.chosen?.kind)) state.chosen = null;
    if (found) values.replaceChildren(...telling(found).map((line) => make("div", {}, line)));
    else if (state.chosen) values.textContent = `${NAMES[state.chosen.kind]} ${state.chosen.number} is not shown in this snapshot`;
    else values.textContent = "nothing is chosen";
    // print has no use for it then
    values.parentElement?.classList.toggle("only-screen", !found);
    wanted.value = state.chosen && state.chosen.kind in NAMES ? state.chosen.number : "";
  }
  /* Chooses the next body of the chosen kind, or the one before it. */
  function step(way) {
    const layer = chosen()?.layer || shownLayers().find((l) => l.kind in NAMES);
    const index = layer ? neighbour(layer, chosen()?.index, way, slab()) : null;
    if (index !== null) choose({ layer, index });
  }
  // dark within light: it stands out from every colour
  const rings = ["--ink", "--panel"].map((name, i) => {
    const paint = new THREE.MeshBasicMaterial({ depthTest: false, depthWrite: false, transparent: true, side: THREE.DoubleSide });
    const mesh = new THREE.Mesh(new THREE.RingGeometry(1 + 0.09 * i, 1.09 + 0.09 * i, 64), paint);
    mesh.renderOrder = 1;
    mesh.frustumCulled = false;
    scene.add(mesh);
    return { mesh, paint, name };
  });
  /* A ring around what is chosen. */
  function mark() {
    const found = chosen();
    const { centre, radius } = found ? around(found.layer, found.index) : { centre: [0, 0, 0], radius: 1 };
    for (const { mesh } of rings) {
      mesh.visible = found !== null;
      mesh.position.set(...centre);
      mesh.scale.setScalar(Math.max(1.03 * radius, 6 * pixel()));
      mesh.quaternion.copy(camera.quaternion);
    }
  }
  /* Shows what is at a place of the canvas beside it. */
  let pointed = 0;
  function point(x, y) {
    cancelAnimationFrame(pointed);
    pointed = requestAnimationFrame(() => {
      const lines = telling(under(x, y));
      tip.hidden = !lines;
      if (!lines) return;
      tip.replaceChildren(...lines.map((line) => make("div", {}, line)));
      const room = [stage.clientWidth - tip.offsetWidth - 4, stage.clientHeight - tip.offsetHeight - 4];
      tip.style.left = `${Math.max(4, x + 14 > room[0] ? x - tip.offsetWidth - 10 : x + 14)}px`;
      tip.style.top = `${Math.max(4, Math.min(y + 14, room[1]))}px`;
    });
  }
  function unpoint() {
    cancelAnimationFrame(pointed);
    tip.hidden = true;
  }
  /* Looks at everything from a direction. */
  function look(from) {
    const { centre, size } = box();
    const away = new THREE.Vector3(...from).normalize();
    camera.up.set(0, 0, 1);
    if (Math.abs(away.z) > 0.999) camera.up.set(0, 1, 0);
    camera.position.set(...centre).addScaledVector(away, 2 * size);
    orbit.object.up.copy(camera.up);
    orbit.target.set(...centre);
    camera.near = 0.01 * size;
    camera.far = 6 * size;
    camera.zoom = 1;
    orbit.update();
    camera.updateMatrixWorld();
    // half the width and height of everything, as it is seen from there
    const turned = new THREE.Matrix3().setFromMatrix4(camera.matrixWorldInverse);
    reach = [0, 0];
    for (let i = 0; i < 8; i++) {
      const corner = new THREE.Vector3(...[0, 1, 2].map((a) => frames().bounds[(i >> a) & 1][a] - centre[a])).applyMatrix3(turned);
      reach = [Math.max(reach[0], Math.abs(corner.x)), Math.max(reach[1], Math.abs(corner.y))];
    }
    resize();
    draw();
  }
  const front = () => (frames().flat ? [0, 0, 1] : [0.42, -0.9, 0.45]);
  function resize() {
    const [width, height] = [stage.clientWidth, stage.clientHeight];
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    const unit = 1.08 * Math.max(reach[0] / width, reach[1] / height, (1e-3 * box().size) / width);
    const [x, y] = [unit * width, unit * height];
    [camera.left, camera.right, camera.top, camera.bottom] = [-x, x, y, -y];
    camera.updateProjectionMatrix();
  }

  /* The quantities that colour, and limits of the scale. */
  const plainTone = [0.72, 0.74, 0.76];
  function fieldOf() { return frames().fields.find((f) => f.name === state.field); }
  function limits(held) {
    const field = fieldOf();
    let [low, high, positive] = [field.low, field.high, field.leastPositive];
    if (state.own) {
      [low, high, positive] = [Infinity, -Infinity, Infinity];
      for (const { values } of held) {
        for (const v of values || []) {
          if (!Number.isFinite(v)) continue;
          low = Math.min(low, v);
          high = Math.max(high, v);
          if (v > 0) positive = Math.min(positive, v);
        }
      }
    }
    if (state.log && high > 0) return [Math.max(positive, high * 1e-6), high];
    return [low, high];
  }
  const palette = report.data.palette;
  const rgb = (colour) => channels(colour).map((c) => c / 255);
  const sequence = palette.sequence.map(rgb);
  const generations = palette.generations.map(rgb);
  function colour(value, range) {
    if (!Number.isFinite(value)) return plainTone;
    if (state.field === "generation") return generations[Math.min(generations.length - 1, Math.max(0, Math.round(value)))];
    return onScale(value, range);
  }
  function onScale(value, [low, high], colours = sequence) {
    const share = state.log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
    const at = Math.min(1, Math.max(0, Number.isFinite(share) ? share : 0)) * (colours.length - 1);
    const i = Math.min(colours.length - 2, Math.floor(at));
    return colours[i].map((c, k) => c + (colours[i + 1][k] - c) * (at - i));
  }

  /* Makes the objects of the snapshot that is chosen. */
  function build() {
    for (const layer of layers) {
      scene.remove(layer.object);
      layer.object.geometry.dispose();
    }
    const frame = frames().list[state.frame];
    layers = layersOf(state.run, frame, state.field, box().size, forceRange()[1]);
    slice = sliceOf(layers, box().size);
    const [low, high] = state.field ? limits(layers) : [0, 1];
    report.view.limits = [low, high];
    for (const layer of layers) {
      layer.object = { grains: balls, points: balls, surface: faces, walls: edges, contacts: lines, point_contacts: lines }[layer.kind](layer, [low, high]);
      layer.object.frustumCulled = false;
      layer.object.visible = !state.hidden.has(layer.kind);
      scene.add(layer.object);
    }
    legend([low, high]);
    forces();
    say(frame);
    tell();
    unpoint();
    draw();
  }
  const each = (values, size) => new THREE.InstancedBufferAttribute(values, size);
  function quads(layer, attributes) {
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.instanceCount = layer.count;
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    geometry.setAttribute("position", new THREE.Float32BufferAttribute([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], 3));
    for (const [name, attribute] of Object.entries(attributes)) geometry.setAttribute(name, attribute);
    return new THREE.Mesh(geometry, materials[layer.kind]);
  }
  function balls(layer, range) {
    return quads(layer, { centre: each(layer.centres, 3), radius: each(layer.radii, 1), tone: each(tones(layer, range, 1), 3) });
  }
  function lines(layer) {
    const ends = new THREE.InstancedInterleavedBuffer(layer.ends, 6);
    const tone = new Float32Array(3 * layer.count);
    const range = forceRange();
    const colours = chainColours().map(rgb);
    layer.force.forEach((force, i) => tone.set(onScale(force, range, colours), 3 * i));
    return quads(layer, { from: new THREE.InterleavedBufferAttribute(ends, 3, 0), to: new THREE.InterleavedBufferAttribute(ends, 3, 3), width: each(layer.widths, 1), tone: each(tone, 3) });
  }
  /* Thin lines, which are of small forces, need colours that stand out from a dark ground. */
  const chainColours = () => (luminance(tone("--panel")) < 0.2 ? palette.sequence.map(readable) : palette.sequence);
  /* Limits of the scale of forces, N; a logarithmic one has three decades. */
  function forceRange() {
    const most = strongest(state.own ? [frames().list[state.frame]] : frames().list);
    return [state.log ? 1e-3 * most : 0, most];
  }
  function faces(layer, range) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(layer.corners, 3));
    geometry.setAttribute("tone", new THREE.BufferAttribute(tones(layer, range, 3), 3));
    return new THREE.Mesh(geometry, materials.surface);
  }
  function edges(layer) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(layer.corners, 3));
    return new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 30), edge);
  }
  /* A colour for each entry, `times` over. */
  function tones(layer, range, times) {
    const all = new Float32Array(3 * times * layer.count);
    for (let i = 0; i < layer.count; i++) {
      const c = layer.values ? colour(layer.values[i], range) : plainTone;
      for (let k = 0; k < times; k++) all.set(c, 3 * (times * i + k));
    }
    return all;
  }

  /* Controls. */
  const said = make("output", { "aria-live": "polite" });
  function say(frame) {
    const facts = frame.facts.map(([what, value, unit]) => `${what} ${digits(value, 4)}${unit && unit !== "–" ? ` ${unit}` : ""}`);
    const counts = frame.layers.filter((l) => l.kind !== "walls").map((l) => `${l.kind === "surface" ? bodies(l) : l.count} ${l.kind === "contacts" ? "contacts of grains" : KINDS[l.kind]}`);
    said.textContent = [`snapshot ${state.frame + 1} of ${frames().list.length}`, ...facts, ...counts].join(" · ");
  }
  const bodies = ({ kind, blob }) => new Set(layers.find((l) => l.kind === kind && l.blob === blob).numbers).size;
  const scale = make("div", { class: "scale" });
  const chains = make("div", { class: "scale", id: "forces" });
  function legend([low, high]) {
    const field = fieldOf();
    if (!field) return scale.replaceChildren();
    if (field.name === "generation") {
      const last = Math.min(generations.length - 1, field.high);
      const entries = Array.from({ length: last + 1 }, (_, i) => {
        const box = make("i");
        box.style.background = palette.generations[i];
        return make("span", {}, box, i === generations.length - 1 && field.high > i ? `${i} and later` : String(i));
      });
      return scale.replaceChildren(make("div", { class: "small" }, field.what), make("div", { class: "keys" }, entries));
    }
    scale.replaceChildren(...barOf(field, [low, high], field.name === "strength" ? " (grey: cannot break)" : ""));
  }
  function barOf({ what, unit: si }, [low, high], remark, colours = palette.sequence) {
    const [factor, unit] = scaled(si, Math.max(Math.abs(low), Math.abs(high)));
    const bar = make("div", { class: "bar", role: "img", "aria-label": "colours from the least to the largest value" });
    bar.style.background = `linear-gradient(to right, ${colours.join(", ")})`;
    const tick = (share) => (state.log ? low * (high / low) ** share : low + share * (high - low));
    const ticks = [0, 0.25, 0.5, 0.75, 1].map((share) => make("span", {}, digits(factor * tick(share), 3)));
    return [bar, make("div", { class: "ticks" }, ticks), make("div", { class: "small" }, what + (unit && unit !== "–" ? `, ${unit}` : "") + remark)];
  }
  /* The scale of the contacts' forces, where contacts are shown. */
  function forces() {
    const shown = shownLayers().some((layer) => layer.ends);
    chains.replaceChildren(...(shown ? barOf({ what: "normal force of contacts", unit: "N" }, forceRange(), "; lines are as wide as it is large, at the end of the scale and beyond it alike", chainColours()) : []));
  }
  const choice = (label, options, change) => {
    const select = make("select", { change: () => { change(select.value); } }, options.map(([value, text]) => make("option", { value }, text)));
    return make("label", {}, label, select);
  };
  const tick = (label, change, checked = false) => {
    const box = make("input", { type: "checkbox", change: () => change(box.checked) });
    box.checked = checked;
    return make("label", {}, box, ` ${label}`);
  };
  const slider = make("input", { type: "range", min: 0, step: 1, id: "snapshot", input: () => {
    state.frame = Number(slider.value);
    if (CHAINS.includes(state.chosen?.kind)) state.chosen = null;
    build();
  } });
  const fields = make("select", { id: "field", change: () => { state.field = fields.value; build(); } });
  const kinds = make("div", { class: "row" });
  const place = make("input", { type: "range", min: 0, max: 1, step: 0.005, value: state.at, "aria-label": "place of the cut", input: () => { state.at = Number(place.value); draw(); } });
  const button = (text, act) => make("button", { type: "button", click: act }, text);
  function take(run) {
    state.run = run;
    slider.max = run.frames.list.length - 1;
    state.frame = run.frames.list.length - 1;
    slider.value = state.frame;
    const known = run.frames.fields.filter((f) => f.low !== null && (f.name === "generation" || f.low < f.high));
    fields.replaceChildren(...known.map((f) => make("option", { value: f.name }, f.what)), make("option", { value: "" }, "nothing"));
    if (!known.some((f) => f.name === state.field)) {
      const best = ["generation", "plastic_strain", "speed"].find((name) => known.some((f) => f.name === name && f.high > f.low));
      state.field = best || known[0]?.name || "";
    }
    fields.value = state.field;
    const there = [...new Set(run.frames.list.flatMap((f) => f.layers.map((l) => l.kind)))];
    const boxes = there.map((kind) => tick(KINDS[kind], (on) => {
      if (on) state.hidden.delete(kind); else state.hidden.add(kind);
      // grains and points would hide the contacts between them
      if (on && CHAINS.includes(kind)) ["grains", "points"].forEach((other) => state.hidden.add(other));
      boxes.forEach((label, i) => { label.querySelector("input").checked = !state.hidden.has(there[i]); });
      build();
    }, !state.hidden.has(kind)));
    boxes.forEach((label, i) => label.querySelector("input").setAttribute("data-kind", there[i]));
    kinds.replaceChildren(...boxes);
    state.chosen = null;
    const dropped = run.frames.all - run.frames.list.length;
    note.textContent = dropped > 0 ? `${run.frames.list.length} of ${run.frames.all} snapshots are in this page; report --snapshots takes more` : "";
    build();
    look(front());
  }
  const other = tick("other side", (on) => { state.flip = on; draw(); });
  const note = make("p", { class: "quiet small" });
  const values = make("output", { id: "values", "aria-live": "polite" });
  const wanted = make("input", { type: "number", min: 0, step: 1, id: "wanted", change: () => {
    const number = Number(wanted.value);
    const layer = shownLayers().find((l) => l.kind in NAMES && (l.numbers ? l.numbers.includes(number) : number < l.count)) || shownLayers().find((l) => l.kind in NAMES);
    state.chosen = wanted.value === "" || !layer ? null : { kind: layer.kind, number };
    tell();
    draw();
  } });
  controls.append(
    make("fieldset", {}, make("legend", {}, "Instant"),
      runs.length > 1 ? choice("run", runs.map((r, i) => [i, r.name]), (i) => take(runs[i])) : null,
      make("label", { for: "snapshot" }, "snapshot"), slider, said, note),
    make("fieldset", {}, make("legend", {}, "Colour"), fields, scale, chains,
      make("div", { class: "row" }, tick("logarithmic", (on) => { state.log = on; build(); }), tick("scale of this snapshot alone", (on) => { state.own = on; build(); }))),
    make("fieldset", { class: "only-screen" }, make("legend", {}, "Cut"),
      choice("plane across", [["", "none"], ["x", "x"], ["y", "y"], ["z", "z (height)"]], (axis) => {
        state.axis = axis;
        // what is nearer to the eye is taken away
        if (axis) state.flip = other.querySelector("input").checked = camera.position[axis] < orbit.target[axis];
        draw();
      }),
      place, make("div", { class: "row" }, other, tick("only a slice", (on) => { state.slice = on; draw(); }))),
    make("fieldset", {}, make("legend", {}, "Values"), values,
      make("label", { for: "wanted", class: "only-screen" }, "number"), wanted,
      make("p", { class: "quiet small only-screen" }, "Point at a body, click to choose it, or type its number. Keys in the view: N next, P previous, Escape none.")),
    make("fieldset", { class: "only-screen" }, make("legend", {}, "View"),
      make("div", { class: "row" }, button("oblique", () => look([0.42, -0.9, 0.45])), button("front", () => look([0, -1, 0])), button("side", () => look([1, 0, 0])), button("top", () => look([0, 0, 1]))),
      kinds,
      make("p", { class: "quiet small" }, "Drag or arrow keys turn, wheel or + and − zoom, right button moves.")));
  fields.setAttribute("aria-label", "colour by");
  const colours = () => {
    renderer.setClearColor(tone("--panel"));
    edge.color.set(tone("--quiet"));
    for (const { paint, name } of rings) paint.color.set(tone(name));
    if (layers.length) build();
  };
  orbit.addEventListener("change", draw);
  new ResizeObserver(() => { resize(); if (layers.length) draw(); }).observe(stage);
  onColours(colours);
  for (const event of ["beforeprint", "afterprint"]) addEventListener(event, () => { colours(); resize(); render(); });
  let pressed = [0, 0];
  canvas.addEventListener("pointerdown", (event) => { pressed = [event.offsetX, event.offsetY]; unpoint(); });
  canvas.addEventListener("pointermove", (event) => { if (!event.buttons) point(event.offsetX, event.offsetY); });
  canvas.addEventListener("pointerleave", unpoint);
  canvas.addEventListener("click", (event) => {
    const [x, y] = [event.offsetX, event.offsetY];
    // what was dragged is turned, not chosen
    if (Math.hypot(x - pressed[0], y - pressed[1]) > 5) return;
    choose(under(x, y));
    point(x, y);
  });
  canvas.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (turn) {
      const away = camera.position.clone().sub(orbit.target);
      const up = camera.up.clone();
      away.applyAxisAngle(up, turn[0] * 0.1);
      const side = new THREE.Vector3().crossVectors(up, away).normalize();
      const tipped = away.clone().applyAxisAngle(side, turn[1] * 0.1);
      const angle = tipped.angleTo(up);
      camera.position.copy(orbit.target).add(angle > 0.02 && angle < Math.PI - 0.02 ? tipped : away);
    } else if (event.key === "+" || event.key === "=") camera.zoom *= 1.15;
    else if (event.key === "-") camera.zoom /= 1.15;
    else if (event.key === "0") return look(front());
    else if ("nNpP".includes(event.key)) return step(event.key.toLowerCase() === "n" ? 1 : -1);
    else if (event.key === "Escape") {
      unpoint();
      return choose(null);
    } else return;
    camera.updateProjectionMatrix();
    orbit.update();
    draw();
    event.preventDefault();
  });
  colours();
  take(runs[0]);
  render();
}
