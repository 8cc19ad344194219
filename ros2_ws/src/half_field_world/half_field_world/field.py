"""Lines and marks of the field, m: rcssserver's, halved. The goal is on the right."""

LENGTH, WIDTH = 52.5, 68.0
GOAL_X = LENGTH / 2.0
GOAL_WIDTH = 14.02
POST_RADIUS = 0.06  # radius of a goal post
AREA_LENGTH, AREA_WIDTH = 16.5, 40.32  # of the penalty area, in which the goalie may catch
CATCHABLE = 1.2  # largest distance from the goalie's center to the ball's for a catch


def in_area(x: float, y: float) -> bool:
    """Whether a place is in the penalty area."""
    return GOAL_X - AREA_LENGTH <= x <= GOAL_X and abs(y) <= AREA_WIDTH / 2.0
