// Requests of the page to the server, from clicks and forms. Attributes of the elements define them:
//   data-do="name"     on a click, with all other data- attributes
//   data-change="name" when a control changes, with its value
//   data-submit="name" when a form is sent, with all its values
//   data-with-form     on a click or a change, also with all values of the form around it
//   data-seen          with the cycle that the field showed at the key press or click
//   data-hotkey="k"    pressing the key clicks the element (keys.js)
//   data-off="why"     the element is unavailable, and shows why; the server decides if it still is
//
// Each request has an identity, and is sent, with all before it, until the server has confirmed it: so
// none is lost with a broken connection, and none is carried out twice or out of order.
const client = `${Date.now().toString(36)}${Math.random().toString(36).slice(2)}`;
let count = 0;
let unconfirmed = [];
const send = () => unconfirmed.length && window.emitEvent("studio", { requests: unconfirmed });
export function request(what, more = {}) {
  sendTyped(); // the server handles requests in the person's order
  unconfirmed.push({ do: what, ...more, id: `${client}.${++count}` });
  send();
}
window.studioTell = request;
window.studioHeard = (id) => (unconfirmed = unconfirmed.slice(1 + unconfirmed.findIndex((asked) => asked.id === id)));
setInterval(() => window.socket?.connected && send(), 1000);

function dataOf(element) {
  const data = { ...element.dataset };
  for (const name of ["do", "change", "submit", "hotkey", "key", "kept", "withForm"]) delete data[name];
  return data;
}

function valuesOf(form) {
  const values = {};
  for (const [name, value] of new FormData(form)) {
    if (name.endsWith("[]")) (values[name.slice(0, -2)] ||= []).push(value);
    else values[name] = value;
  }
  return values;
}

// The emergency stop is requested over HTTP, since the page's web socket may be down or reconnecting.
// The request is repeated until the server answers, also after a reload of the page.
const PRESSED = "hitab-stop-pressed";
const GIVE_UP_MS = 30000;
let stopping = false;

function reportStop(text) {
  let band = document.getElementById("stop-report");
  if (!band) {
    band = document.createElement("div");
    band.id = "stop-report";
    band.dataset.test = "stop-report";
    band.setAttribute("role", "alert");
    document.body.append(band);
  }
  band.textContent = text;
  band.hidden = !text;
}

async function sendStop() {
  if (stopping) return;
  stopping = true;
  let problem = "";
  while (Number(sessionStorage.getItem(PRESSED)) > Date.now() - GIVE_UP_MS) {
    try {
      const signal = AbortSignal.timeout(3000);
      const answer = await fetch(`stop-robots?page=${window.STUDIO_PAGE}`, { method: "POST", signal });
      problem = answer.ok ? "" : (await answer.json()).detail;
      break;
    } catch {
      problem = "THE ROBOTS WERE NOT STOPPED: the studio does not answer. Use the robots' own switches.";
      reportStop("The studio has not answered yet: asking it again to stop the robots. Use their own switches.");
      await new Promise((resolve) => setTimeout(resolve, 300));
    }
  }
  stopping = false;
  sessionStorage.removeItem(PRESSED);
  reportStop(problem);
}

export function stopRobots() {
  sessionStorage.setItem(PRESSED, Date.now());
  sendStop();
}
if (sessionStorage.getItem(PRESSED)) sendStop();

// Releases the person's agents at once, also for the same page after a reload, and not only after the
// server's timeout for a reconnection.
addEventListener("pagehide", () => navigator.sendBeacon(`leave?page=${window.STUDIO_PAGE}`));
addEventListener("pageshow", ({ persisted }) => persisted && location.reload());

// Whether the current click is a further one of a double click; the server decides whether it counts.
let again = false;
document.addEventListener("click", (event) => (again = event.detail > 1), true);
document.addEventListener("keydown", () => (again = false), true);

// The cycle shown at the pointer's press, which precedes the click.
const shown = () => window.studioField?.shown || 0;
let seen = 0;
document.addEventListener("pointerdown", () => (seen = shown()), true);

document.addEventListener("click", (event) => {
  const off = event.target.closest("[data-off]");
  if (off && (!off.dataset.do || off.form)) {
    event.preventDefault();
    request("why", { reason: off.dataset.off });
    return;
  }
  const element = event.target.closest("[data-do]");
  if (!element || element.disabled) return;
  if (element.dataset.do === "stop-robots") return stopRobots();
  const control = event.target.closest("input, select");
  if (control && control !== element && element.contains(control)) return; // a control in a clickable row
  const form = element.closest("form");
  if (element.type !== "submit" || !form) event.preventDefault();
  else return;
  request(element.dataset.do, {
    ...dataOf(element),
    ...(form && element.dataset.withForm !== undefined ? { values: valuesOf(form) } : {}),
    ...(element.dataset.seen !== undefined ? { seen: event.detail ? seen : shown() } : {}),
    ...(event.detail ? {} : { hotkey: element.dataset.hotkey }),
    shift: event.shiftKey || undefined,
    again: again || undefined,
  });
  // The next key is meant for the page, unless the element was reached with the keyboard.
  if (event.detail) element.blur?.();
});

document.addEventListener("change", (event) => {
  const element = event.target.closest("[data-change]");
  if (!element) return;
  const value = element.type === "checkbox" ? element.checked : element.value;
  const form = element.dataset.withForm !== undefined && element.closest("form");
  request(element.dataset.change, { ...dataOf(element), value, ...(form ? { values: valuesOf(form) } : {}) });
  if (element.type === "number") element.value = element.defaultValue; // until the server confirms the value
  // As after a click on a button: the next key is meant for the page.
  if (element.matches("select, [type=checkbox]:not(form *)") && !element.matches(":focus-visible")) element.blur();
});

// Typed text is sent once the person pauses or does something else.
let typed = null;
function sendTyped() {
  const last = typed;
  typed = null;
  if (!last) return;
  clearTimeout(last.timer);
  request(last.what, last.data);
}
document.addEventListener("input", (event) => {
  const element = event.target.closest("[data-input]");
  if (!element) return;
  if (typed?.element === element) clearTimeout(typed.timer);
  else sendTyped();
  const form = element.dataset.withForm !== undefined && element.closest("form");
  const data = { ...dataOf(element), value: element.value, ...(form ? { values: valuesOf(form) } : {}) };
  delete data.input;
  const timer = setTimeout(sendTyped, element.type === "range" ? 30 : 150);
  typed = { element, what: element.dataset.input, data, timer };
});

document.addEventListener("submit", (event) => {
  const form = event.target.closest("form[data-submit]");
  if (!form) return;
  event.preventDefault();
  request(form.dataset.submit, { ...dataOf(form), values: valuesOf(form), again: again || undefined });
});

document.documentElement.lang = "en";

// The theme is the browser's own unless the person chose one.
export function applyTheme(choice) {
  const dark = choice ? choice === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  window.studioField?.recolor();
}
window.studioTheme = () => {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  try {
    localStorage.setItem("hitab-theme", next);
  } catch {}
  applyTheme(next);
};
let kept = null;
try {
  kept = localStorage.getItem("hitab-theme");
} catch {}
applyTheme(kept);
document.addEventListener("click", (event) => {
  if (event.target.closest("[data-theme-toggle]")) window.studioTheme();
});

// An open dialog keeps the keyboard focus; when it closes, the focus returns to its former place.
let dialog = null;
let before = null;
new MutationObserver(() => {
  const modal = document.querySelector("[data-modal]")?.firstElementChild ?? null;
  if (modal === dialog) return;
  if (!dialog) before = document.activeElement;
  dialog = modal;
  for (const part of document.querySelectorAll("#studio > :not(#panel-dialog, #panel-messages, #panel-emergency, #panel-tutorial)")) {
    part.inert = !!modal;
  }
  const first = modal?.querySelector("[autofocus]") ?? modal?.querySelector("input, select, button");
  if (first) first.focus({ preventScroll: true }); // a long dialog begins at its top
  else if (before?.isConnected) before.focus();
}).observe(document.body, { childList: true, subtree: true });
