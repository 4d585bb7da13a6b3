// The mixer: a card for each light group, with the search for lamps and the light dial.

const openSearch = { field: null, choose: null, found: [], at: 0 };

// What is typed finds words that begin so, in a lamp's name or family.
function lampsLike(text) {
  const wanted = text.toLowerCase().split(/\s+/).filter(Boolean);
  const all = page.lamps.map((lamp, number) => ({ number, words: `${lamp.name} ${lamp.family}`.toLowerCase() }));
  return all.filter(({ words }) => wanted.every((part) => words.includes(part)))
    .sort((a, b) => (wanted.length ? a.words.indexOf(wanted[0]) - b.words.indexOf(wanted[0]) || a.number - b.number : a.number - b.number))
    .map(({ number }) => number);
}

function closeSearch() {
  if (!openSearch.field) return;
  openSearch.field.setAttribute("aria-expanded", "false");
  openSearch.field.removeAttribute("aria-activedescendant");
  openSearch.field = null;
  $("lamps").hidden = true;
}

function showSearch(field, choose) {
  Object.assign(openSearch, { field, choose, found: lampsLike(field.value === field.dataset.chosen ? "" : field.value), at: 0 });
  const list = $("lamps");
  if (field.value === field.dataset.chosen) openSearch.at = Math.max(0, openSearch.found.findIndex((n) => page.lamps[n].name === field.value));
  list.replaceChildren(...openSearch.found.map((number) => {
    const lamp = page.lamps[number];
    const curve = element("canvas", { width: 64, height: 24, className: "curve" });
    drawCurve(curve, table(page.lampPower).subarray(number * LINES, (number + 1) * LINES), `rgb(${lamp.colour.map((v) => Math.round(255 * v))})`);
    const item = element("li", { role: "option", id: `lamp${number}` }, curve, named(lamp.name), element("span", { className: "family", textContent: lamp.family }));
    item.addEventListener("pointerdown", (event) => event.preventDefault());
    item.addEventListener("click", () => chooseLamp(number));
    return item;
  }));
  if (!openSearch.found.length) list.append(element("li", { role: "option", "aria-disabled": "true", textContent: word("noLamp") }));
  const box = field.getBoundingClientRect();
  const width = Math.min(Math.max(box.width, 300), innerWidth - 16);
  Object.assign(list.style, { top: `${box.bottom + scrollY + 2}px`, width: `${width}px`, left: `${Math.max(8, Math.min(box.left, innerWidth - width - 8)) + scrollX}px` });
  list.hidden = false;
  field.setAttribute("aria-expanded", "true");
  markLamp(openSearch.at);
}

function markLamp(at) {
  openSearch.at = Math.max(0, Math.min(openSearch.found.length - 1, at));
  [...$("lamps").children].forEach((item, i) => item.setAttribute("aria-selected", i === openSearch.at));
  const marked = $("lamps").children[openSearch.at];
  marked?.scrollIntoView({ block: "nearest" });
  if (marked?.id) openSearch.field.setAttribute("aria-activedescendant", marked.id);
}

function chooseLamp(number) {
  const { field, choose } = openSearch;
  field.value = field.dataset.chosen = page.lamps[number].name;
  closeSearch();
  choose(number);
}

// A text field that finds a lamp: the combobox of ARIA's patterns.
function lampField(number, label, choose) {
  const field = element("input", { type: "text", role: "combobox", autocomplete: "off", spellcheck: false, placeholder: word("search"),
    "aria-autocomplete": "list", "aria-expanded": "false", "aria-controls": "lamps", "aria-label": label });
  field.value = field.dataset.chosen = page.lamps[number].name;
  field.addEventListener("click", () => { if (openSearch.field !== field) { field.select(); showSearch(field, choose); } });
  field.addEventListener("input", () => showSearch(field, choose));
  field.addEventListener("blur", () => { if (openSearch.field === field) closeSearch(); field.value = field.dataset.chosen; });
  field.addEventListener("keydown", (event) => {
    const open = openSearch.field === field;
    if (["ArrowDown", "ArrowUp"].includes(event.key)) {
      if (!open) showSearch(field, choose);
      else markLamp(openSearch.at + (event.key === "ArrowDown" ? 1 : -1));
    } else if (event.key === "Enter" && open && openSearch.found.length) chooseLamp(openSearch.found[openSearch.at]);
    else if (event.key === "Escape" && open) { closeSearch(); field.value = field.dataset.chosen; field.select(); }
    else return;
    event.preventDefault();
  });
  return field;
}

// A slider with its value; typed values may lie outside the slider's own range.
function slider(key, value, { low, high, step, from = (v) => v, to = (v) => v, digits = 2, label = word(key) }, change) {
  const range = element("input", { type: "range", min: low, max: high, step, value: to(value), "aria-label": label });
  const number = element("input", { type: "text", className: "number", inputMode: "decimal", value: value.toFixed(digits), "aria-label": `${label}, ${word(key)}` });
  const show = (next) => { range.setAttribute("aria-valuetext", next.toFixed(digits)); };
  show(value);
  range.addEventListener("input", () => { const next = from(Number(range.value)); number.value = next.toFixed(digits); show(next); change(next); });
  number.addEventListener("change", () => {
    const typed = Number(number.value.replace(",", "."));
    const [least, most] = [from(low), from(high)].sort((a, b) => a - b);
    const next = number.value.trim() && Number.isFinite(typed) ? Math.max(least, Math.min(most, typed)) : value;
    number.value = next.toFixed(digits);
    range.value = to(next);
    show(next);
    change(next);
  });
  return element("div", { className: "field" }, element("span", { textContent: word(key) }), range, number);
}

const SVG = "http://www.w3.org/2000/svg";

function vector(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

// The disc on which the lamps of a blend stand; the sliders below it do the same for keys and screen readers.
function lightDial(light, changed) {
  const dial = vector("svg", { viewBox: "-1.25 -1.25 2.5 2.5", class: "dial", "aria-hidden": "true" });
  dial.append(vector("circle", { r: 1, class: "disc", "stroke-width": 0.03 }));
  anchors(light.parts.length).forEach(([x, y], i) => {
    const corner = vector("circle", { cx: x, cy: -y, r: 0.13, stroke: "#888", "stroke-width": 0.02 });
    corner.style.fill = `rgb(${page.lamps[light.parts[i].lamp].colour.map((v) => Math.round(255 * v))})`;
    dial.append(corner);
  });
  const handle = vector("circle", { r: 0.12, class: "handle", "stroke-width": 0.04 });
  const place = () => { const [x, y] = dialHandle(light.parts.map((part) => part.weight)); handle.setAttribute("cx", x); handle.setAttribute("cy", -y); };
  place();
  dial.append(handle);
  const move = (event) => {
    const box = dial.getBoundingClientRect();
    const at = [((event.clientX - box.left) / box.width) * 2.5 - 1.25, 1.25 - ((event.clientY - box.top) / box.height) * 2.5];
    dialWeights(at, light.parts.length).forEach((weight, i) => (light.parts[i].weight = weight));
    place();
    changed();
  };
  dial.addEventListener("pointerdown", (event) => { dial.setPointerCapture(event.pointerId); move(event); });
  dial.addEventListener("pointermove", (event) => { if (dial.hasPointerCapture(event.pointerId)) move(event); });
  return { dial, place };
}

// The card of one light group. `changed` is called for every change, `rebuild` where the card itself has to change.
function groupCard(picture, mix, g, changed, rebuild) {
  const [light, group] = [mix.lights[g], picture.groups[g]];
  const curve = element("canvas", { width: 128, height: 64, className: "curve", "aria-hidden": "true" });
  const draw = () => drawCurve(curve, powerOf(light), colourOf(light));
  const did = () => { draw(); changed(); };
  draw();
  const kind = element("select", { "aria-label": `${group.name}: ${word("kind")}` }, ...KINDS.map((each) => element("option", { value: each, textContent: word(each) })));
  kind.value = light.kind;
  kind.addEventListener("change", () => {
    light.kind = kind.value;
    if (light.kind === "blend" && !light.parts.length) {
      const other = page.lamps.findIndex((lamp, number) => number !== light.lamp && lamp.name === "D65");
      light.parts = [light.lamp, other >= 0 ? other : (light.lamp + 1) % page.lamps.length].map((lamp, i) => ({ lamp, weight: i ? 0 : 1 }));
    }
    if (page.kinds[light.kind]) { const [low, high] = page.kinds[light.kind].range; light.kelvin = Math.max(low, Math.min(high, light.kelvin)); }
    rebuild(g, "select");
  });
  const card = element("fieldset", {}, element("legend", {}, named(group.name)), element("div", { className: "row" }, curve, kind));
  if (light.kind === "lamp")
    card.append(element("div", { className: "row" }, lampField(light.lamp, `${group.name}: ${word("name")}`, (number) => { light.lamp = number; did(); })));
  else if (light.kind === "blend") card.append(...blendRows(group, light, did, () => rebuild(g, "button.part")));
  else {
    const [low, high] = page.kinds[light.kind].range;
    card.append(slider("kelvin", light.kelvin, { low: -1e6 / low, high: -1e6 / high, step: 0.5, from: (m) => -1e6 / m, to: (k) => -1e6 / k, digits: 0,
      label: `${group.name}: ${word("kelvin")}` }, (kelvin) => { light.kelvin = kelvin; did(); }));
  }
  card.append(slider("gain", light.stops, { low: -8, high: 8, step: 0.05, label: `${group.name}: ${word("gain")} (${word("stops")})` }, (stops) => { light.stops = stops; changed(); }));
  const states = ["solo", "mute"].map((state) => {
    const made = button(state, light[state], () => { light[state] = !light[state]; made.setAttribute("aria-pressed", light[state]); changed(); });
    made.dataset.state = state;
    made.setAttribute("aria-label", `${group.name}: ${word(state)}`);
    return made;
  });
  card.append(element("div", { className: "row" }, ...states));
  return card;
}

function blendRows(group, light, did, rebuild) {
  const { dial, place } = lightDial(light, () => { rows.forEach((row, i) => row.querySelector("input[type=range]") && setWeight(row, light.parts[i].weight)); did(); });
  const setWeight = (row, weight) => { row.querySelector("input[type=range]").value = weight; row.querySelector(".number").value = weight.toFixed(2); };
  const rows = light.parts.map((part, i) => {
    const label = `${group.name}: ${page.lamps[part.lamp].name}`;
    const field = lampField(part.lamp, `${group.name}: ${word("name")} ${i + 1}`, (number) => { part.lamp = number; did(); rebuild(); });
    const remove = button("remove", null, () => { light.parts.splice(i, 1); did(); rebuild(); });
    remove.className = "part";
    remove.disabled = light.parts.length < 2;
    remove.setAttribute("aria-label", `${word("remove")}: ${label}`);
    const weight = slider("weight", part.weight, { low: 0, high: 1, step: 0.01, label: `${label}, ${word("weight")}` }, (value) => { part.weight = value; place(); did(); });
    return element("div", {}, element("div", { className: "row" }, field, remove), weight);
  });
  const add = button("add", null, () => { light.parts.push({ lamp: light.lamp, weight: 0 }); did(); rebuild(); });
  add.className = "part";
  add.disabled = light.parts.length >= 6;
  return [dial, ...rows, element("div", { className: "row" }, add)];
}
