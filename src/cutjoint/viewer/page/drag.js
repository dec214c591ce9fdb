// The tool dragged with the mouse: a ball over the tool's point; where it is pulled to lies in the plane of the picture.
"use strict";

const HANDLE = 0.035; // radius of the ball, in radii of the robot

class ToolHandle {
  // `moved` is told where in the world of the robot the tool should be: [x, y, z] [m].
  constructor(stage, moved) {
    const { SphereGeometry, MeshBasicMaterial, Mesh } = MeshCat.THREE;
    this.stage = stage;
    this.moved = moved;
    this.held = null;
    this.ball = new Mesh(new SphereGeometry(1, 24, 16), new MeshBasicMaterial({
      color: 0x6b3d99, opacity: 0.45, transparent: true, depthTest: false, depthWrite: false,
    }));
    this.ball.renderOrder = 10;
    const { pane } = stage;
    pane.addEventListener("pointerdown", (event) => this.grab(event), true);
    pane.addEventListener("pointermove", (event) => (this.held ? this.pull(event) : this.point(event)));
    for (const end of ["pointerup", "pointercancel"]) pane.addEventListener(end, () => this.release());
  }

  // Follow the tool of the scene, at a size that suits every robot.
  attach() {
    this.ball.scale.setScalar(HANDLE / this.stage.node("robot").scale.x);
    this.stage.node("robot/tool").add(this.ball);
    this.stage.viewer.set_dirty();
  }

  ray(event) {
    const box = this.stage.pane.getBoundingClientRect();
    const caster = new MeshCat.THREE.Raycaster();
    caster.setFromCamera({
      x: 2 * (event.clientX - box.left) / box.width - 1, y: 1 - 2 * (event.clientY - box.top) / box.height,
    }, this.stage.viewer.camera);
    return caster;
  }

  isUnder(event) {
    return this.ball.parent !== null && this.ray(event).intersectObject(this.ball).length > 0;
  }

  point(event) {
    this.shine(event.buttons === 0 && this.isUnder(event) ? "grab" : "");
  }

  shine(cursor) {
    if (this.stage.pane.style.cursor === cursor) return;
    this.stage.pane.style.cursor = cursor;
    this.ball.material.opacity = cursor ? 0.8 : 0.45;
    this.stage.viewer.set_dirty();
  }

  grab(event) {
    if (event.button !== 0 || !this.isUnder(event)) return;
    const { camera, controls } = this.stage.viewer, { Plane, Vector3 } = MeshCat.THREE;
    const middle = this.ball.getWorldPosition(new Vector3());
    const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), middle);
    const at = this.ray(event).ray.intersectPlane(plane, new Vector3());
    this.held = { plane, offset: middle.sub(at) };
    controls.enabled = false; // the camera stays
    this.stage.pane.setPointerCapture(event.pointerId);
    this.shine("grabbing");
  }

  pull(event) {
    const at = this.ray(event).ray.intersectPlane(this.held.plane, new MeshCat.THREE.Vector3());
    if (at) this.moved(this.stage.node("robot").worldToLocal(at.add(this.held.offset)).toArray());
  }

  release() {
    if (!this.held) return;
    this.held = null;
    this.stage.viewer.controls.enabled = true;
    this.shine("");
  }
}
