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

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
