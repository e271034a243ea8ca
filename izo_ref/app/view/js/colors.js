// Colors. Lightness alone tells the values apart, so that the page can be read in grey as well.
// Colors are stated in OKLCH (lightness, chroma, hue), in which equal steps look equal.

// From little to much, as it looks on a light page; on a dark page, the scale is turned around, so
// that little is always close to the background.
const RAMP = [
  [0.93, 0.05, 95],
  [0.79, 0.13, 72],
  [0.63, 0.17, 40],
  [0.45, 0.16, 5],
  [0.27, 0.12, -50],
];
// The lightness of each differs from that of the others by at least 0.05.
const PARTS = [
  [0.58, 0.13, 255],
  [0.77, 0.13, 65],
  [0.47, 0.1, 155],
  [0.83, 0.08, 350],
  [0.41, 0.13, 300],
  [0.89, 0.1, 100],
  [0.66, 0.09, 200],
  [0.35, 0.07, 50],
];
const ZONE_LIGHTNESS = [0.55, 0.78, 0.42, 0.68, 0.86, 0.49];
const PINNED = [0.71, 0.008, 250];
const NEUTRAL = { light: [0.83, 0.004, 250], dark: [0.4, 0.006, 250] };
// The two sides of the selected pair: orange is light, blue is dark.
const SIDES = { light: [[0.72, 0.18, 55], [0.45, 0.2, 262]], dark: [[0.86, 0.15, 80], [0.6, 0.19, 258]] };

/** Return red, green and blue from 0 to 1, linear (as light adds up), of a color in OKLCH. */
export function linear([lightness, chroma, hue]) {
  const angle = (hue * Math.PI) / 180;
  const a = chroma * Math.cos(angle);
  const b = chroma * Math.sin(angle);
  // the inverse of OKLab (Ottosson 2020)
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map((value) => Math.min(Math.max(value, 0), 1));
}

/** Return a color for CSS. */
export function css([lightness, chroma, hue]) {
  const bytes = linear([lightness, chroma, hue]).map((value) => {
    const encoded = value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
    return Math.round(255 * encoded);
  });
  return `rgb(${bytes.join(" ")})`;
}

/** Return the color of a value from 0, little, to 1, much. */
export function ramp(value, theme) {
  const inside = Math.min(Math.max(value, 0), 1);
  const place = (theme === "dark" ? 1 - inside : inside) * (RAMP.length - 1);
  const i = Math.min(Math.floor(place), RAMP.length - 2);
  const part = place - i;
  return RAMP[i].map((number, k) => (1 - part) * number + part * RAMP[i + 1][k]);
}

/** Return the color of a time from 0 to 1: the earlier, the stronger. A pair at rest is strongest. */
export function timeColor(time, theme) {
  return ramp(Number.isNaN(time) ? 0.85 : 1 - 0.7 * time, theme);
}

export const partColor = (part) => PARTS[part % PARTS.length];
// 137.5 degrees between the hues of neighbours: the golden angle, which repeats late
export const zoneColor = (zone) => [ZONE_LIGHTNESS[zone % ZONE_LIGHTNESS.length], 0.13, (zone * 137.5 + 250) % 360];
export const pinnedColor = () => PINNED;
export const neutralColor = (theme) => NEUTRAL[theme];
export const sideColors = (theme) => SIDES[theme];
