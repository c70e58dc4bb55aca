"use strict";
/* The page: its sections in order. */

const { runs, charts } = report.data;
const names = runs.map((run) => run.name);
const several = runs.length > 1;
const content = document.getElementById("content");

/* A section with its heading and its entry in the list of sections. */
function section(id, title, ...children) {
  const element = make("section", { id, "aria-labelledby": `${id}-title` }, make("h2", { id: `${id}-title` }, title), children);
  content.append(element);
  document.querySelector("nav").append(make("a", { href: `#${id}` }, title));
  return element;
}

/* What `inner` makes of each run, under the run's name where there are several; nothing for runs of which it makes nothing. */
function each(inner) {
  return runs.flatMap((run) => {
    const made = inner(run);
    return made ? [several ? make("h3", {}, run.name) : null, made].flat(Infinity) : [];
  }).filter((part) => part);
}

function value(x) {
  return typeof x === "boolean" ? (x ? "yes" : "no") : x;
}

/* A table with a row for each entry of any run and a column for each run. */
function beside(head, rowsOf) {
  const rows = new Map();
  runs.forEach((run, i) => rowsOf(run).forEach(([key, x]) => {
    if (!rows.has(key)) rows.set(key, runs.map(() => null));
    rows.get(key)[i] = value(x);
  }));
  return rows.size ? table([head, ...(several ? names : ["value"])], [...rows].map(([key, values]) => [key, ...values])) : null;
}

document.querySelector("h1").textContent = several ? `Report of ${runs.length} runs` : names[0];

section("results", "Results", each((run) => [
  run.description ? make("p", { class: "quiet" }, run.description) : null,
  run.note ? make("ul", { class: "warnings" }, make("li", {}, run.note)) : null,
  run.closing.map((line) => make("p", {}, line)),
  run.warnings.length ? make("ul", { class: "warnings", "aria-label": "Warnings" }, run.warnings.map((text) => make("li", {}, `Warning: ${text}`))) : null,
]));

const switches = { runs: runs.map(() => true), bands: true };
if (charts.length) {
  const figures = charts.map((chart) => figure(chart, switches, names));
  const refresh = () => figures.forEach((each) => each.refresh());
  const toggle = (text, set) => {
    const box = make("input", { type: "checkbox", change: () => { set(box.checked); refresh(); } });
    box.checked = true;
    return make("label", {}, box, ` ${text}`);
  };
  const banded = charts.some((chart) => chart.series.some((series) => series.kind === "band" && series.run === null));
  section("figures", "Figures",
    make("p", { class: "quiet small no-print" }, "Point at a curve for its values, drag a box to zoom (or Ctrl and the wheel), double-click to see all. With the keyboard: Tab to a figure, then arrow keys, + and −, 0."),
    several ? make("div", { class: "row tools", role: "group", "aria-label": "Runs" },
      names.map((name, i) => toggle(name, (on) => { switches.runs[i] = on; })),
      banded ? toggle("median and band of the seeds", (on) => { switches.bands = on; }) : null) : null,
    make("div", { class: "charts" }, figures.map((each) => each.element)));
  figures.forEach((each) => each.start());
}

const withFrames = runs.filter((run) => run.frames.list.some((frame) => frame.layers.length));
const solid = withFrames.length ? section("specimen", "The specimen in three dimensions") : null;

const pictures = each((run) => (run.pictures.length ? make("div", { class: "charts" }, run.pictures.map(({ name, title, address }) =>
  make("figure", { id: `picture-${name}` }, make("figcaption", {}, title), make("img", { src: address, alt: `${title}, as the figure ${name} of the run shows it` })))) : null));
if (pictures.length) section("pictures", "Pictures", make("p", { class: "quiet small" }, "The run has left no snapshots, so that these are drawings and no view in three dimensions."), pictures);

const logs = each((run) => (run.logs.length ? run.logs.flatMap((content) => [make("h3", {}, content.title), log(content)]) : null));
if (logs.length) section("breakages", "Breakages", logs);

const quality = beside("measure", (run) => run.quality.map(([what, x, unit]) => [unit && unit !== "–" ? `${what} (${unit})` : what, x]));
if (quality) {
  section("quality", "Energy and quasi-static quality", quality,
    runs.every((run) => run.warnings.length === 0) ? make("p", {}, "The run has noted no warnings.") : make("p", {}, "Warnings stand under ", make("a", { href: "#results" }, "Results"), "."));
}

const sources = each((run) => {
  if (run.sources.unknown) return [make("p", {}, `Assumed values are not known: ${run.sources.unknown}`)];
  const { assumed, decisions } = run.sources;
  const shown = (x) => (typeof x === "object" && x !== null ? JSON.stringify(x) : value(x));
  return [
    assumed.length ? table(["assumed value", "value", "source"], assumed.map((a) => [a.key, shown(a.value), a.source]), "Values that no paper gives") : null,
    decisions.length ? table(["open matter", "settled by", "value"], decisions.map((d) => [d.matter, d.key, shown(d.value)]), "Matters that papers leave open") : null,
    make("details", {}, make("summary", {}, "The scene with every default"), make("pre", {}, run.scene)),
  ];
});
section("provenance", "What was run", sources);

section("tables", "Tables and files", each((run) => [
  make("p", {}, make("a", { href: `${run.folder || "."}/` }, "folder of the run"), " · ",
    make("a", { href: run.files.scene }, "scene.resolved.toml"), run.files.summary ? [" · ", make("a", { href: run.files.summary }, "summary.json")] : []),
  make("p", { class: "small" }, run.tables.flatMap((entry, i) => [i ? " · " : "", make("a", { href: entry.link }, entry.file)])),
]), make("details", {}, make("summary", {}, "Every entry of summary.json"), beside("entry", (run) => run.summary) || make("p", {}, "none")));

content.append(make("footer", {}, `Made by comminute ${report.data.version} of the records of the run${several ? "s" : ""}. The page needs no network.`));

/* In print, figures have the colours of the paper and enough pixels. */
const fit = (ratio) => () => report.charts.forEach(({ chart }) => {
  chart.options.devicePixelRatio = ratio;
  for (const axis of ["x", "y"]) chart.options.scales[axis].ticks.font = { size: ratio ? 20 : undefined };
  paint(chart);
  chart.resize();
  chart.update("none");
});
addEventListener("beforeprint", fit(3));
addEventListener("afterprint", fit(undefined));

const opened = () => {
  report.ready = true;
  report.opened = performance.now();
};
if (solid) view(solid, withFrames).then(opened, (error) => { report.errors.push(String(error)); opened(); });
else opened();
