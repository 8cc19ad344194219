// An arrow dragged from an agent commands a behavior with a direction, repeatedly while it moves.
const EVERY_MS = 200;

// Returns the open form of a behavior with a direction, if an arrow from thing i sets it.
function formOf(field, i) {
  const form = document.querySelector("form[data-arrow]");
  return form && i >= 0 && field.roster.names[i] === form.dataset.agent ? form : null;
}

export function arrowOf(field, i) {
  return formOf(field, i) && { to: null, at: 0, cycle: field.now.cycle, shown: false };
}

export function aim(field, drag, event) {
  const { arrow } = drag;
  arrow.to = field.toField(event.offsetX, event.offsetY);
  // In a paused world the situation does not change, so only the final direction is sent.
  const due = performance.now() - arrow.at > EVERY_MS && field.now.cycle !== arrow.cycle;
  if (due && !document.querySelector(".overlay .busy")) show(field, drag);
}

export function letGo(field, drag) {
  if (!drag.arrow.shown || field.now.cycle !== drag.arrow.cycle) show(field, drag);
}

// Directions are counter-clockwise from the agent's heading.
function show(field, { i, arrow }) {
  const form = formOf(field, i);
  if (!form) return; // the form was closed meanwhile
  const { to } = arrow;
  const [x, y, heading] = field.now.places.subarray(3 * i, 3 * i + 3);
  const [low, high] = [Number(form.dataset.low), Number(form.dataset.high)];
  const turns = (Math.atan2(to[1] - y, to[0] - x) - heading) / (2 * Math.PI);
  const whole = high - low;
  const value = low + ((((turns * whole - low) % whole) + whole) % whole);
  Object.assign(arrow, { at: performance.now(), cycle: field.now.cycle, shown: true });
  const values = { ...Object.fromEntries(new FormData(form)), [form.dataset.arrow]: value };
  window.studioTell("show", { values, seen: field.shown });
}

export function drawArrow(field, c, screen) {
  const { i, arrow } = field.drag ?? {};
  if (!arrow?.to) return;
  const [px, py] = screen.subarray(3 * i, 3 * i + 2);
  const [x, y] = field.toScreen(...arrow.to);
  const angle = Math.atan2(y - py, x - px);
  c.strokeStyle = field.colors.accent;
  c.lineWidth = 3;
  c.beginPath();
  c.moveTo(px, py);
  c.lineTo(x, y);
  for (const side of [-0.45, 0.45]) {
    c.moveTo(x, y);
    c.lineTo(x - 12 * Math.cos(angle + side), y - 12 * Math.sin(angle + side));
  }
  c.stroke();
}
