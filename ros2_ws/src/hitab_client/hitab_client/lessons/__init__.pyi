from .conditions import Condition as Condition
from .lesson import read_lesson as read_lesson
from .lesson_player import LessonPlayer as LessonPlayer
from .lesson_player import LessonReport as LessonReport
