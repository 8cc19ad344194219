"""Links: to the world, the robot and the commander."""
