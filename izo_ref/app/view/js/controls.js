// The controls of the page, and what each of them changes.
import { css, sideColors } from "izo/colors";
import { listen } from "izo/keys";
import { describe, PairList } from "izo/list";
import { Marks, placeOf } from "izo/marks";
import { positionsAt } from "izo/model";
import { legend, modesOf, paint } from "izo/paint";
import { Stage } from "izo/stage";

const PATH_SECONDS = 3; // of playing a path
const FITTED = 9; // frames that are put into view
const byId = (id) => document.getElementById(id);

export class Controls {
  constructor(model) {
    this.model = model;
    this.stage = new Stage(byId("canvas"), model);
    this.marks = this.stage.sides.map((side) => new Marks(side.root));
    this.list = new PairList(byId("list"), (index) => this.select(index));
    this.modes = modesOf(model);
    this.selected = null;
    this.playing = 0;
    const isDark = window.matchMedia("(prefers-color-scheme: dark)").matches;
    this.now = {
      frame: model.isStep ? 1 : 0,
      time: 1,
      mode: "parts",
      theme: isDark ? "dark" : "light",
      positions: this.stage.sides.map((side) => side.positions),
    };
    this.prepare();
    this.connect();
    listen(this.shortcuts(), byId("help-keys"));
    this.setTheme(this.now.theme);
    this.setLayout(model.sides.length === 2 ? "both" : "before");
    this.setUp(model.up === "z");
    this.setFrame(this.now.frame);
    this.showAll();
  }

  // Show the controls that this model needs, with its names.
  prepare() {
    const { model } = this;
    const [before, after] = model.sides.map((side) => side.name);
    byId("layouts").hidden = !after;
    for (const id of ["name-before", "label-before"]) byId(id).textContent = before;
    for (const id of ["name-after", "label-after"]) byId(id).textContent = after ?? "";
    byId("frame-row").hidden = byId("rate-row").hidden = model.isStep;
    const isWhole = model.numbers.every((number, i) => i === 0 || number === model.numbers[i - 1] + 1);
    byId("path-row").hidden = model.numbers.length < 2 || !isWhole;
    byId("path-name").textContent = model.isStep ? "Path" : "Way from the frame before";
    byId("play").hidden = model.numbers.length < 2;
    byId("frame").max = model.numbers.length - 1;
    byId("frame").disabled = model.numbers.length < 2;
    for (const [i, mode] of this.modes.entries()) {
      const label = document.createElement("label");
      label.innerHTML = `<input type="radio" name="mode" value="${mode.id}"><span>${mode.label}</span>`;
      label.firstChild.checked = i === 0;
      byId("modes").append(label);
    }
  }

  connect() {
    const on = (id, event, run) => byId(id).addEventListener(event, run);
    on("layouts", "change", (event) => this.setLayout(event.target.value));
    on("modes", "change", (event) => this.setMode(event.target.value));
    on("wire", "change", (event) => this.stage.setEdges(event.target.checked));
    on("points", "change", () => this.showMarks());
    on("cut", "change", (event) => this.setCut(event.target.checked));
    on("up", "change", (event) => this.setUp(event.target.checked));
    on("fit", "click", () => this.showAll());
    on("theme", "click", () => this.setTheme(this.now.theme === "dark" ? "light" : "dark"));
    on("help-button", "click", () => byId("help").showModal());
    on("wipe", "input", (event) => this.setSplit(Number(event.target.value)));
    on("frame", "input", (event) => this.setFrame(Number(event.target.value)));
    on("path", "input", (event) => this.setTime(Number(event.target.value)));
    on("play", "click", () => this.play(!this.playing));
  }

  shortcuts() {
    const click = (id) => () => byId(id).click();
    const layout = (name) => () => byId("layouts").hidden || this.setLayout(name);
    const turn = (key, across, along) => ({ keys: [key], onStage: true, run: () => this.stage.turn(across, along) });
    const turns = [turn("ArrowLeft", 1, 0), turn("ArrowRight", -1, 0), turn("ArrowUp", 0, 1), turn("ArrowDown", 0, -1)];
    const one = (shown, what, run, keys = [shown.toLowerCase()]) => ({ keys, shown, what, run });
    const modes = this.modes.map((mode, i) => one(String(i + 1), `color: ${mode.label}`, () => this.setMode(mode.id)));
    const all = [
      one("Space", "play or stop", () => byId("play").hidden || this.play(!this.playing), [" "]),
      one(", and .", "one frame, or a hundredth of the path, back or on", () => this.step(-1), [","]),
      { keys: ["."], run: () => this.step(1) },
      one("N and P", "fly to the next or to the previous pair", () => this.list.choose(this.list.selected + 1), ["n"]),
      { keys: ["p"], run: () => this.list.choose(this.list.selected - 1) },
      one("A", "all in view", () => this.showAll()),
      one("B", "before and after beside each other", layout("both")),
      one("S", "before and after with a slider between them", layout("wipe")),
      one("X", "switch between before and after", () => this.exchange()),
      ...modes,
      one("E", "edges of the triangles", click("wire")),
      one("M", "marks of the pairs", click("points")),
      one("C", "cut away what is in front", click("cut")),
      one("U", "y or z points up", click("up")),
      one("D", "dark or light", click("theme")),
      one("Arrow keys", "turn, while the 3D view is focused", turns[0].run, []),
      ...turns,
      one("+ and −", "zoom", () => this.stage.zoom(0.85), ["+", "="]),
      { keys: ["-"], run: () => this.stage.zoom(1 / 0.85) },
      one("?", "this list", click("help-button")),
    ];
    return all;
  }

  setTheme(theme) {
    this.now.theme = theme;
    document.documentElement.dataset.theme = theme;
    byId("theme").textContent = theme === "dark" ? "Light" : "Dark";
    const [first, second] = sideColors(theme).map(css);
    document.documentElement.style.setProperty("--first", first);
    document.documentElement.style.setProperty("--second", second);
    this.stage.setTheme(theme);
    this.list.theme = theme;
    this.list.draw();
    this.repaint();
    this.showMarks();
  }

  setLayout(layout) {
    this.stage.layout = layout;
    byId("stage").dataset.layout = layout;
    const input = document.querySelector(`input[name=layout][value=${layout}]`);
    input.checked = true;
    byId("wipe").hidden = layout !== "wipe";
    byId("label-before").hidden = layout === "after";
    byId("label-after").hidden = layout === "before" || this.model.sides.length < 2;
    this.setSplit(layout === "wipe" ? Number(byId("wipe").value) : 0.5);
  }

  exchange() {
    if (this.model.sides.length === 2) this.setLayout(this.stage.layout === "before" ? "after" : "before");
  }

  setSplit(split) {
    this.stage.split = split;
    byId("stage").style.setProperty("--split", `${100 * split}%`);
    this.stage.draw();
  }

  setMode(mode) {
    this.now.mode = mode;
    document.querySelector(`input[name=mode][value=${mode}]`).checked = true;
    this.repaint();
  }

  setCut(isCut) {
    byId("cut").checked = this.stage.isCut = isCut;
    this.stage.draw();
  }

  setUp(isZ) {
    byId("up").checked = isZ;
    this.stage.setUp(isZ ? "z" : "y");
  }

  // Put the mesh into view, as it is in some frames from the first to the last.
  showAll() {
    this.setCut(false);
    const { sides, used, numbers } = this.model;
    const count = Math.min(numbers.length, FITTED);
    const chosen = Array.from({ length: count }, (_, i) => Math.round((i * (numbers.length - 1)) / Math.max(count - 1, 1)));
    this.stage.fit(used, sides.flatMap((side) => chosen.map((frame) => side.frames[frame])));
  }

  setFrame(frame) {
    this.now.frame = frame;
    byId("frame").value = frame;
    byId("frame-out").textContent = `${this.model.numbers[frame]} of ${this.model.numbers.at(-1)}`;
    byId("path").disabled = frame === 0;
    this.selected = null;
    byId("said").textContent = "";
    this.showList();
    this.setTime(1);
    this.showMarks();
  }

  setTime(time) {
    this.now.time = time;
    byId("path").value = time;
    byId("path-out").textContent = time.toFixed(3);
    this.model.sides.forEach((side, i) => {
      positionsAt(side, this.now.frame, time, this.now.positions[i]);
      this.stage.moved(i);
      this.marks[i].move(this.pairsOf(i), this.now.positions[i]);
    });
    this.drawSelected();
    if (this.now.mode === "resolving" || this.now.mode === "start") this.repaint();
  }

  // Colors that do not depend on the time are painted when the frame changes.
  repaint() {
    this.stage.sides.forEach((side, i) => {
      paint(this.model, this.now, i, side.colors);
      this.stage.painted(i);
    });
    byId("legend").innerHTML = legend(this.model, this.now);
  }

  pairsOf(side) {
    return this.model.sides[side].pairs[this.now.frame];
  }

  // List the pairs of this frame; what is wrong after resolving comes first.
  showList() {
    const entries = [];
    const counts = [];
    for (const [i, side] of [...this.model.sides.entries()].reverse()) {
      const pairs = this.pairsOf(i);
      counts.unshift(`${side.name} ${side.nPairs[this.now.frame].toLocaleString("en")}`);
      for (let row = 0; row < pairs.n; row += 1) entries.push({ pairs, row, side: i, sideName: side.name });
    }
    const what = this.model.isStep ? "Pairs that meet" : "Pairs that cross";
    byId("pairs-title").textContent = `${what}: ${counts.join(", ")}`;
    this.list.show(entries, this.now.theme);
  }

  showMarks() {
    const isShown = byId("points").checked;
    this.marks.forEach((marks, i) => {
      marks.points.visible = isShown;
      marks.show(this.pairsOf(i), this.now.positions[i], this.now.theme);
    });
    this.drawSelected();
    if (this.now.mode === "pairs") this.repaint();
    this.stage.draw();
  }

  // Fly to a pair of the list, at the time when it meets.
  select(index) {
    const entry = this.list.entries[index];
    this.play(false);
    this.selected = entry;
    const time = entry.pairs.times[entry.row];
    this.setTime(Number.isNaN(time) ? 1 : time);
    const isHidden = this.stage.layout === (entry.side ? "before" : "after");
    if (isHidden) this.exchange();
    this.setCut(true);
    const { center, size } = placeOf(entry.pairs, entry.row, this.now.positions[entry.side]);
    this.stage.fly(entry.side, center, size);
    const [first, second] = describe(entry);
    byId("said").innerHTML = `<span class="a">${first}</span>, <span class="b">${second}</span>`;
  }

  drawSelected() {
    const entry = this.selected;
    this.marks.forEach((marks, i) => {
      // the same vertices are drawn on the other side too, to see where they are there
      marks.select(entry?.pairs, entry ? entry.row : null, this.now.positions[i], this.now.theme);
    });
    this.stage.draw();
  }

  step(direction) {
    if (this.model.isStep) {
      this.setTime(Math.min(Math.max(this.now.time + 0.01 * direction, 0), 1));
    } else {
      this.setFrame(Math.min(Math.max(this.now.frame + direction, 0), this.model.numbers.length - 1));
    }
  }

  play(on) {
    this.playing = on ? this.playing + 1 || 1 : 0;
    byId("play").textContent = on ? "Stop" : "Play";
    if (!on) return;
    const run = this.playing;
    const rate = () => (this.model.isStep ? 1 / PATH_SECONDS : Number(byId("rate").value));
    let last = performance.now();
    let rest = 0;
    const go = (time) => {
      if (this.playing !== run) return;
      rest += (rate() * (time - last)) / 1000;
      last = time;
      if (this.model.isStep) {
        this.setTime(this.now.time >= 1 ? 0 : Math.min(this.now.time + rest, 1));
        rest = 0;
      } else if (rest >= 1) {
        this.setFrame((this.now.frame + Math.floor(rest)) % this.model.numbers.length);
        rest %= 1;
      }
      requestAnimationFrame(go);
    };
    requestAnimationFrame(go);
  }
}
