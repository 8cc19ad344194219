from .curriculum import Curriculum as Curriculum
from .trainer import Trainer as Trainer
from .training_journal import JOURNAL_FILE as JOURNAL_FILE
from .training_journal import TrainingJournal as TrainingJournal
