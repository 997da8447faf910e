// Figures that answer. The pointer over a curve names and reads it; a label switches its curve off and on;
// from a label that has the focus, the arrow keys read along its curve. Without this script nothing is lost
// but that. `reports/shared/figures/curves.py` writes the attributes that are read here.
(() => {
  const NEAR = 14; // how far from a curve the pointer may be [px]
  const STEPS = 50; // readings along a curve by keys
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.setAttribute("role", "status");
  document.body.append(tip);

  const inside = (panel, x, y) => [x, y].every((v, i) => (v - panel[i].from) * (v - panel[i].to) <= 0.01);

  function read({from, to, low, high, log, label}, at) {
    const share = (at - from) / (to - from);
    let value = log ? low * (high / low) ** share : low + share * (high - low);
    if (!log && Math.abs(value) < 5e-4 * Math.abs(high - low)) value = 0;
    const [, words, unit] = label.replace(/\s+/g, " ").match(/^(.*?)(?: \[(.*)\])?$/);
    return `${words} ${Number(value.toPrecision(3))}${unit && unit !== "1" ? " " + unit : ""}`.trim();
  }

  function points(curve) { // [starts anew, x, y], of lines and of markers
    if (curve.points) return curve.points;
    const found = [];
    for (const drawn of curve.querySelectorAll("path, use")) {
      if (drawn.closest("defs")) continue;
      if (drawn.tagName === "use") found.push([true, +drawn.getAttribute("x"), +drawn.getAttribute("y")]);
      else for (const [, pen, x, y] of drawn.getAttribute("d").matchAll(/([ML])\s*(\S+)\s+([-\d.]+)/g))
        found.push([pen === "M", +x, +y]);
    }
    return curve.points = found;
  }

  function nearest(curve, x, y) { // [distance, x, y] of the point of a curve that is nearest
    let best = [Infinity], ax, ay;
    for (const [anew, px, py] of points(curve)) {
      const dx = anew ? 0 : px - ax, dy = anew ? 0 : py - ay;
      const rest = ((px - x) * dx + (py - y) * dy) / (dx * dx + dy * dy || 1);
      const back = Math.min(1, Math.max(0, rest)), qx = px - back * dx, qy = py - back * dy;
      const far = Math.hypot(qx - x, qy - y);
      if (far < best[0]) best = [far, qx, qy];
      [ax, ay] = [px, py];
    }
    return best;
  }

  function show(svg, curve, x, y) {
    hide();
    const panel = svg.panels[curve.dataset.panel];
    curve.classList.add("on");
    tip.textContent = `${curve.dataset.curve}: ${read(panel[0], x)}, ${read(panel[1], y)}`;
    const place = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
    tip.style.display = "block";
    tip.style.left = `${Math.max(4, Math.min(place.x + 12, innerWidth - tip.offsetWidth - 6))}px`;
    tip.style.top = `${Math.max(4, place.y - tip.offsetHeight - 10)}px`;
  }

  function hide() {
    tip.style.display = "none";
    document.querySelectorAll(".on").forEach(curve => curve.classList.remove("on"));
  }

  function point(svg, event) {
    const screen = svg.getScreenCTM(), at = new DOMPoint(event.clientX, event.clientY);
    const {x, y} = at.matrixTransform(screen.inverse());
    const found = svg.curves
      .filter(c => !c.classList.contains("off") && inside(svg.panels[c.dataset.panel], x, y))
      .map(c => [nearest(c, x, y), c])
      .filter(([[far, px, py], c]) => far * screen.a < NEAR && inside(svg.panels[c.dataset.panel], px, py))
      .sort((a, b) => a[0][0] - b[0][0])[0];
    if (found) show(svg, found[1], found[0][1], found[0][2]); else hide();
  }

  function toggle(svg, name) {
    for (const e of [...svg.all, ...svg.labels]) {
      if ((e.dataset.curve ?? e.dataset.of) !== name) continue;
      const off = e.classList.toggle("off");
      if (e.dataset.of && e.hasAttribute("tabindex")) e.setAttribute("aria-pressed", String(!off));
    }
    hide();
  }

  function key(svg, label, event) {
    const name = label.dataset.of, curve = svg.curves.find(c => c.dataset.curve === name);
    if (event.key === "Enter" || event.key === " ") toggle(svg, name);
    else if (event.key === "Escape") hide();
    else if (curve && /^Arrow(Left|Right)$/.test(event.key)) {
      const [{from, to}] = svg.panels[curve.dataset.panel], along = points(curve).map(p => p[1]);
      const start = Math.max(from, Math.min(...along)), end = Math.min(to, Math.max(...along));
      label.step = Math.min(STEPS, Math.max(0, (label.step ?? -1) + (event.key === "ArrowRight" ? 1 : -1)));
      const x = start + label.step / STEPS * (end - start);
      show(svg, curve, x, height(curve, x));
    } else return;
    event.preventDefault();
  }

  function height(curve, x) { // of a curve over x
    let ax, ay;
    for (const [anew, px, py] of points(curve)) {
      if (px === x || (!anew && (ax - x) * (px - x) < 0)) return px === x ? py : ay + (py - ay) * (x - ax) / (px - ax);
      [ax, ay] = [px, py];
    }
    return ay;
  }

  for (const svg of document.querySelectorAll("svg[data-panels]")) {
    svg.panels = JSON.parse(svg.dataset.panels);
    svg.all = [...svg.querySelectorAll("[data-curve]")];
    svg.curves = svg.all.filter(c => c.dataset.panel);
    svg.labels = [...svg.querySelectorAll("[data-of]")];
    svg.setAttribute("role", "group"); // an image hides the buttons within it from who hears the page
    svg.addEventListener("pointermove", event => point(svg, event));
    svg.addEventListener("pointerleave", hide);
    for (const label of svg.labels) {
      label.addEventListener("click", () => toggle(svg, label.dataset.of));
      if (!label.querySelector("text")) continue;
      for (const [name, value] of Object.entries(
        {tabindex: 0, role: "button", "aria-pressed": "true", "aria-label": label.dataset.of}
      )) label.setAttribute(name, value);
      label.addEventListener("keydown", event => key(svg, label, event));
      label.addEventListener("blur", hide);
    }
  }
})();
