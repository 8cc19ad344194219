"""The HiTAB engine: automata, learning, training sessions and the library, without ROS."""
