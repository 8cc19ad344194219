from .feature_cache import FeatureCache as FeatureCache
from .feature_cache import checks_of as checks_of
from .live_features import live_features as live_features
from .observing import Change as Change
from .running_automaton import Clock as Clock
from .running_automaton import RunContext as RunContext
from .running_automaton import Running as Running
from .running_automaton import RunningAutomaton as RunningAutomaton
