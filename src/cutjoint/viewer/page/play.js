// The player: a clock that seeks in meshcat's animation, and figures that go with it.
"use strict";

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
const stage = new Stage(byId("scene"));
const player = { time: 0, playing: data.duration > 0, last: null };
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
    byId("clock").textContent = `${player.time.toFixed(2)} / ${data.duration.toFixed(2)} s`;
  }
  if (data.trail) {
    const past = data.trail.times.filter((one) => one <= player.time + 1e-9).length;
    stage.node(data.trail.path).geometry.setDrawRange(0, data.trail.indices * Math.max(past - 1, 0));
  }
  const rows = data.effort.map(({ name, unit, values }, i) => [name, `${figure(sample(values), 3)} ${unit}`, data.legend[i].colour]);
  if (data.error) rows.unshift(["Tool error", `${figure(1000 * sample(data.error), 3)} mm`]);
  fillTable(byId("figures"), data.figures || rows);
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
byId("legend").querySelector("ul").append(...data.legend.map(({ text, colour }) => {
  const item = document.createElement("li");
  item.append(swatch(colour), text);
  return item;
}));
byId("playing").hidden = data.duration === 0;
byId("now").hidden = data.effort.length === 0 && !data.figures;
byId("about-section").hidden = data.about.length === 0;
fillTable(byId("about"), data.about.map((line) => [line, ""]));
byId("time").max = data.duration;
byId("time").addEventListener("input", () => { setPlaying(false); seek(+byId("time").value); });
byId("play").addEventListener("click", () => setPlaying(!player.playing));
const names = { title: "Names", shown: true };
fillToggles(byId("toggles"), [...data.toggles, names], stage, (title, shown) => stage.setLabels(shown ? data.labels : []));

// ---- start: `#picture&time=1.5` shows the scene alone, standing still

const wish = new URLSearchParams(location.hash.slice(1));
if (wish.has("picture")) document.documentElement.classList.add("picture");
setPlaying(data.duration > 0 && !wish.has("picture"));
seek(+wish.get("time") || 0);
requestAnimationFrame(() => requestAnimationFrame(() => {
  stage.viewer.set_3d_pane_size();
  stage.viewer.render();
  document.documentElement.dataset.ready = "yes";
}));
requestAnimationFrame(tick);
