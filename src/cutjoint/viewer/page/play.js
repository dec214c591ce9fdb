// The player: a clock that seeks in meshcat's animation, and figures that go with it.
"use strict";

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
const stage = new Stage(byId("scene"));
const player = { time: 0, playing: data.duration > 0, last: null };
const DIGITS = data.duration > 0 ? Math.max(2, 2 - Math.floor(Math.log10(data.duration))) : 2;
let curves = null; // of the groups that are chosen
window.cutjoint = { stage, player, seek, setPlaying };

// ---- scene

const bytes = Uint8Array.from(atob(byId("scene-data").textContent), (c) => c.charCodeAt(0));
stage.take(bytes.buffer);
const animator = stage.viewer.animator;
animator.pause(); // meshcat has started its own clock; ours runs

function sample(values) {
  const times = data.time, t = player.time;
  let high = times.findIndex((time) => time >= t);
  if (high < 0) high = times.length - 1;
  if (high === 0) return values[0];
  const share = (t - times[high - 1]) / (times[high] - times[high - 1]);
  return values[high - 1] + share * (values[high] - values[high - 1]);
}

function seek(time) {
  player.time = Math.min(Math.max(time, 0), data.duration);
  if (data.duration > 0) {
    animator.seek(player.time);
    byId("time").value = player.time;
    byId("clock").textContent = `${player.time.toFixed(DIGITS)} / ${data.duration.toFixed(DIGITS)} s`;
    byId("time").setAttribute("aria-valuetext", byId("clock").textContent.replace("/", "of"));
  }
  if (data.trail) {
    const past = data.trail.times.filter((one) => one <= player.time + 1e-9).length;
    stage.node(data.trail.path).geometry.setDrawRange(0, data.trail.indices * Math.max(past - 1, 0));
  }
  const rows = data.effort.map(({ name, unit, values, colour }) => [name, `${figure(sample(values), 3)} ${unit}`, colour]);
  if (data.error) rows.unshift(["Tool error", `${figure(1000 * sample(data.error), 3)} mm`]);
  fillTable(byId("figures"), rows);
  if (curves) curves.cursor(player.time);
  stage.viewer.set_dirty();
}

function setPlaying(playing) {
  player.playing = playing;
  player.last = null;
  byId("play").textContent = playing ? "Pause" : "Play";
  if (playing && player.time >= data.duration) player.time = 0;
}

function tick(now) {
  if (player.playing) {
    if (player.last !== null) {
      const next = player.time + (now - player.last) / 1000 * +byId("speed").value;
      if (next < data.duration) seek(next);
      else if (byId("loop").checked) seek(next % data.duration);
      else { seek(data.duration); setPlaying(false); }
    }
    player.last = now;
  }
  requestAnimationFrame(tick);
}

// ---- panel

byId("title").textContent = data.title;
byId("legend").querySelector("b").textContent = data.title;
byId("legend").querySelector("ul").append(...data.legend.map(({ text, colour, over }) => {
  const item = document.createElement("li");
  item.append(swatch(colour, over), text);
  return item;
}));
// Speeds: the usual ones, and those at which a very short or long motion takes some seconds.
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4], SHORTEST = 0.2, LONGEST = 60;
for (let speed = 0.01; data.duration > 0 && data.duration / SPEEDS[0] < 1; speed /= 10) SPEEDS.unshift(speed);
for (let speed = 10; data.duration / SPEEDS.at(-1) > LONGEST; speed *= 10) SPEEDS.push(speed);
const usual = data.duration < SHORTEST ? SPEEDS.findLast((speed) => data.duration / speed >= 1) : 1;
byId("speed").append(...SPEEDS.map((speed) => new Option(`${+speed.toPrecision(2)} ×`, speed, speed === usual, speed === usual)));

byId("playing").hidden = data.duration === 0;
byId("now").hidden = data.effort.length === 0 && !data.error;
byId("about-section").hidden = data.about.length === 0;
fillTable(byId("about"), data.about.map((line) => line.split(/: (.*)/, 2)));
byId("time").max = data.duration;
byId("time").addEventListener("input", () => hold(+byId("time").value));
byId("play").addEventListener("click", () => setPlaying(!player.playing));
const names = { title: "Names", shown: data.names };
fillToggles(byId("toggles"), [...data.toggles, names], stage, (title, shown) => stage.setLabels(shown ? data.labels : []));

look.placeLegend(byId("legend"), byId("scene"), byId("legend-section"));

// ---- curves: a group of panels is chosen by its name; a pointer in a curve seeks

function drawChosen() {
  const panels = data.curves.filter((group) => byId(`curve-${group.name}`).checked).flatMap((group) => group.panels);
  if (curves) curves.remove();
  curves = panels.length ? drawCurves(byId("curves"), panels, { onSeek: hold, height: 150, compact: true }) : null;
  if (curves) curves.cursor(player.time);
}

function hold(time) {
  setPlaying(false);
  seek(time);
}

byId("curves-section").hidden = data.curves.length === 0;
byId("choose").append(...data.curves.map(({ name, shown }) => {
  const label = document.createElement("label"), box = document.createElement("input");
  label.className = "check";
  box.type = "checkbox";
  box.id = `curve-${name}`;
  box.checked = shown;
  box.addEventListener("change", drawChosen);
  label.append(box, name[0].toUpperCase() + name.slice(1));
  return label;
}));
drawChosen();
look.follow(() => curves && curves.redraw());

// ---- start: `#picture&time=1.5` shows the scene alone, standing still

const wish = new URLSearchParams(location.hash.slice(1));
if (wish.has("picture")) document.documentElement.classList.add("picture");
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches; // then nothing moves unasked
setPlaying(data.duration > 0 && !wish.has("picture") && !calm);
seek(+wish.get("time") || 0);
requestAnimationFrame(() => requestAnimationFrame(() => {
  stage.viewer.set_3d_pane_size();
  stage.viewer.render();
  document.documentElement.dataset.ready = "yes";
}));
requestAnimationFrame(tick);
