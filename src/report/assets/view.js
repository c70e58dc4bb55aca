"use strict";
/* The specimen in three dimensions: three.js draws. Grains and points are balls that are exact in every pixel, and cut by the plane where it
   passes through them; bodies are their surfaces, walls their edges. */

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

/* The numbers of a blob: single precision, little-endian, in base 64. */
function numbers(id) {
  const text = atob(document.getElementById(`blob-${id}`).textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}

const LIGHT = "const vec3 light = vec3(-0.45, 0.65, 0.61);";
const BALL = {
  vertex: `in vec3 centre; in float radius; in vec3 tone; out vec2 at; out vec3 middle; out float r; out vec3 colour;
    void main() {
      vec4 c = modelViewMatrix * vec4(centre, 1.0);
      at = position.xy; middle = c.xyz; r = radius; colour = tone;
      gl_Position = projectionMatrix * (c + vec4(position.xy * radius, 0.0, 0.0));
    }`,
  // the eye looks along -z; a ball whose front is cut away shows its section
  fragment: `uniform mat4 projectionMatrix; uniform vec4 plane; uniform bool cut; in vec2 at; in vec3 middle; in float r; in vec3 colour; out vec4 seen; ${LIGHT}
    void main() {
      float square = dot(at, at);
      if (square > 1.0) discard;
      vec3 normal = vec3(at, sqrt(1.0 - square));
      vec3 place = middle + r * normal;
      float shade = 1.0;
      if (cut && dot(plane.xyz, place) > plane.w) {
        vec3 back = middle + r * vec3(at, -normal.z);
        if (dot(plane.xyz, back) > plane.w) discard;
        place.z = (plane.w - dot(plane.xy, place.xy)) / plane.z;
        normal = plane.xyz;
        shade = 0.86;
      }
      float brightness = 0.52 + 0.5 * max(dot(normal, light), 0.0);
      seen = vec4(colour * brightness * shade, 1.0);
      gl_FragDepth = 0.5 * (projectionMatrix[2][2] * place.z + projectionMatrix[3][2]) + 0.5;
    }`,
};
const FACE = {
  vertex: `in vec3 tone; out vec3 place; out vec3 colour;
    void main() { vec4 p = modelViewMatrix * vec4(position, 1.0); place = p.xyz; colour = tone; gl_Position = projectionMatrix * p; }`,
  fragment: `uniform vec4 plane; uniform bool cut; in vec3 place; in vec3 colour; out vec4 seen; ${LIGHT}
    void main() {
      if (cut && dot(plane.xyz, place) > plane.w) discard;
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      float brightness = gl_FrontFacing ? 0.52 + 0.5 * max(dot(normal, light), 0.0) : 0.4;
      seen = vec4(colour * brightness, 1.0);
    }`,
};

const KINDS = { grains: "grains", points: "points of the continuum", surface: "bodies", walls: "walls" };

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
  canvas.setAttribute("aria-label", "The specimen: arrow keys turn it, plus and minus zoom, 0 shows all");
  stage.append(canvas);
  const scene = new THREE.Scene();
  const camera = new THREE.OrthographicCamera();
  camera.up.set(0, 0, 1);
  const orbit = new OrbitControls(camera, canvas);
  orbit.enableZoom = true;
  const shared = { plane: { value: new THREE.Vector4() }, cut: { value: false } };
  const material = (shaders) => new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3, vertexShader: shaders.vertex, fragmentShader: shaders.fragment, uniforms: shared, side: THREE.DoubleSide,
  });
  const [ball, face] = [material(BALL), material(FACE)];
  const edge = new THREE.LineBasicMaterial();
  const state = { run: runs[0], frame: 0, field: "", log: false, own: false, axis: "", at: 0.5, flip: false, hidden: new Set() };
  report.view = { state, pixels, layers: () => layers.map((l) => ({ kind: l.kind, count: l.count })), limits: [0, 1] };
  let layers = [];
  let reach = [1, 1];

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
    renderer.render(scene, camera);
  }
  /* The plane in the eye's axes. */
  function aim() {
    camera.updateMatrixWorld();
    shared.cut.value = state.axis !== "";
    if (!shared.cut.value) return;
    const a = "xyz".indexOf(state.axis);
    const { low, high } = box();
    const sign = state.flip ? -1 : 1;
    const normal = new THREE.Vector3().setComponent(a, sign);
    const place = new THREE.Vector3().setComponent(a, low[a] + state.at * (high[a] - low[a]));
    normal.transformDirection(camera.matrixWorldInverse);
    place.applyMatrix4(camera.matrixWorldInverse);
    shared.plane.value.set(normal.x, normal.y, normal.z, normal.dot(place));
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
  function colour(value, [low, high]) {
    if (!Number.isFinite(value)) return plainTone;
    if (state.field === "generation") return generations[Math.min(generations.length - 1, Math.max(0, Math.round(value)))];
    const share = state.log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
    const at = Math.min(1, Math.max(0, Number.isFinite(share) ? share : 0)) * (sequence.length - 1);
    const i = Math.min(sequence.length - 2, Math.floor(at));
    return sequence[i].map((c, k) => c + (sequence[i + 1][k] - c) * (at - i));
  }

  /* Makes the objects of the snapshot that is chosen. */
  function build() {
    for (const layer of layers) {
      scene.remove(layer.object);
      layer.object.geometry.dispose();
    }
    const frame = frames().list[state.frame];
    layers = frame.layers.map((layer) => {
      const data = numbers(state.run.firstBlob + layer.blob);
      const part = (at, count) => data.subarray(at, at + count);
      const values = layer.fields[state.field] === undefined ? null : part(layer.fields[state.field], layer.count);
      return { ...layer, data, part, values };
    });
    const [low, high] = state.field ? limits(layers) : [0, 1];
    report.view.limits = [low, high];
    for (const layer of layers) {
      layer.object = { grains: balls, points: balls, surface: faces, walls: edges }[layer.kind](layer, [low, high]);
      layer.object.frustumCulled = false;
      layer.object.visible = !state.hidden.has(layer.kind);
      scene.add(layer.object);
    }
    legend([low, high]);
    say(frame);
    draw();
  }
  function balls(layer, range) {
    const { count } = layer;
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.instanceCount = count;
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    geometry.setAttribute("position", new THREE.Float32BufferAttribute([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], 3));
    geometry.setAttribute("centre", new THREE.InstancedBufferAttribute(layer.part(0, 3 * count), 3));
    const radius = Float32Array.from(layer.part(layer.places.radius, count), (r) => (r > 0 ? r : (0.3 * box().size) / Math.cbrt(count)));
    geometry.setAttribute("radius", new THREE.InstancedBufferAttribute(radius, 1));
    geometry.setAttribute("tone", new THREE.InstancedBufferAttribute(tones(layer, range, 1), 3));
    return new THREE.Mesh(geometry, ball);
  }
  function faces(layer, range) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(layer.part(0, 9 * layer.count), 3));
    geometry.setAttribute("tone", new THREE.BufferAttribute(tones(layer, range, 3), 3));
    return new THREE.Mesh(geometry, face);
  }
  function edges(layer) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(layer.part(0, 9 * layer.count), 3));
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
    const counts = frame.layers.filter((l) => l.kind !== "walls").map((l) => `${l.count} ${l.kind === "surface" ? "triangles of bodies" : KINDS[l.kind]}`);
    said.textContent = [`snapshot ${state.frame + 1} of ${frames().list.length}`, ...facts, ...counts].join(" · ");
  }
  const scale = make("div", { class: "scale" });
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
    const [factor, unit] = scaled(field.unit, Math.max(Math.abs(low), Math.abs(high)));
    const bar = make("div", { class: "bar", role: "img", "aria-label": "colours from the least to the largest value" });
    bar.style.background = `linear-gradient(to right, ${palette.sequence.join(", ")})`;
    const tick = (share) => (state.log ? low * (high / low) ** share : low + share * (high - low));
    const ticks = [0, 0.25, 0.5, 0.75, 1].map((share) => make("span", {}, digits(factor * tick(share), 3)));
    const beyond = frames().fields.some((f) => f.name === "strength") && field.name === "strength" ? " (grey: cannot break)" : "";
    scale.replaceChildren(bar, make("div", { class: "ticks" }, ticks), make("div", { class: "small" }, field.what + (unit && unit !== "–" ? `, ${unit}` : "") + beyond));
  }
  const choose = (label, options, change) => {
    const select = make("select", { change: () => { change(select.value); } }, options.map(([value, text]) => make("option", { value }, text)));
    return make("label", {}, label, select);
  };
  const tick = (label, change, checked = false) => {
    const box = make("input", { type: "checkbox", change: () => change(box.checked) });
    box.checked = checked;
    return make("label", {}, box, ` ${label}`);
  };
  const slider = make("input", { type: "range", min: 0, step: 1, id: "snapshot", input: () => { state.frame = Number(slider.value); build(); } });
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
    kinds.replaceChildren(...there.map((kind) => tick(KINDS[kind], (on) => {
      if (on) state.hidden.delete(kind); else state.hidden.add(kind);
      build();
    }, !state.hidden.has(kind))));
    const dropped = run.frames.all - run.frames.list.length;
    note.textContent = dropped > 0 ? `${run.frames.list.length} of ${run.frames.all} snapshots are in this page; report --snapshots takes more` : "";
    build();
    look(front());
  }
  const note = make("p", { class: "quiet small" });
  controls.append(
    make("fieldset", {}, make("legend", {}, "Instant"),
      runs.length > 1 ? choose("run", runs.map((r, i) => [i, r.name]), (i) => take(runs[i])) : null,
      make("label", { for: "snapshot" }, "snapshot"), slider, said, note),
    make("fieldset", {}, make("legend", {}, "Colour"), fields, scale,
      make("div", { class: "row" }, tick("logarithmic", (on) => { state.log = on; build(); }), tick("scale of this snapshot alone", (on) => { state.own = on; build(); }))),
    make("fieldset", { class: "only-screen" }, make("legend", {}, "Cut"),
      choose("plane across", [["", "none"], ["x", "x"], ["y", "y"], ["z", "z (height)"]], (axis) => { state.axis = axis; draw(); }),
      place, tick("other side", (on) => { state.flip = on; draw(); })),
    make("fieldset", { class: "only-screen" }, make("legend", {}, "View"),
      make("div", { class: "row" }, button("oblique", () => look([0.42, -0.9, 0.45])), button("front", () => look([0, -1, 0])), button("side", () => look([1, 0, 0])), button("top", () => look([0, 0, 1]))),
      kinds,
      make("p", { class: "quiet small" }, "Drag or arrow keys turn, wheel or + and − zoom, right button moves.")));
  fields.setAttribute("aria-label", "colour by");
  const colours = () => {
    renderer.setClearColor(tone("--panel"));
    edge.color.set(tone("--quiet"));
    if (layers.length) draw();
  };
  orbit.addEventListener("change", draw);
  new ResizeObserver(() => { resize(); if (layers.length) draw(); }).observe(stage);
  onColours(colours);
  for (const event of ["beforeprint", "afterprint"]) addEventListener(event, () => { colours(); resize(); render(); });
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
    else return;
    camera.updateProjectionMatrix();
    orbit.update();
    draw();
    event.preventDefault();
  });
  colours();
  take(runs[0]);
  render();
}
