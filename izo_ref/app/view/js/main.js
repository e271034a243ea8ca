// Start the page.
import { Controls } from "izo/controls";
import { loadModel } from "izo/model";

/**
 * Take settings from the address of the page, such as `#colors=pairs&layout=wipe&pair=3`.
 *
 * @param {Controls} controls The controls.
 * @param {URLSearchParams} wanted The settings.
 */
function apply(controls, wanted) {
  const oneOf = (name, known) => known.find((value) => value === wanted.get(name));
  const number = (name, most) => Math.min(Math.max(Number(wanted.get(name)) || 0, 0), most);
  const theme = oneOf("theme", ["light", "dark"]);
  const layout = oneOf("layout", ["both", "wipe", "before", "after"]);
  const mode = oneOf("colors", controls.modes.map((known) => known.id));
  if (theme) controls.setTheme(theme);
  if (layout && controls.model.sides.length === 2) controls.setLayout(layout);
  if (mode) controls.setMode(mode);
  if (wanted.has("frame")) controls.setFrame(Math.round(number("frame", controls.model.numbers.length - 1)));
  if (wanted.has("path")) controls.setTime(number("path", 1));
  if (wanted.has("edges")) document.getElementById("wire").click();
  if (wanted.has("pair")) controls.list.choose(Math.round(number("pair", Infinity)) - 1);
}

export async function start() {
  const loading = document.getElementById("loading");
  document.documentElement.dataset.theme = window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  try {
    const data = JSON.parse(document.getElementById("data").textContent);
    const model = await loadModel(data, (text) => {
      loading.textContent = text;
    });
    const controls = new Controls(model);
    apply(controls, new URLSearchParams(location.hash.slice(1)));
    window.izoView = controls; // for those who look at the page with its console
    loading.hidden = true;
    document.documentElement.dataset.ready = "true";
  } catch (error) {
    const reason = error.message.replace(/\.+$/, "");
    loading.textContent = `The 3D view cannot be shown: ${reason}. The report below has the figures.`;
    document.documentElement.dataset.ready = "failed";
    throw error;
  }
}
