from .cost import TrainingCost as TrainingCost
from .cost import training_costs as training_costs
from .cost import unsaved_cost as unsaved_cost
from .question import Question as Question
