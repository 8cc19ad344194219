"""Operations that train an agent: begin, command, test, take over, save, discard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from hitab_core.library.expectation import broken_expectations
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.remedies import Fix
from hitab_core.texts.wording import quantity
from hitab_core.training.events import Given
from hitab_core.training.operation import Operation, Outcome

if TYPE_CHECKING:
    from hitab_core.agent import Agent

MOMENT = frozenset({"seen", "pace", "exact"})
"""Fields of a command that tell for which percept it is meant; by default, for the last one."""


@dataclass(frozen=True)
class BeginTraining(Operation):
    """Begin to train an automaton.

    Attributes:
        automaton: its name.
        features: features for the decisions, such as ``"DistanceTo(ball)"``.
        states: behaviors that may be commanded; empty for any.
        parameters: free variables of the automaton, each with its target in training.
        resume: a trained behavior whose examples to continue, or a version, such as ``Chase@2``.
        classifier: classifier to learn with; empty for the transition tree.
        discard: give up an unsaved training.
    """

    automaton: str
    features: Sequence[str] = ()
    states: Sequence[str] = ()
    parameters: Mapping[str, str] = field(default_factory=dict)
    resume: str = ""
    classifier: str = ""
    discard: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Begin the training."""
        from hitab_core.training.curriculum import Curriculum

        curriculum = Curriculum.parse(
            self.automaton,
            self.features,
            self.states,
            self.parameters,
            self.classifier or "tree",
        )
        given_up = _unsaved(agent)
        session = agent.begin(curriculum, resume=self.resume, discard=self.discard)
        name, remedies = session.curriculum.name, []
        done = [f'training "{name}"']
        if len(session.log):
            done[0] += f" with {quantity(len(session.log), 'example')}"
        if given_up:
            done.append(f"discarded {given_up}")
        saved = agent.loaded.files.get(name)
        if saved is not None and not self.resume:
            examples = quantity(len(saved.automaton.examples), "example")
            done.append(f'saving it will replace the "{name}" in the library, with {examples}')
            remedies.append(Fix.TRAIN_FURTHER(agent=agent.name, behavior=name))
        if not session.curriculum.features:
            done.append("no feature is chosen, so all situations look the same to it")
            remedies += [Fix.CHOOSE_FEATURES(agent=agent.name), Fix.VOCABULARY(agent=agent.name)]
        return Outcome("; ".join(done), remedies)


@dataclass(frozen=True)
class Command(Operation):
    """Command a behavior, which the agent performs and learns from.

    Attributes:
        behavior: a behavior of the repertoire, or a flag.
        targets: targets for its parameters, such as ball; its numbers, such as direction=40.
        seen: the world's cycle that the demonstrator saw; 0 for that of the last percept.
        pace: simulated seconds in a second of the demonstrator's; 0 if the situation waited.
        exact: whether it is meant for the percept seen; else the agent estimates its delay.
        unrecorded: perform it without recording an example.
    """

    behavior: str
    targets: Sequence[str] = ()
    seen: int = 0
    pace: float = 0.0
    exact: bool = False
    unrecorded: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Perform the behavior, and record its examples."""
        term = Term.parse(self.behavior, self.targets)
        if agent.stopped and not agent.repertoire.stands_still(term):
            # The example would record something that the robot did not do.
            raise TrainingError(agent.stopped, Fix.ARM(robot=agent.name))
        given = Given(0, self.seen, self.pace, exact=self.exact, who=self.by)
        taught = agent.command(term, given, unrecorded=self.unrecorded)
        session = agent.under_way()
        left = taught[0].state if taught else ""
        done = f"{agent.name} performs {term}"
        if taught:
            done = f"{agent.name}: {left} -> {taught[0].next_state}"
        examples = quantity(len(session.log), "example")
        default = sum(example.is_default for example in session.examples)
        done += f"; {session.curriculum.name} has {examples} ({default} default)"
        done += f"; {agent.name} {session.note}" if session.note else ""
        return Outcome(done, examples=[example.number for example in taught], left=left)


@dataclass(frozen=True)
class Test(Operation):
    """Give control to the learned automaton, without a reset.

    Attributes:
        restart: begin at Start, not at the active state.
    """

    __test__: ClassVar[bool] = False  # not a test case, despite its name

    restart: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Learn from the examples, and let the automaton decide."""
        agent.test(restart=self.restart)
        session, remedies = agent.under_way(), []
        done = f'{agent.name} is {agent.mode} "{agent.training}"'
        if open_ones := _open_questions(agent):
            done += f"; it has {open_ones}"
            remedies.append(Fix.QUESTIONS(agent=agent.name))
        remarks = agent.remarks(look=True)
        done += "".join(f"; but {remark}" for remark in remarks)
        saved = agent.loaded.files.get(agent.training)
        if saved is not None:
            broken = broken_expectations(saved.expectations, session.automaton())
            done = "; but ".join([done, *broken])
        return Outcome(done, [*remedies, *(remark.remedy for remark in remarks)])


@dataclass(frozen=True)
class TakeOver(Operation):
    """Give control back to the demonstrator, in the active state."""

    def apply(self, agent: Agent) -> Outcome:
        """Let the demonstrator decide."""
        agent.take_over()
        return Outcome(f'{agent.name} is {agent.mode} "{agent.training}"')


@dataclass(frozen=True)
class SaveBehavior(Operation):
    """Trim the learned automaton, add it to the library and end the training.

    Attributes:
        automaton: its name; empty for the name that training began with.
        bindings: targets or parameters, each with what replaces it.
        description: text for people who browse the library; empty to keep the present one.
        keep_unused: keep features that nothing uses yet, to resume training with them.
    """

    automaton: str = ""
    bindings: Mapping[str, str] = field(default_factory=dict)
    description: str = ""
    keep_unused: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Save the behavior."""
        performed = agent.behavior if agent.mode is Mode.PERFORMING else ""
        open_ones, remarks = _open_questions(agent), agent.remarks(look=True)
        automaton, path, trimmed, replaced = agent.save(
            self.automaton, self.bindings, self.description, keep_unused=self.keep_unused
        )
        file = agent.loaded.files[automaton.name]
        saved = Term(automaton.name, automaton.parameters)
        done = f'saved "{saved}" with {quantity(len(automaton.examples), "example")}'
        done += f"; {replaced}" if replaced else ""
        done += f"; it had {open_ones}" if open_ones else ""
        done += "".join(f"; but {remark}" for remark in remarks)
        remedies = [remark.remedy for remark in remarks]
        if open_ones or remarks:
            remedies.insert(0, Fix.TRAIN_FURTHER(agent=agent.name, behavior=automaton.name))
        done = "; but ".join([done, *file.broken])
        if performed and agent.mode is Mode.IDLE:
            done += f'; {agent.name} is idle now: it can no longer perform "{performed}"'
        return Outcome(
            done,
            remedies,
            path=str(path),
            digest=file.checksum,
            replaced=replaced,
            trimmed=trimmed,
        )


@dataclass(frozen=True)
class DiscardTraining(Operation):
    """Give up a training with its unsaved examples; the agent is idle afterwards."""

    def apply(self, agent: Agent) -> Outcome:
        """Give the training up."""
        training, session = agent.training, agent.session
        saved = agent.repertoire.automata.get(training)
        if not training:
            given_up = "the interrupted training"
        elif not agent.unsaved:
            given_up = f'"{training}", which had no examples'
        elif session and saved and tuple(session.examples) == tuple(saved.examples):
            given_up = f'the training of "{training}", which stays as it was saved'
        else:
            given_up = _unsaved(agent)
        agent.discard()
        return Outcome(f"{agent.name} is {agent.mode}; discarded {given_up}")


def _unsaved(agent: Agent) -> str:
    """Describe the training under way; empty if it has no examples."""
    if not agent.unsaved:
        return ""
    return f'"{agent.training}" with {quantity(agent.unsaved, "unsaved example")}'


def _open_questions(agent: Agent) -> str:
    """Return how many questions about a training are open, as far as known; empty if none."""
    known = agent.session.questions.known() if agent.session is not None else []
    if not known:
        return ""
    text = quantity(len(known), "open question")
    if clashes := sum(question.kind == "contradiction" for question in known):
        text += f", {clashes} of contradicting commands, where it decides by chance"
    return text
