// The renderer on the GPU: XYZ of every light group is kept, so that a change of one lamp works on one group only, and
// gains, white balance and exposure work on none.

const MOST_GROUPS = 32;
const MOST_AXES = 10; // in fours

// Whether there is a GPU. What software makes of WebGL is slower than the renderer on the CPU.
function hasGpu() {
  // Not the picture's canvas: one that was asked for one kind of context gives no other
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe?.getExtension("EXT_color_buffer_float")) return false;
  const told = probe.getExtension("WEBGL_debug_renderer_info");
  const name = probe.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : probe.RENDERER);
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

// Whether every picture has as many light groups and channels at most as the programs have room for.
const fitsGpu = () => page.pictures.every((each) => each.groups.length <= MOST_GROUPS) && page.models.every((each) => each.channels <= 4 * MOST_AXES);

function glRenderer(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: false, premultipliedAlpha: false, preserveDrawingBuffer: true });
  gl.getExtension("EXT_color_buffer_float");
  const source = document.getElementById("shader").textContent.trim();

  function shader(kind, part) {
    const made = gl.createShader(kind);
    const numbers = `\n#define ${part}\n#define MOST ${MOST_AXES}\n#define GROUPS ${MOST_GROUPS}\n`;
    gl.shaderSource(made, source.replace("\n", numbers));
    gl.compileShader(made);
    if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made) || "shader");
    return made;
  }

  function program(part) {
    const made = gl.createProgram();
    gl.attachShader(made, shader(gl.VERTEX_SHADER, "PLACE"));
    gl.attachShader(made, shader(gl.FRAGMENT_SHADER, part));
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made) || "program");
    const places = new Map();
    return { made, at: (name) => places.get(name) ?? (places.set(name, gl.getUniformLocation(made, name)), places.get(name)) };
  }

  const [decode, relight, show] = ["DECODE", "RELIGHT", "SHOW"].map(program);
  const frameBuffer = gl.createFramebuffer();
  const every = gl.NEAREST;

  function texture(kind, filter = every) {
    const made = gl.createTexture();
    gl.bindTexture(kind, made);
    gl.texParameteri(kind, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(kind, gl.TEXTURE_MAG_FILTER, filter);
    for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) gl.texParameteri(kind, axis, gl.CLAMP_TO_EDGE);
    return made;
  }

  const nothing = texture(gl.TEXTURE_2D);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, 1, 1, 0, gl.RED, gl.UNSIGNED_BYTE, new Uint8Array([255]));
  const noLut = texture(gl.TEXTURE_3D);
  gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA8, 1, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  const luts = new Map();
  let frame, groups, coverage, kept; // kept: for the mix and the one to compare with, XYZ and the matrices it was made of

  function bind(unit, kind, what) {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(kind, what);
  }

  function layers(format, [width, height], count) {
    const made = texture(gl.TEXTURE_2D_ARRAY);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, format, width, height, count);
    return made;
  }

  function meaning(tables) {
    const made = texture(gl.TEXTURE_2D);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, 256, tables.length / 256, 0, gl.RED, gl.FLOAT, tables);
    return made;
  }

  function put(planes, layer, bitmap) {
    bind(0, gl.TEXTURE_2D_ARRAY, planes);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, ...frame.size, 1, gl.RED, gl.UNSIGNED_BYTE, bitmap);
  }

  // Numbers of bytes, once for all: four planes in a layer.
  function decoded(planes, group, count, bright, means) {
    const tables = meaning(group.tables);
    const values = layers(gl.RGBA16F, frame.size, Math.ceil(count / 4));
    gl.useProgram(decode.made);
    bind(0, gl.TEXTURE_2D_ARRAY, planes);
    bind(1, gl.TEXTURE_2D, tables);
    gl.uniform1i(decode.at("planes"), 0);
    gl.uniform1i(decode.at("tables"), 1);
    gl.uniform1i(decode.at("count"), count);
    bind(2, gl.TEXTURE_2D_ARRAY, bright);
    bind(3, gl.TEXTURE_2D, means);
    gl.uniform1i(decode.at("bright"), 2);
    gl.uniform1i(decode.at("means"), 3);
    gl.uniform1i(decode.at("groups"), frame.groups.length);
    gl.uniform1f(decode.at("base"), group.floor);
    gl.uniform1f(decode.at("part"), page.shared);
    for (let layer = 0; layer < Math.ceil(count / 4); layer++) {
      into(values, layer);
      gl.uniform1i(decode.at("first"), 4 * layer);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteTexture(tables);
    return values;
  }

  function into(target, layer) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, frameBuffer);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, target, 0, layer);
    gl.viewport(0, 0, ...frame.size);
  }

  function load(read) {
    for (const old of groups || []) gl.deleteTexture(old.values);
    for (const old of kept || []) gl.deleteTexture(old.xyz);
    if (coverage) gl.deleteTexture(coverage);
    frame = read;
    [canvas.width, canvas.height] = frame.size;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    const bright = layers(gl.R8, frame.size, frame.groups.length);
    const means = meaning(Float32Array.from(frame.groups.flatMap((group) => [...group.tables.subarray(0, 256)])));
    frame.groups.forEach((group, g) => put(bright, g, group.bitmaps[0]));
    groups = frame.groups.map((group) => {
      const count = group.bitmaps.length;
      const planes = layers(gl.R8, frame.size, count);
      group.bitmaps.forEach((bitmap, layer) => { put(planes, layer, bitmap); bitmap.close(); });
      const values = decoded(planes, group, count, bright, means);
      gl.deleteTexture(planes);
      return { values, count, layers: Math.ceil(count / 4) };
    });
    gl.deleteTexture(bright);
    gl.deleteTexture(means);
    coverage = null;
    if (frame.alpha) {
      coverage = texture(gl.TEXTURE_2D);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, gl.RED, gl.UNSIGNED_BYTE, frame.alpha);
    }
    kept = [];
  }

  function update(side, matrices) {
    kept[side] ??= { xyz: layers(gl.RGBA16F, frame.size, groups.length), matrices: [] };
    gl.useProgram(relight.made);
    groups.forEach((group, g) => {
      const before = kept[side].matrices[g];
      if (before && before.every((value, i) => value === matrices[g][i])) return;
      kept[side].matrices[g] = matrices[g];
      into(kept[side].xyz, g);
      bind(0, gl.TEXTURE_2D_ARRAY, group.values);
      gl.uniform1i(relight.at("values"), 0);
      gl.uniform1i(relight.at("layers"), group.layers);
      gl.uniform3fv(relight.at("white"), whiteUnder(matrices[g]));
      const axes = new Float32Array(12 * group.layers);
      axes.set(axesUnder(matrices[g], frame.groups[g].basis), 3);
      gl.uniformMatrix4x3fv(relight.at("axes"), false, axes);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  function lutOf(lut) {
    if (!luts.has(lut)) {
      const made = texture(gl.TEXTURE_3D, gl.LINEAR);
      const values = table(lut.values);
      const four = new Float32Array((values.length / 3) * 4);
      for (let i = 0; i < values.length / 3; i++) four.set(values.subarray(3 * i, 3 * i + 3), 4 * i);
      gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA16F, lut.size, lut.size, lut.size, 0, gl.RGBA, gl.FLOAT, four);
      luts.set(lut, made);
    }
    return luts.get(lut);
  }

  // sides: the lighting of the mix, and, if any, of the one to compare with; wipe: its first column.
  function draw(sides, wipe) {
    sides.forEach((lighting, side) => update(side, lighting.matrices));
    const [left, right] = [sides[0], sides[1] || sides[0]];
    const gains = new Float32Array(2 * MOST_GROUPS);
    gains.set(left.gains);
    gains.set(right.gains, MOST_GROUPS);
    gl.useProgram(show.made);
    gl.viewport(0, 0, canvas.width, canvas.height);
    bind(0, gl.TEXTURE_2D_ARRAY, kept[0].xyz);
    bind(1, gl.TEXTURE_2D_ARRAY, kept[sides[1] ? 1 : 0].xyz);
    bind(2, gl.TEXTURE_2D, coverage || nothing);
    bind(3, gl.TEXTURE_3D, left.lut ? lutOf(left.lut) : noLut);
    ["left", "right", "coverage", "lut"].forEach((name, unit) => gl.uniform1i(show.at(name), unit));
    gl.uniform1fv(show.at("gains"), gains);
    gl.uniformMatrix3fv(show.at("display"), true, left.display);
    gl.uniformMatrix3fv(show.at("display[1]"), true, right.display);
    gl.uniform1f(show.at("gamma"), left.gamma);
    gl.uniform1i(show.at("groups"), groups.length);
    gl.uniform1i(show.at("wipe"), sides[1] ? wipe : canvas.width + 1);
    gl.uniform1i(show.at("hasLut"), left.lut ? 1 : 0);
    gl.uniform1i(show.at("hasAlpha"), coverage ? 1 : 0);
    if (left.lut) gl.uniform2f(show.at("range"), ...left.lut.range);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Of one pixel, of each light group: its brightness, and what is left along the axes.
  function valuesAt(x, y) {
    const four = new Float32Array(4);
    const found = groups.map((group) => {
      const values = [];
      for (let layer = 0; layer < group.layers; layer++) {
        into(group.values, layer);
        gl.readPixels(x, y, 1, 1, gl.RGBA, gl.FLOAT, four);
        values.push(...four);
      }
      return values.slice(0, group.count);
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return found;
  }

  return { name: "WebGL2", load, draw, valuesAt };
}

// (p - 1, 3): XYZ of each axis of a basis (p, p - 1) under a matrix (3, p).
function axesUnder(matrix, basis) {
  const p = matrix.length / 3;
  const axes = new Float32Array(3 * (p - 1));
  for (let k = 0; k < p - 1; k++)
    for (let row = 0; row < 3; row++)
      for (let i = 0; i < p; i++) axes[3 * k + row] += matrix[row * p + i] * basis[i * (p - 1) + k];
  return axes;
}
