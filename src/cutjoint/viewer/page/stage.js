// The 3-D scene of a page: meshcat's viewer, fed with batches of its own messages, and labels over it.
"use strict";

const VIEWS = [
  ["Front", "f", [0, -1, 0]],
  ["Side", "s", [1, 0, 0]],
  ["Top", "t", [0, 0, 1]],
  ["Home", "h", null],
];

class Stage {
  constructor(scene) {
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
      viewer.camera.zoom = Math.min(1, width / height); // the robot fits in, however narrow the page
      resize.call(viewer, width, height);
    };
    new ResizeObserver(() => viewer.set_3d_pane_size()).observe(this.pane);
    const render = viewer.render;
    viewer.render = () => { render.call(viewer); this.placeLabels(); };
    viewer.set_3d_pane_size();
    this.makeViews(scene.querySelector("#views"));
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
    const { camera } = this.viewer, width = this.pane.clientWidth, height = this.pane.clientHeight;
    const placed = [];
    for (const { path, box } of this.labels) {
      const point = new MeshCat.THREE.Vector3().setFromMatrixPosition(this.node(path).matrixWorld).project(camera);
      const w = box.offsetWidth, h = box.offsetHeight;
      const x = Math.min(Math.max((point.x + 1) / 2 * width + 12, 4), Math.max(width - w - 4, 4));
      const y = Math.min(Math.max((1 - point.y) / 2 * height - 1.6 * h, 4), Math.max(height - h - 4, 4));
      placed.push({ box, x, y, w, h, behind: point.z > 1 });
    }
    placed.sort((a, b) => a.y - b.y);
    placed.forEach((one, i) => {
      for (const other of placed.slice(0, i)) {
        if (one.x < other.x + other.w && other.x < one.x + one.w && one.y < other.y + other.h + 2) one.y = other.y + other.h + 2;
      }
      one.box.style.transform = `translate(${one.x.toFixed(1)}px, ${one.y.toFixed(1)}px)`;
      one.box.style.visibility = one.behind ? "hidden" : "visible";
    });
  }
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

function swatch(colour) {
  const box = document.createElement("span");
  box.className = "swatch";
  box.style.background = colour;
  return box;
}

function fillToggles(parent, toggles, stage, extra) {
  const before = new Map([...parent.querySelectorAll("input")].map((box) => [box.name, box.checked]));
  parent.replaceChildren(...toggles.map(({ title, paths, shown }) => {
    const label = document.createElement("label"), box = document.createElement("input");
    box.type = "checkbox";
    box.name = title;
    box.checked = before.has(title) ? before.get(title) : shown;
    const apply = () => paths ? stage.show(paths, box.checked) : extra(title, box.checked);
    box.addEventListener("change", apply);
    apply();
    label.append(box, title);
    return label;
  }));
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
