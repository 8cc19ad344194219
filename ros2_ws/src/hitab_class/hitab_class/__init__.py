"""A class with HiTAB: exercises, grading, and expectations that behaviors carry."""
