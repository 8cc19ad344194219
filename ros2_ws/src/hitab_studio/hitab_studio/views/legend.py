"""The keys of the page, and the words on it that a newcomer may not know."""

from __future__ import annotations

from hitab_client.demonstrating import EARLIER_SECONDS

KEYS = (
    ("Ctrl+Enter", "emergency stop: all robots stand still at once; works everywhere on the page"),
    ("1 … 0, Q …", "command the behavior whose button shows the key"),
    ("T", "test: hand back to what was learned; again: take over"),
    ("U", "undo the last command or edit"),
    ("Y", "redo it"),
    ("A", "answer the first question as it proposes"),
    (
        "B",
        f"pressed late: the last command counts for a situation {EARLIER_SECONDS:g} s earlier; "
        "press it again for more",
    ),
    ("Space", "emergency stop of all robots; in a simulated world, pause and resume it"),
    ("N", "one cycle"),
    ("R", "new episode"),
    ("Z", "undo a placement"),
    ("[ and ]", "previous and next agent"),
    ("F", "all of the field"),
    ("+ and -", "zoom in and out; the wheel too"),
    ("L", "trails"),
    ("Page Up, Page Down, Home, End", "scroll what was clicked last, else the panel at the right"),
    ("Esc", "close, give up"),
)

WORDS = (
    (
        "Emergency stop",
        "robots stand still, and simulated worlds pause, until somebody releases them; then each "
        "robot waits until it is re-armed. The page says below its header who has stopped them",
    ),
    ("Example", "a situation, the state that the agent was in, and the state to go to"),
    (
        "Default example",
        "recorded by itself with a command: otherwise, keep doing what was commanded",
    ),
    (
        "Superseded",
        "a default example that a later command contradicts: nothing is learned from it",
    ),
    (
        "Pressed late",
        "the last command came too late: it counts for an earlier situation from then on",
    ),
    (
        "When unsure",
        "what the agent does where few examples are like the situation: it goes on deciding, it "
        "halts, or it hands back to you",
    ),
    ("Parameter", "stands for a target, such as A in GotoObject(A), and is given with a command"),
    (
        "Taken out",
        "a hand-written automaton that the swarm file leaves out: it does nothing until it is "
        "trained",
    ),
    (
        "Generation",
        "a version of a behavior that the whole team performs while one agent is trained further",
    ),
)
