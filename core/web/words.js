// Words of the interface, and small help with elements. What comes from outside is text, never markup.

const $ = (id) => document.getElementById(id);
let language = navigator.language.toLowerCase().startsWith("de") ? "de" : "en";
const word = (key) => page.words[language][key] ?? key;

function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key.includes("-") || ["role", "for", "list"].includes(key)) made.setAttribute(key, value);
    else made[key] = value;
  }
  made.append(...children);
  return made;
}

// A name from outside: kept apart from the direction of the words around it.
const named = (text) => element("bdi", { textContent: text });

function button(key, pressed, act) {
  const made = element("button", { type: "button", textContent: word(key) });
  if (pressed !== null) made.setAttribute("aria-pressed", pressed);
  made.addEventListener("click", act);
  return made;
}

function translate() {
  document.documentElement.lang = language;
  for (const each of document.querySelectorAll("[data-word]")) each.textContent = word(each.dataset.word);
  for (const each of document.querySelectorAll("[data-label]")) each.setAttribute("aria-label", word(each.dataset.label));
  $("language").textContent = language === "de" ? "English" : "Deutsch";
  $("language").lang = language === "de" ? "en" : "de";
  $("picture").setAttribute("aria-label", word("picture"));
  $("spectrum").setAttribute("aria-label", word("spectrumOf"));
}
