// Ways to color the mesh, and the legend of each.
import { css, linear, neutralColor, partColor, pinnedColor, ramp, timeColor, zoneColor } from "izo/colors";
import { WIDTH } from "izo/model";

const NAMED = 8; // parts that the legend names

/** Return the ways to color this model, each with `id` and `label`. */
export function modesOf(model) {
  const hasPairs = model.sides.some((side) => side.pairs.some((pairs) => pairs.n));
  return [
    { id: "parts", label: "Parts", shown: true },
    { id: "pairs", label: model.isStep ? "Impacts by time" : "Crossings", shown: hasPairs },
    { id: "zones", label: "Zones", shown: model.zoneOf !== null && model.nZones > 0 },
    { id: "resolving", label: "Moved by resolving", shown: model.sides.length === 2 },
    { id: "start", label: "Moved since start", shown: model.numbers.length > 1 },
  ].filter((mode) => mode.shown);
}

/**
 * Color the vertices of one side.
 *
 * @param {object} model The model.
 * @param {object} now What is shown: mode, theme, frame, positions of each side.
 * @param {number} side Index of the side.
 * @param {Float32Array} out (n, 3), colors in linear light.
 */
export function paint(model, now, side, out) {
  const colors = { parts: paintParts, pairs: paintPairs, zones: paintZones, resolving: paintMoves, start: paintMoves };
  colors[now.mode](model, now, side, out);
}

function paintEach(model, out, colorOf) {
  const known = new Map();
  for (let v = 0; v < model.n; v += 1) {
    const key = colorOf.key(v);
    if (!known.has(key)) known.set(key, linear(colorOf.color(key)));
    out.set(known.get(key), 3 * v);
  }
}

function paintParts(model, now, side, out) {
  const key = (v) => (model.pinned[v] ? -1 : model.partOf[v]);
  paintEach(model, out, { key, color: (part) => (part < 0 ? pinnedColor() : partColor(part)) });
}

function paintZones(model, now, side, out) {
  const color = (zone) => (zone < 0 ? neutralColor(now.theme) : zoneColor(zone));
  paintEach(model, out, { key: (v) => model.zoneOf[v], color });
}

function paintPairs(model, now, side, out) {
  const pairs = model.sides[side].pairs[now.frame];
  const earliest = new Float64Array(model.n).fill(Infinity);
  for (let i = 0; i < pairs.nodes.length; i += 1) {
    const node = pairs.nodes[i];
    const time = pairs.times[Math.floor(i / WIDTH)];
    if (node >= 0) earliest[node] = Math.min(earliest[node], Number.isNaN(time) ? -1 : time);
  }
  // times in hundredths: no more colors than the eye tells apart
  const key = (v) => (earliest[v] === Infinity ? 2 : Math.round(100 * earliest[v]) / 100);
  const color = (time) => (time === 2 ? neutralColor(now.theme) : timeColor(time < 0 ? NaN : time, now.theme));
  paintEach(model, out, { key, color });
}

const SHADES = 255; // of a heat map
function paintMoves(model, now, side, out) {
  const shades = Array.from({ length: SHADES + 1 }, (_, i) => linear(ramp(i / SHADES, now.theme)));
  const own = now.positions[side];
  const other = now.mode === "resolving" ? now.positions[1 - side] : model.sides[side].frames[0];
  const largest = (now.mode === "resolving" ? model.byResolving : model.sinceStart) || 1;
  for (let i = 0; i < own.length; i += 3) {
    const square = (own[i] - other[i]) ** 2 + (own[i + 1] - other[i + 1]) ** 2 + (own[i + 2] - other[i + 2]) ** 2;
    out.set(shades[Math.min(Math.round((SHADES * Math.sqrt(square)) / largest), SHADES)], i);
  }
}

/** Return the legend of what is shown, as HTML made of our own words and escaped names. */
export function legend(model, now) {
  const { theme } = now;
  const swatch = (color, text) => `<li><i style="background:${css(color)}"></i>${escaped(text)}</li>`;
  if (now.mode === "parts") {
    const free = new Set(model.partOf.filter((part, v) => !model.pinned[v]));
    const named = model.parts.map((name, i) => [name, i]).filter(([, i]) => free.has(i));
    const items = named.slice(0, NAMED).map(([name, i]) => swatch(partColor(i), name));
    if (named.length > NAMED) items.push(`<li>and ${named.length - NAMED} more parts</li>`);
    if (model.pinned.some(Boolean)) items.push(swatch(pinnedColor(), "pinned"));
    return `<ul>${items.join("")}</ul>`;
  }
  if (now.mode === "zones") {
    const text = `${model.nZones} ${model.nZones === 1 ? "zone" : "zones"}; a color may stand for several`;
    return `<div>${text}</div><ul>${swatch(neutralColor(theme), "in no zone")}</ul>`;
  }
  if (now.mode === "pairs" && !model.isStep) {
    return `<ul>${swatch(timeColor(NaN, theme), "vertices of pairs that cross")}${swatch(neutralColor(theme), "others")}</ul>`;
  }
  if (now.mode === "pairs") {
    const scale = rampBar((value) => timeColor(value, theme), "t = 0", "t = 1");
    return `<div>When vertices first meet something</div>${scale}<ul>${swatch(neutralColor(theme), "never")}</ul>`;
  }
  const byResolving = now.mode === "resolving";
  const largest = (byResolving ? model.byResolving : model.sinceStart) * model.radius;
  const title = byResolving ? "Distance between before and after" : "Distance from the start";
  return `<div>${title}</div>${rampBar((value) => ramp(value, theme), "0", lengthText(largest, model))}`;
}

function rampBar(colorOf, low, high) {
  const stops = Array.from({ length: 17 }, (_, i) => css(colorOf(i / 16))).join(",");
  return `<div class="ramp" style="background:linear-gradient(to right,${stops})"></div><div class="ends"><span>${low}</span><span>${high}</span></div>`;
}

function lengthText(length, model) {
  return `${Number(length.toPrecision(3))} ${model.isStep ? "m" : "(unit of the file)"}`;
}

function escaped(text) {
  const box = document.createElement("span");
  box.textContent = text;
  return box.innerHTML;
}
