// The 3-D scene of a page: meshcat's viewer, fed with batches of its own messages, and labels over it.
"use strict";

const VIEWS = [
  ["Front", "f", [0, -1, 0]],
  ["Side", "s", [1, 0, 0]],
  ["Top", "t", [0, 0, 1]],
  ["Home", "h", null],
];

// What lies behind the robot, from top to bottom, and the lines of the floor.
const BEHIND = {
  light: { top: [0.93, 0.95, 0.98], bottom: [0.99, 0.99, 0.99], floor: 0xd5d8dd },
  dark: { top: [0.21, 0.24, 0.28], bottom: [0.13, 0.145, 0.17], floor: 0x454c56 },
};
const LEAST_CONTRAST = 4; // of lines over the robot, in the dark

class Stage {
  constructor(scene) {
    this.scene = scene;
    this.pane = scene.querySelector("#pane");
    this.labelBox = scene.querySelector("#labels");
    this.labels = [];
    const viewer = new MeshCat.Viewer(this.pane);
    this.viewer = viewer;
    // meshcat would run the text of these messages; nothing here sends them, and nothing may
    viewer.set_control = viewer.set_control_value = viewer.delete_control = () => {};
    const resize = viewer.set_3d_pane_size;
    viewer.set_3d_pane_size = () => {
      const width = this.pane.clientWidth, height = this.pane.clientHeight;
      if (width > 0 && height > 0) {
        const bar = SMALL.matches ? Math.min(scene.querySelector("#bar").offsetHeight + 6, height / 3) : 0;
        viewer.camera.zoom = Math.min(1, width / height, (height - bar) / height); // the robot fits in, under the buttons
        viewer.camera.setViewOffset(width, height, 0, -bar / 2, width, height);
      }
      resize.call(viewer, width, height);
    };
    new ResizeObserver(() => viewer.set_3d_pane_size()).observe(this.pane);
    const render = viewer.render;
    viewer.render = () => { render.call(viewer); this.placeLabels(); };
    viewer.set_3d_pane_size();
    this.makeViews(scene.querySelector("#views"));
    look.makeTools(scene.querySelector("#tools"));
    look.follow((dark) => this.light(dark));
  }

  light(dark) {
    const { top, bottom } = BEHIND[dark ? "dark" : "light"];
    this.viewer.set_property(["Background"], "top_color", top);
    this.viewer.set_property(["Background"], "bottom_color", bottom);
    this.tint();
  }

  // Colours of lines and of what is drawn over the robot, so that they stand out; shaded surfaces keep theirs.
  tint() {
    const paint = (root, colour) => this.node(root).traverse(({ material }) => {
      if (!material || material.isMeshPhongMaterial || material.vertexColors) return;
      material.userData.own ??= material.color.getHex();
      material.color.setHex(colour(material.userData.own, material.opacity));
    });
    paint("robot", standingOut);
    paint("floor", () => BEHIND[look.dark ? "dark" : "light"].floor);
    this.viewer.set_dirty();
  }

  // Named views, by button and key, along the axes of the world (turned so that gravity points down): from in front one
  // looks along +y with +x to the right, from the side along -x with +y to the right, from the top along -z with +y up.
  makeViews(parent) {
    for (const [name, key, where] of VIEWS) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.title = `${name} view (key ${key.toUpperCase()})`;
      button.addEventListener("click", () => this.lookFrom(where));
      parent.append(button);
    }
    window.addEventListener("keydown", (event) => {
      const typing = event.target instanceof Element && event.target.matches("input[type=number], select, textarea");
      if (typing || event.ctrlKey || event.altKey || event.metaKey) return;
      const view = VIEWS.find(([, key]) => key === event.key.toLowerCase());
      if (view) this.lookFrom(view[2]);
    });
  }

  // The camera at `where` in the world, or where the scene puts it, looking at the middle of the robot.
  lookFrom(where) {
    const { camera, controls } = this.viewer;
    camera.position.copy(this.home);
    if (where) camera.position.set(where[0], where[2], 0 - where[1]).setLength(this.home.length()); // its y is up
    controls.target.set(0, 0, 0);
    controls.update();
    this.viewer.set_dirty();
  }

  // A batch: messages, each with its length in four bytes before it.
  take(buffer) {
    const view = new DataView(buffer);
    for (let at = 0; at + 4 <= view.byteLength;) {
      const size = view.getUint32(at, true);
      this.viewer.handle_command_bytearray(new Uint8Array(buffer, at + 4, size));
      at += 4 + size;
    }
    this.home ??= this.viewer.camera.position.clone();
    this.tint();
  }

  node(path) {
    return this.viewer.scene_tree.find(path.split("/").filter((part) => part)).object;
  }

  show(paths, shown) {
    for (const path of paths) this.node(path).visible = shown;
    this.viewer.set_dirty();
  }

  // Labels follow the origin of a path of the scene: [{path, text, colour}].
  setLabels(labels) {
    this.labelBox.replaceChildren();
    this.labels = labels.map((label) => {
      const box = document.createElement("div");
      box.className = "label";
      box.textContent = label.text;
      if (label.colour) box.style.borderLeftColor = label.colour;
      this.labelBox.append(box);
      return { path: label.path, box };
    });
    this.viewer.set_dirty();
  }

  placeLabels() {
    if (!this.labels.length) return;
    const { camera } = this.viewer, width = this.pane.clientWidth, height = this.pane.clientHeight;
    const taken = this.taken();
    const wanted = this.labels.map(({ path, box }) => {
      const point = new MeshCat.THREE.Vector3().setFromMatrixPosition(this.node(path).matrixWorld).project(camera);
      const w = box.offsetWidth, h = box.offsetHeight;
      const x = Math.min(Math.max((point.x + 1) / 2 * width + 12, 4), Math.max(width - w - 4, 4));
      const y = Math.min(Math.max((1 - point.y) / 2 * height - 1.6 * h, 4), Math.max(height - h - 4, 4));
      return { box, x, y, w, h, behind: point.z > 1 };
    });
    for (const one of wanted.sort((a, b) => a.y - b.y)) {
      const y = one.behind ? null : freePlace(one, taken, height);
      one.box.style.visibility = y === null ? "hidden" : "visible"; // where there is no room, as behind the camera
      if (y === null) continue;
      one.box.style.transform = `translate(${one.x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      taken.push({ ...one, y });
    }
  }

  // What else lies over the picture, where no label may be.
  taken() {
    const pane = this.pane.getBoundingClientRect();
    return [...this.scene.querySelectorAll("#views, #tools, #legend")].map((one) => {
      const box = one.getBoundingClientRect();
      return { x: box.left - pane.left, y: box.top - pane.top, w: box.width, h: box.height };
    });
  }
}

// The height nearest to the wanted one, below it or else above, at which a label lies over nothing; null where there is none.
function freePlace({ x, y, w, h }, taken, height) {
  const gap = 2;
  const hit = (at) => taken.find((one) => x < one.x + one.w + gap && one.x < x + w + gap && at < one.y + one.h + gap && one.y < at + h + gap);
  for (const step of [(one) => one.y + one.h + gap, (one) => one.y - h - gap]) {
    let at = y, under = hit(at);
    while (under && at >= 0 && at + h <= height) {
      at = step(under);
      under = hit(at);
    }
    if (!under && at >= 0 && at + h <= height) return at;
  }
  return null;
}

function luminance(colour) {
  const [r, g, b] = [16, 8, 0].map((shift) => {
    const share = (colour >> shift & 255) / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

// A colour (a number) as it is in the light; in the dark with as much white as it needs to stand out.
function standingOut(colour, opacity = 1) {
  if (!look.dark) return colour;
  const back = luminance(BEHIND.dark.top.reduce((all, share) => all << 8 | Math.round(255 * share), 0));
  const mixed = (white) => [16, 8, 0].reduce((all, shift) => all << 8 | Math.round((colour >> shift & 255) * (1 - white) + 255 * white), 0);
  for (let white = 0; white < 1; white += 0.1) {
    if ((luminance(mixed(white)) + 0.05) / (back + 0.05) * opacity >= LEAST_CONTRAST) return mixed(white);
  }
  return 0xffffff;
}

// Rows of a table: [[name, value, colour, class of the name], ...].
function fillTable(table, rows) {
  table.replaceChildren(...rows.map(([name, value, colour, kind]) => {
    const row = document.createElement("tr"), left = document.createElement("td"), right = document.createElement("td");
    if (colour) left.append(swatch(colour));
    left.append(name);
    if (kind) left.className = kind;
    right.textContent = value;
    row.append(left, right);
    return row;
  }));
}

// A patch of a colour, #rrggbb or #rrggbbaa; `over` where it is that of a line or arrow over the robot, which the dark changes.
function swatch(colour, over = false) {
  const box = document.createElement("span");
  box.className = "swatch";
  const paint = () => {
    const own = parseInt(colour.slice(1, 7), 16);
    box.style.background = `#${(over ? standingOut(own, parseInt(colour.slice(7) || "ff", 16) / 255) : own).toString(16).padStart(6, "0")}${colour.slice(7)}`;
  };
  paint();
  if (over) look.follow(paint);
  return box;
}

// Boxes that are there already stay, with their state and the focus.
function fillToggles(parent, toggles, stage, extra) {
  const before = new Map([...parent.querySelectorAll("input")].map((box) => [box.name, box]));
  const labels = toggles.map(({ title, paths, shown }) => {
    let box = before.get(title);
    if (!box) {
      box = document.createElement("input");
      Object.assign(box, { type: "checkbox", name: title, checked: shown });
      document.createElement("label").append(box, title);
    }
    box.onchange = () => paths ? stage.show(paths, box.checked) : extra(title, box.checked);
    box.onchange();
    return box.parentElement;
  });
  if (labels.length !== before.size || labels.some((label, i) => label !== parent.children[i])) parent.replaceChildren(...labels);
}

function figure(value, digits = 4) {
  if (value === null || value === undefined) return "not defined";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size < 1e-3 || size >= 1e5 ? value.toExponential(1) : value.toPrecision(digits);
}

function fixed(value, digits = 4) {
  return (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
}
