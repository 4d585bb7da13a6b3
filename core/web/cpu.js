// The renderer without a GPU: the same two steps in plain loops.

function cpuRenderer(canvas) {
  const context = canvas.getContext("2d");
  const encode = (value) => (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);
  const encoded = Float32Array.from({ length: 65536 }, (_, i) => 255 * encode(i / 65535));
  let frame, groups, coverage, kept;

  function bytes(bitmap) {
    const paper = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d", { willReadFrequently: true });
    paper.drawImage(bitmap, 0, 0);
    const four = paper.getImageData(0, 0, bitmap.width, bitmap.height).data;
    bitmap.close();
    return Uint8Array.from({ length: four.length / 4 }, (_, i) => four[4 * i]);
  }

  function load(read) {
    frame = read;
    [canvas.width, canvas.height] = frame.size;
    groups = frame.groups.map((group) => group.bitmaps.map(bytes));
    coverage = frame.alpha ? bytes(frame.alpha) : null;
    kept = [];
  }

  // XYZ of a light group, pixel after pixel; row by row, so that what is worked on stays in the cache.
  function relit(planes, group, matrix) {
    const [width, height] = frame.size;
    const xyz = new Float32Array(3 * width * height);
    const [white, axes] = [whiteUnder(matrix), axesUnder(matrix, group.basis)];
    const means = planes.map((_, k) => group.tables.subarray(256 * k, 256 * k + 256));
    for (let start = 0; start < width * height; start += width) {
      const row = xyz.subarray(3 * start, 3 * (start + width));
      for (let k = 1; k < planes.length; k++) add(row, planes[k].subarray(start, start + width), means[k], axes[3 * k - 3], axes[3 * k - 2], axes[3 * k - 1]);
      finish(row, planes[0].subarray(start, start + width), means[0], group.floor, ...white);
    }
    return xyz;
  }

  function add(row, plane, means, a, b, c) {
    for (let i = 0, j = 0; i < plane.length; i++, j += 3) {
      const value = means[plane[i]];
      row[j] += a * value;
      row[j + 1] += b * value;
      row[j + 2] += c * value;
    }
  }

  function finish(row, plane, means, floor, a, b, c) {
    for (let i = 0, j = 0; i < plane.length; i++, j += 3) {
      const brightness = means[plane[i]];
      const scale = brightness + floor;
      row[j] = brightness * a + scale * row[j];
      row[j + 1] = brightness * b + scale * row[j + 1];
      row[j + 2] = brightness * c + scale * row[j + 2];
    }
  }

  function update(side, matrices) {
    kept[side] ??= { xyz: [], matrices: [] };
    groups.forEach((planes, g) => {
      const before = kept[side].matrices[g];
      if (before && before.every((value, i) => value === matrices[g][i])) return;
      kept[side].matrices[g] = matrices[g];
      kept[side].xyz[g] = relit(planes, frame.groups[g], matrices[g]);
    });
  }

  function sum(row, xyz, gain, [a, b, c, d, e, f, g, h, i]) {
    for (let j = 0; j < row.length; j += 3) {
      const [x, y, z] = [gain * xyz[j], gain * xyz[j + 1], gain * xyz[j + 2]];
      row[j] += a * x + b * y + c * z;
      row[j + 1] += d * x + e * y + f * z;
      row[j + 2] += g * x + h * y + i * z;
    }
  }

  // Writes the columns from..to of one mix into the picture.
  function paint(picture, { gains, display, lut, gamma }, xyz, from, to) {
    const [width, height] = frame.size;
    const power = Uint8ClampedArray.from(encoded, (byte) => Math.round(255 * (byte / 255) ** (1 / gamma)));
    const throughLut = lut ? lutSampler(lut) : null;
    const row = new Float32Array(3 * (to - from));
    for (let line = 0; line < height; line++) {
      const first = line * width + from;
      row.fill(0);
      for (let g = 0; g < xyz.length; g++)
        if (gains[g]) sum(row, xyz[g].subarray(3 * first, 3 * (first + to - from)), gains[g], display);
      if (coverage) for (let j = 0; j < row.length; j++) row[j] /= (coverage[first + Math.floor(j / 3)] || 255) / 255;
      if (throughLut) throughLut(row, picture, 4 * first);
      else
        for (let j = 0, k = 4 * first; j < row.length; j += 3, k += 4) {
          picture[k] = power[Math.max(0, Math.min(65535, row[j] * 65535 + 0.5)) | 0];
          picture[k + 1] = power[Math.max(0, Math.min(65535, row[j + 1] * 65535 + 0.5)) | 0];
          picture[k + 2] = power[Math.max(0, Math.min(65535, row[j + 2] * 65535 + 0.5)) | 0];
        }
      for (let i = first; i < first + to - from; i++) picture[4 * i + 3] = coverage ? coverage[i] : 255;
    }
  }

  function draw(sides, wipe) {
    sides.forEach((lighting, side) => update(side, lighting.matrices));
    const [width, height] = frame.size;
    const image = context.createImageData(width, height);
    const edge = sides[1] ? Math.min(wipe, width) : width;
    paint(image.data, sides[0], kept[0].xyz, 0, edge);
    if (sides[1]) paint(image.data, sides[1], kept[1].xyz, edge, width);
    context.putImageData(image, 0, 0);
    if (sides[1]) { context.fillStyle = "white"; context.fillRect(edge, 0, 1, height); }
  }

  const valuesAt = (x, y) => groups.map((planes, g) => planes.map((plane, k) => frame.groups[g].tables[256 * k + plane[y * frame.size[0] + x]]));
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
    }
  };
}
