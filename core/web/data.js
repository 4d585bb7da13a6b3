// What the page holds: tables of numbers, and the planes of pictures, as browsers decode them.

// With "var", as `now` is, for whoever drives the page from outside
var page = JSON.parse(document.getElementById("data").textContent);
const LINES = 81; // wavelengths, 380 to 780 nm
let numbers;

// Base 85: five characters for four bytes, as Python's base64.b85encode writes them, but "," for "<".
const DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;,=>?@^_`{|}~";
const DIGIT = new Uint8Array(128);
[...DIGITS].forEach((character, value) => (DIGIT[character.charCodeAt(0)] = value));

function bytesOf(element) {
  const text = element.textContent.trim();
  const length = Math.floor((text.length * 4) / 5);
  const words = new DataView(new ArrayBuffer(4 * Math.ceil(text.length / 5)));
  for (let at = 0, word = 0; at < text.length; at += 5, word += 4) {
    let value = 0;
    for (let i = 0; i < 5; i++) value = value * 85 + (at + i < text.length ? DIGIT[text.charCodeAt(at + i)] : 84);
    words.setUint32(word, value);
  }
  return new Uint8Array(words.buffer, 0, length);
}

async function readNumbers() {
  const packed = new Blob([bytesOf(document.getElementById("numbers"))]).stream();
  const bytes = new Uint8Array(await new Response(packed.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
  // Three bytes of each, the first ones of all before the second: numbers of 24 bits
  const count = bytes.length / 3;
  const words = new Uint32Array(count);
  for (let i = 0; i < count; i++) words[i] = (bytes[i] << 8) | (bytes[count + i] << 16) | (bytes[2 * count + i] << 24);
  numbers = new Float32Array(words.buffer);
}

// The numbers that [first, ...shape] in the data stand for, flat.
function table([first, ...shape]) {
  return numbers.subarray(first, first + shape.reduce((product, size) => product * size, 1));
}

function plane(number) {
  const file = new Blob([bytesOf(document.getElementById("plane" + number))], { type: "image/avif" });
  return createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
}

// A frame of a picture, ready for a renderer: of each light group bitmaps, tables, basis (p, p - 1) and floor.
async function readFrame(picture, number) {
  const frame = picture.frames[number];
  const groups = await Promise.all(
    frame.groups.map(async (group) => ({
      bitmaps: await Promise.all(group.planes.map(plane)),
      tables: table(group.tables),
      basis: table(group.basis),
      floor: group.floor,
    }))
  );
  return { size: picture.size, groups, alpha: frame.alpha === null ? null : await plane(frame.alpha) };
}
