// The live page: sliders send what is asked for, one request at a time; the robot comes back as it really stands.
"use strict";

const byId = (id) => document.getElementById(id);
const stage = new Stage(byId("scene"));
const state = { tab: 0, session: null, number: 0, inFlight: null, wanted: null, socket: null, held: null, last: null };
const ANSWER_SECONDS = 20;
const MANY = 12; // passive coordinates: more are folded up at first
const handle = new ToolHandle(stage, (point) => ask({ move: "drag", point }));
window.cutjoint = { stage, state, handle };

// Angles are shown in degrees, and sent in radians.
const shown = (value, unit) => (unit === "rad" ? value * 180 / Math.PI : value);
const sent = (value, unit) => (unit === "rad" ? value * Math.PI / 180 : value);
const unitText = (unit) => (unit === "rad" ? "°" : unit);
// Lengths have four decimals for a robot of a metre, more for a smaller one.
const decimals = (unit) => (unit === "rad" ? 2 : Math.min(Math.max(4 + Math.round(Math.log10(stage.node("robot").scale.x / 2)), 0), 12));

// ---- trail of the tool

const TRAIL = 2000;
const trail = (() => {
  const geometry = new MeshCat.THREE.BufferGeometry();
  geometry.setAttribute("position", new MeshCat.THREE.BufferAttribute(new Float32Array(3 * TRAIL), 3));
  geometry.setDrawRange(0, 0);
  const line = new MeshCat.THREE.Line(geometry, new MeshCat.THREE.LineBasicMaterial({ color: 0xd55e00 }));
  line.frustumCulled = false;
  line.visible = false;
  return { line, count: 0 };
})();

function extendTrail(point) {
  const positions = trail.line.geometry.attributes.position;
  if (trail.count) {
    const i = trail.count - 1;
    const near = 1e-6 / stage.node("robot").scale.x; // of the robot's size
    if (point.every((value, axis) => Math.abs(value - positions.array[3 * i + axis]) < near)) return;
  }
  if (trail.count === TRAIL) {
    positions.array.copyWithin(0, 3);
    trail.count -= 1;
  }
  positions.array.set(point, 3 * trail.count);
  trail.count += 1;
  positions.needsUpdate = true;
  trail.line.geometry.setDrawRange(0, trail.count);
}

// ---- messages

function say(kind, text) {
  byId("message").className = kind;
  byId("message").textContent = text;
}

function send() {
  if (state.inFlight || !state.wanted || !state.socket || state.socket.readyState !== WebSocket.OPEN) return;
  state.number += 1;
  const number = state.number;
  state.inFlight = number;
  state.socket.send(JSON.stringify({ ...state.wanted, number }));
  state.wanted = null;
  setTimeout(() => {
    if (state.inFlight !== number) return;
    state.inFlight = null;
    say("trouble", `No answer within ${ANSWER_SECONDS} s.`);
    send();
  }, 1000 * ANSWER_SECONDS);
}

function ask(message) {
  state.wanted = message;
  send();
}

function connect(delay) {
  const socket = new WebSocket(`ws://${location.host}/scene`);
  socket.binaryType = "arraybuffer";
  state.socket = socket;
  let opened = false;
  socket.onmessage = ({ data }) => {
    opened = true;
    if (typeof data !== "string") stage.take(data);
    else receive(JSON.parse(data));
  };
  socket.onclose = () => {
    state.inFlight = null;
    say("trouble", "The connection is lost. Is the program still running? Trying again…");
    const next = opened ? 1 : Math.min(2 * delay, 10);
    setTimeout(() => connect(next), 1000 * next);
  };
}

function receive(message) {
  if (message.type === "hello") {
    if (state.session && state.session !== message.session) {
      location.reload(); // another program answers here now
      return;
    }
    state.session = message.session;
    state.tab = message.tab;
    stage.node("robot").add(trail.line);
    say("", "");
  } else if (message.type === "controls") {
    build(message);
  } else if (message.type === "state") {
    update(message);
  }
}

// ---- panel

const sliders = { actuated: [], tool: [] };

const DRAGGED = "Or drag the ball at the tool in the picture.";

function build(controls) {
  document.title = `${controls.title} · cutjoint`;
  byId("title").textContent = controls.title;
  byId("source").textContent = controls.source;
  byId("source-section").hidden = !controls.source;
  for (const kind of ["actuated", "tool"]) {
    if (sliders[kind].length !== controls[kind].length) {
      sliders[kind] = controls[kind].map((spec) => makeSlider(kind, spec));
      byId(kind).replaceChildren(...sliders[kind].map((slider) => slider.box));
    }
    controls[kind].forEach((spec, index) => {
      const { range, number } = sliders[kind][index], value = number.value;
      for (const input of [range, number]) {
        input.min = shown(spec.lower, spec.unit);
        input.max = shown(spec.upper, spec.unit);
      }
      if (value !== "") range.value = value;
    });
  }
  byId("note").textContent = controls.note;
  byId("tool-note").textContent = [controls.tool_axes, controls.draggable ? DRAGGED : ""].filter((one) => one).join(" ");
  if (controls.draggable) handle.attach();
  if (!state.controls) byId("passive-section").open = controls.passive.length <= MANY;
  byId("passive-section").hidden = controls.passive.length === 0;
  byId("passive-section").firstElementChild.textContent = `Passive joints (${controls.passive.length})`;
  byId("actuated-section").hidden = controls.actuated.length === 0;
  byId("tool-section").hidden = controls.tool.length === 0 && !controls.draggable;
  byId("mode").replaceChildren(...controls.modes.map((name, index) => new Option(name, index)));
  state.controls = controls;
  const own = [{ title: "Tool trail", shown: false }, { title: "Names", shown: false }];
  fillToggles(byId("toggles"), [...controls.toggles, ...own], stage, (title, shown) => {
    if (title === "Names") return stage.setLabels(shown ? controls.labels : []);
    trail.line.visible = shown;
    if (!shown) { trail.count = 0; trail.line.geometry.setDrawRange(0, 0); }
    return stage.viewer.set_dirty();
  });
  if (state.last) update(state.last);
}

function makeSlider(kind, spec) {
  const { index, unit: own } = spec;
  const box = document.createElement("div"), name = document.createElement("label");
  const range = document.createElement("input"), number = document.createElement("input"), unit = document.createElement("span");
  box.className = "slider";
  name.className = "name";
  name.htmlFor = `${kind}-${index}`;
  if (spec.colour) name.append(swatch(spec.colour));
  name.append(spec.name);
  range.type = "range";
  range.id = `${kind}-${index}`;
  range.step = "any";
  number.type = "number";
  number.step = "any";
  number.setAttribute("aria-label", `${spec.name} [${unitText(own)}]`);
  unit.className = "unit";
  unit.textContent = unitText(own);
  const moved = (value) => {
    if (Number.isFinite(value)) ask({ move: kind, index, value: sent(value, own) });
  };
  range.addEventListener("input", () => { number.value = fixed(+range.value, decimals(own)); moved(+range.value); });
  range.addEventListener("pointerdown", () => { state.held = range; });
  number.addEventListener("change", () => moved(number.value === "" ? NaN : +number.value));
  box.append(name, range, number, unit);
  return { box, name, range, number, index, unit: own };
}

window.addEventListener("pointerup", () => {
  state.held = null;
  if (state.last) update(state.last);
});

function update(message) {
  state.last = message;
  const { answer } = message;
  if (answer && answer.tab === state.tab && answer.number === state.inFlight) {
    state.inFlight = null;
    byId("text").hidden = true; // what it said is no longer so
    byId("copied").textContent = "";
    if (answer.text) copy(answer.text);
    if (answer.trouble) say("trouble", answer.trouble);
    else if (message.stop) say(`stop ${message.stop.kind}`, message.stop.text);
    else say("", "");
  }
  const settled = !state.wanted && !state.inFlight;
  const atLimit = new Set(message.at_limit), { controls } = state;
  for (const [kind, values] of [["actuated", message.q], ["tool", message.coordinates]]) {
    sliders[kind].forEach(({ name, range, number, index, unit }) => {
      if (values[index] === undefined) return;
      const value = shown(values[index], unit);
      if (kind === "actuated" && controls) name.classList.toggle("at-limit", atLimit.has(controls.actuated[index].name));
      const own = range === state.held || document.activeElement === number;
      if (own && !(settled && message.stop) && !(settled && range !== state.held)) return;
      range.value = value;
      number.value = fixed(value, decimals(unit));
    });
  }
  fillTable(byId("passive"), (controls ? controls.passive : []).map(({ name, joint, unit }, i) => {
    const value = fixed(shown(message.passive[i], unit), decimals(unit));
    return [name, `${value} ${unitText(unit)}`, null, atLimit.has(joint) ? "at-limit" : ""];
  }));
  byId("mode").value = message.mode;
  const pointHasSliders = sliders.tool.filter(({ index }) => index < 3).length === 3 && !(controls && controls.tool_axes);
  const efforts = (message.effort || []).map((effort, i) => {
    const spec = controls ? controls.actuated[i] : { name: "", colour: "" };
    return [`${spec.name} holds`, `${figure(effort)} ${message.effort_units[i]}`, spec.colour];
  });
  fillTable(byId("figures"), [
    ...(message.tool && !pointHasSliders ? [["Tool", `${message.tool.map((x) => fixed(x, decimals("m"))).join(", ")} m`]] : []),
    ["Loop gap", `${figure(message.gap[0])} m, ${figure(message.gap[1])} rad`],
    ["Mobility", `${message.mobility} (rank ${message.rank} of ${message.rows} rows)`],
    ["Condition number", figure(message.condition)],
    ["Distance to type-1 singularity", figure(message.type1)],
    ["Distance to type-2 singularity", figure(message.type2)],
    ...(efforts.length ? efforts : [["Effort against gravity", "not defined"]]),
  ]);
  if (message.tool) extendTrail(message.tool);
  stage.viewer.set_dirty();
  document.documentElement.dataset.ready = "yes";
  send();
}

function copy(text) {
  const box = byId("text");
  box.value = text;
  box.hidden = false;
  box.select();
  const done = (words) => { byId("copied").textContent = words; };
  done("Copy it from here:");
  if (navigator.clipboard) navigator.clipboard.writeText(text).then(() => done("Copied."), () => {}); // not over --host
}

for (const move of ["toml", "python"]) byId(move).addEventListener("click", () => ask({ move }));
byId("mode").addEventListener("change", () => ask({ move: "mode", index: +byId("mode").value }));
byId("home").addEventListener("click", () => ask({ move: "home" }));
byId("modes").addEventListener("click", () => { say("busy", "Searching the working modes…"); ask({ move: "modes" }); });
connect(1);
