// Turn the texts of the page into whole numbers; `pack.py` says how they were packed.

/**
 * Return the numbers of a text.
 *
 * @param {string} text What `pack` made: base64 of deflated bytes.
 * @param {number} width Numbers in a row.
 * @param {Int32Array} [base] The array from which the differences are; without it, the row before.
 * @returns {Promise<Int32Array>}
 */
export async function unpack(text, width, base) {
  const planes = await inflate(bytesOf(text));
  const n = planes.length / 4;
  const numbers = new Int32Array(n);
  for (let i = 0; i < n; i += 1) {
    const zigzag = planes[i] | (planes[n + i] << 8) | (planes[2 * n + i] << 16) | (planes[3 * n + i] << 24);
    const difference = (zigzag >>> 1) ^ -(zigzag & 1);
    const near = base ? base[i] : i >= width ? numbers[i - width] : 0;
    numbers[i] = near + difference; // an Int32Array wraps around at 2^32, as `pack` does
  }
  return numbers;
}

function bytesOf(text) {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i += 1) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
