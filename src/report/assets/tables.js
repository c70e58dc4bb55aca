"use strict";
/* Tables: of entries, and logs that are sorted by a click. */

/* A cell of a table; in columns of numbers these stand to the right. */
function cell(value, numbers) {
  const text = typeof value === "number" ? digits(value, 6) : value === null ? "" : String(value);
  return make("td", { class: numbers ? "number" : null }, text);
}

/* Whether column `i` of rows holds numbers only. */
function numeric(rows, i) {
  return rows.every((row) => typeof row[i] === "number" || row[i] === null) && rows.some((row) => row[i] !== null);
}

/* A table with a head and rows of values or elements. */
function table(head, rows, caption) {
  const right = head.map((_, i) => numeric(rows, i));
  return make("div", { class: "scroll" }, make("table", {},
    caption ? make("caption", { class: "quiet small" }, caption) : null,
    make("thead", {}, make("tr", {}, head.map((text, i) => make("th", { scope: "col", class: right[i] ? "number" : null }, text)))),
    make("tbody", {}, rows.map((row) => make("tr", {}, row.map((value, i) => {
      if (value instanceof Node) return make("td", {}, value);
      return i === 0 ? make("th", { scope: "row" }, String(value)) : cell(value, right[i]);
    }))))));
}

/* Rows of a log that are shown at first, and that each click on the button adds. */
const STEP = 100;

/* Order of two cells; empty ones come last whatever the direction. */
function order(a, b, direction) {
  if (a === null || b === null) return (a === null) - (b === null);
  const difference = typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
  return direction * difference;
}

/* A log: sorted by the column whose head is clicked, up and then down. */
function log(content) {
  let shown = STEP;
  let by = 0;
  let direction = 1;
  const rows = content.rows.slice();
  const body = make("tbody");
  const said = make("p", { class: "quiet small", "aria-live": "polite" });
  const more = make("button", { type: "button", click: () => { shown += 10 * STEP; draw(); } }, "more rows");
  const right = content.columns.map((_, i) => numeric(rows, i));
  const heads = content.columns.map((column, i) => {
    const unit = column.unit && column.unit !== "-" ? ` (${column.unit})` : "";
    const button = make("button", { type: "button", title: column.what || null, click: () => sort(i) }, column.name, make("span", { "aria-hidden": "true" }));
    return make("th", { scope: "col", class: right[i] ? "number" : null, "aria-sort": "none", title: column.what + unit }, button);
  });
  function sort(i) {
    direction = by === i ? -direction : 1;
    by = i;
    rows.sort((a, b) => order(a[i], b[i], direction));
    draw();
  }
  function draw() {
    heads.forEach((head, i) => {
      head.setAttribute("aria-sort", i !== by ? "none" : direction > 0 ? "ascending" : "descending");
      head.querySelector("span").textContent = i !== by ? "" : direction > 0 ? " ▲" : " ▼";
    });
    body.replaceChildren(...rows.slice(0, shown).map((row) => make("tr", {}, row.map((value, i) => cell(value, right[i])))));
    const count = Math.min(shown, rows.length);
    said.textContent = `${count} of ${rows.length} rows, sorted by ${content.columns[by].name}`;
    more.hidden = count >= rows.length;
  }
  draw();
  return make("div", { class: "log" },
    said,
    make("div", { class: "scroll tall", tabindex: "0", role: "region", "aria-label": content.title },
      make("table", {}, make("thead", {}, make("tr", {}, heads)), body)),
    make("div", { class: "row" }, more));
}
