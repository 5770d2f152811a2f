"""The system under test: light filter, landmark detection, association, EKF-SLAM, mapping, A*.

This room knows pictures, odometry and its own calibration. It imports none of the other rooms,
so ground truth cannot leak into it.
"""
