"""What a forager perceives in a cycle, as a flat list of floats.

====================  =====================================================================
index                 value
====================  =====================================================================
0                     own number, from 1
1, 2, 3               own position, m, and heading, rad: foragers know where they are
4                     number of the box that is held, from 1; 0: none
5                     size of that box: 0 none, 1 small, 2 large
6                     how many robots hold it
7                     how long it has not moved since it was gripped, s; 0 if none is held
8                     how long ago it last let go of a box by itself, s; FAR if never
9                     how far it can reach, m
10 and so on          places: distance, m, direction relative to the body, rad, box number
====================  =====================================================================

The places are, in this order: home (its centre), the closest box, the closest small one, the
closest large one, the closest one that other robots hold, the box that the own squad holds (with
most hands), the large box that the own company holds, the middle of the own squad, and the
closest obstacle or wall. Distances to boxes, obstacles and walls are from edge to edge and never
negative. What is not seen, or is not there, is FAR away, straight ahead; but an obstacle that is
not seen is straight behind, where it is in nobody's way.

Boxes and obstacles are seen within a range; what a squad or company knows is told by radio and
known everywhere. The direction is counter-clockwise, on [-pi, pi].
"""

FAR = 1000.0

NUMBER, X, Y, HEADING, HELD, HELD_SIZE, HANDS, WAITED, RESTED, REACH = range(10)
(
    HOME,
    BOX,
    SMALL_BOX,
    LARGE_BOX,
    ATTACHED_BOX,
    SQUAD_BOX,
    COMPANY_BOX,
    SQUAD_CENTRE,
    OBSTACLE,
) = range(10, 37, 3)
LENGTH = 37
SMALL, LARGE = 1.0, 2.0
