from .curriculum import Curriculum as Curriculum
from .training_session import TrainingSession as TrainingSession
