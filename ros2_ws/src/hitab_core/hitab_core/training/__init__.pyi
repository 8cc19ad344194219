from .cost import TrainingCost as TrainingCost
from .curriculum import Curriculum as Curriculum
from .question import Question as Question
from .training_journal import TrainingJournal as TrainingJournal
from .training_session import TrainingSession as TrainingSession
