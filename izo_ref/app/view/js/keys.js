// Keys, and the table that lists them.

/**
 * Listen to keys, and fill the table of the help.
 *
 * @param {{keys: string[], shown?: string, what?: string, onStage?: boolean, run: () => void}[]} shortcuts
 *     What each key does; those without `shown` are not listed, those `onStage` need the 3D view.
 * @param {HTMLTableElement} table Where they are listed.
 */
export function listen(shortcuts, table) {
  const byKey = new Map(shortcuts.flatMap((shortcut) => shortcut.keys.map((key) => [key, shortcut])));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const { target } = event;
    const isOwn = target.closest("select, summary, a"); // these use letters or space themselves
    const pressed = event.key === " " && target.closest("button, input:not([type=range])");
    const onStage = target.id === "canvas" || target === document.body;
    const shortcut = byKey.get(event.key.length === 1 ? event.key.toLowerCase() : event.key);
    if (isOwn || pressed || !shortcut || (shortcut.onStage && !onStage)) return;
    event.preventDefault();
    shortcut.run();
  });
  const others = [
    ["Drag", "turn; with the right button, or with Shift: move"],
    ["Wheel, or two fingers", "zoom toward the pointer"],
    ["Tab", "go to the next control; arrow keys move a slider or the list"],
  ];
  const listed = shortcuts.filter((shortcut) => shortcut.shown).map(({ shown, what }) => [shown, what]);
  for (const [shown, what] of [...listed, ...others]) {
    const row = table.insertRow();
    const key = document.createElement("kbd");
    key.textContent = shown;
    row.insertCell().append(key);
    row.insertCell().textContent = what;
  }
}
