// A map of gains that answers: a click on a cell, or the arrow keys on the map, show the cell's step and what its
// limits are held against. Without this script the map is a map. `reports/shared/cells.py` writes the data.
(() => {
  const SVG = "http://www.w3.org/2000/svg", WIDE = 320, HIGH = 190, [LEFT, RIGHT, TOP, FOOT] = [40, 298, 12, 152];

  function element(name, attributes = {}, text = "") {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.textContent = text;
    return made;
  }

  function step(data, cell) { // a picture of the step under the gains of a cell
    const end = data.time.at(-1), top = 1.6 * data.reference, low = -0.1 * data.reference;
    const x = t => LEFT + t / end * (RIGHT - LEFT);
    const y = v => FOOT - (Math.min(top, Math.max(low, v)) - low) / (top - low) * (FOOT - TOP);
    const found = element("svg", {viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img", "aria-label": "Step under these gains"});
    for (const v of [0, data.reference]) {
      found.append(element("line", {x1: LEFT, x2: RIGHT, y1: y(v), y2: y(v), class: "rule"}));
      found.append(element("text", {x: LEFT - 5, y: y(v) + 4, "text-anchor": "end"}, String(v / data.per)));
    }
    for (let t = 0; t <= end + 0.1; t++) found.append(element("text", {x: x(t), y: FOOT + 15, "text-anchor": "middle"}, `${t} s`));
    found.append(element("text", {x: LEFT, y: TOP - 2}, data.angle));
    data.steps.forEach(([words, angles], i) => {
      const points = angles[cell].map((v, k) => `${x(data.time[k]).toFixed(1)},${y(v).toFixed(1)}`).join(" ");
      found.append(element("polyline", {points, class: `way way${i}`}));
      const at = LEFT + i * 115;
      found.append(element("line", {x1: at, x2: at + 18, y1: FOOT + 26, y2: FOOT + 26, class: `way way${i}`}));
      found.append(element("text", {x: at + 22, y: FOOT + 30}, words));
    });
    return found;
  }

  function table(data, cell) {
    const found = document.createElement("table");
    for (const [name, unit, values] of data.rows) {
      const row = found.insertRow();
      row.insertCell().textContent = name + (unit ? ` [${unit}]` : "");
      Object.assign(row.insertCell(), {className: "number", textContent: values[cell]});
    }
    return found;
  }

  for (const script of document.querySelectorAll("script.cells")) {
    const data = JSON.parse(script.textContent), svg = script.parentElement.querySelector("svg[data-panels]");
    const panel = JSON.parse(svg.dataset.panels)[0], count = data.gains.map(axis => axis.length);
    const place = (axis, n) => panel[axis].from + n / (count[axis] - 1) * (panel[axis].to - panel[axis].from);
    const size = axis => Math.abs(place(axis, 1) - place(axis, 0));
    const mark = element("rect", {width: size(0), height: size(1), class: "cell-mark"}), box = document.createElement("div");
    let at = data.at;
    box.className = "cell";
    box.setAttribute("role", "status");
    svg.append(mark);
    script.after(box);

    function show(chosen) {
      at = chosen.map((n, axis) => Math.max(0, Math.min(count[axis] - 1, n)));
      const cell = at[0] * count[1] + at[1], words = document.createElement("p"), [Kp, Ki] = data.gains.map((axis, i) => axis[at[i]]);
      mark.setAttribute("x", place(0, at[0]) - size(0) / 2);
      mark.setAttribute("y", place(1, at[1]) - size(1) / 2);
      words.textContent = `Cell of Kp ${Kp} ${data.units[0]}, Ki ${Ki} ${data.units[1]}. Click another, or use the arrow keys on the map.`;
      box.replaceChildren(words, step(data, cell), table(data, cell));
    }

    svg.addEventListener("click", event => {
      const {x, y} = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const near = [x, y].map((v, axis) => (v - place(axis, 0)) / (place(axis, 1) - place(axis, 0)));
      if (near.every((n, axis) => n > -0.6 && n < count[axis] - 0.4)) show(near.map(Math.round));
    });
    svg.tabIndex = 0;
    svg.addEventListener("keydown", event => {
      const way = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
      if (!way || event.target !== svg) return;
      event.preventDefault();
      show(at.map((n, axis) => n + way[axis]));
    });
    show(at);
  }
})();
