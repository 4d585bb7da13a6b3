// A mix and its arithmetic: matrices of lamps, white balance, and the words that say a mix.

const XYZ_TO_RGB = page.xyzToRgb; // of the display, row by row
const WHITE = page.white;
const KINDS = ["lamp", "planckian", "daylight", "blend"];

const times = (a, b) => [0, 3, 6].flatMap((r) => [0, 1, 2].map((c) => a[r] * b[c] + a[r + 1] * b[c + 3] + a[r + 2] * b[c + 6]));
const onto = (m, v) => [0, 3, 6].map((r) => m[r] * v[0] + m[r + 1] * v[1] + m[r + 2] * v[2]);

function inverse([a, b, c, d, e, f, g, h, i]) {
  const cofactors = [e * i - f * h, c * h - b * i, b * f - c * e, f * g - d * i, a * i - c * g, c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d];
  const determinant = a * cofactors[0] + b * cofactors[3] + c * cofactors[6];
  return cofactors.map((value) => value / determinant);
}

function renderedMix(picture) {
  return {
    lights: picture.groups.map((group) => ({
      kind: "lamp", lamp: group.lamp, kelvin: 3200, parts: [], stops: Math.log2(group.gain || 1), solo: false, mute: group.gain === 0,
    })),
    white: picture.whiteBalance, method: picture.method, exposure: 0, observer: picture.observer,
  };
}

const copyOf = (mix) => structuredClone(mix);

function gainsOf(mix) {
  const solo = mix.lights.some((light) => light.solo);
  return mix.lights.map((light) => (light.mute || (solo && !light.solo) ? 0 : 2 ** light.stops));
}

// Where a temperature lies among those that the page knows: the one before, and how far to the next.
function between(kind, kelvin) {
  const mireds = table(page.kinds[kind].mireds);
  const at = ((1e6 / kelvin - mireds[0]) / (mireds.at(-1) - mireds[0])) * (mireds.length - 1);
  const first = Math.max(0, Math.min(mireds.length - 2, Math.floor(at)));
  return [first, Math.max(0, Math.min(1, at - first))];
}

// Adds up blocks of `size` numbers, [[block, weight], ...], of a table.
function sumOf(values, size, weighted, from = 0) {
  const sum = new Float64Array(size);
  for (const [block, weight] of weighted)
    for (let i = 0; i < size; i++) sum[i] += weight * values[from + block * size + i];
  return sum;
}

function weightsOf(light) {
  if (light.kind === "blend") {
    const total = light.parts.reduce((sum, part) => sum + part.weight, 0);
    return light.parts.map((part) => [part.lamp, total > 0 ? part.weight / total : 1 / light.parts.length]);
  }
  if (light.kind === "lamp") return [[light.lamp, 1]];
  const [first, part] = between(light.kind, light.kelvin);
  return [[first, 1 - part], [first + 1, part]];
}

// (3, p): coefficients to XYZ under a light.
function matrixOf(model, light, observer) {
  const [known, size] = [["lamp", "blend"].includes(light.kind) ? model.lamps : model[light.kind], 3 * model.channels];
  return sumOf(table(known), size, weightsOf(light), observer * known[2] * size);
}

// (81): power of a light, scaled so that a white has Y = 1.
function powerOf(light) {
  const known = ["lamp", "blend"].includes(light.kind) ? page.lampPower : page.kinds[light.kind].power;
  return sumOf(table(known), LINES, weightsOf(light));
}

// XYZ that a white surface has under a matrix (3, p): the sums of its rows.
function whiteUnder(matrix) {
  const p = matrix.length / 3;
  return [0, 1, 2].map((row) => matrix.subarray(row * p, row * p + p).reduce((sum, value) => sum + value, 0));
}

// XYZ (3, 3) with `white` moved to the display's; null where this light has too little of a cone's part to be balanced.
function adaptation(white, degree, method) {
  const cone = page.adaptations[method];
  const [from, to] = [onto(cone, white.map((v) => v / white[1])), onto(cone, WHITE)];
  if (from.some((v) => !(v > 0))) return null;
  const [g, h, i] = to.map((v, k) => (degree * v) / from[k] + 1 - degree);
  const matrix = times(inverse(cone), times([g, 0, 0, 0, h, 0, 0, 0, i], cone));
  const kept = white[1] / onto(matrix, white)[1];
  return matrix.map((v) => v * kept);
}

// All that a renderer needs of a mix: matrices and gains of groups, and one matrix from XYZ to what the display takes.
function lightingOf(picture, mix) {
  const model = page.models[picture.model];
  const matrices = mix.lights.map((light) => matrixOf(model, light, mix.observer));
  const gains = gainsOf(mix);
  const lut = picture.view.lut === null ? null : page.luts[picture.view.lut];
  let display = lut ? lut.matrix : XYZ_TO_RGB;
  let problem = "";
  if (mix.white > 0) {
    let white = picture.white;
    if (!white) {
      white = [0, 0, 0];
      matrices.forEach((matrix, g) => whiteUnder(matrix).forEach((v, k) => (white[k] += gains[g] * v)));
      if (!(white[1] > 0)) white = WHITE;
    }
    const balance = adaptation(white, mix.white, mix.method);
    if (balance) display = times(display, balance);
    else problem = "unbalanced";
  }
  const brighter = 2 ** (picture.view.exposure + mix.exposure);
  return { matrices, gains, display: display.map((v) => v * brighter), lut, gamma: picture.view.gamma, problem };
}

// A plain decimal number: six digits that count, no exponent.
const plain = (value) => (value === 0 ? "0" : String(Number(value.toPrecision(6))).includes("e") ? value.toFixed(9) : String(Number(value.toPrecision(6))));

function lampWords(light) {
  if (light.kind === "planckian") return `Planckian ${Math.round(light.kelvin)} K`;
  if (light.kind === "daylight") return `D ${Math.round(light.kelvin)} K`;
  if (light.kind === "lamp") return page.lamps[light.lamp].name;
  return JSON.stringify(light.parts.map((part) => [page.lamps[part.lamp].name, Number(part.weight.toFixed(3))]));
}

// GROUP=ILLUMINANT*GAIN of each light group, as `relume relight --light` takes it.
function wordsOf(picture, mix, gains = gainsOf(mix)) {
  return mix.lights.map((light, g) => `${picture.groups[g].name}=${lampWords(light)}*${plain(gains[g])}`);
}

const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

// The command line that makes this picture, and what of the mix it cannot say.
function commandOf(picture, mix) {
  const gains = gainsOf(mix);
  const unsaid = new Set();
  const said = wordsOf(picture, mix, gains).filter((_, g) => {
    const [light, group] = [mix.lights[g], picture.groups[g]];
    const own = page.lamps[group.lamp];
    if (light.kind === "blend" && light.parts.some((part) => page.lamps[part.lamp].own)) unsaid.add("own");
    else if (light.kind === "lamp" && page.lamps[light.lamp].own && light.lamp !== group.lamp) unsaid.add("own");
    else if (own.own && light.kind === "lamp" && Math.abs(gains[g] - group.gain) > 1e-6) unsaid.add("own");
    else return !(light.kind === "lamp" && own.own && light.lamp === group.lamp);
    return false;
  });
  if (mix.exposure) unsaid.add("exposure");
  if (mix.observer !== picture.observer) unsaid.add("observer");
  const words = said.length ? ["--light", ...said.map(quoted)] : [];
  return { words: [...words, "--white", plain(mix.white)].join(" "), unsaid: [...unsaid] };
}

// The mix in the address, and back; names that the page does not know leave what is there.
function hashOf(picture, mix) {
  const said = new URLSearchParams();
  if (page.pictures.length > 1) said.set("picture", picture.name);
  wordsOf(picture, mix, mix.lights.map((light) => 2 ** light.stops)).forEach((words) => said.append("light", words));
  for (const state of ["solo", "mute"])
    mix.lights.forEach((light, g) => light[state] && said.append(state, picture.groups[g].name));
  said.set("white", plain(mix.white));
  if (mix.method !== "bradford") said.set("method", mix.method);
  if (mix.exposure) said.set("exposure", plain(mix.exposure));
  if (mix.observer !== picture.observer) said.set("observer", page.observers[mix.observer]);
  return said.toString();
}

const inRange = (text, low, high, otherwise) => {
  const value = Number(text);
  return text !== null && text !== "" && value >= low && value <= high ? value : otherwise;
};

function lightFrom(words, light) {
  const temperature = /^(Planckian|D) (\d+(?:\.\d+)?) K$/.exec(words);
  const lamp = page.lamps.findIndex((each) => each.name === words);
  if (lamp >= 0) return Object.assign(light, { kind: "lamp", lamp });
  if (temperature) {
    const kind = temperature[1] === "D" ? "daylight" : "planckian";
    const [low, high] = page.kinds[kind].range;
    return Object.assign(light, { kind, kelvin: Math.min(high, Math.max(low, Number(temperature[2]))) });
  }
  let parts;
  try { parts = JSON.parse(words); } catch { return light; }
  if (!Array.isArray(parts)) return light;
  parts = parts.filter(Array.isArray).slice(0, 6).map(([name, weight]) => ({
    lamp: page.lamps.findIndex((each) => each.name === name), weight: inRange(weight, 0, 1, 0),
  })).filter((part) => part.lamp >= 0);
  return parts.length ? Object.assign(light, { kind: "blend", parts }) : light;
}

function mixFrom(hash, picture) {
  const said = new URLSearchParams(hash.replace(/^#/, ""));
  const mix = renderedMix(picture);
  const group = (name) => mix.lights[picture.groups.findIndex((each) => each.name === name)];
  for (const words of said.getAll("light")) {
    const found = picture.groups.find((each) => words.startsWith(each.name + "="));
    const star = words.lastIndexOf("*");
    if (!found || star < 0) continue;
    const light = lightFrom(words.slice(found.name.length + 1, star), group(found.name));
    const gain = inRange(words.slice(star + 1), 0, 1e6, 1);
    light.mute = gain === 0;
    light.stops = gain > 0 ? Math.log2(gain) : 0;
  }
  for (const state of ["solo", "mute"])
    for (const name of said.getAll(state)) if (group(name)) group(name)[state] = true;
  mix.white = inRange(said.get("white"), 0, 1, mix.white);
  mix.exposure = inRange(said.get("exposure"), -10, 10, 0);
  if (page.adaptations[said.get("method")]) mix.method = said.get("method");
  if (page.observers.includes(said.get("observer"))) mix.observer = page.observers.indexOf(said.get("observer"));
  return mix;
}

// Weights of a blend from the place of the handle on the light dial: Wachspress coordinates, as in `core/mixing.py`.
function anchors(count) {
  return Array.from({ length: count }, (_, i) => [Math.sin((2 * Math.PI * i) / count), Math.cos((2 * Math.PI * i) / count)]);
}

function dialWeights([x, y], count) {
  if (count === 1) return [1];
  if (count === 2) { const up = Math.max(0, Math.min(1, (y + 1) / 2)); return [up, 1 - up]; }
  const corners = anchors(count);
  const inside = Math.cos(Math.PI / count);
  const normals = corners.map(([a, b], i) => {
    const [c, d] = corners[(i + 1) % count];
    return [(a + c) / 2 / inside, (b + d) / 2 / inside];
  });
  const reach = Math.max(1, ...normals.map(([a, b]) => (a * x + b * y) / inside));
  const far = normals.map(([a, b]) => { const d = inside - (a * x + b * y) / reach; return d < 1e-12 ? 0 : d; });
  const products = corners.map((_, i) => far.reduce((all, d, j) => (j === i || j === (i + count - 1) % count ? all : all * d), 1));
  const total = products.reduce((a, b) => a + b, 0);
  return products.map((v) => v / total);
}

function dialHandle(weights) {
  const total = weights.reduce((a, b) => a + b, 0) || 1;
  return anchors(weights.length).reduce(([x, y], [a, b], i) => [x + (a * weights[i]) / total, y + (b * weights[i]) / total], [0, 0]);
}
