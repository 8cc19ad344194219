from .cost import TrainingCost as TrainingCost
from .curriculum import Curriculum as Curriculum
from .questions import Question as Question
from .training_session import TrainingSession as TrainingSession
