// The 3-D scene of a page: meshcat's viewer, fed with batches of its own messages, and labels over it.
"use strict";

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
  }

  // A batch: messages, each with its length in four bytes before it.
  take(buffer) {
    const view = new DataView(buffer);
    for (let at = 0; at + 4 <= view.byteLength;) {
      const size = view.getUint32(at, true);
      this.viewer.handle_command_bytearray(new Uint8Array(buffer, at + 4, size));
      at += 4 + size;
    }
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

// Rows of a table: [[name, value, colour], ...].
function fillTable(table, rows) {
  table.replaceChildren(...rows.map(([name, value, colour]) => {
    const row = document.createElement("tr"), left = document.createElement("td"), right = document.createElement("td");
    if (colour) left.append(swatch(colour));
    left.append(name);
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
