// Marks in the 3D view: a point at each pair, and the pair that is selected.
import * as THREE from "three";
import { linear, sideColors, timeColor } from "izo/colors";
import { sidesOf, WIDTH } from "izo/model";
import { nearer } from "izo/stage";

const POINT = 5; // pixels
const LINE = 0.022; // radius of a drawn edge over the size of its pair
const DOT = 0.05; // radius of a drawn vertex, in the same way

/** Return centre and size of a pair at given positions. */
export function placeOf(pairs, row, positions) {
  const nodes = sidesOf(pairs, row).flat();
  const center = [0, 1, 2].map((k) => nodes.reduce((sum, v) => sum + positions[3 * v + k], 0) / nodes.length);
  const size = Math.max(
    ...nodes.map((v) => Math.hypot(...center.map((value, k) => positions[3 * v + k] - value))),
  );
  return { center, size };
}

/** The marks of one side. */
export class Marks {
  constructor(root) {
    this.points = new THREE.Points(
      new THREE.BufferGeometry(),
      nearer(new THREE.PointsMaterial({ size: POINT * Math.min(window.devicePixelRatio, 2), sizeAttenuation: false, vertexColors: true })),
    );
    this.points.frustumCulled = false;
    this.pair = new THREE.Group();
    root.add(this.points, this.pair);
  }

  /** Show the points of these pairs. */
  show(pairs, positions, theme) {
    const places = new Float32Array(3 * pairs.n);
    const colors = new Float32Array(3 * pairs.n);
    // times in hundredths: no more colors than the eye tells apart
    const shades = Array.from({ length: 101 }, (_, i) => linear(timeColor(i / 100, theme)));
    const atRest = linear(timeColor(NaN, theme));
    for (let i = 0; i < pairs.n; i += 1) {
      colors.set(shades[Math.round(100 * pairs.times[i])] ?? atRest, 3 * i);
    }
    this.points.geometry.dispose();
    this.points.geometry = new THREE.BufferGeometry();
    this.points.geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
    this.points.geometry.setAttribute("color", new THREE.BufferAttribute(colors, 3));
    this.move(pairs, positions);
  }

  /** Put each point into the middle of the vertices of its pair. */
  move(pairs, positions) {
    const attribute = this.points.geometry.getAttribute("position");
    if (!attribute) return;
    const places = attribute.array;
    for (let i = 0; i < pairs.n; i += 1) {
      let count = 0;
      places.fill(0, 3 * i, 3 * i + 3);
      for (let k = 0; k < WIDTH; k += 1) {
        const node = pairs.nodes[WIDTH * i + k];
        if (node < 0) continue;
        count += 1;
        for (let axis = 0; axis < 3; axis += 1) places[3 * i + axis] += positions[3 * node + axis];
      }
      for (let axis = 0; axis < 3; axis += 1) places[3 * i + axis] /= count;
    }
    attribute.needsUpdate = true;
  }

  /** Draw a pair over everything else; none if `row` is null. */
  select(pairs, row, positions, theme) {
    for (const object of [...this.pair.children]) {
      object.geometry.dispose();
      object.material.dispose();
      this.pair.remove(object);
    }
    if (row === null) return;
    const { size } = placeOf(pairs, row, positions);
    const point = (v) => new THREE.Vector3().fromArray(positions, 3 * v);
    sidesOf(pairs, row).forEach((nodes, i) => {
      const color = new THREE.Color().setRGB(...linear(sideColors(theme)[i]));
      const points = nodes.map(point);
      if (points.length === 1) this.pair.add(dot(points[0], DOT * size, color));
      if (points.length === 3) this.pair.add(face(points, color));
      const ends = points.length === 3 ? [[0, 1], [1, 2], [2, 0]] : points.length === 2 ? [[0, 1]] : [];
      for (const [a, b] of ends) this.pair.add(line(points[a], points[b], LINE * size, color));
      if (points.length === 2) for (const end of points) this.pair.add(dot(end, 1.3 * LINE * size, color));
    });
  }
}

function drawnLast(object, order) {
  object.renderOrder = order;
  object.frustumCulled = false;
  return object;
}

function overAll(color, opacity = 1) {
  return new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true, opacity, side: THREE.DoubleSide });
}

function dot(center, radius, color) {
  const ball = new THREE.Mesh(new THREE.SphereGeometry(radius, 20, 14), overAll(color));
  ball.position.copy(center);
  return drawnLast(ball, 3);
}

function line(from, to, radius, color) {
  const along = to.clone().sub(from);
  const tube = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, along.length(), 10), overAll(color));
  tube.position.copy(from).addScaledVector(along, 0.5);
  tube.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
  return drawnLast(tube, 2);
}

function face(points, color) {
  const geometry = new THREE.BufferGeometry().setFromPoints(points);
  return drawnLast(new THREE.Mesh(geometry, overAll(color, 0.45)), 1);
}
