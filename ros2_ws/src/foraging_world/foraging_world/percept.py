"""A forager's percept of a cycle, as a flat list of floats.

====================  =====================================================================
index                 value
====================  =====================================================================
0                     own number, from 1
1, 2, 3               own position, m, and heading, rad: foragers are localized
4                     number of the held box, from 1; 0 if none
5                     size of that box: 0 none, 1 small, 2 large
6                     how many robots hold that box
7                     time for which the held box has not moved, s; 0 if none is held
8                     time since the forager last let go of a box by itself, s; FAR if never
9                     reach of the forager, m; -1 if it cannot grip
10 and so on          places: distance, m, direction relative to the body, rad, box number
====================  =====================================================================

The places are, in this order: home (its center), the closest box, the closest small one, the
closest large one, the closest one that other robots hold, the box that most of the own squad hold,
the large box that most of the own company hold, the middle of the own squad, the closest obstacle
or wall, the first scout of the own squad, and the box closest to one of its scouts, in their
sight, that no member of the squad holds. Distances to boxes, obstacles and walls are from edge to
edge and never negative. A thing that is not seen, or does not exist, is FAR away, straight ahead;
but an obstacle that is not seen is straight behind, where it is in no forager's way.

Boxes and obstacles are seen within a range; what a squad or company knows is shared by radio
everywhere. The direction is counter-clockwise, on [-pi, pi].
"""

NOT_SEEN_M = 1000.0

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
    SCOUT,
    SCOUTED_BOX,
) = range(10, 43, 3)
PERCEPT_LENGTH = 43
SMALL, LARGE = 1.0, 2.0
