// The renderer without a GPU: the same two steps in plain loops.

const DRAFT = 5e5; // pixels that are drawn at once on any machine
const NOTHING = new Float32Array(256);

function cpuRenderer(canvas) {
  const context = canvas.getContext("2d");
  const encode = (value) => (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);
  const encoded = Float32Array.from({ length: 65536 }, (_, i) => 255 * encode(i / 65535));
  let frame, full, draft;

  function bytes(bitmap) {
    const paper = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d", { willReadFrequently: true });
    paper.drawImage(bitmap, 0, 0);
    const four = paper.getImageData(0, 0, bitmap.width, bitmap.height).data;
    bitmap.close();
    const one = new Uint8Array(four.length / 4);
    for (let i = 0; i < one.length; i++) one[i] = four[4 * i];
    return one;
  }

  // What is drawn: every pixel, or, as long as someone drags a slider, every nth in both directions.
  function level([width, height], planes, coverage, every) {
    const size = [Math.ceil(width / every), Math.ceil(height / every)];
    const thinned = (plane) => {
      if (every === 1) return plane;
      const thin = new Uint8Array(size[0] * size[1]);
      for (let y = 0, i = 0; y < size[1]; y++) for (let x = 0; x < size[0]; x++, i++) thin[i] = plane[y * every * width + x * every];
      return thin;
    };
    const groups = planes.map((group) => group.map(thinned));
    const total = new Float32Array(size[0] * size[1]);
    groups.forEach(([bright], g) => { const means = frame.groups[g].tables; for (let i = 0; i < total.length; i++) total[i] += means[bright[i]]; });
    const scales = groups.map(([bright], g) => {
      const { tables, floor } = frame.groups[g];
      return total.map((sum, i) => tables[bright[i]] + floor + page.shared * sum);
    });
    const paper = every === 1 ? context : new OffscreenCanvas(...size).getContext("2d");
    return { size, every, groups, scales, coverage: coverage && thinned(coverage), paper, image: paper.createImageData(...size), kept: [] };
  }

  function load(read) {
    frame = read;
    [canvas.width, canvas.height] = frame.size;
    const planes = frame.groups.map((group) => group.bitmaps.map(bytes));
    const coverage = frame.alpha ? bytes(frame.alpha) : null;
    const every = Math.ceil(Math.sqrt((canvas.width * canvas.height) / DRAFT));
    full = level(frame.size, planes, coverage, 1);
    draft = every > 1 ? level(frame.size, planes, coverage, every) : full;
  }

  // Writes XYZ of a light group, pixel after pixel; row by row, so that what is worked on stays in the cache.
  function relight(xyz, { size: [width, height] }, planes, scale, group, matrix) {
    const [white, axes] = [whiteUnder(matrix), axesUnder(matrix, group.basis)];
    const means = (k) => (k < planes.length ? group.tables.subarray(256 * k, 256 * k + 256) : NOTHING);
    for (let start = 0; start < width * height; start += width) {
      const row = xyz.subarray(3 * start, 3 * (start + width)).fill(0);
      const bytes = (k) => planes[Math.min(k, planes.length - 1)].subarray(start, start + width);
      for (let k = 1; k < planes.length; k += 4) {
        const weights = axes.subarray(3 * k - 3, 3 * k + 9);
        add(row, bytes(k), bytes(k + 1), bytes(k + 2), bytes(k + 3), means(k), means(k + 1), means(k + 2), means(k + 3), ...weights, ...NOTHING.subarray(weights.length, 12));
      }
      finish(row, bytes(0), means(0), scale.subarray(start, start + width), ...white);
    }
  }

  // Four planes at once: the row goes through memory a quarter as often.
  function add(row, one, two, three, four, m, n, o, p, a, b, c, d, e, f, g, h, i, j, k, l) {
    for (let x = 0, at = 0; x < one.length; x++, at += 3) {
      const u = m[one[x]], v = n[two[x]], w = o[three[x]], z = p[four[x]];
      row[at] += a * u + d * v + g * w + j * z;
      row[at + 1] += b * u + e * v + h * w + k * z;
      row[at + 2] += c * u + f * v + i * w + l * z;
    }
  }

  function finish(row, plane, means, scale, a, b, c) {
    for (let i = 0, j = 0; i < plane.length; i++, j += 3) {
      const brightness = means[plane[i]];
      const times = scale[i];
      row[j] = brightness * a + times * row[j];
      row[j + 1] = brightness * b + times * row[j + 1];
      row[j + 2] = brightness * c + times * row[j + 2];
    }
  }

  function update(shown, side, matrices) {
    const kept = (shown.kept[side] ??= { xyz: [], matrices: [] });
    shown.groups.forEach((planes, g) => {
      const before = kept.matrices[g];
      if (before && before.every((value, i) => value === matrices[g][i])) return;
      kept.matrices[g] = matrices[g];
      kept.xyz[g] ??= new Float32Array(3 * planes[0].length);
      relight(kept.xyz[g], shown, planes, shown.scales[g], frame.groups[g], matrices[g]);
    });
    return kept.xyz;
  }

  function sum(row, xyz, gain) {
    for (let j = 0; j < row.length; j++) row[j] += gain * xyz[j];
  }

  function toDisplay(row, [a, b, c, d, e, f, g, h, i]) {
    for (let j = 0; j < row.length; j += 3) {
      const x = row[j], y = row[j + 1], z = row[j + 2];
      row[j] = a * x + b * y + c * z;
      row[j + 1] = d * x + e * y + f * z;
      row[j + 2] = g * x + h * y + i * z;
    }
  }

  function put(row, power, picture, first) {
    for (let j = 0, k = 4 * first; j < row.length; j += 3, k += 4) {
      picture[k] = power[Math.max(0, Math.min(65535, row[j] * 65535 + 0.5)) | 0];
      picture[k + 1] = power[Math.max(0, Math.min(65535, row[j + 1] * 65535 + 0.5)) | 0];
      picture[k + 2] = power[Math.max(0, Math.min(65535, row[j + 2] * 65535 + 0.5)) | 0];
      picture[k + 3] = 255;
    }
  }

  const powers = new Map();

  function powerOf(gamma) {
    if (!powers.has(gamma)) powers.set(gamma, Uint8ClampedArray.from(encoded, (byte) => Math.round(255 * (byte / 255) ** (1 / gamma))));
    return powers.get(gamma);
  }

  // Writes the columns from..to of one mix into the picture.
  function paint({ size: [width, height], image: { data }, coverage }, { gains, display, lut, gamma }, xyz, from, to) {
    const throughLut = lut ? lutSampler(lut) : null;
    const row = new Float32Array(3 * (to - from));
    for (let line = 0; line < height; line++) {
      const first = line * width + from;
      row.fill(0);
      for (let g = 0; g < xyz.length; g++) if (gains[g]) sum(row, xyz[g].subarray(3 * first, 3 * (first + to - from)), gains[g]);
      toDisplay(row, display);
      if (coverage) for (let j = 0; j < row.length; j++) row[j] /= (coverage[first + Math.floor(j / 3)] || 255) / 255;
      if (throughLut) throughLut(row, data, 4 * first);
      else put(row, powerOf(gamma), data, first);
      if (coverage) for (let i = first; i < first + to - from; i++) data[4 * i + 3] = coverage[i];
    }
  }

  // quick: coarser where every pixel would take long.
  function draw(sides, wipe, quick) {
    const shown = quick ? draft : full;
    const width = shown.size[0];
    const edge = sides[1] ? Math.min(Math.round(wipe / shown.every), width) : width;
    paint(shown, sides[0], update(shown, 0, sides[0].matrices), 0, edge);
    if (sides[1]) paint(shown, sides[1], update(shown, 1, sides[1].matrices), edge, width);
    shown.paper.putImageData(shown.image, 0, 0);
    if (shown !== full) {
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.drawImage(shown.paper.canvas, 0, 0, shown.size[0] * shown.every, shown.size[1] * shown.every);
    }
    if (sides[1]) { context.fillStyle = "white"; context.fillRect(Math.min(wipe, canvas.width), 0, 1, canvas.height); }
    return shown === full;
  }

  function valuesAt(x, y) {
    const at = y * frame.size[0] + x;
    return full.groups.map((planes, g) => planes.map((plane, k) => (k ? full.scales[g][at] : 1) * frame.groups[g].tables[256 * k + plane[at]]));
  }

  return { name: "CPU", load, draw, valuesAt };
}

// Reads a 3-D table between its points, as the GPU does, for a row of pixels.
function lutSampler(lut) {
  const [values, size, [low, high]] = [table(lut.values), lut.size, lut.range];
  const [at, part, least] = [[0, 0, 0], [0, 0, 0], 2 ** low];
  return (row, picture, start) => {
    for (let j = 0, place = start; j < row.length; j += 3, place += 4) {
      for (let c = 0; c < 3; c++) {
        const stops = Math.log2(Math.max(row[j + c], 0) + least);
        const where = Math.max(0, Math.min(1, (stops - low) / (high - low))) * (size - 1);
        at[c] = Math.min(size - 2, Math.floor(where));
        part[c] = where - at[c];
      }
      for (let c = 0; c < 3; c++) {
        let sum = 0;
        for (let corner = 0; corner < 8; corner++) {
          const [r, g, b] = [corner & 1, (corner >> 1) & 1, corner >> 2];
          const weight = (r ? part[0] : 1 - part[0]) * (g ? part[1] : 1 - part[1]) * (b ? part[2] : 1 - part[2]);
          sum += weight * values[3 * (((at[2] + b) * size + at[1] + g) * size + at[0] + r) + c];
        }
        picture[place + c] = Math.round(255 * sum);
      }
      picture[place + 3] = 255;
    }
  };
}
