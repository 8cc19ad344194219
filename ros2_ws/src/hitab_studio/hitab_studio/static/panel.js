// A part of the page that the server describes as HTML. What is there is changed into what should
// be there piece by piece, so that focus, scrolling and what was typed stay.
//
// Nothing moves under a finger: while the pointer is down, what is there stays until the click that
// it may become has been heard.
let pressed = false;
const waiting = new Set();
function press() {
  pressed = true;
}
function release() {
  if (!pressed) return;
  // A click comes right after the pointer has gone up.
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

// What does something else is another element: a button never becomes the one beside it.
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
  if (there.tagName === "CANVAS" || there.isEqualNode(wanted)) return; // what is drawn stays
  const typed = there.type !== "number" || there.value !== there.defaultValue;
  const mine = (document.activeElement === there && typed) || there.dataset.kept !== undefined;
  // What a person has filled in stays, unless the server describes another value than before.
  const told = ["value", "checked", "name", "type"].some(
    (name) => there.getAttribute(name) !== wanted.getAttribute(name),
  );
  for (const { name, value } of [...wanted.attributes]) {
    if (name !== "open" && there.getAttribute(name) !== value) there.setAttribute(name, value);
  }
  for (const { name } of [...there.attributes]) {
    // <details> that a person has opened or closed stay so.
    if (name !== "open" && !wanted.hasAttribute(name)) there.removeAttribute(name);
  }
  if (there.tagName === "INPUT" && told && !mine) {
    if (there.type === "checkbox") there.checked = wanted.hasAttribute("checked");
    else there.value = wanted.getAttribute("value") || "";
  }
  if (there.tagName !== "TEXTAREA") patchChildren(there, wanted);
}
