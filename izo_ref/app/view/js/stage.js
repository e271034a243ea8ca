// The 3D view: one camera, one mesh for each side, and how the two share the canvas.
import * as THREE from "three";
import { OrbitControls } from "three-orbit";

const FOV = 40; // degrees
const FROM = new THREE.Vector3(0.5, 0.42, 0.85).normalize(); // direction of the first view
const FLIGHT = 450; // milliseconds
const NEAR = 0.004; // distance of the near plane over that of the target
const CUT = 0.55; // the same while the front is cut away
const LOOKED_AT = 60000; // positions that decide what is put into view
const MARGIN = 1.12; // space around what is put into view
const NEARER = 0.0006; // of the depth that the picture has
const TURN = 0.09; // radians of a key

export class Stage {
  /**
   * @param {HTMLElement} holder Where the canvas goes.
   * @param {object} model The model.
   */
  constructor(holder, model) {
    this.holder = holder;
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    holder.append(this.renderer.domElement);
    this.renderer.domElement.setAttribute("aria-hidden", "true"); // the holder has the label
    this.camera = new THREE.PerspectiveCamera(FOV, 1, 0.01, 100);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.draw());
    this.radius = Math.hypot(...model.reach);
    this.layout = "before";
    this.split = 0.5;
    this.isCut = false;
    this.sides = model.sides.map(() => makeSide(model));
    this.flight = 0;
    this.waiting = false;
    new ResizeObserver(() => this.draw()).observe(holder);
  }

  /** Show new positions of a side; `side.positions` was changed. */
  moved(side) {
    this.sides[side].geometry.getAttribute("position").needsUpdate = true;
    this.draw();
  }

  /** Show new colors of a side; `side.colors` was changed. */
  painted(side) {
    this.sides[side].geometry.getAttribute("color").needsUpdate = true;
    this.draw();
  }

  /** Take the colors of the page, which differ on a light and on a dark one. */
  setTheme(theme) {
    this.renderer.setClearColor(getComputedStyle(this.holder.parentElement).backgroundColor);
    const strength = theme === "dark" ? 0.32 : 0.22;
    for (const side of this.sides) {
      side.lines.material.color.set(theme === "dark" ? 0xffffff : 0x000000);
      side.lines.material.opacity = strength;
    }
    this.draw();
  }

  setUp(axis) {
    for (const side of this.sides) side.root.rotation.x = axis === "z" ? -Math.PI / 2 : 0;
    this.draw();
  }

  setEdges(shown) {
    for (const side of this.sides) side.lines.visible = shown;
    this.draw();
  }

  /**
   * Put vertices into view.
   *
   * @param {Int32Array} used The vertices.
   * @param {Float32Array[]} frames Positions, all of which are to be seen.
   */
  fit(used, frames) {
    const box = new THREE.Box3();
    const point = new THREE.Vector3();
    const each = (run) => {
      const { root } = this.sides[0];
      root.updateMatrixWorld();
      // some of the vertices are enough: the margin has room for those between them
      const step = Math.max(Math.floor((used.length * frames.length) / LOOKED_AT), 1);
      for (const positions of frames) {
        for (let i = 0; i < used.length; i += step) {
          run(point.fromArray(positions, 3 * used[i]).applyMatrix4(root.matrixWorld));
        }
      }
    };
    each((place) => box.expandByPoint(place));
    const center = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
    const right = new THREE.Vector3().crossVectors(this.camera.up, FROM).normalize();
    const above = new THREE.Vector3().crossVectors(FROM, right);
    const tangent = Math.tan((FOV * Math.PI) / 360);
    let distance = 0; // the least from which each vertex is seen
    each((place) => {
      const offset = place.sub(center);
      const across = Math.abs(offset.dot(right)) / (tangent * this.aspect());
      const along = Math.abs(offset.dot(above)) / tangent;
      distance = Math.max(distance, offset.dot(FROM) + MARGIN * Math.max(across, along));
    });
    this.look(center, FROM, distance || 1, false);
  }

  /** Fly to a place of a side: `center` and `size` are in the numbers of the positions. */
  fly(side, center, size) {
    const { root } = this.sides[side];
    root.updateMatrixWorld();
    const target = root.localToWorld(new THREE.Vector3(...center));
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    this.look(target, direction, 7 * Math.max(size, 1e-6), true);
  }

  look(target, direction, distance, isSlow) {
    const begin = { target: this.controls.target.clone(), eye: this.camera.position.clone() };
    const eye = target.clone().addScaledVector(direction, distance);
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const flight = (this.flight += 1); // a later flight ends this one
    const since = performance.now();
    const go = (time) => {
      if (flight !== this.flight) return;
      const part = !isSlow || still ? 1 : Math.min((time - since) / FLIGHT, 1);
      const eased = Math.max(part, 0) ** 2 * (3 - 2 * Math.max(part, 0));
      this.controls.target.lerpVectors(begin.target, target, eased);
      // the distance shrinks evenly in its logarithm, so that the flight ends softly
      const far = begin.eye.distanceTo(begin.target) || distance;
      const aside = begin.eye.clone().sub(begin.target).normalize().lerp(direction, eased).normalize();
      this.camera.position.copy(this.controls.target).addScaledVector(aside, far ** (1 - eased) * distance ** eased);
      this.controls.update();
      this.draw();
      if (part < 1) requestAnimationFrame(go);
    };
    go(since);
  }

  /** Turn or zoom the camera by a key: `across` and `along` in turns of a key. */
  turn(across, along) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const place = new THREE.Spherical().setFromVector3(offset);
    place.theta -= TURN * across;
    place.phi = Math.min(Math.max(place.phi - TURN * along, 0.02), Math.PI - 0.02);
    this.camera.position.copy(this.controls.target).add(offset.setFromSpherical(place));
    this.controls.update();
    this.draw();
  }

  zoom(factor) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.camera.position.copy(this.controls.target).addScaledVector(offset, factor);
    this.controls.update();
    this.draw();
  }

  aspect() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    return (this.layout === "both" ? width / 2 : width) / Math.max(height, 1);
  }

  /** Draw soon; several calls before that are one. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.drawNow();
    });
  }

  drawNow() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== width || size.y !== height) this.renderer.setSize(width, height);
    const distance = this.camera.position.distanceTo(this.controls.target);
    // near and far planes close to the mesh: sheets that are nearly in contact stay apart in depth
    const forward = this.controls.target.clone().sub(this.camera.position).normalize();
    const middle = -this.camera.position.dot(forward); // depth of the centre of the mesh
    this.camera.near = distance * (this.isCut ? CUT : NEAR);
    if (!this.isCut) this.camera.near = Math.max(this.camera.near, middle - this.radius);
    this.camera.far = Math.max(middle + this.radius, 2 * this.camera.near);
    this.camera.aspect = this.aspect();
    this.camera.updateProjectionMatrix();
    const half = Math.floor(width / 2);
    const place = Math.floor(width * this.split);
    const views = {
      before: [[0, 0, width, 0, width]],
      after: [[1, 0, width, 0, width]],
      both: [[0, 0, half, 0, half], [1, half, width - half, half, width - half]],
      wipe: [[0, 0, width, 0, place], [1, 0, width, place, width - place]],
    }[this.layout];
    this.renderer.setScissorTest(true);
    for (const [side, left, wide, cutLeft, cutWide] of views) {
      if (cutWide <= 0) continue;
      this.renderer.setViewport(left, 0, wide, height);
      this.renderer.setScissor(cutLeft, 0, cutWide, height);
      const { scene, light } = this.sides[Math.min(side, this.sides.length - 1)];
      // a light above and to the left of the camera, so that shapes are seen from everywhere
      light.position.set(-0.55, 0.75, 0).multiplyScalar(distance);
      light.position.applyQuaternion(this.camera.quaternion).add(this.camera.position);
      light.target.position.copy(this.controls.target);
      light.target.updateMatrixWorld();
      this.renderer.render(scene, this.camera);
    }
  }
}

/**
 * Draw what has this material a little in front of the faces that it is on. Faces themselves are
 * not pushed back (`polygonOffset`): sheets that are nearly in contact would go through each other.
 */
export function nearer(material) {
  material.onBeforeCompile = (shader) => {
    const end = "#include <project_vertex>";
    shader.vertexShader = shader.vertexShader.replace(end, `${end}\ngl_Position.z -= ${NEARER} * gl_Position.w;`);
  };
  return material;
}

// The scene of one side, with arrays of positions and colors that others write to.
function makeSide(model) {
  const positions = new Float32Array(3 * model.n);
  const colors = new Float32Array(3 * model.n);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3).setUsage(THREE.DynamicDrawUsage));
  geometry.setAttribute("color", new THREE.BufferAttribute(colors, 3).setUsage(THREE.DynamicDrawUsage));
  geometry.setIndex(new THREE.BufferAttribute(model.faces, 1));
  const surface = new THREE.MeshLambertMaterial({
    vertexColors: true,
    flatShading: true, // normals from the positions that are drawn, without any work per frame
    side: THREE.DoubleSide,
  });
  const mesh = new THREE.Mesh(geometry, surface);
  const lines = new THREE.Mesh(geometry, nearer(new THREE.MeshBasicMaterial({ wireframe: true, transparent: true, depthWrite: false })));
  lines.visible = false;
  for (const object of [mesh, lines]) object.frustumCulled = false; // the positions change
  const root = new THREE.Group();
  root.add(mesh, lines);
  const scene = new THREE.Scene();
  const light = new THREE.DirectionalLight(0xffffff, 2.1);
  scene.add(root, new THREE.AmbientLight(0xffffff, 1.3), light, light.target);
  return { scene, root, light, geometry, positions, colors, lines };
}
