"use strict";
/* Figures as charts: Chart.js draws, chartjs-plugin-zoom zooms. The numbers are those of the CSV beside each figure. */

Chart.defaults.font.family = '"Noto Sans", "DejaVu Sans", system-ui, sans-serif';
Chart.defaults.font.size = 13;
Chart.defaults.animation = false;

/* The point under the pointer: the nearest of all shown series, but of no edge of a band. */
Chart.Interaction.modes.point_of_series = (chart, event, options, final) => {
  const at = Chart.helpers.getRelativePosition(event, chart);
  let nearest = [];
  let least = 40 ** 2; // pixels, squared
  for (const meta of chart.getSortedVisibleDatasetMetas()) {
    if (chart.data.datasets[meta.index].edge) continue;
    meta.data.forEach((element, index) => {
      if (element.skip) return;
      const { x, y } = element.getProps(["x", "y"], final);
      const distance = (x - at.x) ** 2 + (y - at.y) ** 2;
      if (distance < least) {
        least = distance;
        nearest = [{ element, datasetIndex: meta.index, index }];
      }
    });
  }
  return nearest;
};

/* Fill of the plot area, so that charts are opaque when they are copied, and equal scales where the figure has them. */
const ground = {
  id: "ground",
  beforeDraw(chart) {
    const { ctx, width, height } = chart;
    ctx.save();
    ctx.fillStyle = tone("--panel");
    ctx.fillRect(0, 0, width, height);
    ctx.restore();
  },
};

/* Labels of ticks: on logarithmic axes the decades, and 2 and 5 where there is room for no more than two of them. */
function tickLabel(value) {
  if (this.type !== "logarithmic") return digits(value, 6);
  const lead = Number(String(value.toExponential()).split("e")[0]);
  const decades = Math.log10(this.max / this.min);
  return Math.abs(lead - 1) < 1e-9 || (decades < 2.2 && [2, 5].includes(Math.round(lead * 1e6) / 1e6)) ? digits(value, 3) : "";
}

/* Whether a series is shown: neither its legend entry, nor its run, nor its kind is switched off. */
function isShown(series, hidden, switches) {
  if (hidden.has(series.key)) return false;
  if (series.kind === "band" && series.run === null) return switches.bands;
  return series.run === null || switches.runs[series.run];
}

/* The datasets of a series: one, or two edges and a median for a band. */
function datasets(series) {
  const points = (values) => series.x.map((x, i) => ({ x, y: values[i] }));
  const line = series.kind === "line" || series.kind === "band" || series.kind === "guide";
  const lone = series.x.length === 1;
  const own = {
    label: plain(series.label || series.name), source: series, data: points(series.y), showLine: line,
    borderWidth: series.kind === "guide" ? 1.2 : 2, borderDash: series.dash.map((d) => 2 * d),
    pointRadius: line && !lone ? 0 : 4, pointHoverRadius: 5, tension: 0, spanGaps: false,
  };
  if (series.kind !== "band") return [own];
  const edge = (values, fill) => ({
    label: own.label, source: series, edge: true, data: points(values), showLine: true, borderWidth: 0, pointRadius: 0,
    pointHoverRadius: 0, fill,
  });
  return [edge(series.low, false), edge(series.high, "-1"), own];
}

/* Sets the colours of a chart to those of the page. */
function paint(chart) {
  for (const set of chart.data.datasets) {
    const colour = readable(set.source.colour);
    set.borderColor = set.pointBorderColor = colour;
    set.pointBackgroundColor = tone("--panel");
    set.pointHoverBackgroundColor = colour;
    set.backgroundColor = colour + "33";
  }
  for (const axis of ["x", "y"]) {
    const { grid, ticks, border } = chart.options.scales[axis];
    grid.color = tone("--grid");
    ticks.color = tone("--ink");
    border.color = tone("--quiet");
  }
  const tip = chart.options.plugins.tooltip;
  tip.backgroundColor = tone("--ink");
  tip.titleColor = tip.bodyColor = tone("--page");
}

/* Makes one unit equally long on both axes, as far as the axes reach now. */
function equalize(chart) {
  const { x, y } = chart.scales;
  const { width, height } = chart.chartArea;
  const unit = Math.max((x.max - x.min) / width, (y.max - y.min) / height);
  chart.options.scales.x.max = x.min + unit * width;
  chart.options.scales.y.max = y.min + unit * height;
  chart.update("none");
}

/* A sample of how a series is drawn, for the legend. */
function swatch(series) {
  const svg = (tag, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
    return element;
  };
  const box = svg("svg", { class: "swatch", viewBox: "0 0 34 12", "aria-hidden": "true" });
  const paintAll = () => {
    const stroke = readable(series.colour);
    box.replaceChildren();
    if (series.kind === "band") box.append(svg("rect", { width: 34, height: 12, fill: stroke, "fill-opacity": 0.2 }));
    if (series.kind === "data") box.append(svg("circle", { cx: 17, cy: 6, r: 4, fill: "none", stroke, "stroke-width": 2 }));
    else {
      const width = series.kind === "guide" ? 1.2 : 2.4;
      box.append(svg("line", { x1: 0, x2: 34, y1: 6, y2: 6, stroke, "stroke-width": width, "stroke-dasharray": series.dash.map((d) => 2 * d).join(" ") || "none" }));
    }
  };
  paintAll();
  onColours(paintAll);
  return box;
}

/* A figure with its chart, legend and tools. `switches` says which runs and bands are shown. */
function figure(content, switches, names) {
  const [, unitX] = quantity(content.x.label);
  const [nameY, unitY] = quantity(content.y.label);
  const [nameX] = quantity(content.x.label);
  const hidden = new Set();
  const several = names.length > 1;
  // one legend entry for each label of a run; a series without one goes with the entry before it
  let key = "";
  content.series.forEach((series) => {
    if (series.label) key = `${series.run} ${series.kind} ${series.label}`;
    series.key = key;
  });
  const canvas = make("canvas", { tabindex: "0", role: "img", "aria-label": `${plain(nameY)} against ${plain(nameX)}: arrow keys show values, plus and minus zoom, 0 shows all` });
  const scale = (axis, log) => ({
    type: log ? "logarithmic" : "linear", reverse: axis.downwards, offset: false,
    // the range of the figure, where the axis is the figure's
    min: log === axis.log ? axis.range[0] : undefined, max: log === axis.log ? axis.range[1] : undefined,
    grid: {}, border: {}, ticks: { callback: tickLabel, includeBounds: false, maxRotation: 0, autoSkip: !log, autoSkipPadding: 14 },
  });
  const value = (x, unit) => digits(x, 6) + (unit ? ` ${plain(unit)}` : "");
  const config = {
    type: "scatter",
    data: { datasets: content.series.flatMap(datasets) },
    plugins: [ground],
    options: {
      maintainAspectRatio: false, parsing: false, normalized: false,
      interaction: { mode: "point_of_series", intersect: false },
      scales: { x: scale(content.x, content.x.log), y: scale(content.y, content.y.log) },
      plugins: {
        legend: { display: false },
        tooltip: {
          displayColors: false,
          callbacks: {
            title: (items) => items.map((item) => item.dataset.label),
            label: ({ raw, dataset, dataIndex }) => [
              `${plain(nameX)}: ${value(raw.x, unitX)}`, `${plain(nameY)}: ${value(raw.y, unitY)}`,
              ...(dataset.source.low ? [`${digits(dataset.source.low[dataIndex], 6)} to ${value(dataset.source.high[dataIndex], unitY)}`] : []),
            ],
          },
        },
        zoom: {
          zoom: { drag: { enabled: true, threshold: 6 }, wheel: { enabled: true, modifierKey: "ctrl" }, mode: "xy" },
        },
      },
    },
  };
  let chart = null;
  const refresh = () => {
    chart.data.datasets.forEach((set, i) => chart.setDatasetVisibility(i, isShown(set.source, hidden, switches)));
    paint(chart);
    chart.update("none");
  };
  const everything = () => {
    chart.resetZoom("none");
    if (content.equal) equalize(chart);
  };
  const keys = [...new Map(content.series.filter((s) => s.label).map((s) => [s.key, s])).values()];
  const text = (series) => {
    if (series.kind === "band" && series.run === null) return ["median and band: ", ...marked(series.label)];
    if (!several || series.run === null) return marked(series.label);
    return series.label === names[series.run] ? marked(series.label) : [`${names[series.run]}: `, ...marked(series.label)];
  };
  const legend = make("div", { class: "legend", role: "group", "aria-label": "Series: switch on and off" }, content.legend ? make("span", { class: "small" }, marked(content.legend)) : null, keys.map((series) => {
    const button = make("button", { type: "button", "aria-pressed": "true", click: () => {
      if (!hidden.delete(series.key)) hidden.add(series.key);
      button.setAttribute("aria-pressed", String(!hidden.has(series.key)));
      refresh();
    } }, swatch(series), make("span", { class: "entry" }, text(series)));
    return button;
  }));
  const positive = (pick) => content.series.every((series) => pick(series).every((v) => v > 0));
  const logarithmic = (name, axis, pick) => {
    // points that are not positive have no place on a logarithmic axis
    const button = make("button", { type: "button", "aria-pressed": String(axis.log), title: positive(pick) ? null : "leaves out values that are not positive", click: () => {
      const log = chart.options.scales[name].type !== "logarithmic";
      chart.resetZoom("none");
      chart.options.scales[name] = scale(axis, log);
      button.setAttribute("aria-pressed", String(log));
      refresh();
    } }, `log ${name}`);
    return button;
  };
  const csv = content.csv.map((link, run) => (link ? make("a", { href: link, title: names[run], "aria-label": `CSV of ${names[run]}` }, several ? String(run + 1) : "CSV") : null));
  const links = several && content.csv.some((link) => link) ? make("span", {}, "CSV of run ", csv.flatMap((link) => (link ? [link, " "] : []))) : csv;
  canvas.addEventListener("dblclick", everything);
  canvas.addEventListener("keydown", (event) => keyed(event, chart, everything));
  const figure = make("figure", { id: `figure-${content.name}` },
    make("figcaption", {}, make("span", {}, marked(nameY), " against ", marked(nameX)),
      content.title.length ? make("div", { class: "quiet small" }, content.title.flatMap((part, i) => [i ? " · " : "", ...marked(part)])) : null),
    legend,
    make("div", { class: "frame" },
      make("div", { class: "y" }, marked(content.y.label)), make("div", { class: "plot" }, canvas),
      make("div", { class: "x" }, marked(content.x.label))),
    make("div", { class: "row tools" },
      logarithmic("x", content.x, (s) => s.x), logarithmic("y", content.y, (s) => s.y),
      make("button", { type: "button", "aria-label": "zoom in", click: () => chart.zoom(1.3) }, "+"),
      make("button", { type: "button", "aria-label": "zoom out", click: () => chart.zoom(1 / 1.3) }, "−"),
      make("button", { type: "button", click: everything }, "all"),
      links));
  // drawn once, when the canvas has its size
  const start = () => {
    paint(config);
    chart = new Chart(canvas, config);
    report.charts.push({ name: content.name, chart, series: content.series });
    if (content.equal) equalize(chart);
    onColours(() => { paint(chart); chart.update("none"); });
  };
  return { element: figure, refresh, start };
}

/* Keys on a chart: arrows go from point to point and from series to series, plus and minus zoom, 0 shows all. */
function keyed(event, chart, everything) {
  const shown = chart.getSortedVisibleDatasetMetas().filter((meta) => !chart.data.datasets[meta.index].edge);
  const active = chart.tooltip.getActiveElements()[0] || { datasetIndex: shown[0]?.index, index: -1 };
  const place = Math.max(0, shown.findIndex((meta) => meta.index === active.datasetIndex));
  const step = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 0], ArrowUp: [-1, 0] }[event.key];
  if (step && shown.length) {
    const meta = shown[(place + step[0] + shown.length) % shown.length];
    const count = meta.data.length;
    const index = Math.min(count - 1, Math.max(0, active.index + step[1]));
    const found = [{ datasetIndex: meta.index, index }];
    const { x, y } = meta.data[index] || { x: 0, y: 0 };
    chart.setActiveElements(found);
    chart.tooltip.setActiveElements(found, { x, y });
    chart.update("none");
  } else if (event.key === "+" || event.key === "=") chart.zoom(1.3);
  else if (event.key === "-") chart.zoom(1 / 1.3);
  else if (event.key === "0") everything();
  else if (event.key === "Escape") {
    chart.setActiveElements([]);
    chart.tooltip.setActiveElements([], { x: 0, y: 0 });
    chart.update("none");
  } else return;
  event.preventDefault();
}
