"""The services in which an agent asks its demonstrator, and is answered.

Looking for questions can take most of a second, in which an agent must not miss its cycles. So the
search is done in slices, and the reply is sent when it is over.
"""

from __future__ import annotations

from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.slices import Job, Slices
from hitab_core import Agent, Do, TrainingError, quantity
from hitab_core.training import Question, TrainingSession
from hitab_ros import GuardedNode, names
from hitab_ros.answering import Answered, answering, refuse


class QuestionServices:
    """Offers the services; a refusal is a reply with ``success`` false and the reason."""

    def __init__(
        self, node: GuardedNode, agent: Agent, answered: Answered, slices: Slices
    ) -> None:
        """Offer the services.

        Args:
            node: to offer them on.
            agent: that asks.
            answered: called before a reply.
            slices: do the search.
        """
        self._agent = agent
        self._answered = answered
        self._slices = slices
        self._begun: Any = None
        service = node.create_service(srv.ListQuestions, names.LIST_QUESTIONS, self._begin)
        self._send = service.send_response
        # The executor sends what a callback returns at once; this keeps it until it is complete.
        service.send_response = self._keep
        node.create_service(
            srv.AnswerQuestion, names.ANSWER_QUESTION, answering(self._answer, answered)
        )

    @property
    def _session(self) -> TrainingSession:
        session, name = self._agent.session, self._agent.name
        if session is None:
            raise TrainingError(
                "it is not training anything", Do.RESUME(agent=name), Do.TRAIN(agent=name)
            )
        return session

    def _begin(self, request: srv.ListQuestions.Request, response: Any) -> Any:
        """Check that there is a training, and have the reply wait for the search."""
        assert self._session is not None
        self._begun = response
        return response

    def _keep(self, response: Any, header: Any) -> None:
        begun, self._begun = self._begun, None
        if response is begun:
            self._slices.do(self._search(response, header))
        else:
            self._send(response, header)  # a refusal

    def _search(self, response: Any, header: Any) -> Job:
        """Look for questions until the examples no longer change meanwhile, then reply."""
        why: Exception | None = None
        try:
            while True:
                session, examples = self._session, self._session.examples
                for _ in session.search():
                    yield None
                if session is self._agent.session and examples is session.examples:
                    break
            response.questions = [question_message(q, session) for q in session.questions()]
            response.answered = session.asked.answered
            response.message = quantity(len(response.questions), "question")
            response.success = True
        except Exception as error:
            why = error
            refuse(response, error)
        self._answered(why)
        self._send(response, header)

    def _answer(self, request: srv.AnswerQuestion.Request, response: Any) -> str:
        session = self._session
        question = session.answer(request.number, request.choice, dismiss=request.dismiss)
        if request.dismiss:
            return f"question {question.number} is not asked again"
        done = session.log.history.done[-1] if session.log.history.done else "nothing"
        return f"question {question.number}: {done}"


def question_message(question: Question, session: TrainingSession) -> msg.Question:
    """Return a question as a message."""
    features = [str(use) for use in session.curriculum.features]
    return msg.Question(
        number=question.number,
        kind=question.kind.value,
        text=question.text,
        state=question.state,
        examples=list(question.examples),
        choices=[choice.name for choice in question.choices],
        effects=[choice.effect for choice in question.choices],
        proposed=0,
        features=features if question.situation else [],
        situation=list(question.situation),
    )
