// Draws a frame's triangles and lines with three.js, and only after a change.
import * as THREE from "three";
import { OrbitControls } from "./OrbitControls.js";
import { BROKEN, bodyColour, shellColour } from "./colours.js";

const MOVING = 0, STATIC = 2; // `kind` of a triangle of bodies
const FIELD_DEG = 30;
const FROM = new THREE.Vector3(0.42, -0.80, 0.46).normalize(); // first direction of the camera, as in the contact sheet

export class Picture {
  #canvas; #renderer; #camera; #controls; #scene = new THREE.Scene(); #shown = new THREE.Group(); #queued = false;
  #origin = null; // of the first frame [m]; later frames are placed relative to it

  constructor(canvas) {
    this.#canvas = canvas;
    this.#renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.#camera = new THREE.PerspectiveCamera(FIELD_DEG, 1, 0.01, 100);
    this.#camera.up.set(0, 0, 1);
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.addEventListener("change", () => this.redraw());
    const sun = new THREE.DirectionalLight(0xffffff, 1.9);
    sun.position.set(-0.36, -0.28, 0.89);
    const fill = new THREE.DirectionalLight(0xffffff, 0.7);
    fill.position.set(0.6, -0.5, -0.2);
    this.#scene.add(new THREE.HemisphereLight(0xffffff, 0xb8bec6, 1.7), sun, fill, this.#shown);
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
  }

  /** Number of triangles drawn last. */
  get triangles() { return this.#renderer.info.render.triangles; }

  /** Draws the scene before the next repaint of the screen, once for several calls. */
  redraw() {
    if (this.#queued) return;
    this.#queued = true;
    requestAnimationFrame(() => {
      this.#queued = false;
      const towards = this.#camera.position.clone().sub(this.#controls.target).normalize();
      for (const object of this.#shown.children) object.position.copy(towards).multiplyScalar(object.userData.lift ?? 0);
      this.#renderer.render(this.#scene, this.#camera);
      document.body.dataset.triangles = this.triangles; // read by tests of the page
    });
  }

  /** Draws a frame. `options`: by, top, look, lines, bodies, fixed, mesh. */
  show(frame, options) {
    for (const object of this.#shown.children) { object.geometry.dispose(); object.material.dispose(); }
    this.#shown.clear();
    this.#origin ??= frame.origin;
    this.#shown.position.set(...frame.origin.map((v, axis) => v - this.#origin[axis]));
    const a = frame.arrays, { by, top, look } = options;
    const oneOfTwo = 1 - Math.sqrt(1 - look.glassOpacity); // of glass of which two faces are drawn
    if (a["shell.index"]) {
      const normals = a["shell.normal"];
      const opacity = frame.thickness_m > 0 ? oneOfTwo : look.glassOpacity;
      const clear = by === "part" ? (t) => look.isGlass(a["shell.part"][t]) : () => false;
      const colour = shellColour(frame, by, top, look);
      this.#add(a["shell.position"], a["shell.index"], colour, normals, (t) => !clear(t), 1, options, true);
      this.#add(a["shell.position"], a["shell.index"], colour, normals, clear, opacity, options, true);
    }
    if (a["bodies.index"]) {
      const kind = a["bodies.kind"], colour = bodyColour(frame, by, top, look);
      const mesh = (keep, opacity = 1) =>
        this.#add(a["bodies.position"], a["bodies.index"], colour, null, keep, opacity, options, false);
      const clear = (t) => by === "part" && BROKEN.includes(kind[t]) &&
        look.isGlassShard(a["bodies.body"][t], a["bodies.part"]?.[t] ?? -1);
      if (options.bodies) mesh((t) => kind[t] !== STATIC && !clear(t));
      if (options.bodies) mesh(clear, oneOfTwo);
      if (options.fixed) mesh((t) => kind[t] === STATIC);
      if (options.bodies) this.#addLines(a.outlines, 0.35);
    }
    if (options.lines) {
      this.#addLines(a.cracks, 0.85);
      this.#addLines(a.inner, 0.85, 0.55 * frame.thickness_m);
    }
    this.redraw();
  }

  #add(points, index, colour, normals, keep, opacity, options, shell) {
    const kept = [];
    for (let t = 0; t < index.length / 3; t++) if (keep(t)) kept.push(t);
    if (!kept.length) return;
    const position = new Float32Array(9 * kept.length), colours = new Float32Array(9 * kept.length);
    const normal = normals && new Float32Array(9 * kept.length);
    const mixed = new THREE.Color();
    kept.forEach((t, n) => {
      for (let c = 0; c < 3; c++) {
        const point = index[3 * t + c], at = 9 * n + 3 * c;
        mixed.setRGB(...colour(t, point), THREE.SRGBColorSpace).toArray(colours, at);
        for (let axis = 0; axis < 3; axis++) {
          position[at + axis] = points[3 * point + axis];
          if (normal) normal[at + axis] = normals[3 * point + axis];
        }
      }
      if (normal) flatten(position, normal, 9 * n);
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    if (normal) geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
    const material = new THREE.MeshPhongMaterial({
      vertexColors: true, side: THREE.DoubleSide, flatShading: !normal, shininess: 40, specular: 0x222222,
      wireframe: options.mesh, transparent: opacity < 1, opacity, depthWrite: opacity > 0.6, forceSinglePass: true,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1, // keeps lines on a face in front of it
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.userData = { shell, kept };
    this.#shown.add(mesh);
  }

  /** The triangle of a frame at a place of the window [px]: {shell, triangle}; null where there is none. */
  pick(x, y) {
    const { left, top, width, height } = this.#canvas.getBoundingClientRect();
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(2 * (x - left) / width - 1, 1 - 2 * (y - top) / height), this.#camera);
    const hit = ray.intersectObjects(this.#shown.children.filter((object) => object.userData.kept), false)[0];
    return hit ? { shell: hit.object.userData.shell, triangle: hit.object.userData.kept[hit.faceIndex] } : null;
  }

  /** `lift` [m]: how far lines are drawn towards the eye. */
  #addLines(points, opacity, lift = 0) {
    if (!points?.length) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x0f1f29, transparent: true, opacity }));
    lines.userData.lift = lift;
    this.#shown.add(lines);
  }

  /** Moves the camera so that the shell fills the picture; without a shell, all moving bodies do. */
  fit(frame) {
    const a = frame.arrays, box = new THREE.Box3(), point = new THREE.Vector3();
    if (a["shell.position"]?.length) box.setFromArray(a["shell.position"]);
    else {
      const index = a["bodies.index"] ?? [], kind = a["bodies.kind"];
      const fixed = kind?.every((k) => k === STATIC);
      for (let i = 0; i < index.length; i++)
        if (fixed || kind[Math.floor(i / 3)] !== STATIC) box.expandByPoint(point.fromArray(a["bodies.position"], 3 * index[i]));
    }
    if (box.isEmpty()) box.set(new THREE.Vector3(-0.5, -0.5, -0.5), new THREE.Vector3(0.5, 0.5, 0.5));
    const origin = this.#origin ?? frame.origin;
    box.translate(point.set(...frame.origin.map((v, axis) => v - origin[axis])));
    const radius = Math.max(0.5 * box.getSize(new THREE.Vector3()).length(), 1e-9);
    const narrow = Math.min(this.#camera.aspect, 1);
    const distance = radius / Math.sin(0.5 * THREE.MathUtils.degToRad(FIELD_DEG)) / narrow;
    box.getCenter(this.#controls.target);
    const from = FROM.clone();
    if (this.#comesFrom(a) < this.#controls.target.x - 0.25 * radius) from.x *= -1; // look at the side that is hit
    this.#camera.position.copy(this.#controls.target).addScaledVector(from, distance);
    this.#camera.near = distance / 100;
    this.#camera.far = distance * 100;
    this.#camera.updateProjectionMatrix();
    this.#controls.update();
    this.redraw();
  }

  /** Mean x of the scene's moving bodies [m]; NaN without any. */
  #comesFrom(arrays) {
    const index = arrays["bodies.index"] ?? [], kind = arrays["bodies.kind"];
    let sum = 0, count = 0;
    for (let i = 0; i < index.length; i++)
      if (kind[Math.floor(i / 3)] === MOVING) { sum += arrays["bodies.position"][3 * index[i]]; count++; }
    return sum / count;
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#canvas.parentElement;
    if (!width || !height) return;
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
    this.redraw();
  }
}

/** Gives the triangle at `first` its own normal where one of its corners has none: edges of sheets, and folds. */
function flatten(position, normal, first) {
  const corners = [0, 3, 6].map((k) => new THREE.Vector3().fromArray(normal, first + k));
  if (corners.every((n) => n.lengthSq() > 0.25)) return;
  const [a, b, c] = [0, 3, 6].map((k) => new THREE.Vector3().fromArray(position, first + k));
  const own = b.sub(a).cross(c.sub(a)).normalize();
  for (const k of [0, 3, 6]) own.toArray(normal, first + k);
}
