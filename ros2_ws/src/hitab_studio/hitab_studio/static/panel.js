// A part of the page with HTML from the server. New HTML is patched into the old elements, so that
// the focus, the scroll position and typed text stay.
//
// While the pointer is down, patches wait until after the click, so that nothing moves under it.
let pressed = false;
const waiting = new Set();
function press(event) {
  pressed = event.target.id !== "minute"; // a drag on the strip shows what is there meanwhile
}
function release() {
  if (!pressed) return;
  // The browser dispatches the click right after the pointer is up.
  setTimeout(() => {
    pressed = false;
    for (const patch of waiting) patch();
    waiting.clear();
  });
}
addEventListener("pointerdown", press, true);
for (const name of ["pointerup", "pointercancel", "blur"]) addEventListener(name, release, true);

export default {
  template: "<div></div>",
  props: { html: String },
  mounted() {
    this.patch();
  },
  watch: {
    html() {
      this.patch();
    },
  },
  methods: {
    patch() {
      if (pressed) {
        waiting.add(this.patch);
        return;
      }
      const wanted = document.createElement("template");
      wanted.innerHTML = this.html || "";
      patchChildren(this.$el, wanted.content);
    },
  },
};

// Elements with different actions have different keys, so that a button never turns into another.
function keyOf(node) {
  if (node.nodeType !== 1) return "";
  const { key, do: does, kind, name, number } = node.dataset;
  return key || node.id || (does ? `${does} ${kind || ""} ${name || ""} ${number || ""}` : "");
}

function alike(a, b) {
  return a.nodeType === b.nodeType && a.nodeName === b.nodeName && keyOf(a) === keyOf(b);
}

function patchChildren(there, wanted) {
  let now = there.firstChild;
  for (const next of [...wanted.childNodes]) {
    let same = now;
    if (now && !alike(now, next) && keyOf(next)) {
      for (same = now.nextSibling; same && !alike(same, next); same = same.nextSibling);
    }
    if (same && alike(same, next)) {
      if (same !== now) there.insertBefore(same, now);
      else now = now.nextSibling;
      patchNode(same, next);
    } else {
      there.insertBefore(next, now);
    }
  }
  while (now) {
    const after = now.nextSibling;
    there.removeChild(now);
    now = after;
  }
}

function patchNode(there, wanted) {
  if (there.nodeType !== 1) {
    if (there.nodeValue !== wanted.nodeValue) there.nodeValue = wanted.nodeValue;
    return;
  }
  if (there.tagName === "CANVAS" || there.isEqualNode(wanted)) return; // keep the drawing
  const typed = there.type !== "number" || there.value !== there.defaultValue;
  const mine = (document.activeElement === there && typed) || there.dataset.kept !== undefined;
  // A person's input stays, unless the server has changed the value.
  const changed = ["value", "checked", "name", "type"].some(
    (name) => there.getAttribute(name) !== wanted.getAttribute(name),
  );
  for (const { name, value } of [...wanted.attributes]) {
    if (name !== "open" && there.getAttribute(name) !== value) there.setAttribute(name, value);
  }
  for (const { name } of [...there.attributes]) {
    // The person opens and closes <details>.
    if (name !== "open" && !wanted.hasAttribute(name)) there.removeAttribute(name);
  }
  if (there.tagName === "INPUT" && changed && !mine) {
    if (there.type === "checkbox") there.checked = wanted.hasAttribute("checked");
    else there.value = wanted.getAttribute("value") || "";
  }
  if (there.tagName !== "TEXTAREA") patchChildren(there, wanted);
}
