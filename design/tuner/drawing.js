// How the tuner draws: SVG elements, axes, the two plots, the map of the gains and the two tables, each from the
// records that Python sends.  `tuner.js` follows in the same module.

// --- elements ---------------------------------------------------------------------------------------------

function node(kind, attributes = {}, ...children) {
  const found = kind.startsWith("svg:")
    ? document.createElementNS("http://www.w3.org/2000/svg", kind.slice(4))
    : document.createElement(kind);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== false) found.setAttribute(name, value === true ? "" : value);
  }
  found.append(...children);
  return found;
}

const text = (x, y, words, attributes = {}) => node("svg:text", { x, y, ...attributes }, words);
const path = (points) => "M" + points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
const linear = (low, high, from, to) => (v) => from + ((v - low) / (high - low)) * (to - from);
const logarithmic = (low, high, from, to) => {
  const inside = linear(Math.log(low), Math.log(high), from, to);
  return (v) => inside(Math.log(v));
};
const range = (low, high, step) =>
  Array.from({ length: Math.floor((high - low) / step + 1e-9) + 1 }, (_, i) => low + i * step);
const shown = (value) => Number(value.toPrecision(3));

// The distance of ticks, 1, 2, 3 or 5 of a power of ten, of which no more than seven go into a span.
function spacing(span) {
  const power = 10 ** Math.floor(Math.log10(span / 7));
  return power * [1, 2, 3, 5, 10].find((v) => span / 7 <= v * power * (1 + 1e-9));
}

function decades(low, high) {
  const ticks = [];
  for (let power = 10 ** Math.floor(Math.log10(low)); power <= high; power *= 10) {
    ticks.push(...[1, 2, 5].map((v) => v * power).filter((v) => v >= low * 0.999 && v <= high * 1.001));
  }
  return ticks;
}

// Axes with grid, ticks and labels, and a clipped layer to draw in; x and y: {at, ticks, label}.
let clips = 0;
function axes(svg, box, x, y) {
  const { left, top, right, bottom } = box;
  const grid = node("svg:g", { class: "grid" });
  for (const v of x.ticks) {
    grid.append(node("svg:line", { x1: x.at(v), x2: x.at(v), y1: top, y2: bottom }));
    grid.append(text(x.at(v), bottom + 14, shown(v), { "text-anchor": "middle" }));
  }
  for (const v of y.ticks) {
    grid.append(node("svg:line", { x1: left, x2: right, y1: y.at(v), y2: y.at(v) }));
    grid.append(text(left - 6, y.at(v) + 3.5, shown(v), { "text-anchor": "end" }));
  }
  const middle = (top + bottom) / 2;
  grid.append(text((left + right) / 2, bottom + 30, x.label, { class: "label", "text-anchor": "middle" }));
  grid.append(
    text(12, middle, y.label, { class: "label", "text-anchor": "middle", transform: `rotate(-90 12 ${middle})` }),
  );
  const id = `wrist-tuner-clip-${(clips += 1)}`;
  const frame = { x: left, y: top, width: right - left, height: bottom - top };
  const layer = node("svg:g", { "clip-path": `url(#${id})` });
  svg.append(node("svg:clipPath", { id }, node("svg:rect", frame)), grid, layer);
  return layer;
}

// --- plots ------------------------------------------------------------------------------------------------

function legend(entries) {
  const list = node("ul", { class: "legend" });
  for (const [mark, words] of entries) {
    const sample = node("svg:svg", { width: 26, height: 12, "aria-hidden": "true" });
    sample.append(mark);
    const memory = mark.dataset.memory;
    const item = node("li", memory ? { tabindex: 0, "data-memory": memory } : {}, sample, words);
    list.append(item);
  }
  return list;
}

const stroke = (kind) => node("svg:path", { class: kind, d: "M1 6L25 6" });

function drawSteps(svg, width, about, picture, seconds) {
  const { step, time_s: time, overshoot_percent: allowed } = about;
  const highest = Math.min(Math.max(step * 1.15, ...picture.series.map((s) => Math.max(...s.way) * 1.03)), 3 * step);
  const tick = spacing(highest);
  const top = Math.ceil(highest / tick - 1e-9) * tick;
  const box = { left: 46, top: 8, right: width - 8, bottom: 262 };
  const x = { at: linear(0, seconds, box.left, box.right), ticks: range(0, seconds, seconds / (seconds < about.duration_s ? 5 : 10)), label: "Time [s]" };
  const y = { at: linear(-step / 15, top, box.bottom, box.top), ticks: range(0, top, tick), label: `Way towards the reference [${about.units.angle}]` };
  svg.setAttribute("height", 298);
  const layer = axes(svg, box, x, y);
  layer.append(node("svg:line", { class: "reference", x1: box.left, x2: box.right, y1: y.at(step), y2: y.at(step) }));
  for (const s of picture.series) layer.append(curve(s, s.way, time, x, y, "response"));
  if (allowed !== null) {
    const broken = picture.limits.some((row) => row.name === "overshoot_percent" && row.broken);
    const level = y.at(step * (1 + allowed / 100));
    layer.append(node("svg:line", { class: `bound${broken ? " violated" : ""}`, x1: box.left, x2: box.right, y1: level, y2: level }));
    layer.append(text(box.right - 4, level - 4, `${broken ? "▲ " : ""}overshoot limit ${allowed} %`, { class: broken ? "violated" : "quiet", "text-anchor": "end" }));
  }
}

function drawCommand(svg, width, about, picture, seconds) {
  const [low, high] = about.command;
  const room = (high - low) / 40;
  const box = { left: 46, top: 6, right: width - 8, bottom: 92 };
  const x = { at: linear(0, seconds, box.left, box.right), ticks: range(0, seconds, seconds / (seconds < about.duration_s ? 5 : 10)), label: "Time [s]" };
  const y = { at: linear(low - room, high + room, box.bottom, box.top), ticks: range(low, high, spacing(high - low)), label: `Command [${about.units.command}]` };
  svg.setAttribute("height", 128);
  const layer = axes(svg, box, x, y);
  for (const s of picture.series) layer.append(curve(s, s.command, about.time_s, x, y, "command"));
}

function curve(s, values, time, x, y, kind) {
  const d = path(values.map((v, i) => [x.at(time[i]), y.at(v)]));
  return node("svg:path", { class: `${kind} ${s.memory}${s.plus ? "" : " minus"}`, "data-memory": s.memory, d });
}

function drawMap(svg, width, about, regions, picture, at) {
  const height = Math.min(width, 390);
  const box = { left: 46, top: 8, right: width - 8, bottom: height - 36 };
  const { pressure, angle } = about.units;
  const x = { at: logarithmic(...about.Kp, box.left, box.right), ticks: decades(...about.Kp), label: `Kp [${pressure}/${angle}]` };
  const y = { at: logarithmic(...about.Ki, box.bottom, box.top), ticks: decades(...about.Ki), label: `Ki [${pressure}/(${angle} s)]` };
  svg.setAttribute("height", height);
  const layer = axes(svg, box, x, y);
  const place = ([u, v]) => [box.left + u * (box.right - box.left), box.bottom + v * (box.top - box.bottom)];
  svg.classList.toggle("behind", regions.behind);
  const rings = regions.held.map((ring) => path(ring.map(place)) + "Z").join("");
  layer.prepend(node("svg:path", { class: "held", d: rings, "fill-rule": "evenodd" }));
  const broken = new Set(picture.limits.filter((row) => row.broken).map((row) => row.name));
  for (const [name, lines] of Object.entries(regions.limits)) {
    const d = lines.map((line) => path(line.map(place))).join("");
    layer.append(node("svg:path", { class: `limit ${name}${broken.has(name) ? " violated" : ""}`, d }));
  }
  if (regions.best) layer.append(star(x.at(regions.best[0]), y.at(regions.best[1])));
  const bad = broken.size > 0 || picture.trouble;
  const [cx, cy] = [x.at(at.Kp), y.at(at.Ki)];
  layer.append(node("svg:path", { class: "cross", d: `M${box.left} ${cy}H${box.right}M${cx} ${box.top}V${box.bottom}` }));
  layer.append(node("svg:circle", { class: `point${bad ? " violated" : ""}`, cx, cy, r: 7 }));
  if (bad) layer.append(node("svg:path", { class: "mark", d: `M${cx - 3} ${cy - 3}l6 6m0 -6l-6 6` }));
  svg.gains = (px, py) => {
    const [u, v] = [(px - box.left) / (box.right - box.left), (py - box.bottom) / (box.top - box.bottom)];
    const along = ([low, high], t) => shown(low * (high / low) ** Math.min(Math.max(t, 0), 1));
    return { Kp: along(about.Kp, u), Ki: along(about.Ki, v) };
  };
}

function star(x, y) {
  const points = range(0, 9, 1).map((i) => {
    const [r, a] = [i % 2 ? 3.2 : 8, (i * Math.PI) / 5];
    return [x + r * Math.sin(a), y - r * Math.cos(a)];
  });
  return node("svg:path", { class: "best", d: path(points) + "Z" });
}

// --- tables -----------------------------------------------------------------------------------------------

function table(caption, headings, rows) {
  const head = node("tr", {}, ...headings.map((h) => node("th", { scope: "col" }, h)));
  const body = rows.map(([first, ...cells]) =>
    node("tr", {}, node("th", { scope: "row" }, first), ...cells.map(([words, broken]) =>
      node("td", { class: broken ? "violated" : null }, broken ? `▲ ${words}` : words))));
  return node("table", {}, node("caption", {}, caption), node("thead", {}, head), node("tbody", {}, ...body));
}

function tables(picture) {
  const limits = picture.limits.map((row) => [
    row.label, [row.value, row.broken], [row.limit, false],
    [row.limit === "none" ? "–" : row.broken ? "violated" : "✓ held", false], [row.place, false],
  ]);
  const margins = picture.margins.map((row) => [row.branch, ...row.cells.map((c) => [c.text, c.broken])]);
  const quick = `Worst settling time ${picture.settling}, worst IAE ${picture.iae}`;
  return [
    table(`Limits. ${quick}`, ["Quantity", "Worst", "Limit", "", "Where"], limits),
    table("Margins of the linear loop", ["Branch, rate", "Ms", "Delay margin", "Phase margin", "Gain margin"], margins),
  ];
}
