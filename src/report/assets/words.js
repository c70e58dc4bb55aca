"use strict";
/* Elements, numbers and labels. `report` is what the scripts of the page share; tests of the page read it. */
const report = {
  data: JSON.parse(document.getElementById("data").textContent),
  charts: [],
  errors: [],
  ready: false,
};
window.report = report;
window.addEventListener("error", (event) => report.errors.push(String(event.message)));
window.addEventListener("unhandledrejection", (event) => report.errors.push(String(event.reason)));

/* An element: tag, attributes (functions listen), children (texts or elements; null is left out). */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key, value);
    else if (value !== null && value !== undefined) element.setAttribute(key, value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
}

/* A label such as σ_{v} with its sub- and superscripts. */
function marked(text) {
  return text.split(/([_^]\{[^}]*\})/).filter((part) => part !== "").map((part) => {
    const script = part.match(/^([_^])\{([^}]*)\}$/);
    return script ? make(script[1] === "_" ? "sub" : "sup", {}, script[2]) : part;
  });
}

/* The same label as plain text. */
function plain(text) {
  return text.replace(/[_^]\{([^}]*)\}/g, "$1");
}

/* A label without its unit in brackets at the end, and that unit. */
function quantity(label) {
  const found = label.match(/^(.*?)\s*\(([^()]*)\)\s*$/);
  return found ? [found[1], found[2] === "–" ? "" : found[2]] : [label, ""];
}

const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/* A number with so many significant digits, powers of ten written as such. */
function digits(x, count = 4) {
  if (x === null || x === undefined || Number.isNaN(x)) return "–";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (Number.isInteger(x) && size < 1e7) return String(x).replace("-", "−");
  if (size >= 1e6 || size < 1e-4) {
    const [head, power] = x.toExponential(count - 1).split("e");
    const raised = String(Number(power)).split("").map((c) => SUPERSCRIPTS[c]).join("");
    const front = String(Number(head)).replace("-", "−");
    return front === "1" ? `10${raised}` : `${front}·10${raised}`;
  }
  return String(Number(x.toPrecision(count))).replace("-", "−");
}

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"]];

/* Factor and unit in which a quantity of this size is read well. */
function scaled(unit, size) {
  const known = { Pa: PREFIXES, N: PREFIXES, m: PREFIXES, "m/s": [[1, ""], [1e-3, "m"], [1e-6, "µ"]] }[unit];
  if (!known || !(size > 0)) return [1, unit];
  const [factor, prefix] = known.find(([factor]) => size >= factor) || known[known.length - 1];
  return [1 / factor, prefix + unit];
}

/* A colour variable of the page. */
function tone(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function channels(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

function luminance(colour) {
  const [r, g, b] = channels(colour).map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/* The colour, lightened or darkened until it stands out from the panels of the page (contrast 3:1, as WCAG asks of graphics). */
function readable(colour) {
  const ground = luminance(tone("--panel"));
  const towards = ground < 0.2 ? 255 : 0;
  let seen = colour;
  for (let share = 0; share <= 1; share += 0.1) {
    seen = "#" + channels(colour).map((c) => Math.round(c + (towards - c) * share).toString(16).padStart(2, "0")).join("");
    const [light, dark] = [Math.max(luminance(seen), ground), Math.min(luminance(seen), ground)];
    if ((light + 0.05) / (dark + 0.05) >= 3) break;
  }
  return seen;
}

/* Calls `redraw` when the colours of the page change: by the system, for print and back. */
function onColours(redraw) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  matchMedia("print").addEventListener("change", redraw);
}
