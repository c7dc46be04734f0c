"""Constants of the telemanipulator's position servos, shared by its gate and the checks of its sensors."""

SERVO_N_M = 1000.0
"""Stiffness of a finger's position servo, N/m: force per distance of the set-point below the finger."""
LONGEST_TICK_S = 0.010
"""Maximum time that one report of the servos counts for after a pause of the loop, s."""
