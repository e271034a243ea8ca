// The list of pairs: only the rows that can be seen are in the page, so that it may be long.
import { css, timeColor } from "izo/colors";
import { KINDS, sidesOf } from "izo/model";

const SPARE = 4; // rows above and below those that can be seen

/** Say which pair it is, as HTML of two lines. Numbers and our own words need no escaping. */
function rowHtml(entry, theme) {
  const { pairs, row, sideName } = entry;
  const kind = KINDS[pairs.kinds[row]];
  const [first, second] = sidesOf(pairs, row).map((nodes) => nodes.join(" "));
  const time = pairs.times[row];
  const when = Number.isNaN(time) ? "cross" : `t = ${time.toFixed(6)}`;
  const dot = `<span class="dot" style="background:${css(timeColor(time, theme))}"></span>`;
  return `${dot}${kind.first} ${first} · ${kind.second} ${second}<br><small>${when}, ${sideName}</small>`;
}

/** Say which pair it is, for the line below the list. */
export function describe(entry) {
  const kind = KINDS[entry.pairs.kinds[entry.row]];
  const [first, second] = sidesOf(entry.pairs, entry.row).map((nodes) => nodes.join(" "));
  return [`${kind.first} ${first}`, `${kind.second} ${second}`];
}

export class PairList {
  /**
   * @param {HTMLElement} box The listbox; it has one element inside, which is as high as all rows.
   * @param {(index: number) => void} onSelect Is called when a row is chosen.
   */
  constructor(box, onSelect) {
    this.box = box;
    this.inside = box.firstElementChild;
    this.onSelect = onSelect;
    this.entries = [];
    this.selected = -1;
    box.addEventListener("scroll", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(box);
    box.addEventListener("click", (event) => {
      const row = event.target.closest("[data-index]");
      if (row) this.choose(Number(row.dataset.index));
    });
    box.addEventListener("keydown", (event) => {
      const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10, Home: -Infinity, End: Infinity };
      if (!(event.key in steps) && event.key !== "Enter") return;
      event.preventDefault();
      event.stopPropagation();
      this.choose(this.selected + (steps[event.key] ?? 0));
    });
  }

  /** Show these entries: `{pairs, row, side, sideName}` each. */
  show(entries, theme) {
    this.entries = entries;
    this.theme = theme;
    this.selected = -1;
    this.box.scrollTop = 0;
    this.draw();
  }

  /** Select a row, bring it into view, and tell. */
  choose(index) {
    if (!this.entries.length) return;
    this.selected = Math.min(Math.max(index, 0), this.entries.length - 1);
    const height = this.rowHeight();
    const top = this.selected * height;
    const view = this.box;
    if (top < view.scrollTop) view.scrollTop = top;
    if (top + height > view.scrollTop + view.clientHeight) view.scrollTop = top + height - view.clientHeight;
    this.draw();
    this.onSelect(this.selected);
  }

  rowHeight() {
    return 2.6 * parseFloat(getComputedStyle(document.documentElement).fontSize); // as in page.css
  }

  draw() {
    const height = this.rowHeight();
    this.inside.style.height = `${this.entries.length * height}px`;
    const first = Math.max(Math.floor(this.box.scrollTop / height) - SPARE, 0);
    const last = Math.min(Math.ceil((this.box.scrollTop + this.box.clientHeight) / height) + SPARE, this.entries.length);
    const rows = [];
    for (let i = first; i < last; i += 1) {
      const row = document.createElement("div");
      row.id = `pair-${i}`;
      row.dataset.index = i;
      row.style.top = `${i * height}px`;
      row.setAttribute("role", "option");
      row.setAttribute("aria-selected", String(i === this.selected));
      row.setAttribute("aria-setsize", this.entries.length);
      row.setAttribute("aria-posinset", i + 1);
      row.innerHTML = rowHtml(this.entries[i], this.theme);
      rows.push(row);
    }
    this.inside.replaceChildren(...rows);
    this.inside.dataset.empty = this.entries.length ? "" : "No pairs here.";
    if (this.selected >= 0) this.box.setAttribute("aria-activedescendant", `pair-${this.selected}`);
    else this.box.removeAttribute("aria-activedescendant");
  }
}
