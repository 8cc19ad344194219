// What a person has filled in in a dialog stays: also if a part of the dialog goes and comes back,
// as its features do while the agent does not answer, if the dialog is closed because its swarm
// ends, and if the page is loaded again after the connection was lost. It is forgotten once the
// form is sent or the person closes it.
//   data-draft="name" of a form: under which name it is kept, in this tab of the browser
const place = (form) => `hitab-draft ${form.dataset.draft}`;
const controls = (form) => [...form.elements].filter((e) => e.name && e.type !== "hidden" && e.type !== "submit");
const isBox = (control) => control.type === "checkbox";
const nameOf = (control) => (isBox(control) ? `${control.name} ${control.value}` : control.name);

function kept(name) {
  try {
    return JSON.parse(sessionStorage.getItem(name)) || {};
  } catch {
    return {};
  }
}

function keep(form) {
  const draft = kept(place(form)); // what is not there at the moment stays in it
  for (const control of controls(form)) {
    const [now, first] = isBox(control)
      ? [control.checked, control.defaultChecked]
      : [control.value, control.tagName === "SELECT" ? null : control.defaultValue];
    if (now === first) delete draft[nameOf(control)];
    else draft[nameOf(control)] = now;
  }
  try {
    sessionStorage.setItem(place(form), JSON.stringify(draft));
  } catch {}
}

let open = null; // the name under which the open form is kept
let done = false; // whether the person has sent it or closed it
const filled = new WeakSet();

function changed({ target }) {
  const form = target.closest?.("form[data-draft]");
  if (!form) return;
  done = false;
  keep(form);
}
document.addEventListener("input", changed);
document.addEventListener("change", changed);
document.addEventListener("submit", ({ target }) => target.matches("[data-draft]") && (done = true));
document.addEventListener("click", ({ target }) => target.closest("form[data-draft] [data-do=close]") && (done = true), true);
document.addEventListener("keydown", ({ key }) => key === "Escape" && open && (done = true), true);

new MutationObserver(() => {
  const form = document.querySelector("form[data-draft]");
  const name = form ? place(form) : null;
  if (name !== open) {
    if (open && done) sessionStorage.removeItem(open);
    open = name;
    done = false;
  }
  if (!form) return;
  let draft = null;
  for (const control of controls(form)) {
    if (filled.has(control)) continue;
    filled.add(control);
    draft ??= kept(name);
    const value = draft[nameOf(control)];
    if (value === undefined) continue;
    if (isBox(control)) control.checked = value;
    else control.value = value;
    // What the server makes of it, such as the features of a parameter.
    if (control.dataset.input) control.dispatchEvent(new Event("input", { bubbles: true }));
  }
}).observe(document.body, { childList: true, subtree: true });
