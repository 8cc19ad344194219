"""Hierarchical training of agent behaviors, without ROS.

The names below are the public interface. They are loaded when they are first used, so that a
program that needs one of them does not wait for all.

    LearningAgent             an agent to train step by step, from a notebook or a script
    plain_domain              a domain made of plain functions
    Domain, BasicBehavior,    actions and percepts of a robot; one domain per kind of robot
    Feature, FeatureKind,
    Target, load_domain
    ActionBehavior,           a basic behavior that the server of a ROS action carries out, and
    feedback_feature          a feature that is a field of its feedback
    Agent, Mode               the engine of an agent, as a ROS node or a simulation runs it
    Automaton, Term, Example  learned machines, and their training data
    BehaviorLibrary           trained behaviors in a folder
    TransitionTree            learns the decisions of one state from examples
    TransitionTreeClassifier  the same as a scikit-learn classifier
    automaton_as_text,        automata as text and as pictures
    draw_automata
    HitabError                base of all errors that a user can mend
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
