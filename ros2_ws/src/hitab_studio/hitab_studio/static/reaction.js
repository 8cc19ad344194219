// The game that measures how fast a person reacts: a disc appears, and the person presses Space.
const WAIT_MS = [800, 2000]; // until the disc appears
const SOONEST_MS = 100; // nobody sees and presses faster: who does has guessed

export function playReactionGame({ rounds, longest }) {
  if (document.getElementById("reaction-game")) return;
  const board = document.createElement("div");
  board.id = "reaction-game";
  board.dataset.test = "reaction-board";
  board.tabIndex = -1;
  board.setAttribute("role", "dialog");
  board.setAttribute("aria-modal", "true");
  board.setAttribute("aria-label", "Reaction time");
  board.innerHTML =
    '<p role="status"></p><button data-test="reaction-cancel">Cancel <kbd>Esc</kbd></button>' +
    '<div class="disc" data-test="disc" hidden></div>';
  const [text, cancel, disc] = board.children;
  const times = [];
  let round = 0;
  let shown = 0; // when the disc appeared; 0: it has not
  let timer;

  const say = (words) => (text.textContent = words);

  function wait(words = "") {
    disc.hidden = true;
    shown = 0;
    clearTimeout(timer);
    say(`${words}Press Space when the disc appears: ${round + 1} of ${rounds}.`);
    timer = setTimeout(show, WAIT_MS[0] + Math.random() * (WAIT_MS[1] - WAIT_MS[0]));
  }

  function show() {
    disc.style.left = `${10 + 75 * Math.random()}%`;
    disc.style.top = `${20 + 60 * Math.random()}%`;
    // It is on the screen from the next frame on.
    requestAnimationFrame(() => {
      disc.hidden = false;
      shown = performance.now();
      timer = setTimeout(next, 1000 * longest);
    });
  }

  function press(time) {
    if (!shown || time - shown < SOONEST_MS) return wait("Too early: that does not count. ");
    times.push((time - shown) / 1000);
    next();
  }

  function next() {
    round += 1;
    if (round < rounds) return wait();
    end();
    if (2 * times.length < rounds) {
      window.studioTell("why", {
        reason: "Space was pressed too rarely; measure again, or set the time.",
      });
    } else {
      window.studioTell("reaction-measured", { seconds: median(times) });
    }
  }

  function end() {
    clearTimeout(timer);
    window.removeEventListener("keydown", key, true);
    board.remove();
  }

  // No key means anything else meanwhile.
  function key(event) {
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.key === "Escape") end();
    else if (event.key === " " && !event.repeat) press(event.timeStamp);
  }

  window.addEventListener("keydown", key, true);
  board.addEventListener("pointerdown", (event) => {
    if (!cancel.contains(event.target)) press(event.timeStamp);
  });
  cancel.addEventListener("click", end);
  document.getElementById("stage").append(board);
  board.focus();
  wait();
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}
