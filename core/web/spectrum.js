// Curves: of lamps, and of the light that comes from a spot of the picture.

const RAINBOW = [[380, 77, 13, 102], [420, 97, 26, 191], [450, 38, 64, 242], [485, 13, 179, 230], [510, 26, 204, 102],
  [550, 140, 217, 26], [580, 242, 217, 26], [610, 250, 128, 20], [650, 230, 31, 20], [780, 102, 5, 13]];

function rainbow(context, width) {
  const gradient = context.createLinearGradient(0, 0, width, 0);
  for (const [nanometres, ...rgb] of RAINBOW) gradient.addColorStop((nanometres - 380) / 400, `rgb(${rgb})`);
  return gradient;
}

function drawCurve(canvas, power, background) {
  const context = canvas.getContext("2d");
  const [width, height] = [canvas.width, canvas.height];
  const highest = Math.max(...power, 1e-12);
  context.clearRect(0, 0, width, height);
  if (background) { context.fillStyle = background; context.fillRect(0, 0, width, height); }
  context.beginPath();
  context.moveTo(0, height);
  power.forEach((value, i) => context.lineTo((i * width) / (power.length - 1), height - 1 - (0.92 * height * Math.max(0, value)) / highest));
  context.lineTo(width, height);
  context.closePath();
  context.fillStyle = background ? "rgb(0 0 0 / 0.55)" : rainbow(context, width);
  context.fill();
}

function colourOf(light) {
  const sum = [0, 0, 0];
  const xyz = page.models[0];
  const matrix = whiteUnder(matrixOf(xyz, light, 0));
  onto(XYZ_TO_RGB, matrix).forEach((value, k) => (sum[k] = Math.max(0, value)));
  const brightest = Math.max(...sum, 1e-9);
  const encode = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
  return `rgb(${sum.map((value) => Math.round(255 * encode(value / brightest)))})`;
}

// What a spot sends to the eye: its spectrum (81), and XYZ before white balance; from the values of the light groups.
function spotOf(picture, frame, mix, read) {
  const model = page.models[picture.model];
  const p = model.channels;
  const [rebuilt, gains] = [table(model.spectrum), gainsOf(mix)];
  const power = new Float64Array(LINES);
  const xyz = [0, 0, 0];
  frame.groups.forEach((group, g) => {
    if (!gains[g]) return;
    const values = read[g];
    const coefficients = Array.from({ length: p }, (_, i) => {
      let rest = 0;
      for (let k = 0; k < p - 1; k++) rest += group.basis[i * (p - 1) + k] * values[k + 1];
      return values[0] + rest;
    });
    const [lamp, matrix] = [powerOf(mix.lights[g]), matrixOf(model, mix.lights[g], mix.observer)];
    for (let row = 0; row < 3; row++)
      for (let i = 0; i < p; i++) xyz[row] += gains[g] * matrix[row * p + i] * coefficients[i];
    for (let line = 0; line < LINES; line++) {
      let reflected = 0;
      for (let i = 0; i < p; i++) reflected += rebuilt[i * LINES + line] * coefficients[i];
      power[line] += gains[g] * lamp[line] * Math.max(0, reflected);
    }
  });
  return { power, xyz };
}
