from . import operation as operation
from .curriculum import Curriculum as Curriculum
from .trainer import Trainer as Trainer
from .training_journal import TrainingJournal as TrainingJournal
