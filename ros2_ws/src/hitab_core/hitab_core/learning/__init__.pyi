from . import tree_text as tree_text
from .classifier_spec import ClassifierSpec as ClassifierSpec
from .transition_learning import TREE as TREE
from .transition_learning import learn_transitions as learn_transitions
from .transition_learning import relearned as relearned
from .tree_nodes import Leaf as Leaf
from .tree_nodes import Node as Node
