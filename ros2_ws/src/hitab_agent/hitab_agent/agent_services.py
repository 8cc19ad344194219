"""The services of an agent, for requests that need a reply."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.training_topic import TrainingTopic
from hitab_core import (
    FLAGS,
    OWN_FEATURES,
    Agent,
    BasicBehavior,
    BehaviorLibrary,
    Caution,
    Domain,
    Fix,
    LibraryError,
    Mode,
    Request,
    Term,
    TrainingError,
    TrainingSession,
    has,
    quantity,
    unknown,
)
from hitab_core.assistant import training_costs
from hitab_core.library import BEHAVIOR_SUFFIX, broken_expectations
from hitab_core.training import Curriculum
from hitab_ros import GuardedNode, names
from hitab_ros.answering import Answered, Serve, answering
from hitab_ros.conversions import (
    cost_message,
    feature_message,
    number_messages,
    remedy_messages,
    term_of,
)


class AgentServices:
    """Offers an agent's services; a refusal is a reply with ``success`` false and the reason."""

    def __init__(
        self,
        node: GuardedNode,
        agent: Agent,
        library: Callable[[Path, Domain], BehaviorLibrary],
        answered: Answered,
        training: TrainingTopic,
    ) -> None:
        """Offer the services.

        Args:
            node: the node to offer them on.
            agent: the agent that they control.
            library: returns the library in a folder, for a domain.
            answered: called before the reply to a request that may have changed the agent.
            training: publishes a new revision when they have changed something.
        """
        self._agent = agent
        self._library = library
        self._topic = training
        offered: list[tuple[Any, str, Serve]] = [
            (srv.BeginTraining, names.BEGIN, self._begin),
            (srv.SetMode, names.SET_MODE, self._set_mode),
            (srv.EditExamples, names.EDIT_EXAMPLES, self._edit_examples),
            (srv.AnswerQuestion, names.ANSWER_QUESTION, self._answer_question),
            (srv.SaveBehavior, names.SAVE, self._save),
            (srv.Perform, names.PERFORM, self._perform),
            (srv.LoadLibrary, names.LOAD_LIBRARY, self._load_library),
            (srv.GetReport, names.GET_REPORT, self._get_report),
            (srv.SetCaution, names.SET_CAUTION, self._set_caution),
        ]
        for kind, name, serve in offered:
            node.create_service(kind, name, answering(self._with_revision(serve), answered))
        node.create_service(srv.GetVocabulary, names.GET_VOCABULARY, self._get_vocabulary)

    def _with_revision(self, serve: Serve) -> Serve:
        """Return a service function that replies with the training's revision."""

        def served(request: Any, response: Any) -> str:
            message = serve(request, response)
            if hasattr(response, "revision"):
                response.revision = self._topic.notice()
            return message

        return served

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
        agent, name, remedies = self._agent.name, session.curriculum.name, []
        saved = self._agent.loaded.files.get(name)
        if saved is not None and not request.resume:
            examples = quantity(len(saved.automaton.examples), "example")
            done.append(f'saving it will replace the "{name}" in the library, with {examples}')
            remedies.append(Fix.TRAIN_FURTHER(agent=agent, behavior=name))
        if not session.curriculum.features:
            done.append("no feature is chosen, so all situations look the same to it")
            remedies += [Fix.CHOOSE_FEATURES(agent=agent), Fix.VOCABULARY(agent=agent)]
        response.remedies = remedy_messages(remedies)
        return "; ".join(done)

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
                return self._perform_instead(response, None)
            case mode:
                known = (Mode.TESTING, Mode.TRAINING, Mode.IDLE)
                raise TrainingError(unknown("mode", mode, known))
        agent = self._agent
        done = f'{agent.name} is {agent.mode} "{agent.training}"'
        if agent.mode is Mode.TESTING and (open_ones := _open_questions(agent)):
            done += f"; it has {open_ones}"
            response.remedies = remedy_messages([Fix.QUESTIONS(agent=agent.name)])
        if agent.mode is Mode.TESTING and (remarks := agent.remarks(look=True)):
            done += "".join(f"; but {remark}" for remark in remarks)
            response.remedies += remedy_messages(remark.remedy for remark in remarks)
        saved = agent.loaded.files.get(agent.training)
        if saved is not None and agent.mode is Mode.TESTING and agent.session is not None:
            learned = agent.session.automaton()
            done = "; but ".join([done, *broken_expectations(saved.expectations, learned)])
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
        session, did = self._training(), ""
        edits = srv.EditExamples.Request
        match request.action:
            case _ if not session.begins(Request(request.client, request.request)):
                pass  # made by this agent's last process, which was killed before it answered
            case edits.UNDO:
                session.undo()
                did = f"undone: {session.log.history.undone[0]}; "
            case edits.REDO:
                session.redo()
                did = f"redone: {session.log.history.done[-1]}; "
            case edits.DELETE:
                session.delete(request.numbers)
            case edits.RELABEL:
                session.relabel(request.numbers, Term.parse(request.next_state))
                did = f"{session.log.history.done[-1]}; "
            case edits.RETIME:
                session.retime(request.numbers, request.ago)
            case edits.FEATURES:
                session.choose_features(list(map(Term.parse, request.features)))
            case action:
                raise TrainingError(f"there is no action {action}; see EditExamples.srv")
        count = quantity(len(session.log), "example")
        return f'{did}"{session.curriculum.name}" has {count}'

    def _answer_question(self, request: srv.AnswerQuestion.Request, response: Any) -> str:
        session = self._training()
        if session.begins(Request(request.client, request.request)):
            session.answer(request.number, request.choice, dismiss=request.dismiss)
        if request.dismiss:
            return f"question {request.number} is not asked again"
        done = session.log.history.done[-1] if session.log.history.done else "nothing"
        return f"question {request.number}: {done}"

    def _training(self) -> TrainingSession:
        session = self._agent.session
        if session is None:
            raise self._no_training(Fix.RESUME, Fix.TRAIN)
        return session

    def _no_training(self, *ways: Fix) -> TrainingError:
        agent = self._agent.name
        return TrainingError("it is not training anything", *(do(agent=agent) for do in ways))

    def _set_caution(self, request: srv.SetCaution.Request, response: Any) -> str:
        caution = Caution.parse(request.when_unsure, request.distance)
        self._agent.monitor.set(caution)
        return f"{self._agent.name}: {caution}"

    def _get_report(self, request: srv.GetReport.Request, response: Any) -> str:
        agent = self._agent
        name = request.automaton or agent.training
        if not name:
            raise self._no_training(Fix.EXAMPLES_OF)
        known = training_costs(agent.journal)
        costs = [cost for cost in known if cost.automaton == name]
        if not costs and name == agent.training:
            raise TrainingError(
                f'nothing was done yet in the training of "{name}"',
                Fix.DEMONSTRATE(agent=agent.name),
            )
        if not costs:
            raise TrainingError(
                f'{agent.name} has no record of a training of "{name}" '
                f"{has([cost.automaton for cost in known], name)}; ask the agent that was trained"
            )
        response.costs = [cost_message(cost) for cost in costs]
        return quantity(len(costs), "training")

    def _save(self, request: srv.SaveBehavior.Request, response: Any) -> str:
        bindings, agent = bindings_of(request), self._agent
        performed = agent.behavior if agent.mode is Mode.PERFORMING else ""
        open_ones, remarks = _open_questions(agent), agent.remarks(look=True)
        automaton, path, trimmed, replaced = self._agent.save(
            request.name, bindings, request.description, keep_unused=request.keep_unused
        )
        response.path = str(path)
        response.digest = self._agent.loaded.files[automaton.name].checksum
        response.trimmed = trimmed
        response.replaced = replaced
        saved = Term(automaton.name, automaton.parameters)
        done = f'saved "{saved}" with {quantity(len(automaton.examples), "example")}'
        done += f"; {replaced}" if replaced else ""
        done += f"; it had {open_ones}" if open_ones else ""
        done += "".join(f"; but {remark}" for remark in remarks)
        if open_ones or remarks:
            further = Fix.TRAIN_FURTHER(agent=agent.name, behavior=automaton.name)
            response.remedies = remedy_messages([further, *(r.remedy for r in remarks)])
        done = "; but ".join([done, *agent.loaded.files[automaton.name].broken])
        if performed and self._agent.mode is Mode.IDLE:
            done += f'; {self._agent.name} is idle now: it can no longer perform "{performed}"'
        return done

    def _perform(self, request: srv.Perform.Request, response: Any) -> str:
        term = term_of(request.behavior, request.arguments) if request.behavior else None
        return self._perform_instead(response, term)

    def _perform_instead(self, response: Any, term: Term | None) -> str:
        """Make the agent perform a behavior; report what becomes of a training under way."""
        agent = self._agent
        agent.perform(term)
        done = f"{agent.name} performs {term or 'nothing'}"
        if agent.session is None:
            return done
        response.remedies = remedy_messages([Fix.RESUME(agent=agent.name)])
        examples = quantity(agent.unsaved, "example")
        return f'{done}; the training of "{agent.training}" ({examples}) is kept'

    def _load_library(self, request: srv.LoadLibrary.Request, response: Any) -> str:
        library = None
        if request.path:
            folder = Path(os.path.expanduser(request.path))
            if not folder.is_absolute() or not folder.is_dir():
                raise LibraryError(
                    f'"{request.path}" is not a folder here; give the absolute path of a library'
                )
            if any(folder.iterdir()) and not any(folder.glob(f"*{BEHAVIOR_SUFFIX}")):
                raise LibraryError(
                    f"{folder} contains files but no behaviors (*{BEHAVIOR_SUFFIX}); give "
                    "the path of a library, or of an empty folder for a new one"
                )
            library = self._library(folder, self._agent.domain)
        response.behaviors = self._agent.reload(library)
        response.digest = self._agent.loaded.digest
        broken = [text for file in self._agent.loaded.files.values() for text in file.broken]
        return "; but ".join([quantity(len(response.behaviors), "trained behavior"), *broken])

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
                name=str(Term(b.name, b.parameters)),
                description="; ".join([b.description, *map(str, domain.numbers_of(Term(b.name)))]),
                trained=b.name in agent.loaded.files,
                one_shot=isinstance(b, BasicBehavior) and b.one_shot,
                numbers=number_messages(domain.numbers_of(Term(b.name))),
            )
            for b in behaviors
        ]
        words = [(Term(f.name, f.parameters), f) for f in features]
        words += [
            (term, domain.feature(term.name)) for term in OWN_FEATURES if term.name not in FLAGS
        ]
        response.features = [feature_message(term, feature) for term, feature in words]
        response.targets = sorted(domain.targets)
        return response


def bindings_of(request: Any) -> dict[str, str]:
    """Return the new names of targets and parameters that a request asks for.

    Raises:
        TrainingError: if there are not as many new names as old ones.
    """
    if len(request.bind_from) != len(request.bind_to):
        raise TrainingError(
            f"bind_from has {quantity(len(request.bind_from), 'name')}, "
            f"bind_to {len(request.bind_to)}"
        )
    return dict(zip(request.bind_from, request.bind_to, strict=True))


def _open_questions(agent: Agent) -> str:
    """Return how many questions about a training are open, as far as known; empty if none."""
    session = agent.session
    known = session.questions.known() if session is not None else []
    if not known:
        return ""
    text = quantity(len(known), "open question")
    if clashes := sum(question.kind == msg.Question.CONTRADICTION for question in known):
        text += f", {clashes} of contradicting commands, where it decides by chance"
    return text
