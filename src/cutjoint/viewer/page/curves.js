// Curves over time on canvases: a cursor that reads values off, and a stretch of time that is shown larger.
//
//   const curves = drawCurves(element, panels, { onSeek, height, compact })
//   curves.cursor(t)      moves the cursor to t [s]; null hides it
//   curves.show(from, to) shows that stretch of time; without arguments the whole
//   curves.redraw()       after the element was hidden or its size changed unseen
//   curves.remove()       empties the element and listens to nothing any more; drawing into it again does so too
//
// A panel is {title, unit, quantity, curves, time, bound, since}; a curve {name, values, time, dash, colour, low, high},
// where `time` is the panel's unless it is its own, `dash` and `colour` are numbers of the tables below, and `low` and
// `high` limits of this curve alone.  With `onSeek` a pointer that is pressed asks for times, else it marks the stretch
// to enlarge.  `compact` leaves out the buttons and shows legends in a line.
"use strict";

const drawCurves = (() => {

const LOOKS = {
  light: { ink: "#20242a", soft: "#5a6270", grid: "#e3e6ea", back: "#ffffff", mark: "rgba(0, 114, 178, .14)",
    colours: ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#222222", "#8A6D00"] },
  dark: { ink: "#e8eaed", soft: "#a5adb8", grid: "#363c45", back: "#16191d", mark: "rgba(86, 180, 233, .22)",
    colours: ["#4AA3DF", "#F2B134", "#3ECFA3", "#F07F3C", "#E7A3C8", "#9AD4FF", "#E8EAED", "#D8C25A"] },
};
const DASHES = [[], [7, 3], [2, 2.5], [9, 3, 2, 3], [14, 4], [4, 2, 1, 2, 1, 2]];
const STYLE = `
.curves-tools { display: flex; flex-wrap: wrap; gap: 6px 8px; align-items: center; margin: 0 0 10px; font-size: 13px; }
.curves-tools button, .curve-legend button { font: inherit; color: inherit; background: none; cursor: pointer; }
.curves-tools button { border: 1px solid currentColor; border-radius: 5px; padding: 2px 10px; opacity: .85; }
.curves-tools button:disabled { opacity: .35; cursor: default; }
.curves-tools span { opacity: .75; }
.curve { margin: 0 0 14px; min-width: 0; break-inside: avoid; }
.curve-title { font-size: 14px; font-weight: 600; margin: 0 0 2px; }
.curve canvas { display: block; width: 100%; touch-action: pan-y; outline-offset: 2px; cursor: crosshair; }
.curve-legend { display: flex; flex-wrap: wrap; gap: 1px 12px; margin: 3px 0 0; font-size: 12px; }
.curve-legend button { display: flex; align-items: center; gap: 5px; border: 0; padding: 1px 0; text-align: left; }
.curve-legend button[aria-pressed=false] { opacity: .4; text-decoration: line-through; }
.curve-legend span { opacity: .75; }
.curve-legend svg { flex: 0 0 26px; }
.curve-legend output { font-variant-numeric: tabular-nums; min-width: 4.6em; text-align: right; }
.curve-legend.many { max-height: 9em; overflow-y: auto; }
.curves-compact .curve-title { font-size: 12px; }
.curves-compact .curve-legend { font-size: 11px; }
@media (max-width: 760px), (max-height: 480px), (pointer: coarse) {
  .curves-tools button, .curve-legend button { min-height: 40px; min-width: 40px; }
}
@media print { .curves-tools { display: none; } }
`;
const FAR = 4; // limits that far beyond the values would press them flat
const removers = new WeakMap(); // of elements with curves

function drawCurves(element, panels, options = {}) {
  removers.get(element)?.();
  if (!document.getElementById("curve-style")) {
    const style = document.createElement("style");
    style.id = "curve-style";
    style.textContent = STYLE;
    document.head.append(style);
  }
  const times = panels.flatMap((panel) => panel.curves.map((one) => one.time || panel.time));
  const whole = [Math.min(...times.map((one) => one[0])), Math.max(...times.map((one) => one[one.length - 1]))];
  if (!(whole[1] > whole[0])) whole[1] = whole[0] + 1e-9;
  const view = { from: whole[0], to: whole[1], at: null, mark: null, whole };
  element.replaceChildren();
  element.classList.add("curves");
  element.classList.toggle("curves-compact", Boolean(options.compact));
  const tools = options.compact ? null : curveTools(element);
  const drawn = panels.map((panel) => curvePanel(element, panel, options));

  const dark = matchMedia("(prefers-color-scheme: dark)");
  let printing = false;
  const theme = () => document.documentElement.dataset.theme || (dark.matches ? "dark" : "light"); // the page's own first
  const redraw = () => {
    const look = LOOKS[printing ? "light" : theme()];
    for (const one of drawn) paintPanel(one, view, look);
    if (tools) {
      tools.whole.disabled = view.from === whole[0] && view.to === whole[1];
      tools.note.textContent = view.at === null ? tools.usual : `t = ${figureOf(view.at, (view.to - view.from) / 1000)} s`;
    }
  };
  const cursor = (t) => { view.at = t; redraw(); };
  const show = (from = whole[0], to = whole[1]) => {
    const least = (whole[1] - whole[0]) * 1e-5, middle = (from + to) / 2;
    if (to - from < least) { from = middle - least / 2; to = middle + least / 2; }
    view.from = Math.max(from, whole[0]);
    view.to = Math.min(to, whole[1]);
    redraw();
  };
  const zoom = (factor) => {
    const middle = view.at !== null && view.at >= view.from && view.at <= view.to ? view.at : (view.from + view.to) / 2;
    show(middle - (middle - view.from) * factor, middle + (view.to - middle) * factor);
  };
  if (tools) {
    tools.whole.onclick = () => show();
    tools.larger.onclick = () => zoom(0.5);
    tools.smaller.onclick = () => zoom(2);
  }
  for (const one of drawn) {
    for (const [name, t] of [["min", whole[0]], ["max", whole[1]], ["now", whole[0]]]) one.canvas.setAttribute(`aria-value${name}`, t);
    handlePointer(one, view, { cursor, show, redraw, onSeek: options.onSeek });
    one.canvas.addEventListener("keydown", (event) => {
      const step = (view.to - view.from) / (event.shiftKey ? 20 : 200), at = view.at === null ? view.from : view.at;
      const moved = { ArrowLeft: at - step, ArrowRight: at + step, Home: view.from, End: view.to }[event.key];
      if (moved !== undefined) {
        const t = Math.min(Math.max(moved, whole[0]), whole[1]);
        cursor(t);
        if (options.onSeek) options.onSeek(t);
        sayTime(one, t, (view.to - view.from) / 1000);
      } else if (event.key === "+") zoom(0.5);
      else if (event.key === "-") zoom(2);
      else if (event.key === "Escape") show();
      else return;
      event.preventDefault();
    });
    for (const key of one.keys) key.button.addEventListener("click", () => { key.shown = !key.shown; redraw(); });
  }
  const listening = new AbortController(), { signal } = listening, sized = new ResizeObserver(redraw);
  dark.addEventListener("change", redraw, { signal });
  addEventListener("beforeprint", () => { printing = true; redraw(); }, { signal });
  addEventListener("afterprint", () => { printing = false; redraw(); }, { signal });
  sized.observe(element);
  redraw();
  const remove = () => {
    listening.abort();
    sized.disconnect();
    element.replaceChildren();
    removers.delete(element);
  };
  removers.set(element, remove);
  return { cursor, show, redraw, remove, view };
}

function curveTools(element) {
  const bar = document.createElement("div");
  bar.className = "curves-tools";
  const button = (text) => {
    const one = document.createElement("button");
    one.type = "button";
    one.textContent = text;
    bar.append(one);
    return one;
  };
  const whole = button("Whole run"), larger = button("Zoom in"), smaller = button("Zoom out");
  const note = document.createElement("span");
  bar.append(note);
  element.append(bar);
  const usual = matchMedia("(pointer: coarse)").matches ? "touch a curve to read it off"
    : "point at a curve to read it off, drag to enlarge, double-click for the whole";
  return { whole, larger, smaller, note, usual };
}

function curvePanel(element, panel, options) {
  const section = document.createElement("section"), title = document.createElement("p");
  section.className = "curve";
  title.className = "curve-title";
  title.textContent = panel.title;
  const canvas = document.createElement("canvas"), legend = document.createElement("div");
  canvas.style.height = `${options.height || 220}px`;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "slider"); // of time
  canvas.setAttribute("aria-label", `${panel.title}: ${panel.quantity} in ${panel.unit} over time in s, ` +
    `${panel.curves.map((one) => one.name).join(", ")}; arrow keys move the cursor`);
  legend.className = panel.curves.length > 12 ? "curve-legend many" : "curve-legend";
  const keys = panel.curves.map((curve) => {
    const button = document.createElement("button"), value = document.createElement("output");
    const swatch = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
    swatch.setAttribute("width", "26");
    swatch.setAttribute("height", "8");
    for (const [name, at] of Object.entries({ x1: 0, y1: 4, x2: 26, y2: 4, "stroke-width": 2.2 })) line.setAttribute(name, at);
    line.setAttribute("stroke-dasharray", DASHES[(curve.dash || 0) % DASHES.length].join(" "));
    swatch.append(line);
    button.type = "button";
    button.title = "show or hide this curve";
    value.setAttribute("aria-live", "off"); // sixty times a second is too much to hear
    button.append(swatch, curve.name, value);
    legend.append(button);
    return { curve, time: curve.time || panel.time, button, value, line, shown: true };
  });
  const limits = document.createElement("span");
  legend.append(limits);
  section.append(title, canvas, legend);
  element.append(section);
  return { panel, canvas, keys, limits, box: null };
}

// What the cursor reads off, for who hears the page.
function sayTime({ canvas, panel, keys }, t, step) {
  const read = keys.filter((key) => key.shown).map((key) => `${key.curve.name} ${key.value.textContent}`);
  canvas.setAttribute("aria-valuenow", t);
  canvas.setAttribute("aria-valuetext", `${figureOf(t, step)} s: ${read.join(", ")} ${panel.unit}`);
}

function handlePointer(one, view, { cursor, show, redraw, onSeek }) {
  const { canvas } = one;
  let pressed = null;
  const timeAt = (event) => {
    const left = canvas.getBoundingClientRect().left, { x, width } = one.box;
    const share = Math.min(Math.max((event.clientX - left - x) / width, 0), 1);
    return view.from + share * (view.to - view.from);
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    pressed = timeAt(event);
    canvas.setPointerCapture(event.pointerId);
    cursor(pressed);
    if (onSeek) onSeek(pressed);
  });
  canvas.addEventListener("pointermove", (event) => {
    const t = timeAt(event);
    if (onSeek) {
      if (pressed !== null) { cursor(t); onSeek(t); }
      return;
    }
    if (pressed !== null && event.pointerType === "mouse") view.mark = [Math.min(pressed, t), Math.max(pressed, t)];
    cursor(t);
  });
  const release = () => {
    const mark = view.mark, least = 4 / one.box.width * (view.to - view.from);
    pressed = view.mark = null;
    if (mark && mark[1] - mark[0] > least) show(...mark);
    else redraw();
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  if (onSeek) return;
  canvas.addEventListener("dblclick", () => show());
  canvas.addEventListener("pointerleave", (event) => {
    if (pressed === null && event.pointerType === "mouse") cursor(null);
  });
}

// ---- drawing

function paintPanel(one, view, look) {
  const { canvas, panel, keys } = one, width = canvas.clientWidth, height = canvas.clientHeight;
  if (width === 0) return; // hidden; the observer asks again
  const scale = devicePixelRatio || 1;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const pen = canvas.getContext("2d");
  pen.scale(scale, scale);
  pen.font = '11px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
  const range = rangeOf(panel, keys, view), ten = tenOf(Math.max(Math.abs(range.low), Math.abs(range.high)));
  const ticks = ticksOf(range.low, range.high, Math.max(2, Math.floor(height / 45)));
  const words = ticks.map((value) => figureOf(value / ten, (ticks[1] - ticks[0]) / ten || 1));
  const left = Math.ceil(Math.max(...words.map((word) => pen.measureText(word).width))) + 10;
  const box = one.box = { x: left, y: 20, width: Math.max(width - left - 10, 10), height: height - 20 - 34 };
  const x = (t) => box.x + (t - view.from) / (view.to - view.from) * box.width;
  const y = (value) => box.y + (range.high - value) / (range.high - range.low) * box.height;

  const exponent = ten === 1 ? "" : ` ×${powerOf(ten)}`;
  pen.lineWidth = 1;
  pen.textBaseline = "middle";
  pen.fillStyle = look.soft;
  pen.textAlign = "left";
  pen.fillText(`${panel.quantity} [${panel.unit}]${exponent}`, 2, 8);
  pen.textAlign = "right";
  pen.fillStyle = look.ink;
  pen.strokeStyle = look.grid;
  ticks.forEach((value, i) => {
    rule(pen, box.x, y(value), box.x + box.width, y(value));
    pen.fillText(words[i], box.x - 6, y(value));
  });
  const instants = ticksOf(view.from, view.to, Math.max(2, Math.floor(box.width / 75)));
  pen.textAlign = "center";
  const plate = timePlate(pen, box, view, x);
  for (const t of instants) {
    rule(pen, x(t), box.y, x(t), box.y + box.height);
    const word = figureOf(t, instants[1] - instants[0] || 1), half = pen.measureText(word).width / 2 + 2;
    if (plate && x(t) + half > plate.left && x(t) - half < plate.left + plate.width) continue; // the cursor's time is there
    pen.fillText(word, x(t), box.y + box.height + 10);
  }
  pen.fillStyle = look.soft;
  pen.fillText("time [s]", box.x + box.width / 2, box.y + box.height + 26);

  pen.save();
  pen.beginPath();
  pen.rect(box.x, box.y - 1, box.width, box.height + 2);
  pen.clip();
  const since = Math.max(x(panel.since === undefined ? view.from : panel.since), box.x);
  for (const value of range.bounds) limit(pen, since, y(value), box.x + box.width, look.ink);
  for (const value of range.shared) limit(pen, box.x, y(value), box.x + box.width, look.ink);
  const alone = keys.length === 1;
  for (const key of keys) {
    const colour = alone ? look.ink : look.colours[(key.curve.colour || 0) % look.colours.length];
    key.line.setAttribute("stroke", colour);
    key.button.setAttribute("aria-pressed", key.shown);
    if (!key.shown) continue;
    for (const value of [key.curve.low, key.curve.high]) {
      if (Number.isFinite(value) && !range.shared.includes(value)) limit(pen, box.x, y(value), box.x + box.width, colour);
    }
    strokeCurve(pen, key, view, x, y, colour);
  }
  if (view.mark) {
    pen.fillStyle = look.mark;
    pen.fillRect(x(view.mark[0]), box.y, x(view.mark[1]) - x(view.mark[0]), box.height);
  }
  paintCursor(pen, one, view, look, x, y);
  pen.restore();
  paintTime(pen, box, plate, look);
  one.limits.textContent = limitWords(range, panel.unit);
  const digits = (range.high - range.low) / 1000;
  for (const key of keys) {
    const value = view.at === null || !key.shown ? null : valueAt(key, view.at);
    key.value.textContent = value === null ? "" : ten === 1 ? figureOf(value, digits) : longOf(value);
  }
}

function paintCursor(pen, { keys, box }, view, look, x, y) {
  if (view.at === null || view.at < view.from || view.at > view.to) return;
  pen.setLineDash([]);
  pen.strokeStyle = look.soft;
  pen.lineWidth = 1;
  rule(pen, x(view.at), box.y, x(view.at), box.y + box.height);
  for (const key of keys) {
    const value = key.shown ? valueAt(key, view.at) : null;
    if (value === null) continue;
    pen.fillStyle = key.line.getAttribute("stroke");
    pen.beginPath();
    pen.arc(x(view.at), y(value), 3, 0, 7);
    pen.fill();
  }
}

// Where the cursor's time is written on the axis; null where it is not in view.
function timePlate(pen, box, view, x) {
  if (view.at === null || view.at < view.from || view.at > view.to) return null;
  const words = `${figureOf(view.at, (view.to - view.from) / 1000)} s`, width = pen.measureText(words).width + 8;
  return { words, width, left: Math.min(Math.max(x(view.at) - width / 2, box.x), box.x + box.width - width) };
}

function paintTime(pen, box, plate, look) {
  if (!plate) return;
  const { words, width, left } = plate, top = box.y + box.height + 3;
  pen.fillStyle = look.ink;
  pen.fillRect(left, top, width, 15);
  pen.fillStyle = look.back;
  pen.textAlign = "center";
  pen.fillText(words, left + width / 2, top + 8);
}

function strokeCurve(pen, { curve, time }, view, x, y, colour) {
  const first = Math.max(after(time, view.from) - 1, 0), last = Math.min(after(time, view.to) + 1, time.length - 1);
  pen.strokeStyle = pen.fillStyle = colour;
  pen.lineWidth = 1.6;
  pen.lineJoin = "round";
  pen.setLineDash(DASHES[(curve.dash || 0) % DASHES.length]);
  pen.beginPath();
  for (let i = first; i <= last; i++) pen.lineTo(x(time[i]), y(curve.values[i]));
  pen.stroke();
  pen.setLineDash([]);
  if (time.length === 1) { pen.beginPath(); pen.arc(x(time[0]), y(curve.values[0]), 3, 0, 7); pen.fill(); }
}

function rule(pen, x1, y1, x2, y2) {
  pen.beginPath();
  pen.moveTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
  pen.lineTo(Math.round(x2) + 0.5, Math.round(y2) + 0.5);
  pen.stroke();
}

function limit(pen, x1, y1, x2, colour) {
  pen.strokeStyle = colour;
  pen.lineWidth = 1.2;
  pen.setLineDash([1.5, 3]);
  rule(pen, x1, y1, x2, y1);
  pen.setLineDash([]);
}

// ---- numbers

// What the vertical axis shows: the values in view, and limits where they are not so far that they would press those flat.
function rangeOf(panel, keys, view) {
  let low = Infinity, high = -Infinity;
  for (const { curve, time, shown } of keys) {
    if (!shown) continue;
    const first = Math.max(after(time, view.from) - 1, 0), last = Math.min(after(time, view.to), time.length - 1);
    for (let i = first; i <= last; i++) {
      low = Math.min(low, curve.values[i]);
      high = Math.max(high, curve.values[i]);
    }
  }
  if (low > high) [low, high] = [0, 1];
  const near = (value) => Math.max(high, value) - Math.min(low, value) <= FAR * Math.max(high - low, 1e-300);
  const wanted = Number.isFinite(panel.bound) && view.to > (panel.since || 0) ? (low < 0 ? [panel.bound, -panel.bound] : [panel.bound]) : [];
  const own = keys.flatMap(({ curve, shown }) => shown ? [curve.low, curve.high].filter(Number.isFinite) : []);
  const bounds = wanted.filter(near), seen = [...bounds, ...own.filter(near)];
  const shared = [...new Set(own)].filter((value) => keys.length > 1 && keys.every(({ curve }) => curve.low === value || curve.high === value));
  const drawn = new Set(seen), all = new Set([...wanted, ...own]), far = [...all].filter((value) => !drawn.has(value));
  low = Math.min(low, ...seen);
  high = Math.max(high, ...seen);
  const size = Math.max(Math.abs(low), Math.abs(high));
  const margin = high - low > 1e-12 * size ? 0.06 * (high - low) : 0.1 * size || 1;
  return { low: low - margin, high: high + margin, bounds, shared, drawn: [...drawn], far };
}

// What the dotted lines are, and which limits lie outside the figure.
function limitWords({ drawn, far }, unit) {
  const ends = far.map((value) => Number(value.toPrecision(4))).sort((a, b) => a - b);
  const told = ends.length > 4 ? "" : ` (${ends.join(", ").replaceAll("-", "−")} ${unit})`;
  const outside = far.length ? `limits${told} outside the figure` : "";
  return [drawn.length ? "dotted: limits" : "", outside].filter(Boolean).join("; ");
}

// The first sample at t or later.
function after(time, t) {
  let low = 0, high = time.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (time[middle] < t) low = middle + 1; else high = middle;
  }
  return low;
}

function valueAt({ curve, time }, t) {
  const { values } = curve, high = after(time, t);
  if (high === 0) return t === time[0] ? values[0] : null;
  if (high === time.length) return null;
  const share = (t - time[high - 1]) / (time[high] - time[high - 1]);
  return values[high - 1] + share * (values[high] - values[high - 1]);
}

function ticksOf(low, high, most) {
  const raw = (high - low) / most, ten = 10 ** Math.floor(Math.log10(raw));
  const steps = [0.2, 0.5, 1, 2, 5, 10].map((one) => one * ten), first = steps.findIndex((one) => one >= raw * (1 - 1e-9));
  for (const step of [steps[first], steps[first - 1], steps[first - 2]]) {
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    if (found.length > 1) return found; // one alone tells no scale
  }
  return [low, high];
}

// The power of ten that is taken out of the axis, where numbers would be long.
function tenOf(size) {
  const power = size > 0 ? Math.floor(Math.log10(size)) : 0;
  return power < -3 || power > 4 ? 10 ** power : 1;
}

function powerOf(ten) {
  return `10${[...String(Math.round(Math.log10(ten)))].map((c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]).join("")}`;
}

// A number that is very large or small, in four digits.
function longOf(value) {
  const [digits, power] = value.toExponential(3).split("e");
  return value === 0 ? "0" : `${digits.replace("-", "−")}·${powerOf(10 ** Number(power))}`;
}

// A number with as many digits as tell differences of `step`.
function figureOf(value, step) {
  const digits = Math.min(Math.max(-Math.floor(Math.log10(step) + 1e-9), 0), 12);
  const text = value.toFixed(digits);
  return (/^-0(\.0*)?$/.test(text) ? text.slice(1) : text).replace("-", "−");
}

return drawCurves;

})();
