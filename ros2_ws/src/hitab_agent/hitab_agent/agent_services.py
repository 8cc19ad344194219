"""The services of an agent, for requests that need a reply."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.question_services import QuestionServices
from hitab_agent.slices import Slices
from hitab_core import (
    FLAGS,
    OWN_FEATURES,
    Agent,
    BasicBehavior,
    BehaviorLibrary,
    Caution,
    Domain,
    LibraryError,
    Mode,
    TrainingError,
    Use,
    has,
    quantity,
    unknown,
)
from hitab_core.library import SUFFIX
from hitab_core.training import Curriculum, TrainingSession
from hitab_ros import GuardedNode, names
from hitab_ros.answering import Serve, answering
from hitab_ros.conversions import cost_message, example_message, feature_message, use_of


class AgentServices:
    """Offers an agent's services; a refusal is a reply with ``success`` false and the reason."""

    def __init__(
        self,
        node: GuardedNode,
        agent: Agent,
        library: Callable[[Path, Domain], BehaviorLibrary],
        answered: Callable[[str], None],
    ) -> None:
        """Offer the services.

        Args:
            node: to offer them on.
            agent: the agent that they control.
            library: returns the library in a folder, for a domain.
            answered: called before the reply to a request that may have changed the agent, with
                the reason for a refusal, or "".
        """
        self._agent = agent
        self._library = library
        offered: list[tuple[Any, str, Serve]] = [
            (srv.BeginTraining, names.BEGIN, self._begin),
            (srv.SetMode, names.SET_MODE, self._set_mode),
            (srv.EditExamples, names.EDIT_EXAMPLES, self._edit_examples),
            (srv.ListExamples, names.LIST_EXAMPLES, self._list_examples),
            (srv.SaveBehavior, names.SAVE, self._save),
            (srv.Perform, names.PERFORM, self._perform),
            (srv.LoadLibrary, names.LOAD_LIBRARY, self._load_library),
            (srv.GetReport, names.GET_REPORT, self._get_report),
            (srv.SetCaution, names.SET_CAUTION, self._set_caution),
        ]
        for kind, name, serve in offered:
            node.create_service(kind, name, answering(serve, answered))
        node.create_service(srv.GetVocabulary, names.GET_VOCABULARY, self._get_vocabulary)
        QuestionServices(node, agent, answered, Slices(node))

    def _begin(self, request: srv.BeginTraining.Request, response: Any) -> str:
        curriculum = Curriculum.parse(
            request.automaton,
            request.features,
            request.states,
            request.parameters,
            request.arguments,
            request.classifier or "tree",
        )
        given_up = self._under_way()
        session = self._agent.begin(curriculum, resume=request.resume, discard=request.discard)
        done = [f'training "{session.curriculum.name}"']
        if len(session.log):
            done[0] += f" with {quantity(len(session.log), 'example')}"
        if given_up:
            done.append(f"discarded {given_up}")
        done += self._replaced(session.curriculum.name, resumed=bool(request.resume))
        done += self._without_features(session)
        return "; ".join(done)

    def _replaced(self, name: str, *, resumed: bool) -> list[str]:
        """Say what saving will replace, and how to go on with that instead."""
        saved = self._agent.edition.files.get(name)
        if saved is None or resumed:
            return []
        agent, examples = self._agent.name, len(saved.automaton.examples)
        if not examples:
            return [f'saving it will replace the "{name}" in the library']
        return [
            f'saving it will replace the "{name}" in the library, which has '
            f"{quantity(examples, 'example')}. To go on from these instead: "
            f"`hitab train {agent} {name} --resume`, with other features if -f names them"
        ]

    def _without_features(self, session: TrainingSession) -> list[str]:
        if session.curriculum.features:
            return []
        agent = self._agent.name
        return [
            "no feature is chosen, so it cannot tell situations apart yet. Choose by what it "
            f"decides, now or later: `hitab examples features {agent} -f FEATURE`; "
            f"`hitab vocabulary {agent}` lists the features"
        ]

    def _under_way(self) -> str:
        """Describe the training under way; empty if it has no examples."""
        agent = self._agent
        if not agent.unsaved:
            return ""
        return f'"{agent.training}" with {quantity(agent.unsaved, "unsaved example")}'

    def _set_mode(self, request: srv.SetMode.Request, response: Any) -> str:
        if request.discard:
            return self._discard(request.mode)
        match request.mode:
            case Mode.TESTING:
                self._agent.test(restart=request.restart)
            case Mode.TRAINING:
                self._agent.take_over()
            case Mode.IDLE:
                return self._kept_aside(lambda: self._agent.perform(None), "is idle")
            case mode:
                known = (Mode.TESTING, Mode.TRAINING, Mode.IDLE)
                raise TrainingError(unknown("mode", mode, known))
        agent = self._agent
        done = f'{agent.name} is {agent.mode} "{agent.training}"'
        if agent.mode is Mode.TESTING and (open_ones := _open_questions(agent)):
            done += f"; it has {open_ones}; `hitab questions {agent.name}` shows what it asks"
        return done

    def _discard(self, mode: str) -> str:
        if mode != Mode.IDLE:
            raise TrainingError(
                f"a training can be discarded only by an agent that goes idle; set mode "
                f'"{Mode.IDLE}", not "{mode}"'
            )
        training, session = self._agent.training, self._agent.session
        saved = self._agent.repertoire.automata.get(training)
        if not training:
            given_up = "the interrupted training"
        elif not self._agent.unsaved:
            given_up = f'"{training}", which had no examples'
        elif session and saved and tuple(session.examples) == tuple(saved.examples):
            given_up = f'the training of "{training}", which stays as it was saved'
        else:
            given_up = self._under_way()
        self._agent.discard()
        return f"{self._agent.name} is {self._agent.mode}; discarded {given_up}"

    def _edit_examples(self, request: srv.EditExamples.Request, response: Any) -> str:
        session = self._training()
        edits = srv.EditExamples.Request
        match request.action:
            case edits.UNDO:
                session.undo()
            case edits.REDO:
                session.redo()
            case edits.DELETE:
                session.delete(request.numbers)
            case edits.RELABEL:
                session.relabel(request.numbers, Use.parse(request.next_state))
            case edits.RETIME:
                session.retime(request.numbers, request.ago)
            case edits.FEATURES:
                session.choose_features(list(map(Use.parse, request.features)))
            case action:
                known = (
                    edits.UNDO,
                    edits.REDO,
                    edits.DELETE,
                    edits.RELABEL,
                    edits.RETIME,
                    edits.FEATURES,
                )
                raise TrainingError(unknown("action", action, known))
        return f'"{session.curriculum.name}" has {quantity(len(session.log), "example")}'

    def _training(self) -> TrainingSession:
        session = self._agent.session
        if session is None:
            raise TrainingError(_no_training(self._agent, "begin one with `hitab train {} NAME`"))
        return session

    def _set_caution(self, request: srv.SetCaution.Request, response: Any) -> str:
        caution = Caution.parse(request.when_unsure, request.support, request.distance)
        self._agent.monitor.set(caution)
        return f"{self._agent.name}: {caution}"

    def _list_examples(self, request: srv.ListExamples.Request, response: Any) -> str:
        session = self._agent.session
        if request.automaton:
            automata, name = self._agent.repertoire.automata, request.automaton
            if name not in automata:
                raise TrainingError(f'no trained behavior "{name}" {has(automata, name)}')
            features, examples = automata[name].features, automata[name].examples
            readable = automata[name].readable
        elif session is not None:
            name, features = session.curriculum.name, session.curriculum.features
            examples, readable = session.examples, session.readable
            response.done, response.undone = session.log.history.done, session.log.history.undone
        else:
            raise TrainingError(
                _no_training(self._agent, "name a trained behavior: `hitab examples list {} NAME`")
            )
        response.automaton = name
        response.features = [str(feature) for feature in features]
        response.readable = [str(use) for use in readable]
        response.examples = [example_message(example) for example in examples]
        return quantity(len(examples), "example")

    def _get_report(self, request: srv.GetReport.Request, response: Any) -> str:
        agent = self._agent
        name = request.automaton or agent.training
        if not name:
            raise TrainingError(
                _no_training(
                    agent, "name a trained behavior: `hitab examples list {} NAME --cost`"
                )
            )
        costs = agent.journal.costs(name)
        if not costs and name == agent.training:
            raise TrainingError(
                f'nothing was done yet in the training of "{name}"; command a behavior with '
                f"`hitab demonstrate {agent.name} BEHAVIOR`"
            )
        if not costs:
            raise TrainingError(
                f'{agent.name} has no record of a training of "{name}" '
                f"{has(agent.journal.trained(), name)}; ask the agent that was trained"
            )
        response.costs = [cost_message(cost) for cost in costs]
        return quantity(len(costs), "training")

    def _save(self, request: srv.SaveBehavior.Request, response: Any) -> str:
        if len(request.bind_from) != len(request.bind_to):
            raise TrainingError(
                f"bind_from has {quantity(len(request.bind_from), 'name')}, "
                f"bind_to {len(request.bind_to)}"
            )
        bindings = dict(zip(request.bind_from, request.bind_to, strict=True))
        agent = self._agent
        performed = agent.behavior if agent.mode is Mode.PERFORMING else ""
        open_ones = _open_questions(agent)
        automaton, path, trimmed, replaced = self._agent.save(
            request.name, bindings, request.description, keep_unused=request.keep_unused
        )
        response.path = str(path)
        response.digest = self._agent.edition.files[automaton.name].checksum
        response.trimmed = trimmed
        response.replaced = replaced
        saved = Use(automaton.name, automaton.parameters)
        done = f'saved "{saved}" with {quantity(len(automaton.examples), "example")}'
        done += f"; {replaced}" if replaced else ""
        if open_ones:
            done += (
                f"; it had {open_ones}; to answer, `hitab train {agent.name} {automaton.name} "
                f"--resume` and `hitab questions {agent.name}`"
            )
        if performed and self._agent.mode is Mode.IDLE:
            done += f'; {self._agent.name} is idle now: it can no longer perform "{performed}"'
        return done

    def _perform(self, request: srv.Perform.Request, response: Any) -> str:
        use = use_of(request.behavior, request.arguments) if request.behavior else None
        return self._kept_aside(lambda: self._agent.perform(use), f"performs {use or 'nothing'}")

    def _kept_aside(self, perform: Callable[[], None], done: str) -> str:
        """Have the agent perform something; say what becomes of a training under way."""
        agent = self._agent
        perform()
        if agent.session is None:
            return f"{agent.name} {done}"
        return (
            f'{agent.name} {done}; the training of "{agent.training}" '
            f"({quantity(agent.unsaved, 'example')}) is kept: `hitab train {agent.name}` goes on "
            "with it"
        )

    def _load_library(self, request: srv.LoadLibrary.Request, response: Any) -> str:
        library = None
        if request.path:
            folder = Path(os.path.expanduser(request.path))
            if not folder.is_absolute() or not folder.is_dir():
                raise LibraryError(
                    f'"{request.path}" is not a folder here; give the absolute path of a library'
                )
            if any(folder.iterdir()) and not any(folder.glob(f"*{SUFFIX}")):
                raise LibraryError(
                    f"{folder} contains files but no behaviors (*{SUFFIX}); give the path of a "
                    "library, or of an empty folder for a new one"
                )
            library = self._library(folder, self._agent.domain)
        response.behaviors = self._agent.reload(library)
        response.digest = self._agent.edition.digest
        known = quantity(len(response.behaviors), "trained behavior")
        return "; ".join((known, *self._agent.edition.losses.faults))

    def _get_vocabulary(
        self, request: srv.GetVocabulary.Request, response: srv.GetVocabulary.Response
    ) -> srv.GetVocabulary.Response:
        agent = self._agent
        domain, repertoire = agent.domain, agent.repertoire
        behaviors = [repertoire.get(name) for name in repertoire.names()]
        features = sorted(domain.features.values(), key=lambda feature: feature.name)
        response.domain = domain.name
        response.signature = domain.signature
        response.behaviors = [
            msg.Behavior(
                name=str(Use(b.name, b.parameters)),
                description=b.description,
                trained=b.name in agent.edition.files,
                one_shot=isinstance(b, BasicBehavior) and b.one_shot,
            )
            for b in behaviors
        ]
        words = [(Use(f.name, f.parameters), f) for f in features]
        words += [(use, domain.feature(use.name)) for use in OWN_FEATURES if use.name not in FLAGS]
        response.features = [feature_message(str(use), feature) for use, feature in words]
        response.targets = sorted(domain.targets)
        return response


def _open_questions(agent: Agent) -> str:
    """Return how many questions about a training are open, as far as known; empty: none."""
    session = agent.session
    known = session.asked.known(session.log) if session is not None else []
    if not known:
        return ""
    told = quantity(len(known), "open question")
    if clashes := sum(question.kind == msg.Question.CONTRADICTION for question in known):
        told += f", {clashes} of contradicting commands, where it decides by chance"
    return told


def _no_training(agent: Agent, way_out: str) -> str:
    """Return that an agent is not training anything.

    Args:
        agent: the agent.
        way_out: what to do, with ``{}`` for its name.
    """
    return f"{agent.name} is not training anything; {way_out.format(agent.name)}"
