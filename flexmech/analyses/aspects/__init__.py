"""What several analyses report about one thing: a motor, the force that shakes the frame."""
