// What the page shows, unpacked: the mesh, its positions in each frame, and the pairs.
import { unpack } from "izo/unpack";

export const WIDTH = 6; // vertices of a row of pairs; `model.py` has the same number

// What the sides of each kind of pair are, and how many vertices the first side has.
export const KINDS = [
  { first: "vertex", split: 1, second: "face" },
  { first: "edge", split: 2, second: "edge" },
  { first: "edge", split: 2, second: "face" },
  { first: "face", split: 3, second: "face" },
];

/**
 * Unpack everything that the page holds.
 *
 * @param {object} data The JSON of the page (`page.py`).
 * @param {(text: string) => void} say Is called with a sentence as the work goes on.
 */
export async function loadModel(data, say) {
  const faces = new Uint32Array(await unpack(data.faces, 3));
  const partOf = await unpack(data.partOf, 1);
  const model = {
    isStep: data.isStep,
    up: data.up,
    radius: data.radius, // of the mesh, in the unit of the file; positions below are relative to it
    numbers: data.frames,
    parts: data.parts,
    n: partOf.length,
    nZones: data.nZones,
    faces,
    used: Int32Array.from(new Set(faces)), // vertices in faces
    partOf,
    pinned: await unpack(data.pinned, 1),
    zoneOf: data.zoneOf === null ? null : await unpack(data.zoneOf, 1),
    sides: data.sides.map((side) => ({ name: side.name, frames: [], pairs: [], nPairs: side.nPairs })),
  };
  const last = []; // whole numbers of the last frame of each side
  for (let frame = 0; frame < data.frames.length; frame += 1) {
    if (data.frames.length > 2) say(`Reading frame ${frame + 1} of ${data.frames.length} …`);
    for (const [i, side] of data.sides.entries()) {
      const whole = await unpack(side.positions[frame], 3, i ? last[0] : last[i]);
      last[i] = whole;
      model.sides[i].frames.push(Float32Array.from(whole, (number) => number / data.steps));
      model.sides[i].pairs.push(await loadPairs(side.pairs[frame], data.ticks));
    }
  }
  return Object.assign(model, largestMoves(model));
}

async function loadPairs(packed, ticks) {
  if (packed === null) return { n: 0, nodes: new Int32Array(0), kinds: [], times: [] };
  const nodes = await unpack(packed.nodes, WIDTH);
  const kinds = await unpack(packed.kinds, 1);
  const whole = await unpack(packed.times, 1);
  const times = Float64Array.from(whole, (tick) => (tick < 0 ? NaN : tick / ticks));
  return { n: kinds.length, nodes, kinds, times };
}

// The largest distances that the scales of the heat maps have to show, and how far positions reach
// from the centre along each axis.
function largestMoves(model) {
  const reach = [0, 0, 0];
  let byResolving = 0;
  let sinceStart = 0;
  const [before, after] = model.sides;
  for (let frame = 0; frame < model.numbers.length; frame += 1) {
    if (after) byResolving = Math.max(byResolving, largestDistance(before.frames[frame], after.frames[frame]));
    for (const side of model.sides) {
      sinceStart = Math.max(sinceStart, largestDistance(side.frames[frame], side.frames[0]));
      side.frames[frame].forEach((value, i) => {
        reach[i % 3] = Math.max(reach[i % 3], Math.abs(value));
      });
    }
  }
  return { byResolving, sinceStart, reach };
}

function largestDistance(a, b) {
  let largest = 0;
  for (let i = 0; i < a.length; i += 3) {
    const square = (a[i] - b[i]) ** 2 + (a[i + 1] - b[i + 1]) ** 2 + (a[i + 2] - b[i + 2]) ** 2;
    if (square > largest) largest = square;
  }
  return Math.sqrt(largest);
}

/**
 * Write the positions of a side at a time of the path to a frame.
 *
 * @param {object} side A side of the model.
 * @param {number} frame Index of the frame.
 * @param {number} time From 0, the frame before, to 1, the frame.
 * @param {Float32Array} out Where to write.
 */
export function positionsAt(side, frame, time, out) {
  const end = side.frames[frame];
  if (frame === 0 || time === 1) {
    out.set(end);
    return;
  }
  const start = side.frames[frame - 1];
  for (let i = 0; i < out.length; i += 1) out[i] = (1 - time) * start[i] + time * end[i];
}

/** Return the vertices of the first and of the second side of a pair. */
export function sidesOf(pairs, row) {
  const all = [...pairs.nodes.subarray(row * WIDTH, (row + 1) * WIDTH)].filter((node) => node >= 0);
  const { split } = KINDS[pairs.kinds[row]];
  return [all.slice(0, split), all.slice(split)];
}
