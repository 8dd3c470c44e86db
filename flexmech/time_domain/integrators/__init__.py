"""Time integration of the equations of motion by the trapezoidal rule and Lobatto's method."""
