"""Common aspects of several analyses: a motor, the force that shakes the frame."""
