"""Scripts that tests run in the page of a view, in front of their own."""

SLIDE = """
const set = async (id, value) => {
  const slider = document.getElementById(id);
  slider.value = value;
  slider.dispatchEvent(new Event("input", {bubbles: true}));
  await wait(100);
};
const shown = () => view.stage.sides.map((side) => [...side.positions]);
"""
# Pixels of the canvas in colors, after it was drawn anew in the same task.
PIXELS = """
const pixels = () => {
  view.stage.drawNow();
  const source = view.stage.renderer.domElement;
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [source.width, source.height];
  const brush = copy.getContext("2d");
  brush.drawImage(source, 0, 0);
  return brush.getImageData(0, 0, copy.width, copy.height).data;
};
const painted = (left, right) => {
  const data = pixels();
  const width = view.stage.renderer.domElement.width;
  const corner = [data[0], data[1], data[2]].join();
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    const x = (i / 4) % width / width;
    if (x >= left && x < right && [data[i], data[i + 1], data[i + 2]].join() !== corner) count += 1;
  }
  return count;
};
"""
