"""Driving in closed loop: the true world, the robot in it, and how it fared."""
