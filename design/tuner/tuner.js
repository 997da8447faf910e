// The tuner in the browser: sliders in, pictures out.  It computes nothing of the wrist: what is drawn comes from
// Python in the traits `picture` and `regions`.  `drawing.js` comes before, in the same module.

const MEMORIES = {
  virgin: "from rest (virgin)",
  line1: "from line 1",
  line2: "from line 2",
  inside: "from inside the loop",
  return: "back to 0",
};
const PATIENCE = 5000; // ms without an answer, as when the kernel is gone, before asking again

// --- controls ---------------------------------------------------------------------------------------------

function control(slider, id, change) {
  const { name, label, unit, per_unit, low, high, logarithmic: log } = slider;
  const step = per_unit === 1 ? 0.01 : 1;
  const position = log ? logarithmic(low, high, 0, 400) : (v) => v * per_unit;
  const value = log ? (p) => low * (high / low) ** (p / 400) : (p) => p / per_unit;
  const bar = node("input", {
    type: "range", id, "data-name": name, step: log ? 1 : step,
    min: log ? 0 : low * per_unit, max: log ? 400 : high * per_unit,
  });
  const field = node("input", {
    type: "number", step: log ? "any" : step, min: low * per_unit, max: high * per_unit,
    "aria-label": `${label} in ${unit === "×" ? "times that of the wrist" : unit}`,
  });
  const inside = (v) => Math.min(Math.max(v, low), high);
  const give = (v) => {
    show(v);
    change(name, v);
  };
  const show = (v) => {
    bar.value = position(v);
    field.value = Number((v * per_unit).toPrecision(4));
    bar.setAttribute("aria-valuetext", `${field.value} ${unit}`);
  };
  bar.addEventListener("input", () => give(inside(Number(value(Number(bar.value)).toPrecision(log ? 3 : 6)))));
  const typed = () => {
    const v = Number(field.value) / per_unit;
    give(inside(field.value !== "" && Number.isFinite(v) ? v : low));
  };
  field.addEventListener("change", typed);
  field.addEventListener("keydown", (event) => event.key === "Enter" && typed());
  const now = node("span", { class: "unit now" });
  const row = node(
    "div", { class: "slider" },
    node("label", { for: id, title: slider.meaning }, label), field, node("span", { class: "unit" }, unit), bar, now,
  );
  return { row, show, now };
}

// --- the widget -------------------------------------------------------------------------------------------

function render({ model, el }) {
  const about = model.get("about");
  const unique = `wrist-tuner-${Math.random().toString(36).slice(2, 8)}`;
  const root = node("div", { class: "wrist-tuner" });
  let seconds = about.duration_s / 2;

  // The newest wins: while Python computes, later positions replace each other, and the last is asked for.
  let wanted = {}, busy = false, patience = 0, rest = 0;
  let keeping; // name of the file for the gains, until Python has them
  const waiting = () => {
    const late = Object.keys(wanted).length || model.get("answered") !== model.get("asked");
    root.setAttribute("aria-busy", String(Boolean(late)));
    if (late || keeping === undefined) return;
    model.send({ keep: keeping });
    keeping = undefined;
  };
  const send = (values) => {
    busy = true;
    for (const [name, value] of Object.entries(values)) model.set(name, value);
    model.set("asked", model.get("asked") + 1);
    model.save_changes();
    waiting();
    patience = setTimeout(() => free(), PATIENCE);
  };
  const free = () => {
    clearTimeout(patience);
    busy = false;
    clearTimeout(rest);
    waiting();
    if (Object.keys(wanted).length) {
      const values = wanted;
      wanted = {};
      send(values);
    } else if (!model.get("regions").complete) {
      rest = setTimeout(() => busy || send({ sharpen: model.get("sharpen") + 1 }), 60);
    }
  };
  const ask = (values) => {
    Object.assign(wanted, values);
    waiting();
    if (!busy) free();
  };

  const status = node("p", { class: "status", role: "status", "aria-live": "polite" });
  const controls = about.sliders.map((s) => ({
    name: s.name, ...control(s, `${unique}-${s.name}`, (name, v) => {
      ask({ [name]: v });
      drawGains();
    }),
  }));
  const rows = (names) => controls.filter((c) => names.includes(c.name)).map((c) => c.row);
  const start = Object.fromEntries(about.sliders.map((s) => [s.name, model.get(s.name)]));
  const back = node("button", { type: "button" }, "Reset plant");
  back.addEventListener("click", () => {
    const values = { width: 1, lines: 1, transit: 1, dead_time: about.dead_time_s };
    for (const c of controls) if (c.name in values) c.show(values[c.name]);
    ask(values);
  });
  const name = node("input", { type: "text", id: `${unique}-file`, value: "gains.toml", spellcheck: "false" });
  const kept = node("output", { class: "kept", role: "status" });
  const keep = node(
    "form", { class: "keep" }, node("label", { for: `${unique}-file` }, "Keep as"), name, node("button", { type: "submit" }, "Keep gains"),
  );
  keep.addEventListener("submit", (event) => {
    event.preventDefault();
    keeping = name.value;
    waiting();
  });

  const steps = node("svg:svg", { class: "steps", role: "img" });
  const command = node("svg:svg", { class: "commands", role: "img", "aria-label": "Command over time, for the same steps" });
  const map = node("svg:svg", { class: "map", role: "img" });
  const windows = node("div", { class: "windows", role: "group", "aria-label": "Time shown" }, ...[5, 2, 1].map((part) => {
    const s = about.duration_s / part;
    const button = node("button", { type: "button", "aria-pressed": String(s === seconds) }, `${shown(s)} s`);
    button.addEventListener("click", () => {
      seconds = s;
      for (const b of windows.children) b.setAttribute("aria-pressed", String(b === button));
      draw();
    });
    return button;
  }));
  const listed = node("div", { class: "tables" });
  const memories = Object.entries(MEMORIES).map(([m, words]) => {
    const mark = stroke(`response ${m}`);
    mark.dataset.memory = m;
    return [mark, m === "return" ? `${words} ${about.units.angle}` : words];
  });
  for (const [event, over] of [["pointerover", true], ["pointerout", false], ["focusin", true], ["focusout", false]]) {
    root.addEventListener(event, ({ target }) => {
      const memory = target.closest("li[data-memory]")?.dataset.memory;
      if (memory && over) root.dataset.only = memory;
      else delete root.dataset.only;
    });
  }
  const limits = Object.entries(about.limits).map(([n, words]) => [stroke(`limit ${n}`), words.split(",")[0]]);
  root.append(node(
    "div", { class: "body" },
    node("header", {}, node("h3", {}, `PI tuner: ${about.title}`), status),
    node("section", { class: "controls", "aria-label": "Gains and plant" },
      node("h4", {}, "Gains"), ...rows(["Kp", "Ki"]),
      node("h4", {}, "Plant"), ...rows(["width", "lines", "transit", "dead_time"]), back, keep, kept),
    node("section", { class: "responses", "aria-label": "Step responses" },
      node("h4", {}, `Step of ${about.step} ${about.units.angle} from every starting memory`, windows), steps, command,
      legend([...memories, [stroke("response key"), "plus"], [stroke("response key minus"), "minus direction"]])),
    node("section", { class: "plane", "aria-label": "Map of the gains" },
      node("h4", {}, "Where the gains hold every limit"), map,
      legend([
        [node("svg:rect", { class: "held", x: 1, y: 1, width: 24, height: 10 }), "every limit held"], ...limits,
        [node("svg:circle", { class: "point", cx: 13, cy: 6, r: 5 }), "these gains (drag me)"],
        [star(13, 6.5), "least IAE on the map"],
      ])),
    listed,
  ));
  // The keys are theirs: JupyterLab's shortcuts would take the arrows from a slider.
  for (const e of root.querySelectorAll("input, button, [tabindex]")) e.setAttribute("data-lm-suppress-shortcuts", "true");
  el.append(root);

  const gains = () => ({ Kp: wanted.Kp ?? model.get("Kp"), Ki: wanted.Ki ?? model.get("Ki") });
  const drawGains = () => {
    if (!map.clientWidth) return;
    map.replaceChildren();
    drawMap(map, map.clientWidth, about, model.get("regions"), model.get("picture"), gains());
  };
  const draw = () => {
    if (!root.isConnected) return; // it has neither a size nor a theme before
    const picture = model.get("picture");
    root.dataset.theme = dark(root) ? "dark" : "light";
    root.classList.toggle("stale", Boolean(picture.trouble));
    const broken = picture.limits.filter((row) => row.broken).map((row) => row.label.split(",")[0]);
    const bad = picture.trouble || picture.note || broken.length;
    for (const c of controls) c.now.textContent = picture.plant[c.name] ?? "";
    status.className = `status${bad ? " violated" : ""}`;
    status.textContent = picture.trouble
      ? `▲ No such plant: ${picture.trouble}`
      : picture.note
        ? `▲ Out of reach: ${picture.note}`
        : broken.length ? `▲ Violated: ${broken.join(", ")}` : "✓ Every limit is held";
    drawGains();
    if (picture.trouble || !steps.clientWidth) return;
    for (const [svg, how] of [[steps, drawSteps], [command, drawCommand]]) {
      svg.replaceChildren();
      how(svg, svg.clientWidth, about, picture, seconds);
    }
    steps.setAttribute("aria-label", `Step responses; worst settling time ${picture.settling}. ${status.textContent}`);
    map.setAttribute("aria-label", `Map of the gains at Kp ${shown(gains().Kp)}, Ki ${shown(gains().Ki)}. ${status.textContent}`);
    listed.replaceChildren(...tables(picture));
  };
  const follow = () => {
    for (const c of controls) if (!(c.name in wanted) && !c.row.contains(document.activeElement)) c.show(model.get(c.name));
    draw();
  };

  const pull = (event) => {
    if (!event.buttons || !map.gains) return;
    event.preventDefault();
    const box = map.getBoundingClientRect();
    const to = map.gains(event.clientX - box.left, event.clientY - box.top);
    ask(to);
    for (const c of controls) if (c.name in to) c.show(to[c.name]);
    drawGains();
  };
  map.addEventListener("pointerdown", (event) => {
    map.setPointerCapture(event.pointerId);
    pull(event);
  });
  map.addEventListener("pointermove", pull);

  const told = () => {
    const said = model.get("kept");
    kept.className = `kept${said.done === false ? " violated" : ""}`;
    kept.replaceChildren(said.done === false ? `▲ ${said.words}` : said.words ?? "");
    if (said.command) kept.append(node("code", {}, said.command));
  };
  const events = { "change:picture": follow, "change:regions": drawGains, "change:answered": free, "change:kept": told };
  for (const [event, listener] of Object.entries(events)) model.on(event, listener);
  const sized = new ResizeObserver(draw);
  sized.observe(root);
  const themed = new MutationObserver(draw);
  themed.observe(document.body, { attributes: true });
  for (const c of controls) c.show(start[c.name]);
  follow();
  told();
  free();
  return () => {
    for (const [event, listener] of Object.entries(events)) model.off(event, listener);
    sized.disconnect();
    themed.disconnect();
    clearTimeout(patience);
    clearTimeout(rest);
  };
}

// Whether the page is dark: its text is light, whatever notebook this is.
function dark(element) {
  const [r, g, b] = getComputedStyle(element).color.match(/[\d.]+/g).map(Number);
  return 0.3 * r + 0.6 * g + 0.1 * b > 140;
}

export default { render };
