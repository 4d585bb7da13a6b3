// The page: what is shown, and everything that a person, the address or another page may change.

var now = { picture: null, mix: null, mixes: new Map(), frame: null, number: 0, snapshots: [], compared: null, wipe: 0.5, spot: null };
let renderer, waiting, settling, loads = 0;

// quick: as fast as someone drags, and exactly once that has ended.
function render(quick = false) {
  waiting = 0;
  clearTimeout(settling);
  if (!now.frame) return;
  const sides = [lightingOf(now.picture, now.mix)];
  if (now.compared) sides.push(lightingOf(now.picture, now.compared));
  if (renderer.draw(sides, Math.round(now.wipe * now.picture.size[0]), quick) === false) settling = setTimeout(() => render(), 150);
  $("problem").textContent = sides[0].problem ? word(sides[0].problem) : "";
  showSpot();
}

let saving;

function changed() {
  waiting ||= requestAnimationFrame(() => render(true));
  const { words, unsaid } = commandOf(now.picture, now.mix);
  $("words").value = words;
  $("unsaid").textContent = unsaid.length ? `${word("said")} ${unsaid.map((key) => word("said_" + key)).join(", ")}.` : "";
  clearTimeout(saving);
  // Browsers take only so many changes of the address in a second
  saving = setTimeout(() => history.replaceState(null, "", "#" + hashOf(now.picture, now.mix)), 250);
}

function drawMixer() {
  const cards = now.mix.lights.map((_, g) => groupCard(now.picture, now.mix, g, changed, rebuildCard));
  $("groups").replaceChildren(...cards);
  for (const key of ["exposure", "white"]) $(key).value = now.mix[key];
  $("method").replaceChildren(...Object.keys(page.adaptations).map((name) => element("option", { value: name, textContent: name[0].toUpperCase() + name.slice(1) })));
  $("method").value = now.mix.method;
  $("observer").replaceChildren(...page.observers.map((name, i) => element("option", { value: i, textContent: name })));
  $("observer").value = now.mix.observer;
  showValues();
  drawSnapshots();
}

function rebuildCard(g, focus) {
  const card = groupCard(now.picture, now.mix, g, changed, rebuildCard);
  $("groups").children[g].replaceWith(card);
  card.querySelector(focus)?.focus();
  changed();
}

function showValues() {
  $("exposureValue").textContent = now.mix.exposure.toFixed(2);
  $("whiteValue").textContent = `${Math.round(100 * now.mix.white)} %`;
}

function drawSnapshots() {
  $("snapshots").replaceChildren(...now.snapshots.map((snapshot, i) => {
    const use = element("button", { type: "button" }, named(snapshot.name));
    use.addEventListener("click", () => setMix(copyOf(snapshot.mix)));
    const forget = button("forget", null, () => { now.snapshots.splice(i, 1); drawSnapshots(); compareWith("") ; });
    forget.setAttribute("aria-label", `${word("forget")}: ${snapshot.name}`);
    return element("li", {}, use, forget);
  }));
  const chosen = $("other").value;
  const options = [["", word("nothing")], ["rendered", word("asRendered")], ...now.snapshots.map((snapshot, i) => [String(i), snapshot.name])];
  $("other").replaceChildren(...options.map(([value, text]) => element("option", { value, textContent: text })));
  $("other").value = options.some(([value]) => value === chosen) ? chosen : "";
}

function compareWith(value) {
  $("other").value = value;
  now.compared = value === "" ? null : value === "rendered" ? renderedMix(now.picture) : copyOf(now.snapshots[value].mix);
  $("wipeField").hidden = $("handle").hidden = !now.compared;
  wipeTo(now.wipe);
}

function wipeTo(part) {
  now.wipe = Math.max(0, Math.min(1, part));
  $("wipe").value = now.wipe;
  $("handle").style.left = `${100 * now.wipe}%`;
  $("handle").setAttribute("aria-valuenow", Math.round(100 * now.wipe));
  changed();
}

function setMix(mix) {
  now.mix = mix;
  now.mixes.set(now.picture, mix);
  drawMixer();
  changed();
}

async function showFrame(number) {
  const load = ++loads;
  now.number = number;
  $("status").textContent = word("loading");
  $("frameNumber").textContent = now.picture.frames[number].number;
  try {
    const frame = await readFrame(now.picture, number);
    if (load !== loads) return;
    renderer.load(frame);
    $("sheet").style.setProperty("--ratio", frame.size[0] / frame.size[1]);
    now.frame = frame;
    render();
    $("status").textContent = "";
    document.documentElement.dataset.shown = renderer.name;
  } catch (error) {
    $("status").textContent = `${word("failed")} ${error.message}`;
  }
}

async function showPicture(picture, mix) {
  now.mixes.set(now.picture, now.mix);
  Object.assign(now, { picture, frame: null, compared: null, spot: null, snapshots: (picture.snapshots ??= []) });
  [...$("gallery").children].forEach((each, i) => each.setAttribute("aria-current", page.pictures[i] === picture));
  $("time").hidden = picture.frames.length < 2;
  $("frame").max = picture.frames.length - 1;
  $("frame").value = 0;
  setMix(mix || now.mixes.get(picture) || renderedMix(picture));
  compareWith("");
  await showFrame(0);
}

// What a page that embeds this one, or the address, says: the words of `hashOf`.
function say(words) {
  const name = new URLSearchParams(words.replace(/^#/, "")).get("picture");
  const picture = page.pictures.find((each) => each.name === name) || now.picture || page.pictures[0];
  const mix = mixFrom(words, picture);
  return picture === now.picture ? setMix(mix) : showPicture(picture, mix);
}

function showSpot() {
  if (!now.spot || !now.frame) return;
  const { power, xyz } = spotOf(now.picture, now.frame, now.mix, renderer.valuesAt(...now.spot));
  drawCurve($("spectrum"), power);
  const sum = xyz[0] + xyz[1] + xyz[2];
  const peak = 380 + 5 * power.indexOf(Math.max(...power));
  const text = sum > 0 ? `x ${(xyz[0] / sum).toFixed(4)}, y ${(xyz[1] / sum).toFixed(4)}, Y ${xyz[1].toPrecision(3)}, ${peak} nm` : "Y 0";
  $("reading").textContent = `${now.spot.join(", ")}: ${text}`;
  $("spectrum").setAttribute("aria-label", `${word("spectrumOf")}: ${text}`);
}

function pointAt(x, y) {
  const [width, height] = now.picture.size;
  now.spot = [Math.max(0, Math.min(width - 1, Math.floor(x))), Math.max(0, Math.min(height - 1, Math.floor(y)))];
  requestAnimationFrame(showSpot);
}

async function copy(text, field) {
  try {
    await navigator.clipboard.writeText(text);
    $("status").textContent = word("copied");
  } catch {
    $("words").value = text;
    field.focus();
    field.select();
    $("status").textContent = word("notCopied");
  }
}

function listen() {
  const canvas = $("picture");
  const pointed = (event) => {
    const box = canvas.getBoundingClientRect();
    pointAt(((event.clientX - box.left) / box.width) * now.picture.size[0], ((event.clientY - box.top) / box.height) * now.picture.size[1]);
  };
  for (const name of ["pointermove", "pointerdown"]) canvas.addEventListener(name, pointed);
  // A GPU may be taken away, from a phone's page that was long out of sight
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => { renderer = glRenderer(canvas); showFrame(now.number); });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const [x, y] = now.spot || now.picture.size.map((side) => side / 2);
    const far = event.shiftKey ? 1 : 8;
    pointAt(x + far * step[0], y + far * step[1]);
  });
  for (const key of ["exposure", "white"])
    $(key).addEventListener("input", () => { now.mix[key] = Number($(key).value); showValues(); changed(); });
  $("method").addEventListener("change", () => { now.mix.method = $("method").value; changed(); });
  $("observer").addEventListener("change", () => { now.mix.observer = Number($("observer").value); changed(); });
  $("other").addEventListener("change", () => compareWith($("other").value));
  $("wipe").addEventListener("input", () => wipeTo(Number($("wipe").value)));
  const handle = $("handle");
  const follow = (event) => { const box = canvas.getBoundingClientRect(); wipeTo((event.clientX - box.left) / box.width); };
  handle.addEventListener("pointerdown", (event) => { handle.setPointerCapture(event.pointerId); follow(event); });
  handle.addEventListener("pointermove", (event) => { if (handle.hasPointerCapture(event.pointerId)) follow(event); });
  handle.addEventListener("keydown", (event) => {
    const to = { ArrowLeft: now.wipe - 0.02, ArrowDown: now.wipe - 0.02, ArrowRight: now.wipe + 0.02, ArrowUp: now.wipe + 0.02, Home: 0, End: 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    wipeTo(to);
  });
  $("frame").addEventListener("input", () => showFrame(Number($("frame").value)));
  $("reset").addEventListener("click", () => setMix(renderedMix(now.picture)));
  $("keep").addEventListener("click", () => {
    const taken = now.snapshots.map((snapshot) => snapshot.name);
    let n = 1;
    while (taken.includes(`${word("mixNumber")} ${n}`)) n++;
    now.snapshots.push({ name: `${word("mixNumber")} ${n}`, mix: copyOf(now.mix) });
    drawSnapshots();
  });
  $("copy").addEventListener("click", () => copy($("words").value, $("words")));
  $("link").addEventListener("click", () => copy(location.href.replace(/#.*/, "") + "#" + hashOf(now.picture, now.mix), $("words")));
  $("language").addEventListener("click", () => { language = language === "de" ? "en" : "de"; translate(); drawMixer(); changed(); });
  addEventListener("hashchange", () => say(location.hash));
  addEventListener("resize", closeSearch);
  addEventListener("keydown", press);
}

function press(event) {
  const bracket = event.key === "[" || event.key === "]"; // on many keyboards it takes Alt or AltGr
  const typing = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range";
  if (typing || event.metaKey || ((event.ctrlKey || event.altKey) && !bracket)) return;
  const digit = /^Digit([1-9])$/.exec(event.code);
  const light = digit && now.mix.lights[digit[1] - 1];
  if (light) { const state = event.shiftKey ? "mute" : "solo"; light[state] = !light[state]; }
  else if (bracket) now.mix.exposure = Math.max(-6, Math.min(6, now.mix.exposure + (event.key === "]" ? 0.25 : -0.25)));
  else if (event.key === "0") return setMix(renderedMix(now.picture));
  else if (event.key.toLowerCase() === "w") return compareWith($("other").value === "" ? "rendered" : "");
  else return;
  const focused = document.activeElement.getAttribute("aria-label");
  drawMixer();
  if (focused) [...$("groups").querySelectorAll("[aria-label]")].find((each) => each.getAttribute("aria-label") === focused)?.focus();
  changed();
}

// For a page that embeds this one: docs/web.md says what may be said.
function answer(event) {
  if (event.source !== parent || parent === window || typeof event.data?.relume !== "string") return;
  if (event.data.relume === "set" && typeof event.data.mix === "string") say(event.data.mix);
  if (event.data.relume === "frame" && now.picture.frames[event.data.number]) showFrame(event.data.number);
  if (["set", "get", "frame"].includes(event.data.relume)) tell("mix");
}

function tell(relume) {
  const { picture, mix } = now;
  parent.postMessage({ relume, mix: hashOf(picture, mix), picture: picture.name, pictures: page.pictures.map((each) => each.name), frames: picture.frames.length,
    groups: picture.groups.map((group) => group.name), lamps: page.lamps.map((lamp) => lamp.name) }, "*");
}

async function start() {
  translate();
  $("title").replaceChildren(named(page.title));
  try {
    await readNumbers();
    const wanted = new URLSearchParams(location.search).get("renderer");
    renderer = (wanted ? wanted === "gpu" : fitsGpu() && hasGpu()) ? glRenderer($("picture")) : cpuRenderer($("picture"));
    if (page.pictures.length > 1) {
      $("gallery").hidden = false;
      $("gallery").classList.add("row");
      $("gallery").replaceChildren(...page.pictures.map((picture) => {
        const made = element("button", { type: "button" }, named(picture.name));
        made.addEventListener("click", () => showPicture(picture));
        return made;
      }));
    }
    listen();
    addEventListener("message", answer);
    await say(location.hash);
    if (parent !== window) tell("ready");
  } catch (error) {
    $("status").textContent = `${word("failed")} ${error.message}`;
  }
}

start();
