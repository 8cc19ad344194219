"""Operations: everything that can be done to an agent, each with its fields and its effect.

    a key, a verb, a step of a lesson, a button of the studio
        |
        v
    an operation            data with an id, such as Undo(id="5f0c", by="ann")
        |
        v
    SwarmClient.do          sends it to the service of its name, again until it is answered
        |
        v
    Agent.do                an id that was done before is answered; any other is applied
        |
        v
    the trainer             decides what the operation means: examples, or another mode
        |
        v
    the journal             keeps the decision with the id, before the agent follows it
        |
        v
    an outcome              the answer, which names what was done and the next steps

The fields of a service in `hitab_msgs` have the names of those here. So have options of verbs,
keys of lessons and inputs of the studio, which are made from them. What loads the learning code is
imported where it is used: programs that only send operations, such as `hitab undo`, start faster.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from hitab_core.errors import LibraryError, TrainingError, VocabularyError
from hitab_core.library.expectation import broken_expectations
from hitab_core.mode import Mode
from hitab_core.operation import Operation, Outcome, Shipment
from hitab_core.remedies import Fix
from hitab_core.term import Term
from hitab_core.training.events import Given
from hitab_core.wording import quantity

if TYPE_CHECKING:
    from hitab_core.agent import Agent
    from hitab_core.training_session import TrainingSession

# -- training -------------------------------------------------------------------------------


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
            self.parameters.values(),
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
        term = _term(self.behavior, self.targets)
        if agent.stopped and not agent.repertoire.stands_still(term):
            # The example would record something that the robot did not do.
            raise TrainingError(agent.stopped, Fix.ARM(robot=agent.name))
        given = Given(0, self.seen, self.pace, exact=self.exact, who=self.by)
        taught = agent.command(term, given, unrecorded=self.unrecorded)
        session = _training(agent)
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
        session, remedies = _training(agent), []
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
class Undo(Operation):
    """Undo the last command, deletion or other edit.

    Undoing a command makes the agent perform its previous behavior again.
    """

    def apply(self, agent: Agent) -> Outcome:
        """Undo."""
        session = _training(agent)
        session.undo()
        return _edited(session, f"undone: {session.log.history.undone[0]}")


@dataclass(frozen=True)
class Redo(Operation):
    """Redo what was undone last, if nothing else was done since."""

    def apply(self, agent: Agent) -> Outcome:
        """Redo."""
        session = _training(agent)
        session.redo()
        return _edited(session, f"redone: {session.log.history.done[-1]}")


@dataclass(frozen=True)
class DeleteExamples(Operation):
    """Delete examples; undoing brings them back.

    Attributes:
        numbers: numbers of the examples.
    """

    numbers: Sequence[int]

    def apply(self, agent: Agent) -> Outcome:
        """Delete the examples."""
        session = _training(agent)
        session.delete(self.numbers)
        return _edited(session)


@dataclass(frozen=True)
class RelabelExamples(Operation):
    """Change the next state of examples; undoing reverts this.

    Attributes:
        numbers: numbers of the examples.
        next_state: the right next state, with its targets and numbers, if any.
    """

    numbers: Sequence[int]
    next_state: str

    def apply(self, agent: Agent) -> Outcome:
        """Change the examples."""
        session = _training(agent)
        session.relabel(self.numbers, Term.parse(self.next_state))
        return _edited(session)


@dataclass(frozen=True)
class RetimeExamples(Operation):
    """Correct late commands: date them back to an earlier percept of the agent.

    Attributes:
        numbers: numbers of examples; of a command all are retimed.
        ago: time from the situation to the command, s of simulated time.
    """

    numbers: Sequence[int]
    ago: float

    def apply(self, agent: Agent) -> Outcome:
        """Change the examples."""
        session = _training(agent)
        session.retime(self.numbers, self.ago)
        return _edited(session)


@dataclass(frozen=True)
class ChooseFeatures(Operation):
    """Learn from other features of the same examples.

    Attributes:
        features: all that examples will have, such as ``"DistanceTo(ball)"``.
    """

    features: Sequence[str]

    def apply(self, agent: Agent) -> Outcome:
        """Choose the features."""
        session = _training(agent)
        session.choose_features(list(map(Term.parse, self.features)))
        return _edited(session)


@dataclass(frozen=True)
class AnswerQuestion(Operation):
    """Answer a question of the agent.

    Attributes:
        number: number of the question.
        choice: one of its choices; empty for the proposed one.
        dismiss: do not ask this again; nothing changes.
    """

    number: int
    choice: str = ""
    dismiss: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Change the examples as the answer says."""
        session = _training(agent)
        session.answer(self.number, self.choice, dismiss=self.dismiss)
        if self.dismiss:
            return Outcome(f"question {self.number} is not asked again")
        done = session.log.history.done[-1] if session.log.history.done else "nothing"
        return Outcome(f"question {self.number}: {done}")


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


# -- performing -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Perform(Operation):
    """Perform a behavior as the top-level one, from Start; a training is kept.

    Attributes:
        behavior: the behavior; empty to perform nothing.
        targets: targets for its parameters, such as ball; its numbers, such as direction=40.
    """

    behavior: str = ""
    targets: Sequence[str] = ()

    def apply(self, agent: Agent) -> Outcome:
        """Perform the behavior."""
        term = _term(self.behavior, self.targets) if self.behavior else None
        agent.perform(term)
        done = f"{agent.name} performs {term or 'nothing'}"
        if agent.session is None:
            return Outcome(done)
        examples = quantity(agent.unsaved, "example")
        done += f'; the training of "{agent.training}" ({examples}) is kept'
        return Outcome(done, [Fix.RESUME(agent=agent.name)])


@dataclass(frozen=True)
class SetCaution(Operation):
    """Set what the agent does when it is unsure of a decision.

    Attributes:
        when_unsure: ``go_on``, ``halt`` or ``hand_back``.
        distance: it is unsure farther from any example, in spreads of the examples; 0 for any
            distance.
    """

    when_unsure: str
    distance: float = 0.0

    def apply(self, agent: Agent) -> Outcome:
        """Set it."""
        from hitab_core.assistant.caution import Caution

        caution = Caution.parse(self.when_unsure, self.distance)
        agent.monitor.set(caution)
        return Outcome(f"{agent.name}: {caution}")


# -- the library ----------------------------------------------------------------------------


@dataclass(frozen=True)
class LoadLibrary(Operation):
    """Read the library again, or another one.

    Attributes:
        path: its folder; empty for the same again.
    """

    path: str = ""

    def apply(self, agent: Agent) -> Outcome:
        """Read the library."""
        from hitab_core.library.behavior_file import BEHAVIOR_SUFFIX

        other = None
        if self.path:
            folder = Path(os.path.expanduser(self.path))
            if not folder.is_absolute() or not folder.is_dir():
                raise LibraryError(
                    f'"{self.path}" is not a folder here; give the absolute path of a library'
                )
            if any(folder.iterdir()) and not any(folder.glob(f"*{BEHAVIOR_SUFFIX}")):
                raise LibraryError(
                    f"{folder} contains files but no behaviors (*{BEHAVIOR_SUFFIX}); give "
                    "the path of a library, or of an empty folder for a new one"
                )
            other = agent.open_library(folder, agent.domain)
        behaviors, loaded = agent.reload(other), agent.loaded
        broken = [text for file in loaded.files.values() for text in file.broken]
        done = "; but ".join([quantity(len(behaviors), "trained behavior"), *broken])
        return Outcome(done, behaviors=behaviors, digest=loaded.digest)


@dataclass(frozen=True)
class Distribute(Operation):
    """Send a behavior of the library, with all its parts, to other agents.

    Attributes:
        behavior: the behavior.
        targets: targets for its parameters, such as ball; its numbers, such as direction=40.
        receivers: names of the receivers; empty for all.
        start: have them begin performing it, at Start.
    """

    behavior: str
    targets: Sequence[str] = ()
    receivers: Sequence[str] = ()
    start: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Send the behavior."""
        from hitab_core.library.bundle import make_bundle

        term = _term(self.behavior, self.targets)
        agent.check_saved(term.name)
        if self.start:
            agent.repertoire.check_state(term)
        agent.repertoire.get(term.name)  # unless it is unknown or lost
        if term.name not in agent.loaded.files:
            raise VocabularyError(
                f'"{term.name}" does not need to be sent: it comes with domain '
                f'"{agent.domain.name}", which its agents have'
            )
        bundle = make_bundle(agent.loaded.texts, agent.repertoire, term.name)
        number = agent.send(Shipment(bundle, term, self.receivers, self.start))
        broken = [text for name, _ in bundle.files for text in agent.loaded.files[name].broken]
        done = "; but ".join([f"sent {quantity(len(bundle.files), 'behavior')}", *broken])
        return Outcome(done, digest=bundle.digest, sequence=number)


# -- words of outcomes ----------------------------------------------------------------------


def _term(behavior: str, targets: Sequence[str]) -> Term:
    """Return a behavior with its targets, which may be part of the name, as in ``GoTo(ball)``."""
    term = Term.parse(behavior)
    return Term(term.name, (*term.arguments, *targets))


def _training(agent: Agent) -> TrainingSession:
    if agent.session is None:
        ways = Fix.RESUME(agent=agent.name), Fix.TRAIN(agent=agent.name)
        raise TrainingError("it is not training anything", *ways)
    return agent.session


def _unsaved(agent: Agent) -> str:
    """Describe the training under way; empty if it has no examples."""
    if not agent.unsaved:
        return ""
    return f'"{agent.training}" with {quantity(agent.unsaved, "unsaved example")}'


def _edited(session: TrainingSession, done: str = "") -> Outcome:
    done = done or (session.log.history.done or ["nothing"])[-1]
    count = quantity(len(session.log), "example")
    return Outcome(f'{done}; "{session.curriculum.name}" has {count}')


def _open_questions(agent: Agent) -> str:
    """Return how many questions about a training are open, as far as known; empty if none."""
    known = agent.session.questions.known() if agent.session is not None else []
    if not known:
        return ""
    text = quantity(len(known), "open question")
    if clashes := sum(question.kind == "contradiction" for question in known):
        text += f", {clashes} of contradicting commands, where it decides by chance"
    return text


OPERATIONS = {kind.name: kind for kind in Operation.__subclasses__()}
"""All operations, by name."""
